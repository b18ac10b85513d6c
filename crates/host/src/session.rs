//! A master on a port that asks one thing after the other: for commands that look, and for what they do before they exchange
//! data.
//!
//! Nothing here sends Set_Prm. Slaves that are added to the [`master`](Tool::master) are served beside what is asked.

use crate::clock::{duration_of, tbit_of};
use crate::port::{Notice, Opener, Port, PortError};
use crate::segment::Segment;
use profivac_dp::link::active::{
    Active, Answer, BusParameters, Confirmation, Failure, OutOfRange, Request, RingCounters, RingState,
};
use profivac_dp::link::{Baud, BitTime, Listening, Station, Transmit};
use profivac_dp::master::{Busy, Handle, Master, Operation, Settings, SlaveListError, SlaveParameters};
use profivac_wire::control::{StationType, Status};
use profivac_wire::{MAX_DU, Telegram};
use rustix::fd::BorrowedFd;
use std::time::{Duration, Instant};

/// A master with room for every slave a bus can have.
pub type BusMaster = Master<125, MAX_DU>;

/// What an operating system and a USB adapter may add to an answer. free choice: the 16 ms an adapter may keep octets
/// (profibus-wire 9.4, point 36), and some more.
const PLATFORM_DELAY: Duration = Duration::from_millis(20);

/// G. Each absent address that is asked costs a slot time, which is long on such a port; with a longer pause another tool
/// waits longer until it is let into the ring: [`entry_time`]. free choice.
const GAP_FACTOR: u8 = 2;

/// How long it takes at most to pass the token on at the end. free choice: some rotations of a small ring.
const TOKEN_PASS_TIMEOUT: Duration = Duration::from_secs(1);

/// The shortest time the line is waited for.
const MIN_WAIT: Duration = Duration::from_millis(1);

/// The bus parameters of a master behind an operating system.
#[must_use]
pub fn bus_parameters(address: u8, baud: Baud) -> BusParameters {
    let bus = BusParameters::new(address, baud);
    let delay_tbit = u32::try_from(tbit_of(baud, PLATFORM_DELAY)).unwrap_or(u32::MAX);
    BusParameters { slot_tbit: bus.slot_tbit.saturating_add(delay_tbit), gap_factor: GAP_FACTOR, ..bus }
}

/// How long it may take until a ring of such masters lets another one in. On a slow line that is many seconds: see
/// [`BusParameters::entry_tbit`].
#[must_use]
pub fn entry_time(bus: &BusParameters, baud: Baud) -> Duration {
    duration_of(baud, bus.entry_tbit())
}

/// Why nothing could be asked.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The port.
    #[error(transparent)]
    Port(#[from] PortError),
    /// No bus can have such parameters.
    #[error("{0}")]
    Parameters(OutOfRange),
    /// Another master has the line and does not let this one into its ring.
    #[error("master {0} is using the line")]
    LineInUse(u8),
    /// Another master with the address of this one is on the line.
    #[error("another master has the address {0}")]
    AddressInUse(u8),
    /// The line is never quiet.
    #[error("the line is never quiet")]
    NeverIdle,
}

/// What became of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// The answer.
    Answer {
        /// What kind of station answered.
        station: StationType,
        /// How it answered.
        status: Status,
        /// The data unit.
        du: Vec<u8>,
    },
    /// Nobody answered, or nothing that is an answer.
    NoAnswer(Failure),
}

/// Adds a slave to a master, or begins anew with one that was given back, for a read of its unit perhaps: with these
/// parameters and not with those it had then.
///
/// # Errors
/// [`Rejected`] when the parameters are impossible.
pub fn add_or_restart(master: &mut BusMaster, parameters: &SlaveParameters<'_>) -> Result<(), SlaveListError> {
    if master.state(parameters.address).is_none() {
        return master.add(parameters);
    }
    master.reparameterise(parameters)?;
    master.restart(parameters.address);
    Ok(())
}

/// The station, behind a pointer: it is too large to be handed around on the stack of a thread.
struct BoxedStation(Box<Active<BusMaster>>);

impl BoxedStation {
    /// Never part of its caller's stack.
    #[inline(never)]
    fn new(bus: BusParameters, baud: Baud) -> Self {
        Self(Box::new(BusMaster::on(bus, Settings::new(baud), BitTime(0))))
    }
}

impl Station for BoxedStation {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        self.0.telegram(end, telegram)
    }

    fn activity(&mut self, end: BitTime) {
        self.0.activity(end);
    }

    fn sent(&mut self, end: BitTime) {
        self.0.sent(end);
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        self.0.poll(now)
    }

    fn wake_at(&self) -> Option<BitTime> {
        self.0.wake_at()
    }

    fn listening(&self) -> Listening {
        self.0.listening()
    }
}

/// A master on a port.
pub struct BusSession {
    segment: Segment<[BoxedStation; 1]>,
    baud: Baud,
    timeout: Duration,
    /// The same for the line.
    line_timeout: Duration,
    entry: Duration,
    background: Option<BackgroundTask>,
}

