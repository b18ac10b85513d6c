//! A line as keyword, argument and values.

use crate::lexer::{Kind, Line, Token};
use crate::problem::Fault;

/// The greatest number of octets in a list: no data unit has more, profibus-wire 1.3.
const MAX_OCTETS: usize = 244;

/// The greatest number of values and ranges in a list, which bounds the work for one value. chosen: as many as modules, which slots list.
const MAX_INTERVALS: usize = 10_000;

/// A line of a file that has a keyword or values.
#[derive(Debug)]
pub(crate) struct Statement<'a> {
    pub(crate) line: usize,
    /// As the file writes it, without blanks at its ends; empty for a line of values alone.
    pub(crate) spelled: &'a str,
    /// In small letters, with `_` in place of blanks.
    pub(crate) keyword: String,
    /// The number in brackets behind the keyword, or the two numbers. Each fits an `i64` or a `u64`.
    pub(crate) argument: Vec<i128>,
    pub(crate) values: Values<'a>,
    /// The comment behind the values, with its semicolon; empty if there is none.
    pub(crate) comment: &'a str,
    /// The whole line, without the comment at its end.
    pub(crate) whole: &'a str,
}

/// The values behind the keyword.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Values<'a> {
    tokens: &'a [Token],
    text: &'a str,
}

impl<'a> Statement<'a> {
    pub(crate) fn new(line: &'a Line, text: &'a str) -> Option<Self> {
        let tokens = line.tokens.as_slice();
        let first = tokens.first()?;
        let head = head_length(tokens, text);
        let (keyword, rest) = tokens.split_at_checked(head)?;
        let spelled = keyword.last().and_then(|last| text.get(first.span.start..last.span.end)).unwrap_or_default();
        let (argument, rest) = argument(rest);
        let rest = if rest.first().is_some_and(|token| token.kind == Kind::Equals) { rest.get(1..)? } else { rest };
        Some(Self {
            line: line.number,
            spelled,
            keyword: spelled.to_ascii_lowercase().split_ascii_whitespace().collect::<Vec<_>>().join("_"),
            argument,
            values: Values { tokens: rest, text },
            comment: tokens.last().and_then(|last| text.get(last.span.end..line.span.end)).unwrap_or_default().trim(),
            whole: Values { tokens, text }.raw(),
        })
    }

    /// The argument as one small number.
    pub(crate) fn index(&self) -> Result<u32, Fault> {
        self.argument.first().and_then(|value| u32::try_from(*value).ok()).ok_or(Fault::BadValue)
    }
}

/// The number of tokens of the keyword: those in front of `=` or `(`, else the first word if it starts with a letter.
fn head_length(tokens: &[Token], text: &str) -> usize {
    let is_value = |token: &Token| matches!(token.kind, Kind::Text(_) | Kind::Comma | Kind::Minus | Kind::Close);
    let end = tokens.iter().position(|token| is_value(token) || matches!(token.kind, Kind::Equals | Kind::Open));
    let signed =
        end.is_some_and(|end| matches!(tokens.get(end).map(|token| &token.kind), Some(Kind::Equals | Kind::Open)));
    let first = tokens.first().filter(|token| token.kind == Kind::Word);
    let first = first.and_then(|token| text.get(token.span.clone())).unwrap_or_default();
    let is_name = first.starts_with(|one: char| one.is_ascii_alphabetic() || one == '#');
    match end {
        // A type without `=`: `Bit(0) 0 0-1`, and one with a fault: `Unsigned8 0 = 3`.
        Some(end) if signed && !(is_name && tokens.get(1..end).is_some_and(has_number)) => end,
        _ => usize::from(is_name),
    }
}

fn has_number(tokens: &[Token]) -> bool {
    tokens.iter().any(|token| matches!(token.kind, Kind::Number(_)))
}

fn argument(tokens: &[Token]) -> (Vec<i128>, &[Token]) {
    let open = tokens.first().is_some_and(|token| token.kind == Kind::Open);
    let close = tokens.iter().position(|token| token.kind == Kind::Close).filter(|_| open);
    let Some((inside, rest)) = close.and_then(|close| tokens.split_at_checked(close)) else {
        return (Vec::new(), tokens);
    };
    (signed_numbers(inside), rest.get(1..).unwrap_or_default())
}

/// The numbers among the tokens. `-` behind a number is a range, elsewhere it is a sign.
fn signed_numbers(tokens: &[Token]) -> Vec<i128> {
    let mut numbers = Vec::new();
    let mut negative = false;
    let mut before = &Kind::Open;
    for Token { kind, .. } in tokens {
        match kind {
            Kind::Number(value) if negative => numbers.push(i128::from(*value).saturating_neg()),
            Kind::Number(value) => numbers.push(i128::from(*value)),
            _ => {}
        }
        negative = *kind == Kind::Minus && !matches!(before, Kind::Number(_));
        before = kind;
    }
    numbers
}

