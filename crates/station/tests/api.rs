//! Answers and refusals of the API.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use axum::body::{Body, to_bytes};
use axum::http::{Request, Response};
use profivac_devices::Principle;
use profivac_recorder::{
    CodeText, Deadband, DescribedPoint, EventKind, Micros, Point, PointKind, PointSample, Quality, Recorder, Retention,
    Sample, Settings,
};
use profivac_station::api::{description, router};
use profivac_station::control::error::Unavailable;
use profivac_station::control::requests::SegmentRequest;
use profivac_station::directory::{Directory, GaugeLabels};
use profivac_station::services::Services;
use profivac_station::snapshot::SegmentSnapshot;
use profivac_station::view::{Block, BusStationState, Gauge, GaugeKind, Reading, Segment, SegmentState};
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;
use tokio_stream::StreamExt;
use tower::ServiceExt;

const NEW_YEAR_MS: i64 = 1_767_225_600_000;

struct TestStation {
    folder: TempDir,
    services: Arc<Services>,
}

impl TestStation {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plant.db");
        let settings = Settings {
            deadband: Deadband { decades: 0.0, max_interval: Duration::ZERO },
            retention: Retention { samples: None, ..Retention::default() },
            ..Settings::default()
        };
        let recorder = Recorder::start(&file, settings).unwrap();
        let services = Arc::new(Services::new("Target hall".to_owned(), file, recorder));
        services.snapshots().publish(snapshot());
        Self { folder, services }
    }

    /// Status, content type and body of an answer.
    fn get(&self, path: &str) -> (u16, String, String) {
        let (response, text) = self.ask(path);
        let kind = response.headers().get("content-type").map_or("", |kind| kind.to_str().unwrap()).to_owned();
        (response.status().as_u16(), kind, text)
    }

    fn ask(&self, path: &str) -> (Response<()>, String) {
        self.send("GET", path)
    }

    fn send(&self, method: &str, path: &str) -> (Response<()>, String) {
        let (head, octets) = self.octets(method, path);
        (head, String::from_utf8(octets).unwrap())
    }

    fn octets(&self, method: &str, path: &str) -> (Response<()>, Vec<u8>) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        runtime.block_on(async {
            let request = Request::builder().method(method).uri(path).body(Body::empty()).unwrap();
            let response = router(Arc::clone(&self.services)).oneshot(request).await.unwrap();
            let (head, body) = response.into_parts();
            (Response::from_parts(head, ()), to_bytes(body, usize::MAX).await.unwrap().to_vec())
        })
    }

    fn json(&self, path: &str) -> Value {
        let (status, kind, text) = self.get(path);
        assert_eq!((status, kind.as_str()), (200, "application/json"), "{path}: {text}");
        serde_json::from_str(&text).unwrap()
    }

    /// Status and detail of a problem document.
    fn problem(&self, path: &str) -> (u16, String) {
        let (status, kind, text) = self.get(path);
        assert_eq!(kind, "application/problem+json", "{path}: {text}");
        let json: Value = serde_json::from_str(&text).unwrap();
        assert_eq!((&json["status"], json["title"].is_string()), (&status.into(), true), "{path}: {text}");
        (status, json["detail"].as_str().unwrap().to_owned())
    }

    fn record(&self, second: i64, pa: f64) {
        let at = Micros((NEW_YEAR_MS + second * 1000) * 1000);
        self.services.recorder().push(&Arc::from("chamber"), Sample::new(at, Some(pa), Quality::Valid));
    }
}

fn snapshot() -> SegmentSnapshot {
    let reading = Reading {
        series: "chamber".to_owned(),
        instance: 2,
        principle: Some(Principle::HotCathode),
        pa: Some(1e-4),
        corrected_pa: Some(8e-5),
        quality: Quality::Valid,
        limit_pa: None,
        cause: None,
        is_defect: false,
    };
    let gauge = Gauge {
        name: "chamber".to_owned(),
        kind: GaugeKind::Gauge,
        segment: "hall".to_owned(),
        address: 5,
        device: "bcg450".to_owned(),
        has_dpv1: true,
        state: BusStationState::DataExchange,
        gas: "ar".to_owned(),
        readings: vec![reading],
        poll_ms: 200,
        stale_after_ms: 3000,
        ..Gauge::default()
    };
    let segment = Segment {
        name: "hall".to_owned(),
        port: "/dev/ttyUSB0".to_owned(),
        baud: 19200,
        master: Some(0),
        listen_only: false,
        state: SegmentState::Running,
        problem: None,
        cycle_ms: Some(20.0),
        damaged_telegrams: 0,
        stations: Vec::new(),
    };
    SegmentSnapshot { segment, gauges: vec![gauge] }
}

#[test]
fn the_api_serves_the_published_snapshot() {
    let station = TestStation::new();
    assert_eq!(station.json("/api/station")["name"], "Target hall");
    assert_eq!(station.json("/api/segments")[0]["state"], "running");
    let gauge = station.json("/api/gauges/chamber");
    assert_eq!(gauge, station.json("/api/gauges")[0]);
    assert_eq!((&gauge["state"], &gauge["readings"][0]["pa"]), (&"data-exchange".into(), &1e-4.into()));
}

