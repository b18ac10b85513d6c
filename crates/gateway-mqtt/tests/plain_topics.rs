//! Plain topics and Home Assistant's discovery: topics and contents.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_gateway::model::Modeller;
use profivac_gateway::{Inputs, Signal, Snapshot, State, Subject};
use profivac_gateway_mqtt::message::{Delivery, Message};
use profivac_gateway_mqtt::names::names;
use profivac_gateway_mqtt::plain::layout::{Layout, Topic, status};
use profivac_gateway_mqtt::plain::times::ReadTimes;
use profivac_gateway_mqtt::plain::{default_prefix, discovery};
use profivac_gateway_mqtt::tracker::{COUNTER_PERIOD, Tracker};
use profivac_listen::counts::Counts;
use profivac_listen::report::{BusReport, Distribution, StationReport};
use profivac_listen::station::StationState;
use profivac_recorder::{Micros, Quality};
use profivac_station::config::Config;
use profivac_station::config::gateways::GatewaySettings;
use profivac_station::config::gateways::mqtt::Discovery;
use profivac_station::view::{BusStationState, RecorderView};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

const FILE: &str = r#"
[station]
name = "Target hall"

[[segment]]
name = "hall"
port = "sim:hall.toml"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.gauge]]
name = "fore line"
address = 6
device = "tpg300"

[mqtt]
broker = "mqtt://localhost"
home-assistant = true

[mqtt.sparkplug]
group = "G"
"#;

fn config() -> Config {
    profivac_config::parse(FILE, Path::new("plant.toml")).unwrap()
}

/// A counter of 32 bits of a slave has ten digits; the digits of a converted float mean nothing.
#[test]
fn the_number_of_a_parameter_has_all_its_digits_and_no_others() {
    let mut inputs = measuring(Some(1.0), Micros(7));
    let numbers = [("setpoint-a.status", 4_294_967_294.0), ("ba.emission-status", f64::from(2.5e-5_f32))];
    for parameter in Arc::make_mut(&mut inputs.gauges[0].parameters) {
        let number = numbers.iter().find(|(target, _)| *target == parameter.target).map(|(_, number)| *number);
        (parameter.number, parameter.quality, parameter.read_at) = (number, Quality::Valid, Some(Micros(1)));
    }
    let messages = all(&Modeller::default().next(inputs, Micros(1)));
    let number =
        |name: &str| object(&messages, &format!("profivac/target-hall/chamber/parameter/{name}"))["number"].clone();
    assert_eq!(number("setpoint-a.status"), json!(4_294_967_294.0));
    assert_eq!(number("ba.emission-status"), json!(2.5e-5));
}

fn measuring(pa: Option<f64>, at: Micros) -> Inputs {
    let mut inputs = Inputs::planned(&config());
    let gauge = &mut inputs.gauges[0];
    gauge.state = BusStationState::DataExchange;
    (gauge.age_ms, gauge.read_at) = (Some(10), Some(at));
    let quality = if pa.is_some() { Quality::Valid } else { Quality::Off };
    (gauge.readings[0].quality, gauge.readings[0].pa) = (quality, pa);
    inputs
}

fn snapshot(pa: Option<f64>) -> Snapshot {
    Modeller::default().next(measuring(pa, Micros(1_795_316_400_120_000)), Micros(0))
}

fn all(snapshot: &Snapshot) -> BTreeMap<String, Message> {
    let layout = Layout::new(&default_prefix("Target hall"), &snapshot.points);
    let messages = (0..layout.len()).flat_map(|topic| layout.messages(topic, snapshot));
    messages.map(|message| (message.topic.clone(), message)).collect()
}

fn object(messages: &BTreeMap<String, Message>, topic: &str) -> Value {
    serde_json::from_slice(&messages[topic].payload).unwrap()
}

