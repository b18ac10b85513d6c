//! Batches to rows, in transactions.

use crate::nats::{of_message_id, of_subject};
use crate::schema::{LOCK, SchemaError, upgrade};
use futures_util::pin_mut;
use profivac_recorder::batch::{AlarmChange, Audit, Batch, Event, Span};
use profivac_recorder::{Micros, Sample};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::time::SystemTime;
use thiserror::Error;
use tokio::task::JoinHandle;
use tokio_postgres::binary_copy::BinaryCopyInWriter;
use tokio_postgres::error::SqlState;
use tokio_postgres::types::Type;
use tokio_postgres::{Client, Config, NoTls, Transaction};

/// Rows with times before this one are of a clock that was not set: 2000-01-01.
const EARLIEST: i64 = 946_684_800 * Micros::SECOND;

/// How far the clock of a station may be ahead of that of the archive. free choice.
const MAX_AHEAD: i64 = 3_600 * Micros::SECOND;

/// A former record that still makes batches this time after its successor began is that of another station with the same name.
const SUCCESSION: i64 = 60 * Micros::SECOND;

/// A transaction takes no further batch once it has this many rows and samples: hostile batches must not fill the memory.
const MAX_WEIGHT: usize = 200_000;

/// The most names of series in memory.
const MAX_SERIES: usize = 200_000;

const DAY: i64 = 86_400 * Micros::SECOND;

/// Why batches were not stored.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The database has refused something, or cannot be reached.
    #[error("the database: {}", described(.0))]
    Database(#[from] tokio_postgres::Error),
    /// The tables cannot be used.
    #[error(transparent)]
    Schema(#[from] SchemaError),
}

/// The error with its cause: that of the library alone says only "db error".
fn described(error: &tokio_postgres::Error) -> String {
    match (error.as_db_error(), std::error::Error::source(error)) {
        (Some(error), _) => error.to_string(),
        (None, Some(source)) => format!("{error}: {source}"),
        (None, None) => error.to_string(),
    }
}

impl StoreError {
    /// Whether the rows themselves are the cause, so that the same rows fail again.
    fn is_of_rows(&self) -> bool {
        let Self::Database(error) = self else { return false };
        let class = |code: &SqlState| code.code().starts_with("22") || code.code().starts_with("23");
        error.code().is_some_and(class)
    }
}

/// A message of a station.
#[derive(Clone, Debug)]
pub struct Incoming {
    /// Its subject.
    pub subject: String,
    /// Its id.
    pub id: String,
    /// Its octets.
    pub payload: Vec<u8>,
}

/// A batch that can be stored.
struct Accepted<'a> {
    plant: &'a str,
    station: &'a str,
    epoch: i64,
    number: i64,
    batch: Batch,
    samples: Vec<(String, Vec<Sample>)>,
}

/// The results for messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stored {
    /// Batches.
    pub batches: u64,
    /// Samples in them.
    pub samples: u64,
    /// Batches that were put aside.
    pub rejected: u64,
}

impl Stored {
    /// Adds other results.
    pub const fn add(&mut self, other: Self) {
        self.batches += other.batches;
        self.samples += other.samples;
        self.rejected += other.rejected;
    }
}

/// A station as the database knows it.
struct Station {
    id: i32,
    plant: String,
    epoch: i64,
}

/// A connection to the database.
pub struct Store {
    client: Client,
    connection: JoinHandle<()>,
    /// The ids of series, by station and name.
    series: HashMap<(i32, String), i32>,
    /// The days that have a partition.
    days: HashSet<i64>,
    samples_days: u32,
}

impl Drop for Store {
    fn drop(&mut self) {
        self.connection.abort();
    }
}

impl Store {
    /// Connects and brings the tables up to date.
    ///
    /// # Errors
    /// [`StoreError`] when the database cannot be reached, or its tables are of a newer program.
    pub async fn connect(config: &Config, samples_days: u32) -> Result<Self, StoreError> {
        let (mut client, connection) = config.connect(NoTls).await?;
        // Its error is also that of the statement that waits.
        let connection = tokio::spawn(async { connection.await.unwrap_or_default() });
        upgrade(&mut client).await?;
        client
            .batch_execute(
                "SET statement_timeout = '120s';
                 CREATE TEMPORARY TABLE stage (series integer, at timestamptz, pressure_pa double precision, quality smallint)
                 ON COMMIT DELETE ROWS",
            )
            .await?;
        Ok(Self { client, connection, series: HashMap::new(), days: HashSet::new(), samples_days })
    }

