//! Chooses the notation of a text by the check octets of its telegrams, and reads the text in it.

use super::columns::{Cleaned, Columns};
use super::decimal::Numbers;
use super::escapes::{Calls, Quoted, Strings};
use super::ignored::{Ignored, IgnoredKind, shortened};
use super::letters::{Letters, Shown, are_letters};
use super::radix::Radix;
use super::single::{Lines, Table};
use super::word::Commas;
use super::{Found, LeftOver, Reader, checked_octets, has_token};
use profivac_dp::link::Baud;

/// Notation of the octets of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    /// Hexadecimal, several octets a line.
    Hexadecimal,
    /// A dump with letters in place of octets.
    Letters,
    /// One octet a line, in a notation of this name.
    Single(&'static str),
    /// A table with one octet a line, in a notation of this name.
    Table(&'static str),
    /// Decimal numbers.
    Decimal,
    /// Eight binary digits for each octet.
    Binary,
    /// Strings with escapes.
    Strings,
    /// Calls that strace prints.
    Calls,
}

impl std::fmt::Display for Notation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Hexadecimal => f.write_str("octets in hexadecimal"),
            Self::Letters => f.write_str("letters and octal numbers, as od -c and hexdump -c print them"),
            Self::Single(radix) => write!(f, "one octet a line in {radix}"),
            Self::Table(radix) => write!(f, "a table with one octet a line in {radix}"),
            Self::Decimal => f.write_str("octets in decimal"),
            Self::Binary => f.write_str("octets in binary"),
            Self::Strings => f.write_str("octets in strings with escapes"),
            Self::Calls => f.write_str("octets in the calls that strace prints"),
        }
    }
}

/// Notation that a user states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatedNotation {
    /// Hexadecimal, several octets a line.
    Hexadecimal,
    /// Decimal numbers.
    Decimal,
    /// Strings with escapes.
    Strings,
    /// Calls that strace prints.
    Calls,
}

/// The most octets of a text that wait until a telegram shows the notation. chosen: the libraries that a program loads before it opens its
/// port are less in the output of strace.
const MOST_HELD: usize = 1 << 20;

/// The number of parts up to which the notation is searched after each part; then after each doubling.
const SEARCHED_PARTS: usize = 8;

/// The most parts that wait for columns of numbers after a telegram or a token has shown the notation: a pipe may stay open. chosen: three
/// lines with octets show a column, and lines without octets may be between them.
const WAITING_PARTS: usize = 8;

/// The most parts that wait for a telegram more if most octets are outside of telegrams: a pipe may stay open. chosen: with one octet a line
/// most telegrams of a gauge end before.
const WAITING_IN_DOUBT: usize = 32;

/// The most parts that wait for the second line of a dump with letters: omitted lines may be between.
const WAITING_FOR_LETTERS: usize = 3;

/// Reads a text: holds its first lines until a telegram with a check octet shows the notation.
#[derive(Clone, Debug)]
pub(crate) struct Log {
    baud: Baud,
    line: usize,
    ignored: Ignored,
    /// The present line has begun with another part.
    is_inner: bool,
    held: Vec<Part>,
    held_octets: usize,
    /// The number of parts at which the notation is searched next.
    search_at: usize,
    form: Option<Form>,
    /// The number of parts at which columns are no longer awaited.
    waits_until: Option<usize>,
    /// The number of parts at which the second line of a dump with letters is no longer awaited.
    letters_until: Option<usize>,
    /// The number of parts at which a notation counts although most octets are outside of telegrams.
    doubtful_until: Option<usize>,
    /// The numbers in front of the octets.
    columns: Option<Columns>,
    /// A telegram, a token or the user has shown the notation.
    is_shown: bool,
}

/// A line or a part of it.
#[derive(Clone, Debug)]
struct Part {
    text: String,
    /// The line ends here.
    is_last: bool,
}

/// The reader of each notation.
#[derive(Clone, Debug)]
enum Form {
    Hexadecimal(Box<Reader>),
    Letters(Letters),
    Single(Lines),
    Table(Table),
    Numbers(Numbers),
    Strings(Strings),
    Calls(Calls),
}

impl Log {
    pub(crate) fn new(baud: Baud) -> Self {
        Self {
            baud,
            line: 0,
            ignored: Ignored::default(),
            is_inner: false,
            held: Vec::new(),
            held_octets: 0,
            search_at: 1,
            form: None,
            waits_until: None,
            letters_until: None,
            doubtful_until: None,
            columns: None,
            is_shown: false,
        }
    }

    /// The user states the notation, before the first line.
    pub(crate) fn state(&mut self, notation: StatedNotation) {
        let form = match notation {
            StatedNotation::Hexadecimal => self.hexadecimal(Commas::Octets),
            StatedNotation::Decimal => decimal(Commas::Octets),
            StatedNotation::Strings => Form::Strings(Strings::new(Quoted::Any)),
            StatedNotation::Calls => Form::Calls(Calls::default()),
        };
        (self.form, self.is_shown) = (Some(form), true);
    }

