//! Reads a file portion by portion: first its kind, then its octets.

use super::kind::{BYTE_ORDER_MARK, KindFinder, MOST_OCTETS, SourceKind};
use super::{Chunk, Damage, InputError};
use crate::frame::TimeSource;
use crate::text::{self, Found, Ignored, IgnoredKind, LeftOver, Notation, Row, StatedNotation};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT};
use profivac_sim::trace::pcapng::{self, CaptureError, Times};
use profivac_sim::trace::{self, Entry, TraceError, pcap};
use std::collections::VecDeque;
use std::io::{ErrorKind, Read};

/// The rate whose bit times count the times of a file without a rate. chosen: the fastest one, whose bit times are whole parts of a
/// microsecond, so that no time of such a file is rounded to bit times of a line that it does not name.
const CLOCK: Baud = Baud::B12000000;

/// Size of one read, and longest line of a text that is read at once.
const PORTION_OCTETS: usize = MOST_OCTETS;

/// Most octets of a chunk: a longer packet or line is split. It bounds the memory for the pieces of a chunk.
const CHUNK_OCTETS: usize = 1 << 12;

/// Longest line of a trace in octets. chosen: a telegram has 255 octets, an entry without a pause has many more.
const MAX_TRACE_LINE: usize = 1 << 20;

/// Where a line of a text that is too long may be split in front of the last octets of a portion.
const SPLIT_OCTETS: usize = 1 << 10;

/// A file that is decoded while it is read. It may have any size, and a pipe may never end.
pub struct Source<R> {
    input: R,
    baud: Baud,
    /// Kind of the file.
    pub kind: SourceKind,
    /// Whether the octets showed the kind, and not the caller.
    pub is_detected: bool,
    /// Transmission rate of the line, if the file has one.
    pub line_baud: Option<Baud>,
    /// Source of its times.
    pub times: TimeSource,
    /// The number of octets in the chunks so far.
    pub octets: u64,
    /// Text that may be octets and is in no chunk. The caller takes it.
    pub left_over: Vec<LeftOver>,
    /// Damage that ends a capture file or a trace early.
    pub damage: Option<Damage>,
    format: Format,
    /// Room for one read.
    portion: Vec<u8>,
    /// Octets of the file that are not decoded yet.
    buffer: Vec<u8>,
    ended: bool,
    /// The portion that showed the kind of the file is not decoded yet.
    is_new: bool,
    /// No chunk was read yet.
    is_empty: bool,
    /// Chunks that wait to be split.
    long: VecDeque<LongChunk>,
}

/// A chunk of any length, as often as a dump has it.
struct LongChunk {
    chunk: Chunk,
    times: u64,
    /// The number of octets that are in other chunks already.
    done: usize,
}

/// Format of a file, with the state of its reader.
enum Format {
    /// Text with hexadecimal octets.
    Text(Box<text::Log>),
    /// Binary octets.
    Octets,
    /// A capture file.
    Pcapng(pcapng::Reader),
    /// A capture file of the older format.
    Pcap(pcap::Reader),
    /// A trace of profivac.
    Trace(trace::Reader),
}

impl<R: Read> Source<R> {
    /// Opens a file and finds its kind. `baud` is the rate of the line if the file has none: it turns numbers of samples into times.
    ///
    /// # Errors
    /// [`InputError`] if the file has nothing that can be decoded.
    pub fn open(input: R, baud: Baud) -> Result<Self, InputError> {
        let mut source = Self::new(input, baud);
        let mut finder = KindFinder::default();
        let kind = loop {
            source.fill()?;
            if let Some(kind) = finder.kind(&source.buffer, source.ended)? {
                break kind;
            }
        };
        source.begin(kind)?;
        Ok(source)
    }

    /// Opens a file of a known kind: [`SourceKind::Text`] or [`SourceKind::Octets`], where the octets alone may mislead.
    ///
    /// # Errors
    /// [`InputError`] if the file has nothing that can be decoded.
    pub fn open_as(input: R, baud: Baud, kind: SourceKind) -> Result<Self, InputError> {
        let mut source = Self { is_detected: false, ..Self::new(input, baud) };
        source.fill()?;
        source.begin(kind)?;
        Ok(source)
    }

