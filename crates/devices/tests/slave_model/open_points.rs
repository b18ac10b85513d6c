//! The points that `docs/spec` leaves open, and what slave and model do.

/// Number, section, and the behaviour.
pub const OPEN: &[(u8, &str, &str)] = &[];
