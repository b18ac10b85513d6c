//! Events: the next one, and its effects.

use super::direct::OnLine;
use super::{SHOWN, Segment, connected};
use crate::character::Character;
use crate::driver::DriverAction;
use crate::listeners::Listener;
use crate::referee::Transmission;
use crate::rule::{Violated, Violation};
use crate::scheduler::NEVER;
use crate::signal::{Signal, TelegramFault};
use crate::station_id::StationId;
use crate::trace::{Entry, Line};
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Received};
use profivac_wire::Telegram;
use std::sync::Arc;

/// What a tap reads at once.
#[derive(Clone, Copy, Debug)]
enum Piece<'a> {
    Character(Character),
    /// A whole undisturbed telegram, with the end of its first character.
    Telegram(BitTime, &'a [u8]),
}

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
        if let Some((begin, octets)) = self.taps[index].take_telegram() {
            let end = begin + octets.len() as u64 * CHARACTER_TBIT;
            self.receive(index, end, Piece::Telegram(begin + CHARACTER_TBIT, &octets));
        }
        while !self.taps[index].is_read_until(now) {
            if let Some((end, character)) = self.taps[index].read_next() {
                self.receive(index, end, Piece::Character(character));
            }
        }
    }

    /// Handles characters at a tap, the last of which ended at `end`.
    fn receive(&mut self, index: usize, end: BitTime, piece: Piece<'_>) {
        let tap = &mut self.taps[index];
        if tap.owner.is_some_and(|owner| end <= self.drivers[owner].sends_until) {
            // The receiver of a station is off while the station sends.
            return;
        }
        if let (Some(kept), Piece::Character(character)) = (&mut tap.kept, piece) {
            kept.push((end, character));
        }
        let received = match piece {
            Piece::Character(Character { octet, error: false }) => tap.receiver.octet(end, octet),
            Piece::Character(Character { error: true, .. }) => {
                tap.receiver.character_error(end);
                Received::Nothing
            }
            Piece::Telegram(first, octets) => tap.receiver.octets(first, octets).1,
        };
        let Received::Telegram(telegram) = received else { return self.activity(index, end) };
        let mut moved = Vec::new();
        let mut give = |driver: usize| {
            moved.extend(self.drivers[driver].telegram(end, &telegram).then_some(driver));
            self.driver_times.set(driver, self.drivers[driver].next());
        };
        match tap.owner {
            Some(owner) => give(owner),
            None => {
                let here = self.listeners.of(&telegram).filter(|listener| listener.tap == index);
                here.for_each(|listener| give(listener.driver));
            }
        }
        moved.into_iter().for_each(|driver| self.readdress(driver));
    }

    /// Moves a station to its present address.
    fn readdress(&mut self, driver: usize) {
        self.announce_everywhere(self.now + 1);
        if let Some(address) = self.drivers[driver].address
            && let Some(tap) = self.listeners.leave(driver)
        {
            self.listeners.join(Listener { driver, tap }, address);
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
        if self.drivers[driver].changed_address() {
            self.readdress(driver);
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
        let on_line = OnLine { signal, sender, position: transmission.position, begin: self.now, end };
        match telegram.filter(|_| self.reaches_all_undisturbed(&on_line)) {
            Some(telegram) => self.announce_to_receivers(on_line, &telegram),
            None => self.announce_to_all(&on_line),
        }
    }

    /// Announces a signal, and its echo, to all taps.
    fn announce_to_all(&mut self, on_line: &OnLine) {
        self.announce_everywhere(self.now + 1);
        let OnLine { signal, sender, position, .. } = on_line;
        self.spread(signal, Some(*sender), *position, 0);
        if let Some(delay) = self.echo {
            self.spread(signal, None, *position, delay);
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
