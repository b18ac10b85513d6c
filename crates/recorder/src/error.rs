//! Why a database cannot be used.

use super::schema::VERSION;
use std::io;
use std::path::PathBuf;

/// The reason why a database cannot be opened, read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatabaseError {
    /// SQLite failed.
    #[error("{path}: {error}", path = path.display())]
    Sql {
        /// The database.
        path: PathBuf,
        /// The error of SQLite.
        error: rusqlite::Error,
    },
    /// The path is a folder.
    #[error("{path}: expected a database file, got a folder", path = .0.display())]
    IsFolder(PathBuf),
    /// The file or its lock cannot be created or opened.
    #[error("{path}: the database cannot be opened for writing: {error}", path = path.display())]
    NotWritable {
        /// The database.
        path: PathBuf,
        /// The error of the system.
        error: io::Error,
    },
    /// The file was removed while it was being opened.
    #[error("{path}: the file is gone", path = .0.display())]
    Gone(PathBuf),
    /// Another station writes to it.
    #[error("{path} is in use by another station", path = .0.display())]
    InUse(PathBuf),
    /// It is the database of another program.
    #[error("{path} is a SQLite database, but not one of profivac; choose another file", path = .0.display())]
    Foreign(PathBuf),
    /// Nothing was recorded into it yet.
    #[error("{path}: expected a database of profivac, found an empty one; `profivac run` records into it", path = .0.display())]
    Empty(PathBuf),
    /// A newer program wrote it.
    #[error("{path} has tables of version {found}, this program knows version {VERSION}", path = path.display())]
    Version {
        /// The database.
        path: PathBuf,
        /// Its version.
        found: i64,
    },
}

impl DatabaseError {
    /// Whether the file is damaged: its contents, or the disk below them.
    #[must_use]
    pub fn is_damage(&self) -> bool {
        matches!(self, Self::Sql { error, .. } if is_damage(error))
    }
}

/// Whether SQLite has found the file damaged, or the disk cannot read a part of it.
pub fn is_damage(error: &rusqlite::Error) -> bool {
    use rusqlite::ErrorCode::{DatabaseCorrupt, NotADatabase};
    use rusqlite::ffi::{SQLITE_IOERR_CORRUPTFS, SQLITE_IOERR_DATA, SQLITE_IOERR_READ, SQLITE_IOERR_SHORT_READ};
    let of_disk = [SQLITE_IOERR_READ, SQLITE_IOERR_SHORT_READ, SQLITE_IOERR_CORRUPTFS, SQLITE_IOERR_DATA];
    matches!(error.sqlite_error_code(), Some(DatabaseCorrupt | NotADatabase))
        || error.sqlite_extended_error_code().is_some_and(|code| of_disk.contains(&code))
}

/// The reason why an audit entry was not written before its command was to be sent.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AuditError {
    /// The queue of the recorder is full.
    #[error("the recorder's queue is full")]
    QueueFull,
    /// The disk did not answer in time.
    #[error("the disk is too slow")]
    Timeout,
    /// SQLite inserted no row.
    #[error("no row was written")]
    NoRow,
    /// The database failed.
    #[error(transparent)]
    Database(#[from] DatabaseError),
}