impl<'a> Values<'a> {
    pub(crate) fn is_empty(&self) -> bool {
        self.tokens.is_empty()
    }

    fn next_if(&mut self, kind: &Kind) -> bool {
        let is = self.tokens.first().is_some_and(|token| token.kind == *kind);
        if is {
            self.tokens = self.tokens.get(1..).unwrap_or_default();
        }
        is
    }

    /// The next unsigned number.
    pub(crate) fn unsigned(&mut self) -> Option<u64> {
        let Some(Token { kind: Kind::Number(value), .. }) = self.tokens.first() else { return None };
        self.tokens = self.tokens.get(1..).unwrap_or_default();
        Some(*value)
    }

    /// The next number with its sign.
    pub(crate) fn signed(&mut self) -> Option<i64> {
        let negative = self.next_if(&Kind::Minus);
        let value = i64::try_from(self.unsigned()?).ok()?;
        Some(if negative { value.saturating_neg() } else { value })
    }

    /// The one number of the line.
    pub(crate) fn number<T: TryFrom<u64>>(mut self) -> Result<T, Fault> {
        let value = self.unsigned().ok_or(Fault::BadValue)?;
        T::try_from(value).map_err(|_| Fault::OutOfRange)
    }

    /// The next text in quotation marks.
    pub(crate) fn quoted(&mut self) -> Option<&'a str> {
        let Some(Token { kind: Kind::Text(text), .. }) = self.tokens.first() else { return None };
        self.tokens = self.tokens.get(1..).unwrap_or_default();
        Some(text)
    }

    /// The text of the line, in quotation marks or not.
    pub(crate) fn text(mut self) -> String {
        self.quoted().map_or_else(|| self.raw().to_owned(), str::to_owned)
    }

    /// The values as the file writes them.
    pub(crate) fn raw(&self) -> &'a str {
        let (Some(first), Some(last)) = (self.tokens.first(), self.tokens.last()) else { return "" };
        self.text.get(first.span.start..last.span.end).unwrap_or_default()
    }

    /// The rest as octets, up to the first value that is none, and what is wrong with the list.
    pub(crate) fn octets(mut self) -> (Vec<u8>, Option<Fault>) {
        let mut octets = Vec::new();
        let mut fault = None;
        while !self.is_empty() {
            match self.unsigned().map(u8::try_from) {
                // More are no data unit of PROFIBUS.
                Some(Ok(_)) if octets.len() >= MAX_OCTETS => return (octets, Some(Fault::OutOfRange)),
                Some(Ok(octet)) => octets.push(octet),
                Some(Err(_)) => return (octets, Some(Fault::OutOfRange)),
                None if self.next_if(&Kind::Comma) => {
                    fault = Some(Fault::RepeatedComma);
                    continue;
                }
                None => return (octets, Some(Fault::BadValue)),
            }
            self.next_if(&Kind::Comma);
        }
        (octets, fault)
    }

    /// The rest as values and ranges of values: `0-5`, `-5--1` or `1,3,8-9`.
    pub(crate) fn intervals(mut self) -> Result<Vec<(i64, i64)>, Fault> {
        let mut intervals = Vec::new();
        while !self.is_empty() {
            let low = self.signed().ok_or(Fault::BadValue)?;
            if intervals.len() >= MAX_INTERVALS {
                return Err(Fault::TooMany);
            }
            let high = if self.next_if(&Kind::Minus) { self.signed().ok_or(Fault::BadValue)? } else { low };
            intervals.push((low.min(high), low.max(high)));
            self.next_if(&Kind::Comma);
        }
        Ok(intervals)
    }

    /// Whether `-` follows the next number without a blank, so that it is a range and no default.
    pub(crate) fn starts_with_range(mut self) -> bool {
        let _ = self.next_if(&Kind::Minus);
        let [number, minus, ..] = self.tokens else { return false };
        minus.kind == Kind::Minus && number.span.end == minus.span.start
    }

    /// Whether the values contain a number that is written with `0X`.
    pub(crate) fn has_capital_x(&self) -> bool {
        let capital = |token: &Token| self.text.get(token.span.clone()).is_some_and(|text| text.starts_with("0X"));
        self.tokens.iter().any(|token| matches!(token.kind, Kind::Number(_)) && capital(token))
    }

    /// The values as words, for messages: at most 40 characters.
    pub(crate) fn brief(&self) -> String {
        self.raw().chars().take(40).collect()
    }
}
