//! The two relays, each with two functions. tira41d1 3.2.5.6 to 3.2.5.8, errata-bpg-bcg-tpg 110 to 114.

use super::table::POTENTIOMETER;
use crate::model::AccessError;
use crate::profile::{HYSTERESIS, SetPoint};

/// The range of Percentage of atmosphere, in tenths of a percent.
const PERCENTAGE: core::ops::RangeInclusive<u16> = 10..=1400;

/// 5 %, as printed (113).
const FACTORY_PERCENTAGE: u16 = 50;

/// A relay of the BCG450-SP.
#[derive(Clone, Debug)]
pub struct Relay {
    /// Potentiometer and contacts.
    pub point: SetPoint,
    /// Setpoint Function: atmosphere control instead of the potentiometer.
    atmosphere: bool,
    /// Percentage of atmosphere, times ten.
    percentage: u16,
}

impl Relay {
    /// The function is that of the potentiometer (111).
    pub const fn new() -> Self {
        Self { point: SetPoint::new(&POTENTIOMETER), atmosphere: false, percentage: FACTORY_PERCENTAGE }
    }

    /// The same when power returns.
    pub const fn restarted(&self) -> Self {
        Self { point: self.point.restarted(), ..Self::new() }
    }

    pub const fn function(&self) -> bool {
        self.atmosphere
    }

    /// The contacts fall back before another function begins.
    pub const fn set_function(&mut self, atmosphere: bool) {
        if self.atmosphere != atmosphere {
            self.point.open();
        }
        self.atmosphere = atmosphere;
    }

    pub const fn percentage(&self) -> u16 {
        self.percentage
    }

    pub fn set_percentage(&mut self, percentage: u16) -> Result<(), AccessError> {
        self.percentage = Some(percentage).filter(|it| PERCENTAGE.contains(it)).ok_or(AccessError::OutOfRange)?;
        Ok(())
    }

    /// "Atmospheric pressure reached" (114).
    pub const fn atmosphere_reached(&self) -> bool {
        self.atmosphere && self.point.is_closed()
    }

    /// The relay follows the pressure while it is allowed to be closed at all (112).
    pub fn follow(&mut self, allowed: bool, pa: f64, atmosphere_pa: f64) {
        if self.atmosphere {
            let threshold_pa = atmosphere_pa * f64::from(self.percentage) / 1000.0;
            self.point.switch(allowed, pa >= threshold_pa, pa >= threshold_pa * (1.0 - HYSTERESIS));
        } else {
            self.point.follow(allowed, pa);
        }
    }
}
