//! Logs with one octet a line: behind the same words, or in a column of a table.

use super::ignored::{Ignored, IgnoredKind, shortened};
use super::radix::Radix;
use super::word::{clock_time, decimal_number, unit};
use super::{Found, LeftOver, Row, checked_octets};
use profivac_dp::link::Baud;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// The octet that waits: the next line may say that it had an error.
#[derive(Clone, Debug, Default)]
struct Waiting(Option<Row>);

impl Waiting {
    fn push(&mut self, seconds: Option<f64>, octet: u8, has_error: bool, found: &mut Found) {
        let errors = if has_error { vec![0] } else { Vec::new() };
        found.rows.extend(self.0.replace(Row { seconds, octets: vec![octet], errors, is_continued: false, times: 1 }));
    }

    /// Marks the octet: a line behind it says that it was damaged.
    fn mark(&mut self) {
        if let Some(row) = &mut self.0 {
            row.errors = vec![0];
        }
    }

    fn end(&mut self, found: &mut Found) {
        found.rows.extend(self.0.take());
    }
}

/// Lines with one octet behind the same words: `uart-1: 10`, `0-1100 UART: RX data: 10`.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    radix: Radix,
    /// The words, without direction, behind which octets of the line stand.
    words: BTreeSet<String>,
    samples: Samples,
    waiting: Waiting,
}

/// One octet of a line.
struct Entry<'a> {
    words: String,
    time: Option<Time>,
    value: &'a str,
}

/// The time of an octet.
#[derive(Clone, Copy)]
enum Time {
    Seconds(f64),
    /// The first and the last sample of its eight data bits.
    Samples(u64, u64),
}

/// The most words that are kept.
const MOST_WORDS: usize = 64;

impl Lines {
    /// The reader for the lines in which octets of `radix` are telegrams, and the octets of these telegrams.
    pub(super) fn of<'a>(radix: Radix, lines: impl Iterator<Item = &'a str>, baud: Baud) -> Option<(Self, usize)> {
        let mut streams: BTreeMap<String, Vec<u8>> = BTreeMap::new();
        // Behind these words stand octets of hexadecimal: a telegram among those that are read as numbers of another radix is a coincidence.
        let mut others: BTreeSet<String> = BTreeSet::new();
        for entry in lines.filter_map(entry) {
            let has_room = streams.len() < MOST_WORDS || streams.contains_key(&entry.words);
            match radix.octet(entry.value) {
                Some(octet) if has_room => streams.entry(entry.words).or_default().push(octet),
                None if is_hexadecimal(entry.value) && others.len() < MOST_WORDS => drop(others.insert(entry.words)),
                _ => {}
            }
        }
        streams.retain(|words, _| !others.contains(words));
        let checked = streams.into_iter().map(|(words, octets)| (words, checked_octets(&octets)));
        let (words, counts): (BTreeSet<String>, Vec<usize>) = checked.filter(|(_, count)| *count > 0).unzip();
        let samples = Samples { baud, samples_per_second: None };
        let lines = Self { radix, words, samples, waiting: Waiting::default() };
        (!counts.is_empty()).then(|| (lines, counts.iter().sum()))
    }

    pub(super) const fn radix(&self) -> Radix {
        self.radix
    }

    /// Reads a line.
    pub(super) fn read(&mut self, line: usize, text: &str, found: &mut Found, ignored: &mut Ignored) {
        let octet = entry(text).and_then(|entry| Some((self.radix.octet(entry.value)?, entry)));
        let Some((octet, entry)) = octet else {
            let lower = text.to_ascii_lowercase();
            if lower.contains("error") {
                self.waiting.mark();
            }
            let is_bit = ["start bit", "stop bit", "parity bit"].iter().any(|name| lower.contains(name))
                || lower.ends_with(" 0")
                || lower.ends_with(" 1");
            ignored.add(if is_bit { IgnoredKind::Bits } else { IgnoredKind::Line }, line, text);
            return;
        };
        if !self.words.contains(&entry.words) {
            found.left_over.push(LeftOver { line, text: shortened(text), octets: 1 });
            return;
        }
        let seconds = entry.time.map(|time| self.samples.seconds(time));
        self.waiting.push(seconds, octet, false, found);
        if !entry.words.is_empty() {
            ignored.add(IgnoredKind::Words, line, text.strip_suffix(entry.value).unwrap_or(text));
        }
    }

    pub(super) fn end(&mut self, found: &mut Found) {
        self.waiting.end(found);
    }
}

/// Whether the value is an octet of two hexadecimal digits.
fn is_hexadecimal(value: &str) -> bool {
    value.len() == 2 && value.bytes().all(|digit| digit.is_ascii_hexdigit())
}

