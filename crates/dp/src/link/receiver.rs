//! From characters to telegrams. profibus-wire 1.7.
//!
//! After any error the receiver hunts: it listens to nothing until the line was idle, so the rest of a damaged telegram
//! is never taken for the beginning of another. After a valid telegram the next may follow at once.

use super::time::{BitTime, CHARACTER_TBIT, T_SYN_TBIT};
use profivac_wire::{Extent, MAX_TELEGRAM, Malformed, Telegram};

/// What a character completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard<'a> {
    /// Nothing yet, or nothing the receiver listens to.
    Nothing,
    /// A telegram.
    Telegram(Telegram<'a>),
    /// A telegram broke; the receiver hunts for an idle line.
    Damaged(Malformed),
}

/// What became of an octet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// It is kept, or passed over while hunting.
    Kept,
    /// It is the last of a telegram.
    Complete,
    /// With it the octets are no telegram.
    Broken(Malformed),
}

/// Collects the characters of one telegram at a time.
#[derive(Clone, Debug)]
pub struct Receiver {
    octets: [u8; MAX_TELEGRAM],
    /// How many octets of a telegram are there; 0 while none is being received.
    length: usize,
    /// As long as there are fewer octets than this, another one is only kept; the one after them decides something.
    quiet: usize,
    /// What it decides: it completes the telegram. Otherwise it tells how many octets there will be.
    sized: bool,
    hunting: bool,
    /// When the last character ended.
    last: BitTime,
    /// From the end of a character to the end of the next, if the line was just idle between them.
    gap_tbit: u64,
    damaged: u32,
}

impl Receiver {
    /// Begins to listen at `now`, in the middle of whatever is on the line. The line counts as idle after T_SYN.
    #[must_use]
    pub const fn new(now: BitTime) -> Self {
        Self::with_idle(now, T_SYN_TBIT)
    }

    /// As [`new`](Self::new), but the line counts as idle after `idle_tbit` without a character: for ports of an operating
    /// system, where 33 bit times cannot be measured. A gap longer than this inside a telegram breaks it.
    #[must_use]
    pub const fn with_idle(now: BitTime, idle_tbit: u64) -> Self {
        let gap_tbit = idle_tbit.saturating_add(CHARACTER_TBIT);
        Self {
            octets: [0; MAX_TELEGRAM],
            length: 0,
            quiet: 0,
            sized: false,
            hunting: true,
            last: now,
            gap_tbit,
            damaged: 0,
        }
    }

    /// A character without error ended at `end`.
    #[inline]
    pub fn octet(&mut self, end: BitTime, octet: u8) -> Heard<'_> {
        match self.step(end, octet) {
            Step::Kept => Heard::Nothing,
            Step::Complete => self.complete(),
            Step::Broken(defect) => Heard::Damaged(defect),
        }
    }

    /// Characters without error and without gaps between them, the first of which ended at `end`: the same as one after the
    /// other, but cheaper. Takes them up to the one with which a telegram is complete or broken, and says how many that were.
    pub fn octets<'a>(&'a mut self, end: BitTime, octets: &'a [u8]) -> (usize, Heard<'a>) {
        if let Some((taken, telegram)) = self.whole(end, octets) {
            self.hunting = false;
            self.last = end + characters_tbit(taken.saturating_sub(1));
            return (taken, Heard::Telegram(telegram));
        }
        for (before, octet) in octets.iter().enumerate() {
            let taken = before.saturating_add(1);
            match self.step(end + characters_tbit(before), *octet) {
                Step::Kept => {}
                Step::Complete => return (taken, self.complete()),
                Step::Broken(defect) => return (taken, Heard::Damaged(defect)),
            }
        }
        (octets.len(), Heard::Nothing)
    }

    /// A valid telegram at the front of `octets`, read where it lies, if one may begin there.
    fn whole<'a>(&self, end: BitTime, octets: &'a [u8]) -> Option<(usize, Telegram<'a>)> {
        if self.length > 0 || (self.hunting && end - self.last < self.gap_tbit) {
            return None;
        }
        let Extent::Total(total) = Extent::of(octets) else { return None };
        Some((total, Telegram::parse(octets.get(..total)?).ok()?))
    }

    /// A character with a parity, framing or overrun error ended at `end`.
    pub fn character_error(&mut self, end: BitTime) {
        self.last = end;
        self.hunt();
    }

    /// How many telegrams broke, character errors and long gaps included.
    #[must_use]
    pub const fn damaged(&self) -> u32 {
        self.damaged
    }

    /// Whether a telegram is being received.
    #[must_use]
    pub const fn is_receiving(&self) -> bool {
        self.length > 0
    }

    #[inline]
    fn step(&mut self, end: BitTime, octet: u8) -> Step {
        let since_last = end - self.last;
        self.last = end;
        if since_last > self.gap_tbit || self.length >= self.quiet {
            return self.decide(since_last, octet);
        }
        self.append(octet);
        Step::Kept
    }

    #[inline]
    fn append(&mut self, octet: u8) {
        if let Some(place) = self.octets.get_mut(self.length) {
            *place = octet;
            self.length = self.length.wrapping_add(1);
        }
    }

    /// An octet that is not only kept.
    fn decide(&mut self, since_last: u64, octet: u8) -> Step {
        if self.length == 0 || since_last > self.gap_tbit {
            return self.begin(since_last, octet);
        }
        self.append(octet);
        if self.sized { Step::Complete } else { self.size() }
    }

    /// A first character, or one after a gap.
    fn begin(&mut self, since_last: u64, octet: u8) -> Step {
        if self.length > 0 {
            self.hunt();
        }
        if self.hunting && since_last < self.gap_tbit {
            return Step::Kept;
        }
        self.hunting = false;
        self.octets[0] = octet;
        self.length = 1;
        self.size()
    }

    /// Asks the octets so far how many there will be.
    fn size(&mut self) -> Step {
        match Extent::of(self.octets.get(..self.length).unwrap_or_default()) {
            Extent::Open => self.quiet = Extent::TELLING.saturating_sub(1),
            Extent::Total(total) if total == self.length => return Step::Complete,
            Extent::Total(total) => (self.quiet, self.sized) = (total.saturating_sub(1), true),
            Extent::Broken(defect) => {
                self.hunt();
                return Step::Broken(defect);
            }
        }
        Step::Kept
    }

    fn complete(&mut self) -> Heard<'_> {
        let length = self.length;
        self.clear();
        match Telegram::parse(self.octets.get(..length).unwrap_or_default()) {
            Ok(telegram) => Heard::Telegram(telegram),
            Err(defect) => {
                self.hunting = true;
                self.damaged = self.damaged.saturating_add(1);
                Heard::Damaged(defect)
            }
        }
    }

    fn hunt(&mut self) {
        self.hunting = true;
        self.clear();
        self.damaged = self.damaged.saturating_add(1);
    }

    fn clear(&mut self) {
        self.length = 0;
        self.quiet = 0;
        self.sized = false;
    }
}

