//! The tables of the manual of the interface boards IF300P and IF301P for TPG300 and TPG500 (i9973ber/a).
//!
//! Where a row departs from the print, a comment says why. Numbers in brackets are those of errata-bpg-bcg-tpg, whose part G
//! settles what the manual leaves open.

use super::codes::{
    AccessCode, Filter, MeasurementStatus, ProgramVersion, SetpointStatus, Source, UnderrangeControl, Validation,
    Volatility,
};
use super::faults::Faults;
use crate::model::block_macros::{block, blocks};
use crate::model::{
    AccessError, AlarmWords, ChannelRules, Configuration, Counts, Field, Gsd, INTEGER16_MAX, Location, Model,
    NumberType, ParameterSet, PressureFormat, Scale, TaskKind, Telegram, Unit, UserPrm, configuration, telegram, text,
};
use crate::profile::codes::UnitCode;
use profivac_dp::slave::Features;

block! {
    /// The controller as a whole.
    pub DeviceBlock in device_block = "Device Block";
    // Index  parameter            name as printed                  data type  access        store  section
    // INT8 in print, but four fields of two bits (128).
    20 SensorOnOff                 "Sensor On_Off"                  UINT8      [c_w, ac_r]   V      "3.2.3.2";
    // 1 byte in print (129).
    21 ProgramVersion              "Program version"                INT32      [ac_r]        -      "3.2.3.2" ProgramVersion;
    24 AccessCode                  "Authorized access code"         INT16      [ac_r, ac_w]  R      "3.2.3.2" AccessCode;
    // OSTRING1 in print (145).
    25 UnderrangeControl           "Pressure under-range control"   UINT8      [ac_r, ac_w]  R      "3.2.3.2" UnderrangeControl;
    26 Volatility                  "Volatility"                     UINT8      [ac_r, ac_w]  V      "3.2.3.2" Volatility;
}

block! {
    /// A measuring channel.
    pub AnalogInput in analog_input = "Analog Input Function Block";
    // Index  parameter            name as printed                  data type  access        store  section
    20 MeasuredValue               "Measured value"                 BY_TYPE    [c_r]         D      "3.2.4.1";
    21 MeasurementStatus           "Measurement status"             UINT8      [c_r]         D      "3.2.4.1" MeasurementStatus;
    22 PressureUnit                "Pressure unit"                  UINT8      [ac_r, ac_w]  R      "3.2.4.1" UnitCode;
    // OSTRING1 in print (145).
    23 FilterTimeConstant          "Filter time constant"           UINT8      [ac_r, ac_w]  R      "3.2.4.1" Filter;
}

block! {
    /// A pair of thresholds that switches a relay or a cold cathode.
    pub ThresholdControl in threshold_control = "Threshold Control Function Block";
    // Index  parameter            name as printed                  data type  access        store  section
    20 Validation                  "Threshold validation"           INT8       [ac_r, ac_w]  V      "3.2.4.2" Validation;
    // 1 byte in print (130).
    21 UpperThreshold              "Upper threshold"                BY_TYPE    [ac_r, ac_w]  R      "3.2.4.2";
    22 LowerThreshold              "Lower threshold"                BY_TYPE    [ac_r, ac_w]  R      "3.2.4.2";
    23 Source                      "Threshold source"               UINT8      [ac_r, ac_w]  R      "3.2.4.2" Source;
    24 SetpointStatus              "Setpoint status"                UINT8      [ac_r]        D      "3.2.4.2" SetpointStatus;
}

