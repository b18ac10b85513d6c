//! The parameter channel (PKW): eight octets each way, inside the cyclic data. errata-bpg-bcg-tpg 17 to 26 and 133,
//! 148, 153.
//!
//! [`ParameterChannel`] keeps the request of the master and the answer of the device from cycle to cycle. It does not access
//! parameters: [`channel_service`](super::channel_service) executes its tasks.

use crate::model::{AccessError, ChannelRules, TaskKind};

/// The octets of the channel each way.
pub const OCTETS: usize = 8;

/// AK of an answer: no task.
const AK_NO_TASK: u8 = 0;
/// AK of an answer: a value of two octets.
const AK_WORD: u8 = 1;
/// AK of an answer: a value of three or four octets.
const AK_DOUBLE_WORD: u8 = 2;
/// AK of an answer: an error code.
const AK_ERROR: u8 = 7;
/// AK of an answer: a value of one octet.
const AK_BYTE: u8 = 11;

/// The octets of a request of the master, without reserved bits, reserved octet and unused octets of the value. All 0 for no request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Request([u8; OCTETS]);

impl Request {
    fn new([pke, slot, index, _, value @ ..]: [u8; OCTETS], rules: &ChannelRules) -> Self {
        let ak = pke >> 4;
        let task = if ak == AK_NO_TASK { None } else { rules.task(ak) };
        let used = match task {
            Some(TaskKind::Write(lengths)) => lengths.iter().copied().max().unwrap_or_default(),
            Some(TaskKind::Read) | None => 0,
        };
        let mask = match used {
            0 => 0,
            1 => 0xFF,
            2 => 0xFFFF,
            3 => 0xFF_FFFF,
            _ => u32::MAX,
        };
        let [a, b, c, d] = (u32::from_be_bytes(value) & mask).to_be_bytes();
        Self([ak << 4, slot, index, 0, a, b, c, d])
    }

    const fn ak(&self) -> u8 {
        let Self([pke, ..]) = self;
        *pke >> 4
    }
}

/// A task of the master.
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
    Write(WriteTask),
}

/// A write task of the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WriteTask {
    /// The slot of the parameter.
    pub slot: u8,
    /// Its index.
    pub index: u8,
    /// The lengths of the parameters that a task with this AK can write.
    pub lengths: &'static [usize],
    /// The value, right-aligned.
    pub value: [u8; 4],
}

/// The parameter channel of a device.
#[derive(Clone, Debug)]
pub struct ParameterChannel {
    rules: &'static ChannelRules,
    /// The present request; AK 0 for none.
    request: Request,
    /// The octets of the last cycle: the same ones again change nothing, which is the usual cycle.
    octets: [u8; OCTETS],
    answer: [u8; OCTETS],
}

impl ParameterChannel {
    /// A channel without a request.
    #[must_use]
    pub fn new(rules: &'static ChannelRules) -> Self {
        Self { rules, request: Request::default(), octets: [0; OCTETS], answer: [0; OCTETS] }
    }

    /// Accepts the octets of this cycle. Returns a write that has to be executed now; the caller passes its result to
    /// [`set_result`](Self::set_result).
    ///
    /// Where the manual asks for AK 0 between two requests, a changed request without it is ignored and the old answer
    /// stays.
    pub fn accept(&mut self, octets: [u8; OCTETS]) -> Option<WriteTask> {
        if octets == self.octets {
            return None;
        }
        self.octets = octets;
        let request = Request::new(octets, self.rules);
        if !self.is_new(&request) {
            return None;
        }
        let is_idle = request.ak() == AK_NO_TASK;
        self.request = request;
        self.put(AK_NO_TASK, [0; 4]);
        match self.task() {
            Some(Task::Write(write)) => return Some(write),
            None if !is_idle => self.set_result(Err(AccessError::UnknownTask)),
            Some(Task::Read { .. }) | None => {}
        }
        None
    }

    /// Whether [`accept`](Self::accept) would change nothing with these octets.
    #[must_use]
    pub fn keeps(&self, octets: [u8; OCTETS]) -> bool {
        octets == self.octets || !self.is_new(&Request::new(octets, self.rules))
    }

    /// Whether a request takes the place of the present one.
    fn is_new(&self, request: &Request) -> bool {
        let must_wait = request.ak() != AK_NO_TASK && self.request.ak() != AK_NO_TASK && self.rules.needs_idle_between;
        *request != self.request && !must_wait
    }

    /// The task of the present request.
    #[must_use]
    pub fn task(&self) -> Option<Task> {
        let Request([_, slot, index, _, value @ ..]) = self.request;
        if self.request.ak() == AK_NO_TASK {
            return None;
        }
        Some(match self.rules.task(self.request.ak())? {
            TaskKind::Read => Task::Read { slot, index },
            TaskKind::Write(lengths) => Task::Write(WriteTask { slot, index, lengths, value }),
        })
    }

