//! Octets into telegrams, and what is left of them.
//!
//! Of all ways to divide octets into telegrams and damaged pieces, the one counts that explains most octets by telegrams
//! with a check octet (SD1, SD2, SD3), and among those the one that explains most by others. So a valid telegram is never
//! lost because of what stands beside it: something else can only take its place if it is longer, overlaps it, and has a
//! check octet and an end delimiter that fit by chance. What looks like a telegram inside the data of a valid one is
//! data. SD3 has neither a length octet nor any other protection of its 14 octets, so an A2 before two telegrams becomes one
//! easily: it counts less than the shortest of the others. Of two telegrams that end together the shorter one is meant, if it
//! is an SD2 or begins what came together: the data of a telegram may hold a telegram, but not with its own check octet at
//! the end, while one that was cut off may well be as long as it announced once the next one has followed.
//!
//! SC and the token have no check octet, so any E5 among damaged octets looks like one. They are kept, because a valid one
//! may stand there, and are [`Sort::Doubtful`] where they touch damaged octets that came in the same piece.

use profivac_dp::link::{BitTime, CHARACTER_TBIT};
use profivac_wire::{MAX_TELEGRAM, Telegram, TelegramLength};
use std::collections::VecDeque;

/// The highest address in a token: the EXT bit and everybody cannot be.
const MAX_ADDRESS: u8 = 126;

/// What an SD3 counts: less than the 6 octets of an SD1.
const SD3_SCORE: usize = 5;
const SD3: u8 = 0xA2;
const SD2: u8 = 0x68;

/// So many octets without a telegram are told before there are more.
const MAX_DAMAGED: usize = 1024;

/// What octets are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceKind {
    /// A telegram.
    Valid,
    /// SC or a token that may be part of something damaged.
    Doubtful,
    /// No telegram.
    Damaged,
}

/// A telegram, or octets between telegrams.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// When it began, if that is known.
    pub start: Option<BitTime>,
    /// The octets.
    pub octets: Vec<u8>,
    /// The numbers of those that came with a character error, counted from 0.
    pub errors: Vec<usize>,
    /// What they are.
    pub kind: PieceKind,
}

/// Where octets came from.
#[derive(Clone, Copy, Debug)]
struct ChunkStart {
    /// The first octet that came together.
    at: usize,
    start: Option<BitTime>,
}

/// What the times of octets are worth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TimeSource {
    /// Those of the line: octets follow each other in eleven bit times, and no telegram goes on after T_SYN.
    #[default]
    Exact,
    /// Those of an operating system: when a piece was handed over. A telegram may come in pieces.
    Platform,
}

/// Divides octets that come in pieces of any size.
#[derive(Clone, Debug, Default)]
pub struct Framer {
    times: TimeSource,
    octets: Vec<u8>,
    has_error: Vec<bool>,
    marks: VecDeque<ChunkStart>,
}

/// A stretch of the octets at hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Span {
    from: usize,
    to: usize,
    kind: PieceKind,
}

impl Framer {
    /// For octets with such times.
    #[must_use]
    pub fn new(times: TimeSource) -> Self {
        Self { times, ..Self::default() }
    }

    /// How long after the beginning of a piece its `count`th octet began.
    const fn passed_tbit(&self, count: usize) -> u64 {
        match self.times {
            TimeSource::Exact => (count as u64).saturating_mul(CHARACTER_TBIT),
            TimeSource::Platform => 0,
        }
    }

    /// Octets came that follow those before. `errors` are the numbers of those with a character error. What is settled by
    /// them is appended to `out`.
    pub fn push(&mut self, start: Option<BitTime>, octets: &[u8], errors: &[usize], out: &mut Vec<Piece>) {
        let at = self.octets.len();
        self.marks.push_back(ChunkStart { at, start });
        self.octets.extend_from_slice(octets);
        self.has_error.resize(self.octets.len(), false);
        for place in errors {
            if let Some(wrong) = self.has_error.get_mut(at.saturating_add(*place)) {
                *wrong = true;
            }
        }
        self.emit_settled(false, out);
    }

