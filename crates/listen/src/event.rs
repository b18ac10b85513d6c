//! Events: one sentence about one change on the line. The list is bounded, the oldest events leave it.

use profivac_dp::link::BitTime;
use serde::Serialize;
use std::collections::VecDeque;

/// The number of events that are kept.
pub const MAX_EVENTS: usize = 512;

/// The subject of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum EventKind {
    /// A station does not answer any more.
    Lost,
    /// A station answers again, or for the first time.
    Returned,
    /// Parameters or configuration of a slave, sent by a master.
    Configuration,
    /// The owner of a slave.
    Owner,
    /// The diagnosis of a slave.
    Diagnosis,
    /// A slave refuses a service.
    Refused,
    /// A parameter was written.
    Parameter,
    /// Many damaged telegrams in a short time.
    Burst,
    /// The token ring.
    Ring,
}

/// A change on the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// The number of the event, counted from 1.
    pub number: u64,
    /// When.
    pub at: BitTime,
    /// The station; `None` for the line.
    pub station: Option<u8>,
    /// The subject.
    pub kind: EventKind,
    /// The sentence.
    pub text: String,
}

/// The last events.
#[derive(Clone, Debug, Default)]
pub struct Events {
    list: VecDeque<Event>,
    count: u64,
}

impl Events {
    /// Adds an event.
    pub fn add(&mut self, at: BitTime, station: Option<u8>, kind: EventKind, text: String) {
        self.count = self.count.saturating_add(1);
        if self.list.len() >= MAX_EVENTS {
            self.list.pop_front();
        }
        self.list.push_back(Event { number: self.count, at, station, kind, text });
    }

    /// The events that are kept, oldest first.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &Event> {
        self.list.iter()
    }

    /// The kept events behind the one with this number.
    pub fn since(&self, number: u64) -> impl Iterator<Item = &Event> {
        // The numbers of the kept events are consecutive: the cost is that of the new events.
        let new = usize::try_from(self.count.saturating_sub(number)).unwrap_or(usize::MAX);
        self.list.iter().skip(self.list.len().saturating_sub(new))
    }

    /// The number of the last event; 0 without events.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }
}