    /// Sets which roles may read which plants.
    ///
    /// # Errors
    /// [`StoreError`]; a role that does not exist is one.
    pub async fn set_readers(&mut self, plants: &[(String, Vec<String>)]) -> Result<(), StoreError> {
        let transaction = self.client.transaction().await?;
        // Two archives that start together grant one after the other.
        transaction.execute("SELECT pg_advisory_xact_lock($1)", &[&LOCK]).await?;
        transaction.execute("DELETE FROM profivac_data.reader", &[]).await?;
        for (plant, roles) in plants {
            for role in roles {
                transaction
                    .execute("INSERT INTO profivac_data.reader VALUES ($1, $2) ON CONFLICT DO NOTHING", &[plant, role])
                    .await?;
                let row = transaction
                    .query_one("SELECT format('GRANT USAGE ON SCHEMA profivac TO %1$I; GRANT SELECT ON ALL TABLES IN SCHEMA profivac TO %1$I', $1::text)", &[role])
                    .await?;
                transaction.batch_execute(row.get(0)).await?;
            }
        }
        Ok(transaction.commit().await?)
    }

    /// Makes the partitions of the next days, drops those beyond the retention, and forgets old batches.
    ///
    /// # Errors
    /// [`StoreError`] when the database refuses.
    pub async fn maintain(&mut self, now: Micros) -> Result<(), StoreError> {
        let today = now.0.div_euclid(DAY);
        self.add_days((today..today.saturating_add(4)).collect()).await?;
        let before = today.saturating_sub(i64::from(self.samples_days));
        self.client
            .execute("SELECT profivac_data.drop_days(date '1970-01-01' + $1::int)", &[&day_number(before)])
            .await?;
        self.days.retain(|day| *day >= before);
        self.client.execute("DELETE FROM profivac_data.batch WHERE stored < now() - interval '30 days'", &[]).await?;
        let sql =
            "DELETE FROM profivac_data.rejected WHERE id <= (SELECT max(id) FROM profivac_data.rejected) - 100000";
        self.client.execute(sql, &[]).await?;
        Ok(())
    }

    /// Stores messages, in one transaction unless they are very large. Those that cannot be stored are put aside with the reason.
    ///
    /// # Errors
    /// [`StoreError`]; then all messages come again, and rows that are stored already stay as they are.
    pub async fn store(&mut self, messages: &[Incoming], now: Micros) -> Result<Stored, StoreError> {
        let mut sum = Stored::default();
        let mut rest = messages;
        while !rest.is_empty() {
            let (stored, taken) = match self.store_together(rest, now).await {
                Err(error) if error.is_of_rows() => (self.store_one_by_one(rest, now, &error).await?, rest.len()),
                stored => stored?,
            };
            sum.add(stored);
            rest = rest.get(taken..).unwrap_or_default();
        }
        Ok(sum)
    }

    /// Stores each message in a transaction of its own, after `refusal` of all together. A message that is refused alone is put aside.
    async fn store_one_by_one(
        &mut self,
        messages: &[Incoming],
        now: Micros,
        refusal: &StoreError,
    ) -> Result<Stored, StoreError> {
        let mut sum = Stored::default();
        for message in messages {
            let stored = match messages {
                [_] => self.put_aside(message, refusal).await?,
                _ => Box::pin(self.store(std::slice::from_ref(message), now)).await?,
            };
            sum.add(stored);
        }
        Ok(sum)
    }

    async fn put_aside(&mut self, message: &Incoming, refusal: &StoreError) -> Result<Stored, StoreError> {
        let transaction = self.client.transaction().await?;
        reject(&transaction, message, &refusal.to_string()).await?;
        transaction.commit().await?;
        Ok(Stored { rejected: 1, ..Stored::default() })
    }

