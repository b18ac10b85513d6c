//! The tables of BG 5530 BEN/A (IF 400 P for IMG 400), row by row. Where a row departs from the print, a comment says
//! why. Sections are those of the manual, numbers in brackets those of errata-pxg55x-img400.

use super::codes::{
    ADJUST, CHANNEL, DEGAS_STATUS, DEVICE_STATE, EMISSION_CURRENT, EMISSION_STATUS, HOT_CATHODE_COMMAND, KEY_LOCK,
    RESET_ERRORS,
};
use crate::model::block::{block, blocks};
use crate::model::{
    ChannelRules, Clipping, Configuration, Counts, Field, Gsd, Limits, Model, NumberType, ParameterSet, PartSpec,
    Scale, TaskKind, Telegram, Unit, UserPrm, configuration, faults, mbar, telegram,
};
use crate::profile::Thresholds;
use crate::profile::codes::{DATA_TYPE, EXCEPTIONS, SAFE_STATE, STATE_COMMAND, STATUS_EXTENSION, UNIT};
use crate::simulation::{Part, Principle};
use profivac_dp::slave::Features;

block! {
    /// The controller as a whole. Identity and exception details are promised in the text and do not exist (120).
    pub DeviceBlock = "Device Block", type 1;
    // ID parameter         name as printed                               data type  access            store, section
    // Table 1 leaves the store class blank: a command is never kept (26).
    15 StateCommand         "Device Block State"                          UINT8      [1_R/W 2_R/W]     - "4.4.1" STATE_COMMAND;
    16 BlockType            "Block Type ID"                               OSTRING(4) [1_R 2_R]         N "4.4.1";
    25 DeviceState          "Device State"                                UINT8      [1_R 2_R]         V "4.4.1" DEVICE_STATE;
    26 ExceptionStatus      "Exception Status"                            UINT8      [0_XI 1_R 2_R]    V "4.4.1" EXCEPTIONS;
    203 KeyLock             "Key Lock"                                    UINT8      [1_R/W 2_R/W]     V "4.4.1" KEY_LOCK;
    204 ChannelStatus       "Channel Status"                              OSTRING(2) [0_XI 1_R 2_R]    V "4.4.1";
    205 ResetErrorCondition "Reset Error Condition"                       UINT8      [1_W 2_W]         V "4.4.1" RESET_ERRORS;
}

block! {
    /// The pressure of one channel.
    pub AnalogInput = "Sensor Analog Input Function Block", type 2;
    // 2R/W without a length in table 3, both classes and two octets in the record table (130).
    15 BlockAdjustCommand   "Block Adjust Command"                        RECORD(2)  [1/2_R/W]         - "4.4.2" ADJUST;
    // A record without a length in print (132).
    16 BlockType            "Block Type ID"                               OSTRING(4) [2R]              N "4.4.2";
    19 ProcessValue         "ProcessValue (PV)"                           BY_TYPE    [0_XI 1_R 2_R]    D "4.4.2";
    20 Status               "Status"                                      UINT8      [1_R 2_R]         D "4.4.2";
    21 DataType             "Data Type"                                   UINT8      [2_R 2_W]         N "4.4.2" DATA_TYPE;
    // Only the user parameters change it (143).
    22 DataUnits            "Data Units"                                  UINT16     [2_R prm]         N "4.4.2" UNIT;
    23 ReadingValid         "Reading Valid"                               BOOLEAN    [1_R 2_R]         D "4.4.2";
    24 FullScale            "Full Scale"                                  BY_TYPE    [1_R 2_R]         N "4.4.2";
    39 SafeState            "Safe State"                                  UINT8      [1_R 1_W 2_R 2_W] N "4.4.2" SAFE_STATE;
    40 SafeValue            "Safe Value"                                  BY_TYPE    [1_R 1_W 2_R 2_W] N "4.4.2";
    44 Overrange            "Overrange"                                   BY_TYPE    [1_R 2_R]         N "4.4.2";
    45 Underrange           "Underrange"                                  BY_TYPE    [1_R 2_R]         N "4.4.2";
}

