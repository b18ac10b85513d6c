//! The state of a device for users and scripts.

/// The reading of one measuring part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartReading {
    /// As in [`Part::instance`](crate::model::Part::instance).
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
        if let Some(free) = self.items.iter_mut().find(|item| item.is_none()) {
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
    /// Operating time in hours, which a power failure does not end; 0 for a TPG, which does not count it.
    pub run_hours: f64,
}

impl StateReport {
    /// The report of the same device without power: each list keeps its length, with nothing closed, on or valid in it,
    /// and readings are not numbers.
    // chosen: outputs count as safe then, for relays are open, cathodes off, and no value is sent.
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
