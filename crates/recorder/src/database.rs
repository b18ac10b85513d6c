//! The file: tables, transactions, retention.
//!
//! SQLite with a write-ahead log and `synchronous = FULL`: what a transaction has returned from is on the disk, and a power
//! cut in the middle of one leaves the file as it was before.

use super::alarms::{self, AlarmBatch};
use super::audit::{self, AuditEntry};
use super::lock::{DatabaseLock, sibling_path};
use super::sample::{Micros, Sample};
use super::spans::{LEVELS, PendingSpans};
use rusqlite::{Connection, OpenFlags, OptionalExtension, Transaction, TransactionBehavior, params};
use std::fs::{self, OpenOptions};
use std::io::ErrorKind;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The version of the tables, in the file's `user_version`: so many of the [`STEPS`] were taken.
const VERSION: i64 = MIGRATIONS.len() as i64;

/// How an empty file becomes one of this version. A file of an older version takes the steps it lacks; a step that was ever
/// shipped is never changed.
const MIGRATIONS: [&str; 3] = [SAMPLE_TABLES, audit::AUDIT_TABLE, alarms::ALARM_TABLES];

const SAMPLE_TABLES: &str = "
    CREATE TABLE gauge (
        id   INTEGER PRIMARY KEY,
        name TEXT NOT NULL UNIQUE
    );
    -- Times in microseconds since 1970, pressures in Pa. quality: 0 valid, 1 overrange, 2 underrange, 3 invalid, 4 gap.
    CREATE TABLE sample (
        gauge   INTEGER NOT NULL REFERENCES gauge,
        at      INTEGER NOT NULL,
        pa      REAL,
        quality INTEGER NOT NULL,
        PRIMARY KEY (gauge, at)
    ) WITHOUT ROWID;
    -- What happened in 10 s (level 1), 2 min, 30 min and 6 h. qualities: bit 0 valid, bit 1 overrange, ...
    CREATE TABLE rollup (
        level     INTEGER NOT NULL,
        gauge     INTEGER NOT NULL REFERENCES gauge,
        start     INTEGER NOT NULL,
        low       REAL,
        high      REAL,
        decades   REAL NOT NULL,
        count     INTEGER NOT NULL,
        qualities INTEGER NOT NULL,
        PRIMARY KEY (level, gauge, start)
    ) WITHOUT ROWID;
    CREATE TABLE event (
        id    INTEGER PRIMARY KEY,
        at    INTEGER NOT NULL,
        gauge INTEGER REFERENCES gauge,
        kind  TEXT NOT NULL,
        text  TEXT NOT NULL
    );
    CREATE INDEX event_at ON event (at);
";

/// Why the file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum DatabaseError {
    /// SQLite says so.
    #[error("{path}: {error}", path = path.display())]
    Sql {
        /// The file.
        path: PathBuf,
        /// What it says.
        error: rusqlite::Error,
    },
    /// It cannot be a record where it is meant to be, or not any more.
    #[error("{path}: {what}", path = path.display())]
    Place {
        /// The file.
        path: PathBuf,
        /// What was expected and what came.
        what: String,
    },
    /// Another station records into it.
    #[error("{path} is already recorded into by another station", path = path.display())]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// A newer program wrote it.
    #[error("{path} has tables of version {found}, this program knows version {VERSION}", path = path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// What it has.
        found: i64,
    },
}

/// What kind of thing happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The station or a segment of it began or ended.
    Station,
    /// A slave came or went.
    Bus,
    /// A gauge reports a fault, or does no longer.
    Gauge,
    /// Somebody did something.
    Command,
    /// Somebody wrote something down.
    Note,
    /// Somebody logged in or out, was refused, or was made a user.
    Access,
    /// Something became of an alarm.
    Alarm,
}

impl EventKind {
    const ALL: [Self; 7] =
        [Self::Station, Self::Bus, Self::Gauge, Self::Command, Self::Note, Self::Access, Self::Alarm];

    /// As it stands in the file.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Station => "station",
            Self::Bus => "bus",
            Self::Gauge => "gauge",
            Self::Command => "command",
            Self::Note => "note",
            Self::Access => "access",
            Self::Alarm => "alarm",
        }
    }

    /// The kind with this word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.word() == word)
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// When.
    pub at: Micros,
    /// To which gauge, by its name.
    pub gauge: Option<String>,
    /// What kind of thing.
    pub kind: EventKind,
    /// One sentence.
    pub text: String,
}

/// How long what is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Retention {
    /// Samples.
    pub samples: Duration,
    /// Spans of 10 s, 2 min, 30 min and 6 h; for ever where nothing is said.
    pub spans: [Option<Duration>; LEVELS.len()],
}

