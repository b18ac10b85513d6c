//! A master on a port that sends one request after the other. Commands use it, and clients before they exchange data.
//!
//! The session itself never sends Set_Prm. It serves slaves that were added to the [`master`](BusSession::master) while it
//! waits for an answer.

use crate::clock::{duration_of, tbit_of};
use crate::port::{Delivery, LateAnswerRemedy, Notice, Opener, Port, PortError};
use crate::readiness::Readiness;
use crate::segment::Segment;
use profivac_dp::link::active::{
    Active, Answer, BusParameters, CheckedBus, Confirmation, Failure, OutOfRange, Request, RingCounters, RingState,
};
use profivac_dp::link::{Baud, BitTime, Listening, Station, Transmit};
use profivac_dp::master::{Busy, Handle, Master, Operation, Settings, SlaveListError, SlaveParameters};
use profivac_wire::control::{StationType, Status};
use profivac_wire::{MAX_DU, Telegram};
use std::collections::BTreeMap;
use std::fmt;
use std::time::{Duration, Instant};

/// A master with room for every slave of a bus.
pub type BusMaster = Master<125, MAX_DU>;

/// G. Each request to an absent address costs a slot time, which is long on such a port; a longer pause would delay the
/// entry of another master into the ring: [`entry_time`]. free choice.
const GAP_FACTOR: u8 = 2;

/// The longest wait for passing the token at the end. free choice: some rotations of a small ring.
const TOKEN_PASS_TIMEOUT: Duration = Duration::from_secs(1);

/// The longest slot time of PROFIBUS, in bit times. profibus-wire 1.12.
pub const MAX_SLOT_TBIT: u32 = 16_383;

/// The shortest wait for the line.
const MIN_WAIT: Duration = Duration::from_millis(1);

/// The bus parameters of a master on a port of an operating system: the slot time is longer by what the port delays.
#[must_use]
pub fn bus_parameters(address: u8, baud: Baud, delivery: Delivery) -> BusParameters {
    let bus = BusParameters::new(address, baud);
    let delay_tbit = u32::try_from(tbit_of(baud, delivery.slot_delay(baud))).unwrap_or(u32::MAX);
    BusParameters { slot_tbit: bus.slot_tbit.saturating_add(delay_tbit), gap_factor: GAP_FACTOR, ..bus }
}

/// How long a ring of such masters may take to admit another one. Many seconds on a slow line: see
/// [`BusParameters::entry_tbit`].
#[must_use]
pub fn entry_time(bus: &BusParameters, baud: Baud) -> Duration {
    duration_of(baud, bus.entry_tbit())
}

/// The reason why a session could not send a request.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SessionError {
    /// The port failed.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The bus parameters are out of range.
    #[error("{0}")]
    Parameters(OutOfRange),
    /// Another master uses the line and does not admit this one into its ring.
    #[error("master {0} is using the line")]
    LineInUse(u8),
    /// Another master has the address of this one.
    #[error("another master has the address {0}")]
    AddressInUse(u8),
    /// The line is never idle.
    #[error("the line is never idle")]
    NeverIdle,
    /// The program ends: see [`BusSession::set_cancellation`].
    #[error("interrupted")]
    Interrupted,
}

/// A record of one octet that a client changed for a moment and could not set back because the line was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnrestoredRecord {
    /// The slot.
    pub slot: u8,
    /// The index.
    pub index: u8,
    /// The value that the client wrote.
    pub written: u8,
    /// The value before.
    pub original: u8,
}

/// The reply of a station, or its absence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// The station answered.
    Answer {
        /// The type of the station.
        station: StationType,
        /// The status of the answer.
        status: Status,
        /// The data unit.
        du: Vec<u8>,
    },
    /// No station answered, or the answer was invalid.
    NoAnswer(Failure),
}

