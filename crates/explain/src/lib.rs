#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! [`Capture`](input::Capture) reads a whole file. A [`Source`](input::Source) reads a file of any size piece by piece, and a
//! [`Tap`](tap::Tap) receives from a port without sending; both return the [`Chunk`]s that `push` takes.
//!
//! Each layer uses the layers above it in this table:
//!
//! | Layer | Module | Result |
//! |---|---|---|
//! | telegrams | [`frame`] | telegrams and damaged pieces |
//! | times | [`divider`] | telegrams and damaged pieces of octets with times |
//! | files | [`input`], [`text`] | octets from captures, traces and logs, with times if the file has times |
//! | ports | [`tap`] | octets with times, from a port that only listens |
//! | cycles | [`cycle`] | requests with their answers |
//! | names | [`names`], `refusal` (private) | parameters, values and reasons in the words of the manuals |
//! | diagnosis | [`dpv1`] | the format of device-related blocks |
//! | files | [`gsd`] | modules, parameters and diagnosis in the words of GSD files |
//! | stations | [`slave`], [`ring`], `cyclic` and `acyclic` (private) | device, owner and state of each station |
//! | sentences | [`explainer`], [`note`] | a sentence about each change |

mod acyclic;
pub mod cycle;
mod cyclic;
pub mod divider;
pub mod dpv1;
pub mod explainer;
pub mod frame;
pub mod gsd;
pub mod input;
pub mod names;
pub mod note;
mod refusal;
pub mod ring;
pub mod slave;
pub mod tap;
pub mod text;

use divider::Divider;
use explainer::Explainer;
use frame::{Chunk, Piece, TimeSource};
use gsd::Files;
use note::Note;
use profivac_dp::link::Baud;
use std::time::Duration;

/// A piece with its explanation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExplainedPiece {
    /// Number of the piece, counted from 1.
    pub number: usize,
    /// The telegram, or the damaged octets.
    pub piece: Piece,
    /// Meaning of the telegram for its station, beyond its plain description; empty if there is none.
    pub meaning: String,
    /// Sentences about the changes that this piece shows.
    pub notes: Vec<Note>,
}

/// Decodes octets into telegrams and explains them.
#[derive(Clone, Debug)]
pub struct Decoder {
    divider: Divider,
    explainer: Explainer,
    pieces: Vec<Piece>,
    number: usize,
}

/// Longest pause that an operating system or an adapter may make within a telegram. chosen: longer than the 16 ms for
/// which an adapter may hold octets back (profibus-wire 9.4, point 36), short enough for a live display.
pub const PLATFORM_SILENCE: Duration = Duration::from_millis(50);

/// Longest delay between octets on a live line and their report. chosen: longer than a telegram of 255 octets at 9.6 kbit/s
/// (292 ms), and less than a second.
pub const LONGEST_DELAY: Duration = Duration::from_millis(500);

impl Decoder {
    /// A decoder without any traffic yet. Times are bit times of `baud`, which is the rate of the line.
    #[must_use]
    pub fn new(baud: Baud, times: TimeSource) -> Self {
        Self { divider: Divider::new(baud, times), explainer: Explainer::new(baud), pieces: Vec::new(), number: 0 }
    }

    /// The decoder, for a line with another rate than the one that counts the times. Only with [`TimeSource::Platform`].
    #[must_use]
    pub fn with_line_rate(mut self, line: Baud) -> Self {
        self.divider = self.divider.with_line_rate(line);
        self
    }

    /// The decoder, with the GSD files of slaves.
    #[must_use]
    pub fn with_gsd(mut self, files: Files) -> Self {
        self.explainer = self.explainer.with_gsd(files);
        self
    }

    /// The state of the line as the traffic shows it.
    #[must_use]
    pub const fn explainer(&self) -> &Explainer {
        &self.explainer
    }

    /// Decodes octets and appends the complete pieces to `explained`. A pause before the octets ends a telegram.
    pub fn push(&mut self, chunk: &Chunk, explained: &mut Vec<ExplainedPiece>) {
        self.divider.push(chunk, &mut self.pieces);
        self.explain_pieces(explained);
    }

    /// Appends the pieces that are left to `explained`, at the end of the input or after a silent line.
    pub fn end(&mut self, explained: &mut Vec<ExplainedPiece>) {
        self.divider.end(&mut self.pieces);
        self.explain_pieces(explained);
    }

    fn explain_pieces(&mut self, explained: &mut Vec<ExplainedPiece>) {
        for piece in self.pieces.drain(..) {
            self.number = self.number.saturating_add(1);
            let mut notes = Vec::new();
            let meaning = self.explainer.piece(&piece, self.number, &mut notes);
            explained.push(ExplainedPiece { number: self.number, piece, meaning, notes });
        }
    }
}
