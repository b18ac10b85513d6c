//! A database opened for writing: transactions and retention.
//!
//! SQLite runs with a write-ahead log and `synchronous = FULL`: a committed transaction is on the disk, and a power cut during a
//! transaction leaves the database as it was before.

use super::alarms::AlarmBatch;
use super::audit;
use super::batch::BatchPoint;
use super::connection::{MAX_WAL_OCTETS, open_to_write};
use super::error::DatabaseError;
use super::lock::{DatabaseLock, sibling_path};
use super::outbox::{self, Acknowledgement, Forward, LastForwarded, PointRows, PointTexts, PressureRows, Taken};
use super::point::{DescribedPoint, Point, PointSample};
use super::reader::recording_periods;
use super::recorded::Recorded;
use super::retention::{ClockAtStart, Expired, Period};
use super::sample::{Micros, Sample};
use super::spans::{LEVELS, PendingSpans, SpanKey};
use super::state::{self, StationState};
use profivac_model::{AuditEntry, Event};
use rusqlite::{Connection, ErrorCode, OptionalExtension, Row, Transaction, TransactionBehavior, params};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long rows are kept, in recorded time: see [`Expired`]. The audit trail is kept without limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Retention {
    /// Samples; `None` keeps them without limit.
    pub samples: Option<Duration>,
    /// Spans of 10 s, 2 min, 30 min and 6 h; `None` keeps them without limit.
    pub spans: [Option<Duration>; LEVELS.len()],
    /// Events; `None` keeps them without limit.
    pub events: Option<Duration>,
    /// Rows of the alarm history; `None` keeps them without limit.
    pub alarm_history: Option<Duration>,
    /// Batches that the archive has in its database, from their acknowledgement on; `None` keeps as many as may wait.
    pub batches: Option<Duration>,
}

const DAY: Duration = Duration::from_secs(86_400);

impl Default for Retention {
    /// chosen, similar to the practice of large sites: samples for two years, spans of 10 s, events and the alarm history for five,
    /// all coarser spans without limit. Batches for a day: a dump of the archive's database is rarely older.
    fn default() -> Self {
        let five_years = Some(DAY.saturating_mul(1826));
        Self {
            samples: Some(DAY.saturating_mul(730)),
            spans: [five_years, None, None, None],
            events: five_years,
            alarm_history: five_years,
            batches: Some(DAY),
        }
    }
}

/// The most rows that one transaction deletes: samples are recorded between two such transactions.
const MAX_DELETIONS: u32 = 20_000;

/// Deletes samples from time 1 to before time 2, at most number 3. All of these statements have a fourth parameter, the level.
const DELETE_SAMPLES: &str = "DELETE FROM sample WHERE (series_id, at_us) IN (
    SELECT series_id, at_us FROM series
    JOIN sample ON sample.series_id = series.id AND at_us >= ?1 AND at_us < ?2 AND ?4 = 0 LIMIT ?3)";

/// The same for the spans of a level.
const DELETE_SPANS: &str = "DELETE FROM span WHERE (level, series_id, start_us) IN (
    SELECT level, series_id, start_us FROM series
    JOIN span ON span.series_id = series.id AND level = ?4 AND start_us >= ?1 AND start_us < ?2 LIMIT ?3)";

/// The same for samples of points.
const DELETE_POINT_SAMPLES: &str = "DELETE FROM point_sample WHERE (point_id, at_us) IN (
    SELECT point_id, at_us FROM point
    JOIN point_sample ON point_sample.point_id = point.id AND at_us >= ?1 AND at_us < ?2 AND ?4 = 0 LIMIT ?3)";

/// The same for the spans of points of a level.
const DELETE_POINT_SPANS: &str = "DELETE FROM point_span WHERE (level, point_id, start_us) IN (
    SELECT level, point_id, start_us FROM point
    JOIN point_span ON point_span.point_id = point.id AND level = ?4 AND start_us >= ?1 AND start_us < ?2 LIMIT ?3)";

/// The same for events.
const DELETE_EVENTS: &str = "DELETE FROM event WHERE id IN (
    SELECT id FROM event WHERE at_us >= ?1 AND at_us < ?2 AND ?4 = 0 LIMIT ?3)";

/// The same for the alarm history.
const DELETE_ALARM_HISTORY: &str = "DELETE FROM alarm_history WHERE id IN (
    SELECT id FROM alarm_history WHERE at_us >= ?1 AND at_us < ?2 AND ?4 = 0 LIMIT ?3)";

