//! The read model of a running station with gauges in memory.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::until::until;
use profivac_gateway::{Point, PointValue, ReadModel, Signal, Snapshot, State, Value};
use profivac_station::station::Station;
use std::path::Path;
use std::sync::Arc;
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

const PERCENTAGE: &str = "setpoint-a.percentage-of-atmosphere";

fn started(folder: &TempDir) -> (Station, ReadModel) {
    let segment = folder.path().join("hall.toml");
    std::fs::write(&segment, SEGMENT).unwrap();
    let text = PLANT.replace("SEGMENT", &segment.display().to_string());
    let station =
        Station::start(profivac_config::parse(&text, Path::new(&folder.path().join("plant.toml"))).unwrap()).unwrap();
    let model = ReadModel::start(station.services()).unwrap();
    (station, model)
}

/// Waits for a snapshot that `is_it`.
fn snapshot_that(model: &ReadModel, is_it: impl Fn(&Snapshot) -> bool) -> Arc<Snapshot> {
    until("a snapshot", || Some(model.snapshot()).filter(|snapshot| is_it(snapshot)))
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
    let snapshot = snapshot_that(&model, |snapshot| {
        let is_read =
            |gauge, name, signal| found(snapshot, gauge, name, signal).is_some_and(|it| it.state == State::Ok);
        is_read("chamber", "ba.emission-status", Signal::ParameterText)
            && is_read("fore line", "trip-point.1/high-trip-point", Signal::ParameterPressure)
            && is_read("controller", "relay.1/setpoint-status", Signal::ParameterNumber)
            && is_read("chamber", "chamber", Signal::Pressure)
            && is_read("chamber", PERCENTAGE, Signal::ParameterPercentage)
    });
    let Value::Float(pa) = value(&snapshot, "chamber", "chamber", Signal::Pressure).value else { panic!("a pressure") };
    assert!((pa / 0.1 - 1.0).abs() < 1e-3, "1e-3 mbar, the default of a segment: {pa} Pa");
    let Value::Text(emission) = &value(&snapshot, "chamber", "ba.emission-status", Signal::ParameterText).value else {
        panic!("a text")
    };
    assert_ne!(&**emission, "", "the words of the manual");
    // The factory setting, which the record of the gauge holds as 50 tenths.
    let percentage = &value(&snapshot, "chamber", PERCENTAGE, Signal::ParameterPercentage).value;
    assert_eq!(percentage, &Value::Float(5.0));
    assert!(snapshot.points.iter().all(|point| point.subject.gauge().is_none() || point.is_simulated));
    station.stop().unwrap();
}

#[test]
fn parameters_are_wanted_as_long_as_a_gateway_runs() {
    let folder = tempfile::tempdir().unwrap();
    let (station, model) = started(&folder);
    assert!(station.services().snapshots().are_parameters_wanted());
    drop(model);
    assert!(!station.services().snapshots().are_parameters_wanted());
    station.stop().unwrap();
}
