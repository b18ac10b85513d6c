//! A line on a port: stations served in real time.
//!
//! The clock is the monotonic one, counted in bit times of the line. An operating system delivers characters late and in
//! groups, so the line counts as idle after the time that [`Delivery`](crate::port::Delivery) derives from the port.

use crate::clock::{Clock, duration_of, tbit_of};
use crate::line::{Line, Pace, Stations};
use crate::port::{Character, Notice, Opener, Port, PortError, Reopening, wait_for_port};
use crate::readiness::Readiness;
use crate::timing::{Measured, Timing};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Receiver};
use std::time::Duration;

/// The longest delay of an answer behind its time on a real line; a later one is dropped, because the master has given it up.
/// chosen: several times the delay that [`Delivery`](crate::port::Delivery) expects of the operating system.
const ANSWER_LATENESS: Duration = Duration::from_millis(20);

/// Stations on a line, the port of the line, and its clock.
pub struct Segment<C> {
    line: Line<C>,
    port: Box<dyn Port>,
    clock: Clock,
    /// The time of the clock at the beginning.
    first: BitTime,
    /// The silence after which the line counts as idle, in bit times.
    idle_tbit: u64,
    /// Measures the answers to the requests of a master.
    timing: Option<Timing>,
    received: Vec<Character>,
    out: Vec<u8>,
    /// The end of the last character.
    last_end: BitTime,
    baud: Baud,
    /// The generation of the port at the last reception.
    generation: u32,
    /// The port was opened again since the last call of `take_reopened`.
    reopened: bool,
}

/// Takes the place of the port while the port is wrapped.
struct NullPort;

impl Port for NullPort {
    fn name(&self) -> &'static str {
        "nowhere"
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        Vec::new()
    }

    fn receive(&mut self, _heard: &mut Vec<Character>) -> Result<(), PortError> {
        Ok(())
    }

    fn send(&mut self, _octets: &[u8]) -> Result<(), PortError> {
        Ok(())
    }
}

impl<C: Stations> Segment<C> {
    /// Puts `stations` on `port`. With `paced`, the octets of a port without a baud rate leave at the pace of the line.
    pub fn new(port: Box<dyn Port>, baud: Baud, paced: bool, stations: C) -> Self {
        let gap_tbit = port.delivery().idle_tbit(baud);
        // On a real line a telegram may be under way. A line without a baud rate begins with this segment and is idle.
        let first = if port.is_timed() { BitTime(0) } else { BitTime(0) + gap_tbit + CHARACTER_TBIT };
        let pace = match (port.is_timed(), paced) {
            (true, _) => Pace::ByPort,
            (false, true) => Pace::ByLine,
            (false, false) => Pace::Instant,
        };
        let line = Line::new(stations, Receiver::with_idle(BitTime(0), gap_tbit), pace);
        // Only on a real line a late answer disturbs another telegram.
        let line = if port.is_timed() { line.with_lateness_limit(tbit_of(baud, ANSWER_LATENESS)) } else { line };
        let generation = port.generation();
        Self {
            line,
            port,
            clock: Clock::starting_at(first, baud),
            first,
            idle_tbit: gap_tbit,
            timing: None,
            received: Vec::new(),
            out: Vec::new(),
            last_end: BitTime(0),
            baud,
            generation,
            reopened: false,
        }
    }

    /// The same segment, which has one master and measures the answers to its requests. A pause within an answer that is longer than
    /// the port should make is tolerated from then on, up to [`Delivery::max_pause`](crate::port::Delivery::max_pause).
    #[must_use]
    pub fn measuring(mut self) -> Self {
        self.timing = Some(Timing::default());
        self
    }

    /// The longest times that were measured; none without [`measuring`](Self::measuring).
    pub fn measured(&self) -> Measured {
        self.timing.as_ref().map(Timing::measured).unwrap_or_default()
    }

    /// The silence after which the line counts as idle, and the longest tolerated pause within a telegram, in bit times.
    pub const fn idle_tbit(&self) -> u64 {
        self.idle_tbit
    }

    /// The same segment with a port that `opener` opens again whenever it is lost. Meanwhile the line behaves like a
    /// disconnected cable.
    #[must_use]
    pub fn with_reopening(mut self, opener: Opener) -> Self {
        self.set_reopening(opener);
        self
    }

