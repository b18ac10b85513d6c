//! The code tables of tira36e1 that no other manual has. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::parts::{BPG_SWITCHOVER, INSTANCES, LOWEST_AIR_PA, PIRANI};
use crate::model::Precondition::{DegasOff, EmissionOn, Executing, PressureAbove, PressureBelow};
use crate::model::code_table::{code_range, codes};

codes! {
    /// The command "for adjusting the gauge at atmospheric pressure". 3.2.1.1.
    pub AdjustCommand: Commands;
    0 Inactive        "inactive";
    1 FullScaleAdjust "full-scale-adjust",
                      needs &[Executing, PressureAbove(Some(PIRANI.instance), LOWEST_AIR_PA)],
                      risk "adjusts the Pirani: the chamber must be at atmospheric pressure";
}

code_range! {
    /// Channel Instance Selector: the instance that slot 1 shows. 3.2.1.3.
    pub Selector: u8 = INSTANCES.0, INSTANCES.1
}

codes! {
    /// Emission Status: writing 0 switches off, 1 switches on. 3.3.3.5, with the codes of (97).
    pub EmissionStatus: Names;
    0 Off    "off", risk "the ionisation part measures nothing without emission; set points in its range switch";
    1 On     "on", needs &[Executing],
             risk "switches the hot cathode: at a pressure that is too high this costs its life";
    2 OnHigh "on-high";
    3 Degas  "degas";
}

codes! {
    /// Hot Cathode Block State Command: the command in the high octet, its value in the low one. 3.3.3.8.
    pub HotCathodeCommand: Commands;
    0x0000 Inactive "inactive";
    0x0100 DegasOff "degas-off";
    0x0101 DegasOn  "degas-on",
                    needs &[Executing, EmissionOn, DegasOff, PressureBelow(None, BPG_SWITCHOVER.emission.degas_pa)],
                    risk "heats the electrodes for three minutes: gas is set free, and the pressure rises";
}

codes! {
    /// Degas Status. 3.3.3.7 (99).
    pub DegasStatus: Names;
    0 Off "off";
    3 On  "on";
}