    /// The line was silent, or there is no more: nothing that is to come belongs to what is here.
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
        // A piece in which something may begin waits as a whole.
        self.drop_settled(done);
    }

    /// The best division. Ordinary traffic comes in pieces of one telegram: there is nothing to weigh.
    fn divide(&self) -> Vec<Span> {
        if self.marks.len() == 1 && self.candidate(0) == Some((self.octets.len(), true)) {
            return vec![Span { from: 0, to: self.octets.len(), kind: PieceKind::Valid }];
        }
        // From behind: what the octets from here on are worth at best, and with which telegram that begins.
        let mut best = vec![(Score::default(), None); self.octets.len().saturating_add(1)];
        let mut ends = vec![false; best.len()];
        for from in (0..self.octets.len()).rev() {
            let mut choice = (worth(&best, from.saturating_add(1)), None);
            let end_is_taken = |length: usize| ends.get(from.saturating_add(length)).is_some_and(|taken| *taken);
            let candidate = self.candidate(from).filter(|(length, checked)| !(*checked && end_is_taken(*length)));
            if let Some((length, checked)) = candidate {
                let claims = checked && (self.octets.get(from) == Some(&SD2) || self.begins_piece(from));
                if let Some(end) = ends.get_mut(from.saturating_add(length)).filter(|_| claims) {
                    *end = true;
                }
                let counted = if self.octets.get(from) == Some(&SD3) { SD3_SCORE } else { length };
                let taken = worth(&best, from.saturating_add(length)).plus(counted, checked);
                if taken >= choice.0 {
                    choice = (taken, Some((length, checked)));
                }
            }
            if let Some(place) = best.get_mut(from) {
                *place = choice;
            }
        }
        let spans = walk(&best.into_iter().map(|(_, chosen)| chosen).collect::<Vec<_>>());
        self.mark_doubtful(spans)
    }

    /// The telegram that begins here: its length, and whether it has a check octet.
    fn candidate(&self, from: usize) -> Option<(usize, bool)> {
        let rest = self.octets.get(from..)?;
        let TelegramLength::Known(length) = TelegramLength::of(rest) else { return None };
        let length = usize::from(length);
        let octets = rest.get(..length)?;
        let spoiled = self.has_error.iter().skip(from).take(length).any(|wrong| *wrong);
        match Telegram::parse(octets).ok().filter(|_| !spoiled)? {
            Telegram::Token { da, sa } => (da.max(sa) <= MAX_ADDRESS).then_some((length, false)),
            Telegram::ShortAck => Some((length, false)),
            Telegram::Data(_) => Some((length, true)),
        }
    }

    /// Marks what has no check octet and touches damaged octets of the same piece.
    fn mark_doubtful(&self, mut spans: Vec<Span>) -> Vec<Span> {
        let damaged: Vec<bool> = spans.iter().map(|span| span.kind == PieceKind::Damaged).collect();
        let touches = |number: Option<usize>, at: usize| {
            let neighbour = number.and_then(|number| damaged.get(number)).is_some_and(|damaged| *damaged);
            neighbour && !self.begins_piece(at)
        };
        // A row of short telegrams is as doubtful as its first or its last.
        let count = spans.len();
        let mut doubtful = vec![false; count];
        for number in (0..count).chain((0..count).rev()) {
            let Some(span) = spans.get(number) else { continue };
            let near = |other: Option<usize>| other.and_then(|other| doubtful.get(other)).is_some_and(|doubt| *doubt);
            let (before, after) = (number.checked_sub(1), number.checked_add(1));
            let doubt = touches(before, span.from)
                || touches(after, span.to)
                || (near(before) && !self.begins_piece(span.from))
                || (near(after) && !self.begins_piece(span.to));
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

    fn begins_piece(&self, at: usize) -> bool {
        self.marks.iter().any(|mark| mark.at == at)
    }

    fn is_checked(&self, span: Span) -> bool {
        self.candidate(span.from).is_some_and(|(_, checked)| checked)
    }

    /// Up to where nothing can change any more: the first octet with which a telegram may begin that is not complete yet.
    /// What lies inside a telegram with a check octet is taken for data.
    fn settled(&self, spans: &[Span]) -> usize {
        let unchecked = spans.iter().filter(|span| !self.is_checked(**span));
        let open = unchecked.flat_map(|span| span.from..span.to).find(|place| self.is_incomplete(*place));
        match (open, spans.last()) {
            (Some(open), _) => open,
            // Damaged octets at the end are told together with those that follow.
            (None, Some(Span { from, to, kind: PieceKind::Damaged })) if to.saturating_sub(*from) < MAX_DAMAGED => {
                *from
            }
            (None, _) => self.octets.len(),
        }
    }

    /// Whether a telegram begins here that would go on behind the last octet.
    fn is_incomplete(&self, from: usize) -> bool {
        // The last octets only: a telegram that begins before them would be complete.
        let Some(rest) = self.octets.get(from..).filter(|rest| rest.len() < MAX_TELEGRAM) else { return false };
        if self.has_error.iter().skip(from).any(|wrong| *wrong) {
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
        let wrong = self.has_error.iter().skip(span.from).take(octets.len());
        let errors = wrong.enumerate().filter(|(_, wrong)| **wrong).map(|(place, _)| place).collect();
        let mark = self.marks.iter().rev().find(|mark| mark.at <= span.from);
        let start = mark.and_then(|mark| {
            let before = span.from.saturating_sub(mark.at);
            mark.start.map(|start| start + self.passed_tbit(before))
        });
        Piece { start, octets, errors, kind: span.kind }
    }

    fn drop_settled(&mut self, done: usize) {
        self.octets.drain(..done);
        self.has_error.drain(..done);
        let mut last = None;
        while let Some(mark) = self.marks.pop_front_if(|mark| mark.at <= done) {
            last = Some(mark);
        }
        self.marks.iter_mut().for_each(|mark| mark.at = mark.at.saturating_sub(done));
        // What is left of the piece in which the cut lies goes on counting from there.
        if let Some(ChunkStart { at, start }) = last.filter(|_| !self.octets.is_empty()) {
            let gone = self.passed_tbit(done.saturating_sub(at));
            self.marks.push_front(ChunkStart { at: 0, start: start.map(|start| start + gone) });
        }
    }
}

/// What a division is worth: octets of telegrams with a check octet, then octets of others.
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

/// A telegram that was chosen: its length, and whether it has a check octet.
type Chosen = Option<(usize, bool)>;

fn worth(best: &[(Score, Chosen)], from: usize) -> Score {
    best.get(from).map(|(worth, _)| *worth).unwrap_or_default()
}

/// The stretches that follow from what was chosen at each octet.
fn walk(chosen: &[Chosen]) -> Vec<Span> {
    let (mut spans, mut from): (Vec<Span>, usize) = (Vec::new(), 0);
    let end = chosen.len().saturating_sub(1);
    while from < end {
        let length = chosen.get(from).copied().flatten().map(|(length, _)| length);
        let to = from.saturating_add(length.unwrap_or(1));
        let sort = if length.is_some() { PieceKind::Valid } else { PieceKind::Damaged };
        match spans.last_mut() {
            Some(last) if last.kind == PieceKind::Damaged && sort == PieceKind::Damaged => last.to = to,
            _ => spans.push(Span { from, to, kind: sort }),
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

    fn told(pieces: &[Piece]) -> Vec<(PieceKind, String)> {
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

    /// Damage as it happens: noise, a telegram with a flipped bit, one with an octet lost or too many, one cut off.
    fn junk(random: &mut Random) -> Vec<u8> {
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

    /// A telegram and where it begins.
    type Placed = (usize, Vec<u8>);

    /// A line of valid telegrams with damage between them, and where the valid ones begin.
    fn line(random: &mut Random) -> (Vec<Vec<u8>>, Vec<Placed>) {
        let (mut line, mut valid, mut at) = (Vec::new(), Vec::new(), 0);
        for _ in 0..10 {
            let damaged = if random.below(2) == 0 { junk(random) } else { Vec::new() };
            let telegram = random_telegram(random, false);
            valid.push((at + damaged.len(), telegram.clone()));
            at += damaged.len() + telegram.len();
            line.extend([damaged, telegram]);
        }
        (line, valid)
    }

    /// The pieces of a line with the time of each chunk, or cut anywhere and without times; and where they begin.
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
        assert_eq!(pieces.iter().flat_map(|piece| piece.octets.clone()).collect::<Vec<_>>(), octets, "nothing is lost");
        let mut at = 0;
        let begins = pieces.into_iter().map(|piece| {
            at += piece.octets.len();
            (at - piece.octets.len(), piece)
        });
        begins.collect()
    }

    #[test]
    fn no_valid_telegram_is_lost_between_damaged_ones_when_times_are_known() {
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

    /// Without times a token whose last octet completes what was left of a damaged telegram has two readings, and so has an
    /// SD1 at the end of what a telegram announced that was cut off. Nothing longer is ever lost.
    #[test]
    fn without_times_only_a_longer_telegram_can_take_the_octets_of_one_of_the_shortest() {
        let (mut random, mut taken) = (Random::new(9), 0);
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
                let taker = pieces.iter().find(|piece| overlaps(piece) && piece.1.octets.len() > telegram.len());
                assert!(telegram.len() <= 6 && taker.is_some(), "{telegram:02X?} in {line:02X?}");
                taken += 1;
            }
        }
        assert!(taken < 10, "{taken} of 40000");
    }

    #[test]
    fn what_looks_like_a_telegram_inside_a_valid_one_is_data() {
        // FDL_Status, SC and a token in the data of a Data_Exchange.
        let outer = hex("68 0D 0D 68 08 02 7D 10 08 02 49 53 16 E5 DC 02 02 18 16");
        assert_eq!(told(&framed(&[&outer])), [(PieceKind::Valid, profivac_sim::describe::Hex(&outer).to_string())]);
        // If it is damaged, what is in it comes up: with a check octet as a telegram, without one as a doubtful one.
        let mut damaged = outer;
        damaged[17] ^= 1;
        let expected = [
            (PieceKind::Damaged, "68 0D 0D 68 08 02 7D"),
            (PieceKind::Valid, "10 08 02 49 53 16"),
            (PieceKind::Doubtful, "E5"),
            (PieceKind::Doubtful, "DC 02 02"),
            (PieceKind::Damaged, "19 16"),
        ];
        assert_eq!(told(&framed(&[&damaged])), expected.map(|(sort, text)| (sort, text.to_owned())));
    }

    #[test]
    fn an_sd3_is_found_but_takes_no_other_telegram() {
        let sd3 = hex("A2 08 02 7D 01 02 03 04 05 06 07 08 AB 16");
        assert_eq!(framed(&[&sd3])[0].kind, PieceKind::Valid);
        // The check octets and the end delimiter of what A2 begins fit by chance.
        let octets = hex("A2 DE 10 1A 13 49 76 16 10 42 24 49 AF 16");
        let expected = [
            (PieceKind::Damaged, "A2 DE"),
            (PieceKind::Valid, "10 1A 13 49 76 16"),
            (PieceKind::Valid, "10 42 24 49 AF 16"),
        ];
        assert!(Telegram::parse(&octets).is_ok());
        assert_eq!(
            told(&framed(&[&[0], &octets])[1..]),
            expected[1..].iter().map(|(sort, text)| (*sort, (*text).to_owned())).collect::<Vec<_>>()
        );
    }

    #[test]
    fn a_token_of_noise_does_not_swallow_a_telegram() {
        let octets = hex("DC 10 08 02 49 53 16");
        let expected = [(PieceKind::Damaged, "DC"), (PieceKind::Valid, "10 08 02 49 53 16")];
        assert_eq!(told(&framed(&[&octets])), expected.map(|(sort, text)| (sort, text.to_owned())));
    }

    #[test]
    fn an_octet_with_a_character_error_is_in_no_telegram() {
        let (mut framer, mut out) = (Framer::default(), Vec::new());
        framer.push(Some(BitTime(100)), &hex("10 08 02 49 53 16 E5"), &[2], &mut out);
        framer.flush(&mut out);
        assert_eq!(
            told(&out),
            [(PieceKind::Damaged, "10 08 02 49 53 16".to_owned()), (PieceKind::Doubtful, "E5".to_owned())]
        );
        assert_eq!((out[0].errors.as_slice(), out[1].start), (&[2][..], Some(BitTime(166))));
    }

    #[test]
    fn a_telegram_is_told_as_soon_as_it_is_complete_and_a_damaged_one_with_the_next() {
        let (mut framer, mut out) = (Framer::default(), Vec::new());
        framer.push(None, &hex("68 05 05 68 88 82 6D"), &[], &mut out);
        assert!(out.is_empty());
        framer.push(None, &hex("3C 3E F1 16"), &[], &mut out);
        assert_eq!(out.len(), 1);
        framer.push(None, &hex("68 05 05 68 88"), &[], &mut out);
        framer.push(None, &hex("10 08 02 49 53 16"), &[], &mut out);
        let sorts: Vec<_> = out.iter().map(|piece| piece.kind).collect();
        assert_eq!(sorts, [PieceKind::Valid, PieceKind::Damaged, PieceKind::Valid]);
    }

    #[test]
    fn noise_without_end_needs_no_memory() {
        let (mut framer, mut out) = (Framer::default(), Vec::new());
        for _ in 0..1000 {
            framer.push(None, &[0; 100], &[], &mut out);
            assert!(framer.octets.len() <= MAX_DAMAGED + 100);
        }
        assert!(out.len() > 50);
    }
}
