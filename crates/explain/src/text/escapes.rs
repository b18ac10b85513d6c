//! Octets in quoted strings with escapes: literals of Python, strings of C and JSON, and the calls that strace prints.

use super::ignored::{Ignored, IgnoredKind, shortened};
use super::word::{clock_time, unit};
use super::{Found, LeftOver, Row};
use std::collections::BTreeMap;

/// Which strings are octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quoted {
    /// Literals of Python: `b'\x10\x08I'`.
    Literals,
    /// All strings: C and JSON have no prefix.
    All,
    /// Both.
    Any,
}

/// A string of a line.
#[derive(Debug, Default)]
struct Text {
    octets: Vec<u8>,
    /// Positions of the letters that are no octet.
    errors: Vec<usize>,
}

/// Reads the strings of a log as octets. A part of a long line may end within a string.
#[derive(Clone, Debug)]
pub(super) struct Strings {
    quoted: Quoted,
    /// The quote of the string in which the last part has ended.
    open: Option<char>,
}

impl Strings {
    pub(super) const fn new(quoted: Quoted) -> Self {
        Self { quoted, open: None }
    }

    /// Reads a line or a part of it: each string is a row.
    pub(super) fn read(&mut self, line: usize, text: &str, is_last: bool, found: &mut Found, ignored: &mut Ignored) {
        let seconds = time_before(text);
        let (mut rest, mut has_rows, mut outside) = (text, false, String::new());
        loop {
            let quote = match self.open.take() {
                Some(quote) => quote,
                None => match self.begin(rest) {
                    Some((front, quote, behind)) => {
                        outside += front;
                        rest = behind;
                        quote
                    }
                    None => break,
                },
            };
            let (string, behind) = unescaped(rest, quote);
            if behind.is_none() && !is_last {
                self.open = Some(quote);
            }
            if !string.octets.is_empty() {
                has_rows = true;
                let is_continued = self.open.is_some();
                let Text { octets, errors } = string;
                found.rows.push_back(Row { seconds, octets, errors, is_continued, times: 1 });
            }
            match behind {
                Some(behind) => rest = behind,
                None => {
                    rest = "";
                    break;
                }
            }
        }
        outside += rest;
        if !outside.trim().is_empty() {
            ignored.add(if has_rows { IgnoredKind::Words } else { IgnoredKind::Line }, line, &outside);
        }
    }

    /// The text before the next string, its quote, and the text behind the quote.
    fn begin<'a>(&self, text: &'a str) -> Option<(&'a str, char, &'a str)> {
        let is_begin = |at: usize, quote: char| match self.quoted {
            Quoted::All => quote == '"',
            Quoted::Literals => text.get(..at).is_some_and(is_literal),
            Quoted::Any => quote == '"' || text.get(..at).is_some_and(is_literal),
        };
        let (at, quote) =
            text.char_indices().find(|(at, letter)| matches!(letter, '"' | '\'') && is_begin(*at, *letter))?;
        Some((text.get(..at)?, quote, text.get(at.saturating_add(1)..)?))
    }
}

/// Whether the text ends with the `b` of a literal, and not with a word that ends so.
fn is_literal(front: &str) -> bool {
    let Some(front) = front.strip_suffix(['b', 'B']) else { return false };
    !front.ends_with(|letter: char| letter.is_alphanumeric() || letter == '_')
}

/// The octets of a string up to its closing quote, and the text behind it; `None` if the text ends before.
fn unescaped(text: &str, quote: char) -> (Text, Option<&str>) {
    let mut string = Text::default();
    let mut letters = text.char_indices();
    while let Some((at, letter)) = letters.next() {
        if letter == quote {
            return (string, text.get(at.saturating_add(1)..));
        }
        if letter != '\\' {
            string.push_letter(letter);
            continue;
        }
        let Some((_, kind)) = letters.next() else { break };
        match kind {
            'x' => string.push_digits(&mut letters, 16, 2, ""),
            'u' => string.push_digits(&mut letters, 16, 4, ""),
            '0'..='7' => string.push_digits(&mut letters, 8, 2, kind.encode_utf8(&mut [0; 4])),
            _ => match simple(kind) {
                Some(octet) => string.octets.push(octet),
                // Python keeps the backslash of an escape that it does not know.
                None => {
                    string.octets.push(b'\\');
                    string.push_letter(kind);
                }
            },
        }
    }
    (string, None)
}

