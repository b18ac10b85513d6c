//! The parameter channel: eight octets each way, inside the cyclic data. errata-bpg-bcg-tpg 17 to 26 and 133, 148, 153.
//!
//! It only keeps step with the master: what an instruction asks for is done by the same access that serves DP-V1.

use crate::model::{AccessError, ChannelRules, TaskKind};

/// How many octets it has each way.
pub const OCTETS: usize = 8;

/// AK of an answer.
const NOTHING: u8 = 0;
const WORD: u8 = 1;
const DOUBLE_WORD: u8 = 2;
const REFUSED: u8 = 7;
const BYTE: u8 = 11;

/// What the master sends. Reserved bits, the reserved octet and unused octets of the value are not looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Request {
    ak: u8,
    slot: u8,
    index: u8,
    value: [u8; 4],
}

impl Request {
    fn new([pke, slot, index, _, value @ ..]: [u8; OCTETS], dialect: &ChannelRules) -> Self {
        let ak = pke >> 4;
        let used = match dialect.task(ak) {
            Some(TaskKind::Write(lengths)) => lengths.iter().copied().max().unwrap_or_default(),
            Some(TaskKind::Read) | None => 0,
        };
        let mut kept = [0; 4];
        for (place, octet) in kept.iter_mut().zip(value).rev().take(used) {
            *place = octet;
        }
        Self { ak, slot, index, value: kept }
    }
}

/// What is to be done for the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Read this parameter, again in every cycle.
    Read {
        /// Its slot.
        slot: u8,
        /// Its index.
        index: u8,
    },
    /// Write this parameter, once.
    Write {
        /// Its slot.
        slot: u8,
        /// Its index.
        index: u8,
        /// Which lengths the instruction can mean.
        lengths: &'static [usize],
        /// The value, right-aligned.
        value: [u8; 4],
    },
}

/// The parameter channel of a device.
#[derive(Clone, Debug)]
pub struct ParameterChannel {
    dialect: &'static ChannelRules,
    /// The instruction that stands.
    request: Request,
    reply: [u8; OCTETS],
}

impl ParameterChannel {
    /// A channel in which nothing was asked.
    #[must_use]
    pub fn new(dialect: &'static ChannelRules) -> Self {
        Self { dialect, request: Request::default(), reply: [0; OCTETS] }
    }

    /// What the master sends in this cycle. Returns a write that is to be done now; the result goes to
    /// [`answer`](Self::answer).
    ///
    /// A changed instruction without AK 0 before it is not started where the manual asks for that rest; the old answer
    /// stays then.
    pub fn take(&mut self, octets: [u8; OCTETS]) -> Option<Task> {
        let request = Request::new(octets, self.dialect);
        let rest = request.ak == 0;
        if request == self.request || (!rest && self.request.ak != 0 && self.dialect.needs_idle_between) {
            return None;
        }
        self.request = request;
        self.put(NOTHING, [0; 4]);
        if !rest && self.dialect.task(request.ak).is_none() {
            self.answer(Err(AccessError::UnknownTask));
        }
        self.task().filter(|task| matches!(task, Task::Write { .. }))
    }

    /// What the standing instruction asks for.
    #[must_use]
    pub fn task(&self) -> Option<Task> {
        let Request { ak, slot, index, value } = self.request;
        if ak == 0 {
            return None;
        }
        Some(match self.dialect.task(ak)? {
            TaskKind::Read => Task::Read { slot, index },
            TaskKind::Write(lengths) => Task::Write { slot, index, lengths, value },
        })
    }

    /// The result of the task: the octets of the parameter, or why not.
    pub fn answer(&mut self, result: Result<&[u8], AccessError>) {
        match result.and_then(signature) {
            Ok((ak, value)) => self.put(ak, value),
            Err(refusal) => self.put(REFUSED, u32::from(self.dialect.error_code(refusal)).to_be_bytes()),
        }
    }

    /// What the device sends in this cycle.
    #[must_use]
    pub const fn reply(&self) -> &[u8; OCTETS] {
        &self.reply
    }

    /// Slot and index are those of the request, what is not used is 0: errata-bpg-bcg-tpg 24.
    fn put(&mut self, ak: u8, [a, b, c, d]: [u8; 4]) {
        self.reply = [ak << 4, self.request.slot, self.request.index, 0, a, b, c, d];
    }
}

