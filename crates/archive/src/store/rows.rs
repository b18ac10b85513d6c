//! The rows of the tables, and how many of them are inserted at once.
//!
//! Rows are copied into a temporary table and inserted from there, those that are new: three statements for any number of rows. Samples
//! usually take a shorter way, see `samples`.

use super::accept::text;
use futures_util::pin_mut;
use profivac_recorder::batch::{AlarmChange, Audit, Event, PointSpan, Span};
use profivac_recorder::{Micros, PointSample, Sample};
use std::pin::Pin;
use std::time::SystemTime;
use tokio_postgres::binary_copy::BinaryCopyInWriter;
use tokio_postgres::types::{ToSql, Type};
use tokio_postgres::{Client, Error, Transaction};

/// A row of a table.
pub trait Row {
    /// The table.
    const TABLE: &'static str;
    /// The columns with their types.
    const COLUMNS: &'static [(&'static str, Type)];
    /// The action of PostgreSQL for a row whose key is there.
    const ON_CONFLICT: &'static str = "DO NOTHING";

    /// Writes the values, in the order of the columns.
    async fn write(&self, copy: CopyIn<'_>) -> Result<(), Error>;
}

/// Takes the values of rows.
pub type CopyIn<'a> = Pin<&'a mut BinaryCopyInWriter>;

type Values<'a> = [&'a (dyn ToSql + Sync)];

/// Makes the temporary table of a kind of row.
pub async fn prepare<R: Row>(client: &Client) -> Result<(), Error> {
    let (table, columns) = (R::TABLE, names::<R>());
    let sql = format!(
        "CREATE TEMPORARY TABLE stage_{table} ON COMMIT DELETE ROWS AS SELECT {columns} FROM profivac_data.{table} WITH NO DATA"
    );
    client.batch_execute(&sql).await
}

/// Inserts rows. In the order of `rows`: two archives that insert the same rows in the same order do not wait for each other in a
/// circle. Returns how many rows were stored: those that are new, and spans that have changed.
pub async fn insert<R: Row>(transaction: &Transaction<'_>, rows: &[R]) -> Result<u64, Error> {
    if rows.is_empty() {
        return Ok(0);
    }
    copy_to_stage(transaction, rows).await?;
    copy_from_stage::<R>(transaction).await
}

/// Copies rows into their temporary table.
pub async fn copy_to_stage<R: Row>(transaction: &Transaction<'_>, rows: &[R]) -> Result<(), Error> {
    let types: Vec<_> = R::COLUMNS.iter().map(|(_, of_column)| of_column.clone()).collect();
    let sink = transaction.copy_in(&format!("COPY stage_{} FROM STDIN BINARY", R::TABLE)).await?;
    let copy = BinaryCopyInWriter::new(sink, &types);
    pin_mut!(copy);
    for row in rows {
        row.write(copy.as_mut()).await?;
    }
    copy.finish().await?;
    Ok(())
}

/// Inserts the rows of a temporary table. Returns how many rows were stored.
pub async fn copy_from_stage<R: Row>(transaction: &Transaction<'_>) -> Result<u64, Error> {
    let (table, columns, on_conflict) = (R::TABLE, names::<R>(), R::ON_CONFLICT);
    let sql = format!(
        "INSERT INTO profivac_data.{table} ({columns}) SELECT {columns} FROM stage_{table} ON CONFLICT {on_conflict}"
    );
    transaction.execute(&sql, &[]).await
}

/// The columns of a table.
pub fn names<R: Row>() -> String {
    R::COLUMNS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

/// A sample of a series.
pub struct SampleRow {
    pub series: i32,
    pub sample: Sample,
}

impl Row for SampleRow {
    const TABLE: &'static str = "sample";
    const COLUMNS: &'static [(&'static str, Type)] =
        &[("series", Type::INT4), ("at", Type::TIMESTAMPTZ), ("pressure_pa", Type::FLOAT8), ("quality", Type::INT2)];

    async fn write(&self, copy: CopyIn<'_>) -> Result<(), Error> {
        let Sample { at, pa, quality } = &self.sample;
        copy.write(&[&self.series, &at.to_system_time(), pa, &i16::from(*quality as u8)]).await
    }
}

/// A span of a series, of a batch of a database.
pub struct SpanRow {
    pub series: i32,
    pub epoch: i64,
    pub batch: i64,
    pub span: Span,
}

