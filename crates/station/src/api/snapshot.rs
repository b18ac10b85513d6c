//! The present state of the station, its segments and its gauges.

use super::names::not_found;
use crate::control::SegmentRequestError;
use crate::control::error::Unavailable;
use crate::directory::GaugeLabels;
use crate::gateway_status::GatewayView;
use crate::plant::PlantPicture;
use crate::services::Services;
use crate::view::{Block, Gauge, Segment, Station};
use axum::Json;
use axum::extract::{Path, State};
use axum::http::HeaderMap;
use axum::response::Response;
use profivac_web_server::compression::compressed_json;
use profivac_web_server::problem::{Problem, task_failed};
use serde::Serialize;
use std::sync::Arc;
use utoipa::ToSchema;

/// A gauge with its labels.
#[derive(Debug, Serialize, ToSchema)]
pub struct LabelledGauge {
    #[serde(flatten)]
    gauge: Gauge,
    /// What the station's file says about it beside the bus.
    labels: GaugeLabels,
}

impl LabelledGauge {
    fn of(gauge: Gauge, services: &Services) -> Self {
        Self { labels: services.directory().labels(&gauge.name), gauge }
    }
}

/// The station and its recorder
#[utoipa::path(get, path = "/api/station", responses((status = 200, body = Station)))]
pub async fn station(State(services): State<Arc<Services>>) -> Json<Station> {
    Json(services.station())
}

/// The segments with the stations on them
#[utoipa::path(get, path = "/api/segments", responses((status = 200, body = [Segment])))]
pub async fn segments(State(services): State<Arc<Services>>) -> Json<Vec<Segment>> {
    Json(services.snapshots().segments())
}

/// All gauges with their readings
#[utoipa::path(get, path = "/api/gauges", responses((status = 200, body = [LabelledGauge])))]
pub async fn gauges(State(services): State<Arc<Services>>) -> Json<Vec<LabelledGauge>> {
    Json(services.snapshots().gauges().into_iter().map(|gauge| LabelledGauge::of(gauge, &services)).collect())
}

/// One gauge with its readings
#[utoipa::path(
    get,
    path = "/api/gauges/{name}",
    params(("name" = String, Path, description = "The name of the gauge", example = "chamber")),
    responses(
        (status = 200, body = LabelledGauge),
        (status = 404, body = Problem, description = "There is no gauge of this name")
    )
)]
pub async fn gauge(
    State(services): State<Arc<Services>>,
    Path(name): Path<String>,
) -> Result<Json<LabelledGauge>, Problem> {
    let gauge = services.snapshots().gauge_named(&name).map_err(not_found)?;
    Ok(Json(LabelledGauge::of(gauge, &services)))
}

/// The blocks and parameters of a gauge
///
/// The station reads the parameters from the gauge now, beside its cyclic data.
#[utoipa::path(
    get,
    path = "/api/gauges/{name}/blocks",
    params(("name" = String, Path, description = "The name of the gauge", example = "chamber")),
    responses(
        (status = 200, body = [Block]),
        (status = 404, body = Problem, description = "There is no gauge of this name"),
        (status = 409, body = Problem, description = "The gauge does not answer"),
        (status = 503, body = Problem, description = "The segment is busy")
    )
)]
pub async fn blocks(
    State(services): State<Arc<Services>>,
    Path(name): Path<String>,
) -> Result<Json<Vec<Block>>, Problem> {
    match tokio::task::spawn_blocking(move || services.control().requests().blocks(&name)).await {
        Ok(Ok(blocks)) => Ok(Json(blocks)),
        Ok(Err(error)) => Err(error.into()),
        Err(error) => Err(task_failed(&error)),
    }
}

/// The plant: its volumes, and the valves and pumps between them
///
/// It changes with the station's file. The states of the parts are in the live stream, which has a new `plant.revision` when this answer
/// changes.
#[utoipa::path(get, path = "/api/plant", responses((status = 200, body = PlantPicture)))]
pub async fn plant(State(services): State<Arc<Services>>) -> Json<PlantPicture> {
    Json(services.plant().view())
}

/// The directory: the labels of the gauges, and the views
///
/// Groups, tags, locations and calibrations; filters of the overview and groups of trends. It changes with the station's file. The live
/// stream has a new `directory_revision` when this answer changes.
#[utoipa::path(get, path = "/api/directory", responses((status = 200, body = crate::directory::Directory)))]
pub async fn directory(State(services): State<Arc<Services>>, headers: HeaderMap) -> Response {
    // Texts and lists always have a JSON form.
    compressed_json(serde_json::to_vec(&*services.directory().view()).unwrap_or_default(), &headers)
}

/// The gateways to control systems, with their clients and errors
#[utoipa::path(get, path = "/api/gateways", responses((status = 200, body = [GatewayView])))]
pub async fn gateways(State(services): State<Arc<Services>>) -> Json<Vec<GatewayView>> {
    Json(services.gateways().views())
}

impl From<SegmentRequestError> for Problem {
    fn from(error: SegmentRequestError) -> Self {
        match error {
            SegmentRequestError::UnknownGauge(_) | SegmentRequestError::Unavailable(Unavailable::UnknownGauge(_)) => {
                Self::not_found(error.to_string())
            }
            // A gauge that is switched off is no fault of the station.
            SegmentRequestError::Unavailable(_) | SegmentRequestError::Stopped => Self::conflict(error.to_string()),
            SegmentRequestError::Busy | SegmentRequestError::Timeout => Self::unavailable(error.to_string()),
        }
    }
}
