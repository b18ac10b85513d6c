//! A tap: a receiver at one position of the cable.
//!
//! All passive stations at one position receive the same, so they share one tap. An active station has a separate tap,
//! because it does not receive its own telegrams; so does a station with local noise or separate power.
//!
//! While one undamaged telegram is on the line, the tap takes whole characters, each at the time of its last bit. When
//! signals overlap or bits are inverted, it steps bit by bit through a [`Uart`].
//!
//! Passive stations need telegrams only, and an undisturbed telegram is complete at its end, so a shared tap reads all its
//! characters at that time. One to another station may not even be announced to it (`segment/direct.rs`).

use crate::character::{Character, Uart};
use crate::noise::Noise;
use crate::scheduler::NEVER;
use crate::signal::Signal;
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Receiver};
use std::collections::VecDeque;
use std::sync::Arc;

/// A signal at this position.
#[derive(Clone, Debug)]
struct Incoming {
    signal: Signal,
    sender: Option<usize>,
    begin: BitTime,
    /// The end of the signal.
    until: BitTime,
    /// The number of the next whole octet, and its start.
    next: usize,
    due: BitTime,
}

/// A receiver at one position.
#[derive(Clone, Debug)]
pub(crate) struct Tap {
    pub(crate) position: u64,
    /// The station of a tap that is not shared.
    pub(crate) owner: Option<usize>,
    pub(crate) receiver: Receiver,
    /// The signals, ordered by arrival.
    incoming: VecDeque<Incoming>,
    uart: Uart,
    /// The tap has read everything before this.
    at: BitTime,
    /// The time of the next inverted bit.
    flip: BitTime,
    line_noise: Option<Noise>,
    pub(crate) own_noise: Option<Noise>,
    /// The characters with the times of their ends, if they are kept.
    pub(crate) kept: Option<Vec<(BitTime, Character)>>,
}

impl Tap {
    /// A tap `position` bit times from the beginning of the cable, reading from `now` on.
    pub(crate) fn new(position: u64, now: BitTime, line_noise: Option<Noise>) -> Self {
        let mut tap = Self {
            position,
            owner: None,
            receiver: Receiver::new(now),
            incoming: VecDeque::new(),
            uart: Uart::default(),
            at: now,
            flip: NEVER,
            line_noise,
            own_noise: None,
            kept: None,
        };
        tap.find_flip(now);
        tap
    }

    /// Takes a whole undisturbed telegram and its start.
    pub(crate) fn take_telegram(&mut self) -> Option<(BitTime, Arc<[u8]>)> {
        let first = self.incoming.front().filter(|first| self.is_undisturbed(first))?;
        let whole = (first.begin, first.signal.clean()?.clone());
        self.at = first.until;
        self.incoming.pop_front();
        Some(whole)
    }

    /// Changes the noise from `now` on.
    pub(crate) fn set_noise(&mut self, now: BitTime, line: Option<Noise>, own: Option<Noise>) {
        self.line_noise = line;
        self.own_noise = own;
        self.find_flip(now.max(self.at));
    }

    fn find_flip(&mut self, from: BitTime) {
        let next = |noise: &Option<Noise>| noise.as_ref().map_or(NEVER, |noise| noise.next(from));
        self.flip = next(&self.line_noise).min(next(&self.own_noise));
    }

    /// Adds a signal that arrives at `begin`.
    pub(crate) fn announce(&mut self, signal: Signal, sender: Option<usize>, begin: BitTime) {
        let until = begin + signal.duration_tbit();
        let index = self.incoming.partition_point(|other| other.begin <= begin);
        self.incoming.insert(index, Incoming { signal, sender, begin, until, next: 0, due: begin });
    }

    /// As [`announce`](Self::announce), unless the tap knows a signal that begins then, or has read it.
    pub(crate) fn announce_once(&mut self, signal: Signal, sender: Option<usize>, begin: BitTime) {
        if self.at <= begin && self.incoming.iter().all(|other| other.begin != begin) {
            self.announce(signal, sender, begin);
        }
    }

