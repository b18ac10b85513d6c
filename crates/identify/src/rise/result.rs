//! Intervals, causes and shapes from all fits of a record.

use super::model::{Model, Rate};
use super::noise::LEAST_NOISE;
use super::{Cause, Flow, Rise, RiseSetup, Shapes};
use crate::interval::{Interval, SIGMAS};
use profivac_vacuum::gas::Gas;

/// The number of points of the profile for the mean.
const MEAN_POINTS: usize = 64;

/// A quantity is stated as present if its lower bound is above this part of the rise. chosen
const SMALL: f64 = 0.1;

/// The probabilities of the causes, and the outgassing without a leak in Pa/s.
struct Causes {
    leak_alone: f64,
    outgassing_alone: f64,
    both: f64,
    outgassing: f64,
}

/// A record with all its fits.
pub(super) struct Record<'a> {
    pub samples: &'a [(f64, f64, f64)],
    pub first: f64,
    pub straight: [f64; 3],
    pub models: Vec<Model>,
}

impl Record<'_> {
    pub fn result(&self, setup: &RiseSetup) -> Rise {
        let [start, slope, line] = self.straight;
        let by_sum = |one: &&Model, two: &&Model| one.best.chi2.total_cmp(&two.best.chi2);
        let best = self.models.iter().min_by(by_sum);
        let least = best.map_or(line, |model| model.best.chi2);
        let misfit = (least.max(0.0) / self.samples.len().saturating_sub(4).max(1) as f64).sqrt();
        // A fit that misses more than the noise has larger uncertainties.
        let variance = misfit.powi(2).max(1.0);
        let causes = self.causes(least.min(line), variance);
        let [leak, outgassing, total] =
            [Rate::Leak, Rate::Outgassing, Rate::Total].map(|rate| self.interval(rate, least, variance, &causes));
        let shapes = self.shapes(least.min(line), variance);
        let saturating = self.models.iter().filter(|model| model.slowing.tau_s.is_some()).min_by(by_sum);
        let flow = |interval: Interval, factor: f64| Flow {
            pa_m3_per_s: interval.scaled(setup.volume_m3 * factor).widened(setup.gauge_uncertainty),
            gas_k: setup.gas_k,
        };
        let [air, walls] = [Gas::Air, setup.outgassed].map(|gas| setup.gauge.factor(gas));
        let fitted = self.samples.iter().enumerate().map(|(index, (t, ..))| {
            let more = best.map_or(0.0, |model| model.at(index, *t));
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
        let leak_alone = causes.leak_alone * self.straight[1];
        let outgassing_alone = causes.outgassing_alone * causes.outgassing;
        let alone = match rate {
            Rate::Leak => leak_alone,
            Rate::Outgassing => outgassing_alone,
            Rate::Total => leak_alone + outgassing_alone,
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
