//! From characters to telegrams. profibus-wire 1.7.
//!
//! After any error the receiver waits for an idle line before it accepts a telegram, so that it never takes the rest of a
//! damaged telegram for the beginning of another. After a valid telegram the next may follow at once.

use super::time::{BitTime, CHARACTER_TBIT, T_SYN_TBIT};
use profivac_wire::{MAX_TELEGRAM, Telegram, TelegramError, TelegramLength};

/// The result of one or more characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Received<'a> {
    /// No telegram is complete, or the receiver waits for an idle line.
    Nothing,
    /// A valid telegram.
    Telegram(Telegram<'a>),
    /// A telegram was damaged; the receiver waits for an idle line.
    Damaged(TelegramError),
}

/// The result of one octet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// The octet is stored, or ignored while waiting for an idle line.
    Stored,
    /// The octet is the last of a telegram.
    Complete,
    /// With this octet the stored octets are no telegram.
    Broken(TelegramError),
}

/// The decision that depends on an octet, where the receiver does more than store it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Decision {
    /// Whether a telegram begins, and which.
    Beginning,
    /// The length of an SD2.
    Length,
    /// Whether the octets are a telegram.
    End,
}

/// Collects the characters of one telegram at a time.
///
/// Most characters decide nothing: they come in time, and [`octet`](Self::octet) only stores them. The first one of a
/// telegram, the one that completes its length field and the last one go through `decide`, as does any one after a gap.
///
/// ```
/// use profivac_dp::link::{BitTime, Received, Receiver};
/// use profivac_wire::Telegram;
///
/// // The line is idle from bit time 0; the first character of a short acknowledgement ends at 50.
/// let mut receiver = Receiver::new(BitTime(0));
/// assert_eq!(receiver.octet(BitTime(50), 0xE5), Received::Telegram(Telegram::ShortAck));
/// ```
#[derive(Clone, Debug)]
pub struct Receiver {
    /// One octet more than the longest telegram, so that every value of `length` is an index.
    octets: [u8; MAX_TELEGRAM + 1],
    /// The number of octets received of a telegram; 0 while none is being received.
    length: u8,
    /// Up to this number octets are only stored; the next one needs a decision.
    buffer_until: u8,
    /// That decision.
    next: Decision,
    waiting_for_idle: bool,
    /// The end of the last character.
    last: BitTime,
    /// From the end of a character to the end of the next, if the line was idle between them for just the idle time.
    gap_tbit: u64,
    damaged: u32,
}

impl Receiver {
    /// Begins to listen at `now`, possibly in the middle of a telegram. The line counts as idle after T_SYN.
    #[must_use]
    pub const fn new(now: BitTime) -> Self {
        Self::with_idle(now, T_SYN_TBIT)
    }

    /// As [`new`](Self::new), but the line counts as idle after `idle_tbit` without a character: for ports of an operating
    /// system, which cannot measure 33 bit times. A longer gap inside a telegram damages it.
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