/// The same for batches that were acknowledged. One that the database of the archive may lack stays.
const DELETE_BATCHES: &str = "DELETE FROM outbox_kept WHERE number IN (
    SELECT number FROM outbox_kept WHERE acknowledged_us >= ?1 AND acknowledged_us < ?2 AND ?4 = 0
        AND number <= (SELECT stored FROM outbox_state) LIMIT ?3)";

/// A sample whose time is already taken by another sample is moved by at most this many microseconds.
const MAX_SHIFT_US: i64 = 1_000;

/// Samples and spans of points that wait for a transaction.
#[derive(Clone, Debug, Default)]
pub struct NewPoints {
    /// The samples that are kept, with the index of their point.
    pub samples: Vec<(usize, PointSample)>,
    /// The spans of all samples.
    pub spans: PendingSpans<PointSample>,
}

impl NewPoints {
    /// Adds a sample that is kept, also to its spans.
    pub fn add(&mut self, point: usize, sample: PointSample) {
        self.samples.push((point, sample));
        self.spans.add(point, &sample);
    }

    /// The number of samples and spans.
    #[must_use]
    pub fn len(&self) -> usize {
        self.samples.len().saturating_add(self.spans.len())
    }

    /// Whether nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Removes everything, after it was written.
    pub fn clear(&mut self) {
        self.samples.clear();
        self.spans.clear();
    }
}

/// A database opened for writing.
pub struct Database {
    path: PathBuf,
    lock: Option<DatabaseLock>,
    connection: Connection,
    /// The names of series, by index.
    names: Vec<String>,
    /// The ids of the first series in the database, by index.
    ids: Vec<i64>,
    /// The points, by index, and the ids of the first ones in the database.
    points: Vec<Point>,
    point_ids: Vec<i64>,
    /// The row of the present recording period.
    period: Option<i64>,
    /// Which samples are in the batches of the outbox; `None` without an outbox.
    forward: Option<Forward>,
    last_forwarded: LastForwarded,
    /// The texts of the codes of points, for the batches.
    texts: PointTexts,
    /// The time of the batches.
    now: Micros,
    /// The file was deleted or replaced, and another one was opened.
    was_replaced: bool,
}

impl Database {
    /// Opens a database and locks it. A missing file is created; an older version is migrated.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be used, also when another station uses it.
    pub fn open(path: &Path, now: Micros) -> Result<Self, DatabaseError> {
        let mut lock = DatabaseLock::acquire(path)?;
        let connection = open_to_write(path)?;
        lock.record_file_identity(path)?;
        let database = Self {
            path: path.to_owned(),
            lock: Some(lock),
            connection,
            names: Vec::new(),
            ids: Vec::new(),
            points: Vec::new(),
            point_ids: Vec::new(),
            period: None,
            forward: None,
            last_forwarded: LastForwarded::default(),
            texts: PointTexts::new(),
            now,
            was_replaced: false,
        };
        // No other process writes, so the station ended while a command without an outcome was being sent.
        audit::close_unfinished(&database.connection, now).map_err(|error| database.failed(error))?;
        Ok(database)
    }

    /// Puts the rows of all later transactions into the outbox as well, or no longer.
    pub fn set_outbox(&mut self, forward: Option<Forward>) {
        self.forward = forward;
    }

    /// Sets the texts of the codes of all points. The next batch with a point has its texts.
    pub fn set_point_texts(&mut self, points: Vec<DescribedPoint>) {
        let with_texts = points.into_iter().filter(|described| !described.texts.is_empty());
        self.texts = with_texts.map(|described| (BatchPoint::of(&described.point), described.texts)).collect();
        self.last_forwarded.forget_texts();
    }

    /// Sets the time of the batches.
    pub const fn set_time(&mut self, now: Micros) {
        self.now = now;
    }

    /// Takes note of an answer about the batches of the outbox. One about another epoch changes nothing.
    ///
    /// # Errors
    /// [`DatabaseError`] when nothing was changed.
    pub fn acknowledge_outbox(&mut self, answer: Acknowledgement) -> Result<(), DatabaseError> {
        self.reopen_if_replaced()?;
        let noted = match self.note_answer(answer, Taken::Keep) {
            // Batches that wait no longer make room for rows that are recorded.
            Err(error) if error.sqlite_error_code() == Some(ErrorCode::DiskFull) => {
                self.note_answer(answer, Taken::Forget)
            }
            noted => noted,
        };
        noted.map_err(|error| self.failed(error))
    }

