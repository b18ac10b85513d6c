//! The tables of tira41d1, row by row, with the names as printed. Where a row departs from the print, a comment says
//! why. Sections are those of the manual, numbers in brackets those of errata-bpg-bcg-tpg.

use super::codes::{
    AtmosphereCommand, DegasStatus, EmissionStatus, HotCathodeCommand, Percentage, Selector, SetpointFunction,
};
use super::faults::Faults;
use super::parts;
use crate::model::block_macros::{block, blocks};
use crate::model::{
    AlarmBit, AlarmWords, ChannelRules, Configuration, Field, Gsd, INTEGER16_MAX, Location, Model, NumberType,
    ParameterSet, Scale, TaskKind, Telegram, Unit, UserPrm, configuration, telegram, text,
};
use crate::profile::codes::{Milliamperes, UnitCode};
use crate::profile::{DeviceState, ExceptionStatus, SafeState, StateCommand, StatusExtension};
use profivac_dp::slave::Features;

block! {
    /// Identity, state and exceptions of the whole device.
    pub DeviceBlock in device_block = "Device Block", type 1;
    // ID parameter                 name as printed                                data type    access        store  section
    // The overview leaves the store class blank, 3.1.2.1 prints N: a command is never kept (35).
    15 StateCommand               "Device Block State Command"                   UINT8        [1_R/W 2_R/W]    -  "3.1.2.1" StateCommand;
    16 BlockType                  "Block Type"                                   OSTRING(4)   [1/2_R]          N  "3.1.1.1";
    17 DeviceType                 "Device Type"                                  VSTRING(8)   [1/2_R]          N  "3.1.1.2";
    18 StandardRevision           "Standard Revision Level"                      VSTRING(9)   [1/2_R]          N  "3.1.1.3";
    19 Manufacturer               "Device Manufacturer Identifier"               VSTRING(20)  [1/2_R]          N  "3.1.1.4";
    20 ModelNumber                "Manufacturer Model Number"                    VSTRING(20)  [1/2_R]          N  "3.1.1.5";
    21 SoftwareRevision           "Software or Firmware Revision Level"          VSTRING(8)   [1/2_R]          N  "3.1.1.6";
    22 HardwareRevision           "Hardware Revision Level"                      VSTRING(8)   [1/2_R]          N  "3.1.1.7";
    23 SerialNumber               "Serial Number"                                VSTRING(30)  [1/2_R]          N  "3.1";
    24 DeviceConfiguration        "Device Configuration"                         VSTRING(50)  [1/2_R]          N  "3.1.1.8";
    25 DeviceState                "Device State"                                 UINT8        [1/2_R]          V  "3.1.1.9" DeviceState;
    26 ExceptionStatus            "Exception Status"                             UINT8        [0_XI 1/2_R]     V  "3.1.1.10" ExceptionStatus;
    27 AlarmDetail                "Exception Detail Alarm"                       RECORD(12)   [1/2_R]          V  "3.1.1.11";
    28 WarningDetail              "Exception Detail Warning"                     RECORD(13)   [1/2_R]          V  "3.1.1.12";
    204 AlarmCommon               "Common Exception Detail Alarm 0"              UINT8        [1/2_R]          V  "3.1.1.13";
    205 AlarmDevice0To3           "Device Exception Detail Alarm 0 ... 3"        ARRAY(4)     [1/2_R]          V  "3.1.1.14";
    206 AlarmDevice4To5           "Device Exception Detail Alarm 4 ... 5"        ARRAY(2)     [1/2_R]          V  "3.1.1.15";
    207 AlarmManufacturer         "Manufacturer Exception Detail Alarm 0"        UINT8        [1/2_R]          V  "3.1.1.16";
    208 WarningCommon             "Common Exception Detail Warning 0"            UINT8        [1/2_R]          V  "3.1.1.17";
    209 WarningDevice0To3         "Device Exception Detail Warning 0 ... 3"      ARRAY(4)     [1/2_R]          V  "3.1.1.18";
    210 WarningDevice4To6         "Device Exception Detail Warning 4 ... 6"      ARRAY(3)     [1/2_R]          V  "3.1.1.19";
    211 WarningManufacturer       "Manufacturer Exception Detail Warning 0"      UINT8        [1/2_R]          V  "3.1.1.20";
}

