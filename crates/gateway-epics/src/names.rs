//! The names of records.

use profivac_gateway::{Point, Signal, Snapshot, Subject, Value};
use profivac_station::config::gateways::epics::{MAX_NAME, Preset, Settings};
use std::collections::BTreeMap;
use std::collections::btree_map;

/// The reason why the names cannot be published. All of them are errors of the station's file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NameError {
    /// A name is too long.
    #[error(
        "[epics]: the name {name} of {point} has {} octets, EPICS allows {MAX_NAME}: shorten name or prefix, or give the signal a shorter \
         name in signals",
        name.len()
    )]
    TooLong {
        /// The name.
        name: String,
        /// What it stands for.
        point: String,
    },
    /// Two points have the same name.
    #[error(
        "[epics]: {first} and {second} both have the name {name}: add a place such as {{GAUGE}}, {{segment}} or {{channel}} to name, or give \
         one of the signals another name in signals"
    )]
    Duplicate {
        /// The name.
        name: String,
        /// A point.
        first: String,
        /// Another point.
        second: String,
    },
    /// `signals` names a signal that does not exist.
    #[error("[epics]: there is no signal {found:?} to be renamed in signals{}", hint(.suggestion.as_deref()))]
    UnknownSignal {
        /// The key.
        found: String,
        /// The most similar key.
        suggestion: Option<String>,
    },
    /// `alias` names a point that does not exist.
    #[error(
        "[epics.alias]: expected for {name} a point like \"GAUGE.SIGNAL\", found {found:?}{}",
        hint(.suggestion.as_deref())
    )]
    UnknownPoint {
        /// The alias.
        name: String,
        /// What it shall stand for.
        found: String,
        /// The most similar point.
        suggestion: Option<String>,
    },
}

fn hint(suggestion: Option<&str>) -> String {
    suggestion.map_or_else(String::new, |suggestion| format!("; did you mean {suggestion:?}?"))
}

/// A name and the point that it stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// The name of the record.
    pub name: String,
    /// The position of the point in the snapshot.
    pub point: usize,
    /// What it stands for.
    pub entry: Entry,
}

/// What a name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// A point.
    Point,
    /// A point, by a name of the file.
    Alias,
    /// The commands of the gauge of the point, where clients may write.
    Command,
    /// The acknowledgement of the alarm of the point, where clients may write.
    Acknowledge,
}

/// The names of all points of a snapshot that have a record, in its order, then the aliases.
///
/// # Errors
/// A name is too long or is given twice, or the settings name something that does not exist.
pub fn rows(station: &str, snapshot: &Snapshot, settings: &Settings) -> Result<Vec<Row>, NameError> {
    check_signals(snapshot, settings)?;
    let mut taken = BTreeMap::new();
    let mut rows = Vec::new();
    let naming = Naming::new(station, snapshot, settings);
    for (point, it) in snapshot.points.iter().enumerate().filter(|(point, it)| has_record(snapshot, *point, it)) {
        rows.push(Row { name: naming.name(it), point, entry: Entry::Point });
    }
    if settings.write.is_some() {
        let points = snapshot.points.iter().enumerate();
        rows.extend(points.filter_map(|(point, it)| {
            let (name, entry) = naming.for_writing(it)?;
            Some(Row { name, point, entry })
        }));
    }
    for (name, target) in &settings.aliases {
        rows.push(Row { name: name.clone(), point: aliased(snapshot, name, target)?, entry: Entry::Alias });
    }
    for row in &rows {
        let described = snapshot.points.get(row.point).map(described).unwrap_or_default();
        take(&mut taken, &row.name, described)?;
    }
    take(&mut taken, &table_name(settings), "the table of all gauges".to_owned())?;
    Ok(rows)
}

/// Whether a point has a record of its own: the limit of an alarm without one, such as "no data", has none. A limit is in the file, so that it
/// does not come and go.
fn has_record(snapshot: &Snapshot, position: usize, point: &Point) -> bool {
    let has_value = || snapshot.values.get(position).is_none_or(|value| value.value != Value::None);
    point.signal != Signal::AlarmLimit || has_value()
}

