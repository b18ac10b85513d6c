//! Virtual devices on the bench: a slave and its instrument, a power switch, and the vacuum around them.

use crate::action_text::{ActionText, UnknownName};
use profivac_client::pressure::Pressure;
use profivac_devices::model::Fault;
use profivac_devices::{Action, Drive, Principle, SimulatedDevice, StateReport, UnsupportedAction};
use profivac_dp::link::{Baud, BitTime, Listening, Station, Transmit};
use profivac_dp::slave::{Slave, SlaveState};
use profivac_vacuum::sensor::{self, Environment, REFERENCE_K, Range, Sensor};
use profivac_vacuum::{Gas, Mixture};
use profivac_wire::Telegram;

/// The longest a device is left without time, in milliseconds: the fastest thing a device does by itself (the refresh of a
/// controller's values) happens this often.
const MAX_WAIT_MS: u64 = 100;

/// Time is handed out in pieces no shorter than this, in milliseconds: nothing in a device is quicker.
const MIN_STEP_MS: u64 = 10;

/// A device answers to what its sensors indicate, and mostly soon after something has changed. Longer times pass in steps
/// that begin like this and double up to this, in s.
const FIRST_STEP_S: f64 = 0.01;
const MAX_STEP_S: f64 = 10.0;

/// What surrounds the devices, as people say it: one gas, at the temperature at which gauges are calibrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GasConditions {
    /// The true pressure in the chamber.
    pub pressure: Pressure,
    /// The pressure outside.
    pub atmosphere: Pressure,
    /// What the chamber is filled with.
    pub gas: Gas,
}

impl From<GasConditions> for Environment {
    fn from(conditions: GasConditions) -> Self {
        Self {
            gas: Mixture::pure(conditions.gas, conditions.pressure.pa()),
            atmosphere_pa: conditions.atmosphere.pa(),
            temperature_k: REFERENCE_K,
        }
    }
}

/// A slave with an instrument behind it, whichever it is.
pub trait GaugeSlave: Station + Send {
    /// The instrument.
    fn instrument(&self) -> &dyn SimulatedDevice;

    /// The instrument, to do something to it.
    fn instrument_mut(&mut self) -> &mut dyn SimulatedDevice;

    /// The station address the slave answers at.
    fn station_address(&self) -> u8;

    /// Whether it exchanges data with a master.
    fn is_exchanging(&self) -> bool;

    /// The slave forgets everything and answers at the address its instrument has now.
    fn power_up(&mut self);
}

impl<I: SimulatedDevice + Send> GaugeSlave for Slave<I> {
    fn instrument(&self) -> &dyn SimulatedDevice {
        self.device()
    }

    fn instrument_mut(&mut self) -> &mut dyn SimulatedDevice {
        self.device_mut()
    }

    fn station_address(&self) -> u8 {
        self.address()
    }

    fn is_exchanging(&self) -> bool {
        matches!(self.state(), SlaveState::DataExch(..))
    }

    fn power_up(&mut self) {
        let address = self.device().station_address();
        Self::power_up(self, address);
    }
}

/// A device that can be switched off, at a place on the bench, with a sensor for each of its measuring parts.
///
/// As it is made its sensors are ideal and everything settles at once, as a test wants it. With
/// [real sensors](Self::with_real_sensors) nothing does: they lag, drift and are noisy, filaments burn, and a self test takes
/// its time.
pub struct VirtualDevice {
    switch_address: u8,
    slave: Box<dyn GaugeSlave>,
    powered: bool,
    /// The sensor of each measuring part, and what it indicates in Pa.
    sensors: Vec<(Sensor, f64)>,
    has_real_sensors: bool,
    around: Environment,
    /// What surrounds the measuring parts that sit elsewhere, by their instances.
    part_surroundings: Vec<(u8, Environment)>,
    baud: Baud,
    /// Its time passes when somebody says so, and not with that of the bus.
    externally_timed: bool,
    /// It is connected to the bus.
    connected: bool,
    /// Up to when the device has lived through bus time.
    simulated_until: BitTime,
}

impl VirtualDevice {
    /// Puts a device on the bench and lets it settle. `place` is the address its switch is set to.
    #[must_use]
    pub fn new(unit: Box<dyn GaugeSlave>, place: u8, baud: Baud, around: impl Into<Environment>) -> Self {
        let around = around.into();
        let sensors = sensors(unit.instrument(), Sensor::ideal);
        let mut device = Self {
            switch_address: place,
            slave: unit,
            powered: true,
            sensors,
            has_real_sensors: false,
            around,
            part_surroundings: Vec::new(),
            baud,
            externally_timed: false,
            connected: true,
            simulated_until: BitTime(0),
        };
        device.settle();
        device
    }