    /// From now on the line counts as idle after `idle_tbit`, see [`with_idle`](Self::with_idle).
    pub const fn set_idle(&mut self, idle_tbit: u64) {
        self.gap_tbit = idle_tbit.saturating_add(CHARACTER_TBIT);
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

    /// As [`octet`](Self::octet), but leaves the octets of a complete telegram in the receiver and returns `true`: for a handler of an
    /// interrupt, which must be short. The caller takes them with [`take`](Self::take) before the next character ends; otherwise
    /// the telegram counts as damaged.
    #[inline]
    pub fn collect(&mut self, end: BitTime, octet: u8) -> bool {
        matches!(self.step(end, octet), Step::Complete)
    }

    /// Stores a character of a telegram whose end is not there yet, without a look at the time: for a handler of an interrupt that knows
    /// already that the line was not idle before it. Returns `false`, and does nothing, where [`collect`](Self::collect) must decide. The
    /// caller tells the receiver the end of the character with [`continue_at`](Self::continue_at) before it calls anything else.
    #[inline]
    pub fn collect_plain(&mut self, octet: u8) -> bool {
        let is_plain = self.length < self.buffer_until;
        if is_plain {
            self.store(octet);
        }
        is_plain
    }

    /// The last character, which [`collect_plain`](Self::collect_plain) has stored, ended at `end`.
    #[inline]
    pub const fn continue_at(&mut self, end: BitTime) {
        self.last = end;
    }

    /// Copies the octets that [`collect`](Self::collect) has completed to the front of `buffer` and returns them. They may be damaged:
    /// the caller reports octets that are no telegram with [`reject`](Self::reject).
    pub fn take<'a>(&mut self, buffer: &'a mut [u8; MAX_TELEGRAM]) -> &'a [u8] {
        let length = usize::from(self.length);
        self.clear();
        match (buffer.get_mut(..length), self.octets.get(..length)) {
            (Some(buffer), Some(octets)) => {
                buffer.copy_from_slice(octets);
                buffer
            }
            _ => &[],
        }
    }

    /// The octets taken last were no telegram: the receiver waits for an idle line.
    pub fn reject(&mut self) {
        self.wait_for_idle();
    }

    /// Characters without error and without gaps between them, the first of which ended at `end`: the same as several calls of
    /// [`octet`](Self::octet), but cheaper. Stops after the character that completes or damages a telegram, and returns the
    /// number of characters consumed.
    #[inline]
    pub fn octets<'a>(&'a mut self, end: BitTime, octets: &'a [u8]) -> (usize, Received<'a>) {
        if let Some((taken, telegram)) = self.whole_telegram(end, octets) {
            self.waiting_for_idle = false;
            self.last = end + characters_tbit(taken.saturating_sub(1));
            return (taken, Received::Telegram(telegram));
        }
        let taken = self.buffer_front(end, octets);
        if taken == octets.len() {
            return (taken, Received::Nothing);
        }
        self.octets_one_by_one(end, octets, taken)
    }

    /// The rest of [`octets`](Self::octets) after the first `taken` characters, with all decisions.
    fn octets_one_by_one(&mut self, end: BitTime, octets: &[u8], mut taken: usize) -> (usize, Received<'_>) {
        while let Some((octet, rest)) = octets.get(taken..).and_then(<[u8]>::split_first) {
            let at = end + characters_tbit(taken);
            let step = self.step(at, *octet);
            taken = taken.saturating_add(1);
            match step {
                Step::Stored => taken = taken.saturating_add(self.buffer_plain(at + CHARACTER_TBIT, rest)),
                Step::Complete => return (taken, self.complete()),
                Step::Broken(defect) => return (taken, Received::Damaged(defect)),
            }
        }
        (taken, Received::Nothing)
    }

    /// Whether an octet that ends at `end` may be the first of a telegram.
    #[inline]
    fn may_begin(&self, end: BitTime) -> bool {
        self.length == 0 && (!self.waiting_for_idle || end - self.last >= self.gap_tbit)
    }

    /// A valid telegram at the front of `octets`, parsed in place, if one may begin there.
    #[inline]
    fn whole_telegram<'a>(&self, end: BitTime, octets: &'a [u8]) -> Option<(usize, Telegram<'a>)> {
        if !self.may_begin(end) {
            return None;
        }
        let TelegramLength::Known(total) = TelegramLength::of(octets) else { return None };
        let total = usize::from(total);
        Some((total, Telegram::parse(octets.get(..total)?).ok()?))
    }

    /// Stores the octets at the front of a piece up to the last one of a telegram, which they continue in time, or begin
    /// with a valid header. Returns their number. [`step`](Self::step) does the same with each of them.
    #[inline]
    fn buffer_front(&mut self, end: BitTime, octets: &[u8]) -> usize {
        if self.length == 0 {
            let TelegramLength::Known(total) = TelegramLength::of(octets) else { return 0 };
            if !self.may_begin(end) {
                return 0;
            }
            self.waiting_for_idle = false;
            (self.buffer_until, self.next) = (total.saturating_sub(1), Decision::End);
        } else if end.0.wrapping_sub(self.last.0) >= self.gap_tbit {
            // Time that runs backwards looks like a long gap, as in `step`.
            return 0;
        }
        self.buffer_plain(end, octets)
    }

    /// The station begins to send at `now`. After an idle line of T_SYN nothing that was received before continues behind its telegram:
    /// the beginning of a telegram counts as damaged, and the next telegram may follow the own one at once. For ports whose idle time is
    /// longer than the pauses of the line. Without that pause another station is sending, and its telegram is received to its end.
    pub fn own_telegram(&mut self, now: BitTime) {
        if now < self.last + T_SYN_TBIT {
            return;
        }
        if self.length > 0 {
            self.damaged = self.damaged.saturating_add(1);
        }
        self.clear();
        self.waiting_for_idle = false;
    }

    /// A character with a parity, framing or overrun error ended at `end`.
    pub fn character_error(&mut self, end: BitTime) {
        self.last = end;
        self.wait_for_idle();
    }

    /// The number of damaged telegrams, character errors and long gaps included.
    #[must_use]
    pub const fn damaged(&self) -> u32 {
        self.damaged
    }

    /// Whether a telegram is being received.
    #[must_use]
    pub const fn is_receiving(&self) -> bool {
        self.length > 0
    }

    /// Whether the next octet begins a telegram, without an idle line before it: after a valid telegram.
    #[must_use]
    pub const fn is_ready(&self) -> bool {
        self.length == 0 && !self.waiting_for_idle
    }

    #[inline]
    fn step(&mut self, end: BitTime, octet: u8) -> Step {
        // Time that runs backwards looks like a long gap here; `decide` treats it as no gap.
        let since_last = end.0.wrapping_sub(self.last.0);
        let is_last = self.length >= self.buffer_until;
        if since_last >= self.gap_tbit || (is_last && self.next != Decision::End) {
            return self.decide(end, octet);
        }
        self.last = end;
        self.store(octet);
        if is_last { Step::Complete } else { Step::Stored }
    }

    #[inline]
    fn store(&mut self, octet: u8) {
        if let Some(buffer) = self.octets.get_mut(usize::from(self.length)) {
            *buffer = octet;
        }
        self.length = self.length.wrapping_add(1);
    }

    /// Stores the octets at the front of `octets` that need no decision and returns their number. The first of them ended
    /// at `end`.
    #[inline]
    fn buffer_plain(&mut self, end: BitTime, octets: &[u8]) -> usize {
        let count = usize::from(self.buffer_until.saturating_sub(self.length)).min(octets.len());
        let buffer = self.octets.get_mut(usize::from(self.length)..).and_then(|free| free.get_mut(..count));
        if let (Some(buffer), Some(octets), Ok(more @ 1..)) = (buffer, octets.get(..count), u8::try_from(count)) {
            buffer.copy_from_slice(octets);
            self.length = self.length.wrapping_add(more);
            self.last = end + characters_tbit(count.saturating_sub(1));
        }
        count
    }

    /// Processes any octet. [`step`](Self::step) has a shorter way with the same result for most of them.
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

    /// The line was idle. Inside a telegram a gap of just the idle time is allowed.
    fn after_gap(&mut self, since_last: u64) {
        if self.length > 0 && since_last > self.gap_tbit {
            self.wait_for_idle();
        }
        self.waiting_for_idle = false;
    }

    /// Sets the number of octets that need no decision, from what the octets so far say about the length.
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

