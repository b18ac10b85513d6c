//! Alarms: the present state, the history, acknowledging, taking out of service.

use super::database::DatabaseReaders;
use crate::alarm::performance::{AlarmPerformance, Counter, LONG_ACTIVE_AFTER, Raised};
use crate::alarm::service::AlarmResult;
use crate::alarm::view::AlarmView;
use crate::alarm::{AlarmError, AlarmServiceError, MAX_SHELVED_MINUTES, ReasonError, checked_reason};
use crate::services::Services;
use crate::webhook::WebhookView;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Path, Query, State};
use profivac_model::{AlarmHistoryEntry, Micros};
use profivac_web_server::auth::Actor;
use profivac_web_server::auth::Role;
use profivac_web_server::body::Body;
use profivac_web_server::problem::{Problem, task_failed};
use profivac_web_server::query::{checked_range, parsed_query, time_range};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;
use utoipa::{IntoParams, ToSchema};

/// The most entries of an answer.
const MAX_ENTRIES: u32 = 10_000;

/// The longest time out of service with an end, in minutes: 31 days.
const MAX_MINUTES: u32 = 44_640;

/// The most alarms of one request.
const MAX_ALARMS: usize = 1_000;

/// The longest time range of the figures: 366 days.
const MAX_PERFORMANCE_RANGE: i64 = 366 * 86_400 * Micros::SECOND;

/// The time range and the alarm of a history.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct HistoryParameters {
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// The most entries of the answer, 1 to 10000.
    #[param(default = 200, minimum = 1, maximum = 10_000)]
    limit: Option<u32>,
    /// The name of an alarm; without it the history of all alarms.
    alarm: Option<String>,
}

/// The time range of the figures.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct PerformanceQuery {
    /// The beginning, in milliseconds since 1970.
    #[param(example = 1_767_225_600_000_i64)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 1_767_312_000_000_i64)]
    to: i64,
}

/// The occurrence of an alarm that the user has seen.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Acknowledge {
    /// The number of the occurrence, as the alarm shows it.
    #[schema(example = 3)]
    occurrence: i64,
}

/// An occurrence of an alarm that the user has seen.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AcknowledgeOne {
    /// The name of the alarm.
    #[schema(example = "chamber: fault")]
    name: String,
    /// The number of the occurrence, as the alarm shows it.
    #[schema(example = 3)]
    occurrence: i64,
}

/// The alarms that the user has seen.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AcknowledgeAll {
    /// 1 to 1000 alarms.
    #[schema(min_items = 1, max_items = 1000)]
    alarms: Vec<AcknowledgeOne>,
}

/// Why an alarm is taken out of service, and for how long.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TakeOutOfService {
    /// The reason, in one line of 1 to 500 characters.
    #[schema(min_length = 1, max_length = 500, example = "the gauge is being replaced")]
    reason: String,
    /// The time in minutes, 1 to 44640; without it until a user returns the alarm to service.
    #[schema(minimum = 1, maximum = 44_640)]
    minutes: Option<u32>,
}

/// Which alarms are shelved, why, and for how long.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Shelve {
    /// The names of 1 to 1000 alarms.
    #[schema(min_items = 1, max_items = 1000, example = json!(["chamber: fault"]))]
    alarms: Vec<String>,
    /// The reason, in one line of 1 to 500 characters.
    #[schema(min_length = 1, max_length = 500, example = "the lock is vented")]
    reason: String,
    /// The time in minutes, 1 to 720.
    #[schema(minimum = 1, maximum = 720)]
    minutes: u32,
}

/// The alarms that are unshelved.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Unshelve {
    /// The names of 1 to 1000 alarms.
    #[schema(min_items = 1, max_items = 1000, example = json!(["chamber: fault"]))]
    alarms: Vec<String>,
}

/// The result of acknowledging several alarms.
#[derive(Debug, Serialize, ToSchema)]
pub struct AcknowledgeAllResult {
    /// The names of the acknowledged alarms.
    acknowledged: Vec<String>,
    /// The alarms that were not acknowledged.
    refused: Vec<RefusedAlarm>,
}

