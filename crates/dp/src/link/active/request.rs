//! What the layer above an active station asks for, and what it is told.

use crate::link::time::BitTime;
use core::fmt;
use profivac_wire::control::{Function, StationType, Status};
use profivac_wire::telegram::BROADCAST;

/// A message for the station to send. What a request must not be (to oneself, too long) is confirmed as
/// [`Failure::Impossible`] without being sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request<'a> {
    /// To whom: 0 to 126, or 127 for everybody where no answer is expected.
    pub da: u8,
    /// What is asked. An SDN, and any function this station does not know, is not answered.
    pub function: Function,
    /// The service access point at the destination.
    pub dsap: Option<u8>,
    /// The service access point here.
    pub ssap: Option<u8>,
    /// The data unit.
    pub du: &'a [u8],
}

/// Which kind of answer a request gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// None.
    Unconfirmed,
    /// A telegram without data, with or without being counted.
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

    /// Whether the frame count bit counts such requests, profibus-wire 1.10.
    pub(super) const fn counts(self) -> bool {
        matches!(self, Self::Acknowledge | Self::Reply)
    }
}

/// What is remembered of a request while its answer is awaited.
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

    /// A request that expects an answer cannot go to everybody, and none can go to oneself.
    pub(super) fn is_possible(&self, address: u8) -> bool {
        let last = if Kind::of(self.function) == Kind::Unconfirmed { BROADCAST } else { BROADCAST.saturating_sub(1) };
        self.da <= last && self.da != address
    }
}

/// Which messages a token visit is for. profibus-wire 1.12.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Priority {
    /// One of these is always allowed, more as long as there is token hold time.
    High,
    /// Only as long as there is token hold time, and when no message of high priority is left for this visit.
    Low,
}

/// The layer above an active station. The station asks it for work whenever it may speak.
pub trait FdlUser {
    /// The next message, `None` when there is none for this token visit. Each message is confirmed exactly once, and
    /// before the next is asked for.
    fn next_request(&mut self, priority: Priority, now: BitTime) -> Option<Request<'_>>;

    /// What became of the message, at `now`.
    fn confirm(&mut self, now: BitTime, confirmation: Confirmation<'_>);

    /// Station `sender` has answered to us at `now`, and nothing was asked of it any more: late, or it is not the only one
    /// at its address. Never a value; told so that somebody can look.
    fn stray(&mut self, now: BitTime, sender: u8) {
        let _ = (now, sender);
    }
}

/// What became of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Confirmation<'a> {
    /// It has left; nobody answers such a message.
    Sent,
    /// The answer, which fits the request in source, access points, function code and form.
    Answer(Answer<'a>),
    /// No such answer came, or the message was not sent.
    Failed(Failure),
}

/// An answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer<'a> {
    /// What kind of station answered.
    pub station: StationType,
    /// How it answered; SC is [`Status::NoReply`] to an SRD.
    pub status: Status,
    /// The data unit, empty where there is none.
    pub du: &'a [u8],
    /// How often the request had to be repeated.
    pub retries: u8,
}

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// Nothing was heard.
    Silence,
    /// Something was heard, but no valid telegram.
    Damaged,
    /// Only the answer to something else was heard.
    Mismatch(Mismatch),
    /// Another master spoke, or the line is never quiet: this station is listening again.
    Interrupted,
    /// Nobody can send such a message.
    Impossible,
}

/// What does not fit in an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mismatch {
    /// It is from this station, not from the one that was asked.
    Source(u8),
    /// It is for this station, not for us.
    Destination(u8),
    /// Its access points are not those of the request, swapped.
    AccessPoint,
    /// This FC is no answer to the request.
    Function(u8),
    /// SC or data where neither belongs.
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
