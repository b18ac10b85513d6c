//! The database is in use, in an impossible place, deleted, locked by another program, full of old rows, or read by a slow reader.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::common::{Fixture, keep_everything};
use crate::until::until;
use profivac_model::{AlarmState, AlarmStatus, Attribution, Declaration, Role};
use profivac_recorder::alarms::AlarmBatch;
use profivac_recorder::audit::AuditQuery;
use profivac_recorder::database::Database;
use profivac_recorder::spans::PendingSpans;
use profivac_recorder::{
    AuditAction, AuditEntry, Event, EventKind, Export, Micros, Quality, Reader, Recorder, Retention, Sample, Settings,
};
use rusqlite::Connection;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

fn samples(fixture: &Fixture) -> Vec<Sample> {
    fixture.reader().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap()
}

fn sample(number: i64, pa: f64) -> Sample {
    Sample::new(Micros(Micros::SECOND * (1_767_225_600 + number)), Some(pa), Quality::Valid)
}

fn push(recorder: &Recorder, samples: impl IntoIterator<Item = Sample>) {
    let gauge: Arc<str> = Arc::from("chamber");
    samples.into_iter().for_each(|sample| recorder.push(&gauge, sample));
}

fn event(text: &str) -> Event {
    Event { at: Micros(Micros::SECOND), gauge: None, kind: EventKind::Note.into(), text: text.to_owned() }
}

fn entry(what: AuditAction, of: Option<i64>) -> AuditEntry {
    AuditEntry {
        id: 0,
        at: Micros(Micros::SECOND),
        action: what.into(),
        refers_to: of,
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
        command_id: Some("1-1".to_owned()),
    }
}

fn start_error(path: &Path) -> String {
    Recorder::start(path, Settings::default()).map(drop).unwrap_err().to_string()
}

#[test]
fn a_second_station_cannot_use_the_database() {
    let fixture = Fixture::new();
    let first = fixture.recorder(keep_everything());
    let sentence = format!("{} is in use by another station", fixture.path.display());
    assert_eq!(start_error(&fixture.path), sentence);
    drop(first);
    drop(fixture.recorder(keep_everything()));
}

#[test]
fn an_error_says_why_there_can_be_no_database() {
    let fixture = Fixture::new();
    let folder = fixture.path.parent().unwrap();
    assert_eq!(start_error(folder), format!("{}: expected a database file, got a folder", folder.display()));
    let nowhere = folder.join("no such folder").join("plant.db");
    assert_eq!(
        start_error(&nowhere),
        format!(
            "{}: the database cannot be opened for writing: No such file or directory (os error 2)",
            nowhere.display()
        )
    );
    // Not even root may create a file here.
    assert!(
        start_error(Path::new("/proc/plant.db"))
            .starts_with("/proc/plant.db: the database cannot be opened for writing: ")
    );
}

