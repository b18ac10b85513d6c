//! Cyclic data, sensors and front panel of BPG400-SP and HPG400-SP.

use super::parts::PARTS;
use super::{Xpg400Behaviour, Xpg400Model};
use crate::model::{Fault, Field, MeasuringRange, Model, Octets, Part};
use crate::profile::{Behaviour, DeviceBlockValues, Presentation};
use crate::simulation::{Drive, FrontPanel, Led, Potentiometer, StateReport, Switch, SwitchName};

impl Behaviour for Xpg400Behaviour {
    fn model(&self) -> &'static Model {
        self.presentation.model
    }

    fn presentation_mut(&mut self) -> Option<&mut Presentation> {
        Some(&mut self.presentation)
    }

    fn set_exchanging(&mut self, running: bool) {
        self.machine.set_exchanging(running);
    }

    fn input(&self, field: Field) -> Octets {
        let active = self.active();
        match field {
            Field::ExceptionStatus => Octets::new(&[self.exception_status().bits()]),
            Field::StatusExtension => Octets::new(&[self.one_of_n.bits()]),
            Field::PvSelector => Octets::new(&[active.part().instance]),
            Field::ProcessValue(_) => {
                let pa = active.process_value_pa(&self.condition);
                self.presentation.format(active.spec.counts).encode(pa)
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
            ..Self::new(self.presentation.model, self.model, self.serial)
        };
    }

    fn update(&mut self) {
        self.update_all();
    }

    fn parts(&self) -> &[Part] {
        &PARTS
    }

    fn measuring_range(&self, part: usize) -> MeasuringRange {
        if part == 0 { self.pirani.measuring_range() } else { self.ion.measuring_range() }
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
        self.machine.advance(seconds, self.self_test());
        self.cathode.advance(seconds);
        self.advance_adjustment(seconds);
        self.seconds += seconds;
    }

    fn settle(&mut self) {
        self.machine.settle(self.self_test());
    }

    /// Pin 7 is connected in the BPG400-SP only (Appendix C); only the HPG400-SP has the side switches.
    fn front_panel(&self) -> FrontPanel {
        FrontPanel {
            switches: match self.model {
                Xpg400Model::Bpg => &[SwitchName::Address, SwitchName::Degas],
                Xpg400Model::Hpg => &[SwitchName::Address, SwitchName::LowHigh, SwitchName::CalAdj],
            },
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
            Switch::LowHigh(position) => self.side.low_high = position,
            Switch::CalAdj(position) => self.side.cal_adj = position,
            Switch::Address(_) => {}
        }
    }

    fn turn_potentiometer(&mut self, potentiometer: Potentiometer, volts: f64) {
        let [a, b] = &mut self.set_points;
        match potentiometer {
            Potentiometer::A => a.turn(volts),
            Potentiometer::B => b.turn(volts),
        }
    }

    fn has_alarm(&self) -> bool {
        self.alarm().is_any()
    }

    fn report(&self) -> StateReport {
        let degas = (self.model == Xpg400Model::Bpg).then_some(self.cathode.is_degassing());
        StateReport {
            device_state: self.machine.state().into(),
            led: Led::None,
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
