//! The slaves that are monitored: gauges, and slaves of which only the octets are known.

use super::gsd::outputs_of_unknown;
use super::plan::{OwnedByGsd, Plan};
use super::row::{ModuleInputs, Row, RowState};
use crate::bus;
use crate::device_files::known;
use crate::failure::Failure;
use crate::output::visible;
use profivac_client::ClientError;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::discover::CyclicError;
use profivac_client::values::hex;
use profivac_dp::master::{SlaveParameters, services};
use profivac_explain::dpv1::DeviceBlocks;
use profivac_explain::gsd::Described;
use profivac_explain::slave::diagnosis_reports;
use profivac_gsd_slave::PlacedModule;
use profivac_host::scan::probe;
use profivac_host::session::{BusSession, Reply, SessionError, add_or_restart};
use profivac_wire::control::Status;
use profivac_wire::diag::SlaveDiag;
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
    /// The slave in the words of its GSD file, if there is one.
    described: Described,
}

/// How the inputs of an unknown slave are read.
enum Access {
    /// With RD_Inp, while another master owns the slave.
    Read { owner: u8, state: ReadState },
    /// By data exchange: this master owns the slave.
    Exchange { cfg: Vec<u8>, user_prm: Vec<u8>, outputs: Vec<u8> },
    /// By data exchange, with modules and parameters of its GSD file.
    ByGsd(Box<OwnedByGsd>),
}

/// What RD_Inp has returned so far.
#[derive(Default)]
struct ReadState {
    inputs: Vec<u8>,
    reads: u32,
    lost: u32,
    /// Why the last one returned no inputs.
    error: Option<ReadError>,
    /// The last answer to Slave_Diag.
    diagnosis: Vec<u8>,
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
    /// Finds the slave at `address`. Changes nothing.
    pub fn find(session: &mut BusSession, address: u8, plan: &Plan) -> Result<Self, Failure> {
        if let Some(owned) = plan.by_gsd.get(&address) {
            return Ok(Self::Unknown(UnknownSlave {
                address,
                ident: owned.slave.ident(),
                access: Access::ByGsd(owned.clone().into()),
                // A search by these octets could find other modules, or another file.
                described: Described::chosen(owned.slave.file(), &owned.slave.configuration()),
            }));
        }
        match CyclicSlave::find_among(known(), session, address, plan.bus.master()) {
            Ok(gauge) if plan.outputs.contains_key(&address) => Err(Failure::usage(format!(
                "the slave at address {address} is a {}, and monitor sends zeros to a known gauge: leave out --outputs for this address",
                gauge.model.name
            ))),
            Ok(gauge) => Ok(Self::Gauge(gauge)),
            Err(CyclicError::Client(ClientError::UnknownDevice { ident, .. })) => {
                let cfg = bus::present_cfg(session, address)?;
                let cfg = cfg.ok_or_else(|| Failure::refused(without_configuration(address, ident)))?;
                let described = described(plan, ident, &cfg);
                if described.is_known() || plan.chosen.contains(&address) {
                    return Err(Failure::refused(became_free(address)));
                }
                let outputs = outputs_of_unknown(plan, address, &cfg)?;
                let access = Access::Exchange { cfg, user_prm: plan.user_prm.clone(), outputs };
                Ok(Self::Unknown(UnknownSlave { address, ident, access, described }))
            }
            Err(error @ CyclicError::OwnedByOther { master: owner, .. }) => {
                Self::owned(session, address, owner, plan)?.ok_or_else(|| error.into())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// An unknown slave of another master, if RD_Inp returns its inputs.
    fn owned(session: &mut BusSession, address: u8, owner: u8, plan: &Plan) -> Result<Option<Self>, Failure> {
        let status = probe(session, address)?.and_then(|station| station.slave);
        let Some(status) = status.filter(|status| !known().knows(status.ident)) else { return Ok(None) };
        let mut state = ReadState::default();
        state.read(session, address);
        let cfg = bus::present_cfg(session, address)?.unwrap_or_default();
        let described = described(plan, status.ident, &cfg);
        let slave = UnknownSlave { address, ident: status.ident, access: Access::Read { owner, state }, described };
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
            Self::Unknown(UnknownSlave { access: Access::Read { .. }, .. }) => false,
            Self::Gauge(_) | Self::Unknown(_) => true,
        }
    }

    /// Begins data exchange with a slave that this master owns.
    pub fn take(&self, session: &mut BusSession) -> Result<(), Failure> {
        let parameters = match self {
            Self::Gauge(gauge) => gauge.parameters(session.baud()),
            Self::Unknown(UnknownSlave { address, ident, access, .. }) => match access {
                Access::Exchange { cfg, user_prm, .. } => {
                    SlaveParameters { user_prm, ..SlaveParameters::new(*address, *ident, cfg) }
                }
                Access::ByGsd(owned) => owned.slave.parameters(*address, session.baud()),
                Access::Read { .. } => return Ok(()),
            },
        };
        let master = session.master();
        add_or_restart(master, &parameters).map_err(|error| Failure::usage(error.to_string()))?;
        let room = master.outputs_mut(self.address()).unwrap_or_default();
        room.iter_mut().zip(self.outputs()).for_each(|(room, output)| *room = *output);
        Ok(())
    }

    /// The outputs that the command line gives; empty for a gauge, which gets zeros.
    fn outputs(&self) -> &[u8] {
        match self {
            Self::Unknown(UnknownSlave { access: Access::ByGsd(owned), .. }) => &owned.outputs,
            Self::Unknown(UnknownSlave { access: Access::Exchange { outputs, .. }, .. }) => outputs,
            Self::Gauge(_) | Self::Unknown(_) => &[],
        }
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
            Self::Unknown(UnknownSlave { access: Access::ByGsd(_), .. }) => {
                "; compare the parameters with --set, and the GSD file with the revision of the slave"
            }
            Self::Unknown(_) => "; give the user parameters of its GSD file with --prm HEX",
        }
    }
}

impl UnknownSlave {
    fn has_been_read(&self) -> bool {
        matches!(&self.access, Access::Read { state, .. } if state.reads > 0)
    }

