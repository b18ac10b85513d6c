//! The tables of tira36e1, row by row, with the names as printed. Where a row departs from the print, a comment says
//! why. Sections are those of the manual, numbers in brackets those of errata-bpg-bcg-tpg.

use super::codes::{AdjustCommand, DegasStatus, EmissionStatus, HotCathodeCommand, Selector};
use super::faults::Faults;
use super::parts;
use crate::model::block_macros::{block, blocks};
use crate::model::{
    AlarmBit, AlarmWords, ChannelRules, Configuration, Counts, Field, Gsd, INTEGER16_MAX, Limits, Location, Model,
    NumberType, ParameterSet, PartSpec, PlacedBlock, Scale, TaskKind, Telegram, Unit, UserPrm, configuration, telegram,
    text,
};
use crate::profile::codes::{Milliamperes, UnitCode};
use crate::profile::{DeviceState, ExceptionStatus, PotentiometerScale, SafeState, StateCommand, StatusExtension};
use profivac_dp::slave::Features;

block! {
    /// Identity, state and exceptions of the whole device.
    pub DeviceBlock in device_block = "Device Block", type 1;
    // ID parameter                 name as printed                                data type    access        store  section
    // "Device Block State" in the overview; 3.1.2.1 prints N, but a command is never kept (35).
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
    27 AlarmDetail                "Exception Detail Alarm"                       RECORD(10)   [1/2_R]          V  "3.1.1.11";
    28 WarningDetail              "Exception Detail Warning"                     RECORD(11)   [1/2_R]          V  "3.1.1.12";
    204 AlarmCommon               "Common Exception Detail Alarm 0"              UINT8        [1/2_R]          V  "3.1.1.15";
    205 AlarmDevice               "Device Exception Detail Alarm 0 ... 3"        ARRAY(4)     [1/2_R]          V  "3.1.1.16";
    206 AlarmManufacturer         "Manufacturer Exception Detail Alarm 0"        UINT8        [1/2_R]          V  "3.1.1.17";
    207 WarningCommon             "Common Exception Detail Warning 0"            UINT8        [1/2_R]          V  "3.1.1.18";
    // Without the status extension before it (40).
    208 WarningDevice             "Device Exception Detail Warning 1 ... 4"      ARRAY(4)     [1/2_R]          V  "3.1.1.19";
    209 WarningManufacturer       "Manufacturer Exception Detail Warning 0"      UINT8        [1/2_R]          V  "3.1.1.20";
}

block! {
    /// The switches on the side of the HPG400-SP. They are printed in one table with the rows above, which does not say
    /// to which gauge they belong (38).
    pub SideSwitches in side_switches = "Device Block (HPG400-SP only)";
    // Printed as one octet; the value is a pressure (38).
    202 EmissionOnSwitch          "Emission On Switch"                           BY_TYPE      [1/2_R]          V  "3.1.1.13";
    203 SensorCalibrationSwitch   "Sensor Calibration Switch"                    UINT8        [1/2_R]          V  "3.1.1.14";
}

block! {
    /// The instance that measures, and the instance that the shared indices show.
    pub OneOfNInput in one_of_n_input = "One Of N Analog Input Function Block", type 3;
    15 AdjustCommand              "AI Block Adjust Command"                      UINT8        [1/2_W]          -  "3.2.1.1" AdjustCommand;
    16 BlockType                  "Block Type"                                   OSTRING(4)   [2_R]            N  "3.2.1.2";
    46 ChannelInstanceSelector    "Channel Instance Selector"                    UINT8        [1/2_R/W]        N  "3.2.1.3" Selector;
    47 PvSelector                 "PV Selector"                                  UINT8        [0_XI 1/2_R]     D  "3.2.1.4";
}

block! {
    /// The pressure of one measuring part, with the sections of instance 1; 3.2.3 repeats them for 2. No block type is
    /// printed (33).
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
    /// A switching function and its threshold.
    pub SetPoint in set_point = "Analog Sensor Input Function Block (set point)";
    // Printed as Unsigned16 without a length; the text says data type and unit of the device (71).
    19 ProcessValue               "Process Value (PV)"                           BY_TYPE      [1_R 2_R]        D  "3.2.4.1";
    20 Status                     "Status"                                       UINT8        [1_R 2_R]        D  "3.2.4.2";
    21 DataType                   "Data Type"                                    UINT8        [2_R 2_W]        N  "3.2.4.3" NumberType;
    22 DataUnits                  "Data Units"                                   UINT16       [2_R 2_W]        N  "3.2.4.4" UnitCode;
    23 ReadingValid               "Reading Valid"                                BOOLEAN      [1_R 2_R]        D  "3.2.4.5";
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
    140 FullScaleState            "Full Scale State"                             UINT8        [1/2_R]          V  "3.3.2.5";
}

