//! The thread that owns the file. Whoever measures never waits for the disk.

use super::alarms::AlarmBatch;
use super::audit::{AuditAction, AuditEntry};
use super::clock::ClockMonitor;
use super::database::{Database, DatabaseError, Event, EventKind, Retention};
use super::deadband::{Deadband, DeadbandFilter};
use super::ring::RingBuffer;
use super::sample::{Micros, Sample};
use super::spans::PendingSpans;
use std::collections::HashMap;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SendError, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often what was measured is written: a power cut loses no more.
const WRITE_INTERVAL: Duration = Duration::from_secs(1);

/// How often what is old is looked for.
const PRUNE_INTERVAL: Duration = Duration::from_secs(60);

/// So many messages may wait for the thread: ten seconds of 125 gauges at 50 Hz.
const QUEUE_LENGTH: usize = 65_536;

/// So many samples and spans, and so many events, are kept in memory while the disk takes none.
const MAX_UNWRITTEN: usize = 1_000_000;
const MAX_UNWRITTEN_EVENTS: usize = 10_000;

/// A disk that has not answered for so long hangs.
const STALL_TIMEOUT: Duration = Duration::from_secs(15);

/// How long somebody who wants to know waits for the disk.
const WRITE_TIMEOUT: Duration = Duration::from_secs(10);

/// What is kept, and for how long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The dead band.
    pub deadband: Deadband,
    /// How much time before and after an event is kept at full rate.
    pub full_rate_window: Duration,
    /// How long what is kept.
    pub retention: Retention,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            deadband: Deadband::default(),
            full_rate_window: Duration::from_secs(30),
            retention: Retention::default(),
        }
    }
}

/// How the recorder is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Health {
    /// When a transaction ended last.
    pub last_write: Option<Micros>,
    /// Why the last one failed, if it did; it is tried again.
    pub error: Option<String>,
    /// Samples that could not be kept: the queue was full, or the disk took none for long.
    pub lost_samples: u64,
    /// Events that could not be kept, for the same reasons.
    pub lost_events: u64,
}

enum Message {
    Sample(Arc<str>, Sample),
    /// Somebody may want to know when it is on the disk.
    Event(Event, Option<Sender<()>>),
    /// A row of the audit trail, now or never: which row it is, or why there is none.
    AuditBeforeSending(Box<AuditEntry>, Sender<Result<i64, String>>),
    /// A row of the audit trail that must not be lost; somebody wants to know when it is on the disk.
    Audit(Box<AuditEntry>, Sender<()>),
    /// What became of alarms, with the events that tell it. Written at once.
    Alarms(AlarmBatch, Vec<Event>, Option<Sender<()>>),
    Flush(Sender<()>),
    /// A flush with what the dead band holds back.
    Finish(Sender<()>),
}

/// Takes samples and events from any thread.
pub struct Recorder {
    messages: Option<SyncSender<Message>>,
    health: Arc<Mutex<Health>>,
    /// When the thread was last done with the disk.
    answered: Arc<Mutex<Instant>>,
    thread: Option<JoinHandle<()>>,
}

impl Recorder {
    /// Opens the file and begins.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be used.
    pub fn start(path: &Path, settings: Settings) -> Result<Self, DatabaseError> {
        let store = Database::open(path)?;
        let health = Arc::new(Mutex::new(Health::default()));
        let (messages, inbox) = sync_channel(QUEUE_LENGTH);
        let work = Writer::new(store, settings, Arc::clone(&health));
        let answered = Arc::clone(&work.answered);
        let thread = std::thread::spawn(move || work.run(&inbox));
        Ok(Self { messages: Some(messages), health, answered, thread: Some(thread) })
    }

    /// A sample of a gauge. Never waits: what cannot be taken is counted in [`Health::lost`].
    pub fn push(&self, gauge: &Arc<str>, sample: Sample) {
        if !self.send(Message::Sample(Arc::clone(gauge), sample)) {
            count(&mut self.locked().lost_samples);
        }
    }

