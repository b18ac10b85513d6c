//! Profiles of a least-squares sum over one of its numbers, with the others not below zero.
//!
//! A rise is `p = p_straight + d0 + s t + x lag1 + y lag2`. The sum of squares is quadratic in these four, so it is known from
//! ten sums over the samples. Its minimum with bounds on x and y is found by trying every combination of free and bounded numbers.

use nalgebra::{DMatrix, DVector, Matrix4, Vector4};

/// The sums of a record for one way of slowing down, relative to a straight line.
#[derive(Clone, Debug)]
pub(crate) struct Sums {
    normal: Matrix4<f64>,
    right: Vector4<f64>,
    square: f64,
}

/// The constant, the time, and two lags as vectors of the space of [`Sums`].
pub(crate) const TIME: [f64; 4] = [0.0, 1.0, 0.0, 0.0];
const CONSTANT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// A sum of squares with the numbers that minimise it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Least {
    pub chi2: f64,
    pub vector: Vector4<f64>,
}

/// A direction with the upper bound of its number; the lower one is 0.
pub(crate) type Bounded = (Vector4<f64>, f64);

impl Sums {
    /// The sums of rows with the residual from the straight line and its weight.
    pub fn new(rows: impl Iterator<Item = (Vector4<f64>, f64, f64)>) -> Self {
        let mut sums = Self { normal: Matrix4::zeros(), right: Vector4::zeros(), square: 0.0 };
        for (row, residual, weight) in rows {
            let row = row * weight;
            sums.normal += row * row.transpose();
            sums.right += row * (residual * weight);
            sums.square += (residual * weight).powi(2);
        }
        sums
    }

    fn at(&self, vector: Vector4<f64>) -> Least {
        let chi2 = self.square - 2.0 * self.right.dot(&vector) + vector.dot(&(self.normal * vector));
        Least { chi2, vector }
    }

    /// The least sum with a fixed vector, a free constant, and two bounded numbers.
    pub fn least(&self, fixed: Vector4<f64>, bounded: [Bounded; 2]) -> Least {
        let [first, second] = bounded.map(|bounded| choices(&bounded));
        let mut best = Least { chi2: f64::INFINITY, vector: fixed };
        for one in &first {
            for other in &second {
                let found = self.with(fixed, [*one, *other]);
                if let Some(found) = found.filter(|found| found.chi2 < best.chi2) {
                    best = found;
                }
            }
        }
        best
    }

    /// The least sum where each number is free or at a bound; `None` if a free one leaves its bounds.
    fn with(&self, fixed: Vector4<f64>, numbers: [Choice; 2]) -> Option<Least> {
        let mut start = fixed;
        let mut free = vec![(Vector4::from(CONSTANT), f64::NEG_INFINITY, f64::INFINITY)];
        for number in numbers {
            match number {
                Choice::Fixed(part) => start += part,
                Choice::Free(direction, most) => free.push((direction, 0.0, most)),
            }
        }
        let gradient = self.right - self.normal * start;
        let size = free.len();
        // Directions of the same size keep the elimination accurate.
        let scales: Vec<f64> =
            free.iter().map(|(direction, ..)| direction.dot(&(self.normal * direction)).sqrt()).collect();
        let product = |row: usize, column: usize| {
            let normal = self.normal * free[column].0;
            free[row].0.dot(&normal) / scales[row] / scales[column]
        };
        let matrix = DMatrix::from_fn(size, size, product);
        let right = DVector::from_fn(size, |row, _| free[row].0.dot(&gradient) / scales[row]);
        let solution = matrix.cholesky()?.solve(&right);
        let mut vector = start;
        for ((direction, least, most), (value, scale)) in free.iter().zip(solution.iter().zip(&scales)) {
            let value = value / scale;
            if !value.is_finite() || value < *least || value > *most {
                return None;
            }
            vector += direction * value;
        }
        Some(self.at(vector))
    }
}

#[derive(Clone, Copy)]
enum Choice {
    /// A fixed part of the vector.
    Fixed(Vector4<f64>),
    /// A direction with the upper bound of its number.
    Free(Vector4<f64>, f64),
}

fn choices((direction, most): &Bounded) -> Vec<Choice> {
    let mut all = vec![Choice::Fixed(Vector4::zeros())];
    if *most > 0.0 {
        all.push(Choice::Free(*direction, *most));
    }
    if *most > 0.0 && most.is_finite() {
        all.push(Choice::Fixed(direction * *most));
    }
    all
}

/// The number from 0 to `most` with the least value of a convex function (golden section).
pub(crate) fn minimise(most: f64, value: impl Fn(f64) -> f64) -> f64 {
    const PART: f64 = 0.618_033_988_749_895;
    let (mut low, mut high) = (0.0, most);
    let (mut left, mut right) = (most * (1.0 - PART), most * PART);
    let (mut at_left, mut at_right) = (value(left), value(right));
    for _ in 0..60 {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - PART * (high - low);
            at_left = value(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + PART * (high - low);
            at_right = value(right);
        }
    }
    let inside = f64::midpoint(low, high);
    let ends = [0.0, inside, most];
    ends.into_iter().min_by(|one, other| value(*one).total_cmp(&value(*other))).unwrap_or(inside)
}

/// Where a convex function reaches a limit on the way from a number within to a bound; the bound if it stays below.
pub(crate) fn crossing(within: f64, bound: f64, limit: f64, value: impl Fn(f64) -> f64) -> f64 {
    if value(bound) <= limit {
        return bound;
    }
    let (mut inside, mut outside) = (within, bound);
    for _ in 0..50 {
        let middle = f64::midpoint(inside, outside);
        if value(middle) <= limit { inside = middle } else { outside = middle }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_sum_respects_the_bounds() {
        // y = 1 + 2 t - 3 lag, so a lag that must not be negative is 0, and the time takes its share.
        let row = |t: f64| Vector4::new(1.0, t, -t * t, 0.0);
        let rows = (0..20).map(|k| f64::from(k) / 10.0).map(|t| (row(t), 1.0 + 2.0 * t + 3.0 * t * t, 1.0));
        let sums = Sums::new(rows);
        let lag = Vector4::new(0.0, 0.0, 1.0, 0.0);
        let bounded = sums.least(Vector4::zeros(), [(Vector4::from(TIME), f64::INFINITY), (lag, f64::INFINITY)]);
        assert_eq!(bounded.vector[2], 0.0);
        assert!(bounded.chi2 > 1.0);
        let free = sums.least(Vector4::zeros(), [(Vector4::from(TIME), f64::INFINITY), (-lag, f64::INFINITY)]);
        assert!(free.chi2 < 1e-9 && (free.vector[2] + 3.0).abs() < 1e-6, "{free:?}");
        let limited = sums.least(Vector4::zeros(), [(Vector4::from(TIME), f64::INFINITY), (-lag, 1.0)]);
        assert!((limited.vector[2] + 1.0).abs() < 1e-9, "{limited:?}");
    }

    #[test]
    fn a_convex_function_is_minimised_and_crossed() {
        let parabola = |x: f64| (x - 3.0).powi(2);
        assert!((minimise(10.0, parabola) - 3.0).abs() < 1e-6);
        assert_eq!(minimise(2.0, parabola), 2.0);
        assert!((crossing(3.0, 10.0, 4.0, parabola) - 5.0).abs() < 1e-9);
        assert_eq!(crossing(3.0, 4.0, 4.0, parabola), 4.0);
    }
}
