//! The alarms of a running station, shared by its threads: one evaluates, users acknowledge, the API reads.
//!
//! Changes are queued for the recorder while the registry is locked, so rows are in the order of the changes. No thread waits for
//! the disk while it holds the lock.

use super::evaluate::Inputs;
use super::notify::{NotificationTarget, Notifier};
use super::persistence::{
    SettingsChange, default_settings_rows, late_notifications, plant_state_rows, rename, rows_and_events, settings_rows,
};
use super::plant_state::{PlantStateChange, PlantStateError, PlantStateRule, PlantStates};
use super::registry::{AlarmChange, AlarmError, AlarmRegistry, RegisteredAlarm, removed_text};
use super::rule::Rule;
use super::suppression::AlarmTime;
use super::view::{AlarmView, AlarmsNow, PlantStateView};
use crate::recording::RecorderHandle;
use profivac_model::{AlarmChangeKind, AlarmHistoryEntry, AlarmState, AlarmStatus, Declaration};
use profivac_recorder::alarms::AlarmBatch;
use profivac_recorder::{DatabaseError, Event, Micros, Reader, WriteReceipt};
use profivac_web_server::auth::{Actor, Role};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// When the alarms have not been evaluated for this time, the overview says so.
const EVALUATION_TIMEOUT: Duration = Duration::from_secs(5);

/// The most rows of a kind that wait for room in the recorder's queue.
const MAX_UNWRITTEN: usize = 10_000;

/// The reason why a request about an alarm failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AlarmServiceError {
    /// The state of the alarm does not allow it.
    #[error(transparent)]
    Refused(#[from] AlarmError),
    /// The change is made, and may be lost when the station restarts.
    #[error("the change is made but is not on the disk: it may be lost when the station is restarted")]
    NotStored,
}

/// The reason why a request about a plant state failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlantStateServiceError {
    /// The plant state does not allow it.
    #[error(transparent)]
    Refused(#[from] PlantStateError),
    /// The change is made, and may be lost when the station restarts.
    #[error("the change is made but is not on the disk: it may be lost when the station is restarted")]
    NotStored,
}

/// The name of an alarm, and whether a request changed it.
pub type AlarmResult = (String, Result<(), AlarmServiceError>);

/// All alarms of a station.
pub struct AlarmService {
    started: Instant,
    station: String,
    recorder: Arc<RecorderHandle>,
    inner: Mutex<Inner>,
}

#[derive(Default)]
struct Inner {
    registry: AlarmRegistry,
    notifier: Notifier,
    /// When the alarms were last evaluated; `None` while no thread evaluates.
    evaluated_at: Option<Instant>,
    /// Rows and events for which the recorder had no room.
    unwritten: (AlarmBatch, Vec<Event>),
}

impl AlarmService {
    /// A service without alarms; `station` is the name of the station in notifications.
    #[must_use]
    pub fn new(station: String, recorder: Arc<RecorderHandle>) -> Self {
        Self { started: Instant::now(), station, recorder, inner: Mutex::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> AlarmTime {
        AlarmTime { monotonic: Micros(0).after(self.started.elapsed()), wall: Micros::now() }
    }

    /// Starts with these rules and the states in the database.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn start(&self, rules: Vec<Rule>, targets: Vec<NotificationTarget>) -> Result<(), DatabaseError> {
        let reader = self.recorder.open_reader()?;
        let has_rule = |name: &str| rules.iter().any(|rule| rule.name == name);
        let (stored, renamed) = rename(reader.alarms()?, has_rule);
        let (stored, removed): (Vec<_>, Vec<_>) = stored.into_iter().partition(|(name, _)| has_rule(name));
        let removals = removal_rows(&reader, removed)?;
        let mut inner = self.lock();
        inner.notifier.set_targets(targets);
        let changes = inner.registry.reconfigure(rules, stored, self.now());
        inner.evaluated_at = Some(Instant::now());
        inner.unwritten.0.append(renamed, MAX_UNWRITTEN);
        inner.unwritten.0.append(removals, MAX_UNWRITTEN);
        self.write(&mut inner, &changes);
        Ok(())
    }

    /// Starts with these plant states and the declarations in the database.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn start_plant_states(&self, rules: Vec<PlantStateRule>) -> Result<(), DatabaseError> {
        let stored = self.recorder.open_reader()?.plant_states()?;
        self.apply_plant_states(rules, stored);
        Ok(())
    }

