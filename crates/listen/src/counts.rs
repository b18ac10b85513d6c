//! Counters of the requests to a station, in total and of the last minute.

use profivac_dp::link::{Baud, BitTime};
use serde::Serialize;

/// What happened to the requests to a station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Counts {
    /// Requests with their repetitions, also damaged ones that were repeated; without FDL status.
    pub requests: u64,
    /// Data_Exchange cycles with a valid answer.
    pub exchanges: u64,
    /// Requests without any answer.
    pub unanswered: u64,
    /// Message cycles that their master gave up: neither the request nor a repetition had a valid answer.
    pub lost: u64,
    /// Repetitions, also those of requests that were received damaged.
    pub repeated: u64,
    /// Damaged answers, and damaged requests that were repeated.
    pub damaged: u64,
    /// Answers that refuse: UE, RR, RS, RDL, RDH, and negative responses of DP-V1.
    pub refused: u64,
    /// Diagnoses that were fetched.
    pub diagnoses: u64,
}

impl Counts {
    /// Repetitions in percent of the requests.
    #[must_use]
    pub fn repeated_percent(&self) -> f64 {
        self.percent(self.repeated)
    }

    /// Damaged telegrams in percent of the requests.
    #[must_use]
    pub fn damaged_percent(&self) -> f64 {
        self.percent(self.damaged)
    }

    /// Lost message cycles in percent of the requests.
    #[must_use]
    pub fn lost_percent(&self) -> f64 {
        self.percent(self.lost)
    }

    #[expect(clippy::cast_precision_loss, reason = "a percentage needs no 53 bits")]
    fn percent(&self, count: u64) -> f64 {
        if self.requests == 0 { 0.0 } else { count as f64 * 100.0 / self.requests as f64 }
    }

    fn add(&mut self, other: &Self) {
        for (own, other) in self.all_mut().into_iter().zip(other.all()) {
            *own = own.saturating_add(other);
        }
    }

    const fn all(&self) -> [u64; 8] {
        let Self { requests, exchanges, unanswered, lost, repeated, damaged, refused, diagnoses } = *self;
        [requests, exchanges, unanswered, lost, repeated, damaged, refused, diagnoses]
    }

    const fn all_mut(&mut self) -> [&mut u64; 8] {
        let Self { requests, exchanges, unanswered, lost, repeated, damaged, refused, diagnoses } = self;
        [requests, exchanges, unanswered, lost, repeated, damaged, refused, diagnoses]
    }
}

/// The number of slots of a minute.
const SLOTS: usize = 12;

/// The length of a slot in milliseconds.
const SLOT_MS: u64 = 5000;

/// Counters with their last minute, in slots of five seconds: the last minute is at least 55 s and at most 60 s long.
#[derive(Clone, Debug)]
pub struct CountsOverTime {
    total: Counts,
    slots: [Counts; SLOTS],
    /// The number of the present slot since bit time 0.
    present: u64,
    slot_tbit: u64,
}

impl CountsOverTime {
    /// No requests yet.
    #[must_use]
    pub fn new(baud: Baud) -> Self {
        let slot_tbit = baud.tbit_of_ms(SLOT_MS).max(1);
        Self { total: Counts::default(), slots: [Counts::default(); SLOTS], present: 0, slot_tbit }
    }

    /// Changes the counters at `now`.
    pub fn count(&mut self, now: BitTime, change: impl Fn(&mut Counts)) {
        self.advance(now);
        change(&mut self.total);
        if let Some(slot) = self.slots.get_mut(position(self.present)) {
            change(slot);
        }
    }

    /// Counters since the beginning.
    #[must_use]
    pub const fn total(&self) -> &Counts {
        &self.total
    }

    /// Counters of the last minute at `now`.
    #[must_use]
    pub fn last_minute(&self, now: BitTime) -> Counts {
        let present = (now.0 / self.slot_tbit).max(self.present);
        let mut sum = Counts::default();
        for age in 0..SLOTS as u64 {
            let Some(number) = present.checked_sub(age) else { break };
            if number <= self.present
                && self.present.saturating_sub(number) < SLOTS as u64
                && let Some(slot) = self.slots.get(position(number))
            {
                sum.add(slot);
            }
        }
        sum
    }

    /// Clears the slots between the last change and `now`.
    fn advance(&mut self, now: BitTime) {
        let present = (now.0 / self.slot_tbit).max(self.present);
        let first = self.present.saturating_add(1).max(present.saturating_sub(SLOTS as u64 - 1));
        for number in first..=present {
            if let Some(slot) = self.slots.get_mut(position(number)) {
                *slot = Counts::default();
            }
        }
        self.present = present;
    }
}

fn position(number: u64) -> usize {
    usize::try_from(number % SLOTS as u64).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_minute_forgets_and_the_total_does_not() {
        let baud = Baud::B19200;
        let at = |seconds: u64| BitTime(baud.tbit_of_ms(seconds * 1000));
        let mut counts = CountsOverTime::new(baud);
        for second in 0..100 {
            counts.count(at(second), |counts| counts.requests += 1);
        }
        let minute = counts.last_minute(at(99)).requests;
        assert!((55..=60).contains(&minute), "{minute}");
        assert_eq!((counts.total().requests, counts.last_minute(at(1000)).requests), (100, 0));
        counts.count(at(1000), |counts| counts.repeated += 1);
        assert_eq!((counts.last_minute(at(1001)).requests, counts.last_minute(at(1001)).repeated), (0, 1));
    }

    #[test]
    fn a_percentage_without_requests_is_zero() {
        assert!(Counts::default().repeated_percent().abs() < f64::EPSILON);
        let counts = Counts { requests: 200, repeated: 3, ..Counts::default() };
        assert!((counts.repeated_percent() - 1.5).abs() < 1e-12);
    }
}
