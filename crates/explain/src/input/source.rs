//! Reads a file portion by portion: first its kind, then its octets.

use super::{Chunk, Damage, InputError, Skipped};
use crate::frame::TimeSource;
use crate::octet_row::Reader;
use profivac_dp::link::{Baud, BitTime};
use profivac_sim::trace::pcapng::{self, CaptureError};
use profivac_sim::trace::{self, TraceError};
use std::io::{ErrorKind, Read};

const PCAPNG: [u8; 4] = [0x0A, 0x0D, 0x0D, 0x0A];
/// Microseconds and nanoseconds, each in both octet orders.
const PCAP: [[u8; 4]; 4] =
    [[0xA1, 0xB2, 0xC3, 0xD4], [0xD4, 0xC3, 0xB2, 0xA1], [0xA1, 0xB2, 0x3C, 0x4D], [0x4D, 0x3C, 0xB2, 0xA1]];

/// Mark that some programs write before UTF-8 text.
pub(super) const BYTE_ORDER_MARK: &[u8] = "\u{FEFF}".as_bytes();

/// Size of one read, and longest line of a text: a longer line is split.
const PORTION_OCTETS: usize = 1 << 16;

/// Longest line of a trace in octets. free choice: a telegram has 255 octets, an entry without a pause has many more.
const MAX_TRACE_LINE: usize = 1 << 20;

/// Number of octets that show the kind of a file.
const SIGNATURE_OCTETS: usize = 12;

/// A file that is decoded while it is read. It may have any size, and a pipe may never end.
pub struct Source<R> {
    input: R,
    baud: Baud,
    /// Kind of the file: `pcapng`, `trace`, `text` or `octets`.
    pub kind: &'static str,
    /// Transmission rate of the line, if the file has one.
    pub line_baud: Option<Baud>,
    /// Source of its times.
    pub times: TimeSource,
    /// Lines without octets so far.
    pub skipped: Skipped,
    /// Damage that ends a capture file or a trace early.
    pub damage: Option<Damage>,
    format: Format,
    /// Octets of the file that are not decoded yet.
    buffer: Vec<u8>,
    ended: bool,
    /// The portion that showed the kind of the file is not decoded yet.
    is_new: bool,
    /// A trace has had no entry yet.
    is_empty: bool,
    /// Chunks that were decoded to find the transmission rate.
    found: Vec<Chunk>,
}

/// Format of a file, with the state of its reader.
enum Format {
    /// Text with hexadecimal octets.
    Printed { reader: Reader, line: usize, any: bool, first: Option<(usize, String)> },
    /// Binary octets.
    Raw,
    /// A capture file.
    Captured(pcapng::Reader),
    /// A trace of profivac.
    Traced(trace::Reader),
}

impl<R: Read> Source<R> {
    /// Opens a file and finds its kind. `baud` converts times in seconds to bit times if the file has no transmission rate.
    ///
    /// # Errors
    /// [`InputError`] if the file has nothing that can be decoded.
    pub fn open(input: R, baud: Baud) -> Result<Self, InputError> {
        let format = Format::Raw;
        let (kind, times, skipped) = ("octets", TimeSource::Exact, Skipped::default());
        let (line_baud, damage, buffer, ended) = (None, None, Vec::new(), false);
        let (is_new, is_empty, found) = (true, true, Vec::new());
        let mut source = Self {
            input,
            baud,
            kind,
            line_baud,
            times,
            skipped,
            damage,
            format,
            buffer,
            ended,
            is_new,
            is_empty,
            found,
        };
        while !source.ended && (source.buffer.len() < SIGNATURE_OCTETS || !source.buffer.contains(&b'\n')) {
            if source.buffer.len() >= PORTION_OCTETS {
                break;
            }
            source.fill()?;
        }
        source.begin()?;
        Ok(source)
    }

