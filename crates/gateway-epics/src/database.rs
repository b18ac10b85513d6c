//! The records of a station, and what they read in a snapshot.

use crate::field::{self, Field};
use crate::names::{self, Entry, NameError};
use crate::record::{AlarmLimits, Answer, Data, MAX_TEXT, Meta, Put, Record, RecordType, Sample, cut, exponential};
use profivac_gateway::command::controlled_gauges;
use profivac_gateway::signal::{gauge_state, priority};
use profivac_gateway::{EpicsSeverity, EpicsStatus, Kind, Point, PointValue, Signal, Snapshot, State, Value};
use profivac_recorder::Micros;
use profivac_recorder::export::seven_digits;
use profivac_station::config::gateways::epics::{OnInvalid, ReadingState, Settings, Severity};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// The words of `bi`.
const NO_YES: [&str; 2] = ["No", "Yes"];

/// A field of a record: what a channel reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Target {
    /// The position of the record.
    pub record: usize,
    /// The field.
    pub field: Field,
    /// The text as an array of octets over Channel Access: the name ends with `$`.
    pub is_long: bool,
}

/// The records of a station.
#[derive(Debug)]
pub struct Database {
    /// The records: one for each point that has one, then those for writing, and one for each alias.
    pub records: Vec<Record>,
    /// How many of them are the records of the points; these come first.
    pub of_points: usize,
    by_name: HashMap<Arc<str>, usize>,
    /// The name of the table of all gauges.
    pub table: String,
    settings: Settings,
}

/// Records and values at one moment.
#[derive(Clone, Debug)]
pub struct World {
    /// The records.
    pub database: Arc<Database>,
    /// Their values.
    pub snapshot: Arc<Snapshot>,
    /// The last pressures, by point, if the settings want them to be held.
    pub held: Arc<[Option<f64>]>,
}

impl Database {
    /// The records of the points of a snapshot.
    ///
    /// # Errors
    /// A name is too long or is given twice, or the settings name something that does not exist.
    pub fn new(station: &str, snapshot: &Snapshot, settings: &Settings) -> Result<Self, NameError> {
        let rows = names::rows(station, snapshot, settings)?;
        let gauges = controlled_gauges(snapshot);
        let record = |row: &names::Row| {
            let point = snapshot.points.get(row.point)?;
            let is_pressure = |it: &Point| it.signal == Signal::Pressure && it.subject == point.subject;
            let text = point.signal == Signal::StateText;
            Some(Record {
                name: Arc::from(row.name.as_str()),
                kind: record_type(row.entry, point.signal),
                signal: point.signal,
                about: about(row.entry, point.signal, &settings.unit),
                point: row.point,
                pressure: if text { snapshot.points.iter().position(is_pressure) } else { None },
                is_pressure: point.unit == Some("Pa"),
                is_simulated: point.is_simulated,
                put: put(row.entry, point, &gauges, settings),
                meta: meta(row.entry, point, settings),
            })
        };
        let records: Vec<Record> = rows.iter().filter_map(record).collect();
        let by_name = records.iter().enumerate().map(|(index, record)| (Arc::clone(&record.name), index)).collect();
        let of_points = rows.iter().filter(|row| row.entry == Entry::Point).count();
        Ok(Self { records, of_points, by_name, table: names::table_name(settings), settings: settings.clone() })
    }

    /// The field that a name with or without a field stands for.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<Target> {
        let (name, is_long) = name.strip_suffix('$').map_or((name, false), |name| (name, true));
        let (name, field) = name.split_once('.').unwrap_or((name, "VAL"));
        let record = *self.by_name.get(name)?;
        let kind = self.records.get(record)?.kind;
        let field = Field::named(field, kind)?;
        (!is_long || field.is_text(kind)).then_some(Target { record, field, is_long })
    }

    /// The record of a target if a put to it may be done: its value, not another field.
    #[must_use]
    pub fn writable(&self, target: Target) -> Option<&Record> {
        let record = self.records.get(target.record)?;
        (target.field == Field::Value && record.put != Put::Refused).then_some(record)
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }
}

