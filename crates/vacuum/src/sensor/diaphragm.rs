//! Capacitance diaphragm: the gas bends a membrane. Linear and independent of the gas.

use super::imperfections::Tolerance;
use super::{Environment, Range};

/// A capacitance diaphragm.
#[derive(Clone, Debug)]
pub struct Diaphragm {
    range: Range,
    /// The temperature of a heated head, in K. According to their manuals no gauge of this project heats its head; without
    /// heating there is no transpiration.
    pub head_k: Option<f64>,
}

/// The diameter of the tube to the head, in m.
const TUBE_M: f64 = 4e-3;

impl Diaphragm {
    pub const fn new(range: Range) -> Self {
        Self { range, head_k: None }
    }

    /// The pressure in the head, in Pa.
    pub fn signal(&self, environment: &Environment) -> f64 {
        let pa = environment.gas.total();
        self.head_k.map_or(pa, |head_k| pa * transpiration(pa, head_k, environment.temperature_k))
    }

    /// General knowledge: noise 3e-5 of full scale, zero 5e-5 of full scale per K, gain 0.2 %. chosen: a
    /// zero error of 1e-4 of full scale as delivered.
    pub const fn tolerance(&self) -> Tolerance {
        let full_scale_pa = self.range.highest_pa;
        Tolerance {
            gain: 2e-3,
            zero_pa: 1e-4 * full_scale_pa,
            zero_pa_per_k: 5e-5 * full_scale_pa,
            noise: 0.0,
            floor_pa: 3e-5 * full_scale_pa,
            drift_pa: 3e-5 * full_scale_pa,
            lag_s: 0.03,
        }
    }
}

/// Thermal transpiration: the pressure in a head at `head_k` divided by the pressure `pa` in a chamber at `chamber_k`.
///
/// Takaishi and Sensui, Trans. Faraday Soc. 59 (1963) 2503, with their constants of nitrogen for every gas: according to
/// Daudé, Elandaloussi and Janssen (arXiv:1308.6794) viscosity and molecular speed determine the effect, and the published
/// constants of other gases are unreliable. The result is 1 at high pressure and the root of the temperature ratio in
/// molecular flow.
fn transpiration(pa: f64, head_k: f64, chamber_k: f64) -> f64 {
    const A: f64 = 1.2e6;
    const B: f64 = 1.0e3;
    const C: f64 = 14.0;
    const PA_PER_TORR: f64 = 133.322;
    // In Torr mm / K, with the pressure of the chamber, which differs from that of the head by less than a tenth.
    let x = pa / PA_PER_TORR * (TUBE_M * 1e3) * 2.0 / (head_k + chamber_k);
    let dense = A * x * x + B * x + C * x.sqrt();
    (dense + 1.0) / (dense + (chamber_k / head_k).sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::REFERENCE_K;
    use super::*;
    use crate::gas::{Gas, Mixture};

    const RANGE: Range = Range { lowest_pa: 10.0, highest_pa: 1e5 };

    fn environment(gas: Gas, pa: f64) -> Environment {
        Environment { gas: Mixture::pure(gas, pa), atmosphere_pa: 1e5, temperature_k: REFERENCE_K }
    }

    #[test]
    fn every_gas_gives_the_same_indication() {
        for gas in Gas::all() {
            for pa in [1e-3, 1.0, 1e5] {
                assert_eq!(Diaphragm::new(RANGE).signal(&environment(gas, pa)), pa, "{gas}");
            }
        }
    }

    #[test]
    fn a_heated_head_indicates_too_high_in_molecular_flow() {
        let heated = Diaphragm { head_k: Some(318.15), ..Diaphragm::new(RANGE) };
        let ratio = |pa: f64| heated.signal(&environment(Gas::N2, pa)) / pa;
        assert!((ratio(1e-4) / (318.15f64 / REFERENCE_K).sqrt() - 1.0).abs() < 5e-3, "{}", ratio(1e-4));
        assert!(ratio(1.0) < ratio(1e-2) && ratio(1.0) > 1.005, "{}", ratio(1.0));
        assert!((ratio(1000.0) - 1.0).abs() < 1e-3, "{}", ratio(1000.0));
    }

    /// arXiv:1308.6794: the effect is halved at 2 x viscosity x mean speed / diameter.
    #[test]
    fn transpiration_is_halved_at_the_pressure_given_by_viscosity() {
        let pa = 2.0 * 17.6e-6 * 471.0 / TUBE_M;
        let whole = (318.15f64 / REFERENCE_K).sqrt() - 1.0;
        let share = (transpiration(pa, 318.15, REFERENCE_K) - 1.0) / whole;
        assert!((0.4..0.6).contains(&share), "{share} at {pa} Pa");
    }
}
