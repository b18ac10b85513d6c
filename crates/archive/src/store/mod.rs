//! Batches to rows, in transactions.

mod accept;
mod copies;
mod gaps;
mod operator;
mod retention;
mod rows;
mod samples;

pub use accept::Incoming;
pub(crate) use accept::{Accepted, accept};
pub use gaps::{SEARCH_INTERVAL, StationStatus};
pub use retention::{Dropped, OldDays};
pub(crate) use samples::KEYS;

use crate::config::Plant;
use crate::database::{ConnectError, Database, described};
use crate::metrics::{self, Metrics};
use crate::schema::{LOCK, SchemaError, upgrade};
use accept::{Refusal, text};
use profivac_archive_protocol::nats::{of_message_id, of_subject};
use profivac_recorder::Micros;
use profivac_recorder::batch::{AlarmChange, Audit, BatchPoint, Event};
use rows::{
    BatchRow, PointSampleRow, PointSpanRow, PointTextRow, Row, SampleRow, SpanRow, StationRow, insert, insert_batches,
    prepare,
};
use samples::{SampleOf, Way};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::mem::{Discriminant, discriminant};
use thiserror::Error;
use tokio::task::JoinHandle;
use tokio::time::Instant;
use tokio_postgres::error::SqlState;
use tokio_postgres::types::ToSql;
use tokio_postgres::{Client, Transaction};

/// A former database that still makes batches this time after its successor began is that of another station with the same name.
const SUCCESSION: i64 = 60 * Micros::SECOND;

/// A transaction takes no further batch once it has this many rows and samples, see [`Accepted::weight`]: hostile batches must not fill the
/// memory.
const MAX_WEIGHT: usize = 200_000;

/// The most stations and reasons that are reported in an hour: a user who invents names must not fill the memory.
const MAX_REPORTED: usize = 1_000;

/// The most names of series, and of points, in memory.
const MAX_SERIES: usize = 200_000;

/// Limit of series for each station, and of points. chosen: eight segments with 125 gauges of three channels each have 3,000. Each view keeps the latest
/// reading of all series, so a station that invents names must not fill the memory.
const MAX_SERIES_OF_STATION: i64 = 10_000;

/// The texts of a point beyond this number are deleted, the oldest first: a station that invents values must not fill the disk. chosen
const MAX_TEXTS_OF_POINT: i64 = 1_000;

/// Deletes the texts of the points of this transaction beyond [`MAX_TEXTS_OF_POINT`].
const LIMIT_TEXTS: &str = "DELETE FROM profivac_data.point_text AS known USING (
        SELECT point, value, row_number() OVER (PARTITION BY point ORDER BY epoch DESC, batch DESC, value) AS number
        FROM profivac_data.point_text WHERE point IN (SELECT point FROM stage_point_text)
    ) AS counted
    WHERE known.point = counted.point AND known.value = counted.value AND counted.number > $1";

/// Size limit of the table of rejected batches in bytes, and how many rejections pass before it is checked again. Older ones are deleted.
const MAX_REJECTED_OCTETS: i64 = 1 << 30;
const REJECTED_BETWEEN_COUNTS: u64 = 1_000;

/// A station forgets a batch after the commit, so a commit waits for the disk, whatever the settings of the server and the role are.
const DURABLE: &str = "SELECT set_config('synchronous_commit', 'on', false) WHERE current_setting('synchronous_commit') IN ('off', 'local')";

/// The file of the table of series. Reading a row keeps the table until the end of the transaction.
const TABLES: &str =
    "SELECT pg_relation_filenode('profivac_data.series'), (SELECT 1 FROM profivac_data.series LIMIT 1)";

