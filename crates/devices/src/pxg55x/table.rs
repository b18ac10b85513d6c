//! The tables of tira56e1, row by row: blocks of chapters 7 to 13, telegrams and configurations of 4.4. Names as printed
//! there. Sections are those of the manual, numbers in brackets those of errata-pxg55x-img400.

use super::codes::{ATM_ADJUST, CDG_ADJUST, PIRANI_ADJUST, PIRANI_OFF, SETPOINT_MODE};
use super::simulation::Faults;
use crate::model::block::{block, blocks};
use crate::model::{
    AccessError, Block, ChannelRules, Clipping, Configuration, Counts, FaultList, Field, Gsd, Limits, Location, Model,
    NumberType, ParameterSet, PartSpec, PlacedBlock, Row, Scale, TaskKind, Telegram, Unit, UserPrm, configuration,
    mbar, telegram,
};
use crate::profile::codes::{DATA_TYPE, DEVICE_STATE, EXCEPTIONS, SAFE_STATE, STATE_COMMAND, STATUS_EXTENSION, UNIT};
use crate::simulation::{Part, Principle};
use profivac_dp::slave::Features;
use profivac_wire::acyclic::Im0;

block! {
    /// Identity, state and exceptions of a PCG55x.
    pub DeviceBlock = "Device Block", type 1;
    // ID  parameter                    name as printed                           data type   access                store  section
    15  StateCommand                    "Device Block State"                      UINT8       [     1_R/W 2_R/W]     N  "7.2.2" STATE_COMMAND;
    16  BlockType                       "Block Type ID"                           OSTRING(4)  [     1_R   2_R  ]     N  "7.1.1";
    17  DeviceType                      "Device Type"                             VSTRING(8)  [           2_R  ]     N  "7.1.2";
    18  StandardRevision                "Standard Revision Level"                 VSTRING(9)  [           2_R  ]     N  "7.1.3";
    19  Manufacturer                    "Device Manufacturer Identifier"          VSTRING(20) [           2_R  ]     N  "7.1.4";
    20  ModelNumber                     "Manufacturer Model Number"               VSTRING(20) [           2_R  ]     N  "7.1.5";
    21  FirmwareRevision                "Software or Firmware Revision Level"     VSTRING(8)  [           2_R  ]     N  "7.1.6";
    22  HardwareRevision                "Hardware Revision Level"                 VSTRING(8)  [           2_R  ]     N  "7.1.7";
    23  SerialNumber                    "Serial Number"                           VSTRING(30) [           2_R  ]     N  "7.1.8";
    24  DeviceConfiguration             "Device Configuration"                    VSTRING(50) [           2_R  ]     N  "7.1.9";
    25  DeviceState                     "Device State"                            UINT8       [0_XI 1_R   2_R  ]     V  "7.1.10" DEVICE_STATE;
    26  ExceptionStatus                 "Exception Status"                        UINT8       [0_XI 1_R   2_R  ]     V  "7.1.11" EXCEPTIONS;
    27  ExceptionDetailAlarm            "Exception Detail Alarm"                  RECORD(10)  [     1_R   2_R  ]     V  "7.1.12";
    28  ExceptionDetailWarning          "Exception Detail Warning"                RECORD(11)  [     1_R   2_R  ]     V  "7.1.13";
    36  RunHours                        "Run hours"                               UINT16      [     1_R   2_R  ]     N  "7.1.14";
    202 BasicDeviceFirmwareRevision     "Basic Device Firmware Revision Level"    VSTRING(8)  [           2_R  ]     N  "7.1.15";
    204 CommonExceptionAlarm            "Common Exception Detail Alarm"           ARRAY(2)    [     1_R   2_R  ]     V  "7.1.16";
    205 DeviceExceptionAlarm            "Device Exception Detail Alarm"           ARRAY(4)    [     1_R   2_R  ]     V  "7.1.17";
    206 ManufacturerExceptionAlarm      "Manufacturer Exception Detail Alarm"     UINT8       [     1_R   2_R  ]     V  "7.1.18";
    207 CommonExceptionWarning          "Common Exception Detail Warning"         ARRAY(2)    [     1_R   2_R  ]     V  "7.1.19";
    // Printed as an array of one octet (75).
    208 DeviceExceptionWarning1         "Device Exception Detail Warning I"       UINT8       [     1_R   2_R  ]     V  "7.1.20" STATUS_EXTENSION;
    209 DeviceExceptionWarning2         "Device Exception Detail Warning II"      ARRAY(4)    [     1_R   2_R  ]     V  "7.1.20";
    210 ManufacturerExceptionWarning    "Manufacturer Exception Detail Warning"   UINT8       [     1_R   2_R  ]     V  "7.1.21";
    211 AddressSwitch                   "Address Switch"                          UINT8       [     1_R   2_R  ]     V  "7.1.22";
    212 RunHours4                       "Run hours (*4)"                          UINT32      [     1_R   2_R  ]     N  "7.1.23";
}

