//! The points of a slave by its GSD file.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_gateway::model::Modeller;
use profivac_gateway::{EpicsSeverity, Inputs, Limits, Signal, Snapshot, State, Subject, Value};
use profivac_recorder::{Micros, Quality};
use profivac_station::view::{BusStationState, GaugeKind};
use std::fs;
use std::sync::Arc;

const GSD: &str = "#Profibus_DP
Vendor_Name = \"Invented\"
Model_Name = \"Valve 7\"
Ident_Number = 0x0FA7
Max_Input_Len = 2
Max_Output_Len = 0
Module = \"Position\" 0x11
1
EndModule
";

const FILE: &str = r#"
[[segment]]
name = "hall"
port = "sim:hall.toml"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.slave]]
name = "gate"
address = 9
gsd = "valve.gsd"
own = true

[[segment.slave.point]]
name = "position"
octet = 1
type = "u8"
unit = "mm"

[[segment.slave.point.alarm]]
above = 95
priority = "high"

[[segment.slave.point.alarm]]
above = 90

[[segment.slave.point.alarm]]
below = 5

[[segment.slave.point]]
name = "limit switch"
bit = 0
type = "bool"
texts = { 0 = "open", 1 = "closed" }

[[segment.slave.point]]
name = "opening"
octet = 1
type = "u8"
scale = 0.5
unit = "%"
"#;

fn planned() -> Inputs {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("valve.gsd"), GSD).unwrap();
    Inputs::planned(&profivac_config::parse(FILE, &folder.path().join("plant.toml")).unwrap())
}

/// The valve exchanges data; its points have these numbers, texts and qualities.
fn measuring(values: [(Option<f64>, &str, Quality); 3], age_ms: u64) -> Inputs {
    let mut inputs = planned();
    let gate = inputs.gauges.iter_mut().find(|gauge| gauge.name == "gate").unwrap();
    assert_eq!(gate.kind, GaugeKind::Slave);
    (gate.state, gate.age_ms, gate.read_at) = (BusStationState::DataExchange, Some(age_ms), Some(Micros(7)));
    let mut points = gate.parameters.to_vec();
    for (point, (number, text, quality)) in points.iter_mut().zip(values) {
        (point.number, point.quality, point.read_at) = (number, quality, Some(Micros(7)));
        point.text = text.to_owned();
    }
    gate.parameters = Arc::from(points);
    inputs
}

const GOOD: [(Option<f64>, &str, Quality); 3] = [
    (Some(40.0), "40 mm", Quality::Valid),
    (Some(1.0), "closed", Quality::Valid),
    (Some(20.0), "20 %", Quality::Valid),
];

fn value(snapshot: &Snapshot, subject: &str, signal: Signal) -> (Value, State, Option<&'static str>) {
    let is_it = |(point, _): &(&profivac_gateway::Point, _)| {
        point.subject.name() == subject && point.signal == signal && point.subject.gauge() == Some("gate")
    };
    let (point, value) = snapshot.iter().find(is_it).unwrap_or_else(|| panic!("{subject} {signal:?}"));
    (value.value.clone(), value.state, point.unit)
}

#[test]
fn the_points_of_a_slave_are_parameters_in_the_unit_of_the_file() {
    let snapshot = Modeller::default().next(measuring(GOOD, 10), Micros(8));
    assert_eq!(value(&snapshot, "position", Signal::ParameterNumber), (Value::Float(40.0), State::Ok, Some("mm")));
    let text = |text: &str| Value::Text(Arc::from(text));
    assert_eq!(value(&snapshot, "limit switch", Signal::ParameterText).0, text("closed"));
    assert_eq!(value(&snapshot, "limit switch", Signal::ParameterNumber), (Value::Float(1.0), State::Ok, None));
    assert_eq!(value(&snapshot, "opening", Signal::ParameterPercentage).0, Value::Float(20.0));
    assert_eq!(value(&snapshot, "gate", Signal::Device).0, text("Invented Valve 7"));
    let pascals =
        snapshot.iter().filter(|(point, _)| point.subject.gauge() == Some("gate") && point.unit == Some("Pa"));
    assert_eq!(pascals.count(), 0, "no pressure");
}

#[test]
fn a_bad_number_is_a_fault_and_old_values_are_stale() {
    let bad = [(None, "bad, status 00h", Quality::Fault), GOOD[1], GOOD[2]];
    let snapshot = Modeller::default().next(measuring(bad, 10), Micros(8));
    let (number, state, _) = value(&snapshot, "position", Signal::ParameterNumber);
    assert_eq!((number, state), (Value::None, State::Fault));
    assert_eq!(value(&snapshot, "opening", Signal::ParameterPercentage).1, State::Ok);
    let snapshot = Modeller::default().next(measuring(GOOD, 60_000), Micros(8));
    let (number, state, _) = value(&snapshot, "position", Signal::ParameterNumber);
    assert_eq!((number, state), (Value::None, State::Stale));
    // An archiver that keeps one value for each time would miss a loss with the time of the last value.
    let is_position =
        |point: &profivac_gateway::Point| point.subject.name() == "position" && point.signal == Signal::ParameterNumber;
    let (_, position) = snapshot.iter().find(|(point, _)| is_position(point)).unwrap();
    assert_eq!(position.at, Some(Micros(7 + 3 * Micros::SECOND)), "when it became stale");
}

