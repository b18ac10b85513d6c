//! Conductance of openings and tubes, from molecular to laminar flow.
//!
//! In molecular flow each gas flows independently, light gases faster: C = A v/4 for an opening and (pi/12) v d^3/l for a
//! tube, with the mean speed v = sqrt(8 R T / pi M). For air at 20 °C these are the 11.6 l/s per cm^2 and the 12.1 d^3/l of
//! the textbooks (general knowledge). Knudsen's factor covers the transition, Poiseuille's law laminar flow, both in the usual form
//! for air: 135 d^4/l p + 12.1 d^3/l (1 + 192 d p)/(1 + 237 d p) in cm, mbar and l/s (general knowledge). The speed of sound
//! limits the flow through an opening to 20 l/s of air per cm^2 (general knowledge).

use crate::atmosphere::ROOM_K;
use crate::gas::{GAS_COUNT, Gas};
use std::f64::consts::PI;

/// The gas constant, in J/(mol K).
pub const R: f64 = 8.314_463;

/// The viscosity of air at 20 °C, in Pa s (general knowledge). Most gases differ by less than a third.
const VISCOSITY: f64 = 1.82e-5;

/// The two coefficients of Knudsen's factor for air, per Pa m (the same numbers per mbar cm).
const KNUDSEN: [f64; 2] = [192.0, 237.0];

/// The highest speed of air through an opening, in m/s: 20 l/s per cm^2.
const CHOKED_M_PER_S: f64 = 200.0;

/// The mean speed of the molecules of a gas at room temperature, in m/s.
#[must_use]
pub fn mean_speed_m_per_s(gas: Gas) -> f64 {
    (8.0 * R * ROOM_K / (PI * gas.molar_mass_kg_per_mol())).sqrt()
}

/// The mean speed of each gas relative to nitrogen: sqrt(28/M), in the order of [`Gas::all`].
pub(crate) fn relative_speeds() -> [f64; GAS_COUNT] {
    let mut relative_speeds = [1.0; GAS_COUNT];
    for (place, gas) in relative_speeds.iter_mut().zip(Gas::all()) {
        *place = (Gas::N2.molar_mass_kg_per_mol() / gas.molar_mass_kg_per_mol()).sqrt();
    }
    relative_speeds
}

/// A conductance: gas flow per pressure difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductance {
    /// Molecular conductance for nitrogen, in m^3/s.
    molecular: f64,
    /// Laminar conductance per pressure, in m^3/s per Pa.
    laminar: f64,
    /// The limit by the speed of sound, in m^3/s.
    choked: f64,
    /// The diameter in m; 0 for a conductance that does not depend on pressure.
    diameter_m: f64,
}

impl Conductance {
    /// A molecular conductance at every pressure, in m^3/s for nitrogen.
    #[must_use]
    pub const fn fixed(m3_per_s: f64) -> Self {
        Self { molecular: m3_per_s, laminar: 0.0, choked: 0.0, diameter_m: 0.0 }
    }

    /// A viscous conductance at every pressure, in m^3/s: the same for all gases, as through a leak.
    #[must_use]
    pub const fn viscous(m3_per_s: f64) -> Self {
        Self { molecular: 0.0, laminar: 0.0, choked: m3_per_s, diameter_m: 0.0 }
    }

    /// A round tube; diameter and length in m. The conductance of its opening is included, which matters for short tubes.
    #[must_use]
    pub fn tube(diameter_m: f64, length_m: f64) -> Self {
        let speed = mean_speed_m_per_s(Gas::N2);
        let area = PI * diameter_m * diameter_m / 4.0;
        let (opening, tube) = (area * speed / 4.0, PI / 12.0 * speed * diameter_m.powi(3) / length_m);
        Self {
            molecular: opening * tube / (opening + tube),
            laminar: PI * diameter_m.powi(4) / (128.0 * VISCOSITY * length_m),
            choked: CHOKED_M_PER_S * area,
            diameter_m,
        }
    }

    /// The molecular conductance for nitrogen, in m^3/s.
    #[must_use]
    pub const fn molecular(&self) -> f64 {
        self.molecular
    }

    /// The conductance at a mean pressure in Pa: the molecular part (for nitrogen) and the viscous part (the same for all
    /// gases), both in m^3/s.
    #[must_use]
    pub fn parts_at(&self, pa: f64) -> (f64, f64) {
        if self.diameter_m == 0.0 {
            return (self.molecular, self.choked);
        }
        let dp = self.diameter_m * pa;
        let laminar = self.laminar * pa;
        let viscous = laminar * self.choked / (laminar + self.choked);
        (self.molecular * (1.0 + KNUDSEN[0] * dp) / (1.0 + KNUDSEN[1] * dp), viscous)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() < relative, "{value} instead of {expected}");
    }

    #[test]
    fn conductances_of_air_match_the_textbook() {
        // 11.6 l/s per cm^2 = 116 m/s; 12.1 d^3/l (cm, l/s) = 121 d^3/l (m, m^3/s).
        near(mean_speed_m_per_s(Gas::Air) / 4.0, 116.0, 0.005);
        near(PI / 12.0 * mean_speed_m_per_s(Gas::Air), 121.0, 0.005);
        // 135 d^4/l p (cm, mbar, l/s) = 1350 d^4/l p (m, Pa, m^3/s).
        near(PI / (128.0 * VISCOSITY), 1350.0, 0.005);
    }

    #[test]
    fn a_long_tube_has_molecular_then_laminar_flow() {
        let tube = Conductance::tube(0.04, 2.0);
        let nitrogen = PI / 12.0 * mean_speed_m_per_s(Gas::N2) * 0.04_f64.powi(3) / 2.0;
        near(tube.molecular(), nitrogen, 0.03);
        let (molecules, viscous) = tube.parts_at(1e-6);
        near(molecules, tube.molecular(), 1e-5);
        assert!(viscous < 1e-6 * molecules);
        // At 10 Pa and a diameter of 4 cm: 1350 d^4/l p = 17 l/s plus 3 l/s of molecular flow, reduced to 192/237.
        let (molecules, viscous) = tube.parts_at(10.0);
        near(viscous, 1350.0 * 0.04_f64.powi(4) / 2.0 * 10.0, 0.1);
        near(molecules / tube.molecular(), 192.0 / 237.0, 0.01);
    }

    #[test]
    fn the_speed_of_sound_limits_the_flow_of_a_tube() {
        let (_, viscous) = Conductance::tube(0.1, 0.1).parts_at(1e5);
        assert!(viscous < 200.0 * PI * 0.05 * 0.05);
        assert!(Conductance::tube(0.1, 1e-6).molecular() < PI * 0.05 * 0.05 * 118.0);
    }

    #[test]
    fn light_gases_are_faster_than_nitrogen() {
        let relative_speeds = relative_speeds();
        near(relative_speeds[Gas::H2 as usize], 3.728, 1e-3);
        near(relative_speeds[Gas::Ar as usize], 0.8374, 1e-3);
        near(relative_speeds[Gas::N2 as usize], 1.0, 1e-12);
    }
}
