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

use crate::interval::{Interval, SIGMAS};
use crate::profile::{Least, Sums, TIME, crossing, minimise};
use nalgebra::Vector4;
use profivac_vacuum::gas::Gas;
use profivac_vacuum::pump::sccm_of_flow;

/// The fewest samples: three unknowns, and some more to know the noise.
pub const LEAST_SAMPLES: usize = 12;

/// More samples are averaged in groups, because they would only cost time.
const MOST_SAMPLES: usize = 400;

/// The time constants of return as a part of the length of the record: from a twentieth to ten times. A longer one is a
/// straight line, which no record distinguishes from a leak.
const TAUS: [f64; 2] = [0.05, 10.0];

/// Times of pumping before as a part of the length of the record, when that is not known.
const STARTS: [f64; 2] = [0.05, 50.0];

/// How often the step of the time constants is reduced to its root around the best one.
const REFINEMENTS: usize = 6;

/// The number of time constants, and of times of pumping when that is not known.
const TAU_STEPS: usize = 16;
const START_STEPS: usize = 8;

/// Exponents of outgassing that does not return: near 1 for metals in the first day, 1/2 for hydrogen (Elsey 1975; Grinham and Chew,
/// Appl. Sci. Converg. Technol. 26 (2017) 95).
const EXPONENTS: [f64; 5] = [0.5, 0.8, 0.9, 1.0, 1.1];

/// The exponents of the share beside water that returns.
const SHARE_EXPONENTS: [f64; 2] = [0.5, 1.0];

/// The number of points of the profile for the mean.
const MEAN_POINTS: usize = 64;

/// A quantity is stated as present if its lower bound is above this part of the rise. free choice
const SMALL: f64 = 0.1;

/// The least relative noise: a record without noise has the four digits of a display. free choice
const LEAST_NOISE: f64 = 1e-4;

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
    /// The volume, in m^3.
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

/// A gas flow with its 95 % interval, in Pa m^3/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// The mean, and the shortest interval with a probability of 95 %.
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
    /// The total at that time, as the indicated slope times the volume.
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

/// The integral of the relative rate less 1 up to each time of a record, for outgassing that falls with an exponent (Simpson).
fn staying(times: &[f64], start_s: f64, exponent: f64) -> Vec<f64> {
    let less = |t: f64| (-exponent * (t / start_s).ln_1p()).exp_m1();
    let (mut sum, mut before, mut last) = (0.0, 0.0, 0.0);
    let mut integral = |t: &f64| {
        let end = less(*t);
        sum += (t - before) / 6.0 * (last + 4.0 * less(f64::midpoint(before, *t)) + end);
        (before, last) = (*t, end);
        sum
    };
    times.iter().map(&mut integral).collect()
}

/// The same for water that returns to the wall: u' = t0/c - u/tau, c' = 1 - c u / (tau t0), with the age c of the wall and the
/// pressure u divided by b (fourth order Runge-Kutta).
fn returning(times: &[f64], start_s: f64, tau_s: f64) -> Vec<f64> {
    let rate = |[u, c]: [f64; 2]| [start_s / c - u / tau_s, 1.0 - c * u / (tau_s * start_s)];
    let (mut state, mut before) = ([0.0, start_s], 0.0);
    let mut advance = |t: &f64| {
        let step = t - before;
        let at = |slope: [f64; 2], part: f64| [state[0] + slope[0] * step * part, state[1] + slope[1] * step * part];
        let first = rate(state);
        let second = rate(at(first, 0.5));
        let third = rate(at(second, 0.5));
        let fourth = rate(at(third, 1.0));
        for (place, value) in state.iter_mut().enumerate() {
            *value += step / 6.0 * (first[place] + 2.0 * second[place] + 2.0 * third[place] + fourth[place]);
        }
        before = *t;
        state[0] - t
    };
    times.iter().map(&mut advance).collect()
}

