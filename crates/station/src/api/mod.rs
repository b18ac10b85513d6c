//! The API: what the dashboard uses, and anybody else.
//!
//! | Path | Gives |
//! |---|---|
//! | `/api/station` | the station and its recorder |
//! | `/api/segments` | segments, and who is on them |
//! | `/api/gauges` | gauges and what they show |
//! | `/api/gauges/{name}/blocks` | a gauge's blocks and parameters, read now |
//! | `/api/gauges/{name}/commands` | its commands with what they ask for and risk |
//! | `/api/gauges/{name}/arm` | the first step of a command or a write |
//! | `/api/orders/{id}`, `/api/orders/{id}/fire` | the second step |
//! | `/api/mastership` and below | who may act |
//! | `/api/audit`, `/api/audit.csv` | who did what |
//! | `/api/trend` | what was recorded, drawn for so many pixels |
//! | `/api/events` | what happened |
//! | `/api/rise` | a rise of pressure, told apart |
//! | `/api/export.csv` | what was recorded, as a table |
//! | `/api/alarms` | alarms, and where each stands |
//! | `/api/alarms/history` | what happened to alarms |
//! | `/api/alarms/acknowledge`, `/api/alarms/{name}/acknowledge` | somebody knows |
//! | `/api/alarms/{name}/out-of-service`, `.../return-to-service` | an alarm is taken away, and put back |
//! | `/api/webhooks` | who is told of alarms, and how that goes |
//! | `/api/session` | who asks, and what they may |
//! | `/api/login`, `/api/logout`, `/api/password` | begins a session, ends it, changes a password |
//! | `/api/live` | gauges and segments as they change, as server-sent events |
//! | `/api/openapi.json` | this, for programs |

mod alarms;
mod audit;
mod body;
mod control;
mod database;
pub mod headers;
mod history;
mod live;
pub mod middleware;
mod openapi;
mod problem;
mod session;
mod snapshot;

use crate::services::Services;
use axum::Router;
use axum::extract::FromRef;
use axum::routing::{delete, get, post};
use database::DatabaseReaders;
use live::SnapshotSource;
use openapi::CommonResponses;
pub use problem::Problem;
use std::sync::Arc;
use utoipa::OpenApi;

/// The description of the API.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "profivac station",
        description = "What a vacuum station sees and has recorded. Pressures in Pa, times in milliseconds since 1970."
    ),
    modifiers(&CommonResponses),
    paths(
        snapshot::station,
        snapshot::segments,
        snapshot::gauges,
        snapshot::gauge,
        snapshot::blocks,
        history::trend,
        history::events,
        history::rise,
        history::export,
        alarms::alarms,
        alarms::history,
        alarms::acknowledge,
        alarms::acknowledge_all,
        alarms::out_of_service,
        alarms::return_to_service,
        alarms::webhooks,
        live::live,
        session::session,
        session::login,
        session::logout,
        session::password,
        control::commands,
        control::arm,
        control::execute,
        control::disarm,
        control::authority,
        control::request,
        control::release,
        control::grant,
        control::take_over,
        audit::audit,
        audit::csv
    )
)]
struct Description;

/// The description of the API as JSON.
#[must_use]
pub fn description() -> String {
    Description::openapi().to_pretty_json().unwrap_or_default()
}

/// What those who answer share.
#[derive(Clone)]
struct Shared {
    plant: Arc<Services>,
    archive: DatabaseReaders,
    moments: Arc<SnapshotSource>,
}

impl FromRef<Shared> for Arc<Services> {
    fn from_ref(shared: &Shared) -> Self {
        Self::clone(&shared.plant)
    }
}

impl FromRef<Shared> for DatabaseReaders {
    fn from_ref(shared: &Shared) -> Self {
        shared.archive.clone()
    }
}

impl FromRef<Shared> for Arc<SnapshotSource> {
    fn from_ref(shared: &Shared) -> Self {
        Self::clone(&shared.moments)
    }
}

async fn method() -> Problem {
    Problem::method()
}

/// Everything that changes something.
fn control_routes() -> Router<Shared> {
    Router::new()
        .route("/api/gauges/{name}/commands", get(control::commands))
        .route("/api/gauges/{name}/arm", post(control::arm))
        .route("/api/orders/{id}/fire", post(control::execute))
        .route("/api/orders/{id}", delete(control::disarm))
        .route("/api/mastership", get(control::authority))
        .route("/api/mastership/ask", post(control::request))
        .route("/api/mastership/release", post(control::release))
        .route("/api/mastership/grant", post(control::grant))
        .route("/api/mastership/take-over", post(control::take_over))
}

fn alarm_routes() -> Router<Shared> {
    Router::new()
        .route("/api/alarms", get(alarms::alarms))
        .route("/api/alarms/history", get(alarms::history))
        .route("/api/alarms/acknowledge", post(alarms::acknowledge_all))
        .route("/api/alarms/{name}/acknowledge", post(alarms::acknowledge))
        .route("/api/alarms/{name}/out-of-service", post(alarms::out_of_service))
        .route("/api/alarms/{name}/return-to-service", post(alarms::return_to_service))
        .route("/api/webhooks", get(alarms::webhooks))
}

/// The API of a plant, and the dashboard beside it.
pub fn router(plant: Arc<Services>) -> Router {
    let (archive, moments) =
        (DatabaseReaders::of(Arc::clone(&plant)), Arc::new(SnapshotSource::of(Arc::clone(&plant))));
    Router::new()
        .route("/api/station", get(snapshot::station))
        .route("/api/segments", get(snapshot::segments))
        .route("/api/gauges", get(snapshot::gauges))
        .route("/api/gauges/{name}", get(snapshot::gauge))
        .route("/api/gauges/{name}/blocks", get(snapshot::blocks))
        .route("/api/trend", get(history::trend))
        .route("/api/events", get(history::events))
        .route("/api/rise", get(history::rise))
        .route("/api/export.csv", get(history::export))
        .merge(alarm_routes())
        .route("/api/session", get(session::session))
        .route("/api/login", post(session::login))
        .route("/api/logout", post(session::logout))
        .route("/api/password", post(session::password))
        .route("/api/audit", get(audit::audit))
        .route("/api/audit.csv", get(audit::csv))
        .merge(control_routes())
        .route("/api/live", get(live::live))
        .route("/api/openapi.json", get(async || ([("content-type", "application/json")], description())))
        .route(
            "/api/{*rest}",
            get(async || Problem::unknown("there is no such thing in the API; /api/openapi.json says what there is")),
        )
        .fallback(get(crate::web::file).fallback(method))
        .method_not_allowed_fallback(method)
        .layer(axum::middleware::from_fn(headers::catch_panic))
        .layer(axum::middleware::from_fn(headers::headers))
        .with_state(Shared { plant, archive, moments })
}
