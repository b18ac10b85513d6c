//! Receives octets from a port and never sends.

use super::PLATFORM_SILENCE;
use super::frame::Chunk;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, T_SYN_TBIT};
use profivac_host::clock::tbit_of;
use profivac_host::port::{Character, Notice, Port, PortClock, PortError, wait_for_port};
use profivac_host::readiness::Readiness;
use std::time::Duration;

/// A port that only receives.
pub struct Tap {
    port: Box<dyn Port>,
    baud: Baud,
    clock: PortClock,
    received: Vec<Character>,
    /// Time of the last character, until the silence after it is reported.
    last: Option<BitTime>,
    /// Start of the last chunk.
    before: BitTime,
}

/// Event on the line of a tap.
#[derive(Clone, Debug, PartialEq)]
pub enum TapEvent {
    /// Octets were received.
    Octets(Chunk),
    /// The line has been silent for so long that no telegram continues.
    Silence,
    /// Nothing was received.
    Nothing,
}

impl Tap {
    /// A tap that receives from now on.
    #[must_use]
    pub fn new(port: Box<dyn Port>, baud: Baud) -> Self {
        Self::starting_at(port, baud, BitTime(0))
    }

    /// A tap that receives from now on, which is bit time `first`: the times of a port that was opened again continue.
    #[must_use]
    pub fn starting_at(port: Box<dyn Port>, baud: Baud, first: BitTime) -> Self {
        let clock = PortClock::starting_at(first, baud, &*port);
        Self { port, baud, clock, received: Vec::new(), last: None, before: first }
    }

    /// Takes the oldest notice of the port.
    pub fn next_notice(&mut self) -> Option<Notice> {
        self.port.next_notice()
    }

    /// The present bit time.
    #[must_use]
    pub fn now(&self) -> BitTime {
        self.clock.now(&*self.port)
    }

    /// Waits for an event, at most `at_most`. Also returns when one of `others` becomes readable; the second value says which
    /// ones are.
    ///
    /// # Errors
    /// [`PortError::Lost`] if the port is lost.
    pub fn receive(&mut self, others: &[Readiness<'_>], at_most: Duration) -> Result<(TapEvent, Vec<bool>), PortError> {
        let at_most = if self.last.is_some() { at_most.min(PLATFORM_SILENCE) } else { at_most };
        let readable = wait_for_port(&mut *self.port, others, at_most)?;
        self.received.clear();
        self.port.receive(&mut self.received)?;
        let now = self.now();
        if !self.received.is_empty() {
            self.last = Some(now);
            return Ok((TapEvent::Octets(self.take_chunk(now)), readable));
        }
        let silence_tbit = tbit_of(self.baud, PLATFORM_SILENCE).max(T_SYN_TBIT);
        let event = match self.last {
            Some(last) if now - last >= silence_tbit => {
                self.last = None;
                TapEvent::Silence
            }
            _ => TapEvent::Nothing,
        };
        Ok((event, readable))
    }

    /// The received octets as a chunk with the earliest possible start of its first octet. Starts never decrease.
    fn take_chunk(&mut self, now: BitTime) -> Chunk {
        let octet = |character: &Character| if let Character::Octet(octet) = character { *octet } else { 0 };
        let octets: Vec<u8> = self.received.iter().map(octet).collect();
        let bad = self.received.iter().enumerate().filter(|(_, character)| **character == Character::Error);
        let errors = bad.map(|(index, _)| index).collect();
        // A UART delivers several characters at once: the first one began earlier by their duration.
        let early_tbit = if self.port.is_timed() { (octets.len() as u64).saturating_mul(CHARACTER_TBIT) } else { 0 };
        self.before = self.before.max(BitTime(now.0.saturating_sub(early_tbit)));
        Chunk { start: Some(self.before), octets, errors, is_continued: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::net::UnixStream;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// A port with some characters that counts the octets sent.
    struct CountingPort {
        characters: Vec<Character>,
        end: UnixStream,
        sent: Arc<AtomicUsize>,
    }

    impl Port for CountingPort {
        fn name(&self) -> &str {
            "counting"
        }

        fn readiness(&self) -> Vec<Readiness<'_>> {
            vec![Readiness::of(&self.end)]
        }

        fn receive(&mut self, received: &mut Vec<Character>) -> Result<(), PortError> {
            received.append(&mut self.characters);
            Ok(())
        }

        fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
            self.sent.fetch_add(octets.len().max(1), Ordering::Relaxed);
            Ok(())
        }
    }

    #[test]
    fn a_tap_returns_octets_and_errors_then_one_silence_and_sends_nothing() {
        let (sent, (end, _other)) = (Arc::new(AtomicUsize::new(0)), UnixStream::pair().unwrap());
        let characters = vec![Character::Octet(0x10), Character::Error, Character::Octet(2)];
        let mut tap = Tap::new(Box::new(CountingPort { characters, end, sent: sent.clone() }), Baud::B500000);
        let (event, _) = tap.receive(&[], Duration::ZERO).unwrap();
        let TapEvent::Octets(chunk) = event else { panic!("{event:?}") };
        assert_eq!((chunk.octets, chunk.errors), (vec![0x10, 0, 2], vec![1]));
        let mut silences = 0;
        while silences == 0 {
            silences += usize::from(tap.receive(&[], PLATFORM_SILENCE).unwrap().0 == TapEvent::Silence);
        }
        assert_eq!(tap.receive(&[], Duration::ZERO).unwrap().0, TapEvent::Nothing);
        assert_eq!(sent.load(Ordering::Relaxed), 0);
    }
}
