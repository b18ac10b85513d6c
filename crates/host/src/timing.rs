//! What a master measures on its port: the turnaround of its requests, and the pauses within the answers.
//!
//! While a master waits for an answer, all characters that it receives belong to this answer. So the measurement needs no knowledge
//! about the port, and it works beside other masters too.

use crate::port::Character;
use profivac_dp::link::{BitTime, CHARACTER_TBIT};
use profivac_wire::control::{Control, Function};
use profivac_wire::{Telegram, TelegramLength};
use std::collections::VecDeque;

/// The requests that are kept: a late answer belongs to one before the last. chosen.
const MAX_REQUESTS: usize = 4;

/// From the end of a request to the end of the first character of its answer: min T_SDR of a slave, and the character.
/// profibus-wire 1.12.
const EARLIEST_TBIT: u64 = 11 + CHARACTER_TBIT;

/// The longest times that were measured so far, in bit times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measured {
    /// The answers.
    pub answers: u64,
    /// The requests after which the next telegram was sent without an answer to them.
    pub missing: u64,
    /// From the end of a request to the delivery of the first character of its answer.
    pub turnaround_tbit: u64,
    /// Between two deliveries of characters of one answer.
    pub pause_tbit: u64,
}

/// A request.
#[derive(Clone, Copy, Debug)]
struct Sent {
    to: u8,
    end: BitTime,
    /// An answer that may belong to it, or to a later one, has come.
    is_answered: bool,
}

/// Measures the answers to the requests of one master.
#[derive(Clone, Debug, Default)]
pub struct Timing {
    /// The oldest first.
    requests: VecDeque<Sent>,
    /// The last delivery of characters of the answer to the newest request.
    answer: Option<BitTime>,
    /// The newest telegram is a request that has an answer, and no characters have come since.
    is_waiting: bool,
    measured: Measured,
}

impl Timing {
    /// The longest times so far.
    #[must_use]
    pub const fn measured(&self) -> Measured {
        self.measured
    }

    /// The master sends telegrams, the last of which ends at `end`.
    pub fn sent(&mut self, octets: &[u8], end: BitTime) {
        let mut rest = octets;
        while let TelegramLength::Known(length) = TelegramLength::of(rest)
            && let Some((telegram, behind)) = rest.split_at_checked(length.into())
        {
            self.sent_telegram(Telegram::parse(telegram).ok(), end);
            rest = behind;
        }
        if !rest.is_empty() {
            self.forget();
        }
    }

    fn sent_telegram(&mut self, telegram: Option<Telegram<'_>>, end: BitTime) {
        if std::mem::take(&mut self.is_waiting) {
            self.measured.missing = self.measured.missing.saturating_add(1);
        }
        match telegram {
            Some(Telegram::Data(data)) => match data.control() {
                Control::Request { function, .. } => {
                    self.is_waiting = !matches!(function, Function::SdnLow | Function::SdnHigh);
                    self.requests.push_back(Sent { to: data.da, end, is_answered: false });
                    self.requests.drain(..self.requests.len().saturating_sub(MAX_REQUESTS));
                    self.answer = None;
                }
                Control::Response { .. } => self.forget(),
            },
            // A master that is alone keeps the token, and a late answer may still come.
            Some(Telegram::Token { da, sa }) if da == sa => self.answer = None,
            // The line belongs to another master, or no answer follows.
            Some(Telegram::Token { .. } | Telegram::ShortAck) | None => self.forget(),
        }
    }

    /// The next characters belong to no request.
    pub fn forget(&mut self) {
        self.requests.clear();
        self.answer = None;
    }

