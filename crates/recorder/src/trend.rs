//! A trend as the station and the archive show it.

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
    /// The lowest pressure in Pa; `null` without a pressure.
    pub low: Vec<Option<f64>>,
    /// The highest pressure in Pa.
    pub high: Vec<Option<f64>>,
    /// The geometric mean in Pa.
    pub mean: Vec<Option<f64>>,
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
            qualities: bins.iter().map(|bin| bin.summary.qualities).map(|Qualities(bits)| bits).collect(),
        }
    }
}
