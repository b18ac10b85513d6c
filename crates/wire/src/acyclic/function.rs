//! Function numbers of PDUs, and the errors of parsing a PDU. profibus-wire 4.1.

use crate::octets::TooShort;
use core::fmt;

/// Bit 7 of the function number: a negative response.
pub(super) const NEGATIVE: u8 = 0x80;

/// The function of a PDU: its number without the bit for negative responses.
///
/// ```
/// use profivac_wire::acyclic::Function;
///
/// assert_eq!(Function::Read.number(), 0x5E);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Function {
    /// Idle keeps a connection open
    Idle = 0x48,
    /// Data_Transport
    DataTransport = 0x51,
    /// The answer of the resource manager
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
    /// The octet on the wire, without the bit for negative responses.
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

/// Error of a data unit that is not a PDU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PduError {
    /// The data unit is empty: a poll.
    Empty,
    /// The function number is not defined in this direction.
    Function(u8),
    /// The PDU is shorter or longer than its fields, or a length octet is out of range.
    Length(Function),
    /// The resource manager names an access point above 48.
    AccessPoint(u8),
    /// Initiate: the length of an additional address does not fit its type.
    Address,
}

impl fmt::Display for PduError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("a poll is no PDU"),
            Self::Function(number) => write!(f, "there is no function {number:02X}"),
            Self::Length(function) => write!(f, "the length of {function} does not fit its fields"),
            Self::AccessPoint(found) => write!(f, "expected an access point from 0 to 48, got {found}"),
            Self::Address => f.write_str("type and length of an additional address contradict each other"),
        }
    }
}

impl core::error::Error for PduError {}

/// Why the octets after a function number are wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FieldError {
    /// They end before the last field.
    TooShort,
    /// Octets follow the last field.
    Surplus,
    /// A length octet is out of range, or differs from the number of octets that follow.
    Length,
    /// An access point is above 48.
    AccessPoint(u8),
}

impl FieldError {
    /// The error of a PDU with this function.
    pub(super) const fn of(self, function: Function) -> PduError {
        match self {
            Self::TooShort | Self::Surplus | Self::Length => PduError::Length(function),
            Self::AccessPoint(found) => PduError::AccessPoint(found),
        }
    }
}

impl From<TooShort> for FieldError {
    fn from(TooShort: TooShort) -> Self {
        Self::TooShort
    }
}
