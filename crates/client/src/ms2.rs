//! Records over MS2, as a class 2 master reads and writes them. profibus-wire 4.2 and 4.6 to 4.8.
//!
//! Nothing of this needs the slave to be parameterised, and nothing disturbs the master that owns it.

use crate::records::{RecordError, Records};
use profivac_devices::model::AccessPath;
use profivac_dp::master::{Cause, ConnectionEnd, Handle, Ms2Parameters, Outcome, SubmitError};
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
    /// What came is the response to something else.
    #[error("the answer belongs to something else")]
    UnexpectedAnswer,
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
    connection: Option<Handle>,
}

impl Drop for Ms2<'_> {
    /// Without this a slave keeps the connection for some seconds, and it has few.
    fn drop(&mut self) {
        self.close().ok();
    }
}

/// What a slave says to a request.
enum Response {
    Opened,
    Record(Vec<u8>),
    Written,
    Refused(Negative),
    Ended(ConnectionEnd),
    Other,
}

impl Response {
    fn of(outcome: Outcome<'_>) -> Self {
        match outcome {
            Outcome::Opened(_) => Self::Opened,
            Outcome::Read(record) => Self::Record(record.to_vec()),
            Outcome::Written => Self::Written,
            Outcome::Refused(negative) => Self::Refused(negative),
            Outcome::Ended(end) => Self::Ended(end),
            Outcome::Transported(_)
            | Outcome::Acknowledged
            | Outcome::Value(_)
            | Outcome::Denied(_)
            | Outcome::Failed(_) => Self::Other,
        }
    }

    /// Why it is not the answer that was hoped for.
    fn error(self) -> Ms2Error {
        match self {
            Self::Refused(negative) => Ms2Error::Refused(negative),
            Self::Ended(end) => Ms2Error::Ended(end),
            Self::Opened | Self::Record(_) | Self::Written | Self::Other => Ms2Error::UnexpectedAnswer,
        }
    }
}

/// Whether the access point was closed, so that nothing can have been done.
const fn was_closed(answer: &Response) -> bool {
    matches!(answer, Response::Ended(ConnectionEnd::Failed { cause: Cause::Status(Status::ServiceNotActivated), .. }))
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
        let mut read = || self.request(|master, connection| master.ms2_read(connection, slot, index, wanted));
        let mut answer = read()?;
        for _ in 1..ATTEMPTS {
            if !matches!(answer, Response::Ended(_)) {
                break;
            }
            answer = read()?;
        }
        match answer {
            Response::Record(record) => Ok(record),
            other => Err(other.error()),
        }
    }

    /// Writes a record, once: if no answer comes it may have been written or not.
    ///
    /// # Errors
    /// [`Ms2Error`] says how far it got.
    pub fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), Ms2Error> {
        match self.request(|master, connection| master.ms2_write(connection, slot, index, octets))? {
            Response::Written => Ok(()),
            other => Err(other.error()),
        }
    }

    /// Closes the connection, if there is one.
    fn close(&mut self) -> Result<(), Ms2Error> {
        if let Some(connection) = self.connection.take() {
            self.tool.master().ms2_close(connection)?;
            self.tool.wait_for_outcome(connection, Response::of)?;
        }
        Ok(())
    }

    /// A request on the connection. One that the slave closed meanwhile, because nobody asked for long, is opened once more.
    fn request(
        &mut self,
        hand_in: impl Fn(&mut BusMaster, Handle) -> Result<(), SubmitError>,
    ) -> Result<Response, Ms2Error> {
        if let Some(connection) = self.connection {
            let answer = self.on(connection, &hand_in)?;
            if !was_closed(&answer) {
                return Ok(answer);
            }
        }
        match self.open()? {
            Ok(connection) => self.on(connection, &hand_in),
            Err(end) => Ok(end),
        }
    }

    fn on(
        &mut self,
        connection: Handle,
        hand_in: impl Fn(&mut BusMaster, Handle) -> Result<(), SubmitError>,
    ) -> Result<Response, Ms2Error> {
        // What came since the last request: the end of the connection, or what nobody waited for any more.
        let answer = match self.tool.master().outcome(connection).map(Response::of) {
            Some(ended @ Response::Ended(_)) => ended,
            Some(_) | None => {
                hand_in(self.tool.master(), connection)?;
                self.tool.wait_for_outcome(connection, Response::of)?
            }
        };
        if matches!(answer, Response::Ended(_)) {
            self.connection = None;
        }
        Ok(answer)
    }

    /// Opens a connection, or says why there is none.
    fn open(&mut self) -> Result<Result<Handle, Response>, Ms2Error> {
        let parameters = Ms2Parameters::new(self.tool.baud());
        let connection = self.tool.master().ms2_open(self.address, &parameters)?;
        Ok(match self.tool.wait_for_outcome(connection, Response::of)? {
            Response::Opened => {
                self.connection = Some(connection);
                Ok(connection)
            }
            other => Err(other),
        })
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
            Ms2Error::Ended(_) | Ms2Error::NotSubmitted(_) | Ms2Error::UnexpectedAnswer => {
                Self::Interrupted(error.to_string())
            }
        }
    }
}
