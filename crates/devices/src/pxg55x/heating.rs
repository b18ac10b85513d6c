//! The filament of the Pirani: tira56e1 12.2.5, errata-pxg55x-img400 107.

use super::codes::PiraniOff;
use crate::model::mbar;

/// Above this pressure the automatic mode switches the filament off.
const OFF_PA: f64 = mbar(12.0);

/// chosen: below this pressure it switches the filament on again, before the Pirani is needed.
const ON_PA: f64 = mbar(11.0);

/// The filament and its switch.
#[derive(Clone, Copy, Debug)]
pub struct PiraniHeating {
    /// ID 201
    pub mode: PiraniOff,
    heated: bool,
}

impl PiraniHeating {
    /// As it leaves the factory (85).
    pub const fn new() -> Self {
        Self { mode: PiraniOff::AlwaysOn, heated: true }
    }

    /// Whether the filament is heated, so that the Pirani has a reading.
    pub const fn is_on(&self) -> bool {
        self.heated
    }

    /// Switches the filament after a change of pressure.
    pub fn update(&mut self, pa: f64) {
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
    fn the_automatic_mode_has_a_hysteresis() {
        let mut heating = PiraniHeating { mode: PiraniOff::Automatic, ..PiraniHeating::new() };
        for (mbar_, on) in [(11.5, true), (12.0, true), (12.1, false), (11.5, false), (11.0, true), (11.5, true)] {
            heating.update(mbar(mbar_));
            assert_eq!(heating.is_on(), on, "{mbar_} mbar");
        }
    }

    #[test]
    fn the_pressure_has_no_effect_in_the_other_modes() {
        for (mode, on) in [(PiraniOff::AlwaysOn, true), (PiraniOff::AlwaysOff, false)] {
            let mut heating = PiraniHeating { mode, ..PiraniHeating::new() };
            for mbar_ in [1e-4, 1.0, 1000.0] {
                heating.update(mbar(mbar_));
                assert_eq!(heating.is_on(), on, "{mode:?} at {mbar_} mbar");
            }
        }
    }
}