/// The device block.
pub const DEVICE: Location = Location::slot(0, "Device");
/// Channel A1.
pub const A1: Location = Location::slot(1, "A1");
/// Channel A2.
pub const A2: Location = Location::slot(2, "A2");
/// Channel B1.
pub const B1: Location = Location::slot(3, "B1");
/// Channel B2.
pub const B2: Location = Location::slot(4, "B2");
/// Relay 1.
pub const RELAY_1: Location = Location::slot(5, "Relay 1");
/// Relay 2.
pub const RELAY_2: Location = Location::slot(6, "Relay 2");
/// Relay 3.
pub const RELAY_3: Location = Location::slot(7, "Relay 3");
/// Relay 4.
pub const RELAY_4: Location = Location::slot(8, "Relay 4");
/// The cold cathodes of board A.
pub const COLD_CATHODE_A: Location = Location::slot(9, "Cold cathode A");
/// The cold cathodes of board B.
pub const COLD_CATHODE_B: Location = Location::slot(10, "Cold cathode B");

blocks! {
    /// All parameters of the controller. Slots as in 3.2.3.1, 3.2.4.1 and 3.2.4.2.
    pub Parameter;
    Device(DeviceBlock)         [DEVICE];
    Input(AnalogInput)          [A1, A2, B1, B2];
    Threshold(ThresholdControl) [RELAY_1, RELAY_2, RELAY_3, RELAY_4, COLD_CATHODE_A, COLD_CATHODE_B];
}

/// mbar, the unit from the factory.
// chosen: the manual gives no initial value
pub(super) const MBAR: Unit = Unit { code: 1, name: "mbar", alias: "hPa", scale: Scale::MBAR };
const TORR: Unit = Unit { code: 2, name: "Torr", alias: "torr", scale: Scale::TORR };
const PASCAL: Unit = Unit { code: 3, name: "Pascal", alias: "Pa", scale: Scale::PASCAL };

/// 3.2.4.1
pub(super) const UNITS: &[Unit] = &[MBAR, TORR, PASCAL];

/// The format of pressures in `unit`: always floats, without COUNTS.
pub(super) const fn format(unit: &'static Unit) -> PressureFormat {
    PressureFormat { unit, number: NumberType::Float, counts: Counts::Linear { per_mbar: 1.0 }, max_integer: u16::MAX }
}

const FLOAT: NumberType = NumberType::Float;

/// 3.2.2, the master's outputs. The manual does not number its telegrams; here 10 means floats, 20 mantissas.
const OUTPUTS: Telegram = telegram(0, &[Field::ParameterChannel, Field::SensorOnOff]);

/// The inputs with this number of channel modules in PROFIBUS floating point format: the first is A1, then A2, B1, B2
/// (122).
const fn floats(channels: u8) -> Telegram {
    const FIELDS: &[Field] = &[
        Field::ParameterChannel,
        Field::ChannelValue(1, FLOAT),
        Field::MeasurementStatus(1),
        Field::ChannelValue(2, FLOAT),
        Field::MeasurementStatus(2),
        Field::ChannelValue(3, FLOAT),
        Field::MeasurementStatus(3),
        Field::ChannelValue(4, FLOAT),
        Field::MeasurementStatus(4),
    ];
    telegram(channels.saturating_add(10), first(FIELDS, channels))
}

/// The same in Inficon floating point format.
const fn mantissas(channels: u8) -> Telegram {
    const FIELDS: &[Field] = &[
        Field::ParameterChannel,
        Field::ChannelMantissa(1),
        Field::MeasurementStatus(1),
        Field::ChannelMantissa(2),
        Field::MeasurementStatus(2),
        Field::ChannelMantissa(3),
        Field::MeasurementStatus(3),
        Field::ChannelMantissa(4),
        Field::MeasurementStatus(4),
    ];
    telegram(channels.saturating_add(20), first(FIELDS, channels))
}

