//! MS2 of a class 2 master: one connection to one slave. profibus-wire 4.6 to 4.9 and 4.11.
//!
//! ```text
//! Initiating(Manager) ── RM ── Initiating(Server) ── Initiate.res ── Open ◄────────────┐
//!     │ RR, D7, Abort                │ RS, D7, Abort                 │ service, T idle │
//!     ▼                              ▼                               ▼                 │
//!   Ended ◄───── SC, RS ─────── Aborting ◄── wrong, late, user ── Transferring ── response
//!     ▲                                                              │
//!     └───────────────────────── RS, Abort of the slave ─────────────┘
//! ```
//!
//! The Abort, at the known access point (Aborting) or at one after the other (Searching):
//!
//! | Answer | Meaning, profibus-wire 4.8 and 4.10 | Aborting | Searching |
//! |---|---|---|---|
//! | SC | the slave frees the connection | Ended | Ended, or Initiating again |
//! | RS | the master has no connection there | Ended | the next access point |
//! | RR, UE, data | the access point is not closed | again, for half a second | again, `rejections` times |
//! | none | the slave may have got the Abort | again, for half a second | again, twice |
//!
//! The first message to SAP 49 carries the Initiate. The resource manager answers it at once, or with SC, and then the master
//! polls SAP 49. This master never reopens a connection that has ended; that is up to the user.
//!
//! A slave has few connections, so the master leaves none behind. It repeats an Abort until the slave answers SC or RS. If the answer of the
//! resource manager is lost, the slave has a connection for the master, and the master does not know its access point: it sends the
//! Abort to one access point after the other until the slave accepts it. It does the same when the resource manager is closed (RS),
//! because an earlier program with this station address may have ended without an Abort; then it asks for a connection again. A slave
//! accepts the Abort of the master that has the connection, and answers RS to every other (profibus-wire 4.10), so the search ends no
//! connection of another master.
//!
//! A master without slaves of its own reads and writes records of a slave that belongs to no master. The slave is in memory:
//!
//! ```
//! use profivac_dp::link::active::{Active, BusParameters};
//! use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Station};
//! use profivac_dp::master::ms2::RequestError;
//! use profivac_dp::master::{Master, Ms2Parameters, Phase, Settings};
//! use profivac_dp::slave::{CfgFault, Device, Dpv1Error, Features, Outputs, PrmFault, Relation, Slave};
//! use profivac_wire::acyclic::ErrorCode;
//! use profivac_wire::{Telegram, cfg};
//!
//! /// A device with one record: index 20 of slot 1.
//! struct OneRecord(Vec<u8>);
//!
//! impl Device for OneRecord {
//!     fn features(&self) -> Features {
//!         Features { dpv1: true, ..Features::default() }
//!     }
//!     fn read(&mut self, _via: Relation, slot: u8, index: u8, record: &mut [u8]) -> Result<usize, Dpv1Error> {
//!         if slot != 1 {
//!             return Err(Dpv1Error::INVALID_SLOT);
//!         }
//!         if index != 20 {
//!             return Err(Dpv1Error::INVALID_INDEX.with(3));
//!         }
//!         record[..self.0.len()].copy_from_slice(&self.0);
//!         Ok(self.0.len())
//!     }
//!     fn write(&mut self, _via: Relation, _slot: u8, _index: u8, record: &[u8]) -> Result<(), Dpv1Error> {
//!         self.0 = record.to_vec();
//!         Ok(())
//!     }
//!     // Cyclic data are not used here.
//! #     fn ident_number(&self) -> u16 { 0x1234 }
//! #     fn set_prm(&mut self, _user: &[u8]) -> Result<(), PrmFault> { Ok(()) }
//! #     fn chk_cfg(&mut self, octets: &[u8]) -> Result<cfg::Lengths, CfgFault> { cfg::lengths(octets).map_err(|_| CfgFault) }
//! #     fn get_cfg(&self) -> &[u8] { &[0x11] }
//! #     fn outputs(&mut self, _outputs: Outputs<'_>) {}
//! #     fn inputs(&mut self, _inputs: &mut [u8]) {}
//! }
//!
//! /// Runs the line until `done`: the master sends at its deadline, the slave answers not before min T_SDR.
//! fn run(
//!     master: &mut Active<Master<1, 32>>,
//!     slave: &mut Slave<OneRecord>,
//!     now: &mut BitTime,
//!     done: impl Fn(&Master<1, 32>) -> bool,
//! ) {
//!     while !done(&master.user) {
//!         *now = (*now).max(master.wake_at().expect("a master always has a deadline"));
//!         let Some(request) = master.poll(*now) else { continue };
//!         let octets = request.octets.to_vec();
//!         *now = (*now).max(request.not_before) + CHARACTER_TBIT * octets.len() as u64;
//!         master.sent(*now);
//!         let request = Telegram::parse(&octets).expect("a master sends valid telegrams");
//!         let Some(answer) = slave.telegram(*now, &request) else { continue };
//!         *now = answer.not_before + CHARACTER_TBIT * answer.octets.len() as u64;
//!         master.telegram(*now, &Telegram::parse(answer.octets).expect("a slave sends valid telegrams"));
//!     }
//! }
//!
//! let baud = Baud::B1500000;
//! let mut slave = Slave::<OneRecord>::new(OneRecord(vec![1, 2, 3]), 8, baud);
//! let mut master = Master::<1, 32>::on(BusParameters::new(2, baud).check()?, Settings::new(baud), BitTime(0));
//! let mut now = BitTime(0);
//!
//! let connection = master.user.ms2_open(8, &Ms2Parameters::new(baud))?;
//! run(&mut master, &mut slave, &mut now, |master| master.ms2_phase(connection) == Some(Phase::Open));
//! let opened = master.user.outcome(connection).expect("the connection is open")?;
//! assert_eq!(opened.max_len_data_unit, 240);
//!
//! let write = master.user.ms2_write(connection, 1, 20, &[4, 5])?;
//! run(&mut master, &mut slave, &mut now, |master| master.is_over(write));
//! assert_eq!(master.user.outcome(write), Some(Ok(())));
//!
//! let read = master.user.ms2_read(connection, 1, 20, 240)?;
//! run(&mut master, &mut slave, &mut now, |master| master.is_over(read));
//! assert_eq!(master.user.outcome(read), Some(Ok(&[4, 5][..])));
//!
//! // A refusal has the codes of the device; the connection stays open.
//! let read = master.user.ms2_read(connection, 1, 21, 240)?;
//! run(&mut master, &mut slave, &mut now, |master| master.is_over(read));
//! let Some(Err(RequestError::Refused(negative))) = master.user.outcome(read) else { panic!("expected a refusal") };
//! assert_eq!((negative.code_1, negative.code_2), (ErrorCode::INVALID_INDEX, 3));
//!
//! master.user.ms2_close(connection)?;
//! run(&mut master, &mut slave, &mut now, |master| master.is_over(connection));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

