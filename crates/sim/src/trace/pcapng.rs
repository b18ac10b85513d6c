//! Capture files that other programs read.
//!
//! A file has a section header, one interface with its link type and rate, and one packet for each entry of the trace: the
//! octets from start to end delimiter. Times are nanoseconds since the beginning of the trace; a bit of 12 Mbit/s has 83,
//! so the bit times come back exactly. Octets with character errors are named in a comment and by the symbol error flag,
//! because a packet has no room for them.

use super::{CharacterErrors, Entry, Trace};
use profivac_dp::link::{Baud, BitTime};
use std::fmt;

/// LINKTYPE_PROFIBUS_DL: data link layer telegrams of IEC 61158-4-3.
pub const PROFIBUS_DL: u16 = 257;
/// LINKTYPE_USER0: a type of private use, to which a dissector can be bound.
pub const USER0: u16 = 147;

const SECTION_HEADER: u32 = 0x0A0D_0D0A;
const BYTE_ORDER: u32 = 0x1A2B_3C4D;
const INTERFACE: u32 = 1;
const ENHANCED_PACKET: u32 = 6;

const OPT_COMMENT: u16 = 1;
const EPB_FLAGS: u16 = 2;
const IF_SPEED: u16 = 8;
const IF_TSRESOL: u16 = 9;

/// In epb_flags: a character of the link layer was wrong.
const SYMBOL_ERROR: u32 = 1 << 31;

const NANOSECONDS: u128 = 1_000_000_000;

/// The trace as a capture file of `link_type`, [`PROFIBUS_DL`] or [`USER0`].
#[must_use]
pub fn write(trace: &Trace, link_type: u16) -> Vec<u8> {
    let mut file = head(trace.baud, link_type);
    trace.entries.iter().for_each(|entry| file.extend(packet(entry, trace.baud)));
    file
}

/// What a file begins with: for a file that grows, packet by packet.
#[must_use]
pub fn head(baud: Baud, link_type: u16) -> Vec<u8> {
    let mut file = Vec::new();
    // Version 1.0, length of the section not given.
    block(&mut file, SECTION_HEADER, &[&BYTE_ORDER.to_le_bytes(), &[1, 0, 0, 0], &[0xFF; 8]]);
    let mut options = option(IF_TSRESOL, &[9]);
    options.extend(option(IF_SPEED, &u64::from(baud.bits_per_second()).to_le_bytes()));
    options.extend(option(0, &[]));
    // No limit to the length of a packet.
    block(&mut file, INTERFACE, &[&link_type.to_le_bytes(), &[0; 6], &options]);
    file
}

/// The octets of one packet.
#[must_use]
pub fn packet(entry: &Entry, baud: Baud) -> Vec<u8> {
    let (mut file, rate) = (Vec::new(), u128::from(baud.bits_per_second()));
    let time = ((u128::from(entry.start.0) * NANOSECONDS + rate / 2) / rate) as u64;
    let length = (entry.octets.len() as u32).to_le_bytes();
    let (high, low) = ((time >> 32) as u32, time as u32);
    let mut options = Vec::new();
    if !entry.errors.is_empty() {
        options.extend(option(OPT_COMMENT, CharacterErrors(&entry.errors).to_string().as_bytes()));
        options.extend(option(EPB_FLAGS, &SYMBOL_ERROR.to_le_bytes()));
        options.extend(option(0, &[]));
    }
    let octets = padded(&entry.octets);
    let (high, low) = (high.to_le_bytes(), low.to_le_bytes());
    block(&mut file, ENHANCED_PACKET, &[&[0; 4], &high, &low, &length, &length, &octets, &options]);
    file
}

fn block(file: &mut Vec<u8>, kind: u32, parts: &[&[u8]]) {
    let length = parts.iter().map(|part| part.len() as u32).sum::<u32>() + 12;
    file.extend(kind.to_le_bytes());
    file.extend(length.to_le_bytes());
    parts.iter().for_each(|part| file.extend(*part));
    file.extend(length.to_le_bytes());
}

fn option(code: u16, value: &[u8]) -> Vec<u8> {
    let length = value.len() as u16;
    [&code.to_le_bytes()[..], &length.to_le_bytes(), &padded(value)].concat()
}