/// The duration of `count` characters without gaps.
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

    /// The octets between the header and the last one need no decision.
    #[test]
    fn characters_without_their_time_are_stored_where_no_decision_is_needed() {
        let mut receiver = Receiver::new(BitTime(0));
        let mut end = BitTime(100);
        let mut plain = 0;
        for (number, octet) in SLAVE_DIAG.iter().enumerate() {
            end = end + CHARACTER_TBIT;
            if receiver.collect_plain(*octet) {
                receiver.continue_at(end);
                plain += 1;
            } else {
                assert_eq!(receiver.collect(end, *octet), number == SLAVE_DIAG.len() - 1, "octet {number}");
            }
        }
        assert_eq!((plain, receiver.damaged()), (8, 0));
        assert_eq!(receiver.take(&mut [0; MAX_TELEGRAM]), SLAVE_DIAG);
    }

    /// A line: characters follow each other without idle bits, except for `idle` bit times where the test says so.
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
    fn a_collected_telegram_is_the_one_that_octet_returns_and_a_rejected_one_waits_for_an_idle_line() {
        let mut receiver = Receiver::new(BitTime(0));
        let mut buffer = [0; MAX_TELEGRAM];
        let mut now = BitTime(100);
        for telegram in [&FDL_STATUS[..], &SLAVE_DIAG] {
            let (last, first) = telegram.split_last().unwrap();
            for octet in first {
                assert!(!receiver.collect(now, *octet));
                now = now + CHARACTER_TBIT;
            }
            assert!(receiver.collect(now, *last));
            now = now + CHARACTER_TBIT;
            assert_eq!(receiver.take(&mut buffer), telegram);
        }
        receiver.reject();
        assert_eq!(receiver.damaged(), 1);
        for octet in FDL_STATUS {
            assert!(!receiver.collect(now, octet), "the line was not idle");
            now = now + CHARACTER_TBIT;
        }
    }

    /// The next telegram of another station arrives while this one begins to send late.
    #[test]
    fn an_own_telegram_ends_only_what_an_idle_line_has_ended() {
        for (pause, rest_is_received) in [(T_SYN_TBIT - 1, true), (T_SYN_TBIT, false)] {
            let mut receiver = Receiver::with_idle(BitTime(0), 5_000);
            let mut end = BitTime(6_000);
            let mut octet = |receiver: &mut Receiver, value: u8| {
                end = end + CHARACTER_TBIT;
                (end, matches!(receiver.octet(end, value), Received::Telegram(_)))
            };
            let (first, rest) = FDL_STATUS.split_at(3);
            let mut last = BitTime(0);
            for value in first {
                last = octet(&mut receiver, *value).0;
            }
            receiver.own_telegram(last + pause);
            let received = rest.iter().any(|value| octet(&mut receiver, *value).1);
            assert_eq!((received, receiver.damaged() == 0), (rest_is_received, rest_is_received), "{pause}");
        }
    }

    #[test]
    fn a_telegram_after_t_syn_is_received() {
        assert_eq!(Line::new().idle(33).octets(&FDL_STATUS).heard, [FDL_STATUS]);
    }

    #[test]
    fn a_longer_idle_time_tolerates_a_longer_pause() {
        let (begin, end) = FDL_STATUS.split_at(3);
        assert!(Line::new().idle(33).octets(begin).idle(40).octets(end).heard.is_empty());
        let mut line = Line::new().idle(33).octets(begin);
        line.receiver.set_idle(40);
        assert_eq!(line.idle(40).octets(end).heard, [FDL_STATUS]);
    }

    #[test]
    fn a_receiver_that_starts_during_traffic_waits_for_t_syn() {
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
    fn the_rest_of_a_damaged_telegram_is_ignored() {
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
