//! The outbox: the rows of each transaction once more, as a numbered batch for the archive, in the same transaction.
//!
//! A row of the database is therefore in a batch, and the other way round, after every kill and every power cut. A batch never
//! changes once it has a number, so that it may be sent twice. Numbers have no gaps. Deleting a batch that the archive has is what
//! moves the cursor.

use super::batch::{AlarmChange, Audit, Batch, Event, FORMAT, MAX_SAMPLES, Samples, Span};
use super::error::DatabaseError;
use super::reader::Reader;
use super::sample::{Micros, Sample};
use super::spans::{LEVELS, PendingSpans};
use rusqlite::{OptionalExtension, Row, Transaction, params};
use std::collections::{BTreeMap, HashMap};
use std::time::Duration;

/// Which samples are in the batches. Spans, events, alarms and the audit trail always are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Forward {
    /// Every sample of the database.
    All,
    /// Those that differ from the last one by a factor: its decimal logarithm. Also each change of quality, and one in ten minutes.
    Deadband(f64),
    /// None.
    Off,
}

/// The longest time between two samples of a series that [`Forward::Deadband`] passes.
const MAX_INTERVAL: Duration = Duration::from_secs(600);

/// The finest level of spans in the batches: two minutes.
const FINEST_LEVEL: u8 = 2;

/// A span is sent this time after its end. A sample that is later sends it again.
const SETTLED: i64 = 5 * Micros::SECOND;

/// The most rows of a kind in the batch of one transaction; of spans, of a level. With the series of [`MAX_SAMPLES`] samples they are
/// fewer than [`MAX_ROWS`](super::batch::MAX_ROWS).
const MAX_ROWS_OF_KIND: u32 = 1_000;

/// The most batches that wait, 30 days at one a second: then the oldest are deleted.
const MAX_BATCHES: i64 = 2_592_000;

/// The last sample that was passed on, by the id of the series.
pub type LastForwarded = HashMap<i64, Sample>;

/// A batch that waits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Waiting {
    /// Its number.
    pub number: i64,
    /// Its octets.
    pub payload: Vec<u8>,
}

/// What waits in the outbox.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Page {
    /// The epoch of the database: it differs after the database was replaced.
    pub epoch: i64,
    /// The first batches, in the order of their numbers.
    pub batches: Vec<Waiting>,
}

/// The state in the database.
struct State {
    epoch: i64,
    event: i64,
    alarm: i64,
    audit: i64,
}

/// Adds a batch with the rows of this transaction, if there are any. Returns the samples that were passed on last.
pub fn put(
    transaction: &Transaction<'_>,
    forward: Forward,
    last: &LastForwarded,
    inserted: &[(i64, Sample)],
    spans: &PendingSpans,
    ids: &[i64],
    now: Micros,
) -> rusqlite::Result<LastForwarded> {
    let mut state = state(transaction, now)?;
    let mut last = last.clone();
    let samples = inserted.iter().filter(|(series, sample)| passes(forward, &mut last, *series, sample));
    let samples: Vec<_> = samples.copied().collect();
    note_spans(transaction, spans, ids)?;
    let mut batch = Batch {
        format: FORMAT,
        made_us: now.0,
        samples: Vec::new(),
        spans: take_settled_spans(transaction, now)?,
        events: events(transaction, &mut state)?,
        alarms: alarms(transaction, &mut state)?,
        audit: audit(transaction, &mut state)?,
    };
    let mut chunks = samples.chunks(MAX_SAMPLES);
    batch.samples = by_series(transaction, chunks.next().unwrap_or_default())?;
    let has_rows = !(batch.events.is_empty() && batch.alarms.is_empty() && batch.audit.is_empty());
    if has_rows || !batch.samples.is_empty() || !batch.spans.is_empty() {
        insert(transaction, &batch)?;
    }
    for chunk in chunks {
        let samples = by_series(transaction, chunk)?;
        insert(transaction, &Batch { format: FORMAT, made_us: now.0, samples, ..Batch::default() })?;
    }
    if has_rows {
        transaction
            .prepare_cached("UPDATE outbox_state SET event_id = ?1, alarm_id = ?2, audit_id = ?3")?
            .execute(params![state.event, state.alarm, state.audit])?;
    }
    limit(transaction)?;
    Ok(last)
}

