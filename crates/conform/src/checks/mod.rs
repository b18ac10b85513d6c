//! The rules, in the order in which they are tested. Each is about one thing. A rule whose test needs another one names it, and
//! is not tested if the slave breaks that one or lacks its service. All outputs are zero, and no stored value changes.

mod contact;
mod count;
mod damage;
mod diagnosis;
mod exchange;
mod gsd;
mod layer2;
mod lock;
mod ms1;
mod ms2;
mod noise;
mod start_up;
mod watchdog;

use super::dialogue::{CheckOutcome, Dialogue};

/// The reserved access point of profibus-wire 2.1, where no slave has a service.
const NO_SERVICE: u8 = 52;

/// A rule, and the function that tests it.
#[derive(Debug)]
pub struct Check {
    /// Name for scripts: `layer2.closed`.
    pub name: &'static str,
    /// The rule, in one sentence.
    pub rule: &'static str,
    /// Section of the protocol reference, see docs/conformance.md.
    pub section: &'static str,
    /// The names of the rules without which this one cannot be tested.
    pub needs: &'static [&'static str],
    /// The names of the rules whose fault may show itself here again: if the slave breaks one, this rule is not tested.
    pub shares: &'static [&'static str],
    /// Tests the rule.
    pub run: fn(&mut Dialogue<'_>) -> CheckOutcome,
}

impl Check {
    const fn new(
        name: &'static str,
        section: &'static str,
        rule: &'static str,
        run: fn(&mut Dialogue<'_>) -> CheckOutcome,
    ) -> Self {
        Self { name, rule, section, needs: &[], shares: &[], run }
    }

    const fn after(self, needs: &'static [&'static str]) -> Self {
        Self { needs, ..self }
    }

    const fn unless_broken(self, shares: &'static [&'static str]) -> Self {
        Self { shares, ..self }
    }
}

/// All checks.
pub fn all() -> impl Iterator<Item = &'static Check> {
    [
        contact::CHECKS,
        layer2::CHECKS,
        damage::CHECKS,
        diagnosis::CHECKS,
        start_up::CHECKS,
        lock::CHECKS,
        exchange::CHECKS,
        count::CHECKS,
        watchdog::CHECKS,
        ms1::CHECKS,
        ms2::CHECKS,
        noise::CHECKS,
    ]
    .into_iter()
    .flatten()
}

/// What the GSD file states. These rules are tested after all others, on a slave with a file.
pub fn of_gsd() -> impl Iterator<Item = &'static Check> {
    gsd::CHECKS.iter()
}

/// The rule that a slave executes first requests. Without it the test counts its requests from the beginning.
pub const FIRST_REQUEST: &str = "count.first";

/// The beginning of the names of the rules about frame count bits. If a slave keeps them all, the test counts its requests
/// from then on.
pub const COUNT: &str = "count.";
