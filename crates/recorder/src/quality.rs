//! Why a sample has no pressure, or that it has one.

use serde::{Serialize, Serializer};

/// Whether a sample has a pressure, and if not, why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// The gauge measures.
    Valid = 0,
    /// The pressure is above the range of the gauge; the sample holds the end of the range.
    Overrange = 1,
    /// The pressure is below the range of the gauge; the sample holds the end of the range.
    Underrange = 2,
    /// The gauge reports that its reading is invalid.
    Invalid = 3,
    /// No data came from the gauge from here on.
    Gap = 4,
}

impl Quality {
    /// All qualities.
    pub const ALL: [Self; 5] = [Self::Valid, Self::Overrange, Self::Underrange, Self::Invalid, Self::Gap];

    /// The quality stored as `number`.
    #[must_use]
    pub fn from_number(number: i64) -> Option<Self> {
        Self::ALL.into_iter().find(|quality| *quality as i64 == number)
    }

    /// The word in exports and in the API.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Valid => "valid",
            Self::Overrange => "overrange",
            Self::Underrange => "underrange",
            Self::Invalid => "invalid",
            Self::Gap => "gap",
        }
    }
}

impl Serialize for Quality {
    /// As its word.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}

/// A set of qualities, as bits: bit 0 valid, bit 1 overrange, ...
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Qualities(pub u8);

impl Qualities {
    /// The set of one quality.
    #[must_use]
    pub const fn of(quality: Quality) -> Self {
        Self(1 << quality as u8)
    }

    /// The union of both sets.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether the set contains a quality.
    #[must_use]
    pub const fn contains(self, quality: Quality) -> bool {
        self.0 & Self::of(quality).0 != 0
    }

    /// The qualities in the set.
    pub fn iter(self) -> impl Iterator<Item = Quality> {
        Quality::ALL.into_iter().filter(move |quality| self.contains(*quality))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn qualities_are_stored_as_numbers() {
        for quality in Quality::ALL {
            assert_eq!(Quality::from_number(quality as i64), Some(quality));
            assert_eq!(Qualities::of(quality).iter().collect::<Vec<_>>(), [quality]);
        }
        assert_eq!(Quality::from_number(5), None);
    }
}
