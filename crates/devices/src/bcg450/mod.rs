//! BCG450-SP: Pirani, Bayard-Alpert and capacitance diaphragm in one gauge. tira41d1.
//!
//! [`table`] has the manual's tables, [`parts`] the ranges, [`codes`] the code tables. `measurement` joins the three parts,
//! `relay` has the two functions of the contacts, `parameters` reads and writes every row, `simulation` has cyclic data
//! and front panel. Numbers in brackets are those of errata-bpg-bcg-tpg.

pub mod codes;
mod faults;
mod measurement;
mod parameters;
pub mod parts;
mod relay;
mod simulation;
pub mod table;

use crate::model::{AccessError, Counts, DESCRIBED, Limits, Model, Principle};
use crate::profile::{
    BlockDevice, Cathode, CathodeConditions, CommonExceptions, DeviceBlockValues, ExceptionDetails, ExceptionStatus,
    MeasuringPart, Presentation, ReadingCondition, SelfTestResult, Sensor, SerialNumber, Setup, StateMachine,
    StatusExtension, TransitionCommand,
};
use crate::store::Store;
use faults::Faults;
use measurement::measure;
use relay::Relay;

/// A BCG450-SP with its nonvolatile memory.
pub type Bcg450<S> = BlockDevice<Bcg450Behaviour, S>;

impl<S: Store> Bcg450<S> {
    /// A gauge that has just been switched on.
    #[must_use]
    pub fn new(store: S, setup: Setup) -> Self {
        Self::with_model(&table::MODEL, store, setup)
    }

    /// The same for a gauge whose tables a device file has, like those of the BCG450-SP.
    #[must_use]
    pub fn with_model(model: &'static Model, store: S, setup: Setup) -> Self {
        Self::from_behaviour(Bcg450Behaviour::new(model, setup.serial), store, &setup)
    }
}

/// The behaviour of the BCG450-SP.
#[derive(Clone, Debug)]
pub struct Bcg450Behaviour {
    serial: SerialNumber,
    machine: StateMachine,
    presentation: Presentation,
    /// Channel Instance Selector.
    selector: u8,
    pirani: MeasuringPart,
    ba: MeasuringPart,
    cdg: MeasuringPart,
    /// The ambient pressure.
    atmosphere: Sensor,
    /// PV Selector.
    active: u8,
    /// The gauge has been in EXECUTING since power-up. Outside of EXECUTING the PV Selector stays.
    has_measured: bool,
    /// The conditions that all readings depend on.
    condition: ReadingCondition,
    /// One Of N Status Extension: the range of the whole gauge, and whether its value is valid (57, 58).
    one_of_n: StatusExtension,
    cathode: Cathode,
    relays: [Relay; 2],
    /// The cyclic transition command of the last cycle.
    command: TransitionCommand,
    faults: Faults,
    /// Operating time in seconds.
    seconds: f64,
}

impl Bcg450Behaviour {
    fn new(model: &'static Model, serial: SerialNumber) -> Self {
        Self {
            serial,
            machine: StateMachine::power_up(),
            presentation: Presentation::new(model, table::FACTORY_UNIT),
            selector: 1,
            pirani: MeasuringPart::new(model.part_like(&parts::PIRANI)),
            ba: MeasuringPart::new(model.part_like(&parts::BA)),
            cdg: MeasuringPart::new(model.part_like(&parts::CDG)),
            atmosphere: Sensor::in_air(),
            active: 1,
            has_measured: false,
            condition: ReadingCondition { executing: false, disturbed: false, alarmed: false },
            one_of_n: StatusExtension::INVALID,
            cathode: Cathode::new(&parts::CATHODE),
            relays: [Relay::new(), Relay::new()],
            command: TransitionCommand::NONE,
            faults: Faults::NONE,
            seconds: 0.0,
        }
    }

    /// The measuring part with this instance.
    const fn part(&self, instance: u8) -> Option<&MeasuringPart> {
        match instance {
            1 => Some(&self.pirani),
            2 => Some(&self.ba),
            3 => Some(&self.cdg),
            _ => None,
        }
    }

    const fn part_mut(&mut self, instance: u8) -> Option<&mut MeasuringPart> {
        match instance {
            1 => Some(&mut self.pirani),
            2 => Some(&mut self.ba),
            3 => Some(&mut self.cdg),
            _ => None,
        }
    }

    /// The active part.
    fn active(&self) -> &MeasuringPart {
        self.part(self.active).unwrap_or(&self.pirani)
    }

