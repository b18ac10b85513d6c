//! Reads octets from the text that programs print: hexadecimal in many notations, with times, arrows and words around it.
//!
//! | Text | Example |
//! |---|---|
//! | plain | `68 05 05 68 88 82 6D 3C 3E F1 16`, also with single digits, commas, `0x`, `h`, `\x` |
//! | joined | `680505688882`, `68:05:05:68`, `68-05-05-68`, in lines of any length |
//! | dumps | `xxd`, `hexdump`, `od` with any address column, words of 16 bits, and omitted lines (`*`) |
//! | logs | `PHY-serial: TX   10 08 02 49 53 16`, `12:00:00.5 2 -> 8 ; SRD ; 68 05 ...` |
//!
//! Octets do not get lost: each word that may be octets is in a [`Row`] or in a [`LeftOver`], and all other text is counted in
//! [`Ignored`]. The layout of the text decides what a column is, never a telegram beside it:
//!
//! * An address column grows from line to line by the number of octets. A first word that may be octets waits for the next line.
//! * Characters behind octets are a column if they are those of the octets.
//! * In a line with words, the column with the longest row counts, and rows of three octets and more. A shorter row counts behind TX,
//!   RX, an arrow, or the words behind which other lines have longer rows.
//! * A line of octets alone, in one column or several, is read whole. An unreadable word between octets (`??`, `0G`, `08!`) is
//!   an octet with an error.

mod dump;
mod word;

use super::frame::{Chunk, Framer, PieceKind};
use dump::{Column, DumpLine, Step};
use profivac_wire::Telegram;
use std::cmp::Ordering;
use std::collections::VecDeque;
use word::{Meaning, Octets, Word, pairs, words};

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

/// Kind of text that is not octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum IgnoredKind {
    /// A line without octets.
    Line,
    /// Words beside octets.
    Words,
    /// A comment.
    Comment,
    /// The address of a line of a dump.
    Address,
    /// The octets of a dump as characters.
    Characters,
    /// The mark at the begin of UTF-8 text.
    ByteOrderMark,
}

/// Lines with text that is not octets, by its kind.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ignored(std::collections::BTreeMap<IgnoredKind, IgnoredText>);

/// Lines with ignored text of one kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IgnoredText {
    /// Their number.
    pub lines: usize,
    /// Number of the first line, counted from 1.
    pub first_line: usize,
    /// The text in the first line, at most 60 characters.
    pub first_text: String,
    last_line: usize,
}

impl Ignored {
    /// The kinds that occurred.
    pub fn kinds(&self) -> impl Iterator<Item = (IgnoredKind, &IgnoredText)> {
        self.0.iter().map(|(kind, text)| (*kind, text))
    }

    pub(crate) fn add(&mut self, kind: IgnoredKind, line: usize, text: &str) {
        let new = || IgnoredText { lines: 0, first_line: line, last_line: 0, first_text: shortened(text) };
        let ignored = self.0.entry(kind).or_insert_with(new);
        ignored.lines = ignored.lines.saturating_add(usize::from(ignored.last_line != line));
        ignored.last_line = line;
    }
}

/// Number of characters of a line that a message shows.
const SHOWN: usize = 60;

fn shortened(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(SHOWN).collect()
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
    /// State within a line that comes in parts.
    part: Part,
    /// A line without an address has had octets.
    has_rows: bool,
    /// The present line ends with a line end.
    has_more_lines: bool,
}

