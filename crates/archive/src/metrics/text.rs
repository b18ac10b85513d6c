//! The text of a scrape.

use super::{BOUNDS, Counts, Histogram, Metrics, Retention, StationFigures, StreamFigures};
use profivac_recorder::Micros;
use profivac_web_server::exposition::{Exposition, Format, MetricKind, Number, put_label};
use std::fmt::Display;

/// The octets that a text probably has, without the stations, and those of a station.
const OCTETS: usize = 8 << 10;
const OCTETS_OF_STATION: usize = 512;

/// The name, the help and the value of a metric of each station.
type OfStation<T> = (&'static str, &'static str, fn(&StationFigures) -> T);

/// The time of an event as Prometheus writes it.
struct Seconds(Micros);

impl Display for Seconds {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Micros(us) = self.0;
        write!(formatter, "{}.{:06}", us.div_euclid(Micros::SECOND), us.rem_euclid(Micros::SECOND))
    }
}

impl Metrics {
    /// The present text.
    #[must_use]
    pub fn text(&self, format: Format) -> String {
        let counts = self.lock();
        let capacity = OCTETS.saturating_add(counts.stations.len().saturating_mul(OCTETS_OF_STATION));
        let mut text = Exposition::new(format, capacity);
        text.family("profivac_archive", MetricKind::Info, None, "The archive");
        text.sample("profivac_archive_info", &labels(&[("version", env!("CARGO_PKG_VERSION"))]), 1);
        put_work(&mut text, &counts);
        put_stations(&mut text, &counts);
        put_histogram(
            &mut text,
            "profivac_archive_transaction_duration_seconds",
            "Durations of the transactions that store batches",
            &counts.transactions,
        );
        put_histogram(
            &mut text,
            "profivac_archive_answer_duration_seconds",
            "Times from a whole batch over HTTPS to its answer after the commit",
            &counts.answers,
        );
        if let Some(stream) = &counts.stream {
            put_stream(&mut text, stream);
        }
        put_retention(&mut text, counts.retention);
        drop(counts);
        text.finish()
    }
}

fn put_work(text: &mut Exposition, counts: &Counts) {
    text.family("profivac_archive_up", MetricKind::Gauge, None, "1 while batches are taken over this transport");
    for (transport, is_up) in &counts.is_up {
        text.sample("profivac_archive_up", &labels(&[("transport", transport.word())]), u8::from(*is_up));
    }
    counter(text, "profivac_archive_batches", "Batches that were stored", counts.sum.batches);
    let help = "Batches that came again after they had been stored";
    counter(text, "profivac_archive_repeated_batches", help, counts.sum.repeated);
    text.family("profivac_archive_rows", MetricKind::Counter, None, "Rows that were stored");
    for (table, rows) in &counts.sum.rows {
        text.sample("profivac_archive_rows_total", &labels(&[("table", table)]), rows);
    }
    let help = "Samples that were not stored because they are older than samples-days";
    counter(text, "profivac_archive_expired_samples", help, counts.sum.expired);
    text.family("profivac_archive_rejected_batches", MetricKind::Counter, None, "Batches that were put aside");
    for ((station, reason), count) in &counts.rejected {
        let labels = labels(&[("station", station), ("reason", reason)]);
        text.sample("profivac_archive_rejected_batches_total", &labels, count);
    }
    let help = "Errors of the database after which the archive connects again";
    text.family("profivac_archive_database_errors", MetricKind::Counter, None, help);
    for (state, count) in &counts.database_errors {
        text.sample("profivac_archive_database_errors_total", &labels(&[("sqlstate", state)]), count);
    }
    let help = "Errors of the servers of NATS after which the archive connects again";
    counter(text, "profivac_archive_nats_errors", help, counts.nats_errors);
}

