//! The settings of an alarm: read by all users, changed by engineers.

use super::body::Body;
use super::problem::{Problem, task_failed};
use crate::alarm::view::AlarmView;
use crate::alarm::{AlarmServiceError, checked_reason};
use crate::alarm_editor::{AlarmEdit, AlarmEditError};
use crate::auth::{Actor, Role};
use crate::config::{AlarmSettings, SettingsError};
use crate::services::Services;
use axum::Json;
use axum::extract::{Path, State};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::ToSchema;

/// New settings of an alarm.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ChangeSettings {
    /// The settings that the user has seen.
    seen: AlarmSettings,
    /// The new settings, all of them.
    new: AlarmSettings,
    /// The reason, in one line of 1 to 500 characters.
    #[schema(min_length = 1, max_length = 500, example = "the process needs a lower pressure")]
    reason: String,
}

/// The settings of an alarm, as the station's file writes them
#[utoipa::path(
    get,
    path = "/api/alarms/{name}/settings",
    params(("name" = String, Path, description = "The name of the alarm", example = "chamber too high")),
    responses(
        (status = 200, body = AlarmSettings),
        (status = 404, body = Problem, description = "There is no alarm of this name"),
        (status = 409, body = Problem, description = "The alarm is a default alarm, or the station has no file")
    )
)]
pub async fn settings(
    State(services): State<Arc<Services>>,
    Path(name): Path<String>,
) -> Result<Json<AlarmSettings>, Problem> {
    run_blocking(move || services.alarm_editor().settings(&name)).await
}

/// Change the settings of an alarm
///
/// The station's file and the running alarm have the change before the answer; the state of the alarm stays.
#[utoipa::path(
    post,
    path = "/api/alarms/{name}/settings",
    params(("name" = String, Path, description = "The name of the alarm", example = "chamber too high")),
    request_body = ChangeSettings,
    responses(
        (status = 200, body = AlarmView),
        (status = 400, body = Problem, description = "The body is malformed, or the station's file would be wrong"),
        (status = 403, body = Problem, description = "The role engineer is needed"),
        (status = 404, body = Problem, description = "There is no alarm of this name"),
        (status = 409, body = Problem, description = "The settings or the file have changed since, the alarm is a default alarm, or the station has no file"),
        (status = 503, body = Problem, description = "The file cannot be written, or the database cannot")
    )
)]
pub async fn change(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
    Body(ChangeSettings { seen, new, reason }): Body<ChangeSettings>,
) -> Result<Json<AlarmView>, Problem> {
    actor.user.require(Role::Engineer, "changing the settings of an alarm")?;
    let edit = AlarmEdit { seen, new, reason: checked_reason(&reason)? };
    run_blocking(move || services.alarm_editor().change(&name, &edit, &actor)).await
}

/// Runs `work` on a blocking thread, because it waits for the disk.
async fn run_blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, AlarmEditError> + Send + 'static,
) -> Result<Json<T>, Problem> {
    let done = tokio::task::spawn_blocking(work).await.map_err(|error| task_failed(&error))?;
    done.map(Json).map_err(Problem::from)
}

impl From<AlarmEditError> for Problem {
    fn from(error: AlarmEditError) -> Self {
        let sentence = error.to_string();
        match error {
            AlarmEditError::Alarm(AlarmServiceError::Refused(_)) => Self::not_found(sentence),
            AlarmEditError::Invalid(_) | AlarmEditError::Settings(SettingsError::OtherLimit { .. }) => {
                Self::bad_request(sentence)
            }
            AlarmEditError::NoFile
            | AlarmEditError::Settings(_)
            | AlarmEditError::FileChanged(_)
            | AlarmEditError::OtherSettings { .. } => Self::conflict(sentence),
            AlarmEditError::Alarm(AlarmServiceError::NotStored) | AlarmEditError::File { .. } => {
                Self::unavailable(sentence)
            }
        }
    }
}
