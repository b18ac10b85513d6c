//! The tables of tira36e1, row by row. Names as printed there; where a row departs from the print, a comment says why.
//! Sections are those of the manual, numbers in brackets those of errata-bpg-bcg-tpg.

use super::codes::{ADJUST, DEGAS_STATUS, EMISSION_STATUS, HOT_CATHODE_COMMAND, SELECTOR};
use super::simulation::Faults;
use crate::model::block::{block, blocks};
use crate::model::{
    ChannelRules, Clipping, Configuration, Counts, Field, Gsd, Limits, Location, Model, NumberType, ParameterSet,
    PartSpec, PlacedBlock, Scale, TaskKind, Telegram, Unit, UserPrm, configuration, mbar, telegram,
};
use crate::profile::codes::{DATA_TYPE, DEVICE_STATE, EXCEPTIONS, SAFE_STATE, STATE_COMMAND, STATUS_EXTENSION, UNIT};
use crate::profile::{Potentiometer, Thresholds};
use crate::simulation::{Part, Principle};
use profivac_dp::slave::Features;

block! {
    /// Identity, state and exceptions of the whole device.
    pub DeviceBlock = "Device Block", type 1;
    // ID  parameter                    name as printed                              data type    access           store  section
    // "Device Block State" in the overview; 3.1.2.1 prints N, but a command is never kept (35).
    15 StateCommand               "Device Block State Command"                   UINT8        [1_R/W 2_R/W]    -  "3.1.2.1" STATE_COMMAND;
    16 BlockType                  "Block Type"                                   OSTRING(4)   [1/2_R]          N  "3.1.1.1";
    17 DeviceType                 "Device Type"                                  VSTRING(8)   [1/2_R]          N  "3.1.1.2";
    18 StandardRevision           "Standard Revision Level"                      VSTRING(9)   [1/2_R]          N  "3.1.1.3";
    19 Manufacturer               "Device Manufacturer Identifier"               VSTRING(20)  [1/2_R]          N  "3.1.1.4";
    20 ModelNumber                "Manufacturer Model Number"                    VSTRING(20)  [1/2_R]          N  "3.1.1.5";
    21 SoftwareRevision           "Software or Firmware Revision Level"          VSTRING(8)   [1/2_R]          N  "3.1.1.6";
    22 HardwareRevision           "Hardware Revision Level"                      VSTRING(8)   [1/2_R]          N  "3.1.1.7";
    23 SerialNumber               "Serial Number"                                VSTRING(30)  [1/2_R]          N  "3.1";
    24 DeviceConfiguration        "Device Configuration"                         VSTRING(50)  [1/2_R]          N  "3.1.1.8";
    25 DeviceState                "Device State"                                 UINT8        [1/2_R]          V  "3.1.1.9" DEVICE_STATE;
    26 ExceptionStatus            "Exception Status"                             UINT8        [0_XI 1/2_R]     V  "3.1.1.10" EXCEPTIONS;
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
    /// The switches on the side of the HPG400-SP. Printed in one table with the rows above, which does not say whose they
    /// are (38).
    pub SideSwitches = "Device Block (HPG400-SP only)";
    // Printed as one octet; the value is a pressure (38).
    202 EmissionOnSwitch          "Emission On Switch"                           BY_TYPE      [1/2_R]          V  "3.1.1.13";
    203 SensorCalibrationSwitch   "Sensor Calibration Switch"                    UINT8        [1/2_R]          V  "3.1.1.14";
}

block! {
    /// Which instance measures, and which one the shared indices show.
    pub OneOfNInput = "One Of N Analog Input Function Block", type 3;
    15 AdjustCommand              "AI Block Adjust Command"                      UINT8        [1/2_W]          -  "3.2.1.1" ADJUST;
    16 BlockType                  "Block Type"                                   OSTRING(4)   [2_R]            N  "3.2.1.2";
    46 ChannelInstanceSelector    "Channel Instance Selector"                    UINT8        [1/2_R/W]        N  "3.2.1.3" SELECTOR;
    47 PvSelector                 "PV Selector"                                  UINT8        [0_XI 1/2_R]     D  "3.2.1.4";
}

