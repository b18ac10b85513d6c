//! Capture files in the pcapng format, as Wireshark reads them.
//!
//! A file has a section header, an interface with link type and rate for each source of times ([`Times`]), and one packet for each entry of
//! the trace: the octets from start to end delimiter. Times are in nanoseconds since the start of the trace; a bit at 12 Mbit/s has 83 ns,
//! so bit times are restored exactly. A comment and the symbol error flag mark octets with character errors, because a packet has no field
//! for them.

mod reader;

pub use reader::{CaptureError, Packet, Reader, Skipped};

use super::{CharacterErrors, Entry, Trace};
use profivac_dp::link::Baud;

/// LINKTYPE_PROFIBUS_DL: data link layer telegrams of IEC 61158-4-3.
pub const PROFIBUS_DL: u16 = 257;
/// LINKTYPE_USER0: a type for private use, to which a dissector can be assigned.
pub const USER0: u16 = 147;

const SECTION_HEADER: u32 = 0x0A0D_0D0A;
const BYTE_ORDER: u32 = 0x1A2B_3C4D;
const INTERFACE: u32 = 1;
const SIMPLE_PACKET: u32 = 3;
const ENHANCED_PACKET: u32 = 6;

const OPT_COMMENT: u16 = 1;
const IF_DESCRIPTION: u16 = 3;
const EPB_FLAGS: u16 = 2;
const IF_SPEED: u16 = 8;
const IF_TSRESOL: u16 = 9;
const IF_TSOFFSET: u16 = 14;

/// Bit of epb_flags: symbol error, used for character errors.
const SYMBOL_ERROR: u32 = 1 << 31;

/// Bits of epb_flags: the direction.
const DIRECTION: u32 = 0b11;
const INBOUND: u32 = 0b01;
const OUTBOUND: u32 = 0b10;

/// The sender of a packet, where a file says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Another station sent it: inbound.
    Received,
    /// The computer that wrote the file sent it: outbound.
    Sent,
}

impl Direction {
    const fn flags(self) -> u32 {
        match self {
            Self::Received => INBOUND,
            Self::Sent => OUTBOUND,
        }
    }

    const fn of_flags(flags: u32) -> Option<Self> {
        match flags & DIRECTION {
            INBOUND => Some(Self::Received),
            OUTBOUND => Some(Self::Sent),
            _ => None,
        }
    }
}

const NANOSECONDS: u128 = 1_000_000_000;

/// Where the times of packets come from. Each has an interface of the capture file, in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Times {
    /// The line, or the system that received the octets.
    #[default]
    Measured,
    /// The writer of the file: the source had no times, and a packet needs one.
    Invented,
}

impl Times {
    const ALL: [Self; 2] = [Self::Measured, Self::Invented];

    /// The description of the interface. A reader recognises invented times by it.
    const fn description(self) -> &'static str {
        match self {
            Self::Measured => "PROFIBUS, with the times of the source",
            Self::Invented => "PROFIBUS, invented times: the source has none",
        }
    }
}

/// Writes a trace as a capture file with `link_type`, [`PROFIBUS_DL`] or [`USER0`].
#[must_use]
pub fn write(trace: &Trace, link_type: u16) -> Vec<u8> {
    let mut file = file_header(Some(trace.baud), link_type);
    trace.entries.iter().for_each(|entry| file.extend(packet(entry, Times::Measured, trace.baud)));
    file
}

/// The blocks before the first packet, for a file that is written packet by packet. `baud` is the rate of the line, if it is known.
#[must_use]
pub fn file_header(baud: Option<Baud>, link_type: u16) -> Vec<u8> {
    let mut file = Vec::new();
    // Version 1.0, section length not specified.
    block(&mut file, SECTION_HEADER, &[&BYTE_ORDER.to_le_bytes(), &[1, 0, 0, 0], &[0xFF; 8]]);
    for times in Times::ALL {
        let mut options = option(IF_DESCRIPTION, times.description().as_bytes());
        options.extend(option(IF_TSRESOL, &[9]));
        if let Some(baud) = baud {
            options.extend(option(IF_SPEED, &u64::from(baud.bits_per_second()).to_le_bytes()));
        }
        options.extend(option(0, &[]));
        // No limit of the packet length.
        block(&mut file, INTERFACE, &[&link_type.to_le_bytes(), &[0; 6], &options]);
    }
    file
}

/// The block of one packet. Its start is in bit times of `baud`.
#[must_use]
pub fn packet(entry: &Entry, times: Times, baud: Baud) -> Vec<u8> {
    packet_with_flags(entry, times, 0, baud)
}

