//! Sensors for Home Assistant: retained descriptions of the readings, from which it makes its entities.

use super::layout::{Layout, Topic, retained, status_topic};
use crate::message::{Delivery, Message};
use crate::topic::{identifier, slug};
use profivac_gateway::{Kind, Point, PointValue, Signal, State, Subject, Value};
use profivac_station::config::gateways::mqtt::Discovery;
use serde_json::{Value as Json, json};
use std::collections::{BTreeMap, BTreeSet};

/// The shortest time after which a reading that is not published again is unavailable, in seconds: six times the period in which the time
/// of the reading is published.
const EXPIRE_AFTER_S: u64 = 60;

/// Two of these periods, in seconds: a reading that is stale was published by then.
const PUBLISHED_WITHIN_S: u64 = 20;

/// Where Home Assistant publishes `online` after its start.
#[must_use]
pub fn birth_topic(discovery: &str) -> String {
    format!("{discovery}/status")
}

/// A sensor of a reading.
struct Sensor {
    /// The last part of its identifier and its topic.
    key: &'static str,
    name: &'static str,
    /// What it shows.
    signal: Signal,
    /// Unit and device class, if it has them.
    unit: Option<&'static str>,
    class: Option<&'static str>,
    template: &'static str,
}

/// Home Assistant rounds small numbers to 0 in its cards, so the logarithm is a sensor of its own. Beyond its range a gauge measures
/// nothing: its numbers are unknown there, so that no statistics take the end of the range for a value.
const SENSORS: [Sensor; 3] = [
    Sensor {
        key: "pressure",
        name: "Pressure",
        signal: Signal::Pressure,
        unit: Some("Pa"),
        class: Some("pressure"),
        template: "{{ value_json.pressure if value_json.usable else none }}",
    },
    Sensor {
        key: "pressure_log10",
        name: "Pressure log10",
        signal: Signal::PressureLog10,
        unit: None,
        class: None,
        template: "{{ value_json.pressure_log10 if value_json.usable else none }}",
    },
    Sensor {
        key: "state",
        name: "State",
        signal: Signal::State,
        unit: None,
        class: Some("enum"),
        template: "{{ value_json.state }}",
    },
];

/// The attributes of a sensor: why its number is unknown. They change seldom, because Home Assistant records each change; the text of a
/// measured pressure would change with each reading.
const ATTRIBUTES: &str = "{{ {'quality': value_json.quality, 'cause': value_json.cause, \
                          'text': none if value_json.usable else value_json.state_text, \
                          'limit_pa': none if value_json.usable else value_json.pressure} | tojson }}";

/// Numbers are unavailable while the gauge is not there; otherwise they have a value, or their quality says why not.
const AVAILABLE: &str = "{{ 'offline' if value_json.quality in ['missing', 'stale'] else 'online' }}";

/// The descriptions of all readings. The values name the devices; without them a description does not.
#[must_use]
pub fn sensors(
    discovery: &Discovery,
    prefix: &str,
    station: &str,
    layout: &Layout,
    points: &[Point],
    values: &[PointValue],
) -> Vec<Message> {
    let devices = devices(points, values);
    let readings = layout.topics().iter().filter(|topic| matches!(topic.subject, Subject::Reading { .. }));
    let mut messages = Vec::new();
    for topic in readings {
        let device = topic.subject.gauge().and_then(|gauge| devices.get(gauge)).copied();
        let of_reading =
            SENSORS.iter().map(|sensor| describe(sensor, topic, discovery, prefix, station, points, device));
        messages.extend(of_reading);
    }
    messages
}

/// The device of each gauge, by its name.
fn devices<'a>(points: &'a [Point], values: &'a [PointValue]) -> BTreeMap<&'a str, &'a str> {
    let all = points.iter().zip(values).filter(|(point, _)| point.signal == Signal::Device);
    let named = all.filter_map(|(point, value)| match &value.value {
        Value::Text(device) if !device.is_empty() => Some((point.subject.gauge()?, &**device)),
        _ => None,
    });
    named.collect()
}

