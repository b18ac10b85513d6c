//! The alarms of a running station, as its threads share them: one looks, people act, all see.
//!
//! What changes is handed to the recorder while the book is held, so the order in the file is the order in which it happened.
//! Nobody waits for the disk with the book in hand.

use super::book::{Book, Change, Life, Now, Refusal, What};
use super::judge::Sight;
use super::paper::{Addressee, written};
use super::rule::Rule;
use super::state::State;
use super::view::{Alarm, Standing};
use crate::act::Actor;
use crate::plant::Plant;
use profivac_recorder::alarms::{Batch, Line};
use profivac_recorder::{Event, Micros, Reader, Recorder, StoreError, Written};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// When nobody has looked for so long, what is told of alarms cannot be believed any more.
const QUIET: Duration = Duration::from_secs(5);

/// Why somebody could not do what they wanted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotDone {
    /// The alarm does not allow it.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// It is done, and nobody knows whether it outlives the program.
    #[error("it is done and could not be written to the disk: it may be lost when the station is started again")]
    Unwritten,
}

/// All alarms.
pub struct Alarms {
    begun: Instant,
    desk: Mutex<Desk>,
}

#[derive(Default)]
struct Desk {
    book: Book,
    /// The name of the station, for letters.
    station: String,
    addressees: Vec<Addressee>,
    /// When somebody looked last; nothing while nothing is watched.
    looked: Option<Instant>,
    /// What the recorder had no room for.
    unwritten: (Batch, Vec<Event>),
}

/// So many lines wait for room.
const WAITING: usize = 10_000;

impl Default for Alarms {
    fn default() -> Self {
        Self { begun: Instant::now(), desk: Mutex::default() }
    }
}

impl Alarms {
    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> Now {
        Now { steady: Micros(0).after(self.begun.elapsed()), at: Micros::now() }
    }

    /// Begins with what the record knows, and these alarms.
    ///
    /// # Errors
    /// [`StoreError`] when the record cannot be read.
    pub fn begin(&self, plant: &Plant, rules: Vec<Rule>, addressees: Vec<Addressee>) -> Result<(), StoreError> {
        let reader = plant.reader()?;
        let kept = reader.alarms()?.into_iter().map(|(name, kept)| (name, Life::from(kept)));
        let is_meant = |name: &str| rules.iter().any(|rule| rule.name == name);
        let (kept, gone): (Vec<_>, Vec<_>) = kept.partition(|(name, _)| is_meant(name));
        let farewell = farewell(&reader, gone)?;
        let mut desk = self.desk();
        desk.station = plant.name().to_owned();
        desk.addressees = addressees;
        let changes = desk.book.become_like(rules, kept, self.now());
        desk.looked = Some(Instant::now());
        desk.unwritten.0.append(farewell, WAITING);
        desk.write(plant.recorder(), &changes);
        Ok(())
    }

    /// Becomes what a changed file says; what did not change stays where it stands.
    pub fn become_like(&self, recorder: &Recorder, rules: Vec<Rule>, addressees: Vec<Addressee>) {
        let mut desk = self.desk();
        desk.addressees = addressees;
        let changes = desk.book.become_like(rules, Vec::new(), self.now());
        desk.write(recorder, &changes);
    }

    /// Looks at what the plant shows.
    pub fn look(&self, recorder: &Recorder, sight: &Sight) {
        let mut desk = self.desk();
        let changes = desk.book.look(sight, self.now());
        desk.looked = Some(Instant::now());
        desk.write(recorder, &changes);
    }

    /// Nobody looks any more, and nobody is to: the station ends.
    pub fn end(&self) {
        self.desk().looked = None;
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
    ) -> Result<Alarm, NotDone> {
        let now = self.now();
        self.act(recorder, name, actor, |book, who| book.acknowledge(name, occurrence, who, now))
    }

    /// Somebody has seen these occurrences of alarms. What came of each; on the disk, together, when this returns.
    pub fn acknowledge_all(
        &self,
        recorder: &Recorder,
        seen: Vec<(String, i64)>,
        actor: &Actor,
    ) -> Vec<(String, Result<(), NotDone>)> {
        let now = self.now();
        let mut desk = self.desk();
        let mut changes = Vec::new();
        let mut done: Vec<(String, Result<(), NotDone>)> = Vec::new();
        for (name, occurrence) in seen {
            let acknowledged = desk.book.acknowledge(&name, occurrence, &actor.person.name, now);
            done.push((name, acknowledged.map(|change| changes.push(change)).map_err(NotDone::from)));
        }
        let written = desk.write_and_tell(recorder, &changes, actor);
        drop(desk);
        if !written.wait() {
            done.iter_mut().filter(|(_, done)| done.is_ok()).for_each(|(_, done)| *done = Err(NotDone::Unwritten));
        }
        done
    }

