//! Reads a capture file incrementally, block by block. The buffer holds at most one block, at any file size.

use super::{
    BYTE_ORDER, CharacterErrors, Direction, ENHANCED_PACKET, EPB_FLAGS, Entry, IF_DESCRIPTION, IF_SPEED, IF_TSOFFSET,
    IF_TSRESOL, INTERFACE, OPT_COMMENT, PROFIBUS_DL, SECTION_HEADER, SIMPLE_PACKET, Times, USER0,
};
use profivac_dp::link::{Baud, BitTime};
use std::fmt;

/// The largest block that is read: 16 MiB. chosen: the limit of libpcap; a telegram has at most 255 octets.
const LARGEST: u32 = 1 << 24;

/// The most interfaces of a section. chosen: a capture has one for each captured line.
const MOST_INTERFACES: usize = 1 << 12;

/// The types of blocks that are read.
const KNOWN: [u32; 4] = [SECTION_HEADER, INTERFACE, SIMPLE_PACKET, ENHANCED_PACKET];

/// Octets of a block beside its body: type and length before, length after.
const FRAMING: usize = 12;

/// Error of a capture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CaptureError {
    /// The file does not begin with the section header of pcapng.
    NotPcapng,
    /// The file ends within a block: its writer was stopped, or is still writing.
    Cut {
        /// The position of the block in the file, in octets.
        offset: u64,
    },
    /// A block is shorter than its type needs, or larger than the limit.
    Block {
        /// The position of the block in the file, in octets.
        offset: u64,
    },
    /// A packet has no interface, or there are more interfaces than the limit.
    Interface {
        /// The position of the block in the file, in octets.
        offset: u64,
    },
    /// No interface before the first packet has the link type of PROFIBUS; this is the one of the packet, or of the first interface.
    LinkType(u16),
}

impl fmt::Display for CaptureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPcapng => f.write_str("expected a pcapng file, found no section header"),
            Self::Cut { offset } => {
                write!(f, "the file ends within the block at octet {offset}: it was cut off, or is still being written")
            }
            Self::Block { offset } => write!(f, "the block at octet {offset} has no possible length"),
            Self::Interface { offset } => write!(f, "the block at octet {offset} belongs to no interface"),
            Self::LinkType(other) => {
                write!(f, "expected link type {PROFIBUS_DL} or {USER0}, found {other}")
            }
        }
    }
}

impl std::error::Error for CaptureError {}

/// A packet of a capture file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Its time, octets and character errors.
    pub entry: Entry,
    /// Where its time comes from.
    pub times: Times,
}

/// Packets of interfaces of other link types, which are not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Skipped {
    /// The link type of the first one.
    pub link_type: u16,
    /// Their number.
    pub packets: u64,
}

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { link_type, packets } = self;
        let plural = if *packets == 1 { "" } else { "s" };
        write!(
            f,
            "{packets} packet{plural} skipped: expected link type {PROFIBUS_DL} or {USER0}, the first one has {link_type}"
        )
    }
}

/// Rate of the lines of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LineRate {
    /// No interface of PROFIBUS has one.
    Unknown,
    /// All that have one have this one.
    One(Baud),
    /// The interfaces have different ones.
    Several,
}

/// Reads packets from a file in portions of any size.
pub struct Reader {
    /// The octets pushed last; those before `at` are read.
    ahead: Vec<u8>,
    at: usize,
    /// The position of `at` in the file.
    offset: u64,
    /// The position of the last skipped block, and the octets of it that are still to skip.
    passed: u64,
    passing: u64,
    big_endian: bool,
    interfaces: Vec<Interface>,
    default_baud: Baud,
    line_rate: LineRate,
    direction: Option<Direction>,
    skipped: Option<Skipped>,
    /// An interface so far has the link type of PROFIBUS.
    has_profibus: bool,
    stage: Stage,
    /// The size of the block that is not complete yet.
    reserve_octets: usize,
}

/// The progress in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Before the section header.
    New,
    /// Before the first packet: an interface may still set the rate.
    Begun,
    /// After the first packet.
    Packets,
    /// After an error: no further packets are read.
    Damaged,
}

/// A whole block: position, type, range of the body in the buffer.
type Block = (u64, u32, std::ops::Range<usize>);