    /// The same device with sensors as they are bought. The seed says which; sensors of one device differ from each other,
    /// and so do those of devices at two places.
    #[must_use]
    pub fn with_real_sensors(mut self, seed: u64) -> Self {
        let mut seeds = (0..).map(|part: u64| seed ^ part << 40 ^ u64::from(self.switch_address) << 32);
        let bought = |principle, range| Sensor::real(principle, range, seeds.next().unwrap_or_default());
        self.sensors = sensors(self.slave.instrument(), bought);
        self.has_real_sensors = true;
        self.sense(0.0);
        self
    }

    /// The same device, whose time passes by [`follow`](Self::follow) and not with that of the bus: so a scenario goes the
    /// same way at any speed and on any bus.
    #[must_use]
    pub fn with_external_time(mut self) -> Self {
        self.externally_timed = true;
        self
    }

    /// The vacuum around the device has changed, and so much time passes for it.
    pub fn advance_in(&mut self, around: impl Into<Environment>, seconds: f64) {
        self.around = around.into();
        if !self.has_real_sensors && self.powered {
            self.sense(0.0);
        }
        self.simulate(seconds);
    }

    /// The bus connector is pulled (`false`) or plugged again.
    pub fn set_connected(&mut self, plugged: bool) {
        self.connected = plugged;
    }

    /// Whether it exchanges data with a master.
    #[must_use]
    pub fn is_exchanging(&self) -> bool {
        self.powered && self.slave.is_exchanging()
    }

    /// The sensor of the measuring part with this instance, to do something to it.
    pub fn sensor_mut(&mut self, instance: u8) -> Option<&mut Sensor> {
        let parts = self.slave.instrument().parts();
        parts.iter().zip(&mut self.sensors).find(|(part, _)| part.instance == instance).map(|(_, (sensor, _))| sensor)
    }

    /// The address by which people name the device: the setting of its switch.
    #[must_use]
    pub const fn switch_address(&self) -> u8 {
        self.switch_address
    }

    /// The station address it answers at.
    #[must_use]
    pub fn station_address(&self) -> u8 {
        self.slave.station_address()
    }

    /// The instrument.
    #[must_use]
    pub fn instrument(&self) -> &dyn SimulatedDevice {
        self.slave.instrument()
    }

    /// The instrument, to do something to it that no bus and no line can.
    pub fn instrument_mut(&mut self) -> &mut dyn SimulatedDevice {
        self.slave.instrument_mut()
    }

    /// What the instrument shows.
    #[must_use]
    pub fn report(&self) -> StateReport {
        self.slave.instrument().report()
    }

    /// What surrounds it.
    #[must_use]
    pub const fn surroundings(&self) -> &Environment {
        &self.around
    }

    /// The vacuum around the device changes, and everything that follows by itself has followed. With real sensors this is
    /// [`surround`](Self::surround).
    pub fn settle_in(&mut self, around: impl Into<Environment>) {
        self.around = around.into();
        self.settle();
    }

    /// The vacuum around the device changes. What follows takes its time.
    pub fn set_surroundings(&mut self, around: impl Into<Environment>) {
        self.around = around.into();
        if self.powered {
            self.sense(0.0);
        }
    }

    /// From now on the measuring part of this instance sits elsewhere, or what is there changes: the sensor of a channel has a cable
    /// of its own. What follows comes with the next time that passes.
    pub fn set_part_surroundings(&mut self, instance: u8, around: impl Into<Environment>) {
        let around = around.into();
        match self.part_surroundings.iter_mut().find(|(known, _)| *known == instance) {
            Some((_, known)) => *known = around,
            None => self.part_surroundings.push((instance, around)),
        }
    }

    /// Power is switched off, or on again. Nothing happens to a device that is off already, or on.
    pub fn set_power(&mut self, on: bool) {
        if self.powered == on {
            return;
        }
        self.powered = on;
        self.slave.instrument_mut().set_power(on);
        if on {
            self.slave.power_up();
            self.settle();
        }
    }

    /// Time passes for the device alone, as many seconds as there are: not infinitely many.
    pub fn advance(&mut self, seconds: f64) {
        self.simulate(seconds);
        self.settle();
    }

    /// Somebody does something to the device.
    ///
    /// # Errors
    /// [`Unknown`] when the device has nothing of that name.
    pub fn operate(&mut self, action: Action) -> Result<(), UnsupportedAction> {
        self.slave.instrument_mut().operate(action)?;
        self.settle();
        Ok(())
    }

    /// Performs an action that a user has written in words.
    ///
    /// # Errors
    /// [`UnknownName`] when the device does not have the fault or control, or the control not the position.
    pub fn operate_text(&mut self, text: ActionText<'_>) -> Result<(), UnknownName> {
        let action = text.resolve(self.slave.instrument())?;
        // The device has it: `resolve` has looked.
        let _ = self.operate(action);
        Ok(())
    }

