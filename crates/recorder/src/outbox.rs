//! The outbox: the rows of each transaction once more, as a numbered batch for the archive, in the same transaction.
//!
//! A row of the database is therefore in a batch, and the other way round, after every kill and every power cut. A batch never
//! changes once it has a number, so that it may be sent twice. Numbers have no gaps. Moving an acknowledged batch to `outbox_kept` is what
//! moves the cursor: the archive asks for those that its database lacks.

mod absence;
mod epoch;

use super::batch::{
    AlarmChange, Audit, Batch, BatchPoint, Event, FORMAT, MAX_SAMPLES, PointSamples, PointSpan, PointText, Samples,
    Span,
};
use super::error::DatabaseError;
use super::point::{CodeText, LARGEST, Point, PointKind, PointSample};
use super::quality::Quality;
use super::reader::Reader;
use super::sample::{Micros, Sample};
use super::spans::{LEVELS, PendingSpans, SpanKey};
pub use absence::note as note_absence;
use epoch::State;
pub use epoch::{begin_epoch, branch};
use profivac_model::EventKind;
use rusqlite::{OptionalExtension, Row, Rows, Transaction, params};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::RangeInclusive;
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

/// The texts of a point are in a batch again after this time, for an archive that has lost the batch before. chosen
const TEXTS_INTERVAL: Duration = Duration::from_secs(6 * 3_600);

/// The most rows of a kind in the batch of one transaction; of spans, of a level. With the series of [`MAX_SAMPLES`] samples they are
/// fewer than [`MAX_ROWS`](super::batch::MAX_ROWS).
const MAX_ROWS_OF_KIND: u32 = 1_000;

/// The most batches that wait, 30 days at one a second: then the oldest are deleted.
const MAX_BATCHES: i64 = 2_592_000;

/// The most batches that are kept while the database of the archive does not confirm them: those of a week at one a second. chosen
const MAX_UNCONFIRMED: i64 = 604_800;

/// The texts of the codes of points.
pub type PointTexts = HashMap<BatchPoint, Vec<CodeText>>;

/// The last samples that were passed on, by the ids of the series and of the points, and when the texts of a point were.
#[derive(Clone, Debug, Default)]
pub struct LastForwarded {
    series: HashMap<i64, Sample>,
    points: HashMap<i64, PointSample>,
    texts: HashMap<BatchPoint, Micros>,
}

impl LastForwarded {
    /// The texts have changed: each point is sent with its own again.
    pub fn forget_texts(&mut self) {
        self.texts.clear();
    }
}

/// The rows of pressures of a transaction.
pub struct PressureRows<'a> {
    /// The new samples, by the id of their series.
    pub inserted: &'a [(i64, Sample)],
    /// The spans that the transaction has changed, by the index of their series.
    pub spans: &'a PendingSpans,
    /// The ids of the series, by index.
    pub ids: &'a [i64],
}

/// The rows of points of a transaction.
pub struct PointRows<'a> {
    /// The new samples, by the id of their point.
    pub inserted: &'a [(i64, PointSample)],
    /// The spans that the transaction has changed, by the index of their point.
    pub spans: &'a PendingSpans<PointSample>,
    /// The points and their ids, by index.
    pub points: &'a [Point],
    pub ids: &'a [i64],
    /// The texts of the station's file.
    pub texts: &'a PointTexts,
}

/// An answer about the batches of a database.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Acknowledgement {
    /// The epoch of the database.
    pub epoch: i64,
    /// The servers have the batches up to this number, or the archive itself.
    pub taken: i64,
    /// The database of the archive has every batch up to this number.
    pub stored: i64,
}

impl Acknowledgement {
    /// Both answers; the later one, if they are about two epochs.
    #[must_use]
    pub fn and(self, later: Self) -> Self {
        match self.epoch == later.epoch {
            true => {
                Self { epoch: later.epoch, taken: self.taken.max(later.taken), stored: self.stored.max(later.stored) }
            }
            false => later,
        }
    }
}

/// A batch that waits, or is kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Waiting {
    /// The epoch of the database in which it was made.
    pub epoch: i64,
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

