//! A gauge of the series as it stands on bus and bench.

use super::trip::TripPoint;
use super::{Pxg55xBehaviour, table, ttr};
use crate::model::{Configuration, Field, Model, Octets, Unit, UserPrm, faults};
use crate::profile::Behaviour;
use crate::simulation::{Action, Drive, MeasuringRange, Part, Principle, StateReport, UnsupportedAction};
use profivac_wire::acyclic::Im0;
use profivac_wire::acyclic::call::IM_RECORD_LENGTH;

faults! {
    /// What can be broken. The effect is a bit of the exception details (7.1.12). The list ends with what is particular to an
    /// instance: a gauge has the faults of the instances it has.
    pub Faults;
    eeprom         "eeprom"        "EEPROM exception, alarm and warning";
    ram            "ram"           "RAM exception, alarm and warning";
    eprom          "eprom"         "EPROM exception, alarm and warning; with ram a self test ends in CRITICAL FAULT";
    comm           "comm"          "internal communication exception, manufacturer alarm and warning";
    sensor_1       "sensor1"       "Sensor Element Failure of instance 1";
    electronics_1  "electronics1"  "Electronics Failure of instance 1";
    sensor_2       "sensor2"       "Sensor Element Failure of instance 2";
    electronics_2  "electronics2"  "Electronics Failure of instance 2";
    sensor_3       "sensor3"       "Sensor Element Failure of the atmosphere sensor, in its own block only";
    electronics_3  "electronics3"  "Electronics Failure of the atmosphere sensor, in its own block only";
}

impl Behaviour for Pxg55xBehaviour {
    fn model(&self) -> &'static Model {
        &self.version.model
    }

    fn set_unit(&mut self, unit: &'static Unit) {
        self.presentation.unit = unit;
    }

    /// The string without a unit is TTR compatibility mode; unit and data type keep their values then (49).
    fn parameterise(&mut self, prm: &'static UserPrm) {
        let unit = self.version.model.unit(prm.unit_code());
        self.ttr = unit.is_none();
        self.presentation.unit = unit.unwrap_or(self.presentation.unit);
    }

    /// Telegram 205 in TTR compatibility mode, and nothing else there (49).
    fn accepts(&self, configuration: &'static Configuration) -> bool {
        let is_ttr = configuration.inputs.is_some_and(|telegram| telegram.fields == [Field::TtrValue]);
        is_ttr == self.ttr
    }

    fn configure(&mut self, configuration: &'static Configuration) {
        self.presentation.configure(configuration);
    }

    fn exchanging(&mut self, running: bool) {
        self.machine.exchanging(running);
    }

    /// The octets of telegram 206 are not processed (4.4.1).
    fn output(&mut self, _field: Field, _octets: &[u8]) {}

    fn input(&self, field: Field) -> Octets {
        let [trip_1, trip_2] = self.trips.each_ref().map(|trip| u8::from(trip.status()));
        match field {
            Field::ExceptionStatus => Octets::new(&[self.exception_status().bits()]),
            Field::StatusExtension => Octets::new(&[self.one_of_n().bits()]),
            Field::PvSelector => Octets::new(&[self.active().part().instance]),
            Field::ProcessValue(_) => self.presentation.format(table::COUNTS).encode(self.output_pa()),
            // One octet each (103).
            Field::TripRelays(_) => Octets::new(&[trip_1, trip_2]),
            Field::TtrValue => Octets::new(&ttr::octets(self.has_alarm(), trip_1 != 0, self.output_pa())),
            // In none of its telegrams.
            _ => Octets::EMPTY,
        }
    }

    /// ORDER_ID is the part number; a serial number that is longer than the field is cut.
    fn im0(&self) -> Option<[u8; IM_RECORD_LENGTH]> {
        let serial = self.serial.as_slice();
        let serial_number = serial.get(..16).unwrap_or(serial);
        let im0 = Im0 { order_id: self.version.number.as_bytes(), serial_number, ..table::IM0 };
        let mut record = [0; IM_RECORD_LENGTH];
        im0.emit(&mut record).ok().map(|_| record)
    }

    fn start(&mut self) {
        *self = self.as_new();
    }

    fn update(&mut self) {
        self.follow();
    }

    fn parts(&self) -> &[Part] {
        self.version.family.parts
    }

    fn span(&self, part: usize) -> MeasuringRange {
        self.measuring_parts().nth(part).unwrap_or(&self.pirani).span()
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
        self.machine.advance(seconds, self.health());
        self.pass_time(seconds);
    }

    fn settle(&mut self) {
        self.machine.settle(self.health());
    }

    /// The parameter is the switch as it stands (7.1.22); the address is polled at power-up only.
    fn address_switch(&mut self, setting: u8) {
        self.address_switch = setting;
    }

    fn operate(&mut self, action: Action<'_>) -> Result<(), UnsupportedAction> {
        match action {
            Action::Fault { name, present } => self.fault(name, present)?,
            Action::Button(1) => self.press(0),
            Action::Button(2) => self.press(1),
            Action::Button(_) => return Err(UnsupportedAction { expected: &["1", "2"] }),
            Action::Switch { .. } => return Err(UnsupportedAction { expected: &["address"] }),
            Action::Pot { .. } => return Err(UnsupportedAction { expected: &[] }),
        }
        Ok(())
    }

    fn report(&self) -> StateReport {
        let active = self.active();
        StateReport {
            device_state: self.machine.state().name(),
            led: self.led(),
            // A relay is what its trip point says (93).
            relays: self.trips.iter().map(TripPoint::status).collect(),
            indicated: self.measuring_parts().map(|part| part.indicated(&self.condition(part))).collect(),
            active_instance: active.part().instance,
            exception_status: self.exception_status().bits(),
            outputs_safe: active.is_safe(&self.condition(active)),
            run_hours: self.kept.run_hours(),
            ..StateReport::default()
        }
    }
}

impl Pxg55xBehaviour {
    fn fault(&mut self, name: &str, present: bool) -> Result<(), UnsupportedAction> {
        let expected = self.version.model.faults.names;
        let fault = self.faults.named(name).filter(|_| expected.contains(&name));
        *fault.ok_or(UnsupportedAction { expected })? = present;
        Ok(())
    }
}
