//! The steps of a check: each fails with a [`StepError`], and the check decides what that means.

use crate::expected::{Expected, Reason, Service};
use crate::probe::Received;
use profivac_host::port::PortError;

/// The reason why a step failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The slave did something else.
    #[error("expected {0}")]
    Unexpected(Expected),
    /// The port is lost.
    #[error(transparent)]
    Port(#[from] PortError),
}

/// Result of a step.
pub type StepResult<T = ()> = Result<T, StepError>;

/// The reason why a check ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckError {
    /// The slave breaks the rule.
    #[error("expected {0}")]
    Broken(Expected),
    /// The rule was not tested.
    #[error("not tested: {0}")]
    NotTested(Reason),
    /// The port is lost.
    #[error(transparent)]
    Port(#[from] PortError),
}

/// Result of a check.
pub type CheckOutcome<T = ()> = Result<T, CheckError>;

/// What the failure of a step means for the rule.
pub trait Step<T> {
    /// The rule itself: the slave breaks it.
    ///
    /// # Errors
    /// [`CheckError::Broken`].
    fn tested(self) -> CheckOutcome<T>;

    /// A preparation: the rule was not tested.
    ///
    /// # Errors
    /// [`CheckError::NotTested`].
    fn prepared(self) -> CheckOutcome<T>;
}

impl<T> Step<T> for StepResult<T> {
    fn tested(self) -> CheckOutcome<T> {
        self.map_err(|error| match error {
            StepError::Unexpected(expected) => CheckError::Broken(expected),
            StepError::Port(error) => CheckError::Port(error),
        })
    }

    fn prepared(self) -> CheckOutcome<T> {
        self.map_err(|error| match error {
            StepError::Unexpected(expected) => CheckError::NotTested(Reason::Unprepared(expected)),
            StepError::Port(error) => CheckError::Port(error),
        })
    }
}

/// Fails unless the condition `holds`.
///
/// # Errors
/// [`StepError::Unexpected`].
pub fn require(holds: bool, expected: Expected) -> StepResult {
    if holds { Ok(()) } else { Err(StepError::Unexpected(expected)) }
}

/// Fails unless `received` is the telegram `before` once more.
///
/// # Errors
/// [`StepError::Unexpected`].
pub fn require_same(received: Received, before: Received) -> StepResult {
    match before {
        Received::Telegram(octets) => {
            require(received == Received::Telegram(octets.clone()), Expected::SameAnswer(octets))
        }
        Received::Nothing | Received::Damaged => Err(StepError::Unexpected(Expected::Answer)),
    }
}

/// Ends the check: the slave does not have the service.
///
/// # Errors
/// [`CheckError::NotTested`], always.
pub const fn without<T>(service: Service) -> CheckOutcome<T> {
    Err(CheckError::NotTested(Reason::Without(service)))
}