fn put_stations(text: &mut Exposition, counts: &Counts) {
    let figures: [OfStation<u64>; 2] = [
        ("profivac_archive_station_missing_batches", "Batches whose numbers have not come", |it| it.missing),
        ("profivac_archive_station_rejected_batches", "Batches of the station that were put aside", |it| it.rejected),
    ];
    for (name, help, of) in figures {
        text.family(name, MetricKind::Gauge, None, help);
        for ((plant, station), figures) in &counts.stations {
            text.sample(name, &labels(&[("plant", plant), ("station", station)]), of(figures));
        }
    }
    let times: [OfStation<Option<Micros>>; 2] = [
        (
            "profivac_archive_station_last_batch_timestamp_seconds",
            "Time when the last batch of the station was stored",
            |it| it.stored,
        ),
        (
            "profivac_archive_station_last_batch_made_timestamp_seconds",
            "Time when the last batch of the station was made, by its clock",
            |it| it.made,
        ),
    ];
    for (name, help, of) in times {
        text.family(name, MetricKind::Gauge, Some("timestamp_seconds"), help);
        for ((plant, station), figures) in &counts.stations {
            if let Some(at) = of(figures) {
                text.sample(name, &labels(&[("plant", plant), ("station", station)]), Seconds(at));
            }
        }
    }
}

fn put_stream(text: &mut Exposition, stream: &StreamFigures) {
    gauge(text, "profivac_archive_stream_batches", None, "Batches that wait in the stream", stream.batches);
    let help = "Octets of the batches that wait in the stream";
    gauge(text, "profivac_archive_stream_bytes", Some("bytes"), help, stream.octets);
    let help = "Octets that the stream takes";
    gauge(text, "profivac_archive_stream_limit_bytes", Some("bytes"), help, stream.limit);
    let help = "Time when the stream took the oldest batch that waits";
    time(text, "profivac_archive_stream_oldest_batch_timestamp_seconds", help, stream.oldest);
}

fn put_retention(text: &mut Exposition, retention: Retention) {
    let Retention { last, next, dropped, waiting, timeouts } = retention;
    let help = "Time of the last look for days of samples that are older than samples-days";
    time(text, "profivac_archive_retention_last_timestamp_seconds", help, last);
    time(text, "profivac_archive_retention_next_timestamp_seconds", "Time of the next look", next);
    let help = "Partitions of a day of samples that this archive has dropped";
    counter(text, "profivac_archive_retention_dropped_partitions", help, dropped);
    let help = "Partitions of samples that are older than samples-days and stay";
    gauge(text, "profivac_archive_retention_waiting_partitions", None, help, waiting);
    let help = "Partitions that were not dropped because a reader held a lock";
    counter(text, "profivac_archive_retention_lock_timeouts", help, timeouts);
}

fn counter(text: &mut Exposition, name: &str, help: &str, value: u64) {
    text.family(name, MetricKind::Counter, None, help);
    text.sample(&format!("{name}_total"), "", value);
}

fn gauge(text: &mut Exposition, name: &str, unit: Option<&str>, help: &str, value: impl Display) {
    text.family(name, MetricKind::Gauge, unit, help);
    text.sample(name, "", value);
}

/// A time; without one the metric has no sample.
fn time(text: &mut Exposition, name: &str, help: &str, at: Option<Micros>) {
    text.family(name, MetricKind::Gauge, Some("timestamp_seconds"), help);
    if let Some(at) = at {
        text.sample(name, "", Seconds(at));
    }
}

fn put_histogram(text: &mut Exposition, name: &str, help: &str, histogram: &Histogram) {
    text.family(name, MetricKind::Histogram, Some("seconds"), help);
    let bucket = format!("{name}_bucket");
    let mut below = 0_u64;
    for (bound, count) in BOUNDS.iter().zip(histogram.counts) {
        below = below.saturating_add(count);
        // A bound has a point in OpenMetrics.
        text.sample(&bucket, &labels(&[("le", &format!("{bound:?}"))]), below);
    }
    text.sample(&bucket, &labels(&[("le", "+Inf")]), histogram.count);
    text.sample(&format!("{name}_count"), "", histogram.count);
    text.sample(&format!("{name}_sum"), "", Number(histogram.sum));
}

fn labels(all: &[(&str, &str)]) -> String {
    let mut text = String::new();
    all.iter().for_each(|(name, value)| put_label(&mut text, name, value));
    text
}