    /// Whether the tap reads a telegram that begins at `begin` to its end, and is then as before: it has received only whole
    /// undisturbed telegrams since the line was idle, and those still on the line end before.
    pub(crate) fn is_in_step(&self, begin: BitTime) -> bool {
        let mut free_from = self.at;
        let follows = |incoming: &Incoming| {
            let follows = incoming.is_whole_telegram() && free_from <= incoming.begin;
            free_from = incoming.until;
            follows
        };
        self.flip == NEVER
            && self.uart.is_idle()
            && self.receiver.is_ready()
            && self.incoming.iter().all(follows)
            && free_from <= begin
    }

    /// Ends the signals of `sender` at `now`.
    pub(crate) fn cut_off(&mut self, sender: usize, now: BitTime) {
        for incoming in self.incoming.iter_mut().filter(|incoming| incoming.sender == Some(sender)) {
            incoming.until = incoming.until.min(now);
        }
    }

    /// The time of the next event that a station may notice.
    pub(crate) fn next(&self) -> BitTime {
        match self.incoming.front() {
            None if self.uart.is_idle() => self.flip + 1,
            Some(first) if self.is_undisturbed(first) => first.until,
            Some(first) if self.is_clean(first) => first.due + CHARACTER_TBIT,
            _ => self.first_bit() + 1,
        }
    }

    /// Whether the first signal is an undisturbed telegram and no station needs its single characters.
    fn is_undisturbed(&self, first: &Incoming) -> bool {
        self.owner.is_none()
            && first.is_whole_telegram()
            && !self.receiver.is_receiving()
            && self.is_clean(first)
            && self.is_alone(first.until)
    }

    /// Whether the next character of the first signal is undisturbed.
    fn is_clean(&self, first: &Incoming) -> bool {
        let end = first.due + CHARACTER_TBIT;
        first.signal.clean().is_some()
            && self.uart.is_idle()
            && (self.at == first.due || self.at < first.due && first.next == 0)
            && first.until >= end
            && self.is_alone(end)
    }

    /// Whether neither noise nor another signal occurs before `end`.
    fn is_alone(&self, end: BitTime) -> bool {
        self.flip >= end && self.incoming.get(1).is_none_or(|second| second.begin >= end)
    }

    /// Whether the tap has read everything before `time`.
    pub(crate) fn is_read_until(&self, time: BitTime) -> bool {
        self.at >= time
    }

    /// The next bit to read.
    fn first_bit(&self) -> BitTime {
        if !self.uart.is_idle() {
            return self.at;
        }
        let begins = self.incoming.iter().map(|incoming| incoming.begin.max(self.at));
        begins.fold(self.flip, BitTime::min).max(self.at)
    }

    /// Reads one undisturbed character, or otherwise one bit. Returns the character that ends.
    pub(crate) fn read_next(&mut self) -> Option<(BitTime, Character)> {
        if self.incoming.front().is_some_and(|first| self.is_clean(first)) {
            return self.read_octet();
        }
        self.at = self.first_bit();
        let inverted = self.flip == self.at;
        if inverted {
            self.find_flip(self.at + 1);
        }
        let line = self.incoming.iter().all(|incoming| incoming.level(self.at));
        self.at = self.at + 1;
        self.incoming.retain_mut(|incoming| incoming.has_more(self.at));
        self.uart.level(line != inverted).map(|character| (self.at, character))
    }

    fn read_octet(&mut self) -> Option<(BitTime, Character)> {
        let first = self.incoming.front_mut()?;
        let octets = first.signal.clean()?;
        let octet = *octets.get(first.next)?;
        first.next += 1;
        first.due = first.due + CHARACTER_TBIT;
        self.at = first.due;
        if first.next == octets.len() {
            self.incoming.pop_front();
        }
        Some((self.at, Character { octet, error: false }))
    }
}

impl Incoming {
    /// Whether an undisturbed telegram is not read yet and does not end early.
    fn is_whole_telegram(&self) -> bool {
        self.signal.is_telegram() && self.next == 0 && self.until == self.begin + self.signal.duration_tbit()
    }

    /// The level of this signal; of several signals, 0 wins over 1 (chosen).
    fn level(&self, at: BitTime) -> bool {
        at < self.begin || at >= self.until || self.signal.level(at - self.begin)
    }

    /// Skips the part before `at`. Returns false at the end of the signal.
    fn has_more(&mut self, at: BitTime) -> bool {
        while self.due < at {
            self.due = self.due + CHARACTER_TBIT;
            self.next += 1;
        }
        at < self.until
    }
}
