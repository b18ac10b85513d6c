//! The code tables of tira41d1 that no other manual has. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::parts::{ATMOSPHERE, CATHODE, CDG, INSTANCES, PERCENTAGE, PIRANI};
use crate::model::Precondition::{DegasOff, EmissionOn, Executing, PressureAbove, PressureBelow};
use crate::model::code_table::{code_range, codes};
use crate::model::{CodeTable, Codes, Precondition};

code_range! {
    /// Channel Instance Selector: the instance that slot 1 shows. 3.2.1.2.
    pub Selector: u8 = INSTANCES.0, INSTANCES.1
}

codes! {
    /// Setpoint Function: what switches the relay of a set point. 3.2.5.6.
    pub SetpointFunction: Names;
    0 Potentiometer "potentiometer";
    1 Atmosphere    "atmosphere";
}

/// Percentage of atmosphere, in tenths of a percent: 500 is 50 %. 3.2.5.7.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Percentage {}

impl CodeTable for Percentage {
    type Value = u16;

    const CODES: Codes = Codes::PerMille(PERCENTAGE.0 as i64, PERCENTAGE.1 as i64);
}

/// The risk of switching the emission on.
const CATHODE_LIFE: &str = "switches the hot cathode: at a pressure that is too high this costs its life";

/// The conditions of switching the emission on.
const EMISSION_ON: &[Precondition] = &[Executing, PressureBelow(Some(PIRANI.part.instance), CATHODE.on_pa)];

codes! {
    /// Hot Cathode Block State Command: the command in the high octet, its value in the low one. 3.3.3.9.
    pub HotCathodeCommand: Commands;
    0x0000 Inactive      "inactive";
    0x0100 DegasOff      "degas-off";
    0x0101 DegasOn       "degas-on", needs &[Executing, EmissionOn, DegasOff, PressureBelow(None, CATHODE.degas_pa)],
                         risk "heats the electrodes for three minutes: gas is set free, and the pressure rises";
    0x0300 EmissionOff   "emission-off", risk "the ionisation part measures nothing without emission; set points in its range switch";
    0x0301 EmissionOn    "emission-on", needs EMISSION_ON, risk CATHODE_LIFE;
    0x8000 ManualMode    "manual-mode", risk "the gauge no longer switches the emission on by itself";
    0x8001 AutomaticMode "automatic-mode", risk CATHODE_LIFE;
}

codes! {
    /// Emission Status. 3.3.3.5, with the codes of (97). Writing 0 and 1 is the command EmissionOff and EmissionOn of
    /// [`HotCathodeCommand`].
    pub EmissionStatus: Names;
    0 Off             "off", risk "the ionisation part measures nothing without emission; set points in its range switch";
    1 On25Microampere "on-25-microampere", needs EMISSION_ON, risk CATHODE_LIFE;
    2 On5Milliampere  "on-5-milliampere";
    3 Degas           "degas";
}

codes! {
    /// Degas Status. 3.3.3.7 (99).
    pub DegasStatus: Names;
    0 Off "off";
    3 On  "on";
}

codes! {
    /// Atmosphere gauge Block State Command: the command in the high octet, its value in the low one. The gauge refuses it while the
    /// diaphragm reads no ambient pressure (159). 3.3.5.2 (116).
    pub AtmosphereCommand: Commands;
    0x0000 Inactive            "inactive";
    0x8000 AtmosphereAdjust    "atmosphere-adjust",
                               needs &[Executing, PressureAbove(Some(CDG.part.instance), ATMOSPHERE.lowest_pa)],
                               risk "adjusts the ambient pressure sensor: the chamber must be at atmospheric pressure";
    0x8001 AtmosphereAdjustOff "atmosphere-adjust-off", risk "takes back the adjustment of the ambient pressure sensor";
}