impl Reader {
    /// A reader; `default_baud` applies to a file without a rate.
    #[must_use]
    pub const fn new(default_baud: Baud) -> Self {
        Self {
            ahead: Vec::new(),
            at: 0,
            offset: 0,
            passed: 0,
            passing: 0,
            big_endian: false,
            interfaces: Vec::new(),
            default_baud,
            line_rate: LineRate::Unknown,
            direction: None,
            skipped: None,
            has_profibus: false,
            stage: Stage::New,
            reserve_octets: 0,
        }
    }

    /// The rate whose bit times the times of all packets are: that of the line, or the default one.
    #[must_use]
    pub const fn baud(&self) -> Baud {
        match self.line_rate {
            LineRate::One(baud) => baud,
            LineRate::Unknown | LineRate::Several => self.default_baud,
        }
    }

    /// The rate of the line, from the interfaces before the first packet. `None` if they have none of PROFIBUS, or different ones.
    #[must_use]
    pub const fn line_baud(&self) -> Option<Baud> {
        match self.line_rate {
            LineRate::One(baud) => Some(baud),
            LineRate::Unknown | LineRate::Several => None,
        }
    }

    /// The packets of other link types so far.
    #[must_use]
    pub const fn skipped(&self) -> Option<Skipped> {
        self.skipped
    }

    /// The sender of the packet that [`next`](Self::next) returned last. `None` if the file does not say it.
    #[must_use]
    pub const fn direction(&self) -> Option<Direction> {
        self.direction
    }

    /// Adds the next octets of the file.
    pub fn push(&mut self, octets: &[u8]) {
        self.ahead.drain(..self.at);
        self.at = 0;
        let missing = std::mem::take(&mut self.reserve_octets).saturating_sub(self.ahead.len());
        self.ahead.reserve_exact(missing.max(octets.len()));
        self.ahead.extend(octets);
    }

    /// The number of octets in the buffer.
    #[cfg(test)]
    pub(super) fn buffered(&self) -> usize {
        self.ahead.len()
    }

    /// The next packet. `None` if more of the file is needed, or after an error.
    ///
    /// # Errors
    /// [`CaptureError`], once.
    #[expect(clippy::should_implement_trait, reason = "more packets may follow `None`")]
    pub fn next(&mut self) -> Option<Result<Packet, CaptureError>> {
        while self.stage != Stage::Damaged {
            let (offset, kind, body) = match self.block()? {
                Ok(block) => block,
                Err(damage) => return Some(Err(self.damaged(damage))),
            };
            match self.entry(offset, kind, body) {
                Ok(None) => {}
                Ok(Some(packet)) => return Some(Ok(packet)),
                Err(damage) => return Some(Err(self.damaged(damage))),
            }
        }
        None
    }

    /// Ends the file.
    ///
    /// # Errors
    /// [`CaptureError`] if the file is empty or ends within a block, or all its interfaces have other link types, unless an error was
    /// returned before.
    pub fn end(&mut self) -> Result<(), CaptureError> {
        let foreign = self.interfaces.first().filter(|_| !self.has_profibus).map(|interface| interface.link_type);
        match (self.stage, foreign) {
            (Stage::Damaged, _) => Ok(()),
            (Stage::New, _) => Err(self.damaged(CaptureError::NotPcapng)),
            _ if self.passing > 0 => Err(self.damaged(CaptureError::Cut { offset: self.passed })),
            _ if self.at != self.ahead.len() => Err(self.damaged(CaptureError::Cut { offset: self.offset })),
            (Stage::Begun | Stage::Packets, Some(link_type)) => Err(self.damaged(CaptureError::LinkType(link_type))),
            (Stage::Begun | Stage::Packets, None) => Ok(()),
        }
    }

    fn damaged(&mut self, damage: CaptureError) -> CaptureError {
        let is_new = self.stage == Stage::New;
        self.stage = Stage::Damaged;
        if is_new { CaptureError::NotPcapng } else { damage }
    }

