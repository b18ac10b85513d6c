//! What can be decoded: a capture file, a trace, printed octets, or octets as they are.

use super::frame::Times;
use super::printed::Reader;
use profivac_dp::link::{Baud, BitTime};
use profivac_sim::Trace;
use profivac_sim::trace::BadLine;
use profivac_sim::trace::pcapng::{self, BadCapture};

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
    /// Lines without octets, counted from 1.
    pub skipped: Vec<usize>,
    /// Why there is no more of a capture file.
    pub damage: Option<BadCapture>,
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
}

const PCAPNG: [u8; 4] = [0x0A, 0x0D, 0x0D, 0x0A];
/// Microseconds and nanoseconds, in both orders of octets.
const PCAP: [[u8; 4]; 4] =
    [[0xA1, 0xB2, 0xC3, 0xD4], [0xD4, 0xC3, 0xB2, 0xA1], [0xA1, 0xB2, 0x3C, 0x4D], [0x4D, 0x3C, 0xB2, 0xA1]];

/// How much of a line a message shows.
const SHOWN: usize = 60;

impl Recording {
    /// Reads a file of any kind. Times in seconds become bit times of `baud`, unless the file has a rate.
    ///
    /// # Errors
    /// [`BadInput`] in one sentence.
    pub fn read(file: &[u8], baud: Baud) -> Result<Self, BadInput> {
        if file.is_empty() {
            return Err(BadInput::Empty);
        }
        if file.starts_with(&PCAPNG) {
            return Self::captured(file, baud);
        }
        if PCAP.iter().any(|magic| file.starts_with(magic)) {
            return Err(BadInput::Pcap);
        }
        match std::str::from_utf8(file) {
            Ok(text) if is_trace(text) => text.parse().map(|trace| Self::of("trace", trace)).map_err(BadInput::Trace),
            Ok(text) if !text.contains('\0') => Self::printed(text, baud),
            // Programs print what they like; only what is full of other characters is not printed at all.
            _ if is_binary(file) => Ok(Self::raw(file)),
            _ => Self::printed(&String::from_utf8_lossy(file), baud),
        }
    }

    fn of(kind: &'static str, trace: Trace) -> Self {
        let baud = Some(trace.baud);
        let noted = trace.entries.into_iter().map(|entry| Noted {
            start: Some(entry.start),
            octets: entry.octets.to_vec(),
            errors: entry.errors,
        });
        Self { kind, baud, times: Times::Exact, noted: noted.collect(), skipped: Vec::new(), damage: None }
    }

    /// What a capture file holds before it is damaged, if that is anything.
    fn captured(file: &[u8], baud: Baud) -> Result<Self, BadInput> {
        match pcapng::read_until_damage(file, baud) {
            (trace, Some(damage)) if trace.entries.is_empty() => Err(BadInput::Capture(damage)),
            (trace, damage) => Ok(Self { damage, ..Self::of("pcapng", trace) }),
        }
    }

    fn raw(file: &[u8]) -> Self {
        let noted = vec![Noted { start: None, octets: file.to_vec(), errors: Vec::new() }];
        Self { kind: "octets", baud: None, times: Times::Exact, noted, skipped: Vec::new(), damage: None }
    }

    fn printed(text: &str, baud: Baud) -> Result<Self, BadInput> {
        let (mut reader, mut noted, mut skipped) = (Reader::default(), Vec::new(), Vec::new());
        for (line, number) in text.lines().zip(1..) {
            match reader.line(line) {
                Some(printed) => noted.push(Noted {
                    start: printed.seconds.map(|seconds| bit_time(seconds, baud)),
                    octets: printed.octets,
                    errors: printed.errors,
                }),
                None if line.trim().is_empty() => {}
                None => skipped.push(number),
            }
        }
        if noted.is_empty() {
            let first = text.lines().zip(1..).find(|(line, _)| !line.trim().is_empty());
            let Some((line, number)) = first else { return Err(BadInput::Empty) };
            return Err(BadInput::NoOctets { line: number, found: line.trim().chars().take(SHOWN).collect() });
        }
        Ok(Self { kind: "text", baud: None, times: Times::Platform, noted, skipped, damage: None })
    }
}

/// A trace says its rate first.
fn is_trace(text: &str) -> bool {
    text.lines().next().is_some_and(|line| line.starts_with("# ") && line.trim_end().ends_with("bit/s"))
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
        assert_eq!(read(b"RX 10 08 02 49 53 16\nwaiting\n0.5 E5").unwrap().skipped, [2]);
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
}