mod parameters;

pub use parameters::{Ms2Parameters, Opened};

use super::acyclic::{
    AcyclicEvent, Cause, ConnectionEnd, ExpectedResponse, Pooled, Progress, Stage, SubmitError, Timeouts, Transaction,
};
use crate::link::BitTime;
use crate::link::active::{Answer, Confirmation, Failure, Request};
use core::fmt;
use profivac_wire::Sap;
use profivac_wire::acyclic::{
    Abort, AbortReason, Function, InitiateRes, Negative, Request as Pdu, ResourceManager, Response,
};
use profivac_wire::control::{self, Status};
use profivac_wire::sap::MASTER_MS2;

/// Operation of [`Master::ms2_open`](super::Master::ms2_open): the first outcome is [`Opened`], the last one the
/// [`ConnectionEnd`].
#[derive(Clone, Copy, Debug)]
pub enum Connect {}

/// Operation of [`Master::ms2_read`](super::Master::ms2_read): the outcome is the record.
#[derive(Clone, Copy, Debug)]
pub enum Read {}

/// Operation of [`Master::ms2_write`](super::Master::ms2_write).
#[derive(Clone, Copy, Debug)]
pub enum Write {}

/// Operation of [`Master::ms2_transport`](super::Master::ms2_transport): the outcome is the data that the slave returns.
#[derive(Clone, Copy, Debug)]
pub enum Transport {}

