//! A time.

use jiff::Timestamp;
use serde::{Serialize, Serializer};
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
    /// use profivac_model::Micros;
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

    /// The time in whole milliseconds since 1970, as the API has it.
    #[must_use]
    pub const fn milliseconds(self) -> i64 {
        self.0.div_euclid(1000)
    }
}

impl Serialize for Micros {
    /// In milliseconds since 1970.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_i64(self.milliseconds())
    }
}
