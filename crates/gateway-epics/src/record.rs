//! Records: what a process variable is, and its value at a moment.

use profivac_gateway::{EpicsSeverity, EpicsStatus, Signal};
use profivac_recorder::Micros;
use std::borrow::Cow;
use std::sync::Arc;

/// The decimals of a number with an exponent.
pub const DECIMALS: u8 = 2;

/// The longest text of Channel Access in octets, without the end mark.
pub const MAX_TEXT: usize = 39;

/// The type of a record in EPICS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordType {
    /// A floating-point number.
    Ai,
    /// A whole number of 64 bits; Channel Access shows it as a floating-point number, as EPICS does.
    Int64in,
    /// No or yes.
    Bi,
    /// One of several words.
    Mbbi,
    /// A text.
    Stringin,
}

impl RecordType {
    /// Its name, the value of the field `RTYP`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ai => "ai",
            Self::Int64in => "int64in",
            Self::Bi => "bi",
            Self::Mbbi => "mbbi",
            Self::Stringin => "stringin",
        }
    }
}

/// A record: what seldom changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Its name.
    pub name: Arc<str>,
    /// Its type.
    pub kind: RecordType,
    /// What it says.
    pub signal: Signal,
    /// The same in a sentence, with the unit of the settings: `INP`.
    pub about: Cow<'static, str>,
    /// The position of its point in the snapshot.
    pub point: usize,
    /// The position of the pressure of the same reading, for the text.
    pub pressure: Option<usize>,
    /// Its value is a pressure, in the unit of the settings.
    pub is_pressure: bool,
    /// Its gauge is virtual.
    pub is_simulated: bool,
    /// What a put does.
    pub put: Put,
    /// Units, limits and words.
    pub meta: Meta,
}

/// What a put to a record does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Put {
    /// It is refused.
    Refused,
    /// It writes the parameter of the point.
    Parameter,
    /// It sends a command to the gauge of the point. The record has no value of its own.
    Command,
    /// It acknowledges this occurrence of the alarm of the point.
    Acknowledge,
}

/// What a client shows besides the value.
#[derive(Clone, Debug, PartialEq)]
pub struct Meta {
    /// A description.
    pub description: String,
    /// The unit.
    pub unit: String,
    /// The number of decimals, `PREC`: as many as the smallest value needs where a client shows no exponent.
    pub precision: i16,
    /// The value spans decades: a text of it has an exponent and two decimals.
    pub is_exponential: bool,
    /// The ends of the range, low and high: `LOPR`, `HOPR`. Both 0 where there is no range.
    pub display: (f64, f64),
    /// The limits of the alarms; not a number where there is none.
    pub limits: AlarmLimits,
    /// The words of an enumeration.
    pub states: &'static [&'static str],
}

/// The limits of the alarms of a number; not a number where there is none.
#[derive(Clone, Copy, Debug)]
pub struct AlarmLimits {
    /// `HIHI`.
    pub high_high: f64,
    /// `HIGH`.
    pub high: f64,
    /// `LOW`.
    pub low: f64,
    /// `LOLO`.
    pub low_low: f64,
}

impl AlarmLimits {
    /// No limits.
    pub const NONE: Self = Self { high_high: f64::NAN, high: f64::NAN, low: f64::NAN, low_low: f64::NAN };

    fn bits(self) -> [u64; 4] {
        [self.high_high, self.high, self.low, self.low_low].map(f64::to_bits)
    }

    /// The alarm of a value.
    #[must_use]
    pub fn alarm(self, value: f64) -> Option<(EpicsSeverity, EpicsStatus)> {
        // A comparison with a limit that is not a number is false.
        if value >= self.high_high {
            Some((EpicsSeverity::Major, EpicsStatus::HiHi))
        } else if value <= self.low_low {
            Some((EpicsSeverity::Major, EpicsStatus::LoLo))
        } else if value >= self.high {
            Some((EpicsSeverity::Minor, EpicsStatus::High))
        } else if value <= self.low {
            Some((EpicsSeverity::Minor, EpicsStatus::Low))
        } else {
            None
        }
    }
}