    /// Applies the plant states of a changed file. One that is still there keeps its declaration.
    pub fn reconfigure_plant_states(&self, rules: Vec<PlantStateRule>) {
        self.apply_plant_states(rules, Vec::new());
    }

    fn apply_plant_states(&self, rules: Vec<PlantStateRule>, stored: Vec<(String, Declaration)>) {
        let mut inner = self.lock();
        let changes = inner.registry.plant_states_mut().reconfigure(rules, stored, self.now());
        self.write_plant_states(&mut inner, &changes);
    }

    /// All plant states, in the order of the station's file.
    #[must_use]
    pub fn plant_states(&self) -> Vec<PlantStateView> {
        self.lock().registry.plant_states().all().iter().map(PlantStateView::from).collect()
    }

    /// The lowest role that declares and extends a plant state.
    ///
    /// # Errors
    /// [`PlantStateError::Unknown`] if the station's file has no such plant state.
    pub fn role_of_plant_state(&self, name: &str) -> Result<Role, PlantStateError> {
        Ok(self.lock().registry.plant_states().state(name)?.rule().role)
    }

    /// Declares a plant state for a time, and suppresses its alarms. On the disk when this returns.
    ///
    /// # Errors
    /// [`PlantStateServiceError`] says why not.
    pub fn declare(
        &self,
        name: &str,
        actor: &Actor,
        reason: &str,
        time: Duration,
    ) -> Result<PlantStateView, PlantStateServiceError> {
        let now = self.now();
        self.change_plant_state(name, actor, now, |states, user| states.declare(name, user, reason, time, now))
    }

    /// Gives a declared plant state a later end: `time` from now. On the disk when this returns.
    ///
    /// # Errors
    /// [`PlantStateServiceError`] says why not.
    pub fn extend(
        &self,
        name: &str,
        actor: &Actor,
        reason: &str,
        time: Duration,
    ) -> Result<PlantStateView, PlantStateServiceError> {
        let now = self.now();
        self.change_plant_state(name, actor, now, |states, user| states.extend(name, user, reason, time, now))
    }

    /// Ends a declared plant state. On the disk when this returns; the next evaluation raises the alarms whose conditions are met.
    ///
    /// # Errors
    /// [`PlantStateServiceError`] says why not.
    pub fn end_plant_state(
        &self,
        name: &str,
        actor: &Actor,
        reason: &str,
    ) -> Result<PlantStateView, PlantStateServiceError> {
        let now = self.now();
        self.change_plant_state(name, actor, now, |states, user| states.end(name, user, reason, now))
    }

    /// Changes a plant state, and its alarms in the same transaction.
    fn change_plant_state(
        &self,
        name: &str,
        actor: &Actor,
        now: AlarmTime,
        change: impl FnOnce(&mut PlantStates, &str) -> Result<PlantStateChange, PlantStateError>,
    ) -> Result<PlantStateView, PlantStateServiceError> {
        let mut inner = self.lock();
        let change = change(inner.registry.plant_states_mut(), &actor.user.name)?;
        let alarms = inner.registry.suppress(now);
        let (rows, own_events) = plant_state_rows(std::slice::from_ref(&change), Some(actor));
        append_unwritten(&mut inner, rows, own_events);
        let receipt = self.write_with_receipt(&mut inner, &alarms, actor);
        let view = PlantStateView::from(inner.registry.plant_states().state(name)?);
        drop(inner);
        if receipt.wait() { Ok(view) } else { Err(PlantStateServiceError::NotStored) }
    }

    fn write_plant_states(&self, inner: &mut Inner, changes: &[PlantStateChange]) {
        if changes.is_empty() {
            return;
        }
        let (rows, events) = plant_state_rows(changes, None);
        append_unwritten(inner, rows, events);
        self.write(inner, &[]);
    }

    /// Applies the rules of a changed file. Unchanged alarms keep their state.
    pub fn reconfigure(&self, rules: Vec<Rule>, targets: Vec<NotificationTarget>) {
        let mut inner = self.lock();
        inner.notifier.set_targets(targets);
        let changes = inner.registry.reconfigure(rules, Vec::new(), self.now());
        self.write(&mut inner, &changes);
        // After the last notifications about removed alarms.
        let Inner { notifier, registry, .. } = &mut *inner;
        notifier.forget_removed(registry.alarms());
    }