/// The reason why an MS2 request has no positive response.
///
/// Not `non_exhaustive`: after `Refused` the connection is open, after the others it is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RequestError {
    /// The slave refused the request; the connection stays open.
    Refused(Negative),
    /// The connection has ended, and the slave may have executed the request. The handle of the connection is used up too.
    Ended(ConnectionEnd),
    /// The connection has ended, and the slave has not executed the request: it was not sent, or the access point did not take it.
    /// The handle of the connection is used up too.
    NotExecuted(ConnectionEnd),
}

impl fmt::Display for RequestError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(negative) => write!(f, "the slave refused the request: {}", negative.code_1),
            Self::Ended(end) | Self::NotExecuted(end) => end.fmt(f),
        }
    }
}

impl core::error::Error for RequestError {}

/// The phase of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Phase {
    /// The master asks the resource manager, and then the server, for a connection.
    Initiating,
    /// The master accepts requests.
    Open,
    /// A request is under way.
    Transferring,
    /// The master sends the slave an Abort.
    Aborting,
    /// The connection has ended.
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
    /// An Idle follows at this time, counted from the first call of `elapse` in this state.
    Open(Option<BitTime>),
    Transferring(ExpectedResponse),
    /// The Abort is sent, after the first one without SC or RS until this time.
    Aborting(ConnectionEnd, Option<BitTime>),
    Searching(Search),
    Ended(ConnectionEnd),
}

/// The Abort is sent to one access point after the other, until the slave accepts it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Search {
    sap: u8,
    /// The Aborts in a row that got neither SC nor RS.
    attempts: u8,
    /// The slave may have accepted an Abort although no SC came: RS to the next one does not deny it.
    is_uncertain: bool,
    /// The end of the connection when the search is over.
    end: ConnectionEnd,
    /// A connection that the search has freed is asked for again.
    is_for_reuse: bool,
}

impl Search {
    /// The end if the search itself fails: that is not the refusal of a slave whose connections are all in use.
    const fn given_up(&self, cause: Cause) -> ConnectionEnd {
        if self.is_for_reuse { ConnectionEnd::Failed { reason: reason(cause), cause } } else { self.end }
    }
}

/// The meaning of the confirmation of an Abort.
enum AbortAnswer {
    /// SC: the slave frees the connection.
    Accepted,
    /// RS: the master has no connection there. After a repetition of the link layer the slave may have freed it.
    NotOpen { is_repeated: bool },
    /// The access point is not closed: RR, UE, or a response that waited.
    Open,
    /// The slave may have got the Abort.
    Lost(Failure),
}

impl AbortAnswer {
    const fn of(confirmation: &Confirmation<'_>) -> Self {
        match confirmation {
            Confirmation::Answer(Answer { status: Status::NoReply, .. }) => Self::Accepted,
            Confirmation::Answer(Answer { status: Status::ServiceNotActivated, repetitions, .. }) => {
                Self::NotOpen { is_repeated: *repetitions > 0 }
            }
            Confirmation::Answer(_) | Confirmation::Sent => Self::Open,
            Confirmation::Failed(failure) => Self::Lost(*failure),
        }
    }
}

/// The highest access point of a connection: profibus-wire 4.6.
const FIRST_SAP: u8 = 48;

/// How long an Abort without SC or RS is repeated, in milliseconds.
/// chosen: a computer or a slave that is busy for a moment answers within it, and a program whose gauge is gone ends within a second.
const ABORT_MS: u64 = 500;