/// What somebody does each time the line was served.
type BackgroundTask = Box<dyn FnMut(&mut BusMaster) + Send>;

/// While somebody does something beside, the line is waited for at most so long.
const MAX_WAIT: Duration = Duration::from_millis(20);

impl Drop for BusSession {
    /// What is asked last mostly ends with the token here, and a token that vanishes with its holder stops everybody until
    /// somebody dares to make another. Among others it is passed on before.
    fn drop(&mut self) {
        if self.masters().count() < 2 {
            return;
        }
        self.station().leave();
        let begun = Instant::now();
        while self.station().ring_state() == RingState::InRing && begun.elapsed() < TOKEN_PASS_TIMEOUT {
            if self.serve(&[], MIN_WAIT).is_err() {
                return;
            }
        }
    }
}

impl BusSession {
    /// A master without slaves. It waits at most for `patience` until it gets the line and until somebody answers.
    ///
    /// # Errors
    /// [`ToolError::Parameters`] when `bus` cannot be.
    pub fn new(port: Box<dyn Port>, baud: Baud, bus: BusParameters, patience: Duration) -> Result<Self, SessionError> {
        bus.check().map_err(SessionError::Parameters)?;
        let entry = entry_time(&bus, baud);
        let mut station = BoxedStation::new(bus, baud);
        station.0.delay_gap_scan();
        let segment = Segment::new(port, baud, false, [station]);
        Ok(Self { segment, baud, timeout: patience, line_timeout: patience, entry, background: None })
    }

    /// The same, and it waits for the line as long as a ring of such masters may take to let it in, if that is longer.
    #[must_use]
    pub const fn wait_for_ring_entry(mut self) -> Self {
        if self.entry.as_nanos() > self.line_timeout.as_nanos() {
            self.line_timeout = self.entry;
        }
        self
    }

    /// Does `work` whenever the line was served while something that was asked is waited for: who asks does not make those
    /// wait that exchange data.
    pub fn set_background_task(&mut self, work: impl FnMut(&mut BusMaster) + Send + 'static) {
        self.background = Some(Box::new(work));
    }

    /// The master.
    pub fn master(&mut self) -> &mut BusMaster {
        &mut self.station().user
    }

    /// Where this master stands to the ring.
    pub fn standing(&mut self) -> RingState {
        self.station().ring_state()
    }

    /// The slaves that were heard of, by the GAP or because they were asked.
    pub fn known_slaves(&mut self) -> Vec<u8> {
        let live = self.station().live_list();
        live.filter(|(_, station)| *station == StationType::Slave).map(|(address, _)| address).collect()
    }

    /// How many telegrams arrived damaged.
    #[must_use]
    pub const fn damaged_telegrams(&self) -> u32 {
        self.segment.damaged_telegrams()
    }

    /// The masters of the ring, this one included once it is in.
    pub fn masters(&mut self) -> impl Iterator<Item = u8> + use<> {
        self.station().masters()
    }

    /// What happened in the ring.
    pub fn ring_counters(&mut self) -> &RingCounters {
        self.station().ring_counters()
    }

    /// How long it waits for the line, and for somebody to answer.
    #[must_use]
    pub const fn timeout(&self) -> Duration {
        self.timeout
    }

    /// The rate of the line.
    #[must_use]
    pub const fn baud(&self) -> Baud {
        self.baud
    }