    fn note_answer(&mut self, answer: Acknowledgement, taken: Taken) -> rusqlite::Result<()> {
        let transaction = self.connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
        outbox::acknowledge(&transaction, answer, taken, self.now)?;
        transaction.commit()
    }

    /// Goes on as another database from batch `first` of `epoch` on. Another epoch changes nothing.
    ///
    /// # Errors
    /// [`DatabaseError`] when nothing was changed.
    pub fn branch_outbox(&mut self, epoch: i64, first: i64) -> Result<(), DatabaseError> {
        self.reopen_if_replaced()?;
        let begun = self.connection.transaction_with_behavior(TransactionBehavior::Immediate);
        let branched = begun.and_then(|transaction| {
            outbox::branch(&transaction, epoch, first, self.now)?;
            transaction.commit()
        });
        branched.map_err(|error| self.failed(error))
    }

    /// Adds rows to the audit trail, all or none. Returns their numbers.
    ///
    /// # Errors
    /// [`DatabaseError`] when nothing was written.
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

    /// Stores a state of the station.
    ///
    /// # Errors
    /// [`DatabaseError`] when nothing was written.
    pub fn store_state(&mut self, state: &StationState) -> Result<(), DatabaseError> {
        self.reopen_if_replaced()?;
        state::store(&self.connection, state).map_err(|error| self.failed(error))
    }

