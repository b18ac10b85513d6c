//! The loop of an archive: take messages, store them, acknowledge them. Any number of archives share one consumer.

use crate::config::Config;
use crate::https::Server;
use crate::metrics::{self, Metrics, Transport};
use crate::packing;
pub use crate::session::{ArchiveError, Report};
use crate::session::{Maintenance, Retry, SILENCE, noticed};
use crate::store::{Incoming, SEARCH_INTERVAL, StationStatus, Store, StoreError, Stored};
use async_nats::connection::State;
use async_nats::jetstream::consumer::{AckPolicy, Consumer, pull};
use async_nats::jetstream::context::{CreateStreamError, CreateStreamErrorKind};
use async_nats::jetstream::stream::{ConsumerError, ConsumerErrorKind, DiscardPolicy, RetentionPolicy};
use async_nats::jetstream::{Context, ErrorCode, Message, stream};
use futures_util::StreamExt;
use profivac_archive_protocol::nats::{NatsError, STREAM, SUBJECTS, connect};
use profivac_archive_protocol::request::{self, Request};
use profivac_recorder::Micros;
use profivac_web_server::tables::archive::Nats;
use std::fmt::Display;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::watch;
use tokio::time::Instant;

/// The name of the consumer that all archives share.
const CONSUMER: &str = "archive";

/// The most messages of a transaction.
const MAX_MESSAGES: usize = 256;

/// The most octets of a message: a batch of a station is far shorter.
const MAX_MESSAGE_OCTETS: i32 = 768 << 10;

/// A station may have this part of the octets of the stream, with batches of the largest size. chosen.
const SHARES: i64 = 8;

/// Messages that each station may have in the stream, whatever its size: two rounds of its publisher, so that an archive never waits for
/// the station.
const LEAST_MESSAGES: i64 = 256;

/// The longest wait for the first message of a transaction.
const FETCH_TIMEOUT: Duration = Duration::from_secs(1);

/// A message that was not acknowledged comes again after this time: longer than a transaction may take.
const ACKNOWLEDGEMENT_WAIT: Duration = Duration::from_secs(30);

