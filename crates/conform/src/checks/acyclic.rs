//! MS2, if the slave has it (profibus-wire 4).

use super::Check;
use crate::dialogue::{Answer, CheckError, CheckOutcome, Dialogue, require, response, violated};
use profivac_wire::Sap;
use profivac_wire::acyclic::initiate::{AddAddr, Capabilities};
use profivac_wire::acyclic::{Abort, AbortReason, Access, Initiate, Request, Response};
use profivac_wire::control::Status;

pub const CHECKS: &[Check] = &[
    Check {
        name: "ms2.open",
        rule: "Initiate opens a connection on an access point of its own",
        section: "4.6",
        run: opens,
    },
    Check { name: "ms2.idle", rule: "Idle is echoed", section: "4.7", run: idle },
    Check { name: "ms2.foreign", rule: "a connection is closed to other masters", section: "4.2", run: foreign },
    Check {
        name: "ms2.refusal",
        rule: "a record that does not exist is refused with a DP-V1 error of the access class",
        section: "4.1.2",
        run: refusal,
    },
    Check {
        name: "ms2.abort",
        rule: "Abort is acknowledged, and the connection is closed",
        section: "4.8",
        run: abort,
    },
    Check {
        name: "ms2.unknown-function",
        rule: "an unknown PDU ends the connection with Abort",
        section: "4.12",
        run: unknown_function,
    },
];

/// Send_Timeout in 10 ms.
const SEND_TIMEOUT: u16 = 500;

/// A slot that no device has.
const NO_SLOT: u8 = 254;

/// Error_Class 11 of DP-V1: access.
const ACCESS_CLASS: u8 = 0xB;

/// Opens a connection. Returns its access point.
fn open(dialogue: &mut Dialogue<'_>) -> CheckOutcome<u8> {
    let end = AddAddr::default();
    let initiate =
        Initiate { send_timeout: SEND_TIMEOUT, capabilities: Capabilities::READ_WRITE, source: end, destination: end };
    let manager = Sap::ResourceManager;
    let mut du = [0; 32];
    let length = Request::Initiate(initiate).emit(&mut du).unwrap_or_default();
    let opened = match dialogue.request(manager, du.get(..length).unwrap_or_default())? {
        Answer::Data { status: Status::DataLow, du } => du,
        // The master polls for the response (profibus-wire 4.6.1).
        Answer::ShortAck => dialogue.data_from(dialogue.own_address(), manager)?,
        Answer::Data { status: Status::ServiceNotActivated, .. } => {
            return Err(CheckError::NotApplicable { reason: "the slave has no MS2" });
        }
        Answer::Data { .. } => return violated("DL with the access point of the connection, or RS"),
    };
    let Response::ResourceManager(manager) = response(&opened)? else { return violated("the resource manager's PDU") };
    require(manager.server_sap <= 48, "an access point from 0 to 48")?;
    let answer = polled(dialogue, manager.server_sap)?;
    require(matches!(response(&answer)?, Response::Initiate(_)), "Initiate.res")?;
    Ok(manager.server_sap)
}

/// Polls for a response.
fn polled(dialogue: &mut Dialogue<'_>, sap: u8) -> CheckOutcome<Vec<u8>> {
    for _ in 0..100 {
        match dialogue.request(Sap::Ms2(sap), &[])? {
            Answer::Data { status: Status::DataLow, du } => return Ok(du),
            Answer::ShortAck => dialogue.wait(std::time::Duration::from_millis(10))?,
            Answer::Data { .. } => break,
        }
    }
    violated("SC until there is a response, then DL")
}

/// Closes a connection.
fn close(dialogue: &mut Dialogue<'_>, sap: u8) -> CheckOutcome {
    let mut du = [0; 8];
    let length = Request::Abort(Abort::new(AbortReason::User(0))).emit(&mut du).unwrap_or_default();
    let answer = dialogue.request(Sap::Ms2(sap), du.get(..length).unwrap_or_default())?;
    require(answer == Answer::ShortAck, "SC")?;
    dialogue.expect_closed(Sap::Ms2(sap), &[], "RS: the connection is closed")
}

fn opens(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(dialogue)?;
    let answer = dialogue.request(Sap::Ms2(sap), &[])?;
    require(answer == Answer::ShortAck, "SC: no response is waiting")?;
    close(dialogue, sap)
}

fn idle(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(dialogue)?;
    let echo = dialogue.ms2(sap, &Request::Idle(&[]))?;
    require(echo == [0x48], "48")?;
    close(dialogue, sap)
}

fn foreign(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(dialogue)?;
    let other = dialogue.other_master_address();
    dialogue.expect_status_from(
        other,
        Sap::Ms2(sap),
        &[],
        Status::ServiceNotActivated,
        "RS: the connection belongs to another master",
    )?;
    close(dialogue, sap)
}

fn refusal(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(dialogue)?;
    let du = dialogue.ms2(sap, &Request::Read(Access { slot: NO_SLOT, index: 1, length: 240 }))?;
    let Response::Negative(negative) = response(&du)? else { return violated("a negative response: DE 80 B2 00") };
    require(negative.code_1.class() == ACCESS_CLASS, "an error of the access class, like B2 (invalid slot)")?;
    close(dialogue, sap)
}

fn abort(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(dialogue)?;
    close(dialogue, sap)
}

fn unknown_function(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(dialogue)?;
    let answer = dialogue.request(Sap::Ms2(sap), &[0x33, 0, 0, 0])?;
    let du = match answer {
        Answer::Data { status: Status::DataLow, du } => du,
        Answer::ShortAck => polled(dialogue, sap)?,
        Answer::Data { .. } => return violated("SC, then Abort"),
    };
    require(matches!(response(&du)?, Response::Abort(_)), "Abort")?;
    dialogue.expect_closed(Sap::Ms2(sap), &[], "RS: the connection is closed")
}