block! {
    /// The instance that measures, and the instance that the shared indices show.
    pub OneOfNInput in one_of_n_input = "One Of N Analog Input Function Block", type 3;
    16 BlockType                  "Block Type"                                   OSTRING(4)   [2_R]            N  "3.2.1.1";
    46 ChannelInstanceSelector    "Channel Instance Selector"                    UINT8        [1/2_R/W]        N  "3.2.1.2" Selector;
    47 PvSelector                 "PV Selector"                                  UINT8        [0_XI 1/2_R]     D  "3.2.1.3";
}

block! {
    /// The pressure of one measuring part, with the sections of instance 1; 3.2.3 and 3.2.4 repeat them for 2 and 3. No
    /// block type is printed (33).
    pub AnalogInput in analog_input = "Analog Sensor Input Function Block";
    19 ProcessValue               "Process Value (PV)"                           BY_TYPE      [0_XI 1_R 2_R]   D  "3.2.2.1";
    20 Status                     "Status"                                       UINT8        [0_XI 1/2_R]     D  "3.2.2.2";
    21 DataType                   "Data Type"                                    UINT8        [2_R/W]          N  "3.2.2.3" NumberType;
    22 DataUnits                  "Data Units"                                   UINT16       [2_R/W]          N  "3.2.2.4" UnitCode;
    23 ReadingValid               "Reading Valid"                                BOOLEAN      [1_R 2_R]        D  "3.2.2.5";
    24 FullScale                  "Full Scale"                                   BY_TYPE      [1/2_R]          N  "3.2.2.6";
    39 SafeState                  "Safe State"                                   UINT8        [1/2_R/W]        N  "3.2.2.7" SafeState;
    40 SafeValue                  "Safe Value"                                   BY_TYPE      [1/2_R/W]        N  "3.2.2.8";
    44 Overrange                  "Overrange"                                    BY_TYPE      [1/2_R]          N  "3.2.2.9";
    45 Underrange                 "Underrange"                                   BY_TYPE      [1/2_R]          N  "3.2.2.10";
}

block! {
    /// A relay and its threshold.
    pub SetPoint in set_point = "Analog Sensor Input Function Block (set point)";
    // Printed as Unsigned16 without a length; the text says data type and unit of the device (71).
    19 ProcessValue               "Process Value (PV)"                           BY_TYPE      [1_R 2_R]        D  "3.2.5.1";
    20 Status                     "Status"                                       UINT8        [1_R 2_R]        D  "3.2.5.2";
    21 DataType                   "Data Type"                                    UINT8        [2_R 2_W]        N  "3.2.5.3" NumberType;
    22 DataUnits                  "Data Units"                                   UINT16       [2_R 2_W]        N  "3.2.5.4" UnitCode;
    23 ReadingValid               "Reading Valid"                                BOOLEAN      [1_R 2_R]        D  "3.2.5.5";
    // 201 and 202 are printed write-only, and 203 as well (110).
    201 SetpointFunction          "Setpoint Function"                            BOOLEAN      [1_R/W 2_R/W]    N  "3.2.5.6" SetpointFunction;
    202 PercentageOfAtmosphere    "Percentage of atmosphere"                     UINT16       [1_R/W 2_R/W]    N  "3.2.5.7" Percentage;
    203 AtmosphereReached         "Atmospheric pressure reached"                 BOOLEAN      [1_R 2_R]        D  "3.2.5.8";
}

