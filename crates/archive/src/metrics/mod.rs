//! What an archive counts about itself, as metrics for Prometheus.
//!
//! An archive counts what it does itself. What the database and the stream have is the same in the metrics of each archive.

mod server;
mod text;

pub use server::{Server, check, stream};

use profivac_recorder::Micros;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The most stations and reasons that are counted for themselves: a user who invents names must not fill the memory.
const MAX_REJECTED: usize = 1_000;

/// The station of further ones, and of subjects that name none.
const OTHER: &str = "other";

/// The upper bounds of the histograms in seconds. chosen: a transaction takes from some milliseconds to the minute after which a station
/// over HTTPS gives up.
const BOUNDS: [f64; 13] = [0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 60.0];

/// The rows of a transaction.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Transaction {
    /// Batches that are stored now.
    pub batches: u64,
    /// Batches that were stored before.
    pub repeated: u64,
    /// Rows that are stored now, by table.
    pub rows: BTreeMap<&'static str, u64>,
    /// Samples that were older than the retention.
    pub expired: u64,
}

/// What the database has of a station.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StationFigures {
    /// Batches whose numbers have not come.
    pub missing: u64,
    /// Batches that were put aside.
    pub rejected: u64,
    /// When its last batch was stored, by the clock of the database.
    pub stored: Option<Micros>,
    /// When its last batch was made, by the clock of the station.
    pub made: Option<Micros>,
}

/// What waits in the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamFigures {
    /// Batches.
    pub batches: u64,
    /// Their octets.
    pub octets: u64,
    /// The most octets that the stream takes.
    pub limit: i64,
    /// When the stream took the oldest one.
    pub oldest: Option<Micros>,
}

/// What sends batches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Transport {
    /// JetStream.
    Nats,
    /// Stations.
    Https,
}

impl Transport {
    const fn word(self) -> &'static str {
        match self {
            Self::Nats => "nats",
            Self::Https => "https",
        }
    }
}

/// A count of durations.
#[derive(Clone, Copy, Debug, Default)]
struct Histogram {
    /// Those up to each bound, and above the one before.
    counts: [u64; BOUNDS.len()],
    count: u64,
    sum: f64,
}

impl Histogram {
    fn add(&mut self, seconds: f64) {
        let bucket = BOUNDS.iter().position(|bound| seconds <= *bound);
        if let Some(count) = bucket.and_then(|bucket| self.counts.get_mut(bucket)) {
            *count = count.saturating_add(1);
        }
        self.count = self.count.saturating_add(1);
        self.sum += seconds;
    }
}

/// The partitions of samples that are older than the retention.
#[derive(Clone, Copy, Debug, Default)]
struct Retention {
    last: Option<Micros>,
    next: Option<Micros>,
    dropped: u64,
    waiting: u64,
    timeouts: u64,
}

/// What a look at the retention has found.
#[derive(Clone, Copy, Debug)]
pub struct Retained {
    /// When it was.
    pub last: Micros,
    /// When the next one is.
    pub next: Micros,
    /// How many partitions were dropped.
    pub dropped: u64,
    /// How many that are older stay.
    pub waiting: u64,
    /// How many were not dropped because a reader held a lock.
    pub timeouts: u64,
}

#[derive(Debug, Default)]
struct Counts {
    is_up: BTreeMap<Transport, bool>,
    sum: Transaction,
    rejected: BTreeMap<(String, &'static str), u64>,
    stations: BTreeMap<(String, String), StationFigures>,
    transactions: Histogram,
    answers: Histogram,
    stream: Option<StreamFigures>,
    retention: Retention,
    database_errors: BTreeMap<String, u64>,
    nats_errors: u64,
}

/// The metrics of an archive. Clones share them.
#[derive(Clone, Debug, Default)]
pub struct Metrics(Arc<Mutex<Counts>>);

impl Metrics {
    fn lock(&self) -> MutexGuard<'_, Counts> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes whether batches of this transport are taken.
    pub fn is_up(&self, transport: Transport, is_up: bool) {
        self.lock().is_up.insert(transport, is_up);
    }

