//! Code tables as types: `codes!` makes an enum of a code table. The row of a block names that type, so that a typed access
//! to the parameter has it as its value. Ranges and unit codes are types without values of their own, whose parameters are
//! plain integers.

use super::codes::Codes;
use super::octets::Octets;
use super::typed::ParameterValue;
use super::value::{DataType, Value};
use core::cmp::Ordering;
use core::fmt;

/// A code table as a type: the last column of a block table.
pub trait CodeTable {
    /// The Rust type of a value.
    type Value: ParameterValue;

    /// The table.
    const CODES: Codes;
}

/// The number is not in the code table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownCode {
    /// The number.
    pub number: u16,
}

impl fmt::Display for UnknownCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the manual has no code {}", self.number)
    }
}

impl core::error::Error for UnknownCode {}

/// The code that a value is: an integer, a Boolean, a float without a fraction, or the two octets of a command record.
#[must_use]
pub fn code_of(value: &Value) -> Option<u16> {
    match value {
        Value::Boolean(boolean) => Some(u16::from(*boolean)),
        Value::Integer(integer) => u16::try_from(*integer).ok(),
        Value::Float(float) => code_of_float(*float),
        Value::Pressure(_) => None,
        Value::Octets(octets) => match octets.as_slice() {
            [command, value] => Some(u16::from_be_bytes([*command, *value])),
            _ => None,
        },
    }
}

/// A float that holds a code: errata-pxg55x-img400 147.
fn code_of_float(float: f32) -> Option<u16> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates, and is compared below")]
    let code = float as u16;
    (float.partial_cmp(&f32::from(code)) == Some(Ordering::Equal)).then_some(code)
}

/// The value of a parameter of this type that is a code.
#[must_use]
pub fn value_of(code: u16, data_type: DataType) -> Value {
    match data_type {
        DataType::Boolean => Value::Boolean(code != 0),
        DataType::Float => Value::Float(code.into()),
        DataType::Record(_) | DataType::Array(_) | DataType::OctetString(_) | DataType::Visible(_) => {
            Value::Octets(Octets::new(&code.to_be_bytes()))
        }
        _ => Value::Integer(code.into()),
    }
}

/// A code table: number, variant, name for people; then the conditions and the risk of writing it, where it has any.
#[macro_export]
macro_rules! codes {
    (
        $(#[$doc:meta])*
        pub $table:ident: $kind:ident;
        $($number:literal $code:ident $name:literal $(, needs $preconditions:expr)? $(, risk $risk:expr)?;)+
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $table {
            $(#[doc = concat!("`", $name, "`")] $code = $number,)+
        }

        impl $table {
            /// The number.
            #[must_use]
            pub const fn code(self) -> u16 {
                self as u16
            }

            /// The code with this number.
            #[must_use]
            pub const fn from_code(number: u16) -> Option<Self> {
                match number {
                    $($number => Some(Self::$code),)+
                    _ => None,
                }
            }

            /// The manual's name, in lower case.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$code => $name,)+
                }
            }
        }

        impl $crate::model::CodeTable for $table {
            type Value = Self;

            const CODES: $crate::model::Codes = $crate::model::Codes::$kind(&[$($crate::model::Code {
                number: $number,
                name: $name,
                preconditions: $crate::model::code_table::or_default!(&[]; $($preconditions)?),
                risk: $crate::model::code_table::or_default!(""; $($risk)?),
            }),+]);
        }

        impl $crate::model::ParameterValue for $table {
            fn from_value(value: &$crate::model::Value) -> Option<Self> {
                $crate::model::code_table::code_of(value).and_then(Self::from_code)
            }

            fn to_value(self, data_type: $crate::model::DataType) -> $crate::model::Value {
                $crate::model::code_table::value_of(self.code(), data_type)
            }
        }

        impl TryFrom<u16> for $table {
            type Error = $crate::model::UnknownCode;

            fn try_from(number: u16) -> Result<Self, $crate::model::UnknownCode> {
                Self::from_code(number).ok_or($crate::model::UnknownCode { number })
            }
        }

        impl core::fmt::Display for $table {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.pad(self.name())
            }
        }
    };
}

/// The second argument, or the first if there is no second one.
#[doc(hidden)]
#[macro_export]
macro_rules! or_default {
    ($default:expr;) => {
        $default
    };
    ($default:expr; $value:expr) => {
        $value
    };
}

/// Numbers from one to another: a code table without names.
#[macro_export]
macro_rules! code_range {
    ($(#[$doc:meta])* pub $table:ident: $value:ty = $low:expr, $high:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $table {}

        impl $crate::model::CodeTable for $table {
            type Value = $value;

            const CODES: $crate::model::Codes = $crate::model::Codes::Range($low as i64, $high as i64);
        }
    };
}

#[doc(hidden)]
pub use {code_range, codes, or_default};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Precondition;

    codes! {
        /// Two commands with values.
        pub Command: Commands;
        0x0000 Inactive "inactive";
        0x0101 DegasOn "degas-on", needs &[Precondition::Executing], risk "gas";
    }

    #[test]
    fn a_code_table_is_a_list_and_an_enum() {
        let Codes::Commands([inactive, degas]) = &Command::CODES else { panic!("two commands") };
        assert_eq!((inactive.number, inactive.name, inactive.risk), (0, "inactive", ""));
        assert_eq!((degas.preconditions, degas.risk), (&[Precondition::Executing][..], "gas"));
        assert_eq!(Command::try_from(0x0101), Ok(Command::DegasOn));
        assert_eq!(Command::try_from(0x0102), Err(UnknownCode { number: 0x0102 }));
        assert_eq!(Command::DegasOn.name(), "degas-on");
    }

    #[test]
    fn a_code_is_a_value_of_every_data_type_that_can_hold_it() {
        for (data_type, value) in [
            (DataType::Uint8, Value::Integer(1)),
            (DataType::Boolean, Value::Boolean(true)),
            (DataType::Float, Value::Float(1.0)),
            (DataType::Record(2), Value::octets(&[0, 1])),
        ] {
            assert_eq!(value_of(1, data_type), value, "{data_type}");
            assert_eq!(code_of(&value), Some(1), "{data_type}");
        }
        for value in [Value::Float(1.5), Value::Float(-1.0), Value::Float(f32::NAN), Value::Integer(-1), Value::NONE] {
            assert_eq!(code_of(&value), None, "{value:?}");
        }
    }
}
