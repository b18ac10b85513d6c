//! The server for stations without NATS. It answers a batch after the commit of its transaction, and only then.
//!
//! `POST /v1/PLANT/STATION/EPOCH/NUMBER` with the token of the station as `Authorization: Bearer`, and the octets of the batch as body.
//!
//! | Answer | Meaning |
//! |---|---|
//! | 204 | the batch is committed, or put aside in `profivac_data.rejected` |
//! | 401 | no station of the file has this token |
//! | 403 | the token is that of another station |
//! | 404, 405 | another path, another method |
//! | 410 | no user waits for the reply |
//! | 408 | the body did not come in time |
//! | 413 | the body is too long |
//! | 429 | two batches of this station are on their way |
//! | 503 | the database does not answer, or all permits are taken |
//!
//! A client without a token costs a connection and no memory for a body; the connections and their times have limits. A connection with the
//! token of a station does not end in the place of others.
//!
//! The header `Profivac-Status` of a 204 says, from time to time, what the database has of the station, and which batches it lacks.
//!
//! `requests` has the paths of the requests of users.

use crate::config::{Config, Https, Sender};
use crate::metrics::{Metrics, Transport};
use crate::pending::Pending;
use crate::session::{ArchiveError, Maintenance, Report, Retry, SILENCE, noticed};
use crate::store::{Incoming, SEARCH_INTERVAL, Store, Stored};
use axum::Router;
use axum::body::to_bytes;
use axum::extract::{Path, Request, State};
use axum::http::header::{AUTHORIZATION, CONTENT_LENGTH, RETRY_AFTER, WWW_AUTHENTICATE};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use profivac_archive_protocol::nats::{message_id, of_subject, subject};
use profivac_archive_protocol::request::{STATUS_HEADER, Status};
use profivac_recorder::Micros;
use profivac_web_server::auth::connections::Permit;
use profivac_web_server::server::{Connections, Keys, Limits, ServerError};
use std::collections::HashMap;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use subtle::ConstantTimeEq;
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, mpsc, oneshot, watch};
use tokio::time::{Instant, sleep_until, timeout};

mod requests;

pub use requests::MAX_REPLY;

/// The most octets of a body: a batch of a station is far shorter.
pub const MAX_BODY: usize = 768 << 10;

/// Bodies in memory at the same time.
const MAX_BATCHES: usize = 64;

/// Batches of one station at the same time: a station sends one, and a second one when its connection broke.
const MAX_OF_STATION: usize = 2;

/// Connections at the same time. chosen: below the 1,024 files that a process may open by default.
const MAX_CONNECTIONS: usize = 512;

/// The longest time for the head of a request, for its body, and without a request.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(30);

/// The longest wait for a permit, and for the commit.
const PERMIT_TIMEOUT: Duration = Duration::from_secs(10);
const COMMIT_TIMEOUT: Duration = Duration::from_secs(60);

/// The time between two readings of certificate and key.
const KEYS_PERIOD: Duration = Duration::from_secs(60);

/// Checks certificate and key of `[https.tls]`, without listening.
///
/// # Errors
/// [`ServerError`].
pub fn check(https: &Https) -> Result<(), ServerError> {
    https.tls.clone().map(Keys::read).transpose()?;
    Ok(())
}

/// A batch that waits for its commit.
pub struct Job {
    /// The batch.
    pub message: Incoming,
    /// Gets a message after the commit, and what the station is to be told; it is dropped if there is none.
    pub committed: oneshot::Sender<Option<Status>>,
}

/// A server that has its address and does not serve yet.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    connections: Connections,
    jobs: mpsc::Receiver<Job>,
    pending: Pending,
    metrics: Metrics,
}

/// What all requests share.
struct Shared {
    stations: Vec<Known>,
    permits: Semaphore,
    jobs: mpsc::Sender<Job>,
    pending: Pending,
    metrics: Metrics,
}

