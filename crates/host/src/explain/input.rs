//! What can be decoded: a capture file, a trace, printed octets, or octets as they are.

use super::frame::Times;
use super::printed::Reader;
use profivac_dp::link::{Baud, BitTime};
use profivac_sim::Trace;
use profivac_sim::trace::BadLine;
use profivac_sim::trace::pcapng::{self, BadCapture};
use std::io::{ErrorKind, Read};

/// Octets that were noted together.
#[derive(Clone, Debug, PartialEq)]
pub struct Noted {
    /// When the first began, if that was noted too.
    pub start: Option<BitTime>,
    /// The octets.
    pub octets: Vec<u8>,
    /// The numbers of those with an error, counted from 0.
    pub errors: Vec<usize>,
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// What kind of file it is.
    pub kind: &'static str,
    /// The rate of the line, if the file tells it.
    pub baud: Option<Baud>,
    /// What its times are worth.
    pub times: Times,
    /// The octets.
    pub noted: Vec<Noted>,
    /// Lines without octets.
    pub skipped: Skipped,
    /// Why there is no more of a capture file.
    pub damage: Option<BadCapture>,
}

/// Lines without octets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Skipped {
    /// How many.
    pub count: usize,
    /// The number of the first, counted from 1.
    pub first: Option<usize>,
}

/// Why nothing can be decoded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BadInput {
    /// The capture file is damaged.
    #[error("{0}")]
    Capture(BadCapture),
    /// The trace is damaged.
    #[error("{0}")]
    Trace(BadLine),
    /// A capture file of the older format.
    #[error("expected pcapng, found the older pcap format: convert it with 'editcap -F pcapng'")]
    Pcap,
    /// Text in two octets a letter.
    #[error("expected text in UTF-8, found UTF-16: convert it with 'iconv -f UTF-16 -t UTF-8'")]
    Utf16,
    /// Text without a single octet.
    #[error("line {line}: expected octets in hexadecimal, as in '68 05 05 68 88 82 6D 3C 3E F1 16', found '{found}'")]
    NoOctets {
        /// The first line that is not empty.
        line: usize,
        /// What it has.
        found: String,
    },
    /// Nothing at all.
    #[error("expected telegrams, found an empty file")]
    Empty,
    /// The system does not give it.
    #[error("cannot be read: {0}")]
    Unread(String),
}

const PCAPNG: [u8; 4] = [0x0A, 0x0D, 0x0D, 0x0A];
/// Microseconds and nanoseconds, in both orders of octets.
const PCAP: [[u8; 4]; 4] =
    [[0xA1, 0xB2, 0xC3, 0xD4], [0xD4, 0xC3, 0xB2, 0xA1], [0xA1, 0xB2, 0x3C, 0x4D], [0x4D, 0x3C, 0xB2, 0xA1]];

/// What some programs put in front of a text.
const BYTE_ORDER_MARK: &[u8] = "\u{FEFF}".as_bytes();

/// How much of a line a message shows.
const SHOWN: usize = 60;

/// So much is read at a time, and no line is longer: what is, goes on in the next.
const PORTION: usize = 1 << 16;

/// So much shows what kind of file it is.
const TELLING: usize = 12;

/// A file of any kind that is told while it is read: text and plain octets may be of any size, and never end.
pub struct Source<R> {
    input: R,
    baud: Baud,
    /// What kind of file it is.
    pub kind: &'static str,
    /// The rate of the line, if the file tells it.
    pub line_baud: Option<Baud>,
    /// What its times are worth.
    pub times: Times,
    /// Lines without octets up to now.
    pub skipped: Skipped,
    /// Why there is no more of a capture file.
    pub damage: Option<BadCapture>,
    way: Way,
    /// What was read and is not noted yet.
    ahead: Vec<u8>,
    ended: bool,
    /// What was read first shows what kind of file it is, and is not noted yet.
    is_new: bool,
}