/// AK and value of a parameter, right-aligned. Three octets go as a double word: errata-bpg-bcg-tpg 20.
fn signature(octets: &[u8]) -> Result<(u8, [u8; 4]), AccessError> {
    Ok(match *octets {
        [d] => (BYTE, [0, 0, 0, d]),
        [c, d] => (WORD, [0, 0, c, d]),
        [b, c, d] => (DOUBLE_WORD, [0, b, c, d]),
        [a, b, c, d] => (DOUBLE_WORD, [a, b, c, d]),
        _ => return Err(AccessError::WrongLength),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The IF300P board: no byte write, no rest between instructions, fewer codes. errata-bpg-bcg-tpg 133, 148, 153.
    static CONTROLLER: ChannelRules = ChannelRules {
        tasks: &[(1, TaskKind::Read), (2, TaskKind::Write(&[1, 2])), (3, TaskKind::Write(&[4]))],
        needs_idle_between: false,
        error_codes: &[(AccessError::UnknownTask, 17)],
    };

    const fn write(slot: u8, index: u8, lengths: &'static [usize], value: [u8; 4]) -> Option<Task> {
        Some(Task::Write { slot, index, lengths, value })
    }

    /// The threshold example of the IF300P manual, corrected.
    #[test]
    fn a_controller_takes_one_instruction_after_the_other() {
        let mut channel = ParameterChannel::new(&CONTROLLER);
        let upper = [0x3B, 0x03, 0x12, 0x6F];
        let steps = [
            ([0x20, 10, 20, 0, 0, 0, 0, 0], write(10, 20, &[1, 2], [0; 4]), &[0][..], [0xB0, 10, 20, 0, 0, 0, 0, 0]),
            (
                [0x30, 10, 21, 0, 0x3B, 0x03, 0x12, 0x6F],
                write(10, 21, &[4], upper),
                &upper,
                [0x20, 10, 21, 0, 0x3B, 0x03, 0x12, 0x6F],
            ),
            ([0x20, 10, 23, 0, 0, 0, 0, 3], write(10, 23, &[1, 2], [0, 0, 0, 3]), &[3], [0xB0, 10, 23, 0, 0, 0, 0, 3]),
        ];
        for (request, task, octets, reply) in steps {
            assert_eq!(channel.take(request), task);
            channel.answer(Ok(octets));
            assert_eq!(channel.reply(), &reply);
            assert_eq!(channel.take(request), None, "repeated, and done once");
            assert_eq!(channel.reply(), &reply);
        }
        // The lower nibble of the first octet and unused octets do not make another instruction.
        assert_eq!(channel.take([0x2F, 0x0A, 0x17, 9, 9, 9, 0, 3]), None);
        assert_eq!(channel.take([0xA0, 0x0A, 0x17, 0, 0, 0, 0, 3]), None);
        assert_eq!(channel.reply(), &[0x70, 0x0A, 0x17, 0, 0, 0, 0, 17], "no byte write");
    }

    #[test]
    fn a_read_stands_until_it_is_withdrawn() {
        let mut channel = ParameterChannel::new(&CONTROLLER);
        assert_eq!(channel.task(), None);
        assert_eq!(channel.take([0x10, 1, 20, 0, 0, 0, 0, 0]), None);
        assert_eq!(channel.task(), Some(Task::Read { slot: 1, index: 20 }));
        assert_eq!(channel.reply(), &[0x00, 1, 20, 0, 0, 0, 0, 0], "not answered yet");
        channel.answer(Ok(&[1, 2]));
        assert_eq!(channel.reply(), &[0x10, 1, 20, 0, 0, 0, 1, 2]);
        assert_eq!(channel.take([0x10, 1, 20, 0, 9, 9, 9, 9]), None, "a read has no value");
        assert_eq!(channel.reply(), &[0x10, 1, 20, 0, 0, 0, 1, 2]);
        assert_eq!(channel.take([0; 8]), None);
        assert_eq!((channel.task(), channel.reply()), (None, &[0; 8]));
    }

    #[test]
    fn no_signature_fits_a_length_of_five() {
        let mut channel = ParameterChannel::new(&CONTROLLER);
        channel.take([0x10, 1, 20, 0, 0, 0, 0, 0]);
        channel.answer(Ok(&[0; 5]));
        assert_eq!(channel.reply(), &[0x70, 1, 20, 0, 0, 0, 0, 5]);
    }
}
