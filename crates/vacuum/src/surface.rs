//! Outgassing of walls, depending on their history of venting and baking.
//!
//! In vacuum the outgassing rate of each gas is `q = A q1 (t / 1 h)^-a`, with a = 1 for water on metal and a = 1/2 for
//! diffusion out of the bulk (general knowledge). t is the age of the wall for this gas. Heat lets the age advance
//! faster, by the Arrhenius factor f = exp(E/R (1/T0 - 1/T)), and multiplies the rate by the same f, so the amount per step of
//! age is the same at every temperature. A day at 150 °C corresponds to 70 years at room temperature. Exposure to water
//! divides the age by e for each [`WETTING_PA_S`]: with a = 1 the water on the wall depends on the logarithm of t, so each
//! factor of e is the same amount of adsorbed water. A short vent with dry nitrogen therefore has little effect, a minute in
//! humid air nearly resets the wall.

use crate::atmosphere::ROOM_K;
use crate::conductance::R;
use crate::gas::{GAS_COUNT, Gas, Mixture};

/// The hour in `(t / 1 h)^-a`, in s.
const HOUR_S: f64 = 3600.0;

/// Exposure to water that divides the age of a wall by e, in Pa s. free choice: ten seconds in room air.
pub const WETTING_PA_S: f64 = 1e4;

/// The lowest age of a wall, in s: the wall is saturated with water.
const FRESH_S: f64 = 1.0;

/// The outgassing of one gas from a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Desorption {
    /// The gas.
    pub gas: Gas,
    /// Outgassing rate per area after one hour at room temperature, in Pa m/s (Pa m^3/s per m^2).
    pub q1: f64,
    /// The exponent a; 0 is permeation, which does not decrease.
    pub exponent: f64,
    /// The activation energy E, in J/mol.
    pub energy: f64,
    /// Whether venting restores it. Gas from the bulk is not restored.
    pub returns: bool,
}

/// The material of a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in scenarios.
    pub name: &'static str,
    /// Its outgassing, gas by gas.
    pub gases: &'static [Desorption],
}

const fn wall(gas: Gas, q1: f64, energy: f64) -> Desorption {
    Desorption { gas, q1, exponent: 1.0, energy, returns: true }
}

const fn bulk(gas: Gas, q1: f64, energy: f64) -> Desorption {
    Desorption { gas, q1, exponent: 0.5, energy, returns: false }
}

const fn rubber(gas: Gas, q1: f64, energy: f64) -> Desorption {
    Desorption { gas, q1, exponent: 0.5, energy, returns: true }
}

/// All materials. 1e-9 mbar l/s per cm^2 is 1e-6 Pa m/s.
///
/// Unbaked steel has 1e-9 to 1e-8 mbar l/s per cm^2 after an hour, mostly water; elastomers a hundred times that with a = 1/2
/// (general knowledge). free choice: the fractions of the other gases, 80 kJ/mol for water, 50 kJ/mol for hydrogen.
/// With these, a day at 150 °C leaves 1e-13 mbar l/s per cm^2 of hydrogen, the value of baked steel (general knowledge).
pub const MATERIALS: [Material; 5] = [
    Material {
        name: "steel",
        gases: &[
            wall(Gas::H2o, 3e-6, 80e3),
            wall(Gas::Co, 2e-7, 80e3),
            wall(Gas::Co2, 1e-7, 80e3),
            wall(Gas::N2, 1e-7, 80e3),
            bulk(Gas::H2, 2e-8, 50e3),
        ],
    },
    Material {
        name: "polished-steel",
        gases: &[
            wall(Gas::H2o, 1e-6, 80e3),
            wall(Gas::Co, 5e-8, 80e3),
            wall(Gas::Co2, 2e-8, 80e3),
            bulk(Gas::H2, 1e-8, 50e3),
        ],
    },
    Material {
        name: "aluminium",
        gases: &[
            wall(Gas::H2o, 6e-6, 80e3),
            wall(Gas::Co, 3e-7, 80e3),
            wall(Gas::Co2, 2e-7, 80e3),
            bulk(Gas::H2, 2e-9, 50e3),
        ],
    },
    Material { name: "glass", gases: &[wall(Gas::H2o, 1e-6, 80e3), wall(Gas::Co2, 5e-8, 80e3)] },
    Material {
        name: "viton",
        gases: &[rubber(Gas::H2o, 1e-4, 60e3), rubber(Gas::N2, 1e-5, 60e3), rubber(Gas::Co2, 1e-5, 60e3)],
    },
];

impl Material {
    /// The material with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        MATERIALS.iter().find(|material| material.name == name)
    }
}

/// The most gases of a material.
const MAX_GASES: usize = 8;

/// A wall of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Its area, in m^2.
    pub area_m2: f64,
    /// Its temperature, in K.
    pub temperature_k: f64,
    gases: &'static [Desorption],
    /// The age of the wall for each gas, in s.
    clocks: [f64; MAX_GASES],
}

impl Surface {
    /// A freshly vented wall with an area in m^2, at room temperature. Only the first eight gases of the material count.
    #[must_use]
    pub fn fresh(area: f64, material: &Material) -> Self {
        Self { area_m2: area, temperature_k: ROOM_K, gases: material.gases, clocks: [FRESH_S; MAX_GASES] }
    }

    /// The wall after `seconds` in vacuum at `kelvin`.
    #[must_use]
    pub fn aged(mut self, seconds: f64, kelvin: f64) -> Self {
        for (clock, desorption) in self.clocks.iter_mut().zip(self.gases) {
            *clock += seconds * arrhenius_factor(desorption.energy, kelvin);
        }
        self
    }

