//! MS2 of a class 2 master: one connection to one slave. profibus-wire 4.6 to 4.9 and 4.11.
//!
//! ```text
//! Initiating(Manager) ── RM ── Initiating(Server) ── Initiate.res ── Open ◄────────────┐
//!     │ RS, UE, RR, D7, Abort        │ RS, D7, Abort                 │ service, T idle │
//!     ▼                              ▼                               ▼                 │
//!   Ended ◄──────── SC ──────── Aborting ◄── wrong, late, user ── Transferring ── response
//!     ▲                                                              │
//!     └───────────────────────── RS, Abort of the slave ─────────────┘
//! ```
//!
//! The first message to SAP 49 carries the Initiate and is answered by the resource manager at once, or by SC, and then SAP
//! 49 is polled. An ended connection is never opened again: that is up to the user.

mod parameters;

pub use parameters::{Ms2Parameters, Opened};

use super::acyclic::{
    AcyclicEvent, Cause, ConnectionEnd, ExpectedResponse, Outcome, Pooled, Progress, Stage, SubmitError, Timeouts,
    Transaction,
};
use crate::link::BitTime;
use crate::link::active::{Confirmation, Failure, Request};
use core::fmt;
use profivac_wire::Sap;
use profivac_wire::acyclic::{
    Abort, AbortReason, Function, InitiateRes, Negative, Request as Pdu, ResourceManager, Response,
};
use profivac_wire::control::{self, Status};
use profivac_wire::sap::MASTER_MS2;

/// Where a connection stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The resource manager, and then the slave, is asked for a connection.
    Initiating,
    /// Requests are taken.
    Open,
    /// A request is under way.
    Transferring,
    /// The slave is told that the connection is over.
    Aborting,
    /// It is over.
    Ended,
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Initiating => "INITIATING",
            Self::Open => "OPEN",
            Self::Transferring => "TRANSFERRING",
            Self::Aborting => "ABORTING",
            Self::Ended => "ENDED",
        })
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ConnectionState {
    Initiating(Step),
    /// An Idle follows at this time, counted from the first time the connection was asked for work.
    Open(Option<BitTime>),
    Transferring(ExpectedResponse),
    /// The reason is told to the slave.
    Aborting(AbortReason, ConnectionEnd),
    Ended(ConnectionEnd),
}

/// Who is asked for the connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Manager,
    /// At this access point.
    Server(ResourceManager),
}

/// An outcome that waits to be taken; its octets are in the post box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Done {
    Opened(Opened),
    Read,
    Written,
    Transported,
    Refused(Negative),
}

/// The request of the user. An Idle may be under way when it is handed in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum UserRequest {
    None,
    Waiting(ExpectedResponse),
    Done(Done),
}

/// A connection.
#[derive(Clone, Debug)]
pub(super) struct Connection {
    address: u8,
    parameters: Ms2Parameters,
    state: ConnectionState,
    request: UserRequest,
    /// The user wants it closed, for this reason.
    closing: Option<AbortReason>,
    server_sap: u8,
    max_len_data_unit: u8,
    /// T.
    timeout_tbit: u64,
    timeouts: Timeouts,
    transaction: Transaction,
    abort: [u8; 3],
}

impl Pooled for Connection {
    const SERVICE: u8 = 2;

    fn is_over(&self) -> bool {
        matches!(self.state, ConnectionState::Ended(_))
    }
}

/// The one octet of Idle.
const IDLE: [u8; 1] = [Function::Idle.number()];

impl Connection {
    pub(super) fn new(address: u8, parameters: &Ms2Parameters) -> Self {
        let timeout_tbit = parameters.timeout_tbit(0);
        let mut post = Transaction::new();
        post.put(&Pdu::Initiate(parameters.initiate()));
        Self {
            address,
            parameters: *parameters,
            state: ConnectionState::Initiating(Step::Manager),
            request: UserRequest::None,
            closing: None,
            server_sap: 0,
            max_len_data_unit: 0,
            timeout_tbit,
            timeouts: parameters.timeouts(timeout_tbit),
            transaction: post,
            abort: [0; 3],
        }
    }

