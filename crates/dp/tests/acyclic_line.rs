//! Acyclic requests to slaves of this project, on a line in bit times: several connections to one slave and to several,
//! during the cycle and at the same time.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::Active;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::ms2::Connect;
use profivac_dp::master::{
    AcyclicEvent, Cause, ConnectionEnd, EventKind, Handle, Master, Mode, Ms1Parameters, Ms2Parameters, Operation,
    Phase, Settings, SlaveParameters, SubmitError, services,
};
use profivac_dp::slave::Features;
use profivac_wire::acyclic::AbortReason;
use profivac_wire::control::Status;
use std::fmt::Debug;
use support::bus;
use support::line::{From, Line};
use support::plain::Plain;

const BAUD: Baud = Baud::B1500000;
const IDENT: u16 = 0x1234;
/// Two octets in, two octets out.
const CFG: [u8; 2] = [0x11, 0x21];

type Bus = Line<Master<4, 8>>;

fn second() -> u64 {
    BAUD.tbit_of_ms(1000)
}

fn device(address: u8) -> Plain {
    let features = Features { sync: true, freeze: true, dpv1: true, ms1: true };
    Plain { features, record: vec![address; 4], ..Plain::new(IDENT, &CFG) }
}

/// Slaves at these addresses, which are not in the master's list.
fn line(addresses: &[u8]) -> Bus {
    let station: Active<Master<4, 8>> = Master::on(bus().check().unwrap(), Settings::new(BAUD), BitTime(0));
    let mut line = Line::new(station);
    addresses.iter().for_each(|address| line.attach(device(*address), *address));
    line
}

/// The same in data exchange, with DP-V1 enabled.
fn exchanging(addresses: &[u8]) -> Bus {
    let mut line = line(addresses);
    for address in addresses {
        let slave = SlaveParameters { user_prm: &[0x80, 0, 0], ..SlaveParameters::new(*address, IDENT, &CFG) };
        line.master.user.add(&slave).unwrap();
    }
    line.master.user.set_mode(Mode::Operate);
    line.run_until(second(), |line| line.master.user.exchanging() == line.slaves.len());
    while line.master.user.next_event().is_some() {}
    line
}

fn quick() -> Ms2Parameters {
    Ms2Parameters { pace_tbit: 0, send_timeout: 100, response_timeout: 100, ..Ms2Parameters::new(BAUD) }
}

fn open(line: &mut Bus, address: u8) -> Handle<Connect> {
    let connection = line.master.user.ms2_open(address, &quick()).unwrap();
    line.run_until(second(), |line| line.master.user.ms2_phase(connection) == Some(Phase::Open));
    assert!(matches!(line.master.user.outcome(connection), Some(Ok(_))));
    connection
}

/// The end of a connection, in less than three seconds.
fn end(line: &mut Bus, connection: Handle<Connect>) -> ConnectionEnd {
    line.run_until(3 * second(), |line| line.master.user.ms2_phase(connection) == Some(Phase::Ended));
    match line.master.user.outcome(connection) {
        Some(Err(end)) => end,
        other => panic!("{other:?}"),
    }
}

/// The outcome of a request, as text.
fn reported<O>(line: &mut Bus, handle: Handle<O>) -> String
where
    O: Operation,
    for<'a> O::Outcome<'a>: Debug,
{
    let mut reported = None;
    line.run_until(5 * second(), |line| {
        reported = line.master.user.outcome(handle).map(|outcome| format!("{outcome:02X?}"));
        reported.is_some()
    });
    reported.unwrap()
}