    /// The reading of the gauge in Pa, or that of the Pirani if the active part has none. It is not clipped, so that a
    /// Pirani far below its range does not report a pressure too high for degas.
    fn reading_pa(&self) -> f64 {
        let active = self.active();
        active.reading_pa.or(self.pirani.reading_pa).unwrap_or(active.spec.limits.over_pa)
    }

    /// Whether the gauge has a diaphragm: one of a device file can be without.
    fn has_diaphragm(&self) -> bool {
        let mut parts = self.presentation.model.parts.iter();
        !DESCRIBED || parts.any(|spec| spec.part.principle == Principle::Diaphragm)
    }

    /// The number of device details of an alarm: two for each part.
    fn alarm_details(&self) -> usize {
        if self.has_diaphragm() { 6 } else { 4 }
    }

    /// The number of the relay with this instance: 5 and 6, unless a device file has others.
    fn relay_number(&self, instance: u8) -> Option<usize> {
        if DESCRIBED {
            return self.presentation.model.number_in_block(table::SET_POINT_BLOCK, instance);
        }
        instance.checked_sub(table::SETPOINT_A.instance).map(usize::from)
    }

    /// COUNTS of a part.
    const fn counts(part: &MeasuringPart) -> Counts {
        if DESCRIBED { part.spec.counts } else { parts::COUNTS }
    }

    /// The relay with this instance.
    fn relay(&self, instance: u8) -> Option<&Relay> {
        self.relays.get(self.relay_number(instance)?)
    }

    fn relay_mut(&mut self, instance: u8) -> Option<&mut Relay> {
        let number = self.relay_number(instance)?;
        self.relays.get_mut(number)
    }

    /// Executes a Device Block State Command. Reset sets the volatile values to those after power-up.
    fn state_command(&mut self, number: u8) -> Result<(), AccessError> {
        if self.machine.command(number)? {
            self.cathode = Cathode::new(&parts::CATHODE);
            self.relays.iter_mut().for_each(|relay| relay.point.open());
        }
        Ok(())
    }

    /// The result that a self test would have.
    fn self_test(&self) -> SelfTestResult {
        SelfTestResult::found(self.common(), self.exception_status().intersects(ExceptionStatus::ALARM))
    }

    /// Memory faults, alike in both records (48, 49).
    fn common(&self) -> CommonExceptions {
        CommonExceptions::from_memory_faults(self.faults.eprom, self.faults.eeprom, self.faults.ram)
    }

    /// Exception Detail Alarm: CDG, Pirani, BA (46).
    fn alarm(&self) -> ExceptionDetails<6> {
        let [c0, c1] = self.cdg.sensor_alarm();
        let [p0, p1] = self.pirani.sensor_alarm();
        let [b0, b1] = self.ba.sensor_alarm();
        let manufacturer = u8::from(self.faults.comm);
        let device = if self.has_diaphragm() { [c0, c1, p0, p1, b0, b1] } else { [p0, p1, b0, b1, 0, 0] };
        ExceptionDetails { common: self.common(), device, manufacturer }
    }

    /// Exception Detail Warning: the status extension, then CDG, Pirani, BA (44).
    fn warning(&self) -> ExceptionDetails<7> {
        let [c0, c1] = Self::CDG_WARNING;
        let [p0, p1] = self.pirani_warning();
        let [b0, b1] = self.ba_warning();
        let [a, b] = &self.relays;
        // Internal communication as in the alarm (49), then the relays at atmosphere (50, 114).
        let manufacturer =
            u8::from(self.faults.comm) | u8::from(a.atmosphere_reached()) << 1 | u8::from(b.atmosphere_reached()) << 2;
        let range = self.one_of_n.bits();
        let device = if self.has_diaphragm() { [range, c0, c1, p0, p1, b0, b1] } else { [range, p0, p1, b0, b1, 0, 0] };
        ExceptionDetails { common: self.common(), device, manufacturer }
    }

    /// Sensor Warning of the Pirani: Electronics Warning, which means badly adjusted (105).
    fn pirani_warning(&self) -> [u8; 2] {
        [0, u8::from(self.faults.pirani_adjust) << 1]
    }

    /// Sensor Warning of the Bayard-Alpert part: the pressure is too high for degas.
    fn ba_warning(&self) -> [u8; 2] {
        [0, u8::from(self.cathode.is_too_high_for_degas(self.reading_pa())) << 3]
    }

