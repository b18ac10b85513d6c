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

/// Characters without a gap: a telegram or the rest of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The begin of the first start bit.
    pub start: BitTime,
    /// The octets as received, including wrong ones.
    pub octets: Arc<[u8]>,
    /// The positions of octets with a wrong parity or stop bit, counted from 0.
    pub errors: Vec<usize>,
}

impl Entry {
    pub(crate) const fn clean(start: BitTime, octets: Arc<[u8]>) -> Self {
        Self { start, octets, errors: Vec::new() }
    }

    pub(crate) fn read(start: BitTime, characters: &[Character]) -> Self {
        let errors = (0..characters.len()).filter(|place| characters[*place].error).collect();
        Self { start, octets: characters.iter().map(|character| character.octet).collect(), errors }
    }

    /// The end of the last stop bit.
    #[must_use]
    pub fn end(&self) -> BitTime {
        self.start + self.octets.len() as u64 * CHARACTER_TBIT
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
        for (count, place) in self.0.iter().enumerate() {
            let comma = if count == 0 { "" } else { ", " };
            write!(f, "{comma}{}", place + 1)?;
        }
        Ok(())
    }
}
