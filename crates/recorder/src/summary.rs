//! The summary of the pressures of a span of time.

use super::quality::{Qualities, Quality};
use super::recorded::Summarise;
use rusqlite::Row;

/// The summary of a span.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// The lowest pressure in Pa; of a gauge below its range the end of the range.
    pub low: Option<f64>,
    /// The highest pressure in Pa; of a gauge above its range the end of the range.
    pub high: Option<f64>,
    /// The sum of the decimal logarithms of all valid pressures. The end of a range is not measured, so it is in no mean.
    pub decades: f64,
    /// The number of valid pressures.
    pub count: u32,
    /// The pressure of the last sample if that is valid. `None` of a stored span, which does not hold it.
    pub last: Option<f64>,
    /// The qualities that occurred.
    pub qualities: Qualities,
}

impl Summary {
    /// The geometric mean of the valid pressures in Pa.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| 10_f64.powf(self.decades / f64::from(self.count)))
    }

    /// The end of the range where the gauge was beyond it; above the range first.
    #[must_use]
    pub fn bound(&self) -> Option<f64> {
        let above = self.high.filter(|_| self.qualities.contains(Quality::Overrange));
        above.or_else(|| self.low.filter(|_| self.qualities.contains(Quality::Underrange)))
    }
}

impl Summarise for Summary {
    const COLUMNS: &'static str = "min_pa, max_pa, log10_sum, count, qualities";

    fn read(row: &Row<'_>, first: usize) -> rusqlite::Result<Self> {
        let [low, high, decades, count, qualities] = std::array::from_fn(|column| first.saturating_add(column));
        let qualities = Qualities(row.get(qualities)?);
        // Version 0.1 counted the ends of ranges as pressures.
        let has_valid = qualities.contains(Quality::Valid);
        Ok(Self {
            low: row.get(low)?,
            high: row.get(high)?,
            decades: if has_valid { row.get(decades)? } else { 0.0 },
            count: if has_valid { row.get(count)? } else { 0 },
            last: None,
            qualities,
        })
    }

    fn add(&mut self, later: &Self) {
        self.low = lower(self.low, later.low);
        self.high = higher(self.high, later.high);
        self.decades += later.decades;
        self.count = self.count.saturating_add(later.count);
        self.last = later.last;
        self.qualities = self.qualities.and(later.qualities);
    }
}

/// The lower one of two numbers that may be absent.
pub fn lower(one: Option<f64>, two: Option<f64>) -> Option<f64> {
    one.into_iter().chain(two).reduce(f64::min)
}

/// The higher one of two numbers that may be absent.
pub fn higher(one: Option<f64>, two: Option<f64>) -> Option<f64> {
    one.into_iter().chain(two).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::recorded::Recorded;
    use super::super::sample::{Micros, Sample};
    use super::*;

    fn at(second: i64, pa: f64) -> Sample {
        Sample::new(Micros(second * Micros::SECOND), Some(pa), Quality::Valid)
    }

    #[test]
    fn a_summary_has_the_lowest_the_highest_and_the_geometric_mean() {
        let mut summary = Summary::default();
        [at(0, 1e-4), at(1, 1e-2), Sample::gap(Micros(2))].iter().for_each(|sample| summary.add(&sample.summary()));
        assert_eq!((summary.low, summary.high, summary.count), (Some(1e-4), Some(1e-2), 2));
        assert!((summary.mean().unwrap() - 1e-3).abs() < 1e-9);
        assert_eq!(summary.qualities.iter().collect::<Vec<_>>(), [Quality::Valid, Quality::Stale]);
    }

    fn summary(samples: &[Sample]) -> Summary {
        let mut all = Summary::default();
        samples.iter().for_each(|sample| all.add(&sample.summary()));
        all
    }

    #[test]
    fn the_end_of_a_range_is_in_no_mean() {
        let above = Sample::new(Micros(1), Some(1e5), Quality::Overrange);
        let below = Sample::new(Micros(2), Some(1e-8), Quality::Underrange);
        let mixed = summary(&[above, at(1, 1e-3), below]);
        assert!((mixed.mean().unwrap() - 1e-3).abs() < 1e-9);
        assert_eq!((mixed.low, mixed.high, mixed.bound()), (Some(1e-8), Some(1e5), Some(1e5)));
        assert_eq!((summary(&[below]).mean(), summary(&[below]).bound()), (None, Some(1e-8)));
        assert_eq!(summary(&[at(1, 1e-3)]).bound(), None);
    }

    /// A span of version 0.1, in which the end of the range counts.
    #[test]
    fn a_span_without_a_valid_pressure_is_in_no_mean() {
        let connection = rusqlite::Connection::open_in_memory().unwrap();
        let read = |sql: &str| connection.query_row(sql, [], |row| Summary::read(row, 0)).unwrap();
        let mut below = read("SELECT 1e-8, 1e-8, -40.0, 5, 4");
        assert_eq!((below.mean(), below.bound()), (None, Some(1e-8)));
        below.add(&read("SELECT 1e-3, 1e-3, -6.0, 2, 1"));
        assert!((below.mean().unwrap() - 1e-3).abs() < 1e-9, "{:?}", below.mean());
    }

    #[test]
    fn the_last_pressure_is_that_of_the_last_sample_and_measured() {
        let above = Sample::new(at(2, 1.0).at, Some(1e5), Quality::Overrange);
        assert_eq!(summary(&[at(0, 1e-4), at(1, 1e-2)]).last, Some(1e-2));
        assert_eq!(summary(&[at(0, 1e-4), above]).last, None);
        assert_eq!(summary(&[at(0, 1e-4), Sample::gap(Micros(Micros::SECOND))]).last, None);
    }
}
