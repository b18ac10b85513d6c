//! The cyclic data of the BCG450-SP. tira41d1 1.4, 1.5 and 2.3, corrected by errata-bpg-bcg-tpg 2, 5, 59 and 60.
//!
//! A second copy, independent of the tables of the device: a test with expectations from the tables would accept
//! every mistake in them.

use crate::common::octets;
use crate::peers::ADDRESS;
use crate::peers::slave::Slave;

/// Ident number.
const IDENT: u16 = 0x08E6;

/// A configuration string and the numbers of octets that it exchanges.
pub struct Cfg {
    /// The octets of Chk_Cfg.
    pub octets: &'static str,
    /// Master to slave.
    pub outputs: usize,
    /// Slave to master.
    pub inputs: usize,
}

const fn cfg(octets: &'static str, outputs: usize, inputs: usize) -> Cfg {
    Cfg { octets, outputs, inputs }
}

/// All of them, integer and float by turns.
pub static CONFIGURATIONS: [Cfg; 8] = [
    cfg("44 84 05 05 05 03", 0, 5),
    cfg("44 86 05 05 05 08", 0, 7),
    cfg("C6 81 84 05 05 05 05 05 03", 2, 5),
    cfg("C6 81 86 05 05 05 05 05 08", 2, 7),
    cfg("C6 87 8C 0A 0A 05 05 05 03", 8, 13),
    cfg("C6 87 8E 0A 0A 05 05 05 08", 8, 15),
    cfg("C8 89 8C 0A 05 05 0A 05 05 05 03", 10, 13),
    cfg("C8 89 8E 0A 05 05 0A 05 05 05 08", 10, 15),
];

/// A unit, the user parameters that choose it, and the value of a pressure in it.
pub struct UnitString {
    /// The unit.
    pub name: &'static str,
    /// User_Prm_Data.
    pub octets: &'static str,
    value: fn(f64) -> f64,
}

/// All of them.
pub static UNITS: [UnitString; 5] = [
    UnitString { name: "COUNTS", octets: "00 00 00 03 E9", value: |mbar| 2000.0 * (mbar.log10() + 12.5) },
    UnitString { name: "Torr", octets: "00 00 00 05 15", value: |mbar| 0.750_061_68 * mbar },
    UnitString { name: "Micron", octets: "00 00 00 05 16", value: |mbar| 750.061_68 * mbar },
    UnitString { name: "mbar", octets: "00 00 00 05 1C", value: |mbar| mbar },
    UnitString { name: "Pascal", octets: "00 00 00 05 1D", value: |mbar| 100.0 * mbar },
];

/// One pressure for each of the three sensors, in mbar.
pub const PRESSURES: [f64; 3] = [5e-6, 0.7, 820.0];

/// The gauge with this configuration and unit.
pub fn slave(cfg: &Cfg, unit: &UnitString) -> Slave {
    Slave {
        address: ADDRESS,
        ident: IDENT,
        cfg: octets(cfg.octets),
        user_prm: octets(unit.octets),
        outputs: cfg.outputs,
        inputs: cfg.inputs,
    }
}

/// Whether inputs of a configuration show a pressure: an integer truncated and limited by errata-bpg-bcg-tpg 69 and 70, a
/// float to its precision.
pub fn shows(cfg: &Cfg, unit: &UnitString, inputs: &[u8], mbar: f64) -> bool {
    let value = (unit.value)(mbar);
    let is_float = cfg.octets.ends_with("08");
    let (_, process) = inputs.split_at(inputs.len() - if is_float { 4 } else { 2 });
    match *process {
        [high, low] => i16::from_be_bytes([high, low]) == value.min(32767.0) as i16,
        [a, b, c, d] => (f64::from(f32::from_be_bytes([a, b, c, d])) / value - 1.0).abs() < f64::from(f32::EPSILON),
        _ => false,
    }
}
