//! BCG450-SP: Pirani, Bayard-Alpert and capacitance diaphragm in one gauge. tira41d1.
//!
//! [`table`] is the manual's tables; the rest is what they do: `measurement` joins the three parts, `emission` switches
//! the cathode, `relay` the contacts, `parameters` leads every row to its value, `bench` has what people do to it.

mod bench;
mod emission;
mod measurement;
mod parameters;
mod relay;
pub mod table;

use crate::instrument::{Part, Principle};
use crate::model::{NumberType, Unit};
use crate::profile::{
    BlockDevice, Common, Details, ExceptionStatus, Facts, Health, Machine, MeasuringPart, Range, Sensor, Serial, Setup,
    StatusExtension, exception_status,
};
use crate::store::Store;
use bench::Faults;
use emission::{Conditions, Emission};
use measurement::{Measurement, measure};
use relay::Relay;

/// A BCG450-SP with its nonvolatile memory.
pub type Bcg450<S> = BlockDevice<Gauge, S>;

impl<S: Store> Bcg450<S> {
    /// A gauge that has just been switched on.
    #[must_use]
    pub fn new(store: S, setup: Setup) -> Self {
        let mut device = Self::with(Gauge::new(setup.serial), store, setup.address_switch);
        if let Some(unit) = setup.unit {
            device.happen(|gauge| gauge.unit = unit);
        }
        device
    }
}

/// The measuring parts, in the order of their instances.
const PARTS: [Part; 4] = [
    Part { instance: 1, principle: Principle::Pirani },
    Part { instance: 2, principle: Principle::HotCathode },
    Part { instance: 3, principle: Principle::Diaphragm },
    Part { instance: 4, principle: Principle::Atmosphere },
];

/// What is particular to the BCG450-SP.
#[derive(Clone, Debug)]
pub struct Gauge {
    serial: Serial,
    machine: Machine,
    unit: &'static Unit,
    number: NumberType,
    /// Channel Instance Selector.
    selector: u8,
    pirani: MeasuringPart,
    ba: MeasuringPart,
    cdg: MeasuringPart,
    atmosphere: Sensor,
    measurement: Measurement,
    emission: Emission,
    relays: [Relay; 2],
    /// The cyclic transition command of the last cycle.
    command: [u8; 2],
    faults: Faults,
    seconds: f64,
}

