//! Message cycles: a request and its answer.

use profivac_dp::link::BitTime;
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::{DataTelegram, Sap};

/// A request that waits for its answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// Address of the master that sent it.
    pub master: u8,
    /// Address of the slave.
    pub slave: u8,
    /// Service access point of the slave; `Sap::Default` if the telegram has none.
    pub sap: Sap,
    /// Function code.
    pub function: Function,
    /// Frame count bit.
    pub count: FrameCount,
    /// DSAP and SSAP as in the telegram.
    pub saps: [Option<u8>; 2],
    /// The data unit.
    pub du: Vec<u8>,
    /// Start of the request, if the input has times.
    pub at: Option<BitTime>,
}

/// An answer of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer<'a> {
    /// SC counts as `Ok` without data.
    pub status: Status,
    /// The data unit.
    pub du: &'a [u8],
}

impl Answer<'_> {
    /// Whether the answer is an acknowledgement without data.
    #[must_use]
    pub fn is_ack(&self) -> bool {
        matches!(self.status, Status::Ok) || (self.status == Status::NoReply && self.du.is_empty())
    }

    /// Whether the answer refuses the request.
    #[must_use]
    pub const fn is_refusal(&self) -> bool {
        match self.status {
            Status::UserError | Status::NoResource | Status::ServiceNotActivated | Status::Other(_) => true,
            Status::Ok
            | Status::NoReply
            | Status::DataLow
            | Status::DataHigh
            | Status::DataLowNotTaken
            | Status::DataHighNotTaken => false,
        }
    }
}

impl Request {
    /// The request in `data`; `None` for an answer and for SDN, which is never answered.
    #[must_use]
    pub fn of(data: &DataTelegram<'_>, at: Option<BitTime>) -> Option<Self> {
        let Control::Request { function, count } = data.control() else { return None };
        if matches!(function, Function::SdnLow | Function::SdnHigh) {
            return None;
        }
        let (sap, saps) = (Sap::from_octet(data.dsap), [data.dsap, data.ssap]);
        Some(Self { master: data.sa, slave: data.da, sap, function, count, saps, du: data.du.to_vec(), at })
    }

    /// The service that the request asks for.
    #[must_use]
    pub fn service(&self) -> String {
        match self.function {
            Function::FdlStatus => "FDL status".to_owned(),
            Function::Ident => "Ident".to_owned(),
            Function::LsapStatus => "LSAP status".to_owned(),
            Function::SdaLow
            | Function::SdaHigh
            | Function::SdnLow
            | Function::SdnHigh
            | Function::SrdLow
            | Function::SrdHigh
            | Function::Other(_) => profivac_sim::describe::Service(self.sap).to_string(),
        }
    }

    /// Whether `data` is the answer: its addresses and access points are those of the request, swapped.
    #[must_use]
    pub fn is_answered_by(&self, data: &DataTelegram<'_>) -> bool {
        let stations = data.sa == self.slave && data.da == self.master;
        let plain = data.dsap.is_none() && data.ssap.is_none();
        stations && (plain || [data.ssap, data.dsap] == self.saps || self.is_initiate_answered(data))
    }

    /// Whether `other` is a repetition: an equal request with an equal, counted frame count bit.
    #[must_use]
    pub fn is_repeated_by(&self, other: &Self) -> bool {
        matches!(self.count, FrameCount::Counted(_))
            && Self { at: None, ..self.clone() } == Self { at: None, ..other.clone() }
    }

    /// Whether `data` answers Initiate: the answer comes from the access point of the new connection.
    fn is_initiate_answered(&self, data: &DataTelegram<'_>) -> bool {
        matches!(self.sap, Sap::ResourceManager | Sap::Ms2(_)) && data.dsap == self.saps[1]
    }
}

/// The status of an answer without data as text.
#[must_use]
pub const fn status_text(status: Status) -> &'static str {
    match status {
        Status::Ok => "OK",
        Status::UserError => "UE: its application has failed",
        Status::NoResource => "RR: it has no resource for that now",
        Status::ServiceNotActivated => "RS: this service is not open to this master",
        Status::DataLow | Status::DataHigh => "data",
        Status::NoReply => "NR: no data",
        Status::DataLowNotTaken | Status::DataHighNotTaken => {
            "RDL: it answers with data but did not take the data that was sent"
        }
        Status::Other(_) => "an unknown answer",
    }
}
