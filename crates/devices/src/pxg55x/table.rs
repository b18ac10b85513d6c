//! The tables of tira56e1, row by row: blocks of chapters 7 to 13, telegrams and configurations of 4.4. Names as
//! printed there. Sections are those of the manual, numbers in brackets those of errata-pxg55x-img400.

use super::codes::{AtmAdjust, CdgAdjust, Hours, PiraniAdjust, PiraniOff, QuarterHours, SetpointMode};
use super::faults::{PCG_FAULTS, PCG_WITH_ATM_FAULTS, PSG_FAULTS};
use super::parts;
use crate::model::block_macros::{block, blocks};
use crate::model::{
    AccessError, AlarmBit, AlarmWords, Block, ChannelRules, Configuration, FaultList, Field, Gsd, INTEGER16_MAX,
    Location, Model, NumberType, ParameterSet, Part, PartSpec, PlacedBlock, Row, Scale, TaskKind, Telegram, Unit,
    UserPrm, configuration, telegram, text,
};
use crate::profile::codes::UnitCode;
use crate::profile::{DeviceState, ExceptionStatus, SafeState, StateCommand, StatusExtension};
use profivac_dp::slave::Features;
use profivac_wire::acyclic::Im0;

block! {
    /// Identity, state and exceptions of a PCG55x.
    pub DeviceBlock in device_block = "Device Block", type 1;
    // ID  parameter                    name as printed                           data type   access         store  section
    15  StateCommand                    "Device Block State"                      UINT8       [     1_R/W 2_R/W]     N  "7.2.2" StateCommand;
    16  BlockType                       "Block Type ID"                           OSTRING(4)  [     1_R   2_R  ]     N  "7.1.1";
    17  DeviceType                      "Device Type"                             VSTRING(8)  [           2_R  ]     N  "7.1.2";
    18  StandardRevision                "Standard Revision Level"                 VSTRING(9)  [           2_R  ]     N  "7.1.3";
    19  Manufacturer                    "Device Manufacturer Identifier"          VSTRING(20) [           2_R  ]     N  "7.1.4";
    20  ModelNumber                     "Manufacturer Model Number"               VSTRING(20) [           2_R  ]     N  "7.1.5";
    21  FirmwareRevision                "Software or Firmware Revision Level"     VSTRING(8)  [           2_R  ]     N  "7.1.6";
    22  HardwareRevision                "Hardware Revision Level"                 VSTRING(8)  [           2_R  ]     N  "7.1.7";
    23  SerialNumber                    "Serial Number"                           VSTRING(30) [           2_R  ]     N  "7.1.8";
    24  DeviceConfiguration             "Device Configuration"                    VSTRING(50) [           2_R  ]     N  "7.1.9";
    25  DeviceState                     "Device State"                            UINT8       [0_XI 1_R   2_R  ]     V  "7.1.10" DeviceState;
    26  ExceptionStatus                 "Exception Status"                        UINT8       [0_XI 1_R   2_R  ]     V  "7.1.11" ExceptionStatus;
    27  ExceptionDetailAlarm            "Exception Detail Alarm"                  RECORD(10)  [     1_R   2_R  ]     V  "7.1.12";
    28  ExceptionDetailWarning          "Exception Detail Warning"                RECORD(11)  [     1_R   2_R  ]     V  "7.1.13";
    36  RunHours                        "Run hours"                               UINT16      [     1_R   2_R  ]     N  "7.1.14" Hours;
    202 BasicDeviceFirmwareRevision     "Basic Device Firmware Revision Level"    VSTRING(8)  [           2_R  ]     N  "7.1.15";
    204 CommonExceptionAlarm            "Common Exception Detail Alarm"           ARRAY(2)    [     1_R   2_R  ]     V  "7.1.16";
    205 DeviceExceptionAlarm            "Device Exception Detail Alarm"           ARRAY(4)    [     1_R   2_R  ]     V  "7.1.17";
    206 ManufacturerExceptionAlarm      "Manufacturer Exception Detail Alarm"     UINT8       [     1_R   2_R  ]     V  "7.1.18";
    207 CommonExceptionWarning          "Common Exception Detail Warning"         ARRAY(2)    [     1_R   2_R  ]     V  "7.1.19";
    // Printed as an array of one octet (75).
    208 DeviceExceptionWarning1         "Device Exception Detail Warning I"       UINT8       [     1_R   2_R  ]     V  "7.1.20" StatusExtension;
    209 DeviceExceptionWarning2         "Device Exception Detail Warning II"      ARRAY(4)    [     1_R   2_R  ]     V  "7.1.20";
    210 ManufacturerExceptionWarning    "Manufacturer Exception Detail Warning"   UINT8       [     1_R   2_R  ]     V  "7.1.21";
    211 AddressSwitch                   "Address Switch"                          UINT8       [     1_R   2_R  ]     V  "7.1.22";
    212 RunHours4                       "Run hours (*4)"                          UINT32      [     1_R   2_R  ]     N  "7.1.23" QuarterHours;
}

