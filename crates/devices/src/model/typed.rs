//! Parameters as Rust types: the value that a client reads or writes has the type that its row says.
//!
//! `block!` makes a unit struct for every row, in a module beside the enum of the block. A client names location and
//! parameter, and the compiler knows the value:
//!
//! ```
//! use profivac_devices::bcg450::table::{DEVICE, MODEL, PIRANI, analog_input, device_block};
//! use profivac_devices::model::{
//!     Counts, Location, NumberType, ParameterValue, Pascal, PressureFormat, TypedParameter, Value,
//! };
//! use profivac_devices::profile::DeviceState;
//!
//! /// Decodes the octets that a master has read at `location`.
//! fn value_of<P: TypedParameter>(location: &Location, _parameter: P, octets: &[u8]) -> Option<P::Value> {
//!     let row = MODEL.typed_row::<P>(location)?;
//!     let unit = MODEL.unit_named("mbar")?;
//!     let counts = Counts::Linear { per_mbar: 1.0 };
//!     let format = PressureFormat { unit, number: NumberType::Float, counts, max_integer: 32767 };
//!     P::Value::from_value(&row.data_type.decode(octets, &format).ok()?)
//! }
//!
//! assert_eq!(value_of(&DEVICE, device_block::DeviceState, &[2]), Some(DeviceState::Idle));
//! let octets = 1.5f32.to_be_bytes();
//! assert_eq!(value_of(&PIRANI, analog_input::ProcessValue, &octets), Some(Pascal(150.0)));
//! assert_eq!(value_of(&DEVICE, analog_input::ProcessValue, &octets), None, "it is no parameter of the device block");
//! ```

use super::access_error::AccessError;
use super::block::{Block, Row};
use super::octets::Octets;
use super::value::{DataType, Value};

/// A parameter of a block with the Rust type of its value.
pub trait TypedParameter: Copy {
    /// The type of its value.
    type Value: ParameterValue;

    /// Its block.
    const BLOCK: &'static Block;

    /// Its row.
    const ROW: &'static Row;
}

/// A Rust type for the value of a parameter.
pub trait ParameterValue: Copy {
    /// The value as this type; `None` if it is of another type, out of range, or not in the code table.
    fn from_value(value: &Value) -> Option<Self>;

    /// The value as a parameter of this data type has it.
    fn to_value(self, data_type: DataType) -> Value;
}

impl Value {
    /// The value as a typed parameter has it: a code, for example.
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] if it is not of this type.
    pub fn coded<T: ParameterValue>(&self) -> Result<T, AccessError> {
        T::from_value(self).ok_or(AccessError::OutOfRange)
    }
}

/// A pressure in Pa, with any unit and number type of the device.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Pascal(pub f64);

impl Pascal {
    /// The same pressure in mbar.
    #[must_use]
    pub const fn mbar(self) -> f64 {
        self.0 / 100.0
    }
}

impl ParameterValue for Pascal {
    fn from_value(value: &Value) -> Option<Self> {
        value.pressure().ok().map(Self)
    }

    fn to_value(self, _data_type: DataType) -> Value {
        Value::Pressure(self.0)
    }
}

impl ParameterValue for bool {
    fn from_value(value: &Value) -> Option<Self> {
        value.boolean().ok()
    }

    fn to_value(self, _data_type: DataType) -> Value {
        Value::Boolean(self)
    }
}

impl ParameterValue for f32 {
    fn from_value(value: &Value) -> Option<Self> {
        if let Value::Float(float) = value { Some(*float) } else { None }
    }

    fn to_value(self, _data_type: DataType) -> Value {
        Value::Float(self)
    }
}

impl ParameterValue for Octets {
    fn from_value(value: &Value) -> Option<Self> {
        if let Value::Octets(octets) = value { Some(*octets) } else { None }
    }

    fn to_value(self, _data_type: DataType) -> Value {
        Value::Octets(self)
    }
}

/// The integer types of the manuals.
macro_rules! integers {
    ($($integer:ty),+) => {$(
        impl ParameterValue for $integer {
            fn from_value(value: &Value) -> Option<Self> {
                value.integer().ok()
            }

            fn to_value(self, _data_type: DataType) -> Value {
                Value::Integer(self.into())
            }
        }
    )+};
}

integers!(u8, u16, u32, i8, i16, i32);
