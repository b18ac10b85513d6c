//! What a segment is asked beside its cycle: the parameters of a gauge, and what is done to one.
//!
//! Meanwhile the gauges are sampled: who asks does not make holes in a record.

use super::{SegmentThread, execute};
use crate::control::operation::OperationError;
use crate::control::{self, permissions};
use crate::services::{SegmentRequest, Services};
use crate::view::{Block, Parameter, WriteInfo};
use profivac_client::cyclic::CyclicSlave;
use profivac_client::ms2::Ms2;
use profivac_client::names::NamedParameter;
use profivac_client::records::Records;
use profivac_client::values::ValueFormat;
use profivac_client::{ClientError, Gauge};
use profivac_devices::model::{AccessPath, Codes, DataType, Direction, Model, NumberType, Unit};
use profivac_host::session::{BusSession, SessionError};
use std::sync::mpsc::Receiver;
use std::time::Instant;

/// Answers one question, if there is one.
///
/// # Errors
/// The name of the port, when it was lost.
pub fn answer_next(worker: &SegmentThread, tool: &mut BusSession) -> Result<(), String> {
    let Ok(question) = worker.questions.try_recv() else { return Ok(()) };
    let settled = handle(&worker.plant, question, |name| watched(name, worker), |address| Ms2::new(tool, address));
    settled.map_err(|PortLost| tool.port_name().to_owned())
}

/// The port was lost meanwhile.
pub struct PortLost;

/// Answers a question. `watched` says what is known of a gauge, `records` is the way to it.
///
/// # Errors
/// [`Lost`].
pub fn handle<R: Records>(
    plant: &Services,
    question: SegmentRequest,
    watched: impl FnOnce(&str) -> Result<CyclicSlave, String>,
    records: impl FnOnce(u8) -> R,
) -> Result<(), PortLost> {
    // Whoever asked may have gone.
    match question {
        SegmentRequest::Blocks(name, answer) => {
            let watched = watched(&name).map_err(ReadBlocksError::Because);
            let blocks = watched.and_then(|watched| read_blocks(plant, &name, &watched, records(watched.address)));
            let lost = matches!(blocks, Err(ReadBlocksError::Port));
            answer.send(blocks.map_err(ReadBlocksError::sentence)).ok();
            return if lost { Err(PortLost) } else { Ok(()) };
        }
        SegmentRequest::Preview(name, choice, answer) => {
            let watched = watched(&name).map_err(OperationError::Unavailable);
            let draft =
                watched.and_then(|watched| execute::preview(&name, &watched, records(watched.address), &choice));
            answer.send(draft).ok();
        }
        SegmentRequest::Execute(order, begin_by, answer) if Instant::now() >= begin_by => {
            let sentence = format!("the segment of {} was busy for too long", order.gauge);
            answer.send(Err(OperationError::Unavailable(sentence))).ok();
        }
        SegmentRequest::Execute(order, _, answer) if !control::may_send(plant, &order) => {
            let sentence = format!("{} has lost the mastership before it was sent", order.user);
            answer.send(Err(OperationError::Changed(sentence))).ok();
        }
        SegmentRequest::Execute(order, _, answer) => {
            let watched = watched(&order.gauge).map_err(OperationError::Unavailable);
            let done = watched.and_then(|watched| execute::execute(&watched, records(watched.address), &order));
            answer.send(done).ok();
        }
    }
    // If the port was lost, serving the line finds it out.
    Ok(())
}

/// Refuses all questions.
pub fn refuse_all(questions: &Receiver<SegmentRequest>, sentence: &str) {
    while let Ok(question) = questions.try_recv() {
        let away = || OperationError::Unavailable(sentence.to_owned());
        match question {
            SegmentRequest::Blocks(_, answer) => answer.send(Err(sentence.to_owned())).ok(),
            SegmentRequest::Preview(_, _, answer) => answer.send(Err(away())).ok(),
            SegmentRequest::Execute(_, _, answer) => answer.send(Err(away())).ok(),
        };
    }
}