/// A way in which outgassing slows down, with the lags of its two parts.
struct Slowing {
    /// The time of pumping before, in s.
    start_s: f64,
    /// The time constant with which gas returns to the wall, in s.
    tau_s: Option<f64>,
    lags: Vec<f64>,
    /// The lags of the share that does not return.
    others: Option<Vec<f64>>,
}

/// All ways of slowing down for a time of pumping.
fn slowings(times: &[f64], start_s: f64) -> Vec<Slowing> {
    let length = times.last().copied().unwrap_or(0.0);
    let inverse = EXPONENTS.map(|exponent| Slowing {
        start_s,
        tau_s: None,
        lags: staying(times, start_s, exponent),
        others: None,
    });
    let taus = steps(TAUS[0] * length, TAUS[1] * length, TAU_STEPS);
    inverse.into_iter().chain(taus.flat_map(|tau_s| saturating(times, start_s, tau_s))).collect()
}

/// The ways that saturate with a time constant.
fn saturating(times: &[f64], start_s: f64, tau_s: f64) -> [Slowing; SHARE_EXPONENTS.len()] {
    let returns = returning(times, start_s, tau_s);
    SHARE_EXPONENTS.map(|exponent| Slowing {
        start_s,
        tau_s: Some(tau_s),
        lags: returns.clone(),
        others: Some(staying(times, start_s, exponent)),
    })
}

/// Adds models between the steps of the grid of time constants around the best one for a time of pumping: a long record is
/// sensitive to its time constant.
fn refine(models: &mut Vec<Model>, samples: &[(f64, f64, f64)], straight: [f64; 3], start_s: f64) {
    let times: Vec<f64> = samples.iter().map(|(t, ..)| *t).collect();
    let mut ratio = (TAUS[1] / TAUS[0]).powf(1.0 / (TAU_STEPS - 1) as f64);
    for _ in 0..REFINEMENTS {
        ratio = ratio.sqrt();
        let here = models.iter().filter(|model| model.slowing.start_s.total_cmp(&start_s).is_eq());
        let here = here.filter_map(|model| Some((model.best.chi2, model.slowing.tau_s?)));
        let Some((_, tau_s)) = here.min_by(|(one, _), (other, _)| one.total_cmp(other)) else { return };
        for tau_s in [tau_s / ratio, tau_s * ratio] {
            models.extend(saturating(&times, start_s, tau_s).map(|slowing| Model::new(samples, straight, slowing)));
        }
    }
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
    if let Some(place) = samples.iter().position(|(t, p)| !t.is_finite() || !positive(*p)) {
        return Err(NoRise::NotPositive(place));
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

/// Means of groups, so that at most [`MOST_SAMPLES`] remain.
fn grouped(samples: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let size = samples.len().div_ceil(MOST_SAMPLES).max(1);
    let mean = |group: &[(f64, f64)]| {
        let count = group.len() as f64;
        let (t, p) = group.iter().fold((0.0, 0.0), |(t, p), sample| (t + sample.0, p + sample.1));
        (t / count, p / count)
    };
    samples.chunks(size).map(mean).collect()
}

/// The noise of a gauge: constant, or proportional to the pressure.
#[derive(Clone, Copy, Debug)]
enum Noise {
    Constant(f64),
    Relative(f64),
}

impl Noise {
    /// The noise from second differences, which a smooth rise does not contribute to. The more likely of both kinds.
    fn of(samples: &[(f64, f64)]) -> Self {
        let mut sums = [0.0, 0.0];
        let mut logarithms = 0.0;
        let mut count = 0.0;
        for three in samples.windows(3) {
            let [(t0, p0), (t1, p1), (t2, p2)] = three else { continue };
            let part = if t2 > t0 { (t1 - t0) / (t2 - t0) } else { 0.5 };
            let difference = p1 - (p0 + (p2 - p0) * part);
            let square = difference * difference / (1.0 + part * part + (1.0 - part) * (1.0 - part));
            sums[0] += square;
            sums[1] += square / (p1 * p1);
            logarithms += p1.ln();
            count += 1.0;
        }
        // A record without noise has that of its digits.
        let highest = samples.iter().fold(0.0, |highest, (_, p)| f64::max(highest, *p));
        let constant = (sums[0] / count).sqrt().max(LEAST_NOISE * highest);
        let relative = (sums[1] / count).sqrt().max(LEAST_NOISE);
        let likely = -count * relative.ln() - logarithms > -count * constant.ln();
        if likely { Self::Relative(relative) } else { Self::Constant(constant) }
    }

    fn at(self, pa: f64) -> f64 {
        match self {
            Self::Constant(constant) => constant,
            Self::Relative(relative) => relative * pa,
        }
    }
}

/// Numbers from one to another in equal ratios.
fn steps(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |step| from * (to / from).powf(step as f64 / count.saturating_sub(1).max(1) as f64))
}

/// The straight line of the least squares: pressure at the start in Pa, slope in Pa/s, and sum of squares.
fn straight(samples: &[(f64, f64, f64)]) -> [f64; 3] {
    let mut sums = [0.0; 5];
    for (t, p, weight) in samples {
        let square = weight * weight;
        let parts = [1.0, *t, t * t, *p, t * p];
        sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += square * part);
    }
    let [one, t, tt, p, tp] = sums;
    let slope = (one * tp - t * p) / (one * tt - t * t);
    let start = (p - slope * t) / one;
    let chi2 = samples.iter().map(|(t, p, weight)| ((p - start - slope * t) * weight).powi(2)).sum();
    [start, slope, chi2]
}