/// Roles that may select from the views and are readers of no plant. A superuser reads all, as the owner of the tables does.
const WITHOUT_ROWS: &str = "
    SELECT rolname::text FROM pg_roles AS reading
    WHERE NOT rolsuper AND rolname !~ '^pg_' AND has_schema_privilege(reading.oid, 'profivac', 'USAGE')
        AND has_table_privilege(reading.oid, 'profivac.station', 'SELECT')
        AND NOT pg_has_role(reading.oid, (SELECT relowner FROM pg_class WHERE oid = 'profivac_data.station'::regclass), 'member')
        AND NOT EXISTS (SELECT FROM profivac_data.reader JOIN pg_roles AS given ON given.rolname = reader.role
            WHERE pg_has_role(reading.oid, given.oid, 'member'))
    ORDER BY 1";

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
    /// A station has too many points.
    #[error(
        "the station has {MAX_SERIES_OF_STATION} points already, and {0:?} is another one: delete in profivac_data.point those that it no longer has"
    )]
    TooManyPoints(String),
    /// A backup was restored while the archive ran: the ids in memory belong to other stations and series.
    #[error("the tables of the database were made anew, as a restoration does: the archive reads them again")]
    Replaced,
}

/// The classes of SQL states that the rows themselves cause, so that the same rows fail again: two rows with one key, a value without a
/// form, one that breaks a constraint, one that is too large for an index.
const OF_ROWS: [&str; 4] = ["21", "22", "23", "54"];

impl StoreError {
    /// Whether a row was there that was not expected.
    fn is_of_repetition(&self) -> bool {
        matches!(self, Self::Database(error) if error.code() == Some(&SqlState::UNIQUE_VIOLATION))
    }

    /// Whether the rows themselves are the cause.
    fn is_of_rows(&self) -> bool {
        match self {
            Self::TooManySeries(_) | Self::TooManyPoints(_) => true,
            Self::Database(error) => error.code().is_some_and(is_of_rows),
            Self::Connect(_) | Self::Schema(_) | Self::Replaced => false,
        }
    }