/// A station of the file.
struct Known {
    sender: Sender,
    /// Its name as the holder of connections.
    name: Arc<str>,
    /// Permits for its batches.
    batches: Semaphore,
}

impl Known {
    fn of(sender: &Sender) -> Self {
        let name = Arc::from(sender.name.as_str());
        Self { sender: sender.clone(), name, batches: Semaphore::new(MAX_OF_STATION) }
    }
}

impl Shared {
    /// The station whose token the request has, if its path names the same one. Its connection then does not end in the place of others.
    fn authorise(&self, plant: &str, station: &str, request: &Request) -> Result<&Known, Box<Response>> {
        let Some(known) = sender(&self.stations, request.headers()) else {
            let reason = "no [[station]] in the file of the archive has this token: compare token-file at both ends";
            return Err(Box::new(refuse(StatusCode::UNAUTHORIZED, reason)));
        };
        let Sender { plant: own_plant, name, .. } = &known.sender;
        if (plant, station) != (own_plant, name) {
            let reason = format!(
                "the token is that of station {name} of plant {own_plant}: correct plant, station or token-file in [archive]"
            );
            return Err(Box::new(refuse(StatusCode::FORBIDDEN, &reason)));
        }
        if let Some(permit) = request.extensions().get::<Arc<Permit>>() {
            permit.hold_for_station(&known.name);
        }
        Ok(known)
    }
}

impl Server {
    /// Takes the address, and reads certificate and key. It counts in `metrics`.
    ///
    /// # Errors
    /// [`ServerError`].
    pub async fn bind(https: &Https, metrics: &Metrics) -> Result<Self, ServerError> {
        let keys = https.tls.clone().map(Keys::read).transpose()?.map(Arc::new);
        let failed = |error| ServerError::Listen { address: https.listen, error };
        let listener = TcpListener::bind(https.listen).await.map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let (sender, jobs) = mpsc::channel(MAX_BATCHES);
        let stations = https.stations.iter().map(Known::of).collect();
        let pending = Pending::of(&https.stations);
        let (permits, metrics) = (Semaphore::new(MAX_BATCHES), metrics.clone());
        let shared = Shared { stations, permits, jobs: sender, pending: pending.clone(), metrics: metrics.clone() };
        let limits =
            Limits { connections: MAX_CONNECTIONS, head: CLIENT_TIMEOUT, stalled: CLIENT_TIMEOUT, ..Limits::default() };
        let connections = Connections { router: router(Arc::new(shared)), keys, limits, observer: None };
        Ok(Self { listener, address, connections, jobs, pending, metrics })
    }

    /// The requests that its stations poll for.
    #[must_use]
    pub fn pending(&self) -> Pending {
        self.pending.clone()
    }

    /// The address as a URL, with the port that the system has chosen.
    #[must_use]
    pub fn url(&self) -> String {
        format!("{}://{}", if self.connections.keys.is_some() { "https" } else { "http" }, self.address)
    }