#[test]
fn the_state_of_a_gauge_has_pressure_unit_quality_and_the_time_of_the_reading() {
    // As a gauge sends 5.2e-6 mbar: a float has more digits than it means.
    let messages = all(&snapshot(Some(f64::from(5.2e-6_f32) * 100.0)));
    let state = object(&messages, "profivac/target-hall/chamber/state");
    assert_eq!(state["pressure"], json!(5.2e-4));
    assert_eq!((&state["unit"], &state["quality"], &state["state"]), (&json!("Pa"), &json!("valid"), &json!("OK")));
    assert_eq!(state["time"], "2026-11-22T03:00:00.12Z");
    assert_eq!((&state["usable"], &state["simulated"]), (&json!(true), &json!(true)));
    let pressure = &messages["profivac/target-hall/chamber/pressure"];
    assert_eq!((&pressure.payload[..], pressure.is_retained), (&b"5.2e-4"[..], true));
    let retained = messages.values().all(|message| message.is_retained);
    assert!(retained && messages["profivac/target-hall/chamber/state"].delivery == Delivery::AtLeastOnce);
    assert!(messages.contains_key("profivac/target-hall/fore line/2/pressure"));
    assert!(messages.contains_key("profivac/target-hall/station"));
    assert!(messages.contains_key("profivac/target-hall/segment/hall"));
}

#[test]
fn a_parameter_has_its_number_in_the_unit_beside_it() {
    let mut inputs = measuring(Some(1.0), Micros(1));
    for parameter in Arc::make_mut(&mut inputs.gauges[0].parameters) {
        (parameter.number, parameter.quality, parameter.read_at) = (Some(5.0), Quality::Valid, Some(Micros(1)));
    }
    let messages = all(&Modeller::default().next(inputs, Micros(1)));
    let parameter = |name: &str| object(&messages, &format!("profivac/target-hall/chamber/parameter/{name}"));
    let percentage = parameter("setpoint-a.percentage-of-atmosphere");
    assert_eq!((&percentage["percentage"], &percentage["unit"]), (&json!(5.0), &json!("%")));
    let threshold = parameter("setpoint-a.process-value");
    assert_eq!((&threshold["pressure"], &threshold["unit"]), (&json!(5.0), &json!("Pa")));
    let status = parameter("setpoint-a.status");
    assert_eq!((&status["number"], &status["unit"]), (&json!(5.0), &Value::Null));
    assert_eq!((&status["state"], &status["time"]), (&json!("OK"), &json!("1970-01-01T00:00:00.000001Z")));
}

/// The time of a parameter that stays the same would be that of its first reading, for ever.
#[test]
fn the_time_of_a_parameter_that_is_read_again_is_published_within_a_minute() {
    let mut modeller = Modeller::default();
    let mut read_at = |seconds: i64| {
        let mut inputs = measuring(Some(1.0), Micros(1));
        for parameter in Arc::make_mut(&mut inputs.gauges[0].parameters) {
            (parameter.number, parameter.quality) = (Some(5.0), Quality::Valid);
            parameter.read_at = Some(Micros(seconds * Micros::SECOND));
        }
        modeller.next(inputs, Micros(0))
    };
    let first = read_at(0);
    let layout = Layout::new("p", &first.points);
    let mut times = ReadTimes::default();
    times.publish(0..layout.len(), &layout, &first);
    let before = read_at(59);
    assert_eq!(times.due(&layout, &before).count(), 0);
    let due = read_at(60);
    let topics: Vec<usize> = times.due(&layout, &due).collect();
    let is_read = |topic: &&Topic| matches!(&topic.subject, Subject::Parameter { gauge, .. } if &**gauge == "chamber");
    assert_eq!(topics.len(), layout.topics().iter().filter(is_read).count());
    assert!(!topics.is_empty());
    times.publish(topics, &layout, &due);
    assert_eq!(times.due(&layout, &due).count(), 0);
    // A clock that was set back.
    let back = read_at(10);
    assert!(times.due(&layout, &back).count() > 0);
}

#[test]
fn a_gauge_that_does_not_measure_has_no_pressure() {
    let messages = all(&snapshot(None));
    let state = object(&messages, "profivac/target-hall/chamber/state");
    assert_eq!((&state["pressure"], &state["quality"]), (&Value::Null, &json!("off")));
    let pressure = &messages["profivac/target-hall/chamber/pressure"];
    assert!(pressure.payload.is_empty() && pressure.is_retained, "the broker forgets the last pressure");
}