block! {
    /// Identity, state and exceptions of a PSG55x: with one sensor instead of two, 27, 28, 205 and 209 are shorter.
    pub PsgDeviceBlock in psg_device_block = "Device Block", type 1;
    // ID  parameter                    name as printed                           data type   access         store  section
    15  StateCommand                    "Device Block State"                      UINT8       [     1_R/W 2_R/W]     N  "7.2.2" StateCommand;
    16  BlockType                       "Block Type ID"                           OSTRING(4)  [     1_R   2_R  ]     N  "7.1.1";
    17  DeviceType                      "Device Type"                             VSTRING(8)  [           2_R  ]     N  "7.1.2";
    18  StandardRevision                "Standard Revision Level"                 VSTRING(9)  [           2_R  ]     N  "7.1.3";
    19  Manufacturer                    "Device Manufacturer Identifier"          VSTRING(20) [           2_R  ]     N  "7.1.4";
    20  ModelNumber                     "Manufacturer Model Number"               VSTRING(20) [           2_R  ]     N  "7.1.5";
    21  FirmwareRevision                "Software or Firmware Revision Level"     VSTRING(8)  [           2_R  ]     N  "7.1.6";
    22  HardwareRevision                "Hardware Revision Level"                 VSTRING(8)  [           2_R  ]     N  "7.1.7";
    23  SerialNumber                    "Serial Number"                           VSTRING(30) [           2_R  ]     N  "7.1.8";
    24  DeviceConfiguration             "Device Configuration"                    VSTRING(50) [           2_R  ]     N  "7.1.9";
    25  DeviceState                     "Device State"                            UINT8       [0_XI 1_R   2_R  ]     V  "7.1.10" DeviceState;
    26  ExceptionStatus                 "Exception Status"                        UINT8       [0_XI 1_R   2_R  ]     V  "7.1.11" ExceptionStatus;
    27  ExceptionDetailAlarm            "Exception Detail Alarm"                  RECORD(8)   [     1_R   2_R  ]     V  "7.1.12";
    28  ExceptionDetailWarning          "Exception Detail Warning"                RECORD(9)   [     1_R   2_R  ]     V  "7.1.13";
    36  RunHours                        "Run hours"                               UINT16      [     1_R   2_R  ]     N  "7.1.14" Hours;
    202 BasicDeviceFirmwareRevision     "Basic Device Firmware Revision Level"    VSTRING(8)  [           2_R  ]     N  "7.1.15";
    204 CommonExceptionAlarm            "Common Exception Detail Alarm"           ARRAY(2)    [     1_R   2_R  ]     V  "7.1.16";
    205 DeviceExceptionAlarm            "Device Exception Detail Alarm"           ARRAY(2)    [     1_R   2_R  ]     V  "7.1.17";
    206 ManufacturerExceptionAlarm      "Manufacturer Exception Detail Alarm"     UINT8       [     1_R   2_R  ]     V  "7.1.18";
    207 CommonExceptionWarning          "Common Exception Detail Warning"         ARRAY(2)    [     1_R   2_R  ]     V  "7.1.19";
    // Printed as an array of one octet (75).
    208 DeviceExceptionWarning1         "Device Exception Detail Warning I"       UINT8       [     1_R   2_R  ]     V  "7.1.20" StatusExtension;
    209 DeviceExceptionWarning2         "Device Exception Detail Warning II"      ARRAY(2)    [     1_R   2_R  ]     V  "7.1.20";
    210 ManufacturerExceptionWarning    "Manufacturer Exception Detail Warning"   UINT8       [     1_R   2_R  ]     V  "7.1.21";
    211 AddressSwitch                   "Address Switch"                          UINT8       [     1_R   2_R  ]     V  "7.1.22";
    212 RunHours4                       "Run hours (*4)"                          UINT32      [     1_R   2_R  ]     N  "7.1.23" QuarterHours;
}

block! {
    /// The capacitance diaphragm gauge.
    pub CdgInput in cdg_input = "Sensor Analog Input Function Block (CDG)", type 2;
    // ID  parameter      name as printed             data type  access                store  section
    // Printed with a target value of the data type's length in one octet (78).
    15  AdjustCommand     "AIBlockAdjust Command"     RECORD(2)  [     1_R/W 2_R/W]     N  "8.1.1" CdgAdjust;
    16  BlockType         "Block Type ID"             OSTRING(4) [     1_R   2_R  ]     N  "8.1.2";
    19  ProcessValue      "ProcessValue (PV)"         BY_TYPE    [0_XI 1_R   2_R  ]     D  "8.1.3";
    20  Status            "Status"                    UINT8      [0_XI 1_R   2_R  ]     D  "8.1.4";
    21  DataType          "Data Type"                 UINT8      [           2_R/W]     N  "8.1.5" NumberType;
    22  DataUnit          "Data Unit"                 UINT16     [           2_R/W]     N  "8.1.6" UnitCode;
    23  ReadingValid      "Reading Valid"             BOOLEAN    [     1_R   2_R  ]     D  "8.1.7";
    24  FullScale         "Full Scale"                BY_TYPE    [     1_R   2_R  ]     N  "8.1.8";
    39  SafeState         "Safe State"                UINT8      [     1_R/W 2_R/W]     N  "8.1.9" SafeState;
    40  SafeValue         "Safe Value"                BY_TYPE    [     1_R/W 2_R/W]     N  "8.1.10";
    41  AutoZeroEnable    "Auto Zero Enable"          BOOLEAN    [     1_R/W 2_R/W]     N  "8.1.11";
    44  Overrange         "Overrange"                 BY_TYPE    [     1_R   2_R  ]     N  "8.1.12";
    45  Underrange        "Underrange"                BY_TYPE    [     1_R   2_R  ]     N  "8.1.13";
}

