//! Listens to a port and never sends.

use super::PLATFORM_SILENCE;
use super::input::Chunk;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, T_SYN_TBIT};
use profivac_host::clock::{Clock, tbit_of};
use profivac_host::port::{Character, Port, PortError, wait};
use rustix::fd::BorrowedFd;
use std::time::Duration;

/// A port that is only listened to.
pub struct Tap {
    port: Box<dyn Port>,
    baud: Baud,
    clock: Clock,
    received: Vec<Character>,
    /// When the last character came, until the silence after it was told.
    last: Option<BitTime>,
    /// When the piece before began.
    before: BitTime,
}

/// What was heard.
#[derive(Clone, Debug, PartialEq)]
pub enum TapEvent {
    /// Octets.
    Octets(Chunk),
    /// Nothing for so long that nothing that comes belongs to what came.
    Silence,
    /// Nothing.
    Nothing,
}

impl Tap {
    /// Listens from now on.
    #[must_use]
    pub fn new(port: Box<dyn Port>, baud: Baud) -> Self {
        Self {
            port,
            baud,
            clock: Clock::starting_at(BitTime(0), baud),
            received: Vec::new(),
            last: None,
            before: BitTime(0),
        }
    }

    /// Waits until something is heard, at most `at_most`. Also wakes when one of `others` becomes readable, and says
    /// which.
    ///
    /// # Errors
    /// [`PortError::Lost`] when the port is gone.
    pub fn receive(
        &mut self,
        others: &[BorrowedFd<'_>],
        at_most: Duration,
    ) -> Result<(TapEvent, Vec<bool>), PortError> {
        let watched: Vec<_> = others.iter().copied().chain(self.port.watched()).collect();
        let at_most = if self.last.is_some() { at_most.min(PLATFORM_SILENCE) } else { at_most };
        let mut readable = wait(&watched, at_most)?;
        readable.truncate(others.len());
        self.received.clear();
        self.port.receive(&mut self.received)?;
        let now = self.clock.now();
        if !self.received.is_empty() {
            self.last = Some(now);
            return Ok((TapEvent::Octets(self.take_chunk(now)), readable));
        }
        let silence_tbit = tbit_of(self.baud, PLATFORM_SILENCE).max(T_SYN_TBIT);
        let heard = match self.last {
            Some(last) if now - last >= silence_tbit => {
                self.last = None;
                TapEvent::Silence
            }
            _ => TapEvent::Nothing,
        };
        Ok((heard, readable))
    }

    /// What was heard, with the time at which its first octet may have begun. Time never goes back.
    fn take_chunk(&mut self, now: BitTime) -> Chunk {
        let octet = |character: &Character| if let Character::Octet(octet) = character { *octet } else { 0 };
        let octets: Vec<u8> = self.received.iter().map(octet).collect();
        let broken = self.received.iter().enumerate().filter(|(_, character)| **character == Character::Error);
        let errors = broken.map(|(place, _)| place).collect();
        // A UART hands over several characters at once: the first began that much earlier.
        let early_tbit = if self.port.is_timed() { (octets.len() as u64).saturating_mul(CHARACTER_TBIT) } else { 0 };
        self.before = self.before.max(BitTime(now.0.saturating_sub(early_tbit)));
        Chunk { start: Some(self.before), octets, errors }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::fd::AsFd;
    use std::os::unix::net::UnixStream;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// A port with some characters, which counts what is sent.
    struct Spy {
        characters: Vec<Character>,
        end: UnixStream,
        sent: Arc<AtomicUsize>,
    }

    impl Port for Spy {
        fn name(&self) -> &str {
            "spy"
        }

        fn watched(&self) -> Vec<BorrowedFd<'_>> {
            vec![self.end.as_fd()]
        }

        fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
            heard.append(&mut self.characters);
            Ok(())
        }

        fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
            self.sent.fetch_add(octets.len().max(1), Ordering::Relaxed);
            Ok(())
        }
    }

    #[test]
    fn octets_and_broken_ones_are_noted_silence_is_told_once_and_nothing_is_sent() {
        let (sent, (end, _other)) = (Arc::new(AtomicUsize::new(0)), UnixStream::pair().unwrap());
        let characters = vec![Character::Octet(0x10), Character::Error, Character::Octet(2)];
        let mut ear = Tap::new(Box::new(Spy { characters, end, sent: sent.clone() }), Baud::B500000);
        let (heard, _) = ear.receive(&[], Duration::ZERO).unwrap();
        let TapEvent::Octets(noted) = heard else { panic!("{heard:?}") };
        assert_eq!((noted.octets, noted.errors), (vec![0x10, 0, 2], vec![1]));
        let mut silences = 0;
        while silences == 0 {
            silences += usize::from(ear.receive(&[], PLATFORM_SILENCE).unwrap().0 == TapEvent::Silence);
        }
        assert_eq!(ear.receive(&[], Duration::ZERO).unwrap().0, TapEvent::Nothing);
        assert_eq!(sent.load(Ordering::Relaxed), 0);
    }
}