    /// The next whole block of a known type.
    fn block(&mut self) -> Option<Result<Block, CaptureError>> {
        loop {
            self.pass();
            let rest = self.ahead.get(self.at..).filter(|rest| rest.len() >= FRAMING)?;
            if rest.starts_with(&SECTION_HEADER.to_le_bytes()) {
                self.big_endian = rest.get(8..12)? == BYTE_ORDER.to_be_bytes();
            }
            let mut head = Fields { octets: rest, big_endian: self.big_endian };
            let (offset, kind, length) = (self.offset, head.long()?, head.long()?);
            let (size, is_known) = (length as usize, KNOWN.contains(&kind));
            let is_first = self.stage == Stage::New && kind != SECTION_HEADER;
            if is_first || size < FRAMING || !size.is_multiple_of(4) || (is_known && length > LARGEST) {
                return Some(Err(CaptureError::Block { offset }));
            }
            if !is_known {
                (self.passed, self.passing) = (offset, u64::from(length));
                continue;
            }
            if rest.len() < size {
                // A large block needs its size, and not twice as much.
                self.reserve_octets = size;
                return None;
            }
            let body = self.at + 8..self.at + size - 4;
            self.at += size;
            self.offset += u64::from(length);
            return Some(Ok((offset, kind, body)));
        }
    }

    /// Skips the rest of a block of an unknown type.
    fn pass(&mut self) {
        let there = self.ahead.len() - self.at;
        let passed = usize::try_from(self.passing).unwrap_or(usize::MAX).min(there);
        self.at += passed;
        self.passing -= passed as u64;
        self.offset += passed as u64;
    }

    /// The packet of a block, or `None` for a block of another type.
    fn entry(&mut self, offset: u64, kind: u32, body: std::ops::Range<usize>) -> Result<Option<Packet>, CaptureError> {
        let octets = self.ahead.get(body.clone()).unwrap_or_default();
        let fields = Fields { octets, big_endian: self.big_endian };
        match kind {
            SECTION_HEADER => {
                self.interfaces.clear();
                self.stage = if self.stage == Stage::New { Stage::Begun } else { self.stage };
            }
            INTERFACE => {
                if self.interfaces.len() >= MOST_INTERFACES {
                    return Err(CaptureError::Interface { offset });
                }
                let interface = Interface::read(fields).ok_or(CaptureError::Block { offset })?;
                if self.stage == Stage::Begun && interface.is_profibus() {
                    self.line_rate = self.line_rate.with(interface.baud);
                }
                self.has_profibus |= interface.is_profibus();
                self.interfaces.push(interface);
            }
            _ => return self.packet(offset, kind, body),
        }
        Ok(None)
    }

    /// The packet of a block, or `None` if its interface is none of PROFIBUS.
    fn packet(&mut self, offset: u64, kind: u32, body: std::ops::Range<usize>) -> Result<Option<Packet>, CaptureError> {
        let octets = self.ahead.get(body).unwrap_or_default();
        let mut fields = Fields { octets, big_endian: self.big_endian };
        // A simple packet belongs to the first interface.
        let number = if kind == SIMPLE_PACKET { Some(0) } else { fields.long() };
        let number = number.ok_or(CaptureError::Block { offset })?;
        let interface = self.interfaces.get(number as usize).ok_or(CaptureError::Interface { offset })?;
        // A live capture of another line would be read for ever without a word.
        if !self.has_profibus {
            return Err(CaptureError::LinkType(interface.link_type));
        }
        if !interface.is_profibus() {
            let skipped = self.skipped.get_or_insert(Skipped { link_type: interface.link_type, packets: 0 });
            skipped.packets = skipped.packets.saturating_add(1);
            return Ok(None);
        }
        let read = match kind {
            SIMPLE_PACKET => interface.simple_packet(fields),
            _ => interface.packet(fields, self.baud()),
        };
        let (packet, direction) = read.ok_or(CaptureError::Block { offset })?;
        (self.direction, self.stage) = (direction, Stage::Packets);
        Ok(Some(packet))
    }
}

