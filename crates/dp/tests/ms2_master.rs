//! MS2 at the master: every state against every answer, and the timers. profibus-wire 4.6 to 4.11.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::golden;
use crate::ms2_search::{CLOSED, search_down_to};
use crate::support;

use profivac_dp::link::active::Failure;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::ms2::{self, Connect, RequestError};
use profivac_dp::master::{Cause, ConnectionEnd, Handle, Master, Ms2Parameters, Phase, Settings, SubmitError};
use profivac_wire::acyclic::AbortReason;
use profivac_wire::control::Status;
use profivac_wire::{DataTelegram, Telegram};
use std::fmt::Write as _;
use support::rig::MasterRig;
use support::{bus, hex};

pub const BAUD: Baud = Baud::B1500000;

pub type Class2Rig = MasterRig<Master<0, 0>>;

/// T is 1 s, and a slave may be busy twice.
pub fn parameters() -> Ms2Parameters {
    Ms2Parameters { send_timeout: 100, response_timeout: 100, rejections: 2, ..Ms2Parameters::new(BAUD) }
}

pub fn opening() -> (Class2Rig, Handle<Connect>) {
    let mut rig = MasterRig::new(Master::on(bus().check().unwrap(), Settings::new(BAUD), BitTime(0)));
    let connection = rig.station.user.ms2_open(8, &parameters()).unwrap();
    rig.next_request();
    (rig, connection)
}

/// A response of slave 8 from `ssap`, with the function code of `fc`.
fn telegram(fc: u8, ssap: u8, du: &[u8]) -> Vec<u8> {
    let data = DataTelegram { da: 2, sa: 8, dsap: Some(50), ssap: Some(ssap), fc, du };
    let mut octets = [0; 255];
    let length = Telegram::Data(data).emit(&mut octets).unwrap();
    octets[..length].to_vec()
}

/// Sends an answer of the slave: DL with a PDU, SC, a status without data, or nothing.
pub fn answer(rig: &mut Class2Rig, ssap: u8, what: &str) {
    match what.split_once(' ') {
        _ if what == "SC" => rig.receive("E5"),
        _ if what == "RS" => rig.receive("10 02 08 03 0D 16"),
        _ if what == "RR" => rig.receive("10 02 08 02 0C 16"),
        _ if what == "UE" => rig.receive("10 02 08 01 0B 16"),
        _ if what == "silence" => {}
        Some(("DH", pdu)) => rig.receive_octets(11, &telegram(0x0A, ssap, &hex(pdu))),
        Some(("RDL", pdu)) => rig.receive_octets(11, &telegram(0x0C, ssap, &hex(pdu))),
        Some(("RDH", pdu)) => rig.receive_octets(11, &telegram(0x0D, ssap, &hex(pdu))),
        _ => rig.receive_octets(11, &telegram(0x08, ssap, &hex(what))),
    }
}

pub const MANAGER: &str = "56 30 00 64";
pub const INITIATE_RES: &str = "57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00 00";

pub fn open() -> (Class2Rig, Handle<Connect>) {
    let (mut rig, connection) = opening();
    answer(&mut rig, 49, MANAGER);
    rig.next_request();
    answer(&mut rig, 48, INITIATE_RES);
    assert!(matches!(rig.station.user.outcome(connection), Some(Ok(_))));
    (rig, connection)
}

/// The request of a test, if there is one.
pub enum Request {
    None,
    Read(Handle<ms2::Read>),
    Write(Handle<ms2::Write>),
    Transport(Handle<ms2::Transport>),
}

impl Request {
    /// The outcome as the golden prints it; empty if there is none.
    fn outcome(&self, user: &mut Master<0, 0>) -> String {
        let outcome = match self {
            Self::None => None,
            Self::Read(handle) => user.outcome(*handle).map(|it| it.map(|record| format!("read {record:02X?}"))),
            Self::Write(handle) => user.outcome(*handle).map(|it| it.map(|()| "written".to_owned())),
            Self::Transport(handle) => {
                user.outcome(*handle).map(|it| it.map(|data| format!("transported {data:02X?}")))
            }
        };
        match outcome {
            None => String::new(),
            Some(Ok(text)) => format!(", {text}"),
            Some(Err(RequestError::Refused(negative))) => format!(", refused: {}", negative.code_1),
            Some(Err(RequestError::Ended(end))) => format!(", {end}"),
            Some(Err(RequestError::NotExecuted(end))) => format!(", not executed: {end}"),
        }
    }
}