    /// Counts a transaction that is committed.
    pub fn committed(&self, transaction: &Transaction, lasted: Duration) {
        let mut counts = self.lock();
        counts.transactions.add(lasted.as_secs_f64());
        let sum = &mut counts.sum;
        sum.batches = sum.batches.saturating_add(transaction.batches);
        sum.repeated = sum.repeated.saturating_add(transaction.repeated);
        sum.expired = sum.expired.saturating_add(transaction.expired);
        for (table, rows) in &transaction.rows {
            let known = sum.rows.entry(table).or_default();
            *known = known.saturating_add(*rows);
        }
    }

    /// Notes that a batch of a station is stored.
    pub fn stored(&self, plant: &str, station: &str, made: Micros, now: Micros) {
        let mut counts = self.lock();
        // A name that the database does not know yet comes with the next look at it.
        if let Some(known) = counts.stations.get_mut(&(plant.to_owned(), station.to_owned())) {
            (known.made, known.stored) = (known.made.max(Some(made)), known.stored.max(Some(now)));
        }
    }

    /// Counts a batch that is put aside.
    pub fn rejected(&self, station: Option<&str>, reason: &'static str) {
        let mut counts = self.lock();
        let key = (station.unwrap_or(OTHER).to_owned(), reason);
        let is_known = counts.rejected.len() < MAX_REJECTED || counts.rejected.contains_key(&key);
        let key = if is_known { key } else { (OTHER.to_owned(), reason) };
        let count = counts.rejected.entry(key).or_default();
        *count = count.saturating_add(1);
    }

    /// Notes what the database has of the stations, by plant and name.
    pub fn found(&self, stations: BTreeMap<(String, String), StationFigures>) {
        self.lock().stations = stations;
    }

    /// Notes what waits in the stream; `None`: the servers do not say.
    pub fn waiting(&self, stream: Option<StreamFigures>) {
        self.lock().stream = stream;
    }

    /// Counts the time from a whole batch over HTTPS to its answer after the commit.
    pub fn answered(&self, lasted: Duration) {
        self.lock().answers.add(lasted.as_secs_f64());
    }

    /// Notes a look at the retention.
    pub fn retained(&self, look: Retained) {
        let retention = &mut self.lock().retention;
        (retention.last, retention.next, retention.waiting) = (Some(look.last), Some(look.next), look.waiting);
        retention.dropped = retention.dropped.saturating_add(look.dropped);
        retention.timeouts = retention.timeouts.saturating_add(look.timeouts);
    }

    /// Counts an error of the database by its SQL state, `none` without one.
    pub fn database_failed(&self, state: Option<&str>) {
        let mut counts = self.lock();
        let count = counts.database_errors.entry(state.unwrap_or("none").to_owned()).or_default();
        *count = count.saturating_add(1);
    }

