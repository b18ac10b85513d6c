//! Alarms: what stands, what happened, and what people do about it.

use super::archive::{Archive, stopped};
use super::body::Body;
use super::problem::Problem;
use super::recorded::{taken, times, within};
use crate::act::Actor;
use crate::alarm::view::{Alarm, Event};
use crate::alarm::{NotDone, Refusal};
use crate::people::Role;
use crate::plant::Plant;
use crate::webhook::WebhookView;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Path, Query, State};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;
use utoipa::{IntoParams, ToSchema};

/// More lines than anybody reads at once.
const MOST_LINES: u32 = 10_000;

/// The longest reason, in characters.
const LONGEST_REASON: usize = 500;

/// The longest time out of service with an end, in minutes: a month.
const LONGEST_MINUTES: u32 = 44_640;

/// So many can be acknowledged together.
const MOST_TOGETHER: usize = 1_000;

/// Which time, and of which alarm.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct Past {
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// How many at most, 1 to 10000; 200 if nothing is said.
    most: Option<u32>,
    /// The name of an alarm; all if nothing is said.
    alarm: Option<String>,
}

/// What somebody has seen.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Seen {
    /// Which time the alarm was raised, as it stands in what they have seen.
    occurrence: i64,
}

/// An alarm that somebody has seen.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SeenAlarm {
    /// Its name.
    name: String,
    /// Which time it was raised.
    occurrence: i64,
}

/// Alarms that somebody has seen.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SeenAlarms {
    /// All of them, 1 to 1000.
    alarms: Vec<SeenAlarm>,
}

/// Why, and for how long.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Leave {
    /// Why, in 1 to 500 characters.
    reason: String,
    /// For so many minutes, 1 to 44640; until somebody puts it back if nothing is said.
    minutes: Option<u32>,
}

/// What came of acknowledging several alarms.
#[derive(Debug, Serialize, ToSchema)]
pub struct Together {
    /// Those that were acknowledged.
    acknowledged: Vec<String>,
    /// Those that were not.
    refused: Vec<RefusedAlarm>,
}

/// An alarm that was not acknowledged.
#[derive(Debug, Serialize, ToSchema)]
pub struct RefusedAlarm {
    /// Its name.
    name: String,
    /// Why.
    problem: String,
}

/// All alarms, in the order of the file, then those that there are by themselves.
#[utoipa::path(get, path = "/api/alarms", responses((status = 200, body = [Alarm])))]
pub async fn alarms(State(plant): State<Arc<Plant>>) -> Json<Vec<Alarm>> {
    Json(plant.alarms().all())
}

/// What happened to alarms, the latest first.
#[utoipa::path(get, path = "/api/alarms/history", params(Past), responses((status = 200, body = [Event]), (status = 400, body = Problem), (status = 503, body = Problem)))]
pub async fn history(
    State(archive): State<Archive>,
    past: Result<Query<Past>, QueryRejection>,
) -> Result<Json<Vec<Event>>, Problem> {
    let past = taken(past)?;
    let (from, to) = times(past.from, past.to)?;
    let most = within("most", past.most.unwrap_or(200), MOST_LINES)?;
    let read = archive.read(move |reader| {
        let lines = reader.alarm_history(from, to, past.alarm.as_deref(), most)?;
        Ok(Json(lines.into_iter().map(Event::from).collect()))
    });
    read.await
}

/// Somebody knows of an alarm: of the occurrence they have seen, and of no later one. It is on the disk when this is answered.
#[utoipa::path(
    post,
    path = "/api/alarms/{name}/acknowledge",
    params(("name" = String, Path, description = "The name of the alarm")),
    request_body = Seen,
    responses(
        (status = 200, body = Alarm),
        (status = 400, body = Problem),
        (status = 403, body = Problem, description = "The role operator is needed"),
        (status = 404, body = Problem),
        (status = 409, body = Problem, description = "It was raised again since, or is acknowledged already"),
        (status = 503, body = Problem, description = "It is done and could not be written to the disk")
    )
)]
pub async fn acknowledge(
    State(plant): State<Arc<Plant>>,
    actor: Actor,
    Path(name): Path<String>,
    Body(seen): Body<Seen>,
) -> Result<Json<Alarm>, Problem> {
    actor.person.may(Role::Operator, "acknowledging an alarm")?;
    let occurrence = seen.occurrence;
    act(move || plant.alarms().acknowledge(plant.recorder(), &name, occurrence, &actor)).await
}

