//! Converts values between text and the octets of a record.
//!
//! A pressure is a number in the present unit of the device; a pressure in another unit is converted. Numbers that the
//! manual names are printed and accepted by name.

mod expected;
mod parse;
mod pressure;
#[cfg(test)]
mod tests;
mod text;

pub use expected::{BeyondRange, Expected, ValueError, ValueProblem};
pub(crate) use pressure::pressure_format;
pub use text::{format_number, hex};

use super::names::NamedParameter;
use profivac_devices::model::{Codes, CyclicValue, DataType, LengthError, Model, RawValue, Row, Unit};

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number; also a Boolean or a code.
    Integer(i64),
    /// A number; a pressure in the present unit of the device, a percentage in percent.
    Number(f64),
    /// Text without the blanks at its end.
    Text(String),
    /// A string of octets, an array or a record.
    Octets(Vec<u8>),
}

/// Formats and parses the values of one parameter of one device.
///
/// ```
/// use profivac_client::names::ParameterNames;
/// use profivac_client::values::{Value, ValueFormat};
/// use profivac_devices::catalog::model_named;
/// use profivac_devices::model::NumberType;
///
/// let model = model_named("bcg450").ok_or("no such model")?;
/// let names = ParameterNames::of(model);
/// // Safe Value of the Pirani: slot 1, instance 1, index 40. The gauge is set to mbar.
/// let named = names.at(1, 1, 40).ok_or("no such parameter")?;
/// let format = ValueFormat { named, model, unit: model.unit_named("mbar") };
/// assert_eq!(format.format(&Value::Number(0.125)), "0.125 mbar");
/// assert_eq!(format.parse("0.125 mbar", NumberType::Float)?, 0.125_f32.to_be_bytes());
/// println!("expected {}", format.expected(NumberType::Float));
/// assert!(format.beyond_range(&Value::Number(1e6)).is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    /// Decodes the octets of a record, without the unit that its row gives: [`of_row`](Self::of_row).
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

    /// Decodes the octets of a record of this row. A percentage is in percent, although its record counts tenths; a quantity is in its unit.
    ///
    /// ```
    /// use profivac_client::names::ParameterNames;
    /// use profivac_client::values::Value;
    /// use profivac_devices::catalog::model_named;
    ///
    /// let model = model_named("bcg450").ok_or("no such model")?;
    /// // Percentage of atmosphere of setpoint A: slot 1, instance 5, index 202.
    /// let named = ParameterNames::shared(model).at(1, 5, 202).ok_or("no such parameter")?;
    /// assert_eq!(Value::of_row(named.parameter.row, &50u16.to_be_bytes())?, Value::Number(5.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`decode`](Self::decode).
    #[expect(clippy::cast_precision_loss, reason = "a word")]
    pub fn of_row(row: &Row, octets: &[u8]) -> Result<Self, LengthError> {
        Ok(match (Self::decode(row.data_type, octets)?, &row.codes) {
            (Self::Integer(tenths), Codes::PerMille(..)) => Self::Number(tenths as f64 / 10.0),
            (Self::Integer(number), Codes::Quantity(quantity)) => {
                Self::Number(rounded(number as f64 * quantity.factor))
            }
            (Self::Number(number), Codes::Quantity(quantity)) => Self::Number(rounded(number * quantity.factor)),
            (value, _) => value,
        })
    }
}

/// A value of the cyclic data in words; `None` if the telegram is too short.
///
/// ```
/// use profivac_client::values::cyclic_text;
/// use profivac_devices::model::{Codes, CyclicValue, DataType, Quantity};
///
/// let codes = Codes::Quantity(Quantity { unit: "Hz", factor: 0.5, range: None });
/// let data_type = DataType::Uint16;
/// let speed = CyclicValue { name: "speed", is_output: false, telegram: 1, octet: 1, bit: 0, data_type, codes };
/// assert_eq!(cyclic_text(&speed, &[0, 0x07, 0xD0]).as_deref(), Some("1000 Hz"));
/// assert_eq!(cyclic_text(&speed, &[0]), None);
/// ```
#[must_use]
#[expect(clippy::cast_precision_loss, reason = "at most four octets")]
pub fn cyclic_text(value: &CyclicValue, telegram: &[u8]) -> Option<String> {
    let octets = telegram.get(usize::from(value.octet)..)?;
    let in_words = |number: i64| value.codes.code(number).map(|code| code.name.to_owned());
    if value.data_type == DataType::Boolean {
        let is_on = octets.first()?.checked_shr(value.bit.into()).is_some_and(|shifted| shifted & 1 == 1);
        let usual = if is_on { "on" } else { "off" };
        return in_words(is_on.into()).or_else(|| Some(usual.to_owned()));
    }
    let decoded = [1, 2, 4].into_iter().find_map(|length| Value::decode(value.data_type, octets.get(..length)?).ok());
    let (number, plain) = match decoded? {
        Value::Integer(number) => match in_words(number) {
            Some(name) => return Some(name),
            None => (number as f64, number.to_string()),
        },
        Value::Number(number) => (number, format_number(number)),
        Value::Text(_) | Value::Octets(_) => return None,
    };
    Some(match (&value.codes, value.data_type) {
        (Codes::Quantity(quantity), DataType::Float) => {
            format!("{} {}", format_number(number * quantity.factor), quantity.unit)
        }
        // Whole steps have all their digits, which a float of 32 bits has not.
        (Codes::Quantity(quantity), _) => format!("{} {}", rounded(number * quantity.factor), quantity.unit),
        _ => plain,
    })
}

/// The number with the digits that a product with a decimal factor has: 0.3 for 3 x 0.1.
fn rounded(number: f64) -> f64 {
    format!("{number:.11e}").parse().unwrap_or(number)
}

impl ValueFormat<'_> {
    const fn row(&self) -> &'static Row {
        self.named.parameter.row
    }
}

/// The code that a float holds. `None` for a number that is not whole, or greater than any code.
#[expect(clippy::cast_possible_truncation, reason = "whole and small")]
pub(crate) fn whole_number(number: f64) -> Option<i64> {
    (number.fract() == 0.0 && number.abs() < 1e6).then_some(number as i64)
}
