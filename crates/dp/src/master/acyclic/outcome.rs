//! Results and errors that the acyclic services share.

use super::response::ResponseMismatch;
use crate::link::active::Failure;
use core::fmt;
use profivac_wire::acyclic::{AbortReason, Negative};
use profivac_wire::control::Status;

/// An event of an acyclic request or connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum AcyclicEvent {
    /// An outcome can be taken.
    OutcomeReady,
    /// The MS2 connection has ended.
    Ended(ConnectionEnd),
}

/// How an MS2 connection ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConnectionEnd {
    /// The user closed it, for this reason.
    Closed(AbortReason),
    /// The slave refused to open it.
    Refused(Negative),
    /// The slave aborted it.
    Aborted(AbortReason),
    /// This master gave it up. It sent the reason to the slave if it knew the access point and that was still open.
    Failed {
        /// The reason code.
        reason: AbortReason,
        /// The cause.
        cause: Cause,
    },
}

/// The reason why an MS1 or MS2 request failed at this master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Cause {
    /// No response came in time.
    Timeout,
    /// The slave did not answer at all for too long.
    NoAnswer(Failure),
    /// The access point answered with this status, after all repetitions.
    Status(Status),
    /// The response does not fit the request.
    Mismatch(ResponseMismatch),
}

impl fmt::Display for ConnectionEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Closed(reason) => write!(f, "the MS2 connection was closed: {reason}"),
            Self::Refused(negative) => write!(f, "the slave refused the MS2 connection: {}", negative.code_1),
            Self::Aborted(reason) => write!(f, "the slave aborted the MS2 connection: {reason}"),
            Self::Failed { reason, cause } => write!(f, "the MS2 connection failed: {cause}; {reason}"),
        }
    }
}

impl core::error::Error for ConnectionEnd {}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Timeout => f.write_str("no response in time"),
            Self::NoAnswer(failure) => failure.fmt(f),
            Self::Status(Status::ServiceNotActivated) => f.write_str("the service access point is closed (RS)"),
            Self::Status(Status::NoResource) => f.write_str("the slave has no room for the request (RR)"),
            Self::Status(Status::UserError) => f.write_str("the slave's application has failed (UE)"),
            Self::Status(status) => write!(f, "a function code that no DP-V1 response has: {status:?}"),
            Self::Mismatch(mismatch) => mismatch.fmt(f),
        }
    }
}

impl core::error::Error for Cause {}

/// The reason why the master did not accept a request. Nothing was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SubmitError {
    /// All slots of the service are in use.
    Full {
        /// The number of slots.
        slots: usize,
    },
    /// The handle names nothing, or nothing any more.
    UnknownHandle,
    /// A request is under way there.
    Busy,
    /// The connection is not open yet, or not any more.
    NotOpen,
    /// No slave can have this address.
    Address(u8),
    /// The length of the record is 0, or more than the connection or the service carries.
    Length {
        /// The length in octets.
        octets: usize,
        /// The most octets possible.
        room: usize,
    },
    /// The master does not exchange data with the slave.
    NotExchanging(u8),
    /// DP-V1 was not enabled at the slave: bit 7 of its first user parameter octet.
    NotEnabled(u8),
    /// The master is not in Operate.
    NotOperating,
    /// The images of the slave have no parameter channel at the given offsets.
    NoChannel,
}

impl fmt::Display for SubmitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full { slots } => write!(f, "all {slots} slots are in use"),
            Self::UnknownHandle => f.write_str("there is no such request or connection"),
            Self::Busy => f.write_str("the request before is not finished"),
            Self::NotOpen => f.write_str("the MS2 connection is not open"),
            Self::Address(address) => write!(f, "no slave can have the address {address}"),
            Self::Length { octets, room } => write!(f, "a record of {octets} octets: it must have 1 to {room}"),
            Self::NotExchanging(address) => write!(f, "there is no data exchange with slave {address}"),
            Self::NotEnabled(address) => write!(f, "DP-V1 is not enabled at slave {address}"),
            Self::NotOperating => f.write_str("the master is not in Operate"),
            Self::NoChannel => f.write_str("the cyclic data have no parameter channel there"),
        }
    }
}

impl core::error::Error for SubmitError {}
