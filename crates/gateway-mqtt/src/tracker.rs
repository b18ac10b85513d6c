//! Which points are to be published next.

use profivac_gateway::{Signal, Snapshot};
use profivac_recorder::Micros;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

/// The time between two publications of a counter. chosen: counters change with every telegram, and no user reads ten a second.
pub const COUNTER_PERIOD: Duration = Duration::from_secs(10);

/// The snapshot that was published last, and the counters that wait.
#[derive(Clone, Debug)]
pub struct Tracker {
    published: Arc<Snapshot>,
    waiting: BTreeSet<usize>,
    counters_at: Micros,
}

/// The points that are to be published.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Their positions, in the order of the snapshot.
    pub positions: Vec<usize>,
    /// The updates that newer ones have replaced before they were published.
    pub missed: u64,
}

impl Tracker {
    /// A tracker after all points of `published` were published.
    #[must_use]
    pub const fn new(published: Arc<Snapshot>, now: Micros) -> Self {
        Self { published, waiting: BTreeSet::new(), counters_at: now }
    }

    /// Whether a snapshot has the same points. The list is made again when a gauge changes its measuring part, mostly with equal points.
    #[must_use]
    pub fn has_points_of(&self, snapshot: &Snapshot) -> bool {
        self.published.has_points_of(snapshot) || self.published.points == snapshot.points
    }

    /// The points of `snapshot` that are to be published: those that have changed, and the counters when their period is over. The
    /// snapshot has the same points as the one before.
    pub fn next(&mut self, snapshot: &Arc<Snapshot>, now: Micros) -> Changes {
        let mut changes = Changes::default();
        for (position, missed) in snapshot.changes_since(&self.published) {
            let signal = snapshot.points.get(position).map(|point| point.signal);
            if signal.is_some_and(is_counter) {
                self.waiting.insert(position);
            } else {
                changes.positions.push(position);
                changes.missed = changes.missed.saturating_add(missed);
            }
        }
        self.published = Arc::clone(snapshot);
        // A clock that was set back must not stop the counters.
        if now >= self.counters_at.after(COUNTER_PERIOD) || now < self.counters_at {
            changes.positions.extend(std::mem::take(&mut self.waiting));
            changes.positions.sort_unstable();
            self.counters_at = now;
        }
        changes
    }
}

/// Whether a signal changes all the time without saying anything new: counters, durations, and times that pass.
const fn is_counter(signal: Signal) -> bool {
    matches!(
        signal,
        Signal::LastReading
            | Signal::Requests
            | Signal::Repetitions
            | Signal::LostCycles
            | Signal::DamagedAnswers
            | Signal::Refusals
            | Signal::LongestSequence
            | Signal::CycleTime
            | Signal::TokenRotation
            | Signal::LongestCycle
            | Signal::LongestRotation
            | Signal::Telegrams
            | Signal::DamagedTelegrams
            | Signal::DamagedLastMinute
            | Signal::SegmentRepetitions
            | Signal::SegmentLostCycles
            | Signal::ObservedTime
            | Signal::Heartbeat
            | Signal::LostSamples
            | Signal::LostEvents
            | Signal::LastWrite
    )
}
