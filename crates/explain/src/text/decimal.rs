//! Logs with octets as numbers: `TX [16, 8, 2, 73, 83, 22]`, arrays of Python and JSON, signed bytes of Java, lists, binary digits.

use super::ignored::{Ignored, IgnoredKind, shortened};
use super::radix::Radix;
use super::rows::MIN_OCTETS;
use super::word::{Commas, MONTHS, clock_time, decimal_number, is_separator, names_a_number, unit};
use super::{Found, LeftOver, Row};
use std::collections::BTreeSet;

/// Reads octets in decimal, or in another notation of one number each.
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    radix: Radix,
    commas: Commas,
    /// The last part has ended within brackets.
    depth: usize,
    /// The words in front of long rows: behind them a short row counts too.
    prefixes: BTreeSet<String>,
    /// The number in the first column of the last line, which counts the lines if it grows by one.
    counter: Option<u8>,
    /// A line has had a row of octets.
    has_rows: bool,
}

/// The most prefixes that are kept. chosen.
const MOST_PREFIXES: usize = 64;

/// A run of numbers of a line.
#[derive(Clone, Debug, Default)]
struct Run {
    octets: Vec<u8>,
    in_brackets: bool,
    /// One of the numbers has three digits, or a sign.
    is_certain: bool,
    /// The number of words in front of it, and of words, times and brackets.
    words: usize,
    breaks: usize,
}

/// The numbers of a line.
#[derive(Debug, Default)]
struct Line {
    runs: Vec<Run>,
    words: Vec<String>,
    breaks: usize,
    seconds: Option<f64>,
    /// Numbers that are no octet, and the largest of them.
    largest: u64,
}

impl Numbers {
    pub(super) const fn new(radix: Radix, commas: Commas) -> Self {
        Self { radix, commas, depth: 0, prefixes: BTreeSet::new(), counter: None, has_rows: false }
    }

    pub(super) const fn radix(&self) -> Radix {
        self.radix
    }

