//! MS2, if the slave has it (profibus-wire 4).

use super::Check;
use super::ms1::{READ_NOTHING, read_refusal, require_dpv1_error};
use crate::dialogue::{
    Answer, CheckError, CheckOutcome, Dialogue, Step, StepError, StepResult, parse_answer, request_octets, require,
    require_same, response, telegram_octets, without,
};
use crate::expected::{Closed, Expected, Pdu, Reason, Service};
use profivac_wire::acyclic::initiate::{AddAddr, Capabilities};
use profivac_wire::acyclic::{Abort, AbortReason, Initiate, InitiateRes, Request, Response};
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::{DataTelegram, Sap};
use std::time::Duration;

const MANAGER: &str = "ms2.manager";
const INITIATE: &str = "ms2.initiate";
const CLOSES: &str = "ms2.abort-closes";
const IDLE: &str = "ms2.idle";
const REFUSAL: &str = "ms2.refusal";
const UNKNOWN: &str = "ms2.unknown-function";
const CLOSED: &str = "layer2.closed";

pub const CHECKS: &[Check] = &[
    Check::new(MANAGER, "4.6.2", "the resource manager answers Initiate with an access point from 0 to 48", manager),
    Check::new(CLOSES, "4.8", "Abort closes the connection", abort_closes).after(&[MANAGER, CLOSED]),
    Check::new(INITIATE, "4.6.4", "the access point has a positive response to Initiate", initiate).after(&[CLOSES]),
    Check::new("ms2.abort", "4.8", "Abort is acknowledged with SC", abort).after(&[INITIATE]),
    Check::new("ms2.record-length", "4.6.4", "the longest record has 1 to 240 octets", record_length)
        .after(&[INITIATE]),
    Check::new("ms2.poll", "4.2", "MS2 without a response answers a poll with SC", poll)
        .after(&[INITIATE])
        .unless_broken(&["ms1.poll"]),
    Check::new(IDLE, "4.7", "Idle is echoed", idle).after(&[INITIATE]),
    Check::new("ms2.low-priority", "4.2", "responses of MS2 have low priority", low_priority)
        .after(&[IDLE])
        .unless_broken(&["ms1.low-priority"]),
    Check::new("ms2.repeated-poll", "4.2", "a repeated poll gets the same response", repeated_poll)
        .after(&[IDLE, "count.repetition"]),
    Check::new("ms2.undisturbed", "1.9", "a request of another master leaves the response as it is", undisturbed)
        .after(&[IDLE]),
    Check::new("ms2.foreign", "4.2", "a connection is closed to other masters", foreign)
        .after(&[INITIATE])
        .unless_broken(&["ms1.foreign", "diagnosis.any-master"]),
    Check::new("ms2.foreign-access-point", "4.2", "a connection is closed to other source access points", foreign_sap)
        .after(&[INITIATE]),
    Check::new(REFUSAL, "4.1.2", "Read of a slot that does not exist has a negative response", refusal)
        .after(&[INITIATE])
        .unless_broken(&["ms1.refusal"]),
    Check::new("ms2.error-decode", "4.1.2", "a negative response of MS2 has an error of DP-V1", error_decode)
        .after(&[REFUSAL])
        .unless_broken(&["ms1.error-decode"]),
    Check::new("ms2.error-class", "4.1.3", "a slot that does not exist is an error of the access class", error_class)
        .after(&["ms2.error-decode"]),
    Check::new(UNKNOWN, "4.10", "an unknown function is answered with Abort", unknown_function).after(&[INITIATE]),
    Check::new("ms2.abort-ends", "4.8", "an Abort of the slave closes the connection", abort_ends).after(&[UNKNOWN]),
    Check::new("ms2.exchange", "4.6", "a connection works during data exchange and does not end it", exchange)
        .after(&[IDLE, "start-up.exchange"]),
];

/// Send_Timeout in 10 ms.
const SEND_TIMEOUT: u16 = 500;

/// Error_Class 11 of DP-V1: access.
const ACCESS_CLASS: u8 = 0xB;

/// The polls for a response, and the pause between them.
const POLLS: usize = 50;
const POLL_PAUSE: Duration = Duration::from_millis(10);

/// No function of DP-V1.
const UNKNOWN_PDU: [u8; 4] = [0x33, 0, 0, 0];

const fn initiate_request() -> Request<'static> {
    const END: AddAddr<'static> = AddAddr { api: 0, scl: 0, network: None };
    Request::Initiate(Initiate {
        send_timeout: SEND_TIMEOUT,
        capabilities: Capabilities::READ_WRITE,
        source: END,
        destination: END,
    })
}