    /// Adds the mean outgassing of the next `seconds` to `flow`, gas by gas in Pa m^3/s. Returns by how much the total rate
    /// falls below the mean until their end, in Pa m^3/s.
    pub(crate) fn outgas(&self, seconds: f64, flow: &mut [f64; GAS_COUNT]) -> f64 {
        let mut less = 0.0;
        for (clock, desorption) in self.clocks.iter().zip(self.gases) {
            let own = seconds * arrhenius_factor(desorption.energy, self.temperature_k);
            let mean = self.area_m2 * desorption.outgassed(*clock, own) / seconds;
            flow[desorption.gas as usize] += mean;
            less += mean * desorption.exponent * own / (2.0 * (clock + own));
        }
        less
    }

    /// Advances the age by `seconds` in a chamber with a partial pressure of water of `water_pa`.
    pub(crate) fn advance(&mut self, seconds: f64, water_pa: f64) {
        let wetted = (-water_pa * seconds / WETTING_PA_S).exp();
        for (clock, desorption) in self.clocks.iter_mut().zip(self.gases) {
            *clock += seconds * arrhenius_factor(desorption.energy, self.temperature_k);
            if desorption.returns {
                *clock = (*clock * wetted).max(FRESH_S);
            }
        }
    }

    /// The present outgassing, gas by gas in Pa m^3/s.
    #[must_use]
    pub fn flow(&self) -> Mixture {
        let mut flow = Mixture::default();
        for (clock, desorption) in self.clocks.iter().zip(self.gases) {
            let now = desorption.q1 * (HOUR_S / clock).powf(desorption.exponent);
            flow[desorption.gas] += self.area_m2 * now * arrhenius_factor(desorption.energy, self.temperature_k);
        }
        flow
    }
}

impl Desorption {
    /// The outgassed amount per area from the age `clock` on during `own` seconds of age, in Pa m: the integral of the law.
    fn outgassed(&self, clock: f64, own: f64) -> f64 {
        let from = clock / HOUR_S;
        let ratio = (own / clock).ln_1p();
        let rest = 1.0 - self.exponent;
        let powers = if rest == 0.0 { ratio } else { from.powf(rest) * (rest * ratio).exp_m1() / rest };
        self.q1 * HOUR_S * powers
    }
}

/// The Arrhenius factor at `kelvin` relative to room temperature.
fn arrhenius_factor(energy: f64, kelvin: f64) -> f64 {
    if kelvin == ROOM_K { 1.0 } else { (energy / R * (ROOM_K.recip() - kelvin.recip())).exp() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steel() -> Surface {
        Surface::fresh(1.0, Material::named("steel").unwrap())
    }

    fn near(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() < relative, "{value} instead of {expected}");
    }

    #[test]
    fn the_rate_is_q1_after_an_hour_and_a_tenth_after_ten() {
        near(steel().aged(3600.0, ROOM_K).flow()[Gas::H2o], 3e-6, 1e-3);
        near(steel().aged(36_000.0, ROOM_K).flow()[Gas::H2o], 3e-7, 1e-3);
        near(steel().aged(36_000.0, ROOM_K).flow()[Gas::H2], 2e-8 / 10_f64.sqrt(), 1e-3);
    }

    #[test]
    fn the_outgassed_amount_is_the_integral_for_steps_of_any_length() {
        let given = |steps: u32| {
            let (mut wall, mut sum) = (steel(), 0.0);
            for _ in 0..steps {
                let mut flow = [0.0; GAS_COUNT];
                wall.outgas(3600.0 / f64::from(steps), &mut flow);
                wall.advance(3600.0 / f64::from(steps), 0.0);
                sum += flow[Gas::H2o as usize] * 3600.0 / f64::from(steps);
            }
            sum
        };
        near(given(1), 3e-6 * 3600.0 * 3601_f64.ln(), 1e-9);
        near(given(1000), given(1), 1e-9);
    }

    #[test]
    fn baking_raises_outgassing_and_lowers_it_afterwards() {
        let mut hot = steel().aged(36_000.0, ROOM_K);
        let before = hot.flow();
        hot.temperature_k = 423.15;
        assert!(hot.flow()[Gas::H2o] > 1e4 * before[Gas::H2o]);
        let mut baked = hot.aged(86_400.0, 423.15);
        baked.temperature_k = ROOM_K;
        let after = baked.flow();
        assert!(after[Gas::H2o] < 1e-4 * before[Gas::H2o], "{:e}", after[Gas::H2o]);
        // 1e-13 mbar l/s per cm^2 is 1e-10 Pa m/s.
        assert!((0.5e-10..3e-10).contains(&after[Gas::H2]), "{:e}", after[Gas::H2]);
    }

    #[test]
    fn the_effect_of_a_vent_grows_with_its_length_and_humidity() {
        let vented = |seconds: f64, water_pa: f64| {
            let mut wall = steel().aged(864_000.0, ROOM_K);
            wall.advance(seconds, water_pa);
            wall.flow()[Gas::H2o]
        };
        let dry = vented(0.001, 0.0);
        assert!(vented(600.0, 1.0) < 1.1 * dry, "ten minutes of dry nitrogen");
        assert!(vented(5.0, 1170.0) < 2.0 * dry, "five seconds of air");
        assert!(vented(60.0, 1170.0) > 300.0 * dry, "a minute of air");
        near(vented(36_000.0, 1170.0), 3e-6 * 3600.0, 1e-9);
    }

    #[test]
    fn venting_does_not_restore_gas_from_the_bulk() {
        let mut wall = steel().aged(864_000.0, 423.15);
        let before = wall.flow()[Gas::H2];
        wall.advance(3600.0, 1170.0);
        assert!(wall.flow()[Gas::H2] <= before);
    }
}
