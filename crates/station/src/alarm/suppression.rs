//! The present time on both clocks.

use profivac_model::Micros;

/// The present time on both clocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AlarmTime {
    /// A clock that is never set.
    pub monotonic: Micros,
    /// The system clock.
    pub wall: Micros,
}
