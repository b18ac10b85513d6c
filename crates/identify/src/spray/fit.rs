//! The shape of helium at a leak, by least squares: three numbers by a grid that shrinks, four by the normal equations.

use super::Spray;
use crate::interval::{Interval, SIGMAS};
use crate::rise::noise::grouped;
use nalgebra::{DMatrix, Matrix4, SVector, Vector4};

/// The least relative noise: the deadband of a recorder changes a record by up to half a percent. chosen
const LEAST_NOISE: f64 = 0.002;

/// Points of the grid for each number, how often it shrinks, and by what. chosen
const GRID: i32 = 2;
const SHRINKS: usize = 18;
const SHRINK: f64 = 0.65;

/// The fewest points before the change, during it, and after it.
const LEAST_POINTS: usize = 4;

/// An indication that is not watched for this many time constants after the gas has gone has not returned. chosen
const WATCHED: f64 = 2.0;

/// A point: time, pressure divided by the base, weight.
type Point = (f64, f64, f64);

/// Where a shape is searched.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub from_s: f64,
    /// When the indication leaves its course, and when it has nearly returned.
    pub leaves_s: f64,
    pub returns_s: f64,
    pub to_s: f64,
    /// The uncertainty of both times.
    pub step_s: f64,
}

/// The shape within 0 and 1: times and the logarithm of the time constant.
#[derive(Clone, Copy, Debug)]
struct Shape {
    from_s: f64,
    to_s: f64,
    ln_tau: f64,
}

impl Shape {
    fn at(self, t: f64) -> f64 {
        let tau = self.ln_tau.exp();
        let approached = |seconds: f64| -(-seconds.max(0.0) / tau).exp_m1();
        approached(t.min(self.to_s) - self.from_s) * (-(t - self.to_s).max(0.0) / tau).exp()
    }

    fn changed(self, index: usize, by: f64) -> Self {
        let mut changed = [self.from_s, self.to_s, self.ln_tau];
        changed.iter_mut().skip(index).take(1).for_each(|number| *number += by);
        let [from_s, to_s, ln_tau] = changed;
        Self { from_s, to_s, ln_tau }
    }
}

/// A fit of the four linear numbers: base, slope, curvature, change; and the sum of squares.
struct Fitted {
    numbers: Vector4<f64>,
    squares: f64,
}

struct Problem {
    points: Vec<Point>,
    middle_s: f64,
    half_s: f64,
}

impl Problem {
    fn basis(&self, shape: Shape, t: f64) -> [f64; 4] {
        let x = (t - self.middle_s) / self.half_s;
        [1.0, x, x * x, shape.at(t)]
    }

    fn fitted(&self, shape: Shape) -> Option<Fitted> {
        let (mut matrix, mut right) = (Matrix4::zeros(), Vector4::zeros());
        for (t, y, weight) in &self.points {
            let row = SVector::from(self.basis(shape, *t)) * *weight;
            matrix += row * row.transpose();
            right += row * (y * weight);
        }
        let numbers = matrix.cholesky()?.solve(&right);
        let squares = self.points.iter().map(|(t, y, weight)| {
            let row = SVector::from(self.basis(shape, *t));
            ((y - row.dot(&numbers)) * weight).powi(2)
        });
        Some(Fitted { numbers, squares: squares.sum() })
    }

    /// The best shape near the times of the window, with time constants up to the length of the change.
    fn best(&self, window: &Window, shortest_s: f64) -> Option<(Shape, Fitted)> {
        let length = window.returns_s - window.leaves_s;
        let (least, most) = (shortest_s.ln(), (2.0 * length).max(2.0 * shortest_s).ln());
        let middle = Shape {
            from_s: window.leaves_s - window.step_s,
            to_s: window.leaves_s + 0.6 * length,
            ln_tau: f64::midpoint(least, most),
        };
        let mut reach = [3.0 * window.step_s + 0.2 * length, 0.6 * length + window.step_s, 0.5 * (most - least)];
        let mut best: Option<(Shape, Fitted)> = None;
        for _ in 0..SHRINKS {
            let centre = best.as_ref().map_or(middle, |(shape, _)| *shape);
            for (i, j, k) in places() {
                let by = |index: i32, reach: f64| f64::from(index) / f64::from(GRID) * reach;
                let shape = centre.changed(0, by(i, reach[0])).changed(1, by(j, reach[1])).changed(2, by(k, reach[2]));
                let shape = Shape { ln_tau: shape.ln_tau.clamp(least, most), ..shape };
                if shape.to_s <= shape.from_s {
                    continue;
                }
                let Some(fitted) = self.fitted(shape) else { continue };
                if best.as_ref().is_none_or(|(_, known)| fitted.squares < known.squares) {
                    best = Some((shape, fitted));
                }
            }
            reach = reach.map(|one| one * SHRINK);
        }
        best
    }

    /// The standard deviations of change, times and logarithm of the time constant, for residuals as large as the noise. Without
    /// the last one the time constant is fixed.
    fn deviations(&self, shape: Shape, change: f64, is_slow: bool) -> Option<[f64; 4]> {
        let count = if is_slow { 7 } else { 4 };
        let tau = shape.ln_tau.exp();
        let steps = [0.01 * tau, 0.01 * tau, 0.01];
        let rows = DMatrix::from_fn(self.points.len(), count, |row, column| {
            let Some((t, _, weight)) = self.points.get(row) else { return 0.0 };
            let value = match column.checked_sub(4).and_then(|index| Some((index, steps.get(index)?))) {
                None => self.basis(shape, *t).get(column).copied().unwrap_or_default(),
                Some((index, step)) => {
                    let [more, less] = [*step, -step].map(|by| shape.changed(index, by).at(*t));
                    change * (more - less) / (2.0 * step)
                }
            };
            value * weight
        });
        let covariance = (rows.transpose() * rows).try_inverse()?;
        let deviation = |index: usize| covariance.get((index, index)).copied().unwrap_or_default().max(0.0).sqrt();
        Some([3, 4, 5, 6].map(deviation))
    }
}