block! {
    /// The same of a PSG55x: with one sensor instead of two, 27, 28, 205 and 209 are shorter.
    pub PsgDeviceBlock = "Device Block", type 1;
    // ID  parameter                    name as printed                           data type   access                store  section
    15  StateCommand                    "Device Block State"                      UINT8       [     1_R/W 2_R/W]     N  "7.2.2" STATE_COMMAND;
    16  BlockType                       "Block Type ID"                           OSTRING(4)  [     1_R   2_R  ]     N  "7.1.1";
    17  DeviceType                      "Device Type"                             VSTRING(8)  [           2_R  ]     N  "7.1.2";
    18  StandardRevision                "Standard Revision Level"                 VSTRING(9)  [           2_R  ]     N  "7.1.3";
    19  Manufacturer                    "Device Manufacturer Identifier"          VSTRING(20) [           2_R  ]     N  "7.1.4";
    20  ModelNumber                     "Manufacturer Model Number"               VSTRING(20) [           2_R  ]     N  "7.1.5";
    21  FirmwareRevision                "Software or Firmware Revision Level"     VSTRING(8)  [           2_R  ]     N  "7.1.6";
    22  HardwareRevision                "Hardware Revision Level"                 VSTRING(8)  [           2_R  ]     N  "7.1.7";
    23  SerialNumber                    "Serial Number"                           VSTRING(30) [           2_R  ]     N  "7.1.8";
    24  DeviceConfiguration             "Device Configuration"                    VSTRING(50) [           2_R  ]     N  "7.1.9";
    25  DeviceState                     "Device State"                            UINT8       [0_XI 1_R   2_R  ]     V  "7.1.10" DEVICE_STATE;
    26  ExceptionStatus                 "Exception Status"                        UINT8       [0_XI 1_R   2_R  ]     V  "7.1.11" EXCEPTIONS;
    27  ExceptionDetailAlarm            "Exception Detail Alarm"                  RECORD(8)   [     1_R   2_R  ]     V  "7.1.12";
    28  ExceptionDetailWarning          "Exception Detail Warning"                RECORD(9)   [     1_R   2_R  ]     V  "7.1.13";
    36  RunHours                        "Run hours"                               UINT16      [     1_R   2_R  ]     N  "7.1.14";
    202 BasicDeviceFirmwareRevision     "Basic Device Firmware Revision Level"    VSTRING(8)  [           2_R  ]     N  "7.1.15";
    204 CommonExceptionAlarm            "Common Exception Detail Alarm"           ARRAY(2)    [     1_R   2_R  ]     V  "7.1.16";
    205 DeviceExceptionAlarm            "Device Exception Detail Alarm"           ARRAY(2)    [     1_R   2_R  ]     V  "7.1.17";
    206 ManufacturerExceptionAlarm      "Manufacturer Exception Detail Alarm"     UINT8       [     1_R   2_R  ]     V  "7.1.18";
    207 CommonExceptionWarning          "Common Exception Detail Warning"         ARRAY(2)    [     1_R   2_R  ]     V  "7.1.19";
    // Printed as an array of one octet (75).
    208 DeviceExceptionWarning1         "Device Exception Detail Warning I"       UINT8       [     1_R   2_R  ]     V  "7.1.20" STATUS_EXTENSION;
    209 DeviceExceptionWarning2         "Device Exception Detail Warning II"      ARRAY(2)    [     1_R   2_R  ]     V  "7.1.20";
    210 ManufacturerExceptionWarning    "Manufacturer Exception Detail Warning"   UINT8       [     1_R   2_R  ]     V  "7.1.21";
    211 AddressSwitch                   "Address Switch"                          UINT8       [     1_R   2_R  ]     V  "7.1.22";
    212 RunHours4                       "Run hours (*4)"                          UINT32      [     1_R   2_R  ]     N  "7.1.23";
}

