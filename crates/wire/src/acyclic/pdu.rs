//! Complete PDUs: function number and fields. profibus-wire 4.1.

use super::abort::Abort;
use super::error::Negative;
use super::function::{FieldError, Function, NEGATIVE, PduError};
use super::initiate::{Initiate, InitiateRes, ResourceManager};
use super::record::{Access, AlarmAck, Transfer};
use crate::octets::{Reader, TooLong, Writer};

/// A PDU from a master.
///
/// ```
/// use profivac_wire::acyclic::{Access, Request};
///
/// let read = Request::Read(Access { slot: 1, index: 16, length: 20 });
/// let mut out = [0; 4];
/// assert_eq!(read.emit(&mut out), Ok(4));
/// assert_eq!(out, [0x5E, 1, 16, 20]);
/// assert_eq!(Request::parse(&out), Ok(read));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Request<'a> {
    /// Idle keeps the connection open; with the octets after the function number (none in practice).
    Idle(&'a [u8]),
    /// Data for the application.
    DataTransport(Transfer<'a>),
    /// Opens a connection.
    Initiate(Initiate<'a>),
    /// Closes the connection.
    Abort(Abort<'a>),
    /// Acknowledges an alarm.
    AlarmAck(AlarmAck),
    /// Reads a record.
    Read(Access),
    /// Writes a record.
    Write(Transfer<'a>),
}

impl<'a> Request<'a> {
    /// Parses a complete PDU.
    ///
    /// # Errors
    /// [`PduError`] names the error; [`PduError::Empty`] is a poll.
    pub fn parse(pdu: &'a [u8]) -> Result<Self, PduError> {
        let [number, rest @ ..] = pdu else { return Err(PduError::Empty) };
        let function = Function::from_number(*number).ok_or(PduError::Function(*number))?;
        let wrong = |error: FieldError| error.of(function);
        let reader = Reader::new(rest);
        match function {
            Function::Idle => Ok(Self::Idle(rest)),
            Function::DataTransport => Transfer::parse(reader, 1).map(Self::DataTransport).map_err(wrong),
            Function::Initiate => Initiate::parse(reader).map(Self::Initiate),
            Function::Abort => Abort::parse(reader).map(Self::Abort).map_err(|short| wrong(short.into())),
            Function::AlarmAck => AlarmAck::parse(reader).map(Self::AlarmAck).map_err(wrong),
            Function::Read => Access::parse(reader).map(Self::Read).map_err(wrong),
            Function::Write => Transfer::parse(reader, 1).map(Self::Write).map_err(wrong),
            Function::ResourceManager => Err(PduError::Function(*number)),
        }
    }

    /// The function number.
    #[must_use]
    pub const fn function(&self) -> Function {
        match self {
            Self::Idle(_) => Function::Idle,
            Self::DataTransport(_) => Function::DataTransport,
            Self::Initiate(_) => Function::Initiate,
            Self::Abort(_) => Function::Abort,
            Self::AlarmAck(_) => Function::AlarmAck,
            Self::Read(_) => Function::Read,
            Self::Write(_) => Function::Write,
        }
    }

    /// Writes the PDU to the front of `out` and returns its length.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small, or the record longer than 240 octets.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let mut writer = Writer::new(out);
        writer.octet(self.function().number())?;
        match self {
            Self::Idle(rest) => writer.octets(rest),
            Self::DataTransport(transfer) | Self::Write(transfer) => transfer.emit(&mut writer),
            Self::Initiate(initiate) => initiate.emit(&mut writer),
            Self::Abort(abort) => abort.emit(&mut writer),
            Self::AlarmAck(ack) => ack.emit(&mut writer),
            Self::Read(access) => access.emit(&mut writer),
        }?;
        Ok(writer.written())
    }
}

/// A PDU from a slave.
///
/// ```
/// use profivac_wire::acyclic::{Response, Transfer};
///
/// let response = Response::parse(&[0x5E, 1, 16, 2, 0xAA, 0x55]);
/// assert_eq!(response, Ok(Response::Read(Transfer { slot: 1, index: 16, data: &[0xAA, 0x55] })));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Response<'a> {
    /// The response to Idle.
    Idle(&'a [u8]),
    /// Data from the application.
    DataTransport(Transfer<'a>),
    /// The resource manager assigns an access point.
    ResourceManager(ResourceManager),
    /// The connection is open.
    Initiate(InitiateRes<'a>),
    /// The slave closes the connection.
    Abort(Abort<'a>),
    /// The alarm is acknowledged.
    AlarmAck(AlarmAck),
    /// The value of a record.
    Read(Transfer<'a>),
    /// The record was written.
    Write(Access),
    /// The device refuses the request.
    Negative(Negative),
}

impl<'a> Response<'a> {
    /// Parses a complete PDU.
    ///
    /// # Errors
    /// [`PduError`] names the error; [`PduError::Empty`] is a poll.
    pub fn parse(pdu: &'a [u8]) -> Result<Self, PduError> {
        let [number, rest @ ..] = pdu else { return Err(PduError::Empty) };
        let unknown = PduError::Function(*number);
        let function = Function::from_number(*number & !NEGATIVE).ok_or(unknown)?;
        let wrong = |error: FieldError| error.of(function);
        let reader = Reader::new(rest);
        match (function, *number & NEGATIVE != 0) {
            (Function::Idle, false) => Ok(Self::Idle(rest)),
            (Function::DataTransport, false) => Transfer::parse(reader, 0).map(Self::DataTransport).map_err(wrong),
            (Function::ResourceManager, false) => {
                ResourceManager::parse(reader).map(Self::ResourceManager).map_err(wrong)
            }
            (Function::Initiate, false) => InitiateRes::parse(reader).map(Self::Initiate),
            (Function::Abort, false) => Abort::parse(reader).map(Self::Abort).map_err(|short| wrong(short.into())),
            (Function::AlarmAck, false) => AlarmAck::parse(reader).map(Self::AlarmAck).map_err(wrong),
            (Function::Read, false) => Transfer::parse(reader, 0).map(Self::Read).map_err(wrong),
            (Function::Write, false) => Access::parse(reader).map(Self::Write).map_err(wrong),
            (Function::Idle | Function::ResourceManager | Function::Abort, true) => Err(unknown),
            (_, true) => Negative::parse(function, reader).map(Self::Negative).map_err(wrong),
        }
    }

    /// The function number, for a negative response that of the refused function.
    #[must_use]
    pub const fn function(&self) -> Function {
        match self {
            Self::Idle(_) => Function::Idle,
            Self::DataTransport(_) => Function::DataTransport,
            Self::ResourceManager(_) => Function::ResourceManager,
            Self::Initiate(_) => Function::Initiate,
            Self::Abort(_) => Function::Abort,
            Self::AlarmAck(_) => Function::AlarmAck,
            Self::Read(_) => Function::Read,
            Self::Write(_) => Function::Write,
            Self::Negative(negative) => negative.function,
        }
    }

    const fn number(&self) -> u8 {
        match self {
            Self::Negative(negative) => negative.function.number() | NEGATIVE,
            response => response.function().number(),
        }
    }

    /// Writes the PDU to the front of `out` and returns its length.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small, or the record longer than 240 octets.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let mut writer = Writer::new(out);
        writer.octet(self.number())?;
        match self {
            Self::Idle(rest) => writer.octets(rest),
            Self::DataTransport(transfer) | Self::Read(transfer) => transfer.emit(&mut writer),
            Self::ResourceManager(answer) => answer.emit(&mut writer),
            Self::Initiate(initiate) => initiate.emit(&mut writer),
            Self::Abort(abort) => abort.emit(&mut writer),
            Self::AlarmAck(ack) => ack.emit(&mut writer),
            Self::Write(access) => access.emit(&mut writer),
            Self::Negative(negative) => negative.emit(&mut writer),
        }?;
        Ok(writer.written())
    }
}
