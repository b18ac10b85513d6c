//! Text to the octets of a record.

use super::{Expected, ValueError, ValueFormat, ValueProblem, rounded};
use crate::names::key;
use profivac_devices::model::{Codes, DataType, Length, NumberType, Quantity};

impl ValueFormat<'_> {
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
        if let Codes::PerMille(low, high) = self.row().codes {
            let octets = per_mille(text, low, high).map(|number| low_octets(number, 2));
            return octets.map_err(|problem| self.value_error(text, number, problem));
        }
        if let Codes::Quantity(quantity) = &self.row().codes {
            let octets = self.quantity(text, quantity);
            return octets.ok_or_else(|| self.value_error(text, number, ValueProblem::NotAccepted));
        }
        let octets = match self.row().data_type {
            DataType::Boolean | DataType::Uint8 | DataType::Int8 => self.integer(text).map(|it| low_octets(it, 1)),
            DataType::Uint16 | DataType::Int16 => self.integer(text).map(|it| low_octets(it, 2)),
            DataType::Uint32 | DataType::Int32 => self.integer(text).map(|it| low_octets(it, 4)),
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

    /// The values that the parameter accepts.
    #[must_use]
    pub fn expected(&self, number: NumberType) -> Expected {
        let row = self.row();
        let names = || row.codes.codes().iter().map(|code| code.name).collect();
        match (&row.codes, row.data_type) {
            (Codes::Names(_) | Codes::Commands(_) | Codes::BitCommands(_), _) => Expected::OneOf(names()),
            (Codes::Units, _) => Expected::OneOf(self.model.units.iter().map(|unit| unit.name).collect()),
            (Codes::Range(low, high), _) => Expected::Range(*low, *high),
            (Codes::PerMille(low, high), _) => Expected::Percentage(*low, *high),
            (Codes::Quantity(quantity), _) => {
                let in_unit = |number: i64| format!("{} {}", rounded(number as f64 * quantity.factor), quantity.unit);
                let limits = quantity.range.or_else(|| self.range());
                Expected::Quantity {
                    unit: quantity.unit,
                    limits: limits.map(|(low, high)| (in_unit(low), in_unit(high))),
                }
            }
            (_, DataType::Boolean) => Expected::Boolean,
            (_, DataType::ByType) => {
                let highest = (number == NumberType::Integer).then_some(self.model.max_integer);
                Expected::Pressure { example: self.example(highest), highest }
            }
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

    /// A number with or without the unit, which is the only one of the parameter.
    #[expect(clippy::cast_possible_truncation, reason = "whole and within the range, or a float of 32 bits")]
    fn quantity(&self, text: &str, quantity: &Quantity) -> Option<Vec<u8>> {
        let number: f64 = text.strip_suffix(quantity.unit).unwrap_or(text).trim_end().parse().ok()?;
        let steps = number / quantity.factor;
        if self.row().data_type == DataType::Float {
            let float = steps as f32;
            let is_inside = quantity.range.is_none_or(|(low, high)| (low as f64..=high as f64).contains(&steps));
            return (is_inside && float.is_finite()).then(|| float.to_be_bytes().to_vec());
        }
        let (low, high) = self.range()?;
        let (low, high) = quantity.range.map_or((low, high), |(lowest, highest)| (low.max(lowest), high.min(highest)));
        let whole = steps.round();
        // A decimal factor leaves some 1e-16 of the number.
        let is_whole = (steps - whole).abs() < 1e-6_f64.max(1e-11 * whole.abs());
        let is_inside = (low as f64..=high as f64).contains(&whole);
        let octets = match self.row().data_type.octets() {
            Length::Exactly(octets) => usize::from(octets),
            Length::AtMost(_) | Length::ByNumberType => return None,
        };
        (is_whole && is_inside).then(|| low_octets(whole as i64, octets))
    }

    fn command(&self, text: &str) -> Option<Vec<u8>> {
        let number = self.code(text)?;
        Some(low_octets(number, 2))
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
}

fn whole(text: &str) -> Option<i64> {
    match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

fn low_octets(number: i64, octets: usize) -> Vec<u8> {
    number.to_be_bytes().iter().skip(8 - octets).copied().collect()
}

/// Tenths of a percent from `12.5 %`, within these bounds.
#[expect(clippy::cast_possible_truncation, reason = "whole and within the bounds")]
fn per_mille(text: &str, low: i64, high: i64) -> Result<i64, ValueProblem> {
    let number = text.strip_suffix('%').unwrap_or(text).trim_end();
    let percent: f64 = number.parse().map_err(|_| ValueProblem::NotAccepted)?;
    let tenths = (percent * 10.0).round();
    let is_whole = (tenths - percent * 10.0).abs() < 1e-6;
    let is_inside = (low..=high).contains(&(tenths as i64));
    match text.ends_with('%') {
        true if is_whole && is_inside => Ok(tenths as i64),
        false if is_whole && is_inside => Err(ValueProblem::NoPercentSign { number: number.to_owned() }),
        _ => Err(ValueProblem::NotAccepted),
    }
}

/// A text, padded with blanks; an empty one is blanks alone.
fn visible(text: &str, length: usize) -> Option<Vec<u8>> {
    let fits = text.is_ascii() && text.len() <= length;
    fits.then(|| text.bytes().chain(std::iter::repeat(b' ')).take(length).collect())
}

fn octets(text: &str, length: usize) -> Option<Vec<u8>> {
    let digits: String = text.split_whitespace().collect();
    let pairs = digits.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).ok().filter(|pair| pair.len() == 2));
    let octets: Option<Vec<u8>> = pairs.map(|pair| u8::from_str_radix(pair?, 16).ok()).collect();
    octets.filter(|octets| octets.len() == length)
}
