//! Prevents other stations from writing to a database, and detects that its file was deleted or replaced.

use super::error::DatabaseError;
use profivac_files::{FileIdentity, identity, make_private, open_private};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A lock on a database, held until it is dropped.
///
/// It is a separate file beside the database: SQLite loses its own locks when another part of the process closes the database
/// file.
pub struct DatabaseLock {
    _lock: File,
    /// The file of the database.
    identity: Option<FileIdentity>,
}

impl DatabaseLock {
    /// Locks the database at `path`, which need not exist yet.
    ///
    /// # Errors
    /// [`DatabaseError::InUse`] when another station holds the lock; [`DatabaseError::IsFolder`] and
    /// [`DatabaseError::NotWritable`] when there can be no database.
    pub fn acquire(path: &Path) -> Result<Self, DatabaseError> {
        if path.is_dir() {
            return Err(DatabaseError::IsFolder(path.to_owned()));
        }
        let failed = |error: std::io::Error| DatabaseError::NotWritable { path: path.to_owned(), error };
        let name = sibling_path(path, "-lock");
        // Another user who could open the lock file could hold the lock for ever.
        let lock = open_private(OpenOptions::new().create(true).append(true), &name).map_err(failed)?;
        make_private(&name).map_err(failed)?;
        match lock.try_lock() {
            Ok(()) => Ok(Self { _lock: lock, identity: None }),
            Err(TryLockError::WouldBlock) => Err(DatabaseError::InUse(path.to_owned())),
            Err(TryLockError::Error(error)) => Err(failed(error)),
        }
    }

    /// Remembers the file at `path` as the database.
    ///
    /// # Errors
    /// [`DatabaseError::Gone`] when there is no file.
    pub fn record_file_identity(&mut self, path: &Path) -> Result<(), DatabaseError> {
        self.identity = identity(path);
        self.identity.map(drop).ok_or_else(|| DatabaseError::Gone(path.to_owned()))
    }

    /// Whether the file at `path` is still the database.
    pub fn is_same_file(&self, path: &Path) -> bool {
        self.identity.is_some() && identity(path) == self.identity
    }
}

/// Whether a station runs on the database at `path`. True also when the lock cannot be read, because it belongs to another user.
#[must_use]
pub fn is_in_use(path: &Path) -> bool {
    match File::open(sibling_path(path, "-lock")) {
        Ok(lock) => matches!(lock.try_lock_shared(), Err(TryLockError::WouldBlock)),
        Err(error) => error.kind() != ErrorKind::NotFound,
    }
}

/// The path of the file beside `path` whose name ends with `ending`.
pub fn sibling_path(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}
