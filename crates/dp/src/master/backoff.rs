//! When a slave is asked again: later and later while things go wrong, and never sooner than it can bear.
//!
//! The first failure costs no pause. Each further one doubles it, from [`Settings::pause_min_tbit`] to
//! [`Settings::pause_max_tbit`], where it stays: nobody is given up for ever. Only data exchange that lasted longer than
//! the longest pause begins anew; a slave that falls out every time is started ever more slowly as well.
//! free choice: the reference says "slow retry" (profibus-wire 3.10).

use super::parameters::Settings;
use crate::link::BitTime;

/// The pauses of one slave.
#[derive(Clone, Copy, Debug)]
pub(super) struct BackOff {
    /// Nothing is asked before.
    resume_at: BitTime,
    /// How long to pause next time something goes wrong.
    pause_tbit: u64,
    /// Data exchange began, and nothing went wrong since.
    exchanging_since: Option<BitTime>,
}

impl BackOff {
    pub(super) const fn new() -> Self {
        Self { resume_at: BitTime(0), pause_tbit: 0, exchanging_since: None }
    }

    /// Whether it may be asked.
    #[inline]
    pub(super) fn is_over(&self, now: BitTime) -> bool {
        self.resume_at <= now
    }

    /// Data exchange begins.
    pub(super) const fn exchange_began(&mut self, now: BitTime) {
        self.exchanging_since = Some(now);
    }

    /// Something went wrong.
    pub(super) fn failed(&mut self, now: BitTime, settings: &Settings) {
        let Settings { pause_min_tbit, pause_max_tbit, .. } = *settings;
        if self.exchanging_since.take().is_some_and(|since| now >= since + pause_max_tbit) {
            self.pause_tbit = 0;
        }
        self.resume_at = now + self.pause_tbit;
        self.pause_tbit = self.pause_tbit.saturating_mul(2).max(pause_min_tbit).min(pause_max_tbit);
    }

    /// Another state may begin at once.
    pub(super) const fn clear_pause(&mut self, now: BitTime) {
        self.resume_at = now;
    }

    /// What went wrong is forgotten, and there is no pause after `at`.
    pub(super) const fn reset(&mut self, at: BitTime) {
        *self = Self { resume_at: at, ..Self::new() };
    }

    /// Min_Slave_Interval: no request before this, whatever it is.
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

    /// How long the pause is after a failure at `now`.
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
    fn only_exchange_that_lasted_begins_anew() {
        let mut back_off = BackOff::new();
        (0..3).for_each(|now| back_off.failed(BitTime(now), &SETTINGS));
        back_off.exchange_began(BitTime(100));
        assert_eq!(pause(&mut back_off, 164), 40, "well for 64 bit times");
        back_off.exchange_began(BitTime(300));
        assert_eq!(pause(&mut back_off, 365), 0, "well for 65");
        assert_eq!(pause(&mut back_off, 1_000_000), 10, "and that counts once");
    }
}
