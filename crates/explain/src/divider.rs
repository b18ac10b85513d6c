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
    /// No telegram continues after a pause of this length.
    gap_tbit: u64,
    baud: Baud,
    times: TimeSource,
}

impl Divider {
    /// A divider without any traffic yet.
    #[must_use]
    pub fn new(baud: Baud, times: TimeSource) -> Self {
        let gap_tbit = match times {
            TimeSource::Exact => T_SYN_TBIT,
            TimeSource::Platform => tbit_of(baud, PLATFORM_SILENCE).max(T_SYN_TBIT),
        };
        Self { framer: Framer::new(times), end: None, gap_tbit, baud, times }
    }

    /// Divides octets and appends the complete pieces to `pieces`. A pause before the octets ends a telegram.
    pub fn push(&mut self, chunk: &Chunk, pieces: &mut Vec<Piece>) {
        if let (Some(end), Some(start)) = (self.end, chunk.start)
            && start - end >= self.gap_tbit
        {
            self.framer.flush(pieces);
        }
        self.end = chunk.start.map(|start| start + (chunk.octets.len() as u64).saturating_mul(CHARACTER_TBIT));
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
