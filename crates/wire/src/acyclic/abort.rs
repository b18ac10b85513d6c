//! Abort: closes an MS2 connection with a reason. profibus-wire 4.8.
//!
//! ```
//! use profivac_wire::acyclic::{Abort, AbortReason, Request};
//!
//! let abort = Abort::new(AbortReason::TIMEOUT);
//! assert_eq!(abort.reason.name(), "ABT_TO: timeout");
//! let mut out = [0; 3];
//! assert_eq!(Request::Abort(abort).emit(&mut out), Ok(3));
//! assert_eq!(out, [0x58, 0, 0x13]);
//! ```

use crate::octets::{Reader, TooLong, TooShort, Writer};
use core::fmt;

/// Abort, sent by either side. It has no response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Abort<'a> {
    /// Subnet: origin of the cause: 0 unspecified, 1 local, 2 remote.
    pub subnet: u8,
    /// Instance_Reason: the aborting instance and its reason.
    pub reason: AbortReason,
    /// Additional octets of some stations. This project sends none: profibus-wire 10, point 23.
    pub detail: &'a [u8],
}

impl Abort<'_> {
    /// An Abort with `reason`, without subnet and detail.
    #[must_use]
    pub const fn new(reason: AbortReason) -> Self {
        Self { subnet: 0, reason, detail: &[] }
    }
}

impl<'a> Abort<'a> {
    /// Parses the octets after the function number.
    pub(super) fn parse(mut reader: Reader<'a>) -> Result<Self, TooShort> {
        Ok(Self { subnet: reader.octet()?, reason: AbortReason::from_octet(reader.octet()?), detail: reader.rest() })
    }

    pub(super) fn emit(&self, writer: &mut Writer<'_>) -> Result<(), TooLong> {
        writer.octets(&[self.subnet, self.reason.to_octet()])?;
        writer.octets(self.detail)
    }
}

/// Instance_Reason: the aborting instance and its reason, 0 to 15.
///
/// ```
/// use profivac_wire::acyclic::AbortReason;
///
/// assert_eq!(AbortReason::TIMEOUT.to_string(), "ABT_TO: timeout (13)");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AbortReason {
    /// Layer 2; the reason is a response code or a local status.
    Fdl(u8),
    /// The protocol machine of MS2.
    Ms2(u8),
    /// The application.
    User(u8),
    /// A reserved instance or reserved bits: the octet as received.
    Other(u8),
}

impl AbortReason {
    /// ABT_SE: the service is not allowed in this state.
    pub const SEQUENCE: Self = Self::Ms2(1);
    /// ABT_FE: invalid request received.
    pub const INVALID_REQUEST: Self = Self::Ms2(2);
    /// ABT_TO: the connection timed out.
    pub const TIMEOUT: Self = Self::Ms2(3);
    /// ABT_RE: invalid response received.
    pub const INVALID_RESPONSE: Self = Self::Ms2(4);
    /// ABT_IV: invalid service requested by the application.
    pub const INVALID_SERVICE: Self = Self::Ms2(5);
    /// ABT_STO: the requested Send_Timeout is too small.
    pub const SEND_TIMEOUT: Self = Self::Ms2(6);
    /// ABT_IA: the additional address is invalid.
    pub const INVALID_ADDRESS: Self = Self::Ms2(7);
    /// ABT_OC: a layer 2 confirmation is outstanding.
    pub const OPEN_CYCLE: Self = Self::Ms2(8);
    /// ABT_RES: no resource.
    pub const RESOURCE: Self = Self::Ms2(15);

    const fn from_octet(octet: u8) -> Self {
        let reason = octet & 0x0F;
        match octet >> 4 {
            0 => Self::Fdl(reason),
            1 => Self::Ms2(reason),
            2 => Self::User(reason),
            _ => Self::Other(octet),
        }
    }

    const fn to_octet(self) -> u8 {
        match self {
            Self::Fdl(reason) => reason & 0x0F,
            Self::Ms2(reason) => 0x10 | (reason & 0x0F),
            Self::User(reason) => 0x20 | (reason & 0x0F),
            Self::Other(octet) => octet,
        }
    }

    /// The meaning of the reason, in English.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fdl(1) => "UE: user error",
            Self::Fdl(2) => "RR: no resource",
            Self::Fdl(3) => "RS: service access point closed",
            Self::Fdl(9) => "NR: no reply data",
            Self::Fdl(10) => "DH: reply data, high priority",
            Self::Fdl(11) => "LR: no local resource",
            Self::Fdl(12) => "RDL: data not taken, reply low priority",
            Self::Fdl(13) => "RDH: data not taken, reply high priority",
            Self::Fdl(14) => "DS: local station not in the ring",
            Self::Fdl(15) => "NA: no answer",
            Self::Fdl(_) => "layer 2, unknown reason",
            Self::SEQUENCE => "ABT_SE: service not allowed in this state",
            Self::INVALID_REQUEST => "ABT_FE: invalid request",
            Self::TIMEOUT => "ABT_TO: timeout",
            Self::INVALID_RESPONSE => "ABT_RE: invalid response",
            Self::INVALID_SERVICE => "ABT_IV: invalid service from the user",
            Self::SEND_TIMEOUT => "ABT_STO: Send_Timeout too small",
            Self::INVALID_ADDRESS => "ABT_IA: invalid additional address",
            Self::OPEN_CYCLE => "ABT_OC: waiting for a confirmation",
            Self::RESOURCE => "ABT_RES: no resource",
            Self::Ms2(_) => "MS2, unknown reason",
            Self::User(_) => "user",
            Self::Other(_) => "reserved instance",
        }
    }
}

impl fmt::Display for AbortReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({:02X})", self.name(), self.to_octet())
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn every_reason_octet_is_unchanged_after_decoding_and_encoding() {
        for octet in 0..=0xFF {
            assert_eq!(AbortReason::from_octet(octet).to_octet(), octet);
        }
    }

    #[test]
    fn reasons_have_the_codes_of_the_specification() {
        for (reason, text) in [
            (AbortReason::INVALID_REQUEST, "ABT_FE: invalid request (12)"),
            (AbortReason::TIMEOUT, "ABT_TO: timeout (13)"),
            (AbortReason::INVALID_ADDRESS, "ABT_IA: invalid additional address (17)"),
            (AbortReason::RESOURCE, "ABT_RES: no resource (1F)"),
            (AbortReason::Fdl(3), "RS: service access point closed (03)"),
            (AbortReason::User(0), "user (20)"),
            (AbortReason::Other(0x31), "reserved instance (31)"),
        ] {
            assert_eq!(reason.to_string(), text);
        }
    }
}
