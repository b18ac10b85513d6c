//! Answers that are lost, damaged or late cost a command time, and never the next command its connection.
//!
//! The gauge has one MS2 connection. Each test puts the fault at each answer of a conversation in turn.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::late_line::{ADDRESS, Fault, LateLine, RR, RS, SC, UE};
use profivac_client::class1::Class1Session;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::ms2::Ms2;
use profivac_client::records::{RecordError, Records, Unavailable, WriteEffect};
use profivac_client::{ClientError, ErrorKind, Gauge};
use profivac_devices::model::AccessPath;
use profivac_dp::link::Baud;
use profivac_host::port::Delivery;
use profivac_host::session::BusSession;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// The lines of the tests: a slow one whose adapter holds characters for 16 ms, and a fast one.
const LINES: [(Baud, u64); 2] = [(Baud::B19200, 16), (Baud::B1500000, 1)];

fn line(baud: Baud, hold_ms: u64) -> LateLine {
    LateLine::new(baud, Delivery::Usb { hold: Duration::from_millis(hold_ms), is_known: true })
}

/// The faults of one answer, from a single one to a stall of the whole line. The link layer repeats a request once.
fn faults(number: usize) -> [Fault; 9] {
    let ms = Duration::from_millis;
    [
        Fault::Lost(number, 1),
        Fault::Lost(number, 2),
        Fault::Lost(number, 3),
        Fault::Damaged(number, 2),
        Fault::Unheard(number, 2),
        Fault::Unheard(number, 3),
        Fault::Stalled(number, ms(100)),
        Fault::Stalled(number, ms(400)),
        Fault::Stalled(number, ms(1500)),
    ]
}

/// A parameter of an instance that slot 1 does not show at first, and its value.
const TARGET: (&str, &str) = ("ba.safe-value", "0 mbar");

/// Another parameter, for the next command.
const NEXT: (&str, &str) = ("pirani.safe-state", "zero");

/// The longest time of a command with one fault. An Initiate and a write are sent once, and polled for during T: 5 s, profibus-wire 4.9.
fn longest(line: &LateLine) -> Duration {
    match line.fault() {
        Fault::Stalled(..) => Duration::from_secs(13),
        _ if line.has_lost_a_single() => Duration::from_secs(7),
        _ => Duration::from_secs(3),
    }
}

fn read(session: &mut BusSession, name: &str) -> Result<String, ClientError> {
    Ok(Gauge::open(session, ADDRESS)?.read(name)?.text)
}

/// The conversations of a read with every fault at every answer.
fn every_fault(lines: &[(Baud, u64)], conversation: impl Fn(&LateLine) -> Result<(), String>) {
    every_fault_after(lines, |_| {}, conversation);
}

/// The same after something without a fault.
fn every_fault_after(
    lines: &[(Baud, u64)],
    prepare: impl Fn(&LateLine),
    conversation: impl Fn(&LateLine) -> Result<(), String>,
) {
    let mut failures = Vec::new();
    for (baud, hold_ms) in lines.iter().copied() {
        let undisturbed = line(baud, hold_ms);
        prepare(&undisturbed);
        undisturbed.set_fault(Fault::None);
        conversation(&undisturbed).unwrap();
        let count = undisturbed.answers().max(undisturbed.requests());
        for fault in (0..count).flat_map(faults) {
            let line = line(baud, hold_ms);
            prepare(&line);
            line.set_fault(fault);
            if let Err(failure) = conversation(&line) {
                failures.push(format!("{baud}, {fault:?}: {failure}"));
            }
        }
    }
    assert!(failures.is_empty(), "{} conversations failed:\n{}", failures.len(), failures.join("\n"));
}

/// Checks a reading, and that it did not take longer than a bound.
fn check(line: &LateLine, session: &mut BusSession, (name, value): (&str, &str)) -> Result<(), String> {
    let begun = line.now();
    let found = read(session, name).map_err(|error| format!("{name}: {error}"))?;
    let took = line.now() - begun;
    if found != value || took > longest(line) {
        return Err(format!("{name} is {found} after {took:?}"));
    }
    Ok(())
}

