//! A moment on the two clocks of a station.

use profivac_recorder::Micros;
use std::time::{Duration, Instant};

/// A moment on the clock that is never set, which measures silences and intervals, and on that of the system, which dates samples and
/// events.
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
