//! The parameters of controllers without DP-V1: they travel in the parameter channel, beside the cyclic data of the station.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support::memory_station::{ENGINEER, MemoryStation, OPERATOR, VIEWER};
use profivac_station::view::BusStationState;
use serde_json::{Value, json};

const CONTROLLERS: [&str; 2] = ["tpg300@5", "tpg500@5"];

/// Relay 4, which the factory settings leave at channel A1.
const UPPER_THRESHOLD: &str = "relay.4/upper-threshold";
const THRESHOLD: &str = "relay.4/lower-threshold";
const VALIDATION: &str = "relay.4/threshold-validation";

/// A parameter as the API shows it.
fn parameter(station: &MemoryStation, target: &str) -> Value {
    let (status, blocks) = station.get(VIEWER, "/api/gauges/chamber/blocks");
    assert_eq!(status, 200, "{blocks}");
    let mut all = blocks.as_array().unwrap().iter().flat_map(|block| block["parameters"].as_array().unwrap());
    let found = all.find(|parameter| parameter["target"] == target);
    found.unwrap_or_else(|| panic!("no {target} in {blocks:#}")).clone()
}

/// Arms and executes a write, and returns the values before and after.
fn write(station: &MemoryStation, target: &str, value: &str) -> (Value, Value) {
    let (status, armed) = station.arm(ENGINEER, &json!({ "target": target, "value": value }));
    assert_eq!(status, 200, "{armed}");
    let (status, done) = station.execute(ENGINEER, &armed);
    assert_eq!(status, 200, "{done}");
    (done["before"].clone(), done["after"].clone())
}

#[test]
fn the_parameters_of_a_controller_are_read_beside_its_cyclic_data() {
    for spec in CONTROLLERS {
        let station = MemoryStation::with_device(spec, 1e-2);
        let filter = parameter(&station, "a1.filter-time-constant");
        assert_eq!((&filter["value"], &filter["read_error"]), (&json!("medium"), &Value::Null), "{spec}: {filter}");
        assert_eq!(filter["write"]["allowed_values"], json!(["fast", "medium", "slow"]), "{spec}");
        assert_eq!(
            (&filter["write"]["role"], &filter["write"]["risk"]["class"]),
            (&json!("engineer"), &json!("stored-on-request"))
        );
        let unit = parameter(&station, "a1.pressure-unit");
        assert_eq!(unit["value"], "mbar", "{spec}");
        assert!(unit["write"]["blocked_reason"].is_string(), "the station decodes the cyclic data with it");
        let status = parameter(&station, "relay.4/setpoint-status");
        assert_eq!(status["write"], Value::Null, "{spec}: it is read-only");
        assert_eq!(station.gauge().state, BusStationState::DataExchange, "{spec}");
        assert!(!station.gauge().has_dpv1);
    }
}

#[test]
fn a_threshold_of_a_controller_is_opened_written_and_declared_valid() {
    for spec in CONTROLLERS {
        let station = MemoryStation::with_device(spec, 1e-2);
        station.take_control(ENGINEER);
        let opened = write(&station, VALIDATION, "open-for-changes");
        assert_eq!(opened.1, "open-for-changes", "{spec}");
        let (_, after) = write(&station, UPPER_THRESHOLD, "4 Pascal");
        assert_eq!(after, "0.04 mbar", "{spec}");
        let (before, after) = write(&station, THRESHOLD, "2 Pascal");
        assert_eq!(after, "0.02 mbar", "{spec}, before {before}");
        let valid = write(&station, VALIDATION, "valid");
        assert_eq!(valid, (json!("open-for-changes"), json!("valid")), "{spec}");
        assert_eq!(parameter(&station, THRESHOLD)["value"], "0.02 mbar", "{spec}");
        let gauge = station.gauge();
        assert_eq!((gauge.state, gauge.problem), (BusStationState::DataExchange, None), "{spec}");
    }
}

#[test]
fn a_write_that_a_controller_refuses_is_reported_with_its_reason() {
    for spec in CONTROLLERS {
        let station = MemoryStation::with_device(spec, 1e-2);
        station.take_control(ENGINEER);
        // Without open-for-changes a threshold is not changeable.
        let (status, armed) = station.arm(ENGINEER, &json!({ "target": THRESHOLD, "value": "1e-2 mbar" }));
        assert_eq!(status, 200, "{armed}");
        let (status, refused) = station.execute(ENGINEER, &armed);
        assert_eq!(status, 409, "{spec}: {refused}");
        assert!(
            refused["detail"]
                .as_str()
                .unwrap()
                .contains("open the set first: write relay.4/threshold-validation open-for-changes"),
            "{spec}: {refused}"
        );
        let (status, blocked) = station.arm(ENGINEER, &json!({ "target": "a1.pressure-unit", "value": "Torr" }));
        assert_eq!(status, 409, "{spec}: {blocked}");
        let (status, cyclic) = station.arm(ENGINEER, &json!({ "target": "device.sensor-on-off", "value": 1 }));
        assert_eq!(status, 400, "{spec}: {cyclic}");
    }
}

#[test]
fn a_command_of_a_controller_is_listed_armed_and_executed() {
    for spec in CONTROLLERS {
        let station = MemoryStation::with_device(spec, 1e-2);
        let (_, commands) = station.get(VIEWER, "/api/gauges/chamber/commands");
        let store = commands.as_array().unwrap().iter().find(|command| command["command"] == "device.store");
        let store = store.unwrap_or_else(|| panic!("{commands:#}"));
        assert_eq!((&store["role"], &store["risk"]["class"]), (&json!("engineer"), &json!("dangerous")));
        station.take_control(OPERATOR);
        assert_eq!(station.arm(OPERATOR, &json!({ "command": "device.store" })).0, 403, "{spec}");
        station.post(OPERATOR, "/api/control-authority/release", None);
        station.take_control(ENGINEER);
        let (status, armed) = station.arm(ENGINEER, &json!({ "command": "device.store" }));
        assert_eq!(status, 200, "{spec}: {armed}");
        let (status, done) = station.execute(ENGINEER, &armed);
        assert_eq!(status, 200, "{spec}: {done}");
    }
}
