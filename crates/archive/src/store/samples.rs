//! Samples go straight into the tables of their days, and are compared with what is there only where that is needed.
//!
//! The table of a day has a key until it is packed (`crate::packing`), and the key refuses a sample that is there. A packed day has none: a
//! transaction with samples of such a day keeps out all others of its kind, and leaves out what is there.

use super::day_number;
use super::rows::{PointSampleRow, Row, SampleRow, copy_from_stage, copy_to_stage, names};
use axum::body::Bytes;
use futures_util::{SinkExt, pin_mut};
use profivac_recorder::Micros;
use std::collections::BTreeSet;
use tokio_postgres::{Error, Transaction};

/// The lock of the keys of all days. Transactions that store samples share it, and the one that takes a key from a day has it alone.
pub const KEYS: i64 = 1_885_763_173;

/// The lock of the transactions with samples of packed days.
const LATE: i64 = 1_885_763_174;

/// The time from which PostgreSQL counts microseconds, 2000-01-01, in microseconds since 1970.
const POSTGRES_EPOCH: i64 = 946_684_800 * Micros::SECOND;

/// The octets that are sent to the server at once. chosen
const CHUNK: usize = 64 << 10;

/// The beginning of binary rows: the signature, no flags, no extension.
const HEADER: &[u8] = b"PGCOPY\n\xff\r\n\0\0\0\0\0\0\0\0\0";

/// The end of binary rows.
const TRAILER: [u8; 2] = (-1_i16).to_be_bytes();

/// How samples get into the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// They are copied into the tables of their days. One that is there ends the transaction.
    Straight,
    /// They are compared with what is there.
    Compared,
}

/// A row of a table of samples.
pub trait SampleOf: Row {
    /// The column that names the series or the point.
    const OF: &'static str;

    /// The number of the series or the point.
    fn of(&self) -> i32;

    /// The time of the sample.
    fn at(&self) -> Micros;

    /// The number and the quality of the sample.
    fn reading(&self) -> (Option<f64>, i16);
}

impl SampleOf for SampleRow {
    const OF: &'static str = "series";

    fn of(&self) -> i32 {
        self.series
    }

    fn at(&self) -> Micros {
        self.sample.at
    }

    fn reading(&self) -> (Option<f64>, i16) {
        (self.sample.pa, i16::from(self.sample.quality as u8))
    }
}

impl SampleOf for PointSampleRow {
    const OF: &'static str = "point";

    fn of(&self) -> i32 {
        self.point
    }

    fn at(&self) -> Micros {
        self.sample.at
    }

    fn reading(&self) -> (Option<f64>, i16) {
        (self.sample.number, i16::from(self.sample.quality as u8))
    }
}

/// Sorts samples by series or point and time, and leaves the first one of each.
pub fn sort<R: SampleOf>(rows: &mut Vec<R>) {
    let key = |row: &R| (row.of(), row.at());
    rows.sort_by_key(key);
    rows.dedup_by_key(|row| key(row));
}

/// The days of samples that are packed, with the names of the parents of their tables. No key of a day changes until the transaction ends.
pub async fn packed_days(transaction: &Transaction<'_>, days: &BTreeSet<i64>) -> Result<Vec<(String, i64)>, Error> {
    if days.is_empty() {
        return Ok(Vec::new());
    }
    transaction.execute("SELECT pg_advisory_xact_lock_shared($1)", &[&KEYS]).await?;
    let sql = "SELECT parent, day FROM unnest(ARRAY['sample', 'point_sample']) AS parent, unnest($1::integer[]) AS day
        WHERE NOT EXISTS (SELECT FROM pg_index WHERE indisunique
            AND indrelid = to_regclass('profivac_data.' || parent || '_' || to_char(date '1970-01-01' + day, 'YYYYMMDD')))";
    let numbers: Vec<_> = days.iter().map(|day| day_number(*day)).collect();
    let rows = transaction.query(sql, &[&numbers]).await?;
    if !rows.is_empty() {
        // Before any other lock: two such transactions do not wait for each other in a circle.
        transaction.execute("SELECT pg_advisory_xact_lock($1)", &[&LATE]).await?;
    }
    Ok(rows.iter().map(|row| (row.get(0), i64::from(row.get::<_, i32>(1)))).collect())
}

/// Stores samples, which are sorted. Returns how many are new.
pub async fn insert<R: SampleOf>(
    transaction: &Transaction<'_>,
    rows: &[R],
    way: Way,
    packed: &[(String, i64)],
) -> Result<u64, Error> {
    if rows.is_empty() {
        return Ok(0);
    }
    if way == Way::Straight {
        return copy(transaction, rows).await;
    }
    copy_to_stage(transaction, rows).await?;
    for (_, day) in packed.iter().filter(|(parent, _)| parent == R::TABLE) {
        leave_out_known(transaction, rows, *day).await?;
    }
    copy_from_stage::<R>(transaction).await
}

