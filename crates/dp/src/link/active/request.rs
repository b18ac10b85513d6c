//! The interface between an active station and its FDL user: requests and confirmations.

use crate::link::time::BitTime;
use core::fmt;
use profivac_wire::control::{Function, StationType, Status};
use profivac_wire::telegram::BROADCAST;

/// A request for the station to send. An impossible request (to the station itself, too long) is confirmed as
/// [`Failure::Impossible`] and not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Request<'a> {
    /// The destination: 0 to 126, or 127 (all stations) for a request without an answer.
    pub da: u8,
    /// The function. An SDN and an unknown function have no answer.
    pub function: Function,
    /// The service access point at the destination.
    pub dsap: Option<u8>,
    /// The service access point at this station.
    pub ssap: Option<u8>,
    /// The data unit.
    pub du: &'a [u8],
}

/// The kind of answer to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// No answer.
    Unconfirmed,
    /// A telegram without data, counted or not.
    Acknowledge,
    /// Data, or SC.
    Reply,
    /// FDL status.
    FdlStatus,
    /// Identification and the like: data, never SC, not counted.
    Information,
}

impl Kind {
    pub(super) const fn of(function: Function) -> Self {
        match function {
            Function::SdaLow | Function::SdaHigh => Self::Acknowledge,
            Function::SrdLow | Function::SrdHigh => Self::Reply,
            Function::FdlStatus => Self::FdlStatus,
            Function::Ident | Function::LsapStatus => Self::Information,
            Function::SdnLow | Function::SdnHigh | Function::Other(_) => Self::Unconfirmed,
        }
    }

    /// Whether such requests are counted by the frame count bit, profibus-wire 1.10.
    pub(super) const fn counts(self) -> bool {
        matches!(self, Self::Acknowledge | Self::Reply)
    }
}

/// The part of a request that its answer is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct OpenRequest {
    pub(super) da: u8,
    pub(super) kind: Kind,
    pub(super) dsap: Option<u8>,
    pub(super) ssap: Option<u8>,
}

impl Request<'_> {
    pub(super) const fn open_request(&self) -> OpenRequest {
        OpenRequest { da: self.da, kind: Kind::of(self.function), dsap: self.dsap, ssap: self.ssap }
    }

    /// Whether the station at `address` can send the request: no request goes to the station itself, and only one without an
    /// answer goes to all stations.
    pub(super) fn is_possible(&self, address: u8) -> bool {
        let last = if Kind::of(self.function) == Kind::Unconfirmed { BROADCAST } else { BROADCAST.saturating_sub(1) };
        self.da <= last && self.da != address
    }
}

/// The priority of a message in a token visit. profibus-wire 1.12.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Priority {
    /// One message is always allowed, more only during the token hold time.
    High,
    /// Only during the token hold time, and when no message of high priority is left for this visit.
    Low,
}

/// The layer above an active station, which the standard calls FDL user. The station asks it for requests whenever it may
/// send.
pub trait FdlUser {
    /// The next request; `None` when there is none for this token visit. Each request is confirmed exactly once, and before
    /// the station asks for the next.
    fn next_request(&mut self, priority: Priority, now: BitTime) -> Option<Request<'_>>;

    /// The confirmation of the last request, at `now`.
    fn confirm(&mut self, now: BitTime, confirmation: Confirmation<'_>);

    /// Station `sender` has answered at `now` without an open request: the answer is late, or a second station has the same
    /// address. The answer never becomes a value; this report is for diagnosis.
    fn stray(&mut self, now: BitTime, sender: u8) {
        let _ = (now, sender);
    }
}

/// The result of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Confirmation<'a> {
    /// The request was sent; it has no answer.
    Sent,
    /// The answer, which matches the request in source, access points, function code and form.
    Answer(Answer<'a>),
    /// No such answer came, or the request was not sent.
    Failed(Failure),
}

impl Confirmation<'_> {
    /// Whether the layer above at the destination may have got the request. RS and RR say that it has not; UE does not (profibus-wire
    /// 4.12). A repetition of the link layer does not show what has become of the first telegram.
    pub(crate) const fn is_delivery(&self) -> bool {
        match self {
            Self::Answer(Answer { status: Status::ServiceNotActivated | Status::NoResource, repetitions, .. }) => {
                *repetitions > 0
            }
            Self::Failed(Failure::Impossible) => false,
            Self::Sent | Self::Answer(_) | Self::Failed(_) => true,
        }
    }
}

/// An answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answer<'a> {
    /// The type of the answering station.
    pub station: StationType,
    /// The status; SC is [`Status::NoReply`] to an SRD.
    pub status: Status,
    /// The data unit; empty if the answer has none.
    pub du: &'a [u8],
    /// How often the request was repeated.
    pub repetitions: u8,
}

/// The reason why a request has no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Failure {
    /// No character was received.
    Silence,
    /// Characters were received, but no valid telegram.
    Damaged,
    /// Only telegrams that do not match the request were received.
    Mismatch(Mismatch),
    /// Another master sent a telegram, or the line is never idle: this station has given up the token.
    Interrupted,
    /// No station can send such a request.
    Impossible,
}

/// How a telegram differs from the expected answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Mismatch {
    /// It came from this other station.
    Source(u8),
    /// It was addressed to this other station.
    Destination(u8),
    /// Its access points are not those of the request, swapped.
    AccessPoint,
    /// This function code does not answer the request.
    Function(u8),
    /// It is a token, SC where the request allows none, or has access points or data where its status allows none.
    Form,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Silence => f.write_str("no answer"),
            Self::Damaged => f.write_str("the answer is damaged"),
            Self::Mismatch(mismatch) => mismatch.fmt(f),
            Self::Interrupted => f.write_str("another master uses the line"),
            Self::Impossible => f.write_str("no station can be sent such a message"),
        }
    }
}

impl core::error::Error for Failure {}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Source(sa) => write!(f, "the answer came from station {sa}"),
            Self::Destination(da) => write!(f, "the answer was for station {da}"),
            Self::AccessPoint => f.write_str("the answer belongs to other service access points"),
            Self::Function(fc) => write!(f, "the answer's function code {fc:02X} does not fit the request"),
            Self::Form => f.write_str("the form of the answer does not fit the request"),
        }
    }
}

impl core::error::Error for Mismatch {}
