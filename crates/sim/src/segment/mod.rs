//! The segment: stations on a cable with a common time.
//!
//! Time is an integer count of bit times and advances from event to event: the end of a character at a tap, the wake time or
//! start of a transmission of a station, a fault of the script. At equal times faults come first, then taps, then stations.

mod direct;
mod events;
mod faults;

use crate::character::Character;
use crate::driver::Driver;
use crate::fault::{Fault, OctetErrors};
use crate::listeners::{Listener, Listeners};
use crate::noise::Noise;
use crate::referee::{Limits, Referee};
use crate::rule::{Rule, Violation};
use crate::scheduler::Scheduler;
use crate::station_id::{StationHandle, StationId};
use crate::tap::Tap;
use crate::trace::Trace;
use direct::OnLine;
use profivac_dp::link::{Baud, BitTime, Station};
use std::collections::VecDeque;
use std::fmt;

/// The number of telegrams in the trace of a violation.
const SHOWN: usize = 16;

/// A simulated segment.
pub struct Segment {
    baud: Baud,
    now: BitTime,
    drivers: Vec<Driver>,
    /// The time of the next action of each driver.
    driver_times: Scheduler,
    taps: Vec<Tap>,
    /// The time of the next event of each tap.
    tap_times: Scheduler,
    /// The taps of single stations.
    own_taps: Vec<usize>,
    /// The passive stations at shared taps.
    listeners: Listeners,
    /// The position of the last station.
    length_tbit: u64,
    /// The last telegram and those before that are still on the line, as long as telegrams go to their receivers alone.
    /// Empty if all taps get each signal.
    on_line: VecDeque<OnLine>,
    script: VecDeque<(BitTime, Fault)>,
    noise: Option<Noise>,
    /// Whether a station may receive anything else than was sent.
    noisy: bool,
    octet_errors: Option<OctetErrors>,
    echo: Option<u64>,
    cut: Option<u64>,
    /// One for each side of a cut. Without a cut the first checks all stations.
    referees: [Referee; 2],
    violation: Option<Box<Violation>>,
    trace: Trace,
    trace_length: usize,
}

impl fmt::Debug for Segment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (baud, now, stations) = (self.baud, self.now, self.drivers.len());
        write!(f, "Segment {{ {baud}, bit time {now}, {stations} stations }}")
    }
}

impl Segment {
    /// A segment without stations at bit time 0.
    #[must_use]
    pub fn new(baud: Baud) -> Self {
        Self {
            baud,
            now: BitTime(0),
            drivers: Vec::new(),
            driver_times: Scheduler::new(1),
            taps: Vec::new(),
            tap_times: Scheduler::new(1),
            own_taps: Vec::new(),
            listeners: Listeners::default(),
            length_tbit: 0,
            on_line: VecDeque::new(),
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

    /// The baud rate.
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

    /// The characters that a station has received since the last call, also damaged ones and those that noise makes of the idle line, with
    /// the times of their ends. The first call keeps them from then on. Empty for a station that shares its receiver: one that listens to
    /// its own address only.
    pub fn take_characters(&mut self, station: StationId) -> Vec<(BitTime, Character)> {
        let tap = self.taps.iter_mut().find(|tap| tap.owner == Some(station.0));
        tap.and_then(|tap| tap.kept.replace(Vec::new())).unwrap_or_default()
    }

    /// Connects a station `position` bit times of signal propagation from the beginning of the cable.
    pub fn attach_at<S: Station + Send + 'static>(&mut self, position: u64, station: S) -> StationHandle<S> {
        self.announce_everywhere(self.now + 1);
        let id = self.drivers.len();
        self.drivers.push(Driver::new(Box::new(station), position));
        self.length_tbit = self.length_tbit.max(position);
        self.driver_times.grow(self.drivers.len());
        match self.drivers[id].address {
            Some(address) => {
                let shared = self.taps.iter().position(|tap| tap.owner.is_none() && tap.position == position);
                let tap = shared.unwrap_or_else(|| self.add_tap(Tap::new(position, self.now, self.noise.clone())));
                self.listeners.join(Listener { driver: id, tap }, address);
            }
            None => {
                let mut own = Tap::new(position, self.now, self.noise.clone());
                own.owner = Some(id);
                self.add_tap(own);
            }
        }
        StationHandle::new(StationId(id))
    }

    fn add_tap(&mut self, tap: Tap) -> usize {
        let index = self.taps.len();
        self.own_taps.extend(tap.owner.map(|_| index));
        self.taps.push(tap);
        self.tap_times.grow(self.taps.len());
        index
    }

    /// A station.
    ///
    /// # Panics
    /// If the handle belongs to another segment.
    #[must_use]
    #[expect(clippy::panic, reason = "a handle of another segment is an error of the caller that no value can express")]
    pub fn station<S: Station + Send + 'static>(&self, handle: StationHandle<S>) -> &S {
        let station = self.drivers.get(handle.id().0).and_then(|driver| driver.station.as_any().downcast_ref());
        station.unwrap_or_else(|| panic!("{} does not belong to this segment", handle.id()))
    }