#[test]
fn a_wrong_name_is_answered_with_the_names_that_exist() {
    let station = TestStation::new();
    let times = "from=0&to=1";
    let of_series = |path: &str| format!("/api/{path}?series=chambre&{times}");
    let volume = |path: &str| format!("{}&volume_m3=0.1", of_series(path));
    for (kind, name, paths) in [
        (
            "gauge",
            "chambre",
            [
                "gauges/chambre",
                "gauges/chambre/blocks",
                "gauges/chambre/commands",
                "audit?gauge=chambre",
                "audit.csv?gauge=chambre",
            ]
            .map(|path| format!("/api/{path}"))
            .to_vec(),
        ),
        (
            "segment",
            "hal",
            ["bus", "captures", "captures/1-0.pcapng"].map(|path| format!("/api/segments/hal/{path}")).to_vec(),
        ),
        (
            "series",
            "chambre",
            ["trend", "rise", "pump-downs", "export.csv", "export.parquet", "report.html"]
                .map(of_series)
                .into_iter()
                .chain([volume("identify")])
                .collect(),
        ),
    ] {
        let meant = if kind == "segment" { "hall" } else { "chamber" };
        let plural = if kind == "series" { kind.to_owned() } else { format!("{kind}s") };
        let detail = format!("there is no {kind} {name:?}; the {plural} are {meant}; did you mean {meant:?}?");
        for path in paths {
            assert_eq!(station.problem(&path), (404, detail.clone()), "{path}");
        }
    }
    for series in ["chamber", "chamber.2"] {
        assert_eq!(station.json(&format!("/api/trend?series={series}&{times}"))["series"], series);
    }
}

#[test]
fn of_many_gauges_a_problem_names_twenty_and_counts_the_others() {
    let station = TestStation::new();
    let SegmentSnapshot { segment, gauges } = snapshot();
    let named = |number: usize| Gauge { name: format!("g{number:03}"), ..gauges[0].clone() };
    station.services.snapshots().publish(SegmentSnapshot { segment, gauges: (0..480).map(named).collect() });
    let (status, detail) = station.problem("/api/gauges/gl00");
    assert_eq!(status, 404);
    let (begin, end) =
        ("there is no gauge \"gl00\"; the gauges are g000, g001, ", ", g019 and 460 more; did you mean \"g");
    assert!(detail.starts_with(begin) && detail.contains(end), "{detail}");
}

#[test]
fn a_gauge_has_its_labels_and_the_directory_lists_them() {
    let station = TestStation::new();
    let empty = json!({"group": null, "tags": [], "location": null, "calibrated": null, "calibration_due": null});
    assert_eq!(station.json("/api/gauges/chamber")["labels"], empty);
    assert_eq!(station.json("/api/directory"), json!({"gauges": {}, "views": []}));
    let labels = GaugeLabels {
        group: Some("target".to_owned()),
        tags: vec!["bake-out".to_owned()],
        location: Some("rack 4".to_owned()),
        calibrated: Some("2026-05-01".to_owned()),
        calibration_due: None,
    };
    let directory = Directory { gauges: [("chamber".to_owned(), labels)].into(), ..Directory::default() };
    station.services.directory().set(directory);
    let expected = json!({
        "group": "target", "tags": ["bake-out"], "location": "rack 4", "calibrated": "2026-05-01", "calibration_due": null
    });
    assert_eq!(station.json("/api/gauges/chamber")["labels"], expected);
    let all = station.json("/api/gauges");
    assert_eq!((&all[0]["name"], &all[0]["labels"]), (&"chamber".into(), &expected));
    assert_eq!(station.json("/api/directory")["gauges"], json!({"chamber": expected}));
}

#[test]
fn a_removed_segment_is_not_served() {
    let station = TestStation::new();
    station.services.snapshots().remove("hall");
    assert_eq!(station.json("/api/segments"), Value::Array(Vec::new()));
    assert_eq!(station.json("/api/gauges"), Value::Array(Vec::new()));
}

#[test]
fn blocks_are_requested_from_the_segment() {
    let station = TestStation::new();
    assert_eq!(station.problem("/api/gauges/unknown/blocks").0, 404);
    let requests = station.services.control().requests().accept("hall");
    let answering = std::thread::spawn(move || {
        let SegmentRequest::Blocks(gauge, answer) = requests.recv().unwrap() else { panic!("blocks") };
        answer.send(Ok(vec![Block { name: gauge, parameters: Vec::new() }])).unwrap();
        let SegmentRequest::Blocks(_, answer) = requests.recv().unwrap() else { panic!("blocks") };
        answer.send(Err(Unavailable::SegmentDown("the gauge does not answer".to_owned()))).unwrap();
    });
    assert_eq!(station.json("/api/gauges/chamber/blocks")[0]["name"], "chamber");
    assert_eq!(station.problem("/api/gauges/chamber/blocks"), (409, "the gauge does not answer".to_owned()));
    answering.join().unwrap();
    assert_eq!(station.problem("/api/gauges/chamber/blocks").0, 503);
}

#[test]
fn a_trend_has_an_entry_for_every_pixel_with_samples() {
    let station = TestStation::new();
    (0..100).for_each(|second| station.record(second, if second < 50 { 1e-3 } else { 1e-5 }));
    assert!(station.services.recorder().flush());
    let to = NEW_YEAR_MS + 100_000;
    let trend = station.json(&format!("/api/trend?series=chamber&from={NEW_YEAR_MS}&to={to}&pixels=10"));
    assert_eq!(trend["start_ms"].as_array().unwrap().len(), 10);
    assert_eq!((&trend["high"][4], &trend["low"][5]), (&1e-3.into(), &1e-5.into()));
    assert_eq!(trend["qualities"][0], 1);
}

