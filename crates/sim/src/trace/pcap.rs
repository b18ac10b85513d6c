//! Reads capture files in the classic pcap format packet by packet.

use super::Entry;
use super::pcapng::{CaptureError, PROFIBUS_DL, USER0};
use profivac_dp::link::{Baud, BitTime};

/// The largest packet that is read. chosen: as for pcapng, the limit of libpcap.
const LARGEST: usize = 1 << 24;

/// Octets of the file header, and of the header of a packet.
const FILE_HEADER: usize = 24;
const PACKET_HEADER: usize = 16;

/// The first octets of a file, as a number in the order of the octets of its writer.
const MICROSECONDS: u32 = 0xA1B2_C3D4;
const NANOSECONDS: u32 = 0xA1B2_3C4D;

/// The bits of the link type; the others say whether frames have a check sequence.
const LINK_TYPE: u32 = 0xFFFF;

/// Reads packets from a file in portions of any size. The format has no transmission rate: times are bit times of a given one.
pub struct Reader {
    /// The octets that are not read yet.
    ahead: Vec<u8>,
    /// The position of the first of them in the file.
    offset: u64,
    baud: Baud,
    format: Option<Format>,
    is_damaged: bool,
}

/// Properties of a file.
#[derive(Clone, Copy, Debug)]
struct Format {
    big_endian: bool,
    ticks_per_second: u64,
}

impl Reader {
    /// A reader; times are bit times of `baud`.
    #[must_use]
    pub const fn new(baud: Baud) -> Self {
        Self { ahead: Vec::new(), offset: 0, baud, format: None, is_damaged: false }
    }

    /// Whether a file begins as this format does.
    #[must_use]
    pub fn is_begun_by(octets: &[u8]) -> bool {
        Format::of(octets).is_some()
    }

    /// Adds the next octets of the file.
    pub fn push(&mut self, octets: &[u8]) {
        self.ahead.extend(octets);
    }

    /// The next packets that are complete.
    ///
    /// # Errors
    /// [`CaptureError`], once, for what stops the reading; the packets before it are in `entries`.
    pub fn read(&mut self, entries: &mut Vec<Entry>) -> Result<(), CaptureError> {
        let mut at = 0_usize;
        let result = self.packets(&mut at, entries);
        self.ahead.drain(..at.min(self.ahead.len()));
        self.offset = self.offset.saturating_add(at as u64);
        self.is_damaged |= result.is_err();
        result
    }

    /// Ends the file.
    ///
    /// # Errors
    /// [`CaptureError`] if the file ends within a packet, unless an error was returned before.
    pub fn end(&mut self) -> Result<(), CaptureError> {
        let is_whole = self.ahead.is_empty() || std::mem::replace(&mut self.is_damaged, true);
        if is_whole { Ok(()) } else { Err(CaptureError::Cut { offset: self.offset }) }
    }

    fn packets(&mut self, at: &mut usize, entries: &mut Vec<Entry>) -> Result<(), CaptureError> {
        if self.is_damaged {
            return Ok(());
        }
        let format = match self.format {
            Some(format) => format,
            None => {
                let Some(header) = self.ahead.get(..FILE_HEADER) else { return Ok(()) };
                let format = Format::of(header).ok_or(CaptureError::NotPcapng)?;
                let link_type = (format.number(header, 20) & LINK_TYPE) as u16;
                if link_type != PROFIBUS_DL && link_type != USER0 {
                    return Err(CaptureError::LinkType(link_type));
                }
                *at = FILE_HEADER;
                *self.format.insert(format)
            }
        };
        while let Some(header) = self.ahead.get(*at..).and_then(|rest| rest.get(..PACKET_HEADER)) {
            let (seconds, ticks) = (format.number(header, 0), format.number(header, 4));
            let length = format.number(header, 8) as usize;
            if length > LARGEST {
                return Err(CaptureError::Block { offset: self.offset.saturating_add(*at as u64) });
            }
            let from = at.saturating_add(PACKET_HEADER);
            let Some(octets) = self.ahead.get(from..from.saturating_add(length)) else { break };
            let bits = u128::from(self.baud.bits_per_second());
            let part = (u128::from(ticks) * bits + u128::from(format.ticks_per_second / 2))
                / u128::from(format.ticks_per_second);
            let start = BitTime((u128::from(seconds) * bits + part) as u64);
            entries.push(Entry::new(start, octets, Vec::new()));
            *at = from.saturating_add(length);
        }
        Ok(())
    }
}