/// The states of a connection, with a message on the line.
#[derive(Clone, Copy, Debug)]
pub enum Stand {
    /// Initiate to the resource manager.
    Initiate,
    /// The resource manager is polled.
    PollManager,
    /// The server is polled for the response to Initiate.
    PollServer,
    /// A request, and a poll for its response.
    Read,
    PollRead,
    Write,
    PollWrite,
    PollTransport,
    Idle,
    PollIdle,
    /// An Abort of the user.
    Aborting,
    /// An Abort to access point 48 in a search.
    Searching,
}

use Stand::{
    Aborting, Idle, Initiate, PollIdle, PollManager, PollRead, PollServer, PollTransport, PollWrite, Read, Searching,
    Write,
};

pub fn stand(at: Stand) -> (Class2Rig, Handle<Connect>, Request) {
    if let Initiate | PollManager | PollServer | Searching = at {
        let (mut rig, connection) = opening();
        match at {
            PollManager => answer(&mut rig, 49, "SC"),
            PollServer => answer(&mut rig, 49, MANAGER),
            Searching => answer(&mut rig, 49, "RS"),
            _ => return (rig, connection, Request::None),
        }
        rig.next_request();
        return (rig, connection, Request::None);
    }
    let (mut rig, connection) = open();
    let user = &mut rig.station.user;
    let request = match at {
        Read | PollRead => Request::Read(user.ms2_read(connection, 1, 16, 8).unwrap()),
        Write | PollWrite => Request::Write(user.ms2_write(connection, 1, 16, &[1, 2]).unwrap()),
        PollTransport => Request::Transport(user.ms2_transport(connection, 1, 16, &[1, 2]).unwrap()),
        Aborting => {
            user.ms2_close(connection).unwrap();
            Request::None
        }
        _ => Request::None,
    };
    rig.next_request();
    if let PollRead | PollWrite | PollTransport | PollIdle = at {
        answer(&mut rig, 48, "SC");
        rig.next_request();
    }
    (rig, connection, request)
}

/// The answers of a slave.
const ANSWERS: [&str; 30] = [
    "SC",
    "RS",
    "RR",
    "UE",
    "silence",
    "DH 5E 01 10 02 AA BB",
    "RDL 5E 01 10 02 AA BB",
    "RDH 5E 01 10 02 AA BB",
    "48",
    "48 00",
    MANAGER,
    "56 31 00 64",
    INITIATE_RES,
    "57 F1 01 00 00 00 00 00 00 02 00 02 00 00 00 00",
    "57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00",
    "D7 80 A9 00",
    "58 00 13",
    "58",
    "5E 01 10 02 AA BB",
    "5E 01 10 00",
    "5E 01 11 02 AA BB",
    "5E 02 10 02 AA BB",
    "5E 01 10 03 AA BB",
    "5E 01 10 09 01 02 03 04 05 06 07 08 09",
    "DE 80 B0 00",
    "5F 01 10 02",
    "5F 01 10 01",
    "DF 80 B7 02",
    "51 01 10 01 CC",
    "5C 01 10 02",
];

/// The result of an answer: the phase, and the outcome if there is one.
fn after(at: Stand, what: &str) -> String {
    let (mut rig, connection, request) = stand(at);
    let ssap = if let Initiate | PollManager = at { 49 } else { 48 };
    if what == "silence" && !matches!(at, Initiate) {
        // The link layer repeats a counted request.
        rig.next_request();
    }
    answer(&mut rig, ssap, what);
    // The slave acknowledges the Abort of the master.
    let next = rig.next_request_within(40_000).map(|sent| sent.octets);
    let sent = next.as_deref().map_or(String::new(), |octets| match octets {
        [0x68, _, _, 0x68, 0x88, 0x82, _, dsap, 0x32, du @ .., _, 0x16] => {
            let du: Vec<String> = du.iter().map(|octet| format!("{octet:02X}")).collect();
            format!(" then to SAP {dsap}: {}", if du.is_empty() { "poll".to_owned() } else { du.join(" ") })
        }
        other => panic!("{other:02X?}"),
    });
    if sent.contains(": 58") {
        answer(&mut rig, 48, "SC");
    }
    let user = &mut rig.station.user;
    let phase = user.ms2_phase(connection).map_or("-".to_owned(), |phase| phase.to_string());
    let mut outcome = request.outcome(user);
    if outcome.is_empty() {
        outcome = match user.outcome(connection) {
            None => String::new(),
            Some(Ok(opened)) => format!(", open at SAP {}", opened.server_sap),
            Some(Err(end)) => format!(", {end}"),
        };
    }
    format!("{phase}{outcome}{sent}")
}

