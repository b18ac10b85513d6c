//! The points of slaves: a speed, a flow, a limit switch; and their values, in the unit of the station's file.
//!
//! A value of a point may be zero or negative, and its unit is not Pa. So points have tables of their own, an absolute deadband and an
//! arithmetic mean.

use super::quality::{Qualities, Quality};
use super::recorded::{Recorded, Summarise};
use super::sample::Micros;
use super::summary::{higher, lower};
pub use profivac_model::PointKind;
use rusqlite::Row;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A number beyond this is no quantity. chosen: far beyond any, and the sum of 2^32 of them is finite, which SQLite stores.
pub(super) const LARGEST: f64 = 1e290;

/// A point whose values are recorded. With another unit, or as another kind, it is another point: numbers in two units are never mixed.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "openapi", schema(as = RecordedPoint))]
pub struct Point {
    /// The slave.
    pub slave: String,
    /// The name of the point, unique for its slave.
    pub name: String,
    /// The unit of the values; `null` without one.
    pub unit: Option<String>,
    /// What the values are.
    pub kind: PointKind,
}

/// The name in messages and on the command line: `turbo.speed`.
impl fmt::Display for Point {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}.{}", self.slave, self.name)
    }
}

/// The text of a code or of a bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CodeText {
    /// The number that is recorded for it.
    pub number: f64,
    /// The text of the station's file; `off` or `on` of a bit without one.
    pub text: String,
}

/// A point with the texts of its codes. The recorder stores numbers; the texts are those of the station's file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct DescribedPoint {
    /// The point.
    #[serde(flatten)]
    pub point: Point,
    /// The texts of its codes; empty for a number, and for a point that the station's file does not have.
    pub texts: Vec<CodeText>,
}

impl DescribedPoint {
    /// The text of a value; `None` for a number without one.
    #[must_use]
    pub fn text_of(&self, number: f64) -> Option<&str> {
        #[expect(clippy::float_cmp, reason = "both numbers are made from the same code in the same way")]
        let own = self.texts.iter().find(|code| code.number == number);
        own.map(|code| code.text.as_str())
    }
}

/// The value of a point at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointSample {
    /// When it was measured.
    pub at: Micros,
    /// The number in the unit of the point, within ±1e290; the number of a code; 0 or 1 of a bit. `None` where the quality has none.
    pub number: Option<f64>,
    /// Its quality: valid, fault or stale.
    pub quality: Quality,
}

impl PointSample {
    /// A value. A number that is no quantity is dropped, and makes a valid value a fault.
    #[must_use]
    pub fn new(at: Micros, number: Option<f64>, quality: Quality) -> Self {
        let kept = number.filter(|number| number.abs() <= LARGEST && quality == Quality::Valid);
        let quality = if quality == Quality::Valid && kept.is_none() { Quality::Fault } else { quality };
        Self { at, number: kept, quality }
    }

    /// The beginning of a gap.
    #[must_use]
    pub const fn gap(at: Micros) -> Self {
        Self { at, number: None, quality: Quality::Stale }
    }
}

impl Recorded for PointSample {
    type Summary = PointSummary;

    const SAMPLES: &'static str = "point_sample";
    const SPANS: &'static str = "point_span";
    const SERIES: &'static str = "point_id";
    const VALUE: &'static str = "value";

    fn of(at: Micros, value: Option<f64>, quality: Quality) -> Self {
        Self::new(at, value, quality)
    }

    fn at(&self) -> Micros {
        self.at
    }

    fn value(&self) -> Option<f64> {
        self.number
    }

    fn quality(&self) -> Quality {
        self.quality
    }

    fn on_scale(&self) -> Option<f64> {
        self.number
    }

    fn summary(&self) -> PointSummary {
        PointSummary {
            low: self.number,
            high: self.number,
            last: self.number,
            sum: self.number.unwrap_or(0.0),
            count: u32::from(self.number.is_some()),
            qualities: Qualities::of(self.quality),
        }
    }
}

/// The summary of the values of a point in a span of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointSummary {
    /// The lowest number.
    pub low: Option<f64>,
    /// The highest number.
    pub high: Option<f64>,
    /// The number that was recorded last.
    pub last: Option<f64>,
    /// The sum of all numbers.
    pub sum: f64,
    /// The number of numbers.
    pub count: u32,
    /// The qualities that occurred.
    pub qualities: Qualities,
}

impl PointSummary {
    /// The arithmetic mean. A code has none: between "off" and "at speed" is no "accelerating".
    #[must_use]
    pub fn mean(&self, kind: PointKind) -> Option<f64> {
        let mean = self.sum / f64::from(self.count);
        (kind == PointKind::Number && mean.is_finite()).then_some(mean)
    }
}

impl Summarise for PointSummary {
    const COLUMNS: &'static str = "min_value, max_value, last_value, sum, count, qualities";

    fn read(row: &Row<'_>, first: usize) -> rusqlite::Result<Self> {
        let [low, high, last, sum, count, qualities] = std::array::from_fn(|column| first.saturating_add(column));
        Ok(Self {
            low: row.get(low)?,
            high: row.get(high)?,
            last: row.get(last)?,
            sum: row.get(sum)?,
            count: row.get(count)?,
            qualities: Qualities(row.get(qualities)?),
        })
    }

    fn add(&mut self, later: &Self) {
        self.low = lower(self.low, later.low);
        self.high = higher(self.high, later.high);
        self.last = later.last.or(self.last);
        self.sum += later.sum;
        self.count = self.count.saturating_add(later.count);
        self.qualities = self.qualities.and(later.qualities);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn valid(second: i64, number: f64) -> PointSample {
        PointSample::new(Micros(second * Micros::SECOND), Some(number), Quality::Valid)
    }

    fn summary(samples: &[PointSample]) -> PointSummary {
        let mut all = PointSummary::default();
        samples.iter().for_each(|sample| all.add(&sample.summary()));
        all
    }

    #[test]
    fn zero_and_negative_numbers_are_values_and_numbers_that_are_no_quantity_are_faults() {
        for number in [0.0, -12.5, 4_294_967_295.0] {
            assert_eq!(valid(1, number).number, Some(number));
        }
        for number in [None, Some(f64::NAN), Some(f64::NEG_INFINITY), Some(-1e291)] {
            let sample = PointSample::new(Micros(1), number, Quality::Valid);
            assert_eq!((sample.number, sample.quality), (None, Quality::Fault), "{number:?}");
        }
        assert_eq!(PointSample::new(Micros(1), Some(1.0), Quality::Fault).number, None);
    }

    #[test]
    fn a_summary_has_the_lowest_the_highest_the_last_and_the_arithmetic_mean_of_a_number() {
        let gap = PointSample::gap(Micros(4 * Micros::SECOND));
        let all = summary(&[valid(1, -2.0), valid(2, 7.0), valid(3, 1.0), gap]);
        assert_eq!((all.low, all.high, all.last, all.count), (Some(-2.0), Some(7.0), Some(1.0), 3));
        assert_eq!(all.mean(PointKind::Number), Some(2.0));
        assert_eq!(all.mean(PointKind::Code), None);
        assert_eq!(all.qualities.iter().collect::<Vec<_>>(), [Quality::Valid, Quality::Stale]);
        assert_eq!(summary(&[gap]).mean(PointKind::Number), None, "no number has no mean");
        assert_eq!(summary(&[valid(1, LARGEST), valid(2, LARGEST)]).mean(PointKind::Number), Some(LARGEST));
    }
}
