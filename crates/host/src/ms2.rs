//! Records over MS2, as a class 2 master reads and writes them: open a connection, ask, close it. profibus-wire 4.2 and 4.6 to 4.8.
//!
//! Nothing of this needs the slave to be parameterised, and nothing disturbs the master that owns it.

use crate::client::records::{RecordError, Records};
use crate::tool::{Reply, Tool, ToolError};
use profivac_devices::model::Via;
use profivac_dp::link::active::{Failure, Request};
use profivac_wire::acyclic::initiate::{AddAddr, Capabilities};
use profivac_wire::acyclic::{self, Abort, AbortReason, Access, Defect, Initiate, Negative, Response, Transfer};
use profivac_wire::control::{Function, Status};
use profivac_wire::sap::MASTER_MS2;
use profivac_wire::{MAX_DU, Sap};

/// The longest record.
const MAX_RECORD: u8 = 240;

/// Send_Timeout in 10 ms: longer than the 4 s that slaves ask for at the slow rates.
const SEND_TIMEOUT: u16 = 500;

/// How often a record is asked for when telegrams were lost on the way.
const ATTEMPTS: usize = 3;

/// How often a response is polled for. At one poll in a few milliseconds longer than Send_Timeout.
const POLLS: usize = 2000;

/// Why there is no record.
#[derive(Debug, thiserror::Error)]
pub enum Ms2Error {
    /// Nothing could be asked.
    #[error(transparent)]
    Tool(#[from] ToolError),
    /// It is no DP-V1 slave, or has no such record.
    #[error("it has no such record for class 2 masters")]
    Unsupported,
    /// The slave did not answer.
    #[error("{0}")]
    Lost(Failure),
    /// The service access point answers like this: RS is a slave without MS2, or without a connection left.
    #[error("no MS2 connection: it answers {0:?}")]
    Closed(Status),
    /// The slave closed the connection.
    #[error("the MS2 connection was aborted: {0}")]
    Aborted(AbortReason),
    /// The slave refused.
    #[error("refused with {code_1}", code_1 = .0.code_1)]
    Refused(Negative),
    /// What came is no response.
    #[error("{0}")]
    Malformed(Defect),
    /// What came is the response to something else.
    #[error("the answer belongs to something else")]
    Other,
    /// No response came.
    #[error("no response in time")]
    Slow,
}

/// Reads the record at `slot` and `index` of the slave at `address`, with a connection of its own.
///
/// # Errors
/// [`Ms2Error`] says how far it got.
pub fn read(tool: &mut Tool, address: u8, slot: u8, index: u8) -> Result<Vec<u8>, Ms2Error> {
    let mut line = Ms2::new(tool, address);
    let record = line.read(slot, index);
    line.close();
    record
}

/// A connection to a slave. It is opened when it is needed, also again when the slave has closed it, and closed when it is
/// dropped.
pub struct Ms2<'a> {
    tool: &'a mut Tool,
    address: u8,
    sap: Option<u8>,
}

impl Drop for Ms2<'_> {
    fn drop(&mut self) {
        self.close();
    }
}

impl<'a> Ms2<'a> {
    /// No connection yet.
    pub const fn new(tool: &'a mut Tool, address: u8) -> Self {
        Self { tool, address, sap: None }
    }

    /// The master on the line.
    pub const fn tool(&mut self) -> &mut Tool {
        self.tool
    }

    /// Reads a record. What was lost on the way is asked for again: reading changes nothing.
    ///
    /// # Errors
    /// [`Ms2Error`] says how far it got.
    pub fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, Ms2Error> {
        let request = acyclic::Request::Read(Access { slot, index, length: MAX_RECORD });
        let mut answer = self.request(&request);
        for _ in 1..ATTEMPTS {
            if !matches!(answer, Err(Ms2Error::Lost(_) | Ms2Error::Aborted(_))) {
                break;
            }
            answer = self.request(&request);
        }
        match parse(&answer?)? {
            Response::Read(record) if (record.slot, record.index) == (slot, index) => Ok(record.data.to_vec()),
            _ => Err(Ms2Error::Other),
        }
    }