/// The octet of an escape of one letter.
const fn simple(letter: char) -> Option<u8> {
    Some(match letter {
        'a' => 7,
        'b' => 8,
        't' => 9,
        'n' => 10,
        'v' => 11,
        'f' => 12,
        'r' => 13,
        'e' => 27,
        '\\' | '\'' | '"' | '/' => letter as u8,
        _ => return None,
    })
}

impl Text {
    /// Adds a letter; one beyond ASCII is no octet of a line.
    fn push_letter(&mut self, letter: char) {
        match u8::try_from(letter) {
            Ok(octet) if letter.is_ascii() => self.octets.push(octet),
            _ => self.push_error(),
        }
    }

    fn push_error(&mut self) {
        self.errors.push(self.octets.len());
        self.octets.push(0);
    }

    /// Adds the octet of `first` and at most `most` digits of `letters`.
    fn push_digits(&mut self, letters: &mut std::str::CharIndices<'_>, radix: u32, most: usize, first: &str) {
        let more: String = letters.as_str().chars().take(most).take_while(|letter| letter.is_digit(radix)).collect();
        for _ in more.chars() {
            letters.next();
        }
        match u8::from_str_radix(&format!("{first}{more}"), radix) {
            Ok(octet) => self.octets.push(octet),
            Err(_) => self.push_error(),
        }
    }
}

/// The first time in the text before the first string.
fn time_before(text: &str) -> Option<f64> {
    let front = text.split(['"', '\'']).next().unwrap_or_default();
    let mut words = front.split(|letter: char| letter.is_whitespace() || "[](){},".contains(letter));
    let seconds = words.find_map(clock_time)?;
    Some(seconds * words.next().and_then(unit).unwrap_or(1.0))
}

/// The calls that transfer octets: their arguments begin with a descriptor and a string.
const TRANSFERS: [&str; 14] = [
    "read", "write", "pread64", "pwrite64", "readv", "writev", "preadv", "pwritev", "recv", "send", "recvfrom",
    "sendto", "recvmsg", "sendmsg",
];

/// The last descriptor of a program that is not its line: standard input, output and errors.
const STANDARD_ERROR: u32 = 2;

/// Reads the calls that strace prints.
#[derive(Clone, Debug, Default)]
pub(super) struct Calls {
    /// The file of a descriptor, from the call that opened it.
    files: BTreeMap<u32, String>,
    /// The descriptor of a call that is not finished, for each process.
    unfinished: BTreeMap<String, u32>,
}

/// The most descriptors and processes that are kept.
const MOST_KEPT: usize = 1 << 10;

impl Calls {
    /// Reads a line: the octets that a call has transferred are a row. Another line is ignored.
    pub(super) fn read(&mut self, line: usize, text: &str, found: &mut Found, ignored: &mut Ignored) {
        let row = self.row(line, text, found);
        let kind = if row.is_some() { IgnoredKind::Words } else { IgnoredKind::Line };
        let front = text.split('"').next().unwrap_or_default();
        ignored.add(kind, line, if row.is_some() { front } else { text });
        found.rows.extend(row);
    }