const DAY: Duration = Duration::from_secs(86_400);

impl Default for Retention {
    /// free choice, after what large sites keep: samples for two years, 10 s for five, everything coarser for ever.
    fn default() -> Self {
        Self { samples: DAY.saturating_mul(730), spans: [Some(DAY.saturating_mul(1826)), None, None, None] }
    }
}

/// At most so many rows are deleted in one transaction: recording goes on meanwhile.
const MAX_DELETIONS: u32 = 20_000;

/// The log of a transaction is cut back when it has become longer than this, in octets. free choice: four times what SQLite
/// lets it become while nobody holds it up.
const MAX_WAL_OCTETS: i64 = 16 << 20;

/// A moment that is taken by another sample is moved by at most so many microseconds.
const MAX_SHIFT_US: i64 = 1_000;

/// The file, open for writing.
pub struct Database {
    path: PathBuf,
    lock: Option<DatabaseLock>,
    connection: Connection,
    /// The gauges that were named, by the number they have here.
    names: Vec<String>,
    /// What they are in the file, as far as it knows them.
    ids: Vec<i64>,
}

impl Database {
    /// Opens the file, or makes it.
    ///
    /// # Errors
    /// [`StoreError`] when it cannot be used, also when another station has it.
    pub fn open(path: &Path) -> Result<Self, DatabaseError> {
        let mut claim = DatabaseLock::acquire(path)?;
        let connection = connect(path)?;
        claim.record_file_identity(path)?;
        let store = Self { path: path.to_owned(), lock: Some(claim), connection, names: Vec::new(), ids: Vec::new() };
        // Nobody else writes: what has no outcome now was cut off.
        audit::close_unfinished(&store.connection, Micros::now()).map_err(|error| store.failed(error))?;
        Ok(store)
    }

    /// Adds rows to the audit trail, all or none. Says which they are.
    ///
    /// # Errors
    /// [`StoreError`] when nothing was written.
    pub fn audit(&mut self, entries: &[AuditEntry]) -> Result<Vec<i64>, DatabaseError> {
        self.reopen_if_replaced()?;
        let begun = self.connection.transaction_with_behavior(TransactionBehavior::Immediate);
        let written = begun.and_then(|transaction| {
            let rows = entries.iter().map(|entry| audit::insert(&transaction, entry)).collect::<Result<_, _>>()?;
            transaction.commit()?;
            Ok(rows)
        });
        written.map_err(|error| self.failed(error))
    }

