//! The IMG 400 as it stands on bus and bench.

use super::ion::Ion;
use super::table::{Faults, MODEL};
use super::{GaugeChannel, Img400Behaviour, StatusExtension};
use crate::model::{Configuration, Field, Model, Octets, Unit};
use crate::profile::Behaviour;
use crate::simulation::{Action, Drive, MeasuringRange, Part, PartReading, StateReport, UnsupportedAction};

impl Behaviour for Img400Behaviour {
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

    /// The transition command acts on both cathodes (116) when it changes to something (117); a refusal is reported
    /// nowhere (118).
    fn output(&mut self, field: Field, octets: &[u8]) {
        let (Field::TransitionCommand, [command, value]) = (field, octets) else { return };
        if self.command != [*command, *value] {
            self.command = [*command, *value];
            for slot in [1, 2] {
                let _ = self.hot_cathode_command(slot, (*command, *value));
            }
            self.update();
        }
    }

    fn input(&self, field: Field) -> Octets {
        match field {
            Field::ExceptionStatus => Octets::new(&[self.exception_status().bits()]),
            Field::ChannelValue(channel, _) => self.format().encode(self.process_value_pa(channel)),
            Field::ChannelStatus => Octets::new(&self.channel_status()),
            Field::TripRelays(_) => Octets::new(&self.trips.each_ref().map(|trip| trip.is_closed().into())),
            // In none of its telegrams.
            _ => Octets::EMPTY,
        }
    }

    fn start(&mut self) {
        let mut channels = Self::new(self.gauges).channels;
        for (new, old) in channels.iter_mut().zip(&self.channels) {
            new.part = old.part.restarted();
        }
        *self = Self { channels, faults: self.faults, seconds: self.seconds, ..Self::new(self.gauges) };
        self.initialise();
    }

    fn update(&mut self) {
        self.follow();
    }

    fn parts(&self) -> &[Part] {
        self.fitted.parts()
    }

    fn span(&self, part: usize) -> MeasuringRange {
        let channel = self.fitted.channel(part).and_then(|channel| self.channels.get(channel));
        channel.unwrap_or(&self.channels[0]).part.span()
    }

    fn drive(&self, part: usize) -> Drive {
        let channel = self.fitted.channel(part).unwrap_or_default();
        match self.ions.get(channel) {
            Some(ion) => ion.drive(),
            None if self.errors.channels_off => Drive::Off,
            None => Drive::On,
        }
    }

    fn sense(&mut self, part: usize, pa: f64) {
        if let Some(channel) = self.fitted.channel(part).and_then(|channel| self.channels.get_mut(channel)) {
            channel.part.sensor.sensed_pa = pa;
        }
    }

    fn advance(&mut self, seconds: f64) {
        self.run(seconds);
        self.ions.iter_mut().for_each(|ion| ion.advance(seconds));
        self.seconds += seconds;
    }

    fn settle(&mut self) {
        self.run(f64::INFINITY);
    }

    fn operate(&mut self, action: Action<'_>) -> Result<(), UnsupportedAction> {
        match action {
            Action::Fault { name, present } => {
                *self.faults.named(name).ok_or(UnsupportedAction { expected: Faults::LIST.names })? = present;
                Ok(())
            }
            Action::Button(channel @ (1 | 2)) => {
                self.press_key(channel);
                Ok(())
            }
            Action::Button(_) => Err(UnsupportedAction { expected: &["1", "2"] }),
            Action::Switch { .. } => Err(UnsupportedAction { expected: &["address"] }),
            Action::Pot { .. } => Err(UnsupportedAction { expected: &[] }),
        }
    }

    fn report(&self) -> StateReport {
        let fitted = |slot: &u8| self.channel(*slot).is_some_and(|channel| channel.gauge.is_some());
        let indicated = |slot: u8| PartReading {
            instance: slot,
            value_mbar: self.channel(slot).map_or(0.0, |channel| channel.part.indicated_pa() / 100.0),
            valid: !self.status_extension(slot).contains(StatusExtension::INVALID),
        };
        StateReport {
            device_state: self.machine.state().name(),
            led: "none",
            relays: self.trips.iter().map(|trip| trip.is_closed()).collect(),
            indicated: (1..=4).filter(fitted).map(indicated).collect(),
            exception_status: self.exception_status().bits(),
            outputs_safe: self.channels.iter().any(|channel: &GaugeChannel| channel.part.is_safe(&self.condition())),
            emission: self.ions.iter().map(Ion::is_on).collect(),
            degas: self.ions.iter().map(Ion::is_degassing).collect(),
            run_hours: self.seconds / 3600.0,
            ..StateReport::default()
        }
    }
}

impl Img400Behaviour {
    /// The key EMIS of channel 1 or 2. Key Lock 2 and 3 lock the keys (129), but not the emergency off.
    // free choice: what the four levels lock stands in another manual
    fn press_key(&mut self, slot: u8) {
        let (able, pa) = self.conditions(slot);
        let locked = self.key_lock >= 2;
        if let Some(ion) = self.ion_mut(slot) {
            ion.press_key(locked, able, pa);
        }
    }
}
