//! Drawing and reading. A reader has a connection of its own and never holds up the one that writes.

use super::audit::{self, AuditQuery, AuditRow};
use super::database::{DatabaseError, Event, EventKind, open_to_read};
use super::sample::{Micros, Qualities, Quality, Sample};
use super::spans::{LEVELS, Level, Summary};
use rusqlite::{Connection, OptionalExtension, Row, params};
use std::path::{Path, PathBuf};

/// What one pixel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Where it begins.
    pub start: Micros,
    /// What happened in it.
    pub summary: Summary,
}

/// More samples than this are not read for a picture. free choice: a second of work.
const MAX_SAMPLES_PER_TREND: u32 = 1_000_000;

/// A picture that is being drawn, from left to right.
struct SpanCollector {
    from: Micros,
    /// How long a pixel is, in microseconds.
    width: i64,
    bins: Vec<Span>,
}

impl SpanCollector {
    fn take(&mut self, at: Micros, extent: &Summary) {
        // A span that begins before the picture is at its edge.
        let place = at.max(self.from).0.saturating_sub(self.from.0).div_euclid(self.width);
        let start = Micros(self.from.0.saturating_add(place.saturating_mul(self.width)));
        match self.bins.last_mut().filter(|last| last.start == start) {
            Some(last) => last.summary.add(extent),
            None => self.bins.push(Span { start, summary: *extent }),
        }
    }
}

/// An open file.
pub struct Reader {
    path: PathBuf,
    connection: Connection,
}

impl Reader {
    /// Opens the file of a recorder.
    ///
    /// # Errors
    /// [`StoreError`] when there is no such file.
    pub fn open(path: &Path) -> Result<Self, DatabaseError> {
        Ok(Self { path: path.to_owned(), connection: open_to_read(path)? })
    }