impl Row for SpanRow {
    const TABLE: &'static str = "span";
    const COLUMNS: &'static [(&'static str, Type)] = &[
        ("series", Type::INT4),
        ("level", Type::INT2),
        ("start", Type::TIMESTAMPTZ),
        ("epoch", Type::INT8),
        ("batch", Type::INT8),
        ("min_pa", Type::FLOAT8),
        ("max_pa", Type::FLOAT8),
        ("log10_sum", Type::FLOAT8),
        ("count", Type::INT8),
        ("qualities", Type::INT2),
    ];
    const ON_CONFLICT: &'static str =
        "(series, level, start, epoch) DO UPDATE SET batch = excluded.batch, min_pa = excluded.min_pa,
        max_pa = excluded.max_pa, log10_sum = excluded.log10_sum, count = excluded.count, qualities = excluded.qualities
        WHERE span.batch < excluded.batch";

    async fn write(&self, copy: CopyIn<'_>) -> Result<(), Error> {
        let Self { series, epoch, batch, span } = self;
        // `accept` refuses another one.
        let level = i16::try_from(span.level).unwrap_or(i16::MAX);
        let qualities = i16::try_from(span.qualities).unwrap_or(i16::MAX);
        let (start, count) = (time(span.start_us), i64::from(span.count));
        let Span { min_pa, max_pa, log10_sum, .. } = span;
        let values: &Values<'_> =
            &[series, &level, &start, epoch, batch, min_pa, max_pa, log10_sum, &count, &qualities];
        copy.write(values).await
    }
}

/// A value of a point.
pub struct PointSampleRow {
    pub point: i32,
    pub sample: PointSample,
}

impl Row for PointSampleRow {
    const TABLE: &'static str = "point_sample";
    const COLUMNS: &'static [(&'static str, Type)] =
        &[("point", Type::INT4), ("at", Type::TIMESTAMPTZ), ("value", Type::FLOAT8), ("quality", Type::INT2)];

    async fn write(&self, copy: CopyIn<'_>) -> Result<(), Error> {
        let PointSample { at, number, quality } = &self.sample;
        copy.write(&[&self.point, &at.to_system_time(), number, &i16::from(*quality as u8)]).await
    }
}

/// A span of a point, of a batch of a database.
pub struct PointSpanRow {
    pub point: i32,
    pub epoch: i64,
    pub batch: i64,
    pub span: PointSpan,
}

impl Row for PointSpanRow {
    const TABLE: &'static str = "point_span";
    const COLUMNS: &'static [(&'static str, Type)] = &[
        ("point", Type::INT4),
        ("level", Type::INT2),
        ("start", Type::TIMESTAMPTZ),
        ("epoch", Type::INT8),
        ("batch", Type::INT8),
        ("min_value", Type::FLOAT8),
        ("max_value", Type::FLOAT8),
        ("last_value", Type::FLOAT8),
        ("sum", Type::FLOAT8),
        ("count", Type::INT8),
        ("qualities", Type::INT2),
    ];
    const ON_CONFLICT: &'static str = "(point, level, start, epoch) DO UPDATE SET batch = excluded.batch,
        min_value = excluded.min_value, max_value = excluded.max_value, last_value = excluded.last_value, sum = excluded.sum,
        count = excluded.count, qualities = excluded.qualities
        WHERE point_span.batch < excluded.batch";

    async fn write(&self, copy: CopyIn<'_>) -> Result<(), Error> {
        let Self { point, epoch, batch, span } = self;
        // `accept` refuses another one.
        let level = i16::try_from(span.level).unwrap_or(i16::MAX);
        let qualities = i16::try_from(span.qualities).unwrap_or(i16::MAX);
        let (start, count) = (time(span.start_us), i64::from(span.count));
        let PointSpan { min_value, max_value, last_value, sum, .. } = span;
        let values: &Values<'_> =
            &[point, &level, &start, epoch, batch, min_value, max_value, last_value, sum, &count, &qualities];
        copy.write(values).await
    }
}

/// The text of a value of a point, of a batch of a database.
pub struct PointTextRow {
    pub point: i32,
    pub value: f64,
    pub text: String,
    pub epoch: i64,
    pub batch: i64,
}

impl Row for PointTextRow {
    const TABLE: &'static str = "point_text";
    const COLUMNS: &'static [(&'static str, Type)] = &[
        ("point", Type::INT4),
        ("value", Type::FLOAT8),
        ("text", Type::TEXT),
        ("epoch", Type::INT8),
        ("batch", Type::INT8),
    ];
    const ON_CONFLICT: &'static str =
        "(point, value) DO UPDATE SET text = excluded.text, epoch = excluded.epoch, batch = excluded.batch
        WHERE (point_text.epoch, point_text.batch) < (excluded.epoch, excluded.batch)";

    async fn write(&self, copy: CopyIn<'_>) -> Result<(), Error> {
        let Self { point, value, text, epoch, batch } = self;
        copy.write(&[point, value, text, epoch, batch]).await
    }
}

/// A row of the database of a station.
pub struct StationRow<T> {
    pub station: i32,
    pub epoch: i64,
    pub row: T,
}