    /// Characters were delivered at `now`. On a line with a rate, no answer can come earlier than min T_SDR after its request.
    pub fn delivered(&mut self, now: BitTime, characters: &[Character], has_rate: bool) {
        self.is_waiting = false;
        if let Some(last) = self.answer {
            self.measured.pause_tbit = self.measured.pause_tbit.max(now - last);
            self.answer = Some(now);
            return;
        }
        let Some(beginning) = Beginning::of(characters) else { return };
        let earliest = if has_rate { EARLIEST_TBIT } else { 0 };
        let fits = |sent: &Sent| !sent.is_answered && beginning.may_be_from(sent.to) && now >= sent.end + earliest;
        let open = self.requests.iter().rposition(fits);
        let Some(index) = open.or_else(|| self.surplus(&beginning)) else { return };
        let is_newest = index.saturating_add(1) == self.requests.len();
        if let Some(sent) = self.requests.get(index) {
            self.measured.answers = self.measured.answers.saturating_add(1);
            self.measured.turnaround_tbit = self.measured.turnaround_tbit.max(now - sent.end);
        }
        // Earlier requests are given up; a late answer to one of them is a surplus one.
        self.requests.iter_mut().take(index.saturating_add(1)).for_each(|sent| sent.is_answered = true);
        self.answer = (is_newest && open.is_some()).then_some(now);
    }

    /// The request to which one more answer of this slave belongs: a slave answers each request once and in their order, so the
    /// answer that seemed to belong to its last request was that to an earlier one, which was late.
    fn surplus(&self, beginning: &Beginning) -> Option<usize> {
        let Beginning::From(sender) = beginning else { return None };
        self.requests.iter().rposition(|sent| sent.is_answered && sent.to & 0x7F == *sender)
    }
}

/// What the first characters of an answer say about its sender.
enum Beginning {
    Unknown,
    From(u8),
}

impl Beginning {
    /// `None` if no answer begins with these characters.
    fn of(characters: &[Character]) -> Option<Self> {
        let octet = |index: usize| match characters.get(index) {
            Some(Character::Octet(octet)) => Some(*octet),
            Some(Character::Error) | None => None,
        };
        let sender = match octet(0)? {
            0x10 | 0xA2 => octet(2),
            0x68 => octet(5),
            0xE5 => None,
            _ => return None,
        };
        // The highest bit says that an access point follows.
        Some(sender.map_or(Self::Unknown, |sender| Self::From(sender & 0x7F)))
    }

