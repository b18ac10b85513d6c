//! The code tables of tira56e1 that no other manual has. Numbers in brackets are those of errata-pxg55x-img400.

use super::parts::{ATM, CDG, CDG_ZERO_PA, LARGEST_PIRANI_ZERO_PA, LOWEST_AIR_PA, PCG_PIRANI};
use crate::model::Precondition::{Executing, PressureAbove, PressureBelow};
use crate::model::code_table::codes;
use crate::model::{CodeTable, Codes, Quantity};

const ZERO_RISK: &str = "moves the zero: the pressure must be two decades below the range of the gauge";
const SCALE_RISK: &str = "moves the scale: the chamber must be at atmospheric pressure";

codes! {
    /// AIBlockAdjust Command of the diaphragm: the command in the high octet; a target value is not used (78). The Pirani tells whether
    /// the diaphragm is in vacuum. 8.1.1.
    pub CdgAdjust: Commands;
    0x0000 ZeroAdjust "zero-adjust", needs &[Executing, PressureBelow(Some(PCG_PIRANI.part.instance), CDG_ZERO_PA)],
                      risk ZERO_RISK;
}

codes! {
    /// AIBlockAdjust Command of the Pirani: the command in the high octet. 8.2.1.
    pub PiraniAdjust: Commands;
    0x0000 ZeroAdjust "zero-adjust", needs &[Executing, PressureBelow(None, LARGEST_PIRANI_ZERO_PA)], risk ZERO_RISK;
    0x0100 GainAdjust "gain-adjust", needs &[Executing, PressureAbove(None, LOWEST_AIR_PA)], risk SCALE_RISK;
}

codes! {
    /// AIBlockAdjust Command of the atmosphere sensor, which is adjusted to the diaphragm. 8.3.1.
    pub AtmAdjust: Commands;
    0x0100 GainAdjust "gain-adjust", needs &[Executing, PressureAbove(Some(CDG.part.instance), ATM.limits.under_pa)],
                      risk SCALE_RISK;
}

codes! {
    /// Setpoint Mode: where the points of a trip point come from. 11.2.13; the manual has no number 3 (100).
    pub SetpointMode: Names;
    0 Setpoint         "setpoint-mode";
    1 LowByAtmosphere  "low-trip-point-by-atmosphere";
    2 HighByAtmosphere "high-trip-point-by-atmosphere";
    4 BusOnly          "setpoint-mode-profibus-only";
}

codes! {
    /// Pirani OFF: when the filament of the Pirani is not heated. 12.2.5.
    pub PiraniOff: Names;
    0 AlwaysOn  "always-on";
    1 Automatic "automatic";
    2 AlwaysOff "always-off";
}

/// Run hours, in steps of an hour. 7.1.14.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hours {}

impl CodeTable for Hours {
    type Value = u16;

    const CODES: Codes = Codes::Quantity(Quantity { unit: "h", factor: 1.0, range: None });
}

/// Run hours (*4), in steps of a quarter of an hour, which a typed value counts (76). 7.1.23.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuarterHours {}

impl CodeTable for QuarterHours {
    type Value = u32;

    const CODES: Codes = Codes::Quantity(Quantity { unit: "h", factor: 0.25, range: None });
}
