//! Plant states: what they are, declaring, extending and ending them.

use crate::alarm::view::PlantStateView;
use crate::alarm::{PlantStateError, PlantStateServiceError, checked_reason};
use crate::services::Services;
use axum::Json;
use axum::extract::{Path, State};
use profivac_web_server::auth::{Actor, Role};
use profivac_web_server::body::Body;
use profivac_web_server::problem::{Problem, task_failed};
use serde::Deserialize;
use std::sync::Arc;
use std::time::Duration;
use utoipa::ToSchema;

/// Why a plant state is declared or extended, and for how long.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Declare {
    /// The reason, in one line of 1 to 500 characters.
    #[schema(min_length = 1, max_length = 500, example = "the target is changed")]
    reason: String,
    /// The time in minutes from now, 1 to the longest time of the plant state.
    #[schema(minimum = 1, maximum = 44_640)]
    minutes: u32,
}

/// Why a plant state is ended.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct End {
    /// The reason, in one line of 1 to 500 characters; without it the audit trail has none.
    #[schema(min_length = 1, max_length = 500, example = "the target is changed")]
    reason: Option<String>,
}

/// All plant states of the station's file, with their declarations
#[utoipa::path(get, path = "/api/plant-states", responses((status = 200, body = [PlantStateView])))]
pub async fn plant_states(State(services): State<Arc<Services>>) -> Json<Vec<PlantStateView>> {
    Json(services.alarms().plant_states())
}

/// Declare a plant state for a time
///
/// Its alarms are suppressed at once; at its end those whose conditions hold are raised. The database has the change before the answer.
#[utoipa::path(
    post,
    path = "/api/plant-states/{name}/declare",
    params(("name" = String, Path, description = "The name of the plant state", example = "Vented")),
    request_body = Declare,
    responses(
        (status = 200, body = PlantStateView),
        (status = 400, body = Problem, description = "The body is malformed, or the reason or the time is out of range"),
        (status = 403, body = Problem, description = "The role of the plant state is needed"),
        (status = 404, body = Problem, description = "There is no plant state of this name"),
        (status = 409, body = Problem, description = "The plant state is declared already"),
        (status = 503, body = Problem, description = "The plant state is declared, but the database cannot be written")
    )
)]
pub async fn declare(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
    Body(Declare { reason, minutes }): Body<Declare>,
) -> Result<Json<PlantStateView>, Problem> {
    require(&services, &actor, &name, "declaring")?;
    let reason = checked_reason(&reason)?;
    run_blocking(move || services.alarms().declare(&name, &actor, &reason, time(minutes))).await
}

/// Give a declared plant state a later end
///
/// The user who declared it stays; the reason is the new one.
#[utoipa::path(
    post,
    path = "/api/plant-states/{name}/extend",
    params(("name" = String, Path, description = "The name of the plant state", example = "Vented")),
    request_body = Declare,
    responses(
        (status = 200, body = PlantStateView),
        (status = 400, body = Problem, description = "The body is malformed, or the reason or the time is out of range"),
        (status = 403, body = Problem, description = "The role of the plant state is needed"),
        (status = 404, body = Problem, description = "There is no plant state of this name"),
        (status = 409, body = Problem, description = "The plant state is not declared, or has a later end already"),
        (status = 503, body = Problem, description = "The plant state is extended, but the database cannot be written")
    )
)]
pub async fn extend(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
    Body(Declare { reason, minutes }): Body<Declare>,
) -> Result<Json<PlantStateView>, Problem> {
    require(&services, &actor, &name, "extending")?;
    let reason = checked_reason(&reason)?;
    run_blocking(move || services.alarms().extend(&name, &actor, &reason, time(minutes))).await
}

/// End a declared plant state
///
/// The alarms whose conditions hold are raised at once. Every operator ends every plant state.
#[utoipa::path(
    post,
    path = "/api/plant-states/{name}/end",
    params(("name" = String, Path, description = "The name of the plant state", example = "Vented")),
    request_body = End,
    responses(
        (status = 200, body = PlantStateView),
        (status = 400, body = Problem, description = "The body is malformed, or the reason is out of range"),
        (status = 403, body = Problem, description = "The role operator is needed"),
        (status = 404, body = Problem, description = "There is no plant state of this name"),
        (status = 409, body = Problem, description = "The plant state is not declared"),
        (status = 503, body = Problem, description = "The plant state has ended, but the database cannot be written")
    )
)]
pub async fn end(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
    Body(End { reason }): Body<End>,
) -> Result<Json<PlantStateView>, Problem> {
    services.control().refusals().require(&actor, Role::Operator, "ending a plant state")?;
    let reason = reason.map(|reason| checked_reason(&reason)).transpose()?.unwrap_or_default();
    run_blocking(move || services.alarms().end_plant_state(&name, &actor, &reason)).await
}

/// Requires the role that the station's file has for the plant state.
fn require(services: &Services, actor: &Actor, name: &str, what: &str) -> Result<(), Problem> {
    services.control().refusals().require(actor, Role::Operator, &format!("{what} a plant state"))?;
    let role = services.alarms().role_of_plant_state(name).map_err(PlantStateServiceError::from)?;
    Ok(services.control().refusals().require(actor, role, &format!("{what} the plant state {name}"))?)
}

fn time(minutes: u32) -> Duration {
    Duration::from_secs(u64::from(minutes).saturating_mul(60))
}

/// Runs `work` on a blocking thread, because it waits for the disk.
async fn run_blocking(
    work: impl FnOnce() -> Result<PlantStateView, PlantStateServiceError> + Send + 'static,
) -> Result<Json<PlantStateView>, Problem> {
    let done = tokio::task::spawn_blocking(work).await.map_err(|error| task_failed(&error))?;
    done.map(Json).map_err(Problem::from)
}

impl From<PlantStateServiceError> for Problem {
    fn from(error: PlantStateServiceError) -> Self {
        let detail = error.to_string();
        match error {
            PlantStateServiceError::Refused(PlantStateError::Unknown { .. }) => Self::not_found(detail),
            PlantStateServiceError::Refused(PlantStateError::Time { .. }) => Self::bad_request(detail),
            PlantStateServiceError::Refused(
                PlantStateError::Declared { .. }
                | PlantStateError::NotDeclared { .. }
                | PlantStateError::NotLater { .. },
            ) => Self::conflict(detail),
            PlantStateServiceError::NotStored => Self::unavailable(detail),
        }
    }
}