/// Sends Initiate. Returns the answer of access point 49, for which a master may have to poll (profibus-wire 4.6.1).
fn answer_of_manager(dialogue: &mut Dialogue<'_>) -> StepResult<Answer> {
    dialogue.acyclic(Sap::ResourceManager, &initiate_request())
}

/// The access point that the resource manager names.
fn parse_manager(answer: &Answer) -> StepResult<Sap> {
    require(answer.has_data_status(), Expected::Pdu(Pdu::ResourceManager))?;
    match response(&answer.du, Pdu::ResourceManager)? {
        // An access point above 48 belongs to another service, to which no check may send.
        Response::ResourceManager(manager) if manager.server_sap <= 48 => Ok(Sap::Ms2(manager.server_sap)),
        _ => Err(StepError::Unexpected(Expected::Pdu(Pdu::ResourceManager))),
    }
}

fn parse_initiate(answer: &Answer) -> StepResult<InitiateRes<'_>> {
    require(answer.has_data_status(), Expected::Pdu(Pdu::Initiate))?;
    match response(&answer.du, Pdu::Initiate)? {
        Response::Initiate(initiate) => Ok(initiate),
        _ => Err(StepError::Unexpected(Expected::Pdu(Pdu::Initiate))),
    }
}

/// Requests a connection. Returns its access point.
fn request_connection(dialogue: &mut Dialogue<'_>) -> CheckOutcome<Sap> {
    let answer = answer_of_manager(dialogue).prepared()?;
    parse_manager(&answer).prepared()
}