    /// Reads a line or a part of it.
    pub(super) fn read(&mut self, line: usize, text: &str, is_last: bool, found: &mut Found, ignored: &mut Ignored) {
        let numbers = self.line(text);
        let has_brackets = numbers.runs.iter().any(|run| run.in_brackets);
        let is_counted = self.is_counted(&numbers.runs) && !has_brackets && numbers.words.is_empty();
        let taken = self.taken(&numbers, has_brackets, is_counted);
        let (mut octets, mut left_over) = (Vec::new(), Vec::new());
        let has_taken = taken.contains(&true);
        for (number, (run, is_taken)) in numbers.runs.iter().zip(taken).enumerate() {
            if is_taken {
                self.learn(&numbers, run, has_brackets);
                octets.extend(&run.octets);
            } else if run.octets.len() >= MIN_OCTETS || !has_taken || (number == 0 && is_counted) {
                left_over.push(&run.octets);
            }
        }
        for octets in left_over {
            let text: Vec<String> = octets.iter().map(u8::to_string).collect();
            found.left_over.push(LeftOver { line, text: shortened(&text.join(" ")), octets: octets.len() });
        }
        let Line { words, seconds, .. } = numbers;
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

    /// Which runs of a line are octets.
    fn taken(&self, line: &Line, has_brackets: bool, is_counted: bool) -> Vec<bool> {
        let Line { runs, words, .. } = line;
        let longest = runs.iter().map(|run| run.octets.len()).max().unwrap_or_default();
        let is_known = |run: &Run| longest >= MIN_OCTETS || self.prefixes.contains(&line.prefix(run));
        let is_taken = |(number, run): (usize, &Run)| match (has_brackets, words.is_empty()) {
            (true, _) => run.in_brackets,
            (false, true) => !(is_counted && number == 0),
            (false, false) => run.octets.len() == longest && is_known(run),
        };
        runs.iter().enumerate().map(is_taken).collect()
    }

    /// Keeps the words in front of a long run.
    fn learn(&mut self, line: &Line, run: &Run, has_brackets: bool) {
        if run.octets.len() >= MIN_OCTETS && !has_brackets && self.prefixes.len() < MOST_PREFIXES {
            self.prefixes.insert(line.prefix(run));
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
    fn line(&mut self, text: &str) -> Line {
        let (mut line, mut run) = (Line::default(), Run::default());
        let (mut from, mut before) = (0_usize, "");
        for (at, letter) in text.char_indices().chain([(text.len(), ' ')]) {
            if !is_separator(letter) || self.commas.is_in_number(text, at) {
                continue;
            }
            let word = text.get(from..at).unwrap_or_default();
            from = at.saturating_add(letter.len_utf8());
            if !word.is_empty() {
                match unit(word).and_then(|unit| Some((decimal_number(before)?, unit))) {
                    Some((number, unit)) => {
                        if self.octet(before).is_some() {
                            run.octets.pop();
                        }
                        line.take_time(number, unit, &mut run, self.depth);
                    }
                    None => self.word(word, &mut line, &mut run),
                }
                before = word;
            }
            match letter {
                '[' | '(' | '{' => {
                    line.end(&mut run, self.depth);
                    line.breaks = line.breaks.saturating_add(1);
                    self.depth = self.depth.saturating_add(usize::from(letter == '['));
                }
                ']' | ')' | '}' => {
                    line.end(&mut run, self.depth);
                    line.breaks = line.breaks.saturating_add(1);
                    self.depth = self.depth.saturating_sub(usize::from(letter == ']'));
                }
                ';' | '|' | '\t' | '=' => line.end(&mut run, self.depth),
                _ => {}
            }
        }
        line.end(&mut run, self.depth);
        line.join_columns();
        line
    }

    /// Adds a word: an octet, a time, or another one, maybe with an octet behind its colon.
    fn word(&self, word: &str, line: &mut Line, run: &mut Run) {
        if let Some(octet) = self.octet(word) {
            run.is_certain |= word.len() == 3 || word.starts_with('-');
            run.octets.push(octet);
            return;
        }
        let glued = word.rsplit_once(':');
        let glued = glued
            .filter(|(front, _)| front.bytes().any(|letter| letter.is_ascii_alphabetic()) && !names_a_number(front));
        if let Some((front, octet)) = glued.and_then(|(front, back)| Some((front, self.octet(back)?))) {
            line.add_word(front, run, self.depth);
            run.octets.push(octet);
            return;
        }
        let seconds = clock_time(word).filter(|_| line.seconds.is_none());
        // The day in `Nov 29 12:00:00`.
        let is_day = run.octets.len() == 1 && line.words.last().is_some_and(|last| MONTHS.contains(&last.as_str()));
        if seconds.is_some() && is_day {
            run.octets.clear();
        }
        match (seconds, word.parse::<u64>()) {
            (Some(seconds), _) => {
                line.end(run, self.depth);
                line.breaks = line.breaks.saturating_add(1);
                line.seconds = Some(seconds);
            }
            (None, Ok(number)) => {
                line.end(run, self.depth);
                line.breaks = line.breaks.saturating_add(1);
                line.largest = line.largest.max(number);
            }
            (None, Err(_)) => line.add_word(word, run, self.depth),
        }
    }

    /// The octet of a word. Java and C# print octets above 127 as negative numbers.
    fn octet(&self, word: &str) -> Option<u8> {
        match (self.radix, word.strip_prefix('-')) {
            (Radix::Decimal, Some(digits)) => {
                let number = Radix::Decimal.octet(digits).filter(|number| (1..=128).contains(number))?;
                Some(number.wrapping_neg())
            }
            (radix, _) => radix.octet(word),
        }
    }

    /// Whether the lists of a line can only be decimal: a number of three digits among octets, and no hexadecimal digit.
    pub(super) fn is_certain(text: &str) -> bool {
        let line = Self::new(Radix::Decimal, Commas::Octets).line(text);
        let is_list = |run: &Run| run.is_certain && run.octets.len() >= MIN_OCTETS;
        line.runs.iter().any(is_list) && line.largest == 0
    }
}

impl Line {
    fn end(&mut self, run: &mut Run, depth: usize) {
        if !run.octets.is_empty() {
            let (words, breaks) = (self.words.len(), self.breaks);
            self.runs.push(Run { in_brackets: depth > 0, words, breaks, ..std::mem::take(run) });
        }
    }

    /// Adds a number of a unit of time. Behind octets or another time it is a duration.
    fn take_time(&mut self, number: f64, unit: f64, run: &mut Run, depth: usize) {
        self.end(run, depth);
        self.breaks = self.breaks.saturating_add(1);
        if self.runs.is_empty() && self.seconds.is_none_or(|seconds| seconds == number) {
            self.seconds = Some(number * unit);
        }
    }

    fn add_word(&mut self, word: &str, run: &mut Run, depth: usize) {
        self.end(run, depth);
        self.breaks = self.breaks.saturating_add(1);
        self.words.push(word.to_owned());
    }

    /// The words with letters in front of a run.
    fn prefix(&self, run: &Run) -> String {
        let words = self.words.get(..run.words).unwrap_or_default().iter();
        let named = words.filter(|word| word.chars().any(char::is_alphabetic)).map(String::as_str);
        named.collect::<Vec<_>>().join(" ")
    }

    /// Joins columns with one number each, if nothing else is between them: `16;8;2;73;83;22`.
    fn join_columns(&mut self) {
        let mut joined: Vec<Run> = Vec::new();
        for group in self.runs.chunk_by(|run, next| run.breaks == next.breaks) {
            match group {
                [first, ..] if group.len() >= MIN_OCTETS && group.iter().all(|run| run.octets.len() == 1) => {
                    let octets = group.iter().flat_map(|run| run.octets.iter().copied()).collect();
                    joined.push(Run { octets, is_certain: group.iter().any(|run| run.is_certain), ..*first });
                }
                _ => joined.extend_from_slice(group),
            }
        }
        self.runs = joined;
    }
}