/// The name of the table of all gauges.
#[must_use]
pub fn table_name(settings: &Settings) -> String {
    format!("{}TABLE", settings.prefix)
}

fn take(taken: &mut BTreeMap<String, String>, name: &str, point: String) -> Result<(), NameError> {
    if name.len() > MAX_NAME {
        return Err(NameError::TooLong { name: name.to_owned(), point });
    }
    match taken.entry(name.to_owned()) {
        btree_map::Entry::Occupied(first) => {
            Err(NameError::Duplicate { name: name.to_owned(), first: first.get().clone(), second: point })
        }
        btree_map::Entry::Vacant(free) => {
            free.insert(point);
            Ok(())
        }
    }
}

/// A point as the file names it: `chamber.pressure`, of a parameter `chamber.trip-point.1/high-trip-point`.
#[must_use]
pub fn described(point: &Point) -> String {
    match point.subject.name() {
        "" => point.signal.key().to_owned(),
        name => match (&point.subject, point.signal) {
            (Subject::Parameter { gauge, .. }, Signal::ParameterText) => format!("{gauge}.{name}.text"),
            (Subject::Parameter { gauge, .. }, _) => format!("{gauge}.{name}"),
            (_, signal) => format!("{name}.{}", signal.key()),
        },
    }
}

fn aliased(snapshot: &Snapshot, name: &str, target: &str) -> Result<usize, NameError> {
    let mut points = snapshot.points.iter();
    points.position(|point| described(point) == target).ok_or_else(|| NameError::UnknownPoint {
        name: name.to_owned(),
        found: target.to_owned(),
        suggestion: similar(target, snapshot.points.iter().map(described)),
    })
}

/// Every key of `signals` is that of a signal, or a parameter of a gauge.
fn check_signals(snapshot: &Snapshot, settings: &Settings) -> Result<(), NameError> {
    let parameters = || snapshot.points.iter().filter(|point| point.signal == Signal::ParameterText);
    let is_known = |key: &str| {
        Signal::ALL.iter().any(|signal| signal.key() == key) || parameters().any(|point| point.subject.name() == key)
    };
    match settings.signals.keys().find(|key| !is_known(key)) {
        None => Ok(()),
        Some(found) => Err(NameError::UnknownSignal {
            found: found.clone(),
            suggestion: similar(
                found,
                Signal::ALL
                    .iter()
                    .map(|signal| signal.key().to_owned())
                    .chain(parameters().map(|point| point.subject.name().to_owned())),
            ),
        }),
    }
}

fn similar(found: &str, known: impl Iterator<Item = String>) -> Option<String> {
    let scored = known.map(|it| (strsim::jaro_winkler(found, &it), it)).filter(|(score, _)| *score > 0.7);
    scored.max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, it)| it)
}

/// What the templates need besides the point.
struct Naming<'a> {
    station: &'a str,
    settings: &'a Settings,
    /// Device and address of each gauge.
    gauges: BTreeMap<&'a str, (String, String)>,
}

impl<'a> Naming<'a> {
    fn new(station: &'a str, snapshot: &'a Snapshot, settings: &'a Settings) -> Self {
        let mut gauges: BTreeMap<&str, (String, String)> = BTreeMap::new();
        for (point, value) in snapshot.iter() {
            let Subject::Gauge(name) = &point.subject else { continue };
            match (point.signal, &value.value) {
                (Signal::Device, Value::Text(device)) => gauges.entry(name).or_default().0 = device.to_string(),
                (Signal::Address, Value::Integer(address)) => gauges.entry(name).or_default().1 = address.to_string(),
                _ => {}
            }
        }
        Self { station, settings, gauges }
    }

