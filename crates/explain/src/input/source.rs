//! A file that is read while it is told: what kind it is, and portion by portion what it holds.

use super::{Chunk, Damage, InputError, Skipped};
use crate::frame::TimeSource;
use crate::octet_row::Reader;
use profivac_dp::link::{Baud, BitTime};
use profivac_sim::trace::pcapng::{self, CaptureError};
use profivac_sim::trace::{self, TraceError};
use std::io::{ErrorKind, Read};

const PCAPNG: [u8; 4] = [0x0A, 0x0D, 0x0D, 0x0A];
/// Microseconds and nanoseconds, in both orders of octets.
const PCAP: [[u8; 4]; 4] =
    [[0xA1, 0xB2, 0xC3, 0xD4], [0xD4, 0xC3, 0xB2, 0xA1], [0xA1, 0xB2, 0x3C, 0x4D], [0x4D, 0x3C, 0xB2, 0xA1]];

/// What some programs put in front of a text.
pub(super) const BYTE_ORDER_MARK: &[u8] = "\u{FEFF}".as_bytes();

/// So much is read at a time, and no line is longer: what is, goes on in the next.
const PORTION_OCTETS: usize = 1 << 16;

/// No line of a trace is longer. free choice: a telegram has 255 octets, what was never quiet many more.
const MAX_TRACE_LINE: usize = 1 << 20;

/// So much shows what kind of file it is.
const SIGNATURE_OCTETS: usize = 12;

/// A file of any kind that is told while it is read: it may be of any size, and never end.
pub struct Source<R> {
    input: R,
    baud: Baud,
    /// What kind of file it is.
    pub kind: &'static str,
    /// The rate of the line, if the file tells it.
    pub line_baud: Option<Baud>,
    /// What its times are worth.
    pub times: TimeSource,
    /// Lines without octets up to now.
    pub skipped: Skipped,
    /// Why there is no more of a capture file or a trace.
    pub damage: Option<Damage>,
    format: Format,
    /// What was read and is not noted yet.
    buffer: Vec<u8>,
    ended: bool,
    /// What was read first shows what kind of file it is, and is not noted yet.
    is_new: bool,
    /// Nothing was noted of a trace yet.
    is_empty: bool,
    /// What had to be found first.
    found: Vec<Chunk>,
}

/// How a file is read.
enum Format {
    /// Line by line.
    Printed { reader: Reader, line: usize, any: bool, first: Option<(usize, String)> },
    /// As it is.
    Raw,
    /// Block by block.
    Captured(pcapng::Reader),
    /// Line by line, as profivac wrote it.
    Traced(trace::Reader),
}

