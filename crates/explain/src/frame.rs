//! Divides octets into telegrams and damaged pieces.
//!
//! The [`Framer`] chooses the division in which telegrams with a check octet (SD1, SD2, SD3) cover the most octets, and among
//! equal ones the division in which the other telegrams cover the most. Damaged octets beside a valid telegram therefore
//! never hide it: only a longer telegram that overlaps it, with a check octet and an end delimiter that fit by chance, can
//! replace it. Octets that look like a telegram inside the data of a valid one are data.
//!
//! Two rules reduce wrong divisions:
//!
//! * SD3 has no length octet and no other protection of its 14 octets, so an A2 before two telegrams easily becomes an SD3.
//!   An SD3 has a lower score than an SD1.
//! * Of two telegrams with the same end the shorter one counts, if it is an SD2 or begins a chunk. The data of a telegram may
//!   contain a telegram, but not one that ends with the end delimiter of the outer one. A telegram that was cut off may reach its
//!   announced length with the octets of the next one.
//!
//! SC and the token have no check octet, so any E5 among damaged octets looks like an SC. They are kept, because they may be
//! valid, and are [`PieceKind::Doubtful`] where they touch damaged octets of the same chunk.
//!
//! Each octet is examined once, when the telegram that may begin with it is complete, so the framer looks ahead by one longest
//! telegram. Telegrams that overlap each other are divided together; after [`MAX_CHAIN`] octets the best division up to there
//! counts. The framer therefore holds a limited number of octets and its work grows with the number of octets alone,
//! whatever they are. The result does not depend on the sizes of the chunks that continue each other.

use profivac_dp::link::{BitTime, CHARACTER_TBIT};
use profivac_wire::{MAX_TELEGRAM, Telegram, TelegramLength};
use std::collections::VecDeque;

/// The highest address in a token: it has no extension bit and no broadcast address.
const MAX_ADDRESS: u8 = 126;

/// The score of an SD3: less than the 6 octets of an SD1.
const SD3_SCORE: usize = 5;
const SD3: u8 = 0xA2;
const SD2: u8 = 0x68;

/// The number of octets without a telegram that become a damaged piece before more follow.
pub const MAX_DAMAGED: usize = 1024;

/// The longest row of telegrams that overlap each other and are divided together, in octets. free choice: a damaged telegram and
/// the one that follows it.
pub const MAX_CHAIN: usize = 2 * MAX_TELEGRAM;

/// The longest row of SC and tokens that wait for the octet behind them. free choice.
const MAX_SHORT: usize = 64;

/// Octets that belong together: a packet, an entry, a line, or one reception.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chunk {
    /// Start of the first octet, if the input has times.
    pub start: Option<BitTime>,
    /// The octets.
    pub octets: Vec<u8>,
    /// Positions of the octets with a character error, counted from 0.
    pub errors: Vec<usize>,
    /// The next chunk continues this one: the place between them has no meaning.
    pub is_continued: bool,
}

/// Kind of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceKind {
    /// A telegram.
    Valid,
    /// SC or a token that may be part of damaged octets.
    Doubtful,
    /// Octets that are not a telegram.
    Damaged,
}

/// A telegram, or octets between telegrams.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Start of the first octet, if the input has times.
    pub start: Option<BitTime>,
    /// The octets.
    pub octets: Vec<u8>,
    /// Positions of the octets with a character error, counted from 0.
    pub errors: Vec<usize>,
    /// Kind of the piece.
    pub kind: PieceKind,
}

/// Source of the times of octets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TimeSource {
    /// The line: each octet takes eleven bit times, and no telegram continues after T_SYN.
    #[default]
    Exact,
    /// An operating system: the time at which it delivered the chunk. A telegram may come in several chunks.
    Platform,
}

