//! Whether a PDU is the response to a request. profibus-wire 4.11 and 9.5.
//!
//! Source, access points and function code were compared before, by the link layer. Here follow the function of the PDU,
//! slot, index and length: what differs in any of them never becomes a value.

use core::fmt;
use profivac_wire::acyclic::{Access, AlarmAck, Function, PduError, Response};

/// What a response must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::master) enum ExpectedResponse {
    ResourceManager,
    Initiate,
    Idle,
    /// With the length wanted.
    Read(Access),
    /// With the length written.
    Write(Access),
    /// With the longest data possible; it chooses its own.
    Transport(Access),
    AlarmAck(AlarmAck),
}

impl ExpectedResponse {
    /// Whether the request does no harm if the slave does it twice.
    pub(in crate::master) const fn is_repeatable(&self) -> bool {
        match self {
            Self::ResourceManager | Self::Initiate | Self::Idle | Self::Read(_) => true,
            Self::Write(_) | Self::Transport(_) | Self::AlarmAck(_) => false,
        }
    }
}

/// What does not fit in a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResponseMismatch {
    /// It is no response at all.
    Malformed(PduError),
    /// It responds to another function.
    Function {
        /// The function of the request.
        expected: Function,
        /// The function of the response.
        received: Function,
    },
    /// It is about another record, or another alarm type and slot.
    Place {
        /// Slot and index of the request.
        expected: (u8, u8),
        /// Slot and index of the response.
        received: (u8, u8),
    },
    /// It has more octets than wanted, or not as many as written.
    Length {
        /// How many it may have, or must have.
        expected: usize,
        /// How many it has.
        received: usize,
    },
    /// It acknowledges another alarm of the same type and slot.
    Specifier,
}

impl fmt::Display for ResponseMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Malformed(defect) => write!(f, "the response is malformed: {defect}"),
            Self::Function { expected, received } => {
                write!(f, "the response is one to {received} instead of {expected}")
            }
            Self::Place { expected: (slot, index), received: (other_slot, other_index) } => {
                write!(f, "the response is about {other_slot}/{other_index} instead of {slot}/{index}")
            }
            Self::Length { expected, received } => {
                write!(f, "the response has a length of {received} octets, expected were {expected}")
            }
            Self::Specifier => f.write_str("the response acknowledges another alarm"),
        }
    }
}

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
            (_, Response::Negative(negative)) if self.refused_as(negative.function) => {}
            (Self::Initiate, Response::Initiate(initiate)) => at_most(240, initiate.max_len_data_unit.into())?,
            (Self::Read(wanted), Response::Read(record)) => {
                same_place(wanted, record.slot, record.index)?;
                at_most(wanted.length.into(), record.data.len())?;
            }
            (Self::Write(written), Response::Write(access)) => {
                same_place(written, access.slot, access.index)?;
                exactly(written.length.into(), access.length.into())?;
            }
            (Self::Transport(most), Response::DataTransport(record)) => {
                same_place(most, record.slot, record.index)?;
                at_most(most.length.into(), record.data.len())?;
            }
            (Self::AlarmAck(sent), Response::AlarmAck(echo)) => same_alarm(sent, echo)?,
            _ => return Err(self.other_than(&response)),
        }
        Ok(response)
    }

    /// `response` is to another function.
    pub(in crate::master) const fn other_than(&self, response: &Response<'_>) -> ResponseMismatch {
        ResponseMismatch::Function { expected: self.function(), received: response.function() }
    }

    /// The resource manager refuses as Initiate.
    fn refused_as(&self, function: Function) -> bool {
        match self {
            Self::ResourceManager => function == Function::Initiate,
            _ => function == self.function(),
        }
    }
}

fn same_place(expected: &Access, slot: u8, index: u8) -> Result<(), ResponseMismatch> {
    let (expected, received) = ((expected.slot, expected.index), (slot, index));
    if expected == received { Ok(()) } else { Err(ResponseMismatch::Place { expected, received }) }
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
        (false, _) => Err(ResponseMismatch::Place { expected, received }),
        (true, false) => Err(ResponseMismatch::Specifier),
        (true, true) => Ok(()),
    }
}