block! {
    /// The Pirani.
    pub PiraniInput in pirani_input = "Sensor Analog Input Function Block (Pirani)", type 2;
    // ID  parameter      name as printed             data type  access                store  section
    15  AdjustCommand     "AIBlockAdjust Command"     RECORD(2)  [     1_R/W 2_R/W]     N  "8.2.1" PiraniAdjust;
    16  BlockType         "Block Type ID"             OSTRING(4) [     1_R   2_R  ]     N  "8.2.2";
    19  ProcessValue      "ProcessValue (PV)"         BY_TYPE    [0_XI 1_R   2_R  ]     D  "8.2.3";
    20  Status            "Status"                    UINT8      [0_XI 1_R   2_R  ]     D  "8.2.4";
    21  DataType          "Data Type"                 UINT8      [           2_R/W]     N  "8.2.5" NumberType;
    22  DataUnit          "Data Unit"                 UINT16     [           2_R/W]     N  "8.2.6" UnitCode;
    23  ReadingValid      "Reading Valid"             BOOLEAN    [     1_R   2_R  ]     D  "8.2.7";
    24  FullScale         "Full Scale"                BY_TYPE    [     1_R   2_R  ]     N  "8.2.8";
    39  SafeState         "Safe State"                UINT8      [     1_R/W 2_R/W]     N  "8.2.9" SafeState;
    40  SafeValue         "Safe Value"                BY_TYPE    [     1_R/W 2_R/W]     N  "8.2.10";
    44  Overrange         "Overrange"                 BY_TYPE    [     1_R   2_R  ]     N  "8.2.11";
    45  Underrange        "Underrange"                BY_TYPE    [     1_R   2_R  ]     N  "8.2.12";
}

block! {
    /// The atmosphere pressure sensor.
    pub AtmInput in atm_input = "Sensor Analog Input Function Block (ATM)", type 2;
    // ID  parameter      name as printed             data type  access                store  section
    15  AdjustCommand     "AIBlockAdjust Command"     RECORD(2)  [     1_R/W 2_R/W]     N  "8.3.1" AtmAdjust;
    16  BlockType         "Block Type ID"             OSTRING(4) [     1_R   2_R  ]     N  "8.3.2";
    19  ProcessValue      "ProcessValue (PV)"         BY_TYPE    [0_XI 1_R   2_R  ]     D  "8.3.3";
    20  Status            "Status"                    UINT8      [0_XI 1_R   2_R  ]     D  "8.3.4";
    // No data type is printed (89).
    21  DataType          "Data Type"                 UINT8      [           2_R/W]     N  "8.3.5" NumberType;
    22  DataUnit          "Data Unit"                 UINT16     [           2_R/W]     N  "8.3.6" UnitCode;
    23  ReadingValid      "Reading Valid"             BOOLEAN    [     1_R   2_R  ]     D  "8.3.7";
    24  FullScale         "Full Scale"                BY_TYPE    [     1_R   2_R  ]     N  "8.3.8";
    39  SafeState         "Safe State"                UINT8      [     1_R/W 2_R/W]     N  "8.3.9" SafeState;
    40  SafeValue         "Safe Value"                BY_TYPE    [     1_R/W 2_R/W]     N  "8.3.10";
    44  Overrange         "Overrange"                 BY_TYPE    [     1_R   2_R  ]     N  "8.3.11";
    45  Underrange        "Underrange"                BY_TYPE    [     1_R   2_R  ]     N  "8.3.12";
}

block! {
    /// Chooses the instance that slot 1 shows, and has the instance that is in the cyclic data. The block has no block
    /// type (70).
    pub OneOfNInput in one_of_n_input = "OneOfN Analog Input Function Block";
    // ID  parameter              name as printed             data type  access                store  section
    46  ChannelInstanceSelector   "Channel Instance Selector" UINT8      [     1_R/W 2_R/W]     N  "9.1.1";
    // Printed N and without 0_XI, but the gauge chooses it and sends it (65, 66).
    47  PvSelector                "OneOfN PV Selector"        UINT8      [0_XI 1_R   2_R  ]     D  "9.1.2";
}

