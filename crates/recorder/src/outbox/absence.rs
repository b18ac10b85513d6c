//! What was recorded while the station had no `[archive]`, and is sent when it has one again.
//!
//! The first transaction without an outbox notes its time; the first one with an outbox looks back from there. Each transaction then puts a
//! part into a batch: one series after the other, and one point after the other, with their spans. Events, alarms and the audit trail come
//! by their ids.

use super::{
    BatchPoint, FINEST_LEVEL, Forward, LEVELS, Micros, PointSample, PointSamples, Quality, Sample, Samples, passes,
    passes_point, station_event,
};
use crate::state::{self, StationState};
use rusqlite::{OptionalExtension, Row, Transaction, params};
use std::collections::HashMap;

/// The name of the state. Its time is that of the first row without an outbox, its value a [`Progress`] in words, empty before the return.
const ABSENCE: &str = "archive-absence";

/// The most samples of a transaction, before the deadband. chosen: some milliseconds.
const PAGE: usize = 5_000;

/// What a station records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Series,
    Point,
}

/// How far the station has looked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Progress {
    /// When the outbox was there again.
    until_us: i64,
    kind: Kind,
    /// The present series or point; none before it has rows left.
    id: i64,
    /// Its first sample that is left.
    at_us: i64,
}

impl Progress {
    fn read(value: &str) -> Option<Self> {
        let mut words = value.split(' ');
        let kind = match words.next()? {
            "series" => Kind::Series,
            "point" => Kind::Point,
            _ => return None,
        };
        let mut number = || words.next()?.parse().ok();
        Some(Self { kind, id: number()?, at_us: number()?, until_us: number()? })
    }

    fn written(&self) -> String {
        let kind = match self.kind {
            Kind::Series => "series",
            Kind::Point => "point",
        };
        format!("{kind} {} {} {}", self.id, self.at_us, self.until_us)
    }
}

/// What a transaction puts into its batch.
#[derive(Debug, Default)]
pub(super) struct Page {
    pub(super) samples: Vec<Samples>,
    pub(super) point_samples: Vec<PointSamples>,
}

/// Notes that a transaction with samples from `earliest` on is in no batch. A station that has never had an outbox sends nothing of that time.
pub fn note(transaction: &Transaction<'_>, earliest: Option<Micros>) -> rusqlite::Result<()> {
    let Some(earliest) = earliest else { return Ok(()) };
    let sql = "INSERT INTO station_state (name, at_us, value) SELECT ?1, ?2, '' FROM outbox_state WHERE true
        ON CONFLICT DO UPDATE SET at_us = min(at_us, excluded.at_us), value = '' WHERE at_us > excluded.at_us OR value <> ''";
    transaction.prepare_cached(sql)?.execute(params![ABSENCE, earliest.0]).map(drop)
}

/// The next part of what was recorded without an outbox.
pub(super) fn next(transaction: &Transaction<'_>, forward: Forward, now: Micros) -> rusqlite::Result<Page> {
    let mut page = Page::default();
    let row = |row: &Row<'_>| Ok((row.get::<_, i64>(0)?, row.get::<_, String>(1)?));
    let sql = "SELECT at_us, value FROM station_state WHERE name = ?1";
    let Some((since, value)) = transaction.prepare_cached(sql)?.query_row([ABSENCE], row).optional()? else {
        return Ok(page);
    };
    let begun = Progress::read(&value);
    if begun.is_none() {
        let text = format!(
            "the station sends to an archive again, also what it has recorded since {}",
            Micros(since).to_iso(0)
        );
        station_event(transaction, now, &text)?;
    }
    let mut progress = begun.unwrap_or(Progress { until_us: now.0, kind: Kind::Series, id: 0, at_us: since });
    let mut room = PAGE;
    while room > 0 {
        let Some(id) = present(transaction, &progress)? else {
            match progress.kind {
                Kind::Series => progress = Progress { kind: Kind::Point, id: 0, at_us: since, ..progress },
                Kind::Point => {
                    transaction.execute("DELETE FROM station_state WHERE name = ?1", [ABSENCE])?;
                    return Ok(page);
                }
            }
            continue;
        };
        progress.id = id;
        let (read, last) = match progress.kind {
            Kind::Series => page.add_series(transaction, forward, &progress, room)?,
            Kind::Point => page.add_point(transaction, forward, &progress, room)?,
        };
        match last.filter(|_| read == room) {
            Some(last) => progress.at_us = last.saturating_add(1),
            None => {
                note_spans(transaction, &progress, since)?;
                (progress.id, progress.at_us) = (id.saturating_add(1), since);
            }
        }
        room = room.saturating_sub(read);
    }
    state::store(transaction, &StationState { name: ABSENCE, at: Micros(since), value: progress.written() })?;
    Ok(page)
}

