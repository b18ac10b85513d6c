//! PCG550, PCG552, PCG554, PSG550, PSG552 and PSG554: Pirani gauges, the PCG with a capacitance diaphragm and perhaps
//! an atmosphere sensor beside it. tira56e1.
//!
//! [`table`] has the manual's tables, [`codes`] the code tables. `parts` has the ranges, `adjust` the adjustments of the sensors,
//! `heating` the filament of the Pirani, `trip` the trip points, `ttr` the telegram of the compatibility mode;
//! `parameters` reads and writes every row, `simulation` has cyclic data and front panel. Numbers in brackets are those
//! of errata-pxg55x-img400.

mod adjust;
pub mod codes;
mod faults;
mod heating;
mod parameters;
mod parts;
mod simulation;
pub mod table;
mod trip;
mod ttr;

use crate::model::{AccessError, Model, mbar};
use crate::profile::{
    BlockDevice, CommonExceptions, DeviceState, ExceptionDetails, MeasuringPart, Presentation, ReadingCondition,
    SelfTestResult, SerialNumber, Setup, StateCommand, StateMachine, StatusExtension,
};
use crate::simulation::Led;
use crate::store::Store;
use adjust::StoredAdjustments;
use faults::Faults;
use heating::PiraniHeating;
use table::{VARIANTS, Variant};
use trip::TripPoint;

/// A gauge of the series with its nonvolatile memory.
pub type Pxg55x<S> = BlockDevice<Pxg55xBehaviour, S>;

impl<S: Store> Pxg55x<S> {
    /// A gauge that has just been switched on.
    #[must_use]
    pub fn new(store: S, model: Pxg55xModel, setup: Setup) -> Self {
        Self::with_model(&model.variant().model, store, model, setup)
    }

    /// The same for a gauge whose tables a device file has, like those of one of the series.
    #[must_use]
    pub fn with_model(tables: &'static Model, store: S, model: Pxg55xModel, setup: Setup) -> Self {
        Self::from_behaviour(Pxg55xBehaviour::new(tables, model.variant(), setup.serial), store, &setup)
    }
}

/// A gauge of the series.
#[derive(Clone, Copy, Debug)]
pub struct Pxg55xModel(&'static Variant);

impl Pxg55xModel {
    /// The gauge with this name, `pcg550` to `psg554`: with or without an atmosphere sensor; for `None` with one if the
    /// model has such a variant.
    #[must_use]
    pub fn named(name: &str, atmosphere: Option<bool>) -> Option<Self> {
        // Those with a sensor come first.
        let fits = |model: &Self| atmosphere.is_none_or(|wanted| wanted == model.0.family.atm.is_some());
        Self::all().find(|model| model.0.model.name == name && fits(model))
    }

    /// Every gauge of the series.
    pub fn all() -> impl Iterator<Item = Self> {
        VARIANTS.into_iter().map(Self)
    }

    /// Its tables.
    #[must_use]
    pub const fn variant(self) -> &'static Variant {
        self.0
    }
}

/// At and above this pressure of the diaphragm the diaphragm measures (67).
const CDG_FROM_PA: f64 = mbar(10.0);

/// chosen: below this the Pirani does, "a small hysteresis" (67).
const PIRANI_BELOW_PA: f64 = mbar(9.0);

/// The behaviour of the series.
#[derive(Clone, Debug)]
pub struct Pxg55xBehaviour {
    variant: &'static Variant,
    serial: SerialNumber,
    address_switch: u8,
    machine: StateMachine,
    presentation: Presentation,
    /// TTR compatibility mode (49).
    ttr: bool,
    /// Channel Instance Selector.
    selector: u8,
    cdg: Option<MeasuringPart>,
    pirani: MeasuringPart,
    atm: Option<MeasuringPart>,
    heating: PiraniHeating,
    /// Auto Zero Enable.
    auto_zero: bool,
    /// The diaphragm is the active part, if the gauge has one.
    cdg_is_active: bool,
    trips: [TripPoint; 2],
    faults: Faults,
    stored: StoredAdjustments,
}

/// The manufacturer's command for a factory reset (7.2.2).
const FACTORY_RESET: u8 = 128;

impl Pxg55xBehaviour {
    fn new(tables: &'static Model, variant: &'static Variant, serial: SerialNumber) -> Self {
        Self {
            variant,
            serial,
            address_switch: 0,
            machine: StateMachine::power_up(),
            presentation: Presentation::new(tables, table::FACTORY_UNIT),
            ttr: false,
            selector: 1,
            cdg: variant.family.cdg.map(|spec| MeasuringPart::new(tables.part_like(spec))),
            pirani: MeasuringPart::new(tables.part_like(variant.family.pirani)),
            atm: variant.family.atm.map(|spec| MeasuringPart::new(tables.part_like(spec))),
            heating: PiraniHeating::new(),
            auto_zero: false,
            cdg_is_active: true,
            trips: [TripPoint::factory(parts::LOWEST_PA); 2],
            faults: Faults::NONE,
            stored: StoredAdjustments::new(),
        }
    }