    /// The sensors take the pressure around them, and with ideal ones everything that follows by itself follows.
    fn settle(&mut self) {
        if self.powered {
            self.sense(0.0);
            if !self.has_real_sensors {
                self.slave.instrument_mut().settle();
            }
        }
    }

    /// Time passes for sensors and device; without power for the sensors alone.
    fn simulate(&mut self, seconds: f64) {
        if !self.has_real_sensors {
            self.advance_instrument(seconds);
            return;
        }
        let (mut left, mut step) = (seconds, FIRST_STEP_S);
        while left > 0.0 {
            let now = left.min(step);
            self.sense(now);
            self.advance_instrument(now);
            left -= now;
            step = (2.0 * step).min(MAX_STEP_S);
        }
    }

    fn advance_instrument(&mut self, seconds: f64) {
        if self.powered {
            self.slave.instrument_mut().advance(seconds);
        }
    }

    /// Time passes for the sensors as the device drives them, and then it is told what they indicate.
    fn sense(&mut self, seconds: f64) {
        let instrument = self.slave.instrument_mut();
        for (part, (sensor, pa)) in self.sensors.iter_mut().enumerate() {
            let own = instrument.parts().get(part).map(|part| part.instance);
            let elsewhere = self.part_surroundings.iter().find(|(instance, _)| Some(*instance) == own);
            let around = elsewhere.map_or(&self.around, |(_, around)| around);
            *pa = sensor.read(around, drive(instrument.drive(part)), seconds);
        }
        for (part, (sensor, pa)) in self.sensors.iter_mut().enumerate() {
            if self.powered {
                instrument.sense(part, *pa);
            }
            if sensor.filament_mut().is_some_and(sensor::Filament::has_just_broken) {
                break_sensor(instrument, part);
            }
        }
    }

    /// The device lives through bus time up to `now`.
    fn simulate_until(&mut self, now: BitTime) {
        let tbit = now - self.simulated_until;
        if tbit < self.baud.tbit_of_ms(MIN_STEP_MS) {
            return;
        }
        self.simulated_until = now;
        if !self.externally_timed {
            self.simulate(tbit as f64 / f64::from(self.baud.bits_per_second()));
        }
    }
}

/// A sensor for each measuring part.
fn sensors(
    instrument: &dyn SimulatedDevice,
    mut make: impl FnMut(sensor::Principle, Range) -> Sensor,
) -> Vec<(Sensor, f64)> {
    let sensor = |(part, of): (usize, &profivac_devices::Part)| {
        let span = instrument.measuring_range(part);
        (make(principle(of.principle), Range { lowest_pa: span.lowest_pa, highest_pa: span.highest_pa }), 0.0)
    };
    instrument.parts().iter().enumerate().map(sensor).collect()
}

/// A sensor has come to its end: the fault that the device has for it.
fn break_sensor(instrument: &mut dyn SimulatedDevice, part: usize) {
    let instance = instrument.parts().get(part).map(|part| part.instance);
    let Some(fault) = instance.and_then(Fault::of_sensor) else { return };
    // Every device with a cathode has this fault; a device without it ignores the action.
    let _ = instrument.operate(Action::Fault { fault, active: true });
}

/// Devices and sensors are of one rank and know nothing of each other.
const fn principle(principle: Principle) -> sensor::Principle {
    match principle {
        Principle::Pirani => sensor::Principle::Pirani,
        Principle::HotCathode => sensor::Principle::HotCathode,
        Principle::ColdCathode => sensor::Principle::ColdCathode,
        Principle::Diaphragm => sensor::Principle::Diaphragm,
        Principle::Atmosphere => sensor::Principle::Atmosphere,
    }
}

const fn drive(drive: Drive) -> sensor::Drive {
    match drive {
        Drive::Off => sensor::Drive::Off,
        Drive::On => sensor::Drive::On,
        Drive::Emission { milliamperes, degas } => sensor::Drive::Emission { milliamperes, degas },
    }
}

impl Station for VirtualDevice {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        self.simulate_until(end);
        if self.powered && self.connected { self.slave.telegram(end, telegram) } else { None }
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        self.simulate_until(now);
        if self.powered { self.slave.poll(now).filter(|_| self.connected) } else { None }
    }

    fn wake_at(&self) -> Option<BitTime> {
        let tick = self.simulated_until + self.baud.tbit_of_ms(MAX_WAIT_MS);
        let own = self.slave.wake_at().filter(|_| self.powered);
        Some(own.map_or(tick, |own| own.min(tick)))
    }

    fn listening(&self) -> Listening {
        self.slave.listening()
    }
}
