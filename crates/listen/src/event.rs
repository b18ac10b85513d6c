//! Events: one change on the line each, as data; their texts are sentences. The list is bounded, the oldest events leave it.

use crate::gauge::Contradiction;
use crate::parameters::Path;
use profivac_dp::link::BitTime;
use profivac_explain::cycle::status_text;
use profivac_sim::describe::Hex;
use profivac_wire::control::Status;
use serde::Serialize;
use std::collections::VecDeque;
use std::fmt;

/// The number of events that are kept.
pub const MAX_EVENTS: usize = 512;

/// The subject of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum EventKind {
    /// A station does not answer any more.
    Lost,
    /// A station answers again, or for the first time.
    Returned,
    /// Parameters or configuration of a slave, sent by a master.
    Configuration,
    /// The owner of a slave.
    Owner,
    /// The diagnosis of a slave.
    Diagnosis,
    /// A slave refuses a service.
    Refused,
    /// A parameter was written.
    Parameter,
    /// Many damaged telegrams in a short time.
    Burst,
    /// The token ring.
    Ring,
}

/// A change of a station, or of the line.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Change {
    /// The station answers for the first time.
    Appeared,
    /// The station answers again.
    Returned {
        /// The requests without an answer before.
        unanswered: u32,
    },
    /// The station does not answer any more.
    Lost,
    /// The slave refuses Data_Exchange.
    ExchangeRefused(Status),
    /// The diagnosis of the slave reports other conditions than before; none if the list is empty.
    Diagnosis(Vec<String>),
    /// The owner in the diagnosis of the slave; `None` if it has none any more.
    Owner(Option<u8>),
    /// A master has parameterised the slave.
    Parameterised {
        /// The master.
        master: u8,
        /// The data unit of Set_Prm.
        octets: Vec<u8>,
        /// The data unit beside the one before.
        comparison: Comparison,
    },
    /// A master asks the slave for a configuration other than the known one.
    Configured {
        /// The master.
        master: u8,
        /// The octets of Chk_Cfg.
        octets: Vec<u8>,
        /// No configuration was known.
        is_first: bool,
    },
    /// The file says something else about the slave than the line shows.
    Contradiction(Contradiction),
    /// A parameter was written.
    Written {
        /// The master.
        master: u8,
        /// The name of the parameter in the tables of the device, with its numbers.
        name: String,
        /// The value, with the unit and the words of the tables.
        value: String,
        /// The access path.
        path: Path,
    },
    /// This number of damaged telegrams came within a second.
    Burst(u32),
    /// The masters in the order of the token.
    Ring(Vec<u8>),
}

/// A data unit beside the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// None was heard before.
    First,
    /// It is the same.
    Same,
    /// It is another one.
    Other,
}

impl Change {
    /// The subject of the change.
    #[must_use]
    pub const fn kind(&self) -> EventKind {
        match self {
            Self::Lost => EventKind::Lost,
            Self::Appeared | Self::Returned { .. } => EventKind::Returned,
            Self::Parameterised { .. } | Self::Configured { .. } | Self::Contradiction(_) => EventKind::Configuration,
            Self::Owner(_) => EventKind::Owner,
            Self::Diagnosis(_) => EventKind::Diagnosis,
            Self::ExchangeRefused(_) => EventKind::Refused,
            Self::Written { .. } => EventKind::Parameter,
            Self::Burst(_) => EventKind::Burst,
            Self::Ring(_) => EventKind::Ring,
        }
    }
}

/// A change on the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// The number of the event, counted from 1.
    pub number: u64,
    /// When.
    pub at: BitTime,
    /// The station; `None` for the line.
    pub station: Option<u8>,
    /// The change.
    pub change: Change,
}

impl Event {
    /// The subject of the change.
    #[must_use]
    pub const fn kind(&self) -> EventKind {
        self.change.kind()
    }
}

impl fmt::Display for Event {
    /// The change as a sentence.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A change of the line names no station.
        let station = self.station.unwrap_or_default();
        match &self.change {
            Change::Appeared => write!(f, "station {station} answers"),
            Change::Returned { unanswered } => {
                write!(f, "station {station} answers again after {unanswered} unanswered requests")
            }
            Change::Lost => write!(f, "station {station} does not answer any more"),
            Change::ExchangeRefused(status) => {
                write!(f, "station {station} refuses to exchange data: {}", status_text(*status))
            }
            Change::Diagnosis(reports) if reports.is_empty() => {
                write!(f, "the diagnosis of station {station} reports nothing")
            }
            Change::Diagnosis(reports) => {
                write!(f, "the diagnosis of station {station} reports {}", reports.join("; "))
            }
            Change::Owner(None) => write!(f, "station {station} has no owner any more"),
            Change::Owner(Some(owner)) => write!(f, "station {station} belongs to master {owner}"),
            Change::Parameterised { master, octets, comparison } => match comparison {
                Comparison::First => write!(f, "master {master} sets parameters of station {station}"),
                Comparison::Same => write!(f, "master {master} sets the same parameters of station {station} again"),
                Comparison::Other => {
                    write!(f, "master {master} sets other parameters of station {station} than before: {}", Hex(octets))
                }
            },
            Change::Configured { master, octets, is_first } => {
                let other = if *is_first { "the" } else { "another" };
                write!(f, "master {master} asks station {station} for {other} configuration {}", Hex(octets))
            }
            Change::Contradiction(contradiction) => write!(f, "station {station}: {contradiction}"),
            Change::Written { master, name, value, path } => {
                write!(f, "master {master} writes {name} = {value} of station {station} ({})", path.text())
            }
            Change::Burst(count) => write!(f, "{count} damaged telegrams within a second"),
            Change::Ring(ring) => match ring[..] {
                [alone] => write!(f, "master {alone} is alone in the token ring"),
                _ => write!(f, "token ring: {}", ring.iter().map(ToString::to_string).collect::<Vec<_>>().join(" -> ")),
            },
        }
    }
}

/// The last events.
#[derive(Clone, Debug, Default)]
pub struct Events {
    list: VecDeque<Event>,
    count: u64,
}

impl Events {
    /// Adds an event.
    pub fn add(&mut self, at: BitTime, station: Option<u8>, change: Change) {
        self.count = self.count.saturating_add(1);
        if self.list.len() >= MAX_EVENTS {
            self.list.pop_front();
        }
        self.list.push_back(Event { number: self.count, at, station, change });
    }

    /// The events that are kept, oldest first.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &Event> {
        self.list.iter()
    }

    /// The kept events behind the one with this number.
    pub fn since(&self, number: u64) -> impl Iterator<Item = &Event> {
        // The numbers of the kept events are consecutive: the cost is that of the new events.
        let new = usize::try_from(self.count.saturating_sub(number)).unwrap_or(usize::MAX);
        self.list.iter().skip(self.list.len().saturating_sub(new))
    }

    /// The number of the last event; 0 without events.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }
}
