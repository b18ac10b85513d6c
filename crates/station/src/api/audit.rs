//! The audit trail.

use super::database::DatabaseReaders;
use super::history::{checked_range, parsed_query};
use super::problem::Problem;
use crate::view::unix_ms;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::IntoResponse;
use profivac_recorder::Micros;
use profivac_recorder::audit::{AuditQuery, AuditRow};
use profivac_recorder::export::iso;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// More rows than anybody reads at once.
const MOST: u32 = 100_000;

/// Which rows.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct AuditParameters {
    /// The beginning, in milliseconds since 1970; everything if nothing is said.
    #[param(example = 0)]
    from: Option<i64>,
    /// The end.
    #[param(example = 4_102_444_800_000_i64)]
    to: Option<i64>,
    /// Of this gauge only.
    gauge: Option<String>,
    /// By this person only.
    who: Option<String>,
    /// How many at most, 1 to 100000; 200 if nothing is said, 100000 as CSV.
    most: Option<u32>,
}

impl AuditParameters {
    fn wanted(self, most: u32) -> Result<AuditQuery, Problem> {
        let most = checked_range("most", self.most.unwrap_or(most), MOST)?;
        let micros = |at: i64| Micros(at.saturating_mul(1000));
        let (from, to) = (self.from.map_or(Micros(0), micros), self.to.map_or(Micros(i64::MAX), micros));
        if from >= to {
            return Err(Problem::bad("expected from to lie before to"));
        }
        let filled = |text: Option<String>| text.filter(|text| !text.is_empty());
        Ok(AuditQuery { from, to, gauge: filled(self.gauge), who: filled(self.who), limit: most })
    }
}

/// A row of the audit trail.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct AuditView {
    /// Its number, rising.
    id: i64,
    /// When, in milliseconds since 1970.
    at_ms: i64,
    /// `fired` before it is sent, `outcome` after it, `refused` when a condition did not hold, `disarmed`, `mastership`; of an alarm
    /// `acknowledged`, `taken-out-of-service`, `returned-to-service`.
    what: &'static str,
    /// The row whose outcome this is.
    of: Option<i64>,
    /// Who.
    who: String,
    /// Their role then.
    role: String,
    /// From which address.
    peer: Option<String>,
    /// The gauge.
    gauge: Option<String>,
    /// Its segment.
    segment: Option<String>,
    /// Its address on the bus.
    address: Option<u8>,
    /// The manual's name and numbers, or the alarm.
    target: Option<String>,
    /// What it was.
    before: Option<String>,
    /// What it was to be; of an outcome, what was read back.
    after: Option<String>,
    /// What came of it.
    outcome: Option<String>,
    /// The order.
    order: Option<String>,
}

impl From<AuditRow> for AuditView {
    fn from(AuditRow { id, entry }: AuditRow) -> Self {
        Self {
            id,
            at_ms: unix_ms(entry.at),
            what: entry.action.word(),
            of: entry.refers_to,
            who: entry.who,
            role: entry.role,
            peer: entry.peer,
            gauge: entry.gauge,
            segment: entry.segment,
            address: entry.address,
            target: entry.target,
            before: entry.before,
            after: entry.after,
            outcome: entry.outcome,
            order: entry.command_id,
        }
    }
}

/// Who did what, the latest first.
#[utoipa::path(get, path = "/api/audit", params(AuditParameters), responses((status = 200, body = [AuditView]), (status = 400, body = Problem)))]
pub async fn audit(
    State(archive): State<DatabaseReaders>,
    rows: Result<Query<AuditParameters>, QueryRejection>,
) -> Result<Json<Vec<AuditView>>, Problem> {
    let wanted = parsed_query(rows)?.wanted(200)?;
    let read = archive.read(move |reader| Ok(reader.audit(&wanted)?));
    Ok(Json(read.await?.into_iter().map(AuditView::from).collect()))
}

/// The same as a table, the earliest first: times are ISO 8601 in UTC.
#[utoipa::path(get, path = "/api/audit.csv", params(AuditParameters), responses((status = 200, content_type = "text/csv", body = String), (status = 400, body = Problem)))]
pub async fn csv(
    State(archive): State<DatabaseReaders>,
    rows: Result<Query<AuditParameters>, QueryRejection>,
) -> Result<impl IntoResponse, Problem> {
    let wanted = parsed_query(rows)?.wanted(MOST)?;
    let read = archive.read(move |reader| Ok(reader.audit(&wanted)?)).await?;
    let headers =
        [(CONTENT_TYPE, "text/csv; charset=utf-8"), (CONTENT_DISPOSITION, "attachment; filename=\"audit.csv\"")];
    let lines: String = read.iter().rev().map(line).collect();
    Ok((headers, format!("{HEAD}{lines}")))
}

const HEAD: &str = "id,time,what,of,who,role,peer,gauge,segment,address,target,before,after,outcome,order\n";

fn line(row: &AuditRow) -> String {
    let AuditRow { id, entry } = row;
    let text = |text: &Option<String>| text.as_deref().map(quoted).unwrap_or_default();
    let number = |number: Option<i64>| number.map(|number| number.to_string()).unwrap_or_default();
    let cells = [
        id.to_string(),
        iso(entry.at),
        entry.action.word().to_owned(),
        number(entry.refers_to),
        quoted(&entry.who),
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

/// A cell that a spreadsheet takes for text: what would begin a formula gets an apostrophe before it.
fn quoted(text: &str) -> String {
    let guard = if text.starts_with(['=', '+', '-', '@', '\t', '\r']) { "'" } else { "" };
    format!("\"{guard}{}\"", text.replace('"', "\"\""))
}