/// No quality is beside the number in the topic of the pressure.
#[test]
fn the_end_of_the_range_is_beside_its_quality_and_never_alone() {
    for (quality, word) in [(Quality::Underrange, "underrange"), (Quality::Overrange, "overrange")] {
        let mut inputs = measuring(None, Micros(1));
        let reading = &mut inputs.gauges[0].readings[0];
        (reading.quality, reading.limit_pa) = (quality, Some(5e-8));
        let messages = all(&Modeller::default().next(inputs, Micros(0)));
        let state = object(&messages, "profivac/target-hall/chamber/state");
        assert_eq!(
            (&state["pressure"], &state["quality"], &state["usable"]),
            (&json!(5e-8), &json!(word), &json!(false))
        );
        assert!(messages["profivac/target-hall/chamber/pressure"].payload.is_empty(), "{word}");
    }
}

#[test]
fn every_point_is_in_one_topic() {
    let snapshot = snapshot(Some(1.0));
    let layout = Layout::new("p", &snapshot.points);
    let positions: Vec<usize> = layout.topics().iter().flat_map(|topic| topic.positions.clone()).collect();
    assert_eq!(positions, (0..snapshot.points.len()).collect::<Vec<_>>());
    let topics: BTreeSet<_> = layout.topics().iter().map(|topic| &topic.object).collect();
    assert_eq!(topics.len(), layout.len());
}

#[test]
fn a_gauge_that_leaves_the_file_leaves_nothing_at_the_broker() {
    let before = Layout::new("p", &snapshot(Some(1.0)).points);
    let mut inputs = measuring(Some(1.0), Micros(1));
    inputs.gauges.truncate(1);
    let after = Layout::new("p", &Modeller::default().next(inputs, Micros(0)).points);
    let gone = before.obsolete(&after);
    assert!(gone.iter().all(|message| message.payload.is_empty() && message.is_retained));
    assert!(gone.iter().all(|message| message.topic.starts_with("p/fore line/")) && gone.len() > 4);
}

/// A gauge that is renamed or removed is no sensor of Home Assistant any more.
#[test]
fn the_descriptions_of_a_gauge_that_leaves_the_file_are_taken_back() {
    let described = |inputs| described(&Modeller::default().next(inputs, Micros(0)), false);
    let mut fewer = measuring(Some(1.0), Micros(1));
    fewer.gauges.truncate(1);
    let (before, after) = (described(measuring(Some(1.0), Micros(1))), described(fewer));
    let gone = discovery::obsolete(&before, &after);
    assert_eq!(gone.len(), before.len() - after.len());
    assert!(!gone.is_empty() && gone.iter().all(|message| message.payload.is_empty() && message.is_retained));
    assert!(gone.iter().all(|gone| !after.iter().any(|kept| kept.topic == gone.topic)));
    assert!(discovery::obsolete(&before, &before).is_empty());
}

#[test]
fn the_status_of_an_ended_gateway_is_offline() {
    let will = status("p", false);
    assert_eq!((will.topic.as_str(), &will.payload[..], will.is_retained), ("p/status", &b"offline"[..], true));
}

/// The descriptions for Home Assistant.
fn described(snapshot: &Snapshot, has_object_id: bool) -> Vec<Message> {
    let prefix = "profivac/target-hall";
    let settings = Discovery { prefix: "homeassistant".to_owned(), has_object_id };
    let layout = Layout::new(prefix, &snapshot.points);
    discovery::sensors(&settings, prefix, "Target hall", &layout, &snapshot.points, &snapshot.values)
}

/// Home Assistant warns about `object_id` since 2025.10; before, it does not know `default_entity_id`.
#[test]
fn the_name_of_an_entity_has_one_of_two_keys() {
    let snapshot = snapshot(Some(1.0));
    for (has_object_id, key, other) in
        [(false, "default_entity_id", "object_id"), (true, "object_id", "default_entity_id")]
    {
        for message in described(&snapshot, has_object_id) {
            let description: Value = serde_json::from_slice(&message.payload).unwrap();
            assert!(description[key].is_string() && description[other].is_null(), "{description}");
        }
    }
}

