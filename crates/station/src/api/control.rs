//! Acting on gauges: the list of commands, arming, firing, and who has the mastership.

use super::body::Body;
use super::database::task_failed;
use super::middleware::Peer;
use super::problem::Problem;
use crate::auth::{Role, User};
use crate::control::armed_commands::ArmedCommand;
use crate::control::operation::OperationRequest;
use crate::control::permissions::{self, Risk};
use crate::control::{self, Actor, AuthorityAction, ControlError, Executed};
use crate::services::Services;
use crate::view::{ControlAuthorityView, duration_ms};
use axum::Json;
use axum::extract::{FromRequestParts, Path, State};
use axum::http::StatusCode;
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use profivac_client::Condition;
use profivac_client::conditions::required_texts;
use profivac_client::names::{ParameterNames, command_name};
use profivac_virtual::device_spec::entry;
use serde::Serialize;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Instant;
use utoipa::ToSchema;

/// A command of a gauge.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Command {
    /// By what it is armed: `ba.degas-on`.
    command: String,
    /// The manual's name of the parameter by which it is sent.
    name: String,
    /// Its slot and index.
    numbers: String,
    /// What must be the case.
    conditions: Vec<String>,
    /// What it risks.
    risk: Risk,
    /// Who may.
    role: Role,
    /// Why nobody may from here.
    barred: Option<String>,
}

/// A condition, and whether it holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ConditionView {
    /// What must be the case.
    wanted: String,
    /// What is the case.
    found: String,
    /// Whether that is enough.
    holds: bool,
}

impl ConditionView {
    fn of(conditions: &[Condition]) -> Vec<Self> {
        let held = |condition: &Condition| Self {
            wanted: condition.required.clone(),
            found: condition.found.clone(),
            holds: condition.unmet.is_none(),
        };
        conditions.iter().map(held).collect()
    }
}

/// Something that is armed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ArmedCommandView {
    /// By what it is fired.
    order: String,
    /// The gauge.
    gauge: String,
    /// The command or the parameter.
    target: String,
    /// The manual's name and numbers.
    manual: String,
    /// Whether it is a command.
    is_command: bool,
    /// What it is now; nothing if it cannot be read.
    before: Option<String>,
    /// What it is to be.
    after: String,
    /// The octets that are sent.
    octets: String,
    /// What it risks.
    risk: Risk,
    /// All conditions; all hold.
    conditions: Vec<ConditionView>,
    /// How much longer it is armed, in milliseconds.
    left_ms: u64,
}

impl From<ArmedCommand> for ArmedCommandView {
    fn from(order: ArmedCommand) -> Self {
        let ArmedCommand { id, gauge, operation: choice, preview: draft, expires_at: until, .. } = order;
        Self {
            order: id,
            gauge,
            target: choice.target(),
            manual: choice.manual_name(),
            is_command: choice.command.is_some(),
            octets: draft.octets_as_hex(),
            before: draft.before.map(|(text, _)| text),
            after: draft.after,
            risk: draft.risk,
            conditions: ConditionView::of(&draft.conditions),
            left_ms: duration_ms(until.saturating_duration_since(Instant::now())),
        }
    }
}

/// Something that was fired and done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ExecutedView {
    /// The order.
    order: String,
    /// The gauge.
    gauge: String,
    /// The command or the parameter.
    target: String,
    /// The octets that were sent.
    octets: String,
    /// What it was.
    before: Option<String>,
    /// What it is now, as it was read back; nothing if it cannot be read.
    after: Option<String>,
}

impl From<Executed> for ExecutedView {
    fn from(Executed { order, done }: Executed) -> Self {
        let octets = order.preview.octets_as_hex();
        let target = order.operation.target();
        Self { order: order.id, gauge: order.gauge, target, octets, before: done.before, after: done.after }
    }
}

/// Why nothing was armed or done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ConflictView {
    /// In a sentence.
    problem: String,
    /// All conditions, if one of them is the reason.
    conditions: Vec<ConditionView>,
}

impl IntoResponse for ControlError {
    fn into_response(self) -> Response {
        let sentence = self.to_string();
        match self {
            Self::Unknown(_) => Problem::unknown(sentence).into_response(),
            Self::Bad(_) => Problem::bad(sentence).into_response(),
            Self::Forbidden(_) => Problem::forbidden(sentence).into_response(),
            Self::Disk(_) => Problem::unavailable(sentence).into_response(),
            Self::Conflict(_, conditions) => {
                let unmet = ConflictView { problem: sentence, conditions: ConditionView::of(&conditions) };
                (StatusCode::CONFLICT, Json(unmet)).into_response()
            }
        }
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Actor {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Infallible> {
        let person = User::from_request_parts(parts, state).await?;
        let peer = parts.extensions.get::<Peer>().map(|Peer(peer)| *peer);
        Ok(Self { user: person, peer })
    }
}

/// Something that waits, on a thread that may. It goes on when whoever asked has gone.
async fn run_blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, ControlError> + Send + 'static,
) -> Result<T, Response> {
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(done)) => Ok(done),
        Ok(Err(error)) => Err(error.into_response()),
        Err(error) => Err(task_failed(&error).into_response()),
    }
}

