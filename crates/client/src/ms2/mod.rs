//! Records over MS2, as a class 2 master reads and writes them. profibus-wire 4.2 and 4.6 to 4.8.
//!
//! MS2 needs no parameterisation and does not disturb the owner of the slave.
//!
//! A telegram may be lost or come too late at every step. A read is repeated then, on a new connection if the old one has ended. A write
//! is repeated only if the slave cannot have executed it; otherwise its error says that it may have been executed. The master ends the
//! connections that it gives up: [`profivac_dp::master::ms2`].

mod abandoned;

pub(crate) use abandoned::Abandoned;

use crate::records::{Interruption, RecordError, Records, Unavailable, UnrestoredRecord};
use profivac_devices::model::AccessPath;
use profivac_dp::link::Baud;
use profivac_dp::master::ms2::{self, Connect, RequestError};
use profivac_dp::master::{Cause, ConnectionEnd, Handle, Ms2Parameters, Operation, SubmitError};
use profivac_host::session::{BusMaster, BusSession, SessionError};
use profivac_wire::acyclic::Negative;
use profivac_wire::acyclic::record::MAX_RECORD_LENGTH;
use profivac_wire::control::Status;
use std::time::{Duration, Instant};

/// The pauses before a request is repeated because the slave does not answer: the computer or the slave is busy with something else.
/// chosen: an opening that fails takes a few slot times only, so without pauses all attempts would fall into the same short stall.
const PAUSES: [Duration; 2] = [Duration::from_millis(500), Duration::from_millis(1500)];

/// The reason why an MS2 request failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Ms2Error {
    /// The bus session failed.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The bus session failed before the request was sent.
    #[error(transparent)]
    NotSent(SessionError),
    /// The connection ended, and the slave may have executed the request.
    #[error("{0}")]
    Ended(ConnectionEnd),
    /// The connection could not be opened or ended, and the slave has not executed the request.
    #[error("{0}")]
    NotExecuted(ConnectionEnd),
    /// The slave refused.
    #[error("refused with {code_1}", code_1 = .0.code_1)]
    Refused(Negative),
    /// The master did not accept the request.
    #[error(transparent)]
    NotSubmitted(#[from] SubmitError),
    /// No answer arrived in time.
    #[error("no answer")]
    NoAnswer,
    /// A kept connection has ended, and its client does not open another one.
    #[error("the kept connection has ended")]
    KeptConnectionEnded,
}

/// A line with a master that carries MS2 requests: a bus session, or a segment in memory.
///
/// ```
/// use profivac_client::Bus;
/// use profivac_client::ms2::{self, Ms2Error, Ms2Line};
/// use profivac_dp::link::Baud;
/// use profivac_dp::master::{Handle, Operation};
/// use profivac_host::session::{BusMaster, BusSession};
///
/// /// A line that counts its requests.
/// struct Counted<'a> {
///     session: &'a mut BusSession,
///     requests: usize,
/// }
///
/// impl Ms2Line for Counted<'_> {
///     fn baud(&self) -> Baud {
///         self.session.baud()
///     }
///
///     fn master(&mut self) -> &mut BusMaster {
///         self.session.master()
///     }
///
///     fn wait_for<O: Operation, T>(
///         &mut self,
///         handle: Handle<O>,
///         take: impl FnOnce(O::Outcome<'_>) -> T,
///     ) -> Result<T, Ms2Error> {
///         self.requests += 1;
///         Ok(self.session.wait_for_outcome(handle, take)?)
///     }
/// }
///
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
/// let mut line = Counted { session: bus.session(), requests: 0 };
/// ms2::read(&mut line, 5, 0, 25)?;
/// assert!(line.requests >= 2, "the connection and the read");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Ms2Line {
    /// The baud rate of the line.
    fn baud(&self) -> Baud;

    /// The master.
    fn master(&mut self) -> &mut BusMaster;

    /// Serves the line until the request of `handle` has an outcome.
    ///
    /// # Errors
    /// [`Ms2Error::Session`] or [`Ms2Error::NoAnswer`].
    fn wait_for<O: Operation, T>(
        &mut self,
        handle: Handle<O>,
        take: impl FnOnce(O::Outcome<'_>) -> T,
    ) -> Result<T, Ms2Error>;

    /// See [`Records::keep_unrestored`].
    fn keep_unrestored(&mut self, _address: u8, _record: UnrestoredRecord) {}

    /// See [`Records::take_unrestored`].
    fn take_unrestored(&mut self, _address: u8) -> Option<UnrestoredRecord> {
        None
    }

    /// See [`Records::set_restoring`].
    fn set_restoring(&mut self, _is_restoring: bool) {}

    /// Takes the open connection that an earlier client of the slave has left; the default keeps none.
    fn take_connection(&mut self, _address: u8) -> Option<Handle<Connect>> {
        None
    }

    /// Leaves an open connection to the next client of the slave. Returns false if it is to be closed instead.
    fn leave_connection(&mut self, _address: u8, _connection: Handle<Connect>) -> bool {
        false
    }

    /// Serves the line for this time before a request is repeated. The default repeats it at once.
    ///
    /// # Errors
    /// [`Ms2Error::Session`].
    fn pause(&mut self, _time: Duration) -> Result<(), Ms2Error> {
        Ok(())
    }

    /// Serves the line once, because the connection is busy with a request that was given up at a cancellation. Returns whether
    /// to try again; the default never waits, for lines without cancellation.
    ///
    /// # Errors
    /// [`Ms2Error::Session`].
    fn wait_while_busy(&mut self, _begun: Instant) -> Result<bool, Ms2Error> {
        Ok(false)
    }
}

