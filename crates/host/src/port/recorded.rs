//! Records the octets of a port in both directions, with their times.

use super::{Character, Delivery, Notice, Port, PortError, ReaderSearch};
use crate::readiness::Readiness;
use profivac_dp::link::Baud;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Whether this computer sent or received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// This computer sent.
    Sent,
    /// This computer received.
    Received,
}

/// Characters that the program gave to the port, or got from it, at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedChunk {
    /// When the program sent or got them, since the beginning of the recording.
    pub at: Duration,
    /// The sender.
    pub direction: Direction,
    /// The characters, at least one.
    pub characters: Vec<Character>,
}

/// The memory that the chunks of a recording may occupy, in octets. chosen: about 600 000 requests with short answers.
const MAX_MEMORY: usize = 128 << 20;

/// The chunks of one or several ports on the same line, in the order of their times.
///
/// Its memory is limited: see [`is_full`](Self::is_full).
#[derive(Clone, Debug)]
pub struct Recording {
    begin: Instant,
    store: Arc<Mutex<Store>>,
}

#[derive(Debug)]
struct Store {
    chunks: Vec<RecordedChunk>,
    /// The memory for all chunks, in octets.
    limit: usize,
    /// The memory that is left of it.
    left: usize,
    is_full: bool,
}

impl Store {
    fn add(&mut self, chunk: RecordedChunk) {
        let octets = size_of::<Character>().saturating_mul(chunk.characters.len());
        match self.left.checked_sub(octets.saturating_add(size_of::<RecordedChunk>())) {
            // After a missing chunk the others would seem to follow each other.
            Some(left) if !self.is_full => {
                self.left = left;
                self.chunks.push(chunk);
            }
            Some(_) | None => self.is_full = true,
        }
    }
}

impl Recording {
    /// An empty recording that begins now.
    #[must_use]
    pub fn begin() -> Self {
        Self::with_limit(MAX_MEMORY)
    }

    /// The same with another limit of its memory, in octets.
    #[must_use]
    pub fn with_limit(octets: usize) -> Self {
        let store = Store { chunks: Vec::new(), limit: octets, left: octets, is_full: false };
        Self { begin: Instant::now(), store: Arc::new(Mutex::new(store)) }
    }

    /// Whether the limit of the memory is reached: later chunks are missing.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.store().is_full
    }

    fn store(&self) -> MutexGuard<'_, Store> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The time since the beginning of the recording.
    #[must_use]
    pub fn elapsed(&self) -> Duration {
        self.begin.elapsed()
    }

    /// The number of chunks so far.
    #[must_use]
    pub fn count(&self) -> usize {
        self.store().chunks.len()
    }

    /// A copy of the chunks from number `first` on.
    #[must_use]
    pub fn since(&self, first: usize) -> Vec<RecordedChunk> {
        self.store().chunks.get(first..).unwrap_or_default().to_vec()
    }

    /// Removes all chunks and returns them: a recording without end does not grow. Chunks are missing behind them if the recording
    /// [was full](Self::is_full); it has room again.
    #[must_use]
    pub fn take(&self) -> Vec<RecordedChunk> {
        let mut store = self.store();
        store.left = store.limit;
        store.is_full = false;
        std::mem::take(&mut store.chunks)
    }

    fn add(&self, at: Duration, direction: Direction, characters: Vec<Character>) {
        if !characters.is_empty() {
            self.store().add(RecordedChunk { at, direction, characters });
        }
    }
}

/// A port whose traffic is recorded. It behaves like the port inside.
pub struct Recorded {
    port: Box<dyn Port>,
    recording: Recording,
}

impl Recorded {
    /// Adds the traffic of `port` to `recording`.
    #[must_use]
    pub fn new(port: Box<dyn Port>, recording: Recording) -> Self {
        Self { port, recording }
    }
}

impl Port for Recorded {
    fn name(&self) -> &str {
        self.port.name()
    }

    fn delivery(&self) -> Delivery {
        self.port.delivery()
    }

    fn is_timed(&self) -> bool {
        self.port.is_timed()
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        self.port.readiness()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        let before = characters.len();
        let done = self.port.receive(characters);
        let new = characters.get(before..).unwrap_or_default().to_vec();
        self.recording.add(self.recording.elapsed(), Direction::Received, new);
        done
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        let at = self.recording.elapsed();
        self.port.send(octets)?;
        self.recording.add(at, Direction::Sent, octets.iter().copied().map(Character::Octet).collect());
        Ok(())
    }

    fn set_baud(&mut self, baud: Baud) -> Result<(), PortError> {
        self.port.set_baud(baud)
    }

    fn next_notice(&mut self) -> Option<Notice> {
        self.port.next_notice()
    }

    fn reader_search(&self) -> Option<ReaderSearch> {
        self.port.reader_search()
    }

    fn simulated_time(&self) -> Option<Duration> {
        self.port.simulated_time()
    }

    fn simulate(&mut self, at_most: Duration) {
        self.port.simulate(at_most);
    }

    fn generation(&self) -> u32 {
        self.port.generation()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::Stream;
    use std::io::{Read, Write};
    use std::os::unix::net::UnixStream;

    #[test]
    fn a_full_recording_keeps_its_first_chunks_and_says_so() {
        let of_one = size_of::<RecordedChunk>() + size_of::<Character>();
        let recording = Recording::with_limit(2 * of_one);
        let add = |ms, count| {
            let characters = vec![Character::Octet(0xE5); count];
            recording.add(Duration::from_millis(ms), Direction::Received, characters);
        };
        add(1, 1);
        assert!(!recording.is_full());
        add(2, 2);
        // It would fit.
        add(3, 1);
        let times: Vec<_> = recording.since(0).iter().map(|chunk| chunk.at.as_millis()).collect();
        assert_eq!((recording.is_full(), times), (true, vec![1]));
    }

    #[test]
    fn octets_of_both_directions_are_recorded_in_order_and_pass_unchanged() {
        let (mut line, ours) = UnixStream::pair().unwrap();
        ours.set_nonblocking(true).unwrap();
        let recording = Recording::begin();
        let mut port = Recorded::new(Box::new(Stream::new("line".to_owned(), ours, Vec::new())), recording.clone());
        port.send(&[0x10, 8]).unwrap();
        let mut request = [0; 2];
        line.read_exact(&mut request).unwrap();
        line.write_all(&[0xE5]).unwrap();
        let mut answer = Vec::new();
        port.receive(&mut answer).unwrap();
        port.receive(&mut answer).unwrap();
        assert_eq!((request, answer), ([0x10, 8], vec![Character::Octet(0xE5)]));
        let chunks = recording.since(0);
        let seen: Vec<_> = chunks.iter().map(|chunk| (chunk.direction, chunk.characters.len())).collect();
        assert_eq!(seen, [(Direction::Sent, 2), (Direction::Received, 1)]);
        assert!(chunks.first().map(|chunk| chunk.at) <= chunks.last().map(|chunk| chunk.at));
        assert_eq!((recording.count(), recording.since(1).len(), recording.since(9).len()), (2, 1, 0));
    }
}
