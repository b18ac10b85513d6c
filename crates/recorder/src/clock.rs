//! Whether somebody has set the clock of the computer.
//!
//! Samples carry the time that the clock showed, whatever it showed: a record whose times were bent to rise would lie about
//! them for ever. What is set back is told by an event, and the times that stand twice are both kept.

use super::sample::Micros;
use std::time::{Duration, Instant};

/// A clock that is slewed drifts by far less between two looks; what is less than this nobody sees in a trend. free choice.
const MIN_STEP: Duration = Duration::from_secs(1);

/// What the clocks showed together.
pub struct ClockMonitor {
    steady: Instant,
    shown: Micros,
}

impl ClockMonitor {
    /// Both clocks at a moment.
    pub const fn new(steady: Instant, shown: Micros) -> Self {
        Self { steady, shown }
    }

    /// What happened to the clock since this was asked last, in a sentence, if something did.
    pub fn detect_step(&mut self, steady: Instant, shown: Micros) -> Option<String> {
        let expected = self.shown.after(steady.saturating_duration_since(self.steady));
        *self = Self { steady, shown };
        let by = Duration::from_micros(shown.0.abs_diff(expected.0));
        if by < MIN_STEP {
            return None;
        }
        let seconds = by.as_secs_f64();
        Some(if shown < expected {
            format!("the clock was set back by {seconds:.1} s: times before this may stand twice")
        } else {
            format!("the clock was set forward by {seconds:.1} s, or the computer slept")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_is_set_is_noticed_once() {
        let begin = Instant::now();
        let mut clock = ClockMonitor::new(begin, Micros(1_000 * Micros::SECOND));
        let mut look = |after: u64, shown: f64| {
            clock.detect_step(begin + Duration::from_secs(after), Micros((shown * Micros::SECOND as f64) as i64))
        };
        assert_eq!(look(10, 1_010.5), None, "a little is drift");
        assert_eq!(
            look(11, 1_001.5).as_deref(),
            Some("the clock was set back by 10.0 s: times before this may stand twice")
        );
        assert_eq!(look(12, 1_002.5), None);
        assert_eq!(look(13, 4_603.5).as_deref(), Some("the clock was set forward by 3600.0 s, or the computer slept"));
    }
}
