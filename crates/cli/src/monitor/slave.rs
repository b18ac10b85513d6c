//! The slaves that are monitored: gauges, and slaves of which only the octets are known.

use super::row::{Row, RowState};
use crate::bus;
use crate::failure::Failure;
use profivac_client::ClientError;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::discover::CyclicError;
use profivac_client::identify::device_names;
use profivac_client::values::hex;
use profivac_dp::master::{SlaveParameters, services};
use profivac_host::scan::probe;
use profivac_host::session::{BusSession, Reply, SessionError, add_or_restart};
use profivac_wire::control::Status;
use std::fmt;

/// A slave that is monitored.
pub enum MonitoredSlave {
    /// A gauge with pressures.
    Gauge(CyclicSlave),
    /// A slave whose ident number no known device has. Its inputs are shown as octets.
    Unknown(UnknownSlave),
}

/// A slave whose ident number no known device has.
pub struct UnknownSlave {
    /// The address.
    pub address: u8,
    /// Ident_Number.
    pub ident: u16,
    access: Access,
}

/// How the inputs of an unknown slave are read.
enum Access {
    /// With RD_Inp, while another master owns the slave.
    Read { owner: u8, state: ReadState },
    /// By data exchange: this master owns the slave.
    Exchange { cfg: Vec<u8>, user_prm: Vec<u8> },
}

/// What RD_Inp has returned so far.
#[derive(Default)]
struct ReadState {
    inputs: Vec<u8>,
    reads: u32,
    lost: u32,
    /// Why the last one returned no inputs.
    error: Option<ReadError>,
}

/// Why RD_Inp returned no inputs.
#[derive(Debug, thiserror::Error)]
enum ReadError {
    #[error("no answer")]
    NoAnswer,
    #[error("RD_Inp is closed: the slave is not in data exchange")]
    Closed,
    #[error("expected inputs as the answer to RD_Inp, got the status {0:?}")]
    Refused(Status),
    #[error(transparent)]
    Session(SessionError),
}

