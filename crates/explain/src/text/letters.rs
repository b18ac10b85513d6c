//! Dumps with letters in place of octets, as `od -c` and `hexdump -c` print them.
//!
//! Each octet is a cell of four columns: the letter itself, an escape (`\n`), or three octal digits. A line becomes one of a dump in
//! hexadecimal, so that addresses and omitted lines are read in one place.

use super::dump::RADICES;
use super::dump_lines::OMITTED;
use super::ignored::Ignored;
use super::{Found, Reader};
use std::collections::VecDeque;

/// The digits of an address: seven in `od -c` and `hexdump -c`, six in `od -A x -c`.
const ADDRESS_DIGITS: std::ops::RangeInclusive<usize> = 6..=8;

/// The columns of a cell.
const CELL: usize = 4;

/// The most octets of a line of `od`. chosen: `od -w` allows any number.
const MOST_CELLS: usize = 256;

/// The escapes of both programs, and their octets.
const ESCAPES: [(char, u8); 8] =
    [('0', 0), ('a', 7), ('b', 8), ('t', b'\t'), ('n', b'\n'), ('v', 0x0B), ('f', 0x0C), ('r', b'\r')];

/// A line of a dump with letters.
#[derive(Clone, Debug, PartialEq, Eq)]
struct LettersLine<'a> {
    address: &'a str,
    octets: Vec<u8>,
    /// A cell is neither a digit nor octal, or one is a digit and one has leading zeros: neither `od -b` nor `od -t u1` prints such lines.
    has_letters: bool,
}

/// What the lines of a text show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shown {
    /// It is no such dump.
    No,
    /// Its last line may be the first one of such a dump: the next one decides.
    Undecided,
    /// It is one: the address of a line follows from the line before.
    Letters,
}

/// Whether the lines are a dump with letters.
pub(super) fn are_letters<'a>(lines: impl Iterator<Item = &'a str>) -> Shown {
    let (mut before, mut has_letters, mut is_confirmed): (Option<LettersLine>, bool, bool) = (None, false, false);
    for line in lines.filter(|line| !line.trim().is_empty() && line.trim() != OMITTED) {
        let Some(line) = LettersLine::of(line) else {
            before = None;
            continue;
        };
        is_confirmed |= before.is_some_and(|before| before.is_followed_by(&line));
        has_letters |= line.has_letters;
        if is_confirmed && has_letters {
            return Shown::Letters;
        }
        before = Some(line);
    }
    match before {
        Some(line) if line.has_letters => Shown::Undecided,
        _ => Shown::No,
    }
}

/// Reads a dump with letters.
#[derive(Clone, Debug)]
pub(super) struct Letters {
    reader: Box<Reader>,
    /// The last line with octets: the address of the next one may shorten it.
    waiting: Option<String>,
}

impl Letters {
    pub(super) const fn new(reader: Box<Reader>) -> Self {
        Self { reader, waiting: None }
    }

    /// The text that is not octets.
    pub(super) const fn ignored(&self) -> &Ignored {
        self.reader.ignored()
    }

    /// Reads a line, or the part of a line that is too long. `is_last` says whether the line ends here.
    pub(super) fn read(&mut self, text: &str, is_last: bool, found: &mut Found) {
        let line = LettersLine::of(text).filter(|_| is_last);
        self.read_waiting(line.as_ref(), found);
        match line {
            Some(line) if !line.octets.is_empty() => self.waiting = Some(text.to_owned()),
            _ => self.reader.read(text, is_last, found),
        }
    }

    /// Ends the text.
    pub(super) fn end(&mut self, found: &mut Found) {
        self.read_waiting(None, found);
        self.reader.end(found);
    }

    /// Reads the line that waits as one of a dump in hexadecimal.
    fn read_waiting(&mut self, next: Option<&LettersLine>, found: &mut Found) {
        let Some(text) = self.waiting.take() else { return };
        let Some(line) = LettersLine::of(&text) else { return };
        let count = next.and_then(|next| line.count_before(next, 16)).unwrap_or(line.octets.len());
        let octets: String = line.octets.iter().take(count).map(|octet| format!(" {octet:02X}")).collect();
        // With a digit more, an address of hexdump is not taken for an octal one of od.
        self.reader.read(&format!("0{}{octets}\n", line.address), true, found);
    }
}

impl<'a> LettersLine<'a> {
    /// A line of an address and cells; the last line of a dump has none.
    fn of(line: &'a str) -> Option<Self> {
        let line = line.trim_end_matches(['\r', '\n']);
        let digits = line.bytes().take_while(u8::is_ascii_hexdigit).count();
        let (address, cells) = line.split_at_checked(digits).filter(|_| ADDRESS_DIGITS.contains(&digits))?;
        let mut found = Self { address, octets: Vec::new(), has_letters: false };
        let (mut rest, mut further) = (cells.chars().peekable(), VecDeque::new());
        let (mut has_digits, mut has_zeros) = (false, false);
        while rest.peek().is_some() {
            let cell: Vec<char> = rest.by_ref().take(CELL).collect();
            match cell[..] {
                [' '] => {}
                [' ', ..] if found.octets.len() < MOST_CELLS => {
                    has_zeros |= cell.get(1) == Some(&'0');
                    let cell = Cell::of(cell.get(1..)?)?;
                    has_digits |= matches!(cell, Cell::Letter('0'..='9'));
                    found.has_letters |= !matches!(cell, Cell::Octal(_) | Cell::Letter('0'..='9'));
                    found.octets.push(cell.octet(&mut further)?);
                }
                _ => return None,
            }
        }
        found.has_letters |= has_digits && has_zeros;
        Some(found)
    }

    /// Whether the address of `next` follows from this line in one of the number systems.
    fn is_followed_by(&self, next: &Self) -> bool {
        RADICES.iter().any(|radix| self.count_before(next, *radix).is_some())
    }

    /// The number of octets of this line by the address of `next`: all, or those in front of the spaces with which hexdump fills its last
    /// line.
    fn count_before(&self, next: &Self, radix: u32) -> Option<usize> {
        let address = |line: &Self| u64::from_str_radix(line.address, radix).ok();
        let count = address(next)?.checked_sub(address(self)?).and_then(|count| usize::try_from(count).ok())?;
        let rest = self.octets.get(count..).filter(|_| count > 0)?;
        rest.iter().all(|octet| *octet == b' ').then_some(count)
    }
}

/// A cell without its first column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cell {
    Letter(char),
    Escape(u8),
    Octal(u8),
    /// A further octet of the letter before, which has several in UTF-8.
    Further,
}

impl Cell {
    fn of(cell: &[char]) -> Option<Self> {
        match *cell {
            [' ', '*', '*'] => Some(Self::Further),
            [' ', ' ', letter] => (!letter.is_control()).then_some(Self::Letter(letter)),
            [' ', '\\', letter] => {
                ESCAPES.into_iter().find(|(escape, _)| *escape == letter).map(|(_, octet)| Self::Escape(octet))
            }
            [first @ '0'..='3', second @ '0'..='7', third @ '0'..='7'] => {
                u8::from_str_radix(&String::from_iter([first, second, third]), 8).ok().map(Self::Octal)
            }
            _ => None,
        }
    }

    /// Its octet; the further ones of a letter wait for their cells.
    fn octet(self, further: &mut VecDeque<u8>) -> Option<u8> {
        match self {
            Self::Escape(octet) | Self::Octal(octet) => Some(octet),
            Self::Further => further.pop_front(),
            Self::Letter(letter) => {
                further.extend(letter.encode_utf8(&mut [0; 4]).bytes());
                further.pop_front()
            }
        }
    }
}
