//! BCG450-SP: Pirani, Bayard-Alpert and capacitance diaphragm in one gauge. tira41d1.
//!
//! [`table`] is the manual's tables; the rest is what they do: `measurement` joins the three parts, `relay` has the two
//! functions of the contacts, `parameters` leads every row to its value, `bench` has bus and people.

mod codes;
mod measurement;
mod parameters;
mod relay;
mod simulation;
pub mod table;

use crate::model::AccessError;
use crate::profile::{
    BlockDevice, Cathode, CathodeConditions, CommonExceptions, ExceptionDetails, ExceptionStatus, MeasuringPart,
    Presentation, ReadingCondition, SelfTestResult, Sensor, SerialNumber, Setup, StateMachine, StatusExtension,
    exception_status,
};
use crate::store::Store;
use measurement::measure;
use relay::Relay;
use simulation::Faults;

/// A BCG450-SP with its nonvolatile memory.
pub type Bcg450<S> = BlockDevice<Bcg450Behaviour, S>;

impl<S: Store> Bcg450<S> {
    /// A gauge that has just been switched on.
    #[must_use]
    pub fn new(store: S, setup: Setup) -> Self {
        Self::from_behaviour(Bcg450Behaviour::new(setup.serial), store, &setup)
    }
}

/// What is particular to the BCG450-SP.
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
    /// It has been in EXECUTING since power-up: outside of it the PV Selector stays.
    has_measured: bool,
    /// What concerns all readings.
    condition: ReadingCondition,
    /// One Of N Status Extension: the range of the whole gauge, and whether its value is valid (57, 58).
    one_of_n: StatusExtension,
    cathode: Cathode,
    relays: [Relay; 2],
    /// The cyclic transition command of the last cycle.
    command: [u8; 2],
    faults: Faults,
    seconds: f64,
}