/// The fit of one way of slowing down.
struct Model {
    slowing: Slowing,
    sums: Sums,
    /// The slope of the straight line, in Pa/s, and the largest leak or outgassing to be tried.
    slope: f64,
    most: f64,
    /// The leak of the best fit in Pa/s, and the fit.
    leak: f64,
    best: Least,
}

/// One of the two rates.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rate {
    Leak,
    Outgassing,
}

impl Model {
    fn new(samples: &[(f64, f64, f64)], [start, slope, _]: [f64; 3], slowing: Slowing) -> Self {
        let rows = samples
            .iter()
            .enumerate()
            .map(|(place, (t, p, weight))| (slowing.row(place, *t), p - start - slope * t, *weight));
        let sums = Sums::new(rows);
        // Outgassing slows down, so it begins with more than the mean slope; a hundred times is beyond every tau.
        let most = 100.0 * slope.abs();
        let mut model = Self { sums, slope, most, leak: 0.0, best: Least::none(), slowing };
        model.leak = minimise(model.most, |leak| model.least(Rate::Leak, leak).chi2);
        model.best = model.least(Rate::Leak, model.leak);
        model
    }

    /// The best fit with one rate given, in Pa/s.
    fn least(&self, rate: Rate, given: f64) -> Least {
        let time = Vector4::from(TIME);
        let [water, other] = [[0.0, 1.0, 1.0, 0.0], [0.0, 1.0, 0.0, 1.0]].map(Vector4::from);
        let unlimited = f64::INFINITY;
        let has_other = self.slowing.others.is_some();
        match rate {
            Rate::Leak => {
                let others = if has_other { unlimited } else { 0.0 };
                self.sums.least(time * (given - self.slope), [(water, unlimited), (other, others)])
            }
            Rate::Outgassing => {
                let others = if has_other { given } else { 0.0 };
                let fixed = water * given - time * self.slope;
                self.sums.least(fixed, [(time, unlimited), (other - water, others)])
            }
        }
    }

    /// The outgassing of the best fit, in Pa/s.
    fn outgassing(&self) -> f64 {
        self.best.vector[2] + self.best.vector[3]
    }

    /// The range of a rate with a sum of squares up to a limit.
    fn range(&self, rate: Rate, limit: f64) -> Option<[f64; 2]> {
        if self.best.chi2 > limit {
            return None;
        }
        let within = match rate {
            Rate::Leak => self.leak,
            Rate::Outgassing => self.outgassing(),
        };
        Some([0.0, self.most].map(|bound| crossing(within, bound, limit, |given| self.least(rate, given).chi2)))
    }