fn places() -> impl Iterator<Item = (i32, i32, i32)> {
    let all = || -GRID..=GRID;
    all().flat_map(move |i| all().flat_map(move |j| all().map(move |k| (i, j, k))))
}

/// The shape within a window; `None` if the window has too few samples.
pub(super) fn fit(samples: &[(f64, f64)], window: &Window) -> Option<Spray> {
    let first = samples.partition_point(|(t, _)| *t < window.from_s);
    let end = samples.partition_point(|(t, _)| *t <= window.to_s);
    let inside = samples.get(first..end)?;
    if inside.len() < 3 * LEAST_POINTS {
        return None;
    }
    let base = inside.first()?.1;
    let scaled: Vec<(f64, f64)> = inside.iter().map(|(t, pa)| (*t, pa / base)).collect();
    let noise = noise(&scaled).max(LEAST_NOISE);
    let means = grouped(&scaled);
    let size = (inside.len() as f64 / means.len() as f64).max(1.0);
    let weighted = |(t, y): &(f64, f64)| (*t, *y, size.sqrt() / (noise * y));
    let points: Vec<Point> = means.iter().map(weighted).collect();
    let (begin_s, end_s) = (points.first()?.0, points.last()?.0);
    let spacing_s = (end_s - begin_s) / (points.len().saturating_sub(1)) as f64;
    let problem = Problem { points, middle_s: f64::midpoint(begin_s, end_s), half_s: 0.5 * (end_s - begin_s) };
    let shortest_s = 0.3 * spacing_s;
    let (shape, fitted) = problem.best(window, shortest_s)?;
    spray(&problem, shape, &fitted, base, spacing_s)
}

/// The relative noise from second differences. Their median, because a change within a sample must not count as noise.
fn noise(samples: &[(f64, f64)]) -> f64 {
    let difference = |three: &[(f64, f64)]| {
        let [(t0, y0), (t1, y1), (t2, y2)] = three else { return None };
        let part = if t2 > t0 { (t1 - t0) / (t2 - t0) } else { 0.5 };
        let off = (y1 - y0 - (y2 - y0) * part).abs() / y1;
        Some(off / (1.0 + part * part + (1.0 - part) * (1.0 - part)).sqrt())
    };
    let mut all: Vec<f64> = samples.windows(3).filter_map(difference).collect();
    all.sort_by(f64::total_cmp);
    // The median of the absolute values of a normal distribution is 0.6745 standard deviations.
    all.get(all.len() / 2).map_or(0.0, |middle| middle / 0.6745)
}

/// The shape as a result, with intervals.
fn spray(problem: &Problem, shape: Shape, fitted: &Fitted, base: f64, spacing_s: f64) -> Option<Spray> {
    let count = |is_there: &dyn Fn(f64) -> bool| problem.points.iter().filter(|(t, ..)| is_there(*t)).count();
    let parts =
        [count(&|t| t < shape.from_s), count(&|t| t >= shape.from_s && t <= shape.to_s), count(&|t| t > shape.to_s)];
    if parts.iter().any(|points| *points < LEAST_POINTS) {
        return None;
    }
    let tau_s = shape.ln_tau.exp();
    if problem.points.last()?.0 - shape.to_s < WATCHED * tau_s {
        return None;
    }
    let freedom = (problem.points.len() as f64 - 7.0).max(1.0);
    let misfit = (fitted.squares / freedom).sqrt();
    // A time constant below the time between two samples has no derivative that the samples show.
    let is_slow = tau_s > spacing_s;
    let change = fitted.numbers[3];
    let [of_change, of_from, of_to, of_tau] =
        problem.deviations(shape, change, is_slow)?.map(|one| one * misfit.max(1.0));
    let tau = if is_slow {
        Interval { mean: tau_s, low: tau_s * (-SIGMAS * of_tau).exp(), high: tau_s * (SIGMAS * of_tau).exp() }
    } else {
        Interval { mean: tau_s, low: 0.0, high: 2.0 * spacing_s }
    };
    // Where between two samples the gas came is not known either; without derivatives both times lie within a sample or two.
    let between = spacing_s / 12_f64.sqrt();
    let time =
        |at: f64, deviation: f64| Interval::normal(at, if is_slow { deviation.hypot(between) } else { spacing_s });
    let plain = Shape { ln_tau: shape.ln_tau, from_s: f64::INFINITY, to_s: f64::INFINITY };
    let row = problem.basis(plain, f64::midpoint(shape.from_s, shape.to_s));
    let base_pa = base * row.iter().zip(fitted.numbers.iter()).take(3).map(|(one, two)| one * two).sum::<f64>();
    Some(Spray {
        from_s: time(shape.from_s, of_from),
        to_s: time(shape.to_s, of_to),
        tau_s: tau,
        change_pa: Interval::normal(change, of_change).scaled(base),
        base_pa,
        misfit,
    })
}
