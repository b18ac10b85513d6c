//! Rate of rise: after the valve to the pump is closed, the shape of the pressure rise separates a leak from outgassing.
//!
//! A leak adds the same amount of gas every second. Outgassing slows down, for one of two reasons: the wall has less and less to
//! give, or the gas returns to the wall. With b the rate of outgassing when the valve closes, and t0 the time of pumping before:
//!
//! ```text
//! inverse time   dp/dt = a + b (1 + t/t0)^-α                     α near 1 (Elsey, Vacuum 25 (1975) 299)
//! saturating     dp/dt = a + b ((1 - f) u' + f (1 + t/t0)^-α),   u' = t0/c - u/tau,   c' = 1 - c u/(tau t0)
//! ```
//!
//! In the second one the water u returns to the wall of age c (Redhead, JVST A 14 (1996) 2599), a share f of other gases does
//! not. Both are fitted for every t0, α and tau of a grid, with the noise as weight and a, b, f not below zero. An interval holds
//! every value with which any of them fits: its profile likelihood is not below that of a normal distribution at 1.96 standard
//! deviations. So a quantity that the record does not determine has a wide interval.
//!
//! | Module | Holds |
//! |---|---|
//! | `noise` | means of samples, their noise, the straight line |
//! | `slowing` | the ways in which outgassing slows down |
//! | `model` | the fit of one of them |
//! | `result` | intervals, causes and shapes from all fits |

mod model;
pub(crate) mod noise;
mod result;
mod slowing;

use crate::interval::Interval;
use model::{Model, refine};
use noise::{Noise, grouped, straight};
use profivac_vacuum::gas::Gas;
use profivac_vacuum::pump::sccm_of_flow;
use result::Record;
use slowing::{slowings, steps};

/// The fewest samples: three unknowns, and some more to know the noise.
pub const LEAST_SAMPLES: usize = 12;

/// Times of pumping before as a part of the length of the record, when that is not known.
const STARTS: [f64; 2] = [0.05, 50.0];

/// The number of times of pumping when that is not known.
const START_STEPS: usize = 8;

/// How the indication of a gauge depends on the gas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GasDependence {
    /// A diaphragm.
    None,
    /// A hot or cold cathode.
    Ionisation,
    /// A Pirani, below 1 mbar.
    Conduction,
}

impl GasDependence {
    /// True pressure divided by the indication.
    #[must_use]
    pub fn factor(self, gas: Gas) -> f64 {
        match self {
            Self::None => 1.0,
            Self::Ionisation => gas.ion_factor(),
            Self::Conduction => gas.pirani_factor(),
        }
    }
}

/// The known quantities of a rise beside its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RiseSetup {
    /// The volume, in m³.
    pub volume_m3: f64,
    /// The time of pumping before the valve was closed, in s, if known.
    pub pumped_s: Option<f64>,
    /// How the gauge depends on the gas.
    pub gauge: GasDependence,
    /// The gas of outgassing; water for an unbaked chamber, hydrogen for a baked one. A leak is air.
    pub outgassed: Gas,
    /// The standard uncertainty of the gauge's sensitivity as a fraction, which no fit reduces.
    pub gauge_uncertainty: f64,
    /// The temperature of the gas, in K.
    pub gas_k: f64,
}

/// A gas flow with its 95 % interval, in Pa m³/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// The best value, and the values that the profile likelihood does not exclude with 95 %.
    pub pa_m3_per_s: Interval,
    /// The temperature of the gas, in K.
    pub gas_k: f64,
}

impl Flow {
    /// The flow in sccm, at 0 °C and 1013.25 mbar.
    #[must_use]
    pub fn sccm(&self) -> Interval {
        self.pa_m3_per_s.scaled(sccm_of_flow(1.0, self.gas_k))
    }

    /// The flow in mbar l/s.
    #[must_use]
    pub const fn mbar_l_per_s(&self) -> Interval {
        self.pa_m3_per_s.scaled(10.0)
    }
}

