//! What happens next, and what follows from it.

use super::{SHOWN, Segment, StationId, connected};
use crate::character::Character;
use crate::driver::{Driver, DriverAction};
use crate::referee::{Transmission, Violation};
use crate::scheduler::NEVER;
use crate::signal::{Signal, TelegramFault};
use crate::trace::{Entry, Line};
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Received};
use profivac_wire::Telegram;
use std::sync::Arc;

impl Segment {
    /// The next event, if there is one until `end`.
    pub(super) fn step(&mut self, end: BitTime) -> bool {
        let heard = self.tap_times.earliest_time();
        let other = self.next_other_than_tap();
        if heard.min(other) > end {
            self.now = self.now.max(end);
            return false;
        }
        self.now = self.now.max(heard.min(other));
        if self.next_fault_at() <= self.now {
            self.next_fault();
        } else if heard <= other {
            self.listen(self.tap_times.earliest_place(), heard, end);
        } else {
            self.run_driver(self.driver_times.earliest_place());
        }
        true
    }

    /// When the next thing happens that is not heard.
    fn next_other_than_tap(&self) -> BitTime {
        self.next_fault_at().min(self.driver_times.earliest_time())
    }

    fn next_fault_at(&self) -> BitTime {
        self.script.front().map_or(NEVER, |(time, _)| *time)
    }

    /// An ear listens to what ends at `now`, and goes on as long as nothing else happens until `end`.
    fn listen(&mut self, place: usize, mut now: BitTime, end: BitTime) {
        self.tap_times.set(place, NEVER);
        loop {
            self.listen_until(place, now);
            now = self.taps[place].next();
            let alone = now < self.next_other_than_tap() && now < self.tap_times.earliest_time();
            if now > end || !alone {
                return self.tap_times.set(place, now);
            }
            self.now = self.now.max(now);
        }
    }

    fn listen_until(&mut self, place: usize, now: BitTime) {
        if let Some((begin, octets)) = self.taps[place].take_telegram()
            && let Some((last, before)) = octets.split_last()
        {
            let mut end = begin + CHARACTER_TBIT;
            for octet in before {
                self.taps[place].receiver.octet(end, *octet);
                end = end + CHARACTER_TBIT;
            }
            self.receive_character(place, end, Character { octet: *last, error: false });
        }
        while !self.taps[place].has_heard(now) {
            if let Some((end, character)) = self.taps[place].read_next() {
                self.receive_character(place, end, character);
            }
        }
    }

    /// A character ended at an ear.
    fn receive_character(&mut self, place: usize, end: BitTime, character: Character) {
        let ear = &mut self.taps[place];
        if ear.owner.is_some_and(|owner| end <= self.drivers[owner].sends_until) {
            // The receiver is off while the station sends.
            return;
        }
        if character.error {
            ear.receiver.character_error(end);
            return self.activity(place, end);
        }
        let Received::Telegram(telegram) = ear.receiver.octet(end, character.octet) else {
            return self.activity(place, end);
        };
        let mut moved = Vec::new();
        let mut give = |driver: usize| {
            moved.extend(self.drivers[driver].telegram(end, &telegram).map(|left| (driver, left)));
            self.driver_times.set(driver, self.drivers[driver].next());
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
        let shared = self.taps.iter_mut().find(|ear| ear.owner.is_none() && ear.position == position);
        if let (Some(ear), Some(address)) = (shared, address) {
            ear.audience.leave(driver, left);
            ear.audience.join(driver, address);
        }
    }

    /// A character that completed nothing: only who listens to everything wants to know.
    fn activity(&mut self, ear: usize, end: BitTime) {
        if let Some(owner) = self.taps[ear].owner {
            self.drivers[owner].activity(end);
            self.plan(owner);
        }
    }

    /// A station does what it wanted to do now.
    fn run_driver(&mut self, driver: usize) {
        if let DriverAction::Send(octets) = self.drivers[driver].run(self.now) {
            self.send(driver, octets);
        }
        self.plan(driver);
    }

    /// Somebody may have changed a station while time stood still.
    pub(super) fn refresh(&mut self, driver: usize) {
        if let Some(left) = self.drivers[driver].changed_address() {
            self.readdress(driver, left);
        }
        self.plan(driver);
    }

    pub(super) fn plan(&mut self, driver: usize) {
        self.driver_times.set(driver, self.drivers[driver].next());
    }

    /// A telegram begins.
    fn send(&mut self, sender: usize, octets: Arc<[u8]>) {
        let driver = &mut self.drivers[sender];
        let mut tampers = std::mem::take(&mut driver.telegram_faults);
        let paused = tampers.iter().any(|tamper| matches!(tamper, TelegramFault::Pause(..)));
        if let Some(mangle) = &self.octet_errors {
            mangle.draw(self.now, &octets, &mut tampers);
        }
        let telegram = Telegram::parse(&octets).ok();
        let signal = match tampers.as_slice() {
            [] => Signal::plain(octets.clone(), telegram.is_some()),
            tampers => Signal::faulty(&octets, tampers),
        };
        let end = self.now + signal.duration_tbit();
        driver.begin_sending(end);
        let speech =
            Transmission { station: StationId(sender), position: driver.position, begin: self.now, end, paused };
        let disturbed = self.add_to_trace(&signal, end);
        self.check_transmission(speech, telegram.as_ref(), disturbed);
        self.spread(&signal, Some(sender), speech.position, 0);
        if let Some(delay) = self.echo {
            self.spread(&signal, None, speech.position, delay);
        }
    }

    /// A signal reaches all who are connected.
    fn spread(&mut self, signal: &Signal, sender: Option<usize>, position: u64, delay: u64) {
        for (place, ear) in self.taps.iter_mut().enumerate() {
            let itself = sender.is_some() && ear.owner == sender;
            if !itself && connected(self.cut, position, ear.position) {
                ear.announce(signal.clone(), sender, self.now + delay + position.abs_diff(ear.position));
                self.tap_times.set(place, ear.next());
            }
        }
    }

    /// Puts a telegram into the trace as noise and faults leave it. Returns whether they changed it.
    fn add_to_trace(&mut self, signal: &Signal, end: BitTime) -> bool {
        let flips = self.flips(end);
        let entry = match signal.clean() {
            Some(octets) if flips.is_empty() => Entry::clean(self.now, octets.clone()),
            _ => Entry::read(self.now, &signal.read(&flips)),
        };
        let changed = !flips.is_empty() || signal.clean().is_none();
        while self.trace.entries.len() >= self.trace_length.max(1) {
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

    fn check_transmission(&mut self, speech: Transmission, telegram: Option<&Telegram<'_>>, disturbed: bool) {
        let side = usize::from(self.cut.is_some_and(|cut| speech.position >= cut));
        let verdict = self.referees[side].check(speech, telegram);
        if disturbed || self.noisy {
            self.referees[side].disturb();
        }
        if let Err((rule, measured_tbit, limit_tbit)) = verdict {
            let (station, at) = (speech.station, speech.begin);
            self.violation =
                Some(Box::new(Violation { rule, station, at, measured_tbit, limit_tbit, trace: self.last_lines() }));
        }
    }

    fn last_lines(&self) -> String {
        let entries = &self.trace.entries;
        let skipped = entries.len().saturating_sub(SHOWN);
        let before = |place: usize| place.checked_sub(1).map(|place| entries[place].end());
        (skipped..entries.len()).map(|place| Line(before(place), &entries[place]).to_string()).collect()
    }
}
