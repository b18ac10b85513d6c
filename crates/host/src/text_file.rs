//! What files that people write have in common: values written as texts, rates, and the place of what is wrong.

use profivac_dp::link::Baud;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::fmt::Display;
use std::str::FromStr;

/// A value that is written as a text.
#[derive(Debug)]
pub struct Parsed<T>(pub T);

impl<'de, T: FromStr<Err: Display>> Deserialize<'de> for Parsed<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map(Self).map_err(D::Error::custom)
    }
}

/// The rate of a line of which nothing is said.
#[must_use]
pub const fn usual_baud() -> Baud {
    Baud::B19200
}

/// A rate in bits per second.
///
/// # Errors
/// What the format makes of a number that is no PROFIBUS rate.
pub fn baud<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Baud, D::Error> {
    let number = u32::deserialize(deserializer)?;
    Baud::from_bits_per_second(number).ok_or_else(|| {
        let rates = Baud::ALL.map(|baud| baud.bits_per_second().to_string()).join(", ");
        D::Error::custom(format!("expected a PROFIBUS rate out of {rates}, got {number}"))
    })
}

/// Line and column of an octet of `text`, both from 1.
#[must_use]
pub fn place_of(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.rsplit('\n').next().unwrap_or_default();
    (before.matches('\n').count().saturating_add(1), line.chars().count().saturating_add(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_counted_in_characters_from_one() {
        assert_eq!([0, 1, 3].map(|offset| place_of("a\nb", offset)), [(1, 1), (1, 2), (2, 2)]);
        assert_eq!(place_of("ab\ncä e", 7), (2, 4));
    }
}
