//! A moment on the two clocks of a station.

use profivac_dp::link::{Baud, BitTime};
use profivac_host::clock::duration_of;
use profivac_recorder::Micros;
use std::time::{Duration, Instant};

/// The same moment on two clocks: one that is never set measures silences and intervals, the clock of the system dates samples and events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    /// On the clock that is never set.
    pub at: Instant,
    /// On the clock of the system.
    pub wall: Micros,
}

impl Moment {
    /// The moment `time` ago.
    pub fn before(self, time: Duration) -> Self {
        Self { at: self.at.checked_sub(time).unwrap_or(self.at), wall: self.wall.before(time) }
    }

    /// The time since an earlier moment.
    pub fn since(self, earlier: Self) -> Duration {
        self.at.saturating_duration_since(earlier.at)
    }
}

/// The present moment on the clocks of a station, and on the clock of a line.
#[derive(Clone, Copy, Debug)]
pub struct LineMoment {
    /// On the clocks of the station.
    pub now: Moment,
    /// On the clock of the line.
    pub bus_time: BitTime,
    /// The rate of the line.
    pub baud: Baud,
}

impl LineMoment {
    /// The moment of an earlier time of the line.
    pub fn of(self, earlier: BitTime) -> Moment {
        self.now.before(duration_of(self.baud, self.bus_time - earlier))
    }
}
