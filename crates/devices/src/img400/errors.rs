//! Power supplies that have failed: they stay so until somebody resets them. BG 5530 4.4.1 (ID 205), 4.4.4,
//! errata-pxg55x-img400 121, 122 and 128.

/// A power supply. An error is alarm and warning in one (122); each is reset by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Supply {
    pub alarm: bool,
    pub warning: bool,
}

impl Supply {
    fn follow(&mut self, broken: bool) {
        self.alarm |= broken;
        self.warning |= broken;
    }

    const fn is_any(self) -> bool {
        self.alarm || self.warning
    }
}

/// All power supplies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Errors {
    /// Manufacturer Exception Detail 1.
    pub general: Supply,
    /// Manufacturer Exception Detail 2 and 3: hot cathode supplies of channels 1 and 2.
    pub cathodes: [Supply; 2],
    /// Channels 3 and 4 are without supply.
    pub channels_off: bool,
}

impl Errors {
    /// What is broken now.
    pub fn follow(&mut self, general: bool, cathodes: [bool; 2]) {
        self.general.follow(general);
        self.channels_off |= general;
        for (supply, broken) in self.cathodes.iter_mut().zip(cathodes) {
            supply.follow(broken);
        }
    }

    /// Whether a manufacturer alarm stands, and a manufacturer warning.
    pub fn has_alarm(&self) -> bool {
        self.general.alarm || self.cathodes.iter().any(|supply| supply.alarm)
    }

    pub fn has_warning(&self) -> bool {
        self.general.warning || self.cathodes.iter().any(|supply| supply.warning)
    }

    pub fn is_any(&self) -> bool {
        self.general.is_any() || self.cathodes.iter().any(|supply| supply.is_any())
    }

    /// Reset Error Condition, as far as it concerns supplies. What is still broken comes back at once (128).
    pub fn reset(&mut self, bits: Reset) {
        let cathodes = &mut self.cathodes;
        if bits.intersects(Reset::GENERAL_ALARMS | Reset::ALARMS_AND_SUPPLIES | Reset::EVERYTHING) {
            self.general.alarm = false;
        }
        if bits.intersects(Reset::GENERAL_WARNINGS | Reset::EVERYTHING) {
            self.general.warning = false;
        }
        if bits.intersects(Reset::CATHODE_ALARMS | Reset::ALARMS_AND_SUPPLIES | Reset::EVERYTHING) {
            cathodes.iter_mut().for_each(|supply| supply.alarm = false);
        }
        if bits.intersects(Reset::CATHODE_WARNINGS | Reset::EVERYTHING) {
            cathodes.iter_mut().for_each(|supply| supply.warning = false);
        }
        if bits.intersects(Reset::ALARMS_AND_SUPPLIES) {
            self.channels_off = false;
        }
    }
}

bitflags::bitflags! {
    /// The bits of Reset Error Condition. Bit 6 is not used and ignored.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(super) struct Reset: u8 {
        const GENERAL_ALARMS = 1 << 0;
        const GENERAL_WARNINGS = 1 << 1;
        const CATHODE_ALARMS = 1 << 2;
        // "Alarms" in print (128).
        const CATHODE_WARNINGS = 1 << 3;
        /// All supply alarms; channels 3 and 4 get their supply again.
        const ALARMS_AND_SUPPLIES = 1 << 4;
        /// Emission was switched off by overpressure or key.
        const ERROR_FLAG = 1 << 5;
        const EVERYTHING = 1 << 7;
    }
}
