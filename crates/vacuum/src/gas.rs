//! Gases and mixtures, with the correction factors of gauges calibrated for nitrogen.
//!
//! The factors are those of the BCG450 operating manual, page 54: true pressure = factor x indicated pressure, for a Pirani
//! between 1e-2 and 1 mbar and for an ion gauge below 1e-3 mbar. Molar masses are those of the periodic table (general
//! knowledge). Viscosities are those of the CRC Handbook of Chemistry and Physics, Huber and Harvey, "Viscosity of gases", at
//! 300 K, reduced by 1.6 % to 20 °C; that of Freon 12 and the ratios of specific heats are general knowledge.

use std::fmt;
use std::ops::{Index, IndexMut};
use std::str::FromStr;

/// The number of gases.
pub const GAS_COUNT: usize = 13;

/// A gas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gas {
    /// Nitrogen, the calibration gas of gauges.
    #[default]
    N2,
    /// Air.
    Air,
    /// Oxygen.
    O2,
    /// Carbon monoxide.
    Co,
    /// Carbon dioxide.
    Co2,
    /// Water vapour.
    H2o,
    /// Helium.
    He,
    /// Neon.
    Ne,
    /// Argon.
    Ar,
    /// Krypton.
    Kr,
    /// Xenon.
    Xe,
    /// Hydrogen.
    H2,
    /// Freon 12.
    Freon12,
}

/// Gas, name, factor of a Pirani, factor of an ion gauge, molar mass in kg/mol.
///
/// chosen: the manual prints no ion gauge factor for CO2, H2O and Freon 12; these three follow from the relative
/// sensitivities in common use (1.4, 1.1, 2.7). Cold cathodes have the factors of hot cathodes, at every pressure. The factors
/// of a Pirani apply to molecular heat transfer; above 1 mbar [`Pirani`](crate::sensor::Principle::Pirani) uses thermal
/// conductivity.
const GASES: [(Gas, &str, f64, f64, f64); GAS_COUNT] = [
    (Gas::N2, "n2", 1.0, 1.0, 28.0134e-3),
    (Gas::Air, "air", 1.0, 1.0, 28.965e-3),
    (Gas::O2, "o2", 1.0, 1.0, 31.998e-3),
    (Gas::Co, "co", 1.0, 1.0, 28.010e-3),
    (Gas::Co2, "co2", 0.9, 0.7, 44.009e-3),
    (Gas::H2o, "h2o", 0.5, 0.9, 18.015e-3),
    (Gas::He, "he", 0.8, 5.9, 4.0026e-3),
    (Gas::Ne, "ne", 1.4, 4.1, 20.180e-3),
    (Gas::Ar, "ar", 1.7, 0.8, 39.948e-3),
    (Gas::Kr, "kr", 2.4, 0.5, 83.798e-3),
    (Gas::Xe, "xe", 3.0, 0.4, 131.29e-3),
    (Gas::H2, "h2", 0.5, 2.4, 2.016e-3),
    (Gas::Freon12, "freon12", 0.7, 0.37, 120.91e-3),
];

/// The English names of the gases, which are accepted for their formulas.
const WORDS: [(&str, Gas); 13] = [
    ("nitrogen", Gas::N2),
    ("oxygen", Gas::O2),
    ("carbon monoxide", Gas::Co),
    ("carbon dioxide", Gas::Co2),
    ("water", Gas::H2o),
    ("water vapour", Gas::H2o),
    ("helium", Gas::He),
    ("neon", Gas::Ne),
    ("argon", Gas::Ar),
    ("krypton", Gas::Kr),
    ("xenon", Gas::Xe),
    ("hydrogen", Gas::H2),
    ("freon 12", Gas::Freon12),
];

/// The viscosity at 20 °C in Pa s, and the ratio of specific heats, in the order of [`Gas::all`].
const FLUIDS: [(f64, f64); GAS_COUNT] = [
    (17.6e-6, 1.40),
    (18.2e-6, 1.40),
    (20.3e-6, 1.40),
    (17.5e-6, 1.40),
    (14.7e-6, 1.29),
    (9.6e-6, 1.33),
    (19.6e-6, 1.667),
    (31.4e-6, 1.667),
    (22.3e-6, 1.667),
    (25.0e-6, 1.667),
    (22.8e-6, 1.667),
    (8.8e-6, 1.41),
    (12.4e-6, 1.13),
];

impl Gas {
    /// All gases, in the order of [`Mixture`].
    pub fn all() -> impl Iterator<Item = Self> {
        GASES.into_iter().map(|(gas, ..)| gas)
    }