impl Ms2Line for BusSession {
    fn baud(&self) -> Baud {
        Self::baud(self)
    }

    fn master(&mut self) -> &mut BusMaster {
        Self::master(self)
    }

    fn wait_for<O: Operation, T>(
        &mut self,
        handle: Handle<O>,
        take: impl FnOnce(O::Outcome<'_>) -> T,
    ) -> Result<T, Ms2Error> {
        Ok(self.wait_for_outcome(handle, take)?)
    }

    fn keep_unrestored(&mut self, address: u8, record: UnrestoredRecord) {
        Self::keep_unrestored(self, address, record);
    }

    fn take_unrestored(&mut self, address: u8) -> Option<UnrestoredRecord> {
        Self::take_unrestored(self, address)
    }

    fn set_restoring(&mut self, is_restoring: bool) {
        Self::set_restoring(self, is_restoring);
    }

    fn take_connection(&mut self, address: u8) -> Option<Handle<Connect>> {
        Self::take_connection(self, address)
    }

    fn leave_connection(&mut self, address: u8, connection: Handle<Connect>) -> bool {
        Self::leave_connection(self, address, connection)
    }

    fn pause(&mut self, time: Duration) -> Result<(), Ms2Error> {
        Ok(Self::pause(self, time)?)
    }

    fn wait_while_busy(&mut self, begun: Instant) -> Result<bool, Ms2Error> {
        Ok(self.wait_once(begun)?)
    }
}

/// Reads the record at `slot` and `index` of the slave at `address`, with a connection of its own.
///
/// ```
/// # use profivac_client::{Bus, ms2};
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
/// // Device State, slot 0 index 25.
/// assert_eq!(ms2::read(bus.session(), 5, 0, 25)?, [2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`Ms2Error`].
pub fn read(line: &mut impl Ms2Line, address: u8, slot: u8, index: u8) -> Result<Vec<u8>, Ms2Error> {
    Ms2::new(line, address).read(slot, index)
}

/// An MS2 connection to a slave.
///
/// The first request opens it. If it has ended since, for example because the gauge was switched off and on, the next request opens
/// it again. Dropping it closes it, or leaves it to the next client of the slave: see
/// [`BusSession::set_connection_kept`].
///
/// ```
/// # use profivac_client::{Bus, ms2::Ms2};
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
/// let mut connection = Ms2::new(bus.session(), 5);
/// // Safe State of the selected instance, slot 1 index 39.
/// connection.write(1, 39, &[2])?;
/// assert_eq!(connection.read(1, 39)?, [2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Ms2<'a, L: Ms2Line = BusSession> {
    line: &'a mut L,
    address: u8,
    /// The open connection.
    connection: Option<Handle<Connect>>,
    /// The connection whose opening has no outcome yet; a cancellation may end the wait for it.
    opening: Option<Handle<Connect>>,
    abandoned: Abandoned,
    /// Whether a connection that has ended is opened again.
    reopens: bool,
}

impl<L: Ms2Line> Drop for Ms2<'_, L> {
    /// A slave keeps an abandoned connection for seconds and has few of them.
    fn drop(&mut self) {
        self.line.set_restoring(true);
        self.close().ok();
        self.line.set_restoring(false);
    }
}

impl From<RequestError> for Ms2Error {
    fn from(error: RequestError) -> Self {
        match error {
            RequestError::Refused(negative) => Self::Refused(negative),
            RequestError::Ended(end) => Self::Ended(end),
            RequestError::NotExecuted(end) => Self::NotExecuted(end),
        }
    }
}

/// Whether the request may be sent again, on another connection. A slave that has answered RS or RR to a new connection is not asked
/// again: the master has searched for one of its own there, or has repeated the request to the limit.
const fn is_unexecuted(error: &Ms2Error) -> bool {
    match error {
        Ms2Error::NotExecuted(ConnectionEnd::Failed { cause: Cause::Status(_), .. }) => false,
        Ms2Error::NotExecuted(_) => true,
        _ => false,
    }
}

