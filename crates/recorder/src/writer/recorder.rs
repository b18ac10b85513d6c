//! The recorder as all other threads use it: a bounded queue, and the state of the thread behind it.

use super::thread::Writer;
use super::{Health, Load, Message, QUEUE_LENGTH, Settings, Unwritten, count};
use crate::alarms::AlarmBatch;
use crate::clock::{Clock, SystemClock};
use crate::database::Database;
use crate::error::{AuditError, DatabaseError};
use crate::outbox::Acknowledgement;
use crate::point::{DescribedPoint, Point, PointSample};
use crate::reader::Reader;
use crate::sample::Sample;
use crate::state::StationState;
use profivac_model::{AuditEntry, Event};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A disk that has not answered for this time is reported as stalled.
const STALL_TIMEOUT: Duration = Duration::from_secs(15);

/// The longest that a caller waits for the disk.
const WRITE_TIMEOUT: Duration = Duration::from_secs(10);

/// Records samples, events, alarms and audit entries from any thread.
pub struct Recorder {
    messages: Option<SyncSender<Message>>,
    /// The messages that wait for the thread.
    waiting: Arc<AtomicUsize>,
    health: Arc<Mutex<Health>>,
    /// When the last disk access of the thread ended.
    answered: Arc<Mutex<Instant>>,
    thread: Option<JoinHandle<()>>,
}

impl Recorder {
    /// Opens the database and starts the thread.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be used.
    pub fn start(path: &Path, settings: Settings) -> Result<Self, DatabaseError> {
        Self::start_with_clock(path, settings, Arc::new(SystemClock))
    }

    /// Opens the database and starts the thread, which looks at `clock`.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be used.
    pub fn start_with_clock(path: &Path, settings: Settings, clock: Arc<dyn Clock>) -> Result<Self, DatabaseError> {
        let database = Database::open(path, clock.now().wall)?;
        let reader = Reader::open(path)?;
        let (alarms, plant_states) = (reader.alarms()?, reader.plant_states()?);
        drop(reader);
        let health = Arc::new(Mutex::new(Health::default()));
        let (messages, inbox) = sync_channel(QUEUE_LENGTH);
        let writer = Writer::new(database, settings, Arc::clone(&health), clock);
        let writer = writer.with_states(alarms.into_iter().collect(), plant_states.into_iter().collect());
        let (answered, waiting) = (Arc::clone(&writer.answered), Arc::clone(&writer.waiting));
        let thread = std::thread::spawn(move || writer.run(&inbox));
        Ok(Self { messages: Some(messages), waiting, health, answered, thread: Some(thread) })
    }

    /// Records a sample of a series. Never blocks: a sample that is dropped is counted in [`Health::lost_samples`].
    pub fn push(&self, series: &Arc<str>, sample: Sample) {
        if !self.send(Message::Sample(Arc::clone(series), sample)) {
            count(&mut self.locked().lost_samples);
        }
    }

    /// Records a value of a point, with a deadband of this width in the unit of the point: 0 keeps each change. Never blocks: a value that
    /// is dropped is counted in [`Health::lost_samples`].
    pub fn push_point(&self, point: &Arc<Point>, deadband: f64, sample: PointSample) {
        if !self.send(Message::Point(Arc::clone(point), deadband, sample)) {
            count(&mut self.locked().lost_samples);
        }
    }

    /// Sets the texts of the codes of all points, which the batches for an archive contain. Never blocks: a call that finds no room changes
    /// nothing.
    pub fn set_point_texts(&self, points: Vec<DescribedPoint>) {
        let _has_room = self.send(Message::PointTexts(points));
    }

    /// Records an event. Never blocks: an event that is dropped is counted in [`Health::lost_events`].
    pub fn record_event(&self, event: Event) {
        if !self.send(Message::Event(event, None)) {
            count(&mut self.locked().lost_events);
        }
    }

    /// Records an event. Returns `true` when it is on the disk, `false` after ten seconds.
    #[must_use]
    pub fn record_event_and_wait(&self, event: Event) -> bool {
        let (done, wait) = channel();
        let sent = self.send(Message::Event(event, Some(done)));
        if !sent {
            count(&mut self.locked().lost_events);
        }
        sent && wait.recv_timeout(WRITE_TIMEOUT).is_ok()
    }

