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
