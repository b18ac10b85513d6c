//! Reads octets from the text that programs print: hexadecimal in many notations, with times, arrows and words around it.
//!
//! | Text | Example |
//! |---|---|
//! | plain | `68 05 05 68 88 82 6D 3C 3E F1 16`, also with single digits, commas, `0x`, `h`, `\x` |
//! | joined | `680505688882`, `68:05:05:68`, `68-05-05-68`, in lines of any length |
//! | dumps | `xxd`, `hexdump`, `od` with any address column, words of 16 bits, letters (`od -c`), and omitted lines (`*`) |
//! | logs | `PHY-serial: TX   10 08 02 49 53 16`, `12:00:00.5 2 -> 8 ; SRD ; 68 05 ...` |
//!
//! | one octet a line | `uart-1: 10`, `0-1100 UART: RX data: 10`, a table of Saleae Logic |
//! | numbers | `TX [16, 8, 2, 73, 83, 22]`, `[-27]`, `16;8;2;73;83;22`, `00010000 00001000` |
//! | strings | `b'\x10\x08\x02IS\x16'`, `write(3, "\20\10\2IS\26", 6) = 6` |
//!
//! The first telegram with a check octet shows the notation: the one counts in which such telegrams have the most octets.
//!
//! Octets do not get lost: each word that may be octets is in a [`Row`] or in a [`LeftOver`], and all other text is counted in
//! [`Ignored`]. The layout of the text decides what a column is, never a telegram beside it:
//!
//! * An address column grows from line to line by the number of octets. A first word that may be octets waits for the next line.
//! * Characters behind octets are a column if they are those of the octets.
//! * Numbers in front of octets are no octets if in each line they count the lines or the octets, and if no telegram is lost without them.
//!   A line that begins behind them continues the line before.
//! * In a line with words, the column with the longest row counts, and rows of three octets and more. A shorter row counts behind TX,
//!   RX, an arrow, or the words behind which other lines have longer rows.
//! * A line of octets alone, in one column or several, is read whole. An unreadable word between octets (`??`, `0G`, `08!`) is
//!   an octet with an error.

mod columns;
mod decimal;
mod dump;
mod dump_lines;
mod escapes;
mod ignored;
mod letters;
mod log;
mod radix;
mod rows;
mod single;
#[cfg(test)]
mod tests;
mod word;

pub use dump_lines::OMITTED;
pub use ignored::{Ignored, IgnoredKind, IgnoredText};
pub(crate) use log::Log;
pub use log::{Notation, StatedNotation};

use super::frame::{Chunk, Framer, PieceKind};
use dump::DumpLine;
use dump_lines::Addresses;
use ignored::shortened;
use profivac_wire::Telegram;
use rows::{MIN_OCTETS, Rows, plain_octets};
use std::borrow::Cow;
use std::cmp::Ordering;
use std::collections::VecDeque;
use word::{Commas, Meaning, Octets, Word, column_between_commas, pairs, words};

/// Octets that belong together in a text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The time before them in seconds, if the line has one.
    pub seconds: Option<f64>,
    /// The octets.
    pub octets: Vec<u8>,
    /// Positions of the octets that are unreadable or marked with `!`, counted from 0.
    pub errors: Vec<usize>,
    /// The next row continues this one.
    pub is_continued: bool,
    /// How often a dump has this row in succession.
    pub times: u64,
}

/// Text that may be octets and is not in a row: beside a row, too short, or without a second digit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOver {
    /// Number of the line, counted from 1.
    pub line: usize,
    /// The text.
    pub text: String,
    /// The number of octets. A single digit counts as one.
    pub octets: usize,
}

/// The octets of a text, and the text that may be octets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// The octets.
    pub rows: VecDeque<Row>,
    /// Text that may be octets and is in no row.
    pub left_over: Vec<LeftOver>,
}

/// Reads octets line by line, and keeps what is known about the layout.
#[derive(Clone, Debug, Default)]
pub struct Reader {
    line: usize,
    ignored: Ignored,
    addresses: Addresses,
    /// The last row of a dump, which the next line may repeat or shorten.
    last_row: Option<Row>,
    /// A line of a dump behind omitted ones, and its number.
    waiting: Option<(usize, DumpLine)>,
    /// The dump omits equal lines here.
    is_omitting: bool,
    /// The number of octets in the omitted lines that were repeated.
    repeated: u64,
    /// The words before rows of octets.
    prefixes: VecDeque<String>,
    commas: Commas,
    /// State within a line that comes in parts.
    part: Part,
    /// A line without an address has had octets.
    has_rows: bool,
    /// The present line ends with a line end.
    has_more_lines: bool,
    /// The time of a line without octets, and its number: it is the time of the octets in the next line.
    header: Option<(usize, f64)>,
}