/// The octet at the end of a line, the words before it without direction and numbers, and its time.
fn entry(text: &str) -> Option<Entry<'_>> {
    let text = text.trim_end_matches(['\r', '\n']);
    let (front, value) = match text.rsplit_once(": ") {
        // A space is a character.
        Some((front, " ")) => (front, " "),
        Some((front, rest)) if !rest.trim().contains(char::is_whitespace) && !rest.trim().is_empty() => {
            (front, rest.trim())
        }
        _ => {
            let text = text.trim_end();
            let at = text.rfind(char::is_whitespace).map_or(0, |at| at.saturating_add(1));
            text.split_at_checked(at)?
        }
    };
    let plain = value.trim_end_matches([',', ';', '}', ']']).trim_start_matches(['[', '{']);
    // The brackets of `[10]` and a comma alone are characters.
    let value = if plain.is_empty() || value.starts_with('[') { value } else { plain };
    let (mut words, mut time, mut before): (Vec<String>, Option<Time>, &str) = (Vec::new(), None, "");
    for word in front.split_whitespace() {
        let number = unit(word).and_then(|unit| Some((decimal_number(before)?, unit)));
        before = word;
        if let Some((number, unit)) = number {
            let is_same = |time| matches!(time, Time::Seconds(seconds) if seconds == number);
            if time.is_none_or(is_same) {
                time = Some(Time::Seconds(number * unit));
            }
            continue;
        }
        match (time, samples(word), clock_time(word)) {
            (None, Some(range), _) => time = Some(range),
            (None, None, Some(seconds)) => time = Some(Time::Seconds(seconds)),
            _ if word.bytes().all(|letter| letter.is_ascii_digit() || b"-/.:,".contains(&letter)) => {}
            _ => words.push(direction_free(word)),
        }
    }
    Some(Entry { words: words.join(" "), time, value })
}

/// The word in small letters; one direction is as good as the other, because both are on the same line.
fn direction_free(word: &str) -> String {
    let lower = word.to_ascii_lowercase();
    match lower.trim_matches(|letter: char| !letter.is_ascii_alphanumeric()) {
        "tx" | "rx" | "txd" | "rxd" | "read" | "write" | "sent" | "received" | "in" | "out" => "tx".to_owned(),
        _ => lower,
    }
}

/// `2136-2554`: the samples of the data bits.
fn samples(word: &str) -> Option<Time> {
    let (first, last) = word.split_once('-')?;
    let (first, last) = (first.parse().ok()?, last.parse().ok()?);
    (first < last).then_some(Time::Samples(first, last))
}

/// Converts numbers of samples to seconds.
#[derive(Clone, Debug)]
struct Samples {
    baud: Baud,
    samples_per_second: Option<f64>,
}

impl Samples {
    /// The start of the octet in seconds. The first octet shows the number of samples of eight bits, and so the rate.
    #[expect(clippy::cast_precision_loss, reason = "a number of samples")]
    fn seconds(&mut self, time: Time) -> f64 {
        let (first, last) = match time {
            Time::Seconds(seconds) => return seconds,
            Time::Samples(first, last) => (first as f64, last as f64),
        };
        let bits = f64::from(self.baud.bits_per_second());
        let rate = *self.samples_per_second.get_or_insert_with(|| usual_rate((last - first) / 8.0 * bits));
        // The start bit comes before the data bits.
        (first / rate - 1.0 / bits).max(0.0)
    }
}

/// Rates of logic analysers, as the digits of a power of ten.
const USUAL_RATES: [f64; 16] = [1.0, 1.2, 1.25, 1.5, 1.6, 2.0, 2.4, 2.5, 3.0, 3.2, 4.0, 4.8, 5.0, 6.0, 6.25, 8.0];

/// The usual rate within 2 % of the measured one, or else the measured one.
fn usual_rate(measured: f64) -> f64 {
    let power = 10_f64.powf(measured.log10().floor());
    let usual = USUAL_RATES.iter().map(|digits| digits * power);
    usual.chain([10.0 * power]).find(|rate| (rate / measured - 1.0).abs() < 0.02).unwrap_or(measured)
}

/// A table with a column of octets, as Saleae Logic exports it.
#[derive(Clone, Debug)]
pub(super) struct Table {
    separator: char,
    /// The column of octets, and those that are empty beside it: a table with a column for each direction has an octet in one of them.
    columns: Vec<usize>,
    /// The name of the column of octets.
    name: String,
    radix: Radix,
    time: Option<(usize, f64)>,
    errors: Vec<usize>,
    waiting: Waiting,
}

/// The most columns that are examined.
const MOST_COLUMNS: usize = 16;