/// The same for a request that does no harm if the slave executes it twice. UE to the limit: the application of the slave has failed on
/// every connection.
const fn is_read_again(error: &Ms2Error) -> bool {
    match error {
        Ms2Error::Ended(ConnectionEnd::Failed { cause: Cause::Status(Status::UserError), .. }) => false,
        Ms2Error::Ended(_) => true,
        error => is_unexecuted(error),
    }
}

/// Whether the slave did not answer.
pub(crate) const fn is_silence(error: &Ms2Error) -> bool {
    matches!(
        error,
        Ms2Error::Ended(ConnectionEnd::Failed { cause: Cause::NoAnswer(_), .. })
            | Ms2Error::NotExecuted(ConnectionEnd::Failed { cause: Cause::NoAnswer(_), .. })
    )
}

impl Ms2Error {
    /// The same error of a step before the request.
    pub(crate) fn before_request(self) -> Self {
        match self {
            Self::Session(error) => Self::NotSent(error),
            Self::Ended(end) => Self::NotExecuted(end),
            error => error,
        }
    }
}

impl<'a, L: Ms2Line> Ms2<'a, L> {
    /// A client of the slave at `address` without a connection. Sends nothing.
    pub const fn new(line: &'a mut L, address: u8) -> Self {
        Self { line, address, connection: None, opening: None, abandoned: Abandoned::NONE, reopens: true }
    }

    /// The same, which never opens a connection again: after its end, requests fail. A client that relies on the identity of the slave
    /// behind a [kept connection](BusSession::has_kept_connection) must not find another slave behind the next one.
    pub(crate) const fn without_reopening(mut self) -> Self {
        self.reopens = false;
        self
    }

    /// The line, for other requests between two records.
    pub const fn line(&mut self) -> &mut L {
        self.line
    }

    /// Reads a record. Repeats a request that was lost: reading changes nothing.
    ///
    /// # Errors
    /// [`Ms2Error`].
    pub fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, Ms2Error> {
        let wanted = u8::try_from(MAX_RECORD_LENGTH).unwrap_or(u8::MAX);
        let submit =
            |master: &mut BusMaster, connection: Handle<Connect>| master.ms2_read(connection, slot, index, wanted);
        let read = |client: &mut Self| client.request::<ms2::Read, _>(submit, |outcome| outcome.map(<[u8]>::to_vec));
        self.repeat(read, is_read_again)
    }

