//! The BCG450-SP as it stands on bus and bench.

use super::relay::Relay;
use super::table::{MODEL, PARTS};
use super::{Bcg450Behaviour, table};
use crate::model::{Configuration, Field, Model, Octets, Unit, faults};
use crate::profile::Behaviour;
use crate::simulation::{Action, Drive, MeasuringRange, Part, StateReport, UnsupportedAction};

faults! {
    /// What can be broken. The effect is a bit of the exception details (3.1.1.11, 3.1.1.12).
    pub Faults;
    eeprom         "eeprom"        "EEPROM exception, alarm and warning";
    ram            "ram"           "RAM exception, alarm and warning";
    eprom          "eprom"         "EPROM exception, alarm and warning; with ram a self test ends in CRITICAL FAULT";
    comm           "comm"          "internal communication, manufacturer alarm and warning";
    pirani_adjust  "pirani-adjust" "electronics warning of the Pirani";
    sensor_1       "sensor1"       "sensor alarm of the Pirani";
    sensor_2       "sensor2"       "sensor alarm of the BA";
    sensor_3       "sensor3"       "sensor alarm of the CDG";
    electronics_1  "electronics1"  "sensor alarm of the Pirani";
    electronics_2  "electronics2"  "sensor alarm of the BA";
    electronics_3  "electronics3"  "sensor alarm of the CDG";
}

impl Behaviour for Bcg450Behaviour {
    fn model(&self) -> &'static Model {
        &MODEL
    }

    fn set_unit(&mut self, unit: &'static Unit) {
        self.presentation.unit = unit;
    }

    fn configure(&mut self, configuration: &'static Configuration) {
        self.presentation.configure(configuration);
    }

    fn exchanging(&mut self, running: bool) {
        self.machine.exchanging(running);
    }

    /// The transition command acts when it changes, whatever instance is selected; a refusal is reported nowhere (101).
    fn output(&mut self, field: Field, octets: &[u8]) {
        let (Field::TransitionCommand, [command, value]) = (field, octets) else { return };
        if self.command != [*command, *value] {
            self.command = [*command, *value];
            let _ = self.hot_cathode_command((*command, *value));
            self.update();
        }
    }

    fn input(&self, field: Field) -> Octets {
        match field {
            Field::ExceptionStatus => Octets::new(&[self.exception_status().bits()]),
            Field::StatusExtension => Octets::new(&[self.one_of_n.bits()]),
            Field::PvSelector => Octets::new(&[self.active]),
            Field::ProcessValue(_) => {
                let pa = self.active().process_value_pa(&self.condition);
                self.presentation.format(table::COUNTS).encode(pa)
            }
            // In none of its telegrams.
            _ => Octets::EMPTY,
        }
    }

    fn start(&mut self) {
        *self = Self {
            pirani: self.pirani.restarted(),
            ba: self.ba.restarted(),
            cdg: self.cdg.restarted(),
            atmosphere: self.atmosphere.restarted(),
            relays: self.relays.each_ref().map(Relay::restarted),
            faults: self.faults,
            seconds: self.seconds,
            ..Self::new(self.serial)
        };
    }

    fn update(&mut self) {
        self.follow();
    }

    fn parts(&self) -> &[Part] {
        &PARTS
    }

    fn span(&self, part: usize) -> MeasuringRange {
        [&self.pirani, &self.ba, &self.cdg].get(part).map_or(table::ATMOSPHERE, |part| part.span())
    }

    fn drive(&self, part: usize) -> Drive {
        match part {
            1 => self.cathode.current().drive(),
            _ => Drive::On,
        }
    }

    fn sense(&mut self, part: usize, pa: f64) {
        let sensors = [&mut self.pirani.sensor, &mut self.ba.sensor, &mut self.cdg.sensor, &mut self.atmosphere];
        if let Some(sensor) = sensors.into_iter().nth(part) {
            sensor.sensed_pa = pa;
        }
    }

    fn advance(&mut self, seconds: f64) {
        self.machine.advance(seconds, self.health());
        self.cathode.advance(seconds);
        self.seconds += seconds;
    }

    fn settle(&mut self) {
        self.machine.settle(self.health());
    }

    fn operate(&mut self, action: Action<'_>) -> Result<(), UnsupportedAction> {
        match action {
            Action::Fault { name, present } => {
                *self.faults.named(name).ok_or(UnsupportedAction { expected: Faults::LIST.names })? = present;
                Ok(())
            }
            Action::Switch { name: "degas", value } => self.degas_input(value),
            Action::Switch { .. } => Err(UnsupportedAction { expected: &["address", "degas"] }),
            Action::Pot { which, volts } => {
                let [a, b] = &mut self.relays;
                match which {
                    'a' => a.point.turn(volts),
                    'b' => b.point.turn(volts),
                    _ => return Err(UnsupportedAction { expected: &["a", "b"] }),
                }
                Ok(())
            }
            Action::Button(_) => Err(UnsupportedAction { expected: &[] }),
        }
    }

    fn report(&self) -> StateReport {
        StateReport {
            device_state: self.machine.state().name(),
            led: "none",
            relays: self.relays.iter().map(|relay| relay.point.is_closed()).collect(),
            indicated: [&self.pirani, &self.ba, &self.cdg]
                .into_iter()
                .map(|part| part.indicated(&self.condition))
                .collect(),
            active_instance: self.active,
            exception_status: self.exception_status().bits(),
            outputs_safe: self.active().is_safe(&self.condition),
            emission: core::iter::once(self.cathode.is_on()).collect(),
            degas: core::iter::once(self.cathode.is_degassing()).collect(),
            run_hours: self.seconds / 3600.0,
        }
    }
}

impl Bcg450Behaviour {
    /// Pin 7, active high: Appendix C.
    fn degas_input(&mut self, value: &str) -> Result<(), UnsupportedAction> {
        let conditions = self.conditions();
        match value {
            // Refused like the command, but a wire hears nothing of it.
            "on" => drop(self.cathode.start_degas(&conditions)),
            "off" => self.cathode.stop_degas(),
            _ => return Err(UnsupportedAction { expected: &["on", "off"] }),
        }
        Ok(())
    }
}
