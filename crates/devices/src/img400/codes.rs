//! The code tables of BG 5530 that no other manual has. Numbers in brackets are those of errata-pxg55x-img400.

use super::parts::CHANNELS;
use crate::model::Precondition::{BelowPartOfFullScale, DegasOff, EmissionOn, Executing};
use crate::model::code_table::{code_range, codes};
use crate::model::codes::code;
use crate::model::{CodeTable, Codes};
use crate::profile::DeviceState;
use crate::profile::codes::device_state;

/// Device State, with the codes of the gauges and one for INIT. 4.4.1 (20).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControllerState {}

impl CodeTable for ControllerState {
    type Value = DeviceState;

    const CODES: Codes = Codes::Names(&[
        code(0, "undefined"),
        device_state(DeviceState::SelfTesting),
        device_state(DeviceState::Idle),
        device_state(DeviceState::SelfTestException),
        device_state(DeviceState::Executing),
        device_state(DeviceState::Abort),
        device_state(DeviceState::CriticalFault),
        code(DeviceState::INIT_CODE, DeviceState::Init.name()),
    ]);
}

codes! {
    /// Key Lock: the keys of the controller that are locked. 4.4.1, ID 203.
    pub KeyLock: Names;
    0 Off       "off";
    1 ParaLock  "para-lock";
    2 ProfiLock "profi-lock";
    3 FullLock  "full-lock";
}

codes! {
    /// Reset Error Condition: one bit for each command; several may be set. 4.4.1, ID 205.
    pub ResetErrors: BitCommands;
    0x01 PowerSupplyAlarms        "reset-power-supply-alarms";
    0x02 PowerSupplyWarnings      "reset-power-supply-warnings";
    0x04 HotCathodeSupplyAlarms   "reset-hot-cathode-supply-alarms";
    0x08 HotCathodeSupplyWarnings "reset-hot-cathode-supply-warnings";
    0x10 Supplies                 "reset-supplies", risk "switches the supplies of channels 3 and 4 on again";
    0x20 ErrorFlag                "reset-error-flag";
    0x80 All                      "reset-all";
}

/// chosen: the part of Full Scale that an offset may have; a gauge that reads more measures a pressure.
const LARGEST_OFFSET: f64 = 0.05;

codes! {
    /// Block Adjust Command of a channel; the target value says what is done. 4.4.2, ID 15.
    pub AdjustCommand: Commands;
    0x0000 DisableOffset "disable-offset", risk "takes back the zero adjustment of the channel";
    0x0001 ZeroAdjust    "zero-adjust", needs &[Executing, BelowPartOfFullScale(LARGEST_OFFSET)],
                         risk "moves the zero: the pressure must be far below the range of the gauge";
}

code_range! {
    /// Analog Input Sensor Function Block Instance: the channel that a trip point compares. 4.4.3, ID 27.
    pub ChannelNumber: u8 = 1, CHANNELS
}

/// The risk of switching the emission on. No reading is a condition: a channel without emission has none, and the bus does not
/// tell whether the gauge of another channel is in the same chamber.
const CATHODE_LIFE: &str = "switches the hot cathode: at a pressure that is too high this costs its life; the controller does not \
                            tell which other gauge is in the same chamber, so the pressure is not checked";

codes! {
    /// Hot Cathode Block State Command: the command in the high octet, its value in the low one. The limit of degas depends on the
    /// gauge that is fitted; the controller knows it. 4.4.4.
    pub HotCathodeCommand: Commands;
    0x0000 Inactive              "inactive";
    0x0100 DegasOff              "degas-off";
    0x0101 DegasOn               "degas-on", needs &[Executing, EmissionOn, DegasOff],
                                 risk "heats the electrodes: gas is set free, and the pressure rises";
    0x0300 EmissionOff           "emission-off", risk "the channel measures nothing without emission; set points on it switch";
    0x0301 EmissionOn            "emission-on", needs &[Executing], risk CATHODE_LIFE;
    0x0401 ClearEmissionOffAlarm "clear-emission-off-alarm";
}

codes! {
    /// Emission Status. 4.4.4, ID 105.
    pub EmissionStatus: Names;
    0 Off "off", risk "the channel measures nothing without emission; set points on it switch";
    1 On  "on", needs &[Executing], risk CATHODE_LIFE;
}

codes! {
    /// Emission Current: a float that holds a code. 4.4.4, ID 107 (147).
    pub EmissionCurrent: Names;
    0 Milliampere0  "0-mA";
    1 Milliampere01 "0.1-mA";
    2 Milliampere1  "1-mA";
    3 Milliampere16 "1.6-mA";
    4 Milliampere10 "10-mA";
    5 Milliampere45 "45-mA";
    6 Milliampere90 "90-mA";
}

codes! {
    /// Degas Status. 4.4.4, ID 110.
    pub DegasStatus: Names;
    0 Off "off";
    1 On  "on";
}