block! {
    /// Drives a relay.
    pub DiscreteOutput in discrete_output = "Discrete Output Function Block", type 7;
    // ID  parameter      name as printed    data type  access          store  section
    // Printed as one octet (92).
    16  BlockType         "Block Type ID"    OSTRING(4) [     1_R 2_R]   N  "10.1.1";
    19  SetpointValue     "Setpoint Value"   UINT8      [0_XO     2_R]   D  "10.1.2";
    20  Status            "Status"           BOOLEAN    [         2_R]   D  "10.1.3";
}

block! {
    /// Compares the process value with a high and a low limit.
    pub TripPoint in trip_point = "Trip Point Function Block", type 17;
    // ID  parameter            name as printed                             data type  access          store  section
    16  BlockType               "Block Type ID"                             OSTRING(4) [     1_R   2_R  ]     N  "11.2.1";
    17  HighTripPoint           "High Trip Point"                           BY_TYPE    [     1_R/W 2_R/W]     N  "11.2.2";
    18  HighTripEnable          "High Trip Enable"                          BOOLEAN    [     1_R/W 2_R/W]     N  "11.2.3";
    19  LowTripPoint            "Low Trip Point"                            BY_TYPE    [     1_R/W 2_R/W]     N  "11.2.4";
    20  LowTripEnable           "Low Trip Enable"                           BOOLEAN    [     1_R/W 2_R/W]     N  "11.2.5";
    21  Status                  "Status"                                    UINT8      [0_XI 1_R   2_R  ]     D  "11.2.6";
    26  DiscreteOutputInstance  "Discrete Output Function Block Instance"   UINT8      [     1_R   2_R  ]     N  "11.2.7";
    28  DataUnits               "Data Units"                                UINT16     [           2_R/W]     N  "11.2.8" UnitCode;
    29  DataType                "Data Type"                                 UINT8      [           2_R/W]     N  "11.2.9" NumberType;
    31  HighTripPointHysteresis "High Trip Point Hysteresis"                BY_TYPE    [     1_R/W 2_R/W]     N  "11.2.10";
    32  LowTripPointHysteresis  "Low Trip Point Hysteresis"                 BY_TYPE    [     1_R/W 2_R/W]     N  "11.2.11";
    201 FactorOfAtm             "Factor of ATM"                             FLOAT      [     1_R/W 2_R/W]     N  "11.2.12";
    202 SetpointMode            "Setpoint Mode"                             UINT8      [     1_R/W 2_R/W]     N  "11.2.13" SetpointMode;
}

block! {
    /// The diaphragm sensor.
    pub CdgTransducer in cdg_transducer = "CDG Transducer Block", type 14;
    // ID  parameter       name as printed      data type  access        store  section
    101 BlockType          "Block Type ID"      OSTRING(4) [1_R 2_R]     N  "12.1.1";
    102 StatusExtension    "Status Extension"   UINT8      [1_R 2_R]     V  "12.1.2" StatusExtension;
    103 SensorAlarm        "Sensor Alarm"       ARRAY(2)   [1_R 2_R]     V  "12.1.3";
    104 SensorWarning      "Sensor Warning"     ARRAY(2)   [1_R 2_R]     V  "12.1.4";
}

block! {
    /// The Pirani sensor.
    pub PiraniTransducer in pirani_transducer = "Pirani Transducer Block", type 13;
    // ID  parameter       name as printed      data type  access            store  section
    101 BlockType          "Block Type ID"      OSTRING(4) [1_R   2_R  ]     N  "12.2.1";
    102 StatusExtension    "Status Extension"   UINT8      [1_R   2_R  ]     V  "12.2.2" StatusExtension;
    103 SensorAlarm        "Sensor Alarm"       ARRAY(2)   [1_R   2_R  ]     V  "12.2.3";
    104 SensorWarning      "Sensor Warning"     ARRAY(2)   [1_R   2_R  ]     V  "12.2.4";
    201 PiraniOff          "Pirani OFF"         UINT8      [1_R/W 2_R/W]     N  "12.2.5" PiraniOff;
}

block! {
    /// The atmosphere sensor.
    pub AtmTransducer in atm_transducer = "ATM Transducer Block", type 256;
    // ID  parameter       name as printed      data type  access        store  section
    101 BlockType          "Block Type ID"      OSTRING(4) [1_R 2_R]     N  "12.3.1";
    102 StatusExtension    "Status Extension"   UINT8      [1_R 2_R]     V  "12.3.2" StatusExtension;
    103 SensorAlarm        "Sensor Alarm"       ARRAY(2)   [1_R 2_R]     V  "12.3.3";
    104 SensorWarning      "Sensor Warning"     ARRAY(2)   [1_R 2_R]     V  "12.3.4";
}

block! {
    /// The range of the whole gauge.
    pub OneOfNTransducer in one_of_n_transducer = "OneOfN Vacuum Gauge Transducer Block";
    // ID  parameter       name as printed              data type  access             store  section
    // Printed without 0_XI, but it is in the telegrams (65).
    120 StatusExtension    "OneOfN Status Extension"    UINT8      [0_XI 1_R 2_R]     V  "13.1.1" StatusExtension;
}

