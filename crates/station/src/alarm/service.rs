//! The alarms of a running station, as its threads share them: one looks, people act, all see.
//!
//! What changes is handed to the recorder while the book is held, so the order in the file is the order in which it happened.
//! Nobody waits for the disk with the book in hand.

use super::evaluate::Inputs;
use super::persistence::{NotificationTarget, rows_and_events};
use super::registry::{AlarmChange, AlarmError, AlarmRegistry, AlarmStatus, AlarmTime, ChangeKind};
use super::rule::Rule;
use super::state::AlarmState;
use super::view::{AlarmOverview, AlarmView};
use crate::control::Actor;
use crate::services::Services;
use profivac_recorder::alarms::{AlarmBatch, AlarmHistoryEntry};
use profivac_recorder::{DatabaseError, Event, Micros, Reader, Recorder, WriteReceipt};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// When nobody has looked for so long, what is told of alarms cannot be believed any more.
const EVALUATION_TIMEOUT: Duration = Duration::from_secs(5);

/// Why somebody could not do what they wanted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AlarmServiceError {
    /// The alarm does not allow it.
    #[error(transparent)]
    Refused(#[from] AlarmError),
    /// It is done, and nobody knows whether it outlives the program.
    #[error("it is done and could not be written to the disk: it may be lost when the station is started again")]
    NotStored,
}

/// All alarms.
pub struct AlarmService {
    begun: Instant,
    inner: Mutex<Inner>,
}

#[derive(Default)]
struct Inner {
    registry: AlarmRegistry,
    /// The name of the station, for letters.
    station: String,
    targets: Vec<NotificationTarget>,
    /// When somebody looked last; nothing while nothing is watched.
    evaluated_at: Option<Instant>,
    /// What the recorder had no room for.
    unwritten: (AlarmBatch, Vec<Event>),
}

/// So many lines wait for room.
const MAX_UNWRITTEN: usize = 10_000;

impl Default for AlarmService {
    fn default() -> Self {
        Self { begun: Instant::now(), inner: Mutex::default() }
    }
}

impl AlarmService {
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> AlarmTime {
        AlarmTime { monotonic: Micros(0).after(self.begun.elapsed()), wall: Micros::now() }
    }

    /// Begins with what the record knows, and these alarms.
    ///
    /// # Errors
    /// [`StoreError`] when the record cannot be read.
    pub fn begin(
        &self,
        plant: &Services,
        rules: Vec<Rule>,
        addressees: Vec<NotificationTarget>,
    ) -> Result<(), DatabaseError> {
        let reader = plant.open_reader()?;
        let kept = reader.alarms()?.into_iter().map(|(name, kept)| (name, AlarmStatus::from(kept)));
        let is_meant = |name: &str| rules.iter().any(|rule| rule.name == name);
        let (kept, gone): (Vec<_>, Vec<_>) = kept.partition(|(name, _)| is_meant(name));
        let farewell = removal_entries(&reader, gone)?;
        let mut desk = self.lock();
        desk.station = plant.name().to_owned();
        desk.targets = addressees;
        let changes = desk.registry.reconfigure(rules, kept, self.now());
        desk.evaluated_at = Some(Instant::now());
        desk.unwritten.0.append(farewell, MAX_UNWRITTEN);
        desk.write(plant.recorder(), &changes);
        Ok(())
    }

    /// Becomes what a changed file says; what did not change stays where it stands.
    pub fn reconfigure(&self, recorder: &Recorder, rules: Vec<Rule>, addressees: Vec<NotificationTarget>) {
        let mut desk = self.lock();
        desk.targets = addressees;
        let changes = desk.registry.reconfigure(rules, Vec::new(), self.now());
        desk.write(recorder, &changes);
    }

    /// Looks at what the plant shows.
    pub fn evaluate(&self, recorder: &Recorder, sight: &Inputs) {
        let mut desk = self.lock();
        let changes = desk.registry.evaluate(sight, self.now());
        desk.evaluated_at = Some(Instant::now());
        desk.write(recorder, &changes);
    }

    /// Nobody looks any more, and nobody is to: the station ends.
    pub fn end(&self) {
        self.lock().evaluated_at = None;
    }

    /// Somebody has seen this occurrence of an alarm. On the disk when this returns.
    ///
    /// # Errors
    /// [`NotDone`] says why not.
    pub fn acknowledge(
        &self,
        recorder: &Recorder,
        name: &str,
        occurrence: i64,
        actor: &Actor,
    ) -> Result<AlarmView, AlarmServiceError> {
        let now = self.now();
        self.change_alarm(recorder, name, actor, |book, who| book.acknowledge(name, occurrence, who, now))
    }

    /// Somebody has seen these occurrences of alarms. What came of each; on the disk, together, when this returns.
    pub fn acknowledge_all(
        &self,
        recorder: &Recorder,
        seen: Vec<(String, i64)>,
        actor: &Actor,
    ) -> Vec<(String, Result<(), AlarmServiceError>)> {
        let now = self.now();
        let mut desk = self.lock();
        let mut changes = Vec::new();
        let mut done: Vec<(String, Result<(), AlarmServiceError>)> = Vec::new();
        for (name, occurrence) in seen {
            let acknowledged = desk.registry.acknowledge(&name, occurrence, &actor.user.name, now);
            done.push((name, acknowledged.map(|change| changes.push(change)).map_err(AlarmServiceError::from)));
        }
        let written = desk.write_with_receipt(recorder, &changes, actor);
        drop(desk);
        if !written.wait() {
            done.iter_mut()
                .filter(|(_, done)| done.is_ok())
                .for_each(|(_, done)| *done = Err(AlarmServiceError::NotStored));
        }
        done
    }

