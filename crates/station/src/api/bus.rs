//! The lines of the segments: live list, statistics, captures.

use super::names::no_bus;
use crate::services::Services;
use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use profivac_listen::flight::CaptureFolder;
use profivac_listen::report::BusReport;
use profivac_web_server::auth::{Actor, Role};
use profivac_web_server::problem::{Problem, task_failed};
use serde::Serialize;
use std::io;
use std::sync::Arc;
use utoipa::ToSchema;

/// A capture of the traffic of a segment
#[derive(Debug, Serialize, ToSchema)]
pub struct CaptureView {
    /// The name of the file.
    name: String,
    /// Its size in octets.
    octets: u64,
}

/// The live list and the statistics of a segment
///
/// What the station hears on the line, also on a segment on which it only listens.
#[utoipa::path(
    get,
    path = "/api/segments/{name}/bus",
    params(("name" = String, Path, description = "The name of the segment", example = "hall")),
    responses(
        (status = 200, body = BusReport),
        (status = 404, body = Problem, description = "There is no segment of this name")
    )
)]
pub async fn bus(State(services): State<Arc<Services>>, Path(name): Path<String>) -> Result<Json<BusReport>, Problem> {
    let report = services.snapshots().buses().report(&name).ok_or_else(|| no_bus(&services, &name))?;
    Ok(Json(BusReport::clone(&report)))
}

/// The captures of a segment, oldest first
#[utoipa::path(
    get,
    path = "/api/segments/{name}/captures",
    params(("name" = String, Path, description = "The name of the segment", example = "hall")),
    responses(
        (status = 200, body = [CaptureView]),
        (status = 404, body = Problem, description = "There is no segment of this name")
    )
)]
pub async fn captures(
    State(services): State<Arc<Services>>,
    Path(name): Path<String>,
) -> Result<Json<Vec<CaptureView>>, Problem> {
    let folder = services.snapshots().buses().captures(&name).ok_or_else(|| no_bus(&services, &name))?;
    let all = on_disk(move || folder.list()).await?;
    Ok(Json(all.into_iter().map(|it| CaptureView { name: it.name, octets: it.octets }).collect()))
}

/// A capture as a file for Wireshark and `profivac decode`
#[utoipa::path(
    get,
    path = "/api/segments/{name}/captures/{file}",
    params(
        ("name" = String, Path, description = "The name of the segment", example = "hall"),
        ("file" = String, Path, description = "The name of the capture", example = "1700000000-0.pcapng")
    ),
    responses(
        (status = 200, body = Vec<u8>, content_type = "application/x-pcapng"),
        (status = 404, body = Problem, description = "There is no such capture")
    )
)]
pub async fn capture(
    State(services): State<Arc<Services>>,
    Path((name, file)): Path<(String, String)>,
) -> Result<([(axum::http::HeaderName, &'static str); 1], Vec<u8>), Problem> {
    let folder: CaptureFolder = services.snapshots().buses().captures(&name).ok_or_else(|| no_bus(&services, &name))?;
    let octets = on_disk(move || folder.read(&file)).await?;
    Ok(([(CONTENT_TYPE, "application/x-pcapng")], octets))
}

/// Make a capture of the last minute and the next five seconds
#[utoipa::path(
    post,
    path = "/api/segments/{name}/captures",
    params(("name" = String, Path, description = "The name of the segment", example = "hall")),
    responses(
        (status = 204, description = "The capture is listed when it is complete"),
        (status = 404, body = Problem, description = "There is no segment of this name")
    )
)]
pub async fn trigger(
    State(services): State<Arc<Services>>,
    actor: Actor,
    Path(name): Path<String>,
) -> Result<StatusCode, Problem> {
    services.control().refusals().require(&actor, Role::Operator, "making captures")?;
    let reason = format!("asked for by {}", actor.user.name);
    if services.snapshots().buses().request_capture(&name, &reason) {
        Ok(StatusCode::NO_CONTENT)
    } else {
        Err(no_bus(&services, &name))
    }
}

/// Runs work on the disk beside the threads of the server.
async fn on_disk<T: Send + 'static>(work: impl FnOnce() -> io::Result<T> + Send + 'static) -> Result<T, Problem> {
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(done)) => Ok(done),
        Ok(Err(error)) if error.kind() == io::ErrorKind::NotFound => {
            Err(Problem::not_found("there is no such capture"))
        }
        Ok(Err(error)) => Err(Problem::unavailable(format!("the captures cannot be read: {error}"))),
        Err(error) => Err(task_failed(&error)),
    }
}
