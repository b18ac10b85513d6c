//! What was on a line, told in words.
//!
//! | Layer | Module | Makes |
//! |---|---|---|
//! | ports | [`tap`] | octets with times, from a line that is only listened to |
//! | files | [`input`], [`printed`] | octets, with times if there are any, out of captures, traces and prints |
//! | telegrams | [`frame`] | telegrams and damaged pieces |
//! | cycles | [`cycle`] | requests with their answers |
//! | stations | [`slave`], [`ring`], and inside `cyclic`, `acyclic` | what each is, whose, and in which state |
//! | names | [`names`], and inside `refusal` | parameters, values and reasons in the words of the manuals |
//! | story | [`story`], [`note`] | sentences about what changes |
//!
//! ```
//! use profivac_dp::link::Baud;
//! use profivac_explain::{Teller, input::Recording};
//!
//! let log = b"TX 68 07 07 68 FF 82 46 3A 3E 02 00 41 16\n";
//! let log = Recording::read(log, Baud::B19200)?;
//! let mut teller = Teller::new(log.baud.unwrap_or(Baud::B19200), log.times);
//! let mut told = Vec::new();
//! log.noted.iter().for_each(|noted| teller.noted(noted, &mut told));
//! teller.end(&mut told);
//! assert_eq!(told[0].notes[0].text, "master 2 orders Clear_Data to all");
//! # Ok::<(), profivac_explain::input::BadInput>(())
//! ```

mod acyclic;
pub mod cycle;
mod cyclic;
pub mod explainer;
pub mod frame;
pub mod input;
pub mod names;
pub mod note;
pub mod octet_row;
mod refusal;
pub mod ring;
pub mod slave;
pub mod tap;

use explainer::Explainer;
use frame::{Framer, Piece, TimeSource};
use input::Chunk;
use note::Note;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, T_SYN_TBIT};
use profivac_host::clock::tbit_of;
use std::time::Duration;

/// A piece and what is to be said about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExplainedPiece {
    /// Its number, counted from 1.
    pub number: usize,
    /// The telegram, or the damaged octets.
    pub piece: Piece,
    /// What it means to the station concerned, beyond what every telegram says by itself.
    pub meaning: String,
    /// What is new with it.
    pub notes: Vec<Note>,
}

/// From octets to the story.
#[derive(Clone, Debug)]
pub struct Decoder {
    framer: Framer,
    explainer: Explainer,
    pieces: Vec<Piece>,
    number: usize,
    /// When the last octets with a time ended.
    end: Option<BitTime>,
    /// After such a pause nothing goes on.
    gap_tbit: u64,
}

/// How long an operating system or an adapter may pause within a telegram. free choice: longer than the 16 ms for which an
/// adapter may keep octets (profibus-wire 9.4, point 36), short enough to watch.
pub const PLATFORM_SILENCE: Duration = Duration::from_millis(50);

impl Decoder {
    /// Nothing was heard yet.
    #[must_use]
    pub fn new(baud: Baud, times: TimeSource) -> Self {
        let gap_tbit = match times {
            TimeSource::Exact => T_SYN_TBIT,
            TimeSource::Platform => tbit_of(baud, PLATFORM_SILENCE).max(T_SYN_TBIT),
        };
        let (framer, explainer) = (Framer::new(times), Explainer::new(baud));
        Self { framer, explainer, pieces: Vec::new(), number: 0, end: None, gap_tbit }
    }

    /// What is known of the line.
    #[must_use]
    pub const fn explainer(&self) -> &Explainer {
        &self.explainer
    }

    /// Octets came. A telegram does not go on after an idle line.
    pub fn push(&mut self, noted: &Chunk, told: &mut Vec<ExplainedPiece>) {
        if let (Some(end), Some(start)) = (self.end, noted.start)
            && start - end >= self.gap_tbit
        {
            self.framer.flush(&mut self.pieces);
        }
        self.end = noted.start.map(|start| start + (noted.octets.len() as u64).saturating_mul(CHARACTER_TBIT));
        self.framer.push(noted.start, &noted.octets, &noted.errors, &mut self.pieces);
        self.explain_pieces(told);
    }

    /// The line has been silent, or there is no more.
    pub fn end(&mut self, told: &mut Vec<ExplainedPiece>) {
        self.framer.flush(&mut self.pieces);
        self.explain_pieces(told);
    }

    fn explain_pieces(&mut self, told: &mut Vec<ExplainedPiece>) {
        for piece in self.pieces.drain(..) {
            self.number = self.number.saturating_add(1);
            let mut notes = Vec::new();
            let meaning = self.explainer.piece(&piece, self.number, &mut notes);
            told.push(ExplainedPiece { number: self.number, piece, meaning, notes });
        }
    }
}
