//! Values of parameters, and their octets on the wire. The high octet is first: errata-bpg-bcg-tpg 17.

use super::access_error::AccessError;
use super::octets::Octets;
use super::pressure::PressureFormat;
use core::fmt;

/// The data type of a parameter: Appendix A of the manuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    /// One octet, 0 or 1.
    Boolean,
    /// INT8
    Int8,
    /// UINT8
    Uint8,
    /// INT16
    Int16,
    /// UINT16
    Uint16,
    /// INT32
    Int32,
    /// UINT32
    Uint32,
    /// IEEE 754, four octets.
    Float,
    /// VSTRING(n), padded with blanks: errata-bpg-bcg-tpg 34.
    Visible(u8),
    /// OSTRING(n)
    OctetString(u8),
    /// Array of n octets.
    Array(u8),
    /// A record of n octets.
    Record(u8),
    /// A pressure in the device's present unit and number type ("according to data type").
    ByType,
}

/// The data type column of a block table.
#[doc(hidden)]
#[macro_export]
macro_rules! data_type {
    (BOOLEAN) => {
        $crate::model::DataType::Boolean
    };
    (INT8) => {
        $crate::model::DataType::Int8
    };
    (UINT8) => {
        $crate::model::DataType::Uint8
    };
    (INT16) => {
        $crate::model::DataType::Int16
    };
    (UINT16) => {
        $crate::model::DataType::Uint16
    };
    (INT32) => {
        $crate::model::DataType::Int32
    };
    (UINT32) => {
        $crate::model::DataType::Uint32
    };
    (FLOAT) => {
        $crate::model::DataType::Float
    };
    (BY_TYPE) => {
        $crate::model::DataType::ByType
    };
    (VSTRING($length:literal)) => {
        $crate::model::DataType::Visible($length)
    };
    (OSTRING($length:literal)) => {
        $crate::model::DataType::OctetString($length)
    };
    (ARRAY($length:literal)) => {
        $crate::model::DataType::Array($length)
    };
    (RECORD($length:literal)) => {
        $crate::model::DataType::Record($length)
    };
}

#[doc(hidden)]
pub use data_type;

impl fmt::Display for DataType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boolean => f.write_str("BOOLEAN"),
            Self::Int8 => f.write_str("INT8"),
            Self::Uint8 => f.write_str("UINT8"),
            Self::Int16 => f.write_str("INT16"),
            Self::Uint16 => f.write_str("UINT16"),
            Self::Int32 => f.write_str("INT32"),
            Self::Uint32 => f.write_str("UINT32"),
            Self::Float => f.write_str("FLOAT"),
            Self::ByType => f.write_str("BY_TYPE"),
            Self::Visible(length) => write!(f, "VSTRING({length})"),
            Self::OctetString(length) => write!(f, "OSTRING({length})"),
            Self::Array(length) => write!(f, "ARRAY({length})"),
            Self::Record(length) => write!(f, "RECORD({length})"),
        }
    }
}

/// The number of octets in which a type writes its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// Always this number.
    Exactly(u8),
    /// A text without all the blanks that pad it: errata-bpg-bcg-tpg 34.
    AtMost(u8),
    /// 2 or 4: a pressure as an integer or a float.
    ByNumberType,
}

impl Length {
    /// Whether a value may have this number of octets.
    #[must_use]
    pub const fn allows(self, octets: usize) -> bool {
        match self {
            Self::Exactly(length) => octets == length as usize,
            Self::AtMost(length) => octets <= length as usize,
            Self::ByNumberType => matches!(octets, 2 | 4),
        }
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exactly(1) => f.write_str("1 octet"),
            Self::Exactly(length) => write!(f, "{length} octets"),
            Self::AtMost(length) => write!(f, "at most {length} octets"),
            Self::ByNumberType => f.write_str("2 or 4 octets"),
        }
    }
}

/// The octets of a record have another number than the type of the parameter demands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LengthError {
    /// The type.
    pub data_type: DataType,
    /// The number of octets that it demands.
    pub expected: Length,
    /// The number of octets that came.
    pub found: usize,
}

impl fmt::Display for LengthError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "expected {} of {}, found {}", self.expected, self.data_type, self.found)
    }
}

