//! Answers the requests of users to a segment: the parameters of a gauge, and operations.
//!
//! The gauges are sampled meanwhile, so a request leaves no gap in the recording.

use super::execute;
use super::services::SegmentServices;
use crate::control::error::{ChangedSinceArmed, Unavailable};
use crate::control::permissions;
use crate::control::requests::SegmentRequest;
use crate::snapshot::SnapshotStore;
use crate::view::{Block, Parameter, WriteInfo};
use profivac_client::cyclic::CyclicSlave;
use profivac_client::names::NamedParameter;
use profivac_client::records::Records;
use profivac_client::values::ValueFormat;
use profivac_client::{ClientError, Gauge};
use profivac_devices::model::{AccessPath, Codes, DataType, Direction, Model, NumberType, Unit};
use profivac_host::session::SessionError;
use std::sync::mpsc::Receiver;
use std::time::Instant;

/// The port was lost during a request.
pub struct PortLost;

/// Answers a request. `slave` gives the slave of a gauge in data exchange, `records` the access to the records at an address.
///
/// # Errors
/// [`PortLost`]. Where a write finds the port lost, the next cycle finds it lost too.
pub fn answer<R: Records>(
    services: &SegmentServices,
    request: SegmentRequest,
    slave: impl FnOnce(&str) -> Result<CyclicSlave, Unavailable>,
    records: impl FnOnce(u8) -> R,
) -> Result<(), PortLost> {
    // A requester that timed out takes no answer.
    match request {
        SegmentRequest::Blocks(name, answer) => {
            let blocks =
                slave(&name).and_then(|slave| read_blocks(&services.snapshots, &name, &slave, records(slave.address)));
            let is_lost = matches!(blocks, Err(Unavailable::PortLost));
            answer.send(blocks).ok();
            return if is_lost { Err(PortLost) } else { Ok(()) };
        }
        SegmentRequest::Preview(name, operation, answer) => {
            let preview = slave(&name)
                .map_err(Into::into)
                .and_then(|slave| execute::preview(&name, &slave, records(slave.address), &operation));
            answer.send(preview).ok();
        }
        SegmentRequest::Execute(command, begin_by, answer) if Instant::now() >= begin_by => {
            answer.send(Err(Unavailable::SegmentBusy(command.gauge.clone()).into())).ok();
        }
        SegmentRequest::Execute(command, _, answer) if !services.control.may_send(&command) => {
            let lost = ChangedSinceArmed::ControlLost { user: command.user.to_string() };
            answer.send(Err(lost.into())).ok();
        }
        SegmentRequest::Execute(command, _, answer) => {
            let readback = slave(&command.gauge)
                .map_err(Into::into)
                .and_then(|slave| execute::execute(&slave, records(slave.address), &command));
            answer.send(readback).ok();
        }
    }
    Ok(())
}

/// Refuses all requests, because the segment does not run.
pub fn refuse_all(requests: &Receiver<SegmentRequest>, problem: &str) {
    let down = || Unavailable::SegmentDown(problem.to_owned());
    while let Ok(request) = requests.try_recv() {
        match request {
            SegmentRequest::Blocks(_, answer) => answer.send(Err(down())).ok(),
            SegmentRequest::Preview(_, _, answer) => answer.send(Err(down().into())).ok(),
            SegmentRequest::Execute(_, _, answer) => answer.send(Err(down().into())).ok(),
        };
    }
}

/// Reads all blocks of a gauge.
fn read_blocks<R: Records>(
    snapshots: &SnapshotStore,
    name: &str,
    slave: &CyclicSlave,
    records: R,
) -> Result<Vec<Block>, Unavailable> {
    if !slave.model.features.dpv1 {
        return Err(Unavailable::ReadNeedsDpV1(name.to_owned()));
    }
    let mut gauge = Gauge::with_model(records, slave.address, slave.model).with_unit(slave.unit);
    let (names, mut blocks) = (gauge.names(), Ok(Vec::new()));
    let total = names.all().len();
    for (done, named) in names.all().iter().enumerate() {
        snapshots.set_read_progress(name, done, total);
        blocks = blocks.and_then(|blocks| add_parameter(blocks, &mut gauge, named, slave.unit));
        if blocks.is_err() {
            break;
        }
    }
    snapshots.set_read_progress(name, total, total);
    // A gauge that no longer answers keeps the selector where it is.
    gauge.restore_selector().ok();
    blocks
}

/// Adds a parameter to its block, if it can be read or written over MS2.
fn add_parameter<R: Records>(
    mut blocks: Vec<Block>,
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    unit: &'static Unit,
) -> Result<Vec<Block>, Unavailable> {
    let Some(parameter) = parameter(gauge, named, unit)? else { return Ok(blocks) };
    let title = title(named);
    match blocks.last_mut().filter(|block| block.name == title) {
        Some(block) => block.parameters.push(parameter),
        None => blocks.push(Block { name: title, parameters: vec![parameter] }),
    }
    Ok(blocks)
}

/// Reads a parameter; `None` if MS2 neither reads nor writes it.
fn parameter<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    unit: &'static Unit,
) -> Result<Option<Parameter>, Unavailable> {
    let row = named.parameter.row;
    let readable = row.access.allows(AccessPath::Class2, Direction::Read);
    if !readable && !row.access.allows(AccessPath::Class2, Direction::Write) {
        return Ok(None);
    }
    let (value, refusal) = match readable.then(|| gauge.read_parameter(named)) {
        None => (None, None),
        Some(Ok(reading)) => (Some(reading.text), None),
        Some(Err(ClientError::Session(SessionError::Port(_)))) => return Err(Unavailable::PortLost),
        Some(Err(error)) => (None, Some(error.to_string())),
    };
    Ok(Some(Parameter {
        target: named.name.clone(),
        name: row.name.to_owned(),
        numbers: named.parameter.numbers(),
        access: row.access_text.to_owned(),
        value,
        read_error: refusal,
        write: write_info(gauge.model(), named, unit),
    }))
}

/// The values and the role that writing a parameter needs; `None` if it is not writable, or only by a command.
fn write_info(model: &'static Model, named: &NamedParameter, unit: &'static Unit) -> Option<WriteInfo> {
    let row = named.parameter.row;
    if !row.access.allows(AccessPath::Class2, Direction::Write) || row.codes.is_command() {
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
    let place = named.parameter.place;
    match place.instance {
        0 => format!("{} (slot {})", named.parameter.block.name, place.slot),
        instance => format!("{} {instance} (slot {})", named.parameter.block.name, place.slot),
    }
}
