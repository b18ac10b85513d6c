//! Text to lines of tokens. Nothing is dropped: the pieces of a file are its text.

use crate::problem::{Fault, Problem};
use std::ops::Range;

/// A token and its place in the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) kind: Kind,
    pub(crate) span: Range<usize>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Number(u64),
    Text(String),
    Word,
    Equals,
    Open,
    Close,
    Comma,
    Minus,
}

/// A logical line: its tokens, with the octets of the file that belong to it.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// The number of the physical line where it starts, from 1.
    pub(crate) number: usize,
    pub(crate) span: Range<usize>,
    pub(crate) tokens: Vec<Token>,
}

/// The keyword that starts the section of PROFIBUS DP, in small letters.
pub(crate) const HEADER: &str = "#profibus_dp";

/// A keyword with a character in front that joins no line before it.
const BLANKS: &[u8] = b" \t\x0b\x0c\x1a\0";

pub(crate) struct Lexer<'a> {
    text: &'a str,
    octets: &'a [u8],
    at: usize,
    line: usize,
    /// A part of a physical line up to its end: a line of many texts asks for its end at each of them.
    measured: Range<usize>,
    tokens: Vec<Token>,
    pub(crate) problems: Vec<Problem>,
    /// Octets looked at, the measure of the work.
    pub(crate) steps: usize,
}