    /// Takes an alarm out of service, for a time or until somebody puts it back. On the disk when this returns.
    ///
    /// # Errors
    /// [`NotDone`] says why not.
    pub fn take_out(
        &self,
        recorder: &Recorder,
        name: &str,
        actor: &Actor,
        reason: &str,
        time: Option<Duration>,
    ) -> Result<Alarm, NotDone> {
        let now = self.now();
        self.act(recorder, name, actor, |book, who| book.take_out(name, who, reason, time, now))
    }

    /// Puts an alarm back into service. On the disk when this returns.
    ///
    /// # Errors
    /// [`NotDone`] says why not.
    pub fn put_back(&self, recorder: &Recorder, name: &str, actor: &Actor) -> Result<Alarm, NotDone> {
        let now = self.now();
        self.act(recorder, name, actor, |book, who| book.put_back(name, who, now))
    }

    fn act(
        &self,
        recorder: &Recorder,
        name: &str,
        actor: &Actor,
        act: impl FnOnce(&mut Book, &str) -> Result<Change, Refusal>,
    ) -> Result<Alarm, NotDone> {
        let mut desk = self.desk();
        let change = act(&mut desk.book, &actor.person.name)?;
        let written = desk.write_and_tell(recorder, std::slice::from_ref(&change), actor);
        let entry = desk.book.entries().iter().find(|entry| entry.rule().name == name).map(Alarm::from);
        drop(desk);
        let alarm = entry.ok_or_else(|| Refusal::Unknown(name.to_owned()))?;
        if written.wait() { Ok(alarm) } else { Err(NotDone::Unwritten) }
    }

    /// All of them, in the order of the file.
    #[must_use]
    pub fn all(&self) -> Vec<Alarm> {
        self.desk().book.entries().iter().map(Alarm::from).collect()
    }

    /// What must be known at a moment.
    #[must_use]
    pub fn standing(&self) -> Standing {
        let desk = self.desk();
        Standing::of(desk.book.entries(), desk.trouble(Instant::now()))
    }

    /// How long ago somebody looked, if somebody is to.
    #[must_use]
    pub fn looked_ago(&self) -> Option<Duration> {
        self.desk().looked.map(|looked| looked.elapsed())
    }
}

/// What is written of alarms that do not stand in the file any more, while nobody looked: a line for each that was not normal.
fn farewell(reader: &Reader, gone: Vec<(String, Life)>) -> Result<Batch, StoreError> {
    let mut batch = Batch::default();
    for (name, life) in gone {
        // What else is known of it stands in its last line.
        let last = reader.alarm_history(Micros(i64::MIN), Micros(i64::MAX), Some(&name), 1)?.pop();
        let text = format!("it does not stand in the file any more (it was {})", life.state.word());
        let (what, state) = (What::Removed.word().to_owned(), State::Normal.word().to_owned());
        let line = last.map(|last| Line { at: Micros::now(), what, state, who: None, value: None, text, ..last });
        batch.lines.extend(line.filter(|_| life.state != State::Normal));
        batch.kept.insert(name, None);
    }
    Ok(batch)
}

impl Desk {
    fn trouble(&self, now: Instant) -> Option<String> {
        let since = self.looked.map(|looked| now.saturating_duration_since(looked)).filter(|since| *since > QUIET);
        let late = since.map(|since| format!("nobody has looked for alarms for {} s", since.as_secs()));
        late.or_else(|| {
            (!self.unwritten.0.is_empty()).then(|| "the record has no room for what became of alarms".to_owned())
        })
    }

    /// Hands what happened to the recorder, with what it had no room for before.
    fn write(&mut self, recorder: &Recorder, changes: &[Change]) {
        let (batch, events) = self.together(changes, None);
        if batch.is_empty() && events.is_empty() {
            return;
        }
        if !recorder.alarms(batch.clone(), events.clone()) {
            self.unwritten = (batch, events);
        }
    }

    fn write_and_tell(&mut self, recorder: &Recorder, changes: &[Change], actor: &Actor) -> Written {
        let (batch, events) = self.together(changes, Some(actor));
        let written = recorder.alarms_and_tell(batch.clone(), events.clone());
        if !written.is_taken() {
            self.unwritten = (batch, events);
        }
        written
    }

    fn together(&mut self, changes: &[Change], by: Option<&Actor>) -> (Batch, Vec<Event>) {
        let (mut batch, mut events) = std::mem::take(&mut self.unwritten);
        let (later, told) = written(changes, by, &self.station, &self.addressees);
        let _lost = batch.append(later, WAITING);
        events.extend(told.into_iter().take(WAITING.saturating_sub(events.len())));
        (batch, events)
    }
}