/// The parameter channel and the fields of this number of channels.
const fn first(fields: &'static [Field], channels: u8) -> &'static [Field] {
    fields.split_at((channels as usize).saturating_mul(2).saturating_add(1)).0
}

/// 3.2.1.2: the parameter channel, no to four channel modules of one format (122, 123), and the device module.
static CONFIGURATIONS: [Configuration; 9] = [
    modules(&const { floats(0) }, &[0x97, 0xA7, 0xA0]),
    modules(&const { floats(1) }, &[0x97, 0xA7, 0x94, 0xA0]),
    modules(&const { floats(2) }, &[0x97, 0xA7, 0x94, 0x94, 0xA0]),
    modules(&const { floats(3) }, &[0x97, 0xA7, 0x94, 0x94, 0x94, 0xA0]),
    ALL_CHANNELS,
    modules(&const { mantissas(1) }, &[0x97, 0xA7, 0x93, 0xA0]),
    modules(&const { mantissas(2) }, &[0x97, 0xA7, 0x93, 0x93, 0xA0]),
    modules(&const { mantissas(3) }, &[0x97, 0xA7, 0x93, 0x93, 0x93, 0xA0]),
    modules(&const { mantissas(4) }, &[0x97, 0xA7, 0x93, 0x93, 0x93, 0x93, 0xA0]),
];

/// The answer to Get_Cfg before the first Chk_Cfg.
// chosen: four channels whatever boards are fitted, because the position of a module decides its channel (124)
const ALL_CHANNELS: Configuration = modules(&const { floats(4) }, &[0x97, 0xA7, 0x94, 0x94, 0x94, 0x94, 0xA0]);

const fn modules(inputs: &'static Telegram, octets: &'static [u8]) -> Configuration {
    configuration(Some(&OUTPUTS), Some(inputs), octets)
}

/// 3.2.2.1: a byte is written with AK 2 like a word (133), the error list is short (148), and the board needs no
/// AK 0 between two tasks (153).
static CHANNEL_RULES: ChannelRules = ChannelRules {
    tasks: &[(1, TaskKind::Read), (2, TaskKind::Write(&[1, 2])), (3, TaskKind::Write(&[4]))],
    needs_idle_between: false,
    error_codes: &[
        // A parameter that is only in the cyclic data has no index here: 127.
        (AccessError::NotReadable, 3),
        (AccessError::AlreadyInState, 17),
        (AccessError::StateConflict, 17),
        (AccessError::StorageFailed, 17),
        (AccessError::UnknownTask, 17),
    ],
};

/// The TPG300.
pub static TPG300: Model = model("tpg300", "TPG300", "BG509780-F");

/// The TPG500.
// chosen: the version is the other example of 3.2.3.2
pub static TPG500: Model = model("tpg500", "TPG500", "BG509731-A");

/// The controller behind an interface board: the bus does not tell which of the two it is, as both have the ident number of
/// the board and no Device Configuration.
pub static TPG: Model = model("tpg300 or tpg500", "TPG300 or TPG500", "IF300P");

/// Both have the same interface board.
const fn model(name: &'static str, title: &'static str, software: &'static str) -> Model {
    Model {
        name,
        title,
        vendor: "INFICON AG",
        manual: "i9973ber/a",
        ident: 0x05D9,
        // No acyclic services (150).
        features: Features { sync: false, freeze: false, dpv1: false, ms1: false },
        configurations: &CONFIGURATIONS,
        default_configuration: &ALL_CHANNELS,
        values: &[],
        units: UNITS,
        max_integer: INTEGER16_MAX,
        // No user parameters; the three octets that a DP-V1 master adds are tolerated (151).
        user_prm: &[UserPrm { name: "none", octets: &[] }, UserPrm { name: "DPV1_Status", octets: &[0, 0, 0] }],
        dpv1_status: 0,
        blocks: Parameter::BLOCKS,
        // The manual has no ranges: they depend on the gauges.
        parts: &[],
        channel_rules: &CHANNEL_RULES,
        alarms: AlarmWords::NONE,
        faults: &Faults::LIST,
        errata: text("errata-bpg-bcg-tpg 122 to 157 and 160"),
        gsd: Gsd { revision: 1, hardware: "IF300P", software, max_diag_octets: 6, set_slave_add: true },
    }
}
