//! Notes: one sentence about one change on the line.

use profivac_dp::link::BitTime;

/// Subject of a note.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A station answers for the first time, not any more, or again.
    Presence,
    /// The token ring.
    Ring,
    /// Set_Prm, Chk_Cfg, Get_Cfg, Set_Slave_Add and their results.
    StartUp,
    /// A refused request.
    Refused,
    /// A request that its master sends again.
    Repetition,
    /// The owner of a slave.
    Owner,
    /// Data_Exchange begins or its states change.
    Exchange,
    /// The diagnosis of a slave.
    Diagnosis,
    /// The watchdog.
    Watchdog,
    /// Global_Control.
    Control,
    /// A connection of a class 2 master.
    Connection,
    /// A parameter that was read or written.
    Parameter,
    /// Octets that are not a telegram.
    Damaged,
}

impl Kind {
    /// The name in the JSON output.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Presence => "presence",
            Self::Ring => "ring",
            Self::StartUp => "start-up",
            Self::Refused => "refused",
            Self::Repetition => "repetition",
            Self::Owner => "owner",
            Self::Exchange => "exchange",
            Self::Diagnosis => "diagnosis",
            Self::Watchdog => "watchdog",
            Self::Control => "control",
            Self::Connection => "connection",
            Self::Parameter => "parameter",
            Self::Damaged => "damaged",
        }
    }
}

/// `1 octet`, `2 octets`.
pub(super) fn octets(count: usize) -> String {
    format!("{count} octet{}", if count == 1 { "" } else { "s" })
}

/// A sentence about a change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// Start of the telegram, if the input has times.
    pub at: Option<BitTime>,
    /// Number of the piece, counted from 1.
    pub number: usize,
    /// Address of the station; `None` for a note about the line.
    pub station: Option<u8>,
    /// Subject of the note.
    pub kind: Kind,
    /// The sentence.
    pub text: String,
}

/// Collects the notes about one piece.
pub struct Notes<'a> {
    pub(super) at: Option<BitTime>,
    pub(super) number: usize,
    pub(super) list: &'a mut Vec<Note>,
}

impl Notes<'_> {
    /// Adds a note about a station.
    pub fn about(&mut self, station: u8, kind: Kind, text: impl Into<String>) {
        self.add(Some(station), kind, text);
    }

    /// Adds a note about a station, or about the line if `station` is `None`.
    pub fn add(&mut self, station: Option<u8>, kind: Kind, text: impl Into<String>) {
        self.list.push(Note { at: self.at, number: self.number, station, kind, text: text.into() });
    }
}