    /// [`with_reopening`](Self::with_reopening) in place.
    pub fn set_reopening(&mut self, opener: Opener) {
        let port = self.take_port();
        self.port = Box::new(Reopening::new(port, opener));
        self.generation = 0;
    }

    /// Takes the oldest notice of the port.
    pub fn next_notice(&mut self) -> Option<Notice> {
        self.port.next_notice()
    }

    /// Whether the port was opened again since the last call. A master must listen first; slaves need nothing.
    pub const fn take_reopened(&mut self) -> bool {
        std::mem::replace(&mut self.reopened, false)
    }

    /// Takes the port away; the segment ends with it.
    pub fn take_port(&mut self) -> Box<dyn Port> {
        std::mem::replace(&mut self.port, Box::new(NullPort))
    }

    /// The port.
    pub fn port(&self) -> &dyn Port {
        &*self.port
    }

    /// The stations.
    pub const fn stations(&self) -> &C {
        self.line.stations()
    }

    /// Sets the probability with which noise damages an octet, 0 to 1.
    pub const fn set_noise(&mut self, part: f64) {
        self.line.set_noise(part);
    }

    /// The stations, mutable.
    pub const fn stations_mut(&mut self) -> &mut C {
        self.line.stations_mut()
    }

    /// The number of damaged telegrams received.
    pub const fn damaged_telegrams(&self) -> u32 {
        self.line.damaged_telegrams()
    }

    /// The number of telegrams of the stations that were dropped: too late, or too many.
    pub const fn dropped_telegrams(&self) -> u32 {
        self.line.dropped_telegrams()
    }

    /// The time of the segment's clock.
    pub fn now(&self) -> BitTime {
        match self.port.simulated_time() {
            None => self.clock.now(),
            Some(elapsed) => self.first + tbit_of(self.baud, elapsed),
        }
    }

    /// The end of the last character that the port delivers now. The clock counts whole bit times, so a real line takes the next one: an
    /// answer never leaves before its time.
    fn heard_at(&self) -> BitTime {
        let is_real = self.port.is_timed() && self.port.simulated_time().is_none();
        self.now() + u64::from(is_real)
    }

    /// Serves the line once: waits for an octet, the next deadline of a station or one of `others`, at most `at_most`; then
    /// receives, runs the stations and sends. Returns for each of `others` whether it is readable.
    ///
    /// # Errors
    /// [`PortError::Lost`] when the port is gone; [`PortError::System`].
    pub fn serve(&mut self, others: &[Readiness<'_>], at_most: Duration) -> Result<Vec<bool>, PortError> {
        let until = |wake_at: BitTime| duration_of(self.baud, wake_at - self.now());
        let due = self.line.wake_at().map_or(at_most, |wake_at| until(wake_at).min(at_most));
        let readable = wait_for_port(&mut *self.port, others, due)?;
        self.receive()?;
        self.out.clear();
        let now = self.now();
        self.line.advance(now, &mut self.out);
        if !self.out.is_empty() {
            self.port.send(&self.out)?;
            if let Some(timing) = &mut self.timing {
                let octets = if self.port.is_timed() { self.out.len() as u64 } else { 0 };
                timing.sent(&self.out, now + octets.saturating_mul(CHARACTER_TBIT));
            }
        }
        Ok(readable)
    }

    /// Measures what was received at `now`. This comes before the line receives it, so that the telegram that has a long pause is
    /// valid already.
    fn measure(&mut self, now: BitTime) {
        let is_timed = self.port.is_timed();
        let Some(timing) = self.timing.as_mut().filter(|_| !self.received.is_empty()) else { return };
        timing.delivered(now, &self.received, is_timed);
        let max_pause_tbit = tbit_of(self.baud, self.port.delivery().max_pause());
        let needed = timing.measured().pause_tbit.min(max_pause_tbit);
        if needed > self.idle_tbit {
            self.idle_tbit = needed;
            self.line.set_idle(needed);
        }
    }

    fn receive(&mut self) -> Result<(), PortError> {
        self.received.clear();
        self.port.receive(&mut self.received)?;
        let now = self.heard_at();
        if self.port.generation() != self.generation {
            self.generation = self.port.generation();
            self.reopened = true;
            // A telegram may be under way.
            self.idle_tbit = self.port.delivery().idle_tbit(self.baud);
            self.line.reset(Receiver::with_idle(now, self.idle_tbit));
            self.timing.iter_mut().for_each(Timing::forget);
        }
        self.measure(now);
        let timed = self.port.is_timed();
        for (character, after) in self.received.iter().zip((0..self.received.len() as u64).rev()) {
            // A UART delivers several characters at once. Those before the last one ended earlier.
            let early_tbit = if timed { after.saturating_mul(CHARACTER_TBIT) } else { 0 };
            self.last_end = self.last_end.max(BitTime(now.0.saturating_sub(early_tbit)));
            self.line.receive(self.last_end, *character);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::Delivery;
    use profivac_dp::link::{Station, Transmit};
    use profivac_wire::Telegram;
    use std::io::{Read, Write};
    use std::os::unix::net::UnixStream;
    use std::sync::{Arc, Mutex};
    use std::time::Instant;

    const REQUEST: [u8; 6] = [0x10, 8, 2, 0x49, 0x53, 0x16];
    const ANSWER: [u8; 6] = [0x10, 2, 8, 0, 0x0A, 0x16];

    /// When the port delivered the last characters, and when it was given octets to send.
    #[derive(Debug, Default)]
    struct Times {
        handed_over: Option<Instant>,
        sent: Option<Instant>,
    }

    /// A UART whose driver delivers the octets of a socket.
    struct Uart {
        driver: UnixStream,
        times: Arc<Mutex<Times>>,
    }

    impl Port for Uart {
        fn name(&self) -> &str {
            "uart"
        }

        fn delivery(&self) -> Delivery {
            Delivery::Fifo { trigger: None }
        }

        fn readiness(&self) -> Vec<Readiness<'_>> {
            vec![Readiness::of(&self.driver)]
        }

        fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
            let mut buffer = [0; 16];
            if let Ok(length) = self.driver.read(&mut buffer) {
                heard.extend(buffer.iter().take(length).map(|octet| Character::Octet(*octet)));
                self.times.lock().unwrap().handed_over = Some(Instant::now());
            }
            Ok(())
        }

        fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
            self.times.lock().unwrap().sent = Some(Instant::now());
            self.driver.write_all(octets).unwrap();
            Ok(())
        }
    }