impl PartialEq for AlarmLimits {
    fn eq(&self, other: &Self) -> bool {
        self.bits() == other.bits()
    }
}

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// A floating-point number.
    Double(f64),
    /// A whole number.
    Long(i64),
    /// The position of a word.
    Enum(u16),
    /// A text.
    Text(Arc<str>),
}

/// A value with its alarm and its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The value.
    pub data: Data,
    /// The severity of its alarm.
    pub severity: EpicsSeverity,
    /// The reason of its alarm.
    pub status: EpicsStatus,
    /// The reason in words, `AMSG`; empty where the status says everything.
    pub message: &'static str,
    /// The time of the reading, as with `TSE` = -2; of points that no gauge measures: when the value changed.
    pub at: Micros,
}

/// A sample with its meta data: what a protocol encodes.
#[derive(Clone, Debug)]
pub struct Answer<'a> {
    /// The sample.
    pub sample: Sample,
    /// Its meta data.
    pub meta: Cow<'a, Meta>,
}

/// The words of the statuses of EPICS, by number (menuAlarmStat of EPICS base).
pub const STATUS_WORDS: [&str; 22] = [
    "NO_ALARM",
    "READ",
    "WRITE",
    "HIHI",
    "HIGH",
    "LOLO",
    "LOW",
    "STATE",
    "COS",
    "COMM",
    "TIMEOUT",
    "HWLIMIT",
    "CALC",
    "SCAN",
    "LINK",
    "SOFT",
    "BAD_SUB",
    "UDF",
    "DISABLE",
    "SIMM",
    "READ_ACCESS",
    "WRITE_ACCESS",
];

/// The words of the severities of EPICS, by number (menuAlarmSevr of EPICS base).
pub const SEVERITY_WORDS: [&str; 4] = ["NO_ALARM", "MINOR", "MAJOR", "INVALID"];

/// The beginning of a text, up to `max` octets and no half character.
#[must_use]
pub fn cut(text: &str, max: usize) -> &str {
    let end = (0..=max.min(text.len())).rev().find(|end| text.is_char_boundary(*end)).unwrap_or_default();
    text.get(..end).unwrap_or_default()
}

/// A number as EPICS writes it with `%.*e`: at least two digits of the exponent.
#[must_use]
pub fn exponential(number: f64, decimals: usize) -> String {
    if !number.is_finite() {
        return format!("{number}").to_lowercase();
    }
    let text = format!("{number:.decimals$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let (sign, digits) = exponent.strip_prefix('-').map_or(('+', exponent), |digits| ('-', digits));
    format!("{mantissa}e{sign}{digits:0>2}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_that_is_absent_raises_no_alarm() {
        for value in [-1e300, 0.0, 1e300, f64::NAN, f64::INFINITY] {
            assert_eq!(AlarmLimits::NONE.alarm(value), None);
        }
        let limits = AlarmLimits { high_high: 10.0, high: 5.0, low: 2.0, low_low: 1.0 };
        let alarms = [10.0, 5.0, 3.0, 2.0, 1.0].map(|value| limits.alarm(value).map(|(_, status)| status));
        assert_eq!(
            alarms,
            [Some(EpicsStatus::HiHi), Some(EpicsStatus::High), None, Some(EpicsStatus::Low), Some(EpicsStatus::LoLo)]
        );
    }

    #[test]
    fn a_number_has_two_digits_of_its_exponent() {
        assert_eq!(
            [5.2e-6, 1.0, 1013.25, 1e-100, f64::NAN].map(|number| exponential(number, 2)),
            ["5.20e-06", "1.00e+00", "1.01e+03", "1.00e-100", "nan"]
        );
    }

    #[test]
    fn a_text_is_cut_between_characters() {
        assert_eq!((cut("Überdruck", 1), cut("abc", 2), cut("abc", 39)), ("", "ab", "abc"));
    }
}
