//! The two relays, each with two functions. tira41d1 3.2.5.6 to 3.2.5.8, errata-bpg-bcg-tpg 110 to 114.

use super::parts::{GAUGE, PERCENTAGE, POTENTIOMETER};
use crate::model::AccessError;
use crate::profile::{HYSTERESIS, RelaySetPoint};

/// 5 %, as printed (113).
const FACTORY_PERCENTAGE: u16 = 50;

/// A relay of the BCG450-SP.
#[derive(Clone, Debug)]
pub struct Relay {
    /// Potentiometer and contacts.
    pub point: RelaySetPoint,
    /// Setpoint Function: atmosphere control instead of the potentiometer.
    atmosphere: bool,
    /// Percentage of atmosphere, times ten.
    percentage: u16,
}

impl Relay {
    /// A relay as from the factory, with the function of the potentiometer (111).
    pub const fn new() -> Self {
        Self { point: RelaySetPoint::new(&POTENTIOMETER), atmosphere: false, percentage: FACTORY_PERCENTAGE }
    }

    /// The same relay after power-up.
    pub const fn restarted(&self) -> Self {
        Self { point: self.point.restarted(), ..Self::new() }
    }

    /// Setpoint Function.
    pub const fn function(&self) -> bool {
        self.atmosphere
    }

    /// Sets Setpoint Function. The contacts open before another function begins.
    pub const fn set_function(&mut self, atmosphere: bool) {
        if self.atmosphere != atmosphere {
            self.point.open();
        }
        self.atmosphere = atmosphere;
    }

    /// Percentage of atmosphere.
    pub const fn percentage(&self) -> u16 {
        self.percentage
    }

    /// Sets Percentage of atmosphere.
    pub fn set_percentage(&mut self, percentage: u16) -> Result<(), AccessError> {
        let (lowest, highest) = PERCENTAGE;
        self.percentage =
            Some(percentage).filter(|tenths| (lowest..=highest).contains(tenths)).ok_or(AccessError::OutOfRange)?;
        Ok(())
    }

    /// "Atmospheric pressure reached" (114).
    pub const fn atmosphere_reached(&self) -> bool {
        self.atmosphere && self.point.is_closed()
    }

    /// Switches the relay after a change of pressure; opens it if it is not `allowed` to be closed (112).
    pub fn follow(&mut self, allowed: bool, pa: f64, atmosphere_pa: f64) {
        if self.atmosphere {
            let threshold_pa = atmosphere_pa * f64::from(self.percentage) / 1000.0;
            // "The relay is never activated" at or beyond the end of the range: 3.2.5.1, (113).
            let allowed = allowed && threshold_pa < GAUGE.over_pa;
            self.point.switch(allowed, pa >= threshold_pa, pa >= threshold_pa * (1.0 - HYSTERESIS));
        } else {
            self.point.follow(allowed, pa);
        }
    }
}
