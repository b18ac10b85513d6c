//! MS2, where the slave has it. profibus-wire 4.

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
    Check { name: "ms2.foreign", rule: "a connection is closed to everybody else", section: "4.2", run: foreign },
    Check {
        name: "ms2.refusal",
        rule: "a record that is not there is refused with a DP-V1 error of the access class",
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
        rule: "a PDU that is none ends the connection with Abort",
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

/// Opens a connection and returns its access point.
fn open(talk: &mut Dialogue<'_>) -> CheckOutcome<u8> {
    let end = AddAddr::default();
    let initiate =
        Initiate { send_timeout: SEND_TIMEOUT, capabilities: Capabilities::READ_WRITE, source: end, destination: end };
    let manager = Sap::ResourceManager;
    let mut du = [0; 32];
    let length = Request::Initiate(initiate).emit(&mut du).unwrap_or_default();
    let opened = match talk.request(manager, du.get(..length).unwrap_or_default())? {
        Answer::Frame { status: Status::DataLow, du } => du,
        // Polled for, profibus-wire 4.6.1.
        Answer::ShortAck => talk.data_from(talk.own_address(), manager)?,
        Answer::Frame { status: Status::ServiceNotActivated, .. } => {
            return Err(CheckError::NotApplicable("the slave has no MS2"));
        }
        Answer::Frame { .. } => return violated("DL with the access point of the connection, or RS"),
    };
    let Response::ResourceManager(manager) = response(&opened)? else { return violated("the resource manager's PDU") };
    require(manager.server_sap <= 48, "an access point from 0 to 48")?;
    let answer = polled(talk, manager.server_sap)?;
    require(matches!(response(&answer)?, Response::Initiate(_)), "Initiate.res")?;
    Ok(manager.server_sap)
}

/// The response that waits, or will.
fn polled(talk: &mut Dialogue<'_>, sap: u8) -> CheckOutcome<Vec<u8>> {
    for _ in 0..100 {
        match talk.request(Sap::Ms2(sap), &[])? {
            Answer::Frame { status: Status::DataLow, du } => return Ok(du),
            Answer::ShortAck => talk.wait(std::time::Duration::from_millis(10))?,
            Answer::Frame { .. } => break,
        }
    }
    violated("SC until there is a response, then DL")
}

/// Ends a connection.
fn close(talk: &mut Dialogue<'_>, sap: u8) -> CheckOutcome {
    let mut du = [0; 8];
    let length = Request::Abort(Abort::new(AbortReason::User(0))).emit(&mut du).unwrap_or_default();
    let answer = talk.request(Sap::Ms2(sap), du.get(..length).unwrap_or_default())?;
    require(answer == Answer::ShortAck, "SC")?;
    talk.expect_closed(Sap::Ms2(sap), &[], "RS: the connection is closed")
}

fn opens(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(talk)?;
    let nothing = talk.request(Sap::Ms2(sap), &[])?;
    require(nothing == Answer::ShortAck, "SC: no response is waiting")?;
    close(talk, sap)
}

fn idle(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(talk)?;
    let echo = talk.ms2(sap, &Request::Idle(&[]))?;
    require(echo == [0x48], "48")?;
    close(talk, sap)
}

fn foreign(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(talk)?;
    let other = talk.other_master_address();
    talk.expect_status_from(
        other,
        Sap::Ms2(sap),
        &[],
        Status::ServiceNotActivated,
        "RS: the connection is not its own",
    )?;
    close(talk, sap)
}

fn refusal(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(talk)?;
    let du = talk.ms2(sap, &Request::Read(Access { slot: NO_SLOT, index: 1, length: 240 }))?;
    let Response::Negative(negative) = response(&du)? else { return violated("a negative response: DE 80 B2 00") };
    require(negative.code_1.class() == ACCESS_CLASS, "an error of the access class, like B2 (invalid slot)")?;
    close(talk, sap)
}

fn abort(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(talk)?;
    close(talk, sap)
}

fn unknown_function(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let sap = open(talk)?;
    let answer = talk.request(Sap::Ms2(sap), &[0x33, 0, 0, 0])?;
    let du = match answer {
        Answer::Frame { status: Status::DataLow, du } => du,
        Answer::ShortAck => polled(talk, sap)?,
        Answer::Frame { .. } => return violated("SC, then Abort"),
    };
    require(matches!(response(&du)?, Response::Abort(_)), "Abort")?;
    talk.expect_closed(Sap::Ms2(sap), &[], "RS: the connection is closed")
}
