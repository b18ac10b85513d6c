//! From characters to telegrams. profibus-wire 1.7.
//!
//! After any error the receiver hunts: it listens to nothing until the line was idle, so the rest of a damaged telegram
//! is never taken for the beginning of another. After a valid telegram the next may follow at once.

use super::time::{BitTime, CHARACTER_TBIT, T_SYN_TBIT};
use profivac_wire::{MAX_TELEGRAM, Telegram, TelegramError, TelegramLength};

/// What a character completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received<'a> {
    /// Nothing yet, or nothing the receiver listens to.
    Nothing,
    /// A telegram.
    Telegram(Telegram<'a>),
    /// A telegram broke; the receiver hunts for an idle line.
    Damaged(TelegramError),
}

/// What became of an octet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// It is kept, or passed over while hunting.
    Stored,
    /// It is the last of a telegram.
    Complete,
    /// With it the octets are no telegram.
    Broken(TelegramError),
}

/// What an octet decides that is not only kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Decision {
    /// Whether a telegram begins, and which.
    Beginning,
    /// How many octets an SD2 has.
    Length,
    /// Whether all of them are a telegram.
    End,
}

/// Collects the characters of one telegram at a time.
///
/// Most characters decide nothing: they come in time and are kept, and [`octet`](Self::octet) does no more with them. The
/// first of a telegram, the one that tells its length and the last go on to `decide`, as does any after a gap.
#[derive(Clone, Debug)]
pub struct Receiver {
    /// One place more than the longest telegram has octets: whatever `length` is, there is a place.
    octets: [u8; MAX_TELEGRAM + 1],
    /// How many octets of a telegram are there; 0 while none is being received.
    length: u8,
    /// As long as there are fewer octets than this, another one is only kept; the one after them decides something.
    buffer_until: u8,
    /// What it decides.
    next: Decision,
    waiting_for_idle: bool,
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
            octets: [0; MAX_TELEGRAM + 1],
            length: 0,
            buffer_until: 0,
            next: Decision::Beginning,
            waiting_for_idle: true,
            last: now,
            gap_tbit,
            damaged: 0,
        }
    }

    /// A character without error ended at `end`.
    #[inline]
    pub fn octet(&mut self, end: BitTime, octet: u8) -> Received<'_> {
        match self.step(end, octet) {
            Step::Stored => Received::Nothing,
            Step::Complete => self.complete(),
            Step::Broken(defect) => Received::Damaged(defect),
        }
    }

    /// Characters without error and without gaps between them, the first of which ended at `end`: the same as one after the
    /// other, but cheaper. Takes them up to the one with which a telegram is complete or broken, and says how many that were.
    pub fn octets<'a>(&'a mut self, end: BitTime, octets: &'a [u8]) -> (usize, Received<'a>) {
        if let Some((taken, telegram)) = self.whole_telegram(end, octets) {
            self.waiting_for_idle = false;
            self.last = end + characters_tbit(taken.saturating_sub(1));
            return (taken, Received::Telegram(telegram));
        }
        let mut taken = 0_usize;
        while let Some((octet, rest)) = octets.get(taken..).and_then(<[u8]>::split_first) {
            let at = end + characters_tbit(taken);
            let step = self.step(at, *octet);
            taken = taken.saturating_add(1);
            match step {
                Step::Stored => taken = taken.saturating_add(self.buffer_plain(at, rest)),
                Step::Complete => return (taken, self.complete()),
                Step::Broken(defect) => return (taken, Received::Damaged(defect)),
            }
        }
        (taken, Received::Nothing)
    }

    /// A valid telegram at the front of `octets`, read where it lies, if one may begin there.
    fn whole_telegram<'a>(&self, end: BitTime, octets: &'a [u8]) -> Option<(usize, Telegram<'a>)> {
        if self.length > 0 || (self.waiting_for_idle && end - self.last < self.gap_tbit) {
            return None;
        }
        let TelegramLength::Known(total) = TelegramLength::of(octets) else { return None };
        let total = usize::from(total);
        Some((total, Telegram::parse(octets.get(..total)?).ok()?))
    }

    /// A character with a parity, framing or overrun error ended at `end`.
    pub fn character_error(&mut self, end: BitTime) {
        self.last = end;
        self.wait_for_idle();
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
        // Time that runs backwards looks like a long gap here, and like none where it is decided.
        let since_last = end.0.wrapping_sub(self.last.0);
        if since_last >= self.gap_tbit || self.length >= self.buffer_until {
            return self.decide(end, octet);
        }
        self.last = end;
        self.store(octet);
        Step::Stored
    }

    #[inline]
    fn store(&mut self, octet: u8) {
        if let Some(place) = self.octets.get_mut(usize::from(self.length)) {
            *place = octet;
        }
        self.length = self.length.wrapping_add(1);
    }

    /// Keeps those at the front of `octets` that decide nothing, the character before which ended at `last`, and says how
    /// many they are.
    fn buffer_plain(&mut self, last: BitTime, octets: &[u8]) -> usize {
        let count = usize::from(self.buffer_until.saturating_sub(self.length)).min(octets.len());
        let place = self.octets.get_mut(usize::from(self.length)..).and_then(|free| free.get_mut(..count));
        if let (Some(place), Some(octets), Ok(more)) = (place, octets.get(..count), u8::try_from(count)) {
            place.copy_from_slice(octets);
            self.length = self.length.wrapping_add(more);
            self.last = last + characters_tbit(count);
        }
        count
    }

    /// Any octet. What [`step`](Self::step) does with most of them is the same by a shorter way.
    fn decide(&mut self, end: BitTime, octet: u8) -> Step {
        let since_last = end - self.last;
        self.last = end;
        if since_last >= self.gap_tbit {
            self.after_gap(since_last);
        }
        if self.waiting_for_idle {
            return Step::Stored;
        }
        self.store(octet);
        match self.next {
            _ if self.length <= self.buffer_until => Step::Stored,
            Decision::Beginning => self.set_expected_length(TelegramLength::from_start_delimiter(octet)),
            Decision::Length => {
                let [sd, le, ler, repeated, ..] = self.octets;
                self.set_expected_length(TelegramLength::from_sd2_header([sd, le, ler, repeated]))
            }
            Decision::End => Step::Complete,
        }
    }

    /// The line was idle. Inside a telegram it may be so for just the gap.
    fn after_gap(&mut self, since_last: u64) {
        if self.length > 0 && since_last > self.gap_tbit {
            self.wait_for_idle();
        }
        self.waiting_for_idle = false;
    }

    /// The octets so far tell how many there will be.
    fn set_expected_length(&mut self, extent: TelegramLength) -> Step {
        match extent {
            TelegramLength::Incomplete => {
                (self.buffer_until, self.next) = (TelegramLength::HEADER_LENGTH.saturating_sub(1), Decision::Length)
            }
            TelegramLength::Known(1) => return Step::Complete,
            TelegramLength::Known(total) => (self.buffer_until, self.next) = (total.saturating_sub(1), Decision::End),
            TelegramLength::Invalid(defect) => {
                self.wait_for_idle();
                return Step::Broken(defect);
            }
        }
        Step::Stored
    }

    fn complete(&mut self) -> Received<'_> {
        let length = usize::from(self.length);
        self.clear();
        match Telegram::parse(self.octets.get(..length).unwrap_or_default()) {
            Ok(telegram) => Received::Telegram(telegram),
            Err(defect) => {
                self.waiting_for_idle = true;
                self.damaged = self.damaged.saturating_add(1);
                Received::Damaged(defect)
            }
        }
    }

    fn wait_for_idle(&mut self) {
        self.waiting_for_idle = true;
        self.clear();
        self.damaged = self.damaged.saturating_add(1);
    }

    fn clear(&mut self) {
        self.length = 0;
        self.buffer_until = 0;
        self.next = Decision::Beginning;
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
        damaged: Vec<TelegramError>,
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
                    Received::Nothing => {}
                    Received::Damaged(defect) => self.damaged.push(defect),
                    Received::Telegram(telegram) => {
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
        assert_eq!(line.damaged, [TelegramError::Length]);
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
        assert_eq!(line.damaged, [TelegramError::Start(0)]);
        assert_eq!(line.idle(33).octets(&FDL_STATUS).heard, [FDL_STATUS]);
    }
}
