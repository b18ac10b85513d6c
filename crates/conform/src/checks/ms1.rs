//! MS1, if the parameters under test open it (profibus-wire 4.2 and 4.3).

use super::Check;
use crate::dialogue::{Answer, CheckOutcome, Dialogue, Step, StepError, request_octets, require, response, without};
use crate::expected::{Closed, Expected, Pdu, Service};
use profivac_wire::Sap;
use profivac_wire::acyclic::{Access, ErrorDecode, Function, Negative, Request, Response};
use profivac_wire::control::Status;

const POLL: &str = "ms1.poll";

pub const CHECKS: &[Check] = &[
    Check::new("ms1.closed", "4.3", "MS1 is closed outside data exchange", closed)
        .after(&["start-up.unlock", "layer2.closed"]),
    Check::new(POLL, "4.2", "MS1 without a response answers a poll with SC", poll).after(&["start-up.exchange"]),
    Check::new("ms1.foreign", "4.3", "MS1 is closed to other masters", foreign)
        .after(&[POLL, "layer2.closed"])
        .unless_broken(&["lock.set-prm", "diagnosis.any-master"]),
    Check::new("ms1.refusal", "4.1.2", "Read of a slot that does not exist has a negative response", refusal)
        .after(&[POLL]),
    Check::new("ms1.low-priority", "4.2", "responses of MS1 have low priority", low_priority).after(&["ms1.refusal"]),
    Check::new("ms1.error-decode", "4.1.2", "a negative response of MS1 has an error of DP-V1", error_decode)
        .after(&["ms1.refusal"]),
];

/// A slot that no device has.
pub const NO_SLOT: u8 = 254;

/// Read of a record that no device has.
pub const READ_NOTHING: Request<'static> = Request::Read(Access { slot: NO_SLOT, index: 1, length: 240 });

/// The negative response to Read in `answer`.
pub fn read_refusal(answer: &Answer) -> Result<Negative, StepError> {
    require(answer.has_data_status(), Expected::Pdu(Pdu::ReadRefusal))?;
    match response(&answer.du, Pdu::ReadRefusal)? {
        Response::Negative(negative) if negative.function == Function::Read => Ok(negative),
        _ => Err(StepError::Unexpected(Expected::Pdu(Pdu::ReadRefusal))),
    }
}

/// Requires an error of DP-V1 in a negative response.
pub fn require_dpv1_error(negative: &Negative) -> CheckOutcome {
    require(negative.decode == ErrorDecode::DpV1, Expected::Pdu(Pdu::Dpv1Error)).tested()
}

fn closed(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    let own = dialogue.own_address();
    dialogue.expect_closed(own, Sap::Ms1, &request_octets(&READ_NOTHING), Closed::NotExchanging).tested()
}

pub(super) fn poll(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    match dialogue.request(Sap::Ms1, &[]) {
        Ok(answer) if answer.is_closed() => without(Service::Ms1),
        Ok(answer) => require(answer.is_acknowledgement(), Expected::Acknowledgement).tested(),
        Err(error) => Err(error).prepared(),
    }
}

fn foreign(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let other = dialogue.other_master_address();
    dialogue.expect_closed(other, Sap::Ms1, &[], Closed::OtherMaster).tested()
}

fn refusal(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let answer = dialogue.acyclic(Sap::Ms1, &READ_NOTHING).tested()?;
    read_refusal(&answer).map(|_| ()).tested()
}

fn low_priority(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let answer = dialogue.acyclic(Sap::Ms1, &READ_NOTHING).prepared()?;
    require(answer.status == Status::DataLow, Expected::DataLow).tested()
}

fn error_decode(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let answer = dialogue.acyclic(Sap::Ms1, &READ_NOTHING).prepared()?;
    require_dpv1_error(&read_refusal(&answer).prepared()?)
}