impl LineRate {
    /// The rate with that of another interface.
    fn with(self, rate: Option<Baud>) -> Self {
        match (self, rate) {
            (known, None) => known,
            (Self::Unknown, Some(rate)) => Self::One(rate),
            (Self::One(known), Some(rate)) if known == rate => self,
            (Self::One(_) | Self::Several, Some(_)) => Self::Several,
        }
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

/// The parameters of an interface for reading its packets.
struct Interface {
    link_type: u16,
    /// The most octets of a packet that were captured; 0 without a limit.
    captured_octets: u32,
    baud: Option<Baud>,
    times: Times,
    ticks_per_second: u128,
    /// Seconds that are added to each time.
    offset_seconds: i64,
}

impl Interface {
    fn read(mut body: Fields<'_>) -> Option<Self> {
        let link_type = body.short()?;
        body.take(2)?;
        let captured_octets = body.long()?;
        let mut interface = Self {
            link_type,
            captured_octets,
            baud: None,
            times: Times::Measured,
            ticks_per_second: 1_000_000,
            offset_seconds: 0,
        };
        if !interface.is_profibus() {
            return Some(interface);
        }
        while let Some((code, mut value)) = body.option() {
            match code {
                IF_SPEED => interface.baud = rate(value.number(8)?),
                IF_DESCRIPTION if value.octets == Times::Invented.description().as_bytes() => {
                    interface.times = Times::Invented;
                }
                IF_TSOFFSET => interface.offset_seconds = value.number(8)?.cast_signed(),
                IF_TSRESOL => interface.ticks_per_second = ticks(value.number(1)?)?,
                _ => {}
            }
        }
        Some(interface)
    }

    const fn is_profibus(&self) -> bool {
        matches!(self.link_type, PROFIBUS_DL | USER0)
    }

    /// A simple packet, which has neither a time nor a direction.
    fn simple_packet(&self, mut body: Fields<'_>) -> Option<(Packet, Option<Direction>)> {
        let length = body.long()?;
        let captured = if self.captured_octets == 0 { length } else { length.min(self.captured_octets) };
        let octets = body.take(captured as usize)?;
        Some((Packet { entry: Entry::new(BitTime(0), octets, Vec::new()), times: Times::Invented }, None))
    }

    /// The packet behind the number of its interface, and its sender.
    fn packet(&self, mut body: Fields<'_>, baud: Baud) -> Option<(Packet, Option<Direction>)> {
        let (high, low) = (u64::from(body.long()?), u64::from(body.long()?));
        let (length, _) = (body.long()? as usize, body.long()?);
        let octets = body.take(length.checked_next_multiple_of(4)?)?.get(..length)?;
        let ticks = u128::from(high << 32 | low) * u128::from(baud.bits_per_second());
        let bits = (ticks + self.ticks_per_second / 2) / self.ticks_per_second;
        let offset = i128::from(self.offset_seconds) * i128::from(baud.bits_per_second());
        // A time before 1970 is 1970: a bit time has no sign.
        let bits = i128::try_from(bits).unwrap_or(i128::MAX).saturating_add(offset);
        let start = BitTime(u64::try_from(bits.max(0)).unwrap_or(u64::MAX));
        let (mut errors, mut direction) = (Vec::new(), None);
        while let Some((code, mut value)) = body.option() {
            match code {
                OPT_COMMENT => errors = character_errors(value.octets).unwrap_or_default(),
                EPB_FLAGS => direction = value.long().and_then(Direction::of_flags),
                _ => {}
            }
        }
        Some((Packet { entry: Entry::new(start, octets, errors), times: self.times }, direction))
    }
}

fn rate(speed: u64) -> Option<Baud> {
    u32::try_from(speed).ok().and_then(Baud::from_bits_per_second)
}

/// Ticks per second from if_tsresol: a power of ten, or of two if bit 7 is set.
fn ticks(resolution: u64) -> Option<u128> {
    let base: u128 = if resolution & 0x80 != 0 { 2 } else { 10 };
    // More than 2^64 ticks per second could overflow the product with the rate.
    base.checked_pow((resolution & 0x7F) as u32).filter(|ticks| *ticks <= 1 << 64)
}

/// The positions in a comment that [`packet`](super::packet) wrote; `None` for any other comment.
fn character_errors(comment: &[u8]) -> Option<Vec<usize>> {
    let numbers = std::str::from_utf8(comment).ok()?.strip_prefix(CharacterErrors::WORDS)?;
    numbers.split(", ").map(|number| number.parse::<usize>().ok()?.checked_sub(1)).collect()
}
