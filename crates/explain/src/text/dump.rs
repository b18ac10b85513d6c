//! Dumps: lines of an address, octets, and maybe the same octets as characters.
//!
//! An address column is a property of the whole text: from line to line its numbers grow by the number of octets. A first word
//! that could be octets is an address only if the next line confirms it.

use super::word::pairs;

/// A line with an address, as it looks alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct DumpLine {
    pub(super) address: Address,
    pub(super) octets: Vec<u8>,
    /// The characters behind the octets, if the line has them.
    pub(super) characters: Option<String>,
    /// Text behind the octets that is neither.
    pub(super) rest: String,
    /// The number of digits of each group, if all have the same.
    width: usize,
}

/// The first word of a line that may be an address.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Address {
    pub(super) digits: String,
    has_colon: bool,
}

/// Number systems of an address column: `xxd` and `hexdump`, `od`, `od -A d`.
pub(super) const RADICES: [u32; 3] = [16, 8, 10];

impl Address {
    /// Splits a line into address and rest.
    fn of(line: &str) -> Option<(Self, &str)> {
        let line = line.trim_start();
        let (first, rest) = line.split_once([' ', '\t']).unwrap_or((line, ""));
        let digits = first.strip_suffix(':').unwrap_or(first);
        let has_colon = digits.len() < first.len();
        let least = if has_colon { 2 } else { 4 };
        let is_number = (least..=16).contains(&digits.len()) && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        is_number.then(|| (Self { digits: digits.to_owned(), has_colon }, rest))
    }

    fn value(&self, radix: u32) -> Option<u64> {
        u64::from_str_radix(&self.digits, radix).ok()
    }

    fn is_zero(&self) -> bool {
        self.digits.bytes().all(|digit| digit == b'0')
    }

    /// Whether both are numbers of the same column.
    fn is_like(&self, other: &Self) -> bool {
        self.has_colon == other.has_colon && self.digits.len().abs_diff(other.digits.len()) <= 1
    }
}

impl DumpLine {
    /// A line that may have an address. It has octets in groups of equal length, or nothing behind the address.
    pub(super) fn of(line: &str) -> Option<Self> {
        let (address, rest) = Address::of(line)?;
        let groups = Groups::of(rest, !address.has_colon);
        let Groups { octets, characters, rest, width, .. } = groups;
        (!octets.is_empty() || rest.trim().is_empty()).then_some(Self { address, octets, characters, rest, width })
    }

    /// Whether the line alone shows that it is a line of a dump: octets with their characters, or an address with a colon.
    pub(super) fn is_certain(&self) -> bool {
        let has_octets = !self.octets.is_empty();
        has_octets && (self.characters.is_some() || (self.address.has_colon && self.address.digits.len() >= 4))
    }

    /// Whether both lines have groups like their first word, so that it is none.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let form = |line: &Self| (line.address.digits.len(), line.address.has_colon);
        form(self) == form(other) && other.has_groups_like_address()
    }

    /// Whether the address looks like the groups behind it.
    pub(super) fn has_groups_like_address(&self) -> bool {
        self.width == self.address.digits.len()
    }

    /// Whether the line probably belongs to a dump, if no further line decides: the address differs from the groups, and is zero or
    /// has the seven digits of `od`.
    pub(super) fn is_likely(&self) -> bool {
        let length = self.address.digits.len();
        self.width != 0 && self.width != length && (self.address.is_zero() || length == 7)
    }
}

/// The bars in a line behind which the characters of its octets are searched. chosen: the work for a line grows with its length alone.
const MOST_BARS: usize = 8;

/// Characters between bars at the end of a line with words before its octets, as ESP-IDF prints it: the text before them, and the characters.
fn characters_between_bars(line: &str) -> Option<(&str, String)> {
    let inner = line.trim_end().strip_suffix('|')?;
    let is_pair = |word: &&str| word.len() == 2 && word.bytes().all(|digit| digit.is_ascii_hexdigit());
    inner.match_indices('|').take(MOST_BARS).find_map(|(at, _)| {
        let (front, shown) = (inner.get(..at)?, inner.get(at.saturating_add(1)..)?);
        let count = shown.chars().count();
        let words = front.split_whitespace().rev().take_while(is_pair).take(count);
        let mut octets: Vec<u8> = words.flat_map(|word| pairs(word, 0).octets).collect();
        octets.reverse();
        let is_found = count > 0 && octets.len() == count && is_shown(shown, &octets);
        is_found.then(|| (front, shown.to_owned()))
    })
}