/// profibus-wire 4.11, and the cases that it leaves open.
#[test]
fn every_answer_in_every_state_is_as_in_the_golden() {
    let mut text = String::new();
    let all = [
        Initiate,
        PollManager,
        PollServer,
        Read,
        PollRead,
        Write,
        PollWrite,
        PollTransport,
        Idle,
        PollIdle,
        Aborting,
        Searching,
    ];
    for at in all {
        writeln!(text, "{at:?}").unwrap();
        for what in ANSWERS {
            writeln!(text, "  {what:<50}{}", after(at, what)).unwrap();
        }
    }
    golden::compare("tests/golden/master/ms2_master.txt", &text);
}

/// Answers every message with `what` until the connection ends; returns when and how it ended.
fn until_the_end(rig: &mut Class2Rig, connection: Handle<Connect>, what: &str) -> (BitTime, ConnectionEnd) {
    loop {
        let sent = rig.next_request();
        if sent.text().contains(" 32 58 00 ") {
            rig.receive("E5");
            let Some(Err(end)) = rig.station.user.outcome(connection) else { panic!("ended") };
            return (sent.start, end);
        }
        answer(rig, 48, what);
    }
}

/// An end of the connection by this master.
pub const fn failed(reason: AbortReason, cause: Cause) -> ConnectionEnd {
    ConnectionEnd::Failed { reason, cause }
}

/// One poll takes a millisecond at most, and the next message begins within one more.
const GRAIN: u64 = BAUD.tbit_of_ms(2);

fn is_about(measured: u64, ms: u64) -> bool {
    (BAUD.tbit_of_ms(ms)..BAUD.tbit_of_ms(ms) + GRAIN).contains(&measured)
}

/// A connection with these times, in 10 ms: Send_Timeout asked for, C2_Response_Timeout, least Send_Timeout of the slave.
fn open_with(send_timeout: u16, response_timeout: u16, least: u16) -> (Class2Rig, Handle<Connect>) {
    let mut rig = Class2Rig::new(Master::on(bus().check().unwrap(), Settings::new(BAUD), BitTime(0)));
    let parameters = Ms2Parameters { send_timeout, response_timeout, ..parameters() };
    let connection = rig.station.user.ms2_open(8, &parameters).unwrap();
    rig.next_request();
    answer(&mut rig, 49, &format!("56 30 {:02X} {:02X}", least >> 8, least & 0xFF));
    rig.next_request();
    answer(&mut rig, 48, INITIATE_RES);
    let Some(Ok(opened)) = rig.station.user.outcome(connection) else { panic!("open") };
    assert_eq!(opened.send_timeout, send_timeout.max(least));
    (rig, connection)
}

/// profibus-wire 4.9, rule 2: T is the greater Send_Timeout of both sides.
#[test]
fn idle_follows_t_after_the_last_response_again_and_again() {
    for (asked, least, ms) in [(100, 100, 1000), (10, 100, 1000), (130, 100, 1300), (1, 1, 10)] {
        let (mut rig, connection) = open_with(asked, 1, least);
        for _ in 0..3 {
            let fetched = rig.now;
            let sent = rig.next_request();
            assert!(sent.text().contains(" 30 32 48 "), "{}", sent.text());
            assert!(is_about(sent.start - fetched, ms), "{} after {} ms", sent.start - fetched, ms);
            answer(&mut rig, 48, "SC");
            rig.next_request();
            answer(&mut rig, 48, "48");
        }
        assert_eq!(rig.station.user.ms2_phase(connection), Some(Phase::Open));
    }
}

