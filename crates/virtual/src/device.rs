//! A virtual device: a slave with its simulated gauge, a power switch, and the vacuum around it.

use crate::action_text::{ActionText, UnknownName};
use profivac_client::pressure::Pressure;
use profivac_devices::model::{Fault, MeasuringRange, Part};
use profivac_devices::{Action, Drive, Principle, SimulatedDevice, StateReport, UnsupportedAction};
use profivac_dp::link::{Baud, BitTime, Listening, Station, Transmit};
use profivac_dp::slave::Slave;
use profivac_vacuum::sensor::{self, Environment, GasExchange, REFERENCE_K, Range, Sensor};
use profivac_vacuum::{Gas, Mixture};
use profivac_wire::Telegram;

/// The longest interval between two steps of a device, in milliseconds: the fastest periodic action of a device, the
/// refresh of a controller's values, has this period.
const MAX_WAIT_MS: u64 = 100;

/// The shortest step of simulated time, in milliseconds: no device reacts faster.
const MIN_STEP_MS: u64 = 10;

/// A device reacts to its sensors mostly soon after a change. A long interval is simulated in steps that begin with the
/// first duration and double up to the second, in s.
const FIRST_STEP_S: f64 = 0.01;
const MAX_STEP_S: f64 = 10.0;

/// The environment of the devices: one gas at the temperature at which gauges are calibrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GasConditions {
    /// The true pressure in the chamber.
    pub pressure: Pressure,
    /// The pressure outside.
    pub atmosphere: Pressure,
    /// The gas in the chamber.
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

/// A slave with any simulated device.
pub trait GaugeSlave: Station + Send {
    /// The simulated device.
    fn device(&self) -> &dyn SimulatedDevice;

    /// The simulated device, mutable.
    fn device_mut(&mut self) -> &mut dyn SimulatedDevice;

    /// The station address of the slave.
    fn station_address(&self) -> u8;

    /// Whether it exchanges data with a master.
    fn is_exchanging(&self) -> bool;

    /// Resets the slave to its power-on state, at the address that its device stores.
    fn power_up(&mut self);
}

impl<I: SimulatedDevice + Send> GaugeSlave for Slave<I> {
    fn device(&self) -> &dyn SimulatedDevice {
        self.device()
    }

    fn device_mut(&mut self) -> &mut dyn SimulatedDevice {
        self.device_mut()
    }

    fn station_address(&self) -> u8 {
        self.address()
    }

    fn is_exchanging(&self) -> bool {
        self.state().is_exchanging()
    }

    fn power_up(&mut self) {
        let address = self.device().station_address();
        Self::power_up(self, address);
    }
}

/// A virtual device with a power switch and a sensor for each of its measuring parts.
///
/// Initially its sensors are ideal and every process settles at once, as tests need it. With [real
/// sensors](Self::with_real_sensors) they lag, drift and are noisy, filaments burn out, and a self test takes time.
pub struct VirtualDevice {
    switch_address: u8,
    slave: Box<dyn GaugeSlave>,
    powered: bool,
    /// The sensor of each measuring part, and its indication in Pa.
    sensors: Vec<(Sensor, f64)>,
    has_real_sensors: bool,
    around: Environment,
    /// The environment of measuring parts outside the common chamber, by instance.
    part_environments: Vec<(u8, Environment)>,
    baud: Baud,
    /// Its time is advanced by the caller and not by the bus.
    externally_timed: bool,
    /// It is connected to the bus.
    connected: bool,
    /// The bus time up to which the device was simulated.
    simulated_until: BitTime,
}

impl VirtualDevice {
    /// A device in its environment, settled. `address` is the setting of its address switch.
    #[must_use]
    pub fn new(slave: Box<dyn GaugeSlave>, address: u8, baud: Baud, around: impl Into<Environment>) -> Self {
        let around = around.into();
        let sensors = sensors(slave.device(), Sensor::ideal);
        let mut device = Self {
            switch_address: address,
            slave,
            powered: true,
            sensors,
            has_real_sensors: false,
            around,
            part_environments: Vec::new(),
            baud,
            externally_timed: false,
            connected: true,
            simulated_until: BitTime(0),
        };
        device.settle();
        device
    }

