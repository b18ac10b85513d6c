//! The tables of BG 5530 BEN/A (IF 400 P for IMG 400), row by row. Where a row departs from the print, a comment says
//! why. Sections are those of the manual, numbers in brackets those of errata-pxg55x-img400.

use super::codes::{
    AdjustCommand, ChannelNumber, ControllerState, DegasStatus, EmissionCurrent, EmissionStatus, HotCathodeCommand,
    KeyLock, ResetErrors,
};
use super::faults::Faults;
use super::parts;
use crate::model::block_macros::{block, blocks};
use crate::model::{
    AlarmBit, AlarmWords, ChannelRules, Configuration, Field, Gsd, Location, Model, NumberType, ParameterSet, Scale,
    TaskKind, Telegram, Unit, UserPrm, configuration, telegram, text,
};
use crate::profile::codes::UnitCode;
use crate::profile::{ExceptionStatus, SafeState, StateCommand, StatusExtension};
use profivac_dp::slave::Features;

block! {
    /// The controller as a whole. The text mentions identity and exception details, which do not exist (120).
    pub DeviceBlock in device_block = "Device Block", type 1;
    // ID parameter         name as printed                               data type  access            store, section
    // Table 1 leaves the store class blank: a command is never kept (26).
    15 StateCommand         "Device Block State"                          UINT8      [1_R/W 2_R/W]     - "4.4.1" StateCommand;
    16 BlockType            "Block Type ID"                               OSTRING(4) [1_R 2_R]         N "4.4.1";
    25 DeviceState          "Device State"                                UINT8      [1_R 2_R]         V "4.4.1" ControllerState;
    26 ExceptionStatus      "Exception Status"                            UINT8      [0_XI 1_R 2_R]    V "4.4.1" ExceptionStatus;
    203 KeyLock             "Key Lock"                                    UINT8      [1_R/W 2_R/W]     V "4.4.1" KeyLock;
    204 ChannelStatus       "Channel Status"                              OSTRING(2) [0_XI 1_R 2_R]    V "4.4.1";
    205 ResetErrorCondition "Reset Error Condition"                       UINT8      [1_W 2_W]         V "4.4.1" ResetErrors;
}

block! {
    /// The pressure of one channel.
    pub AnalogInput in analog_input = "Sensor Analog Input Function Block", type 2;
    // 2R/W without a length in table 3, both classes and two octets in the record table (130).
    15 BlockAdjustCommand   "Block Adjust Command"                        RECORD(2)  [1/2_R/W]         - "4.4.2" AdjustCommand;
    // A record without a length in print (132).
    16 BlockType            "Block Type ID"                               OSTRING(4) [2R]              N "4.4.2";
    19 ProcessValue         "ProcessValue (PV)"                           BY_TYPE    [0_XI 1_R 2_R]    D "4.4.2";
    20 Status               "Status"                                      UINT8      [1_R 2_R]         D "4.4.2";
    21 DataType             "Data Type"                                   UINT8      [2_R 2_W]         N "4.4.2" NumberType;
    // Only the user parameters change it (143).
    22 DataUnits            "Data Units"                                  UINT16     [2_R prm]         N "4.4.2" UnitCode;
    23 ReadingValid         "Reading Valid"                               BOOLEAN    [1_R 2_R]         D "4.4.2";
    24 FullScale            "Full Scale"                                  BY_TYPE    [1_R 2_R]         N "4.4.2";
    39 SafeState            "Safe State"                                  UINT8      [1_R 1_W 2_R 2_W] N "4.4.2" SafeState;
    40 SafeValue            "Safe Value"                                  BY_TYPE    [1_R 1_W 2_R 2_W] N "4.4.2";
    44 Overrange            "Overrange"                                   BY_TYPE    [1_R 2_R]         N "4.4.2";
    45 Underrange           "Underrange"                                  BY_TYPE    [1_R 2_R]         N "4.4.2";
}

block! {
    /// A relay that closes below a pressure. There is no high trip point (146).
    pub TripPoint in trip_point = "Trip Function Block", type 17;
    // A record without a length in print (132).
    16 BlockType            "Block Type ID"                               OSTRING(4) [2R]              - "4.4.3";
    19 LowTripPoint         "Low Trip Point"                              BY_TYPE    [1_R/W 2_R/W]     N "4.4.3";
    20 LowTripEnable        "Low Trip Enable"                             BOOLEAN    [1_R/W 2_R/W]     N "4.4.3";
    21 Status               "Status"                                      UINT8      [0_XI 1_R 2_R]    V "4.4.3";
    24 Hysteresis           "Hysteresis"                                  BY_TYPE    [1_R/W 2_R/W]     N "4.4.3";
    27 Channel              "Analog Input Sensor Function Block Instance" UINT8      [1_R/W 2_R/W]     N "4.4.3" ChannelNumber;
    28 DataUnits            "Data Unit"                                   UINT16     [2_R]             N "4.4.3" UnitCode;
    29 DataType             "Data Type"                                   UINT8      [2_R]             N "4.4.3" NumberType;
    // 1 byte in print (139).
    201 UpperThreshold      "Low Trip Upper Threshold"                    BY_TYPE    [1_R/W 2_R/W]     N "4.4.3";
}