block! {
    /// The range of the whole gauge.
    pub OneOfNTransducer in one_of_n_transducer = "One Of N Vacuum Gauge Transducer Block";
    120 StatusExtension           "One Of N Status Extension"                    UINT8        [1_R 2_R]        V  "3.3.1.1" StatusExtension;
}

block! {
    /// The Pirani.
    pub HeatTransfer in heat_transfer = "Heat Transfer Vacuum Gauge Transducer Block", type 13;
    101 BlockType                 "Block Type"                                   OSTRING(4)   [2_R]            -  "3.3.2.1";
    102 StatusExtension           "Status Extension"                             UINT8        [1/2_R]          V  "3.3.2.2" StatusExtension;
    103 SensorAlarm               "Sensor Alarm"                                 ARRAY(2)     [1/2_R]          V  "3.3.2.3";
    104 SensorWarning             "Sensor Warning"                               ARRAY(2)     [1/2_R]          V  "3.3.2.4";
}

block! {
    /// The Bayard-Alpert part.
    pub HotCathode in hot_cathode = "Hot Cathode Ion Gauge Transducer Block", type 16;
    // Two octets, command and value; 1 is printed (93).
    14 StateCommand               "Hot Cathode Block State Command"              RECORD(2)    [1_W 2_W]        -  "3.3.3.9" HotCathodeCommand;
    101 BlockType                 "Block Type"                                   OSTRING(4)   [2_R]            -  "3.3.3.1";
    102 StatusExtension           "Status Extension"                             UINT8        [1_R 2_R]        V  "3.3.3.2" StatusExtension;
    103 SensorAlarm               "Sensor Alarm"                                 ARRAY(2)     [1_R 2_R]        V  "3.3.3.3";
    104 SensorWarning             "Sensor Warning"                               ARRAY(2)     [1_R 2_R]        V  "3.3.3.4";
    // Printed as Boolean, with four codes (97).
    105 EmissionStatus            "Emission Status"                              UINT8        [1_R/W 2_R/W]    V  "3.3.3.5" EmissionStatus;
    // Printed NV, but the gauge chooses the current, so there is nothing to keep (98).
    106 EmissionCurrent           "Emission Current"                             FLOAT        [1_R/W 2_R/W]    V  "3.3.3.6" Milliamperes;
    // Printed as Boolean, with the codes 00 and 03 (99).
    109 DegasStatus               "Degas Status"                                 UINT8        [1_R 2_R]        V  "3.3.3.7" DegasStatus;
    201 EmissionUserMode          "Emission User Mode State"                     BOOLEAN      [1_R 2_R]        V  "3.3.3.8";
}

block! {
    /// The capacitance diaphragm part.
    pub Diaphragm in diaphragm = "Diaphragm Gauge Transducer Block", type 14;
    101 BlockType                 "Block Type"                                   OSTRING(4)   [2_R]            -  "3.3.4.1";
    102 StatusExtension           "Status Extension"                             UINT8        [1/2_R]          V  "3.3.4.2" StatusExtension;
    103 SensorAlarm               "Sensor Alarm"                                 ARRAY(2)     [1/2_R]          V  "3.3.4.3";
    104 SensorWarning             "Sensor Warning"                               ARRAY(2)     [1/2_R]          V  "3.3.4.4";
}

block! {
    /// The piezo sensor for the ambient pressure.
    pub Atmosphere in atmosphere = "Atmosphere Sensor Transducer Block", type 256;
    14 StateCommand               "Atmosphere gauge Block State Command"         RECORD(2)    [1_W 2_W]        -  "3.3.5.2" AtmosphereCommand;
    101 BlockType                 "Block Type"                                   OSTRING(4)   [2_R]            -  "3.3.5.1";
}