    /// Stores the first messages in one transaction. Returns how many messages that were.
    async fn store_together(&mut self, messages: &[Incoming], now: Micros) -> Result<(Stored, usize), StoreError> {
        let (mut accepted, mut rejected) = (Vec::new(), Vec::new());
        let mut stations = HashMap::new();
        let mut weight = 0_usize;
        for message in messages {
            if weight >= MAX_WEIGHT {
                break;
            }
            match accept(message, now) {
                Ok(batch) => match self.check_station(&mut stations, &batch).await? {
                    None => {
                        weight =
                            weight.saturating_add(batch.batch.sample_count()).saturating_add(batch.batch.row_count());
                        accepted.push(batch);
                    }
                    Some(reason) => rejected.push((message, reason)),
                },
                Err(reason) => rejected.push((message, reason)),
            }
        }
        let oldest = now.0.div_euclid(DAY).saturating_sub(i64::from(self.samples_days)).saturating_mul(DAY);
        let (rows, expired) = self.sample_rows(&accepted, &stations, oldest).await?;
        self.add_days(rows.iter().map(|(_, sample)| sample.at.0.div_euclid(DAY)).collect()).await?;
        let spans = self.span_rows(&accepted, &stations).await?;
        let transaction = self.client.transaction().await?;
        insert_samples(&transaction, &rows).await?;
        insert_spans(&transaction, &spans).await?;
        for (batch, expired) in accepted.iter().zip(expired) {
            let Some(station) = stations.get(batch.station) else { continue };
            insert_lists(&transaction, station.id, batch, expired).await?;
        }
        for (message, reason) in &rejected {
            reject(&transaction, message, reason).await?;
        }
        transaction.commit().await?;
        let samples = accepted.iter().map(|batch| batch.batch.sample_count() as u64).sum();
        let stored = Stored { batches: accepted.len() as u64, samples, rejected: rejected.len() as u64 };
        Ok((stored, accepted.len().saturating_add(rejected.len())))
    }

    /// Finds or adds the station of a batch. Returns why the batch is not of this station.
    async fn check_station(
        &self,
        stations: &mut HashMap<String, Station>,
        batch: &Accepted<'_>,
    ) -> Result<Option<String>, StoreError> {
        if !stations.contains_key(batch.station) {
            let add =
                "INSERT INTO profivac_data.station (plant, name, epoch) VALUES ($1, $2, $3) ON CONFLICT DO NOTHING";
            self.client.execute(add, &[&batch.plant, &batch.station, &batch.epoch]).await?;
            let select = "SELECT id, plant, epoch FROM profivac_data.station WHERE name = $1";
            let row = self.client.query_one(select, &[&batch.station]).await?;
            let station = Station { id: row.get(0), plant: row.get(1), epoch: row.get(2) };
            stations.insert(batch.station.to_owned(), station);
        }
        let Some(station) = stations.get_mut(batch.station) else { return Ok(None) };
        if station.plant != batch.plant {
            let plant = &station.plant;
            return Ok(Some(format!(
                "the station {} belongs to plant {plant}, and this batch names {}",
                batch.station, batch.plant
            )));
        }
        if batch.epoch < station.epoch && batch.batch.made_us > station.epoch.saturating_add(SUCCESSION) {
            return Ok(Some(format!(
                "two records send as station {}: one that began at {}, and this one of {}, both in microseconds since 1970; give each \
                 station a name of its own",
                batch.station, station.epoch, batch.epoch
            )));
        }
        if batch.epoch > station.epoch {
            let sql = "UPDATE profivac_data.station SET epoch = greatest(epoch, $2) WHERE id = $1";
            self.client.execute(sql, &[&station.id, &batch.epoch]).await?;
            station.epoch = batch.epoch;
        }
        Ok(None)
    }

    /// The id of a series, which is added if it is new. Outside of the transaction: what is in memory stays true if that fails.
    async fn series_id(&mut self, station: i32, name: &str) -> Result<i32, StoreError> {
        let key = (station, name.to_owned());
        if let Some(id) = self.series.get(&key) {
            return Ok(*id);
        }
        let add = "INSERT INTO profivac_data.series (station, name) VALUES ($1, $2) ON CONFLICT DO NOTHING";
        self.client.execute(add, &[&station, &name]).await?;
        let select = "SELECT id FROM profivac_data.series WHERE station = $1 AND name = $2";
        let id = self.client.query_one(select, &[&station, &name]).await?.get(0);
        if self.series.len() >= MAX_SERIES {
            self.series.clear();
        }
        self.series.insert(key, id);
        Ok(id)
    }