block! {
    /// The pressure of one measuring part, with the sections of instance 1; 3.2.3 repeats them for 2. No block type is
    /// printed (33).
    pub AnalogInput = "Analog Sensor Input Function Block";
    19 ProcessValue               "Process Value (PV)"                           BY_TYPE      [0_XI 1_R 2_R]   D  "3.2.2.1";
    20 Status                     "Status"                                       UINT8        [0_XI 1/2_R]     D  "3.2.2.2";
    21 DataType                   "Data Type"                                    UINT8        [2_R/W]          N  "3.2.2.3" DATA_TYPE;
    22 DataUnits                  "Data Units"                                   UINT16       [2_R/W]          N  "3.2.2.4" UNIT;
    23 ReadingValid               "Reading Valid"                                BOOLEAN      [1_R 2_R]        D  "3.2.2.5";
    24 FullScale                  "Full Scale"                                   BY_TYPE      [1/2_R]          N  "3.2.2.6";
    39 SafeState                  "Safe State"                                   UINT8        [1/2_R/W]        N  "3.2.2.7" SAFE_STATE;
    40 SafeValue                  "Safe Value"                                   BY_TYPE      [1/2_R/W]        N  "3.2.2.8";
    44 Overrange                  "Overrange"                                    BY_TYPE      [1/2_R]          N  "3.2.2.9";
    45 Underrange                 "Underrange"                                   BY_TYPE      [1/2_R]          N  "3.2.2.10";
}

block! {
    /// A switching function and its threshold.
    pub SetPoint = "Analog Sensor Input Function Block (set point)";
    // Printed as Unsigned16 without a length; the text says data type and unit of the device (71).
    19 ProcessValue               "Process Value (PV)"                           BY_TYPE      [1_R 2_R]        D  "3.2.4.1";
    20 Status                     "Status"                                       UINT8        [1_R 2_R]        D  "3.2.4.2";
    21 DataType                   "Data Type"                                    UINT8        [2_R 2_W]        N  "3.2.4.3" DATA_TYPE;
    22 DataUnits                  "Data Units"                                   UINT16       [2_R 2_W]        N  "3.2.4.4" UNIT;
    23 ReadingValid               "Reading Valid"                                BOOLEAN      [1_R 2_R]        D  "3.2.4.5";
}

block! {
    /// The range of the whole gauge.
    pub OneOfNTransducer = "One Of N Vacuum Gauge Transducer Block";
    120 StatusExtension           "One Of N Status Extension"                    UINT8        [1_R 2_R]        V  "3.3.1.1" STATUS_EXTENSION;
}

block! {
    /// The Pirani.
    pub HeatTransfer = "Heat Transfer Vacuum Gauge Transducer Block", type 13;
    101 BlockType                 "Block Type"                                   OSTRING(4)   [2_R]            -  "3.3.2.1";
    102 StatusExtension           "Status Extension"                             UINT8        [1/2_R]          V  "3.3.2.2" STATUS_EXTENSION;
    103 SensorAlarm               "Sensor Alarm"                                 ARRAY(2)     [1/2_R]          V  "3.3.2.3";
    104 SensorWarning             "Sensor Warning"                               ARRAY(2)     [1/2_R]          V  "3.3.2.4";
    140 FullScaleState            "Full Scale State"                             UINT8        [1/2_R]          V  "3.3.2.5";
}

block! {
    /// The ionisation part: Bayard-Alpert in the BPG400-SP, High Pressure in the HPG400-SP.
    pub HotCathode = "Hot Cathode Ion Gauge Transducer Block", type 16;
    101 BlockType                 "Block Type"                                   OSTRING(4)   [2_R]            -  "3.3.3.1";
    102 StatusExtension           "Status Extension"                             UINT8        [1_R 2_R]        V  "3.3.3.2" STATUS_EXTENSION;
    103 SensorAlarm               "Sensor Alarm"                                 ARRAY(2)     [1_R 2_R]        V  "3.3.3.3";
    104 SensorWarning             "Sensor Warning"                               ARRAY(2)     [1_R 2_R]        V  "3.3.3.4";
    // Printed as Boolean, with four codes (97).
    105 EmissionStatus            "Emission Status"                              UINT8        [1_R/W 2_R/W]    V  "3.3.3.5" EMISSION_STATUS;
}

