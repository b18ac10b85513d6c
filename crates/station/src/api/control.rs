//! Control of gauges: commands, armed commands, control authority.

use super::names::not_found;
use crate::control::armed_commands::{ArmedCommand, ArmedCommandError};
use crate::control::operation::OperationRequest;
use crate::control::permissions;
use crate::control::{AuthorityAction, ControlError, Executed, OperationError};
use crate::services::Services;
use crate::view::{ControlAuthorityView, Risk, duration_ms};
use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use profivac_client::Condition;
use profivac_client::conditions::required_texts;
use profivac_client::names::{ParameterNames, command_name};
use profivac_devices::catalog::is_built_in;
use profivac_web_server::auth::{Actor, Role};
use profivac_web_server::body::Body;
use profivac_web_server::problem::{PROBLEM_JSON, Problem, task_failed};
use serde::Serialize;
use std::sync::Arc;
use std::time::Instant;
use utoipa::ToSchema;

/// A command of a gauge.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Command {
    /// The name by which it is armed.
    #[schema(example = "ba.degas-on")]
    command: String,
    /// The manual's name of the parameter that carries it.
    name: String,
    /// Slot and index of that parameter.
    numbers: String,
    /// The conditions that must be met.
    conditions: Vec<String>,
    /// The risk of executing it.
    risk: Risk,
    /// The lowest role that may execute it.
    role: Role,
    /// Why it cannot be executed from the station; `null` if it can.
    blocked_reason: Option<String>,
    /// Whether a device file describes it: its conditions and its risk are as good as the file.
    from_device_file: bool,
}

/// A condition of a command, and whether it is met.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ConditionView {
    /// The expected state.
    expected: String,
    /// The state that was found.
    found: String,
    /// Whether the condition is met.
    is_met: bool,
}

impl ConditionView {
    fn of(conditions: &[Condition]) -> Vec<Self> {
        let view = |condition: &Condition| Self {
            expected: condition.required.clone(),
            found: condition.found.clone(),
            is_met: condition.unmet.is_none(),
        };
        conditions.iter().map(view).collect()
    }
}

/// An armed command or write.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ArmedCommandView {
    /// Its identifier.
    id: String,
    /// The gauge.
    gauge: String,
    /// The name of the command, or of the parameter.
    target: String,
    /// The manual's name and numbers of the parameter.
    manual_name: String,
    /// Whether it is a command; otherwise it writes a parameter.
    is_command: bool,
    /// Whether a device file describes it: its conditions and its risk are as good as the file.
    from_device_file: bool,
    /// The present value with its unit; `null` if it cannot be read.
    before: Option<String>,
    /// The requested value with its unit.
    after: String,
    /// The octets that will be sent, in hex.
    octets: String,
    /// The risk of executing it.
    risk: Risk,
    /// The conditions, which are all met.
    conditions: Vec<ConditionView>,
    /// The time until it is disarmed, in milliseconds.
    expires_in_ms: u64,
}

impl From<ArmedCommand> for ArmedCommandView {
    fn from(armed: ArmedCommand) -> Self {
        let ArmedCommand { id, gauge, operation, preview, expires_at, .. } = armed;
        Self {
            id,
            gauge,
            target: operation.target(),
            manual_name: operation.manual_name(),
            is_command: operation.command.is_some(),
            from_device_file: operation.from_device_file,
            octets: preview.octets_as_hex(),
            before: preview.before.map(|(text, _)| text),
            after: preview.after,
            risk: preview.risk,
            conditions: ConditionView::of(&preview.conditions),
            expires_in_ms: duration_ms(expires_at.saturating_duration_since(Instant::now())),
        }
    }
}

/// An executed command or write.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ExecutedView {
    /// The identifier of the armed command.
    id: String,
    /// The gauge.
    gauge: String,
    /// The name of the command, or of the parameter.
    target: String,
    /// The octets that were sent, in hex.
    octets: String,
    /// The value before, with its unit; `null` if it could not be read.
    before: Option<String>,
    /// The value that was read back, with its unit; `null` if it could not be read.
    after: Option<String>,
}

impl From<Executed> for ExecutedView {
    fn from(Executed { command, readback }: Executed) -> Self {
        Self {
            octets: command.preview.octets_as_hex(),
            target: command.operation.target(),
            id: command.id,
            gauge: command.gauge,
            before: readback.before,
            after: readback.after,
        }
    }
}

