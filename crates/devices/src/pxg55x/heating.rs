//! The filament of the Pirani: tira56e1 12.2.5, errata-pxg55x-img400 107.

use crate::model::{AccessError, Value, mbar};

/// Above this pressure the automatic switches off.
const OFF_PA: f64 = mbar(12.0);

/// free choice: below this pressure it switches on again, before the Pirani is needed.
const ON_PA: f64 = mbar(11.0);

/// Parameter 201, Pirani OFF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PiraniOff {
    /// Always on.
    AlwaysOn = 0,
    /// Switched off at high pressure.
    Automatic = 1,
    /// Always off.
    AlwaysOff = 2,
}

impl PiraniOff {
    /// The mode with this code.
    pub fn of(value: &Value) -> Result<Self, AccessError> {
        match value.integer()? {
            0u8 => Ok(Self::AlwaysOn),
            1 => Ok(Self::Automatic),
            2 => Ok(Self::AlwaysOff),
            _ => Err(AccessError::OutOfRange),
        }
    }
}

/// The filament and its switch.
#[derive(Clone, Copy, Debug)]
pub struct Heating {
    /// ID 201
    pub mode: PiraniOff,
    heated: bool,
}

impl Heating {
    /// As it leaves the factory (85).
    pub const fn new() -> Self {
        Self { mode: PiraniOff::AlwaysOn, heated: true }
    }

    /// Whether the Pirani reads anything.
    pub const fn is_on(&self) -> bool {
        self.heated
    }

    /// The pressure may have changed.
    pub fn follow(&mut self, pa: f64) {
        self.heated = match self.mode {
            PiraniOff::AlwaysOn => true,
            PiraniOff::Automatic => pa <= if self.heated { OFF_PA } else { ON_PA },
            PiraniOff::AlwaysOff => false,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_automatic_has_a_hysteresis() {
        let mut heating = Heating { mode: PiraniOff::Automatic, ..Heating::new() };
        for (mbar_, on) in [(11.5, true), (12.0, true), (12.1, false), (11.5, false), (11.0, true), (11.5, true)] {
            heating.follow(mbar(mbar_));
            assert_eq!(heating.is_on(), on, "{mbar_} mbar");
        }
    }

    #[test]
    fn by_hand_the_pressure_does_not_matter() {
        for (mode, on) in [(PiraniOff::AlwaysOn, true), (PiraniOff::AlwaysOff, false)] {
            let mut heating = Heating { mode, ..Heating::new() };
            for mbar_ in [1e-4, 1.0, 1000.0] {
                heating.follow(mbar(mbar_));
                assert_eq!(heating.is_on(), on, "{mode:?} at {mbar_} mbar");
            }
        }
    }
}
