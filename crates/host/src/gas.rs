//! What a sensor that was calibrated for nitrogen makes of another gas.
//!
//! The factors are those of the BCG450 operating manual, page 54: true pressure = factor x indicated pressure, for a Pirani
//! between 1e-2 and 1 mbar and for an ion gauge below 1e-3 mbar.

use profivac_devices::Principle;
use std::fmt;
use std::str::FromStr;

/// A gas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gas {
    /// Nitrogen, what gauges are calibrated for.
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

/// Gas, name, factor of a Pirani, factor of an ion gauge.
///
/// free choice: the manual prints no ion gauge factor for CO2, H2O and Freon 12; these three follow from the relative
/// sensitivities in common use (1.4, 1.1, 2.7). Cold cathodes take the factors of hot ones. All hold at every pressure.
const GASES: [(Gas, &str, f64, f64); 13] = [
    (Gas::N2, "n2", 1.0, 1.0),
    (Gas::Air, "air", 1.0, 1.0),
    (Gas::O2, "o2", 1.0, 1.0),
    (Gas::Co, "co", 1.0, 1.0),
    (Gas::Co2, "co2", 0.9, 0.7),
    (Gas::H2o, "h2o", 0.5, 0.9),
    (Gas::He, "he", 0.8, 5.9),
    (Gas::Ne, "ne", 1.4, 4.1),
    (Gas::Ar, "ar", 1.7, 0.8),
    (Gas::Kr, "kr", 2.4, 0.5),
    (Gas::Xe, "xe", 3.0, 0.4),
    (Gas::H2, "h2", 0.5, 2.4),
    (Gas::Freon12, "freon12", 0.7, 0.37),
];

impl Gas {
    /// What a sensor indicates per true pressure.
    #[must_use]
    pub fn response(self, principle: Principle) -> f64 {
        let (pirani, ion) =
            GASES.into_iter().find(|(gas, ..)| *gas == self).map_or((1.0, 1.0), |(_, _, pirani, ion)| (pirani, ion));
        match principle {
            Principle::Pirani => pirani.recip(),
            Principle::HotCathode | Principle::ColdCathode => ion.recip(),
            Principle::Diaphragm | Principle::Atmosphere => 1.0,
        }
    }
}

/// Not a gas we know.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a gas out of {expected}, got {0:?}", expected = names())]
pub struct UnknownGas(String);

impl FromStr for Gas {
    type Err = UnknownGas;

    fn from_str(text: &str) -> Result<Self, UnknownGas> {
        GASES
            .into_iter()
            .find(|(_, name, ..)| name.eq_ignore_ascii_case(text))
            .map(|(gas, ..)| gas)
            .ok_or_else(|| UnknownGas(text.to_owned()))
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
    fn every_gas_is_in_the_table_under_its_name() {
        for (gas, name, ..) in GASES {
            assert_eq!((gas.to_string().as_str(), name.parse()), (name, Ok(gas)));
        }
        assert_eq!("AR".parse(), Ok(Gas::Ar));
        assert_eq!("steam".parse::<Gas>(), Err(UnknownGas("steam".to_owned())));
    }

    #[test]
    fn helium_reads_too_low_on_an_ion_gauge_and_too_high_on_a_pirani() {
        assert!(Gas::He.response(Principle::HotCathode) < 0.2);
        assert!(Gas::He.response(Principle::Pirani) > 1.2);
        assert!((Gas::He.response(Principle::Diaphragm) - 1.0).abs() < 1e-12);
    }
}
