//! Points and their values.

use crate::signal::{Kind, Signal, SubjectKind};
use crate::state::State;
use profivac_recorder::Micros;
use profivac_recorder::export::seven_digits;
use std::fmt;
use std::sync::Arc;

/// What a point belongs to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Subject {
    /// The station.
    Station,
    /// The segment of this name.
    Segment(Arc<str>),
    /// The gauge or controller of this name.
    Gauge(Arc<str>),
    /// A reading of a gauge.
    Reading {
        /// The name of the gauge.
        gauge: Arc<str>,
        /// The instance of the gauge or the channel of the controller; `None` if there is only one.
        channel: Option<u8>,
        /// The name under which it is recorded.
        series: Arc<str>,
    },
    /// A parameter of a gauge.
    Parameter {
        /// The name of the gauge.
        gauge: Arc<str>,
        /// The name by which the parameter is read: `trip-point.1/high-trip-point`.
        target: Arc<str>,
        /// The manual's name.
        name: Arc<str>,
    },
    /// The alarm of this name.
    Alarm(Arc<str>),
}

impl Subject {
    /// What it is.
    #[must_use]
    pub const fn kind(&self) -> SubjectKind {
        match self {
            Self::Station => SubjectKind::Station,
            Self::Segment(_) => SubjectKind::Segment,
            Self::Gauge(_) => SubjectKind::Gauge,
            Self::Reading { .. } => SubjectKind::Reading,
            Self::Parameter { .. } => SubjectKind::Parameter,
            Self::Alarm(_) => SubjectKind::Alarm,
        }
    }

    /// Its name in the station's file, with the channel of a controller; that of a parameter without its gauge; empty for the station.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Station => "",
            Self::Segment(name) | Self::Gauge(name) | Self::Alarm(name) => name,
            Self::Reading { series, .. } => series,
            Self::Parameter { target, .. } => target,
        }
    }

    /// The gauge to which it belongs.
    #[must_use]
    pub fn gauge(&self) -> Option<&str> {
        match self {
            Self::Gauge(gauge) | Self::Reading { gauge, .. } | Self::Parameter { gauge, .. } => Some(gauge),
            Self::Station | Self::Segment(_) | Self::Alarm(_) => None,
        }
    }
}

/// The values at which the alarms of a reading or of a point of a slave are raised, in the unit of its point: high priority outside, the
/// others inside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// The lowest limit of an alarm of high priority that is raised above it.
    pub high_high: Option<f64>,
    /// The lowest limit of another alarm that is raised above it.
    pub high: Option<f64>,
    /// The highest limit of another alarm that is raised below it.
    pub low: Option<f64>,
    /// The highest limit of an alarm of high priority that is raised below it.
    pub low_low: Option<f64>,
}

/// A point: what never or seldom changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// What it belongs to.
    pub subject: Subject,
    /// What it says.
    pub signal: Signal,
    /// The segment of its subject.
    pub segment: Option<Arc<str>>,
    /// The unit of its value; of an alarm's values the unit of its limit.
    pub unit: Option<&'static str>,
    /// The measuring range of a pressure in Pa, of its logarithm in decades; `None` if the manual has none.
    pub range: Option<(f64, f64)>,
    /// The limits of its alarms, of a pressure or of the number of a point of a slave.
    pub limits: Limits,
    /// The age in milliseconds from which it is stale; `None` unless it belongs to a reading.
    pub stale_after_ms: Option<u64>,
    /// Its gauge is virtual.
    pub is_simulated: bool,
    /// It is a parameter that the station writes, if it controls the gauge.
    pub is_writable: bool,
    /// Its number is a code, bits or another integer without a unit.
    pub is_whole: bool,
    /// The manufacturer of its gauge.
    pub vendor: Option<Arc<str>>,
    /// The point of a slave as the recorder knows it, of its number; `None` for all others.
    pub recorded: Option<Arc<profivac_recorder::Point>>,
}

/// The lowest pressure in Pa that a gauge without a known range may show. chosen: the low end of a cold cathode gauge at a controller.
const LOWEST_PA: f64 = 1e-9;

/// The highest one. chosen: the high end of a Pirani gauge at a controller.
const HIGHEST_PA: f64 = 1e5;

impl Point {
    /// The range over which a client shows its value: the measuring range, and for a reading of a gauge without a known range all the
    /// pressures that it may show.
    #[must_use]
    pub fn display_range(&self) -> Option<(f64, f64)> {
        let of_any_gauge = match self.signal {
            Signal::Pressure | Signal::CorrectedPressure => Some((LOWEST_PA, HIGHEST_PA)),
            Signal::PressureLog10 => Some((LOWEST_PA.log10(), HIGHEST_PA.log10())),
            _ => None,
        };
        self.range.or(of_any_gauge)
    }

    /// The decimals with which a client shows its number without an exponent, in the unit of the point.
    #[must_use]
    pub fn decimals(&self) -> u8 {
        self.decimals_in(1.0)
    }

    /// The same where a pressure is shown in a unit of this many pascals. The lower end of the range has two digits, because many clients
    /// show no exponent, and a pressure must not be 0.00 there. A whole number has none. chosen: microseconds, tenths of a percent.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    pub fn decimals_in(&self, unit_pa: f64) -> u8 {
        match (self.signal.kind(), self.unit) {
            (Kind::Float, Some("Pa")) => {
                let lowest = seven_digits(self.range.map_or(LOWEST_PA, |range| range.0) / unit_pa);
                (1.0 - lowest.log10().floor()).clamp(2.0, 15.0) as u8
            }
            (Kind::Float, _) if self.is_whole => 0,
            (Kind::Float, Some("s")) => 6,
            (Kind::Float, Some("%")) => 1,
            (Kind::Float, Some(_)) => 3,
            (Kind::Float, None) => 2,
            _ => 0,
        }
    }
}

/// A value.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Value {
    /// There is none.
    #[default]
    None,
    /// A floating-point number.
    Float(f64),
    /// A whole number.
    Integer(i64),
    /// True or false.
    Boolean(bool),
    /// A text.
    Text(Arc<str>),
    /// The position of a word in the words of its signal.
    Choice(u16),
    /// A time.
    Time(Micros),
}

impl Value {
    /// The number of a [`Value::Float`].
    #[must_use]
    pub const fn float(&self) -> Option<f64> {
        if let Self::Float(number) = self { Some(*number) } else { None }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => Ok(()),
            Self::Float(number) => write!(formatter, "{number:e}"),
            Self::Integer(number) => number.fmt(formatter),
            Self::Boolean(value) => value.fmt(formatter),
            Self::Text(text) => text.fmt(formatter),
            Self::Choice(number) => number.fmt(formatter),
            Self::Time(Micros(micros)) => micros.fmt(formatter),
        }
    }
}

/// The present value of a point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointValue {
    /// The value.
    pub value: Value,
    /// The state of the reading to which it belongs; `Ok` for points of other subjects.
    pub state: State,
    /// The time of the reading. For points that no gauge measures: when the value changed.
    pub at: Option<Micros>,
    /// How often value or state have changed. A gateway that has served version 3 and sees version 6 has missed two updates.
    pub version: u64,
}

impl PointValue {
    /// Whether the value is the end of a range in place of a measured number. A protocol without a quality beside the number leaves it
    /// out, as clients would take it for a pressure.
    #[must_use]
    pub const fn is_bound(&self) -> bool {
        matches!(self.value, Value::Float(_)) && !self.state.codes().is_measured
    }

    /// The number, if it is measured.
    #[must_use]
    pub const fn measured(&self) -> Option<f64> {
        if self.is_bound() { None } else { self.value.float() }
    }
}
