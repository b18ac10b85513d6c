//! A disk as careless people and hard times leave it: the record is in use, in the wrong place, deleted, locked, full of what
//! is old, and read by somebody slow.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_recorder::alarms::AlarmBatch;
use profivac_recorder::audit::AuditQuery;
use profivac_recorder::database::Database;
use profivac_recorder::spans::PendingSpans;
use profivac_recorder::{
    AuditAction, AuditEntry, Deadband, Event, EventKind, Export, Micros, Quality, Reader, Recorder, Retention, Sample,
    Settings,
};
use rusqlite::Connection;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Long enough for a computer that is busy with something else.
const PATIENCE: Duration = Duration::from_secs(60);

struct Desk {
    _folder: TempDir,
    path: PathBuf,
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        Self { _folder: folder, path }
    }

    fn recorder(&self) -> Recorder {
        let for_ever = Duration::from_secs(1_000_000_000);
        let settings = Settings {
            deadband: Deadband { decades: 0.0, max_interval: Duration::ZERO },
            full_rate_window: Duration::from_secs(5),
            retention: Retention { samples: for_ever, spans: [None; 4] },
        };
        Recorder::start(&self.path, settings).unwrap()
    }

    fn reader(&self) -> Reader {
        Reader::open(&self.path).unwrap()
    }

    fn samples(&self) -> Vec<Sample> {
        self.reader().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap()
    }
}

fn sample(number: i64, pa: f64) -> Sample {
    Sample::new(Micros(Micros::SECOND * (1_767_225_600 + number)), Some(pa), Quality::Valid)
}

fn push(recorder: &Recorder, samples: impl IntoIterator<Item = Sample>) {
    let gauge: Arc<str> = Arc::from("chamber");
    samples.into_iter().for_each(|sample| recorder.push(&gauge, sample));
}

fn event(text: &str) -> Event {
    Event { at: Micros(Micros::SECOND), gauge: None, kind: EventKind::Note, text: text.to_owned() }
}