    pub(super) const fn address(&self) -> u8 {
        self.address
    }

    pub(super) const fn phase(&self) -> Phase {
        match self.state {
            ConnectionState::Initiating(_) => Phase::Initiating,
            ConnectionState::Open(_) => Phase::Open,
            ConnectionState::Transferring(_) => Phase::Transferring,
            ConnectionState::Aborting(..) => Phase::Aborting,
            ConnectionState::Ended(_) => Phase::Ended,
        }
    }

    /// Hands in a request with `octets` of record, wanted or sent.
    pub(super) fn submit(
        &mut self,
        expected: ExpectedResponse,
        octets: usize,
        pdu: &Pdu<'_>,
    ) -> Result<(), SubmitError> {
        match (self.state, self.request, self.closing) {
            (ConnectionState::Open(_), UserRequest::None, None)
            | (ConnectionState::Transferring(ExpectedResponse::Idle), UserRequest::None, None) => {}
            (ConnectionState::Open(_) | ConnectionState::Transferring(_), _, None) => return Err(SubmitError::Busy),
            _ => return Err(SubmitError::NotOpen),
        }
        let room = usize::from(self.max_len_data_unit);
        if octets == 0 || octets > room || !self.transaction.put(pdu) {
            return Err(SubmitError::Length { octets, room });
        }
        self.request = UserRequest::Waiting(expected);
        Ok(())
    }

    /// How many octets one request carries.
    pub(super) const fn max_len_data_unit(&self) -> u8 {
        self.max_len_data_unit
    }

    /// The user does not want the connection any more.
    pub(super) const fn close(&mut self, reason: AbortReason) {
        self.closing = Some(reason);
    }

    /// How it ended, when there is no other outcome to be taken before.
    pub(super) const fn ended(&self) -> Option<ConnectionEnd> {
        match (self.request, self.state) {
            (UserRequest::None | UserRequest::Waiting(_), ConnectionState::Ended(end)) => Some(end),
            _ => None,
        }
    }

