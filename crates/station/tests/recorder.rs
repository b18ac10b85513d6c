//! What the recorder takes, keeps and gives back.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_recorder::{
    Deadband, Event, EventKind, Export, Micros, Quality, Reader, Recorder, Retention, Sample, Settings,
};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;

const DAY: i64 = 86_400 * Micros::SECOND;

/// 2026-01-01.
const NEW_YEAR: i64 = 1_767_225_600 * Micros::SECOND;

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

    fn recorder(&self, settings: Settings) -> Recorder {
        Recorder::start(&self.path, settings).unwrap()
    }

    fn reader(&self) -> Reader {
        Reader::open(&self.path).unwrap()
    }
}

/// Everything is kept, nothing ever deleted.
fn everything() -> Settings {
    let for_ever = Duration::from_secs(1_000_000_000);
    Settings {
        deadband: Deadband { decades: 0.0, max_interval: Duration::ZERO },
        full_rate_window: Duration::from_secs(5),
        retention: Retention { samples: for_ever, spans: [None; 4] },
    }
}

fn at(second: i64) -> Micros {
    Micros(NEW_YEAR + second * Micros::SECOND)
}

fn valid(second: i64, pa: f64) -> Sample {
    Sample::new(at(second), Some(pa), Quality::Valid)
}

/// Who did what stands there. A record that is there keeps the rights that somebody gave it.
#[test]
fn a_new_record_is_its_owners_alone_and_so_is_its_log() {
    use std::fs::{Permissions, metadata, set_permissions};
    use std::os::unix::fs::PermissionsExt;
    let desk = Desk::new();
    let modes = || {
        let mode = |ending: &str| metadata(format!("{}{ending}", desk.path.display())).unwrap().permissions().mode();
        ["", "-wal", "-shm"].map(|ending| mode(ending) & 0o777)
    };
    let recorder = desk.recorder(everything());
    assert!(recorder.flush());
    assert_eq!(modes(), [0o600; 3]);
    drop(recorder);
    set_permissions(&desk.path, Permissions::from_mode(0o640)).unwrap();
    let recorder = desk.recorder(everything());
    assert!(recorder.flush());
    assert_eq!(modes(), [0o640; 3]);
}

fn gauge() -> Arc<str> {
    Arc::from("chamber")
}

#[test]
fn what_was_pushed_comes_back_with_its_quality() {
    let desk = Desk::new();
    let samples = [
        valid(0, 1e-6),
        Sample::new(at(1), Some(1e-8), Quality::Underrange),
        Sample::new(at(2), None, Quality::Invalid),
        Sample::gap(at(3)),
        Sample::new(at(4), Some(1e5), Quality::Overrange),
    ];
    let recorder = desk.recorder(everything());
    samples.iter().for_each(|sample| recorder.push(&gauge(), *sample));
    assert!(recorder.flush());
    assert_eq!(desk.reader().samples("chamber", at(0), at(10)).unwrap(), samples);
    assert_eq!(desk.reader().gauges().unwrap(), ["chamber"]);
    assert_eq!(desk.reader().samples("nobody", at(0), at(10)).unwrap(), []);
}

#[test]
fn a_steady_pressure_takes_little_room_and_its_end_is_known() {
    let desk = Desk::new();
    let recorder = desk.recorder(Settings { retention: everything().retention, ..Settings::default() });
    (0..600).for_each(|second| recorder.push(&gauge(), valid(second, 1e-6)));
    drop(recorder);
    let kept = desk.reader().samples("chamber", at(0), at(1000)).unwrap();
    let seconds: Vec<_> = kept.iter().map(|sample| (sample.at.0 - NEW_YEAR) / Micros::SECOND).collect();
    assert_eq!(seconds, [0, 60, 120, 180, 240, 300, 360, 420, 480, 540, 599]);
}

