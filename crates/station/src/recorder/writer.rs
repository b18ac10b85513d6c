//! The thread that owns the file. Whoever measures never waits for the disk.

use super::ring::Ring;
use super::rollup::Additions;
use super::sample::{Micros, Sample};
use super::store::{Event, Retention, Store, StoreError};
use super::thin::{Band, Thinner};
use std::collections::HashMap;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, TrySendError, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often what was measured is written: a power cut loses no more.
const PERIOD: Duration = Duration::from_secs(1);

/// How often what is old is looked for.
const PRUNING: Duration = Duration::from_secs(60);

/// So many messages may wait for the thread: ten seconds of 125 gauges at 50 Hz.
const QUEUE: usize = 65_536;

/// So many samples are kept in memory while the disk takes none.
const UNWRITTEN: usize = 1_000_000;

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
}

enum Message {
    Sample(Arc<str>, Sample),
    Event(Event, Sender<()>),
    Flush(Sender<()>),
}

/// Takes samples and events from any thread.
pub struct Recorder {
    messages: Option<SyncSender<Message>>,
    health: Arc<Mutex<Health>>,
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
        let thread = std::thread::spawn(move || work.run(&inbox));
        Ok(Self { messages: Some(messages), health, thread: Some(thread) })
    }

    /// A sample of a gauge. Never waits: what cannot be taken is counted in [`Health::lost`].
    pub fn push(&self, gauge: &Arc<str>, sample: Sample) {
        let Some(messages) = &self.messages else { return };
        if let Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) =
            messages.try_send(Message::Sample(Arc::clone(gauge), sample))
        {
            let mut health = self.health.lock().unwrap_or_else(PoisonError::into_inner);
            health.lost = health.lost.saturating_add(1);
        }
    }

    /// Something happened. Returns when it is on the disk, `false` if that could not be had in time.
    #[must_use]
    pub fn event(&self, event: Event) -> bool {
        self.acknowledged(|done| Message::Event(event, done))
    }

    /// Writes what is waiting. Returns when it is on the disk, `false` if that could not be had in time.
    #[must_use]
    pub fn flush(&self) -> bool {
        self.acknowledged(Message::Flush)
    }

    /// How it is.
    #[must_use]
    pub fn health(&self) -> Health {
        self.health.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn acknowledged(&self, message: impl FnOnce(Sender<()>) -> Message) -> bool {
        let (done, wait) = channel();
        let sent = self.messages.as_ref().is_some_and(|messages| messages.send(message(done)).is_ok());
        sent && wait.recv_timeout(Duration::from_secs(10)).is_ok()
    }
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
    number: i64,
    thinner: Thinner,
    ring: Ring,
}

struct Work {
    store: Store,
    settings: Settings,
    health: Arc<Mutex<Health>>,
    lanes: HashMap<Arc<str>, Lane>,
    samples: Vec<(i64, Sample)>,
    additions: Additions,
    events: Vec<Event>,
    acknowledgements: Vec<Sender<()>>,
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
            acknowledgements: Vec::new(),
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
            if !self.acknowledgements.is_empty() || Instant::now() >= self.due {
                self.write();
            }
        }
        // What the dead band held back is the last that is known.
        for lane in self.lanes.values_mut() {
            self.samples.extend(lane.thinner.flush().map(|sample| (lane.number, sample)));
        }
        self.write();
    }

    fn take(&mut self, message: Message) {
        match message {
            Message::Sample(gauge, sample) => self.sample(&gauge, sample),
            Message::Flush(done) => self.acknowledgements.push(done),
            Message::Event(event, done) => {
                self.around(&event);
                self.events.push(event);
                self.acknowledgements.push(done);
            }
        }
    }

    fn sample(&mut self, gauge: &Arc<str>, sample: Sample) {
        if self.samples.len() >= UNWRITTEN {
            self.lose();
            return;
        }
        let Some(lane) = self.lane(gauge) else { return self.lose() };
        let number = lane.number;
        let open = lane.ring.push(sample);
        let band = self.settings.band;
        let Some(lane) = self.lanes.get_mut(gauge) else { return };
        if open {
            self.samples.push((number, sample));
        }
        self.samples.extend(lane.thinner.push(&band, sample).map(|sample| (number, sample)));
        self.additions.add(number, &sample);
    }

    fn lane(&mut self, gauge: &Arc<str>) -> Option<&mut Lane> {
        if !self.lanes.contains_key(gauge) {
            let number = self.store.gauge(gauge);
            let number = self.told(number)?;
            let lane = Lane { number, thinner: Thinner::default(), ring: Ring::new(self.settings.around) };
            self.lanes.insert(Arc::clone(gauge), lane);
        }
        self.lanes.get_mut(gauge)
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

    /// Writes what is there. What could not be written is tried again with the next.
    fn write(&mut self) {
        self.due = Instant::now() + PERIOD;
        let written = self.store.write(&self.samples, &self.additions, &self.events);
        if self.told(written).is_some() {
            self.samples.clear();
            self.additions.clear();
            self.events.clear();
            self.acknowledgements.drain(..).for_each(|done| {
                // Whoever asked may have gone.
                done.send(()).ok();
            });
            self.prune();
        }
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
        let mut health = self.health.lock().unwrap_or_else(PoisonError::into_inner);
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

    fn lose(&self) {
        let mut health = self.health.lock().unwrap_or_else(PoisonError::into_inner);
        health.lost = health.lost.saturating_add(1);
    }
}
