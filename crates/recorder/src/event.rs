//! An event, as a row of the event list.

use super::sample::Micros;
use serde::{Serialize, Serializer};

/// The subject of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The station or one of its segments started or stopped.
    Station,
    /// A slave entered or left data exchange.
    Bus,
    /// A gauge reports a fault, or no longer reports it.
    Gauge,
    /// A user executed a command.
    Command,
    /// A user made a note.
    Note,
    /// A user logged in or out, a request was refused, or the users changed.
    Access,
    /// An alarm changed its state.
    Alarm,
    /// A pump-down deviates from the usual ones.
    PumpDown,
}

impl EventKind {
    /// All kinds.
    pub const ALL: [Self; 8] =
        [Self::Station, Self::Bus, Self::Gauge, Self::Command, Self::Note, Self::Access, Self::Alarm, Self::PumpDown];

    /// The word in the database and in the API.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Station => "station",
            Self::Bus => "bus",
            Self::Gauge => "gauge",
            Self::Command => "command",
            Self::Note => "note",
            Self::Access => "access",
            Self::Alarm => "alarm",
            Self::PumpDown => "pump-down",
        }
    }

    /// The kind with this word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.word() == word)
    }
}

impl Serialize for EventKind {
    /// As its word.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// When it happened.
    pub at: Micros,
    /// The name of the gauge, if it is about one.
    pub gauge: Option<String>,
    /// The subject.
    pub kind: EventKind,
    /// One sentence.
    pub text: String,
}