block! {
    /// The ionisation part: Bayard-Alpert in the BPG400-SP, High Pressure in the HPG400-SP.
    pub HotCathode in hot_cathode = "Hot Cathode Ion Gauge Transducer Block", type 16;
    101 BlockType                 "Block Type"                                   OSTRING(4)   [2_R]            -  "3.3.3.1";
    102 StatusExtension           "Status Extension"                             UINT8        [1_R 2_R]        V  "3.3.3.2" StatusExtension;
    103 SensorAlarm               "Sensor Alarm"                                 ARRAY(2)     [1_R 2_R]        V  "3.3.3.3";
    104 SensorWarning             "Sensor Warning"                               ARRAY(2)     [1_R 2_R]        V  "3.3.3.4";
    // Printed as Boolean, with four codes (97).
    105 EmissionStatus            "Emission Status"                              UINT8        [1_R/W 2_R/W]    V  "3.3.3.5" EmissionStatus;
}

block! {
    /// Current and degas of the BPG400-SP, of the same table as the rows above (94).
    pub Degas in degas = "Hot Cathode Ion Gauge Transducer Block (BPG400-SP only)";
    // Two octets, command and value; 1 is printed (93).
    14 StateCommand               "Hot Cathode Block State Command"              RECORD(2)    [1_W 2_W]        -  "3.3.3.8" HotCathodeCommand;
    // Printed NV, but the gauge chooses the current, so there is nothing to keep (98).
    106 EmissionCurrent           "Emission Current"                             FLOAT        [1_R/W 2_R/W]    V  "3.3.3.6" Milliamperes;
    // Printed as Boolean, with the codes 00 and 03 (99).
    109 DegasStatus               "Degas Status"                                 UINT8        [1_R 2_R]        V  "3.3.3.7" DegasStatus;
}

/// The device block.
pub const DEVICE: Location = Location::slot(0, "Device");
/// The blocks that choose the instance.
pub const ONE_OF_N: Location = Location::slot(1, "One Of N");
/// The Pirani.
pub const PIRANI: Location = Location::instance(1, 1, "Pirani");
/// The Bayard-Alpert part of the BPG400-SP.
pub const BA: Location = Location::instance(1, 2, "BA");
/// The High Pressure ionisation part of the HPG400-SP.
pub const HP: Location = Location::instance(1, 2, "HP");
/// The first switching function.
pub const SETPOINT_A: Location = Location::instance(1, 3, "Setpoint A");
/// The second switching function.
pub const SETPOINT_B: Location = Location::instance(1, 4, "Setpoint B");

blocks! {
    /// All parameters. Slot 1 shows one instance at a time (27, 28). The list is that of a BPG400-SP; [`HPG_BLOCKS`] is
    /// the other.
    pub Parameter;
    Device(DeviceBlock)                [DEVICE];
    SideSwitches(SideSwitches)         [];
    OneOfNInput(OneOfNInput)           [ONE_OF_N];
    Input(AnalogInput)                 [PIRANI, BA];
    SetPoint(SetPoint)                 [SETPOINT_A, SETPOINT_B];
    OneOfNTransducer(OneOfNTransducer) [ONE_OF_N];
    HeatTransfer(HeatTransfer)         [PIRANI];
    HotCathode(HotCathode)             [BA];
    Degas(Degas)                       [BA];
}

/// The position of the block of the set points.
pub const SET_POINT_BLOCK: usize = 4;

/// The blocks of an HPG400-SP.
#[rustfmt::skip]
pub static HPG_BLOCKS: [PlacedBlock; 9] = [
    PlacedBlock { block: &DeviceBlock::BLOCK,      locations: &[DEVICE] },
    PlacedBlock { block: &SideSwitches::BLOCK,     locations: &[DEVICE] },
    PlacedBlock { block: &OneOfNInput::BLOCK,      locations: &[ONE_OF_N] },
    PlacedBlock { block: &AnalogInput::BLOCK,      locations: &[PIRANI, HP] },
    PlacedBlock { block: &SetPoint::BLOCK,         locations: &[SETPOINT_A, SETPOINT_B] },
    PlacedBlock { block: &OneOfNTransducer::BLOCK, locations: &[ONE_OF_N] },
    PlacedBlock { block: &HeatTransfer::BLOCK,     locations: &[PIRANI] },
    PlacedBlock { block: &HotCathode::BLOCK,       locations: &[HP] },
    PlacedBlock { block: &Degas::BLOCK,            locations: &[] },
];

// 2.3; the numbers are not those of the BCG450-SP (13).
static T1: Telegram = telegram(1, &[Field::ParameterChannel]);
static T2: Telegram = telegram(
    2,
    &[Field::ExceptionStatus, Field::StatusExtension, Field::PvSelector, Field::ProcessValue(NumberType::Integer)],
);
static T3: Telegram = telegram(
    3,
    &[Field::ExceptionStatus, Field::StatusExtension, Field::PvSelector, Field::ProcessValue(NumberType::Float)],
);
static T4: Telegram = telegram(
    4,
    &[
        Field::ParameterChannel,
        Field::ExceptionStatus,
        Field::StatusExtension,
        Field::PvSelector,
        Field::ProcessValue(NumberType::Integer),
    ],
);
static T5: Telegram = telegram(
    5,
    &[
        Field::ParameterChannel,
        Field::ExceptionStatus,
        Field::StatusExtension,
        Field::PvSelector,
        Field::ProcessValue(NumberType::Float),
    ],
);