/// The device block.
pub const DEVICE: Location = Location::slot(0, "Device");
/// The blocks that choose the instance.
pub const ONE_OF_N: Location = Location::slot(1, "OneOfN");
/// The capacitance diaphragm gauge of a PCG55x.
pub const CDG: Location = Location::instance(1, 1, "CDG");
/// The Pirani of a PCG55x.
pub const PCG_PIRANI: Location = Location::instance(1, 2, "Pirani");
/// The Pirani of a PSG55x (8).
pub const PSG_PIRANI: Location = Location::instance(1, 1, "Pirani");
/// The atmosphere sensor.
pub const ATM: Location = Location::instance(1, 3, "ATM");
/// Trip point 1.
pub const TRIP_POINT_1: Location = Location::slot(2, "Trip Point 1");
/// Trip point 2.
pub const TRIP_POINT_2: Location = Location::slot(3, "Trip Point 2");
/// Relay 1.
pub const RELAY_1: Location = Location::slot(4, "Relay 1");
/// Relay 2.
pub const RELAY_2: Location = Location::slot(5, "Relay 2");

blocks! {
    /// All parameters of the series. Slot 1 shows one instance at a time (52).
    ///
    /// The list is that of a PCG55x with an atmosphere sensor; [`PCG_BLOCKS`] and [`PSG_BLOCKS`] are the others.
    pub Parameter;
    Device(DeviceBlock)                [DEVICE];
    OneOfNInput(OneOfNInput)           [ONE_OF_N];
    CdgInput(CdgInput)                 [CDG];
    PiraniInput(PiraniInput)           [PCG_PIRANI];
    AtmInput(AtmInput)                 [ATM];
    OneOfNTransducer(OneOfNTransducer) [ONE_OF_N];
    CdgTransducer(CdgTransducer)       [CDG];
    PiraniTransducer(PiraniTransducer) [PCG_PIRANI];
    AtmTransducer(AtmTransducer)       [ATM];
    TripPoint(TripPoint)               [TRIP_POINT_1, TRIP_POINT_2];
    DiscreteOutput(DiscreteOutput)     [RELAY_1, RELAY_2];
}

// The three analog inputs and the three transducers are read by the same code: one table of each kind has every index.
const _: () = assert!(all_in(&PiraniInput::BLOCK, &CdgInput::BLOCK) && all_in(&AtmInput::BLOCK, &CdgInput::BLOCK));
const _: () = assert!(all_in(&CdgTransducer::BLOCK, &PiraniTransducer::BLOCK));
const _: () = assert!(all_in(&AtmTransducer::BLOCK, &PiraniTransducer::BLOCK));
const _: () = assert!(all_in(&PsgDeviceBlock::BLOCK, &DeviceBlock::BLOCK));

/// Whether every index of `block` is in `whole` too.
const fn all_in(block: &Block, whole: &Block) -> bool {
    let mut rows = block.rows;
    while let [row, rest @ ..] = rows {
        if !has(whole.rows, row.index) {
            return false;
        }
        rows = rest;
    }
    true
}

const fn has(mut rows: &[Row], index: u8) -> bool {
    while let [row, rest @ ..] = rows {
        if row.index == index {
            return true;
        }
        rows = rest;
    }
    false
}

/// The blocks of a PCG55x without an atmosphere sensor (8.3, 12.3).
#[rustfmt::skip]
pub static PCG_BLOCKS: [PlacedBlock; 11] = [
    PlacedBlock { block: &DeviceBlock::BLOCK,      locations: &[DEVICE] },
    PlacedBlock { block: &OneOfNInput::BLOCK,      locations: &[ONE_OF_N] },
    PlacedBlock { block: &CdgInput::BLOCK,         locations: &[CDG] },
    PlacedBlock { block: &PiraniInput::BLOCK,      locations: &[PCG_PIRANI] },
    PlacedBlock { block: &AtmInput::BLOCK,         locations: &[] },
    PlacedBlock { block: &OneOfNTransducer::BLOCK, locations: &[ONE_OF_N] },
    PlacedBlock { block: &CdgTransducer::BLOCK,    locations: &[CDG] },
    PlacedBlock { block: &PiraniTransducer::BLOCK, locations: &[PCG_PIRANI] },
    PlacedBlock { block: &AtmTransducer::BLOCK,    locations: &[] },
    PlacedBlock { block: &TripPoint::BLOCK,        locations: &[TRIP_POINT_1, TRIP_POINT_2] },
    PlacedBlock { block: &DiscreteOutput::BLOCK,   locations: &[RELAY_1, RELAY_2] },
];