block! {
    /// A relay that closes below a pressure. There is no high trip point (146).
    pub TripPoint = "Trip Function Block", type 17;
    // A record without a length in print (132).
    16 BlockType            "Block Type ID"                               OSTRING(4) [2R]              - "4.4.3";
    19 LowTripPoint         "Low Trip Point"                              BY_TYPE    [1_R/W 2_R/W]     N "4.4.3";
    20 LowTripEnable        "Low Trip Enable"                             BOOLEAN    [1_R/W 2_R/W]     N "4.4.3";
    21 Status               "Status"                                      UINT8      [0_XI 1_R 2_R]    V "4.4.3";
    24 Hysteresis           "Hysteresis"                                  BY_TYPE    [1_R/W 2_R/W]     N "4.4.3";
    27 Channel              "Analog Input Sensor Function Block Instance" UINT8      [1_R/W 2_R/W]     N "4.4.3" CHANNEL;
    28 DataUnits            "Data Unit"                                   UINT16     [2_R]             N "4.4.3" UNIT;
    29 DataType             "Data Type"                                   UINT8      [2_R]             N "4.4.3" DATA_TYPE;
    // 1 byte in print (139).
    201 UpperThreshold      "Low Trip Upper Threshold"                    BY_TYPE    [1_R/W 2_R/W]     N "4.4.3";
}

block! {
    /// Channel 1 or 2: a Bayard-Alpert or extractor gauge, or none.
    pub HotCathode = "Hot Cathode Ion Gauge Transducer Block", type 16;
    // Store N in the second table only: a command is never kept (150).
    14 StateCommand         "Hot Cathode Block State Command"             RECORD(2)  [1_R/W 2_R/W]     - "4.4.4" HOT_CATHODE_COMMAND;
    101 BlockType           "Block-Type"                                  OSTRING(4) [2_R]             - "4.4.4";
    102 StatusExtension     "Status Extension"                            UINT8      [1_R 2_R]         V "4.4.4" STATUS_EXTENSION;
    103 SensorAlarm         "Sensor Alarm"                                ARRAY(2)   [1_R 2_R]         V "4.4.4";
    104 SensorWarning       "Sensor Warning"                              ARRAY(2)   [1_R 2_R]         V "4.4.4";
    105 EmissionStatus      "Emission Status"                             BOOLEAN    [1_R/W 2_R/W]     V "4.4.4" EMISSION_STATUS;
    // A float that holds one of seven codes (147); NV in print (153).
    107 EmissionCurrent     "Emission Current"                            FLOAT      [1_R/W 2_R/W]     N "4.4.4" EMISSION_CURRENT;
    110 DegasStatus         "Degas Status"                                BOOLEAN    [1_R 2_R]         V "4.4.4" DEGAS_STATUS;
}

block! {
    /// Channel 3 or 4 with a Pirani gauge, or none.
    pub HeatTransfer = "Heat Transfer Vacuum Gauge Transducer Block", type 13;
    101 BlockType           "Block Type"                                  OSTRING(4) [2_R]             - "4.4.5";
    102 StatusExtension     "Status Extension"                            UINT8      [1_R 2_R]         V "4.4.5" STATUS_EXTENSION;
    103 SensorAlarm         "Sensor Alarm"                                ARRAY(2)   [1_R 2_R]         V "4.4.5";
    104 SensorWarning       "Sensor Warning"                              ARRAY(2)   [1_R 2_R]         V "4.4.5";
}

block! {
    /// Channel 3 or 4 with a capacitance diaphragm gauge.
    pub Diaphragm = "Diaphragm Gauge Transducer Block", type 14;
    101 BlockType           "Block Type"                                  OSTRING(4) [2_R]             - "4.4.6";
    102 StatusExtension     "Status Extension"                            UINT8      [1_R 2_R]         V "4.4.6" STATUS_EXTENSION;
    103 SensorAlarm         "Sensor Alarm"                                ARRAY(2)   [1_R 2_R]         V "4.4.6";
    104 SensorWarning       "Sensor Warning"                              ARRAY(2)   [1_R 2_R]         V "4.4.6";
}

blocks! {
    /// All parameters of the IMG 400 (145, 162). In slots 3 and 4 two blocks with the same rows stand at the same
    /// place; the gauge decides which of them it is (154), and only Block Type differs.
    pub Parameter;
    Device(DeviceBlock)              [0 "Device"];
    Input(AnalogInput)               [1 "Channel 1", 2 "Channel 2", 3 "Channel 3", 4 "Channel 4"];
    Trip(TripPoint)                  [5 "Relay 1", 6 "Relay 2", 7 "Relay 3", 8 "Relay 4", 9 "Relay 5", 10 "Relay 6",
                                      11 "Relay 7"];
    HotCathode(HotCathode)           [1 "Channel 1", 2 "Channel 2"];
    HeatTransfer(HeatTransfer)       [3 "Channel 3", 4 "Channel 4"];
    Diaphragm(Diaphragm)             [3 "Channel 3", 4 "Channel 4"];
}

