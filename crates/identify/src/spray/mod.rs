//! Helium at a leak, recognised in a record by its shape.
//!
//! While helium is sprayed on a leak it enters in place of air. The indication then approaches a plateau with the time constant V/S
//! and returns with the same one:
//!
//! ```text
//! p = b + A h(t)      dh/dt = (u - h)/tau      u = 1 while the gas is there, else 0; b is a parabola of the time
//! ```
//!
//! Another gas that is let in for the same time has the same shape, so a [`Spray`] says what the record looks like, and not what
//! was done. Sign and size differ for each kind of gauge: see [`response`].
//!
//! | Module | Holds |
//! |---|---|
//! | `find` | the times at which an indication leaves its course and returns |
//! | `fit` | the shape, by least squares |

mod find;
mod fit;

use crate::interval::Interval;
use crate::rise::GasDependence;
use profivac_vacuum::gas::Gas;

pub use find::find;

/// A change of the indication with the shape of helium at a leak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spray {
    /// When the gas came, in s.
    pub from_s: Interval,
    /// When it went, in s.
    pub to_s: Interval,
    /// The time constant of change and return, in s.
    pub tau_s: Interval,
    /// The change of the indication after many time constants, in Pa; below zero if it falls.
    pub change_pa: Interval,
    /// The indication without it, in Pa.
    pub base_pa: f64,
    /// The root mean square of the residuals divided by the noise: near 1 for a good fit.
    pub misfit: f64,
}

/// The flow of helium through a leak divided by that of air: the root of the quotient of the molar masses if the leak is small, the
/// quotient of the viscosities if it is large.
fn flows() -> [f64; 2] {
    [
        Gas::Air.viscosity_pa_s() / Gas::He.viscosity_pa_s(),
        (Gas::Air.molar_mass_kg_per_mol() / Gas::He.molar_mass_kg_per_mol()).sqrt(),
    ]
}

/// The pumping speed for air divided by that for helium: behind a tube the root of the quotient of the molar masses, at the inlet of
/// a turbo near 1. Capture pumps have larger values.
fn speeds() -> [f64; 2] {
    [(Gas::He.molar_mass_kg_per_mol() / Gas::Air.molar_mass_kg_per_mol()).sqrt(), 1.0]
}

/// The change of an indication when helium replaces all air at a leak, divided by the part of the indication that is this air:
/// from the least to the greatest, for any regime of the leak and any pump but a capture pump.
#[must_use]
pub fn response(gauge: GasDependence) -> [f64; 2] {
    let factor = gauge.factor(Gas::Air) / gauge.factor(Gas::He);
    let [least, greatest] = [0, 1].map(|end| flows()[end] * speeds()[end] * factor - 1.0);
    [least, greatest]
}

/// The pumping speed for air divided by that for helium at which an indication does not change; above it rises.
#[must_use]
pub fn neutral_speeds(gauge: GasDependence) -> [f64; 2] {
    let [viscous, molecular] = flows();
    [molecular, viscous].map(|flow| gauge.factor(Gas::He) / gauge.factor(Gas::Air) / flow)
}

/// What a change says about a leak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LeakPressure {
    /// The part of the indication that is air of the leak, in Pa.
    Air(Interval),
    /// A change of this sign needs a pump that takes helium worse than air, or another gas.
    OtherSign,
    /// The change is larger than if all gas were air of the leak.
    TooLarge,
}

impl Spray {
    /// The part of the indication that is air of the leak. Less than all air may have been replaced, so the leak may be larger, up to
    /// the whole indication.
    #[must_use]
    pub fn air_pa(&self, gauge: GasDependence) -> LeakPressure {
        let [least, greatest] = response(gauge);
        let rises = self.change_pa.mean > 0.0;
        // The strongest and the weakest response with this sign.
        let (strongest, weakest) = if rises { (greatest, least.max(0.0)) } else { (-least, (-greatest).max(0.0)) };
        if strongest <= 0.0 {
            return LeakPressure::OtherSign;
        }
        let Interval { low, high, .. } = self.change_pa;
        let size = if rises { [low, high] } else { [-high, -low] }.map(|pa| pa.max(0.0));
        let low = size[0] / strongest;
        if low > self.base_pa {
            return LeakPressure::TooLarge;
        }
        let high = if weakest > 0.0 { (size[1] / weakest).min(self.base_pa) } else { self.base_pa };
        LeakPressure::Air(Interval { mean: f64::midpoint(low, high), low, high })
    }
}