/// Divides octets that come in chunks of any size.
#[derive(Clone, Debug)]
pub struct Framer {
    times: TimeSource,
    /// The octets that are in no piece yet. All positions below count from the first one.
    octets: Vec<u8>,
    /// Positions of the octets with a character error.
    errors: VecDeque<usize>,
    /// Positions with the time of their octet, if the input has times.
    starts: VecDeque<(usize, Option<BitTime>)>,
    /// Positions between two chunks of which the second does not continue the first.
    boundaries: VecDeque<usize>,
    /// The octets before this position are in pieces.
    emitted: usize,
    /// The octets before this position are divided. They wait because they are damaged and more damaged octets may follow, or
    /// because they are in `short`.
    divided: usize,
    /// The octets before this position are examined.
    examined: usize,
    /// The best divisions of the octets from `divided` to each examined position.
    divisions: Vec<Division>,
    /// Telegrams that begin before `examined` and end after it.
    open: Vec<Candidate>,
    /// SC and tokens that are doubtful if the next octet is damaged.
    short: VecDeque<Candidate>,
    /// The last divided octet is damaged, or part of a doubtful telegram.
    is_doubtful: bool,
    work: u64,
}

/// A possible telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Candidate {
    from: usize,
    to: usize,
    /// It has a check octet.
    is_checked: bool,
}

/// Best division of the octets up to a position.
#[derive(Clone, Copy, Debug, Default)]
struct Division {
    score: Score,
    /// The telegram that ends here; otherwise the octet before is damaged.
    last: Option<Candidate>,
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
    /// A framer for octets with times of this source.
    #[must_use]
    pub fn new(times: TimeSource) -> Self {
        Self {
            times,
            octets: Vec::new(),
            errors: VecDeque::new(),
            starts: VecDeque::new(),
            boundaries: VecDeque::from([0]),
            emitted: 0,
            divided: 0,
            examined: 0,
            divisions: vec![Division::default()],
            open: Vec::new(),
            short: VecDeque::new(),
            is_doubtful: false,
            work: 0,
        }
    }

    /// The number of octets that are in no piece yet: at most [`MAX_DAMAGED`] that are damaged, [`MAX_CHAIN`] in telegrams that
    /// overlap each other, and one longest telegram.
    #[must_use]
    pub fn held(&self) -> usize {
        self.octets.len()
    }

    /// The number of steps so far: octets examined, alone and as part of telegrams, and octets divided again. It shows that the work is
    /// proportional to the number of octets.
    #[must_use]
    pub const fn work(&self) -> u64 {
        self.work
    }

    /// Adds a chunk. Appends the pieces that later octets cannot change to `out`.
    pub fn push(&mut self, chunk: &Chunk, out: &mut Vec<Piece>) {
        let at = self.octets.len();
        self.starts.push_back((at, chunk.start));
        self.octets.extend_from_slice(&chunk.octets);
        let errors = chunk.errors.iter().filter(|position| **position < chunk.octets.len());
        self.errors.extend(errors.map(|position| at.saturating_add(*position)));
        if !chunk.is_continued {
            self.add_boundary();
        }
        self.examine(0, out);
        self.drop_emitted();
    }

    /// Appends all pieces that are left to `out`: after a silent line or at the end of the input no telegram continues.
    pub fn flush(&mut self, out: &mut Vec<Piece>) {
        self.examine(self.octets.len(), out);
        self.emit_waiting(out);
        self.is_doubtful = false;
        self.drop_emitted();
        self.add_boundary();
    }

    /// Appends the pieces to `out` that begin with octets received before `limit`: a telegram that began so early and is not
    /// complete is damaged.
    pub fn give_up(&mut self, limit: BitTime, out: &mut Vec<Piece>) {
        let is_later = |start: &Option<BitTime>| start.is_none_or(|start| start >= limit);
        let later = self.starts.iter().find(|(_, start)| is_later(start)).map(|(at, _)| *at);
        let old = later.unwrap_or(self.octets.len());
        if old == 0 {
            return;
        }
        self.examine(old, out);
        if self.divided < old && !self.open.is_empty() {
            self.divide_early(out);
        }
        self.emit_waiting(out);
        self.drop_emitted();
    }

