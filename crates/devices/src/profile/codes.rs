//! Code tables that are the same in all manuals. tira41d1 3.1.1.9, 3.1.2.1, 3.2.2.3, 3.2.2.7, 3.1.1.10, 3.2.2.2; the same
//! numbers stand in tira36e1, tira56e1 and BG 5530.

use super::state_machine::DeviceState;
use crate::model::{Code, Codes, NumberType, code};

/// Device State.
pub const DEVICE_STATE: Codes = Codes::Names(&[
    code(0, "undefined"),
    state(DeviceState::SelfTesting),
    state(DeviceState::Idle),
    state(DeviceState::SelfTestException),
    state(DeviceState::Executing),
    state(DeviceState::Abort),
    state(DeviceState::CriticalFault),
]);

const fn state(state: DeviceState) -> Code {
    code(state.code() as u16, state.name())
}

/// Device Block State Command. Which of them a state allows is the state diagram: [`TRANSITIONS`](super::TRANSITIONS).
pub const STATE_COMMAND: Codes = Codes::Commands(&[
    code(0, "inactive"),
    risky(1, "reset", "restarts the device: it measures nothing until it is ready"),
    risky(2, "abort", "stops the measurement; relays and outputs go to their safe state"),
    code(3, "recover"),
    code(4, "execute"),
    risky(5, "stop", "stops the measurement; relays and outputs go to their safe state"),
    risky(6, "perform-diagnostic", "stops the measurement for a self test"),
]);

/// A command that may do harm.
pub const fn risky(number: u16, name: &'static str, risk: &'static str) -> Code {
    Code { number, name, preconditions: &[], risk }
}

/// Data Type.
pub const DATA_TYPE: Codes =
    Codes::Names(&[code(NumberType::Integer.code() as u16, "integer"), code(NumberType::Float.code() as u16, "float")]);

/// Data Units.
pub const UNIT: Codes = Codes::Units;

/// Safe State.
pub const SAFE_STATE: Codes =
    Codes::Names(&[code(0, "zero"), code(1, "full-scale"), code(2, "hold-last-value"), code(3, "use-safe-value")]);

/// Status Extension.
pub const STATUS_EXTENSION: Codes =
    Codes::Bits(&[(0, "reading-invalid"), (1, "overrange-exceeded"), (2, "underrange-exceeded")]);

/// Exception Status.
pub const EXCEPTIONS: Codes = Codes::Bits(&[
    (0, "alarm-device-common"),
    (1, "alarm-device-specific"),
    (2, "alarm-manufacturer-specific"),
    (4, "warning-device-common"),
    (5, "warning-device-specific"),
    (6, "warning-manufacturer-specific"),
    (7, "expanded-format"),
]);