impl Format {
    fn of(octets: &[u8]) -> Option<Self> {
        let magic: [u8; 4] = octets.get(..4)?.try_into().ok()?;
        [false, true].into_iter().find_map(|big_endian| {
            let number = if big_endian { u32::from_be_bytes(magic) } else { u32::from_le_bytes(magic) };
            let ticks_per_second = match number {
                MICROSECONDS => 1_000_000,
                NANOSECONDS => 1_000_000_000,
                _ => return None,
            };
            Some(Self { big_endian, ticks_per_second })
        })
    }

    /// The number of four octets at a position; 0 behind the end.
    fn number(self, octets: &[u8], at: usize) -> u32 {
        let field = octets.get(at..at.saturating_add(4)).and_then(|field| field.try_into().ok()).unwrap_or_default();
        if self.big_endian { u32::from_be_bytes(field) } else { u32::from_le_bytes(field) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with two packets, in both orders of octets and both units of time.
    fn file(big_endian: bool, magic: u32, link_type: u32) -> Vec<u8> {
        let number = |number: u32| if big_endian { number.to_be_bytes() } else { number.to_le_bytes() };
        let half = if magic == MICROSECONDS { 500_000 } else { 500_000_000 };
        let mut file = [number(magic), [0; 4], [0; 4], [0; 4], number(65_535), number(link_type)].concat();
        for (seconds, octets) in [(1, &[0xE5][..]), (1_700_000_000, &[0xDC, 2, 2])] {
            let length = number(octets.len() as u32);
            file.extend([number(seconds), number(half), length, length].concat());
            file.extend(octets);
        }
        file
    }

    fn read(file: &[u8], portion: usize) -> (Vec<Entry>, Result<(), CaptureError>) {
        let (mut reader, mut entries) = (Reader::new(Baud::B19200), Vec::new());
        for portion in file.chunks(portion) {
            reader.push(portion);
            if let Err(error) = reader.read(&mut entries) {
                return (entries, Err(error));
            }
        }
        (entries, reader.end())
    }

    #[test]
    fn both_orders_and_units_have_the_same_packets_in_portions_of_any_size() {
        for (big_endian, magic) in
            [(false, MICROSECONDS), (true, MICROSECONDS), (false, NANOSECONDS), (true, NANOSECONDS)]
        {
            for portion in [1, 7, 1000] {
                let (entries, result) = read(&file(big_endian, magic, 257), portion);
                let starts: Vec<u64> = entries.iter().map(|entry| entry.start.0).collect();
                assert_eq!((result, starts), (Ok(()), vec![28_800, 1_700_000_000 * 19_200 + 9_600]));
                assert_eq!(
                    entries.iter().map(|entry| &entry.octets[..]).collect::<Vec<_>>(),
                    [&[0xE5][..], &[0xDC, 2, 2]]
                );
            }
        }
    }

    #[test]
    fn a_file_that_is_cut_or_of_another_line_is_refused_behind_its_packets() {
        let whole = file(false, MICROSECONDS, 147);
        let (entries, result) = read(&whole[..whole.len() - 1], 1000);
        assert_eq!((entries.len(), result), (1, Err(CaptureError::Cut { offset: 41 })));
        assert_eq!(read(&file(true, MICROSECONDS, 1), 1000), (vec![], Err(CaptureError::LinkType(1))));
        let mut large = whole;
        large[32..36].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(read(&large, 1000), (vec![], Err(CaptureError::Block { offset: 24 })));
    }
}