    /// Reads one portion into the buffer. An empty portion is the end of the file.
    fn fill(&mut self) -> Result<(), InputError> {
        let mut portion = vec![0; PORTION_OCTETS];
        loop {
            match self.input.read(&mut portion) {
                Ok(length) => {
                    self.ended = length == 0;
                    self.buffer.extend(portion.iter().take(length));
                    return Ok(());
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    return Err(InputError::Unreadable { kind: error.kind(), message: error.to_string() });
                }
            }
        }
    }

    /// Finds the format from the first portion.
    fn begin(&mut self) -> Result<(), InputError> {
        if self.buffer.is_empty() {
            return Err(InputError::Empty);
        }
        if self.buffer.starts_with(&PCAPNG) {
            return self.begin_capture();
        }
        if PCAP.iter().any(|magic| self.buffer.starts_with(magic)) {
            return Err(InputError::Pcap);
        }
        if is_utf16(&self.buffer) {
            return Err(InputError::Utf16);
        }
        if self.buffer.starts_with(BYTE_ORDER_MARK) {
            self.buffer.drain(..BYTE_ORDER_MARK.len());
        }
        let is_text = is_utf8(&self.buffer) && !self.buffer.contains(&0);
        if is_text && is_trace(&self.buffer) {
            return self.begin_trace();
        }
        // A log may contain some octets that are not UTF-8; a file with many control characters is binary.
        if is_text || !is_binary(&self.buffer) {
            (self.kind, self.times) = ("text", TimeSource::Platform);
            self.format = Format::Printed { reader: Reader::default(), line: 0, any: false, first: None };
        }
        Ok(())
    }

    /// Reads a capture file up to its first packet: its transmission rate is known then.
    fn begin_capture(&mut self) -> Result<(), InputError> {
        let mut reader = pcapng::Reader::new(self.baud);
        loop {
            reader.push(&std::mem::take(&mut self.buffer));
            match reader.next() {
                Some(entry) => {
                    self.found.push(entry.map_err(Damage::from)?.into());
                    break;
                }
                None if self.ended => {
                    reader.end().map_err(Damage::from)?;
                    break;
                }
                None => self.fill()?,
            }
        }
        (self.kind, self.line_baud, self.format) = ("pcapng", Some(reader.baud()), Format::Captured(reader));
        Ok(())
    }

    /// Reads the first line of a trace, which has the transmission rate.
    fn begin_trace(&mut self) -> Result<(), InputError> {
        let end =
            self.buffer.iter().position(|octet| *octet == b'\n').map_or(self.buffer.len(), |end| end.saturating_add(1));
        let first: Vec<u8> = self.buffer.drain(..end).collect();
        let reader = trace::Reader::begin(String::from_utf8_lossy(&first).trim_end()).map_err(Damage::from)?;
        (self.kind, self.line_baud, self.format) = ("trace", Some(reader.baud()), Format::Traced(reader));
        Ok(())
    }

    /// Appends the next chunks to `chunks`, as many as one read returns. Returns false at the end of the file.
    ///
    /// # Errors
    /// [`InputError`] if the file cannot be read, and at the end of a text without octets.
    pub fn read(&mut self, chunks: &mut Vec<Chunk>) -> Result<bool, InputError> {
        if !std::mem::take(&mut self.is_new) && !self.ended {
            self.fill()?;
        }
        chunks.append(&mut self.found);
        match &mut self.format {
            Format::Captured(reader) => {
                reader.push(&std::mem::take(&mut self.buffer));
                if let Err(damage) = packets(reader, self.ended, chunks) {
                    self.stop(damage.into());
                }
            }
            Format::Traced(reader) => {
                let result = entries(reader, &mut self.buffer, self.ended, chunks).map_err(Damage::from);
                self.is_empty &= chunks.is_empty();
                match result {
                    Err(damage) if self.is_empty => return Err(damage.into()),
                    Err(damage) => self.stop(damage),
                    Ok(()) => {}
                }
            }
            Format::Raw if self.buffer.is_empty() => {}
            Format::Raw => {
                chunks.push(Chunk {
                    start: None,
                    octets: std::mem::take(&mut self.buffer),
                    errors: Vec::new(),
                    is_continued: true,
                });
            }
            Format::Printed { .. } => return self.decode_lines(chunks),
        }
        Ok(!self.ended)
    }

