//! A signal ends a command soon, whatever it waits for: an answer, a poll, the pause before a repetition, a restoration.
//!
//! Time passes on the simulated line only.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::late_line::{ADDRESS, Fault, LateLine};
use profivac_client::class1::Class1Session;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::records::{Records, WriteEffect};
use profivac_client::{ClientError, Gauge, ms2};
use profivac_devices::model::AccessPath;
use profivac_dp::link::Baud;
use profivac_host::port::Delivery;
use profivac_host::session::BusSession;
use std::collections::BTreeSet;
use std::time::Duration;

/// The longest time from the signal to the end of a wait: a slice of 20 ms, and the telegram that is under way.
const NOTICE: Duration = Duration::from_millis(60);

/// The timeout of the session, and the longest time of all restorations together.
const TIMEOUT: Duration = Duration::from_secs(5);

/// The longest time of the release of a slave.
const RELEASE: Duration = Duration::from_secs(1);

/// A parameter of an instance that slot 1 does not show at first.
const OTHER_INSTANCE: &str = "ba.safe-value";

/// The value that a test writes, and what the parameter shows before and then.
const WRITTEN: (&str, &str, &str, &str) = ("pirani.safe-value", "12.5 Pascal", "0 mbar", "0.125 mbar");

/// An MS2 write to Safe Value of the selected instance: slot 1, index 40.
const WRITE: [u8; 3] = [0x5F, 1, 40];

fn line() -> LateLine {
    LateLine::new(Baud::B19200, Delivery::Usb { hold: Duration::from_millis(16), is_known: true })
}

/// A session in which a signal comes at this time.
fn session(line: &LateLine, signal_at: Duration) -> BusSession {
    session_with(line, signal_at, TIMEOUT)
}

/// The same with another timeout.
fn session_with(line: &LateLine, signal_at: Duration, timeout: Duration) -> BusSession {
    let mut session = line.session_with(0, timeout);
    let clock = line.clone();
    session.set_cancellation(Some(Box::new(move || clock.now() >= signal_at)));
    session
}

/// A line that works, and lines that are lost at an answer of a command and stay lost; each with a signal at moments from the beginning
/// to the end of the command on the lost line.
fn every_moment(command: impl Fn(&mut BusSession), check: impl Fn(&LateLine, Duration, &dyn Fn(&mut BusSession))) {
    let undisturbed = line();
    command(&mut session(&undisturbed, Duration::MAX));
    let lost = (0..undisturbed.answers()).step_by(4).map(|answer| Fault::Lost(answer, usize::MAX));
    for (fault, step_ms, steps) in lost.map(|fault| (fault, 350, 60)).chain([(Fault::None, 30, 100)]) {
        for step in 0..steps {
            let line = line();
            line.set_fault(fault);
            check(&line, Duration::from_millis(step * step_ms), &command);
        }
    }
}

/// The session ends within the bound after the signal, also in its restorations.
fn check_end(line: &LateLine, signal_at: Duration, bound: Duration, command: &dyn Fn(&mut BusSession)) -> BusSession {
    let mut session = session(line, signal_at);
    command(&mut session);
    let late = line.now().saturating_sub(signal_at);
    assert!(late <= bound, "{:?}, signal at {signal_at:?}: the command ended {late:?} later", line.fault());
    session
}

fn read_other_instance(session: &mut BusSession) -> Result<(), ClientError> {
    Gauge::open(session, ADDRESS)?.read(OTHER_INSTANCE).map(drop)
}

#[test]
fn a_signal_ends_a_read_within_the_timeout_and_the_selector_is_restored_or_named() {
    let ends = BTreeSet::new();
    let ends = std::cell::RefCell::new(ends);
    every_moment(
        |session| {
            read_other_instance(session).ok();
        },
        |line, signal_at, command| {
            let mut session = check_end(line, signal_at, TIMEOUT + NOTICE, command);
            let named = session.take_unrestored(ADDRESS).map(|record| (record.slot, record.index, record.original));
            drop(session);
            line.set_fault(Fault::None);
            let shown = ms2::read(&mut line.session(), ADDRESS, 1, 46).unwrap();
            assert!(shown == [1] || named == Some((1, 46, 1)), "signal at {signal_at:?}: {shown:?}, {named:?}");
            ends.borrow_mut().insert(if shown == [1] { "restored" } else { "named" });
        },
    );
    assert_eq!(ends.into_inner().into_iter().collect::<Vec<_>>(), ["named", "restored"]);
}

/// A user who waits long for answers does not want to wait as long after Ctrl-C.
#[test]
fn a_restoration_takes_no_longer_than_five_seconds_whatever_the_timeout() {
    let undisturbed = line();
    read_other_instance(&mut session(&undisturbed, Duration::MAX)).unwrap();
    let mut longest = Duration::ZERO;
    for (answer, step) in
        (0..undisturbed.answers()).step_by(4).flat_map(|answer| (0..20).map(move |step| (answer, step)))
    {
        let (line, signal_at) = (line(), Duration::from_millis(step * 350));
        line.set_fault(Fault::Lost(answer, usize::MAX));
        read_other_instance(&mut session_with(&line, signal_at, Duration::from_secs(600))).ok();
        longest = longest.max(line.now().saturating_sub(signal_at));
    }
    assert!((TIMEOUT..=TIMEOUT + NOTICE).contains(&longest), "{longest:?}");
}

