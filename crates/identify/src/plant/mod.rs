//! A joint fit of pump-down, base pressure and rise.
//!
//! The chamber is one volume V with an effective pumping speed, a leak, outgassing, and the ultimate pressure of the pump:
//!
//! ```text
//! V dp/dt = -S(p) (p - p_u) + Q_L + Q_1 (1 h / t)^α - V w / tau      with the valve open; S = 0 with the valve closed
//! ```
//!
//! w is the water, which returns to the wall with a time constant tau; a share f of the outgassing does not return. t is the age
//! of the wall, which the returning water reduces, as in [`crate::rise`].
//!
//! S(p) is a power of the pressure between knots, about one for each two decades. Samples are averaged in groups that are even over
//! the logarithm of time. Residuals are logarithms of the pressure, so all decades count alike. Levenberg and Marquardt's method
//! (MINPACK) finds the numbers with exact derivatives, the profile of the sum of squares their 95 % intervals. A record without a closed
//! valve and without a known dose determines S/V and Q/S only, so the volume must be given.
//!
//! | Module | Holds |
//! |---|---|
//! | `record` | samples, phases, volume, their checks, groups, noise |
//! | `number` | numbers with their derivatives |
//! | `model` | the pressure of a plant with known numbers |
//! | `fit` | unknowns and least squares |
//! | `bounds` | intervals |
//! | `predict` | pressures and times to come, remedies |

mod bounds;
mod fit;
mod model;
mod number;
#[cfg(test)]
#[path = "../../tests/fresh/plants.rs"]
#[allow(dead_code, reason = "the numbers that other tests compare")]
mod plants;
mod predict;
mod record;

pub use predict::Remedy;
pub use record::{Dose, LEAST_SAMPLES, NotIdentified, Phase, PlantRecord, Volume};

use crate::interval::Interval;
use bounds::{Better, Bounds, Fitted};
use fit::{EXACT, EXPONENT, LEAK, OUTGASSING, Problem, SPEEDS, ULTIMATE, Unknowns};
use model::State;
use nalgebra::{DMatrix, DVector};

/// A group of samples beside the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Seconds since the start of the pump-down.
    pub at_s: f64,
    /// The mean measured pressure, in Pa.
    pub measured_pa: f64,
    /// The fitted pressure, in Pa.
    pub fitted_pa: f64,
    /// The logarithm of measured by fitted pressure, in standard deviations of the group: about 2 in one of twenty groups.
    pub deviations: f64,
}

/// A plant with its uncertainties.
#[derive(Clone, Debug)]
pub struct Plant {
    /// The volume, in m³.
    pub volume_m3: Interval,
    /// The effective pumping speed in m³/s at pressures in Pa, from low to high pressure.
    pub speeds: Vec<(f64, Interval)>,
    /// The leak, in Pa m³/s.
    pub leak: Interval,
    /// The outgassing after an hour, in Pa m³/s.
    pub outgassing_1h: Interval,
    /// The exponent of the outgassing.
    pub exponent: Interval,
    /// The ultimate pressure of the pump, in Pa.
    pub ultimate_pa: Interval,
    /// The groups of samples beside the fit.
    pub residuals: Vec<Residual>,
    /// The standard deviation of the logarithm of one sample from the fit.
    pub scatter: f64,
    /// The scatter divided by the noise between neighbours: near 1 for a good fit.
    pub misfit: f64,
    gauge_uncertainty: f64,
    unknowns: Unknowns,
    values: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Unknowns at the bounds of the intervals, with which the record still fits.
    corners: Vec<DVector<f64>>,
    /// The time and the state of the first group, where a prediction begins.
    start: (f64, State<f64>),
    /// The time of the last group, in s.
    end_s: f64,
}

/// The standard uncertainty of the laws of the plant, which no number of samples reduces. chosen: the linearity of a good
/// gauge within a decade.
const LAW: f64 = 0.003;

/// How often a better fit may be found while the intervals are searched.
const BETTER: i32 = 10;

/// Identifies a plant from its record.
///
/// # Errors
/// [`NotIdentified`] when the record is incomplete, or does not look like a pump-down.
pub fn identify(record: &PlantRecord) -> Result<Plant, NotIdentified> {
    identify_unless(record, &|| false)
}

/// The same, for a caller that may stop the search: `stopped` is called for each evaluation of the fit, about every millisecond.
///
/// # Errors
/// As [`identify`], and [`NotIdentified::Stopped`].
pub fn identify_unless(record: &PlantRecord, stopped: &dyn Fn() -> bool) -> Result<Plant, NotIdentified> {
    let found = search(record, stopped);
    // A search that is stopped ends early with any result.
    if stopped() { Err(NotIdentified::Stopped) } else { found }
}