/// The blocks of a PSG55x, whose Pirani is instance 1 (8).
#[rustfmt::skip]
pub static PSG_BLOCKS: [PlacedBlock; 11] = [
    PlacedBlock { block: &PsgDeviceBlock::BLOCK,   locations: &[DEVICE] },
    PlacedBlock { block: &OneOfNInput::BLOCK,      locations: &[ONE_OF_N] },
    PlacedBlock { block: &CdgInput::BLOCK,         locations: &[] },
    PlacedBlock { block: &PiraniInput::BLOCK,      locations: &[PSG_PIRANI] },
    PlacedBlock { block: &AtmInput::BLOCK,         locations: &[] },
    PlacedBlock { block: &OneOfNTransducer::BLOCK, locations: &[ONE_OF_N] },
    PlacedBlock { block: &CdgTransducer::BLOCK,    locations: &[] },
    PlacedBlock { block: &PiraniTransducer::BLOCK, locations: &[PSG_PIRANI] },
    PlacedBlock { block: &AtmTransducer::BLOCK,    locations: &[] },
    PlacedBlock { block: &TripPoint::BLOCK,        locations: &[TRIP_POINT_1, TRIP_POINT_2] },
    PlacedBlock { block: &DiscreteOutput::BLOCK,   locations: &[RELAY_1, RELAY_2] },
];

// 4.4.1. There is a telegram 2 in each direction (47).
static OUT_2: Telegram = telegram(2, &[Field::ParameterChannel]);
static OUT_206: Telegram = telegram(206, &[Field::Ignored(2)]);

static T1: Telegram = telegram(1, &[Field::ExceptionStatus, Field::ProcessValue(NumberType::Integer)]);
static T2: Telegram = telegram(2, &[Field::ExceptionStatus, Field::ProcessValue(NumberType::Float)]);
static T3: Telegram = telegram(
    3,
    &[Field::ExceptionStatus, Field::StatusExtension, Field::PvSelector, Field::ProcessValue(NumberType::Integer)],
);
static T4: Telegram = telegram(
    4,
    &[Field::ExceptionStatus, Field::StatusExtension, Field::PvSelector, Field::ProcessValue(NumberType::Float)],
);
static T7: Telegram =
    telegram(7, &[Field::ParameterChannel, Field::ExceptionStatus, Field::ProcessValue(NumberType::Integer)]);
static T8: Telegram =
    telegram(8, &[Field::ParameterChannel, Field::ExceptionStatus, Field::ProcessValue(NumberType::Float)]);
static T9: Telegram = telegram(
    9,
    &[
        Field::ParameterChannel,
        Field::ExceptionStatus,
        Field::StatusExtension,
        Field::PvSelector,
        Field::ProcessValue(NumberType::Integer),
    ],
);
static T10: Telegram = telegram(
    10,
    &[
        Field::ParameterChannel,
        Field::ExceptionStatus,
        Field::StatusExtension,
        Field::PvSelector,
        Field::ProcessValue(NumberType::Float),
    ],
);
// "Channel Status" in 3.7 is the status extension (46); one octet for each relay (103).
static T201: Telegram = telegram(
    201,
    &[Field::ExceptionStatus, Field::ProcessValue(NumberType::Integer), Field::StatusExtension, Field::TripRelays(2)],
);
static T202: Telegram = telegram(
    202,
    &[Field::ExceptionStatus, Field::ProcessValue(NumberType::Float), Field::StatusExtension, Field::TripRelays(2)],
);
static T203: Telegram = telegram(
    203,
    &[
        Field::ParameterChannel,
        Field::ExceptionStatus,
        Field::ProcessValue(NumberType::Integer),
        Field::StatusExtension,
        Field::TripRelays(2),
    ],
);
static T204: Telegram = telegram(
    204,
    &[
        Field::ParameterChannel,
        Field::ExceptionStatus,
        Field::ProcessValue(NumberType::Float),
        Field::StatusExtension,
        Field::TripRelays(2),
    ],
);
static T205: Telegram = telegram(205, &[Field::TtrValue]);

/// 4.4.2
#[rustfmt::skip]
static CONFIGURATIONS: [Configuration; 13] = [
    configuration(None,           Some(&T1),   &[0x42, 0x82, 0x05, 0x03]),
    configuration(None,           Some(&T2),   &[0x42, 0x84, 0x05, 0x08]),
    configuration(None,           Some(&T3),   &[0x44, 0x84, 0x05, 0x05, 0x05, 0x03]),
    configuration(None,           Some(&T4),   &[0x44, 0x86, 0x05, 0x05, 0x05, 0x08]),
    configuration(Some(&OUT_2),   Some(&T7),   &[0xC4, 0x87, 0x8A, 0x0A, 0x0A, 0x05, 0x03]),
    configuration(Some(&OUT_2),   Some(&T8),   &[0xC4, 0x87, 0x8C, 0x0A, 0x0A, 0x05, 0x08]),
    configuration(Some(&OUT_2),   Some(&T9),   &[0xC6, 0x87, 0x8C, 0x0A, 0x0A, 0x05, 0x05, 0x05, 0x03]),
    configuration(Some(&OUT_2),   Some(&T10),  &[0xC6, 0x87, 0x8E, 0x0A, 0x0A, 0x05, 0x05, 0x05, 0x08]),
    configuration(None,           Some(&T201), &[0x44, 0x85, 0x05, 0x03, 0x05, 0x0A]),
    configuration(None,           Some(&T202), &[0x44, 0x87, 0x05, 0x08, 0x05, 0x0A]),
    configuration(Some(&OUT_2),   Some(&T203), &[0xC6, 0x87, 0x8D, 0x0A, 0x0A, 0x05, 0x03, 0x05, 0x0A]),
    configuration(Some(&OUT_2),   Some(&T204), &[0xC6, 0x87, 0x8F, 0x0A, 0x0A, 0x05, 0x08, 0x05, 0x0A]),
    configuration(Some(&OUT_206), Some(&T205), &[0xA1, 0x91]),
];