/// Empty messages for the descriptions in `old` that are not in `new`.
#[must_use]
pub fn obsolete(old: &[Message], new: &[Message]) -> Vec<Message> {
    let topics: BTreeSet<&str> = new.iter().map(|message| message.topic.as_str()).collect();
    let gone = old.iter().filter(|message| !topics.contains(message.topic.as_str()));
    gone.map(|message| Message { payload: Vec::new(), ..message.clone() }).collect()
}

fn describe(
    sensor: &Sensor,
    topic: &Topic,
    discovery: &Discovery,
    prefix: &str,
    station: &str,
    points: &[Point],
    device: Option<&str>,
) -> Message {
    let node = format!(
        "{}_{}",
        slug(station).replace(|it: char| !it.is_ascii_alphanumeric(), "_"),
        identifier(topic.subject.name())
    );
    let kind = if topic.is_simulated { "virtual " } else { "" };
    let mut description = json!({
        "name": sensor.name,
        "unique_id": format!("profivac_{node}_{}", sensor.key),
        "state_topic": topic.object,
        "value_template": sensor.template,
        "json_attributes_topic": topic.object,
        "json_attributes_template": ATTRIBUTES,
        "expire_after": expire_after_s(topic, points),
        "availability_mode": "all",
        "availability": availability(sensor, topic, prefix),
        "device": {
            "identifiers": [format!("profivac_{node}")],
            "name": format!("{station} {}", topic.subject.name()),
            "model": format!("{kind}{}", device.unwrap_or("vacuum gauge")),
            "sw_version": env!("CARGO_PKG_VERSION"),
        },
        "origin": { "name": "profivac", "sw_version": env!("CARGO_PKG_VERSION") },
    });
    let mut put = |key: &str, value: Json| {
        if let Some(object) = description.as_object_mut() {
            object.insert(key.to_owned(), value);
        }
    };
    // Home Assistant warns about `object_id` since 2025.10, and ignores it since 2026.4.
    let entity = format!("{}_{}", slug(&node).replace('-', "_"), sensor.key);
    match discovery.has_object_id {
        true => put("object_id", json!(entity)),
        false => put("default_entity_id", json!(format!("sensor.{entity}"))),
    }
    if sensor.signal.kind() == Kind::Float {
        put("state_class", json!("measurement"));
        put("suggested_display_precision", json!(decimals(sensor, topic, points)));
    }
    if sensor.class == Some("enum") {
        put("options", json!(State::READING_LABELS));
    }
    for (key, value) in [("unit_of_measurement", sensor.unit), ("device_class", sensor.class)] {
        if let Some(value) = value {
            put(key, json!(value));
        }
    }
    // The manufacturer of a real gauge is not this program; the topics of the gauge name the device.
    if let Some(device) = description.get_mut("device").and_then(Json::as_object_mut).filter(|_| topic.is_simulated) {
        device.insert("manufacturer".to_owned(), json!("profivac"));
    }
    let name = format!("{}/sensor/{node}/{}/config", discovery.prefix, sensor.key);
    retained(name, description.to_string(), Delivery::AtLeastOnce)
}

/// The time after which a reading that is not published again is unavailable, in seconds. A gauge that is sampled seldom is published
/// seldom: its reading stays until the station itself shows it as stale.
fn expire_after_s(topic: &Topic, points: &[Point]) -> u64 {
    let mut ages_ms = topic.positions.iter().filter_map(|position| points.get(*position)?.stale_after_ms);
    let stale_after_s = ages_ms.next().unwrap_or_default().div_ceil(1000);
    stale_after_s.saturating_add(PUBLISHED_WITHIN_S).max(EXPIRE_AFTER_S)
}

/// The decimals of a sensor's number in its unit. With fewer, Home Assistant shows and records a small pressure as 0 in another unit.
fn decimals(sensor: &Sensor, topic: &Topic, points: &[Point]) -> u8 {
    let mut own = topic.positions.iter().filter_map(|position| points.get(*position));
    own.find(|point| point.signal == sensor.signal).map_or(0, Point::decimals)
}

/// All sensors need the station; a number needs the gauge as well.
fn availability(sensor: &Sensor, topic: &Topic, prefix: &str) -> Json {
    let station = json!({ "topic": status_topic(prefix) });
    if sensor.signal.kind() != Kind::Float {
        return json!([station]);
    }
    json!([station, { "topic": topic.object, "value_template": AVAILABLE }])
}