/// How many channels and relays the controller has.
pub(super) const CHANNELS: usize = 4;
pub(super) const RELAYS: usize = 7;

use Field::{ChannelStatus, ChannelValue, ExceptionStatus, ParameterChannel, TransitionCommand, TripRelays};
use NumberType::{Float, Integer};

/// Process Values of the channels, as UINT16 and as floats.
const I1: Field = ChannelValue(1, Integer);
const I2: Field = ChannelValue(2, Integer);
const I3: Field = ChannelValue(3, Integer);
const I4: Field = ChannelValue(4, Integer);
const F1: Field = ChannelValue(1, Float);
const F2: Field = ChannelValue(2, Float);
const F3: Field = ChannelValue(3, Float);
const F4: Field = ChannelValue(4, Float);
const RELAYS_1_TO_7: Field = TripRelays(7);

// 4.3.3
static T1: Telegram = telegram(1, &[TransitionCommand]);
static T2: Telegram = telegram(2, &[ParameterChannel]);
static T3: Telegram = telegram(3, &[ParameterChannel, TransitionCommand]);
static T5: Telegram = telegram(5, &[ExceptionStatus, I1, I2, I3, I4]);
static T6: Telegram = telegram(6, &[ExceptionStatus, F1, F2, F3, F4]);
static T11: Telegram = telegram(11, &[ParameterChannel, ExceptionStatus, I1, I2, I3, I4]);
static T12: Telegram = telegram(12, &[ParameterChannel, ExceptionStatus, F1, F2, F3, F4]);
static T201: Telegram = telegram(201, &[ExceptionStatus, I1, I2, I3, I4, ChannelStatus, RELAYS_1_TO_7]);
static T202: Telegram = telegram(202, &[ExceptionStatus, F1, F2, F3, F4, ChannelStatus, RELAYS_1_TO_7]);
static T203: Telegram =
    telegram(203, &[ParameterChannel, ExceptionStatus, I1, I2, I3, I4, ChannelStatus, RELAYS_1_TO_7]);
static T204: Telegram =
    telegram(204, &[ParameterChannel, ExceptionStatus, F1, F2, F3, F4, ChannelStatus, RELAYS_1_TO_7]);

/// 4.2.4. Configurations 9, 10 (113) and 14 (114) have an octet too many in print.
#[rustfmt::skip]
static CONFIGURATIONS: [Configuration; 16] = [
    configuration(None,      Some(&T5),   &[0x45, 0x88, 0x05, 0x03, 0x03, 0x03, 0x03]),
    configuration(None,      Some(&T6),   &[0x45, 0x90, 0x05, 0x08, 0x08, 0x08, 0x08]),
    configuration(Some(&T1), Some(&T5),   &[0xC7, 0x81, 0x88, 0x05, 0x05, 0x05, 0x03, 0x03, 0x03, 0x03]),
    configuration(Some(&T1), Some(&T6),   &[0xC7, 0x81, 0x90, 0x05, 0x05, 0x05, 0x08, 0x08, 0x08, 0x08]),
    configuration(Some(&T2), Some(&T11),  &[0xC7, 0x87, 0x90, 0x0A, 0x0A, 0x05, 0x03, 0x03, 0x03, 0x03]),
    configuration(Some(&T2), Some(&T12),  &[0xC7, 0x87, 0x98, 0x0A, 0x0A, 0x05, 0x08, 0x08, 0x08, 0x08]),
    configuration(Some(&T3), Some(&T11),  &[0xC9, 0x89, 0x90, 0x0A, 0x05, 0x05, 0x0A, 0x05, 0x03, 0x03, 0x03, 0x03]),
    configuration(Some(&T3), Some(&T12),  &[0xC9, 0x89, 0x98, 0x0A, 0x05, 0x05, 0x0A, 0x05, 0x08, 0x08, 0x08, 0x08]),
    configuration(None,      Some(&T201), &[0x47, 0x91, 0x05, 0x03, 0x03, 0x03, 0x03, 0x0A, 0x0A]),
    configuration(None,      Some(&T202), &[0x47, 0x99, 0x05, 0x08, 0x08, 0x08, 0x08, 0x0A, 0x0A]),
    configuration(Some(&T1), Some(&T201), &[0xC9, 0x81, 0x91, 0x05, 0x05, 0x05, 0x03, 0x03, 0x03, 0x03, 0x0A, 0x0A]),
    configuration(Some(&T1), Some(&T202), &[0xC9, 0x81, 0x99, 0x05, 0x05, 0x05, 0x08, 0x08, 0x08, 0x08, 0x0A, 0x0A]),
    configuration(Some(&T2), Some(&T203), &[0xC9, 0x87, 0x99, 0x0A, 0x0A, 0x05, 0x03, 0x03, 0x03, 0x03, 0x0A, 0x0A]),
    configuration(Some(&T2), Some(&T204), &[0xC9, 0x87, 0xA1, 0x0A, 0x0A, 0x05, 0x08, 0x08, 0x08, 0x08, 0x0A, 0x0A]),
    configuration(Some(&T3), Some(&T203), &[0xCB, 0x89, 0x99, 0x0A, 0x05, 0x05, 0x0A, 0x05, 0x03, 0x03, 0x03, 0x03, 0x0A, 0x0A]),
    configuration(Some(&T3), Some(&T204), &[0xCB, 0x89, 0xA1, 0x0A, 0x05, 0x05, 0x0A, 0x05, 0x08, 0x08, 0x08, 0x08, 0x0A, 0x0A]),
];

