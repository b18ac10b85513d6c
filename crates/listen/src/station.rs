//! The state of one station as the traffic shows it.

use crate::counts::CountsOverTime;
use crate::gauge::{Contradiction, Knowledge};
use crate::histogram::Histogram;
use crate::parameters::Parameters;
use profivac_dp::link::{Baud, BitTime};
use profivac_explain::cycle::Request;
use profivac_explain::dpv1::{DeviceBlocks, Dpv1Traffic};
use profivac_explain::gsd::{Described, Files};
use profivac_explain::names::DeviceTables;
use profivac_explain::slave::diagnosis_reports;
use profivac_wire::diag::{NO_MASTER, SlaveDiag, StationStatus};
use serde::Serialize;
use std::collections::VecDeque;

/// The number of diagnoses of a station that are kept.
pub const MAX_DIAGNOSES: usize = 16;

/// A station that was silent for this time is not present any more. chosen: many times the rotation of a slow ring, and less than
/// the time in which an operator expects a change.
const SILENCE_MS: u64 = 3000;

/// The same for the last unanswered request to a gauge of the station's file, which its station searches every few seconds. chosen: three
/// searches of a station.
const SEARCHED_MS: u64 = 10_000;

/// The number of unanswered requests in a row after which a station is missing. chosen: a master sends a request twice by default.
pub const MISSING_AFTER: u32 = 2;

/// The state of a station in the live list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum StationState {
    /// A master: it has sent a request or a token in the last three seconds, or has answered FDL status as one.
    Master,
    /// A slave whose last Data_Exchange had a valid answer, in the last three seconds.
    Exchanging,
    /// A station that has not answered the last two requests or more, or a master that has not sent for three seconds.
    Missing,
    /// A slave that answers the requests of a start-up, of its master or of another one, and does not exchange data.
    NotConfigured,
    /// A slave that answers and that no class 1 master addresses.
    NoMaster,
    /// A station that no master has addressed for three seconds. Whether it is present is unknown.
    NotAddressed,
}

impl StationState {
    /// The words for users.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Master => "master",
            Self::Exchanging => "exchanging",
            Self::Missing => "missing",
            Self::NotConfigured => "not configured",
            Self::NoMaster => "present without a master",
            Self::NotAddressed => "not addressed",
        }
    }
}

/// The last request to a station.
#[derive(Clone, Debug)]
pub struct LastRequest {
    /// The request. Its buffer is used again for the next one.
    pub request: Request,
    /// The number of its telegram, counted from the first one.
    pub number: u64,
    /// The number of damaged pieces outside of answers when it was sent: an equal frame count bit after another one shows nothing.
    pub damage_epoch: u64,
    /// It has a valid answer.
    pub is_answered: bool,
    /// The number of repetitions so far.
    pub repetitions: u32,
}

/// The diagnosis of a slave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnosis {
    /// When it was fetched first with these contents.
    pub at: BitTime,
    /// What it reports; empty if nothing.
    pub reports: Vec<String>,
}

/// A station.
#[derive(Clone, Debug)]
pub struct Station {
    /// Counters of the requests to it.
    pub counts: CountsOverTime,
    /// The longest sequence of repetitions of one request.
    pub longest_sequence: u32,
    /// The device of a slave.
    pub knowledge: Knowledge,
    /// The contradictions between file and line that events have reported.
    pub contradictions: Vec<Contradiction>,
    /// The tables of its device.
    pub tables: DeviceTables,
    /// The parameters that passed.
    pub parameters: Parameters,
    /// The time between two Data_Exchange requests.
    pub interval: Histogram,
    /// The time between two tokens to a master.
    pub rotation: Histogram,
    /// The duration of the cycles of a master.
    pub cycle: Histogram,
    /// Where the cycle of a master stands.
    pub cycle_state: CycleState,
    /// The last request to it.
    pub last: Option<LastRequest>,
    /// The slave in the words of its GSD file.
    pub described: Described,
    /// The longest time from the end of a request to the answer in bit times, of exact times only.
    pub longest_tsdr: Option<u64>,
    /// The traffic that shows whether it is a DP-V1 slave.
    pub dpv1: Dpv1Traffic,
    /// The last diagnoses with different contents, oldest first.
    pub diagnoses: VecDeque<Diagnosis>,
    /// The octets of the last diagnosis.
    pub diagnosis_octets: Vec<u8>,
    /// The status of the last diagnosis.
    pub status: Option<StationStatus>,
    /// The owner in the last diagnosis.
    pub owner: Option<u8>,
    /// The octets of the last acknowledged Set_Prm.
    pub set_prm: Vec<u8>,
    /// An event has said that it does not answer any more.
    pub is_reported_lost: bool,
    /// It refuses Data_Exchange, and an event has said so.
    pub refuses_exchange: bool,
    /// The number of requests without an answer since the last answer.
    pub unanswered_in_a_row: u32,
    /// When it sent as a master, or answered as one.
    pub master_at: Option<BitTime>,
    /// When it sent anything.
    pub heard_at: Option<BitTime>,
    /// When a class 1 master sent it a request.
    pub wanted_at: Option<BitTime>,
    /// When any master sent it a request.
    pub asked_at: Option<BitTime>,
    /// When its last request of the cycle began.
    pub exchange_requested_at: Option<BitTime>,
    /// When it got the token.
    pub token_at: Option<BitTime>,
    /// Its last Data_Exchange was valid.
    pub is_exchanging: bool,
}