    /// A station, to change it. The segment reads its new state at the next run.
    ///
    /// # Panics
    /// If the handle belongs to another segment.
    #[expect(clippy::panic, reason = "a handle of another segment is an error of the caller that no value can express")]
    pub fn station_mut<S: Station + Send + 'static>(&mut self, handle: StationHandle<S>) -> &mut S {
        let station = self.drivers.get_mut(handle.id().0).and_then(|driver| driver.station.as_any_mut().downcast_mut());
        station.unwrap_or_else(|| panic!("{} does not belong to this segment", handle.id()))
    }

    /// Sets the limits of the referee.
    pub fn set_limits(&mut self, limits: Limits) {
        self.referees.iter_mut().for_each(|referee| referee.set_limits(limits));
    }

    /// Ignores violations of a rule.
    pub fn allow(&mut self, rule: Rule) {
        self.referees.iter_mut().for_each(|referee| referee.allow(rule));
    }

    /// Reports violations of a rule again.
    pub fn disallow(&mut self, rule: Rule) {
        self.referees.iter_mut().for_each(|referee| referee.disallow(rule));
    }

    /// Expects the token to go around exactly the stations with these addresses from `from` on. Without addresses any token
    /// is accepted.
    pub fn expect_ring(&mut self, addresses: &[u8], from: BitTime) {
        self.referees.iter_mut().for_each(|referee| referee.expect_ring(addresses, from));
    }

    /// Ignores violations of a station.
    pub fn exempt(&mut self, station: StationId) {
        self.referees.iter_mut().for_each(|referee| referee.exempt(station));
    }

    /// Sets the number of telegrams that [`trace`](Self::trace) keeps.
    pub const fn set_trace_length(&mut self, telegrams: usize) {
        self.trace_length = telegrams;
    }

    /// The last telegrams of the line. A telegram is part of it from its start on.
    #[must_use]
    pub const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// Schedules a fault for `time`, or for now if `time` has passed.
    pub fn schedule_fault(&mut self, time: BitTime, fault: Fault) {
        let index = self.script.partition_point(|(other, _)| *other <= time);
        self.script.insert(index, (time, fault));
    }

    /// Runs up to and including `end`.
    ///
    /// # Errors
    /// The first [`Violation`]. A further call continues the run.
    pub fn run_until(&mut self, end: BitTime) -> Result<(), Box<Violation>> {
        (0..self.drivers.len()).for_each(|driver| self.refresh(driver));
        while self.violation.is_none() && self.step(end) {}
        self.violation.take().map_or(Ok(()), Err)
    }

    /// Runs for `tbit` bit times.
    ///
    /// # Errors
    /// As [`run_until`](Self::run_until).
    pub fn run_for(&mut self, tbit: u64) -> Result<(), Box<Violation>> {
        self.run_until(self.now + tbit)
    }
}

/// Whether two positions are on the same side of a cut.
fn connected(cut: Option<u64>, one: u64, other: u64) -> bool {
    cut.is_none_or(|cut| (one < cut) == (other < cut))
}
