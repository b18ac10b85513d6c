//! The faulty slaves, one for each rule, in the order of the rules.

use super::counting::Counting;
use super::damaged;
use super::faulty::{
    CHK_CFG, FDL_STATUS, Fault, Frame, GET_CFG, GLOBAL_CONTROL, MANAGER, MS1, RD_INP, RD_OUTP, RR, RS, SET_PRM,
    SET_SLAVE_ADD, SLAVE_DIAG, UE, is_exchanging, is_rs, is_waiting, leave, request, sc, status,
};
use super::slave::{ADDRESS, CFG, IDENT, MASTER};
use Fault::{Answers, Counts, Hears, Reacts, Says};
use profivac_conform::probe::Received;
use profivac_dp::slave::SlaveState;

/// A slave with one fault.
pub struct FaultySlave {
    /// The rule that it breaks.
    pub rule: &'static str,
    /// What it does, as a sentence without its subject.
    pub does: &'static str,
    pub fault: Fault,
}

const fn slave(rule: &'static str, does: &'static str, fault: Fault) -> FaultySlave {
    FaultySlave { rule, does, fault }
}

/// Octets of a diagnosis.
const ONE: usize = 0;
const TWO: usize = 1;
const THREE: usize = 2;
const OWNER: usize = 3;

/// Bits of the first octet of Set_Prm.
const LOCK: u8 = 0x80;
const UNLOCK: u8 = 0x40;
const WD_ON: u8 = 0x08;

fn is_prm(request: &Frame) -> bool {
    request.dsap == SET_PRM && request.du.len() >= 7
}

fn has_ident(request: &Frame) -> bool {
    request.du.get(4..6) == Some(&IDENT.to_be_bytes())
}

/// Set_Prm with Lock_Req and the right ident number.
fn is_valid_prm(request: &Frame) -> bool {
    is_prm(request) && request.du[0] & (LOCK | UNLOCK) == LOCK && has_ident(request)
}

/// Set_Prm with Lock_Req and another ident number.
fn is_faulty_prm(request: &Frame) -> bool {
    is_prm(request) && request.du[0] & (LOCK | UNLOCK) == LOCK && !has_ident(request)
}

fn is_unlock(request: &Frame) -> bool {
    is_prm(request) && request.du[0] & UNLOCK != 0
}

/// Chk_Cfg with a truncated identifier.
fn is_truncated_cfg(request: &Frame) -> bool {
    request.dsap == CHK_CFG && request.du.last() == Some(&0xC0)
}

/// A diagnosis, which `change` alters.
fn diagnosis(request: &Frame, answer: &mut Frame, change: impl FnOnce(&mut [u8])) {
    if request.dsap == SLAVE_DIAG && answer.du.len() >= 6 {
        change(&mut answer.du);
    }
}

/// A Set_Prm and a wait for the watchdog: factors of the last one, in ms, and when it began.
#[derive(Clone, Copy, Default)]
struct Watch {
    period_ms: u64,
    begun_ms: u64,
}