/// The commands of a gauge with what they ask for and risk. The gauge is not asked.
#[utoipa::path(
    get,
    path = "/api/gauges/{name}/commands",
    params(("name" = String, Path, description = "The name of the gauge")),
    responses((status = 200, body = [Command]), (status = 404, body = Problem))
)]
pub async fn commands(
    State(plant): State<Arc<Services>>,
    Path(name): Path<String>,
) -> Result<Json<Vec<Command>>, Problem> {
    let unknown = || Problem::unknown(format!("there is no gauge {name:?}"));
    let gauge = plant.gauge(&name).ok_or_else(unknown)?;
    let names = entry(&gauge.device).ok().and_then(|entry| ParameterNames::of_catalog(entry.model));
    let Some(names) = names else { return Ok(Json(Vec::new())) };
    let command = |(named, code): (&profivac_client::names::NamedParameter, _)| {
        let row = named.parameter.row;
        Command {
            command: command_name(named, code),
            name: row.name.to_owned(),
            numbers: named.parameter.numbers(),
            conditions: required_texts(names, named, code),
            risk: permissions::risk(row, Some(code)),
            role: permissions::role(row, Some(code)),
            barred: permissions::blocked_reason(row).map(str::to_owned),
        }
    };
    Ok(Json(names.commands().map(command).collect()))
}

/// The first step: the gauge is asked, and if all conditions hold it is armed for 30 seconds. Needs the mastership.
#[utoipa::path(
    post,
    path = "/api/gauges/{name}/arm",
    params(("name" = String, Path, description = "The name of the gauge")),
    request_body = OperationRequest,
    responses(
        (status = 200, body = ArmedCommandView),
        (status = 400, body = Problem),
        (status = 403, body = Problem),
        (status = 404, body = Problem),
        (status = 408, body = Problem, description = "The body did not come"),
        (status = 409, body = ConflictView, description = "Not the mastership, a condition that does not hold, or a gauge that does not answer"),
        (status = 413, body = Problem, description = "The body is too long"),
        (status = 415, body = Problem, description = "The body is no JSON")
    )
)]
pub async fn arm(
    State(plant): State<Arc<Services>>,
    Path(name): Path<String>,
    actor: Actor,
    Body(wish): Body<OperationRequest>,
) -> Result<Json<ArmedCommandView>, Response> {
    let order = run_blocking(move || control::arm(&plant, &actor, &name, &wish)).await?;
    Ok(Json(order.into()))
}

/// The second step: what was armed is done, once, if everything is as it was then. Needs the mastership.
#[utoipa::path(
    post,
    path = "/api/orders/{id}/fire",
    params(("id" = String, Path, description = "The order")),
    responses(
        (status = 200, body = ExecutedView),
        (status = 403, body = Problem),
        (status = 404, body = Problem),
        (status = 409, body = ConflictView, description = "Not in time, not the mastership, not the same as it was, or the gauge refused"),
        (status = 503, body = Problem, description = "The audit trail cannot be written")
    )
)]
pub async fn execute(
    State(plant): State<Arc<Services>>,
    Path(id): Path<String>,
    actor: Actor,
) -> Result<Json<ExecutedView>, Response> {
    let fired = run_blocking(move || control::execute(&plant, &actor, &id)).await?;
    Ok(Json(fired.into()))
}

/// What was armed is not armed any more.
#[utoipa::path(
    delete,
    path = "/api/orders/{id}",
    params(("id" = String, Path, description = "The order")),
    responses((status = 204), (status = 403, body = Problem), (status = 404, body = Problem), (status = 409, body = ConflictView))
)]
pub async fn disarm(
    State(plant): State<Arc<Services>>,
    Path(id): Path<String>,
    actor: Actor,
) -> Result<StatusCode, Response> {
    run_blocking(move || control::disarm(&plant, &actor, &id)).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Who may act now.
#[utoipa::path(get, path = "/api/mastership", responses((status = 200, body = ControlAuthorityView)))]
pub async fn authority(State(plant): State<Arc<Services>>) -> Json<ControlAuthorityView> {
    Json(control::authority(&plant, Instant::now()))
}

async fn change_authority(
    plant: Arc<Services>,
    actor: Actor,
    wanted: AuthorityAction,
) -> Result<Json<ControlAuthorityView>, Response> {
    let now = run_blocking(move || {
        control::change_authority(&plant, &actor, wanted, Instant::now())?;
        Ok(control::authority(&plant, Instant::now()))
    });
    Ok(Json(now.await?))
}

/// Somebody wants the mastership: if it is free they have it, else its holder is told.
#[utoipa::path(post, path = "/api/mastership/ask", responses((status = 200, body = ControlAuthorityView), (status = 403, body = Problem), (status = 409, body = ConflictView)))]
pub async fn request(State(plant): State<Arc<Services>>, actor: Actor) -> Result<Json<ControlAuthorityView>, Response> {
    change_authority(plant, actor, AuthorityAction::Request).await
}

/// Its holder gives the mastership back.
#[utoipa::path(post, path = "/api/mastership/release", responses((status = 200, body = ControlAuthorityView), (status = 403, body = Problem), (status = 409, body = ConflictView)))]
pub async fn release(State(plant): State<Arc<Services>>, actor: Actor) -> Result<Json<ControlAuthorityView>, Response> {
    change_authority(plant, actor, AuthorityAction::Release).await
}

/// Its holder gives the mastership to who asked.
#[utoipa::path(post, path = "/api/mastership/grant", responses((status = 200, body = ControlAuthorityView), (status = 403, body = Problem), (status = 409, body = ConflictView)))]
pub async fn grant(State(plant): State<Arc<Services>>, actor: Actor) -> Result<Json<ControlAuthorityView>, Response> {
    change_authority(plant, actor, AuthorityAction::Grant).await
}

/// Somebody takes the mastership from its holder: an engineer at any time, an operator 60 s after asking without a reaction.
#[utoipa::path(post, path = "/api/mastership/take-over", responses((status = 200, body = ControlAuthorityView), (status = 403, body = Problem), (status = 409, body = ConflictView)))]
pub async fn take_over(
    State(plant): State<Arc<Services>>,
    actor: Actor,
) -> Result<Json<ControlAuthorityView>, Response> {
    change_authority(plant, actor, AuthorityAction::TakeOver).await
}
