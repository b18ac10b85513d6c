//! Retention and wrong clocks: rows are deleted after their retention of recorded time, and no clock deletes a row earlier.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_model::{AlarmChangeKind, AlarmHistoryEntry, AlarmState, Priority, Role};
use profivac_recorder::alarms::{AlarmBatch, Notification};
use profivac_recorder::audit::AuditQuery;
use profivac_recorder::clock::ClockTime;
use profivac_recorder::{
    AuditAction, AuditEntry, Clock, Deadband, Event, EventKind, Micros, Quality, Reader, Recorder, Retention, Sample,
    Settings,
};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const DAY: Duration = Duration::from_secs(86_400);
const YEAR: i64 = 365;

/// 2026-01-01.
const NEW_YEAR: Micros = Micros(1_767_225_600 * Micros::SECOND);

/// Both clocks of the computer, which tests set.
struct TestClock(Mutex<(Micros, Instant)>);

impl TestClock {
    fn at(wall: Micros) -> Arc<Self> {
        Arc::new(Self(Mutex::new((wall, Instant::now()))))
    }

    /// Time passes on both clocks.
    fn pass(&self, time: Duration) {
        let mut clocks = self.0.lock().unwrap();
        *clocks = (clocks.0.after(time), clocks.1 + time);
    }

    /// The system clock is set by some days, to later or earlier.
    fn set_by(&self, days: i64) {
        self.0.lock().unwrap().0.0 += days * 86_400 * Micros::SECOND;
    }
}

impl Clock for TestClock {
    fn now(&self) -> ClockTime {
        let (wall, monotonic) = *self.0.lock().unwrap();
        ClockTime { monotonic, wall }
    }
}

struct Station {
    _folder: TempDir,
    path: PathBuf,
    clock: Arc<TestClock>,
    retention: Retention,
    recorder: Option<Recorder>,
}

impl Station {
    /// A running station at the beginning of 2026.
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let (clock, retention) = (TestClock::at(NEW_YEAR), Retention::default());
        let mut station = Self { _folder: folder, path, clock, retention, recorder: None };
        station.start();
        station
    }

    fn start(&mut self) {
        let deadband = Deadband { decades: 0.0, max_interval: Duration::ZERO };
        let settings = Settings { deadband, full_rate_window: Duration::ZERO, retention: self.retention, outbox: None };
        self.recorder = Some(Recorder::start_with_clock(&self.path, settings, self.clock.clone()).unwrap());
    }

    fn stop(&mut self) {
        self.recorder = None;
    }

    fn recorder(&self) -> &Recorder {
        self.recorder.as_ref().unwrap()
    }

    /// Lets both clocks run, with a write each day.
    fn run_days(&self, days: u32) {
        for _ in 0..days {
            self.clock.pass(DAY);
            assert!(self.recorder().flush());
        }
    }

    /// Records one row of each kind, and lets everything settle: writing, looking at the clock, deleting.
    fn record(&self, text: &str) {
        let at = self.clock.now().wall;
        self.recorder().push(&Arc::from("chamber"), Sample::new(at, Some(1.0), Quality::Valid));
        self.recorder().record_event(Event { at, gauge: None, kind: EventKind::Note.into(), text: text.to_owned() });
        assert!(self.recorder().audit(audit_entry(at)).wait());
        let batch = AlarmBatch {
            history: vec![history_entry(at, text)],
            notifications: vec![Notification { id: 0, webhook: "log".to_owned(), at, body: "{}".to_owned() }],
            ..AlarmBatch::default()
        };
        assert!(self.recorder().record_alarms_with_receipt(batch, Vec::new()).wait());
        for _ in 0..3 {
            self.clock.pass(Duration::from_secs(100));
            assert!(self.recorder().flush());
        }
    }

    fn reader(&self) -> Reader {
        Reader::open(&self.path).unwrap()
    }

    /// The number of samples, spans of 10 s, notes, audit entries, history rows and waiting notifications.
    fn rows(&self) -> [usize; 6] {
        let reader = self.reader();
        let (from, to) = (Micros(i64::MIN), Micros(i64::MAX));
        let spans = "SELECT count(*) FROM span WHERE level = 1";
        let connection = rusqlite::Connection::open(&self.path).unwrap();
        [
            reader.samples("chamber", from, to).unwrap().len(),
            connection.query_row(spans, [], |row| row.get::<_, u32>(0)).unwrap() as usize,
            reader.events(from, to, 1000).unwrap().iter().filter(|event| event.kind == EventKind::Note).count(),
            reader.audit(&AuditQuery { from, to, gauge: None, user: None, limit: 1000 }).unwrap().len(),
            reader.alarm_history(from, to, None, 1000).unwrap().len(),
            reader.queued_notifications("log").unwrap().len(),
        ]
    }

    /// The texts of the events about the station, the earliest first.
    fn station_events(&self) -> Vec<String> {
        let events = self.reader().events(Micros(i64::MIN), Micros(i64::MAX), 1000).unwrap();
        let own = events.into_iter().rev().filter(|event| event.kind == EventKind::Station);
        own.map(|event| event.text).collect()
    }
}

fn audit_entry(at: Micros) -> AuditEntry {
    AuditEntry {
        id: 0,
        at,
        action: AuditAction::Acknowledged.into(),
        refers_to: None,
        user: "Otto".to_owned(),
        role: Role::Operator.into(),
        peer: None,
        gauge: None,
        segment: None,
        address: None,
        target: None,
        before: None,
        after: None,
        outcome: None,
        command_id: None,
    }
}