/// How often a search repeats an Abort without an answer: then the slave is gone.
/// chosen: an absent slave costs three more requests with their repetitions.
const LOST_REPEATS: u8 = 2;

/// How long the resource manager may still be closed after the slave has accepted an Abort, in milliseconds.
/// chosen: the slave returns the access point when it answers (profibus-wire 4.8 and 4.10). T is the time of its user, who has no part
/// in that.
const FREE_MS: u64 = 1000;

/// The pause before the resource manager is asked again meanwhile, in milliseconds.
/// chosen: fifty requests at most.
const FREE_PAUSE_MS: u64 = 20;

/// The partner that the master asks for the connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Manager,
    /// The server at this access point.
    Server(ResourceManager),
}

/// The request of the user. An Idle may be under way when the user submits it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum UserRequest {
    None,
    Waiting(ExpectedResponse),
    Running,
    /// The connection was opened, and the user has not taken that outcome.
    Opened(Opened),
    /// The outcome of the request was not taken. The record is in the transaction.
    Done(Result<(), Negative>),
}

/// A connection.
#[derive(Clone, Debug)]
pub(super) struct Connection {
    address: u8,
    parameters: Ms2Parameters,
    state: ConnectionState,
    request: UserRequest,
    /// The number of the last request.
    number: u32,
    /// The slave may have executed the last request.
    is_delivered: bool,
    /// Whether a closed resource manager is a reason to search for a connection that an earlier program has left.
    searches: bool,
    /// A search has freed a connection, and until this time the resource manager may still be closed.
    freed_until: Option<BitTime>,
    /// Whether the slave may still have a connection of this master: see [`leftover`](Self::leftover).
    leftover: Option<bool>,
    /// The user closes the connection, for this reason.
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
    fn is_over(&self) -> bool {
        matches!(self.state, ConnectionState::Ended(_))
    }
}

/// The one octet of Idle.
const IDLE: [u8; 1] = [Function::Idle.number()];

impl Connection {
    /// `searches` as in the field.
    pub(super) fn new(address: u8, parameters: &Ms2Parameters, searches: bool) -> Self {
        let timeout_tbit = parameters.timeout_tbit(0);
        let mut transaction = Transaction::new();
        transaction.store_request(&Pdu::Initiate(parameters.initiate()));
        Self {
            address,
            parameters: *parameters,
            state: ConnectionState::Initiating(Step::Manager),
            request: UserRequest::None,
            number: 0,
            is_delivered: false,
            searches,
            freed_until: None,
            leftover: None,
            closing: None,
            server_sap: 0,
            max_len_data_unit: 0,
            timeout_tbit,
            timeouts: parameters.timeouts(timeout_tbit),
            transaction,
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
            ConnectionState::Aborting(..) | ConnectionState::Searching(_) => Phase::Aborting,
            ConnectionState::Ended(_) => Phase::Ended,
        }
    }

    /// Whether the connection has nothing to do while another one searches at its slave: it is new.
    pub(super) fn waits_for_search(&self) -> bool {
        matches!(self.state, ConnectionState::Initiating(Step::Manager)) && self.closing.is_none()
    }

    /// Whether the connection sends to access points that another connection to the same slave may get meanwhile.
    pub(super) const fn is_searching(&self) -> bool {
        matches!(self.state, ConnectionState::Searching(_))
    }

    /// What the end of the connection says about the slave: that it may still have a connection of this master, that it has none, or
    /// nothing new.
    pub(super) const fn leftover(&self) -> Option<bool> {
        self.leftover
    }

