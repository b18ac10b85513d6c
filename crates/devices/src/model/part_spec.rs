//! What the tables say about a measuring part.

use super::Counts;
use crate::simulation::Part;

/// A measuring part in the tables.
#[derive(Debug, PartialEq)]
pub struct PartSpec {
    /// Its instance and how it senses.
    pub part: Part,
    /// Its range.
    pub limits: Limits,
    /// What it shows beyond its range: clipped to it, or the value itself where nobody else measures further.
    pub clipping: Clipping,
    /// Its COUNTS.
    pub counts: Counts,
}

/// The range of an instance in Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Underrange: the lowest valid value.
    pub under_pa: f64,
    /// Overrange: the highest valid value.
    pub over_pa: f64,
    /// Full Scale.
    pub full_scale_pa: f64,
}

/// Which values are shown as they are. errata-bpg-bcg-tpg 53 and 81.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clipping {
    /// Those within the limits.
    Both,
    /// Those below overrange: the lowest part of a gauge.
    Above,
    /// Those above underrange: the highest part of a gauge.
    Below,
    /// All: the only part.
    Never,
}

/// Where a value lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RangeStatus {
    /// Below underrange.
    Under,
    /// Valid.
    Within,
    /// Above overrange.
    Over,
}

/// The limits belong to the range (errata-bpg-bcg-tpg 55), also after a conversion between units.
const SLACK: f64 = 1e-9;

impl Limits {
    /// Where `pa` lies.
    #[must_use]
    pub fn status_of(&self, pa: f64) -> RangeStatus {
        match pa {
            _ if pa < self.under_pa * (1.0 - SLACK) => RangeStatus::Under,
            _ if pa > self.over_pa * (1.0 + SLACK) => RangeStatus::Over,
            _ => RangeStatus::Within,
        }
    }
}

impl PartSpec {
    /// What is shown for a reading of `pa`.
    #[must_use]
    pub const fn clip(&self, pa: f64) -> f64 {
        let Limits { under_pa, over_pa, .. } = self.limits;
        match self.clipping {
            Clipping::Both => pa.clamp(under_pa, over_pa),
            Clipping::Above => pa.min(over_pa),
            Clipping::Below => pa.max(under_pa),
            Clipping::Never => pa,
        }
    }
}