block! {
    /// The capacitance diaphragm gauge.
    pub CdgInput = "Sensor Analog Input Function Block (CDG)", type 2;
    // ID  parameter      name as printed             data type  access                store  section
    // Printed with a target value of the data type's length in one octet (78).
    15  AdjustCommand     "AIBlockAdjust Command"     RECORD(2)  [     1_R/W 2_R/W]     N  "8.1.1" CDG_ADJUST;
    16  BlockType         "Block Type ID"             OSTRING(4) [     1_R   2_R  ]     N  "8.1.2";
    19  ProcessValue      "ProcessValue (PV)"         BY_TYPE    [0_XI 1_R   2_R  ]     D  "8.1.3";
    20  Status            "Status"                    UINT8      [0_XI 1_R   2_R  ]     D  "8.1.4";
    21  DataType          "Data Type"                 UINT8      [           2_R/W]     N  "8.1.5" DATA_TYPE;
    22  DataUnit          "Data Unit"                 UINT16     [           2_R/W]     N  "8.1.6" UNIT;
    23  ReadingValid      "Reading Valid"             BOOLEAN    [     1_R   2_R  ]     D  "8.1.7";
    24  FullScale         "Full Scale"                BY_TYPE    [     1_R   2_R  ]     N  "8.1.8";
    39  SafeState         "Safe State"                UINT8      [     1_R/W 2_R/W]     N  "8.1.9" SAFE_STATE;
    40  SafeValue         "Safe Value"                BY_TYPE    [     1_R/W 2_R/W]     N  "8.1.10";
    41  AutoZeroEnable    "Auto Zero Enable"          BOOLEAN    [     1_R/W 2_R/W]     N  "8.1.11";
    44  Overrange         "Overrange"                 BY_TYPE    [     1_R   2_R  ]     N  "8.1.12";
    45  Underrange        "Underrange"                BY_TYPE    [     1_R   2_R  ]     N  "8.1.13";
}

block! {
    /// The Pirani.
    pub PiraniInput = "Sensor Analog Input Function Block (Pirani)", type 2;
    // ID  parameter      name as printed             data type  access                store  section
    15  AdjustCommand     "AIBlockAdjust Command"     RECORD(2)  [     1_R/W 2_R/W]     N  "8.2.1" PIRANI_ADJUST;
    16  BlockType         "Block Type ID"             OSTRING(4) [     1_R   2_R  ]     N  "8.2.2";
    19  ProcessValue      "ProcessValue (PV)"         BY_TYPE    [0_XI 1_R   2_R  ]     D  "8.2.3";
    20  Status            "Status"                    UINT8      [0_XI 1_R   2_R  ]     D  "8.2.4";
    21  DataType          "Data Type"                 UINT8      [           2_R/W]     N  "8.2.5" DATA_TYPE;
    22  DataUnit          "Data Unit"                 UINT16     [           2_R/W]     N  "8.2.6" UNIT;
    23  ReadingValid      "Reading Valid"             BOOLEAN    [     1_R   2_R  ]     D  "8.2.7";
    24  FullScale         "Full Scale"                BY_TYPE    [     1_R   2_R  ]     N  "8.2.8";
    39  SafeState         "Safe State"                UINT8      [     1_R/W 2_R/W]     N  "8.2.9" SAFE_STATE;
    40  SafeValue         "Safe Value"                BY_TYPE    [     1_R/W 2_R/W]     N  "8.2.10";
    44  Overrange         "Overrange"                 BY_TYPE    [     1_R   2_R  ]     N  "8.2.11";
    45  Underrange        "Underrange"                BY_TYPE    [     1_R   2_R  ]     N  "8.2.12";
}