/// Adds a slave to a master, or restarts it with new parameters if the master has it already.
///
/// # Errors
/// [`SlaveListError`] when the parameters are impossible.
pub fn add_or_restart(master: &mut BusMaster, parameters: &SlaveParameters<'_>) -> Result<(), SlaveListError> {
    if master.state(parameters.address).is_none() {
        return master.add(parameters);
    }
    master.reparameterise(parameters)?;
    master.restart(parameters.address);
    Ok(())
}

/// The station behind a pointer: it is too large for the stack of a thread.
struct BoxedStation(Box<Active<BusMaster>>);

impl BoxedStation {
    /// Keeps the station off the stack of the caller.
    #[inline(never)]
    fn new(bus: CheckedBus, baud: Baud) -> Self {
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

/// A master on a port that sends one request after the other.
pub struct BusSession {
    segment: Segment<[BoxedStation; 1]>,
    baud: Baud,
    timeout: Duration,
    /// The same for access to the line.
    line_timeout: Duration,
    entry: Duration,
    background: Option<BackgroundTask>,
    cancellation: Option<Cancellation>,
    /// A guard restores what the program has changed.
    is_restoring: bool,
    unrestored: BTreeMap<u8, UnrestoredRecord>,
    /// Whether a measured turnaround may raise the slot time.
    adapts_slot_time: bool,
    /// The longest turnaround that a notice has reported, in bit times.
    reported_tbit: u64,
    /// A late answer that no notice has reported.
    late_answer: Option<Notice>,
    closing: Option<Closing>,
}

/// Runs when the session ends.
type Closing = Box<dyn FnOnce(&SessionTiming, Vec<Notice>) + Send>;

/// The longest times that a session measured, beside those that it works with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionTiming {
    /// The answers that were measured.
    pub answers: u64,
    /// From the end of a request to the delivery of the first characters of its answer.
    pub turnaround: Duration,
    /// The slot time.
    pub slot_time: Duration,
    /// Between two deliveries of characters of one answer.
    pub pause: Duration,
    /// The longest pause that is tolerated within a telegram.
    pub tolerated_pause: Duration,
}

impl fmt::Display for SessionTiming {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        write!(
            f,
            "measured on {} answers: the first characters came up to {:.1} ms after the request (slot time {:.1} ms), with pauses up \
             to {:.1} ms within an answer (up to {:.1} ms are tolerated)",
            self.answers,
            ms(self.turnaround),
            ms(self.slot_time),
            ms(self.pause),
            ms(self.tolerated_pause)
        )
    }
}

/// Runs each time the line was served.
type BackgroundTask = Box<dyn FnMut(&mut BusMaster) + Send>;

/// Whether the program wants to end.
type Cancellation = Box<dyn Fn() -> bool + Send>;

/// The longest wait for the line while a background task or a cancellation exists.
const MAX_WAIT: Duration = Duration::from_millis(20);

impl Drop for BusSession {
    /// Passes the token on first if other masters are in the ring. If the holder vanished with the token, the ring would
    /// stand still until another master replaces the token.
    fn drop(&mut self) {
        self.pass_token_on();
        let timing = self.timing();
        if let Some(closing) = self.closing.take() {
            closing(&timing, std::iter::from_fn(|| self.next_notice()).collect());
        }
    }
}

impl BusSession {
    /// A master without slaves. `timeout` limits the wait for the line and for an answer.
    ///
    /// # Errors
    /// [`SessionError::Parameters`] when `bus` is out of range.
    pub fn new(port: Box<dyn Port>, baud: Baud, bus: BusParameters, timeout: Duration) -> Result<Self, SessionError> {
        let entry = entry_time(&bus, baud);
        let bus = bus.check().map_err(SessionError::Parameters)?;
        let mut station = BoxedStation::new(bus, baud);
        station.0.delay_gap_scan();
        let segment = Segment::new(port, baud, false, [station]).measuring();
        Ok(Self {
            segment,
            baud,
            timeout,
            line_timeout: timeout,
            entry,
            background: None,
            cancellation: None,
            is_restoring: false,
            unrestored: BTreeMap::new(),
            adapts_slot_time: true,
            reported_tbit: 0,
            late_answer: None,
            closing: None,
        })
    }

