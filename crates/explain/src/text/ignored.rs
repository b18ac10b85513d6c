//! Text that is not octets.

use std::collections::BTreeMap;

/// Kind of text that is not octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum IgnoredKind {
    /// A line without octets.
    Line,
    /// Words beside octets.
    Words,
    /// A comment.
    Comment,
    /// The address of a line of a dump.
    Address,
    /// The octets of a dump as characters.
    Characters,
    /// The bits of characters: start, data, parity and stop.
    Bits,
    /// The mark at the begin of UTF-8 text.
    ByteOrderMark,
}

/// Lines with text that is not octets, by its kind.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ignored(BTreeMap<IgnoredKind, IgnoredText>);

/// Lines with ignored text of one kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IgnoredText {
    /// Their number.
    pub lines: usize,
    /// Number of the first line, counted from 1.
    pub first_line: usize,
    /// The text in the first line, at most 60 characters.
    pub first_text: String,
    last_line: usize,
}

impl Ignored {
    /// The kinds that occurred.
    pub fn kinds(&self) -> impl Iterator<Item = (IgnoredKind, &IgnoredText)> {
        self.0.iter().map(|(kind, text)| (*kind, text))
    }

    pub(crate) fn add(&mut self, kind: IgnoredKind, line: usize, text: &str) {
        let new = || IgnoredText { lines: 0, first_line: line, last_line: 0, first_text: shortened(text) };
        let ignored = self.0.entry(kind).or_insert_with(new);
        ignored.lines = ignored.lines.saturating_add(usize::from(ignored.last_line != line));
        ignored.last_line = line;
    }
}

/// Number of characters of a line that a message shows.
const SHOWN: usize = 60;

pub(super) fn shortened(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(SHOWN).collect()
}