    /// Something happened. Never waits: what cannot be taken is counted in [`Health::lost_events`].
    pub fn record_event(&self, event: Event) {
        if !self.send(Message::Event(event, None)) {
            count(&mut self.locked().lost_events);
        }
    }

    /// Something happened. Returns when it is on the disk, `false` if that could not be had in ten seconds.
    #[must_use]
    pub fn record_event_and_wait(&self, event: Event) -> bool {
        let (done, wait) = channel();
        let sent = self.send(Message::Event(event, Some(done)));
        if !sent {
            count(&mut self.locked().lost_events);
        }
        sent && wait.recv_timeout(WRITE_TIMEOUT).is_ok()
    }

    /// A row of the audit trail before something is done. Returns its number when it is on the disk; if it does not get
    /// there now, it is not tried again.
    ///
    /// # Errors
    /// Why it is not there.
    pub fn audit_before_sending(&self, entry: AuditEntry) -> Result<i64, String> {
        let (done, wait) = channel();
        if !self.send(Message::AuditBeforeSending(Box::new(entry), done)) {
            return Err("the recorder has too much to write".to_owned());
        }
        wait.recv_timeout(WRITE_TIMEOUT).unwrap_or_else(|_| Err("the disk is too slow".to_owned()))
    }

    /// A row of the audit trail after something was done. If the disk does not take it now, it is tried again.
    pub fn audit(&self, entry: AuditEntry) -> WriteReceipt {
        let (done, wait) = channel();
        let is_taken = self.send(Message::Audit(Box::new(entry), done));
        if !is_taken {
            count(&mut self.locked().lost_events);
        }
        WriteReceipt(is_taken.then_some(wait))
    }

    /// What became of alarms, and the events that tell it. Never waits, and is written at once. Says whether there was room for it.
    #[must_use]
    pub fn record_alarms(&self, batch: AlarmBatch, events: Vec<Event>) -> bool {
        self.send(Message::Alarms(batch, events, None))
    }

    /// The same, with somebody who waits: what is returned tells when it is on the disk. The order of what is sent is the order in
    /// the file.
    #[must_use]
    pub fn record_alarms_with_receipt(&self, batch: AlarmBatch, events: Vec<Event>) -> WriteReceipt {
        let (done, wait) = channel();
        WriteReceipt(self.send(Message::Alarms(batch, events, Some(done))).then_some(wait))
    }

    /// Writes what is waiting. Returns when it is on the disk, `false` if that could not be had in ten seconds.
    #[must_use]
    pub fn flush(&self) -> bool {
        let (done, wait) = channel();
        self.send(Message::Flush(done)) && wait.recv_timeout(WRITE_TIMEOUT).is_ok()
    }

    /// The same with what the dead band holds back, for an end at which not everybody may have let go of the recorder.
    #[must_use]
    pub fn finish(&self) -> bool {
        let (done, wait) = channel();
        self.send(Message::Finish(done)) && wait.recv_timeout(WRITE_TIMEOUT).is_ok()
    }

    /// How it is. Who has died or waits for a disk that hangs cannot say so.
    #[must_use]
    pub fn health(&self) -> Health {
        let silent = self.answered.lock().unwrap_or_else(PoisonError::into_inner).elapsed();
        let has_ended = self.thread.as_ref().is_some_and(JoinHandle::is_finished);
        let health = self.locked().clone();
        Health { error: stall_message(has_ended, silent).or(health.error), ..health }
    }

    fn locked(&self) -> MutexGuard<'_, Health> {
        self.health.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether there was room for it.
    fn send(&self, message: Message) -> bool {
        self.messages.as_ref().is_some_and(|messages| messages.try_send(message).is_ok())
    }
}

/// What the thread cannot say itself.
fn stall_message(has_ended: bool, silent: Duration) -> Option<String> {
    match has_ended {
        true => Some("who records has died: start the station again".to_owned()),
        false => (silent > STALL_TIMEOUT).then(|| format!("the disk has not answered for {} s", silent.as_secs())),
    }
}

