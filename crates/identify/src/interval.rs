//! A value with its uncertainty.

/// A value with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The best value, or the mean of all values that the data allow.
    pub mean: f64,
    /// The lower bound.
    pub low: f64,
    /// The upper bound.
    pub high: f64,
}

/// Standard deviations on either side of a 95 % interval.
pub(crate) const SIGMAS: f64 = 1.96;

/// The standard uncertainty of a gauge whose manual states limits of ± `accuracy`: any deviation within is equally likely, so the
/// limits are divided by √3 (JCGM 100:2008, GUM, 4.3.7).
#[must_use]
pub fn standard_uncertainty(accuracy: f64) -> f64 {
    accuracy / 3_f64.sqrt()
}

impl Interval {
    /// The interval of a normal distribution.
    #[must_use]
    pub const fn normal(mean: f64, deviation: f64) -> Self {
        Self { mean, low: mean - SIGMAS * deviation, high: mean + SIGMAS * deviation }
    }

    /// All three numbers times a factor above zero.
    #[must_use]
    pub const fn scaled(self, factor: f64) -> Self {
        Self { mean: self.mean * factor, low: self.low * factor, high: self.high * factor }
    }

    /// The interval with a further relative standard uncertainty of the value. Above the mean it is a fraction of the upper bound:
    /// the mean of a bound from one side is near zero, and the value may still be as large as the bound.
    #[must_use]
    pub fn widened(self, relative: f64) -> Self {
        let further = SIGMAS * relative;
        let low = self.mean - (self.mean - self.low).hypot(further * self.mean);
        let high = self.mean + (self.high - self.mean).hypot(further * self.high);
        Self { low: if self.low >= 0.0 { low.max(0.0) } else { low }, high, ..self }
    }

    /// Whether it contains a value.
    #[must_use]
    pub const fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_further_uncertainty_widens_and_does_not_pass_zero() {
        let wide = Interval { mean: 10.0, low: 7.0, high: 12.5 }.widened(4.0 / 19.6);
        assert!((wide.low - 5.0).abs() < 1e-9 && (wide.high - (10.0 + 2.5_f64.hypot(5.0))).abs() < 1e-9, "{wide:?}");
        assert_eq!(Interval { mean: 10.0, low: 0.0, high: 20.0 }.widened(1.0).low, 0.0);
        assert!(wide.contains(5.1) && !wide.contains(15.7));
    }

    #[test]
    fn an_upper_bound_widens_although_its_mean_is_near_zero() {
        let bound = Interval { mean: 0.1, low: 0.0, high: 10.0 }.widened(standard_uncertainty(0.15));
        assert!(bound.high > 10.1 && bound.high < 11.5, "{bound:?}");
    }
}
