//! Traces as text.

use super::{Entry, Trace};
use crate::describe::octet;
use profivac_dp::link::{Baud, BitTime};
use std::fmt::{self, Write as _};
use std::str::FromStr;

/// The width of the column of descriptions, so that the octets are aligned.
const WORDS_WIDTH: usize = 76;

/// One line, with the end of the previous telegram.
pub(crate) struct Line<'a>(pub(crate) Option<BitTime>, pub(crate) &'a Entry);

impl fmt::Display for Line<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(before, entry) = self;
        let gap = before.map(|end| format!("+{}", entry.start - end)).unwrap_or_default();
        write!(f, "{:>10} {gap:>6}  {:WORDS_WIDTH$} |", entry.start.0, entry.to_string())?;
        for (index, octet) in entry.octets.iter().enumerate() {
            write!(f, " {octet:02X}{}", if entry.errors.contains(&index) { "!" } else { "" })?;
        }
        f.write_char('\n')
    }
}

impl fmt::Display for Trace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "# {}", self.baud)?;
        let mut before = None;
        for entry in &self.entries {
            Line(before, entry).fmt(f)?;
            before = Some(entry.end());
        }
        Ok(())
    }
}

/// Error of a line that is not a line of a trace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TraceError {
    /// Its number, counted from 1.
    pub number: usize,
    /// The expected part.
    pub expected: Expected,
    /// The text instead.
    pub received: String,
}

/// A part of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Expected {
    /// The first line: the baud rate.
    Baud,
    /// The first column: a bit time.
    BitTime,
    /// The last column: octets after `|`.
    Octets,
    /// An octet of two hexadecimal digits.
    Digits,
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Baud => "a transmission rate, as in '# 1.5 Mbit/s'",
            Self::BitTime => "a bit time",
            Self::Octets => "octets after '|'",
            Self::Digits => "two hexadecimal digits",
        })
    }
}

impl fmt::Display for TraceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: expected {}, found '{}'", self.number, self.expected, self.received)
    }
}

impl std::error::Error for TraceError {}

/// Reads a trace line by line.
#[derive(Clone, Debug)]
pub struct Reader {
    baud: Baud,
    number: usize,
}

impl Reader {
    /// Begins with the first line, which contains the baud rate.
    ///
    /// # Errors
    /// [`TraceError`] if it does not.
    pub fn begin(first: &str) -> Result<Self, TraceError> {
        let number = 1;
        match first.strip_prefix("# ").and_then(rate) {
            Some(baud) => Ok(Self { baud, number }),
            None => Err(bad(number, (Expected::Baud, first))),
        }
    }

    /// The baud rate of the line.
    #[must_use]
    pub const fn baud(&self) -> Baud {
        self.baud
    }

    /// Parses the next line. An empty line or a comment gives `None`.
    ///
    /// # Errors
    /// [`TraceError`] if it is not a line of a trace.
    pub fn line(&mut self, line: &str) -> Result<Option<Entry>, TraceError> {
        self.number += 1;
        if line.is_empty() || line.starts_with('#') {
            return Ok(None);
        }
        entry(line).map(Some).map_err(|wrong| bad(self.number, wrong))
    }
}

/// The longest text of a line in a message, in characters.
const SHOWN: usize = 60;

fn bad(number: usize, (expected, received): (Expected, &str)) -> TraceError {
    TraceError { number, expected, received: received.chars().take(SHOWN).collect() }
}

impl FromStr for Trace {
    type Err = TraceError;

    /// Parses the text that [`Display`](fmt::Display) writes. Empty lines and further comments are skipped.
    fn from_str(text: &str) -> Result<Self, TraceError> {
        let mut lines = text.lines();
        let mut reader = Reader::begin(lines.next().unwrap_or_default())?;
        let mut trace = Self { baud: reader.baud(), entries: Default::default() };
        for line in lines {
            trace.entries.extend(reader.line(line)?);
        }
        Ok(trace)
    }
}

fn rate(text: &str) -> Option<Baud> {
    Baud::ALL.into_iter().find(|baud| baud.to_string() == text.trim())
}

/// Parses an entry. The error has the expected part and the text instead.
fn entry(line: &str) -> Result<Entry, (Expected, &str)> {
    let time = line.split_whitespace().next().unwrap_or_default();
    let start = time.parse().map(BitTime).map_err(|_| (Expected::BitTime, time))?;
    let Some((_, octets)) = line.rsplit_once('|') else { return Err((Expected::Octets, line)) };
    let (mut read, mut errors) = (Vec::new(), Vec::new());
    for text in octets.split_whitespace() {
        let digits = text.strip_suffix('!').unwrap_or(text);
        if digits != text {
            errors.push(read.len());
        }
        read.push(octet(digits).ok_or((Expected::Digits, text))?);
    }
    Ok(Entry::new(start, read, errors))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\
# 1.5 Mbit/s
      1000           2 -> 8    FDL_Status ?                                                 | 10 08 02 49 53 16
      1077    +11    8 -> 2    OK, passive station                                          | 10 02 08 00 0A 16
      1180    +37  damaged: character error in octet 2, 4                                     | 10 08! 02 49! 53 16
      1300    +54  damaged: the check octet is 54, the sum is 53                              | 10 08 02 49 54 16
      2000   +634              SC                                                             | E5
";

    /// The text without the alignment.
    fn squeezed(text: &str) -> String {
        text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ") + "\n").collect()
    }

    #[test]
    fn a_trace_is_read_and_written() {
        let trace: Trace = TEXT.parse().unwrap();
        assert_eq!(trace.entries.len(), 5);
        assert_eq!(trace.entries[2].errors, [1, 3]);
        assert_eq!(squeezed(&trace.to_string()), squeezed(TEXT));
        assert_eq!(trace.to_string().parse(), Ok(trace));
    }

    #[test]
    fn a_bad_line_is_named() {
        for (text, message) in [
            ("", "line 1: expected a transmission rate, as in '# 1.5 Mbit/s', found ''"),
            ("# 1.6 Mbit/s", "line 1: expected a transmission rate, as in '# 1.5 Mbit/s', found '# 1.6 Mbit/s'"),
            ("# 12 Mbit/s\n\nsoon | E5", "line 3: expected a bit time, found 'soon'"),
            ("# 12 Mbit/s\n5 E5", "line 2: expected octets after '|', found '5 E5'"),
            ("# 12 Mbit/s\n5 | E5 5", "line 2: expected two hexadecimal digits, found '5'"),
            ("# 12 Mbit/s\n5 | +5", "line 2: expected two hexadecimal digits, found '+5'"),
        ] {
            assert_eq!(text.parse::<Trace>().unwrap_err().to_string(), message);
        }
    }
}