    /// The same device with real sensors. The seed, the address switch and the part determine the deviations of each
    /// sensor.
    #[must_use]
    pub fn with_real_sensors(mut self, seed: u64) -> Self {
        let mut seeds = (0..).map(|part: u64| seed ^ part << 40 ^ u64::from(self.switch_address) << 32);
        let real = |principle, range| Sensor::real(principle, range, seeds.next().unwrap_or_default());
        self.sensors = sensors(self.slave.device(), real);
        self.has_real_sensors = true;
        self.sense(0.0);
        self
    }

    /// The same device with its time advanced by [`advance_in`](Self::advance_in) and not by the bus, so that a scenario
    /// takes the same course at any speed and on any bus.
    #[must_use]
    pub fn with_external_time(mut self) -> Self {
        self.externally_timed = true;
        self
    }

    /// Changes the environment and advances the device by `seconds`.
    pub fn advance_in(&mut self, around: impl Into<Environment>, seconds: f64) {
        self.around = around.into();
        if !self.has_real_sensors && self.powered {
            self.sense(0.0);
        }
        self.simulate(seconds);
    }

    /// Connects the device to the bus or disconnects it.
    pub fn set_connected(&mut self, connected: bool) {
        self.connected = connected;
    }

    /// Whether the device has power and is connected to the bus.
    #[must_use]
    pub const fn is_present(&self) -> bool {
        self.powered && self.connected
    }

    /// Whether it exchanges data with a master.
    #[must_use]
    pub fn is_exchanging(&self) -> bool {
        self.powered && self.slave.is_exchanging()
    }

    /// The sensor of the measuring part with this instance.
    pub fn sensor_mut(&mut self, instance: u8) -> Option<&mut Sensor> {
        let parts = self.slave.device().parts();
        parts.iter().zip(&mut self.sensors).find(|(part, _)| part.instance == instance).map(|(_, (sensor, _))| sensor)
    }

    /// The setting of the address switch, by which the user names the device.
    #[must_use]
    pub const fn switch_address(&self) -> u8 {
        self.switch_address
    }

    /// The station address.
    #[must_use]
    pub fn station_address(&self) -> u8 {
        self.slave.station_address()
    }

    /// The simulated device.
    #[must_use]
    pub fn device(&self) -> &dyn SimulatedDevice {
        self.slave.device()
    }

