//! Batches to rows, in transactions.

mod accept;
mod rows;

pub use accept::Incoming;
pub(crate) use accept::{Accepted, accept};

use crate::config::Plant;
use crate::database::{ConnectError, Database, described};
use crate::schema::{LOCK, SchemaError, upgrade};
use accept::{Refusal, text};
use profivac_recorder::Micros;
use profivac_recorder::batch::{AlarmChange, Audit, Event};
use rows::{BatchRow, SampleRow, SpanRow, StationRow, insert, prepare};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use thiserror::Error;
use tokio::task::JoinHandle;
use tokio_postgres::error::SqlState;
use tokio_postgres::{Client, Transaction};

/// A former database that still makes batches this time after its successor began is that of another station with the same name.
const SUCCESSION: i64 = 60 * Micros::SECOND;

/// A transaction takes no further batch once it has this many rows and samples, see [`Accepted::weight`]: hostile batches must not fill the
/// memory.
const MAX_WEIGHT: usize = 200_000;

/// The most names of series in memory.
const MAX_SERIES: usize = 200_000;

/// Limit of series for each station. chosen: eight segments with 125 gauges of three channels each have 3,000. Each view keeps the latest
/// reading of all series, so a station that invents names must not fill the memory.
const MAX_SERIES_OF_STATION: i64 = 10_000;

/// Size limit of the table of rejected batches in bytes, and how many rejections pass before it is checked again. Older ones are deleted.
const MAX_REJECTED_OCTETS: i64 = 1 << 30;
const REJECTED_BETWEEN_COUNTS: u64 = 1_000;

const DAY: i64 = 86_400 * Micros::SECOND;

/// Why batches were not stored.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StoreError {
    /// The database has refused something, or cannot be reached.
    #[error("the database: {}", described(.0))]
    Database(#[from] tokio_postgres::Error),
    /// There is no connection to it.
    #[error("the database: {0}")]
    Connect(#[from] ConnectError),
    /// The tables cannot be used.
    #[error(transparent)]
    Schema(#[from] SchemaError),
    /// A station has too many series.
    #[error(
        "the station has {MAX_SERIES_OF_STATION} series already, and {0:?} is another one: delete in profivac_data.series those that it no longer has"
    )]
    TooManySeries(String),
}

/// The classes of SQL states that the rows themselves cause, so that the same rows fail again: two rows with one key, a value without a
/// form, one that breaks a constraint, one that is too large for an index.
const OF_ROWS: [&str; 4] = ["21", "22", "23", "54"];

impl StoreError {
    /// Whether the rows themselves are the cause.
    fn is_of_rows(&self) -> bool {
        match self {
            Self::TooManySeries(_) => true,
            Self::Database(error) => error.code().is_some_and(is_of_rows),
            Self::Connect(_) | Self::Schema(_) => false,
        }
    }
}

fn is_of_rows(state: &SqlState) -> bool {
    OF_ROWS.iter().any(|class| state.code().starts_with(class))
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
        self.batches = self.batches.saturating_add(other.batches);
        self.samples = self.samples.saturating_add(other.samples);
        self.rejected = self.rejected.saturating_add(other.rejected);
    }
}

/// A station as the database knows it.
struct Station {
    id: i32,
    plant: String,
    epoch: i64,
    /// Whether a batch has begun a later epoch.
    is_new_epoch: bool,
}

impl Station {
    /// Why a batch is not of this station. A later epoch is that of its new database.
    fn refusal(&mut self, batch: &Accepted<'_>) -> Option<Refusal> {
        let station = || batch.station.to_owned();
        if self.plant != batch.plant {
            let (plant, found) = (self.plant.clone(), batch.plant.to_owned());
            return Some(Refusal::OtherPlant { station: station(), plant, found });
        }
        if batch.epoch < self.epoch && batch.batch.made_us > self.epoch.saturating_add(SUCCESSION) {
            return Some(Refusal::TwoDatabases { station: station(), known: self.epoch, found: batch.epoch });
        }
        if batch.epoch > self.epoch {
            self.epoch = batch.epoch;
            self.is_new_epoch = true;
        }
        None
    }
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
    /// The batches that were put aside since these were counted.
    rejected: u64,
}