    /// The number of a gauge, for as long as this store is open.
    pub fn series_index(&mut self, name: &str) -> usize {
        self.names.iter().position(|known| known == name).unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len().saturating_sub(1)
        })
    }

    /// Writes everything of a second, or nothing of it. Says how many samples found no free moment near theirs.
    ///
    /// # Errors
    /// [`StoreError`] when nothing was written.
    pub fn write(
        &mut self,
        samples: &[(usize, Sample)],
        additions: &PendingSpans,
        events: &[Event],
        alarms: &AlarmBatch,
    ) -> Result<u64, DatabaseError> {
        self.reopen_if_replaced()?;
        let gauges: Vec<_> =
            events.iter().map(|event| event.gauge.as_deref().map(|name| self.series_index(name))).collect();
        let mut ids = self.ids.clone();
        let names = &self.names;
        let begun = self.connection.transaction_with_behavior(TransactionBehavior::Immediate);
        let written = begun.and_then(|transaction| {
            for name in names.iter().skip(ids.len()) {
                ids.push(series_id(&transaction, name)?);
            }
            let crowded = insert_samples(&transaction, samples, &ids)?;
            add_spans(&transaction, additions, &ids)?;
            insert_events(&transaction, events, &gauges, &ids)?;
            alarms.write(&transaction)?;
            transaction.commit()?;
            Ok(crowded)
        });
        let crowded = written.map_err(|error| self.failed(error))?;
        self.ids = ids;
        Ok(crowded)
    }

    /// A file that was deleted or replaced takes what is written and nobody ever sees it: then what lies at the path is
    /// opened, or made anew.
    fn reopen_if_replaced(&mut self) -> Result<(), DatabaseError> {
        if self.lock.as_ref().is_some_and(|claim| claim.is_same_file(&self.path)) {
            return Ok(());
        }
        // The old one goes first: as it ends it deletes the log at this path, which must not be the new one's.
        self.connection = Connection::open_in_memory().map_err(|error| self.failed(error))?;
        self.ids.clear();
        self.lock = None;
        let mut claim = DatabaseLock::acquire(&self.path)?;
        self.connection = connect(&self.path)?;
        claim.record_file_identity(&self.path)?;
        self.lock = Some(claim);
        Ok(())
    }

    /// Deletes some of what is older than it is to be kept. Says whether there may be more.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be written.
    pub fn prune(&mut self, retention: &Retention, now: Micros) -> Result<bool, DatabaseError> {
        let deleted = self.delete_old(retention, now).map_err(|error| self.failed(error))?;
        if deleted > 0 {
            // Room in the file is given back to the disk in small pieces.
            self.run_to_completion("PRAGMA incremental_vacuum(500)")?;
        }
        self.truncate_wal()?;
        Ok(deleted >= MAX_DELETIONS as usize)
    }

    /// Cuts the log back if somebody has held it up. Whoever still reads is waited for, then it is left for later.
    fn truncate_wal(&self) -> Result<(), DatabaseError> {
        let log = sibling_path(&self.path, "-wal");
        if fs::metadata(log).is_ok_and(|log| log.len() > MAX_WAL_OCTETS.unsigned_abs()) {
            self.run_to_completion("PRAGMA wal_checkpoint(TRUNCATE)")?;
        }
        Ok(())
    }

    /// Runs a statement to its end: some do their work row by row.
    fn run_to_completion(&self, sql: &str) -> Result<(), DatabaseError> {
        let run = || {
            let mut statement = self.connection.prepare_cached(sql)?;
            let mut rows = statement.query([])?;
            while rows.next()?.is_some() {}
            Ok(())
        };
        run().map_err(|error| self.failed(error))
    }

    /// A disk with room for so many pages.
    #[cfg(test)]
    pub fn limit_pages(&self, pages: u32) {
        self.run_to_completion(&format!("PRAGMA max_page_count = {pages}")).unwrap();
    }

    fn delete_old(&self, retention: &Retention, now: Micros) -> rusqlite::Result<usize> {
        let mut deleted = self
            .connection
            .prepare_cached(
                "DELETE FROM sample WHERE (gauge, at) IN (
                     SELECT gauge, at FROM gauge JOIN sample ON sample.gauge = gauge.id AND at < ?1 LIMIT ?2)",
            )?
            .execute(params![now.before(retention.samples).0, MAX_DELETIONS])?;
        for (level, kept) in LEVELS.iter().zip(retention.spans) {
            let Some(kept) = kept else { continue };
            deleted = deleted.saturating_add(
                self.connection
                    .prepare_cached(
                        "DELETE FROM rollup WHERE (level, gauge, start) IN (
                             SELECT level, gauge, start FROM gauge
                             JOIN rollup ON rollup.gauge = gauge.id AND level = ?1 AND start < ?2 LIMIT ?3)",
                    )?
                    .execute(params![level.number, now.before(kept).0, MAX_DELETIONS])?,
            );
        }
        Ok(deleted)
    }

    fn failed(&self, error: rusqlite::Error) -> DatabaseError {
        DatabaseError::Sql { path: self.path.clone(), error }
    }
}

/// Opens a file for reading; a file that is not there is an error, and so is one without tables. What an older version
/// recorded can be read as it is.
///
/// # Errors
/// What SQLite says.
pub fn open_to_read(path: &Path) -> Result<Connection, DatabaseError> {
    let failed = |error| DatabaseError::Sql { path: path.to_owned(), error };
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(path, flags).map_err(failed)?;
    connection.busy_timeout(BUSY_TIMEOUT).map_err(failed)?;
    match version(&connection).map_err(failed)? {
        1..=VERSION => Ok(connection),
        found => Err(DatabaseError::Version { path: path.to_owned(), found }),
    }
}

/// How long one connection waits for another. The recorder tries again every second by itself.
const BUSY_TIMEOUT: Duration = Duration::from_secs(1);

/// Opens a file for writing, or makes it.
fn connect(path: &Path) -> Result<Connection, DatabaseError> {
    let failed = |error| DatabaseError::Sql { path: path.to_owned(), error };
    create_file(path).map_err(|error| DatabaseError::Place { path: path.to_owned(), what: error.to_string() })?;
    let connection = Connection::open(path).map_err(failed)?;
    prepare(&connection).map_err(failed)?;
    match version(&connection).map_err(failed)? {
        found @ 0..=VERSION => migrate(&connection, found).map_err(failed)?,
        found => return Err(DatabaseError::Version { path: path.to_owned(), found }),
    }
    Ok(connection)
}