/// The batches that wait, in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// How many batches wait.
    pub waiting: i64,
    /// When the first of them was made.
    pub oldest: Option<Micros>,
    /// How many were deleted since the last acknowledgement because too many wait.
    pub lost: i64,
}

/// Adds a batch with the rows of this transaction, if there are any. Returns the samples that were passed on last.
pub fn put(
    transaction: &Transaction<'_>,
    forward: Forward,
    last: &LastForwarded,
    pressures: &PressureRows<'_>,
    points: &PointRows<'_>,
    now: Micros,
) -> rusqlite::Result<LastForwarded> {
    let PressureRows { inserted, spans, ids } = *pressures;
    let mut state = State::current(transaction, now)?;
    let mut last = last.clone();
    let samples = inserted.iter().filter(|(series, sample)| passes(forward, &mut last.series, *series, sample));
    let samples: Vec<_> = samples.copied().collect();
    let of_points = points.passed(forward, &mut last.points);
    note_spans(transaction, NOTE_SPAN, spans.iter().map(|(key, _)| key), ids)?;
    note_spans(transaction, NOTE_POINT_SPAN, points.spans.iter().map(|(key, _)| key), points.ids)?;
    let mut batch = Batch {
        format: FORMAT,
        made_us: now.0,
        samples: Vec::new(),
        spans: take_settled_spans(transaction, now)?,
        events: events(transaction, &mut state)?,
        alarms: alarms(transaction, &mut state)?,
        audit: audit(transaction, &mut state)?,
        point_samples: Vec::new(),
        point_spans: take_settled_point_spans(transaction, now)?,
        first_number: state.first_number,
        point_texts: Vec::new(),
    };
    let earlier = absence::next(transaction, forward, now)?;
    // The samples of points are in the first batch if all fit, as in a plant of usual size; otherwise in batches of their own.
    let fit = samples.len().saturating_add(of_points.len()) <= MAX_SAMPLES;
    let (of_points, later_points) = if fit { (&of_points[..], &[][..]) } else { (&[][..], &of_points[..]) };
    batch.point_samples = points.packed(of_points);
    batch.point_texts = points.texts_of(&batch, &mut last.texts, now);
    let mut chunks = samples.chunks(MAX_SAMPLES);
    batch.samples = by_series(transaction, chunks.next().unwrap_or_default())?;
    let has_rows = !(batch.events.is_empty() && batch.alarms.is_empty() && batch.audit.is_empty());
    let has_points = !(batch.point_samples.is_empty() && batch.point_spans.is_empty());
    if has_rows || has_points || !batch.samples.is_empty() || !batch.spans.is_empty() {
        insert(transaction, &batch)?;
    }
    for chunk in chunks {
        let samples = by_series(transaction, chunk)?;
        let first_number = state.first_number;
        insert(transaction, &Batch { format: FORMAT, made_us: now.0, samples, first_number, ..Batch::default() })?;
    }
    for chunk in later_points.chunks(MAX_SAMPLES) {
        let (point_samples, first_number) = (points.packed(chunk), state.first_number);
        let mut batch = Batch { format: FORMAT, made_us: now.0, point_samples, first_number, ..Batch::default() };
        batch.point_texts = points.texts_of(&batch, &mut last.texts, now);
        insert(transaction, &batch)?;
    }
    if !(earlier.samples.is_empty() && earlier.point_samples.is_empty()) {
        let absence::Page { samples, point_samples } = earlier;
        let first_number = state.first_number;
        let batch = Batch { format: FORMAT, made_us: now.0, samples, point_samples, first_number, ..Batch::default() };
        insert(transaction, &batch)?;
    }
    if has_rows {
        transaction
            .prepare_cached("UPDATE outbox_state SET event_id = ?1, alarm_id = ?2, audit_id = ?3")?
            .execute(params![state.event, state.alarm, state.audit])?;
    }
    limit(transaction, now)?;
    Ok(last)
}

/// What becomes of batches that were taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// They are kept, in case the archive loses them.
    Keep,
    /// They are deleted: the disk has no room.
    Forget,
}