/// Somebody knows of several alarms that they have seen. Each is acknowledged or refused for itself.
#[utoipa::path(
    post,
    path = "/api/alarms/acknowledge",
    request_body = SeenAlarms,
    responses(
        (status = 200, body = Together),
        (status = 400, body = Problem),
        (status = 403, body = Problem, description = "The role operator is needed")
    )
)]
pub async fn acknowledge_all(
    State(plant): State<Arc<Plant>>,
    actor: Actor,
    Body(seen): Body<SeenAlarms>,
) -> Result<Json<Together>, Problem> {
    actor.person.may(Role::Operator, "acknowledging alarms")?;
    let seen = seen.alarms;
    if !(1..=MOST_TOGETHER).contains(&seen.len()) {
        return Err(Problem::bad(format!("expected 1 to {MOST_TOGETHER} alarms, got {}", seen.len())));
    }
    let worked = tokio::task::spawn_blocking(move || {
        let mut together = Together { acknowledged: Vec::new(), refused: Vec::new() };
        let seen = seen.into_iter().map(|SeenAlarm { name, occurrence }| (name, occurrence)).collect();
        for (name, done) in plant.alarms().acknowledge_all(plant.recorder(), seen, &actor) {
            match done {
                Ok(()) => together.acknowledged.push(name),
                Err(error) => together.refused.push(RefusedAlarm { name, problem: error.to_string() }),
            }
        }
        together
    });
    worked.await.map(Json).map_err(|error| stopped(&error))
}

/// Takes an alarm out of service, with a reason, for a time or until somebody puts it back.
#[utoipa::path(
    post,
    path = "/api/alarms/{name}/out-of-service",
    params(("name" = String, Path, description = "The name of the alarm")),
    request_body = Leave,
    responses(
        (status = 200, body = Alarm),
        (status = 400, body = Problem),
        (status = 403, body = Problem, description = "The role engineer is needed"),
        (status = 404, body = Problem),
        (status = 409, body = Problem, description = "It is out of service already"),
        (status = 503, body = Problem, description = "It is done and could not be written to the disk")
    )
)]
pub async fn out_of_service(
    State(plant): State<Arc<Plant>>,
    actor: Actor,
    Path(name): Path<String>,
    Body(leave): Body<Leave>,
) -> Result<Json<Alarm>, Problem> {
    actor.person.may(Role::Engineer, "taking an alarm out of service")?;
    let reason = leave.reason.trim().to_owned();
    let length = reason.chars().count();
    if !(1..=LONGEST_REASON).contains(&length) || reason.contains(char::is_control) {
        return Err(Problem::bad(format!("expected a reason in one line of 1 to {LONGEST_REASON} characters")));
    }
    let minutes = leave.minutes.map(|minutes| within("minutes", minutes, LONGEST_MINUTES)).transpose()?;
    let time = minutes.map(|minutes| Duration::from_secs(u64::from(minutes).saturating_mul(60)));
    act(move || plant.alarms().take_out(plant.recorder(), &name, &actor, &reason, time)).await
}

/// Puts an alarm back into service. If its condition holds, it is raised at once.
#[utoipa::path(
    post,
    path = "/api/alarms/{name}/return-to-service",
    params(("name" = String, Path, description = "The name of the alarm")),
    responses(
        (status = 200, body = Alarm),
        (status = 403, body = Problem, description = "The role engineer is needed"),
        (status = 404, body = Problem),
        (status = 409, body = Problem, description = "It is in service"),
        (status = 503, body = Problem, description = "It is done and could not be written to the disk")
    )
)]
pub async fn return_to_service(
    State(plant): State<Arc<Plant>>,
    actor: Actor,
    Path(name): Path<String>,
) -> Result<Json<Alarm>, Problem> {
    actor.person.may(Role::Engineer, "putting an alarm back into service")?;
    act(move || plant.alarms().put_back(plant.recorder(), &name, &actor)).await
}

/// Who is told of alarms, and how that goes.
#[utoipa::path(get, path = "/api/webhooks", responses((status = 200, body = [WebhookView]), (status = 503, body = Problem)))]
pub async fn webhooks(
    State(plant): State<Arc<Plant>>,
    State(archive): State<Archive>,
) -> Result<Json<Vec<WebhookView>>, Problem> {
    archive.read(move |reader| Ok(Json(plant.webhooks().views(&reader)?))).await
}

/// Does something that waits for the disk.
async fn act(act: impl FnOnce() -> Result<Alarm, NotDone> + Send + 'static) -> Result<Json<Alarm>, Problem> {
    let acted = tokio::task::spawn_blocking(act).await.map_err(|error| stopped(&error))?;
    acted.map(Json).map_err(Problem::from)
}

impl From<NotDone> for Problem {
    fn from(error: NotDone) -> Self {
        let sentence = error.to_string();
        match error {
            NotDone::Refused(Refusal::Unknown(_)) => Self::unknown(sentence),
            NotDone::Refused(Refusal::Changed { .. } | Refusal::Idle { .. }) => Self::conflict(sentence),
            NotDone::Unwritten => Self::unavailable(sentence),
        }
    }
}
