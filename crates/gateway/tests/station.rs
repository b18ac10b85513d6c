//! The read model of a running station with gauges in memory.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_gateway::{Point, PointValue, ReadModel, Signal, Snapshot, State, Value};
use profivac_station::config::Config;
use profivac_station::station::Station;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tempfile::TempDir;

const SEGMENT: &str = r#"
baud = 1500000
devices = ["bcg450@5:unit=Pascal", "psg550@6", "tpg300@7"]
"#;

const PLANT: &str = r#"
[[segment]]
name = "hall"
port = "sim:SEGMENT"
baud = 1500000

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.gauge]]
name = "fore line"
address = 6
device = "psg550"

[[segment.gauge]]
name = "controller"
address = 7
device = "tpg300"
"#;

fn started(folder: &TempDir) -> (Station, ReadModel) {
    let segment = folder.path().join("hall.toml");
    std::fs::write(&segment, SEGMENT).unwrap();
    let text = PLANT.replace("SEGMENT", &segment.display().to_string());
    let station = Station::start(Config::parse(&text, Path::new(&folder.path().join("plant.toml"))).unwrap()).unwrap();
    let model = ReadModel::start(station.services()).unwrap();
    (station, model)
}

/// Waits for a snapshot that `is_it`.
fn until(model: &ReadModel, is_it: impl Fn(&Snapshot) -> bool) -> Arc<Snapshot> {
    let end = Instant::now() + Duration::from_secs(60);
    loop {
        let snapshot = model.snapshot();
        if is_it(&snapshot) {
            return snapshot;
        }
        assert!(Instant::now() < end, "{}", described(&snapshot));
        std::thread::park_timeout(Duration::from_millis(50));
    }
}

/// The gauges' points, a line each, for the message of a failed test.
fn described(snapshot: &Snapshot) -> String {
    let of_gauges = snapshot.iter().filter(|(point, _)| point.subject.gauge().is_some());
    let line = |(point, value): (&Point, &PointValue)| {
        let (gauge, name) = (point.subject.gauge().unwrap_or_default(), point.subject.name());
        format!("{gauge} {name} {}: {:?} {:?}\n", point.signal.key(), value.state, value.value)
    };
    of_gauges.map(line).collect()
}

/// The value of a point; `None` before the segment has published its gauges.
fn found<'a>(snapshot: &'a Snapshot, gauge: &str, name: &str, signal: Signal) -> Option<&'a PointValue> {
    let is_it =
        |point: &Point| point.subject.gauge() == Some(gauge) && point.subject.name() == name && point.signal == signal;
    snapshot.iter().find(|(point, _)| is_it(point)).map(|(_, value)| value)
}

fn value<'a>(snapshot: &'a Snapshot, gauge: &str, name: &str, signal: Signal) -> &'a PointValue {
    found(snapshot, gauge, name, signal).unwrap_or_else(|| panic!("{gauge} has no {name}"))
}

#[test]
fn a_gateway_sees_pressures_trip_points_and_emission_of_running_gauges() {
    let folder = tempfile::tempdir().unwrap();
    let (station, model) = started(&folder);
    let snapshot = until(&model, |snapshot| {
        let is_read =
            |gauge, name, signal| found(snapshot, gauge, name, signal).is_some_and(|it| it.state == State::Ok);
        is_read("chamber", "ba.emission-status", Signal::ParameterText)
            && is_read("fore line", "trip-point.1/high-trip-point", Signal::ParameterPressure)
            && is_read("controller", "relay.1/setpoint-status", Signal::ParameterNumber)
            && is_read("chamber", "chamber", Signal::Pressure)
    });
    let Value::Float(pa) = value(&snapshot, "chamber", "chamber", Signal::Pressure).value else { panic!("a pressure") };
    assert!((pa / 0.1 - 1.0).abs() < 1e-3, "1e-3 mbar, the default of a segment: {pa} Pa");
    let Value::Text(emission) = &value(&snapshot, "chamber", "ba.emission-status", Signal::ParameterText).value else {
        panic!("a text")
    };
    assert_ne!(&**emission, "", "the words of the manual");
    assert!(snapshot.points.iter().all(|point| point.subject.gauge().is_none() || point.is_simulated));
    station.stop();
}

#[test]
fn without_a_gateway_no_parameter_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let (station, model) = started(&folder);
    assert!(station.services().snapshots().are_parameters_wanted());
    drop(model);
    assert!(!station.services().snapshots().are_parameters_wanted());
    station.stop();
}
