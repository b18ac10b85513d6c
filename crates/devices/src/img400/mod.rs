//! IMG 400 with IF 400 P: a controller for two hot cathode gauges and two others. BG 5530 BEN/A.
//!
//! [`table`] has the manual's tables, [`codes`] the code tables. `parts` has the ranges, `gauges` the gauges that can be plugged in,
//! `ion` the cathodes, `trip` the relays, `errors` the failed supplies; `parameters` reads and writes every row,
//! `simulation` has cyclic data and front panel. Numbers in brackets are those of errata-pxg55x-img400.

pub mod codes;
mod errors;
mod faults;
mod gauges;
mod ion;
mod parameters;
mod parts;
mod simulation;
pub mod table;
mod trip;

pub use gauges::{Gauges, IonGauge, OtherGauge};

use crate::model::{AccessError, DESCRIBED, Model, PartSpec, PressureFormat, Principle};
use crate::profile::{
    BlockDevice, CommonExceptions, DeviceState, ExceptionDetails, ExceptionStatus, FittedChannels, MeasuringPart,
    Presentation, ReadingCondition, SelfTestResult, Setup, StateMachine, StatusExtension, TransitionCommand,
    exception_status,
};
use crate::store::Store;
use codes::{AdjustCommand, KeyLock};
use errors::{Errors, ResetBits};
use faults::Faults;
use ion::IonCathode;
use parts::{CHANNELS, RELAYS};
use trip::TripRelay;

/// An IMG 400 with its nonvolatile memory.
pub type Img400<S> = BlockDevice<Img400Behaviour, S>;

impl<S: Store> Img400<S> {
    /// A controller that has just been switched on.
    #[must_use]
    pub fn new(store: S, setup: Setup, gauges: Gauges) -> Self {
        Self::with_model(&table::MODEL, store, setup, gauges)
    }

    /// The same for a controller whose tables a device file has, like those of the IMG 400.
    #[must_use]
    pub fn with_model(model: &'static Model, store: S, setup: Setup, gauges: Gauges) -> Self {
        Self::from_behaviour(Img400Behaviour::new(model, gauges), store, &setup)
    }
}

/// A measuring channel.
#[derive(Clone, Debug)]
struct GaugeChannel {
    /// The gauge that is plugged in.
    gauge: Option<&'static PartSpec>,
    /// The gauge that the controller assumes if it finds none (156).
    place_holder: &'static PartSpec,
    /// Whether it was found at start-up, which fixes the block of the slot until the next one (154).
    identified: bool,
    /// Whether it answers now.
    connected: bool,
    part: MeasuringPart,
}

impl GaugeChannel {
    fn new(gauge: Option<&'static PartSpec>, place_holder: &'static PartSpec) -> Self {
        let part = MeasuringPart::new(gauge.unwrap_or(place_holder));
        Self { gauge, place_holder, identified: true, connected: true, part }
    }

    /// Sets whether the gauge was found at start-up, and its block with it.
    fn identify(&mut self, found: bool) {
        self.identified = found;
        self.part.spec = self.gauge.filter(|_| found).unwrap_or(self.place_holder);
    }

    /// Whether the channel has a gauge that was found and answers.
    const fn has_gauge(&self) -> bool {
        self.gauge.is_some() && self.identified && self.connected
    }

    /// Whether the block is that of a diaphragm gauge; a place holder counts as a Pirani gauge (156).
    fn is_diaphragm(&self) -> bool {
        self.part.part().principle == Principle::Diaphragm
    }
}

/// A gauge as the tables of this controller have it: in a device file the first and the second of one principle on a channel stand for
/// those of the IMG 400.
fn gauge_like(model: &'static Model, gauge: &'static PartSpec) -> &'static PartSpec {
    if !DESCRIBED {
        return gauge;
    }
    let on_channel = |model: &'static Model| model.parts.iter().copied().filter(move |spec| spec.part == gauge.part);
    let number = on_channel(&table::MODEL).position(|spec| core::ptr::eq(spec, gauge)).unwrap_or_default();
    on_channel(model).nth(number).or_else(|| on_channel(model).next_back()).unwrap_or(gauge)
}