block! {
    /// Current and degas of the BPG400-SP, of the same table as the rows above (94).
    pub Degas = "Hot Cathode Ion Gauge Transducer Block (BPG400-SP only)";
    // Two octets, command and value; 1 is printed (93).
    14 StateCommand               "Hot Cathode Block State Command"              RECORD(2)    [1_W 2_W]        -  "3.3.3.8" HOT_CATHODE_COMMAND;
    // Printed NV, but the gauge chooses the current, so there is nothing to keep (98).
    106 EmissionCurrent           "Emission Current"                             FLOAT        [1_R/W 2_R/W]    V  "3.3.3.6";
    // Printed as Boolean, with the codes 00 and 03 (99).
    109 DegasStatus               "Degas Status"                                 UINT8        [1_R 2_R]        V  "3.3.3.7" DEGAS_STATUS;
}

blocks! {
    /// All parameters. Slot 1 shows one instance at a time (27, 28). The list is that of a BPG400-SP; [`HPG_PLACES`] is the
    /// other.
    pub Parameter;
    Device(DeviceBlock)                [0 "Device"];
    SideSwitches(SideSwitches)         [];
    OneOfNInput(OneOfNInput)           [1 "One Of N"];
    Input(AnalogInput)                 [1:1 "Pirani", 1:2 "BA"];
    SetPoint(SetPoint)                 [1:3 "Setpoint A", 1:4 "Setpoint B"];
    OneOfNTransducer(OneOfNTransducer) [1 "One Of N"];
    HeatTransfer(HeatTransfer)         [1:1 "Pirani"];
    HotCathode(HotCathode)             [1:2 "BA"];
    Degas(Degas)                       [1:2 "BA"];
}

const fn at(slot: u8, instance: u8, name: &'static str) -> Location {
    Location { slot, instance, name }
}

/// The same of an HPG400-SP.
#[rustfmt::skip]
pub static HPG_PLACES: [PlacedBlock; 9] = [
    PlacedBlock { block: &DeviceBlock::BLOCK,      locations: &[at(0, 0, "Device")] },
    PlacedBlock { block: &SideSwitches::BLOCK,     locations: &[at(0, 0, "Device")] },
    PlacedBlock { block: &OneOfNInput::BLOCK,      locations: &[at(1, 0, "One Of N")] },
    PlacedBlock { block: &AnalogInput::BLOCK,      locations: &[at(1, 1, "Pirani"), at(1, 2, "HP")] },
    PlacedBlock { block: &SetPoint::BLOCK,         locations: &[at(1, 3, "Setpoint A"), at(1, 4, "Setpoint B")] },
    PlacedBlock { block: &OneOfNTransducer::BLOCK, locations: &[at(1, 0, "One Of N")] },
    PlacedBlock { block: &HeatTransfer::BLOCK,     locations: &[at(1, 1, "Pirani")] },
    PlacedBlock { block: &HotCathode::BLOCK,       locations: &[at(1, 2, "HP")] },
    PlacedBlock { block: &Degas::BLOCK,            locations: &[] },
];

/// The instances of slot 1 that the selector can name.
pub const INSTANCES: core::ops::RangeInclusive<u8> = 1..=4;

// 2.3; the numbers are not those of the BCG450-SP (13).
use Field::{ExceptionStatus, ParameterChannel, ProcessValue, PvSelector, StatusExtension};
use NumberType::{Float, Integer};

static T1: Telegram = telegram(1, &[ParameterChannel]);
static T2: Telegram = telegram(2, &[ExceptionStatus, StatusExtension, PvSelector, ProcessValue(Integer)]);
static T3: Telegram = telegram(3, &[ExceptionStatus, StatusExtension, PvSelector, ProcessValue(Float)]);
static T4: Telegram =
    telegram(4, &[ParameterChannel, ExceptionStatus, StatusExtension, PvSelector, ProcessValue(Integer)]);
static T5: Telegram =
    telegram(5, &[ParameterChannel, ExceptionStatus, StatusExtension, PvSelector, ProcessValue(Float)]);

