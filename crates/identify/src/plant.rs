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
//! S(p) is a power of the pressure between knots, about one for each two decades. Residuals are logarithms of the pressure, so all decades count alike.
//! Levenberg and Marquardt's method (MINPACK) finds the numbers; their covariance gives the 95 % intervals. A record without a
//! closed valve and without a known dose determines S/V and Q/S only, so the volume must be given.

use crate::interval::{Interval, SIGMAS};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

const HOUR_S: f64 = 3600.0;

/// The fewest samples.
pub const LEAST_SAMPLES: usize = 30;

/// More samples than this are thinned out, evenly over the logarithm of time and over each closed valve.
const MOST_SAMPLES: usize = 600;

/// The decades of pressure between two knots of the pumping speed.
const DECADES: f64 = 2.0;

/// The most knots.
const MOST_KNOTS: usize = 6;

/// The weight of what is usual, as the scatter of a good record.
const PRIOR: f64 = 0.01;

/// Usual values of unknowns that many records do not determine, with their spread: the share of outgassing that does not return
/// to the wall, and the logarithm of the time constant of the return in s. free choice
const USUAL: [(usize, f64, f64); 2] = [(4, 0.1, 0.1), (5, 10.0, 3.0)];

/// The pressure changes by this part within a step of the calculation at most.
const STEP: f64 = 0.25;

/// The state of the valve to the pump from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// The start, in s.
    pub from_s: f64,
    /// Whether the valve to the pump is open.
    pub pumped: bool,
}

/// A known amount of gas that enters at once while the valve is closed, to measure the volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dose {
    /// The time, in s.
    pub at_s: f64,
    /// The amount, in Pa m^3.
    pub amount: f64,
}

/// The volume of the chamber.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Volume {
    /// It is known, in m^3.
    Given(f64),
    /// It follows from a dose.
    FromDose(Dose),
}

/// A record of a plant.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantRecord {
    /// Seconds since the start of the pump-down, and pressures in Pa.
    pub samples: Vec<(f64, f64)>,
    /// The phases, in the order of time; the first one begins with the record.
    pub phases: Vec<Phase>,
    /// The volume.
    pub volume: Volume,
}

/// The reason why a record cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NotIdentified {
    /// Too few samples.
    #[error("expected at least {LEAST_SAMPLES} samples, got {0}")]
    Few(usize),
    /// A number is not finite, a pressure not above zero, or the times do not rise.
    #[error("expected rising times and pressures above zero, got something else in sample {0}")]
    Sample(usize),
    /// The record has no phases, or they are not in order.
    #[error("expected phases in the order of time, the first one with the valve open")]
    Phases,
    /// The volume or the dose is not above zero.
    #[error("expected a volume or a dose above zero")]
    Volume,
    /// The dose is not within a phase with a closed valve.
    #[error("expected the dose while the valve is closed")]
    DoseWhilePumped,
    /// The method found no minimum.
    #[error("the fit found no minimum: the record does not look like a pump-down")]
    NoMinimum,
}

/// The numbers of a plant.
#[derive(Clone, Debug, PartialEq)]
struct Numbers {
    volume: f64,
    leak: f64,
    outgassing: f64,
    exponent: f64,
    ultimate: f64,
    /// The share of outgassing that does not return to the wall.
    share: f64,
    /// The time constant of the return of the water, in s.
    return_s: f64,
    /// The true pressure of the first sample divided by its indication.
    first: f64,
    /// Logarithms of pressure and speed.
    knots: Vec<(f64, f64)>,
}

impl Numbers {
    fn speed(&self, pa: f64) -> f64 {
        let at = pa.max(f64::MIN_POSITIVE).ln();
        let (Some(first), Some(last)) = (self.knots.first(), self.knots.last()) else { return 0.0 };
        let above = self.knots.windows(2).find(|pair| pair.get(1).is_some_and(|high| at < high.0));
        match above {
            _ if at <= first.0 => first.1.exp(),
            Some([(from, low), (to, high)]) => (low + (high - low) * (at - from) / (to - from)).exp(),
            _ => last.1.exp(),
        }
    }

    /// The outgassing of a wall of an age in s, in Pa m^3/s.
    fn outgassed(&self, age: f64) -> f64 {
        self.outgassing * (HOUR_S / age.max(1.0)).powf(self.exponent)
    }

