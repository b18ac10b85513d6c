//! The frame control octet (FC): function of a request or status of an answer. profibus-wire 1.4 and 1.5.

/// The fields of FC.
///
/// ```
/// use profivac_wire::control::{Control, FrameCount, Function, StationType, Status};
///
/// let control = Control::from_octet(0x6D);
/// assert_eq!(control, Control::Request { function: Function::SrdHigh, count: FrameCount::First });
/// assert_eq!(control.to_octet(), 0x6D);
///
/// // A slave answers with data of low priority; a master in the token ring has another station type.
/// assert_eq!(Control::slave(Status::DataLow).to_octet(), 0x08);
/// let answer = Control::from_octet(0x38);
/// assert_eq!(answer, Control::Response { station: StationType::MasterInRing, status: Status::DataLow });
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Control {
    /// Bit 6 set: a request.
    Request {
        /// The requested function.
        function: Function,
        /// The frame count bit and its validity.
        count: FrameCount,
    },
    /// Bit 6 clear: an answer.
    Response {
        /// The kind of the answering station.
        station: StationType,
        /// The result of the request.
        status: Status,
    },
}

/// FCB and FCV of a request. profibus-wire 1.9.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrameCount {
    /// FCV = 0, FCB = 0: not counted (SDN, FDL status).
    Uncounted,
    /// FCV = 0, FCB = 1: the first request to this station.
    First,
    /// FCV = 1: counted, with the value of FCB.
    Counted(bool),
}

impl FrameCount {
    #[inline]
    const fn from_bits(fc: u8) -> Self {
        match (fc & FCV != 0, fc & FCB != 0) {
            (false, false) => Self::Uncounted,
            (false, true) => Self::First,
            (true, fcb) => Self::Counted(fcb),
        }
    }

    #[inline]
    const fn to_bits(self) -> u8 {
        match self {
            Self::Uncounted => 0,
            Self::First => FCB,
            Self::Counted(false) => FCV,
            Self::Counted(true) => FCV | FCB,
        }
    }
}

const REQUEST: u8 = 0x40;
const FCB: u8 = 0x20;
const FCV: u8 = 0x10;

/// The function code of a request, with bit 7 of FC (the alternative code table) kept in [`Function::Other`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Function {
    /// Send data with acknowledge, low priority. DP has no such service.
    SdaLow,
    /// Send data with no acknowledge, low priority.
    SdnLow,
    /// Send data with acknowledge, high priority. DP has no such service.
    SdaHigh,
    /// Send data with no acknowledge, high priority.
    SdnHigh,
    /// Request FDL status with reply.
    FdlStatus,
    /// Send and request data, low priority.
    SrdLow,
    /// Send and request data, high priority.
    SrdHigh,
    /// Request identification with reply.
    Ident,
    /// Request the status of a service access point with reply.
    LsapStatus,
    /// Any other code: bits 7 and 3 to 0 of FC.
    Other(u8),
}

impl Function {
    #[inline]
    const fn from_bits(fc: u8) -> Self {
        match fc & 0x8F {
            0x03 => Self::SdaLow,
            0x04 => Self::SdnLow,
            0x05 => Self::SdaHigh,
            0x06 => Self::SdnHigh,
            0x09 => Self::FdlStatus,
            0x0C => Self::SrdLow,
            0x0D => Self::SrdHigh,
            0x0E => Self::Ident,
            0x0F => Self::LsapStatus,
            other => Self::Other(other),
        }
    }

    #[inline]
    const fn to_bits(self) -> u8 {
        match self {
            Self::SdaLow => 0x03,
            Self::SdnLow => 0x04,
            Self::SdaHigh => 0x05,
            Self::SdnHigh => 0x06,
            Self::FdlStatus => 0x09,
            Self::SrdLow => 0x0C,
            Self::SrdHigh => 0x0D,
            Self::Ident => 0x0E,
            Self::LsapStatus => 0x0F,
            Self::Other(other) => other & 0x8F,
        }
    }
}

/// Bits 5 and 4 of a response: the kind of the answering station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StationType {
    /// A passive station.
    Slave,
    /// An active station that is not ready to enter the token ring.
    MasterNotReady,
    /// An active station that is ready to enter the token ring.
    MasterReady,
    /// An active station that is in the token ring.
    MasterInRing,
}

