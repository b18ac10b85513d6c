//! Failed power supplies: an error stays until a master resets it. BG 5530 4.4.1 (ID 205), 4.4.4,
//! errata-pxg55x-img400 121, 122 and 128.

/// The errors of a power supply. An error sets alarm and warning (122); each is reset by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SupplyErrors {
    pub alarm: bool,
    pub warning: bool,
}

impl SupplyErrors {
    fn update(&mut self, broken: bool) {
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
    pub general: SupplyErrors,
    /// Manufacturer Exception Detail 2 and 3: hot cathode supplies of channels 1 and 2.
    pub cathodes: [SupplyErrors; 2],
    /// Channels 3 and 4 are without supply.
    pub channels_off: bool,
}

impl Errors {
    /// Sets the errors of the supplies that are broken now.
    pub fn update(&mut self, general: bool, cathodes: [bool; 2]) {
        self.general.update(general);
        self.channels_off |= general;
        for (supply, broken) in self.cathodes.iter_mut().zip(cathodes) {
            supply.update(broken);
        }
    }

    /// Whether there is a manufacturer alarm.
    pub fn has_alarm(&self) -> bool {
        self.general.alarm || self.cathodes.iter().any(|supply| supply.alarm)
    }

    /// Whether there is a manufacturer warning.
    pub fn has_warning(&self) -> bool {
        self.general.warning || self.cathodes.iter().any(|supply| supply.warning)
    }

    /// Whether there is any error.
    pub fn is_any(&self) -> bool {
        self.general.is_any() || self.cathodes.iter().any(|supply| supply.is_any())
    }

    /// Executes Reset Error Condition for the supplies. The error of a supply that is still broken returns at once
    /// (128).
    pub fn reset(&mut self, bits: ResetBits) {
        let cathodes = &mut self.cathodes;
        if bits.intersects(ResetBits::GENERAL_ALARMS | ResetBits::ALARMS_AND_SUPPLIES | ResetBits::EVERYTHING) {
            self.general.alarm = false;
        }
        if bits.intersects(ResetBits::GENERAL_WARNINGS | ResetBits::EVERYTHING) {
            self.general.warning = false;
        }
        if bits.intersects(ResetBits::CATHODE_ALARMS | ResetBits::ALARMS_AND_SUPPLIES | ResetBits::EVERYTHING) {
            cathodes.iter_mut().for_each(|supply| supply.alarm = false);
        }
        if bits.intersects(ResetBits::CATHODE_WARNINGS | ResetBits::EVERYTHING) {
            cathodes.iter_mut().for_each(|supply| supply.warning = false);
        }
        if bits.intersects(ResetBits::ALARMS_AND_SUPPLIES) {
            self.channels_off = false;
        }
    }
}

bitflags::bitflags! {
    /// The bits of Reset Error Condition; bit 6 is unused and ignored. The code table is
    /// [`ResetErrors`](super::codes::ResetErrors).
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(super) struct ResetBits: u8 {
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
