//! Walls that give off gas, and remember when they were last vented and baked.
//!
//! In vacuum a wall gives off `q = A q1 (t / 1 h)^-a` of each gas: a is 1 for water on metal, 1/2 for what diffuses out of the
//! bulk (field 5.3, general knowledge). The time t of this law is the wall's own: heat lets it run faster, by Arrhenius'
//! factor f = exp(E/R (1/T0 - 1/T)), and multiplies the flow by the same f, for what leaves in the own time dt is the same at every
//! temperature. A day at 150 degrees is so 70 years at room temperature. Water from outside turns the clock back by an e-th
//! for every [`WETTING_PA_S`] of exposure: with a = 1 the water on the wall counts as the logarithm of t, so each e-th is the same
//! amount taken up. Hence a short vent with dry nitrogen costs little and a minute in humid air nearly everything.

use crate::atmosphere::ROOM_K;
use crate::conductance::R;
use crate::gas::{GAS_COUNT, Gas, Mixture};

/// The hour of `(t / 1 h)^-a`.
const HOUR_S: f64 = 3600.0;

/// Exposure to water after which the clock of a wall shows an e-th, in Pa s. free choice: ten seconds in the air of a room.
pub const WETTING_PA_S: f64 = 1e4;

/// The wall was never wetter than after this time by its clock, in s.
const FRESH_S: f64 = 1.0;

/// One gas that a material gives off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Desorption {
    /// The gas.
    pub gas: Gas,
    /// What a square metre gives off after an hour at room temperature, in Pa m^3/s per m^2, which is Pa m/s.
    pub q1: f64,
    /// The exponent a; 0 is permeation, which never ends.
    pub exponent: f64,
    /// The energy E that sets it free, in J/mol.
    pub energy: f64,
    /// A vent brings it back; not what comes out of the bulk.
    pub returns: bool,
}

/// What a wall is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in scenarios.
    pub name: &'static str,
    /// What it gives off.
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

/// The materials there are. 1e-9 mbar l/s per cm^2 is 1e-6 Pa m/s.
///
/// Unbaked steel 1e-9 to 1e-8 mbar l/s per cm^2 after an hour, mostly water; elastomers a hundred times that with a = 1/2 (field
/// 5.3, general knowledge). free choice: the small parts beside water, 80 kJ/mol for water and 50 kJ/mol for hydrogen, which make
/// a day at 150 degrees leave hydrogen of 1e-13 mbar l/s per cm^2, as baked steel has (general knowledge).
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
    /// The material of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        MATERIALS.iter().find(|material| material.name == name)
    }
}

/// So many gases of a material have a clock of their own.
const MAX_GASES: usize = 8;

/// A wall of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Its area, in m^2.
    pub area_m2: f64,
    /// Its temperature, in K.
    pub temperature_k: f64,
    gases: &'static [Desorption],
    /// What the clock of each gas shows, in s.
    clocks: [f64; MAX_GASES],
}

impl Surface {
    /// A wall that was wet just now, at room temperature; of more than eight gases the first.
    #[must_use]
    pub fn fresh(area: f64, material: &Material) -> Self {
        Self { area_m2: area, temperature_k: ROOM_K, gases: material.gases, clocks: [FRESH_S; MAX_GASES] }
    }

    /// The same after so many seconds in vacuum at so many kelvin.
    #[must_use]
    pub fn aged(mut self, seconds: f64, kelvin: f64) -> Self {
        for (clock, desorption) in self.clocks.iter_mut().zip(self.gases) {
            *clock += seconds * arrhenius_factor(desorption.energy, kelvin);
        }
        self
    }

    /// Adds what the wall gives off in the next seconds, averaged over them, to `flow`, gas by gas in Pa m^3/s. Returns by how
    /// much it will be less at their end, in all.
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

    /// Time passes in a chamber with this partial pressure of water.
    pub(crate) fn advance(&mut self, seconds: f64, water_pa: f64) {
        let wetted = (-water_pa * seconds / WETTING_PA_S).exp();
        for (clock, desorption) in self.clocks.iter_mut().zip(self.gases) {
            *clock += seconds * arrhenius_factor(desorption.energy, self.temperature_k);
            if desorption.returns {
                *clock = (*clock * wetted).max(FRESH_S);
            }
        }
    }

    /// What it gives off now, in Pa m^3/s.
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
    /// What a square metre gives off from `clock` on for so many seconds of its own time, in Pa m: the integral of the law.
    fn outgassed(&self, clock: f64, own: f64) -> f64 {
        let from = clock / HOUR_S;
        let ratio = (own / clock).ln_1p();
        let rest = 1.0 - self.exponent;
        let powers = if rest == 0.0 { ratio } else { from.powf(rest) * (rest * ratio).exp_m1() / rest };
        self.q1 * HOUR_S * powers
    }
}

/// How much faster a wall lives at `kelvin` than at room temperature.
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
    fn after_an_hour_it_is_q1_and_after_ten_a_tenth() {
        near(steel().aged(3600.0, ROOM_K).flow()[Gas::H2o], 3e-6, 1e-3);
        near(steel().aged(36_000.0, ROOM_K).flow()[Gas::H2o], 3e-7, 1e-3);
        near(steel().aged(36_000.0, ROOM_K).flow()[Gas::H2], 2e-8 / 10_f64.sqrt(), 1e-3);
    }

    #[test]
    fn what_is_given_off_is_the_integral_in_steps_of_any_length() {
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
    fn a_hot_wall_gives_off_more_and_afterwards_less() {
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
    fn a_vent_costs_by_its_length_and_its_humidity() {
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
    fn what_comes_out_of_the_bulk_does_not_come_back() {
        let mut wall = steel().aged(864_000.0, 423.15);
        let before = wall.flow()[Gas::H2];
        wall.advance(3600.0, 1170.0);
        assert!(wall.flow()[Gas::H2] <= before);
    }
}