    /// Accepts a request with a record of `octets` octets, to be read or written, and returns its number. An outcome that
    /// was not taken is dropped.
    pub(super) fn submit(
        &mut self,
        expected: ExpectedResponse,
        octets: usize,
        pdu: &Pdu<'_>,
    ) -> Result<u32, SubmitError> {
        match (self.state, self.request, self.closing) {
            (
                ConnectionState::Open(_) | ConnectionState::Transferring(_),
                UserRequest::Waiting(_) | UserRequest::Running,
                None,
            ) => return Err(SubmitError::Busy),
            (ConnectionState::Open(_) | ConnectionState::Transferring(ExpectedResponse::Idle), _, None) => {}
            _ => return Err(SubmitError::NotOpen),
        }
        let room = usize::from(self.max_len_data_unit);
        if octets == 0 || octets > room || !self.transaction.store_request(pdu) {
            return Err(SubmitError::Length { octets, room });
        }
        self.request = UserRequest::Waiting(expected);
        self.is_delivered = false;
        self.number = self.number.wrapping_add(1);
        Ok(self.number)
    }

    /// The most octets of a record in one request.
    pub(super) const fn max_len_data_unit(&self) -> u8 {
        self.max_len_data_unit
    }

    /// The user closes the connection.
    pub(super) const fn close(&mut self, reason: AbortReason) {
        self.closing = Some(reason);
    }

    /// How the connection ended, unless an outcome can be taken before.
    pub(super) const fn ended(&self) -> Option<ConnectionEnd> {
        match (self.request, self.state) {
            (UserRequest::None | UserRequest::Waiting(_) | UserRequest::Running, ConnectionState::Ended(end)) => {
                Some(end)
            }
            _ => None,
        }
    }

    /// The properties of the connection, once after it was opened.
    pub(super) const fn take_opened(&mut self) -> Option<Opened> {
        let UserRequest::Opened(opened) = self.request else { return None };
        self.request = UserRequest::None;
        Some(opened)
    }

    /// Whether a request is waiting or under way, or its outcome was not taken.
    pub(super) const fn has_request(&self, number: u32) -> bool {
        self.number == number
            && matches!(self.request, UserRequest::Waiting(_) | UserRequest::Running | UserRequest::Done(_))
    }

    /// Whether the slave may have executed the last request.
    pub(super) const fn is_delivered(&self) -> bool {
        self.is_delivered
    }

    /// Whether a request is waiting or under way.
    pub(super) const fn is_running(&self, number: u32) -> bool {
        self.has_request(number) && !matches!(self.request, UserRequest::Done(_))
    }

    /// The outcome of the request, once: the record, no octets for a write.
    pub(super) fn take_outcome(&mut self) -> Option<Result<&[u8], Negative>> {
        let UserRequest::Done(result) = self.request else { return None };
        self.request = UserRequest::None;
        Some(result.map(|()| self.transaction.octets()))
    }

    /// Advances the time to `now`: timeouts end the connection, a waiting request or an Idle begins. `is_alone` says that this master
    /// has no other connection to the slave.
    pub(super) fn elapse(&mut self, now: BitTime, is_alone: bool) -> Option<AcyclicEvent> {
        match self.state {
            _ if self.can_close() => return self.closed(),
            ConnectionState::Initiating(_) | ConnectionState::Transferring(_) => {
                if let Some(cause) = self.transaction.elapse(now, &self.timeouts) {
                    return self.failed(cause, is_alone);
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
            ConnectionState::Aborting(end, _) => return self.not_sent(now, |_| end),
            ConnectionState::Searching(search) => return self.not_sent(now, |cause| search.given_up(cause)),
            ConnectionState::Ended(_) => {}
        }
        None
    }

    /// Gives up an Abort that the slave has not answered for T: the station may have no token to send it.
    fn not_sent(&mut self, now: BitTime, end: impl Fn(Cause) -> ConnectionEnd) -> Option<AcyclicEvent> {
        let cause = self.transaction.elapse(now, &self.timeouts)?;
        self.leftover = Some(true);
        self.end(end(cause))
    }

    /// Whether a message is ready to be sent.
    pub(super) fn is_due(&self, now: BitTime) -> bool {
        match self.state {
            ConnectionState::Initiating(_) | ConnectionState::Transferring(_) | ConnectionState::Searching(_) => {
                self.transaction.is_due(now)
            }
            ConnectionState::Aborting(_, until) => until.is_none() || self.transaction.is_due(now),
            ConnectionState::Open(_) | ConnectionState::Ended(_) => false,
        }
    }

    /// The next message.
    pub(super) fn message(&self) -> Option<Request<'_>> {
        let pdu = match self.state {
            ConnectionState::Transferring(ExpectedResponse::Idle) => &IDLE,
            ConnectionState::Initiating(_) | ConnectionState::Transferring(_) => self.transaction.octets(),
            ConnectionState::Aborting(..) => return Some(self.abort_message(self.server_sap)),
            ConnectionState::Searching(Search { sap, .. }) => return Some(self.abort_message(sap)),
            ConnectionState::Open(_) | ConnectionState::Ended(_) => return None,
        };
        let dsap = match self.state {
            ConnectionState::Initiating(Step::Manager) => Sap::ResourceManager.to_octet()?,
            _ => self.server_sap,
        };
        Some(self.transaction.message(self.address, (dsap, MASTER_MS2), pdu))
    }

    fn abort_message(&self, sap: u8) -> Request<'_> {
        Request {
            da: self.address,
            function: control::Function::SrdLow,
            dsap: Some(sap),
            ssap: Some(MASTER_MS2),
            du: &self.abort,
        }
    }

