//! Gauges and segments as they change.

use crate::plant::Plant;
use crate::view::{Gauge, Segment, Station};
use axum::extract::State;
use axum::response::sse::{Event, KeepAlive, Sse};
use serde::Serialize;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio_stream::wrappers::IntervalStream;
use tokio_stream::{Stream, StreamExt};
use utoipa::ToSchema;

/// How often. free choice: as quick as an eye follows a number.
const PERIOD: Duration = Duration::from_millis(250);

/// Everything that is seen at one moment.
#[derive(Debug, Serialize, ToSchema)]
pub struct Moment {
    station: Station,
    segments: Vec<Segment>,
    gauges: Vec<Gauge>,
}

/// Gauges and segments four times a second, as server-sent events named `moment`.
#[utoipa::path(get, path = "/api/live", responses((status = 200, content_type = "text/event-stream", body = Moment)))]
pub async fn live(State(plant): State<Arc<Plant>>) -> Sse<impl Stream<Item = Result<Event, Infallible>>> {
    let moments = IntervalStream::new(tokio::time::interval(PERIOD)).map(move |_| {
        let moment = Moment { station: plant.station(), segments: plant.segments(), gauges: plant.gauges() };
        // Numbers, texts and lists always have a JSON form.
        Ok(Event::default().event("moment").json_data(moment).unwrap_or_default())
    });
    Sse::new(moments).keep_alive(KeepAlive::default())
}
