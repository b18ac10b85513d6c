//! A device without hardware: sensors to drive, faults to inject, a front panel to operate, a state to report.

use crate::model::{Fault, FaultList, MeasuringRange, Part};
use crate::store::Key;
use core::fmt;
use profivac_dp::slave::Device;

/// How the device drives a measuring part. The pressure that a real sensor senses depends on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Heater, emission or high voltage is off.
    Off,
    /// The part is supplied.
    On,
    /// A hot cathode emits.
    Emission {
        /// The emission current in mA.
        milliamperes: f64,
        /// Degas runs.
        degas: bool,
    },
}

/// An operation on a simulated device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// A fault begins or ends.
    Fault {
        /// The fault.
        fault: Fault,
        /// It begins (`true`) or ends.
        active: bool,
    },
    /// The push button of this number, from 1, is pressed once.
    Button(u8),
    /// A switch or an input is set.
    Switch(Switch),
    /// The potentiometer of a set point is turned.
    Potentiometer {
        /// The potentiometer.
        potentiometer: Potentiometer,
        /// The voltage at the connector.
        volts: f64,
    },
}

/// A switch or an input of a device with its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switch {
    /// The address switches; above 125 the stored address holds.
    Address(u8),
    /// The degas input at pin 7 of the connector, active (`true`) or not.
    Degas(bool),
    /// The rotary switch LOW-HIGH of an HPG400-SP, 0 to 9.
    LowHigh(u8),
    /// The rotary switch CAL ADJ of an HPG400-SP, 0 to 9.
    CalAdj(u8),
}

/// The name of a switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SwitchName {
    /// [`Switch::Address`]
    Address,
    /// [`Switch::Degas`]
    Degas,
    /// [`Switch::LowHigh`]
    LowHigh,
    /// [`Switch::CalAdj`]
    CalAdj,
}

impl Switch {
    /// The name of the switch.
    #[must_use]
    pub const fn name(self) -> SwitchName {
        match self {
            Self::Address(_) => SwitchName::Address,
            Self::Degas(_) => SwitchName::Degas,
            Self::LowHigh(_) => SwitchName::LowHigh,
            Self::CalAdj(_) => SwitchName::CalAdj,
        }
    }

    /// Whether the switch has this position.
    #[must_use]
    pub fn is_valid(self) -> bool {
        match self {
            Self::Address(_) | Self::Degas(_) => true,
            Self::LowHigh(position) | Self::CalAdj(position) => ROTARY_POSITIONS.contains(&position),
        }
    }
}

/// The positions of a rotary switch.
const ROTARY_POSITIONS: core::ops::RangeInclusive<u8> = 0..=9;

impl SwitchName {
    /// All switches.
    pub const ALL: [Self; 4] = [Self::Address, Self::Degas, Self::LowHigh, Self::CalAdj];

    /// The name in words: `low-high`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Address => "address",
            Self::Degas => "degas",
            Self::LowHigh => "low-high",
            Self::CalAdj => "cal-adj",
        }
    }

    /// The switch with this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|switch| switch.name() == name)
    }

    /// The switch at the position that `text` names; `None` for a text that is no position of it.
    #[must_use]
    pub fn at_position(self, text: &str) -> Option<Switch> {
        let switch = match (self, text) {
            (Self::Address, _) => Switch::Address(text.parse().ok()?),
            (Self::Degas, "on") => Switch::Degas(true),
            (Self::Degas, "off") => Switch::Degas(false),
            (Self::Degas, _) => return None,
            (Self::LowHigh, _) => Switch::LowHigh(text.parse().ok()?),
            (Self::CalAdj, _) => Switch::CalAdj(text.parse().ok()?),
        };
        Some(switch).filter(|switch| switch.is_valid())
    }

    /// The texts that [`at_position`](Self::at_position) accepts.
    #[must_use]
    pub const fn positions(self) -> &'static [&'static str] {
        match self {
            Self::Address => &["0 ... 255"],
            Self::Degas => &["on", "off"],
            Self::LowHigh | Self::CalAdj => &["0 ... 9"],
        }
    }
}

/// The potentiometer of a set point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Potentiometer {
    /// Set point A.
    A,
    /// Set point B.
    B,
}

impl Potentiometer {
    /// The name in words: `a`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::A => "a",
            Self::B => "b",
        }
    }

    /// The potentiometer with this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::A, Self::B].into_iter().find(|potentiometer| potentiometer.name() == name)
    }
}

