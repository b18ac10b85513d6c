//! Divides octets with times into telegrams and damaged pieces: a pause ends a telegram.

use super::frame::{Chunk, Framer, Piece, TimeSource};
use super::{LONGEST_DELAY, PLATFORM_SILENCE};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, T_SYN_TBIT};
use profivac_host::clock::tbit_of;

/// Divides octets into telegrams and damaged pieces. It holds a limited number of octets.
#[derive(Clone, Debug)]
pub struct Divider {
    framer: Framer,
    /// End of the last octets that had a time.
    end: Option<BitTime>,
    /// The duration of a character.
    character_tbit: u64,
    /// No telegram continues after a pause of this length.
    gap_tbit: u64,
    baud: Baud,
    times: TimeSource,
}

impl Divider {
    /// A divider without any traffic yet. Times are bit times of `baud`, which is the rate of the line.
    #[must_use]
    pub fn new(baud: Baud, times: TimeSource) -> Self {
        let gap_tbit = match times {
            TimeSource::Exact => T_SYN_TBIT,
            TimeSource::Platform => tbit_of(baud, PLATFORM_SILENCE).max(T_SYN_TBIT),
        };
        Self { framer: Framer::new(times), end: None, character_tbit: CHARACTER_TBIT, gap_tbit, baud, times }
    }

    /// The divider, for a line with another rate than the one that counts the times. Only with [`TimeSource::Platform`].
    #[must_use]
    pub fn with_line_rate(self, line: Baud) -> Self {
        Self { character_tbit: character_tbit(self.baud, line), ..self }
    }

    /// Divides octets and appends the complete pieces to `pieces`. A pause before the octets ends a telegram.
    pub fn push(&mut self, chunk: &Chunk, pieces: &mut Vec<Piece>) {
        if let (Some(end), Some(start)) = (self.end, chunk.start)
            && start - end >= self.gap_tbit
        {
            self.framer.flush(pieces);
        }
        self.end = chunk.start.map(|start| start + (chunk.octets.len() as u64).saturating_mul(self.character_tbit));
        self.framer.push(chunk, pieces);
        if let (TimeSource::Platform, Some(now)) = (self.times, chunk.start) {
            let limit = now.0.saturating_sub(tbit_of(self.baud, LONGEST_DELAY));
            self.framer.give_up(BitTime(limit), pieces);
        }
    }

    /// Appends the pieces that are left to `pieces`, at the end of the input or after a silent line.
    pub fn end(&mut self, pieces: &mut Vec<Piece>) {
        self.framer.flush(pieces);
    }
}

/// The duration of a character on a line of the rate `line`, in bit times of `clock`.
#[must_use]
pub fn character_tbit(clock: Baud, line: Baud) -> u64 {
    let [clock, line] = [clock, line].map(|baud| u64::from(baud.bits_per_second()));
    CHARACTER_TBIT.saturating_mul(clock).checked_div(line).unwrap_or(CHARACTER_TBIT)
}
