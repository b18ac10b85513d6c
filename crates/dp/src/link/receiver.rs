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

/// Collects the characters of one telegram at a time.
#[derive(Clone, Debug)]
pub struct Receiver {
    octets: [u8; MAX_TELEGRAM],
    length: usize,
    /// How many octets the telegram has; unknown as long as it is 0.
    total: usize,
    hunting: bool,
    /// When the last character ended.
    last: BitTime,
    idle_tbit: u64,
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
        Self { octets: [0; MAX_TELEGRAM], length: 0, total: 0, hunting: true, last: now, idle_tbit, damaged: 0 }
    }

    /// A character without error ended at `end`.
    #[inline]
    pub fn octet(&mut self, end: BitTime, octet: u8) -> Heard<'_> {
        let idle = (end - self.last).saturating_sub(CHARACTER_TBIT);
        self.last = end;
        if self.hunting || self.length == 0 || idle > self.idle_tbit {
            return self.begin(idle, octet);
        }
        if let Some(place) = self.octets.get_mut(self.length) {
            *place = octet;
        }
        self.length = self.length.saturating_add(1);
        if self.length == self.total {
            return self.complete();
        }
        if self.total == 0 { self.size() } else { Heard::Nothing }
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

    /// A first character, or one after a gap.
    fn begin(&mut self, idle: u64, octet: u8) -> Heard<'_> {
        if self.length > 0 {
            self.hunt();
        }
        if self.hunting && idle < self.idle_tbit {
            return Heard::Nothing;
        }
        self.hunting = false;
        self.octets[0] = octet;
        self.length = 1;
        self.total = 0;
        self.size()
    }

    /// Asks the octets so far how many there will be.
    fn size(&mut self) -> Heard<'_> {
        match Extent::of(self.octets.get(..self.length).unwrap_or_default()) {
            Extent::Open => Heard::Nothing,
            Extent::Total(total) if total == self.length => self.complete(),
            Extent::Total(total) => {
                self.total = total;
                Heard::Nothing
            }
            Extent::Broken(defect) => {
                self.hunt();
                Heard::Damaged(defect)
            }
        }
    }

    fn complete(&mut self) -> Heard<'_> {
        let length = core::mem::take(&mut self.length);
        self.total = 0;
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
        self.length = 0;
        self.total = 0;
        self.damaged = self.damaged.saturating_add(1);
    }
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
}
