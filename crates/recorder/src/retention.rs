//! Which rows are older than their retention, measured in recorded time.
//!
//! A retention counts the time in which the station recorded, not the time that the clock shows: a clock that is set to a wrong year
//! makes no row older. Recorded time is a list of periods in the order of recording. A period ends when the station ends, or when the
//! clock is set.

use super::clock::{ClockStep, Direction, in_words};
use super::sample::Micros;
use std::fmt;
use std::ops::Range;
use std::time::Duration;

/// A shorter break, or a smaller step forward, does not end a period. chosen: a restart, and an adjustment by a time server.
pub const MAX_BREAK: Duration = Duration::from_secs(3_600);

/// A smaller step back does not end a period.
pub const MAX_STEP_BACK: Duration = Duration::from_secs(60);

/// A longer break before a start is reported. chosen: a weekend is reported, a night is not.
const REPORTED_BREAK: Duration = Duration::from_secs(86_400);

/// A time without a break in which the station recorded, by the clock of the computer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Period {
    /// Its first time.
    pub start: Micros,
    /// Its last time.
    pub end: Micros,
}

impl Period {
    /// A period that begins now.
    #[must_use]
    pub const fn starting(at: Micros) -> Self {
        Self { start: at, end: at }
    }

    /// The period with all times up to `now`.
    #[must_use]
    pub fn until(self, now: Micros) -> Self {
        Self { start: self.start.min(now), end: self.end.max(now) }
    }

    /// Whether a recording that starts at `now` continues this period.
    #[must_use]
    pub fn continues_at(self, now: Micros) -> bool {
        (self.end.before(MAX_STEP_BACK)..=self.end.after(MAX_BREAK)).contains(&now)
    }
}

/// Whether a step of the clock ends a period.
#[must_use]
pub fn ends_period(step: &ClockStep) -> bool {
    let largest = match step.direction {
        Direction::Forward => MAX_BREAK,
        Direction::Back => MAX_STEP_BACK,
    };
    step.by > largest
}

/// How the clock at a start differs from the end of the database.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClockAtStart {
    now: Micros,
    last: Micros,
}

impl ClockAtStart {
    /// The difference between `now` and the end of the last period, if it is worth an event.
    #[must_use]
    pub fn check(now: Micros, last: Micros) -> Option<Self> {
        let is_expected = (last.before(MAX_STEP_BACK)..=last.after(REPORTED_BREAK)).contains(&now);
        (!is_expected).then_some(Self { now, last })
    }
}

impl fmt::Display for ClockAtStart {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let by = in_words(Duration::from_micros(self.now.0.abs_diff(self.last.0)));
        let show = |at: Micros| at.to_iso(0);
        let (now, last) = (show(self.now), show(self.last));
        if self.now < self.last {
            write!(formatter, "the clock shows {now}, {by} before the end of the database ({last}): ")?;
            write!(formatter, "it was set back, or was ahead before; ")?;
        } else {
            write!(formatter, "the clock shows {now}, {by} after the end of the database ({last}): ")?;
            write!(formatter, "the station did not run meanwhile, or the clock was set forward; ")?;
        }
        formatter.write_str("nothing is deleted because of this")
    }
}

/// The times that are older than a retention.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Expired(Vec<Range<i64>>);

impl Expired {
    /// The times before the last `kept` of recorded time. `periods` are in the order of recording, the latest last. An earlier period is
    /// expired as a whole, also when the clock was ahead in it. Times of a later period are never expired, also when the clock showed
    /// an early time in it.
    #[must_use]
    pub fn of(periods: &[Period], kept: Duration) -> Self {
        let mut left = i64::try_from(kept.as_micros()).unwrap_or(i64::MAX);
        for (index, period) in periods.iter().enumerate().rev() {
            let length = period.end.0.saturating_sub(period.start.0);
            if length >= left {
                return Self(before(periods, index, period.end.0.saturating_sub(left)));
            }
            left = left.saturating_sub(length);
        }
        Self::default()
    }

    /// The ranges of times, in microseconds since 1970.
    pub fn ranges(&self) -> impl Iterator<Item = &Range<i64>> {
        self.0.iter()
    }

    /// Whether a time is expired.
    #[must_use]
    pub fn contains(&self, at: Micros) -> bool {
        self.0.iter().any(|range| range.contains(&at.0))
    }
}

/// All times before `cutoff`, and those of the periods before `index`, except what is kept: the times of period `index` from `cutoff`
/// on, and those of later periods.
fn before(periods: &[Period], index: usize, cutoff: i64) -> Vec<Range<i64>> {
    let (earlier, rest) = periods.split_at_checked(index).unwrap_or_default();
    let all = |period: &Period| period.start.0..period.end.0.saturating_add(1);
    let mut kept: Vec<_> = rest.iter().map(all).collect();
    if let Some(first) = kept.first_mut() {
        first.start = cutoff;
    }
    kept.sort_by_key(|range| range.start);
    let mut old: Vec<_> = std::iter::once(i64::MIN..cutoff).chain(earlier.iter().map(all)).collect();
    old.sort_by_key(|range| range.start);
    let (mut ranges, mut from) = (Vec::new(), i64::MIN);
    for range in old {
        from = from.max(range.start);
        without(from..range.end, &kept, &mut ranges);
        from = from.max(range.end);
    }
    ranges
}