/// Statistics must not take the end of the range for a measured value, and the quality says why there is none.
#[test]
fn a_number_of_home_assistant_needs_a_measured_pressure_and_the_quality_is_an_attribute() {
    for message in described(&snapshot(Some(1.0)), false) {
        let description: Value = serde_json::from_slice(&message.payload).unwrap();
        let template = description["value_template"].as_str().unwrap();
        let is_number = !description["state_class"].is_null();
        assert_eq!(template.contains("if value_json.usable else none"), is_number, "{template}");
        assert_eq!(description["json_attributes_topic"], description["state_topic"]);
        let attributes = description["json_attributes_template"].as_str().unwrap();
        assert!(attributes.contains("'quality': value_json.quality"), "{attributes}");
        assert!(attributes.contains("'limit_pa': none if value_json.usable else value_json.pressure"), "{attributes}");
        assert!(attributes.contains("'text': none if value_json.usable else value_json.state_text"), "{attributes}");
        assert_eq!(description["availability"].as_array().unwrap().len(), if is_number { 2 } else { 1 });
    }
}

#[test]
fn home_assistant_gets_pressure_logarithm_and_state_of_each_reading() {
    let snapshot = snapshot(Some(1.0));
    let sensors = described(&snapshot, false);
    assert_eq!(sensors.len(), 3 * 5);
    let find = |topic: &str| {
        let found = sensors.iter().find(|message| message.topic == topic).unwrap_or_else(|| panic!("no {topic}"));
        serde_json::from_slice::<Value>(&found.payload).unwrap()
    };
    let pressure = find("homeassistant/sensor/target_hall_chamber/pressure/config");
    assert_eq!(pressure["state_topic"], "profivac/target-hall/chamber/state");
    assert_eq!((&pressure["unit_of_measurement"], &pressure["device_class"]), (&json!("Pa"), &json!("pressure")));
    assert_eq!((&pressure["state_class"], &pressure["expire_after"]), (&json!("measurement"), &json!(60)));
    assert_eq!(pressure["default_entity_id"], "sensor.target_hall_chamber_pressure");
    assert_eq!(pressure["origin"]["name"], "profivac");
    // BCG450 measures from 5e-8 Pa: two digits there. A controller has gauges of unknown ranges.
    assert_eq!(pressure["suggested_display_precision"], 9);
    let channel = find("homeassistant/sensor/target_hall_fore__line_2E1/pressure/config");
    assert_eq!(channel["suggested_display_precision"], 10);
    assert_eq!(channel["default_entity_id"], "sensor.target_hall_fore_line_2e1_pressure");
    assert_eq!(pressure["availability"][0]["topic"], "profivac/target-hall/status");
    let logarithm = find("homeassistant/sensor/target_hall_chamber/pressure_log10/config");
    assert_eq!(logarithm["unit_of_measurement"], Value::Null);
    assert_eq!(logarithm["suggested_display_precision"], 2);
    let state = find("homeassistant/sensor/target_hall_chamber/state/config");
    assert_eq!((&state["state_class"], &state["suggested_display_precision"]), (&Value::Null, &Value::Null));
    assert_eq!(pressure["device"]["identifiers"], logarithm["device"]["identifiers"]);
    let ids: BTreeSet<_> = sensors.iter().map(object_id).collect();
    assert_eq!(ids.len(), sensors.len());
}

/// Home Assistant records each new state: the words of a measured pressure would be a new one with each reading.
#[test]
fn the_state_in_home_assistant_is_one_of_the_words_of_the_states() {
    let snapshot = snapshot(Some(1.0));
    for message in described(&snapshot, false).iter().filter(|message| message.topic.ends_with("/state/config")) {
        let description: Value = serde_json::from_slice(&message.payload).unwrap();
        assert_eq!(description["value_template"], "{{ value_json.state }}");
        assert_eq!(
            (&description["device_class"], &description["options"]),
            (&json!("enum"), &json!(State::READING_LABELS))
        );
    }
    let state = object(&all(&snapshot), "profivac/target-hall/chamber/state")["state"].clone();
    assert_eq!(state, "OK");
}

