//! One request and its response, as MS1 and MS2 both carry them: the request is acknowledged, the response is fetched by
//! polling. profibus-wire 4.2.

use super::outcome::Cause;
use crate::link::BitTime;
use crate::link::active::{Answer, Confirmation, Failure, Request};
use profivac_wire::MAX_DU;
use profivac_wire::acyclic::Request as Pdu;
use profivac_wire::control::{Function, Status};

/// How long somebody waits for what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::master) struct Timeouts {
    /// For the response.
    pub(in crate::master) response_tbit: u64,
    /// For any answer at all.
    pub(in crate::master) lost_tbit: u64,
    /// Between two messages.
    pub(in crate::master) pace_tbit: u64,
    /// How often in a row the slave may answer RR or UE.
    pub(in crate::master) rejections: u8,
}

/// What is sent next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::master) enum Stage {
    /// The request. Nothing says that the slave has it.
    Request,
    /// An empty data unit, which fetches the response.
    Poll,
}

/// What a confirmation means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::master) enum Progress<'a> {
    /// Nothing yet.
    Waiting,
    /// A response PDU, whichever it is.
    Response(&'a [u8]),
    /// There will be none.
    Failed(Cause),
}

/// A request under way. The octets are the request's until its response takes their place.
#[derive(Clone, Debug)]
pub(in crate::master) struct Transaction {
    octets: [u8; MAX_DU],
    length: usize,
    pub(in crate::master) stage: Stage,
    rejections: u8,
    /// The request was sent before, and the slave may have it.
    uncertain: bool,
    lost: Option<(Failure, BitTime)>,
    not_before: BitTime,
    /// Counted from the first time this was asked for work.
    deadline: Option<BitTime>,
}

impl Transaction {
    pub(in crate::master) const fn new() -> Self {
        Self {
            octets: [0; MAX_DU],
            length: 0,
            stage: Stage::Request,
            rejections: 0,
            uncertain: false,
            lost: None,
            not_before: BitTime(0),
            deadline: None,
        }
    }

    /// Puts a request in. `false` if it is too long for a telegram.
    pub(in crate::master) fn put(&mut self, pdu: &Pdu<'_>) -> bool {
        self.length = pdu.emit(&mut self.octets).unwrap_or(0);
        self.length > 0
    }

    /// Begins with a request, or with polling where the request was another.
    pub(in crate::master) const fn begin(&mut self, stage: Stage) {
        self.stage = stage;
        self.rejections = 0;
        self.uncertain = false;
        self.lost = None;
        self.deadline = None;
    }

    /// The octets put in, or kept.
    pub(in crate::master) fn octets(&self) -> &[u8] {
        self.octets.get(..self.length).unwrap_or_default()
    }

    /// Keeps a response.
    pub(in crate::master) fn keep(&mut self, data: &[u8]) {
        if let Some(place) = self.octets.get_mut(..data.len()) {
            place.copy_from_slice(data);
            self.length = data.len();
        }
    }

    /// Whether the next message may leave.
    pub(in crate::master) fn is_due(&self, now: BitTime) -> bool {
        self.not_before <= now
    }

    /// The next message to `da`, between two access points. `pdu` is the request.
    pub(in crate::master) fn message<'a>(&self, da: u8, saps: (u8, u8), pdu: &'a [u8]) -> Request<'a> {
        let (dsap, ssap) = saps;
        let du = match self.stage {
            Stage::Request => pdu,
            Stage::Poll => &[],
        };
        Request { da, function: Function::SrdLow, dsap: Some(dsap), ssap: Some(ssap), du }
    }

    /// Time has come to `now`. The cause if patience is at its end.
    pub(in crate::master) fn elapse(&mut self, now: BitTime, patience: &Timeouts) -> Option<Cause> {
        let deadline = *self.deadline.get_or_insert(now + patience.response_tbit);
        match self.lost {
            Some((failure, since)) if since + patience.lost_tbit <= now || deadline <= now => {
                Some(Cause::Lost(failure))
            }
            _ if deadline <= now => Some(Cause::Timeout),
            _ => None,
        }
    }

    /// What became of the message. A request that `repeats` may be done twice by the slave and does no harm.
    pub(in crate::master) fn confirmed<'a>(
        &mut self,
        now: BitTime,
        confirmation: Confirmation<'a>,
        repeats: bool,
        patience: &Timeouts,
    ) -> Progress<'a> {
        self.not_before = now + patience.pace_tbit;
        match confirmation {
            Confirmation::Answer(answer) => self.answered(&answer, patience),
            Confirmation::Failed(failure @ Failure::Impossible) => Progress::Failed(Cause::Lost(failure)),
            // Another master spoke at the same time, and neither was understood: nothing is wrong with the slave.
            Confirmation::Failed(Failure::Interrupted) if repeats && self.stage == Stage::Request => {
                self.uncertain = true;
                Progress::Waiting
            }
            // Whether the slave has got the request is not known, and a write must not be done twice: from here on the
            // response is waited for. profibus-wire 4.9, rule 6.
            Confirmation::Failed(failure) => {
                self.stage = Stage::Poll;
                let (_, since) = self.lost.unwrap_or((failure, now));
                self.lost = Some((failure, since));
                Progress::Waiting
            }
            Confirmation::Sent => Progress::Waiting,
        }
    }

    fn answered<'a>(&mut self, answer: &Answer<'a>, patience: &Timeouts) -> Progress<'a> {
        self.lost = None;
        match answer.status {
            Status::NoReply => {
                self.stage = Stage::Poll;
                self.rejections = 0;
                Progress::Waiting
            }
            Status::DataLow => Progress::Response(answer.du),
            // It has the request already.
            Status::NoResource if self.uncertain => {
                (self.stage, self.uncertain) = (Stage::Poll, false);
                Progress::Waiting
            }
            // Nothing was stored: the same again, later. profibus-wire 4.12.
            Status::NoResource | Status::UserError if self.rejections < patience.rejections => {
                self.rejections = self.rejections.saturating_add(1);
                Progress::Waiting
            }
            status => Progress::Failed(Cause::Status(status)),
        }
    }
}
