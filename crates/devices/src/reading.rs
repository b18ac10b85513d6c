//! The quality of a reading: the one list of states that a client, a recorder, an alarm and a user interface use.
//!
//! [`Quality::word`] is a contract: exports, the HTTP API and gateways use these words. The numbers are those of a database.

/// The state of a reading: whether it is a pressure, and if not, why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// The gauge measures. Only a positive, finite number is valid.
    Valid = 0,
    /// The pressure is above the range of the gauge; only the end of the range is known.
    Overrange = 1,
    /// The pressure is below the range of the gauge; only the end of the range is known.
    Underrange = 2,
    /// The gauge reports a defect, or a number that is no pressure.
    Fault = 3,
    /// The gauge gives no data, or gave the last ones too long ago.
    Stale = 4,
    /// The gauge does not measure because its emission, its high voltage or its heating is off; this is no defect.
    Off = 5,
    /// No gauge is connected to the channel.
    Missing = 6,
    /// A listener has inputs, but their configuration or unit is assumed: no telegram and no user has shown it, so the pressure is not
    /// known.
    Assumed = 7,
}

impl Quality {
    /// All qualities.
    pub const ALL: [Self; 8] = [
        Self::Valid,
        Self::Overrange,
        Self::Underrange,
        Self::Fault,
        Self::Stale,
        Self::Off,
        Self::Missing,
        Self::Assumed,
    ];

    /// The quality with this number.
    #[must_use]
    pub fn from_number(number: i64) -> Option<Self> {
        Self::ALL.into_iter().find(|quality| *quality as i64 == number)
    }

    /// The machine-readable word in exports, in the API and in gateways.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Valid => "valid",
            Self::Overrange => "overrange",
            Self::Underrange => "underrange",
            Self::Fault => "fault",
            Self::Stale => "stale",
            Self::Off => "off",
            Self::Missing => "missing",
            Self::Assumed => "assumed",
        }
    }

    /// The words for users.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Valid => "valid",
            Self::Overrange => "over range",
            Self::Underrange => "under range",
            Self::Fault => "fault",
            Self::Stale => "no data",
            Self::Off => "off",
            Self::Missing => "no gauge",
            Self::Assumed => "assumed",
        }
    }

    /// Whether a pressure comes with this quality: a measured one, or the end of the range.
    #[must_use]
    pub const fn has_pressure(self) -> bool {
        matches!(self, Self::Valid | Self::Overrange | Self::Underrange)
    }
}

/// Whether a number in Pa is a pressure: positive and finite. 0 is no pressure: a device sends it in place of a reading
/// (Safe State Zero, errata-bpg-bcg-tpg 74 and 154).
#[must_use]
pub fn is_pressure(pa: f64) -> bool {
    pa.is_finite() && pa > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quality_has_a_number_and_a_word_of_its_own() {
        for (number, quality) in (0..).zip(Quality::ALL) {
            assert_eq!(Quality::from_number(number), Some(quality));
            assert_eq!(Quality::ALL.iter().filter(|other| other.word() == quality.word()).count(), 1);
        }
        assert_eq!((Quality::from_number(8), Quality::from_number(-1)), (None, None));
    }

    #[test]
    fn zero_is_no_pressure() {
        for pa in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!is_pressure(pa), "{pa}");
        }
        assert!(is_pressure(1e-12));
    }
}
