//! The levels of stored summaries: for each span of time the lowest and highest pressure, their geometric mean and the qualities that
//! occurred; [`PointSummary`](super::point::PointSummary) is the summary of a point.
//!
//! A span of a level is twelve to fifteen times as long as one of the level below, so a trend reads at most fifteen rows per pixel.

use super::recorded::{Recorded, Summarise};
use super::sample::{Micros, Sample};
pub use super::summary::Summary;
use std::collections::BTreeMap;

/// A level of spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// Its number in the database.
    pub number: u8,
    /// The length of a span in seconds.
    pub seconds: i64,
}

/// All levels, the finest first.
pub const LEVELS: [Level; 4] = [
    Level { number: 1, seconds: 10 },
    Level { number: 2, seconds: 120 },
    Level { number: 3, seconds: 1_800 },
    Level { number: 4, seconds: 21_600 },
];

impl Level {
    /// The length of a span in microseconds.
    #[must_use]
    pub const fn micros(self) -> i64 {
        self.seconds.saturating_mul(Micros::SECOND)
    }

    /// The start of the span that contains `at`.
    #[must_use]
    pub const fn start(self, at: Micros) -> Micros {
        Micros(at.0.saturating_sub(at.0.rem_euclid(self.micros())))
    }

    /// The coarsest level whose spans are not longer than `micros`; `None` if even the finest ones are longer.
    #[must_use]
    pub fn coarsest_within(micros: i64) -> Option<Self> {
        LEVELS.into_iter().rev().find(|level| level.micros() <= micros)
    }
}

/// Identifies a span of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SpanKey {
    /// The number of the level.
    pub level: u8,
    /// The index of the series.
    pub series: usize,
    /// The start of the span.
    pub start: Micros,
}

/// Summaries to be added to the database: of pressures, or of values of points.
#[derive(Clone, Debug)]
pub struct PendingSpans<T: Recorded = Sample>(BTreeMap<SpanKey, T::Summary>);

impl<T: Recorded> Default for PendingSpans<T> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<T: Recorded> PendingSpans<T> {
    /// Adds a sample to its span of each level.
    pub fn add(&mut self, series: usize, sample: &T) {
        let summary = sample.summary();
        for level in LEVELS {
            let key = SpanKey { level: level.number, series, start: level.start(sample.at()) };
            self.0.entry(key).or_default().add(&summary);
        }
    }

    /// All spans.
    pub fn iter(&self) -> impl Iterator<Item = (&SpanKey, &T::Summary)> {
        self.0.iter()
    }

    /// The number of spans.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are no spans.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Removes all spans, after they were written.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::super::quality::Quality;
    use super::*;

    fn at(second: i64, pa: f64) -> Sample {
        Sample::new(Micros(second * Micros::SECOND), Some(pa), Quality::Valid)
    }

    #[test]
    fn a_sample_is_added_to_every_level() {
        let mut additions = PendingSpans::default();
        additions.add(7, &at(21_599, 1.0));
        additions.add(7, &at(21_600, 1.0));
        let starts: Vec<_> = additions.iter().map(|(key, _)| (key.level, key.start.0 / Micros::SECOND)).collect();
        let expected =
            [(1, 21_590), (1, 21_600), (2, 21_480), (2, 21_600), (3, 19_800), (3, 21_600), (4, 0), (4, 21_600)];
        assert_eq!(starts, expected);
    }

    #[test]
    fn a_span_before_1970_starts_before_it_ends() {
        assert_eq!(LEVELS[0].start(Micros(-1)), Micros(-10 * Micros::SECOND));
    }

    #[test]
    fn a_trend_uses_the_coarsest_level_that_is_fine_enough() {
        let level = |seconds: i64| Level::coarsest_within(seconds * Micros::SECOND).map(|level| level.number);
        assert_eq!(
            [level(9), level(10), level(119), level(120), level(15_768), level(100_000)],
            [None, Some(1), Some(1), Some(2), Some(3), Some(4)]
        );
    }
}