/// profibus-wire 4.9, rule 4.
#[test]
fn the_wait_for_a_response_is_the_greater_of_c2_response_timeout_and_t() {
    for (asked, response, least, ms) in [(100, 100, 100, 1000), (100, 250, 100, 2500), (10, 20, 100, 1000)] {
        let (mut rig, connection) = open_with(asked, response, least);
        rig.station.user.ms2_read(connection, 1, 16, 8).unwrap();
        let began = rig.now;
        let (ended, end) = until_the_end(&mut rig, connection, "SC");
        assert!(is_about(ended - began, ms), "{} after {ms} ms", ended - began);
        assert_eq!(end, failed(AbortReason::TIMEOUT, Cause::Timeout));
    }
}

/// The server has an Idle timer, and this master supervises that the server answers Idle.
#[test]
fn a_server_that_does_not_answer_idle_ends_the_connection() {
    let (mut rig, connection) = open();
    let sent = rig.next_request();
    answer(&mut rig, 48, "SC");
    let (ended, end) = until_the_end(&mut rig, connection, "SC");
    assert!(is_about(ended - sent.start, 1000));
    assert_eq!(end, failed(AbortReason::TIMEOUT, Cause::Timeout));
}

/// The wait for the response to Initiate is limited as any other; the access point is known, so the master sends an Abort.
#[test]
fn an_unanswered_initiate_ends_in_time() {
    let (mut rig, connection, _) = stand(PollServer);
    answer(&mut rig, 48, "SC");
    let (_, end) = until_the_end(&mut rig, connection, "SC");
    assert_eq!(end, failed(AbortReason::TIMEOUT, Cause::Timeout));
    // The access point of the resource manager's connection is not known: the search begins at 48, where the slave accepts the Abort.
    let (mut rig, connection, _) = stand(PollManager);
    let (began, mut last) = (rig.now, rig.now);
    answer(&mut rig, 49, "SC");
    while let Some(sent) = rig.next_request_within(40_000) {
        last = sent.start;
        answer(&mut rig, 49, "SC");
    }
    assert!((BAUD.tbit_of_ms(990)..BAUD.tbit_of_ms(1001)).contains(&(last - began)), "{}", last - began);
    let end = failed(AbortReason::TIMEOUT, Cause::Timeout);
    assert_eq!(rig.station.user.outcome(connection), Some(Err(end)));
}

/// profibus-wire 4.9, rule 6: polls go on for T.
#[test]
fn a_silent_slave_is_polled_for_t() {
    let (mut rig, connection) = open_with(100, 400, 100);
    rig.station.user.ms2_read(connection, 1, 16, 8).unwrap();
    rig.next_request();
    answer(&mut rig, 48, "SC");
    let began = rig.now;
    let mut polls = 0;
    let ended = loop {
        let sent = rig.next_request();
        match sent.text().contains(" 32 58 00 0F ") {
            true => break sent.start,
            false => polls += 1,
        }
    };
    assert!(polls > 100, "{polls}");
    // A poll without an answer takes two slot times.
    assert!((BAUD.tbit_of_ms(1000)..BAUD.tbit_of_ms(1010)).contains(&(ended - began)), "{}", ended - began);
    while rig.station.user.ms2_phase(connection) != Some(Phase::Ended) {
        rig.next_telegram();
    }
    let end = failed(AbortReason::Fdl(15), Cause::NoAnswer(Failure::Silence));
    assert_eq!(rig.station.user.outcome(connection), Some(Err(end)));
}

/// profibus-wire 4.2: polls are a Min_Slave_Interval apart, also from the request.
#[test]
fn messages_to_a_slave_keep_the_minimum_interval() {
    let (mut rig, connection) = open();
    rig.station.user.ms2_read(connection, 1, 16, 8).unwrap();
    let mut before = rig.now;
    for _ in 0..5 {
        let sent = rig.next_request();
        assert!(sent.start >= before + BAUD.tbit_of_ms(1), "{} after {before}", sent.start);
        answer(&mut rig, 48, "SC");
        before = rig.now;
    }
}

