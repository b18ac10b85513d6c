//! A limit for the events about one matter of a slave.

use std::time::{Duration, Instant};

/// The most events about one matter of a slave in a minute. chosen: a loose contact must not fill the list of events; the last state is told a
/// minute later.
const EVENTS_PER_MINUTE: u8 = 6;

/// How many events may still be recorded in this minute, and how many changes have had none.
pub struct Allowance {
    began: Instant,
    used: u8,
    untold: u32,
}

impl Allowance {
    pub const fn new(now: Instant) -> Self {
        Self { began: now, used: 0, untold: 0 }
    }

    /// Counts a change.
    pub const fn changed(&mut self) {
        self.untold = self.untold.saturating_add(1);
    }

    /// Whether there was a change since the last event.
    pub const fn has_changed(&self) -> bool {
        self.untold > 0
    }

    /// The end of the text of the event that is recorded now: how many changes before had none. `None` if the event must wait.
    pub fn take(&mut self, now: Instant) -> Option<String> {
        if now.saturating_duration_since(self.began) >= Duration::from_mins(1) {
            (self.began, self.used) = (now, 0);
        }
        if self.used >= EVENTS_PER_MINUTE {
            return None;
        }
        self.used = self.used.saturating_add(1);
        let earlier = match std::mem::take(&mut self.untold).saturating_sub(1) {
            0 => return Some(String::new()),
            1 => "1 earlier change".to_owned(),
            several => format!("{several} earlier changes"),
        };
        Some(format!(" ({earlier} had no event: at most {EVENTS_PER_MINUTE} a minute)"))
    }
}
