//! The audit trail.

use super::database::DatabaseReaders;
use super::names::not_found;
use crate::services::Services;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::IntoResponse;
use profivac_model::{AuditEntry, Micros};
use profivac_recorder::audit::AuditQuery;
use profivac_recorder::export::{iso, quoted};
use profivac_web_server::problem::Problem;
use profivac_web_server::query::{checked_range, parsed_query};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::IntoParams;

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

/// The audit trail, the latest entry first
#[utoipa::path(
    get,
    path = "/api/audit",
    params(AuditParameters),
    responses(
        (status = 200, body = [AuditEntry]),
        (status = 400, body = Problem, description = "A parameter is out of range"),
        (status = 404, body = Problem, description = "No gauge and no entry has this name"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn audit(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<AuditParameters>, QueryRejection>,
) -> Result<Json<Vec<AuditEntry>>, Problem> {
    let query = parsed_query(parameters)?.into_query(200)?;
    Ok(Json(entries(services, &readers, query).await?))
}

/// The entries. A gauge that the station does not have may have entries of earlier times.
async fn entries(
    services: Arc<Services>,
    readers: &DatabaseReaders,
    query: AuditQuery,
) -> Result<Vec<AuditEntry>, Problem> {
    let read = readers.read(move |reader| {
        let entries = reader.audit(&query)?;
        if let (Some(gauge), true) = (&query.gauge, entries.is_empty()) {
            services.snapshots().gauge_named(gauge).map_err(not_found)?;
        }
        Ok(entries)
    });
    read.await
}

/// The audit trail as CSV, the earliest entry first; times are ISO 8601 in UTC
#[utoipa::path(
    get,
    path = "/api/audit.csv",
    params(AuditParameters),
    responses(
        (status = 200, content_type = "text/csv", body = String),
        (status = 400, body = Problem, description = "A parameter is out of range"),
        (status = 404, body = Problem, description = "No gauge and no entry has this name"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn csv(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<AuditParameters>, QueryRejection>,
) -> Result<impl IntoResponse, Problem> {
    let query = parsed_query(parameters)?.into_query(MAX_ENTRIES)?;
    let rows = entries(services, &readers, query).await?;
    let headers =
        [(CONTENT_TYPE, "text/csv; charset=utf-8"), (CONTENT_DISPOSITION, "attachment; filename=\"audit.csv\"")];
    let lines: String = rows.iter().rev().map(csv_line).collect();
    Ok((headers, format!("{CSV_HEAD}{lines}")))
}

const CSV_HEAD: &str =
    "id,time,action,refers_to,user,role,peer,gauge,segment,address,target,before,after,outcome,command_id\n";

fn csv_line(entry: &AuditEntry) -> String {
    let text = |text: &Option<String>| text.as_deref().map(quoted).unwrap_or_default();
    let number = |number: Option<i64>| number.map(|number| number.to_string()).unwrap_or_default();
    let cells = [
        entry.id.to_string(),
        iso(entry.at),
        entry.action.as_str().to_owned(),
        number(entry.refers_to),
        quoted(&entry.user),
        entry.role.as_str().to_owned(),
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