    /// Counts an error of the servers of NATS.
    pub fn nats_failed(&self) {
        let mut counts = self.lock();
        counts.nats_errors = counts.nats_errors.saturating_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_web_server::exposition::Format;

    /// The lines of a metric.
    fn samples(metrics: &Metrics, name: &str) -> Vec<String> {
        let text = metrics.text(Format::OpenMetrics);
        let of = |line: &&str| line.split(['{', ' ']).next() == Some(name);
        text.lines().filter(of).map(str::to_owned).collect()
    }

    #[test]
    fn batches_and_rows_are_counted_and_a_repetition_for_itself() {
        let metrics = Metrics::default();
        let rows = BTreeMap::from([("sample", 7), ("event", 1)]);
        let first = Transaction { batches: 2, repeated: 0, rows, expired: 3 };
        metrics.committed(&first, Duration::from_millis(7));
        metrics.committed(&Transaction { repeated: 1, ..Transaction::default() }, Duration::from_secs(2));
        assert_eq!(samples(&metrics, "profivac_archive_batches_total"), ["profivac_archive_batches_total 2"]);
        let repeated = samples(&metrics, "profivac_archive_repeated_batches_total");
        assert_eq!(repeated, ["profivac_archive_repeated_batches_total 1"]);
        assert_eq!(
            samples(&metrics, "profivac_archive_rows_total"),
            ["profivac_archive_rows_total{table=\"event\"} 1", "profivac_archive_rows_total{table=\"sample\"} 7"]
        );
        let expired = samples(&metrics, "profivac_archive_expired_samples_total");
        assert_eq!(expired, ["profivac_archive_expired_samples_total 3"]);
        let buckets = samples(&metrics, "profivac_archive_transaction_duration_seconds_bucket");
        let bucket = |bound: &str| buckets.iter().find(|line| line.contains(&format!("le=\"{bound}\""))).unwrap();
        assert!(bucket("0.005").ends_with(" 0") && bucket("0.01").ends_with(" 1"), "{buckets:?}");
        assert!(bucket("1.0").ends_with(" 1") && bucket("2.5").ends_with(" 2") && bucket("+Inf").ends_with(" 2"));
        let sum = samples(&metrics, "profivac_archive_transaction_duration_seconds_sum");
        assert_eq!(sum, ["profivac_archive_transaction_duration_seconds_sum 2.007"]);
    }

    #[test]
    fn a_station_has_its_missing_numbers_and_the_time_of_its_last_batch() {
        let metrics = Metrics::default();
        let key = ("hall".to_owned(), "hall-1".to_owned());
        let figures =
            StationFigures { missing: 5, rejected: 2, stored: Some(Micros(9_500_000)), made: Some(Micros(8_000_000)) };
        metrics.found(BTreeMap::from([(key, figures)]));
        metrics.stored("hall", "invented", Micros(1), Micros(1));
        let labels = "plant=\"hall\",station=\"hall-1\"";
        let missing = samples(&metrics, "profivac_archive_station_missing_batches");
        assert_eq!(missing, [format!("profivac_archive_station_missing_batches{{{labels}}} 5")]);
        let last = "profivac_archive_station_last_batch_timestamp_seconds";
        assert_eq!(samples(&metrics, last), [format!("{last}{{{labels}}} 9.500000")]);
        metrics.stored("hall", "hall-1", Micros(7_000_000), Micros(11_000_000));
        assert_eq!(samples(&metrics, last), [format!("{last}{{{labels}}} 11.000000")]);
        let made = "profivac_archive_station_last_batch_made_timestamp_seconds";
        assert_eq!(samples(&metrics, made), [format!("{made}{{{labels}}} 8.000000")], "a batch that came late");
    }

    #[test]
    fn invented_stations_do_not_fill_the_memory() {
        let metrics = Metrics::default();
        metrics.rejected(Some("hall-1"), "copied");
        metrics.rejected(None, "subject");
        for number in 0..2 * MAX_REJECTED {
            metrics.rejected(Some(&format!("s{number}")), "copied");
        }
        metrics.rejected(Some("hall-1"), "copied");
        let name = "profivac_archive_rejected_batches_total";
        let all = samples(&metrics, name);
        assert!(all.len() <= MAX_REJECTED + 1, "{}", all.len());
        assert!(all.contains(&format!("{name}{{station=\"hall-1\",reason=\"copied\"}} 2")));
        assert!(all.contains(&format!("{name}{{station=\"other\",reason=\"subject\"}} 1")));
        let others = all.iter().find(|line| line.contains("station=\"other\",reason=\"copied\"")).unwrap();
        assert_eq!(others.split(' ').next_back().unwrap().parse::<usize>().unwrap(), MAX_REJECTED + 2);
    }

    #[test]
    fn the_stream_is_absent_while_its_servers_do_not_answer() {
        let metrics = Metrics::default();
        let stream = StreamFigures { batches: 7, octets: 4_000, limit: 10_000, oldest: Some(Micros(5_250_000)) };
        metrics.waiting(Some(stream));
        let oldest = "profivac_archive_stream_oldest_batch_timestamp_seconds";
        assert_eq!(samples(&metrics, oldest), [format!("{oldest} 5.250000")]);
        metrics.waiting(None);
        assert_eq!(samples(&metrics, oldest), [] as [String; 0]);
        assert_eq!(samples(&metrics, "profivac_archive_stream_batches"), [] as [String; 0]);
    }
}