/// Adds the times of `range` that are not in `kept`, which is in the order of the starts.
fn without(range: Range<i64>, kept: &[Range<i64>], ranges: &mut Vec<Range<i64>>) {
    let mut from = range.start;
    for kept in kept {
        let end = kept.start.min(range.end);
        if from < end {
            ranges.push(from..end);
        }
        from = from.max(kept.end);
    }
    if from < range.end {
        ranges.push(from..range.end);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DAY: Duration = Duration::from_secs(86_400);

    fn day(day: i64) -> Micros {
        Micros(day * 86_400 * Micros::SECOND)
    }

    fn days(start: i64, end: i64) -> Period {
        Period { start: day(start), end: day(end) }
    }

    /// Whether each of these days is expired with a retention of 100 days.
    fn expired(periods: &[Period], tested: &[i64]) -> Vec<bool> {
        let expired = Expired::of(periods, DAY * 100);
        tested.iter().map(|tested| expired.contains(day(*tested))).collect()
    }

    #[test]
    fn a_row_expires_after_its_retention_of_recorded_time() {
        assert_eq!(expired(&[days(0, 150)], &[-1, 0, 49, 50, 150]), [true, true, true, false, false]);
        assert_eq!(expired(&[days(0, 99)], &[-1000, 0, 99]), [false, false, false], "less was recorded");
        assert_eq!(expired(&[], &[0]), [false]);
        // A pause of a year counts nothing.
        let pause = [days(0, 90), days(455, 475)];
        assert_eq!(expired(&pause, &[9, 10, 89, 455]), [true, false, false, false]);
    }

    #[test]
    fn a_clock_that_jumps_by_years_makes_no_row_older() {
        let forward = [days(0, 90), days(2_000, 2_001)];
        assert_eq!(expired(&forward, &[0, 90, 2_000]), [false, false, false]);
        let back = [days(2_000, 2_090), days(0, 1)];
        assert_eq!(expired(&back, &[0, 1, 2_000]), [false, false, false]);
        // With a full database the oldest rows of the database go, never those that were recorded last.
        let full = [days(2_000, 2_150), days(0, 1), days(2_150, 2_151)];
        assert_eq!(
            expired(&full, &[-1, 0, 1, 2, 2_000, 2_051, 2_052, 2_150]),
            [true, false, false, true, true, true, false, false]
        );
    }

    #[test]
    fn a_period_with_a_clock_ahead_expires_with_the_recorded_time_after_it() {
        let ahead = [days(2_000, 2_090), days(0, 200)];
        assert_eq!(
            expired(&ahead, &[0, 99, 100, 200, 201, 2_000, 2_090, 2_091]),
            [true, true, false, false, false, true, true, false]
        );
        // Rows that were recorded last at the same times stay.
        let again = [days(2_000, 2_090), days(0, 60), days(2_050, 2_100)];
        assert_eq!(
            expired(&again, &[9, 10, 60, 1_999, 2_000, 2_049, 2_050, 2_100]),
            [true, false, false, false, true, true, false, false]
        );
        let twice = [days(2_000, 2_090), days(2_010, 2_100), days(0, 100)];
        assert_eq!(expired(&twice, &[-1, 0, 2_000, 2_100, 2_101]), [true, false, true, true, false]);
    }

    #[test]
    fn a_break_is_reported_in_both_directions() {
        let text = |now: i64| ClockAtStart::check(day(now), day(1_000)).map(|found| found.to_string());
        assert_eq!((text(1_000), text(1_001)), (None, None));
        assert_eq!(
            text(2_000).as_deref(),
            Some(
                "the clock shows 1975-06-24T00:00:00Z, 1000.0 days after the end of the database (1972-09-27T00:00:00Z): the \
                 station did not run meanwhile, or the clock was set forward; nothing is deleted because of this"
            )
        );
        assert!(
            text(0).unwrap().contains(" before the end of the database (1972-09-27T00:00:00Z): it was set back, or")
        );
    }

    #[test]
    fn a_restart_continues_a_period_and_a_step_ends_it() {
        let period = days(0, 1_000);
        let second = Duration::from_secs(1);
        for (now, expected) in [
            (day(1_000), true),
            (day(1_000).after(MAX_BREAK), true),
            (day(1_000).after(MAX_BREAK + second), false),
            (day(1_000).before(MAX_STEP_BACK), true),
            (day(1_000).before(MAX_STEP_BACK + second), false),
        ] {
            assert_eq!(period.continues_at(now), expected, "{now:?}");
        }
        let step = |direction, by| ends_period(&ClockStep { direction, by, until: day(0), from: day(0) });
        assert!(!step(Direction::Forward, MAX_BREAK) && step(Direction::Forward, MAX_BREAK + second));
        assert!(!step(Direction::Back, MAX_STEP_BACK) && step(Direction::Back, MAX_STEP_BACK + second));
    }
}
