//! The levels in which long times are kept and drawn: for each span the lowest and highest pressure, their geometric mean,
//! and what happened.
//!
//! Each level is twelve to fifteen times as long as the one below, so a picture reads at most fifteen rows for a pixel.

use super::sample::{Micros, Qualities, Sample};
use std::collections::BTreeMap;

/// A level: its number in the file and the length of its spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// Its number.
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

    /// The beginning of the span that `at` lies in.
    #[must_use]
    pub const fn start(self, at: Micros) -> Micros {
        Micros(at.0.saturating_sub(at.0.rem_euclid(self.micros())))
    }

    /// The coarsest level whose spans are not longer than `micros`; nothing if even the finest is.
    #[must_use]
    pub fn coarsest_within(micros: i64) -> Option<Self> {
        LEVELS.into_iter().rev().find(|level| level.micros() <= micros)
    }
}

/// What happened in a span.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// The lowest pressure in Pa.
    pub low: Option<f64>,
    /// The highest.
    pub high: Option<f64>,
    /// The sum of the decimal logarithms of all pressures.
    pub decades: f64,
    /// How many pressures there were.
    pub count: u32,
    /// The qualities that occurred.
    pub qualities: Qualities,
}

impl Summary {
    /// One sample alone.
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

    /// Both.
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

/// Which span of which gauge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SpanKey {
    /// The number of the level.
    pub level: u8,
    /// The gauge.
    pub gauge: usize,
    /// The beginning of the span.
    pub start: Micros,
}

/// What has to be added to the file.
#[derive(Clone, Debug, Default)]
pub struct PendingSpans(BTreeMap<SpanKey, Summary>);

impl PendingSpans {
    /// A sample, in every level.
    pub fn add(&mut self, gauge: usize, sample: &Sample) {
        let extent = Summary::of(sample);
        for level in LEVELS {
            let key = SpanKey { level: level.number, gauge, start: level.start(sample.at) };
            self.0.entry(key).or_default().add(&extent);
        }
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = (&SpanKey, &Summary)> {
        self.0.iter()
    }

    /// How many spans they touch.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is nothing to add.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// They were added.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::Quality;
    use super::*;

    fn at(second: i64, pa: f64) -> Sample {
        Sample::new(Micros(second * Micros::SECOND), Some(pa), Quality::Valid)
    }

    #[test]
    fn a_span_knows_lowest_highest_and_geometric_mean() {
        let mut extent = Summary::default();
        [at(0, 1e-4), at(1, 1e-2), Sample::gap(Micros(2))].iter().for_each(|sample| extent.add(&Summary::of(sample)));
        assert_eq!((extent.low, extent.high, extent.count), (Some(1e-4), Some(1e-2), 2));
        assert!((extent.mean().unwrap() - 1e-3).abs() < 1e-9);
        assert_eq!(extent.qualities.iter().collect::<Vec<_>>(), [Quality::Valid, Quality::Gap]);
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
    fn spans_before_1970_begin_before_they_end() {
        assert_eq!(LEVELS[0].start(Micros(-1)), Micros(-10 * Micros::SECOND));
    }

    #[test]
    fn a_picture_takes_the_coarsest_level_that_is_fine_enough() {
        let level = |seconds: i64| Level::coarsest_within(seconds * Micros::SECOND).map(|level| level.number);
        assert_eq!(
            [level(9), level(10), level(119), level(120), level(15_768), level(100_000)],
            [None, Some(1), Some(1), Some(2), Some(3), Some(4)]
        );
    }
}
