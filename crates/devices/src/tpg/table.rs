//! The tables of the manual of the interface boards IF300P and IF301P for TPG300 and TPG500 (i9973ber/a).
//!
//! errata-bpg-bcg-tpg part G settles what the manual leaves open; a row that departs from the print names its entry.

use super::CHANNELS;
use super::codes::{
    ACCESS_CODE, FILTER, MEASUREMENT_STATUS, SETPOINT_STATUS, SOURCE, UNDERRANGE, VALIDATION, VOLATILITY,
};
use crate::model::block::{block, blocks};
use crate::model::{
    AccessError, ChannelRules, Configuration, Counts, Field, Gsd, Model, NumberType, ParameterSet, PressureFormat,
    Scale, TaskKind, Telegram, Unit, UserPrm, configuration, faults, telegram,
};
use crate::profile::codes::UNIT;
use profivac_dp::slave::Features;

block! {
    /// The controller as a whole.
    pub DeviceBlock = "Device Block";
    // Index  parameter            name as printed                  data type  access        store  section
    // INT8 in print, but four fields of two bits: 128
    20 SensorOnOff                 "Sensor On_Off"                  UINT8      [c_w, ac_r]   V      "3.2.3.2";
    // 1 byte in print: 129
    21 ProgramVersion              "Program version"                INT32      [ac_r]        -      "3.2.3.2";
    24 AccessCode                  "Authorized access code"         INT16      [ac_r, ac_w]  R      "3.2.3.2" ACCESS_CODE;
    // OSTRING1 in print: 145
    25 UnderrangeControl           "Pressure under-range control"   UINT8      [ac_r, ac_w]  R      "3.2.3.2" UNDERRANGE;
    26 Volatility                  "Volatility"                     UINT8      [ac_r, ac_w]  V      "3.2.3.2" VOLATILITY;
}

block! {
    /// A measuring channel.
    pub AnalogInput = "Analog Input Function Block";
    // Index  parameter            name as printed                  data type  access        store  section
    20 MeasuredValue               "Measured value"                 BY_TYPE    [c_r]         D      "3.2.4.1";
    21 MeasurementStatus           "Measurement status"             UINT8      [c_r]         D      "3.2.4.1" MEASUREMENT_STATUS;
    22 PressureUnit                "Pressure unit"                  UINT8      [ac_r, ac_w]  R      "3.2.4.1" UNIT;
    // OSTRING1 in print: 145
    23 FilterTimeConstant          "Filter time constant"           UINT8      [ac_r, ac_w]  R      "3.2.4.1" FILTER;
}

block! {
    /// A pair of thresholds that switches a relay or a cold cathode.
    pub ThresholdControl = "Threshold Control Function Block";
    // Index  parameter            name as printed                  data type  access        store  section
    20 Validation                  "Threshold validation"           INT8       [ac_r, ac_w]  V      "3.2.4.2" VALIDATION;
    // 1 byte in print: 130
    21 UpperThreshold              "Upper threshold"                BY_TYPE    [ac_r, ac_w]  R      "3.2.4.2";
    22 LowerThreshold              "Lower threshold"                BY_TYPE    [ac_r, ac_w]  R      "3.2.4.2";
    23 Source                      "Threshold source"               UINT8      [ac_r, ac_w]  R      "3.2.4.2" SOURCE;
    24 SetpointStatus              "Setpoint status"                UINT8      [ac_r]        D      "3.2.4.2" SETPOINT_STATUS;
}

blocks! {
    /// Every parameter of the controller. Slots as in 3.2.3.1, 3.2.4.1 and 3.2.4.2.
    pub Parameter;
    Device(DeviceBlock)              [0 "Device"];
    Channel(AnalogInput)             [1 "A1", 2 "A2", 3 "B1", 4 "B2"];
    Threshold(ThresholdControl)      [5 "Relay 1", 6 "Relay 2", 7 "Relay 3", 8 "Relay 4",
                                      9 "Cold cathode A", 10 "Cold cathode B"];
}

/// mbar, the unit from the factory.
// free choice: the manual gives no initial value
pub(super) const MBAR: Unit = Unit { code: 1, name: "mbar", alias: "hPa", scale: Scale::MBAR };
const TORR: Unit = Unit { code: 2, name: "Torr", alias: "torr", scale: Scale::TORR };
const PASCAL: Unit = Unit { code: 3, name: "Pascal", alias: "Pa", scale: Scale::PASCAL };

/// 3.2.4.1
pub(super) const UNITS: &[Unit] = &[MBAR, TORR, PASCAL];

/// How pressures look in `unit`: always floats, and there are no COUNTS.
pub(super) const fn format(unit: &'static Unit) -> PressureFormat {
    PressureFormat { unit, number: NumberType::Float, counts: Counts::Linear { per_mbar: 1.0 }, max_integer: u16::MAX }
}

use crate::model::Field::{ChannelMantissa, ChannelValue, MeasurementStatus, ParameterChannel, SensorOnOff};

const FLOAT: NumberType = NumberType::Float;

/// 3.2.2, the master's outputs. The manual does not number its telegrams; here 10 means floats, 20 mantissas.
const OUTPUTS: Telegram = telegram(0, &[ParameterChannel, SensorOnOff]);

/// The inputs with so many channel modules in PROFIBUS floating point format: the first is A1, then A2, B1, B2 (122).
const fn floats(channels: u8) -> Telegram {
    const FIELDS: &[Field] = &[
        ParameterChannel,
        ChannelValue(1, FLOAT),
        MeasurementStatus(1),
        ChannelValue(2, FLOAT),
        MeasurementStatus(2),
        ChannelValue(3, FLOAT),
        MeasurementStatus(3),
        ChannelValue(4, FLOAT),
        MeasurementStatus(4),
    ];
    telegram(channels.saturating_add(10), first(FIELDS, channels))
}

