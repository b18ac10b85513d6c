//! Samples as a Parquet file: a table that pandas, Polars, DuckDB and Spark read with its types.
//!
//! | Column | Type | Unit |
//! |---|---|---|
//! | `time` | timestamp, microseconds | UTC |
//! | `gauge` | string | |
//! | `pressure_pa` | double, null where the gauge gives no pressure | Pa |
//! | `quality` | string, the word of the [quality](crate::quality) | |
//!
//! A file of points has `slave`, `point`, `unit` (empty without one) and `value` in place of `gauge` and `pressure_pa`, and a last column
//! `text`: the text of a code, null without one.

use super::error::DatabaseError;
use super::export::{Chunk, Chunks, Exported};
use super::recorded::Recorded;
use parquet::basic::Compression;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use std::io::{self, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The columns.
fn schema<S: Exported>() -> String {
    let labels: String = S::LABELS.iter().map(|label| format!("required binary {label} (STRING);\n")).collect();
    let text = if S::HAS_TEXT { "optional binary text (STRING);" } else { "" };
    format!(
        "message samples {{
            required int64 time (TIMESTAMP(MICROS, true));
            {labels}
            optional double {value};
            required binary quality (STRING);
            {text}
        }}",
        value = S::Sample::VALUE
    )
}

/// Rows in a row group. chosen: about 8 MB while it is being written.
const ROWS_PER_GROUP: usize = 200_000;

/// The reason why a Parquet file was not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The database cannot be read.
    #[error(transparent)]
    Database(#[from] DatabaseError),
    /// The file cannot be written.
    #[error(transparent)]
    File(#[from] ParquetError),
}

/// Rows that are not written yet, column by column.
#[derive(Default)]
struct Rows {
    times: Vec<i64>,
    /// The columns that name the series.
    labels: Vec<Vec<ByteArray>>,
    /// The values that exist.
    values: Vec<f64>,
    /// For each row 1 if it has a value, otherwise 0.
    has_value: Vec<i16>,
    qualities: Vec<ByteArray>,
    /// The texts that exist.
    texts: Vec<ByteArray>,
    /// For each row 1 if it has a text, otherwise 0; empty if the file has no texts.
    has_text: Vec<i16>,
}

impl Rows {
    fn add<S: Exported>(&mut self, series: &S, samples: &[S::Sample]) {
        self.labels.resize_with(S::LABELS.len(), Vec::new);
        for (column, label) in self.labels.iter_mut().zip(series.labels()) {
            column.resize(column.len().saturating_add(samples.len()), ByteArray::from(label));
        }
        for sample in samples {
            self.times.push(sample.at().0);
            self.values.extend(sample.value());
            self.has_value.push(i16::from(sample.value().is_some()));
            self.qualities.push(ByteArray::from(sample.quality().word()));
            if S::HAS_TEXT {
                let text = sample.value().and_then(|value| series.text(value));
                self.texts.extend(text.map(ByteArray::from));
                self.has_text.push(i16::from(text.is_some()));
            }
        }
    }

    /// Writes the rows as a row group.
    fn write<W: Write + Send>(&self, file: &mut SerializedFileWriter<W>) -> Result<(), ParquetError> {
        let mut group = file.next_row_group()?;
        column::<Int64Type, W>(&mut group, &self.times, None)?;
        for labels in &self.labels {
            column::<ByteArrayType, W>(&mut group, labels, None)?;
        }
        column::<DoubleType, W>(&mut group, &self.values, Some(&self.has_value))?;
        column::<ByteArrayType, W>(&mut group, &self.qualities, None)?;
        if !self.has_text.is_empty() {
            column::<ByteArrayType, W>(&mut group, &self.texts, Some(&self.has_text))?;
        }
        group.close().map(drop)
    }
}

/// Writes the next column of a row group.
fn column<T: DataType, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    values: &[T::T],
    exists: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else { return Ok(()) };
    column.typed::<T>().write_batch(values, exists, None)?;
    column.close()
}

/// The octets of a file that is being written, until they are taken.
#[derive(Clone, Default)]
struct Octets(Arc<Mutex<Vec<u8>>>);

impl Octets {
    fn locked(&self) -> MutexGuard<'_, Vec<u8>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self) -> Vec<u8> {
        std::mem::take(&mut *self.locked())
    }
}

impl Write for Octets {
    fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
        self.locked().write(octets)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Samples as a Parquet file, part by part. The parts in their order are the file; without the last one it is no Parquet file.
pub struct ParquetExport<S: Exported = String> {
    chunks: Chunks<S>,
    /// `None` after the end.
    file: Option<SerializedFileWriter<Octets>>,
    octets: Octets,
    rows: Rows,
    count: u64,
}

impl<S: Exported> ParquetExport<S> {
    /// The samples of `chunks`.
    ///
    /// # Errors
    /// [`WriteError`] when the file cannot begin.
    pub fn new(chunks: Chunks<S>) -> Result<Self, WriteError> {
        let schema = Arc::new(parse_message_type(&schema::<S>())?);
        // Readers of every language decode Snappy, also small ones that know no GZIP.
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        let octets = Octets::default();
        let file = SerializedFileWriter::new(octets.clone(), schema, Arc::new(properties))?;
        Ok(Self { chunks, file: Some(file), octets, rows: Rows::default(), count: 0 })
    }

    /// The number of rows that were read so far.
    #[must_use]
    pub const fn rows_read(&self) -> u64 {
        self.count
    }

    /// Takes the next chunk, and writes a row group when there are enough rows. At the end of the chunks writes the end of the file.
    fn advance(&mut self, file: &mut SerializedFileWriter<Octets>) -> Result<bool, WriteError> {
        let Some(chunk) = self.chunks.next() else {
            if !self.rows.times.is_empty() {
                std::mem::take(&mut self.rows).write(file)?;
            }
            file.finish()?;
            return Ok(false);
        };
        let Chunk { series, samples } = chunk?;
        self.rows.add(&series, &samples);
        self.count = self.count.saturating_add(samples.len() as u64);
        if self.rows.times.len() >= ROWS_PER_GROUP {
            std::mem::take(&mut self.rows).write(file)?;
        }
        Ok(true)
    }
}

impl<S: Exported> Iterator for ParquetExport<S> {
    type Item = Result<Vec<u8>, WriteError>;

    /// The part that follows from the next chunk of samples, empty until a row group is complete. An error ends the export.
    fn next(&mut self) -> Option<Self::Item> {
        let mut file = self.file.take()?;
        match self.advance(&mut file) {
            Ok(continues) => {
                self.file = continues.then_some(file);
                Some(Ok(self.octets.take()))
            }
            Err(error) => Some(Err(error)),
        }
    }
}

/// Writes the samples as a Parquet file; returns the number of rows.
///
/// # Errors
/// [`WriteError`] when the database cannot be read or the file cannot be written; what was written so far is no Parquet file.
pub fn write<S: Exported>(chunks: Chunks<S>, mut to: impl Write) -> Result<u64, WriteError> {
    let mut export = ParquetExport::new(chunks)?;
    for part in export.by_ref() {
        to.write_all(&part?).map_err(ParquetError::from)?;
    }
    Ok(export.rows_read())
}
