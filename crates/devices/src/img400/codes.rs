//! Code tables of BG 5530 that are its own. Numbers in brackets are those of errata-pxg55x-img400.

use super::table::CHANNELS;
use crate::model::{Code, Codes, Precondition, code};
use crate::profile::DeviceState;
use crate::profile::codes::risky;

/// 4.4.1: the same codes as everywhere, and one for INIT (20).
pub const DEVICE_STATE: Codes = Codes::Names(&[
    code(0, "undefined"),
    code(DeviceState::SelfTesting.code() as u16, DeviceState::SelfTesting.name()),
    code(DeviceState::Idle.code() as u16, DeviceState::Idle.name()),
    code(DeviceState::SelfTestException.code() as u16, DeviceState::SelfTestException.name()),
    code(DeviceState::Executing.code() as u16, DeviceState::Executing.name()),
    code(DeviceState::Abort.code() as u16, DeviceState::Abort.name()),
    code(DeviceState::CriticalFault.code() as u16, DeviceState::CriticalFault.name()),
    code(100, DeviceState::Init.name()),
]);

/// 4.4.1, ID 203
pub const KEY_LOCK: Codes =
    Codes::Names(&[code(0, "off"), code(1, "para-lock"), code(2, "profi-lock"), code(3, "full-lock")]);

/// 4.4.1, ID 205
pub const RESET_ERRORS: Codes = Codes::BitCommands(&[
    code(1 << 0, "reset-power-supply-alarms"),
    code(1 << 1, "reset-power-supply-warnings"),
    code(1 << 2, "reset-hot-cathode-supply-alarms"),
    code(1 << 3, "reset-hot-cathode-supply-warnings"),
    risky(1 << 4, "reset-supplies", "switches the supplies of channels 3 and 4 on again"),
    code(1 << 5, "reset-error-flag"),
    code(1 << 7, "reset-all"),
]);

/// 4.4.2, ID 15: the target value says what is done.
pub const ADJUST: Codes = Codes::Commands(&[
    risky(0x0000, "disable-offset", "takes back the zero adjustment of the channel"),
    risky(0x0001, "zero-adjust", "moves the zero: nothing may be there to be measured"),
]);

/// 4.4.3, ID 27
pub const CHANNEL: Codes = Codes::Range(1, CHANNELS as i64);

const LIFE: &str = "switches the hot cathode: at a pressure that is too high this costs its life";

/// 4.4.4. The limit of degas depends on the gauge that is fitted; the controller knows it.
pub const HOT_CATHODE_COMMAND: Codes = Codes::Commands(&[
    code(0x0000, "inactive"),
    code(0x0100, "degas-off"),
    Code {
        number: 0x0101,
        name: "degas-on",
        preconditions: &[Precondition::Executing, Precondition::EmissionOn],
        risk: "heats the electrodes: gas is set free, and the pressure rises",
    },
    risky(0x0300, "emission-off", "the channel measures nothing without emission"),
    Code { number: 0x0301, name: "emission-on", preconditions: &[Precondition::Executing], risk: LIFE },
    code(0x0401, "clear-emission-off-alarm"),
]);

/// 4.4.4, ID 105
pub const EMISSION_STATUS: Codes = Codes::Names(&[
    risky(0, "off", "the channel measures nothing without emission"),
    Code { number: 1, name: "on", preconditions: &[Precondition::Executing], risk: LIFE },
]);

/// 4.4.4, ID 107: a float that holds a code (147).
pub const EMISSION_CURRENT: Codes = Codes::Names(&[
    code(0, "0-mA"),
    code(1, "0.1-mA"),
    code(2, "1-mA"),
    code(3, "1.6-mA"),
    code(4, "10-mA"),
    code(5, "45-mA"),
    code(6, "90-mA"),
]);

/// 4.4.4, ID 110
pub const DEGAS_STATUS: Codes = Codes::Names(&[code(0, "off"), code(1, "on")]);