    /// Evaluates all alarms, and returns the rules of those that are raised now.
    pub fn evaluate(&self, inputs: &Inputs) -> Vec<Rule> {
        let mut inner = self.lock();
        let now = self.now();
        let ended = inner.registry.plant_states_mut().end_due(now);
        self.write_plant_states(&mut inner, &ended);
        let changes = inner.registry.evaluate(inputs, now);
        inner.evaluated_at = Some(Instant::now());
        self.write(&mut inner, &changes);
        self.write_late_notifications(&mut inner, now);
        changes.into_iter().filter(|change| change.kind == AlarmChangeKind::Raised).map(|change| change.rule).collect()
    }

    /// The station stops: from now on no thread evaluates.
    pub fn end(&self) {
        self.lock().evaluated_at = None;
    }

    /// Acknowledges an occurrence of an alarm. On the disk when this returns.
    ///
    /// # Errors
    /// [`AlarmServiceError`] says why not.
    pub fn acknowledge(&self, name: &str, occurrence: i64, actor: &Actor) -> Result<AlarmView, AlarmServiceError> {
        let now = self.now();
        self.change(name, actor, |registry, user| registry.acknowledge(name, occurrence, user, now))
    }

    /// Acknowledges occurrences of several alarms. Returns the result of each; on the disk together when this returns.
    pub fn acknowledge_all(&self, occurrences: Vec<(String, i64)>, actor: &Actor) -> Vec<AlarmResult> {
        let now = self.now();
        self.change_all(occurrences.into_iter(), actor, |registry, name, occurrence, user| {
            registry.acknowledge(name, occurrence, user, now)
        })
    }

    /// Shelves several alarms for a time. Returns the result of each; on the disk together when this returns.
    pub fn shelve_all(&self, names: Vec<String>, actor: &Actor, reason: &str, time: Duration) -> Vec<AlarmResult> {
        let now = self.now();
        let names = names.into_iter().map(|name| (name, ()));
        self.change_all(names, actor, |registry, name, (), user| registry.shelve(name, user, reason, time, now))
    }

    /// Unshelves several alarms. Returns the result of each; on the disk together when this returns.
    pub fn unshelve_all(&self, names: Vec<String>, actor: &Actor) -> Vec<AlarmResult> {
        let now = self.now();
        let names = names.into_iter().map(|name| (name, ()));
        self.change_all(names, actor, |registry, name, (), user| registry.unshelve(name, user, now))
    }

    /// Makes a change of each alarm that allows it. They are on the disk together when this returns.
    fn change_all<T>(
        &self,
        alarms: impl Iterator<Item = (String, T)>,
        actor: &Actor,
        change: impl Fn(&mut AlarmRegistry, &str, T, &str) -> Result<AlarmChange, AlarmError>,
    ) -> Vec<AlarmResult> {
        let mut inner = self.lock();
        let mut changes = Vec::new();
        let mut results: Vec<AlarmResult> = Vec::new();
        for (name, value) in alarms {
            let done = change(&mut inner.registry, &name, value, &actor.user.name);
            results.push((name, done.map(|change| changes.push(change)).map_err(AlarmServiceError::from)));
        }
        let receipt = self.write_with_receipt(&mut inner, &changes, actor);
        drop(inner);
        if !receipt.wait() {
            let done = results.iter_mut().filter(|(_, result)| result.is_ok());
            done.for_each(|(_, result)| *result = Err(AlarmServiceError::NotStored));
        }
        results
    }

    /// Takes an alarm out of service, for a time or until a user returns it. On the disk when this returns.
    ///
    /// # Errors
    /// [`AlarmServiceError`] says why not.
    pub fn take_out_of_service(
        &self,
        name: &str,
        actor: &Actor,
        reason: &str,
        time: Option<Duration>,
    ) -> Result<AlarmView, AlarmServiceError> {
        let now = self.now();
        self.change(name, actor, |registry, user| registry.take_out_of_service(name, user, reason, time, now))
    }

    /// Returns an alarm to service. On the disk when this returns.
    ///
    /// # Errors
    /// [`AlarmServiceError`] says why not.
    pub fn return_to_service(&self, name: &str, actor: &Actor) -> Result<AlarmView, AlarmServiceError> {
        let now = self.now();
        self.change(name, actor, |registry, user| registry.return_to_service(name, user, now))
    }