/// Keeps the batches that were taken, and notes up to which number the database of the archive has them.
pub fn acknowledge(
    transaction: &Transaction<'_>,
    answer: Acknowledgement,
    taken_batches: Taken,
    now: Micros,
) -> rusqlite::Result<()> {
    let Acknowledgement { epoch, taken, stored } = answer;
    let found =
        transaction.prepare_cached("SELECT epoch FROM outbox_state")?.query_row([], |row| row.get(0)).optional()?;
    if found != Some(epoch) {
        return Ok(());
    }
    let keep = "INSERT OR REPLACE INTO outbox_kept (number, epoch, acknowledged_us, payload)
        SELECT number, ifnull(epoch, ?1), ?2, payload FROM outbox WHERE number <= ?3";
    match taken_batches {
        Taken::Keep => drop(transaction.prepare_cached(keep)?.execute([epoch, now.0, taken])?),
        Taken::Forget => drop(transaction.execute("DELETE FROM outbox_kept WHERE number <= ?1", [stored])?),
    }
    let moved = transaction.prepare_cached("DELETE FROM outbox WHERE number <= ?1")?.execute([taken])?;
    if moved > 0 {
        end_loss(transaction, now)?;
    }
    let limit = "DELETE FROM outbox_kept WHERE number <= ?1";
    transaction.prepare_cached(limit)?.execute([taken.saturating_sub(MAX_UNCONFIRMED)])?;
    let note = "UPDATE outbox_state SET stored = ?1 WHERE stored < ?1";
    transaction.prepare_cached(note)?.execute([stored]).map(drop)
}

impl PointRows<'_> {
    /// The samples that are passed on.
    fn passed(&self, forward: Forward, last: &mut HashMap<i64, PointSample>) -> Vec<(i64, PointSample)> {
        let is_code = |id: i64| self.point(id).is_some_and(|point| point.kind == PointKind::Code);
        let passed = |(id, sample): &&(i64, PointSample)| passes_point(forward, last, *id, is_code(*id), sample);
        self.inserted.iter().filter(passed).copied().collect()
    }

    /// The samples, by point.
    fn packed(&self, samples: &[(i64, PointSample)]) -> Vec<PointSamples> {
        let mut by_point: BTreeMap<i64, Vec<PointSample>> = BTreeMap::new();
        samples.iter().for_each(|(id, sample)| by_point.entry(*id).or_default().push(*sample));
        let packed = by_point.iter();
        packed.filter_map(|(id, samples)| Some(PointSamples::new(BatchPoint::of(self.point(*id)?), samples))).collect()
    }

    /// The texts of the points in a batch, once in [`TEXTS_INTERVAL`]. Those that find no room are in the next batch with their point. A
    /// code that `scale` of the station's file makes larger than any sample has none: an archive would refuse the batch.
    fn texts_of(&self, batch: &Batch, sent: &mut HashMap<BatchPoint, Micros>, now: Micros) -> Vec<PointText> {
        let of_spans = batch.point_spans.iter().map(|span| &span.point);
        let points: BTreeSet<_> = batch.point_samples.iter().map(|samples| &samples.point).chain(of_spans).collect();
        let most = MAX_ROWS_OF_KIND as usize;
        let mut rows: Vec<PointText> = Vec::new();
        for point in points {
            let Some(texts) = self.texts.get(point) else { continue };
            let is_due = sent.get(point).is_none_or(|at| now < *at || now >= at.after(TEXTS_INTERVAL));
            if !is_due || (!rows.is_empty() && rows.len().saturating_add(texts.len()) > most) {
                continue;
            }
            let row = |code: &CodeText| PointText { point: point.clone(), value: code.number, text: code.text.clone() };
            rows.extend(texts.iter().filter(|code| code.number.abs() <= LARGEST).take(most).map(row));
            sent.insert(point.clone(), now);
        }
        rows
    }

    fn point(&self, id: i64) -> Option<&Point> {
        self.points.get(self.ids.iter().position(|known| *known == id)?)
    }
}

