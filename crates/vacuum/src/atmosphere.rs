//! The air around a plant, which enters through leaks and vents.

use crate::gas::{Gas, Mixture};

/// The temperature of the gas everywhere, in K: 20 degrees Celsius.
pub const ROOM_K: f64 = 293.15;

/// The standard pressure at sea level, in Pa.
pub const STANDARD_PA: f64 = 101_325.0;

/// The vapour pressure of water at [`ROOM_K`], in Pa (general knowledge: steam tables).
pub const WATER_SATURATED_PA: f64 = 2_339.0;

/// Dry air by volume fractions (general knowledge: the standard atmosphere, CO2 of 2020).
const DRY_AIR: [(Gas, f64); 9] = [
    (Gas::N2, 0.780_83),
    (Gas::O2, 0.209_45),
    (Gas::Ar, 0.009_34),
    (Gas::Co2, 0.000_415),
    (Gas::Ne, 18.2e-6),
    (Gas::He, 5.24e-6),
    (Gas::Kr, 1.14e-6),
    (Gas::H2, 0.55e-6),
    (Gas::Xe, 0.087e-6),
];

/// Humid air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Atmosphere {
    /// Total pressure, in Pa.
    pub pressure_pa: f64,
    /// Relative humidity, 0 to 1.
    pub humidity: f64,
}

impl Default for Atmosphere {
    /// Standard pressure and a relative humidity of 0.5.
    fn default() -> Self {
        Self { pressure_pa: STANDARD_PA, humidity: 0.5 }
    }
}

impl Atmosphere {
    /// The partial pressures of its gases, because light gases flow faster than heavy ones.
    #[must_use]
    pub fn mixture(&self) -> Mixture {
        let water = (self.humidity * WATER_SATURATED_PA).min(self.pressure_pa);
        let parts: f64 = DRY_AIR.into_iter().map(|(_, part)| part).sum();
        let mut mixture = Mixture::default();
        for (gas, part) in DRY_AIR {
            mixture[gas] = (self.pressure_pa - water) * part / parts;
        }
        mixture[Gas::H2o] = water;
        mixture
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn air_is_the_sum_of_its_gases() {
        let air = Atmosphere::default().mixture();
        assert!((air.total() - STANDARD_PA).abs() < 1e-6);
        assert!((air[Gas::H2o] - 1169.5).abs() < 0.1);
        // Argon is just under one per cent of it.
        assert!((air[Gas::Ar] / (STANDARD_PA - 1169.5) - 0.00934).abs() < 1e-5);
        assert_eq!(air[Gas::Air], 0.0);
    }

    #[test]
    fn dry_air_has_no_water_and_the_water_never_exceeds_the_pressure() {
        assert_eq!(Atmosphere { humidity: 0.0, ..Atmosphere::default() }.mixture()[Gas::H2o], 0.0);
        let thin = Atmosphere { pressure_pa: 100.0, humidity: 1.0 }.mixture();
        assert_eq!((thin[Gas::H2o], thin.total()), (100.0, 100.0));
    }
}
