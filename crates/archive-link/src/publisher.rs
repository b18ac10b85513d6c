//! The station's part: the batches of the outbox to JetStream, or to an archive over HTTPS.
//!
//! The cursor of the database moves when JetStream has acknowledged a batch, or the archive has committed it. Without a network batches
//! wait in the database; the segments, the recorder and the dashboard do not notice.
//!
//! The archive tells a station up to which number its database has the batches, and which it lacks: the station sends those again that it
//! still has.

use crate::post::{PostError, Poster};
use crate::responder::{self, MAX_WAITING, Responder};
use async_nats::HeaderMap;
use async_nats::jetstream::context::{PublishError, PublishErrorKind};
use async_nats::jetstream::{Context as JetStream, ErrorCode};
use profivac_archive_protocol::nats::{BATCH_HEADER, NatsError, STREAM, connect_for, inbox, message_id, subject};
use profivac_archive_protocol::request::{Copied, Missing, Status};
use profivac_gateway::ReadModel;
use profivac_gateway::thread::{Context, GatewayThread};
use profivac_recorder::DatabaseError;
use profivac_recorder::outbox::{Acknowledgement, Page, Summary, Waiting};
use profivac_station::config::gateways::archive::{Https, Settings, Transport};
use profivac_station::services::Services;
use profivac_web_server::tables::archive::Nats;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;
use tokio::sync::mpsc;
use tokio::task::JoinError;
use tokio::time::{Instant, sleep, timeout};

/// The most batches that wait for their acknowledgements at once.
const MAX_BATCHES: u32 = 128;

/// About the most octets of these.
const MAX_OCTETS: usize = 2 << 20;

/// The time between two looks at an empty outbox: that between two transactions of the recorder.
const POLL_INTERVAL: Duration = Duration::from_secs(1);

/// The time between two counts of the batches that wait.
const NOTE_INTERVAL: Duration = Duration::from_secs(5);

/// The pause when the servers hold as many batches of the station as they may. chosen: short beside the time in which an archive takes
/// the next hundreds.
const FULL_PAUSE: Duration = Duration::from_millis(50);

/// The longest time without room for a batch before that is reported. chosen: an archive that stores a large batch, or starts again,
/// takes less.
const FULL_TIMEOUT: Duration = Duration::from_secs(10);

/// The longest wait for an acknowledgement.
const ACKNOWLEDGEMENT_TIMEOUT: Duration = Duration::from_secs(10);