/// The result of shelving or unshelving several alarms.
#[derive(Debug, Serialize, ToSchema)]
pub struct ChangedAlarms {
    /// The names of the changed alarms.
    changed: Vec<String>,
    /// The alarms that were not changed.
    refused: Vec<RefusedAlarm>,
}

/// An alarm that was not changed.
#[derive(Debug, Serialize, ToSchema)]
pub struct RefusedAlarm {
    /// Its name.
    name: String,
    /// The reason, in a sentence.
    problem: String,
}

/// All alarms: those of the configuration file in its order, then the default alarms
#[utoipa::path(get, path = "/api/alarms", responses((status = 200, body = [AlarmView])))]
pub async fn alarms(State(services): State<Arc<Services>>) -> Json<Vec<AlarmView>> {
    Json(services.alarms().all())
}

/// The history of alarms, the latest change first
#[utoipa::path(
    get,
    path = "/api/alarms/history",
    params(HistoryParameters),
    responses(
        (status = 200, body = [AlarmHistoryEntry]),
        (status = 400, body = Problem, description = "A parameter is missing or out of range"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn history(
    State(readers): State<DatabaseReaders>,
    query: Result<Query<HistoryParameters>, QueryRejection>,
) -> Result<Json<Vec<AlarmHistoryEntry>>, Problem> {
    let query = parsed_query(query)?;
    let (from, to) = time_range(query.from, query.to)?;
    let limit = checked_range("limit", query.limit.unwrap_or(200), MAX_ENTRIES)?;
    readers.read(move |reader| Ok(Json(reader.alarm_history(from, to, query.alarm.as_deref(), limit)?))).await
}

/// Figures of the alarms: how many, how often, which
///
/// After ISA-18.2, clause 16. The time range is at most 366 days long.
#[utoipa::path(
    get,
    path = "/api/alarms/performance",
    params(PerformanceQuery),
    responses(
        (status = 200, body = AlarmPerformance),
        (status = 400, body = Problem, description = "A parameter is missing or out of range"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn performance(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    query: Result<Query<PerformanceQuery>, QueryRejection>,
) -> Result<Json<AlarmPerformance>, Problem> {
    let query = parsed_query(query)?;
    let (from, to) = time_range(query.from, query.to)?;
    if to.0.saturating_sub(from.0) > MAX_PERFORMANCE_RANGE {
        return Err(Problem::bad_request("expected at most 366 days from from to to"));
    }
    let read = readers.read(move |reader| {
        let recorded = reader.recorded_time(from, to, Micros::now())?;
        let mut counter = Counter::new(from, to, recorded);
        reader.each_raised_alarm(from, to, |at, alarm, priority| {
            counter.count(Raised { at, alarm, priority });
        })?;
        let suppressed = reader.suppressed_alarms(from, to)?;
        let long_active = services.alarms().active_since(Micros::now().before(LONG_ACTIVE_AFTER));
        Ok(Json(counter.figures(suppressed, long_active)))
    });
    read.await
}

/// Acknowledge an alarm
///
/// Acknowledges the occurrence that the user has seen, and no later one. The database has the change before the answer.
#[utoipa::path(
    post,
    path = "/api/alarms/{name}/acknowledge",
    params(("name" = String, Path, description = "The name of the alarm", example = "chamber: fault")),
    request_body = Acknowledge,
    responses(
        (status = 200, body = AlarmView),
        (status = 400, body = Problem, description = "The body is malformed"),
        (status = 403, body = Problem, description = "The role operator is needed"),
        (status = 404, body = Problem, description = "There is no alarm of this name"),
        (status = 409, body = Problem, description = "The alarm was raised again since, or is acknowledged already"),
        (status = 503, body = Problem, description = "The alarm is acknowledged, but the database cannot be written")
    )
)]
pub async fn acknowledge(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
    Body(Acknowledge { occurrence }): Body<Acknowledge>,
) -> Result<Json<AlarmView>, Problem> {
    services.control().refusals().require(&actor, Role::Operator, "acknowledging an alarm")?;
    run_blocking(move || services.alarms().acknowledge(&name, occurrence, &actor)).await
}

/// Acknowledge several alarms
///
/// Each alarm is acknowledged or refused on its own.
#[utoipa::path(
    post,
    path = "/api/alarms/acknowledge",
    request_body = AcknowledgeAll,
    responses(
        (status = 200, body = AcknowledgeAllResult),
        (status = 400, body = Problem, description = "The body is malformed, or has no or too many alarms"),
        (status = 403, body = Problem, description = "The role operator is needed")
    )
)]
pub async fn acknowledge_all(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Body(AcknowledgeAll { alarms }): Body<AcknowledgeAll>,
) -> Result<Json<AcknowledgeAllResult>, Problem> {
    services.control().refusals().require(&actor, Role::Operator, "acknowledging alarms")?;
    check_number_of_alarms(alarms.len())?;
    let seen = alarms.into_iter().map(|AcknowledgeOne { name, occurrence }| (name, occurrence)).collect();
    let ChangedAlarms { changed, refused } =
        change_all(move || services.alarms().acknowledge_all(seen, &actor)).await?;
    Ok(Json(AcknowledgeAllResult { acknowledged: changed, refused }))
}

