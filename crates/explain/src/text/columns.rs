//! Columns of numbers in front of the octets: numbers of lines, and lengths.
//!
//! Such a number may look like an octet, and an octet like such a number: the whole text decides. A column is one only if its rule holds
//! in every line, in two lines at least, and if no telegram is lost without it.

use super::rows::MIN_OCTETS;
use super::word::{Commas, PREFIXES, has_number_behind, is_separator};
use std::ops::Range;

/// The words in front of the octets of each line.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    commas: Commas,
    columns: Vec<Column>,
    /// How often a number was the one that its rule expects.
    agreements: usize,
    /// The number of lines that have agreed.
    lines: usize,
    /// Where the columns of the first line end. A line that begins behind this place continues the line before.
    end: Option<usize>,
}

/// A column in front of the octets.
#[derive(Clone, Copy, Debug)]
enum Column {
    /// No octet: the notation finds out its meaning.
    Word,
    /// No octet, though it looks like one.
    Number(Number),
}

/// A column of numbers, and the rules that all lines so far agree with.
#[derive(Clone, Copy, Debug)]
struct Number {
    /// The number of the line before, in each of [`RADICES`].
    last: [Option<usize>; 2],
    /// Whether the numbers have one of [`MARKS`].
    is_marked: Option<bool>,
    /// It grows by one from line to line.
    is_counter: bool,
    /// It is the number of octets behind the columns.
    is_length: bool,
}

/// A line without the numbers of its columns.
#[derive(Debug, Default)]
pub(super) struct Cleaned<'a> {
    pub(super) text: String,
    /// The numbers that the columns expect.
    pub(super) numbers: Vec<&'a str>,
    /// Other numbers in their place: they may be octets.
    pub(super) left_over: Vec<&'a str>,
}

/// Number systems of a column.
const RADICES: [u32; 2] = [10, 16];

/// Signs at the ends of a number of a column: `#17`, `17:`, `17.`.
const MARKS: [char; 3] = ['#', ':', '.'];

/// The most digits of a number of a column. chosen: a counter of a million lines a second for a quarter of an hour.
const MOST_DIGITS: usize = 9;

/// The most characters of a number that shows a column. The addresses of dumps have six at least: that of the second line is the number of
/// its octets.
const LONGEST_NUMBER: usize = 5;

/// The most columns in front of the octets. chosen: the log of Portmon has eight.
const MOST_COLUMNS: usize = 8;

/// The least number of agreements of a text. chosen: an octet agrees by chance in one line of a hundred.
const MIN_AGREEMENTS: usize = 2;

