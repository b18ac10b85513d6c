//! Numbers with their derivatives by the unknowns of a fit (forward automatic differentiation; docs/decisions, 190).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number with which the model of a plant can be calculated: an `f64`, or one with its derivatives.
pub(super) trait Number:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    fn value(self) -> f64;

    /// The value of a function of some numbers, with its derivative by each of them (the chain rule).
    fn chained<const COUNT: usize>(value: f64, parts: [(f64, &Self); COUNT]) -> Self;

    #[inline]
    fn exp(self) -> Self {
        let value = self.value().exp();
        Self::chained(value, [(value, &self)])
    }

    /// The number, or a constant that is larger. Not a number counts as smaller, as in `f64::max`.
    #[inline]
    fn at_least(self, least: f64) -> Self {
        if self.value() > least { self } else { Self::from(least) }
    }

    /// The smaller one of both.
    #[inline]
    fn smaller(self, other: Self) -> Self {
        if other.value() < self.value() { other } else { self }
    }
}

impl Number for f64 {
    #[inline]
    fn value(self) -> f64 {
        self
    }

    #[inline]
    fn chained<const COUNT: usize>(value: f64, _: [(f64, &Self); COUNT]) -> Self {
        value
    }
}

/// A number with its derivatives by `COUNT` others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dual<const COUNT: usize> {
    value: f64,
    slopes: [f64; COUNT],
}

impl<const COUNT: usize> Dual<COUNT> {
    /// One of the numbers by which derivatives are taken: that by itself is 1.
    pub fn unknown(value: f64, place: usize) -> Self {
        Self { value, slopes: std::array::from_fn(|other| f64::from(u8::from(other == place))) }
    }

    pub const fn slopes(&self) -> &[f64; COUNT] {
        &self.slopes
    }
}

impl<const COUNT: usize> Number for Dual<COUNT> {
    #[inline]
    fn value(self) -> f64 {
        self.value
    }

    #[inline]
    fn chained<const PARTS: usize>(value: f64, parts: [(f64, &Self); PARTS]) -> Self {
        let mut slopes = [0.0; COUNT];
        for (by, part) in parts {
            for (slope, other) in slopes.iter_mut().zip(&part.slopes) {
                *slope += by * other;
            }
        }
        Self { value, slopes }
    }
}

impl<const COUNT: usize> From<f64> for Dual<COUNT> {
    #[inline]
    fn from(value: f64) -> Self {
        Self { value, slopes: [0.0; COUNT] }
    }
}

impl<const COUNT: usize> Add for Dual<COUNT> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self::chained(self.value + other.value, [(1.0, &self), (1.0, &other)])
    }
}

impl<const COUNT: usize> Sub for Dual<COUNT> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::chained(self.value - other.value, [(1.0, &self), (-1.0, &other)])
    }
}

impl<const COUNT: usize> Mul for Dual<COUNT> {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        Self::chained(self.value * other.value, [(other.value, &self), (self.value, &other)])
    }
}

impl<const COUNT: usize> Mul<f64> for Dual<COUNT> {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self::chained(self.value * factor, [(factor, &self)])
    }
}

impl<const COUNT: usize> Div for Dual<COUNT> {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self::chained(value, [(other.value.recip(), &self), (-value / other.value, &other)])
    }
}

impl<const COUNT: usize> Neg for Dual<COUNT> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self::chained(-self.value, [(-1.0, &self)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: Dual<2>, value: f64, slopes: [f64; 2]) {
        let all = [(found.value(), value), (found.slopes()[0], slopes[0]), (found.slopes()[1], slopes[1])];
        assert!(all.iter().all(|(found, expected)| (found - expected).abs() < 1e-15), "{found:?}: {all:?}");
    }

    #[test]
    fn each_operation_has_its_derivatives() {
        let [x, y] = [Dual::unknown(0.5, 0), Dual::unknown(0.25, 1)];
        close(x + y, 0.75, [1.0, 1.0]);
        close(x - y, 0.25, [1.0, -1.0]);
        close(x * y, 0.125, [0.25, 0.5]);
        close(x / y, 2.0, [4.0, -8.0]);
        close(-x * 3.0, -1.5, [-3.0, 0.0]);
        close(y.exp(), 0.25_f64.exp(), [0.0, 0.25_f64.exp()]);
        close(Dual::from(2.0) * x, 1.0, [2.0, 0.0]);
    }

    /// A number at a bound does not change with the unknowns.
    #[test]
    fn the_larger_and_the_smaller_number_bring_their_derivatives() {
        let [x, y] = [Dual::unknown(0.5, 0), Dual::unknown(0.25, 1)];
        close(x.at_least(0.4), 0.5, [1.0, 0.0]);
        close(x.at_least(0.6), 0.6, [0.0, 0.0]);
        close(x.smaller(y), 0.25, [0.0, 1.0]);
        close(y.smaller(x), 0.25, [0.0, 1.0]);
        close(Dual::from(f64::NAN).at_least(0.1), 0.1, [0.0, 0.0]);
    }
}
