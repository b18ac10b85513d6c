//! The state of a line as text and numbers, for tables, JSON and an API.

use crate::counts::Counts;
use crate::event::EventKind;
use crate::gauge::{Origin, Unknown};
use crate::histogram::Histogram;
use crate::observer::Observer;
use crate::parameters::{Done, Path};
use crate::station::{Station, StationState};
use profivac_dp::link::{Baud, BitTime};
use serde::Serialize;

/// The number of events in a report.
const SHOWN_EVENTS: usize = 100;

/// The state of a line.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct BusReport {
    /// The baud rate in bit/s.
    pub baud: u32,
    /// For how long the line was observed, in milliseconds of bus time.
    pub observed_ms: u64,
    /// Valid telegrams.
    pub telegrams: u64,
    /// Octets of telegrams and of damaged pieces.
    pub octets: u64,
    /// Damaged pieces.
    pub damaged: u64,
    /// Damaged pieces of the last minute.
    pub damaged_last_minute: u64,
    /// Damaged pieces that belong to no station that is known.
    pub damaged_unattributed: u64,
    /// The memory that the flight recorder of the line has taken, in octets; 0 without one.
    pub recorder_octets: u64,
    /// The masters in the order of the token.
    pub ring: Vec<u8>,
    /// The duration of the cycles of all masters.
    pub cycle: Distribution,
    /// The time between two tokens to the same master.
    pub rotation: Distribution,
    /// The masters.
    pub masters: Vec<MasterReport>,
    /// The live list, by address.
    pub stations: Vec<StationReport>,
    /// The parameters that passed.
    pub parameters: Vec<ParameterReport>,
    /// The last events, newest first.
    pub events: Vec<EventReport>,
}

/// Durations.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Distribution {
    /// The number of durations.
    pub count: u64,
    /// Their sum in microseconds, which never decreases. Not in JSON, which has the mean.
    #[serde(skip)]
    pub sum_us: u64,
    /// The shortest in microseconds.
    pub min_us: Option<u64>,
    /// The mean in microseconds.
    pub mean_us: Option<u64>,
    /// An upper bound of 99 % of the durations in microseconds.
    pub p99_us: Option<u64>,
    /// The longest in microseconds.
    pub max_us: Option<u64>,
    /// The buckets that have durations, a quarter of an octave each.
    pub buckets: Vec<Bucket>,
}

/// A bucket of durations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Bucket {
    /// Its end in microseconds.
    pub end_us: u64,
    /// The number of durations.
    pub count: u64,
}

/// A master.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct MasterReport {
    /// Its address.
    pub address: u8,
    /// The duration of its cycles.
    pub cycle: Distribution,
    /// The time between two tokens.
    pub rotation: Distribution,
}

/// A station of the live list.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct StationReport {
    /// Its address.
    pub address: u8,
    /// Its state.
    pub state: StationState,
    /// The devices with its Ident_Number, or the one that the file names; empty if it is not known.
    pub devices: Vec<String>,
    /// Its Ident_Number, if a telegram showed it: `0x08E6`.
    pub ident: Option<String>,
    /// The address of its owner, if a diagnosis showed it.
    pub owner: Option<u8>,
    /// Where the configuration comes from; `null` without a gauge.
    pub configuration_origin: Option<Origin>,
    /// The unit of its pressures.
    pub unit: Option<String>,
    /// Where the unit comes from.
    pub unit_origin: Option<Origin>,
    /// Counters since the beginning.
    pub total: Counts,
    /// Counters of the last minute.
    pub last_minute: Counts,
    /// Repetitions of the last minute in percent of its requests.
    pub repeated_percent: f64,
    /// The longest sequence of repetitions of one request.
    pub longest_sequence: u32,
    /// What its last diagnosis reports.
    pub diagnosis: Vec<String>,
    /// Its earlier diagnoses, newest first.
    pub diagnosis_history: Vec<DiagnosisReport>,
    /// The time between two Data_Exchange requests to it.
    pub interval: Distribution,
    /// What the traffic has not shown.
    pub unknown: Vec<String>,
}

/// An earlier diagnosis.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct DiagnosisReport {
    /// How long ago it was fetched, in milliseconds.
    pub age_ms: u64,
    /// What it reports.
    pub reports: Vec<String>,
}

/// A parameter that passed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ParameterReport {
    /// The slave.
    pub address: u8,
    /// The master that asked.
    pub requester: u8,
    /// The access path.
    pub path: Path,
    /// The result.
    pub done: Done,
    /// The name of the parameter with its numbers.
    pub name: String,
    /// The value; empty if the slave refused.
    pub value: String,
    /// How long ago it passed, in milliseconds.
    pub age_ms: u64,
}

/// An event.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct EventReport {
    /// Its number, counted from 1.
    pub number: u64,
    /// How long ago, in milliseconds.
    pub age_ms: u64,
    /// The station; `null` for the line.
    pub station: Option<u8>,
    /// The subject.
    pub kind: EventKind,
    /// The sentence.
    pub text: String,
}