    /// The state after `seconds` more, with constant sources and speed in each step.
    fn advance(&self, mut state: State, seconds: f64, pumped: bool) -> State {
        let mut left = seconds;
        while left > 0.0 {
            let pa = state.pa();
            let rate = if pumped { self.speed(pa) / self.volume } else { 0.0 };
            // Outgassing falls with the age. The speed changes with the pressure until that is nearly steady.
            let sources = (self.leak + self.outgassed(state.age)) / self.volume;
            let moves = rate > 0.0 && (pa / (self.ultimate + sources / rate)).ln().abs() > STEP;
            let step = left.min(STEP * state.age.max(1.0)).min(if moves { STEP / rate } else { left });
            let step = step.max(seconds / 1e4);
            let half = self.moved(state, step / 2.0, rate);
            let rate = if pumped { self.speed(half.pa()) / self.volume } else { 0.0 };
            state = State {
                age: self.aged(state, half.water, step),
                ..self.moved(State { age: half.age, ..state }, step, rate)
            };
            left -= step;
        }
        state
    }

    /// The state after a step at a rate of pumping in 1/s, with the outgassing of its age.
    fn moved(&self, state: State, step: f64, rate: f64) -> State {
        let outgassed = self.outgassed(state.age) / self.volume;
        let dry = self.leak / self.volume + self.ultimate * rate + self.share * outgassed;
        State {
            dry: relaxed(state.dry, dry, rate, step),
            water: relaxed(state.water, (1.0 - self.share) * outgassed, rate + self.return_s.recip(), step),
            age: self.aged(state, state.water, step),
        }
    }

    /// The age after a step with water of this pressure: the returning water makes the wall younger.
    fn aged(&self, state: State, water: f64, step: f64) -> f64 {
        let wetted = water * self.volume / (self.return_s * self.outgassing * HOUR_S);
        relaxed(state.age, 1.0, wetted, step).max(1.0)
    }
}

/// The solution of `x' = source - rate x` after a step.
fn relaxed(value: f64, source: f64, rate: f64, step: f64) -> f64 {
    let x = rate * step;
    let mean = if x < 1e-6 { 1.0 - x / 2.0 } else { -(-x).exp_m1() / x };
    value + (source - rate * value) * step * mean
}

/// The gas of a chamber: what does not return to the wall and the water, in Pa, and the age of the wall, in s.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    dry: f64,
    water: f64,
    age: f64,
}

impl State {
    fn pa(self) -> f64 {
        (self.dry + self.water).max(f64::MIN_POSITIVE)
    }
}

/// A plant with its uncertainties.
#[derive(Clone, Debug)]
pub struct Plant {
    /// The volume, in m^3.
    pub volume_m3: Interval,
    /// The effective pumping speed in m^3/s at pressures in Pa, from low to high pressure.
    pub speeds: Vec<(f64, Interval)>,
    /// The leak, in Pa m^3/s.
    pub leak: Interval,
    /// The outgassing after an hour, in Pa m^3/s.
    pub outgassing_1h: Interval,
    /// The exponent of the outgassing.
    pub exponent: Interval,
    /// The ultimate pressure of the pump, in Pa.
    pub ultimate_pa: Interval,
    /// Seconds, the logarithm of measured by fitted pressure, and the fitted pressure in Pa.
    pub residuals: Vec<(f64, f64, f64)>,
    /// The standard deviation of these logarithms.
    pub scatter: f64,
    unknowns: Unknowns,
    values: DVector<f64>,
    covariance: DMatrix<f64>,
    /// The time and the state of the first sample, where a prediction begins.
    start: (f64, State),
}

/// A change that lowers the pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// Close the leak.
    CloseLeak,
    /// Bake the chamber, which leaves a hundredth of the outgassing (free choice).
    Bake,
    /// A pump of twice the effective speed.
    LargerPump,
    /// A better fore vacuum or pump, with a tenth of the ultimate pressure.
    BetterPump,
}

/// Where each unknown is in the vector of the fit.
#[derive(Clone, Debug, PartialEq)]
struct Unknowns {
    given_volume: Option<f64>,
    knots_at: Vec<f64>,
    /// The sizes of leak and ultimate pressure.
    leak_size: f64,
    ultimate_size: f64,
    /// Whether the leak and the ultimate pressure are kept at zero, because the best fit has them below it.
    zero: [bool; 2],
}

/// The places of leak and ultimate pressure. Both may be negative in a fit, which keeps it linear near zero.
const LEAK: usize = 0;
const ULTIMATE: usize = 3;

impl Unknowns {
    const FIXED: usize = 7;