/// 4.4.2, ID 22; the codes are hexadecimal (14), the factor of Micron is 1000 (135), hPa and mbar are the same (136).
#[rustfmt::skip]
static UNITS: [Unit; 5] = [
    Unit { code: 0x1001, name: "COUNTS", alias: "counts", scale: Scale::Counts },
    Unit { code: 0x1301, name: "Torr",   alias: "torr",   scale: Scale::TORR },
    Unit { code: 0x1302, name: "Micron", alias: "mTorr",  scale: Scale::MICRON },
    Unit { code: 0x1308, name: "hPa",    alias: "mbar",   scale: Scale::MBAR },
    Unit { code: 0x1309, name: "Pascal", alias: "Pa",     scale: Scale::PASCAL },
];

/// 4.2.5: the three octets of DPV1_Status, then the unit (39).
#[rustfmt::skip]
static USER_PRM: [UserPrm; 5] = [
    UserPrm { name: "COUNTS",         octets: &[0x00, 0x00, 0x00, 0x10, 0x01] },
    UserPrm { name: "Torr",           octets: &[0x00, 0x00, 0x00, 0x13, 0x01] },
    UserPrm { name: "mTorr (Micron)", octets: &[0x00, 0x00, 0x00, 0x13, 0x02] },
    UserPrm { name: "hPa",            octets: &[0x00, 0x00, 0x00, 0x13, 0x08] },
    UserPrm { name: "Pa (Pascal)",    octets: &[0x00, 0x00, 0x00, 0x13, 0x09] },
];

/// DPV1_Enable, Fail_Safe and WD_Base_1ms: what a master may ask for besides (39).
const DPV1_STATUS: u8 = 0x80 | 0x40 | 0x04;

/// The unit as it leaves the factory (143).
pub(super) const FACTORY_UNIT: &Unit = &UNITS[3];

/// 4.4.2: COUNTS = 4000 x (log10(p / hPa) + 12.5), an unsigned word (15, 134).
pub(super) const COUNTS: Counts = Counts::Log { per_decade: PER_DECADE, at_1_mbar: AT_1_MBAR };
const PER_DECADE: f64 = 4000.0;
const AT_1_MBAR: f64 = 50_000.0;
pub(super) const HIGHEST_COUNT: u16 = u16::MAX;

/// COUNTS of a hysteresis above a trip point (32).
pub(super) const fn hysteresis_counts(from_pa: f64) -> Counts {
    Counts::Distance { per_decade: PER_DECADE, at_1_mbar: AT_1_MBAR, from_mbar: from_pa / mbar(1.0), upwards: true }
}

// free choice: the ranges of the gauges stand in another manual (133).
const BAG: Limits = Limits { under_pa: mbar(1e-10), over_pa: mbar(1e-2), full_scale_pa: mbar(1e-2) };
const EXT: Limits = Limits { under_pa: mbar(1e-12), over_pa: mbar(1e-4), full_scale_pa: mbar(1e-4) };
const TPR: Limits = Limits { under_pa: mbar(8e-4), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) };
const CMR: Limits = Limits { under_pa: mbar(0.1), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) };

const fn facts(instance: u8, principle: Principle, limits: Limits) -> PartSpec {
    PartSpec { part: Part { instance, principle }, limits, clipping: Clipping::Never, counts: COUNTS }
}

