//! The thread: filters, waiting rows, transactions.

use super::{Health, Message, Settings, Unwritten, count};
use crate::alarms::AlarmBatch;
use crate::clock::{Clock, ClockMonitor};
use crate::database::{Database, NewPoints};
use crate::deadband::DeadbandFilter;
use crate::error::{AuditError, DatabaseError};
use crate::outbox::Acknowledgement;
use crate::point::{Point, PointSample};
use crate::recorded::Recorded;
use crate::retention::ends_period;
use crate::ring::RingBuffer;
use crate::sample::{Micros, Sample};
use crate::spans::PendingSpans;
use crate::state::StationState;
use profivac_model::{AlarmStatus, AuditAction, AuditEntry, Declaration, Event, EventKind};
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SendError, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The time between two transactions: a power cut loses no more than this.
const WRITE_INTERVAL: Duration = Duration::from_secs(1);

/// The time between two searches for rows beyond the retention.
const PRUNE_INTERVAL: Duration = Duration::from_secs(60);

/// The most samples and spans that are kept in memory while the disk accepts no writes.
const MAX_UNWRITTEN: usize = 1_000_000;

/// The most events, and rows of each other kind, that are kept in memory while the disk accepts no writes.
const MAX_UNWRITTEN_EVENTS: usize = 10_000;

/// The event in a database that was created again.
const REPLACED: &str = "the database was deleted or replaced while the station recorded into it: this file begins here with the present \
                        states of the alarms; earlier samples, events, audit entries and waiting notifications are in the former file";

/// The filters of one series.
struct SeriesState<T: Recorded = Sample> {
    index: usize,
    deadband: DeadbandFilter<T>,
    ring: RingBuffer<T>,
}

impl<T: Recorded> SeriesState<T> {
    fn new(index: usize, full_rate_window: Duration) -> Self {
        Self { index, deadband: DeadbandFilter::default(), ring: RingBuffer::new(full_rate_window) }
    }

    /// The samples that are kept now, with a deadband of this width.
    fn kept(&mut self, width: f64, max_interval: Duration, sample: T) -> impl Iterator<Item = (usize, T)> + use<T> {
        let full_rate = self.ring.push(sample).then_some(sample);
        let kept = self.deadband.push_within(width, max_interval, sample);
        let index = self.index;
        full_rate.into_iter().chain(kept).map(move |sample| (index, sample))
    }

    /// The samples before an event, which are kept after all.
    fn around(&mut self, at: Micros) -> impl Iterator<Item = (usize, T)> {
        let index = self.index;
        self.ring.trigger(at).map(move |sample| (index, sample))
    }

    /// The sample that the deadband holds back.
    fn flush(&mut self) -> Option<(usize, T)> {
        self.deadband.flush().map(|sample| (self.index, sample))
    }
}

/// The state of the thread.
pub(super) struct Writer {
    database: Database,
    settings: Settings,
    health: Arc<Mutex<Health>>,
    series: HashMap<Arc<str>, SeriesState>,
    samples: Vec<(usize, Sample)>,
    spans: PendingSpans,
    points: HashMap<Arc<Point>, SeriesState<PointSample>>,
    new_points: NewPoints,
    events: Vec<Event>,
    audit: Vec<AuditEntry>,
    alarms: AlarmBatch,
    /// The states of all alarms, for a database that is created again.
    alarm_states: BTreeMap<String, AlarmStatus>,
    /// The same with the declared plant states.
    plant_states: BTreeMap<String, Declaration>,
    /// The states of the station that are not on the disk yet, by name.
    states: BTreeMap<&'static str, StationState>,
    /// Write before the end of the interval.
    is_urgent: bool,
    /// Answers about the batches of the outbox that are not noted yet.
    acknowledged: Option<Acknowledgement>,
    /// The epoch and the first number of batches that the archive has of another copy of the database.
    copied: Option<(i64, i64)>,
    receipts: Vec<Sender<()>>,
    clock: Arc<dyn Clock>,
    monitor: ClockMonitor,
    /// The database knows that this recorder records.
    is_recording: bool,
    /// The clock was set, and a recording period begins at this time.
    period_begins: Option<PeriodChange>,
    pub(super) answered: Arc<Mutex<Instant>>,
    /// The messages that wait, for [`Recorder`](super::Recorder).
    pub(super) waiting: Arc<AtomicUsize>,
    /// The most samples and spans in memory.
    capacity: usize,
    write_at: Instant,
    prune_at: Instant,
}

