//! Input files: a capture file, a trace, text with hexadecimal octets, or binary octets.

mod kind;
mod source;

pub use kind::SourceKind;
pub use source::Source;

pub use super::frame::Chunk;
use super::frame::TimeSource;
pub use super::text::{Ignored, IgnoredKind, IgnoredText, LeftOver, Notation, StatedNotation};
use profivac_dp::link::Baud;
use profivac_sim::trace::pcapng::CaptureError;
use profivac_sim::trace::{Entry, TraceError};
use std::io::ErrorKind;

/// Contents of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// Kind of the file.
    pub kind: SourceKind,
    /// Transmission rate of the line, if the file has one.
    pub baud: Option<Baud>,
    /// The rate whose bit times the times of the chunks are.
    pub clock: Baud,
    /// Source of its times.
    pub times: TimeSource,
    /// The octets.
    pub chunks: Vec<Chunk>,
    /// The number of octets in the chunks.
    pub octets: u64,
    /// Text that may be octets and is in no chunk.
    pub left_over: Vec<LeftOver>,
    /// The text that is not octets.
    pub ignored: Ignored,
    /// Damage that ends a capture file or a trace early.
    pub damage: Option<Damage>,
}

/// Damage that ends a file early. Everything before it is read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Damage {
    /// A damaged capture file.
    #[error(transparent)]
    Capture(#[from] CaptureError),
    /// A damaged trace.
    #[error(transparent)]
    Trace(#[from] TraceError),
}

/// Error of a file without anything that can be decoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// A capture file or a trace that is damaged before its first octets.
    #[error(transparent)]
    Damaged(#[from] Damage),
    /// Text in UTF-16.
    #[error("expected text in UTF-8, found UTF-16: convert it with 'iconv -f UTF-16 -t UTF-8'")]
    Utf16,
    /// Text without octets.
    #[error("line {line}: expected octets in hexadecimal, as in '68 05 05 68 88 82 6D 3C 3E F1 16', found '{found}'")]
    NoOctets {
        /// Number of the first line that is not empty, counted from 1.
        line: usize,
        /// Beginning of that line.
        found: String,
    },
    /// An empty file.
    #[error("expected telegrams, found an empty file")]
    Empty,
    /// The operating system cannot read it.
    #[error("cannot be read: {message}")]
    Unreadable {
        /// Kind of the error.
        kind: ErrorKind,
        /// Message of the operating system.
        message: String,
    },
}

impl Capture {
    /// Reads a whole file. `baud` is the rate of the line if the file has none: it turns numbers of samples into times.
    ///
    /// # Errors
    /// [`InputError`] if the file has nothing that can be decoded.
    pub fn read(file: &[u8], baud: Baud) -> Result<Self, InputError> {
        let (mut source, mut chunks) = (Source::open(file, baud)?, Vec::new());
        while source.read(&mut chunks)? {}
        let ignored = source.ignored();
        let clock = source.clock();
        let Source { kind, line_baud: baud, times, octets, left_over, damage, .. } = source;
        Ok(Self { kind, baud, clock, times, chunks, octets, left_over, ignored, damage })
    }
}

impl From<Entry> for Chunk {
    fn from(entry: Entry) -> Self {
        Self { start: Some(entry.start), octets: entry.octets.to_vec(), errors: entry.errors, is_continued: false }
    }
}

#[cfg(test)]
mod tests {
    use super::kind::BYTE_ORDER_MARK;
    use super::*;
    use profivac_dp::link::BitTime;
    use profivac_sim::Trace;
    use profivac_sim::dialogue::hex;
    use profivac_sim::trace::pcapng;

    fn read(file: &[u8]) -> Result<Capture, String> {
        Capture::read(file, Baud::B19200).map_err(|error| error.to_string())
    }

    #[test]
    fn the_content_of_a_file_shows_its_kind() {
        let trace: Trace = "# 500 kbit/s\n 100  x | 10 08 02 49 53 16\n 200 | E5! 00\n".parse().unwrap();
        for (file, kind) in [
            (trace.to_string().into_bytes(), SourceKind::Trace),
            (pcapng::write(&trace, pcapng::USER0), SourceKind::Pcapng),
            (pcapng::write(&trace, pcapng::PROFIBUS_DL), SourceKind::Pcapng),
        ] {
            let capture = read(&file).unwrap();
            assert_eq!((capture.kind, capture.baud, capture.chunks.len()), (kind, Some(Baud::B500000), 2));
            assert_eq!((capture.chunks[1].start, &capture.chunks[1].errors[..]), (Some(BitTime(200)), &[0][..]));
        }
        let capture = read(b"RX 10 08 02 49 53 16\nwaiting\n0.5 E5").unwrap();
        let ignored: Vec<_> = capture.ignored.kinds().map(|(kind, text)| (kind, text.first_line)).collect();
        assert_eq!(ignored, [(IgnoredKind::Line, 2), (IgnoredKind::Words, 1)]);
        assert_eq!(read(b"RX E5\n0.5 E5").unwrap().chunks[1].start, Some(BitTime(6_000_000)));
        assert_eq!(read(&hex("10 08 02 49 53 16 10 02 08 00 0A 16")).unwrap().kind, SourceKind::Octets);
        assert_eq!(read(b"\xB5s 10 08 02 49 53 16\n").unwrap().kind, SourceKind::Text, "one letter is not UTF-8");
    }

    #[test]
    fn the_error_of_a_file_that_cannot_be_decoded_names_the_line() {
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
                "the file ends within the block at octet 0: it was cut off, or is still being written",
            ),
            (&[0x0A, 0x0D, 0x0D, 0x0A, 0, 0], "expected a pcapng file, found no section header"),
        ] {
            assert_eq!(read(file).unwrap_err(), message);
        }
    }

    #[test]
    fn a_text_may_begin_with_a_byte_order_mark_but_may_not_be_utf_16() {
        let mark = |text: &str| [BYTE_ORDER_MARK, text.as_bytes()].concat();
        assert_eq!(read(&mark("# 500 kbit/s\r\n200 | E5\r\n")).unwrap().kind, SourceKind::Trace);
        assert_eq!(read(&mark("RX E5")).unwrap().chunks.len(), 1);
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