    /// Opens a text in a notation that the user states: no telegram need show it.
    ///
    /// # Errors
    /// As [`open_as`](Self::open_as).
    pub fn open_in(input: R, baud: Baud, notation: StatedNotation) -> Result<Self, InputError> {
        let mut source = Self::open_as(input, baud, SourceKind::Text)?;
        if let Format::Text(reader) = &mut source.format {
            reader.state(notation);
        }
        Ok(source)
    }

    const fn new(input: R, baud: Baud) -> Self {
        Self {
            input,
            baud,
            kind: SourceKind::Octets,
            is_detected: true,
            line_baud: None,
            times: TimeSource::Exact,
            octets: 0,
            left_over: Vec::new(),
            damage: None,
            format: Format::Octets,
            portion: Vec::new(),
            buffer: Vec::new(),
            ended: false,
            is_new: true,
            is_empty: true,
            long: VecDeque::new(),
        }
    }

    /// The rate whose bit times the times of the chunks are: that of the line if the file has it, otherwise a fine one.
    #[must_use]
    pub fn clock(&self) -> Baud {
        self.line_baud.unwrap_or(CLOCK)
    }

    /// The notation of a text, as soon as its first telegram with a check octet or its end has shown it.
    #[must_use]
    pub fn notation(&self) -> Option<Notation> {
        match &self.format {
            Format::Text(reader) => reader.notation(),
            Format::Octets | Format::Pcapng(_) | Format::Pcap(_) | Format::Trace(_) => None,
        }
    }

    /// Whether a telegram or the user has shown the notation of a text. Otherwise it is assumed.
    #[must_use]
    pub fn is_notation_shown(&self) -> bool {
        match &self.format {
            Format::Text(reader) => reader.is_shown(),
            Format::Octets | Format::Pcapng(_) | Format::Pcap(_) | Format::Trace(_) => false,
        }
    }

    /// The text that is not octets.
    #[must_use]
    pub fn ignored(&self) -> Ignored {
        match &self.format {
            Format::Text(reader) => reader.ignored(),
            Format::Octets | Format::Pcapng(_) | Format::Pcap(_) | Format::Trace(_) => Ignored::default(),
        }
    }

    /// The packets of other link types that a capture file has.
    #[must_use]
    pub const fn skipped(&self) -> Option<pcapng::Skipped> {
        match &self.format {
            Format::Pcapng(reader) => reader.skipped(),
            Format::Text(_) | Format::Octets | Format::Pcap(_) | Format::Trace(_) => None,
        }
    }

    /// Reads one portion into the buffer. An empty portion is the end of the file.
    fn fill(&mut self) -> Result<(), InputError> {
        self.portion.resize(PORTION_OCTETS, 0);
        loop {
            match self.input.read(&mut self.portion) {
                Ok(count) => {
                    self.ended = count == 0;
                    self.buffer.extend(self.portion.iter().take(count));
                    return Ok(());
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    return Err(InputError::Unreadable { kind: error.kind(), message: error.to_string() });
                }
            }
        }
    }

    /// Makes the reader of the format.
    fn begin(&mut self, kind: SourceKind) -> Result<(), InputError> {
        self.kind = kind;
        if self.buffer.is_empty() {
            return Err(InputError::Empty);
        }
        let has_mark = self.buffer.starts_with(BYTE_ORDER_MARK);
        if has_mark && matches!(kind, SourceKind::Text | SourceKind::Trace) {
            self.buffer.drain(..BYTE_ORDER_MARK.len());
        }
        match kind {
            SourceKind::Octets => {}
            SourceKind::Pcapng => self.begin_capture()?,
            SourceKind::Pcap => {
                (self.times, self.format) = (TimeSource::Platform, Format::Pcap(pcap::Reader::new(CLOCK)));
            }
            SourceKind::Trace => self.begin_trace()?,
            SourceKind::Text => {
                let mut reader = Box::new(text::Log::new(self.baud));
                if has_mark {
                    reader.ignore(IgnoredKind::ByteOrderMark, "EF BB BF");
                }
                (self.times, self.format) = (TimeSource::Platform, Format::Text(reader));
            }
        }
        Ok(())
    }

    /// Reads a capture file up to its first packet: its transmission rate is known then.
    fn begin_capture(&mut self) -> Result<(), InputError> {
        let mut reader = pcapng::Reader::new(CLOCK);
        loop {
            reader.push(&std::mem::take(&mut self.buffer));
            match reader.next() {
                Some(packet) => {
                    self.add(chunk_of(packet.map_err(Damage::from)?), 1);
                    break;
                }
                None if self.ended => {
                    reader.end().map_err(Damage::from)?;
                    break;
                }
                None => self.fill()?,
            }
        }
        self.line_baud = reader.line_baud();
        if self.line_baud.is_none() {
            self.times = TimeSource::Platform;
        }
        self.format = Format::Pcapng(reader);
        Ok(())
    }