/// Opens a connection, runs `test` with its access point, and closes the connection whatever the result is.
fn with_connection(
    dialogue: &mut Dialogue<'_>,
    test: impl FnOnce(&mut Dialogue<'_>, Sap) -> CheckOutcome,
) -> CheckOutcome {
    let sap = request_connection(dialogue)?;
    let answer = dialogue.poll(sap).prepared()?;
    parse_initiate(&answer).map(|_| ()).prepared()?;
    let result = test(dialogue, sap);
    close(dialogue, sap, result)
}

/// Closes a connection and returns `result`, which is shown with the message cycle before.
fn close(dialogue: &mut Dialogue<'_>, sap: Sap, result: CheckOutcome) -> CheckOutcome {
    let cycle = dialogue.take_last();
    dialogue.tell(sap, &abort_octets())?;
    dialogue.show(cycle);
    result
}

fn abort_octets() -> Vec<u8> {
    request_octets(&Request::Abort(Abort::new(AbortReason::User(0))))
}

pub(super) fn manager(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let answer = match dialogue.request(Sap::ResourceManager, &request_octets(&initiate_request())) {
        Ok(answer) if answer.is_closed() => return without(Service::Ms2),
        Ok(answer) if answer.is_acknowledgement() => dialogue.poll(Sap::ResourceManager).tested()?,
        Ok(answer) => answer,
        // A slave that is silent on closed access points breaks another rule.
        Err(error) => return Err(error).prepared(),
    };
    let sap = parse_manager(&answer).tested()?;
    close(dialogue, sap, Ok(()))
}

fn initiate(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = request_connection(dialogue)?;
    let answer = dialogue.poll(sap).tested();
    let result = answer.and_then(|answer| parse_initiate(&answer).map(|_| ()).tested());
    close(dialogue, sap, result)
}

fn record_length(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = request_connection(dialogue)?;
    let answer = dialogue.poll(sap).prepared()?;
    let length = parse_initiate(&answer).prepared()?.max_len_data_unit;
    let result = require((1..=240).contains(&length), Expected::RecordLength).tested();
    close(dialogue, sap, result)
}

fn abort(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = request_connection(dialogue)?;
    dialogue.poll(sap).prepared()?;
    dialogue.expect_acknowledged(sap, &abort_octets()).tested()
}

/// The check before has aborted a connection. A slave with one connection has no other one if that is still open.
fn abort_closes(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let answer = answer_of_manager(dialogue).tested()?;
    let sap = parse_manager(&answer).tested()?;
    dialogue.tell(sap, &[])?;
    dialogue.tell(sap, &abort_octets())?;
    dialogue.expect_closed(dialogue.own_address(), sap, &[], Closed::NoConnection).tested()
}

fn poll(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_connection(dialogue, |dialogue, sap| dialogue.expect_acknowledged(sap, &[]).tested())
}

/// Sends Idle. Returns the answer with its echo.
fn echo(dialogue: &mut Dialogue<'_>, sap: Sap) -> StepResult<Answer> {
    let answer = dialogue.acyclic(sap, &Request::Idle(&[]))?;
    require(answer.has_data_status() && answer.du == [0x48], Expected::Pdu(Pdu::Idle))?;
    Ok(answer)
}

fn idle(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_connection(dialogue, |dialogue, sap| echo(dialogue, sap).map(|_| ()).tested())
}

fn low_priority(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_connection(dialogue, |dialogue, sap| {
        let answer = echo(dialogue, sap).prepared()?;
        require(answer.status == Status::DataLow, Expected::DataLow).tested()
    })
}

/// A slave that does not keep its answer has lost the response at the second poll, which has the same frame count bit.
fn repeated_poll(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_connection(dialogue, |dialogue, sap| {
        dialogue.counted(FrameCount::First, Sap::SlaveDiag, &[])?;
        let idle = request_octets(&Request::Idle(&[]));
        // The response may come at once (profibus-wire 4.2), or after some polls.
        let telegrams = std::iter::once(idle).chain(std::iter::repeat_n(Vec::new(), POLLS));
        for (du, bit) in telegrams.zip([false, true].into_iter().cycle()) {
            let fetched = dialogue.counted(FrameCount::Counted(bit), sap, &du)?;
            if !parse_answer(&fetched).prepared()?.has_data_status() {
                dialogue.wait(POLL_PAUSE)?;
                continue;
            }
            let repeated = dialogue.counted(FrameCount::Counted(bit), sap, &du)?;
            return require_same(repeated, fetched).tested();
        }
        Err(StepError::Unexpected(Expected::Pdu(Pdu::Response))).prepared()
    })
}

fn undisturbed(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_connection(dialogue, |dialogue, sap| {
        let answer = dialogue.request(sap, &request_octets(&Request::Idle(&[]))).prepared()?;
        if answer.has_data_status() {
            return Err(CheckError::NotTested(Reason::RespondsAtOnce));
        }
        dialogue.tell_from(dialogue.other_master_address(), Sap::SlaveDiag, &[])?;
        let answer = dialogue.poll(sap).tested()?;
        require(answer.du == [0x48], Expected::Pdu(Pdu::Idle)).tested()
    })
}

fn foreign(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_connection(dialogue, |dialogue, sap| {
        let other = dialogue.other_master_address();
        dialogue.expect_closed(other, sap, &[], Closed::OtherMaster).tested()
    })
}

fn foreign_sap(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    /// Not that of MS2 on a master.
    const OTHER: u8 = 40;
    with_connection(dialogue, |dialogue, sap| {
        let (da, sa) = (dialogue.slave.address, dialogue.own_address());
        let fc = Control::Request { function: Function::SrdLow, count: dialogue.next_count(sa) }.to_octet();
        let telegram = telegram_octets(DataTelegram { da, sa, dsap: sap.to_octet(), ssap: Some(OTHER), fc, du: &[] });
        let answer = dialogue.transmit(sa, &telegram).tested()?;
        require(answer.is_closed(), Expected::Closed(Closed::OtherAccessPoint)).tested()
    })
}

fn refusal(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_connection(dialogue, |dialogue, sap| {
        let answer = dialogue.acyclic(sap, &READ_NOTHING).tested()?;
        read_refusal(&answer).map(|_| ()).tested()
    })
}

fn error_decode(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_connection(dialogue, |dialogue, sap| {
        let answer = dialogue.acyclic(sap, &READ_NOTHING).prepared()?;
        require_dpv1_error(&read_refusal(&answer).prepared()?)
    })
}

fn error_class(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_connection(dialogue, |dialogue, sap| {
        let answer = dialogue.acyclic(sap, &READ_NOTHING).prepared()?;
        let negative = read_refusal(&answer).prepared()?;
        require(negative.code_1.class() == ACCESS_CLASS, Expected::Pdu(Pdu::AccessError)).tested()
    })
}

fn unknown_function(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_connection(dialogue, |dialogue, sap| {
        let answer = dialogue.acyclic_octets(sap, &UNKNOWN_PDU).tested()?;
        let aborted = matches!(response(&answer.du, Pdu::Abort).tested()?, Response::Abort(_));
        require(aborted, Expected::Pdu(Pdu::Abort)).tested()
    })
}

fn abort_ends(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_connection(dialogue, |dialogue, sap| {
        dialogue.acyclic_octets(sap, &UNKNOWN_PDU).prepared()?;
        dialogue.expect_closed(dialogue.own_address(), sap, &[], Closed::NoConnection).tested()
    })
}

fn exchange(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    with_connection(dialogue, |dialogue, sap| {
        echo(dialogue, sap).map(|_| ()).tested()?;
        dialogue.expect_exchange().tested()
    })
}
