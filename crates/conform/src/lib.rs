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
pub mod probe;
pub mod talk;

use probe::{Heard, Probe};
use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime};
use profivac_host::port::{Port, PortError};
use profivac_host::segment::Segment;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};
use talk::{Exchange, Subject, Talk, Wire, Wrong};

/// What became of a check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The rule holds.
    Holds,
    /// It does not.
    Broken {
        /// What was expected.
        expected: String,
        /// What was said last, and what came.
        shown: Option<Exchange>,
    },
    /// It cannot be said of this slave, and why.
    Skipped(&'static str),
}

/// A check and what became of it.
pub struct Finding {
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
    wire: &mut dyn Wire,
    subject: &Subject,
    mut tell: impl FnMut(&Finding) -> ControlFlow<()>,
) -> Result<Vec<Finding>, PortError> {
    let mut talk = Talk::new(wire, subject);
    let mut findings = Vec::new();
    for check in checks::all() {
        talk.take_log();
        let checked = (check.ask)(&mut talk);
        let outcome = match checked {
            Ok(()) => Outcome::Holds,
            Err(Wrong::NotApplicable(why)) => Outcome::Skipped(why),
            Err(Wrong::Port(error)) => return Err(error),
            Err(Wrong::Broken(expected)) => {
                let shown = talk.take_log().pop();
                recover(&mut talk)?;
                Outcome::Broken { expected, shown }
            }
        };
        let finding = Finding { check, outcome };
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
fn recover(talk: &mut Talk<'_>) -> Result<(), PortError> {
    match talk.release() {
        Err(Wrong::Port(error)) => Err(error),
        Ok(()) | Err(Wrong::Broken(_) | Wrong::NotApplicable(_)) => Ok(()),
    }
}

/// The way to a slave through a port, in real time.
pub struct PortWire {
    segment: Segment<[Probe; 1]>,
    baud: Baud,
}

impl PortWire {
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

impl Wire for PortWire {
    fn address(&self) -> u8 {
        let [probe] = self.segment.stations();
        probe.address()
    }

    fn ask(&mut self, octets: &[u8]) -> Result<Heard, PortError> {
        self.probe().say(octets);
        loop {
            self.segment.serve(&[], Duration::from_secs(1))?;
            if let Some(heard) = self.probe().heard() {
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
