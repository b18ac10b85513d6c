//! Whether the settings that a driver has taken are those of PROFIBUS.

use super::{CharacterFormat, PortError};
use profivac_dp::link::Baud;

/// The tolerated deviation of the rate is one part in this many: a character of 11 bits is then still sampled correctly.
const RATE_TOLERANCE: u32 = 50;

/// Verifies what a driver has taken: it silently drops what it does not support, and takes the nearest rate it has.
///
/// # Errors
/// [`PortError::UnsupportedCharacter`] and [`PortError::UnsupportedRate`].
pub fn verify(
    name: &str,
    baud: Baud,
    offered: CharacterFormat,
    rates: impl IntoIterator<Item = Option<u32>>,
) -> Result<(), PortError> {
    if offered != CharacterFormat::PROFIBUS {
        return Err(PortError::UnsupportedCharacter { name: name.to_owned(), offered });
    }
    match wrong_rate(baud.bits_per_second(), rates) {
        Some(offered) => Err(PortError::UnsupportedRate { name: name.to_owned(), baud, offered: Some(offered) }),
        None => Ok(()),
    }
}

/// The first of `rates` that deviates too much from `wanted`.
pub fn wrong_rate(wanted: u32, rates: impl IntoIterator<Item = Option<u32>>) -> Option<u32> {
    rates.into_iter().flatten().find(|offered| offered.abs_diff(wanted) > wanted / RATE_TOLERANCE)
}
