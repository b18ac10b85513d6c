//! BPG400-SP and HPG400-SP as they stand on bus and bench.

use super::table::PARTS;
use super::{Xpg400Behaviour, Xpg400Model};
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
    pirani_adjust  "pirani-adjust" "electronics warning of the Pirani, which makes readings invalid";
    sensor_1       "sensor1"       "sensor alarm of the Pirani";
    sensor_2       "sensor2"       "sensor alarm of the ionisation part";
    electronics_1  "electronics1"  "sensor alarm of the Pirani";
    electronics_2  "electronics2"  "sensor alarm of the ionisation part";
}

impl Behaviour for Xpg400Behaviour {
    fn model(&self) -> &'static Model {
        &self.kind.variant().model
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

    /// Nothing but the parameter channel travels to these gauges.
    fn output(&mut self, _field: Field, _octets: &[u8]) {}

    fn input(&self, field: Field) -> Octets {
        let active = self.active();
        match field {
            Field::ExceptionStatus => Octets::new(&[self.exception_status().bits()]),
            Field::StatusExtension => Octets::new(&[self.one_of_n.bits()]),
            Field::PvSelector => Octets::new(&[active.part().instance]),
            Field::ProcessValue(_) => {
                let pa = active.process_value_pa(&self.condition);
                self.presentation.format(active.facts.counts).encode(pa)
            }
            // In none of its telegrams.
            _ => Octets::EMPTY,
        }
    }

    fn start(&mut self) {
        *self = Self {
            pirani: self.pirani.restarted(),
            ion: self.ion.restarted(),
            set_points: self.set_points.each_ref().map(|point| point.restarted()),
            side: self.side,
            faults: self.faults,
            seconds: self.seconds,
            ..Self::new(self.kind, self.serial)
        };
    }

    fn update(&mut self) {
        self.follow();
    }

    fn parts(&self) -> &[Part] {
        &PARTS
    }

    fn span(&self, part: usize) -> MeasuringRange {
        if part == 0 { self.pirani.span() } else { self.ion.span() }
    }

    fn drive(&self, part: usize) -> Drive {
        if part == 0 { Drive::On } else { self.current().drive() }
    }

    fn sense(&mut self, part: usize, pa: f64) {
        let sensors = [&mut self.pirani.sensor, &mut self.ion.sensor];
        if let Some(sensor) = sensors.into_iter().nth(part) {
            sensor.sensed_pa = pa;
        }
    }

    fn advance(&mut self, seconds: f64) {
        self.machine.advance(seconds, self.health());
        self.cathode.advance(seconds);
        self.advance_adjustment(seconds);
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
            Action::Switch { name, value } => self.set_switch(name, value),
            Action::Pot { which, volts } => {
                let [a, b] = &mut self.set_points;
                match which {
                    'a' => a.turn(volts),
                    'b' => b.turn(volts),
                    _ => return Err(UnsupportedAction { expected: &["a", "b"] }),
                }
                Ok(())
            }
            Action::Button(_) => Err(UnsupportedAction { expected: &[] }),
        }
    }

    fn report(&self) -> StateReport {
        let degas = (self.kind == Xpg400Model::Bpg).then_some(self.cathode.is_degassing());
        StateReport {
            device_state: self.machine.state().name(),
            led: "none",
            relays: self.set_points.iter().map(|point| point.is_closed()).collect(),
            indicated: [&self.pirani, &self.ion].into_iter().map(|part| part.indicated(&self.condition)).collect(),
            active_instance: self.active().part().instance,
            exception_status: self.exception_status().bits(),
            outputs_safe: self.active().is_safe(&self.condition),
            emission: core::iter::once(self.cathode.is_on()).collect(),
            degas: degas.into_iter().collect(),
            run_hours: self.seconds / 3600.0,
        }
    }
}

impl Xpg400Behaviour {
    /// Pin 7 is connected in the BPG400-SP only (Appendix C), the side switches are there on the HPG400-SP only.
    fn set_switch(&mut self, name: &str, value: &str) -> Result<(), UnsupportedAction> {
        match (self.kind, name) {
            (Xpg400Model::Bpg, "degas") => self.degas_input(value)?,
            (Xpg400Model::Bpg, _) => return Err(UnsupportedAction { expected: &["address", "degas"] }),
            (Xpg400Model::Hpg, "low-high") => self.side.low_high = position(value)?,
            (Xpg400Model::Hpg, "cal-adj") => self.side.cal_adj = position(value)?,
            (Xpg400Model::Hpg, _) => return Err(UnsupportedAction { expected: &["address", "low-high", "cal-adj"] }),
        }
        Ok(())
    }

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

/// A position of a rotary switch.
fn position(value: &str) -> Result<u8, UnsupportedAction> {
    value.parse().ok().filter(|position| *position <= 9).ok_or(UnsupportedAction { expected: &["0 ... 9"] })
}
