//! Pump-downs beside the usual ones.

use super::database::DatabaseReaders;
use super::names::check_series;
use crate::comparison::recorded::recorded;
use crate::comparison::view::PumpDowns;
use crate::pumpdown::TimeRange;
use crate::pumpdown::compare::{Run, compare, compare_with};
use crate::services::Services;
use crate::view::unix_ms;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use profivac_web_server::problem::Problem;
use profivac_web_server::query::{checked_range, parsed_query, time_range};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::IntoParams;

/// The most pump-downs of an answer.
const MAX_RUNS: u32 = 50;

/// A reference within this time of a beginning is that pump-down, in ms.
const SAME_START_MS: u64 = 60_000;

/// The series and the time range of pump-downs.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct PumpDownsParameters {
    /// The name of the series: that of a gauge, or `gauge.N` for channel N of a controller.
    #[param(example = "chamber")]
    series: String,
    /// The beginning, in milliseconds since 1970. Pump-downs before it are not usual ones.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// The most pump-downs of the answer, 1 to 50.
    #[param(default = 11, minimum = 1, maximum = 50)]
    limit: Option<u32>,
    /// The beginning of the pump-down with which all others are compared, in milliseconds since 1970; without it each one is compared
    /// with the last ten before it.
    reference: Option<i64>,
}

/// The pump-downs of a series beside the usual ones, the latest first
#[utoipa::path(
    get,
    path = "/api/pump-downs",
    params(PumpDownsParameters),
    responses(
        (status = 200, body = PumpDowns),
        (status = 400, body = Problem, description = "A parameter is out of range, or no pump-down begins at `reference`"),
        (status = 404, body = Problem, description = "There is no series of this name"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn pump_downs(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<PumpDownsParameters>, QueryRejection>,
) -> Result<Json<PumpDowns>, Problem> {
    let PumpDownsParameters { series, from, to, limit, reference } = parsed_query(parameters)?;
    let (start, end) = time_range(from, to)?;
    let limit = checked_range("limit", limit.unwrap_or(11), MAX_RUNS)?;
    let read = readers.read(move |reader| {
        check_series(&services, &reader, &series)?;
        let found = recorded(&reader, &series, TimeRange { start, end })?;
        let runs: Vec<Run> = found.iter().map(|one| one.run.clone()).collect();
        let compared = match reference {
            None => compare(&runs),
            Some(reference) => {
                let is_meant = |run: &&Run| unix_ms(run.start).abs_diff(reference) < SAME_START_MS;
                let chosen = runs.iter().find(is_meant).ok_or_else(|| {
                    Problem::bad_request(format!(
                        "expected reference as the beginning of one of {} pump-downs from {from} to {to}, found {reference}",
                        runs.len()
                    ))
                })?;
                compare_with(chosen, &runs)
            }
        };
        Ok(Json(PumpDowns::new(series, &found, &compared, limit as usize)))
    });
    read.await
}