/// What a put to a name does.
fn put(entry: Entry, point: &Point, gauges: &HashSet<&str>, settings: &Settings) -> Put {
    if settings.write.is_none() {
        return Put::Refused;
    }
    let is_controlled = point.subject.gauge().is_some_and(|gauge| gauges.contains(gauge));
    match entry {
        Entry::Acknowledge => Put::Acknowledge,
        Entry::Command if is_controlled => Put::Command,
        Entry::Point | Entry::Alias if is_controlled && point.is_writable => Put::Parameter,
        _ => Put::Refused,
    }
}

const fn record_type(entry: Entry, signal: Signal) -> RecordType {
    match signal.kind() {
        _ if matches!(entry, Entry::Command) => RecordType::Stringin,
        // An acknowledgement needs each of its 13 digits: `caget` shows six of a number, 1.76723e+12.
        _ if matches!((entry, signal), (Entry::Point | Entry::Alias, Signal::Occurrence)) => RecordType::Stringin,
        Kind::Float => RecordType::Ai,
        Kind::Integer => RecordType::Int64in,
        Kind::Boolean => RecordType::Bi,
        Kind::Choice(_) => RecordType::Mbbi,
        Kind::Text | Kind::Time => RecordType::Stringin,
    }
}

fn meta(entry: Entry, point: &Point, settings: &Settings) -> Meta {
    let is_pressure = point.unit == Some("Pa");
    let scaled = |number: f64| in_unit(point.signal, is_pressure, number, settings.unit_pa());
    let limit = |pa: Option<f64>| pa.map_or(f64::NAN, scaled);
    // 5e-8 Pa is 4.999999999999999e-10 mbar before it is rounded.
    let end = |number: f64| if is_pressure { seven_digits(scaled(number)) } else { scaled(number) };
    let unit = if is_pressure { settings.unit.clone() } else { short(point.unit.unwrap_or_default()).to_owned() };
    let limits = point.limits;
    Meta {
        description: description(entry, point, &settings.unit),
        precision: point.decimals_in(settings.unit_pa()).into(),
        is_exponential: is_pressure || (point.unit == Some("s") && matches!(point.signal.kind(), Kind::Float)),
        display: point.display_range().map_or((0.0, 0.0), |(low, high)| (end(low), end(high))),
        limits: AlarmLimits {
            high_high: limit(limits.high_high),
            high: limit(limits.high),
            low: limit(limits.low),
            low_low: limit(limits.low_low),
        },
        states: match point.signal.kind() {
            _ if entry == Entry::Command => &[],
            Kind::Choice(words) => words,
            Kind::Boolean => &NO_YES,
            _ => &[],
        },
        unit,
    }
}

/// A number of the model in the unit of its record.
fn in_unit(signal: Signal, is_pressure: bool, number: f64, unit_pa: f64) -> f64 {
    match signal {
        Signal::PressureLog10 => number - unit_pa.log10(),
        _ if is_pressure => number / unit_pa,
        _ => number,
    }
}

/// The unit within the seven octets of Channel Access.
fn short(unit: &str) -> &str {
    match unit {
        "decades/min" => "dec/min",
        "telegrams/min" => "tel/min",
        _ => unit,
    }
}

/// What a record says, in a sentence.
fn about(entry: Entry, signal: Signal, unit: &str) -> Cow<'static, str> {
    match (entry, signal) {
        (Entry::Command, _) => "Takes the commands of the gauge; it has no value".into(),
        (Entry::Acknowledge, _) => "Takes the number of the occurrence that is acknowledged".into(),
        (_, Signal::PressureLog10) => format!("Decimal logarithm of the indicated pressure in {unit}").into(),
        (_, other) => other.description().into(),
    }
}

/// The subject and what the point says of it, within the 40 octets of `DESC`.
fn description(entry: Entry, point: &Point, unit: &str) -> String {
    let what = match point.signal {
        _ if entry == Entry::Command => "commands".to_owned(),
        _ if entry == Entry::Acknowledge => "acknowledge this occurrence".to_owned(),
        Signal::Pressure => "pressure".to_owned(),
        Signal::ParameterPressure | Signal::ParameterPercentage | Signal::ParameterNumber | Signal::ParameterText => {
            point.subject.name().to_owned()
        }
        Signal::PressureLog10 => format!("log10 of the pressure in {unit}"),
        other => other.key().replace('-', " "),
    };
    let subject = point.subject.gauge().filter(|_| what == point.subject.name()).unwrap_or(point.subject.name());
    let virtual_mark = if point.is_simulated { "virtual " } else { "" };
    let text = if subject.is_empty() { what } else { format!("{virtual_mark}{subject}: {what}") };
    cut(&text, MAX_TEXT).to_owned()
}