    fn may_be_from(&self, address: u8) -> bool {
        match self {
            Self::Unknown => true,
            Self::From(sender) => *sender == address & 0x7F,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOKEN_TO_ITSELF: [u8; 3] = [0xDC, 0, 0];
    const TOKEN_TO_ANOTHER: [u8; 3] = [0xDC, 2, 0];

    /// FDL status of master 0.
    fn request(to: u8) -> [u8; 6] {
        [0x10, to, 0, 0x49, to.wrapping_add(0x49), 0x16]
    }

    fn characters(octets: &[u8]) -> Vec<Character> {
        octets.iter().copied().map(Character::Octet).collect()
    }

    fn answer(from: u8) -> Vec<Character> {
        characters(&[0x10, 0, from, 0, from, 0x16])
    }

    fn measured(timing: &Timing) -> (u64, u64, u64) {
        let Measured { answers, turnaround_tbit, pause_tbit, .. } = timing.measured();
        (answers, turnaround_tbit, pause_tbit)
    }

    #[test]
    fn the_longest_turnaround_and_the_longest_pause_within_an_answer_are_kept() {
        let mut timing = Timing::default();
        let whole = answer(5);
        for (begin, turnaround, pause) in [(1_000, 100, 40), (2_000, 80, 60)] {
            timing.sent(&request(5), BitTime(begin));
            timing.delivered(BitTime(begin + turnaround), &whole[..4], true);
            timing.delivered(BitTime(begin + turnaround + pause), &whole[4..], true);
        }
        assert_eq!(measured(&timing), (2, 100, 60));
    }

    #[test]
    fn an_answer_that_comes_before_its_request_can_be_answered_belongs_to_the_request_before() {
        let mut timing = Timing::default();
        timing.sent(&request(5), BitTime(1_000));
        timing.sent(&request(5), BitTime(1_500));
        timing.delivered(BitTime(1_521), &answer(5), true);
        assert_eq!(measured(&timing), (1, 521, 0));
        // The answer to the second request, which is no piece of the first one.
        timing.delivered(BitTime(2_021), &answer(5), true);
        assert_eq!(measured(&timing), (2, 521, 0));
    }

    #[test]
    fn one_more_answer_of_a_slave_shows_that_an_earlier_one_was_late() {
        let mut timing = Timing::default();
        timing.sent(&request(5), BitTime(1_000));
        timing.sent(&request(5), BitTime(1_500));
        // 300 after the second request, but it belongs to the first.
        timing.delivered(BitTime(1_800), &answer(5), true);
        timing.sent(&TOKEN_TO_ITSELF, BitTime(1_900));
        timing.delivered(BitTime(2_300), &answer(5), true);
        assert_eq!(measured(&timing), (2, 800, 0));
        timing.sent(&request(6), BitTime(3_000));
        timing.delivered(BitTime(3_100), &answer(6), true);
        assert_eq!(measured(&timing), (3, 800, 0));
    }

    #[test]
    fn an_answer_of_another_slave_belongs_to_the_request_to_that_slave() {
        let mut timing = Timing::default();
        timing.sent(&request(5), BitTime(1_000));
        timing.sent(&request(6), BitTime(1_500));
        timing.delivered(BitTime(1_700), &answer(5), true);
        assert_eq!(measured(&timing), (1, 700, 0));
        timing.delivered(BitTime(1_710), &answer(9), true);
        assert_eq!(measured(&timing), (1, 700, 0), "no request to it");
    }

    #[test]
    fn a_late_answer_is_measured_while_the_master_keeps_the_token_and_not_when_it_has_passed_it() {
        for (token, expected) in [(TOKEN_TO_ITSELF, (1, 900, 0)), (TOKEN_TO_ANOTHER, (0, 0, 0))] {
            let mut timing = Timing::default();
            timing.sent(&request(5), BitTime(1_000));
            timing.sent(&token, BitTime(1_600));
            timing.delivered(BitTime(1_900), &answer(5), true);
            assert_eq!(measured(&timing), expected, "{token:?}");
        }
    }

    #[test]
    fn a_request_before_whose_successor_nothing_came_is_missing_its_answer() {
        let mut timing = Timing::default();
        timing.sent(&request(5), BitTime(1_000));
        timing.delivered(BitTime(1_100), &answer(5), true);
        timing.sent(&request(6), BitTime(1_500));
        assert_eq!(timing.measured().missing, 0, "the answer may still come");
        timing.sent(&TOKEN_TO_ITSELF, BitTime(2_000));
        timing.sent(&request(7), BitTime(2_100));
        assert_eq!(timing.measured().missing, 1);
        // Global_Control has no answer.
        timing.sent(&[0x68, 7, 7, 0x68, 0xFF, 0x80, 0x46, 58, 62, 0, 0, 61, 0x16], BitTime(3_000));
        timing.sent(&TOKEN_TO_ITSELF, BitTime(3_500));
        assert_eq!(timing.measured().missing, 2, "of 6 and 7");
    }

    #[test]
    fn a_token_and_a_request_that_leave_together_are_two_telegrams() {
        let mut timing = Timing::default();
        timing.sent(&[&TOKEN_TO_ITSELF[..], &request(5)].concat(), BitTime(1_000));
        timing.delivered(BitTime(1_001), &answer(5), true);
        assert_eq!(measured(&timing), (0, 0, 0), "too early for a line with a rate");
        timing.delivered(BitTime(1_050), &characters(&[0xE5]), true);
        assert_eq!(measured(&timing), (1, 50, 0));
        timing.sent(&[1, 2, 3], BitTime(1_100));
        timing.delivered(BitTime(1_200), &answer(5), true);
        assert_eq!(measured(&timing), (1, 50, 0), "damaged octets have no answer");
    }
}
