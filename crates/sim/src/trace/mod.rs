//! What was on the line, one telegram a line, and back again.
//!
//! ```text
//! # 1.5 Mbit/s
//!       1000             2 -> 8    FDL_Status ?                  | 10 08 02 49 53 16
//!       1077    +11      8 -> 2    OK, passive station           | 10 02 08 00 0A 16
//!       1180    +37  damaged: character error in octet 2         | 10 08! 02 49 53 16
//! ```
//!
//! The bit time of the first start bit, the idle bit times before it, the telegram in words ([`crate::describe`]) and its
//! octets. An octet whose parity or stop bit were wrong carries a `!`. Reading needs the first column and the octets.

pub mod pcapng;
mod text;

pub(crate) use text::Line;
pub use text::{Reader, TraceError};

use crate::character::Character;
use crate::describe::Description;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT};
use profivac_wire::Telegram;
use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;

/// Telegrams and what was left of them, in the order in which they began.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trace {
    /// The rate of the line.
    pub baud: Baud,
    /// What was on it.
    pub entries: VecDeque<Entry>,
}

/// Characters that followed each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// When the first start bit began.
    pub start: BitTime,
    /// What was read, wrong octets included.
    pub octets: Arc<[u8]>,
    /// The numbers of those with a wrong parity or stop bit, counted from 0.
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

    /// When the last stop bit ended, if there was no gap.
    #[must_use]
    pub fn end(&self) -> BitTime {
        self.start + self.octets.len() as u64 * CHARACTER_TBIT
    }
}

/// What the characters are, in words.
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

/// `character error in octet 2, 5`, counted from 1 as people do.
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
