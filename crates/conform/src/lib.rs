#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! | Module | Contents |
//! |---|---|
//! | [`probe`] | the station that sends any octets and keeps the answer |
//! | [`expected`] | what a rule expects, and why one was not tested |
//! | [`dialogue`] | requests, answers, and the steps of a check |
//! | [`checks`] | the rules |

pub mod checks;
pub mod dialogue;
pub mod expected;
pub mod probe;

use checks::Check;
use dialogue::{CheckError, CountMode, Dialogue, Link, LoggedCycle, SlaveUnderTest};
use expected::{Expected, Reason};
use probe::{Probe, Received};
use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime};
use profivac_host::clock::{duration_of, tbit_of};
use profivac_host::port::{Port, PortError};
use profivac_host::segment::Segment;
use std::ops::ControlFlow;
use std::time::Duration;

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
/// after each check.
///
/// # Errors
/// [`PortError`] if the port is lost.
pub fn run(
    link: &mut dyn Link,
    slave: &SlaveUnderTest,
    mut report: impl FnMut(&CheckResult) -> ControlFlow<()>,
) -> Result<Vec<CheckResult>, PortError> {
    let mut dialogue = Dialogue::new(link, slave);
    let mut results = Vec::new();
    let mut answers = true;
    for check in checks::all() {
        dialogue.set_count_mode(count_mode(check, &results));
        let outcome = match obstacle(check, &results) {
            Some(reason) => Outcome::NotTested(reason),
            None => {
                let outcome = if answers { run_check(check, &mut dialogue)? } else { SILENT };
                let has_withheld = dialogue.take_withheld();
                answers = dialogue.release_and_listen()?;
                dialogue.take_withheld();
                if has_withheld {
                    Outcome::NotTested(Reason::NeedsWrites)
                } else if answers {
                    outcome
                } else {
                    silenced(outcome)
                }
            }
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

const SILENT: Outcome = Outcome::NotTested(Reason::Silent);

fn run_check(check: &Check, dialogue: &mut Dialogue<'_>) -> Result<Outcome, PortError> {
    dialogue.take_last();
    match (check.run)(dialogue) {
        Ok(()) => Ok(Outcome::Passed),
        Err(CheckError::NotTested(reason)) => Ok(Outcome::NotTested(reason)),
        Err(CheckError::Broken(expected)) => Ok(Outcome::Broken { expected, shown: dialogue.take_last() }),
        Err(CheckError::Port(error)) => Err(error),
    }
}

/// The outcome of a check after which the slave does not answer any more. Then silence proves nothing: only a wrong answer does.
fn silenced(outcome: Outcome) -> Outcome {
    match outcome {
        Outcome::Broken { shown: Some(LoggedCycle { received: Received::Telegram(_), .. }), .. } => outcome,
        Outcome::Passed | Outcome::Broken { .. } | Outcome::NotTested(_) => SILENT,
    }
}

/// Why `check` cannot be tested: a rule that it needs is broken, or was not tested itself for this reason; or the slave breaks
/// a rule whose fault may show itself in this one again.
fn obstacle(check: &Check, results: &[CheckResult]) -> Option<Reason> {
    let broken = results.iter().filter(|result| matches!(result.outcome, Outcome::Broken { .. }));
    let mut shared = broken.map(|result| result.check.name).filter(|name| check.shares.contains(name));
    let mut needed = check.needs.iter().filter_map(|name| results.iter().find(|result| result.check.name == *name));
    let reason = |result: &CheckResult| match &result.outcome {
        Outcome::Passed => None,
        Outcome::Broken { .. } => Some(Reason::After(result.check.name)),
        Outcome::NotTested(reason) => Some(reason.clone()),
    };
    needed.find_map(reason).or_else(|| shared.next().map(Reason::After))
}

/// The frame count bits of a check. First requests serve until the rules about frame count bits are tested, and after them if
/// the slave breaks one, so that its fault is not counted again. A slave that does not execute first requests gets counted ones.
fn count_mode(check: &Check, results: &[CheckResult]) -> CountMode {
    let is_count = |check: &Check| check.name.starts_with(checks::COUNT);
    let is_broken = |result: &&CheckResult| matches!(result.outcome, Outcome::Broken { .. });
    let broken: Vec<_> =
        results.iter().filter(is_broken).map(|result| result.check).filter(|check| is_count(check)).collect();
    let remain = checks::all().skip_while(|other| other.name != check.name).any(is_count);
    match broken.first() {
        Some(rule) if rule.name == checks::FIRST_REQUEST => CountMode::Alternating,
        None if !remain => CountMode::Alternating,
        Some(_) | None => CountMode::First,
    }
}

/// A link to the slave through a port, in real time.
pub struct PortLink {
    segment: Segment<[Probe; 1]>,
    baud: Baud,
}

impl PortLink {
    /// A link through `port`. `bus` has the address of the testing master.
    #[must_use]
    pub fn new(port: Box<dyn Port>, baud: Baud, bus: BusParameters) -> Self {
        Self { segment: Segment::new(port, baud, false, [Probe::new(bus, BitTime(0))]).measuring(), baud }
    }

    /// Listens for the timeout after which a master may claim the line. Returns the address of a master that uses the line.
    ///
    /// # Errors
    /// [`PortError`] if the port is lost.
    pub fn listen(&mut self) -> Result<Option<u8>, PortError> {
        let tbit = self.probe().timeout_tbit();
        self.wait(duration_of(self.baud, tbit))?;
        Ok(self.probe().other_master())
    }

    /// The time by which an answer came after its request, if that was longer than the slot time: then the outcomes of the rules
    /// prove nothing.
    #[must_use]
    pub fn late_answer(&self) -> Option<Duration> {
        let [probe] = self.segment.stations();
        let turnaround_tbit = self.segment.measured().turnaround_tbit;
        (turnaround_tbit > probe.slot_tbit()).then(|| duration_of(self.baud, turnaround_tbit))
    }

    /// The address of another master that was received since the link was opened. Does not wait.
    #[must_use]
    pub fn other_master(&self) -> Option<u8> {
        let [probe] = self.segment.stations();
        probe.other_master()
    }

    /// The baud rate of the line.
    #[must_use]
    pub const fn baud(&self) -> Baud {
        self.baud
    }

    fn probe(&mut self) -> &mut Probe {
        let [probe] = self.segment.stations_mut();
        probe
    }
}

impl Link for PortLink {
    fn address(&self) -> u8 {
        let [probe] = self.segment.stations();
        probe.address()
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        self.probe().send(octets);
        loop {
            self.segment.serve(&[], Duration::from_secs(1))?;
            if let Some(received) = self.probe().received() {
                return Ok(received.clone());
            }
        }
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        let end = self.segment.now() + tbit_of(self.baud, time);
        while self.segment.now() < end {
            self.segment.serve(&[], duration_of(self.baud, end - self.segment.now()))?;
        }
        Ok(())
    }
}
