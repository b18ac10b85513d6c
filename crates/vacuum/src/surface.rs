//! Outgassing of walls: adsorbed water with readsorption, gas from the bulk, and their temperature.
//!
//! In vacuum the outgassing rate of each gas is `q = A q1 (t / 1 h)^-a`, with a = 1 for adsorbed gas on metal and a = 1/2 for
//! diffusion out of the bulk. t is the age of the wall for this gas. Heat lets the age advance faster, by the Arrhenius factor
//! f = exp(E/R (1/T0 - 1/T)), and multiplies the rate by the same f, so the amount per step of age is the same at every
//! temperature.
//!
//! With a = 1 the age is the coverage: each factor of e is the amount q1 x 1 h per area less (a logarithmic, Temkin-like
//! isotherm, for which Redhead, JVST A 13 (1995) 467, derives the 1/t law). Water from the gas returns to the wall, and the gas
//! loses it:
//!
//! ```text
//! dt_age/dt = f - (t_age / 1 s - 1) p / W        Q_net = A q1 (1 h / t_age) f - A (q1 x 1 h / W) p
//! ```
//!
//! So a sealed chamber approaches the pressure `W f / t_age`, a full wall has an age of one second, and water above its saturation
//! pressure condenses. The supply is finite: adsorbed gas ends at an age of [`EMPTY_S`], gas in the bulk with the diffusion out
//! of a slab (Calder and Lewin, Brit. J. Appl. Phys. 18 (1967) 1459).

use crate::atmosphere::{ROOM_K, WATER_SATURATED_PA};
use crate::conductance::R;
use crate::gas::{GAS_COUNT, Gas, Mixture};

/// The hour in `(t / 1 h)^-a`, in s.
const HOUR_S: f64 = 3600.0;

/// Exposure to water that divides the age of a wall by e, in Pa s.
///
/// chosen: an effective value, a sticking probability of 7e-8 on steel. Steel adsorbs water faster, but only at its
/// mobile sites. With this value a sealed chamber of unbaked steel ends between 1e-4 and 1e-2 mbar, and a second of room air
/// wets a wall again.
pub const WETTING_PA_S: f64 = 1e3;

/// The same for the other adsorbed gases, which come with air and not with the water of a closed chamber. chosen
const AIR_WETTING_PA_S: f64 = 1e5;

/// The lowest age of a wall, in s: the wall is saturated with water.
const FRESH_S: f64 = 1.0;

/// The age at which adsorbed gas ends, in s: 25 factors of e, or about seven monolayers of water on steel. chosen
pub const EMPTY_S: f64 = 7e10;

/// The diffusion coefficient of hydrogen in austenitic steel at a temperature in K, in m²/s (Outlaw and Peterson, Metall.
/// Trans. A 14 (1983) 1869).
#[must_use]
pub fn hydrogen_diffusion_m2_per_s(kelvin: f64) -> f64 {
    7.01e-7 * (-HYDROGEN_J_PER_MOL / (R * kelvin)).exp()
}

/// The activation energy of the diffusion of hydrogen in steel, in J/mol (the same source).
const HYDROGEN_J_PER_MOL: f64 = 48.0e3;

/// The time d^2 / (pi^2 D) in which a slab of 2 mm of steel loses its hydrogen at room temperature, in s.
const SLAB_S: f64 = 2.06e8;

/// The same for a rubber seal: a month. chosen
const SEAL_S: f64 = 2.6e6;

/// How outgassing falls with the age.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// Adsorbed gas: a = 1.
    Coverage,
    /// Gas that diffuses out of the bulk: a = 1/2.
    Diffusion,
}

impl Law {
    /// The exponent a.
    #[must_use]
    pub const fn exponent(self) -> f64 {
        match self {
            Self::Coverage => 1.0,
            Self::Diffusion => 0.5,
        }
    }
}