/// All faulty slaves.
pub static FAULTY_SLAVES: &[FaultySlave] = &[
    slave(
        "layer2.fdl-status",
        "refuses FDL status with RS",
        Says(|request, answer| {
            if request.function() == FDL_STATUS {
                answer.fc = RS;
            }
        }),
    ),
    slave(
        "layer2.station-type",
        "says that it is a master",
        Says(|request, answer| {
            if request.function() == FDL_STATUS {
                answer.fc = 0x20;
            }
        }),
    ),
    slave(
        "layer2.addresses",
        "sends the addresses as it received them",
        Says(|request, answer| {
            (answer.da, answer.sa) = (request.da, request.sa);
        }),
    ),
    slave("count.first", "takes a first request for a repetition", Counts(Counting::CountsFirst)),
    slave(
        "diagnosis.answer",
        "sends a diagnosis of five octets",
        Says(|request, answer| {
            if request.dsap == SLAVE_DIAG {
                answer.du.truncate(5);
            }
        }),
    ),
    slave(
        "layer2.access-points",
        "sends the access points as it received them",
        Says(|request, answer| {
            if answer.dsap.is_some() {
                (answer.dsap, answer.ssap) = (request.dsap, request.ssap);
            }
        }),
    ),
    slave(
        "layer2.low-priority",
        "ignores Slave_Diag of low priority",
        Answers(
            |_, request, answer| {
                if request.dsap == SLAVE_DIAG && request.function() == 0xC { Received::Nothing } else { answer }
            },
        ),
    ),
    slave(
        "layer2.sd3",
        "ignores SD3",
        Reacts(|| Box::new(|line, octets| if octets[0] == 0xA2 { Received::Nothing } else { line.hear(octets) })),
    ),
    slave(
        "layer2.closed",
        "acknowledges requests to any access point",
        Answers(|_, request, answer| if request.dsap == Some(52) && is_rs(&answer) { sc() } else { answer }),
    ),
    slave(
        "layer2.other-station",
        "answers requests to the address of the master",
        Hears(|request| {
            if request.da == MASTER {
                request.da = ADDRESS;
            }
        }),
    ),
    slave(
        "layer2.broadcast",
        "answers broadcast requests",
        Hears(|request| {
            if request.da == 127 && matches!(request.function(), FDL_STATUS | 0xD) {
                request.da = ADDRESS;
            }
        }),
    ),
    slave(
        "layer2.own-source",
        "answers requests from its own address",
        Hears(|request| {
            if request.sa == ADDRESS {
                request.sa = 1;
            }
        }),
    ),
    slave(
        "layer2.broadcast-source",
        "answers requests from address 127",
        Hears(|request| {
            if request.sa == 127 {
                request.sa = 1;
            }
        }),
    ),
    slave(
        "layer2.token",
        "acknowledges a token",
        Reacts(|| Box::new(|line, octets| if octets[0] == 0xDC { sc() } else { line.hear(octets) })),
    ),
    slave(
        "layer2.short-ack",
        "acknowledges SC",
        Reacts(|| Box::new(|line, octets| if octets == [0xE5] { sc() } else { line.hear(octets) })),
    ),
    slave(
        "layer2.response",
        "acknowledges a response",
        Answers(|_, request, answer| if request.fc & 0x40 == 0 { sc() } else { answer }),
    ),
    slave(
        "damage.start-delimiter",
        "ignores bit 2 of the first octet",
        Reacts(|| damaged::repaired(|octets| octets[0] = if octets[0] == 0x14 { 0x10 } else { octets[0] & !0x04 })),
    ),
    slave(
        "damage.length",
        "does not compare LE with LEr",
        Reacts(|| {
            damaged::repaired(|octets| {
                if octets.len() > 6 {
                    octets[1] = octets.len() as u8 - 6;
                    octets[2] = octets[1];
                }
            })
        }),
    ),
    slave(
        "damage.second-start",
        "does not look at the second 68",
        Reacts(|| {
            damaged::repaired(|octets| {
                if octets.len() > 6 {
                    octets[3] = 0x68;
                }
            })
        }),
    ),
    slave(
        "damage.check-octet",
        "does not check the check octet",
        Reacts(|| {
            damaged::repaired(|octets| {
                let end = octets.len() - 2;
                let first = if octets[0] == 0x68 { 4 } else { 1 };
                if end > first {
                    octets[end] = octets[first..end].iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
                }
            })
        }),
    ),
    slave(
        "damage.end-delimiter",
        "does not look at the end delimiter",
        Reacts(|| damaged::repaired(|octets| *octets.last_mut().unwrap() = 0x16)),
    ),
    slave(
        "damage.cut-off",
        "acknowledges the beginning of a telegram",
        Reacts(|| {
            Box::new(|line, octets| if octets.len() == 6 && octets[0] == 0x68 { sc() } else { line.hear(octets) })
        }),
    ),
    slave("damage.next", "is deaf to one telegram after the beginning of another one", Reacts(damaged::deaf)),
    slave(
        "diagnosis.fixed-bit",
        "sends 0 in the bit that is always 1",
        Says(|request, answer| {
            diagnosis(request, answer, |du| du[TWO] &= !0x04);
        }),
    ),
    slave(
        "diagnosis.master-bits",
        "sets Master_Lock",
        Says(|request, answer| {
            diagnosis(request, answer, |du| du[ONE] |= 0x80);
        }),
    ),
    slave(
        "diagnosis.reserved-bits",
        "sets a reserved bit of the diagnosis",
        Says(|request, answer| {
            diagnosis(request, answer, |du| du[THREE] |= 0x01);
        }),
    ),
    slave(
        "diagnosis.ident",
        "sends another ident number once it has parameters",
        Says(|request, answer| {
            diagnosis(request, answer, |du| du[5] ^= u8::from(du[OWNER] != 0xFF));
        }),
    ),
    slave(
        "diagnosis.blocks",
        "sends a block that is longer than the diagnosis",
        Says(|request, answer| {
            if request.dsap == SLAVE_DIAG && answer.du.len() >= 6 {
                answer.du.push(0x45);
            }
        }),
    ),
    slave(
        "diagnosis.any-master",
        "refuses the diagnosis to a second master",
        Answers(|_, request, answer| {
            if request.dsap == SLAVE_DIAG && request.sa != MASTER && answer != Received::Nothing {
                status(request, RS)
            } else {
                answer
            }
        }),
    ),
    slave(
        "get-cfg.identifiers",
        "sends a truncated configuration",
        Says(|request, answer| {
            if request.dsap == GET_CFG && answer.fc == 8 {
                answer.du.push(0xC0);
            }
        }),
    ),
    slave(
        "get-cfg.any-master",
        "refuses the configuration to a second master",
        Answers(
            |_, request, answer| {
                if request.dsap == GET_CFG && request.sa != MASTER { status(request, RS) } else { answer }
            },
        ),
    ),
    slave(
        "get-cfg.no-open-format",
        "sends an identifier with 15 manufacturer octets",
        Says(|request, answer| {
            if request.dsap == GET_CFG && answer.fc == 8 {
                answer.du = vec![0x4F, 0x81, 0x21];
            }
        }),
    ),
    slave(
        "start-up.set-prm",
        "answers Set_Prm with UE",
        Answers(|_, request, answer| if is_valid_prm(request) { status(request, UE) } else { answer }),
    ),
    slave(
        "start-up.chk-cfg",
        "answers Chk_Cfg with UE",
        Answers(
            |_, request, answer| {
                if request.dsap == CHK_CFG && request.du == CFG { status(request, UE) } else { answer }
            },
        ),
    ),
    slave(
        "start-up.exchange",
        "never gets ready",
        Reacts(|| {
            Box::new(|line, octets| match Frame::parse(octets) {
                Some(request) if request.dsap == CHK_CFG => sc(),
                _ => line.hear(octets),
            })
        }),
    ),
    slave(
        "start-up.unlock",
        "ignores Unlock_Req",
        Reacts(|| {
            Box::new(|line, octets| match Frame::parse(octets) {
                Some(request) if is_unlock(&request) => sc(),
                _ => line.hear(octets),
            })
        }),
    ),
    slave(
        "start-up.refused",
        "is silent when it does not exchange data",
        Answers(|_, request, answer| if request.is_exchange() && is_rs(&answer) { Received::Nothing } else { answer }),
    ),
    slave(
        "start-up.no-owner",
        "keeps Diag_Master_Add without an owner",
        Says(|request, answer| {
            diagnosis(request, answer, |du| {
                if du[OWNER] == 0xFF {
                    du[OWNER] = MASTER;
                }
            });
        }),
    ),
    slave(
        "start-up.prm-req",
        "waits for parameters without Prm_Req",
        Says(|request, answer| {
            diagnosis(request, answer, |du| {
                if du[OWNER] == 0xFF {
                    du[TWO] &= !0x01;
                }
            });
        }),
    ),
    slave(
        "start-up.not-ready",
        "waits for parameters without Station_Not_Ready",
        Says(|request, answer| {
            diagnosis(request, answer, |du| {
                if du[OWNER] == 0xFF {
                    du[ONE] &= !0x02;
                }
            });
        }),
    ),
    slave(
        "start-up.owner",
        "reports another master as its owner",
        Says(|request, answer| {
            diagnosis(request, answer, |du| {
                if du[OWNER] == MASTER {
                    du[OWNER] = 1;
                }
            });
        }),
    ),
    slave(
        "start-up.parameterised",
        "keeps Prm_Req after Set_Prm",
        Says(|request, answer| {
            diagnosis(request, answer, |du| {
                if du[OWNER] != 0xFF {
                    du[TWO] |= 0x01;
                }
            });
        }),
    ),
    slave(
        "start-up.waits-for-cfg",
        "says that it is ready before Chk_Cfg",
        Says(|request, answer| {
            diagnosis(request, answer, |du| {
                if du[OWNER] != 0xFF {
                    du[ONE] &= !0x02;
                }
            });
        }),
    ),
    slave(
        "start-up.before-cfg",
        "exchanges data before Chk_Cfg",
        Answers(|slave, request, answer| {
            let waits = matches!(slave.state(), SlaveState::WaitCfg(owner) if owner.master == request.sa);
            if request.is_exchange() && waits { sc() } else { answer }
        }),
    ),
    slave(
        "start-up.ready",
        "says that it is not ready during data exchange",
        Says(|request, answer| {
            diagnosis(request, answer, |du| {
                if du[OWNER] != 0xFF {
                    du[ONE] |= 0x02;
                }
            });
        }),
    ),
    slave(
        "start-up.cfg-before-prm",
        "begins data exchange with Chk_Cfg alone",
        Reacts(|| {
            Box::new(|line, octets| {
                let request_cfg = Frame::parse(octets).filter(|request| request.dsap == CHK_CFG && request.du == CFG);
                if let Some(cfg) = request_cfg
                    && is_waiting(&line.slave)
                {
                    let [high, low] = IDENT.to_be_bytes();
                    line.hear(&request(cfg.sa, 61, &[LOCK, 0, 0, 11, high, low, 0, 0x80, 0, 0]));
                    return line.hear(&request(cfg.sa, 62, &CFG));
                }
                line.hear(octets)
            })
        }),
    ),
    slave(
        "start-up.no-lock",
        "takes Set_Prm without Lock_Req for one with it",
        Hears(|request| {
            if is_prm(request) && request.du[0] & (LOCK | UNLOCK) == 0 {
                request.du[0] |= LOCK;
            }
        }),
    ),
    slave(
        "start-up.both-locks",
        "ignores Unlock_Req beside Lock_Req",
        Hears(|request| {
            if is_prm(request) && request.du[0] & LOCK != 0 {
                request.du[0] &= !UNLOCK;
            }
        }),
    ),
    slave(
        "start-up.wrong-ident",
        "does not look at the ident number of Set_Prm",
        Hears(|request| {
            if is_prm(request) {
                request.du[4..6].copy_from_slice(&IDENT.to_be_bytes());
            }
        }),
    ),
    slave(
        "start-up.prm-fault",
        "never says Prm_Fault",
        Says(|request, answer| {
            diagnosis(request, answer, |du| du[ONE] &= !0x40);
        }),
    ),
    slave(
        "start-up.prm-fault-acknowledged",
        "answers a faulty Set_Prm with UE",
        Answers(|_, request, answer| if is_faulty_prm(request) { status(request, UE) } else { answer }),
    ),
    slave("start-up.prm-fault-ended", "keeps Prm_Fault until it is released", Reacts(|| latched(is_faulty_prm, 0x40))),
    slave(
        "start-up.short-prm",
        "ignores a Set_Prm of six octets",
        Reacts(|| {
            Box::new(|line, octets| match Frame::parse(octets) {
                Some(request) if request.dsap == SET_PRM && request.du.len() < 7 => sc(),
                _ => line.hear(octets),
            })
        }),
    ),
    slave(
        "start-up.truncated-cfg",
        "ignores a truncated identifier",
        Hears(|request| {
            if is_truncated_cfg(request) {
                request.du.pop();
            }
        }),
    ),
    slave(
        "start-up.other-cfg",
        "compares the first identifiers only",
        Hears(|request| {
            if request.dsap == CHK_CFG && request.du.starts_with(&CFG) && !is_truncated_cfg(request) {
                request.du.truncate(CFG.len());
            }
        }),
    ),
    slave(
        "start-up.cfg-fault",
        "never says Cfg_Fault",
        Says(|request, answer| {
            diagnosis(request, answer, |du| du[ONE] &= !0x04);
        }),
    ),
    slave(
        "start-up.cfg-fault-acknowledged",
        "answers a faulty Chk_Cfg with UE",
        Answers(|_, request, answer| if is_truncated_cfg(request) { status(request, UE) } else { answer }),
    ),
    slave(
        "start-up.cfg-fault-ended",
        "keeps Cfg_Fault until it is released",
        Reacts(|| latched(is_truncated_cfg, 0x04)),
    ),
    slave(
        "start-up.cfg-again",
        "leaves data exchange with the same Chk_Cfg",
        Reacts(|| ends_exchange(|request| request.dsap == CHK_CFG && request.du == CFG)),
    ),
    slave("start-up.prm-again", "ignores Set_Prm during data exchange", Reacts(|| ignores_in_exchange(is_valid_prm))),
    slave(
        "start-up.faulty-prm-ends",
        "ignores a faulty Set_Prm during data exchange",
        Reacts(|| ignores_in_exchange(is_faulty_prm)),
    ),
    slave(
        "start-up.faulty-cfg-ends",
        "ignores a faulty Chk_Cfg during data exchange",
        Reacts(|| ignores_in_exchange(is_truncated_cfg)),
    ),
    slave(
        "exchange.inputs",
        "sends an octet of inputs too few",
        Says(|request, answer| {
            if request.is_exchange() {
                answer.du.pop();
            }
        }),
    ),
    slave(
        "exchange.wrong-length",
        "ignores surplus outputs",
        Hears(|request| {
            if request.is_exchange() {
                request.du.truncate(2);
            }
        }),
    ),
    slave(
        "exchange.diagnosis-flag",
        "announces a diagnosis for ever",
        Says(|request, answer| {
            if request.is_exchange() && answer.fc == 8 {
                answer.fc = 0x0A;
            }
        }),
    ),
    slave(
        "exchange.fdl-status",
        "ignores FDL status during data exchange",
        Answers(
            |slave, request, answer| {
                if request.function() == FDL_STATUS && is_exchanging(slave) { Received::Nothing } else { answer }
            },
        ),
    ),
    slave(
        "exchange.undisturbed",
        "leaves data exchange with Get_Cfg",
        Reacts(|| ends_exchange(|request| request.dsap == GET_CFG)),
    ),
    slave(
        "exchange.set-slave-add",
        "acknowledges Set_Slave_Add at any time",
        Answers(|_, request, answer| if request.dsap == SET_SLAVE_ADD && is_rs(&answer) { sc() } else { answer }),
    ),
    slave(
        "read.inputs-closed",
        "answers RD_Inp outside data exchange",
        Answers(|slave, request, answer| if request.dsap == RD_INP && is_waiting(slave) { sc() } else { answer }),
    ),
    slave(
        "read.outputs-closed",
        "answers RD_Outp outside data exchange",
        Answers(|slave, request, answer| if request.dsap == RD_OUTP && is_waiting(slave) { sc() } else { answer }),
    ),
    slave(
        "read.inputs",
        "sends an octet too many for RD_Inp",
        Says(|request, answer| {
            if request.dsap == RD_INP && answer.fc == 8 {
                answer.du.push(0);
            }
        }),
    ),
    slave(
        "read.inputs-image",
        "sends other inputs for RD_Inp than for Data_Exchange",
        Says(|request, answer| {
            if request.dsap == RD_INP && answer.fc == 8 {
                answer.du[0] ^= 0x01;
            }
        }),
    ),
    slave(
        "read.inputs-any-master",
        "refuses the inputs to a second master",
        Answers(
            |_, request, answer| {
                if request.dsap == RD_INP && request.sa != MASTER { status(request, RS) } else { answer }
            },
        ),
    ),
    slave(
        "read.outputs",
        "sends an octet too many for RD_Outp",
        Says(|request, answer| {
            if request.dsap == RD_OUTP && answer.fc == 8 {
                answer.du.push(0);
            }
        }),
    ),
    slave(
        "read.outputs-image",
        "sends other outputs for RD_Outp than it received",
        Says(|request, answer| {
            if request.dsap == RD_OUTP && answer.fc == 8 {
                answer.du[0] ^= 0x01;
            }
        }),
    ),
    slave(
        "control.broadcast",
        "acknowledges Global_Control to all slaves",
        Answers(|_, request, answer| if request.dsap == GLOBAL_CONTROL && request.da == 127 { sc() } else { answer }),
    ),
    slave(
        "control.single",
        "acknowledges Global_Control to itself",
        Answers(|_, request, answer| {
            if request.dsap == GLOBAL_CONTROL && request.da == ADDRESS && request.function() == 6 {
                sc()
            } else {
                answer
            }
        }),
    ),
    slave(
        "control.clear",
        "leaves data exchange with Clear_Data",
        Reacts(|| ends_exchange(|request| request.dsap == GLOBAL_CONTROL && request.du == [0x02, 0])),
    ),
    slave(
        "control.sync",
        "does not report Sync_Mode",
        Says(|request, answer| {
            diagnosis(request, answer, |du| du[TWO] &= !0x20);
        }),
    ),
    slave("control.unsync", "ignores Unsync", Hears(|request| command(request, |octet| octet & !0x10))),
    slave(
        "control.owner",
        "obeys Global_Control of any master",
        Hears(|request| {
            if request.dsap == GLOBAL_CONTROL {
                request.sa = MASTER;
            }
        }),
    ),
    slave(
        "control.group",
        "obeys Global_Control to any group",
        Hears(|request| {
            if request.dsap == GLOBAL_CONTROL {
                request.du[1] = 0;
            }
        }),
    ),
    slave(
        "control.freeze",
        "does not report Freeze_Mode",
        Says(|request, answer| {
            diagnosis(request, answer, |du| du[TWO] &= !0x10);
        }),
    ),
    slave("control.unfreeze", "ignores Unfreeze", Hears(|request| command(request, |octet| octet & !0x04))),
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
    slave(
        "lock.set-prm",
        "accepts Set_Prm of any master",
        Reacts(|| {
            Box::new(|line, octets| {
                if Frame::parse(octets).is_some_and(|request| is_valid_prm(&request) && request.sa != MASTER) {
                    leave(line);
                }
                line.hear(octets)
            })
        }),
    ),
    slave(
        "lock.undisturbed",
        "takes Set_Prm of any master for one of its owner",
        Hears(|request| {
            if is_valid_prm(request) {
                request.sa = MASTER;
            }
        }),
    ),
    slave(
        "lock.chk-cfg",
        "accepts Chk_Cfg of any master",
        Hears(|request| {
            if request.dsap == CHK_CFG {
                request.sa = MASTER;
            }
        }),
    ),
    slave(
        "lock.exchange",
        "exchanges data with any master",
        Hears(|request| {
            if request.is_exchange() {
                request.sa = MASTER;
            }
        }),
    ),
    slave(
        "watchdog.bit",
        "does not report WD_On",
        Says(|request, answer| {
            diagnosis(request, answer, |du| du[TWO] &= !0x08);
        }),
    ),
    slave(
        "watchdog.no-bit",
        "reports WD_On at any time",
        Says(|request, answer| {
            diagnosis(request, answer, |du| du[TWO] |= 0x08);
        }),
    ),
    slave(
        "watchdog.off",
        "runs a watchdog that is switched off",
        Reacts(|| {
            Box::new(|line, octets| {
                let received = line.hear(octets);
                let Some(request) = Frame::parse(octets) else { return received };
                if is_valid_prm(&request) && request.du[0] & WD_ON == 0 {
                    let mut watched = request;
                    watched.du[..3].copy_from_slice(&[LOCK | WD_ON, 20, 1]);
                    return line.hear(&super::faulty::as_first(&watched));
                }
                let Some(mut answer) = Frame::parse_answer(&received) else { return received };
                let short = line.slave.state().owner().and_then(|owner| owner.watchdog).is_some_and(is_200_ms);
                diagnosis(&request, &mut answer, |du| {
                    if short {
                        du[TWO] &= !0x08;
                    }
                });
                Received::Telegram(answer.octets())
            })
        }),
    ),
    slave(
        "watchdog.expiry",
        "has a watchdog that never expires",
        Hears(|request| {
            if is_valid_prm(request) && request.du[0] & WD_ON != 0 {
                request.du[1..3].copy_from_slice(&[255, 255]);
            }
        }),
    ),
    slave(
        "watchdog.no-owner",
        "keeps its owner after the watchdog has expired",
        Reacts(|| {
            let mut ran = false;
            Box::new(move |line, octets| {
                let received = line.hear(octets);
                let Some(request) = Frame::parse(octets) else { return received };
                ran = (ran && request.dsap != SET_PRM) || line.slave.watchdog_is_running();
                let expired = ran && is_waiting(&line.slave);
                let Some(mut answer) = Frame::parse_answer(&received) else { return received };
                diagnosis(&request, &mut answer, |du| {
                    if expired {
                        du[OWNER] = MASTER;
                    }
                });
                Received::Telegram(answer.octets())
            })
        }),
    ),
    slave(
        "watchdog.restart",
        "does not restart the watchdog with Data_Exchange",
        Reacts(|| {
            let mut watch = Watch::default();
            Box::new(move |line, octets| {
                let Some(request) = Frame::parse(octets) else { return line.hear(octets) };
                if is_prm(&request) {
                    let on = request.du[0] & WD_ON != 0;
                    let period_ms = if on { 10 * u64::from(request.du[1]) * u64::from(request.du[2]) } else { 0 };
                    watch = Watch { period_ms, begun_ms: line.now_ms() };
                }
                if watch.period_ms != 0 && line.now_ms() > watch.begun_ms + watch.period_ms {
                    leave(line);
                }
                line.hear(octets)
            })
        }),
    ),
    slave(
        "ms1.closed",
        "opens MS1 outside data exchange",
        Answers(|slave, request, answer| if request.dsap == MS1 && is_waiting(slave) { sc() } else { answer }),
    ),
    slave(
        "ms1.poll",
        "refuses a poll of MS1 without a response",
        Answers(|_, request, answer| {
            if request.dsap == MS1 && request.du.is_empty() && answer == sc() { status(request, RR) } else { answer }
        }),
    ),
    slave(
        "ms1.foreign",
        "opens MS1 to any master",
        Answers(|_, request, answer| if request.dsap == MS1 && request.sa != MASTER { sc() } else { answer }),
    ),
    slave(
        "ms1.refusal",
        "returns an empty record for a slot that it does not have",
        Says(|request, answer| {
            if request.dsap == MS1 && answer.du.first() == Some(&0xDE) {
                answer.du = vec![0x5E, 254, 1, 0];
            }
        }),
    ),
    slave(
        "ms1.low-priority",
        "sends responses of MS1 with high priority",
        Says(|request, answer| {
            if request.dsap == MS1 && answer.fc == 8 {
                answer.fc = 0x0A;
            }
        }),
    ),
    slave(
        "ms1.error-decode",
        "sends a reserved Error_Decode over MS1",
        Says(|request, answer| {
            if request.dsap == MS1 && answer.du.first() == Some(&0xDE) {
                answer.du[1] = 0x81;
            }
        }),
    ),
    slave(
        "ms2.manager",
        "names an access point above 48",
        Says(|request, answer| {
            if request.dsap == MANAGER && answer.du.len() > 1 {
                answer.du[1] = 54;
            }
        }),
    ),
    slave(
        "ms2.abort-closes",
        "ignores Abort",
        Reacts(|| {
            Box::new(|line, octets| match Frame::parse(octets) {
                Some(request) if request.is_connection() && request.du.first() == Some(&0x58) => sc(),
                _ => line.hear(octets),
            })
        }),
    ),
    slave(
        "ms2.initiate",
        "refuses Initiate on the access point that it named",
        Says(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0x57) {
                answer.du = vec![0xD7, 0x80, 0xA9, 0];
            }
        }),
    ),
    slave(
        "ms2.abort",
        "answers Abort with RR",
        Answers(|_, request, answer| {
            if request.is_connection() && request.du.first() == Some(&0x58) && answer == sc() {
                status(request, RR)
            } else {
                answer
            }
        }),
    ),
    slave(
        "ms2.record-length",
        "says that its longest record has no octets",
        Says(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0x57) {
                answer.du[1] = 0;
            }
        }),
    ),
    slave(
        "ms2.poll",
        "refuses a poll of MS2 without a response",
        Answers(|_, request, answer| {
            if request.is_connection() && request.du.is_empty() && answer == sc() {
                status(request, RR)
            } else {
                answer
            }
        }),
    ),
    slave(
        "ms2.idle",
        "answers Idle with another octet",
        Says(|request, answer| {
            if request.is_connection() && answer.du == [0x48] {
                answer.du[0] = 0x49;
            }
        }),
    ),
    slave(
        "ms2.low-priority",
        "sends responses of MS2 with high priority",
        Says(|request, answer| {
            if request.is_connection() && answer.fc == 8 {
                answer.fc = 0x0A;
            }
        }),
    ),
    slave("ms2.repeated-poll", "executes a repeated poll", Counts(Counting::PollsAnew)),
    slave(
        "ms2.undisturbed",
        "drops a response when another master sends a request",
        Reacts(|| {
            let mut connection = None;
            Box::new(move |line, octets| {
                let Some(request) = Frame::parse(octets) else { return line.hear(octets) };
                if request.is_connection() {
                    connection = Some(Frame { du: Vec::new(), ..request });
                } else if let Some(poll) = connection.as_ref().filter(|_| request.sa != MASTER) {
                    line.hear(&super::faulty::as_first(poll));
                }
                line.hear(octets)
            })
        }),
    ),
    slave(
        "ms2.foreign",
        "opens a connection to any master",
        Answers(|_, request, answer| if request.is_connection() && request.sa != MASTER { sc() } else { answer }),
    ),
    slave(
        "ms2.foreign-access-point",
        "does not look at the source access point of MS2",
        Hears(|request| {
            if request.is_connection() {
                request.ssap = Some(50);
            }
        }),
    ),
    slave(
        "ms2.refusal",
        "returns an empty record over MS2 for a slot that it does not have",
        Says(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0xDE) {
                answer.du = vec![0x5E, 254, 1, 0];
            }
        }),
    ),
    slave(
        "ms2.error-decode",
        "sends a reserved Error_Decode over MS2",
        Says(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0xDE) {
                answer.du[1] = 0x81;
            }
        }),
    ),
    slave(
        "ms2.error-class",
        "sends an error of resources for a slot that it does not have",
        Says(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0xDE) {
                answer.du[2] = 0xC2;
            }
        }),
    ),
    slave(
        "ms2.unknown-function",
        "answers an unknown function with Idle",
        Says(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0x58) {
                answer.du = vec![0x48];
            }
        }),
    ),
    slave(
        "ms2.abort-ends",
        "answers polls after its own Abort",
        Reacts(|| {
            let mut aborted = None;
            Box::new(move |line, octets| {
                let received = line.hear(octets);
                let Some(request) = Frame::parse(octets) else { return received };
                if request.dsap == MANAGER {
                    aborted = None;
                }
                let answer = Frame::parse_answer(&received);
                if request.is_connection() && answer.is_some_and(|answer| answer.du.first() == Some(&0x58)) {
                    aborted = request.dsap;
                }
                if request.is_connection() && request.dsap == aborted && is_rs(&received) { sc() } else { received }
            })
        }),
    ),
    slave(
        "ms2.exchange",
        "leaves data exchange with Initiate",
        Reacts(|| ends_exchange(|request| request.dsap == MANAGER)),
    ),
    slave(
        "noise.silence",
        "acknowledges long telegrams with a fault",
        Reacts(|| Box::new(|line, octets| if damaged::is_long(octets) { sc() } else { line.hear(octets) })),
    ),
    slave(
        "noise.state",
        "leaves data exchange with a long damaged telegram",
        Reacts(|| {
            Box::new(|line, octets| {
                if damaged::is_long(octets) {
                    leave(line);
                }
                line.hear(octets)
            })
        }),
    ),
];

