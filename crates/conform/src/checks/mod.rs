//! The checks, in the order in which they run. Each check begins and ends with a slave that waits for parameters. All outputs
//! are zero.

mod acyclic;
mod exchange;
mod layer2;
mod noise;
mod start_up;

use super::dialogue::{CheckOutcome, Dialogue};

/// A rule, and the function that tests it.
pub struct Check {
    /// Name for scripts: `layer2.repetition`.
    pub name: &'static str,
    /// The rule, in one sentence.
    pub rule: &'static str,
    /// Section of the protocol reference, see docs/conformance.md.
    pub section: &'static str,
    /// Tests the rule.
    pub run: fn(&mut Dialogue<'_>) -> CheckOutcome,
}

/// All checks.
pub fn all() -> impl Iterator<Item = &'static Check> {
    [layer2::CHECKS, start_up::CHECKS, exchange::CHECKS, acyclic::CHECKS, noise::CHECKS].into_iter().flatten()
}