    /// Records an event at once or not at all: after an error nothing of it is stored later. An error while the disk does not answer is
    /// [`AuditError::Timeout`]; only then the event may be stored.
    ///
    /// # Errors
    /// [`AuditError`] says why the event is not on the disk.
    pub fn record_event_or_nothing(&self, event: Event) -> Result<(), AuditError> {
        let (done, wait) = channel();
        if !self.send(Message::EventOrNothing(event, Instant::now() + WRITE_TIMEOUT, done)) {
            return Err(AuditError::QueueFull);
        }
        wait.recv_timeout(WRITE_TIMEOUT).unwrap_or(Err(AuditError::Timeout))
    }

    /// Writes a row of the audit trail before its command is sent. Returns its number when it is on the disk. A row that is not
    /// written at once is not written later.
    ///
    /// # Errors
    /// [`AuditError`] says why the row is not on the disk.
    pub fn audit_before_sending(&self, entry: AuditEntry) -> Result<i64, AuditError> {
        let (done, wait) = channel();
        if !self.send(Message::AuditBeforeSending(Box::new(entry), done)) {
            return Err(AuditError::QueueFull);
        }
        wait.recv_timeout(WRITE_TIMEOUT).unwrap_or(Err(AuditError::Timeout))
    }

    /// Writes a row of the audit trail. The recorder keeps it until it is on the disk.
    pub fn audit(&self, entry: AuditEntry) -> WriteReceipt {
        let (done, wait) = channel();
        let is_queued = self.send(Message::Audit(Box::new(entry), done));
        if !is_queued {
            count(&mut self.locked().lost_events);
        }
        WriteReceipt(is_queued.then_some(wait))
    }

    /// Records changes of alarms with their events, at once. Never blocks. Returns whether the queue had room.
    #[must_use]
    pub fn record_alarms(&self, batch: AlarmBatch, events: Vec<Event>) -> bool {
        self.send(Message::Alarms(batch, events, None))
    }

    /// Records changes of alarms with their events, at once. The receipt says when they are on the disk. Batches are written in the
    /// order of the calls.
    #[must_use]
    pub fn record_alarms_with_receipt(&self, batch: AlarmBatch, events: Vec<Event>) -> WriteReceipt {
        let (done, wait) = channel();
        WriteReceipt(self.send(Message::Alarms(batch, events, Some(done))).then_some(wait))
    }

    /// Notes an answer about the batches of the outbox with the next transaction. Never blocks: a call that finds no room is made up for
    /// by the next one.
    pub fn acknowledge_outbox(&self, answer: Acknowledgement) {
        let _has_room = self.send(Message::OutboxAcknowledged(answer));
    }

    /// Goes on as another database from batch `first` of `epoch` on, with the next transaction: the archive has other batches with these
    /// numbers. Never blocks: a call that finds no room is made up for by the next one.
    pub fn branch_outbox(&self, epoch: i64, first: i64) {
        let _has_room = self.send(Message::OutboxCopied(epoch, first));
    }

    /// Stores a state of the station, in place of the one with its name, with the next transaction. Never blocks. Returns whether the queue
    /// had room.
    #[must_use]
    pub fn store_state(&self, state: StationState) -> bool {
        self.send(Message::State(state))
    }

    /// Writes everything in the queue. Returns `true` when it is on the disk, `false` after ten seconds.
    #[must_use]
    pub fn flush(&self) -> bool {
        let (done, wait) = channel();
        self.send(Message::Flush(done)) && wait.recv_timeout(WRITE_TIMEOUT).is_ok()
    }

    /// Flushes, including the samples held by the deadbands: for the end of a station whose threads still share the recorder. Tries once.
    ///
    /// # Errors
    /// [`Unwritten`] says why not, and how much is lost.
    pub fn finish(&self) -> Result<(), Unwritten> {
        let (done, wait) = channel();
        let answer = self.send(Message::Finish(done)).then(|| wait.recv_timeout(WRITE_TIMEOUT).ok()).flatten();
        answer.unwrap_or_else(|| {
            let Health { error, lost_samples, lost_events, .. } = self.health();
            let error =
                error.unwrap_or_else(|| "the disk does not answer; what was recorded last may be lost too".to_owned());
            Err(Unwritten { error, samples: lost_samples, rows: lost_events })
        })
    }

