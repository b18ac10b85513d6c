//! Why a command is not armed or not executed.
//!
//! Each error says by its variant whether something was sent to the gauge: the audit trail and the HTTP status depend on it.

use super::armed_commands::ArmedCommandError;
use super::authority::AuthorityError;
use super::operation::ResolveError;
use crate::snapshot::{Connection, UnknownGauge};
use profivac_client::values::BeyondRange;
use profivac_client::{ClientError, Condition};
use profivac_recorder::AuditError;
use profivac_web_server::auth::Forbidden;

/// The reason why a control request was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    /// The station has no gauge of this name.
    #[error(transparent)]
    UnknownGauge(#[from] UnknownGauge),
    /// The request does not name a command or a parameter of the device.
    #[error(transparent)]
    Request(#[from] ResolveError),
    /// The role of the user does not allow it.
    #[error(transparent)]
    Forbidden(#[from] Forbidden),
    /// The station never does this.
    #[error("{target}: {reason}")]
    Blocked {
        /// The command or parameter.
        target: String,
        /// Why, and what to do instead.
        reason: &'static str,
    },
    /// The user does not have control, or cannot get it.
    #[error(transparent)]
    Authority(#[from] AuthorityError),
    /// The armed command does not exist any more, or belongs to another user.
    #[error(transparent)]
    Command(#[from] ArmedCommandError),
    /// The operation is not possible, or failed.
    #[error(transparent)]
    Operation(#[from] OperationError),
    /// The audit trail cannot be written, so nothing was sent.
    #[error("nothing was sent, because the audit trail cannot be written: {0}")]
    Audit(#[from] AuditError),
}

/// The reason why a segment does not answer a request.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SegmentRequestError {
    /// No running segment has a gauge of this name.
    #[error(transparent)]
    UnknownGauge(#[from] UnknownGauge),
    /// The queue of the segment is full.
    #[error("the segment is busy with other requests: try again")]
    Busy,
    /// The segment cannot do it.
    #[error(transparent)]
    Unavailable(Unavailable),
    /// The segment stopped before it answered.
    #[error("the segment was stopped")]
    Stopped,
    /// No answer within the timeout.
    #[error("the segment did not answer in time")]
    Timeout,
}

/// The reason why an operation was not done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OperationError {
    /// The parameter does not take this value. Nothing was sent.
    #[error(transparent)]
    InvalidValue(Box<ClientError>),
    /// The pressure is outside the measuring range of the gauge. Nothing was sent.
    #[error("{target}: {error}; to write it all the same, request it with \"force\": true")]
    BeyondRange {
        /// The parameter.
        target: String,
        /// The pressure and the range.
        error: BeyondRange,
    },
    /// Some of these conditions do not hold. Nothing was sent.
    #[error("{}", unmet(.0))]
    ConditionsNotMet(Vec<Condition>),
    /// Something is not as it was when the command was armed. Nothing was sent.
    #[error(transparent)]
    Changed(#[from] ChangedSinceArmed),
    /// The gauge cannot be asked. Nothing was sent.
    #[error(transparent)]
    Unavailable(#[from] Unavailable),
    /// The gauge refused it.
    #[error(transparent)]
    Refused(Box<ClientError>),
    /// It was sent, and its outcome is unknown.
    #[error(transparent)]
    OutcomeUnknown(#[from] OutcomeUnknown),
}

/// A change between arming and executing.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChangedSinceArmed {
    /// The gauge is connected elsewhere.
    #[error("{gauge} was on segment {} at {} when it was armed and is on segment {} at {} now", .armed.segment, .armed.port, .now.segment, .now.port)]
    Connection {
        /// The gauge.
        gauge: String,
        /// Where it was.
        armed: Box<Connection>,
        /// Where it is.
        now: Box<Connection>,
    },
    /// Another device has the name of the gauge.
    #[error("{gauge} was {} at address {} when it was armed and is {} at address {} now", .armed.0, .armed.1, .now.0, .now.1)]
    Device {
        /// The gauge.
        gauge: String,
        /// Its device and address then.
        armed: (&'static str, u8),
        /// Its device and address now.
        now: (&'static str, u8),
    },
    /// The parameter has another value.
    #[error("{target} was {armed} when it was armed and is {now} now")]
    Value {
        /// The parameter.
        target: String,
        /// Its value then.
        armed: String,
        /// Its value now.
        now: String,
    },
    /// The given value means other octets.
    #[error("{given} meant {armed} when it was armed and means {now} now")]
    Meaning {
        /// The value as it was given.
        given: String,
        /// Its meaning when the command was armed.
        armed: String,
        /// Its present meaning.
        now: String,
    },
    /// The user has lost control.
    #[error("{user} lost control before the command was sent")]
    ControlLost {
        /// The user.
        user: String,
    },
}

/// The reason why a gauge cannot be asked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Unavailable {
    /// The segment has the gauge of this name no more.
    #[error("the segment has no gauge {0:?} any more: the station's file was read again")]
    UnknownGauge(String),
    /// The gauge is not in data exchange.
    #[error("{0} does not answer")]
    NoAnswer(String),
    /// The segment got to the command too late.
    #[error("the segment of {0} was busy for too long")]
    SegmentBusy(String),
    /// The segment does not run.
    #[error("{0}")]
    SegmentDown(String),
    /// The port was lost.
    #[error("the port is lost")]
    PortLost,
    /// The gauge or the line failed.
    #[error(transparent)]
    Client(Box<ClientError>),
    /// The segment did not answer.
    #[error(transparent)]
    Request(Box<SegmentRequestError>),
}

/// The reason why the outcome of a command that was sent is not known.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutcomeUnknown {
    /// The segment did not answer in time.
    #[error("the gauge did not answer in time")]
    NoAnswer,
    /// The segment was stopped meanwhile.
    #[error("the segment was stopped")]
    SegmentStopped,
    /// The line failed meanwhile.
    #[error(transparent)]
    Line(Box<ClientError>),
    /// The gauge took the command, and its value cannot be read back.
    #[error("the gauge accepted the command, but reading it back failed: {0}")]
    NotReadBack(Box<ClientError>),
}

impl ControlError {
    /// Whether the audit trail has a row about it already: a missing role, unmet conditions, and everything that failed after arming.
    #[must_use]
    pub const fn is_in_audit_trail(&self) -> bool {
        match self {
            Self::Operation(error) => match error {
                OperationError::ConditionsNotMet(_)
                | OperationError::Changed(_)
                | OperationError::Refused(_)
                | OperationError::OutcomeUnknown(_) => true,
                OperationError::InvalidValue(_)
                | OperationError::BeyondRange { .. }
                | OperationError::Unavailable(_) => false,
            },
            Self::Forbidden(_) => true,
            Self::UnknownGauge(_)
            | Self::Request(_)
            | Self::Blocked { .. }
            | Self::Authority(_)
            | Self::Command(_)
            | Self::Audit(_) => false,
        }
    }
}

impl OperationError {
    /// The sentence for the audit trail: it begins with what happened to the command.
    #[must_use]
    pub fn outcome(&self) -> String {
        match self {
            Self::InvalidValue(_)
            | Self::BeyondRange { .. }
            | Self::ConditionsNotMet(_)
            | Self::Changed(_)
            | Self::Unavailable(_) => format!("not sent: {self}"),
            Self::Refused(_) => format!("refused: {self}"),
            Self::OutcomeUnknown(_) => format!("not known: {self}"),
        }
    }
}

impl From<SegmentRequestError> for OperationError {
    fn from(error: SegmentRequestError) -> Self {
        match error {
            SegmentRequestError::Unavailable(unavailable) => unavailable.into(),
            other => Unavailable::Request(Box::new(other)).into(),
        }
    }
}

fn unmet(conditions: &[Condition]) -> String {
    conditions.iter().filter_map(|condition| condition.unmet.as_deref()).collect::<Vec<_>>().join("; ")
}
