//! Virtual devices on the bench: a slave and its instrument, a power switch, and the vacuum around them.

use crate::pressure::Pressure;
use profivac_devices::{Action, Instrument, Principle, Report, Unknown};
use profivac_dp::link::{Baud, BitTime, Listening, Station, Transmit};
use profivac_dp::slave::Slave;
use profivac_vacuum::Gas;
use profivac_wire::Telegram;

/// The longest a device is left without time, in milliseconds: the fastest thing a device does by itself (the refresh of a
/// controller's values) happens this often.
const TICK_MS: u64 = 100;

/// Time is handed out in pieces no shorter than this, in milliseconds: nothing in a device is quicker.
const GRAIN_MS: u64 = 10;

/// What surrounds the devices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// The true pressure in the chamber.
    pub pressure: Pressure,
    /// The pressure outside.
    pub atmosphere: Pressure,
    /// What the chamber is filled with.
    pub gas: Gas,
}

impl Conditions {
    /// What a sensor without an error of its own indicates, in Pa.
    fn indicated_pa(&self, principle: Principle) -> f64 {
        match principle {
            Principle::Atmosphere => self.atmosphere.pa(),
            Principle::Diaphragm => self.pressure.pa(),
            Principle::Pirani => self.pressure.pa() / self.gas.pirani_factor(),
            Principle::HotCathode | Principle::ColdCathode => self.pressure.pa() / self.gas.ion_factor(),
        }
    }
}

/// A slave with an instrument behind it, whichever it is.
pub trait Unit: Station + Send {
    /// The instrument.
    fn instrument(&self) -> &dyn Instrument;

    /// The instrument, to do something to it.
    fn instrument_mut(&mut self) -> &mut dyn Instrument;

    /// The station address the slave answers at.
    fn station_address(&self) -> u8;

    /// The slave forgets everything and answers at the address its instrument has now.
    fn power_up(&mut self);
}

impl<I: Instrument + Send> Unit for Slave<I> {
    fn instrument(&self) -> &dyn Instrument {
        self.device()
    }

    fn instrument_mut(&mut self) -> &mut dyn Instrument {
        self.device_mut()
    }

    fn station_address(&self) -> u8 {
        self.address()
    }

    fn power_up(&mut self) {
        let address = self.device().station_address();
        Self::power_up(self, address);
    }
}

/// A device that can be switched off, at a place on the bench.
pub struct VirtualDevice {
    place: u8,
    unit: Box<dyn Unit>,
    powered: bool,
    conditions: Conditions,
    baud: Baud,
    /// Up to when the device has lived through bus time.
    lived: BitTime,
}

impl VirtualDevice {
    /// Puts a device on the bench and lets it settle. `place` is the address its switch is set to.
    #[must_use]
    pub fn new(unit: Box<dyn Unit>, place: u8, baud: Baud, conditions: Conditions) -> Self {
        let mut device = Self { place, unit, powered: true, conditions, baud, lived: BitTime(0) };
        device.settle();
        device
    }

    /// The address by which people name the device: the setting of its switch.
    #[must_use]
    pub const fn place(&self) -> u8 {
        self.place
    }

    /// The station address it answers at.
    #[must_use]
    pub fn station_address(&self) -> u8 {
        self.unit.station_address()
    }

    /// The instrument.
    #[must_use]
    pub fn instrument(&self) -> &dyn Instrument {
        self.unit.instrument()
    }

    /// What the instrument shows.
    #[must_use]
    pub fn report(&self) -> Report {
        self.unit.instrument().report()
    }

    /// The vacuum around the device changes, and everything that follows by itself has followed.
    pub fn expose(&mut self, conditions: Conditions) {
        self.conditions = conditions;
        self.settle();
    }

    /// The vacuum around the device changes. What follows takes its time.
    pub fn surround(&mut self, conditions: Conditions) {
        self.conditions = conditions;
        self.sense();
    }

    /// Power is switched off, or on again. Nothing happens to a device that is off already, or on.
    pub fn power(&mut self, on: bool) {
        if self.powered == on {
            return;
        }
        self.powered = on;
        self.unit.instrument_mut().power(on);
        if on {
            self.unit.power_up();
            self.settle();
        }
    }

    /// Time passes for the device alone.
    pub fn advance(&mut self, seconds: f64) {
        if self.powered {
            self.unit.instrument_mut().advance(seconds);
            self.settle();
        }
    }

    /// Somebody does something to the device.
    ///
    /// # Errors
    /// [`Unknown`] when the device has nothing of that name.
    pub fn operate(&mut self, action: Action<'_>) -> Result<(), Unknown> {
        self.unit.instrument_mut().operate(action)?;
        self.settle();
        Ok(())
    }

    /// The sensors take the pressure around them, and everything that follows by itself follows.
    fn settle(&mut self) {
        if self.powered {
            self.sense();
            self.unit.instrument_mut().settle();
        }
    }

    fn sense(&mut self) {
        let conditions = self.conditions;
        let instrument = self.unit.instrument_mut();
        for part in 0..instrument.parts().len() {
            if let Some(principle) = instrument.parts().get(part).map(|part| part.principle) {
                instrument.sense(part, conditions.indicated_pa(principle));
            }
        }
    }

    /// The device lives through bus time up to `now`.
    fn live(&mut self, now: BitTime) {
        let tbit = now - self.lived;
        if tbit < self.baud.tbit_of_ms(GRAIN_MS) {
            return;
        }
        let seconds = tbit as f64 / f64::from(self.baud.bits_per_second());
        self.lived = now;
        if self.powered {
            self.unit.instrument_mut().advance(seconds);
        }
    }
}

impl Station for VirtualDevice {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        self.live(end);
        if self.powered { self.unit.telegram(end, telegram) } else { None }
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        self.live(now);
        if self.powered { self.unit.poll(now) } else { None }
    }

    fn wake_at(&self) -> Option<BitTime> {
        let tick = self.lived + self.baud.tbit_of_ms(TICK_MS);
        let own = self.unit.wake_at().filter(|_| self.powered);
        Some(own.map_or(tick, |own| own.min(tick)))
    }

    fn listening(&self) -> Listening {
        self.unit.listening()
    }
}
