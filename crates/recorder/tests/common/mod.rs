//! A database in a temporary folder, and settings that keep every sample.

#![allow(clippy::unwrap_used, reason = "a test")]
#![allow(dead_code, reason = "each test uses its part")]

use profivac_recorder::{Deadband, Reader, Recorder, Retention, Settings};
use std::path::PathBuf;
use std::time::Duration;
use tempfile::TempDir;

/// The path of a database that does not exist yet, in a folder of its own.
pub struct Fixture {
    _folder: TempDir,
    pub path: PathBuf,
}

impl Fixture {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        Self { _folder: folder, path }
    }

    /// The same folder with another database.
    pub fn at(self, path: PathBuf) -> Self {
        Self { path, ..self }
    }

    pub fn recorder(&self, settings: Settings) -> Recorder {
        Recorder::start(&self.path, settings).unwrap()
    }

    pub fn reader(&self) -> Reader {
        Reader::open(&self.path).unwrap()
    }
}

/// Settings that keep every sample without limit.
pub fn keep_everything() -> Settings {
    Settings {
        deadband: Deadband { decades: 0.0, max_interval: Duration::ZERO },
        full_rate_window: Duration::from_secs(5),
        outbox: None,
        retention: Retention { samples: None, ..Retention::default() },
    }
}