    /// All samples not older than `oldest`, and for each batch how many are older.
    async fn sample_rows(
        &mut self,
        accepted: &[Accepted<'_>],
        stations: &HashMap<String, Station>,
        oldest: i64,
    ) -> Result<(Vec<(i32, Sample)>, Vec<i32>), StoreError> {
        let (mut rows, mut expired) = (Vec::new(), Vec::new());
        for batch in accepted {
            let mut older = 0_i32;
            let Some(station) = stations.get(batch.station) else { continue };
            for (name, samples) in &batch.samples {
                let series = self.series_id(station.id, name).await?;
                let before = rows.len();
                rows.extend(samples.iter().filter(|it| it.at.0 >= oldest).map(|sample| (series, *sample)));
                let kept = rows.len().saturating_sub(before);
                older = older.saturating_add(i32::try_from(samples.len().saturating_sub(kept)).unwrap_or(i32::MAX));
            }
            expired.push(older);
        }
        // Two archives that insert the same rows in the same order do not wait for each other in a circle.
        rows.sort_unstable_by_key(|(series, sample)| (*series, sample.at));
        Ok((rows, expired))
    }

    /// All spans, the last one of several with the same key.
    async fn span_rows(
        &mut self,
        accepted: &[Accepted<'_>],
        stations: &HashMap<String, Station>,
    ) -> Result<Vec<SpanRow>, StoreError> {
        let mut rows = std::collections::BTreeMap::new();
        for batch in accepted {
            let Some(station) = stations.get(batch.station) else { continue };
            for span in &batch.batch.spans {
                let series = self.series_id(station.id, &text(&span.series)).await?;
                let row = SpanRow { series, epoch: batch.epoch, batch: batch.number, span: span.clone() };
                let key = (series, span.level, span.start_us, batch.epoch);
                match rows.get(&key) {
                    Some(SpanRow { batch, .. }) if *batch > row.batch => {}
                    _ => drop(rows.insert(key, row)),
                }
            }
        }
        Ok(rows.into_values().collect())
    }

    /// Makes the partitions of these days.
    async fn add_days(&mut self, days: BTreeSet<i64>) -> Result<(), StoreError> {
        for day in days {
            if !self.days.contains(&day) {
                let sql = "SELECT profivac_data.add_day(date '1970-01-01' + $1::int)";
                self.client.execute(sql, &[&day_number(day)]).await?;
                self.days.insert(day);
            }
        }
        Ok(())
    }
}

struct SpanRow {
    series: i32,
    epoch: i64,
    batch: i64,
    span: Span,
}

fn day_number(day: i64) -> i32 {
    i32::try_from(day).unwrap_or(i32::MAX)
}

/// Decodes and checks a message, or says why it cannot be stored.
fn accept(message: &Incoming, now: Micros) -> Result<Accepted<'_>, String> {
    let (plant, station) = of_subject(&message.subject).ok_or("the subject is not profivac.v1.PLANT.STATION.batch")?;
    let (epoch, number) =
        of_message_id(&message.id, station).ok_or_else(|| format!("the id is not {station}/EPOCH/NUMBER"))?;
    let batch = Batch::decode_compressed(&message.payload).map_err(|error| error.to_string())?;
    let unpack = |series: &profivac_recorder::batch::Samples| Ok((text(&series.series), series.unpack()?));
    let unpacked: Result<Vec<_>, profivac_recorder::batch::BatchError> = batch.samples.iter().map(unpack).collect();
    let samples = unpacked.map_err(|error| error.to_string())?;
    check_times(&batch, &samples, now)?;
    Ok(Accepted { plant, station, epoch, number, batch, samples })
}

/// A batch with times of a wrong clock is put aside whole: its rows would be found nowhere, and its partitions be dropped or wait for
/// years.
fn check_times(batch: &Batch, samples: &[(String, Vec<Sample>)], now: Micros) -> Result<(), String> {
    let of_samples = samples.iter().flat_map(|(_, samples)| samples.iter().map(|sample| sample.at.0));
    let of_lists = batch.events.iter().map(|row| row.at_us).chain(batch.alarms.iter().map(|row| row.at_us));
    let all = of_samples.chain(of_lists).chain(batch.audit.iter().map(|row| row.at_us));
    let all = all.chain(batch.spans.iter().map(|span| span.start_us)).chain([batch.made_us]);
    let latest = now.0.saturating_add(MAX_AHEAD);
    let wrong = all.into_iter().find(|at| !(EARLIEST..=latest).contains(at));
    wrong.map_or(Ok(()), |at| match at < EARLIEST {
        true => Err(format!("a time before 2000 ({at} µs since 1970): the clock of the station was not set")),
        false => Err(format!(
            "a time {} s ahead of the clock of the archive: set the clock of the station",
            at.saturating_sub(now.0) / Micros::SECOND
        )),
    })
}

/// A text that PostgreSQL accepts: it has no NUL.
fn text(text: &str) -> String {
    text.replace('\0', "\u{fffd}")
}

fn optional(value: &Option<String>) -> Option<String> {
    value.as_deref().map(text)
}

fn time(at_us: i64) -> SystemTime {
    Micros(at_us).to_system_time()
}

async fn insert_samples(transaction: &Transaction<'_>, rows: &[(i32, Sample)]) -> Result<(), StoreError> {
    if rows.is_empty() {
        return Ok(());
    }
    let sink = transaction.copy_in("COPY stage FROM STDIN BINARY").await?;
    let writer = BinaryCopyInWriter::new(sink, &[Type::INT4, Type::TIMESTAMPTZ, Type::FLOAT8, Type::INT2]);
    pin_mut!(writer);
    for (series, Sample { at, pa, quality }) in rows {
        let quality = i16::from(*quality as u8);
        writer.as_mut().write(&[series, &at.to_system_time(), pa, &quality]).await?;
    }
    writer.finish().await?;
    let insert = "INSERT INTO profivac_data.sample SELECT series, at, pressure_pa, quality FROM stage ORDER BY series, at ON CONFLICT DO NOTHING";
    transaction.execute(insert, &[]).await?;
    Ok(())
}

async fn insert_spans(transaction: &Transaction<'_>, rows: &[SpanRow]) -> Result<(), StoreError> {
    if rows.is_empty() {
        return Ok(());
    }
    let insert = transaction
        .prepare(
            "INSERT INTO profivac_data.span (series, level, start, epoch, batch, min_pa, max_pa, log10_sum, count, qualities)
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)
             ON CONFLICT (series, level, start, epoch) DO UPDATE SET batch = excluded.batch, min_pa = excluded.min_pa,
                 max_pa = excluded.max_pa, log10_sum = excluded.log10_sum, count = excluded.count, qualities = excluded.qualities
             WHERE span.batch < excluded.batch",
        )
        .await?;
    for SpanRow { series, epoch, batch, span } in rows {
        let level = i16::try_from(span.level).unwrap_or(i16::MAX);
        let qualities = i16::try_from(span.qualities).unwrap_or(i16::MAX);
        let count = i64::from(span.count);
        transaction
            .execute(
                &insert,
                &[
                    series,
                    &level,
                    &time(span.start_us),
                    epoch,
                    batch,
                    &span.min_pa,
                    &span.max_pa,
                    &span.log10_sum,
                    &count,
                    &qualities,
                ],
            )
            .await?;
    }
    Ok(())
}