impl Columns {
    /// The columns that the lines may have: those with the most words first.
    pub(super) fn candidates<'a>(lines: impl Iterator<Item = &'a str> + Clone) -> Vec<Self> {
        let mut candidates = Vec::new();
        for commas in [Commas::Octets, Commas::Numbers] {
            if commas == Commas::Numbers && !lines.clone().any(Commas::may_be_in_numbers) {
                continue;
            }
            let words = |line: &'a str| -> Vec<&'a str> {
                places(line, commas).into_iter().filter_map(|place| line.get(place)).collect()
            };
            let rows: Vec<Vec<&str>> = lines.clone().map(words).filter(|row| may_have_columns(row)).collect();
            let most = rows.iter().map(Vec::len).min().unwrap_or_default().saturating_sub(1).min(MOST_COLUMNS);
            candidates.extend((1..=most).rev().filter_map(|count| Self::of(&rows, count, commas)));
        }
        candidates
    }

    /// The first `count` words of all lines, if one of them at least is a number and none is an octet. With one octet a line they are
    /// columns of a table, or addresses.
    fn of(rows: &[Vec<&str>], count: usize, commas: Commas) -> Option<Self> {
        let (mut columns, mut has_several) = (vec![(Some(Number::NEW), true); count], false);
        for row in rows {
            let run = Run::of(row.get(count..)?);
            if run.words == 0 {
                return None;
            }
            has_several |= run.words.max(run.pairs()) >= MIN_OCTETS;
            for ((number, are_words), word) in columns.iter_mut().zip(row) {
                let is_long = word.len() > LONGEST_NUMBER;
                if number.as_mut().is_some_and(|number| is_long || !number.agrees(word, run)) {
                    *number = None;
                }
                *are_words &= is_word(word);
                if number.is_none() && !*are_words {
                    return None;
                }
            }
        }
        // A long number in front of octets is octets itself, unless another column is between.
        let ends = |row: &Vec<&str>| row.get(count.saturating_sub(1)).is_some_and(|word| digits(word).is_none());
        let has_end = columns.last().is_some_and(|(number, _)| number.is_some()) || rows.iter().all(ends);
        if !has_several || !has_end || columns.iter().all(|(number, _)| number.is_none()) {
            return None;
        }
        let agreed = |((number, _), word): (&(Option<Number>, bool), &&str)| {
            number.as_ref().map_or(0, |number| number.agreements(rows.len(), word))
        };
        let agreements = columns.iter().zip(rows.first()?).map(agreed).sum();
        let kind = |(number, _): (Option<Number>, bool)| number.map_or(Column::Word, |_| Column::Number(Number::NEW));
        Some(Self {
            commas,
            columns: columns.into_iter().map(kind).collect(),
            agreements,
            lines: rows.len(),
            end: None,
        })
    }

    /// Whether the lines so far show that the numbers are columns. One line does not: the octets of a text may begin with zeros.
    pub(super) const fn are_shown(&self) -> bool {
        self.agreements >= MIN_AGREEMENTS && self.lines > 1
    }

    /// The next line without the numbers, and with a point in place of a decimal comma in front of the octets; `None` for a line that does
    /// not begin with these columns, or continues the line before.
    pub(super) fn clean<'a>(&mut self, line: &'a str) -> Option<Cleaned<'a>> {
        let places = places(line, self.commas);
        let words: Vec<&str> = places.iter().filter_map(|place| line.get(place.clone())).collect();
        let fits = |(column, word): (&Column, &&str)| match column {
            Column::Word => is_word(word),
            Column::Number(number) => numbers(word) != [None; 2] && number.has_marks_of(word),
        };
        let is_continuation = self.end.zip(places.first()).is_some_and(|(end, first)| first.start >= end);
        if words.is_empty() || is_continuation || !self.columns.iter().zip(&words).all(fits) {
            return None;
        }
        let has_all = words.len() >= self.columns.len();
        let run = Run::of(words.get(self.columns.len()..).unwrap_or_default());
        // Without its number, `Length 3:` would take the first octet for it.
        let before: Vec<bool> = self.columns.iter().skip(1).map(Column::is_number).chain([false]).collect();
        let (mut cleaned, mut from) = (Cleaned::default(), 0);
        for (((column, word), place), is_before_number) in self.columns.iter_mut().zip(words).zip(places).zip(before) {
            cleaned.text += line.get(from..place.start).unwrap_or_default();
            from = place.end;
            match column {
                Column::Word if is_before_number && has_number_behind(word) => cleaned.numbers.push(word),
                Column::Word if self.commas == Commas::Numbers => cleaned.text += &word.replace(',', "."),
                Column::Word => cleaned.text += word,
                Column::Number(number) => {
                    let place = if number.agrees(word, run) { &mut cleaned.numbers } else { &mut cleaned.left_over };
                    place.push(word);
                }
            }
        }
        self.end = self.end.or(has_all.then_some(from));
        cleaned.text += line.get(from..).unwrap_or_default();
        Some(cleaned)
    }
}

impl Column {
    const fn is_number(&self) -> bool {
        matches!(self, Self::Number(_))
    }
}

impl Number {
    /// A column before its first line.
    const NEW: Self = Self { last: [None; 2], is_marked: None, is_counter: true, is_length: true };

    /// Whether the word of the next line agrees with a rule that all lines before agree with.
    fn agrees(&mut self, word: &str, run: Run) -> bool {
        let now = numbers(word);
        let is_number = now != [None; 2] && self.has_marks_of(word);
        self.is_marked = self.is_marked.or(Some(is_marked(word)));
        let follows = |(last, now): (Option<usize>, Option<usize>)| {
            last.zip(now).is_some_and(|(last, now)| last.checked_add(1) == Some(now))
        };
        let is_next = is_number && (self.last == [None; 2] || self.last.into_iter().zip(now).any(follows));
        let is_counter = self.is_counter && is_next;
        let is_length = self.is_length && is_number && now.into_iter().flatten().any(|number| run.has(number));
        if is_counter || is_length {
            (self.is_counter, self.is_length) = (is_counter, is_length);
        }
        self.last = now;
        is_counter || is_length
    }

