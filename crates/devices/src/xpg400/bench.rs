//! BPG400-SP and HPG400-SP as they stand on bus and bench.

use super::table::PARTS;
use super::{Gauge, Kind};
use crate::instrument::{Action, Drive, Part, Report, Span, Unknown};
use crate::model::{Configuration, Field, Model, Octets, Unit, faults};
use crate::profile::Behaviour;

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

impl Behaviour for Gauge {
    fn model(&self) -> &'static Model {
        &self.kind.version().model
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

    fn span(&self, part: usize) -> Span {
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

    fn operate(&mut self, action: Action<'_>) -> Result<(), Unknown> {
        match action {
            Action::Fault { name, present } => {
                *self.faults.named(name).ok_or(Unknown { expected: Faults::LIST.names })? = present;
                Ok(())
            }
            Action::Switch { name, value } => self.set_switch(name, value),
            Action::Pot { which, volts } => {
                let [a, b] = &mut self.set_points;
                match which {
                    'a' => a.turn(volts),
                    'b' => b.turn(volts),
                    _ => return Err(Unknown { expected: &["a", "b"] }),
                }
                Ok(())
            }
            Action::Button(_) => Err(Unknown { expected: &[] }),
        }
    }

    fn report(&self) -> Report {
        let degas = (self.kind == Kind::Bpg).then_some(self.cathode.is_degassing());
        Report {
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

impl Gauge {
    /// Pin 7 is connected in the BPG400-SP only (Appendix C), the side switches are there on the HPG400-SP only.
    fn set_switch(&mut self, name: &str, value: &str) -> Result<(), Unknown> {
        match (self.kind, name) {
            (Kind::Bpg, "degas") => self.degas_input(value)?,
            (Kind::Bpg, _) => return Err(Unknown { expected: &["address", "degas"] }),
            (Kind::Hpg, "low-high") => self.side.low_high = position(value)?,
            (Kind::Hpg, "cal-adj") => self.side.cal_adj = position(value)?,
            (Kind::Hpg, _) => return Err(Unknown { expected: &["address", "low-high", "cal-adj"] }),
        }
        Ok(())
    }

    /// Pin 7, active high: Appendix C.
    fn degas_input(&mut self, value: &str) -> Result<(), Unknown> {
        let conditions = self.conditions();
        match value {
            // Refused like the command, but a wire hears nothing of it.
            "on" => drop(self.cathode.start_degas(&conditions)),
            "off" => self.cathode.stop_degas(),
            _ => return Err(Unknown { expected: &["on", "off"] }),
        }
        Ok(())
    }
}

/// A position of a rotary switch.
fn position(value: &str) -> Result<u8, Unknown> {
    value.parse().ok().filter(|position| *position <= 9).ok_or(Unknown { expected: &["0 ... 9"] })
}