    fn count(&self) -> usize {
        Self::FIXED + self.knots_at.len() + usize::from(self.given_volume.is_none())
    }

    fn numbers(&self, values: &DVector<f64>) -> Numbers {
        let kept = |place: usize| [LEAK, ULTIMATE].iter().zip(self.zero).any(|(kept, zero)| zero && *kept == place);
        let at = |place: usize| values.get(place).copied().filter(|_| !kept(place)).unwrap_or(0.0);
        let knots = self.knots_at.iter().enumerate().map(|(place, pa)| (*pa, at(Self::FIXED + place)));
        Numbers {
            volume: self.given_volume.unwrap_or_else(|| at(self.count() - 1).exp()),
            leak: self.leak_size * at(LEAK),
            outgassing: at(1).exp(),
            exponent: at(2),
            ultimate: self.ultimate_size * at(ULTIMATE),
            share: at(4),
            return_s: at(5).exp(),
            first: at(6).exp(),
            knots: knots.collect(),
        }
    }
}

/// The problem for the method of Levenberg and Marquardt.
#[derive(Clone)]
struct Problem<'a> {
    record: &'a PlantRecord,
    samples: &'a [(f64, f64)],
    unknowns: Unknowns,
    values: DVector<f64>,
}

impl Problem<'_> {
    /// The states at the samples for some values.
    fn states(&self, values: &DVector<f64>) -> Vec<State> {
        let numbers = self.unknowns.numbers(values);
        let dose = match self.record.volume {
            Volume::FromDose(dose) => Some(dose),
            Volume::Given(_) => None,
        };
        let Some((first, pa)) = self.samples.first().copied() else { return Vec::new() };
        let mut now = first;
        let mut state = State { dry: pa * numbers.first, water: 0.0, age: first.max(1.0) };
        let mut all = Vec::with_capacity(self.samples.len());
        for (t, _) in self.samples {
            // The ends of the pieces between two samples: changes of the valve, the dose, and the sample.
            let dosed = dose.filter(|dose| dose.at_s > now && dose.at_s <= *t).map(|dose| dose.at_s);
            let mut ends: Vec<f64> = self.record.phases.iter().map(|phase| phase.from_s).collect();
            ends.extend(dosed);
            ends.retain(|end| *end > now && *end < *t);
            ends.push(*t);
            ends.sort_by(f64::total_cmp);
            for end in ends {
                state = numbers.advance(state, end - now, self.record.pumped_at(now));
                now = end;
                if let (Some(at), Some(dose)) = (dosed, dose)
                    && at.total_cmp(&end).is_eq()
                {
                    state.dry += dose.amount / numbers.volume;
                }
            }
            all.push(state);
        }
        all
    }

    /// The logarithms of fitted by measured pressure, and the distances of share and return time from what is usual.
    fn misses(&self, values: &DVector<f64>) -> DVector<f64> {
        let states = self.states(values);
        let misses = states.iter().zip(self.samples).map(|(fitted, (_, pa))| (fitted.pa() / pa).ln());
        let usual = USUAL.map(|(place, value, spread)| PRIOR * (values[place] - value) / spread);
        DVector::from_iterator(self.samples.len() + USUAL.len(), misses.chain(usual))
    }

    fn derivatives(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.samples.len() + USUAL.len(), self.values.len());
        for column in 0..self.values.len() {
            let [below, above] = [-1e-4, 1e-4].map(|change| {
                let mut values = self.values.clone();
                values[column] += change;
                self.misses(&values)
            });
            matrix.set_column(column, &((above - below) / 2e-4));
        }
        matrix
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ParameterStorage = Owned<f64, Dyn>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;

    fn set_params(&mut self, values: &DVector<f64>) {
        self.values.copy_from(values);
    }

    fn params(&self) -> DVector<f64> {
        self.values.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.misses(&self.values)).filter(|misses| misses.iter().all(|miss| miss.is_finite()))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.derivatives()).filter(|matrix| matrix.iter().all(|part| part.is_finite()))
    }
}

impl PlantRecord {
    fn pumped_at(&self, seconds: f64) -> bool {
        self.phases.iter().rev().find(|phase| phase.from_s <= seconds).is_none_or(|phase| phase.pumped)
    }