impl Bcg450Behaviour {
    const fn new(serial: SerialNumber) -> Self {
        Self {
            serial,
            machine: StateMachine::power_up(),
            presentation: Presentation::new(table::FACTORY_UNIT),
            selector: 1,
            pirani: MeasuringPart::new(&table::PIRANI),
            ba: MeasuringPart::new(&table::BA),
            cdg: MeasuringPart::new(&table::CDG),
            atmosphere: Sensor::in_air(),
            active: 1,
            has_measured: false,
            condition: ReadingCondition { executing: false, disturbed: false, alarmed: false },
            one_of_n: StatusExtension::INVALID,
            cathode: Cathode::new(&table::CATHODE),
            relays: [Relay::new(), Relay::new()],
            command: [0; 2],
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

    /// The part that measures.
    fn active(&self) -> &MeasuringPart {
        self.part(self.active).unwrap_or(&self.pirani)
    }

    /// What the gauge reads, in Pa, or the Pirani for a part that does not. It is not clipped: a Pirani far below its range
    /// sees no pressure too high for degas.
    fn reading_pa(&self) -> f64 {
        let active = self.active();
        active.reading_pa.or(self.pirani.reading_pa).unwrap_or(active.facts.limits.over_pa)
    }

    /// Instances 5 and 6.
    fn relay(&self, instance: u8) -> Option<&Relay> {
        self.relays.get(usize::from(instance).checked_sub(5)?)
    }

    fn relay_mut(&mut self, instance: u8) -> Option<&mut Relay> {
        self.relays.get_mut(usize::from(instance).checked_sub(5)?)
    }

    /// A Device Block State Command. Reset brings the volatile values back to what they are after power-up.
    fn state_command(&mut self, number: u8) -> Result<(), AccessError> {
        if self.machine.command(number)? {
            self.cathode = Cathode::new(&table::CATHODE);
            self.relays.iter_mut().for_each(|relay| relay.point.open());
        }
        Ok(())
    }

    /// What the self test would find.
    fn health(&self) -> SelfTestResult {
        SelfTestResult::found(self.common(), self.exception_status().intersects(ExceptionStatus::ALARM))
    }

    /// Memory faults, alike in both records (48, 49).
    fn common(&self) -> CommonExceptions {
        CommonExceptions::of_memories(self.faults.eprom, self.faults.eeprom, self.faults.ram)
    }

    /// Exception Detail Alarm: CDG, Pirani, BA (46).
    fn alarm(&self) -> ExceptionDetails<6> {
        let [c0, c1] = self.cdg.sensor_alarm();
        let [p0, p1] = self.pirani.sensor_alarm();
        let [b0, b1] = self.ba.sensor_alarm();
        let manufacturer = u8::from(self.faults.comm);
        ExceptionDetails { common: self.common(), device: [c0, c1, p0, p1, b0, b1], manufacturer }
    }

    /// Exception Detail Warning: the status extension, then CDG, Pirani, BA (44).
    fn warning(&self) -> ExceptionDetails<7> {
        let [c0, c1] = self.sensor_warning(3);
        let [p0, p1] = self.sensor_warning(1);
        let [b0, b1] = self.sensor_warning(2);
        let [a, b] = &self.relays;
        // Internal communication as in the alarm (49), then the relays at atmosphere (50, 114).
        let manufacturer =
            u8::from(self.faults.comm) | u8::from(a.atmosphere_reached()) << 1 | u8::from(b.atmosphere_reached()) << 2;
        ExceptionDetails { common: self.common(), device: [self.one_of_n.bits(), c0, c1, p0, p1, b0, b1], manufacturer }
    }

    /// Sensor Warning. Only the Pirani has an Electronics Warning, which means badly adjusted (105).
    fn sensor_warning(&self, instance: u8) -> [u8; 2] {
        let electronics = instance == 1 && self.faults.pirani_adjust;
        let degas = instance == 2 && self.cathode.is_too_high_for_degas(self.reading_pa());
        [0, u8::from(electronics) << 1 | u8::from(degas) << 3]
    }

    fn exception_status(&self) -> ExceptionStatus {
        exception_status(&self.alarm(), &self.warning())
    }

    /// Any alarm makes every reading invalid, warnings do not (54).
    fn judge(&mut self) {
        let alarm = self.alarm();
        self.condition = ReadingCondition {
            executing: self.machine.is_executing(),
            disturbed: alarm.is_any(),
            alarmed: !alarm.common.is_empty() || alarm.manufacturer != 0,
        };
        let range = table::GAUGE.status_of(self.active().indicated_pa());
        self.one_of_n = StatusExtension::new(range, self.active().is_valid(&self.condition));
    }

    /// What the cathode depends on; the Pirani controls it.
    fn conditions(&self) -> CathodeConditions {
        CathodeConditions {
            able: self.machine.is_executing() && !self.pirani.failed && !self.ba.failed,
            control_pa: self.pirani.sensor.indicated_pa(),
            gauge_pa: self.reading_pa(),
        }
    }

    /// Everything that follows at once: emission, readings, relays, validity, last valid values.
    fn follow(&mut self) {
        self.pirani.failed = self.faults.sensor_1 || self.faults.electronics_1;
        self.ba.failed = self.faults.sensor_2 || self.faults.electronics_2;
        self.cdg.failed = self.faults.sensor_3 || self.faults.electronics_3;
        self.cathode.switch(&self.conditions());
        self.measure();
        self.cathode.follow(self.reading_pa());
        self.follow_relays();
        self.judge();
        let condition = self.condition;
        [&mut self.pirani, &mut self.ba, &mut self.cdg].into_iter().for_each(|part| part.remember(&condition));
    }

    /// Each part reads for itself, the active one what the gauge measures.
    fn measure(&mut self) {
        let pirani_pa = self.pirani.sensor.indicated_pa();
        let ba_pa = self.cathode.is_on().then(|| self.ba.sensor.indicated_pa());
        let cdg_pa = self.cdg.sensor.indicated_pa();
        self.pirani.reading_pa = Some(pirani_pa);
        self.ba.reading_pa = ba_pa;
        self.cdg.reading_pa = Some(cdg_pa);
        let measurement = measure(pirani_pa, ba_pa, cdg_pa);
        if let Some(active) = self.part_mut(measurement.active) {
            active.reading_pa = Some(measurement.pa);
        }
        self.name_active(measurement.active);
    }

    /// The PV Selector names the part that measures. When the gauge stops measuring it stays: the Safe State, and above all
    /// the last valid value, is that of the part whose place it takes in the cyclic data. 3.2.1.3, 3.2.2.7, (74).
    fn name_active(&mut self, measuring: u8) {
        let executing = self.machine.is_executing();
        if executing || !self.has_measured {
            self.active = measuring;
        }
        self.has_measured |= executing;
    }

    /// Only in EXECUTING, and not with any sensor alarm (112).
    fn follow_relays(&mut self) {
        let failed = self.pirani.failed || self.ba.failed || self.cdg.failed;
        let allowed = self.machine.is_executing() && !failed;
        let pa = self.active().indicated_pa();
        let atmosphere_pa = self.atmosphere.indicated_pa();
        for relay in &mut self.relays {
            relay.follow(allowed, pa, atmosphere_pa);
        }
    }

    /// The ambient pressure sensor is adjusted to the diaphragm, or as from the factory (116).
    fn adjust_atmosphere(&mut self, off: bool) {
        self.atmosphere.offset_pa = if off { 0.0 } else { self.cdg.sensor.indicated_pa() - self.atmosphere.sensed_pa };
    }
}