#[test]
fn around_an_event_every_sample_is_kept() {
    let desk = Desk::new();
    let settings =
        Settings { full_rate_window: Duration::from_secs(5), retention: everything().retention, ..Settings::default() };
    let recorder = desk.recorder(settings);
    (0..20).for_each(|second| recorder.push(&gauge(), valid(second, 1e-6)));
    let event =
        Event { at: at(19), gauge: Some("chamber".to_owned()), kind: EventKind::Gauge, text: "degas".to_owned() };
    assert!(recorder.record_event_and_wait(event.clone()));
    (20..40).for_each(|second| recorder.push(&gauge(), valid(second, 1e-6)));
    assert!(recorder.flush());
    let kept = desk.reader().samples("chamber", at(0), at(100)).unwrap();
    let seconds: Vec<_> = kept.iter().map(|sample| (sample.at.0 - NEW_YEAR) / Micros::SECOND).collect();
    assert_eq!(seconds, [0, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24]);
    assert_eq!(desk.reader().events(at(0), at(100), 10).unwrap(), [event]);
}

#[test]
fn a_picture_shows_extremes_at_every_zoom() {
    let desk = Desk::new();
    let recorder = desk.recorder(everything());
    // A day at a sample a second, with one second of 1 Pa in it.
    for second in 0..86_400 {
        recorder.push(&gauge(), valid(second, if second == 40_000 { 1.0 } else { 1e-6 }));
        assert!(second % 10_000 != 0 || recorder.flush());
    }
    assert!(recorder.flush());
    assert_eq!(recorder.health().lost_samples, 0);
    let reader = desk.reader();
    for (from, to, pixels) in
        [(0, 86_400, 2000), (0, 86_400, 100), (0, 86_400, 4), (39_000, 41_000, 2000), (30_000, 50_000, 300)]
    {
        let bins = reader.trend("chamber", at(from), at(to), pixels).unwrap();
        assert!(bins.len() <= pixels as usize + 1, "{} bins in {pixels} pixels", bins.len());
        assert!(bins.windows(2).all(|pair| pair[0].start < pair[1].start));
        let highest = bins.iter().filter_map(|bin| bin.summary.high).fold(0.0, f64::max);
        let lowest = bins.iter().filter_map(|bin| bin.summary.low).fold(1e9, f64::min);
        assert_eq!((lowest, highest), (1e-6, 1.0), "{pixels} pixels");
        let mean = bins[0].summary.mean().unwrap();
        assert!((mean.log10() + 6.0).abs() < 0.01 || pixels == 4, "{mean}");
    }
}

#[test]
fn gaps_are_bins_that_say_so_or_are_not_there() {
    let desk = Desk::new();
    let recorder = desk.recorder(everything());
    (0..100).for_each(|second| recorder.push(&gauge(), valid(second, 1e-6)));
    recorder.push(&gauge(), Sample::gap(at(100)));
    (200..300).for_each(|second| recorder.push(&gauge(), valid(second, 1e-6)));
    assert!(recorder.flush());
    let bins = desk.reader().trend("chamber", at(0), at(300), 30).unwrap();
    let missing: Vec<_> = bins.iter().filter(|bin| bin.summary.count == 0).collect();
    assert_eq!(bins.len(), 21);
    assert_eq!(missing.len(), 1);
    assert!(missing[0].summary.qualities.contains(Quality::Gap));
}

#[test]
fn a_recorder_that_begins_again_goes_on_in_the_same_spans() {
    let desk = Desk::new();
    for first in [0, 5] {
        let recorder = desk.recorder(everything());
        (first..first + 5).for_each(|second| recorder.push(&gauge(), valid(second, 10_f64.powi(second as i32))));
    }
    let bins = desk.reader().trend("chamber", at(0), at(100_000), 10).unwrap();
    assert_eq!(bins.len(), 1);
    let extent = bins[0].summary;
    assert_eq!((extent.low, extent.high, extent.count), (Some(1.0), Some(1e9), 10));
}