/// Everything begins at a multiple of four octets.
fn padded(octets: &[u8]) -> Vec<u8> {
    let mut padded = octets.to_vec();
    padded.resize(octets.len().next_multiple_of(4), 0);
    padded
}

/// Why octets are no capture file that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadCapture {
    /// It does not begin with the section header of pcapng.
    NotPcapng,
    /// A block is shorter than its kind needs, or longer than the file.
    Block {
        /// Where it begins.
        offset: usize,
    },
    /// A packet of an interface that was not described.
    Interface {
        /// Where the packet begins.
        offset: usize,
    },
    /// An interface with telegrams of something else.
    LinkType(u16),
}

impl fmt::Display for BadCapture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPcapng => f.write_str("expected a pcapng file, found no section header"),
            Self::Block { offset } => write!(f, "the block at octet {offset} does not fit the file"),
            Self::Interface { offset } => write!(f, "the packet at octet {offset} belongs to no interface"),
            Self::LinkType(other) => {
                write!(f, "expected link type {PROFIBUS_DL} or {USER0}, found {other}")
            }
        }
    }
}

impl std::error::Error for BadCapture {}

/// Reads a capture file. Blocks of other kinds are skipped. A file that does not say its rate gets `otherwise`.
///
/// # Errors
/// [`BadCapture`] when the octets are no such file.
pub fn read(file: &[u8], otherwise: Baud) -> Result<Trace, BadCapture> {
    let (trace, damage) = read_until_damage(file, otherwise);
    damage.map_or(Ok(trace), Err)
}

/// Reads a capture file as far as it is whole: one whose writer was killed ends within a packet. Says what stopped it.
#[must_use]
pub fn read_until_damage(file: &[u8], otherwise: Baud) -> (Trace, Option<BadCapture>) {
    let mut blocks = Blocks { file, offset: 0, big_endian: false };
    let mut trace = Trace { baud: otherwise, entries: Default::default() };
    if !matches!(blocks.next(), Some(Ok((_, SECTION_HEADER, _)))) {
        return (trace, Some(BadCapture::NotPcapng));
    }
    let mut interfaces = Vec::new();
    let damage = blocks.find_map(|block| block.and_then(|block| add(&mut trace, &mut interfaces, block)).err());
    (trace, damage)
}

/// What a block adds to the trace.
fn add(
    trace: &mut Trace,
    interfaces: &mut Vec<Interface>,
    (offset, kind, body): (usize, u32, Fields<'_>),
) -> Result<(), BadCapture> {
    match kind {
        SECTION_HEADER => interfaces.clear(),
        INTERFACE => {
            let interface = Interface::read(body).ok_or(BadCapture::Block { offset })??;
            trace.baud = interface.baud.unwrap_or(trace.baud);
            interfaces.push(interface);
        }
        ENHANCED_PACKET => {
            let number = body.clone().long().ok_or(BadCapture::Block { offset })?;
            let interface = interfaces.get(number as usize).ok_or(BadCapture::Interface { offset })?;
            let entry = interface.entry(body, trace.baud).ok_or(BadCapture::Block { offset })?;
            trace.entries.push_back(entry);
        }
        _ => {}
    }
    Ok(())
}

/// Walks over the blocks of a file.
struct Blocks<'a> {
    file: &'a [u8],
    offset: usize,
    big_endian: bool,
}

impl<'a> Iterator for Blocks<'a> {
    type Item = Result<(usize, u32, Fields<'a>), BadCapture>;

    fn next(&mut self) -> Option<Self::Item> {
        let offset = self.offset;
        let rest = self.file.get(offset..).filter(|rest| !rest.is_empty())?;
        let block = self.block(rest);
        // After a block without an end there is nothing more to find.
        self.offset = block.as_ref().map_or(self.file.len(), |(length, ..)| offset + length);
        Some(block.map(|(_, kind, body)| (offset, kind, body)).ok_or(BadCapture::Block { offset }))
    }
}

impl<'a> Blocks<'a> {
    /// Its length, kind and what is in it.
    fn block(&mut self, rest: &'a [u8]) -> Option<(usize, u32, Fields<'a>)> {
        if rest.starts_with(&SECTION_HEADER.to_le_bytes()) {
            self.big_endian = rest.get(8..12)? == BYTE_ORDER.to_be_bytes();
        }
        let mut head = Fields { octets: rest, big_endian: self.big_endian };
        let (kind, length) = (head.long()?, head.long()? as usize);
        let body = rest.get(8..length.checked_sub(4)?)?;
        let whole = length >= 12 && length % 4 == 0 && length <= rest.len();
        whole.then_some((length, kind, Fields { octets: body, big_endian: self.big_endian }))
    }
}

/// Takes fields from the front of a block.
#[derive(Clone)]
struct Fields<'a> {
    octets: &'a [u8],
    big_endian: bool,
}

