//! The parameter channel at the master: one instruction in the cyclic data of a slave, and its answer. profibus-wire 6.1,
//! tira56e1 4.3, tira36e1 2.2.1, tira41d1 2.2.1, BG 5530 4.3.2, IF300P manual 3.2.2.
//!
//! AK 0 stands in the outputs until the slave answers AK 0; then the instruction, until it is answered; then AK 0 again. So
//! whatever is answered between the two rests is the answer to this instruction and not to one before, also where a slave
//! answers a cycle or two later (errata-bpg-bcg-tpg 25 and 153, errata-pxg55x-img400 10 and 11). An answer about something
//! else is passed over; if nothing better comes, the last one names the reason.
//!
//! The channel addresses slot and index. Where a slot has several instances the selector decides which one is meant, here as
//! with MS1 and MS2: write the parameter Channel Instance Selector first.

mod value;

pub use value::{AnswerMismatch, Error, Value};

use super::acyclic::{AcyclicEvent, Cause, Outcome, Pooled};
pub(super) use value::OCTETS;
use value::{Answer, Task, is_rest};

/// Where the channel is, and how the slave speaks in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PkwParameters {
    /// Where in the outputs its eight octets begin.
    pub outputs_at: usize,
    /// Where in the inputs.
    pub inputs_at: usize,
    /// How many data exchanges an instruction may take.
    pub cycles: u32,
    /// AK of a write of one octet: 10, and 2 where bytes are written as words (errata-bpg-bcg-tpg 133).
    pub byte_ak: u8,
}

impl PkwParameters {
    /// A gauge whose telegrams begin with the channel, as all of this project do.
    ///
    /// free choice: 1000 exchanges, a few seconds on a slow bus; no manual gives a time.
    pub const GAUGE: Self = Self { outputs_at: 0, inputs_at: 0, cycles: 1000, byte_ak: 10 };

    /// The controllers with an IF300P or IF301P.
    pub const CONTROLLER: Self = Self { byte_ak: 2, ..Self::GAUGE };
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TaskState {
    /// AK 0, until the slave has nothing to answer any more.
    Rest,
    /// The instruction.
    Asked,
    Value(Value),
    Denied(Error),
    Failed(Cause),
}

/// One instruction.
#[derive(Clone, Debug)]
pub(super) struct PkwTask {
    address: u8,
    /// Which data exchange it belongs to: how often the slave had come there.
    starts: u32,
    parameters: PkwParameters,
    instruction: Task,
    state: TaskState,
    /// What stands in the outputs was sent.
    sent: bool,
    exchanges_left: u32,
    wrong: Option<AnswerMismatch>,
}

impl Pooled for PkwTask {
    const SERVICE: u8 = 3;

    fn is_over(&self) -> bool {
        !matches!(self.state, TaskState::Rest | TaskState::Asked)
    }
}

impl PkwTask {
    pub(super) fn read(relation: (u8, u32), (slot, index): (u8, u8), width: Option<usize>, it: &PkwParameters) -> Self {
        Self::new(relation, Task { slot, index, write: None, width, byte_ak: it.byte_ak }, it)
    }

    pub(super) fn write(relation: (u8, u32), (slot, index): (u8, u8), value: Value, it: &PkwParameters) -> Self {
        Self::new(relation, Task { slot, index, write: Some(value), width: None, byte_ak: it.byte_ak }, it)
    }

    const fn new((address, starts): (u8, u32), instruction: Task, parameters: &PkwParameters) -> Self {
        Self {
            address,
            starts,
            parameters: *parameters,
            instruction,
            state: TaskState::Rest,
            sent: false,
            exchanges_left: parameters.cycles,
            wrong: None,
        }
    }

    pub(super) const fn address(&self) -> u8 {
        self.address
    }

    pub(super) const fn starts(&self) -> u32 {
        self.starts
    }

    pub(super) const fn outcome(&self) -> Option<Outcome<'static>> {
        Some(match self.state {
            TaskState::Rest | TaskState::Asked => return None,
            TaskState::Value(value) => Outcome::Value(value),
            TaskState::Denied(error) => Outcome::Denied(error),
            TaskState::Failed(cause) => Outcome::Failed(cause),
        })
    }

    /// These outputs are about to be sent: what stands in the channel is put into them.
    pub(super) fn put(&mut self, outputs: &mut [u8]) {
        if let Some(place) = part_mut(outputs, self.parameters.outputs_at) {
            *place = if self.state == TaskState::Asked { self.instruction.octets() } else { [0; OCTETS] };
            self.sent = true;
        }
    }

    /// Inputs came in answer to outputs.
    pub(super) fn exchanged(&mut self, inputs: &[u8]) -> Option<AcyclicEvent> {
        let octets = *part(inputs, self.parameters.inputs_at)?;
        if self.is_over() || !core::mem::take(&mut self.sent) {
            return None;
        }
        self.exchanges_left = self.exchanges_left.saturating_sub(1);
        match self.state {
            TaskState::Rest if is_rest(&octets) => {
                self.wrong = None;
                self.state = TaskState::Asked;
            }
            TaskState::Rest => self.wrong = Some(AnswerMismatch::Unasked),
            _ => match self.instruction.answer(octets) {
                Ok(Answer::Nothing) => {}
                Ok(Answer::Value(value)) => return self.over(TaskState::Value(value)),
                Ok(Answer::Refused(error)) => return self.over(TaskState::Denied(error)),
                Err(wrong) => self.wrong = Some(wrong),
            },
        }
        if self.exchanges_left > 0 {
            return None;
        }
        self.fail(self.wrong.map_or(Cause::Timeout, Cause::Channel))
    }

    pub(super) fn fail(&mut self, cause: Cause) -> Option<AcyclicEvent> {
        if self.is_over() {
            return None;
        }
        self.over(TaskState::Failed(cause))
    }

    const fn over(&mut self, state: TaskState) -> Option<AcyclicEvent> {
        self.state = state;
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
