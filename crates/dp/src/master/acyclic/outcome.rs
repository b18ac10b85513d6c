//! What becomes of an acyclic request, in words.

use super::response::ResponseMismatch;
use crate::link::active::Failure;
use crate::master::ms2::Opened;
use crate::master::pkw;
use core::fmt;
use profivac_wire::acyclic::{AbortReason, Negative};
use profivac_wire::control::Status;

/// What became of a request, or of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome<'a> {
    /// The MS2 connection is open.
    Opened(Opened),
    /// The record that was read. May be shorter than wanted, also empty.
    Read(&'a [u8]),
    /// The record was written.
    Written,
    /// What the slave returns to a Data_Transport.
    Transported(&'a [u8]),
    /// The alarm was acknowledged.
    Acknowledged,
    /// The slave refused; an MS2 connection stays open.
    Refused(Negative),
    /// The value in the parameter channel.
    Value(pkw::Value),
    /// The slave refused in the parameter channel.
    Denied(pkw::Error),
    /// The request has failed: MS1 and parameter channel.
    Failed(Cause),
    /// The MS2 connection is gone. Its handle is used up.
    Ended(ConnectionEnd),
}

/// How an MS2 connection ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConnectionEnd {
    /// The user closed it, for this reason.
    Closed(AbortReason),
    /// The slave refused to open it.
    Refused(Negative),
    /// The slave aborted it.
    Aborted(AbortReason),
    /// This master gave it up. The slave was told the reason, if its access point was known and still open.
    Failed {
        /// The reason code.
        reason: AbortReason,
        /// What it was.
        cause: Cause,
    },
}

/// Why something failed at this master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// There was no response in time.
    Timeout,
    /// There was no answer for too long.
    Lost(Failure),
    /// The access point answers like this, after all repetitions.
    Status(Status),
    /// The response is none to the request.
    Mismatch(ResponseMismatch),
    /// The parameter channel answered something else all the time.
    Channel(pkw::AnswerMismatch),
    /// The slave left data exchange.
    Left,
    /// The master left Operate: the outputs, and the parameter channel in them, are zero.
    NotOperating,
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
            Self::Lost(failure) => failure.fmt(f),
            Self::Status(Status::ServiceNotActivated) => f.write_str("the service access point is closed (RS)"),
            Self::Status(Status::NoResource) => f.write_str("the slave has no room for the request (RR)"),
            Self::Status(Status::UserError) => f.write_str("the slave's application has failed (UE)"),
            Self::Status(status) => write!(f, "a function code that no DP-V1 response has: {status:?}"),
            Self::Mismatch(wrong) => wrong.fmt(f),
            Self::Channel(wrong) => wrong.fmt(f),
            Self::Left => f.write_str("the slave left data exchange"),
            Self::NotOperating => f.write_str("the master is not in Operate"),
        }
    }
}

impl core::error::Error for Cause {}

/// Why a request was not taken. Nothing was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SubmitError {
    /// There is no place left.
    Full {
        /// How many there are.
        places: usize,
    },
    /// The handle means nothing, or nothing any more.
    UnknownHandle,
    /// A request is under way there, or its outcome was not taken.
    Busy,
    /// The connection is not open yet, or not any more.
    NotOpen,
    /// No slave can have this address.
    Address(u8),
    /// The length of the record is 0, or more than the connection or the service carries.
    Length {
        /// How many octets it has.
        octets: usize,
        /// How many it may have.
        room: usize,
    },
    /// The master does not exchange data with the slave.
    NotExchanging(u8),
    /// DP-V1 was not enabled at the slave: bit 7 of its first user parameter octet.
    NotEnabled(u8),
    /// The master is not in Operate.
    NotOperating,
    /// The images of the slave have no eight octets where the parameter channel should be.
    NoChannel,
}

impl fmt::Display for SubmitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full { places } => write!(f, "all {places} places are in use"),
            Self::UnknownHandle => f.write_str("there is no such request or connection"),
            Self::Busy => f.write_str("the request before is not finished, or its outcome was not taken"),
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