impl core::error::Error for LengthError {}

/// The number, text or string that octets contain, before a unit or a code table gives it a meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RawValue<'a> {
    /// A Boolean, an integer, or a pressure as an integer.
    Integer(i64),
    /// A float, or a pressure as a float.
    Float(f32),
    /// A text with the blanks that pad it.
    Text(&'a [u8]),
    /// A string of octets, an array or a record.
    Octets(&'a [u8]),
}

/// The value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A Boolean.
    Boolean(bool),
    /// Any of the integer types.
    Integer(i64),
    /// A float that is not a pressure.
    Float(f32),
    /// The pressure of a `BY_TYPE` parameter, in Pa. Zero is the number 0 in every unit: errata-bpg-bcg-tpg 74.
    Pressure(f64),
    /// Text, strings of octets, arrays and records.
    Octets(Octets),
}

impl Value {
    /// No value: of an instance that the device does not have.
    pub const NONE: Self = Self::Octets(Octets::EMPTY);

    /// Text.
    #[must_use]
    pub fn text(text: &str) -> Self {
        Self::octets(text.as_bytes())
    }

    /// Octets of a string, an array or a record.
    #[must_use]
    pub fn octets(octets: &[u8]) -> Self {
        Self::Octets(Octets::new(octets))
    }

    /// The integer, if `T` can hold it.
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] if not.
    pub fn integer<T: TryFrom<i64>>(&self) -> Result<T, AccessError> {
        let integer = match self {
            Self::Integer(integer) => *integer,
            Self::Boolean(boolean) => i64::from(*boolean),
            _ => return Err(AccessError::OutOfRange),
        };
        T::try_from(integer).map_err(|_| AccessError::OutOfRange)
    }

    /// The Boolean.
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] if it is none.
    pub const fn boolean(&self) -> Result<bool, AccessError> {
        match self {
            Self::Boolean(boolean) => Ok(*boolean),
            Self::Integer(0) => Ok(false),
            Self::Integer(1) => Ok(true),
            _ => Err(AccessError::OutOfRange),
        }
    }

    /// The pressure in Pa.
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] if it is none.
    pub const fn pressure(&self) -> Result<f64, AccessError> {
        if let Self::Pressure(pa) = self { Ok(*pa) } else { Err(AccessError::OutOfRange) }
    }

    /// The code of a command record: the command in the high octet, its value in the low one; 0 for command 0 with any
    /// value.
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] if it is no such record.
    pub fn command_code(&self) -> Result<u16, AccessError> {
        self.command().map(|(command, value)| command_code(command, value))
    }

    /// The two octets of a command record: command and value.
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] if it is no such record.
    pub fn command(&self) -> Result<(u8, u8), AccessError> {
        match self {
            Self::Octets(octets) => match octets.as_slice() {
                [command, value] => Ok((*command, *value)),
                _ => Err(AccessError::OutOfRange),
            },
            _ => Err(AccessError::OutOfRange),
        }
    }
}

impl From<bool> for Value {
    fn from(boolean: bool) -> Self {
        Self::Boolean(boolean)
    }
}

impl From<u8> for Value {
    fn from(integer: u8) -> Self {
        Self::Integer(integer.into())
    }
}

impl From<u16> for Value {
    fn from(integer: u16) -> Self {
        Self::Integer(integer.into())
    }
}

impl From<u32> for Value {
    fn from(integer: u32) -> Self {
        Self::Integer(integer.into())
    }
}

impl DataType {
    /// Whether its values are whole numbers; those of a Boolean are 0 and 1.
    #[must_use]
    pub const fn is_integer(self) -> bool {
        matches!(
            self,
            Self::Boolean | Self::Int8 | Self::Uint8 | Self::Int16 | Self::Uint16 | Self::Int32 | Self::Uint32
        )
    }

    /// Whether a value of one type is a value of the other: whole numbers, floats, pressures, texts, strings.
    #[must_use]
    pub(crate) const fn is_alike(self, other: Self) -> bool {
        self.kind() == other.kind()
    }