/// Why there are no blocks.
enum ReadBlocksError {
    /// The port is lost.
    Port,
    /// In a sentence.
    Because(String),
}

impl ReadBlocksError {
    /// For people.
    fn sentence(self) -> String {
        match self {
            Self::Port => "the port is lost".to_owned(),
            Self::Because(sentence) => sentence,
        }
    }
}

/// All blocks of a gauge, with what their parameters show.
fn read_blocks<R: Records>(
    plant: &Services,
    name: &str,
    watched: &CyclicSlave,
    records: R,
) -> Result<Vec<Block>, ReadBlocksError> {
    if !watched.model.features.dpv1 {
        let sentence = format!("{name} has no DP-V1: its parameters are read with `profivac dump --via pkw`");
        return Err(ReadBlocksError::Because(sentence));
    }
    let mut gauge = Gauge::with_model(records, watched.address, watched.model).with_unit(watched.unit);
    let (names, mut blocks) = (gauge.names(), Ok(Vec::new()));
    let of = names.all().len();
    for (done, named) in names.all().iter().enumerate() {
        plant.set_read_progress(name, done, of);
        blocks = blocks.and_then(|blocks| add_parameter(blocks, &mut gauge, named, watched.unit));
        if blocks.is_err() {
            break;
        }
    }
    plant.set_read_progress(name, of, of);
    // The instance that was shown before is shown again, if the gauge still answers.
    gauge.restore_selector().ok();
    blocks
}

/// Blocks with one more parameter, if somebody can read or write it.
fn add_parameter<R: Records>(
    mut blocks: Vec<Block>,
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    unit: &'static Unit,
) -> Result<Vec<Block>, ReadBlocksError> {
    let Some(parameter) = parameter(gauge, named, unit)? else { return Ok(blocks) };
    let title = title(named);
    match blocks.last_mut().filter(|block| block.name == title) {
        Some(block) => block.parameters.push(parameter),
        None => blocks.push(Block { name: title, parameters: vec![parameter] }),
    }
    Ok(blocks)
}

/// What is known of the gauge that is asked for, or why it cannot be asked.
fn watched(name: &str, worker: &SegmentThread) -> Result<CyclicSlave, String> {
    let members = worker.members();
    let member = members.iter().find(|member| member.config.name == name);
    let member = member.ok_or_else(|| format!("there is no gauge {name:?}"))?;
    member.watched.ok_or_else(|| format!("{name} does not answer"))
}

/// A parameter with what it shows; nothing if nobody can read or write it on the way we have.
fn parameter<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    unit: &'static Unit,
) -> Result<Option<Parameter>, ReadBlocksError> {
    let row = named.parameter.row;
    let readable = row.access.allows(AccessPath::Class2, Direction::Read);
    if !readable && !row.access.allows(AccessPath::Class2, Direction::Write) {
        return Ok(None);
    }
    let (value, refusal) = match readable.then(|| gauge.read(named)) {
        None => (None, None),
        Some(Ok(reading)) => (Some(reading.text), None),
        Some(Err(ClientError::Session(SessionError::Port(_)))) => return Err(ReadBlocksError::Port),
        Some(Err(error)) => (None, Some(error.to_string())),
    };
    Ok(Some(Parameter {
        target: named.name.clone(),
        name: row.name.to_owned(),
        numbers: named.parameter.numbers(),
        access: row.access_text.to_owned(),
        value,
        refusal,
        write: writing(gauge.model(), named, unit),
    }))
}

/// What it takes to write a parameter; nothing if it is not written, or only as a command.
fn writing(model: &'static Model, named: &NamedParameter, unit: &'static Unit) -> Option<WriteInfo> {
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
    Some(WriteInfo { takes, choices, risk: permissions::risk(row, None), role: permissions::role(row, None), barred })
}

/// The name of a block, with its instance where there are several.
fn title(named: &NamedParameter) -> String {
    let place = named.parameter.place;
    match place.instance {
        0 => format!("{} (slot {})", named.parameter.block.name, place.slot),
        instance => format!("{} {instance} (slot {})", named.parameter.block.name, place.slot),
    }
}
