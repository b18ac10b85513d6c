//! Stations for tests: one that sends given telegrams, one driven by a closure, one that babbles.

use crate::random::Random;
use profivac_dp::link::{BitTime, Listening, Station, Transmit};
use profivac_wire::{MAX_TELEGRAM, Telegram};
use std::collections::VecDeque;
use std::fmt;

/// A received telegram.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReceivedTelegram {
    /// The end of its last bit.
    pub end: BitTime,
    /// Its octets.
    pub octets: Vec<u8>,
}

/// Sends given telegrams at given times, and stores all telegrams that it receives.
#[derive(Clone, Debug, Default)]
pub struct Tester {
    queue: VecDeque<(BitTime, Vec<u8>)>,
    sent: Vec<u8>,
    /// The received telegrams, in order.
    pub received: Vec<ReceivedTelegram>,
    /// The number of characters that did not complete a telegram.
    pub characters: usize,
}

impl Tester {
    /// A tester without telegrams to send.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sends `octets` at `time`. Telegrams are sent in the order of the calls.
    pub fn send(&mut self, time: BitTime, octets: &[u8]) {
        self.queue.push_back((time, octets.to_vec()));
    }
}

impl Station for Tester {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        let mut octets = vec![0; MAX_TELEGRAM];
        let length = telegram.emit(&mut octets).unwrap_or_default();
        octets.truncate(length);
        self.received.push(ReceivedTelegram { end, octets });
        None
    }

    fn activity(&mut self, _end: BitTime) {
        self.characters += 1;
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        let (not_before, octets) = self.queue.pop_front_if(|(time, _)| *time <= now)?;
        self.sent = octets;
        Some(Transmit { not_before, octets: &self.sent })
    }

    fn wake_at(&self) -> Option<BitTime> {
        self.queue.front().map(|(time, _)| *time)
    }
}

/// A station that a closure drives, for wrong behaviour.
pub struct MockStation<F> {
    reaction: F,
    octets: Vec<u8>,
}

impl<F> fmt::Debug for MockStation<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("MockStation")
    }
}

impl<F: FnMut(BitTime, &Telegram<'_>) -> Option<(BitTime, Vec<u8>)>> MockStation<F> {
    /// `reaction` gets each telegram with its end, and returns the octets to send and their time.
    pub const fn new(reaction: F) -> Self {
        Self { reaction, octets: Vec::new() }
    }
}

impl<F: FnMut(BitTime, &Telegram<'_>) -> Option<(BitTime, Vec<u8>)>> Station for MockStation<F> {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        let (not_before, octets) = (self.reaction)(end, telegram)?;
        self.octets = octets;
        Some(Transmit { not_before, octets: &self.octets })
    }

    fn poll(&mut self, _now: BitTime) -> Option<Transmit<'_>> {
        None
    }

    fn wake_at(&self) -> Option<BitTime> {
        None
    }
}

/// A station that sends random octets at random times and ignores all others.
#[derive(Clone, Debug)]
pub struct Babbler {
    random: Random,
    next: BitTime,
    until: BitTime,
    /// The longest pause between two bursts.
    pause_tbit: u64,
    octets: Vec<u8>,
}

impl Babbler {
    /// Bursts of 1 to 20 octets from `from` to `until`, with pauses of at most `pause_tbit` between them.
    #[must_use]
    pub const fn new(seed: u64, from: BitTime, until: BitTime, pause_tbit: u64) -> Self {
        Self { random: Random::new(seed), next: from, until, pause_tbit, octets: Vec::new() }
    }
}

impl Station for Babbler {
    fn telegram(&mut self, _end: BitTime, _telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        None
    }

    fn sent(&mut self, end: BitTime) {
        self.next = end + self.random.below(self.pause_tbit + 1);
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        let length = 1 + self.random.below(20);
        self.octets = (0..length).map(|_| self.random.octet()).collect();
        self.next = BitTime(u64::MAX);
        Some(Transmit { not_before: now, octets: &self.octets })
    }

    fn wake_at(&self) -> Option<BitTime> {
        (self.next < self.until).then_some(self.next)
    }

    fn listening(&self) -> Listening {
        Listening::Everything
    }
}
