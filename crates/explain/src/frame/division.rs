//! Chooses the division of octets into telegrams with the best score.

use super::{Framer, MAX_CHAIN, Piece};
use profivac_wire::{Telegram, TelegramLength};

/// The highest address in a token: it has no extension bit and no broadcast address.
const MAX_ADDRESS: u8 = 126;

/// The score of an SD3: less than the 6 octets of an SD1.
const SD3_SCORE: usize = 5;
const SD3: u8 = 0xA2;
const SD2: u8 = 0x68;

/// A possible telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Candidate {
    pub(super) from: usize,
    pub(super) to: usize,
    /// It has a check octet.
    pub(super) is_checked: bool,
}

/// Best division of the octets up to a position.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Division {
    score: Score,
    /// The telegram that ends here; otherwise the octet before is damaged.
    pub(super) last: Option<Candidate>,
}

/// Result of examining the octets from a position.
enum Examined {
    /// A telegram that begins here would continue after the last octet.
    Incomplete,
    /// No telegram begins here.
    Nothing,
    /// A telegram begins here.
    Telegram(Candidate),
}

impl Framer {
    /// Examines the octets up to the first one with which an incomplete telegram may begin. Telegrams that begin before `old` are not
    /// awaited.
    pub(super) fn examine(&mut self, old: usize, out: &mut Vec<Piece>) {
        while self.examined < self.octets.len() {
            let at = self.examined;
            let found = match self.candidate(at) {
                Examined::Incomplete if at >= old => break,
                Examined::Incomplete | Examined::Nothing => None,
                Examined::Telegram(candidate) => Some(candidate),
            };
            let is_first = at == self.divided;
            match found {
                None if is_first => self.add_damaged(at.saturating_add(1), out),
                Some(candidate) if is_first && self.is_certain(candidate) => self.add_telegram(candidate, out),
                _ => {
                    self.open.extend(found);
                    self.examined = at.saturating_add(1);
                    self.add_division();
                    if self.open.is_empty() {
                        self.divide(self.examined, out);
                    } else if self.examined.saturating_sub(self.divided) >= MAX_CHAIN {
                        self.divide_early(out);
                    }
                    continue;
                }
            }
            self.examined = self.divided;
        }
    }

    /// Whether no other division is possible: an SC alone, or an SD1 or SD2 that is a whole number of chunks.
    fn is_certain(&self, candidate: Candidate) -> bool {
        let is_whole = || self.is_boundary(candidate.from) && self.is_boundary(candidate.to);
        let is_short = candidate.to == candidate.from.saturating_add(1);
        is_short || (candidate.is_checked && !self.is_sd3(candidate) && is_whole())
    }

    fn is_sd3(&self, candidate: Candidate) -> bool {
        candidate.is_checked && self.octets.get(candidate.from) == Some(&SD3)
    }

    /// The telegram that begins at `from`.
    fn candidate(&mut self, from: usize) -> Examined {
        let rest = self.octets.get(from..).unwrap_or_default();
        let length = match TelegramLength::of(rest) {
            TelegramLength::Invalid(_) => return Examined::Nothing,
            TelegramLength::Incomplete => TelegramLength::HEADER_LENGTH,
            TelegramLength::Known(length) => length,
        };
        let octets = rest.get(..usize::from(length)).unwrap_or(rest);
        let to = from.saturating_add(octets.len());
        self.work = self.work.saturating_add(1);
        let next_error = self.errors.get(self.errors.partition_point(|error| *error < from));
        if next_error.is_some_and(|error| *error < to) {
            return Examined::Nothing;
        }
        if octets.len() < usize::from(length) {
            return Examined::Incomplete;
        }
        self.work = self.work.saturating_add(u64::from(length));
        let is_checked = match Telegram::parse(octets) {
            Ok(Telegram::Token { da, sa }) if da.max(sa) <= MAX_ADDRESS => false,
            Ok(Telegram::ShortAck) => false,
            Ok(Telegram::Data(_)) => true,
            Ok(Telegram::Token { .. }) | Err(_) => return Examined::Nothing,
        };
        Examined::Telegram(Candidate { from, to, is_checked })
    }