    /// Serves batches into the database until it is told to stop.
    pub async fn run(self, config: &Config, stop: watch::Receiver<bool>, report: &mut (impl FnMut(Report<'_>) + Send)) {
        let Self { listener, connections, mut jobs, metrics, .. } = self;
        tokio::select! {
            () = connections.serve(&listener) => {}
            () = renew(connections.keys.as_deref()) => {}
            () = store(config, &mut jobs, &metrics, stop, report) => {}
        }
    }

    /// Serves, and passes each batch to `take`: for tests without a database.
    pub async fn serve_with(self, mut take: impl FnMut(Job)) {
        let Self { listener, connections, mut jobs, .. } = self;
        let taken = async {
            while let Some(job) = jobs.recv().await {
                take(job);
            }
        };
        tokio::select! {
            () = connections.serve(&listener) => {}
            () = taken => {}
        }
    }
}

/// Reads certificate and key again and again, because certificates are renewed. One that cannot be read leaves the former one in use.
async fn renew(keys: Option<&Keys>) {
    let Some(keys) = keys else { return std::future::pending().await };
    loop {
        tokio::time::sleep(KEYS_PERIOD).await;
        keys.renew().ok();
    }
}

fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/v1/{plant}/{station}/{epoch}/{number}", post(batch))
        .route("/v1/{plant}/{station}/request", get(requests::next))
        .route("/v1/{plant}/{station}/request/{id}", post(requests::reply))
        .fallback(async || refuse(StatusCode::NOT_FOUND, "expected /v1/PLANT/STATION/EPOCH/NUMBER"))
        .method_not_allowed_fallback(async || {
            refuse(StatusCode::METHOD_NOT_ALLOWED, "expected POST with a batch or a reply, or GET of a request")
        })
        .with_state(shared)
}

fn refuse(status: StatusCode, reason: &str) -> Response {
    let text = format!("{reason}\n");
    match status {
        StatusCode::UNAUTHORIZED => (status, [(WWW_AUTHENTICATE, "Bearer")], text).into_response(),
        StatusCode::SERVICE_UNAVAILABLE | StatusCode::TOO_MANY_REQUESTS => {
            (status, [(RETRY_AFTER, "5")], text).into_response()
        }
        _ => (status, text).into_response(),
    }
}

/// One batch. The token is checked before the body is read.
async fn batch(
    State(shared): State<Arc<Shared>>,
    Path((plant, station, epoch, number)): Path<(String, String, i64, i64)>,
    request: Request,
) -> Response {
    let known = match shared.authorise(&plant, &station, &request) {
        Ok(known) => known,
        Err(refusal) => return *refusal,
    };
    let Ok(_own) = known.batches.try_acquire() else {
        return refuse(
            StatusCode::TOO_MANY_REQUESTS,
            "two batches of this station are on their way: send one at a time",
        );
    };
    let length = request.headers().get(CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    if length.is_some_and(|length| length > MAX_BODY as u64) {
        return too_long();
    }
    let Ok(Ok(_permit)) = timeout(PERMIT_TIMEOUT, shared.permits.acquire()).await else {
        return refuse(StatusCode::SERVICE_UNAVAILABLE, "all places for batches are taken: send again later");
    };
    let payload = match timeout(CLIENT_TIMEOUT, to_bytes(request.into_body(), MAX_BODY)).await {
        Ok(Ok(payload)) => payload.to_vec(),
        Ok(Err(_)) => return too_long(),
        Err(_) => return refuse(StatusCode::REQUEST_TIMEOUT, "the body did not come within 30 s"),
    };
    let message = Incoming { subject: subject(&plant, &station), id: message_id(&station, epoch, number), payload };
    let (begun, (committed, commit)) = (Instant::now(), oneshot::channel());
    let stored = async {
        shared.jobs.send(Job { message, committed }).await.ok()?;
        commit.await.ok()
    };
    match timeout(COMMIT_TIMEOUT, stored).await {
        Ok(Some(status)) => {
            shared.metrics.answered(begun.elapsed());
            taken(status.as_ref())
        }
        _ => refuse(StatusCode::SERVICE_UNAVAILABLE, "the database of the archive does not answer: send again later"),
    }
}

/// The answer after the commit, with what the station is to be told.
fn taken(status: Option<&Status>) -> Response {
    let json = status.and_then(|status| serde_json::to_vec(status).ok());
    let header = json.and_then(|json| HeaderValue::from_bytes(&json).ok());
    let headers = header.map(|header| (HeaderName::from_static(STATUS_HEADER), header));
    (StatusCode::NO_CONTENT, headers.into_iter().collect::<HeaderMap>()).into_response()
}

fn too_long() -> Response {
    refuse(StatusCode::PAYLOAD_TOO_LARGE, &format!("expected a whole batch of at most {MAX_BODY} octets"))
}

/// The station whose token the request has. The comparison takes the same time wherever the tokens differ.
fn sender<'a>(stations: &'a [Known], headers: &HeaderMap) -> Option<&'a Known> {
    let (scheme, given) = headers.get(AUTHORIZATION)?.to_str().ok()?.split_once(' ')?;
    let is_same = |it: &&Known| bool::from(it.sender.token.reveal().as_bytes().ct_eq(given.trim().as_bytes()));
    stations.iter().filter(|_| scheme.eq_ignore_ascii_case("bearer")).find(is_same)
}