/// The behaviour of the IMG 400.
#[derive(Clone, Debug)]
pub struct Img400Behaviour {
    gauges: Gauges,
    fitted: FittedChannels<CHANNELS>,
    machine: StateMachine,
    presentation: Presentation,
    channels: [GaugeChannel; CHANNELS],
    ions: [IonCathode; 2],
    trips: [TripRelay; RELAYS],
    errors: Errors,
    /// Zero adjustment of each channel, in Pa.
    offsets_pa: [f64; CHANNELS],
    key_lock: KeyLock,
    /// The cyclic transition command of the last cycle.
    command: TransitionCommand,
    faults: Faults,
    /// Operating time in seconds.
    seconds: f64,
}

impl Img400Behaviour {
    fn new(model: &'static Model, gauges: Gauges) -> Self {
        let [ch1, ch2, ch3, ch4] = gauges.parts().map(|gauge| gauge.map(|gauge| gauge_like(model, gauge)));
        let channel = |gauge, place_holder| GaugeChannel::new(gauge, gauge_like(model, place_holder));
        let ion = |gauge: Option<IonGauge>| IonCathode::new(gauge.unwrap_or(IonGauge::Bag));
        Self {
            gauges,
            fitted: FittedChannels::new(gauges.parts().map(|spec| spec.map(|spec| spec.part.principle))),
            machine: StateMachine::power_up(),
            presentation: Presentation::new(model, table::FACTORY_UNIT),
            channels: [
                channel(ch1, &parts::BAG_1),
                channel(ch2, &parts::BAG_2),
                channel(ch3, &parts::TPR_3),
                channel(ch4, &parts::TPR_4),
            ],
            ions: [ion(gauges.ch1), ion(gauges.ch2)],
            trips: [const { TripRelay::FACTORY }; RELAYS],
            errors: Errors::default(),
            offsets_pa: [0.0; CHANNELS],
            key_lock: KeyLock::Off,
            command: TransitionCommand::NONE,
            faults: Faults::NONE,
            seconds: 0.0,
        }
    }

    /// The channel in this slot.
    fn channel(&self, slot: u8) -> Option<&GaugeChannel> {
        self.channels.get(usize::from(slot).checked_sub(1)?)
    }

    fn channel_mut(&mut self, slot: u8) -> Option<&mut GaugeChannel> {
        self.channels.get_mut(usize::from(slot).checked_sub(1)?)
    }

    /// The cathode in this slot.
    fn ion(&self, slot: u8) -> Option<&IonCathode> {
        self.ions.get(usize::from(slot).checked_sub(1)?)
    }

    fn ion_mut(&mut self, slot: u8) -> Option<&mut IonCathode> {
        self.ions.get_mut(usize::from(slot).checked_sub(1)?)
    }

    /// The relay in this slot, which is its number + 4 (145).
    fn trip(&self, slot: u8) -> Option<&TripRelay> {
        self.trips.get(usize::from(slot).checked_sub(5)?)
    }

    fn trip_mut(&mut self, slot: u8) -> Option<&mut TripRelay> {
        self.trips.get_mut(usize::from(slot).checked_sub(5)?)
    }

    /// COUNTS need an unsigned word (15).
    const fn format(&self) -> PressureFormat {
        PressureFormat { max_integer: parts::HIGHEST_COUNT, ..self.presentation.format(parts::COUNTS) }
    }

    /// Executes a Device Block State Command. Reset sets the volatile values to those after power-up and looks for
    /// gauges.
    fn state_command(&mut self, number: u8) -> Result<(), AccessError> {
        if self.machine.command(number)? {
            self.initialise();
        }
        Ok(())
    }

    /// Sets the volatile values to those after power-up. The current of a cathode is nonvolatile.
    fn initialise(&mut self) {
        let gauges = [self.gauges.ch1, self.gauges.ch2].map(|gauge| gauge.unwrap_or(IonGauge::Bag));
        for (ion, gauge) in self.ions.iter_mut().zip(gauges) {
            *ion = ion.restarted(gauge);
        }
        self.errors = Errors::default();
        self.key_lock = KeyLock::Off;
        let unplugged = self.unplugged();
        for (channel, unplugged) in self.channels.iter_mut().zip(unplugged) {
            channel.identify(!unplugged);
        }
    }

    /// The channels on which no gauge answers.
    const fn unplugged(&self) -> [bool; CHANNELS] {
        let faults = &self.faults;
        [
            faults.unplugged_1,
            faults.unplugged_2,
            faults.unplugged_3 || faults.sensor_3,
            faults.unplugged_4 || faults.sensor_4,
        ]
    }

