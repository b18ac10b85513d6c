//! Events: the next one, and its effects.

use super::{SHOWN, Segment, connected};
use crate::character::Character;
use crate::driver::{Driver, DriverAction};
use crate::referee::Transmission;
use crate::rule::{Violated, Violation};
use crate::scheduler::NEVER;
use crate::signal::{Signal, TelegramFault};
use crate::station_id::StationId;
use crate::trace::{Entry, Line};
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Received};
use profivac_wire::Telegram;
use std::sync::Arc;

impl Segment {
    /// Runs the next event. Returns false if there is none until `end`.
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
            self.listen(self.tap_times.earliest_index(), heard, end);
        } else {
            self.run_driver(self.driver_times.earliest_index());
        }
        true
    }

    /// The time of the next event of a driver or fault.
    fn next_other_than_tap(&self) -> BitTime {
        self.next_fault_at().min(self.driver_times.earliest_time())
    }

    fn next_fault_at(&self) -> BitTime {
        self.script.front().map_or(NEVER, |(time, _)| *time)
    }

    /// A tap reads up to `now`, and continues while no other event is due before `end`.
    fn listen(&mut self, index: usize, mut now: BitTime, end: BitTime) {
        self.tap_times.set(index, NEVER);
        loop {
            self.listen_until(index, now);
            now = self.taps[index].next();
            let alone = now < self.next_other_than_tap() && now < self.tap_times.earliest_time();
            if now > end || !alone {
                return self.tap_times.set(index, now);
            }
            self.now = self.now.max(now);
        }
    }

    fn listen_until(&mut self, index: usize, now: BitTime) {
        if let Some((begin, octets)) = self.taps[index].take_telegram()
            && let Some((last, before)) = octets.split_last()
        {
            let mut end = begin + CHARACTER_TBIT;
            for octet in before {
                self.taps[index].receiver.octet(end, *octet);
                end = end + CHARACTER_TBIT;
            }
            self.receive_character(index, end, Character { octet: *last, error: false });
        }
        while !self.taps[index].is_read_until(now) {
            if let Some((end, character)) = self.taps[index].read_next() {
                self.receive_character(index, end, character);
            }
        }
    }

    /// Handles a character at a tap.
    fn receive_character(&mut self, index: usize, end: BitTime, character: Character) {
        let tap = &mut self.taps[index];
        if tap.owner.is_some_and(|owner| end <= self.drivers[owner].sends_until) {
            // The receiver of a station is off while the station sends.
            return;
        }
        if let Some(kept) = &mut tap.kept {
            kept.push((end, character));
        }
        if character.error {
            tap.receiver.character_error(end);
            return self.activity(index, end);
        }
        let Received::Telegram(telegram) = tap.receiver.octet(end, character.octet) else {
            return self.activity(index, end);
        };
        let mut moved = Vec::new();
        let mut give = |driver: usize| {
            moved.extend(self.drivers[driver].telegram(end, &telegram).map(|left| (driver, left)));
            self.driver_times.set(driver, self.drivers[driver].next());
        };
        match tap.owner {
            Some(owner) => give(owner),
            None => tap.listeners.of(&telegram).for_each(give),
        }
        moved.into_iter().for_each(|(driver, left)| self.readdress(driver, left));
    }

    /// Moves a station from its former address `left` to its present one.
    fn readdress(&mut self, driver: usize, left: u8) {
        let Driver { position, address, .. } = self.drivers[driver];
        let shared = self.taps.iter_mut().find(|tap| tap.owner.is_none() && tap.position == position);
        if let (Some(tap), Some(address)) = (shared, address) {
            tap.listeners.leave(driver, left);
            tap.listeners.join(driver, address);
        }
    }

    /// Reports a character that completed no telegram to the station of the tap, if the station receives everything.
    fn activity(&mut self, tap: usize, end: BitTime) {
        if let Some(owner) = self.taps[tap].owner {
            self.drivers[owner].activity(end);
            self.plan(owner);
        }
    }

    /// Runs the action of a driver.
    fn run_driver(&mut self, driver: usize) {
        if let DriverAction::Send(octets) = self.drivers[driver].run(self.now) {
            self.send(driver, octets);
        }
        self.plan(driver);
    }

    /// Reads the state of a station again: the caller may have changed it between two runs.
    pub(super) fn refresh(&mut self, driver: usize) {
        if let Some(left) = self.drivers[driver].changed_address() {
            self.readdress(driver, left);
        }
        self.plan(driver);
    }

    pub(super) fn plan(&mut self, driver: usize) {
        self.driver_times.set(driver, self.drivers[driver].next());
    }

    /// Begins a transmission.
    fn send(&mut self, sender: usize, octets: Arc<[u8]>) {
        let driver = &mut self.drivers[sender];
        let mut faults = std::mem::take(&mut driver.telegram_faults);
        let paused = faults.iter().any(|fault| matches!(fault, TelegramFault::Pause(..)));
        if let Some(octet_errors) = &self.octet_errors {
            octet_errors.draw(self.now, &octets, &mut faults);
        }
        let telegram = Telegram::parse(&octets).ok();
        let signal = match faults.as_slice() {
            [] => Signal::plain(octets.clone(), telegram.is_some()),
            faults => Signal::faulty(&octets, faults),
        };
        let end = self.now + signal.duration_tbit();
        driver.begin_sending(end);
        let transmission =
            Transmission { station: StationId(sender), position: driver.position, begin: self.now, end, paused };
        let disturbed = self.add_to_trace(&signal, end);
        self.check_transmission(transmission, telegram.as_ref(), disturbed);
        self.spread(&signal, Some(sender), transmission.position, 0);
        if let Some(delay) = self.echo {
            self.spread(&signal, None, transmission.position, delay);
        }
    }

    /// Sends a signal to all connected taps.
    fn spread(&mut self, signal: &Signal, sender: Option<usize>, position: u64, delay: u64) {
        for (index, tap) in self.taps.iter_mut().enumerate() {
            let itself = sender.is_some() && tap.owner == sender;
            if !itself && connected(self.cut, position, tap.position) {
                tap.announce(signal.clone(), sender, self.now + delay + position.abs_diff(tap.position));
                self.tap_times.set(index, tap.next());
            }
        }
    }

    /// Adds a telegram to the trace as noise and faults leave it. Returns whether they changed it.
    fn add_to_trace(&mut self, signal: &Signal, end: BitTime) -> bool {
        let flips = self.flips(end);
        let entry = match signal.clean() {
            Some(octets) if flips.is_empty() => Entry::clean(self.now, end, octets.clone()),
            _ => Entry::read(self.now, end, &signal.read(&flips)),
        };
        let changed = !flips.is_empty() || signal.clean().is_none();
        while self.trace.entries.len() >= self.trace_length.max(1) {
            self.trace.entries.pop_front();
        }
        self.trace.entries.push_back(entry);
        changed
    }

    /// The bits from now to `end` that the noise of the line inverts.
    fn flips(&self, end: BitTime) -> Vec<u64> {
        let Some(noise) = &self.noise else { return Vec::new() };
        let next = |from: &BitTime| Some(noise.next(*from + 1));
        let all = std::iter::successors(Some(noise.next(self.now)), next);
        all.take_while(|flip| *flip < end).map(|flip| flip - self.now).collect()
    }

    fn check_transmission(&mut self, transmission: Transmission, telegram: Option<&Telegram<'_>>, disturbed: bool) {
        let side = usize::from(self.cut.is_some_and(|cut| transmission.position >= cut));
        let verdict = self.referees[side].check(transmission, telegram);
        if disturbed || self.noisy {
            self.referees[side].disturb();
        }
        if let Err(Violated { rule, measured_tbit, limit_tbit }) = verdict {
            let (station, at) = (transmission.station, transmission.begin);
            self.violation =
                Some(Box::new(Violation { rule, station, at, measured_tbit, limit_tbit, trace: self.last_lines() }));
        }
    }

    fn last_lines(&self) -> String {
        let entries = &self.trace.entries;
        let skipped = entries.len().saturating_sub(SHOWN);
        let before = |index: usize| index.checked_sub(1).map(|index| entries[index].end());
        (skipped..entries.len()).map(|index| Line(before(index), &entries[index]).to_string()).collect()
    }
}