impl Drop for Store {
    fn drop(&mut self) {
        self.connection.abort();
    }
}

impl Store {
    /// Connects, brings the tables up to date, and sets readers and partitions as the file says.
    ///
    /// # Errors
    /// [`StoreError`] when the database cannot be reached or refuses, or its tables are of a newer program.
    pub async fn open(database: &Database, samples_days: u32, plants: &[Plant]) -> Result<Self, StoreError> {
        let mut store = Self::connect(database, samples_days).await?;
        store.set_readers(plants).await?;
        store.maintain(Micros::now()).await?;
        Ok(store)
    }

    /// Connects and brings the tables up to date.
    ///
    /// # Errors
    /// [`StoreError`] when the database cannot be reached, or its tables are of a newer program.
    pub async fn connect(database: &Database, samples_days: u32) -> Result<Self, StoreError> {
        let (mut client, connection) = database.connect().await?;
        upgrade(&mut client).await?;
        client.batch_execute("SET statement_timeout = '120s'").await?;
        prepare::<SampleRow>(&client).await?;
        prepare::<SpanRow>(&client).await?;
        prepare::<StationRow<Event>>(&client).await?;
        prepare::<StationRow<AlarmChange>>(&client).await?;
        prepare::<StationRow<Audit>>(&client).await?;
        prepare::<BatchRow>(&client).await?;
        Ok(Self { client, connection, series: HashMap::new(), days: HashSet::new(), samples_days, rejected: 0 })
    }

