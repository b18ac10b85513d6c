//! Cyclic data, sensors and front panel of the IMG 400. Numbers in brackets are those of errata-pxg55x-img400.

use super::codes::KeyLock;
use super::ion::IonCathode;
use super::{GaugeChannel, Img400Behaviour, StatusExtension};
use crate::model::{Fault, Field, MeasuringRange, Model, Octets, Part};
use crate::profile::{Behaviour, Presentation};
use crate::simulation::{Drive, FrontPanel, Led, PartReading, StateReport, SwitchName};

impl Behaviour for Img400Behaviour {
    fn model(&self) -> &'static Model {
        self.presentation.model
    }

    fn presentation_mut(&mut self) -> Option<&mut Presentation> {
        Some(&mut self.presentation)
    }

    fn set_exchanging(&mut self, running: bool) {
        self.machine.set_exchanging(running);
    }

    /// The transition command acts on both cathodes (116) when it changes (117). No telegram reports a refusal (118).
    fn output(&mut self, field: Field, octets: &[u8]) {
        if let Some(code) = self.command.changed(field, octets) {
            for slot in [1, 2] {
                let _ = self.hot_cathode_command(slot, code);
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
        let mut channels = Self::new(self.presentation.model, self.gauges).channels;
        for (new, old) in channels.iter_mut().zip(&self.channels) {
            new.part = old.part.restarted();
        }
        *self = Self {
            channels,
            faults: self.faults,
            seconds: self.seconds,
            ..Self::new(self.presentation.model, self.gauges)
        };
        self.initialise();
    }

    fn update(&mut self) {
        self.update_all();
    }

    fn parts(&self) -> &[Part] {
        self.fitted.parts()
    }

    fn measuring_range(&self, part: usize) -> MeasuringRange {
        let channel = self.fitted.channel(part).and_then(|channel| self.channels.get(channel));
        channel.unwrap_or(&self.channels[0]).part.measuring_range()
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

    fn front_panel(&self) -> FrontPanel {
        FrontPanel { switches: &[SwitchName::Address], buttons: 2, potentiometers: &[] }
    }

    fn set_fault(&mut self, fault: Fault, active: bool) {
        self.faults.set(fault, active);
    }

    fn press_button(&mut self, number: u8) {
        self.press_key(number);
    }

    fn has_alarm(&self) -> bool {
        self.exception_status().intersects(crate::profile::ExceptionStatus::ALARM)
    }

    fn report(&self) -> StateReport {
        let fitted = |slot: &u8| self.channel(*slot).is_some_and(|channel| channel.gauge.is_some());
        let indicated = |slot: u8| PartReading {
            instance: slot,
            value_mbar: self.channel(slot).map_or(0.0, |channel| channel.part.indicated_pa() / 100.0),
            valid: !self.status_extension(slot).contains(StatusExtension::INVALID),
        };
        StateReport {
            device_state: self.machine.state().into(),
            led: Led::None,
            relays: self.trips.iter().map(|trip| trip.is_closed()).collect(),
            indicated: (1..=4).filter(fitted).map(indicated).collect(),
            exception_status: self.exception_status().bits(),
            outputs_safe: self.channels.iter().any(|channel: &GaugeChannel| channel.part.is_safe(&self.condition())),
            emission: self.ions.iter().map(IonCathode::is_on).collect(),
            degas: self.ions.iter().map(IonCathode::is_degassing).collect(),
            run_hours: self.seconds / 3600.0,
            ..StateReport::default()
        }
    }
}

impl Img400Behaviour {
    /// The operator has pressed the key EMIS of channel 1 or 2. PROFI-LOCK and FULL-LOCK lock the keys (129), but not
    /// the emergency off.
    // chosen: the effect of the four levels is in another manual
    fn press_key(&mut self, slot: u8) {
        let (able, pa) = self.conditions(slot);
        let locked = matches!(self.key_lock, KeyLock::ProfiLock | KeyLock::FullLock);
        if let Some(ion) = self.ion_mut(slot) {
            ion.press_key(locked, able, pa);
        }
    }
}