    fn row(&mut self, line: usize, text: &str, found: &mut Found) -> Option<Row> {
        let (call, arguments, process) = call_of(text)?;
        self.open(call, text);
        let descriptor = if text.contains("resumed>") {
            self.unfinished.remove(process)?
        } else {
            let digits: String = arguments.chars().take_while(char::is_ascii_digit).collect();
            digits.parse().ok()?
        };
        // The octets of a read follow when it is resumed; a write has printed them.
        if text.contains("<unfinished") && self.unfinished.len() < MOST_KEPT {
            self.unfinished.insert(process.to_owned(), descriptor);
        }
        if call == "close" {
            // The next call that returns this number may open a connection, whose path no line has.
            self.files.remove(&descriptor);
            return None;
        }
        let path = arguments.split_once('<').filter(|(digits, _)| digits.parse() == Ok(descriptor));
        let path = path.and_then(|(_, rest)| rest.split('>').next());
        let path = path.or_else(|| self.files.get(&descriptor).map(String::as_str));
        if !TRANSFERS.contains(&call) || descriptor <= STANDARD_ERROR || path.is_some_and(|path| !is_line(path)) {
            return None;
        }
        let (string, behind) = strings_of(text)?;
        let result = behind.rsplit_once("= ").and_then(|(_, result)| result.split_whitespace().next());
        let count = match result.map(str::parse::<i64>) {
            Some(Ok(count)) => usize::try_from(count).ok()?,
            _ if text.contains("<unfinished") => string.octets.len(),
            _ => return None,
        };
        let Text { mut octets, mut errors } = string;
        if let Some(missing) = count.checked_sub(octets.len()).filter(|missing| *missing > 0) {
            let text = shortened(&format!("{missing} octets that strace -s 300 prints"));
            found.left_over.push(LeftOver { line, text, octets: missing });
        }
        octets.truncate(count);
        errors.retain(|at| *at < count);
        let seconds = text.split(call).next().and_then(time_before);
        (!octets.is_empty()).then_some(Row { seconds, octets, errors, is_continued: false, times: 1 })
    }

    /// Keeps the file that a call opens.
    fn open(&mut self, call: &str, text: &str) {
        let result =
            text.rsplit_once("= ").and_then(|(_, result)| result.split(['<', ' ']).next()?.parse::<u32>().ok());
        let path = text.split('"').nth(1);
        if let ("open" | "openat", Some(descriptor), Some(path)) = (call, result, path)
            && self.files.len() < MOST_KEPT
        {
            self.files.insert(descriptor, path.to_owned());
        }
    }
}

/// Whether a path may be a line: a device, or a connection.
fn is_line(path: &str) -> bool {
    path.starts_with("/dev/") || !path.starts_with('/')
}

/// The name of the call of a line, its arguments, and the process before it.
fn call_of(text: &str) -> Option<(&str, &str, &str)> {
    if let Some((front, rest)) = text.split_once("<... ") {
        let (call, behind) = rest.split_once(" resumed>")?;
        return Some((call, behind, process_of(front)));
    }
    let (front, arguments) = text.split_once('(')?;
    let name = front.rsplit(char::is_whitespace).next()?;
    let is_name = !name.is_empty() && name.bytes().all(|letter| letter.is_ascii_alphanumeric() || letter == b'_');
    is_name.then(|| (name, arguments, process_of(front)))
}

/// The number of the process in front of a call: `[pid 12]` or `12`.
fn process_of(front: &str) -> &str {
    let words = front.split(|letter: char| letter.is_whitespace() || "[]".contains(letter));
    words.into_iter().find(|word| !word.is_empty() && word.bytes().all(|letter| letter.is_ascii_digit())).unwrap_or("")
}

/// The octets of all strings of a call, and the text behind the last one. Strings of an address are none: those within further
/// parentheses, as in `sin_addr=inet_addr("10.0.0.1")`, and paths of sockets.
fn strings_of(text: &str) -> Option<(Text, &str)> {
    let (mut all, mut rest, mut depth, mut is_found) = (Text::default(), text, 0_usize, false);
    while let Some((front, behind)) = rest.split_once('"') {
        depth = depth.saturating_add(front.matches('(').count()).saturating_sub(front.matches(')').count());
        let (string, behind) = unescaped(behind, '"');
        rest = behind?;
        if depth > 1 || front.ends_with("sun_path=") || front.ends_with("sun_path=@") {
            continue;
        }
        is_found = true;
        let from = all.octets.len();
        all.errors.extend(string.errors.iter().map(|at| at.saturating_add(from)));
        all.octets.extend(string.octets);
    }
    is_found.then_some((all, rest))
}