impl<R: Read> Source<R> {
    /// Looks what kind of file it is. Times in seconds become bit times of `baud`, unless the file has a rate.
    ///
    /// # Errors
    /// [`BadInput`] in one sentence.
    pub fn open(input: R, baud: Baud) -> Result<Self, InputError> {
        let way = Format::Raw;
        let (kind, times, skipped) = ("octets", TimeSource::Exact, Skipped::default());
        let (line_baud, damage, ahead, ended) = (None, None, Vec::new(), false);
        let (is_new, is_empty, found) = (true, true, Vec::new());
        let mut source = Self {
            input,
            baud,
            kind,
            line_baud,
            times,
            skipped,
            damage,
            format: way,
            buffer: ahead,
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

    /// Reads once. Nothing ends it.
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
                Err(error) => return Err(InputError::Unreadable(error.to_string())),
            }
        }
    }

    fn begin(&mut self) -> Result<(), InputError> {
        if self.buffer.is_empty() {
            return Err(InputError::Empty);
        }
        if self.buffer.starts_with(&PCAPNG) {
            return self.captured();
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
            return self.traced();
        }
        // Programs print what they like; only what is full of other characters is not printed at all.
        if is_text || !is_binary(&self.buffer) {
            (self.kind, self.times) = ("text", TimeSource::Platform);
            self.format = Format::Printed { reader: Reader::default(), line: 0, any: false, first: None };
        }
        Ok(())
    }

    /// A capture file up to its first packet: before that its rate is not known.
    fn captured(&mut self) -> Result<(), InputError> {
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

    /// The first line of a trace.
    fn traced(&mut self) -> Result<(), InputError> {
        let end =
            self.buffer.iter().position(|octet| *octet == b'\n').map_or(self.buffer.len(), |end| end.saturating_add(1));
        let first: Vec<u8> = self.buffer.drain(..end).collect();
        let reader = trace::Reader::begin(String::from_utf8_lossy(&first).trim_end()).map_err(Damage::from)?;
        (self.kind, self.line_baud, self.format) = ("trace", Some(reader.baud()), Format::Traced(reader));
        Ok(())
    }

    /// Appends what comes next: as much as is there at once. False when there is no more.
    ///
    /// # Errors
    /// [`BadInput`] when it cannot be read, or at the end of a text in which there was nothing.
    pub fn read(&mut self, noted: &mut Vec<Chunk>) -> Result<bool, InputError> {
        if !std::mem::take(&mut self.is_new) && !self.ended {
            self.fill()?;
        }
        noted.append(&mut self.found);
        match &mut self.format {
            Format::Captured(reader) => {
                reader.push(&std::mem::take(&mut self.buffer));
                if let Err(damage) = packets(reader, self.ended, noted) {
                    self.stop(damage.into());
                }
            }
            Format::Traced(reader) => {
                let done = entries(reader, &mut self.buffer, self.ended, noted).map_err(Damage::from);
                self.is_empty &= noted.is_empty();
                match done {
                    Err(damage) if self.is_empty => return Err(damage.into()),
                    Err(damage) => self.stop(damage),
                    Ok(()) => {}
                }
            }
            Format::Raw if self.buffer.is_empty() => {}
            Format::Raw => {
                noted.push(Chunk { start: None, octets: std::mem::take(&mut self.buffer), errors: Vec::new() });
            }
            Format::Printed { .. } => return self.print(noted),
        }
        Ok(!self.ended)
    }

    /// Nothing behind it is read.
    fn stop(&mut self, damage: Damage) {
        (self.damage, self.ended) = (Some(damage), true);
        self.buffer.clear();
    }

    /// The lines that are there.
    fn print(&mut self, noted: &mut Vec<Chunk>) -> Result<bool, InputError> {
        let mut from = 0;
        while let Some(to) = self.buffer.get(from..).and_then(|rest| end_of_line(rest, self.ended)) {
            let octets = self.buffer.get(from..from.saturating_add(to)).unwrap_or_default().to_vec();
            self.line(&String::from_utf8_lossy(&octets), noted);
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

    fn line(&mut self, text: &str, noted: &mut Vec<Chunk>) {
        let Format::Printed { reader, line, any, first } = &mut self.format else { return };
        *line = line.saturating_add(1);
        let text = text.trim();
        match reader.line(text) {
            Some(printed) => {
                *any = true;
                let start = printed.seconds.map(|seconds| bit_time(seconds, self.baud));
                noted.push(Chunk { start, octets: printed.octets, errors: printed.errors });
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

/// The packets that are there.
fn packets(reader: &mut pcapng::Reader, is_last: bool, noted: &mut Vec<Chunk>) -> Result<(), CaptureError> {
    while let Some(entry) = reader.next() {
        noted.push(entry?.into());
    }
    if is_last { reader.end() } else { Ok(()) }
}

/// The entries of the lines that are there. The last may have no end.
fn entries(
    reader: &mut trace::Reader,
    ahead: &mut Vec<u8>,
    is_last: bool,
    noted: &mut Vec<Chunk>,
) -> Result<(), TraceError> {
    let mut from = 0_usize;
    let mut done = Ok(());
    while let Some(rest) = ahead.get(from..).filter(|rest| !rest.is_empty()) {
        let end = rest.iter().position(|octet| *octet == b'\n').map(|end| end.saturating_add(1));
        // What is no line for so long is none: the words before the octets are wrong, or they are missing.
        let Some(end) = end.or((is_last || rest.len() > MAX_TRACE_LINE).then_some(rest.len())) else { break };
        let line = String::from_utf8_lossy(rest.get(..end).unwrap_or_default()).into_owned();
        from = from.saturating_add(end);
        match reader.line(line.trim_end()) {
            Ok(entry) => noted.extend(entry.map(Chunk::from)),
            Err(bad) => {
                done = Err(bad);
                break;
            }
        }
    }
    ahead.drain(..from.min(ahead.len()));
    done
}

/// Where the first line ends, if it is there: behind its end, or where one that is too long is cut between words.
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

/// How much of a line a message shows.
const SHOWN: usize = 60;

/// A trace says its rate first.
fn is_trace(text: &[u8]) -> bool {
    let first = text.split(|octet| *octet == b'\n').next().unwrap_or_default();
    first.starts_with(b"# ") && first.trim_ascii_end().ends_with(b"bit/s")
}

/// Letters may be cut off at the end.
fn is_utf8(text: &[u8]) -> bool {
    std::str::from_utf8(text).map_or_else(|error| error.error_len().is_none(), |_| true)
}

/// A mark, and every other octet zero as in plain text.
fn is_utf16(text: &[u8]) -> bool {
    let zeros = |odd: usize| text.iter().skip(2 + odd).step_by(2).filter(|octet| **octet == 0).count();
    let letters = text.len().saturating_sub(2) / 2;
    let most = |zeros: usize| letters > 0 && zeros.saturating_mul(10) > letters.saturating_mul(9);
    (text.starts_with(&[0xFF, 0xFE]) && most(zeros(1))) || (text.starts_with(&[0xFE, 0xFF]) && most(zeros(0)))
}

/// More than one octet in ten is one that no text has.
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

    /// Hands out three octets at a time, as a slow pipe does, and says how much was taken.
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
    fn it_does_not_matter_in_which_portions_a_file_comes() {
        let trace: Trace = "# 500 kbit/s\n 100  x | 10 08 02 49 53 16\n 200 | E5! 00\n".parse().unwrap();
        let text = b"a log\r\nRX 10 08 02 49 53 16\r\nwaiting\r\n0.5 E5".to_vec();
        for file in [pcapng::write(&trace, pcapng::USER0), trace.to_string().into_bytes(), text] {
            let taken = std::cell::Cell::new(0);
            let mut source = Source::open(Slow(&file, &taken), Baud::B19200).unwrap();
            let mut noted = Vec::new();
            while source.read(&mut noted).unwrap() {}
            let whole = read(&file).unwrap();
            assert_eq!((source.kind, &noted, source.skipped), (whole.kind, &whole.chunks, whole.skipped));
        }
    }

    /// Of a capture and a trace as of a text: what is there is noted, the rest is not waited for.
    #[test]
    fn a_packet_is_noted_before_the_next_is_there() {
        let trace: Trace = "# 500 kbit/s\n 100  x | 10 08 02 49 53 16\n 200 | E5\n 300 | E5\n".parse().unwrap();
        for file in [pcapng::write(&trace, pcapng::USER0), trace.to_string().into_bytes()] {
            let taken = std::cell::Cell::new(0);
            let mut source = Source::open(Slow(&file, &taken), Baud::B19200).unwrap();
            let mut noted = Vec::new();
            while noted.is_empty() {
                assert!(source.read(&mut noted).unwrap());
            }
            assert!(noted.len() == 1 && taken.get() + 36 < file.len(), "{} of {}", taken.get(), file.len());
        }
    }

    #[test]
    fn a_file_that_was_cut_off_is_noted_up_to_there() {
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
            let recording = read(file).unwrap();
            assert_eq!(recording.chunks.len(), 1);
            assert_eq!(recording.damage.map(|damage| damage.to_string()), Some(damage));
        }
    }

    /// A capture that never ends is held no longer than it takes to note it.
    #[test]
    fn a_file_of_any_size_needs_no_more_room() {
        let trace: Trace = "# 500 kbit/s\n 100  x | 10 08 02 49 53 16\n".parse().unwrap();
        let capture = pcapng::write(&trace, pcapng::USER0);
        let text = trace.to_string();
        let (head, line) = text.split_at(text.find('\n').unwrap() + 1);
        for (head, again) in [(&capture[..72], &capture[72..]), (head.as_bytes(), line.as_bytes())] {
            let mut source = Source::open(head.chain(Endless(again, 0)), Baud::B19200).unwrap();
            let mut all = 0;
            while all < 100_000 {
                let mut noted = Vec::new();
                assert!(source.read(&mut noted).unwrap());
                assert!(noted.len() <= 2 * PORTION_OCTETS / again.len() + 2, "{}", noted.len());
                all += noted.len();
                assert!(source.buffer.len() <= 2 * PORTION_OCTETS && source.buffer.capacity() <= 4 * PORTION_OCTETS);
            }
        }
    }

    /// The same again and again.
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
    fn a_line_is_noted_before_the_next_is_there() {
        let log = b"RX 10 08 02 49 53 16\nRX E5\nRX E5\n";
        let taken = std::cell::Cell::new(0);
        let mut source = Source::open(Slow(log, &taken), Baud::B19200).unwrap();
        let mut noted = Vec::new();
        assert!(source.read(&mut noted).unwrap());
        assert_eq!((noted.len(), taken.get() < 27), (1, true));
    }

    #[test]
    fn a_line_without_end_is_cut_between_octets() {
        let octets = 100_000;
        let recording = Capture::read("10 08 02 49 53 16 ".repeat(octets / 6).as_bytes(), Baud::B19200).unwrap();
        assert!(
            recording.chunks.iter().all(|noted| noted.octets.len() <= PORTION_OCTETS / 3 && noted.errors.is_empty())
        );
        assert_eq!(recording.chunks.iter().map(|noted| noted.octets.len()).sum::<usize>(), octets / 6 * 6);
        let joined = Capture::read("100802495316".repeat(20_000).as_bytes(), Baud::B19200).unwrap();
        assert_eq!(joined.chunks.iter().map(|noted| noted.octets.len()).sum::<usize>(), 6 * 20_000);
    }
}