    fn name(&self, point: &Point) -> String {
        let signal = signal_name(point.signal, self.settings);
        let prefix = &self.settings.prefix;
        match &point.subject {
            Subject::Station => format!("{prefix}{signal}"),
            Subject::Segment(name) => format!("{prefix}{}:{signal}", upper(name)),
            Subject::Alarm(name) => format!("{prefix}ALARM:{}:{signal}", upper(name)),
            Subject::Gauge(gauge) => self.of_gauge(point, gauge, None, &signal),
            Subject::Reading { gauge, channel, .. } => self.of_gauge(point, gauge, *channel, &signal),
            Subject::Parameter { gauge, target, .. } => {
                let name =
                    self.settings.signals.get(target.as_ref()).cloned().unwrap_or_else(|| parameter_name(target));
                let end = if point.signal == Signal::ParameterText { "_STR" } else { "" };
                self.of_gauge(point, gauge, None, &format!("{name}{end}"))
            }
        }
    }

    /// The name that only takes values: the commands of a gauge, the acknowledgement of an alarm.
    fn for_writing(&self, point: &Point) -> Option<(String, Entry)> {
        match (&point.subject, point.signal) {
            (Subject::Gauge(gauge), Signal::GaugeState) => {
                Some((self.of_gauge(point, gauge, None, "CMD"), Entry::Command))
            }
            (Subject::Alarm(name), Signal::Occurrence) => {
                Some((format!("{}ALARM:{}:ACK", self.settings.prefix, upper(name)), Entry::Acknowledge))
            }
            _ => None,
        }
    }

    fn of_gauge(&self, point: &Point, gauge: &str, channel: Option<u8>, signal: &str) -> String {
        let (device, address) = self.gauges.get(gauge).cloned().unwrap_or_default();
        let template = &self.settings.name;
        let number = channel.map(|channel| channel.to_string()).unwrap_or_default();
        // A template without a place for the channel gets it before the signal.
        let signal = match channel {
            Some(channel) if !template.contains("{channel}") => format!("CH{channel}:{signal}"),
            _ => signal.to_owned(),
        };
        let places = [
            ("{prefix}", self.settings.prefix.clone()),
            ("{station}", plain(self.station)),
            ("{segment}", plain(point.segment.as_deref().unwrap_or_default())),
            ("{gauge}", plain(gauge)),
            ("{GAUGE}", upper(gauge)),
            ("{address}", address),
            ("{device}", plain(&device)),
            ("{channel}", number),
            ("{signal}", signal),
        ];
        filled(template, &places)
    }
}

/// The template with its places filled. The texts that are filled in are not searched for places.
fn filled(template: &str, places: &[(&str, String)]) -> String {
    let mut name = String::new();
    let mut rest = template;
    while let Some(character) = rest.chars().next() {
        match places.iter().find_map(|(place, text)| Some((rest.strip_prefix(place)?, text))) {
            Some((after, text)) => {
                name.push_str(text);
                rest = after;
            }
            None => {
                name.push(character);
                rest = rest.get(character.len_utf8()..).unwrap_or_default();
            }
        }
    }
    name
}

/// A name of the file as part of a record's name: characters other than letters, digits, `_` and `-` become one `_`.
fn plain(name: &str) -> String {
    let of_name = |character: char| character.is_ascii_alphanumeric() || "_-".contains(character);
    let mut plain = String::new();
    for character in name.chars() {
        if of_name(character) {
            plain.push(character);
        } else if !plain.ends_with('_') {
            plain.push('_');
        }
    }
    plain
}

/// Shorter words for the names of parameters, which would soon fill the 60 characters of a name.
const SHORT_WORDS: [(&str, &str); 19] = [
    ("ANALOG", "ANA"),
    ("ATMOSPHERE", "ATM"),
    ("ATMOSPHERIC", "ATM"),
    ("BLOCK", "BLK"),
    ("DISCRETE", "DISC"),
    ("EMISSION", "EMIS"),
    ("FUNCTION", "FUNC"),
    ("HYSTERESIS", "HYST"),
    ("INPUT", "IN"),
    ("INSTANCE", "INST"),
    ("OUTPUT", "OUT"),
    ("PERCENTAGE", "PCT"),
    ("POINT", "PT"),
    ("PRESSURE", "P"),
    ("PROCESS", "PROC"),
    ("SENSOR", "SENS"),
    ("SETPOINT", "SP"),
    ("STATUS", "STAT"),
    ("THRESHOLD", "THR"),
];

