//! Capacitance diaphragm: the force of the gas bends a membrane. Linear, and the same for every gas.

use super::imperfections::Tolerance;
use super::{Environment, Range};

/// A capacitance diaphragm.
#[derive(Clone, Debug)]
pub struct Diaphragm {
    range: Range,
    /// The temperature its head is kept at, in K. As far as their manuals say none of the gauges here heats it, and without
    /// that there is no transpiration.
    pub head_k: Option<f64>,
}

/// The diameter of the tube to a heated head, in m.
const TUBE_M: f64 = 4e-3;

impl Diaphragm {
    pub const fn new(range: Range) -> Self {
        Self { range, head_k: None }
    }

    /// The pressure in the head.
    pub fn signal(&self, around: &Environment) -> f64 {
        let pa = around.gas.total();
        self.head_k.map_or(pa, |head_k| pa * transpiration(pa, head_k, around.temperature_k))
    }

    /// Field manual: noise 3e-5 of full scale. General knowledge: zero 5e-5 of full scale for each K, gain 0.2 %. free choice:
    /// a zero that may be 1e-4 of full scale off as delivered.
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

/// Pressure in a head at `head_k` per pressure `pa` in a chamber at `chamber_k`: Takaishi and Sensui, Trans. Faraday Soc. 59
/// (1963) 2503, with their constants for nitrogen, which every gas gets here: by Daudé, Elandaloussi and Janssen
/// (arXiv:1308.6794) viscosity and speed of the molecules decide, and the constants of other gases lead astray. 1 in dense gas,
/// the root of the temperatures where molecules fly freely.
fn transpiration(pa: f64, head_k: f64, chamber_k: f64) -> f64 {
    const A: f64 = 1.2e6;
    const B: f64 = 1.0e3;
    const C: f64 = 14.0;
    const PA_PER_TORR: f64 = 133.322;
    // In Torr mm / K, with the pressure in the warm head, which is the chamber's but for a tenth.
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

    fn around(gas: Gas, pa: f64) -> Environment {
        Environment { gas: Mixture::pure(gas, pa), atmosphere_pa: 1e5, temperature_k: REFERENCE_K }
    }

    #[test]
    fn every_gas_has_its_own_weight_and_the_same_pressure() {
        for gas in Gas::all() {
            for pa in [1e-3, 1.0, 1e5] {
                assert_eq!(Diaphragm::new(RANGE).signal(&around(gas, pa)), pa, "{gas}");
            }
        }
    }

    #[test]
    fn a_heated_head_reads_high_where_molecules_fly_freely() {
        let heated = Diaphragm { head_k: Some(318.15), ..Diaphragm::new(RANGE) };
        let ratio = |pa: f64| heated.signal(&around(Gas::N2, pa)) / pa;
        assert!((ratio(1e-4) / (318.15f64 / REFERENCE_K).sqrt() - 1.0).abs() < 5e-3, "{}", ratio(1e-4));
        assert!(ratio(1.0) < ratio(1e-2) && ratio(1.0) > 1.005, "{}", ratio(1.0));
        assert!((ratio(1000.0) - 1.0).abs() < 1e-3, "{}", ratio(1000.0));
    }

    /// arXiv:1308.6794: half of it is left at 2 x viscosity x mean speed / diameter.
    #[test]
    fn half_of_the_transpiration_is_left_where_the_viscosity_says() {
        let pa = 2.0 * 17.6e-6 * 471.0 / TUBE_M;
        let whole = (318.15f64 / REFERENCE_K).sqrt() - 1.0;
        let share = (transpiration(pa, 318.15, REFERENCE_K) - 1.0) / whole;
        assert!((0.4..0.6).contains(&share), "{share} at {pa} Pa");
    }
}