#[test]
fn records_of_240_octets_are_written_and_read() {
    let mut line = line(&[8]);
    let connection = open(&mut line, 8);
    let record: Vec<u8> = (0..240).collect();
    let write = line.master.user.ms2_write(connection, 1, 16, &record).unwrap();
    assert_eq!(reported(&mut line, write), "Ok(())");
    assert_eq!(line.slaves[0].device().record, record);
    let read = line.master.user.ms2_read(connection, 1, 16, 240).unwrap();
    assert_eq!(reported(&mut line, read), format!("Ok({record:02X?})"));
    let read = line.master.user.ms2_read(connection, 1, 16, 3).unwrap();
    assert_eq!(reported(&mut line, read), "Ok([00, 01, 02])", "cut to the requested length");
    let read = line.master.user.ms2_read(connection, 9, 16, 3).unwrap();
    assert!(reported(&mut line, read).starts_with("Err(Refused(Negative { function: Read"));
    // This slave does not support Data_Transport; the connection stays open.
    let transport = line.master.user.ms2_transport(connection, 1, 16, &[1]).unwrap();
    assert!(reported(&mut line, transport).starts_with("Err(Refused(Negative { function: DataTransport"));
    assert_eq!(line.master.user.ms2_phase(connection), Some(Phase::Open));
}

/// Two connections to one slave and two to others, all with requests: each request is sent, and so is the raw request.
#[test]
fn connections_take_turns() {
    let mut line = exchanging(&[8, 9, 10]);
    let connections = [open(&mut line, 8), open(&mut line, 8), open(&mut line, 9), open(&mut line, 10)];
    let refused = line.master.user.ms2_open(8, &quick());
    assert_eq!(refused, Err(SubmitError::Full { slots: 4 }));
    let ms1 = Ms1Parameters { pace_tbit: 0, ..Ms1Parameters::new(BAUD) };
    let (mut reads, mut jobs, mut raw) = ([0u32; 4], 0u32, 0u32);
    let mut job = line.master.user.ms1_read(9, 1, 16, 8, &ms1).unwrap();
    line.master.user.submit_request(&services::slave_diag(8)).unwrap();
    let exchanges = |line: &Bus| [8, 9, 10].map(|address| line.master.user.counters(address).unwrap().exchanges);
    let (before, cycles) = (exchanges(&line), line.master.user.cycles());
    let mut handles = connections.map(|connection| line.master.user.ms2_read(connection, 1, 16, 8).unwrap());
    let until = line.now + second();
    line.run_until(2 * second(), |line| {
        for ((connection, handle), reads) in connections.iter().zip(&mut handles).zip(&mut reads) {
            if line.master.user.outcome(*handle).is_some() {
                *reads += 1;
                *handle = line.master.user.ms2_read(*connection, 1, 16, 8).unwrap();
            }
        }
        if line.master.user.outcome(job).is_some() {
            jobs += 1;
            job = line.master.user.ms1_read(9, 1, 16, 8, &ms1).unwrap();
        }
        if line.master.user.take_confirmation().is_some() {
            raw += 1;
            line.master.user.submit_request(&services::slave_diag(8)).unwrap();
        }
        line.now >= until
    });
    assert!(reads[0] > 50, "{reads:?}");
    assert!(reads.iter().all(|count| count.abs_diff(reads[0]) <= 1), "{reads:?}");
    assert!(jobs.abs_diff(reads[0]) <= 1, "{jobs} beside {reads:?}");
    // The raw request takes one message, the others two for each read.
    assert!(raw > reads[0], "{raw} beside {reads:?}");
    // The cycle has priority: each slave exchanges data in every cycle.
    let cycles = line.master.user.cycles() - cycles;
    for (before, after) in before.iter().zip(exchanges(&line)) {
        assert!((after - before).abs_diff(cycles) <= 1, "{} in {cycles} cycles", after - before);
    }
}

/// profibus-wire 4.9: Idle keeps a connection open without requests.
#[test]
fn an_open_connection_stays_open() {
    let mut line = line(&[8]);
    let connection = open(&mut line, 8);
    line.run_for(10 * second());
    assert_eq!(line.master.user.ms2_phase(connection), Some(Phase::Open));
    let idles = line.trace.iter().filter(|entry| entry.from == From::Master && entry.octets.get(9) == Some(&0x48));
    assert!((9..=10).contains(&idles.count()), "one Idle each second");
    let read = line.master.user.ms2_read(connection, 1, 16, 8).unwrap();
    assert_eq!(reported(&mut line, read), "Ok([08, 08, 08, 08])");
}