#[test]
fn a_wrong_parameter_is_refused_with_a_sentence() {
    let station = TestStation::new();
    for (path, sentence) in [
        ("/api/trend?series=a&from=2&to=1", "expected from to lie before to, found 2 and 1"),
        ("/api/trend?series=a&from=1&to=2&pixels=0", "expected pixels from 1 to 20000, found 0"),
        ("/api/events?from=1&to=2&limit=99999", "expected limit from 1 to 10000, found 99999"),
        ("/api/rise?series=a&from=1&to=2&volume_m3=-1", "expected volume_m3 above 0, found -1"),
        ("/api/rise?series=a&from=1&to=2&accuracy=15", "expected an accuracy from 0 to 1 (0.15 is 15 %), found 15"),
        ("/api/rise?series=chamber&from=1&to=2", "expected at least 12 samples of a rise, got 0"),
        ("/api/export.csv?from=2&to=1", "expected from to lie before to, found 2 and 1"),
        ("/api/export.csv?from=noon&to=1", "expected from in milliseconds since 1970, found \"noon\""),
        ("/api/export.csv?from=1", "expected to in milliseconds since 1970, found nothing"),
    ] {
        assert_eq!(station.problem(path), (400, sentence.to_owned()), "{path}");
    }
    for path in ["/api/trend", "/api/trend?series=a&from=x&to=2", "/api/events?from=1", "/api/export.csv"] {
        assert_eq!(station.problem(path).0, 400, "{path}");
    }
    assert_eq!(station.problem("/api/no/such/thing").0, 404);
}

#[test]
fn extreme_times_are_accepted() {
    let station = TestStation::new();
    station.record(0, 1.0);
    assert!(station.services.recorder().flush());
    let (from, to) = (i64::MIN, i64::MAX);
    assert_eq!(
        station.json(&format!("/api/trend?series=chamber&from={from}&to={to}"))["start_ms"].as_array().unwrap().len(),
        1
    );
    assert_eq!(station.json(&format!("/api/events?from={from}&to={to}")), Value::Array(Vec::new()));
}

#[test]
fn a_straight_rise_has_its_leak_with_an_interval_and_sccm_at_the_temperature_of_the_gas() {
    let station = TestStation::new();
    (0..300).for_each(|second| station.record(second, 1e-4 + 1e-6 * second as f64));
    assert!(station.services.recorder().flush());
    let to = NEW_YEAR_MS + 300_000;
    let rise = station.json(&format!("/api/rise?series=chamber&from={NEW_YEAR_MS}&to={to}&volume_m3=0.1"));
    let leak = &rise["flows"]["leak"];
    let number = |unit: &str, key: &str| leak[unit][key].as_f64().unwrap();
    assert!(number("pa_m3_per_s", "low") <= 1e-7 && number("pa_m3_per_s", "high") >= 1e-7, "{leak}");
    assert!(number("pa_m3_per_s", "low") >= 0.97e-7, "{leak}");
    assert!((number("pa_m3_per_s", "mean") / 1e-7 - 1.0).abs() < 0.01, "{leak}");
    assert_eq!(rise["cause"], "leak");
    // 1 sccm is 0.01689 mbar l/s at 0 °C, and 0.01813 mbar l/s at 20 °C.
    assert!((number("mbar_l_per_s", "high") / number("sccm", "high") / 0.01813 - 1.0).abs() < 1e-3, "{leak}");
    assert!(rise["pumped_s"].is_null(), "{rise}");
}

#[test]
fn a_rise_is_not_fitted_to_the_end_of_a_range() {
    let station = TestStation::new();
    (0..100).for_each(|second| {
        let at = Micros((NEW_YEAR_MS + second * 1000) * 1000);
        // The lower end of the range is above the pressure.
        let below = Sample::new(at, Some(2e-4), Quality::Underrange);
        station.services.recorder().push(&Arc::from("chamber"), below);
    });
    (100..300).for_each(|second| station.record(second, 1e-4 + 1e-6 * second as f64));
    assert!(station.services.recorder().flush());
    let to = NEW_YEAR_MS + 300_000;
    let rise = station.json(&format!("/api/rise?series=chamber&from={NEW_YEAR_MS}&to={to}"));
    let leak = rise["leak_pa_per_s"]["mean"].as_f64().unwrap();
    assert!((leak / 1e-6 - 1.0).abs() < 0.01, "{leak}");
    assert_eq!(rise["samples"], 200);
    let trend = station.json(&format!("/api/trend?series=chamber&from={NEW_YEAR_MS}&to={to}&pixels=3"));
    assert_eq!((&trend["mean"][0], &trend["low"][0]), (&Value::Null, &json!(2e-4)), "{trend}");
}

/// Outgassing that falls with the time after ten hours of pumping is nearly a straight line in half an hour.
#[test]
fn outgassing_after_hours_of_pumping_is_not_called_a_leak() {
    let station = TestStation::new();
    let start_s = 36_000.0_f64;
    (0..1800).for_each(|second| station.record(second, 1e-5 + 1e-7 * start_s * (second as f64 / start_s).ln_1p()));
    assert!(station.services.recorder().flush());
    let to = NEW_YEAR_MS + 1_800_000;
    let rise = station.json(&format!("/api/rise?series=chamber&from={NEW_YEAR_MS}&to={to}"));
    assert_eq!(rise["cause"], "outgassing");
    assert!(rise["flows"].is_null());
}