/// 8.1.3: mbar per Torr (83).
const TORR: f64 = 1.333_223_69;

/// The pressure units. 8.1.6; the codes are hexadecimal (14), and there is no micron (62).
#[rustfmt::skip]
pub static UNITS: [Unit; 4] = [
    Unit { code: 0x1001, name: "COUNTS", alias: "counts", scale: Scale::Counts },
    Unit { code: 0x1301, name: "Torr",   alias: "torr",   scale: Scale::PerMbar(1.0 / TORR) },
    Unit { code: 0x1308, name: "mbar",   alias: "hPa",    scale: Scale::MBAR },
    Unit { code: 0x1309, name: "Pascal", alias: "Pa",     scale: Scale::PASCAL },
];

/// 3.8
#[rustfmt::skip]
static USER_PRM: [UserPrm; 5] = [
    UserPrm { name: "COUNTS",                 octets: &[0x00, 0x00, 0x00, 0x10, 0x01] },
    UserPrm { name: "Torr",                   octets: &[0x00, 0x00, 0x00, 0x13, 0x01] },
    UserPrm { name: "mbar",                   octets: &[0x00, 0x00, 0x00, 0x13, 0x08] },
    UserPrm { name: "Pascal",                 octets: &[0x00, 0x00, 0x00, 0x13, 0x09] },
    UserPrm { name: "TTR compatibility mode", octets: &[0x00, 0x00, 0x00, 0x00, 0x00] },
];

/// The unit as it leaves the factory (85).
pub const FACTORY_UNIT: &Unit = &UNITS[2];

/// 4.3.1, 4.3.3. Code 13 is there for texts (6).
static CHANNEL_RULES: ChannelRules = ChannelRules {
    tasks: &[
        (1, TaskKind::Read),
        (2, TaskKind::Write(&[2])),
        // Printed without a text (53).
        (3, TaskKind::Write(&[4])),
        (10, TaskKind::Write(&[1])),
    ],
    needs_idle_between: true,
    error_codes: &[(AccessError::NotInChannel, 13)],
};

/// Revision of the firmware, of the PROFIBUS adapter and of the gauge: six digits, xxyyzz (59).
///
/// chosen: the numbers.
pub const FIRMWARE: &str = "010100";
/// Revision of the PROFIBUS adapter's hardware, likewise.
pub const HARDWARE: &str = "010000";

/// I&M0 without order ID and serial number (5.1, 110). The revisions are those of the PROFIBUS board.
pub const IM0: Im0<'static> = Im0 {
    header: [0; 10],
    manufacturer_id: 0x017A,
    order_id: &[],
    serial_number: &[],
    hardware_revision: 0x0100,
    software_revision: [b'V', 1, 1, 0],
    rev_counter: 0,
    profile_id: 0x5A00,
    profile_specific_type: 0,
    im_version: [1, 1],
    im_supported: 0,
};

/// The measuring parts and blocks of a family.
#[derive(Debug)]
pub struct Family {
    /// Device Type.
    pub device_type: &'static str,
    /// The measuring parts, in the order of their instances.
    pub parts: &'static [Part],
    /// The diaphragm.
    pub cdg: Option<&'static PartSpec>,
    /// The Pirani.
    pub pirani: &'static PartSpec,
    /// The atmosphere sensor.
    pub atm: Option<&'static PartSpec>,
    specs: &'static [&'static PartSpec],
    blocks: &'static [PlacedBlock],
    faults: &'static FaultList,
}

static PCG_WITH_ATM: Family = Family {
    device_type: "CVG",
    parts: &[parts::CDG.part, parts::PCG_PIRANI.part, parts::ATM.part],
    cdg: Some(&parts::CDG),
    pirani: &parts::PCG_PIRANI,
    atm: Some(&parts::ATM),
    specs: &[&parts::CDG, &parts::PCG_PIRANI, &parts::ATM],
    blocks: Parameter::BLOCKS,
    faults: &PCG_WITH_ATM_FAULTS,
};

static PCG: Family = Family {
    device_type: "CVG",
    parts: &[parts::CDG.part, parts::PCG_PIRANI.part],
    cdg: Some(&parts::CDG),
    pirani: &parts::PCG_PIRANI,
    atm: None,
    specs: &[&parts::CDG, &parts::PCG_PIRANI],
    blocks: &PCG_BLOCKS,
    faults: &PCG_FAULTS,
};

