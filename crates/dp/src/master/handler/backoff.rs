//! The pauses before a master asks a faulty slave again: longer and longer, and never shorter than Min_Slave_Interval.
//!
//! After the first failure there is no pause. Each further failure doubles the pause, from [`Settings::pause_min_tbit`] to
//! [`Settings::pause_max_tbit`], where it stays: the master never gives a slave up. Only a data exchange that lasted longer
//! than the longest pause resets it, so a slave that leaves data exchange every time is also started more and more slowly.
//! chosen: the reference says "slow retry" (profibus-wire 3.10).

use super::super::parameters::Settings;
use crate::link::BitTime;

/// The pauses of one slave.
#[derive(Clone, Copy, Debug)]
pub(super) struct BackOff {
    /// No request before this time.
    resume_at: BitTime,
    /// The pause after the next failure.
    pause_tbit: u64,
    /// Data exchange began at this time, without a failure since.
    exchanging_since: Option<BitTime>,
}

impl BackOff {
    pub(super) const fn new() -> Self {
        Self { resume_at: BitTime(0), pause_tbit: 0, exchanging_since: None }
    }

    /// Whether the pause is over.
    #[inline]
    pub(super) fn is_over(&self, now: BitTime) -> bool {
        self.resume_at <= now
    }

    /// Data exchange begins.
    pub(super) const fn exchange_began(&mut self, now: BitTime) {
        self.exchanging_since = Some(now);
    }

    /// Begins a pause after a failure.
    pub(super) fn failed(&mut self, now: BitTime, settings: &Settings) {
        let Settings { pause_min_tbit, pause_max_tbit, .. } = *settings;
        if self.exchanging_since.take().is_some_and(|since| now >= since + pause_max_tbit) {
            self.pause_tbit = 0;
        }
        self.resume_at = now + self.pause_tbit;
        self.pause_tbit = self.pause_tbit.saturating_mul(2).max(pause_min_tbit).min(pause_max_tbit);
    }

    /// Ends the pause: the next state begins at once.
    pub(super) const fn clear_pause(&mut self, now: BitTime) {
        self.resume_at = now;
    }

    /// Clears all failures; there is no pause after `at`.
    pub(super) const fn reset(&mut self, at: BitTime) {
        *self = Self { resume_at: at, ..Self::new() };
    }

    /// Min_Slave_Interval: no request of any kind before `earliest`.
    #[inline]
    pub(super) fn not_before(&mut self, earliest: BitTime) {
        self.resume_at = self.resume_at.max(earliest);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::link::Baud;
    use std::vec::Vec;

    const SETTINGS: Settings = Settings { pause_min_tbit: 10, pause_max_tbit: 65, ..Settings::new(Baud::B19200) };

    /// The pause after a failure at `now`.
    fn pause(back_off: &mut BackOff, now: u64) -> u64 {
        back_off.failed(BitTime(now), &SETTINGS);
        (0..).find(|pause| back_off.is_over(BitTime(now) + *pause)).unwrap()
    }

    #[test]
    fn pauses_double_up_to_the_longest_and_stay_there() {
        let mut back_off = BackOff::new();
        let pauses: Vec<_> = (0..6).map(|now| pause(&mut back_off, 1000 * now)).collect();
        assert_eq!(pauses, [0, 10, 20, 40, 65, 65]);
    }

    #[test]
    fn only_a_data_exchange_longer_than_the_longest_pause_resets_the_pauses() {
        let mut back_off = BackOff::new();
        (0..3).for_each(|now| back_off.failed(BitTime(now), &SETTINGS));
        back_off.exchange_began(BitTime(100));
        assert_eq!(pause(&mut back_off, 164), 40, "after 64 bit times of data exchange");
        back_off.exchange_began(BitTime(300));
        assert_eq!(pause(&mut back_off, 365), 0, "after 65 bit times");
        assert_eq!(pause(&mut back_off, 1_000_000), 10, "the reset counts once");
    }
}
