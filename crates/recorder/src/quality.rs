//! The qualities of samples.

pub use profivac_model::Quality;

/// A set of qualities, as bits: the bit of a quality is its number.
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
        assert_eq!(Quality::from_number(8), None);
    }
}