    /// Whether a word has marks if the numbers of the lines before have some, and none otherwise.
    fn has_marks_of(&self, word: &str) -> bool {
        self.is_marked.is_none_or(|marked| marked == is_marked(word))
    }

    /// How often the rule could have failed in these lines: a counter begins with any number, though mostly with 0 or 1.
    fn agreements(&self, lines: usize, first: &str) -> usize {
        let begins = numbers(first).into_iter().flatten().any(|number| number <= 1);
        if self.is_length || begins { lines } else { lines.saturating_sub(1) }
    }
}

/// The octets behind the columns of a line, up to the first word that is none.
#[derive(Clone, Copy, Debug, Default)]
struct Run {
    words: usize,
    digits: usize,
}

impl Run {
    fn of(words: &[&str]) -> Self {
        let add = |run: Self, digits: usize| Self {
            words: run.words.saturating_add(1),
            digits: run.digits.saturating_add(digits),
        };
        words.iter().map_while(|word| octet_digits(word)).fold(Self::default(), add)
    }

    /// The number of octets with two digits each, maybe without separators.
    const fn pairs(self) -> usize {
        self.digits / 2
    }

    const fn has(self, count: usize) -> bool {
        count == self.words || count == self.pairs()
    }
}

/// The places of the words of a line.
fn places(line: &str, commas: Commas) -> Vec<Range<usize>> {
    let (mut places, mut from) = (Vec::new(), 0);
    for (at, letter) in line.char_indices().chain([(line.len(), ' ')]) {
        if !is_separator(letter) || commas.is_in_number(line, at) {
            continue;
        }
        if at > from {
            places.push(from..at);
        }
        from = at.saturating_add(letter.len_utf8());
    }
    places
}

/// Whether a line may have a number and octets behind it: a comment, the names of columns and `Opening COM3 at 19200` do not.
fn may_have_columns(words: &[&str]) -> bool {
    let is_comment = words.first().is_some_and(|word| *word == "#" || word.starts_with("//"));
    let has_digit = |word: &&str| word.bytes().any(|letter| letter.is_ascii_digit());
    let is_number = |word: &&&str| octet_digits(word).is_some() || numbers(word) != [None; 2];
    !is_comment && words.iter().any(has_digit) && words.iter().filter(is_number).count() > 1
}

/// Whether a number has one of [`MARKS`].
fn is_marked(word: &str) -> bool {
    word.trim_matches(MARKS).len() != word.len()
}

/// The number of a word in each of [`RADICES`]: `17`, `#17`, `17:`, `0B`.
fn numbers(word: &str) -> [Option<usize>; 2] {
    let digits = word.trim_matches(MARKS);
    RADICES.map(|radix| {
        let is_number = digits.len() <= MOST_DIGITS && digits.chars().all(|letter| letter.is_digit(radix));
        usize::from_str_radix(digits, radix).ok().filter(|_| is_number)
    })
}

/// The digits of an octet or of joined octets, without what a language writes around them.
fn digits(word: &str) -> Option<&str> {
    let digits = PREFIXES.iter().find_map(|prefix| word.strip_prefix(prefix)).or_else(|| word.strip_prefix('-'));
    let digits = digits.unwrap_or(word);
    let digits = digits.strip_suffix(['h', 'H']).unwrap_or(digits);
    let is_number = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    is_number.then_some(digits)
}

/// The number of digits of a word of octets, also with a sign between them: `10:08:02`.
fn octet_digits(word: &str) -> Option<usize> {
    let is_pair = |pair: &str| pair.len() == 2 && digits(pair) == Some(pair);
    let signs = || word.split([':', '-', '_']).all(is_pair).then(|| word.split([':', '-', '_']).count());
    digits(word).map(str::len).or_else(|| signs().map(|pairs| pairs.saturating_mul(2)))
}

/// Whether a word in front of octets is none: a time, a name, or a long number.
fn is_word(word: &str) -> bool {
    digits(word).is_none_or(|digits| digits.len() == word.len() && digits.len() > 3)
}