#[test]
fn a_database_deleted_during_a_run_is_created_again_with_an_event_and_the_states_of_the_alarms() {
    let fixture = Fixture::new();
    let alarm = |state| AlarmStatus { state, ..AlarmStatus::default() };
    let batch = |name: &str, state: Option<AlarmState>| AlarmBatch {
        alarms: BTreeMap::from([(name.to_owned(), state.map(alarm))]),
        ..AlarmBatch::default()
    };
    // States of an earlier run count as well.
    assert!(
        fixture.recorder(keep_everything()).record_alarms(batch("before", Some(AlarmState::Acknowledged)), Vec::new())
    );
    let recorder = fixture.recorder(keep_everything());
    push(&recorder, [sample(0, 1.0)]);
    assert!(recorder.record_alarms_with_receipt(batch("high", Some(AlarmState::Unacknowledged)), Vec::new()).wait());
    assert!(recorder.record_alarms_with_receipt(batch("gone", Some(AlarmState::Returned)), Vec::new()).wait());
    assert!(recorder.record_alarms_with_receipt(batch("gone", None), Vec::new()).wait());
    let by = Attribution { user: "Ada".to_owned(), at: Micros(1) };
    let vented = Declaration { by, reason: "so".to_owned(), until: Micros(9) };
    let declare = |name: &str, state: Option<&Declaration>| AlarmBatch {
        plant_states: BTreeMap::from([(name.to_owned(), state.cloned())]),
        ..AlarmBatch::default()
    };
    for (name, state) in [("Vented", Some(&vented)), ("Bake-out", Some(&vented)), ("Bake-out", None)] {
        assert!(recorder.record_alarms_with_receipt(declare(name, state), Vec::new()).wait());
    }
    fs::remove_file(&fixture.path).unwrap();
    push(&recorder, [sample(1, 2.0)]);
    assert!(recorder.flush());
    // The event keeps the full rate of the last seconds, so the new file begins with them.
    assert_eq!(samples(&fixture), [sample(0, 1.0), sample(1, 2.0)]);
    let reader = fixture.reader();
    let events: Vec<_> = reader.events(Micros(0), Micros(i64::MAX), 10).unwrap();
    assert_eq!(events.len(), 1, "{events:?}");
    assert!(events[0].text.starts_with("the database was deleted or replaced while the station recorded into it: "));
    let states: Vec<_> = reader.alarms().unwrap().into_iter().map(|(name, alarm)| (name, alarm.state)).collect();
    let expected = [("before", AlarmState::Acknowledged), ("high", AlarmState::Unacknowledged)];
    assert_eq!(states, expected.map(|(name, state)| (name.to_owned(), state)));
    assert_eq!(reader.plant_states().unwrap(), [("Vented".to_owned(), vented)]);
    push(&recorder, [sample(2, 3.0)]);
    drop(recorder);
    assert_eq!(samples(&fixture), [sample(0, 1.0), sample(1, 2.0), sample(2, 3.0)]);
    assert_eq!(fixture.reader().events(Micros(0), Micros(i64::MAX), 10).unwrap().len(), 1, "reported once");
}

#[test]
fn the_database_its_log_and_its_lock_are_private_also_behind_a_dangling_link() {
    let fixture = Fixture::new();
    let folder = fixture.path.parent().unwrap();
    let target = folder.join("elsewhere.db");
    symlink(&target, &fixture.path).unwrap();
    // A lock file of an earlier version may be open to others.
    let lock = folder.join("plant.db-lock");
    fs::write(&lock, "").unwrap();
    fs::set_permissions(&lock, fs::Permissions::from_mode(0o666)).unwrap();
    let recorder = fixture.recorder(keep_everything());
    push(&recorder, [sample(0, 1.0)]);
    assert!(recorder.flush());
    for file in fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()).filter(|file| !file.is_symlink()) {
        let mode = fs::metadata(&file).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode, 0o600, "{}", file.display());
    }
    assert!(target.exists());
}

#[test]
fn a_database_of_another_program_is_refused_and_not_changed() {
    let fixture = Fixture::new();
    let foreign = [
        "CREATE TABLE note (text TEXT)",
        "CREATE TABLE note (text TEXT); PRAGMA user_version = 3",
        "CREATE TABLE note (text TEXT); PRAGMA user_version = 4",
        "CREATE TABLE note (text TEXT); PRAGMA user_version = 5",
        "CREATE TABLE series (id); CREATE TABLE sample (id); PRAGMA user_version = 4",
        "PRAGMA application_id = 77; CREATE TABLE series (id)",
    ];
    for sql in foreign {
        fs::remove_file(&fixture.path).ok();
        Connection::open(&fixture.path).unwrap().execute_batch(sql).unwrap();
        let before = fs::read(&fixture.path).unwrap();
        let expected =
            format!("{} is a SQLite database, but not one of profivac; choose another file", fixture.path.display());
        assert_eq!(start_error(&fixture.path), expected, "{sql}");
        assert_eq!(Reader::open(&fixture.path).map(drop).unwrap_err().to_string(), expected, "{sql}");
        assert_eq!(fs::read(&fixture.path).unwrap(), before, "{sql}");
    }
    fs::write(&fixture.path, "").unwrap();
    assert!(Reader::open(&fixture.path).map(drop).unwrap_err().to_string().contains("found an empty one"));
    drop(fixture.recorder(keep_everything()));
    drop(fixture.reader());
}

