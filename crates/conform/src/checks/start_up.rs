//! Set_Prm, Chk_Cfg and the states of a slave (profibus-wire 2.2 to 2.6 and 3.2).

use super::Check;
use crate::dialogue::{CheckError, CheckOutcome, Dialogue, Step, StepError, require, set_prm_octets};
use crate::expected::{Closed, Expected, Reason};
use profivac_wire::Sap;
use profivac_wire::diag::{NO_MASTER, StationStatus};
use profivac_wire::prm::{PrmStatus, SetPrm};
use std::time::Duration;

const EXCHANGE: &str = "start-up.exchange";
const UNLOCK: &str = "start-up.unlock";
const DIAGNOSIS: &str = "diagnosis.answer";

pub const CHECKS: &[Check] = &[
    Check::new("start-up.set-prm", "2.4", "Set_Prm is acknowledged with SC", set_prm),
    Check::new("start-up.chk-cfg", "2.6", "Chk_Cfg is acknowledged with SC", chk_cfg),
    Check::new(EXCHANGE, "3.2", "after Set_Prm and Chk_Cfg the slave exchanges data", exchange),
    Check::new(UNLOCK, "3.2", "Unlock_Req ends data exchange", unlock).after(&[EXCHANGE]),
    Check::new("start-up.refused", "2.2", "outside data exchange Data_Exchange is answered with RS", refused)
        .after(&[UNLOCK, "layer2.closed"]),
    Check::new("start-up.no-owner", "2.3", "without an owner Diag_Master_Add is FF", no_owner)
        .after(&[DIAGNOSIS, UNLOCK]),
    Check::new("start-up.prm-req", "2.3", "a slave that waits for parameters says Prm_Req", prm_req)
        .after(&[DIAGNOSIS, UNLOCK]),
    Check::new("start-up.not-ready", "2.3", "a slave that waits for parameters says Station_Not_Ready", not_ready)
        .after(&[DIAGNOSIS, UNLOCK]),
    Check::new("start-up.owner", "2.3", "Diag_Master_Add is the master that sent Set_Prm", owner).after(&[DIAGNOSIS]),
    Check::new("start-up.parameterised", "3.2", "Set_Prm ends Prm_Req", parameterised).after(&[DIAGNOSIS, EXCHANGE]),
    Check::new("start-up.waits-for-cfg", "3.2", "before Chk_Cfg the slave says Station_Not_Ready", waits_for_cfg)
        .after(&["start-up.not-ready"]),
    Check::new("start-up.before-cfg", "2.2", "before Chk_Cfg the slave does not exchange data", before_cfg)
        .after(&[EXCHANGE]),
    Check::new("start-up.ready", "3.2", "in data exchange the slave does not say Station_Not_Ready", ready)
        .after(&[DIAGNOSIS, EXCHANGE]),
    Check::new("start-up.cfg-before-prm", "2.2", "Chk_Cfg before Set_Prm starts no data exchange", cfg_before_prm)
        .after(&[UNLOCK]),
    Check::new("start-up.no-lock", "2.4", "Set_Prm without Lock_Req and Unlock_Req gives no owner", no_lock)
        .after(&["start-up.no-owner"]),
    Check::new("start-up.both-locks", "2.4", "Lock_Req together with Unlock_Req ends data exchange", both_locks)
        .after(&[UNLOCK, "start-up.cfg-before-prm"]),
    Check::new("start-up.wrong-ident", "2.4", "Set_Prm with another ident number starts nothing", wrong_ident)
        .after(&[UNLOCK, "start-up.cfg-before-prm"]),
    Check::new("start-up.prm-fault", "2.3", "a faulty Set_Prm is Prm_Fault", prm_fault)
        .after(&[DIAGNOSIS, "start-up.wrong-ident"]),
    Check::new(
        "start-up.prm-fault-acknowledged",
        "2.2",
        "a faulty Set_Prm is acknowledged too",
        prm_fault_acknowledged,
    )
    .after(&["start-up.set-prm"]),
    Check::new("start-up.prm-fault-ended", "2.4", "a valid Set_Prm ends Prm_Fault", prm_fault_ended)
        .after(&["start-up.prm-fault"]),
    Check::new("start-up.short-prm", "2.4", "Set_Prm with less than seven octets is Prm_Fault", short_prm)
        .after(&["start-up.prm-fault"]),
    Check::new(
        "start-up.truncated-cfg",
        "2.6.4",
        "a configuration with a truncated identifier starts nothing",
        truncated,
    )
    .after(&[EXCHANGE, "start-up.before-cfg"]),
    Check::new("start-up.other-cfg", "2.6.5", "a configuration with another identifier starts nothing", other_cfg)
        .after(&["start-up.truncated-cfg"]),
    Check::new("start-up.cfg-fault", "2.6.5", "a faulty configuration is Cfg_Fault", cfg_fault)
        .after(&[DIAGNOSIS, "start-up.truncated-cfg"]),
    Check::new(
        "start-up.cfg-fault-acknowledged",
        "2.2",
        "a faulty Chk_Cfg is acknowledged too",
        cfg_fault_acknowledged,
    )
    .after(&["start-up.chk-cfg"]),
    Check::new("start-up.cfg-fault-ended", "2.4", "a valid Set_Prm ends Cfg_Fault", cfg_fault_ended)
        .after(&["start-up.cfg-fault"])
        .unless_broken(&["start-up.prm-fault-ended"]),
    Check::new("start-up.cfg-again", "3.2", "the same Chk_Cfg does not end data exchange", cfg_again)
        .after(&[EXCHANGE]),
    Check::new("start-up.prm-again", "3.2", "a new Set_Prm ends data exchange", prm_again)
        .after(&["start-up.before-cfg"]),
    Check::new("start-up.faulty-prm-ends", "3.2", "a faulty Set_Prm ends data exchange", faulty_prm_ends)
        .after(&["start-up.wrong-ident"])
        .unless_broken(&["start-up.prm-again"]),
    Check::new("start-up.faulty-cfg-ends", "3.2", "a faulty Chk_Cfg ends data exchange", faulty_cfg_ends)
        .after(&["start-up.truncated-cfg"]),
];

