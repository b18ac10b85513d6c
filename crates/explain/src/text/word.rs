//! Words of a line: octets in many notations, numbers, times, other text.

use super::checked_octets;
use profivac_sim::describe::octet;
use std::collections::BTreeSet;

/// Meaning of a word.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Meaning {
    /// Octets, maybe with half an octet at one end that has no second digit.
    Octets(Octets),
    /// One digit: an octet without its leading zero, or a number.
    Digit(u8),
    /// An octet that is unreadable or marked with `!`.
    Unreadable(u8),
    /// A time in seconds.
    Time(f64),
    /// Octets in a notation that cannot be read, and their number.
    Strange(usize),
    /// Any other text.
    Other,
}

/// Octets of one word.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Octets {
    pub(super) octets: Vec<u8>,
    /// Digits before and behind the octets, each without a second one.
    pub(super) halves: String,
    /// Two digits that begin with 0: the line has octets with leading zeros.
    pub(super) is_padded: bool,
}

/// A word and its place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Word<'a> {
    pub(super) text: &'a str,
    pub(super) meaning: Meaning,
    /// Number of the column, counted from 0.
    pub(super) column: usize,
    /// In round or square brackets.
    pub(super) in_brackets: bool,
    /// Behind `>`, `<`, TX or RX: octets follow, however few.
    pub(super) is_marked: bool,
}

impl Word<'_> {
    /// Whether the word may be an octet of a row.
    pub(super) const fn is_octet(&self) -> bool {
        matches!(self.meaning, Meaning::Octets(_) | Meaning::Digit(_) | Meaning::Unreadable(_))
    }

    /// Whether the notation says that the word is octets: `0x68`, `$68`, `68h`, `\x68`.
    pub(super) fn has_notation(&self) -> bool {
        let begins = PREFIXES.iter().any(|prefix| self.text.starts_with(prefix));
        begins || self.text.starts_with("\\x") || (self.text.len() == 3 && self.text.ends_with(['h', 'H']))
    }

    /// Whether the word is no word of a language.
    pub(super) fn is_number(&self) -> bool {
        self.text.bytes().any(|letter| !letter.is_ascii_lowercase())
    }

    /// The number of octets that the word may be. A single digit and a word of letters are a number and a word of a language.
    pub(super) fn octet_count(&self) -> usize {
        match &self.meaning {
            Meaning::Octets(octets) if self.is_number() => octets.octets.len(),
            Meaning::Strange(count) => *count,
            Meaning::Octets(_) | Meaning::Digit(_) | Meaning::Unreadable(_) | Meaning::Time(_) | Meaning::Other => 0,
        }
    }
}

/// Meaning of the commas of a text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Commas {
    /// They are between octets.
    #[default]
    Octets,
    /// They are between columns, of which one with this number, counted from 0, has the octets.
    Columns(usize),
    /// Between digits they are decimal commas.
    Numbers,
}

impl Commas {
    /// Whether the letter at a position is a decimal comma.
    pub(super) fn is_in_number(self, text: &str, at: usize) -> bool {
        let is_digit = |at: Option<usize>| at.and_then(|at| text.as_bytes().get(at)).is_some_and(u8::is_ascii_digit);
        let is_comma = text.as_bytes().get(at) == Some(&b',');
        self == Self::Numbers && is_comma && is_digit(at.checked_sub(1)) && is_digit(at.checked_add(1))
    }

    /// Whether a text has a comma between digits.
    pub(super) fn may_be_in_numbers(text: &str) -> bool {
        text.match_indices(',').any(|(at, _)| Self::Numbers.is_in_number(text, at))
    }
}