block! {
    /// Channel 1 or 2: a Bayard-Alpert or extractor gauge, or none.
    pub HotCathode in hot_cathode = "Hot Cathode Ion Gauge Transducer Block", type 16;
    // Store N in the second table only: a command is never kept (150).
    14 StateCommand         "Hot Cathode Block State Command"             RECORD(2)  [1_R/W 2_R/W]     - "4.4.4" HotCathodeCommand;
    101 BlockType           "Block-Type"                                  OSTRING(4) [2_R]             - "4.4.4";
    102 StatusExtension     "Status Extension"                            UINT8      [1_R 2_R]         V "4.4.4" StatusExtension;
    103 SensorAlarm         "Sensor Alarm"                                ARRAY(2)   [1_R 2_R]         V "4.4.4";
    104 SensorWarning       "Sensor Warning"                              ARRAY(2)   [1_R 2_R]         V "4.4.4";
    105 EmissionStatus      "Emission Status"                             BOOLEAN    [1_R/W 2_R/W]     V "4.4.4" EmissionStatus;
    // A float that holds one of seven codes (147); NV in print (153).
    107 EmissionCurrent     "Emission Current"                            FLOAT      [1_R/W 2_R/W]     N "4.4.4" EmissionCurrent;
    110 DegasStatus         "Degas Status"                                BOOLEAN    [1_R 2_R]         V "4.4.4" DegasStatus;
}

block! {
    /// Channel 3 or 4 with a Pirani gauge, or none.
    pub HeatTransfer in heat_transfer = "Heat Transfer Vacuum Gauge Transducer Block", type 13;
    101 BlockType           "Block Type"                                  OSTRING(4) [2_R]             - "4.4.5";
    102 StatusExtension     "Status Extension"                            UINT8      [1_R 2_R]         V "4.4.5" StatusExtension;
    103 SensorAlarm         "Sensor Alarm"                                ARRAY(2)   [1_R 2_R]         V "4.4.5";
    104 SensorWarning       "Sensor Warning"                              ARRAY(2)   [1_R 2_R]         V "4.4.5";
}

block! {
    /// Channel 3 or 4 with a capacitance diaphragm gauge.
    pub Diaphragm in diaphragm = "Diaphragm Gauge Transducer Block", type 14;
    101 BlockType           "Block Type"                                  OSTRING(4) [2_R]             - "4.4.6";
    102 StatusExtension     "Status Extension"                            UINT8      [1_R 2_R]         V "4.4.6" StatusExtension;
    103 SensorAlarm         "Sensor Alarm"                                ARRAY(2)   [1_R 2_R]         V "4.4.6";
    104 SensorWarning       "Sensor Warning"                              ARRAY(2)   [1_R 2_R]         V "4.4.6";
}

/// The device block.
pub const DEVICE: Location = Location::slot(0, "Device");
/// Channel 1.
pub const CHANNEL_1: Location = Location::slot(1, "Channel 1");
/// Channel 2.
pub const CHANNEL_2: Location = Location::slot(2, "Channel 2");
/// Channel 3.
pub const CHANNEL_3: Location = Location::slot(3, "Channel 3");
/// Channel 4.
pub const CHANNEL_4: Location = Location::slot(4, "Channel 4");
/// Relay 1.
pub const RELAY_1: Location = Location::slot(5, "Relay 1");
/// Relay 2.
pub const RELAY_2: Location = Location::slot(6, "Relay 2");
/// Relay 3.
pub const RELAY_3: Location = Location::slot(7, "Relay 3");
/// Relay 4.
pub const RELAY_4: Location = Location::slot(8, "Relay 4");
/// Relay 5.
pub const RELAY_5: Location = Location::slot(9, "Relay 5");
/// Relay 6.
pub const RELAY_6: Location = Location::slot(10, "Relay 6");
/// Relay 7.
pub const RELAY_7: Location = Location::slot(11, "Relay 7");

