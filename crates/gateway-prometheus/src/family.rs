//! The metric families: one for each signal, named after the conventions of Prometheus.

use profivac_gateway::names::NameTable;
use profivac_gateway::signal::SubjectKind;
use profivac_gateway::{Kind, Point, Signal, Subject};
use profivac_web_server::exposition::{MetricKind, put_label};

/// How a signal becomes series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A number that goes up and down.
    Gauge,
    /// A number that only grows while the station runs.
    Counter,
    /// A series for each word in the label of this name; that of the present word is 1, the others are 0.
    States(&'static str, &'static [&'static str]),
    /// A series with the value 1 and the text in the label of this name, absent while the text is empty.
    Text(&'static str),
    /// The same, for texts that are words: a text that is a number has no series, as each value would begin a new one, and the number is a
    /// metric of its own.
    Word(&'static str),
    /// A label of the series `profivac_…_info` of its subject.
    Label(&'static str),
    /// Nothing is published.
    Absent,
}

/// A metric family.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Family {
    /// Its name with its unit, without `_total` and `_info`.
    pub name: String,
    /// How the signal becomes series.
    pub form: Form,
    /// The unit in its name.
    pub unit: Option<&'static str>,
    /// Its description.
    pub help: &'static str,
}

impl Family {
    /// The family of a signal.
    #[must_use]
    pub fn of(signal: Signal) -> Self {
        let form = form(signal);
        let unit = unit(signal);
        let prefix = prefix(signal.subject());
        let name = match form {
            Form::Label(_) => prefix.to_owned(),
            _ => [prefix, &stem(signal)]
                .into_iter()
                .chain(unit)
                .filter(|part| !part.is_empty())
                .collect::<Vec<_>>()
                .join("_"),
        };
        Self { name, form, unit: unit.filter(|_| !matches!(form, Form::Label(_))), help: help(signal) }
    }

    /// The name of its samples.
    #[must_use]
    pub fn sample(&self) -> String {
        format!("{}{}", self.name, self.kind().suffix())
    }

    /// Its type.
    #[must_use]
    pub const fn kind(&self) -> MetricKind {
        match self.form {
            Form::Counter => MetricKind::Counter,
            Form::Label(_) | Form::Text(_) | Form::Word(_) => MetricKind::Info,
            Form::Gauge | Form::States(..) | Form::Absent => MetricKind::Gauge,
        }
    }
}

/// How a signal becomes series. A signal without a row of its own follows its kind, so that a new one is published at once.
fn form(signal: Signal) -> Form {
    match signal {
        Signal::Requests
        | Signal::Repetitions
        | Signal::LostCycles
        | Signal::DamagedAnswers
        | Signal::Telegrams
        | Signal::DamagedTelegrams
        | Signal::SegmentRepetitions
        | Signal::SegmentLostCycles
        | Signal::LostSamples
        | Signal::LostEvents
        | Signal::Refusals => Form::Counter,
        // What never changes while the file is the same.
        Signal::Device => Form::Label("device"),
        Signal::Address => Form::Label("address"),
        Signal::Gas => Form::Label("gas"),
        Signal::Group => Form::Label("group"),
        Signal::Tags => Form::Label("tags"),
        Signal::Location => Form::Label("location"),
        Signal::Calibrated => Form::Label("calibrated"),
        Signal::CalibrationDue => Form::Label("calibration_due"),
        Signal::Simulated => Form::Label("simulated"),
        Signal::ListenOnly => Form::Label("listen_only"),
        Signal::Version => Form::Label("version"),
        Signal::Priority => Form::Label("priority"),
        // Its pressure would make a new series with every reading; pressure, state, problem and faults say the same.
        Signal::StateText => Form::Absent,
        // Its value would make a new series with every occurrence; the metrics of the alarm have limit and values.
        Signal::AlarmText => Form::Absent,
        Signal::ParameterText => Form::Word("text"),
        // The same text as in the state of the reading, with a pressure where the quality is assumed.
        Signal::Cause => Form::Absent,
        Signal::Problem | Signal::SegmentProblem | Signal::RecorderProblem => Form::Text("problem"),
        Signal::Faults => Form::Text("faults"),
        Signal::Warnings => Form::Text("warnings"),
        Signal::Assumptions => Form::Text("assumptions"),
        Signal::AlarmUnit => Form::Text("unit"),
        Signal::AcknowledgedBy | Signal::SuppressedBy => Form::Text("user"),
        Signal::OutOfService => Form::Text("reason"),
        Signal::Quality => Form::States("quality", &profivac_gateway::signal::QUALITIES),
        Signal::TokenRing => Form::Text("addresses"),
        Signal::LineUnit => Form::Text("unit"),
        Signal::Diagnosis => Form::Text("diagnosis"),
        Signal::AlarmPriority => Form::States("priority", &profivac_gateway::signal::PRIORITIES),
        other => match other.kind() {
            Kind::Float | Kind::Integer | Kind::Boolean | Kind::Time => Form::Gauge,
            Kind::Choice(words) => Form::States("state", words),
            Kind::Text => Form::Text("text"),
        },
    }
}

/// The description. A pressure that is not measured has no series, so the end of the range is never its value.
const fn help(signal: Signal) -> &'static str {
    match signal {
        Signal::Pressure => "Indicated pressure; absent while it is not measured",
        Signal::ParameterText => "Value of a parameter in words; absent where it is a number",
        other => other.description(),
    }
}

/// The base unit at the end of the name.
fn unit(signal: Signal) -> Option<&'static str> {
    match (signal.kind(), signal.unit()) {
        (Kind::Time, _) => Some("timestamp_seconds"),
        (_, Some("Pa")) => Some("pascals"),
        (_, Some("s")) => Some("seconds"),
        // People read and enter it in percent, so no ratio.
        (_, Some("%")) => Some("percent"),
        (_, Some("A")) => Some("amperes"),
        (_, Some("V")) => Some("volts"),
        (_, Some("W")) => Some("watts"),
        _ => None,
    }
}

/// The beginning of the names of a subject.
pub const fn prefix(subject: SubjectKind) -> &'static str {
    match subject {
        SubjectKind::Station => "profivac_station",
        SubjectKind::Segment => "profivac_segment",
        // promtool refuses `gauge` in a name, because it is a type of metric.
        SubjectKind::Gauge => "profivac_device",
        SubjectKind::Reading => "profivac_reading",
        SubjectKind::Parameter => "profivac_parameter",
        SubjectKind::Alarm => "profivac_alarm",
    }
}