/// The name of the gauge is that of the device in Home Assistant already.
#[test]
fn the_model_in_home_assistant_is_the_device_and_says_whether_it_is_virtual() {
    let models = |port: &str| -> BTreeSet<String> {
        let config = profivac_config::parse(&FILE.replace("sim:hall.toml", port), Path::new("plant.toml")).unwrap();
        let snapshot = Modeller::default().next(Inputs::planned(&config), Micros(0));
        let described = described(&snapshot, false);
        let model = |message: &Message| {
            serde_json::from_slice::<Value>(&message.payload).unwrap()["device"]["model"].as_str().unwrap().to_owned()
        };
        described.iter().map(model).collect()
    };
    assert_eq!(models("/dev/ttyUSB0"), BTreeSet::from(["bcg450".to_owned(), "tpg300".to_owned()]));
    assert_eq!(models("sim:hall.toml"), BTreeSet::from(["virtual bcg450".to_owned(), "virtual tpg300".to_owned()]));
}

/// A gauge that is sampled every ten minutes is published every ten minutes, and its station shows it as stale after five of them.
#[test]
fn a_sensor_of_a_gauge_that_is_sampled_seldom_stays_until_its_reading_is_stale() {
    for (poll, expire_after_s) in [("200 ms", 60), ("8 s", 60), ("9 s", 65), ("10 min", 3020), ("1 h", 18_020)] {
        let file = FILE.replace("device = \"bcg450\"", &format!("device = \"bcg450\"\npoll = \"{poll}\""));
        let config = profivac_config::parse(&file, Path::new("plant.toml")).unwrap();
        let snapshot = Modeller::default().next(Inputs::planned(&config), Micros(0));
        let sensors = described(&snapshot, false);
        let (chamber, others): (Vec<_>, Vec<_>) = sensors.iter().partition(|it| it.topic.contains("_chamber/"));
        assert_eq!((chamber.len(), others.len()), (3, 3 * 4));
        for (sensors, expected) in [(chamber, expire_after_s), (others, 60)] {
            for sensor in sensors {
                let description: Value = serde_json::from_slice(&sensor.payload).unwrap();
                assert_eq!(description["expire_after"], json!(expected), "{poll} {}", sensor.topic);
            }
        }
    }
}

/// Sensors are described again when the file gives a gauge another interval.
#[test]
fn another_interval_of_a_gauge_changes_the_points() {
    let mut modeller = Modeller::default();
    let before = modeller.next(measuring(Some(1.0), Micros(1)), Micros(1));
    let mut inputs = measuring(Some(1.0), Micros(2));
    inputs.gauges[0].stale_after_ms = 3_000_000;
    assert!(!modeller.next(inputs, Micros(2)).has_points_of(&before));
}

/// The manufacturer of a real gauge is not this program.
#[test]
fn only_virtual_gauges_have_a_manufacturer() {
    let manufacturers = |port: &str| {
        let config = profivac_config::parse(&FILE.replace("sim:hall.toml", port), Path::new("plant.toml")).unwrap();
        let snapshot = Modeller::default().next(Inputs::planned(&config), Micros(0));
        let sensors = described(&snapshot, false);
        let manufacturer = |message: &Message| {
            serde_json::from_slice::<Value>(&message.payload).unwrap()["device"]["manufacturer"].clone()
        };
        sensors.iter().map(manufacturer).collect::<Vec<_>>()
    };
    assert_eq!(manufacturers("sim:hall.toml"), vec![json!("profivac"); 3 * 5]);
    assert_eq!(manufacturers("/dev/ttyUSB0"), vec![Value::Null; 3 * 5]);
}

fn object_id(message: &Message) -> String {
    let description: Value = serde_json::from_slice(&message.payload).unwrap();
    description["unique_id"].as_str().unwrap().to_owned()
}

#[test]
fn counters_are_published_every_ten_seconds_and_pressures_at_once() {
    let mut modeller = Modeller::default();
    let first = Arc::new(modeller.next(measuring(Some(1.0), Micros(1)), Micros(1)));
    let mut tracker = Tracker::new(Arc::clone(&first), Micros(0));
    let signals = |snapshot: &Snapshot, positions: &[usize]| -> BTreeSet<Signal> {
        positions.iter().map(|position| snapshot.points[*position].signal).collect()
    };
    let second = Arc::new(modeller.next(measuring(Some(1.0), Micros(2)), Micros(2)));
    assert_eq!(tracker.next(&second, Micros(1)).positions, [0_usize; 0], "the time of the reading waits");
    let third = Arc::new(modeller.next(measuring(Some(2.0), Micros(3)), Micros(3)));
    let changes = tracker.next(&third, Micros(2));
    let found = signals(&third, &changes.positions);
    assert!(found.contains(&Signal::Pressure) && !found.contains(&Signal::LastReading), "{found:?}");
    let changes = tracker.next(&third, Micros(0).after(COUNTER_PERIOD));
    assert_eq!(signals(&third, &changes.positions), BTreeSet::from([Signal::LastReading]));
}