#[test]
fn a_pump_down_of_half_a_minute_is_found_in_a_search_of_thirty_days() {
    let station = TestStation::new();
    (0..60).for_each(|second| station.record(second, 1e5 * (-(second as f64 - 10.0).max(0.0) / 2.0).exp() + 1e-3));
    assert!(station.services.recorder().flush());
    let (from, to) = (NEW_YEAR_MS - 29 * 86_400_000, NEW_YEAR_MS + 86_400_000);
    let answer = station.json(&format!("/api/pump-downs?series=chamber&from={from}&to={to}"));
    assert_eq!(answer["runs"].as_array().unwrap().len(), 1, "{answer}");
    let before = station.json(&format!("/api/pump-downs?series=chamber&from={from}&to={}", NEW_YEAR_MS - 1));
    assert_eq!(before["runs"].as_array().unwrap().len(), 0, "{before}");
}

/// Eleven pump-downs, one a day; the last has twice the outgassing.
#[test]
fn pump_downs_are_compared_with_the_last_ten_or_with_a_chosen_one() {
    let station = TestStation::new();
    const DAY_S: i64 = 86_400;
    for day in 0..11 {
        let outgassing = if day == 10 { 2.0 } else { 1.0 };
        (-30..0).for_each(|second| station.record(day * DAY_S + second, 1e5));
        let mut second = 0;
        while second < 14_400 {
            let s = second as f64;
            station.record(day * DAY_S + second, 1e5 * (-s / 20.0).exp() + outgassing * 0.36 / (s + 1.0) + 1e-6);
            second += 1.max(second / 100);
        }
        assert!(station.services.recorder().flush());
    }
    let (from, to) = (NEW_YEAR_MS - 60_000, NEW_YEAR_MS + 11 * DAY_S * 1000);
    let answer = station.json(&format!("/api/pump-downs?series=chamber&from={from}&to={to}&limit=5"));
    let runs = answer["runs"].as_array().unwrap();
    assert_eq!((runs.len(), &answer["found"]), (5, &11.into()));
    let last = &runs[0];
    let text = last["deviation"]["text"].as_str().unwrap();
    assert!(text.contains(" later to 1e-6 mbar than usual: ") && text.contains("the median of the last 10"), "{text}");
    assert_eq!(last["deviation"]["pattern"], "at-low-pressure");
    assert_eq!(last["deviation"]["excess"], "outgassing");
    assert!(runs[1..].iter().all(|run| run["deviation"].is_null()), "{answer}");
    let level = last["levels"].as_array().unwrap().iter().find(|level| level["pa"].as_f64().unwrap() < 1.1e-3).unwrap();
    let (s, usual) = (level["s"].as_f64().unwrap(), level["usual"]["s"].as_f64().unwrap());
    // The roughing still counts at the usual time: 1e5 exp(-410/20) and 0.36/411 are 1e-3 Pa.
    assert!((usual / 410.0 - 1.0).abs() < 0.02 && (s / 720.0 - 1.0).abs() < 0.02, "{level}");
    assert!((110..=120).contains(&last["curve"].as_array().unwrap().len()), "{last}");
    let reference = last["start_ms"].as_i64().unwrap();
    let path = format!("/api/pump-downs?series=chamber&from={from}&to={to}&reference={reference}");
    let answer = station.json(&path);
    let directions: Vec<_> =
        answer["runs"].as_array().unwrap().iter().map(|run| run["deviation"]["text"].as_str().unwrap_or("")).collect();
    assert_eq!(directions[0], "");
    assert!(
        directions[1..].iter().all(|text| text.contains("earlier") && text.contains("the chosen one")),
        "{directions:?}"
    );
    let (status, _, text) = station.get(&path.replace(&reference.to_string(), "5"));
    assert!(status == 400 && text.contains("expected reference as the beginning of one of 11 pump-downs"), "{text}");
    let (status, _, text) = station.get("/api/pump-downs?series=chamber&from=1&to=2&limit=51");
    assert!(status == 400 && text.contains("expected limit from 1 to 50, found 51"), "{text}");
    assert_eq!(station.json("/api/pump-downs?series=chamber.2&from=1&to=2")["runs"], Value::Array(Vec::new()));
}