/// A step of the clock that ends a recording period.
#[derive(Clone, Copy)]
struct PeriodChange {
    /// The latest time of the period before.
    until: Micros,
    /// The first time of the next period.
    from: Micros,
}

/// Applies changed states by name; `None` removes one.
fn apply<T: Clone>(states: &mut BTreeMap<String, T>, changes: &BTreeMap<String, Option<T>>) {
    for (name, state) in changes {
        match state {
            Some(state) => drop(states.insert(name.clone(), state.clone())),
            None => drop(states.remove(name)),
        }
    }
}

impl Writer {
    pub(super) fn new(
        mut database: Database,
        settings: Settings,
        health: Arc<Mutex<Health>>,
        clock: Arc<dyn Clock>,
    ) -> Self {
        database.set_outbox(settings.outbox);
        let now = Instant::now();
        let clock_time = clock.now();
        Self {
            database,
            settings,
            health,
            series: HashMap::new(),
            samples: Vec::new(),
            spans: PendingSpans::default(),
            points: HashMap::new(),
            new_points: NewPoints::default(),
            events: Vec::new(),
            audit: Vec::new(),
            alarms: AlarmBatch::default(),
            alarm_states: BTreeMap::new(),
            plant_states: BTreeMap::new(),
            states: BTreeMap::new(),
            is_urgent: false,
            acknowledged: None,
            copied: None,
            receipts: Vec::new(),
            monitor: ClockMonitor::new(clock_time),
            is_recording: false,
            period_begins: None,
            answered: Arc::new(Mutex::new(now)),
            waiting: Arc::default(),
            capacity: MAX_UNWRITTEN,
            write_at: now + WRITE_INTERVAL,
            prune_at: clock_time.monotonic,
            clock,
        }
    }

    /// The same with the states of the alarms and the declared plant states in the database.
    pub(super) fn with_states(
        self,
        alarm_states: BTreeMap<String, AlarmStatus>,
        plant_states: BTreeMap<String, Declaration>,
    ) -> Self {
        Self { alarm_states, plant_states, ..self }
    }