    /// Takes an alarm out of service, for a time or until somebody puts it back. On the disk when this returns.
    ///
    /// # Errors
    /// [`NotDone`] says why not.
    pub fn take_out_of_service(
        &self,
        recorder: &Recorder,
        name: &str,
        actor: &Actor,
        reason: &str,
        time: Option<Duration>,
    ) -> Result<AlarmView, AlarmServiceError> {
        let now = self.now();
        self.change_alarm(recorder, name, actor, |book, who| book.take_out_of_service(name, who, reason, time, now))
    }

    /// Puts an alarm back into service. On the disk when this returns.
    ///
    /// # Errors
    /// [`NotDone`] says why not.
    pub fn return_to_service(
        &self,
        recorder: &Recorder,
        name: &str,
        actor: &Actor,
    ) -> Result<AlarmView, AlarmServiceError> {
        let now = self.now();
        self.change_alarm(recorder, name, actor, |book, who| book.return_to_service(name, who, now))
    }

    fn change_alarm(
        &self,
        recorder: &Recorder,
        name: &str,
        actor: &Actor,
        act: impl FnOnce(&mut AlarmRegistry, &str) -> Result<AlarmChange, AlarmError>,
    ) -> Result<AlarmView, AlarmServiceError> {
        let mut desk = self.lock();
        let change = act(&mut desk.registry, &actor.user.name)?;
        let written = desk.write_with_receipt(recorder, std::slice::from_ref(&change), actor);
        let entry = desk.registry.entries().iter().find(|entry| entry.rule().name == name).map(AlarmView::from);
        drop(desk);
        let alarm = entry.ok_or_else(|| AlarmError::Unknown(name.to_owned()))?;
        if written.wait() { Ok(alarm) } else { Err(AlarmServiceError::NotStored) }
    }

    /// All of them, in the order of the file.
    #[must_use]
    pub fn all(&self) -> Vec<AlarmView> {
        self.lock().registry.entries().iter().map(AlarmView::from).collect()
    }

    /// What must be known at a moment.
    #[must_use]
    pub fn overview(&self) -> AlarmOverview {
        let desk = self.lock();
        AlarmOverview::of(desk.registry.entries(), desk.trouble(Instant::now()))
    }

    /// How long ago somebody looked, if somebody is to.
    #[must_use]
    pub fn evaluated_ago(&self) -> Option<Duration> {
        self.lock().evaluated_at.map(|looked| looked.elapsed())
    }
}

/// What is written of alarms that do not stand in the file any more, while nobody looked: a line for each that was not normal.
fn removal_entries(reader: &Reader, gone: Vec<(String, AlarmStatus)>) -> Result<AlarmBatch, DatabaseError> {
    let mut batch = AlarmBatch::default();
    for (name, life) in gone {
        // What else is known of it stands in its last line.
        let last = reader.alarm_history(Micros(i64::MIN), Micros(i64::MAX), Some(&name), 1)?.pop();
        let text = format!("it does not stand in the file any more (it was {})", life.state.word());
        let (what, state) = (ChangeKind::Removed.word().to_owned(), AlarmState::Normal.word().to_owned());
        let line = last.map(|last| AlarmHistoryEntry {
            at: Micros::now(),
            change: what,
            state,
            user: None,
            value: None,
            text,
            ..last
        });
        batch.history.extend(line.filter(|_| life.state != AlarmState::Normal));
        batch.alarms.insert(name, None);
    }
    Ok(batch)
}

impl Inner {
    fn trouble(&self, now: Instant) -> Option<String> {
        let since = self
            .evaluated_at
            .map(|looked| now.saturating_duration_since(looked))
            .filter(|since| *since > EVALUATION_TIMEOUT);
        let late = since.map(|since| format!("nobody has looked for alarms for {} s", since.as_secs()));
        late.or_else(|| {
            (!self.unwritten.0.is_empty()).then(|| "the record has no room for what became of alarms".to_owned())
        })
    }

    /// Hands what happened to the recorder, with what it had no room for before.
    fn write(&mut self, recorder: &Recorder, changes: &[AlarmChange]) {
        let (batch, events) = self.pending_batch(changes, None);
        if batch.is_empty() && events.is_empty() {
            return;
        }
        if !recorder.record_alarms(batch.clone(), events.clone()) {
            self.unwritten = (batch, events);
        }
    }

    fn write_with_receipt(&mut self, recorder: &Recorder, changes: &[AlarmChange], actor: &Actor) -> WriteReceipt {
        let (batch, events) = self.pending_batch(changes, Some(actor));
        let written = recorder.record_alarms_with_receipt(batch.clone(), events.clone());
        if !written.is_queued() {
            self.unwritten = (batch, events);
        }
        written
    }

    fn pending_batch(&mut self, changes: &[AlarmChange], by: Option<&Actor>) -> (AlarmBatch, Vec<Event>) {
        let (mut batch, mut events) = std::mem::take(&mut self.unwritten);
        let (later, told) = rows_and_events(changes, by, &self.station, &self.targets);
        let _lost = batch.append(later, MAX_UNWRITTEN);
        events.extend(told.into_iter().take(MAX_UNWRITTEN.saturating_sub(events.len())));
        (batch, events)
    }
}
