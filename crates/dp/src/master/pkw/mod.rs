//! The parameter channel of a master: one task in the cyclic data of a slave, and its answer. profibus-wire 6.1,
//! tira56e1 4.3, tira36e1 2.2.1, tira41d1 2.2.1, BG 5530 4.3.2, IF300P manual 3.2.2.
//!
//! AK, the high nibble of the first octet, says what a task requests and how it was answered; AK 0 is no task. The master sends
//! AK 0 in the outputs until the slave answers AK 0, then the task until the slave answers it, then AK 0 again. An answer
//! between the two AK 0 therefore belongs to this task and not to one before, also with a slave that answers a cycle or two
//! later (errata-bpg-bcg-tpg 25 and 153, errata-pxg55x-img400 10 and 11). The master ignores an answer about something else;
//! if no better one comes, the last one gives the reason of the failure.
//!
//! The channel addresses slot and index. Where a slot has several instances, the Channel Instance Selector selects one of
//! them, as with MS1 and MS2: write that parameter first.

mod value;

pub use value::{AnswerMismatch, ErrorNumber, Value};

use super::acyclic::{AcyclicEvent, Pooled};
use core::fmt;
pub(super) use value::OCTETS;
use value::{Answer, Instruction, is_rest};

/// Operation of [`Master::pkw_read`](super::Master::pkw_read) and [`Master::pkw_write`](super::Master::pkw_write): the
/// outcome is the value in the answer.
#[derive(Clone, Copy, Debug)]
pub enum Task {}

/// The reason why a task has no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TaskError {
    /// The slave refused the task.
    Refused(ErrorNumber),
    /// No answer came within the number of data exchanges.
    Timeout,
    /// Only answers that do not fit the task came.
    Mismatch(AnswerMismatch),
    /// The slave left data exchange.
    LeftExchange,
    /// The master left Operate: the outputs, and the parameter channel in them, are zero.
    NotOperating,
}

impl fmt::Display for TaskError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(number) => write!(f, "the slave refused the task: {number}"),
            Self::Timeout => f.write_str("no response in time"),
            Self::Mismatch(mismatch) => mismatch.fmt(f),
            Self::LeftExchange => f.write_str("the slave left data exchange"),
            Self::NotOperating => f.write_str("the master is not in Operate"),
        }
    }
}

impl core::error::Error for TaskError {}

/// AK of a write of one octet, as most devices have it.
pub const WRITE_BYTE: u8 = 10;

/// AK of a write of one octet on devices that take octets as words (errata-bpg-bcg-tpg 133).
pub const WRITE_BYTE_AS_WORD: u8 = 2;

/// The position of the channel in the images, and the dialect of the slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PkwParameters {
    /// The offset of the eight octets in the outputs.
    pub outputs_at: usize,
    /// The offset in the inputs.
    pub inputs_at: usize,
    /// The most data exchanges that a task may take.
    pub cycles: u32,
    /// AK of a write of one octet: [`WRITE_BYTE`] or [`WRITE_BYTE_AS_WORD`].
    pub byte_ak: u8,
}

impl PkwParameters {
    /// A gauge whose telegrams begin with the channel, as all gauges of this project do.
    ///
    /// chosen: 1000 exchanges, a few seconds on a slow bus; no manual gives a time.
    pub const GAUGE: Self = Self { outputs_at: 0, inputs_at: 0, cycles: 1000, byte_ak: WRITE_BYTE };

