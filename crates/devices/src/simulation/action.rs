//! What a user can do to a device: faults, push buttons, switches, potentiometers.

use crate::model::Fault;
use core::fmt;

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

/// The device has no such fault, button, switch or potentiometer, or the switch has no such position.
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
            Action::Switch(switch @ (Switch::LowHigh(position) | Switch::CalAdj(position))) if !switch.is_valid() => {
                write!(f, "the switch {} has no position {position}", switch.name().name())
            }
            Action::Switch(switch) => write!(f, "the device has no switch {}", switch.name().name()),
            Action::Potentiometer { potentiometer, .. } => {
                write!(f, "the device has no potentiometer {}", potentiometer.name())
            }
        }
    }
}

impl core::error::Error for UnsupportedAction {}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::string::ToString as _;

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

    /// The text names what is missing: the switch, or the position of a switch.
    #[test]
    fn an_unsupported_action_says_whether_the_switch_or_its_position_is_missing() {
        for (switch, text) in [
            (Switch::LowHigh(3), "the device has no switch low-high"),
            (Switch::LowHigh(12), "the switch low-high has no position 12"),
            (Switch::CalAdj(10), "the switch cal-adj has no position 10"),
        ] {
            assert_eq!(UnsupportedAction { action: Action::Switch(switch) }.to_string(), text);
        }
    }
}
