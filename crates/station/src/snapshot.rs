//! The latest snapshot of each segment. Segment threads publish; alarms, control and the API read.

use crate::bus::BusStore;
use crate::view::{BusStation, Gauge, ReadProgress, Segment, SegmentState, duration_ms};
use profivac_client::suggestion::known;
use profivac_recorder::Micros;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::{Duration, Instant};

/// A segment thread that has published nothing for this long is reported as stalled. It publishes every 100 ms, also while it waits
/// for a slow gauge.
const STALLED_AFTER: Duration = Duration::from_secs(15);

/// A name that no gauge of the station has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no gauge {name:?}; {}", known("gauges", name, gauges))]
pub struct UnknownGauge {
    /// The name.
    pub name: String,
    /// The names of the gauges, sorted.
    pub gauges: Vec<String>,
}

/// The state of a segment at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentSnapshot {
    /// The segment.
    pub segment: Segment,
    /// Its gauges, in the order of the station's file.
    pub gauges: Vec<Gauge>,
}

/// Where a gauge is connected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connection {
    /// The name of the segment.
    pub segment: String,
    /// The port of the segment.
    pub port: String,
}

/// A snapshot, and when it was published.
struct Published {
    at: Instant,
    snapshot: SegmentSnapshot,
}

impl Published {
    /// The snapshot as it is now.
    fn aged(&self) -> SegmentSnapshot {
        let (since, SegmentSnapshot { segment, gauges }) = (self.at.elapsed(), &self.snapshot);
        SegmentSnapshot {
            segment: segment_after(segment, since),
            gauges: gauges.iter().map(|gauge| gauge_after(gauge, since)).collect(),
        }
    }
}

/// The latest snapshots of all segments, by name.
#[derive(Default)]
pub struct SnapshotStore {
    segments: RwLock<BTreeMap<String, Published>>,
    /// The segments of the file, before they start.
    plan: RwLock<Arc<[SegmentSnapshot]>>,
    read_progress: Mutex<Vec<ReadProgress>>,
    /// Since when the gauges of a segment that was stopped have no readings, until they have some again.
    losses: Mutex<BTreeMap<String, Micros>>,
    buses: BusStore,
    /// A gateway shows parameters: the segments read them.
    parameter_readers: AtomicUsize,
}

impl SnapshotStore {
    /// Replaces the snapshot of a segment.
    pub fn publish(&self, snapshot: SegmentSnapshot) {
        let has_readings = |name: &String| snapshot.gauges.iter().any(|it| it.name == *name && it.lost_at.is_none());
        self.losses().retain(|name, _| !has_readings(name));
        let published = Published { at: Instant::now(), snapshot };
        self.write().insert(published.snapshot.segment.name.clone(), published);
    }

    /// Sets the segments of the file, before they start.
    pub fn set_plan(&self, plan: Vec<SegmentSnapshot>) {
        *self.plan.write().unwrap_or_else(PoisonError::into_inner) = plan.into();
    }

