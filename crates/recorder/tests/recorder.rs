//! The recorder writes samples and events, and the reader returns them.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::common::{Fixture, keep_everything};
use profivac_recorder::{
    Event, EventKind, Export, Micros, Occurrence, Occurrences, Quality, Reader, Recorder, Sample, Settings,
};
use std::sync::Arc;
use std::time::Duration;

/// 2026-01-01.
const NEW_YEAR: i64 = 1_767_225_600 * Micros::SECOND;

fn at(second: i64) -> Micros {
    Micros(NEW_YEAR + second * Micros::SECOND)
}

fn valid(second: i64, pa: f64) -> Sample {
    Sample::new(at(second), Some(pa), Quality::Valid)
}

/// The database holds the audit trail. An existing database keeps the permissions that the operator gave it.
#[test]
fn a_new_database_and_its_log_are_readable_by_their_owner_alone() {
    use std::fs::{Permissions, metadata, set_permissions};
    use std::os::unix::fs::PermissionsExt;
    let fixture = Fixture::new();
    let modes = || {
        let mode = |ending: &str| metadata(format!("{}{ending}", fixture.path.display())).unwrap().permissions().mode();
        ["", "-wal", "-shm"].map(|ending| mode(ending) & 0o777)
    };
    let recorder = fixture.recorder(keep_everything());
    assert!(recorder.flush());
    assert_eq!(modes(), [0o600; 3]);
    drop(recorder);
    set_permissions(&fixture.path, Permissions::from_mode(0o640)).unwrap();
    let recorder = fixture.recorder(keep_everything());
    assert!(recorder.flush());
    assert_eq!(modes(), [0o640; 3]);
}

fn gauge() -> Arc<str> {
    Arc::from("chamber")
}

#[test]
fn a_sample_is_read_back_with_its_quality() {
    let fixture = Fixture::new();
    let samples = [
        valid(0, 1e-6),
        Sample::new(at(1), Some(1e-8), Quality::Underrange),
        Sample::new(at(2), None, Quality::Fault),
        Sample::gap(at(3)),
        Sample::new(at(4), Some(1e5), Quality::Overrange),
    ];
    let recorder = fixture.recorder(keep_everything());
    samples.iter().for_each(|sample| recorder.push(&gauge(), *sample));
    assert!(recorder.flush());
    assert_eq!(fixture.reader().samples("chamber", at(0), at(10)).unwrap(), samples);
    assert_eq!(fixture.reader().series_names().unwrap(), ["chamber"]);
    assert_eq!(fixture.reader().samples("unknown", at(0), at(10)).unwrap(), []);
}

#[test]
fn valid_samples_of_a_pressure_are_found_in_their_periods_and_in_the_spans_of_deleted_samples() {
    const WANTED: f64 = 32767.0;
    const DAY: i64 = 86_400;
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    let end = |second| Sample::new(at(second), Some(WANTED), Quality::Overrange);
    let samples = [
        // A span with it, one with a higher pressure, one with the end of a range.
        [valid(0, WANTED), valid(1, 1.0)],
        [valid(DAY, WANTED), valid(DAY + 1, 4e4)],
        [end(2 * DAY), valid(2 * DAY + 1, 1.0)],
        // These stay.
        [valid(9 * DAY, WANTED), valid(9 * DAY + 1, WANTED)],
        [end(9 * DAY + 2), valid(9 * DAY + 3, WANTED)],
        [valid(9 * DAY + 4, 1.0), valid(9 * DAY + 5, WANTED)],
    ];
    samples.iter().flatten().for_each(|sample| recorder.push(&gauge(), *sample));
    recorder.finish().unwrap();
    let deleted = rusqlite::Connection::open(&fixture.path).unwrap();
    deleted.execute("DELETE FROM sample WHERE at_us < ?1", [at(8 * DAY).0]).unwrap();
    let found = fixture.reader().occurrences("chamber", &[1.0e9, WANTED], 2).unwrap();
    let period = |first, last| Occurrence { pa: WANTED, first: at(first), last: at(last) };
    assert_eq!(found.periods, [period(9 * DAY, 9 * DAY + 1), period(9 * DAY + 3, 9 * DAY + 3)]);
    assert_eq!((found.samples, found.more, found.spans), (4, 1, Some((at(0), at(0)))));
    assert_eq!(fixture.reader().occurrences("unknown", &[WANTED], 2).unwrap(), Occurrences::default());
}

