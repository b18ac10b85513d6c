//! The settings of an alarm: read by all users, changed by engineers.

use crate::alarm::view::AlarmView;
use crate::alarm::{AlarmServiceError, checked_reason};
use crate::alarm_editor::{AlarmEdit, AlarmEditError};
use crate::config::{AlarmSettings, DefaultAlarmSettings, SettingsError, settings_by_default};
use crate::services::Services;
use axum::Json;
use axum::extract::{Path, State};
use profivac_web_server::auth::{Actor, Role};
use profivac_web_server::body::Body;
use profivac_web_server::problem::{Problem, task_failed};
use serde::{Deserialize, Serialize};
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

/// A default alarm, which every gauge, every segment or the station has.
#[derive(Debug, Serialize, ToSchema)]
pub struct DefaultAlarmView {
    /// Its name in the table `[alarms]` of the station's file.
    #[schema(example = "stale")]
    name: String,
    /// The settings, as the file writes them.
    settings: DefaultAlarmSettings,
    /// What holds where the file has no setting.
    defaults: DefaultAlarmSettings,
}

/// New settings of a default alarm.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ChangeDefaultSettings {
    /// The settings that the user has seen.
    seen: DefaultAlarmSettings,
    /// The new settings, all of them.
    new: DefaultAlarmSettings,
    /// The reason, in one line of 1 to 500 characters.
    #[schema(min_length = 1, max_length = 500, example = "a restart of the gauge takes longer")]
    reason: String,
}

/// The settings of all default alarms, as the table `[alarms]` of the station's file writes them; empty if the station has no file
#[utoipa::path(get, path = "/api/default-alarms", responses((status = 200, body = [DefaultAlarmView])))]
pub async fn defaults(State(services): State<Arc<Services>>) -> Result<Json<Vec<DefaultAlarmView>>, Problem> {
    let view = |(name, settings): (&'static str, DefaultAlarmSettings)| DefaultAlarmView {
        name: name.to_owned(),
        settings,
        defaults: settings_by_default(name).unwrap_or_default(),
    };
    run_blocking(move || match services.alarm_editor().default_settings() {
        Ok(all) => Ok(all.into_iter().map(view).collect()),
        Err(AlarmEditError::NoFile) => Ok(Vec::new()),
        Err(error) => Err(error),
    })
    .await
}

/// Change the settings of a default alarm
///
/// The station's file and the running alarms have the change before the answer; the alarms that are still there keep their states.
#[utoipa::path(
    post,
    path = "/api/default-alarms/{name}/settings",
    params(("name" = String, Path, description = "The name of the default alarm in the table `[alarms]`", example = "stale")),
    request_body = ChangeDefaultSettings,
    responses(
        (status = 200, body = DefaultAlarmSettings),
        (status = 400, body = Problem, description = "The body is malformed, or the station's file would be wrong"),
        (status = 403, body = Problem, description = "The role engineer is needed"),
        (status = 404, body = Problem, description = "There is no default alarm of this name"),
        (status = 409, body = Problem, description = "The settings or the file have changed since, or the station has no file"),
        (status = 503, body = Problem, description = "The file cannot be written, or the database cannot")
    )
)]
pub async fn change_default(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
    Body(ChangeDefaultSettings { seen, new, reason }): Body<ChangeDefaultSettings>,
) -> Result<Json<DefaultAlarmSettings>, Problem> {
    services.control().refusals().require(&actor, Role::Engineer, "changing the settings of a default alarm")?;
    let edit = AlarmEdit { seen, new, reason: checked_reason(&reason)? };
    run_blocking(move || services.alarm_editor().change_default(&name, &edit, &actor)).await
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
    services.control().refusals().require(&actor, Role::Engineer, "changing the settings of an alarm")?;
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
            AlarmEditError::Alarm(AlarmServiceError::Refused(_))
            | AlarmEditError::Settings(SettingsError::UnknownDefault { .. }) => Self::not_found(sentence),
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
