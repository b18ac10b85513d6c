//! Reports from generated databases: the page and the numbers are those of the goldens.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::golden;
use jiff::tz::{TimeZone, offset};
use profivac_recorder::{Deadband, Event, EventKind, Micros, Quality, Reader, Recorder, Retention, Sample, Settings};
use profivac_station::pumpdown::TimeRange;
use profivac_station::report::series::{known, moved, pump_downs, series};
use profivac_station::report::{GaugeInfo, Report, ReportRequest, Unit, page::page};
use profivac_station::view::RiseCause;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;

/// 2026-11-21 12:00:00 UTC.
const NOON: Micros = Micros(1_795_262_400 * Micros::SECOND);

const STATION: &str = r#"
[station]
name = "Target hall"
[[segment]]
name = "hall"
port = "/dev/null"
[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"
gas = "ar"
levels = { "ready for beam" = "5e-5 mbar" }
[[segment.gauge]]
name = "ion"
address = 6
device = "img400"
"#;

fn at(s: f64) -> Micros {
    NOON.after(Duration::from_secs_f64(s))
}

/// A deadband of `decades`, and unlimited retention.
fn settings(decades: f64) -> Settings {
    let band = Deadband { decades, ..Deadband::default() };
    let retention = Retention { samples: None, ..Retention::default() };
    Settings { deadband: band, full_rate_window: Duration::ZERO, retention, outbox: None }
}

/// A database in a temporary folder.
struct Made {
    path: PathBuf,
    _folder: TempDir,
}

fn made(decades: f64, write: impl FnOnce(&Recorder)) -> Made {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hall.db");
    let recorder = Recorder::start(&path, settings(decades)).unwrap();
    write(&recorder);
    recorder.finish().unwrap();
    Made { path, _folder: folder }
}

/// A minute of air, 20 l/s on 100 l down to the outgassing, a valve that is closed for five minutes. The ion gauge is above
/// its range at first, and does not answer for a while.
fn plant(recorder: &Recorder) {
    let [chamber, ion]: [Arc<str>; 2] = ["chamber", "ion"].map(Arc::from);
    for second in (0..3_600).map(f64::from) {
        let t = (second - 60.0).max(0.0);
        let closed = (second - 2_400.0).clamp(0.0, 300.0) * if second < 2_700.0 { 1.0 } else { 0.0 };
        // With the valve closed the pressure does not fall below what it was.
        let pumped = if (2_400.0..2_700.0).contains(&second) { 2_340.0 } else { t };
        let pa = 101_325.0 * (-t / 5.0).exp() + 0.5 / (pumped + 10.0) * f64::from(u8::from(t > 0.0)) + closed * 2e-5;
        recorder.push(&chamber, Sample::new(at(second), Some(pa), Quality::Valid));
        let seen = match second {
            1_000.0..1_200.0 => Sample::gap(at(second)),
            _ if pa > 1.0 => Sample::new(at(second), Some(1.0), Quality::Overrange),
            _ => Sample::new(at(second), Some(pa * 0.9), Quality::Valid),
        };
        recorder.push(&ion, seen);
    }
    for (second, gauge, text) in [
        (60.0, None, "the valve to the pump was opened"),
        (1_000.0, Some("ion"), "ion: no answer"),
        (1_200.0, Some("ion"), "ion: it exchanges data"),
        (2_400.0, Some("elsewhere"), "elsewhere: of another chamber"),
    ] {
        let event = Event {
            at: at(second),
            gauge: gauge.map(str::to_owned),
            kind: EventKind::Note.into(),
            text: text.to_owned(),
        };
        assert!(recorder.record_event_and_wait(event));
    }
}

fn request(span: TimeRange, names: &[&str]) -> ReportRequest {
    let config = profivac_config::parse(STATION, Path::new("hall.toml")).unwrap();
    ReportRequest {
        title: "Acceptance of chamber 7".to_owned(),
        station: Some(config.name.clone()),
        record: "hall.db".to_owned(),
        span,
        why: "the last pump-down".to_owned(),
        gauges: names.iter().map(|name| ((*name).to_owned(), GaugeInfo::of(&config, name))).collect(),
        volume_m3: Some(0.1),
        pressures: vec![2e-2],
        unit: Unit::Mbar,
        zone: TimeZone::fixed(offset(1)),
        made: at(7_200.0),
    }
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// Compares with a file of `tests/golden`.
fn compare(name: &str, text: &str) {
    golden::compare(&format!("crates/station/tests/golden/{name}"), text);
}

/// Rounds to six digits: further digits depend on the mathematics library of the computer.
fn rounded(value: Value) -> Value {
    match value {
        Value::Number(number) if number.is_f64() => {
            format!("{:.5e}", number.as_f64().unwrap()).parse::<f64>().unwrap().into()
        }
        Value::Array(values) => values.into_iter().map(rounded).collect(),
        Value::Object(pairs) => pairs.into_iter().map(|(key, value)| (key, rounded(value))).collect(),
        other => other,
    }
}

#[test]
fn a_report_has_the_page_and_the_numbers_of_the_goldens() {
    // A wide deadband keeps the golden short enough to read.
    let made = made(0.05, plant);
    let reader = Reader::open(&made.path).unwrap();
    let found = pump_downs(&reader, &names(&["chamber", "ion"]), false).unwrap();
    let report = Report::make(&reader, request(found[0].span, &["chamber", "ion"])).unwrap();
    // 2e-5 Pa/s in 100 l.
    let leak = report.gauges[0].rises[0].leak_pa_m3_per_s.unwrap();
    assert!(leak.low <= 2e-6 && 2e-6 <= leak.high && leak.low >= 0.97 * 2e-6, "{leak:?}");
    assert!((leak.mean / 2e-6 - 1.0).abs() < 0.03, "{leak:?}");
    assert_eq!(report.gauges[0].rises[0].cause, Some(RiseCause::Leak));
    let pumped = report.gauges[0].rises[0].pumped_s.unwrap();
    assert!((pumped - 2_340.0).abs() < 5.0, "{pumped}");
    let version = env!("CARGO_PKG_VERSION");
    let page = page(&report).replace(version, "VERSION");
    let (head, rest) = page.split_once("<style>").unwrap();
    let (_, rest) = rest.split_once("</style>").unwrap();
    compare("report/page.html", &format!("{head}<style>...</style>{rest}"));
    let numbers = rounded(serde_json::to_value(&report).unwrap());
    compare(
        "report/numbers.json",
        &(serde_json::to_string_pretty(&numbers).unwrap().replace(version, "VERSION") + "\n"),
    );
}

#[test]
fn the_pump_down_is_found_to_the_second_and_the_last_of_several_counts() {
    let made = made(0.002, |recorder| {
        let chamber: Arc<str> = Arc::from("chamber");
        for second in (0..2_000).map(f64::from) {
            let t = (second % 1_000.0 - 100.0).max(0.0);
            let pa = (101_325.0 * (-t / 10.0).exp()).max(1e-3);
            recorder.push(&chamber, Sample::new(at(second), Some(pa), Quality::Valid));
        }
    });
    let reader = Reader::open(&made.path).unwrap();
    let all = pump_downs(&reader, &names(&["chamber"]), true).unwrap();
    let begun: Vec<i64> = all.iter().map(|one| (one.span.start.0 - NOON.0) / Micros::SECOND).collect();
    assert_eq!(begun, [100, 1_100]);
    assert_eq!(all.iter().map(|one| one.is_vented).collect::<Vec<_>>(), [true, false]);
    let last = pump_downs(&reader, &names(&["chamber"]), false).unwrap();
    assert_eq!(last.last().map(|one| one.span), Some(all[1].span));
}

#[test]
fn a_pump_down_that_began_days_ago_is_found_in_the_spans() {
    let days = 5.0 * 86_400.0;
    let made = made(0.002, |recorder| {
        let chamber: Arc<str> = Arc::from("chamber");
        let early = (0..600).map(f64::from);
        let late = (1..).map(|minute| 600.0 + 60.0 * f64::from(minute)).take_while(|second| *second < days);
        for second in early.chain(late) {
            let t = (second - 300.0).max(0.0);
            let pa = 101_325.0 * (-t / 10.0).exp() + 1.0 / (t + 60.0);
            recorder.push(&chamber, Sample::new(at(second), Some(pa), Quality::Valid));
        }
    });
    let reader = Reader::open(&made.path).unwrap();
    let found = pump_downs(&reader, &names(&["chamber"]), false).unwrap();
    let begun = found.last().map(|one| (one.span.start.0 - NOON.0) / Micros::SECOND);
    assert_eq!(begun, Some(300));
    let report = Report::make(&reader, request(found[0].span, &["chamber"])).unwrap();
    let slope = report.gauges[0].slope.unwrap();
    assert!((slope.exponent - 1.0).abs() < 0.02, "{slope:?}");
}

#[test]
fn names_from_a_database_are_never_markup() {
    let hostile = "<script>alert(1)</script>\" onload='x";
    let made = made(0.002, |recorder| {
        let gauge: Arc<str> = Arc::from(hostile);
        for second in (0..200).map(f64::from) {
            let pa = 101_325.0 * (-second / 10.0).exp();
            recorder.push(&gauge, Sample::new(at(second), Some(pa), Quality::Valid));
        }
        let text = "</td><img src=x onerror=alert(1)>".to_owned();
        let event = Event { at: at(5.0), gauge: Some(hostile.to_owned()), kind: EventKind::Note.into(), text };
        assert!(recorder.record_event_and_wait(event));
    });
    let reader = Reader::open(&made.path).unwrap();
    let span = TimeRange { start: at(0.0), end: at(199.0) };
    let request = ReportRequest {
        title: hostile.to_owned(),
        station: Some(hostile.to_owned()),
        record: hostile.to_owned(),
        why: hostile.to_owned(),
        ..request(span, &[hostile])
    };
    let page = page(&Report::make(&reader, request).unwrap());
    for forbidden in ["<script", "<img", "</td><img", "\" onload", "onload='", "http://", "https://"] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;&quot; onload=&#39;x"));
}

#[test]
fn a_report_without_valid_pressures_is_complete() {
    let made = made(0.002, |recorder| {
        let gauge: Arc<str> = Arc::from("chamber");
        (0..100).map(f64::from).for_each(|s| recorder.push(&gauge, Sample::new(at(s), None, Quality::Fault)));
    });
    let reader = Reader::open(&made.path).unwrap();
    let moved = |start, end| moved(&reader, "chamber", TimeRange { start: at(start), end: at(end) }).unwrap();
    assert_eq!((moved(0.0, 99.0), moved(200.0, 300.0)), (Some(0.0), None));
    let report = Report::make(&reader, request(TimeRange { start: NOON, end: at(99.0) }, &["chamber"])).unwrap();
    let page = page(&report);
    assert!(page.contains("not reached<small>no valid pressure</small>"));
    assert!(!page.contains("NaN") && !page.contains("inf"), "{page}");
}

#[test]
fn a_pump_down_older_than_the_samples_is_read_from_spans() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.db");
    let long_ago = |s: f64| at(s).before(Duration::from_secs(6 * 365 * 86_400));
    let recorder = Recorder::start(&path, settings(0.0)).unwrap();
    let gauge: Arc<str> = Arc::from("chamber");
    for second in (0..3_000).map(f64::from) {
        let pa = (101_325.0 * (-(second - 600.0).max(0.0) / 100.0).exp()).max(1e-4);
        recorder.push(&gauge, Sample::new(long_ago(second), Some(pa), Quality::Valid));
    }
    drop(recorder);
    // A recorder deletes old samples when it writes for the first time.
    let kept = settings(0.0);
    let shorter = Settings { retention: Retention { samples: Some(Duration::ZERO), ..kept.retention }, ..kept };
    assert!(Recorder::start(&path, shorter).unwrap().flush());
    let reader = Reader::open(&path).unwrap();
    assert_eq!(reader.first_sample("chamber").unwrap(), None);
    let [found] = pump_downs(&reader, &names(&["chamber"]), false).unwrap()[..] else { panic!("one") };
    let begun = (found.span.start.0 - long_ago(0.0).0) / Micros::SECOND;
    assert!((580..=610).contains(&begun), "{begun}");
    let report = Report::make(&reader, request(found.span, &["chamber"])).unwrap();
    let gauge = &report.gauges[0];
    assert_eq!(gauge.coverage.coarsest_s, Some(10.0));
    let index = report.targets.iter().position(|target| target.pa == 1.0).unwrap();
    let s = gauge.times[index].s.unwrap();
    assert!((s / (100.0 * 101_325_f64.ln()) - 1.0).abs() < 0.02, "{s}");
    assert!(page(&report).contains("in part means of 10.0\u{a0}s"));
}

#[test]
fn a_long_time_range_is_read_in_spans_and_the_report_says_so() {
    let second = 400_000 / 5;
    let made = made(0.0, |recorder| {
        let gauge: Arc<str> = Arc::from("chamber");
        for number in 0..(second * 5) {
            let s = f64::from(number) / 5.0;
            // Two alternating values: the deadband leaves out no sample.
            let pa = if number % 2 == 0 { 1.0 } else { 1.1 };
            recorder.push(&gauge, Sample::new(at(s), Some(pa), Quality::Valid));
            if number % 20_000 == 0 {
                assert!(recorder.flush());
            }
        }
    });
    let reader = Reader::open(&made.path).unwrap();
    let span = TimeRange { start: NOON, end: at(f64::from(second)) };
    let read = series(&reader, "chamber", span).unwrap();
    let coarsest = read.coarsest_s.unwrap();
    assert!((1.0..=20.0).contains(&coarsest), "{coarsest}");
    assert!((20_000..300_000).contains(&read.samples.len()), "{}", read.samples.len());
    // The beginning is read sample by sample.
    assert_eq!(read.samples.partition_point(|sample| sample.at < at(3_000.0)), 15_000);
    assert_eq!(known(&reader, &names(&["chamber", "unknown"])).unwrap().map(|known| known.start), Some(NOON));
}

#[test]
fn a_time_range_up_to_the_largest_time_is_read() {
    let made = made(0.0, |recorder| recorder.push(&Arc::from("chamber"), Sample::new(NOON, Some(1.0), Quality::Valid)));
    let reader = Reader::open(&made.path).unwrap();
    let all = TimeRange { start: Micros(i64::MIN), end: Micros(i64::MAX) };
    assert_eq!(series(&reader, "chamber", all).unwrap().samples.len(), 1);
}