/// Characters behind the octets of a line without an address: the text before them, and the characters.
pub(super) fn characters_at_end(line: &str) -> Option<(&str, String)> {
    characters_between_bars(line).or_else(|| characters_behind(line))
}

fn characters_behind(line: &str) -> Option<(&str, String)> {
    let groups = Groups::of(line, false);
    let characters = groups.characters?;
    let at = line.len().checked_sub(groups.tail)?;
    Some((line.get(..at)?, characters))
}

/// Groups of digits at the begin of a text.
struct Groups {
    octets: Vec<u8>,
    characters: Option<String>,
    rest: String,
    /// The number of octets of text with the characters.
    tail: usize,
    width: usize,
}

impl Groups {
    /// Reads groups up to the characters, or up to a word that is no group. `may_swap`: groups of four digits and more are
    /// numbers with their low octet first.
    fn of(text: &str, may_swap: bool) -> Self {
        let (mut octets, mut at, mut width, mut is_last): (Vec<u8>, usize, usize, bool) = (Vec::new(), 0, 0, false);
        let (mut characters, mut tail) = (None, 0);
        while let Some(rest) = text.get(at..) {
            if let Some(found) = characters_of(rest, &octets) {
                (characters, tail) = (Some(found), rest.len());
                at = text.len();
                break;
            }
            let start = at.saturating_add(rest.len().saturating_sub(rest.trim_start().len()));
            let Some(group) = text.get(start..).and_then(|rest| rest.split_whitespace().next()) else { break };
            if width == 0 {
                width = group.len();
            }
            let Some(found) = group_octets(group, width, may_swap).filter(|_| !is_last && group.len() <= width) else {
                break;
            };
            is_last = group.len() < width;
            octets.extend(found);
            at = start.saturating_add(group.len());
        }
        Self { octets, characters, rest: text.get(at..).unwrap_or_default().to_owned(), tail, width }
    }
}

/// The octets of a group of a dump whose groups have `width` digits; the last one may be shorter. A dump with plain addresses has
/// numbers with their low octet first: hexadecimal (hexdump, od -x) or octal (od); od -b has octets in three octal digits.
fn group_octets(group: &str, width: usize, may_swap: bool) -> Option<Vec<u8>> {
    match (width, may_swap) {
        (3, true) => u8::from_str_radix(group, 8).ok().map(|octet| vec![octet]),
        (6, true) => u16::from_str_radix(group, 8).ok().map(|number| number.to_le_bytes().to_vec()),
        _ => {
            let is_group = group.len().is_multiple_of(2) && group.bytes().all(|digit| digit.is_ascii_hexdigit());
            let mut octets = is_group.then(|| pairs(group, 0).octets)?;
            if may_swap && matches!(width, 4 | 8 | 16) {
                octets.reverse();
            }
            Some(octets)
        }
    }
}

/// The characters behind octets: between bars (hexdump -C), between angles (od z), or behind two spaces (xxd). Without marks they
/// count only if they are those of the octets.
fn characters_of(text: &str, octets: &[u8]) -> Option<String> {
    if octets.is_empty() {
        return None;
    }
    let begin = text.trim_start();
    if begin.starts_with(['|', '>']) {
        let inner = [('|', '|'), ('>', '<')].into_iter().find_map(|(first, last)| {
            let inner = begin.trim_end().strip_prefix(first)?.strip_suffix(last)?;
            is_shown(inner, octets).then(|| inner.to_owned())
        });
        if inner.is_some() {
            return inner;
        }
    }
    let spaces = text.len().saturating_sub(text.trim_start_matches(' ').len());
    // The spaces that show octets. At most one place is possible, and the search looks at no more octets than there are spaces: it is
    // made behind each octet of a line.
    let skip = if begin.is_empty() {
        2
    } else {
        spaces.saturating_sub(octets.iter().take(spaces).take_while(|octet| **octet == b' ').count())
    };
    let shown = text.get(skip..).filter(|shown| (2..=spaces).contains(&skip) && is_shown(shown, octets))?;
    Some(shown.trim_end().to_owned())
}

/// Whether `shown` are the octets as characters, `.` for one that cannot be printed. Spaces at the end may be lost.
fn is_shown(shown: &str, octets: &[u8]) -> bool {
    let mut letters = shown.chars();
    let all = octets.iter().all(|octet| {
        let expected = if (0x20..0x7F).contains(octet) { char::from(*octet) } else { '.' };
        letters.next().unwrap_or(' ') == expected
    });
    all && letters.all(char::is_whitespace)
}

