//! Values as text, in the words of the manual.

use super::{Value, ValueFormat, whole_number};
use profivac_devices::model::{Codes, DataType};

/// Behind the highest integer, which stands for every higher pressure.
pub(super) const OR_MORE: &str = " or more";

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
    /// A value that was read from these octets, as text. The highest integer stands for every higher pressure (errata-bpg-bcg-tpg 70,
    /// errata-pxg55x-img400 16).
    #[must_use]
    pub fn text(&self, octets: &[u8], value: &Value) -> String {
        let text = self.format(value);
        let is_highest = self.row().data_type == DataType::ByType && octets == self.model.max_integer.to_be_bytes();
        if is_highest { format!("{text}{OR_MORE}") } else { text }
    }

    /// The value as text.
    #[must_use]
    pub fn format(&self, value: &Value) -> String {
        match value {
            Value::Integer(number) => self.format_integer(*number),
            Value::Number(it) => match (&self.row().codes, self.row().data_type, self.unit) {
                (Codes::PerMille(..), ..) => format!("{} %", format_number(*it)),
                (Codes::Quantity(quantity), DataType::Float, _) => format!("{} {}", format_number(*it), quantity.unit),
                // Whole steps have all their digits, which a float of 32 bits has not.
                (Codes::Quantity(quantity), ..) => format!("{it} {}", quantity.unit),
                (_, DataType::ByType, Some(unit)) => format!("{} {}", format_number(*it), unit.name),
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
    pub(super) fn name_of_float(&self, number: f64) -> Option<String> {
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
}

/// Tenths of a percent as a percentage: `12.5 %`.
pub(super) fn percent(per_mille: i64) -> String {
    let sign = if per_mille < 0 { "-" } else { "" };
    let (whole, tenths) = (per_mille.unsigned_abs() / 10, per_mille.unsigned_abs() % 10);
    let tenths = if tenths > 0 { format!(".{tenths}") } else { String::new() };
    format!("{sign}{whole}{tenths} %")
}

/// The version in the nibbles of a number: [`Codes::Version`]. `None` for nibbles that are none.
fn version(number: i64) -> Option<String> {
    let digits = u32::try_from(number).ok()? >> 8;
    let letter = u8::try_from(number & 0xFF).ok().filter(|letter| (1..=15).contains(letter))?;
    let digits = format!("{digits:06X}");
    let is_decimal = digits.bytes().all(|digit| digit.is_ascii_digit());
    is_decimal.then(|| format!("{digits}-{}", char::from(b'A' + letter - 1)))
}
