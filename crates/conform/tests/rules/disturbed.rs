//! A line that disturbs the test at random: it loses, damages and delays telegrams, and the computer stops the program.

use profivac_conform::dialogue::Link;
use profivac_conform::probe::Received;
use profivac_host::port::PortError;
use std::time::Duration;

/// A disturbance on the way from the program to the slave and back.
#[derive(Clone, Copy, Debug)]
enum Disturbance {
    /// The request comes in two pieces with a pause between them, which the slave discards. The link does not notice it.
    RequestLost,
    /// The answer comes in two pieces with a pause between them, or with a wrong bit.
    AnswerDamaged,
    /// The answer comes behind the slot time, before the next request.
    AnswerLate,
    /// The answer comes behind the next request, in place of the answer to that.
    AnswerLater,
    /// The computer stops the program.
    Stall,
}

/// Disturbances that the link notices.
pub const NOTICED: Disturbances =
    Disturbances(&[Disturbance::AnswerDamaged, Disturbance::AnswerLate, Disturbance::AnswerLater, Disturbance::Stall]);

/// All disturbances.
pub const ALL: Disturbances = Disturbances(&[
    Disturbance::RequestLost,
    Disturbance::AnswerDamaged,
    Disturbance::AnswerLate,
    Disturbance::AnswerLater,
    Disturbance::Stall,
]);

/// Disturbances that occur on a line.
#[derive(Clone, Copy)]
pub struct Disturbances(&'static [Disturbance]);

/// A link that is disturbed.
pub struct DisturbedLine<L> {
    line: L,
    disturbances: Disturbances,
    /// The probability of a disturbance for each telegram and each wait.
    probability: f64,
    random: fastrand::Rng,
    /// An answer that comes behind the next request.
    later: Option<Received>,
    is_disturbed: bool,
}

/// Longer than the watchdogs of the rules.
const STALL: Duration = Duration::from_millis(600);

impl<L: Link> DisturbedLine<L> {
    pub fn new(line: L, disturbances: Disturbances, probability: f64, seed: u64) -> Self {
        let random = fastrand::Rng::with_seed(seed);
        Self { line, disturbances, probability, random, later: None, is_disturbed: false }
    }

    fn next_disturbance(&mut self) -> Option<Disturbance> {
        let occurs = self.random.f64() < self.probability;
        occurs.then(|| self.random.choice(self.disturbances.0).copied()).flatten()
    }

    fn stall(&mut self) -> Result<(), PortError> {
        self.is_disturbed = true;
        self.line.wait(STALL)
    }
}

impl<L: Link> Link for DisturbedLine<L> {
    fn address(&self) -> u8 {
        self.line.address()
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        let disturbance = self.next_disturbance();
        if let Some(Disturbance::RequestLost) = disturbance {
            return Ok(Received::Nothing);
        }
        if let Some(Disturbance::Stall) = disturbance {
            self.stall()?;
        }
        let received = self.line.send_and_receive(octets)?;
        if let Some(later) = self.later.take() {
            self.is_disturbed = true;
            return Ok(later);
        }
        if received == Received::Nothing {
            return Ok(received);
        }
        Ok(match disturbance {
            None | Some(Disturbance::RequestLost | Disturbance::Stall) => received,
            Some(Disturbance::AnswerDamaged) => Received::Damaged,
            Some(Disturbance::AnswerLate) => {
                self.is_disturbed = true;
                Received::Nothing
            }
            Some(Disturbance::AnswerLater) => {
                self.later = Some(received);
                Received::Nothing
            }
        })
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        if let Some(Disturbance::Stall) = self.next_disturbance() {
            self.stall()?;
        }
        self.line.wait(time)
    }

    fn take_disturbed(&mut self) -> bool {
        std::mem::take(&mut self.is_disturbed)
    }
}
