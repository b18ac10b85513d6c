//! Parameters that pass in the parameter channel, on MS1 and on MS2: octets with their location; text is composed when it is shown.

use profivac_devices::model::{Field, TaskKind, Telegram};
use profivac_dp::link::BitTime;
use profivac_explain::cycle::Request;
use profivac_explain::names::DeviceTables;
use profivac_wire::Sap;
use profivac_wire::acyclic::{Access, Request as Pdu, Response, Transfer};
use serde::Serialize;

/// The number of parameters of a slave that are kept; the one that passed first leaves.
pub const MAX_PARAMETERS: usize = 64;

/// The number of requests of a slave that wait for their response: one on MS1, and one on each MS2 connection.
const MAX_PENDING: usize = 8;

/// The access path of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Path {
    /// The parameter channel of the cyclic data.
    ParameterChannel,
    /// MS1.
    Ms1,
    /// MS2.
    Ms2,
}

impl Path {
    /// The words for users.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::ParameterChannel => "parameter channel",
            Self::Ms1 => "MS1",
            Self::Ms2 => "MS2",
        }
    }
}

/// What a master did with a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Done {
    /// It was read.
    Read,
    /// It was written.
    Written,
    /// The slave refused.
    Refused,
}

/// A parameter that passed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Passed {
    /// Slot and index.
    pub location: (u8, u8),
    /// The value; empty if the slave refused to read it.
    pub octets: Vec<u8>,
    /// The master that asked.
    pub requester: u8,
    /// The access path.
    pub path: Path,
    /// The result.
    pub done: Done,
    /// When it passed last.
    pub at: BitTime,
}

/// A request that waits for its response.
#[derive(Clone, Debug)]
struct Pending {
    /// The access point of the slave; `None` for MS1.
    connection: Option<u8>,
    requester: u8,
    location: (u8, u8),
    /// The value of a write request.
    written: Option<Vec<u8>>,
}

/// The parameters of one slave.
#[derive(Clone, Debug, Default)]
pub struct Parameters {
    passed: Vec<Passed>,
    pending: Vec<Pending>,
    /// The last task in the parameter channel, its master, and whether its answer passed.
    task: [u8; 8],
    task_master: u8,
    task_is_answered: bool,
}

/// AK of an answer in the parameter channel (errata-bpg-bcg-tpg 24).
const NOTHING: u8 = 0;
const WORD: u8 = 1;
const REFUSED: u8 = 7;
const BYTE: u8 = 11;

impl Parameters {
    /// The parameters that passed, in the order of their first time.
    #[must_use]
    pub fn passed(&self) -> &[Passed] {
        &self.passed
    }

    /// Whether requests without a response are within their bounds.
    #[cfg(test)]
    pub(crate) fn is_bounded(&self) -> bool {
        let longest = self.pending.iter().filter_map(|pending| pending.written.as_ref()).map(Vec::len).max();
        self.pending.len() <= MAX_PENDING && longest.unwrap_or(0) <= 246
    }

    /// Records a request on MS1 or MS2.
    pub fn request(&mut self, request: &Request) {
        let (location, written) = match Pdu::parse(&request.du) {
            Ok(Pdu::Read(Access { slot, index, .. })) => ((slot, index), None),
            Ok(Pdu::Write(Transfer { slot, index, data })) => ((slot, index), Some(data.to_vec())),
            _ => return,
        };
        let connection = connection(request.sap);
        self.pending.retain(|pending| pending.connection != connection);
        if self.pending.len() >= MAX_PENDING {
            self.pending.remove(0);
        }
        self.pending.push(Pending { connection, requester: request.master, location, written });
    }

    /// Records an answer on MS1 or MS2. Returns the parameter that it completes.
    pub fn answer(&mut self, request: &Request, du: &[u8], at: BitTime) -> Option<&Passed> {
        let connection = connection(request.sap);
        let path = if connection.is_some() { Path::Ms2 } else { Path::Ms1 };
        let response = Response::parse(du).ok()?;
        let position = self.pending.iter().position(|pending| pending.connection == connection);
        let known = position.map(|position| self.pending.swap_remove(position));
        let requester = known.as_ref().map_or(request.master, |pending| pending.requester);
        let (location, octets, done) = match response {
            Response::Read(Transfer { slot, index, data }) => ((slot, index), data.to_vec(), Done::Read),
            Response::Write(Access { slot, index, .. }) => {
                let known = known.filter(|pending| pending.location == (slot, index));
                ((slot, index), known.and_then(|pending| pending.written).unwrap_or_default(), Done::Written)
            }
            Response::Negative(_) => {
                let known = known?;
                (known.location, known.written.unwrap_or_default(), Done::Refused)
            }
            _ => return None,
        };
        self.add(Passed { location, octets, requester, path, done, at })
    }

    /// Records the outputs of a master.
    pub fn outputs(&mut self, telegram: &'static Telegram, master: u8, du: &[u8]) {
        let Some(channel) = channel(telegram, du) else { return };
        if channel != self.task || master != self.task_master {
            (self.task, self.task_master, self.task_is_answered) = (channel, master, false);
        }
    }

    /// Records inputs. Returns the parameter whose task they answer.
    pub fn inputs(
        &mut self,
        telegram: &'static Telegram,
        tables: &DeviceTables,
        du: &[u8],
        at: BitTime,
    ) -> Option<&Passed> {
        if self.task_is_answered {
            return None;
        }
        let [pke, slot, index, _, value @ ..] = channel(telegram, du)?;
        let [task_pke, task_slot, task_index, _, task_value @ ..] = self.task;
        let (ak, task) = (pke >> 4, task_pke >> 4);
        if ak == NOTHING || task == NOTHING || (slot, index) != (task_slot, task_index) {
            return None;
        }
        let kind = tables.model.and_then(|model| model.channel_rules.task(task));
        let length = match (ak, kind) {
            (BYTE, _) => 1,
            (WORD, _) => 2,
            (_, Some(TaskKind::Write(lengths))) => lengths.iter().copied().max().unwrap_or(4).min(4),
            _ => 4,
        };
        let (source, done) = match kind {
            _ if ak == REFUSED => (&[][..], Done::Refused),
            Some(TaskKind::Write(_)) => (&task_value[..], Done::Written),
            _ => (&value[..], Done::Read),
        };
        let octets = source.get(source.len().saturating_sub(length)..).unwrap_or_default().to_vec();
        self.task_is_answered = true;
        let requester = self.task_master;
        self.add(Passed { location: (slot, index), octets, requester, path: Path::ParameterChannel, done, at })
    }

    fn add(&mut self, passed: Passed) -> Option<&Passed> {
        let same = |other: &Passed| {
            (other.location, other.path, other.requester) == (passed.location, passed.path, passed.requester)
        };
        let position = self.passed.iter().position(same);
        if let Some(position) = position {
            self.passed.remove(position);
        } else if self.passed.len() >= MAX_PARAMETERS {
            self.passed.remove(0);
        }
        self.passed.push(passed);
        self.passed.last()
    }
}

/// The access point of the slave; `None` for MS1.
const fn connection(sap: Sap) -> Option<u8> {
    match sap {
        Sap::Ms2(connection) => Some(connection),
        _ => None,
    }
}

fn channel(telegram: &'static Telegram, du: &[u8]) -> Option<[u8; 8]> {
    let (start, _) = telegram.layout().find(|(_, field)| *field == Field::ParameterChannel)?;
    du.get(start..)?.get(..8)?.try_into().ok()
}