    /// Writes a record, once: if no answer comes it may have been written or not.
    ///
    /// # Errors
    /// [`Ms2Error`] says how far it got.
    pub fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), Ms2Error> {
        let request = acyclic::Request::Write(Transfer { slot, index, data: octets });
        let answer = self.request(&request)?;
        match parse(&answer)? {
            Response::Write(written) if (written.slot, written.index) == (slot, index) => Ok(()),
            _ => Err(Ms2Error::Other),
        }
    }

    /// Closes the connection, if there is one.
    pub fn close(&mut self) {
        if let Some(sap) = self.sap.take() {
            // A slave that does not hear it closes by itself after a while.
            self.send(sap, &acyclic::Request::Abort(Abort::new(AbortReason::User(0)))).ok();
        }
    }

    /// A request on the connection. One that the slave closed meanwhile, because nobody asked for long, is opened once more.
    fn request(&mut self, request: &acyclic::Request<'_>) -> Result<Vec<u8>, Ms2Error> {
        let (sap, is_old) = match self.sap {
            Some(sap) => (sap, true),
            None => (self.open()?, false),
        };
        self.sap = Some(sap);
        let mut answer = self.call(sap, request);
        // RS: the access point is closed, nothing was done.
        if is_old && matches!(answer, Err(Ms2Error::Closed(_))) {
            let sap = self.open()?;
            self.sap = Some(sap);
            answer = self.call(sap, request);
        }
        let is_over = match &answer {
            Ok(answer) => matches!(Response::parse(answer), Ok(Response::Abort(_)) | Err(_)),
            Err(_) => true,
        };
        if is_over {
            self.sap = None;
        }
        answer
    }

    /// Opens a connection and returns its access point.
    fn open(&mut self) -> Result<u8, Ms2Error> {
        let end = AddAddr::default();
        let initiate = Initiate {
            send_timeout: SEND_TIMEOUT,
            capabilities: Capabilities::READ_WRITE,
            source: end,
            destination: end,
        };
        let manager = Sap::ResourceManager.to_octet().unwrap_or_default();
        let answer = self.call(manager, &acyclic::Request::Initiate(initiate))?;
        let Response::ResourceManager(manager) = parse(&answer)? else { return Err(Ms2Error::Other) };
        let answer = self.poll(manager.server_sap)?;
        match parse(&answer)? {
            Response::Initiate(_) => Ok(manager.server_sap),
            _ => Err(Ms2Error::Other),
        }
    }

    /// A request and its response, which may come at once or on a later poll.
    fn call(&mut self, sap: u8, request: &acyclic::Request<'_>) -> Result<Vec<u8>, Ms2Error> {
        match self.send(sap, request)? {
            Some(response) => Ok(response),
            None => self.poll(sap),
        }
    }

    fn send(&mut self, sap: u8, request: &acyclic::Request<'_>) -> Result<Option<Vec<u8>>, Ms2Error> {
        let mut du = [0; MAX_DU];
        let length = request.emit(&mut du).unwrap_or_default();
        self.ask(sap, du.get(..length).unwrap_or_default())
    }

    fn poll(&mut self, sap: u8) -> Result<Vec<u8>, Ms2Error> {
        for _ in 0..POLLS {
            if let Some(response) = self.ask(sap, &[])? {
                return Ok(response);
            }
        }
        Err(Ms2Error::Slow)
    }

    /// One message. The data unit of the answer, if it has one.
    fn ask(&mut self, sap: u8, du: &[u8]) -> Result<Option<Vec<u8>>, Ms2Error> {
        let request =
            Request { da: self.address, function: Function::SrdLow, dsap: Some(sap), ssap: Some(MASTER_MS2), du };
        match self.tool.ask(&request)? {
            Reply::Answer { status: Status::NoReply, .. } => Ok(None),
            Reply::Answer { status: Status::DataLow | Status::DataHigh, du, .. } => Ok(Some(du)),
            Reply::Answer { status, .. } => Err(Ms2Error::Closed(status)),
            Reply::Nothing(failure) => Err(Ms2Error::Lost(failure)),
        }
    }
}

fn parse(pdu: &[u8]) -> Result<Response<'_>, Ms2Error> {
    match Response::parse(pdu).map_err(Ms2Error::Malformed)? {
        Response::Abort(abort) => Err(Ms2Error::Aborted(abort.reason)),
        Response::Negative(negative) => Err(Ms2Error::Refused(negative)),
        response => Ok(response),
    }
}

impl Records for Ms2<'_> {
    fn via(&self) -> Via {
        Via::Class2
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        Ok(Self::read(self, slot, index)?)
    }

    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        Ok(Self::write(self, slot, index, octets)?)
    }
}
