//! Records over MS2, as a class 2 master reads and writes them. profibus-wire 4.2 and 4.6 to 4.8.
//!
//! Nothing of this needs the slave to be parameterised, and nothing disturbs the master that owns it.

use crate::records::{RecordError, Records};
use profivac_devices::model::AccessPath;
use profivac_dp::master::ms2::{self, Connect, RequestError};
use profivac_dp::master::{Cause, ConnectionEnd, Handle, Ms2Parameters, Operation, SubmitError};
use profivac_host::session::{BusMaster, BusSession, SessionError};
use profivac_wire::acyclic::Negative;
use profivac_wire::acyclic::record::MAX_RECORD_LENGTH;
use profivac_wire::control::Status;

/// How often a record is asked for when telegrams were lost on the way.
const ATTEMPTS: usize = 3;

/// Why there is no record.
#[derive(Debug, thiserror::Error)]
pub enum Ms2Error {
    /// Nothing could be asked.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// It is no DP-V1 slave, or has no such record.
    #[error("it has no such record for class 2 masters")]
    Unsupported,
    /// The connection is gone.
    #[error("{0}")]
    Ended(ConnectionEnd),
    /// The slave refused.
    #[error("refused with {code_1}", code_1 = .0.code_1)]
    Refused(Negative),
    /// The master cannot ask so.
    #[error("{0}")]
    NotSubmitted(#[from] SubmitError),
}

/// Reads the record at `slot` and `index` of the slave at `address`, with a connection of its own.
///
/// # Errors
/// [`Ms2Error`] says how far it got.
pub fn read(tool: &mut BusSession, address: u8, slot: u8, index: u8) -> Result<Vec<u8>, Ms2Error> {
    Ms2::new(tool, address).read(slot, index)
}

/// A connection to a slave. It is opened when it is needed, also again when the slave has closed it, and closed when it is
/// dropped.
pub struct Ms2<'a> {
    tool: &'a mut BusSession,
    address: u8,
    connection: Option<Handle<Connect>>,
}

impl Drop for Ms2<'_> {
    /// Without this a slave keeps the connection for some seconds, and it has few.
    fn drop(&mut self) {
        self.close().ok();
    }
}

impl From<RequestError> for Ms2Error {
    fn from(error: RequestError) -> Self {
        match error {
            RequestError::Refused(negative) => Self::Refused(negative),
            RequestError::Ended(end) => Self::Ended(end),
        }
    }
}

/// Whether the access point was closed, so that the slave cannot have executed the request.
const fn was_closed(end: &ConnectionEnd) -> bool {
    matches!(end, ConnectionEnd::Failed { cause: Cause::Status(Status::ServiceNotActivated), .. })
}

impl<'a> Ms2<'a> {
    /// The master that asks, for what has to be done between two records.
    pub const fn session(&mut self) -> &mut BusSession {
        self.tool
    }

    /// No connection yet.
    pub const fn new(tool: &'a mut BusSession, address: u8) -> Self {
        Self { tool, address, connection: None }
    }

    /// Reads a record. What was lost on the way is asked for again: reading changes nothing.
    ///
    /// # Errors
    /// [`Ms2Error`] says how far it got.
    pub fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, Ms2Error> {
        let wanted = u8::try_from(MAX_RECORD_LENGTH).unwrap_or(u8::MAX);
        let submit =
            |master: &mut BusMaster, connection: Handle<Connect>| master.ms2_read(connection, slot, index, wanted);
        let mut read = || self.request::<ms2::Read, _>(submit, |outcome| outcome.map(<[u8]>::to_vec));
        let mut record = read();
        for _ in 1..ATTEMPTS {
            if !matches!(record, Err(Ms2Error::Ended(_))) {
                break;
            }
            record = read();
        }
        record
    }

    /// Writes a record, once: if no answer comes it may have been written or not.
    ///
    /// # Errors
    /// [`Ms2Error`] says how far it got.
    pub fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), Ms2Error> {
        let submit =
            |master: &mut BusMaster, connection: Handle<Connect>| master.ms2_write(connection, slot, index, octets);
        self.request::<ms2::Write, _>(submit, |outcome| outcome)
    }

    /// Closes the connection, if there is one.
    fn close(&mut self) -> Result<(), Ms2Error> {
        if let Some(connection) = self.connection.take() {
            self.tool.master().ms2_close(connection)?;
            self.tool.wait_for_outcome(connection, drop)?;
        }
        Ok(())
    }

    /// A request on the connection. If the slave has closed the connection meanwhile, because it was idle for too long, it is
    /// opened once more.
    fn request<O: Operation, T>(
        &mut self,
        submit: impl Fn(&mut BusMaster, Handle<Connect>) -> Result<Handle<O>, SubmitError>,
        take: impl Fn(O::Outcome<'_>) -> Result<T, RequestError>,
    ) -> Result<T, Ms2Error> {
        if let Some(connection) = self.connection {
            match self.request_on(connection, &submit, &take) {
                Err(Ms2Error::Ended(end)) if was_closed(&end) => {}
                result => return result,
            }
        }
        let connection = self.open()?;
        self.request_on(connection, &submit, &take)
    }

    fn request_on<O: Operation, T>(
        &mut self,
        connection: Handle<Connect>,
        submit: impl Fn(&mut BusMaster, Handle<Connect>) -> Result<Handle<O>, SubmitError>,
        take: impl Fn(O::Outcome<'_>) -> Result<T, RequestError>,
    ) -> Result<T, Ms2Error> {
        // The connection may have ended since the last request.
        if let Some(Err(end)) = self.tool.master().outcome(connection) {
            self.connection = None;
            return Err(Ms2Error::Ended(end));
        }
        let handle = submit(self.tool.master(), connection)?;
        let outcome = self.tool.wait_for_outcome(handle, take)?;
        if matches!(outcome, Err(RequestError::Ended(_))) {
            self.connection = None;
        }
        Ok(outcome?)
    }

    /// Opens a connection.
    fn open(&mut self) -> Result<Handle<Connect>, Ms2Error> {
        let parameters = Ms2Parameters::new(self.tool.baud());
        let connection = self.tool.master().ms2_open(self.address, &parameters)?;
        self.tool.wait_for_outcome(connection, |opened| opened)?.map_err(Ms2Error::Ended)?;
        self.connection = Some(connection);
        Ok(connection)
    }
}

impl Records for Ms2<'_> {
    fn via(&self) -> AccessPath {
        AccessPath::Class2
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        Ok(Self::read(self, slot, index)?)
    }

    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        Ok(Self::write(self, slot, index, octets)?)
    }
}

impl From<Ms2Error> for RecordError {
    fn from(error: Ms2Error) -> Self {
        match error {
            Ms2Error::Session(error) => Self::Session(error),
            Ms2Error::Refused(negative) => Self::Refused(negative.into()),
            Ms2Error::Ended(ConnectionEnd::Failed { cause: Cause::Status(Status::ServiceNotActivated), .. }) => {
                Self::Unavailable(
                    "it has no MS2 connection, or none left: other class 2 masters may hold them".to_owned(),
                )
            }
            Ms2Error::Unsupported | Ms2Error::Ended(ConnectionEnd::Refused(_)) => Self::Unavailable(error.to_string()),
            Ms2Error::Ended(_) | Ms2Error::NotSubmitted(_) => Self::Interrupted(error.to_string()),
        }
    }
}
