//! One sentence of the story.

use profivac_dp::link::BitTime;

/// What a sentence is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Somebody is there, or is not there any more.
    Presence,
    /// The token ring.
    Ring,
    /// Set_Prm, Chk_Cfg, Get_Cfg, Set_Slave_Add and what came of them.
    StartUp,
    /// Somebody refuses something.
    Refused,
    /// Who owns a slave.
    Owner,
    /// Data are exchanged, or not any more.
    Exchange,
    /// What a slave says about itself.
    Diagnosis,
    /// The watchdog.
    Watchdog,
    /// Global_Control.
    Control,
    /// A connection of a class 2 master.
    Connection,
    /// A parameter, one way or the other.
    Parameter,
    /// Octets that are no telegram.
    Damaged,
}

impl Kind {
    /// The name for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Presence => "presence",
            Self::Ring => "ring",
            Self::StartUp => "start-up",
            Self::Refused => "refused",
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

/// One sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// When the telegram began that it is about, if that is known.
    pub at: Option<BitTime>,
    /// The number of the piece, counted from 1.
    pub number: usize,
    /// The station.
    pub station: Option<u8>,
    /// What it is about.
    pub kind: Kind,
    /// The sentence.
    pub text: String,
}

/// Where the sentences about one station go.
pub struct Notes<'a> {
    pub(super) at: Option<BitTime>,
    pub(super) number: usize,
    pub(super) list: &'a mut Vec<Note>,
}

impl Notes<'_> {
    /// Adds a sentence about a station.
    pub fn about(&mut self, station: u8, kind: Kind, text: impl Into<String>) {
        self.add(Some(station), kind, text);
    }

    /// Adds a sentence about a station, or about the line.
    pub fn add(&mut self, station: Option<u8>, kind: Kind, text: impl Into<String>) {
        self.list.push(Note { at: self.at, number: self.number, station, kind, text: text.into() });
    }
}