    /// The index of a series, valid as long as this database is open.
    pub fn series_index(&mut self, name: &str) -> usize {
        self.names.iter().position(|known| known == name).unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len().saturating_sub(1)
        })
    }

    /// The index of a point, valid as long as this database is open.
    pub fn point_index(&mut self, point: &Point) -> usize {
        self.points.iter().position(|known| known == point).unwrap_or_else(|| {
            self.points.push(point.clone());
            self.points.len().saturating_sub(1)
        })
    }

    /// Writes samples, spans, events and alarm changes, all or none. Returns the number of samples that were dropped because
    /// all times near theirs are taken.
    ///
    /// # Errors
    /// [`DatabaseError`] when nothing was written.
    pub fn write(
        &mut self,
        samples: &[(usize, Sample)],
        spans: &PendingSpans,
        events: &[Event],
        alarms: &AlarmBatch,
    ) -> Result<u64, DatabaseError> {
        self.write_with_points(samples, spans, &NewPoints::default(), events, alarms)
    }

    /// The same, with values of points.
    ///
    /// # Errors
    /// [`DatabaseError`] when nothing was written.
    pub fn write_with_points(
        &mut self,
        samples: &[(usize, Sample)],
        spans: &PendingSpans,
        new_points: &NewPoints,
        events: &[Event],
        alarms: &AlarmBatch,
    ) -> Result<u64, DatabaseError> {
        self.reopen_if_replaced()?;
        let of_events: Vec<_> =
            events.iter().map(|event| event.gauge.as_deref().map(|name| self.series_index(name))).collect();
        let (mut ids, mut point_ids) = (self.ids.clone(), self.point_ids.clone());
        let (names, points) = (&self.names, &self.points);
        let (forward, last_forwarded, texts, now) = (self.forward, &self.last_forwarded, &self.texts, self.now);
        let begun = self.connection.transaction_with_behavior(TransactionBehavior::Immediate);
        let written = begun.and_then(|transaction| {
            for name in names.iter().skip(ids.len()) {
                ids.push(series_id(&transaction, name)?);
            }
            for point in points.iter().skip(point_ids.len()) {
                point_ids.push(point_id(&transaction, point)?);
            }
            let (crowded, inserted) = insert_samples(&transaction, samples, &ids)?;
            add_spans(&transaction, spans, &ids)?;
            let (crowded_points, of_points) = insert_samples(&transaction, &new_points.samples, &point_ids)?;
            add_point_spans(&transaction, &new_points.spans, &point_ids)?;
            insert_events(&transaction, events, &of_events, &ids)?;
            alarms.write(&transaction)?;
            let pressures = PressureRows { inserted: &inserted, spans, ids: &ids };
            let points = PointRows { inserted: &of_points, spans: &new_points.spans, points, ids: &point_ids, texts };
            let put = |forward| outbox::put(&transaction, forward, last_forwarded, &pressures, &points, now);
            let last_forwarded = forward.map(put).transpose()?;
            if forward.is_none() {
                let times =
                    inserted.iter().map(|(_, sample)| sample.at).chain(of_points.iter().map(|(_, sample)| sample.at));
                // A sample within the deadband is in its spans only.
                let short = |key: &&SpanKey| key.level == LEVELS[0].number;
                let starts = spans.iter().map(|(key, _)| key).filter(short).map(|key| key.start);
                let of_points = new_points.spans.iter().map(|(key, _)| key).filter(short).map(|key| key.start);
                outbox::note_absence(&transaction, times.chain(starts).chain(of_points).min())?;
            }
            transaction.commit()?;
            Ok((crowded.saturating_add(crowded_points), last_forwarded))
        });
        let (crowded, last_forwarded) = written.map_err(|error| self.failed(error))?;
        (self.ids, self.point_ids) = (ids, point_ids);
        if let Some(last_forwarded) = last_forwarded {
            self.last_forwarded = last_forwarded;
        }
        Ok(crowded)
    }

    /// Continues the last recording period, or begins one if the clock does not fit to its end. Returns how the clock differs, if that is
    /// worth an event.
    ///
    /// # Errors
    /// [`DatabaseError`] when nothing was written.
    pub fn resume_recording(&mut self, now: Micros) -> Result<Option<ClockAtStart>, DatabaseError> {
        let read = || {
            let sql = "SELECT id, start_us, end_us FROM recording_period ORDER BY id DESC LIMIT 1";
            let row =
                |row: &Row<'_>| Ok((row.get(0)?, Period { start: Micros(row.get(1)?), end: Micros(row.get(2)?) }));
            self.connection.query_row(sql, [], row).optional()
        };
        let last: Option<(i64, Period)> = read().map_err(|error| self.failed(error))?;
        match last.filter(|(_, period)| period.continues_at(now)) {
            Some((id, _)) => {
                self.period = Some(id);
                self.extend_period(now)?;
            }
            None => self.begin_period(now)?,
        }
        Ok(last.and_then(|(_, period)| ClockAtStart::check(now, period.end)))
    }

    /// Begins a recording period at `start`, after the clock was set.
    ///
    /// # Errors
    /// [`DatabaseError`] when nothing was written.
    pub fn begin_period(&mut self, start: Micros) -> Result<(), DatabaseError> {
        let sql = "INSERT INTO recording_period (start_us, end_us) VALUES (?1, ?1)";
        let inserted = self.connection.execute(sql, [start.0]);
        inserted.map_err(|error| self.failed(error))?;
        self.period = Some(self.connection.last_insert_rowid());
        Ok(())
    }

    /// Extends the present recording period to `now`.
    ///
    /// # Errors
    /// [`DatabaseError`] when nothing was written.
    pub fn extend_period(&mut self, now: Micros) -> Result<(), DatabaseError> {
        let Some(id) = self.period else { return self.begin_period(now) };
        let sql = "UPDATE recording_period SET start_us = min(start_us, ?1), end_us = max(end_us, ?1) WHERE id = ?2";
        let updated = self.connection.execute(sql, [now.0, id]);
        updated.map(drop).map_err(|error| self.failed(error))
    }

    /// Whether the file was deleted or replaced since the last call. The present file lacks everything that was written before.
    pub fn take_replaced(&mut self) -> bool {
        std::mem::take(&mut self.was_replaced)
    }

    /// Opens the file at the path again if it was deleted or replaced. SQLite would continue to write to the deleted file.
    ///
    /// # Errors
    /// [`DatabaseError`] when the file at the path cannot be used.
    pub fn reopen_if_replaced(&mut self) -> Result<(), DatabaseError> {
        if self.lock.as_ref().is_some_and(|lock| lock.is_same_file(&self.path)) {
            return Ok(());
        }
        // The old connection closes first: it deletes the log at this path, which must not be the log of the new file.
        self.connection = Connection::open_in_memory().map_err(|error| self.failed(error))?;
        self.ids.clear();
        self.point_ids.clear();
        self.last_forwarded = LastForwarded::default();
        self.lock = None;
        let mut lock = DatabaseLock::acquire(&self.path)?;
        self.connection = open_to_write(&self.path)?;
        lock.record_file_identity(&self.path)?;
        self.lock = Some(lock);
        self.period = None;
        self.was_replaced = true;
        Ok(())
    }

    /// Deletes some rows that are older than the retention. Returns whether there may be more.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be written.
    pub fn prune(&mut self, retention: &Retention) -> Result<bool, DatabaseError> {
        let deleted = self.delete_old(retention).map_err(|error| self.failed(error))?;
        if deleted > 0 {
            // Returns free pages to the disk in small steps.
            self.run_to_completion("PRAGMA incremental_vacuum(500)")?;
        }
        self.truncate_wal()?;
        Ok(deleted >= MAX_DELETIONS as usize)
    }

    /// Truncates the log if it has grown because of a slow reader. The checkpoint waits for readers up to the busy timeout.
    fn truncate_wal(&self) -> Result<(), DatabaseError> {
        let log = sibling_path(&self.path, "-wal");
        if fs::metadata(log).is_ok_and(|log| log.len() > MAX_WAL_OCTETS.unsigned_abs()) {
            self.run_to_completion("PRAGMA wal_checkpoint(TRUNCATE)")?;
        }
        Ok(())
    }

    /// Runs a statement and reads all its rows: some pragmas do their work row by row.
    fn run_to_completion(&self, sql: &str) -> Result<(), DatabaseError> {
        let run = || {
            let mut statement = self.connection.prepare_cached(sql)?;
            let mut rows = statement.query([])?;
            while rows.next()?.is_some() {}
            Ok(())
        };
        run().map_err(|error| self.failed(error))
    }

    /// Simulates a disk with room for `pages` pages.
    #[cfg(test)]
    pub fn limit_pages(&self, pages: u32) {
        self.run_to_completion(&format!("PRAGMA max_page_count = {pages}")).unwrap();
    }

    fn delete_old(&self, retention: &Retention) -> rusqlite::Result<usize> {
        let periods = recording_periods(&self.connection)?;
        let delete = |sql: &str, kept: Option<Duration>, level: u8| {
            let Some(kept) = kept else { return Ok(0) };
            let mut delete = self.connection.prepare_cached(sql)?;
            Expired::of(&periods, kept).ranges().try_fold(0_usize, |deleted, range| {
                let now = delete.execute(params![range.start, range.end, MAX_DELETIONS, level])?;
                Ok::<_, rusqlite::Error>(deleted.saturating_add(now))
            })
        };
        let mut deleted = 0_usize;
        for of_samples in [DELETE_SAMPLES, DELETE_POINT_SAMPLES] {
            deleted = deleted.saturating_add(delete(of_samples, retention.samples, 0)?);
        }
        for (level, kept) in LEVELS.iter().zip(retention.spans) {
            for of_spans in [DELETE_SPANS, DELETE_POINT_SPANS] {
                deleted = deleted.saturating_add(delete(of_spans, kept, level.number)?);
            }
        }
        deleted = deleted.saturating_add(delete(DELETE_EVENTS, retention.events, 0)?);
        deleted = deleted.saturating_add(delete(DELETE_ALARM_HISTORY, retention.alarm_history, 0)?);
        Ok(deleted.saturating_add(delete(DELETE_BATCHES, retention.batches, 0)?))
    }

    fn failed(&self, error: rusqlite::Error) -> DatabaseError {
        DatabaseError::Sql { path: self.path.clone(), error }
    }
}