    const fn kind(self) -> u8 {
        match self {
            Self::Boolean | Self::Int8 | Self::Uint8 | Self::Int16 | Self::Uint16 | Self::Int32 | Self::Uint32 => 0,
            Self::Float => 1,
            Self::ByType => 2,
            Self::Visible(_) => 3,
            Self::OctetString(_) | Self::Array(_) | Self::Record(_) => 4,
        }
    }

    /// The number of octets of a value on the wire.
    #[must_use]
    pub const fn length(self, format: &PressureFormat) -> usize {
        match self {
            Self::Boolean | Self::Int8 | Self::Uint8 => 1,
            Self::Int16 | Self::Uint16 => 2,
            Self::Int32 | Self::Uint32 | Self::Float => 4,
            Self::Visible(length) | Self::OctetString(length) | Self::Array(length) | Self::Record(length) => {
                length as usize
            }
            Self::ByType => format.number.octets(),
        }
    }

    /// The number of octets that a value may have while unit and number type are not known.
    #[must_use]
    pub const fn octets(self) -> Length {
        match self {
            Self::Boolean | Self::Int8 | Self::Uint8 => Length::Exactly(1),
            Self::Int16 | Self::Uint16 => Length::Exactly(2),
            Self::Int32 | Self::Uint32 | Self::Float => Length::Exactly(4),
            Self::Visible(length) => Length::AtMost(length),
            Self::OctetString(length) | Self::Array(length) | Self::Record(length) => Length::Exactly(length),
            Self::ByType => Length::ByNumberType,
        }
    }

    /// The number, text or string in `octets`.
    ///
    /// ```
    /// use profivac_devices::model::{DataType, RawValue};
    ///
    /// assert_eq!(DataType::Uint16.raw(&[0x13, 0x08]), Ok(RawValue::Integer(0x1308)));
    /// let error = DataType::Boolean.raw(&[1; 62]).unwrap_err();
    /// assert_eq!(error.to_string(), "expected 1 octet of BOOLEAN, found 62");
    /// ```
    ///
    /// # Errors
    /// [`LengthError`] for a number of octets that no value of this type has.
    pub fn raw(self, octets: &[u8]) -> Result<RawValue<'_>, LengthError> {
        let expected = self.octets();
        if !expected.allows(octets.len()) {
            return Err(LengthError { data_type: self, expected, found: octets.len() });
        }
        Ok(match (self, octets) {
            (Self::Float | Self::ByType, [a, b, c, d]) => RawValue::Float(f32::from_be_bytes([*a, *b, *c, *d])),
            (Self::Int8 | Self::Int16 | Self::Int32, _) => RawValue::Integer(signed(octets)),
            (Self::Boolean | Self::Uint8 | Self::Uint16 | Self::Uint32 | Self::Float | Self::ByType, _) => {
                RawValue::Integer(unsigned(octets))
            }
            (Self::Visible(_), _) => RawValue::Text(octets),
            (Self::OctetString(_) | Self::Array(_) | Self::Record(_), _) => RawValue::Octets(octets),
        })
    }

    /// The octets of `value` on the wire.
    #[must_use]
    pub fn encode(self, value: &Value, format: &PressureFormat) -> Octets {
        let length = self.length(format);
        match value {
            Value::Boolean(boolean) => Octets::filled(&[u8::from(*boolean)], length, 0),
            // A device file can have a Boolean where the device that it is like has several codes.
            Value::Integer(integer) if self == Self::Boolean => Octets::new(&[u8::from(*integer != 0)]),
            Value::Integer(integer) => low_octets(&integer.to_be_bytes(), length),
            Value::Float(float) => Octets::filled(&float.to_be_bytes(), length, 0),
            Value::Pressure(pa) if self == Self::ByType => format.encode(*pa),
            Value::Pressure(pa) => Octets::filled(&format.encode(*pa), length, 0),
            Value::Octets(octets) => Octets::filled(octets, length, self.fill()),
        }
    }

    /// The value of `octets`, whose number is that of [`length`](Self::length).
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] when no value of this type has these octets: a Boolean other than 0 and 1
    /// (errata-bpg-bcg-tpg 26), a float that is not a number, a pressure below zero.
    pub fn decode(self, octets: &[u8], format: &PressureFormat) -> Result<Value, AccessError> {
        let number = match self.raw(octets).map_err(|_| AccessError::OutOfRange)? {
            RawValue::Text(octets) | RawValue::Octets(octets) => return Ok(Value::octets(octets)),
            RawValue::Integer(integer) => match (self, integer) {
                (Self::ByType, _) => format.decode(octets).map(Value::Pressure),
                (Self::Boolean, 0 | 1) => Some(Value::Boolean(integer == 1)),
                (Self::Boolean, _) => None,
                _ => Some(Value::Integer(integer)),
            },
            RawValue::Float(_) if self == Self::ByType => format.decode(octets).map(Value::Pressure),
            RawValue::Float(float) => float.is_finite().then_some(Value::Float(float)),
        };
        number.ok_or(AccessError::OutOfRange)
    }

    /// The octet that pads a short text or string.
    const fn fill(self) -> u8 {
        if matches!(self, Self::Visible(_)) { b' ' } else { 0 }
    }

    /// The octets of `value` in the nonvolatile memory, which do not depend on unit and number type.
    #[must_use]
    pub fn encode_stored(self, value: &Value, format: &PressureFormat) -> Octets {
        match value {
            Value::Pressure(pa) => Octets::new(&pa.to_be_bytes()),
            _ => self.encode(value, format),
        }
    }

    /// The value that was stored; `None` if the octets cannot be a value of this type.
    #[must_use]
    pub fn decode_stored(self, octets: &[u8], format: &PressureFormat) -> Option<Value> {
        match self {
            Self::ByType => {
                let pa = f64::from_be_bytes(octets.try_into().ok()?);
                (pa >= 0.0 && pa.is_finite()).then_some(Value::Pressure(pa))
            }
            _ if octets.len() == self.length(format) => self.decode(octets, format).ok(),
            _ => None,
        }
    }
}

