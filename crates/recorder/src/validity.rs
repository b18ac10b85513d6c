//! Determines the quality of a reading and whether it is fresh. The recorder, the alarms and the API use these functions, so
//! that a reading has the same quality everywhere.
//!
//! | Silence of the gauge | Pressure | Reported status | Quality |
//! |---|---|---|---|
//! | 1 s or more | any | any | gap |
//! | less | none | any | invalid |
//! | less | any | invalid | invalid |
//! | less | any | overrange, underrange | overrange, underrange |
//! | less | not positive and finite | in range | invalid |
//! | less | positive and finite | in range | valid |

use super::quality::Quality;
use std::time::Duration;

/// A gauge whose cyclic data have not been refreshed for this time has no reading: another master may use the line.
pub const MAX_SILENCE: Duration = Duration::from_secs(1);

/// A reading is fresh for this number of poll intervals, and for at least [`MIN_STALE_MS`]. free choice.
const STALE_POLLS: u64 = 5;

/// The shortest time in milliseconds after which a reading is stale. free choice.
const MIN_STALE_MS: u64 = 3_000;

/// The status that a gauge reports with a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RangeStatus {
    /// The value is measured.
    InRange,
    /// The pressure is above the range; the value is the end of the range.
    Over,
    /// The pressure is below the range; the value is the end of the range.
    Under,
    /// The value means nothing.
    Invalid,
}

/// The quality of a value that a gauge reported, `silence` after its last data exchange.
#[must_use]
pub fn quality(pa: Option<f64>, status: RangeStatus, silence: Duration) -> Quality {
    match (pa, status) {
        _ if silence >= MAX_SILENCE => Quality::Gap,
        (None, _) | (_, RangeStatus::Invalid) => Quality::Invalid,
        (Some(_), RangeStatus::Over) => Quality::Overrange,
        (Some(_), RangeStatus::Under) => Quality::Underrange,
        (Some(pa), RangeStatus::InRange) if is_pressure(pa) => Quality::Valid,
        (Some(_), RangeStatus::InRange) => Quality::Invalid,
    }
}

/// Whether a number in Pa is a pressure: positive and finite.
#[must_use]
pub fn is_pressure(pa: f64) -> bool {
    pa.is_finite() && pa > 0.0
}

/// Whether a quality comes with a pressure: a measured one, or the end of the range.
#[must_use]
pub const fn has_pressure(quality: Quality) -> bool {
    matches!(quality, Quality::Valid | Quality::Overrange | Quality::Underrange)
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
    use super::RangeStatus::{InRange, Invalid, Over, Under};
    use super::*;

    #[test]
    fn each_row_of_the_table_has_its_quality() {
        let table = [
            // silence in ms, pressure in Pa, status, quality
            (1_000, Some(1.0), InRange, Quality::Gap),
            (1_000, None, Invalid, Quality::Gap),
            (999, Some(1.0), InRange, Quality::Valid),
            (0, Some(1e-9), InRange, Quality::Valid),
            (0, None, InRange, Quality::Invalid),
            (0, None, Over, Quality::Invalid),
            (0, None, Under, Quality::Invalid),
            (0, Some(1.0), Invalid, Quality::Invalid),
            (0, Some(1e5), Over, Quality::Overrange),
            (0, Some(1e-8), Under, Quality::Underrange),
            (0, Some(0.0), InRange, Quality::Invalid),
            (0, Some(-1.0), InRange, Quality::Invalid),
            (0, Some(f64::NAN), InRange, Quality::Invalid),
            (0, Some(f64::INFINITY), InRange, Quality::Invalid),
        ];
        for (silence_ms, pa, status, expected) in table {
            let found = quality(pa, status, Duration::from_millis(silence_ms));
            assert_eq!(found, expected, "{silence_ms} ms, {pa:?} Pa, {status:?}");
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