    /// Whether a telegram or the user has shown the notation. Otherwise it is the most frequent one.
    pub(crate) const fn is_shown(&self) -> bool {
        self.is_shown
    }

    /// The notation, as soon as a telegram has shown it.
    pub(crate) fn notation(&self) -> Option<Notation> {
        self.form.as_ref().map(Form::notation)
    }

    /// The text that is not octets.
    pub(crate) fn ignored(&self) -> Ignored {
        match &self.form {
            Some(Form::Hexadecimal(reader)) => reader.ignored().clone(),
            Some(Form::Letters(letters)) => letters.ignored().clone(),
            _ => self.ignored.clone(),
        }
    }

    /// Counts text that is not octets, in front of the first line.
    pub(crate) fn ignore(&mut self, kind: IgnoredKind, text: &str) {
        self.ignored.add(kind, 1, text);
    }

    /// Reads a line, or the part of a line that is too long. `is_last` says whether the line ends here.
    pub(crate) fn read(&mut self, text: &str, is_last: bool, found: &mut Found) {
        if self.form.is_some() {
            self.read_part(text, is_last, found);
            return;
        }
        self.held.push(Part { text: text.to_owned(), is_last });
        self.held_octets = self.held_octets.saturating_add(text.len());
        let is_full = self.held_octets >= MOST_HELD;
        if self.held.len() >= self.search_at || is_full {
            let parts = self.held.len();
            self.search_at = parts.saturating_add(if parts < SEARCHED_PARTS { 1 } else { parts });
            self.choose(is_full);
            self.release(found);
        }
    }

    /// Ends the text.
    pub(crate) fn end(&mut self, found: &mut Found) {
        if self.form.is_none() {
            self.choose(true);
            self.release(found);
        }
        if let Some(form) = &mut self.form {
            form.end(found);
        }
    }

    /// Searches the notation. `is_all` says that no more lines decide.
    fn choose(&mut self, is_all: bool) {
        match are_letters(self.held.iter().map(|part| part.text.as_str())) {
            Shown::Letters => {
                (self.form, self.is_shown) = (Some(Form::Letters(Letters::new(self.reader(Commas::Octets)))), true);
                return;
            }
            Shown::Undecided if !is_all => {
                let parts = self.held.len();
                if parts < *self.letters_until.get_or_insert(parts.saturating_add(WAITING_FOR_LETTERS)) {
                    self.search_at = parts.saturating_add(1);
                    return;
                }
            }
            Shown::Undecided | Shown::No => {}
        }
        self.form = self.search(&self.held);
        if self.find_columns() && !is_all {
            let parts = self.held.len();
            let until = *self.waits_until.get_or_insert(parts.saturating_add(WAITING_PARTS));
            if parts < until {
                self.search_at = parts.saturating_add(1);
                self.form = None;
                return;
            }
        }
        if !is_all && self.is_doubtful() {
            let parts = self.held.len();
            if parts < *self.doubtful_until.get_or_insert(parts.saturating_add(WAITING_IN_DOUBT)) {
                self.form = None;
                return;
            }
        }
        self.is_shown = self.form.is_some();
        if is_all && self.form.is_none() {
            self.form = Some(match self.is_decimal() {
                true => decimal(Commas::Octets),
                false => self.hexadecimal(Commas::Octets),
            });
        }
    }

    /// Whether the notation has telegrams and leaves as many octets outside of them: a short telegram may be one by chance.
    fn is_doubtful(&self) -> bool {
        let tried = self.form.clone().map(|form| self.try_form(&self.held, form));
        tried.is_some_and(|tried| tried.score > 0 && tried.besides >= tried.score)
    }

    /// Searches columns of numbers in front of the octets. Without the numbers as many octets are in telegrams, and not more are outside
    /// of them: a reader that takes an octet of one digit for a number may be right by chance. Returns whether more lines decide.
    fn find_columns(&mut self) -> bool {
        let lines = self.held.iter().map(|part| part.text.as_str());
        let is_whole = self.held.iter().all(|part| part.is_last);
        let candidates = if is_whole { Columns::candidates(lines) } else { Vec::new() };
        if candidates.is_empty() {
            return false;
        }
        let form = self.form.clone();
        let plain = form.clone().map_or_else(Tried::default, |form| self.try_form(&self.held, form));
        // The other notations ignore numbers beside their octets.
        let has_rows = matches!(form, None | Some(Form::Hexadecimal(_) | Form::Numbers(_)));
        let mut is_open = false;
        for columns in candidates {
            let parts = self.without(columns.clone());
            let form = if plain.score > 0 { form.clone() } else { self.search(&parts) };
            let Some(form) = form else { continue };
            let tried = self.try_form(&parts, form.clone());
            let is_enough = tried.besides.saturating_add(usize::from(!has_rows)) <= plain.besides;
            if tried.score < plain.score || (tried.score == plain.score && !is_enough) {
                continue;
            }
            if columns.are_shown() {
                (self.columns, self.form) = (Some(columns), Some(form));
                return false;
            }
            is_open = true;
        }
        is_open
    }

