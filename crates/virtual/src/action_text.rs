//! Actions on a device as a user writes them: `fault 5 eeprom`, `switch 5 low-high 3`. The device decides what the words mean.

use profivac_devices::model::Fault;
use profivac_devices::{Action, Potentiometer, SimulatedDevice, SwitchName};

/// An action in words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActionText<'a> {
    /// A fault begins or ends.
    Fault {
        /// Its name.
        name: &'a str,
        /// It begins (`true`) or ends.
        present: bool,
    },
    /// The push button of this number is pressed.
    Button(u8),
    /// A switch or an input is set.
    Switch {
        /// Its name.
        name: &'a str,
        /// Its position.
        value: &'a str,
    },
    /// A potentiometer is turned.
    Pot {
        /// Its letter.
        which: char,
        /// The voltage.
        volts: f64,
    },
}

/// The device has no fault, button, switch, position or potentiometer of this name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// The names that it has; empty if it has no control of this kind.
    pub expected: Vec<String>,
}

impl UnknownName {
    fn new<T: ToString>(expected: impl IntoIterator<Item = T>) -> Self {
        Self { expected: expected.into_iter().map(|name| name.to_string()).collect() }
    }
}

impl ActionText<'_> {
    /// The action on this device.
    ///
    /// # Errors
    /// [`UnknownName`] when the device does not have the fault or control, or the control not the position.
    pub fn resolve(self, device: &dyn SimulatedDevice) -> Result<Action, UnknownName> {
        let panel = device.front_panel();
        match self {
            Self::Fault { name, present } => Fault::from_name(name)
                .filter(|fault| device.faults().faults.contains(fault))
                .map(|fault| Action::Fault { fault, active: present })
                .ok_or_else(|| UnknownName::new(device.faults().names())),
            Self::Button(number) if (1..=panel.buttons).contains(&number) => Ok(Action::Button(number)),
            Self::Button(_) => Err(UnknownName::new(1..=panel.buttons)),
            Self::Switch { name, value } => {
                let switch = SwitchName::from_name(name)
                    .filter(|switch| panel.switches.contains(switch))
                    .ok_or_else(|| UnknownName::new(panel.switches.iter().map(|switch| switch.name())))?;
                let at_position = switch.at_position(value).map(Action::Switch);
                at_position.ok_or_else(|| UnknownName::new(switch.positions()))
            }
            Self::Pot { which, volts } => Potentiometer::from_name(which.encode_utf8(&mut [0; 4]))
                .filter(|potentiometer| panel.potentiometers.contains(potentiometer))
                .map(|potentiometer| Action::Potentiometer { potentiometer, volts })
                .ok_or_else(|| UnknownName::new(panel.potentiometers.iter().map(|it| it.name()))),
        }
    }
}