    /// Runs until the last sender is dropped.
    pub(super) fn run(mut self, inbox: &Receiver<Message>) {
        loop {
            match inbox.recv_timeout(self.write_at.saturating_duration_since(Instant::now())) {
                Ok(message) => {
                    self.waiting.fetch_sub(1, Ordering::Relaxed);
                    self.handle(message);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if self.is_urgent || !self.receipts.is_empty() || Instant::now() >= self.write_at {
                // The health says why it failed; the next interval tries again.
                self.write().ok();
            }
        }
        self.flush_deadbands();
        self.write().ok();
    }

    fn handle(&mut self, message: Message) {
        match message {
            Message::Sample(series, sample) => self.sample(&series, sample),
            Message::Point(point, deadband, sample) => self.point(&point, deadband, sample),
            Message::PointTexts(points) => self.database.set_point_texts(points),
            Message::Event(event, done) => self.event(event, done),
            Message::AuditBeforeSending(entry, done) => {
                let written = self.audit_now((*entry).clone());
                // The requester has timed out and has sent nothing, so the row gets an outcome.
                if let Err(SendError(Ok(row))) = done.send(written) {
                    let outcome = Some("not sent: the disk was too slow".to_owned());
                    let action = AuditAction::Outcome.into();
                    self.audit.push(AuditEntry { action, refers_to: Some(row), outcome, ..*entry });
                }
            }
            Message::Audit(..) if self.audit.len() >= MAX_UNWRITTEN_EVENTS => count(&mut self.locked().lost_events),
            Message::Audit(entry, done) => {
                self.audit.push(*entry);
                self.receipts.push(done);
            }
            Message::Alarms(batch, events, done) => self.alarms(batch, events, done),
            Message::OutboxAcknowledged(answer) => {
                self.acknowledged = Some(self.acknowledged.map_or(answer, |before| before.and(answer)));
            }
            Message::OutboxCopied(epoch, first) => self.copied = Some((epoch, first)),
            Message::State(state) => drop(self.states.insert(state.name, state)),
            Message::Flush(done) => self.receipts.push(done),
            Message::EventOrNothing(event, until, done) => {
                let written = self.event_or_nothing(event, until);
                // The requester may have timed out.
                done.send(written).ok();
            }
            Message::Finish(done) => {
                self.flush_deadbands();
                let written = self.write().map_err(|error| self.unwritten(&error));
                done.send(written).ok();
            }
        }
    }

    /// Writes an event with the rows that wait, unless `until` has passed. A transaction that fails leaves the event out.
    fn event_or_nothing(&mut self, event: Event, until: Instant) -> Result<(), AuditError> {
        if Instant::now() >= until {
            return Err(AuditError::Timeout);
        }
        let index = self.events.len();
        if index >= MAX_UNWRITTEN_EVENTS {
            return Err(AuditError::QueueFull);
        }
        self.event(event, None);
        self.write().map_err(|error| {
            self.events.remove(index);
            error.into()
        })
    }

    /// What is lost if the recorder ends now.
    fn unwritten(&self, error: &DatabaseError) -> Unwritten {
        let health = self.locked();
        let rows = self.events.len().saturating_add(self.audit.len()).saturating_add(self.alarms.len());
        Unwritten {
            error: error.to_string(),
            samples: health
                .lost_samples
                .saturating_add(self.samples.len() as u64)
                .saturating_add(self.new_points.samples.len() as u64),
            rows: health.lost_events.saturating_add(rows as u64),
        }
    }

    /// Records the sample that each deadband holds back: it is the last one of its series.
    fn flush_deadbands(&mut self) {
        self.samples.extend(self.series.values_mut().filter_map(SeriesState::flush));
        self.new_points.samples.extend(self.points.values_mut().filter_map(SeriesState::flush));
    }

    /// Whether the memory is full while the disk accepts no writes.
    fn is_full(&self) -> bool {
        self.samples.len().saturating_add(self.spans.len()).saturating_add(self.new_points.len()) >= self.capacity
    }

    fn sample(&mut self, series: &Arc<str>, sample: Sample) {
        if self.is_full() {
            count(&mut self.locked().lost_samples);
            return;
        }
        if !self.series.contains_key(series) {
            let index = self.database.series_index(series);
            self.series.insert(Arc::clone(series), SeriesState::new(index, self.settings.full_rate_window));
        }
        let Some(state) = self.series.get_mut(series) else { return };
        let band = self.settings.deadband;
        self.samples.extend(state.kept(band.decades, band.max_interval, sample));
        self.spans.add(state.index, &sample);
    }

    fn point(&mut self, point: &Arc<Point>, deadband: f64, sample: PointSample) {
        if self.is_full() {
            count(&mut self.locked().lost_samples);
            return;
        }
        if !self.points.contains_key(point) {
            let index = self.database.point_index(point);
            self.points.insert(Arc::clone(point), SeriesState::new(index, self.settings.full_rate_window));
        }
        let Some(state) = self.points.get_mut(point) else { return };
        self.new_points.samples.extend(state.kept(deadband, self.settings.deadband.max_interval, sample));
        self.new_points.spans.add(state.index, &sample);
    }

    fn event(&mut self, event: Event, done: Option<Sender<()>>) {
        if self.events.len() >= MAX_UNWRITTEN_EVENTS {
            count(&mut self.locked().lost_events);
            return;
        }
        // Refused logins must not let an unauthenticated client make the database grow.
        if !self.is_full() && event.kind != EventKind::Access {
            self.write_full_rate(&event);
        }
        self.events.push(event);
        self.receipts.extend(done);
    }

    fn alarms(&mut self, batch: AlarmBatch, events: Vec<Event>, done: Option<Sender<()>>) {
        apply(&mut self.alarm_states, &batch.alarms);
        apply(&mut self.plant_states, &batch.plant_states);
        let dropped = self.alarms.append(batch, MAX_UNWRITTEN_EVENTS);
        if dropped > 0 {
            let mut health = self.locked();
            health.lost_events = health.lost_events.saturating_add(dropped);
        }
        events.into_iter().for_each(|event| self.event(event, None));
        self.is_urgent = true;
        self.receipts.extend(done);
    }

    /// Keeps every sample around an event: of its gauge or slave, or of all series.
    fn write_full_rate(&mut self, event: &Event) {
        let concerns = |name: &str| event.gauge.as_deref().is_none_or(|gauge| gauge == name);
        for (_, state) in self.series.iter_mut().filter(|(name, _)| concerns(name)) {
            self.samples.extend(state.around(event.at));
        }
        for (_, state) in self.points.iter_mut().filter(|(point, _)| concerns(&point.slave)) {
            self.new_points.samples.extend(state.around(event.at));
        }
    }

    /// Writes a row now, after the rows that wait, so that the rows are in the order of the actions.
    fn audit_now(&mut self, entry: AuditEntry) -> Result<i64, AuditError> {
        let mut entries = std::mem::take(&mut self.audit);
        entries.push(entry);
        match self.database.audit(&entries) {
            Ok(rows) => rows.last().copied().ok_or(AuditError::NoRow),
            Err(error) => {
                entries.pop();
                self.audit = entries;
                Err(error.into())
            }
        }
    }

    /// Writes the rows of the audit trail that wait.
    fn write_audit(&mut self) -> Result<(), DatabaseError> {
        if !self.audit.is_empty() {
            self.database.audit(&self.audit)?;
            self.audit.clear();
        }
        Ok(())
    }

    /// Writes the states of the station that wait.
    fn write_states(&mut self) -> Result<(), DatabaseError> {
        while let Some(entry) = self.states.first_entry() {
            self.database.store_state(entry.get())?;
            entry.remove();
        }
        Ok(())
    }

    /// Writes everything in memory. Rows that cannot be written are tried again in the next interval.
    fn write(&mut self) -> Result<(), DatabaseError> {
        self.write_at = Instant::now() + WRITE_INTERVAL;
        self.is_urgent = false;
        self.check_clock();
        self.database.set_time(self.monitor.last().wall);
        let written = self.check_database().and_then(|()| self.write_audit());
        let written = written.and_then(|()| self.write_states()).and_then(|()| self.acknowledge());
        let written = written.and_then(|()| {
            let (samples, spans) = (&self.samples, &self.spans);
            self.database.write_with_points(samples, spans, &self.new_points, &self.events, &self.alarms)
        });
        let written = self.note_result(written).map(|crowded| {
            let mut health = self.locked();
            health.lost_samples = health.lost_samples.saturating_add(crowded);
            drop(health);
            self.samples.clear();
            self.spans.clear();
            self.new_points.clear();
            self.events.clear();
            self.alarms = AlarmBatch::default();
            self.receipts.drain(..).for_each(|done| {
                // The requester may have timed out.
                done.send(()).ok();
            });
            self.prune();
        });
        *self.answered.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
        written
    }

    /// Notes the answers about the batches of the outbox.
    fn acknowledge(&mut self) -> Result<(), DatabaseError> {
        if let Some(answer) = self.acknowledged.take() {
            self.database.acknowledge_outbox(answer)?;
        }
        if let Some((epoch, first)) = self.copied.take() {
            self.database.branch_outbox(epoch, first)?;
        }
        Ok(())
    }

    /// Reports a step of the clock. A large one begins a recording period, and rows are counted against their retention at once.
    fn check_clock(&mut self) {
        let Some(step) = self.monitor.detect_step(self.clock.now()) else { return };
        self.station_event(step.to_string());
        self.prune_at = self.monitor.last().monotonic;
        if ends_period(&step) {
            let until = self.period_begins.map_or(step.until, |change| change.until);
            self.period_begins = Some(PeriodChange { until, from: step.from });
        }
    }

    /// Opens the database again if it was deleted, and notes in it that this recorder records.
    fn check_database(&mut self) -> Result<(), DatabaseError> {
        self.database.reopen_if_replaced()?;
        if self.database.take_replaced() {
            self.is_recording = false;
            // Changes of alarms that are not written yet are later than these states.
            for (name, state) in &self.alarm_states {
                self.alarms.alarms.insert(name.clone(), Some(state.clone()));
            }
            for (name, state) in &self.plant_states {
                self.alarms.plant_states.insert(name.clone(), Some(state.clone()));
            }
            self.station_event(REPLACED.to_owned());
        }
        if !self.is_recording {
            let found = self.database.resume_recording(self.monitor.last().wall)?;
            self.is_recording = true;
            self.period_begins = None;
            if let Some(found) = found {
                self.station_event(found.to_string());
            }
        } else if let Some(change) = self.period_begins {
            self.database.extend_period(change.until)?;
            self.database.begin_period(change.from)?;
            self.period_begins = None;
        }
        Ok(())
    }

    fn station_event(&mut self, text: String) {
        self.event(Event { at: self.monitor.last().wall, gauge: None, kind: EventKind::Station.into(), text }, None);
    }

    fn prune(&mut self) {
        let now = self.monitor.last();
        if now.monotonic < self.prune_at {
            return;
        }
        let extended = self.database.extend_period(now.wall);
        let more = extended.and_then(|()| self.database.prune(&self.settings.retention));
        let more = self.note_result(more).is_ok_and(|more| more);
        self.prune_at = now.monotonic + if more { WRITE_INTERVAL } else { PRUNE_INTERVAL };
    }

    /// Stores the result of a transaction in the health.
    fn note_result<T>(&self, result: Result<T, DatabaseError>) -> Result<T, DatabaseError> {
        let mut health = self.locked();
        health.error = result.as_ref().err().map(ToString::to_string);
        if result.is_ok() {
            health.last_write = Some(self.monitor.last().wall);
        }
        result
    }

    fn locked(&self) -> MutexGuard<'_, Health> {
        self.health.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::SystemClock;
    use crate::deadband::Deadband;
    use crate::quality::Quality;
    use crate::reader::Reader;

    /// A writer of a new database in `folder`.
    fn writer(folder: &tempfile::TempDir) -> Writer {
        let database = Database::open(&folder.path().join("plant.db"), Micros::now()).unwrap();
        Writer::new(database, Settings::default(), Arc::default(), Arc::new(SystemClock))
    }

    fn note(text: &str) -> Event {
        Event { at: Micros::now(), gauge: None, kind: EventKind::Note.into(), text: text.to_owned() }
    }

    #[test]
    fn a_note_that_a_full_disk_refuses_is_not_stored_later() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = writer(&folder);
        writer.write().unwrap();
        writer.database.limit_pages(1);
        let soon = Instant::now() + Duration::from_secs(60);
        // More than the free room of the last page.
        let refused = writer.event_or_nothing(note(&"x".repeat(20_000)), soon);
        assert!(matches!(refused, Err(AuditError::Database(_))), "{refused:?}");
        writer.database.limit_pages(1_000_000);
        let late = writer.event_or_nothing(note("late"), Instant::now());
        assert!(matches!(late, Err(AuditError::Timeout)), "its requester has gone");
        writer.event_or_nothing(note("again"), soon).unwrap();
        let events = Reader::open(&folder.path().join("plant.db")).unwrap();
        let events = events.events(Micros(0), Micros(i64::MAX), 100).unwrap();
        let notes: Vec<_> = events.iter().filter(|event| event.kind == EventKind::Note).map(|it| &*it.text).collect();
        assert_eq!(notes, ["again"]);
    }

    #[test]
    fn an_end_that_cannot_write_says_at_once_what_is_lost() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = writer(&folder);
        writer.write().unwrap();
        writer.database.limit_pages(1);
        let series: Arc<str> = Arc::from("chamber");
        let now = Micros::now().0;
        (0..3).for_each(|at| writer.sample(&series, Sample::new(Micros(now + at), Some(1.0), Quality::Valid)));
        writer.event(note(&"x".repeat(20_000)), None);
        let (done, wait) = std::sync::mpsc::channel();
        writer.handle(Message::Finish(done));
        let lost = wait.try_recv().unwrap().unwrap_err();
        assert!(lost.samples >= 2 && lost.rows == 1, "{lost:?}");
        let sentence = lost.to_string();
        assert!(
            sentence.contains("database or disk is full") && sentence.contains("other rows are lost"),
            "{sentence}"
        );
    }