/// Deletes the batches that the archive has.
pub fn acknowledge(connection: &rusqlite::Connection, epoch: i64, number: i64) -> rusqlite::Result<usize> {
    let sql = "DELETE FROM outbox WHERE number <= ?2 AND EXISTS (SELECT 1 FROM outbox_state WHERE epoch = ?1)";
    connection.prepare_cached(sql)?.execute([epoch, number])
}

/// Makes a copy of a database another database: its batches go on under an epoch of their own.
pub fn begin_epoch(connection: &rusqlite::Connection) -> rusqlite::Result<()> {
    let sql = "SELECT count(*) FROM sqlite_schema WHERE name = 'outbox_state'";
    let tables: i64 = connection.query_row(sql, [], |row| row.get(0))?;
    // A database of an older version has no outbox.
    if tables > 0 {
        connection.execute("UPDATE outbox_state SET epoch = 0", [])?;
    }
    Ok(())
}

/// The state; a new database, and a copy, begins its epoch now.
fn state(transaction: &Transaction<'_>, now: Micros) -> rusqlite::Result<State> {
    let row =
        |row: &Row<'_>| Ok(State { epoch: row.get(0)?, event: row.get(1)?, alarm: row.get(2)?, audit: row.get(3)? });
    let sql = "SELECT epoch, event_id, alarm_id, audit_id FROM outbox_state";
    match transaction.prepare_cached(sql)?.query_row([], row).optional()? {
        Some(state) if state.epoch != 0 => Ok(state),
        Some(state) => {
            transaction.execute("UPDATE outbox_state SET epoch = ?1", [now.0])?;
            Ok(State { epoch: now.0, ..state })
        }
        None => {
            transaction.execute(
                "INSERT INTO outbox_state (id, epoch, event_id, alarm_id, audit_id) VALUES (1, ?1, 0, 0, 0)",
                [now.0],
            )?;
            Ok(State { epoch: now.0, event: 0, alarm: 0, audit: 0 })
        }
    }
}

/// Whether a sample is passed on, which makes it the last one of its series.
fn passes(forward: Forward, last: &mut LastForwarded, series: i64, sample: &Sample) -> bool {
    let passes = match forward {
        Forward::All => return true,
        Forward::Off => return false,
        Forward::Deadband(decades) => last.get(&series).is_none_or(|last| differs(last, sample, decades)),
    };
    if passes {
        last.insert(series, *sample);
    }
    passes
}

fn differs(last: &Sample, sample: &Sample, decades: f64) -> bool {
    let is_far = match (last.decades(), sample.decades()) {
        (Some(one), Some(two)) => (one - two).abs() >= decades,
        (one, two) => one.is_some() != two.is_some(),
    };
    is_far || last.quality != sample.quality || sample.at >= last.at.after(MAX_INTERVAL) || sample.at < last.at
}

/// Notes the spans that this transaction has changed.
fn note_spans(transaction: &Transaction<'_>, spans: &PendingSpans, ids: &[i64]) -> rusqlite::Result<()> {
    let sql = "INSERT OR IGNORE INTO outbox_span (level, series_id, start_us) VALUES (?1, ?2, ?3)";
    let mut note = transaction.prepare_cached(sql)?;
    for (key, _) in spans.iter().filter(|(key, _)| key.level >= FINEST_LEVEL) {
        note.execute(params![key.level, ids.get(key.series).copied().unwrap_or_default(), key.start.0])?;
    }
    Ok(())
}