    /// Applies the rules of a file in which a user has changed the settings of the alarm `name`. On the disk when this returns. All
    /// alarms keep their states: the next evaluation raises or returns the alarm.
    ///
    /// # Errors
    /// [`AlarmServiceError`] if there is no such alarm, or if the change may be lost.
    pub fn change_rules(
        &self,
        rules: Vec<Rule>,
        name: &str,
        change: &SettingsChange<'_>,
        actor: &Actor,
    ) -> Result<AlarmView, AlarmServiceError> {
        let mut inner = self.lock();
        let now = self.now();
        let changes = inner.registry.reconfigure(rules, Vec::new(), now);
        let (mut batch, mut events) = self.pending(&mut inner, &changes, None);
        let alarm = inner.registry.alarms().iter().find(|alarm| alarm.rule().name == name);
        let alarm = alarm.ok_or_else(|| AlarmError::Unknown(name.to_owned()))?;
        let (rows, event) = settings_rows(change, alarm, actor, now.wall);
        let view = AlarmView::from(alarm);
        let _dropped = batch.append(rows, MAX_UNWRITTEN);
        events.push(event);
        let receipt = self.recorder.record_alarms_with_receipt(batch.clone(), events.clone());
        if !receipt.is_queued() {
            inner.unwritten = (batch, events);
        }
        drop(inner);
        if receipt.wait() { Ok(view) } else { Err(AlarmServiceError::NotStored) }
    }

    /// Applies the rules and plant states of a file in which a user has changed the default alarm `name`. On the disk when this returns.
    /// Alarms that are still there keep their states: the next evaluation raises or returns them.
    ///
    /// # Errors
    /// [`AlarmServiceError`] if the change may be lost.
    pub fn change_default_rules(
        &self,
        rules: Vec<Rule>,
        plant_states: Vec<PlantStateRule>,
        name: &str,
        change: &SettingsChange<'_>,
        actor: &Actor,
    ) -> Result<(), AlarmServiceError> {
        let mut inner = self.lock();
        let now = self.now();
        let ended = inner.registry.plant_states_mut().reconfigure(plant_states, Vec::new(), now);
        let (rows, events) = plant_state_rows(&ended, None);
        append_unwritten(&mut inner, rows, events);
        let changes = inner.registry.reconfigure(rules, Vec::new(), now);
        let (rows, event) = default_settings_rows(change, name, actor, now.wall);
        append_unwritten(&mut inner, rows, vec![event]);
        let receipt = self.write_with_receipt(&mut inner, &changes, actor);
        // After the last notifications about removed alarms.
        let Inner { notifier, registry, .. } = &mut *inner;
        notifier.forget_removed(registry.alarms());
        drop(inner);
        if receipt.wait() { Ok(()) } else { Err(AlarmServiceError::NotStored) }
    }

    fn change(
        &self,
        name: &str,
        actor: &Actor,
        change: impl FnOnce(&mut AlarmRegistry, &str) -> Result<AlarmChange, AlarmError>,
    ) -> Result<AlarmView, AlarmServiceError> {
        let mut inner = self.lock();
        let change = change(&mut inner.registry, &actor.user.name)?;
        let receipt = self.write_with_receipt(&mut inner, std::slice::from_ref(&change), actor);
        let alarm = inner.registry.alarms().iter().find(|alarm| alarm.rule().name == name).map(AlarmView::from);
        drop(inner);
        let alarm = alarm.ok_or_else(|| AlarmError::Unknown(name.to_owned()))?;
        if receipt.wait() { Ok(alarm) } else { Err(AlarmServiceError::NotStored) }
    }

    /// All alarms, in the order of the station's file.
    #[must_use]
    pub fn all(&self) -> Vec<AlarmView> {
        self.lock().registry.alarms().iter().map(AlarmView::from).collect()
    }

    /// The names of the alarms that have been active since before `before`, in the order of the station's file.
    #[must_use]
    pub fn active_since(&self, before: Micros) -> Vec<String> {
        let inner = self.lock();
        let is_old = |alarm: &&RegisteredAlarm| alarm.status().raised.is_some_and(|raised| raised < before);
        let active = inner.registry.alarms().iter().filter(|alarm| alarm.status().state.is_active());
        active.filter(is_old).map(|alarm| alarm.rule().name.clone()).collect()
    }