    /// The measuring parts with their ranges.
    pub fn ranges(&self) -> impl Iterator<Item = (Part, MeasuringRange)> + '_ {
        let device = self.device();
        device.parts().iter().enumerate().map(|(at, part)| (*part, device.measuring_range(at)))
    }

    /// The simulated device, for operations that need no bus.
    pub fn device_mut(&mut self) -> &mut dyn SimulatedDevice {
        self.slave.device_mut()
    }

    /// The state of the device.
    #[must_use]
    pub fn report(&self) -> StateReport {
        self.slave.device().report()
    }

    /// The environment.
    #[must_use]
    pub const fn environment(&self) -> &Environment {
        &self.around
    }

    /// Changes the environment and settles. With real sensors the same as [`set_environment`](Self::set_environment).
    pub fn settle_in(&mut self, around: impl Into<Environment>) {
        self.around = around.into();
        self.settle();
    }

    /// Changes the environment. The device reacts in its own time.
    pub fn set_environment(&mut self, around: impl Into<Environment>) {
        self.around = around.into();
        if self.powered {
            self.sense(0.0);
        }
    }

    /// Changes the environment of one measuring part: the sensor of a channel has a cable of its own. Takes effect with
    /// the next step.
    pub fn set_part_environment(&mut self, instance: u8, around: impl Into<Environment>) {
        let around = around.into();
        match self.part_environments.iter_mut().find(|(known, _)| *known == instance) {
            Some((_, known)) => *known = around,
            None => self.part_environments.push((instance, around)),
        }
    }

    /// The gas that each measuring part releases and pumps, by instance.
    pub fn gas_exchanges(&self) -> impl Iterator<Item = (u8, GasExchange)> {
        let simulated = self.slave.device();
        let parts = simulated.parts().iter().zip(&self.sensors).enumerate();
        parts.map(move |(part, (of, (sensor, _)))| {
            let driven = if self.powered { drive(simulated.drive(part)) } else { sensor::Drive::Off };
            (of.instance, sensor.gas_exchange(self.around_part(of.instance), driven))
        })
    }

    /// The environment of the measuring part with this instance.
    fn around_part(&self, instance: u8) -> &Environment {
        let elsewhere = self.part_environments.iter().find(|(known, _)| *known == instance);
        elsewhere.map_or(&self.around, |(_, around)| around)
    }

    /// Switches the power on or off. No effect if it is already in that state.
    pub fn set_power(&mut self, on: bool) {
        if self.powered == on {
            return;
        }
        self.powered = on;
        self.slave.device_mut().set_power(on);
        if on {
            self.slave.power_up();
            self.settle();
        }
    }

    /// Advances the device by a finite number of seconds.
    pub fn advance(&mut self, seconds: f64) {
        self.simulate(seconds);
        self.settle();
    }

    /// Operates the device: a fault, a button, a switch, a potentiometer.
    ///
    /// # Errors
    /// [`UnsupportedAction`] when the device does not have it.
    pub fn operate(&mut self, action: Action) -> Result<(), UnsupportedAction> {
        self.slave.device_mut().operate(action)?;
        self.settle();
        Ok(())
    }

    /// Performs an action that a user has written as text.
    ///
    /// # Errors
    /// [`UnknownName`] when the device does not have the fault or control, or the control not the position.
    pub fn operate_text(&mut self, text: ActionText<'_>) -> Result<(), UnknownName> {
        let action = text.resolve(self.slave.device())?;
        // `resolve` has checked that the device has it.
        let _ = self.operate(action);
        Ok(())
    }

    /// Updates the sensors; with ideal sensors, also completes every process.
    fn settle(&mut self) {
        if self.powered {
            self.sense(0.0);
            if !self.has_real_sensors {
                self.slave.device_mut().settle();
            }
        }
    }

    /// Advances sensors and device. Without power only the sensors.
    fn simulate(&mut self, seconds: f64) {
        if !self.has_real_sensors {
            self.advance_device(seconds);
            return;
        }
        let (mut left, mut step) = (seconds, FIRST_STEP_S);
        while left > 0.0 {
            let now = left.min(step);
            self.sense(now);
            self.advance_device(now);
            left -= now;
            step = (2.0 * step).min(MAX_STEP_S);
        }
    }

    fn advance_device(&mut self, seconds: f64) {
        if self.powered {
            self.slave.device_mut().advance(seconds);
        }
    }

    /// Advances the sensors with the drive of the device, then passes their indications to the device.
    fn sense(&mut self, seconds: f64) {
        let simulated = self.slave.device_mut();
        for (part, (sensor, pa)) in self.sensors.iter_mut().enumerate() {
            let own = simulated.parts().get(part).map(|part| part.instance);
            let elsewhere = self.part_environments.iter().find(|(instance, _)| Some(*instance) == own);
            let around = elsewhere.map_or(&self.around, |(_, around)| around);
            *pa = sensor.read(around, drive(simulated.drive(part)), seconds);
        }
        for (part, (sensor, pa)) in self.sensors.iter_mut().enumerate() {
            if self.powered {
                simulated.sense(part, *pa);
            }
            if sensor.filament_mut().is_some_and(sensor::Filament::has_just_broken) {
                break_sensor(simulated, part);
            }
        }
    }

    /// Simulates the device up to the bus time `now`.
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
    simulated: &dyn SimulatedDevice,
    mut make: impl FnMut(sensor::Principle, Range) -> Sensor,
) -> Vec<(Sensor, f64)> {
    let sensor = |(part, of): (usize, &profivac_devices::Part)| {
        let span = simulated.measuring_range(part);
        (make(principle(of.principle), Range { lowest_pa: span.lowest_pa, highest_pa: span.highest_pa }), 0.0)
    };
    simulated.parts().iter().enumerate().map(sensor).collect()
}

/// Sets the fault of a sensor that has failed.
fn break_sensor(simulated: &mut dyn SimulatedDevice, part: usize) {
    let instance = simulated.parts().get(part).map(|part| part.instance);
    let Some(fault) = instance.and_then(Fault::of_sensor) else { return };
    // Every device with a cathode has this fault; a device without it ignores the action.
    let _ = simulated.operate(Action::Fault { fault, active: true });
}

/// The crates of devices and sensors do not depend on each other, so their types are converted here.
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