block! {
    /// The atmosphere pressure sensor.
    pub AtmInput = "Sensor Analog Input Function Block (ATM)", type 2;
    // ID  parameter      name as printed             data type  access                store  section
    15  AdjustCommand     "AIBlockAdjust Command"     RECORD(2)  [     1_R/W 2_R/W]     N  "8.3.1" ATM_ADJUST;
    16  BlockType         "Block Type ID"             OSTRING(4) [     1_R   2_R  ]     N  "8.3.2";
    19  ProcessValue      "ProcessValue (PV)"         BY_TYPE    [0_XI 1_R   2_R  ]     D  "8.3.3";
    20  Status            "Status"                    UINT8      [0_XI 1_R   2_R  ]     D  "8.3.4";
    // No data type is printed (89).
    21  DataType          "Data Type"                 UINT8      [           2_R/W]     N  "8.3.5" DATA_TYPE;
    22  DataUnit          "Data Unit"                 UINT16     [           2_R/W]     N  "8.3.6" UNIT;
    23  ReadingValid      "Reading Valid"             BOOLEAN    [     1_R   2_R  ]     D  "8.3.7";
    24  FullScale         "Full Scale"                BY_TYPE    [     1_R   2_R  ]     N  "8.3.8";
    39  SafeState         "Safe State"                UINT8      [     1_R/W 2_R/W]     N  "8.3.9" SAFE_STATE;
    40  SafeValue         "Safe Value"                BY_TYPE    [     1_R/W 2_R/W]     N  "8.3.10";
    44  Overrange         "Overrange"                 BY_TYPE    [     1_R   2_R  ]     N  "8.3.11";
    45  Underrange        "Underrange"                BY_TYPE    [     1_R   2_R  ]     N  "8.3.12";
}

block! {
    /// Chooses which instance slot 1 shows, and tells which one is in the cyclic data. Neither has a block type of its own (70).
    pub OneOfNInput = "OneOfN Analog Input Function Block";
    // ID  parameter              name as printed             data type  access                store  section
    46  ChannelInstanceSelector   "Channel Instance Selector" UINT8      [     1_R/W 2_R/W]     N  "9.1.1";
    // Printed N and without 0_XI, but the gauge chooses it and sends it (65, 66).
    47  PvSelector                "OneOfN PV Selector"        UINT8      [0_XI 1_R   2_R  ]     D  "9.1.2";
}

block! {
    /// Drives a relay.
    pub DiscreteOutput = "Discrete Output Function Block", type 7;
    // ID  parameter      name as printed    data type  access          store  section
    // Printed as one octet (92).
    16  BlockType         "Block Type ID"    OSTRING(4) [     1_R 2_R]   N  "10.1.1";
    19  SetpointValue     "Setpoint Value"   UINT8      [0_XO     2_R]   D  "10.1.2";
    20  Status            "Status"           BOOLEAN    [         2_R]   D  "10.1.3";
}

block! {
    /// Compares the process value with a high and a low limit.
    pub TripPoint = "Trip Point Function Block", type 17;
    // ID  parameter            name as printed                             data type  access                store  section
    16  BlockType               "Block Type ID"                             OSTRING(4) [     1_R   2_R  ]     N  "11.2.1";
    17  HighTripPoint           "High Trip Point"                           BY_TYPE    [     1_R/W 2_R/W]     N  "11.2.2";
    18  HighTripEnable          "High Trip Enable"                          BOOLEAN    [     1_R/W 2_R/W]     N  "11.2.3";
    19  LowTripPoint            "Low Trip Point"                            BY_TYPE    [     1_R/W 2_R/W]     N  "11.2.4";
    20  LowTripEnable           "Low Trip Enable"                           BOOLEAN    [     1_R/W 2_R/W]     N  "11.2.5";
    21  Status                  "Status"                                    UINT8      [0_XI 1_R   2_R  ]     D  "11.2.6";
    26  DiscreteOutputInstance  "Discrete Output Function Block Instance"   UINT8      [     1_R   2_R  ]     N  "11.2.7";
    28  DataUnits               "Data Units"                                UINT16     [           2_R/W]     N  "11.2.8" UNIT;
    29  DataType                "Data Type"                                 UINT8      [           2_R/W]     N  "11.2.9" DATA_TYPE;
    31  HighTripPointHysteresis "High Trip Point Hysteresis"                BY_TYPE    [     1_R/W 2_R/W]     N  "11.2.10";
    32  LowTripPointHysteresis  "Low Trip Point Hysteresis"                 BY_TYPE    [     1_R/W 2_R/W]     N  "11.2.11";
    201 FactorOfAtm             "Factor of ATM"                             FLOAT      [     1_R/W 2_R/W]     N  "11.2.12";
    202 SetpointMode            "Setpoint Mode"                             UINT8      [     1_R/W 2_R/W]     N  "11.2.13" SETPOINT_MODE;
}

