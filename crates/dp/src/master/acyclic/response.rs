//! Whether a PDU is the response to a request. profibus-wire 4.11 and 9.5.
//!
//! The link layer has already compared source, access points and function code. Here follow the function of the PDU, slot,
//! index and length: a response that differs in any of them never becomes a value.

use core::fmt;
use profivac_wire::acyclic::record::MAX_RECORD_LENGTH;
use profivac_wire::acyclic::{Access, AlarmAck, Function, PduError, Response};

/// The response that a request expects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::master) enum ExpectedResponse {
    ResourceManager,
    Initiate,
    Idle,
    /// The access has the length that was requested.
    Read(Access),
    /// The access has the length that was written.
    Write(Access),
    /// The access has the longest length possible; the slave chooses the length.
    Transport(Access),
    AlarmAck(AlarmAck),
}

impl ExpectedResponse {
    /// Whether the request does no harm if the slave executes it twice.
    pub(in crate::master) const fn is_repeatable(&self) -> bool {
        match self {
            Self::ResourceManager | Self::Initiate | Self::Idle | Self::Read(_) => true,
            Self::Write(_) | Self::Transport(_) | Self::AlarmAck(_) => false,
        }
    }

    /// Whether the request is sent again when an answer was lost. An Initiate would open another connection.
    pub(in crate::master) const fn is_resent(&self) -> bool {
        matches!(self, Self::Idle | Self::Read(_))
    }
}

/// How a response differs from the expected one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ResponseMismatch {
    /// The octets are no response PDU.
    Malformed(PduError),
    /// The response belongs to another function.
    Function {
        /// The function of the request.
        expected: Function,
        /// The function of the response.
        received: Function,
    },
    /// The response names another slot and index, or another slot and alarm type.
    Location {
        /// Slot and index of the request.
        expected: (u8, u8),
        /// Slot and index of the response.
        received: (u8, u8),
    },
    /// The response has more octets than requested, or not as many as written.
    Length {
        /// The number of octets requested or written.
        expected: usize,
        /// The number of octets received.
        received: usize,
    },
    /// The response acknowledges another alarm of the same type and slot.
    Specifier,
}

impl fmt::Display for ResponseMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Malformed(error) => write!(f, "the response is malformed: {error}"),
            Self::Function { expected, received } => {
                write!(f, "the response is one to {received} instead of {expected}")
            }
            Self::Location { expected: (slot, index), received: (other_slot, other_index) } => {
                write!(f, "the response is about {other_slot}/{other_index} instead of {slot}/{index}")
            }
            Self::Length { expected, received } => {
                write!(f, "the response has a length of {received} octets, expected were {expected}")
            }
            Self::Specifier => f.write_str("the response acknowledges another alarm"),
        }
    }
}

impl core::error::Error for ResponseMismatch {}

impl ExpectedResponse {
    const fn function(&self) -> Function {
        match self {
            Self::ResourceManager => Function::ResourceManager,
            Self::Initiate => Function::Initiate,
            Self::Idle => Function::Idle,
            Self::Read(_) => Function::Read,
            Self::Write(_) => Function::Write,
            Self::Transport(_) => Function::DataTransport,
            Self::AlarmAck(_) => Function::AlarmAck,
        }
    }

    /// The response in `pdu`: the one expected, its negative form, or Abort.
    pub(in crate::master) fn matched<'a>(&self, pdu: &'a [u8]) -> Result<Response<'a>, ResponseMismatch> {
        let response = Response::parse(pdu).map_err(ResponseMismatch::Malformed)?;
        match (self, &response) {
            (_, Response::Abort(_))
            | (Self::ResourceManager, Response::ResourceManager(_))
            | (Self::Idle, Response::Idle(_)) => {}
            (_, Response::Negative(negative)) if self.is_refused_as(negative.function) => {}
            (Self::Initiate, Response::Initiate(initiate)) => {
                at_most(MAX_RECORD_LENGTH, initiate.max_len_data_unit.into())?;
            }
            (Self::Read(wanted), Response::Read(record)) => {
                same_location(wanted, record.slot, record.index)?;
                at_most(wanted.length.into(), record.data.len())?;
            }
            (Self::Write(written), Response::Write(access)) => {
                same_location(written, access.slot, access.index)?;
                exactly(written.length.into(), access.length.into())?;
            }
            (Self::Transport(most), Response::DataTransport(record)) => {
                same_location(most, record.slot, record.index)?;
                at_most(most.length.into(), record.data.len())?;
            }
            (Self::AlarmAck(sent), Response::AlarmAck(echo)) => same_alarm(sent, echo)?,
            _ => return Err(self.other_function(&response)),
        }
        Ok(response)
    }

    /// The error for a `response` to another function.
    pub(in crate::master) const fn other_function(&self, response: &Response<'_>) -> ResponseMismatch {
        ResponseMismatch::Function { expected: self.function(), received: response.function() }
    }

    /// Whether a negative response to `function` refuses this request. The resource manager refuses with Initiate.
    fn is_refused_as(&self, function: Function) -> bool {
        match self {
            Self::ResourceManager => function == Function::Initiate,
            _ => function == self.function(),
        }
    }
}

fn same_location(expected: &Access, slot: u8, index: u8) -> Result<(), ResponseMismatch> {
    let (expected, received) = ((expected.slot, expected.index), (slot, index));
    if expected == received { Ok(()) } else { Err(ResponseMismatch::Location { expected, received }) }
}

const fn at_most(expected: usize, received: usize) -> Result<(), ResponseMismatch> {
    if received <= expected { Ok(()) } else { Err(ResponseMismatch::Length { expected, received }) }
}

const fn exactly(expected: usize, received: usize) -> Result<(), ResponseMismatch> {
    if received == expected { Ok(()) } else { Err(ResponseMismatch::Length { expected, received }) }
}

fn same_alarm(sent: &AlarmAck, echo: &AlarmAck) -> Result<(), ResponseMismatch> {
    let (expected, received) = ((sent.slot, sent.alarm_type), (echo.slot, echo.alarm_type));
    match (expected == received, sent.specifier == echo.specifier) {
        (false, _) => Err(ResponseMismatch::Location { expected, received }),
        (true, false) => Err(ResponseMismatch::Specifier),
        (true, true) => Ok(()),
    }
}
