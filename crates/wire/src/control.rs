//! The frame control octet (FC): what a telegram asks for, or how it answers. profibus-wire 1.4 and 1.5.

/// FC, taken apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Bit 6 set: somebody asks.
    Request {
        /// What is asked.
        function: Function,
        /// The frame count bit and whether it counts.
        count: FrameCount,
    },
    /// Bit 6 clear: somebody answers.
    Response {
        /// Which kind of station answers.
        station: StationType,
        /// How it answers.
        status: Status,
    },
}

/// FCB and FCV of a request. profibus-wire 1.9.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameCount {
    /// FCV = 0, FCB = 0: not counted (SDN, FDL status).
    Uncounted,
    /// FCV = 0, FCB = 1: the first request of a relation.
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
pub enum Function {
    /// Send data with acknowledge, low priority. DP has no such service.
    SdaLow,
    /// Send data with no acknowledge, low priority.
    SdnLow,
    /// Send data with acknowledge, high priority. DP has no such service.
    SdaHigh,
    /// Send data with no acknowledge, high priority.
    SdnHigh,
    /// Request FDL status with reply: "who is there".
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

/// Bits 5 and 4 of a response: what kind of station answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StationType {
    /// A passive station.
    Slave,
    /// An active station that is not ready to enter the token ring.
    MasterNotReady,
    /// An active station that wants to enter the token ring.
    MasterReady,
    /// An active station that is in the token ring.
    MasterInRing,
}

/// How a request was answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// OK: positive acknowledgement.
    Ok,
    /// UE: the user of the remote station has failed.
    UserError,
    /// RR: no resource for the data.
    NoResource,
    /// RS: the service access point is not open, or not to this requester.
    ServiceNotActivated,
    /// DL: here are data, low priority.
    DataLow,
    /// NR: data taken, none to return.
    NoReply,
    /// DH: here are data, high priority.
    DataHigh,
    /// RDL: here are data, but those sent were not taken.
    DataLowNotTaken,
    /// RDH: as RDL, high priority.
    DataHighNotTaken,
    /// Any other code: bits 7 and 3 to 0 of FC.
    Other(u8),
}

impl Status {
    /// Whether data come with it.
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
    /// Takes an FC octet apart. Every octet has a meaning, so this cannot fail.
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

    /// The FC octet.
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
    fn every_octet_survives_parse_and_emit() {
        for fc in 0..=0xFF {
            assert_eq!(Control::from_octet(fc).to_octet(), fc, "{fc:02X}");
        }
    }

    #[test]
    fn the_octets_of_the_reference_mean_what_it_says() {
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