    /// The English name.
    #[must_use]
    pub fn word(self) -> &'static str {
        WORDS.into_iter().find(|(_, gas)| *gas == self).map_or("air", |(word, _)| word)
    }

    /// True pressure divided by the indication of a Pirani, between 1 and 100 Pa.
    #[must_use]
    pub fn pirani_factor(self) -> f64 {
        self.factors().0
    }

    /// True pressure divided by the indication of an ion gauge, below 0.1 Pa.
    #[must_use]
    pub fn ion_factor(self) -> f64 {
        self.factors().1
    }

    fn factors(self) -> (f64, f64) {
        let (_, _, pirani, ion, _) = GASES[self as usize];
        (pirani, ion)
    }

    /// Molar mass, in kg/mol.
    #[must_use]
    pub const fn molar_mass_kg_per_mol(self) -> f64 {
        GASES[self as usize].4
    }

    /// Viscosity at 20 °C, in Pa s.
    #[must_use]
    pub const fn viscosity_pa_s(self) -> f64 {
        FLUIDS[self as usize].0
    }

    /// Ratio of the specific heats at constant pressure and constant volume.
    #[must_use]
    pub const fn heat_ratio(self) -> f64 {
        FLUIDS[self as usize].1
    }
}

/// Partial pressures by gas, in Pa.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mixture([f64; GAS_COUNT]);

impl Mixture {
    /// A single gas.
    #[must_use]
    pub fn pure(gas: Gas, pa: f64) -> Self {
        let mut mixture = Self::default();
        mixture[gas] = pa;
        mixture
    }

    /// The sum of all partial pressures, in Pa.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.0.iter().sum()
    }

    /// The same gases at `factor` times the pressure.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self(self.0.map(|pa| pa * factor))
    }

    /// The partial pressures in the order of [`Gas::all`], in Pa.
    pub(crate) const fn as_array(&self) -> &[f64; GAS_COUNT] {
        &self.0
    }

    /// All gases with their partial pressures in Pa, including those of 0 Pa.
    pub fn iter(&self) -> impl Iterator<Item = (Gas, f64)> {
        Gas::all().zip(self.0)
    }
}

impl From<[f64; GAS_COUNT]> for Mixture {
    /// Partial pressures in the order of [`Gas::all`], in Pa.
    fn from(pa: [f64; GAS_COUNT]) -> Self {
        Self(pa)
    }
}

impl Index<Gas> for Mixture {
    type Output = f64;

    fn index(&self, gas: Gas) -> &f64 {
        &self.0[gas as usize]
    }
}

impl IndexMut<Gas> for Mixture {
    fn index_mut(&mut self, gas: Gas) -> &mut f64 {
        &mut self.0[gas as usize]
    }
}

/// The error of an unknown gas name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a gas, one of {expected}, got {0:?}", expected = names())]
pub struct UnknownGas(String);

impl FromStr for Gas {
    type Err = UnknownGas;

    fn from_str(text: &str) -> Result<Self, UnknownGas> {
        let named = GASES.into_iter().find(|(_, name, ..)| name.eq_ignore_ascii_case(text)).map(|(gas, ..)| gas);
        let words = || WORDS.into_iter().find(|(word, _)| word.eq_ignore_ascii_case(text)).map(|(_, gas)| gas);
        named.or_else(words).ok_or_else(|| UnknownGas(text.to_owned()))
    }
}

impl fmt::Display for Gas {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = GASES.into_iter().find(|(gas, ..)| gas == self).map_or("", |(_, name, ..)| name);
        f.write_str(name)
    }
}

fn names() -> String {
    GASES.map(|(_, name, ..)| name).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gas_is_found_by_its_english_name() {
        for (word, gas) in [("Argon", Gas::Ar), ("nitrogen", Gas::N2), ("water vapour", Gas::H2o), ("AIR", Gas::Air)] {
            assert_eq!(word.parse(), Ok(gas));
        }
        assert!("argonne".parse::<Gas>().is_err());
        assert!(Gas::all().all(|gas| gas.word().parse() == Ok(gas)));
    }

    #[test]
    fn every_gas_is_found_by_its_name() {
        for (gas, name, ..) in GASES {
            assert_eq!((gas.to_string().as_str(), name.parse()), (name, Ok(gas)));
        }
        assert_eq!("AR".parse(), Ok(Gas::Ar));
        assert_eq!("steam".parse::<Gas>(), Err(UnknownGas("steam".to_owned())));
    }

    #[test]
    fn the_table_is_in_the_order_of_the_gases() {
        for (position, gas) in Gas::all().enumerate() {
            assert_eq!(gas as usize, position, "{gas}");
        }
    }

    #[test]
    fn the_total_of_a_mixture_is_the_sum_of_its_gases() {
        let mut mixture = Mixture::pure(Gas::N2, 78.0);
        mixture[Gas::O2] += 21.0;
        assert!((mixture.total() - 99.0).abs() < 1e-9);
        assert_eq!(mixture.iter().filter(|(_, pa)| *pa > 0.0).count(), 2);
    }
}
