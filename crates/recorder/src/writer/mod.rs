//! The thread that owns the database. Bus threads put samples into a queue and never block on disk I/O.
//!
//! | Module | Holds |
//! |---|---|
//! | `recorder` | the queue of the thread, and its state, for all other threads |
//! | `thread` | the thread: filters, waiting rows, transactions |

mod recorder;
mod thread;

use super::alarms::AlarmBatch;
use super::database::Retention;
use super::deadband::Deadband;
use super::error::AuditError;
use super::outbox::{Acknowledgement, Forward};
use super::point::{DescribedPoint, Point, PointSample};
use super::sample::{Micros, Sample};
use super::state::StationState;
use profivac_model::{AuditEntry, Event};
pub use recorder::{Recorder, WriteReceipt};
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

/// The deadband, the full-rate window and the retention of the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The deadband.
    pub deadband: Deadband,
    /// The time before and after an event in which every sample is kept.
    pub full_rate_window: Duration,
    /// How long rows are kept.
    pub retention: Retention,
    /// Which samples are also in the batches for an archive; `None` without an archive.
    pub outbox: Option<Forward>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            deadband: Deadband::default(),
            full_rate_window: Duration::from_secs(30),
            retention: Retention::default(),
            outbox: None,
        }
    }
}

/// The state of a recorder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Health {
    /// When the last transaction ended.
    pub last_write: Option<Micros>,
    /// The reason why the last transaction failed, if it did; the recorder tries again.
    pub error: Option<String>,
    /// Samples that were dropped because the queue or the memory was full.
    pub lost_samples: u64,
    /// Events and other rows that were dropped for the same reasons.
    pub lost_events: u64,
}

/// How busy the thread of a recorder is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Load {
    /// The messages that wait for the thread.
    pub waiting: usize,
    /// The time since its last access to the disk ended. An idle thread writes once a second.
    pub silent: Duration,
}

impl Load {
    /// The most messages that wait while the disk keeps up. chosen: a third of a second of 125 gauges at 50 Hz.
    pub const MAX_WAITING: usize = QUEUE_LENGTH / 32;

    /// The longest time between two accesses while the disk keeps up. chosen: a fifth of the time after which the disk counts as stalled.
    pub const MAX_SILENT: Duration = Duration::from_secs(3);

    /// Whether work that can wait should leave the disk and the processor to the recorder.
    #[must_use]
    pub fn is_high(self) -> bool {
        self.waiting > Self::MAX_WAITING || self.silent > Self::MAX_SILENT
    }
}

/// Messages that may wait for the thread: ten seconds of 125 gauges at 50 Hz.
const QUEUE_LENGTH: usize = 65_536;

/// What a recorder could not write at its end.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the database could not be written at the end: {error}; {samples} samples and {rows} other rows are lost")]
pub struct Unwritten {
    /// Why.
    pub error: String,
    /// Samples since the last transaction, and those that were dropped before.
    pub samples: u64,
    /// Events, changes of alarms and rows of the audit trail, likewise.
    pub rows: u64,
}

/// A message to the thread.
enum Message {
    Sample(Arc<str>, Sample),
    /// A value of a point, and the width of its deadband in its unit.
    Point(Arc<Point>, f64, PointSample),
    /// The texts of the codes of all points.
    PointTexts(Vec<DescribedPoint>),
    /// The sender, if any, waits until the event is on the disk.
    Event(Event, Option<Sender<()>>),
    /// An event that is written at once or not at all, and not begun after this time. The sender waits for the outcome.
    EventOrNothing(Event, Instant, Sender<Result<(), AuditError>>),
    /// A row of the audit trail that is written at once or not at all. The sender waits for its number.
    AuditBeforeSending(Box<AuditEntry>, Sender<Result<i64, AuditError>>),
    /// A row of the audit trail that is kept until it is on the disk. The sender may wait for that.
    Audit(Box<AuditEntry>, Sender<()>),
    /// Changes of alarms with their events, written at once.
    Alarms(AlarmBatch, Vec<Event>, Option<Sender<()>>),
    /// An answer about the batches of the outbox.
    OutboxAcknowledged(Acknowledgement),
    /// The archive has other batches of this epoch from this number on.
    OutboxCopied(i64, i64),
    /// A state that is kept until it is on the disk, or until a later one with its name replaces it.
    State(StationState),
    Flush(Sender<()>),
    /// A flush that includes the samples held by the deadbands, tried once. The answer says what is not on the disk.
    Finish(Sender<Result<(), Unwritten>>),
}

const fn count(lost: &mut u64) {
    *lost = lost.saturating_add(1);
}
