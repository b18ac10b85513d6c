//! Permeation of gas through seals: solution and diffusion (Daynes, Proc. R. Soc. A 97 (1920) 286; Barrer 1939).
//!
//! In the steady state `Q = K A (p_out - p_in) / d`. After a change of the pressure outside, the flow follows with the time lag
//! `d^2 / 6 D`.

use crate::gas::{GAS_COUNT, Gas, Mixture};
use std::f64::consts::PI;

/// A seal between the chamber and the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seal {
    /// The conductance K A / d of each gas, in m³/s.
    conductances: [f64; GAS_COUNT],
}

impl Seal {
    /// A seal of an area in m² and a thickness in m, with the permeability K of some gases in m²/s (Pa m³/s of gas per m of
    /// thickness, m² of area and Pa).
    #[must_use]
    pub fn new(area_m2: f64, thickness_m: f64, permeabilities: &[(Gas, f64)]) -> Self {
        let mut conductances = [0.0; GAS_COUNT];
        for (gas, permeability) in permeabilities {
            if let Some(target) = conductances.get_mut(*gas as usize) {
                *target = permeability * area_m2 / thickness_m;
            }
        }
        Self { conductances }
    }

    /// The conductance of each gas, in m³/s.
    pub(crate) const fn conductances(&self) -> &[f64; GAS_COUNT] {
        &self.conductances
    }

    /// The steady flow from a gas outside into vacuum, gas by gas in Pa m³/s.
    #[must_use]
    pub fn flow(&self, outside: &Mixture) -> Mixture {
        let mut flow = *outside.as_array();
        flow.iter_mut().zip(self.conductances).for_each(|(pa, conductance)| *pa *= conductance);
        flow.into()
    }
}

/// The time lag in s of a seal of a thickness in m, for a diffusion coefficient in m²/s.
#[must_use]
pub fn time_lag_s(thickness_m: f64, diffusion_m2_per_s: f64) -> f64 {
    thickness_m * thickness_m / (6.0 * diffusion_m2_per_s)
}

/// The flow relative to the steady one, after a time as a multiple of the time lag since gas came to the outside.
#[must_use]
pub fn approach(lags: f64) -> f64 {
    if lags <= 0.0 {
        return 0.0;
    }
    // exp(-n^2 pi^2 D t / d^2) with D / d^2 = 1 / (6 lag); the last terms matter at short times only.
    let sum: f64 = (1..=40)
        .map(|n| {
            let n = f64::from(n);
            (PI * n).cos() * (-n * n * PI * PI * lags / 6.0).exp()
        })
        .sum();
    (1.0 + 2.0 * sum).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_steady_flow_is_permeability_times_area_over_thickness() {
        let seal = Seal::new(0.01, 0.005, &[(Gas::He, 1e-11)]);
        let flow = seal.flow(&Mixture::pure(Gas::He, 1e5));
        assert!((flow[Gas::He] / (1e-11 * 0.01 / 0.005 * 1e5) - 1.0).abs() < 1e-12);
        assert_eq!(flow[Gas::N2], 0.0);
    }

    /// The asymptote of the gas that has passed cuts the axis at the time lag.
    #[test]
    fn the_passed_gas_lags_by_d_squared_over_six_d() {
        let passed: f64 = (0..100_000).map(|step| approach((f64::from(step) + 0.5) * 1e-4) * 1e-4).sum();
        assert!((10.0 - passed - 1.0).abs() < 1e-3, "{passed}");
        assert!((time_lag_s(5e-3, 1e-10) - 25e-6 / 6e-10).abs() < 1.0);
        assert!(approach(0.05) < 1e-3 && (approach(10.0) - 1.0).abs() < 1e-4);
    }
}
