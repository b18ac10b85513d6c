//! Requests to a segment beside its cycle: read the parameters of a gauge, preview an operation, execute an armed one.
//!
//! Each segment accepts requests on a queue of its own and answers each at most once: not after its requester has given up. A request
//! has a permit in the queue until it is answered or dropped, also while the segment works on it, so their number is bounded. A
//! requester waits, so it must not be a bus thread.

use super::armed_commands::ArmedCommand;
use super::error::{ChangedSinceArmed, OperationError, OutcomeUnknown, SegmentRequestError, Unavailable};
use super::operation::{Operation, OperationPreview, Readback};
use crate::snapshot::SnapshotStore;
use crate::view::Block;
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SendError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Requests that one segment may have, waiting or in work.
const QUEUE_LENGTH: usize = 8;

/// How many of them may read the parameters of a gauge, so that viewers leave room for operators.
const PARALLEL_READS: usize = 2;

/// The longest wait for an answer: a few hundred parameters at a slow baud rate.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(60);

/// The way of an answer to its requester, and the permit of the request in the queue, which ends with it.
pub struct Answer<T> {
    sender: SyncSender<T>,
    awaited_until: Instant,
    permits: Vec<OwnedSemaphorePermit>,
}

impl<T> Answer<T> {
    /// An answer that is awaited until a time, and the end that receives it.
    pub(crate) fn channel(awaited_until: Instant, permits: Vec<OwnedSemaphorePermit>) -> (Self, Receiver<T>) {
        let (sender, receiver) = sync_channel(1);
        (Self { sender, awaited_until, permits }, receiver)
    }

    /// Whether the requester still waits at `now`.
    #[must_use]
    pub fn is_awaited(&self, now: Instant) -> bool {
        now < self.awaited_until
    }

    /// Answers. The permit of the request is free before its requester can send the next one.
    ///
    /// # Errors
    /// The answer, if the requester has given up.
    pub fn send(self, answer: T) -> Result<(), SendError<T>> {
        drop(self.permits);
        self.sender.send(answer)
    }
}

/// A request to a segment, with the way of its answer.
pub enum SegmentRequest {
    /// Read all blocks of the gauge of this name.
    Blocks(String, Answer<Result<Vec<Block>, Unavailable>>),
    /// Ask the gauge of this name what an operation would do; nothing is changed.
    Preview(String, Operation, Answer<Result<OperationPreview, OperationError>>),
    /// Execute an armed command, unless the segment gets to it after this time.
    Execute(Box<ArmedCommand>, Instant, Answer<Result<Readback, OperationError>>),
}

/// The queue of one segment.
#[derive(Clone)]
struct Queue {
    sender: SyncSender<SegmentRequest>,
    permits: Arc<Semaphore>,
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
        let (permits, reads) = (Semaphore::new(QUEUE_LENGTH), Semaphore::new(PARALLEL_READS));
        let queue = Queue { sender, permits: Arc::new(permits), reads: Arc::new(reads) };
        self.queues().insert(segment.to_owned(), queue);
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
        let permit = permit_of(&queue.reads)?;
        ask(&queue, vec![permit], |answer| SegmentRequest::Blocks(gauge.to_owned(), answer))?
            .map_err(SegmentRequestError::Unavailable)
    }

    /// Asks a gauge what an operation would do; nothing is changed. Waits for the segment.
    ///
    /// # Errors
    /// [`OperationError`] says why the operation is not possible.
    pub fn preview(&self, gauge: &str, operation: Operation) -> Result<OperationPreview, OperationError> {
        let queue = self.queue_of(gauge)?;
        ask(&queue, Vec::new(), |answer| SegmentRequest::Preview(gauge.to_owned(), operation, answer))?
    }

    /// Executes an armed command, unless the segment has not begun with it at `begin_by`. Waits for the segment.
    ///
    /// # Errors
    /// [`OperationError`] says whether the command was sent, and its outcome.
    pub fn execute(&self, command: ArmedCommand, begin_by: Instant) -> Result<Readback, OperationError> {
        let gauge = command.gauge.clone();
        let now = self.snapshots.connection(&gauge).ok_or_else(|| self.unknown(&gauge))?;
        if command.connection != now {
            let armed = Box::new(command.connection);
            return Err(ChangedSinceArmed::Connection { gauge, armed, now: Box::new(now) }.into());
        }
        let queue = self.queue_of(&gauge)?;
        match ask(&queue, Vec::new(), |answer| SegmentRequest::Execute(Box::new(command), begin_by, answer)) {
            Ok(answer) => answer,
            Err(SegmentRequestError::Timeout) => Err(OutcomeUnknown::NoAnswer.into()),
            Err(SegmentRequestError::Stopped) => Err(OutcomeUnknown::SegmentStopped.into()),
            Err(error) => Err(error.into()),
        }
    }

    fn queue_of(&self, gauge: &str) -> Result<Queue, SegmentRequestError> {
        let connection = self.snapshots.connection(gauge);
        let queue = connection.and_then(|connection| self.queues().get(&connection.segment).cloned());
        queue.ok_or_else(|| self.unknown(gauge))
    }

    fn unknown(&self, gauge: &str) -> SegmentRequestError {
        self.snapshots.unknown_gauge(gauge).into()
    }

    fn queues(&self) -> MutexGuard<'_, BTreeMap<String, Queue>> {
        self.queues.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A permit, if one is free.
fn permit_of(permits: &Arc<Semaphore>) -> Result<OwnedSemaphorePermit, SegmentRequestError> {
    Arc::clone(permits).try_acquire_owned().map_err(|_| SegmentRequestError::Busy)
}

/// Puts a request into a queue and waits for its answer. The request keeps `permits` and one in the queue.
fn ask<T>(
    queue: &Queue,
    mut permits: Vec<OwnedSemaphorePermit>,
    request: impl FnOnce(Answer<T>) -> SegmentRequest,
) -> Result<T, SegmentRequestError> {
    permits.push(permit_of(&queue.permits)?);
    let (answer, receiver) = Answer::channel(Instant::now() + ANSWER_TIMEOUT, permits);
    queue.sender.try_send(request(answer)).map_err(|_| SegmentRequestError::Busy)?;
    receiver.recv_timeout(ANSWER_TIMEOUT).map_err(|error| match error {
        RecvTimeoutError::Timeout => SegmentRequestError::Timeout,
        RecvTimeoutError::Disconnected => SegmentRequestError::Stopped,
    })
}
