//! A whole PDU: the function number and what it says. profibus-wire 4.1.

use super::abort::Abort;
use super::error::{NEGATIVE, Negative};
use super::initiate::{Initiate, InitiateRes, ResourceManager};
use super::record::{Access, AlarmAck, Transfer};
use crate::octets::{Reader, TooLong, TooShort, Writer};
use core::fmt;

/// The function number of a PDU, without the bit for negative responses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Function {
    /// Idle
    Idle = 0x48,
    /// Data_Transport
    DataTransport = 0x51,
    /// The resource manager's answer
    ResourceManager = 0x56,
    /// Initiate
    Initiate = 0x57,
    /// Abort
    Abort = 0x58,
    /// Alarm_Ack
    AlarmAck = 0x5C,
    /// Read
    Read = 0x5E,
    /// Write
    Write = 0x5F,
}

impl Function {
    /// The octet on the wire.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8
    }

    pub(super) const fn from_number(number: u8) -> Option<Self> {
        match number {
            0x48 => Some(Self::Idle),
            0x51 => Some(Self::DataTransport),
            0x56 => Some(Self::ResourceManager),
            0x57 => Some(Self::Initiate),
            0x58 => Some(Self::Abort),
            0x5C => Some(Self::AlarmAck),
            0x5E => Some(Self::Read),
            0x5F => Some(Self::Write),
            _ => None,
        }
    }
}

impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Idle => "Idle",
            Self::DataTransport => "Data_Transport",
            Self::ResourceManager => "RM",
            Self::Initiate => "Initiate",
            Self::Abort => "Abort",
            Self::AlarmAck => "Alarm_Ack",
            Self::Read => "Read",
            Self::Write => "Write",
        })
    }
}

/// Why a data unit is no PDU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PduError {
    /// There is not one octet: this is a poll.
    Empty,
    /// No PDU of this direction has this function number.
    Function(u8),
    /// The PDU is shorter or longer than its fields, or a length octet is one it cannot have.
    Length(Function),
    /// Initiate: type and length of an additional address contradict each other.
    Address,
}

impl fmt::Display for PduError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("a poll is no PDU"),
            Self::Function(number) => write!(f, "there is no function {number:02X}"),
            Self::Length(function) => write!(f, "the length of {function} does not fit its fields"),
            Self::Address => f.write_str("type and length of an additional address contradict each other"),
        }
    }
}

impl core::error::Error for PduError {}

/// What a master sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request<'a> {
    /// "I am still here", with the octets that follow the function number (none in practice).
    Idle(&'a [u8]),
    /// Data for the application, and back.
    DataTransport(Transfer<'a>),
    /// Open a connection.
    Initiate(Initiate<'a>),
    /// Close it.
    Abort(Abort<'a>),
    /// An alarm was processed.
    AlarmAck(AlarmAck),
    /// Read a record.
    Read(Access),
    /// Write a record.
    Write(Transfer<'a>),
}

impl<'a> Request<'a> {
    /// Reads a whole PDU.
    ///
    /// # Errors
    /// [`Defect`] says what is wrong with it.
    pub fn parse(pdu: &'a [u8]) -> Result<Self, PduError> {
        let [number, rest @ ..] = pdu else { return Err(PduError::Empty) };
        let function = Function::from_number(*number).ok_or(PduError::Function(*number))?;
        let length = |TooShort| PduError::Length(function);
        let reader = Reader::new(rest);
        match function {
            Function::Idle => Ok(Self::Idle(rest)),
            Function::DataTransport => Transfer::parse(reader, 1).map(Self::DataTransport).map_err(length),
            Function::Initiate => Initiate::parse(reader).map(Self::Initiate),
            Function::Abort => Abort::parse(reader).map(Self::Abort).map_err(length),
            Function::AlarmAck => AlarmAck::parse(reader).map(Self::AlarmAck).map_err(length),
            Function::Read => Access::parse(reader).map(Self::Read).map_err(length),
            Function::Write => Transfer::parse(reader, 1).map(Self::Write).map_err(length),
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
    /// [`Full`] when `out` is too small, or the record longer than 240 octets.
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

/// What a slave returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Response<'a> {
    /// The echo of Idle.
    Idle(&'a [u8]),
    /// Data of the application.
    DataTransport(Transfer<'a>),
    /// Where the connection will be.
    ResourceManager(ResourceManager),
    /// The connection is open.
    Initiate(InitiateRes<'a>),
    /// The slave closes the connection.
    Abort(Abort<'a>),
    /// The alarm is gone.
    AlarmAck(AlarmAck),
    /// The record.
    Read(Transfer<'a>),
    /// It was written.
    Write(Access),
    /// It was refused.
    Negative(Negative),
}

impl<'a> Response<'a> {
    /// Reads a whole PDU.
    ///
    /// # Errors
    /// [`Defect`] says what is wrong with it.
    pub fn parse(pdu: &'a [u8]) -> Result<Self, PduError> {
        let [number, rest @ ..] = pdu else { return Err(PduError::Empty) };
        let unknown = PduError::Function(*number);
        let function = Function::from_number(*number & !NEGATIVE).ok_or(unknown)?;
        let length = |TooShort| PduError::Length(function);
        let reader = Reader::new(rest);
        match (function, *number & NEGATIVE != 0) {
            (Function::Idle, false) => Ok(Self::Idle(rest)),
            (Function::DataTransport, false) => Transfer::parse(reader, 0).map(Self::DataTransport).map_err(length),
            (Function::ResourceManager, false) => {
                ResourceManager::parse(reader).map(Self::ResourceManager).map_err(length)
            }
            (Function::Initiate, false) => InitiateRes::parse(reader).map(Self::Initiate),
            (Function::Abort, false) => Abort::parse(reader).map(Self::Abort).map_err(length),
            (Function::AlarmAck, false) => AlarmAck::parse(reader).map(Self::AlarmAck).map_err(length),
            (Function::Read, false) => Transfer::parse(reader, 0).map(Self::Read).map_err(length),
            (Function::Write, false) => Access::parse(reader).map(Self::Write).map_err(length),
            (Function::Idle | Function::ResourceManager | Function::Abort, true) => Err(unknown),
            (_, true) => Negative::parse(function, reader).map(Self::Negative).map_err(length),
        }
    }

    /// The function number, also where it is the refusal of this function.
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
    /// [`Full`] when `out` is too small, or the record longer than 240 octets.
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
