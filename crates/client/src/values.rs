//! Converts values between text and the octets of a record.
//!
//! A pressure is a number in the present unit of the device; a pressure in another unit is converted. Numbers that the
//! manual names are printed and accepted by name.

use super::names::{NamedParameter, key};
use profivac_devices::model::{
    Codes, DataType, LengthError, Model, NumberType, PressureFormat, RawValue, Row, Scale, Unit,
};
use std::fmt;

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

/// The parameter does not accept the text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected {expected}, got {received:?}")]
pub struct ValueError {
    /// The accepted values.
    pub expected: Expected,
    /// The text.
    pub received: String,
    /// The text is a number, but outside the accepted range.
    pub out_of_range: bool,
}

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
    /// A pressure. The unit is `None` while it is unknown.
    Pressure {
        /// The unit of the device.
        unit: Option<&'static str>,
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
            Self::Pressure { unit, number } => {
                let unit = unit.unwrap_or("the unit of the device");
                match number {
                    NumberType::Float => write!(f, "a pressure of 0 {unit} or more"),
                    NumberType::Integer => write!(f, "a pressure from 0 to 65535 {unit} in whole numbers"),
                }
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
#[must_use]
pub fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ")
}

/// A number in its shortest form, with an exponent if it would be long.
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
    #[expect(clippy::cast_possible_truncation, reason = "whole and small")]
    fn name_of_float(&self, number: f64) -> Option<String> {
        (number.fract() == 0.0 && number.abs() < 1e6).then(|| self.name_of(number as i64)).flatten()
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

    /// Parses a value. `number` is how the device writes its pressures.
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
            DataType::ByType => self.pressure(text, number),
            DataType::Visible(length) => visible(text, length.into()),
            DataType::OctetString(length) | DataType::Array(length) | DataType::Record(length) => {
                self.command(text).or_else(|| octets(text, length.into()))
            }
        };
        octets.ok_or_else(|| ValueError {
            expected: self.expected(number),
            received: text.to_owned(),
            out_of_range: text.split_whitespace().next().is_some_and(|number| number.parse::<f64>().is_ok()),
        })
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
            (_, DataType::ByType) => Expected::Pressure { unit: self.unit.map(|unit| unit.name), number },
            (_, DataType::Float) => Expected::Number,
            (_, DataType::Visible(length)) => Expected::Text(length),
            (_, DataType::OctetString(length) | DataType::Array(length) | DataType::Record(length)) => {
                Expected::Octets(length)
            }
            _ => self.range().map_or(Expected::Number, |(low, high)| Expected::Range(low, high)),
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

    /// Parses `1e-3` and `1e-3 mbar`, also in another unit of the device.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked")]
    fn pressure(&self, text: &str, number: NumberType) -> Option<Vec<u8>> {
        let end = text.find(char::is_whitespace).unwrap_or_else(|| {
            text.char_indices()
                .find(|(at, it)| it.is_ascii_alphabetic() && !is_exponent(text, *at))
                .map_or(text.len(), |(at, _)| at)
        });
        let (digits, unit) = text.split_at(end);
        let value: f64 = digits.parse().ok()?;
        let value = match unit.trim() {
            "" => value,
            unit => self.converted(value, self.model.unit_named(unit)?)?,
        };
        if !(value >= 0.0 && value <= f64::from(f32::MAX)) {
            return None;
        }
        match number {
            NumberType::Float => Some((value as f32).to_be_bytes().to_vec()),
            NumberType::Integer => {
                let whole = value.round();
                let fits = (whole - value).abs() < 1e-6 * value.max(1.0) && whole <= f64::from(u16::MAX);
                fits.then(|| (whole as u16).to_be_bytes().to_vec())
            }
        }
    }

    /// Converts a number to the unit of the device. COUNTS can be converted only for a part whose scale the tables give.
    fn converted(&self, value: f64, from: &'static Unit) -> Option<f64> {
        let to = self.unit?;
        match (from.scale, to.scale) {
            _ if from == to => Some(value),
            (Scale::PerMbar(from), Scale::PerMbar(to)) => Some(value / from * to),
            _ => {
                let format = |unit| {
                    Some(PressureFormat {
                        unit,
                        number: NumberType::Float,
                        counts: self.counts()?,
                        max_integer: u16::MAX,
                    })
                };
                Some(format(to)?.number_from_pa(format(from)?.pa_from_number(value)?))
            }
        }
    }

    /// The scale of the measuring part of the parameter.
    fn counts(&self) -> Option<profivac_devices::model::Counts> {
        let instance = match self.named.parameter.place {
            place if place.instance > 0 => place.instance,
            place => place.slot,
        };
        let facts = self.model.parts.iter().find(|facts| facts.part.instance == instance);
        facts.map(|facts| facts.counts)
    }
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
            ("bcg450", "pirani.safe-value", "0.125", "3E 00 00 00"),
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
    fn a_value_that_is_not_accepted_is_an_error_with_those_that_are() {
        for (device, target, text, sentence) in [
            ("bcg450", "pirani.safe-state", "never", "one of zero, full-scale, hold-last-value, use-safe-value"),
            ("bcg450", "pirani.safe-state", "4", "one of zero, full-scale, hold-last-value, use-safe-value"),
            ("bcg450", "pirani.safe-value", "-1", "a pressure of 0 mbar or more"),
            ("bcg450", "pirani.safe-value", "1 psi", "a pressure of 0 mbar or more"),
            ("bcg450", "pirani.safe-value", "nan", "a pressure of 0 mbar or more"),
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
            assert!(said.contains(&format!("expected {sentence}, got {text:?}")), "{said}");
        }
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
        assert_eq!(octets("bcg450", "pirani.safe-value", "25000").unwrap(), "61 A8");
        assert!(octets("bcg450", "pirani.safe-value", "25000.5").is_err());
        assert!(octets("bcg450", "pirani.safe-value", "65536").is_err());
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
