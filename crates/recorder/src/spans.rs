//! The levels of stored summaries: for each span of time the lowest and highest pressure, their geometric mean and the qualities that
//! occurred.
//!
//! A span of a level is twelve to fifteen times as long as one of the level below, so a trend reads at most fifteen rows per pixel.

use super::quality::Qualities;
use super::sample::{Micros, Sample};
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

/// The summary of a span.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// The lowest pressure in Pa.
    pub low: Option<f64>,
    /// The highest pressure in Pa.
    pub high: Option<f64>,
    /// The sum of the decimal logarithms of all pressures.
    pub decades: f64,
    /// The number of pressures.
    pub count: u32,
    /// The qualities that occurred.
    pub qualities: Qualities,
}

impl Summary {
    /// The summary of one sample.
    #[must_use]
    pub fn of(sample: &Sample) -> Self {
        Self {
            low: sample.pa,
            high: sample.pa,
            decades: sample.decades().unwrap_or(0.0),
            count: u32::from(sample.pa.is_some()),
            qualities: Qualities::of(sample.quality),
        }
    }

    /// Adds another summary.
    pub fn add(&mut self, other: &Self) {
        let lowest = |one: f64, two: f64| one.min(two);
        let highest = |one: f64, two: f64| one.max(two);
        self.low = merged(self.low, other.low, lowest);
        self.high = merged(self.high, other.high, highest);
        self.decades += other.decades;
        self.count = self.count.saturating_add(other.count);
        self.qualities = self.qualities.and(other.qualities);
    }

    /// The geometric mean in Pa.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| 10_f64.powf(self.decades / f64::from(self.count)))
    }
}

fn merged(one: Option<f64>, two: Option<f64>, choose: fn(f64, f64) -> f64) -> Option<f64> {
    match (one, two) {
        (Some(one), Some(two)) => Some(choose(one, two)),
        (one, two) => one.or(two),
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

/// Summaries to be added to the database.
#[derive(Clone, Debug, Default)]
pub struct PendingSpans(BTreeMap<SpanKey, Summary>);

impl PendingSpans {
    /// Adds a sample to its span of each level.
    pub fn add(&mut self, series: usize, sample: &Sample) {
        let summary = Summary::of(sample);
        for level in LEVELS {
            let key = SpanKey { level: level.number, series, start: level.start(sample.at) };
            self.0.entry(key).or_default().add(&summary);
        }
    }

    /// All spans.
    pub fn iter(&self) -> impl Iterator<Item = (&SpanKey, &Summary)> {
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
    fn a_summary_has_the_lowest_the_highest_and_the_geometric_mean() {
        let mut summary = Summary::default();
        [at(0, 1e-4), at(1, 1e-2), Sample::gap(Micros(2))].iter().for_each(|sample| summary.add(&Summary::of(sample)));
        assert_eq!((summary.low, summary.high, summary.count), (Some(1e-4), Some(1e-2), 2));
        assert!((summary.mean().unwrap() - 1e-3).abs() < 1e-9);
        assert_eq!(summary.qualities.iter().collect::<Vec<_>>(), [Quality::Valid, Quality::Stale]);
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