    /// The reason for which a batch is put aside, in a word.
    const fn word(&self) -> &'static str {
        match self {
            Self::TooManySeries(_) => "too_many_series",
            Self::TooManyPoints(_) => "too_many_points",
            Self::Database(_) | Self::Connect(_) | Self::Schema(_) | Self::Replaced => "refused_by_database",
        }
    }

    /// The SQL state of the refusal, if the database has given one.
    #[must_use]
    pub fn state(&self) -> Option<&str> {
        let error = match self {
            Self::Database(error) | Self::Schema(SchemaError::Database(error)) => error,
            Self::Connect(ConnectError::Refused(error)) => error,
            _ => return None,
        };
        error.code().map(SqlState::code)
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
    /// The databases that are not the one of the station.
    refused: Vec<i64>,
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
        if self.refused.contains(&batch.epoch) {
            return Some(Refusal::NotChosen { station: station() });
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
    /// The ids of points, by station.
    points: HashMap<(i32, BatchPoint), i32>,
    /// The databases of stations that the database knows, by station and epoch.
    epochs: HashSet<(i32, i64)>,
    /// The file of the table of series, by which tables that were made anew are noticed.
    tables: Option<u32>,
    /// The days that have a partition.
    days: HashSet<i64>,
    samples_days: u32,
    /// The batches that were put aside since these were counted.
    rejected: u64,
    /// The stations and kinds of reasons that were reported in the last hour, and sentences to report.
    reported: HashSet<(String, Option<Discriminant<Refusal>>)>,
    reports: Vec<String>,
    metrics: Metrics,
}

impl Drop for Store {
    fn drop(&mut self) {
        self.connection.abort();
    }
}

impl Store {
    /// Connects, brings the tables up to date, and sets readers as the file says.
    ///
    /// # Errors
    /// [`StoreError`] when the database cannot be reached or refuses, or its tables are of a newer program.
    pub async fn open(database: &Database, samples_days: u32, plants: &[Plant]) -> Result<Self, StoreError> {
        let mut store = Self::connect(database, samples_days).await?;
        store.set_readers(plants).await?;
        Ok(store)
    }

    /// Connects and brings the tables up to date.
    ///
    /// # Errors
    /// [`StoreError`] when the database cannot be reached, or its tables are of a newer program.
    pub async fn connect(database: &Database, samples_days: u32) -> Result<Self, StoreError> {
        let (mut client, connection) = database.connect().await?;
        upgrade(&mut client).await?;
        // The second: a statement after a lock sees what was committed before the lock was free.
        client
            .batch_execute("SET statement_timeout = '120s'; SET default_transaction_isolation = 'read committed'")
            .await?;
        client.execute(DURABLE, &[]).await?;
        prepare::<SampleRow>(&client).await?;
        prepare::<SpanRow>(&client).await?;
        prepare::<PointSampleRow>(&client).await?;
        prepare::<PointSpanRow>(&client).await?;
        prepare::<PointTextRow>(&client).await?;
        prepare::<StationRow<Event>>(&client).await?;
        prepare::<StationRow<AlarmChange>>(&client).await?;
        prepare::<StationRow<Audit>>(&client).await?;
        let tables = client.query_one(TABLES, &[]).await?.get(0);
        let (series, points, epochs, days) = (HashMap::new(), HashMap::new(), HashSet::new(), HashSet::new());
        let (reported, reports) = (HashSet::new(), Vec::new());
        let store = Self {
            client,
            connection,
            series,
            points,
            epochs,
            tables,
            days,
            samples_days,
            rejected: 0,
            reported,
            reports,
            metrics: Metrics::default(),
        };
        Ok(store)
    }

    /// Lets the store count in `metrics`.
    #[must_use]
    pub fn counting(mut self, metrics: &Metrics) -> Self {
        self.metrics = metrics.clone();
        self
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

    /// The roles to which the views show nothing, in a sentence; `None` without one.
    ///
    /// # Errors
    /// [`StoreError`] when the database refuses.
    pub async fn roles_without_rows(&self) -> Result<Option<String>, StoreError> {
        let rows = self.client.query(WITHOUT_ROWS, &[]).await?;
        let roles: Vec<String> = rows.iter().map(|row| row.get(0)).collect();
        let sentence = || {
            let roles = roles.join(", ");
            format!(
                "the views of profivac have no rows for {roles}: they may select from them and are readers of no plant; add them to readers of a \
                 [[plant]], or REVOKE USAGE ON SCHEMA profivac"
            )
        };
        Ok((!roles.is_empty()).then(sentence))
    }

    /// Makes the partitions of the next days, and forgets old batches.
    ///
    /// # Errors
    /// [`StoreError`] when the database refuses.
    pub async fn maintain(&mut self, now: Micros) -> Result<(), StoreError> {
        let today = now.0.div_euclid(DAY);
        self.add_days((today..today.saturating_add(4)).collect()).await?;
        // An administrator may have dropped partitions and deleted series.
        self.days.clear();
        self.series.clear();
        self.points.clear();
        self.epochs.clear();
        self.reported.clear();
        // Gaps are noted before the batches around them are forgotten.
        self.find_gaps().await?;
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
        reject(&transaction, message, &refusal.to_string(), false).await?;
        transaction.commit().await?;
        self.metrics.rejected(of_subject(&message.subject).map(|(_, station)| station), refusal.word());
        self.report(message, None, &refusal.to_string());
        Ok(Stored { rejected: 1, ..Stored::default() })
    }

    /// Notes a sentence about a batch that was put aside, unless there was one about its station with such a reason.
    fn report(&mut self, message: &Incoming, kind: Option<Discriminant<Refusal>>, reason: &str) {
        let of = of_subject(&message.subject).map_or("an unknown station", |(_, station)| station);
        if self.reported.len() < MAX_REPORTED && self.reported.insert((of.to_owned(), kind)) {
            let later = "later ones for this reason are reported once an hour; profivac_data.rejected has them";
            self.reports.push(format!("a batch of {of} is put aside: {reason}; {later}"));
        }
    }

    /// The sentences about batches that were put aside since the last call.
    pub fn take_reports(&mut self) -> Vec<String> {
        std::mem::take(&mut self.reports)
    }

    /// Stores the first messages in one transaction. Returns how many messages that were.
    async fn store_together(&mut self, messages: &[Incoming], now: Micros) -> Result<(Stored, usize), StoreError> {
        let begun = Instant::now();
        let (decoded, mut rejected) = decode(messages, now);
        let taken = decoded.len().saturating_add(rejected.len());
        let mut stations = self.stations(&decoded).await?;
        let mut of_stations = Vec::new();
        for (message, batch) in decoded {
            let Some(station) = stations.get_mut(batch.station) else { continue };
            match station.refusal(&batch) {
                Some(reason) => rejected.push((message, reason)),
                None => of_stations.push((message, station.id, batch)),
            }
        }
        let mut made = self.known_times(&of_stations).await?;
        let way = if made.is_empty() { Way::Straight } else { Way::Compared };
        let (mut batches, mut copied) = (Vec::new(), Vec::new());
        for (message, station, batch) in of_stations {
            let key = (station, batch.epoch, batch.number);
            match *made.entry(key).or_insert(batch.batch.made_us) == batch.batch.made_us {
                true => batches.push((station, batch)),
                false => {
                    copied.push(key);
                    rejected.push((message, Refusal::Copied { number: batch.number }));
                }
            }
        }
        batches.sort_unstable_by_key(|(station, batch)| (*station, batch.epoch, batch.number));
        // Two archives count what they put aside in the same order, and do not wait for each other in a circle.
        rejected.sort_by(|(one, _), (other, _)| one.subject.cmp(&other.subject));
        copied.sort_unstable();
        self.add_epochs(&batches).await?;
        let rows = self.rows(&batches, now).await?;
        self.add_days(rows.days()).await?;
        let stations = stations.into_values().filter(|station| station.is_new_epoch);
        let epochs = stations.map(|station| (station.id, station.epoch)).collect();
        let changes = Changes { rows, epochs, copied, rejected };
        let counts = match self.commit(&changes, way).await {
            // A copy of a database of a station, or a batch that another archive has just stored.
            Err(error) if error.is_of_repetition() => self.commit(&changes, Way::Compared).await,
            counts => counts,
        }?;
        let rejected = changes.rejected;
        self.metrics.committed(&counts, begun.elapsed());
        for (_, batch) in &batches {
            self.metrics.stored(batch.plant, batch.station, Micros(batch.batch.made_us), Micros::now());
        }
        for (message, reason) in &rejected {
            self.metrics.rejected(of_subject(&message.subject).map(|(_, station)| station), reason.word());
            self.report(message, Some(discriminant(reason)), &reason.to_string());
        }
        let samples = batches.iter().map(|(_, batch)| batch.batch.sample_count() as u64).sum();
        Ok((Stored { batches: batches.len() as u64, samples, rejected: rejected.len() as u64 }, taken))
    }

    /// Stores all changes, or none.
    async fn commit(&mut self, changes: &Changes<'_>, way: Way) -> Result<metrics::Transaction, StoreError> {
        let transaction = self.client.transaction().await?;
        if transaction.query_one(TABLES, &[]).await?.get::<_, Option<u32>>(0) != self.tables {
            return Err(StoreError::Replaced);
        }
        let counts = changes.rows.insert(&transaction, way).await?;
        for (id, epoch) in &changes.epochs {
            let sql = "UPDATE profivac_data.station SET epoch = greatest(epoch, $2) WHERE id = $1";
            transaction.execute(sql, &[id, epoch]).await?;
        }
        for (station, epoch, number) in &changes.copied {
            let sql = "UPDATE profivac_data.epoch SET copied = least(copied, $3) WHERE station = $1 AND epoch = $2";
            transaction.execute(sql, &[station, epoch, number]).await?;
        }
        for (message, reason) in &changes.rejected {
            reject(&transaction, message, &reason.to_string(), reason.competes()).await?;
        }
        transaction.commit().await?;
        Ok(counts)
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
        let sql = "SELECT name, id, plant, epoch,
                ARRAY(SELECT epoch.epoch FROM profivac_data.epoch WHERE epoch.station = station.id AND refused) AS refused
            FROM profivac_data.station WHERE name = ANY($1)";
        let station = |row: tokio_postgres::Row| {
            let (id, plant, epoch, refused) = (row.get(1), row.get(2), row.get(3), row.get(4));
            let station = Station { id, plant, epoch, refused, is_new_epoch: false };
            (row.get(0), station)
        };
        Ok(self.client.query(sql, &[&names]).await?.into_iter().map(station).collect())
    }

    /// When the batches with these numbers were made that are stored already. A batch with the same number and another time is another one: a copy of the database
    /// gives numbers again.
    async fn known_times(
        &self,
        batches: &[(&Incoming, i32, Accepted<'_>)],
    ) -> Result<HashMap<(i32, i64, i64), i64>, StoreError> {
        let sql = "SELECT batch.station, batch.epoch, batch.number, (extract(epoch FROM batch.made) * 1000000)::bigint
            FROM unnest($1::integer[], $2::bigint[], $3::bigint[]) AS given (station, epoch, number)
            JOIN profivac_data.batch USING (station, epoch, number)";
        let stations: Vec<_> = batches.iter().map(|(_, station, _)| *station).collect();
        let epochs: Vec<_> = batches.iter().map(|(_, _, batch)| batch.epoch).collect();
        let numbers: Vec<_> = batches.iter().map(|(_, _, batch)| batch.number).collect();
        let rows = self.client.query(sql, &[&stations, &epochs, &numbers]).await?;
        Ok(rows.iter().map(|row| ((row.get(0), row.get(1), row.get(2)), row.get(3))).collect())
    }

    /// Adds the databases of these batches that are new. Outside of the transaction, as the series.
    async fn add_epochs(&mut self, batches: &[(i32, Accepted<'_>)]) -> Result<(), StoreError> {
        for (station, batch) in batches {
            let key = (*station, batch.epoch);
            if self.epochs.contains(&key) {
                continue;
            }
            // An older program does not say which number is the first one. The batches are in the order of their numbers.
            let of_station = Some(batch.batch.first_number).filter(|first| (1..=batch.number).contains(first));
            let settled = of_station.unwrap_or(batch.number).saturating_sub(1);
            let is_copy = of_station.is_some_and(|first| first > 1);
            let add = "INSERT INTO profivac_data.epoch (station, epoch, settled, is_copy) VALUES ($1, $2, $3, $4) ON CONFLICT DO NOTHING";
            self.client.execute(add, &[station, &batch.epoch, &settled, &is_copy]).await?;
            if self.epochs.len() >= MAX_SERIES {
                self.epochs.clear();
            }
            self.epochs.insert(key);
        }
        Ok(())
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

    /// The id of a point, in the same way.
    async fn point_id(&mut self, station: i32, point: &BatchPoint) -> Result<i32, StoreError> {
        let [slave, name, unit, kind] = [&point.slave, &point.name, &point.unit, &point.kind].map(|word| text(word));
        let key = (station, BatchPoint { slave, name, unit, kind });
        if let Some(id) = self.points.get(&key) {
            return Ok(*id);
        }
        let BatchPoint { slave, name, unit, kind } = &key.1;
        let add = "INSERT INTO profivac_data.point (station, slave, name, unit, kind)
            SELECT $1::integer, $2::text, $3::text, $4::text, $5::text
            WHERE (SELECT count(*) FROM profivac_data.point WHERE station = $1) < $6::bigint ON CONFLICT DO NOTHING";
        self.client.execute(add, &[&station, slave, name, unit, kind, &MAX_SERIES_OF_STATION]).await?;
        let select = "SELECT id FROM profivac_data.point
            WHERE station = $1 AND slave = $2 AND name = $3 AND unit = $4 AND kind = $5";
        let found = self.client.query_opt(select, &[&station, slave, name, unit, kind]).await?;
        let id = found.ok_or_else(|| StoreError::TooManyPoints(format!("{slave}.{name}")))?.get(0);
        if self.points.len() >= MAX_SERIES {
            self.points.clear();
        }
        self.points.insert(key, id);
        Ok(id)
    }

    /// The rows of batches: all samples within the retention, and of several spans with the same key the last one.
    async fn rows(&mut self, batches: &[(i32, Accepted<'_>)], now: Micros) -> Result<Rows, StoreError> {
        let oldest = now.0.div_euclid(DAY).saturating_sub(i64::from(self.samples_days)).saturating_mul(DAY);
        let mut rows = Rows::default();
        let (mut spans, mut point_spans, mut point_texts) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        for (station, batch) in batches {
            let mut expired = 0_usize;
            for (name, samples) in &batch.samples {
                let series = self.series_id(*station, name).await?;
                let before = rows.samples.len();
                let kept = samples.iter().filter(|sample| sample.at.0 >= oldest);
                rows.samples.extend(kept.map(|sample| SampleRow { series, sample: *sample }));
                expired += samples.len().saturating_sub(rows.samples.len().saturating_sub(before));
            }
            for (point, samples) in &batch.points {
                let point = self.point_id(*station, point).await?;
                let before = rows.point_samples.len();
                let kept = samples.iter().filter(|sample| sample.at.0 >= oldest);
                rows.point_samples.extend(kept.map(|sample| PointSampleRow { point, sample: *sample }));
                expired += samples.len().saturating_sub(rows.point_samples.len().saturating_sub(before));
            }
            for span in &batch.batch.point_spans {
                let point = self.point_id(*station, &span.point).await?;
                let key = (point, span.level, span.start_us, batch.epoch);
                let row = PointSpanRow { point, epoch: batch.epoch, batch: batch.number, span: span.clone() };
                point_spans.insert(key, row);
            }
            for row in &batch.batch.point_texts {
                let point = self.point_id(*station, &row.point).await?;
                // -0 and 0 are one key of the table.
                let value = row.value + 0.0;
                let row = PointTextRow { point, value, text: text(&row.text), epoch: batch.epoch, batch: batch.number };
                // The batches are in the order of their numbers.
                point_texts.insert((point, value.to_bits()), row);
            }
            for span in &batch.batch.spans {
                let series = self.series_id(*station, &text(&span.series)).await?;
                let key = (series, span.level, span.start_us, batch.epoch);
                // The batches are in the order of their numbers.
                spans.insert(key, SpanRow { series, epoch: batch.epoch, batch: batch.number, span: span.clone() });
            }
            rows.add_lists(*station, batch, expired);
        }
        samples::sort(&mut rows.samples);
        samples::sort(&mut rows.point_samples);
        rows.spans = spans.into_values().collect();
        rows.point_spans = point_spans.into_values().collect();
        rows.point_texts = point_texts.into_values().collect();
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

/// What a transaction changes.
struct Changes<'a> {
    rows: Rows,
    /// The stations with a later epoch.
    epochs: Vec<(i32, i64)>,
    /// The batches whose numbers were given twice: station, epoch, number.
    copied: Vec<(i32, i64, i64)>,
    /// The batches that are put aside.
    rejected: Vec<Of<'a, Refusal>>,
}

/// The rows of a transaction.
#[derive(Default)]
struct Rows {
    samples: Vec<SampleRow>,
    spans: Vec<SpanRow>,
    point_samples: Vec<PointSampleRow>,
    point_spans: Vec<PointSpanRow>,
    point_texts: Vec<PointTextRow>,
    events: Vec<StationRow<Event>>,
    alarms: Vec<StationRow<AlarmChange>>,
    audit: Vec<StationRow<Audit>>,
    batches: Vec<BatchRow>,
}

impl Rows {
    /// The days of all samples, since 1970.
    fn days(&self) -> BTreeSet<i64> {
        let of_points = self.point_samples.iter().map(|row| row.sample.at);
        self.samples.iter().map(|row| row.sample.at).chain(of_points).map(day_of).collect()
    }

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

    /// Stores the rows. Returns how many were stored.
    async fn insert(&self, transaction: &Transaction<'_>, way: Way) -> Result<metrics::Transaction, StoreError> {
        let mut counts = BTreeMap::new();
        let packed = samples::packed_days(transaction, &self.days()).await?;
        let way = if packed.is_empty() { way } else { Way::Compared };
        put_samples(transaction, &self.samples, way, &packed, &mut counts).await?;
        put(transaction, &self.spans, &mut counts).await?;
        put_samples(transaction, &self.point_samples, way, &packed, &mut counts).await?;
        put(transaction, &self.point_spans, &mut counts).await?;
        put(transaction, &self.point_texts, &mut counts).await?;
        if !self.point_texts.is_empty() {
            transaction.execute(LIMIT_TEXTS, &[&MAX_TEXTS_OF_POINT]).await?;
        }
        if !self.spans.is_empty() {
            transaction.execute(&copies::poorer_spans("span", "series"), &[]).await?;
        }
        if !self.point_spans.is_empty() {
            transaction.execute(&copies::poorer_spans("point_span", "point"), &[]).await?;
        }
        put(transaction, &self.events, &mut counts).await?;
        put(transaction, &self.alarms, &mut counts).await?;
        put(transaction, &self.audit, &mut counts).await?;
        let lists = [("event", self.events.len()), ("alarm", self.alarms.len()), ("audit", self.audit.len())];
        for (table, _) in lists.into_iter().filter(|(_, rows)| *rows > 0) {
            transaction.execute(&copies::earlier_rows(table), &[]).await?;
        }
        let batches = insert_batches(transaction, &self.batches).await?;
        let repeated = (self.batches.len() as u64).saturating_sub(batches);
        let expired = self.batches.iter().map(|row| u64::try_from(row.expired).unwrap_or(0)).sum();
        Ok(metrics::Transaction { batches, repeated, rows: counts, expired })
    }
}

/// Inserts rows, and notes how many were stored.
async fn put<R: Row>(
    transaction: &Transaction<'_>,
    rows: &[R],
    counts: &mut BTreeMap<&'static str, u64>,
) -> Result<(), StoreError> {
    let stored = insert(transaction, rows).await?;
    if !rows.is_empty() {
        counts.insert(R::TABLE, stored);
    }
    Ok(())
}

/// Stores samples, and notes how many are new.
async fn put_samples<R: SampleOf>(
    transaction: &Transaction<'_>,
    rows: &[R],
    way: Way,
    packed: &[(String, i64)],
    counts: &mut BTreeMap<&'static str, u64>,
) -> Result<(), StoreError> {
    let stored = samples::insert(transaction, rows, way, packed).await?;
    if !rows.is_empty() {
        counts.insert(R::TABLE, stored);
    }
    Ok(())
}

/// The day of a time (UTC), since 1970.
fn day_of(at: Micros) -> i64 {
    at.0.div_euclid(DAY)
}

fn day_number(day: i64) -> i32 {
    i32::try_from(day).unwrap_or(i32::MAX)
}

async fn reject(
    transaction: &Transaction<'_>,
    message: &Incoming,
    reason: &str,
    competes: bool,
) -> Result<(), StoreError> {
    let station = of_subject(&message.subject).map(|(_, station)| station);
    let (epoch, number) = station.and_then(|station| of_message_id(&message.id, station)).unzip();
    let sql =
        "INSERT INTO profivac_data.rejected (subject, message_id, reason, payload, station, epoch, number, competes)
        VALUES ($1, $2, $3, $4, $5, $6, $7, $8) ON CONFLICT DO NOTHING";
    let (subject, id, reason) = (text(&message.subject), text(&message.id), text(reason));
    let values: &[&(dyn ToSql + Sync)] =
        &[&subject, &id, &reason, &message.payload, &station, &epoch, &number, &competes];
    let is_new = transaction.execute(sql, values).await? > 0;
    let Some(station) = station.filter(|_| is_new) else { return Ok(()) };
    let count = "INSERT INTO profivac_data.put_aside AS known (station, count, at, reason) VALUES ($1, 1, clock_timestamp(), $2)
        ON CONFLICT (station) DO UPDATE SET count = known.count + 1, at = excluded.at, reason = excluded.reason";
    transaction.execute(count, &[&station, &reason]).await?;
    Ok(())
}