static PSG: Family = Family {
    device_type: "VPG",
    parts: &[parts::PSG_PIRANI.part],
    cdg: None,
    pirani: &parts::PSG_PIRANI,
    atm: None,
    specs: &[&parts::PSG_PIRANI],
    blocks: &PSG_BLOCKS,
    faults: &PSG_FAULTS,
};

/// A gauge of the series.
#[derive(Debug)]
pub struct Variant {
    /// Its tables.
    pub model: Model,
    /// Its measuring parts and blocks.
    pub family: &'static Family,
    /// Manufacturer Model Number: the part number (61).
    pub number: &'static str,
    /// Device Configuration (63).
    pub configuration: &'static str,
}

const fn variant(
    family: &'static Family,
    name: &'static str,
    title: &'static str,
    number: &'static str,
    configuration: &'static str,
) -> Variant {
    let model = Model {
        name,
        title,
        vendor: "INFICON AG",
        manual: "tira56e1",
        ident: 0x0C85,
        features: Features { sync: false, freeze: false, dpv1: true, ms1: true },
        configurations: &CONFIGURATIONS,
        // chosen: the manual names no default. A float, and nothing that a master must send.
        default_configuration: &CONFIGURATIONS[1],
        values: &[],
        units: &UNITS,
        max_integer: INTEGER16_MAX,
        user_prm: &USER_PRM,
        // DPV1_Enable, Fail_Safe, WD_Base_1ms: what the slave supports (39).
        dpv1_status: 0xC4,
        blocks: family.blocks,
        parts: family.specs,
        channel_rules: &CHANNEL_RULES,
        // 7.1.12: instances 1 and 2, in a PSG55x only 1. Table 28, 12.1.3, 12.2.3, 12.3.3.
        alarms: AlarmWords {
            instances: &[1, 2],
            sensor: &[
                AlarmBit { octet: 0, mask: 1 << 0, name: "sensor element failure" },
                AlarmBit { octet: 1, mask: 1 << 1, name: "electronics failure" },
            ],
            manufacturer: &[(1 << 0, "internal communication exception"), (1 << 1, "incompatible software")],
        },
        faults: family.faults,
        errata: text("errata-pxg55x-img400 1 to 112, 163 to 166"),
        gsd: Gsd { revision: 1, hardware: HARDWARE, software: FIRMWARE, max_diag_octets: 6, set_slave_add: true },
    };
    Variant { model, family, number, configuration }
}

/// The whole series, a gauge with an atmosphere sensor before the same without.
///
/// The models differ in the filament: tungsten, nickel, and ceramic coated, which has no abbreviation in 7.1.9.
/// Connector, relays and analog output are those of the example there, and the part numbers stand for them.
pub static VARIANTS: [&Variant; 9] =
    [&PCG550_WITH_ATM, &PCG552_WITH_ATM, &PCG554_WITH_ATM, &PCG550, &PCG552, &PCG554, &PSG550, &PSG552, &PSG554];

/// Tungsten, with an atmosphere sensor.
pub static PCG550_WITH_ATM: Variant =
    variant(&PCG_WITH_ATM, "pcg550", "PCG550", "3PC1-001-3121", "DS9 SP WO ATM PB CDG AO0 PIR");
/// Nickel, with an atmosphere sensor.
pub static PCG552_WITH_ATM: Variant =
    variant(&PCG_WITH_ATM, "pcg552", "PCG552", "3PC2-001-3121", "DS9 SP NI ATM PB CDG AO0 PIR");
/// Ceramic coated, with an atmosphere sensor.
pub static PCG554_WITH_ATM: Variant =
    variant(&PCG_WITH_ATM, "pcg554", "PCG554", "3PC3-001-3121", "DS9 SP ATM PB CDG AO0 PIR");
/// Tungsten, without an atmosphere sensor.
pub static PCG550: Variant = variant(&PCG, "pcg550", "PCG550", "3PC1-001-2121", "DS9 SP WO PB CDG AO0 PIR");
/// Nickel, without an atmosphere sensor.
pub static PCG552: Variant = variant(&PCG, "pcg552", "PCG552", "3PC2-001-2121", "DS9 SP NI PB CDG AO0 PIR");
/// Ceramic coated, without an atmosphere sensor.
pub static PCG554: Variant = variant(&PCG, "pcg554", "PCG554", "3PC3-001-2121", "DS9 SP PB CDG AO0 PIR");
/// Tungsten.
pub static PSG550: Variant = variant(&PSG, "psg550", "PSG550", "3PI1-001-2121", "DS9 SP WO PB AO0 PIR");
/// Nickel.
pub static PSG552: Variant = variant(&PSG, "psg552", "PSG552", "3PI2-001-2121", "DS9 SP NI PB AO0 PIR");
/// Ceramic coated.
pub static PSG554: Variant = variant(&PSG, "psg554", "PSG554", "3PI3-001-2121", "DS9 SP PB AO0 PIR");
