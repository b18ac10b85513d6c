//! Converts values between text and the octets of a record.
//!
//! A pressure is a number in the present unit of the device; a pressure in another unit is converted. Numbers that the
//! manual names are printed and accepted by name.

use super::names::{NamedParameter, key};
use profivac_devices::model::{
    Codes, Counts, DataType, LengthError, Model, NumberType, PressureFormat, RawValue, Role, Row, Scale, Unit,
};
use std::fmt;
use std::ops::RangeInclusive;

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number; also a Boolean or a code.
    Integer(i64),
    /// A number; a pressure in the present unit of the device.
    Number(f64),
    /// Text without the blanks at its end.
    Text(String),
    /// A string of octets, an array or a record.
    Octets(Vec<u8>),
}

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
            Self::BecomesZero => f.write_str(", which is so small that the gauge would hold 0"),
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

/// The limits of a measuring range also belong to it after a conversion to a 32-bit float of another unit, and a number that is
/// whole in one unit is whole after the conversion from another.
const SLACK: f64 = 1e-6;

/// The values that a parameter accepts.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Expected {
    /// One of the names of a code table.
    OneOf(Vec<&'static str>),
    /// A whole number in a range, limits included.
    Range(i64, i64),
    /// A Boolean.
    Boolean,
    /// A pressure with its unit.
    Pressure {
        /// A pressure that the gauge accepts, in its present unit: `1500 mbar`.
        example: String,
        /// How the device writes its pressures.
        number: NumberType,
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
            Self::Boolean => f.write_str("true or false"),
            Self::Pressure { example, number } => {
                let numbers = match number {
                    NumberType::Float => "0 or more",
                    NumberType::Integer => "0 to 65535 in whole numbers",
                };
                write!(f, "a pressure of {numbers} with its unit, such as '{example}'")
            }
            Self::Number => f.write_str("a number"),
            Self::Text(length) => write!(f, "1 to {length} ASCII characters"),
            Self::Octets(length) => write!(f, "{length} octets in hexadecimal digits"),
        }
    }
}

/// Formats and parses the values of one parameter of one device.
#[derive(Clone, Copy, Debug)]
pub struct ValueFormat<'a> {
    /// The parameter.
    pub named: &'a NamedParameter,
    /// The model of the device.
    pub model: &'static Model,
    /// The present unit of its pressures.
    pub unit: Option<&'static Unit>,
}

impl Value {
    /// Decodes the octets of a record.
    ///
    /// ```
    /// use profivac_client::values::Value;
    /// use profivac_devices::model::DataType;
    ///
    /// assert_eq!(Value::decode(DataType::Uint8, &[4])?, Value::Integer(4));
    /// let error = Value::decode(DataType::Uint8, &[0, 4]).unwrap_err();
    /// assert_eq!(error.to_string(), "expected 1 octet of UINT8, found 2");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`LengthError`] if no value of this type has this number of octets.
    pub fn decode(data_type: DataType, octets: &[u8]) -> Result<Self, LengthError> {
        Ok(match data_type.raw(octets)? {
            #[expect(clippy::cast_precision_loss, reason = "a word")]
            RawValue::Integer(integer) if data_type == DataType::ByType => Self::Number(integer as f64),
            RawValue::Integer(integer) => Self::Integer(integer),
            RawValue::Float(float) => Self::Number(float.into()),
            RawValue::Text(text) => Self::Text(String::from_utf8_lossy(text).trim_end_matches(['\0', ' ']).to_owned()),
            RawValue::Octets(octets) => Self::Octets(octets.to_vec()),
        })
    }
}

/// Octets as hexadecimal digits.
///
/// ```
/// assert_eq!(profivac_client::values::hex(&[0x13, 0x08]), "13 08");
/// ```
#[must_use]
pub fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ")
}

/// A number in its shortest form, with an exponent if it would be long.
///
/// ```
/// use profivac_client::values::format_number;
///
/// assert_eq!((format_number(0.125), format_number(5e-10)), ("0.125".to_owned(), "5e-10".to_owned()));
/// ```
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "it came as a float of 32 bits")]
pub fn format_number(number: f64) -> String {
    let number = number as f32;
    let plain = number == 0.0 || (0.01..100_000.0).contains(&number.abs());
    if plain { number.to_string() } else { format!("{number:e}") }
}

