//! Slaves with a fault in their diagnosis, in Get_Cfg, or in their states.

use super::*;

pub static SLAVES: &[FaultySlave] = &[
    slave("diagnosis.fixed-bit", "sends 0 in the bit that is always 1", Reports(|du| du[TWO] &= !0x04)),
    slave("diagnosis.master-bits", "sets Master_Lock", Reports(|du| du[ONE] |= 0x80)),
    slave("diagnosis.reserved-bits", "sets a reserved bit of the diagnosis", Reports(|du| du[THREE] |= 0x01)),
    slave(
        "diagnosis.ident",
        "sends another ident number once it has parameters",
        Reports(|du| du[5] ^= u8::from(du[OWNER] != 0xFF)),
    ),
    slave(
        "diagnosis.blocks",
        "sends a block that is longer than the diagnosis",
        ChangesAnswer(|request, answer| {
            if request.dsap == SLAVE_DIAG && answer.du.len() >= 6 {
                answer.du.push(0x45);
            }
        }),
    ),
    slave("diagnosis.any-master", "refuses the diagnosis to a second master", RefusesOthers(SLAVE_DIAG)),
    slave("get-cfg.identifiers", "sends a truncated configuration", Returns(GET_CFG, |du| du.push(0xC0))),
    slave("get-cfg.any-master", "refuses the configuration to a second master", RefusesOthers(GET_CFG)),
    slave(
        "get-cfg.no-open-format",
        "sends an identifier with 15 manufacturer octets",
        Returns(GET_CFG, |du| *du = vec![0x4F, 0x81, 0x21]),
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
                _ => line.send(octets),
            })
        }),
    ),
    slave(
        "start-up.unlock",
        "ignores Unlock_Req",
        Reacts(|| {
            Box::new(|line, octets| match Frame::parse(octets) {
                Some(request) if is_unlock(&request) => sc(),
                _ => line.send(octets),
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
        Reports(|du| {
            if du[OWNER] == 0xFF {
                du[OWNER] = MASTER;
            }
        }),
    ),
    slave(
        "start-up.prm-req",
        "waits for parameters without Prm_Req",
        Reports(|du| {
            if du[OWNER] == 0xFF {
                du[TWO] &= !0x01;
            }
        }),
    ),
    slave(
        "start-up.not-ready",
        "waits for parameters without Station_Not_Ready",
        Reports(|du| {
            if du[OWNER] == 0xFF {
                du[ONE] &= !0x02;
            }
        }),
    ),
    slave(
        "start-up.owner",
        "reports another master as its owner",
        Reports(|du| {
            if du[OWNER] == MASTER {
                du[OWNER] = 1;
            }
        }),
    ),
    slave(
        "start-up.parameterised",
        "keeps Prm_Req after Set_Prm",
        Reports(|du| {
            if du[OWNER] != 0xFF {
                du[TWO] |= 0x01;
            }
        }),
    ),
    slave(
        "start-up.waits-for-cfg",
        "reports that it is ready before Chk_Cfg",
        Reports(|du| {
            if du[OWNER] != 0xFF {
                du[ONE] &= !0x02;
            }
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
        "reports that it is not ready during data exchange",
        Reports(|du| {
            if du[OWNER] != 0xFF {
                du[ONE] |= 0x02;
            }
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
                    line.send(&request(cfg.sa, 61, &[LOCK, 0, 0, 11, high, low, 0, 0x80, 0, 0]));
                    return line.send(&request(cfg.sa, 62, &CFG));
                }
                line.send(octets)
            })
        }),
    ),
    slave(
        "start-up.no-lock",
        "takes Set_Prm without Lock_Req for one with it",
        ChangesRequest(|request| {
            if is_prm(request) && request.du[0] & (LOCK | UNLOCK) == 0 {
                request.du[0] |= LOCK;
            }
        }),
    ),
    slave(
        "start-up.both-locks",
        "ignores Unlock_Req beside Lock_Req",
        ChangesRequest(|request| {
            if is_prm(request) && request.du[0] & LOCK != 0 {
                request.du[0] &= !UNLOCK;
            }
        }),
    ),
    slave(
        "start-up.wrong-ident",
        "does not look at the ident number of Set_Prm",
        ChangesRequest(|request| {
            if is_prm(request) {
                request.du[4..6].copy_from_slice(&IDENT.to_be_bytes());
            }
        }),
    ),
    slave("start-up.prm-fault", "never reports Prm_Fault", Reports(|du| du[ONE] &= !0x40)),
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
                _ => line.send(octets),
            })
        }),
    ),
    slave(
        "start-up.truncated-cfg",
        "ignores a truncated identifier",
        ChangesRequest(|request| {
            if is_truncated_cfg(request) {
                request.du.pop();
            }
        }),
    ),
    slave(
        "start-up.other-cfg",
        "compares the first identifiers only",
        ChangesRequest(|request| {
            if request.dsap == CHK_CFG && request.du.starts_with(&CFG) && !is_truncated_cfg(request) {
                request.du.truncate(CFG.len());
            }
        }),
    ),
    slave("start-up.cfg-fault", "never reports Cfg_Fault", Reports(|du| du[ONE] &= !0x04)),
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
];
