//! Converts between bit times and the clock of the system.

use profivac_dp::link::{Baud, BitTime};
use std::time::{Duration, Instant};

const NANOSECONDS: u128 = 1_000_000_000;

/// The duration of `tbit` bit times at `baud`, rounded up.
#[must_use]
pub fn duration_of(baud: Baud, tbit: u64) -> Duration {
    let nanoseconds = (u128::from(tbit) * NANOSECONDS).div_ceil(u128::from(baud.bits_per_second()));
    Duration::from_nanos(u64::try_from(nanoseconds).unwrap_or(u64::MAX))
}

/// The whole bit times in `duration` at `baud`.
#[must_use]
pub fn tbit_of(baud: Baud, duration: Duration) -> u64 {
    let tbit = duration.as_nanos() * u128::from(baud.bits_per_second()) / NANOSECONDS;
    u64::try_from(tbit).unwrap_or(u64::MAX)
}

/// The monotonic clock of the system in bit times.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    baud: Baud,
    start: Instant,
    first: BitTime,
}

impl Clock {
    /// A clock that shows `first` now.
    #[must_use]
    pub fn starting_at(first: BitTime, baud: Baud) -> Self {
        Self { baud, start: Instant::now(), first }
    }

    /// The time it shows.
    #[must_use]
    pub fn now(&self) -> BitTime {
        self.first + tbit_of(self.baud, self.start.elapsed())
    }

    /// The duration until it shows `moment`. Zero if that has passed.
    #[must_use]
    pub fn time_until(&self, moment: BitTime) -> Duration {
        duration_of(self.baud, moment - self.now())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_and_bit_times_agree_at_every_rate() {
        for baud in Baud::ALL {
            for tbit in [0, 1, 11, 33, 5_000, 1 << 40] {
                assert_eq!(tbit_of(baud, duration_of(baud, tbit)), tbit, "{tbit} at {baud}");
            }
        }
        assert_eq!(duration_of(Baud::B19200, 192), Duration::from_millis(10));
        assert_eq!(duration_of(Baud::B9600, u64::MAX), Duration::from_nanos(u64::MAX));
    }
}
