//! A file: its text and its model.

use crate::device::Device;
use crate::encoding::{Encoding, octets_of};
use crate::lexer::{HEADER, Lexer};
use crate::problem::{Fault, Problem, Severity};
use crate::reader::Reader;
use crate::statement::Statement;
use std::borrow::Cow;
use std::ops::Range;

/// A GSD file that was read: its text, its device and its problems.
///
/// Reading refuses no file. A line that cannot be interpreted is a problem, stays in the text and in
/// [`Device::others`](crate::Device::others).
#[derive(Clone, Debug)]
pub struct GsdFile {
    encoding: Encoding,
    text: String,
    lines: Vec<(usize, Range<usize>)>,
    device: Device,
    problems: Vec<Problem>,
}

impl GsdFile {
    /// Reads a file.
    ///
    /// ```
    /// use profivac_gsd::GsdFile;
    ///
    /// let file = GsdFile::read(b"#Profibus_DP\r\nIdent_Number = 0x1234\r\nModule = \"2 octets in\" 0x11\r\nEndModule\r\n");
    /// assert!(file.problems().is_empty(), "{:?}", file.problems());
    /// assert_eq!(file.device().general.ident_number, Some(0x1234));
    /// assert_eq!(file.device().modules[0].config, [0x11]);
    /// ```
    #[must_use]
    pub fn read(octets: &[u8]) -> Self {
        Self::read_counted(octets).0
    }

    /// Reads a file and counts the octets that the reader looked at, to prove that its work is linear.
    pub(crate) fn read_counted(octets: &[u8]) -> (Self, usize) {
        let encoding = Encoding::detect(octets);
        let text = encoding.decode(octets);
        let mut lexer = Lexer::new(&text);
        let mut reader = Reader::default();
        let mut lines = Vec::new();
        while let Some(line) = lexer.next_line() {
            lines.push((line.number, line.span.clone()));
            if let Some(statement) = Statement::new(&line, &text) {
                reader.statement(&statement);
            }
        }
        let (problems, steps) = (std::mem::take(&mut lexer.problems), lexer.steps);
        let (device, mut problems) = reader.finish(problems);
        // It stands in front of the first line, whichever section that belongs to.
        if let Some(fault) = fault_of(encoding, octets, &text) {
            problems.insert(0, Problem::new(1, fault, ""));
        }
        (Self { encoding, text, lines, device, problems }, steps)
    }

    /// The code page of the file.
    #[must_use]
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// The text of the file.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The logical lines: the number of the first physical line, from 1, and the text with comments, continuations and end of line.
    /// Together they are the text.
    pub fn lines(&self) -> impl Iterator<Item = (usize, &str)> {
        self.lines.iter().map(|(number, span)| (*number, self.text.get(span.clone()).unwrap_or_default()))
    }

    /// The octets of the file, as they were read.
    #[must_use]
    pub fn octets(&self) -> Cow<'_, [u8]> {
        octets_of(self.encoding, &self.text)
    }

    /// The device that the file describes.
    #[must_use]
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The device, without the text.
    #[must_use]
    pub fn into_device(self) -> Device {
        self.device
    }

    /// The problems, by line.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// The problems where a line is wrong; the others are lines that a known tool does not read.
    pub fn faults(&self) -> impl Iterator<Item = &Problem> {
        self.problems.iter().filter(|problem| problem.severity() == Severity::Fault)
    }
}

/// What a tool that expects one octet for each character makes of the beginning of the text.
fn fault_of(encoding: Encoding, octets: &[u8], text: &str) -> Option<Fault> {
    let starts_with_header = || text.get(..HEADER.len()).is_some_and(|start| start.eq_ignore_ascii_case(HEADER));
    match encoding {
        Encoding::Utf8Bom if starts_with_header() => Some(Fault::MarkBeforeHeader),
        _ if encoding.is_utf16() => Some(Fault::Utf16),
        // What follows the byte order mark is not all UTF-16.
        _ if octets.starts_with(b"\xFF\xFE") || octets.starts_with(b"\xFE\xFF") => Some(Fault::DamagedUtf16),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(octets: &[u8]) -> usize {
        GsdFile::read_counted(octets).1
    }

    /// Each pattern would cost the square of its length if a mark, a continuation or a comment were searched again and again.
    #[test]
    fn the_work_grows_with_the_length_of_the_file() {
        let patterns: [&str; 16] = [
            "\"",
            "\"\"\\",
            "\"a\"\\ ",
            "\"a",
            "\"1,2 ",
            "a\"b\\\n",
            "\"\n",
            "\\\n",
            "\\;\n",
            "0,\n",
            "0,\\\n",
            ";\\\n",
            "x=\"\\\n",
            "(",
            "a =",
            "Module=\"a\" 1\n",
        ];
        for pattern in patterns {
            for start in ["", "x=\"", "x=0,\\\n", "x=1 "] {
                let file = |times: usize| steps(format!("{start}{}", pattern.repeat(times)).as_bytes());
                let (short, long) = (file(500), file(2000));
                assert!(
                    long <= short * 4 + 400,
                    "{start:?} and {pattern:?}: {short} steps, {long} for four times the length"
                );
            }
        }
    }
}
