//! The station's answers to requests of the archive. The file of the station says which requests it answers.

use crate::post::{PostError, Poster};
use async_nats::{Client, Message, Subject};
use futures_util::StreamExt;
use profivac_archive_protocol::nats::NatsError;
use profivac_archive_protocol::request::{MAX_OCTETS, MAX_PIXELS, Reply, Request, Status, subject};
use profivac_recorder::Micros;
use profivac_recorder::Trend;
use profivac_station::config::gateways::archive::{Https, Requests, Settings};
use profivac_station::gateway_status::GatewayStatus;
use profivac_station::services::Services;
use profivac_web_server::auth::secret::RandomSecret;
use profivac_web_server::auth::{Actor, Role, User};
use profivac_web_server::tables::archive::Nats;
use profivac_web_server::visible_text::check_line;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::task::{JoinHandle, spawn_blocking};
use tokio::time::{Instant, sleep};

/// The most characters of the name of a user: `openid:` and 64 for a user of an OpenID provider; accounts have fewer.
const MAX_USER: usize = 71;

/// The most requests that wait in memory for this thread. Others are dropped: their senders get no answer.
pub const MAX_WAITING: usize = 64;

/// The most trends that wait for the one that is read.
const MAX_TRENDS: usize = 4;

/// The shortest time of a poll without a request, and the pauses after a failure.
const SHORTEST_POLL: Duration = Duration::from_secs(1);
const LONGEST_PAUSE: Duration = Duration::from_secs(30);

/// Answers requests until it is dropped: acknowledgements as they come, and beside them one trend after the other, so that a long
/// trend delays no operator.
#[derive(Default)]
pub struct Responder(Vec<JoinHandle<()>>);

impl Drop for Responder {
    fn drop(&mut self) {
        self.0.iter().for_each(JoinHandle::abort);
    }
}

/// Begins to answer requests over NATS, and to pass what the archive has of the station to `told`.
///
/// # Errors
/// [`NatsError`] when the connection has ended.
pub async fn answer_nats(
    client: Client,
    nats: &Nats,
    settings: &Settings,
    services: &Arc<Services>,
    told: mpsc::Sender<Status>,
) -> Result<Responder, NatsError> {
    let mut responder = Responder::default();
    let subject = subject(&settings.plant, &settings.station);
    let mut requests = client.subscribe(subject).await.map_err(|error| NatsError::new(nats, error))?;
    let mut receiver = responder.receiver(client.clone(), client, settings.requests, services);
    responder.0.push(tokio::spawn(async move {
        while let Some(message) = requests.next().await {
            let Message { payload, reply, .. } = message;
            match (decoded(&payload), reply) {
                // The archive tells it again.
                (Ok(Request::Status(status)), _) => drop(told.try_send(status)),
                (request, Some(inbox)) => receiver.take(inbox, request).await,
                (_, None) => {}
            }
        }
    }));
    Ok(responder)
}

/// Begins to poll archives for requests over HTTPS, if the file permits requests. Failures are reported to `status` and tried again.
///
/// # Errors
/// [`PostError`] when the certificates cannot be read.
pub fn answer_https(
    https: &Https,
    settings: &Settings,
    services: &Arc<Services>,
    status: &Arc<GatewayStatus>,
) -> Result<Responder, PostError> {
    let mut responder = Responder::default();
    if settings.requests == Requests::Off {
        return Ok(responder);
    }
    for url in &https.request_urls {
        let poster = || Poster::new(https, url);
        let replies = || Ok::<_, PostError>(Replies { poster: poster()?, settings: settings.clone() });
        let receiver = responder.receiver(replies()?, replies()?, settings.requests, services);
        responder.0.push(tokio::spawn(poll(poster()?, settings.clone(), receiver, Arc::clone(status))));
    }
    Ok(responder)
}

/// Polls one archive again and again.
async fn poll(mut poster: Poster, settings: Settings, mut receiver: Receiver<Replies>, status: Arc<GatewayStatus>) {
    let (mut pause, mut reported) = (SHORTEST_POLL, String::new());
    loop {
        let begun = Instant::now();
        match poster.poll(&settings.plant, &settings.station).await {
            Ok(request) => {
                (pause, reported) = (SHORTEST_POLL, String::new());
                match request {
                    Some((id, body)) => receiver.take(id, decoded(&body)).await,
                    // Another server could answer at once.
                    None => sleep(SHORTEST_POLL.saturating_sub(begun.elapsed())).await,
                }
            }
            Err(error) => {
                let error = format!("requests of users do not come: {error}");
                if error != reported {
                    status.error(&error);
                }
                reported = error;
                sleep(pause).await;
                pause = pause.saturating_mul(2).min(LONGEST_PAUSE);
            }
        }
    }
}

/// Where replies go.
trait Outlet: Send + 'static {
    /// Names a request.
    type Id: Send + 'static;

    /// Sends a reply. A user who is gone needs none.
    fn send(&mut self, id: Self::Id, reply: Reply) -> impl Future<Output = ()> + Send;
}