    /// The held parts without the numbers of columns.
    fn without(&self, mut columns: Columns) -> Vec<Part> {
        let cleaned = |part: &Part| {
            let text = columns.clean(&part.text).map_or_else(|| part.text.clone(), |cleaned| cleaned.text);
            Part { text, is_last: part.is_last }
        };
        self.held.iter().map(cleaned).collect()
    }

    /// Reads the parts that were held.
    fn release(&mut self, found: &mut Found) {
        if self.form.is_none() {
            return;
        }
        for part in std::mem::take(&mut self.held) {
            self.read_part(&part.text, part.is_last, found);
        }
    }

    fn read_part(&mut self, text: &str, is_last: bool, found: &mut Found) {
        let is_whole = is_last && !self.is_inner;
        if !self.is_inner {
            self.line = self.line.saturating_add(1);
        }
        self.is_inner = !is_last;
        let columns = self.columns.as_mut().filter(|_| is_whole);
        let Some(Cleaned { text: rest, numbers, left_over }) = columns.and_then(|columns| columns.clean(text)) else {
            self.read_rest(text, is_last, found);
            return;
        };
        if !numbers.is_empty() {
            self.ignore_numbers(&numbers.join(" "));
        }
        if !left_over.is_empty() {
            let (text, octets) = (shortened(&left_over.join(" ")), left_over.len());
            found.left_over.push(LeftOver { line: self.line, text, octets });
        }
        self.read_rest(&rest, is_last, found);
    }

    /// Counts the numbers of columns beside octets.
    fn ignore_numbers(&mut self, numbers: &str) {
        match &mut self.form {
            Some(Form::Hexadecimal(reader)) => reader.ignored.add(IgnoredKind::Words, self.line, numbers),
            _ => self.ignored.add(IgnoredKind::Words, self.line, numbers),
        }
    }

    fn read_rest(&mut self, text: &str, is_last: bool, found: &mut Found) {
        if let Some(form) = &mut self.form {
            form.read(self.line, text, is_last, found, &mut self.ignored);
        }
    }

    /// The notation in which telegrams with a check octet have the most octets. Of equal ones the first counts, which expects most of the
    /// text.
    fn search(&self, held: &[Part]) -> Option<Form> {
        let (hexadecimal, Tried { rows, score, .. }) = self.with_commas(held, &|commas| self.hexadecimal(commas));
        let text = |mark: &str| held.iter().any(|part| part.text.contains(mark));
        let mut best = None;
        let mut consider = |form: Form, score: usize| {
            if score > best.as_ref().map_or(0, |(_, score)| *score) {
                best = Some((form, score));
            }
        };
        if text("\"") && text("(") && text(" = ") {
            let form = Form::Calls(Calls::default());
            consider(form.clone(), self.try_form(held, form).score);
        }
        if text("b'") || text("b\"") {
            let form = Form::Strings(Strings::new(Quoted::Literals));
            consider(form.clone(), self.try_form(held, form).score);
        }
        let lines = held.iter().map(|part| part.text.as_str());
        if let Some((table, score)) = Table::of(lines.clone()) {
            consider(Form::Table(table), score);
        }
        consider(hexadecimal.clone(), score);
        if text("\"") {
            let form = Form::Strings(Strings::new(Quoted::All));
            consider(form.clone(), self.try_form(held, form).score);
        }
        for radix in Radix::ALL {
            if let Some((lines, score)) = Lines::of(radix, lines.clone(), self.baud) {
                consider(Form::Single(lines), score);
            }
        }
        let (form, Tried { score, .. }) = self.with_commas(held, &decimal);
        consider(form, score);
        let form = Form::Numbers(Numbers::new(Radix::Binary, Commas::Octets));
        consider(form.clone(), self.try_form(held, form).score);
        // A token has no check octet: its three octets in one row show nothing else than hexadecimal digits do.
        let has_token = || !text("\\") && rows.iter().any(|octets| has_token(octets));
        best.map(|(form, _)| form).or_else(|| has_token().then_some(hexadecimal))
    }

    /// Whether the numbers of the text can only be decimal.
    fn is_decimal(&self) -> bool {
        let is_hexadecimal = |part: &Part| {
            let words = part.text.split(|letter: char| !letter.is_ascii_alphanumeric());
            words
                .into_iter()
                .any(|word| word.len() == 2 && word.bytes().any(|letter| letter.is_ascii_alphabetic()) && is_hex(word))
        };
        self.held.iter().any(|part| Numbers::is_certain(&part.text)) && !self.held.iter().any(is_hexadecimal)
    }

