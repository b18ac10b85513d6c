//! The model of an adapter as a port in simulated time, with stations at the other end of its line.

use crate::adapter_models::adapter::{Adapter, AdapterModel};
use profivac_dp::link::{Baud, BitTime, Receiver};
use profivac_host::clock::{duration_of, tbit_of};
use profivac_host::line::{Line, Pace, Stations};
use profivac_host::port::{Character, Delivery, Port, PortError};
use profivac_host::readiness::Readiness;
use std::time::Duration;

/// An adapter whose line has stations that keep the rules of the line in bit times.
pub struct ModelPort<C> {
    model: AdapterModel,
    baud: Baud,
    line: Line<C>,
    now: Duration,
    delivered: Vec<Character>,
}

impl<C: Stations> ModelPort<C> {
    pub fn new(adapter: Adapter, baud: Baud, stations: C) -> Self {
        Self {
            model: AdapterModel::new(adapter, baud),
            baud,
            line: Line::new(stations, Receiver::new(BitTime(0)), Pace::ByLine),
            now: Duration::ZERO,
            delivered: Vec::new(),
        }
    }

    fn tbit(&self, time: Duration) -> BitTime {
        BitTime(tbit_of(self.baud, time))
    }

    /// Everything that happens until `self.now`.
    fn step(&mut self) {
        while let Some((end, octet)) = self.model.next_left(self.now) {
            self.line.receive(self.tbit(end), Character::Octet(octet));
        }
        let mut out = Vec::new();
        self.line.advance(self.tbit(self.now), &mut out);
        for octet in out {
            self.model.receive(self.now, octet);
        }
        self.delivered.extend(self.model.deliver(self.now).into_iter().map(Character::Octet));
    }
}

impl<C: Stations + Send> Port for ModelPort<C> {
    fn name(&self) -> &str {
        "model"
    }

    fn delivery(&self) -> Delivery {
        self.model.adapter().delivery
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        Vec::new()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        characters.append(&mut self.delivered);
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        self.model.send(self.now, octets);
        Ok(())
    }

    fn simulated_time(&self) -> Option<Duration> {
        Some(self.now)
    }

    fn simulate(&mut self, at_most: Duration) {
        let end = self.now + at_most;
        while self.delivered.is_empty() && self.now < end {
            let wakes = self.line.wake_at().map(|time| duration_of(self.baud, time.0));
            let leaves = self.model.leaves_at().map(|(next, _)| next);
            let next = [wakes, leaves, self.model.delivers_at()].into_iter().flatten().min().unwrap_or(end);
            self.now = next.clamp(self.now, end);
            self.step();
        }
    }
}
