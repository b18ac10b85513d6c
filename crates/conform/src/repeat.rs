//! Repeats the test of a rule where one test alone proves nothing.
//!
//! Between the slave and the program are a line, a port and a computer: they lose, damage and delay octets too. So a rule is broken
//! only if several tests of it fail, and a test that the line disturbed does not count. The results of a test:
//!
//! | Test | Consequence |
//! |---|---|
//! | disturbed ([`Dialogue::take_disturbed`]) | repeated; without a result in the end: [`Reason::Disturbed`] |
//! | broken | repeated; broken if [`REPRODUCTIONS`] tests are broken, or [`MISSING_REPRODUCTIONS`] in which an answer is missing |
//! | not prepared | repeated; not tested if the preparation fails each time |
//! | passed after the slave sent something else in an earlier test | [`Reason::Varies`] |
//! | passed otherwise, or not tested for another reason | the outcome of the rule |

use super::Outcome;
use super::checks::Check;
use super::dialogue::{CheckError, Dialogue, LoggedCycle};
use super::expected::Reason;
use super::probe::Received;
use profivac_host::port::PortError;

/// The most tests of a rule. chosen.
const ATTEMPTS: usize = 12;

/// The tests that must show a broken rule in which the slave sends something else. chosen: a line that loses requests unnoticed
/// hardly leads to it in four tests.
const REPRODUCTIONS: usize = 4;

/// The tests that must show a broken rule in which an answer is missing. chosen: a lost request looks the same.
const MISSING_REPRODUCTIONS: usize = 8;

/// How often a slave without an answer is asked whether it still answers. chosen.
const LISTENS: usize = 3;

const SILENT: Outcome = Outcome::NotTested(Reason::Silent);

/// The results of the tests so far.
#[derive(Default)]
struct Tests {
    broken: usize,
    /// In a test that was broken the slave sent a telegram, and not nothing.
    has_contradicted: bool,
    is_disturbed: bool,
    /// The first test that was broken. The slave was then as the rule before had left it.
    first_broken: Option<Outcome>,
    unprepared: Option<Outcome>,
}

impl Tests {
    /// Adds a test that was not disturbed. Returns the outcome of the rule once it is known.
    fn add(&mut self, outcome: Outcome) -> Option<Outcome> {
        match &outcome {
            Outcome::Broken { shown, .. } => {
                let is_telegram = |cycle: &LoggedCycle| matches!(cycle.received, Received::Telegram(_));
                self.has_contradicted |= shown.as_ref().is_some_and(is_telegram);
                self.broken = self.broken.saturating_add(1);
                self.first_broken.get_or_insert(outcome);
                let required = if self.has_contradicted { REPRODUCTIONS } else { MISSING_REPRODUCTIONS };
                if self.broken >= required { self.first_broken.take() } else { None }
            }
            Outcome::NotTested(Reason::Unprepared(_)) => {
                self.unprepared = Some(outcome);
                None
            }
            Outcome::Passed | Outcome::NotTested(_) if self.has_contradicted => {
                Some(Outcome::NotTested(Reason::Varies))
            }
            Outcome::Passed | Outcome::NotTested(_) => Some(outcome),
        }
    }

    /// The outcome of the rule after the last test.
    fn outcome(self) -> Outcome {
        match self.unprepared {
            Some(unprepared) if self.broken == 0 => unprepared,
            _ if self.is_disturbed => Outcome::NotTested(Reason::Disturbed),
            _ => Outcome::NotTested(Reason::Varies),
        }
    }
}

/// Tests the rule until its outcome is known. The slave is released after each test.
pub fn test(check: &Check, dialogue: &mut Dialogue<'_>) -> Result<Outcome, PortError> {
    let mut tests = Tests::default();
    for _ in 0..ATTEMPTS {
        dialogue.take_disturbed();
        let outcome = run_check(check, dialogue)?;
        let has_withheld = dialogue.take_withheld();
        let answers = answers(dialogue)?;
        dialogue.take_withheld();
        if has_withheld {
            return Ok(Outcome::NotTested(Reason::NeedsWrites));
        }
        if !answers {
            return Ok(SILENT);
        }
        let is_disturbed = dialogue.take_disturbed();
        tests.is_disturbed |= is_disturbed;
        if is_disturbed || has_failed(&outcome) {
            dialogue.settle()?;
        }
        let known = if is_disturbed { None } else { tests.add(outcome) };
        if let Some(outcome) = known {
            return Ok(outcome);
        }
    }
    Ok(tests.outcome())
}

/// Whether the slave did not do what a step of the test expects.
const fn has_failed(outcome: &Outcome) -> bool {
    matches!(outcome, Outcome::Broken { .. } | Outcome::NotTested(Reason::Unprepared(_)))
}

/// Releases the slave. Returns whether it answers.
pub fn answers(dialogue: &mut Dialogue<'_>) -> Result<bool, PortError> {
    for _ in 0..LISTENS {
        if dialogue.release_and_listen()? {
            return Ok(true);
        }
    }
    Ok(false)
}

fn run_check(check: &Check, dialogue: &mut Dialogue<'_>) -> Result<Outcome, PortError> {
    dialogue.take_last();
    match (check.run)(dialogue) {
        Ok(()) => Ok(Outcome::Passed),
        Err(CheckError::NotTested(reason)) => Ok(Outcome::NotTested(reason)),
        Err(CheckError::Broken(expected)) => Ok(Outcome::Broken { expected, shown: dialogue.take_last() }),
        Err(CheckError::Port(error)) => Err(error),
    }
}
