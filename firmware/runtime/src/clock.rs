//! Ticks of a timer to bit times.

use profivac_dp::link::{Baud, BitTime};

/// Bit times from the ticks of a timer of 32 bits that wraps.
///
/// Clocks with the same ticks, rate and origin agree exactly, so each context has one of its own. [`at`](Self::at) must be called more
/// often than the timer wraps.
#[derive(Clone, Debug)]
pub struct TickClock {
    ticks_per_second: u32,
    /// Bit times in a tick, in 2^-32.
    factor: u32,
    last: u32,
    /// The part of a bit time behind `now`, in 2^-32.
    fraction: u32,
    now: BitTime,
}

impl TickClock {
    /// A clock whose bit time 0 is now. The timer must be faster than the bits.
    #[must_use]
    pub fn new(ticks_per_second: u32, baud: Baud, ticks: u32) -> Self {
        let factor = (u64::from(baud.bits_per_second()) << 32).checked_div(u64::from(ticks_per_second)).unwrap_or(0);
        let factor = u32::try_from(factor).unwrap_or(u32::MAX);
        Self { ticks_per_second, factor, last: ticks, fraction: 0, now: BitTime(0) }
    }

    /// The bit time at these ticks, which are not before those of the call before.
    #[inline]
    pub fn at(&mut self, ticks: u32) -> BitTime {
        let passed = ticks.wrapping_sub(self.last);
        self.last = ticks;
        // At most (2^32 - 1)^2 + 2^32 - 1.
        let sum = u64::from(passed).wrapping_mul(u64::from(self.factor)).wrapping_add(u64::from(self.fraction));
        self.fraction = sum as u32;
        self.now = self.now + (sum >> 32);
        self.now
    }

    /// The ticks in this number of bit times, rounded up.
    #[must_use]
    pub fn ticks_in(&self, tbit: u64) -> u32 {
        let ticks = (tbit << 32).checked_div(u64::from(self.factor)).unwrap_or(0);
        u32::try_from(ticks.saturating_add(1)).unwrap_or(u32::MAX)
    }

    /// The same timer at another rate, whose bit time 0 is now.
    #[must_use]
    pub fn restarted(&self, baud: Baud, ticks: u32) -> Self {
        Self::new(self.ticks_per_second, baud, ticks)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn every_rate_keeps_time_over_many_wraps_of_the_timer() {
        for baud in Baud::ALL {
            let mut clock = TickClock::new(84_000_000, baud, 7);
            let (mut ticks, mut total) = (7u32, 0u64);
            for step in 0..2_000u32 {
                let passed = 3_000_000_000u32.wrapping_add(step.wrapping_mul(977));
                ticks = ticks.wrapping_add(passed);
                total += u64::from(passed);
                clock.at(ticks);
            }
            let wanted = u128::from(total) * u128::from(baud.bits_per_second()) / 84_000_000;
            let found = u128::from(clock.at(ticks).0);
            assert!(wanted.abs_diff(found) * 500_000 < wanted, "{baud}: {found} instead of {wanted}");
        }
    }

    #[test]
    fn two_clocks_agree_whenever_they_are_asked() {
        let mut often = TickClock::new(25_000_000, Baud::B1500000, 0);
        let mut seldom = often.clone();
        for ticks in (0..1_000_000u32).step_by(13) {
            often.at(ticks);
        }
        assert_eq!(often.at(1_000_000), seldom.at(1_000_000));
    }

    #[test]
    fn the_ticks_in_a_time_are_not_too_few() {
        for baud in Baud::ALL {
            for tbit in [1, 11, 33, 150, 60_000] {
                let mut clock = TickClock::new(25_000_000, baud, 0);
                let ticks = clock.ticks_in(tbit);
                assert!(clock.at(ticks) >= BitTime(tbit), "{baud} {tbit}");
            }
        }
    }
}
