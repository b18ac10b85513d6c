#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! | Module | Contents |
//! |---|---|
//! | [`probe`] | the station that sends any octets and keeps the answer |
//! | [`dialogue`] | requests, answers, and the expectations of a check |
//! | [`checks`] | the rules |

pub mod checks;
pub mod dialogue;
pub mod probe;

use dialogue::{CheckError, Dialogue, Link, LoggedCycle, SlaveUnderTest};
use probe::{Probe, Received};
use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime};
use profivac_host::port::{Port, PortError};
use profivac_host::segment::Segment;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Outcome of a check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The slave keeps the rule.
    Passed,
    /// The slave violates the rule.
    Violated {
        /// The expected answer.
        expected: String,
        /// The last message cycle of the check.
        shown: Option<LoggedCycle>,
    },
    /// The rule does not apply to this slave, for this reason.
    Skipped(&'static str),
}

/// A check with its outcome.
pub struct CheckResult {
    /// The check.
    pub check: &'static checks::Check,
    /// Its outcome.
    pub outcome: Outcome,
}

/// Runs all checks. Calls `report` with each result; `ControlFlow::Break` ends the run after that check. The slave is released
/// at the end.
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
    for check in checks::all() {
        dialogue.take_log();
        let outcome = match (check.run)(&mut dialogue) {
            Ok(()) => Outcome::Passed,
            Err(CheckError::NotApplicable { reason }) => Outcome::Skipped(reason),
            Err(CheckError::Port(error)) => return Err(error),
            Err(CheckError::Violated { expected }) => {
                let shown = dialogue.take_log().pop();
                recover(&mut dialogue)?;
                Outcome::Violated { expected, shown }
            }
        };
        let result = CheckResult { check, outcome };
        let control = report(&result);
        results.push(result);
        if control.is_break() {
            recover(&mut dialogue)?;
            break;
        }
    }
    Ok(results)
}

/// Releases the slave after a violated rule, so that the next check begins with a slave that waits for parameters.
fn recover(dialogue: &mut Dialogue<'_>) -> Result<(), PortError> {
    match dialogue.release() {
        Err(CheckError::Port(error)) => Err(error),
        Ok(()) | Err(CheckError::Violated { .. } | CheckError::NotApplicable { .. }) => Ok(()),
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
        Self { segment: Segment::new(port, baud, false, [Probe::new(bus, BitTime(0))]), baud }
    }

    /// Listens for the timeout after which a master may claim the line. Returns the address of a master that uses the line.
    ///
    /// # Errors
    /// [`PortError`] if the port is lost.
    pub fn listen(&mut self) -> Result<Option<u8>, PortError> {
        let tbit = self.probe().timeout_tbit();
        self.wait(profivac_host::clock::duration_of(self.baud, tbit))?;
        Ok(self.probe().other_master())
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
        let start = Instant::now();
        while let Some(left) = time.checked_sub(start.elapsed()).filter(|left| !left.is_zero()) {
            self.segment.serve(&[], left)?;
        }
        Ok(())
    }
}