impl Row for StationRow<Event> {
    const TABLE: &'static str = "event";
    const COLUMNS: &'static [(&'static str, Type)] = &[
        ("station", Type::INT4),
        ("epoch", Type::INT8),
        ("id", Type::INT8),
        ("at", Type::TIMESTAMPTZ),
        ("series", Type::TEXT),
        ("kind", Type::TEXT),
        ("text", Type::TEXT),
    ];

    async fn write(&self, copy: CopyIn<'_>) -> Result<(), Error> {
        let Self { station, epoch, row } = self;
        let (kind, sentence, series) = (text(&row.kind), text(&row.text), optional(row.series.as_deref()));
        copy.write(&[station, epoch, &row.id, &time(row.at_us), &series, &kind, &sentence]).await
    }
}

impl Row for StationRow<AlarmChange> {
    const TABLE: &'static str = "alarm";
    const COLUMNS: &'static [(&'static str, Type)] = &[
        ("station", Type::INT4),
        ("epoch", Type::INT8),
        ("id", Type::INT8),
        ("at", Type::TIMESTAMPTZ),
        ("alarm", Type::TEXT),
        ("change", Type::TEXT),
        ("state", Type::TEXT),
        ("priority", Type::TEXT),
        ("subject", Type::TEXT),
        ("occurrence", Type::INT8),
        ("user_name", Type::TEXT),
        ("value", Type::FLOAT8),
        ("unit", Type::TEXT),
        ("text", Type::TEXT),
    ];

    async fn write(&self, copy: CopyIn<'_>) -> Result<(), Error> {
        let Self { station, epoch, row } = self;
        let [alarm, change, state, priority, sentence] =
            [&row.alarm, &row.change, &row.state, &row.priority, &row.text].map(|value| text(value));
        let [subject, user, unit] = [&row.subject, &row.user, &row.unit].map(|value| optional(value.as_deref()));
        let (at, AlarmChange { id, occurrence, value, .. }) = (time(row.at_us), row);
        let values: &Values<'_> = &[
            station, epoch, id, &at, &alarm, &change, &state, &priority, &subject, occurrence, &user, value, &unit,
            &sentence,
        ];
        copy.write(values).await
    }
}

impl Row for StationRow<Audit> {
    const TABLE: &'static str = "audit";
    const COLUMNS: &'static [(&'static str, Type)] = &[
        ("station", Type::INT4),
        ("epoch", Type::INT8),
        ("id", Type::INT8),
        ("at", Type::TIMESTAMPTZ),
        ("action", Type::TEXT),
        ("refers_to", Type::INT8),
        ("user_name", Type::TEXT),
        ("role", Type::TEXT),
        ("peer", Type::TEXT),
        ("gauge", Type::TEXT),
        ("target", Type::TEXT),
        ("before", Type::TEXT),
        ("after", Type::TEXT),
        ("outcome", Type::TEXT),
    ];

    async fn write(&self, copy: CopyIn<'_>) -> Result<(), Error> {
        let Self { station, epoch, row } = self;
        let [action, user, role] = [&row.action, &row.user, &row.role].map(|value| text(value));
        let [peer, gauge, target, before, after, outcome] =
            [&row.peer, &row.gauge, &row.target, &row.before, &row.after, &row.outcome]
                .map(|value| optional(value.as_deref()));
        let (at, Audit { id, refers_to, .. }) = (time(row.at_us), row);
        let values: &Values<'_> = &[
            station, epoch, id, &at, &action, refers_to, &user, &role, &peer, &gauge, &target, &before, &after,
            &outcome,
        ];
        copy.write(values).await
    }
}

/// A batch that is stored.
pub struct BatchRow {
    pub station: i32,
    pub epoch: i64,
    pub number: i64,
    pub made_us: i64,
    pub samples: i32,
    /// Samples that are older than the retention.
    pub expired: i32,
}

/// Stores batches. Returns how many are new. Without a temporary table: PostgreSQL empties all of a session after each transaction that uses
/// one, and most transactions have only samples and batches.
pub async fn insert_batches(transaction: &Transaction<'_>, rows: &[BatchRow]) -> Result<u64, Error> {
    if rows.is_empty() {
        return Ok(0);
    }
    let sql = "INSERT INTO profivac_data.batch (station, epoch, number, made, samples, expired)
        SELECT * FROM unnest($1::integer[], $2::bigint[], $3::bigint[], $4::timestamptz[], $5::integer[], $6::integer[]) ON CONFLICT DO NOTHING";
    let stations: Vec<_> = rows.iter().map(|row| row.station).collect();
    let epochs: Vec<_> = rows.iter().map(|row| row.epoch).collect();
    let numbers: Vec<_> = rows.iter().map(|row| row.number).collect();
    let made: Vec<_> = rows.iter().map(|row| time(row.made_us)).collect();
    let samples: Vec<_> = rows.iter().map(|row| row.samples).collect();
    let expired: Vec<_> = rows.iter().map(|row| row.expired).collect();
    transaction.execute(sql, &[&stations, &epochs, &numbers, &made, &samples, &expired]).await
}

fn optional(value: Option<&str>) -> Option<String> {
    value.map(text)
}

fn time(at_us: i64) -> SystemTime {
    Micros(at_us).to_system_time()
}