    fn check(&self) -> Result<(), NotIdentified> {
        let good = |(t, pa): &(f64, f64)| t.is_finite() && *t >= 0.0 && pa.is_finite() && *pa > 0.0;
        if let Some(place) = self.samples.iter().position(|sample| !good(sample)) {
            return Err(NotIdentified::Sample(place));
        }
        if let Some(place) = self.samples.windows(2).position(|pair| pair.first() >= pair.get(1)) {
            return Err(NotIdentified::Sample(place));
        }
        if self.samples.len() < LEAST_SAMPLES {
            return Err(NotIdentified::Few(self.samples.len()));
        }
        let ordered = self.phases.windows(2).all(|pair| pair[0].from_s < pair[1].from_s);
        if !ordered || !self.phases.first().is_some_and(|phase| phase.pumped) {
            return Err(NotIdentified::Phases);
        }
        match self.volume {
            Volume::Given(m3) if m3.is_finite() && m3 > 0.0 => Ok(()),
            Volume::FromDose(dose) if dose.amount.is_finite() && dose.amount > 0.0 => {
                if self.pumped_at(dose.at_s) {
                    Err(NotIdentified::DoseWhilePumped)
                } else {
                    Ok(())
                }
            }
            Volume::Given(_) | Volume::FromDose(_) => Err(NotIdentified::Volume),
        }
    }

    /// At most [`MOST_SAMPLES`], evenly over the logarithm of the time within each phase.
    fn thinned(&self) -> Vec<(f64, f64)> {
        let first = self.samples.first().map_or(0.0, |(t, _)| *t);
        let per_phase = MOST_SAMPLES / self.phases.len().max(1);
        let mut kept = Vec::new();
        for (place, phase) in self.phases.iter().enumerate() {
            let end = self.phases.get(place + 1).map_or(f64::INFINITY, |next| next.from_s);
            let start = phase.from_s.max(first);
            let here = self.samples.iter().filter(|(t, _)| *t >= phase.from_s && *t < end);
            let here: Vec<_> = here.copied().collect();
            let length = here.last().map_or(1.0, |(t, _)| t - start);
            let shortest = (length / 1e3).max(1e-3);
            let whole = (length / shortest).ln_1p();
            let mut next = f64::NEG_INFINITY;
            for sample in here {
                let part = ((sample.0 - start) / shortest).ln_1p() / whole * per_phase as f64;
                if part >= next {
                    kept.push(sample);
                    next = part.floor() + 1.0;
                }
            }
        }
        kept
    }
}

/// Identifies a plant from its record.
///
/// # Errors
/// [`NotIdentified`] when the record is incomplete, or does not look like a pump-down.
pub fn identify(record: &PlantRecord) -> Result<Plant, NotIdentified> {
    record.check()?;
    let samples = record.thinned();
    let (unknowns, start) = guess(record, &samples);
    let problem = Problem { record, samples: &samples, unknowns: unknowns.clone(), values: start };
    // The leak and the ultimate pressure may begin on the wrong side of a ridge.
    let starts = [[1.0, 1.0], [0.1, 0.1]];
    let fits = starts.into_iter().filter_map(|[leak, ultimate]| {
        let mut problem = problem.clone();
        problem.values[0] *= leak;
        problem.values[3] *= ultimate;
        let (fitted, report) = LevenbergMarquardt::new().minimize(problem);
        report.objective_function.is_finite().then_some((report.objective_function, fitted))
    });
    let best = fits.min_by(|(one, _), (two, _)| one.total_cmp(two));
    let (mut sum, mut fitted) = best.ok_or(NotIdentified::NoMinimum)?;
    while let Some(place) = [LEAK, ULTIMATE].iter().position(|place| fitted.values[*place] < 0.0) {
        fitted.unknowns.zero[place] = true;
        let (again, report) = LevenbergMarquardt::new().minimize(fitted);
        (sum, fitted) = (report.objective_function, again);
        [LEAK, ULTIMATE]
            .iter()
            .zip(fitted.unknowns.zero)
            .filter(|(_, zero)| *zero)
            .for_each(|(place, _)| fitted.values[*place] = 0.0);
    }
    fitted.unknowns.zero = [false; 2];
    if !sum.is_finite() {
        return Err(NotIdentified::NoMinimum);
    }
    let freedom = samples.len().saturating_sub(unknowns.count()).max(1) as f64;
    let variance = 2.0 * sum / freedom;
    // A number that the record does not determine has no effect; a weak prior of e^3 keeps its variance finite.
    let matrix = fitted.derivatives();
    let size = unknowns.count();
    let mut normal = matrix.transpose() * &matrix / variance;
    for place in 0..size {
        normal[(place, place)] += 1.0 / 9.0;
    }
    let covariance = normal.cholesky().ok_or(NotIdentified::NoMinimum)?.inverse();
    Ok(plant(&fitted, covariance, variance.sqrt()))
}