/// The outgassing of one gas from a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Desorption {
    /// The gas.
    pub gas: Gas,
    /// Outgassing rate per area after one hour at room temperature, in Pa m/s (Pa m³/s per m²).
    pub q1: f64,
    /// The law of the rate.
    pub law: Law,
    /// The activation energy E, in J/mol.
    pub energy: f64,
    /// Whether water vapour restores it. Gas from the bulk of a metal is not restored.
    pub returns: bool,
    /// The age at which the supply ends, in s.
    pub ends_s: f64,
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
    Desorption { gas, q1, law: Law::Coverage, energy, returns: true, ends_s: EMPTY_S }
}

const fn bulk(gas: Gas, q1: f64, energy: f64) -> Desorption {
    Desorption { gas, q1, law: Law::Diffusion, energy, returns: false, ends_s: SLAB_S }
}

const fn rubber(gas: Gas, q1: f64, energy: f64) -> Desorption {
    Desorption { gas, q1, law: Law::Diffusion, energy, returns: true, ends_s: SEAL_S }
}

/// All materials. 1e-9 mbar l/s per cm² is 1e-6 Pa m/s.
///
/// Unbaked steel has 1e-9 to 1e-8 mbar l/s per cm² after an hour, mostly water (general knowledge). Hydrogen: with the
/// diffusion of Outlaw and Peterson, 24 h at 150 °C leave 2e-12 mbar l/s per cm²; 20 h at 100 °C of steel that was baked before
/// leave 1.3e-12 (Messer and Treitz 1977, 1e-12 Torr l/s per cm²). Viton: 1.14e-6 mbar l/s per cm^2 after an hour (table of
/// pspglobal.com, "Outgassing and weight loss of elastomers"). chosen: the fractions of the other gases, 80 kJ/mol for
/// water.
pub const MATERIALS: [Material; 6] = [
    Material {
        name: "steel",
        gases: &[
            wall(Gas::H2o, 3e-6, 80e3),
            wall(Gas::Co, 2e-7, 80e3),
            wall(Gas::Co2, 1e-7, 80e3),
            wall(Gas::N2, 1e-7, 80e3),
            bulk(Gas::H2, 2e-7, HYDROGEN_J_PER_MOL),
        ],
    },
    Material {
        name: "polished-steel",
        gases: &[
            wall(Gas::H2o, 1e-6, 80e3),
            wall(Gas::Co, 5e-8, 80e3),
            wall(Gas::Co2, 2e-8, 80e3),
            bulk(Gas::H2, 1e-7, HYDROGEN_J_PER_MOL),
        ],
    },
    // chosen: the hydrogen of a vacuum firing, a hundredth of that of ordinary steel.
    Material {
        name: "fired-steel",
        gases: &[
            wall(Gas::H2o, 3e-6, 80e3),
            wall(Gas::Co, 2e-7, 80e3),
            wall(Gas::Co2, 1e-7, 80e3),
            bulk(Gas::H2, 2e-9, HYDROGEN_J_PER_MOL),
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
        gases: &[rubber(Gas::H2o, 9.4e-4, 60e3), rubber(Gas::N2, 1e-4, 60e3), rubber(Gas::Co2, 1e-4, 60e3)],
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

/// A change of temperature at a constant rate.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ramp {
    to_k: f64,
    /// The size of the rate, in K/s.
    k_per_s: f64,
}

/// A wall of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Its area, in m².
    pub area_m2: f64,
    /// Its temperature, in K.
    pub temperature_k: f64,
    ramp: Option<Ramp>,
    gases: &'static [Desorption],
    /// The age of the wall for each gas, in s.
    clocks: [f64; MAX_GASES],
}

/// The exchange of a wall with the gas during a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Exchange {
    /// By how much the outgassing at the end of the step differs from its mean, in Pa m³/s.
    pub slack: f64,
    /// The water that returns to the wall, as a conductance in m³/s.
    pub returning: f64,
}

impl Surface {
    /// A freshly vented wall with an area in m², at room temperature. Only the first eight gases of the material count.
    #[must_use]
    pub fn fresh(area: f64, material: &Material) -> Self {
        Self { area_m2: area, temperature_k: ROOM_K, ramp: None, gases: material.gases, clocks: [FRESH_S; MAX_GASES] }
    }