impl World {
    /// The value of a field with its meta data; `None` if the record does not exist.
    #[must_use]
    pub fn read(&self, target: Target) -> Option<Answer<'_>> {
        let record = self.database.records.get(target.record)?;
        let sample = self.sample(record)?;
        match target.field {
            Field::Value => Some(Answer { sample, meta: Cow::Borrowed(&record.meta) }),
            other => Some(field::read(other, record, sample)),
        }
    }

    /// How often the point of a target has changed.
    #[must_use]
    pub fn version(&self, target: Target) -> u64 {
        let value = self.database.records.get(target.record).and_then(|record| self.snapshot.values.get(record.point));
        value.map_or(0, |value| value.version)
    }

    /// The value of a record.
    #[must_use]
    pub fn sample(&self, record: &Record) -> Option<Sample> {
        let value = self.snapshot.values.get(record.point)?;
        let settings = self.database.settings();
        let data = self.data(record, value);
        let mut alarm = alarm_of_state(value.state, settings);
        // The words stay if the site gives the state no severity: the end of the range is no pressure then either.
        let mut message = message(record.signal, value.state);
        if value.value == Value::None && value.state == State::Ok {
            if exists_always(record) {
                alarm = (EpicsSeverity::Invalid, EpicsStatus::Undefined);
            } else {
                message = "there is none";
            }
        }
        let own = match &data {
            Data::Double(number) => record.meta.limits.alarm(*number),
            _ => alarm_of_value(record.signal, &value.value),
        };
        if let Some(own) = own.filter(|own| own.0 > alarm.0) {
            alarm = own;
        }
        // A virtual gauge tells that it is one wherever no alarm needs the place.
        if record.is_simulated && alarm.0 == EpicsSeverity::None {
            alarm.1 = EpicsStatus::Simulated;
        }
        Some(Sample { data, severity: alarm.0, status: alarm.1, message, at: value.at.unwrap_or(Micros(0)) })
    }

    fn data(&self, record: &Record, value: &PointValue) -> Data {
        match (&value.value, record.kind) {
            // A record of commands shows no value.
            (Value::Choice(_), RecordType::Stringin) => Data::Text(Arc::from("")),
            (Value::Float(number), RecordType::Ai) => Data::Double(self.scaled(record, *number)),
            (_, RecordType::Ai) => {
                let held = self.held.get(record.point).copied().flatten();
                Data::Double(held.map_or(f64::NAN, |number| self.scaled(record, number)))
            }
            (Value::Integer(number), RecordType::Stringin) => Data::Text(number.to_string().into()),
            (Value::Integer(number), _) => Data::Long(*number),
            (_, RecordType::Int64in) => Data::Long(0),
            (Value::Boolean(is_true), _) => Data::Enum(u16::from(*is_true)),
            (Value::Choice(number), _) => Data::Enum(*number),
            (_, RecordType::Bi | RecordType::Mbbi) => Data::Enum(0),
            (Value::Text(text), RecordType::Stringin) if record.signal == Signal::AlarmUnit && &**text == "Pa" => {
                Data::Text(Arc::from(self.database.settings().unit.as_str()))
            }
            (Value::Text(text), RecordType::Stringin) => {
                self.pressure_text(record, value).unwrap_or(Data::Text(Arc::clone(text)))
            }
            (Value::Time(at), RecordType::Stringin) => Data::Text(at.to_iso(3).into()),
            (_, RecordType::Stringin) => Data::Text(Arc::from("")),
        }
    }

    /// A number of the model in the unit of the record.
    fn scaled(&self, record: &Record, number: f64) -> f64 {
        in_unit(record.signal, record.is_pressure, number, self.database.settings().unit_pa())
    }

    /// The text of a reading in the unit of the settings, if the reading has a pressure.
    fn pressure_text(&self, record: &Record, value: &PointValue) -> Option<Data> {
        let pa = self.snapshot.values.get(record.pressure?)?.value.float()?;
        let settings = self.database.settings();
        let sign = match value.state {
            State::UnderRange => "< ",
            State::OverRange => "> ",
            _ => "",
        };
        let number = exponential(pa / settings.unit_pa(), 2);
        Some(Data::Text(format!("{sign}{number} {}", settings.unit).into()))
    }
}