    /// Sets the answer to the result of the task: the octets of the parameter, or an error.
    pub fn set_result(&mut self, result: Result<&[u8], AccessError>) {
        match result.and_then(ak_and_value) {
            Ok((ak, value)) => self.put(ak, value),
            Err(error) => self.put(AK_ERROR, u32::from(self.rules.error_code(error)).to_be_bytes()),
        }
    }

    /// The octets that the device sends in this cycle.
    #[must_use]
    pub const fn answer(&self) -> &[u8; OCTETS] {
        &self.answer
    }

    /// Slot and index are those of the request, unused octets are 0: errata-bpg-bcg-tpg 24.
    fn put(&mut self, ak: u8, [a, b, c, d]: [u8; 4]) {
        let Request([_, slot, index, ..]) = self.request;
        self.answer = [ak << 4, slot, index, 0, a, b, c, d];
    }
}

/// AK and value of a parameter, right-aligned. Three octets are sent as a double word: errata-bpg-bcg-tpg 20.
fn ak_and_value(octets: &[u8]) -> Result<(u8, [u8; 4]), AccessError> {
    Ok(match *octets {
        [d] => (AK_BYTE, [0, 0, 0, d]),
        [c, d] => (AK_WORD, [0, 0, c, d]),
        [b, c, d] => (AK_DOUBLE_WORD, [0, b, c, d]),
        [a, b, c, d] => (AK_DOUBLE_WORD, [a, b, c, d]),
        _ => return Err(AccessError::WrongLength),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The IF300P board: no byte write, no rest between tasks, fewer codes. errata-bpg-bcg-tpg 133, 148, 153.
    static CONTROLLER: ChannelRules = ChannelRules {
        tasks: &[(1, TaskKind::Read), (2, TaskKind::Write(&[1, 2])), (3, TaskKind::Write(&[4]))],
        needs_idle_between: false,
        error_codes: &[(AccessError::UnknownTask, 17)],
    };

    const fn write(slot: u8, index: u8, lengths: &'static [usize], value: [u8; 4]) -> Option<WriteTask> {
        Some(WriteTask { slot, index, lengths, value })
    }

    /// The threshold example of the IF300P manual, corrected.
    #[test]
    fn a_controller_executes_one_task_after_the_other_without_ak_0() {
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
        for (request, task, octets, answer) in steps {
            assert_eq!(channel.accept(request), task);
            channel.set_result(Ok(octets));
            assert_eq!(channel.answer(), &answer);
            assert_eq!(channel.accept(request), None, "the repeated request is executed once");
            assert_eq!(channel.answer(), &answer);
        }
        // The lower nibble of the first octet and unused octets do not make another request.
        assert_eq!(channel.accept([0x2F, 0x0A, 0x17, 9, 9, 9, 0, 3]), None);
        assert_eq!(channel.accept([0xA0, 0x0A, 0x17, 0, 0, 0, 0, 3]), None);
        assert_eq!(channel.answer(), &[0x70, 0x0A, 0x17, 0, 0, 0, 0, 17], "no byte write");
    }

    #[test]
    fn a_read_task_lasts_until_the_master_withdraws_it() {
        let mut channel = ParameterChannel::new(&CONTROLLER);
        assert_eq!(channel.task(), None);
        assert_eq!(channel.accept([0x10, 1, 20, 0, 0, 0, 0, 0]), None);
        assert_eq!(channel.task(), Some(Task::Read { slot: 1, index: 20 }));
        assert_eq!(channel.answer(), &[0x00, 1, 20, 0, 0, 0, 0, 0], "not answered yet");
        channel.set_result(Ok(&[1, 2]));
        assert_eq!(channel.answer(), &[0x10, 1, 20, 0, 0, 0, 1, 2]);
        assert_eq!(channel.accept([0x10, 1, 20, 0, 9, 9, 9, 9]), None, "a read has no value");
        assert_eq!(channel.answer(), &[0x10, 1, 20, 0, 0, 0, 1, 2]);
        assert_eq!(channel.accept([0; 8]), None);
        assert_eq!((channel.task(), channel.answer()), (None, &[0; 8]));
    }

    #[test]
    fn a_parameter_of_five_octets_does_not_fit_into_the_channel() {
        let mut channel = ParameterChannel::new(&CONTROLLER);
        channel.accept([0x10, 1, 20, 0, 0, 0, 0, 0]);
        channel.set_result(Ok(&[0; 5]));
        assert_eq!(channel.answer(), &[0x70, 1, 20, 0, 0, 0, 0, 5]);
    }
}