/// Answers of archives that wait for the publisher. An archive repeats them.
const MAX_TOLD: usize = 16;

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

    /// Begins to answer requests of the archive. What it has of the station goes to `told`.
    async fn answer(
        &self,
        settings: &Settings,
        context: &Context,
        told: mpsc::Sender<Status>,
    ) -> Result<Responder, PublisherError> {
        let services = &context.services;
        Ok(match self {
            Self::JetStream(nats, jetstream) => {
                responder::answer_nats(jetstream.client(), nats, settings, services, told).await?
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

    /// Sends batches, in their order.
    async fn send(&mut self, settings: &Settings, batches: Vec<Waiting>, told: &mpsc::Sender<Status>) -> Sent {
        match self {
            Self::JetStream(nats, jetstream) => publish_batches(jetstream, nats, settings, batches).await,
            Self::Archive(_, poster) => post_batches(poster, settings, batches, told).await,
        }
    }

    /// Whether a batch that was taken is in the database of the archive.
    const fn stores(&self) -> bool {
        matches!(self, Self::Archive(..))
    }
}

/// What became of batches that were sent.
struct Sent {
    /// How many were taken without a gap.
    count: u64,
    /// The number of the last one of them.
    last: Option<i64>,
    /// What failed then.
    result: Result<(), PublisherError>,
}

impl Sent {
    const fn nothing() -> Self {
        Self { count: 0, last: None, result: Ok(()) }
    }

    const fn add(&mut self, number: i64) {
        self.count = self.count.saturating_add(1);
        self.last = Some(number);
    }

    fn failed(self, error: impl Into<PublisherError>) -> Self {
        Self { result: Err(error.into()), ..self }
    }
}

/// Publishes until it is told to stop, or something fails.
async fn publish(settings: Settings, mut context: Context) -> Result<(), PublisherError> {
    note_waiting(&context).await?;
    let mut destination = Destination::open(&settings).await?;
    let (teller, mut told) = mpsc::channel(MAX_TOLD);
    let _responder = destination.answer(&settings, &context, teller.clone()).await?;
    context.status.runs(destination.name());
    let mut cursor = (0, 0);
    let mut missing = VecDeque::new();
    let mut noted = Instant::now();
    // When there was room last. A publisher that begins with a full share reports it at once.
    let mut room = None;
    loop {
        while let Ok(status) = told.try_recv() {
            note_status(&context, &status);
            if !status.missing.is_empty() {
                missing = status.missing.into();
            }
        }
        if let Some(lacking) = missing.pop_front() {
            let rest = send_again(&mut destination, &settings, &mut context, lacking, &teller).await?;
            rest.into_iter().for_each(|rest| missing.push_front(rest));
        }
        let page = read(&context, cursor).await?;
        if page.epoch != cursor.0 {
            cursor = (page.epoch, 0);
        }
        if noted.elapsed() >= NOTE_INTERVAL {
            note_waiting(&context).await?;
            noted = Instant::now();
        }
        if page.batches.is_empty() {
            // Nothing is without an answer.
            if destination.stores() {
                context.status.archive_answered();
            }
            room = room.map(|_| Instant::now());
            if missing.is_empty() {
                pause(&mut context, POLL_INTERVAL).await;
            }
        } else {
            let (begun, octets) = (Instant::now(), octets_of(&page.batches));
            let Sent { count, last, result: sent } = destination.send(&settings, page.batches, &teller).await;
            context.status.sent(count);
            cursor.1 = last.unwrap_or(cursor.1);
            let stored = if destination.stores() { cursor.1 } else { 0 };
            let answer = Acknowledgement { epoch: cursor.0, taken: cursor.1, stored };
            context.services.recorder().acknowledge_outbox(answer);
            if count > 0 {
                room = Some(Instant::now());
                if destination.stores() {
                    context.status.archive_answered();
                }
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

/// Notes what the archive has of the station.
fn note_status(context: &Context, status: &Status) {
    let answer = Acknowledgement { epoch: status.epoch, taken: 0, stored: status.stored };
    context.services.recorder().acknowledge_outbox(answer);
    if let Some(Copied { epoch, first }) = status.copied {
        context.services.recorder().branch_outbox(epoch, first);
    }
    context.status.archive_answered();
    context.status.put_aside(status.put_aside, status.reason.as_deref());
}

/// Notes how many batches wait.
async fn note_waiting(context: &Context) -> Result<(), PublisherError> {
    let recorder = Arc::clone(context.services.recorder());
    let summary = tokio::task::spawn_blocking(move || recorder.open_reader()?.outbox_summary());
    let Summary { waiting, oldest, lost } = summary.await??;
    context.status.batches(waiting.unsigned_abs(), oldest, lost.unsigned_abs());
    Ok(())
}

/// Sends the first batches again that the archive lacks. Returns the numbers that are left.
async fn send_again(
    destination: &mut Destination,
    settings: &Settings,
    context: &mut Context,
    lacking: Missing,
    told: &mpsc::Sender<Status>,
) -> Result<Option<Missing>, PublisherError> {
    let batches = read_kept(context, lacking).await?;
    let (begun, octets) = (Instant::now(), octets_of(&batches));
    let Sent { count, last, result } = destination.send(settings, batches, told).await;
    context.status.sent(count);
    pause(context, pause_after(settings.limit, octets, begun.elapsed())).await;
    match result {
        // The archive asks again.
        Err(PublisherError::FullShare(_)) => Ok(None),
        Err(error) => Err(error),
        Ok(()) => {
            let next = last.map(|last| Missing { first: last.saturating_add(1), ..lacking });
            Ok(next.filter(|next| next.first <= next.last))
        }
    }
}

/// Reads the first batches that the archive lacks, of those that the station keeps.
async fn read_kept(context: &Context, lacking: Missing) -> Result<Vec<Waiting>, PublisherError> {
    let recorder = Arc::clone(context.services.recorder());
    let Missing { epoch, first, last } = lacking;
    let batches = tokio::task::spawn_blocking(move || {
        recorder.open_reader()?.kept_batches(epoch, first..=last, MAX_BATCHES, MAX_OCTETS)
    });
    Ok(batches.await??)
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

fn octets_of(batches: &[Waiting]) -> usize {
    batches.iter().map(|batch| batch.payload.len()).sum()
}

/// Posts batches, one after the other: each answer is that of a commit.
async fn post_batches(
    poster: &mut Poster,
    settings: &Settings,
    batches: Vec<Waiting>,
    told: &mpsc::Sender<Status>,
) -> Sent {
    let mut sent = Sent::nothing();
    for batch in batches {
        let number = batch.number;
        match poster.post(&settings.plant, &settings.station, batch).await {
            Ok(status) => {
                sent.add(number);
                if let Some(status) = status {
                    // Without room: the archive tells it again.
                    told.try_send(status).ok();
                }
            }
            Err(error) => return sent.failed(error),
        }
    }
    sent
}

/// Publishes batches, and waits for their acknowledgements.
async fn publish_batches(jetstream: &JetStream, nats: &Nats, settings: &Settings, batches: Vec<Waiting>) -> Sent {
    let subject = subject(&settings.plant, &settings.station);
    let (mut waiting, mut published) = (Vec::new(), Ok(()));
    for Waiting { epoch, number, payload } in batches {
        let mut headers = HeaderMap::new();
        headers.insert(BATCH_HEADER, message_id(&settings.station, epoch, number).as_str());
        let sent = jetstream.publish_with_headers(subject.clone(), headers, payload.into());
        match timeout(ACKNOWLEDGEMENT_TIMEOUT, sent).await {
            Ok(Ok(acknowledgement)) => waiting.push((number, acknowledgement)),
            Ok(Err(error)) => published = Err(error.to_string()),
            Err(_) => published = Err("the server takes no messages".to_owned()),
        }
        if published.is_err() {
            break;
        }
    }
    let mut sent = Sent::nothing();
    for (number, acknowledgement) in waiting {
        let acknowledged = timeout(ACKNOWLEDGEMENT_TIMEOUT, acknowledgement.into_future()).await;
        let acknowledged = acknowledged.unwrap_or_else(|_| Err(PublishErrorKind::TimedOut.into()));
        match acknowledged {
            Ok(stored) if stored.stream == STREAM => sent.add(number),
            Ok(stored) => return sent.failed(NatsError::new(nats, foreign(&stored.stream, &subject))),
            Err(error) => {
                let reason = NatsError::new(nats, explained(&error, settings));
                return match is_full_share(&error) {
                    true => sent.failed(PublisherError::FullShare(reason)),
                    false => sent.failed(reason),
                };
            }
        }
    }
    match published {
        Ok(()) => sent,
        Err(reason) => sent.failed(NatsError::new(nats, reason)),
    }
}

/// Why the acknowledgement of another stream is none.
fn foreign(stream: &str, subject: &str) -> String {
    format!(
        "the stream {stream} has taken the batch, and not {STREAM}, from which the archive reads: delete {subject} from the subjects of \
         {stream}, and start `profivac archive` once, which creates {STREAM}"
    )
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
            alarm_hours: None,
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
