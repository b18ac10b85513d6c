//! What a segment is asked beside its cycle: the parameters of a gauge, and what is done to one.
//!
//! Meanwhile the gauges are sampled: who asks does not make holes in a record.

use super::{Worker, deeds};
use crate::act::draft::Refusal;
use crate::act::{self, allowed};
use crate::plant::{Plant, Question};
use crate::view::{Block, Parameter, Writing};
use profivac_client::ms2::Ms2;
use profivac_client::names::Named;
use profivac_client::records::Records;
use profivac_client::values::Meaning;
use profivac_client::watch::Watched;
use profivac_client::{ClientError, Gauge};
use profivac_devices::model::{Codes, DataType, Direction, Model, NumberType, Unit, Via};
use profivac_host::session::{BusSession, SessionError};
use std::sync::mpsc::Receiver;
use std::time::Instant;

/// Answers one question, if there is one.
///
/// # Errors
/// The name of the port, when it was lost.
pub fn answer(worker: &Worker, tool: &mut BusSession) -> Result<(), String> {
    let Ok(question) = worker.questions.try_recv() else { return Ok(()) };
    let settled = settle(&worker.plant, question, |name| watched(name, worker), |address| Ms2::new(tool, address));
    settled.map_err(|Lost| tool.port_name().to_owned())
}

/// The port was lost meanwhile.
pub struct Lost;

/// Answers a question. `watched` says what is known of a gauge, `records` is the way to it.
///
/// # Errors
/// [`Lost`].
pub fn settle<R: Records>(
    plant: &Plant,
    question: Question,
    watched: impl FnOnce(&str) -> Result<Watched, String>,
    records: impl FnOnce(u8) -> R,
) -> Result<(), Lost> {
    // Whoever asked may have gone.
    match question {
        Question::Blocks(name, answer) => {
            let watched = watched(&name).map_err(Missed::Because);
            let blocks = watched.and_then(|watched| read_blocks(plant, &name, &watched, records(watched.address)));
            let lost = matches!(blocks, Err(Missed::Port));
            answer.send(blocks.map_err(Missed::sentence)).ok();
            return if lost { Err(Lost) } else { Ok(()) };
        }
        Question::Draft(name, choice, answer) => {
            let watched = watched(&name).map_err(Refusal::Away);
            let draft = watched.and_then(|watched| deeds::draft(&name, &watched, records(watched.address), &choice));
            answer.send(draft).ok();
        }
        Question::Fire(order, begin_by, answer) if Instant::now() >= begin_by => {
            let sentence = format!("the segment of {} was busy for too long", order.gauge);
            answer.send(Err(Refusal::Away(sentence))).ok();
        }
        Question::Fire(order, _, answer) if !act::may_send(plant, &order) => {
            let sentence = format!("{} has lost the mastership before it was sent", order.by);
            answer.send(Err(Refusal::Changed(sentence))).ok();
        }
        Question::Fire(order, _, answer) => {
            let watched = watched(&order.gauge).map_err(Refusal::Away);
            let done = watched.and_then(|watched| deeds::carry_out(&watched, records(watched.address), &order));
            answer.send(done).ok();
        }
    }
    // If the port was lost, serving the line finds it out.
    Ok(())
}

/// Refuses all questions.
pub fn refuse(questions: &Receiver<Question>, sentence: &str) {
    while let Ok(question) = questions.try_recv() {
        let away = || Refusal::Away(sentence.to_owned());
        match question {
            Question::Blocks(_, answer) => answer.send(Err(sentence.to_owned())).ok(),
            Question::Draft(_, _, answer) => answer.send(Err(away())).ok(),
            Question::Fire(_, _, answer) => answer.send(Err(away())).ok(),
        };
    }
}

/// Why there are no blocks.
enum Missed {
    /// The port is lost.
    Port,
    /// In a sentence.
    Because(String),
}