/// The id of a series, which is created if it is new.
fn series_id(connection: &Connection, name: &str) -> rusqlite::Result<i64> {
    let sql = "SELECT id FROM series WHERE name = ?1";
    match connection.query_row(sql, [name], |row| row.get(0)).optional()? {
        Some(id) => Ok(id),
        None => {
            connection.execute("INSERT INTO series (name) VALUES (?1)", [name])?;
            Ok(connection.last_insert_rowid())
        }
    }
}

/// The id of a point, which is created if it is new.
fn point_id(connection: &Connection, point: &Point) -> rusqlite::Result<i64> {
    let Point { slave, name, unit, kind } = point;
    let row = params![slave, name, unit.as_deref().unwrap_or_default(), kind.word()];
    let sql = "SELECT id FROM point WHERE slave = ?1 AND name = ?2 AND unit = ?3 AND kind = ?4";
    match connection.query_row(sql, row, |row| row.get(0)).optional()? {
        Some(id) => Ok(id),
        None => {
            connection.execute("INSERT INTO point (slave, name, unit, kind) VALUES (?1, ?2, ?3, ?4)", row)?;
            Ok(connection.last_insert_rowid())
        }
    }
}

/// The id of a series by index. An unknown index gives 0, which violates the foreign key, so nothing is written.
fn id(ids: &[i64], series: usize) -> i64 {
    ids.get(series).copied().unwrap_or_default()
}