impl ValueFormat<'_> {
    const fn row(&self) -> &'static Row {
        self.named.parameter.row
    }

    /// The value as text.
    #[must_use]
    pub fn format(&self, value: &Value) -> String {
        match value {
            Value::Integer(number) => self.format_integer(*number),
            Value::Number(it) => match (self.row().data_type, self.unit) {
                (DataType::ByType, Some(unit)) => format!("{} {}", format_number(*it), unit.name),
                _ => self.name_of_float(*it).unwrap_or_else(|| format_number(*it)),
            },
            Value::Text(text) => text.clone(),
            Value::Octets(octets) => match (octets.as_slice(), self.row().codes.is_command()) {
                ([command, value], true) => {
                    self.name_of(u16::from_be_bytes([*command, *value]).into()).unwrap_or_else(|| hex(octets))
                }
                _ => hex(octets),
            },
        }
    }

    /// The name of a number in the code table.
    fn name_of(&self, number: i64) -> Option<String> {
        self.row().codes.code(number).map(|code| code.name.to_owned())
    }

    /// BG 5530 has a float that contains a code.
    fn name_of_float(&self, number: f64) -> Option<String> {
        self.name_of(whole_number(number)?)
    }

    fn format_integer(&self, number: i64) -> String {
        match self.row().codes {
            Codes::Bits(bits) => {
                let set: Vec<_> =
                    bits.iter().filter(|(bit, _)| number >> bit & 1 == 1).map(|(_, name)| *name).collect();
                if set.is_empty() { "none".to_owned() } else { set.join(", ") }
            }
            Codes::Units => u16::try_from(number)
                .ok()
                .and_then(|code| self.model.unit(code))
                .map_or_else(|| number.to_string(), |unit| unit.name.to_owned()),
            Codes::Version => version(number).unwrap_or_else(|| number.to_string()),
            _ => self.name_of(number).unwrap_or_else(|| match self.row().data_type {
                DataType::Boolean => match number {
                    0 => "false".to_owned(),
                    // PROFIBUS writes FF, the manuals write 1: errata-bpg-bcg-tpg 26.
                    1 | 0xFF => "true".to_owned(),
                    _ => number.to_string(),
                },
                _ => number.to_string(),
            }),
        }
    }

    /// Parses a value. `number` is how the device writes its pressures. A pressure needs its unit, in any unit of the device.
    ///
    /// ```
    /// use profivac_client::names::{ParameterNames, Target};
    /// use profivac_client::values::ValueFormat;
    /// use profivac_devices::catalog::model_named;
    /// use profivac_devices::model::NumberType;
    ///
    /// let model = model_named("bcg450").ok_or("no such model")?;
    /// let names = ParameterNames::of(model);
    /// let Target::Parameter(named) = names.find(model.name, "pirani.safe-value")? else { return Ok(()) };
    /// let format = ValueFormat { named, model, unit: model.unit_named("mbar") };
    /// assert_eq!(format.parse("12.5 Pa", NumberType::Float)?, 0.125_f32.to_be_bytes());
    /// assert!(format.parse("12.5", NumberType::Float).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ValueError`] with the accepted values.
    pub fn parse(&self, text: &str, number: NumberType) -> Result<Vec<u8>, ValueError> {
        let text = text.trim();
        let octets = match self.row().data_type {
            DataType::Boolean | DataType::Uint8 | DataType::Int8 => self.integer(text).map(|it| low(it, 1)),
            DataType::Uint16 | DataType::Int16 => self.integer(text).map(|it| low(it, 2)),
            DataType::Uint32 | DataType::Int32 => self.integer(text).map(|it| low(it, 4)),
            DataType::Float => self.float(text),
            DataType::ByType => {
                return self.pressure(text, number).map_err(|problem| self.value_error(text, number, problem));
            }
            DataType::Visible(length) => visible(text, length.into()),
            DataType::OctetString(length) | DataType::Array(length) | DataType::Record(length) => {
                self.command(text).or_else(|| octets(text, length.into()))
            }
        };
        octets.ok_or_else(|| self.value_error(text, number, ValueProblem::NotAccepted))
    }

    pub(crate) fn value_error(&self, text: &str, number: NumberType, problem: ValueProblem) -> ValueError {
        ValueError { expected: self.expected(number), received: text.to_owned(), problem }
    }

    /// Whether a value is a pressure outside the measuring range of the gauge. 0 is inside: the manuals define it as a Safe
    /// Value (tira41d1 3.2.2.8), and a trip point of 0 is never reached. Without a range in the tables or a known unit, nothing is
    /// outside.
    #[must_use]
    pub fn beyond_range(&self, value: &Value) -> Option<BeyondRange> {
        let (Value::Number(number), DataType::ByType) = (value, self.row().data_type) else { return None };
        let range = self.range_in_unit()?;
        let (lowest, highest) = (*range.start(), *range.end());
        let is_inside = *number == 0.0 || (lowest * (1.0 - SLACK)..=highest * (1.0 + SLACK)).contains(number);
        let text = |number: f64| self.format(&Value::Number(number));
        (!is_inside).then(|| BeyondRange { given: text(*number), lowest: text(lowest), highest: text(highest) })
    }

    /// The measuring range in the present unit of the device; for a difference of pressures from 0 to the highest pressure.
    fn range_in_unit(&self) -> Option<RangeInclusive<f64>> {
        let (unit, place) = (self.unit?, self.named.parameter.place);
        let range = self.model.measuring_range_at(place)?;
        let is_difference = self.row().role == Some(Role::PressureDifference);
        let format = self.pressure_format(unit)?;
        let lowest = if is_difference { 0.0 } else { format.number_from_pa(range.lowest_pa) };
        Some(lowest..=format.number_from_pa(range.highest_pa))
    }

    /// The format of a pressure in a unit; `None` for COUNTS without a scale.
    fn pressure_format(&self, unit: &'static Unit) -> Option<PressureFormat> {
        pressure_format(self.model, self.named, unit, NumberType::Float)
    }

    /// The values that the parameter accepts.
    #[must_use]
    pub fn expected(&self, number: NumberType) -> Expected {
        let row = self.row();
        let names = || row.codes.codes().iter().map(|code| code.name).collect();
        match (&row.codes, row.data_type) {
            (Codes::Names(_) | Codes::Commands(_) | Codes::BitCommands(_), _) => Expected::OneOf(names()),
            (Codes::Units, _) => Expected::OneOf(self.model.units.iter().map(|unit| unit.name).collect()),
            (Codes::Range(low, high), _) => Expected::Range(*low, *high),
            (_, DataType::Boolean) => Expected::Boolean,
            (_, DataType::ByType) => Expected::Pressure { example: self.example(), number },
            (_, DataType::Float) => Expected::Number,
            (_, DataType::Visible(length)) => Expected::Text(length),
            (_, DataType::OctetString(length) | DataType::Array(length) | DataType::Record(length)) => {
                Expected::Octets(length)
            }
            _ => self.range().map_or(Expected::Number, |(low, high)| Expected::Range(low, high)),
        }
    }

    /// A pressure that the gauge accepts: the highest of its range.
    fn example(&self) -> String {
        match (self.range_in_unit(), self.unit) {
            (Some(range), _) => self.format(&Value::Number(*range.end())),
            (None, Some(unit)) => format!("1 {}", unit.name),
            (None, None) => "1 mbar".to_owned(),
        }
    }

    /// The range of the integers.
    const fn range(&self) -> Option<(i64, i64)> {
        Some(match (&self.row().codes, self.row().data_type) {
            (Codes::Range(low, high), _) => (*low, *high),
            (_, DataType::Boolean) => (0, 1),
            (_, DataType::Uint8) => (0, u8::MAX as i64),
            (_, DataType::Int8) => (i8::MIN as i64, i8::MAX as i64),
            (_, DataType::Uint16) => (0, u16::MAX as i64),
            (_, DataType::Int16) => (i16::MIN as i64, i16::MAX as i64),
            (_, DataType::Uint32) => (0, u32::MAX as i64),
            (_, DataType::Int32) => (i32::MIN as i64, i32::MAX as i64),
            _ => return None,
        })
    }

    /// A name of the code table, or a number in the range.
    fn integer(&self, text: &str) -> Option<i64> {
        let row = self.row();
        if let Some(code) = self.code(text) {
            return Some(code);
        }
        let number = match key(text).as_str() {
            "true" | "on" | "yes" if row.data_type == DataType::Boolean => 1,
            "false" | "off" | "no" if row.data_type == DataType::Boolean => 0,
            _ => whole(text)?,
        };
        let (low, high) = self.range()?;
        let known = match row.codes {
            // A combination of commands.
            Codes::BitCommands(codes) => number & !codes.iter().fold(0, |all, code| all | i64::from(code.number)) == 0,
            Codes::Names(_) | Codes::Commands(_) => row.codes.code(number).is_some(),
            Codes::Units => u16::try_from(number).is_ok_and(|code| self.model.unit(code).is_some()),
            _ => true,
        };
        (known && (low..=high).contains(&number)).then_some(number)
    }

    /// The number with this name.
    fn code(&self, text: &str) -> Option<i64> {
        if self.row().codes == Codes::Units {
            return self.model.unit_named(text).map(|unit| unit.code.into());
        }
        let code = self.row().codes.codes().iter().find(|code| key(code.name) == key(text))?;
        Some(code.number.into())
    }

    fn command(&self, text: &str) -> Option<Vec<u8>> {
        let number = self.code(text)?;
        Some(low(number, 2))
    }

    #[expect(clippy::cast_possible_truncation, reason = "checked, and a float of 32 bits has no more digits")]
    fn float(&self, text: &str) -> Option<Vec<u8>> {
        let number = match (self.code(text), self.row().codes.codes()) {
            (Some(code), _) => code as f64,
            (None, []) => text.parse().ok()?,
            // The code table restricts the numbers.
            (None, _) => text.parse().ok().filter(|number| self.name_of_float(*number).is_some())?,
        };
        let float = number as f32;
        float.is_finite().then(|| float.to_be_bytes().to_vec())
    }

    /// Parses `1e-3 mbar` in any unit of the device.
    fn pressure(&self, text: &str, number: NumberType) -> Result<Vec<u8>, ValueProblem> {
        let end = text.find(char::is_whitespace).unwrap_or_else(|| {
            text.char_indices()
                .find(|(at, it)| it.is_ascii_alphabetic() && !is_exponent(text, *at))
                .map_or(text.len(), |(at, _)| at)
        });
        let (digits, unit) = text.split_at(end);
        let value: f64 = digits.parse().map_err(|_| ValueProblem::NotAccepted)?;
        let value = match unit.trim() {
            "" if !is_writable_number(value) => return Err(ValueProblem::NotAccepted),
            "" => {
                let example = self.unit.map(|unit| format!("{digits} {}", unit.name));
                return Err(ValueProblem::NoUnit { example });
            }
            unit => {
                let units = || self.model.units.iter().map(|unit| unit.name).collect();
                let unit = self.model.unit_named(unit).ok_or_else(|| ValueProblem::UnknownUnit { units: units() })?;
                self.converted(value, unit)?
            }
        };
        self.encode_pressure(value, number)
    }

    /// The octets of a pressure in the present unit of the device, if they hold this number. A number other than 0 never
    /// becomes 0, which is a Safe Value and a trip point of its own meaning.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked")]
    pub(crate) fn encode_pressure(&self, value: f64, number: NumberType) -> Result<Vec<u8>, ValueProblem> {
        if !is_writable_number(value) {
            return Err(ValueProblem::NotAccepted);
        }
        let (held, octets) = match number {
            NumberType::Float => (f64::from(value as f32), (value as f32).to_be_bytes().to_vec()),
            NumberType::Integer => {
                let whole = value.round().min(f64::from(u16::MAX));
                (whole, (whole as u16).to_be_bytes().to_vec())
            }
        };
        match (held - value).abs() <= SLACK * value {
            true => Ok(octets),
            false if held == 0.0 => Err(ValueProblem::BecomesZero),
            false => Err(ValueProblem::NotAccepted),
        }
    }

    /// Converts a number to the unit of the device.
    fn converted(&self, value: f64, from: &'static Unit) -> Result<f64, ValueProblem> {
        let not_convertible = || ValueProblem::NotConvertible { unit: self.unit.map(|unit| unit.name) };
        let to = self.unit.ok_or_else(not_convertible)?;
        match (from.scale, to.scale) {
            _ if from == to => Ok(value),
            (Scale::PerMbar(from), Scale::PerMbar(to)) => Ok(value / from * to),
            _ => {
                let format = |unit| self.pressure_format(unit).ok_or_else(not_convertible);
                let pa = format(from)?.pa_from_number(value).ok_or(ValueProblem::NotAccepted)?;
                Ok(format(to)?.number_from_pa(pa))
            }
        }
    }
}

