//! How much gas an opening or a tube lets pass, from single molecules to a wind.
//!
//! Molecules that never meet pass by themselves, light ones faster: C = A v/4 for an opening and (pi/12) v d^3/l for a tube,
//! with the mean speed v = sqrt(8 R T / pi M). For air at 20 degrees these are the 11.6 l/s per cm^2 and the 12.1 d^3/l of the
//! textbooks (field 5.3). Between, Knudsen's factor, and above it the laminar flow of Poiseuille; both in the usual form for
//! air, 135 d^4/l p + 12.1 d^3/l (1 + 192 d p)/(1 + 237 d p) in cm, mbar and l/s (general knowledge). No gas passes faster than
//! sound: an opening takes in at most 20 l/s of air per cm^2 (general knowledge).

use crate::atmosphere::ROOM_K;
use crate::gas::{GAS_COUNT, Gas};
use std::f64::consts::PI;

/// The gas constant, in J/(mol K).
pub const R: f64 = 8.314_463;

/// The viscosity of air at 20 degrees, in Pa s (general knowledge). Most gases are within a third of it.
const VISCOSITY: f64 = 1.82e-5;

/// Knudsen's two numbers for air, per Pa m (the same number per mbar cm).
const KNUDSEN: [f64; 2] = [192.0, 237.0];

/// The highest speed of air through an opening, in m/s: 20 l/s per cm^2.
const CHOKED_M_PER_S: f64 = 200.0;

/// The mean speed of the molecules of a gas at room temperature, in m/s.
#[must_use]
pub fn mean_speed_m_per_s(gas: Gas) -> f64 {
    (8.0 * R * ROOM_K / (PI * gas.molar_mass_kg_per_mol())).sqrt()
}

/// How much faster each gas is than nitrogen: sqrt(28/M), in the order of [`Gas::all`].
pub(crate) fn relative_speeds() -> [f64; GAS_COUNT] {
    let mut quickness = [1.0; GAS_COUNT];
    for (place, gas) in quickness.iter_mut().zip(Gas::all()) {
        *place = (Gas::N2.molar_mass_kg_per_mol() / gas.molar_mass_kg_per_mol()).sqrt();
    }
    quickness
}

/// A conductance: what flows is it times the difference of the pressures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductance {
    /// For nitrogen molecule by molecule, in m^3/s.
    molecular: f64,
    /// What the laminar flow adds, in m^3/s per Pa.
    laminar: f64,
    /// What it cannot exceed, in m^3/s.
    choked: f64,
    /// The diameter, in m, 0 if pressure does not matter.
    diameter: f64,
}

impl Conductance {
    /// One that is the same at every pressure, in m^3/s of nitrogen.
    #[must_use]
    pub const fn fixed(m3_per_s: f64) -> Self {
        Self { molecular: m3_per_s, laminar: 0.0, choked: 0.0, diameter: 0.0 }
    }

    /// A wind at every pressure, in m^3/s: all gases pass alike, as through a leak.
    #[must_use]
    pub const fn wind(m3_per_s: f64) -> Self {
        Self { molecular: 0.0, laminar: 0.0, choked: m3_per_s, diameter: 0.0 }
    }

    /// A round tube, in m. A short one is also an opening that has to be found.
    #[must_use]
    pub fn tube(diameter: f64, length: f64) -> Self {
        let speed = mean_speed_m_per_s(Gas::N2);
        let area = PI * diameter * diameter / 4.0;
        let (opening, tube) = (area * speed / 4.0, PI / 12.0 * speed * diameter.powi(3) / length);
        Self {
            molecular: opening * tube / (opening + tube),
            laminar: PI * diameter.powi(4) / (128.0 * VISCOSITY * length),
            choked: CHOKED_M_PER_S * area,
            diameter,
        }
    }

    /// Of nitrogen molecule by molecule, in m^3/s.
    #[must_use]
    pub const fn molecular(&self) -> f64 {
        self.molecular
    }

    /// At a mean pressure in Pa: the part that depends on the molecules (for nitrogen), and the wind that takes all gases
    /// along alike, both in m^3/s.
    #[must_use]
    pub fn parts_at(&self, pa: f64) -> (f64, f64) {
        if self.diameter == 0.0 {
            return (self.molecular, self.choked);
        }
        let dp = self.diameter * pa;
        let laminar = self.laminar * pa;
        let wind = laminar * self.choked / (laminar + self.choked);
        (self.molecular * (1.0 + KNUDSEN[0] * dp) / (1.0 + KNUDSEN[1] * dp), wind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() < relative, "{value} instead of {expected}");
    }

    #[test]
    fn the_textbook_numbers_for_air_come_out() {
        // 11.6 l/s per cm^2 = 116 m/s; 12.1 d^3/l (cm, l/s) = 121 d^3/l (m, m^3/s).
        near(mean_speed_m_per_s(Gas::Air) / 4.0, 116.0, 0.005);
        near(PI / 12.0 * mean_speed_m_per_s(Gas::Air), 121.0, 0.005);
        // 135 d^4/l p (cm, mbar, l/s) = 1350 d^4/l p (m, Pa, m^3/s).
        near(PI / (128.0 * VISCOSITY), 1350.0, 0.005);
    }

    #[test]
    fn a_long_tube_carries_molecules_then_a_wind() {
        let tube = Conductance::tube(0.04, 2.0);
        let nitrogen = PI / 12.0 * mean_speed_m_per_s(Gas::N2) * 0.04_f64.powi(3) / 2.0;
        near(tube.molecular(), nitrogen, 0.03);
        let (molecules, wind) = tube.parts_at(1e-6);
        near(molecules, tube.molecular(), 1e-5);
        assert!(wind < 1e-6 * molecules);
        // At 10 Pa in 4 cm of width: 1350 d^4/l p = 17 l/s above 3 l/s of molecules that are slowed to 192/237.
        let (molecules, wind) = tube.parts_at(10.0);
        near(wind, 1350.0 * 0.04_f64.powi(4) / 2.0 * 10.0, 0.1);
        near(molecules / tube.molecular(), 192.0 / 237.0, 0.01);
    }

    #[test]
    fn no_tube_passes_more_than_its_opening_at_the_speed_of_sound() {
        let (_, wind) = Conductance::tube(0.1, 0.1).parts_at(1e5);
        assert!(wind < 200.0 * PI * 0.05 * 0.05);
        assert!(Conductance::tube(0.1, 1e-6).molecular() < PI * 0.05 * 0.05 * 118.0);
    }

    #[test]
    fn light_gases_are_quick() {
        let quickness = relative_speeds();
        near(quickness[Gas::H2 as usize], 3.728, 1e-3);
        near(quickness[Gas::Ar as usize], 0.8374, 1e-3);
        near(quickness[Gas::N2 as usize], 1.0, 1e-12);
    }
}