#[test]
fn an_outcome_is_written_after_the_database_of_its_command_was_deleted() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    recorder.audit_before_sending(entry(AuditAction::Execute, None)).unwrap();
    let command = recorder.audit_before_sending(entry(AuditAction::Execute, None)).unwrap();
    fs::remove_file(&fixture.path).unwrap();
    assert!(recorder.audit(entry(AuditAction::Outcome, Some(command))).wait());
    push(&recorder, [sample(0, 1.0)]);
    assert!(recorder.flush());
    assert_eq!((samples(&fixture), recorder.health().error), (vec![sample(0, 1.0)], None));
    let wanted = AuditQuery { from: Micros(0), to: Micros(i64::MAX), gauge: None, user: None, limit: 10 };
    let rows = fixture.reader().audit(&wanted).unwrap();
    assert_eq!(rows.len(), 1);
    assert_eq!(rows[0].action, AuditAction::Outcome);
    assert_eq!(rows[0].refers_to, None, "the row it refers to is deleted");
}

#[test]
fn the_recorder_continues_when_the_folder_of_the_database_is_back() {
    let fixture = Fixture::new();
    let folder = fixture.path.parent().unwrap().join("disk");
    fs::create_dir(&folder).unwrap();
    let fixture = fixture.at(folder.join("plant.db"));
    let recorder = fixture.recorder(keep_everything());
    push(&recorder, [sample(0, 1.0)]);
    assert!(recorder.flush());
    let away = folder.with_file_name("away");
    fs::rename(&folder, &away).unwrap();
    push(&recorder, [sample(1, 2.0)]);
    until("an error", || recorder.health().error.is_some().then_some(()));
    assert!(recorder.health().error.unwrap().contains("the database cannot be opened for writing"));
    fs::rename(&away, &folder).unwrap();
    assert!(recorder.flush());
    assert_eq!(samples(&fixture), [sample(0, 1.0), sample(1, 2.0)]);
    assert_eq!((recorder.health().error, recorder.health().lost_samples), (None, 0));
}

#[test]
fn a_database_locked_by_another_program_blocks_no_sender_and_lost_events_are_counted() {
    const MANY: usize = 90_000;
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    let other = Connection::open(&fixture.path).unwrap();
    other.execute_batch("BEGIN IMMEDIATE").unwrap();
    push(&recorder, [sample(0, 1.0)]);
    until("an error", || recorder.health().error.is_some().then_some(()));
    assert!(recorder.health().error.unwrap().ends_with("database is locked"));
    (0..MANY).for_each(|number| recorder.record_event(event(&number.to_string())));
    other.execute_batch("COMMIT").unwrap();
    until("it is written again", || recorder.flush().then_some(()));
    let kept = fixture.reader().events(Micros(0), Micros(i64::MAX), u32::MAX).unwrap().len();
    let lost = usize::try_from(recorder.health().lost_events).unwrap();
    assert!(lost > 0, "more than the memory takes");
    assert_eq!(kept + lost, MANY);
    assert_eq!((samples(&fixture), recorder.health().error), (vec![sample(0, 1.0)], None));
}

#[test]
fn two_samples_of_one_time_are_both_kept_and_a_repeated_sample_once() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    // The clock was set back, and the same time occurs again.
    push(&recorder, [sample(0, 1.0), sample(1, 2.0), sample(0, 3.0), sample(0, 3.0)]);
    assert!(recorder.flush());
    let pressures: Vec<_> = samples(&fixture).iter().map(|sample| sample.pa.unwrap()).collect();
    assert_eq!(pressures, [1.0, 3.0, 2.0]);
    assert_eq!(recorder.health().lost_samples, 0);
    let spans = fixture.reader().trend("chamber", Micros(0), sample(100, 1.0).at, 10).unwrap();
    assert_eq!(spans.iter().map(|span| span.summary.count).sum::<u32>(), 4, "every sample is counted");
}

