//! Code tables of tira56e1 that are its own. Numbers in brackets are those of errata-pxg55x-img400.

use super::heating::PiraniOff;
use super::trip::Mode;
use crate::model::{Codes, code};
use crate::profile::codes::risky;

const ZERO_RISK: &str = "moves the zero: the pressure must be two decades below the range of the gauge";
const ATMOSPHERE: &str = "moves the scale: the chamber must be at atmospheric pressure";

/// 8.1.1; a target value is not used (78).
pub const CDG_ADJUST: Codes = Codes::Commands(&[risky(0x0000, "zero-adjust", ZERO_RISK)]);

/// 8.2.1
pub const PIRANI_ADJUST: Codes =
    Codes::Commands(&[risky(0x0000, "zero-adjust", ZERO_RISK), risky(0x0100, "gain-adjust", ATMOSPHERE)]);

/// 8.3.1
pub const ATM_ADJUST: Codes = Codes::Commands(&[risky(0x0100, "gain-adjust", ATMOSPHERE)]);

/// 11.2.13
pub const SETPOINT_MODE: Codes = Codes::Names(&[
    code(Mode::Setpoint as u16, "setpoint-mode"),
    code(Mode::LowByAtmosphere as u16, "low-trip-point-by-atmosphere"),
    code(Mode::HighByAtmosphere as u16, "high-trip-point-by-atmosphere"),
    code(Mode::BusOnly as u16, "setpoint-mode-profibus-only"),
]);

/// 12.2.5
pub const PIRANI_OFF: Codes = Codes::Names(&[
    code(PiraniOff::AlwaysOn as u16, "always-on"),
    code(PiraniOff::Automatic as u16, "automatic"),
    code(PiraniOff::AlwaysOff as u16, "always-off"),
]);