impl MonitoredSlave {
    /// Finds the slave at `address` on behalf of `master`. Changes nothing. `user_prm` are the user parameters of an unknown
    /// slave.
    pub fn find(session: &mut BusSession, address: u8, master: u8, user_prm: &[u8]) -> Result<Self, Failure> {
        match CyclicSlave::find(session, address, master) {
            Ok(gauge) => Ok(Self::Gauge(gauge)),
            Err(CyclicError::Client(ClientError::UnknownDevice { ident, .. })) => {
                let cfg = bus::present_cfg(session, address)?;
                let cfg = cfg.ok_or_else(|| Failure::refused(without_configuration(address, ident)))?;
                let access = Access::Exchange { cfg, user_prm: user_prm.to_vec() };
                Ok(Self::Unknown(UnknownSlave { address, ident, access }))
            }
            Err(error @ CyclicError::OwnedByOther { master: owner, .. }) => {
                Self::owned(session, address, owner)?.ok_or_else(|| error.into())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// An unknown slave of another master, if RD_Inp returns its inputs.
    fn owned(session: &mut BusSession, address: u8, owner: u8) -> Result<Option<Self>, Failure> {
        let status = probe(session, address)?.and_then(|station| station.slave);
        let Some(status) = status.filter(|status| device_names(status.ident).is_empty()) else { return Ok(None) };
        let mut state = ReadState::default();
        state.read(session, address);
        let access = Access::Read { owner, state };
        let slave = UnknownSlave { address, ident: status.ident, access };
        Ok(slave.has_been_read().then_some(Self::Unknown(slave)))
    }

    /// The address.
    pub const fn address(&self) -> u8 {
        match self {
            Self::Gauge(gauge) => gauge.address,
            Self::Unknown(slave) => slave.address,
        }
    }

    /// Whether this master exchanges data with the slave and owns it.
    pub const fn is_owned(&self) -> bool {
        match self {
            Self::Gauge(_) | Self::Unknown(UnknownSlave { access: Access::Exchange { .. }, .. }) => true,
            Self::Unknown(UnknownSlave { access: Access::Read { .. }, .. }) => false,
        }
    }

    /// Begins data exchange with a slave that this master owns.
    pub fn take(&self, session: &mut BusSession) -> Result<(), Failure> {
        let parameters = match self {
            Self::Gauge(gauge) => gauge.parameters(session.baud()),
            Self::Unknown(UnknownSlave { address, ident, access: Access::Exchange { cfg, user_prm } }) => {
                SlaveParameters { user_prm, ..SlaveParameters::new(*address, *ident, cfg) }
            }
            Self::Unknown(UnknownSlave { access: Access::Read { .. }, .. }) => return Ok(()),
        };
        add_or_restart(session.master(), &parameters).map_err(|error| Failure::usage(error.to_string()))
    }

    /// Reads the inputs of a slave that another master owns.
    pub fn read(&mut self, session: &mut BusSession) {
        if let Self::Unknown(UnknownSlave { address, access: Access::Read { state, .. }, .. }) = self {
            state.read(session, *address);
        }
    }

    /// Its rows, at least one.
    pub fn rows(&self, segment: Option<&str>, session: &mut BusSession, unix_time: f64) -> Vec<Row> {
        match self {
            Self::Gauge(gauge) => Row::of(segment, gauge, session.master(), unix_time),
            Self::Unknown(slave) => vec![slave.row(segment, session, unix_time)],
        }
    }

    /// What the user must know to give the slave what it needs.
    pub const fn advice(&self) -> &'static str {
        match self {
            Self::Gauge(_) => "",
            Self::Unknown(_) => "; give the user parameters of its GSD file with --prm HEX",
        }
    }
}

impl UnknownSlave {
    fn has_been_read(&self) -> bool {
        matches!(&self.access, Access::Read { state, .. } if state.reads > 0)
    }

    fn row(&self, segment: Option<&str>, session: &mut BusSession, unix_time: f64) -> Row {
        let device = format!("0x{:04X}", self.ident);
        let row = Row::empty(segment, self.address, device, unix_time);
        match &self.access {
            Access::Read { state, .. } => Row {
                state: if state.error.is_none() { RowState::Read } else { RowState::Offline },
                inputs: state.error.is_none().then(|| hex(&state.inputs)),
                remarks: state.error.iter().map(ToString::to_string).collect(),
                exchanges: state.reads,
                lost: state.lost,
                ..row
            },
            Access::Exchange { .. } => {
                let master = session.master();
                row.with_master(master).with_inputs(master.inputs(self.address).map(hex))
            }
        }
    }
}

impl ReadState {
    fn read(&mut self, session: &mut BusSession, address: u8) {
        let error = match session.request(&services::rd_inp(address)) {
            Ok(Reply::Answer { status: Status::DataLow | Status::DataHigh, du, .. }) => {
                self.inputs = du;
                None
            }
            // A slave without inputs.
            Ok(Reply::Answer { status: Status::NoReply, .. }) => {
                self.inputs = Vec::new();
                None
            }
            Ok(Reply::Answer { status: Status::ServiceNotActivated, .. }) => Some(ReadError::Closed),
            Ok(Reply::Answer { status, .. }) => Some(ReadError::Refused(status)),
            Ok(Reply::NoAnswer(_)) => Some(ReadError::NoAnswer),
            Err(error) => Some(ReadError::Session(error)),
        };
        let count = if error.is_none() { &mut self.reads } else { &mut self.lost };
        *count = count.saturating_add(1);
        self.error = error;
    }
}

/// What `monitor` does with an unknown slave.
impl fmt::Display for UnknownSlave {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { address, ident, access } = self;
        write!(f, "the slave at address {address} has the ident number 0x{ident:04X}, which no known device has; ")?;
        match access {
            Access::Read { owner, .. } => write!(
                f,
                "master {owner} owns it, and its inputs are read with RD_Inp and shown as octets, without ownership"
            ),
            Access::Exchange { cfg, user_prm } => {
                let prm = if user_prm.is_empty() { "no user parameters".to_owned() } else { hex(user_prm) };
                write!(
                    f,
                    "its inputs are shown as octets, with its configuration {}, {prm} and outputs of zero",
                    hex(cfg)
                )
            }
        }
    }
}

fn without_configuration(address: u8, ident: u16) -> String {
    format!(
        "the slave at address {address} has the ident number 0x{ident:04X}, which no known device has, and does not answer \
         Get_Cfg; without its configuration its inputs cannot be shown"
    )
}