/// The samples at these seconds, all with the wanted pressure or with 1 Pa, of which those before `left` are deleted.
fn spans_of_deleted(samples: &[(i64, bool)], left: i64) -> (u64, Option<(Micros, Micros)>) {
    const WANTED: f64 = 32767.0;
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    for (second, is_wanted) in samples {
        recorder.push(&gauge(), valid(*second, if *is_wanted { WANTED } else { 1.0 }));
    }
    recorder.finish().unwrap();
    let deleted = rusqlite::Connection::open(&fixture.path).unwrap();
    deleted.execute("DELETE FROM sample WHERE at_us < ?1", [at(left).0]).unwrap();
    let found = fixture.reader().occurrences("chamber", &[WANTED], 2).unwrap();
    (found.samples, found.spans)
}

/// The retention deletes up to any moment: a part of the last six hours stays.
#[test]
fn a_pressure_is_found_also_in_the_six_hours_of_which_only_a_part_of_the_samples_is_deleted() {
    const SIX_HOURS: i64 = 6 * 3600;
    let span = Some((at(0), at(0)));
    assert_eq!(spans_of_deleted(&[(60, true), (3600, false)], 3600), (0, span));
    assert_eq!(
        spans_of_deleted(&[(60, true), (3600, false), (7200, true)], 3600),
        (1, span),
        "the shorter spans tell it"
    );
    let both = Some((at(0), at(SIX_HOURS)));
    let samples = [(60, true), (SIX_HOURS + 60, true), (SIX_HOURS + 3600, false), (2 * SIX_HOURS, true)];
    assert_eq!(spans_of_deleted(&samples, SIX_HOURS + 3600), (1, both));
    assert_eq!(spans_of_deleted(&[(60, true), (3600, false)], 61), (0, span), "all but the last one");
}

#[test]
fn samples_that_are_left_are_not_reported_as_deleted() {
    assert_eq!(spans_of_deleted(&[(3601, true), (3602, false)], 0), (1, None));
    assert_eq!(spans_of_deleted(&[(3601, false), (3602, true)], 0), (1, None));
    assert_eq!(spans_of_deleted(&[(60, false), (3601, false), (3602, true)], 3600), (1, None));
}

#[test]
fn a_steady_pressure_keeps_one_sample_a_minute_and_the_last_one() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(Settings { retention: keep_everything().retention, ..Settings::default() });
    (0..600).for_each(|second| recorder.push(&gauge(), valid(second, 1e-6)));
    drop(recorder);
    let kept = fixture.reader().samples("chamber", at(0), at(1000)).unwrap();
    let seconds: Vec<_> = kept.iter().map(|sample| (sample.at.0 - NEW_YEAR) / Micros::SECOND).collect();
    assert_eq!(seconds, [0, 60, 120, 180, 240, 300, 360, 420, 480, 540, 599]);
}

#[test]
fn every_sample_around_an_event_is_kept() {
    let fixture = Fixture::new();
    let settings = Settings {
        full_rate_window: Duration::from_secs(5),
        outbox: None,
        retention: keep_everything().retention,
        ..Settings::default()
    };
    let recorder = fixture.recorder(settings);
    (0..20).for_each(|second| recorder.push(&gauge(), valid(second, 1e-6)));
    let event = Event {
        at: at(19),
        gauge: Some("chamber".to_owned()),
        kind: EventKind::Gauge.into(),
        text: "degas".to_owned(),
    };
    assert!(recorder.record_event_and_wait(event.clone()));
    (20..40).for_each(|second| recorder.push(&gauge(), valid(second, 1e-6)));
    assert!(recorder.flush());
    let kept = fixture.reader().samples("chamber", at(0), at(100)).unwrap();
    let seconds: Vec<_> = kept.iter().map(|sample| (sample.at.0 - NEW_YEAR) / Micros::SECOND).collect();
    assert_eq!(seconds, [0, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24]);
    assert_eq!(fixture.reader().events(at(0), at(100), 10).unwrap(), [event]);
}

#[test]
fn a_trend_shows_the_extremes_at_every_zoom() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    // A day with a sample a second, one of them at 1 Pa.
    for second in 0..86_400 {
        recorder.push(&gauge(), valid(second, if second == 40_000 { 1.0 } else { 1e-6 }));
        assert!(second % 10_000 != 0 || recorder.flush());
    }
    assert!(recorder.flush());
    assert_eq!(recorder.health().lost_samples, 0);
    let reader = fixture.reader();
    for (from, to, pixels) in
        [(0, 86_400, 2000), (0, 86_400, 100), (0, 86_400, 4), (39_000, 41_000, 2000), (30_000, 50_000, 300)]
    {
        let spans = reader.trend("chamber", at(from), at(to), pixels).unwrap();
        assert!(spans.len() <= pixels as usize + 1, "{} spans in {pixels} pixels", spans.len());
        assert!(spans.windows(2).all(|pair| pair[0].start < pair[1].start));
        let highest = spans.iter().filter_map(|span| span.summary.high).fold(0.0, f64::max);
        let lowest = spans.iter().filter_map(|span| span.summary.low).fold(1e9, f64::min);
        assert_eq!((lowest, highest), (1e-6, 1.0), "{pixels} pixels");
        let mean = spans[0].summary.mean().unwrap();
        assert!((mean.log10() + 6.0).abs() < 0.01 || pixels == 4, "{mean}");
    }
}