    /// The state of the recorder, also when its thread has ended or is blocked on disk I/O.
    #[must_use]
    pub fn health(&self) -> Health {
        let silent = self.silent();
        let has_ended = self.thread.as_ref().is_some_and(JoinHandle::is_finished);
        let health = self.locked().clone();
        Health { error: stall_message(has_ended, silent).or(health.error), ..health }
    }

    /// How busy the thread is.
    #[must_use]
    pub fn load(&self) -> Load {
        Load { waiting: self.waiting.load(Ordering::Relaxed), silent: self.silent() }
    }

    /// The time since the last access to the disk ended.
    fn silent(&self) -> Duration {
        self.answered.lock().unwrap_or_else(PoisonError::into_inner).elapsed()
    }

    fn locked(&self) -> MutexGuard<'_, Health> {
        self.health.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns whether the queue had room.
    fn send(&self, message: Message) -> bool {
        // Counted first: the thread may take the message before this returns.
        self.waiting.fetch_add(1, Ordering::Relaxed);
        let has_room = self.messages.as_ref().is_some_and(|messages| messages.try_send(message).is_ok());
        if !has_room {
            self.waiting.fetch_sub(1, Ordering::Relaxed);
        }
        has_room
    }
}

/// An error that the thread cannot report itself: it has ended, or the disk does not answer.
fn stall_message(has_ended: bool, silent: Duration) -> Option<String> {
    match has_ended {
        true => Some("the recorder thread has ended: restart the station".to_owned()),
        false => (silent > STALL_TIMEOUT).then(|| format!("the disk has not answered for {} s", silent.as_secs())),
    }
}

/// Says when rows are on the disk.
pub struct WriteReceipt(Option<Receiver<()>>);

impl WriteReceipt {
    /// Whether the queue had room for the rows.
    #[must_use]
    pub const fn is_queued(&self) -> bool {
        self.0.is_some()
    }

    /// Returns `true` when the rows are on the disk, `false` after ten seconds.
    pub fn wait(self) -> bool {
        self.0.is_some_and(|wait| wait.recv_timeout(WRITE_TIMEOUT).is_ok())
    }
}
impl Drop for Recorder {
    /// Writes everything in the queue before it returns.
    fn drop(&mut self) {
        self.messages = None;
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_load_is_high_while_messages_wait_or_the_disk_does_not_answer() {
        let load = |waiting, silent| Load { waiting, silent };
        assert!(!load(Load::MAX_WAITING, Load::MAX_SILENT).is_high());
        assert!(load(Load::MAX_WAITING + 1, Duration::ZERO).is_high());
        assert!(load(0, Load::MAX_SILENT + Duration::from_millis(1)).is_high());
        let folder = tempfile::tempdir().unwrap();
        let (messages, inbox) = sync_channel(2);
        let mut recorder = Recorder::start(&folder.path().join("plant.db"), Settings::default()).unwrap();
        assert!(recorder.flush());
        assert_eq!(recorder.load().waiting, 0, "the thread has taken what was sent");
        // No thread takes these messages, and the third one finds no room.
        recorder.messages = Some(messages);
        (0..3).for_each(|_| recorder.acknowledge_outbox(Acknowledgement::default()));
        assert_eq!(recorder.load().waiting, 2);
        drop((recorder, inbox));
    }

    #[test]
    fn health_reports_a_stalled_disk_and_an_ended_thread() {
        assert_eq!(stall_message(false, STALL_TIMEOUT), None);
        let stalled = stall_message(false, Duration::from_secs(16));
        assert_eq!(stalled.as_deref(), Some("the disk has not answered for 16 s"));
        let folder = tempfile::tempdir().unwrap();
        let mut recorder = Recorder::start(&folder.path().join("plant.db"), Settings::default()).unwrap();
        // The thread ends when its queue closes; it is not joined.
        recorder.messages = None;
        while recorder.health().error.is_none() {
            std::thread::yield_now();
        }
        let error = recorder.health().error;
        assert_eq!(error.as_deref(), Some("the recorder thread has ended: restart the station"));
    }
}