#[test]
fn a_read_is_repeated_after_a_fault_and_the_next_command_and_the_next_program_work() {
    every_fault(&LINES, |line| {
        let mut session = line.session();
        check(line, &mut session, TARGET)?;
        check(line, &mut session, NEXT)?;
        drop(session);
        // Another station address: it could not close what the first program had left.
        check(line, &mut line.session_of(3), TARGET)
    });
}

/// Ctrl-C ends the waits of a program, not the closing of its connection; also when the answer to the opening was lost.
#[test]
fn a_program_that_is_cancelled_at_any_moment_leaves_no_connection() {
    for fault in [Fault::None, Fault::Lost(2, 2)] {
        for allowed in 0..1000 {
            let line = line(Baud::B19200, 16);
            line.set_fault(fault);
            let mut session = line.session();
            let waits = Arc::new(AtomicUsize::new(0));
            let counted = Arc::clone(&waits);
            let cancel = move || counted.fetch_add(1, Ordering::SeqCst) >= allowed;
            session.set_cancellation(Some(Box::new(cancel)));
            let ended = read(&mut session, NEXT.0);
            drop(session);
            let found = read(&mut line.session_of(3), NEXT.0);
            assert_eq!(found.unwrap(), NEXT.1, "{fault:?}, cancelled after {allowed} waits: {ended:?}");
            if waits.load(Ordering::SeqCst) <= allowed {
                assert_eq!(ended.unwrap(), NEXT.1, "{fault:?}");
                break;
            }
        }
    }
}

/// After T without a request the master sends Idle: profibus-wire 4.9, rule 2.
#[test]
fn a_connection_survives_a_fault_at_its_idle_or_is_opened_again() {
    every_fault(&LINES[..1], |line| {
        let mut session = line.session();
        let mut connection = Ms2::new(&mut session, ADDRESS);
        for _ in 0..2 {
            let state = connection.read(0, 25).map_err(|error| error.to_string())?;
            if state != [2] {
                return Err(format!("device state {state:?}"));
            }
            connection.line().pause(Duration::from_secs(6)).unwrap();
        }
        drop(connection);
        drop(session);
        check(line, &mut line.session(), NEXT)
    });
}

/// A program that was killed leaves its connection open. The next one has the same station address.
#[test]
fn a_connection_that_a_killed_program_has_left_is_closed_by_the_next_program() {
    every_fault_after(&LINES, leave_connection, |line| check(line, &mut line.session(), TARGET));
}

/// Opens the connection of the gauge and is killed.
fn leave_connection(line: &LateLine) {
    let mut session = line.session();
    let mut connection = Ms2::new(&mut session, ADDRESS);
    connection.read(0, 25).unwrap();
    std::mem::forget(connection);
    std::mem::forget(session);
}

/// The gauge accepts the Abort and offers no connection all the same: it has refused, and that is known soon.
#[test]
fn a_gauge_that_accepts_an_abort_and_stays_closed_is_an_error_of_its_own_within_two_seconds() {
    let line = line(Baud::B1500000, 1);
    line.answer_with(&[0x58], SC);
    line.answer_with(&INITIATE, RS);
    let begun = line.now();
    let error = RecordError::from(Ms2::new(&mut line.session(), ADDRESS).read(0, 25).unwrap_err());
    assert_eq!(error.kind(), ErrorKind::Refused, "{error}");
    assert!(matches!(error, RecordError::Unavailable(Unavailable::NoConnection)), "{error}");
    let took = line.now() - begun;
    assert!(took < Duration::from_secs(2), "{took:?}");
}