    /// Advances start and self test. Without an answer from the controller the interface board stays in INIT (4.4.1).
    fn run(&mut self, seconds: f64) {
        if self.machine.state() != DeviceState::Init || !self.faults.comm {
            self.machine.advance(seconds, self.self_test());
        }
    }

    /// The result that a self test would have (4.4.1): it tests memories and internal communication.
    fn self_test(&self) -> SelfTestResult {
        SelfTestResult::found(self.common(), !self.common().is_empty())
    }

    /// Common Exception Detail 0, alike for alarms and warnings (37, 121).
    fn common(&self) -> CommonExceptions {
        let mut common = CommonExceptions::from_memory_faults(self.faults.eprom, self.faults.eeprom, self.faults.ram);
        common.set(CommonExceptions::COMMUNICATION, self.faults.comm);
        common
    }

    /// Sensor Alarm of a channel: electronics (121), overpressure, key.
    fn sensor_alarm(&self, slot: u8) -> [u8; 2] {
        let electronics = match self.errors.cathodes.get(usize::from(slot).saturating_sub(1)) {
            Some(supply) => supply.alarm,
            None => self.errors.general.alarm,
        };
        [0, u8::from(electronics) << 1 | self.ion(slot).map_or(0, IonCathode::alarm_bits)]
    }

    /// Sensor Warning of a channel: electronics, pressure too high for degas.
    fn sensor_warning(&self, slot: u8) -> [u8; 2] {
        let electronics = match self.errors.cathodes.get(usize::from(slot).saturating_sub(1)) {
            Some(supply) => supply.warning,
            None => self.errors.general.warning,
        };
        let reading = self.channel(slot).and_then(|channel| channel.part.reading_pa);
        let too_high = self.ion(slot).zip(reading).is_some_and(|(ion, pa)| ion.is_too_high_for_degas(pa));
        [0, u8::from(electronics) << 1 | u8::from(too_high) << 3]
    }

    /// Reading Valid; the range does not matter (123, 125).
    fn is_valid(&self, slot: u8) -> bool {
        self.machine.is_executing() && !self.errors.is_any() && self.sensor_alarm(slot) == [0, 0]
    }

    /// Status Extension: Reading Invalid also without a gauge and while it is off; range bits only for a reading (125).
    fn status_extension(&self, slot: u8) -> StatusExtension {
        match self.channel(slot).map(|channel| &channel.part) {
            Some(part) if part.reading_pa.is_some() => StatusExtension::new(part.range(), self.is_valid(slot)),
            _ => StatusExtension::INVALID,
        }
    }

    /// A nibble for each channel, channel 1 in the low one of the first octet (127).
    fn channel_status(&self) -> [u8; 2] {
        let [ch1, ch2, ch3, ch4] = [1, 2, 3, 4].map(|slot| self.status_extension(slot).bits());
        [ch2 << 4 | ch1, ch4 << 4 | ch3]
    }

    fn exception_status(&self) -> ExceptionStatus {
        let [a, b, c, d] = [1, 2, 3, 4].map(|slot| self.sensor_alarm(slot)[1]);
        let manufacturer = u8::from(self.errors.has_alarm());
        let alarm = ExceptionDetails { common: self.common(), device: [a, b, c, d], manufacturer };
        // Sensor Warning does not count here (126).
        let [a, b, c, d] = [1, 2, 3, 4].map(|slot| self.status_extension(slot).bits());
        let manufacturer = u8::from(self.errors.has_warning());
        exception_status(&alarm, &ExceptionDetails { common: self.common(), device: [a, b, c, d], manufacturer })
    }

    /// The conditions of all readings: a common or manufacturer alarm concerns all channels (35).
    fn condition(&self) -> ReadingCondition {
        let alarmed = !self.common().is_empty() || self.errors.has_alarm();
        ReadingCondition {
            executing: self.machine.is_executing(),
            disturbed: alarmed || self.errors.has_warning(),
            alarmed,
        }
    }

    /// Process Value of a channel, in Pa.
    fn process_value_pa(&self, slot: u8) -> f64 {
        self.channel(slot).map_or(0.0, |channel| channel.part.process_value_pa(&self.condition()))
    }