    /// Evaluates the confirmation of the message sent last. `is_alone` as in [`elapse`](Self::elapse).
    pub(super) fn confirmed(
        &mut self,
        now: BitTime,
        confirmation: Confirmation<'_>,
        is_alone: bool,
    ) -> Option<AcyclicEvent> {
        let expected = match self.state {
            ConnectionState::Initiating(Step::Manager) => ExpectedResponse::ResourceManager,
            ConnectionState::Initiating(Step::Server(_)) => ExpectedResponse::Initiate,
            ConnectionState::Transferring(expected) => expected,
            ConnectionState::Aborting(end, until) => return self.abort_confirmed(now, end, until, confirmation),
            ConnectionState::Searching(search) => return self.search_confirmed(now, search, confirmation),
            ConnectionState::Open(_) | ConnectionState::Ended(_) => return None,
        };
        let sent = self.transaction.stage;
        if (sent, self.request) == (Stage::Request, UserRequest::Running) {
            self.is_delivered |= confirmation.is_delivery();
        }
        match self.transaction.confirmed(now, confirmation, &expected, &self.timeouts) {
            Progress::Waiting => match (expected, sent, confirmation) {
                // No station is there, or its answer was lost: the search finds that out.
                (ExpectedResponse::ResourceManager, Stage::Request, Confirmation::Failed(failure))
                    if failure != Failure::Interrupted =>
                {
                    self.failed(Cause::NoAnswer(failure), is_alone)
                }
                _ => None,
            },
            Progress::Failed(Cause::Status(Status::ServiceNotActivated)) if self.is_being_freed(now) => {
                // Each request has its own time for the response: RS after `FREE_MS` decides.
                self.transaction.begin(Stage::Request);
                self.transaction.pause(now + self.tbit_of_ms(FREE_PAUSE_MS));
                None
            }
            Progress::Failed(cause) => self.failed(cause, is_alone),
            Progress::Response(pdu) => match expected.matched(pdu) {
                Ok(response) => self.responded(&response),
                Err(mismatch) => self.failed(Cause::Mismatch(mismatch), is_alone),
            },
        }
    }

    /// Whether the slave has accepted an Abort a short time ago, and may not offer the access point yet.
    fn is_being_freed(&self, now: BitTime) -> bool {
        self.state == ConnectionState::Initiating(Step::Manager) && self.freed_until.is_some_and(|until| now < until)
    }

    const fn tbit_of_ms(&self, ms: u64) -> u64 {
        self.parameters.baud.tbit_of_ms(ms)
    }

