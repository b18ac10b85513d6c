//! A trend as the station and the archive show it.

use crate::point::{CodeText, DescribedPoint, Point, PointSummary};
use crate::quality::Qualities;
use crate::reader::Span;
use serde::{Deserialize, Serialize};

/// A trend: each list has one entry for every pixel with samples.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Trend {
    /// The name of the series.
    pub series: String,
    /// The start of each pixel, in milliseconds since 1970, rising.
    pub start_ms: Vec<i64>,
    /// The lowest pressure in Pa; `null` without a pressure. Where the gauge was below its range, the end of the range.
    pub low: Vec<Option<f64>>,
    /// The highest pressure in Pa. Where the gauge was above its range, the end of the range.
    pub high: Vec<Option<f64>>,
    /// The geometric mean of the measured pressures in Pa; `null` without one. The end of a range is in no mean.
    pub mean: Vec<Option<f64>>,
    /// The pressure in Pa that was recorded last in the pixel, which the gauge held until the next pixel of the list; `null` if the pixel
    /// ends without a measured pressure, and where only summaries are stored.
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(required = true))]
    pub last: Vec<Option<f64>>,
    /// The qualities that occurred: bit 0 valid, 1 overrange, 2 underrange, 3 fault, 4 stale, 5 off, 6
    /// missing, 7 assumed.
    pub qualities: Vec<u8>,
}

impl Trend {
    /// The trend of these spans.
    #[must_use]
    pub fn of(series: &str, bins: &[Span]) -> Self {
        Self {
            series: series.to_owned(),
            start_ms: bins.iter().map(|bin| bin.start.0.div_euclid(1000)).collect(),
            low: bins.iter().map(|bin| bin.summary.low).collect(),
            high: bins.iter().map(|bin| bin.summary.high).collect(),
            mean: bins.iter().map(|bin| bin.summary.mean()).collect(),
            last: bins.iter().map(|bin| bin.summary.last).collect(),
            qualities: bins.iter().map(|bin| bin.summary.qualities).map(|Qualities(bits)| bits).collect(),
        }
    }
}

/// The trend of a point, in its unit: each list has one entry for every pixel with values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PointTrend {
    /// The point, with its unit.
    pub point: Point,
    /// The texts of its codes in the station's file; empty for a number.
    pub texts: Vec<CodeText>,
    /// The start of each pixel, in milliseconds since 1970, rising.
    pub start_ms: Vec<i64>,
    /// The lowest number; `null` without a number.
    pub low: Vec<Option<f64>>,
    /// The highest number.
    pub high: Vec<Option<f64>>,
    /// The arithmetic mean; always `null` for a code or a bit.
    pub mean: Vec<Option<f64>>,
    /// The number that was recorded last in the pixel.
    pub last: Vec<Option<f64>>,
    /// The qualities that occurred: bit 0 valid, 3 fault, 4 stale.
    pub qualities: Vec<u8>,
}

impl PointTrend {
    /// The trend of these spans.
    #[must_use]
    pub fn of(DescribedPoint { point, texts }: DescribedPoint, bins: &[Span<PointSummary>]) -> Self {
        Self {
            texts,
            start_ms: bins.iter().map(|bin| bin.start.0.div_euclid(1000)).collect(),
            low: bins.iter().map(|bin| bin.summary.low).collect(),
            high: bins.iter().map(|bin| bin.summary.high).collect(),
            mean: bins.iter().map(|bin| bin.summary.mean(point.kind)).collect(),
            last: bins.iter().map(|bin| bin.summary.last).collect(),
            qualities: bins.iter().map(|bin| bin.summary.qualities).map(|Qualities(bits)| bits).collect(),
            point,
        }
    }
}