    /// The segments of the file, before they start.
    #[must_use]
    pub fn plan(&self) -> Arc<[SegmentSnapshot]> {
        Arc::clone(&self.plan.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// All segments with their gauges in the order of the file, then those that are not in the file. A segment that does not run at this
    /// moment has its place too, so that the places of the others do not depend on it.
    #[must_use]
    pub fn in_order_of_file(&self) -> Vec<SegmentSnapshot> {
        let plan = self.plan();
        let published = self.read();
        let now = |planned: &SegmentSnapshot| {
            published.get(&planned.segment.name).map_or_else(|| self.with_losses(planned), Published::aged)
        };
        let is_other = |name: &String| plan.iter().all(|planned| planned.segment.name != *name);
        let others = published.iter().filter(|(name, _)| is_other(name)).map(|(_, published)| published.aged());
        plan.iter().map(now).chain(others).collect()
    }

    /// Keeps since when the gauges of a segment that stops have no readings: the segment that begins anew has the same times, which are
    /// those of the database.
    pub fn keep_losses(&self, gauges: impl IntoIterator<Item = Gauge>) {
        let losses = gauges.into_iter().filter_map(|gauge| Some((gauge.name, gauge.lost_at?)));
        self.losses().extend(losses);
    }

    /// Since when a gauge of a segment that was stopped has no readings.
    #[must_use]
    pub fn loss(&self, gauge: &str) -> Option<Micros> {
        self.losses().get(gauge).copied()
    }

    fn with_losses(&self, planned: &SegmentSnapshot) -> SegmentSnapshot {
        let SegmentSnapshot { segment, gauges } = planned.clone();
        let with_loss = |gauge: Gauge| Gauge { lost_at: self.loss(&gauge.name), ..gauge };
        SegmentSnapshot { segment, gauges: gauges.into_iter().map(with_loss).collect() }
    }

    fn losses(&self) -> MutexGuard<'_, BTreeMap<String, Micros>> {
        self.losses.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces the gauges of a segment and their stations on the bus, and leaves the rest of its snapshot.
    pub fn publish_gauges(&self, segment: &str, gauges: Vec<Gauge>, stations: Vec<BusStation>) {
        if let Some(published) = self.write().get_mut(segment) {
            published.at = Instant::now();
            published.snapshot.gauges = gauges;
            for station in stations {
                let shown = &mut published.snapshot.segment.stations;
                if let Some(place) = shown.iter_mut().find(|other| other.address == station.address) {
                    *place = station;
                }
            }
        }
    }

    /// Whether the segments read the parameters that gateways show.
    #[must_use]
    pub fn are_parameters_wanted(&self) -> bool {
        self.parameter_readers.load(Ordering::Relaxed) > 0
    }

    /// The segments read the parameters that gateways show until [`Self::remove_parameter_reader`] is called as often.
    pub fn add_parameter_reader(&self) {
        self.parameter_readers.fetch_add(1, Ordering::Relaxed);
    }

    /// Takes one [`Self::add_parameter_reader`] back.
    pub fn remove_parameter_reader(&self) {
        self.parameter_readers.fetch_sub(1, Ordering::Relaxed);
    }

    /// The lines of the segments.
    #[must_use]
    pub const fn buses(&self) -> &BusStore {
        &self.buses
    }

    /// Removes a segment that has stopped.
    pub fn remove(&self, segment: &str) {
        self.buses.remove(segment);
        self.write().remove(segment);
    }

    /// All segments, by name.
    #[must_use]
    pub fn segments(&self) -> Vec<Segment> {
        self.read()
            .values()
            .map(|published| segment_after(&published.snapshot.segment, published.at.elapsed()))
            .collect()
    }

    /// All gauges, segment by segment.
    #[must_use]
    pub fn gauges(&self) -> Vec<Gauge> {
        let aged = |published: &Published| {
            let since = published.at.elapsed();
            published.snapshot.gauges.iter().map(|gauge| gauge_after(gauge, since)).collect::<Vec<_>>()
        };
        self.read().values().flat_map(aged).collect()
    }

    /// The gauge of this name.
    #[must_use]
    pub fn gauge(&self, name: &str) -> Option<Gauge> {
        let named = |published: &Published| {
            let gauge = published.snapshot.gauges.iter().find(|gauge| gauge.name == name)?;
            Some(gauge_after(gauge, published.at.elapsed()))
        };
        self.read().values().find_map(named)
    }

    /// The gauge that a user names.
    ///
    /// # Errors
    /// [`UnknownGauge`] has the names of all gauges.
    pub fn gauge_named(&self, name: &str) -> Result<Gauge, UnknownGauge> {
        self.gauge(name).ok_or_else(|| self.unknown_gauge(name))
    }

    /// The error for a name that no gauge has.
    #[must_use]
    pub fn unknown_gauge(&self, name: &str) -> UnknownGauge {
        let all = self.read();
        let gauges = all.values().flat_map(|published| &published.snapshot.gauges);
        let mut gauges: Vec<String> = gauges.map(|gauge| gauge.name.clone()).collect();
        gauges.sort_unstable();
        UnknownGauge { name: name.to_owned(), gauges }
    }

    /// Where the gauge of this name is connected.
    #[must_use]
    pub fn connection(&self, gauge: &str) -> Option<Connection> {
        let all = self.read();
        let has = |snapshot: &SegmentSnapshot| snapshot.gauges.iter().any(|other| other.name == gauge);
        let snapshot = all.values().map(|published| &published.snapshot).find(|snapshot| has(snapshot))?;
        let Segment { name, port, .. } = &snapshot.segment;
        Some(Connection { segment: name.clone(), port: port.clone() })
    }

    /// The progress of all parameter readings that are under way.
    #[must_use]
    pub fn read_progress(&self) -> Vec<ReadProgress> {
        self.progress().clone()
    }

    /// Sets the progress of reading the parameters of a gauge; `done == total` ends it.
    pub fn set_read_progress(&self, gauge: &str, done: usize, total: usize) {
        let mut progress = self.progress();
        progress.retain(|other| other.gauge != gauge);
        if done < total {
            progress.push(ReadProgress { gauge: gauge.to_owned(), done, total });
        }
    }

    fn progress(&self) -> MutexGuard<'_, Vec<ReadProgress>> {
        self.read_progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn read(&self) -> RwLockReadGuard<'_, BTreeMap<String, Published>> {
        self.segments.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> RwLockWriteGuard<'_, BTreeMap<String, Published>> {
        self.segments.write().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A segment `since` its snapshot was published.
fn segment_after(segment: &Segment, since: Duration) -> Segment {
    let mut segment = segment.clone();
    if since > STALLED_AFTER {
        segment.state = SegmentState::Waiting;
        segment.problem = Some(format!("the thread of the segment has not responded for {} s", since.as_secs()));
    }
    segment
}

/// A gauge `since` its snapshot was published: its readings are older by that time.
fn gauge_after(gauge: &Gauge, since: Duration) -> Gauge {
    let age_ms = gauge.age_ms.map(|age| age.saturating_add(duration_ms(since)));
    // A thread that stands still finds out nothing.
    let is_awaited = gauge.is_awaited && since <= STALLED_AFTER;
    Gauge { age_ms, is_awaited, ..gauge.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::BusStationState;

    fn segment(name: &str, state: SegmentState) -> SegmentSnapshot {
        let segment = Segment {
            name: name.to_owned(),
            port: "/dev/ttyUSB0".to_owned(),
            baud: 19200,
            master: Some(0),
            listen_only: false,
            state,
            problem: None,
            cycle_ms: None,
            damaged_telegrams: 0,
            stations: Vec::new(),
        };
        let gauge = Gauge { name: format!("gauge of {name}"), ..Gauge::default() };
        SegmentSnapshot { segment, gauges: vec![gauge] }
    }

    #[test]
    fn segments_have_the_order_of_the_file_also_while_one_does_not_run() {
        let store = SnapshotStore::default();
        let names = |store: &SnapshotStore| -> Vec<(String, SegmentState, String)> {
            let shown = |it: SegmentSnapshot| (it.segment.name, it.segment.state, it.gauges[0].name.clone());
            store.in_order_of_file().into_iter().map(shown).collect()
        };
        let row = |name: &str, state| (name.to_owned(), state, format!("gauge of {name}"));
        let (waiting, running) = (SegmentState::Waiting, SegmentState::Running);
        store.set_plan(["z", "m", "b"].map(|name| segment(name, waiting)).into());
        ["a", "b", "m", "z"].into_iter().for_each(|name| store.publish(segment(name, running)));
        assert_eq!(names(&store), ["z", "m", "b", "a"].map(|name| row(name, running)), "the last is not in the file");
        store.remove("z");
        assert_eq!(names(&store)[..2], [row("z", waiting), row("m", running)]);
    }

    /// A request may wait for seconds: the map of the bus must not show an exchange of which the gauge knows that it is over.
    #[test]
    fn gauges_are_published_with_their_stations_on_the_bus() {
        let station = |address, state| BusStation {
            address,
            state,
            name: None,
            device: None,
            ident: None,
            description: String::new(),
        };
        let (master, exchange, missing) =
            (BusStationState::OwnMaster, BusStationState::DataExchange, BusStationState::Missing);
        let store = SnapshotStore::default();
        let mut snapshot = segment("hall", SegmentState::Running);
        snapshot.segment.stations = vec![station(1, master), station(5, exchange), station(6, exchange)];
        store.publish(snapshot.clone());
        let gauges = vec![Gauge { state: missing, ..snapshot.gauges[0].clone() }];
        store.publish_gauges("hall", gauges.clone(), vec![station(6, missing)]);
        let shown = store.in_order_of_file().remove(0);
        assert_eq!(shown.segment.stations, [station(1, master), station(5, exchange), station(6, missing)]);
        assert_eq!(shown.gauges, gauges);
    }

    #[test]
    fn readings_age_after_publication_and_a_stalled_thread_is_reported() {
        let gauge = Gauge {
            name: "chamber".to_owned(),
            segment: "hall".to_owned(),
            address: 5,
            device: "bcg450".to_owned(),
            has_dpv1: true,
            state: BusStationState::DataExchange,
            gas: "n2".to_owned(),
            poll_ms: 200,
            stale_after_ms: 3000,
            age_ms: Some(12),
            ..Gauge::default()
        };
        assert_eq!(gauge_after(&gauge, Duration::from_secs(3)).age_ms, Some(3012));
        let awaited = Gauge { is_awaited: true, ..gauge.clone() };
        assert!(gauge_after(&awaited, STALLED_AFTER).is_awaited);
        assert!(!gauge_after(&awaited, Duration::from_secs(20)).is_awaited);
        let segment = Segment {
            name: "hall".to_owned(),
            port: "/dev/ttyUSB0".to_owned(),
            baud: 19200,
            master: Some(0),
            listen_only: false,
            state: SegmentState::Running,
            problem: None,
            cycle_ms: None,
            damaged_telegrams: 0,
            stations: Vec::new(),
        };
        assert_eq!(segment_after(&segment, STALLED_AFTER), segment);
        let stalled = segment_after(&segment, Duration::from_secs(20));
        assert_eq!(stalled.problem.as_deref(), Some("the thread of the segment has not responded for 20 s"));
        assert_eq!(stalled.state, SegmentState::Waiting);
    }
}
