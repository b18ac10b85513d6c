//! Readings of the batches that pass through JetStream: the page shows them before the database has them, and also while it is down.

use super::state::{LatestReading, State};
use crate::store::{Accepted, Incoming, accept};
use profivac_recorder::{Micros, Quality, Sample};
use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError, RwLock};

/// Readings that are later than those of the database, by station and series. Clones share them.
///
/// Only series that the database has are taken: a station that invents names does not fill the memory.
#[derive(Clone, Default)]
pub(super) struct Passing {
    readings: Arc<RwLock<BTreeMap<String, LatestReading>>>,
}

impl Passing {
    /// Takes the last sample of each series of a batch. A batch that an archive puts aside changes nothing.
    pub fn take(&self, message: &Incoming, state: &RwLock<State>, now: Micros) {
        let Ok(batch) = accept(message, now) else { return };
        let state = state.read().unwrap_or_else(PoisonError::into_inner);
        if !is_of_its_station(&batch, &state) {
            return;
        }
        let mut readings = self.readings.write().unwrap_or_else(PoisonError::into_inner);
        for (series, samples) in &batch.samples {
            let key = format!("{}/{series}", batch.station);
            let Some(last) = samples.iter().max_by_key(|sample| sample.at) else { continue };
            let shown = readings.get(&key).or_else(|| state.readings.get(&key));
            if shown.is_some_and(|shown| milliseconds(last.at) > shown.at_ms) {
                readings.insert(key, reading(batch.station, series, last));
            }
        }
    }

    /// Brings the later readings into a state from the database.
    pub fn add_to(&self, state: &mut State) {
        for (key, reading) in self.readings.read().unwrap_or_else(PoisonError::into_inner).iter() {
            if let Some(shown) = state.readings.get_mut(key).filter(|shown| shown.at_ms < reading.at_ms) {
                shown.clone_from(reading);
            }
        }
    }

    /// Forgets the readings that the database has, and those of series that it no longer has.
    pub fn forget_stored(&self, state: &State) {
        let mut readings = self.readings.write().unwrap_or_else(PoisonError::into_inner);
        readings.retain(|key, reading| state.readings.get(key).is_some_and(|stored| stored.at_ms < reading.at_ms));
    }
}

/// Whether an archive stores the batch: of two databases under one name, the later one is that of the station.
fn is_of_its_station(batch: &Accepted<'_>, state: &State) -> bool {
    let station = state.stations.get(batch.station);
    station.is_some_and(|station| station.plant == batch.plant && batch.epoch >= station.epoch)
}

/// Milliseconds since 1970, rounded as PostgreSQL does: the same sample has the same time from both.
const fn milliseconds(at: Micros) -> i64 {
    at.0.saturating_add(500).div_euclid(1000)
}

fn reading(station: &str, series: &str, sample: &Sample) -> LatestReading {
    let is_valid = sample.quality == Quality::Valid;
    LatestReading {
        station: station.to_owned(),
        series: series.to_owned(),
        at_ms: milliseconds(sample.at),
        pa: sample.pa.filter(|_| is_valid),
        limit_pa: sample.pa.filter(|_| !is_valid),
        quality: sample.quality,
        mean_of_ms: None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::state::StationState;
    use super::*;
    use profivac_recorder::batch::{Batch, FORMAT, Samples};

    const NOW: Micros = Micros(1_700_000_000 * Micros::SECOND);

    fn sample(after_ms: i64, pa: f64) -> Sample {
        Sample::new(Micros(NOW.0 + after_ms * 1000), Some(pa), Quality::Valid)
    }

    /// A batch of two samples, the later one first.
    fn message(plant: &str, station: &str, epoch: i64, series: &str, after_ms: i64) -> Incoming {
        let samples = vec![Samples::new(series.to_owned(), &[sample(after_ms, 2.0), sample(after_ms - 500, 9.0)])];
        let batch = Batch { format: FORMAT, made_us: NOW.0, samples, ..Batch::default() };
        Incoming {
            subject: format!("profivac.v1.{plant}.{station}.batch"),
            id: format!("{station}/{epoch}/1"),
            payload: batch.encode_compressed().unwrap(),
        }
    }

    /// A station of epoch 5 with one series.
    fn stored() -> State {
        let station = StationState {
            plant: "hall".to_owned(),
            epoch: 5,
            made_ms: None,
            stored_ms: None,
            missing: 0,
            put_aside: 0,
            put_aside_reason: None,
        };
        let of_series = reading("hall-1", "chamber", &sample(0, 1.0));
        State {
            stations: [("hall-1".to_owned(), station)].into(),
            readings: [("hall-1/chamber".to_owned(), of_series)].into(),
            ..State::default()
        }
    }

    fn after(message: &Incoming) -> State {
        let (passing, state) = (Passing::default(), RwLock::new(stored()));
        passing.take(message, &state, NOW);
        let mut state = state.into_inner().unwrap();
        passing.add_to(&mut state);
        state
    }

    #[test]
    fn the_last_sample_of_a_batch_is_shown_before_the_database_has_it() {
        let shown = after(&message("hall", "hall-1", 5, "chamber", 1_000));
        let expected = reading("hall-1", "chamber", &sample(1_000, 2.0));
        assert_eq!(shown.readings["hall-1/chamber"], expected);
        // The station has a new database, which the archive does not have yet.
        assert_eq!(after(&message("hall", "hall-1", 6, "chamber", 1_000)).readings["hall-1/chamber"], expected);
    }

    #[test]
    fn times_are_rounded_as_in_the_database() {
        assert_eq!([499, 500, 1_499, 1_500].map(|us| milliseconds(Micros(us))), [0, 1, 1, 2]);
    }

    #[test]
    fn a_batch_that_is_late_or_put_aside_changes_nothing() {
        for message in [
            message("hall", "hall-1", 5, "chamber", -1),
            message("ring", "hall-1", 5, "chamber", 1_000),
            message("hall", "hall-2", 5, "chamber", 1_000),
            message("hall", "hall-1", 4, "chamber", 1_000),
            message("hall", "hall-1", 5, "invented", 1_000),
            message("hall", "hall-1", 5, "chamber", 3_601_000),
            Incoming { payload: vec![255; 9], ..message("hall", "hall-1", 5, "chamber", 1_000) },
        ] {
            assert_eq!(after(&message), stored(), "{message:?}");
        }
    }

    #[test]
    fn a_reading_is_forgotten_when_the_database_has_it_and_not_before() {
        let (passing, state) = (Passing::default(), RwLock::new(stored()));
        passing.take(&message("hall", "hall-1", 5, "chamber", 1_000), &state, NOW);
        let count = || passing.readings.read().unwrap().len();
        let mut state = state.into_inner().unwrap();
        passing.forget_stored(&state);
        assert_eq!(count(), 1);
        passing.add_to(&mut state);
        passing.forget_stored(&state);
        assert_eq!(count(), 0);
        passing.take(&message("hall", "hall-1", 5, "chamber", 2_000), &RwLock::new(stored()), NOW);
        passing.forget_stored(&State::default());
        assert_eq!(count(), 0, "a series that the database no longer has");
    }
}
