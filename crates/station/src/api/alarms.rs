//! Alarms: what stands, what happened, and what people do about it.

use super::body::Body;
use super::database::{DatabaseReaders, task_failed};
use super::history::{checked_range, parsed_query, time_range};
use super::problem::Problem;
use crate::alarm::view::{AlarmHistoryView, AlarmView};
use crate::alarm::{AlarmError, AlarmServiceError};
use crate::auth::Role;
use crate::control::Actor;
use crate::services::Services;
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
pub struct HistoryQuery {
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
pub struct Acknowledge {
    /// Which time the alarm was raised, as it stands in what they have seen.
    occurrence: i64,
}

/// An alarm that somebody has seen.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AcknowledgeOne {
    /// Its name.
    name: String,
    /// Which time it was raised.
    occurrence: i64,
}

/// Alarms that somebody has seen.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AcknowledgeAll {
    /// All of them, 1 to 1000.
    alarms: Vec<AcknowledgeOne>,
}

/// Why, and for how long.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TakeOutOfService {
    /// Why, in 1 to 500 characters.
    reason: String,
    /// For so many minutes, 1 to 44640; until somebody puts it back if nothing is said.
    minutes: Option<u32>,
}

/// What came of acknowledging several alarms.
#[derive(Debug, Serialize, ToSchema)]
pub struct AcknowledgeAllResult {
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
#[utoipa::path(get, path = "/api/alarms", responses((status = 200, body = [AlarmView])))]
pub async fn alarms(State(plant): State<Arc<Services>>) -> Json<Vec<AlarmView>> {
    Json(plant.alarms().all())
}

/// What happened to alarms, the latest first.
#[utoipa::path(get, path = "/api/alarms/history", params(HistoryQuery), responses((status = 200, body = [AlarmHistoryView]), (status = 400, body = Problem), (status = 503, body = Problem)))]
pub async fn history(
    State(archive): State<DatabaseReaders>,
    past: Result<Query<HistoryQuery>, QueryRejection>,
) -> Result<Json<Vec<AlarmHistoryView>>, Problem> {
    let past = parsed_query(past)?;
    let (from, to) = time_range(past.from, past.to)?;
    let most = checked_range("most", past.most.unwrap_or(200), MOST_LINES)?;
    let read = archive.read(move |reader| {
        let lines = reader.alarm_history(from, to, past.alarm.as_deref(), most)?;
        Ok(Json(lines.into_iter().map(AlarmHistoryView::from).collect()))
    });
    read.await
}

/// Somebody knows of an alarm: of the occurrence they have seen, and of no later one. It is on the disk when this is answered.
#[utoipa::path(
    post,
    path = "/api/alarms/{name}/acknowledge",
    params(("name" = String, Path, description = "The name of the alarm")),
    request_body = Acknowledge,
    responses(
        (status = 200, body = AlarmView),
        (status = 400, body = Problem),
        (status = 403, body = Problem, description = "The role operator is needed"),
        (status = 404, body = Problem),
        (status = 409, body = Problem, description = "It was raised again since, or is acknowledged already"),
        (status = 503, body = Problem, description = "It is done and could not be written to the disk")
    )
)]
pub async fn acknowledge(
    State(plant): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
    Body(seen): Body<Acknowledge>,
) -> Result<Json<AlarmView>, Problem> {
    actor.user.require(Role::Operator, "acknowledging an alarm")?;
    let occurrence = seen.occurrence;
    run_blocking(move || plant.alarms().acknowledge(plant.recorder(), &name, occurrence, &actor)).await
}

/// Somebody knows of several alarms that they have seen. Each is acknowledged or refused for itself.
#[utoipa::path(
    post,
    path = "/api/alarms/acknowledge",
    request_body = AcknowledgeAll,
    responses(
        (status = 200, body = AcknowledgeAllResult),
        (status = 400, body = Problem),
        (status = 403, body = Problem, description = "The role operator is needed")
    )
)]
pub async fn acknowledge_all(
    State(plant): State<Arc<Services>>,
    actor: Actor,
    Body(seen): Body<AcknowledgeAll>,
) -> Result<Json<AcknowledgeAllResult>, Problem> {
    actor.user.require(Role::Operator, "acknowledging alarms")?;
    let seen = seen.alarms;
    if !(1..=MOST_TOGETHER).contains(&seen.len()) {
        return Err(Problem::bad(format!("expected 1 to {MOST_TOGETHER} alarms, got {}", seen.len())));
    }
    let worked = tokio::task::spawn_blocking(move || {
        let mut together = AcknowledgeAllResult { acknowledged: Vec::new(), refused: Vec::new() };
        let seen = seen.into_iter().map(|AcknowledgeOne { name, occurrence }| (name, occurrence)).collect();
        for (name, done) in plant.alarms().acknowledge_all(plant.recorder(), seen, &actor) {
            match done {
                Ok(()) => together.acknowledged.push(name),
                Err(error) => together.refused.push(RefusedAlarm { name, problem: error.to_string() }),
            }
        }
        together
    });
    worked.await.map(Json).map_err(|error| task_failed(&error))
}