/// The connection of another master stays open: only the slave tells the masters apart.
#[test]
fn a_connection_of_another_master_is_not_closed_and_the_error_names_it() {
    let line = line(Baud::B1500000, 1);
    let mut other = line.session_of(3);
    let mut held = Ms2::new(&mut other, ADDRESS);
    held.read(0, 25).unwrap();
    let error = read(&mut line.session(), TARGET.0).unwrap_err();
    assert_eq!(error.to_string(), format!("bcg450 at address 5: {}", Unavailable::NoConnection));
    assert_eq!(held.read(0, 25).unwrap(), [2], "the connection is still open");
    assert_eq!(line.requests_with(&INITIATE), 2, "each master asks once");
}

/// The value that a test writes, and what the parameter shows then.
const WRITTEN: (&str, &str, &str) = ("pirani.safe-value", "12.5 Pascal", "0.125 mbar");

/// An Initiate.
const INITIATE: [u8; 1] = [0x57];

/// An MS2 write to Safe Value of the selected instance: slot 1, index 40.
const WRITE: [u8; 3] = [0x5F, 1, 40];

/// Writes with one fault, and compares the error, the requests that the gauge took, and the value that the next program reads. Returns
/// the effect.
fn write(line: &LateLine) -> Result<&'static str, String> {
    let (name, value, written) = WRITTEN;
    let mut session = line.session();
    let outcome = Gauge::open(&mut session, ADDRESS).and_then(|mut gauge| gauge.write(name, value));
    drop(session);
    let (sent, taken) = (line.requests_with(&WRITE), line.taken(&WRITE));
    line.set_fault(Fault::None);
    let found = read(&mut line.session(), name).map_err(|error| format!("the next program: {error}"))?;
    let effect = outcome.as_ref().map_or_else(ClientError::write_effect, |_| WriteEffect::Executed);
    let says = |text| outcome.as_ref().is_err_and(|error| error.to_string().contains(text));
    let fits = match effect {
        WriteEffect::Executed => found == written,
        WriteEffect::NotSent | WriteEffect::Refused => found == "0 mbar" && taken == 0,
        WriteEffect::PossiblyExecuted => sent == 1 && says("it may have been written, read it"),
    };
    if taken > 1 || !fits {
        return Err(format!("{effect:?}, the gauge took {taken} of {sent} writes, the value is {found}: {outcome:?}"));
    }
    Ok(effect.name())
}

#[test]
fn a_write_is_executed_once_after_a_fault_at_any_answer() {
    every_fault(&LINES[..1], |line| match write(line)? {
        "executed" => Ok(()),
        effect => Err(effect.to_owned()),
    });
}

/// The line fails at any answer and stays lost until the next program.
#[test]
fn a_write_on_a_line_that_is_lost_is_sent_once_at_most_and_its_error_says_whether_it_may_have_been_executed() {
    let [(baud, hold_ms), _] = LINES;
    let count = {
        let undisturbed = line(baud, hold_ms);
        let mut session = undisturbed.session();
        Gauge::open(&mut session, ADDRESS).unwrap().write(WRITTEN.0, WRITTEN.1).unwrap();
        undisturbed.answers()
    };
    let mut effects = BTreeSet::new();
    for number in 2..count {
        for fault in [Fault::Lost(number, usize::MAX), Fault::Unheard(number, usize::MAX)] {
            let line = line(baud, hold_ms);
            line.set_fault(fault);
            effects.insert(write(&line).unwrap_or_else(|failure| panic!("{fault:?}: {failure}")));
        }
    }
    assert_eq!(effects.into_iter().collect::<Vec<_>>(), ["executed", "not-sent", "possibly-executed"]);
}