    /// Sensor Warning of the capacitance diaphragm part, which warns of nothing.
    const CDG_WARNING: [u8; 2] = [0; 2];

    /// Any alarm makes every reading invalid, warnings do not (54).
    fn update_validity(&mut self) {
        let alarm = self.alarm();
        self.condition = ReadingCondition {
            executing: self.machine.is_executing(),
            disturbed: alarm.is_any(),
            alarmed: !alarm.common.is_empty() || alarm.manufacturer != 0,
        };
        let range = self.range().status_of(self.active().indicated_pa());
        self.one_of_n = StatusExtension::new(range, self.active().is_valid(&self.condition));
    }

    /// The range of the whole gauge: from the lowest end of its parts to the highest.
    fn range(&self) -> Limits {
        if !DESCRIBED {
            return parts::GAUGE;
        }
        let highest = if self.has_diaphragm() { self.cdg.spec } else { self.pirani.spec };
        Limits { under_pa: self.ba.spec.limits.under_pa, ..highest.limits }
    }

    /// The conditions of the cathode; the Pirani is its controlling part.
    fn conditions(&self) -> CathodeConditions {
        CathodeConditions {
            able: self.machine.is_executing() && !self.pirani.failed && !self.ba.failed,
            control_pa: self.pirani.sensor.indicated_pa(),
            gauge_pa: self.reading_pa(),
        }
    }

    /// Updates device state, emission, readings, relays, validity and last valid values, in this order.
    fn update_all(&mut self) {
        self.machine.detect(self.common());
        self.pirani.failed = self.faults.sensor_1 || self.faults.electronics_1;
        self.ba.failed = self.faults.sensor_2 || self.faults.electronics_2;
        self.cdg.failed = self.has_diaphragm() && (self.faults.sensor_3 || self.faults.electronics_3);
        self.cathode.update_emission(&self.conditions());
        self.measure();
        self.cathode.update_current(self.reading_pa());
        self.update_relays();
        self.update_validity();
        let condition = self.condition;
        [&mut self.pirani, &mut self.ba, &mut self.cdg].into_iter().for_each(|part| part.remember(&condition));
    }

    /// Sets the reading of each part; that of the active one is the measurement of the gauge.
    fn measure(&mut self) {
        let pirani_pa = self.pirani.sensor.indicated_pa();
        let ba_pa = self.cathode.is_on().then(|| self.ba.sensor.indicated_pa());
        let cdg_pa = self.has_diaphragm().then(|| self.cdg.sensor.indicated_pa());
        self.pirani.reading_pa = Some(pirani_pa);
        self.ba.reading_pa = ba_pa;
        self.cdg.reading_pa = cdg_pa;
        let measurement = measure(pirani_pa, ba_pa, cdg_pa);
        if let Some(active) = self.part_mut(measurement.active) {
            active.reading_pa = Some(measurement.pa);
        }
        self.select_active(measurement.active);
    }

    /// Sets the PV Selector to the part that measures. When the gauge leaves EXECUTING it stays, because the Safe State
    /// and the last valid value in the cyclic data are those of the part that measured last. 3.2.1.3, 3.2.2.7, (74).
    fn select_active(&mut self, measuring: u8) {
        let executing = self.machine.is_executing();
        if executing || !self.has_measured {
            self.active = measuring;
        }
        self.has_measured |= executing;
    }

    /// The relays are closed only in EXECUTING, and without any sensor alarm (112).
    fn update_relays(&mut self) {
        let failed = self.pirani.failed || self.ba.failed || self.cdg.failed;
        let allowed = self.machine.is_executing() && !failed;
        let pa = self.active().indicated_pa();
        let atmosphere_pa = self.atmosphere.indicated_pa();
        for relay in &mut self.relays {
            relay.follow(allowed, pa, atmosphere_pa);
        }
    }

    /// Adjusts the ambient pressure sensor to the diaphragm, in a chamber that is vented: 3.3.5.2, (116, 159).
    fn adjust_atmosphere(&mut self) -> Result<(), AccessError> {
        let pa = self.cdg.sensor.indicated_pa();
        if self.cdg.failed || !parts::ATMOSPHERE.contains(pa) {
            return Err(AccessError::StateConflict);
        }
        self.atmosphere.offset_pa = pa - self.atmosphere.sensed_pa;
        Ok(())
    }

    /// Takes back the adjustment of the ambient pressure sensor (116).
    fn reset_atmosphere(&mut self) {
        self.atmosphere.offset_pa = 0.0;
    }
}