    /// Sets which roles may read which plants.
    ///
    /// # Errors
    /// [`StoreError`]; a role that does not exist is one.
    pub async fn set_readers(&mut self, plants: &[Plant]) -> Result<(), StoreError> {
        let transaction = self.client.transaction().await?;
        // Two archives that start together grant one after the other.
        transaction.execute("SELECT pg_advisory_xact_lock($1)", &[&LOCK]).await?;
        transaction.execute("DELETE FROM profivac_data.reader", &[]).await?;
        for Plant { name: plant, readers, .. } in plants {
            for role in readers {
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
        // An administrator may have dropped partitions and deleted series.
        self.days.clear();
        self.series.clear();
        self.client.execute("DELETE FROM profivac_data.batch WHERE stored < now() - interval '30 days'", &[]).await?;
        self.limit_rejected().await
    }

    /// Deletes the oldest batches that were put aside, beyond the limits.
    async fn limit_rejected(&mut self) -> Result<(), StoreError> {
        let sql = "DELETE FROM profivac_data.rejected WHERE id <= (SELECT max(id) FROM (
                SELECT id, sum(octet_length(payload) + 1000) OVER (ORDER BY id DESC) AS octets FROM profivac_data.rejected
            ) AS newest WHERE octets > $1)";
        self.client.execute(sql, &[&MAX_REJECTED_OCTETS]).await?;
        self.rejected = 0;
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
                Err(error) if error.is_of_rows() => {
                    // An administrator may have dropped a partition.
                    self.days.clear();
                    (self.store_one_by_one(rest, now, &error).await?, rest.len())
                }
                stored => stored?,
            };
            sum.add(stored);
            rest = rest.get(taken..).unwrap_or_default();
        }
        self.rejected = self.rejected.saturating_add(sum.rejected);
        if self.rejected >= REJECTED_BETWEEN_COUNTS {
            self.limit_rejected().await?;
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
        let (decoded, mut rejected) = decode(messages, now);
        let taken = decoded.len().saturating_add(rejected.len());
        let mut stations = self.stations(&decoded).await?;
        let mut batches = Vec::new();
        for (message, batch) in decoded {
            let Some(station) = stations.get_mut(batch.station) else { continue };
            match station.refusal(&batch) {
                Some(reason) => rejected.push((message, reason)),
                None => batches.push((station.id, batch)),
            }
        }
        batches.sort_unstable_by_key(|(station, batch)| (*station, batch.epoch, batch.number));
        let rows = self.rows(&batches, now).await?;
        self.add_days(rows.samples.iter().map(|row| row.sample.at.0.div_euclid(DAY)).collect()).await?;
        let transaction = self.client.transaction().await?;
        rows.insert(&transaction).await?;
        for station in stations.values().filter(|station| station.is_new_epoch) {
            let sql = "UPDATE profivac_data.station SET epoch = greatest(epoch, $2) WHERE id = $1";
            transaction.execute(sql, &[&station.id, &station.epoch]).await?;
        }
        for (message, reason) in &rejected {
            reject(&transaction, message, &reason.to_string()).await?;
        }
        transaction.commit().await?;
        let samples = batches.iter().map(|(_, batch)| batch.batch.sample_count() as u64).sum();
        Ok((Stored { batches: batches.len() as u64, samples, rejected: rejected.len() as u64 }, taken))
    }

    /// The stations of these batches, by name. New ones are added, outside of the transaction: ids in memory stay true if that fails.
    async fn stations(&self, decoded: &[Of<'_, Accepted<'_>>]) -> Result<BTreeMap<String, Station>, StoreError> {
        let first: BTreeMap<_, _> = decoded.iter().rev().map(|(_, batch)| (batch.station, batch)).collect();
        let names: Vec<_> = first.keys().copied().collect();
        let mut stations = self.known_stations(&names).await?;
        let missing: Vec<_> = first.into_iter().filter(|(name, _)| !stations.contains_key(*name)).collect();
        if !missing.is_empty() {
            for (name, batch) in missing {
                let add =
                    "INSERT INTO profivac_data.station (plant, name, epoch) VALUES ($1, $2, $3) ON CONFLICT DO NOTHING";
                self.client.execute(add, &[&batch.plant, &name, &batch.epoch]).await?;
            }
            stations = self.known_stations(&names).await?;
        }
        Ok(stations)
    }

    async fn known_stations(&self, names: &[&str]) -> Result<BTreeMap<String, Station>, StoreError> {
        let sql = "SELECT name, id, plant, epoch FROM profivac_data.station WHERE name = ANY($1)";
        let station = |row: tokio_postgres::Row| {
            let station = Station { id: row.get(1), plant: row.get(2), epoch: row.get(3), is_new_epoch: false };
            (row.get(0), station)
        };
        Ok(self.client.query(sql, &[&names]).await?.into_iter().map(station).collect())
    }

    /// The id of a series, which is added if it is new. Outside of the transaction: what is in memory stays true if that fails.
    async fn series_id(&mut self, station: i32, name: &str) -> Result<i32, StoreError> {
        let key = (station, name.to_owned());
        if let Some(id) = self.series.get(&key) {
            return Ok(*id);
        }
        let add = "INSERT INTO profivac_data.series (station, name)
            SELECT $1::integer, $2::text WHERE (SELECT count(*) FROM profivac_data.series WHERE station = $1) < $3::bigint ON CONFLICT DO NOTHING";
        self.client.execute(add, &[&station, &name, &MAX_SERIES_OF_STATION]).await?;
        let select = "SELECT id FROM profivac_data.series WHERE station = $1 AND name = $2";
        let found = self.client.query_opt(select, &[&station, &name]).await?;
        let id = found.ok_or_else(|| StoreError::TooManySeries(name.to_owned()))?.get(0);
        if self.series.len() >= MAX_SERIES {
            self.series.clear();
        }
        self.series.insert(key, id);
        Ok(id)
    }

    /// The rows of batches: all samples within the retention, and of several spans with the same key the last one.
    async fn rows(&mut self, batches: &[(i32, Accepted<'_>)], now: Micros) -> Result<Rows, StoreError> {
        let oldest = now.0.div_euclid(DAY).saturating_sub(i64::from(self.samples_days)).saturating_mul(DAY);
        let mut rows = Rows::default();
        let mut spans = BTreeMap::new();
        for (station, batch) in batches {
            let mut expired = 0_usize;
            for (name, samples) in &batch.samples {
                let series = self.series_id(*station, name).await?;
                let before = rows.samples.len();
                let kept = samples.iter().filter(|sample| sample.at.0 >= oldest);
                rows.samples.extend(kept.map(|sample| SampleRow { series, sample: *sample }));
                expired += samples.len().saturating_sub(rows.samples.len().saturating_sub(before));
            }
            for span in &batch.batch.spans {
                let series = self.series_id(*station, &text(&span.series)).await?;
                let key = (series, span.level, span.start_us, batch.epoch);
                // The batches are in the order of their numbers.
                spans.insert(key, SpanRow { series, epoch: batch.epoch, batch: batch.number, span: span.clone() });
            }
            rows.add_lists(*station, batch, expired);
        }
        rows.samples.sort_unstable_by_key(|row| (row.series, row.sample.at));
        rows.spans = spans.into_values().collect();
        Ok(rows)
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

/// What became of a message.
type Of<'a, T> = (&'a Incoming, T);

/// The first messages, decoded, up to [`MAX_WEIGHT`]; and those that cannot be, with the reason.
fn decode(messages: &[Incoming], now: Micros) -> (Vec<Of<'_, Accepted<'_>>>, Vec<Of<'_, Refusal>>) {
    let (mut decoded, mut rejected) = (Vec::new(), Vec::new());
    let mut weight = 0_usize;
    for message in messages {
        match accept(message, now) {
            Ok(batch) => {
                weight = weight.saturating_add(batch.weight());
                decoded.push((message, batch));
            }
            Err(reason) => rejected.push((message, reason)),
        }
        if weight >= MAX_WEIGHT {
            break;
        }
    }
    (decoded, rejected)
}

/// The rows of a transaction.
#[derive(Default)]
struct Rows {
    samples: Vec<SampleRow>,
    spans: Vec<SpanRow>,
    events: Vec<StationRow<Event>>,
    alarms: Vec<StationRow<AlarmChange>>,
    audit: Vec<StationRow<Audit>>,
    batches: Vec<BatchRow>,
}

impl Rows {
    /// Adds the events, alarms and audit of a batch, and the batch itself.
    fn add_lists(&mut self, station: i32, accepted: &Accepted<'_>, expired: usize) {
        let Accepted { epoch, number, batch, .. } = accepted;
        self.events.extend(batch.events.iter().map(|row| StationRow { station, epoch: *epoch, row: row.clone() }));
        self.alarms.extend(batch.alarms.iter().map(|row| StationRow { station, epoch: *epoch, row: row.clone() }));
        self.audit.extend(batch.audit.iter().map(|row| StationRow { station, epoch: *epoch, row: row.clone() }));
        let [samples, expired] = [batch.sample_count(), expired].map(|count| i32::try_from(count).unwrap_or(i32::MAX));
        let (epoch, number, made_us) = (*epoch, *number, batch.made_us);
        self.batches.push(BatchRow { station, epoch, number, made_us, samples, expired });
    }

    async fn insert(&self, transaction: &Transaction<'_>) -> Result<(), StoreError> {
        insert(transaction, &self.samples).await?;
        insert(transaction, &self.spans).await?;
        insert(transaction, &self.events).await?;
        insert(transaction, &self.alarms).await?;
        insert(transaction, &self.audit).await?;
        insert(transaction, &self.batches).await?;
        Ok(())
    }
}

fn day_number(day: i64) -> i32 {
    i32::try_from(day).unwrap_or(i32::MAX)
}

async fn reject(transaction: &Transaction<'_>, message: &Incoming, reason: &str) -> Result<(), StoreError> {
    let sql = "INSERT INTO profivac_data.rejected (subject, message_id, reason, payload) VALUES ($1, $2, $3, $4) ON CONFLICT DO NOTHING";
    transaction.execute(sql, &[&text(&message.subject), &text(&message.id), &text(reason), &message.payload]).await?;
    Ok(())
}