/// The spans that were changed and have ended, with all of their samples so far. They are no longer noted as changed.
fn take_settled_spans(transaction: &Transaction<'_>, now: Micros) -> rusqlite::Result<Vec<Span>> {
    let mut select = transaction.prepare_cached(
        "SELECT name, level, start_us, min_pa, max_pa, log10_sum, count, qualities, series_id
         FROM outbox_span JOIN span USING (level, series_id, start_us) JOIN series ON series.id = series_id
         WHERE level = ?1 AND start_us <= ?2 LIMIT ?3",
    )?;
    let mut forget =
        transaction.prepare_cached("DELETE FROM outbox_span WHERE level = ?1 AND series_id = ?2 AND start_us = ?3")?;
    let mut taken = Vec::new();
    for level in LEVELS.into_iter().filter(|level| level.number >= FINEST_LEVEL) {
        let ended = now.0.saturating_sub(SETTLED).saturating_sub(level.micros());
        let mut rows = select.query(params![level.number, ended, MAX_ROWS_OF_KIND])?;
        let first = taken.len();
        while let Some(row) = rows.next()? {
            let span = Span {
                series: row.get(0)?,
                level: row.get(1)?,
                start_us: row.get(2)?,
                min_pa: row.get(3)?,
                max_pa: row.get(4)?,
                log10_sum: row.get(5)?,
                count: row.get(6)?,
                qualities: row.get(7)?,
            };
            taken.push((row.get::<_, i64>(8)?, span));
        }
        for (series, span) in taken.iter().skip(first) {
            forget.execute(params![span.level, series, span.start_us])?;
        }
    }
    Ok(taken.into_iter().map(|(_, span)| span).collect())
}

fn events(transaction: &Transaction<'_>, state: &mut State) -> rusqlite::Result<Vec<Event>> {
    let mut select = transaction.prepare_cached(
        "SELECT event.id, at_us, name, kind, text FROM event LEFT JOIN series ON series.id = series_id
         WHERE event.id > ?1 ORDER BY event.id LIMIT ?2",
    )?;
    let event = |row: &Row<'_>| {
        Ok(Event { id: row.get(0)?, at_us: row.get(1)?, series: row.get(2)?, kind: row.get(3)?, text: row.get(4)? })
    };
    let events =
        select.query_map(params![state.event, MAX_ROWS_OF_KIND], event)?.collect::<rusqlite::Result<Vec<_>>>()?;
    state.event = events.last().map_or(state.event, |event| event.id);
    Ok(events)
}

fn alarms(transaction: &Transaction<'_>, state: &mut State) -> rusqlite::Result<Vec<AlarmChange>> {
    let mut select = transaction.prepare_cached(
        "SELECT id, at_us, alarm, change, state, priority, subject, occurrence, user_name, value, unit, text
         FROM alarm_history WHERE id > ?1 ORDER BY id LIMIT ?2",
    )?;
    let change = |row: &Row<'_>| {
        Ok(AlarmChange {
            id: row.get(0)?,
            at_us: row.get(1)?,
            alarm: row.get(2)?,
            change: row.get(3)?,
            state: row.get(4)?,
            priority: row.get(5)?,
            subject: row.get(6)?,
            occurrence: row.get(7)?,
            user: row.get(8)?,
            value: row.get(9)?,
            unit: row.get(10)?,
            text: row.get(11)?,
        })
    };
    let alarms =
        select.query_map(params![state.alarm, MAX_ROWS_OF_KIND], change)?.collect::<rusqlite::Result<Vec<_>>>()?;
    state.alarm = alarms.last().map_or(state.alarm, |change| change.id);
    Ok(alarms)
}