/// A slave aborts after an unknown function; the master fetches the reason as a response and reports it.
#[test]
fn an_abort_of_the_slave_is_reported() {
    let mut line = line(&[8]);
    let connection = open(&mut line, 8);
    // Another function arrives instead of Idle, with a matching check octet.
    line.telegram_fault = Some(Box::new(|_, octets| match octets {
        [0x68, 6, 6, 0x68, da, sa, fc, dsap, ssap, 0x48, sum, 0x16] => {
            vec![0x68, 6, 6, 0x68, *da, *sa, *fc, *dsap, *ssap, 0x49, sum.wrapping_add(1), 0x16]
        }
        octets => octets.to_vec(),
    }));
    let began = line.now;
    assert_eq!(end(&mut line, connection), ConnectionEnd::Aborted(AbortReason::INVALID_REQUEST));
    assert!((line.now - began).abs_diff(second()) < second() / 100, "after T");
}

/// Every request arrives damaged: neither side receives the other.
#[test]
fn a_connection_over_a_broken_line_ends_at_both_sides() {
    let mut line = line(&[8]);
    let connection = open(&mut line, 8);
    line.telegram_fault = Some(Box::new(|from, octets| match from {
        From::Master if octets[0] == 0x68 => octets.iter().map(|octet| octet ^ 0x10).collect(),
        _ => octets.to_vec(),
    }));
    let lost = Cause::NoAnswer(profivac_dp::link::active::Failure::Silence);
    assert_eq!(end(&mut line, connection), ConnectionEnd::Failed { reason: AbortReason::Fdl(15), cause: lost });
    line.run_for(3 * second());
    // The slave has freed its connection by itself: both can be opened again.
    line.telegram_fault = None;
    open(&mut line, 8);
    open(&mut line, 8);
}

#[test]
fn a_slave_that_lost_its_power_has_closed_the_access_point() {
    let mut line = line(&[8, 9]);
    let lost = open(&mut line, 8);
    let stays = open(&mut line, 9);
    line.slaves[0].power_up(8);
    let reason = AbortReason::Fdl(3);
    let cause = Cause::Status(Status::ServiceNotActivated);
    assert_eq!(end(&mut line, lost), ConnectionEnd::Failed { reason, cause }, "seen by the next Idle");
    assert_eq!(line.master.user.ms2_phase(stays), Some(Phase::Open));
    // The user opens a new connection with the same access point.
    let again = open(&mut line, 8);
    assert_ne!(again, lost);
    assert_eq!(line.master.user.ms2_read(lost, 1, 16, 8), Err(SubmitError::UnknownHandle));
}

#[test]
fn a_slave_without_a_free_connection_refuses_another() {
    let mut line = line(&[8]);
    let first = open(&mut line, 8);
    open(&mut line, 8);
    let third = line.master.user.ms2_open(8, &quick()).unwrap();
    let closed =
        ConnectionEnd::Failed { reason: AbortReason::Fdl(3), cause: Cause::Status(Status::ServiceNotActivated) };
    assert_eq!(end(&mut line, third), closed);
    // After one connection is closed, another can be opened.
    line.master.user.ms2_close(first).unwrap();
    assert_eq!(end(&mut line, first), ConnectionEnd::Closed(AbortReason::User(0)));
    open(&mut line, 8);
}

#[test]
fn a_connection_to_an_absent_slave_fails_at_once() {
    let mut line = line(&[8]);
    let connection = line.master.user.ms2_open(9, &quick()).unwrap();
    let began = line.now;
    let end = end(&mut line, connection);
    assert!(end.to_string().contains("no answer"), "{end}");
    assert!(line.now - began < second() / 100);
}

/// Ended connections whose outcome was not taken do not occupy slots.
#[test]
fn ended_connections_free_their_slots() {
    let mut line = line(&[8]);
    for _ in 0..20 {
        let connection = line.master.user.ms2_open(9, &quick()).unwrap();
        line.run_until(second(), |line| line.master.user.ms2_phase(connection) == Some(Phase::Ended));
    }
    open(&mut line, 8);
    let events: Vec<_> = std::iter::from_fn(|| line.master.user.next_event()).collect();
    let ended =
        events.iter().filter(|event| matches!(event.kind, EventKind::Acyclic(_, AcyclicEvent::Ended(_)))).count();
    assert_eq!(ended, 20);
    assert!(!line.master.user.take_overflow());
}

