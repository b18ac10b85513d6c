//! A block device on the bench: what all of them share of [`Instrument`].

use super::behaviour::Behaviour;
use super::device::BlockDevice;
use crate::simulation::{Action, Drive, MeasuringRange, Part, SimulatedDevice, StateReport, UnsupportedAction};
use crate::store::Store;

impl<B: Behaviour, S: Store> SimulatedDevice for BlockDevice<B, S> {
    fn name(&self) -> &'static str {
        self.behaviour.model().name
    }

    fn station_address(&self) -> u8 {
        self.address.get()
    }

    fn parts(&self) -> &[Part] {
        self.behaviour.parts()
    }

    fn measuring_range(&self, part: usize) -> MeasuringRange {
        self.behaviour.span(part)
    }

    fn drive(&self, part: usize) -> Drive {
        if self.powered { self.behaviour.drive(part) } else { Drive::Off }
    }

    fn sense(&mut self, part: usize, pa: f64) {
        self.behaviour.sense(part, if pa.is_nan() { 0.0 } else { pa });
        self.behaviour.update();
    }

    fn advance(&mut self, seconds: f64) {
        if self.powered && seconds > 0.0 {
            self.happen(|behaviour| behaviour.advance(seconds));
        }
    }

    fn settle(&mut self) {
        self.happen(Behaviour::settle);
    }

    fn set_power(&mut self, on: bool) {
        if on && !self.powered {
            self.start();
        }
        self.powered = on;
    }

    fn faults(&self) -> &'static [&'static str] {
        self.behaviour.model().faults.names
    }

    fn operate(&mut self, action: Action<'_>) -> Result<(), UnsupportedAction> {
        if let Action::Switch { name: "address", value } = action {
            self.address.switch = value.parse().map_err(|_| UnsupportedAction { expected: &["0 ... 255"] })?;
            self.behaviour.address_switch(self.address.switch);
            return Ok(());
        }
        let before = self.behaviour.clone();
        self.behaviour.operate(action)?;
        self.behaviour.update();
        let _ = self.store_differences(&before, None);
        Ok(())
    }

    fn report(&self) -> StateReport {
        let report = self.behaviour.report();
        if self.powered { report } else { report.without_power() }
    }
}
