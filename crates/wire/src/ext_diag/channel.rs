//! Channel-related blocks: the error of one channel of a module. profibus-wire 2.3.1.

use super::{CHANNEL, LENGTH};
use crate::octets::{Reader, TooLong, TooShort, Writer};
use core::fmt::{self, Display, Formatter};

/// A channel-related block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Channel {
    /// Number of the configuration identifier of the channel, 0 to 63.
    pub identifier: u8,
    /// The channel is an input.
    pub input: bool,
    /// The channel is an output.
    pub output: bool,
    /// Number of the channel, 0 to 63.
    pub number: u8,
    /// Width of the channel.
    pub organisation: Organisation,
    /// Error type.
    pub error: ChannelError,
}

impl Channel {
    pub(super) fn parse(identifier: u8, reader: &mut Reader<'_>) -> Result<Self, TooShort> {
        let (channel, kind) = (reader.octet()?, reader.octet()?);
        Ok(Self {
            identifier,
            input: channel & 0x40 != 0,
            output: channel & 0x80 != 0,
            number: channel & LENGTH,
            organisation: Organisation::from_bits(kind >> 5),
            error: ChannelError(kind & 0x1F),
        })
    }

    pub(super) fn emit(self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        let direction = if self.input { 0x40 } else { 0 } | if self.output { 0x80 } else { 0 };
        let kind = (self.organisation as u8) << 5 | self.error.0 & 0x1F;
        writer.octets(&[CHANNEL | self.identifier & LENGTH, direction | self.number & LENGTH, kind])
    }
}

/// The width of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Organisation {
    /// Reserved code 0.
    Unknown = 0,
    /// One bit.
    Bit = 1,
    /// Two bits.
    TwoBits = 2,
    /// Four bits.
    FourBits = 3,
    /// Eight bits.
    Byte = 4,
    /// 16 bits.
    Word = 5,
    /// 32 bits.
    TwoWords = 6,
    /// Reserved code 7.
    Reserved = 7,
}

impl Organisation {
    /// The name of the width, in English.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unknown => "reserved width 0",
            Self::Bit => "bit",
            Self::TwoBits => "2 bit",
            Self::FourBits => "4 bit",
            Self::Byte => "byte",
            Self::Word => "word",
            Self::TwoWords => "2 words",
            Self::Reserved => "reserved width 7",
        }
    }

    const fn from_bits(bits: u8) -> Self {
        match bits & 7 {
            0 => Self::Unknown,
            1 => Self::Bit,
            2 => Self::TwoBits,
            3 => Self::FourBits,
            4 => Self::Byte,
            5 => Self::Word,
            6 => Self::TwoWords,
            _ => Self::Reserved,
        }
    }
}

/// The error type of a channel-related block, 0 to 31. As text it is the name in the standard; a type without one, reserved or
/// of the manufacturer, keeps its number.
///
/// ```
/// use profivac_wire::ext_diag::ChannelError;
///
/// assert_eq!(ChannelError(6).to_string(), "line break");
/// assert_eq!(ChannelError(17).to_string(), "manufacturer specific error 17");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ChannelError(pub u8);

impl Display for ChannelError {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0 {
            1 => "short circuit",
            2 => "undervoltage",
            3 => "overvoltage",
            4 => "overload",
            5 => "overtemperature",
            6 => "line break",
            7 => "upper limit exceeded",
            8 => "lower limit exceeded",
            9 => "error",
            16..=31 => return write!(f, "manufacturer specific error {}", self.0),
            number => return write!(f, "reserved error {number}"),
        })
    }
}
