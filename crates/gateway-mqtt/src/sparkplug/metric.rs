//! Points as metrics.

use super::backlog::Recorded;
use super::payload::{Metric, MetricValue, Property, PropertySet, datatype};
use crate::topic::{level, levels};
use profivac_gateway::names::capitalized;
use profivac_gateway::{Kind, Point, PointValue, Signal, State, Subject, Value};
use profivac_recorder::{Micros, PointSample, Sample};
use profivac_station::config::gateways::mqtt::DataStyle;

/// The property that says whether a value can be used.
const QUALITY: &str = "Quality";

/// `Quality`: the value must not be used.
const BAD: i32 = 0;

/// `Quality`: the value can be used.
const GOOD: i32 = 192;

/// A time in milliseconds since 1970.
#[must_use]
pub fn milliseconds(at: Micros) -> u64 {
    u64::try_from(at.0.div_euclid(1000)).unwrap_or_default()
}

/// The alias of a point: its position, counted from 1 (tck-id-payloads-alias-uniqueness: unique over the edge node and its devices).
#[must_use]
pub const fn alias(position: usize) -> u64 {
    (position as u64).saturating_add(1)
}

/// The name of a point as a metric of its device or of the edge node.
#[must_use]
pub fn name(point: &Point) -> String {
    let signal = match point.signal {
        Signal::AlarmPriority => "Alarm/Priority".to_owned(),
        Signal::Unacknowledged => "Alarm/Unacknowledged".to_owned(),
        other => capitalized(other.key().strip_prefix(prefix(&point.subject)).unwrap_or(other.key())),
    };
    match &point.subject {
        Subject::Station | Subject::Gauge(_) | Subject::Reading { channel: None, .. } => signal,
        Subject::Reading { channel: Some(channel), .. } => format!("{channel}/{signal}"),
        Subject::Parameter { target, .. } => format!("Parameters/{}/{signal}", levels(target)),
        Subject::Segment(name) => format!("Segments/{}/{signal}", level(name)),
        Subject::Alarm(name) => format!("Alarms/{}/{signal}", level(name)),
    }
}

/// The first word of a key that the name of the subject says already.
const fn prefix(subject: &Subject) -> &'static str {
    match subject {
        Subject::Segment(_) => "segment-",
        Subject::Alarm(_) => "alarm-",
        Subject::Parameter { .. } => "parameter-",
        Subject::Station | Subject::Gauge(_) | Subject::Reading { .. } => "",
    }
}

/// What a metric says. A pressure that is not measured is null, so the end of the range is never its value.
#[must_use]
pub const fn description(signal: Signal) -> &'static str {
    match signal {
        Signal::Pressure => "Indicated pressure; null while it is not measured",
        other => other.description(),
    }
}

/// The data type of a signal.
#[must_use]
pub const fn datatype_of(signal: Signal) -> u32 {
    match signal.kind() {
        Kind::Float => datatype::FLOAT,
        Kind::Integer => datatype::INT64,
        Kind::Boolean => datatype::BOOLEAN,
        Kind::Text => datatype::STRING,
        Kind::Choice(_) => datatype::INT32,
        Kind::Time => datatype::DATE_TIME,
    }
}

/// What identifies a metric in data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Identity {
    /// Name and data type: Sparkplug 3.0 recommends to leave the data type out (tck-id-payloads-metric-datatype-not-req), but hosts that do
    /// not keep births read nothing then.
    Name(String, u32),
    /// The alias of its birth alone (tck-id-payloads-alias-data-cmd-requirement).
    Alias(u64),
}

impl Identity {
    /// The identity of a point.
    #[must_use]
    pub fn of(style: DataStyle, position: usize, point: &Point) -> Self {
        match style {
            DataStyle::Names => Self::Name(name(point), datatype_of(point.signal)),
            DataStyle::Aliases => Self::Alias(alias(position)),
        }
    }
}

/// The metric of a birth: name, alias if data has aliases, data type, present value, unit, range and the rest.
#[must_use]
pub fn birth(identity: Identity, point: &Point, value: &PointValue, now: Micros) -> Metric {
    let mut metric = data(identity, point, value, now);
    metric.name = Some(name(point));
    metric.datatype = Some(datatype_of(point.signal));
    let properties = metric.properties.get_or_insert_default();
    let mut text = |key, text: &str| properties.push(key, Property::String(text.to_owned()));
    match &point.subject {
        Subject::Parameter { name, .. } => text("documentation", name),
        _ => text("documentation", description(point.signal)),
    }
    if let Some(unit) = point.unit {
        text("engUnit", unit);
    }
    if let Kind::Choice(words) = point.signal.kind() {
        text("words", &words.join(","));
    }
    if point.is_simulated {
        properties.push("simulated", Property::Boolean(true));
    }
    let range = point.range.map(|(low, high)| [("engLow", low), ("engHigh", high)]).into_iter().flatten();
    let limits = [
        ("limitHighHigh", point.limits.high_high),
        ("limitHigh", point.limits.high),
        ("limitLow", point.limits.low),
        ("limitLowLow", point.limits.low_low),
    ];
    let limits = limits.into_iter().filter_map(|(key, limit)| limit.map(|limit| (key, limit)));
    for (key, pa) in range.chain(limits) {
        properties.push(key, Property::Double(pa));
    }
    metric
}