    fn row(&self, segment: Option<&str>, session: &mut BusSession, unix_time: f64) -> Row {
        let models = self.described.models().join(" or ");
        let device = if models.is_empty() { format!("0x{:04X}", self.ident) } else { visible(&models) };
        let row = Row::empty(segment, self.address, device, unix_time);
        match &self.access {
            Access::Read { state, .. } => {
                let inputs = state.error.is_none().then_some(state.inputs.as_slice());
                let mut remarks: Vec<_> = state.error.iter().map(ToString::to_string).collect();
                if let Ok(diag) = SlaveDiag::parse(&state.diagnosis) {
                    remarks.extend(self.reports(&diag));
                }
                Row {
                    state: if state.error.is_none() { RowState::Read } else { RowState::Offline },
                    remarks,
                    exchanges: state.reads,
                    lost: state.lost,
                    ..row.with_inputs(inputs.map(hex))
                }
                .with_modules(inputs.map(|inputs| self.modules(inputs)))
            }
            Access::Exchange { .. } | Access::ByGsd(_) => {
                let master = session.master();
                let mut row = row.with_master(master);
                if let Some(diag) = master.diagnosis(self.address) {
                    row.remarks.extend(self.reports(&diag));
                }
                let inputs = master.inputs(self.address);
                row.with_inputs(inputs.map(hex)).with_modules(inputs.map(|inputs| self.modules(inputs)))
            }
        }
    }

    /// A diagnosis in the words of the GSD file; empty without one.
    fn reports(&self, diag: &SlaveDiag<'_>) -> Vec<String> {
        let blocks = match self.described.dpv1_slave() {
            Some(true) => DeviceBlocks::Messages,
            Some(false) => DeviceBlocks::Vendor,
            None => return Vec::new(),
        };
        diagnosis_reports(diag, blocks, &self.described).iter().map(|report| visible(report)).collect()
    }

    /// The inputs of each module; empty if they are not known.
    fn modules(&self, inputs: &[u8]) -> Vec<ModuleInputs> {
        let module = |slot: u32, module: String, octets: &[u8]| ModuleInputs {
            slot,
            module: visible(&module),
            inputs: hex(octets),
        };
        if let Access::ByGsd(owned) = &self.access {
            let all = owned.slave.layout().inputs();
            return all
                .filter_map(|data| Some(module(data.module.slot, data.module.name.clone(), data.of(inputs)?)))
                .collect();
        }
        let slots = self.described.slots().iter().filter(|slot| !slot.inputs.is_empty());
        slots.filter_map(|slot| Some(module(slot.slot, slot.names(), inputs.get(slot.inputs.clone())?))).collect()
    }
}

/// The slave belonged to another master, or was silent, when its GSD file was looked for, and is free now. It must not get parameters that are
/// not those of its file.
fn became_free(address: u8) -> String {
    format!(
        "the slave at address {address} belonged to another master or was silent when the command looked for its GSD file, and is free now; it got no \
         parameters; if no other master needs it, run the command again"
    )
}

/// A slave in the words of the GSD files.
fn described(plan: &Plan, ident: u16, cfg: &[u8]) -> Described {
    let mut described = Described::new(plan.files.clone());
    described.identify(ident);
    described.configure(cfg);
    described
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
        self.diagnosis = match session.request(&services::slave_diag(address)) {
            Ok(Reply::Answer { du, .. }) => du,
            // A former diagnosis may have ended.
            Ok(Reply::NoAnswer(_)) | Err(_) => Vec::new(),
        };
        let count = if error.is_none() { &mut self.reads } else { &mut self.lost };
        *count = count.saturating_add(1);
        self.error = error;
    }
}

