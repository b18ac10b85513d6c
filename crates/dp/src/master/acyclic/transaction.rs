//! One request and its response, as MS1 and MS2 both carry them: the slave acknowledges the request, and the master fetches
//! the response by polling. profibus-wire 4.2.

use super::outcome::Cause;
use super::response::ExpectedResponse;
use crate::link::BitTime;
use crate::link::active::{Answer, Confirmation, Failure, Request};
use profivac_wire::MAX_DU;
use profivac_wire::acyclic::Request as Pdu;
use profivac_wire::control::{Function, Status};

/// The timeouts and limits of a transaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::master) struct Timeouts {
    /// The longest wait for the response.
    pub(in crate::master) response_tbit: u64,
    /// The longest time without any answer.
    pub(in crate::master) lost_tbit: u64,
    /// The least time between two messages.
    pub(in crate::master) pace_tbit: u64,
    /// How often in a row the slave may answer RR or UE.
    pub(in crate::master) rejections: u8,
    /// A read is sent again when an answer was lost. The slave may then have a response that nothing fetches, and answers RR to the next
    /// request: only an Abort ends that.
    pub(in crate::master) resends: bool,
}

/// The next message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::master) enum Stage {
    /// The request. The slave has not confirmed that it has it.
    Request,
    /// An empty data unit, which fetches the response.
    Poll,
}

/// The effect of a confirmation on the transaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::master) enum Progress<'a> {
    /// The transaction continues.
    Waiting,
    /// A response PDU came; the caller checks it.
    Response(&'a [u8]),
    /// The transaction failed.
    Failed(Cause),
}

/// A request under way. The buffer holds the request until the response replaces it.
#[derive(Clone, Debug)]
pub(in crate::master) struct Transaction {
    octets: [u8; MAX_DU],
    length: usize,
    pub(in crate::master) stage: Stage,
    rejections: u8,
    /// The request was sent before, and the slave may have it.
    uncertain: bool,
    /// The first failure since the last answer, and its time.
    lost: Option<(Failure, BitTime)>,
    not_before: BitTime,
    /// Counted from the first call of [`elapse`](Self::elapse), because a request may wait for the token before.
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

    /// Stores a request. Returns `false` if it is too long for a telegram.
    pub(in crate::master) fn store_request(&mut self, pdu: &Pdu<'_>) -> bool {
        self.length = pdu.emit(&mut self.octets).unwrap_or(0);
        self.length > 0
    }

    /// Begins at a stage: with the request, or with polling if another message carried the request.
    pub(in crate::master) const fn begin(&mut self, stage: Stage) {
        self.stage = stage;
        self.rejections = 0;
        self.uncertain = false;
        self.lost = None;
        self.deadline = None;
    }

    /// The request, or the record of the response.
    pub(in crate::master) fn octets(&self) -> &[u8] {
        self.octets.get(..self.length).unwrap_or_default()
    }

    /// Replaces the request by the record of its response.
    pub(in crate::master) fn store_response(&mut self, data: &[u8]) {
        if let Some(front) = self.octets.get_mut(..data.len()) {
            front.copy_from_slice(data);
            self.length = data.len();
        }
    }

    /// Whether the slave cannot have the request.
    pub(in crate::master) const fn is_unheard(&self) -> bool {
        matches!(self.stage, Stage::Request) && !self.uncertain
    }

    /// Sends the next message not before `until`.
    pub(in crate::master) const fn pause(&mut self, until: BitTime) {
        self.not_before = until;
    }

    /// Whether the next message may be sent.
    pub(in crate::master) fn is_due(&self, now: BitTime) -> bool {
        self.not_before <= now
    }

    /// The next message to `da`, between two access points. `pdu` is the request.
    pub(in crate::master) fn message<'a>(&self, da: u8, (dsap, ssap): (u8, u8), pdu: &'a [u8]) -> Request<'a> {
        let du = match self.stage {
            Stage::Request => pdu,
            Stage::Poll => &[],
        };
        Request { da, function: Function::SrdLow, dsap: Some(dsap), ssap: Some(ssap), du }
    }

    /// Advances the time to `now`. Returns the cause if a timeout has passed.
    pub(in crate::master) fn elapse(&mut self, now: BitTime, timeouts: &Timeouts) -> Option<Cause> {
        let deadline = *self.deadline.get_or_insert(now + timeouts.response_tbit);
        match self.lost {
            Some((failure, since)) if since + timeouts.lost_tbit <= now || deadline <= now => {
                Some(Cause::NoAnswer(failure))
            }
            _ if deadline <= now => Some(Cause::Timeout),
            _ => None,
        }
    }

    /// Evaluates the confirmation of the message sent last.
    pub(in crate::master) fn confirmed<'a>(
        &mut self,
        now: BitTime,
        confirmation: Confirmation<'a>,
        expected: &ExpectedResponse,
        timeouts: &Timeouts,
    ) -> Progress<'a> {
        self.not_before = now + timeouts.pace_tbit;
        match confirmation {
            Confirmation::Answer(answer) => self.answered(&answer, expected, timeouts),
            Confirmation::Failed(failure @ Failure::Impossible) => Progress::Failed(Cause::NoAnswer(failure)),
            // Another master sent at the same time, and neither telegram was received: the slave is not at fault.
            Confirmation::Failed(Failure::Interrupted) if expected.is_repeatable() && self.stage == Stage::Request => {
                self.uncertain = true;
                Progress::Waiting
            }
            // The slave may or may not have got the request, or has given its response to a poll whose answer was lost, and then polls
            // for it are in vain. A read is sent again: a slave that has it answers RR (profibus-wire 10, point 20). A write must not
            // be executed twice: from here on the master polls for the response. profibus-wire 4.9, rule 6.
            Confirmation::Failed(failure) => {
                self.uncertain = timeouts.resends && expected.is_resent();
                self.stage = if self.uncertain { Stage::Request } else { Stage::Poll };
                let (_, since) = self.lost.unwrap_or((failure, now));
                self.lost = Some((failure, since));
                Progress::Waiting
            }
            Confirmation::Sent => Progress::Waiting,
        }
    }

    fn answered<'a>(&mut self, answer: &Answer<'a>, expected: &ExpectedResponse, timeouts: &Timeouts) -> Progress<'a> {
        self.lost = None;
        match answer.status {
            Status::NoReply => {
                self.stage = Stage::Poll;
                self.rejections = 0;
                Progress::Waiting
            }
            Status::DataLow => Progress::Response(answer.du),
            // The slave already has the request, from an earlier message or from the telegram that the link layer has repeated.
            Status::NoResource if self.uncertain || (self.stage == Stage::Request && answer.repetitions > 0) => {
                (self.stage, self.uncertain) = (Stage::Poll, false);
                Progress::Waiting
            }
            // UE: the slave's application interface failed, maybe after it had the request, which must not be executed twice.
            // profibus-wire 4.12.
            Status::UserError if self.stage == Stage::Request && !expected.is_repeatable() => {
                Progress::Failed(Cause::Status(Status::UserError))
            }
            // The same message again, later. profibus-wire 4.9, rule 6.
            Status::NoResource | Status::UserError if self.rejections < timeouts.rejections => {
                self.rejections = self.rejections.saturating_add(1);
                Progress::Waiting
            }
            status => Progress::Failed(Cause::Status(status)),
        }
    }
}
