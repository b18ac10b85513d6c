//! A master on a port that sends one request after the other. Commands use it, and clients before they exchange data.
//!
//! The session itself never sends Set_Prm. It serves slaves that were added to the [`master`](BusSession::master) while it
//! waits for an answer.

#[cfg(test)]
mod hostile;
mod kept;
mod parameters;
mod readers;
mod reply;
mod slot_time;
mod station;
mod unrestored;

pub use parameters::{MAX_SLOT_TBIT, bus_parameters, entry_time};
pub use reply::{Reply, SessionError};
pub use slot_time::SessionTiming;
pub use station::{BusMaster, add_or_restart};
pub use unrestored::UnrestoredRecord;

use crate::clock::{duration_of, tbit_of};
use crate::port::{Notice, Opener, Port, PortError};
use crate::readiness::Readiness;
use crate::segment::Segment;
use kept::KeptConnection;
use profivac_dp::link::active::{
    Active, Answer, BusParameters, Confirmation, Failure, Request, RingCounters, RingState,
};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{Busy, Handle, Operation};
use profivac_wire::control::StationType;
use readers::OtherReaders;
use station::BoxedStation;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// The longest wait for passing the token at the end. chosen: some rotations of a small ring.
const TOKEN_PASS_TIMEOUT: Duration = Duration::from_secs(1);

/// The longest time that guards restore after a cancellation, whatever the timeout of the session. chosen: the time that a command waits
/// for the line unless the user says otherwise.
const MAX_RESTORING: Duration = Duration::from_secs(5);

/// The shortest wait for the line.
const MIN_WAIT: Duration = Duration::from_millis(1);

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
    /// When a wait has first seen the cancellation.
    cancelled_at: Option<BitTime>,
    /// A guard restores what the program has changed.
    is_restoring: bool,
    unrestored: BTreeMap<u8, UnrestoredRecord>,
    /// By address.
    kept: BTreeMap<u8, KeptConnection>,
    /// Whether a measured turnaround may raise the slot time.
    adapts_slot_time: bool,
    /// The longest turnaround that a notice has reported, in bit times.
    reported_tbit: u64,
    /// A late answer that no notice has reported.
    late_answer: Option<Notice>,
    other_readers: OtherReaders,
    closing: Option<Closing>,
}

/// Runs when the session ends.
type Closing = Box<dyn FnOnce(&SessionTiming, Vec<Notice>) + Send>;

/// Runs each time the line was served, with the time of the line.
type BackgroundTask = Box<dyn FnMut(&mut BusMaster, BitTime) + Send>;

/// Whether the program wants to end.
type Cancellation = Box<dyn Fn() -> bool + Send>;

/// The longest wait for the line while a background task or a cancellation exists.
const MAX_WAIT: Duration = Duration::from_millis(20);

