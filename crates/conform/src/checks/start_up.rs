//! Set_Prm, Chk_Cfg and who owns the slave. profibus-wire 2.3 to 2.7 and 3.

use super::Check;
use crate::dialogue::{CheckOutcome, Dialogue, require};
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
        run: diagnosis,
    },
    Check {
        name: "start-up.get-cfg",
        rule: "Get_Cfg gives a configuration to any master",
        section: "2.7",
        run: get_cfg,
    },
    Check {
        name: "start-up.not-yet",
        rule: "before Set_Prm, Data_Exchange, RD_Inp and RD_Outp answer RS",
        section: "2.2",
        run: not_yet,
    },
    Check {
        name: "start-up.wrong-ident",
        rule: "Set_Prm with another ident number is Prm_Fault",
        section: "2.4",
        run: wrong_ident,
    },
    Check {
        name: "start-up.short-prm",
        rule: "Set_Prm with less than seven octets is Prm_Fault",
        section: "2.4",
        run: short_prm,
    },
    Check {
        name: "start-up.owner",
        rule: "a parameterised slave names its master and waits for the configuration",
        section: "3.2",
        run: owner,
    },
    Check { name: "start-up.wrong-cfg", rule: "another configuration is Cfg_Fault", section: "2.6.5", run: wrong_cfg },
    Check {
        name: "start-up.lock",
        rule: "another master can neither parameterise nor exchange, but read the diagnosis",
        section: "3.4",
        run: lock,
    },
    Check { name: "start-up.unlock", rule: "the owner releases the slave", section: "3.2", run: unlock },
    Check {
        name: "start-up.watchdog",
        rule: "a slave that hears nothing of its master leaves data exchange",
        section: "3.6",
        run: watchdog,
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
fn waits(talk: &mut Dialogue<'_>, first: u8) -> CheckOutcome {
    let [one, two, three, master, ident @ ..] = talk.diagnosis()?;
    let expected = format!("{first:02X} 05 00 FF");
    require((one & !FREE_BITS, two & !STAT_DIAG, three & 0x7F, master) == (first, PRM_REQ, 0, NO_MASTER), &expected)?;
    require(one & BITS_OF_MASTERS == 0, "the bits that only masters set are 0")?;
    require(u16::from_be_bytes(ident) == talk.slave.ident, "the same ident number as before")
}

fn diagnosis(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.release()?;
    waits(talk, 0x02)
}

fn get_cfg(talk: &mut Dialogue<'_>) -> CheckOutcome {
    for sa in [talk.own_address(), talk.other_master_address()] {
        let octets = talk.data_from(sa, Sap::GetCfg)?;
        require(cfg::lengths(&octets).is_ok(), "identifiers of a configuration")?;
    }
    Ok(())
}

fn not_yet(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.release()?;
    let outputs = talk.outputs();
    talk.expect_closed(Sap::Default, &outputs, "RS: it is not in data exchange")?;
    talk.expect_closed(Sap::RdInp, &[], "RS: it is not in data exchange")?;
    talk.expect_closed(Sap::RdOutp, &[], "RS: it is not in data exchange")
}

fn wrong_ident(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.release()?;
    let prm = talk.prm([0, 0]);
    talk.set_prm(&SetPrm { ident: prm.ident ^ 0x0101, ..prm })?;
    waits(talk, 0x42)?;
    talk.release()
}

fn short_prm(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.release()?;
    let [high, low] = talk.slave.ident.to_be_bytes();
    talk.expect_acknowledged(Sap::SetPrm, &[0x80, 0, 0, 11, high, low])?;
    waits(talk, 0x42)?;
    talk.release()
}

fn owner(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.release()?;
    talk.set_prm(&talk.prm([0, 0]))?;
    let [one, two, _, master, ..] = talk.diagnosis()?;
    require(master == talk.own_address(), "our address as Diag_Master_Add")?;
    require(one & !FREE_BITS == 0x02, "Station_Not_Ready and no fault")?;
    require(two & 0x05 == 0x04, "no Prm_Req")?;
    let outputs = talk.outputs();
    talk.expect_closed(Sap::Default, &outputs, "RS: it waits for its configuration")?;
    talk.release()
}

fn wrong_cfg(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.release()?;
    talk.set_prm(&talk.prm([0, 0]))?;
    // One octet more than it has, each way.
    let wrong: Vec<_> = talk.slave.cfg.iter().copied().chain([0x30]).collect();
    talk.expect_acknowledged(Sap::ChkCfg, &wrong)?;
    waits(talk, 0x06)?;
    talk.release()
}

fn lock(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.start([0, 0])?;
    let other = talk.other_master_address();
    let takes = crate::dialogue::emitted(&talk.prm([0, 0]));
    // Acknowledged and ignored, or refused: profibus-wire 2.2 leaves both.
    talk.request_from(other, Sap::SetPrm, &takes)?;
    let [.., master, _, _] = talk.diagnosis_from(other)?;
    require(master == talk.own_address(), "our address as Diag_Master_Add, as before")?;
    let outputs = talk.outputs();
    talk.expect_status_from(
        other,
        Sap::Default,
        &outputs,
        Status::ServiceNotActivated,
        "RS: it belongs to another master",
    )?;
    talk.exchange()?;
    talk.release()
}

fn unlock(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.start([0, 0])?;
    talk.release()?;
    waits(talk, 0x02)
}

fn watchdog(talk: &mut Dialogue<'_>) -> CheckOutcome {
    // 10 x 1 x 10 ms
    talk.start([10, 1])?;
    talk.wait(Duration::from_millis(500))?;
    waits(talk, 0x02)?;
    let outputs = talk.outputs();
    talk.expect_closed(Sap::Default, &outputs, "RS: its watchdog has expired")
}