/// The block of one packet with measured times that says who sent it.
#[must_use]
pub fn directed_packet(entry: &Entry, direction: Direction, baud: Baud) -> Vec<u8> {
    packet_with_flags(entry, Times::Measured, direction.flags(), baud)
}

fn packet_with_flags(entry: &Entry, times: Times, direction: u32, baud: Baud) -> Vec<u8> {
    let interface = (times as u32).to_le_bytes();
    let (mut file, rate) = (Vec::new(), u128::from(baud.bits_per_second()));
    let time = ((u128::from(entry.start.0) * NANOSECONDS + rate / 2) / rate) as u64;
    let length = (entry.octets.len() as u32).to_le_bytes();
    let (high, low) = ((time >> 32) as u32, time as u32);
    let mut options = Vec::new();
    if !entry.errors.is_empty() {
        options.extend(option(OPT_COMMENT, CharacterErrors(&entry.errors).to_string().as_bytes()));
    }
    let flags = direction | if entry.errors.is_empty() { 0 } else { SYMBOL_ERROR };
    if flags != 0 {
        options.extend(option(EPB_FLAGS, &flags.to_le_bytes()));
        options.extend(option(0, &[]));
    }
    let octets = padded(&entry.octets);
    let (high, low) = (high.to_le_bytes(), low.to_le_bytes());
    block(&mut file, ENHANCED_PACKET, &[&interface, &high, &low, &length, &length, &octets, &options]);
    file
}

fn block(file: &mut Vec<u8>, kind: u32, parts: &[&[u8]]) {
    let length = parts.iter().map(|part| part.len() as u32).sum::<u32>() + 12;
    file.extend(kind.to_le_bytes());
    file.extend(length.to_le_bytes());
    parts.iter().for_each(|part| file.extend(*part));
    file.extend(length.to_le_bytes());
}

/// An option with a value of at most 65535 octets, the longest that an option has; further ones are dropped.
fn option(code: u16, value: &[u8]) -> Vec<u8> {
    let length = u16::try_from(value.len()).unwrap_or(u16::MAX);
    let value = value.get(..usize::from(length)).unwrap_or(value);
    [&code.to_le_bytes()[..], &length.to_le_bytes(), &padded(value)].concat()
}

/// Pads to a multiple of four octets.
fn padded(octets: &[u8]) -> Vec<u8> {
    let mut padded = octets.to_vec();
    padded.resize(octets.len().next_multiple_of(4), 0);
    padded
}