fn search(record: &PlantRecord, stopped: &dyn Fn() -> bool) -> Result<Plant, NotIdentified> {
    record.check()?;
    let mut groups = record.groups();
    let noise = record::noise(&record.samples);
    // The mean of logarithms is below the logarithm of the mean.
    groups.iter_mut().for_each(|group| group.ln_pa += noise * noise / 2.0);
    let (mut sum, mut problem) = fit::best(record, &groups, noise, stopped)?;
    // A flat valley has always a slightly better fit: each search is satisfied with twice the difference, the last one with any.
    for attempt in 0..=BETTER {
        let slack = if attempt < BETTER { 0.05 * f64::from(1 << attempt) } else { f64::INFINITY };
        let fitted = Fitted::new(sum, problem, slack).ok_or(NotIdentified::NoMinimum)?;
        let places = 0..fitted.problem.unknowns.count();
        match places.map(|index| reported(&fitted, index)).collect::<Result<Vec<_>, _>>() {
            Ok(bounds) => return Ok(plant(&fitted, &bounds, record.gauge_uncertainty)),
            Err(Better(less, better)) => {
                (sum, problem) = better.minimised(EXACT).unwrap_or((less, fitted.problem));
            }
        }
    }
    Err(NotIdentified::NoMinimum)
}

/// The bounds of an unknown that has an interval.
fn reported<'a>(fitted: &Fitted<'a>, index: usize) -> Result<Option<Bounds>, Better<'a>> {
    let is_reported = matches!(index, LEAK | OUTGASSING | EXPONENT | ULTIMATE) || index >= SPEEDS;
    is_reported.then(|| fitted.bounds(index)).transpose()
}

fn residuals(problem: &Problem<'_>, states: &[State<f64>]) -> Vec<Residual> {
    let residual = |(group, fitted): (&record::Group, &State<f64>)| Residual {
        at_s: group.at_s,
        measured_pa: group.ln_pa.exp(),
        fitted_pa: fitted.pa(),
        deviations: (group.ln_pa - fitted.pa().ln()) * group.count.sqrt() / problem.noise,
    };
    problem.groups.iter().zip(states).map(residual).collect()
}

fn plant(fitted: &Fitted<'_>, bounds: &[Option<Bounds>], gauge_uncertainty: f64) -> Plant {
    let problem: &Problem<'_> = &fitted.problem;
    let unknowns = problem.unknowns.clone();
    let values = problem.values.clone();
    let interval = |index: usize| {
        let found = bounds.get(index).and_then(Option::as_ref);
        let [low, high] = found.map_or([&values; 2], |bounds| [&bounds.low, &bounds.high]).map(|all| all[index]);
        Interval { mean: values[index], low, high }
    };
    let logarithmic = |index: usize| {
        let found = interval(index);
        Interval { mean: found.mean.exp(), low: found.low.exp(), high: found.high.exp() }
    };
    // A gauge that reads too high finds too much gas and, from a dose, too small a volume. The time constants V/S do not change.
    let gas = |interval: Interval| interval.widened(gauge_uncertainty.hypot(LAW));
    let by_dose = |interval: Interval| match unknowns.given_volume {
        Some(_) => interval.widened(LAW),
        None => gas(interval),
    };
    let speeds = unknowns.knots_at.iter().enumerate();
    let speeds = speeds.map(|(knot, pa)| (pa.exp(), by_dose(logarithmic(SPEEDS + knot)))).collect();
    let given = unknowns.given_volume.map(|m3| Interval { mean: m3, low: m3, high: m3 });
    let volume_m3 = given.unwrap_or_else(|| by_dose(logarithmic(unknowns.count() - 1)));
    let states = problem.states(&values);
    let first = problem.groups.first().zip(states.first());
    let start = first.map_or((0.0, State { dry: 1.0, water: 0.0, age: 1.0 }), |(group, state)| (group.at_s, *state));
    let misfit = fitted.variance.sqrt();
    Plant {
        volume_m3,
        speeds,
        leak: gas(interval(LEAK).scaled(unknowns.leak_size)),
        outgassing_1h: gas(logarithmic(OUTGASSING)),
        exponent: interval(EXPONENT),
        ultimate_pa: gas(interval(ULTIMATE).scaled(unknowns.ultimate_size)),
        residuals: residuals(problem, &states),
        scatter: misfit * problem.noise,
        misfit,
        gauge_uncertainty,
        start,
        end_s: problem.groups.last().map_or(0.0, |group| group.at_s),
        corners: bounds.iter().flatten().flat_map(|bounds| [bounds.low.clone(), bounds.high.clone()]).collect(),
        unknowns,
        values,
        covariance: fitted.covariance.clone(),
    }
}