/// 2.3; the last octet of the last string is printed without its 0 (1).
#[rustfmt::skip]
static CONFIGURATIONS: [Configuration; 4] = [
    configuration(None,      Some(&T2), &[0x44, 0x84, 0x05, 0x05, 0x05, 0x03]),
    configuration(None,      Some(&T3), &[0x44, 0x86, 0x05, 0x05, 0x05, 0x08]),
    configuration(Some(&T1), Some(&T4), &[0xC6, 0x87, 0x8C, 0x0A, 0x0A, 0x05, 0x05, 0x05, 0x03]),
    configuration(Some(&T1), Some(&T5), &[0xC6, 0x87, 0x8E, 0x0A, 0x0A, 0x05, 0x05, 0x05, 0x08]),
];

/// 3.2.2.1 and 3.2.2.4; the codes are decimal (5), the factor of Micron is 1000 (60), the factors are the printed ones (83).
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

/// 10^(COUNTS/2000 - 12.5) mbar for every instance of the BPG400-SP (59).
const BPG_COUNTS: Counts = Counts::Log { per_decade: 2000.0, at_1_mbar: 25000.0 };

// The HPG400-SP has three scales (64).
/// 10^(6 x COUNTS/4000 - 42.5) mbar: Pirani and Emission On Switch (66).
const HPG_PIRANI_COUNTS: Counts = Counts::Log { per_decade: 4000.0 / 6.0, at_1_mbar: 42.5 * 4000.0 / 6.0 };
/// 10^(6 x COUNTS/16000 - 9.125) mbar.
const HP_COUNTS: Counts = Counts::Log { per_decade: 16000.0 / 6.0, at_1_mbar: 9.125 * 16000.0 / 6.0 };
/// 10^((COUNTS - 22999)/2444) mbar, with the printed constants (65).
const HPG_SET_POINT_COUNTS: Counts = Counts::Log { per_decade: 2444.0, at_1_mbar: 22999.0 };

const PIRANI: Part = Part { instance: 1, principle: Principle::Pirani };
const ION: Part = Part { instance: 2, principle: Principle::HotCathode };

/// The measuring parts.
pub static PARTS: [Part; 2] = [PIRANI, ION];

/// 3.2.2.6, 3.2.2.9, 3.2.2.10. Above overrange the value goes on (53).
static BPG_PIRANI: PartSpec = PartSpec {
    part: PIRANI,
    limits: Limits { under_pa: mbar(5.5e-3), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) },
    clipping: Clipping::Below,
    counts: BPG_COUNTS,
};

static HPG_PIRANI: PartSpec = PartSpec {
    part: PIRANI,
    limits: Limits { under_pa: mbar(1e-2), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) },
    clipping: Clipping::Below,
    counts: HPG_PIRANI_COUNTS,
};

/// 3.2.3.6, 3.2.3.9, 3.2.3.10 (61)
static BA: PartSpec = PartSpec {
    part: ION,
    limits: Limits { under_pa: mbar(5e-10), over_pa: mbar(2e-2), full_scale_pa: mbar(2e-2) },
    clipping: Clipping::Above,
    counts: BPG_COUNTS,
};

static HP: PartSpec = PartSpec {
    part: ION,
    limits: Limits { under_pa: mbar(1e-6), over_pa: mbar(1.0), full_scale_pa: mbar(1.0) },
    clipping: Clipping::Above,
    counts: HP_COUNTS,
};

/// Where the ionisation part takes over from the Pirani (3.2.1.4).
#[derive(Debug)]
pub struct Switchover {
    /// Below this pressure of the Pirani the ionisation part measures, in Pa; no hysteresis (77).
    pub pa: f64,
    /// When its emission is switched.
    pub emission: Thresholds,
}

/// free choice: the manual has no thresholds of the emission, these are those of the sister gauges. The operating current
/// changes at the limit of degas.
pub static BPG_SWITCHOVER: Switchover = Switchover {
    pa: mbar(5.5e-3),
    emission: Thresholds { off_pa: mbar(3.2e-2), on_pa: mbar(2.4e-2), degas_pa: mbar(7.2e-6) },
};