/// The name of a signal without the name of its subject.
fn stem(signal: Signal) -> String {
    // The name ends with its unit: `profivac_reading_timestamp_seconds`, `profivac_parameter_percent`.
    if matches!(signal, Signal::LastReading | Signal::ParameterPercentage) {
        return String::new();
    }
    let own = match signal.subject() {
        SubjectKind::Station => "station-",
        SubjectKind::Segment => "segment-",
        SubjectKind::Gauge => "gauge-",
        SubjectKind::Reading => "reading-",
        SubjectKind::Parameter => "parameter-",
        SubjectKind::Alarm => "alarm-",
    };
    let key = signal.key();
    key.strip_prefix(own).unwrap_or(key).replace('-', "_")
}

/// A word of a choice as the value of a label.
#[must_use]
pub fn word_label(word: &str) -> String {
    word.to_lowercase().replace(' ', "_")
}

/// The labels that name a subject.
#[must_use]
pub fn labels(point: &Point) -> String {
    let mut text = String::new();
    if let Some(segment) = &point.segment {
        put_label(&mut text, "segment", segment);
    }
    match &point.subject {
        Subject::Station | Subject::Segment(_) => {}
        Subject::Gauge(gauge) => put_label(&mut text, "gauge", gauge),
        Subject::Reading { gauge, channel, .. } => {
            put_label(&mut text, "gauge", gauge);
            if let Some(channel) = channel {
                put_label(&mut text, "channel", &channel.to_string());
            }
        }
        Subject::Parameter { gauge, target, .. } => {
            put_label(&mut text, "gauge", gauge);
            put_label(&mut text, "parameter", target);
        }
        Subject::Alarm(alarm) => put_label(&mut text, "alarm", alarm),
    }
    // A unit that is not the same for all numbers of the family cannot be a part of its name.
    if let Some(unit) = point.unit.filter(|_| point.signal.unit().is_none()) {
        put_label(&mut text, "unit", unit);
    }
    text
}

/// The metrics of these points.
#[must_use]
pub fn names(points: &[Point]) -> NameTable {
    let mut table = NameTable::new(&["name", "labels", "kind", "unit", "values", "signal", "description"]);
    for point in points {
        let family = Family::of(point.signal);
        let (own_label, values) = match family.form {
            Form::Absent => continue,
            Form::States(label, words) => {
                (Some(label), words.iter().map(|word| word_label(word)).collect::<Vec<_>>().join(" "))
            }
            Form::Text(label) | Form::Word(label) | Form::Label(label) => (Some(label), "1".to_owned()),
            Form::Gauge | Form::Counter => (None, String::new()),
        };
        let mut labels = labels(point);
        if let Some(label) = own_label {
            put_label(&mut labels, label, "…");
        }
        table.push([
            family.sample(),
            labels,
            family.kind().word().to_owned(),
            family.unit.unwrap_or_default().to_owned(),
            values,
            point.signal.key().to_owned(),
            family.help.to_owned(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn the_names_follow_the_conventions_of_prometheus() {
        let sample = |signal| Family::of(signal).sample();
        assert_eq!(sample(Signal::Pressure), "profivac_reading_pressure_pascals");
        assert_eq!(sample(Signal::State), "profivac_reading_state");
        assert_eq!(sample(Signal::LastReading), "profivac_reading_timestamp_seconds");
        assert_eq!(sample(Signal::SegmentUp), "profivac_segment_up");
        assert_eq!(sample(Signal::SegmentRepetitions), "profivac_segment_repetitions_total");
        assert_eq!(sample(Signal::Device), "profivac_device_info");
        assert_eq!(sample(Signal::AlarmActive), "profivac_alarm_active");
        assert_eq!(sample(Signal::ParameterPercentage), "profivac_parameter_percent");
        let allowed = |name: &str| {
            name.bytes().all(|octet| octet.is_ascii_lowercase() || octet.is_ascii_digit() || octet == b'_')
        };
        assert!(Signal::ALL.iter().all(|signal| allowed(&Family::of(*signal).name)));
    }

    #[test]
    fn two_signals_share_a_name_only_as_labels_of_one_info_series() {
        let mut signals: BTreeMap<String, Vec<Signal>> = BTreeMap::new();
        for signal in Signal::ALL {
            signals.entry(Family::of(*signal).name).or_default().push(*signal);
        }
        let is_label = |signal: &Signal| matches!(Family::of(*signal).form, Form::Label(_));
        for (name, signals) in signals {
            assert!(signals.len() == 1 || signals.iter().all(is_label), "{name}: {signals:?}");
        }
    }
}
