//! MS1 of a class 1 master: one request to a slave in data exchange, and its response. profibus-wire 4.2, 4.3 and 4.5.
//!
//! MS1 has no connection of its own: it lives with data exchange. A job ends with its response, or fails: when the slave
//! leaves data exchange; when its access point is closed; when a response is wrong; and when none comes in time. After the
//! last two a late response could be taken for the one to the next request, so the slave is started anew.

use super::acyclic::{AcyclicEvent, Cause, ExpectedResponse, Outcome, Pooled, Progress, Timeouts, Transaction};
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

    const fn timeouts(&self) -> Timeouts {
        Timeouts {
            response_tbit: self.response_tbit,
            lost_tbit: self.response_tbit,
            pace_tbit: self.pace_tbit,
            rejections: self.rejections,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RequestState {
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
pub(super) struct Ms1Request {
    address: u8,
    /// Which data exchange it belongs to: how often the slave had come there.
    starts: u32,
    parameters: Ms1Parameters,
    expected: ExpectedResponse,
    state: RequestState,
    transaction: Transaction,
}

impl Pooled for Ms1Request {
    const SERVICE: u8 = 1;

    fn is_over(&self) -> bool {
        self.state != RequestState::Running
    }

    fn is_taken(&self) -> bool {
        self.state == RequestState::Taken
    }
}

impl Ms1Request {
    /// `None` if the request is too long.
    pub(super) fn new(
        (address, starts): (u8, u32),
        expected: ExpectedResponse,
        pdu: &Pdu<'_>,
        parameters: &Ms1Parameters,
    ) -> Option<Self> {
        let mut post = Transaction::new();
        post.put(pdu).then_some(Self {
            address,
            starts,
            parameters: *parameters,
            expected,
            state: RequestState::Running,
            transaction: post,
        })
    }

    pub(super) const fn address(&self) -> u8 {
        self.address
    }

    pub(super) const fn starts(&self) -> u32 {
        self.starts
    }

    pub(super) fn is_due(&self, now: BitTime) -> bool {
        self.state == RequestState::Running && self.transaction.is_due(now)
    }

    /// The outcome, once.
    pub(super) fn outcome(&mut self) -> Option<Outcome<'_>> {
        let state = self.state;
        if self.is_over() {
            self.state = RequestState::Taken;
        }
        Some(match state {
            RequestState::Running | RequestState::Taken => return None,
            RequestState::Read => Outcome::Read(self.transaction.octets()),
            RequestState::Written => Outcome::Written,
            RequestState::Acknowledged => Outcome::Acknowledged,
            RequestState::Refused(negative) => Outcome::Refused(negative),
            RequestState::Failed(cause) => Outcome::Failed(cause),
        })
    }

    /// Time has come to `now`.
    pub(super) fn elapse(&mut self, now: BitTime) -> Option<AcyclicEvent> {
        if self.state != RequestState::Running {
            return None;
        }
        let cause = self.transaction.elapse(now, &self.parameters.timeouts())?;
        self.fail(cause)
    }

    pub(super) fn message(&self) -> Option<Request<'_>> {
        let sap = Sap::Ms1.to_octet()?;
        Some(self.transaction.message(self.address, (sap, sap), self.transaction.octets()))
    }

    pub(super) fn confirmed(&mut self, now: BitTime, confirmation: Confirmation<'_>) -> Option<AcyclicEvent> {
        if self.state != RequestState::Running {
            return None;
        }
        match self.transaction.confirmed(now, confirmation, self.expected.is_repeatable(), &self.parameters.timeouts())
        {
            Progress::Waiting => None,
            Progress::Failed(cause) => self.fail(cause),
            Progress::Response(pdu) => match self.expected.matched(pdu) {
                Ok(response) => self.responded(&response),
                Err(wrong) => self.fail(Cause::Mismatch(wrong)),
            },
        }
    }

    fn responded(&mut self, response: &Response<'_>) -> Option<AcyclicEvent> {
        self.state = match response {
            Response::Read(record) => {
                self.transaction.keep(record.data);
                RequestState::Read
            }
            Response::Write(_) => RequestState::Written,
            Response::AlarmAck(_) => RequestState::Acknowledged,
            Response::Negative(negative) => RequestState::Refused(*negative),
            // MS1 knows no others: an Abort is a response to another function.
            other => return self.fail(Cause::Mismatch(self.expected.other_than(other))),
        };
        Some(AcyclicEvent::OutcomeReady)
    }

    pub(super) fn fail(&mut self, cause: Cause) -> Option<AcyclicEvent> {
        if self.state != RequestState::Running {
            return None;
        }
        self.state = RequestState::Failed(cause);
        Some(AcyclicEvent::OutcomeReady)
    }

    /// Whether the slave must be started anew, because it may still respond. profibus-wire 4.3 has that for the time-out.
    pub(super) const fn is_late(&self) -> bool {
        matches!(self.state, RequestState::Failed(Cause::Timeout | Cause::Lost(_) | Cause::Mismatch(_)))
    }
}