    /// Rows of the audit trail, the latest first.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn audit(&self, wanted: &AuditQuery) -> Result<Vec<AuditRow>, DatabaseError> {
        audit::select(&self.connection, wanted).map_err(|error| self.failed(error))
    }

    /// The names of all gauges that were ever recorded, in the order of their first sample.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn gauges(&self) -> Result<Vec<String>, DatabaseError> {
        self.query_all("SELECT name FROM gauge ORDER BY id", [], |row| row.get(0))
    }

    /// What a gauge showed in a time, in at most `pixels` bins (and one more at the edge). Bins in which nothing was
    /// recorded are left out.
    ///
    /// Where there are very many samples, or none any more, bins are as coarse as the finest spans that there are.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn trend(&self, gauge: &str, from: Micros, to: Micros, pixels: u32) -> Result<Vec<Span>, DatabaseError> {
        let Some(number) = self.series_id(gauge)? else { return Ok(Vec::new()) };
        let range = to.0.saturating_sub(from.0).max(1);
        let width = range.checked_div(i64::from(pixels.max(1))).unwrap_or(range).max(1);
        let mut bins = SpanCollector { from, width, bins: Vec::new() };
        let level = Level::coarsest_within(width);
        if level.is_none() && self.count(number, from, to, MAX_SAMPLES_PER_TREND)? < MAX_SAMPLES_PER_TREND {
            self.each_sample(number, from, to, i64::MAX, &mut |sample| bins.take(sample.at, &Summary::of(&sample)))?;
        }
        let levels = LEVELS.into_iter().filter(|coarse| level.is_none_or(|level| coarse.number >= level.number));
        for level in levels {
            if bins.bins.is_empty() {
                self.each_span(level, number, from, to, &mut |at, extent| bins.take(at, extent))?;
            }
        }
        Ok(bins.bins)
    }

    /// The samples of a gauge in a time, as they were kept.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn samples(&self, gauge: &str, from: Micros, to: Micros) -> Result<Vec<Sample>, DatabaseError> {
        self.page(gauge, from, to, u32::MAX)
    }

    /// The first `most` of them.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn page(&self, gauge: &str, from: Micros, to: Micros, most: u32) -> Result<Vec<Sample>, DatabaseError> {
        let mut samples = Vec::new();
        if let Some(number) = self.series_id(gauge)? {
            self.each_sample(number, from, to, i64::from(most), &mut |sample| samples.push(sample))?;
        }
        Ok(samples)
    }

    /// The first and the last moment of which anything is known of a gauge, samples and spans together.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn time_range(&self, gauge: &str) -> Result<Option<(Micros, Micros)>, DatabaseError> {
        let Some(number) = self.series_id(gauge)? else { return Ok(None) };
        let ends = |sql: &str, level: u8| {
            let row = self.connection.query_row(sql, params![number, level], |row| Ok((row.get(0)?, row.get(1)?)));
            row.map(|(first, last): (Option<i64>, Option<i64>)| first.zip(last)).map_err(|error| self.failed(error))
        };
        let samples = ends("SELECT min(at), max(at) FROM sample WHERE gauge = ?1 AND ?2 >= 0", 0)?;
        let Some(level) = LEVELS.last() else { return Ok(None) };
        let spans = ends("SELECT min(start), max(start) FROM rollup WHERE gauge = ?1 AND level = ?2", level.number)?;
        let known = match (samples, spans) {
            // A span begins before what is in it, so it says something new only if it ends before the first sample.
            (Some((first, last)), Some((start, _))) if start.saturating_add(level.micros()) > first => {
                Some((first, last))
            }
            (Some((_, last)), Some((start, _))) => Some((start, last)),
            (samples, spans) => samples.or(spans.map(|(start, last)| (start, last.saturating_add(level.micros())))),
        };
        Ok(known.map(|(first, last)| (Micros(first), Micros(last))))
    }

    /// When the first sample that is still there was taken.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn first_sample(&self, gauge: &str) -> Result<Option<Micros>, DatabaseError> {
        let Some(number) = self.series_id(gauge)? else { return Ok(None) };
        let sql = "SELECT min(at) FROM sample WHERE gauge = ?1";
        let first: Option<i64> =
            self.connection.query_row(sql, [number], |row| row.get(0)).map_err(|error| self.failed(error))?;
        Ok(first.map(Micros))
    }

    /// What happened in a time, the latest first, at most so much.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn events(&self, from: Micros, to: Micros, most: u32) -> Result<Vec<Event>, DatabaseError> {
        self.query_all(
            "SELECT at, name, kind, text FROM event LEFT JOIN gauge ON gauge.id = event.gauge
             WHERE at BETWEEN ?1 AND ?2 ORDER BY at DESC, event.id DESC LIMIT ?3",
            params![from.0, to.0, most],
            |row| {
                let kind: String = row.get(2)?;
                let kind = EventKind::from_word(&kind).unwrap_or(EventKind::Note);
                Ok(Event { at: Micros(row.get(0)?), gauge: row.get(1)?, kind, text: row.get(3)? })
            },
        )
    }

    fn series_id(&self, gauge: &str) -> Result<Option<i64>, DatabaseError> {
        let asked = self.connection.query_row("SELECT id FROM gauge WHERE name = ?1", [gauge], |row| row.get(0));
        asked.optional().map_err(|error| self.failed(error))
    }

    /// How many samples there are, counted up to `most`.
    fn count(&self, gauge: i64, from: Micros, to: Micros, most: u32) -> Result<u32, DatabaseError> {
        let sql = "SELECT count(*) FROM (SELECT 1 FROM sample WHERE gauge = ?1 AND at BETWEEN ?2 AND ?3 LIMIT ?4)";
        let asked = self.connection.query_row(sql, params![gauge, from.0, to.0, most], |row| row.get(0));
        asked.map_err(|error| self.failed(error))
    }

    fn each_sample(
        &self,
        gauge: i64,
        from: Micros,
        to: Micros,
        most: i64,
        take: &mut dyn FnMut(Sample),
    ) -> Result<(), DatabaseError> {
        let sql = "SELECT at, pa, quality FROM sample WHERE gauge = ?1 AND at BETWEEN ?2 AND ?3 ORDER BY at LIMIT ?4";
        self.query_each(sql, params![gauge, from.0, to.0, most], |row| {
            let quality = Quality::from_number(row.get(2)?).unwrap_or(Quality::Invalid);
            // Whoever else wrote into the file may have written what is no pressure.
            take(Sample::new(Micros(row.get(0)?), row.get(1)?, quality));
            Ok(())
        })
    }

    fn each_span(
        &self,
        level: Level,
        gauge: i64,
        from: Micros,
        to: Micros,
        take: &mut dyn FnMut(Micros, &Summary),
    ) -> Result<(), DatabaseError> {
        let sql = "SELECT start, low, high, decades, count, qualities FROM rollup
                   WHERE level = ?1 AND gauge = ?2 AND start > ?3 AND start <= ?4 ORDER BY start";
        self.query_each(sql, params![level.number, gauge, from.0.saturating_sub(level.micros()), to.0], |row| {
            let extent = Summary {
                low: row.get(1)?,
                high: row.get(2)?,
                decades: row.get(3)?,
                count: row.get(4)?,
                qualities: Qualities(row.get(5)?),
            };
            take(Micros(row.get(0)?), &extent);
            Ok(())
        })
    }

    pub(super) fn query_all<T>(
        &self,
        sql: &str,
        parameters: impl rusqlite::Params,
        map: impl Fn(&Row<'_>) -> rusqlite::Result<T>,
    ) -> Result<Vec<T>, DatabaseError> {
        let mut rows = Vec::new();
        self.query_each(sql, parameters, |row| {
            rows.push(map(row)?);
            Ok(())
        })?;
        Ok(rows)
    }

    fn query_each(
        &self,
        sql: &str,
        parameters: impl rusqlite::Params,
        mut take: impl FnMut(&Row<'_>) -> rusqlite::Result<()>,
    ) -> Result<(), DatabaseError> {
        let read = || {
            let mut statement = self.connection.prepare_cached(sql)?;
            let mut rows = statement.query(parameters)?;
            while let Some(row) = rows.next()? {
                take(row)?;
            }
            Ok(())
        };
        read().map_err(|error| self.failed(error))
    }

    fn failed(&self, error: rusqlite::Error) -> DatabaseError {
        DatabaseError::Sql { path: self.path.clone(), error }
    }
}
