//! MS1 of a class 1 master: one request to a slave in data exchange, and its response. profibus-wire 4.2, 4.3 and 4.5.
//!
//! MS1 has no connection of its own: it depends on data exchange. A request ends with its response, or it fails: when the
//! slave leaves data exchange, when its access point is closed, when the response is wrong, and when none comes in time. In
//! the last two cases a late response could be taken for the response to the next request, so the master restarts the slave.

use super::acyclic::{AcyclicEvent, Cause, ExpectedResponse, Pooled, Progress, Stage, Timeouts, Transaction};
use crate::link::active::{Confirmation, Request};
use crate::link::{Baud, BitTime};
use core::fmt;
use profivac_wire::Sap;
use profivac_wire::acyclic::{Negative, Request as Pdu, Response};

/// Operation of [`Master::ms1_read`](super::Master::ms1_read): the outcome is the record.
#[derive(Clone, Copy, Debug)]
pub enum Read {}

/// Operation of [`Master::ms1_write`](super::Master::ms1_write).
#[derive(Clone, Copy, Debug)]
pub enum Write {}

/// Operation of [`Master::ms1_alarm_ack`](super::Master::ms1_alarm_ack).
#[derive(Clone, Copy, Debug)]
pub enum AcknowledgeAlarm {}

/// The reason why an MS1 request has no positive response.
///
/// Not `non_exhaustive`: a caller treats each of the cases differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RequestError {
    /// The slave refused the request.
    Refused(Negative),
    /// The request failed, and the slave may have executed it.
    Failed(Cause),
    /// The request failed, and the slave has not executed it: it was not sent, or the access point did not take it.
    NotExecuted(Cause),
    /// The slave left data exchange, and may have executed the request before.
    LeftExchange,
    /// The slave left data exchange before the request was sent.
    NotSent,
}

impl fmt::Display for RequestError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(negative) => write!(f, "the slave refused the request: {}", negative.code_1),
            Self::Failed(cause) | Self::NotExecuted(cause) => cause.fmt(f),
            Self::LeftExchange | Self::NotSent => f.write_str("the slave left data exchange"),
        }
    }
}

impl core::error::Error for RequestError {}

/// The timeouts of MS1 requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ms1Parameters {
    /// C1_Response_Timeout of the GSD file, in bit times.
    pub response_tbit: u64,
    /// The least time between two messages, in bit times. At least the Min_Slave_Interval of the slave.
    pub pace_tbit: u64,
    /// How often in a row the slave may answer RR or UE.
    pub rejections: u8,
}

impl Ms1Parameters {
    /// A C1_Response_Timeout of 4 s, the usual one (profibus-wire 4.3), and a millisecond between messages.
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
            resends: false,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RequestState {
    Running,
    /// The record of a read is in the transaction.
    Done(Result<(), RequestError>),
    /// The outcome was taken.
    Taken,
}

/// One request.
#[derive(Clone, Debug)]
pub(super) struct Ms1Request {
    address: u8,
    /// The data exchange that the request belongs to: how often the slave had entered data exchange.
    starts: u32,
    parameters: Ms1Parameters,
    expected: ExpectedResponse,
    state: RequestState,
    /// The slave may have executed the request.
    is_delivered: bool,
    transaction: Transaction,
}

impl Pooled for Ms1Request {
    fn is_over(&self) -> bool {
        self.state != RequestState::Running
    }

    fn is_taken(&self) -> bool {
        self.state == RequestState::Taken
    }
}

impl Ms1Request {
    /// Returns `None` if the request is too long.
    pub(super) fn new(
        (address, starts): (u8, u32),
        expected: ExpectedResponse,
        pdu: &Pdu<'_>,
        parameters: &Ms1Parameters,
    ) -> Option<Self> {
        let mut transaction = Transaction::new();
        transaction.store_request(pdu).then_some(Self {
            address,
            starts,
            parameters: *parameters,
            expected,
            state: RequestState::Running,
            is_delivered: false,
            transaction,
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

    /// The outcome, once: the record of a read, no octets for the others.
    pub(super) fn take_outcome(&mut self) -> Option<Result<&[u8], RequestError>> {
        let RequestState::Done(result) = self.state else { return None };
        self.state = RequestState::Taken;
        Some(result.map(|()| self.transaction.octets()))
    }

    /// Advances the time to `now`.
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
        if self.transaction.stage == Stage::Request {
            self.is_delivered |= confirmation.is_delivery();
        }
        let timeouts = self.parameters.timeouts();
        match self.transaction.confirmed(now, confirmation, &self.expected, &timeouts) {
            Progress::Waiting => None,
            Progress::Failed(cause) => self.fail(cause),
            Progress::Response(pdu) => match self.expected.matched(pdu) {
                Ok(response) => self.responded(&response),
                Err(mismatch) => self.fail(Cause::Mismatch(mismatch)),
            },
        }
    }

    fn responded(&mut self, response: &Response<'_>) -> Option<AcyclicEvent> {
        match response {
            Response::Read(record) => {
                self.transaction.store_response(record.data);
                self.finish(Ok(()))
            }
            Response::Write(_) | Response::AlarmAck(_) => self.finish(Ok(())),
            Response::Negative(negative) => self.finish(Err(RequestError::Refused(*negative))),
            // MS1 has no other functions: an Abort is a response to another function.
            other => self.fail(Cause::Mismatch(self.expected.other_function(other))),
        }
    }

    fn fail(&mut self, cause: Cause) -> Option<AcyclicEvent> {
        let error = if self.is_delivered { RequestError::Failed } else { RequestError::NotExecuted };
        self.finish(Err(error(cause)))
    }

    /// The slave left data exchange.
    pub(super) fn left_exchange(&mut self) -> Option<AcyclicEvent> {
        self.finish(Err(if self.is_delivered { RequestError::LeftExchange } else { RequestError::NotSent }))
    }

    fn finish(&mut self, result: Result<(), RequestError>) -> Option<AcyclicEvent> {
        if self.state != RequestState::Running {
            return None;
        }
        self.state = RequestState::Done(result);
        Some(AcyclicEvent::OutcomeReady)
    }

    /// Whether the slave may still respond, so that it must be restarted. profibus-wire 4.3 requires that for the time-out.
    pub(super) const fn may_respond_late(&self) -> bool {
        matches!(
            self.state,
            RequestState::Done(Err(RequestError::Failed(Cause::Timeout | Cause::NoAnswer(_) | Cause::Mismatch(_))))
        )
    }
}