/// Whether a value of a point is passed on. chosen: a number that differs from the last one by the factor, as a pressure; each code.
fn passes_point(
    forward: Forward,
    last: &mut HashMap<i64, PointSample>,
    point: i64,
    is_code: bool,
    sample: &PointSample,
) -> bool {
    let passes = match forward {
        Forward::All => return true,
        Forward::Off => return false,
        Forward::Deadband(decades) => last.get(&point).is_none_or(|last| {
            let is_far = match (last.number, sample.number) {
                (Some(one), Some(two)) if is_code => one != two,
                (Some(one), Some(two)) => one != two && (two - one).abs() >= (10_f64.powf(decades) - 1.0) * one.abs(),
                (one, two) => one.is_some() != two.is_some(),
            };
            is_far || is_other(last.at, last.quality, sample.at, sample.quality)
        }),
    };
    if passes {
        last.insert(point, *sample);
    }
    passes
}

/// Whether a sample of this time and quality is passed on whatever its value.
fn is_other(last: Micros, of_last: Quality, at: Micros, quality: Quality) -> bool {
    of_last != quality || at >= last.after(MAX_INTERVAL) || at < last
}

/// Whether a sample is passed on, which makes it the last one of its series.
fn passes(forward: Forward, last: &mut HashMap<i64, Sample>, series: i64, sample: &Sample) -> bool {
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
    is_far || is_other(last.at, last.quality, sample.at, sample.quality)
}

const NOTE_SPAN: &str = "INSERT OR IGNORE INTO outbox_span (level, series_id, start_us) VALUES (?1, ?2, ?3)";
const NOTE_POINT_SPAN: &str = "INSERT OR IGNORE INTO outbox_point_span (level, point_id, start_us) VALUES (?1, ?2, ?3)";

