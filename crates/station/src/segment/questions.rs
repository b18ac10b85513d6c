//! What a segment is asked beside its cycle: the parameters of a gauge.
//!
//! One parameter after the other, and between them the gauges are sampled: who asks does not make holes in a record.

use super::member::Member;
use crate::plant::{Plant, Question};
use crate::view::{Block, Parameter};
use profivac_devices::model::{Direction, Via};
use profivac_host::client::{ClientError, Gauge};
use profivac_host::ms2::Ms2;
use profivac_host::tool::{Tool, ToolError};
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
enum Missed {
    Port,
    Because(String),
}

impl Missed {
    fn sentence(self) -> String {
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
    if !watched.model.features.dpv1 {
        return Err(Missed::Because(format!(
            "{name} has no DP-V1: its parameters are read with `profivac dump --via pkw`"
        )));
    }
    let mut gauge = Gauge::known(Ms2::new(tool, watched.address), watched.address, watched.model).in_unit(watched.unit);
    let mut blocks: Vec<Block> = Vec::new();
    for named in gauge.names().all() {
        let row = named.parameter.row;
        let readable = row.access.allows(Via::Class2, Direction::Read);
        if !readable && !row.access.allows(Via::Class2, Direction::Write) {
            continue;
        }
        let read = readable.then(|| gauge.read(named));
        let (value, refusal) = match read {
            None => (None, None),
            Some(Ok(reading)) => (Some(reading.text), None),
            Some(Err(ClientError::Tool(ToolError::Port(_)))) => return Err(Missed::Port),
            Some(Err(error)) => (None, Some(error.to_string())),
        };
        let parameter = Parameter {
            target: named.name.clone(),
            name: row.name.to_owned(),
            numbers: named.parameter.numbers(),
            access: row.access_text.to_owned(),
            value,
            refusal,
        };
        let title = title(named);
        match blocks.last_mut().filter(|block| block.name == title) {
            Some(block) => block.parameters.push(parameter),
            None => blocks.push(Block { name: title, parameters: vec![parameter] }),
        }
        let tool = gauge.records().tool();
        members.iter_mut().for_each(|member| member.sample(plant, tool));
    }
    let _put_back = gauge.finish();
    Ok(blocks)
}

/// The name of a block, with its instance where there are several.
fn title(named: &profivac_host::client::names::Named) -> String {
    let place = named.parameter.place;
    match place.instance {
        0 => format!("{} (slot {})", named.parameter.block.name, place.slot),
        instance => format!("{} {instance} (slot {})", named.parameter.block.name, place.slot),
    }
}