/// Takes an alarm out of service, with a reason, for a time or until somebody puts it back.
#[utoipa::path(
    post,
    path = "/api/alarms/{name}/out-of-service",
    params(("name" = String, Path, description = "The name of the alarm")),
    request_body = TakeOutOfService,
    responses(
        (status = 200, body = AlarmView),
        (status = 400, body = Problem),
        (status = 403, body = Problem, description = "The role engineer is needed"),
        (status = 404, body = Problem),
        (status = 409, body = Problem, description = "It is out of service already"),
        (status = 503, body = Problem, description = "It is done and could not be written to the disk")
    )
)]
pub async fn out_of_service(
    State(plant): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
    Body(leave): Body<TakeOutOfService>,
) -> Result<Json<AlarmView>, Problem> {
    actor.user.require(Role::Engineer, "taking an alarm out of service")?;
    let reason = leave.reason.trim().to_owned();
    let length = reason.chars().count();
    if !(1..=LONGEST_REASON).contains(&length) || reason.contains(char::is_control) {
        return Err(Problem::bad(format!("expected a reason in one line of 1 to {LONGEST_REASON} characters")));
    }
    let minutes = leave.minutes.map(|minutes| checked_range("minutes", minutes, LONGEST_MINUTES)).transpose()?;
    let time = minutes.map(|minutes| Duration::from_secs(u64::from(minutes).saturating_mul(60)));
    run_blocking(move || plant.alarms().take_out_of_service(plant.recorder(), &name, &actor, &reason, time)).await
}

/// Puts an alarm back into service. If its condition holds, it is raised at once.
#[utoipa::path(
    post,
    path = "/api/alarms/{name}/return-to-service",
    params(("name" = String, Path, description = "The name of the alarm")),
    responses(
        (status = 200, body = AlarmView),
        (status = 403, body = Problem, description = "The role engineer is needed"),
        (status = 404, body = Problem),
        (status = 409, body = Problem, description = "It is in service"),
        (status = 503, body = Problem, description = "It is done and could not be written to the disk")
    )
)]
pub async fn return_to_service(
    State(plant): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
) -> Result<Json<AlarmView>, Problem> {
    actor.user.require(Role::Engineer, "putting an alarm back into service")?;
    run_blocking(move || plant.alarms().return_to_service(plant.recorder(), &name, &actor)).await
}

/// Who is told of alarms, and how that goes.
#[utoipa::path(get, path = "/api/webhooks", responses((status = 200, body = [WebhookView]), (status = 503, body = Problem)))]
pub async fn webhooks(
    State(plant): State<Arc<Services>>,
    State(archive): State<DatabaseReaders>,
) -> Result<Json<Vec<WebhookView>>, Problem> {
    archive.read(move |reader| Ok(Json(plant.webhooks().views(&reader)?))).await
}

/// Does something that waits for the disk.
async fn run_blocking(
    act: impl FnOnce() -> Result<AlarmView, AlarmServiceError> + Send + 'static,
) -> Result<Json<AlarmView>, Problem> {
    let acted = tokio::task::spawn_blocking(act).await.map_err(|error| task_failed(&error))?;
    acted.map(Json).map_err(Problem::from)
}

impl From<AlarmServiceError> for Problem {
    fn from(error: AlarmServiceError) -> Self {
        let sentence = error.to_string();
        match error {
            AlarmServiceError::Refused(AlarmError::Unknown(_)) => Self::unknown(sentence),
            AlarmServiceError::Refused(AlarmError::OccurrenceChanged { .. } | AlarmError::NotApplicable { .. }) => {
                Self::conflict(sentence)
            }
            AlarmServiceError::NotStored => Self::unavailable(sentence),
        }
    }
}