/// State between the parts of a line.
#[derive(Clone, Debug, Default)]
struct Part {
    /// The line has begun with another part.
    is_inner: bool,
    /// The last part has ended within a word of digits.
    is_in_word: bool,
    /// The last part has ended with a row.
    is_in_row: bool,
    /// A first digit whose second one is in the next part.
    digit: Option<char>,
}

/// The most words before rows of octets that are kept. chosen.
const MAX_PREFIXES: usize = 16;

/// The least number of digits of a word that may begin within an octet, and the number of octets that are searched for telegrams to find
/// out. chosen.
const MIN_ALIGNED: usize = 12;
const MAX_ALIGNED: usize = 2048;

impl Reader {
    /// A reader of a text of which `ignored` was read already.
    fn new(ignored: &Ignored, commas: Commas) -> Self {
        Self { ignored: ignored.clone(), commas, ..Self::default() }
    }

    /// The number of lines so far.
    #[must_use]
    pub const fn lines(&self) -> usize {
        self.line
    }

    /// The text that is not octets.
    #[must_use]
    pub const fn ignored(&self) -> &Ignored {
        &self.ignored
    }

    /// Reads a line, or the part of a line that is too long. `is_last` says whether the line ends here.
    pub fn read(&mut self, text: &str, is_last: bool, found: &mut Found) {
        let is_inner = self.part.is_inner;
        self.has_more_lines = text.ends_with('\n');
        if !is_inner {
            self.line = self.line.saturating_add(1);
        }
        if is_inner || !is_last {
            self.flush(found);
            self.read_part(text, is_last, found);
            return;
        }
        let text = text.trim_end_matches(['\r', '\n']);
        if text.trim().is_empty() {
            return;
        }
        // Most lines of most texts are plain octets, and reading them as words takes several times as long.
        if !matches!(self.addresses, Addresses::Undecided { .. })
            && let Some(octets) = plain_octets(text)
        {
            self.read_plain(octets, found);
            return;
        }
        if self.read_dump(text, found) {
            return;
        }
        self.read_line(text, found);
    }

    /// Ends the text.
    pub fn end(&mut self, found: &mut Found) {
        self.flush(found);
        if std::mem::take(&mut self.is_omitting) {
            // No address says how many lines were omitted.
            found.left_over.push(LeftOver { line: self.line, text: OMITTED.to_owned(), octets: 0 });
        }
    }

    /// Reads what waits for the next line.
    fn flush(&mut self, found: &mut Found) {
        match std::mem::take(&mut self.addresses) {
            Addresses::Undecided { number, line, .. } if line.is_likely() => self.begin_dump(&line, number, found),
            Addresses::Undecided { number, line, text } => self.refute(number, line, &text, found),
            decided => self.addresses = decided,
        }
        self.read_waiting(found);
        self.emit_last_row(found);
    }

    /// Reads the line that has no address after all.
    fn refute(&mut self, number: usize, line: DumpLine, text: &str, found: &mut Found) {
        let present = std::mem::replace(&mut self.line, number);
        self.read_line(text, found);
        self.line = present;
        self.addresses = Addresses::Refuted(line);
    }

    fn emit_last_row(&mut self, found: &mut Found) {
        found.rows.extend(self.last_row.take().filter(|row| !row.octets.is_empty()));
    }

    /// Reports text behind the octets of a dump.
    fn leave_over_or_ignore(&mut self, text: &str, line: usize, found: &mut Found) {
        let octets: usize =
            words(text, self.commas, &|digits, _| pairs(digits, 0)).iter().map(|word| word.octet_count()).sum();
        if octets > 0 {
            found.left_over.push(LeftOver { line, text: shortened(text), octets });
        } else {
            self.ignored.add(IgnoredKind::Words, line, text);
        }
    }

    /// Reads a line of plain octets, as [`read_line`](Self::read_line) does: it has no prefix, and all its octets are one row.
    fn read_plain(&mut self, octets: Vec<u8>, found: &mut Found) {
        self.read_waiting(found);
        self.emit_last_row(found);
        if octets.len() >= MIN_OCTETS {
            self.learn_prefix(String::new());
        }
        self.has_rows = true;
        let mut row = Row { octets, times: 1, ..Row::default() };
        self.take_header(&mut row);
        found.rows.push_back(row);
    }

    /// Gives octets without a time the one of the line before: socat and jpnevulator print it so.
    fn take_header(&mut self, row: &mut Row) {
        if row.octets.is_empty() {
            return;
        }
        let header = self.header.take().filter(|(line, _)| line.saturating_add(1) == self.line);
        row.seconds = row.seconds.or(header.map(|(_, seconds)| seconds));
    }