    /// The conditions of a cathode: whether it can be on, and the pressure of its gauge in Pa.
    fn conditions(&self, slot: u8) -> (bool, f64) {
        let supplied =
            self.errors.cathodes.get(usize::from(slot).saturating_sub(1)).is_some_and(|supply| !supply.alarm);
        match self.channel(slot) {
            Some(channel) => (channel.has_gauge() && supplied, channel.part.sensor.indicated_pa()),
            None => (false, 0.0),
        }
    }

    /// Updates device state, supplies, cathodes, readings, relays and last valid values, in this order.
    fn update_all(&mut self) {
        self.machine.detect(self.common());
        self.update_supplies();
        for slot in [1, 2] {
            let (able, pa) = self.conditions(slot);
            let overpressure = self.faults.overpressure;
            if let Some(ion) = self.ion_mut(slot) {
                ion.update(able, pa, overpressure);
            }
        }
        self.measure();
        self.update_relays();
        let condition = self.condition();
        for channel in self.channels.iter_mut().filter(|channel| !channel.part.failed) {
            channel.part.remember(&condition);
        }
    }

    /// Sets the errors of the supplies. The general supply feeds channels 3 and 4, so a fault of their electronics is
    /// its fault (121).
    fn update_supplies(&mut self) {
        let faults = &self.faults;
        let general = faults.power || faults.electronics_3 || faults.electronics_4;
        let cathodes = [faults.sensor_1 || faults.electronics_1, faults.sensor_2 || faults.electronics_2];
        self.errors.update(general, cathodes);
        let unplugged = self.unplugged();
        for ((channel, unplugged), offset_pa) in self.channels.iter_mut().zip(unplugged).zip(self.offsets_pa) {
            channel.connected = !unplugged;
            channel.part.sensor.offset_pa = offset_pa;
        }
    }

    /// Sets the readings: a gauge has one if it answers and is on.
    fn measure(&mut self) {
        let [ion_1, ion_2] = &self.ions;
        let supplied = !self.errors.channels_off;
        let on = [ion_1.is_on(), ion_2.is_on(), supplied, supplied];
        let failed = [1, 2, 3, 4].map(|slot| self.sensor_alarm(slot) != [0, 0]);
        for ((channel, on), failed) in self.channels.iter_mut().zip(on).zip(failed) {
            let measures = channel.has_gauge() && on;
            channel.part.reading_pa = measures.then(|| channel.part.sensor.indicated_pa());
            channel.part.failed = failed;
        }
    }

    fn update_relays(&mut self) {
        let readings = self.channels.each_ref().map(|channel| channel.part.reading_pa);
        for trip in &mut self.trips {
            let channel = usize::from(trip.channel()).saturating_sub(1);
            trip.update(readings.get(channel).copied().flatten());
        }
    }

    /// Reset Error Condition (128, 152).
    fn reset_errors(&mut self, bits: u8) {
        let bits = ResetBits::from_bits_retain(bits);
        self.errors.reset(bits);
        if bits.intersects(ResetBits::ERROR_FLAG | ResetBits::EVERYTHING) {
            self.ions.iter_mut().for_each(IonCathode::acknowledge);
        }
    }

    /// Executes an Analog Input Block Adjust Command (130, 131).
    fn adjust(&mut self, slot: u8, command: AdjustCommand) -> Result<(), AccessError> {
        let channel = self.channel(slot).filter(|channel| channel.has_gauge()).ok_or(AccessError::StateConflict)?;
        let reading = channel.part.reading_pa.map(|_| channel.part.sensor.sensed_pa);
        let offset_pa = match (channel.part.part().principle, command) {
            (Principle::Diaphragm, AdjustCommand::DisableOffset) => Some(0.0),
            // chosen: a gauge that is off has no offset to be calculated, so the present one stays.
            (Principle::Diaphragm | Principle::HotCathode, AdjustCommand::ZeroAdjust) => {
                reading.map(|sensed_pa| -sensed_pa)
            }
            _ => return Err(AccessError::StateConflict),
        };
        let target = self.offsets_pa.get_mut(usize::from(slot).saturating_sub(1)).ok_or(AccessError::UnknownSlot)?;
        *target = offset_pa.unwrap_or(*target);
        Ok(())
    }

    /// Executes a Hot Cathode Block State Command.
    fn hot_cathode_command(&mut self, slot: u8, code: u16) -> Result<(), AccessError> {
        let (able, pa) = self.conditions(slot);
        self.ion_mut(slot).ok_or(AccessError::UnknownSlot)?.command(code, able, pa)
    }
}