impl Drop for BusSession {
    /// Passes the token on first if other masters are in the ring. If the holder vanished with the token, the ring would
    /// stand still until another master replaces the token.
    fn drop(&mut self) {
        self.close();
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
            cancelled_at: None,
            is_restoring: false,
            unrestored: BTreeMap::new(),
            kept: BTreeMap::new(),
            adapts_slot_time: true,
            reported_tbit: 0,
            late_answer: None,
            other_readers: OtherReaders::default(),
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

    /// Ends the session, and returns its port for another one: a serial device that takes no octets is not opened again for 30 s after it
    /// was closed.
    #[must_use]
    pub fn into_port(mut self) -> Box<dyn Port> {
        self.close();
        self.segment.take_port()
    }

    fn close(&mut self) {
        self.pass_token_on();
        let timing = self.timing();
        if let Some(closing) = self.closing.take() {
            self.other_readers.search(self.losses(), self.segment.port());
            closing(&timing, std::iter::from_fn(|| self.next_notice()).collect());
        }
    }

    /// Runs `work` with the time of the line each time the line was served while a request waits, so that requests do not delay the
    /// evaluation of cyclic data.
    pub fn set_background_task(&mut self, work: impl FnMut(&mut BusMaster, BitTime) + Send + 'static) {
        self.background = Some(Box::new(work));
    }

    /// Ends each wait with [`SessionError::Interrupted`] within 20 ms after `is_cancelled` returns true. `None` waits as before.
    pub fn set_cancellation(&mut self, is_cancelled: Option<Box<dyn Fn() -> bool + Send>>) {
        self.cancellation = is_cancelled;
        self.cancelled_at = None;
    }

    /// Whether the program ends. While a guard restores, only after the timeout of the session, or after 5 s if that is longer.
    pub fn is_cancelled(&mut self) -> bool {
        if !self.cancellation.as_ref().is_some_and(|is_cancelled| is_cancelled()) {
            self.cancelled_at = None;
            return false;
        }
        let now = self.segment.now();
        let since = *self.cancelled_at.get_or_insert(now);
        !self.is_restoring || self.has_passed(self.timeout.min(MAX_RESTORING), since)
    }

    /// While this is true, the guards of a client restore what they have changed although the program ends. Waits end by cancellation
    /// only when the [`timeout`](Self::timeout), and 5 s at most, has passed since the cancellation was seen, for all guards together: so a
    /// program on a dead line ends too.
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

    /// Serves the line for this time.
    ///
    /// # Errors
    /// [`SessionError::Port`]; [`SessionError::Interrupted`] at a cancellation.
    pub fn pause(&mut self, time: Duration) -> Result<(), SessionError> {
        let end = self.segment.now() + tbit_of(self.baud, time);
        loop {
            let now = self.segment.now();
            if end <= now {
                return Ok(());
            }
            self.serve_once(duration_of(self.baud, end - now).clamp(MIN_WAIT, MAX_WAIT))?;
        }
    }

    /// The time of the line, for limits of a wait.
    pub fn now(&self) -> BitTime {
        self.segment.now()
    }

    /// Whether this time of the line has passed since `begun`.
    pub fn has_passed(&self, time: Duration, begun: BitTime) -> bool {
        self.segment.now() - begun >= tbit_of(self.baud, time)
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
        self.other_readers.poll(self.losses(), self.segment.port());
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

    /// The requests without an answer and the damaged telegrams so far.
    fn losses(&self) -> u64 {
        self.segment.measured().missing.saturating_add(self.damaged_telegrams().into())
    }

    /// Takes the oldest notice of the port.
    pub fn next_notice(&mut self) -> Option<Notice> {
        let of_session = self.late_answer.take().or_else(|| self.other_readers.next_notice());
        of_session.or_else(|| self.segment.next_notice())
    }

    /// Sends a request and waits for the reply. A request that the loss of the token interrupted is sent again: the station
    /// may have got it before.
    ///
    /// # Errors
    /// [`SessionError`] when the master does not get the line.
    pub fn request(&mut self, request: &Request<'_>) -> Result<Reply, SessionError> {
        let begun = Instant::now();
        loop {
            // The master is busy with a request that was given up; its result comes first.
            while let Err(Busy) = self.master().submit_request(request) {
                self.wait(begun)?;
                self.master().take_confirmation();
            }
            let reply = self.reply(begun)?;
            if reply != Reply::NoAnswer(Failure::Interrupted) {
                return Ok(reply);
            }
        }
    }

    /// Waits for the reply to the submitted request.
    fn reply(&mut self, begun: Instant) -> Result<Reply, SessionError> {
        loop {
            self.wait(begun)?;
            let Some(confirmation) = self.master().take_confirmation() else { continue };
            return Ok(match confirmation {
                Confirmation::Answer(Answer { station, status, du, .. }) => {
                    Reply::Answer { station, status, du: du.to_vec() }
                }
                Confirmation::Sent => Reply::NoAnswer(Failure::Silence),
                Confirmation::Failed(failure) => Reply::NoAnswer(failure),
            });
        }
    }

    /// Serves the line once for a request that has been waiting since `begun`.
    fn wait(&mut self, begun: Instant) -> Result<(), SessionError> {
        let left = self.line_timeout.saturating_sub(begun.elapsed());
        // A request that takes longer than the timeout has its own limit; meanwhile the line is served without a busy loop.
        let longest = if self.background.is_some() || self.cancellation.is_some() { MAX_WAIT } else { left };
        self.serve_once(left.min(longest).max(MIN_WAIT))?;
        let station = self.station();
        if !left.is_zero() || station.has_token() {
            return Ok(());
        }
        Err(match (station.ring_state(), station.other_master()) {
            (RingState::AddressTaken, _) => SessionError::AddressInUse(station.bus().address),
            (_, Some(master)) => SessionError::LineInUse(master),
            (_, None) => SessionError::NeverIdle,
        })
    }

    /// Serves the line once while something waits.
    fn serve_once(&mut self, at_most: Duration) -> Result<(), SessionError> {
        self.serve(&[], at_most)?;
        if self.is_cancelled() {
            return Err(SessionError::Interrupted);
        }
        let now = self.segment.now();
        let [BoxedStation(station)] = self.segment.stations_mut();
        if let Some(work) = &mut self.background {
            work(&mut station.user, now);
        }
        Ok(())
    }

    fn station(&mut self) -> &mut Active<BusMaster> {
        let [station] = self.segment.stations_mut();
        &mut station.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::{Character, Delivery, ReaderSearch};
    use profivac_dp::master::{Settings, services};
    use profivac_sim::Segment;
    use std::os::unix::net::UnixStream;
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::sync::{Arc, Mutex};

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

    /// A port without answers whose octets another program reads. The number counts the searches for it.
    struct Shared(Quiet, Arc<AtomicU32>);

    impl Port for Shared {
        fn name(&self) -> &str {
            self.0.name()
        }

        fn readiness(&self) -> Vec<Readiness<'_>> {
            self.0.readiness()
        }

        fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
            self.0.receive(heard)
        }

        fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
            self.0.send(octets)
        }

        fn reader_search(&self) -> Option<ReaderSearch> {
            self.1.fetch_add(1, Ordering::Relaxed);
            let (name, program) = (self.name().to_owned(), "cat".to_owned());
            Some(Box::new(move || vec![Notice::OpenElsewhere { name, program, pid: 7 }]))
        }
    }