    /// Ends the file at the damage.
    fn stop(&mut self, damage: Damage) {
        (self.damage, self.ended) = (Some(damage), true);
        self.buffer.clear();
    }

    /// Decodes the complete lines in the buffer.
    fn decode_lines(&mut self, chunks: &mut Vec<Chunk>) -> Result<bool, InputError> {
        let mut from = 0;
        while let Some(to) = self.buffer.get(from..).and_then(|rest| end_of_line(rest, self.ended)) {
            let octets = self.buffer.get(from..from.saturating_add(to)).unwrap_or_default().to_vec();
            self.line(&String::from_utf8_lossy(&octets), chunks);
            from = from.saturating_add(to);
        }
        self.buffer.drain(..from);
        match &mut self.format {
            Format::Printed { any: false, first, .. } if self.ended => {
                Err(first.take().map_or(InputError::Empty, |(line, found)| InputError::NoOctets { line, found }))
            }
            _ => Ok(!self.ended),
        }
    }

    fn line(&mut self, text: &str, chunks: &mut Vec<Chunk>) {
        let Format::Printed { reader, line, any, first } = &mut self.format else { return };
        *line = line.saturating_add(1);
        let text = text.trim();
        match reader.line(text) {
            Some(row) => {
                *any = true;
                let start = row.seconds.map(|seconds| bit_time(seconds, self.baud));
                chunks.push(Chunk { start, octets: row.octets, errors: row.errors, is_continued: false });
            }
            None if text.is_empty() => {}
            None => {
                first.get_or_insert_with(|| (*line, text.chars().take(SHOWN).collect()));
                self.skipped.count = self.skipped.count.saturating_add(1);
                self.skipped.first = self.skipped.first.or(Some(*line));
            }
        }
    }
}

/// Decodes the complete packets.
fn packets(reader: &mut pcapng::Reader, is_last: bool, chunks: &mut Vec<Chunk>) -> Result<(), CaptureError> {
    while let Some(entry) = reader.next() {
        chunks.push(entry?.into());
    }
    if is_last { reader.end() } else { Ok(()) }
}

/// Decodes the complete lines of a trace. The last line of the file may have no line end.
fn entries(
    reader: &mut trace::Reader,
    buffer: &mut Vec<u8>,
    is_last: bool,
    chunks: &mut Vec<Chunk>,
) -> Result<(), TraceError> {
    let mut from = 0_usize;
    let mut result = Ok(());
    while let Some(rest) = buffer.get(from..).filter(|rest| !rest.is_empty()) {
        let end = rest.iter().position(|octet| *octet == b'\n').map(|end| end.saturating_add(1));
        // A line that is too long goes to the reader as it is: the reader names the error.
        let Some(end) = end.or((is_last || rest.len() > MAX_TRACE_LINE).then_some(rest.len())) else { break };
        let line = String::from_utf8_lossy(rest.get(..end).unwrap_or_default()).into_owned();
        from = from.saturating_add(end);
        match reader.line(line.trim_end()) {
            Ok(entry) => chunks.extend(entry.map(Chunk::from)),
            Err(bad) => {
                result = Err(bad);
                break;
            }
        }
    }
    buffer.drain(..from.min(buffer.len()));
    result
}

/// Position after the first line, if the line is complete. A line that is too long is split between words.
fn end_of_line(text: &[u8], is_last: bool) -> Option<usize> {
    let portion = text.get(..PORTION_OCTETS).unwrap_or(text);
    if let Some(end) = portion.iter().position(|octet| *octet == b'\n') {
        return Some(end.saturating_add(1));
    }
    if text.len() < PORTION_OCTETS {
        return (is_last && !text.is_empty()).then_some(text.len());
    }
    let between = portion.iter().rposition(|octet| octet.is_ascii_whitespace());
    Some(between.map_or(PORTION_OCTETS, |between| between.saturating_add(1)))
}