    /// RS: the slave has received an earlier Abort.
    fn abort_confirmed(
        &mut self,
        now: BitTime,
        end: ConnectionEnd,
        until: Option<BitTime>,
        confirmation: Confirmation<'_>,
    ) -> Option<AcyclicEvent> {
        if let AbortAnswer::Open | AbortAnswer::Lost(_) = AbortAnswer::of(&confirmation) {
            let until = until.unwrap_or(now + self.tbit_of_ms(ABORT_MS));
            if now < until {
                self.transaction.pause(now + self.parameters.pace_tbit);
                self.state = ConnectionState::Aborting(end, Some(until));
                return None;
            }
            self.leftover = Some(true);
        }
        self.end(end)
    }

    fn search_confirmed(
        &mut self,
        now: BitTime,
        search: Search,
        confirmation: Confirmation<'_>,
    ) -> Option<AcyclicEvent> {
        self.transaction.pause(now + self.parameters.pace_tbit);
        let (repeats, end) = match AbortAnswer::of(&confirmation) {
            AbortAnswer::Accepted => return self.found(now, search),
            AbortAnswer::NotOpen { is_repeated } => {
                let is_uncertain = search.is_uncertain || is_repeated;
                return self.search_on(now, Search { attempts: 0, is_uncertain, ..search });
            }
            AbortAnswer::Open => (self.parameters.rejections, search.end),
            AbortAnswer::Lost(failure) => (LOST_REPEATS, search.given_up(Cause::NoAnswer(failure))),
        };
        if search.attempts < repeats {
            let attempts = search.attempts.saturating_add(1);
            self.state = ConnectionState::Searching(Search { attempts, is_uncertain: true, ..search });
            return None;
        }
        self.leftover = Some(true);
        self.end(end)
    }

    /// The access point is not the master's: the next one, or the end of the search.
    fn search_on(&mut self, now: BitTime, search: Search) -> Option<AcyclicEvent> {
        if let Some(sap) = search.sap.checked_sub(1) {
            self.transaction.begin(Stage::Request);
            self.state = ConnectionState::Searching(Search { sap, ..search });
            return None;
        }
        self.leftover = Some(false);
        if search.is_uncertain { self.found(now, search) } else { self.end(search.end) }
    }

    /// The slave has accepted the Abort, so it frees a connection.
    fn found(&mut self, now: BitTime, search: Search) -> Option<AcyclicEvent> {
        match self.closing {
            None if search.is_for_reuse => {
                self.freed_until = Some(now + self.tbit_of_ms(FREE_MS));
                self.transaction.begin(Stage::Request);
                self.state = ConnectionState::Initiating(Step::Manager);
                None
            }
            Some(reason) if search.is_for_reuse => self.end(ConnectionEnd::Closed(reason)),
            _ => self.end(search.end),
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
            (Response::Negative(negative), _) => self.done(UserRequest::Done(Err(*negative))),
            (Response::Read(record) | Response::DataTransport(record), _) => {
                self.transaction.store_response(record.data);
                self.done(UserRequest::Done(Ok(())))
            }
            (Response::Write(_), _) => self.done(UserRequest::Done(Ok(()))),
            (Response::Idle(_) | Response::Initiate(_) | Response::AlarmAck(_), _) => {
                self.state = ConnectionState::Open(None);
                None
            }
        }
    }

    fn opened(&mut self, manager: ResourceManager, initiate: &InitiateRes<'_>) -> Option<AcyclicEvent> {
        self.max_len_data_unit = initiate.max_len_data_unit;
        self.done(UserRequest::Opened(Opened {
            server_sap: manager.server_sap,
            max_len_data_unit: initiate.max_len_data_unit,
            send_timeout: manager.min_send_timeout.max(self.parameters.send_timeout),
            capabilities: initiate.capabilities,
        }))
    }

    const fn done(&mut self, outcome: UserRequest) -> Option<AcyclicEvent> {
        self.state = ConnectionState::Open(None);
        self.request = outcome;
        Some(AcyclicEvent::OutcomeReady)
    }

