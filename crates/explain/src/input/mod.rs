//! What can be decoded: a capture file, a trace, printed octets, or octets as they are.

mod source;

pub use source::Source;

use super::frame::TimeSource;
use profivac_dp::link::{Baud, BitTime};
use profivac_sim::trace::pcapng::CaptureError;
use profivac_sim::trace::{Entry, TraceError};

/// Octets that were noted together.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk {
    /// When the first began, if that was noted too.
    pub start: Option<BitTime>,
    /// The octets.
    pub octets: Vec<u8>,
    /// The numbers of those with an error, counted from 0.
    pub errors: Vec<usize>,
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// What kind of file it is.
    pub kind: &'static str,
    /// The rate of the line, if the file tells it.
    pub baud: Option<Baud>,
    /// What its times are worth.
    pub times: TimeSource,
    /// The octets.
    pub chunks: Vec<Chunk>,
    /// Lines without octets.
    pub skipped: Skipped,
    /// Why there is no more of a capture file or a trace.
    pub damage: Option<Damage>,
}

/// Lines without octets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Skipped {
    /// How many.
    pub count: usize,
    /// The number of the first, counted from 1.
    pub first: Option<usize>,
}

/// What ends a file before its end. What comes before it is noted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Damage {
    /// Of a capture file.
    #[error(transparent)]
    Capture(#[from] CaptureError),
    /// Of a trace.
    #[error(transparent)]
    Trace(#[from] TraceError),
}

/// Why nothing can be decoded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InputError {
    /// The capture file or the trace is damaged before there is anything to tell.
    #[error(transparent)]
    Damaged(#[from] Damage),
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
    Unreadable(String),
}

impl Capture {
    /// Reads a file of any kind as a whole. Times in seconds become bit times of `baud`, unless the file has a rate.
    ///
    /// # Errors
    /// [`BadInput`] in one sentence.
    pub fn read(file: &[u8], baud: Baud) -> Result<Self, InputError> {
        let (mut source, mut noted) = (Source::open(file, baud)?, Vec::new());
        while source.read(&mut noted)? {}
        let Source { kind, line_baud: baud, times, skipped, damage, .. } = source;
        Ok(Self { kind, baud, times, chunks: noted, skipped, damage })
    }
}

impl From<Entry> for Chunk {
    fn from(entry: Entry) -> Self {
        Self { start: Some(entry.start), octets: entry.octets.to_vec(), errors: entry.errors }
    }
}

#[cfg(test)]
mod tests {
    use super::source::BYTE_ORDER_MARK;
    use super::*;
    use profivac_sim::Trace;
    use profivac_sim::scenario::hex;
    use profivac_sim::trace::pcapng;

    fn read(file: &[u8]) -> Result<Capture, String> {
        Capture::read(file, Baud::B19200).map_err(|error| error.to_string())
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
            assert_eq!((recording.kind, recording.baud, recording.chunks.len()), (kind, Some(Baud::B500000), 2));
            assert_eq!((recording.chunks[1].start, &recording.chunks[1].errors[..]), (Some(BitTime(200)), &[0][..]));
        }
        let skipped = Skipped { count: 1, first: Some(2) };
        assert_eq!(read(b"RX 10 08 02 49 53 16\nwaiting\n0.5 E5").unwrap().skipped, skipped);
        assert_eq!(read(b"RX E5\n0.5 E5").unwrap().chunks[1].start, Some(BitTime(9600)));
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

    #[test]
    fn a_text_may_begin_with_a_mark_but_not_have_two_octets_a_letter() {
        let mark = |text: &str| [BYTE_ORDER_MARK, text.as_bytes()].concat();
        assert_eq!(read(&mark("# 500 kbit/s\r\n200 | E5\r\n")).unwrap().kind, "trace");
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
