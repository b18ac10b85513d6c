//! The interval of an unknown: all values for which the others can be chosen so that the record still fits (profile likelihood).
//!
//! The sum of squares may exceed its least by 1.96² times the variance (Venzon and Moolgavkar, Appl. Stat. 37 (1988) 87). Its root
//! is nearly a straight line of the distance, so a few steps find the bound.

use super::fit::{Problem, ROUGH, bounded};
use crate::interval::SIGMAS;
use nalgebra::{DMatrix, DVector};

/// The most steps to a bound, and how near the root of the sum has to come.
const STEPS: usize = 8;
const NEAR: f64 = 0.04;

/// An unknown that the record does not determine ends here, in its own numbers.
const FAR: f64 = 12.0;

/// A better fit that was found on the way: the least sum of squares was not the least.
pub(super) struct Better<'a>(pub f64, pub Box<Problem<'a>>);

/// The lower and the upper bound of an unknown, with all unknowns there.
pub(super) struct Bounds {
    pub low: DVector<f64>,
    pub high: DVector<f64>,
}

/// A fit with the covariance of its unknowns.
pub(super) struct Fitted<'a> {
    pub sum: f64,
    pub variance: f64,
    pub problem: Problem<'a>,
    pub covariance: DMatrix<f64>,
    /// By how much of the variance a sum may be below the least one before that counts as a better fit.
    pub slack: f64,
}

impl<'a> Fitted<'a> {
    /// The covariance from the derivatives. A weak prior keeps the variance of an unknown without effect finite.
    pub fn new(sum: f64, problem: Problem<'a>, slack: f64) -> Option<Self> {
        let all: Vec<usize> = (0..problem.unknowns.count()).collect();
        let freedom = problem.groups.len().saturating_sub(all.len()).max(1) as f64;
        let variance = (sum / freedom).max(1e-6);
        let matrix = problem.derivatives(&all);
        let mut normal = matrix.transpose() * &matrix / variance;
        for index in all {
            normal[(index, index)] += 1.0 / 9.0;
        }
        let covariance = normal.cholesky()?.inverse();
        Some(Self { sum, variance, problem, covariance, slack })
    }

    pub fn deviation(&self, index: usize) -> f64 {
        self.covariance[(index, index)].sqrt()
    }

    /// The bounds of an unknown.
    pub fn bounds(&self, index: usize) -> Result<Bounds, Better<'a>> {
        Ok(Bounds { low: self.bound(index, -1.0)?, high: self.bound(index, 1.0)? })
    }

    /// All unknowns where the one at `place` reaches its bound below (-1) or above (1).
    fn bound(&self, index: usize, side: f64) -> Result<DVector<f64>, Better<'a>> {
        let target = SIGMAS * self.variance.sqrt();
        let here = self.problem.values[index];
        let limit = bounded(index, here + side * FAR);
        let (mut inside, mut outside) = (0.0, (limit - here).abs());
        let mut found = self.problem.values.clone();
        let mut reached = false;
        let mut distance = (SIGMAS * self.deviation(index)).min(outside);
        for _ in 0..STEPS {
            if outside <= 0.0 || (self.problem.stopped)() {
                break;
            }
            let (sum, problem) = self.profile(index, here + side * distance, &found);
            if sum < self.sum - self.slack * self.variance {
                return Err(Better(sum, Box::new(Problem { free: self.all(), ..problem })));
            }
            let root = (sum - self.sum).max(0.0).sqrt();
            let is_limit = distance >= outside;
            if root <= target * (1.0 + NEAR) {
                found = problem.values;
                inside = distance;
                if is_limit || root >= target * (1.0 - NEAR) {
                    reached = true;
                    break;
                }
            } else {
                outside = distance;
            }
            let next = distance * (target / root.max(0.2 * target)).max(0.2);
            distance = if next <= inside || next >= outside && !is_limit {
                if outside.is_finite() { f64::midpoint(inside, outside) } else { next }
            } else {
                next.min(outside)
            };
        }
        // Without an end within the steps the interval is the wider one.
        if !reached && outside.is_finite() {
            found[index] = here + side * outside;
        }
        Ok(found)
    }

    fn all(&self) -> Vec<usize> {
        (0..self.problem.unknowns.count()).collect()
    }

    /// The least sum with one unknown given. The others begin where the covariance has them.
    fn profile(&self, index: usize, value: f64, near: &DVector<f64>) -> (f64, Problem<'a>) {
        let mut problem = self.problem.clone();
        let change = (value - near[index]) / self.covariance[(index, index)];
        problem.values = DVector::from_fn(near.len(), |other, _| {
            bounded(other, near[other] + (self.covariance[(other, index)] * change).clamp(-1.0, 1.0))
        });
        problem.values[index] = value;
        problem.free = self.all();
        problem.free.retain(|other| *other != index);
        let kept = problem.clone();
        problem.minimised(ROUGH).unwrap_or((f64::INFINITY, kept))
    }
}
