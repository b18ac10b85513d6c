//! Slaves with a fault in their frame count memory.

use super::*;

pub static SLAVES: &[FaultySlave] = &[
    slave("count.new", "takes every counted request for a repetition", Counts(Counting::IgnoresBit)),
    slave("count.uncounted", "takes an uncounted request for a repetition", Counts(Counting::CountsUncounted)),
    slave("count.station", "remembers a bit for each access point", Counts(Counting::PerAccessPoint)),
    slave("count.repetition", "has no frame count handling", Counts(Counting::None)),
    slave("count.answer", "reads anew for a repetition", Counts(Counting::ReadsAnew)),
    slave("count.refusal", "does not keep RS for a repetition", Counts(Counting::ForgetsRefusals)),
    slave("count.exchange", "executes a repeated Data_Exchange", Counts(Counting::ExchangesAnew)),
    slave("count.other-master", "does not remember the master", Counts(Counting::IgnoresSource)),
    slave("count.fdl-status", "remembers the bit of FDL status", Counts(Counting::CountsFdlStatus)),
    slave("count.global-control", "remembers the bit of Global_Control", Counts(Counting::CountsGlobalControl)),
    slave("count.damaged", "remembers the bit of a damaged telegram", Counts(Counting::CountsDamaged)),
];