/// profibus-wire 4.3.
#[test]
fn ms1_needs_data_exchange_and_dpv1() {
    let parameters = Ms1Parameters::new(BAUD);
    let mut line = line(&[8]);
    assert_eq!(line.master.user.ms1_read(8, 1, 16, 8, &parameters), Err(SubmitError::NotExchanging(8)));
    line.master.user.add(&SlaveParameters { user_prm: &[0, 0, 0], ..SlaveParameters::new(8, IDENT, &CFG) }).unwrap();
    line.master.user.set_mode(Mode::Operate);
    line.run_until(second(), |line| line.master.user.exchanging() == 1);
    assert_eq!(line.master.user.ms1_read(8, 1, 16, 8, &parameters), Err(SubmitError::NotEnabled(8)));

    let mut line = exchanging(&[8]);
    let write = line.master.user.ms1_write(8, 1, 16, &[1, 2, 3], &parameters).unwrap();
    assert_eq!(line.master.user.ms1_read(8, 1, 16, 8, &parameters), Err(SubmitError::Busy));
    assert_eq!(reported(&mut line, write), "Ok(())");
    let read = line.master.user.ms1_read(8, 1, 16, 8, &parameters).unwrap();
    assert_eq!(reported(&mut line, read), "Ok([01, 02, 03])");
    let read = line.master.user.ms1_read(8, 1, 17, 8, &parameters).unwrap();
    assert!(reported(&mut line, read).starts_with("Err(Refused("));
    let length = |octets| SubmitError::Length { octets, room: 240 };
    assert_eq!(line.master.user.ms1_write(8, 1, 16, &[0; 241], &parameters), Err(length(241)));
    assert_eq!(line.master.user.ms1_read(8, 1, 16, 0, &parameters), Err(length(0)));
}

/// MS1 ends with data exchange, whether the slave returns at once or not.
#[test]
fn an_ms1_request_ends_when_the_slave_leaves_data_exchange() {
    let parameters = Ms1Parameters::new(BAUD);
    let mut line = exchanging(&[8, 9]);
    let lost = line.master.user.ms1_read(8, 1, 16, 8, &parameters).unwrap();
    let stays = line.master.user.ms1_read(9, 1, 16, 8, &parameters).unwrap();
    line.master.user.restart(8);
    assert_eq!(reported(&mut line, lost), "Err(NotSent)");
    assert_eq!(reported(&mut line, stays), "Ok([09, 09, 09, 09])");

    // The request is on its way: no telegram of MS1 arrives undamaged.
    line.run_until(second(), |line| line.master.user.exchanging() == 2);
    let sent = line.master.user.ms1_read(8, 1, 16, 8, &parameters).unwrap();
    line.telegram_fault = Some(Box::new(|_, octets| {
        let is_ms1 = octets.get(7) == Some(&0x33);
        octets.iter().map(|octet| if is_ms1 { octet ^ 0x10 } else { *octet }).collect()
    }));
    line.run_for(second() / 100);
    line.master.user.restart(8);
    assert_eq!(reported(&mut line, sent), "Err(LeftExchange)");
}

/// Two requests whose responses never come fail in the same bit time, and each slave may still respond late.
#[test]
fn every_slave_whose_ms1_request_timed_out_is_restarted() {
    let parameters = Ms1Parameters::new(BAUD);
    let mut line = exchanging(&[8, 9, 10]);
    let starts = |line: &Bus| [8, 9, 10].map(|address| line.master.user.counters(address).unwrap().starts);
    assert_eq!(starts(&line), [1, 1, 1]);
    // SC instead of each response: the slave answers, and has no response yet.
    line.telegram_fault = Some(Box::new(|_, octets| match octets {
        [0x68, _, _, 0x68, _, _, 0x08, 0x33, 0x33, ..] => vec![0xE5],
        octets => octets.to_vec(),
    }));
    let reads = [8, 9].map(|address| line.master.user.ms1_read(address, 1, 16, 8, &parameters).unwrap());
    for read in reads {
        assert_eq!(reported(&mut line, read), "Err(Failed(Timeout))");
    }
    line.run_for(second());
    assert_eq!(starts(&line), [2, 2, 1]);
}