/// Archives until it is told to stop: from NATS if the file has it, and from `server` if there is one. It counts in `metrics`.
pub async fn run(
    config: &Config,
    server: Option<Server>,
    metrics: &Metrics,
    stop: watch::Receiver<bool>,
    report: impl FnMut(Report<'_>) + Send,
) {
    let report = Mutex::new(report);
    let noted = |transport, it: Report<'_>| {
        if matches!(it, Report::Silent(_)) {
            metrics.is_up(transport, false);
        }
        (report.lock().unwrap_or_else(PoisonError::into_inner))(it);
    };
    let mut of_nats = |it: Report<'_>| noted(Transport::Nats, it);
    let mut of_https = |it: Report<'_>| noted(Transport::Https, it);
    let mut of_packing = |it: Report<'_>| (report.lock().unwrap_or_else(PoisonError::into_inner))(it);
    let nats = async {
        if let Some(nats) = &config.nats {
            let watched = async {
                match config.prometheus {
                    Some(_) => metrics::stream(nats, metrics).await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                () = run_nats(config, nats, metrics, stop.clone(), &mut of_nats) => {}
                () = watched => {}
            }
        }
    };
    let https = async {
        if let Some(server) = server {
            server.run(config, stop.clone(), &mut of_https).await;
        }
    };
    tokio::join!(nats, https, packing::run(config, stop.clone(), &mut of_packing));
}

/// Archives from NATS. A failure is reported once, and tried again with growing pauses.
async fn run_nats(
    config: &Config,
    nats: &Nats,
    metrics: &Metrics,
    stop: watch::Receiver<bool>,
    report: &mut impl FnMut(Report<'_>),
) {
    let (mut sum, mut retry) = (Stored::default(), Retry::default());
    while !*stop.borrow() {
        let before = sum;
        metrics.is_up(Transport::Nats, false);
        let Err(error) = archive(config, nats, metrics, &stop, &mut sum, report).await else { return };
        metrics.is_up(Transport::Nats, false);
        error.count(metrics);
        retry.after(&error, sum != before, stop.clone(), report).await;
    }
}

/// One session with the servers and the database.
async fn archive(
    config: &Config,
    nats: &Nats,
    metrics: &Metrics,
    stop: &watch::Receiver<bool>,
    sum: &mut Stored,
    report: &mut impl FnMut(Report<'_>),
) -> Result<(), ArchiveError> {
    let mut store = noticed(SILENCE, Store::open(&config.database, config.samples_days, &config.plants), report)
        .await?
        .counting(metrics);
    let mut maintenance = Maintenance::default();
    maintenance.run(&mut store, metrics, report).await?;
    let jetstream = connect(nats, "profivac archive").await?;
    let consumer = consumer(config, nats, &jetstream, report).await?;
    metrics.is_up(Transport::Nats, true);
    report(Report::Ready);
    let mut search_at = Instant::now();
    while !*stop.borrow() {
        let messages = fetch(nats, &consumer).await?;
        if !messages.is_empty() {
            let stored = noticed(SILENCE, store_messages(&mut store, &messages), report).await;
            if stored.is_err() {
                hand_back(&messages).await;
            }
            let stored = stored?;
            acknowledge(nats, &messages).await?;
            sum.add(stored);
            store.take_reports().into_iter().for_each(|sentence| report(Report::PutAside(sentence)));
            report(Report::Stored(*sum));
        } else if jetstream.client().connection_state() == State::Disconnected {
            // Without a connection the library waits as if there were no messages.
            return Err(NatsError::new(nats, "the connection is lost").into());
        }
        if Instant::now() >= maintenance.at {
            maintenance.run(&mut store, metrics, report).await?;
        }
        if Instant::now() >= search_at {
            let found = noticed(SILENCE, store.find_gaps(), report).await?;
            metrics.is_up(Transport::Nats, true);
            if noticed(SILENCE, store.claim_telling(), report).await? {
                tell(nats, &jetstream, found).await?;
            }
            search_at = Instant::now() + SEARCH_INTERVAL;
        }
    }
    Ok(())
}

/// Tells each station what the database has of it. One that does not listen is told the next time.
async fn tell(nats: &Nats, jetstream: &Context, stations: Vec<StationStatus>) -> Result<(), NatsError> {
    let client = jetstream.client();
    for StationStatus { plant, station, status } in stations {
        let Ok(payload) = serde_json::to_vec(&Request::Status(status)) else { continue };
        let subject = request::subject(&plant, &station);
        client.publish(subject, payload.into()).await.map_err(|error| NatsError::new(nats, error))?;
    }
    Ok(())
}

/// The stream and the consumer, which the first archive creates.
async fn consumer(
    config: &Config,
    nats: &Nats,
    jetstream: &Context,
    report: &mut impl FnMut(Report<'_>),
) -> Result<Consumer<pull::Config>, NatsError> {
    let failed = |text: String| NatsError::new(nats, text);
    let wanted = stream_config(config.replicas, config.stream_octets);
    let stream = jetstream.get_or_create_stream(wanted.clone()).await;
    let stream = stream.map_err(|error| failed(refused_stream(&error)))?;
    for sentence in differences(&stream.cached_info().config, &wanted) {
        report(Report::OtherStream(sentence));
    }
    let consumer = pull::Config {
        durable_name: Some(CONSUMER.to_owned()),
        ack_policy: AckPolicy::Explicit,
        ack_wait: ACKNOWLEDGEMENT_WAIT,
        max_ack_pending: 8_192,
        ..pull::Config::default()
    };
    stream.get_or_create_consumer(CONSUMER, consumer).await.map_err(|error| failed(refused_consumer(&error)))
}

/// The stream as the first archive creates it.
fn stream_config(replicas: usize, octets: i64) -> stream::Config {
    stream::Config {
        name: STREAM.to_owned(),
        subjects: vec![SUBJECTS.to_owned()],
        retention: RetentionPolicy::WorkQueue,
        // A full stream refuses: batches stay at the stations. So does a full share of a station, which leaves room for the others.
        discard: DiscardPolicy::New,
        discard_new_per_subject: true,
        max_messages_per_subject: (octets / SHARES / i64::from(MAX_MESSAGE_OCTETS)).max(LEAST_MESSAGES),
        max_bytes: octets,
        max_message_size: MAX_MESSAGE_OCTETS,
        num_replicas: replicas,
        ..stream::Config::default()
    }
}

/// How a stream that existed differs from that of the file, and what to do. It is not changed: another archive may have another file.
fn differences(found: &stream::Config, wanted: &stream::Config) -> Vec<String> {
    [other_size(found, wanted), no_shares(found, wanted), loses_batches(found, wanted)].into_iter().flatten().collect()
}

fn other_size(found: &stream::Config, wanted: &stream::Config) -> Option<String> {
    ((found.num_replicas, found.max_bytes) != (wanted.num_replicas, wanted.max_bytes)).then(|| {
        format!(
            "the stream {STREAM} was created with replicas = {} and stream-octets = {}, the file has {} and {}: change the file, or the stream \
             with `nats stream edit {STREAM}`",
            found.num_replicas, found.max_bytes, wanted.num_replicas, wanted.max_bytes
        )
    })
}

fn no_shares(found: &stream::Config, wanted: &stream::Config) -> Option<String> {
    let share = wanted.max_messages_per_subject;
    (!found.discard_new_per_subject || found.max_messages_per_subject != share).then(|| {
        format!(
            "the stream {STREAM} does not give each station a share of {share} batches: one station alone could fill it; \
             `nats stream edit {STREAM} --max-msgs-per-subject {share} --discard-per-subject` changes it"
        )
    })
}

/// The settings with which the servers forget a batch that they have acknowledged, or take none or others.
fn loses_batches(found: &stream::Config, wanted: &stream::Config) -> Option<String> {
    let settings = |config: &stream::Config| {
        [
            ("subjects", config.subjects.join(" ")),
            ("storage", format!("{:?}", config.storage).to_lowercase()),
            ("retention", format!("{:?}", config.retention).to_lowercase()),
            ("discard", format!("{:?}", config.discard).to_lowercase()),
            ("max-age", format!("{} s", config.max_age.as_secs_f64())),
            // The servers write -1 for no limit, and take 0 for it too.
            ("max-msgs", config.max_messages.max(0).to_string()),
            ("no-ack", config.no_ack.to_string()),
        ]
    };
    let both = settings(found).into_iter().zip(settings(wanted));
    let others = both.filter(|((_, found), (_, wanted))| found != wanted);
    let others: Vec<_> =
        others.map(|((name, found), (_, wanted))| format!("{name} {found} in place of {wanted}")).collect();
    (!others.is_empty()).then(|| {
        format!(
            "the stream {STREAM} was created by another program with {}: batches may be lost in it; stop the archives, delete the stream with \
             `nats stream rm {STREAM}`, and start an archive, which creates it; the stations send again what they have",
            others.join(", ")
        )
    })
}

/// Why the servers gave no stream, with what to do. A server does not answer a request that its user may not send.
fn refused_stream(error: &CreateStreamError) -> String {
    let advice = match error.kind() {
        CreateStreamErrorKind::TimedOut => Some(NO_ANSWER),
        CreateStreamErrorKind::JetStreamUnavailable => Some("give the server a table jetstream { store_dir: ... }"),
        CreateStreamErrorKind::JetStream(error) => advice(error.error_code()),
        _ => None,
    };
    with_advice(error, advice)
}

/// Why the servers gave no consumer, with what to do.
fn refused_consumer(error: &ConsumerError) -> String {
    let advice = match error.kind() {
        ConsumerErrorKind::TimedOut => Some(NO_ANSWER),
        ConsumerErrorKind::JetStream(error) => advice(error.error_code()),
        _ => None,
    };
    with_advice(error, advice)
}

const NO_ANSWER: &str =
    "check that the servers have a leader, and that the user may publish to $JS.> and subscribe to _INBOX.>";

const fn advice(code: ErrorCode) -> Option<&'static str> {
    match code {
        ErrorCode::STREAM_REPLICAS_NOT_SUPPORTED => {
            Some("write replicas = 1 into [archive], or use a cluster of servers")
        }
        ErrorCode::STORAGE_RESOURCES_EXCEEDED
        | ErrorCode::INSUFFICIENT_RESOURCES
        | ErrorCode::MEMORY_RESOURCES_EXCEEDED => {
            Some("reduce stream-octets in [archive], or give the servers more room")
        }
        _ => None,
    }
}

fn with_advice(error: &dyn Display, advice: Option<&str>) -> String {
    advice.map_or_else(|| error.to_string(), |advice| format!("{error}; {advice}"))
}

/// The next messages, or none.
async fn fetch(nats: &Nats, consumer: &Consumer<pull::Config>) -> Result<Vec<Message>, NatsError> {
    let failed = |error: &dyn std::fmt::Display| NatsError::new(nats, error);
    let fetched = consumer.fetch().max_messages(MAX_MESSAGES).expires(FETCH_TIMEOUT).messages().await;
    let mut fetched = fetched.map_err(|error| failed(&error))?;
    let mut messages = Vec::new();
    while let Some(message) = fetched.next().await {
        match message {
            Ok(message) => messages.push(message),
            // Messages that have come are stored first.
            Err(_) if !messages.is_empty() => break,
            Err(error) => return Err(failed(&error)),
        }
    }
    Ok(messages)
}

async fn store_messages(store: &mut Store, messages: &[Message]) -> Result<Stored, StoreError> {
    let incoming: Vec<_> = messages.iter().map(|message| Incoming::of(message)).collect();
    store.store(&incoming, Micros::now()).await
}

/// Acknowledges what is committed. A lost acknowledgement brings the message again, which changes nothing.
async fn acknowledge(nats: &Nats, messages: &[Message]) -> Result<(), NatsError> {
    for message in messages {
        message.ack().await.map_err(|error| NatsError::new(nats, error))?;
    }
    Ok(())
}

/// Lets the messages come again soon. If that fails, they come after the wait for the acknowledgement.
async fn hand_back(messages: &[Message]) {
    use async_nats::jetstream::AckKind;
    for message in messages {
        if message.ack_with(AckKind::Nak(Some(Duration::from_secs(1)))).await.is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_with_other_settings_is_named() {
        let wanted = stream_config(1, 10_000_000_000);
        let difference = |found: &stream::Config, wanted: &stream::Config| {
            let mut sentences = differences(found, wanted);
            let first = sentences.pop().unwrap();
            assert_eq!(sentences, [] as [String; 0]);
            first
        };
        assert_eq!(differences(&wanted, &wanted), [] as [String; 0]);
        let unlimited = stream::Config { max_messages: -1, ..wanted.clone() };
        assert_eq!(differences(&unlimited, &wanted), [] as [String; 0], "as the servers answer");
        let other = difference(&wanted, &stream_config(3, 10_000_000_000));
        assert!(
            other.contains("replicas = 1 and stream-octets = 10000000000, the file has 3 and 10000000000"),
            "{other}"
        );
        let other = stream::Config { max_bytes: 20_000_000_000, ..wanted.clone() };
        assert!(difference(&other, &wanted).ends_with("`nats stream edit PROFIVAC`"));
        let without_shares = stream::Config { discard_new_per_subject: false, ..wanted.clone() };
        let other = difference(&without_shares, &wanted);
        assert!(other.contains("--max-msgs-per-subject 1589 --discard-per-subject"), "{other}");
    }

    #[test]
    fn a_stream_in_which_batches_may_be_lost_is_named_with_every_such_setting() {
        let wanted = stream_config(1, 10_000_000_000);
        let found = stream::Config {
            subjects: vec!["profivac.>".to_owned()],
            storage: stream::StorageType::Memory,
            retention: RetentionPolicy::Limits,
            discard: DiscardPolicy::Old,
            max_age: Duration::from_secs(20),
            max_messages: 9,
            no_ack: true,
            ..wanted.clone()
        };
        let sentences = differences(&found, &wanted);
        let expected = "with subjects profivac.> in place of profivac.v1.*.*.batch, storage memory in place of file, retention limits in place of \
                        workqueue, discard old in place of new, max-age 20 s in place of 0 s, max-msgs 9 in place of 0, no-ack true in place of \
                        false: batches may be lost";
        assert!(sentences.len() == 1 && sentences[0].contains(expected), "{sentences:?}");
    }

    #[test]
    fn a_station_has_an_eighth_of_the_stream_and_never_less_than_two_rounds() {
        let share = |octets| stream_config(1, octets).max_messages_per_subject;
        assert_eq!([10_000_000_000, 1_000_000_000, 10_000_000].map(share), [1_589, 256, 256]);
        let largest = share(10_000_000_000) * i64::from(MAX_MESSAGE_OCTETS);
        assert!(largest <= 10_000_000_000 / SHARES);
    }

    /// The codes of the server: its `errors.json`.
    #[test]
    fn servers_without_a_stream_say_what_to_change() {
        let answered = |code: u64| {
            let answer = serde_json::json!({"code": 500, "err_code": code, "description": "in other words"});
            serde_json::from_value::<async_nats::jetstream::Error>(answer).unwrap()
        };
        for (kind, advice) in [
            (CreateStreamErrorKind::TimedOut, "the user may publish to $JS.>"),
            (CreateStreamErrorKind::JetStreamUnavailable, "give the server a table jetstream"),
            (CreateStreamErrorKind::JetStream(answered(10_074)), "replicas = 1"),
            (CreateStreamErrorKind::JetStream(answered(10_047)), "reduce stream-octets"),
            (CreateStreamErrorKind::JetStream(answered(10_023)), "reduce stream-octets"),
            (CreateStreamErrorKind::JetStream(answered(10_028)), "reduce stream-octets"),
        ] {
            let error = CreateStreamError::new(kind);
            let refused = refused_stream(&error);
            assert!(refused.starts_with(&format!("{error}; ")) && refused.contains(advice), "{refused}");
        }
        let other = CreateStreamError::new(CreateStreamErrorKind::JetStream(answered(10_000)));
        assert_eq!(refused_stream(&other), other.to_string());
        let consumer = ConsumerError::new(ConsumerErrorKind::TimedOut);
        assert_eq!(refused_consumer(&consumer), format!("timed out; {NO_ANSWER}"));
    }
}
