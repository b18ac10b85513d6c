//! Reads samples, trends and events. A reader has a separate connection and never blocks the recorder.

use super::audit::{self, AuditQuery};
use super::connection::open_to_read;
use super::error::DatabaseError;
use super::point::{Point, PointKind, PointSample, PointSummary};
use super::quality::Quality;
use super::recorded::{Recorded, Summarise};
use super::retention::{Expired, Period};
use super::sample::{Micros, Sample};
use super::spans::{LEVELS, Level, Summary};
use profivac_model::{AuditEntry, Event, Word};
use rusqlite::{Connection, OptionalExtension, Row, params};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The most samples that are read for one trend. chosen: a second of work.
const MAX_SAMPLES_PER_TREND: u32 = 1_000_000;

/// The most rows that a list sorts. chosen: some ten milliseconds of work.
const MAX_SORTED: u32 = 20_000;

/// All recording periods, in the order of recording.
///
/// # Errors
/// Any error of SQLite.
pub fn recording_periods(connection: &Connection) -> rusqlite::Result<Vec<Period>> {
    let mut select = connection.prepare_cached("SELECT start_us, end_us FROM recording_period ORDER BY id")?;
    let period = |row: &Row<'_>| Ok(Period { start: Micros(row.get(0)?), end: Micros(row.get(1)?) });
    select.query_map([], period)?.collect()
}

/// A part of a trend, one pixel wide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span<S = Summary> {
    /// Where it starts.
    pub start: Micros,
    /// The summary of its samples.
    pub summary: S,
}

/// Merges summaries into the pixels of a trend, from left to right.
struct SpanCollector<S> {
    from: Micros,
    /// The width of a pixel, in microseconds.
    width: i64,
    spans: Vec<Span<S>>,
}

impl<S: Summarise> SpanCollector<S> {
    fn add(&mut self, at: Micros, summary: &S) {
        // A stored span that starts before the trend belongs to its first pixel.
        let pixel = at.max(self.from).0.saturating_sub(self.from.0).div_euclid(self.width);
        let start = Micros(self.from.0.saturating_add(pixel.saturating_mul(self.width)));
        match self.spans.last_mut().filter(|last| last.start == start) {
            Some(last) => last.summary.add(summary),
            None => self.spans.push(Span { start, summary: *summary }),
        }
    }
}

/// Valid samples with the same pressure, without another sample between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occurrence {
    /// The pressure in Pa.
    pub pa: f64,
    /// The time of the first one.
    pub first: Micros,
    /// The time of the last one.
    pub last: Micros,
}

/// Where valid samples of a series have one of certain pressures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Occurrences {
    /// The number of these samples.
    pub samples: u64,
    /// The samples that follow one another, the earliest first.
    pub periods: Vec<Occurrence>,
    /// The number of periods that are not in `periods`.
    pub more: u64,
    /// The starts of the first and of the last span of six hours with a deleted sample of such a pressure, as far as the highest pressures
    /// of the spans show it.
    pub spans: Option<(Micros, Micros)>,
}

/// A database opened for reading.
pub struct Reader {
    path: PathBuf,
    connection: Connection,
}

impl Reader {
    /// Opens the database of a recorder.
    ///
    /// # Errors
    /// [`DatabaseError`] when the file is missing, is no database, or was written by a newer program.
    pub fn open(path: &Path) -> Result<Self, DatabaseError> {
        Ok(Self { path: path.to_owned(), connection: open_to_read(path)? })
    }

    /// The damage of the file in the words of SQLite; empty if there is none. The whole file is read.
    ///
    /// # Errors
    /// [`DatabaseError`] when the file cannot be read.
    pub fn damage(&self) -> Result<Vec<String>, DatabaseError> {
        let rows = || {
            let mut statement = self.connection.prepare("PRAGMA quick_check(10)")?;
            let rows = statement.query_map([], |row| row.get::<_, String>(0))?;
            rows.collect::<rusqlite::Result<Vec<_>>>()
        };
        let mut rows = rows().map_err(|error| self.failed(error))?;
        rows.retain(|row| row != "ok");
        Ok(rows)
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The connection, for modules that read other tables.
    pub(super) const fn connection(&self) -> &Connection {
        &self.connection
    }

    /// The selected rows of the audit trail, the latest first.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn audit(&self, query: &AuditQuery) -> Result<Vec<AuditEntry>, DatabaseError> {
        audit::select(&self.connection, query).map_err(|error| self.failed(error))
    }