    /// Keeps the words before a long row.
    fn learn_prefix(&mut self, prefix: String) {
        if self.prefixes.contains(&prefix) {
            return;
        }
        self.prefixes.push_back(prefix);
        if self.prefixes.len() > MAX_PREFIXES {
            self.prefixes.pop_front();
        }
    }

    /// Reads a line without an address.
    fn read_line(&mut self, text: &str, found: &mut Found) {
        self.read_waiting(found);
        self.emit_last_row(found);
        let text = self.without_comment(text);
        let text = &*text;
        let characters = dump::characters_at_end(text);
        let text = characters.as_ref().map_or(text, |(front, _)| front);
        if self.commas == Commas::Octets {
            self.commas = column_between_commas(text).map_or(Commas::Octets, Commas::Columns);
        }
        let words = words(text, self.commas, &|digits, is_first| self.aligned(digits, is_first));
        if words.is_empty() {
            return;
        }
        if text.trim() == OMITTED && self.has_rows {
            // Without addresses nothing says how many lines a dump omits.
            found.left_over.push(LeftOver { line: self.line, text: OMITTED.to_owned(), octets: 0 });
            return;
        }
        let mut rows = Rows::of(&words);
        rows.select(&words, |prefix| self.prefixes.iter().any(|known| known == prefix));
        if let Some((_, characters)) = &characters {
            self.ignored.add(IgnoredKind::Characters, self.line, characters);
        }
        if let Some(prefix) = rows.prefix_of_long(&words) {
            self.learn_prefix(prefix);
        }
        self.emit(&words, &rows, false, found);
    }

    /// The text before a comment, and with a space in place of each comment of C.
    fn without_comment<'a>(&mut self, text: &'a str) -> Cow<'a, str> {
        let (mut clean, mut rest) = (String::new(), text);
        while let Some((from, to)) = inner_comment(rest) {
            self.ignored.add(IgnoredKind::Comment, self.line, rest.get(from..to).unwrap_or_default());
            clean += rest.get(..from).unwrap_or_default();
            clean.push(' ');
            rest = rest.get(to..).unwrap_or_default();
        }
        let text = if clean.is_empty() { Cow::Borrowed(text) } else { Cow::Owned(clean + rest) };
        let Some(at) = comment(&text) else { return text };
        self.ignored.add(IgnoredKind::Comment, self.line, text.get(at..).unwrap_or_default());
        Cow::Owned(text.get(..at).unwrap_or_default().to_owned())
    }

    /// Reads a part of a line. All its columns count, because the whole line is not known.
    fn read_part(&mut self, text: &str, is_last: bool, found: &mut Found) {
        let joined: String = self.part.digit.take().into_iter().chain(text.chars()).collect();
        let mut text = joined.as_str();
        let digits = text.len().saturating_sub(text.trim_end_matches(|letter: char| letter.is_ascii_hexdigit()).len());
        let word = text.get(text.len().saturating_sub(digits)..).unwrap_or_default();
        let is_first = digits == text.len();
        if !is_last && digits >= MIN_ALIGNED && (digits.saturating_sub(self.skipped(word, is_first))) % 2 == 1 {
            self.part.digit = text.chars().next_back();
            text = text.get(..text.len().saturating_sub(1)).unwrap_or_default();
        }
        let words = words(text, self.commas, &|digits, is_first| self.aligned(digits, is_first));
        let mut rows = Rows::of(&words);
        rows.select_parts(&words, self.part.is_in_row, !is_last);
        self.emit(&words, &rows, !is_last, found);
        let is_in_row = rows.ends_with_row(&words);
        self.part = if is_last {
            Part::default()
        } else {
            Part { is_inner: true, is_in_word: digits > 0, is_in_row, digit: self.part.digit }
        };
    }

    /// Emits the selected rows, and reports everything else.
    fn emit(&mut self, words: &[Word<'_>], rows: &Rows, is_continued: bool, found: &mut Found) {
        let (mut row, mut ignored, mut left_over) =
            (Row { is_continued, times: 1, ..Row::default() }, Vec::new(), Vec::new());
        for (word, is_taken) in words.iter().zip(&rows.is_taken) {
            match &word.meaning {
                Meaning::Time(seconds) if row.seconds.is_none() => row.seconds = Some(*seconds),
                meaning if *is_taken => {
                    row.add(meaning);
                    if let Meaning::Octets(Octets { halves, .. }) = meaning {
                        left_over.extend(halves.chars().map(|digit| (digit.to_string(), 1)));
                    }
                }
                _ if word.octet_count() > 0 => left_over.push((shortened(word.text), word.octet_count())),
                _ => ignored.push(word.text),
            }
        }
        let line = self.line;
        self.take_header(&mut row);
        let (is_empty, has_left_over, seconds) = (row.octets.is_empty(), !left_over.is_empty(), row.seconds);
        found.left_over.extend(joined(left_over).into_iter().map(|(text, octets)| LeftOver { line, text, octets }));
        if !is_empty {
            self.has_rows = true;
            found.rows.push_back(row);
        }
        if is_empty && !has_left_over {
            self.header = seconds.map(|seconds| (line, seconds));
            let texts: Vec<&str> = words.iter().map(|word| word.text).collect();
            self.ignored.add(IgnoredKind::Line, line, &texts.join(" "));
        } else if !ignored.is_empty() {
            self.ignored.add(IgnoredKind::Words, line, &ignored.join(" "));
        }
    }

    /// The octets of a word of digits. A long one may begin within an octet: the first word of a text that was cut, and a word with
    /// an odd number of digits.
    fn aligned(&self, digits: &str, is_first: bool) -> Octets {
        pairs(digits, self.skipped(digits, is_first))
    }

    /// The number of digits before the first octet of a word: 0 or 1.
    fn skipped(&self, digits: &str, is_first: bool) -> usize {
        let is_continued = is_first && self.part.is_in_word;
        let may_be_cut = digits.len() % 2 == 1 || (is_first && self.line == 1);
        if is_continued || !may_be_cut {
            return 0;
        }
        // The first line of a text that was cut begins within an octet, the last one ends within one.
        let begins_cut = is_first && self.line == 1 && self.has_more_lines && digits.len() % 2 == 1;
        if digits.len() < MIN_ALIGNED {
            return usize::from(begins_cut);
        }
        let checked = |skip| checked_octets(&pairs(digits.get(..2 * MAX_ALIGNED).unwrap_or(digits), skip).octets);
        match checked(1).cmp(&checked(0)) {
            Ordering::Greater => 1,
            Ordering::Equal => usize::from(begins_cut),
            Ordering::Less => 0,
        }
    }
}

