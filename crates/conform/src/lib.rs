//! Does a slave keep the rules? Anybody's slave, on any port: it is asked what a master would ask and what none should, and
//! each answer is held against the protocol reference.
//!
//! | Module | Holds |
//! |---|---|
//! | [`probe`] | a station that says anything and writes down what comes back |
//! | [`talk`] | requests, answers, what a check may expect |
//! | [`checks`] | the rules |
//!
//! The slave is parameterised and released again and again, with outputs of zero; whoever uses it must not need it meanwhile.

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

/// What became of a check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The rule holds.
    Passed,
    /// It does not.
    Violated {
        /// What was expected.
        expected: String,
        /// What was said last, and what came.
        shown: Option<LoggedCycle>,
    },
    /// It cannot be said of this slave, and why.
    Skipped(&'static str),
}

/// A check and what became of it.
pub struct CheckResult {
    /// The check.
    pub check: &'static checks::Check,
    /// What became of it.
    pub outcome: Outcome,
}

/// Leads a slave through all checks; `tell` hears of each as soon as it is done, and may break off: the slave is released
/// then.
///
/// # Errors
/// [`PortError`] when the port is lost.
pub fn run(
    wire: &mut dyn Link,
    subject: &SlaveUnderTest,
    mut tell: impl FnMut(&CheckResult) -> ControlFlow<()>,
) -> Result<Vec<CheckResult>, PortError> {
    let mut talk = Dialogue::new(wire, subject);
    let mut findings = Vec::new();
    for check in checks::all() {
        talk.take_log();
        let checked = (check.run)(&mut talk);
        let outcome = match checked {
            Ok(()) => Outcome::Passed,
            Err(CheckError::NotApplicable(why)) => Outcome::Skipped(why),
            Err(CheckError::Port(error)) => return Err(error),
            Err(CheckError::Violated(expected)) => {
                let shown = talk.take_log().pop();
                recover(&mut talk)?;
                Outcome::Violated { expected, shown }
            }
        };
        let finding = CheckResult { check, outcome };
        let goes_on = tell(&finding);
        findings.push(finding);
        if goes_on.is_break() {
            recover(&mut talk)?;
            break;
        }
    }
    Ok(findings)
}

/// The next check begins with a slave that waits for parameters, whatever the one before came to.
fn recover(talk: &mut Dialogue<'_>) -> Result<(), PortError> {
    match talk.release() {
        Err(CheckError::Port(error)) => Err(error),
        Ok(()) | Err(CheckError::Violated(_) | CheckError::NotApplicable(_)) => Ok(()),
    }
}

/// The way to a slave through a port, in real time.
pub struct PortLink {
    segment: Segment<[Probe; 1]>,
    baud: Baud,
}

impl PortLink {
    /// Takes the line of `port`.
    #[must_use]
    pub fn new(port: Box<dyn Port>, baud: Baud, bus: BusParameters) -> Self {
        Self { segment: Segment::new(port, baud, false, [Probe::new(bus, BitTime(0))]), baud }
    }

    /// Listens for as long as a master must before it claims a line. Says which master is using it, if one is.
    ///
    /// # Errors
    /// [`PortError`] when the port is gone.
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
            if let Some(heard) = self.probe().received() {
                return Ok(heard.clone());
            }
        }
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        let begun = Instant::now();
        while let Some(left) = time.checked_sub(begun.elapsed()).filter(|left| !left.is_zero()) {
            self.segment.serve(&[], left)?;
        }
        Ok(())
    }
}