    /// The outcome of the request, once.
    pub(super) fn outcome(&mut self) -> Option<Outcome<'_>> {
        let UserRequest::Done(done) = self.request else { return None };
        self.request = UserRequest::None;
        Some(match done {
            Done::Opened(opened) => Outcome::Opened(opened),
            Done::Read => Outcome::Read(self.transaction.octets()),
            Done::Written => Outcome::Written,
            Done::Transported => Outcome::Transported(self.transaction.octets()),
            Done::Refused(negative) => Outcome::Refused(negative),
        })
    }

    /// Time has come to `now`: what is due, and whether there is a message to send.
    pub(super) fn elapse(&mut self, now: BitTime) -> Option<AcyclicEvent> {
        match self.state {
            _ if self.wants_to_close() => return self.closed(),
            ConnectionState::Initiating(_) | ConnectionState::Transferring(_) => {
                if let Some(cause) = self.transaction.elapse(now, &self.timeouts) {
                    return self.failed(cause);
                }
            }
            ConnectionState::Open(idle_at) => {
                let idle_at = idle_at.unwrap_or(now + self.timeout_tbit);
                match self.request {
                    UserRequest::Waiting(expected) => self.transfer(expected),
                    _ if idle_at <= now => self.transfer(ExpectedResponse::Idle),
                    _ => self.state = ConnectionState::Open(Some(idle_at)),
                }
            }
            ConnectionState::Aborting(..) | ConnectionState::Ended(_) => {}
        }
        None
    }

    /// Whether there is a message to send.
    pub(super) fn is_due(&self, now: BitTime) -> bool {
        match self.state {
            ConnectionState::Initiating(_) | ConnectionState::Transferring(_) => self.transaction.is_due(now),
            ConnectionState::Aborting(..) => true,
            ConnectionState::Open(_) | ConnectionState::Ended(_) => false,
        }
    }

    /// The next message.
    pub(super) fn message(&self) -> Option<Request<'_>> {
        let pdu = match self.state {
            ConnectionState::Initiating(_) => self.transaction.octets(),
            ConnectionState::Transferring(ExpectedResponse::Idle) => &IDLE,
            ConnectionState::Transferring(_) => self.transaction.octets(),
            ConnectionState::Aborting(..) => return Some(self.abort_message()),
            ConnectionState::Open(_) | ConnectionState::Ended(_) => return None,
        };
        let dsap = match self.state {
            ConnectionState::Initiating(Step::Manager) => Sap::ResourceManager.to_octet()?,
            _ => self.server_sap,
        };
        Some(self.transaction.message(self.address, (dsap, MASTER_MS2), pdu))
    }

    fn abort_message(&self) -> Request<'_> {
        Request {
            da: self.address,
            function: control::Function::SrdLow,
            dsap: Some(self.server_sap),
            ssap: Some(MASTER_MS2),
            du: &self.abort,
        }
    }

    /// What became of the message.
    pub(super) fn confirmed(&mut self, now: BitTime, confirmation: Confirmation<'_>) -> Option<AcyclicEvent> {
        let expected = match self.state {
            ConnectionState::Initiating(Step::Manager) => ExpectedResponse::ResourceManager,
            ConnectionState::Initiating(Step::Server(_)) => ExpectedResponse::Initiate,
            ConnectionState::Transferring(expected) => expected,
            // Nobody answers an Abort but by SC, and if it was lost the slave's own timers end the connection.
            ConnectionState::Aborting(_, end) => return self.end(end),
            ConnectionState::Open(_) | ConnectionState::Ended(_) => return None,
        };
        let sent = self.transaction.stage;
        match self.transaction.confirmed(now, confirmation, expected.is_repeatable(), &self.timeouts) {
            Progress::Waiting => match (expected, sent, confirmation) {
                // Nobody there: no connection is lost by giving up at once. profibus-wire 4.11.
                (ExpectedResponse::ResourceManager, Stage::Request, Confirmation::Failed(failure))
                    if failure != Failure::Interrupted =>
                {
                    self.failed(Cause::Lost(failure))
                }
                _ => None,
            },
            Progress::Failed(cause) => self.failed(cause),
            Progress::Response(pdu) => match expected.matched(pdu) {
                Ok(response) => self.responded(&response),
                Err(wrong) => self.failed(Cause::Mismatch(wrong)),
            },
        }
    }

    /// The response that was expected, its negative form, or Abort.
    fn responded(&mut self, response: &Response<'_>) -> Option<AcyclicEvent> {
        match (response, self.state) {
            (Response::Abort(abort), _) => self.end(ConnectionEnd::Aborted(abort.reason)),
            (Response::Negative(negative), ConnectionState::Initiating(_)) => {
                self.end(ConnectionEnd::Refused(*negative))
            }
            (Response::ResourceManager(manager), _) => {
                self.timeout_tbit = self.parameters.timeout_tbit(manager.min_send_timeout);
                self.timeouts = self.parameters.timeouts(self.timeout_tbit);
                self.server_sap = manager.server_sap;
                self.transaction.begin(Stage::Poll);
                self.state = ConnectionState::Initiating(Step::Server(*manager));
                None
            }
            (Response::Initiate(initiate), ConnectionState::Initiating(Step::Server(manager))) => {
                self.opened(manager, initiate)
            }
            (Response::Negative(negative), _) => self.done(Done::Refused(*negative)),
            (Response::Read(record), _) => {
                self.transaction.keep(record.data);
                self.done(Done::Read)
            }
            (Response::DataTransport(record), _) => {
                self.transaction.keep(record.data);
                self.done(Done::Transported)
            }
            (Response::Write(_), _) => self.done(Done::Written),
            (Response::Idle(_) | Response::Initiate(_) | Response::AlarmAck(_), _) => {
                self.state = ConnectionState::Open(None);
                None
            }
        }
    }

    fn opened(&mut self, manager: ResourceManager, initiate: &InitiateRes<'_>) -> Option<AcyclicEvent> {
        self.max_len_data_unit = initiate.max_len_data_unit;
        self.done(Done::Opened(Opened {
            server_sap: manager.server_sap,
            max_len_data_unit: initiate.max_len_data_unit,
            send_timeout: manager.min_send_timeout.max(self.parameters.send_timeout),
            capabilities: initiate.capabilities,
        }))
    }

    const fn done(&mut self, done: Done) -> Option<AcyclicEvent> {
        self.state = ConnectionState::Open(None);
        self.request = UserRequest::Done(done);
        Some(AcyclicEvent::OutcomeReady)
    }

    fn transfer(&mut self, expected: ExpectedResponse) {
        if expected != ExpectedResponse::Idle {
            self.request = UserRequest::None;
        }
        self.transaction.begin(Stage::Request);
        self.state = ConnectionState::Transferring(expected);
    }

    /// Whether the wish to close can be followed now. While the resource manager is being polled the access point is not
    /// known yet, and the slave has reserved one.
    fn wants_to_close(&self) -> bool {
        match self.state {
            ConnectionState::Initiating(Step::Manager) => {
                self.closing.is_some() && self.transaction.stage == Stage::Request
            }
            ConnectionState::Aborting(..) | ConnectionState::Ended(_) => false,
            _ => self.closing.is_some(),
        }
    }

    fn closed(&mut self) -> Option<AcyclicEvent> {
        let reason = self.closing?;
        match self.state {
            ConnectionState::Initiating(Step::Manager) => self.end(ConnectionEnd::Closed(reason)),
            _ => self.abort(reason, ConnectionEnd::Closed(reason)),
        }
    }

    /// The connection cannot go on. The slave is told so, unless it has no access point for it.
    fn failed(&mut self, cause: Cause) -> Option<AcyclicEvent> {
        let reason = reason(cause);
        let end = ConnectionEnd::Failed { reason, cause };
        match (self.state, cause) {
            (ConnectionState::Initiating(Step::Manager), _) | (_, Cause::Status(Status::ServiceNotActivated)) => {
                self.end(end)
            }
            _ => self.abort(reason, end),
        }
    }

    fn abort(&mut self, reason: AbortReason, end: ConnectionEnd) -> Option<AcyclicEvent> {
        if Pdu::Abort(Abort::new(reason)).emit(&mut self.abort).is_err() {
            return self.end(end);
        }
        self.state = ConnectionState::Aborting(reason, end);
        None
    }

    /// A request that waits has no outcome of its own: the end is it.
    fn end(&mut self, end: ConnectionEnd) -> Option<AcyclicEvent> {
        if let UserRequest::Waiting(_) = self.request {
            self.request = UserRequest::None;
        }
        self.state = ConnectionState::Ended(end);
        Some(AcyclicEvent::Ended(end))
    }
}

/// The reason that is told for a cause. profibus-wire 4.8.
const fn reason(cause: Cause) -> AbortReason {
    match cause {
        Cause::Timeout => AbortReason::TIMEOUT,
        Cause::Lost(_) => AbortReason::Fdl(15),
        Cause::Status(Status::UserError) => AbortReason::Fdl(1),
        Cause::Status(Status::NoResource) => AbortReason::Fdl(2),
        Cause::Status(Status::ServiceNotActivated) => AbortReason::Fdl(3),
        Cause::Status(Status::DataHigh) => AbortReason::Fdl(10),
        Cause::Status(Status::DataLowNotTaken) => AbortReason::Fdl(12),
        Cause::Status(Status::DataHighNotTaken) => AbortReason::Fdl(13),
        Cause::Status(_) | Cause::Mismatch(_) => AbortReason::INVALID_RESPONSE,
        // Of other services.
        Cause::Channel(_) | Cause::Left | Cause::NotOperating => AbortReason::SEQUENCE,
    }
}