/// The master sends a request once: it does not repeat a lost one, since a write must not be executed twice.
#[test]
fn a_request_that_got_no_answer_is_polled_for_and_not_repeated() {
    let (mut rig, connection) = open();
    let written = rig.station.user.ms2_write(connection, 1, 16, &[1, 2]).unwrap();
    let write = rig.next_request().text();
    // The link layer repeats the telegram, with the same count: the slave does it once.
    assert_eq!(rig.next_request().text(), write);
    for _ in 0..5 {
        assert!(rig.next_request().text().starts_with("68 05 05 68 88 82 "), "a poll");
        answer(&mut rig, 48, "SC");
    }
    rig.next_request();
    answer(&mut rig, 48, "5F 01 10 02");
    assert_eq!(rig.station.user.outcome(written), Some(Ok(())));
}

/// profibus-wire 4.9, rule 6: the master repeats the request while the slave is busy; the count starts again when the
/// slave accepts it.
#[test]
fn a_busy_slave_is_asked_again_a_limited_number_of_times() {
    for (what, reason, status) in
        [("RR", AbortReason::Fdl(2), Status::NoResource), ("UE", AbortReason::Fdl(1), Status::UserError)]
    {
        let (mut rig, connection) = open();
        rig.station.user.ms2_read(connection, 1, 16, 8).unwrap();
        for answered in [what, what, "SC", what, what, what] {
            rig.next_request();
            answer(&mut rig, 48, answered);
        }
        assert!(rig.next_request().text().contains(" 32 58 00 "), "the third in a row ends it");
        answer(&mut rig, 48, "SC");
        let end = failed(reason, Cause::Status(status));
        assert_eq!(rig.station.user.outcome(connection), Some(Err(end)));
    }
}

/// UE: the slave's application interface failed (profibus-wire 4.12), maybe after it had taken the request.
#[test]
fn a_request_that_changes_something_is_not_sent_again_after_ue() {
    let submit: [fn(&mut Master<0, 0>, Handle<Connect>) -> Request; 2] = [
        |user, connection| Request::Write(user.ms2_write(connection, 1, 16, &[1, 2]).unwrap()),
        |user, connection| Request::Transport(user.ms2_transport(connection, 1, 16, &[1, 2]).unwrap()),
    ];
    for submit in submit {
        let (mut rig, connection) = open();
        let request = submit(&mut rig.station.user, connection);
        rig.next_request();
        answer(&mut rig, 48, "UE");
        let (sap, du) = message(&rig.next_request().octets);
        assert_eq!((sap, du.as_str()), (48, "58 00 01"), "an Abort with the reason UE");
        answer(&mut rig, 48, "SC");
        let outcome = request.outcome(&mut rig.station.user);
        assert!(outcome.starts_with(", the MS2 connection failed: "), "{outcome}");
    }
}

/// The Initiate may have opened a connection.
#[test]
fn after_ue_of_the_resource_manager_the_master_searches_for_the_connection() {
    let (mut rig, connection) = opening();
    for _ in 0..2 {
        answer(&mut rig, 49, "UE");
        assert_eq!(message(&rig.next_request().octets).0, 49);
    }
    answer(&mut rig, 49, "UE");
    search_down_to(&mut rig, 47);
    assert_eq!(message(&rig.next_request().octets).0, 46);
    answer(&mut rig, 46, "SC");
    let end = failed(AbortReason::Fdl(1), Cause::Status(Status::UserError));
    assert_eq!(rig.station.user.outcome(connection), Some(Err(end)));
}

#[test]
fn an_invalid_request_is_refused_at_once() {
    let (mut rig, connection) = opening();
    let user = &mut rig.station.user;
    assert_eq!(user.ms2_open(127, &parameters()), Err(SubmitError::Address(127)));
    assert_eq!(user.ms2_open(2, &parameters()), Err(SubmitError::Address(2)), "the master itself");
    assert_eq!(user.ms2_read(connection, 1, 16, 8), Err(SubmitError::NotOpen));
    for _ in 1..4 {
        user.ms2_open(8, &parameters()).unwrap();
    }
    assert_eq!(user.ms2_open(8, &parameters()), Err(SubmitError::Full { slots: 4 }));

    let (mut rig, connection) = open();
    let user = &mut rig.station.user;
    let length = |octets| SubmitError::Length { octets, room: 240 };
    assert_eq!(user.ms2_read(connection, 1, 16, 0), Err(length(0)));
    assert_eq!(user.ms2_write(connection, 1, 16, &[]), Err(length(0)));
    assert_eq!(user.ms2_write(connection, 1, 16, &[0; 241]), Err(length(241)));
    assert_eq!(user.ms2_transport(connection, 1, 16, &[0; 300]), Err(length(300)));
    user.ms2_read(connection, 1, 16, 8).unwrap();
    assert_eq!(user.ms2_read(connection, 1, 17, 8), Err(SubmitError::Busy));
    user.ms2_close(connection).unwrap();
    rig.next_request();
    answer(&mut rig, 48, "SC");
    assert!(matches!(rig.station.user.outcome(connection), Some(Err(_))));
    assert_eq!(rig.station.user.ms2_close(connection), Err(SubmitError::UnknownHandle));
    assert_eq!(rig.station.user.ms2_read(connection, 1, 16, 8), Err(SubmitError::UnknownHandle));
}

