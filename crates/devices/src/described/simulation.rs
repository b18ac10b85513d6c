//! Cyclic data, sensors and front panel of a described device.

use super::trip::Trip;
use super::{BlockBehaviour, DescribedBehaviour};
use crate::model::{Fault, Field, MeasuringRange, Model, NumberType, Octets, Part, PressureFormat, Principle};
use crate::profile::{Behaviour, Cathode, DeviceBlockValues, MeasuringPart, Presentation};
use crate::simulation::{Drive, FrontPanel, Led, ReportedState, StateReport, SwitchName};

impl DescribedBehaviour {
    /// A pressure of a part in this number type.
    fn pressure(&self, part: Option<&MeasuringPart>, number: NumberType) -> Octets {
        let pa = part.map_or(0.0, |part| part.process_value_pa(&self.condition));
        PressureFormat { number, ..self.format_of(part) }.encode(pa)
    }

    /// The name of the command with this code in the first block of a part that has it, and the position of the part.
    fn transition(&self, code: u16) -> Option<(usize, &'static str)> {
        let blocks = self.description.model.blocks.iter().zip(self.description.blocks);
        let transducers = blocks.filter(|(_, behaviour)| behaviour.is_some_and(|it| it.principle().is_some()));
        let mut places = transducers.flat_map(|(placed, _)| placed.locations.iter().map(move |it| (it, placed.block)));
        places.find_map(|(location, block)| {
            let mut commands = block.rows.iter().filter(|row| row.codes.is_command());
            let found = commands.find_map(|row| row.codes.code(code.into()))?;
            Some((self.part_at(location)?, found.name))
        })
    }
}

impl Behaviour for DescribedBehaviour {
    fn model(&self) -> &'static Model {
        self.description.model
    }

    fn presentation_mut(&mut self) -> Option<&mut Presentation> {
        Some(&mut self.presentation)
    }

    fn set_exchanging(&mut self, running: bool) {
        self.machine.set_exchanging(running);
    }

    /// No telegram reports a refusal (errata-bpg-bcg-tpg 101).
    fn output(&mut self, field: Field, octets: &[u8]) {
        if let Some(code) = self.command.changed(field, octets) {
            if let Some((position, name)) = self.transition(code) {
                let _ = self.execute(position, name);
            }
            self.update();
        }
    }

    fn input(&self, field: Field) -> Octets {
        let part = |channel: u8| self.position(channel).and_then(|it| self.sensing().get(it)).map(|it| &it.part);
        match field {
            Field::ExceptionStatus => Octets::new(&[self.exception_status().bits()]),
            Field::StatusExtension => Octets::new(&[self.one_of_n.bits()]),
            Field::PvSelector => Octets::new(&[self.active().map_or(0, |part| part.part().instance)]),
            Field::ProcessValue(number) => self.pressure(self.active(), number),
            Field::ChannelValue(channel, number) => self.pressure(part(channel), number),
            Field::TripRelays(_) => {
                let states = self.trips.each_ref().map(Trip::status);
                Octets::filled(&states, field.octets(), 0)
            }
            // What no behaviour of the library has: zeros.
            _ => Octets::filled(&[], field.octets(), 0),
        }
    }

    fn start(&mut self) {
        let mut sensing = self.sensing.clone();
        for it in &mut sensing {
            it.part = it.part.restarted();
            it.cathode = Cathode::new(self.description.thresholds);
        }
        let Self { eeprom, ram, eprom, comm, seconds, .. } = *self;
        *self = Self { sensing, eeprom, ram, eprom, comm, seconds, ..Self::new(self.description, self.serial) };
    }

    fn update(&mut self) {
        self.update_all();
    }

    fn parts(&self) -> &[Part] {
        self.parts.get(..self.count).unwrap_or_default()
    }

    fn measuring_range(&self, part: usize) -> MeasuringRange {
        let nothing = MeasuringRange { lowest_pa: 0.0, highest_pa: 0.0 };
        self.sensing().get(part).map_or(nothing, |it| it.part.measuring_range())
    }

    fn drive(&self, part: usize) -> Drive {
        match self.sensing().get(part) {
            Some(it) if it.part.part().principle == Principle::HotCathode => it.cathode.current().drive(),
            Some(it) if it.has_cathode() && !it.cathode.is_on() => Drive::Off,
            _ => Drive::On,
        }
    }

    fn sense(&mut self, part: usize, pa: f64) {
        if let Some(it) = self.sensing_mut().get_mut(part) {
            it.part.sensor.sensed_pa = pa;
        }
    }

    fn advance(&mut self, seconds: f64) {
        self.machine.advance(seconds, self.self_test());
        self.sensing_mut().iter_mut().for_each(|it| it.cathode.advance(seconds));
        self.seconds += seconds;
    }

    fn settle(&mut self) {
        self.machine.settle(self.self_test());
    }

    fn front_panel(&self) -> FrontPanel {
        FrontPanel { switches: &[SwitchName::Address], buttons: 0, potentiometers: &[] }
    }

    fn set_fault(&mut self, fault: Fault, active: bool) {
        match fault {
            Fault::Eeprom => self.eeprom = active,
            Fault::Ram => self.ram = active,
            Fault::Eprom => self.eprom = active,
            Fault::Comm => self.comm = active,
            _ => {
                for it in self.sensing_mut() {
                    let instance = it.part.part().instance;
                    if Fault::of_sensor(instance) == Some(fault) {
                        it.sensor_failed = active;
                    }
                    if Fault::of_electronics(instance) == Some(fault) {
                        it.electronics_failed = active;
                    }
                }
            }
        }
    }

    fn has_alarm(&self) -> bool {
        self.alarm().is_any()
    }

    fn report(&self) -> StateReport {
        let has_machine = self.has(BlockBehaviour::StateMachine);
        let cathodes = || self.sensing().iter().filter(|it| it.has_cathode());
        let trips = self.description.model.blocks.iter().zip(self.description.blocks);
        let trips = trips.filter(|(_, behaviour)| **behaviour == Some(BlockBehaviour::TripPoint));
        let count = trips.map(|(placed, _)| placed.locations.len()).sum();
        StateReport {
            device_state: if has_machine { self.machine.state().into() } else { ReportedState::None },
            led: Led::None,
            relays: self.trips.iter().take(count).map(Trip::is_closed).collect(),
            indicated: self.sensing().iter().map(|it| it.part.indicated(&self.condition)).collect(),
            active_instance: self.active().map_or(0, |part| part.part().instance),
            exception_status: self.exception_status().bits(),
            outputs_safe: self.active().is_some_and(|part| part.is_safe(&self.condition)),
            emission: cathodes().map(|it| it.cathode.is_on()).collect(),
            degas: cathodes().map(|it| it.cathode.is_degassing()).collect(),
            run_hours: self.seconds / 3600.0,
        }
    }
}
