//! The loop of an archive: take messages, store them, acknowledge them. Any number of archives share one consumer.

use crate::config::Config;
use crate::nats::{NatsError, STREAM, SUBJECTS, connect};
use crate::store::{Incoming, Store, StoreError, Stored};
use async_nats::jetstream::consumer::{AckPolicy, Consumer, pull};
use async_nats::jetstream::stream::{DiscardPolicy, RetentionPolicy};
use async_nats::jetstream::{Context, Message, stream};
use futures_util::StreamExt;
use profivac_recorder::Micros;
use std::time::Duration;
use thiserror::Error;
use tokio::sync::watch;
use tokio::time::{Instant, sleep};

/// The name of the consumer that all archives share.
const CONSUMER: &str = "archive";

/// The most messages of a transaction.
const MAX_MESSAGES: usize = 256;

/// The most octets of a message: a batch of a station is far shorter.
const MAX_MESSAGE_OCTETS: i32 = 768 << 10;

/// The longest wait for the first message of a transaction.
const FETCH_TIMEOUT: Duration = Duration::from_secs(1);

/// A message that was not acknowledged comes again after this time: longer than a transaction may take.
const ACKNOWLEDGEMENT_WAIT: Duration = Duration::from_secs(30);

/// The time between two looks at partitions and retention.
const MAINTENANCE_INTERVAL: Duration = Duration::from_secs(3_600);

/// The pauses after a failure.
const FIRST_PAUSE: Duration = Duration::from_millis(500);
const LONGEST_PAUSE: Duration = Duration::from_secs(10);

/// Why an archive has to connect again.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ArchiveError {
    /// The servers of NATS cannot be used.
    #[error(transparent)]
    Nats(#[from] NatsError),
    /// The database cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// What an archive reports.
#[derive(Debug)]
pub enum Report<'a> {
    /// It takes batches.
    Ready,
    /// It has stored batches, since the start.
    Stored(Stored),
    /// It has failed and connects again.
    Failed(&'a ArchiveError),
}

/// Archives until it is told to stop. A failure is reported once, and tried again with growing pauses.
pub async fn run(config: &Config, mut stop: watch::Receiver<bool>, mut report: impl FnMut(Report<'_>)) {
    let mut pause = FIRST_PAUSE;
    let mut sum = Stored::default();
    let mut last = String::new();
    while !*stop.borrow() {
        let before = sum;
        let ended = archive(config, &stop, &mut sum, &mut report).await;
        let Err(error) = ended else { return };
        if error.to_string() != last || sum != before {
            report(Report::Failed(&error));
        }
        last = error.to_string();
        pause = if sum == before { pause.saturating_mul(2).min(LONGEST_PAUSE) } else { FIRST_PAUSE };
        tokio::select! {
            () = sleep(pause) => {}
            _ = stop.wait_for(|is_stopped| *is_stopped) => return,
        }
    }
}

/// One session with the servers and the database.
async fn archive(
    config: &Config,
    stop: &watch::Receiver<bool>,
    sum: &mut Stored,
    report: &mut impl FnMut(Report<'_>),
) -> Result<(), ArchiveError> {
    let mut store = Store::connect(&config.database, config.samples_days).await?;
    store.set_readers(&config.plants).await?;
    store.maintain(Micros::now()).await?;
    let jetstream = connect(&config.nats, "profivac archive").await?;
    let consumer = consumer(config, &jetstream).await?;
    report(Report::Ready);
    let mut maintain_at = Instant::now() + MAINTENANCE_INTERVAL;
    while !*stop.borrow() {
        let messages = fetch(config, &consumer).await?;
        if !messages.is_empty() {
            let stored = store_messages(&mut store, &messages).await;
            if stored.is_err() {
                hand_back(&messages).await;
            }
            let stored = stored?;
            acknowledge(config, &messages).await?;
            sum.add(stored);
            report(Report::Stored(*sum));
        }
        if Instant::now() >= maintain_at {
            store.maintain(Micros::now()).await?;
            maintain_at = Instant::now() + MAINTENANCE_INTERVAL;
        }
    }
    Ok(())
}

/// The stream and the consumer, which the first archive creates.
async fn consumer(config: &Config, jetstream: &Context) -> Result<Consumer<pull::Config>, NatsError> {
    let failed = |error: &dyn std::fmt::Display| NatsError::new(&config.nats, error);
    let stream = stream::Config {
        name: STREAM.to_owned(),
        subjects: vec![SUBJECTS.to_owned()],
        retention: RetentionPolicy::WorkQueue,
        // A full stream refuses: batches stay at the stations.
        discard: DiscardPolicy::New,
        max_bytes: config.stream_octets,
        max_message_size: MAX_MESSAGE_OCTETS,
        num_replicas: config.replicas,
        duplicate_window: Duration::from_secs(120),
        ..stream::Config::default()
    };
    let stream = jetstream.get_or_create_stream(stream).await.map_err(|error| failed(&error))?;
    let consumer = pull::Config {
        durable_name: Some(CONSUMER.to_owned()),
        ack_policy: AckPolicy::Explicit,
        ack_wait: ACKNOWLEDGEMENT_WAIT,
        max_ack_pending: 8_192,
        ..pull::Config::default()
    };
    stream.get_or_create_consumer(CONSUMER, consumer).await.map_err(|error| failed(&error))
}

/// The next messages, or none.
async fn fetch(config: &Config, consumer: &Consumer<pull::Config>) -> Result<Vec<Message>, NatsError> {
    let failed = |error: &dyn std::fmt::Display| NatsError::new(&config.nats, error);
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
    let incoming: Vec<_> = messages.iter().map(incoming).collect();
    store.store(&incoming, Micros::now()).await
}

fn incoming(message: &Message) -> Incoming {
    let id = message.headers.as_ref().and_then(|headers| headers.get("Nats-Msg-Id"));
    Incoming {
        subject: message.subject.to_string(),
        id: id.map(|id| id.as_str().to_owned()).unwrap_or_default(),
        payload: message.payload.to_vec(),
    }
}

/// Acknowledges what is committed. A lost acknowledgement brings the message again, which changes nothing.
async fn acknowledge(config: &Config, messages: &[Message]) -> Result<(), NatsError> {
    for message in messages {
        message.ack().await.map_err(|error| NatsError::new(&config.nats, error))?;
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