/// The emission of the HPG400-SP goes on where the switchover is (82).
///
/// free choice: it goes off a third above it, as far as on the sister gauges. There is one current and no degas.
const fn switchover(at_mbar: f64) -> Switchover {
    let pa = mbar(at_mbar);
    Switchover { pa, emission: Thresholds { off_pa: pa * 4.0 / 3.0, on_pa: pa, degas_pa: 0.0 } }
}

/// 3.1.1.13: for each two positions of LOW-HIGH, from 0 on (66).
static HPG_SWITCHOVER: [Switchover; 5] =
    [switchover(1.0), switchover(0.5), switchover(0.2), switchover(0.1), switchover(0.05)];

/// The switchover of the HPG400-SP at this position of LOW-HIGH, 0 to 9.
pub const fn hpg_switchover(position: u8) -> &'static Switchover {
    let [high, second, third, fourth, low] = &HPG_SWITCHOVER;
    match position {
        0 | 1 => high,
        2 | 3 => second,
        4 | 5 => third,
        6 | 7 => fourth,
        _ => low,
    }
}

/// 3.2.4.1: above 100 mbar the switching functions do not work (107).
const HIGHEST_SET_POINT_PA: f64 = mbar(100.0);

static BPG_POTENTIOMETER: Potentiometer =
    Potentiometer { per_volt: 1.23011, at_0_v: -9.301_029_99, highest_pa: HIGHEST_SET_POINT_PA };

static HPG_POTENTIOMETER: Potentiometer =
    Potentiometer { per_volt: 0.9, at_0_v: -6.0, highest_pa: HIGHEST_SET_POINT_PA };

/// 2.2.1.1
static DIALECT: ChannelRules = ChannelRules {
    tasks: &[(1, TaskKind::Read), (2, TaskKind::Write(&[2])), (3, TaskKind::Write(&[4])), (10, TaskKind::Write(&[1]))],
    needs_idle_between: true,
    error_codes: &[],
};

/// All that tells one gauge from the other.
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
    pub potentiometer: &'static Potentiometer,
    /// COUNTS of the set points.
    pub set_point_counts: Counts,
}

const fn model(
    name: &'static str,
    title: &'static str,
    ident: u16,
    places: &'static [PlacedBlock],
    ranges: &'static [&'static PartSpec],
) -> Model {
    Model {
        name,
        title,
        vendor: "INFICON AG",
        manual: "tira36e1",
        ident,
        features: Features { sync: false, freeze: false, dpv1: true, ms1: true },
        configurations: &CONFIGURATIONS,
        // free choice: the manual names no default. A float, and nothing that a master must send.
        default_configuration: &CONFIGURATIONS[1],
        units: &UNITS,
        user_prm: &USER_PRM,
        dpv1_status: 0x80,
        blocks: places,
        parts: ranges,
        channel_rules: &DIALECT,
        faults: &Faults::LIST,
        // Revisions as 3.1.1.6 and 3.1.1.7 print them (36).
        errata: "errata-bpg-bcg-tpg 1, 3 to 10, 12 to 40, 45, 47 to 77, 81 to 95, 97 to 99, 103, 105 to 109, 117 to 119, 121",
        gsd: Gsd { revision: 1, hardware: "1.0", software: "1.01", max_diag_octets: 6, set_slave_add: true },
    }
}

/// The BPG400-SP.
pub static BPG400: Variant = Variant {
    model: model("bpg400", "BPG400-SP", 0x06A9, Parameter::PLACES, &[&BPG_PIRANI, &BA]),
    number: "353-505",
    pirani: &BPG_PIRANI,
    ion: &BA,
    range: Limits { under_pa: mbar(5e-10), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) },
    potentiometer: &BPG_POTENTIOMETER,
    set_point_counts: BPG_COUNTS,
};

/// The HPG400-SP.
pub static HPG400: Variant = Variant {
    model: model("hpg400", "HPG400-SP", 0x06A8, &HPG_PLACES, &[&HPG_PIRANI, &HP]),
    number: "353-525",
    pirani: &HPG_PIRANI,
    ion: &HP,
    range: Limits { under_pa: mbar(1e-6), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) },
    potentiometer: &HPG_POTENTIOMETER,
    set_point_counts: HPG_SET_POINT_COUNTS,
};
