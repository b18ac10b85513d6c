//! Topics and their contents.
//!
//! | Topic below the prefix | Content |
//! |---|---|
//! | `status` | `online` or `offline`, retained; `offline` is the will |
//! | `station` | the signals of the station |
//! | `segment/NAME` | those of a segment |
//! | `alarm/NAME` | those of an alarm |
//! | `GAUGE/gauge` | those of a gauge |
//! | `GAUGE/parameter/BLOCK/PARAMETER` | those of a parameter: trip point, relay, emission, with name, unit, limits, state and time |
//! | `GAUGE/state`, `GAUGE/CHANNEL/state` | those of a reading, with unit, range, limits, quality and time |
//! | `GAUGE/pressure`, `GAUGE/CHANNEL/pressure` | the measured pressure in Pa, empty while none is measured |

use crate::message::{Delivery, Message};
use crate::topic::{gauge_level, level, levels};
use jiff::Timestamp;
use profivac_gateway::{Kind, Limits, Point, PointValue, Signal, Snapshot, Subject, Value};
use profivac_recorder::Micros;
use profivac_recorder::export::seven_digits;
use serde_json::{Map, Value as Json, json};

/// The topics of the points.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    topics: Vec<Topic>,
    /// The topic of each point.
    of_point: Vec<usize>,
}

/// The topic of a subject.
#[derive(Clone, Debug, PartialEq)]
pub struct Topic {
    /// The subject.
    pub subject: Subject,
    /// The topic of its JSON object.
    pub object: String,
    /// The topic of its pressure, if it is a reading.
    pub pressure: Option<String>,
    /// The positions of its points.
    pub positions: Vec<usize>,
    /// The device model is virtual.
    pub is_simulated: bool,
}

impl Layout {
    /// The topics of these points below a prefix.
    #[must_use]
    pub fn new(prefix: &str, points: &[Point]) -> Self {
        let mut layout = Self { topics: Vec::new(), of_point: Vec::new() };
        for (position, point) in points.iter().enumerate() {
            if layout.topics.last().is_none_or(|last| last.subject != point.subject) {
                layout.topics.push(topic(prefix, point));
            }
            layout.of_point.push(layout.topics.len().saturating_sub(1));
            if let Some(last) = layout.topics.last_mut() {
                last.positions.push(position);
            }
        }
        layout
    }

    /// The number of topics with a JSON object.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.topics.len()
    }

    /// Whether there is no topic.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.topics.is_empty()
    }

    /// All topics.
    #[must_use]
    pub fn topics(&self) -> &[Topic] {
        &self.topics
    }

    /// The topic of a point.
    #[must_use]
    pub fn topic_of(&self, position: usize) -> Option<usize> {
        self.of_point.get(position).copied()
    }

    /// The messages of a topic: its object, and the pressure of a reading.
    #[must_use]
    pub fn messages(&self, topic: usize, snapshot: &Snapshot) -> Vec<Message> {
        let Some(topic) = self.topics.get(topic) else { return Vec::new() };
        let of_topic = topic.positions.iter().filter_map(|it| snapshot.points.get(*it).zip(snapshot.values.get(*it)));
        let values: Vec<_> = of_topic.collect();
        let object = retained(topic.object.clone(), object(&values).to_string(), Delivery::AtLeastOnce);
        let pressure = topic.pressure.clone().map(|name| {
            let found = values.iter().find(|(point, _)| point.signal == Signal::Pressure);
            // No quality is beside this number, so it is never the end of the range.
            let text = found.and_then(|(_, value)| value.measured()).map(|pa| format!("{:e}", seven_digits(pa)));
            retained(name, text.unwrap_or_default(), Delivery::AtMostOnce)
        });
        std::iter::once(object).chain(pressure).collect()
    }

    /// Empty messages for the topics that `new` does not have.
    #[must_use]
    pub fn obsolete(&self, new: &Self) -> Vec<Message> {
        let is_gone = |topic: &&Topic| !new.topics.iter().any(|other| other.object == topic.object);
        let gone = self.topics.iter().filter(is_gone);
        let names = gone.flat_map(|topic| std::iter::once(topic.object.clone()).chain(topic.pressure.clone()));
        names.map(|name| retained(name, String::new(), Delivery::AtLeastOnce)).collect()
    }
}

