//! Cyclic data, sensors and front panel of the BCG450-SP. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::Bcg450Behaviour;
use super::parts::{self, PARTS, PARTS_WITHOUT_DIAPHRAGM};
use super::relay::Relay;
use super::table::MODEL;
use crate::model::{DESCRIBED, Fault, Field, MeasuringRange, Model, Octets, Part, Principle};
use crate::profile::{Behaviour, DeviceBlockValues, MeasuringPart, Presentation};
use crate::simulation::{Drive, FrontPanel, Led, Potentiometer, StateReport, Switch, SwitchName};

impl Behaviour for Bcg450Behaviour {
    fn model(&self) -> &'static Model {
        if DESCRIBED { self.presentation.model } else { &MODEL }
    }

    fn presentation_mut(&mut self) -> Option<&mut Presentation> {
        Some(&mut self.presentation)
    }

    fn set_exchanging(&mut self, running: bool) {
        self.machine.set_exchanging(running);
    }

    /// The transition command acts whatever instance is selected. No telegram reports a refusal (101).
    fn output(&mut self, field: Field, octets: &[u8]) {
        if let Some(code) = self.command.changed(field, octets) {
            let _ = self.hot_cathode_command(code);
            self.update();
        }
    }

    #[inline]
    fn input(&self, field: Field) -> Octets {
        match field {
            Field::ExceptionStatus => Octets::new(&[self.exception_status().bits()]),
            Field::StatusExtension => Octets::new(&[self.one_of_n.bits()]),
            Field::PvSelector => Octets::new(&[self.active]),
            Field::ProcessValue(_) => {
                let pa = self.active().process_value_pa(&self.condition);
                self.presentation.format(Self::counts(self.active())).encode(pa)
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
            ..Self::new(self.presentation.model, self.serial)
        };
    }

    fn update(&mut self) {
        self.update_all();
    }

    fn parts(&self) -> &[Part] {
        if self.has_diaphragm() { &PARTS } else { &PARTS_WITHOUT_DIAPHRAGM }
    }

    fn measuring_range(&self, part: usize) -> MeasuringRange {
        let part = self.parts().get(part).and_then(|part| self.part(part.instance));
        part.map_or(parts::ATMOSPHERE, MeasuringPart::measuring_range)
    }

    fn drive(&self, part: usize) -> Drive {
        match part {
            1 => self.cathode.current().drive(),
            _ => Drive::On,
        }
    }

    fn sense(&mut self, part: usize, pa: f64) {
        let principle = self.parts().get(part).map(|part| part.principle);
        let sensor = match principle {
            Some(Principle::Pirani) => &mut self.pirani.sensor,
            Some(Principle::HotCathode) => &mut self.ba.sensor,
            Some(Principle::Diaphragm) => &mut self.cdg.sensor,
            Some(Principle::Atmosphere) => &mut self.atmosphere,
            Some(Principle::ColdCathode) | None => return,
        };
        sensor.sensed_pa = pa;
    }

    fn advance(&mut self, seconds: f64) {
        self.machine.advance(seconds, self.self_test());
        self.cathode.advance(seconds);
        self.seconds += seconds;
    }

    fn settle(&mut self) {
        self.machine.settle(self.self_test());
    }

    fn front_panel(&self) -> FrontPanel {
        FrontPanel {
            switches: &[SwitchName::Address, SwitchName::Degas],
            buttons: 0,
            potentiometers: &[Potentiometer::A, Potentiometer::B],
        }
    }

    fn set_fault(&mut self, fault: Fault, active: bool) {
        self.faults.set(fault, active);
    }

    /// Degas is pin 7, active high: Appendix C. A refusal like that of the command has no way to be reported.
    fn set_switch(&mut self, switch: Switch) {
        let conditions = self.conditions();
        match switch {
            Switch::Degas(true) => drop(self.cathode.start_degas(&conditions)),
            Switch::Degas(false) => self.cathode.stop_degas(),
            Switch::Address(_) | Switch::LowHigh(_) | Switch::CalAdj(_) => {}
        }
    }

    fn turn_potentiometer(&mut self, potentiometer: Potentiometer, volts: f64) {
        let [a, b] = &mut self.relays;
        match potentiometer {
            Potentiometer::A => a.point.turn(volts),
            Potentiometer::B => b.point.turn(volts),
        }
    }

    fn has_alarm(&self) -> bool {
        self.alarm().is_any()
    }

    fn report(&self) -> StateReport {
        StateReport {
            device_state: self.machine.state().into(),
            led: Led::None,
            relays: self.relays.iter().map(|relay| relay.point.is_closed()).collect(),
            indicated: [&self.pirani, &self.ba, &self.cdg]
                .into_iter()
                .take(if self.has_diaphragm() { 3 } else { 2 })
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