/// The number of octets in telegrams with a check octet.
fn checked_octets(octets: &[u8]) -> usize {
    let is_checked = |octets: &&Vec<u8>| matches!(Telegram::parse(octets), Ok(Telegram::Data(_)));
    valid_telegrams(octets).iter().filter(is_checked).map(Vec::len).sum()
}

/// Whether the octets have a token.
fn has_token(octets: &[u8]) -> bool {
    valid_telegrams(octets).iter().any(|octets| matches!(Telegram::parse(octets), Ok(Telegram::Token { .. })))
}

fn valid_telegrams(octets: &[u8]) -> Vec<Vec<u8>> {
    let (mut framer, mut pieces) = (Framer::default(), Vec::new());
    framer.push(&Chunk { octets: octets.to_vec(), ..Chunk::default() }, &mut pieces);
    framer.flush(&mut pieces);
    let valid = pieces.into_iter().filter(|piece| piece.kind == PieceKind::Valid);
    valid.map(|piece| piece.octets).collect()
}

/// Joins left-over words that follow each other into one text.
fn joined(words: Vec<(String, usize)>) -> Option<(String, usize)> {
    let octets = words.iter().map(|(_, octets)| octets).sum();
    let texts: Vec<String> = words.into_iter().map(|(text, _)| text).collect();
    (!texts.is_empty()).then(|| (shortened(&texts.join(" ")), octets))
}

/// The begin and the end of a comment of C that begins a word.
fn inner_comment(text: &str) -> Option<(usize, usize)> {
    let (from, _) = text.match_indices("/*").find(|(at, _)| begins_word(text, *at))?;
    let behind = text.get(from.saturating_add(2)..)?;
    // Characters of octets in a comment may be its end: the last one counts if no further comment begins before it.
    let until = behind.get(2..).and_then(|rest| rest.find("/*")).map_or(behind.len(), |at| at.saturating_add(2));
    let end = behind.get(..until).and_then(|comment| comment.rfind("*/"));
    let length = end.or_else(|| behind.find("*/")).map_or(behind.len(), |at| at.saturating_add(2));
    Some((from, from.saturating_add(2).saturating_add(length)))
}

fn begins_word(text: &str, at: usize) -> bool {
    text.get(..at).is_some_and(|front| front.is_empty() || front.ends_with(char::is_whitespace))
}

/// The position of a comment: `#` without a number behind it, or `//`, at the begin of a word.
fn comment(text: &str) -> Option<usize> {
    let marks = text.match_indices('#').filter(|(at, _)| {
        let next = text.get(at.saturating_add(1)..).and_then(|rest| rest.chars().next());
        !next.is_some_and(|letter| letter.is_ascii_digit())
    });
    marks.chain(text.match_indices("//")).map(|(at, _)| at).filter(|at| begins_word(text, *at)).min()
}