    /// Waits for what becomes of an acyclic request.
    ///
    /// # Errors
    /// [`ToolError`] when the line could not be had at all.
    pub fn wait_for_outcome<O: Operation, T>(
        &mut self,
        handle: Handle<O>,
        take: impl FnOnce(O::Outcome<'_>) -> T,
    ) -> Result<T, SessionError> {
        let begun = Instant::now();
        loop {
            if let Some(outcome) = self.master().outcome(handle) {
                return Ok(take(outcome));
            }
            self.wait(begun)?;
        }
    }

    /// The name of the port.
    #[must_use]
    pub fn port_name(&self) -> &str {
        self.segment.port().name()
    }

    /// Serves the line once, see [`Segment::serve`].
    ///
    /// # Errors
    /// [`PortError::Lost`] when the port is gone.
    pub fn serve(&mut self, others: &[BorrowedFd<'_>], at_most: Duration) -> Result<Vec<bool>, PortError> {
        let readable = self.segment.serve(others, at_most)?;
        if self.segment.take_reopened() {
            let now = self.segment.now();
            self.station().listen(now);
        }
        Ok(readable)
    }

    /// The same, and `opener` brings the port back whenever it is lost, see [`Segment::lasting`].
    #[must_use]
    pub fn lasting(mut self, opener: Opener) -> Self {
        self.segment.set_reopening(opener);
        self
    }

    /// What somebody should know about the port.
    pub fn next_notice(&mut self) -> Option<Notice> {
        self.segment.next_notice()
    }

    /// Asks once and waits for what comes of it.
    ///
    /// # Errors
    /// [`ToolError`] when the request could not be sent at all.
    pub fn request(&mut self, request: &Request<'_>) -> Result<Reply, SessionError> {
        let begun = Instant::now();
        // Busy: what was asked before was given up, and its result comes first.
        while let Err(Busy) = self.master().submit_request(request) {
            self.wait(begun)?;
            self.master().take_confirmation();
        }
        loop {
            self.wait(begun)?;
            let reply = match self.master().take_confirmation() {
                None => continue,
                Some(Confirmation::Answer(Answer { station, status, du, .. })) => {
                    Reply::Answer { station, status, du: du.to_vec() }
                }
                Some(Confirmation::Sent) => Reply::NoAnswer(Failure::Silence),
                Some(Confirmation::Failed(failure)) => Reply::NoAnswer(failure),
            };
            if reply != Reply::NoAnswer(Failure::Interrupted) {
                return Ok(reply);
            }
            // Nothing is in the slot any more.
            let _ = self.master().submit_request(request);
        }
    }

    /// Serves the line once on behalf of somebody who has been waiting since `begun`.
    fn wait(&mut self, begun: Instant) -> Result<(), SessionError> {
        let left = self.line_timeout.saturating_sub(begun.elapsed());
        // What takes longer than patience has its own end; meanwhile the line is served and not raced around.
        let longest = if self.background.is_some() { MAX_WAIT } else { left };
        self.serve(&[], left.min(longest).max(MIN_WAIT))?;
        let [BoxedStation(station)] = self.segment.stations_mut();
        if let Some(work) = &mut self.background {
            work(&mut station.user);
        }
        if !left.is_zero() || station.has_token() {
            return Ok(());
        }
        Err(match (station.ring_state(), station.other_master()) {
            (RingState::AddressTaken, _) => SessionError::AddressInUse(station.bus().address),
            (_, Some(master)) => SessionError::LineInUse(master),
            (_, None) => SessionError::NeverIdle,
        })
    }

    fn station(&mut self) -> &mut Active<BusMaster> {
        let [station] = self.segment.stations_mut();
        &mut station.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::Character;
    use profivac_dp::master::services;
    use profivac_sim::Segment;
    use rustix::fd::AsFd;
    use std::os::unix::net::UnixStream;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// A port on which nobody else is, and that was lost as often as the number says.
    struct Quiet(UnixStream, Arc<AtomicU32>);

    impl Port for Quiet {
        fn name(&self) -> &str {
            "quiet"
        }

        fn watched(&self) -> Vec<BorrowedFd<'_>> {
            vec![self.0.as_fd()]
        }

        fn receive(&mut self, _heard: &mut Vec<Character>) -> Result<(), PortError> {
            Ok(())
        }

        fn send(&mut self, _octets: &[u8]) -> Result<(), PortError> {
            Ok(())
        }

        fn generation(&self) -> u32 {
            self.1.load(Ordering::Relaxed)
        }
    }

    /// Two commands on one slow line, both with the parameters they have if nobody says otherwise. The first looks for
    /// others only now and then; whenever the second begins to listen, and wherever its address is, it is let in in time.
    #[test]
    fn a_second_tool_is_let_in_while_it_has_patience() {
        let baud = Baud::B19200;
        for (address, begins_ms) in [(1, 1_500), (1, 9_000), (60, 9_000), (125, 1_500), (125, 5_500), (125, 12_000)] {
            let mut bus = Segment::new(baud);
            let tool = |address, now| {
                let mut station = BusMaster::on(bus_parameters(address, baud), Settings::new(baud), now);
                station.delay_gap_scan();
                station
            };
            let first = bus.attach(tool(0, BitTime(0)));
            bus.run_until(BitTime(baud.tbit_of_ms(begins_ms))).unwrap();
            let now = bus.now();
            let second = bus.attach(tool(address, now));
            let patience = tbit_of(baud, entry_time(&bus_parameters(address, baud), baud));
            while bus.now() < now + patience && bus.station(second).ring_state() != RingState::InRing {
                // Nobody is at 90: each question costs a slot time.
                let _ = bus.station_mut(first).user.submit_request(&services::slave_diag(90));
                bus.station_mut(first).user.take_confirmation();
                bus.run_for(100).unwrap();
            }
            let standing = bus.station(second).ring_state();
            assert_eq!(standing, RingState::InRing, "{address}, which begins after {begins_ms} ms");
        }
    }

    /// On the line it comes back to there may be another master by now.
    #[test]
    fn a_master_whose_port_is_back_has_no_token() {
        let (ours, _theirs) = UnixStream::pair().unwrap();
        let lost = Arc::new(AtomicU32::new(0));
        let port = Quiet(ours, Arc::clone(&lost));
        let (baud, patience) = (Baud::B19200, Duration::from_secs(30));
        let mut tool = BusSession::new(Box::new(port), baud, bus_parameters(2, baud), patience).unwrap();
        for _ in 0..2 {
            while !tool.station().has_token() {
                tool.serve(&[], patience).unwrap();
            }
            lost.fetch_add(1, Ordering::Relaxed);
            tool.serve(&[], Duration::ZERO).unwrap();
            assert!(!tool.station().has_token());
        }
    }
}
