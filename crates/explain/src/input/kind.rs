//! The kind of a file: what its first octets show.

use super::InputError;
use crate::text::{Found, Reader};
use profivac_sim::trace::pcap;

/// Kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceKind {
    /// A capture file.
    Pcapng,
    /// A capture file of the older format.
    Pcap,
    /// A trace of profivac.
    Trace,
    /// Text with octets in hexadecimal.
    Text,
    /// The octets of the line, and nothing else.
    Octets,
}

impl SourceKind {
    /// The name in the JSON output.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pcapng => "pcapng",
            Self::Pcap => "pcap",
            Self::Trace => "trace",
            Self::Text => "text",
            Self::Octets => "octets",
        }
    }
}

const PCAPNG: [u8; 4] = [0x0A, 0x0D, 0x0D, 0x0A];

/// Mark that some programs write before UTF-8 text.
pub(super) const BYTE_ORDER_MARK: &[u8] = "\u{FEFF}".as_bytes();

/// Number of octets after which unprintable ones show that a file is no text. chosen: long enough for a letter of an old
/// character set, shorter than the first telegrams of a line.
const LEAST_OCTETS: usize = 16;

/// Number of letters after which a file is a text: other notations have no hexadecimal octets. chosen: no line has as many octets without
/// one that no text has.
const LEAST_LETTERS: usize = 64;

/// Number of octets that are enough to decide in any case.
pub(super) const MOST_OCTETS: usize = 1 << 16;

/// Finds the kind of a file from its first octets. The result does not depend on the portions in which they come.
#[derive(Clone, Debug, Default)]
pub(super) struct KindFinder {
    /// The number of octets that are examined.
    at: usize,
    /// Octets that no text has.
    strange: usize,
    /// The number of octets that the present letter of UTF-8 still needs.
    letter: u8,
    /// The first octet of the present line.
    line: usize,
}

impl KindFinder {
    /// The kind, or `None` if more octets are needed. `ended` says whether these are all.
    ///
    /// # Errors
    /// [`InputError`] for a format that cannot be read.
    pub(super) fn kind(&mut self, octets: &[u8], ended: bool) -> Result<Option<SourceKind>, InputError> {
        if octets.len() < PCAPNG.len() && !ended {
            return Ok(None);
        }
        if octets.starts_with(&PCAPNG) {
            return Ok(Some(SourceKind::Pcapng));
        }
        if pcap::Reader::is_begun_by(octets) {
            return Ok(Some(SourceKind::Pcap));
        }
        while let Some(octet) = octets.get(self.at) {
            self.at = self.at.saturating_add(1);
            self.strange = self.strange.saturating_add(usize::from(self.is_strange(*octet)));
            if let Some(kind) = self.kind_here(octets, *octet)? {
                return Ok(Some(kind));
            }
        }
        if ended {
            return self.kind_of_all(octets).map(Some);
        }
        Ok(None)
    }

    /// Whether an octet is a control character, or shows that a letter of UTF-8 is none. E5 and the like are frequent on a line.
    const fn is_strange(&mut self, octet: u8) -> bool {
        let was_letter = self.letter > 0;
        self.letter = match octet {
            0x80..=0xBF if was_letter => {
                self.letter = self.letter.saturating_sub(1);
                return false;
            }
            0xC2..=0xDF => 1,
            0xE0..=0xEF => 2,
            0xF0..=0xF4 => 3,
            _ => 0,
        };
        let is_control = octet.is_ascii_control() && !octet.is_ascii_whitespace() && octet != 0x1B;
        was_letter || is_control || matches!(octet, 0x80..=0xC1 | 0xF5..)
    }

    /// The kind that the octets up to `at` show.
    fn kind_here(&mut self, octets: &[u8], octet: u8) -> Result<Option<SourceKind>, InputError> {
        let seen = octets.get(..self.at).unwrap_or_default();
        if self.at == LEAST_OCTETS && is_utf16(seen) {
            return Err(InputError::Utf16);
        }
        if self.at >= LEAST_OCTETS && self.is_mostly_strange() {
            return Ok(Some(SourceKind::Octets));
        }
        if octet == b'\n' || self.at == MOST_OCTETS {
            let is_first = self.line == 0;
            let line = octets.get(std::mem::replace(&mut self.line, self.at)..self.at).unwrap_or_default();
            if is_first && is_trace(line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line)) {
                return Ok(Some(SourceKind::Trace));
            }
            if self.at == MOST_OCTETS {
                return Ok(Some(SourceKind::Text));
            }
            let is_text = has_octets(line) || (self.strange == 0 && self.at >= LEAST_LETTERS);
            return Ok((is_text && !self.is_mostly_strange()).then_some(SourceKind::Text));
        }
        Ok(None)
    }

    /// The kind of a file that ends here.
    fn kind_of_all(&mut self, octets: &[u8]) -> Result<SourceKind, InputError> {
        if is_utf16(octets) {
            return Err(InputError::Utf16);
        }
        if self.is_mostly_strange() {
            return Ok(SourceKind::Octets);
        }
        let is_first = self.line == 0;
        let line = octets.get(self.line..).unwrap_or_default();
        let is_trace = is_first && is_trace(line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line));
        Ok(if is_trace { SourceKind::Trace } else { SourceKind::Text })
    }

    /// Whether more than one octet in ten is in no text.
    const fn is_mostly_strange(&self) -> bool {
        self.strange.saturating_mul(10) > self.at
    }
}

/// Whether a line has octets in hexadecimal.
fn has_octets(line: &[u8]) -> bool {
    let (mut reader, mut found) = (Reader::default(), Found::default());
    reader.read(&String::from_utf8_lossy(line), true, &mut found);
    reader.end(&mut found);
    !found.rows.is_empty()
}

/// Whether the first line is that of a trace: `# 500 kbit/s`.
fn is_trace(first: &[u8]) -> bool {
    first.starts_with(b"# ") && first.trim_ascii_end().ends_with(b"bit/s")
}

/// Whether the octets are UTF-16: a byte order mark, and zero in more than nine of ten high octets.
fn is_utf16(text: &[u8]) -> bool {
    let zeros = |odd: usize| text.iter().skip(2 + odd).step_by(2).filter(|octet| **octet == 0).count();
    let letters = text.len().saturating_sub(2) / 2;
    let most = |zeros: usize| letters > 0 && zeros.saturating_mul(10) > letters.saturating_mul(9);
    (text.starts_with(&[0xFF, 0xFE]) && most(zeros(1))) || (text.starts_with(&[0xFE, 0xFF]) && most(zeros(0)))
}
