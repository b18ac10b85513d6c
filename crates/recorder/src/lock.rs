//! Where the file lies: whether a record can be there, that no other station records into it, and whether it is still there.

use super::database::DatabaseError;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// What keeps other stations away from a file, as long as it lives.
///
/// A file of its own beside the record is locked: SQLite loses its own locks when anybody else in the process closes the
/// record itself.
pub struct DatabaseLock {
    _lock: File,
    /// Device and inode of the record.
    opened: Option<(u64, u64)>,
}

impl DatabaseLock {
    /// Claims the file at `path`, which need not be there yet.
    ///
    /// # Errors
    /// [`StoreError::InUse`] when another station has it, [`StoreError::Place`] when there cannot be a record.
    pub fn acquire(path: &Path) -> Result<Self, DatabaseError> {
        let place = |what: String| DatabaseError::Place { path: path.to_owned(), what };
        if path.is_dir() {
            return Err(place("expected a file to record into, got a folder".to_owned()));
        }
        let cannot = |error: std::io::Error| place(format!("nothing can be recorded here: {error}"));
        let name = sibling_path(path, "-lock");
        let lock = OpenOptions::new().create(true).append(true).open(name).map_err(cannot)?;
        match lock.try_lock() {
            Ok(()) => Ok(Self { _lock: lock, opened: None }),
            Err(TryLockError::WouldBlock) => Err(DatabaseError::InUse { path: path.to_owned() }),
            Err(TryLockError::Error(error)) => Err(cannot(error)),
        }
    }

    /// What lies at `path` now is the record.
    ///
    /// # Errors
    /// [`StoreError::Place`] when nothing does.
    pub fn record_file_identity(&mut self, path: &Path) -> Result<(), DatabaseError> {
        self.opened = file_identity(path);
        let gone = || DatabaseError::Place { path: path.to_owned(), what: "the file is gone".to_owned() };
        self.opened.map(drop).ok_or_else(gone)
    }

    /// Whether the record still lies at `path`, and no other file.
    pub fn is_same_file(&self, path: &Path) -> bool {
        self.opened.is_some() && file_identity(path) == self.opened
    }
}

fn file_identity(path: &Path) -> Option<(u64, u64)> {
    fs::metadata(path).ok().map(|file| (file.dev(), file.ino()))
}

/// The file beside `path` whose name ends with `ending`.
pub fn sibling_path(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}
