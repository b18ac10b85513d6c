//! MS1 of a class 1 master: one request to a slave in data exchange, and its response. profibus-wire 4.2, 4.3 and 4.5.
//!
//! MS1 has no connection of its own: it lives with data exchange. A job ends with its response, or fails: when the slave
//! leaves data exchange; when its access point is closed; when a response is wrong; and when none comes in time. After the
//! last two a late response could be taken for the one to the next request, so the slave is started anew.

use super::acyclic::{Cause, Expected, Held, Notice, Outcome, Patience, PostBox, Progress};
use crate::link::active::{Confirmation, Request};
use crate::link::{Baud, BitTime};
use profivac_wire::Sap;
use profivac_wire::acyclic::{Negative, Request as Pdu, Response};

/// How MS1 requests are supervised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ms1Parameters {
    /// C1_Response_Timeout of the GSD file, in bit times.
    pub response_tbit: u64,
    /// No message follows the one before sooner, in bit times. At least the Min_Slave_Interval of the slave.
    pub pace_tbit: u64,
    /// How often in a row the slave may answer RR or UE.
    pub rejections: u8,
}

impl Ms1Parameters {
    /// A C1_Response_Timeout of 4 s, the usual one (profibus-wire 4.3), a millisecond between messages.
    #[must_use]
    pub const fn new(baud: Baud) -> Self {
        Self { response_tbit: baud.tbit_of_ms(4000), pace_tbit: baud.tbit_of_ms(1), rejections: 10 }
    }

    const fn patience(&self) -> Patience {
        Patience {
            response_tbit: self.response_tbit,
            lost_tbit: self.response_tbit,
            pace_tbit: self.pace_tbit,
            rejections: self.rejections,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Running,
    Read,
    Written,
    Acknowledged,
    Refused(Negative),
    Failed(Cause),
    /// The outcome was taken.
    Taken,
}

/// One request.
#[derive(Clone, Debug)]
pub(super) struct Job {
    address: u8,
    /// Which data exchange it belongs to: how often the slave had come there.
    starts: u32,
    parameters: Ms1Parameters,
    expected: Expected,
    state: State,
    post: PostBox,
}

impl Held for Job {
    const SERVICE: u8 = 1;

    fn is_over(&self) -> bool {
        self.state != State::Running
    }

    fn is_taken(&self) -> bool {
        self.state == State::Taken
    }
}

impl Job {
    /// `None` if the request is too long.
    pub(super) fn new(
        (address, starts): (u8, u32),
        expected: Expected,
        pdu: &Pdu<'_>,
        parameters: &Ms1Parameters,
    ) -> Option<Self> {
        let mut post = PostBox::new();
        post.put(pdu).then_some(Self {
            address,
            starts,
            parameters: *parameters,
            expected,
            state: State::Running,
            post,
        })
    }

    pub(super) const fn address(&self) -> u8 {
        self.address
    }

    pub(super) const fn starts(&self) -> u32 {
        self.starts
    }

    pub(super) fn is_due(&self, now: BitTime) -> bool {
        self.state == State::Running && self.post.is_due(now)
    }

    /// The outcome, once.
    pub(super) fn outcome(&mut self) -> Option<Outcome<'_>> {
        let state = self.state;
        if self.is_over() {
            self.state = State::Taken;
        }
        Some(match state {
            State::Running | State::Taken => return None,
            State::Read => Outcome::Read(self.post.octets()),
            State::Written => Outcome::Written,
            State::Acknowledged => Outcome::Acknowledged,
            State::Refused(negative) => Outcome::Refused(negative),
            State::Failed(cause) => Outcome::Failed(cause),
        })
    }

    /// Time has come to `now`.
    pub(super) fn elapse(&mut self, now: BitTime) -> Option<Notice> {
        if self.state != State::Running {
            return None;
        }
        let cause = self.post.elapse(now, &self.parameters.patience())?;
        self.fail(cause)
    }

    pub(super) fn message(&self) -> Option<Request<'_>> {
        let sap = Sap::Ms1.to_octet()?;
        Some(self.post.message(self.address, (sap, sap), self.post.octets()))
    }

    pub(super) fn confirmed(&mut self, now: BitTime, confirmation: Confirmation<'_>) -> Option<Notice> {
        if self.state != State::Running {
            return None;
        }
        match self.post.confirmed(now, confirmation, self.expected.repeats(), &self.parameters.patience()) {
            Progress::Waiting => None,
            Progress::Failed(cause) => self.fail(cause),
            Progress::Response(pdu) => match self.expected.matched(pdu) {
                Ok(response) => self.responded(&response),
                Err(wrong) => self.fail(Cause::Wrong(wrong)),
            },
        }
    }

    fn responded(&mut self, response: &Response<'_>) -> Option<Notice> {
        self.state = match response {
            Response::Read(record) => {
                self.post.keep(record.data);
                State::Read
            }
            Response::Write(_) => State::Written,
            Response::AlarmAck(_) => State::Acknowledged,
            Response::Negative(negative) => State::Refused(*negative),
            // MS1 knows no others: an Abort is a response to another function.
            other => return self.fail(Cause::Wrong(self.expected.other_than(other))),
        };
        Some(Notice::Done)
    }

    pub(super) fn fail(&mut self, cause: Cause) -> Option<Notice> {
        if self.state != State::Running {
            return None;
        }
        self.state = State::Failed(cause);
        Some(Notice::Done)
    }

    /// Whether the slave must be started anew, because it may still respond. profibus-wire 4.3 has that for the time-out.
    pub(super) const fn is_late(&self) -> bool {
        matches!(self.state, State::Failed(Cause::Timeout | Cause::Lost(_) | Cause::Wrong(_)))
    }
}