/// A station without anything new: its lines go on, its recorder writes, its time passes.
#[test]
fn a_station_whose_pressures_stay_publishes_nothing_between_the_counters() {
    let counted = |number: u64| {
        let mut inputs = measuring(Some(1.0), Micros(1));
        inputs.station.now_ms = 1000 * i64::try_from(number).unwrap();
        let RecorderView { last_write_ms, lost_samples, lost_events, .. } = &mut inputs.station.recorder;
        (*last_write_ms, *lost_samples, *lost_events) = (Some(inputs.station.now_ms), number, number);
        inputs.segments[0].cycle_ms = Some(number as f64);
        inputs.gauges[0].read_at = Some(Micros(1_000_000 * i64::try_from(number).unwrap()));
        inputs.buses.insert("hall".to_owned(), Arc::new(line(number)));
        inputs
    };
    let mut modeller = Modeller::default();
    let first = Arc::new(modeller.next(counted(1), Micros(1)));
    let mut tracker = Tracker::new(Arc::clone(&first), Micros(0));
    let second = Arc::new(modeller.next(counted(2), Micros(2)));
    let waiting = second.changes_since(&first).count();
    let signals = |positions: &[usize]| -> Vec<_> { positions.iter().map(|it| second.points[*it].signal).collect() };
    assert_eq!(signals(&tracker.next(&second, Micros(1)).positions), []);
    let due = tracker.next(&second, Micros(0).after(COUNTER_PERIOD)).positions;
    assert_eq!(due.len(), waiting, "each counter once: {:?}", signals(&due));
    assert!(waiting > 20, "the counters of station, segment and gauge: {:?}", signals(&due));
}

/// A line whose counters and times have this value.
fn line(number: u64) -> BusReport {
    let times = Distribution { mean_us: Some(number), max_us: Some(number), ..Distribution::default() };
    let total = Counts {
        requests: number,
        lost: number,
        repeated: number,
        damaged: number,
        refused: number,
        ..Counts::default()
    };
    let station = StationReport {
        address: 5,
        state: StationState::Exchanging,
        devices: Vec::new(),
        ident: None,
        owner: None,
        configuration_origin: None,
        unit: None,
        unit_origin: None,
        total,
        last_minute: Counts::default(),
        repeated_percent: 0.0,
        longest_sequence: u32::try_from(number).unwrap(),
        diagnosis: Vec::new(),
        diagnosis_history: Vec::new(),
        interval: Distribution::default(),
        unknown: Vec::new(),
    };
    BusReport {
        baud: 19_200,
        observed_ms: 1000 * number,
        telegrams: number,
        octets: number,
        damaged: number,
        damaged_last_minute: number,
        damaged_unattributed: 0,
        recorder_octets: 0,
        ring: Vec::new(),
        cycle: times.clone(),
        rotation: times,
        masters: Vec::new(),
        stations: vec![station],
        parameters: Vec::new(),
        events: Vec::new(),
    }
}

#[test]
fn the_table_of_names_has_all_topics_and_metrics() {
    let config = config();
    let [GatewaySettings::Mqtt(settings)] = &config.gateways[..] else { panic!("one gateway") };
    let points = snapshot(Some(1.0)).points;
    let table = names(settings, &config.name, &points);
    let rows: BTreeSet<(&str, &str)> = table.rows().iter().map(|row| (row[0].as_str(), row[1].as_str())).collect();
    assert_eq!(rows.len(), table.rows().len(), "no name twice");
    for row in [
        ("profivac/target-hall/chamber/state", "pressure_log10"),
        ("profivac/target-hall/status", ""),
        ("homeassistant/sensor/target_hall_chamber/pressure/config", ""),
        ("spBv1.0/G/DDATA/Target hall/chamber", "Pressure"),
        ("spBv1.0/G/NDATA/Target hall", "Segments/hall/Up"),
    ] {
        assert!(rows.contains(&row), "{row:?}");
    }
}
