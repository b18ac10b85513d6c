//! A pressure with its quality.

use super::quality::Quality;
use jiff::Timestamp;
use profivac_devices::reading::is_pressure;
use std::time::{Duration, SystemTime};

/// A time in microseconds since 1970, UTC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Micros(pub i64);

impl Micros {
    /// One second in microseconds.
    pub const SECOND: i64 = 1_000_000;

    /// The time of the system clock.
    #[must_use]
    pub fn now() -> Self {
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        Self(i64::try_from(since.as_micros()).unwrap_or(i64::MAX))
    }

    /// The time in UTC after ISO 8601 with this number of decimals: `2026-11-21T13:00:00.250Z` with three.
    ///
    /// ```
    /// use profivac_recorder::Micros;
    ///
    /// assert_eq!(Micros(1_500_000).to_iso(3), "1970-01-01T00:00:01.500Z");
    /// assert_eq!(Micros(1_500_000).to_iso(0), "1970-01-01T00:00:01Z");
    /// ```
    #[must_use]
    pub fn to_iso(self, decimals: usize) -> String {
        format!("{:.decimals$}", Timestamp::try_from(self.to_system_time()).unwrap_or(Timestamp::MAX))
    }

    /// The same time as a system time; the beginning of 1970 for earlier times, 22 h on 30 December 9999 for later ones, which only a
    /// damaged database has: in every time zone the times between have four digits for the year.
    #[must_use]
    pub fn to_system_time(self) -> SystemTime {
        const LAST_US: u64 = 253_402_207_200_999_999;
        SystemTime::UNIX_EPOCH + Duration::from_micros(u64::try_from(self.0).unwrap_or_default().min(LAST_US))
    }

    /// The time `time` later, saturating.
    #[must_use]
    pub fn after(self, time: Duration) -> Self {
        Self(self.0.saturating_add(i64::try_from(time.as_micros()).unwrap_or(i64::MAX)))
    }

    /// The time `time` earlier, saturating.
    #[must_use]
    pub fn before(self, time: Duration) -> Self {
        Self(self.0.saturating_sub(i64::try_from(time.as_micros()).unwrap_or(i64::MAX)))
    }
}

/// The pressure of a series at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When it was measured.
    pub at: Micros,
    /// The pressure in Pa, positive and finite; `None` where the quality has no pressure.
    pub pa: Option<f64>,
    /// Its quality.
    pub quality: Quality,
}

impl Sample {
    /// A sample. A number that is no pressure is dropped, and makes a valid sample a fault.
    #[must_use]
    pub fn new(at: Micros, pa: Option<f64>, quality: Quality) -> Self {
        let kept = pa.filter(|pa| is_pressure(*pa) && quality.has_pressure());
        let quality = if quality == Quality::Valid && kept.is_none() { Quality::Fault } else { quality };
        Self { at, pa: kept, quality }
    }

    /// The beginning of a gap.
    #[must_use]
    pub const fn gap(at: Micros) -> Self {
        Self { at, pa: None, quality: Quality::Stale }
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
    fn a_number_that_is_no_pressure_makes_a_valid_sample_a_fault() {
        for pa in [None, Some(f64::NAN), Some(0.0), Some(-1.0), Some(f64::INFINITY)] {
            let sample = Sample::new(Micros(1), pa, Quality::Valid);
            assert_eq!((sample.pa, sample.quality), (None, Quality::Fault), "{pa:?}");
        }
        assert_eq!(Sample::new(Micros(1), Some(9.9e9), Quality::Fault).pa, None);
        assert_eq!(Sample::new(Micros(1), Some(1e5), Quality::Overrange).pa, Some(1e5));
    }
}
