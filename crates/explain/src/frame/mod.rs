//! Divides octets into telegrams and damaged pieces.
//!
//! The [`Framer`] chooses the division in which telegrams with a check octet (SD1, SD2, SD3) cover the most octets, and among
//! equal ones the division in which the other telegrams cover the most. Damaged octets beside a valid telegram therefore
//! never hide it: only a longer telegram that overlaps it, with a check octet and an end delimiter that fit by chance, can
//! replace it. Octets that look like a telegram inside the data of a valid one are data.
//!
//! Two rules reduce wrong divisions:
//!
//! * SD3 has no length octet and no other protection of its 14 octets, so an A2 before two telegrams easily becomes an SD3.
//!   An SD3 has a lower score than an SD1.
//! * Of two telegrams with the same end the shorter one counts, if it is an SD2 or begins a chunk. The data of a telegram may
//!   contain a telegram, but not one that ends with the end delimiter of the outer one. A telegram that was cut off may reach its
//!   announced length with the octets of the next one.
//!
//! SC and the token have no check octet, so any E5 among damaged octets looks like an SC. They are kept, because they may be
//! valid, and are [`PieceKind::Doubtful`] where they touch damaged octets of the same chunk.
//!
//! Each octet is examined once, when the telegram that may begin with it is complete, so the framer looks ahead by one longest
//! telegram. Telegrams that overlap each other are divided together; after [`MAX_CHAIN`] octets the best division up to there
//! counts. The framer therefore holds a limited number of octets and its work grows with the number of octets alone,
//! whatever they are. The result does not depend on the sizes of the chunks that continue each other.

mod division;
mod pieces;
#[cfg(test)]
mod tests;

use division::{Candidate, Division};
use profivac_dp::link::BitTime;
use profivac_wire::MAX_TELEGRAM;
use std::collections::VecDeque;

/// The number of octets without a telegram that become a damaged piece before more follow.
pub const MAX_DAMAGED: usize = 1024;

/// The longest row of telegrams that overlap each other and are divided together, in octets. chosen: a damaged telegram and
/// the one that follows it.
pub const MAX_CHAIN: usize = 2 * MAX_TELEGRAM;

/// Octets that belong together: a packet, an entry, a line, or one reception.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chunk {
    /// Start of the first octet, if the input has times.
    pub start: Option<BitTime>,
    /// The octets.
    pub octets: Vec<u8>,
    /// Positions of the octets with a character error, counted from 0.
    pub errors: Vec<usize>,
    /// The next chunk continues this one: the place between them has no meaning.
    pub is_continued: bool,
}

/// Kind of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceKind {
    /// A telegram.
    Valid,
    /// SC or a token that may be part of damaged octets.
    Doubtful,
    /// Octets that are not a telegram.
    Damaged,
}

/// A telegram, or octets between telegrams.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Start of the first octet, if the input has times.
    pub start: Option<BitTime>,
    /// The octets.
    pub octets: Vec<u8>,
    /// Positions of the octets with a character error, counted from 0.
    pub errors: Vec<usize>,
    /// Kind of the piece.
    pub kind: PieceKind,
}

/// Source of the times of octets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TimeSource {
    /// The line: each octet takes eleven bit times, and no telegram continues after T_SYN.
    #[default]
    Exact,
    /// An operating system: the time at which it delivered the chunk. A telegram may come in several chunks.
    Platform,
}

/// Divides octets that come in chunks of any size.
#[derive(Clone, Debug)]
pub struct Framer {
    times: TimeSource,
    /// The octets that are in no piece yet. All positions below count from the first one.
    octets: Vec<u8>,
    /// Positions of the octets with a character error.
    errors: VecDeque<usize>,
    /// Positions with the time of their octet, if the input has times.
    starts: VecDeque<(usize, Option<BitTime>)>,
    /// Positions between two chunks of which the second does not continue the first.
    boundaries: VecDeque<usize>,
    /// The octets before this position are in pieces.
    emitted: usize,
    /// The octets before this position are divided. They wait because they are damaged and more damaged octets may follow, or
    /// because they are in `short`.
    divided: usize,
    /// The octets before this position are examined.
    examined: usize,
    /// The best divisions of the octets from `divided` to each examined position.
    divisions: Vec<Division>,
    /// Telegrams that begin before `examined` and end after it.
    open: Vec<Candidate>,
    /// SC and tokens that are doubtful if the next octet is damaged.
    short: VecDeque<Candidate>,
    /// The last divided octet is damaged, or part of a doubtful telegram.
    is_doubtful: bool,
    work: u64,
}

impl Framer {
    /// A framer for octets with times of this source.
    #[must_use]
    pub fn new(times: TimeSource) -> Self {
        Self {
            times,
            octets: Vec::new(),
            errors: VecDeque::new(),
            starts: VecDeque::new(),
            boundaries: VecDeque::from([0]),
            emitted: 0,
            divided: 0,
            examined: 0,
            divisions: vec![Division::default()],
            open: Vec::new(),
            short: VecDeque::new(),
            is_doubtful: false,
            work: 0,
        }
    }

    /// The number of octets that are in no piece yet: at most [`MAX_DAMAGED`] that are damaged, [`MAX_CHAIN`] in telegrams that
    /// overlap each other, and one longest telegram.
    #[must_use]
    pub fn held(&self) -> usize {
        self.octets.len()
    }

    /// The number of steps so far: octets examined, alone and as part of telegrams, and octets divided again. It shows that the work is
    /// proportional to the number of octets.
    #[must_use]
    pub const fn work(&self) -> u64 {
        self.work
    }

    /// Adds a chunk. Appends the pieces that later octets cannot change to `out`.
    pub fn push(&mut self, chunk: &Chunk, out: &mut Vec<Piece>) {
        let at = self.octets.len();
        self.starts.push_back((at, chunk.start));
        self.octets.extend_from_slice(&chunk.octets);
        let errors = chunk.errors.iter().filter(|position| **position < chunk.octets.len());
        self.errors.extend(errors.map(|position| at.saturating_add(*position)));
        if !chunk.is_continued {
            self.add_boundary();
        }
        self.examine(0, out);
        self.drop_emitted();
    }

    /// Appends all pieces that are left to `out`: after a silent line or at the end of the input no telegram continues.
    pub fn flush(&mut self, out: &mut Vec<Piece>) {
        self.examine(self.octets.len(), out);
        self.emit_waiting(out);
        self.is_doubtful = false;
        self.drop_emitted();
        self.add_boundary();
    }

    /// Appends the pieces to `out` that begin with octets received before `limit`: a telegram that began so early and is not
    /// complete is damaged.
    pub fn give_up(&mut self, limit: BitTime, out: &mut Vec<Piece>) {
        let is_later = |start: &Option<BitTime>| start.is_none_or(|start| start >= limit);
        let later = self.starts.iter().find(|(_, start)| is_later(start)).map(|(at, _)| *at);
        let old = later.unwrap_or(self.octets.len());
        if old == 0 {
            return;
        }
        self.examine(old, out);
        if self.divided < old && !self.open.is_empty() {
            self.divide_early(out);
        }
        self.emit_waiting(out);
        self.drop_emitted();
    }

    fn add_boundary(&mut self) {
        if self.boundaries.back() != Some(&self.octets.len()) {
            self.boundaries.push_back(self.octets.len());
        }
    }

    fn is_boundary(&self, at: usize) -> bool {
        self.boundaries.binary_search(&at).is_ok()
    }
}

impl Default for Framer {
    fn default() -> Self {
        Self::new(TimeSource::default())
    }
}
