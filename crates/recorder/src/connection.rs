//! Opens a database for reading or for writing.

use super::error::DatabaseError;
use super::schema::{VERSION, is_own, read_as_current, upgrade, version};
use profivac_files::open_private;
use rusqlite::{Connection, OpenFlags};
use std::fs::{self, OpenOptions};
use std::io::ErrorKind;
use std::path::Path;
use std::time::Duration;

/// The longest wait of one connection for another. The recorder tries again every second.
const BUSY_TIMEOUT: Duration = Duration::from_secs(1);

/// The log is truncated when it has become longer than this, in octets. chosen: four times the length at which SQLite
/// truncates it when no reader uses it.
pub const MAX_WAL_OCTETS: i64 = 16 << 20;

/// Opens a database for reading. A database of an older version is read under the current names of tables and columns.
///
/// # Errors
/// [`DatabaseError`] when the file is missing, is no database, or was written by a newer program.
pub fn open_to_read(path: &Path) -> Result<Connection, DatabaseError> {
    let failed = |error| DatabaseError::Sql { path: path.to_owned(), error };
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(path, flags).map_err(failed)?;
    connection.busy_timeout(BUSY_TIMEOUT).map_err(failed)?;
    let found = checked_version(&connection, path)?;
    if found == 0 {
        return Err(DatabaseError::Empty(path.to_owned()));
    }
    read_as_current(&connection, found).map_err(failed)?;
    Ok(connection)
}

/// Opens a database for writing. A missing file is created; an older version is migrated.
///
/// # Errors
/// [`DatabaseError`] when the file cannot be written, is no database, or was written by a newer program.
pub fn open_to_write(path: &Path) -> Result<Connection, DatabaseError> {
    let failed = |error| DatabaseError::Sql { path: path.to_owned(), error };
    create_file(path).map_err(|error| DatabaseError::NotWritable { path: path.to_owned(), error })?;
    let mut connection = Connection::open(path).map_err(failed)?;
    connection.busy_timeout(BUSY_TIMEOUT).map_err(failed)?;
    // Before the first change of the file: a database of another program stays as it is.
    let found = checked_version(&connection, path)?;
    prepare(&connection).map_err(failed)?;
    upgrade(&mut connection, found).map_err(failed)?;
    Ok(connection)
}

/// The version of a database of a recorder, 0 for an empty file.
fn checked_version(connection: &Connection, path: &Path) -> Result<i64, DatabaseError> {
    let failed = |error| DatabaseError::Sql { path: path.to_owned(), error };
    let found = version(connection).map_err(failed)?;
    if !is_own(connection, found).map_err(failed)? {
        return Err(DatabaseError::Foreign(path.to_owned()));
    }
    if !(0..=VERSION).contains(&found) {
        return Err(DatabaseError::Version { path: path.to_owned(), found });
    }
    Ok(found)
}

/// Creates a missing file readable by its owner alone, also where a link names it. SQLite gives its log the permissions of the file.
///
/// An existing file is not opened: closing it would release the locks that SQLite has on it in this process.
fn create_file(path: &Path) -> std::io::Result<()> {
    match fs::metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            open_private(OpenOptions::new().write(true).create(true).truncate(false), path).map(drop)
        }
        found => found.map(drop),
    }
}

fn prepare(connection: &Connection) -> rusqlite::Result<()> {
    // auto_vacuum must be chosen before the first table.
    connection.execute_batch(
        "PRAGMA auto_vacuum = INCREMENTAL;
         PRAGMA journal_mode = WAL;
         PRAGMA synchronous = FULL;
         PRAGMA foreign_keys = ON;",
    )?;
    connection.pragma_update(None, "journal_size_limit", MAX_WAL_OCTETS)
}
