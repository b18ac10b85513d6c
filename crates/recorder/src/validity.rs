//! Determines whether a reading is fresh. The recorder, the alarms and the API use these functions, so that a reading has
//! the same quality everywhere.

use super::quality::Quality;
use std::time::Duration;

/// A gauge whose cyclic data have not been refreshed for this time has no reading: another master may use the line.
pub const MAX_SILENCE: Duration = Duration::from_secs(1);

/// A reading is fresh for this number of poll intervals, and for at least [`MIN_STALE_MS`]. chosen.
const STALE_POLLS: u64 = 5;

/// The shortest time in milliseconds after which a reading is stale. chosen.
const MIN_STALE_MS: u64 = 3_000;

/// The quality of a reading, `silence` after the last data exchange with its gauge.
#[must_use]
pub fn quality_after(quality: Quality, silence: Duration) -> Quality {
    if silence >= MAX_SILENCE { Quality::Stale } else { quality }
}

/// The age in milliseconds from which a reading of a gauge is stale that is polled every `poll_ms`.
#[must_use]
pub fn stale_after_ms(poll_ms: u64) -> u64 {
    poll_ms.saturating_mul(STALE_POLLS).max(MIN_STALE_MS)
}

/// Whether a reading of this age is fresh. A gauge without any reading has no age.
#[must_use]
pub fn is_fresh(age_ms: Option<u64>, poll_ms: u64) -> bool {
    age_ms.is_some_and(|age| age <= stale_after_ms(poll_ms))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_is_stale_after_a_silence_of_one_second() {
        for quality in Quality::ALL {
            assert_eq!(quality_after(quality, Duration::from_millis(999)), quality);
            assert_eq!(quality_after(quality, MAX_SILENCE), Quality::Stale);
        }
    }

    #[test]
    fn a_reading_is_fresh_for_five_polls_and_at_least_three_seconds() {
        let table = [
            // age, poll interval, fresh
            (None, 200, false),
            (Some(0), 200, true),
            (Some(3_000), 200, true),
            (Some(3_001), 200, false),
            (Some(5_000), 1_000, true),
            (Some(5_001), 1_000, false),
            (Some(u64::MAX), u64::MAX, true),
        ];
        for (age_ms, poll_ms, expected) in table {
            assert_eq!(is_fresh(age_ms, poll_ms), expected, "{age_ms:?} at {poll_ms}");
        }
    }
}
