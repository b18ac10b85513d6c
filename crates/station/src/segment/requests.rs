//! Reads the parameters of a gauge for users, block by block.

use crate::control::error::Unavailable;
use crate::control::permissions;
use crate::snapshot::SnapshotStore;
use crate::view::{Block, Parameter, WriteInfo};
use profivac_client::cyclic::CyclicSlave;
use profivac_client::names::NamedParameter;
use profivac_client::records::{self, Records};
use profivac_client::values::ValueFormat;
use profivac_client::{ClientError, ErrorKind, Gauge};
use profivac_devices::model::{AccessPath, Codes, DataType, Direction, Model, NumberType, Unit};
use profivac_host::session::SessionError;

/// How far the parameters of a gauge are read.
#[derive(Default)]
pub struct BlockReading {
    /// The model whose parameters are read.
    model: Option<&'static Model>,
    blocks: Vec<Block>,
    /// The number of parameters that are done.
    done: usize,
}

/// Why a reading paused or ended.
pub enum BlockReadingEnd {
    /// All parameters are read.
    Complete,
    /// A command comes first. The reading continues after it.
    Interrupted,
    /// The gauge cannot be read.
    Failed(Unavailable),
}

impl BlockReading {
    /// The blocks that were read.
    pub fn into_blocks(self) -> Vec<Block> {
        self.blocks
    }

    /// Reads one parameter after the other until all are done or `is_interrupted`, with at least one each time. Begins again if
    /// a gauge of another model has replaced the one before.
    pub fn read_on<R: Records>(
        &mut self,
        snapshots: &SnapshotStore,
        name: &str,
        slave: &CyclicSlave,
        records: R,
        mut is_interrupted: impl FnMut() -> bool,
    ) -> BlockReadingEnd {
        if !self.model.is_some_and(|model| std::ptr::eq(model, slave.model)) {
            *self = Self { model: Some(slave.model), ..Self::default() };
        }
        let mut gauge = Gauge::with_model(records, slave.address, slave.model).with_unit(slave.unit);
        let names = gauge.names();
        let total = names.all().len();
        let end = loop {
            let Some(named) = names.all().get(self.done) else { break BlockReadingEnd::Complete };
            snapshots.set_read_progress(name, self.done, total);
            if let Err(error) = self.add(&mut gauge, named, slave.unit) {
                break BlockReadingEnd::Failed(error);
            }
            self.done = self.done.saturating_add(1);
            if self.done < total && is_interrupted() {
                break BlockReadingEnd::Interrupted;
            }
        };
        // A gauge that no longer answers keeps the selector where it is.
        gauge.restore_selector().ok();
        end
    }

    /// Reads a parameter into its block, if the service of the gauge reads or writes it.
    fn add<R: Records>(
        &mut self,
        gauge: &mut Gauge<R>,
        named: &NamedParameter,
        unit: &'static Unit,
    ) -> Result<(), Unavailable> {
        let Some(parameter) = parameter(gauge, named, unit)? else { return Ok(()) };
        let title = title(named);
        match self.blocks.last_mut().filter(|block| block.name == title) {
            Some(block) => block.parameters.push(parameter),
            None => self.blocks.push(Block { name: title, parameters: vec![parameter] }),
        }
        Ok(())
    }
}

/// Whether a slave has closed its resource manager: all of its connections are in use.
pub const fn has_no_connection(error: &ClientError) -> bool {
    matches!(error, ClientError::Unavailable { reason: records::Unavailable::NoConnection, .. })
}

/// The parameters of a gauge are no longer being read.
pub fn end_progress(snapshots: &SnapshotStore, name: &str) {
    snapshots.set_read_progress(name, 0, 0);
}

/// Reads a parameter; `None` if the service of the gauge neither reads nor writes it.
fn parameter<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    unit: &'static Unit,
) -> Result<Option<Parameter>, Unavailable> {
    let (row, via) = (named.parameter.row, gauge.records().via());
    let readable = row.access.allows(via, Direction::Read);
    if !readable && !row.access.allows(via, Direction::Write) {
        return Ok(None);
    }
    let (value, refusal) = match readable.then(|| gauge.read_parameter(named)) {
        None => (None, None),
        Some(Ok(reading)) => (Some(reading.text), None),
        Some(Err(ClientError::Session(SessionError::Port(_)))) => return Err(Unavailable::PortLost),
        // The gauge does not answer any more: each further parameter would take as long as this one.
        Some(Err(error)) if has_no_connection(&error) || error.kind() == ErrorKind::Line => {
            return Err(Unavailable::Client(Box::new(error)));
        }
        Some(Err(error)) => (None, Some(error.to_string())),
    };
    Ok(Some(Parameter {
        target: named.name.clone(),
        name: row.name.to_owned(),
        numbers: named.parameter.numbers(),
        access: row.access_text.to_owned(),
        value,
        read_error: refusal,
        write: write_info(gauge.model(), named, unit, via),
    }))
}

/// The values and the role that writing a parameter needs; `None` if it is not writable, or only by a command.
fn write_info(
    model: &'static Model,
    named: &NamedParameter,
    unit: &'static Unit,
    via: AccessPath,
) -> Option<WriteInfo> {
    let row = named.parameter.row;
    if !row.access.allows(via, Direction::Write) || row.codes.is_command() {
        return None;
    }
    let choices = match (&row.codes, row.data_type) {
        (Codes::Plain, DataType::Boolean) => vec!["true".to_owned(), "false".to_owned()],
        (codes, _) => codes.codes().iter().map(|code| code.name.to_owned()).collect(),
    };
    let takes = ValueFormat { named, model, unit: Some(unit) }.expected(NumberType::Float).to_string();
    let barred = permissions::blocked_reason(row).map(str::to_owned);
    Some(WriteInfo {
        expects: takes,
        allowed_values: choices,
        risk: permissions::risk(row, None),
        role: permissions::role(row, None),
        blocked_reason: barred,
    })
}

/// The name of a block, with its instance if there are several.
fn title(named: &NamedParameter) -> String {
    let location = named.parameter.location;
    match location.instance {
        0 => format!("{} (slot {})", named.parameter.block.name, location.slot),
        instance => format!("{} {instance} (slot {})", named.parameter.block.name, location.slot),
    }
}