/// What `monitor` does with an unknown slave.
impl fmt::Display for UnknownSlave {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { address, ident, access, described } = self;
        let name = described.names().join(" or ");
        let name = if name.is_empty() { "which no known device has".to_owned() } else { visible(&name) };
        write!(f, "the slave at address {address} has the ident number 0x{ident:04X}, {name}; ")?;
        match access {
            Access::Read { owner, .. } => write!(
                f,
                "master {owner} owns it, and its inputs are read with RD_Inp and shown as octets, without ownership"
            ),
            Access::Exchange { cfg, user_prm, outputs } => {
                let prm = if user_prm.is_empty() { "no user parameters".to_owned() } else { hex(user_prm) };
                write!(
                    f,
                    "its inputs are shown as octets, with its configuration {}, {prm} and {}",
                    hex(cfg),
                    if outputs.is_empty() { "no outputs".to_owned() } else { format!("the outputs {}", hex(outputs)) }
                )
            }
            Access::ByGsd(owned) => {
                let modules: Vec<_> = owned.slave.layout().modules.iter().map(PlacedModule::label).collect();
                let or_none = |octets: &[u8]| if octets.is_empty() { "none".to_owned() } else { hex(octets) };
                write!(
                    f,
                    "it gets {} with the configuration {}, the user parameters {} and the outputs {}",
                    visible(&modules.join(", ")),
                    hex(owned.slave.chk_cfg()),
                    or_none(owned.slave.user_prm()),
                    or_none(&owned.outputs)
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test")]

    use super::*;
    use crate::bus::{BusOptions, MasterOptions};
    use profivac_dp::link::Baud;
    use profivac_explain::gsd::Files;
    use profivac_gsd::GsdFile;
    use std::fs;
    use std::path::Path;
    use std::sync::Arc;

    #[test]
    fn a_slave_that_is_silent_has_no_diagnosis_of_its_former_answer() {
        let folder = tempfile::tempdir().unwrap();
        let gsd = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/support/gsd/pressure.gsd"));
        fs::copy(gsd, folder.path().join("pressure.gsd")).unwrap();
        let file = folder.path().join("bus.toml");
        fs::write(&file, "devices = [\"pressure.gsd@9\"]\n").unwrap();
        let line = MasterOptions::new(Baud::B19200, 0, 126);
        let mut session = BusOptions::new(&format!("sim:{}", file.display()), &line).open().unwrap();
        let mut state = ReadState::default();
        state.read(&mut session, 9);
        assert!(!state.diagnosis.is_empty());
        // Nobody is there.
        state.read(&mut session, 10);
        assert!(matches!(state.error, Some(ReadError::NoAnswer)));
        assert_eq!(state.diagnosis, [0; 0]);
    }

    /// A slave that had a master when its GSD file was read, and has none now.
    #[test]
    fn a_released_slave_of_a_gsd_file_does_not_get_other_parameters() {
        let folder = tempfile::tempdir().unwrap();
        let gsd = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/support/gsd/pressure.gsd"));
        fs::copy(gsd, folder.path().join("pressure.gsd")).unwrap();
        let file = folder.path().join("bus.toml");
        fs::write(&file, "devices = [\"pressure.gsd@9\"]\n").unwrap();
        let line = MasterOptions::new(Baud::B19200, 0, 126);
        let find = |files: Files, chosen: Vec<u8>| {
            let bus = BusOptions::new(&format!("sim:{}", file.display()), &line);
            let plan = Plan { chosen, files, ..Plan::new(None, bus, vec![9]) };
            let mut session = plan.bus.open().unwrap();
            MonitoredSlave::find(&mut session, 9, &plan).map(|slave| slave.is_owned())
        };
        assert!(
            find(Files::default(), Vec::new()).is_ok_and(|is_owned| is_owned),
            "without a file its octets are enough"
        );
        let files = Files::new([Arc::new(GsdFile::read(&fs::read(gsd).unwrap()))]);
        for (files, chosen) in [(files, Vec::new()), (Files::default(), vec![9])] {
            let failure = find(files, chosen).err().map(|failure| failure.to_string()).unwrap_or_default();
            assert!(failure.contains("and is free now; it got no parameters"), "{failure}");
        }
    }
}
