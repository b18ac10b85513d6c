//! What is seen now.

use super::database::task_failed;
use super::problem::Problem;
use crate::services::{SegmentRequestError, Services};
use crate::view::{Block, Gauge, Segment, Station};
use axum::Json;
use axum::extract::{Path, State};
use std::sync::Arc;

/// The station and its recorder.
#[utoipa::path(get, path = "/api/station", responses((status = 200, body = Station)))]
pub async fn station(State(plant): State<Arc<Services>>) -> Json<Station> {
    Json(plant.station())
}

/// Segments, and who is on them.
#[utoipa::path(get, path = "/api/segments", responses((status = 200, body = [Segment])))]
pub async fn segments(State(plant): State<Arc<Services>>) -> Json<Vec<Segment>> {
    Json(plant.segments())
}

/// Gauges, and what they show.
#[utoipa::path(get, path = "/api/gauges", responses((status = 200, body = [Gauge])))]
pub async fn gauges(State(plant): State<Arc<Services>>) -> Json<Vec<Gauge>> {
    Json(plant.gauges())
}

/// One gauge, and what it shows.
#[utoipa::path(
    get,
    path = "/api/gauges/{name}",
    params(("name" = String, Path, description = "The name of the gauge")),
    responses((status = 200, body = Gauge), (status = 404, body = Problem))
)]
pub async fn gauge(State(plant): State<Arc<Services>>, Path(name): Path<String>) -> Result<Json<Gauge>, Problem> {
    plant.gauge(&name).map(Json).ok_or_else(|| Problem::unknown(format!("there is no gauge {name:?}")))
}

/// The blocks of a gauge with what their parameters show. They are read from the gauge now, beside its cyclic data.
#[utoipa::path(
    get,
    path = "/api/gauges/{name}/blocks",
    params(("name" = String, Path, description = "The name of the gauge")),
    responses((status = 200, body = [Block]), (status = 404, body = Problem), (status = 409, body = Problem), (status = 503, body = Problem))
)]
pub async fn blocks(State(plant): State<Arc<Services>>, Path(name): Path<String>) -> Result<Json<Vec<Block>>, Problem> {
    let asked = tokio::task::spawn_blocking(move || plant.blocks(&name)).await;
    match asked {
        Ok(Ok(blocks)) => Ok(Json(blocks)),
        Ok(Err(error)) => Err(error.into()),
        Err(error) => Err(task_failed(&error)),
    }
}

impl From<SegmentRequestError> for Problem {
    fn from(error: SegmentRequestError) -> Self {
        match error {
            SegmentRequestError::Unknown(_) => Self::unknown(error.to_string()),
            // A gauge that is switched off is no fault of the station.
            SegmentRequestError::Refused(_) => Self::conflict(error.to_string()),
            SegmentRequestError::Busy | SegmentRequestError::Timeout => Self::unavailable(error.to_string()),
        }
    }
}
