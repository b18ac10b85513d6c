//! Actions on a device as a user writes them: `fault 5 eeprom`, `switch 5 low-high 3`. The device decides what the words mean.

use profivac_client::suggestion::closest;
use profivac_devices::model::{Fault, FaultList};
use profivac_devices::{Action, Potentiometer, SimulatedDevice, SwitchName};
use std::fmt;

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

/// What a device does not have: a fault, button, switch, position or potentiometer.
///
/// ```
/// use profivac_virtual::action_text::ActionText;
/// use profivac_virtual::device_spec::DeviceSpec;
/// use profivac_virtual::nonvolatile::NonvolatileMemory;
///
/// let spec: DeviceSpec = "bcg450@5".parse()?;
/// let gauge = spec.build(NonvolatileMemory::volatile(), profivac_dp::link::Baud::B19200)?;
/// let unknown = ActionText::Switch { name: "degass", value: "on" }.resolve(gauge.device()).unwrap_err();
/// assert_eq!(
///     unknown.to_string(),
///     "no switch \"degass\"; it has address (0 ... 255), degas (on, off); did you mean \"degas\"?"
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// `fault`, `button`, `switch`, `position` or `potentiometer`.
    kind: &'static str,
    /// The name of the user, for a position with its switch.
    found: String,
    /// The names that the device has, each with its meaning in words, which may be empty.
    known: Vec<(String, String)>,
    /// The most similar one.
    near: Option<String>,
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, found, known, near } = self;
        if known.is_empty() {
            return write!(f, "no {kind}");
        }
        let named = known.iter().map(|(name, meaning)| match meaning.as_str() {
            "" => name.clone(),
            meaning => format!("{name} ({meaning})"),
        });
        write!(f, "no {kind} {found}; it has {}", named.collect::<Vec<_>>().join(", "))?;
        near.as_ref().map_or(Ok(()), |near| write!(f, "; did you mean {near:?}?"))
    }
}

impl UnknownName {
    /// Of a kind whose names are words.
    fn named(kind: &'static str, name: &str, known: Vec<(String, String)>) -> Self {
        let near = closest(name, known.iter().map(|(name, _)| name.as_str())).map(str::to_owned);
        Self { kind, found: format!("{name:?}"), known, near }
    }

    fn fault(name: &str, faults: &FaultList) -> Self {
        let known = faults.names().zip(faults.effects).map(|(name, effect)| (name.to_owned(), (*effect).to_owned()));
        Self::named("fault", name, known.collect())
    }

    fn button(number: u8, buttons: u8) -> Self {
        let known = (1..=buttons).map(|number| (number.to_string(), String::new())).collect();
        Self { kind: "button", found: number.to_string(), known, near: None }
    }

    fn switch(name: &str, switches: &[SwitchName]) -> Self {
        let known = switches.iter().map(|switch| (switch.name().to_owned(), switch.positions().join(", ")));
        Self::named("switch", name, known.collect())
    }

    fn position(value: &str, switch: SwitchName) -> Self {
        let known = switch.positions().iter().map(|position| ((*position).to_owned(), String::new())).collect();
        let found = format!("{value:?} of the switch {:?}", switch.name());
        Self { kind: "position", found, known, near: None }
    }

    fn potentiometer(which: char, potentiometers: &[Potentiometer]) -> Self {
        let known = potentiometers.iter().map(|it| (it.name().to_owned(), String::new())).collect();
        Self { kind: "potentiometer", found: format!("{:?}", which.to_string()), known, near: None }
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
                .ok_or_else(|| UnknownName::fault(name, device.faults())),
            Self::Button(number) if (1..=panel.buttons).contains(&number) => Ok(Action::Button(number)),
            Self::Button(number) => Err(UnknownName::button(number, panel.buttons)),
            Self::Switch { name, value } => {
                let switch = SwitchName::from_name(name)
                    .filter(|switch| panel.switches.contains(switch))
                    .ok_or_else(|| UnknownName::switch(name, panel.switches))?;
                let at_position = switch.at_position(value).map(Action::Switch);
                at_position.ok_or_else(|| UnknownName::position(value, switch))
            }
            Self::Pot { which, volts } => Potentiometer::from_name(which.encode_utf8(&mut [0; 4]))
                .filter(|potentiometer| panel.potentiometers.contains(potentiometer))
                .map(|potentiometer| Action::Potentiometer { potentiometer, volts })
                .ok_or_else(|| UnknownName::potentiometer(which, panel.potentiometers)),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use crate::device_spec::DEVICES;
    use crate::nonvolatile::NonvolatileMemory;
    use profivac_dp::link::Baud;

    #[test]
    fn the_answer_to_a_wrong_fault_has_every_fault_of_the_device_with_its_effect() {
        for entry in &DEVICES {
            let spec: crate::device_spec::DeviceSpec = format!("{}@5", entry.model.name).parse().unwrap();
            let built = spec.build(NonvolatileMemory::volatile(), Baud::B19200).unwrap();
            let device = built.device();
            let unknown = ActionText::Fault { name: "tiredness", present: true }.resolve(device).unwrap_err();
            let sentence = unknown.to_string();
            let (before, list) = sentence.split_once("; it has ").unwrap();
            assert_eq!(before, "no fault \"tiredness\"");
            let faults = device.faults();
            let words = faults.names().zip(faults.effects).map(|(name, effect)| format!("{name} ({effect})"));
            assert_eq!(list, words.collect::<Vec<_>>().join(", "), "{}", entry.model.name);
            for fault in Fault::ALL {
                let known = faults.faults.contains(fault);
                let text = ActionText::Fault { name: fault.name(), present: false };
                assert_eq!(text.resolve(device).is_ok(), known, "{} {}", entry.model.name, fault.name());
            }
        }
    }
}
