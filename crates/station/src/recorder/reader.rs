//! Drawing and exporting. A reader has a connection of its own and never holds up the one that writes.

use super::rollup::{Extent, Level};
use super::sample::{Micros, Qualities, Quality, Sample};
use super::store::{Event, EventKind, StoreError, open_to_read};
use rusqlite::{Connection, OptionalExtension, Row, params};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What one pixel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Where it begins.
    pub start: Micros,
    /// What happened in it.
    pub extent: Extent,
}

/// An open file.
pub struct Reader {
    path: PathBuf,
    connection: Connection,
}

/// What cannot be written out.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The file.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Where it goes to.
    #[error("the export cannot be written: {0}")]
    Output(#[from] io::Error),
}

impl Reader {
    /// Opens the file of a recorder.
    ///
    /// # Errors
    /// [`StoreError`] when there is no such file.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        Ok(Self { path: path.to_owned(), connection: open_to_read(path)? })
    }

    /// The names of all gauges that were ever recorded, in the order of their first sample.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn gauges(&self) -> Result<Vec<String>, StoreError> {
        self.all("SELECT name FROM gauge ORDER BY id", [], |row| row.get(0))
    }

    /// What a gauge showed in a time, in at most `pixels` bins (and one more at the edge). Bins in which nothing was
    /// recorded are left out.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn draw(&self, gauge: &str, from: Micros, to: Micros, pixels: u32) -> Result<Vec<Bin>, StoreError> {
        let Some(number) = self.number(gauge)? else { return Ok(Vec::new()) };
        let range = to.0.saturating_sub(from.0).max(1);
        let width = range.checked_div(i64::from(pixels.max(1))).unwrap_or(range).max(1);
        let mut bins: Vec<Bin> = Vec::new();
        let mut take = |at: Micros, extent: &Extent| {
            let place = at.0.saturating_sub(from.0).div_euclid(width);
            let start = Micros(from.0.saturating_add(place.saturating_mul(width)));
            match bins.last_mut().filter(|last| last.start == start) {
                Some(last) => last.extent.add(extent),
                None => bins.push(Bin { start, extent: *extent }),
            }
        };
        match Level::for_span(width) {
            Some(level) => self.each_span(level, number, from, to, &mut take)?,
            None => self.each_sample(number, from, to, &mut |sample| take(sample.at, &Extent::of(&sample)))?,
        }
        Ok(bins)
    }

    /// The samples of a gauge in a time, as they were kept.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn samples(&self, gauge: &str, from: Micros, to: Micros) -> Result<Vec<Sample>, StoreError> {
        let mut samples = Vec::new();
        if let Some(number) = self.number(gauge)? {
            self.each_sample(number, from, to, &mut |sample| samples.push(sample))?;
        }
        Ok(samples)
    }

    /// What happened in a time, the latest first, at most so much.
    ///
    /// # Errors
    /// [`StoreError`] when the file cannot be read.
    pub fn events(&self, from: Micros, to: Micros, most: u32) -> Result<Vec<Event>, StoreError> {
        self.all(
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

    /// The samples of gauges in a time as CSV: time in ISO 8601 (UTC), gauge, pressure in Pa, quality. Says how many.
    ///
    /// # Errors
    /// [`ExportError`] when the file cannot be read or `out` not be written.
    pub fn export(&self, gauges: &[String], from: Micros, to: Micros, out: &mut dyn Write) -> Result<u64, ExportError> {
        writeln!(out, "time,gauge,pressure_pa,quality")?;
        let mut count = 0_u64;
        for gauge in gauges {
            for sample in self.samples(gauge, from, to)? {
                let pa = sample.pa.map(|pa| format!("{pa:e}")).unwrap_or_default();
                writeln!(out, "{},{},{pa},{}", iso(sample.at), quoted(gauge), sample.quality.word())?;
                count = count.saturating_add(1);
            }
        }
        Ok(count)
    }

    fn number(&self, gauge: &str) -> Result<Option<i64>, StoreError> {
        let asked = self.connection.query_row("SELECT id FROM gauge WHERE name = ?1", [gauge], |row| row.get(0));
        asked.optional().map_err(|error| self.failed(error))
    }

    fn each_sample(
        &self,
        gauge: i64,
        from: Micros,
        to: Micros,
        take: &mut dyn FnMut(Sample),
    ) -> Result<(), StoreError> {
        let sql = "SELECT at, pa, quality FROM sample WHERE gauge = ?1 AND at BETWEEN ?2 AND ?3 ORDER BY at";
        self.each(sql, params![gauge, from.0, to.0], |row| {
            let quality = Quality::from_number(row.get(2)?).unwrap_or(Quality::Invalid);
            take(Sample { at: Micros(row.get(0)?), pa: row.get(1)?, quality });
            Ok(())
        })
    }

    fn each_span(
        &self,
        level: Level,
        gauge: i64,
        from: Micros,
        to: Micros,
        take: &mut dyn FnMut(Micros, &Extent),
    ) -> Result<(), StoreError> {
        let sql = "SELECT start, low, high, decades, count, qualities FROM rollup
                   WHERE level = ?1 AND gauge = ?2 AND start BETWEEN ?3 AND ?4 ORDER BY start";
        self.each(sql, params![level.number, gauge, from.0, to.0], |row| {
            let extent = Extent {
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

    fn all<T>(
        &self,
        sql: &str,
        parameters: impl rusqlite::Params,
        map: impl Fn(&Row<'_>) -> rusqlite::Result<T>,
    ) -> Result<Vec<T>, StoreError> {
        let mut rows = Vec::new();
        self.each(sql, parameters, |row| {
            rows.push(map(row)?);
            Ok(())
        })?;
        Ok(rows)
    }

    fn each(
        &self,
        sql: &str,
        parameters: impl rusqlite::Params,
        mut take: impl FnMut(&Row<'_>) -> rusqlite::Result<()>,
    ) -> Result<(), StoreError> {
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

    fn failed(&self, error: rusqlite::Error) -> StoreError {
        StoreError::Sql { path: self.path.clone(), error }
    }
}

/// A name in CSV, RFC 4180.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() }
}

/// A moment as ISO 8601 has it, in UTC with microseconds.
fn iso(at: Micros) -> String {
    humantime::format_rfc3339_micros(at.to_system_time()).to_string()
}