/// The address column of a text.
#[derive(Clone, Debug)]
pub(super) struct Column {
    address: Address,
    /// The number systems in which all addresses agree.
    radices: Vec<u32>,
    /// The number of octets of the last line.
    count: usize,
    /// The number of digits of its groups.
    width: usize,
}

/// Relation of an address to the line before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// It is the expected address.
    Next,
    /// It ends the dump early: this number of octets completes the last word and is not in the input.
    Padded(u64),
    /// The dump begins again.
    Restart,
    /// It is another address.
    Other,
}

impl Column {
    pub(super) fn new(line: &DumpLine) -> Self {
        let (address, count) = (line.address.clone(), line.octets.len());
        Self { address, radices: RADICES.to_vec(), count, width: line.width }
    }

    /// Whether `line` confirms that both lines have addresses.
    pub(super) fn is_confirmed_by(&self, line: &DumpLine) -> bool {
        self.count > 0 && self.address.is_like(&line.address) && matches!(self.step(line), Step::Next | Step::Padded(_))
    }

    /// Whether `line` has an address of this column.
    pub(super) fn has(&self, line: &DumpLine) -> bool {
        self.address.is_like(&line.address)
    }

    /// The relation of the address of `line` to that of the line before.
    pub(super) fn step(&self, line: &DumpLine) -> Step {
        let count = self.count as u64;
        let expected = |radix: u32| Some((self.address.value(radix)?.checked_add(count)?, line.address.value(radix)?));
        let found: Vec<(u64, u64)> = self.radices.iter().filter_map(|radix| expected(*radix)).collect();
        // Words of 16 bits have four hexadecimal or six octal digits.
        let longest = if self.width == 6 { 2 } else { self.width as u64 / 2 };
        let missing = |(expected, found): &(u64, u64)| {
            expected.checked_sub(*found).filter(|missing| line.octets.is_empty() && *missing < longest)
        };
        if found.iter().any(|(expected, found)| expected == found) {
            Step::Next
        } else if let Some(missing) = found.iter().find_map(missing) {
            Step::Padded(missing)
        } else if line.address.is_zero() {
            Step::Restart
        } else {
            Step::Other
        }
    }

    /// The number of octets that a dump omits before `line`: a multiple of the octets of a line, in the only number system in which it is
    /// one.
    pub(super) fn gap(&self, line: &DumpLine) -> Option<u64> {
        let count = self.count as u64;
        let gap = |radix: &u32| {
            let expected = self.address.value(*radix)?.checked_add(count)?;
            line.address
                .value(*radix)?
                .checked_sub(expected)
                .filter(|gap| *gap > 0 && gap.checked_rem(count) == Some(0))
        };
        let mut gaps: Vec<u64> = self.radices.iter().filter_map(gap).collect();
        // Addresses of od with single octets are octal: seven digits.
        if gaps.len() > 1 && self.width == 2 && self.address.digits.len() == 7 {
            gaps = gap(&8).into_iter().collect();
        }
        gaps.dedup();
        match gaps[..] {
            [gap] => Some(gap),
            _ => None,
        }
    }

    /// Keeps the number systems in which `second` follows `first`, if there are any.
    pub(super) fn narrow(&mut self, first: &DumpLine, second: &DumpLine) {
        let follows = |radix: &u32| {
            let next = first.address.value(*radix)?.checked_add(first.octets.len() as u64)?;
            (next == second.address.value(*radix)?).then_some(*radix)
        };
        let radices: Vec<u32> = self.radices.iter().filter_map(follows).collect();
        if !radices.is_empty() {
            self.radices = radices;
        }
    }

    /// Continues behind `line`.
    pub(super) fn advance(&mut self, line: &DumpLine) {
        if self.step(line) == Step::Next {
            let (before, count) = (self.address.clone(), self.count as u64);
            let agrees = |radix: &u32| {
                before.value(*radix).map(|value| value.saturating_add(count)) == line.address.value(*radix)
            };
            self.radices.retain(agrees);
        } else if self.step(line) == Step::Restart {
            self.radices = RADICES.to_vec();
        }
        (self.address, self.count) = (line.address.clone(), line.octets.len());
        if line.width != 0 {
            self.width = line.width;
        }
    }
}