/// The topic that says whether the station is connected.
#[must_use]
pub fn status_topic(prefix: &str) -> String {
    format!("{prefix}/status")
}

/// The message on it.
#[must_use]
pub fn status(prefix: &str, is_online: bool) -> Message {
    let text = if is_online { "online" } else { "offline" };
    retained(status_topic(prefix), text.to_owned(), Delivery::AtLeastOnce)
}

/// A message that the broker keeps.
pub(super) fn retained(topic: String, text: String, delivery: Delivery) -> Message {
    Message { topic, payload: text.into_bytes(), delivery, is_retained: true }
}

fn topic(prefix: &str, point: &Point) -> Topic {
    let (object, pressure) = match &point.subject {
        Subject::Station => (format!("{prefix}/station"), None),
        Subject::Segment(name) => (format!("{prefix}/segment/{}", level(name)), None),
        Subject::Alarm(name) => (format!("{prefix}/alarm/{}", level(name)), None),
        Subject::Gauge(name) => (format!("{prefix}/{}/gauge", gauge_level(name)), None),
        Subject::Reading { gauge, channel, .. } => {
            let channel = channel.map(|channel| format!("/{channel}")).unwrap_or_default();
            let reading = format!("{prefix}/{}{channel}", gauge_level(gauge));
            (format!("{reading}/state"), Some(format!("{reading}/pressure")))
        }
        Subject::Parameter { gauge, target, .. } => {
            (format!("{prefix}/{}/parameter/{}", gauge_level(gauge), levels(target)), None)
        }
    };
    Topic { subject: point.subject.clone(), object, pressure, positions: Vec::new(), is_simulated: point.is_simulated }
}

/// The key of a signal in a JSON object; a template of Home Assistant cannot name a key with `-` simply.
#[must_use]
pub fn key(signal: Signal) -> String {
    let key = signal.key();
    key.strip_prefix("parameter-").unwrap_or(key).replace('-', "_")
}

/// The points of one subject as a JSON object.
fn object(values: &[(&Point, &PointValue)]) -> Json {
    let mut object = Map::new();
    for (point, value) in values {
        if let Subject::Parameter { name, .. } = &point.subject {
            object.insert("name".to_owned(), json!(**name));
            object.insert("state".to_owned(), json!(value.state.label()));
            if point.signal != Signal::ParameterText {
                object.insert("unit".to_owned(), json!(point.unit));
                object.insert("limits".to_owned(), limits(point.limits));
            }
            object.insert("time".to_owned(), value.at.map_or(Json::Null, time));
        }
        if point.signal == Signal::Pressure {
            object.insert("unit".to_owned(), json!(point.unit));
            object.insert("time".to_owned(), value.at.map_or(Json::Null, time));
            object.insert("simulated".to_owned(), json!(point.is_simulated));
            object.insert("range".to_owned(), json!(point.range.map(|(low, high)| [low, high])));
            object.insert("limits".to_owned(), limits(point.limits));
        }
        object.insert(key(point.signal), json_of(point.signal, &value.value));
    }
    Json::Object(object)
}

fn limits(limits: Limits) -> Json {
    let Limits { high_high, high, low, low_low } = limits;
    json!({ "high_high": high_high, "high": high, "low": low, "low_low": low_low })
}

fn json_of(signal: Signal, value: &Value) -> Json {
    match (value, signal.kind()) {
        (Value::None, _) => Json::Null,
        (Value::Float(number), _) if signal == Signal::ParameterNumber => json!(parameter(*number)),
        (Value::Float(number), _) => json!(seven_digits(*number)),
        (Value::Integer(number), _) => json!(number),
        (Value::Boolean(value), _) => json!(value),
        (Value::Text(text), _) => json!(**text),
        (Value::Choice(number), Kind::Choice(words)) => json!(words.get(usize::from(*number))),
        (Value::Choice(number), _) => json!(number),
        (Value::Time(at), _) => time(*at),
    }
}

/// The number of a parameter. A point of a slave has up to twelve digits, all of them right; more digits come from the conversion of a
/// float.
fn parameter(number: f64) -> f64 {
    let has_twelve_digits = format!("{number:.11e}").parse() == Ok(number);
    if has_twelve_digits { number } else { seven_digits(number) }
}

/// A time as RFC 3339 in UTC.
fn time(at: Micros) -> Json {
    json!(Timestamp::from_microsecond(at.0).unwrap_or_default().to_string())
}