/// The metric of data: identity, value, time and quality. The end of the range is no value: hosts that do not look at `Quality` would take
/// it for a pressure.
#[must_use]
pub fn data(identity: Identity, point: &Point, value: &PointValue, now: Micros) -> Metric {
    let number = if value.is_bound() { None } else { metric_value(&value.value) };
    let quality = quality(point.signal, value.state, number.is_some());
    metric(identity, value.at.unwrap_or(now), number, quality)
}

/// The metric of a value in the past: the same with `is_historical`.
#[must_use]
pub fn historical(identity: Identity, at: Micros, value: Option<MetricValue>, quality: i32) -> Metric {
    Metric { is_historical: Some(true), ..metric(identity, at, value, quality) }
}

/// A null value has no number (tck-id-operational-behavior-data-publish-dbirth-values).
fn metric(identity: Identity, at: Micros, value: Option<MetricValue>, quality: i32) -> Metric {
    let mut properties = PropertySet::default();
    properties.push(QUALITY, Property::Int(quality.cast_unsigned()));
    let (name, datatype, alias) = match identity {
        Identity::Name(name, datatype) => (Some(name), Some(datatype), None),
        Identity::Alias(alias) => (None, None, Some(alias)),
    };
    Metric {
        name,
        alias,
        timestamp: Some(milliseconds(at)),
        datatype,
        is_historical: None,
        is_null: value.is_none().then_some(true),
        properties: Some(properties),
        value,
    }
}

/// The property `Quality`: 0, 192 or 500 (tck-id-payloads-propertyset-quality-value-value). State, text, quality, cause and time of a
/// reading are good also when they say that there is no pressure.
#[must_use]
pub const fn quality(signal: Signal, state: State, has_value: bool) -> i32 {
    match (signal, state.codes().sparkplug) {
        (
            Signal::State | Signal::StateText | Signal::Usable | Signal::Quality | Signal::Cause | Signal::LastReading,
            _,
        ) if has_value => GOOD,
        (_, GOOD) if !has_value => BAD,
        (_, of_state) => of_state,
    }
}

/// A pressure has six significant digits at most, so 32 bits hold it.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a smaller number is zero, a larger one infinite, and no pressure is that"
)]
fn metric_value(value: &Value) -> Option<MetricValue> {
    Some(match value {
        Value::None => return None,
        Value::Float(number) => MetricValue::Float(*number as f32),
        Value::Integer(number) => MetricValue::Long(number.cast_unsigned()),
        Value::Boolean(value) => MetricValue::Boolean(*value),
        Value::Text(text) => MetricValue::String((**text).to_owned()),
        Value::Choice(number) => MetricValue::Int((*number).into()),
        Value::Time(at) => MetricValue::Long(milliseconds(*at)),
    })
}

/// The value and the quality of a signal in a recorded sample; `None` for signals that are not recorded.
#[must_use]
pub fn of_recorded(signal: Signal, sample: &Recorded) -> Option<(Option<MetricValue>, i32)> {
    match sample {
        Recorded::Pressure(sample) => of_sample(signal, sample),
        Recorded::Point(sample) => Some(of_point_sample(signal, sample)),
    }
}

/// The number of a point of a slave. Its text is not recorded.
fn of_point_sample(signal: Signal, sample: &PointSample) -> (Option<MetricValue>, i32) {
    let value = metric_value(&sample.number.map_or(Value::None, Value::Float));
    let quality = quality(signal, State::recorded(sample.quality), value.is_some());
    (value, quality)
}

fn of_sample(signal: Signal, sample: &Sample) -> Option<(Option<MetricValue>, i32)> {
    let state = State::recorded(sample.quality);
    let measured = |number: Option<f64>| number.filter(|_| state.codes().is_measured).map_or(Value::None, Value::Float);
    let value = match signal {
        Signal::Pressure => metric_value(&measured(sample.pa)),
        Signal::PressureLog10 => metric_value(&measured(sample.decades())),
        Signal::State => metric_value(&Value::Choice(state.number())),
        _ => return None,
    };
    let quality = quality(signal, state, value.is_some());
    Some((value, quality))
}