    /// The same gauge as from the factory, with its address switch, pressures and faults.
    fn as_new(&self) -> Self {
        Self {
            address_switch: self.address_switch,
            cdg: self.cdg.as_ref().map(MeasuringPart::restarted),
            pirani: self.pirani.restarted(),
            atm: self.atm.as_ref().map(MeasuringPart::restarted),
            faults: self.faults,
            ..Self::new(self.presentation.model, self.variant, self.serial)
        }
    }

    /// The measuring parts, in the order of their instances.
    fn measuring_parts(&self) -> impl Iterator<Item = &MeasuringPart> {
        self.cdg.iter().chain([&self.pirani]).chain(&self.atm)
    }

    fn measuring_parts_mut(&mut self) -> impl Iterator<Item = &mut MeasuringPart> {
        self.cdg.iter_mut().chain([&mut self.pirani]).chain(&mut self.atm)
    }

    /// The measuring part with this instance.
    fn part(&self, instance: u8) -> Option<&MeasuringPart> {
        self.measuring_parts().find(|part| part.part().instance == instance)
    }

    fn part_mut(&mut self, instance: u8) -> Option<&mut MeasuringPart> {
        self.measuring_parts_mut().find(|part| part.part().instance == instance)
    }

    /// The active part: its instance is the PV Selector.
    fn active(&self) -> &MeasuringPart {
        self.cdg.as_ref().filter(|_| self.cdg_is_active).unwrap_or(&self.pirani)
    }

    /// Executes a Device Block State Command. Every value that a Reset would restore is restored already when EXECUTING
    /// ends; 129, which also restarts the basic device, has no other visible effect.
    fn state_command(&mut self, number: u8) -> Result<(), AccessError> {
        const RESET_ALL: u8 = 129;
        const RESET: u8 = StateCommand::Reset as u8;
        let like_reset = matches!(number, FACTORY_RESET | RESET_ALL);
        if like_reset && self.machine.state() == DeviceState::CriticalFault {
            // Only Reset itself acts there (22).
            return Err(AccessError::StateConflict);
        }
        self.machine.command(if like_reset { RESET } else { number })?;
        if number == FACTORY_RESET {
            self.factory_reset();
        }
        Ok(())
    }

    /// Resets every setting and adjustment. The run hours stay, and so do unit, data type and mode while a master
    /// exchanges data that depend on them (8.1.6).
    fn factory_reset(&mut self) {
        let new = self.as_new();
        let held = if self.machine.is_exchanging() { self.presentation } else { new.presentation };
        *self = Self {
            machine: self.machine.clone(),
            presentation: held,
            ttr: self.ttr,
            stored: self.stored.readjusted(),
            ..new
        };
    }

    /// The result that a self test would have.
    fn self_test(&self) -> SelfTestResult {
        SelfTestResult::found(self.common(), self.has_error())
    }

    /// Memory faults, alike in both records (37).
    fn common(&self) -> CommonExceptions {
        CommonExceptions::from_memory_faults(self.faults.eprom, self.faults.eeprom, self.faults.ram)
    }

    /// Internal communication exception, alike in both records (37, 73): bit 0 of 7.1.12. Bit 5 of the common detail,
    /// the communications exception, is another one, and no fault of the list sets it.
    const fn manufacturer(&self) -> u8 {
        self.faults.comm as u8
    }

    /// Sensor Element Failure and Electronics Failure (12.1.3, 12.2.3, 12.3.3).
    const fn sensor_alarm(&self, instance: u8) -> [u8; 2] {
        let Faults { sensor_1, sensor_2, sensor_3, electronics_1, electronics_2, electronics_3, .. } = self.faults;
        let (sensor, electronics) = match instance {
            1 => (sensor_1, electronics_1),
            2 => (sensor_2, electronics_2),
            _ => (sensor_3, electronics_3),
        };
        [sensor as u8, (electronics as u8) << 1]
    }

    /// Exception Detail Alarm: instances 1 and 2, on a PSG55x only 1. The atmosphere sensor is not reported (74).
    fn alarm<const N: usize>(&self) -> ExceptionDetails<N> {
        let mut device = [0; N];
        let alarms =
            (1..=2).filter(|instance| self.part(*instance).is_some()).flat_map(|instance| self.sensor_alarm(instance));
        device.iter_mut().zip(alarms).for_each(|(target, octet)| *target = octet);
        ExceptionDetails { common: self.common(), device, manufacturer: self.manufacturer() }
    }

    /// Exception Detail Warning: the status extension of the gauge (71); no sensor warns of anything.
    fn warning<const N: usize>(&self) -> ExceptionDetails<N> {
        let mut device = [0; N];
        if let [first, ..] = &mut device[..] {
            *first = self.one_of_n().bits();
        }
        ExceptionDetails { common: self.common(), device, manufacturer: self.manufacturer() }
    }