/// A file that is not there yet is made as its owner's alone. SQLite gives its log the rights of the file.
fn create_file(path: &Path) -> std::io::Result<()> {
    match OpenOptions::new().write(true).create_new(true).mode(0o600).open(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(()),
        made => made.map(drop),
    }
}

fn prepare(connection: &Connection) -> rusqlite::Result<()> {
    connection.busy_timeout(BUSY_TIMEOUT)?;
    // auto_vacuum must be chosen before the first table.
    connection.execute_batch(
        "PRAGMA auto_vacuum = INCREMENTAL;
         PRAGMA journal_mode = WAL;
         PRAGMA synchronous = FULL;
         PRAGMA foreign_keys = ON;",
    )?;
    connection.pragma_update(None, "journal_size_limit", MAX_WAL_OCTETS)
}

fn version(connection: &Connection) -> rusqlite::Result<i64> {
    connection.query_row("PRAGMA user_version", [], |row| row.get(0))
}

fn migrate(connection: &Connection, found: i64) -> rusqlite::Result<()> {
    let lacking = MIGRATIONS.iter().skip(usize::try_from(found).unwrap_or(MIGRATIONS.len()));
    let lacking: String = lacking.copied().collect();
    if lacking.is_empty() {
        return Ok(());
    }
    connection.execute_batch(&format!("BEGIN; {lacking} PRAGMA user_version = {VERSION}; COMMIT;"))
}

fn series_id(connection: &Connection, name: &str) -> rusqlite::Result<i64> {
    let known = connection.query_row("SELECT id FROM gauge WHERE name = ?1", [name], |row| row.get(0)).optional()?;
    match known {
        Some(number) => Ok(number),
        None => {
            connection.execute("INSERT INTO gauge (name) VALUES (?1)", [name])?;
            Ok(connection.last_insert_rowid())
        }
    }
}

/// What is written for a gauge that the file does not know breaks the reference to its table, and nothing is written.
fn id(ids: &[i64], gauge: usize) -> i64 {
    ids.get(gauge).copied().unwrap_or_default()
}

/// A sample that is there already stays as it is: the ring brings some twice. Another one at the same moment, which a clock
/// that was set back can bring, is moved to the next microsecond that is free. Says how many found none.
fn insert_samples(transaction: &Transaction<'_>, samples: &[(usize, Sample)], ids: &[i64]) -> rusqlite::Result<u64> {
    let mut insert = transaction.prepare_cached("INSERT OR IGNORE INTO sample VALUES (?1, ?2, ?3, ?4)")?;
    let mut same =
        transaction.prepare_cached("SELECT pa IS ?3 AND quality = ?4 FROM sample WHERE gauge = ?1 AND at = ?2")?;
    let mut crowded = 0_u64;
    for (gauge, Sample { at, pa, quality }) in samples {
        let gauge = id(ids, *gauge);
        let mut is_kept = false;
        for at in at.0..at.0.saturating_add(MAX_SHIFT_US) {
            let row = params![gauge, at, pa, *quality as u8];
            is_kept = insert.execute(row)? == 1 || same.query_row(row, |row| row.get(0))?;
            if is_kept {
                break;
            }
        }
        crowded = crowded.saturating_add(u64::from(!is_kept));
    }
    Ok(crowded)
}

fn add_spans(transaction: &Transaction<'_>, additions: &PendingSpans, ids: &[i64]) -> rusqlite::Result<()> {
    let mut add = transaction.prepare_cached(
        "INSERT INTO rollup VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)
         ON CONFLICT DO UPDATE SET
             low       = min(ifnull(low, excluded.low), ifnull(excluded.low, low)),
             high      = max(ifnull(high, excluded.high), ifnull(excluded.high, high)),
             decades   = decades + excluded.decades,
             count     = count + excluded.count,
             qualities = qualities | excluded.qualities",
    )?;
    for (key, extent) in additions.iter() {
        add.execute(params![
            key.level,
            id(ids, key.gauge),
            key.start.0,
            extent.low,
            extent.high,
            extent.decades,
            extent.count,
            extent.qualities.0
        ])?;
    }
    Ok(())
}

fn insert_events(
    transaction: &Transaction<'_>,
    events: &[Event],
    gauges: &[Option<usize>],
    ids: &[i64],
) -> rusqlite::Result<()> {
    let mut insert = transaction.prepare_cached("INSERT INTO event (at, gauge, kind, text) VALUES (?1, ?2, ?3, ?4)")?;
    for (event, gauge) in events.iter().zip(gauges) {
        let gauge = gauge.map(|gauge| id(ids, gauge));
        insert.execute(params![event.at.0, gauge, event.kind.word(), event.text])?;
    }
    Ok(())
}