/// A first guess from the slopes of the record.
fn guess(record: &PlantRecord, samples: &[(f64, f64)]) -> (Unknowns, DVector<f64>) {
    let lowest = samples.iter().map(|(_, pa)| *pa).fold(f64::INFINITY, f64::min);
    let highest = samples.iter().map(|(_, pa)| *pa).fold(0.0, f64::max);
    let volume = match record.volume {
        Volume::Given(m3) => m3,
        Volume::FromDose(dose) => {
            let at = |t: f64| samples.iter().min_by(|one, two| (one.0 - t).abs().total_cmp(&(two.0 - t).abs()));
            let before = samples.iter().rev().find(|(t, _)| *t < dose.at_s).map_or(0.0, |(_, pa)| *pa);
            let after =
                samples.iter().find(|(t, _)| *t > dose.at_s).or_else(|| at(dose.at_s)).map_or(1.0, |(_, pa)| *pa);
            dose.amount / (after - before).max(1e-3 * after)
        }
    };
    let count = (((highest / lowest).log10() / DECADES).round().max(1.0) as usize).min(MOST_KNOTS - 1);
    let knots_at: Vec<f64> =
        (0..=count).map(|knot| lowest.ln() + (highest / lowest).ln() * knot as f64 / count as f64).collect();
    let pairs = || samples.windows(2).filter_map(|pair| Some((pair.first()?, pair.get(1)?)));
    let fastest = pairs()
        .filter(|((t, _), _)| record.pumped_at(*t))
        .map(|((t, pa), (later, lower))| (pa / lower).ln() / (later - t))
        .fold(1e-6, f64::max);
    let speed = (fastest * volume).ln();
    let rising = pairs().filter(|((t, _), _)| !record.pumped_at(*t));
    let gas = rising.map(|((t, pa), (later, higher))| (higher - pa) / (later - t) * volume).filter(|gas| *gas > 0.0);
    let gases: Vec<f64> = gas.collect();
    let gas = if gases.is_empty() { lowest * speed.exp() } else { gases.iter().sum::<f64>() / gases.len() as f64 };
    let end = samples.last().map_or(HOUR_S, |(t, _)| *t);
    let unknowns = Unknowns {
        given_volume: match record.volume {
            Volume::Given(m3) => Some(m3),
            Volume::FromDose(_) => None,
        },
        knots_at,
        leak_size: gas,
        ultimate_size: lowest,
        zero: [false; 2],
    };
    let mut values = vec![0.3, (0.7 * gas * end / HOUR_S).ln(), 1.0, 0.3, 0.1, 10.0, 0.0];
    values.extend(std::iter::repeat_n(speed, count + 1));
    if unknowns.given_volume.is_none() {
        values.push(volume.ln());
    }
    (unknowns, DVector::from_vec(values))
}

fn plant(fitted: &Problem<'_>, covariance: DMatrix<f64>, scatter: f64) -> Plant {
    let unknowns = fitted.unknowns.clone();
    let values = fitted.values.clone();
    let numbers = unknowns.numbers(&values);
    let deviation = |place: usize| covariance[(place, place)].sqrt();
    let logarithmic = |place: usize| {
        let [low, mean, high] = [-SIGMAS, 0.0, SIGMAS].map(|part| (values[place] + part * deviation(place)).exp());
        Interval { mean, low, high }
    };
    let linear = |place: usize, size: f64| {
        let found = Interval::normal(values[place], deviation(place)).scaled(size);
        Interval { low: found.low.max(0.0), ..found }
    };
    let speeds = unknowns.knots_at.iter().enumerate();
    let speeds = speeds.map(|(knot, pa)| (pa.exp(), logarithmic(Unknowns::FIXED + knot))).collect();
    let volume = unknowns
        .given_volume
        .map_or_else(|| logarithmic(unknowns.count() - 1), |m3| Interval { mean: m3, low: m3, high: m3 });
    let states = fitted.states(&values);
    let residuals = fitted.samples.iter().zip(&states);
    let residuals = residuals.map(|((t, pa), fitted)| (*t, (pa / fitted.pa()).ln(), fitted.pa()));
    let first = fitted.samples.iter().zip(&states).next();
    let start = first.map_or((0.0, State { dry: 1.0, water: 0.0, age: 1.0 }), |((t, _), state)| (*t, *state));
    Plant {
        volume_m3: volume,
        speeds,
        leak: linear(0, unknowns.leak_size),
        outgassing_1h: logarithmic(1),
        exponent: Interval::normal(numbers.exponent, deviation(2)),
        ultimate_pa: linear(3, unknowns.ultimate_size),
        residuals: residuals.collect(),
        scatter,
        start,
        unknowns,
        values,
        covariance,
    }
}

