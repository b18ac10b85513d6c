//! A device as the bench sees it: sensors to expose, faults to inject, a front panel to operate, a state to look at.

use profivac_dp::slave::Device;

/// How a measuring part senses pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Principle {
    /// Heat transfer.
    Pirani,
    /// Hot cathode ionisation, Bayard-Alpert or extractor.
    HotCathode,
    /// Cold cathode ionisation.
    ColdCathode,
    /// Capacitance diaphragm.
    Diaphragm,
    /// Piezo diaphragm that measures the ambient atmosphere, not the chamber.
    Atmosphere,
}

/// One measuring part of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The instance the manual gives it, or the channel of a controller, from 1.
    pub instance: u8,
    /// How it senses.
    pub principle: Principle,
}

/// What a measuring part is made for, in Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuringRange {
    /// The lowest pressure.
    pub lowest_pa: f64,
    /// The highest pressure, full scale.
    pub highest_pa: f64,
}

/// What a device does to a measuring part. What a real sensor senses depends on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Nothing: heater, emission or high voltage is off.
    Off,
    /// It is supplied.
    On,
    /// A hot cathode emits.
    Emission {
        /// In mA.
        milliamperes: f64,
        /// Degas runs.
        degas: bool,
    },
}

/// Something a person does to a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action<'a> {
    /// A fault by its name begins or ends.
    Fault {
        /// As in [`Instrument::faults`].
        name: &'a str,
        /// Begins, or ends.
        present: bool,
    },
    /// The push button of this number is pressed once.
    Button(u8),
    /// A switch or input is set.
    Switch {
        /// The switch.
        name: &'a str,
        /// Its new setting.
        value: &'a str,
    },
    /// A set point potentiometer is turned.
    Pot {
        /// `a` or `b`.
        which: char,
        /// The voltage at the connector.
        volts: f64,
    },
}

/// The device has nothing of this name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnsupportedAction {
    /// What it has instead; empty if it has no such thing at all.
    pub expected: &'static [&'static str],
}

/// What one measuring part shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartReading {
    /// As in [`Part::instance`].
    pub instance: u8,
    /// In mbar; no number while the device has no power.
    pub value_mbar: f64,
    /// Reading Valid, or status "ok" of a controller's channel.
    pub valid: bool,
}

/// How many measuring parts, relays or cathodes a report can name.
pub const REPORT_CAPACITY: usize = 8;

/// A few values of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedVec<T> {
    items: [Option<T>; REPORT_CAPACITY],
}

impl<T: Copy> Default for BoundedVec<T> {
    fn default() -> Self {
        Self { items: [None; REPORT_CAPACITY] }
    }
}

impl<T: Copy> BoundedVec<T> {
    /// Adds one; what exceeds the capacity is left out.
    pub fn push(&mut self, item: T) {
        if let Some(free) = self.items.iter_mut().find(|place| place.is_none()) {
            *free = Some(item);
        }
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.items.iter().flatten()
    }
}

impl<T: Copy> FromIterator<T> for BoundedVec<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        let mut few = Self::default();
        items.into_iter().for_each(|item| few.push(item));
        few
    }
}

/// The state of a device for people and scripts. The address and the true pressure are known elsewhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StateReport {
    /// The name of the device state, `EXECUTING` or as the manual has it.
    pub device_state: &'static str,
    /// The front panel's network light, `none` where there is none.
    pub led: &'static str,
    /// Closed relays, in the order of the manual.
    pub relays: BoundedVec<bool>,
    /// What each measuring part shows.
    pub indicated: BoundedVec<PartReading>,
    /// The instance whose value travels in the cyclic data, 0 where it is none of them.
    pub active_instance: u8,
    /// The octet Exception Status, 0 where there is none.
    pub exception_status: u8,
    /// Process values are at their safe value, or the device has no power.
    pub outputs_safe: bool,
    /// Emission of each cathode: on an IMG 400 of channels 1 and 2, fitted or not; on a TPG of the cold cathodes that are
    /// fitted, in the order of their channels.
    pub emission: BoundedVec<bool>,
    /// Degas of each cathode, in the same places.
    pub degas: BoundedVec<bool>,
    /// Operating hours.
    pub run_hours: f64,
}

impl StateReport {
    /// What the same device shows without power: each list keeps its places, with nothing closed, on or valid in them,
    /// and what is indicated is no number.
    // free choice: outputs count as safe then, for relays are open, cathodes off, and no value travels.
    #[must_use]
    pub fn without_power(&self) -> Self {
        let off = |states: &BoundedVec<bool>| states.iter().map(|_| false).collect();
        let blank = |shown: &PartReading| PartReading { instance: shown.instance, value_mbar: f64::NAN, valid: false };
        Self {
            device_state: "OFF",
            led: if self.led == "none" { "none" } else { "off" },
            relays: off(&self.relays),
            indicated: self.indicated.iter().map(blank).collect(),
            active_instance: 0,
            exception_status: 0,
            outputs_safe: true,
            emission: off(&self.emission),
            degas: off(&self.degas),
            run_hours: self.run_hours,
        }
    }
}

/// A device on the bench.
pub trait SimulatedDevice: Device {
    /// The name of the device in profivac: `bcg450`.
    fn name(&self) -> &'static str;

    /// The station address that holds from the last power-up on: the address switch, or what is stored.
    fn station_address(&self) -> u8;

    /// The measuring parts, in the order of their instances.
    fn parts(&self) -> &[Part];

    /// What a part is made for.
    fn measuring_range(&self, part: usize) -> MeasuringRange;

    /// What the device does to a part now.
    fn drive(&self, part: usize) -> Drive;

    /// What a part senses now, in Pa: its indicated pressure before the device's own adjustments. Below zero where the zero
    /// of the sensor is off; what is no number is nothing.
    fn sense(&mut self, part: usize, pa: f64);

    /// Time of the device passes: timers, degas, ignition, run hours.
    fn advance(&mut self, seconds: f64);

    /// Lets everything that settles by itself settle: self test, emission switching, filters. Timers that people wait for
    /// (degas, run hours) do not move.
    fn settle(&mut self);

    /// Power is lost (`false`) or returns. Returning starts the device as from the box, with its nonvolatile values.
    fn set_power(&mut self, on: bool);

    /// The faults the device can have.
    fn faults(&self) -> &'static [&'static str];

    /// Somebody does something to the device.
    ///
    /// # Errors
    /// [`Unknown`] when the device has nothing of that name; nothing has changed then.
    fn operate(&mut self, action: Action<'_>) -> Result<(), UnsupportedAction>;

    /// What it shows.
    fn report(&self) -> StateReport;
}