    /// The conditions of the reading of a part: manufacturer alarms and warnings and its own alarm make it invalid (87,
    /// 88), alarms of the whole device make it safe (35).
    fn condition(&self, part: &MeasuringPart) -> ReadingCondition {
        let manufacturer = self.manufacturer() != 0;
        ReadingCondition {
            executing: self.machine.is_executing(),
            disturbed: manufacturer || part.failed,
            alarmed: manufacturer || !self.common().is_empty(),
        }
    }

    fn is_valid(&self, part: &MeasuringPart) -> bool {
        part.is_valid(&self.condition(part))
    }

    fn status_extension(&self, part: &MeasuringPart) -> StatusExtension {
        if part.reading_pa.is_none() {
            // A Pirani that is not heated has no place relative to its range (107).
            return StatusExtension::INVALID;
        }
        part.status_extension(&self.condition(part))
    }

    fn process_value_pa(&self, part: &MeasuringPart) -> f64 {
        part.process_value_pa(&self.condition(part))
    }

    /// The process value in the telegrams, in Pa.
    fn output_pa(&self) -> f64 {
        self.process_value_pa(self.active())
    }

    /// OneOfN Status Extension: that of the active instance, and invalid with every error of the gauge, also with one
    /// that leaves Reading Valid of the active instance alone (13.1.1, 88, 165).
    fn one_of_n(&self) -> StatusExtension {
        let mut extension = self.status_extension(self.active());
        extension.set(StatusExtension::INVALID, extension.contains(StatusExtension::INVALID) || self.has_error());
        extension
    }

    /// Whether Exception Detail Alarm has an error.
    fn has_error(&self) -> bool {
        self.alarm::<4>().is_any()
    }

    /// Status of the discrete outputs: the gauge has an error, or is in a fault from which there is no recovery (10.1.3,
    /// 10.2, 166). No fault concerns a single relay.
    fn outputs_have_error(&self) -> bool {
        self.has_error() || self.machine.state() == DeviceState::CriticalFault
    }

    /// Updates device state, adjustments, readings, active instance, trip points and last valid values, in this order.
    fn update_all(&mut self) {
        self.machine.detect(self.common());
        self.apply_adjustments();
        self.measure();
        self.choose_active();
        self.update_trip_points();
        self.remember();
    }

    /// Sets the reading of each part; the Pirani has one only while it is heated.
    fn measure(&mut self) {
        let failed = [1, 2, 3].map(|instance| self.sensor_alarm(instance) != [0; 2]);
        for (part, failed) in self.measuring_parts_mut().zip(failed) {
            part.failed = failed;
            part.reading_pa = Some(part.sensor.indicated_pa());
        }
        // chosen: on a PSG55x the pressure of the unheated Pirani decides when it is heated again.
        let control = self.cdg.as_ref().unwrap_or(&self.pirani);
        self.heating.update(control.sensor.indicated_pa());
        if !self.heating.is_on() {
            self.pirani.reading_pa = None;
        }
    }

    /// Sets the active part by the reading of the diaphragm, which also measures while the Pirani is off (67, 107).
    fn choose_active(&mut self) {
        let Some(pa) = self.cdg.as_ref().map(|cdg| cdg.sensor.indicated_pa()) else { return };
        let from_pa = if self.cdg_is_active { PIRANI_BELOW_PA } else { CDG_FROM_PA };
        self.cdg_is_active = pa >= from_pa || !self.heating.is_on();
    }

    /// The trip points compare the process value of the telegrams (96), also a safe value, in EXECUTING only (104).
    fn update_trip_points(&mut self) {
        let atmosphere_pa = self.atm.as_ref().filter(|atm| !atm.failed).and_then(|atm| atm.reading_pa);
        let pa = self.machine.is_executing().then(|| self.output_pa());
        for trip in &mut self.trips {
            if let Some(atmosphere_pa) = atmosphere_pa {
                trip.set_atmosphere(atmosphere_pa);
            }
            trip.evaluate(pa);
        }
    }

    /// Keeps the last valid value that was shown for Hold Last Value. With a common alarm the reading stays valid (88),
    /// but the safe value is shown.
    fn remember(&mut self) {
        for instance in 1..=3 {
            let Some(condition) = self.part(instance).map(|part| self.condition(part)) else { continue };
            if let Some(part) = self.part_mut(instance).filter(|part| !part.is_safe(&condition)) {
                part.remember(&condition);
            }
        }
    }

    /// The operator has pressed a push button, which sets a trip point to the present pressure (11.2.13).
    ///
    /// chosen: the manual does not describe the effect; without a valid pressure there is none.
    fn set_trip_point_by_button(&mut self, trip: usize) {
        let active = self.active();
        let (valid, pa) = (self.is_valid(active), self.process_value_pa(active));
        if let Some(trip) = self.trips.get_mut(trip).filter(|_| valid)
            && let Some(side) = trip.button_side()
        {
            trip.limit_mut(side).point_pa = pa;
        }
    }

    /// NET LED (3.4, 112).
    fn led(&self) -> Led {
        match () {
            () if self.has_error() => Led::Red,
            () if self.machine.is_exchanging() => Led::Green,
            () => Led::GreenFlashing,
        }
    }
}
