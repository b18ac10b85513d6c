//! What follows from a request: the reply of a station, or the reason why the request could not be sent.

use crate::port::PortError;
use profivac_dp::link::active::{Failure, OutOfRange};
use profivac_wire::control::{StationType, Status};

/// The reason why a session could not send a request.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SessionError {
    /// The port failed.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The bus parameters are out of range.
    #[error("{0}")]
    Parameters(OutOfRange),
    /// Another master uses the line and does not admit this one into its ring.
    #[error("master {0} is using the line")]
    LineInUse(u8),
    /// Another master has the address of this one.
    #[error("another master has the address {0}")]
    AddressInUse(u8),
    /// The line is never idle.
    #[error("the line is never idle")]
    NeverIdle,
    /// The program ends: see [`BusSession::set_cancellation`](super::BusSession::set_cancellation).
    #[error("interrupted by a signal")]
    Interrupted,
}

/// The reply of a station, or its absence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// The station answered.
    Answer {
        /// The type of the station.
        station: StationType,
        /// The status of the answer.
        status: Status,
        /// The data unit.
        du: Vec<u8>,
    },
    /// No station answered, or the answer was invalid.
    NoAnswer(Failure),
}
