//! A line on a port: stations served in real time.
//!
//! The clock is the monotonic one, counted in bit times of the segment's rate. An operating system reports characters late
//! and in pieces, so an idle line is one that was silent for [`PLATFORM_GAP`] or T_SYN, whichever is longer.

use crate::clock::{Clock, tbit_of};
use crate::line::{Line, Pace, Stations};
use crate::port::{Character, Port, PortError, wait};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Receiver, T_SYN_TBIT};
use rustix::fd::BorrowedFd;
use std::time::Duration;

/// How long a line must be silent to count as idle, and how long a telegram may pause. free choice: longer than the pieces
/// a telegram arrives in are apart, shorter than the slot time of any master that works through an operating system.
pub const PLATFORM_GAP: Duration = Duration::from_millis(2);

/// A line, the port it goes out through, and the time.
pub struct Segment<C> {
    line: Line<C>,
    port: Box<dyn Port>,
    clock: Clock,
    heard: Vec<Character>,
    out: Vec<u8>,
    /// When the last character ended.
    last: BitTime,
}

impl<C: Stations> Segment<C> {
    /// Puts `stations` on `port`. With `paced` the octets of a port that does not take time by itself are given theirs.
    pub fn new(port: Box<dyn Port>, baud: Baud, paced: bool, stations: C) -> Self {
        let gap_tbit = tbit_of(baud, PLATFORM_GAP).max(T_SYN_TBIT);
        // Who joins a real line may come in the middle of a telegram. A line that begins with us has been silent.
        let first = if port.is_timed() { BitTime(0) } else { BitTime(0) + gap_tbit + CHARACTER_TBIT };
        let pace = match (port.is_timed(), paced) {
            (true, _) => Pace::ByPort,
            (false, true) => Pace::ByLine,
            (false, false) => Pace::Instant,
        };
        Self {
            line: Line::new(stations, Receiver::with_idle(BitTime(0), gap_tbit), pace),
            port,
            clock: Clock::starting_at(first, baud),
            heard: Vec::new(),
            out: Vec::new(),
            last: BitTime(0),
        }
    }

    /// The port.
    pub fn port(&self) -> &dyn Port {
        &*self.port
    }

    /// The stations.
    pub const fn stations(&self) -> &C {
        self.line.stations()
    }

    /// The stations, to do something to them.
    pub const fn stations_mut(&mut self) -> &mut C {
        self.line.stations_mut()
    }

    /// How many damaged telegrams arrived.
    pub const fn damaged(&self) -> u32 {
        self.line.damaged()
    }

    /// What the clock of the segment shows.
    pub fn now(&self) -> BitTime {
        self.clock.now()
    }

    /// Serves the line once: waits until something is heard or due, at most `at_most`, and does what follows from it. Also
    /// wakes when one of `others` becomes readable, and says which.
    ///
    /// # Errors
    /// [`PortError::Lost`] when the port is gone.
    pub fn serve(&mut self, others: &[BorrowedFd<'_>], at_most: Duration) -> Result<Vec<bool>, PortError> {
        let due = self.line.wake_at().map_or(at_most, |wake_at| self.clock.until(wake_at).min(at_most));
        let watched: Vec<_> = others.iter().copied().chain(self.port.watched()).collect();
        let mut readable = wait(&watched, due)?;
        readable.truncate(others.len());
        self.receive()?;
        self.out.clear();
        self.line.advance(self.clock.now(), &mut self.out);
        if !self.out.is_empty() {
            self.port.send(&self.out)?;
        }
        Ok(readable)
    }

    fn receive(&mut self) -> Result<(), PortError> {
        self.heard.clear();
        self.port.receive(&mut self.heard)?;
        let now = self.clock.now();
        let timed = self.port.is_timed();
        for (character, after) in self.heard.iter().zip((0..self.heard.len() as u64).rev()) {
            // A UART hands over several characters at once: those before the last one ended earlier.
            let early_tbit = if timed { after.saturating_mul(CHARACTER_TBIT) } else { 0 };
            self.last = self.last.max(BitTime(now.0.saturating_sub(early_tbit)));
            self.line.hear(self.last, *character);
        }
        Ok(())
    }
}