/// Nothing is to be restored before the selector is moved, and the work itself is never continued.
#[test]
fn a_signal_ends_the_work_of_a_read_within_a_slice() {
    every_moment(
        |session| {
            read_other_instance(session).ok();
        },
        |line, signal_at, _| {
            let mut session = session(line, signal_at);
            let late = match Gauge::open(&mut session, ADDRESS) {
                Ok(mut gauge) => {
                    gauge.read(OTHER_INSTANCE).ok();
                    line.now().saturating_sub(signal_at)
                }
                // The connection is closed within the timeout.
                Err(_) => Duration::ZERO,
            };
            assert!(late <= NOTICE, "{:?}, signal at {signal_at:?}: the work ended {late:?} later", line.fault());
        },
    );
}

#[test]
fn a_write_that_a_signal_ends_says_whether_the_gauge_may_have_the_value() {
    let (name, value, before, after) = WRITTEN;
    let effects = std::cell::RefCell::new(BTreeSet::new());
    let write = |session: &mut BusSession| {
        Gauge::open(session, ADDRESS).and_then(|mut gauge| gauge.write(name, value)).map(drop)
    };
    every_moment(
        |session| {
            write(session).ok();
        },
        |line, signal_at, _| {
            let outcome = write(&mut session(line, signal_at));
            let (sent, taken) = (line.requests_with(&WRITE), line.taken(&WRITE));
            line.set_fault(Fault::None);
            let mut next = line.session();
            let found = Gauge::open(&mut next, ADDRESS).unwrap().read(name).unwrap().text;
            let effect = outcome.as_ref().map_or_else(ClientError::write_effect, |()| WriteEffect::Executed);
            let says = |text| outcome.as_ref().is_err_and(|error| error.to_string().contains(text));
            let fits = match effect {
                WriteEffect::Executed => found == after,
                WriteEffect::NotSent | WriteEffect::Refused => found == before && taken == 0,
                WriteEffect::PossiblyExecuted => sent == 1 && says("it may have been written, read it"),
            };
            assert!(fits && taken <= 1, "signal at {signal_at:?}: {outcome:?}, {sent} writes, the value is {found}");
            effects.borrow_mut().insert(effect.name());
        },
    );
    assert_eq!(effects.into_inner().into_iter().collect::<Vec<_>>(), ["executed", "not-sent", "possibly-executed"]);
}

#[test]
fn a_signal_ends_the_search_for_a_slave_within_the_timeout() {
    every_moment(
        |session| {
            CyclicSlave::find(session, ADDRESS, 0).ok();
        },
        |line, signal_at, command| {
            check_end(line, signal_at, TIMEOUT + NOTICE, command);
        },
    );
}

/// The slave is released, which takes a second if it does not answer.
#[test]
fn a_signal_ends_a_read_by_ms1_or_in_the_parameter_channel_within_the_timeout() {
    for path in [AccessPath::Class1, AccessPath::ParameterChannel] {
        every_moment(
            |session| {
                let Ok(slave) = CyclicSlave::find(session, ADDRESS, 0) else { return };
                let Ok(mut records) = Class1Session::open(session, &slave, path) else { return };
                records.read(1, 39).ok();
            },
            |line, signal_at, command| {
                check_end(line, signal_at, TIMEOUT + RELEASE + NOTICE, command);
            },
        );
    }
}

/// Reads a parameter of another instance by a service that needs ownership.
fn read_other_instance_as_owner(session: &mut BusSession, path: AccessPath) {
    let Ok(slave) = CyclicSlave::find(session, ADDRESS, 0) else { return };
    let Ok(records) = Class1Session::open(session, &slave, path) else { return };
    Gauge::with_model(records, ADDRESS, slave.model).with_unit(slave.unit).read(OTHER_INSTANCE).ok();
}

/// The master takes no second request of these services to a slave: the one that the signal has interrupted ends first.
#[test]
fn a_selector_that_ms1_or_the_parameter_channel_has_moved_is_restored_after_a_signal_or_named() {
    for path in [AccessPath::Class1, AccessPath::ParameterChannel] {
        let ends = std::cell::RefCell::new(BTreeSet::new());
        every_moment(
            |session| read_other_instance_as_owner(session, path),
            |line, signal_at, command| {
                let mut session = check_end(line, signal_at, TIMEOUT + RELEASE + NOTICE, command);
                let is_healthy = line.fault() == Fault::None;
                let named = session.take_unrestored(ADDRESS).map(|record| (record.slot, record.index, record.original));
                drop(session);
                line.set_fault(Fault::None);
                let shown = ms2::read(&mut line.session(), ADDRESS, 1, 46).unwrap();
                let is_named = !is_healthy && named == Some((1, 46, 1));
                assert!(shown == [1] || is_named, "{path:?}, signal at {signal_at:?}: {shown:?}, {named:?}");
                ends.borrow_mut().insert(if shown == [1] { "restored" } else { "named" });
            },
        );
        assert_eq!(ends.into_inner().into_iter().collect::<Vec<_>>(), ["named", "restored"], "{path:?}");
    }
}