    #[test]
    fn a_full_disk_is_reported_and_samples_in_memory_are_written_when_there_is_room() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let health = Arc::new(Mutex::new(Health::default()));
        let deadband = Deadband { decades: 0.0, max_interval: Duration::ZERO };
        let settings = Settings { deadband, ..Settings::default() };
        let mut writer = Writer::new(
            Database::open(&path, Micros::now()).unwrap(),
            settings,
            Arc::clone(&health),
            Arc::new(SystemClock),
        );
        writer.capacity = 5_000;
        writer.database.limit_pages(20);
        let series: Arc<str> = Arc::from("chamber");
        let now = Micros::now().0;
        let sample = |number: i64| Sample::new(Micros(now + number), Some(1.0), Quality::Valid);
        (0..6_000).for_each(|number| writer.sample(&series, sample(number)));
        writer.write().ok();
        let full = health.lock().unwrap().clone();
        assert!(full.error.unwrap().ends_with("database or disk is full"));
        let kept = 6_000 - full.lost_samples;
        assert!(full.lost_samples > 0 && kept > 4_900, "{kept} kept");
        writer.database.limit_pages(1_000_000);
        writer.write().ok();
        assert_eq!(health.lock().unwrap().error, None);
        let samples = Reader::open(&path).unwrap().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap();
        assert_eq!(samples.len() as u64, kept);
    }

    #[test]
    fn an_access_event_does_not_trigger_the_full_sample_rate() {
        let folder = tempfile::tempdir().unwrap();
        let health = Arc::new(Mutex::new(Health::default()));
        let database = Database::open(&folder.path().join("plant.db"), Micros::now()).unwrap();
        let mut writer = Writer::new(database, Settings::default(), health, Arc::new(SystemClock));
        let series: Arc<str> = Arc::from("chamber");
        let now = Micros::now();
        let sample = |number: i64| Sample::new(Micros(now.0 + number * 1000), Some(1.0), Quality::Valid);
        let event = |kind: EventKind| Event { at: now, gauge: None, kind: kind.into(), text: "x".to_owned() };
        (0..100).for_each(|number| writer.sample(&series, sample(number)));
        let kept = writer.samples.len();
        writer.event(event(EventKind::Access), None);
        (100..200).for_each(|number| writer.sample(&series, sample(number)));
        assert_eq!(writer.samples.len(), kept, "the pressure is steady");
        writer.event(event(EventKind::Note), None);
        assert!(writer.samples.len() >= kept + 199, "every sample of the window is kept");
    }
}