/// Shelve alarms for a while
///
/// A shelved alarm is silent; at its end it is raised at once if its condition holds. Each alarm is shelved or refused on its own.
#[utoipa::path(
    post,
    path = "/api/alarms/shelve",
    request_body = Shelve,
    responses(
        (status = 200, body = ChangedAlarms),
        (status = 400, body = Problem, description = "The body is malformed, or something in it is out of range"),
        (status = 403, body = Problem, description = "The role operator is needed")
    )
)]
pub async fn shelve(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Body(Shelve { alarms, reason, minutes }): Body<Shelve>,
) -> Result<Json<ChangedAlarms>, Problem> {
    services.control().refusals().require(&actor, Role::Operator, "shelving an alarm")?;
    check_number_of_alarms(alarms.len())?;
    let reason = checked_reason(&reason)?;
    let minutes = checked_range("minutes", minutes, MAX_SHELVED_MINUTES)?;
    let time = Duration::from_secs(u64::from(minutes).saturating_mul(60));
    change_all(move || services.alarms().shelve_all(alarms, &actor, &reason, time)).await.map(Json)
}

/// Unshelve alarms
///
/// An alarm whose condition holds is raised at once. Each alarm is unshelved or refused on its own.
#[utoipa::path(
    post,
    path = "/api/alarms/unshelve",
    request_body = Unshelve,
    responses(
        (status = 200, body = ChangedAlarms),
        (status = 400, body = Problem, description = "The body is malformed, or has no or too many alarms"),
        (status = 403, body = Problem, description = "The role operator is needed")
    )
)]
pub async fn unshelve(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Body(Unshelve { alarms }): Body<Unshelve>,
) -> Result<Json<ChangedAlarms>, Problem> {
    services.control().refusals().require(&actor, Role::Operator, "unshelving an alarm")?;
    check_number_of_alarms(alarms.len())?;
    change_all(move || services.alarms().unshelve_all(alarms, &actor)).await.map(Json)
}

fn check_number_of_alarms(number: usize) -> Result<(), Problem> {
    if (1..=MAX_ALARMS).contains(&number) {
        return Ok(());
    }
    Err(Problem::bad_request(format!("expected 1 to {MAX_ALARMS} alarms, found {number}")))
}

