//! The clocks of a recorder, and steps of the system clock.
//!
//! Samples carry the time that the clock showed: correcting it afterwards would falsify the database. A step is recorded as an event,
//! and the samples of times that occur twice are all kept.

use super::sample::Micros;
use std::time::{Duration, Instant};

/// The smallest step that is reported. A slewed clock drifts by far less between two checks, and less is not visible in a trend.
/// chosen.
const MIN_STEP: Duration = Duration::from_secs(1);

/// The times of both clocks of a computer at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClockTime {
    /// A clock that is never set.
    pub monotonic: Instant,
    /// The system clock, which may be set to any time at any moment.
    pub wall: Micros,
}

/// The clocks of a recorder. Tests use clocks that they set.
pub trait Clock: Send + Sync {
    /// The present times.
    fn now(&self) -> ClockTime;
}

/// The clocks of the operating system.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemClock;

impl Clock for SystemClock {
    fn now(&self) -> ClockTime {
        ClockTime { monotonic: Instant::now(), wall: Micros::now() }
    }
}

/// The direction of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// To a later time, or the computer was suspended.
    Forward,
    /// To an earlier time.
    Back,
}

/// A step of the system clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClockStep {
    /// Its direction.
    pub direction: Direction,
    /// How far the clock was set.
    pub by: Duration,
    /// The latest time that the clock can have shown before the step.
    pub until: Micros,
    /// The earliest time that the clock can have shown after the step.
    pub from: Micros,
}

impl std::fmt::Display for ClockStep {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let time = in_words(self.by);
        match self.direction {
            Direction::Back => {
                write!(formatter, "the clock was set back by {time}: times before this event may occur twice")?;
            }
            Direction::Forward => {
                write!(formatter, "the clock was set forward by {time}, or the computer was suspended")?;
            }
        }
        formatter.write_str("; nothing is deleted because of this")
    }
}

/// A time in the largest unit of which there are two at least.
pub fn in_words(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    let units = [("days", 86_400.0), ("h", 3_600.0), ("min", 60.0)];
    let (unit, length) = units.into_iter().find(|(_, length)| seconds >= 2.0 * length).unwrap_or(("s", 1.0));
    format!("{:.1} {unit}", seconds / length)
}

/// Finds steps of the system clock.
pub struct ClockMonitor(ClockTime);

impl ClockMonitor {
    /// A monitor whose last check was at `now`.
    pub const fn new(now: ClockTime) -> Self {
        Self(now)
    }

    /// The times at the last check. Whatever is measured against the database uses these: the clock may be set at any moment after the
    /// check, and the next check finds that.
    pub const fn last(&self) -> ClockTime {
        self.0
    }

    /// The step since the last check, if there was one.
    pub fn detect_step(&mut self, now: ClockTime) -> Option<ClockStep> {
        let elapsed = now.monotonic.saturating_duration_since(self.0.monotonic);
        let expected = self.0.wall.after(elapsed);
        self.0 = now;
        let by = Duration::from_micros(now.wall.0.abs_diff(expected.0));
        let direction = if now.wall < expected { Direction::Back } else { Direction::Forward };
        (by >= MIN_STEP).then(|| ClockStep { direction, by, until: expected, from: now.wall.before(elapsed) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn time(monotonic: Instant, wall: Micros) -> ClockTime {
        ClockTime { monotonic, wall }
    }

    #[test]
    fn a_clock_step_is_reported_once() {
        let begin = Instant::now();
        let at = |after: u64, wall: f64| {
            time(begin + Duration::from_secs(after), Micros((wall * Micros::SECOND as f64) as i64))
        };
        let mut clock = ClockMonitor::new(at(0, 1_000.0));
        let mut check = |after, wall| clock.detect_step(at(after, wall)).map(|step| step.to_string());
        assert_eq!(check(10, 1_010.5), None, "half a second is drift");
        assert_eq!(
            check(11, 1_001.5).as_deref(),
            Some(
                "the clock was set back by 10.0 s: times before this event may occur twice; nothing is deleted because of this"
            )
        );
        assert_eq!(check(12, 1_002.5), None);
        assert_eq!(
            check(13, 4_603.5).as_deref(),
            Some(
                "the clock was set forward by 60.0 min, or the computer was suspended; nothing is deleted because of this"
            )
        );
    }

    #[test]
    fn a_step_knows_the_earliest_time_after_it() {
        let begin = Instant::now();
        let second = |second: i64| Micros(second * Micros::SECOND);
        let mut clock = ClockMonitor::new(time(begin, second(1_000)));
        let step = clock.detect_step(time(begin + Duration::from_secs(5), second(400))).unwrap();
        assert_eq!((step.direction, step.by, step.from), (Direction::Back, Duration::from_secs(605), second(395)));
    }
}
