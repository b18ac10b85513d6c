//! The thread that owns the file. Whoever measures never waits for the disk.

use super::alarms::Batch;
use super::audit::{Deed, Entry};
use super::clock::Clock;
use super::ring::Ring;
use super::rollup::Additions;
use super::sample::{Micros, Sample};
use super::store::{Event, EventKind, Retention, Store, StoreError};
use super::thin::{Band, Thinner};
use std::collections::HashMap;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SendError, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often what was measured is written: a power cut loses no more.
const PERIOD: Duration = Duration::from_secs(1);

/// How often what is old is looked for.
const PRUNING: Duration = Duration::from_secs(60);

/// So many messages may wait for the thread: ten seconds of 125 gauges at 50 Hz.
const QUEUE: usize = 65_536;

/// So many samples and spans, and so many events, are kept in memory while the disk takes none.
const UNWRITTEN: usize = 1_000_000;
const UNWRITTEN_EVENTS: usize = 10_000;

/// A disk that has not answered for so long hangs.
const QUIET: Duration = Duration::from_secs(15);

/// How long somebody who wants to know waits for the disk.
const PATIENCE: Duration = Duration::from_secs(10);

/// What is kept, and for how long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The dead band.
    pub band: Band,
    /// How much time before and after an event is kept at full rate.
    pub around: Duration,
    /// How long what is kept.
    pub retention: Retention,
}

impl Default for Settings {
    fn default() -> Self {
        Self { band: Band::default(), around: Duration::from_secs(30), retention: Retention::default() }
    }
}

/// How the recorder is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Health {
    /// When a transaction ended last.
    pub written: Option<Micros>,
    /// Why the last one failed, if it did; it is tried again.
    pub error: Option<String>,
    /// Samples that could not be kept: the queue was full, or the disk took none for long.
    pub lost: u64,
    /// Events that could not be kept, for the same reasons.
    pub lost_events: u64,
}

enum Message {
    Sample(Arc<str>, Sample),
    /// Somebody may want to know when it is on the disk.
    Event(Event, Option<Sender<()>>),
    /// A row of the audit trail, now or never: which row it is, or why there is none.
    Intent(Box<Entry>, Sender<Result<i64, String>>),
    /// A row of the audit trail that must not be lost; somebody wants to know when it is on the disk.
    Audit(Box<Entry>, Sender<()>),
    /// What became of alarms, with the events that tell it. Written at once.
    Alarms(Batch, Vec<Event>, Option<Sender<()>>),
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
    pub fn start(path: &Path, settings: Settings) -> Result<Self, StoreError> {
        let store = Store::open(path)?;
        let health = Arc::new(Mutex::new(Health::default()));
        let (messages, inbox) = sync_channel(QUEUE);
        let work = Work::new(store, settings, Arc::clone(&health));
        let answered = Arc::clone(&work.answered);
        let thread = std::thread::spawn(move || work.run(&inbox));
        Ok(Self { messages: Some(messages), health, answered, thread: Some(thread) })
    }

    /// A sample of a gauge. Never waits: what cannot be taken is counted in [`Health::lost`].
    pub fn push(&self, gauge: &Arc<str>, sample: Sample) {
        if !self.send(Message::Sample(Arc::clone(gauge), sample)) {
            count(&mut self.locked().lost);
        }
    }

    /// Something happened. Never waits: what cannot be taken is counted in [`Health::lost_events`].
    pub fn remark(&self, event: Event) {
        if !self.send(Message::Event(event, None)) {
            count(&mut self.locked().lost_events);
        }
    }

    /// Something happened. Returns when it is on the disk, `false` if that could not be had in ten seconds.
    #[must_use]
    pub fn event(&self, event: Event) -> bool {
        let (done, wait) = channel();
        let sent = self.send(Message::Event(event, Some(done)));
        if !sent {
            count(&mut self.locked().lost_events);
        }
        sent && wait.recv_timeout(PATIENCE).is_ok()
    }