/// Something that is on its way to the disk.
pub struct WriteReceipt(Option<Receiver<()>>);

impl WriteReceipt {
    /// Whether there was room for it.
    #[must_use]
    pub const fn is_queued(&self) -> bool {
        self.0.is_some()
    }

    /// Returns when it is on the disk, `false` if that could not be had in ten seconds.
    pub fn wait(self) -> bool {
        self.0.is_some_and(|wait| wait.recv_timeout(WRITE_TIMEOUT).is_ok())
    }
}

const fn count(lost: &mut u64) {
    *lost = lost.saturating_add(1);
}

impl Drop for Recorder {
    /// Everything that was taken is written before this returns.
    fn drop(&mut self) {
        self.messages = None;
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

/// One gauge on its way to the file.
struct SeriesState {
    number: usize,
    thinner: DeadbandFilter,
    ring: RingBuffer,
}

struct Writer {
    store: Database,
    settings: Settings,
    health: Arc<Mutex<Health>>,
    series: HashMap<Arc<str>, SeriesState>,
    samples: Vec<(usize, Sample)>,
    additions: PendingSpans,
    events: Vec<Event>,
    audit: Vec<AuditEntry>,
    alarms: AlarmBatch,
    /// Something is not to wait for the end of the second.
    is_urgent: bool,
    acknowledgements: Vec<Sender<()>>,
    clock: ClockMonitor,
    answered: Arc<Mutex<Instant>>,
    /// So much fits into memory.
    capacity: usize,
    due: Instant,
    prune_at: Instant,
}

impl Writer {
    fn new(store: Database, settings: Settings, health: Arc<Mutex<Health>>) -> Self {
        let now = Instant::now();
        Self {
            store,
            settings,
            health,
            series: HashMap::new(),
            samples: Vec::new(),
            additions: PendingSpans::default(),
            events: Vec::new(),
            audit: Vec::new(),
            alarms: AlarmBatch::default(),
            is_urgent: false,
            acknowledgements: Vec::new(),
            clock: ClockMonitor::new(now, Micros::now()),
            answered: Arc::new(Mutex::new(now)),
            capacity: MAX_UNWRITTEN,
            due: now + WRITE_INTERVAL,
            prune_at: now,
        }
    }

    /// Until nobody can send any more.
    fn run(mut self, inbox: &Receiver<Message>) {
        loop {
            match inbox.recv_timeout(self.due.saturating_duration_since(Instant::now())) {
                Ok(message) => self.handle(message),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if self.is_urgent || !self.acknowledgements.is_empty() || Instant::now() >= self.due {
                self.write();
            }
        }
        self.flush_deadbands();
        self.write();
    }

    fn handle(&mut self, message: Message) {
        match message {
            Message::Sample(gauge, sample) => self.sample(&gauge, sample),
            Message::Event(event, done) => self.event(event, done),
            Message::AuditBeforeSending(entry, done) => {
                let written = self.intend((*entry).clone());
                // Whoever asked has gone when it took too long, and does nothing then.
                if let Err(SendError(Ok(row))) = done.send(written) {
                    let outcome = Some("not sent: the disk was too slow".to_owned());
                    self.audit.push(AuditEntry {
                        action: AuditAction::Outcome,
                        refers_to: Some(row),
                        outcome,
                        ..*entry
                    });
                }
            }
            Message::Audit(..) if self.audit.len() >= MAX_UNWRITTEN_EVENTS => count(&mut self.locked().lost_events),
            Message::Audit(entry, done) => {
                self.audit.push(*entry);
                self.acknowledgements.push(done);
            }
            Message::Alarms(batch, events, done) => self.alarms(batch, events, done),
            Message::Flush(done) => self.acknowledgements.push(done),
            Message::Finish(done) => {
                self.flush_deadbands();
                self.acknowledgements.push(done);
            }
        }
    }

    /// What the dead band held back is the last that is known.
    fn flush_deadbands(&mut self) {
        for lane in self.series.values_mut() {
            self.samples.extend(lane.thinner.flush().map(|sample| (lane.number, sample)));
        }
    }

    /// Whether nothing more fits into memory while the disk takes nothing.
    fn is_full(&self) -> bool {
        self.samples.len().saturating_add(self.additions.len()) >= self.capacity
    }

    fn sample(&mut self, gauge: &Arc<str>, sample: Sample) {
        if self.is_full() {
            count(&mut self.locked().lost_samples);
            return;
        }
        if !self.series.contains_key(gauge) {
            let number = self.store.series_index(gauge);
            let lane = SeriesState {
                number,
                thinner: DeadbandFilter::default(),
                ring: RingBuffer::new(self.settings.full_rate_window),
            };
            self.series.insert(Arc::clone(gauge), lane);
        }
        let Some(lane) = self.series.get_mut(gauge) else { return };
        let number = lane.number;
        let whole = lane.ring.push(sample).then_some(sample);
        let thinned = lane.thinner.push(&self.settings.deadband, sample);
        self.samples.extend(whole.into_iter().chain(thinned).map(|sample| (number, sample)));
        self.additions.add(number, &sample);
    }

    fn event(&mut self, event: Event, done: Option<Sender<()>>) {
        if self.events.len() >= MAX_UNWRITTEN_EVENTS {
            count(&mut self.locked().lost_events);
            return;
        }
        // Whoever is only refused at the door must not make the record grow.
        if !self.is_full() && event.kind != EventKind::Access {
            self.write_full_rate(&event);
        }
        self.events.push(event);
        self.acknowledgements.extend(done);
    }

    fn alarms(&mut self, batch: AlarmBatch, events: Vec<Event>, done: Option<Sender<()>>) {
        let lost = self.alarms.append(batch, MAX_UNWRITTEN_EVENTS);
        if lost > 0 {
            let mut health = self.locked();
            health.lost_events = health.lost_events.saturating_add(lost);
        }
        events.into_iter().for_each(|event| self.event(event, None));
        self.is_urgent = true;
        self.acknowledgements.extend(done);
    }

    /// Full rate around an event: of its gauge, or of all.
    fn write_full_rate(&mut self, event: &Event) {
        for (name, lane) in &mut self.series {
            if event.gauge.as_deref().is_none_or(|gauge| gauge == &**name) {
                let number = lane.number;
                self.samples.extend(lane.ring.trigger(event.at).map(|sample| (number, sample)));
            }
        }
    }

    /// What waits before it goes first: rows stand in the order in which things happened.
    fn intend(&mut self, entry: AuditEntry) -> Result<i64, String> {
        let mut entries = std::mem::take(&mut self.audit);
        entries.push(entry);
        match self.store.audit(&entries) {
            Ok(rows) => rows.last().copied().ok_or_else(|| "no row was written".to_owned()),
            Err(error) => {
                entries.pop();
                self.audit = entries;
                Err(error.to_string())
            }
        }
    }

    /// Writes what waits of the audit trail.
    fn write_audit(&mut self) -> Result<(), DatabaseError> {
        if !self.audit.is_empty() {
            self.store.audit(&self.audit)?;
            self.audit.clear();
        }
        Ok(())
    }

    /// Writes what is there. What could not be written is tried again with the next.
    fn write(&mut self) {
        self.due = Instant::now() + WRITE_INTERVAL;
        self.is_urgent = false;
        if let Some(text) = self.clock.detect_step(Instant::now(), Micros::now()) {
            self.event(Event { at: Micros::now(), gauge: None, kind: EventKind::Station, text }, None);
        }
        let written = self.write_audit();
        let written =
            written.and_then(|()| self.store.write(&self.samples, &self.additions, &self.events, &self.alarms));
        if let Some(crowded) = self.note_result(written) {
            let mut health = self.locked();
            health.lost_samples = health.lost_samples.saturating_add(crowded);
            drop(health);
            self.samples.clear();
            self.additions.clear();
            self.events.clear();
            self.alarms = AlarmBatch::default();
            self.acknowledgements.drain(..).for_each(|done| {
                // Whoever asked may have gone.
                done.send(()).ok();
            });
            self.prune();
        }
        *self.answered.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }

    fn prune(&mut self) {
        if Instant::now() < self.prune_at {
            return;
        }
        let more = self.store.prune(&self.settings.retention, Micros::now());
        let more = self.note_result(more) == Some(true);
        self.prune_at = Instant::now() + if more { WRITE_INTERVAL } else { PRUNE_INTERVAL };
    }

    /// Notes how it went.
    fn note_result<T>(&self, result: Result<T, DatabaseError>) -> Option<T> {
        let mut health = self.locked();
        match result {
            Ok(value) => {
                health.last_write = Some(Micros::now());
                health.error = None;
                Some(value)
            }
            Err(error) => {
                health.error = Some(error.to_string());
                None
            }
        }
    }

    fn locked(&self) -> MutexGuard<'_, Health> {
        self.health.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::super::reader::Reader;
    use super::super::sample::Quality;
    use super::*;

    #[test]
    fn who_records_and_has_died_or_hangs_is_told() {
        assert_eq!(stall_message(false, STALL_TIMEOUT), None);
        assert_eq!(
            stall_message(false, Duration::from_secs(16)).as_deref(),
            Some("the disk has not answered for 16 s")
        );
        let folder = tempfile::tempdir().unwrap();
        let mut recorder = Recorder::start(&folder.path().join("plant.db"), Settings::default()).unwrap();
        // Its thread ends, and nobody joins it.
        recorder.messages = None;
        while recorder.health().error.is_none() {
            std::thread::yield_now();
        }
        assert_eq!(recorder.health().error.as_deref(), Some("who records has died: start the station again"));
    }

    #[test]
    fn a_full_disk_is_told_and_what_waited_is_written_when_there_is_room() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let health = Arc::new(Mutex::new(Health::default()));
        let settings =
            Settings { deadband: Deadband { decades: 0.0, max_interval: Duration::ZERO }, ..Settings::default() };
        let mut work = Writer::new(Database::open(&path).unwrap(), settings, Arc::clone(&health));
        work.capacity = 5_000;
        work.store.limit_pages(20);
        let gauge: Arc<str> = Arc::from("chamber");
        let now = Micros::now().0;
        let sample = |number: i64| Sample::new(Micros(now + number), Some(1.0), Quality::Valid);
        (0..6_000).for_each(|number| work.sample(&gauge, sample(number)));
        work.write();
        let told = health.lock().unwrap().clone();
        assert!(told.error.unwrap().ends_with("database or disk is full"));
        let kept = 6_000 - told.lost_samples;
        assert!(told.lost_samples > 0 && kept > 4_900, "{kept} kept");
        work.store.limit_pages(1_000_000);
        work.write();
        assert_eq!(health.lock().unwrap().error, None);
        let samples = Reader::open(&path).unwrap().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap();
        assert_eq!(samples.len() as u64, kept);
    }

    #[test]
    fn who_is_refused_at_the_door_makes_nobody_record_at_full_rate() {
        let folder = tempfile::tempdir().unwrap();
        let health = Arc::new(Mutex::new(Health::default()));
        let store = Database::open(&folder.path().join("plant.db")).unwrap();
        let mut work = Writer::new(store, Settings::default(), health);
        let gauge: Arc<str> = Arc::from("chamber");
        let now = Micros::now();
        let sample = |number: i64| Sample::new(Micros(now.0 + number * 1000), Some(1.0), Quality::Valid);
        let event = |kind| Event { at: now, gauge: None, kind, text: "x".to_owned() };
        (0..100).for_each(|number| work.sample(&gauge, sample(number)));
        let kept = work.samples.len();
        work.event(event(EventKind::Access), None);
        (100..200).for_each(|number| work.sample(&gauge, sample(number)));
        assert_eq!(work.samples.len(), kept, "nothing has moved");
        work.event(event(EventKind::Note), None);
        assert!(work.samples.len() >= kept + 199, "all that is remembered");
    }
}