/// The code of a command with its value. Command 0 is Inactive with any value.
#[must_use]
pub const fn command_code(command: u8, value: u8) -> u16 {
    if command == 0 { 0 } else { u16::from_be_bytes([command, value]) }
}

/// The last `length` octets.
fn low_octets(octets: &[u8], length: usize) -> Octets {
    Octets::new(octets.split_at_checked(octets.len().saturating_sub(length)).map_or(&[], |(_, low)| low))
}

fn unsigned(octets: &[u8]) -> i64 {
    octets.iter().fold(0, |sum, octet| sum << 8 | i64::from(*octet))
}

fn signed(octets: &[u8]) -> i64 {
    let negative = octets.first().is_some_and(|octet| octet & 0x80 != 0);
    octets.iter().fold(if negative { -1 } else { 0 }, |sum, octet| sum << 8 | i64::from(*octet))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Counts, NumberType, Scale, Unit};

    static PASCAL: Unit = Unit { code: 0x1309, name: "Pascal", alias: "Pa", scale: Scale::PerMbar(100.0) };

    const FORMAT: PressureFormat = PressureFormat {
        unit: &PASCAL,
        number: NumberType::Float,
        counts: Counts::Linear { per_mbar: 1.0 },
        max_integer: 32767,
    };

    #[test]
    fn every_data_type_is_encoded_and_decoded() {
        for (data_type, value, octets) in [
            (DataType::Boolean, Value::Boolean(true), &[1][..]),
            (DataType::Uint8, Value::Integer(200), &[200]),
            (DataType::Int8, Value::Integer(-2), &[0xFE]),
            (DataType::Uint16, Value::Integer(0x1308), &[0x13, 0x08]),
            (DataType::Int16, Value::Integer(-2), &[0xFF, 0xFE]),
            (DataType::Uint32, Value::Integer(0x5097_3101), &[0x50, 0x97, 0x31, 0x01]),
            (DataType::Int32, Value::Integer(-2), &[0xFF, 0xFF, 0xFF, 0xFE]),
            // IF300P/IF301P manual, 0.001
            (DataType::Float, Value::Float(0.001), &[0x3A, 0x83, 0x12, 0x6F]),
            (DataType::ByType, Value::Pressure(0.125), &[0x3E, 0x00, 0x00, 0x00]),
            (DataType::Array(2), Value::octets(&[1, 2]), &[1, 2]),
        ] {
            assert_eq!(data_type.length(&FORMAT), octets.len(), "{data_type}");
            assert_eq!(data_type.encode(&value, &FORMAT).as_slice(), octets, "{data_type}");
            assert_eq!(data_type.decode(octets, &FORMAT), Ok(value), "{data_type}");
            let stored = data_type.encode_stored(&value, &FORMAT);
            assert_eq!(data_type.decode_stored(&stored, &FORMAT), Some(value), "{data_type}");
        }
    }

    #[test]
    fn octets_of_another_number_than_the_type_demands_are_no_value() {
        for (data_type, allowed) in [
            (DataType::Boolean, &[1][..]),
            (DataType::Int8, &[1]),
            (DataType::Uint8, &[1]),
            (DataType::Int16, &[2]),
            (DataType::Uint16, &[2]),
            (DataType::Int32, &[4]),
            (DataType::Uint32, &[4]),
            (DataType::Float, &[4]),
            (DataType::ByType, &[2, 4]),
            (DataType::Visible(3), &[0, 1, 2, 3]),
            (DataType::OctetString(3), &[3]),
            (DataType::Array(3), &[3]),
            (DataType::Record(3), &[3]),
        ] {
            for length in 0..=64 {
                let octets = [0; 64];
                let raw = data_type.raw(octets.get(..length).unwrap());
                assert_eq!(raw.is_ok(), allowed.contains(&length), "{data_type} of {length} octets");
            }
        }
        let expected = LengthError { data_type: DataType::Visible(8), expected: Length::AtMost(8), found: 9 };
        assert_eq!(DataType::Visible(8).raw(&[b' '; 9]), Err(expected));
    }

    #[test]
    fn texts_are_padded_with_blanks_and_strings_with_zeros() {
        assert_eq!(DataType::Visible(4).encode(&Value::text("CG"), &FORMAT).as_slice(), b"CG  ");
        assert_eq!(DataType::Visible(1).encode(&Value::text("CG"), &FORMAT).as_slice(), b"C");
        assert_eq!(DataType::OctetString(4).encode(&Value::octets(&[0, 1]), &FORMAT).as_slice(), [0, 1, 0, 0]);
    }

    #[test]
    fn octets_that_are_no_value_of_a_type_are_out_of_range() {
        assert_eq!(DataType::Boolean.decode(&[2], &FORMAT), Err(AccessError::OutOfRange));
        assert_eq!(DataType::Boolean.decode(&[0xFF], &FORMAT), Err(AccessError::OutOfRange));
        assert_eq!(DataType::Float.decode(&f32::NAN.to_be_bytes(), &FORMAT), Err(AccessError::OutOfRange));
        assert_eq!(DataType::ByType.decode(&(-1.0f32).to_be_bytes(), &FORMAT), Err(AccessError::OutOfRange));
        assert_eq!(Value::Integer(256).integer::<u8>(), Err(AccessError::OutOfRange));
        assert_eq!(Value::Float(1.0).integer::<u8>(), Err(AccessError::OutOfRange));
        assert_eq!(Value::Integer(2).boolean(), Err(AccessError::OutOfRange));
        assert_eq!(Value::octets(&[1, 2, 3]).command(), Err(AccessError::OutOfRange));
    }

    #[test]
    fn a_boolean_and_the_numbers_0_and_1_stand_for_each_other() {
        assert_eq!([false, true].map(|state| Value::Boolean(state).integer::<u8>()), [Ok(0), Ok(1)]);
        assert_eq!([0, 1].map(|number| Value::Integer(number).boolean()), [Ok(false), Ok(true)]);
    }

    #[test]
    fn a_stored_pressure_does_not_depend_on_unit_and_number_type() {
        let stored = DataType::ByType.encode_stored(&Value::Pressure(12.5), &FORMAT);
        let integers = PressureFormat { number: NumberType::Integer, ..FORMAT };
        assert_eq!(DataType::ByType.decode_stored(&stored, &integers), Some(Value::Pressure(12.5)));
        assert_eq!(DataType::ByType.decode_stored(&(-1.0f64).to_be_bytes(), &FORMAT), None);
        assert_eq!(DataType::ByType.decode_stored(&[0; 4], &FORMAT), None);
        assert_eq!(DataType::Uint16.decode_stored(&[1], &FORMAT), None);
    }
}