fn entry(what: AuditAction, of: Option<i64>) -> AuditEntry {
    AuditEntry {
        at: Micros(Micros::SECOND),
        action: what,
        refers_to: of,
        who: "Otto".to_owned(),
        role: "operator".to_owned(),
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

fn refusal(path: &Path) -> String {
    Recorder::start(path, Settings::default()).map(drop).unwrap_err().to_string()
}

fn until(what: &str, mut seen: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !seen() {
        assert!(Instant::now() < end, "never seen: {what}");
        std::thread::yield_now();
    }
}

#[test]
fn two_stations_do_not_share_a_record() {
    let desk = Desk::new();
    let first = desk.recorder();
    let sentence = format!("{} is already recorded into by another station", desk.path.display());
    assert_eq!(refusal(&desk.path), sentence);
    drop(first);
    drop(desk.recorder());
}

#[test]
fn a_place_where_no_record_can_be_is_told() {
    let desk = Desk::new();
    let folder = desk.path.parent().unwrap();
    assert_eq!(refusal(folder), format!("{}: expected a file to record into, got a folder", folder.display()));
    let nowhere = folder.join("no such folder").join("plant.db");
    assert_eq!(
        refusal(&nowhere),
        format!("{}: nothing can be recorded here: No such file or directory (os error 2)", nowhere.display())
    );
    // Where nobody may write, not even root.
    assert!(refusal(Path::new("/proc/plant.db")).starts_with("/proc/plant.db: nothing can be recorded here: "));
}

#[test]
fn a_record_that_is_deleted_is_begun_again() {
    let desk = Desk::new();
    let recorder = desk.recorder();
    push(&recorder, [sample(0, 1.0)]);
    assert!(recorder.flush());
    fs::remove_file(&desk.path).unwrap();
    push(&recorder, [sample(1, 2.0)]);
    assert!(recorder.flush());
    assert_eq!(desk.samples(), [sample(1, 2.0)]);
    push(&recorder, [sample(2, 3.0)]);
    drop(recorder);
    assert_eq!(desk.samples(), [sample(1, 2.0), sample(2, 3.0)]);
}

#[test]
fn what_came_of_something_is_written_though_the_record_was_deleted_meanwhile() {
    let desk = Desk::new();
    let recorder = desk.recorder();
    recorder.audit_before_sending(entry(AuditAction::Execute, None)).unwrap();
    let fired = recorder.audit_before_sending(entry(AuditAction::Execute, None)).unwrap();
    fs::remove_file(&desk.path).unwrap();
    assert!(recorder.audit(entry(AuditAction::Outcome, Some(fired))).wait());
    push(&recorder, [sample(0, 1.0)]);
    assert!(recorder.flush());
    assert_eq!((desk.samples(), recorder.health().error), (vec![sample(0, 1.0)], None));
    let wanted = AuditQuery { from: Micros(0), to: Micros(i64::MAX), gauge: None, who: None, limit: 10 };
    let rows = desk.reader().audit(&wanted).unwrap();
    assert_eq!(rows.len(), 1);
    assert_eq!(
        (rows[0].entry.action, rows[0].entry.refers_to),
        (AuditAction::Outcome, None),
        "the row it belongs to is gone"
    );
}

#[test]
fn a_record_whose_folder_is_away_goes_on_when_it_is_back() {
    let desk = Desk::new();
    let folder = desk.path.parent().unwrap().join("disk");
    fs::create_dir(&folder).unwrap();
    let desk = Desk { path: folder.join("plant.db"), ..desk };
    let recorder = desk.recorder();
    push(&recorder, [sample(0, 1.0)]);
    assert!(recorder.flush());
    let away = folder.with_file_name("away");
    fs::rename(&folder, &away).unwrap();
    push(&recorder, [sample(1, 2.0)]);
    until("an error", || recorder.health().error.is_some());
    assert!(recorder.health().error.unwrap().contains("nothing can be recorded here"));
    fs::rename(&away, &folder).unwrap();
    assert!(recorder.flush());
    assert_eq!(desk.samples(), [sample(0, 1.0), sample(1, 2.0)]);
    assert_eq!((recorder.health().error, recorder.health().lost_samples), (None, 0));
}

#[test]
fn while_another_program_has_the_record_nobody_waits_and_what_is_lost_is_counted() {
    const MANY: usize = 90_000;
    let desk = Desk::new();
    let recorder = desk.recorder();
    let other = Connection::open(&desk.path).unwrap();
    other.execute_batch("BEGIN IMMEDIATE").unwrap();
    push(&recorder, [sample(0, 1.0)]);
    until("an error", || recorder.health().error.is_some());
    assert!(recorder.health().error.unwrap().ends_with("database is locked"));
    (0..MANY).for_each(|number| recorder.record_event(event(&number.to_string())));
    other.execute_batch("COMMIT").unwrap();
    until("it is written again", || recorder.flush());
    let kept = desk.reader().events(Micros(0), Micros(i64::MAX), u32::MAX).unwrap().len();
    let lost = usize::try_from(recorder.health().lost_events).unwrap();
    assert!(lost > 0, "more than memory may take");
    assert_eq!(kept + lost, MANY);
    assert_eq!((desk.samples(), recorder.health().error), (vec![sample(0, 1.0)], None));
}

#[test]
fn two_samples_of_one_moment_are_both_kept_and_one_sample_once() {
    let desk = Desk::new();
    let recorder = desk.recorder();
    // The clock was set back, and the same moment comes again.
    push(&recorder, [sample(0, 1.0), sample(1, 2.0), sample(0, 3.0), sample(0, 3.0)]);
    assert!(recorder.flush());
    let pressures: Vec<_> = desk.samples().iter().map(|sample| sample.pa.unwrap()).collect();
    assert_eq!(pressures, [1.0, 3.0, 2.0]);
    assert_eq!(recorder.health().lost_samples, 0);
    let bins = desk.reader().trend("chamber", Micros(0), sample(100, 1.0).at, 10).unwrap();
    assert_eq!(bins.iter().map(|bin| bin.summary.count).sum::<u32>(), 4, "each was measured");
}

#[test]
fn a_slow_reader_does_not_make_the_log_grow() {
    let desk = Desk::new();
    let recorder = desk.recorder();
    push(&recorder, (0..10_000).map(|number| sample(number, 1.0)));
    assert!(recorder.flush());
    let mut export = Export::new(desk.reader(), vec!["chamber".to_owned()], Micros(0), Micros(i64::MAX));
    assert_eq!(export.by_ref().take(2).map(Result::unwrap).count(), 2);
    for round in 1..40 {
        push(&recorder, (0..10_000).map(|number| sample(round * 10_000 + number, 1.0)));
        assert!(recorder.flush());
    }
    let log = fs::metadata(desk.path.with_file_name("plant.db-wal")).unwrap().len();
    assert!(log < 16 << 20, "{log} octets");
    let rows: usize = export.map(|piece| piece.unwrap().lines().count()).sum();
    assert_eq!(rows, 400_000 - 2_000, "what came meanwhile is in the table");
}

#[test]
fn what_is_deleted_gives_its_room_back() {
    let desk = Desk::new();
    let mut store = Database::open(&desk.path).unwrap();
    let gauge = store.series_index("chamber");
    let samples: Vec<_> = (0..100_000).map(|number| (gauge, sample(number, 1.0))).collect();
    store.write(&samples, &PendingSpans::default(), &[], &AlarmBatch::default()).unwrap();
    let pages = |what: &str| -> i64 {
        let connection = Connection::open(&desk.path).unwrap();
        connection.query_row(&format!("PRAGMA {what}"), [], |row| row.get(0)).unwrap()
    };
    let full = pages("page_count");
    let retention = Retention { samples: Duration::ZERO, spans: [None; 4] };
    let rounds = (0..100).take_while(|_| store.prune(&retention, Micros(i64::MAX)).unwrap()).count();
    assert_eq!(rounds, 5, "20000 at a time");
    assert!(full > 500 && pages("page_count") < 50, "{} pages of {full}", pages("page_count"));
    assert_eq!(pages("freelist_count"), 0);
}

#[test]
fn where_samples_are_gone_spans_are_drawn() {
    let desk = Desk::new();
    let recorder = desk.recorder();
    push(&recorder, (0..100).map(|number| sample(number, 1.0)));
    assert!(recorder.flush());
    Connection::open(&desk.path).unwrap().execute("DELETE FROM sample", []).unwrap();
    let bins = desk.reader().trend("chamber", sample(0, 1.0).at, sample(99, 1.0).at, 1000).unwrap();
    assert_eq!(bins.iter().map(|bin| bin.summary.count).sum::<u32>(), 100);
    assert_eq!(bins.len(), 10);
}
