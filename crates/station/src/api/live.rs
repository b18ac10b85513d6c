//! Gauges and segments as they change.

use super::middleware::RequestContext;
use crate::alarm::view::AlarmOverview;
use crate::control;
use crate::services::Services;
use crate::view::{ControlAuthorityView, Gauge, ReadProgress, Segment, Station};
use axum::extract::State;
use axum::http::Extensions;
use axum::response::sse::{Event, KeepAlive, Sse};
use serde::Serialize;
use std::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tokio::time::MissedTickBehavior;
use tokio_stream::wrappers::IntervalStream;
use tokio_stream::{Stream, StreamExt};
use utoipa::ToSchema;

/// How often. free choice: as quick as an eye follows a number.
const PERIOD: Duration = Duration::from_millis(250);

/// Everything that is seen at one moment.
#[derive(Debug, Serialize, ToSchema)]
pub struct Snapshot {
    station: Station,
    segments: Vec<Segment>,
    gauges: Vec<Gauge>,
    mastership: ControlAuthorityView,
    reading: Vec<ReadProgress>,
    alarms: AlarmOverview,
}

/// The present moment as JSON, made once for all who watch.
pub struct SnapshotSource {
    plant: Arc<Services>,
    latest: Mutex<Option<(Instant, Arc<str>)>>,
}

impl SnapshotSource {
    /// The moments of a plant.
    pub const fn of(plant: Arc<Services>) -> Self {
        Self { plant, latest: Mutex::new(None) }
    }

    /// What is seen at `now`, or was less than a period before.
    fn at(&self, now: Instant) -> Arc<str> {
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        match &*latest {
            Some((made, moment)) if now < *made + PERIOD => Arc::clone(moment),
            _ => {
                let moment: Arc<str> = self.json().into();
                *latest = Some((now, Arc::clone(&moment)));
                moment
            }
        }
    }

    fn json(&self) -> String {
        let Self { plant, .. } = self;
        let mastership = control::authority(plant, Instant::now());
        let (station, segments, gauges) = (plant.station(), plant.segments(), plant.gauges());
        let (reading, alarms) = (plant.read_progress(), plant.alarms().overview());
        let moment = Snapshot { station, segments, gauges, mastership, reading, alarms };
        // Numbers, texts and lists always have a JSON form.
        serde_json::to_string(&moment).unwrap_or_default()
    }
}

/// Gauges and segments four times a second, as server-sent events named `moment`. Whoever is slow misses moments. It ends with
/// the session it was asked for in.
#[utoipa::path(get, path = "/api/live", responses((status = 200, content_type = "text/event-stream", body = Snapshot)))]
pub async fn live(
    State(moments): State<Arc<SnapshotSource>>,
    extensions: Extensions,
) -> Sse<impl Stream<Item = Result<Event, Infallible>>> {
    let mut ticks = tokio::time::interval(PERIOD);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let visit = extensions.get::<RequestContext>().cloned();
    let allowed = move |_: &_| visit.as_ref().is_none_or(RequestContext::is_still_authenticated);
    let ticks = IntervalStream::new(ticks).take_while(allowed);
    let moments = ticks.map(move |_| Ok(Event::default().event("moment").data(moments.at(Instant::now()))));
    Sse::new(moments).keep_alive(KeepAlive::default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_recorder::{Recorder, Settings};

    #[test]
    fn all_who_watch_share_a_moment() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plant.db");
        let recorder = Recorder::start(&file, Settings::default()).unwrap();
        let moments = SnapshotSource::of(Arc::new(Services::new("hall".to_owned(), file, recorder)));
        let begin = Instant::now();
        let first = moments.at(begin);
        assert!(first.starts_with("{\"station\":{\"name\":\"hall\""), "{first}");
        assert!(Arc::ptr_eq(&first, &moments.at(begin + PERIOD / 2)));
        assert!(!Arc::ptr_eq(&first, &moments.at(begin + PERIOD)));
    }
}