/// Reads a capture file. Blocks of other types are skipped. `default_baud` applies to a file without a rate.
///
/// # Errors
/// [`CaptureError`] if the octets are not a complete capture file of PROFIBUS.
pub fn read(file: &[u8], default_baud: Baud) -> Result<Trace, CaptureError> {
    let mut reader = Reader::new(default_baud);
    reader.push(file);
    let mut entries = std::collections::VecDeque::new();
    while let Some(packet) = reader.next() {
        entries.push_back(packet?.entry);
    }
    reader.end()?;
    Ok(Trace { baud: reader.baud(), entries })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialogue::hex;
    use profivac_dp::link::BitTime;

    /// Octets before the first packet.
    const HEADER: usize = 28 + 88 + 96;

    fn trace(baud: Baud) -> Trace {
        let entry = |start, text, errors| Entry::new(BitTime(start), hex(text), errors);
        let entries = [
            entry(33, "10 08 02 49 53 16", vec![]),
            entry(7_777_777_777, "10 02 08 00 0A 16", vec![1, 4]),
            entry(123_456_789_012_345, "E5", vec![]),
        ];
        Trace { baud, entries: entries.into() }
    }

    #[test]
    fn a_written_file_is_read_back_at_every_rate_and_with_both_link_types() {
        for baud in Baud::ALL {
            for link_type in [PROFIBUS_DL, USER0] {
                let trace = trace(baud);
                assert_eq!(read(&write(&trace, link_type), Baud::B9600), Ok(trace), "{baud}");
            }
        }
    }

    /// A stamp of 5 s, with an offset of 1,700,000,000 s in the interface.
    #[test]
    fn the_offset_of_an_interface_is_added_to_each_time() {
        for (offset, start) in [(1_700_000_000_i64, 1_700_000_005), (0, 5), (-3, 2), (-10, 0), (i64::MIN, 0)] {
            let mut file = Vec::new();
            block(&mut file, SECTION_HEADER, &[&BYTE_ORDER.to_le_bytes(), &[1, 0, 0, 0], &[0xFF; 8]]);
            let options =
                [option(IF_TSOFFSET, &offset.to_le_bytes()), option(IF_TSRESOL, &[0]), option(0, &[])].concat();
            block(&mut file, INTERFACE, &[&USER0.to_le_bytes(), &[0; 6], &options]);
            let fields = [0_u32, 0, 5, 1, 1].map(u32::to_le_bytes).concat();
            block(&mut file, ENHANCED_PACKET, &[&fields, &[0xE5, 0, 0, 0]]);
            let trace = read(&file, Baud::B9600).unwrap();
            let starts: Vec<u64> = trace.entries.iter().map(|entry| entry.start.0).collect();
            assert_eq!(starts, [start * 9600], "offset {offset}");
        }
    }

    /// A section, and interfaces of these link types with these options.
    fn file_of(interfaces: &[(u16, Vec<u8>)]) -> Vec<u8> {
        let mut file = Vec::new();
        block(&mut file, SECTION_HEADER, &[&BYTE_ORDER.to_le_bytes(), &[1, 0, 0, 0], &[0xFF; 8]]);
        for (link_type, options) in interfaces {
            block(&mut file, INTERFACE, &[&link_type.to_le_bytes(), &[0; 6], options, &option(0, &[])]);
        }
        file
    }

    /// A packet of the interface with this number: one octet at this number of ticks.
    fn short_packet(file: &mut Vec<u8>, interface: u32, ticks: u32) {
        let fields = [interface, 0, ticks, 1, 1].map(u32::to_le_bytes).concat();
        block(file, ENHANCED_PACKET, &[&fields, &[0xE5, 0, 0, 0]]);
    }

    #[test]
    fn each_interface_has_its_own_link_type_resolution_and_offset() {
        let milliseconds = option(IF_TSRESOL, &[3]);
        let halves = [option(IF_TSRESOL, &[0x81]), option(IF_TSOFFSET, &100_i64.to_le_bytes())].concat();
        let mut file = file_of(&[(1, vec![]), (USER0, milliseconds), (PROFIBUS_DL, halves), (USER0, vec![])]);
        for (interface, ticks) in [(0, 9), (1, 2000), (2, 5), (3, 3_000_000), (0, 9)] {
            short_packet(&mut file, interface, ticks);
        }
        let mut reader = Reader::new(Baud::B9600);
        reader.push(&file);
        let packets: Vec<Packet> = std::iter::from_fn(|| reader.next()).map(Result::unwrap).collect();
        let times: Vec<f64> = packets.iter().map(|packet| packet.entry.start.0 as f64 / 9600.0).collect();
        assert_eq!(times, [2.0, 102.5, 3.0]);
        assert_eq!((reader.end(), reader.skipped()), (Ok(()), Some(Skipped { link_type: 1, packets: 2 })));
    }

    /// Two lines in a file have no common rate: their times are in bit times of the default one.
    #[test]
    fn interfaces_of_several_rates_have_no_line_rate() {
        let rate = |baud: Baud| option(IF_SPEED, &u64::from(baud.bits_per_second()).to_le_bytes());
        let (slow, fast) = (rate(Baud::B19200), rate(Baud::B1500000));
        for (interfaces, expected) in [
            (vec![(USER0, slow.clone()), (USER0, slow.clone())], Some(Baud::B19200)),
            (vec![(USER0, slow.clone()), (PROFIBUS_DL, vec![])], Some(Baud::B19200)),
            (vec![(USER0, slow.clone()), (1, fast.clone())], Some(Baud::B19200)),
            (vec![(USER0, slow), (USER0, fast)], None),
        ] {
            let mut file = file_of(&interfaces);
            short_packet(&mut file, 0, 1_000_000);
            let mut reader = Reader::new(Baud::B9600);
            reader.push(&file);
            let packet = reader.next().unwrap().unwrap();
            assert_eq!(reader.line_baud(), expected);
            assert_eq!(packet.entry.start.0, u64::from(reader.baud().bits_per_second()));
        }
    }

    /// A simple packet has neither a time nor an interface.
    #[test]
    fn a_simple_packet_has_octets_and_no_time() {
        let mut file = file_of(&[(USER0, vec![])]);
        block(&mut file, SIMPLE_PACKET, &[&3_u32.to_le_bytes(), &[0xDC, 2, 2, 0]]);
        let mut reader = Reader::new(Baud::B9600);
        reader.push(&file);
        let packet = reader.next().unwrap().unwrap();
        assert_eq!((&packet.entry.octets[..], packet.times), (&[0xDC, 2, 2][..], Times::Invented));
        assert_eq!(reader.end(), Ok(()));
        let mut short = file_of(&[(USER0, vec![])]);
        let offset = short.len() as u64;
        block(&mut short, SIMPLE_PACKET, &[&5_u32.to_le_bytes(), &[0xDC, 2, 2, 0]]);
        assert_eq!(read(&short, Baud::B9600), Err(CaptureError::Block { offset }));
    }

    /// The length of an option has two octets. A longer comment would make the file unreadable from there on.
    #[test]
    fn an_option_has_at_most_65535_octets() {
        for (octets, length) in [(3, 3), (65_535, 65_535), (65_536, 65_535), (70_000, 65_535)] {
            let option = option(1, &vec![b'a'; octets]);
            assert_eq!(option[2..4], u16::to_le_bytes(length));
            assert_eq!(option.len(), 4 + usize::from(length).next_multiple_of(4));
        }
    }

    #[test]
    fn the_octets_of_a_file_match_the_format() {
        let mut trace = trace(Baud::B12000000);
        trace.entries.truncate(1);
        let expected = "
            0A 0D 0D 0A 1C 00 00 00 4D 3C 2B 1A 01 00 00 00 FF FF FF FF FF FF FF FF 1C 00 00 00
            01 00 00 00 58 00 00 00 01 01 00 00 00 00 00 00 03 00 26 00
            50 52 4F 46 49 42 55 53 2C 20 77 69 74 68 20 74 68 65 20 74 69 6D 65 73
            20 6F 66 20 74 68 65 20 73 6F 75 72 63 65 00 00
            09 00 01 00 09 00 00 00
            08 00 08 00 00 1B B7 00 00 00 00 00 00 00 00 00 58 00 00 00
            01 00 00 00 60 00 00 00 01 01 00 00 00 00 00 00 03 00 2D 00
            50 52 4F 46 49 42 55 53 2C 20 69 6E 76 65 6E 74 65 64 20 74 69 6D 65 73
            3A 20 74 68 65 20 73 6F 75 72 63 65 20 68 61 73 20 6E 6F 6E 65 00 00 00
            09 00 01 00 09 00 00 00
            08 00 08 00 00 1B B7 00 00 00 00 00 00 00 00 00 60 00 00 00
            06 00 00 00 28 00 00 00 00 00 00 00 00 00 00 00 BE 0A 00 00 06 00 00 00 06 00 00 00
            10 08 02 49 53 16 00 00 28 00 00 00";
        assert_eq!(write(&trace, PROFIBUS_DL), hex(expected));
    }

    #[test]
    fn a_file_says_which_times_are_invented() {
        let entries = trace(Baud::B500000).entries;
        for link_type in [PROFIBUS_DL, USER0] {
            let (mut file, all) =
                (file_header(Some(Baud::B500000), link_type), [Times::Measured, Times::Invented, Times::Measured]);
            for (entry, times) in entries.iter().zip(all) {
                file.extend(packet(entry, times, Baud::B500000));
            }
            let mut reader = Reader::new(Baud::B9600);
            reader.push(&file);
            for (entry, times) in entries.iter().zip(all) {
                assert_eq!(reader.next(), Some(Ok(Packet { entry: entry.clone(), times })));
            }
        }
    }

    #[test]
    fn the_direction_of_a_packet_is_read_back() {
        let trace = trace(Baud::B19200);
        let directions = [Some(Direction::Sent), Some(Direction::Received), None];
        let mut file = file_header(Some(trace.baud), PROFIBUS_DL);
        for (entry, direction) in trace.entries.iter().zip(directions) {
            file.extend(match direction {
                Some(direction) => directed_packet(entry, direction, trace.baud),
                None => packet(entry, Times::Measured, trace.baud),
            });
        }
        let mut reader = Reader::new(Baud::B9600);
        reader.push(&file);
        for (entry, direction) in trace.entries.iter().zip(directions) {
            assert_eq!(reader.next().unwrap().unwrap().entry, *entry);
            assert_eq!(reader.direction(), direction);
        }
    }

    #[test]
    fn files_of_other_machines_are_read() {
        // Big endian, microseconds, no rate, a block of another type in between.
        let file = "
            0A 0D 0D 0A 00 00 00 1C 1A 2B 3C 4D 00 01 00 00 FF FF FF FF FF FF FF FF 00 00 00 1C
            00 00 00 01 00 00 00 14 00 93 00 00 00 00 00 00 00 00 00 14
            00 00 00 04 00 00 00 0C 00 00 00 0C
            00 00 00 06 00 00 00 24 00 00 00 00 00 00 00 00 00 0F 42 40 00 00 00 01 00 00 00 01 E5 00 00 00 00 00 00 24";
        let trace = read(&hex(file), Baud::B19200).unwrap();
        let entry = Entry::new(BitTime(19_200), [0xE5], vec![]);
        assert_eq!(trace, Trace { baud: Baud::B19200, entries: [entry].into() });
    }

    #[test]
    fn every_shorter_file_and_every_altered_octet_is_read_without_panic() {
        let file = write(&trace(Baud::B1500000), PROFIBUS_DL);
        for length in 0..file.len() {
            let _ = read(&file[..length], Baud::B9600);
        }
        for index in 0..file.len() {
            for octet in 0..=0xFF {
                let mut altered = file.clone();
                altered[index] = octet;
                let _ = read(&altered, Baud::B9600);
            }
        }
    }

    /// The entries and the final error of a reader that gets the file in portions of `length` octets.
    fn in_portions(file: &[u8], length: usize) -> (Vec<Entry>, Option<CaptureError>) {
        let (mut reader, mut entries) = (Reader::new(Baud::B9600), Vec::new());
        for portion in file.chunks(length) {
            reader.push(portion);
            while let Some(packet) = reader.next() {
                match packet {
                    Ok(packet) => entries.push(packet.entry),
                    Err(damage) => return (entries, Some(damage)),
                }
            }
        }
        (entries, reader.end().err())
    }

    #[test]
    fn the_size_of_the_portions_does_not_change_the_entries() {
        let trace = trace(Baud::B1500000);
        let mut file = write(&trace, USER0);
        // A block of another type between the packets.
        let foreign = [&[4, 0, 0, 0, 24, 0, 0, 0][..], &[7; 12], &[24, 0, 0, 0]].concat();
        file.splice(HEADER..HEADER, foreign);
        for length in 1..file.len() {
            assert_eq!(in_portions(&file, length), (trace.entries.clone().into(), None), "{length}");
        }
    }

    #[test]
    fn a_truncated_file_is_read_up_to_its_last_whole_packet() {
        let trace = trace(Baud::B1500000);
        let file = write(&trace, USER0);
        for cut in 1..36 {
            let (entries, damage) = in_portions(&file[..file.len() - cut], 7);
            assert_eq!(entries.len(), trace.entries.len() - 1);
            assert_eq!(damage, Some(CaptureError::Cut { offset: file.len() as u64 - 36 }), "{cut}");
        }
        assert_eq!(in_portions(&file[..file.len() - 36], 7), (trace.entries.range(..2).cloned().collect(), None));
    }

    #[test]
    fn a_block_that_declares_a_large_size_is_an_error_at_once() {
        let mut file = write(&trace(Baud::B1500000), USER0);
        let offset = file.len() as u64;
        file.extend([6, 0, 0, 0, 4, 0, 0, 1, 0, 0, 0, 0]);
        assert_eq!(in_portions(&file, 50).1, Some(CaptureError::Block { offset }));
    }

    #[test]
    fn a_large_block_of_another_type_is_skipped_without_buffering() {
        let mut reader = Reader::new(Baud::B9600);
        reader.push(&write(&trace(Baud::B1500000), USER0)[..HEADER]);
        reader.push(&[4, 0, 0, 0, 0, 0, 0, 0x80, 0, 0, 0, 0]);
        for _ in 0..1000 {
            assert!(reader.next().is_none());
            reader.push(&[0; 1000]);
        }
        assert!(reader.buffered() <= 2000, "{}", reader.buffered());
        assert_eq!(reader.end(), Err(CaptureError::Cut { offset: HEADER as u64 }));
    }

    #[test]
    fn each_error_names_its_cause() {
        let file = write(&trace(Baud::B1500000), 1);
        assert_eq!(read(&file, Baud::B9600), Err(CaptureError::LinkType(1)));
        assert_eq!(read(&file_of(&[(1, vec![])]), Baud::B9600), Err(CaptureError::LinkType(1)), "no packet came");
        assert_eq!(read(b"GIF89a", Baud::B9600), Err(CaptureError::NotPcapng));
        assert_eq!(read(&file[..40], Baud::B9600), Err(CaptureError::Cut { offset: 28 }));
        let mut orphan = file[..28].to_vec();
        orphan.extend(&write(&trace(Baud::B1500000), PROFIBUS_DL)[HEADER..]);
        assert_eq!(read(&orphan, Baud::B9600), Err(CaptureError::Interface { offset: 28 }));
    }
}
