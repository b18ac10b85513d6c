//! The measuring parts of a device in its tables.

use super::pressure::Counts;

/// The principle by which a measuring part senses pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Principle {
    /// Heat transfer.
    Pirani,
    /// Hot cathode ionisation, Bayard-Alpert or extractor.
    HotCathode,
    /// Cold cathode ionisation.
    ColdCathode,
    /// Capacitance diaphragm.
    Diaphragm,
    /// Piezo diaphragm that measures the ambient atmosphere, not the chamber.
    Atmosphere,
}

impl Principle {
    /// The part in a sentence: `Pirani`, `ionisation part`.
    #[must_use]
    pub const fn part_name(self) -> &'static str {
        match self {
            Self::Pirani => "Pirani",
            Self::HotCathode | Self::ColdCathode => "ionisation part",
            Self::Diaphragm => "diaphragm",
            Self::Atmosphere => "atmosphere sensor",
        }
    }
}

/// A measuring part of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its instance in the manual, or its channel on a controller, from 1.
    pub instance: u8,
    /// Its principle.
    pub principle: Principle,
}

/// The pressures between which a measuring part measures, in Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuringRange {
    /// The lowest pressure.
    pub lowest_pa: f64,
    /// The highest pressure, full scale.
    pub highest_pa: f64,
}

impl MeasuringRange {
    /// Whether the part measures this pressure in Pa.
    #[must_use]
    pub const fn contains(&self, pa: f64) -> bool {
        self.lowest_pa <= pa && pa <= self.highest_pa
    }
}

/// A measuring part in the tables.
#[derive(Debug, PartialEq)]
pub struct PartSpec {
    /// Its instance and principle.
    pub part: Part,
    /// Its range.
    pub limits: Limits,
    /// How it shows a value beyond its range.
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

/// The end of the range at which a measuring part shows the limit instead of the value. errata-bpg-bcg-tpg 53 and 81.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clipping {
    /// Below underrange and above overrange.
    Both,
    /// Above overrange only: the lowest part of a gauge.
    Above,
    /// Below underrange only: the highest part of a gauge.
    Below,
    /// At no end: the only part.
    Never,
}

/// The position of a value relative to a range.
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
    /// The position of `pa` relative to the range.
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
    /// The value that the part shows for a reading of `pa`.
    #[must_use]
    pub const fn clip(&self, pa: f64) -> f64 {
        let Limits { under_pa, over_pa, .. } = self.limits;
        match self.clipping {
            Clipping::Both => pa.min(over_pa).max(under_pa),
            Clipping::Above => pa.min(over_pa),
            Clipping::Below => pa.max(under_pa),
            Clipping::Never => pa,
        }
    }
}