/// How a file is read.
enum Way {
    /// Line by line.
    Printed { reader: Reader, line: usize, any: bool, first: Option<(usize, String)> },
    /// As it is.
    Raw,
    /// Its format wants it as a whole.
    Whole(Vec<Noted>),
}

impl<R: Read> Source<R> {
    /// Looks what kind of file it is. Times in seconds become bit times of `baud`, unless the file has a rate.
    ///
    /// # Errors
    /// [`BadInput`] in one sentence.
    pub fn open(input: R, baud: Baud) -> Result<Self, BadInput> {
        let way = Way::Raw;
        let (kind, times, skipped) = ("octets", Times::Exact, Skipped::default());
        let (line_baud, damage, ahead, ended) = (None, None, Vec::new(), false);
        let is_new = true;
        let mut source = Self { input, baud, kind, line_baud, times, skipped, damage, way, ahead, ended, is_new };
        while !source.ended && (source.ahead.len() < TELLING || !source.ahead.contains(&b'\n')) {
            if source.ahead.len() >= PORTION {
                break;
            }
            source.fill()?;
        }
        source.begin()?;
        Ok(source)
    }

    /// Reads once. Nothing ends it.
    fn fill(&mut self) -> Result<(), BadInput> {
        let mut portion = vec![0; PORTION];
        loop {
            match self.input.read(&mut portion) {
                Ok(length) => {
                    self.ended = length == 0;
                    self.ahead.extend(portion.iter().take(length));
                    return Ok(());
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(BadInput::Unread(error.to_string())),
            }
        }
    }

    fn begin(&mut self) -> Result<(), BadInput> {
        if self.ahead.is_empty() {
            return Err(BadInput::Empty);
        }
        if self.ahead.starts_with(&PCAPNG) {
            return self.captured();
        }
        if PCAP.iter().any(|magic| self.ahead.starts_with(magic)) {
            return Err(BadInput::Pcap);
        }
        if is_utf16(&self.ahead) {
            return Err(BadInput::Utf16);
        }
        if self.ahead.starts_with(BYTE_ORDER_MARK) {
            self.ahead.drain(..BYTE_ORDER_MARK.len());
        }
        let is_text = is_utf8(&self.ahead) && !self.ahead.contains(&0);
        if is_text && is_trace(&self.ahead) {
            return self.traced();
        }
        // Programs print what they like; only what is full of other characters is not printed at all.
        if is_text || !is_binary(&self.ahead) {
            (self.kind, self.times) = ("text", Times::Platform);
            self.way = Way::Printed { reader: Reader::default(), line: 0, any: false, first: None };
        }
        Ok(())
    }

    /// The whole file.
    fn rest(&mut self) -> Result<Vec<u8>, BadInput> {
        let mut whole = std::mem::take(&mut self.ahead);
        let read = self.input.read_to_end(&mut whole);
        self.ended = true;
        read.map(|_| whole).map_err(|error| BadInput::Unread(error.to_string()))
    }

    /// What a capture file holds before it is damaged, if that is anything.
    fn captured(&mut self) -> Result<(), BadInput> {
        let file = self.rest()?;
        match pcapng::read_until_damage(&file, self.baud) {
            (trace, Some(damage)) if trace.entries.is_empty() => Err(BadInput::Capture(damage)),
            (trace, damage) => {
                self.damage = damage;
                self.whole("pcapng", trace);
                Ok(())
            }
        }
    }

    fn traced(&mut self) -> Result<(), BadInput> {
        let file = self.rest()?;
        let trace = String::from_utf8_lossy(&file).parse().map_err(BadInput::Trace)?;
        self.whole("trace", trace);
        Ok(())
    }

    fn whole(&mut self, kind: &'static str, trace: Trace) {
        (self.kind, self.line_baud) = (kind, Some(trace.baud));
        let noted = trace.entries.into_iter().map(|entry| Noted {
            start: Some(entry.start),
            octets: entry.octets.to_vec(),
            errors: entry.errors,
        });
        self.way = Way::Whole(noted.collect());
    }

    /// Appends what comes next: as much as is there at once. False when there is no more.
    ///
    /// # Errors
    /// [`BadInput`] when it cannot be read, or at the end of a text in which there was nothing.
    pub fn read(&mut self, noted: &mut Vec<Noted>) -> Result<bool, BadInput> {
        if !std::mem::take(&mut self.is_new) && !self.ended {
            self.fill()?;
        }
        match &mut self.way {
            Way::Whole(all) => noted.append(all),
            Way::Raw if self.ahead.is_empty() => {}
            Way::Raw => {
                noted.push(Noted { start: None, octets: std::mem::take(&mut self.ahead), errors: Vec::new() });
            }
            Way::Printed { .. } => return self.print(noted),
        }
        Ok(!self.ended)
    }

    /// The lines that are there.
    fn print(&mut self, noted: &mut Vec<Noted>) -> Result<bool, BadInput> {
        let mut from = 0;
        while let Some(to) = self.ahead.get(from..).and_then(|rest| end_of_line(rest, self.ended)) {
            let octets = self.ahead.get(from..from.saturating_add(to)).unwrap_or_default().to_vec();
            self.line(&String::from_utf8_lossy(&octets), noted);
            from = from.saturating_add(to);
        }
        self.ahead.drain(..from);
        match &mut self.way {
            Way::Printed { any: false, first, .. } if self.ended => {
                Err(first.take().map_or(BadInput::Empty, |(line, found)| BadInput::NoOctets { line, found }))
            }
            _ => Ok(!self.ended),
        }
    }

    fn line(&mut self, text: &str, noted: &mut Vec<Noted>) {
        let Way::Printed { reader, line, any, first } = &mut self.way else { return };
        *line = line.saturating_add(1);
        let text = text.trim();
        match reader.line(text) {
            Some(printed) => {
                *any = true;
                let start = printed.seconds.map(|seconds| bit_time(seconds, self.baud));
                noted.push(Noted { start, octets: printed.octets, errors: printed.errors });
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

/// Where the first line ends, if it is there: behind its end, or where one that is too long is cut between words.
fn end_of_line(text: &[u8], is_last: bool) -> Option<usize> {
    let portion = text.get(..PORTION).unwrap_or(text);
    if let Some(end) = portion.iter().position(|octet| *octet == b'\n') {
        return Some(end.saturating_add(1));
    }
    if text.len() < PORTION {
        return (is_last && !text.is_empty()).then_some(text.len());
    }
    let between = portion.iter().rposition(|octet| octet.is_ascii_whitespace());
    Some(between.map_or(PORTION, |between| between.saturating_add(1)))
}

impl Recording {
    /// Reads a file of any kind as a whole. Times in seconds become bit times of `baud`, unless the file has a rate.
    ///
    /// # Errors
    /// [`BadInput`] in one sentence.
    pub fn read(file: &[u8], baud: Baud) -> Result<Self, BadInput> {
        let (mut source, mut noted) = (Source::open(file, baud)?, Vec::new());
        while source.read(&mut noted)? {}
        let Source { kind, line_baud: baud, times, skipped, damage, .. } = source;
        Ok(Self { kind, baud, times, noted, skipped, damage })
    }
}

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
    use super::*;
    use profivac_sim::scenario::hex;

    fn read(file: &[u8]) -> Result<Recording, String> {
        Recording::read(file, Baud::B19200).map_err(|error| error.to_string())
    }

    #[test]
    fn every_kind_of_file_is_known_by_its_content() {
        let trace: Trace = "# 500 kbit/s\n 100  x | 10 08 02 49 53 16\n 200 | E5! 00\n".parse().unwrap();
        for (file, kind) in [
            (trace.to_string().into_bytes(), "trace"),
            (pcapng::write(&trace, pcapng::USER0), "pcapng"),
            (pcapng::write(&trace, pcapng::PROFIBUS_DL), "pcapng"),
        ] {
            let recording = read(&file).unwrap();
            assert_eq!((recording.kind, recording.baud, recording.noted.len()), (kind, Some(Baud::B500000), 2));
            assert_eq!((recording.noted[1].start, &recording.noted[1].errors[..]), (Some(BitTime(200)), &[0][..]));
        }
        let skipped = Skipped { count: 1, first: Some(2) };
        assert_eq!(read(b"RX 10 08 02 49 53 16\nwaiting\n0.5 E5").unwrap().skipped, skipped);
        assert_eq!(read(b"RX E5\n0.5 E5").unwrap().noted[1].start, Some(BitTime(9600)));
        assert_eq!(read(&hex("10 08 02 49 53 16 10 02 08 00 0A 16")).unwrap().kind, "octets");
        assert_eq!(read(b"\xB5s 10 08 02 49 53 16\n").unwrap().kind, "text", "a letter of another character set");
    }

    #[test]
    fn what_cannot_be_read_is_named_with_its_place() {
        for (file, message) in [
            (&b""[..], "expected telegrams, found an empty file"),
            (b" \n\n", "expected telegrams, found an empty file"),
            (
                b"\nhello there\n",
                "line 2: expected octets in hexadecimal, as in '68 05 05 68 88 82 6D 3C 3E F1 16', found 'hello there'",
            ),
            (b"# 500 kbit/s\nsoon | E5", "line 2: expected a bit time, found 'soon'"),
            (
                b"# 501 kbit/s\n1 | E5",
                "line 1: expected a transmission rate, as in '# 1.5 Mbit/s', found '# 501 kbit/s'",
            ),
            (
                &[0xD4, 0xC3, 0xB2, 0xA1, 2, 0],
                "expected pcapng, found the older pcap format: convert it with 'editcap -F pcapng'",
            ),
            (&[0x0A, 0x0D, 0x0D, 0x0A, 0, 0], "expected a pcapng file, found no section header"),
        ] {
            assert_eq!(read(file).unwrap_err(), message);
        }
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
            assert_eq!((source.kind, &noted, source.skipped), (whole.kind, &whole.noted, whole.skipped));
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
        let recording = Recording::read("10 08 02 49 53 16 ".repeat(octets / 6).as_bytes(), Baud::B19200).unwrap();
        assert!(recording.noted.iter().all(|noted| noted.octets.len() <= PORTION / 3 && noted.errors.is_empty()));
        assert_eq!(recording.noted.iter().map(|noted| noted.octets.len()).sum::<usize>(), octets / 6 * 6);
        let joined = Recording::read("100802495316".repeat(20_000).as_bytes(), Baud::B19200).unwrap();
        assert_eq!(joined.noted.iter().map(|noted| noted.octets.len()).sum::<usize>(), 6 * 20_000);
    }

    #[test]
    fn a_text_may_begin_with_a_mark_but_not_have_two_octets_a_letter() {
        let mark = |text: &str| [BYTE_ORDER_MARK, text.as_bytes()].concat();
        assert_eq!(read(&mark("# 500 kbit/s\r\n200 | E5\r\n")).unwrap().kind, "trace");
        assert_eq!(read(&mark("RX E5")).unwrap().noted.len(), 1);
        let wide: Vec<u16> = "\u{FEFF}RX 10 08 02 49 53 16\r\n".encode_utf16().collect();
        for file in [
            wide.iter().flat_map(|letter| letter.to_le_bytes()).collect::<Vec<_>>(),
            wide.iter().flat_map(|letter| letter.to_be_bytes()).collect(),
        ] {
            let expected = "expected text in UTF-8, found UTF-16: convert it with 'iconv -f UTF-16 -t UTF-8'";
            assert_eq!(read(&file).unwrap_err(), expected);
        }
    }
}