/// A problem document with the conditions of a command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ConflictView {
    /// The problem.
    #[serde(flatten)]
    problem: Problem,
    /// All conditions of the command, if one of them is not met.
    conditions: Vec<ConditionView>,
}

impl IntoResponse for ControlError {
    fn into_response(self) -> Response {
        let detail = self.to_string();
        match self {
            Self::UnknownGauge(_) | Self::Command(ArmedCommandError::Unknown(_)) => {
                Problem::not_found(detail).into_response()
            }
            Self::Request(_)
            | Self::Operation(OperationError::InvalidValue(_) | OperationError::BeyondRange { .. }) => {
                Problem::bad_request(detail).into_response()
            }
            Self::Forbidden(_) | Self::Command(ArmedCommandError::OtherUser(_)) => {
                Problem::forbidden(detail).into_response()
            }
            Self::Audit(_) => Problem::unavailable(detail).into_response(),
            Self::Operation(OperationError::ConditionsNotMet(conditions)) => conflict(detail, &conditions),
            Self::Blocked { .. } | Self::Authority(_) | Self::Command(_) | Self::Operation(_) => conflict(detail, &[]),
        }
    }
}

fn conflict(detail: String, conditions: &[Condition]) -> Response {
    let body = ConflictView { problem: Problem::conflict(detail), conditions: ConditionView::of(conditions) };
    (StatusCode::CONFLICT, [(CONTENT_TYPE, PROBLEM_JSON)], Json(body)).into_response()
}

/// Runs `work` on a blocking thread. It continues when the client disconnects.
async fn run_blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, ControlError> + Send + 'static,
) -> Result<T, Response> {
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(done)) => Ok(done),
        Ok(Err(error)) => Err(error.into_response()),
        Err(error) => Err(task_failed(&error).into_response()),
    }
}

/// The commands of a gauge with their conditions and risks
///
/// The station answers from its tables, without a request to the gauge.
#[utoipa::path(
    get,
    path = "/api/gauges/{name}/commands",
    params(("name" = String, Path, description = "The name of the gauge", example = "chamber")),
    responses(
        (status = 200, body = [Command]),
        (status = 404, body = Problem, description = "There is no gauge of this name")
    )
)]
pub async fn commands(
    State(services): State<Arc<Services>>,
    Path(name): Path<String>,
) -> Result<Json<Vec<Command>>, Problem> {
    let gauge = services.snapshots().gauge_named(&name).map_err(not_found)?;
    let Some(model) = gauge.model else { return Ok(Json(Vec::new())) };
    let (names, from_device_file) = (ParameterNames::shared(model), !is_built_in(model));
    let command = |(named, code): (&profivac_client::names::NamedParameter, _)| {
        let row = named.parameter.row;
        Command {
            command: command_name(named, code),
            name: row.name.to_owned(),
            numbers: named.parameter.numbers(),
            conditions: required_texts(names, named, code),
            risk: permissions::risk(row, Some(code)),
            role: permissions::role(row, Some(code)),
            blocked_reason: permissions::blocked_reason(row).map(str::to_owned),
            from_device_file,
        }
    };
    Ok(Json(names.commands().map(command).collect()))
}

/// Arm a command or a write
///
/// The first step. The station reads the conditions and the present value from the gauge. If all conditions are met, the command
/// is armed for 30 seconds. The user needs control authority.
#[utoipa::path(
    post,
    path = "/api/gauges/{name}/arm",
    params(("name" = String, Path, description = "The name of the gauge", example = "chamber")),
    request_body = OperationRequest,
    responses(
        (status = 200, body = ArmedCommandView),
        (status = 400, body = Problem, description = "The gauge has no such command or parameter, or does not accept the value"),
        (status = 403, body = Problem, description = "The role of the user does not permit it"),
        (status = 404, body = Problem, description = "There is no gauge of this name"),
        (status = 409, body = ConflictView, description = "The user has no control authority, a condition is not met, or the gauge does not answer")
    )
)]
pub async fn arm(
    State(services): State<Arc<Services>>,
    Path(name): Path<String>,
    actor: Actor,
    Body(request): Body<OperationRequest>,
) -> Result<Json<ArmedCommandView>, Response> {
    let armed = run_blocking(move || services.control().arm(&actor, &name, &request)).await?;
    Ok(Json(armed.into()))
}

