//! Set_Prm, Chk_Cfg and who owns the slave. profibus-wire 2.3 to 2.7 and 3.

use super::Check;
use crate::talk::{Checked, Talk, must};
use profivac_wire::control::Status;
use profivac_wire::diag::NO_MASTER;
use profivac_wire::prm::SetPrm;
use profivac_wire::{Sap, cfg};
use std::time::Duration;

pub const CHECKS: &[Check] = &[
    Check {
        name: "start-up.diagnosis",
        rule: "a slave that nobody owns says 02 05 00 FF and its ident number",
        section: "2.3",
        ask: diagnosis,
    },
    Check {
        name: "start-up.get-cfg",
        rule: "Get_Cfg gives a configuration to any master",
        section: "2.7",
        ask: get_cfg,
    },
    Check {
        name: "start-up.not-yet",
        rule: "before Set_Prm, Data_Exchange, RD_Inp and RD_Outp answer RS",
        section: "2.2",
        ask: not_yet,
    },
    Check {
        name: "start-up.wrong-ident",
        rule: "Set_Prm with another ident number is Prm_Fault",
        section: "2.4",
        ask: wrong_ident,
    },
    Check {
        name: "start-up.short-prm",
        rule: "Set_Prm with less than seven octets is Prm_Fault",
        section: "2.4",
        ask: short_prm,
    },
    Check {
        name: "start-up.owner",
        rule: "a parameterised slave names its master and waits for the configuration",
        section: "3.2",
        ask: owner,
    },
    Check { name: "start-up.wrong-cfg", rule: "another configuration is Cfg_Fault", section: "2.6.5", ask: wrong_cfg },
    Check {
        name: "start-up.lock",
        rule: "another master can neither parameterise nor exchange, but read the diagnosis",
        section: "3.4",
        ask: lock,
    },
    Check { name: "start-up.unlock", rule: "the owner releases the slave", section: "3.2", ask: unlock },
    Check {
        name: "start-up.watchdog",
        rule: "a slave that hears nothing of its master leaves data exchange",
        section: "3.6",
        ask: watchdog,
    },
];

/// Bits that only a master sets: Station_Non_Existent, Invalid_Slave_Response and Master_Lock.
const BITS_OF_MASTERS: u8 = 0xA1;

/// Ext_Diag and Not_Supported may be there in any state.
const FREE_BITS: u8 = 0x18;

/// Prm_Req and the bit that is always one.
const PRM_REQ: u8 = 0x05;

/// Stat_Diag may be there in any state.
const STAT_DIAG: u8 = 0x02;

/// The diagnosis has this first octet, and nobody owns the slave.
fn waits(talk: &mut Talk<'_>, first: u8) -> Checked {
    let [one, two, three, master, ident @ ..] = talk.diagnosis()?;
    let expected = format!("{first:02X} 05 00 FF");
    must((one & !FREE_BITS, two & !STAT_DIAG, three & 0x7F, master) == (first, PRM_REQ, 0, NO_MASTER), &expected)?;
    must(one & BITS_OF_MASTERS == 0, "the bits that only masters set are 0")?;
    must(u16::from_be_bytes(ident) == talk.subject.ident, "the same ident number as before")
}

fn diagnosis(talk: &mut Talk<'_>) -> Checked {
    talk.release()?;
    waits(talk, 0x02)
}

fn get_cfg(talk: &mut Talk<'_>) -> Checked {
    for sa in [talk.us(), talk.other()] {
        let octets = talk.data_from(sa, Sap::GetCfg)?;
        must(cfg::lengths(&octets).is_ok(), "identifiers of a configuration")?;
    }
    Ok(())
}

fn not_yet(talk: &mut Talk<'_>) -> Checked {
    talk.release()?;
    let outputs = talk.outputs();
    talk.closed(Sap::Default, &outputs, "RS: it is not in data exchange")?;
    talk.closed(Sap::RdInp, &[], "RS: it is not in data exchange")?;
    talk.closed(Sap::RdOutp, &[], "RS: it is not in data exchange")
}

fn wrong_ident(talk: &mut Talk<'_>) -> Checked {
    talk.release()?;
    let prm = talk.prm([0, 0]);
    talk.set_prm(&SetPrm { ident: prm.ident ^ 0x0101, ..prm })?;
    waits(talk, 0x42)?;
    talk.release()
}

fn short_prm(talk: &mut Talk<'_>) -> Checked {
    talk.release()?;
    let [high, low] = talk.subject.ident.to_be_bytes();
    talk.acknowledged(Sap::SetPrm, &[0x80, 0, 0, 11, high, low])?;
    waits(talk, 0x42)?;
    talk.release()
}

fn owner(talk: &mut Talk<'_>) -> Checked {
    talk.release()?;
    talk.set_prm(&talk.prm([0, 0]))?;
    let [one, two, _, master, ..] = talk.diagnosis()?;
    must(master == talk.us(), "our address as Diag_Master_Add")?;
    must(one & !FREE_BITS == 0x02, "Station_Not_Ready and no fault")?;
    must(two & 0x05 == 0x04, "no Prm_Req")?;
    let outputs = talk.outputs();
    talk.closed(Sap::Default, &outputs, "RS: it waits for its configuration")?;
    talk.release()
}

fn wrong_cfg(talk: &mut Talk<'_>) -> Checked {
    talk.release()?;
    talk.set_prm(&talk.prm([0, 0]))?;
    // One octet more than it has, each way.
    let wrong: Vec<_> = talk.subject.cfg.iter().copied().chain([0x30]).collect();
    talk.acknowledged(Sap::ChkCfg, &wrong)?;
    waits(talk, 0x06)?;
    talk.release()
}

fn lock(talk: &mut Talk<'_>) -> Checked {
    talk.start([0, 0])?;
    let other = talk.other();
    let takes = crate::talk::emitted(&talk.prm([0, 0]));
    // Acknowledged and ignored, or refused: profibus-wire 2.2 leaves both.
    talk.request_from(other, Sap::SetPrm, &takes)?;
    let [.., master, _, _] = talk.diagnosis_from(other)?;
    must(master == talk.us(), "our address as Diag_Master_Add, as before")?;
    let outputs = talk.outputs();
    talk.refused_from(other, Sap::Default, &outputs, Status::ServiceNotActivated, "RS: it belongs to another master")?;
    talk.exchange()?;
    talk.release()
}

fn unlock(talk: &mut Talk<'_>) -> Checked {
    talk.start([0, 0])?;
    talk.release()?;
    waits(talk, 0x02)
}

fn watchdog(talk: &mut Talk<'_>) -> Checked {
    // 10 x 1 x 10 ms
    talk.start([10, 1])?;
    talk.wait(Duration::from_millis(500))?;
    waits(talk, 0x02)?;
    let outputs = talk.outputs();
    talk.closed(Sap::Default, &outputs, "RS: its watchdog has expired")
}
