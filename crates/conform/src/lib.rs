#![doc = include_str!("../README.md")]

pub mod checks;
pub mod dialogue;
pub mod expected;
pub mod port_link;
pub mod probe;
mod repeat;

pub use port_link::PortLink;

use checks::Check;
use dialogue::{CountMode, Dialogue, Link, LoggedCycle, SlaveUnderTest};
use expected::{Expected, Reason};
use profivac_host::port::PortError;
use std::ops::ControlFlow;

/// Outcome of a check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The slave keeps the rule.
    Passed,
    /// The slave breaks the rule.
    Broken {
        /// The expectation that it did not meet.
        expected: Expected,
        /// The message cycle that shows it.
        shown: Option<LoggedCycle>,
    },
    /// The rule was not tested. A consequence of another fault is never a broken rule.
    NotTested(Reason),
}

/// A check with its outcome.
#[derive(Clone, Debug)]
pub struct CheckResult {
    /// The check.
    pub check: &'static Check,
    /// Its outcome.
    pub outcome: Outcome,
}

/// Runs all checks. Calls `report` with each result; `ControlFlow::Break` ends the run after that check. The slave is released
/// after each check. A broken rule has been reproduced: several tests of it show the fault, and none of them was disturbed.
///
/// # Errors
/// [`PortError`] if the port is lost.
pub fn run(
    link: &mut dyn Link,
    slave: &SlaveUnderTest,
    mut report: impl FnMut(&CheckResult) -> ControlFlow<()>,
) -> Result<Vec<CheckResult>, PortError> {
    let mut dialogue = Dialogue::new(link, slave);
    let mut results: Vec<CheckResult> = Vec::new();
    let of_gsd = checks::of_gsd().filter(|_| slave.stated.is_some());
    for check in checks::all().chain(of_gsd) {
        dialogue.set_count_mode(count_mode(check, &results));
        let was_silent = results.last().is_some_and(|last| last.outcome == Outcome::NotTested(Reason::Silent));
        let outcome = match obstacle(check, &results) {
            Some(reason) => Outcome::NotTested(reason),
            None if was_silent && !repeat::answers(&mut dialogue)? => Outcome::NotTested(Reason::Silent),
            None => repeat::test(check, &mut dialogue)?,
        };
        let result = CheckResult { check, outcome };
        let control = report(&result);
        results.push(result);
        if control.is_break() {
            break;
        }
    }
    Ok(results)
}

/// What the outcome of a rule says about the slave.
enum Verdict {
    /// It keeps the rule.
    Kept,
    /// It breaks the rule.
    Broken,
    /// Nothing, for a reason that is none of its own: the line disturbs the tests.
    Undecided,
    /// Nothing, for this reason.
    NotTested(Reason),
}

fn verdict(result: &CheckResult) -> Verdict {
    match &result.outcome {
        Outcome::Passed => Verdict::Kept,
        Outcome::Broken { .. } => Verdict::Broken,
        Outcome::NotTested(Reason::Disturbed | Reason::Varies) => Verdict::Undecided,
        Outcome::NotTested(reason) => Verdict::NotTested(reason.clone()),
    }
}

/// Why `check` cannot be tested: a rule that it needs is broken, or was not tested itself for this reason; or the slave breaks, or
/// may break, a rule whose fault may show itself in this one again.
fn obstacle(check: &Check, results: &[CheckResult]) -> Option<Reason> {
    let result_of = |name: &&'static str| results.iter().find(|result| result.check.name == *name);
    let mut needed = check.needs.iter().filter_map(result_of);
    let mut shared = check.shares.iter().filter_map(result_of);
    let fault = |result: &CheckResult| match verdict(result) {
        Verdict::Broken => Some(Reason::After(result.check.name)),
        Verdict::Undecided => Some(Reason::Undecided(result.check.name)),
        Verdict::Kept | Verdict::NotTested(_) => None,
    };
    let lack = |result: &CheckResult| match verdict(result) {
        Verdict::NotTested(reason) => Some(reason),
        Verdict::Kept | Verdict::Broken | Verdict::Undecided => None,
    };
    needed.find_map(|result| fault(result).or_else(|| lack(result))).or_else(|| shared.find_map(fault))
}

/// The frame count bits of a check. First requests serve until the rules about frame count bits are tested, and after them if
/// the slave breaks one, or may break one, so that its fault is not counted again. A slave that does not execute first requests gets
/// counted ones.
fn count_mode(check: &Check, results: &[CheckResult]) -> CountMode {
    let is_count = |check: &Check| check.name.starts_with(checks::COUNT);
    let is_faulty = |result: &&CheckResult| is_count(result.check) && !has_no_fault(result);
    let remain = checks::all().skip_while(|other| other.name != check.name).any(is_count);
    match results.iter().find(is_faulty).map(|result| (result.check.name, verdict(result))) {
        Some((checks::FIRST_REQUEST, Verdict::Broken)) => CountMode::Alternating,
        None if !remain => CountMode::Alternating,
        Some(_) | None => CountMode::First,
    }
}

/// Whether the slave keeps the rule, or the rule was not tested for a reason that shows no fault.
fn has_no_fault(result: &CheckResult) -> bool {
    match verdict(result) {
        Verdict::Broken | Verdict::Undecided | Verdict::NotTested(Reason::Undecided(_)) => false,
        Verdict::Kept | Verdict::NotTested(_) => true,
    }
}
