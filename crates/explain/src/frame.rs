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
const MAX_DAMAGED: usize = 1024;

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

/// Start of a chunk.
#[derive(Clone, Copy, Debug)]
struct ChunkStart {
    /// Position of its first octet.
    at: usize,
    start: Option<BitTime>,
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
#[derive(Clone, Debug, Default)]
pub struct Framer {
    times: TimeSource,
    octets: Vec<u8>,
    has_error: Vec<bool>,
    chunks: VecDeque<ChunkStart>,
}

/// A range of the octets that are not settled yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Span {
    from: usize,
    to: usize,
    kind: PieceKind,
}

impl Framer {
    /// A framer for octets with times of this source.
    #[must_use]
    pub fn new(times: TimeSource) -> Self {
        Self { times, ..Self::default() }
    }

    /// Time from the start of a chunk to its octet number `count`.
    const fn passed_tbit(&self, count: usize) -> u64 {
        match self.times {
            TimeSource::Exact => (count as u64).saturating_mul(CHARACTER_TBIT),
            TimeSource::Platform => 0,
        }
    }

    /// Adds a chunk of octets. `errors` are the positions of octets with a character error. Appends the pieces that later
    /// octets cannot change to `out`.
    pub fn push(&mut self, start: Option<BitTime>, octets: &[u8], errors: &[usize], out: &mut Vec<Piece>) {
        let at = self.octets.len();
        self.chunks.push_back(ChunkStart { at, start });
        self.octets.extend_from_slice(octets);
        self.has_error.resize(self.octets.len(), false);
        for place in errors {
            if let Some(has_error) = self.has_error.get_mut(at.saturating_add(*place)) {
                *has_error = true;
            }
        }
        self.emit_settled(false, out);
    }

    /// Appends all pieces that are left to `out`: after a silent line or at the end of the input no telegram continues.
    pub fn flush(&mut self, out: &mut Vec<Piece>) {
        self.emit_settled(true, out);
    }

    fn emit_settled(&mut self, ended: bool, out: &mut Vec<Piece>) {
        if self.octets.is_empty() {
            return;
        }
        let spans = self.divide();
        let settled = if ended { self.octets.len() } else { self.settled(&spans) };
        let mut done = 0;
        for span in spans.iter().take_while(|span| span.to <= settled) {
            out.push(self.piece(*span));
            done = span.to;
        }
        // A span in which a telegram may begin waits as a whole.
        self.drop_settled(done);
    }

    /// The best division. A chunk that is one telegram with a check octet needs no search: ordinary traffic comes like this.
    fn divide(&self) -> Vec<Span> {
        if self.chunks.len() == 1 && self.candidate(0) == Some((self.octets.len(), true)) {
            return vec![Span { from: 0, to: self.octets.len(), kind: PieceKind::Valid }];
        }
        // From the last octet to the first: the best score of the octets from here on, and the telegram that begins here.
        let mut best = vec![(Score::default(), None); self.octets.len().saturating_add(1)];
        let mut ends = vec![false; best.len()];
        for from in (0..self.octets.len()).rev() {
            let mut choice = (score_from(&best, from.saturating_add(1)), None);
            let end_is_taken = |length: usize| ends.get(from.saturating_add(length)).is_some_and(|taken| *taken);
            let candidate = self.candidate(from).filter(|(length, checked)| !(*checked && end_is_taken(*length)));
            if let Some((length, checked)) = candidate {
                let takes_end = checked && (self.octets.get(from) == Some(&SD2) || self.begins_chunk(from));
                if let Some(end) = ends.get_mut(from.saturating_add(length)).filter(|_| takes_end) {
                    *end = true;
                }
                let counted = if self.octets.get(from) == Some(&SD3) { SD3_SCORE } else { length };
                let with_telegram = score_from(&best, from.saturating_add(length)).plus(counted, checked);
                if with_telegram >= choice.0 {
                    choice = (with_telegram, Some((length, checked)));
                }
            }
            if let Some(place) = best.get_mut(from) {
                *place = choice;
            }
        }
        let spans = spans_of(&best.into_iter().map(|(_, chosen)| chosen).collect::<Vec<_>>());
        self.mark_doubtful(spans)
    }