    fn transfer(&mut self, expected: ExpectedResponse) {
        if expected != ExpectedResponse::Idle {
            self.request = UserRequest::Running;
        }
        self.transaction.begin(Stage::Request);
        self.state = ConnectionState::Transferring(expected);
    }

    /// Whether the user closes the connection and that is possible now. While the master polls the resource manager it does
    /// not know the access point yet, and the slave has reserved one.
    fn can_close(&self) -> bool {
        match self.state {
            ConnectionState::Initiating(Step::Manager) => self.closing.is_some() && self.transaction.is_unheard(),
            ConnectionState::Aborting(..) | ConnectionState::Searching(_) | ConnectionState::Ended(_) => false,
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

    /// The connection has failed. The master sends an Abort, unless the slave has no access point for it.
    fn failed(&mut self, cause: Cause, is_alone: bool) -> Option<AcyclicEvent> {
        let reason = reason(cause);
        let end = ConnectionEnd::Failed { reason, cause };
        match (self.state, cause) {
            (ConnectionState::Initiating(Step::Manager), Cause::Status(Status::ServiceNotActivated)) => {
                if is_alone && core::mem::take(&mut self.searches) {
                    self.search(reason, end, true)
                } else {
                    self.end(end)
                }
            }
            // The slave has stored nothing.
            (
                ConnectionState::Initiating(Step::Manager),
                Cause::Status(Status::NoResource) | Cause::NoAnswer(Failure::Impossible),
            )
            | (_, Cause::Status(Status::ServiceNotActivated)) => self.end(end),
            (ConnectionState::Initiating(Step::Manager), _) if is_alone => self.search(reason, end, false),
            (ConnectionState::Initiating(Step::Manager), _) => {
                self.leftover = Some(true);
                self.end(end)
            }
            _ => self.abort(reason, end),
        }
    }

    /// Begins to search for the connection that the slave has for this master.
    fn search(&mut self, reason: AbortReason, end: ConnectionEnd, is_for_reuse: bool) -> Option<AcyclicEvent> {
        let search = Search { sap: FIRST_SAP, attempts: 0, is_uncertain: false, end, is_for_reuse };
        self.send_abort(reason, ConnectionState::Searching(search), end)
    }

    fn abort(&mut self, reason: AbortReason, end: ConnectionEnd) -> Option<AcyclicEvent> {
        self.send_abort(reason, ConnectionState::Aborting(end, None), end)
    }

    /// Enters a state in which an Abort with this reason is sent.
    fn send_abort(&mut self, reason: AbortReason, state: ConnectionState, end: ConnectionEnd) -> Option<AcyclicEvent> {
        if Pdu::Abort(Abort::new(reason)).emit(&mut self.abort).is_err() {
            return self.end(end);
        }
        self.transaction.begin(Stage::Request);
        self.state = state;
        None
    }

    const fn end(&mut self, end: ConnectionEnd) -> Option<AcyclicEvent> {
        self.state = ConnectionState::Ended(end);
        Some(AcyclicEvent::Ended(end))
    }
}

/// The reason that the master sends for a cause. profibus-wire 4.8: the codes of subnet FDL are those of the link layer's
/// confirmations.
const fn reason(cause: Cause) -> AbortReason {
    match cause {
        Cause::Timeout => AbortReason::TIMEOUT,
        Cause::NoAnswer(_) => AbortReason::Fdl(15),
        Cause::Status(Status::UserError) => AbortReason::Fdl(1),
        Cause::Status(Status::NoResource) => AbortReason::Fdl(2),
        Cause::Status(Status::ServiceNotActivated) => AbortReason::Fdl(3),
        Cause::Status(Status::DataHigh) => AbortReason::Fdl(10),
        Cause::Status(Status::DataLowNotTaken) => AbortReason::Fdl(12),
        Cause::Status(Status::DataHighNotTaken) => AbortReason::Fdl(13),
        Cause::Status(_) | Cause::Mismatch(_) => AbortReason::INVALID_RESPONSE,
    }
}