/// The status of a response.
///
/// ```
/// use profivac_wire::control::Status;
///
/// assert!(Status::DataLow.carries_data() && !Status::NoReply.carries_data());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Status {
    /// OK: positive acknowledgement.
    Ok,
    /// UE: error of the FDL user of the remote station.
    UserError,
    /// RR: no resource for the data.
    NoResource,
    /// RS: the service access point is not activated, or not for this requester.
    ServiceNotActivated,
    /// DL: response data, low priority.
    DataLow,
    /// NR: request data accepted, no response data.
    NoReply,
    /// DH: response data, high priority.
    DataHigh,
    /// RDL: response data, low priority; request data not accepted.
    DataLowNotTaken,
    /// RDH: response data, high priority; request data not accepted.
    DataHighNotTaken,
    /// Any other code: bits 7 and 3 to 0 of FC.
    Other(u8),
}

impl Status {
    /// Whether the response carries data.
    #[must_use]
    pub const fn carries_data(self) -> bool {
        matches!(self, Self::DataLow | Self::DataHigh | Self::DataLowNotTaken | Self::DataHighNotTaken)
    }

    #[inline]
    const fn from_bits(fc: u8) -> Self {
        match fc & 0x8F {
            0x00 => Self::Ok,
            0x01 => Self::UserError,
            0x02 => Self::NoResource,
            0x03 => Self::ServiceNotActivated,
            0x08 => Self::DataLow,
            0x09 => Self::NoReply,
            0x0A => Self::DataHigh,
            0x0C => Self::DataLowNotTaken,
            0x0D => Self::DataHighNotTaken,
            other => Self::Other(other),
        }
    }

    #[inline]
    const fn to_bits(self) -> u8 {
        match self {
            Self::Ok => 0x00,
            Self::UserError => 0x01,
            Self::NoResource => 0x02,
            Self::ServiceNotActivated => 0x03,
            Self::DataLow => 0x08,
            Self::NoReply => 0x09,
            Self::DataHigh => 0x0A,
            Self::DataLowNotTaken => 0x0C,
            Self::DataHighNotTaken => 0x0D,
            Self::Other(other) => other & 0x8F,
        }
    }
}

impl Control {
    /// Decodes an FC octet. Codes without a name are kept, so this cannot fail.
    #[must_use]
    #[inline]
    pub const fn from_octet(fc: u8) -> Self {
        if fc & REQUEST != 0 {
            return Self::Request { function: Function::from_bits(fc), count: FrameCount::from_bits(fc) };
        }
        let station = match (fc >> 4) & 3 {
            0 => StationType::Slave,
            1 => StationType::MasterNotReady,
            2 => StationType::MasterReady,
            _ => StationType::MasterInRing,
        };
        Self::Response { station, status: Status::from_bits(fc) }
    }

    /// Encodes the FC octet.
    #[must_use]
    #[inline]
    pub const fn to_octet(self) -> u8 {
        match self {
            Self::Request { function, count } => REQUEST | function.to_bits() | count.to_bits(),
            Self::Response { station, status } => ((station as u8) << 4) | status.to_bits(),
        }
    }

    /// The response of a passive station with `status`.
    #[must_use]
    pub const fn slave(status: Status) -> Self {
        Self::Response { station: StationType::Slave, status }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_octet_is_unchanged_after_decoding_and_encoding() {
        for fc in 0..=0xFF {
            assert_eq!(Control::from_octet(fc).to_octet(), fc, "{fc:02X}");
        }
    }

    #[test]
    fn the_octets_of_the_specification_decode_to_their_functions() {
        use {FrameCount::*, Function::*};
        for (fc, function, count) in [
            (0x6C, SrdLow, First),
            (0x6D, SrdHigh, First),
            (0x5D, SrdHigh, Counted(false)),
            (0x7C, SrdLow, Counted(true)),
            (0x46, SdnHigh, Uncounted),
            (0x44, SdnLow, Uncounted),
            (0x49, FdlStatus, Uncounted),
            (0x4E, Ident, Uncounted),
            (0x4F, LsapStatus, Uncounted),
            (0xC0, Other(0x80), Uncounted),
        ] {
            assert_eq!(Control::from_octet(fc), Control::Request { function, count }, "{fc:02X}");
        }
        assert_eq!(Control::from_octet(0x0A), Control::slave(Status::DataHigh));
        assert_eq!(
            Control::from_octet(0x30),
            Control::Response { station: StationType::MasterInRing, status: Status::Ok }
        );
    }
}