/// Inserts samples. A sample that is stored already stays as it is: the ring buffer returns some twice. A different sample at a taken
/// time, which a clock that was set back can cause, moves to the next free microsecond. Returns how many found none, and the new rows
/// by the id of their series.
fn insert_samples<T: Recorded>(
    transaction: &Transaction<'_>,
    samples: &[(usize, T)],
    ids: &[i64],
) -> rusqlite::Result<(u64, Vec<(i64, T)>)> {
    let (table, of_series, of_value) = (T::SAMPLES, T::SERIES, T::VALUE);
    let mut insert = transaction.prepare_cached(&format!(
        "INSERT OR IGNORE INTO {table} ({of_series}, at_us, {of_value}, quality) VALUES (?1, ?2, ?3, ?4)"
    ))?;
    let mut same = transaction.prepare_cached(&format!(
        "SELECT {of_value} IS ?3 AND quality = ?4 FROM {table} WHERE {of_series} = ?1 AND at_us = ?2"
    ))?;
    let (mut crowded, mut inserted) = (0_u64, Vec::new());
    for (series, sample) in samples {
        let (series, value, quality) = (id(ids, *series), sample.value(), sample.quality());
        let mut is_kept = false;
        for at in sample.at().0..sample.at().0.saturating_add(MAX_SHIFT_US) {
            let row = params![series, at, value, quality as u8];
            let is_new = insert.execute(row)? == 1;
            is_kept = is_new || same.query_row(row, |row| row.get(0))?;
            if is_new {
                inserted.push((series, T::of(Micros(at), value, quality)));
            }
            if is_kept {
                break;
            }
        }
        crowded = crowded.saturating_add(u64::from(!is_kept));
    }
    Ok((crowded, inserted))
}

fn add_spans(transaction: &Transaction<'_>, spans: &PendingSpans, ids: &[i64]) -> rusqlite::Result<()> {
    let mut add = transaction.prepare_cached(
        "INSERT INTO span (level, series_id, start_us, min_pa, max_pa, log10_sum, count, qualities)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)
         ON CONFLICT DO UPDATE SET
             min_pa    = min(ifnull(min_pa, excluded.min_pa), ifnull(excluded.min_pa, min_pa)),
             max_pa    = max(ifnull(max_pa, excluded.max_pa), ifnull(excluded.max_pa, max_pa)),
             log10_sum = log10_sum + excluded.log10_sum,
             count     = count + excluded.count,
             qualities = qualities | excluded.qualities",
    )?;
    for (key, summary) in spans.iter() {
        add.execute(params![
            key.level,
            id(ids, key.series),
            key.start.0,
            summary.low,
            summary.high,
            summary.decades,
            summary.count,
            summary.qualities.0
        ])?;
    }
    Ok(())
}

fn add_point_spans(
    transaction: &Transaction<'_>,
    spans: &PendingSpans<PointSample>,
    ids: &[i64],
) -> rusqlite::Result<()> {
    let mut add = transaction.prepare_cached(
        "INSERT INTO point_span (level, point_id, start_us, min_value, max_value, last_value, sum, count, qualities)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)
         ON CONFLICT DO UPDATE SET
             min_value  = min(ifnull(min_value, excluded.min_value), ifnull(excluded.min_value, min_value)),
             max_value  = max(ifnull(max_value, excluded.max_value), ifnull(excluded.max_value, max_value)),
             last_value = ifnull(excluded.last_value, last_value),
             sum        = sum + excluded.sum,
             count      = count + excluded.count,
             qualities  = qualities | excluded.qualities",
    )?;
    for (key, summary) in spans.iter() {
        add.execute(params![
            key.level,
            id(ids, key.series),
            key.start.0,
            summary.low,
            summary.high,
            summary.last,
            summary.sum,
            summary.count,
            summary.qualities.0
        ])?;
    }
    Ok(())
}

fn insert_events(
    transaction: &Transaction<'_>,
    events: &[Event],
    of_events: &[Option<usize>],
    ids: &[i64],
) -> rusqlite::Result<()> {
    let sql = "INSERT INTO event (at_us, series_id, kind, text) VALUES (?1, ?2, ?3, ?4)";
    let mut insert = transaction.prepare_cached(sql)?;
    for (event, series) in events.iter().zip(of_events) {
        let series = series.map(|series| id(ids, series));
        insert.execute(params![event.at.0, series, event.kind.as_str(), event.text])?;
    }
    Ok(())
}