/// The device block.
pub const DEVICE: Location = Location::slot(0, "Device");
/// The blocks that choose the instance.
pub const ONE_OF_N: Location = Location::slot(1, "One Of N");
/// The Pirani.
pub const PIRANI: Location = Location::instance(1, 1, "Pirani");
/// The Bayard-Alpert part.
pub const BA: Location = Location::instance(1, 2, "BA");
/// The capacitance diaphragm part.
pub const CDG: Location = Location::instance(1, 3, "CDG");
/// The ambient pressure sensor.
pub const ATMOSPHERE: Location = Location::instance(1, 4, "Atmosphere");
/// The first relay.
pub const SETPOINT_A: Location = Location::instance(1, 5, "Setpoint A");
/// The second relay.
pub const SETPOINT_B: Location = Location::instance(1, 6, "Setpoint B");

blocks! {
    /// All parameters of the BCG450-SP. Slot 1 shows one instance at a time (27, 28).
    pub Parameter;
    Device(DeviceBlock)                [DEVICE];
    OneOfNInput(OneOfNInput)           [ONE_OF_N];
    OneOfNTransducer(OneOfNTransducer) [ONE_OF_N];
    Input(AnalogInput)                 [PIRANI, BA, CDG];
    SetPoint(SetPoint)                 [SETPOINT_A, SETPOINT_B];
    HeatTransfer(HeatTransfer)         [PIRANI];
    HotCathode(HotCathode)             [BA];
    Diaphragm(Diaphragm)               [CDG];
    Atmosphere(Atmosphere)             [ATMOSPHERE];
}

/// The position of the block of the relays in [`Parameter::BLOCKS`].
pub const SET_POINT_BLOCK: usize = 4;

// 2.3, with the configuration data of 2.3 and not of 1.4 (2).
static T1: Telegram = telegram(1, &[Field::TransitionCommand]);
static T2: Telegram = telegram(2, &[Field::ParameterChannel, Field::TransitionCommand]);
static T3: Telegram = telegram(3, &[Field::ParameterChannel]);
static T4: Telegram = telegram(
    4,
    &[Field::ExceptionStatus, Field::StatusExtension, Field::PvSelector, Field::ProcessValue(NumberType::Integer)],
);
static T5: Telegram = telegram(
    5,
    &[Field::ExceptionStatus, Field::StatusExtension, Field::PvSelector, Field::ProcessValue(NumberType::Float)],
);
static T6: Telegram = telegram(
    6,
    &[
        Field::ParameterChannel,
        Field::ExceptionStatus,
        Field::StatusExtension,
        Field::PvSelector,
        Field::ProcessValue(NumberType::Integer),
    ],
);
static T7: Telegram = telegram(
    7,
    &[
        Field::ParameterChannel,
        Field::ExceptionStatus,
        Field::StatusExtension,
        Field::PvSelector,
        Field::ProcessValue(NumberType::Float),
    ],
);

#[rustfmt::skip]
static CONFIGURATIONS: [Configuration; 8] = [
    configuration(None,      Some(&T4), &[0x44, 0x84, 0x05, 0x05, 0x05, 0x03]),
    configuration(None,      Some(&T5), &[0x44, 0x86, 0x05, 0x05, 0x05, 0x08]),
    configuration(Some(&T1), Some(&T4), &[0xC6, 0x81, 0x84, 0x05, 0x05, 0x05, 0x05, 0x05, 0x03]),
    configuration(Some(&T1), Some(&T5), &[0xC6, 0x81, 0x86, 0x05, 0x05, 0x05, 0x05, 0x05, 0x08]),
    configuration(Some(&T3), Some(&T6), &[0xC6, 0x87, 0x8C, 0x0A, 0x0A, 0x05, 0x05, 0x05, 0x03]),
    configuration(Some(&T3), Some(&T7), &[0xC6, 0x87, 0x8E, 0x0A, 0x0A, 0x05, 0x05, 0x05, 0x08]),
    configuration(Some(&T2), Some(&T6), &[0xC8, 0x89, 0x8C, 0x0A, 0x05, 0x05, 0x0A, 0x05, 0x05, 0x05, 0x03]),
    configuration(Some(&T2), Some(&T7), &[0xC8, 0x89, 0x8E, 0x0A, 0x05, 0x05, 0x0A, 0x05, 0x05, 0x05, 0x08]),
];

