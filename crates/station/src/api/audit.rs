//! The audit trail.

use super::database::DatabaseReaders;
use crate::view::unix_ms;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::IntoResponse;
use profivac_recorder::audit::{AuditQuery, AuditRow};
use profivac_recorder::export::{iso, quoted};
use profivac_recorder::{AuditAction, Micros};
use profivac_web_server::problem::Problem;
use profivac_web_server::query::{checked_range, parsed_query};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// The most entries of an answer.
const MAX_ENTRIES: u32 = 100_000;

/// The entries of an answer.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct AuditParameters {
    /// The beginning, in milliseconds since 1970; without it from the first entry.
    #[param(example = 0)]
    from: Option<i64>,
    /// The end, in milliseconds since 1970; without it to the last entry.
    #[param(example = 4_102_444_800_000_i64)]
    to: Option<i64>,
    /// Only entries about this gauge.
    gauge: Option<String>,
    /// Only entries of this user.
    user: Option<String>,
    /// The most entries of the answer, 1 to 100000. The default is 200, as CSV 100000.
    #[param(minimum = 1, maximum = 100_000)]
    limit: Option<u32>,
}

impl AuditParameters {
    fn into_query(self, default_limit: u32) -> Result<AuditQuery, Problem> {
        let limit = checked_range("limit", self.limit.unwrap_or(default_limit), MAX_ENTRIES)?;
        let micros = |at: i64| Micros(at.saturating_mul(1000));
        let (from, to) = (self.from.map_or(Micros(0), micros), self.to.map_or(Micros(i64::MAX), micros));
        if from >= to {
            return Err(Problem::bad_request("expected from to lie before to"));
        }
        let filled = |text: Option<String>| text.filter(|text| !text.is_empty());
        Ok(AuditQuery { from, to, gauge: filled(self.gauge), user: filled(self.user), limit })
    }
}

/// An entry of the audit trail.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct AuditView {
    /// The number of the entry. Later entries have higher numbers.
    id: i64,
    /// The time, in milliseconds since 1970.
    at_ms: i64,
    /// The action.
    action: AuditActionView,
    /// For an `outcome` or `disarmed`, the number of the entry that it belongs to.
    refers_to: Option<i64>,
    /// The name of the user.
    user: String,
    /// The role of the user at that time.
    #[schema(value_type = profivac_web_server::auth::Role)]
    role: String,
    /// The address of the user's computer.
    peer: Option<String>,
    /// The gauge.
    gauge: Option<String>,
    /// The segment of the gauge.
    segment: Option<String>,
    /// The bus address of the gauge.
    address: Option<u8>,
    /// The manual's name and numbers of the parameter, or the name of the alarm or plant state.
    target: Option<String>,
    /// The value before the action.
    before: Option<String>,
    /// The requested value; for an `outcome`, the value that was read back.
    after: Option<String>,
    /// The result, in a sentence.
    outcome: Option<String>,
    /// The identifier of the armed command.
    command_id: Option<String>,
}

/// The action of an audit entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AuditActionView {
    /// A command or a write is about to be sent.
    Execute,
    /// The result of a command or a write.
    Outcome,
    /// A command or a write was refused, because a condition is not met, or any action, because the role does not permit it.
    Refused,
    /// An armed command was disarmed.
    Disarmed,
    /// Control authority changed.
    ControlAuthority,
    /// An alarm was acknowledged.
    Acknowledged,
    /// An alarm was shelved.
    Shelved,
    /// An alarm was unshelved.
    Unshelved,
    /// An alarm was taken out of service.
    TakenOutOfService,
    /// An alarm was returned to service.
    ReturnedToService,
    /// The settings of an alarm were changed.
    AlarmSettings,
    /// A plant state was declared.
    PlantStateDeclared,
    /// A declared plant state got a later end.
    PlantStateExtended,
    /// A declared plant state was ended.
    PlantStateEnded,
    /// A copy of the database is about to be made.
    Backup,
    /// The station has read its file again, and a value in it has changed.
    FileChanged,
}