/// The cause of a rise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// A leak; outgassing is not certain.
    Leak,
    /// Outgassing; a leak is not certain.
    Outgassing,
    /// Both are certain.
    Both,
    /// Leak and outgassing cannot be distinguished: each of them explains the rise alone.
    Undistinguished,
    /// The pressure does not rise.
    NoRise,
}

/// The probabilities of the shapes, which add up to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shapes {
    /// A straight line.
    pub straight: f64,
    /// A straight line and outgassing that falls with the time.
    pub inverse_time: f64,
    /// A straight line and outgassing that saturates.
    pub saturating: f64,
}

/// A rise, separated into leak and outgassing.
#[derive(Clone, Debug, PartialEq)]
pub struct Rise {
    /// The leak.
    pub leak: Flow,
    /// The outgassing at the time when the valve was closed.
    pub outgassing: Flow,
    /// Both at that time: the indicated rate times the volume.
    pub total: Flow,
    /// The cause.
    pub cause: Cause,
    /// The probabilities of the shapes.
    pub shapes: Shapes,
    /// The root mean square of the residuals of the best fit divided by the noise: near 1 for a good fit.
    pub misfit: f64,
    /// The best fit, to draw it: indicated pressures in Pa at the times of the samples.
    pub fitted: Vec<(f64, f64)>,
    /// The time constant of saturation of the best fit in s, if that shape is the most probable one.
    pub tau_s: Option<f64>,
}

/// The reason why samples cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoRise {
    /// Too few samples.
    #[error("expected at least {LEAST_SAMPLES} samples of a rise, got {0}")]
    Few(usize),
    /// All samples have the same time.
    #[error("expected samples at different times, got {0} samples at one time")]
    NoTime(usize),
    /// A number is not finite, or a pressure not above zero.
    #[error("expected finite times and pressures above zero, got something else in sample {0}")]
    NotPositive(usize),
    /// The setup has a volume, time or temperature that is not above zero.
    #[error("expected a volume, a time of pumping and a temperature above zero")]
    Setup,
}

/// Separates a rise: samples of seconds since the valve was closed and indicated pressures in Pa.
///
/// # Errors
/// [`NoRise`] when there is too little to fit.
pub fn analyse(samples: &[(f64, f64)], setup: &RiseSetup) -> Result<Rise, NoRise> {
    check(samples, setup)?;
    let samples = grouped(samples);
    let samples = samples.as_slice();
    let first = samples.first().map_or(0.0, |(t, _)| *t);
    let length = samples.last().map_or(0.0, |(t, _)| *t - first);
    let noise = Noise::of(samples);
    let weighted: Vec<_> = samples.iter().map(|(t, p)| (t - first, *p, noise.at(*p).recip())).collect();
    let straight = straight(&weighted);
    let starts: Vec<f64> = match setup.pumped_s {
        Some(pumped) => vec![pumped + first],
        None => steps(STARTS[0] * length, STARTS[1] * length, START_STEPS).collect(),
    };
    let times: Vec<f64> = weighted.iter().map(|(t, ..)| *t).collect();
    let slowings = starts.iter().flat_map(|start_s| slowings(&times, *start_s));
    let mut models: Vec<Model> = slowings.map(|slowing| Model::new(&weighted, straight, slowing)).collect();
    starts.iter().for_each(|start_s| refine(&mut models, &weighted, straight, *start_s));
    Ok(Record { samples: &weighted, first, straight, models }.result(setup))
}

fn check(samples: &[(f64, f64)], setup: &RiseSetup) -> Result<(), NoRise> {
    let positive = |number: f64| number.is_finite() && number > 0.0;
    if let Some(index) = samples.iter().position(|(t, p)| !t.is_finite() || !positive(*p)) {
        return Err(NoRise::NotPositive(index));
    }
    if samples.len() < LEAST_SAMPLES {
        return Err(NoRise::Few(samples.len()));
    }
    if samples.first().map(|(t, _)| *t) >= samples.last().map(|(t, _)| *t) {
        return Err(NoRise::NoTime(samples.len()));
    }
    let known = [Some(setup.volume_m3), Some(setup.gas_k), setup.pumped_s];
    if known.into_iter().flatten().all(positive) { Ok(()) } else { Err(NoRise::Setup) }
}
