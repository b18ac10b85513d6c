//! Sensors for Home Assistant: retained descriptions of the readings, from which it makes its entities.

use super::layout::{Layout, Topic, retained, status_topic};
use crate::message::{Delivery, Message};
use crate::topic::{identifier, slug};
use profivac_gateway::Subject;
use serde_json::{Value as Json, json};

/// The time after which a reading that is not published again is unavailable, in seconds: six times the period in which the time of the
/// reading is published.
const EXPIRE_AFTER: u32 = 60;

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
    /// Unit and device class, if it has them.
    unit: Option<&'static str>,
    class: Option<&'static str>,
    /// `measurement` makes statistics.
    state_class: Option<&'static str>,
    template: &'static str,
}

/// Home Assistant rounds small numbers to 0 in its cards, so the logarithm is a sensor of its own.
const SENSORS: [Sensor; 3] = [
    Sensor {
        key: "pressure",
        name: "Pressure",
        unit: Some("Pa"),
        class: Some("pressure"),
        state_class: Some("measurement"),
        template: "{{ value_json.pressure }}",
    },
    Sensor {
        key: "pressure_log10",
        name: "Pressure log10",
        unit: None,
        class: None,
        state_class: Some("measurement"),
        template: "{{ value_json.pressure_log10 }}",
    },
    Sensor {
        key: "state",
        name: "State",
        unit: None,
        class: None,
        state_class: None,
        template: "{{ value_json.state_text }}",
    },
];

/// The descriptions of all readings.
#[must_use]
pub fn sensors(discovery: &str, prefix: &str, station: &str, layout: &Layout) -> Vec<Message> {
    let readings = layout.topics().iter().filter(|topic| matches!(topic.subject, Subject::Reading { .. }));
    readings
        .flat_map(|topic| SENSORS.iter().map(|sensor| describe(sensor, topic, discovery, prefix, station)))
        .collect()
}

fn describe(sensor: &Sensor, topic: &Topic, discovery: &str, prefix: &str, station: &str) -> Message {
    let node = format!(
        "{}_{}",
        slug(station).replace(|it: char| !it.is_ascii_alphanumeric(), "_"),
        identifier(topic.subject.name())
    );
    let gauge = topic.subject.gauge().unwrap_or_default();
    let model = if topic.is_simulated { "virtual vacuum gauge" } else { "vacuum gauge" };
    let mut description = json!({
        "name": sensor.name,
        "unique_id": format!("profivac_{node}_{}", sensor.key),
        "object_id": format!("{node}_{}", sensor.key),
        "state_topic": topic.object,
        "value_template": sensor.template,
        "expire_after": EXPIRE_AFTER,
        "availability_mode": "all",
        "availability": availability(sensor, topic, prefix),
        "device": {
            "identifiers": [format!("profivac_{node}")],
            "name": format!("{station} {}", topic.subject.name()),
            "model": format!("{model} ({gauge})"),
            "sw_version": env!("CARGO_PKG_VERSION"),
        },
    });
    // The manufacturer of a real gauge is not this program; the topics of the gauge name the device.
    if let Some(device) = description.get_mut("device").and_then(Json::as_object_mut).filter(|_| topic.is_simulated) {
        device.insert("manufacturer".to_owned(), json!("profivac"));
    }
    for (key, value) in
        [("unit_of_measurement", sensor.unit), ("device_class", sensor.class), ("state_class", sensor.state_class)]
    {
        if let (Some(value), Some(object)) = (value, description.as_object_mut()) {
            object.insert(key.to_owned(), json!(value));
        }
    }
    let name = format!("{discovery}/sensor/{node}/{}/config", sensor.key);
    retained(name, description.to_string(), Delivery::AtLeastOnce)
}

/// All sensors need the station; a number needs a pressure as well.
fn availability(sensor: &Sensor, topic: &Topic, prefix: &str) -> Json {
    let station = json!({ "topic": status_topic(prefix) });
    if sensor.state_class.is_none() {
        return json!([station]);
    }
    let template = "{{ 'online' if value_json.pressure is not none else 'offline' }}";
    json!([station, { "topic": topic.object, "value_template": template }])
}