    /// A row of the audit trail before something is done. Returns its number when it is on the disk; if it does not get
    /// there now, it is not tried again.
    ///
    /// # Errors
    /// Why it is not there.
    pub fn intend(&self, entry: Entry) -> Result<i64, String> {
        let (done, wait) = channel();
        if !self.send(Message::Intent(Box::new(entry), done)) {
            return Err("the recorder has too much to write".to_owned());
        }
        wait.recv_timeout(PATIENCE).unwrap_or_else(|_| Err("the disk is too slow".to_owned()))
    }

    /// A row of the audit trail after something was done. If the disk does not take it now, it is tried again.
    pub fn audit(&self, entry: Entry) -> Written {
        let (done, wait) = channel();
        let is_taken = self.send(Message::Audit(Box::new(entry), done));
        if !is_taken {
            count(&mut self.locked().lost_events);
        }
        Written(is_taken.then_some(wait))
    }

    /// What became of alarms, and the events that tell it. Never waits, and is written at once. Says whether there was room for it.
    #[must_use]
    pub fn alarms(&self, batch: Batch, events: Vec<Event>) -> bool {
        self.send(Message::Alarms(batch, events, None))
    }

    /// The same, with somebody who waits: what is returned tells when it is on the disk. The order of what is sent is the order in
    /// the file.
    #[must_use]
    pub fn alarms_and_tell(&self, batch: Batch, events: Vec<Event>) -> Written {
        let (done, wait) = channel();
        Written(self.send(Message::Alarms(batch, events, Some(done))).then_some(wait))
    }

    /// Writes what is waiting. Returns when it is on the disk, `false` if that could not be had in ten seconds.
    #[must_use]
    pub fn flush(&self) -> bool {
        let (done, wait) = channel();
        self.send(Message::Flush(done)) && wait.recv_timeout(PATIENCE).is_ok()
    }

    /// The same with what the dead band holds back, for an end at which not everybody may have let go of the recorder.
    #[must_use]
    pub fn finish(&self) -> bool {
        let (done, wait) = channel();
        self.send(Message::Finish(done)) && wait.recv_timeout(PATIENCE).is_ok()
    }