/// Events, alarms and audit of a batch, and the batch itself.
async fn insert_lists(
    transaction: &Transaction<'_>,
    station: i32,
    batch: &Accepted<'_>,
    expired: i32,
) -> Result<(), StoreError> {
    let epoch = batch.epoch;
    for Event { id, at_us, series, kind, text: sentence } in &batch.batch.events {
        let sql = "INSERT INTO profivac_data.event VALUES ($1, $2, $3, $4, $5, $6, $7) ON CONFLICT DO NOTHING";
        transaction
            .execute(sql, &[&station, &epoch, id, &time(*at_us), &optional(series), &text(kind), &text(sentence)])
            .await?;
    }
    for row in &batch.batch.alarms {
        insert_alarm(transaction, station, epoch, row).await?;
    }
    for row in &batch.batch.audit {
        insert_audit(transaction, station, epoch, row).await?;
    }
    let samples = i32::try_from(batch.batch.sample_count()).unwrap_or(i32::MAX);
    let sql = "INSERT INTO profivac_data.batch (station, epoch, number, made, samples, expired)
               VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT DO NOTHING";
    transaction
        .execute(sql, &[&station, &epoch, &batch.number, &time(batch.batch.made_us), &samples, &expired])
        .await?;
    Ok(())
}

async fn insert_alarm(
    transaction: &Transaction<'_>,
    station: i32,
    epoch: i64,
    row: &AlarmChange,
) -> Result<(), StoreError> {
    let sql = "INSERT INTO profivac_data.alarm VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14)
               ON CONFLICT DO NOTHING";
    let (alarm, change, state, priority) = (text(&row.alarm), text(&row.change), text(&row.state), text(&row.priority));
    let (subject, user, unit, sentence) =
        (optional(&row.subject), optional(&row.user), optional(&row.unit), text(&row.text));
    let values: [&(dyn tokio_postgres::types::ToSql + Sync); 14] = [
        &station,
        &epoch,
        &row.id,
        &time(row.at_us),
        &alarm,
        &change,
        &state,
        &priority,
        &subject,
        &row.occurrence,
        &user,
        &row.value,
        &unit,
        &sentence,
    ];
    transaction.execute(sql, &values).await?;
    Ok(())
}

