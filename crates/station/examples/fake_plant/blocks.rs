//! Blocks of a gauge, as a reading returns them.

use profivac_station::view::{Block, Parameter};

/// Target, name, numbers, access, value or refusal.
type Row = (&'static str, &'static str, &'static str, &'static str, Result<&'static str, &'static str>);

const PHYSICAL: &[Row] = &[
    ("physical/device-type", "Device Type", "slot 0 index 20", "R", Ok("\"VG\"")),
    ("physical/serial-number", "Serial Number", "slot 0 index 26", "R", Ok("\"103842\"")),
    ("physical/status", "Exception Status", "slot 0 index 29", "R", Ok("0x00, nothing")),
    ("physical/device-state", "Device State", "slot 0 index 27", "R", Ok("4, executing")),
    ("physical/selftest", "Device Selftest", "slot 0 index 36", "W", Err("it is only written")),
];

const INPUT: &[Row] = &[
    ("analog-input/process-value", "Process Value", "slot 1 index 19", "R", Ok("3.21e-5 Pa")),
    ("analog-input/data-units", "Data Units", "slot 1 index 22", "R/W", Ok("1309, Pa")),
    ("analog-input/status", "Status", "slot 1 index 20", "R", Ok("0x00, valid")),
    ("analog-input/safe-state", "Safe State", "slot 1 index 24", "R/W", Ok("0, zero")),
    ("analog-input/safe-value", "Safe Value", "slot 1 index 25", "R/W", Ok("0 Pa")),
];

const TRIP: &[Row] = &[
    ("trip-point.1/high-trip-point", "High Trip Point", "slot 1 index 61", "R/W", Ok("1.00e-2 Pa")),
    ("trip-point.1/high-trip-enable", "High Trip Enable", "slot 1 index 62", "R/W", Ok("yes")),
    ("trip-point.1/hysteresis", "Hysteresis", "slot 1 index 67", "R/W", Ok("1.00e-3 Pa")),
    ("trip-point.1/status", "Status", "slot 1 index 65", "R", Ok("0x01, above")),
];

const HOT: &[Row] = &[
    ("hot-cathode/emission-status", "Emission Status", "slot 1 index 110", "R", Ok("5 mA")),
    ("hot-cathode/filament", "Active Filament", "slot 1 index 112", "R", Ok("1")),
    ("hot-cathode/degas", "Degas", "slot 1 index 115", "R/W", Ok("off")),
    (
        "hot-cathode/degas-time",
        "Degas Time",
        "slot 1 index 116",
        "R/W",
        Err("the device refuses: state conflict (0xB5)"),
    ),
];

/// Blocks with their parameters.
pub fn all() -> Vec<Block> {
    [
        ("Physical Block (slot 0)", PHYSICAL),
        ("Analog Input Function Block (slot 1)", INPUT),
        ("Trip Point Function Block 1 (slot 1)", TRIP),
        ("Hot Cathode Transducer Block (slot 1)", HOT),
    ]
    .map(|(name, rows)| Block { name: name.to_owned(), parameters: rows.iter().map(parameter).collect() })
    .into()
}

fn parameter((target, name, numbers, access, read): &Row) -> Parameter {
    Parameter {
        target: (*target).to_owned(),
        name: (*name).to_owned(),
        numbers: (*numbers).to_owned(),
        access: (*access).to_owned(),
        value: read.ok().map(str::to_owned),
        read_error: read.err().map(str::to_owned),
        write: None,
    }
}
