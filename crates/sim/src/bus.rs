//! The segment: stations on a cable, and the time they share.
//!
//! Time is an integer count of bit times and jumps from event to event: the end of a character somewhere, the moment a
//! station wants to be called or begins to speak, a fault of the script. At equal times faults come first, then what is
//! heard, then what stations do.

use crate::agenda::{Agenda, NEVER};
use crate::character::Character;
use crate::driver::{Doing, Driver};
use crate::ear::Ear;
use crate::fault::{Fault, Mangle};
use crate::noise::Noise;
use crate::referee::{Foul, Limits, Referee, Rule, Speech};
use crate::signal::{Signal, Tamper};
use crate::trace::{Entry, Line, Trace};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Heard, Station};
use profivac_wire::Telegram;
use std::collections::VecDeque;
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

/// How many telegrams a broken rule shows unless the whole run is recorded.
const SHOWN: usize = 16;

/// A station of a bus, whatever its type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id(pub(crate) usize);

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "station #{}", self.0)
    }
}

/// A station of a bus with its type.
#[derive(Debug)]
pub struct Handle<S> {
    id: Id,
    kind: PhantomData<fn() -> S>,
}

impl<S> Handle<S> {
    /// The station, whatever its type.
    #[must_use]
    pub const fn id(self) -> Id {
        self.id
    }
}

impl<S> Clone for Handle<S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for Handle<S> {}

/// A segment.
pub struct Bus {
    baud: Baud,
    now: BitTime,
    drivers: Vec<Driver>,
    /// When each driver has something to do.
    agenda: Agenda,
    ears: Vec<Ear>,
    /// When each ear has something to hear.
    hearing: Agenda,
    script: VecDeque<(BitTime, Fault)>,
    noise: Option<Noise>,
    mangle: Option<Mangle>,
    echo: Option<u64>,
    cut: Option<u64>,
    /// One for each side of a cut. As long as there is none, the first judges alone.
    referees: [Referee; 2],
    foul: Option<Box<Foul>>,
    trace: Trace,
    recorded: usize,
}

impl fmt::Debug for Bus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (baud, now, stations) = (self.baud, self.now, self.drivers.len());
        write!(f, "Bus {{ {baud}, bit time {now}, {stations} stations }}")
    }
}

impl Bus {
    /// A cable without stations at bit time 0.
    #[must_use]
    pub fn new(baud: Baud) -> Self {
        Self {
            baud,
            now: BitTime(0),
            drivers: Vec::new(),
            agenda: Agenda::new(1),
            ears: Vec::new(),
            hearing: Agenda::new(1),
            script: VecDeque::new(),
            noise: None,
            mangle: None,
            echo: None,
            cut: None,
            referees: [Referee::new(Limits::of(baud)), Referee::new(Limits::of(baud))],
            foul: None,
            trace: Trace { baud, entries: VecDeque::new() },
            recorded: SHOWN,
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
    pub fn attach<S: Station + Send + 'static>(&mut self, station: S) -> Handle<S> {
        self.attach_at(0, station)
    }

    /// Connects a station `position` bit times of signal propagation from the beginning of the cable.
    pub fn attach_at<S: Station + Send + 'static>(&mut self, position: u64, station: S) -> Handle<S> {
        let id = self.drivers.len();
        self.drivers.push(Driver::new(Box::new(station), position));
        self.agenda.grow(self.drivers.len());
        let shared = self.ears.iter().position(|ear| ear.owner.is_none() && ear.position == position);
        match (self.drivers[id].address, shared) {
            (Some(address), Some(ear)) => self.ears[ear].audience.join(id, address),
            (Some(address), None) => self.add_ear(position).audience.join(id, address),
            (None, _) => self.add_ear(position).owner = Some(id),
        }
        Handle { id: Id(id), kind: PhantomData }
    }

    fn add_ear(&mut self, position: u64) -> &mut Ear {
        self.hearing.grow(self.ears.len() + 1);
        self.ears.push_mut(Ear::new(position, self.now, self.noise.clone()))
    }

