//! Detects steps of the system clock.
//!
//! Samples carry the time that the clock showed: correcting it afterwards would falsify the record. A step is recorded as an event,
//! and the samples of times that occur twice are all kept.

use super::sample::Micros;
use std::time::{Duration, Instant};

/// The smallest step that is reported. A slewed clock drifts by far less between two checks, and less is not visible in a trend.
/// free choice.
const MIN_STEP: Duration = Duration::from_secs(1);

/// The times of both clocks at the last check.
pub struct ClockMonitor {
    monotonic: Instant,
    wall: Micros,
}

impl ClockMonitor {
    /// The times of both clocks at one moment.
    pub const fn new(monotonic: Instant, wall: Micros) -> Self {
        Self { monotonic, wall }
    }

    /// A sentence about the step since the last check, if there was one.
    pub fn detect_step(&mut self, monotonic: Instant, wall: Micros) -> Option<String> {
        let expected = self.wall.after(monotonic.saturating_duration_since(self.monotonic));
        *self = Self { monotonic, wall };
        let step = Duration::from_micros(wall.0.abs_diff(expected.0));
        if step < MIN_STEP {
            return None;
        }
        let seconds = step.as_secs_f64();
        Some(if wall < expected {
            format!("the clock was set back by {seconds:.1} s: times before this event may occur twice")
        } else {
            format!("the clock was set forward by {seconds:.1} s, or the computer was suspended")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_step_is_reported_once() {
        let begin = Instant::now();
        let mut clock = ClockMonitor::new(begin, Micros(1_000 * Micros::SECOND));
        let mut check = |after: u64, wall: f64| {
            clock.detect_step(begin + Duration::from_secs(after), Micros((wall * Micros::SECOND as f64) as i64))
        };
        assert_eq!(check(10, 1_010.5), None, "half a second is drift");
        assert_eq!(
            check(11, 1_001.5).as_deref(),
            Some("the clock was set back by 10.0 s: times before this event may occur twice")
        );
        assert_eq!(check(12, 1_002.5), None);
        assert_eq!(
            check(13, 4_603.5).as_deref(),
            Some("the clock was set forward by 3600.0 s, or the computer was suspended")
        );
    }
}