impl Table {
    /// The reader for the table whose column has the most octets in telegrams, and their number. The first line has the names of columns.
    pub(super) fn of<'a>(lines: impl Iterator<Item = &'a str> + Clone) -> Option<(Self, usize)> {
        let is_header = |line: &&str| !line.trim().is_empty() && !line.starts_with('#') && !line.starts_with("sep=");
        let header = lines.clone().find(is_header)?;
        let separator = [';', '\t', ','].into_iter().find(|separator| header.contains(*separator))?;
        let names: Vec<String> = fields(header, separator).iter().map(|name| name.to_ascii_lowercase()).collect();
        // DSView begins the name of a column with the number of its channel: `0:UART: RX/TX`.
        let is_value = |name: &String| name.starts_with(|letter: char| letter.is_ascii_digit()) && !name.contains(": ");
        if names.iter().any(is_value) {
            return None;
        }
        let rows: Vec<Vec<String>> = lines.map(|line| fields(line, separator)).collect();
        let score = |(column, radix): (usize, Radix)| {
            let octets = rows.iter().filter_map(|row| radix.octet(row.get(column)?));
            (column, radix, checked_octets(&octets.collect::<Vec<_>>()))
        };
        let columns = (0..names.len().min(MOST_COLUMNS)).flat_map(|column| Radix::ALL.map(|radix| (column, radix)));
        let scores = columns.map(score).filter(|(.., count)| *count > 0);
        let best = scores.reduce(|best, next| if next.2 > best.2 { next } else { best });
        let (column, radix, count) = best?;
        let is_time = |name: &&String| name.contains("time") || name.contains("start");
        let time = names.iter().position(|name| is_time(&name));
        let time = time.map(|at| (at, names.get(at).map_or(1.0, |name| seconds_in_unit(name))));
        let errors: Vec<usize> =
            names.iter().enumerate().filter(|(_, name)| name.contains("error")).map(|(at, _)| at).collect();
        let octet_rows = || rows.iter().filter(|row| row.get(column).is_some_and(|field| radix.octet(field).is_some()));
        let is_empty = |other: usize| octet_rows().all(|row| row.get(other).is_none_or(String::is_empty));
        let is_other = |other: &usize| {
            *other != column && time.is_none_or(|(at, _)| at != *other) && !errors.contains(other) && is_empty(*other)
        };
        let columns = std::iter::once(column).chain((0..names.len().min(MOST_COLUMNS)).filter(is_other)).collect();
        let name = names.get(column).cloned().unwrap_or_default();
        Some((Self { separator, columns, name, radix, time, errors, waiting: Waiting::default() }, count))
    }

    pub(super) const fn radix(&self) -> Radix {
        self.radix
    }

    /// Reads a line.
    pub(super) fn read(&mut self, line: usize, text: &str, found: &mut Found, ignored: &mut Ignored) {
        let fields = fields(text, self.separator);
        let field = |column: usize| fields.get(column).map(String::as_str);
        let Some(octet) = self.columns.iter().find_map(|column| self.radix.octet(field(*column)?)) else {
            let value = self.columns.first().and_then(|column| field(*column)).unwrap_or_default();
            if value.is_empty() || value.eq_ignore_ascii_case(&self.name) {
                ignored.add(IgnoredKind::Line, line, text);
            } else {
                found.left_over.push(LeftOver { line, text: shortened(value), octets: 1 });
            }
            return;
        };
        let time = self.time.and_then(|(column, unit)| Some((field(column)?, unit)));
        let seconds = time.and_then(|(text, unit)| {
            let number =
                text.replace(',', ".").parse::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
            number.map(|number| number * unit).or_else(|| clock_time(text))
        });
        let is_error = |text: &str| !matches!(text.to_ascii_lowercase().as_str(), "" | "0" | "false" | "no" | "none");
        let has_error = self.errors.iter().any(|column| field(*column).is_some_and(is_error));
        self.waiting.push(seconds, octet, has_error, found);
    }

    pub(super) fn end(&mut self, found: &mut Found) {
        self.waiting.end(found);
    }
}

/// The unit in the name of a column of times: `Time [ms]`.
fn seconds_in_unit(name: &str) -> f64 {
    let units = [
        ("[ms]", 1e-3),
        ("[us]", 1e-6),
        ("[µs]", 1e-6),
        ("[ns]", 1e-9),
        ("(ms)", 1e-3),
        ("(us)", 1e-6),
        ("(ns)", 1e-9),
    ];
    units.iter().find(|(unit, _)| name.contains(unit)).map_or(1.0, |(_, seconds)| *seconds)
}

/// The fields of a line, without quotes. A quote within a quoted field is doubled (RFC 4180).
fn fields(line: &str, separator: char) -> Vec<String> {
    let line = line.trim_end_matches(['\r', '\n']);
    let (mut fields, mut field, mut in_quotes) = (Vec::new(), String::new(), false);
    let mut letters: VecDeque<char> = line.chars().collect();
    while let Some(letter) = letters.pop_front() {
        match letter {
            '"' if in_quotes && letters.front() == Some(&'"') => {
                letters.pop_front();
                field.push('"');
            }
            '"' if in_quotes || field.is_empty() => in_quotes = !in_quotes,
            letter if letter == separator && !in_quotes => fields.push(std::mem::take(&mut field)),
            letter => field.push(letter),
        }
    }
    fields.push(field);
    let is_blank = |field: &String| field == " ";
    fields.into_iter().map(|field| if is_blank(&field) { field } else { field.trim().to_owned() }).collect()
}
