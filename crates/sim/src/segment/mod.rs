//! The segment: stations on a cable, and the time they share.
//!
//! Time is an integer count of bit times and jumps from event to event: the end of a character somewhere, the moment a
//! station wants to be called or begins to speak, a fault of the script. At equal times faults come first, then what is
//! heard, then what stations do.

mod events;
mod faults;

use crate::driver::Driver;
use crate::fault::{Fault, OctetErrors};
use crate::noise::Noise;
use crate::referee::{Limits, Referee, Rule, Violation};
use crate::scheduler::Scheduler;
use crate::tap::Tap;
use crate::trace::Trace;
use profivac_dp::link::{Baud, BitTime, Station};
use std::collections::VecDeque;
use std::fmt;
use std::marker::PhantomData;

/// How many telegrams a broken rule shows unless the whole run is recorded.
const SHOWN: usize = 16;

/// A station of a bus, whatever its type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StationId(pub(crate) usize);

impl fmt::Display for StationId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "station #{}", self.0)
    }
}

/// A station of a bus with its type.
#[derive(Debug)]
pub struct StationHandle<S> {
    id: StationId,
    kind: PhantomData<fn() -> S>,
}

impl<S> StationHandle<S> {
    /// The station, whatever its type.
    #[must_use]
    pub const fn id(self) -> StationId {
        self.id
    }
}

impl<S> Clone for StationHandle<S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for StationHandle<S> {}

/// A segment.
pub struct Segment {
    baud: Baud,
    now: BitTime,
    drivers: Vec<Driver>,
    /// When each driver has something to do.
    driver_times: Scheduler,
    taps: Vec<Tap>,
    /// When each ear has something to hear.
    tap_times: Scheduler,
    script: VecDeque<(BitTime, Fault)>,
    noise: Option<Noise>,
    /// Somebody may hear what was not sent.
    noisy: bool,
    octet_errors: Option<OctetErrors>,
    echo: Option<u64>,
    cut: Option<u64>,
    /// One for each side of a cut. As long as there is none, the first judges alone.
    referees: [Referee; 2],
    violation: Option<Box<Violation>>,
    trace: Trace,
    trace_length: usize,
}

impl fmt::Debug for Segment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (baud, now, stations) = (self.baud, self.now, self.drivers.len());
        write!(f, "Bus {{ {baud}, bit time {now}, {stations} stations }}")
    }
}

impl Segment {
    /// A cable without stations at bit time 0.
    #[must_use]
    pub fn new(baud: Baud) -> Self {
        Self {
            baud,
            now: BitTime(0),
            drivers: Vec::new(),
            driver_times: Scheduler::new(1),
            taps: Vec::new(),
            tap_times: Scheduler::new(1),
            script: VecDeque::new(),
            noise: None,
            noisy: false,
            octet_errors: None,
            echo: None,
            cut: None,
            referees: [Referee::new(Limits::of(baud)), Referee::new(Limits::of(baud))],
            violation: None,
            trace: Trace { baud, entries: VecDeque::new() },
            trace_length: SHOWN,
        }
    }

    /// The transmission rate.
    #[must_use]
    pub const fn baud(&self) -> Baud {
        self.baud
    }

    /// The present bit time.
    #[must_use]
    pub const fn now(&self) -> BitTime {
        self.now
    }

