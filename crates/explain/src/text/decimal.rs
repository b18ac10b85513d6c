//! Logs with octets as decimal numbers: `TX [16, 8, 2, 73, 83, 22]`, arrays of Python and JSON, lists.

use super::ignored::{Ignored, IgnoredKind, shortened};
use super::rows::MIN_OCTETS;
use super::word::clock_time;
use super::{Found, LeftOver, Row};

/// Reads octets in decimal.
#[derive(Clone, Debug, Default)]
pub(super) struct Decimal {
    /// The last part has ended within brackets.
    depth: usize,
    /// A line has had a row of octets.
    has_rows: bool,
    /// The number in the first column of the last line, which counts the lines if it grows by one.
    counter: Option<u8>,
}

/// A run of numbers of a line.
#[derive(Debug, Default)]
struct Run {
    octets: Vec<u8>,
    in_brackets: bool,
    /// One of the numbers has three digits.
    is_certain: bool,
}

/// The numbers of a line.
#[derive(Debug, Default)]
struct Numbers {
    runs: Vec<Run>,
    words: Vec<String>,
    seconds: Option<f64>,
    /// Numbers that are no octet, and the largest of them.
    largest: u64,
}

impl Decimal {
    /// Reads a line or a part of it.
    pub(super) fn read(&mut self, line: usize, text: &str, is_last: bool, found: &mut Found, ignored: &mut Ignored) {
        let Numbers { runs, words, seconds, .. } = self.numbers(text);
        let has_brackets = runs.iter().any(|run| run.in_brackets);
        let is_counted = self.is_counted(&runs) && !has_brackets && words.is_empty();
        let longest = runs.iter().map(|run| run.octets.len()).max().unwrap_or_default();
        let is_taken = |run: &Run| match (has_brackets, words.is_empty()) {
            (true, _) => run.in_brackets,
            (false, true) => true,
            (false, false) => run.octets.len() == longest && (longest >= MIN_OCTETS || self.has_rows),
        };
        let (mut octets, mut left_over) = (Vec::new(), Vec::new());
        for (number, run) in runs.into_iter().enumerate() {
            if is_counted && number == 0 {
                let text = run.octets.first().map(u8::to_string).unwrap_or_default();
                found.left_over.push(LeftOver { line, text, octets: 1 });
            } else if is_taken(&run) {
                octets.extend(run.octets);
            } else if run.octets.len() >= MIN_OCTETS {
                left_over.push(run.octets);
            }
        }
        for octets in left_over {
            let text: Vec<String> = octets.iter().map(u8::to_string).collect();
            found.left_over.push(LeftOver { line, text: shortened(&text.join(" ")), octets: octets.len() });
        }
        let has_rows = !octets.is_empty();
        self.has_rows |= octets.len() >= MIN_OCTETS;
        if has_rows {
            found.rows.push_back(Row { seconds, octets, errors: Vec::new(), is_continued: !is_last, times: 1 });
        }
        if !words.is_empty() || (!has_rows && !text.trim().is_empty()) {
            let kind = if has_rows { IgnoredKind::Words } else { IgnoredKind::Line };
            ignored.add(kind, line, &if words.is_empty() { text.to_owned() } else { words.join(" ") });
        }
    }

    /// Whether the first column has one number, which is one more than in the line before, and in the first line 0 or 1.
    fn is_counted(&mut self, runs: &[Run]) -> bool {
        let counter = match runs {
            [Run { octets, in_brackets: false, .. }, row, ..] if row.octets.len() >= MIN_OCTETS => {
                match octets.as_slice() {
                    [counter] => Some(*counter),
                    _ => None,
                }
            }
            _ => None,
        };
        let before = std::mem::replace(&mut self.counter, counter);
        counter.is_some_and(|now| match before {
            Some(before) => now.checked_sub(1) == Some(before),
            None => !self.has_rows && now <= 1,
        })
    }

    /// Divides a line into runs of numbers, words and a time.
    fn numbers(&mut self, text: &str) -> Numbers {
        let (mut numbers, mut run) = (Numbers::default(), Run::default());
        let mut from = 0_usize;
        for (at, letter) in text.char_indices().chain([(text.len(), ' ')]) {
            if !letter.is_whitespace() && !",;[](){}=|\"'".contains(letter) {
                continue;
            }
            let word = text.get(from..at).unwrap_or_default();
            from = at.saturating_add(letter.len_utf8());
            match octet(word) {
                _ if word.is_empty() => {}
                Some(octet) => {
                    run.is_certain |= word.len() == 3;
                    run.octets.push(octet);
                }
                None => {
                    numbers.end(&mut run, self.depth);
                    match (numbers.seconds, clock_time(word), word.parse::<u64>()) {
                        (None, Some(seconds), _) => numbers.seconds = Some(seconds),
                        (_, _, Ok(number)) => numbers.largest = numbers.largest.max(number),
                        _ => numbers.words.push(word.to_owned()),
                    }
                }
            }
            match letter {
                '[' | '(' | '{' => {
                    numbers.end(&mut run, self.depth);
                    self.depth = self.depth.saturating_add(usize::from(letter == '['));
                }
                ']' | ')' | '}' => {
                    numbers.end(&mut run, self.depth);
                    self.depth = self.depth.saturating_sub(usize::from(letter == ']'));
                }
                ';' | '|' | '\t' | '=' => numbers.end(&mut run, self.depth),
                _ => {}
            }
        }
        numbers.end(&mut run, self.depth);
        numbers
    }

    /// Whether the lists of a line can only be decimal: a number of three digits among octets, and no hexadecimal digit.
    pub(super) fn is_certain(text: &str) -> bool {
        let numbers = Self::default().numbers(text);
        let is_list = |run: &Run| run.is_certain && run.octets.len() >= MIN_OCTETS;
        numbers.runs.iter().any(is_list) && numbers.largest == 0
    }
}

impl Numbers {
    fn end(&mut self, run: &mut Run, depth: usize) {
        if !run.octets.is_empty() {
            self.runs.push(Run { in_brackets: depth > 0, ..std::mem::take(run) });
        }
    }
}

/// A number from 0 to 255.
fn octet(word: &str) -> Option<u8> {
    let is_number = (1..=3).contains(&word.len()) && word.bytes().all(|letter| letter.is_ascii_digit());
    word.parse().ok().filter(|_| is_number)
}
