//! The first answers of a slave (profibus-wire 1.11, 2.3 and 1.9).

use super::Check;
use crate::dialogue::{CheckOutcome, Dialogue, FDL_STATUS, Step, StepError, StepResult, octets, parse_answer, require};
use crate::expected::Expected;
use crate::probe::Received;
use profivac_wire::control::{Control, FrameCount, Status};
use profivac_wire::sap::MASTER_MS0;
use profivac_wire::{Sap, Telegram};

pub const CHECKS: &[Check] = &[
    Check::new("layer2.fdl-status", "1.11", "FDL status is answered with status OK", fdl_status_is_ok),
    Check::new("layer2.station-type", "1.5", "the answer to FDL status names a passive station", station_type)
        .after(&["layer2.fdl-status"]),
    Check::new("layer2.addresses", "1.3", "an answer has the addresses of the request, swapped", addresses)
        .after(&["layer2.fdl-status"]),
    Check::new(super::FIRST_REQUEST, "1.9", "a first request is executed, whatever the last frame count bit", first),
    Check::new("diagnosis.answer", "2.3", "Slave_Diag is answered with a diagnosis of 6 to 244 octets", diagnosis),
    Check::new("layer2.access-points", "1.3", "data have the access points of the request, swapped", access_points)
        .after(&["diagnosis.answer"]),
];

/// The telegram FDL status.
pub fn fdl_status_telegram(da: u8, sa: u8) -> Vec<u8> {
    octets(da, sa, Sap::Default, FDL_STATUS, &[])
}

/// The head of an answer.
struct Head {
    da: u8,
    sa: u8,
    fc: u8,
}

/// Sends FDL status, which the slave must answer.
pub fn fdl_status(dialogue: &mut Dialogue<'_>) -> StepResult {
    fdl_status_head(dialogue).map(|_| ())
}

/// Sends FDL status. Returns the head of the answer if it is a response without data.
fn fdl_status_head(dialogue: &mut Dialogue<'_>) -> StepResult<Head> {
    let received = dialogue.send(&fdl_status_telegram(dialogue.slave.address, dialogue.own_address()))?;
    if let Received::Telegram(octets) = received
        && let Ok(Telegram::Data(data)) = Telegram::parse(&octets)
        && let Control::Response { status: Status::Ok, .. } = data.control()
        && data.du.is_empty()
    {
        return Ok(Head { da: data.da, sa: data.sa, fc: data.fc });
    }
    Err(StepError::Unexpected(Expected::FdlStatus))
}

fn fdl_status_is_ok(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    fdl_status(dialogue).tested()
}

fn station_type(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let answer = fdl_status_head(dialogue).prepared()?;
    require(answer.fc & 0x30 == 0, Expected::PassiveStation).tested()
}

fn addresses(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let answer = fdl_status_head(dialogue).prepared()?;
    let (da, sa) = (dialogue.own_address(), dialogue.slave.address);
    require((answer.da, answer.sa) == (da, sa), Expected::Addresses { da, sa }).tested()
}

fn diagnosis(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.diagnosis_octets(dialogue.own_address()).map(|_| ()).tested()
}

fn access_points(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.diagnosis_octets(dialogue.own_address()).prepared()?;
    let cycle = dialogue.take_last();
    let found = cycle.as_ref().and_then(|cycle| access_points_of(&cycle.received));
    dialogue.show(cycle);
    let (dsap, ssap) = (Some(MASTER_MS0), Sap::SlaveDiag.to_octet());
    require(found == Some((dsap, ssap)), Expected::AccessPoints { dsap, ssap }).tested()
}

/// DSAP and SSAP of a data telegram.
fn access_points_of(received: &Received) -> Option<(Option<u8>, Option<u8>)> {
    let Received::Telegram(octets) = received else { return None };
    match Telegram::parse(octets) {
        Ok(Telegram::Data(data)) => Some((data.dsap, data.ssap)),
        Ok(Telegram::ShortAck | Telegram::Token { .. }) | Err(_) => None,
    }
}

/// Two first requests to different services: a slave that takes the second one for a repetition sends the answer of the first.
fn first(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let diagnosis = dialogue.counted(FrameCount::First, Sap::SlaveDiag, &[])?;
    let configuration = dialogue.counted(FrameCount::First, Sap::GetCfg, &[])?;
    // Two refusals may be equal.
    let answer = parse_answer(&diagnosis).prepared()?;
    require(answer.has_data_status() || answer.is_acknowledgement(), Expected::Diagnosis).prepared()?;
    require(diagnosis != configuration, Expected::NewAnswer).tested()
}
