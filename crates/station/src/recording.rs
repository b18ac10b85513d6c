//! The recorder as the threads of the station share it, with the path of its database.

use profivac_recorder::check::GiveUp;
use profivac_recorder::{Check, DatabaseError, Event, EventKind, LastCheck, Micros, Reader, Recorder, StationState};
use std::ops::Deref;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A recorder and the path of its database.
pub struct RecorderHandle {
    recorder: Recorder,
    database: PathBuf,
    last_check: Mutex<Option<LastCheck>>,
}

impl RecorderHandle {
    /// A handle of `recorder`, which writes to `database`.
    #[must_use]
    pub const fn new(recorder: Recorder, database: PathBuf) -> Self {
        Self { recorder, database, last_check: Mutex::new(None) }
    }

    /// The folder for captures of the station's segments, beside the database.
    #[must_use]
    pub fn captures(&self) -> PathBuf {
        self.beside("captures")
    }

    /// The path of a file or folder beside the database, with this extension.
    #[must_use]
    pub fn beside(&self, extension: &str) -> PathBuf {
        self.database.with_extension(extension)
    }

    /// Opens the database for reading.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database is missing or cannot be read.
    pub fn open_reader(&self) -> Result<Reader, DatabaseError> {
        Reader::open(&self.database)
    }

    /// Begins a check of the database for damage.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be opened.
    pub fn begin_check(&self, give_up: GiveUp) -> Result<Check, DatabaseError> {
        Check::begin(&self.database, give_up)
    }

    /// Reads the last check from the database.
    pub fn recall_check(&self) {
        // A table that cannot be read counts as no check: the next one finds it damaged.
        *self.locked_check() = self.open_reader().and_then(|reader| reader.last_check()).unwrap_or_default();
    }

    /// The last check of the database; `None` before the first one.
    #[must_use]
    pub fn last_check(&self) -> Option<LastCheck> {
        self.locked_check().clone()
    }

    /// Keeps the outcome of a check, here and in the database.
    pub fn store_check(&self, check: LastCheck) {
        // Without room in the queue the station checks again after a restart.
        let _queued = self.recorder.store_state(StationState::from(&check));
        *self.locked_check() = Some(check);
    }

    /// The damage that the last check has found.
    #[must_use]
    pub fn damage(&self) -> Option<String> {
        let check = self.locked_check();
        let found = check.as_ref().map(|check| check.found.join("; "));
        found.filter(|found| !found.is_empty())
    }

    /// The damage that the last check has found, and what to do, in a sentence.
    #[must_use]
    pub fn damage_sentence(&self) -> Option<String> {
        let path = self.database.display();
        self.damage().map(|damage| {
            format!(
                "the database is damaged: {damage}; look at it with `profivac doctor {path}`, stop the station and restore a backup"
            )
        })
    }

    fn locked_check(&self) -> MutexGuard<'_, Option<LastCheck>> {
        self.last_check.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records an event with the present time. Never blocks on the disk.
    pub fn event_now(&self, gauge: Option<&str>, kind: EventKind, text: impl Into<String>) {
        self.recorder.record_event(event(Micros::now(), gauge, kind, text.into()));
    }

    /// Records an event of this time. Never blocks on the disk.
    pub fn event_at(&self, at: Micros, gauge: Option<&str>, kind: EventKind, text: impl Into<String>) {
        self.recorder.record_event(event(at, gauge, kind, text.into()));
    }

    /// Records an event with the present time, and returns when it is on the disk or after the recorder's timeout. Not for bus threads.
    pub fn event_now_and_wait(&self, gauge: Option<&str>, kind: EventKind, text: impl Into<String>) {
        // A failure is reported by the recorder's health.
        let _written = self.recorder.record_event_and_wait(event(Micros::now(), gauge, kind, text.into()));
    }
}

impl Deref for RecorderHandle {
    type Target = Recorder;

    fn deref(&self) -> &Recorder {
        &self.recorder
    }
}

fn event(at: Micros, gauge: Option<&str>, kind: EventKind, text: String) -> Event {
    Event { at, gauge: gauge.map(str::to_owned), kind: kind.into(), text }
}