    /// The number of alarms by state and priority, and those that an operator must see.
    #[must_use]
    pub fn overview(&self) -> AlarmsNow {
        let inner = self.lock();
        let states = inner.registry.plant_states().all();
        AlarmsNow::of(inner.registry.alarms(), states, inner.problem(Instant::now()))
    }

    /// The time since the last evaluation; `None` while no thread evaluates.
    #[must_use]
    pub fn evaluated_ago(&self) -> Option<Duration> {
        self.lock().evaluated_at.map(|at| at.elapsed())
    }

    /// Queues the rows of changes for the recorder, after those for which it had no room before.
    fn write(&self, inner: &mut Inner, changes: &[AlarmChange]) {
        let (batch, events) = self.pending(inner, changes, None);
        if batch.is_empty() && events.is_empty() {
            return;
        }
        if !self.recorder.record_alarms(batch.clone(), events.clone()) {
            inner.unwritten = (batch, events);
        }
    }

    /// Queues the notifications about alarms that still wait for their acknowledgement.
    fn write_late_notifications(&self, inner: &mut Inner, now: AlarmTime) {
        let Inner { registry, notifier, unwritten, .. } = inner;
        let late = notifier.told_late(registry.alarms(), now);
        if late.is_empty() {
            return;
        }
        let batch = late_notifications(late, &self.station, now.wall);
        if !self.recorder.record_alarms(batch.clone(), Vec::new()) {
            let _dropped = unwritten.0.append(batch, MAX_UNWRITTEN);
        }
    }

    fn write_with_receipt(&self, inner: &mut Inner, changes: &[AlarmChange], actor: &Actor) -> WriteReceipt {
        let (batch, events) = self.pending(inner, changes, Some(actor));
        let receipt = self.recorder.record_alarms_with_receipt(batch.clone(), events.clone());
        if !receipt.is_queued() {
            inner.unwritten = (batch, events);
        }
        receipt
    }

    fn pending(&self, inner: &mut Inner, changes: &[AlarmChange], by: Option<&Actor>) -> (AlarmBatch, Vec<Event>) {
        let (mut batch, mut events) = std::mem::take(&mut inner.unwritten);
        let (later, later_events) = rows_and_events(changes, by, &self.station, &mut inner.notifier);
        let _dropped = batch.append(later, MAX_UNWRITTEN);
        events.extend(later_events.into_iter().take(MAX_UNWRITTEN.saturating_sub(events.len())));
        (batch, events)
    }
}

/// Rows and events that are written before those of the next change.
fn append_unwritten(inner: &mut Inner, rows: AlarmBatch, events: Vec<Event>) {
    let (batch, pending) = &mut inner.unwritten;
    let _dropped = batch.append(rows, MAX_UNWRITTEN);
    pending.extend(events.into_iter().take(MAX_UNWRITTEN.saturating_sub(pending.len())));
}

impl Inner {
    /// The reason why the overview may be wrong.
    fn problem(&self, now: Instant) -> Option<String> {
        let since = self.evaluated_at.map(|at| now.saturating_duration_since(at));
        let overdue = since.filter(|since| *since > EVALUATION_TIMEOUT);
        let overdue = overdue.map(|since| format!("the alarms have not been evaluated for {} s", since.as_secs()));
        let is_full = !self.unwritten.0.is_empty();
        overdue.or_else(|| is_full.then(|| "the recorder has no room for changes of alarms".to_owned()))
    }
}

/// The rows about alarms that were removed from the file while the station was stopped: a history entry for each that was not
/// normal.
fn removal_rows(reader: &Reader, removed: Vec<(String, AlarmStatus)>) -> Result<AlarmBatch, DatabaseError> {
    let mut batch = AlarmBatch::default();
    for (name, status) in removed {
        // The last history entry has the remaining columns.
        let last = reader.alarm_history(Micros(i64::MIN), Micros(i64::MAX), Some(&name), 1)?.pop();
        let entry = last.map(|last| AlarmHistoryEntry {
            at: Micros::now(),
            change: AlarmChangeKind::Removed.into(),
            state: AlarmState::Normal.into(),
            user: None,
            value: None,
            text: removed_text(status.state),
            ..last
        });
        batch.history.extend(entry.filter(|_| status.state != AlarmState::Normal));
        batch.alarms.insert(name, None);
    }
    Ok(batch)
}
