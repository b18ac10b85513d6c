//! Samples as a Parquet file: a table that pandas, Polars, DuckDB and Spark read with its types.
//!
//! | Column | Type | Unit |
//! |---|---|---|
//! | `time` | timestamp, microseconds | UTC |
//! | `gauge` | string | |
//! | `pressure_pa` | double, null where the gauge gives no pressure | Pa |
//! | `quality` | string, the word of the [quality](crate::quality) | |

use super::error::DatabaseError;
use super::export::{Chunk, Chunks};
use super::sample::Sample;
use parquet::basic::{Compression, GzipLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use std::io::Write;
use std::sync::Arc;

/// The columns.
const SCHEMA: &str = "message samples {
    required int64 time (TIMESTAMP(MICROS, true));
    required binary gauge (STRING);
    optional double pressure_pa;
    required binary quality (STRING);
}";

/// Rows in a row group. free choice: about 8 MB while it is being written.
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
    gauges: Vec<ByteArray>,
    /// The pressures that exist, in Pa.
    pressures: Vec<f64>,
    /// For each row 1 if it has a pressure, otherwise 0.
    has_pressure: Vec<i16>,
    qualities: Vec<ByteArray>,
}

impl Rows {
    fn add(&mut self, gauge: &ByteArray, sample: &Sample) {
        self.times.push(sample.at.0);
        self.gauges.push(gauge.clone());
        self.pressures.extend(sample.pa);
        self.has_pressure.push(i16::from(sample.pa.is_some()));
        self.qualities.push(ByteArray::from(sample.quality.word()));
    }

    /// Writes the rows as a row group.
    fn write<W: Write + Send>(&self, file: &mut SerializedFileWriter<W>) -> Result<(), ParquetError> {
        let mut group = file.next_row_group()?;
        column::<Int64Type, W>(&mut group, &self.times, None)?;
        column::<ByteArrayType, W>(&mut group, &self.gauges, None)?;
        column::<DoubleType, W>(&mut group, &self.pressures, Some(&self.has_pressure))?;
        column::<ByteArrayType, W>(&mut group, &self.qualities, None)?;
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

/// Writes the samples as a Parquet file; returns the number of rows.
///
/// # Errors
/// [`WriteError`] when the database cannot be read or the file cannot be written; what was written so far is no Parquet file.
pub fn write(chunks: Chunks, to: impl Write + Send) -> Result<u64, WriteError> {
    let schema = Arc::new(parse_message_type(SCHEMA)?);
    let properties = WriterProperties::builder().set_compression(Compression::GZIP(GzipLevel::default())).build();
    let mut file = SerializedFileWriter::new(to, schema, Arc::new(properties))?;
    let mut rows = Rows::default();
    let mut count: u64 = 0;
    for chunk in chunks {
        let Chunk { series, samples } = chunk?;
        let gauge = ByteArray::from(series.as_str());
        samples.iter().for_each(|sample| rows.add(&gauge, sample));
        count = count.saturating_add(samples.len() as u64);
        if rows.times.len() >= ROWS_PER_GROUP {
            std::mem::take(&mut rows).write(&mut file)?;
        }
    }
    if !rows.times.is_empty() {
        rows.write(&mut file)?;
    }
    file.close()?;
    Ok(count)
}