/// The controls of a device.
#[derive(Debug, PartialEq, Eq)]
pub struct FrontPanel {
    /// The names of the switches and inputs.
    pub switches: &'static [SwitchName],
    /// The number of push buttons.
    pub buttons: u8,
    /// The names of the potentiometers.
    pub potentiometers: &'static [Potentiometer],
}

/// The device has no such fault, button, switch or potentiometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnsupportedAction {
    /// The action that was asked for.
    pub action: Action,
}

impl fmt::Display for UnsupportedAction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.action {
            Action::Fault { fault, .. } => write!(f, "the device has no fault {}", fault.name()),
            Action::Button(number) => write!(f, "the device has no button {number}"),
            Action::Switch(switch) => write!(f, "the device has no switch {}", switch.name().name()),
            Action::Potentiometer { potentiometer, .. } => {
                write!(f, "the device has no potentiometer {}", potentiometer.name())
            }
        }
    }
}

impl core::error::Error for UnsupportedAction {}

/// The reading of one measuring part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartReading {
    /// As in [`Part::instance`].
    pub instance: u8,
    /// In mbar; not a number while the device has no power.
    pub value_mbar: f64,
    /// Reading Valid, or status "ok" of a controller's channel.
    pub valid: bool,
}

/// How many measuring parts, relays or cathodes a report can name.
pub const REPORT_CAPACITY: usize = 8;

/// Up to [`REPORT_CAPACITY`] values of one kind.
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
    /// Appends an item; drops it when the capacity is reached.
    pub fn push(&mut self, item: T) {
        if let Some(free) = self.items.iter_mut().find(|place| place.is_none()) {
            *free = Some(item);
        }
    }

    /// The items, in order.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.items.iter().flatten()
    }
}

impl<T: Copy> FromIterator<T> for BoundedVec<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        let mut vec = Self::default();
        items.into_iter().for_each(|item| vec.push(item));
        vec
    }
}

/// The device state in a report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum ReportedState {
    /// The device has no states.
    #[default]
    None,
    /// The device has no power.
    Off,
    /// Starting.
    Init,
    /// Self test.
    SelfTesting,
    /// Ready, not measuring.
    Idle,
    /// The self test has found a fault.
    SelfTestException,
    /// Measuring.
    Executing,
    /// Stopped by command.
    Abort,
    /// Not able to work.
    CriticalFault,
}

impl ReportedState {
    /// All states.
    pub const ALL: [Self; 9] = [
        Self::None,
        Self::Off,
        Self::Init,
        Self::SelfTesting,
        Self::Idle,
        Self::SelfTestException,
        Self::Executing,
        Self::Abort,
        Self::CriticalFault,
    ];

    /// The name in the state diagram: `EXECUTING`; `OFF` without power, `none` without states.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Off => "OFF",
            Self::Init => "INIT",
            Self::SelfTesting => "SELFTESTING",
            Self::Idle => "IDLE",
            Self::SelfTestException => "SELFTESTEXCEPTION",
            Self::Executing => "EXECUTING",
            Self::Abort => "ABORT",
            Self::CriticalFault => "CRITICALFAULT",
        }
    }

    /// The state with this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.name() == name)
    }
}

/// The network light of the front panel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Led {
    /// The device has none.
    #[default]
    None,
    /// Dark: no power.
    Off,
    /// Red.
    Red,
    /// Green.
    Green,
    /// Green, flashing.
    GreenFlashing,
}

impl Led {
    /// The name for users: `green flashing`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Off => "off",
            Self::Red => "red",
            Self::Green => "green",
            Self::GreenFlashing => "green flashing",
        }
    }
}

/// The state of a device for users and scripts. The device does not know its address on the bus and the true pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StateReport {
    /// The device state.
    pub device_state: ReportedState,
    /// The network light of the front panel.
    pub led: Led,
    /// Closed relays, in the order of the manual.
    pub relays: BoundedVec<bool>,
    /// The reading of each measuring part.
    pub indicated: BoundedVec<PartReading>,
    /// The instance whose value is in the cyclic data, 0 where it is that of no single instance.
    pub active_instance: u8,
    /// The octet Exception Status, 0 for a device without it.
    pub exception_status: u8,
    /// Process values are at their safe value, or the device has no power.
    pub outputs_safe: bool,
    /// Emission of each cathode: on an IMG 400 of channels 1 and 2, fitted or not; on a TPG of the cold cathodes that
    /// are fitted, in the order of their channels.
    pub emission: BoundedVec<bool>,
    /// Degas of each cathode, in the same order.
    pub degas: BoundedVec<bool>,
    /// Operating hours.
    pub run_hours: f64,
}