    fn add_boundary(&mut self) {
        if self.boundaries.back() != Some(&self.octets.len()) {
            self.boundaries.push_back(self.octets.len());
        }
    }

    fn is_boundary(&self, at: usize) -> bool {
        self.boundaries.binary_search(&at).is_ok()
    }

    /// Examines the octets up to the first one with which an incomplete telegram may begin. Telegrams that begin before `old` are not
    /// awaited.
    fn examine(&mut self, old: usize, out: &mut Vec<Piece>) {
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
    fn divide_early(&mut self, out: &mut Vec<Piece>) {
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

    /// Adds the octets up to `to`, which are damaged.
    fn add_damaged(&mut self, to: usize, out: &mut Vec<Piece>) {
        if self.is_boundary(self.divided) {
            self.emit_short(PieceKind::Valid, out);
        } else {
            self.emit_short(PieceKind::Doubtful, out);
        }
        (self.divided, self.is_doubtful) = (to, true);
        while self.divided.saturating_sub(self.emitted) >= MAX_DAMAGED {
            self.emit(self.emitted.saturating_add(MAX_DAMAGED), PieceKind::Damaged, out);
        }
    }

    fn add_telegram(&mut self, telegram: Candidate, out: &mut Vec<Piece>) {
        let is_boundary = self.is_boundary(telegram.from);
        if is_boundary || telegram.is_checked {
            self.emit_short(PieceKind::Valid, out);
        }
        if self.short.is_empty() {
            self.emit(telegram.from, PieceKind::Damaged, out);
        }
        self.is_doubtful &= !is_boundary && !telegram.is_checked;
        self.divided = telegram.to;
        if telegram.is_checked {
            return self.emit(telegram.to, PieceKind::Valid, out);
        }
        if self.is_doubtful {
            return self.emit(telegram.to, PieceKind::Doubtful, out);
        }
        self.short.push_back(telegram);
        if self.is_boundary(telegram.to) {
            self.emit_short(PieceKind::Valid, out);
        } else if self.short.len() > MAX_SHORT
            && let Some(first) = self.short.pop_front()
        {
            self.emit(first.to, PieceKind::Valid, out);
        }
    }

    /// Appends the SC and tokens that wait to `out`.
    fn emit_short(&mut self, kind: PieceKind, out: &mut Vec<Piece>) {
        while let Some(telegram) = self.short.pop_front() {
            self.emit(telegram.to, kind, out);
        }
    }

    /// Appends the divided octets that wait to `out`.
    fn emit_waiting(&mut self, out: &mut Vec<Piece>) {
        self.emit_short(PieceKind::Valid, out);
        self.emit(self.divided, PieceKind::Damaged, out);
    }

    /// Appends the octets up to `to` as one piece to `out`, if there are any.
    fn emit(&mut self, to: usize, kind: PieceKind, out: &mut Vec<Piece>) {
        let from = self.emitted;
        if to <= from {
            return;
        }
        let octets = self.octets.get(from..to).unwrap_or_default().to_vec();
        let mut errors = Vec::new();
        while let Some(error) = self.errors.pop_front_if(|error| *error < to) {
            errors.push(error.saturating_sub(from));
        }
        while self.starts.get(1).is_some_and(|(at, _)| *at <= from) {
            self.starts.pop_front();
        }
        let start = self.starts.front().and_then(|(at, start)| {
            let before = from.saturating_sub(*at);
            start.map(|start| start + passed_tbit(self.times, before))
        });
        out.push(Piece { start, octets, errors, kind });
        self.emitted = to;
    }

    /// Removes the octets that are in pieces, and moves all positions.
    fn drop_emitted(&mut self) {
        let gone = std::mem::take(&mut self.emitted);
        if gone == 0 {
            return;
        }
        self.octets.drain(..gone);
        self.errors.iter_mut().for_each(|at| *at = at.saturating_sub(gone));
        while self.boundaries.pop_front_if(|at| *at < gone).is_some() {}
        self.boundaries.iter_mut().for_each(|at| *at = at.saturating_sub(gone));
        while self.starts.get(1).is_some_and(|(at, _)| *at <= gone) {
            self.starts.pop_front();
        }
        for (at, start) in &mut self.starts {
            // The rest of a chunk becomes a chunk with a later start.
            let passed = passed_tbit(self.times, gone.saturating_sub(*at));
            *start = start.map(|start| start + passed);
            *at = at.saturating_sub(gone);
        }
        self.divided = self.divided.saturating_sub(gone);
        self.examined = self.examined.saturating_sub(gone);
        for candidate in self.open.iter_mut().chain(&mut self.short) {
            candidate.shift(gone);
        }
        for division in &mut self.divisions {
            if let Some(last) = &mut division.last {
                last.shift(gone);
            }
        }
    }
}

impl Candidate {
    const fn shift(&mut self, gone: usize) {
        (self.from, self.to) = (self.from.saturating_sub(gone), self.to.saturating_sub(gone));
    }
}

impl Default for Framer {
    fn default() -> Self {
        Self::new(TimeSource::default())
    }
}

/// Time from the start of a chunk to its octet number `count`.
const fn passed_tbit(times: TimeSource, count: usize) -> u64 {
    match times {
        TimeSource::Exact => (count as u64).saturating_mul(CHARACTER_TBIT),
        TimeSource::Platform => 0,
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

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_sim::Random;
    use profivac_sim::scenario::hex;
    use profivac_wire::DataTelegram;

    fn chunk(octets: &[u8]) -> Chunk {
        Chunk { octets: octets.to_vec(), ..Chunk::default() }
    }

    fn framed(chunks: &[&[u8]]) -> Vec<Piece> {
        let (mut framer, mut out) = (Framer::default(), Vec::new());
        chunks.iter().for_each(|octets| framer.push(&chunk(octets), &mut out));
        framer.flush(&mut out);
        out
    }

    fn kinds_and_octets(pieces: &[Piece]) -> Vec<(PieceKind, String)> {
        pieces.iter().map(|piece| (piece.kind, profivac_sim::describe::Hex(&piece.octets).to_string())).collect()
    }

    fn random_telegram(random: &mut Random, checked: bool) -> Vec<u8> {
        let du: Vec<u8> = (0..random.below(30)).map(|_| random.octet()).collect();
        let (da, sa) = (random.octet() & 0x7F, random.octet() & 0x7F);
        let sap = |random: &mut Random| (random.below(2) == 0).then(|| random.octet());
        let telegram = match random.below(if checked { 6 } else { 8 }) {
            0 => Telegram::Data(DataTelegram { da, sa, dsap: None, ssap: None, fc: 0x49, du: &[] }),
            6 => Telegram::ShortAck,
            7 => Telegram::Token { da: da.min(126), sa: sa.min(126) },
            _ => Telegram::Data(DataTelegram {
                da,
                sa,
                dsap: sap(random),
                ssap: sap(random),
                fc: random.octet(),
                du: &du,
            }),
        };
        let mut out = [0; MAX_TELEGRAM];
        let length = telegram.emit(&mut out).unwrap();
        out[..length].to_vec()
    }

    /// Damaged octets: noise, a telegram with a flipped bit, one with an octet lost or inserted, or one that was cut off.
    fn damaged_octets(random: &mut Random) -> Vec<u8> {
        let mut octets = random_telegram(random, true);
        let place = random.below(octets.len() as u64) as usize;
        match random.below(5) {
            0 => octets = (0..random.below(20)).map(|_| random.octet()).collect(),
            1 => octets[place] ^= 1 << random.below(8),
            2 => drop(octets.remove(place)),
            3 => octets.insert(place, random.octet()),
            _ => octets.truncate(place),
        }
        octets
    }

    /// The position of a telegram, and its octets.
    type Placed = (usize, Vec<u8>);

    /// Valid telegrams with damaged octets between them, and the positions of the valid ones.
    fn line(random: &mut Random) -> (Vec<Vec<u8>>, Vec<Placed>) {
        let (mut line, mut valid, mut at) = (Vec::new(), Vec::new(), 0);
        for _ in 0..10 {
            let damaged = if random.below(2) == 0 { damaged_octets(random) } else { Vec::new() };
            let telegram = random_telegram(random, false);
            valid.push((at + damaged.len(), telegram.clone()));
            at += damaged.len() + telegram.len();
            line.extend([damaged, telegram]);
        }
        (line, valid)
    }

    /// The pieces of a line and their positions: with the time of each chunk, or in random chunks without times.
    fn pieces(random: &mut Random, line: &[Vec<u8>], timed: bool) -> Vec<(usize, Piece)> {
        let (mut framer, mut pieces, octets) = (Framer::default(), Vec::new(), line.concat());
        if timed {
            for (number, octets) in (0..).zip(line) {
                framer.push(&Chunk { start: Some(BitTime(number * 10_000)), ..chunk(octets) }, &mut pieces);
                framer.flush(&mut pieces);
            }
        } else {
            let mut rest = &octets[..];
            while !rest.is_empty() {
                let (octets, more) = rest.split_at(rest.len().min(1 + random.below(40) as usize));
                framer.push(&chunk(octets), &mut pieces);
                rest = more;
            }
            framer.flush(&mut pieces);
        }
        assert_eq!(
            pieces.iter().flat_map(|piece| piece.octets.clone()).collect::<Vec<_>>(),
            octets,
            "the pieces have all octets of the line"
        );
        let mut at = 0;
        let begins = pieces.into_iter().map(|piece| {
            at += piece.octets.len();
            (at - piece.octets.len(), piece)
        });
        begins.collect()
    }

    #[test]
    fn with_times_the_framer_finds_every_valid_telegram_between_damaged_octets() {
        let mut random = Random::new(8);
        for _ in 0..4_000 {
            let (line, valid) = line(&mut random);
            let pieces = pieces(&mut random, &line, true);
            for (at, telegram) in valid {
                let found = |(from, piece): &(usize, Piece)| {
                    *from == at && piece.octets == telegram && piece.kind == PieceKind::Valid
                };
                assert!(pieces.iter().any(found), "{telegram:02X?} in {line:02X?}");
            }
        }
    }

    /// Without times two divisions are possible for a token whose last octet completes a damaged telegram, and for an SD1 at the
    /// announced end of a telegram that was cut off. The framer finds every longer telegram.
    #[test]
    fn without_times_the_framer_misses_only_telegrams_of_six_octets_or_less_inside_longer_ones() {
        let (mut random, mut missed) = (Random::new(9), 0);
        for _ in 0..4_000 {
            let (line, valid) = line(&mut random);
            let pieces = pieces(&mut random, &line, false);
            for (at, telegram) in valid {
                let found = |(from, piece): &(usize, Piece)| {
                    *from == at && piece.octets == telegram && piece.kind != PieceKind::Damaged
                };
                if pieces.iter().any(found) {
                    continue;
                }
                let overlaps = |(from, piece): &&(usize, Piece)| {
                    piece.kind == PieceKind::Valid && *from < at + telegram.len() && at < from + piece.octets.len()
                };
                let longer = pieces.iter().find(|piece| overlaps(piece) && piece.1.octets.len() > telegram.len());
                assert!(telegram.len() <= 6 && longer.is_some(), "{telegram:02X?} in {line:02X?}");
                missed += 1;
            }
        }
        assert!(missed < 10, "{missed} of 40000");
    }

    #[test]
    fn the_framer_takes_telegrams_inside_the_data_of_a_valid_one_for_data() {
        // FDL_Status, SC and a token in the data of a Data_Exchange.
        let outer = hex("68 0D 0D 68 08 02 7D 10 08 02 49 53 16 E5 DC 02 02 18 16");
        assert_eq!(
            kinds_and_octets(&framed(&[&outer])),
            [(PieceKind::Valid, profivac_sim::describe::Hex(&outer).to_string())]
        );
        // If the outer telegram is damaged, the inner ones are pieces: valid with a check octet, doubtful without one.
        let mut damaged = outer;
        damaged[17] ^= 1;
        let expected = [
            (PieceKind::Damaged, "68 0D 0D 68 08 02 7D"),
            (PieceKind::Valid, "10 08 02 49 53 16"),
            (PieceKind::Doubtful, "E5"),
            (PieceKind::Doubtful, "DC 02 02"),
            (PieceKind::Damaged, "19 16"),
        ];
        assert_eq!(kinds_and_octets(&framed(&[&damaged])), expected.map(|(kind, text)| (kind, text.to_owned())));
    }

    #[test]
    fn the_framer_finds_an_sd3_but_prefers_two_other_telegrams() {
        let sd3 = hex("A2 08 02 7D 01 02 03 04 05 06 07 08 AB 16");
        assert_eq!(framed(&[&sd3])[0].kind, PieceKind::Valid);
        // The check octet and the end delimiter of the SD3 fit by chance.
        let octets = hex("A2 DE 10 1A 13 49 76 16 10 42 24 49 AF 16");
        let expected = [
            (PieceKind::Damaged, "A2 DE"),
            (PieceKind::Valid, "10 1A 13 49 76 16"),
            (PieceKind::Valid, "10 42 24 49 AF 16"),
        ];
        assert!(Telegram::parse(&octets).is_ok());
        assert_eq!(
            kinds_and_octets(&framed(&[&[0], &octets])[1..]),
            expected[1..].iter().map(|(kind, text)| (*kind, (*text).to_owned())).collect::<Vec<_>>()
        );
    }

    #[test]
    fn the_framer_prefers_a_telegram_with_a_check_octet_to_a_token_that_overlaps_it() {
        let octets = hex("DC 10 08 02 49 53 16");
        let expected = [(PieceKind::Damaged, "DC"), (PieceKind::Valid, "10 08 02 49 53 16")];
        assert_eq!(kinds_and_octets(&framed(&[&octets])), expected.map(|(kind, text)| (kind, text.to_owned())));
    }

    #[test]
    fn the_framer_puts_an_octet_with_a_character_error_into_a_damaged_piece() {
        let (mut framer, mut out) = (Framer::default(), Vec::new());
        let octets = chunk(&hex("10 08 02 49 53 16 E5"));
        framer.push(&Chunk { start: Some(BitTime(100)), errors: vec![2], ..octets }, &mut out);
        framer.flush(&mut out);
        assert_eq!(
            kinds_and_octets(&out),
            [(PieceKind::Damaged, "10 08 02 49 53 16".to_owned()), (PieceKind::Doubtful, "E5".to_owned())]
        );
        assert_eq!((out[0].errors.as_slice(), out[1].start), (&[2][..], Some(BitTime(166))));
    }

    #[test]
    fn the_framer_returns_a_complete_telegram_at_once_and_damaged_octets_with_the_next_telegram() {
        let (mut framer, mut out) = (Framer::default(), Vec::new());
        framer.push(&chunk(&hex("68 05 05 68 88 82 6D")), &mut out);
        assert!(out.is_empty());
        framer.push(&chunk(&hex("3C 3E F1 16")), &mut out);
        assert_eq!(out.len(), 1);
        framer.push(&chunk(&hex("68 05 05 68 88")), &mut out);
        framer.push(&chunk(&hex("10 08 02 49 53 16")), &mut out);
        let kinds: Vec<_> = out.iter().map(|piece| piece.kind).collect();
        assert_eq!(kinds, [PieceKind::Valid, PieceKind::Damaged, PieceKind::Valid]);
    }

    /// The noise of which each octet or each few octets may begin a telegram.
    fn periodic_noise() -> Vec<Vec<u8>> {
        let every = |octet: u8, period: usize| [&[octet][..], &vec![0; period - 1]].concat();
        let mut noise = vec![every(0x10, 6), every(0xA2, 14), every(0xDC, 3), every(0x68, 4)];
        noise.extend([vec![0x68], vec![0x10], vec![0], vec![0xE5], vec![0xDC], vec![0xFF], vec![0xDC, 1, 2]]);
        // Headers of the longest telegram, telegrams inside telegrams, and a telegram without end.
        noise.extend([hex("68 F9 F9 68"), hex("68 03 03 68 10 00 00 00 00 16 16"), hex("68 68 68 68 16")]);
        noise
    }

    #[test]
    fn the_work_is_proportional_to_the_octets_of_any_noise_and_few_octets_are_held() {
        for noise in periodic_noise() {
            for portion in [1, 7, 4096] {
                let (mut framer, mut out, mut work) = (Framer::default(), Vec::new(), Vec::new());
                let mut octets = noise.iter().copied().cycle();
                for _ in 0..4 {
                    for _ in 0..40_960 / portion {
                        let octets: Vec<u8> = octets.by_ref().take(portion).collect();
                        framer.push(&Chunk { is_continued: true, ..chunk(&octets) }, &mut out);
                        out.clear();
                        let longest = MAX_DAMAGED + MAX_CHAIN + MAX_TELEGRAM;
                        assert!(framer.held() <= longest, "{noise:02X?}: {}", framer.held());
                    }
                    work.push(framer.work());
                }
                // The last quarter is not more work than the second one; the first octets of each wait for those behind.
                assert!(work[3] - work[2] <= work[1] - work[0] + 10_000, "{noise:02X?} in {portion}: {work:?}");
                assert!(work[3] <= 4 * 40_960 * 2 * MAX_TELEGRAM as u64, "{noise:02X?} in {portion}: {work:?}");
            }
        }
    }

    /// Chunks that continue each other have the pieces of one chunk.
    #[test]
    fn the_pieces_do_not_depend_on_the_sizes_of_portions() {
        let mut random = Random::new(10);
        for _ in 0..1_000 {
            let octets = line(&mut random).0.concat();
            let whole = framed(&[&octets]);
            let (mut framer, mut out, mut rest) = (Framer::default(), Vec::new(), &octets[..]);
            while !rest.is_empty() {
                let (part, more) = rest.split_at(rest.len().min(1 + random.below(40) as usize));
                framer.push(&Chunk { is_continued: !more.is_empty(), ..chunk(part) }, &mut out);
                rest = more;
            }
            framer.flush(&mut out);
            assert_eq!(out, whole, "{octets:02X?}");
        }
    }

    #[test]
    fn the_framer_gives_up_a_telegram_that_began_too_early() {
        let (mut framer, mut out) = (Framer::new(TimeSource::Platform), Vec::new());
        framer.push(&Chunk { start: Some(BitTime(100)), ..chunk(&hex("00 68 05 05 68 88")) }, &mut out);
        framer.push(&Chunk { start: Some(BitTime(200)), ..chunk(&hex("68 05 05 68")) }, &mut out);
        framer.give_up(BitTime(100), &mut out);
        assert!(out.is_empty());
        framer.give_up(BitTime(101), &mut out);
        assert_eq!(kinds_and_octets(&out), [(PieceKind::Damaged, "00 68 05 05 68 88".to_owned())]);
        framer.push(&Chunk { start: Some(BitTime(300)), ..chunk(&hex("88 82 6D 3C 3E F1 16")) }, &mut out);
        assert_eq!((out.len(), out[1].kind, out[1].start), (2, PieceKind::Valid, Some(BitTime(200))));
    }
}