    /// The names of all series that were ever recorded, in the order of their first sample.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn series_names(&self) -> Result<Vec<String>, DatabaseError> {
        self.query_all("SELECT name FROM series ORDER BY id", [], |row| row.get(0))
    }

    /// The trend of a series from `from` to `to`, in at most `pixels` spans and one more at the edge. Pixels without samples are
    /// left out.
    ///
    /// Where there are too many samples, or where the samples were deleted, the trend consists of the finest stored spans.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn trend(&self, series: &str, from: Micros, to: Micros, pixels: u32) -> Result<Vec<Span>, DatabaseError> {
        let Some(id) = self.series_id(series)? else { return Ok(Vec::new()) };
        self.trend_of::<Sample>(id, from, to, pixels)
    }

    /// The points whose values were ever recorded, in the order of their first value.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn points(&self) -> Result<Vec<Point>, DatabaseError> {
        self.query_all("SELECT slave, name, unit, kind FROM point ORDER BY id", [], point)
    }

    /// The point `name` of a slave, in the unit in which it was recorded last, or in `unit`. `None` if no value was recorded.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn point(&self, slave: &str, name: &str, unit: Option<&str>) -> Result<Option<Point>, DatabaseError> {
        let sql = "SELECT slave, name, unit, kind FROM point
                   WHERE slave = ?1 AND name = ?2 AND (?3 IS NULL OR unit = ?3)
                   ORDER BY (SELECT max(at_us) FROM point_sample WHERE point_id = point.id) DESC, id DESC LIMIT 1";
        let found = self.connection.query_row(sql, params![slave, name, unit], point);
        found.optional().map_err(|error| self.failed(error))
    }

    /// The trend of a point, as [`trend`](Self::trend) for a gauge.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn point_trend(
        &self,
        point: &Point,
        from: Micros,
        to: Micros,
        pixels: u32,
    ) -> Result<Vec<Span<PointSummary>>, DatabaseError> {
        let Some(id) = self.point_id(point)? else { return Ok(Vec::new()) };
        self.trend_of::<PointSample>(id, from, to, pixels)
    }

    /// The first `limit` kept values of a point from `from` to `to`.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn point_page(
        &self,
        point: &Point,
        from: Micros,
        to: Micros,
        limit: u32,
    ) -> Result<Vec<PointSample>, DatabaseError> {
        let mut samples = Vec::new();
        if let Some(id) = self.point_id(point)? {
            self.each_sample(id, from, to, i64::from(limit), &mut |sample| samples.push(sample))?;
        }
        Ok(samples)
    }

    /// The first and the last time of which values or spans of a point are stored.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn point_time_range(&self, point: &Point) -> Result<Option<(Micros, Micros)>, DatabaseError> {
        let Some(id) = self.point_id(point)? else { return Ok(None) };
        self.time_range_of::<PointSample>(id)
    }

    fn trend_of<T: Recorded>(
        &self,
        id: i64,
        from: Micros,
        to: Micros,
        pixels: u32,
    ) -> Result<Vec<Span<T::Summary>>, DatabaseError> {
        let range = to.0.saturating_sub(from.0).max(1);
        let width = range.checked_div(i64::from(pixels.max(1))).unwrap_or(range).max(1);
        let mut collector = SpanCollector { from, width, spans: Vec::new() };
        let level = Level::coarsest_within(width);
        if level.is_none() && self.count::<T>(id, from, to, MAX_SAMPLES_PER_TREND)? < MAX_SAMPLES_PER_TREND {
            self.each_sample(id, from, to, i64::MAX, &mut |sample: T| collector.add(sample.at(), &sample.summary()))?;
        }
        let levels = LEVELS.into_iter().filter(|coarse| level.is_none_or(|level| coarse.number >= level.number));
        for level in levels {
            if collector.spans.is_empty() {
                self.each_span::<T>(level, id, from, to, &mut |at, summary| collector.add(at, summary))?;
            }
        }
        Ok(collector.spans)
    }

    /// The kept samples of a series from `from` to `to`.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn samples(&self, series: &str, from: Micros, to: Micros) -> Result<Vec<Sample>, DatabaseError> {
        self.page(series, from, to, u32::MAX)
    }

    /// The first `limit` kept samples of a series from `from` to `to`.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn page(&self, series: &str, from: Micros, to: Micros, limit: u32) -> Result<Vec<Sample>, DatabaseError> {
        let mut samples = Vec::new();
        if let Some(id) = self.series_id(series)? {
            self.each_sample(id, from, to, i64::from(limit), &mut |sample| samples.push(sample))?;
        }
        Ok(samples)
    }

    /// The valid samples of a series that have exactly one of these pressures in Pa, in at most `limit` periods. All samples are read, one
    /// at a time.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn occurrences(&self, series: &str, pressures_pa: &[f64], limit: usize) -> Result<Occurrences, DatabaseError> {
        let Some(id) = self.series_id(series)? else { return Ok(Occurrences::default()) };
        let wanted = |pa: Option<f64>| pa.filter(|pa| pressures_pa.contains(pa));
        let (mut found, mut before, mut first, mut first_found) = (Occurrences::default(), None, None, None);
        self.each_sample(id, Micros(i64::MIN), Micros(i64::MAX), i64::MAX, &mut |sample: Sample| {
            first = first.or(Some(sample.at));
            let now = wanted(sample.pa).filter(|_| sample.quality == Quality::Valid);
            let continues = before == now;
            before = now;
            let Some(pa) = now else { return };
            first_found = first_found.or(Some(sample.at));
            found.samples = found.samples.saturating_add(1);
            if continues {
                // The period of the sample before may be one of those that are only counted.
                found.periods.last_mut().filter(|_| found.more == 0).into_iter().for_each(|last| last.last = sample.at);
            } else if found.periods.len() < limit {
                found.periods.push(Occurrence { pa, first: sample.at, last: sample.at });
            } else {
                found.more = found.more.saturating_add(1);
            }
        })?;
        let first = first.unwrap_or(Micros(i64::MAX));
        found.spans = self.deleted_occurrences(id, first, first_found.unwrap_or(Micros(i64::MAX)), &wanted)?;
        Ok(found)
    }

    /// The starts of the first and of the last span of six hours with a deleted sample that is `wanted`. `first` is the first sample that
    /// is left, `first_found` the first of these that is `wanted`.
    fn deleted_occurrences(
        &self,
        series: i64,
        first: Micros,
        first_found: Micros,
        wanted: &dyn Fn(Option<f64>) -> Option<f64>,
    ) -> Result<Option<(Micros, Micros)>, DatabaseError> {
        let Some(longest) = LEVELS.last() else { return Ok(None) };
        let mut found: Option<(Micros, Micros)> = None;
        for level in LEVELS {
            // Shorter spans only tell which part of the six hours around `first` is deleted.
            let from = if level.number == longest.number { Micros(i64::MIN) } else { longest.start(first) };
            let until = Micros(first.0.saturating_sub(1));
            self.each_span::<Sample>(level, series, from, until, &mut |start, summary| {
                // A sample that is left may explain the highest pressure. The end of a range is stored like a pressure.
                let is_explained = first_found.0 < start.0.saturating_add(level.micros());
                if wanted(summary.high).is_some() && !is_explained && !summary.qualities.contains(Quality::Overrange) {
                    let six_hours = longest.start(start);
                    found = Some(
                        found.map_or((six_hours, six_hours), |(one, two)| (one.min(six_hours), two.max(six_hours))),
                    );
                }
            })?;
        }
        Ok(found)
    }

    /// The first and the last time of which samples or spans of a series are stored.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn time_range(&self, series: &str) -> Result<Option<(Micros, Micros)>, DatabaseError> {
        let Some(id) = self.series_id(series)? else { return Ok(None) };
        self.time_range_of::<Sample>(id)
    }

    fn time_range_of<T: Recorded>(&self, id: i64) -> Result<Option<(Micros, Micros)>, DatabaseError> {
        let ends = |sql: &str, level: u8| {
            let row = self.connection.query_row(sql, params![id, level], |row| Ok((row.get(0)?, row.get(1)?)));
            row.map(|(first, last): (Option<i64>, Option<i64>)| first.zip(last)).map_err(|error| self.failed(error))
        };
        let (samples, spans, series) = (T::SAMPLES, T::SPANS, T::SERIES);
        let of_samples = format!("SELECT min(at_us), max(at_us) FROM {samples} WHERE {series} = ?1 AND ?2 >= 0");
        let samples = ends(&of_samples, 0)?;
        let Some(level) = LEVELS.last() else { return Ok(None) };
        let of_spans = format!("SELECT min(start_us), max(start_us) FROM {spans} WHERE {series} = ?1 AND level = ?2");
        let spans = ends(&of_spans, level.number)?;
        let known = match (samples, spans) {
            // A span starts before its first sample, so it extends the range only if it ends before the first sample.
            (Some((first, last)), Some((start, _))) if start.saturating_add(level.micros()) > first => {
                Some((first, last))
            }
            (Some((_, last)), Some((start, _))) => Some((start, last)),
            (samples, spans) => samples.or(spans.map(|(start, last)| (start, last.saturating_add(level.micros())))),
        };
        Ok(known.map(|(first, last)| (Micros(first), Micros(last))))
    }

    /// The time of the first stored sample of a series.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn first_sample(&self, series: &str) -> Result<Option<Micros>, DatabaseError> {
        let Some(id) = self.series_id(series)? else { return Ok(None) };
        let sql = "SELECT min(at_us) FROM sample WHERE series_id = ?1";
        let first: Option<i64> =
            self.connection.query_row(sql, [id], |row| row.get(0)).map_err(|error| self.failed(error))?;
        Ok(first.map(Micros))
    }

    /// The events from `from` to `to` that were recorded last, at most `limit`, the last first. The order is that of recording: an event
    /// with a future time, from a clock that was ahead, does not stay before all later ones.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn events(&self, from: Micros, to: Micros, limit: u32) -> Result<Vec<Event>, DatabaseError> {
        let at = self.time_column("event", from, to)?;
        self.query_all(
            &format!(
                "SELECT at_us, name, kind, text FROM event LEFT JOIN series ON series.id = event.series_id
                 WHERE {at} BETWEEN ?1 AND ?2 ORDER BY event.id DESC LIMIT ?3"
            ),
            params![from.0, to.0, limit],
            |row| {
                let kind = Word::read(row.get(2)?);
                Ok(Event { at: Micros(row.get(0)?), gauge: row.get(1)?, kind, text: row.get(3)? })
            },
        )
    }

    /// The column by which a list in the order of recording selects its time range. SQLite finds the few rows of a short range by the
    /// index on times and sorts them; a long range is faster to read from its end, without that index.
    pub(super) fn time_column(
        &self,
        table: &'static str,
        from: Micros,
        to: Micros,
    ) -> Result<&'static str, DatabaseError> {
        let sql = format!("SELECT count(*) FROM (SELECT 1 FROM {table} WHERE at_us BETWEEN ?1 AND ?2 LIMIT ?3)");
        let counted = self.connection.query_row(&sql, params![from.0, to.0, MAX_SORTED], |row| row.get::<_, u32>(0));
        let rows = counted.map_err(|error| self.failed(error))?;
        // A sign keeps SQLite from using the index.
        Ok(if rows < MAX_SORTED { "at_us" } else { "+at_us" })
    }

    /// How much of the time from `from` to `to` the station recorded, at `now`.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn recorded_time(&self, from: Micros, to: Micros, now: Micros) -> Result<Duration, DatabaseError> {
        let periods = self.recording_periods_until(now)?;
        let overlap = |period: &Period| {
            let length = period.end.0.min(to.0).saturating_sub(period.start.0.max(from.0));
            Duration::from_micros(u64::try_from(length).unwrap_or(0))
        };
        Ok(periods.iter().map(overlap).fold(Duration::ZERO, Duration::saturating_add))
    }

    /// The times that are older than `kept` in recorded time, at `now`.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn expired(&self, kept: Duration, now: Micros) -> Result<Expired, DatabaseError> {
        Ok(Expired::of(&self.recording_periods_until(now)?, kept))
    }

    /// The periods in which the station recorded, the last one up to `now` if it goes on.
    fn recording_periods_until(&self, now: Micros) -> Result<Vec<Period>, DatabaseError> {
        let mut periods = recording_periods(&self.connection).map_err(|error| self.failed(error))?;
        // The recorder extends the last period once a minute.
        if let Some(last) = periods.last_mut().filter(|last| last.continues_at(now)) {
            *last = last.until(now);
        }
        Ok(periods)
    }

    fn series_id(&self, series: &str) -> Result<Option<i64>, DatabaseError> {
        let sql = "SELECT id FROM series WHERE name = ?1";
        let found = self.connection.query_row(sql, [series], |row| row.get(0));
        found.optional().map_err(|error| self.failed(error))
    }

    fn point_id(&self, point: &Point) -> Result<Option<i64>, DatabaseError> {
        let Point { slave, name, unit, kind } = point;
        let row = params![slave, name, unit.as_deref().unwrap_or_default(), kind.word()];
        let sql = "SELECT id FROM point WHERE slave = ?1 AND name = ?2 AND unit = ?3 AND kind = ?4";
        self.connection.query_row(sql, row, |row| row.get(0)).optional().map_err(|error| self.failed(error))
    }

    /// The number of samples, counted up to `limit`.
    fn count<T: Recorded>(&self, series: i64, from: Micros, to: Micros, limit: u32) -> Result<u32, DatabaseError> {
        let (table, of_series) = (T::SAMPLES, T::SERIES);
        let sql = format!(
            "SELECT count(*) FROM
                 (SELECT 1 FROM {table} WHERE {of_series} = ?1 AND at_us BETWEEN ?2 AND ?3 LIMIT ?4)"
        );
        let counted = self.connection.query_row(&sql, params![series, from.0, to.0, limit], |row| row.get(0));
        counted.map_err(|error| self.failed(error))
    }

    fn each_sample<T: Recorded>(
        &self,
        series: i64,
        from: Micros,
        to: Micros,
        limit: i64,
        take: &mut dyn FnMut(T),
    ) -> Result<(), DatabaseError> {
        let (table, of_series, value) = (T::SAMPLES, T::SERIES, T::VALUE);
        let sql = format!(
            "SELECT at_us, {value}, quality FROM {table}
             WHERE {of_series} = ?1 AND at_us BETWEEN ?2 AND ?3 ORDER BY at_us LIMIT ?4"
        );
        self.query_each(&sql, params![series, from.0, to.0, limit], |row| {
            let quality = Quality::from_number(row.get(2)?).unwrap_or(Quality::Fault);
            // Another program may have written a number that is no value: `of` checks it.
            take(T::of(Micros(row.get(0)?), row.get(1)?, quality));
            Ok(())
        })
    }

    fn each_span<T: Recorded>(
        &self,
        level: Level,
        series: i64,
        from: Micros,
        to: Micros,
        take: &mut dyn FnMut(Micros, &T::Summary),
    ) -> Result<(), DatabaseError> {
        let (table, of_series, columns) = (T::SPANS, T::SERIES, T::Summary::COLUMNS);
        let sql = format!(
            "SELECT start_us, {columns} FROM {table}
             WHERE level = ?1 AND {of_series} = ?2 AND start_us > ?3 AND start_us <= ?4 ORDER BY start_us"
        );
        self.query_each(&sql, params![level.number, series, from.0.saturating_sub(level.micros()), to.0], |row| {
            take(Micros(row.get(0)?), &T::Summary::read(row, 1)?);
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

    pub(super) fn query_each(
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

    pub(super) fn failed(&self, error: rusqlite::Error) -> DatabaseError {
        DatabaseError::Sql { path: self.path.clone(), error }
    }
}

/// The point of a row with slave, name, unit and kind. A kind of a later program has no mean, as a code.
fn point(row: &Row<'_>) -> rusqlite::Result<Point> {
    let (unit, kind): (String, String) = (row.get(2)?, row.get(3)?);
    Ok(Point {
        slave: row.get(0)?,
        name: row.get(1)?,
        unit: Some(unit).filter(|unit| !unit.is_empty()),
        kind: PointKind::from_word(&kind).unwrap_or(PointKind::Code),
    })
}
