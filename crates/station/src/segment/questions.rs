//! What a segment is asked beside its cycle: the parameters of a gauge.
//!
//! One parameter after the other, and between them the gauges are sampled: who asks does not make holes in a record.

use super::member::Member;
use crate::plant::{Plant, Question};
use crate::view::{Block, Parameter};
use profivac_devices::model::{Direction, Via};
use profivac_host::client::names::Named;
use profivac_host::client::records::Records;
use profivac_host::client::{ClientError, Gauge};
use profivac_host::ms2::Ms2;
use profivac_host::tool::{Tool, ToolError};
use profivac_host::watch::Watched;
use std::sync::mpsc::Receiver;

/// Answers one question, if there is one.
///
/// # Errors
/// The name of the port, when it was lost.
pub fn answer(
    questions: &Receiver<Question>,
    tool: &mut Tool,
    members: &mut [Member],
    plant: &Plant,
) -> Result<(), String> {
    let Ok(Question::Blocks(name, answer)) = questions.try_recv() else { return Ok(()) };
    let blocks = blocks(&name, tool, members, plant);
    let lost = matches!(blocks, Err(Missed::Port));
    // Whoever asked may have gone.
    answer.send(blocks.map_err(|missed| missed.sentence())).ok();
    if lost { Err(tool.port_name().to_owned()) } else { Ok(()) }
}

/// Refuses all questions.
pub fn refuse(questions: &Receiver<Question>, sentence: &str) {
    while let Ok(Question::Blocks(_, answer)) = questions.try_recv() {
        answer.send(Err(sentence.to_owned())).ok();
    }
}

/// Why there are no blocks.
pub enum Missed {
    /// The port is lost.
    Port,
    /// In a sentence.
    Because(String),
}

impl Missed {
    /// For people.
    pub fn sentence(self) -> String {
        match self {
            Self::Port => "the port is lost".to_owned(),
            Self::Because(sentence) => sentence,
        }
    }
}

fn blocks(name: &str, tool: &mut Tool, members: &mut [Member], plant: &Plant) -> Result<Vec<Block>, Missed> {
    let member = members.iter().find(|member| member.config.name == name);
    let member = member.ok_or_else(|| Missed::Because(format!("there is no gauge {name:?}")))?;
    let watched = member.watched.ok_or_else(|| Missed::Because(format!("{name} does not answer")))?;
    let records = Ms2::new(tool, watched.address);
    read_blocks(name, &watched, records, |records| {
        let master = records.tool().master();
        members.iter_mut().for_each(|member| member.sample(plant, master));
    })
}

/// All blocks of a gauge. `between` is called after every parameter.
pub fn read_blocks<R: Records>(
    name: &str,
    watched: &Watched,
    records: R,
    mut between: impl FnMut(&mut R),
) -> Result<Vec<Block>, Missed> {
    if !watched.model.features.dpv1 {
        return Err(Missed::Because(format!(
            "{name} has no DP-V1: its parameters are read with `profivac dump --via pkw`"
        )));
    }
    let mut gauge = Gauge::known(records, watched.address, watched.model).in_unit(watched.unit);
    let mut blocks: Vec<Block> = Vec::new();
    for named in gauge.names().all() {
        let Some(parameter) = read_parameter(&mut gauge, named)? else { continue };
        let title = title(named);
        match blocks.last_mut().filter(|block| block.name == title) {
            Some(block) => block.parameters.push(parameter),
            None => blocks.push(Block { name: title, parameters: vec![parameter] }),
        }
        between(gauge.records());
    }
    // The instance that was shown before is shown again, if the gauge still answers.
    gauge.finish().ok();
    Ok(blocks)
}

/// A parameter that a class 2 master may read or write, read if it may.
fn read_parameter<R: Records>(gauge: &mut Gauge<R>, named: &Named) -> Result<Option<Parameter>, Missed> {
    let row = named.parameter.row;
    let readable = row.access.allows(Via::Class2, Direction::Read);
    if !readable && !row.access.allows(Via::Class2, Direction::Write) {
        return Ok(None);
    }
    let (value, refusal) = match readable.then(|| gauge.read(named)) {
        None => (None, None),
        Some(Ok(reading)) => (Some(reading.text), None),
        Some(Err(ClientError::Tool(ToolError::Port(_)))) => return Err(Missed::Port),
        Some(Err(error)) => (None, Some(error.to_string())),
    };
    Ok(Some(Parameter {
        target: named.name.clone(),
        name: row.name.to_owned(),
        numbers: named.parameter.numbers(),
        access: row.access_text.to_owned(),
        value,
        refusal,
    }))
}

/// The name of a block, with its instance where there are several.
fn title(named: &Named) -> String {
    let place = named.parameter.place;
    match place.instance {
        0 => format!("{} (slot {})", named.parameter.block.name, place.slot),
        instance => format!("{} {instance} (slot {})", named.parameter.block.name, place.slot),
    }
}