    /// Answers FDL status after this number of bit times.
    struct Slave(u64);

    impl Station for Slave {
        fn telegram(&mut self, end: BitTime, _: &Telegram<'_>) -> Option<Transmit<'_>> {
            Some(Transmit { not_before: end + self.0, octets: &ANSWER })
        }

        fn poll(&mut self, _: BitTime) -> Option<Transmit<'_>> {
            None
        }

        fn wake_at(&self) -> Option<BitTime> {
            None
        }
    }

    /// The answer window counts from the moment at which the driver delivered the last character: later than on the line,
    /// never earlier.
    #[test]
    fn an_answer_on_a_uart_waits_for_its_time_after_the_last_character() {
        for (baud, min_tsdr) in [(Baud::B9600, 11), (Baud::B19200, 60), (Baud::B93750, 1000)] {
            let (mut line, driver) = UnixStream::pair().unwrap();
            driver.set_nonblocking(true).unwrap();
            let times = Arc::new(Mutex::new(Times::default()));
            let uart = Uart { driver, times: Arc::clone(&times) };
            let mut segment = Segment::new(Box::new(uart), baud, false, [Slave(min_tsdr)]);
            // A real line must be silent first.
            while segment.now() < BitTime(0) + segment.port().delivery().idle_tbit(baud) + CHARACTER_TBIT * 7 {
                segment.serve(&[], Duration::from_millis(2)).unwrap();
            }
            line.write_all(&REQUEST).unwrap();
            let deadline = Instant::now() + Duration::from_secs(60);
            while times.lock().unwrap().sent.is_none() && Instant::now() < deadline {
                segment.serve(&[], Duration::from_millis(100)).unwrap();
            }
            let Times { handed_over: Some(heard), sent: Some(sent) } = *times.lock().unwrap() else {
                panic!("the answer was not sent")
            };
            let window = crate::clock::duration_of(baud, min_tsdr);
            assert!(sent - heard >= window, "{:?} of {window:?} at {baud}", sent - heard);
            let mut answer = [0; 6];
            line.read_exact(&mut answer).unwrap();
            assert_eq!(answer, ANSWER);
        }
    }
}