pub(super) static BAG_1: PartSpec = facts(1, Principle::HotCathode, BAG);
pub(super) static EXT_1: PartSpec = facts(1, Principle::HotCathode, EXT);
pub(super) static BAG_2: PartSpec = facts(2, Principle::HotCathode, BAG);
pub(super) static EXT_2: PartSpec = facts(2, Principle::HotCathode, EXT);
pub(super) static TPR_3: PartSpec = facts(3, Principle::Pirani, TPR);
pub(super) static CMR_3: PartSpec = facts(3, Principle::Diaphragm, CMR);
pub(super) static TPR_4: PartSpec = facts(4, Principle::Pirani, TPR);
pub(super) static CMR_4: PartSpec = facts(4, Principle::Diaphragm, CMR);

/// 4.4.4: emission goes off above p_max, degas starts below 1e-4 hPa and 1e-5 hPa. It may be switched on at any
/// pressure.
// free choice: p_max stands in another manual; it lies above the range, so that overrange can be seen.
pub(super) static BAG_CATHODE: Thresholds =
    Thresholds { off_pa: mbar(2e-2), on_pa: f64::INFINITY, degas_pa: mbar(1e-4) };
pub(super) static EXT_CATHODE: Thresholds =
    Thresholds { off_pa: mbar(2e-4), on_pa: f64::INFINITY, degas_pa: mbar(1e-5) };

faults! {
    /// What can be broken. The details behind Exception Status cannot be read (120, 121).
    pub Faults;
    eeprom         "eeprom"        "common alarm and warning";
    ram            "ram"           "common alarm and warning";
    eprom          "eprom"         "common alarm and warning; with ram a self test ends in CRITICAL FAULT";
    comm           "comm"          "internal serial interface set wrong (3.2): common alarm and warning; stays in INIT";
    power          "power"         "general power supply: manufacturer alarm and warning, channels 3 and 4 off until reset";
    overpressure   "overpressure"  "channels 1 and 2 see more than p_max: emission goes off until acknowledged";
    sensor_1       "sensor1"       "hot cathode supply of channel 1: manufacturer alarm and warning until reset";
    sensor_2       "sensor2"       "hot cathode supply of channel 2: manufacturer alarm and warning until reset";
    sensor_3       "sensor3"       "the gauge of channel 3 does not answer";
    sensor_4       "sensor4"       "the gauge of channel 4 does not answer";
    electronics_1  "electronics1"  "hot cathode supply of channel 1: manufacturer alarm and warning until reset";
    electronics_2  "electronics2"  "hot cathode supply of channel 2: manufacturer alarm and warning until reset";
    electronics_3  "electronics3"  "general power supply, as power";
    electronics_4  "electronics4"  "general power supply, as power";
    unplugged_1    "unplugged1"    "no gauge on channel 1";
    unplugged_2    "unplugged2"    "no gauge on channel 2";
    unplugged_3    "unplugged3"    "no gauge on channel 3";
    unplugged_4    "unplugged4"    "no gauge on channel 4";
}

/// 4.3.2
static DIALECT: ChannelRules = ChannelRules {
    tasks: &[(1, TaskKind::Read), (2, TaskKind::Write(&[2])), (3, TaskKind::Write(&[4])), (10, TaskKind::Write(&[1]))],
    needs_idle_between: true,
    error_codes: &[],
};

/// The tables of the IMG 400.
pub static MODEL: Model = Model {
    name: "img400",
    title: "IMG 400",
    vendor: "Pfeiffer Vacuum",
    manual: "BG 5530 BEN/A",
    ident: 0x0947,
    features: Features { sync: false, freeze: false, dpv1: true, ms1: true },
    configurations: &CONFIGURATIONS,
    // free choice: the manual names no default. Floats, and nothing that a master must send.
    default_configuration: &CONFIGURATIONS[1],
    units: &UNITS,
    user_prm: &USER_PRM,
    dpv1_status: DPV1_STATUS,
    blocks: Parameter::PLACES,
    parts: &[&BAG_1, &EXT_1, &BAG_2, &EXT_2, &TPR_3, &CMR_3, &TPR_4, &CMR_4],
    channel_rules: &DIALECT,
    faults: &Faults::LIST,
    errata: "errata-pxg55x-img400 1 to 45 and 113 to 162",
    gsd: Gsd { revision: 1, hardware: "1.0", software: "1.0", max_diag_octets: 6, set_slave_add: true },
};
