//! Capture files in the pcapng format, as Wireshark reads them.
//!
//! A file has a section header, one interface with link type and rate, and one packet for each entry of the trace: the octets
//! from start to end delimiter. Times are in nanoseconds since the start of the trace; a bit at 12 Mbit/s has 83 ns, so bit
//! times are restored exactly. A comment and the symbol error flag mark octets with character errors, because a packet has
//! no field for them.

mod reader;

pub use reader::{CaptureError, Reader};

use super::{CharacterErrors, Entry, Trace};
use profivac_dp::link::Baud;

/// LINKTYPE_PROFIBUS_DL: data link layer telegrams of IEC 61158-4-3.
pub const PROFIBUS_DL: u16 = 257;
/// LINKTYPE_USER0: a type for private use, to which a dissector can be assigned.
pub const USER0: u16 = 147;

const SECTION_HEADER: u32 = 0x0A0D_0D0A;
const BYTE_ORDER: u32 = 0x1A2B_3C4D;
const INTERFACE: u32 = 1;
const ENHANCED_PACKET: u32 = 6;

const OPT_COMMENT: u16 = 1;
const EPB_FLAGS: u16 = 2;
const IF_SPEED: u16 = 8;
const IF_TSRESOL: u16 = 9;

/// Bit of epb_flags: symbol error, used for character errors.
const SYMBOL_ERROR: u32 = 1 << 31;

const NANOSECONDS: u128 = 1_000_000_000;

/// Writes a trace as a capture file with `link_type`, [`PROFIBUS_DL`] or [`USER0`].
#[must_use]
pub fn write(trace: &Trace, link_type: u16) -> Vec<u8> {
    let mut file = file_header(trace.baud, link_type);
    trace.entries.iter().for_each(|entry| file.extend(packet(entry, trace.baud)));
    file
}

/// The blocks before the first packet, for a file that is written packet by packet.
#[must_use]
pub fn file_header(baud: Baud, link_type: u16) -> Vec<u8> {
    let mut file = Vec::new();
    // Version 1.0, section length not specified.
    block(&mut file, SECTION_HEADER, &[&BYTE_ORDER.to_le_bytes(), &[1, 0, 0, 0], &[0xFF; 8]]);
    let mut options = option(IF_TSRESOL, &[9]);
    options.extend(option(IF_SPEED, &u64::from(baud.bits_per_second()).to_le_bytes()));
    options.extend(option(0, &[]));
    // No limit of the packet length.
    block(&mut file, INTERFACE, &[&link_type.to_le_bytes(), &[0; 6], &options]);
    file
}

/// The block of one packet.
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
    while let Some(entry) = reader.next() {
        entries.push_back(entry?);
    }
    reader.end()?;
    Ok(Trace { baud: reader.baud(), entries })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::hex;
    use profivac_dp::link::BitTime;

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
    fn a_written_file_is_read_back_at_every_rate_and_with_both_link_types() {
        for baud in Baud::ALL {
            for link_type in [PROFIBUS_DL, USER0] {
                let trace = trace(baud);
                assert_eq!(read(&write(&trace, link_type), Baud::B9600), Ok(trace), "{baud}");
            }
        }
    }

    #[test]
    fn the_octets_of_a_file_match_the_format() {
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
        // Big endian, microseconds, no rate, a block of another type in between.
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
    fn every_shorter_file_and_every_altered_octet_is_read_without_panic() {
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

    /// The entries and the final error of a reader that gets the file in portions of `length` octets.
    fn in_portions(file: &[u8], length: usize) -> (Vec<Entry>, Option<CaptureError>) {
        let (mut reader, mut entries) = (Reader::new(Baud::B9600), Vec::new());
        for portion in file.chunks(length) {
            reader.push(portion);
            while let Some(entry) = reader.next() {
                match entry {
                    Ok(entry) => entries.push(entry),
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
        file.splice(72..72, foreign);
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
        reader.push(&write(&trace(Baud::B1500000), USER0)[..72]);
        reader.push(&[4, 0, 0, 0, 0, 0, 0, 0x80, 0, 0, 0, 0]);
        for _ in 0..1000 {
            assert!(reader.next().is_none());
            reader.push(&[0; 1000]);
        }
        assert!(reader.buffered() <= 2000, "{}", reader.buffered());
        assert!(matches!(reader.end(), Err(CaptureError::Cut { offset: 72 })));
    }

    #[test]
    fn each_error_names_its_cause() {
        let file = write(&trace(Baud::B1500000), 1);
        assert_eq!(read(&file, Baud::B9600), Err(CaptureError::LinkType(1)));
        assert_eq!(read(b"GIF89a", Baud::B9600), Err(CaptureError::NotPcapng));
        assert_eq!(read(&file[..40], Baud::B9600), Err(CaptureError::Cut { offset: 28 }));
        let mut orphan = file[..28].to_vec();
        orphan.extend(&write(&trace(Baud::B1500000), PROFIBUS_DL)[72..]);
        assert_eq!(read(&orphan, Baud::B9600), Err(CaptureError::Interface { offset: 28 }));
    }
}
