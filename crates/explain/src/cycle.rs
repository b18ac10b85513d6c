//! A request and what came of it.

use profivac_dp::link::BitTime;
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::{DataTelegram, Sap};

/// A request that waits for its answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// Who asks.
    pub master: u8,
    /// Who is asked.
    pub slave: u8,
    /// Its access point, 0 if there is none.
    pub sap: Sap,
    /// What is asked.
    pub function: Function,
    /// Frame count bit.
    pub count: FrameCount,
    /// The access points as they came.
    pub saps: [Option<u8>; 2],
    /// The data unit.
    pub du: Vec<u8>,
    /// When it began, if that is known.
    pub at: Option<BitTime>,
}

/// How it was answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer<'a> {
    /// SC counts as `Ok` without data.
    pub status: Status,
    /// The data unit.
    pub du: &'a [u8],
}

impl Answer<'_> {
    /// Whether the request was taken without a word.
    #[must_use]
    pub fn is_ack(&self) -> bool {
        matches!(self.status, Status::Ok) || (self.status == Status::NoReply && self.du.is_empty())
    }
}

impl Request {
    /// A request that is to be answered; `None` for answers and for what nobody answers.
    #[must_use]
    pub fn of(frame: &DataTelegram<'_>, at: Option<BitTime>) -> Option<Self> {
        let Control::Request { function, count } = frame.control() else { return None };
        if matches!(function, Function::SdnLow | Function::SdnHigh) {
            return None;
        }
        let (sap, saps) = (Sap::from_octet(frame.dsap), [frame.dsap, frame.ssap]);
        Some(Self { master: frame.sa, slave: frame.da, sap, function, count, saps, du: frame.du.to_vec(), at })
    }

    /// Whether `frame` is the answer: stations and access points the other way round.
    #[must_use]
    pub fn is_answered_by(&self, frame: &DataTelegram<'_>) -> bool {
        let stations = frame.sa == self.slave && frame.da == self.master;
        let plain = frame.dsap.is_none() && frame.ssap.is_none();
        stations && (plain || [frame.ssap, frame.dsap] == self.saps || self.is_initiate_answered(frame))
    }

    /// Only the frame count bits tell a repetition from the same request once more.
    #[must_use]
    pub fn is_repeated_by(&self, other: &Self) -> bool {
        matches!(self.count, FrameCount::Counted(_))
            && Self { at: None, ..self.clone() } == Self { at: None, ..other.clone() }
    }

    /// The resource manager's connection answers from an access point of its own.
    fn is_initiate_answered(&self, frame: &DataTelegram<'_>) -> bool {
        matches!(self.sap, Sap::ResourceManager | Sap::Ms2(_)) && frame.dsap == self.saps[1]
    }
}

/// The status of an answer without data, in words.
#[must_use]
pub const fn status_text(status: Status) -> &'static str {
    match status {
        Status::Ok => "OK",
        Status::UserError => "UE: its application has failed",
        Status::NoResource => "RR: it has no room for that now",
        Status::ServiceNotActivated => "RS: this service is not open to this master",
        Status::DataLow | Status::DataHigh => "data",
        Status::NoReply => "NR: nothing to say",
        Status::DataLowNotTaken | Status::DataHighNotTaken => "RDL: it has data, and took none of those that were sent",
        Status::Other(_) => "an unknown answer",
    }
}