impl<'a> Fields<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.octets.split_at_checked(count)?;
        self.octets = rest;
        Some(taken)
    }

    /// An unsigned number of `count` octets.
    fn number(&mut self, count: usize) -> Option<u64> {
        let octets = self.take(count)?.iter();
        let joined = |number, octet: &u8| number << 8 | u64::from(*octet);
        Some(if self.big_endian { octets.fold(0, joined) } else { octets.rev().fold(0, joined) })
    }

    fn long(&mut self) -> Option<u32> {
        self.number(4).map(|number| number as u32)
    }

    fn short(&mut self) -> Option<u16> {
        self.number(2).map(|number| number as u16)
    }

    /// The next option, `None` at their end.
    fn option(&mut self) -> Option<(u16, Self)> {
        let (code, length) = (self.short()?, usize::from(self.short()?));
        let octets = self.take(length.next_multiple_of(4))?.get(..length)?;
        (code != 0).then_some((code, Self { octets, ..*self }))
    }
}

/// How the packets of an interface are to be read.
struct Interface {
    baud: Option<Baud>,
    ticks_per_second: u128,
}

impl Interface {
    fn read(mut body: Fields<'_>) -> Option<Result<Self, BadCapture>> {
        let link_type = body.short()?;
        if link_type != PROFIBUS_DL && link_type != USER0 {
            return Some(Err(BadCapture::LinkType(link_type)));
        }
        body.take(6)?;
        let mut interface = Self { baud: None, ticks_per_second: 1_000_000 };
        while let Some((code, mut value)) = body.option() {
            match code {
                IF_SPEED => interface.baud = rate(value.number(8)?),
                IF_TSRESOL => interface.ticks_per_second = ticks(value.number(1)?)?,
                _ => {}
            }
        }
        Some(Ok(interface))
    }

    fn entry(&self, mut body: Fields<'_>, baud: Baud) -> Option<Entry> {
        body.long()?;
        let (high, low) = (u64::from(body.long()?), u64::from(body.long()?));
        let (length, _) = (body.long()? as usize, body.long()?);
        let octets = body.take(length.checked_next_multiple_of(4)?)?.get(..length)?;
        let ticks = u128::from(high << 32 | low) * u128::from(baud.bits_per_second());
        let start = BitTime(((ticks + self.ticks_per_second / 2) / self.ticks_per_second) as u64);
        let mut errors = Vec::new();
        while let Some((code, value)) = body.option() {
            if code == OPT_COMMENT {
                errors = character_errors(value.octets).unwrap_or_default();
            }
        }
        Some(Entry { start, octets: octets.into(), errors })
    }
}

fn rate(speed: u64) -> Option<Baud> {
    u32::try_from(speed).ok().and_then(Baud::from_bits_per_second)
}

/// if_tsresol: a negative power of ten, or of two if bit 7 is set.
fn ticks(resolution: u64) -> Option<u128> {
    let base: u128 = if resolution & 0x80 != 0 { 2 } else { 10 };
    // 2^64 ticks a second are finer than any clock; more would leave no room for the product with the rate.
    base.checked_pow((resolution & 0x7F) as u32).filter(|ticks| *ticks <= 1 << 64)
}

