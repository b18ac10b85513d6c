//! An event, as a row of the event list.

use crate::micros::Micros;
use crate::words;
use crate::words::Word;
use serde::Serialize;
use utoipa::ToSchema;

words! {
    /// The subject of an event.
    #[schema(as = StationEventKind)]
    pub enum EventKind {
        /// The station or one of its segments started or stopped.
        Station = "station",
        /// A slave entered or left data exchange.
        Bus = "bus",
        /// A gauge reports a fault, or no longer reports it.
        Gauge = "gauge",
        /// A user executed a command.
        Command = "command",
        /// A user made a note.
        Note = "note",
        /// A user logged in or out, a request was refused, or the users changed.
        Access = "access",
        /// An alarm changed its state.
        Alarm = "alarm",
        /// A pump-down deviates from the usual ones.
        PumpDown = "pump-down",
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Event {
    /// When, in milliseconds since 1970.
    #[serde(rename = "at_ms")]
    #[schema(value_type = i64)]
    pub at: Micros,
    /// The gauge, if the event is about one.
    pub gauge: Option<String>,
    /// The kind.
    #[schema(value_type = EventKind)]
    pub kind: Word<EventKind>,
    /// One sentence.
    pub text: String,
}
