//! What the live stream shows.

use serde::Serialize;
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// The state of all stations at one moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct State {
    /// The time of the archive, in milliseconds since 1970.
    pub now_ms: i64,
    /// Why the rest is old: the database does not answer.
    pub problem: Option<String>,
    /// The stations, by name.
    pub stations: BTreeMap<String, StationState>,
    /// The latest reading of each series, by station and series: `hall-1/chamber`.
    pub readings: BTreeMap<String, LatestReading>,
    /// Alarms that are not normal, by station and alarm: `hall-1/chamber limit`.
    pub alarms: BTreeMap<String, ActiveAlarm>,
    /// The number of such alarms beyond the list.
    pub not_listed: i64,
}

/// A station as the archive knows it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct StationState {
    /// Its plant.
    pub plant: String,
    /// When its database began, in microseconds since 1970.
    #[serde(skip)]
    pub epoch: i64,
    /// When it made its last batch by its own clock, in milliseconds since 1970; `null` before the first one.
    pub made_ms: Option<i64>,
    /// When the archive stored its last batch, in milliseconds since 1970.
    pub stored_ms: Option<i64>,
}

/// The latest reading of a series.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct LatestReading {
    /// The station.
    pub station: String,
    /// The series: the name of a gauge, or `gauge.N` for channel N of a controller.
    pub series: String,
    /// When it was measured, in milliseconds since 1970.
    pub at_ms: i64,
    /// The pressure in Pa; `null` unless the reading is valid.
    pub pa: Option<f64>,
    /// The end of the range that the pressure is beyond, in Pa.
    pub limit_pa: Option<f64>,
    /// The quality: `valid`, `overrange`, `underrange`, `fault`, `stale`, `off`, `missing` or `assumed`.
    #[schema(example = "valid")]
    pub quality: &'static str,
}

/// An alarm that is not normal.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct ActiveAlarm {
    /// The plant.
    pub plant: String,
    /// The station.
    pub station: String,
    /// The name of the alarm.
    pub alarm: String,
    /// The state: `unacknowledged`, `acknowledged`, `returned`, `shelved`, `out-of-service` or `suppressed`.
    pub state: String,
    /// The priority: `high`, `medium` or `low`.
    pub priority: String,
    /// The number of the occurrence, which an acknowledgement names.
    pub occurrence: i64,
    /// The gauge or the segment that the alarm is about.
    pub subject: Option<String>,
    /// When the state began, in milliseconds since 1970.
    pub at_ms: i64,
    /// The user who brought it into this state.
    pub user: Option<String>,
    /// What happened, in a sentence.
    pub text: String,
}