block! {
    /// The diaphragm sensor.
    pub CdgTransducer = "CDG Transducer Block", type 14;
    // ID  parameter       name as printed      data type  access        store  section
    101 BlockType          "Block Type ID"      OSTRING(4) [1_R 2_R]     N  "12.1.1";
    102 StatusExtension    "Status Extension"   UINT8      [1_R 2_R]     V  "12.1.2" STATUS_EXTENSION;
    103 SensorAlarm        "Sensor Alarm"       ARRAY(2)   [1_R 2_R]     V  "12.1.3";
    104 SensorWarning      "Sensor Warning"     ARRAY(2)   [1_R 2_R]     V  "12.1.4";
}

block! {
    /// The Pirani sensor.
    pub PiraniTransducer = "Pirani Transducer Block", type 13;
    // ID  parameter       name as printed      data type  access            store  section
    101 BlockType          "Block Type ID"      OSTRING(4) [1_R   2_R  ]     N  "12.2.1";
    102 StatusExtension    "Status Extension"   UINT8      [1_R   2_R  ]     V  "12.2.2" STATUS_EXTENSION;
    103 SensorAlarm        "Sensor Alarm"       ARRAY(2)   [1_R   2_R  ]     V  "12.2.3";
    104 SensorWarning      "Sensor Warning"     ARRAY(2)   [1_R   2_R  ]     V  "12.2.4";
    201 PiraniOff          "Pirani OFF"         UINT8      [1_R/W 2_R/W]     N  "12.2.5" PIRANI_OFF;
}

block! {
    /// The atmosphere sensor.
    pub AtmTransducer = "ATM Transducer Block", type 256;
    // ID  parameter       name as printed      data type  access        store  section
    101 BlockType          "Block Type ID"      OSTRING(4) [1_R 2_R]     N  "12.3.1";
    102 StatusExtension    "Status Extension"   UINT8      [1_R 2_R]     V  "12.3.2" STATUS_EXTENSION;
    103 SensorAlarm        "Sensor Alarm"       ARRAY(2)   [1_R 2_R]     V  "12.3.3";
    104 SensorWarning      "Sensor Warning"     ARRAY(2)   [1_R 2_R]     V  "12.3.4";
}

block! {
    /// The gauge as one.
    pub OneOfNTransducer = "OneOfN Vacuum Gauge Transducer Block";
    // ID  parameter       name as printed              data type  access             store  section
    // Printed without 0_XI, but it is in the telegrams (65).
    120 StatusExtension    "OneOfN Status Extension"    UINT8      [0_XI 1_R 2_R]     V  "13.1.1" STATUS_EXTENSION;
}

blocks! {
    /// All parameters of the series. Slot 1 shows one instance at a time (52).
    ///
    /// The list is that of a PCG55x with an atmosphere sensor; [`PCG_PLACES`] and [`PSG_PLACES`] are the others.
    pub Parameter;
    Device(DeviceBlock)                [0 "Device"];
    OneOfNInput(OneOfNInput)           [1 "OneOfN"];
    CdgInput(CdgInput)                 [1:1 "CDG"];
    PiraniInput(PiraniInput)           [1:2 "Pirani"];
    AtmInput(AtmInput)                 [1:3 "ATM"];
    OneOfNTransducer(OneOfNTransducer) [1 "OneOfN"];
    CdgTransducer(CdgTransducer)       [1:1 "CDG"];
    PiraniTransducer(PiraniTransducer) [1:2 "Pirani"];
    AtmTransducer(AtmTransducer)       [1:3 "ATM"];
    TripPoint(TripPoint)               [2 "Trip Point 1", 3 "Trip Point 2"];
    DiscreteOutput(DiscreteOutput)     [4 "Relay 1", 5 "Relay 2"];
}

// The three analog inputs and the three transducers are read by the same code: one table of each kind has every ID.
const _: () = assert!(all_in(&PiraniInput::BLOCK, &CdgInput::BLOCK) && all_in(&AtmInput::BLOCK, &CdgInput::BLOCK));
const _: () = assert!(all_in(&CdgTransducer::BLOCK, &PiraniTransducer::BLOCK));
const _: () = assert!(all_in(&AtmTransducer::BLOCK, &PiraniTransducer::BLOCK));
const _: () = assert!(all_in(&PsgDeviceBlock::BLOCK, &DeviceBlock::BLOCK));

/// Whether every ID of `block` is in `whole` too.
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