    /// How it is. Who has died or waits for a disk that hangs cannot say so.
    #[must_use]
    pub fn health(&self) -> Health {
        let silent = self.answered.lock().unwrap_or_else(PoisonError::into_inner).elapsed();
        let has_ended = self.thread.as_ref().is_some_and(JoinHandle::is_finished);
        let health = self.locked().clone();
        Health { error: silence(has_ended, silent).or(health.error), ..health }
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
fn silence(has_ended: bool, silent: Duration) -> Option<String> {
    match has_ended {
        true => Some("who records has died: start the station again".to_owned()),
        false => (silent > QUIET).then(|| format!("the disk has not answered for {} s", silent.as_secs())),
    }
}

/// Something that is on its way to the disk.
pub struct Written(Option<Receiver<()>>);

impl Written {
    /// Whether there was room for it.
    #[must_use]
    pub const fn is_taken(&self) -> bool {
        self.0.is_some()
    }

    /// Returns when it is on the disk, `false` if that could not be had in ten seconds.
    pub fn wait(self) -> bool {
        self.0.is_some_and(|wait| wait.recv_timeout(PATIENCE).is_ok())
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
struct Lane {
    number: usize,
    thinner: Thinner,
    ring: Ring,
}

struct Work {
    store: Store,
    settings: Settings,
    health: Arc<Mutex<Health>>,
    lanes: HashMap<Arc<str>, Lane>,
    samples: Vec<(usize, Sample)>,
    additions: Additions,
    events: Vec<Event>,
    audit: Vec<Entry>,
    alarms: Batch,
    /// Something is not to wait for the end of the second.
    is_urgent: bool,
    acknowledgements: Vec<Sender<()>>,
    clock: Clock,
    answered: Arc<Mutex<Instant>>,
    /// So much fits into memory.
    room: usize,
    due: Instant,
    prune_at: Instant,
}

impl Work {
    fn new(store: Store, settings: Settings, health: Arc<Mutex<Health>>) -> Self {
        let now = Instant::now();
        Self {
            store,
            settings,
            health,
            lanes: HashMap::new(),
            samples: Vec::new(),
            additions: Additions::default(),
            events: Vec::new(),
            audit: Vec::new(),
            alarms: Batch::default(),
            is_urgent: false,
            acknowledgements: Vec::new(),
            clock: Clock::new(now, Micros::now()),
            answered: Arc::new(Mutex::new(now)),
            room: UNWRITTEN,
            due: now + PERIOD,
            prune_at: now,
        }
    }

    /// Until nobody can send any more.
    fn run(mut self, inbox: &Receiver<Message>) {
        loop {
            match inbox.recv_timeout(self.due.saturating_duration_since(Instant::now())) {
                Ok(message) => self.take(message),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if self.is_urgent || !self.acknowledgements.is_empty() || Instant::now() >= self.due {
                self.write();
            }
        }
        self.let_go();
        self.write();
    }

    fn take(&mut self, message: Message) {
        match message {
            Message::Sample(gauge, sample) => self.sample(&gauge, sample),
            Message::Event(event, done) => self.event(event, done),
            Message::Intent(entry, done) => {
                let written = self.intend((*entry).clone());
                // Whoever asked has gone when it took too long, and does nothing then.
                if let Err(SendError(Ok(row))) = done.send(written) {
                    let outcome = Some("not sent: the disk was too slow".to_owned());
                    self.audit.push(Entry { what: Deed::Outcome, of: Some(row), outcome, ..*entry });
                }
            }
            Message::Audit(..) if self.audit.len() >= UNWRITTEN_EVENTS => count(&mut self.locked().lost_events),
            Message::Audit(entry, done) => {
                self.audit.push(*entry);
                self.acknowledgements.push(done);
            }
            Message::Alarms(batch, events, done) => self.alarms(batch, events, done),
            Message::Flush(done) => self.acknowledgements.push(done),
            Message::Finish(done) => {
                self.let_go();
                self.acknowledgements.push(done);
            }
        }
    }

    /// What the dead band held back is the last that is known.
    fn let_go(&mut self) {
        for lane in self.lanes.values_mut() {
            self.samples.extend(lane.thinner.flush().map(|sample| (lane.number, sample)));
        }
    }

    /// Whether nothing more fits into memory while the disk takes nothing.
    fn is_full(&self) -> bool {
        self.samples.len().saturating_add(self.additions.len()) >= self.room
    }

    fn sample(&mut self, gauge: &Arc<str>, sample: Sample) {
        if self.is_full() {
            count(&mut self.locked().lost);
            return;
        }
        if !self.lanes.contains_key(gauge) {
            let number = self.store.gauge(gauge);
            let lane = Lane { number, thinner: Thinner::default(), ring: Ring::new(self.settings.around) };
            self.lanes.insert(Arc::clone(gauge), lane);
        }
        let Some(lane) = self.lanes.get_mut(gauge) else { return };
        let number = lane.number;
        let whole = lane.ring.push(sample).then_some(sample);
        let thinned = lane.thinner.push(&self.settings.band, sample);
        self.samples.extend(whole.into_iter().chain(thinned).map(|sample| (number, sample)));
        self.additions.add(number, &sample);
    }

    fn event(&mut self, event: Event, done: Option<Sender<()>>) {
        if self.events.len() >= UNWRITTEN_EVENTS {
            count(&mut self.locked().lost_events);
            return;
        }
        // Whoever is only refused at the door must not make the record grow.
        if !self.is_full() && event.kind != EventKind::Access {
            self.around(&event);
        }
        self.events.push(event);
        self.acknowledgements.extend(done);
    }

    fn alarms(&mut self, batch: Batch, events: Vec<Event>, done: Option<Sender<()>>) {
        let lost = self.alarms.append(batch, UNWRITTEN_EVENTS);
        if lost > 0 {
            let mut health = self.locked();
            health.lost_events = health.lost_events.saturating_add(lost);
        }
        events.into_iter().for_each(|event| self.event(event, None));
        self.is_urgent = true;
        self.acknowledgements.extend(done);
    }

    /// Full rate around an event: of its gauge, or of all.
    fn around(&mut self, event: &Event) {
        for (name, lane) in &mut self.lanes {
            if event.gauge.as_deref().is_none_or(|gauge| gauge == &**name) {
                let number = lane.number;
                self.samples.extend(lane.ring.open(event.at).map(|sample| (number, sample)));
            }
        }
    }

    /// What waits before it goes first: rows stand in the order in which things happened.
    fn intend(&mut self, entry: Entry) -> Result<i64, String> {
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
    fn write_audit(&mut self) -> Result<(), StoreError> {
        if !self.audit.is_empty() {
            self.store.audit(&self.audit)?;
            self.audit.clear();
        }
        Ok(())
    }

    /// Writes what is there. What could not be written is tried again with the next.
    fn write(&mut self) {
        self.due = Instant::now() + PERIOD;
        self.is_urgent = false;
        if let Some(text) = self.clock.step(Instant::now(), Micros::now()) {
            self.event(Event { at: Micros::now(), gauge: None, kind: EventKind::Station, text }, None);
        }
        let written = self.write_audit();
        let written =
            written.and_then(|()| self.store.write(&self.samples, &self.additions, &self.events, &self.alarms));
        if let Some(crowded) = self.told(written) {
            let mut health = self.locked();
            health.lost = health.lost.saturating_add(crowded);
            drop(health);
            self.samples.clear();
            self.additions.clear();
            self.events.clear();
            self.alarms = Batch::default();
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
        let more = self.told(more) == Some(true);
        self.prune_at = Instant::now() + if more { PERIOD } else { PRUNING };
    }

    /// Notes how it went.
    fn told<T>(&self, result: Result<T, StoreError>) -> Option<T> {
        let mut health = self.locked();
        match result {
            Ok(value) => {
                health.written = Some(Micros::now());
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
        assert_eq!(silence(false, QUIET), None);
        assert_eq!(silence(false, Duration::from_secs(16)).as_deref(), Some("the disk has not answered for 16 s"));
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
        let settings = Settings { band: Band { decades: 0.0, longest: Duration::ZERO }, ..Settings::default() };
        let mut work = Work::new(Store::open(&path).unwrap(), settings, Arc::clone(&health));
        work.room = 5_000;
        work.store.limit(20);
        let gauge: Arc<str> = Arc::from("chamber");
        let now = Micros::now().0;
        let sample = |number: i64| Sample::new(Micros(now + number), Some(1.0), Quality::Valid);
        (0..6_000).for_each(|number| work.sample(&gauge, sample(number)));
        work.write();
        let told = health.lock().unwrap().clone();
        assert!(told.error.unwrap().ends_with("database or disk is full"));
        let kept = 6_000 - told.lost;
        assert!(told.lost > 0 && kept > 4_900, "{kept} kept");
        work.store.limit(1_000_000);
        work.write();
        assert_eq!(health.lock().unwrap().error, None);
        let samples = Reader::open(&path).unwrap().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap();
        assert_eq!(samples.len() as u64, kept);
    }

    #[test]
    fn who_is_refused_at_the_door_makes_nobody_record_at_full_rate() {
        let folder = tempfile::tempdir().unwrap();
        let health = Arc::new(Mutex::new(Health::default()));
        let store = Store::open(&folder.path().join("plant.db")).unwrap();
        let mut work = Work::new(store, Settings::default(), health);
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