    /// Reads the first line of a trace, which has the transmission rate.
    fn begin_trace(&mut self) -> Result<(), InputError> {
        let end =
            self.buffer.iter().position(|octet| *octet == b'\n').map_or(self.buffer.len(), |end| end.saturating_add(1));
        let first: Vec<u8> = self.buffer.drain(..end).collect();
        let reader = trace::Reader::begin(String::from_utf8_lossy(&first).trim_end()).map_err(Damage::from)?;
        (self.line_baud, self.format) = (Some(reader.baud()), Format::Trace(reader));
        Ok(())
    }

    /// Adds octets to those that are returned next.
    fn add(&mut self, chunk: Chunk, times: u64) {
        let length = (chunk.octets.len() as u64).saturating_mul(times);
        self.octets = self.octets.saturating_add(length);
        self.is_empty &= length == 0;
        if length > 0 {
            self.long.push_back(LongChunk { chunk, times, done: 0 });
        }
    }

    /// Appends the next chunks to `chunks`, as many as one read returns and not more than its size. Returns false at the end of the
    /// file.
    ///
    /// # Errors
    /// [`InputError`] if the file cannot be read, and at the end of a text without octets.
    pub fn read(&mut self, chunks: &mut Vec<Chunk>) -> Result<bool, InputError> {
        if self.long.is_empty() || self.is_new {
            if !std::mem::take(&mut self.is_new) && !self.ended {
                self.fill()?;
            }
            self.decode()?;
        }
        let mut count = 0;
        while count < PORTION_OCTETS
            && let Some(long) = self.long.front_mut()
        {
            let chunk = long.next(self.times);
            count = count.saturating_add(chunk.octets.len());
            chunks.push(chunk);
            if long.times == 0 {
                self.long.pop_front();
            }
        }
        Ok(!self.ended || !self.long.is_empty())
    }

    /// Decodes the buffer.
    fn decode(&mut self) -> Result<(), InputError> {
        let (mut found, mut buffer) = (Vec::new(), std::mem::take(&mut self.buffer));
        match &mut self.format {
            Format::Pcapng(reader) => {
                reader.push(&buffer);
                buffer.clear();
                let result = packets(reader, self.ended, &mut found);
                found.drain(..).for_each(|chunk| self.add(chunk, 1));
                if let Err(damage) = result {
                    self.stop(damage.into());
                }
            }
            Format::Pcap(reader) => {
                let mut entries: Vec<Entry> = Vec::new();
                reader.push(&buffer);
                buffer.clear();
                let result = reader.read(&mut entries).and_then(|()| if self.ended { reader.end() } else { Ok(()) });
                entries.into_iter().for_each(|entry| self.add(entry.into(), 1));
                match result.map_err(Damage::from) {
                    Err(damage) if self.is_empty => return Err(damage.into()),
                    Err(damage) => self.stop(damage),
                    Ok(()) => {}
                }
            }
            Format::Trace(reader) => {
                let result = entries(reader, &mut buffer, self.ended, &mut found).map_err(Damage::from);
                found.drain(..).for_each(|chunk| self.add(chunk, 1));
                match result {
                    Err(damage) if self.is_empty => return Err(damage.into()),
                    Err(damage) => {
                        self.stop(damage);
                        buffer.clear();
                    }
                    Ok(()) => {}
                }
            }
            Format::Octets => {
                let octets = std::mem::take(&mut buffer);
                self.add(Chunk { octets, is_continued: true, ..Chunk::default() }, 1);
            }
            Format::Text(_) => self.decode_lines(&mut buffer)?,
        }
        self.buffer = buffer;
        Ok(())
    }

    /// Ends the file at the damage.
    fn stop(&mut self, damage: Damage) {
        (self.damage, self.ended) = (Some(damage), true);
    }