impl<'a> Lexer<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        let octets = text.as_bytes();
        Self { text, octets, at: 0, line: 1, measured: 0..0, tokens: Vec::new(), problems: Vec::new(), steps: 0 }
    }

    /// The next logical line; none at the end of the text.
    pub(crate) fn next_line(&mut self) -> Option<Line> {
        (self.at < self.octets.len()).then(|| {
            let (start, number) = (self.at, self.line);
            while self.step() {}
            Line { number, span: start..self.at, tokens: std::mem::take(&mut self.tokens) }
        })
    }

    fn peek(&self) -> Option<u8> {
        self.octets.get(self.at).copied()
    }

    fn octet(&self, at: usize) -> Option<u8> {
        self.octets.get(at).copied()
    }

    fn fault(&mut self, fault: Fault, found: &str) {
        self.problems.push(Problem::new(self.line, fault, found));
    }

    /// Reads one token. False at the end of the logical line.
    fn step(&mut self) -> bool {
        let Some(octet) = self.peek() else { return false };
        match octet {
            b'\n' | b'\r' => return self.end_of_line(),
            b';' => self.at = self.end_of_text_line(self.at),
            b'\\' => return self.backslash(),
            b'"' => self.string(),
            b'=' => self.single(Kind::Equals),
            b'(' => self.single(Kind::Open),
            b')' => self.single(Kind::Close),
            b',' => self.single(Kind::Comma),
            b'-' => self.single(Kind::Minus),
            _ if BLANKS.contains(&octet) => self.advance(1),
            _ if self.text.get(self.at..).is_some_and(|rest| rest.starts_with('\u{a0}')) => self.advance(2),
            _ => self.word(),
        }
        true
    }

    fn advance(&mut self, octets: usize) {
        self.at = self.at.saturating_add(octets).min(self.octets.len());
        self.steps = self.steps.saturating_add(octets);
    }

    fn single(&mut self, kind: Kind) {
        self.tokens.push(Token { kind, span: self.at..self.at.saturating_add(1) });
        self.advance(1);
    }

    /// The position of the end of the physical line, before its end-of-line characters.
    fn end_of_text_line(&mut self, from: usize) -> usize {
        if !self.measured.contains(&from) {
            let rest = self.octets.get(from..).unwrap_or_default();
            let length = rest.iter().position(|octet| matches!(octet, b'\n' | b'\r')).unwrap_or(rest.len());
            self.steps = self.steps.saturating_add(length);
            self.measured = from..from.saturating_add(length);
        }
        self.measured.end
    }

    /// Passes over `\n`, `\r` or `\r\n`.
    fn pass_line_end(&mut self) {
        let pair = self.peek() == Some(b'\r') && self.octet(self.at.saturating_add(1)) == Some(b'\n');
        self.advance(if pair { 2 } else { 1 });
        self.line = self.line.saturating_add(1);
    }

    /// A list goes on if it ends with a comma and the next line starts with a number, also without the sign for it.
    fn end_of_line(&mut self) -> bool {
        let open_list = self.tokens.last().is_some_and(|last| last.kind == Kind::Comma);
        self.pass_line_end();
        let next = self.skip_blanks(self.at);
        let goes_on = open_list && self.continues_list(next);
        if goes_on {
            self.fault(Fault::ListWithoutContinuation, "");
        }
        goes_on
    }

    /// Whether a number starts here, and neither a keyword like `9.6_supp` nor the number of the module that was just named.
    /// chosen: a hexadecimal number in a line of its own is an octet of the module.
    fn continues_list(&mut self, start: usize) -> bool {
        let length = self.word_length(start);
        self.steps = self.steps.saturating_add(length);
        let word = self.octets.get(start..start.saturating_add(length)).unwrap_or_default();
        let alone = word.iter().all(u8::is_ascii_digit) && {
            let after = self.skip_blanks(start.saturating_add(length));
            self.at_line_end(after) || self.octet(after) == Some(b';')
        };
        number(word).is_some() && !(alone && self.names_module())
    }

    fn names_module(&self) -> bool {
        let first = self.tokens.first().and_then(|token| self.text.get(token.span.clone()));
        first.is_some_and(|word| word.eq_ignore_ascii_case("module"))
    }

    fn skip_blanks(&mut self, from: usize) -> usize {
        let rest = self.octets.get(from..).unwrap_or_default();
        let length = rest.iter().position(|octet| !BLANKS.contains(octet)).unwrap_or(rest.len());
        self.steps = self.steps.saturating_add(length);
        from.saturating_add(length)
    }

    /// A continuation, if only blanks and a comment follow.
    fn backslash(&mut self) -> bool {
        let next = self.skip_blanks(self.at.saturating_add(1));
        match self.octet(next) {
            Some(b';' | b'\n' | b'\r') => self.continuation(next),
            None => {
                self.at = self.octets.len();
                true
            }
            Some(_) => {
                self.fault(Fault::StrayBackslash, "");
                self.advance(1);
                true
            }
        }
    }

    fn continuation(&mut self, next: usize) -> bool {
        let line = self.line;
        if self.octet(next) == Some(b';') {
            self.fault(Fault::CommentBehindContinuation, "");
        } else if next > self.at.saturating_add(1) {
            self.fault(Fault::BlankBehindContinuation, "");
        }
        self.at = self.end_of_text_line(next);
        self.pass_line_end();
        if self.tokens.is_empty() {
            return false;
        }
        self.pass_comments();
        let start = self.skip_blanks(self.at);
        let ends = self.at_line_end(start) || self.starts_statement(start);
        if ends {
            self.problems.push(Problem::new(line, Fault::ContinuationOfNothing, ""));
        }
        !ends
    }

    /// Passes over whole lines of comment between the lines of a list.
    fn pass_comments(&mut self) {
        loop {
            let start = self.skip_blanks(self.at);
            if self.octet(start) != Some(b';') {
                return;
            }
            self.at = self.end_of_text_line(start);
            if self.peek().is_none() {
                return;
            }
            self.pass_line_end();
        }
    }

    fn at_line_end(&self, at: usize) -> bool {
        matches!(self.octet(at), None | Some(b'\n' | b'\r'))
    }

    /// Whether a keyword with its sign, a section or an end of a block starts here.
    fn starts_statement(&mut self, start: usize) -> bool {
        let rest = self.octets.get(start..).unwrap_or_default();
        let is_word = |octet: &u8| octet.is_ascii_alphanumeric() || b"_.!".contains(octet);
        let length = rest.iter().position(|octet| !is_word(octet)).unwrap_or(rest.len());
        self.steps = self.steps.saturating_add(length);
        let word = rest.get(..length).unwrap_or_default();
        let after = self.skip_blanks(start.saturating_add(length));
        let starts_block_end = word.get(..3).is_some_and(|start| start.eq_ignore_ascii_case(b"end"));
        let closes = starts_block_end && (self.at_line_end(after) || self.octet(after) == Some(b';'));
        closes
            || self.octet(start) == Some(b'#')
            || (word.iter().any(u8::is_ascii_alphabetic) && matches!(self.octet(after), Some(b'=' | b'(')))
    }

    fn word_length(&self, start: usize) -> usize {
        let rest = self.octets.get(start..).unwrap_or_default();
        let ends = |octet: &u8| BLANKS.contains(octet) || b"\r\n;\\\"=(),".contains(octet);
        rest.iter().position(ends).unwrap_or(rest.len())
    }

    fn word(&mut self) {
        let start = self.at;
        let length = self.word_length(start);
        let number = number(self.octets.get(start..start.saturating_add(length)).unwrap_or_default());
        let (kind, length) = match number {
            Some((value, octets)) => (Kind::Number(value), octets),
            None => (Kind::Word, length),
        };
        self.advance(length);
        self.tokens.push(Token { kind, span: start..self.at });
    }

    /// A text in quotation marks. A mark ends it only if a list, a comment or the end of the line follows.
    fn string(&mut self) {
        let start = self.at;
        let mut text = String::new();
        self.advance(1);
        loop {
            let end = self.end_of_text_line(self.at);
            match self.closing_mark(end) {
                Some((close, true)) => return self.close(start, text, close),
                Some((close, false)) if !self.goes_on(end) => {
                    self.fault(Fault::TextBehindString, "");
                    return self.close(start, text, close);
                }
                _ => {}
            }
            if !self.join(&mut text, end) {
                let found: String = text.chars().take(40).collect();
                self.fault(Fault::OpenString, &found);
                self.tokens.push(Token { kind: Kind::Text(text), span: start..self.at });
                return;
            }
        }
    }

    fn close(&mut self, start: usize, mut text: String, close: usize) {
        text.push_str(self.text.get(self.at..close).unwrap_or_default());
        self.at = close.saturating_add(1);
        if text.contains('"') {
            self.fault(Fault::QuoteInText, "");
        }
        self.tokens.push(Token { kind: Kind::Text(text), span: start..self.at });
    }

    /// The mark that ends the text in this line, or the last mark of the line, and whether it ends the text for certain.
    fn closing_mark(&mut self, end: usize) -> Option<(usize, bool)> {
        let mut last = None;
        let mut at = self.at;
        while at < end {
            self.steps = self.steps.saturating_add(1);
            if self.octet(at) == Some(b'"') {
                let next = self.pass_list(at.saturating_add(1), end);
                if next >= end || matches!(self.octet(next), Some(b';' | b'\\')) {
                    return Some((at, true));
                }
                last = Some((at, false));
                at = next;
            } else {
                at = at.saturating_add(1);
            }
        }
        last
    }

    /// Passes over numbers, commas and blanks. Stays if a number is the start of a word.
    fn pass_list(&mut self, from: usize, end: usize) -> usize {
        let rest = self.octets.get(from..end).unwrap_or_default();
        let in_list = |octet: &u8| octet.is_ascii_hexdigit() || b",-xX".contains(octet) || BLANKS.contains(octet);
        let length = rest.iter().position(|octet| !in_list(octet)).unwrap_or(rest.len());
        self.steps = self.steps.saturating_add(length);
        from.saturating_add(length)
    }

    /// Whether the line says that its text goes on in the next one.
    fn goes_on(&self, end: usize) -> bool {
        let line = self.octets.get(self.at..end).unwrap_or_default();
        line.iter().rev().find(|octet| !BLANKS.contains(octet)) == Some(&b'\\')
    }

    /// Adds the rest of the line to the text and moves to the next line. False if the text ends here.
    fn join(&mut self, text: &mut String, end: usize) -> bool {
        let marked = self.goes_on(end);
        let part = self.text.get(self.at..end).unwrap_or_default();
        let part = if marked { part.trim_end().strip_suffix('\\').unwrap_or(part) } else { part.trim_end() };
        text.push_str(part);
        self.at = end;
        if end >= self.octets.len() {
            return false;
        }
        let pair = self.octets.get(end..end.saturating_add(2)) == Some(b"\r\n");
        let next = end.saturating_add(if pair { 2 } else { 1 });
        if self.starts_section(next) || (!marked && !self.ends_a_text(next)) {
            return false;
        }
        if !marked {
            self.fault(Fault::StringWithoutContinuation, "");
            text.push(' ');
        }
        self.pass_line_end();
        true
    }

    /// Whether this line is `#Profibus_DP`, which no text before it takes.
    fn starts_section(&mut self, line: usize) -> bool {
        let start = self.skip_blanks(line);
        let word = self.octets.get(start..start.saturating_add(HEADER.len()));
        word.is_some_and(|word| word.eq_ignore_ascii_case(HEADER.as_bytes()))
    }

    /// Whether this line is the rest of a text: no statement and no comment, but a quotation mark.
    fn ends_a_text(&mut self, line: usize) -> bool {
        let start = self.skip_blanks(line);
        let end = self.end_of_text_line(start);
        let has_mark = self.octets.get(start..end).is_some_and(|line| line.contains(&b'"'));
        has_mark && self.octet(start) != Some(b';') && !self.starts_statement(start)
    }
}

/// A number at the start of a word and its length. `-` ends it; any other character makes it a word.
fn number(word: &[u8]) -> Option<(u64, usize)> {
    let hex = word.strip_prefix(b"0x").or_else(|| word.strip_prefix(b"0X"));
    let (digits, radix, prefix) = hex.map_or((word, 10, 0), |digits| (digits, 16, 2));
    let length = digits.iter().position(|octet| !char::from(*octet).is_digit(radix)).unwrap_or(digits.len());
    let ends = matches!(digits.get(length), None | Some(b'-'));
    let digits = digits.get(..length).filter(|digits| ends && !digits.is_empty())?;
    let value = u64::from_str_radix(std::str::from_utf8(digits).ok()?, radix).ok()?;
    Some((value, length.saturating_add(prefix)))
}
