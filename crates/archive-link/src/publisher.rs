//! The station's part: the batches of the outbox to JetStream, or to an archive over HTTPS.
//!
//! The cursor of the database moves when JetStream has acknowledged a batch, or the archive has committed it. Without a network batches
//! wait in the database; the segments, the recorder and the dashboard do not notice.

use crate::post::{PostError, Poster};
use crate::responder::{self, MAX_WAITING, Responder};
use async_nats::HeaderMap;
use async_nats::jetstream::context::{PublishError, PublishErrorKind};
use async_nats::jetstream::{Context as JetStream, ErrorCode};
use profivac_archive_protocol::nats::{BATCH_HEADER, NatsError, connect_for, inbox, message_id, subject};
use profivac_gateway::ReadModel;
use profivac_gateway::thread::{Context, GatewayThread};
use profivac_recorder::DatabaseError;
use profivac_recorder::outbox::{Page, Waiting};
use profivac_station::config::gateways::archive::{Https, Settings, Transport};
use profivac_station::services::Services;
use profivac_web_server::tables::archive::Nats;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;
use tokio::task::JoinError;
use tokio::time::{Instant, sleep, timeout};

/// The most batches that wait for their acknowledgements at once.
const MAX_BATCHES: u32 = 128;

/// About the most octets of these.
const MAX_OCTETS: usize = 2 << 20;

/// The time between two looks at an empty outbox: that between two transactions of the recorder.
const POLL_INTERVAL: Duration = Duration::from_secs(1);

/// The pause when the servers hold as many batches of the station as they may. chosen: short beside the time in which an archive takes
/// the next hundreds.
const FULL_PAUSE: Duration = Duration::from_millis(50);

/// The longest time without room for a batch before that is reported. chosen: an archive that stores a large batch, or starts again,
/// takes less.
const FULL_TIMEOUT: Duration = Duration::from_secs(10);

/// The longest wait for an acknowledgement.
const ACKNOWLEDGEMENT_TIMEOUT: Duration = Duration::from_secs(10);

