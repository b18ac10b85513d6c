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
    /// Ticks in a bit time: 2^64 / `factor`, rounded up.
    inverse: u64,
    last: u32,
    /// The part of a bit time behind `now`, in 2^-32.
    fraction: u32,
    now: BitTime,
}

impl TickClock {
    /// A clock whose bit time 0 is now. The timer must be faster than the bits.
    #[must_use]
    pub fn new(ticks_per_second: u32, baud: Baud, ticks: u32) -> Self {
        let factor = quotient(u64::from(baud.bits_per_second()) << 32, ticks_per_second);
        let factor = u32::try_from(factor).unwrap_or(u32::MAX);
        let inverse = quotient(u64::MAX, factor).saturating_add(1);
        Self { ticks_per_second, factor, inverse, last: ticks, fraction: 0, now: BitTime(0) }
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
        let tbit = u64::from(u32::try_from(tbit).unwrap_or(u32::MAX));
        let fraction = tbit.wrapping_mul(u64::from(self.inverse as u32)) >> 32;
        let ticks = tbit.wrapping_mul(self.inverse >> 32).saturating_add(fraction);
        u32::try_from(ticks.saturating_add(1)).unwrap_or(u32::MAX)
    }

    /// The same timer at another rate, whose bit time 0 is now.
    #[must_use]
    pub fn restarted(&self, baud: Baud, ticks: u32) -> Self {
        Self::new(self.ticks_per_second, baud, ticks)
    }
}

/// `value` / `divisor`, rounded down; 0 for the divisor 0. Bit by bit: it is needed once for each rate, and the division of 64 bits of
/// the compiler's library takes 900 octets. Not inlined: behind a loop the compiler would make what has a clock on the stack and copy it.
#[inline(never)]
fn quotient(value: u64, divisor: u32) -> u64 {
    if divisor == 0 {
        return 0;
    }
    let (mut rest, mut remainder, mut quotient) = (value, 0, 0);
    for _ in 0..u64::BITS {
        remainder = remainder << 1 | rest >> 63;
        rest <<= 1;
        quotient <<= 1;
        if remainder >= u64::from(divisor) {
            remainder = remainder.wrapping_sub(u64::from(divisor));
            quotient |= 1;
        }
    }
    quotient
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
    fn a_quotient_is_that_of_the_division() {
        for divisor in [1, 2, 3, 490_878, 84_000_000, u32::MAX] {
            for value in [0, 1, 19_200 << 32, 12_000_000 << 32, u64::MAX - 1, u64::MAX] {
                assert_eq!(quotient(value, divisor), value / u64::from(divisor), "{value} / {divisor}");
            }
        }
        assert_eq!(quotient(7, 0), 0);
    }

    /// One tick too many at most, so that no answer is later than it must be.
    #[test]
    fn the_ticks_in_a_time_are_not_too_many() {
        for baud in Baud::ALL {
            for tbit in [1, 11, 33, 150, 60_000] {
                let mut clock = TickClock::new(25_000_000, baud, 0);
                let ticks = clock.ticks_in(tbit);
                assert!(clock.at(ticks - 2) < BitTime(tbit), "{baud} {tbit}");
            }
        }
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
