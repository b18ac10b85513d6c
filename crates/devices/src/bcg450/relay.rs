//! The two relays. tira41d1 3.2.5, errata-bpg-bcg-tpg 106 to 114.

use crate::model::{Refusal, mbar};

/// The range of Percentage of atmosphere, in tenths of a percent.
const PERCENTAGE: core::ops::RangeInclusive<u16> = 10..=1400;

/// 5 %, as printed (113).
const FACTORY_PERCENTAGE: u16 = 50;

/// 10 % of the threshold (108).
const HYSTERESIS: f64 = 0.1;

/// A relay with its potentiometer.
#[derive(Clone, Debug)]
pub struct Relay {
    /// The voltage of the potentiometer.
    volts: f64,
    /// Setpoint Function: atmosphere control instead of the potentiometer.
    atmosphere: bool,
    /// Percentage of atmosphere, times ten.
    percentage: u16,
    closed: bool,
}

impl Default for Relay {
    /// free choice: the manual does not say where a potentiometer stands; at 0 V the relay never closes. The function is
    /// that of the potentiometer (111).
    fn default() -> Self {
        Self { volts: 0.0, atmosphere: false, percentage: FACTORY_PERCENTAGE, closed: false }
    }
}

impl Relay {
    /// The same relay when power returns: the potentiometer stays where it is.
    pub fn restarted(&self) -> Self {
        Self { volts: self.volts, ..Self::default() }
    }

    /// The contacts fall back.
    pub const fn open(&mut self) {
        self.closed = false;
    }

    pub const fn is_closed(&self) -> bool {
        self.closed
    }

    /// Somebody turns the potentiometer; it has no more than 0 to 10 V.
    pub const fn turn(&mut self, volts: f64) {
        self.volts = volts.clamp(0.0, 10.0);
    }

    /// What the potentiometer is set to, in Pa: 3.2.5.1.
    pub fn threshold_pa(&self) -> f64 {
        mbar(libm::exp10(1.23011 * self.volts - 9.301_029_99))
    }

    /// Setpoint Function.
    pub const fn function(&self) -> bool {
        self.atmosphere
    }

    /// The contacts fall back before another function begins.
    pub const fn set_function(&mut self, atmosphere: bool) {
        if self.atmosphere != atmosphere {
            self.closed = false;
        }
        self.atmosphere = atmosphere;
    }

    pub const fn percentage(&self) -> u16 {
        self.percentage
    }

    pub fn set_percentage(&mut self, percentage: u16) -> Result<(), Refusal> {
        self.percentage = Some(percentage).filter(|it| PERCENTAGE.contains(it)).ok_or(Refusal::Range)?;
        Ok(())
    }

    /// Status: closed shows in both low exceptions (106).
    pub const fn status(&self) -> u8 {
        if self.closed { 0x0A } else { 0 }
    }

    /// "Atmospheric pressure reached" (114).
    pub const fn atmosphere_reached(&self) -> bool {
        self.atmosphere && self.closed
    }

    /// The relay follows the pressure while it is allowed to be closed at all (112).
    pub fn follow(&mut self, allowed: bool, pa: f64, atmosphere_pa: f64) {
        let (closes, stays) = if self.atmosphere {
            let threshold_pa = atmosphere_pa * f64::from(self.percentage) / 1000.0;
            (pa >= threshold_pa, pa >= threshold_pa * (1.0 - HYSTERESIS))
        } else {
            let threshold_pa = self.threshold_pa();
            (pa < threshold_pa, pa <= threshold_pa * (1.0 + HYSTERESIS))
        };
        self.closed = allowed && (closes || self.closed && stays);
    }
}