/// The series or point that is next, from the present one on.
fn present(transaction: &Transaction<'_>, progress: &Progress) -> rusqlite::Result<Option<i64>> {
    let sql = match progress.kind {
        Kind::Series => "SELECT min(id) FROM series WHERE id >= ?1",
        Kind::Point => "SELECT min(id) FROM point WHERE id >= ?1",
    };
    transaction.prepare_cached(sql)?.query_row([progress.id], |row| row.get(0))
}

fn quality(number: i64) -> Quality {
    Quality::from_number(number).unwrap_or(Quality::Fault)
}

impl Page {
    /// Adds at most `room` samples of a series. Returns how many were read, and the time of the last one.
    fn add_series(
        &mut self,
        transaction: &Transaction<'_>,
        forward: Forward,
        progress: &Progress,
        room: usize,
    ) -> rusqlite::Result<(usize, Option<i64>)> {
        let Progress { until_us, id, at_us, .. } = *progress;
        let sql = "SELECT at_us, pressure_pa, quality FROM sample WHERE series_id = ?1 AND at_us BETWEEN ?2 AND ?3 ORDER BY at_us LIMIT ?4";
        let sample =
            |row: &Row<'_>| Ok(Sample { at: Micros(row.get(0)?), pa: row.get(1)?, quality: quality(row.get(2)?) });
        let mut select = transaction.prepare_cached(sql)?;
        let read = select
            .query_map(params![id, at_us, until_us, room as i64], sample)?
            .collect::<rusqlite::Result<Vec<_>>>()?;
        let mut last = HashMap::new();
        let passed: Vec<_> = read.iter().filter(|sample| passes(forward, &mut last, id, sample)).copied().collect();
        if !passed.is_empty() {
            let name = "SELECT name FROM series WHERE id = ?1";
            let name = transaction.prepare_cached(name)?.query_row([id], |row| row.get(0))?;
            self.samples.push(Samples::new(name, &passed));
        }
        Ok((read.len(), read.last().map(|sample| sample.at.0)))
    }

    /// The same of a point.
    fn add_point(
        &mut self,
        transaction: &Transaction<'_>,
        forward: Forward,
        progress: &Progress,
        room: usize,
    ) -> rusqlite::Result<(usize, Option<i64>)> {
        let Progress { until_us, id, at_us, .. } = *progress;
        let point = |row: &Row<'_>| {
            Ok(BatchPoint { slave: row.get(0)?, name: row.get(1)?, unit: row.get(2)?, kind: row.get(3)? })
        };
        let sql = "SELECT slave, name, unit, kind FROM point WHERE id = ?1";
        let point = transaction.prepare_cached(sql)?.query_row([id], point)?;
        let sql = "SELECT at_us, value, quality FROM point_sample WHERE point_id = ?1 AND at_us BETWEEN ?2 AND ?3 ORDER BY at_us LIMIT ?4";
        let sample = |row: &Row<'_>| {
            Ok(PointSample { at: Micros(row.get(0)?), number: row.get(1)?, quality: quality(row.get(2)?) })
        };
        let mut select = transaction.prepare_cached(sql)?;
        let read = select
            .query_map(params![id, at_us, until_us, room as i64], sample)?
            .collect::<rusqlite::Result<Vec<_>>>()?;
        let (mut last, is_code) = (HashMap::new(), point.kind == "code");
        let passed = read.iter().filter(|sample| passes_point(forward, &mut last, id, is_code, sample));
        let passed: Vec<_> = passed.copied().collect();
        if !passed.is_empty() {
            self.point_samples.push(PointSamples::new(point, &passed));
        }
        Ok((read.len(), read.last().map(|sample| sample.at.0)))
    }
}

/// Notes the spans of the present series or point as changed: those that the absence has touched.
fn note_spans(transaction: &Transaction<'_>, progress: &Progress, since: i64) -> rusqlite::Result<()> {
    let sql = match progress.kind {
        Kind::Series => {
            "INSERT OR IGNORE INTO outbox_span (level, series_id, start_us)
             SELECT level, series_id, start_us FROM span WHERE level = ?1 AND series_id = ?2 AND start_us > ?3 AND start_us <= ?4"
        }
        Kind::Point => {
            "INSERT OR IGNORE INTO outbox_point_span (level, point_id, start_us)
             SELECT level, point_id, start_us FROM point_span WHERE level = ?1 AND point_id = ?2 AND start_us > ?3 AND start_us <= ?4"
        }
    };
    let mut note = transaction.prepare_cached(sql)?;
    for level in LEVELS.into_iter().filter(|level| level.number >= FINEST_LEVEL) {
        let begun = since.saturating_sub(level.micros());
        note.execute(params![level.number, progress.id, begun, progress.until_us])?;
    }
    Ok(())
}