/// The comment that [`packet`] wrote. Any other says nothing about octets.
fn character_errors(comment: &[u8]) -> Option<Vec<usize>> {
    let numbers = std::str::from_utf8(comment).ok()?.strip_prefix(CharacterErrors::WORDS)?;
    numbers.split(", ").map(|number| number.parse::<usize>().ok()?.checked_sub(1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::hex;

    fn trace(baud: Baud) -> Trace {
        let entry = |start, text, errors| Entry { start: BitTime(start), octets: hex(text).into(), errors };
        let entries = [
            entry(33, "10 08 02 49 53 16", vec![]),
            entry(7_777_777_777, "10 02 08 00 0A 16", vec![1, 4]),
            entry(123_456_789_012_345, "E5", vec![]),
        ];
        Trace { baud, entries: entries.into() }
    }

    #[test]
    fn what_was_written_is_read_at_every_rate_and_for_both_link_types() {
        for baud in Baud::ALL {
            for link_type in [PROFIBUS_DL, USER0] {
                let trace = trace(baud);
                assert_eq!(read(&write(&trace, link_type), Baud::B9600), Ok(trace), "{baud}");
            }
        }
    }

    #[test]
    fn the_octets_of_a_file_are_those_of_the_format() {
        let mut trace = trace(Baud::B12000000);
        trace.entries.truncate(1);
        let expected = "
            0A 0D 0D 0A 1C 00 00 00 4D 3C 2B 1A 01 00 00 00 FF FF FF FF FF FF FF FF 1C 00 00 00
            01 00 00 00 2C 00 00 00 01 01 00 00 00 00 00 00 09 00 01 00 09 00 00 00
            08 00 08 00 00 1B B7 00 00 00 00 00 00 00 00 00 2C 00 00 00
            06 00 00 00 28 00 00 00 00 00 00 00 00 00 00 00 BE 0A 00 00 06 00 00 00 06 00 00 00
            10 08 02 49 53 16 00 00 28 00 00 00";
        assert_eq!(write(&trace, PROFIBUS_DL), hex(expected));
    }

    #[test]
    fn files_of_other_machines_are_read() {
        // Big endian, microseconds, no rate, a block of another kind in between.
        let file = "
            0A 0D 0D 0A 00 00 00 1C 1A 2B 3C 4D 00 01 00 00 FF FF FF FF FF FF FF FF 00 00 00 1C
            00 00 00 01 00 00 00 14 00 93 00 00 00 00 00 00 00 00 00 14
            00 00 00 04 00 00 00 0C 00 00 00 0C
            00 00 00 06 00 00 00 24 00 00 00 00 00 00 00 00 00 0F 42 40 00 00 00 01 00 00 00 01 E5 00 00 00 00 00 00 24";
        let trace = read(&hex(file), Baud::B19200).unwrap();
        let entry = Entry { start: BitTime(19_200), octets: [0xE5].into(), errors: vec![] };
        assert_eq!(trace, Trace { baud: Baud::B19200, entries: [entry].into() });
    }

    #[test]
    fn every_shorter_file_and_every_altered_octet_is_read_or_refused_without_harm() {
        let file = write(&trace(Baud::B1500000), PROFIBUS_DL);
        for length in 0..file.len() {
            let _ = read(&file[..length], Baud::B9600);
        }
        for place in 0..file.len() {
            for octet in 0..=0xFF {
                let mut altered = file.clone();
                altered[place] = octet;
                let _ = read(&altered, Baud::B9600);
            }
        }
    }

    #[test]
    fn a_file_that_was_cut_off_is_read_up_to_there() {
        let trace = trace(Baud::B1500000);
        let file = write(&trace, USER0);
        let (whole, damage) = read_until_damage(&file, Baud::B9600);
        assert_eq!((whole, damage), (trace.clone(), None));
        let (cut, damage) = read_until_damage(&file[..file.len() - 1], Baud::B9600);
        assert_eq!(cut.entries.len(), trace.entries.len() - 1);
        assert_eq!(damage, Some(BadCapture::Block { offset: file.len() - 36 }));
    }

    #[test]
    fn refusals_say_why() {
        let file = write(&trace(Baud::B1500000), 1);
        assert_eq!(read(&file, Baud::B9600), Err(BadCapture::LinkType(1)));
        assert_eq!(read(b"GIF89a", Baud::B9600), Err(BadCapture::NotPcapng));
        assert_eq!(read(&file[..40], Baud::B9600), Err(BadCapture::Block { offset: 28 }));
        let mut orphan = file[..28].to_vec();
        orphan.extend(&write(&trace(Baud::B1500000), PROFIBUS_DL)[72..]);
        assert_eq!(read(&orphan, Baud::B9600), Err(BadCapture::Interface { offset: 28 }));
    }
}