    /// Adds the best division up to the last examined octet.
    fn add_division(&mut self) {
        let end = self.examined;
        let mut best = Division { score: self.score_at(end.saturating_sub(1)), last: None };
        // The last start of a telegram that ends here and excludes longer ones.
        let takes_end =
            |candidate: &&Candidate| candidate.to == end && candidate.is_checked && self.takes_end(candidate.from);
        let shortest = self.open.iter().filter(takes_end).map(|candidate| candidate.from).max();
        for candidate in self.open.iter().filter(|candidate| candidate.to == end) {
            if candidate.is_checked && shortest.is_some_and(|from| candidate.from < from) {
                continue;
            }
            let score = self.score_with(*candidate);
            if score > best.score {
                best = Division { score, last: Some(*candidate) };
            }
        }
        self.work = self.work.saturating_add(self.open.len() as u64);
        self.open.retain(|candidate| candidate.to != end);
        self.divisions.push(best);
    }

    /// Whether a telegram that begins here excludes longer ones with the same end.
    fn takes_end(&self, from: usize) -> bool {
        self.octets.get(from) == Some(&SD2) || self.is_boundary(from)
    }

    /// Score of the best division up to `end`.
    fn score_at(&self, end: usize) -> Score {
        self.divisions.get(end.saturating_sub(self.divided)).map(|division| division.score).unwrap_or_default()
    }

    /// Score of the best division that ends with `candidate`.
    fn score_with(&self, candidate: Candidate) -> Score {
        let length = candidate.to.saturating_sub(candidate.from);
        let counted = if self.is_sd3(candidate) { SD3_SCORE } else { length };
        self.score_at(candidate.from).plus(counted, candidate.is_checked)
    }

    /// Divides the examined octets although telegrams are open: the division with the best score counts.
    pub(super) fn divide_early(&mut self, out: &mut Vec<Piece>) {
        let best = self.open.iter().copied().max_by_key(|candidate| self.score_with(*candidate));
        match best.filter(|candidate| self.score_with(*candidate) > self.score_at(self.examined)) {
            Some(candidate) => {
                self.divide(candidate.from, out);
                self.add_telegram(candidate, out);
                self.examined = self.divided;
            }
            None => self.divide(self.examined, out),
        }
    }

    /// Divides the octets up to `end` with the best division, and begins again behind it.
    fn divide(&mut self, end: usize, out: &mut Vec<Piece>) {
        let (mut telegrams, mut at) = (Vec::new(), end);
        while at > self.divided {
            self.work = self.work.saturating_add(1);
            let division = self.divisions.get(at.saturating_sub(self.divided)).copied().unwrap_or_default();
            at = division.last.map_or(at.saturating_sub(1), |telegram| telegram.from);
            telegrams.extend(division.last);
        }
        for telegram in telegrams.into_iter().rev() {
            if telegram.from > self.divided {
                self.add_damaged(telegram.from, out);
            }
            self.add_telegram(telegram, out);
        }
        if end > self.divided {
            self.add_damaged(end, out);
        }
        self.divisions.truncate(1);
        self.open.clear();
    }
}

impl Candidate {
    pub(super) const fn shift(&mut self, gone: usize) {
        (self.from, self.to) = (self.from.saturating_sub(gone), self.to.saturating_sub(gone));
    }
}

/// Score of a division: octets in telegrams with a check octet, then octets in other telegrams.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Score {
    checked: usize,
    others: usize,
}

impl Score {
    const fn plus(self, length: usize, is_checked: bool) -> Self {
        if is_checked {
            Self { checked: self.checked.saturating_add(length), ..self }
        } else {
            Self { others: self.others.saturating_add(length), ..self }
        }
    }
}