/// The name of a parameter without its gauge: `SP_A_ATM_P_REACHED`.
fn parameter_name(target: &str) -> String {
    let long = upper(target).replace('-', "_");
    long.split('_').map(shortened).collect::<Vec<_>>().join("_")
}

fn shortened(word: &str) -> &str {
    SHORT_WORDS.iter().find(|(long, _)| *long == word).map_or(word, |(_, short)| *short)
}

fn upper(name: &str) -> String {
    plain(name).to_ascii_uppercase()
}

/// The name of a signal: that of the file, of the preset, the usual one, or its key in upper case.
#[must_use]
pub fn signal_name(signal: Signal, settings: &Settings) -> String {
    let renamed = settings.signals.get(signal.key()).cloned();
    let of_preset = || settings.preset.and_then(|preset| preset_name(preset, signal)).map(str::to_owned);
    let usual = || usual_name(signal).map_or_else(|| signal.key().replace('-', "_").to_uppercase(), str::to_owned);
    renamed.or_else(of_preset).unwrap_or_else(usual)
}

const fn usual_name(signal: Signal) -> Option<&'static str> {
    Some(match signal {
        Signal::Pressure => "P",
        Signal::PressureLog10 => "PLOG",
        Signal::CorrectedPressure => "P_CORR",
        Signal::StateText => "P_STR",
        Signal::Usable => "OK",
        Signal::AlarmPriority => "ALARM",
        Signal::Unacknowledged => "UNACK",
        Signal::SegmentUp => "SEG_OK",
        Signal::CycleTime => "CYCLE",
        Signal::SegmentRepetitions => "REPETITIONS",
        Signal::AlarmAcknowledged => "ACKED",
        Signal::AcknowledgedBy => "ACK_BY",
        Signal::AcknowledgedAt => "ACK_AT",
        Signal::OutOfService => "SUPPR_REASON",
        Signal::SuppressedBy => "SUPPR_BY",
        Signal::SuppressedUntil => "SUPPR_UNTIL",
        _ => return None,
    })
}

/// The names of signals at a facility, as its public support modules write them.
const fn preset_name(preset: Preset, signal: Signal) -> Option<&'static str> {
    Some(match (preset, signal) {
        // ISISComputingGroup/EPICS-TPG
        (Preset::Isis, Signal::Pressure) => "PRESSURE",
        (Preset::Isis, Signal::State) => "PRESSURE_STAT",
        // DiamondLightSource/mks937b
        (Preset::Dls, Signal::Pressure) => "P",
        (Preset::Dls, Signal::PressureLog10) => "PLOG",
        (Preset::Dls, Signal::State) => "STA",
        // NSLS2/va-ioc
        (Preset::Nsls2, Signal::Pressure) => "P-I",
        (Preset::Nsls2, Signal::State) => "P-Sts",
        // pcdshub/lcls-twincat-vacuum
        (Preset::Lcls, Signal::Pressure) => "PRESS_RBV",
        (Preset::Lcls, Signal::State) => "STATE_RBV",
        (Preset::Lcls, Signal::Usable) => "PRESS_OK_RBV",
        // ess-dmsc/nicos
        (Preset::Ess, Signal::Pressure) => "PrsR",
        (Preset::Ess, Signal::State) => "PrsStatR",
        (Preset::Ess, Signal::StateText) => "PrR-STR",
        // lnls-sirius/streamdevice-ioc
        (Preset::Sirius, Signal::Pressure) => "Pressure-Mon",
        _ => return None,
    })
}