    /// Writes a record. Repeats a request that the slave cannot have executed, and no other.
    ///
    /// # Errors
    /// [`Ms2Error`]. After [`Ms2Error::Session`], [`Ms2Error::Ended`] and [`Ms2Error::NoAnswer`] the slave may or may not have written
    /// it, after every other error it has not.
    pub fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), Ms2Error> {
        let submit =
            |master: &mut BusMaster, connection: Handle<Connect>| master.ms2_write(connection, slot, index, octets);
        let write = |client: &mut Self| client.request::<ms2::Write, _>(submit, |outcome| outcome);
        self.repeat(write, is_unexecuted)
    }

    /// Repeats a request after errors of this kind, unless a new connection would be needed and is not wanted.
    fn repeat<T>(
        &mut self,
        request: impl Fn(&mut Self) -> Result<T, Ms2Error>,
        is_repeatable: impl Fn(&Ms2Error) -> bool,
    ) -> Result<T, Ms2Error> {
        let mut result = request(self);
        for pause in if self.reopens { &PAUSES[..] } else { &[] } {
            match &result {
                Err(error) if is_repeatable(error) && is_silence(error) => {
                    self.line.pause(*pause).map_err(Ms2Error::before_request)?;
                }
                Err(error) if is_repeatable(error) => {}
                _ => break,
            }
            result = request(self);
        }
        result
    }

    fn close(&mut self) -> Result<(), Ms2Error> {
        self.finish_opening()?;
        self.abandoned.finish(self.line)?;
        self.forget_ended_connection();
        if let Some(connection) = self.connection.take()
            && !self.line.leave_connection(self.address, connection)
        {
            self.submit(|master| master.ms2_close(connection))?;
            self.line.wait_for(connection, drop)?;
        }
        Ok(())
    }

    fn submit<T>(&mut self, request: impl FnOnce(&mut BusMaster) -> Result<T, SubmitError>) -> Result<T, Ms2Error> {
        Ok(request(self.line.master())?)
    }

    /// Sends a request on the connection. A connection that is known to have ended, that the slave has closed for lack of traffic, or on
    /// which it answers RR because nothing has fetched an earlier response, is opened again: the slave has not executed the request.
    fn request<O: Operation + 'static, T>(
        &mut self,
        submit: impl Fn(&mut BusMaster, Handle<Connect>) -> Result<Handle<O>, SubmitError>,
        take: impl Fn(O::Outcome<'_>) -> Result<T, RequestError>,
    ) -> Result<T, Ms2Error> {
        self.finish_earlier().map_err(Ms2Error::before_request)?;
        if self.connection.is_none() {
            self.connection = self.line.take_connection(self.address);
        }
        self.forget_ended_connection();
        if let Some(connection) = self.connection {
            match self.request_on(connection, &submit, &take) {
                Err(Ms2Error::NotExecuted(_)) => {}
                result => return result,
            }
        }
        if !self.reopens {
            return Err(Ms2Error::KeptConnectionEnded);
        }
        let connection = self.open().map_err(Ms2Error::before_request)?;
        self.request_on(connection, &submit, &take)
    }

    /// Waits for an opening and a request that were given up.
    fn finish_earlier(&mut self) -> Result<(), Ms2Error> {
        match self.finish_opening() {
            Ok(()) | Err(Ms2Error::Ended(_)) => self.abandoned.finish(self.line),
            Err(error) => Err(error),
        }
    }

    /// Forgets a connection that has ended since the last request, whatever its end.
    fn forget_ended_connection(&mut self) {
        let (master, Some(connection)) = (self.line.master(), self.connection) else { return };
        // A request that was given up may have taken the end of the connection with it.
        if matches!(master.outcome(connection), Some(Err(_))) || master.is_over(connection) {
            self.connection = None;
        }
    }

    fn request_on<O: Operation + 'static, T>(
        &mut self,
        connection: Handle<Connect>,
        submit: impl Fn(&mut BusMaster, Handle<Connect>) -> Result<Handle<O>, SubmitError>,
        take: impl Fn(O::Outcome<'_>) -> Result<T, RequestError>,
    ) -> Result<T, Ms2Error> {
        let handle = self.submit(|master| submit(master, connection))?;
        let outcome = self.abandoned.wait_for(self.line, handle, take)?;
        if matches!(outcome, Err(RequestError::Ended(_) | RequestError::NotExecuted(_))) {
            self.connection = None;
        }
        Ok(outcome?)
    }

    fn open(&mut self) -> Result<Handle<Connect>, Ms2Error> {
        let (parameters, address) = (Ms2Parameters::new(self.line.baud()), self.address);
        let connection = self.submit(|master| master.ms2_open(address, &parameters))?;
        self.opening = Some(connection);
        self.finish_opening()?;
        Ok(connection)
    }

    /// Waits until the connection that is being opened is open. Does nothing without one.
    fn finish_opening(&mut self) -> Result<(), Ms2Error> {
        let Some(connection) = self.opening else { return Ok(()) };
        let opened = self.line.wait_for(connection, |opened| opened)?;
        self.opening = None;
        opened.map_err(Ms2Error::Ended)?;
        self.connection = Some(connection);
        Ok(())
    }
}

impl<L: Ms2Line> Records for Ms2<'_, L> {
    fn via(&self) -> AccessPath {
        AccessPath::Class2
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        Ok(Self::read(self, slot, index)?)
    }

    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        Ok(Self::write(self, slot, index, octets)?)
    }

    fn keep_unrestored(&mut self, record: UnrestoredRecord) {
        self.line.keep_unrestored(self.address, record);
    }

    fn take_unrestored(&mut self) -> Option<UnrestoredRecord> {
        self.line.take_unrestored(self.address)
    }

    fn set_restoring(&mut self, is_restoring: bool) {
        self.line.set_restoring(is_restoring);
    }
}

impl From<Ms2Error> for RecordError {
    fn from(error: Ms2Error) -> Self {
        match error {
            Ms2Error::Session(error) => Self::Session(error),
            Ms2Error::Refused(negative) => Self::Refused(negative.into()),
            Ms2Error::NotSent(error) => Self::NotSent(error),
            Ms2Error::NotExecuted(ConnectionEnd::Failed {
                cause: Cause::Status(Status::ServiceNotActivated), ..
            }) => Unavailable::NoConnection.into(),
            Ms2Error::NotExecuted(end @ ConnectionEnd::Refused(_)) => Unavailable::ConnectionRefused(end).into(),
            Ms2Error::NotExecuted(end) => Interruption::NotExecuted(end).into(),
            Ms2Error::Ended(end) => Interruption::Ended(end).into(),
            Ms2Error::NotSubmitted(error) => Interruption::NotSubmitted(error).into(),
            Ms2Error::NoAnswer => Interruption::NoAnswer.into(),
            Ms2Error::KeptConnectionEnded => Interruption::KeptConnectionEnded.into(),
        }
    }
}