/// The time that a slave may take to begin data exchange by mistake.
const PAUSE: Duration = Duration::from_millis(50);

/// A Set_Prm with another ident number.
pub fn faulty_prm<'a>(dialogue: &Dialogue<'a>) -> SetPrm<'a> {
    let prm = dialogue.prm([0, 0]);
    SetPrm { ident: prm.ident ^ 0x0101, ..prm }
}

/// The configuration under test with further octets.
fn extended_cfg(dialogue: &Dialogue<'_>, further: u8) -> Vec<u8> {
    dialogue.slave.cfg.iter().copied().chain([further]).collect()
}

/// The configuration under test and an identifier without its two length octets, which even a slave that adapts itself must
/// refuse (profibus-wire 2.6.4).
pub fn truncated_cfg(dialogue: &Dialogue<'_>) -> Vec<u8> {
    const TWO_LENGTHS: u8 = 0xC0;
    extended_cfg(dialogue, TWO_LENGTHS)
}

/// The configuration under test with an octet of inputs and an octet of outputs more.
fn longer_cfg(dialogue: &Dialogue<'_>) -> Vec<u8> {
    const IN_AND_OUT: u8 = 0x30;
    extended_cfg(dialogue, IN_AND_OUT)
}

fn set_prm(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.expect_acknowledged(Sap::SetPrm, &set_prm_octets(&dialogue.prm([0, 0]))).tested()
}

fn chk_cfg(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.parameterise()?;
    dialogue.expect_acknowledged(Sap::ChkCfg, &dialogue.slave.cfg).tested()
}

fn exchange(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().tested()
}

fn unlock(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    dialogue.release()?;
    dialogue.expect_no_exchange().tested()
}

fn refused(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    let outputs = dialogue.outputs();
    dialogue.expect_closed(dialogue.own_address(), Sap::Default, &outputs, Closed::NotExchanging).tested()
}

fn no_owner(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.diagnosis().prepared()?.require_master(NO_MASTER).tested()
}

fn prm_req(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.diagnosis().prepared()?.require_set(StationStatus::PRM_REQ).tested()
}

fn not_ready(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.diagnosis().prepared()?.require_set(StationStatus::STATION_NOT_READY).tested()
}

fn owner(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.parameterise()?;
    dialogue.diagnosis().prepared()?.require_master(dialogue.own_address()).tested()
}

fn parameterised(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.parameterise()?;
    dialogue.diagnosis().prepared()?.require_clear(StationStatus::PRM_REQ).tested()
}

fn waits_for_cfg(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.parameterise()?;
    dialogue.diagnosis().prepared()?.require_set(StationStatus::STATION_NOT_READY).tested()
}

fn before_cfg(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.parameterise()?;
    dialogue.wait(PAUSE)?;
    dialogue.expect_no_exchange().tested()
}