    /// The pressure above the straight line at a sample, in Pa.
    fn at(&self, place: usize, t: f64) -> f64 {
        self.slowing.row(place, t).dot(&self.best.vector)
    }
}

impl Slowing {
    /// The row of a sample: constant, time, and the two lags.
    fn row(&self, place: usize, t: f64) -> Vector4<f64> {
        let lag = |lags: &Vec<f64>| lags.get(place).copied().unwrap_or(0.0);
        Vector4::new(1.0, t, lag(&self.lags), self.others.as_ref().map_or(0.0, lag))
    }
}

impl Least {
    fn none() -> Self {
        Self { chi2: f64::INFINITY, vector: Vector4::zeros() }
    }
}

/// The probabilities of the causes, and the outgassing without a leak in Pa/s.
struct Causes {
    leak_alone: f64,
    outgassing_alone: f64,
    both: f64,
    outgassing: f64,
}

/// A record with all its fits.
struct Record<'a> {
    samples: &'a [(f64, f64, f64)],
    first: f64,
    straight: [f64; 3],
    models: Vec<Model>,
}

impl Record<'_> {
    fn result(&self, setup: &RiseSetup) -> Rise {
        let [start, slope, line] = self.straight;
        let by_sum = |one: &&Model, two: &&Model| one.best.chi2.total_cmp(&two.best.chi2);
        let best = self.models.iter().min_by(by_sum);
        let least = best.map_or(line, |model| model.best.chi2);
        let misfit = (least.max(0.0) / self.samples.len().saturating_sub(4).max(1) as f64).sqrt();
        // A fit that misses more than the noise has larger uncertainties.
        let variance = misfit.powi(2).max(1.0);
        let causes = self.causes(least.min(line), variance);
        let [leak, outgassing] =
            [Rate::Leak, Rate::Outgassing].map(|rate| self.interval(rate, least, variance, &causes));
        let total =
            Interval { mean: best.map_or(slope, |model| model.leak + model.outgassing()), ..self.slope(variance) };
        let shapes = self.shapes(least.min(line), variance);
        let saturating = self.models.iter().filter(|model| model.slowing.tau_s.is_some()).min_by(by_sum);
        let flow = |interval: Interval, factor: f64| Flow {
            pa_m3_per_s: interval.scaled(setup.volume_m3 * factor).widened(setup.gauge_uncertainty),
            gas_k: setup.gas_k,
        };
        let [air, walls] = [Gas::Air, setup.outgassed].map(|gas| setup.gauge.factor(gas));
        let fitted = self.samples.iter().enumerate().map(|(place, (t, ..))| {
            let more = best.map_or(0.0, |model| model.at(place, *t));
            (t + self.first, start + slope * t + more)
        });
        Rise {
            leak: flow(leak, air),
            outgassing: flow(outgassing, walls),
            total: flow(total, air),
            cause: cause(&total, slope, &leak, &outgassing),
            shapes,
            misfit,
            fitted: fitted.collect(),
            tau_s: saturating.and_then(|model| model.slowing.tau_s).filter(|_| shapes.saturating > 0.5),
        }
    }

    /// The mean slope with its uncertainty, in Pa/s.
    fn slope(&self, variance: f64) -> Interval {
        let sums = self.samples.iter().fold([0.0; 3], |[one, t, tt], (time, _, weight)| {
            let square = weight * weight;
            [one + square, t + square * time, tt + square * time * time]
        });
        let [one, t, tt] = sums;
        Interval::normal(self.straight[1], (variance * one / (one * tt - t * t)).sqrt())
    }

    /// The mean of a rate over the causes, and its 95 % interval.
    fn interval(&self, rate: Rate, least: f64, variance: f64, causes: &Causes) -> Interval {
        let limit = least + SIGMAS * SIGMAS * variance;
        let ranges = self.models.iter().filter_map(|model| model.range(rate, limit));
        let hull = |[low, high]: [f64; 2], [from, to]: [f64; 2]| [low.min(from), high.max(to)];
        let [low, high] = ranges.fold([f64::INFINITY, 0.0], hull);
        let low = low.min(high);
        let likely: Vec<&Model> = self.models.iter().filter(|model| model.best.chi2 <= limit).collect();
        let (mut weights, mut sum) = (0.0, 0.0);
        for point in 0..=MEAN_POINTS {
            let given = low + (high - low) * point as f64 / MEAN_POINTS as f64;
            let chi2 = likely.iter().map(|model| model.least(rate, given).chi2).fold(f64::INFINITY, f64::min);
            let weight = (-(chi2 - least) / (2.0 * variance)).exp();
            weights += weight;
            sum += weight * given;
        }
        let with_both = if weights > 0.0 { sum / weights } else { low };
        let alone = match rate {
            Rate::Leak => causes.leak_alone * self.straight[1],
            Rate::Outgassing => causes.outgassing_alone * causes.outgassing,
        };
        // Digits limit a slope too: they do not average out over the samples.
        let digits = SIGMAS * LEAST_NOISE * self.straight[1].abs();
        Interval {
            mean: (alone + causes.both * with_both).clamp(low, high),
            low: (low - digits).max(0.0),
            high: high + digits,
        }
    }

    /// The probabilities of a leak alone, outgassing alone and both, by the Bayesian information criterion. A rate that is not
    /// below zero would be too small on average if both were always taken as present, because the other one takes a share of it.
    fn causes(&self, least: f64, variance: f64) -> Causes {
        let each = (self.samples.len() as f64).ln();
        let weight = |chi2: f64, numbers: f64| (-(chi2 - least) / (2.0 * variance) - numbers * each / 2.0).exp();
        let numbers = |model: &Model| if model.slowing.tau_s.is_some() { 2.0 } else { 0.0 };
        let leak_alone = if self.straight[1] > 0.0 { weight(self.straight[2], 0.0) } else { 0.0 };
        let (mut both, mut outgassing_alone, mut outgassing) = (0.0, 0.0, 0.0);
        for model in &self.models {
            let without = model.least(Rate::Leak, 0.0);
            both = f64::max(both, weight(model.best.chi2, numbers(model) + 1.0));
            let found = weight(without.chi2, numbers(model));
            if found > outgassing_alone {
                (outgassing_alone, outgassing) = (found, without.vector[2] + without.vector[3]);
            }
        }
        let sum = leak_alone + outgassing_alone + both;
        Causes { leak_alone: leak_alone / sum, outgassing_alone: outgassing_alone / sum, both: both / sum, outgassing }
    }

    /// The probabilities of the shapes by the Bayesian information criterion: 2, 3 and 5 numbers.
    fn shapes(&self, least: f64, variance: f64) -> Shapes {
        let each = (self.samples.len() as f64).ln();
        let weight = |chi2: f64, numbers: f64| (-(chi2 - least) / (2.0 * variance) - numbers * each / 2.0).exp();
        let of = |returns: bool| {
            let models = self.models.iter().filter(|model| model.slowing.tau_s.is_some() == returns);
            models.map(|model| model.best.chi2).fold(f64::INFINITY, f64::min)
        };
        let weights = [weight(self.straight[2], 0.0), weight(of(false), 1.0), weight(of(true), 3.0)];
        let sum: f64 = weights.iter().sum();
        let [straight, inverse_time, saturating] = weights.map(|weight| weight / sum);
        Shapes { straight, inverse_time, saturating }
    }
}

/// The cause of a rise with a total rate at its start and a mean slope. A leak lasts, so it counts beside the mean slope; outgassing
/// is given at the start, so it counts beside the rate there.
fn cause(total: &Interval, slope: f64, leak: &Interval, outgassing: &Interval) -> Cause {
    if total.low <= 0.0 {
        return Cause::NoRise;
    }
    match (leak.low > SMALL * slope, outgassing.low > SMALL * total.mean) {
        (true, true) => Cause::Both,
        (true, false) => Cause::Leak,
        (false, true) => Cause::Outgassing,
        (false, false) => Cause::Undistinguished,
    }
}
