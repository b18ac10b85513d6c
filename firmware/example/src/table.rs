//! The table of the gauge: what its manual would print.

use profivac_devices::model::{
    AlarmWords, ChannelRules, Clipping, Configuration, Counts, Field, Gsd, INTEGER16_MAX, Limits, Location, Model,
    NumberType, ParameterSet, Part, PartSpec, Principle, Scale, TaskKind, Telegram, Unit, UserPrm, configuration, mbar,
    telegram,
};
use profivac_devices::profile::SafeState;
use profivac_devices::profile::codes::UnitCode;
use profivac_devices::{block, blocks, code_range, codes, faults};
use profivac_dp::slave::Features;

codes! {
    /// The heater of the wire.
    pub Heater: Names;
    0 Off "off";
    1 On  "on";
}

code_range! {
    /// The filter of the reading.
    pub FilterRange: u16 = 0, 1000
}

block! {
    /// Identity.
    pub DeviceBlock in device_block = "Device Block", type 1;
    // ID parameter     name                   data type    access      store  section, code table
    16 BlockType       "Block Type"            OSTRING(4)   [1/2_R]      N  "1";
    17 DeviceType      "Device Type"           VSTRING(8)   [1/2_R]      N  "1";
    23 SerialNumber    "Serial Number"         VSTRING(30)  [1/2_R]      N  "1";
}

block! {
    /// The pressure. Process Value, Reading Valid and other names mean to a client what they mean for every gauge.
    pub Pressure in pressure = "Pressure";
    19 ProcessValue    "Process Value (PV)"    BY_TYPE      [0_XI 1/2_R] D  "2";
    21 DataType        "Data Type"             UINT8        [2_R/W]      N  "2" NumberType;
    22 DataUnits       "Data Units"            UINT16       [2_R/W]      N  "2" UnitCode;
    23 ReadingValid    "Reading Valid"         BOOLEAN      [1/2_R]      D  "2";
    24 FullScale       "Full Scale"            BY_TYPE      [1/2_R]      N  "2";
    39 SafeState       "Safe State"            UINT8        [1/2_R/W]    N  "2" SafeState;
    40 SafeValue       "Safe Value"            BY_TYPE      [1/2_R/W]    N  "2";
    44 Overrange       "Overrange"             BY_TYPE      [1/2_R]      N  "2";
    45 Underrange      "Underrange"            BY_TYPE      [1/2_R]      N  "2";
    60 Heater          "Heater"                UINT8        [1/2_R/W]    N  "3" Heater;
    61 Filter          "Filter (ms)"           UINT16       [1/2_R/W]    N  "3" FilterRange;
}

const DEVICE: Location = Location::slot(0, "device");
const PIRANI: Location = Location::slot(1, "pirani");

blocks! {
    /// Every parameter.
    pub Parameter;
    Device(DeviceBlock) [DEVICE];
    Pressure(Pressure) [PIRANI];
}

faults! {
    /// The active faults.
    pub Faults;
    sensor Sensor1 "the wire is broken";
}

/// COUNTS of the pressure.
pub const COUNTS: Counts = Counts::Log { per_decade: 2000.0, at_1_mbar: 25000.0 };

/// The sensor.
pub static PART: PartSpec = PartSpec {
    part: Part { instance: 1, principle: Principle::Pirani },
    limits: Limits { under_pa: mbar(5e-4), over_pa: mbar(1000.0), full_scale_pa: mbar(1000.0) },
    clipping: Clipping::Never,
    counts: COUNTS,
};

static INPUTS: Telegram = telegram(1, &[Field::ProcessValue(NumberType::Float)]);

// Configuration data that do not fit the telegrams do not compile.
static CONFIGURATIONS: [Configuration; 1] = [configuration(None, Some(&INPUTS), &[0x41, 0x83, 0x08])];

static UNITS: [Unit; 2] = [
    Unit { code: 1308, name: "mbar", alias: "hPa", scale: Scale::MBAR },
    Unit { code: 1309, name: "Pascal", alias: "Pa", scale: Scale::PASCAL },
];

/// The unit as it leaves the factory.
pub const FACTORY_UNIT: &Unit = &UNITS[0];

static USER_PRM: [UserPrm; 2] = [
    UserPrm { name: "mbar", octets: &[0x00, 0x00, 0x00, 0x05, 0x1C] },
    UserPrm { name: "Pascal", octets: &[0x00, 0x00, 0x00, 0x05, 0x1D] },
];

static CHANNEL_RULES: ChannelRules = ChannelRules {
    tasks: &[(1, TaskKind::Read), (2, TaskKind::Write(&[2])), (3, TaskKind::Write(&[4])), (10, TaskKind::Write(&[1]))],
    needs_idle_between: true,
    error_codes: &[],
};

/// The tables of the gauge.
pub static MODEL: Model = Model {
    name: "ex1",
    title: "EX1",
    vendor: "Example",
    manual: "none",
    // PROFIBUS & PROFINET International assigns ident numbers; this one is a placeholder that must not be on a bus of others.
    ident: 0xFFFE,
    features: Features { sync: false, freeze: false, dpv1: true, ms1: true },
    configurations: &CONFIGURATIONS,
    default_configuration: &CONFIGURATIONS[0],
    values: &[],
    units: &UNITS,
    max_integer: INTEGER16_MAX,
    user_prm: &USER_PRM,
    dpv1_status: 0x80,
    blocks: Parameter::BLOCKS,
    parts: &[&PART],
    channel_rules: &CHANNEL_RULES,
    alarms: AlarmWords::NONE,
    faults: &Faults::LIST,
    errata: "",
    gsd: Gsd { revision: 1, hardware: "1.0", software: "1.0", max_diag_octets: 6, set_slave_add: true },
};
