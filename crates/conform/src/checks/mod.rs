//! The checks, in the order in which a slave is led through them. Each begins and ends with a slave that waits for
//! parameters, and none sends an output that is not zero.

mod acyclic;
mod exchange;
mod layer2;
mod noise;
mod start_up;

use super::dialogue::{CheckOutcome, Dialogue};

/// A rule and how a slave is asked about it.
pub struct Check {
    /// A name for scripts: `layer2.repetition`.
    pub name: &'static str,
    /// The rule, in one sentence.
    pub rule: &'static str,
    /// Where it stands: a section of the protocol reference, see docs/conformance.md.
    pub section: &'static str,
    /// Asks.
    pub run: fn(&mut Dialogue<'_>) -> CheckOutcome,
}

/// All of them.
pub fn all() -> impl Iterator<Item = &'static Check> {
    [layer2::CHECKS, start_up::CHECKS, exchange::CHECKS, acyclic::CHECKS, noise::CHECKS].into_iter().flatten()
}