/// A slave that keeps a bit of the first octet of its diagnosis from a request until it is released.
fn latched(begins: fn(&Frame) -> bool, bit: u8) -> Box<super::faulty::Reaction> {
    let mut latched = false;
    Box::new(move |line, octets| {
        let received = line.hear(octets);
        let Some(request) = Frame::parse(octets) else { return received };
        latched = (latched || begins(&request)) && !is_unlock(&request);
        let Some(mut answer) = Frame::parse_answer(&received) else { return received };
        diagnosis(&request, &mut answer, |du| {
            if latched {
                du[ONE] |= bit;
            }
        });
        Received::Telegram(answer.octets())
    })
}

/// A slave that leaves data exchange after a request.
fn ends_exchange(ends: fn(&Frame) -> bool) -> Box<super::faulty::Reaction> {
    Box::new(move |line, octets| {
        let was = is_exchanging(&line.slave);
        let received = line.hear(octets);
        if was && Frame::parse(octets).is_some_and(|request| ends(&request)) {
            leave(line);
        }
        received
    })
}

/// A slave that acknowledges a request of its owner during data exchange and does not execute it.
fn ignores_in_exchange(ignores: fn(&Frame) -> bool) -> Box<super::faulty::Reaction> {
    Box::new(move |line, octets| match Frame::parse(octets) {
        Some(request) if is_exchanging(&line.slave) && request.sa == MASTER && ignores(&request) => sc(),
        _ => line.hear(octets),
    })
}

fn is_200_ms(watchdog: profivac_dp::slave::Watchdog) -> bool {
    watchdog.period_tbit == profivac_dp::link::Baud::B19200.tbit_of_ms(200)
}

/// Changes Control_Command.
fn command(request: &mut Frame, change: impl FnOnce(u8) -> u8) {
    if request.dsap == GLOBAL_CONTROL {
        request.du[0] = change(request.du[0]);
    }
}
