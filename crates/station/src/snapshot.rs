//! The latest snapshot of each segment. Segment threads publish; alarms, control and the API read.

use crate::bus::BusStore;
use crate::view::{Gauge, ReadProgress, Segment, SegmentState, duration_ms};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::{Duration, Instant};

/// A segment thread that has published nothing for this long is reported as stalled. It publishes every 100 ms, also while it waits
/// for a slow gauge.
const STALLED_AFTER: Duration = Duration::from_secs(15);

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

/// The latest snapshots of all segments, by name.
#[derive(Default)]
pub struct SnapshotStore {
    segments: RwLock<BTreeMap<String, Published>>,
    read_progress: Mutex<Vec<ReadProgress>>,
    buses: BusStore,
    /// A gateway shows parameters: the segments read them.
    parameter_readers: AtomicUsize,
}

impl SnapshotStore {
    /// Replaces the snapshot of a segment.
    pub fn publish(&self, snapshot: SegmentSnapshot) {
        let published = Published { at: Instant::now(), snapshot };
        self.write().insert(published.snapshot.segment.name.clone(), published);
    }

    /// Replaces the gauges of a segment, and leaves the rest of its snapshot.
    pub fn publish_gauges(&self, segment: &str, gauges: Vec<Gauge>) {
        if let Some(published) = self.write().get_mut(segment) {
            published.at = Instant::now();
            published.snapshot.gauges = gauges;
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
        self.gauges().into_iter().find(|gauge| gauge.name == name)
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
    Gauge { age_ms, ..gauge.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{BusStationState, GaugeKind};
    use std::sync::Arc;

    #[test]
    fn readings_age_after_publication_and_a_stalled_thread_is_reported() {
        let gauge = Gauge {
            name: "chamber".to_owned(),
            kind: GaugeKind::Gauge,
            segment: "hall".to_owned(),
            address: 5,
            device: "bcg450".to_owned(),
            has_dpv1: true,
            listen_only: false,
            assumptions: Vec::new(),
            state: BusStationState::DataExchange,
            problem: None,
            exceptions: Vec::new(),
            warnings: Vec::new(),
            gas: "n2".to_owned(),
            levels: Vec::new(),
            readings: Vec::new(),
            poll_ms: 200,
            stale_after_ms: 3000,
            age_ms: Some(12),
            parameters: Arc::default(),
            read_at: None,
            lost_at: None,
        };
        assert_eq!(gauge_after(&gauge, Duration::from_secs(3)).age_ms, Some(3012));
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