async fn insert_audit(transaction: &Transaction<'_>, station: i32, epoch: i64, row: &Audit) -> Result<(), StoreError> {
    let sql = "INSERT INTO profivac_data.audit VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14)
               ON CONFLICT DO NOTHING";
    let (action, user, role, peer) = (text(&row.action), text(&row.user), text(&row.role), optional(&row.peer));
    let (gauge, target) = (optional(&row.gauge), optional(&row.target));
    let (before, after, outcome) = (optional(&row.before), optional(&row.after), optional(&row.outcome));
    let values: [&(dyn tokio_postgres::types::ToSql + Sync); 14] = [
        &station,
        &epoch,
        &row.id,
        &time(row.at_us),
        &action,
        &row.refers_to,
        &user,
        &role,
        &peer,
        &gauge,
        &target,
        &before,
        &after,
        &outcome,
    ];
    transaction.execute(sql, &values).await?;
    Ok(())
}

async fn reject(transaction: &Transaction<'_>, message: &Incoming, reason: &str) -> Result<(), StoreError> {
    let sql = "INSERT INTO profivac_data.rejected (subject, message_id, reason, payload) VALUES ($1, $2, $3, $4) ON CONFLICT DO NOTHING";
    transaction.execute(sql, &[&text(&message.subject), &text(&message.id), &text(reason), &message.payload]).await?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_recorder::Quality;
    use profivac_recorder::batch::{FORMAT, Samples};

    const NOW: Micros = Micros(1_700_000_000 * Micros::SECOND);

    fn message(at: i64) -> Incoming {
        let samples = [Sample::new(Micros(at), Some(1.0), Quality::Valid)];
        let samples = vec![Samples::new("chamber".to_owned(), &samples)];
        let batch = Batch { format: FORMAT, made_us: NOW.0, samples, ..Batch::default() };
        let payload = batch.encode_compressed().unwrap();
        Incoming { subject: "profivac.v1.hall.hall-1.batch".to_owned(), id: "hall-1/5/7".to_owned(), payload }
    }

    #[test]
    fn a_message_has_plant_station_epoch_number_and_samples() {
        let message = message(NOW.0);
        let accepted = accept(&message, NOW).unwrap();
        assert_eq!((accepted.plant, accepted.station, accepted.epoch, accepted.number), ("hall", "hall-1", 5, 7));
        assert_eq!(accepted.samples[0].1[0].at, NOW);
    }

    #[test]
    fn a_wrong_clock_another_station_and_damage_are_refused_with_a_reason() {
        let reason = |message: Incoming| accept(&message, NOW).err().unwrap();
        assert!(reason(message(0)).contains("was not set"));
        assert!(reason(message(NOW.0 + 3_601 * Micros::SECOND)).contains("3601 s ahead"));
        assert!(accept(&message(NOW.0 + 3_600 * Micros::SECOND), NOW).is_ok());
        assert!(reason(Incoming { id: "hall-2/5/7".to_owned(), ..message(NOW.0) }).contains("hall-1/EPOCH/NUMBER"));
        assert!(reason(Incoming { subject: "x".to_owned(), ..message(NOW.0) }).contains("the subject is not"));
        assert!(reason(Incoming { payload: vec![255; 9], ..message(NOW.0) }).contains("the batch is damaged"));
    }

    #[test]
    fn a_text_has_no_nul() {
        assert_eq!(text("a\0b"), "a\u{fffd}b");
    }
}