const fn has(mut rows: &[Row], id: u8) -> bool {
    while let [row, rest @ ..] = rows {
        if row.index == id {
            return true;
        }
        rows = rest;
    }
    false
}

const fn at(slot: u8, instance: u8, name: &'static str) -> Location {
    Location { slot, instance, name }
}

const ABSENT: &[Location] = &[];
const TRIP_POINTS: &[Location] = &[at(2, 0, "Trip Point 1"), at(3, 0, "Trip Point 2")];
const RELAYS: &[Location] = &[at(4, 0, "Relay 1"), at(5, 0, "Relay 2")];

/// A PCG55x without an atmosphere sensor (8.3, 12.3).
#[rustfmt::skip]
pub static PCG_PLACES: [PlacedBlock; 11] = [
    PlacedBlock { block: &DeviceBlock::BLOCK,      locations: &[at(0, 0, "Device")] },
    PlacedBlock { block: &OneOfNInput::BLOCK,      locations: &[at(1, 0, "OneOfN")] },
    PlacedBlock { block: &CdgInput::BLOCK,         locations: &[at(1, 1, "CDG")] },
    PlacedBlock { block: &PiraniInput::BLOCK,      locations: &[at(1, 2, "Pirani")] },
    PlacedBlock { block: &AtmInput::BLOCK,         locations: ABSENT },
    PlacedBlock { block: &OneOfNTransducer::BLOCK, locations: &[at(1, 0, "OneOfN")] },
    PlacedBlock { block: &CdgTransducer::BLOCK,    locations: &[at(1, 1, "CDG")] },
    PlacedBlock { block: &PiraniTransducer::BLOCK, locations: &[at(1, 2, "Pirani")] },
    PlacedBlock { block: &AtmTransducer::BLOCK,    locations: ABSENT },
    PlacedBlock { block: &TripPoint::BLOCK,        locations: TRIP_POINTS },
    PlacedBlock { block: &DiscreteOutput::BLOCK,   locations: RELAYS },
];

/// A PSG55x: the Pirani is instance 1 (8).
#[rustfmt::skip]
pub static PSG_PLACES: [PlacedBlock; 11] = [
    PlacedBlock { block: &PsgDeviceBlock::BLOCK,   locations: &[at(0, 0, "Device")] },
    PlacedBlock { block: &OneOfNInput::BLOCK,      locations: &[at(1, 0, "OneOfN")] },
    PlacedBlock { block: &CdgInput::BLOCK,         locations: ABSENT },
    PlacedBlock { block: &PiraniInput::BLOCK,      locations: &[at(1, 1, "Pirani")] },
    PlacedBlock { block: &AtmInput::BLOCK,         locations: ABSENT },
    PlacedBlock { block: &OneOfNTransducer::BLOCK, locations: &[at(1, 0, "OneOfN")] },
    PlacedBlock { block: &CdgTransducer::BLOCK,    locations: ABSENT },
    PlacedBlock { block: &PiraniTransducer::BLOCK, locations: &[at(1, 1, "Pirani")] },
    PlacedBlock { block: &AtmTransducer::BLOCK,    locations: ABSENT },
    PlacedBlock { block: &TripPoint::BLOCK,        locations: TRIP_POINTS },
    PlacedBlock { block: &DiscreteOutput::BLOCK,   locations: RELAYS },
];

// 4.4.1. There is a telegram 2 in each direction (47).
use Field::{
    ExceptionStatus, Ignored, ParameterChannel, ProcessValue, PvSelector, StatusExtension, TripRelays, TtrValue,
};
use NumberType::{Float, Integer};

static OUT_2: Telegram = telegram(2, &[ParameterChannel]);
static OUT_206: Telegram = telegram(206, &[Ignored(2)]);

static T1: Telegram = telegram(1, &[ExceptionStatus, ProcessValue(Integer)]);
static T2: Telegram = telegram(2, &[ExceptionStatus, ProcessValue(Float)]);
static T3: Telegram = telegram(3, &[ExceptionStatus, StatusExtension, PvSelector, ProcessValue(Integer)]);
static T4: Telegram = telegram(4, &[ExceptionStatus, StatusExtension, PvSelector, ProcessValue(Float)]);
static T7: Telegram = telegram(7, &[ParameterChannel, ExceptionStatus, ProcessValue(Integer)]);
static T8: Telegram = telegram(8, &[ParameterChannel, ExceptionStatus, ProcessValue(Float)]);
static T9: Telegram =
    telegram(9, &[ParameterChannel, ExceptionStatus, StatusExtension, PvSelector, ProcessValue(Integer)]);
