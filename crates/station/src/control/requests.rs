//! Requests to a segment beside its cycle: read the parameters of a gauge, preview an operation, execute an armed one.
//!
//! Each segment accepts requests on a queue of its own and answers each exactly once. A requester waits, so it must not be a bus
//! thread.

use super::armed_commands::ArmedCommand;
use super::error::{ChangedSinceArmed, OperationError, OutcomeUnknown, SegmentRequestError, Unavailable};
use super::operation::{Operation, OperationPreview, Readback};
use crate::snapshot::SnapshotStore;
use crate::view::Block;
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::Semaphore;

/// Requests that may wait for one segment.
const QUEUE_LENGTH: usize = 8;

/// How many of them may read the parameters of a gauge, so that viewers leave room for operators.
const PARALLEL_READS: usize = 2;

/// The longest wait for an answer: a few hundred parameters at a slow baud rate.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(60);

/// A request to a segment, with the channel for its answer.
pub enum SegmentRequest {
    /// Read all blocks of the gauge of this name.
    Blocks(String, SyncSender<Result<Vec<Block>, Unavailable>>),
    /// Ask the gauge of this name what an operation would do; nothing is changed.
    Preview(String, Operation, SyncSender<Result<OperationPreview, OperationError>>),
    /// Execute an armed command, unless the segment gets to it after this time.
    Execute(Box<ArmedCommand>, Instant, SyncSender<Result<Readback, OperationError>>),
}

/// The queue of one segment.
#[derive(Clone)]
struct Queue {
    sender: SyncSender<SegmentRequest>,
    reads: Arc<Semaphore>,
}

/// The request queues of all segments.
pub struct SegmentRequests {
    snapshots: Arc<SnapshotStore>,
    queues: Mutex<BTreeMap<String, Queue>>,
}

impl SegmentRequests {
    /// No queues yet; `snapshots` says on which segment a gauge is.
    #[must_use]
    pub fn new(snapshots: Arc<SnapshotStore>) -> Self {
        Self { snapshots, queues: Mutex::default() }
    }

    /// Opens the queue of a segment and returns its receiving end. An older queue of that name is closed.
    pub fn accept(&self, segment: &str) -> Receiver<SegmentRequest> {
        let (sender, receiver) = sync_channel(QUEUE_LENGTH);
        let reads = Arc::new(Semaphore::new(PARALLEL_READS));
        self.queues().insert(segment.to_owned(), Queue { sender, reads });
        receiver
    }

    /// Closes the queue of a segment.
    pub fn close(&self, segment: &str) {
        self.queues().remove(segment);
    }

    /// Reads the blocks of a gauge. Waits for the segment.
    ///
    /// # Errors
    /// [`SegmentRequestError`] says why there are none.
    pub fn blocks(&self, gauge: &str) -> Result<Vec<Block>, SegmentRequestError> {
        let queue = self.queue_of(gauge)?;
        let _permit = queue.reads.try_acquire().map_err(|_| SegmentRequestError::Busy)?;
        ask(&queue, |answer| SegmentRequest::Blocks(gauge.to_owned(), answer))?
            .map_err(SegmentRequestError::Unavailable)
    }

    /// Asks a gauge what an operation would do; nothing is changed. Waits for the segment.
    ///
    /// # Errors
    /// [`OperationError`] says why the operation is not possible.
    pub fn preview(&self, gauge: &str, operation: Operation) -> Result<OperationPreview, OperationError> {
        let queue = self.queue_of(gauge)?;
        ask(&queue, |answer| SegmentRequest::Preview(gauge.to_owned(), operation, answer))?
    }

    /// Executes an armed command, unless the segment has not begun with it at `begin_by`. Waits for the segment.
    ///
    /// # Errors
    /// [`OperationError`] says whether the command was sent, and its outcome.
    pub fn execute(&self, command: ArmedCommand, begin_by: Instant) -> Result<Readback, OperationError> {
        let gauge = command.gauge.clone();
        let now = self.snapshots.connection(&gauge).ok_or_else(|| SegmentRequestError::UnknownGauge(gauge.clone()))?;
        if command.connection != now {
            let armed = Box::new(command.connection);
            return Err(ChangedSinceArmed::Connection { gauge, armed, now: Box::new(now) }.into());
        }
        let queue = self.queue_of(&gauge)?;
        match ask(&queue, |answer| SegmentRequest::Execute(Box::new(command), begin_by, answer)) {
            Ok(answer) => answer,
            Err(SegmentRequestError::Timeout) => Err(OutcomeUnknown::NoAnswer.into()),
            Err(SegmentRequestError::Stopped) => Err(OutcomeUnknown::SegmentStopped.into()),
            Err(error) => Err(error.into()),
        }
    }

    fn queue_of(&self, gauge: &str) -> Result<Queue, SegmentRequestError> {
        let connection = self.snapshots.connection(gauge);
        let queue = connection.and_then(|connection| self.queues().get(&connection.segment).cloned());
        queue.ok_or_else(|| SegmentRequestError::UnknownGauge(gauge.to_owned()))
    }

    fn queues(&self) -> MutexGuard<'_, BTreeMap<String, Queue>> {
        self.queues.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Puts a request into a queue and waits for its answer.
fn ask<T>(queue: &Queue, request: impl FnOnce(SyncSender<T>) -> SegmentRequest) -> Result<T, SegmentRequestError> {
    let (sender, answer) = sync_channel(1);
    queue.sender.try_send(request(sender)).map_err(|_| SegmentRequestError::Busy)?;
    answer.recv_timeout(ANSWER_TIMEOUT).map_err(|error| match error {
        RecvTimeoutError::Timeout => SegmentRequestError::Timeout,
        RecvTimeoutError::Disconnected => SegmentRequestError::Stopped,
    })
}