/// Number of characters of a line that a message shows.
const SHOWN: usize = 60;

/// Whether the first line is that of a trace: `# 500 kbit/s`.
fn is_trace(text: &[u8]) -> bool {
    let first = text.split(|octet| *octet == b'\n').next().unwrap_or_default();
    first.starts_with(b"# ") && first.trim_ascii_end().ends_with(b"bit/s")
}

/// Whether the octets are UTF-8. The last character may be incomplete.
fn is_utf8(text: &[u8]) -> bool {
    std::str::from_utf8(text).map_or_else(|error| error.error_len().is_none(), |_| true)
}

/// Whether the octets are UTF-16: a byte order mark, and zero in more than nine of ten high octets.
fn is_utf16(text: &[u8]) -> bool {
    let zeros = |odd: usize| text.iter().skip(2 + odd).step_by(2).filter(|octet| **octet == 0).count();
    let letters = text.len().saturating_sub(2) / 2;
    let most = |zeros: usize| letters > 0 && zeros.saturating_mul(10) > letters.saturating_mul(9);
    (text.starts_with(&[0xFF, 0xFE]) && most(zeros(1))) || (text.starts_with(&[0xFE, 0xFF]) && most(zeros(0)))
}

/// Whether more than one octet in ten is a control character.
fn is_binary(file: &[u8]) -> bool {
    let strange = file.iter().filter(|octet| octet.is_ascii_control() && !octet.is_ascii_whitespace()).count();
    strange.saturating_mul(10) > file.len()
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a time of day in bit times")]
fn bit_time(seconds: f64, baud: Baud) -> BitTime {
    BitTime((seconds * f64::from(baud.bits_per_second())).round() as u64)
}

#[cfg(test)]
mod tests {
    use super::super::Capture;
    use super::*;
    use profivac_sim::Trace;

    fn read(file: &[u8]) -> Result<Capture, String> {
        Capture::read(file, Baud::B19200).map_err(|error| error.to_string())
    }

    /// Returns three octets per read, like a slow pipe, and counts the octets that were read.
    struct Slow<'a>(&'a [u8], &'a std::cell::Cell<usize>);

    impl Read for Slow<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            let length = self.0.take(3).read(buffer)?;
            self.0 = &self.0[length..];
            self.1.set(self.1.get() + length);
            Ok(length)
        }
    }

    #[test]
    fn a_source_returns_the_same_chunks_for_small_and_large_portions() {
        let trace: Trace = "# 500 kbit/s\n 100  x | 10 08 02 49 53 16\n 200 | E5! 00\n".parse().unwrap();
        let text = b"a log\r\nRX 10 08 02 49 53 16\r\nwaiting\r\n0.5 E5".to_vec();
        for file in [pcapng::write(&trace, pcapng::USER0), trace.to_string().into_bytes(), text] {
            let octets_read = std::cell::Cell::new(0);
            let mut source = Source::open(Slow(&file, &octets_read), Baud::B19200).unwrap();
            let mut chunks = Vec::new();
            while source.read(&mut chunks).unwrap() {}
            let whole = read(&file).unwrap();
            assert_eq!((source.kind, &chunks, source.skipped), (whole.kind, &whole.chunks, whole.skipped));
        }
    }

    /// A source of a capture or a trace does not wait for more than one chunk, like a source of a text.
    #[test]
    fn a_source_returns_a_packet_before_the_next_one_arrives() {
        let trace: Trace = "# 500 kbit/s\n 100  x | 10 08 02 49 53 16\n 200 | E5\n 300 | E5\n".parse().unwrap();
        for file in [pcapng::write(&trace, pcapng::USER0), trace.to_string().into_bytes()] {
            let octets_read = std::cell::Cell::new(0);
            let mut source = Source::open(Slow(&file, &octets_read), Baud::B19200).unwrap();
            let mut chunks = Vec::new();
            while chunks.is_empty() {
                assert!(source.read(&mut chunks).unwrap());
            }
            assert!(
                chunks.len() == 1 && octets_read.get() + 36 < file.len(),
                "{} of {}",
                octets_read.get(),
                file.len()
            );
        }
    }

    #[test]
    fn a_source_returns_the_chunks_before_the_damage_of_a_file() {
        let trace: Trace = "# 500 kbit/s\n 100  x | 10 08 02 49 53 16\n 200 | E5\n".parse().unwrap();
        let capture = pcapng::write(&trace, pcapng::USER0);
        let mut text = trace.to_string();
        text.truncate(text.len() - 2);
        let at = capture.len() - 36;
        for (file, damage) in [
            (
                &capture[..capture.len() - 1],
                format!("the file ends within the block at octet {at}: it was cut off, or is still being written"),
            ),
            (text.as_bytes(), "line 3: expected two hexadecimal digits, found 'E'".to_owned()),
        ] {
            let capture = read(file).unwrap();
            assert_eq!(capture.chunks.len(), 1);
            assert_eq!(capture.damage.map(|damage| damage.to_string()), Some(damage));
        }
    }

    /// An endless capture does not accumulate in memory.
    #[test]
    fn a_source_holds_a_limited_number_of_octets_of_an_endless_file() {
        let trace: Trace = "# 500 kbit/s\n 100  x | 10 08 02 49 53 16\n".parse().unwrap();
        let capture = pcapng::write(&trace, pcapng::USER0);
        let text = trace.to_string();
        let (head, line) = text.split_at(text.find('\n').unwrap() + 1);
        for (head, again) in [(&capture[..72], &capture[72..]), (head.as_bytes(), line.as_bytes())] {
            let mut source = Source::open(head.chain(Endless(again, 0)), Baud::B19200).unwrap();
            let mut count = 0;
            while count < 100_000 {
                let mut chunks = Vec::new();
                assert!(source.read(&mut chunks).unwrap());
                assert!(chunks.len() <= 2 * PORTION_OCTETS / again.len() + 2, "{}", chunks.len());
                count += chunks.len();
                assert!(source.buffer.len() <= 2 * PORTION_OCTETS && source.buffer.capacity() <= 4 * PORTION_OCTETS);
            }
        }
    }

    /// Repeats its octets without end.
    struct Endless<'a>(&'a [u8], usize);

    impl Read for Endless<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            for octet in &mut *buffer {
                *octet = self.0[self.1 % self.0.len()];
                self.1 += 1;
            }
            Ok(buffer.len())
        }
    }

    #[test]
    fn a_source_returns_a_line_before_the_next_one_arrives() {
        let log = b"RX 10 08 02 49 53 16\nRX E5\nRX E5\n";
        let octets_read = std::cell::Cell::new(0);
        let mut source = Source::open(Slow(log, &octets_read), Baud::B19200).unwrap();
        let mut chunks = Vec::new();
        assert!(source.read(&mut chunks).unwrap());
        assert_eq!((chunks.len(), octets_read.get() < 27), (1, true));
    }

    #[test]
    fn a_source_splits_an_endless_line_between_octets() {
        let octets = 100_000;
        let capture = Capture::read("10 08 02 49 53 16 ".repeat(octets / 6).as_bytes(), Baud::B19200).unwrap();
        assert!(capture.chunks.iter().all(|chunk| chunk.octets.len() <= PORTION_OCTETS / 3 && chunk.errors.is_empty()));
        assert_eq!(capture.chunks.iter().map(|chunk| chunk.octets.len()).sum::<usize>(), octets / 6 * 6);
        let joined = Capture::read("100802495316".repeat(20_000).as_bytes(), Baud::B19200).unwrap();
        assert_eq!(joined.chunks.iter().map(|chunk| chunk.octets.len()).sum::<usize>(), 6 * 20_000);
    }
}