    /// The wall after `seconds` in vacuum at `kelvin`.
    #[must_use]
    pub fn aged(mut self, seconds: f64, kelvin: f64) -> Self {
        for (clock, desorption) in self.clocks.iter_mut().zip(self.gases) {
            *clock += seconds * arrhenius_factor(desorption.energy, kelvin);
        }
        self
    }

    /// Sets the temperature at once, in K.
    pub const fn set_temperature(&mut self, kelvin: f64) {
        self.temperature_k = kelvin;
        self.ramp = None;
    }

    /// Heats or cools the wall to a temperature in K within `seconds`, at a constant rate.
    pub fn heat(&mut self, kelvin: f64, seconds: f64) {
        if seconds > 0.0 {
            self.ramp = Some(Ramp { to_k: kelvin, k_per_s: (kelvin - self.temperature_k).abs() / seconds });
        } else {
            self.set_temperature(kelvin);
        }
    }

    /// The temperature after `seconds`, in K.
    fn temperature_after(&self, seconds: f64) -> f64 {
        self.ramp.map_or(self.temperature_k, |ramp| {
            let change = ramp.k_per_s * seconds;
            self.temperature_k + (ramp.to_k - self.temperature_k).clamp(-change, change)
        })
    }

    /// Adds the mean outgassing of the next `seconds` to `flow`, gas by gas in Pa m³/s, with a partial pressure of water of
    /// `water_pa` in the chamber.
    pub(crate) fn outgas(&self, seconds: f64, water_pa: f64, flow: &mut [f64; GAS_COUNT]) -> Exchange {
        let mut exchange = Exchange::default();
        let (now_k, then_k) = (self.temperature_k, self.temperature_after(seconds));
        for (clock, desorption) in self.clocks.iter().zip(self.gases) {
            let (now, then) = (desorption.factor(now_k), desorption.factor(then_k));
            let factor = f64::midpoint(now, then);
            let end = desorption.aged(*clock, seconds, factor, water_pa);
            let mean = self.area_m2 * desorption.mean_rate(*clock, end) * factor;
            let last = self.area_m2 * desorption.rate(end) * then;
            flow[desorption.gas as usize] += mean;
            exchange.slack += (mean - last).abs();
            if desorption.gas == Gas::H2o && desorption.returns {
                exchange.returning += self.area_m2 * desorption.readsorption(f64::midpoint(*clock, end));
                exchange.returning += mean / WATER_SATURATED_PA;
            }
        }
        exchange
    }

    /// Advances age and temperature by `seconds` in a chamber with a partial pressure of water of `water_pa`.
    pub(crate) fn advance(&mut self, seconds: f64, water_pa: f64) {
        let then_k = self.temperature_after(seconds);
        for (clock, desorption) in self.clocks.iter_mut().zip(self.gases) {
            let factor = f64::midpoint(desorption.factor(self.temperature_k), desorption.factor(then_k));
            *clock = desorption.aged(*clock, seconds, factor, water_pa);
        }
        self.temperature_k = then_k;
        if self.ramp.is_some_and(|ramp| (ramp.to_k - then_k).abs() < 1e-9) {
            self.ramp = None;
        }
    }

    /// The present outgassing, gas by gas in Pa m³/s, without the water that returns.
    #[must_use]
    pub fn flow(&self) -> Mixture {
        let mut flow = Mixture::default();
        for (clock, desorption) in self.clocks.iter().zip(self.gases) {
            flow[desorption.gas] += self.area_m2 * desorption.rate(*clock) * desorption.factor(self.temperature_k);
        }
        flow
    }
}

impl Desorption {
    fn factor(&self, kelvin: f64) -> f64 {
        arrhenius_factor(self.energy, kelvin)
    }