fn audit(transaction: &Transaction<'_>, state: &mut State) -> rusqlite::Result<Vec<Audit>> {
    let mut select = transaction.prepare_cached(
        "SELECT id, at_us, action, refers_to, user_name, role, peer, gauge, target, before, after, outcome
         FROM audit WHERE id > ?1 ORDER BY id LIMIT ?2",
    )?;
    let entry = |row: &Row<'_>| {
        Ok(Audit {
            id: row.get(0)?,
            at_us: row.get(1)?,
            action: row.get(2)?,
            refers_to: row.get(3)?,
            user: row.get(4)?,
            role: row.get(5)?,
            peer: row.get(6)?,
            gauge: row.get(7)?,
            target: row.get(8)?,
            before: row.get(9)?,
            after: row.get(10)?,
            outcome: row.get(11)?,
        })
    };
    let audit =
        select.query_map(params![state.audit, MAX_ROWS_OF_KIND], entry)?.collect::<rusqlite::Result<Vec<_>>>()?;
    state.audit = audit.last().map_or(state.audit, |entry| entry.id);
    Ok(audit)
}

/// The samples, by series.
fn by_series(transaction: &Transaction<'_>, samples: &[(i64, Sample)]) -> rusqlite::Result<Vec<Samples>> {
    let mut series: BTreeMap<i64, Vec<Sample>> = BTreeMap::new();
    samples.iter().for_each(|(id, sample)| series.entry(*id).or_default().push(*sample));
    let mut name = transaction.prepare_cached("SELECT name FROM series WHERE id = ?1")?;
    series.iter().map(|(id, samples)| Ok(Samples::new(name.query_row([id], |row| row.get(0))?, samples))).collect()
}

fn insert(transaction: &Transaction<'_>, batch: &Batch) -> rusqlite::Result<()> {
    let payload =
        batch.encode_compressed().map_err(|error| rusqlite::Error::ToSqlConversionFailure(Box::new(error)))?;
    transaction.prepare_cached("INSERT INTO outbox (payload) VALUES (?1)")?.execute([payload]).map(drop)
}

/// Deletes the oldest batch when there are too many. The archive sees the gap in the numbers.
fn limit(transaction: &Transaction<'_>) -> rusqlite::Result<()> {
    let sql = "DELETE FROM outbox WHERE number <= (SELECT max(number) FROM outbox) - ?1";
    transaction.prepare_cached(sql)?.execute([MAX_BATCHES]).map(drop)
}