/// The pressure units. 3.2.2.1 and 3.2.2.4; the codes are decimal (5), the factor of Micron is 1000 (60), the factors are
/// the printed ones (83).
#[rustfmt::skip]
pub static UNITS: [Unit; 5] = [
    Unit { code: 1001, name: "COUNTS", alias: "counts", scale: Scale::Counts },
    Unit { code: 1301, name: "Torr",   alias: "torr",   scale: Scale::TORR },
    Unit { code: 1302, name: "Micron", alias: "mTorr",  scale: Scale::MICRON },
    Unit { code: 1308, name: "mbar",   alias: "hPa",    scale: Scale::MBAR },
    Unit { code: 1309, name: "Pascal", alias: "Pa",     scale: Scale::PASCAL },
];

/// 1.5
#[rustfmt::skip]
static USER_PRM: [UserPrm; 5] = [
    UserPrm { name: "COUNTS",         octets: &[0x00, 0x00, 0x00, 0x03, 0xE9] },
    UserPrm { name: "Torr",           octets: &[0x00, 0x00, 0x00, 0x05, 0x15] },
    UserPrm { name: "Micron (mTorr)", octets: &[0x00, 0x00, 0x00, 0x05, 0x16] },
    UserPrm { name: "mbar",           octets: &[0x00, 0x00, 0x00, 0x05, 0x1C] },
    UserPrm { name: "Pascal",         octets: &[0x00, 0x00, 0x00, 0x05, 0x1D] },
];

/// The unit as it leaves the factory (73).
pub const FACTORY_UNIT: &Unit = &UNITS[3];

/// 2.2.1.1
static CHANNEL_RULES: ChannelRules = ChannelRules {
    tasks: &[(1, TaskKind::Read), (2, TaskKind::Write(&[2])), (3, TaskKind::Write(&[4])), (10, TaskKind::Write(&[1]))],
    needs_idle_between: true,
    error_codes: &[],
};

/// The tables of the BCG450-SP.
pub static MODEL: Model = Model {
    name: "bcg450",
    title: "BCG450-SP",
    vendor: "INFICON AG",
    manual: "tira41d1",
    ident: 0x08E6,
    features: Features { sync: false, freeze: false, dpv1: true, ms1: true },
    configurations: &CONFIGURATIONS,
    // chosen: the manual names no default. A float, and nothing that a master must send.
    default_configuration: &CONFIGURATIONS[1],
    values: &[],
    units: &UNITS,
    max_integer: INTEGER16_MAX,
    user_prm: &USER_PRM,
    dpv1_status: 0x80,
    blocks: Parameter::BLOCKS,
    parts: &[&parts::PIRANI, &parts::BA, &parts::CDG],
    channel_rules: &CHANNEL_RULES,
    // 3.1.1.11: CDG, Pirani, BA. 3.3.2.3, 3.3.3.3, 3.3.4.3: Electronics Failure includes a failure of the sensor.
    alarms: AlarmWords {
        instances: &[3, 1, 2],
        sensor: &[AlarmBit { octet: 1, mask: 1 << 1, name: text("electronics or sensor failure") }],
        manufacturer: &[(1 << 0, text("internal communication error"))],
    },
    faults: &Faults::LIST,
    errata: text(
        "errata-bpg-bcg-tpg 2 to 37, 39, 41 to 44, 46 to 52, 54 to 60, 62, 63, 69 to 81, 83 to 85, 87 to 93, 95 to 102, 104, \
             106 to 121, 158, 159",
    ),
    gsd: Gsd { revision: 1, hardware: "1.0", software: "1.01", max_diag_octets: 6, set_slave_add: true },
};