/// Deletes, of the samples of a packed day that are to be stored, those that are there.
async fn leave_out_known<R: SampleOf>(transaction: &Transaction<'_>, rows: &[R], day: i64) -> Result<(), Error> {
    let of_day = || rows.iter().filter(|row| super::day_of(row.at()) == day);
    let times = of_day().map(|row| row.at());
    let Some((first, last)) = times.clone().min().zip(times.max()) else { return Ok(()) };
    let series: BTreeSet<_> = of_day().map(SampleOf::of).collect();
    let (series, table, of) = (series.into_iter().collect::<Vec<_>>(), R::TABLE, R::OF);
    // Without statistics of the stage PostgreSQL might look through all known samples for each one.
    transaction.batch_execute("SET LOCAL enable_nestloop = off").await?;
    let sql = format!(
        "WITH known AS MATERIALIZED (SELECT {of}, at FROM profivac_data.{table} WHERE {of} = ANY ($1) AND at BETWEEN $2 AND $3)
        DELETE FROM stage_{table} AS staged USING known WHERE known.{of} = staged.{of} AND known.at = staged.at"
    );
    transaction.execute(&sql, &[&series, &first.to_system_time(), &last.to_system_time()]).await?;
    transaction.batch_execute("SET LOCAL enable_nestloop = on").await
}

/// Copies samples into the tables of their days.
async fn copy<R: SampleOf>(transaction: &Transaction<'_>, rows: &[R]) -> Result<u64, Error> {
    let sql = format!("COPY profivac_data.{} ({}) FROM STDIN BINARY", R::TABLE, names::<R>());
    let sink = transaction.copy_in::<_, Bytes>(&sql).await?;
    pin_mut!(sink);
    let mut octets = HEADER.to_vec();
    for row in rows {
        encode(row, &mut octets);
        if octets.len() >= CHUNK {
            let full = std::mem::replace(&mut octets, Vec::with_capacity(CHUNK + 64));
            sink.send(full.into()).await?;
        }
    }
    octets.extend(TRAILER);
    sink.send(octets.into()).await?;
    sink.finish().await
}

/// A row as PostgreSQL reads it in binary: the number of columns, and each value after its length.
fn encode<R: SampleOf>(row: &R, octets: &mut Vec<u8>) {
    let (number, quality) = row.reading();
    octets.extend(4_i16.to_be_bytes());
    octets.extend(4_i32.to_be_bytes());
    octets.extend(row.of().to_be_bytes());
    octets.extend(8_i32.to_be_bytes());
    octets.extend(row.at().0.saturating_sub(POSTGRES_EPOCH).to_be_bytes());
    match number {
        Some(number) => {
            octets.extend(8_i32.to_be_bytes());
            octets.extend(number.to_be_bytes());
        }
        None => octets.extend((-1_i32).to_be_bytes()),
    }
    octets.extend(2_i32.to_be_bytes());
    octets.extend(quality.to_be_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_recorder::{Quality, Sample};

    fn row(series: i32, seconds: i64, pa: Option<f64>) -> SampleRow {
        let quality = if pa.is_some() { Quality::Valid } else { Quality::Fault };
        SampleRow { series, sample: Sample::new(Micros(POSTGRES_EPOCH + seconds * Micros::SECOND), pa, quality) }
    }

    #[test]
    fn a_row_has_the_octets_of_postgresql() {
        let mut octets = Vec::new();
        encode(&row(0x0102, 1, Some(1.0)), &mut octets);
        let (time, one) = (1_000_000_i64.to_be_bytes(), 1.0_f64.to_be_bytes());
        let columns: [&[u8]; 9] =
            [&[0, 4], &[0, 0, 0, 4], &[0, 0, 1, 2], &[0, 0, 0, 8], &time, &[0, 0, 0, 8], &one, &[0, 0, 0, 2], &[0, 0]];
        assert_eq!(octets, columns.concat());
    }

    #[test]
    fn a_sample_without_a_pressure_is_null() {
        let mut octets = Vec::new();
        encode(&row(1, 0, None), &mut octets);
        let fault = (Quality::Fault as u8).to_be_bytes();
        assert_eq!(octets[22..], [&[255, 255, 255, 255, 0, 0, 0, 2, 0], fault.as_slice()].concat());
    }

    #[test]
    fn of_two_samples_of_one_time_the_first_is_left() {
        let mut rows = vec![row(2, 5, Some(1.0)), row(1, 9, Some(2.0)), row(2, 5, Some(3.0)), row(1, 4, Some(4.0))];
        sort(&mut rows);
        let left: Vec<_> = rows.iter().map(|row| (row.series, row.sample.pa)).collect();
        assert_eq!(left, [(1, Some(4.0)), (1, Some(2.0)), (2, Some(1.0))]);
    }
}