/// The format of the pressures of a parameter in a unit. `None` for COUNTS without a scale in the tables, and for the COUNTS of
/// a difference, which depend on the point it starts from.
pub(crate) fn pressure_format(
    model: &Model,
    named: &NamedParameter,
    unit: &'static Unit,
    number: NumberType,
) -> Option<PressureFormat> {
    let is_difference = named.parameter.row.role == Some(Role::PressureDifference);
    let counts = match unit.scale {
        Scale::PerMbar(_) => Counts::Linear { per_mbar: 1.0 },
        Scale::Counts if is_difference => return None,
        Scale::Counts => model.counts_at(named.parameter.place)?,
    };
    Some(PressureFormat { unit, number, counts, max_integer: u16::MAX })
}

/// Whether a number of this size can be written as a pressure: 0 too, as a Safe Value; NaN cannot.
fn is_writable_number(number: f64) -> bool {
    (0.0..=f64::from(f32::MAX)).contains(&number)
}

/// The code that a float holds. `None` for a number that is not whole, or greater than any code.
#[expect(clippy::cast_possible_truncation, reason = "whole and small")]
pub(crate) fn whole_number(number: f64) -> Option<i64> {
    (number.fract() == 0.0 && number.abs() < 1e6).then_some(number as i64)
}

/// Whether the letter at this position is the exponent sign of a number.
fn is_exponent(text: &str, at: usize) -> bool {
    let (before, rest) = text.split_at(at);
    rest.starts_with(['e', 'E'])
        && before.ends_with(|it: char| it.is_ascii_digit() || it == '.')
        && rest[1..].trim_start_matches(['-', '+']).starts_with(|it: char| it.is_ascii_digit())
}

