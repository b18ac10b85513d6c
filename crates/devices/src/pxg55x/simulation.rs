//! Cyclic data, sensors and front panel of the series. Numbers in brackets are those of errata-pxg55x-img400.

use super::trip::TripPoint;
use super::{Pxg55xBehaviour, parts, table, ttr};
use crate::model::{Configuration, Fault, Field, MeasuringRange, Model, Octets, Part, Principle, UserPrm};
use crate::profile::{Behaviour, DeviceBlockValues, Presentation};
use crate::simulation::{Drive, FrontPanel, StateReport, Switch, SwitchName};
use profivac_wire::acyclic::Im0;
use profivac_wire::acyclic::call::IM_RECORD_LENGTH;

impl Behaviour for Pxg55xBehaviour {
    fn model(&self) -> &'static Model {
        self.presentation.model
    }

    fn presentation_mut(&mut self) -> Option<&mut Presentation> {
        Some(&mut self.presentation)
    }

    /// The string without a unit selects TTR compatibility mode; unit and data type keep their values then (49).
    fn apply_user_prm(&mut self, prm: &'static UserPrm) {
        let unit = self.presentation.model.unit(prm.unit_code());
        self.ttr = unit.is_none();
        self.presentation.unit = unit.unwrap_or(self.presentation.unit);
    }

    /// TTR compatibility mode allows only telegram 205 (49).
    fn accepts(&self, configuration: &'static Configuration) -> bool {
        configuration.is_ttr() == self.ttr
    }

    fn set_exchanging(&mut self, running: bool) {
        self.machine.set_exchanging(running);
    }

    /// The octets of telegram 206 are not processed (4.4.1).
    fn output(&mut self, _field: Field, _octets: &[u8]) {}

    fn input(&self, field: Field) -> Octets {
        let [trip_1, trip_2] = self.trips.each_ref().map(|trip| u8::from(trip.status()));
        match field {
            Field::ExceptionStatus => Octets::new(&[self.exception_status().bits()]),
            Field::StatusExtension => Octets::new(&[self.one_of_n().bits()]),
            Field::PvSelector => Octets::new(&[self.active().part().instance]),
            Field::ProcessValue(_) => self.presentation.format(parts::COUNTS).encode(self.output_pa()),
            // One octet each (103).
            Field::TripRelays(_) => Octets::new(&[trip_1, trip_2]),
            Field::TtrValue => Octets::new(&ttr::octets(self.has_error(), trip_1 != 0, self.output_pa())),
            // In none of its telegrams.
            _ => Octets::EMPTY,
        }
    }

    /// ORDER_ID is the part number; a serial number that is longer than the field is cut.
    fn im0(&self) -> Option<[u8; IM_RECORD_LENGTH]> {
        let serial = self.serial.as_slice();
        let serial_number = serial.get(..16).unwrap_or(serial);
        let im0 = Im0 { order_id: self.variant.number.as_bytes(), serial_number, ..table::IM0 };
        let mut record = [0; IM_RECORD_LENGTH];
        im0.emit(&mut record).ok().map(|_| record)
    }

    fn start(&mut self) {
        *self = self.as_new();
    }

    fn update(&mut self) {
        self.update_all();
    }

    fn parts(&self) -> &[Part] {
        self.variant.family.parts
    }

    fn measuring_range(&self, part: usize) -> MeasuringRange {
        self.measuring_parts().nth(part).unwrap_or(&self.pirani).measuring_range()
    }

    fn drive(&self, part: usize) -> Drive {
        match self.parts().get(part).map(|part| part.principle) {
            Some(Principle::Pirani) if !self.heating.is_on() => Drive::Off,
            _ => Drive::On,
        }
    }

    fn sense(&mut self, part: usize, pa: f64) {
        if let Some(part) = self.measuring_parts_mut().nth(part) {
            part.sensor.sensed_pa = pa;
        }
    }

    fn advance(&mut self, seconds: f64) {
        self.machine.advance(seconds, self.self_test());
        self.advance_adjustments(seconds);
    }

    fn settle(&mut self) {
        self.machine.settle(self.self_test());
    }

    fn front_panel(&self) -> FrontPanel {
        FrontPanel { switches: &[SwitchName::Address], buttons: 2, potentiometers: &[] }
    }

    fn set_fault(&mut self, fault: Fault, active: bool) {
        self.faults.set(fault, active);
    }

    /// Button 1 belongs to trip point 1, button 2 to trip point 2.
    fn press_button(&mut self, number: u8) {
        self.set_trip_point_by_button(usize::from(number).saturating_sub(1));
    }

    /// The parameter Address Switch is the present setting (7.1.22); the station address is read at power-up only.
    fn set_switch(&mut self, switch: Switch) {
        match switch {
            Switch::Address(setting) => self.address_switch = setting,
            Switch::Degas(_) | Switch::LowHigh(_) | Switch::CalAdj(_) => {}
        }
    }

    fn has_alarm(&self) -> bool {
        self.has_error()
    }

    fn report(&self) -> StateReport {
        let active = self.active();
        StateReport {
            device_state: self.machine.state().into(),
            led: self.led(),
            // A relay has the state of its trip point (93).
            relays: self.trips.iter().map(TripPoint::status).collect(),
            indicated: self.measuring_parts().map(|part| part.indicated(&self.condition(part))).collect(),
            active_instance: active.part().instance,
            exception_status: self.exception_status().bits(),
            outputs_safe: active.is_safe(&self.condition(active)),
            run_hours: self.stored.run_hours(),
            ..StateReport::default()
        }
    }
}