    /// The same session with a timeout for the line that is at least the time a ring of such masters takes to admit it.
    #[must_use]
    pub const fn wait_for_ring_entry(mut self) -> Self {
        if self.entry.as_nanos() > self.line_timeout.as_nanos() {
            self.line_timeout = self.entry;
        }
        self
    }

    /// The same session with a slot time that stays as it is.
    #[must_use]
    pub const fn with_fixed_slot_time(mut self) -> Self {
        self.adapts_slot_time = false;
        self
    }

    /// Calls `closing` when the session ends, with the notices that nothing has taken.
    pub fn on_close(&mut self, closing: impl FnOnce(&SessionTiming, Vec<Notice>) + Send + 'static) {
        self.closing = Some(Box::new(closing));
    }

    /// What the session has measured so far.
    pub fn timing(&mut self) -> SessionTiming {
        let (baud, measured) = (self.baud, self.segment.measured());
        let slot_tbit = self.station().bus().slot_tbit.into();
        SessionTiming {
            answers: measured.answers,
            turnaround: duration_of(baud, measured.turnaround_tbit),
            slot_time: duration_of(baud, slot_tbit),
            pause: duration_of(baud, measured.pause_tbit),
            tolerated_pause: duration_of(baud, self.segment.idle_tbit()),
        }
    }

    /// Raises the slot time if an answer came later, and this master is alone. Beside other masters the notice says what the user
    /// has to do.
    fn check_turnaround(&mut self) {
        let turnaround_tbit = self.segment.measured().turnaround_tbit;
        let slot_tbit = self.station().bus().slot_tbit;
        if turnaround_tbit <= u64::from(slot_tbit).max(self.reported_tbit) {
            return;
        }
        let (baud, adapts, name) = (self.baud, self.adapts_slot_time, self.port_name().to_owned());
        self.reported_tbit = turnaround_tbit;
        let station = self.station();
        let is_alone = station.masters().count() < 2 && station.other_master().is_none();
        let wanted_tbit = u32::try_from(turnaround_tbit.saturating_mul(2)).unwrap_or(u32::MAX);
        let needed_tbit = wanted_tbit.min(MAX_SLOT_TBIT);
        let remedy = match adapts && is_alone {
            _ if turnaround_tbit > needed_tbit.into() => LateAnswerRemedy::Impossible,
            true => LateAnswerRemedy::Raised,
            false => LateAnswerRemedy::ToBeSet,
        };
        if remedy == LateAnswerRemedy::Raised {
            station.raise_slot_time(needed_tbit);
        }
        // On a pty or TCP the cause is the load of the computer, which needs no action.
        if remedy == LateAnswerRemedy::Raised && !self.segment.port().is_timed() {
            return;
        }
        let turnaround_ms = u64::try_from(duration_of(baud, turnaround_tbit).as_millis()).unwrap_or(u64::MAX);
        self.late_answer = Some(Notice::LateAnswer { name, turnaround_ms, slot_tbit, needed_tbit, remedy });
    }

