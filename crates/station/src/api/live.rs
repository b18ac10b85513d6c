//! The live stream: snapshots of the station as server-sent events.

use super::middleware::RequestContext;
use crate::alarm::view::AlarmOverview;
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

/// The interval between two snapshots. free choice: a reader cannot follow faster numbers.
const PERIOD: Duration = Duration::from_millis(250);

/// The state of the station at one moment.
#[derive(Debug, Serialize, ToSchema)]
pub struct Snapshot {
    /// The station.
    station: Station,
    /// Its segments.
    segments: Vec<Segment>,
    /// Its gauges with their readings.
    gauges: Vec<Gauge>,
    /// The user with control authority, and a request for it.
    control_authority: ControlAuthorityView,
    /// The gauges whose parameters are being read.
    read_progress: Vec<ReadProgress>,
    /// The active alarms.
    alarms: AlarmOverview,
}

/// The latest snapshot as JSON, shared by all clients.
pub struct SnapshotSource {
    services: Arc<Services>,
    latest: Mutex<Option<(Instant, Arc<str>)>>,
}

impl SnapshotSource {
    /// The snapshots of a station.
    pub const fn of(services: Arc<Services>) -> Self {
        Self { services, latest: Mutex::new(None) }
    }

    /// A snapshot that is younger than [`PERIOD`] at `now`.
    fn at(&self, now: Instant) -> Arc<str> {
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        match &*latest {
            Some((made, snapshot)) if now < *made + PERIOD => Arc::clone(snapshot),
            _ => {
                let snapshot: Arc<str> = self.json().into();
                *latest = Some((now, Arc::clone(&snapshot)));
                snapshot
            }
        }
    }

    fn json(&self) -> String {
        let Self { services, .. } = self;
        let snapshot = Snapshot {
            station: services.station(),
            segments: services.snapshots().segments(),
            gauges: services.snapshots().gauges(),
            control_authority: services.control().authority(Instant::now()),
            read_progress: services.snapshots().read_progress(),
            alarms: services.alarms().overview(),
        };
        // Numbers, texts and lists always have a JSON form.
        serde_json::to_string(&snapshot).unwrap_or_default()
    }
}

/// Snapshots of the station, four a second
///
/// Server-sent events named `moment`. A slow client misses snapshots. The stream ends with the session of its client.
#[utoipa::path(get, path = "/api/live", responses((status = 200, content_type = "text/event-stream", body = Snapshot)))]
pub async fn live(
    State(source): State<Arc<SnapshotSource>>,
    extensions: Extensions,
) -> Sse<impl Stream<Item = Result<Event, Infallible>>> {
    let mut ticks = tokio::time::interval(PERIOD);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let context = extensions.get::<RequestContext>().cloned();
    let is_allowed = move |_: &_| context.as_ref().is_none_or(RequestContext::is_still_authenticated);
    let ticks = IntervalStream::new(ticks).take_while(is_allowed);
    let events = ticks.map(move |_| Ok(Event::default().event("moment").data(source.at(Instant::now()))));
    Sse::new(events).keep_alive(KeepAlive::default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_recorder::{Recorder, Settings};

    #[test]
    fn all_clients_share_a_snapshot_for_one_period() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plant.db");
        let recorder = Recorder::start(&file, Settings::default()).unwrap();
        let source = SnapshotSource::of(Arc::new(Services::new("hall".to_owned(), file, recorder)));
        let begin = Instant::now();
        let first = source.at(begin);
        assert!(first.starts_with("{\"station\":{\"name\":\"hall\""), "{first}");
        assert!(Arc::ptr_eq(&first, &source.at(begin + PERIOD / 2)));
        assert!(!Arc::ptr_eq(&first, &source.at(begin + PERIOD)));
    }
}
