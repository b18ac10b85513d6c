//! Code tables of tira36e1 that are its own. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::table::{BPG_SWITCHOVER, INSTANCES};
use crate::model::{Code, Codes, Precondition, code};
use crate::profile::codes::risky;

/// 3.2.1.1
pub const ADJUST: Codes = Codes::Commands(&[
    code(0, "inactive"),
    Code {
        number: 1,
        name: "full-scale-adjust",
        preconditions: &[Precondition::Executing],
        risk: "adjusts the Pirani: the chamber must be at atmospheric pressure",
    },
]);

/// 3.2.1.3
pub const SELECTOR: Codes = Codes::Range(*INSTANCES.start() as i64, *INSTANCES.end() as i64);

/// 3.3.3.5, with the codes of (97): 0 switches off, 1 switches on.
pub const EMISSION_STATUS: Codes = Codes::Names(&[
    risky(0, "off", "the ionisation part measures nothing without emission"),
    Code {
        number: 1,
        name: "on",
        preconditions: &[Precondition::Executing],
        risk: "switches the hot cathode: at a pressure that is too high this costs its life",
    },
    code(2, "on-high"),
    code(3, "degas"),
]);

/// 3.3.3.8
pub const HOT_CATHODE_COMMAND: Codes = Codes::Commands(&[
    code(0x0000, "inactive"),
    code(0x0100, "degas-off"),
    Code {
        number: 0x0101,
        name: "degas-on",
        preconditions: &[
            Precondition::Executing,
            Precondition::EmissionOn,
            Precondition::PressureBelow(None, BPG_SWITCHOVER.emission.degas_pa),
        ],
        risk: "heats the electrodes for three minutes: gas is set free, and the pressure rises",
    },
]);

/// 3.3.3.7 (99)
pub const DEGAS_STATUS: Codes = Codes::Names(&[code(0, "off"), code(3, "on")]);