#[test]
fn a_pixel_of_samples_has_its_last_pressure_and_a_stored_span_has_none() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    (0..20).for_each(|second| recorder.push(&gauge(), valid(second, if second < 17 { 1e-6 } else { 1e-3 })));
    assert!(recorder.flush());
    let last = |pixels| -> Vec<Option<f64>> {
        let spans = fixture.reader().trend("chamber", at(0), at(20), pixels).unwrap();
        spans.iter().map(|span| span.summary.last).collect()
    };
    assert_eq!(last(4), [Some(1e-6), Some(1e-6), Some(1e-6), Some(1e-3)]);
    assert_eq!(last(2), [None, None], "spans of 10 s");
}

#[test]
fn a_gap_is_a_span_without_a_pressure_or_no_span() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    (0..100).for_each(|second| recorder.push(&gauge(), valid(second, 1e-6)));
    recorder.push(&gauge(), Sample::gap(at(100)));
    (200..300).for_each(|second| recorder.push(&gauge(), valid(second, 1e-6)));
    assert!(recorder.flush());
    let spans = fixture.reader().trend("chamber", at(0), at(300), 30).unwrap();
    let missing: Vec<_> = spans.iter().filter(|span| span.summary.count == 0).collect();
    assert_eq!(spans.len(), 21);
    assert_eq!(missing.len(), 1);
    assert!(missing[0].summary.qualities.contains(Quality::Stale));
}

#[test]
fn a_restarted_recorder_continues_the_same_spans() {
    let fixture = Fixture::new();
    for first in [0, 5] {
        let recorder = fixture.recorder(keep_everything());
        (first..first + 5).for_each(|second| recorder.push(&gauge(), valid(second, 10_f64.powi(second as i32))));
    }
    let spans = fixture.reader().trend("chamber", at(0), at(100_000), 10).unwrap();
    assert_eq!(spans.len(), 1);
    let extent = spans[0].summary;
    assert_eq!((extent.low, extent.high, extent.count), (Some(1.0), Some(1e9), 10));
}

#[test]
fn an_export_is_csv() {
    let fixture = Fixture::new();
    let recorder = fixture.recorder(keep_everything());
    let odd: Arc<str> = Arc::from("pump, \"fore\"");
    recorder.push(&odd, valid(0, 1.5e-6));
    recorder.push(&odd, Sample::gap(at(1)));
    assert!(recorder.flush());
    let gauges = fixture.reader().series_names().unwrap();
    let csv = Export::new(fixture.reader(), gauges, at(0), at(10)).collect::<Result<String, _>>().unwrap();
    let expected = "\
time,gauge,pressure_pa,quality
2026-01-01T00:00:00.000000Z,\"pump, \"\"fore\"\"\",1.5e-6,valid
2026-01-01T00:00:01.000000Z,\"pump, \"\"fore\"\"\",,stale
";
    assert_eq!(csv, expected);
}

#[test]
fn an_error_names_the_file_that_is_no_database() {
    let fixture = Fixture::new();
    std::fs::write(
        &fixture.path,
        "no database at all, but long enough to have a header of a hundred octets or so, which SQLite reads first",
    )
    .unwrap();
    let error = Recorder::start(&fixture.path, Settings::default()).map(drop).unwrap_err().to_string();
    assert_eq!(error, format!("{}: file is not a database", fixture.path.display()));
    let missing = fixture.path.with_file_name("missing.db");
    assert!(Reader::open(&missing).map(drop).unwrap_err().to_string().starts_with(&missing.display().to_string()));
}

fn version(connection: &rusqlite::Connection) -> i64 {
    connection.query_row("PRAGMA user_version", [], |row| row.get(0)).unwrap()
}

#[test]
fn a_database_of_a_newer_program_is_refused() {
    let fixture = Fixture::new();
    drop(fixture.recorder(Settings::default()));
    let connection = rusqlite::Connection::open(&fixture.path).unwrap();
    let known = version(&connection);
    connection.pragma_update(None, "user_version", known + 1).unwrap();
    drop(connection);
    let error = Recorder::start(&fixture.path, Settings::default()).map(drop).unwrap_err().to_string();
    let expected = format!("has tables of version {}, this program knows version {known}", known + 1);
    assert_eq!(error, format!("{} {expected}", fixture.path.display()));
}