fn ready(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    dialogue.diagnosis().prepared()?.require_clear(StationStatus::STATION_NOT_READY).tested()
}

fn cfg_before_prm(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.chk_cfg()?;
    dialogue.wait(PAUSE)?;
    dialogue.expect_no_exchange().tested()
}

fn no_lock(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.set_prm(&SetPrm { status: PrmStatus::empty(), ..dialogue.prm([0, 0]) })?;
    dialogue.diagnosis().prepared()?.require_master(NO_MASTER).tested()
}

fn both_locks(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    dialogue.set_prm(&SetPrm { status: PrmStatus::LOCK_REQ | PrmStatus::UNLOCK_REQ, ..dialogue.prm([0, 0]) })?;
    // A slave that takes it for Lock_Req alone waits for its configuration.
    dialogue.chk_cfg()?;
    dialogue.wait(PAUSE)?;
    dialogue.expect_no_exchange().tested()
}

fn wrong_ident(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.set_prm(&faulty_prm(dialogue))?;
    dialogue.chk_cfg()?;
    dialogue.wait(PAUSE)?;
    dialogue.expect_no_exchange().tested()
}

fn prm_fault(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.set_prm(&faulty_prm(dialogue))?;
    dialogue.diagnosis().prepared()?.require_set(StationStatus::PRM_FAULT).tested()
}

fn prm_fault_acknowledged(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.expect_acknowledged(Sap::SetPrm, &set_prm_octets(&faulty_prm(dialogue))).tested()
}

fn prm_fault_ended(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.set_prm(&faulty_prm(dialogue))?;
    dialogue.set_prm(&dialogue.prm([0, 0]))?;
    dialogue.diagnosis().prepared()?.require_clear(StationStatus::PRM_FAULT).tested()
}

fn short_prm(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    let octets = set_prm_octets(&dialogue.prm([0, 0]));
    dialogue.tell(Sap::SetPrm, octets.get(..6).unwrap_or_default())?;
    dialogue.diagnosis().prepared()?.require_set(StationStatus::PRM_FAULT).tested()
}

fn truncated(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.parameterise()?;
    dialogue.tell(Sap::ChkCfg, &truncated_cfg(dialogue))?;
    dialogue.wait(PAUSE)?;
    dialogue.expect_no_exchange().tested()
}

fn other_cfg(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let other = longer_cfg(dialogue);
    dialogue.parameterise()?;
    dialogue.tell(Sap::ChkCfg, &other)?;
    dialogue.wait(PAUSE)?;
    match dialogue.request(Sap::GetCfg, &[]) {
        Ok(answer) if answer.du == other => return Err(CheckError::NotTested(Reason::Adapts)),
        Ok(_) | Err(StepError::Unexpected(_)) => {}
        Err(StepError::Port(error)) => return Err(error.into()),
    }
    // A slave that accepts it may expect the outputs of either configuration.
    let longer: Vec<_> = dialogue.outputs().into_iter().chain([0]).collect();
    for outputs in [dialogue.outputs(), longer] {
        let exchanging = dialogue.is_exchanging_with(dialogue.own_address(), &outputs)?;
        require(!exchanging, Expected::NoExchange).tested()?;
    }
    Ok(())
}

fn cfg_fault(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.parameterise()?;
    dialogue.tell(Sap::ChkCfg, &truncated_cfg(dialogue))?;
    dialogue.diagnosis().prepared()?.require_set(StationStatus::CFG_FAULT).tested()
}

fn cfg_fault_acknowledged(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.parameterise()?;
    dialogue.expect_acknowledged(Sap::ChkCfg, &truncated_cfg(dialogue)).tested()
}

fn cfg_fault_ended(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.parameterise()?;
    dialogue.tell(Sap::ChkCfg, &truncated_cfg(dialogue))?;
    dialogue.set_prm(&dialogue.prm([0, 0]))?;
    dialogue.diagnosis().prepared()?.require_clear(StationStatus::CFG_FAULT).tested()
}

fn cfg_again(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    dialogue.chk_cfg()?;
    dialogue.await_exchange().tested()
}

fn prm_again(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    dialogue.set_prm(&dialogue.prm([0, 0]))?;
    dialogue.expect_no_exchange().tested()
}

fn faulty_prm_ends(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    dialogue.set_prm(&faulty_prm(dialogue))?;
    dialogue.expect_no_exchange().tested()
}

fn faulty_cfg_ends(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    dialogue.tell(Sap::ChkCfg, &truncated_cfg(dialogue))?;
    dialogue.expect_no_exchange().tested()
}