    /// The controllers with an IF300P or IF301P.
    pub const CONTROLLER: Self = Self { byte_ak: WRITE_BYTE_AS_WORD, ..Self::GAUGE };
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TaskState {
    /// The master sends AK 0 until the slave answers AK 0.
    Rest,
    /// The master sends the task.
    Requested,
    Done(Result<Value, TaskError>),
}

/// One task under way.
#[derive(Clone, Debug)]
pub(super) struct PkwTask {
    address: u8,
    /// The data exchange that the task belongs to: how often the slave had entered data exchange.
    starts: u32,
    parameters: PkwParameters,
    instruction: Instruction,
    state: TaskState,
    /// The octets of the present state were sent.
    sent: bool,
    exchanges_left: u32,
    mismatch: Option<AnswerMismatch>,
}

impl Pooled for PkwTask {
    fn is_over(&self) -> bool {
        matches!(self.state, TaskState::Done(_))
    }
}

impl PkwTask {
    pub(super) fn read(
        relation: (u8, u32),
        (slot, index): (u8, u8),
        width: Option<usize>,
        parameters: &PkwParameters,
    ) -> Self {
        Self::new(relation, Instruction { slot, index, write: None, width, byte_ak: parameters.byte_ak }, parameters)
    }

    pub(super) fn write(
        relation: (u8, u32),
        (slot, index): (u8, u8),
        value: Value,
        parameters: &PkwParameters,
    ) -> Self {
        Self::new(
            relation,
            Instruction { slot, index, write: Some(value), width: None, byte_ak: parameters.byte_ak },
            parameters,
        )
    }

    const fn new((address, starts): (u8, u32), instruction: Instruction, parameters: &PkwParameters) -> Self {
        Self {
            address,
            starts,
            parameters: *parameters,
            instruction,
            state: TaskState::Rest,
            sent: false,
            exchanges_left: parameters.cycles,
            mismatch: None,
        }
    }

    pub(super) const fn address(&self) -> u8 {
        self.address
    }

    pub(super) const fn starts(&self) -> u32 {
        self.starts
    }

    pub(super) const fn outcome(&self) -> Option<Result<Value, TaskError>> {
        match self.state {
            TaskState::Rest | TaskState::Requested => None,
            TaskState::Done(result) => Some(result),
        }
    }

    /// Puts the octets of the present state into outputs that are about to be sent.
    pub(super) fn put(&mut self, outputs: &mut [u8]) {
        if let Some(channel) = part_mut(outputs, self.parameters.outputs_at) {
            *channel = if self.state == TaskState::Requested { self.instruction.octets() } else { [0; OCTETS] };
            self.sent = true;
        }
    }

    /// Evaluates the inputs that the slave sent in answer to outputs.
    pub(super) fn exchanged(&mut self, inputs: &[u8]) -> Option<AcyclicEvent> {
        let octets = *part(inputs, self.parameters.inputs_at)?;
        if self.is_over() || !core::mem::take(&mut self.sent) {
            return None;
        }
        self.exchanges_left = self.exchanges_left.saturating_sub(1);
        match self.state {
            TaskState::Rest if is_rest(&octets) => {
                self.mismatch = None;
                self.state = TaskState::Requested;
            }
            TaskState::Rest => self.mismatch = Some(AnswerMismatch::Unrequested),
            _ => match self.instruction.answer(octets) {
                Ok(Answer::Nothing) => {}
                Ok(Answer::Value(value)) => return self.finish(Ok(value)),
                Ok(Answer::Refused(number)) => return self.finish(Err(TaskError::Refused(number))),
                Err(mismatch) => self.mismatch = Some(mismatch),
            },
        }
        if self.exchanges_left > 0 {
            return None;
        }
        self.fail(self.mismatch.map_or(TaskError::Timeout, TaskError::Mismatch))
    }

    pub(super) fn fail(&mut self, error: TaskError) -> Option<AcyclicEvent> {
        if self.is_over() {
            return None;
        }
        self.finish(Err(error))
    }

    const fn finish(&mut self, result: Result<Value, TaskError>) -> Option<AcyclicEvent> {
        self.state = TaskState::Done(result);
        Some(AcyclicEvent::OutcomeReady)
    }
}

/// The channel in an image.
pub(super) fn part(image: &[u8], at: usize) -> Option<&[u8; OCTETS]> {
    image.get(at..)?.first_chunk()
}

fn part_mut(image: &mut [u8], at: usize) -> Option<&mut [u8; OCTETS]> {
    image.get_mut(at..)?.first_chunk_mut()
}