static T10: Telegram =
    telegram(10, &[ParameterChannel, ExceptionStatus, StatusExtension, PvSelector, ProcessValue(Float)]);
// "Channel Status" in 3.7 is the status extension (46); one octet for each relay (103).
static T201: Telegram = telegram(201, &[ExceptionStatus, ProcessValue(Integer), StatusExtension, TripRelays(2)]);
static T202: Telegram = telegram(202, &[ExceptionStatus, ProcessValue(Float), StatusExtension, TripRelays(2)]);
static T203: Telegram =
    telegram(203, &[ParameterChannel, ExceptionStatus, ProcessValue(Integer), StatusExtension, TripRelays(2)]);
static T204: Telegram =
    telegram(204, &[ParameterChannel, ExceptionStatus, ProcessValue(Float), StatusExtension, TripRelays(2)]);
static T205: Telegram = telegram(205, &[TtrValue]);

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

/// 8.1.6; the codes are hexadecimal (14), and there is no micron (62).
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

/// Counts for a factor of ten, and at 1 mbar: 3511 x log10(2^20) + 1.
const PER_DECADE: f64 = 3511.0;
const AT_1_MBAR: f64 = PER_DECADE * 20.0 * core::f64::consts::LOG10_2 + 1.0;

/// 3511 x log10(p x 2^20) + 1, the braces set right (81).
pub const COUNTS: Counts = Counts::Log { per_decade: PER_DECADE, at_1_mbar: AT_1_MBAR };

/// 8.3.3: the atmosphere sensor has p x 2^4 (82).
const ATM_COUNTS: Counts = Counts::Linear { per_mbar: 16.0 };

/// A hysteresis above or below a point in Pa (32).
pub const fn distance(from_pa: f64, upwards: bool) -> Counts {
    Counts::Distance { per_decade: PER_DECADE, at_1_mbar: AT_1_MBAR, from_mbar: from_pa / mbar(1.0), upwards }
}

// 8: which instance is what.
const CDG_PART: Part = Part { instance: 1, principle: Principle::Diaphragm };
const PCG_PIRANI_PART: Part = Part { instance: 2, principle: Principle::Pirani };
const ATM_PART: Part = Part { instance: 3, principle: Principle::Atmosphere };
const PSG_PIRANI_PART: Part = Part { instance: 1, principle: Principle::Pirani };

/// 8.1.8, 8.1.12, 8.1.13: the manual has no numbers (86).
static CDG: PartSpec = PartSpec {
    part: CDG_PART,
    limits: Limits { under_pa: mbar(1.0), over_pa: mbar(1500.0), full_scale_pa: mbar(1500.0) },
    clipping: Clipping::Never,
    counts: COUNTS,
};

/// 8.2.8, 8.2.11, 8.2.12 (86)
const PIRANI_LIMITS: Limits = Limits { under_pa: mbar(5e-5), over_pa: mbar(1200.0), full_scale_pa: mbar(1000.0) };

static PCG_PIRANI: PartSpec =
    PartSpec { part: PCG_PIRANI_PART, limits: PIRANI_LIMITS, clipping: Clipping::Never, counts: COUNTS };

static PSG_PIRANI: PartSpec =
    PartSpec { part: PSG_PIRANI_PART, limits: PIRANI_LIMITS, clipping: Clipping::Never, counts: COUNTS };

// free choice: nothing says what the atmosphere sensor measures (86); this covers every place people live at.
static ATM: PartSpec = PartSpec {
    part: ATM_PART,
    limits: Limits { under_pa: mbar(300.0), over_pa: mbar(1200.0), full_scale_pa: mbar(1200.0) },
    clipping: Clipping::Never,
    counts: ATM_COUNTS,
};

/// The lowest pressure a gauge of the series measures, in Pa.
pub const LOWEST_PA: f64 = PIRANI_LIMITS.under_pa;

/// 4.3.1, 4.3.3. Code 13 is there for texts (6).
static DIALECT: ChannelRules = ChannelRules {
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

/// Revision of the firmware, of the PROFIBUS adapter and of the gauge: six digits, xxyyzz (59). free choice: the numbers.
pub const FIRMWARE: &str = "010100";
/// Revision of the PROFIBUS adapter's hardware, likewise.
pub const HARDWARE: &str = "010000";

/// I&M0 without what tells one gauge from another (5.1, 110). The revisions are those of the PROFIBUS board.
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

/// What the gauges of a family have in them.
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
    ranges: &'static [&'static PartSpec],
    places: &'static [PlacedBlock],
    faults: FaultList,
}