/// Execute an armed command
///
/// The second step. The station checks the conditions and the present value again, and sends the command once. The
/// user needs control authority.
#[utoipa::path(
    post,
    path = "/api/armed-commands/{id}/execute",
    params(("id" = String, Path, description = "The identifier of the armed command")),
    responses(
        (status = 200, body = ExecutedView),
        (status = 403, body = Problem, description = "The role of the user does not permit it"),
        (status = 404, body = Problem, description = "There is no armed command with this identifier"),
        (status = 409, body = ConflictView, description = "The command has expired, the user has no control authority, a condition or the value has changed, or the gauge refused"),
        (status = 503, body = Problem, description = "The audit trail cannot be written")
    )
)]
pub async fn execute(
    State(services): State<Arc<Services>>,
    Path(id): Path<String>,
    actor: Actor,
) -> Result<Json<ExecutedView>, Response> {
    let executed = run_blocking(move || services.control().execute(&actor, &id)).await?;
    Ok(Json(executed.into()))
}

/// Disarm an armed command
#[utoipa::path(
    delete,
    path = "/api/armed-commands/{id}",
    params(("id" = String, Path, description = "The identifier of the armed command")),
    responses(
        (status = 204, description = "The command is disarmed"),
        (status = 403, body = Problem, description = "Another user armed the command"),
        (status = 404, body = Problem, description = "There is no armed command with this identifier"),
        (status = 409, body = ConflictView, description = "The command is being executed or has expired")
    )
)]
pub async fn disarm(
    State(services): State<Arc<Services>>,
    Path(id): Path<String>,
    actor: Actor,
) -> Result<StatusCode, Response> {
    run_blocking(move || services.control().disarm(&actor, &id)).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// The user with control authority
#[utoipa::path(get, path = "/api/control-authority", responses((status = 200, body = ControlAuthorityView)))]
pub async fn authority(State(services): State<Arc<Services>>) -> Json<ControlAuthorityView> {
    Json(services.control().authority(Instant::now()))
}

async fn change_authority(
    services: Arc<Services>,
    actor: Actor,
    action: AuthorityAction,
) -> Result<Json<ControlAuthorityView>, Response> {
    let changed = run_blocking(move || {
        services.control().change_authority(&actor, action, Instant::now())?;
        Ok(services.control().authority(Instant::now()))
    });
    Ok(Json(changed.await?))
}

/// Request control authority
///
/// If control authority is free, the user gets it. Otherwise the holder sees the request.
#[utoipa::path(
    post,
    path = "/api/control-authority/request",
    responses(
        (status = 200, body = ControlAuthorityView),
        (status = 403, body = Problem, description = "The role operator is needed"),
        (status = 409, body = ConflictView, description = "Another user has requested it already")
    )
)]
pub async fn request(
    State(services): State<Arc<Services>>,
    actor: Actor,
) -> Result<Json<ControlAuthorityView>, Response> {
    change_authority(services, actor, AuthorityAction::Request).await
}

/// Release control authority
#[utoipa::path(
    post,
    path = "/api/control-authority/release",
    responses(
        (status = 200, body = ControlAuthorityView),
        (status = 403, body = Problem, description = "The role operator is needed"),
        (status = 409, body = ConflictView, description = "The user does not have control authority")
    )
)]
pub async fn release(
    State(services): State<Arc<Services>>,
    actor: Actor,
) -> Result<Json<ControlAuthorityView>, Response> {
    change_authority(services, actor, AuthorityAction::Release).await
}

/// Grant control authority to the user who requested it
#[utoipa::path(
    post,
    path = "/api/control-authority/grant",
    responses(
        (status = 200, body = ControlAuthorityView),
        (status = 403, body = Problem, description = "The role operator is needed"),
        (status = 409, body = ConflictView, description = "The user does not have control authority, or there is no request")
    )
)]
pub async fn grant(
    State(services): State<Arc<Services>>,
    actor: Actor,
) -> Result<Json<ControlAuthorityView>, Response> {
    change_authority(services, actor, AuthorityAction::Grant).await
}

/// Take over control authority from its holder
///
/// An engineer may do so at any time, an operator 60 s after a request without an answer.
#[utoipa::path(
    post,
    path = "/api/control-authority/take-over",
    responses(
        (status = 200, body = ControlAuthorityView),
        (status = 403, body = Problem, description = "The role operator is needed"),
        (status = 409, body = ConflictView, description = "The holder still has time to answer the request")
    )
)]
pub async fn take_over(
    State(services): State<Arc<Services>>,
    actor: Actor,
) -> Result<Json<ControlAuthorityView>, Response> {
    change_authority(services, actor, AuthorityAction::TakeOver).await
}