impl Reader {
    /// The batches after number `after` that wait, at most `count` of them and not many more than `octets`.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn outbox(&self, after: i64, count: u32, octets: usize) -> Result<Page, DatabaseError> {
        self.read_outbox(after, count, octets).map_err(|error| self.failed(error))
    }

    fn read_outbox(&self, after: i64, count: u32, octets: usize) -> rusqlite::Result<Page> {
        // One transaction, so that the epoch is that of the batches.
        let transaction = self.connection().unchecked_transaction()?;
        let epoch = transaction.query_row("SELECT epoch FROM outbox_state", [], |row| row.get(0)).optional()?;
        let mut select = transaction
            .prepare_cached("SELECT number, payload FROM outbox WHERE number > ?1 ORDER BY number LIMIT ?2")?;
        let mut rows = select.query(params![after, count])?;
        let (mut batches, mut read) = (Vec::new(), 0_usize);
        while read < octets {
            let Some(row) = rows.next()? else { break };
            let waiting = Waiting { number: row.get(0)?, payload: row.get(1)? };
            read = read.saturating_add(waiting.payload.len());
            batches.push(waiting);
        }
        Ok(Page { epoch: epoch.unwrap_or_default(), batches })
    }

    /// The number of batches that wait.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn outbox_length(&self) -> Result<i64, DatabaseError> {
        let sql = "SELECT ifnull(max(number) - min(number) + 1, 0) FROM outbox";
        self.connection().query_row(sql, [], |row| row.get(0)).map_err(|error| self.failed(error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alarms::AlarmBatch;
    use crate::backup::Existing;
    use crate::database::{Database, Retention};
    use crate::quality::Quality;
    use profivac_model::{AlarmChangeKind, AlarmHistoryEntry, AlarmState, Event as RecordEvent, EventKind, Priority};
    use std::path::Path;

    const DAY: i64 = 86_400 * Micros::SECOND;

    fn valid(at: i64, pa: f64) -> Sample {
        Sample::new(Micros(at), Some(pa), Quality::Valid)
    }

    fn open(path: &Path, forward: Forward) -> Database {
        let mut database = Database::open(path, Micros(DAY)).unwrap();
        database.set_outbox(Some(forward));
        database
    }

    fn write(database: &mut Database, now: i64, samples: &[Sample]) {
        let index = database.series_index("chamber");
        let mut spans = PendingSpans::default();
        samples.iter().for_each(|sample| spans.add(index, sample));
        let samples: Vec<_> = samples.iter().map(|sample| (index, *sample)).collect();
        database.set_time(Micros(now));
        database.write(&samples, &spans, &[], &AlarmBatch::default()).unwrap();
    }

    /// Writes an event and a row of the alarm history.
    fn write_event_and_alarm(database: &mut Database, at: i64, text: &str) {
        let event = RecordEvent { at: Micros(at), gauge: None, kind: EventKind::Note.into(), text: text.to_owned() };
        let change = AlarmHistoryEntry {
            at: Micros(at),
            alarm: "chamber too high".to_owned(),
            change: AlarmChangeKind::Raised.into(),
            state: AlarmState::Unacknowledged.into(),
            priority: Priority::High.into(),
            subject: None,
            occurrence: at,
            user: None,
            value: None,
            unit: None,
            text: text.to_owned(),
        };
        let alarms = AlarmBatch { history: vec![change], ..AlarmBatch::default() };
        database.write(&[], &PendingSpans::default(), &[event], &alarms).unwrap();
    }

    /// The ids and texts of all events in the batches, then those of all alarm changes.
    fn sent(path: &Path) -> [Vec<(i64, String)>; 2] {
        let batches = batches(path);
        let events = batches.iter().flat_map(|batch| &batch.events).map(|event| (event.id, event.text.clone()));
        let alarms = batches.iter().flat_map(|batch| &batch.alarms).map(|change| (change.id, change.text.clone()));
        [events.collect(), alarms.collect()]
    }

    fn row_counts(path: &Path) -> (i64, i64) {
        let sql = "SELECT (SELECT count(*) FROM event), (SELECT count(*) FROM alarm_history)";
        let reader = Reader::open(path).unwrap();
        reader.connection().query_row(sql, [], |row| Ok((row.get(0)?, row.get(1)?))).unwrap()
    }

    fn page(path: &Path) -> Page {
        Reader::open(path).unwrap().outbox(0, 100, usize::MAX).unwrap()
    }

    fn batches(path: &Path) -> Vec<Batch> {
        page(path).batches.iter().map(|waiting| Batch::decode_compressed(&waiting.payload).unwrap()).collect()
    }

    #[test]
    fn a_batch_has_the_samples_of_the_record_at_the_times_of_the_record() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let mut database = open(&path, Forward::All);
        write(&mut database, DAY, &[valid(DAY, 1.0), valid(DAY, 1.0), valid(DAY, 2.0)]);
        // A repeated sample is one row; another one at a taken time moves by a microsecond.
        write(&mut database, DAY, &[valid(DAY, 1.0), valid(DAY - 5, 3.0)]);
        let sent: Vec<_> =
            batches(&path).iter().flat_map(|batch| batch.samples.clone()).map(|it| it.unpack().unwrap()).collect();
        assert_eq!(sent, [vec![valid(DAY, 1.0), valid(DAY + 1, 2.0)], vec![valid(DAY - 5, 3.0)]]);
        let mut sent = sent.concat();
        sent.sort_by_key(|sample| sample.at);
        assert_eq!(Reader::open(&path).unwrap().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap(), sent);
    }

    #[test]
    fn numbers_have_no_gaps_and_are_not_used_again_after_an_acknowledgement() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let mut database = open(&path, Forward::All);
        let numbers = || page(&path).batches.iter().map(|waiting| waiting.number).collect::<Vec<_>>();
        (0..3).for_each(|second| write(&mut database, DAY, &[valid(DAY + second, 1.0)]));
        assert_eq!(numbers(), [1, 2, 3]);
        let epoch = page(&path).epoch;
        database.acknowledge_outbox(epoch + 1, 3).unwrap();
        assert_eq!(numbers(), [1, 2, 3], "of another database");
        database.acknowledge_outbox(epoch, 3).unwrap();
        drop(database);
        write(&mut open(&path, Forward::All), DAY, &[valid(DAY + 9, 1.0)]);
        assert_eq!(numbers(), [4]);
        assert_eq!(page(&path).epoch, epoch);
        assert_eq!(Reader::open(&path).unwrap().outbox_length().unwrap(), 1);
    }

    #[test]
    fn a_span_is_sent_when_it_has_ended_and_again_after_a_late_sample() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let mut database = open(&path, Forward::Off);
        write(&mut database, DAY, &[valid(DAY, 1.0)]);
        assert!(page(&path).batches.is_empty());
        let after = DAY + 126 * Micros::SECOND;
        write(&mut database, after, &[]);
        write(&mut database, after, &[]);
        write(&mut database, after, &[valid(DAY + 1, 3.0)]);
        let spans: Vec<_> = batches(&path).into_iter().flat_map(|batch| batch.spans).collect();
        let short: Vec<_> = spans.iter().map(|span| (span.level, span.start_us, span.count, span.max_pa)).collect();
        assert_eq!(short, [(2, DAY, 1, Some(1.0)), (2, DAY, 2, Some(3.0))]);
    }

    #[test]
    fn events_are_sent_once_also_those_before_the_outbox() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let event = |text: &str| RecordEvent {
            at: Micros(1),
            gauge: None,
            kind: EventKind::Note.into(),
            text: text.to_owned(),
        };
        let mut database = Database::open(&path, Micros(DAY)).unwrap();
        database.write(&[], &PendingSpans::default(), &[event("before")], &AlarmBatch::default()).unwrap();
        database.set_outbox(Some(Forward::Off));
        database.write(&[], &PendingSpans::default(), &[event("after")], &AlarmBatch::default()).unwrap();
        database.write(&[], &PendingSpans::default(), &[], &AlarmBatch::default()).unwrap();
        let texts: Vec<_> = batches(&path).into_iter().flat_map(|batch| batch.events).map(|it| it.text).collect();
        assert_eq!(texts, ["before", "after"]);
    }

    #[test]
    fn rows_after_a_retention_that_deleted_all_events_and_the_alarm_history_are_sent() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let mut database = open(&path, Forward::Off);
        database.begin_period(Micros(DAY)).unwrap();
        write_event_and_alarm(&mut database, DAY, "before");
        write_event_and_alarm(&mut database, DAY + 1, "before, too");
        let day = Some(Duration::from_secs(86_400));
        let retention = Retention { events: day, alarm_history: day, ..Retention::default() };
        database.extend_period(Micros(2 * DAY)).unwrap();
        database.prune(&retention).unwrap();
        assert_eq!(row_counts(&path), (2, 2), "the time is not over yet");
        database.extend_period(Micros(2 * DAY + 2)).unwrap();
        database.prune(&retention).unwrap();
        assert_eq!(row_counts(&path), (0, 0));
        drop(database);
        write_event_and_alarm(&mut open(&path, Forward::Off), 2 * DAY + 3, "after");
        let expected = [(1, "before"), (2, "before, too"), (3, "after")].map(|(id, text)| (id, text.to_owned()));
        assert_eq!(sent(&path), [expected.to_vec(), expected.to_vec()]);
    }

    /// Samples and events refer to a series by its id, and the retention counts the recording periods.
    #[test]
    fn a_retention_that_deletes_everything_leaves_the_series_and_the_recording_periods() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let mut database = open(&path, Forward::Off);
        database.begin_period(Micros(DAY)).unwrap();
        write(&mut database, DAY, &[valid(DAY, 1.0)]);
        write_event_and_alarm(&mut database, DAY, "deleted");
        database.extend_period(Micros(2 * DAY)).unwrap();
        database.begin_period(Micros(900 * DAY)).unwrap();
        database.extend_period(Micros(902 * DAY)).unwrap();
        let day = Some(Duration::from_secs(86_400));
        database.prune(&Retention { samples: day, spans: [day; 4], events: day, alarm_history: day }).unwrap();
        drop(database);
        let reader = Reader::open(&path).unwrap();
        let count = |table: &str| -> i64 {
            reader.connection().query_row(&format!("SELECT count(*) FROM {table}"), [], |row| row.get(0)).unwrap()
        };
        let deleted = ["sample", "span", "event", "alarm_history"].map(count);
        assert_eq!((deleted, count("series"), count("recording_period")), ([0; 4], 1, 2));
    }

    /// The last rows are the first to be deleted if the clock was behind when they were written.
    #[test]
    fn rows_after_a_retention_that_deleted_the_last_rows_alone_are_sent() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let mut database = open(&path, Forward::Off);
        database.begin_period(Micros(9 * DAY)).unwrap();
        database.extend_period(Micros(11 * DAY)).unwrap();
        write_event_and_alarm(&mut database, 11 * DAY, "kept");
        write_event_and_alarm(&mut database, DAY, "deleted");
        let day = Some(Duration::from_secs(86_400));
        database.prune(&Retention { events: day, alarm_history: day, ..Retention::default() }).unwrap();
        assert_eq!(row_counts(&path), (1, 1));
        write_event_and_alarm(&mut database, 11 * DAY, "after");
        let expected = [(1, "kept"), (2, "deleted"), (3, "after")].map(|(id, text)| (id, text.to_owned()));
        assert_eq!(sent(&path), [expected.to_vec(), expected.to_vec()]);
    }

    #[test]
    fn the_deadband_passes_changes_of_five_percent_of_quality_and_one_sample_in_ten_minutes() {
        let mut last = LastForwarded::new();
        let five_percent = Forward::Deadband(1.05_f64.log10());
        let samples = [
            (valid(0, 1.0), true),
            (valid(1, 1.04), false),
            (valid(2, 1.051), true),
            (Sample::gap(Micros(3)), true),
            (Sample::gap(Micros(4)), false),
            (valid(5, 1.0), true),
            (valid(600 * Micros::SECOND + 5, 1.0), true),
        ];
        for (sample, passed) in samples {
            assert_eq!(passes(five_percent, &mut last, 1, &sample), passed, "{sample:?}");
        }
    }

    #[test]
    fn many_samples_of_one_transaction_are_several_batches() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let count = MAX_SAMPLES as i64 + 1;
        let samples: Vec<_> = (0..count).map(|at| valid(DAY + at, 1.0)).collect();
        write(&mut open(&path, Forward::All), DAY, &samples);
        let counts: Vec<_> = batches(&path).iter().map(Batch::sample_count).collect();
        assert_eq!(counts, [MAX_SAMPLES, 1]);
    }

    #[test]
    fn a_restored_copy_begins_another_epoch() {
        let folder = tempfile::tempdir().unwrap();
        let (path, copy) = (folder.path().join("plant.db"), folder.path().join("copy.db"));
        write(&mut open(&path, Forward::All), DAY, &[valid(DAY, 1.0)]);
        Reader::open(&path).unwrap().backup(&copy, Existing::Keep, |_, _| ()).unwrap();
        write(&mut open(&copy, Forward::All), DAY + 7, &[valid(DAY + 1, 1.0)]);
        assert_eq!((page(&path).epoch, page(&copy).epoch), (DAY, DAY + 7));
        assert_eq!(page(&copy).batches.len(), 2);
    }
}
