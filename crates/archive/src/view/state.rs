//! What the live stream shows.

use super::visibility::Hidden;
use profivac_model::{AlarmState, Priority, Quality, Word, words};
use profivac_web_server::live_source::{Changes, LiveState};
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
    /// The number of such alarms of each plant, with those beyond the list.
    #[serde(skip)]
    pub alarms_of_plant: BTreeMap<String, i64>,
}

impl State {
    /// The state without these plants.
    pub fn without(mut self, hidden: &Hidden) -> Self {
        self.stations.retain(|_, station| !hidden.contains(&station.plant));
        let stations = &self.stations;
        self.readings.retain(|_, reading| stations.contains_key(&reading.station));
        self.alarms.retain(|_, alarm| !hidden.contains(&alarm.plant));
        self.alarms_of_plant.retain(|plant, _| !hidden.contains(plant));
        let listed = i64::try_from(self.alarms.len()).unwrap_or(i64::MAX);
        self.not_listed = self.alarms_of_plant.values().sum::<i64>().saturating_sub(listed).max(0);
        self
    }
}

impl LiveState for State {
    fn changes_since(&self, before: &Self) -> Changes {
        let Self { now_ms, problem, stations, readings, alarms, not_listed, alarms_of_plant: _ } = self;
        Changes::default()
            .part("now_ms", &before.now_ms, now_ms)
            .part("problem", &before.problem, problem)
            .entries("stations", &before.stations, stations)
            .entries("readings", &before.readings, readings)
            .entries("alarms", &before.alarms, alarms)
            .part("not_listed", &before.not_listed, not_listed)
    }
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
    /// Batches that have not come.
    pub missing: i64,
    /// Batches that were put aside.
    pub put_aside: i64,
    /// Why the last one of them was put aside, in a sentence.
    pub put_aside_reason: Option<String>,
}

/// The latest reading of a series.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct LatestReading {
    /// The station.
    pub station: String,
    /// The series: the name of a gauge, or `gauge.N` for channel N of a controller.
    pub series: String,
    /// When it was measured, or when the time of a mean began, in milliseconds since 1970.
    pub at_ms: i64,
    /// The pressure in Pa; `null` unless the reading is valid.
    pub pa: Option<f64>,
    /// The end of the range that the pressure is beyond, in Pa.
    pub limit_pa: Option<f64>,
    /// The quality.
    #[schema(value_type = profivac_model::quality::schema::Quality)]
    #[serde(serialize_with = "words::serialize")]
    pub quality: Quality,
    /// The milliseconds from `at_ms` on of which `pa` is the geometric mean; `null` for a sample.
    pub mean_of_ms: Option<i64>,
}

/// The shortest spans that a station sends.
const SPAN_MS: i64 = 120_000;

impl LatestReading {
    /// The mean of a span of two minutes. `qualities` has a bit for the number of each quality that a sample of it had; with others than
    /// valid ones the reading has the highest of these, and no pressure: the mean would be that of a part of the time.
    pub fn of_span(station: String, series: String, start_ms: i64, mean_pa: Option<f64>, qualities: i16) -> Self {
        let highest = (0..16_i64).rev().find(|bit| qualities >> bit & 1 == 1);
        let quality = highest.map_or(Quality::Missing, |bit| Quality::from_number(bit).unwrap_or(Quality::Fault));
        let pa = mean_pa.filter(|_| quality == Quality::Valid);
        let mean_of_ms = Some(SPAN_MS);
        Self { station, series, at_ms: start_ms, pa, limit_pa: None, quality, mean_of_ms }
    }
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
    /// The state, which is not `normal`.
    #[schema(value_type = AlarmState)]
    pub state: Word<AlarmState>,
    /// The priority.
    #[schema(value_type = Priority)]
    pub priority: Word<Priority>,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_is_a_reading_that_says_so_and_has_a_pressure_only_if_all_of_it_is_valid() {
        let of = |mean_pa, qualities| {
            LatestReading::of_span("hall-1".to_owned(), "chamber".to_owned(), 7, mean_pa, qualities)
        };
        let valid = of(Some(2.0), 1);
        assert_eq!(
            (valid.at_ms, valid.pa, valid.quality, valid.mean_of_ms),
            (7, Some(2.0), Quality::Valid, Some(120_000))
        );
        for (mean_pa, qualities, quality) in [
            (Some(2.0), 1 | 1 << Quality::Overrange as i16, Quality::Overrange),
            (None, 1 << Quality::Off as i16, Quality::Off),
            (None, 0, Quality::Missing),
            (Some(2.0), 1 | 1 << 14, Quality::Fault),
            (Some(2.0), i16::MIN, Quality::Fault),
        ] {
            let reading = of(mean_pa, qualities);
            assert_eq!((reading.pa, reading.limit_pa, reading.quality), (None, None, quality), "{qualities}");
        }
    }

    #[test]
    fn a_state_without_a_plant_has_none_of_its_rows_and_counts() {
        let station = |plant: &str| StationState {
            plant: plant.to_owned(),
            epoch: 1,
            made_ms: None,
            stored_ms: None,
            missing: 0,
            put_aside: 0,
            put_aside_reason: None,
        };
        let reading = |station: &str| LatestReading {
            station: station.to_owned(),
            series: "chamber".to_owned(),
            at_ms: 1,
            pa: Some(1.0),
            limit_pa: None,
            quality: Quality::Valid,
            mean_of_ms: None,
        };
        let alarm = |plant: &str, station: &str| ActiveAlarm {
            plant: plant.to_owned(),
            station: station.to_owned(),
            alarm: "high".to_owned(),
            state: AlarmState::Unacknowledged.into(),
            priority: Priority::High.into(),
            occurrence: 1,
            subject: None,
            at_ms: 1,
            user: None,
            text: String::new(),
        };
        let both = [("hall", "hall-1"), ("ring", "ring-1")];
        let state = State {
            stations: both.map(|(plant, name)| (name.to_owned(), station(plant))).into(),
            readings: both.map(|(_, name)| (format!("{name}/chamber"), reading(name))).into(),
            alarms: both.map(|(plant, name)| (format!("{name}/high"), alarm(plant, name))).into(),
            alarms_of_plant: [("hall".to_owned(), 1), ("ring".to_owned(), 7)].into(),
            ..State::default()
        };
        assert_eq!(state.clone().without(&Hidden::new()).not_listed, 6);
        let seen = state.without(&["ring".to_owned()].into());
        let shown = serde_json::to_string(&seen).unwrap();
        assert!(
            !shown.contains("ring") && shown.contains("hall-1/chamber") && shown.contains("hall-1/high"),
            "{shown}"
        );
        assert_eq!(seen.not_listed, 0);
    }
}
