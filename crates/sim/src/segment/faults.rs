//! Faults come and go.

use super::{Segment, StationId, connected};
use crate::driver::Driver;
use crate::fault::Fault;
use crate::noise::Noise;
use crate::referee::Referee;
use profivac_dp::link::Receiver;

impl Segment {
    /// The next fault of the script comes.
    pub(super) fn next_fault(&mut self) {
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
            Fault::Telegram(station, tamper) => self.drivers[station.0].telegram_faults.push(tamper),
            Fault::OctetErrors(mangle) => self.octet_errors = mangle,
            Fault::Echo(delay) => self.set_echo(delay),
            Fault::Cut(position) => self.set_cut(position),
        }
    }

    /// Whoever gets power listens anew and may hear less than those beside it.
    fn power(&mut self, station: StationId, on: bool) {
        let StationId(driver) = station;
        if on {
            let place = self.own_tap(driver);
            self.taps[place].receiver = Receiver::new(self.now);
        } else {
            self.taps.iter_mut().for_each(|ear| ear.cut_off(driver, self.now));
        }
        self.drivers[driver].set_power(on);
        self.plan(driver);
        self.reschedule_taps();
        let now = self.now;
        self.referees.iter_mut().for_each(|referee| referee.power_failed(station, now));
    }

    fn set_noise(&mut self, noise: Option<Noise>) {
        self.noise = noise;
        for ear in &mut self.taps {
            ear.set_noise(self.now, self.noise.clone(), ear.own_noise.clone());
        }
        self.reschedule_taps();
    }

    fn set_noise_at(&mut self, StationId(driver): StationId, noise: Option<Noise>) {
        let place = self.own_tap(driver);
        self.taps[place].set_noise(self.now, self.noise.clone(), noise);
        self.reschedule_taps();
    }

    /// From now on a station decodes for itself.
    fn own_tap(&mut self, driver: usize) -> usize {
        let own = self.taps.iter().position(|ear| ear.owner == Some(driver));
        own.unwrap_or_else(|| self.separate_tap(driver))
    }

    /// Gives a station that shares an ear one of its own, which has heard the same so far.
    fn separate_tap(&mut self, driver: usize) -> usize {
        let Driver { position, address, .. } = self.drivers[driver];
        let shared = self.taps.iter_mut().find(|ear| ear.owner.is_none() && ear.position == position);
        if let (Some(shared), Some(address)) = (shared, address) {
            shared.audience.leave(driver, address);
            let mut own = shared.clone();
            own.owner = Some(driver);
            self.taps.push(own);
        }
        self.tap_times.grow(self.taps.len());
        self.taps.len() - 1
    }

    fn set_echo(&mut self, delay: Option<u64>) {
        self.echo = delay;
        self.reschedule_taps();
    }

    fn set_cut(&mut self, position: Option<u64>) {
        for (sender, driver) in self.drivers.iter().enumerate() {
            let lost = self.taps.iter_mut().filter(|ear| !connected(position, driver.position, ear.position));
            lost.for_each(|ear| ear.cut_off(sender, self.now));
        }
        self.reschedule_taps();
        match (self.cut, position) {
            // Both sides know the same so far.
            (None, Some(_)) => self.referees[1] = self.referees[0].clone(),
            (Some(_), _) => self.referees.iter_mut().for_each(Referee::forget),
            (None, None) => {}
        }
        self.cut = position;
    }

    /// Other things are heard than was expected.
    fn reschedule_taps(&mut self) {
        self.noisy = self.noise.is_some() || self.echo.is_some() || self.taps.iter().any(|ear| ear.own_noise.is_some());
        self.taps.iter().enumerate().for_each(|(place, ear)| self.tap_times.set(place, ear.next()));
    }
}