    /// Connects a station at the beginning of the cable.
    pub fn attach<S: Station + Send + 'static>(&mut self, station: S) -> StationHandle<S> {
        self.attach_at(0, station)
    }

    /// Connects a station `position` bit times of signal propagation from the beginning of the cable.
    pub fn attach_at<S: Station + Send + 'static>(&mut self, position: u64, station: S) -> StationHandle<S> {
        let id = self.drivers.len();
        self.drivers.push(Driver::new(Box::new(station), position));
        self.driver_times.grow(self.drivers.len());
        let shared = self.taps.iter().position(|ear| ear.owner.is_none() && ear.position == position);
        match (self.drivers[id].address, shared) {
            (Some(address), Some(ear)) => self.taps[ear].audience.join(id, address),
            (Some(address), None) => self.add_tap(position).audience.join(id, address),
            (None, _) => self.add_tap(position).owner = Some(id),
        }
        StationHandle { id: StationId(id), kind: PhantomData }
    }

    fn add_tap(&mut self, position: u64) -> &mut Tap {
        self.tap_times.grow(self.taps.len() + 1);
        self.taps.push_mut(Tap::new(position, self.now, self.noise.clone()))
    }

    /// A station.
    ///
    /// # Panics
    /// If the handle comes from another bus.
    #[must_use]
    #[expect(clippy::panic, reason = "a handle of another bus is a fault of the caller that no value can express")]
    pub fn station<S: Station + Send + 'static>(&self, handle: StationHandle<S>) -> &S {
        let station = self.drivers.get(handle.id.0).and_then(|driver| driver.station.as_any().downcast_ref());
        station.unwrap_or_else(|| panic!("{} is none of this bus", handle.id))
    }

    /// A station, to change what is behind it. What it then wants to do is asked when time goes on.
    ///
    /// # Panics
    /// If the handle comes from another bus.
    #[expect(clippy::panic, reason = "a handle of another bus is a fault of the caller that no value can express")]
    pub fn station_mut<S: Station + Send + 'static>(&mut self, handle: StationHandle<S>) -> &mut S {
        let station = self.drivers.get_mut(handle.id.0).and_then(|driver| driver.station.as_any_mut().downcast_mut());
        station.unwrap_or_else(|| panic!("{} is none of this bus", handle.id))
    }

    /// What the referee judges by.
    pub fn set_limits(&mut self, limits: Limits) {
        self.referees.iter_mut().for_each(|referee| referee.set_limits(limits));
    }

    /// The referee does not stop the run for this rule any more.
    pub fn allow(&mut self, rule: Rule) {
        self.referees.iter_mut().for_each(|referee| referee.allow(rule));
    }

    /// The referee stops the run for this rule again.
    pub fn disallow(&mut self, rule: Rule) {
        self.referees.iter_mut().for_each(|referee| referee.disallow(rule));
    }

    /// From `from` on the referee wants the token to go around the stations with these addresses, and around no others. With
    /// no address it may go where it likes.
    pub fn expect_ring(&mut self, addresses: &[u8], from: BitTime) {
        self.referees.iter_mut().for_each(|referee| referee.expect_ring(addresses, from));
    }

    /// The referee lets this station send what and when it likes.
    pub fn exempt(&mut self, station: StationId) {
        self.referees.iter_mut().for_each(|referee| referee.exempt(station));
    }

    /// Keeps the last `telegrams` of the run in [`trace`](Self::trace).
    pub const fn set_trace_length(&mut self, telegrams: usize) {
        self.trace_length = telegrams;
    }

    /// What was on the line. Each telegram stands there from its beginning on.
    #[must_use]
    pub const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// A fault at a given time, or now if that has passed.
    pub fn schedule_fault(&mut self, time: BitTime, fault: Fault) {
        let place = self.script.partition_point(|(other, _)| *other <= time);
        self.script.insert(place, (time, fault));
    }

    /// Lets time pass up to and including `end`.
    ///
    /// # Errors
    /// The first [`Foul`]. The run may go on after it.
    pub fn run_until(&mut self, end: BitTime) -> Result<(), Box<Violation>> {
        (0..self.drivers.len()).for_each(|driver| self.refresh(driver));
        while self.violation.is_none() && self.step(end) {}
        self.violation.take().map_or(Ok(()), Err)
    }

    /// Lets `tbit` bit times pass.
    ///
    /// # Errors
    /// As [`run_until`](Self::run_until).
    pub fn run_for(&mut self, tbit: u64) -> Result<(), Box<Violation>> {
        self.run_until(self.now + tbit)
    }
}

/// A cable cut at a position has everything from there on behind the cut.
fn connected(cut: Option<u64>, one: u64, other: u64) -> bool {
    cut.is_none_or(|cut| (one < cut) == (other < cut))
}