static PCG_WITH_ATM: Family = Family {
    device_type: "CVG",
    parts: &[CDG_PART, PCG_PIRANI_PART, ATM_PART],
    cdg: Some(&CDG),
    pirani: &PCG_PIRANI,
    atm: Some(&ATM),
    ranges: &[&CDG, &PCG_PIRANI, &ATM],
    places: Parameter::PLACES,
    faults: faults(10),
};

static PCG: Family = Family {
    device_type: "CVG",
    parts: &[CDG_PART, PCG_PIRANI_PART],
    cdg: Some(&CDG),
    pirani: &PCG_PIRANI,
    atm: None,
    ranges: &[&CDG, &PCG_PIRANI],
    places: &PCG_PLACES,
    faults: faults(8),
};

static PSG: Family = Family {
    device_type: "VPG",
    parts: &[PSG_PIRANI_PART],
    cdg: None,
    pirani: &PSG_PIRANI,
    atm: None,
    ranges: &[&PSG_PIRANI],
    places: &PSG_PLACES,
    faults: faults(6),
};

/// Four faults of the device and two for each instance: the first of the list.
const fn faults(count: usize) -> FaultList {
    let (names, _) = Faults::LIST.names.split_at(count);
    let (effects, _) = Faults::LIST.effects.split_at(count);
    FaultList { names, effects }
}

/// One gauge of the series.
#[derive(Debug)]
pub struct Variant {
    /// Its tables.
    pub model: Model,
    /// What is in it.
    pub family: &'static Family,
    /// Manufacturer Model Number: the part number (61).
    pub number: &'static str,
    /// Device Configuration (63).
    pub configuration: &'static str,
}

const fn version(
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
        // free choice: the manual names no default. A float, and nothing that a master must send.
        default_configuration: &CONFIGURATIONS[1],
        units: &UNITS,
        user_prm: &USER_PRM,
        // DPV1_Enable, Fail_Safe, WD_Base_1ms: what the slave supports (39).
        dpv1_status: 0xC4,
        blocks: family.places,
        parts: family.ranges,
        channel_rules: &DIALECT,
        faults: &family.faults,
        errata: "errata-pxg55x-img400 1 to 112",
        gsd: Gsd { revision: 1, hardware: HARDWARE, software: FIRMWARE, max_diag_octets: 6, set_slave_add: true },
    };
    Variant { model, family, number, configuration }
}

/// The whole series, a gauge with an atmosphere sensor before the same without.
///
/// The filament tells the models apart: tungsten, nickel, and ceramic coated, which has no abbreviation in 7.1.9. Connector,
/// relays and analog output are those of the example there, and the part numbers stand for them.
#[rustfmt::skip]
pub static VARIANTS: [Variant; 9] = [
    version(&PCG_WITH_ATM, "pcg550", "PCG550", "3PC1-001-3121", "DS9 SP WO ATM PB CDG AO0 PIR"),
    version(&PCG_WITH_ATM, "pcg552", "PCG552", "3PC2-001-3121", "DS9 SP NI ATM PB CDG AO0 PIR"),
    version(&PCG_WITH_ATM, "pcg554", "PCG554", "3PC3-001-3121", "DS9 SP ATM PB CDG AO0 PIR"),
    version(&PCG,          "pcg550", "PCG550", "3PC1-001-2121", "DS9 SP WO PB CDG AO0 PIR"),
    version(&PCG,          "pcg552", "PCG552", "3PC2-001-2121", "DS9 SP NI PB CDG AO0 PIR"),
    version(&PCG,          "pcg554", "PCG554", "3PC3-001-2121", "DS9 SP PB CDG AO0 PIR"),
    version(&PSG,          "psg550", "PSG550", "3PI1-001-2121", "DS9 SP WO PB AO0 PIR"),
    version(&PSG,          "psg552", "PSG552", "3PI2-001-2121", "DS9 SP NI PB AO0 PIR"),
    version(&PSG,          "psg554", "PSG554", "3PI3-001-2121", "DS9 SP PB AO0 PIR"),
];