/// The number of the column of octets if commas divide the columns of a line: one column has several octets with spaces between them, or a
/// telegram, and another one is not empty.
pub(super) fn column_between_commas(line: &str) -> Option<usize> {
    let is_octet = |word: &str| word.len() == 2 && octet(word).is_some();
    let has_telegram = |word: &str| {
        let is_joined = word.len() >= 12 && word.bytes().all(|digit| digit.is_ascii_hexdigit());
        is_joined && checked_octets(&pairs(word, 0).octets) > 0
    };
    let is_row = |column: &str| match column.split_whitespace().count() {
        0 => false,
        1 => has_telegram(column.trim()),
        _ => column.split_whitespace().all(is_octet),
    };
    if !line.contains(',') || line.split(',').filter(|column| !column.trim().is_empty()).count() < 2 {
        return None;
    }
    // Two rows are a request with its answer, or the columns of two directions.
    let is_one = line.split(',').filter(|column| is_row(column)).count() == 1;
    line.split([',', ';', '|', '\t']).position(is_row).filter(|_| is_one)
}

/// Divides the digits of a word into octets. The second argument says whether it is the first word of its line.
pub(super) type Aligned<'a> = dyn Fn(&str, bool) -> Octets + 'a;

/// Divides a line into words.
pub(super) fn words<'a>(line: &'a str, commas: Commas, aligned: &Aligned<'_>) -> Vec<Word<'a>> {
    let (mut words, mut column, mut depth, mut from, mut is_marked) = (Vec::new(), 0, 0_usize, 0, false);
    let comma = decimal_comma(line);
    let is_comma = |at: usize| Some(at) == comma || commas.is_in_number(line, at);
    let ends = line.char_indices().chain([(line.len(), ' ')]);
    for (at, letter) in ends.filter(|(at, letter)| is_separator(*letter) && !is_comma(*at)) {
        let text = line.get(from..at).unwrap_or_default();
        if !text.is_empty() {
            // The b of b"\x68", which is a notation of Python.
            let is_prefix = text.len() == 1 && matches!(letter, '"' | '\'');
            let is_number = is_named_number(line, from, text, words.last());
            let is_other = is_prefix || is_number;
            let meaning = if is_other { Meaning::Other } else { meaning(text, words.is_empty(), aligned) };
            let at = glued(text).filter(|_| !is_other && meaning == Meaning::Other);
            if let Some((front, back)) = at.and_then(|at| text.split_at_checked(at)) {
                let first = self::meaning(front, words.is_empty(), aligned);
                words.push(Word { text: front, meaning: first, column, in_brackets: depth > 0, is_marked });
                let meaning = self::meaning(back, false, aligned);
                words.push(Word {
                    text: back,
                    meaning,
                    column,
                    in_brackets: depth > 0,
                    is_marked: is_direction(front),
                });
            } else {
                words.push(Word { text, meaning, column, in_brackets: depth > 0, is_marked });
            }
            is_marked = is_direction(text);
        }
        match letter {
            ',' if matches!(commas, Commas::Columns(_)) => column = column.saturating_add(1),
            '|' | ';' | '\t' => column = column.saturating_add(1),
            '(' | '[' => depth = depth.saturating_add(1),
            ')' | ']' => depth = depth.saturating_sub(1),
            '<' | '>' => is_marked = true,
            _ => {}
        }
        from = at.saturating_add(letter.len_utf8());
    }
    restore_octets(&mut words);
    find_dates(&mut words);
    find_numbers(&mut words);
    find_units(&mut words);
    if let Commas::Columns(octets) = commas {
        let rows: Vec<usize> = rows_of_columns(&words);
        let is_number = |word: &Word<'_>| {
            word.column != octets
                && !rows.contains(&word.column)
                && word.text.bytes().all(|digit| digit.is_ascii_digit())
        };
        words.iter_mut().filter(|word| is_number(word)).for_each(|word| word.meaning = Meaning::Other);
    }
    words
}

