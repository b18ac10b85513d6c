//! Times on both clocks, users with their times, and why an alarm is silent.

use profivac_recorder::Micros;

/// The present time on both clocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AlarmTime {
    /// A clock that is never set.
    pub monotonic: Micros,
    /// The system clock.
    pub wall: Micros,
}

/// The user who did something, and when.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attribution {
    /// The name of the user.
    pub user: String,
    /// The wall-clock time.
    pub at: Micros,
}

/// Why an alarm is shelved, out of service or suppressed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suppression {
    /// The user who shelved it, took it out of service, or declared the plant state that suppresses it.
    pub by: Attribution,
    /// The reason; of a plant state with its name before it.
    pub reason: String,
    /// The wall-clock time at which it ends by itself. A shelved or suppressed alarm has one.
    pub until: Option<Micros>,
}