/// The numbers measured last after `snapshot`, if the settings want them to be held. The end of a range was not measured.
#[must_use]
pub fn held(
    before: &[Option<f64>],
    snapshot: &Snapshot,
    is_same_list: bool,
    settings: &Settings,
) -> Arc<[Option<f64>]> {
    if settings.on_invalid == OnInvalid::Nan {
        return Arc::from([]);
    }
    let old = |index: usize| if is_same_list { before.get(index).copied().flatten() } else { None };
    let values = snapshot.values.iter().enumerate();
    values.map(|(index, value)| value.measured().or_else(|| old(index))).collect()
}

/// The alarm of the state of a reading.
fn alarm_of_state(state: State, settings: &Settings) -> (EpicsSeverity, EpicsStatus) {
    let codes = state.codes();
    let severity = configured(state, settings).unwrap_or(codes.epics_severity);
    (severity, if severity == EpicsSeverity::None { EpicsStatus::None } else { codes.epics_status })
}

/// The words for the alarm of a state, within the 39 octets of `AMSG`.
const fn message(signal: Signal, state: State) -> &'static str {
    match (signal, state) {
        (_, State::Ok) => "",
        (Signal::Pressure | Signal::PressureLog10, State::UnderRange) => "below range: the value is its lower end",
        (Signal::Pressure | Signal::PressureLog10, State::OverRange) => "above range: the value is its upper end",
        (_, other) => other.label(),
    }
}

/// Whether a record has a value unless something is wrong. An alarm without a limit, or one that was never raised, lacks nothing, and no
/// controller corrects for the gas: there the number is not a number and the text is empty, without an alarm.
fn exists_always(record: &Record) -> bool {
    match record.signal {
        Signal::AlarmLimit
        | Signal::RaisedValue
        | Signal::Raised
        | Signal::AcknowledgedAt
        | Signal::SuppressedUntil
        | Signal::CorrectedPressure => false,
        // The value of an alarm with a limit is missing while its gauge is lost.
        Signal::AlarmValue => !record.meta.unit.is_empty(),
        _ => true,
    }
}

fn configured(state: State, settings: &Settings) -> Option<EpicsSeverity> {
    let key = match state {
        State::Ok | State::Uncertain => return None,
        State::UnderRange => ReadingState::Underrange,
        State::OverRange => ReadingState::Overrange,
        State::Off => ReadingState::Off,
        State::Starting => ReadingState::Starting,
        State::Invalid => ReadingState::Invalid,
        State::NotPresent => ReadingState::NotPresent,
        State::Stale | State::NotRead => ReadingState::Gap,
        State::Fault => ReadingState::Fault,
    };
    Some(match settings.severities.get(&key)? {
        Severity::None => EpicsSeverity::None,
        Severity::Minor => EpicsSeverity::Minor,
        Severity::Major => EpicsSeverity::Major,
        Severity::Invalid => EpicsSeverity::Invalid,
    })
}

/// The alarm of a value that is no pressure.
const fn alarm_of_value(signal: Signal, value: &Value) -> Option<(EpicsSeverity, EpicsStatus)> {
    let severity = match (signal, value) {
        // The priorities none, low, medium, high.
        (Signal::AlarmPriority, Value::Choice(priority::LOW | priority::MEDIUM)) => EpicsSeverity::Minor,
        (Signal::AlarmPriority, Value::Choice(priority::HIGH)) => EpicsSeverity::Major,
        // The states data exchange, fault, starting, missing.
        (Signal::GaugeState, Value::Choice(gauge_state::FAULT | gauge_state::MISSING)) => EpicsSeverity::Major,
        (Signal::GaugeState, Value::Choice(gauge_state::STARTING)) => EpicsSeverity::Minor,
        (Signal::SegmentUp | Signal::Recording, Value::Boolean(false)) => EpicsSeverity::Major,
        _ => return None,
    };
    Some((severity, EpicsStatus::State))
}
