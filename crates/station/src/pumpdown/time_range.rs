//! Time ranges.

use profivac_recorder::Micros;

/// The time from `start` to `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeRange {
    /// The beginning.
    pub start: Micros,
    /// The end.
    pub end: Micros,
}

impl TimeRange {
    /// The length in seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        seconds(self.start, self.end)
    }

    /// Whether the two ranges have a time in common.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.start < other.end && other.start < self.end
    }
}

/// The time from one moment to another, in seconds.
#[must_use]
pub fn seconds(from: Micros, to: Micros) -> f64 {
    to.0.saturating_sub(from.0) as f64 / Micros::SECOND as f64
}