/// The columns that have several words, each of them an octet of two digits: those of the other direction.
fn rows_of_columns(words: &[Word<'_>]) -> Vec<usize> {
    let columns: BTreeSet<usize> = words.iter().map(|word| word.column).collect();
    let is_row = |column: &usize| {
        let mut own = words.iter().filter(|word| word.column == *column);
        own.clone().count() > 1 && own.all(|word| word.text.len() == 2 && octet(word.text).is_some())
    };
    columns.into_iter().filter(is_row).collect()
}

/// Whether a word says who has sent the octets behind it: `TX`, `RX:`.
fn is_direction(word: &str) -> bool {
    let mark = word.rsplit('-').next().unwrap_or_default().trim_end_matches([':', '-']);
    mark.eq_ignore_ascii_case("tx") || mark.eq_ignore_ascii_case("rx")
}

/// The place behind the last colon or hyphen of a word that ends with octets: `TX:10`, `000028-Tx:10`, `Tx:000028-10`. A hyphen in front of
/// octets follows a number or a direction, because names have hyphens too.
fn glued(text: &str) -> Option<usize> {
    let at = text.rfind([':', '-'])?;
    let (front, back) = (text.get(..at)?, text.get(at.saturating_add(1)..)?);
    let is_octets =
        back.len() >= 2 && back.len().is_multiple_of(2) && back.bytes().all(|digit| digit.is_ascii_hexdigit());
    let is_name = match text.as_bytes().get(at) {
        Some(b':') => {
            front.bytes().any(|letter| letter.is_ascii_alphabetic())
                && !front.contains(['.', '/'])
                && !names_a_number(front)
        }
        _ => {
            let number = front.rsplit(':').next().unwrap_or_default();
            let is_number =
                !number.is_empty() && number.bytes().all(|letter| letter.is_ascii_digit() || letter == b'.');
            back.len() == 2 && (is_direction(front) || is_number)
        }
    };
    (is_octets && is_name).then_some(at.saturating_add(1))
}

/// Names of numbers that stand in front of octets: `len:06`, `seq:0001`.
const NUMBER_NAMES: [&str; 26] = [
    "addr", "address", "bytes", "ch", "channel", "count", "frame", "from", "id", "idx", "index", "len", "length",
    "line", "no", "num", "number", "octets", "offset", "packet", "pkt", "port", "pos", "seq", "size", "to",
];

/// Whether the word, or its last part, is the name of a number that is no octet of a telegram.
pub(super) fn names_a_number(word: &str) -> bool {
    let last = word.trim_end_matches(':').rsplit(['_', '-', '.', ':']).next().unwrap_or_default();
    NUMBER_NAMES.iter().any(|name| last.eq_ignore_ascii_case(name))
}

/// Numbers beside octets are none: a clock that is not the first word, a date, the seconds since 1970, a number in the first column, an
/// address with `0x`.
fn find_numbers(words: &mut [Word<'_>]) {
    let sign = |text: &str| text.contains([':', '-', '_', '.']);
    let is_plain = |word: &Word<'_>| word.is_octet() && !sign(word.text);
    if !words.iter().any(is_plain) {
        return;
    }
    // The last number of a line is no time: nothing else would be its octets.
    let mut others = words.iter().filter(|word| word.is_octet()).count().saturating_sub(1);
    for word in words.iter_mut().filter(|word| matches!(word.meaning, Meaning::Octets(_))) {
        if sign(word.text) {
            match time(word.text, true).filter(|_| word.text.contains(':')) {
                Some(seconds) => word.meaning = Meaning::Time(seconds),
                None if is_date(word.text) => word.meaning = Meaning::Other,
                None => {}
            }
        } else if let Some(seconds) = seconds_since_1970(word).filter(|_| others > 0) {
            word.meaning = Meaning::Time(seconds);
            others = others.saturating_sub(1);
        }
    }
    for at in 0..words.len().saturating_sub(1) {
        let Some([word, next]) = words.get(at..at.saturating_add(2)) else { continue };
        let is_pair = next.is_octet() && next.text.len() == 2 && word.column == next.column;
        let is_address = word.text.starts_with("0x") && word.text.len() >= 6;
        let is_first_number = at == 0 && is_long_number(word);
        if is_pair
            && (is_address || is_first_number)
            && let Some(word) = words.get_mut(at)
        {
            word.meaning = Meaning::Other;
        }
    }
}

/// A number in front of a unit of time is no octet, and in front of the octets it is their time: `12.5 us`, `5 ms:`.
fn find_units(words: &mut [Word<'_>]) {
    let first = words.iter().position(Word::is_octet).unwrap_or(words.len());
    for at in 1..words.len() {
        let Some([number, name]) = words.get_mut(at.saturating_sub(1)..=at) else { continue };
        let Some(seconds) = unit(name.text) else { continue };
        if let Some(count) = decimal_number(number.text) {
            let is_time = at <= first.saturating_add(1);
            number.meaning = if is_time { Meaning::Time(count * seconds) } else { Meaning::Other };
            name.meaning = Meaning::Other;
        }
    }
}

/// The seconds in a unit of time behind a number.
pub(super) fn unit(word: &str) -> Option<f64> {
    Some(match word.trim_end_matches(':') {
        "ms" => 1e-3,
        "us" | "\u{B5}s" | "\u{3BC}s" => 1e-6,
        "ns" => 1e-9,
        _ => return None,
    })
}

/// The number of a word of decimal digits, maybe with a point or a comma.
pub(super) fn decimal_number(word: &str) -> Option<f64> {
    let digits = word.replace(',', ".");
    let is_number = digits.bytes().all(|letter| letter.is_ascii_digit() || letter == b'.');
    digits.parse().ok().filter(|_| is_number)
}

/// Whether a word is a decimal number that is no pair of digits and has no telegram.
fn is_long_number(word: &Word<'_>) -> bool {
    let is_number = word.text.len() >= 3 && word.text.bytes().all(|digit| digit.is_ascii_digit());
    is_number && matches!(&word.meaning, Meaning::Octets(octets) if checked_octets(&octets.octets) == 0)
}

/// The seconds of a number that counts seconds since 1970, or thousandths or millionths or billionths of them, after 2001 and before 2033.
fn seconds_since_1970(word: &Word<'_>) -> Option<f64> {
    let unit = match word.text.len() {
        10 => 1.0,
        13 => 1e-3,
        16 => 1e-6,
        19 => 1e-9,
        _ => return None,
    };
    let number: f64 = word.text.parse().ok().filter(|_| is_long_number(word) && word.text.starts_with('1'))?;
    Some(number * unit)
}

/// Names of numbers that programs write beside octets, as socat does: `length=11 from=12 to=22`. Behind the first four no octets follow
/// without a sign between.
const NUMBERS: [&str; 7] = ["length", "len", "size", "count", "from", "to", "offset"];
const CERTAIN: usize = 4;

/// Whether a number without a sign between follows this word: `Length 3:`.
pub(super) fn has_number_behind(word: &str) -> bool {
    NUMBERS.contains(&word.trim_end_matches(':').to_ascii_lowercase().as_str())
}

/// Whether the word that begins at `from` is the number of a name: `length=6`, `Length: 0006`, `Length 11:`, `octets_len = 27`, the size in
/// `octets[27] =`, or a number of three digits and more alone in parentheses.
fn is_named_number(line: &str, from: usize, text: &str, before: Option<&Word<'_>>) -> bool {
    let Some(before) = before.filter(|before| before.meaning == Meaning::Other) else { return false };
    let digits = text.strip_suffix(':').unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|digit| digit.is_ascii_digit()) {
        return false;
    }
    let front = line.get(..from).unwrap_or_default();
    let behind = line.get(from.saturating_add(text.len())..).unwrap_or_default();
    let is_size = behind.strip_prefix(']').is_some_and(|behind| behind.trim_start().starts_with('='));
    if (front.ends_with('[') && is_size) || (front.ends_with('(') && behind.starts_with(')') && text.len() >= 3) {
        return true;
    }
    let has_equals = front.trim_end().ends_with('=');
    let name = before.text.trim_end_matches(':').to_ascii_lowercase();
    let has_sign = has_equals || before.text.ends_with(':');
    let is_name = |number: &&str| name == **number || (has_equals && name.ends_with(&format!("_{number}")));
    let at = NUMBERS.iter().position(is_name);
    at.is_some_and(|at| has_sign || at < CERTAIN)
}

/// The position of a decimal comma: in a clock time with thousandths, or in a number that fills the first column of a line.
fn decimal_comma(line: &str) -> Option<usize> {
    let (at, _) = line.match_indices(',').next()?;
    let (front, back) = (line.get(..at)?, line.get(at.saturating_add(1)..)?);
    let digits = back.bytes().take_while(u8::is_ascii_digit).count();
    let end = back.get(digits..).and_then(|rest| rest.chars().next());
    let word = front.rsplit(|letter: char| letter.is_whitespace() || "[(".contains(letter)).next()?;
    let is_clock = word.len() == 8 && time(word, true).is_some() && digits % 3 == 0;
    let is_column = matches!(end, Some(';' | '\t')) && front.bytes().all(|letter| letter.is_ascii_digit());
    (digits > 0 && (is_clock || (is_column && !front.is_empty()))).then_some(at)
}

/// The months as the logs of Unix write them.
pub(super) const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// A clock behind a date is a time, and the date is no octets: `2026-11-29 08:15:00`, `29.11.26 08:15:00`, `Nov 29 08:15:00`.
fn find_dates(words: &mut [Word<'_>]) {
    for at in 1..words.len() {
        let Some([date, clock]) = words.get(at.saturating_sub(1)..=at) else { continue };
        let month = at.checked_sub(2).and_then(|at| words.get(at)).map(|word| word.text);
        let is_day = date.text.len() <= 2 && month.is_some_and(|month| MONTHS.contains(&month));
        let is_clock = clock.text.contains(':') && (is_day || is_date(date.text));
        let is_of_socat = words.get(at.saturating_add(1)).is_some_and(|word| word.text == "length");
        let seconds = time_of_socat(clock.text).filter(|_| is_of_socat).or_else(|| time(clock.text, true));
        let seconds = seconds.filter(|_| is_clock);
        if let (Some(seconds), Some([date, clock])) = (seconds, words.get_mut(at.saturating_sub(1)..=at)) {
            (date.meaning, clock.meaning) = (Meaning::Other, Meaning::Time(seconds));
        }
    }
}

/// socat 1.7.4 writes microseconds with nine digits: `12:00:00.000250000` is a quarter of a second behind twelve. Other versions write six.
fn time_of_socat(clock: &str) -> Option<f64> {
    let (whole, fraction) = clock.split_once('.')?;
    let microseconds: f64 = fraction.strip_prefix("000").filter(|_| fraction.len() == 9)?.parse().ok()?;
    Some(time(whole, true)? + microseconds / 1e6)
}

/// Three numbers with a sign between them.
fn is_date(text: &str) -> bool {
    ['-', '.', '/'].iter().any(|sign| {
        let groups: Vec<&str> = text.split(*sign).collect();
        let is_number = |group: &&str| group.bytes().all(|letter| letter.is_ascii_digit());
        let has_year = *sign != '-' || groups.iter().any(|group| group.len() == 4);
        let is_possible = |group: &&str| is_number(group) && matches!(group.len(), 1 | 2 | 4);
        groups.len() == 3 && has_year && groups.iter().all(is_possible)
    })
}

pub(super) fn is_separator(letter: char) -> bool {
    letter.is_whitespace() || ",[](){}<>\"'=|;".contains(letter)
}

/// A time is one only beside octets in another notation: `08:15:00` alone is three octets, and so is each word among others
/// like it.
fn restore_octets(words: &mut [Word<'_>]) {
    let separator = |text: &str| text.chars().find(|letter| ":.".contains(*letter));
    // A set, because a line may have thousands of words of either kind.
    let notations: BTreeSet<Option<char>> = words
        .iter()
        .filter(|word| matches!(word.meaning, Meaning::Octets(_)))
        .map(|word| separator(word.text))
        .collect();
    for word in words.iter_mut().filter(|word| matches!(word.meaning, Meaning::Time(_))) {
        if (notations.is_empty() || notations.contains(&separator(word.text)))
            && let Some(octets) = separated(word.text)
        {
            word.meaning = Meaning::Octets(octets);
        }
    }
}

fn meaning(word: &str, is_first: bool, aligned: &Aligned<'_>) -> Meaning {
    if let Some(time) = time(word, is_first) {
        return Meaning::Time(time);
    }
    let (plain, is_damaged) = word.strip_suffix('!').map_or((word, false), |plain| (plain, true));
    match (octets_of(plain, is_first, aligned), is_damaged) {
        (Some(Octets { octets, .. }), true) => {
            octets.first().map_or(Meaning::Other, |octet| Meaning::Unreadable(*octet))
        }
        (Some(octets), false) => Meaning::Octets(octets),
        (None, _) => other(plain),
    }
}

fn other(word: &str) -> Meaning {
    let unknown = |letter: &u8| b"?xX.*_-".contains(letter);
    match word.as_bytes() {
        [digit] if digit.is_ascii_hexdigit() => u8::from_str_radix(word, 16).map_or(Meaning::Other, Meaning::Digit),
        // A letter beside a digit, or two signs for an unknown digit.
        [first, second]
            if (unknown(first) && unknown(second))
                || (first.is_ascii_digit() && (second.is_ascii_alphanumeric() || *second == b'?'))
                || (second.is_ascii_digit() && (first.is_ascii_alphanumeric() || *first == b'?')) =>
        {
            Meaning::Unreadable(0)
        }
        _ => match word.matches("\\x").count() {
            // An octet where a text was cut, or a number of a line.
            0 => word.strip_suffix(':').and_then(octet).map_or(Meaning::Other, |_| Meaning::Strange(1)),
            count => Meaning::Strange(count),
        },
    }
}

/// What languages write in front of hexadecimal digits: C, assemblers, Visual Basic, IEC 61131-3.
pub(super) const PREFIXES: [&str; 7] = ["0x", "0X", "$", "&H", "&h", "16#", "B#16#"];

/// `68`, `0x68`, `68h`, `$68`, `\x68\x05`, `680505`, `68:05:05`, `68-05-05`.
fn octets_of(word: &str, is_first: bool, aligned: &Aligned<'_>) -> Option<Octets> {
    if word.contains("\\x") {
        // The begin or the end of the text may be within an octet.
        let whole = word.trim_start_matches('x').trim_end_matches('\\');
        let groups = whole.split("\\x").filter(|digits| !digits.is_empty());
        let octets: Option<Vec<u8>> = groups.map(one_or_two_digits).collect();
        return octets.map(|octets| Octets { octets, ..Octets::default() });
    }
    let prefix = PREFIXES.iter().find_map(|prefix| word.strip_prefix(prefix));
    if let Some(digits) = prefix {
        let single = one_or_two_digits(digits).map(|octet| Octets { octets: vec![octet], ..Octets::default() });
        return single.or_else(|| digit_pairs(digits, is_first, aligned));
    }
    if let Some(octet) = word.strip_suffix(['h', 'H']).and_then(octet) {
        return Some(Octets { octets: vec![octet], ..Octets::default() });
    }
    separated(word).or_else(|| digit_pairs(word, is_first, aligned))
}

fn one_or_two_digits(digits: &str) -> Option<u8> {
    let is_octet = matches!(digits.len(), 1 | 2) && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    u8::from_str_radix(digits, 16).ok().filter(|_| is_octet)
}

/// Octets with a sign between them. Where a text was cut, the first or the last one may have one digit or none.
fn separated(word: &str) -> Option<Octets> {
    let sign = [':', '-', '_', '.'].into_iter().find(|sign| word.contains(*sign))?;
    let groups: Vec<&str> = word.split(sign).collect();
    let (mut octets, last) = (Vec::new(), groups.len().checked_sub(1)?);
    for (number, group) in groups.iter().enumerate() {
        let is_cut = (number == 0 || number == last) && group.len() < 2 && sign != '.';
        match octet(group) {
            Some(octet) => octets.push(octet),
            None if is_cut && group.is_empty() => {}
            None if is_cut => octets.push(one_or_two_digits(group)?),
            None => return None,
        }
    }
    let is_octets =
        groups.iter().any(|group| group.len() == 2) && groups.len() > 1 && !(word.ends_with(':') && groups.len() == 2);
    is_octets.then(|| Octets { octets, ..Octets::default() })
}

/// Octets from pairs of digits without separators. A digit is left over if their number is odd: at least three digits, one of
/// them decimal, because `bed` is a word.
fn digit_pairs(word: &str, is_first: bool, aligned: &Aligned<'_>) -> Option<Octets> {
    let is_hexadecimal = word.bytes().all(|digit| digit.is_ascii_hexdigit());
    let is_even = word.len().is_multiple_of(2);
    if !is_hexadecimal || word.len() < 2 || (!is_even && !word.bytes().any(|digit| digit.is_ascii_digit())) {
        return None;
    }
    let octets = aligned(word, is_first);
    Some(Octets { is_padded: word.len() == 2 && word.starts_with('0'), ..octets })
}

/// The octets of a word of digits. The first `skip` digits and an odd last one are left over.
pub(super) fn pairs(digits: &str, skip: usize) -> Octets {
    let rest = digits.get(skip..).unwrap_or_default();
    let octets = rest.as_bytes().chunks_exact(2).filter_map(|pair| octet(std::str::from_utf8(pair).ok()?)).collect();
    let back = digits.chars().next_back().filter(|_| rest.len() % 2 == 1);
    Octets { octets, halves: digits.chars().take(skip).chain(back).collect(), is_padded: false }
}

/// A time in seconds in any place of a line: a clock, or a number with a point or a comma.
pub(super) fn clock_time(word: &str) -> Option<f64> {
    let is_fraction = |text: &str| !text.is_empty() && text.bytes().all(|letter| letter.is_ascii_digit());
    let word = word.trim_matches(['[', ']', '(', ')']);
    let is_time = word.split_once(',').is_none_or(|(_, fraction)| is_fraction(fraction));
    time(word, true).filter(|_| is_time)
}

/// A time in seconds: `12.345`, `[12.345]`, `12.345s`, `12.5us`, `08:15:00.25`, a first word `08:15:00`; a date with `T` may precede it.
fn time(word: &str, is_first: bool) -> Option<f64> {
    let point = word.contains(',').then(|| word.replacen(',', ".", 1));
    let word = point.as_deref().unwrap_or(word);
    let clock = word.rsplit_once('T').map_or(word, |(_, clock)| clock).trim_end_matches(['Z', ':']);
    let groups: Vec<&str> = clock.split(':').collect();
    if let [hours, minutes, seconds] = groups[..] {
        let has_fraction = seconds.contains('.') || (is_first && clock.len() == 8);
        let (hours, minutes, seconds): (f64, f64, f64) =
            (hours.parse().ok()?, minutes.parse().ok()?, seconds.parse().ok()?);
        let is_possible = hours < 24.0 && minutes < 60.0 && seconds < 61.0;
        return (has_fraction && is_possible).then_some(hours * 3600.0 + minutes * 60.0 + seconds);
    }
    let number = word.trim_end_matches([':', 's']);
    let (number, unit) = match number.find(char::is_alphabetic).and_then(|at| word.split_at_checked(at)) {
        Some((number, name)) => (number, unit(name)?),
        None => (number, 1.0),
    };
    let (whole, fraction) = number.split_once('.')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|letter| letter.is_ascii_digit());
    let seconds = || number.parse::<f64>().ok().map(|number| number * unit);
    (is_first && is_number(whole) && is_number(fraction)).then(seconds)?
}
