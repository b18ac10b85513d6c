//! Set_Prm, Chk_Cfg and the owner of the slave (profibus-wire 2.3 to 2.7 and 3).

use super::Check;
use crate::dialogue::{CheckOutcome, Dialogue, require, set_prm_octets};
use profivac_wire::control::Status;
use profivac_wire::diag::NO_MASTER;
use profivac_wire::prm::SetPrm;
use profivac_wire::{Sap, cfg};
use std::time::Duration;

pub const CHECKS: &[Check] = &[
    Check {
        name: "start-up.diagnosis",
        rule: "the diagnosis of a slave without an owner is 02 05 00 FF and its ident number",
        section: "2.3",
        run: diagnosis,
    },
    Check {
        name: "start-up.get-cfg",
        rule: "Get_Cfg returns a configuration to any master",
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
        rule: "a parameterised slave reports its master and waits for the configuration",
        section: "3.2",
        run: owner,
    },
    Check { name: "start-up.wrong-cfg", rule: "another configuration is Cfg_Fault", section: "2.6.5", run: wrong_cfg },
    Check {
        name: "start-up.lock",
        rule: "another master can read the diagnosis, but neither parameterise nor exchange data",
        section: "3.4",
        run: lock,
    },
    Check { name: "start-up.unlock", rule: "the owner releases the slave", section: "3.2", run: unlock },
    Check {
        name: "start-up.watchdog",
        rule: "a slave without requests of its master leaves data exchange",
        section: "3.6",
        run: watchdog,
    },
];

/// The bits that only a master sets: Station_Non_Existent, Invalid_Slave_Response and Master_Lock.
const BITS_OF_MASTERS: u8 = 0xA1;

/// Ext_Diag and Not_Supported may be set in any state.
const FREE_BITS: u8 = 0x18;

/// Prm_Req and the bit that is always 1.
const PRM_REQ: u8 = 0x05;

/// Stat_Diag may be set in any state.
const STAT_DIAG: u8 = 0x02;

/// Requires a diagnosis with this first octet, of a slave that waits for parameters and has no owner.
fn expect_waiting(dialogue: &mut Dialogue<'_>, first: u8) -> CheckOutcome {
    let [one, two, three, master, ident @ ..] = dialogue.diagnosis()?;
    let expected = format!("{first:02X} 05 00 FF");
    require((one & !FREE_BITS, two & !STAT_DIAG, three & 0x7F, master) == (first, PRM_REQ, 0, NO_MASTER), &expected)?;
    require(one & BITS_OF_MASTERS == 0, "0 in the bits that only masters set")?;
    require(u16::from_be_bytes(ident) == dialogue.slave.ident, "the same ident number as before")
}

fn diagnosis(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    expect_waiting(dialogue, 0x02)
}

fn get_cfg(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    for sa in [dialogue.own_address(), dialogue.other_master_address()] {
        let octets = dialogue.data_from(sa, Sap::GetCfg)?;
        require(cfg::lengths(&octets).is_ok(), "the identifiers of a configuration")?;
    }
    Ok(())
}

fn not_yet(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    let outputs = dialogue.outputs();
    dialogue.expect_closed(Sap::Default, &outputs, "RS: the slave is not in data exchange")?;
    dialogue.expect_closed(Sap::RdInp, &[], "RS: the slave is not in data exchange")?;
    dialogue.expect_closed(Sap::RdOutp, &[], "RS: the slave is not in data exchange")
}

fn wrong_ident(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    let prm = dialogue.prm([0, 0]);
    dialogue.set_prm(&SetPrm { ident: prm.ident ^ 0x0101, ..prm })?;
    expect_waiting(dialogue, 0x42)?;
    dialogue.release()
}

fn short_prm(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    let [high, low] = dialogue.slave.ident.to_be_bytes();
    dialogue.expect_acknowledged(Sap::SetPrm, &[0x80, 0, 0, 11, high, low])?;
    expect_waiting(dialogue, 0x42)?;
    dialogue.release()
}

fn owner(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.set_prm(&dialogue.prm([0, 0]))?;
    let [one, two, _, master, ..] = dialogue.diagnosis()?;
    require(master == dialogue.own_address(), "the address of the testing master as Diag_Master_Add")?;
    require(one & !FREE_BITS == 0x02, "Station_Not_Ready and no fault")?;
    require(two & 0x05 == 0x04, "no Prm_Req")?;
    let outputs = dialogue.outputs();
    dialogue.expect_closed(Sap::Default, &outputs, "RS: the slave waits for its configuration")?;
    dialogue.release()
}

fn wrong_cfg(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.set_prm(&dialogue.prm([0, 0]))?;
    // The configuration with one identifier more.
    let wrong: Vec<_> = dialogue.slave.cfg.iter().copied().chain([0x30]).collect();
    dialogue.expect_acknowledged(Sap::ChkCfg, &wrong)?;
    expect_waiting(dialogue, 0x06)?;
    dialogue.release()
}

fn lock(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start([0, 0])?;
    let other = dialogue.other_master_address();
    let accepted = set_prm_octets(&dialogue.prm([0, 0]));
    // The slave may acknowledge and ignore it, or refuse it (profibus-wire 2.2).
    dialogue.request_from(other, Sap::SetPrm, &accepted)?;
    let [.., master, _, _] = dialogue.diagnosis_from(other)?;
    require(master == dialogue.own_address(), "the address of the testing master as Diag_Master_Add, as before")?;
    let outputs = dialogue.outputs();
    dialogue.expect_status_from(
        other,
        Sap::Default,
        &outputs,
        Status::ServiceNotActivated,
        "RS: the slave belongs to another master",
    )?;
    dialogue.exchange()?;
    dialogue.release()
}

fn unlock(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start([0, 0])?;
    dialogue.release()?;
    expect_waiting(dialogue, 0x02)
}

fn watchdog(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    // 10 x 1 x 10 ms = 100 ms.
    dialogue.start([10, 1])?;
    dialogue.wait(Duration::from_millis(500))?;
    expect_waiting(dialogue, 0x02)?;
    let outputs = dialogue.outputs();
    dialogue.expect_closed(Sap::Default, &outputs, "RS: the watchdog has expired")
}