impl Plant {
    /// The pressure in Pa with its 95 % band if the pumping goes on until `seconds` after the start of the pump-down.
    #[must_use]
    pub fn predicted_pa(&self, seconds: f64) -> Interval {
        let logarithm = |values: &DVector<f64>| self.pressure(&self.unknowns.numbers(values), seconds).ln();
        let (mean, spread) = self.propagated(logarithm);
        Interval { mean: mean.exp(), low: (mean - spread).exp(), high: (mean + spread).exp() }
    }

    /// The time in s after the start of the pump-down at which the pressure reaches a target in Pa, with its 95 % band; `None`
    /// if it does not within a year.
    #[must_use]
    pub fn time_to_pa(&self, target_pa: f64) -> Option<Interval> {
        let time = |values: &DVector<f64>| self.time(&self.unknowns.numbers(values), target_pa).ln();
        let (mean, spread) = self.propagated(time);
        mean.is_finite().then(|| Interval {
            mean: mean.exp(),
            low: (mean - spread).exp(),
            // A value that is not finite means that the target may not be reached at all.
            high: if spread.is_finite() { (mean + spread).exp() } else { f64::INFINITY },
        })
    }

    /// The pressure after another day of pumping divided by that with each remedy, the best one first.
    #[must_use]
    pub fn remedies(&self) -> Vec<(Remedy, f64)> {
        let end = self.residuals.last().map_or(0.0, |(t, ..)| *t) + 24.0 * HOUR_S;
        let numbers = self.unknowns.numbers(&self.values);
        let now = self.pressure(&numbers, end);
        let mut all: Vec<_> = [Remedy::CloseLeak, Remedy::Bake, Remedy::LargerPump, Remedy::BetterPump]
            .map(|remedy| (remedy, now / self.pressure(&remedy.applied(&numbers), end)))
            .into();
        all.sort_by(|(_, one), (_, two)| two.total_cmp(one));
        all
    }

    /// The pressure if the pumping goes on from the first sample until `seconds`.
    fn pressure(&self, numbers: &Numbers, seconds: f64) -> f64 {
        let (from, state) = self.start;
        if seconds > from { numbers.advance(state, seconds - from, true).pa() } else { state.pa() }
    }

    fn time(&self, numbers: &Numbers, target_pa: f64) -> f64 {
        let (mut now, mut state) = self.start;
        if state.pa() <= target_pa {
            return now;
        }
        while now < 365.0 * 24.0 * HOUR_S {
            let step = (now * 0.02).max(0.1);
            let next = numbers.advance(state, step, true);
            let (pa, lower) = (state.pa(), next.pa());
            if lower <= target_pa {
                // Between the two the logarithms are a straight line.
                let part = if lower < pa { (pa / target_pa).ln() / (pa / lower).ln() } else { 1.0 };
                return now + step * part;
            }
            (now, state) = (now + step, next);
        }
        f64::INFINITY
    }

    /// A function of the numbers with 1.96 of its standard deviations.
    fn propagated(&self, of: impl Fn(&DVector<f64>) -> f64) -> (f64, f64) {
        let mean = of(&self.values);
        let gradient = DVector::from_fn(self.values.len(), |place, _| {
            // A tenth of the uncertainty of the number shows how the function changes within it.
            let step = (0.1 * self.covariance[(place, place)].sqrt()).max(1e-6);
            let [below, above] = [-step, step].map(|change| {
                let mut values = self.values.clone();
                values[place] += change;
                of(&values)
            });
            (above - below) / (2.0 * step)
        });
        let variance = gradient.dot(&(&self.covariance * &gradient));
        (mean, SIGMAS * variance.max(0.0).sqrt())
    }
}

impl Remedy {
    fn applied(self, numbers: &Numbers) -> Numbers {
        let mut better = numbers.clone();
        match self {
            Self::CloseLeak => better.leak = 0.0,
            Self::Bake => better.outgassing *= 0.01,
            Self::LargerPump => better.knots.iter_mut().for_each(|(_, speed)| *speed += std::f64::consts::LN_2),
            Self::BetterPump => better.ultimate *= 0.1,
        }
        better
    }
}
