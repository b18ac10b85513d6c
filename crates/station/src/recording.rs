//! The recorder as the threads of the station share it, with the path of its database.

use profivac_recorder::{DatabaseError, Event, EventKind, Micros, Reader, Recorder};
use std::ops::Deref;
use std::path::PathBuf;

/// A recorder and the path of its database.
pub struct RecorderHandle {
    recorder: Recorder,
    database: PathBuf,
}

impl RecorderHandle {
    /// A handle of `recorder`, which writes to `database`.
    #[must_use]
    pub const fn new(recorder: Recorder, database: PathBuf) -> Self {
        Self { recorder, database }
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