/// Notes the spans that this transaction has changed.
fn note_spans<'k>(
    transaction: &Transaction<'_>,
    sql: &str,
    spans: impl Iterator<Item = &'k SpanKey>,
    ids: &[i64],
) -> rusqlite::Result<()> {
    let mut note = transaction.prepare_cached(sql)?;
    for key in spans.filter(|key| key.level >= FINEST_LEVEL) {
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

/// The same of points.
fn take_settled_point_spans(transaction: &Transaction<'_>, now: Micros) -> rusqlite::Result<Vec<PointSpan>> {
    let mut select = transaction.prepare_cached(
        "SELECT slave, name, unit, kind, level, start_us, min_value, max_value, last_value, sum, count, qualities, point_id
         FROM outbox_point_span JOIN point_span USING (level, point_id, start_us) JOIN point ON point.id = point_id
         WHERE level = ?1 AND start_us <= ?2 LIMIT ?3",
    )?;
    let mut forget = transaction
        .prepare_cached("DELETE FROM outbox_point_span WHERE level = ?1 AND point_id = ?2 AND start_us = ?3")?;
    let mut taken = Vec::new();
    for level in LEVELS.into_iter().filter(|level| level.number >= FINEST_LEVEL) {
        let ended = now.0.saturating_sub(SETTLED).saturating_sub(level.micros());
        let mut rows = select.query(params![level.number, ended, MAX_ROWS_OF_KIND])?;
        let first = taken.len();
        while let Some(row) = rows.next()? {
            let point = BatchPoint { slave: row.get(0)?, name: row.get(1)?, unit: row.get(2)?, kind: row.get(3)? };
            let span = PointSpan {
                point,
                level: row.get(4)?,
                start_us: row.get(5)?,
                min_value: row.get(6)?,
                max_value: row.get(7)?,
                last_value: row.get(8)?,
                sum: row.get(9)?,
                count: row.get(10)?,
                qualities: row.get(11)?,
            };
            taken.push((row.get::<_, i64>(12)?, span));
        }
        for (point, span) in taken.iter().skip(first) {
            forget.execute(params![span.level, point, span.start_us])?;
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
    transaction.prepare_cached("INSERT INTO outbox (payload) VALUES (?1)")?.execute([encoded(batch)?]).map(drop)
}

fn encoded(batch: &Batch) -> rusqlite::Result<Vec<u8>> {
    batch.encode_compressed().map_err(|error| rusqlite::Error::ToSqlConversionFailure(Box::new(error)))
}

/// Deletes the oldest batch when there are too many. The archive sees the gap in the numbers, the operator an event when it begins.
fn limit(transaction: &Transaction<'_>, now: Micros) -> rusqlite::Result<()> {
    let sql = "DELETE FROM outbox WHERE number <= (SELECT max(number) FROM outbox) - ?1";
    let deleted = transaction.prepare_cached(sql)?.execute([MAX_BATCHES])?;
    if deleted == 0 {
        return Ok(());
    }
    if lost(transaction)? == 0 {
        let text = format!(
            "{MAX_BATCHES} batches wait for the archive, and none is taken: the station deletes the oldest for each new one; their rows stay in \
             the database of the station"
        );
        station_event(transaction, now, &text)?;
    }
    transaction
        .prepare_cached("UPDATE outbox_state SET lost = lost + ?1")?
        .execute([i64::try_from(deleted).unwrap_or(i64::MAX)])
        .map(drop)
}

/// How many batches were deleted since the last acknowledgement because too many wait.
fn lost(connection: &rusqlite::Connection) -> rusqlite::Result<i64> {
    let found =
        connection.prepare_cached("SELECT lost FROM outbox_state")?.query_row([], |row| row.get(0)).optional()?;
    Ok(found.unwrap_or_default())
}

/// Batches are taken again.
fn end_loss(transaction: &Transaction<'_>, now: Micros) -> rusqlite::Result<()> {
    let lost = lost(transaction)?;
    if lost > 0 {
        let text =
            format!("batches are taken again; {lost} that waited before them were deleted and are not in the archive");
        station_event(transaction, now, &text)?;
        transaction.execute("UPDATE outbox_state SET lost = 0", [])?;
    }
    Ok(())
}

fn station_event(transaction: &Transaction<'_>, now: Micros, text: &str) -> rusqlite::Result<()> {
    let sql = "INSERT INTO event (at_us, kind, text) VALUES (?1, ?2, ?3)";
    transaction.execute(sql, params![now.0, EventKind::Station.word(), text]).map(drop)
}

/// The first rows, not many more than `octets`.
fn some(rows: &mut Rows<'_>, octets: usize) -> rusqlite::Result<Vec<Waiting>> {
    let (mut batches, mut read) = (Vec::new(), 0_usize);
    while read < octets {
        let Some(row) = rows.next()? else { break };
        let waiting = Waiting { epoch: row.get(0)?, number: row.get(1)?, payload: row.get(2)? };
        read = read.saturating_add(waiting.payload.len());
        batches.push(waiting);
    }
    Ok(batches)
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
        let epoch = epoch.unwrap_or_default();
        let sql = "SELECT ifnull(epoch, ?3), number, payload FROM outbox WHERE number > ?1 ORDER BY number LIMIT ?2";
        let mut select = transaction.prepare_cached(sql)?;
        let batches = some(&mut select.query(params![after, count, epoch])?, octets)?;
        Ok(Page { epoch, batches })
    }

    /// The batches of an epoch with these numbers that were acknowledged and are kept, at most `count` of them and not many more than
    /// `octets`.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn kept_batches(
        &self,
        epoch: i64,
        numbers: RangeInclusive<i64>,
        count: u32,
        octets: usize,
    ) -> Result<Vec<Waiting>, DatabaseError> {
        let read = || {
            let mut select = self.connection().prepare_cached(
                "SELECT epoch, number, payload FROM outbox_kept WHERE epoch = ?1 AND number BETWEEN ?2 AND ?3
                 ORDER BY number LIMIT ?4",
            )?;
            some(&mut select.query(params![epoch, numbers.start(), numbers.end(), count])?, octets)
        };
        read().map_err(|error| self.failed(error))
    }

    /// How many batches wait, and since when.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn outbox_summary(&self) -> Result<Summary, DatabaseError> {
        let read = || {
            let sql = "SELECT ifnull(max(number) - min(number) + 1, 0) FROM outbox";
            let waiting = self.connection().query_row(sql, [], |row| row.get(0))?;
            let sql = "SELECT payload FROM outbox ORDER BY number LIMIT 1";
            let first: Option<Vec<u8>> = self.connection().query_row(sql, [], |row| row.get(0)).optional()?;
            let oldest = first.and_then(|payload| Batch::decode_compressed(&payload).ok());
            Ok(Summary { waiting, oldest: oldest.map(|batch| Micros(batch.made_us)), lost: lost(self.connection())? })
        };
        read().map_err(|error| self.failed(error))
    }
}

#[cfg(test)]
mod tests;