    /// A station.
    ///
    /// # Panics
    /// If the handle comes from another bus.
    #[must_use]
    #[expect(clippy::panic, reason = "a handle of another bus is a fault of the caller that no value can express")]
    pub fn station<S: Station + Send + 'static>(&self, handle: Handle<S>) -> &S {
        let station = self.drivers.get(handle.id.0).and_then(|driver| driver.station.as_any().downcast_ref());
        station.unwrap_or_else(|| panic!("{} is none of this bus", handle.id))
    }

    /// A station, to change what is behind it. What it then wants to do is asked when time goes on.
    ///
    /// # Panics
    /// If the handle comes from another bus.
    #[expect(clippy::panic, reason = "a handle of another bus is a fault of the caller that no value can express")]
    pub fn station_mut<S: Station + Send + 'static>(&mut self, handle: Handle<S>) -> &mut S {
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

    /// The referee lets this station send what and when it likes.
    pub fn exempt(&mut self, station: Id) {
        self.referees.iter_mut().for_each(|referee| referee.exempt(station));
    }

    /// Keeps the last `telegrams` of the run in [`trace`](Self::trace).
    pub const fn record(&mut self, telegrams: usize) {
        self.recorded = telegrams;
    }

    /// What was on the line. Each telegram stands there from its beginning on.
    #[must_use]
    pub const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// A fault at a given time, or now if that has passed.
    pub fn at(&mut self, time: BitTime, fault: Fault) {
        let place = self.script.partition_point(|(other, _)| *other <= time);
        self.script.insert(place, (time, fault));
    }

    /// Lets time pass up to and including `end`.
    ///
    /// # Errors
    /// The first [`Foul`]. The run may go on after it.
    pub fn run_until(&mut self, end: BitTime) -> Result<(), Box<Foul>> {
        (0..self.drivers.len()).for_each(|driver| self.look_at(driver));
        while self.foul.is_none() && self.step(end) {}
        self.foul.take().map_or(Ok(()), Err)
    }

    /// Lets `tbit` bit times pass.
    ///
    /// # Errors
    /// As [`run_until`](Self::run_until).
    pub fn run_for(&mut self, tbit: u64) -> Result<(), Box<Foul>> {
        self.run_until(self.now + tbit)
    }

    /// The next event, if there is one until `end`.
    fn step(&mut self, end: BitTime) -> bool {
        let heard = self.hearing.first();
        let other = self.next_but_hearing();
        if heard.min(other) > end {
            self.now = self.now.max(end);
            return false;
        }
        self.now = self.now.max(heard.min(other));
        if self.next_fault_at() <= self.now {
            self.next_fault();
        } else if heard <= other {
            self.listen(self.hearing.place(), heard, end);
        } else {
            self.act(self.agenda.place());
        }
        true
    }

    /// When the next thing happens that is not heard.
    fn next_but_hearing(&self) -> BitTime {
        self.next_fault_at().min(self.agenda.first())
    }

    fn next_fault_at(&self) -> BitTime {
        self.script.front().map_or(NEVER, |(time, _)| *time)
    }

    /// An ear listens to what ends at `now`, and goes on as long as nothing else happens until `end`.
    fn listen(&mut self, place: usize, mut now: BitTime, end: BitTime) {
        self.hearing.set(place, NEVER);
        loop {
            self.listen_until(place, now);
            now = self.ears[place].next();
            let alone = now < self.next_but_hearing() && now < self.hearing.first();
            if now > end || !alone {
                return self.hearing.set(place, now);
            }
            self.now = self.now.max(now);
        }
    }

    fn listen_until(&mut self, place: usize, now: BitTime) {
        if let Some((begin, octets)) = self.ears[place].take_telegram()
            && let Some((last, before)) = octets.split_last()
        {
            let mut end = begin + CHARACTER_TBIT;
            for octet in before {
                self.ears[place].receiver.octet(end, *octet);
                end = end + CHARACTER_TBIT;
            }
            self.hear(place, end, Character { octet: *last, error: false });
        }
        while !self.ears[place].has_heard(now) {
            if let Some((end, character)) = self.ears[place].hear() {
                self.hear(place, end, character);
            }
        }
    }

    /// A character ended at an ear.
    fn hear(&mut self, place: usize, end: BitTime, character: Character) {
        let ear = &mut self.ears[place];
        if ear.owner.is_some_and(|owner| end <= self.drivers[owner].spoke_until) {
            // The receiver is off while the station sends.
            return;
        }
        if character.error {
            ear.receiver.character_error(end);
            return self.activity(place, end);
        }
        let Heard::Telegram(telegram) = ear.receiver.octet(end, character.octet) else {
            return self.activity(place, end);
        };
        let mut moved = Vec::new();
        let mut give = |driver: usize| {
            moved.extend(self.drivers[driver].telegram(end, &telegram).map(|left| (driver, left)));
            self.agenda.set(driver, self.drivers[driver].next());
        };
        match ear.owner {
            Some(owner) => give(owner),
            None => ear.audience.of(&telegram).for_each(give),
        }
        moved.into_iter().for_each(|(driver, left)| self.readdress(driver, left));
    }

    /// A station that listened to the address `left` has another one.
    fn readdress(&mut self, driver: usize, left: u8) {
        let Driver { position, address, .. } = self.drivers[driver];
        let shared = self.ears.iter_mut().find(|ear| ear.owner.is_none() && ear.position == position);
        if let (Some(ear), Some(address)) = (shared, address) {
            ear.audience.leave(driver, left);
            ear.audience.join(driver, address);
        }
    }

    /// A character that completed nothing: only who listens to everything wants to know.
    fn activity(&mut self, ear: usize, end: BitTime) {
        if let Some(owner) = self.ears[ear].owner {
            self.drivers[owner].activity(end);
            self.plan(owner);
        }
    }

    /// A station does what it wanted to do now.
    fn act(&mut self, driver: usize) {
        if let Doing::Speak(octets) = self.drivers[driver].act(self.now) {
            self.speak(driver, octets);
        }
        self.plan(driver);
    }

    /// Somebody may have changed a station while time stood still.
    fn look_at(&mut self, driver: usize) {
        if let Some(left) = self.drivers[driver].changed_address() {
            self.readdress(driver, left);
        }
        self.plan(driver);
    }

    fn plan(&mut self, driver: usize) {
        self.agenda.set(driver, self.drivers[driver].next());
    }

    /// A telegram begins.
    fn speak(&mut self, sender: usize, octets: Arc<[u8]>) {
        let driver = &mut self.drivers[sender];
        let mut tampers = std::mem::take(&mut driver.tampers);
        let paused = tampers.iter().any(|tamper| matches!(tamper, Tamper::Stutter(..)));
        if let Some(mangle) = &self.mangle {
            mangle.draw(self.now, octets.len(), &mut tampers);
        }
        let telegram = Telegram::parse(&octets).ok();
        let signal = match tampers.as_slice() {
            [] => Signal::plain(octets.clone(), telegram.is_some()),
            tampers => Signal::tampered(&octets, tampers),
        };
        let end = self.now + signal.duration_tbit();
        driver.speaks(end);
        let speech = Speech { station: Id(sender), position: driver.position, begin: self.now, end, paused };
        let disturbed = self.note(&signal, end);
        self.judge(speech, telegram.as_ref(), disturbed);
        self.spread(&signal, Some(sender), speech.position, 0);
        if let Some(delay) = self.echo {
            self.spread(&signal, None, speech.position, delay);
        }
    }

    /// A signal reaches all who are connected.
    fn spread(&mut self, signal: &Signal, sender: Option<usize>, position: u64, delay: u64) {
        for (place, ear) in self.ears.iter_mut().enumerate() {
            let itself = sender.is_some() && ear.owner == sender;
            if !itself && connected(self.cut, position, ear.position) {
                ear.announce(signal.clone(), sender, self.now + delay + position.abs_diff(ear.position));
                self.hearing.set(place, ear.next());
            }
        }
    }

    /// Puts a telegram into the trace as noise and faults leave it. Returns whether they changed it.
    fn note(&mut self, signal: &Signal, end: BitTime) -> bool {
        let flips = self.flips(end);
        let entry = match signal.clean() {
            Some(octets) if flips.is_empty() => Entry::clean(self.now, octets.clone()),
            _ => Entry::read(self.now, &signal.read(&flips)),
        };
        let changed = !flips.is_empty() || signal.clean().is_none();
        while self.trace.entries.len() >= self.recorded.max(1) {
            self.trace.entries.pop_front();
        }
        self.trace.entries.push_back(entry);
        changed
    }

    /// Which of the bits from now to `end` the noise of the line inverts.
    fn flips(&self, end: BitTime) -> Vec<u64> {
        let Some(noise) = &self.noise else { return Vec::new() };
        let next = |from: &BitTime| Some(noise.next(*from + 1));
        let all = std::iter::successors(Some(noise.next(self.now)), next);
        all.take_while(|flip| *flip < end).map(|flip| flip - self.now).collect()
    }

    fn judge(&mut self, speech: Speech, telegram: Option<&Telegram<'_>>, disturbed: bool) {
        let side = usize::from(self.cut.is_some_and(|cut| speech.position >= cut));
        let verdict = self.referees[side].judge(speech, telegram);
        if disturbed || self.noise.is_some() {
            self.referees[side].disturb();
        }
        if let Err((rule, measured_tbit, limit_tbit)) = verdict {
            let (station, at) = (speech.station, speech.begin);
            self.foul = Some(Box::new(Foul { rule, station, at, measured_tbit, limit_tbit, trace: self.last_lines() }));
        }
    }

    fn last_lines(&self) -> String {
        let entries = &self.trace.entries;
        let skipped = entries.len().saturating_sub(SHOWN);
        let before = |place: usize| place.checked_sub(1).map(|place| entries[place].end());
        (skipped..entries.len()).map(|place| Line(before(place), &entries[place]).to_string()).collect()
    }

    fn next_fault(&mut self) {
        if let Some((_, fault)) = self.script.pop_front() {
            self.inject(fault);
        }
    }

    /// A fault, now.
    pub fn inject(&mut self, fault: Fault) {
        match fault {
            Fault::Power(station, on) => self.power(station, on),
            Fault::Noise(noise) => self.set_noise(noise),
            Fault::NoiseAt(station, noise) => self.set_noise_at(station, noise),
            Fault::Tamper(station, tamper) => self.drivers[station.0].tampers.push(tamper),
            Fault::Mangle(mangle) => self.mangle = mangle,
            Fault::Echo(delay) => self.echo = delay,
            Fault::Cut(position) => self.set_cut(position),
        }
    }

    fn power(&mut self, station: Id, on: bool) {
        if !on {
            self.ears.iter_mut().for_each(|ear| ear.cut_off(station.0, self.now));
            self.listen_again();
        }
        self.drivers[station.0].set_power(on);
        self.plan(station.0);
        self.referees.iter_mut().for_each(Referee::power_failed);
    }

    fn set_noise(&mut self, noise: Option<Noise>) {
        self.noise = noise;
        for ear in &mut self.ears {
            ear.set_noise(self.now, self.noise.clone(), ear.own_noise.clone());
        }
        self.listen_again();
    }

    /// The station decodes for itself from now on.
    fn set_noise_at(&mut self, station: Id, noise: Option<Noise>) {
        let Id(driver) = station;
        let own = self.ears.iter().position(|ear| ear.owner == Some(driver));
        let place = own.unwrap_or_else(|| self.part(driver));
        self.ears[place].set_noise(self.now, self.noise.clone(), noise);
        self.listen_again();
    }

    /// Gives a station that shares an ear one of its own, which has heard the same so far.
    fn part(&mut self, driver: usize) -> usize {
        let Driver { position, address, .. } = self.drivers[driver];
        let shared = self.ears.iter_mut().find(|ear| ear.owner.is_none() && ear.position == position);
        if let (Some(shared), Some(address)) = (shared, address) {
            shared.audience.leave(driver, address);
            let mut own = shared.clone();
            own.owner = Some(driver);
            self.ears.push(own);
        }
        self.hearing.grow(self.ears.len());
        self.ears.len() - 1
    }

    fn set_cut(&mut self, position: Option<u64>) {
        for (sender, driver) in self.drivers.iter().enumerate() {
            let lost = self.ears.iter_mut().filter(|ear| !connected(position, driver.position, ear.position));
            lost.for_each(|ear| ear.cut_off(sender, self.now));
        }
        self.listen_again();
        match (self.cut, position) {
            // Both sides know the same so far.
            (None, Some(_)) => self.referees[1] = self.referees[0].clone(),
            (Some(_), _) => self.referees.iter_mut().for_each(Referee::forget),
            (None, None) => {}
        }
        self.cut = position;
    }

    fn listen_again(&mut self) {
        self.ears.iter().enumerate().for_each(|(place, ear)| self.hearing.set(place, ear.next()));
    }
}

/// A cable cut at a position has everything from there on behind the cut.
fn connected(cut: Option<u64>, one: u64, other: u64) -> bool {
    cut.is_none_or(|cut| (one < cut) == (other < cut))
}