impl StateReport {
    /// The report of the same device without power: each list keeps its length, with nothing closed, on or valid in it,
    /// and readings are not numbers.
    // free choice: outputs count as safe then, for relays are open, cathodes off, and no value is sent.
    #[must_use]
    pub fn without_power(&self) -> Self {
        let off = |states: &BoundedVec<bool>| states.iter().map(|_| false).collect();
        let blank =
            |reading: &PartReading| PartReading { instance: reading.instance, value_mbar: f64::NAN, valid: false };
        Self {
            device_state: ReportedState::Off,
            led: if self.led == Led::None { Led::None } else { Led::Off },
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

/// A device that a simulation drives: a [`Device`] on the bus with its sensors, front panel and power supply.
pub trait SimulatedDevice: Device {
    /// The name of the model: `bcg450`.
    fn name(&self) -> &'static str;

    /// The station address that holds from the next power-up on: that of the address switch, or the stored one.
    fn station_address(&self) -> u8;

    /// The measuring parts, in the order of their instances.
    fn parts(&self) -> &[Part];

    /// The measuring range of a part.
    fn measuring_range(&self, part: usize) -> MeasuringRange;

    /// How the device drives a part now.
    fn drive(&self, part: usize) -> Drive;

    /// Sets the pressure that a part senses, in Pa: its indicated pressure before the device's own adjustments. Below
    /// zero where the zero of the sensor is off; NaN counts as 0.
    fn sense(&mut self, part: usize, pa: f64);

    /// Advances the time of the device: timers, degas, ignition, run hours.
    fn advance(&mut self, seconds: f64);

    /// Completes self test, emission switching and filters at once. Timers that a user waits for (degas, run hours) do
    /// not move.
    fn settle(&mut self);

    /// Switches the power off or on. Switched on, the device starts with its nonvolatile values.
    fn set_power(&mut self, on: bool);

    /// Calls `found` with the key of each value of the nonvolatile memory that the device does not take at power-up, because the
    /// parameter cannot have it; its default holds. Keys that the device does not have are not looked at.
    fn refused_values(&self, found: &mut dyn FnMut(Key));

    /// The faults that the device can have.
    fn faults(&self) -> &'static FaultList;

    /// The controls that the device has.
    fn front_panel(&self) -> FrontPanel;

    /// Performs an action.
    ///
    /// # Errors
    /// [`UnsupportedAction`] when the device does not have the fault or control; it has not changed then.
    fn operate(&mut self, action: Action) -> Result<(), UnsupportedAction>;

    /// The state that the device shows.
    fn report(&self) -> StateReport;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_switch_takes_the_texts_of_its_positions_only() {
        for (name, text, switch) in [
            (SwitchName::Address, "17", Some(Switch::Address(17))),
            (SwitchName::Address, "255", Some(Switch::Address(255))),
            (SwitchName::Degas, "on", Some(Switch::Degas(true))),
            (SwitchName::Degas, "off", Some(Switch::Degas(false))),
            (SwitchName::LowHigh, "0", Some(Switch::LowHigh(0))),
            (SwitchName::CalAdj, "9", Some(Switch::CalAdj(9))),
            (SwitchName::Address, "256", None),
            (SwitchName::Address, "300", None),
            (SwitchName::Address, "-1", None),
            (SwitchName::Address, "7D hex", None),
            (SwitchName::Address, "", None),
            (SwitchName::Degas, "24V", None),
        ] {
            assert_eq!(name.at_position(text), switch, "{} {text}", name.name());
        }
        for text in ["10", "-1", "", "LOW", "255", "256"] {
            assert_eq!(SwitchName::LowHigh.at_position(text), None, "{text}");
            assert_eq!(SwitchName::CalAdj.at_position(text), None, "{text}");
        }
    }

    #[test]
    fn a_name_leads_to_its_switch_and_potentiometer() {
        assert!(SwitchName::ALL.into_iter().all(|switch| SwitchName::from_name(switch.name()) == Some(switch)));
        assert_eq!(SwitchName::from_name("low"), None);
        assert_eq!(Potentiometer::from_name("b"), Some(Potentiometer::B));
        assert_eq!(Potentiometer::from_name("c"), None);
    }
}