/// Runs `work` on a blocking thread, because it waits for the disk.
async fn change_all(work: impl FnOnce() -> Vec<AlarmResult> + Send + 'static) -> Result<ChangedAlarms, Problem> {
    let results = tokio::task::spawn_blocking(work).await.map_err(|error| task_failed(&error))?;
    let mut all = ChangedAlarms { changed: Vec::new(), refused: Vec::new() };
    for (name, done) in results {
        match done {
            Ok(()) => all.changed.push(name),
            Err(error) => all.refused.push(RefusedAlarm { name, problem: error.to_string() }),
        }
    }
    Ok(all)
}

/// Take an alarm out of service, with a reason, for a time or without an end
#[utoipa::path(
    post,
    path = "/api/alarms/{name}/out-of-service",
    params(("name" = String, Path, description = "The name of the alarm", example = "chamber: fault")),
    request_body = TakeOutOfService,
    responses(
        (status = 200, body = AlarmView),
        (status = 400, body = Problem, description = "The body is malformed, or the reason or the time is out of range"),
        (status = 403, body = Problem, description = "The role engineer is needed"),
        (status = 404, body = Problem, description = "There is no alarm of this name"),
        (status = 409, body = Problem, description = "The alarm is already out of service"),
        (status = 503, body = Problem, description = "The alarm is out of service, but the database cannot be written")
    )
)]
pub async fn out_of_service(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
    Body(request): Body<TakeOutOfService>,
) -> Result<Json<AlarmView>, Problem> {
    services.control().refusals().require(&actor, Role::Engineer, "taking an alarm out of service")?;
    let reason = checked_reason(&request.reason)?;
    let minutes = request.minutes.map(|minutes| checked_range("minutes", minutes, MAX_MINUTES)).transpose()?;
    let time = minutes.map(|minutes| Duration::from_secs(u64::from(minutes).saturating_mul(60)));
    run_blocking(move || services.alarms().take_out_of_service(&name, &actor, &reason, time)).await
}

/// Return an alarm to service
///
/// If its condition holds, the alarm is raised at once.
#[utoipa::path(
    post,
    path = "/api/alarms/{name}/return-to-service",
    params(("name" = String, Path, description = "The name of the alarm", example = "chamber: fault")),
    responses(
        (status = 200, body = AlarmView),
        (status = 403, body = Problem, description = "The role engineer is needed"),
        (status = 404, body = Problem, description = "There is no alarm of this name"),
        (status = 409, body = Problem, description = "The alarm is in service"),
        (status = 503, body = Problem, description = "The alarm is in service, but the database cannot be written")
    )
)]
pub async fn return_to_service(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
) -> Result<Json<AlarmView>, Problem> {
    services.control().refusals().require(&actor, Role::Engineer, "returning an alarm to service")?;
    run_blocking(move || services.alarms().return_to_service(&name, &actor)).await
}

/// The webhooks with the status of their deliveries
#[utoipa::path(
    get,
    path = "/api/webhooks",
    responses(
        (status = 200, body = [WebhookView]),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn webhooks(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
) -> Result<Json<Vec<WebhookView>>, Problem> {
    readers.read(move |reader| Ok(Json(services.webhooks().views(&reader)?))).await
}

/// Runs `work` on a blocking thread, because it waits for the disk.
async fn run_blocking(
    work: impl FnOnce() -> Result<AlarmView, AlarmServiceError> + Send + 'static,
) -> Result<Json<AlarmView>, Problem> {
    let done = tokio::task::spawn_blocking(work).await.map_err(|error| task_failed(&error))?;
    done.map(Json).map_err(Problem::from)
}

impl From<ReasonError> for Problem {
    fn from(error: ReasonError) -> Self {
        Self::bad_request(error.to_string())
    }
}

impl From<AlarmServiceError> for Problem {
    fn from(error: AlarmServiceError) -> Self {
        let detail = error.to_string();
        match error {
            AlarmServiceError::Refused(AlarmError::Unknown(_)) => Self::not_found(detail),
            AlarmServiceError::Refused(AlarmError::OccurrenceChanged { .. } | AlarmError::NotApplicable { .. }) => {
                Self::conflict(detail)
            }
            AlarmServiceError::NotStored => Self::unavailable(detail),
        }
    }
}