impl Gauge {
    fn new(serial: Serial) -> Self {
        Self {
            serial,
            machine: Machine::default(),
            unit: table::FACTORY_UNIT,
            number: NumberType::Float,
            selector: 1,
            pirani: MeasuringPart::new(&table::PIRANI),
            ba: MeasuringPart::new(&table::BA),
            cdg: MeasuringPart::new(&table::CDG),
            atmosphere: Sensor::default(),
            measurement: Measurement { active: table::PIRANI.instance, pa: 0.0 },
            emission: Emission::default(),
            relays: [Relay::default(), Relay::default()],
            command: [0; 2],
            faults: Faults::default(),
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

    /// Instances 5 and 6.
    fn relay(&self, instance: u8) -> Option<&Relay> {
        self.relays.get(usize::from(instance).checked_sub(5)?)
    }

    fn relay_mut(&mut self, instance: u8) -> Option<&mut Relay> {
        self.relays.get_mut(usize::from(instance).checked_sub(5)?)
    }

    /// Volatile values as they are after INIT.
    fn initialise(&mut self) {
        self.emission = Emission::default();
        self.relays.iter_mut().for_each(Relay::open);
    }

    /// A Device Block State Command.
    fn state_command(&mut self, number: u8) -> Result<(), crate::model::Refusal> {
        if self.machine.command(number)? {
            self.initialise();
        }
        Ok(())
    }

    /// What the self test would find.
    fn health(&self) -> Health {
        match () {
            // free choice: a gauge whose program cannot be read does not start at all.
            () if self.faults.eprom => Health::Critical,
            () if self.exception_status().intersects(ExceptionStatus::ALARM) => Health::Faulty,
            () => Health::Good,
        }
    }

    /// A sensor alarm of this instance: sensor and electronics cannot be told apart (3.3.2.3).
    const fn has_failed(&self, instance: u8) -> bool {
        match instance {
            1 => self.faults.sensor_1 || self.faults.electronics_1,
            2 => self.faults.sensor_2 || self.faults.electronics_2,
            3 => self.faults.sensor_3 || self.faults.electronics_3,
            _ => false,
        }
    }

    /// Sensor Alarm, two octets.
    const fn sensor_alarm(&self, instance: u8) -> [u8; 2] {
        [0, if self.has_failed(instance) { 1 << 1 } else { 0 }]
    }

    /// Sensor Warning, two octets. Only the Pirani has an Electronics Warning, which means badly adjusted (105).
    fn sensor_warning(&self, instance: u8) -> [u8; 2] {
        let electronics = instance == 1 && self.faults.pirani_adjust;
        let degas = instance == 2 && self.emission.is_too_high_for_degas(self.pressure_pa());
        [0, u8::from(electronics) << 1 | u8::from(degas) << 3]
    }

    /// Memory faults, alike in both records (48, 49).
    fn common(&self) -> Common {
        let mut common = Common::empty();
        common.set(Common::EPROM, self.faults.eprom);
        common.set(Common::EEPROM, self.faults.eeprom);
        common.set(Common::RAM, self.faults.ram);
        common
    }

    /// Exception Detail Alarm: CDG, Pirani, BA (46).
    fn alarm(&self) -> Details<6> {
        let [c0, c1] = self.sensor_alarm(3);
        let [p0, p1] = self.sensor_alarm(1);
        let [b0, b1] = self.sensor_alarm(2);
        let manufacturer = u8::from(self.faults.comm);
        Details { common: self.common(), device: [c0, c1, p0, p1, b0, b1], manufacturer }
    }

    /// Exception Detail Warning: the status extension, then CDG, Pirani, BA (44).
    fn warning(&self) -> Details<7> {
        let [c0, c1] = self.sensor_warning(3);
        let [p0, p1] = self.sensor_warning(1);
        let [b0, b1] = self.sensor_warning(2);
        let device = [self.one_of_n().bits(), c0, c1, p0, p1, b0, b1];
        let [a, b] = &self.relays;
        // Internal communication as in the alarm (49), then the relays at atmosphere (50, 114).
        let manufacturer =
            u8::from(self.faults.comm) | u8::from(a.atmosphere_reached()) << 1 | u8::from(b.atmosphere_reached()) << 2;
        Details { common: self.common(), device, manufacturer }
    }

    fn exception_status(&self) -> ExceptionStatus {
        exception_status(&self.alarm(), &self.warning())
    }

    fn has_alarm(&self) -> bool {
        // The status of the alarms alone: the warnings depend on it.
        self.alarm() != Details { common: Common::empty(), device: [0; 6], manufacturer: 0 }
    }

    /// What an instance reads, in Pa; nothing without emission. The active one shows what the gauge measures.
    fn reading_pa(&self, part: &Facts) -> Option<f64> {
        match part.instance {
            active if active == self.measurement.active => Some(self.measurement.pa),
            1 => Some(self.pirani.sensor.indicated_pa()),
            2 => self.emission.is_on().then(|| self.ba.sensor.indicated_pa()),
            _ => Some(self.cdg.sensor.indicated_pa()),
        }
    }

    /// Where the reading of an instance lies; without emission on the high side (81).
    fn range(&self, part: &Facts) -> Range {
        self.reading_pa(part).map_or(Range::Over, |pa| part.limits.judge(pa))
    }

    /// What an instance indicates, in Pa: clipped to its own range (81), but not where that is the end of the gauge's
    /// range (53).
    fn indicated_pa(&self, part: &Facts) -> f64 {
        let low = if part.limits.under_pa == table::GAUGE.under_pa { 0.0 } else { part.limits.under_pa };
        let high = if part.limits.over_pa == table::GAUGE.over_pa { f64::INFINITY } else { part.limits.over_pa };
        self.reading_pa(part).map_or(high, |pa| pa.clamp(low, high))
    }

    /// The pressure the gauge indicates, in Pa.
    fn pressure_pa(&self) -> f64 {
        self.indicated_pa(self.active())
    }

    /// The part that measures.
    const fn active(&self) -> &'static Facts {
        match self.part(self.measurement.active) {
            Some(part) => part.facts,
            None => &table::PIRANI,
        }
    }

    /// Reading Valid: measuring, no alarm (54), in range (55).
    fn is_valid(&self, part: &Facts) -> bool {
        self.machine.is_executing() && !self.has_alarm() && self.range(part) == Range::Within
    }

    /// Whether Safe State rules the value of an instance (75).
    fn is_safe(&self, instance: u8) -> bool {
        !self.machine.is_executing() || !self.common().is_empty() || self.faults.comm || self.has_failed(instance)
    }

    /// Process Value in Pa.
    fn process_value_pa(&self, part: &MeasuringPart) -> f64 {
        if self.is_safe(part.facts.instance) { part.safe_pa() } else { self.indicated_pa(part.facts) }
    }

    /// Status Extension of an instance (57).
    fn status_extension(&self, part: &Facts) -> StatusExtension {
        StatusExtension::new(self.range(part), self.is_valid(part))
    }

    /// One Of N Status Extension: the range of the whole gauge, and whether its value is valid (57, 58).
    fn one_of_n(&self) -> StatusExtension {
        let range = table::GAUGE.judge(self.pressure_pa());
        StatusExtension::new(range, range == Range::Within && self.is_valid(self.active()))
    }

    fn conditions(&self) -> Conditions {
        Conditions {
            able: self.machine.is_executing() && !self.has_failed(1) && !self.has_failed(2),
            pirani_pa: self.pirani.sensor.indicated_pa(),
            gauge_pa: self.pressure_pa(),
        }
    }

    /// Everything that follows at once: emission, active instance, relays, last valid values.
    fn follow(&mut self) {
        let Conditions { able, pirani_pa, .. } = self.conditions();
        self.emission.switch(able, pirani_pa);
        let ba_pa = self.emission.is_on().then(|| self.ba.sensor.indicated_pa());
        self.measurement = measure(pirani_pa, ba_pa, self.cdg.sensor.indicated_pa());
        let pa = self.pressure_pa();
        self.emission.forget_refused_degas(pa);
        self.follow_relays(pa);
        for instance in 1..=3 {
            self.remember(instance);
        }
    }

    /// Only in EXECUTING, and not with any sensor alarm (112).
    fn follow_relays(&mut self, pa: f64) {
        let allowed = self.machine.is_executing() && !(1..=3).any(|instance| self.has_failed(instance));
        let atmosphere_pa = self.atmosphere.indicated_pa();
        for relay in &mut self.relays {
            relay.follow(allowed, pa, atmosphere_pa);
        }
    }

    /// For Hold Last Value.
    fn remember(&mut self, instance: u8) {
        let Some(facts) = self.part(instance).map(|part| part.facts) else { return };
        if self.is_valid(facts) {
            let pa = self.indicated_pa(facts);
            if let Some(part) = self.part_mut(instance) {
                part.remember(pa);
            }
        }
    }

    /// The ambient pressure sensor is adjusted to the diaphragm, or as from the factory (116).
    fn adjust_atmosphere(&mut self, off: bool) {
        self.atmosphere.offset_pa = if off { 0.0 } else { self.cdg.sensor.indicated_pa() - self.atmosphere.sensed_pa };
    }
}