/// Two hours of pumping of 50 l with 20 l/s, and twenty minutes with a closed valve: a leak of 2e-7 and an outgassing of 2e-6 Pa m³/s.
fn record_plant(station: &TestStation) {
    let mut random = fastrand::Rng::with_seed(4);
    let mut pa = 100.0;
    for second in 0..8_400 {
        let noise: f64 = (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        station.record(second, pa * (1.0 + 0.01 * noise));
        for part in 0..100 {
            let now = second as f64 + f64::from(part) / 100.0;
            let pumped = if now < 7_200.0 { 0.02 * pa } else { 0.0 };
            pa += (2e-7 + 2e-6 * 3600.0 / (now + 5.0) - pumped) / 0.05 / 100.0;
        }
    }
    assert!(station.services.recorder().flush());
}

#[test]
fn a_plant_is_identified_from_the_record_of_a_gauge() {
    let station = TestStation::new();
    record_plant(&station);
    let path = format!("/api/identify?series=chamber&from={NEW_YEAR_MS}&to={}", NEW_YEAR_MS + 8_400_000);
    let plant = station.json(&format!("{path}&volume_m3=0.05&target_pa=5e-6"));
    let holds = |found: &Value, truth: f64| {
        let [low, high] = ["low", "high"].map(|key| found[key].as_f64().unwrap());
        assert!(low <= truth && truth <= high, "{truth} is not within {found}");
    };
    holds(&plant["leak"]["flow"]["pa_m3_per_s"], 2e-7);
    holds(&plant["outgassing_1h"]["flow"]["pa_m3_per_s"], 2e-6);
    holds(&plant["exponent"]["value"], 1.0);
    let speeds = plant["speeds"].as_array().unwrap();
    holds(&speeds[speeds.len() / 2]["m3_per_s"]["value"], 0.02);
    let closed = plant["rise"]["closed_s"].as_f64().unwrap();
    assert!((closed - 7_200.0).abs() < 3.0, "{closed}");
    assert_eq!((&plant["is_described"], &plant["is_volume_given"]), (&true.into(), &true.into()));
    // The pump of this plant has no ultimate pressure, and the record cannot know that.
    assert_eq!(plant["ultimate_pa"]["certainty"], "upper-bound");
    assert!(plant["ultimate_pa"]["note"].as_str().unwrap().contains("cannot be told from zero"), "{plant}");
    assert_eq!(plant["prediction"].as_array().unwrap().len(), 61);
    assert!(plant["residuals"].as_array().unwrap().len() > 100);
    assert!(plant["target_s"].is_null() && plant["remedies"][0]["divided_by"]["mean"].as_f64().unwrap() > 1.0);
    // A gauge that ionises indicates water too high: there is less of it. The accuracy widens.
    let other = station.json(&format!("{path}&volume_m3=0.05&gauge=ionisation&accuracy=0.15"));
    let mean = |plant: &Value| plant["outgassing_1h"]["flow"]["pa_m3_per_s"]["mean"].as_f64().unwrap();
    assert!((mean(&other) / mean(&plant) / profivac_vacuum::Gas::H2o.ion_factor() - 1.0).abs() < 1e-6);
    assert_eq!(other["accuracy"], 0.15);
    let dosed = station.problem(&format!("{path}&dose_pa_m3=1&dose_at={}", NEW_YEAR_MS + 5_000_000));
    assert_eq!(dosed, (400, "expected the dose while the valve is closed".to_owned()));
}

/// The pump-down of `record_plant` is the first one, so there are no usual ones.
#[test]
fn a_report_has_the_plant_and_says_that_there_are_no_usual_pump_downs() {
    let station = TestStation::new();
    record_plant(&station);
    let path = format!("/api/report.html?series=chamber&from={NEW_YEAR_MS}&to={}", NEW_YEAR_MS + 8_400_000);
    let (status, _, page) = station.get(&format!("{path}&volume_m3=0.05&accuracy=0.1&zone=Europe/Berlin"));
    assert_eq!(status, 200, "{page}");
    for part in [
        "<h2>Plant</h2>",
        "Outgassing after 1 h",
        "cannot be told from zero",
        "with an accuracy of the gauge of ±10 %",
        "What would help most",
        "<h2>Rises</h2>",
        "too few pump-downs before it to compare with",
    ] {
        assert!(page.contains(part), "{part} is missing in {page}");
    }
    let (status, _, page) = station.get(&path);
    assert!(status == 200 && !page.contains("<h2>Plant</h2>"), "{page}");
    for (query, sentence) in [
        ("&unit=bar", "expected a unit, one of mbar, Pa, hPa, Torr, micron, got \"bar\""),
        ("&zone=Atlantis", "expected a time zone such as Europe/Berlin, found \"Atlantis\""),
        ("&volume_m3=-1", "expected volume_m3 above 0, found -1"),
        ("&accuracy=2", "expected an accuracy from 0 to 1 (0.15 is 15 %), found 2"),
    ] {
        assert_eq!(station.problem(&format!("{path}{query}")), (400, sentence.to_owned()));
    }
    let none = path.replace("series=chamber", "series=chamber.2");
    assert_eq!(station.problem(&none), (400, "expected samples of \"chamber.2\" in this time, found none".to_owned()));
    let long = path.replace(&format!("from={NEW_YEAR_MS}"), "from=0");
    assert_eq!(station.problem(&long), (400, "expected a time range of at most a year".to_owned()));
}

#[test]
fn a_plant_without_a_volume_or_a_record_is_refused_with_a_sentence() {
    let station = TestStation::new();
    for (query, sentence) in [
        ("", "expected either volume_m3, or dose_pa_m3 with dose_at: the record alone has no volume"),
        (
            "&volume_m3=1&dose_pa_m3=1&dose_at=1",
            "expected either volume_m3, or dose_pa_m3 with dose_at: the record alone has no volume",
        ),
        ("&volume_m3=0", "expected volume_m3 above 0, found 0"),
        ("&volume_m3=1&accuracy=15", "expected an accuracy from 0 to 1 (0.15 is 15 %), found 15"),
        ("&volume_m3=1&closed=3&opened=2", "expected closed to lie before opened, found 3 and 2"),
        ("&volume_m3=1&target_pa=-1", "expected target_pa above 0, found -1"),
        ("&volume_m3=1", "expected at least 30 samples, got 0"),
    ] {
        let path = format!("/api/identify?series=chamber&from=1&to=9{query}");
        assert_eq!(station.problem(&path), (400, sentence.to_owned()), "{path}");
    }
}

#[test]
fn a_rise_after_a_recorded_pump_down_knows_the_time_of_pumping() {
    let station = TestStation::new();
    let (closed, end) = (600, 900);
    let pa = |second: i64| match second {
        ..600 => (1e5 * (-second as f64 / 5.0).exp()).max(1e-4),
        _ => 1e-4 + 1e-6 * (second - 600) as f64,
    };
    (0..end).for_each(|second| station.record(second, pa(second)));
    assert!(station.services.recorder().flush());
    let (from, to) = (NEW_YEAR_MS + closed * 1000, NEW_YEAR_MS + end * 1000);
    let rise = station.json(&format!("/api/rise?series=chamber&from={from}&to={to}"));
    let pumped = rise["pumped_s"].as_f64().unwrap();
    assert!((pumped - 600.0).abs() <= 5.0, "{pumped}");
}

/// The uncertainty of the gauge is that of its sensitivity: no number of samples reduces it.
#[test]
fn the_uncertainty_of_the_gauge_widens_the_intervals() {
    let station = TestStation::new();
    (0..300).for_each(|second| station.record(second, 1e-4 + 1e-6 * second as f64));
    assert!(station.services.recorder().flush());
    let to = NEW_YEAR_MS + 300_000;
    let path = format!("/api/rise?series=chamber&from={NEW_YEAR_MS}&to={to}");
    let rise = station.json(&format!("{path}&accuracy=0.15"));
    // Limits of 15 % are a rectangular distribution: its standard deviation is 15 % / √3, and the interval has 1.96 of it.
    let [low, high] = ["low", "high"].map(|key| rise["leak_pa_per_s"][key].as_f64().unwrap());
    assert!((0.82e-6..0.84e-6).contains(&low) && (1.16e-6..1.18e-6).contains(&high), "{low} {high}");
    assert_eq!(rise["accuracy"], 0.15);
    assert!(station.json(&path)["accuracy"].is_null());
}

#[test]
fn the_time_of_pumping_is_known_after_more_samples_than_are_fitted() {
    let station = TestStation::new();
    let pa = |second: i64| match second {
        ..30_000 => (1e5 * (-second as f64 / 5.0).exp()).max(1e-4) * (1.0 + 0.02 * (second % 2) as f64),
        _ => 1e-4 + 1e-6 * (second - 30_000) as f64,
    };
    (0..30_300).for_each(|second| station.record(second, pa(second)));
    assert!(station.services.recorder().flush());
    let (from, to) = (NEW_YEAR_MS + 30_000_000, NEW_YEAR_MS + 30_300_000);
    let rise = station.json(&format!("/api/rise?series=chamber&from={from}&to={to}"));
    let pumped = rise["pumped_s"].as_f64().unwrap();
    assert!((pumped / 30_000.0 - 1.0).abs() < 0.01, "{pumped}");
}

#[test]
fn events_come_latest_first() {
    let station = TestStation::new();
    station.services.recorder().event_now_and_wait(Some("chamber"), EventKind::Gauge, "emission is on");
    station.services.recorder().event_now_and_wait(None, EventKind::Station, "the station begins");
    let events = station.json(&format!("/api/events?from=0&to={}", i64::MAX));
    let texts: Vec<_> = events.as_array().unwrap().iter().map(|event| event["text"].as_str().unwrap()).collect();
    assert_eq!(texts, ["the station begins", "emission is on"]);
    assert_eq!((&events[1]["gauge"], &events[1]["kind"]), (&"chamber".into(), &"gauge".into()));
}

#[test]
fn an_export_is_a_csv_attachment() {
    let station = TestStation::new();
    station.record(0, 1e-3);
    assert!(station.services.recorder().flush());
    let (status, kind, text) = station.get(&format!("/api/export.csv?from={NEW_YEAR_MS}&to={}", NEW_YEAR_MS + 1));
    assert_eq!((status, kind.as_str()), (200, "text/csv; charset=utf-8"));
    assert_eq!(text, "time,gauge,pressure_pa,quality\n2026-01-01T00:00:00.000000Z,chamber,1e-3,valid\n");
}

fn point(name: &str, unit: Option<&str>, kind: PointKind) -> Arc<Point> {
    Arc::new(Point { slave: "turbo".to_owned(), name: name.to_owned(), unit: unit.map(str::to_owned), kind })
}

/// A station that has recorded the speed of a turbo, first in Hz, and its state.
fn station_with_points() -> TestStation {
    let station = TestStation::new();
    station.record(0, 1e-3);
    let at = |second: i64| Micros((NEW_YEAR_MS + second * 1000) * 1000);
    let value = |second, number| PointSample::new(at(second), Some(number), Quality::Valid);
    let [hertz, rpm] = ["Hz", "rpm"].map(|unit| point("speed", Some(unit), PointKind::Number));
    let recorder = station.services.recorder();
    recorder.push_point(&hertz, 0.0, value(0, 1000.0));
    (1..=20).for_each(|second| recorder.push_point(&rpm, 0.0, value(second, if second <= 10 { -2.0 } else { 4.0 })));
    let state = point("state", None, PointKind::Code);
    recorder.push_point(&state, 0.0, value(1, 3.0));
    assert!(recorder.flush());
    // The texts of the present file: the point in Hz is no longer in it.
    let texts = vec![CodeText { number: 3.0, text: "at speed".to_owned() }];
    let point = (*state).clone();
    let points = vec![DescribedPoint { point: (*rpm).clone(), texts: Vec::new() }, DescribedPoint { point, texts }];
    station.services.directory().set(Directory { points, ..Directory::default() });
    station
}

#[test]
fn a_trend_of_a_point_has_its_unit_and_no_pressure() {
    let station = station_with_points();
    let listed = station.json("/api/points");
    let units: Vec<_> = listed.as_array().unwrap().iter().map(|it| (&it["name"], &it["unit"], &it["kind"])).collect();
    let word = |text: &str| Value::from(text);
    let expected = [
        (&word("speed"), &word("Hz"), &word("number")),
        (&word("speed"), &word("rpm"), &word("number")),
        (&word("state"), &Value::Null, &word("code")),
    ];
    assert_eq!(units, expected);
    let texts: Vec<_> = listed.as_array().unwrap().iter().map(|it| &it["texts"]).collect();
    let at_speed = serde_json::json!([{"number": 3.0, "text": "at speed"}]);
    assert_eq!(texts, [&serde_json::json!([]), &serde_json::json!([]), &at_speed]);
    let trend = |query: &str| {
        let to = NEW_YEAR_MS + 20_500;
        station.json(&format!("/api/point-trend?slave=turbo&{query}&from={}&to={to}&pixels=4", NEW_YEAR_MS + 500))
    };
    let speed = trend("point=speed");
    assert_eq!(speed["point"], serde_json::json!({"slave": "turbo", "name": "speed", "unit": "rpm", "kind": "number"}));
    // Five seconds each.
    let values = serde_json::json!([-2.0, -2.0, 4.0, 4.0]);
    assert_eq!((&speed["mean"], &speed["low"]), (&values, &values));
    // Its only value is before the range, and its span of ten seconds is not.
    let hertz = trend("point=speed&unit=Hz");
    assert_eq!((&hertz["point"]["unit"], &hertz["mean"]), (&word("Hz"), &serde_json::json!([1000.0])));
    let state = trend("point=state");
    assert_eq!((&state["texts"], &speed["texts"]), (&at_speed, &serde_json::json!([])));
    assert_eq!((&state["mean"], &state["last"]), (&serde_json::json!([null]), &serde_json::json!([3.0])));
    // A series of pressures has no such name.
    assert_eq!(station.problem("/api/trend?series=turbo.speed&from=0&to=9999999999999").0, 404);
    for (query, part) in
        [("slave=turbo&point=current", "no value of point \"current\""), ("slave=gate&point=speed", "gate")]
    {
        let (status, detail) = station.problem(&format!("/api/point-trend?{query}&from=1&to=2"));
        assert!(status == 404 && detail.contains(part), "{status} {detail}");
    }
    assert_eq!(station.problem("/api/point-trend?slave=turbo&point=speed&from=2&to=1").0, 400);
}

#[test]
fn an_export_of_points_has_their_units_and_an_export_of_pressures_has_no_point() {
    let station = station_with_points();
    let range = format!("from={NEW_YEAR_MS}&to={}", NEW_YEAR_MS + 1_000);
    let (status, kind, text) = station.get(&format!("/api/points.csv?{range}"));
    assert_eq!((status, kind.as_str()), (200, "text/csv; charset=utf-8"));
    let expected = "\
time,slave,point,unit,value,quality,text
2026-01-01T00:00:00.000000Z,turbo,speed,Hz,1000,valid,
2026-01-01T00:00:01.000000Z,turbo,speed,rpm,-2,valid,
2026-01-01T00:00:01.000000Z,turbo,state,,3,valid,at speed
";
    assert_eq!(text, expected);
    let rows = |query: &str| station.get(&format!("/api/points.csv?{range}{query}")).2.lines().count() - 1;
    assert_eq!([rows("&slave=turbo&point=speed"), rows("&point=state"), rows("&slave=gate")], [2, 1, 0]);
    let (_, _, pressures) = station.get(&format!("/api/export.csv?{range}"));
    assert_eq!(pressures, "time,gauge,pressure_pa,quality\n2026-01-01T00:00:00.000000Z,chamber,1e-3,valid\n");
}

#[cfg(feature = "parquet")]
#[test]
fn an_export_of_points_may_be_a_parquet_file() {
    let station = station_with_points();
    let path = format!("/api/points.parquet?from={NEW_YEAR_MS}&to={}", NEW_YEAR_MS + 1_000);
    let (head, octets) = station.octets("GET", &path);
    assert_eq!(head.status(), 200);
    assert_eq!(head.headers()["content-disposition"], "attachment; filename=\"points.parquet\"");
    assert!(octets.starts_with(b"PAR1") && octets.ends_with(b"PAR1"), "{} octets", octets.len());
    assert!(octets.windows(3).any(|part| part == b"rpm"), "the unit is in the statistics");
}

#[cfg(feature = "parquet")]
#[test]
fn an_export_may_be_a_parquet_file() {
    let station = TestStation::new();
    for second in 0..5_000 {
        station.record(second, 1e-3);
    }
    assert!(station.services.recorder().flush());
    let path = format!("/api/export.parquet?from={NEW_YEAR_MS}&to={}", NEW_YEAR_MS + 5_000_000);
    let (head, octets) = station.octets("GET", &path);
    assert_eq!(head.status(), 200);
    assert_eq!(head.headers()["content-type"], "application/vnd.apache.parquet");
    assert!(octets.starts_with(b"PAR1") && octets.ends_with(b"PAR1"), "{} octets", octets.len());
    assert!(octets.windows(7).any(|part| part == b"chamber"), "the name of the series is in the statistics");
    assert_eq!(station.get("/api/export.parquet?from=2&to=1").0, 400);
}

/// Names may contain commas: a repeated `series` names one series each, and only a value that is no name is split at its commas.
#[test]
fn an_export_has_the_requested_series() {
    let station = TestStation::new();
    for name in ["hall, north", "hall", "north & south", "annex", "=1+1"] {
        let at = Micros(NEW_YEAR_MS * 1000);
        station.services.recorder().push(&Arc::from(name), Sample::new(at, Some(1.0), Quality::Valid));
    }
    assert!(station.services.recorder().flush());
    for (asked, expected) in [
        // An apostrophe keeps a spreadsheet from reading a name as a formula.
        ("", &["'=1+1", "annex", "hall", "hall, north", "north & south"][..]),
        ("&series=hall%2C%20north", &["hall, north"]),
        ("&series=hall%2C+north&series=annex", &["annex", "hall, north"]),
        ("&series=hall,annex", &["annex", "hall"]),
        ("&series=hall&series=hall,hall", &["hall"]),
        ("&series=north+%26+south&series=hall,annex", &["annex", "hall", "north & south"]),
        ("&series=chamber", &[]),
    ] {
        let (status, _, text) =
            station.get(&format!("/api/export.csv?from={NEW_YEAR_MS}&to={}{asked}", NEW_YEAR_MS + 1));
        let mut names: Vec<_> = text.lines().skip(1).map(|row| name_of(row).to_owned()).collect();
        names.sort();
        assert_eq!((status, names.iter().map(String::as_str).collect::<Vec<_>>()), (200, expected.to_vec()), "{asked}");
    }
}

/// The name between time and pressure, without its quotes.
fn name_of(row: &str) -> &str {
    let (_, rest) = row.split_once(',').unwrap();
    rest.trim_end_matches(",valid").rsplit_once(',').unwrap().0.trim_matches('"')
}

/// Samples that are deleted after the first chunk are missing in the rest: the station has not read ahead far.
#[test]
fn an_export_is_read_while_the_client_reads() {
    let station = TestStation::new();
    (0..40_000).for_each(|second| station.record(second, 1e-3));
    assert!(station.services.recorder().flush());
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
    let rows = runtime.block_on(async {
        let path = format!("/api/export.csv?from={NEW_YEAR_MS}&to={}", NEW_YEAR_MS + 100_000_000);
        let request = Request::get(path).body(Body::empty()).unwrap();
        let response = router(Arc::clone(&station.services)).oneshot(request).await.unwrap();
        let mut pieces = response.into_body().into_data_stream();
        let mut rows = text(pieces.next().await).lines().count();
        let file = rusqlite::Connection::open(station.folder.path().join("plant.db")).unwrap();
        file.execute("DELETE FROM sample", []).unwrap();
        while let Some(piece) = pieces.next().await {
            rows += text(Some(piece)).lines().count();
        }
        rows
    });
    assert!(rows < 10_000, "{rows} rows");
}

fn text(piece: Option<Result<axum::body::Bytes, axum::Error>>) -> String {
    String::from_utf8(piece.unwrap().unwrap().to_vec()).unwrap()
}

#[test]
fn a_rise_with_many_samples_is_fitted_to_their_means() {
    let station = TestStation::new();
    (0..30_000).for_each(|second| station.record(second, 1e-4 + 1e-6 * second as f64));
    assert!(station.services.recorder().flush());
    let to = NEW_YEAR_MS + 30_000_000;
    let rise = station.json(&format!("/api/rise?series=chamber&from={NEW_YEAR_MS}&to={to}"));
    let [low, high] = ["low", "high"].map(|key| rise["leak_pa_per_s"][key].as_f64().unwrap());
    assert!((0.97e-6..=1e-6).contains(&low) && high >= 1e-6, "{low} {high}");
    assert_eq!(rise["cause"], "leak");
    assert!(rise["samples"].as_u64().unwrap() <= 20_001, "{rise}");
}

#[test]
fn a_method_that_a_path_does_not_have_is_refused() {
    let station = TestStation::new();
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "PATCH"] {
        for path in ["/api/station", "/api/no/such/thing", "/"] {
            let (response, text) = station.send(method, path);
            let allow = response.headers().get("allow").map(|value| value.to_str().unwrap());
            assert_eq!((response.status().as_u16(), allow), (405, Some("GET,HEAD")), "{method} {path}");
            assert!(text.contains("this method is not available here"), "{text}");
        }
    }
    let (response, text) = station.send("HEAD", "/api/station");
    assert_eq!((response.status().as_u16(), text.as_str()), (200, ""));
}