/// How long so many characters are without gaps.
fn characters_tbit(count: usize) -> u64 {
    (count as u64).saturating_mul(CHARACTER_TBIT)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    const FDL_STATUS: [u8; 6] = [0x10, 8, 2, 0x49, 0x53, 0x16];
    const SLAVE_DIAG: [u8; 11] = [0x68, 5, 5, 0x68, 0x88, 0x82, 0x6D, 0x3C, 0x3E, 0xF1, 0x16];

    /// A line: characters follow each other without idle bits, `idle` bit times of silence where the test says so.
    struct Line {
        receiver: Receiver,
        now: BitTime,
        heard: Vec<Vec<u8>>,
        damaged: Vec<Malformed>,
    }

    impl Line {
        fn new() -> Self {
            Self { receiver: Receiver::new(BitTime(0)), now: BitTime(0), heard: Vec::new(), damaged: Vec::new() }
        }

        fn idle(mut self, tbit: u64) -> Self {
            self.now = self.now + tbit;
            self
        }

        fn octets(mut self, octets: &[u8]) -> Self {
            for octet in octets {
                self.now = self.now + CHARACTER_TBIT;
                match self.receiver.octet(self.now, *octet) {
                    Heard::Nothing => {}
                    Heard::Damaged(defect) => self.damaged.push(defect),
                    Heard::Telegram(telegram) => {
                        let mut out = [0; MAX_TELEGRAM];
                        let length = telegram.emit(&mut out).unwrap();
                        self.heard.push(out[..length].to_vec());
                    }
                }
            }
            self
        }

        fn error(mut self) -> Self {
            self.now = self.now + CHARACTER_TBIT;
            self.receiver.character_error(self.now);
            self
        }
    }

    #[test]
    fn a_telegram_after_t_syn_is_heard() {
        assert_eq!(Line::new().idle(33).octets(&FDL_STATUS).heard, [FDL_STATUS]);
    }

    #[test]
    fn a_receiver_that_wakes_in_traffic_waits_for_t_syn() {
        let line = Line::new().idle(32).octets(&FDL_STATUS);
        assert!(line.heard.is_empty());
        assert_eq!(line.idle(33).octets(&FDL_STATUS).heard, [FDL_STATUS]);
    }

    #[test]
    fn telegrams_may_follow_a_valid_one_at_once() {
        let line = Line::new().idle(33).octets(&SLAVE_DIAG).octets(&[0xE5]).octets(&FDL_STATUS);
        assert_eq!(line.heard, [&SLAVE_DIAG[..], &[0xE5], &FDL_STATUS[..]]);
    }

    #[test]
    fn the_rest_of_a_damaged_telegram_is_not_listened_to() {
        // The data unit holds a telegram of its own; the outer length octets disagree.
        let mut outer = SLAVE_DIAG.to_vec();
        outer[2] ^= 1;
        outer.extend_from_slice(&FDL_STATUS);
        let line = Line::new().idle(33).octets(&outer);
        assert!(line.heard.is_empty());
        assert_eq!(line.damaged, [Malformed::Length]);
        assert_eq!(line.idle(33).octets(&FDL_STATUS).heard, [FDL_STATUS]);
    }

    #[test]
    fn a_wrong_check_octet_costs_only_this_telegram() {
        let mut altered = FDL_STATUS;
        altered[1] ^= 0x40;
        let line = Line::new().idle(33).octets(&altered).idle(33).octets(&FDL_STATUS);
        assert_eq!(line.heard, [FDL_STATUS]);
        assert_eq!(line.receiver.damaged(), 1);
    }

    #[test]
    fn a_gap_up_to_t_syn_is_tolerated_and_a_longer_one_breaks_the_telegram() {
        let (head, tail) = SLAVE_DIAG.split_at(5);
        assert_eq!(Line::new().idle(33).octets(head).idle(33).octets(tail).heard, [SLAVE_DIAG]);
        let line = Line::new().idle(33).octets(head).idle(34).octets(tail);
        assert!(line.heard.is_empty());
        assert_eq!(line.idle(33).octets(&FDL_STATUS).heard, [FDL_STATUS]);
    }

    #[test]
    fn a_telegram_may_begin_where_a_gap_broke_another() {
        let line = Line::new().idle(33).octets(&SLAVE_DIAG[..5]).idle(34).octets(&FDL_STATUS);
        assert_eq!(line.heard, [FDL_STATUS]);
    }

    #[test]
    fn a_character_error_breaks_the_telegram() {
        let line = Line::new().idle(33).octets(&FDL_STATUS[..2]).error().octets(&FDL_STATUS[3..]);
        assert!(line.heard.is_empty());
        assert_eq!(line.idle(33).octets(&FDL_STATUS).heard, [FDL_STATUS]);
    }

    #[test]
    fn noise_before_a_telegram_hides_it_until_the_line_is_idle() {
        let line = Line::new().idle(33).octets(&[0x00]).octets(&FDL_STATUS);
        assert!(line.heard.is_empty());
        assert_eq!(line.damaged, [Malformed::Start(0)]);
        assert_eq!(line.idle(33).octets(&FDL_STATUS).heard, [FDL_STATUS]);
    }

    /// Numbers that look random and are the same for the same seed (Knuth's MMIX generator).
    struct Random(u64);

    impl Random {
        fn below(&mut self, bound: u64) -> u64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 33).checked_rem(bound).unwrap()
        }

        /// Some telegrams one after the other, with an octet altered here and there.
        fn chunk(&mut self) -> Vec<u8> {
            let mut octets = Vec::new();
            for _ in 0..=self.below(3) {
                octets
                    .extend_from_slice([&FDL_STATUS[..], &SLAVE_DIAG, &[0xE5], &[0xDC, 2, 2]][self.below(4) as usize]);
            }
            if self.below(3) == 0 {
                let place = self.below(octets.len() as u64) as usize;
                octets[place] ^= 1 << self.below(8);
            }
            octets.truncate(self.below(40).max(1) as usize);
            octets
        }
    }

    /// What a receiver says to a chunk that comes together, as text.
    fn together(receiver: &mut Receiver, mut end: BitTime, mut octets: &[u8]) -> Vec<std::string::String> {
        let mut said = Vec::new();
        while !octets.is_empty() {
            let (taken, heard) = receiver.octets(end, octets);
            said.extend((heard != Heard::Nothing).then(|| std::format!("{heard:02X?}")));
            end = end + characters_tbit(taken);
            octets = &octets[taken..];
        }
        said
    }

    #[test]
    fn octets_that_come_together_are_heard_as_those_one_by_one() {
        for seed in 0..2_000 {
            let mut random = Random(seed);
            let (mut one_by_one, mut slices) = (Receiver::new(BitTime(0)), Receiver::new(BitTime(0)));
            let mut end = BitTime(0);
            for _ in 0..20 {
                let octets = random.chunk();
                end = end + [0, 0, 32, 33, 34, 100][random.below(6) as usize];
                let said = together(&mut slices, end + CHARACTER_TBIT, &octets);
                let mut expected = Vec::new();
                for octet in &octets {
                    end = end + CHARACTER_TBIT;
                    let heard = one_by_one.octet(end, *octet);
                    expected.extend((heard != Heard::Nothing).then(|| std::format!("{heard:02X?}")));
                }
                assert_eq!(said, expected, "seed {seed}, {octets:02X?}");
                assert_eq!(slices.damaged(), one_by_one.damaged(), "seed {seed}");
            }
        }
    }
}
