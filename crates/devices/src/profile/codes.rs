//! Code tables that are the same in all manuals. tira41d1 3.1.1.9, 3.1.2.1, 3.2.2.3, 3.2.2.7, 3.1.1.10, 3.2.2.2;
//! tira36e1, tira56e1 and BG 5530 have the same numbers.

use super::exceptions::ExceptionStatus;
pub use super::part::SafeState;
use super::part::StatusExtension;
use super::state_machine::DeviceState;
pub use super::state_machine::StateCommand;
use crate::model::code_table::{code_of, value_of};
use crate::model::codes::code;
use crate::model::{Code, CodeTable, Codes, DataType, NumberType, ParameterValue, Quantity, Value};

impl CodeTable for DeviceState {
    type Value = Self;

    const CODES: Codes = Codes::Names(&[
        code(0, "undefined"),
        device_state(Self::SelfTesting),
        device_state(Self::Idle),
        device_state(Self::SelfTestException),
        device_state(Self::Executing),
        device_state(Self::Abort),
        device_state(Self::CriticalFault),
    ]);
}

/// The code of a state that has one.
pub(crate) const fn device_state(state: DeviceState) -> Code {
    code(state.code() as u16, state.name())
}

impl ParameterValue for DeviceState {
    fn from_value(value: &Value) -> Option<Self> {
        match code_of(value)? {
            0 | Self::INIT_CODE => Some(Self::Init),
            1 => Some(Self::SelfTesting),
            2 => Some(Self::Idle),
            3 => Some(Self::SelfTestException),
            4 => Some(Self::Executing),
            5 => Some(Self::Abort),
            6 => Some(Self::CriticalFault),
            _ => None,
        }
    }

    fn to_value(self, data_type: DataType) -> Value {
        value_of(self.code().into(), data_type)
    }
}

/// Data Type.
impl CodeTable for NumberType {
    type Value = Self;

    const CODES: Codes =
        Codes::Names(&[code(Self::Integer.code() as u16, "integer"), code(Self::Float.code() as u16, "float")]);
}

impl ParameterValue for NumberType {
    fn from_value(value: &Value) -> Option<Self> {
        code_of(value).and_then(|code| u8::try_from(code).ok()).and_then(Self::from_code)
    }

    fn to_value(self, data_type: DataType) -> Value {
        value_of(self.code().into(), data_type)
    }
}

/// Data Units: the code of one of the units of the [`Model`](crate::model::Model).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitCode {}

impl CodeTable for UnitCode {
    type Value = u16;

    const CODES: Codes = Codes::Units;
}

/// Emission Current of a BCG450 or BPG400 in mA; the lowest of its four currents is 0, the highest 20 (errata-bpg-bcg-tpg 98).
/// tira41d1 3.3.3.6, tira36e1 3.3.3.6.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Milliamperes {}

impl CodeTable for Milliamperes {
    type Value = f32;

    const CODES: Codes = Codes::Quantity(Quantity { unit: "mA", factor: 1.0, range: Some((0, 20)) });
}

/// A code table whose numbers are bits.
macro_rules! bits {
    ($flags:ident [$($bit:literal $name:literal),+]) => {
        impl CodeTable for $flags {
            type Value = Self;

            const CODES: Codes = Codes::Bits(&[$(($bit, $name)),+]);
        }

        impl ParameterValue for $flags {
            fn from_value(value: &Value) -> Option<Self> {
                value.integer().ok().map(Self::from_bits_retain)
            }

            fn to_value(self, _data_type: DataType) -> Value {
                self.bits().into()
            }
        }
    };
}

bits!(StatusExtension [0 "reading-invalid", 1 "overrange-exceeded", 2 "underrange-exceeded"]);

bits!(ExceptionStatus [
    0 "alarm-device-common",
    1 "alarm-device-specific",
    2 "alarm-manufacturer-specific",
    4 "warning-device-common",
    5 "warning-device-specific",
    6 "warning-manufacturer-specific",
    7 "expanded-format"
]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_device_state_is_read_from_its_code() {
        let Codes::Names(codes) = &DeviceState::CODES else { panic!("named codes") };
        for code in codes.iter().filter(|code| code.number != 0) {
            let state = DeviceState::from_value(&Value::Integer(code.number.into())).unwrap();
            assert_eq!(state.name(), code.name);
        }
        assert_eq!(DeviceState::from_value(&Value::Integer(100)), Some(DeviceState::Init));
        assert_eq!(DeviceState::from_value(&Value::Integer(7)), None);
    }
}