    /// Leaves the ring of other masters. A master that vanishes with the token stops all of them for a while.
    fn pass_token_on(&mut self) {
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

    /// Runs `work` each time the line was served while a request waits, so that requests do not delay the evaluation of
    /// cyclic data.
    pub fn set_background_task(&mut self, work: impl FnMut(&mut BusMaster) + Send + 'static) {
        self.background = Some(Box::new(work));
    }

    /// Ends each wait with [`SessionError::Interrupted`] as soon as `is_cancelled` returns true. `None` waits as before.
    pub fn set_cancellation(&mut self, is_cancelled: Option<Box<dyn Fn() -> bool + Send>>) {
        self.cancellation = is_cancelled;
    }

    /// While this is true, waits do not end by cancellation: the guards of a client restore what they have changed although the
    /// program ends. The timeout limits each wait.
    pub const fn set_restoring(&mut self, is_restoring: bool) {
        self.is_restoring = is_restoring;
    }

    /// The master.
    pub fn master(&mut self) -> &mut BusMaster {
        &mut self.station().user
    }

    /// The state of this master in the token ring.
    pub fn ring_state(&mut self) -> RingState {
        self.station().ring_state()
    }

    /// The slaves that the GAP or a request has found.
    pub fn known_slaves(&mut self) -> Vec<u8> {
        let live = self.station().live_list();
        live.filter(|(_, station)| *station == StationType::Slave).map(|(address, _)| address).collect()
    }

    /// The number of damaged telegrams received.
    #[must_use]
    pub const fn damaged_telegrams(&self) -> u32 {
        self.segment.damaged_telegrams()
    }

    /// The masters of the ring, including this one once it is admitted.
    pub fn masters(&mut self) -> impl Iterator<Item = u8> + use<> {
        self.station().masters()
    }

    /// The counters of the token ring.
    pub fn ring_counters(&mut self) -> &RingCounters {
        self.station().ring_counters()
    }

    /// The longest wait for the line, and for an answer.
    #[must_use]
    pub const fn timeout(&self) -> Duration {
        self.timeout
    }

    /// The baud rate of the line.
    #[must_use]
    pub const fn baud(&self) -> Baud {
        self.baud
    }

    /// Serves the line until an acyclic request has an outcome.
    ///
    /// # Errors
    /// [`SessionError`] when the master does not get the line.
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

    /// Serves the line once for a request that the master does not accept yet. Returns false if the timeout has passed since
    /// `begun`.
    ///
    /// # Errors
    /// [`SessionError`] when the master does not get the line.
    pub fn wait_once(&mut self, begun: Instant) -> Result<bool, SessionError> {
        self.wait(begun)?;
        Ok(begun.elapsed() < self.line_timeout)
    }

    /// Keeps a record of the slave at `address` that could not be set back, for the next client of this slave.
    pub fn keep_unrestored(&mut self, address: u8, record: UnrestoredRecord) {
        self.unrestored.insert(address, record);
    }

    /// Takes the record that [`keep_unrestored`](Self::keep_unrestored) kept for the slave at `address`.
    pub fn take_unrestored(&mut self, address: u8) -> Option<UnrestoredRecord> {
        self.unrestored.remove(&address)
    }

    /// Takes all kept records by address. A program that opens a new session on the same line hands them over to it.
    pub fn take_all_unrestored(&mut self) -> BTreeMap<u8, UnrestoredRecord> {
        std::mem::take(&mut self.unrestored)
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
    pub fn serve(&mut self, others: &[Readiness<'_>], at_most: Duration) -> Result<Vec<bool>, PortError> {
        let readable = self.segment.serve(others, at_most)?;
        self.check_turnaround();
        if self.segment.take_reopened() {
            let now = self.segment.now();
            self.station().listen(now);
        }
        Ok(readable)
    }

    /// The same session with a port that `opener` opens again whenever it is lost, see [`Segment::with_reopening`].
    #[must_use]
    pub fn with_reopening(mut self, opener: Opener) -> Self {
        self.segment.set_reopening(opener);
        self
    }

    /// Takes the oldest notice of the port.
    pub fn next_notice(&mut self) -> Option<Notice> {
        self.late_answer.take().or_else(|| self.segment.next_notice())
    }

    /// Sends a request once and waits for the reply.
    ///
    /// # Errors
    /// [`SessionError`] when the master does not get the line.
    pub fn request(&mut self, request: &Request<'_>) -> Result<Reply, SessionError> {
        let begun = Instant::now();
        // The master is busy with a request that was given up; its result comes first.
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
            // The slot is free, so the request is accepted.
            let _ = self.master().submit_request(request);
        }
    }

    /// Serves the line once for a request that has been waiting since `begun`.
    fn wait(&mut self, begun: Instant) -> Result<(), SessionError> {
        let left = self.line_timeout.saturating_sub(begun.elapsed());
        // A request that takes longer than the timeout has its own limit; meanwhile the line is served without a busy loop.
        let longest = if self.background.is_some() || self.cancellation.is_some() { MAX_WAIT } else { left };
        self.serve(&[], left.min(longest).max(MIN_WAIT))?;
        if !self.is_restoring && self.cancellation.as_ref().is_some_and(|is_cancelled| is_cancelled()) {
            return Err(SessionError::Interrupted);
        }
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
    use std::os::unix::net::UnixStream;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// A port on a silent line. The number counts how often the port was lost.
    struct Quiet(UnixStream, Arc<AtomicU32>);

    impl Port for Quiet {
        fn name(&self) -> &str {
            "quiet"
        }

        fn readiness(&self) -> Vec<Readiness<'_>> {
            vec![Readiness::of(&self.0)]
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

    /// Two sessions on one slow line with default parameters. The first polls its GAP rarely; the second is still admitted
    /// in time, whatever its address and starting time.
    #[test]
    fn a_second_session_is_admitted_to_the_ring_within_its_timeout() {
        let baud = Baud::B19200;
        for (address, begins_ms) in [(1, 1_500), (1, 9_000), (60, 9_000), (125, 1_500), (125, 5_500), (125, 12_000)] {
            let mut bus = Segment::new(baud);
            let master = |address, now| {
                let mut station = BusMaster::on(
                    bus_parameters(address, baud, Delivery::Unpaced).check().unwrap(),
                    Settings::new(baud),
                    now,
                );
                station.delay_gap_scan();
                station
            };
            let first = bus.attach(master(0, BitTime(0)));
            bus.run_until(BitTime(baud.tbit_of_ms(begins_ms))).unwrap();
            let now = bus.now();
            let second = bus.attach(master(address, now));
            let timeout = tbit_of(baud, entry_time(&bus_parameters(address, baud, Delivery::Unpaced), baud));
            while bus.now() < now + timeout && bus.station(second).ring_state() != RingState::InRing {
                // Address 90 is empty: each request costs a slot time.
                let _ = bus.station_mut(first).user.submit_request(&services::slave_diag(90));
                bus.station_mut(first).user.take_confirmation();
                bus.run_for(100).unwrap();
            }
            let ring_state = bus.station(second).ring_state();
            assert_eq!(ring_state, RingState::InRing, "{address}, which begins after {begins_ms} ms");
        }
    }

    /// A program that ends does not wait for an answer.
    #[test]
    fn a_cancellation_ends_a_wait() {
        let (ours, _theirs) = UnixStream::pair().unwrap();
        let port = Quiet(ours, Arc::default());
        let (baud, timeout) = (Baud::B19200, Duration::from_secs(3600));
        let bus = bus_parameters(2, baud, Delivery::Unpaced);
        let mut session = BusSession::new(Box::new(port), baud, bus, timeout).unwrap();
        session.set_cancellation(Some(Box::new(|| true)));
        let ended = session.request(&services::slave_diag(5));
        assert!(matches!(ended, Err(SessionError::Interrupted)), "{ended:?}");
        session.set_cancellation(None);
        assert_eq!(session.request(&services::slave_diag(5)).unwrap(), Reply::NoAnswer(Failure::Silence));
    }

    /// Another master may have the line by now.
    #[test]
    fn a_master_has_no_token_after_its_port_was_reopened() {
        let (ours, _theirs) = UnixStream::pair().unwrap();
        let lost = Arc::new(AtomicU32::new(0));
        let port = Quiet(ours, Arc::clone(&lost));
        let (baud, timeout) = (Baud::B19200, Duration::from_secs(30));
        let mut session =
            BusSession::new(Box::new(port), baud, bus_parameters(2, baud, Delivery::Unpaced), timeout).unwrap();
        for _ in 0..2 {
            while !session.station().has_token() {
                session.serve(&[], timeout).unwrap();
            }
            lost.fetch_add(1, Ordering::Relaxed);
            session.serve(&[], Duration::ZERO).unwrap();
            assert!(!session.station().has_token());
        }
    }
}