fn whole(text: &str) -> Option<i64> {
    match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

fn low(number: i64, octets: usize) -> Vec<u8> {
    number.to_be_bytes().iter().skip(8 - octets).copied().collect()
}

fn visible(text: &str, length: usize) -> Option<Vec<u8>> {
    let fits = text.is_ascii() && !text.is_empty() && text.len() <= length;
    fits.then(|| text.bytes().chain(std::iter::repeat(b' ')).take(length).collect())
}

fn octets(text: &str, length: usize) -> Option<Vec<u8>> {
    let digits: String = text.split_whitespace().collect();
    let pairs = digits.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).ok().filter(|pair| pair.len() == 2));
    let octets: Option<Vec<u8>> = pairs.map(|pair| u8::from_str_radix(pair?, 16).ok()).collect();
    octets.filter(|octets| octets.len() == length)
}

/// The version in the nibbles of a number: [`Codes::Version`]. `None` for nibbles that are none.
fn version(number: i64) -> Option<String> {
    let digits = u32::try_from(number).ok()? >> 8;
    let letter = u8::try_from(number & 0xFF).ok().filter(|letter| (1..=15).contains(letter))?;
    let digits = format!("{digits:06X}");
    let is_decimal = digits.bytes().all(|digit| digit.is_ascii_digit());
    is_decimal.then(|| format!("{digits}-{}", char::from(b'A' + letter - 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::names::{ParameterNames, Target};
    use profivac_devices::catalog::model_named;

    fn with<T>(device: &str, target: &str, unit: &str, ask: impl FnOnce(&ValueFormat<'_>) -> T) -> T {
        let model = model_named(device).unwrap();
        let names = ParameterNames::of(model);
        let Ok(Target::Parameter(named)) = names.find(model.name, target) else { panic!("{target}") };
        ask(&ValueFormat { named, model, unit: model.unit_named(unit) })
    }

    fn parsed(device: &str, target: &str, text: &str) -> String {
        with(device, target, "mbar", |meaning| match meaning.parse(text, NumberType::Float) {
            Ok(octets) => hex(&octets),
            Err(error) => error.to_string(),
        })
    }

    fn shown(device: &str, target: &str, octets: &[u8]) -> String {
        with(device, target, "mbar", |meaning| meaning.format(&Value::decode(meaning.row().data_type, octets).unwrap()))
    }

    #[test]
    fn values_are_formatted_with_names_and_units() {
        for (device, target, octets, text) in [
            ("bcg450", "device.device-state", &[4][..], "EXECUTING"),
            ("bcg450", "pirani.process-value", &5.5e-3f32.to_be_bytes(), "5.5e-3 mbar"),
            ("bcg450", "pirani.full-scale", &1000f32.to_be_bytes(), "1000 mbar"),
            ("bcg450", "pirani.process-value", &[0x61, 0xA8], "25000 mbar"),
            ("bcg450", "pirani.data-units", &1308u16.to_be_bytes(), "mbar"),
            ("pcg550", "pirani.data-unit", &0x1309u16.to_be_bytes(), "Pascal"),
            ("bcg450", "pirani.data-type", &[8], "float"),
            ("bcg450", "pirani.reading-valid", &[1], "true"),
            ("bcg450", "device.serial-number", b"4711      ", "4711"),
            (
                "bcg450",
                "device.exception-status",
                &[0xA1],
                "alarm-device-common, warning-device-specific, expanded-format",
            ),
            ("bcg450", "one-of-n.one-of-n-status-extension", &[0], "none"),
            ("bcg450", "ba.emission-current", &0.025f32.to_be_bytes(), "0.025"),
            ("img400", "channel.1/emission-current", &5f32.to_be_bytes(), "45-mA"),
            ("img400", "device.device-state", &[100], "INIT"),
            ("bcg450", "device.device-exception-detail-alarm-4-5", &[1, 0xFE], "01 FE"),
            // The examples of the manual, and numbers that are no version.
            ("tpg500", "device.program-version", &[0x50, 0x97, 0x31, 0x01], "509731-A"),
            ("tpg300", "device.program-version", &[0x50, 0x97, 0x80, 0x06], "509780-F"),
            ("tpg300", "device.program-version", &[0x50, 0x97, 0x80, 0x00], "1352105984"),
            ("tpg300", "device.program-version", &[0x50, 0x97, 0x80, 0x16], "1352106006"),
            ("tpg300", "device.program-version", &[0x5A, 0x97, 0x80, 0x06], "1519878150"),
        ] {
            assert_eq!(shown(device, target, octets), text, "{device} {target}");
        }
    }

    #[test]
    fn values_are_parsed_by_name_number_and_unit() {
        for (device, target, text, octets) in [
            ("bcg450", "pirani.safe-state", "use-safe-value", "03"),
            ("bcg450", "pirani.safe-state", "Full Scale", "01"),
            ("bcg450", "pirani.safe-state", "2", "02"),
            ("bcg450", "pirani.safe-value", "0.125 mbar", "3E 00 00 00"),
            ("bcg450", "pirani.safe-value", "12.5 Pascal", "3E 00 00 00"),
            ("bcg450", "pirani.safe-value", "12.5Pa", "3E 00 00 00"),
            ("bcg450", "pirani.safe-value", "1.25e-1mbar", "3E 00 00 00"),
            ("bcg450", "pirani.data-units", "Torr", "05 15"),
            ("bcg450", "pirani.data-units", "1308", "05 1C"),
            ("pcg550", "pirani.data-unit", "0x1308", "13 08"),
            ("bcg450", "ba.hot-cathode-block-state-command", "degas-on", "01 01"),
            ("bcg450", "ba.hot-cathode-block-state-command", "01 00", "01 00"),
            ("pcg550", "trip-point.1/low-trip-enable", "on", "01"),
            ("img400", "channel.1/emission-current", "45-mA", "40 A0 00 00"),
            ("img400", "reset-error-condition", "reset-all", "80"),
        ] {
            assert_eq!(parsed(device, target, text), octets, "{device} {target} {text}");
        }
    }

    #[test]
    fn a_text_that_is_no_value_is_an_error_with_the_accepted_ones() {
        for (device, target, text, sentence) in [
            ("bcg450", "pirani.safe-state", "never", "one of zero, full-scale, hold-last-value, use-safe-value"),
            ("bcg450", "pirani.safe-state", "4", "one of zero, full-scale, hold-last-value, use-safe-value"),
            ("bcg450", "pirani.safe-value", "-1 mbar", PRESSURE),
            ("bcg450", "pirani.safe-value", "-1", PRESSURE),
            ("bcg450", "pirani.safe-value", "nan mbar", PRESSURE),
            ("bcg450", "pirani.safe-value", "inf mbar", PRESSURE),
            ("bcg450", "pirani.safe-value", "much", PRESSURE),
            ("bcg450", "setpoint-a.percentage-of-atmosphere", "1401", "a number from 10 to 1400"),
            ("bcg450", "pirani.data-units", "psi", "one of COUNTS, Torr, Micron, mbar, Pascal"),
            ("pcg550", "trip-point.1/low-trip-enable", "2", "true or false"),
            (
                "bcg450",
                "device.device-block-state-command",
                "256",
                "one of inactive, reset, abort, recover, execute, stop, perform-diagnostic",
            ),
            ("bcg450", "device.device-configuration", &"x".repeat(51), "1 to 50 ASCII characters"),
        ] {
            let said = parsed(device, target, text);
            assert_eq!(said, format!("expected {sentence}, got {text:?}"));
        }
    }

    const PRESSURE: &str = "a pressure of 0 or more with its unit, such as '1500 mbar'";

    #[test]
    fn a_pressure_without_a_unit_is_an_error_that_shows_the_unit_of_the_gauge() {
        let sentence = |device, unit, target, text| {
            with(device, target, unit, |format| format.parse(text, NumberType::Float).unwrap_err().to_string())
        };
        assert_eq!(
            sentence("bcg450", "mbar", "pirani.safe-value", "0.5"),
            format!(
                "expected {PRESSURE}, got \"0.5\" without a unit; in the present unit of the gauge it is '0.5 mbar'"
            )
        );
        let torr = sentence("pcg550", "Torr", "trip-point.1/high-trip-point", "1e-3");
        assert!(
            torr.ends_with("got \"1e-3\" without a unit; in the present unit of the gauge it is '1e-3 Torr'"),
            "{torr}"
        );
        assert_eq!(
            sentence("bcg450", "mbar", "pirani.safe-value", "0.2 bananas"),
            format!(
                "expected {PRESSURE}, got \"0.2 bananas\"; the units of the gauge are COUNTS, Torr, Micron, mbar, Pascal"
            )
        );
        let unknown = sentence("tpg300", "none of them", "relay.1/upper-threshold", "1");
        assert!(unknown.ends_with("such as '1 mbar', got \"1\" without a unit"), "{unknown}");
    }

    fn beyond(device: &str, unit: &str, target: &str, text: &str) -> Option<String> {
        with(device, target, unit, |format| {
            let octets = format.parse(text, NumberType::Float).unwrap();
            let value = Value::decode(DataType::ByType, &octets).unwrap();
            format.beyond_range(&value).map(|error| error.to_string())
        })
    }

    #[test]
    fn a_pressure_outside_the_measuring_range_is_reported_with_the_range_in_the_unit_of_the_gauge() {
        for (device, unit, target, text, sentence) in [
            (
                "bcg450",
                "mbar",
                "pirani.safe-value",
                "1e9 mbar",
                Some("1e9 mbar is outside the measuring range, which is 5e-10 mbar to 1500 mbar"),
            ),
            (
                "bcg450",
                "Pascal",
                "pirani.safe-value",
                "1e9 mbar",
                Some("1e11 Pascal is outside the measuring range, which is 5e-8 Pascal to 1.5e5 Pascal"),
            ),
            (
                "bcg450",
                "mbar",
                "pirani.safe-value",
                "1e-13 mbar",
                Some("1e-13 mbar is outside the measuring range, which is 5e-10 mbar to 1500 mbar"),
            ),
            // tira41d1 3.2.5.1: the end of the range means "never", and Zero is a Safe Value.
            ("bcg450", "mbar", "pirani.safe-value", "1500 mbar", None),
            ("bcg450", "Torr", "pirani.safe-value", "1500 mbar", None),
            ("bcg450", "mbar", "pirani.safe-value", "0 mbar", None),
            ("bcg450", "counts", "pirani.safe-value", "1500 mbar", None),
            // One range for all parts of a combined gauge.
            ("bcg450", "mbar", "pirani.safe-value", "1e-8 mbar", None),
            ("pcg550", "mbar", "trip-point.1/high-trip-point", "1500 mbar", None),
            (
                "pcg550",
                "mbar",
                "trip-point.2/low-trip-point",
                "1501 mbar",
                Some("1501 mbar is outside the measuring range, which is 5e-5 mbar to 1500 mbar"),
            ),
            // A difference may be smaller than every pressure.
            ("pcg550", "mbar", "trip-point.1/low-trip-point-hysteresis", "1e-9 mbar", None),
            (
                "pcg550",
                "mbar",
                "trip-point.1/low-trip-point-hysteresis",
                "2000 mbar",
                Some("2000 mbar is outside the measuring range, which is 0 mbar to 1500 mbar"),
            ),
            (
                "img400",
                "hPa",
                "channel.3/safe-value",
                "1e-5 hPa",
                Some("1e-5 hPa is outside the measuring range, which is 8e-4 hPa to 1000 hPa"),
            ),
            // The tables of a controller have no range of the gauges that may be connected.
            ("tpg300", "mbar", "relay.1/upper-threshold", "1e9 mbar", None),
        ] {
            assert_eq!(beyond(device, unit, target, text).as_deref(), sentence, "{device} {target} {text}");
        }
    }

    /// COUNTS of a difference depend on the trip point: a number from the scale of pressures would be false.
    #[test]
    fn a_hysteresis_is_not_converted_to_counts() {
        let parse = |text| {
            with("pcg550", "trip-point.1/low-trip-point-hysteresis", "counts", |format| {
                format.parse(text, NumberType::Integer).map_err(|error| error.problem)
            })
        };
        assert_eq!(parse("1 mbar"), Err(ValueProblem::NotConvertible { unit: Some("COUNTS") }));
        assert_eq!(parse("100 counts").unwrap(), [0, 100]);
    }

    #[test]
    fn counts_are_converted_on_the_scale_of_the_part() {
        let octets = |device, target, text| {
            with(device, target, "counts", |meaning| {
                meaning.parse(text, NumberType::Integer).map(|octets| hex(&octets))
            })
        };
        // 10^(COUNTS/2000 - 12.5) mbar
        assert_eq!(octets("bcg450", "pirani.safe-value", "1 mbar").unwrap(), "61 A8");
        assert_eq!(octets("bcg450", "pirani.safe-value", "25000 counts").unwrap(), "61 A8");
        assert!(octets("bcg450", "pirani.safe-value", "25000.5 counts").is_err());
        assert!(octets("bcg450", "pirani.safe-value", "65536 counts").is_err());
    }

    #[test]
    fn every_formatted_name_is_parsed() {
        for model in profivac_devices::catalog::MODELS {
            let names = ParameterNames::of(model);
            for named in names.all() {
                let meaning = ValueFormat { named, model, unit: model.unit_named("mbar") };
                for code in named.parameter.row.codes.codes() {
                    let octets = meaning.parse(code.name, NumberType::Float).unwrap();
                    let value = Value::decode(named.parameter.row.data_type, &octets).unwrap();
                    assert_eq!(meaning.format(&value), code.name, "{named}");
                }
            }
        }
    }
}
