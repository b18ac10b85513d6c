//! The BCG450-SP as it stands on bus and bench.

use super::relay::Relay;
use super::table::{MODEL, Parameter};
use super::{Gauge, PARTS};
use crate::instrument::{Action, Indicated, Part, Report, Unknown};
use crate::model::{Address, Configuration, Field, Format, Model, Octets, Refusal, UserPrm, Value, faults};
use crate::profile::{At, Behaviour, MeasuringPart};
use crate::store::Key;

faults! {
    /// What can be broken. The effect is a bit of the exception details (3.1.1.11, 3.1.1.12).
    pub Faults;
    eeprom         "eeprom"        "EEPROM exception, alarm and warning; nothing can be stored";
    ram            "ram"           "RAM exception, alarm and warning";
    eprom          "eprom"         "EPROM exception, alarm and warning; found while starting: CRITICAL FAULT";
    comm           "comm"          "internal communication, manufacturer alarm and warning";
    pirani_adjust  "pirani-adjust" "electronics warning of the Pirani";
    sensor_1       "sensor1"       "sensor alarm of the Pirani";
    sensor_2       "sensor2"       "sensor alarm of the BA";
    sensor_3       "sensor3"       "sensor alarm of the CDG";
    electronics_1  "electronics1"  "sensor alarm of the Pirani";
    electronics_2  "electronics2"  "sensor alarm of the BA";
    electronics_3  "electronics3"  "sensor alarm of the CDG";
}

impl Behaviour for Gauge {
    type Parameter = Parameter;

    const MODEL: &'static Model = &MODEL;

    /// Slot 1 shows the instance of the Channel Instance Selector (errata-bpg-bcg-tpg 28).
    fn shows(&self, address: &Address) -> bool {
        address.instance == 0 || address.instance == self.selector
    }

    fn format(&self, _at: &At<Parameter>) -> Format {
        self.format()
    }

    fn get(&self, at: &At<Parameter>) -> Value {
        self.get(at)
    }

    fn permits(&self, at: &At<Parameter>) -> Result<(), Refusal> {
        self.permits(at)
    }

    fn set(&mut self, at: &At<Parameter>, value: &Value) -> Result<(), Refusal> {
        self.set(at, value)
    }

    fn key(&self, at: &At<Parameter>) -> Key {
        Self::key(at)
    }

    /// The adjustment of the ambient pressure sensor.
    fn hidden(&self) -> &[f64] {
        core::slice::from_ref(&self.atmosphere.offset_pa)
    }

    fn hidden_mut(&mut self) -> &mut [f64] {
        core::slice::from_mut(&mut self.atmosphere.offset_pa)
    }

    fn memory_works(&self) -> bool {
        !self.faults.eeprom
    }

    fn parameterise(&mut self, prm: &'static UserPrm) {
        if let Some(unit) = MODEL.unit(prm.code()) {
            self.unit = unit;
        }
    }

    fn configure(&mut self, configuration: &'static Configuration) {
        if let Some(number) = configuration.number() {
            self.number = number;
        }
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
            Field::StatusExtension => Octets::new(&[self.one_of_n().bits()]),
            Field::PvSelector => Octets::new(&[self.measurement.active]),
            Field::ProcessValue(_) => {
                let pa = self.part(self.measurement.active).map_or(0.0, |part| self.process_value_pa(part));
                self.format().encode(pa)
            }
            // In none of its telegrams.
            _ => Octets::EMPTY,
        }
    }

    fn start(&mut self) {
        *self = Self {
            pirani: MeasuringPart::restarted(&self.pirani),
            ba: MeasuringPart::restarted(&self.ba),
            cdg: MeasuringPart::restarted(&self.cdg),
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

    fn sense(&mut self, part: usize, pa: f64) {
        let sensors = [&mut self.pirani.sensor, &mut self.ba.sensor, &mut self.cdg.sensor, &mut self.atmosphere];
        if let Some(sensor) = sensors.into_iter().nth(part) {
            sensor.sensed_pa = pa.max(0.0);
        }
    }

    fn advance(&mut self, seconds: f64) {
        self.machine.advance(seconds, self.health());
        self.emission.advance(seconds);
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
            Action::Switch { name: "degas", value } => self.degas_input(value),
            Action::Switch { .. } => Err(Unknown { expected: &["address", "degas"] }),
            Action::Pot { which, volts } => {
                let [a, b] = &mut self.relays;
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
        let indicated = [&self.pirani, &self.ba, &self.cdg].into_iter().map(|part| Indicated {
            instance: part.facts.instance,
            value_mbar: self.indicated_pa(part.facts) / 100.0,
            valid: self.is_valid(part.facts),
        });
        Report {
            device_state: self.machine.state().name(),
            led: "none",
            relays: self.relays.iter().map(Relay::is_closed).collect(),
            indicated: indicated.collect(),
            active_instance: self.measurement.active,
            exception_status: self.exception_status().bits(),
            outputs_safe: self.is_safe(self.measurement.active),
            emission: core::iter::once(self.emission.is_on()).collect(),
            degas: core::iter::once(self.emission.is_degassing()).collect(),
            run_hours: self.seconds / 3600.0,
        }
    }
}

impl Gauge {
    /// Pin 7, active high: Appendix C.
    fn degas_input(&mut self, value: &str) -> Result<(), Unknown> {
        let conditions = self.conditions();
        // Refused like the command, and as silently as a wire can refuse.
        let _ = match value {
            "on" => self.emission.start_degas(&conditions),
            "off" => self.emission.stop_degas(),
            _ => return Err(Unknown { expected: &["on", "off"] }),
        };
        Ok(())
    }
}