/// The slave answers UE or RR until the master gives up. UE: its application may have taken the write. RR: it has not, and a new connection
/// is the remedy if a response waits that nothing has fetched.
#[test]
fn a_write_that_the_slave_rejects_is_repeated_after_rr_only_and_on_one_new_connection_at_most() {
    for (status, is_open, sent, initiates, effect) in [
        (UE, false, 1, 1, WriteEffect::PossiblyExecuted),
        (UE, true, 1, 0, WriteEffect::PossiblyExecuted),
        (RR, false, 11, 1, WriteEffect::NotSent),
        (RR, true, 22, 1, WriteEffect::NotSent),
    ] {
        let line = line(Baud::B1500000, 1);
        let mut session = line.session();
        let mut connection = Ms2::new(&mut session, ADDRESS);
        if is_open {
            connection.read(0, 25).unwrap();
        }
        line.set_fault(Fault::None);
        line.answer_with(&WRITE, status);
        let error = RecordError::from(connection.write(1, 40, &[0; 4]).unwrap_err());
        assert_eq!(error.write_effect(), effect, "{error}");
        assert_eq!((line.requests_with(&WRITE), line.requests_with(&INITIATE)), (sent, initiates), "{error}");
    }
}

/// A slave that rejects all openings, or all reads, is not asked on more connections: it has answered.
#[test]
fn an_opening_or_a_read_that_the_slave_rejects_goes_over_one_connection() {
    for status in [UE, RR] {
        for (rejected, initiates) in [(&INITIATE[..], 11), (&[0x5E], 1)] {
            let line = line(Baud::B1500000, 1);
            line.answer_with(rejected, status);
            let mut session = line.session();
            let error = Ms2::new(&mut session, ADDRESS).read(0, 25).unwrap_err();
            assert_eq!(line.requests_with(&INITIATE), initiates, "{error}");
        }
    }
}

/// The gauge is gone before the write is sent: the error does not send the user to look for a change.
#[test]
fn a_write_to_a_gauge_that_is_gone_was_not_sent() {
    let line = line(Baud::B1500000, 1);
    let mut session = line.session();
    let mut gauge = Gauge::open(&mut session, ADDRESS).unwrap();
    let named = gauge.find(WRITTEN.0).unwrap();
    let write = gauge.prepare(&named, WRITTEN.1).unwrap();
    line.set_fault(Fault::Lost(0, usize::MAX));
    let error = gauge.execute(write).unwrap_err();
    assert_eq!(error.write_effect(), WriteEffect::NotSent, "{error}");
    assert_eq!(line.requests_with(&WRITE), 0);
    // A record without a reading before it.
    let error = gauge.records().write(1, 40, &[0; 4]).unwrap_err();
    let error = RecordError::from(error);
    assert_eq!(error.write_effect(), WriteEffect::NotSent, "{error}");
}

/// MS1 and the parameter channel: a read is repeated, a write is executed at most once.
#[test]
fn a_fault_at_ms1_or_in_the_parameter_channel_costs_no_value_and_no_second_write() {
    for path in [AccessPath::Class1, AccessPath::ParameterChannel] {
        every_fault(&LINES[..1], |line| {
            let mut session = line.session();
            let slave = CyclicSlave::find(&mut session, ADDRESS, 0).map_err(|error| error.to_string())?;
            let mut records = Class1Session::open(&mut session, &slave, path).map_err(|error| error.to_string())?;
            let before = records.read(1, 39).map_err(|error| format!("before: {error}"))?;
            let outcome = records.write(1, 39, &[2]);
            let after = records.read(1, 39).map_err(|error| format!("after: {error}"))?;
            drop(records);
            drop(session);
            let effect = outcome.as_ref().map_or_else(RecordError::write_effect, |()| WriteEffect::Executed);
            let fits = match effect {
                WriteEffect::Executed => after == [2],
                WriteEffect::NotSent | WriteEffect::Refused => after == before,
                WriteEffect::PossiblyExecuted => true,
            };
            if before != [0] || !fits {
                return Err(format!("{before:?}, then {after:?} after {outcome:?}"));
            }
            let ms1_writes = line.taken(&[0x5F, 1, 39]);
            if ms1_writes > 1 {
                return Err(format!("{ms1_writes} writes"));
            }
            check(line, &mut line.session(), TARGET)
        });
    }
}