/// Why publishing has ended.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PublisherError {
    /// The database cannot be read.
    #[error(transparent)]
    Database(#[from] DatabaseError),
    /// The servers cannot be used.
    #[error("{0}; batches wait in the database")]
    Nats(#[from] NatsError),
    /// The servers hold as many batches of the station as they may, and no archive takes them.
    #[error("{0}; batches wait in the database")]
    FullShare(NatsError),
    /// The archive cannot be reached, or refuses.
    #[error("{0}; batches wait in the database")]
    Post(#[from] PostError),
    /// A thread has failed.
    #[error("reading the database has failed unexpectedly: {0}")]
    Thread(#[from] JoinError),
}

/// Starts to publish.
///
/// # Errors
/// When the system gives no thread.
pub fn start(settings: Settings, model: Arc<ReadModel>, services: Arc<Services>) -> std::io::Result<GatewayThread> {
    GatewayThread::start("archive", model, services, move |context| publish(settings.clone(), context))
}

/// Where batches go.
enum Destination {
    JetStream(Nats, JetStream),
    Archive(Https, Poster),
}

impl Destination {
    /// Connects to the servers of NATS. An archive is connected to with the first batch.
    async fn open(settings: &Settings) -> Result<Self, PublisherError> {
        Ok(match &settings.transport {
            Transport::Nats(nats) => {
                let inbox = inbox(&settings.plant, &settings.station);
                Self::JetStream(nats.clone(), connect_for(nats, &settings.station, MAX_WAITING, &inbox).await?)
            }
            Transport::Https(https) => Self::Archive(https.clone(), Poster::new(https, &https.url)?),
        })
    }

    /// Begins to answer requests of the archive, if the file permits it.
    async fn answer(&self, settings: &Settings, context: &Context) -> Result<Responder, PublisherError> {
        let services = &context.services;
        Ok(match self {
            Self::JetStream(nats, jetstream) => {
                responder::answer_nats(jetstream.client(), nats, settings, services).await?
            }
            Self::Archive(https, _) => responder::answer_https(https, settings, services, &context.status)?,
        })
    }

    fn name(&self) -> String {
        match self {
            Self::JetStream(nats, _) => nats.servers.join(", "),
            Self::Archive(_, poster) => poster.origin().to_owned(),
        }
    }

    /// Sends batches and moves the cursor past those that are stored without a gap. Returns their number, and what failed.
    async fn send(
        &mut self,
        settings: &Settings,
        page: Page,
        cursor: &mut (i64, i64),
    ) -> (u64, Result<(), PublisherError>) {
        match self {
            Self::JetStream(nats, jetstream) => publish_page(jetstream, nats, settings, page, cursor).await,
            Self::Archive(_, poster) => post_page(poster, settings, page, cursor).await,
        }
    }
}

/// Publishes until it is told to stop, or something fails.
async fn publish(settings: Settings, mut context: Context) -> Result<(), PublisherError> {
    let mut destination = Destination::open(&settings).await?;
    let _responder = destination.answer(&settings, &context).await?;
    context.status.runs(destination.name());
    let mut cursor = (0, 0);
    // When there was room last. A publisher that begins with a full share reports it at once.
    let mut room = None;
    loop {
        let page = read(&context, cursor).await?;
        if page.epoch != cursor.0 {
            cursor = (page.epoch, 0);
        }
        if page.batches.is_empty() {
            room = room.map(|_| Instant::now());
            pause(&mut context, POLL_INTERVAL).await;
        } else {
            let (begun, octets) = (Instant::now(), octets_of(&page));
            let (count, sent) = destination.send(&settings, page, &mut cursor).await;
            context.status.sent(count);
            context.services.recorder().acknowledge_outbox(cursor.0, cursor.1);
            if count > 0 {
                room = Some(Instant::now());
            }
            match sent {
                // An archive takes batches: the next round sends the rest.
                Err(PublisherError::FullShare(_)) if room.is_some_and(|it| it.elapsed() < FULL_TIMEOUT) => {
                    pause(&mut context, if count == 0 { FULL_PAUSE } else { Duration::ZERO }).await;
                }
                sent => sent?,
            }
            pause(&mut context, pause_after(settings.limit, octets, begun.elapsed())).await;
        }
        if context.stop.is_stopped() {
            return Ok(());
        }
    }
}

/// Reads the batches after the cursor on a thread that may wait for the disk. The database is opened each time: it may be replaced.
async fn read(context: &Context, (epoch, after): (i64, i64)) -> Result<Page, PublisherError> {
    let recorder = Arc::clone(context.services.recorder());
    let page = tokio::task::spawn_blocking(move || {
        let reader = recorder.open_reader()?;
        let page = reader.outbox(after, MAX_BATCHES, MAX_OCTETS)?;
        // Another database counts from one.
        if page.epoch == epoch { Ok(page) } else { reader.outbox(0, MAX_BATCHES, MAX_OCTETS) }
    });
    Ok(page.await??)
}

fn octets_of(page: &Page) -> usize {
    page.batches.iter().map(|batch| batch.payload.len()).sum()
}

/// Posts batches, one after the other: each answer is that of a commit.
async fn post_page(
    poster: &mut Poster,
    settings: &Settings,
    page: Page,
    cursor: &mut (i64, i64),
) -> (u64, Result<(), PublisherError>) {
    let mut count = 0;
    for batch in page.batches {
        let number = batch.number;
        match poster.post(&settings.plant, &settings.station, page.epoch, batch).await {
            Ok(()) => *cursor = (page.epoch, number),
            Err(error) => return (count, Err(error.into())),
        }
        count += 1;
    }
    (count, Ok(()))
}

/// Publishes batches and moves the cursor past those that are acknowledged without a gap. Returns their number, and what failed.
async fn publish_page(
    jetstream: &JetStream,
    nats: &Nats,
    settings: &Settings,
    page: Page,
    cursor: &mut (i64, i64),
) -> (u64, Result<(), PublisherError>) {
    let subject = subject(&settings.plant, &settings.station);
    let failed = |reason: String| Err(NatsError::new(nats, reason).into());
    let (mut waiting, mut published) = (Vec::new(), Ok(()));
    for Waiting { number, payload } in page.batches {
        let mut headers = HeaderMap::new();
        headers.insert(BATCH_HEADER, message_id(&settings.station, page.epoch, number).as_str());
        let sent = jetstream.publish_with_headers(subject.clone(), headers, payload.into());
        match timeout(ACKNOWLEDGEMENT_TIMEOUT, sent).await {
            Ok(Ok(acknowledgement)) => waiting.push((number, acknowledgement)),
            Ok(Err(error)) => published = failed(error.to_string()),
            Err(_) => published = failed("the server takes no messages".to_owned()),
        }
        if published.is_err() {
            break;
        }
    }
    let mut count: u64 = 0;
    for (number, acknowledgement) in waiting {
        match timeout(ACKNOWLEDGEMENT_TIMEOUT, acknowledgement.into_future()).await {
            Ok(Ok(_stored)) => *cursor = (page.epoch, number),
            Ok(Err(error)) if is_full_share(&error) => {
                let reason = NatsError::new(nats, explained(&error, settings));
                return (count, Err(PublisherError::FullShare(reason)));
            }
            Ok(Err(error)) => return (count, failed(explained(&error, settings))),
            Err(_) => return (count, failed(explained(&PublishErrorKind::TimedOut.into(), settings))),
        }
        count = count.saturating_add(1);
    }
    (count, published)
}

/// Whether the stream holds as many batches of the station as it may. The server has one code for all reasons why it stores no message, so
/// its text decides between a full share and a full stream.
fn is_full_share(error: &PublishError) -> bool {
    let answer =
        std::error::Error::source(error).and_then(|source| source.downcast_ref::<async_nats::jetstream::Error>());
    answer.is_some_and(|answer| {
        answer.error_code() == ErrorCode::STREAM_STORE_FAILED
            && answer.to_string().starts_with("maximum messages per subject exceeded")
    })
}

/// The error of an acknowledgement, with what to do.
fn explained(error: &PublishError, settings: &Settings) -> String {
    let Settings { plant, station, .. } = settings;
    match error.kind() {
        PublishErrorKind::StreamNotFound => {
            format!("no stream takes the batches ({error}): start `profivac archive` once, which creates it")
        }
        // A server does not answer a message that its user may not send.
        PublishErrorKind::TimedOut => {
            format!(
                "the batch was not stored: {error}; check that the server runs, and that the user of the station may publish to {} and \
                 subscribe to {}.>",
                subject(plant, station),
                inbox(plant, station)
            )
        }
        _ if is_full_share(error) => {
            "the servers hold as many batches of this station as they may, and no archive takes them: check that `profivac archive` runs, and \
             its database"
                .to_owned()
        }
        _ => format!("the batch was not stored: {error}"),
    }
}

/// The pause that keeps the limit on average.
fn pause_after(limit: Option<u32>, octets: usize, took: Duration) -> Duration {
    let Some(limit) = limit.filter(|limit| *limit > 0) else { return Duration::ZERO };
    Duration::from_secs_f64(octets as f64 / f64::from(limit)).saturating_sub(took)
}

async fn pause(context: &mut Context, time: Duration) {
    if !time.is_zero() {
        tokio::select! {
            () = sleep(time) => {}
            () = context.stop.stopped() => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_recorder::Forward;
    use profivac_station::config::gateways::archive::Requests;

    #[test]
    fn the_limit_counts_the_time_that_sending_took() {
        let second = Duration::from_secs(1);
        assert_eq!(pause_after(Some(1_000), 3_000, second), second * 2);
        assert_eq!(pause_after(Some(1_000), 500, second), Duration::ZERO);
        assert_eq!(pause_after(None, 500, Duration::ZERO), Duration::ZERO);
    }

    #[test]
    fn a_full_share_is_told_apart_from_a_full_stream() {
        let error = |code: u64, text: &str| {
            let answer = serde_json::json!({"code": 503, "err_code": code, "description": text});
            let answer: async_nats::jetstream::Error = serde_json::from_value(answer).unwrap();
            PublishError::with_source(PublishErrorKind::Other, answer)
        };
        assert!(is_full_share(&error(10_077, "maximum messages per subject exceeded")));
        assert!(!is_full_share(&error(10_077, "maximum bytes exceeded")));
        assert!(!is_full_share(&error(10_047, "maximum messages per subject exceeded")));
    }

    #[test]
    fn a_missing_stream_says_what_creates_it() {
        let settings = Settings {
            plant: "a".to_owned(),
            station: "b".to_owned(),
            samples: Forward::All,
            limit: None,
            transport: Transport::Nats(Nats { servers: Vec::new(), tls: false, credentials: None, ca_file: None }),
            requests: Requests::Off,
        };
        let explained = |kind: PublishErrorKind| explained(&PublishError::from(kind), &settings);
        assert!(explained(PublishErrorKind::StreamNotFound).ends_with("which creates it"));
        let refused = explained(PublishErrorKind::TimedOut);
        assert!(
            refused.ends_with("publish to profivac.v1.a.b.batch and subscribe to profivac.v1.a.b.inbox.>"),
            "{refused}"
        );
    }
}
