//! The numbers that a key of the file accepts.

use std::fmt;

/// The numbers that a key accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NumberRange {
    /// From the first to the second number.
    Between(f64, f64),
    /// Above 0, and at most this number.
    AboveZero(f64),
}

impl NumberRange {
    /// Whether the key accepts this number.
    #[must_use]
    pub fn contains(self, number: f64) -> bool {
        match self {
            Self::Between(least, most) => (least..=most).contains(&number),
            Self::AboveZero(most) => number > 0.0 && number <= most,
        }
    }
}

impl fmt::Display for NumberRange {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Between(least, most) => write!(formatter, "from {least} to {most}"),
            Self::AboveZero(most) => write!(formatter, "above 0 to {most}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_a_range_are_in_it_and_zero_is_not_above_zero() {
        let range = NumberRange::Between(0.0, 10.0);
        assert_eq!(
            [-0.1, 0.0, 10.0, 10.1, f64::NAN].map(|number| range.contains(number)),
            [false, true, true, false, false]
        );
        let range = NumberRange::AboveZero(10.0);
        assert_eq!(
            [0.0, 1e-9, 10.0, 10.1, f64::NAN].map(|number| range.contains(number)),
            [false, true, true, false, false]
        );
        assert_eq!(NumberRange::Between(1.0, 1e6).to_string(), "from 1 to 1000000");
        assert_eq!(NumberRange::AboveZero(10.0).to_string(), "above 0 to 10");
    }
}