    /// The telegram that begins at `from`: its length, and whether it has a check octet.
    fn candidate(&self, from: usize) -> Option<(usize, bool)> {
        let rest = self.octets.get(from..)?;
        let TelegramLength::Known(length) = TelegramLength::of(rest) else { return None };
        let length = usize::from(length);
        let octets = rest.get(..length)?;
        let has_error = self.has_error.iter().skip(from).take(length).any(|error| *error);
        match Telegram::parse(octets).ok().filter(|_| !has_error)? {
            Telegram::Token { da, sa } => (da.max(sa) <= MAX_ADDRESS).then_some((length, false)),
            Telegram::ShortAck => Some((length, false)),
            Telegram::Data(_) => Some((length, true)),
        }
    }

    /// Marks the telegrams without a check octet that touch damaged octets of the same chunk.
    fn mark_doubtful(&self, mut spans: Vec<Span>) -> Vec<Span> {
        let damaged: Vec<bool> = spans.iter().map(|span| span.kind == PieceKind::Damaged).collect();
        let touches = |number: Option<usize>, at: usize| {
            let neighbour = number.and_then(|number| damaged.get(number)).is_some_and(|damaged| *damaged);
            neighbour && !self.begins_chunk(at)
        };
        // A sequence of short telegrams is doubtful if its first or its last one is.
        let count = spans.len();
        let mut doubtful = vec![false; count];
        for number in (0..count).chain((0..count).rev()) {
            let Some(span) = spans.get(number) else { continue };
            let near = |other: Option<usize>| other.and_then(|other| doubtful.get(other)).is_some_and(|doubt| *doubt);
            let (before, after) = (number.checked_sub(1), number.checked_add(1));
            let doubt = touches(before, span.from)
                || touches(after, span.to)
                || (near(before) && !self.begins_chunk(span.from))
                || (near(after) && !self.begins_chunk(span.to));
            let short = span.kind == PieceKind::Valid && !self.is_checked(*span);
            if let Some(place) = doubtful.get_mut(number) {
                *place |= short && doubt;
            }
        }
        for (span, doubtful) in spans.iter_mut().zip(doubtful) {
            if doubtful {
                span.kind = PieceKind::Doubtful;
            }
        }
        spans
    }

    fn begins_chunk(&self, at: usize) -> bool {
        self.chunks.iter().any(|chunk| chunk.at == at)
    }

    fn is_checked(&self, span: Span) -> bool {
        self.candidate(span.from).is_some_and(|(_, checked)| checked)
    }

    /// The end of the octets that later octets cannot change: the first octet with which an incomplete telegram may begin.
    /// Octets inside a telegram with a check octet count as data.
    fn settled(&self, spans: &[Span]) -> usize {
        let unchecked = spans.iter().filter(|span| !self.is_checked(**span));
        let open = unchecked.flat_map(|span| span.from..span.to).find(|place| self.is_incomplete(*place));
        match (open, spans.last()) {
            (Some(open), _) => open,
            // Damaged octets at the end wait for those that follow, to form one piece.
            (None, Some(Span { from, to, kind: PieceKind::Damaged })) if to.saturating_sub(*from) < MAX_DAMAGED => {
                *from
            }
            (None, _) => self.octets.len(),
        }
    }

    /// Whether a telegram may begin at `from` that continues after the last octet.
    fn is_incomplete(&self, from: usize) -> bool {
        // Only the last octets matter: a telegram that begins before them would be complete.
        let Some(rest) = self.octets.get(from..).filter(|rest| rest.len() < MAX_TELEGRAM) else { return false };
        if self.has_error.iter().skip(from).any(|error| *error) {
            return false;
        }
        match TelegramLength::of(rest) {
            TelegramLength::Incomplete => true,
            TelegramLength::Known(length) => usize::from(length) > rest.len(),
            TelegramLength::Invalid(_) => false,
        }
    }

    fn piece(&self, span: Span) -> Piece {
        let octets = self.octets.get(span.from..span.to).unwrap_or_default().to_vec();
        let flags = self.has_error.iter().skip(span.from).take(octets.len());
        let errors = flags.enumerate().filter(|(_, has_error)| **has_error).map(|(place, _)| place).collect();
        let chunk = self.chunks.iter().rev().find(|chunk| chunk.at <= span.from);
        let start = chunk.and_then(|chunk| {
            let before = span.from.saturating_sub(chunk.at);
            chunk.start.map(|start| start + self.passed_tbit(before))
        });
        Piece { start, octets, errors, kind: span.kind }
    }