#[test]
fn what_is_old_goes_and_what_is_coarse_stays() {
    let desk = Desk::new();
    let now = Micros::now();
    let old = Micros(now.0 - 30 * DAY);
    let retention = Retention {
        samples: Duration::from_secs(86_400),
        spans: [Some(Duration::from_secs(10 * 86_400)), None, None, None],
    };
    let recorder = desk.recorder(Settings { retention, ..everything() });
    for begin in [old, now] {
        (0..10).for_each(|second| {
            recorder.push(&gauge(), Sample::new(Micros(begin.0 + second * Micros::SECOND), Some(1.0), Quality::Valid))
        });
    }
    // The first transaction is followed by the first look for what is old.
    assert!(recorder.flush());
    drop(recorder);
    let reader = desk.reader();
    let samples = reader.samples("chamber", Micros(0), Micros(i64::MAX)).unwrap();
    assert_eq!(samples.len(), 10);
    assert!(samples.iter().all(|sample| sample.at >= now));
    let file = rusqlite::Connection::open(&desk.path).unwrap();
    let spans = |level: u8| -> i64 {
        let sql = "SELECT count(*) FROM rollup WHERE level = ?1 AND start < ?2";
        file.query_row(sql, [i64::from(level), now.0 - DAY], |row| row.get(0)).unwrap()
    };
    assert_eq!((spans(1), spans(2) > 0), (0, true), "spans of 10 s are as old as they may be");
    let near = reader.trend("chamber", old, Micros(old.0 + 100 * Micros::SECOND), 10).unwrap();
    assert_eq!(near.iter().map(|bin| bin.summary.count).sum::<u32>(), 10, "then coarser ones are drawn");
    let year = reader.trend("chamber", Micros(old.0 - DAY), Micros(old.0 + DAY), 100).unwrap();
    assert_eq!(year.iter().map(|bin| bin.summary.count).sum::<u32>(), 10, "coarser spans are kept");
}

#[test]
fn an_export_is_csv_that_anybody_reads() {
    let desk = Desk::new();
    let recorder = desk.recorder(everything());
    let odd: Arc<str> = Arc::from("pump, \"fore\"");
    recorder.push(&odd, valid(0, 1.5e-6));
    recorder.push(&odd, Sample::gap(at(1)));
    assert!(recorder.flush());
    let gauges = desk.reader().gauges().unwrap();
    let csv = Export::new(desk.reader(), gauges, at(0), at(10)).collect::<Result<String, _>>().unwrap();
    let expected = "\
time,gauge,pressure_pa,quality
2026-01-01T00:00:00.000000Z,\"pump, \"\"fore\"\"\",1.5e-6,valid
2026-01-01T00:00:01.000000Z,\"pump, \"\"fore\"\"\",,gap
";
    assert_eq!(csv, expected);
}

#[test]
fn a_file_that_is_none_is_told_with_its_name() {
    let desk = Desk::new();
    std::fs::write(&desk.path, "no database at all, but long enough to have a header of a hundred octets or so, which is what is looked at first").unwrap();
    let complaint = Recorder::start(&desk.path, Settings::default()).map(drop).unwrap_err().to_string();
    assert_eq!(complaint, format!("{}: file is not a database", desk.path.display()));
    let missing = desk.path.with_file_name("missing.db");
    assert!(Reader::open(&missing).map(drop).unwrap_err().to_string().starts_with(&missing.display().to_string()));
}

fn version(connection: &rusqlite::Connection) -> i64 {
    connection.query_row("PRAGMA user_version", [], |row| row.get(0)).unwrap()
}

#[test]
fn a_file_of_a_newer_program_is_left_alone() {
    let desk = Desk::new();
    drop(desk.recorder(Settings::default()));
    let connection = rusqlite::Connection::open(&desk.path).unwrap();
    let known = version(&connection);
    connection.pragma_update(None, "user_version", known + 1).unwrap();
    drop(connection);
    let complaint = Recorder::start(&desk.path, Settings::default()).map(drop).unwrap_err().to_string();
    let expected = format!("has tables of version {}, this program knows version {known}", known + 1);
    assert_eq!(complaint, format!("{} {expected}", desk.path.display()));
}

#[test]
fn a_file_of_the_first_program_gets_the_tables_it_lacks() {
    let desk = Desk::new();
    drop(desk.recorder(Settings::default()));
    let connection = rusqlite::Connection::open(&desk.path).unwrap();
    let known = version(&connection);
    let sql = "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite%' \
               AND name NOT IN ('gauge', 'sample', 'rollup', 'event')";
    let later: Vec<String> =
        connection.prepare(sql).unwrap().query_map([], |row| row.get(0)).unwrap().map(Result::unwrap).collect();
    assert!(later.contains(&"alarm_history".to_owned()), "{later:?}");
    later
        .iter()
        .for_each(|table| connection.execute_batch(&format!("DROP TABLE {table}; PRAGMA user_version = 1")).unwrap());
    drop(connection);
    drop(desk.recorder(Settings::default()));
    assert_eq!(Reader::open(&desk.path).unwrap().alarms().unwrap(), []);
    assert_eq!(version(&rusqlite::Connection::open(&desk.path).unwrap()), known);
}
