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

mod acting;
mod alarms;
mod archive;
mod audit;
mod body;
mod described;
pub mod gate;
pub mod guard;
mod live;
mod problem;
mod recorded;
mod seen;
mod session;

use crate::plant::Plant;
use archive::Archive;
use axum::Router;
use axum::extract::FromRef;
use axum::routing::{delete, get, post};
use described::Door;
use live::Moments;
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
    modifiers(&Door),
    paths(
        seen::station,
        seen::segments,
        seen::gauges,
        seen::gauge,
        seen::blocks,
        recorded::trend,
        recorded::events,
        recorded::rise,
        recorded::export,
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
        acting::commands,
        acting::arm,
        acting::fire,
        acting::disarm,
        acting::mastership,
        acting::ask,
        acting::release,
        acting::grant,
        acting::take_over,
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
    plant: Arc<Plant>,
    archive: Archive,
    moments: Arc<Moments>,
}

impl FromRef<Shared> for Arc<Plant> {
    fn from_ref(shared: &Shared) -> Self {
        Self::clone(&shared.plant)
    }
}

impl FromRef<Shared> for Archive {
    fn from_ref(shared: &Shared) -> Self {
        shared.archive.clone()
    }
}

impl FromRef<Shared> for Arc<Moments> {
    fn from_ref(shared: &Shared) -> Self {
        Self::clone(&shared.moments)
    }
}

async fn method() -> Problem {
    Problem::method()
}

/// Everything that changes something.
fn acts() -> Router<Shared> {
    Router::new()
        .route("/api/gauges/{name}/commands", get(acting::commands))
        .route("/api/gauges/{name}/arm", post(acting::arm))
        .route("/api/orders/{id}/fire", post(acting::fire))
        .route("/api/orders/{id}", delete(acting::disarm))
        .route("/api/mastership", get(acting::mastership))
        .route("/api/mastership/ask", post(acting::ask))
        .route("/api/mastership/release", post(acting::release))
        .route("/api/mastership/grant", post(acting::grant))
        .route("/api/mastership/take-over", post(acting::take_over))
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
pub fn router(plant: Arc<Plant>) -> Router {
    let (archive, moments) = (Archive::of(Arc::clone(&plant)), Arc::new(Moments::of(Arc::clone(&plant))));
    Router::new()
        .route("/api/station", get(seen::station))
        .route("/api/segments", get(seen::segments))
        .route("/api/gauges", get(seen::gauges))
        .route("/api/gauges/{name}", get(seen::gauge))
        .route("/api/gauges/{name}/blocks", get(seen::blocks))
        .route("/api/trend", get(recorded::trend))
        .route("/api/events", get(recorded::events))
        .route("/api/rise", get(recorded::rise))
        .route("/api/export.csv", get(recorded::export))
        .merge(alarm_routes())
        .route("/api/session", get(session::session))
        .route("/api/login", post(session::login))
        .route("/api/logout", post(session::logout))
        .route("/api/password", post(session::password))
        .route("/api/audit", get(audit::audit))
        .route("/api/audit.csv", get(audit::csv))
        .merge(acts())
        .route("/api/live", get(live::live))
        .route("/api/openapi.json", get(async || ([("content-type", "application/json")], description())))
        .route(
            "/api/{*rest}",
            get(async || Problem::unknown("there is no such thing in the API; /api/openapi.json says what there is")),
        )
        .fallback(get(crate::web::file).fallback(method))
        .method_not_allowed_fallback(method)
        .layer(axum::middleware::from_fn(guard::caught))
        .layer(axum::middleware::from_fn(guard::headers))
        .with_state(Shared { plant, archive, moments })
}