    /// A session on [`Shared`], the notices of its end, and the number of searches. The socket keeps the port open.
    fn shared() -> (BusSession, Arc<Mutex<Vec<Notice>>>, Arc<AtomicU32>, UnixStream) {
        let (ours, theirs) = UnixStream::pair().unwrap();
        let (closing, searches) = (Arc::new(Mutex::new(Vec::new())), Arc::new(AtomicU32::new(0)));
        let port = Shared(Quiet(ours, Arc::default()), Arc::clone(&searches));
        let baud = Baud::B500000;
        let bus = bus_parameters(2, baud, Delivery::Unpaced);
        let mut session = BusSession::new(Box::new(port), baud, bus, Duration::from_secs(3600)).unwrap();
        let told = Arc::clone(&closing);
        session.on_close(move |_, notices| told.lock().unwrap().extend(notices));
        (session, closing, searches, theirs)
    }

    fn is_cat(notice: &Notice) -> bool {
        matches!(notice, Notice::OpenElsewhere { program, pid: 7, .. } if program == "cat")
    }

    #[test]
    fn a_program_that_takes_answers_away_is_named_while_the_session_runs_and_once() {
        let (mut session, closing, _, _line) = shared();
        let named = (0..10_000).find_map(|_| {
            session.request(&services::slave_diag(5)).unwrap();
            session.next_notice()
        });
        assert!(named.as_ref().is_some_and(is_cat), "{named:?}");
        session.request(&services::slave_diag(5)).unwrap();
        drop(session);
        assert_eq!(*closing.lock().unwrap(), []);
    }

    #[test]
    fn a_program_that_takes_answers_away_is_named_at_the_end_of_the_session() {
        let (mut session, closing, _, _line) = shared();
        session.request(&services::slave_diag(5)).unwrap();
        drop(session);
        let closing = closing.lock().unwrap();
        assert!(closing.len() == 1 && closing.iter().all(is_cat), "{closing:?}");
    }

    #[test]
    fn a_session_without_missing_answers_searches_for_no_other_program() {
        let (mut session, closing, searches, _line) = shared();
        session.serve(&[], Duration::ZERO).unwrap();
        drop(session);
        assert_eq!((searches.load(Ordering::Relaxed), closing.lock().unwrap().len()), (0, 0));
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