/// The user may submit a request while the master waits for the answer to Idle.
#[test]
fn a_request_waits_for_an_idle_under_way() {
    let (mut rig, connection, _) = stand(Idle);
    let read = rig.station.user.ms2_read(connection, 1, 16, 8).unwrap();
    answer(&mut rig, 48, "SC");
    assert!(rig.next_request().text().starts_with("68 05 05"), "the Idle is fetched first");
    answer(&mut rig, 48, "48");
    assert!(rig.next_request().text().contains(" 30 32 5E 01 10 08 "));
    answer(&mut rig, 48, "5E 01 10 01 AA");
    assert_eq!(rig.station.user.outcome(read), Some(Ok(&[0xAA][..])));
}

/// A station without the token gets no requests, but its timeouts pass.
#[test]
fn timeouts_end_without_the_token_too() {
    let (mut rig, connection, _) = stand(PollRead);
    // The poll was sent: the master waits for its answer before it gives up.
    rig.station.user.elapse(rig.now + BAUD.tbit_of_ms(1001));
    assert_eq!(rig.station.user.ms2_phase(connection), Some(Phase::Transferring));
    rig.station.listen(rig.now);
    rig.station.user.elapse(rig.now);
    assert_eq!(rig.station.user.ms2_phase(connection), Some(Phase::Transferring));
    rig.station.user.elapse(rig.now + BAUD.tbit_of_ms(1001));
    assert_eq!(rig.station.user.ms2_phase(connection), Some(Phase::Aborting));
}

/// A close while the master polls the resource manager waits until the access point for the Abort is known.
#[test]
fn a_connection_that_is_closed_while_it_opens_is_aborted_at_its_access_point() {
    let (mut rig, connection, _) = stand(PollManager);
    rig.station.user.ms2_close(connection).unwrap();
    answer(&mut rig, 49, "SC");
    let sent = rig.next_request_within(40_000).expect("SAP 49 is polled on");
    assert!(sent.text().contains(" 31 32 "), "{}", sent.text());
    answer(&mut rig, 49, MANAGER);
    assert_eq!(rig.next_request().text()[18..], *"5C 30 32 58 00 20 40 16");
    answer(&mut rig, 48, "SC");
    let end = ConnectionEnd::Closed(AbortReason::User(0));
    assert_eq!(rig.station.user.outcome(connection), Some(Err(end)));
}

/// Master 3 asks another station for its FDL status.
const FOREIGN: &str = "10 05 03 49 51 16";

/// The access point, and the octets of the message; nothing is a poll.
pub fn message(octets: &[u8]) -> (u8, String) {
    let [0x68, _, _, 0x68, 0x88, 0x82, _, dsap, 0x32, du @ .., _, 0x16] = octets else { panic!("{octets:02X?}") };
    (*dsap, support::text(du))
}