/// State of the search for an address column.
#[derive(Clone, Debug, Default)]
enum Addresses {
    /// No line has had an address.
    #[default]
    None,
    /// This line may have one: the next line decides.
    Undecided { number: usize, line: DumpLine, text: String },
    /// First words of this form are octets.
    Refuted(DumpLine),
    /// The text is a dump.
    Column(Column),
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

/// The line with which od and hexdump replace lines that are equal to the one before.
pub const OMITTED: &str = "*";

/// The most octets of a text in the lines that a dump omits. An address of a few digits can stand for any number of octets, so what
/// is more stays left over: the work for a text then grows with its length. free choice.
const MAX_REPEATED: u64 = 1 << 20;

/// The least number of octets in a line with other words: `cafe` and `be` are words.
const MIN_OCTETS: usize = 3;

/// The most words before rows of octets that are kept. free choice.
const MAX_PREFIXES: usize = 16;

/// The least number of digits of a word that may begin within an octet, and the number of octets that are searched for telegrams to find
/// out. free choice.
const MIN_ALIGNED: usize = 12;
const MAX_ALIGNED: usize = 2048;

impl Reader {
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

    /// Counts text that is not octets, in front of the first line.
    pub(crate) fn ignore(&mut self, kind: IgnoredKind, text: &str) {
        self.ignored.add(kind, 1, text);
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

    /// Reads a line of a dump. Returns false for another line.
    fn read_dump(&mut self, text: &str, found: &mut Found) -> bool {
        let number = self.line;
        if text.trim() == OMITTED && matches!(self.addresses, Addresses::Undecided { .. } | Addresses::Column(_)) {
            let undecided = std::mem::take(&mut self.addresses);
            match undecided {
                Addresses::Undecided { number, line, text } if line.has_groups_like_address() => {
                    self.refute(number, line, &text, found);
                }
                Addresses::Undecided { number, line, .. } => self.begin_dump(&line, number, found),
                decided => self.addresses = decided,
            }
            self.read_waiting(found);
            self.is_omitting = true;
            return true;
        }
        let line = DumpLine::of(text);
        let undecided = std::mem::take(&mut self.addresses);
        if let Addresses::Undecided { number, line: first, text } = undecided {
            if line.as_ref().is_some_and(|line| Column::new(&first).is_confirmed_by(line)) {
                self.begin_dump(&first, number, found);
            } else {
                self.refute(number, first, &text, found);
            }
        } else {
            self.addresses = undecided;
        }
        let Some(line) = line else { return false };
        match &self.addresses {
            Addresses::Column(column) if column.has(&line) => self.continue_dump(&line, found),
            _ if line.is_certain() => {
                self.flush(found);
                self.begin_dump(&line, number, found);
            }
            Addresses::Refuted(refuted) if refuted.is_like(&line) => return false,
            Addresses::Column(_) if line.octets.is_empty() || line.has_groups_like_address() => return false,
            _ if !line.octets.is_empty() => {
                self.read_waiting(found);
                self.emit_last_row(found);
                self.addresses = Addresses::Undecided { number, line, text: text.to_owned() };
            }
            _ => return false,
        }
        true
    }

    /// Reads the first line of a dump.
    fn begin_dump(&mut self, line: &DumpLine, number: usize, found: &mut Found) {
        self.addresses = Addresses::Column(Column::new(line));
        self.take_dump_row(line, number, found);
    }

    /// Reads the next line of a dump. A line behind omitted ones waits for the next one, if its address alone does not show how many
    /// were omitted.
    fn continue_dump(&mut self, line: &DumpLine, found: &mut Found) {
        if let (Some((_, waiting)), Addresses::Column(column)) = (&self.waiting, &mut self.addresses) {
            column.narrow(waiting, line);
        }
        self.read_waiting(found);
        match &self.addresses {
            Addresses::Column(column) if self.is_omitting && column.gap(line).is_none() => {
                (self.waiting, self.is_omitting) = (Some((self.line, line.clone())), false);
            }
            _ => self.read_dump_line(line, self.line, found),
        }
    }

    /// Reads the line that waits for the next one.
    fn read_waiting(&mut self, found: &mut Found) {
        if let Some((number, line)) = self.waiting.take() {
            let is_omitting = std::mem::replace(&mut self.is_omitting, true);
            self.read_dump_line(&line, number, found);
            self.is_omitting = is_omitting;
        }
    }

    fn read_dump_line(&mut self, line: &DumpLine, number: usize, found: &mut Found) {
        let Addresses::Column(column) = &mut self.addresses else { return };
        let (step, gap) = (column.step(line), column.gap(line));
        column.advance(line);
        match (step, std::mem::take(&mut self.is_omitting)) {
            (Step::Next | Step::Restart, false) => {}
            (_, true) => self.repeat_last_row(gap, number.saturating_sub(1), found),
            (Step::Padded(count), false) => {
                if let Some(row) = &mut self.last_row {
                    let length = row.octets.len() as u64;
                    row.octets.truncate(usize::try_from(length.saturating_sub(count)).unwrap_or_default());
                }
            }
            (Step::Other, false) => {
                let text = line.address.digits.clone();
                let octets = text.len().div_ceil(2);
                found.left_over.push(LeftOver { line: number, text, octets });
            }
        }
        self.take_dump_row(line, number, found);
    }

    /// Repeats the last row for the lines that the dump omits, if they have not too many octets.
    fn repeat_last_row(&mut self, gap: Option<u64>, line: usize, found: &mut Found) {
        let length = self.last_row.as_ref().map_or(0, |row| row.octets.len() as u64);
        let repeated = gap.map(|gap| (gap, self.repeated.saturating_add(gap)));
        let repeated = repeated.filter(|(_, repeated)| *repeated <= MAX_REPEATED);
        match (&mut self.last_row, repeated.and_then(|(gap, sum)| Some((gap.checked_div(length)?, sum)))) {
            (Some(row), Some((times, sum))) => {
                row.times = row.times.saturating_add(times);
                self.repeated = sum;
            }
            _ => found.left_over.push(LeftOver { line, text: OMITTED.to_owned(), octets: 0 }),
        }
    }

    fn take_dump_row(&mut self, line: &DumpLine, number: usize, found: &mut Found) {
        self.emit_last_row(found);
        self.ignored.add(IgnoredKind::Address, number, &line.address.digits);
        if let Some(characters) = &line.characters {
            self.ignored.add(IgnoredKind::Characters, number, characters);
        }
        self.last_row = Some(Row { octets: line.octets.clone(), is_continued: true, times: 1, ..Row::default() });
        let rest = line.rest.trim();
        if !rest.is_empty() {
            self.leave_over_or_ignore(rest, number, found);
        }
    }

    /// Reports text behind the octets of a dump.
    fn leave_over_or_ignore(&mut self, text: &str, line: usize, found: &mut Found) {
        let octets: usize = words(text, &|digits, _| pairs(digits, 0)).iter().map(|word| word.octet_count()).sum();
        if octets > 0 {
            found.left_over.push(LeftOver { line, text: shortened(text), octets });
        } else {
            self.ignored.add(IgnoredKind::Words, line, text);
        }
    }

    /// Reads a line without an address.
    fn read_line(&mut self, text: &str, found: &mut Found) {
        self.read_waiting(found);
        self.emit_last_row(found);
        let text = self.without_comment(text);
        let characters = dump::characters_at_end(text);
        let text = characters.as_ref().map_or(text, |(front, _)| front);
        let words = words(text, &|digits, is_first| self.aligned(digits, is_first));
        if words.is_empty() {
            return;
        }
        if text.trim() == OMITTED && self.has_rows {
            // Without addresses nothing says how many lines a dump omits.
            found.left_over.push(LeftOver { line: self.line, text: OMITTED.to_owned(), octets: 0 });
            return;
        }
        let mut rows = Rows::of(&words);
        let prefix = rows.prefix(&words);
        let is_known = self.prefixes.contains(&prefix);
        rows.select(&words, is_known);
        if let Some((_, characters)) = &characters {
            self.ignored.add(IgnoredKind::Characters, self.line, characters);
        }
        if rows.is_long() && !is_known {
            self.prefixes.push_back(prefix);
            if self.prefixes.len() > MAX_PREFIXES {
                self.prefixes.pop_front();
            }
        }
        self.emit(&words, &rows, false, found);
    }

    /// The text before a comment.
    fn without_comment<'a>(&mut self, text: &'a str) -> &'a str {
        let Some(at) = comment(text) else { return text };
        let (front, comment) = text.split_at(at);
        self.ignored.add(IgnoredKind::Comment, self.line, comment);
        front
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
        let words = words(text, &|digits, is_first| self.aligned(digits, is_first));
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
        let (is_empty, has_left_over) = (row.octets.is_empty(), !left_over.is_empty());
        found.left_over.extend(joined(left_over).into_iter().map(|(text, octets)| LeftOver { line, text, octets }));
        if !is_empty {
            self.has_rows = true;
            found.rows.push_back(row);
        }
        if is_empty && !has_left_over {
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
    let (mut framer, mut pieces) = (Framer::default(), Vec::new());
    framer.push(&Chunk { octets: octets.to_vec(), ..Chunk::default() }, &mut pieces);
    framer.flush(&mut pieces);
    let valid = pieces.iter().filter(|piece| piece.kind == PieceKind::Valid);
    let is_checked = |octets: &&Vec<u8>| matches!(Telegram::parse(octets), Ok(Telegram::Data(_)));
    valid.map(|piece| &piece.octets).filter(is_checked).map(Vec::len).sum()
}

/// Joins left-over words that follow each other into one text.
fn joined(words: Vec<(String, usize)>) -> Option<(String, usize)> {
    let octets = words.iter().map(|(_, octets)| octets).sum();
    let texts: Vec<String> = words.into_iter().map(|(text, _)| text).collect();
    (!texts.is_empty()).then(|| (shortened(&texts.join(" ")), octets))
}

/// The position of a comment: `#` without a number behind it, or `//`, at the begin of a word.
fn comment(text: &str) -> Option<usize> {
    let is_begin =
        |at: usize| text.get(..at).is_some_and(|front| front.is_empty() || front.ends_with(char::is_whitespace));
    let marks = text.match_indices('#').filter(|(at, _)| {
        let next = text.get(at.saturating_add(1)..).and_then(|rest| rest.chars().next());
        !next.is_some_and(|letter| letter.is_ascii_digit())
    });
    marks.chain(text.match_indices("//")).map(|(at, _)| at).filter(|at| is_begin(*at)).min()
}

impl Row {
    fn add(&mut self, meaning: &Meaning) {
        match meaning {
            Meaning::Octets(octets) => self.octets.extend(&octets.octets),
            Meaning::Digit(octet) => self.octets.push(*octet),
            Meaning::Unreadable(octet) => {
                self.errors.push(self.octets.len());
                self.octets.push(*octet);
            }
            Meaning::Time(_) | Meaning::Strange(_) | Meaning::Other => {}
        }
    }
}

/// The rows of octets of a line, and which words belong to the selected ones.
struct Rows {
    rows: Vec<std::ops::Range<usize>>,
    is_taken: Vec<bool>,
    /// Octets of each row.
    lengths: Vec<usize>,
}

impl Rows {
    /// Divides the words of a line into rows. A row has at least one word of two digits; numbers of one digit at its ends belong to
    /// it unless the line writes octets with leading zeros.
    fn of(words: &[Word<'_>]) -> Self {
        let is_padded = words.iter().any(|word| matches!(&word.meaning, Meaning::Octets(octets) if octets.is_padded));
        let (mut rows, mut from) = (Vec::new(), 0);
        for to in 0..=words.len() {
            let continues =
                words.get(from..to).and_then(|row| row.last()).zip(words.get(to)).is_some_and(|(last, next)| {
                    last.is_octet()
                        && next.is_octet()
                        && (last.column, last.in_brackets) == (next.column, next.in_brackets)
                });
            if continues || from == to {
                continue;
            }
            rows.extend(trimmed(words, from..to, is_padded));
            from = to;
        }
        let lengths = rows.iter().map(|row| octets_in(words.get(row.clone()).unwrap_or_default())).collect();
        Self { rows, is_taken: vec![false; words.len()], lengths }
    }

    /// The words before the first row, without numbers.
    fn prefix(&self, words: &[Word<'_>]) -> String {
        let end = self.rows.first().map_or(0, |row| row.start);
        let others = words.iter().take(end).filter(|word| word.meaning == Meaning::Other);
        others.map(|word| word.text).collect::<Vec<_>>().join(" ")
    }

    /// Selects the rows of a whole line.
    fn select(&mut self, words: &[Word<'_>], is_known_prefix: bool) {
        let outside = words.iter().any(|word| word.is_octet() && !word.in_brackets);
        let is_text = |word: &Word<'_>| word.meaning == Meaning::Other && !(outside && word.in_brackets);
        let has_words = words.iter().any(is_text);
        let time = words.iter().position(|word| matches!(word.meaning, Meaning::Time(_))).unwrap_or(0);
        let is_outside = |row: &std::ops::Range<usize>| words.get(row.start).is_some_and(|word| !word.in_brackets);
        let brackets_count = !self.rows.iter().any(is_outside);
        let longest = self.rows.iter().zip(&self.lengths).max_by_key(|(_, length)| **length);
        let best = longest.and_then(|(row, _)| words.get(row.start)).map(|word| word.column);
        let is_single = self.lengths.iter().all(|length| *length == 1);
        let is_marked = self.rows.first().and_then(|row| words.get(row.start)).is_some_and(|word| word.is_marked);
        let begins_row = is_known_prefix || is_marked;
        for (number, (row, length)) in self.rows.iter().zip(&self.lengths).enumerate() {
            let Some(first) = words.get(row.start) else { continue };
            let in_column = !has_words || is_single || Some(first.column) == best;
            let is_sc = words.get(row.clone()).is_some_and(is_short_ack);
            let is_first_known = begins_row && (number == 0 || is_single);
            let is_row_of_columns = is_single && self.rows.len() >= MIN_OCTETS;
            let is_long =
                *length >= MIN_OCTETS && words.get(row.clone()).is_some_and(|row| row.iter().any(Word::is_number));
            let is_certain = is_sc || first.is_marked || is_first_known || first.has_notation();
            let is_enough = !has_words || is_row_of_columns || is_long || is_certain;
            if in_column && is_enough && row.start >= time && (brackets_count || !first.in_brackets) {
                self.is_taken.iter_mut().take(row.end).skip(row.start).for_each(|taken| *taken = true);
            }
        }
    }

    /// Selects the rows of a part of a line. A row may have begun in the part before, and may continue in the next one.
    fn select_parts(&mut self, words: &[Word<'_>], continues_row: bool, is_continued: bool) {
        let has_words = words.iter().any(|word| matches!(word.meaning, Meaning::Other));
        for (row, length) in self.rows.iter().zip(&self.lengths) {
            let touches = (continues_row && row.start == 0) || (is_continued && row.end == words.len());
            let is_sc = words.get(row.clone()).is_some_and(is_short_ack);
            let is_marked = words.get(row.start).is_some_and(|word| word.is_marked);
            if !has_words || *length >= MIN_OCTETS || touches || is_sc || is_marked {
                self.is_taken.iter_mut().take(row.end).skip(row.start).for_each(|taken| *taken = true);
            }
        }
    }

    /// Whether the selected rows show that such lines have octets.
    fn is_long(&self) -> bool {
        let is_taken = |row: &std::ops::Range<usize>| self.is_taken.get(row.start) == Some(&true);
        let taken = self.rows.iter().zip(&self.lengths).filter(|(row, _)| is_taken(row));
        taken.map(|(_, length)| length).sum::<usize>() >= MIN_OCTETS
    }

    fn ends_with_row(&self, words: &[Word<'_>]) -> bool {
        !words.is_empty() && self.is_taken.last() == Some(&true)
    }
}

/// Whether a row is an SC alone.
fn is_short_ack(row: &[Word<'_>]) -> bool {
    matches!(row, [Word { meaning: Meaning::Octets(octets), .. }] if octets.octets == [0xE5])
}

fn octets_in(row: &[Word<'_>]) -> usize {
    let count = |word: &Word<'_>| if let Meaning::Octets(octets) = &word.meaning { octets.octets.len() } else { 1 };
    row.iter().map(count).sum()
}

/// A row without unreadable words before its first octet, and without numbers at its ends if the line is padded; `None` if no
/// word is certainly an octet.
fn trimmed(words: &[Word<'_>], row: std::ops::Range<usize>, is_padded: bool) -> Option<std::ops::Range<usize>> {
    let part = words.get(row.clone())?;
    let is_certain = |word: &Word<'_>| matches!(word.meaning, Meaning::Octets(_));
    let begins = |word: &Word<'_>| match word.meaning {
        Meaning::Octets(_) => true,
        Meaning::Digit(_) => !is_padded,
        Meaning::Unreadable(octet) => octet != 0,
        Meaning::Time(_) | Meaning::Strange(_) | Meaning::Other => false,
    };
    let ends = |word: &Word<'_>| !(is_padded && matches!(word.meaning, Meaning::Digit(_)));
    let (first, last) = (part.iter().position(begins)?, part.iter().rposition(ends)?);
    let range = row.start.saturating_add(first)..row.start.saturating_add(last).saturating_add(1);
    words.get(range.clone())?.iter().any(is_certain).then_some(range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_sim::describe::Hex;

    const DIAG: &str = "68 05 05 68 88 82 6D 3C 3E F1 16";

    fn read(text: &str) -> Vec<String> {
        rows(text).0.iter().map(|row| Hex(&row.octets).to_string()).collect()
    }

    fn rows(text: &str) -> (Vec<Row>, Vec<LeftOver>, Ignored) {
        let (mut reader, mut found) = (Reader::default(), Found::default());
        text.lines().for_each(|line| reader.read(line, true, &mut found));
        reader.end(&mut found);
        (found.rows.into(), found.left_over, reader.ignored)
    }

    #[test]
    fn the_reader_understands_a_telegram_in_every_notation() {
        for line in [
            "68 05 05 68 88 82 6D 3C 3E F1 16",
            "68 5 5 68 88 82 6d 3c 3e f1 16",
            "0x68, 0x05, 0x05, 0x68, 0x88, 0x82, 0x6d, 0x3c, 0x3e, 0xf1, 0x16,",
            "{0x68,0x5,0x5,0x68,0x88,0x82,0x6d,0x3c,0x3e,0xf1,0x16}",
            "68h 05h 05h 68h 88h 82h 6Dh 3Ch 3Eh F1h 16h",
            "$68 $05 $05 $68 $88 $82 $6D $3C $3E $F1 $16",
            r#"b"\x68\x05\x05\x68\x88\x82\x6d\x3c\x3e\xf1\x16""#,
            "68:05:05:68:88:82:6D:3C:3E:F1:16",
            "68-05-05-68-88-82-6D-3C-3E-F1-16",
            "680505688882 6D3C3EF116",
            "PHY-serial: TX   68 05 05 68 88 82 6D 3C 3E F1 16",
            "RX (fragment)   68 05 05 68 88 82 6D 3C 3E F1 16",
            "-> 68 05 05 68 88 82 6D 3C 3E F1 16 (11 octets)",
            "<< 68 05 05 68 88 82 6D 3C 3E F1 16 ",
            "17;12:00:00.123456;2;8;SRD_HIGH;68 05 05 68 88 82 6D 3C 3E F1 16;Slave_Diag",
            "2 -> 8  Slave_Diag req | 68 05 05 68 88 82 6D 3C 3E F1 16",
            "[  3.25] 68 05 05 68 88 82 6D 3C 3E F1 16",
            "00000000: 6805 0568 8882 6d3c 3ef1 16              h..h..m<>..",
            "00000000  68 05 05 68 88 82 6d 3c  3e f1 16                 |h..h..m<>..|",
            "0000000 0568 6805 8288 3c6d f13e 0016\n000000b",
        ] {
            let octets = read(line);
            assert_eq!(octets.first().map(String::as_str), Some(DIAG), "{line}");
        }
    }

    #[test]
    fn the_reader_removes_the_offsets_of_a_dump() {
        let dump = "\
00000000  68 05 05 68 88 82 6d 3c  3e f1 16 e5 10 08 02 49  |h..h..m<>......I|
00000010  53 16                                             |S.|
00000012";
        assert_eq!(read(dump), ["68 05 05 68 88 82 6D 3C 3E F1 16 E5 10 08 02 49", "53 16"]);
        // Eight digits that are not the expected offset are octets.
        assert_eq!(read("68050568 88826D3C 3EF116"), [DIAG]);
    }

    #[test]
    fn the_lines_that_a_dump_omits_are_limited_and_the_rest_is_left_over() {
        let line = |address: u64| format!("{address:016x}  68 05 05 68 88 82 6D 3C 3E F1 16 00 00 00 00 00\n");
        let repeated = |text: &str| {
            let (rows, left_over, _) = rows(text);
            let lines: Vec<usize> = left_over.iter().map(|left_over| left_over.line).collect();
            (rows.iter().map(|row| row.times * row.octets.len() as u64).sum::<u64>(), lines)
        };
        let text = |gaps: &[u64]| {
            let (mut text, mut address) = (line(0), 0);
            for gap in gaps {
                address += gap + 16;
                text += &format!("*\n{}", line(address));
            }
            text
        };
        let most = MAX_REPEATED;
        assert_eq!(repeated(&text(&[most])), (most + 32, vec![]));
        assert_eq!(repeated(&text(&[most + 16])), (32, vec![2]));
        assert_eq!(repeated(&text(&[0x7FFF_FFFF_FFFF_FFE0])), (32, vec![2]));
        // The limit is one of the whole text.
        assert_eq!(repeated(&text(&[most - 32, 48, 32, 16])), (most + 80, vec![4, 8]));
    }

    #[test]
    fn an_unreadable_word_between_octets_is_an_octet_with_an_error() {
        for (line, errors) in [
            ("68 05 ?? 68 88 82 6D 3C 3E F1 16", vec![2]),
            ("68 05 05! 68 88 82 6D 3C 3E F1 16", vec![2]),
            ("68 0G 05 68 88 xx 6D 3C 3E F1 16", vec![1, 5]),
        ] {
            let row = rows(line).0.remove(0);
            assert_eq!((row.octets.len(), row.errors), (11, errors), "{line}");
        }
    }

    #[test]
    fn the_reader_takes_the_time_before_the_octets() {
        for (line, seconds) in [
            ("12.5 E5", Some(12.5)),
            ("[0.000250] E5", Some(0.000_25)),
            ("0.25s: E5", Some(0.25)),
            ("01:00:01.5 E5", Some(3601.5)),
            ("2026-11-21T00:00:02.25Z E5", Some(2.25)),
            ("08:15:00 10 08 02 49 53 16", Some(29700.0)),
            ("10 08 02 49 53 16", None),
            ("E5", None),
        ] {
            assert_eq!(rows(line).0[0].seconds, seconds, "{line}");
        }
    }

    #[test]
    fn the_reader_takes_no_octets_from_words() {
        for line in ["", "# 68 05", "be careful", "the cafe added a face", "Slave 8 replied", "// DC 02 02", "7 of 9"] {
            assert_eq!(read(line), [""; 0], "{line}");
        }
        assert_eq!(read("RX: E5"), ["E5"]);
        assert_eq!(read("DC 02"), ["DC 02"]);
    }
}
