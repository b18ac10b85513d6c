//! The link to a slave through a port, in real time.

use super::dialogue::Link;
use super::probe::{Probe, Received};
use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT};
use profivac_host::clock::{duration_of, tbit_of};
use profivac_host::port::{Port, PortError};
use profivac_host::segment::Segment;
use profivac_wire::MAX_TELEGRAM;
use std::time::Duration;

/// The time by which a wait or a message cycle may be too long without consequences for a test. chosen: a quarter of the watchdog
/// that the tests of the watchdog use, which the slave must survive.
const STALL: Duration = Duration::from_millis(100);

/// A link to the slave through a port, in real time.
pub struct PortLink {
    segment: Segment<[Probe; 1]>,
    baud: Baud,
    /// A wait or a message cycle took too long.
    has_stalled: bool,
}

impl PortLink {
    /// A link through `port`. `bus` has the address of the testing master.
    #[must_use]
    pub fn new(port: Box<dyn Port>, baud: Baud, bus: BusParameters) -> Self {
        Self {
            segment: Segment::new(port, baud, false, [Probe::new(bus, BitTime(0))]).measuring(),
            baud,
            has_stalled: false,
        }
    }

    /// Listens for the timeout after which a master may claim the line. Returns the address of a master that uses the line.
    ///
    /// # Errors
    /// [`PortError`] if the port is lost.
    pub fn listen(&mut self) -> Result<Option<u8>, PortError> {
        let tbit = self.probe().timeout_tbit();
        self.wait(duration_of(self.baud, tbit))?;
        Ok(self.probe().other_master())
    }

    /// The address of another master that was received since the link was opened. Does not wait.
    #[must_use]
    pub fn other_master(&self) -> Option<u8> {
        let [probe] = self.segment.stations();
        probe.other_master()
    }

    /// The time by which an answer came after its request, if that was longer than the slot time.
    #[must_use]
    pub fn late_answer(&self) -> Option<Duration> {
        let [probe] = self.segment.stations();
        let turnaround_tbit = self.segment.measured().turnaround_tbit;
        (turnaround_tbit > probe.slot_tbit()).then(|| duration_of(self.baud, turnaround_tbit))
    }

    /// The baud rate of the line.
    #[must_use]
    pub const fn baud(&self) -> Baud {
        self.baud
    }

    /// The time since `start`, in the time of the port.
    fn elapsed(&self, start: BitTime) -> Duration {
        duration_of(self.baud, self.segment.now() - start)
    }

    fn probe(&mut self) -> &mut Probe {
        let [probe] = self.segment.stations_mut();
        probe
    }
}

impl Link for PortLink {
    fn address(&self) -> u8 {
        let [probe] = self.segment.stations();
        probe.address()
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        let start = self.segment.now();
        self.probe().send(octets);
        let received = loop {
            self.segment.serve(&[], Duration::from_secs(1))?;
            if let Some(received) = self.probe().received() {
                break received.clone();
            }
        };
        let longest = duration_of(self.baud, longest_cycle_tbit(octets.len(), self.probe().longest_silence_tbit()));
        self.has_stalled |= is_stall(self.elapsed(start), longest);
        Ok(received)
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        let start = self.segment.now();
        let end = start + tbit_of(self.baud, time);
        while self.segment.now() < end {
            self.segment.serve(&[], duration_of(self.baud, end - self.segment.now()))?;
        }
        self.has_stalled |= is_stall(self.elapsed(start), time);
        Ok(())
    }

    fn take_disturbed(&mut self) -> bool {
        std::mem::take(&mut self.has_stalled) | self.probe().take_late()
    }
}

/// The longest message cycle with a request of `octets`, in bit times: silence before it, the request, the slot time, and the longest
/// answer.
const fn longest_cycle_tbit(octets: usize, silence_tbit: u64) -> u64 {
    let octets = (octets as u64).saturating_add(MAX_TELEGRAM as u64);
    octets.saturating_mul(CHARACTER_TBIT).saturating_add(silence_tbit)
}

/// Whether something that takes at most `longest` took so long that the computer must have stopped the program.
fn is_stall(elapsed: Duration, longest: Duration) -> bool {
    elapsed > longest.saturating_add(STALL)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_or_a_cycle_that_takes_a_quarter_of_the_watchdog_too_long_is_a_stall() {
        let planned = Duration::from_millis(100);
        assert!(!is_stall(Duration::from_millis(100), planned));
        assert!(!is_stall(Duration::from_millis(200), planned));
        assert!(is_stall(Duration::from_millis(201), planned));
    }

    #[test]
    fn the_longest_cycle_has_request_answer_and_silences() {
        assert_eq!(longest_cycle_tbit(6, 200), (6 + 255) * 11 + 200);
    }
}