/// PROFIBUS PA calls a value uncertain, and so does OPC UA; the number stays.
#[test]
fn an_uncertain_number_of_a_point_has_the_state_uncertain() {
    let uncertain = [(Some(40.0), "40 mm (uncertain)", Quality::Valid), GOOD[1], GOOD[2]];
    let snapshot = Modeller::default().next(measuring(uncertain, 10), Micros(8));
    let (number, state, _) = value(&snapshot, "position", Signal::ParameterNumber);
    assert_eq!((number, state), (Value::Float(40.0), State::Uncertain));
    let codes = state.codes();
    // OPC 10000-4: Uncertain without a cause.
    assert_eq!((codes.opcua, codes.epics_severity, codes.sparkplug), (0x4000_0000, EpicsSeverity::Minor, 192));
    assert_eq!(value(&snapshot, "opening", Signal::ParameterPercentage).1, State::Ok);
}

#[test]
fn the_limits_of_a_point_are_in_its_own_unit_and_no_other_point_has_them() {
    let snapshot = Modeller::default().next(measuring(GOOD, 10), Micros(8));
    let limits = |subject: &str, signal: Signal| {
        let is_it = |point: &&profivac_gateway::Point| point.subject.name() == subject && point.signal == signal;
        snapshot.points.iter().find(is_it).unwrap_or_else(|| panic!("{subject} {signal:?}")).limits
    };
    let expected = Limits { high_high: Some(95.0), high: Some(90.0), low: Some(5.0), low_low: None };
    assert_eq!(limits("position", Signal::ParameterNumber), expected);
    assert_eq!(limits("position", Signal::ParameterText), Limits::default());
    assert_eq!(limits("opening", Signal::ParameterPercentage), Limits::default());
}

#[test]
fn a_bit_has_no_decimals_and_a_number_with_a_unit_has_some() {
    let snapshot = Modeller::default().next(measuring(GOOD, 10), Micros(8));
    let decimals = |subject: &str, signal: Signal| {
        let is_it = |point: &&profivac_gateway::Point| point.subject.name() == subject && point.signal == signal;
        snapshot.points.iter().find(is_it).unwrap_or_else(|| panic!("{subject} {signal:?}")).decimals()
    };
    assert_eq!(decimals("limit switch", Signal::ParameterNumber), 0);
    assert_eq!(decimals("position", Signal::ParameterNumber), 3);
}

/// A slave that exchanges data with no master is asked each second, and its record was read before.
#[test]
fn a_point_in_a_record_has_the_time_of_the_record_and_needs_no_data_exchange() {
    let mut inputs = measuring(GOOD, 10);
    let gate = inputs.gauges.iter_mut().find(|gauge| gauge.name == "gate").unwrap();
    (gate.state, gate.read_at) = (BusStationState::Missing, Some(Micros(9)));
    let snapshot = Modeller::default().next(inputs, Micros(10));
    let is_position =
        |point: &profivac_gateway::Point| point.subject.name() == "position" && point.signal == Signal::ParameterNumber;
    let (_, position) = snapshot.iter().find(|(point, _)| is_position(point)).unwrap();
    assert_eq!((&position.value, position.state, position.at), (&Value::Float(40.0), State::Ok, Some(Micros(7))));
}

/// A file without a vendor may have the name of a gauge as its model.
#[test]
fn a_slave_without_points_has_no_parameters_and_readings_of_a_gauge() {
    let mut inputs = planned();
    let gate = inputs.gauges.iter_mut().find(|gauge| gauge.name == "gate").unwrap();
    (gate.device, gate.parameters) = ("bcg450".to_owned(), Arc::default());
    let snapshot = Modeller::default().next(inputs, Micros(8));
    let subjects = snapshot.iter().filter(|(point, _)| point.subject.gauge() == Some("gate"));
    let of_gauge = subjects.filter(|(point, _)| !matches!(point.subject, Subject::Gauge(_)));
    assert_eq!(of_gauge.count(), 0);
}

#[test]
fn the_points_exist_before_the_slave_was_found() {
    let snapshot = Modeller::default().next(planned(), Micros(8));
    let (number, state, unit) = value(&snapshot, "position", Signal::ParameterNumber);
    assert_eq!((number, state, unit), (Value::None, State::Stale, Some("mm")));
}
