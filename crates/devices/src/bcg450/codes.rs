//! Code tables of tira41d1 that are its own. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::table::{CATHODE, INSTANCES, PIRANI};
use crate::model::{Code, Codes, Precondition, code};
use crate::profile::codes::risky;

/// 3.2.1.2
pub const SELECTOR: Codes = Codes::Range(*INSTANCES.start() as i64, *INSTANCES.end() as i64);

/// 3.2.5.6
pub const SETPOINT_FUNCTION: Codes = Codes::Names(&[code(0, "potentiometer"), code(1, "atmosphere")]);

/// 3.2.5.7: tenths of a percent.
pub const PERCENTAGE: Codes = Codes::Range(10, 1400);

const LIFE: &str = "switches the hot cathode: at a pressure that is too high this costs its life";

const EMISSION_ON: Code = Code {
    number: 0x0301,
    name: "emission-on",
    preconditions: &[Precondition::Executing, Precondition::PressureBelow(Some(PIRANI.part.instance), CATHODE.on_pa)],
    risk: LIFE,
};

/// 3.3.3.9
pub const HOT_CATHODE_COMMAND: Codes = Codes::Commands(&[
    code(0x0000, "inactive"),
    code(0x0100, "degas-off"),
    Code {
        number: 0x0101,
        name: "degas-on",
        preconditions: &[
            Precondition::Executing,
            Precondition::EmissionOn,
            Precondition::PressureBelow(None, CATHODE.degas_pa),
        ],
        risk: "heats the electrodes for three minutes: gas is set free, and the pressure rises",
    },
    risky(0x0300, "emission-off", "the ionisation part measures nothing without emission"),
    EMISSION_ON,
    risky(0x8000, "manual-mode", "the gauge no longer switches the emission on by itself"),
    risky(0x8001, "automatic-mode", LIFE),
]);

/// 3.3.3.5, with the codes of (97). Writing 0 and 1 is the command above.
pub const EMISSION_STATUS: Codes = Codes::Names(&[
    risky(0, "off", "the ionisation part measures nothing without emission"),
    Code { number: 1, name: "on-25-microampere", ..EMISSION_ON },
    code(2, "on-5-milliampere"),
    code(3, "degas"),
]);

/// 3.3.3.7 (99)
pub const DEGAS_STATUS: Codes = Codes::Names(&[code(0, "off"), code(3, "on")]);

/// 3.3.5.2 (116)
pub const ATMOSPHERE_COMMAND: Codes = Codes::Commands(&[
    code(0x0000, "inactive"),
    risky(
        0x8000,
        "atmosphere-adjust",
        "adjusts the ambient pressure sensor: the chamber must be at atmospheric pressure",
    ),
    risky(0x8001, "atmosphere-adjust-off", "takes back the adjustment of the ambient pressure sensor"),
]);
