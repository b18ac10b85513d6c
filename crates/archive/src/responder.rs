//! The station's answers to requests of the archive. The file of the station says which requests it answers.

use crate::nats::NatsError;
use crate::request::{MAX_PIXELS, Reply, Request, subject};
use async_nats::{Client, Message, Subject};
use futures_util::StreamExt;
use profivac_recorder::Micros;
use profivac_station::auth::{Actor, Role, User};
use profivac_station::config::gateways::archive::{Nats, Requests, Settings};
use profivac_station::services::Services;
use profivac_station::view::Trend;
use profivac_station::visible_text::check_line;
use std::sync::Arc;
use tokio::sync::mpsc;
use tokio::task::{JoinHandle, spawn_blocking};

/// The most octets of a request: names of alarms and series are far shorter.
const MAX_OCTETS: usize = 8 << 10;

/// The most characters of the name of a user: `openid:` and 64 for a user of an OpenID provider; accounts have fewer.
const MAX_USER: usize = 71;

/// The most requests that wait in memory for this thread. Others are dropped: their senders get no answer.
pub const MAX_WAITING: usize = 64;

/// The most trends that wait for the one that is read.
const MAX_TRENDS: usize = 4;

/// Answers requests until it is dropped: acknowledgements as they come, and beside them one trend after the other, so that a long
/// trend delays no operator.
pub struct Responder([JoinHandle<()>; 2]);

impl Drop for Responder {
    fn drop(&mut self) {
        self.0.iter().for_each(JoinHandle::abort);
    }
}

/// Begins to answer; `None` if the file permits no requests.
///
/// # Errors
/// [`NatsError`] when the connection has ended.
pub async fn start(
    client: Client,
    nats: &Nats,
    settings: &Settings,
    services: &Arc<Services>,
) -> Result<Option<Responder>, NatsError> {
    if settings.requests == Requests::Off {
        return Ok(None);
    }
    let subject = subject(&settings.plant, &settings.station);
    let mut requests = client.subscribe(subject).await.map_err(|error| NatsError::new(nats, error))?;
    let (trends, waiting) = mpsc::channel(MAX_TRENDS);
    let answers = Answers { client, permitted: settings.requests, services: Arc::clone(services) };
    let of_trends = tokio::spawn(answer_trends(answers.clone(), waiting));
    let of_others = tokio::spawn(async move {
        while let Some(message) = requests.next().await {
            let Message { payload, reply: Some(inbox), .. } = message else { continue };
            match decoded(&payload) {
                Ok(request @ Request::Trend { .. }) => {
                    if let Err(error) = trends.try_send((inbox, request)) {
                        let (inbox, _) = error.into_inner();
                        answers.send(inbox, Reply::Busy).await;
                    }
                }
                Ok(request) => answers.answer(inbox, request).await,
                Err(reason) => answers.send(inbox, Reply::Refused(reason)).await,
            }
        }
    });
    Ok(Some(Responder([of_trends, of_others])))
}

async fn answer_trends(answers: Answers, mut waiting: mpsc::Receiver<(Subject, Request)>) {
    while let Some((inbox, request)) = waiting.recv().await {
        answers.answer(inbox, request).await;
    }
}

/// What both tasks need.
#[derive(Clone)]
struct Answers {
    client: Client,
    permitted: Requests,
    services: Arc<Services>,
}

impl Answers {
    /// Answers on a thread that may wait for the disk.
    async fn answer(&self, inbox: Subject, request: Request) {
        let (permitted, services) = (self.permitted, Arc::clone(&self.services));
        let reply =
            spawn_blocking(move || answered(request, permitted, &services).unwrap_or_else(Reply::Refused)).await;
        let defect = |_| Reply::Refused("a defect of the station; it continues to run".to_owned());
        self.send(inbox, reply.unwrap_or_else(defect)).await;
    }

    async fn send(&self, inbox: Subject, reply: Reply) {
        // A client that is gone needs no answer.
        self.client.publish(inbox, serde_json::to_vec(&reply).unwrap_or_default().into()).await.ok();
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
    }
}

/// The operator as the audit trail of the station names them: no account of the station has a colon in its name.
fn operator(user: &str) -> Actor {
    Actor { user: User { name: Arc::from(format!("archive:{user}")), role: Role::Operator }, peer: None }
}
