//! What the GSD file of a slave states about it. These rules are tested only if there is a file; what a file does not state is not tested.

use super::exchange::start_with;
use super::{Check, ms1, ms2};
use crate::dialogue::{CheckError, CheckOutcome, Dialogue, Stated, Step, require};
use crate::expected::{Expected, Reason, Service};
use profivac_wire::Sap;
use profivac_wire::prm::{Dpv1Status1, PrmStatus, SetPrm};

const EXCHANGE: &[&str] = &["start-up.exchange"];
const DIAGNOSED_EXCHANGE: &[&str] = &["start-up.exchange", "diagnosis.answer"];

pub const CHECKS: &[Check] = &[
    Check::new("gsd.diagnosis-length", "2.3", "no diagnosis is longer than Max_Diag_Data_Len", diagnosis_length)
        .after(DIAGNOSED_EXCHANGE),
    Check::new("gsd.sync", "2.9", "the slave has Sync if the file has Sync_Mode_supp", sync).after(DIAGNOSED_EXCHANGE),
    Check::new("gsd.freeze", "2.9", "the slave has Freeze if the file has Freeze_Mode_supp", freeze)
        .after(DIAGNOSED_EXCHANGE),
    Check::new("gsd.fail-safe", "2.8", "the slave takes outputs of length 0 if the file has Fail_Safe", fail_safe)
        .after(EXCHANGE),
    Check::new("gsd.ms1", "4.2", "the slave has MS1 if the file has C1_Read_Write_supp", has_ms1).after(EXCHANGE),
    Check::new("gsd.ms2", "4.6", "the slave has MS2 if the file has C2_Read_Write_supp", has_ms2),
];

/// The statement of the file; without it the rule is not tested.
fn stated(dialogue: &Dialogue<'_>, is_stated: impl Fn(&Stated) -> bool) -> CheckOutcome {
    let stated = dialogue.slave.stated.as_ref().filter(|stated| is_stated(stated));
    stated.map(|_| ()).ok_or(CheckError::NotTested(Reason::NotStated))
}

/// A service that the file states: to lack it is the fault here, and any other fault has a rule of its own.
fn present(service: Service, result: CheckOutcome) -> CheckOutcome {
    match result {
        Err(CheckError::NotTested(Reason::Without(_))) => Err(CheckError::Broken(Expected::Stated(service))),
        Err(CheckError::Broken(expected)) => Err(CheckError::NotTested(Reason::Unprepared(expected))),
        result => result,
    }
}

/// Before and during data exchange.
fn diagnosis_length(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let most = dialogue.slave.stated.as_ref().and_then(|stated| stated.max_diag_len);
    let most = usize::from(most.ok_or(CheckError::NotTested(Reason::NotStated))?);
    let own = dialogue.own_address();
    for exchanging in [false, true] {
        if exchanging {
            dialogue.start().prepared()?;
        }
        let octets = dialogue.diagnosis_octets(own).prepared()?;
        require(octets.len() <= most, Expected::DiagnosisUpTo(most)).tested()?;
    }
    Ok(())
}

fn sync(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    stated(dialogue, |stated| stated.sync)?;
    present(Service::Sync, start_with(dialogue, PrmStatus::SYNC_REQ, Service::Sync))
}

fn freeze(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    stated(dialogue, |stated| stated.freeze)?;
    present(Service::Freeze, start_with(dialogue, PrmStatus::FREEZE_REQ, Service::Freeze))
}

/// A DP-V1 slave must have the bit Fail_Safe in its user parameters.
fn fail_safe(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    stated(dialogue, |stated| stated.fail_safe)?;
    let prm = dialogue.prm([0, 0]);
    let mut user = prm.user.to_vec();
    let is_dpv1 = dialogue.slave.stated.as_ref().is_some_and(|stated| stated.dpv1);
    if let Some(status) = user.first_mut().filter(|_| is_dpv1) {
        *status |= Dpv1Status1::FAIL_SAFE.bits();
    }
    dialogue.start_with(&SetPrm { user: &user, ..prm }).prepared()?;
    dialogue.request(Sap::Default, &[]).tested()?;
    dialogue.expect_exchange().tested()
}

/// Without DPV1_Enable in the user parameters the service is closed.
fn has_ms1(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    stated(dialogue, |stated| stated.ms1)?;
    let first = dialogue.slave.user_prm.first().copied().unwrap_or(0);
    if !Dpv1Status1::from_bits_retain(first).contains(Dpv1Status1::DPV1_ENABLE) {
        return Err(CheckError::NotTested(Reason::NotStated));
    }
    present(Service::Ms1, ms1::poll(dialogue))
}

fn has_ms2(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    stated(dialogue, |stated| stated.ms2)?;
    present(Service::Ms2, ms2::manager(dialogue))
}