blocks! {
    /// All parameters of the IMG 400 (145, 162). Slots 3 and 4 have two blocks with the same rows; the gauge decides
    /// which of them it is (154), and only Block Type differs.
    pub Parameter;
    Device(DeviceBlock)        [DEVICE];
    Input(AnalogInput)         [CHANNEL_1, CHANNEL_2, CHANNEL_3, CHANNEL_4];
    Trip(TripPoint)            [RELAY_1, RELAY_2, RELAY_3, RELAY_4, RELAY_5, RELAY_6, RELAY_7];
    HotCathode(HotCathode)     [CHANNEL_1, CHANNEL_2];
    HeatTransfer(HeatTransfer) [CHANNEL_3, CHANNEL_4];
    Diaphragm(Diaphragm)       [CHANNEL_3, CHANNEL_4];
}

/// Process Values of the channels, as UINT16 and as floats.
const I1: Field = Field::ChannelValue(1, NumberType::Integer);
const I2: Field = Field::ChannelValue(2, NumberType::Integer);
const I3: Field = Field::ChannelValue(3, NumberType::Integer);
const I4: Field = Field::ChannelValue(4, NumberType::Integer);
const F1: Field = Field::ChannelValue(1, NumberType::Float);
const F2: Field = Field::ChannelValue(2, NumberType::Float);
const F3: Field = Field::ChannelValue(3, NumberType::Float);
const F4: Field = Field::ChannelValue(4, NumberType::Float);
const RELAYS_1_TO_7: Field = Field::TripRelays(7);

// 4.3.3
static T1: Telegram = telegram(1, &[Field::TransitionCommand]);
static T2: Telegram = telegram(2, &[Field::ParameterChannel]);
static T3: Telegram = telegram(3, &[Field::ParameterChannel, Field::TransitionCommand]);
static T5: Telegram = telegram(5, &[Field::ExceptionStatus, I1, I2, I3, I4]);
static T6: Telegram = telegram(6, &[Field::ExceptionStatus, F1, F2, F3, F4]);
static T11: Telegram = telegram(11, &[Field::ParameterChannel, Field::ExceptionStatus, I1, I2, I3, I4]);
static T12: Telegram = telegram(12, &[Field::ParameterChannel, Field::ExceptionStatus, F1, F2, F3, F4]);
static T201: Telegram = telegram(201, &[Field::ExceptionStatus, I1, I2, I3, I4, Field::ChannelStatus, RELAYS_1_TO_7]);
static T202: Telegram = telegram(202, &[Field::ExceptionStatus, F1, F2, F3, F4, Field::ChannelStatus, RELAYS_1_TO_7]);
static T203: Telegram = telegram(
    203,
    &[Field::ParameterChannel, Field::ExceptionStatus, I1, I2, I3, I4, Field::ChannelStatus, RELAYS_1_TO_7],
);
static T204: Telegram = telegram(
    204,
    &[Field::ParameterChannel, Field::ExceptionStatus, F1, F2, F3, F4, Field::ChannelStatus, RELAYS_1_TO_7],
);

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

/// DPV1_Enable, Fail_Safe and WD_Base_1ms, which a master may set (39).
const DPV1_STATUS: u8 = 0x80 | 0x40 | 0x04;

/// The unit as it leaves the factory (143).
pub(super) const FACTORY_UNIT: &Unit = &UNITS[3];

/// 4.3.2
static CHANNEL_RULES: ChannelRules = ChannelRules {
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
    // chosen: the manual names no default. Floats, and nothing that a master must send.
    default_configuration: &CONFIGURATIONS[1],
    values: &[],
    units: &UNITS,
    max_integer: parts::HIGHEST_COUNT,
    user_prm: &USER_PRM,
    dpv1_status: DPV1_STATUS,
    blocks: Parameter::BLOCKS,
    parts: &[
        &parts::BAG_1,
        &parts::EXT_1,
        &parts::BAG_2,
        &parts::EXT_2,
        &parts::TPR_3,
        &parts::CMR_3,
        &parts::TPR_4,
        &parts::CMR_4,
    ],
    channel_rules: &CHANNEL_RULES,
    // 4.4.4, Sensor Alarm; no record of the device block has all alarms (4.4.1).
    alarms: AlarmWords {
        instances: &[],
        sensor: &[
            AlarmBit { octet: 1, mask: 1 << 1, name: "electronics failure" },
            AlarmBit { octet: 1, mask: 1 << 3, name: "emission switched off, the pressure was too high" },
            AlarmBit { octet: 1, mask: 1 << 4, name: "emission switched off at the controller" },
        ],
        manufacturer: &[],
    },
    faults: &Faults::LIST,
    errata: text("errata-pxg55x-img400 1 to 45 and 113 to 163"),
    gsd: Gsd { revision: 1, hardware: "1.0", software: "1.0", max_diag_octets: 6, set_slave_add: true },
};