/// 2.3; the last octet of the last string is printed without its 0 (1).
#[rustfmt::skip]
static CONFIGURATIONS: [Configuration; 4] = [
    configuration(None,      Some(&T2), &[0x44, 0x84, 0x05, 0x05, 0x05, 0x03]),
    configuration(None,      Some(&T3), &[0x44, 0x86, 0x05, 0x05, 0x05, 0x08]),
    configuration(Some(&T1), Some(&T4), &[0xC6, 0x87, 0x8C, 0x0A, 0x0A, 0x05, 0x05, 0x05, 0x03]),
    configuration(Some(&T1), Some(&T5), &[0xC6, 0x87, 0x8E, 0x0A, 0x0A, 0x05, 0x05, 0x05, 0x08]),
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
    UserPrm { name: "COUNTS", octets: &[0x00, 0x00, 0x00, 0x03, 0xE9] },
    UserPrm { name: "Torr",   octets: &[0x00, 0x00, 0x00, 0x05, 0x15] },
    UserPrm { name: "Micron", octets: &[0x00, 0x00, 0x00, 0x05, 0x16] },
    UserPrm { name: "mbar",   octets: &[0x00, 0x00, 0x00, 0x05, 0x1C] },
    UserPrm { name: "Pascal", octets: &[0x00, 0x00, 0x00, 0x05, 0x1D] },
];

/// The unit as it leaves the factory (73).
pub const FACTORY_UNIT: &Unit = &UNITS[3];

/// 2.2.1.1
static CHANNEL_RULES: ChannelRules = ChannelRules {
    tasks: &[(1, TaskKind::Read), (2, TaskKind::Write(&[2])), (3, TaskKind::Write(&[4])), (10, TaskKind::Write(&[1]))],
    needs_idle_between: true,
    error_codes: &[],
};

/// The properties in which the two gauges differ.
#[derive(Debug)]
pub struct Variant {
    /// The tables.
    pub model: Model,
    /// Manufacturer Model Number, with the flange DN 25 ISO-KF (37).
    pub number: &'static str,
    /// The Pirani.
    pub pirani: &'static PartSpec,
    /// The ionisation part.
    pub ion: &'static PartSpec,
    /// The range of the whole gauge (58).
    pub range: Limits,
    /// The potentiometers of the set points (109).
    pub potentiometer: &'static PotentiometerScale,
    /// COUNTS of the set points.
    pub set_point_counts: Counts,
}

const fn model(
    name: &'static str,
    title: &'static str,
    ident: u16,
    blocks: &'static [PlacedBlock],
    parts: &'static [&'static PartSpec],
) -> Model {
    Model {
        name,
        title,
        vendor: "INFICON AG",
        manual: "tira36e1",
        ident,
        features: Features { sync: false, freeze: false, dpv1: true, ms1: true },
        configurations: &CONFIGURATIONS,
        // chosen: the manual names no default. A float, and nothing that a master must send.
        default_configuration: &CONFIGURATIONS[1],
        values: &[],
        units: &UNITS,
        max_integer: INTEGER16_MAX,
        user_prm: &USER_PRM,
        dpv1_status: 0x80,
        blocks,
        parts,
        channel_rules: &CHANNEL_RULES,
        // 3.1.1.11: Pirani, BA or HP. 3.3.2.3, 3.3.3.3: Electronics Failure includes a sensor error.
        alarms: AlarmWords {
            instances: &[1, 2],
            sensor: &[AlarmBit { octet: 1, mask: 1 << 1, name: "electronics or sensor failure" }],
            manufacturer: &[(1 << 0, "internal communication error")],
        },
        faults: &Faults::LIST,
        // Revisions as 3.1.1.6 and 3.1.1.7 print them (36).
        errata: text(
            "errata-bpg-bcg-tpg 1, 3 to 10, 12 to 40, 45, 47 to 77, 81 to 95, 97 to 99, 103, 105 to 109, 117 to 119, 121, 158",
        ),
        gsd: Gsd { revision: 1, hardware: "1.0", software: "1.01", max_diag_octets: 6, set_slave_add: true },
    }
}

/// The BPG400-SP.
pub static BPG400: Variant = Variant {
    model: model("bpg400", "BPG400-SP", 0x06A9, Parameter::BLOCKS, &[&parts::BPG_PIRANI, &parts::BA]),
    number: "353-505",
    pirani: &parts::BPG_PIRANI,
    ion: &parts::BA,
    range: parts::BPG_GAUGE,
    potentiometer: &parts::BPG_POTENTIOMETER,
    set_point_counts: parts::BPG_COUNTS,
};

/// The HPG400-SP.
pub static HPG400: Variant = Variant {
    model: model("hpg400", "HPG400-SP", 0x06A8, &HPG_BLOCKS, &[&parts::HPG_PIRANI, &parts::HP]),
    number: "353-525",
    pirani: &parts::HPG_PIRANI,
    ion: &parts::HP,
    range: parts::HPG_GAUGE,
    potentiometer: &parts::HPG_POTENTIOMETER,
    set_point_counts: parts::HPG_SET_POINT_COUNTS,
};