#[test]
fn every_answer_of_the_api_has_security_headers() {
    let station = TestStation::new();
    for path in ["/api/station", "/api/no/such/thing"] {
        let (response, _) = station.ask(path);
        let header = |name: &str| response.headers().get(name).map(|value| value.to_str().unwrap().to_owned());
        assert_eq!(header("x-content-type-options").as_deref(), Some("nosniff"), "{path}");
        assert_eq!(header("x-frame-options").as_deref(), Some("DENY"));
        assert_eq!(header("cache-control").as_deref(), Some("no-store"));
        assert!(header("content-security-policy").unwrap().starts_with("default-src 'none'"));
    }
}

#[test]
fn the_description_names_every_path() {
    let description: Value = serde_json::from_str(&description()).unwrap();
    let described = description["paths"].as_object().unwrap();
    let station = TestStation::new();
    assert_eq!(described.len(), 61);
    for (path, methods) in described.iter().filter(|(path, _)| *path != "/api/live" && !path.contains("blocks")) {
        let (status, _, text) = station.get(&path.replace("{name}", "chamber"));
        let operation = ["get", "post", "delete"].iter().map(|method| &methods[method]).find(|one| one.is_object());
        assert!(
            operation.unwrap()["responses"]["429"].is_object(),
            "{path}: the answers of the middleware are missing"
        );
        // The station of this test has no line to listen to, and no alarm. A request without a user is that of a viewer.
        let is_of_none = path.starts_with("/api/segments/{name}/") || path.ends_with("/settings");
        let is_of_an_engineer = path.starts_with("/api/backup");
        let expected: &[u16] = match methods["get"].is_object() {
            true if is_of_none => &[404],
            true if is_of_an_engineer => &[403],
            true => &[200, 400],
            false => &[405],
        };
        assert!(expected.contains(&status), "{path}: {status} {text}");
    }
    assert_eq!(station.json("/api/openapi.json"), description);
}
