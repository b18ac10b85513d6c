//! Faults of the segment.

use super::{Segment, connected};
use crate::driver::Driver;
use crate::fault::Fault;
use crate::noise::Noise;
use crate::referee::Referee;
use crate::station_id::StationId;
use crate::tap::Tap;
use profivac_dp::link::Receiver;

impl Segment {
    /// Applies the next fault of the script.
    pub(super) fn next_fault(&mut self) {
        if let Some((_, fault)) = self.script.pop_front() {
            // The taps have not read the telegrams that end now.
            self.announce_everywhere(self.now);
            self.apply(fault);
        }
    }

    /// Applies a fault now.
    ///
    /// # Panics
    /// If its station belongs to another segment; a fault of the script panics when its time comes.
    pub fn inject(&mut self, fault: Fault) {
        self.announce_everywhere(self.now + 1);
        self.apply(fault);
    }

    fn apply(&mut self, fault: Fault) {
        match fault {
            Fault::Power(station, on) => self.power(station, on),
            Fault::Noise(noise) => self.set_noise(noise),
            Fault::NoiseAt(station, noise) => self.set_noise_at(station, noise),
            Fault::Telegram(station, fault) => self.driver(station).telegram_faults.push(fault),
            Fault::OctetErrors(octet_errors) => self.octet_errors = octet_errors,
            Fault::Echo(delay) => self.set_echo(delay),
            Fault::Cut(position) => self.set_cut(position),
        }
    }

    #[expect(
        clippy::panic,
        reason = "a station of another segment is an error of the caller that no value can express"
    )]
    fn driver(&mut self, station: StationId) -> &mut Driver {
        self.drivers.get_mut(station.0).unwrap_or_else(|| panic!("{station} does not belong to this segment"))
    }

    /// Switches the power of a station. After power-up its receiver starts again, so it needs a separate tap.
    fn power(&mut self, station: StationId, on: bool) {
        self.driver(station).set_power(on);
        let StationId(driver) = station;
        if on {
            let index = self.own_tap(driver);
            self.taps[index].receiver = Receiver::new(self.now);
        } else {
            self.taps.iter_mut().for_each(|tap| tap.cut_off(driver, self.now));
        }
        self.plan(driver);
        self.reschedule_taps();
        let now = self.now;
        self.referees.iter_mut().for_each(|referee| referee.power_failed(station, now));
    }

    fn set_noise(&mut self, noise: Option<Noise>) {
        self.noise = noise;
        for tap in &mut self.taps {
            tap.set_noise(self.now, self.noise.clone(), tap.own_noise.clone());
        }
        self.reschedule_taps();
    }

    fn set_noise_at(&mut self, station: StationId, noise: Option<Noise>) {
        self.driver(station);
        let index = self.own_tap(station.0);
        self.taps[index].set_noise(self.now, self.noise.clone(), noise);
        self.reschedule_taps();
    }

    /// The tap of a station alone, separated from a shared one if necessary.
    fn own_tap(&mut self, driver: usize) -> usize {
        let own = self.taps.iter().position(|tap| tap.owner == Some(driver));
        own.unwrap_or_else(|| self.separate_tap(driver))
    }

    /// Gives a station of a shared tap a separate copy.
    fn separate_tap(&mut self, driver: usize) -> usize {
        let new = || Tap::new(self.drivers[driver].position, self.now, self.noise.clone());
        let mut own = self.listeners.leave(driver).map_or_else(new, |shared| self.taps[shared].clone());
        own.owner = Some(driver);
        self.add_tap(own)
    }

    fn set_echo(&mut self, delay: Option<u64>) {
        self.echo = delay;
        self.reschedule_taps();
    }

    fn set_cut(&mut self, position: Option<u64>) {
        for (sender, driver) in self.drivers.iter().enumerate() {
            let lost = self.taps.iter_mut().filter(|tap| !connected(position, driver.position, tap.position));
            lost.for_each(|tap| tap.cut_off(sender, self.now));
        }
        self.reschedule_taps();
        match (self.cut, position) {
            // Both sides have the same history.
            (None, Some(_)) => self.referees[1] = self.referees[0].clone(),
            (Some(_), _) => self.referees.iter_mut().for_each(Referee::forget),
            (None, None) => {}
        }
        self.cut = position;
    }

    /// Recalculates the times of all taps after a change of the signals.
    fn reschedule_taps(&mut self) {
        self.noisy = self.noise.is_some() || self.echo.is_some() || self.taps.iter().any(|tap| tap.own_noise.is_some());
        self.taps.iter().enumerate().for_each(|(index, tap)| self.tap_times.set(index, tap.next()));
    }
}