    /// Decodes the complete lines in the buffer.
    fn decode_lines(&mut self, buffer: &mut Vec<u8>) -> Result<(), InputError> {
        let Format::Text(reader) = &mut self.format else { return Ok(()) };
        let (mut from, mut found) = (0, Found::default());
        while let Some((to, is_whole)) = buffer.get(from..).and_then(|rest| end_of_line(rest, self.ended)) {
            let line = buffer.get(from..from.saturating_add(to)).unwrap_or_default();
            reader.read(&String::from_utf8_lossy(line), is_whole, &mut found);
            from = from.saturating_add(to);
        }
        buffer.drain(..from);
        if self.ended {
            reader.end(&mut found);
        }
        let first = reader.ignored().kinds().map(|(_, text)| (text.first_line, text.first_text.clone())).min();
        for Row { seconds, octets, errors, is_continued, times } in found.rows {
            let start = seconds.map(|seconds| bit_time(seconds, CLOCK));
            self.add(Chunk { start, octets, errors, is_continued }, times);
        }
        self.left_over.append(&mut found.left_over);
        if self.ended && self.is_empty {
            let left_over = self.left_over.first().map(|text| (text.line, text.text.clone()));
            let found = first.or(left_over);
            return Err(found.map_or(InputError::Empty, |(line, found)| InputError::NoOctets { line, found }));
        }
        Ok(())
    }
}

impl LongChunk {
    /// The next octets, at most [`CHUNK_OCTETS`].
    fn next(&mut self, times: TimeSource) -> Chunk {
        let (from, whole) = (self.done, &self.chunk);
        if from == 0 && whole.octets.len() <= CHUNK_OCTETS {
            self.times = self.times.saturating_sub(1);
            return if self.times == 0 { std::mem::take(&mut self.chunk) } else { whole.clone() };
        }
        let to = from.saturating_add(CHUNK_OCTETS).min(whole.octets.len());
        let is_last = to == whole.octets.len();
        let passed = match times {
            TimeSource::Exact => (from as u64).saturating_mul(CHARACTER_TBIT),
            TimeSource::Platform => 0,
        };
        let errors = whole.errors.iter().filter(|error| (from..to).contains(error));
        let chunk = Chunk {
            start: whole.start.map(|start| start + passed),
            octets: whole.octets.get(from..to).unwrap_or_default().to_vec(),
            errors: errors.map(|error| error.saturating_sub(from)).collect(),
            is_continued: !is_last || whole.is_continued,
        };
        self.done = if is_last { 0 } else { to };
        self.times = self.times.saturating_sub(u64::from(is_last));
        chunk
    }
}

/// A packet as a chunk. A time that the writer of the file has invented is none.
fn chunk_of(packet: pcapng::Packet) -> Chunk {
    let chunk = Chunk::from(packet.entry);
    match packet.times {
        Times::Measured => chunk,
        Times::Invented => Chunk { start: None, ..chunk },
    }
}

/// Decodes the complete packets.
fn packets(reader: &mut pcapng::Reader, is_last: bool, chunks: &mut Vec<Chunk>) -> Result<(), CaptureError> {
    while let Some(packet) = reader.next() {
        chunks.push(chunk_of(packet?));
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

/// Position after the first line or part of a line, if it is complete, and whether the line ends there. A line that is too long is
/// split between words, or else behind a sign between octets.
fn end_of_line(text: &[u8], is_last: bool) -> Option<(usize, bool)> {
    let portion = text.get(..PORTION_OCTETS).unwrap_or(text);
    if let Some(end) = portion.iter().position(|octet| *octet == b'\n') {
        return Some((end.saturating_add(1), true));
    }
    if text.len() < PORTION_OCTETS {
        return (is_last && !text.is_empty()).then_some((text.len(), true));
    }
    let from = portion.len().saturating_sub(SPLIT_OCTETS);
    let end = portion.get(from..).unwrap_or_default();
    let behind = |found: Option<usize>| found.map(|at| from.saturating_add(at).saturating_add(1));
    let word = behind(end.iter().rposition(u8::is_ascii_whitespace));
    let escape = || end.iter().rposition(|octet| *octet == b'\\').map(|at| from.saturating_add(at));
    let sign = || behind(end.iter().rposition(|octet| b",;:-_.|".contains(octet)));
    let to = word.or_else(escape).or_else(sign).filter(|to| *to > 0).unwrap_or(PORTION_OCTETS);
    Some((to, false))
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
            assert_eq!((source.kind, &chunks, source.ignored()), (whole.kind, &whole.chunks, whole.ignored));
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
        let begin = capture.len() - 40;
        for (head, again) in [(&capture[..begin], &capture[begin..]), (head.as_bytes(), line.as_bytes())] {
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