    fn hexadecimal(&self, commas: Commas) -> Form {
        Form::Hexadecimal(self.reader(commas))
    }

    fn reader(&self, commas: Commas) -> Box<Reader> {
        Box::new(Reader::new(&self.ignored, commas))
    }

    /// The form with commas between octets, or with decimal commas if these leave as many octets in telegrams, as many of them within a row,
    /// and fewer besides: a decimal comma between octets is a number more.
    fn with_commas(&self, held: &[Part], form: &dyn Fn(Commas) -> Form) -> (Form, Tried) {
        let plain = form(Commas::Octets);
        let tried = self.try_form(held, plain.clone());
        if held.iter().any(|part| Commas::may_be_in_numbers(&part.text)) {
            let other = form(Commas::Numbers);
            let of_other = self.try_form(held, other.clone());
            let is_better = of_other.in_telegrams() > tried.in_telegrams()
                || (of_other.in_telegrams() == tried.in_telegrams() && of_other.besides < tried.besides);
            if of_other.score > 0 && is_better {
                return (other, of_other);
            }
        }
        (plain, tried)
    }

    /// What a notation finds in parts of the text.
    fn try_form(&self, held: &[Part], mut form: Form) -> Tried {
        let (mut found, mut ignored) = (Found::default(), Ignored::default());
        for part in held {
            form.read(1, &part.text, part.is_last, &mut found, &mut ignored);
        }
        form.end(&mut found);
        let left_over: usize = found.left_over.iter().map(|text| text.octets).sum();
        let rows: Vec<Vec<u8>> = found.rows.into_iter().map(|row| row.octets).collect();
        let all = rows.concat();
        let score = checked_octets(&all);
        let in_rows = rows.iter().map(|row| checked_octets(row)).sum();
        Tried { rows, score, in_rows, besides: all.len().saturating_sub(score).saturating_add(left_over) }
    }
}

/// What a notation finds in a text.
#[derive(Default)]
struct Tried {
    /// The rows of octets.
    rows: Vec<Vec<u8>>,
    /// How many octets are in telegrams with a check octet, and how many may be outside of them.
    score: usize,
    /// How many of these are in telegrams within one row.
    in_rows: usize,
    besides: usize,
}

impl Tried {
    /// By which readings are compared: the end of a row and the begin of the next one may be a telegram by chance.
    const fn in_telegrams(&self) -> (usize, usize) {
        (self.score, self.in_rows)
    }
}

fn decimal(commas: Commas) -> Form {
    Form::Numbers(Numbers::new(Radix::Decimal, commas))
}

fn is_hex(word: &str) -> bool {
    word.bytes().all(|letter| letter.is_ascii_hexdigit())
}

impl Form {
    const fn notation(&self) -> Notation {
        match self {
            Self::Hexadecimal(_) => Notation::Hexadecimal,
            Self::Letters(_) => Notation::Letters,
            Self::Single(lines) => Notation::Single(lines.radix().name()),
            Self::Table(table) => Notation::Table(table.radix().name()),
            Self::Numbers(numbers) if matches!(numbers.radix(), Radix::Binary) => Notation::Binary,
            Self::Numbers(_) => Notation::Decimal,
            Self::Strings(_) => Notation::Strings,
            Self::Calls(_) => Notation::Calls,
        }
    }

    fn read(&mut self, line: usize, text: &str, is_last: bool, found: &mut Found, ignored: &mut Ignored) {
        match self {
            Self::Hexadecimal(reader) => return reader.read(text, is_last, found),
            Self::Letters(letters) => return letters.read(text, is_last, found),
            _ => {}
        }
        let text = text.trim_end_matches(['\r', '\n']);
        if text.trim().is_empty() {
            return;
        }
        match self {
            Self::Hexadecimal(_) | Self::Letters(_) => {}
            Self::Single(lines) => lines.read(line, text, found, ignored),
            Self::Table(table) => table.read(line, text, found, ignored),
            Self::Numbers(numbers) => numbers.read(line, text, is_last, found, ignored),
            Self::Strings(strings) => strings.read(line, text, is_last, found, ignored),
            Self::Calls(calls) => calls.read(line, text, found, ignored),
        }
    }

    fn end(&mut self, found: &mut Found) {
        match self {
            Self::Hexadecimal(reader) => reader.end(found),
            Self::Letters(letters) => letters.end(found),
            Self::Single(lines) => lines.end(found),
            Self::Table(table) => table.end(found),
            Self::Numbers(_) | Self::Strings(_) | Self::Calls(_) => {}
        }
    }
}