    /// The rate per area at room temperature and an age, in Pa m/s.
    fn rate(&self, clock: f64) -> f64 {
        self.mean_rate(clock, clock)
    }

    /// The mean rate per area at room temperature while the age goes from one value to another, in Pa m/s.
    fn mean_rate(&self, from: f64, to: f64) -> f64 {
        let change = (to - from) / from;
        let ratio = HOUR_S / from;
        let start = match self.law {
            Law::Coverage => ratio,
            Law::Diffusion => ratio.sqrt(),
        };
        let mean = match self.law {
            _ if change.abs() < 1e-6 => 1.0 - self.law.exponent() * change / 2.0,
            Law::Coverage => change.ln_1p() / change,
            // The mean of (1 + x)^-1/2.
            Law::Diffusion => 2.0 / (1.0 + (1.0 + change).sqrt()),
        };
        self.q1 * start * mean * self.supply(f64::midpoint(from, to))
    }

    /// The part of the law that the finite supply leaves at an age.
    fn supply(&self, clock: f64) -> f64 {
        let x = clock / self.ends_s;
        if x < 1e-3 {
            1.0
        } else {
            match self.law {
                Law::Coverage => (-x).exp(),
                Law::Diffusion => slab(x),
            }
        }
    }

    /// The age after `seconds` at a rate of `factor`, with water at `water_pa`: the exact solution for constant values.
    fn aged(&self, clock: f64, seconds: f64, factor: f64, water_pa: f64) -> f64 {
        let wetted = match (self.returns, self.gas) {
            (false, _) => 0.0,
            (true, Gas::H2o) => water_pa * seconds / WETTING_PA_S,
            (true, _) => water_pa * seconds / AIR_WETTING_PA_S,
        };
        let rate = factor - (clock - FRESH_S) * wetted / seconds.max(f64::MIN_POSITIVE);
        let mean = if wetted < 1e-6 { 1.0 - wetted / 2.0 } else { -(-wetted).exp_m1() / wetted };
        (clock + rate * seconds * mean).max(FRESH_S)
    }

    /// The water per area that returns to a wall of this age, per pressure in m/s.
    fn readsorption(&self, clock: f64) -> f64 {
        match self.law {
            Law::Coverage => self.q1 * HOUR_S / WETTING_PA_S * (1.0 - FRESH_S / clock),
            Law::Diffusion => 0.0,
        }
    }
}