impl Outlet for Client {
    type Id = Subject;

    async fn send(&mut self, inbox: Subject, reply: Reply) {
        self.publish(inbox, encoded(&reply).into()).await.ok();
    }
}

/// Replies to an archive over HTTPS.
struct Replies {
    poster: Poster,
    settings: Settings,
}

impl Outlet for Replies {
    type Id = RandomSecret;

    async fn send(&mut self, id: RandomSecret, reply: Reply) {
        let Settings { plant, station, .. } = &self.settings;
        self.poster.reply(plant, station, &id, encoded(&reply)).await.ok();
    }
}

fn encoded(reply: &Reply) -> Vec<u8> {
    serde_json::to_vec(reply).unwrap_or_default()
}

/// Takes the requests of one archive, or of all behind the servers of NATS.
struct Receiver<O: Outlet> {
    outlet: O,
    answers: Answers,
    trends: mpsc::Sender<(O::Id, Request)>,
}

impl<O: Outlet> Receiver<O> {
    async fn take(&mut self, id: O::Id, request: Result<Request, String>) {
        match request {
            Ok(request @ Request::Trend { .. }) => {
                if let Err(error) = self.trends.try_send((id, request)) {
                    let (id, _) = error.into_inner();
                    self.outlet.send(id, Reply::Busy).await;
                }
            }
            Ok(request) => {
                let reply = self.answers.to(request).await;
                self.outlet.send(id, reply).await;
            }
            Err(reason) => self.outlet.send(id, Reply::Refused(reason)).await,
        }
    }
}

impl Responder {
    /// A receiver, with a task of its own that reads trends and sends them to the second outlet.
    fn receiver<O: Outlet>(
        &mut self,
        outlet: O,
        mut of_trends: O,
        permitted: Requests,
        services: &Arc<Services>,
    ) -> Receiver<O> {
        let (trends, mut waiting) = mpsc::channel(MAX_TRENDS);
        let answers = Answers { permitted, services: Arc::clone(services) };
        let reading = answers.clone();
        self.0.push(tokio::spawn(async move {
            while let Some((id, request)) = waiting.recv().await {
                let reply = reading.to(request).await;
                of_trends.send(id, reply).await;
            }
        }));
        Receiver { outlet, answers, trends }
    }
}

/// What the answers need.
#[derive(Clone)]
struct Answers {
    permitted: Requests,
    services: Arc<Services>,
}

impl Answers {
    /// Answers on a thread that may wait for the disk.
    async fn to(&self, request: Request) -> Reply {
        let (permitted, services) = (self.permitted, Arc::clone(&self.services));
        let reply =
            spawn_blocking(move || answered(request, permitted, &services).unwrap_or_else(Reply::Refused)).await;
        let defect = |_| Reply::Refused("a defect of the station; it continues to run".to_owned());
        reply.unwrap_or_else(defect)
    }
}

fn decoded(payload: &[u8]) -> Result<Request, String> {
    if payload.len() > MAX_OCTETS {
        return Err(format!("expected a request of at most {MAX_OCTETS} octets, found {}", payload.len()));
    }
    serde_json::from_slice(payload).map_err(|error| format!("expected a request: {error}"))
}

/// The answer, or the reason of a refusal.
fn answered(request: Request, permitted: Requests, services: &Services) -> Result<Reply, String> {
    if permitted == Requests::Off {
        return Err(
            "the file of this station permits no requests: requests = \"read\" or \"acknowledge\" in [archive] does"
                .to_owned(),
        );
    }
    match request {
        Request::Trend { series, from_ms, to_ms, pixels } => {
            if !(1..=MAX_PIXELS).contains(&pixels) || from_ms >= to_ms {
                return Err(format!("expected 1 to {MAX_PIXELS} pixels and a beginning before the end"));
            }
            let time = |ms: i64| Micros(ms.saturating_mul(1000));
            let reader = services.recorder().open_reader().map_err(|error| error.to_string())?;
            let spans = reader.trend(&series, time(from_ms), time(to_ms), pixels).map_err(|error| error.to_string())?;
            Ok(Reply::Trend(Trend::of(&series, &spans)))
        }
        Request::Acknowledge { alarm, occurrence, user } => {
            if permitted < Requests::Acknowledge {
                return Err(
                    "the file of this station does not permit it: requests = \"acknowledge\" in [archive] does"
                        .to_owned(),
                );
            }
            if user.chars().count() > MAX_USER || check_line(&user).is_err() {
                return Err(format!("expected the name of a user of 1 to {MAX_USER} visible characters"));
            }
            services.alarms().acknowledge(&alarm, occurrence, &operator(&user)).map_err(|error| error.to_string())?;
            Ok(Reply::Done)
        }
        Request::Status(_) => Err("expected the request of a user".to_owned()),
    }
}

/// The operator as the audit trail of the station names them: no account of the station has a colon in its name.
fn operator(user: &str) -> Actor {
    Actor { user: User { name: Arc::from(format!("archive:{user}")), role: Role::Operator }, peer: None }
}
