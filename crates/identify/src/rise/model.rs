//! The fit of one way of slowing down, for a given leak or outgassing.

use super::slowing::{Slowing, TAU_STEPS, TAUS, saturating};
use crate::profile::{Least, Sums, TIME, crossing, minimise};
use nalgebra::Vector4;

/// How often the step of the time constants is reduced to its root around the best one.
const REFINEMENTS: usize = 6;

/// The fit of one way of slowing down.
pub(super) struct Model {
    pub slowing: Slowing,
    sums: Sums,
    /// The slope of the straight line, in Pa/s, and the largest leak or outgassing to be tried.
    slope: f64,
    most: f64,
    /// The leak of the best fit in Pa/s, and the fit.
    pub leak: f64,
    pub best: Least,
}

/// One of the two rates, or both together when the valve closes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Rate {
    Leak,
    Outgassing,
    Total,
}

impl Model {
    pub fn new(samples: &[(f64, f64, f64)], [start, slope, _]: [f64; 3], slowing: Slowing) -> Self {
        let rows = samples
            .iter()
            .enumerate()
            .map(|(index, (t, p, weight))| (slowing.row(index, *t), p - start - slope * t, *weight));
        let sums = Sums::new(rows);
        // Outgassing slows down, so it begins with more than the mean slope; a hundred times is beyond every tau.
        let most = 100.0 * slope.abs();
        let mut model = Self { sums, slope, most, leak: 0.0, best: Least::none(), slowing };
        model.leak = minimise(model.most, |leak| model.least(Rate::Leak, leak).chi2);
        model.best = model.least(Rate::Leak, model.leak);
        model
    }

    /// The best fit with one rate given, in Pa/s.
    pub fn least(&self, rate: Rate, given: f64) -> Least {
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
            Rate::Total => {
                // Outgassing is a part of the rate that slows down; that it may be two parts of all of it only widens an interval.
                let others = if has_other { given } else { 0.0 };
                self.sums.least(time * (given - self.slope), [(water - time, given), (other - time, others)])
            }
        }
    }

    /// The outgassing of the best fit, in Pa/s.
    pub fn outgassing(&self) -> f64 {
        self.best.vector[2] + self.best.vector[3]
    }

    /// The range of a rate with a sum of squares up to a limit.
    pub fn range(&self, rate: Rate, limit: f64) -> Option<[f64; 2]> {
        if self.best.chi2 > limit {
            return None;
        }
        let within = match rate {
            Rate::Leak => self.leak,
            Rate::Outgassing => self.outgassing(),
            Rate::Total => self.leak + self.outgassing(),
        };
        Some([0.0, self.most].map(|bound| crossing(within, bound, limit, |given| self.least(rate, given).chi2)))
    }

    /// The pressure above the straight line at a sample, in Pa.
    pub fn at(&self, index: usize, t: f64) -> f64 {
        self.slowing.row(index, t).dot(&self.best.vector)
    }
}

impl Least {
    fn none() -> Self {
        Self { chi2: f64::INFINITY, vector: Vector4::zeros() }
    }
}

/// Adds models between the steps of the grid of time constants around the best one for a time of pumping: a long record is
/// sensitive to its time constant.
pub(super) fn refine(models: &mut Vec<Model>, samples: &[(f64, f64, f64)], straight: [f64; 3], start_s: f64) {
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
