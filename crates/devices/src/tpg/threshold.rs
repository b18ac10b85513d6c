//! A threshold control block: a pair of thresholds with a source, compared with hysteresis. IF300P/IF301P manual 3.2.4.2,
//! errata-bpg-bcg-tpg 137 to 142.

/// The set of a block that only holds together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limits {
    /// The function is deactivated above it, in Pa.
    pub upper_pa: f64,
    /// The function is activated below it, in Pa.
    pub lower_pa: f64,
    /// Slot of the analog input block that is compared.
    pub source: u8,
}

impl Limits {
    /// Whether the function is activated at this pressure in Pa, after it `was` or was not. Without a pressure it is not.
    pub fn compare(&self, pressure: Option<f64>, was: bool) -> bool {
        match pressure {
            None => false,
            Some(pa) if pa < self.lower_pa => true,
            Some(pa) if pa > self.upper_pa => false,
            Some(_) => was,
        }
    }

    /// Whether they can be compared: errata-bpg-bcg-tpg 137.
    pub fn are_in_order(&self) -> bool {
        self.lower_pa <= self.upper_pa
    }
}

/// The state of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Threshold {
    /// The set in preparation, while Threshold validation is 0. The controller does not know it (139).
    pub open: Option<Limits>,
    /// Whether the function is activated.
    pub activated: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_the_thresholds_nothing_changes() {
        let limits = Limits { upper_pa: 2.0, lower_pa: 1.0, source: 1 };
        for (pa, was, is) in [
            (0.9, false, true),
            (1.0, false, false),
            (1.5, false, false),
            (1.5, true, true),
            (2.0, true, true),
            (2.1, true, false),
        ] {
            assert_eq!(limits.compare(Some(pa), was), is, "{pa} {was}");
        }
        assert!(!limits.compare(None, true));
    }
}