/// The diffusion out of a slab relative to that out of an infinite body, at the time x d^2 / (pi^2 D).
fn slab(x: f64) -> f64 {
    let terms: f64 = [1.0, 9.0, 25.0].into_iter().map(|square: f64| (-square * x).exp()).sum();
    if x < 0.2 { 1.0 } else { 4.0 * (x / std::f64::consts::PI).sqrt() * terms }
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
        near(steel().aged(36_000.0, ROOM_K).flow()[Gas::H2], 2e-7 / 10_f64.sqrt(), 1e-3);
    }

    #[test]
    fn the_outgassed_amount_is_the_integral_for_steps_of_any_length() {
        let given = |steps: u32| {
            let (mut wall, mut sum) = (steel(), 0.0);
            for _ in 0..steps {
                let mut flow = [0.0; GAS_COUNT];
                wall.outgas(3600.0 / f64::from(steps), 0.0, &mut flow);
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
        hot.set_temperature(423.15);
        assert!(hot.flow()[Gas::H2o] > 1e4 * before[Gas::H2o]);
        let mut baked = hot.aged(86_400.0, 423.15);
        baked.set_temperature(ROOM_K);
        let after = baked.flow();
        assert!(after[Gas::H2o] < 1e-4 * before[Gas::H2o], "{:e}", after[Gas::H2o]);
        // 2e-12 mbar l/s per cm² is 2e-9 Pa m/s.
        assert!((1.3e-9..2.7e-9).contains(&after[Gas::H2]), "{:e}", after[Gas::H2]);
    }

    #[test]
    fn the_effect_of_a_vent_grows_with_its_length_and_humidity() {
        let vented = |seconds: f64, water_pa: f64| {
            let mut wall = steel().aged(864_000.0, ROOM_K);
            wall.advance(seconds, water_pa);
            wall.flow()[Gas::H2o]
        };
        let dry = vented(0.001, 0.0);
        assert!(vented(600.0, 0.1) < 1.1 * dry, "ten minutes of gas with 0.1 Pa of water");
        assert!(vented(600.0, 1.0) < 2.0 * dry, "ten minutes of dry nitrogen");
        assert!(vented(5.0, 1170.0) > 100.0 * dry, "five seconds of air");
        near(vented(36_000.0, 1170.0), 3e-6 * 3600.0 / (1.0 + WETTING_PA_S / 1170.0), 1e-3);
    }

    #[test]
    fn the_water_that_a_wall_gains_is_the_water_that_the_gas_loses() {
        let mut wall = steel().aged(36_000.0, ROOM_K);
        let (pa, seconds) = (0.3, 10.0);
        let before = wall.clocks[0];
        let mut flow = [0.0; GAS_COUNT];
        let exchange = wall.outgas(seconds, pa, &mut flow);
        wall.advance(seconds, pa);
        let gained = 3e-6 * HOUR_S * (before / wall.clocks[0]).ln();
        let condensed = flow[Gas::H2o as usize] / WATER_SATURATED_PA;
        let lost = ((exchange.returning - condensed) * pa - flow[Gas::H2o as usize]) * seconds;
        near(gained, lost, 2e-3);
    }

    #[test]
    fn a_wall_and_its_vapour_reach_the_pressure_of_their_equilibrium() {
        let wall = steel().aged(36_000.0, ROOM_K);
        let net = |pa: f64| {
            let mut flow = [0.0; GAS_COUNT];
            let exchange = wall.outgas(1e-3, pa, &mut flow);
            flow[Gas::H2o as usize] - exchange.returning * pa
        };
        let equilibrium = WETTING_PA_S / 36_000.0;
        assert!(net(0.99 * equilibrium) > 0.0 && net(1.01 * equilibrium) < 0.0);
    }

    #[test]
    fn a_slab_of_steel_loses_its_hydrogen() {
        near(SLAB_S, 4e-6 / (std::f64::consts::PI.powi(2) * hydrogen_diffusion_m2_per_s(ROOM_K)), 0.01);
        // The sum over odd n of exp(-n^2 x), relative to sqrt(pi / x) / 4.
        near(slab(0.2), 1.0, 2e-3);
        near(slab(2.0), 0.432, 5e-3);
        let emptied = steel().aged(1e9, ROOM_K).flow()[Gas::H2];
        assert!(emptied < 0.05 * 2e-7 * (3600.0_f64 / 1e9).sqrt(), "{emptied:e}");
    }

    #[test]
    fn a_wall_is_heated_at_a_constant_rate_in_steps_of_any_length() {
        let heated = |steps: u32| {
            let mut wall = steel().aged(3600.0, ROOM_K);
            wall.heat(ROOM_K + 100.0, 1000.0);
            let mut sum = 0.0;
            for _ in 0..steps {
                let seconds = 500.0 / f64::from(steps);
                let mut flow = [0.0; GAS_COUNT];
                wall.outgas(seconds, 0.0, &mut flow);
                wall.advance(seconds, 0.0);
                sum += flow[Gas::H2 as usize] * seconds;
            }
            near(wall.temperature_k, ROOM_K + 50.0, 1e-9);
            wall.advance(5000.0, 0.0);
            near(wall.temperature_k, ROOM_K + 100.0, 1e-9);
            sum
        };
        near(heated(100), heated(10_000), 5e-3);
    }

    #[test]
    fn venting_does_not_restore_gas_from_the_bulk() {
        let mut wall = steel().aged(864_000.0, 423.15);
        let before = wall.flow()[Gas::H2];
        wall.advance(3600.0, 1170.0);
        assert!(wall.flow()[Gas::H2] <= before);
    }
}
