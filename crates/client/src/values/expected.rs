//! The values that a parameter accepts, and why a text is none of them.

use super::text::percent;
use std::fmt;

/// The text is no value of the parameter.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected {expected}, got {received:?}{problem}")]
pub struct ValueError {
    /// The accepted values.
    pub expected: Expected,
    /// The text.
    pub received: String,
    /// The defect of the text.
    pub problem: ValueProblem,
}

/// The defect of a text that is no value.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ValueProblem {
    /// It is none of the accepted values.
    NotAccepted,
    /// The end of the integers, as a gauge shows it for every higher pressure.
    EndOfIntegers,
    /// A pressure without its unit.
    NoUnit {
        /// The same number with the present unit of the gauge, if that is known.
        example: Option<String>,
    },
    /// A unit that the gauge does not have.
    UnknownUnit {
        /// Those that it has.
        units: Vec<&'static str>,
    },
    /// A percentage without its sign.
    NoPercentSign {
        /// The number.
        number: String,
    },
    /// The gauge would hold 0 in place of the pressure, which is another setting.
    BecomesZero,
    /// The gauge is set to a unit into which the pressure cannot be converted: COUNTS without a scale in the tables.
    NotConvertible {
        /// The present unit of the gauge, if that is known.
        unit: Option<&'static str>,
    },
}

impl fmt::Display for ValueProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAccepted => Ok(()),
            Self::EndOfIntegers => f.write_str(", which is the end of the integers and no value: write a pressure"),
            Self::BecomesZero => f.write_str(", which is so small that the gauge would hold 0"),
            Self::NoPercentSign { number } => write!(f, " without its sign; {number} percent is '{number} %'"),
            Self::NoUnit { example: Some(example) } => {
                write!(f, " without a unit; in the present unit of the gauge it is '{example}'")
            }
            Self::NoUnit { example: None } => f.write_str(" without a unit"),
            Self::UnknownUnit { units } => write!(f, "; the units of the gauge are {}", units.join(", ")),
            Self::NotConvertible { unit: Some(unit) } => {
                write!(f, ", which cannot be converted to {unit}, the present unit of the gauge")
            }
            Self::NotConvertible { unit: None } => {
                f.write_str(", which cannot be converted: the present unit of the gauge is not known")
            }
        }
    }
}

/// A pressure outside the measuring range of the gauge. The texts have the present unit of the gauge.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{given} is outside the measuring range, which is {lowest} to {highest}")]
pub struct BeyondRange {
    /// The pressure.
    pub given: String,
    /// The lowest pressure of the range; 0 for a difference of pressures.
    pub lowest: String,
    /// The highest pressure of the range.
    pub highest: String,
}

/// The values that a parameter accepts.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Expected {
    /// One of the names of a code table.
    OneOf(Vec<&'static str>),
    /// A whole number in a range, limits included.
    Range(i64, i64),
    /// A percentage in a range, limits included, in tenths of a percent.
    Percentage(i64, i64),
    /// A number in this unit, and the lowest and the highest one.
    Quantity {
        /// The unit.
        unit: &'static str,
        /// With their unit.
        limits: Option<(String, String)>,
    },
    /// A Boolean.
    Boolean,
    /// A pressure with its unit.
    Pressure {
        /// A pressure that the gauge accepts, in its present unit: `1500 mbar`.
        example: String,
        /// The highest number, where the device writes its pressures as integers.
        highest: Option<u16>,
    },
    /// A number.
    Number,
    /// ASCII text of at most this length.
    Text(u8),
    /// This number of octets.
    Octets(u8),
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OneOf(names) => write!(f, "one of {}", names.join(", ")),
            Self::Range(low, high) => write!(f, "a number from {low} to {high}"),
            Self::Percentage(low, high) => {
                write!(f, "a percentage from {} to {}, such as '50 %'", percent(*low), percent(*high))
            }
            Self::Quantity { unit, limits: None } => write!(f, "a number in {unit}"),
            Self::Quantity { limits: Some((low, high)), .. } => write!(f, "a number from {low} to {high}"),
            Self::Boolean => f.write_str("true or false"),
            Self::Pressure { example, highest: None } => {
                write!(f, "a pressure of 0 or more with its unit, such as '{example}'")
            }
            Self::Pressure { example, highest: Some(highest) } => write!(
                f,
                "a pressure of 0 to {highest} in whole numbers with its unit, such as '{example}' (for other pressures choose the data type \
                 float)"
            ),
            Self::Number => f.write_str("a number"),
            Self::Text(length) => write!(f, "up to {length} ASCII characters"),
            Self::Octets(length) => write!(f, "{length} octets in hexadecimal digits"),
        }
    }
}
