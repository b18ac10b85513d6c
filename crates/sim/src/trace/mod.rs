//! Traces: the telegrams of a line as text, one per line, and back.
//!
//! ```text
//! # 1.5 Mbit/s
//!       1000             2 -> 8    FDL_Status ?                  | 10 08 02 49 53 16
//!       1077    +11      8 -> 2    OK, passive station           | 10 02 08 00 0A 16
//!       1180    +37  damaged: character error in octet 2         | 10 08! 02 49 53 16
//! ```
//!
//! The columns are the bit time of the first start bit, the idle bit times before it, the description of the telegram
//! ([`crate::describe`]) and its octets. `!` marks an octet with a wrong parity or stop bit. Reading uses the first column and
//! the octets only.

pub mod pcap;
pub mod pcapng;
mod text;

pub(crate) use text::Line;
pub use text::{Expected, Reader, TraceError};

use crate::character::Character;
use crate::describe::Description;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT};
use profivac_wire::Telegram;
use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;

/// Telegrams, whole and damaged, in the order of their start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trace {
    /// The baud rate of the line.
    pub baud: Baud,
    /// The telegrams.
    pub entries: VecDeque<Entry>,
}

/// A telegram, or the rest of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The begin of the first start bit.
    pub start: BitTime,
    /// The octets as received, including wrong ones.
    pub octets: Arc<[u8]>,
    /// The positions of octets with a wrong parity or stop bit, counted from 0.
    pub errors: Vec<usize>,
    /// The end of the last stop bit: later than that of the characters if the sender paused or lost one.
    end: BitTime,
}

impl Entry {
    /// Characters without a pause between them.
    #[must_use]
    pub fn new(start: BitTime, octets: impl Into<Arc<[u8]>>, errors: Vec<usize>) -> Self {
        let octets = octets.into();
        Self { start, end: start + octets.len() as u64 * CHARACTER_TBIT, octets, errors }
    }

    /// A transmission without damage, from `start` to `end`.
    pub(crate) const fn clean(start: BitTime, end: BitTime, octets: Arc<[u8]>) -> Self {
        Self { start, octets, errors: Vec::new(), end }
    }

    /// A transmission from `start` to `end`, as it was received.
    pub(crate) fn read(start: BitTime, end: BitTime, characters: &[Character]) -> Self {
        let errors = (0..characters.len()).filter(|index| characters[*index].error).collect();
        Self { start, octets: characters.iter().map(|character| character.octet).collect(), errors, end }
    }

    /// The end of the last stop bit.
    #[must_use]
    pub const fn end(&self) -> BitTime {
        self.end
    }
}

/// The description of the characters.
impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.errors.is_empty() {
            return write!(f, "damaged: {}", CharacterErrors(&self.errors));
        }
        match Telegram::parse(&self.octets) {
            Ok(telegram) => Description(&telegram).fmt(f),
            Err(defect) => write!(f, "damaged: {defect}"),
        }
    }
}

/// `character error in octet 2, 5`, counted from 1.
struct CharacterErrors<'a>(&'a [usize]);

impl CharacterErrors<'_> {
    const WORDS: &'static str = "character error in octet ";
}

impl fmt::Display for CharacterErrors<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Self::WORDS)?;
        for (count, index) in self.0.iter().enumerate() {
            let comma = if count == 0 { "" } else { ", " };
            write!(f, "{comma}{}", index + 1)?;
        }
        Ok(())
    }
}