#[test]
fn a_slow_reader_does_not_let_the_log_grow() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    push(&recorder, (0..10_000).map(|number| sample(number, 1.0)));
    assert!(recorder.flush());
    let mut export = Export::new(fixture.reader(), vec!["chamber".to_owned()], Micros(0), Micros(i64::MAX));
    assert_eq!(export.by_ref().take(2).map(Result::unwrap).count(), 2);
    for round in 1..40 {
        push(&recorder, (0..10_000).map(|number| sample(round * 10_000 + number, 1.0)));
        assert!(recorder.flush());
    }
    let log = fs::metadata(fixture.path.with_file_name("plant.db-wal")).unwrap().len();
    assert!(log < 16 << 20, "{log} octets");
    let rows: usize = export.map(|piece| piece.unwrap().lines().count()).sum();
    assert_eq!(rows, 400_000 - 2_000, "the export contains samples that were recorded meanwhile");
}

#[test]
fn deleted_rows_return_their_pages_to_the_disk() {
    let fixture = Fixture::new();
    let begin = sample(0, 1.0).at;
    let mut database = Database::open(&fixture.path, begin).unwrap();
    let gauge = database.series_index("chamber");
    let samples: Vec<_> = (0..100_000).map(|number| (gauge, sample(number, 1.0))).collect();
    database.write(&samples, &PendingSpans::default(), &[], &AlarmBatch::default()).unwrap();
    let pages = |what: &str| -> i64 {
        let connection = Connection::open(&fixture.path).unwrap();
        connection.query_row(&format!("PRAGMA {what}"), [], |row| row.get(0)).unwrap()
    };
    let full = pages("page_count");
    let retention = Retention { samples: Some(Duration::ZERO), ..Retention::default() };
    database.extend_period(sample(200_000, 1.0).at).unwrap();
    let rounds = (0..100).take_while(|_| database.prune(&retention).unwrap()).count();
    assert_eq!(rounds, 5, "20000 rows at a time");
    assert!(full > 500 && pages("page_count") < 50, "{} pages of {full}", pages("page_count"));
    assert_eq!(pages("freelist_count"), 0);
}

#[test]
fn a_trend_without_samples_uses_spans() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    push(&recorder, (0..100).map(|number| sample(number, 1.0)));
    assert!(recorder.flush());
    Connection::open(&fixture.path).unwrap().execute("DELETE FROM sample", []).unwrap();
    let spans = fixture.reader().trend("chamber", sample(0, 1.0).at, sample(99, 1.0).at, 1000).unwrap();
    assert_eq!(spans.iter().map(|span| span.summary.count).sum::<u32>(), 100);
    assert_eq!(spans.len(), 10);
}

#[test]
fn a_long_list_of_events_has_the_order_and_the_range_of_a_short_one() {
    let fixture = Fixture::new();
    let mut database = Database::open(&fixture.path, Micros(0)).unwrap();
    let at = |number: i64| Micros(number * Micros::SECOND);
    // The times run back, so the order of recording differs from that of the times.
    let numbers = (0..40_000).rev().map(|number| Event { at: at(number), ..event(&number.to_string()) });
    let events: Vec<_> = numbers.collect();
    for piece in events.chunks(10_000) {
        database.write(&[], &PendingSpans::default(), piece, &AlarmBatch::default()).unwrap();
    }
    let reader = fixture.reader();
    let texts = |from: i64, to: i64| {
        let events = reader.events(at(from), at(to), 3).unwrap();
        events.into_iter().map(|event| event.text).collect::<Vec<_>>()
    };
    assert_eq!(texts(0, 40_000), ["0", "1", "2"]);
    assert_eq!(texts(100, 39_000), ["100", "101", "102"]);
    assert_eq!(texts(38_000, 38_001), ["38000", "38001"]);
}
