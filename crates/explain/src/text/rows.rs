//! Divides the words of a line into rows of octets.

use super::Row;
use super::word::{Meaning, Word};

/// The least number of octets in a line with other words: `cafe` and `be` are words.
pub(super) const MIN_OCTETS: usize = 3;

/// The rows of a line that are compared with the words before rows of other lines: the work for a line grows with its length alone.
const MOST_EXAMINED: usize = 8;

impl Row {
    pub(super) fn add(&mut self, meaning: &Meaning) {
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
pub(super) struct Rows {
    rows: Vec<std::ops::Range<usize>>,
    pub(super) is_taken: Vec<bool>,
    /// Octets of each row.
    lengths: Vec<usize>,
}

impl Rows {
    /// Divides the words of a line into rows. A row has at least one word of two digits; numbers of one digit at its ends belong to
    /// it unless the line writes octets with leading zeros.
    pub(super) fn of(words: &[Word<'_>]) -> Self {
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

    /// The words before a row, with a sign for each number that is none of the row.
    fn prefix(words: &[Word<'_>], row: &std::ops::Range<usize>) -> String {
        let shown = |word: &Word<'_>| match word.meaning {
            Meaning::Other if !word.text.bytes().all(|letter| letter.is_ascii_digit()) => Some(word.text.to_owned()),
            Meaning::Time(_) => None,
            _ => Some("0".to_owned()),
        };
        words.iter().take(row.start).filter_map(shown).collect::<Vec<_>>().join(" ")
    }

    /// The words before the first selected row, if the selected rows are long.
    pub(super) fn prefix_of_long(&self, words: &[Word<'_>]) -> Option<String> {
        let taken = self.rows.iter().find(|row| self.is_taken.get(row.start) == Some(&true)).filter(|_| self.is_long());
        taken.map(|row| Self::prefix(words, row))
    }

    /// Selects the rows of a whole line.
    pub(super) fn select(&mut self, words: &[Word<'_>], is_known: impl Fn(&str) -> bool) {
        let outside = words.iter().any(|word| word.is_octet() && !word.in_brackets);
        let is_text = |word: &Word<'_>| word.meaning == Meaning::Other && !(outside && word.in_brackets);
        let has_words = words.iter().any(is_text);
        let time = words.iter().position(|word| matches!(word.meaning, Meaning::Time(_))).unwrap_or(0);
        let is_outside = |row: &std::ops::Range<usize>| words.get(row.start).is_some_and(|word| !word.in_brackets);
        let brackets_count = !self.rows.iter().any(is_outside);
        let longest = self.rows.iter().zip(&self.lengths).max_by_key(|(_, length)| **length);
        let best = longest.and_then(|(row, _)| words.get(row.start)).map(|word| word.column);
        let is_single = self.lengths.iter().all(|length| *length == 1);
        let begins_row = |row: &std::ops::Range<usize>| {
            words.get(row.start).is_some_and(|word| word.is_marked) || is_known(&Self::prefix(words, row))
        };
        let is_first_known = self.rows.first().is_some_and(begins_row);
        for (number, (row, length)) in self.rows.iter().zip(&self.lengths).enumerate() {
            let Some(first) = words.get(row.start) else { continue };
            let in_column = !has_words || is_single || Some(first.column) == best;
            let is_sc = words.get(row.clone()).is_some_and(is_short_ack);
            let is_row_of_columns = is_single && self.rows.len() >= MIN_OCTETS;
            let is_long =
                *length >= MIN_OCTETS && words.get(row.clone()).is_some_and(|row| row.iter().any(Word::is_number));
            // Columns with one octet each continue the first one.
            let is_of_row = match number {
                0 => is_first_known,
                1..MOST_EXAMINED => (is_first_known && is_single) || (*length < MIN_OCTETS && begins_row(row)),
                _ => is_first_known && is_single,
            };
            let is_certain = is_sc || first.is_marked || is_of_row || first.has_notation();
            let is_enough = !has_words || is_row_of_columns || is_long || is_certain;
            if in_column && is_enough && row.start >= time && (brackets_count || !first.in_brackets) {
                self.is_taken.iter_mut().take(row.end).skip(row.start).for_each(|taken| *taken = true);
            }
        }
    }

    /// Selects the rows of a part of a line. A row may have begun in the part before, and may continue in the next one.
    pub(super) fn select_parts(&mut self, words: &[Word<'_>], continues_row: bool, is_continued: bool) {
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

    pub(super) fn ends_with_row(&self, words: &[Word<'_>]) -> bool {
        !words.is_empty() && self.is_taken.last() == Some(&true)
    }
}

/// The octets of a line that is nothing but octets of two digits with one space between them, and at most one behind them.
pub(super) fn plain_octets(line: &str) -> Option<Vec<u8>> {
    let digit = |letter: u8| char::from(letter).to_digit(16).and_then(|digit| u8::try_from(digit).ok());
    let octet = |group: &[u8]| match *group {
        [high, low] | [high, low, b' '] => Some(digit(high)? << 4 | digit(low)?),
        _ => None,
    };
    let line = line.as_bytes();
    // A group without a space behind it is the last one, because the next one would begin within an octet.
    (!line.is_empty()).then(|| line.chunks(3).map(octet).collect())?
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