impl Missed {
    /// For people.
    fn sentence(self) -> String {
        match self {
            Self::Port => "the port is lost".to_owned(),
            Self::Because(sentence) => sentence,
        }
    }
}

/// All blocks of a gauge, with what their parameters show.
fn read_blocks<R: Records>(plant: &Plant, name: &str, watched: &Watched, records: R) -> Result<Vec<Block>, Missed> {
    if !watched.model.features.dpv1 {
        let sentence = format!("{name} has no DP-V1: its parameters are read with `profivac dump --via pkw`");
        return Err(Missed::Because(sentence));
    }
    let mut gauge = Gauge::known(records, watched.address, watched.model).in_unit(watched.unit);
    let (names, mut blocks) = (gauge.names(), Ok(Vec::new()));
    let of = names.all().len();
    for (done, named) in names.all().iter().enumerate() {
        plant.read_so_far(name, done, of);
        blocks = blocks.and_then(|blocks| grown(blocks, &mut gauge, named, watched.unit));
        if blocks.is_err() {
            break;
        }
    }
    plant.read_so_far(name, of, of);
    // The instance that was shown before is shown again, if the gauge still answers.
    gauge.finish().ok();
    blocks
}

/// Blocks with one more parameter, if somebody can read or write it.
fn grown<R: Records>(
    mut blocks: Vec<Block>,
    gauge: &mut Gauge<R>,
    named: &Named,
    unit: &'static Unit,
) -> Result<Vec<Block>, Missed> {
    let Some(parameter) = parameter(gauge, named, unit)? else { return Ok(blocks) };
    let title = title(named);
    match blocks.last_mut().filter(|block| block.name == title) {
        Some(block) => block.parameters.push(parameter),
        None => blocks.push(Block { name: title, parameters: vec![parameter] }),
    }
    Ok(blocks)
}

/// What is known of the gauge that is asked for, or why it cannot be asked.
fn watched(name: &str, worker: &Worker) -> Result<Watched, String> {
    let members = worker.members();
    let member = members.iter().find(|member| member.config.name == name);
    let member = member.ok_or_else(|| format!("there is no gauge {name:?}"))?;
    member.watched.ok_or_else(|| format!("{name} does not answer"))
}

/// A parameter with what it shows; nothing if nobody can read or write it on the way we have.
fn parameter<R: Records>(
    gauge: &mut Gauge<R>,
    named: &Named,
    unit: &'static Unit,
) -> Result<Option<Parameter>, Missed> {
    let row = named.parameter.row;
    let readable = row.access.allows(Via::Class2, Direction::Read);
    if !readable && !row.access.allows(Via::Class2, Direction::Write) {
        return Ok(None);
    }
    let (value, refusal) = match readable.then(|| gauge.read(named)) {
        None => (None, None),
        Some(Ok(reading)) => (Some(reading.text), None),
        Some(Err(ClientError::Tool(SessionError::Port(_)))) => return Err(Missed::Port),
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
fn writing(model: &'static Model, named: &Named, unit: &'static Unit) -> Option<Writing> {
    let row = named.parameter.row;
    if !row.access.allows(Via::Class2, Direction::Write) || row.codes.is_command() {
        return None;
    }
    let choices = match (&row.codes, row.data_type) {
        (Codes::Plain, DataType::Boolean) => vec!["true".to_owned(), "false".to_owned()],
        (codes, _) => codes.list().iter().map(|code| code.name.to_owned()).collect(),
    };
    let takes = Meaning { named, model, unit: Some(unit) }.takes(NumberType::Float);
    let barred = allowed::barred(row).map(str::to_owned);
    Some(Writing { takes, choices, risk: allowed::risk(row, None), role: allowed::role(row, None), barred })
}

/// The name of a block, with its instance where there are several.
fn title(named: &Named) -> String {
    let place = named.parameter.place;
    match place.instance {
        0 => format!("{} (slot {})", named.parameter.block.name, place.slot),
        instance => format!("{} {instance} (slot {})", named.parameter.block.name, place.slot),
    }
}