/// While a ring forms, another master may interrupt a request. The slave is not at fault.
#[test]
fn a_request_that_another_master_interrupted_is_sent_again() {
    for (at, sap, du) in [(Initiate, 49, "57"), (Read, 48, "5E 01 10 08"), (Idle, 48, "48")] {
        let (mut rig, connection, request) = stand(at);
        rig.receive_after(100, FOREIGN);
        let (again, sent) = message(&rig.next_request().octets);
        assert!(again == sap && sent.starts_with(du), "{at:?}: {sent} to {again}");
        // The slave did receive the first one: it answers RR to the second, and the master fetches the response.
        if !matches!(at, Initiate) {
            answer(&mut rig, 48, "RR");
            assert_eq!(message(&rig.next_request().octets), (48, String::new()), "{at:?}");
        }
        assert_ne!(rig.station.user.ms2_phase(connection), Some(Phase::Ended), "{at:?}");
        match at {
            Initiate => answer(&mut rig, 49, MANAGER),
            Read => answer(&mut rig, 48, "5E 01 10 02 AA BB"),
            _ => answer(&mut rig, 48, "48"),
        }
        let reported = request.outcome(&mut rig.station.user);
        let expected = if let Read = at { ", read [AA, BB]" } else { "" };
        assert_eq!(reported, expected, "{at:?}");
    }
}

/// The master does not repeat a write; the response shows whether the slave has it.
#[test]
fn a_write_that_another_master_interrupted_is_polled_for() {
    let (mut rig, connection) = open();
    let written = rig.station.user.ms2_write(connection, 1, 16, &[1, 2]).unwrap();
    rig.next_request();
    rig.receive_after(100, FOREIGN);
    assert_eq!(message(&rig.next_request().octets), (48, String::new()));
    answer(&mut rig, 48, "5F 01 10 02");
    assert!(matches!(rig.station.user.outcome(written), Some(Ok(()))));
}

/// A lost poll may have fetched the response. A slave that still has it answers RR, and the master fetches it.
#[test]
fn a_read_is_sent_again_after_a_lost_answer() {
    for (what, next) in [("SC", "5E 01 10 02 AA BB"), ("RR", "5E 01 10 02 AA BB")] {
        let (mut rig, _, request) = stand(PollRead);
        // The poll and its repetition by the link layer.
        rig.next_request();
        assert_eq!(message(&rig.next_request().octets), (48, "5E 01 10 08".to_owned()));
        answer(&mut rig, 48, what);
        assert_eq!(message(&rig.next_request().octets), (48, String::new()));
        answer(&mut rig, 48, next);
        assert_eq!(request.outcome(&mut rig.station.user), ", read [AA, BB]");
    }
}

/// Whether a write that failed may have been executed: after each confirmation of the request, and of a poll.
#[test]
fn the_end_of_a_connection_says_whether_the_slave_may_have_executed_the_request() {
    let write = |before: &[&str], last: &str| {
        let (mut rig, connection) = open();
        let write = rig.station.user.ms2_write(connection, 1, 16, &[1, 2]).unwrap();
        rig.next_request();
        for what in before {
            if *what != "repeated" {
                answer(&mut rig, 48, what);
            }
            rig.next_request();
        }
        answer(&mut rig, 48, last);
        while rig.station.user.ms2_phase(connection) != Some(Phase::Ended) {
            rig.next_request();
            answer(&mut rig, 48, "SC");
        }
        match rig.station.user.outcome(write) {
            Some(Err(RequestError::Ended(_))) => "possibly executed",
            Some(Err(RequestError::NotExecuted(_))) => "not executed",
            other => panic!("{before:?}, {last}: {other:?}"),
        }
    };
    for (before, last, expected) in [
        (&[][..], "RS", "not executed"),
        (&["RR", "RR"], "RR", "not executed"),
        (&[], "UE", "possibly executed"),
        (&["RR"], "UE", "possibly executed"),
        (&["SC", "UE", "UE"], "UE", "possibly executed"),
        (&["repeated"], "RS", "possibly executed"),
        (&["SC"], "RS", "possibly executed"),
        (&["SC"], "58 00 13", "possibly executed"),
        (&["SC"], "5F 01 11 02", "possibly executed"),
        (&["repeated", "repeated"], "RS", "possibly executed"),
        (&[], "58 00 13", "possibly executed"),
    ] {
        assert_eq!(write(before, last), expected, "{before:?}, {last}");
    }
    // The connection ends before the request was sent: an Idle is under way.
    let (mut rig, connection, _) = stand(Idle);
    let write = rig.station.user.ms2_write(connection, 1, 16, &[1, 2]).unwrap();
    answer(&mut rig, 48, "RS");
    assert_eq!(rig.station.user.outcome(write), Some(Err(RequestError::NotExecuted(CLOSED))));
}