    fn drop_settled(&mut self, done: usize) {
        self.octets.drain(..done);
        self.has_error.drain(..done);
        let mut last = None;
        while let Some(chunk) = self.chunks.pop_front_if(|chunk| chunk.at <= done) {
            last = Some(chunk);
        }
        self.chunks.iter_mut().for_each(|chunk| chunk.at = chunk.at.saturating_sub(done));
        // The rest of a chunk that is settled in part becomes a chunk with a later start.
        if let Some(ChunkStart { at, start }) = last.filter(|_| !self.octets.is_empty()) {
            let passed = self.passed_tbit(done.saturating_sub(at));
            self.chunks.push_front(ChunkStart { at: 0, start: start.map(|start| start + passed) });
        }
    }
}

/// Score of a division: octets in telegrams with a check octet, then octets in other telegrams.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Score {
    checked: usize,
    others: usize,
}

impl Score {
    const fn plus(self, length: usize, checked: bool) -> Self {
        if checked {
            Self { checked: self.checked.saturating_add(length), ..self }
        } else {
            Self { others: self.others.saturating_add(length), ..self }
        }
    }
}

/// The telegram chosen at an octet: its length, and whether it has a check octet.
type Chosen = Option<(usize, bool)>;

fn score_from(best: &[(Score, Chosen)], from: usize) -> Score {
    best.get(from).map(|(score, _)| *score).unwrap_or_default()
}

/// The spans of the telegrams chosen at each octet.
fn spans_of(chosen: &[Chosen]) -> Vec<Span> {
    let (mut spans, mut from): (Vec<Span>, usize) = (Vec::new(), 0);
    let end = chosen.len().saturating_sub(1);
    while from < end {
        let length = chosen.get(from).copied().flatten().map(|(length, _)| length);
        let to = from.saturating_add(length.unwrap_or(1));
        let kind = if length.is_some() { PieceKind::Valid } else { PieceKind::Damaged };
        match spans.last_mut() {
            Some(last) if last.kind == PieceKind::Damaged && kind == PieceKind::Damaged => last.to = to,
            _ => spans.push(Span { from, to, kind }),
        }
        from = to;
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_sim::Random;
    use profivac_sim::scenario::hex;
    use profivac_wire::DataTelegram;

    fn framed(chunks: &[&[u8]]) -> Vec<Piece> {
        let (mut framer, mut out) = (Framer::default(), Vec::new());
        chunks.iter().for_each(|chunk| framer.push(None, chunk, &[], &mut out));
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
            for (number, chunk) in (0..).zip(line) {
                framer.push(Some(BitTime(number * 10_000)), chunk, &[], &mut pieces);
                framer.flush(&mut pieces);
            }
        } else {
            let mut rest = &octets[..];
            while !rest.is_empty() {
                let (chunk, more) = rest.split_at(rest.len().min(1 + random.below(40) as usize));
                framer.push(None, chunk, &[], &mut pieces);
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
        framer.push(Some(BitTime(100)), &hex("10 08 02 49 53 16 E5"), &[2], &mut out);
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
        framer.push(None, &hex("68 05 05 68 88 82 6D"), &[], &mut out);
        assert!(out.is_empty());
        framer.push(None, &hex("3C 3E F1 16"), &[], &mut out);
        assert_eq!(out.len(), 1);
        framer.push(None, &hex("68 05 05 68 88"), &[], &mut out);
        framer.push(None, &hex("10 08 02 49 53 16"), &[], &mut out);
        let kinds: Vec<_> = out.iter().map(|piece| piece.kind).collect();
        assert_eq!(kinds, [PieceKind::Valid, PieceKind::Damaged, PieceKind::Valid]);
    }

    #[test]
    fn the_framer_holds_a_limited_number_of_octets_of_endless_noise() {
        let (mut framer, mut out) = (Framer::default(), Vec::new());
        for _ in 0..1000 {
            framer.push(None, &[0; 100], &[], &mut out);
            assert!(framer.octets.len() <= MAX_DAMAGED + 100);
        }
        assert!(out.len() > 50);
    }
}