/// Which slaves a master has served in its present cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct CycleState {
    /// A bit for each address.
    pub served: u128,
    /// When the first of them was served.
    pub began: BitTime,
}

impl Station {
    /// A station that has not sent anything.
    #[must_use]
    pub fn new(baud: Baud, files: Files) -> Self {
        Self {
            knowledge: Knowledge::new(files.devices()),
            described: Described::new(files),
            longest_tsdr: None,
            counts: CountsOverTime::new(baud),
            longest_sequence: 0,
            contradictions: Vec::new(),
            tables: DeviceTables::default(),
            parameters: Parameters::default(),
            interval: Histogram::default(),
            rotation: Histogram::default(),
            cycle: Histogram::default(),
            cycle_state: CycleState::default(),
            last: None,
            dpv1: Dpv1Traffic::default(),
            diagnoses: VecDeque::new(),
            diagnosis_octets: Vec::new(),
            status: None,
            owner: None,
            set_prm: Vec::new(),
            is_reported_lost: false,
            refuses_exchange: false,
            unanswered_in_a_row: 0,
            master_at: None,
            heard_at: None,
            wanted_at: None,
            asked_at: None,
            exchange_requested_at: None,
            token_at: None,
            is_exchanging: false,
        }
    }

    /// The state in the live list at `now`; `None` if no telegram shows that there is a station.
    #[must_use]
    pub fn state(&self, now: BitTime, baud: Baud) -> Option<StationState> {
        let silence_tbit = baud.tbit_of_ms(SILENCE_MS);
        let is_recent = |at: Option<BitTime>| at.is_some_and(|at| now - at < silence_tbit);
        let asked_tbit = if self.knowledge.is_declared() { baud.tbit_of_ms(SEARCHED_MS) } else { silence_tbit };
        let is_asked = self.asked_at.is_some_and(|at| now - at < asked_tbit);
        let is_missing = self.unanswered_in_a_row >= MISSING_AFTER;
        Some(match (self.master_at, self.heard_at) {
            (Some(_), heard) if is_recent(heard) && !is_missing => StationState::Master,
            (Some(_), _) => StationState::Missing,
            (None, _) if is_missing && is_asked => StationState::Missing,
            (None, None) => return None,
            (None, heard) if !is_recent(heard) => StationState::NotAddressed,
            (None, Some(_)) if self.is_exchanging && is_recent(self.knowledge.exchanged_at()) => {
                StationState::Exchanging
            }
            (None, Some(_)) if is_recent(self.wanted_at) => StationState::NotConfigured,
            (None, Some(_)) => StationState::NoMaster,
        })
    }

    /// The format of the device-related blocks in its diagnosis.
    #[must_use]
    pub fn device_blocks(&self) -> DeviceBlocks {
        let by_tables = self.knowledge.model().map(|(model, _)| model.features.dpv1);
        self.dpv1.device_blocks(by_tables.or(self.described.dpv1_slave()))
    }

    /// Words the last diagnosis again: the traffic behind it has shown the format of its blocks. The diagnosis of another device keeps its
    /// words.
    pub fn reword_diagnosis(&mut self) {
        let (ident, device_blocks) = (self.knowledge.ident(), self.device_blocks());
        if let (Some(last), Ok(diag)) = (self.diagnoses.back_mut(), SlaveDiag::parse(&self.diagnosis_octets))
            && ident == Some(diag.ident)
        {
            last.reports = diagnosis_reports(&diag, device_blocks, &self.described);
        }
    }

    /// The owner as its diagnosis names it.
    #[must_use]
    pub fn owner(&self) -> Option<u8> {
        self.owner.filter(|owner| *owner != NO_MASTER)
    }
}
