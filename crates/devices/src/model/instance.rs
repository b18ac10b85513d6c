//! What the tables say about a measuring part.

use super::Counts;
use crate::instrument::Part;

/// A measuring part in the tables.
#[derive(Debug, PartialEq)]
pub struct Facts {
    /// Its instance and how it senses.
    pub part: Part,
    /// Its range.
    pub limits: Limits,
    /// What it shows beyond its range: clipped to it, or the value itself where nobody else measures further.
    pub shows: Shows,
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
pub enum Shows {
    /// Those within the limits.
    Range,
    /// Those below overrange: the lowest part of a gauge.
    RangeAndBelow,
    /// Those above underrange: the highest part of a gauge.
    RangeAndAbove,
    /// All: the only part.
    Everything,
}

/// Where a value lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
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
    pub fn judge(&self, pa: f64) -> Range {
        match pa {
            _ if pa < self.under_pa * (1.0 - SLACK) => Range::Under,
            _ if pa > self.over_pa * (1.0 + SLACK) => Range::Over,
            _ => Range::Within,
        }
    }
}

impl Facts {
    /// What is shown for a reading of `pa`.
    #[must_use]
    pub const fn shown(&self, pa: f64) -> f64 {
        let Limits { under_pa, over_pa, .. } = self.limits;
        match self.shows {
            Shows::Range => pa.clamp(under_pa, over_pa),
            Shows::RangeAndBelow => pa.min(over_pa),
            Shows::RangeAndAbove => pa.max(under_pa),
            Shows::Everything => pa,
        }
    }
}