impl From<AuditAction> for AuditActionView {
    fn from(action: AuditAction) -> Self {
        match action {
            AuditAction::Execute => Self::Execute,
            AuditAction::Outcome => Self::Outcome,
            AuditAction::Refused => Self::Refused,
            AuditAction::Disarmed => Self::Disarmed,
            AuditAction::ControlAuthority => Self::ControlAuthority,
            AuditAction::Acknowledged => Self::Acknowledged,
            AuditAction::Shelved => Self::Shelved,
            AuditAction::Unshelved => Self::Unshelved,
            AuditAction::TakenOutOfService => Self::TakenOutOfService,
            AuditAction::ReturnedToService => Self::ReturnedToService,
            AuditAction::AlarmSettings => Self::AlarmSettings,
            AuditAction::PlantStateDeclared => Self::PlantStateDeclared,
            AuditAction::PlantStateExtended => Self::PlantStateExtended,
            AuditAction::PlantStateEnded => Self::PlantStateEnded,
            AuditAction::Backup => Self::Backup,
            AuditAction::FileChanged => Self::FileChanged,
        }
    }
}

impl From<AuditRow> for AuditView {
    fn from(AuditRow { id, entry }: AuditRow) -> Self {
        Self {
            id,
            at_ms: unix_ms(entry.at),
            action: entry.action.into(),
            refers_to: entry.refers_to,
            user: entry.user,
            role: entry.role,
            peer: entry.peer,
            gauge: entry.gauge,
            segment: entry.segment,
            address: entry.address,
            target: entry.target,
            before: entry.before,
            after: entry.after,
            outcome: entry.outcome,
            command_id: entry.command_id,
        }
    }
}

/// The audit trail, the latest entry first
#[utoipa::path(
    get,
    path = "/api/audit",
    params(AuditParameters),
    responses(
        (status = 200, body = [AuditView]),
        (status = 400, body = Problem, description = "A parameter is out of range"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn audit(
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<AuditParameters>, QueryRejection>,
) -> Result<Json<Vec<AuditView>>, Problem> {
    let query = parsed_query(parameters)?.into_query(200)?;
    let rows = readers.read(move |reader| Ok(reader.audit(&query)?)).await?;
    Ok(Json(rows.into_iter().map(AuditView::from).collect()))
}

/// The audit trail as CSV, the earliest entry first; times are ISO 8601 in UTC
#[utoipa::path(
    get,
    path = "/api/audit.csv",
    params(AuditParameters),
    responses(
        (status = 200, content_type = "text/csv", body = String),
        (status = 400, body = Problem, description = "A parameter is out of range"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn csv(
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<AuditParameters>, QueryRejection>,
) -> Result<impl IntoResponse, Problem> {
    let query = parsed_query(parameters)?.into_query(MAX_ENTRIES)?;
    let rows = readers.read(move |reader| Ok(reader.audit(&query)?)).await?;
    let headers =
        [(CONTENT_TYPE, "text/csv; charset=utf-8"), (CONTENT_DISPOSITION, "attachment; filename=\"audit.csv\"")];
    let lines: String = rows.iter().rev().map(csv_line).collect();
    Ok((headers, format!("{CSV_HEAD}{lines}")))
}

const CSV_HEAD: &str =
    "id,time,action,refers_to,user,role,peer,gauge,segment,address,target,before,after,outcome,command_id\n";

fn csv_line(row: &AuditRow) -> String {
    let AuditRow { id, entry } = row;
    let text = |text: &Option<String>| text.as_deref().map(quoted).unwrap_or_default();
    let number = |number: Option<i64>| number.map(|number| number.to_string()).unwrap_or_default();
    let cells = [
        id.to_string(),
        iso(entry.at),
        entry.action.word().to_owned(),
        number(entry.refers_to),
        quoted(&entry.user),
        entry.role.clone(),
        text(&entry.peer),
        text(&entry.gauge),
        text(&entry.segment),
        number(entry.address.map(i64::from)),
        text(&entry.target),
        text(&entry.before),
        text(&entry.after),
        text(&entry.outcome),
        text(&entry.command_id),
    ];
    cells.join(",") + "\n"
}