/// The same in Inficon floating point format.
const fn mantissas(channels: u8) -> Telegram {
    const FIELDS: &[Field] = &[
        ParameterChannel,
        ChannelMantissa(1),
        MeasurementStatus(1),
        ChannelMantissa(2),
        MeasurementStatus(2),
        ChannelMantissa(3),
        MeasurementStatus(3),
        ChannelMantissa(4),
        MeasurementStatus(4),
    ];
    telegram(channels.saturating_add(20), first(FIELDS, channels))
}

/// The parameter channel and the fields of so many channels.
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

/// What Get_Cfg tells first.
// free choice: four channels whatever boards are fitted, because a module stands for a channel by its position (124)
const ALL_CHANNELS: Configuration = modules(&const { floats(4) }, &[0x97, 0xA7, 0x94, 0x94, 0x94, 0x94, 0xA0]);

const fn modules(inputs: &'static Telegram, octets: &'static [u8]) -> Configuration {
    configuration(Some(&OUTPUTS), Some(inputs), octets)
}

/// 3.2.2.1: a byte is written with AK 2 like a word (133), the error list is short (148), and no rest is asked for
/// between two instructions (153).
static DIALECT: ChannelRules = ChannelRules {
    tasks: &[(1, TaskKind::Read), (2, TaskKind::Write(&[1, 2])), (3, TaskKind::Write(&[4]))],
    needs_idle_between: false,
    error_codes: &[
        // What travels only in the cyclic data has no index here: 127.
        (AccessError::NotReadable, 3),
        (AccessError::AlreadyInState, 17),
        (AccessError::StateConflict, 17),
        (AccessError::StorageFailed, 17),
        (AccessError::UnknownTask, 17),
    ],
};

faults! {
    /// What can be broken; the numbers are those of the channels.
    pub Faults;
    comm           "comm"         "no link to the controller: error on every channel, nothing can be written (156)";
    sensor_1       "sensor1"      "error on channel A1";
    sensor_2       "sensor2"      "error on channel A2";
    sensor_3       "sensor3"      "error on channel B1";
    sensor_4       "sensor4"      "error on channel B2";
    electronics_1  "electronics1" "error on channel A1";
    electronics_2  "electronics2" "error on channel A2";
    electronics_3  "electronics3" "error on channel B1";
    electronics_4  "electronics4" "error on channel B2";
    unplugged_1    "unplugged1"   "error on channel A1";
    unplugged_2    "unplugged2"   "error on channel A2";
    unplugged_3    "unplugged3"   "error on channel B1";
    unplugged_4    "unplugged4"   "error on channel B2";
}

impl Faults {
    /// Which channels have failed. The status tells nothing about the cause.
    pub(super) const fn failed(&self) -> [bool; CHANNELS] {
        [
            self.sensor_1 || self.electronics_1 || self.unplugged_1,
            self.sensor_2 || self.electronics_2 || self.unplugged_2,
            self.sensor_3 || self.electronics_3 || self.unplugged_3,
            self.sensor_4 || self.electronics_4 || self.unplugged_4,
        ]
    }
}

/// The TPG300.
pub static TPG300: Model = model("tpg300", "TPG300", "BG509780-F");

/// The TPG500.
// free choice: the version is the other example of 3.2.3.2
pub static TPG500: Model = model("tpg500", "TPG500", "BG509731-A");

/// Two names, one interface board.
const fn model(name: &'static str, title: &'static str, software: &'static str) -> Model {
    Model {
        name,
        title,
        vendor: "INFICON AG",
        manual: "i9973ber/a",
        ident: 0x05D9,
        // 150: no acyclic service at all
        features: Features { sync: false, freeze: false, dpv1: false, ms1: false },
        configurations: &CONFIGURATIONS,
        default_configuration: &ALL_CHANNELS,
        units: UNITS,
        // 151: no user parameters; the three octets that a DP-V1 master adds are tolerated.
        user_prm: &[UserPrm { name: "none", octets: &[] }, UserPrm { name: "DPV1_Status", octets: &[0, 0, 0] }],
        dpv1_status: 0,
        blocks: Parameter::PLACES,
        // None in the manual: it leaves them to the gauges.
        parts: &[],
        channel_rules: &DIALECT,
        faults: &Faults::LIST,
        errata: "errata-bpg-bcg-tpg 122 to 157",
        gsd: Gsd { revision: 1, hardware: "IF300P", software, max_diag_octets: 6, set_slave_add: true },
    }
}

/// A code of Sensor On_Off for one channel. 3.2.3.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Switch {
    Off = 1,
    Automatic = 2,
    On = 3,
}

impl Switch {
    /// The code in the low two bits; 0 is no action.
    pub const fn of(field: u8) -> Option<Self> {
        match field & 0x03 {
            1 => Some(Self::Off),
            2 => Some(Self::Automatic),
            3 => Some(Self::On),
            _ => None,
        }
    }
}

/// Filter time constant. 3.2.4.1, 146.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    Fast = 1,
    Medium = 2,
    Slow = 3,
}

impl Filter {
    pub const fn of(code: u8) -> Option<Self> {
        match code {
            1 => Some(Self::Fast),
            2 => Some(Self::Medium),
            3 => Some(Self::Slow),
            _ => None,
        }
    }

    /// The time constant in seconds.
    // free choice: the manual names no times
    pub const fn seconds(self) -> f64 {
        match self {
            Self::Fast => 0.1,
            Self::Medium => 0.4,
            Self::Slow => 1.6,
        }
    }
}