impl BusReport {
    /// The state of the line that `observer` has observed.
    #[must_use]
    pub fn of(observer: &Observer) -> Self {
        let (baud, now, totals) = (observer.baud(), observer.now(), observer.totals());
        let masters = observer.stations().filter(|(_, station)| station.master_at.is_some());
        let master = |(address, station): (u8, &Station)| MasterReport {
            address,
            cycle: Distribution::of(&station.cycle, baud),
            rotation: Distribution::of(&station.rotation, baud),
        };
        let age_ms = |at: BitTime| ms_of(baud, now - at);
        let event = |event: &crate::event::Event| EventReport {
            number: event.number,
            age_ms: age_ms(event.at),
            station: event.station,
            kind: event.kind(),
            text: event.to_string(),
        };
        Self {
            baud: observer.line_baud().bits_per_second(),
            observed_ms: ms_of(baud, observer.observed_tbit()),
            telegrams: totals.telegrams,
            octets: totals.octets,
            damaged: totals.damaged,
            damaged_last_minute: observer.damaged_last_minute(),
            damaged_unattributed: totals.unattributed,
            recorder_octets: 0,
            ring: observer.ring().to_vec(),
            cycle: Distribution::of(observer.cycle(), baud),
            rotation: Distribution::of(observer.rotation(), baud),
            masters: masters.map(master).collect(),
            stations: observer
                .stations()
                .filter_map(|(address, station)| StationReport::of(observer, address, station))
                .collect(),
            parameters: parameters(observer),
            events: observer.events().iter().rev().take(SHOWN_EVENTS).map(event).collect(),
        }
    }
}

/// Whole milliseconds.
fn ms_of(baud: Baud, tbit: u64) -> u64 {
    us_of(baud, tbit) / 1000
}

fn us_of(baud: Baud, tbit: u64) -> u64 {
    let us = u128::from(tbit).saturating_mul(1_000_000) / u128::from(baud.bits_per_second());
    u64::try_from(us).unwrap_or(u64::MAX)
}

impl Distribution {
    /// The durations of a histogram.
    #[must_use]
    pub fn of(histogram: &Histogram, baud: Baud) -> Self {
        let us = |tbit| us_of(baud, tbit);
        let range = histogram.range_tbit();
        Self {
            count: histogram.count(),
            sum_us: us(histogram.sum_tbit()),
            min_us: range.map(|(least, _)| us(least)),
            mean_us: histogram.mean_tbit().map(us),
            p99_us: histogram.percentile_tbit(99).map(us),
            max_us: range.map(|(_, greatest)| us(greatest)),
            buckets: histogram.buckets().map(|(end, count)| Bucket { end_us: us(end), count }).collect(),
        }
    }
}

impl StationReport {
    fn of(observer: &Observer, address: u8, station: &Station) -> Option<Self> {
        let (now, baud) = (observer.now(), observer.baud());
        let state = match station.state(now, baud) {
            Some(state) => state,
            None if station.knowledge.is_declared() => StationState::NotAddressed,
            None => return None,
        };
        let facts = station.knowledge.facts(address);
        let ident = station.knowledge.ident();
        let devices = match (facts, ident) {
            (Some(facts), _) if facts.model != Origin::Assumed => vec![facts.slave.model.name.to_owned()],
            (_, Some(ident)) => match station.described.devices() {
                known if known.knows(ident) => known.names_with_ident(ident).map(str::to_owned).collect(),
                _ => station.described.models(),
            },
            (_, None) => station.knowledge.model().into_iter().map(|(model, _)| model.name.to_owned()).collect(),
        };
        let last_minute = station.counts.last_minute(now);
        let mut diagnoses = station.diagnoses.iter().rev();
        let diagnosis = diagnoses.next().map(|diagnosis| diagnosis.reports.clone()).unwrap_or_default();
        let history = diagnoses.map(|diagnosis| DiagnosisReport {
            age_ms: ms_of(baud, now - diagnosis.at),
            reports: diagnosis.reports.clone(),
        });
        let is_slave = !matches!(state, StationState::Master);
        Some(Self {
            address,
            state,
            devices,
            ident: ident.map(|ident| format!("0x{ident:04X}")),
            owner: station.owner(),
            configuration_origin: facts.map(|facts| facts.configuration),
            unit: facts.map(|facts| facts.slave.unit.name.to_owned()),
            unit_origin: facts.map(|facts| facts.unit),
            total: *station.counts.total(),
            last_minute,
            repeated_percent: last_minute.repeated_percent(),
            longest_sequence: station.longest_sequence,
            diagnosis,
            diagnosis_history: history.collect(),
            interval: Distribution::of(&station.interval, baud),
            unknown: if is_slave && station.master_at.is_none() {
                texts(&station.knowledge.unknown())
            } else {
                Vec::new()
            },
        })
    }
}

fn texts(unknown: &[Unknown]) -> Vec<String> {
    unknown.iter().map(ToString::to_string).collect()
}

fn parameters(observer: &Observer) -> Vec<ParameterReport> {
    let (now, baud) = (observer.now(), observer.baud());
    let of_station = |(address, station): (u8, &Station)| {
        let report = |passed: &crate::parameters::Passed| {
            let (name, value) = observer.parameter_text(address, passed);
            let (requester, path, done) = (passed.requester, passed.path, passed.done);
            ParameterReport { address, requester, path, done, name, value, age_ms: ms_of(baud, now - passed.at) }
        };
        station.parameters.passed().iter().map(report).collect::<Vec<_>>()
    };
    observer.stations().flat_map(of_station).collect()
}