/// Stores batches until it is told to stop. A failure is reported once, and tried again with growing pauses.
async fn store(
    config: &Config,
    jobs: &mut mpsc::Receiver<Job>,
    metrics: &Metrics,
    stop: watch::Receiver<bool>,
    report: &mut (impl FnMut(Report<'_>) + Send),
) {
    let (mut sum, mut retry) = (Stored::default(), Retry::default());
    while !*stop.borrow() {
        // Batches that came during a failure are refused at once, instead of after a time-out.
        while jobs.try_recv().is_ok() {}
        let before = sum;
        metrics.is_up(Transport::Https, false);
        let Err(error) = session(config, jobs, metrics, stop.clone(), &mut sum, report).await else { return };
        metrics.is_up(Transport::Https, false);
        error.count(metrics);
        retry.after(&error, sum != before, stop.clone(), report).await;
    }
}

/// One session with the database.
async fn session(
    config: &Config,
    jobs: &mut mpsc::Receiver<Job>,
    metrics: &Metrics,
    mut stop: watch::Receiver<bool>,
    sum: &mut Stored,
    report: &mut (impl FnMut(Report<'_>) + Send),
) -> Result<(), ArchiveError> {
    let mut store = noticed(SILENCE, Store::open(&config.database, config.samples_days, &config.plants), report)
        .await?
        .counting(metrics);
    let mut maintenance = Maintenance::default();
    maintenance.run(&mut store, metrics, report).await?;
    metrics.is_up(Transport::Https, true);
    report(Report::Ready);
    let mut search_at = Instant::now();
    let mut statuses = HashMap::new();
    loop {
        let mut taken = Vec::new();
        tokio::select! {
            () = async { drop(stop.wait_for(|is_stopped| *is_stopped).await) } => return Ok(()),
            () = sleep_until(maintenance.at.min(search_at)) => {}
            _ = jobs.recv_many(&mut taken, MAX_BATCHES) => {}
        }
        if Instant::now() >= maintenance.at {
            maintenance.run(&mut store, metrics, report).await?;
        }
        if Instant::now() >= search_at {
            let found = noticed(SILENCE, store.find_gaps(), report).await?;
            metrics.is_up(Transport::Https, true);
            statuses = found.into_iter().map(|it| ((it.plant, it.station), it.status)).collect();
            search_at = Instant::now() + SEARCH_INTERVAL;
        }
        if taken.is_empty() {
            continue;
        }
        let (messages, waiting): (Vec<_>, Vec<_>) = taken.into_iter().map(|job| (job.message, job.committed)).unzip();
        sum.add(noticed(SILENCE, store.store(&messages, Micros::now()), report).await?);
        for (message, committed) in messages.iter().zip(waiting) {
            // Once after each search, so that no batch is sent again and again before it is stored.
            let status = of_subject(&message.subject)
                .and_then(|(plant, station)| statuses.remove(&(plant.to_owned(), station.to_owned())));
            // The station may have gone: it sends the batch again, which changes nothing.
            committed.send(status).ok();
        }
        store.take_reports().into_iter().for_each(|sentence| report(Report::PutAside(sentence)));
        report(Report::Stored(*sum));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_web_server::server::TlsFiles;

    #[test]
    fn an_absent_certificate_is_found_without_listening() {
        let tls = Some(TlsFiles { certificate: "absent.pem".into(), key: "absent.key".into() });
        let https = Https { listen: ([127, 0, 0, 1], 0).into(), tls, stations: Vec::new() };
        let error = check(&https).unwrap_err().to_string();
        assert!(error.contains("absent.key"), "{error}");
        assert!(check(&Https { tls: None, ..https }).is_ok());
    }
}
