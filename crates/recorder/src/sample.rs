//! A pressure with its quality.

use std::time::{Duration, SystemTime};

/// Microseconds since 1970, UTC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Micros(pub i64);

impl Micros {
    /// One second.
    pub const SECOND: i64 = 1_000_000;

    /// The clock of the system.
    #[must_use]
    pub fn now() -> Self {
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        Self(i64::try_from(since.as_micros()).unwrap_or(i64::MAX))
    }

    /// The same moment for the clock of the system; 1970 for earlier ones.
    #[must_use]
    pub fn to_system_time(self) -> SystemTime {
        SystemTime::UNIX_EPOCH + Duration::from_micros(u64::try_from(self.0).unwrap_or_default())
    }

    /// So much later.
    #[must_use]
    pub fn after(self, time: Duration) -> Self {
        Self(self.0.saturating_add(i64::try_from(time.as_micros()).unwrap_or(i64::MAX)))
    }

    /// So much earlier.
    #[must_use]
    pub fn before(self, time: Duration) -> Self {
        Self(self.0.saturating_sub(i64::try_from(time.as_micros()).unwrap_or(i64::MAX)))
    }
}

/// What a sample is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// The gauge says that it measures.
    Valid = 0,
    /// Above what the gauge can measure; the pressure is the end of its range.
    Overrange = 1,
    /// Below what the gauge can measure; the pressure is the end of its range.
    Underrange = 2,
    /// The gauge says that its reading is not valid.
    Invalid = 3,
    /// Nothing was heard of the gauge from here on.
    Gap = 4,
}

impl Quality {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Valid, Self::Overrange, Self::Underrange, Self::Invalid, Self::Gap];

    /// The one that is stored as `number`.
    #[must_use]
    pub fn from_number(number: i64) -> Option<Self> {
        Self::ALL.into_iter().find(|quality| *quality as i64 == number)
    }

    /// A word for people and files.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Valid => "valid",
            Self::Overrange => "overrange",
            Self::Underrange => "underrange",
            Self::Invalid => "invalid",
            Self::Gap => "gap",
        }
    }
}

/// The qualities that occurred.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Qualities(pub u8);

impl Qualities {
    /// One alone.
    #[must_use]
    pub const fn of(quality: Quality) -> Self {
        Self(1 << quality as u8)
    }

    /// Both.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether this one occurred.
    #[must_use]
    pub const fn contains(self, quality: Quality) -> bool {
        self.0 & Self::of(quality).0 != 0
    }

    /// Those that occurred.
    pub fn iter(self) -> impl Iterator<Item = Quality> {
        Quality::ALL.into_iter().filter(move |quality| self.contains(*quality))
    }
}

/// What a gauge showed at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When.
    pub at: Micros,
    /// In Pa; nothing where there is no pressure. Positive and finite.
    pub pa: Option<f64>,
    /// What it is worth.
    pub quality: Quality,
}

impl Sample {
    /// A sample; a pressure that is not positive and finite is none, and makes a valid sample invalid.
    #[must_use]
    pub fn new(at: Micros, pa: Option<f64>, quality: Quality) -> Self {
        let kept = pa.filter(|pa| {
            pa.is_finite() && *pa > 0.0 && matches!(quality, Quality::Valid | Quality::Overrange | Quality::Underrange)
        });
        let quality = if quality == Quality::Valid && kept.is_none() { Quality::Invalid } else { quality };
        Self { at, pa: kept, quality }
    }

    /// Nothing was heard from here on.
    #[must_use]
    pub const fn gap(at: Micros) -> Self {
        Self { at, pa: None, quality: Quality::Gap }
    }

    /// The decimal logarithm of the pressure.
    #[must_use]
    pub fn decades(&self) -> Option<f64> {
        self.pa.map(f64::log10)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pressure_that_is_none_makes_no_valid_sample() {
        for pa in [None, Some(f64::NAN), Some(0.0), Some(-1.0), Some(f64::INFINITY)] {
            let sample = Sample::new(Micros(1), pa, Quality::Valid);
            assert_eq!((sample.pa, sample.quality), (None, Quality::Invalid), "{pa:?}");
        }
        assert_eq!(Sample::new(Micros(1), Some(9.9e9), Quality::Invalid).pa, None);
        assert_eq!(Sample::new(Micros(1), Some(1e5), Quality::Overrange).pa, Some(1e5));
    }

    #[test]
    fn qualities_are_stored_as_numbers() {
        for quality in Quality::ALL {
            assert_eq!(Quality::from_number(quality as i64), Some(quality));
            assert_eq!(Qualities::of(quality).iter().collect::<Vec<_>>(), [quality]);
        }
        assert_eq!(Quality::from_number(5), None);
    }
}