fn history_entry(at: Micros, text: &str) -> AlarmHistoryEntry {
    AlarmHistoryEntry {
        at,
        alarm: "high".to_owned(),
        change: AlarmChangeKind::Raised.into(),
        state: AlarmState::Unacknowledged.into(),
        priority: Priority::High.into(),
        subject: None,
        occurrence: 1,
        user: None,
        value: None,
        unit: None,
        text: text.to_owned(),
    }
}

#[test]
fn rows_are_deleted_after_their_retention_of_recorded_time() {
    let mut station = Station::new();
    station.stop();
    station.retention = Retention {
        samples: Some(DAY * 10),
        spans: [Some(DAY * 20), None, None, None],
        events: Some(DAY * 30),
        alarm_history: Some(DAY * 40),
        ..Retention::default()
    };
    station.start();
    station.record("first");
    let kept = |station: &Station| station.rows().map(|rows| rows == 1);
    for (days, expected) in [
        (9, [true; 6]),
        (2, [false, true, true, true, true, true]),
        (10, [false, false, true, true, true, true]),
        (10, [false, false, false, true, true, true]),
        // The audit trail and waiting notifications have no retention here.
        (10, [false, false, false, true, false, true]),
    ] {
        station.run_days(days);
        assert_eq!(kept(&station), expected);
    }
    let coarse = station.reader().trend("chamber", NEW_YEAR, NEW_YEAR.after(DAY), 10).unwrap();
    assert_eq!(coarse.iter().map(|span| span.summary.count).sum::<u32>(), 1, "coarse spans are kept");
}

#[test]
fn a_clock_that_is_years_wrong_at_a_start_deletes_nothing_and_is_reported() {
    for (days, words) in [(3 * YEAR, "after the end of the database"), (-3 * YEAR, "before the end of the database")] {
        let mut station = Station::new();
        station.record("first");
        station.stop();
        station.clock.set_by(days);
        station.start();
        station.record("second");
        assert_eq!(station.rows(), [2; 6], "{days}");
        let reported = station.station_events();
        assert!(
            reported.len() == 1
                && reported[0].contains(words)
                && reported[0].ends_with("nothing is deleted because of this")
        );
        // The clock is corrected.
        station.stop();
        station.clock.set_by(-days);
        station.start();
        station.record("third");
        assert_eq!(station.rows(), [3; 6], "{days}");
    }
}

#[test]
fn a_clock_that_jumps_by_years_during_a_run_deletes_nothing_and_is_reported() {
    for (days, words) in
        [(7 * YEAR, "the clock was set forward by 2555.0 days"), (-7 * YEAR, "the clock was set back by 2555.0 days")]
    {
        let station = Station::new();
        station.record("first");
        station.clock.set_by(days);
        station.record("second");
        assert_eq!(station.rows(), [2; 6], "{days}");
        station.clock.set_by(-days);
        station.record("third");
        assert_eq!(station.rows(), [3; 6], "{days}");
        let reported = station.station_events();
        assert!(reported.len() == 2 && reported[0].starts_with(words), "{reported:?}");
    }
}

#[test]
fn a_wrong_clock_deletes_neither_new_nor_early_rows_of_a_full_database() {
    let mut station = Station::new();
    station.stop();
    station.retention = Retention { samples: Some(DAY * 10), ..Retention::default() };
    station.start();
    station.record("first");
    station.run_days(8);
    station.record("second");
    for days in [3 * YEAR, -3 * YEAR, -50 * YEAR, 50 * YEAR] {
        station.clock.set_by(days);
        station.record("wrong");
    }
    assert_eq!(station.rows()[0], 6);
    // Ten days of recording after them, all are beyond the retention, wherever their clock stood.
    station.run_days(11);
    let left = station.reader().samples("chamber", Micros(i64::MIN), Micros(i64::MAX)).unwrap();
    assert_eq!(left, [], "none is left");
}

#[test]
fn a_row_of_the_last_minute_before_a_step_back_expires_too() {
    let mut station = Station::new();
    station.stop();
    station.retention = Retention { samples: Some(DAY * 10), ..Retention::default() };
    station.clock.set_by(3 * YEAR);
    station.start();
    station.record("ahead");
    station.clock.pass(Duration::from_secs(20));
    let at = station.clock.now().wall;
    station.recorder().push(&Arc::from("chamber"), Sample::new(at, Some(1.0), Quality::Valid));
    assert!(station.recorder().flush());
    station.clock.set_by(-3 * YEAR);
    station.run_days(11);
    assert_eq!(station.rows()[0], 0);
}

#[test]
fn an_event_with_a_future_time_does_not_stay_on_top() {
    let station = Station::new();
    station.record("first");
    station.clock.set_by(9 * YEAR);
    station.record("from a clock that was ahead");
    station.clock.set_by(-9 * YEAR);
    station.record("last");
    let events = station.reader().events(Micros(0), Micros(i64::MAX), 1000).unwrap();
    let notes: Vec<_> = events.iter().filter(|event| event.kind == EventKind::Note).map(|note| &*note.text).collect();
    assert_eq!(notes, ["last", "from a clock that was ahead", "first"]);
    let history = station.reader().alarm_history(Micros(0), Micros(i64::MAX), None, 1).unwrap();
    assert_eq!(history[0].text, "last");
}

#[test]
fn a_waiting_notification_grows_old_with_recorded_time_only() {
    let mut station = Station::new();
    station.record("first");
    let is_old =
        |station: &Station| station.reader().expired(DAY, station.clock.now().wall).unwrap().contains(NEW_YEAR);
    station.clock.set_by(3 * YEAR);
    station.record("second");
    assert!(!is_old(&station));
    station.stop();
    station.clock.set_by(-6 * YEAR);
    station.start();
    station.record("third");
    assert!(!is_old(&station));
    station.clock.set_by(3 * YEAR);
    station.run_days(2);
    assert!(is_old(&station));
}
