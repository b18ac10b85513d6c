//! Negative responses and their error codes. profibus-wire 4.1.2 and 4.1.3.

use super::function::{FieldError, Function};
use crate::octets::{Reader, TooLong, Writer};
use core::fmt;

/// A negative response.
///
/// ```
/// use profivac_wire::acyclic::{ErrorCode, Response};
///
/// let Ok(Response::Negative(negative)) = Response::parse(&[0xDF, 0x80, 0xB6, 0]) else { panic!("expected a refusal") };
/// assert_eq!(negative.code_1, ErrorCode::ACCESS_DENIED);
/// assert_eq!(negative.code_1.to_string(), "access denied (B6)");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Negative {
    /// The function that the device refuses.
    pub function: Function,
    /// Error_Decode: the origin of the two codes.
    pub decode: ErrorDecode,
    /// Error_Code_1.
    pub code_1: ErrorCode,
    /// Error_Code_2, defined by the device; 0 if unused.
    pub code_2: u8,
}

impl Negative {
    /// A refusal of `function` with a DP-V1 code; Error_Code_2 is 0.
    #[must_use]
    pub const fn new(function: Function, code_1: ErrorCode) -> Self {
        Self { function, decode: ErrorDecode::DpV1, code_1, code_2: 0 }
    }

    /// Parses the octets after the function number.
    pub(super) fn parse(function: Function, mut reader: Reader<'_>) -> Result<Self, FieldError> {
        let negative = Self {
            function,
            decode: ErrorDecode::from_octet(reader.octet()?),
            code_1: ErrorCode(reader.octet()?),
            code_2: reader.octet()?,
        };
        if reader.is_empty() { Ok(negative) } else { Err(FieldError::Surplus) }
    }

    pub(super) fn emit(self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        writer.octets(&[self.decode.to_octet(), self.code_1.0, self.code_2])
    }
}

/// Error_Decode: the origin of the error codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ErrorDecode {
    /// 128: codes of DP-V1.
    DpV1,
    /// 254: codes of FMS.
    Fms,
    /// 255: codes of HART.
    Hart,
    /// Reserved.
    Other(u8),
}

impl ErrorDecode {
    const fn from_octet(octet: u8) -> Self {
        match octet {
            128 => Self::DpV1,
            254 => Self::Fms,
            255 => Self::Hart,
            other => Self::Other(other),
        }
    }

    const fn to_octet(self) -> u8 {
        match self {
            Self::DpV1 => 128,
            Self::Fms => 254,
            Self::Hart => 255,
            Self::Other(other) => other,
        }
    }
}

/// Error_Code_1: Error_Class in the high and Error_Code in the low nibble.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ErrorCode(pub u8);

impl ErrorCode {
    /// Application: reading failed.
    pub const READ_ERROR: Self = Self(0xA0);
    /// Application: writing failed.
    pub const WRITE_ERROR: Self = Self(0xA1);
    /// The module has failed or was removed.
    pub const MODULE_FAILURE: Self = Self(0xA2);
    /// The versions are incompatible.
    pub const VERSION_CONFLICT: Self = Self(0xA8);
    /// The application does not support the feature.
    pub const FEATURE_NOT_SUPPORTED: Self = Self(0xA9);
    /// The index does not exist.
    pub const INVALID_INDEX: Self = Self(0xB0);
    /// The length of the data differs from that of the record.
    pub const WRITE_LENGTH: Self = Self(0xB1);
    /// The slot does not exist.
    pub const INVALID_SLOT: Self = Self(0xB2);
    /// The data type of the request does not match.
    pub const TYPE_CONFLICT: Self = Self(0xB3);
    /// The area does not exist.
    pub const INVALID_AREA: Self = Self(0xB4);
    /// The present state does not permit the access.
    pub const STATE_CONFLICT: Self = Self(0xB5);
    /// The access is not permitted, for example a write to a read-only parameter.
    pub const ACCESS_DENIED: Self = Self(0xB6);
    /// The value is out of range.
    pub const INVALID_RANGE: Self = Self(0xB7);
    /// A field of the request is invalid.
    pub const INVALID_PARAMETER: Self = Self(0xB8);
    /// The data type is invalid.
    pub const INVALID_TYPE: Self = Self(0xB9);
    /// A simultaneous read conflicts with this one.
    pub const READ_CONSTRAINT: Self = Self(0xC0);
    /// A simultaneous write conflicts with this one.
    pub const WRITE_CONSTRAINT: Self = Self(0xC1);
    /// The resource is in use.
    pub const RESOURCE_BUSY: Self = Self(0xC2);
    /// The resource is unavailable.
    pub const RESOURCE_UNAVAILABLE: Self = Self(0xC3);

    /// Error_Class, 0 to 15.
    #[must_use]
    pub const fn class(self) -> u8 {
        self.0 >> 4
    }

    /// Error_Code within the class, 0 to 15.
    #[must_use]
    pub const fn code(self) -> u8 {
        self.0 & 0x0F
    }

    /// The name of the code in DP-V1.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self.0 {
            0xA0 => "read error",
            0xA1 => "write error",
            0xA2 => "module failure",
            0xA8 => "version conflict",
            0xA9 => "feature not supported",
            0xAA..=0xAF => "application, user specific",
            0xB0 => "invalid index",
            0xB1 => "write length error",
            0xB2 => "invalid slot",
            0xB3 => "type conflict",
            0xB4 => "invalid area",
            0xB5 => "state conflict",
            0xB6 => "access denied",
            0xB7 => "invalid range",
            0xB8 => "invalid parameter",
            0xB9 => "invalid type",
            0xBA..=0xBF => "access, user specific",
            0xC0 => "read constraint conflict",
            0xC1 => "write constraint conflict",
            0xC2 => "resource busy",
            0xC3 => "resource unavailable",
            0xC8..=0xCF => "resource, user specific",
            0xD0..=0xFF => "user specific",
            _ => "reserved",
        }
    }
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({:02X})", self.name(), self.0)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn every_error_decode_octet_is_unchanged_after_decoding_and_encoding() {
        for octet in 0..=0xFF {
            assert_eq!(ErrorDecode::from_octet(octet).to_octet(), octet);
        }
    }

    /// profibus-wire 4.1.3
    #[test]
    fn codes_have_the_names_and_classes_of_the_specification() {
        for (code, class, low, text) in [
            (ErrorCode::READ_ERROR, 10, 0, "read error (A0)"),
            (ErrorCode::FEATURE_NOT_SUPPORTED, 10, 9, "feature not supported (A9)"),
            (ErrorCode::INVALID_INDEX, 11, 0, "invalid index (B0)"),
            (ErrorCode::INVALID_PARAMETER, 11, 8, "invalid parameter (B8)"),
            (ErrorCode::RESOURCE_UNAVAILABLE, 12, 3, "resource unavailable (C3)"),
            (ErrorCode(0xA7), 10, 7, "reserved (A7)"),
            (ErrorCode(0xBA), 11, 10, "access, user specific (BA)"),
            (ErrorCode(0xC4), 12, 4, "reserved (C4)"),
            (ErrorCode(0xE1), 14, 1, "user specific (E1)"),
            (ErrorCode(0x9F), 9, 15, "reserved (9F)"),
        ] {
            assert_eq!((code.class(), code.code()), (class, low), "{text}");
            assert_eq!(code.to_string(), text);
        }
    }
}
