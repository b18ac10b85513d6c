//! A threshold control block: a pair of thresholds with a source. IF300P/IF301P manual 3.2.4.2,
//! errata-bpg-bcg-tpg 137 to 142.

/// The thresholds and the source of a block, which become valid together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ThresholdSet {
    /// The function is deactivated above it, in Pa.
    pub upper_pa: f64,
    /// The function is activated below it, in Pa.
    pub lower_pa: f64,
    /// Slot of the analog input block that is compared.
    pub source: u8,
}

impl ThresholdSet {
    /// Whether the lower threshold is not above the upper one: errata-bpg-bcg-tpg 137.
    pub fn are_in_order(&self) -> bool {
        self.lower_pa <= self.upper_pa
    }

    /// Moves the upper threshold to the lower one if it lies below.
    pub const fn uncross(&mut self) {
        self.upper_pa = self.upper_pa.max(self.lower_pa);
    }
}

/// The state of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Threshold {
    /// The set in preparation, while Threshold validation is 0. The controller does not use it (139).
    pub open: Option<ThresholdSet>,
    /// Whether the function is activated.
    pub activated: bool,
}
