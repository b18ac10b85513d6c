//! The part of [`SimulatedDevice`] that all block devices share.

use super::address::StationAddress;
use super::behaviour::Behaviour;
use super::device::BlockDevice;
use crate::model::{FaultList, MeasuringRange, Part};
use crate::simulation::{Action, Drive, FrontPanel, SimulatedDevice, StateReport, Switch, UnsupportedAction};
use crate::store::{Key, Store};

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
        self.behaviour.measuring_range(part)
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
            self.apply_event(&mut |behaviour| behaviour.advance(seconds));
        }
    }

    fn settle(&mut self) {
        self.apply_event(&mut Behaviour::settle);
    }

    fn set_power(&mut self, on: bool) {
        if on && !self.powered {
            self.start();
        }
        self.powered = on;
    }

    fn refused_values(&self, found: &mut dyn FnMut(Key)) {
        if !StationAddress::is_stored_well(&self.store) {
            found(Key::Address);
        }
        let mut behaviour = self.behaviour.clone();
        behaviour.start();
        Self::restore_values(&mut behaviour, &self.store, found);
    }

    fn faults(&self) -> &'static FaultList {
        self.behaviour.model().faults
    }

    fn front_panel(&self) -> FrontPanel {
        self.behaviour.front_panel()
    }

    fn operate(&mut self, action: Action) -> Result<(), UnsupportedAction> {
        if !self.supports(action) {
            return Err(UnsupportedAction { action });
        }
        if let Action::Switch(Switch::Address(setting)) = action {
            // The device reads the switch at power-up.
            self.address.switch = setting;
        }
        self.apply_event(&mut |behaviour| match action {
            Action::Fault { fault, active } => behaviour.set_fault(fault, active),
            Action::Button(number) => behaviour.press_button(number),
            Action::Switch(switch) => behaviour.set_switch(switch),
            Action::Potentiometer { potentiometer, volts } => behaviour.turn_potentiometer(potentiometer, volts),
        });
        Ok(())
    }

    fn report(&self) -> StateReport {
        let report = self.behaviour.report();
        if self.powered { report } else { report.without_power() }
    }
}

impl<B: Behaviour, S> BlockDevice<B, S> {
    /// Whether the device has the fault or control.
    fn supports(&self, action: Action) -> bool {
        let panel = self.behaviour.front_panel();
        match action {
            Action::Fault { fault, .. } => self.behaviour.model().faults.faults.contains(&fault),
            Action::Button(number) => (1..=panel.buttons).contains(&number),
            Action::Switch(switch) => panel.switches.contains(&switch.name()) && switch.is_valid(),
            Action::Potentiometer { potentiometer, .. } => panel.potentiometers.contains(&potentiometer),
        }
    }
}
