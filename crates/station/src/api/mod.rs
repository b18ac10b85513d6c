//! The HTTP API of the station, for the dashboard and for other programs.
//!
//! | Path | Content |
//! |---|---|
//! | `/api/station` | the station and its recorder |
//! | `/api/segments` | the segments with the stations on them |
//! | `/api/segments/{name}/bus` | the live list and the statistics of a segment |
//! | `/api/segments/{name}/captures` and below | captures of its traffic |
//! | `/api/gauges` | the gauges with their readings |
//! | `/api/gauges/{name}/blocks` | the blocks and parameters of a gauge, read now |
//! | `/api/gauges/{name}/commands` | the commands of a gauge with conditions and risks |
//! | `/api/gauges/{name}/arm` | arms a command or a write |
//! | `/api/armed-commands/{id}`, `/api/armed-commands/{id}/execute` | disarms and executes it |
//! | `/api/control-authority` and below | control authority |
//! | `/api/audit`, `/api/audit.csv` | the audit trail |
//! | `/api/backup` and below | copies of the database |
//! | `/api/directory` | the labels of the gauges, and the views |
//! | `/api/plant` | the plant: volumes, valves, pumps |
//! | `/api/trend` | the trend of a series |
//! | `/api/events` | events |
//! | `/api/notes` | makes a note, which is an event |
//! | `/api/rise` | a rise of pressure, separated into a leak and outgassing |
//! | `/api/identify` | the numbers of a plant from the record of a gauge |
//! | `/api/report.html` | a report about a pump-down |
//! | `/api/pump-downs` | pump-downs beside the usual ones |
//! | `/api/export.csv`, `/api/export.parquet` | samples as CSV and as Parquet |
//! | `/api/points`, `/api/point-trend` | the recorded points of slaves, and the trend of one |
//! | `/api/points.csv`, `/api/points.parquet` | their values as CSV and as Parquet |
//! | `/api/alarms` | the alarms with their states |
//! | `/api/alarms/history` | the history of alarms |
//! | `/api/alarms/acknowledge`, `/api/alarms/{name}/acknowledge` | acknowledges alarms |
//! | `/api/alarms/performance` | figures of the alarms: how many, how often, which |
//! | `/api/alarms/shelve`, `/api/alarms/unshelve` | shelves alarms for a while, and unshelves them |
//! | `/api/alarms/{name}/out-of-service`, `.../return-to-service` | takes an alarm out of service, and returns it |
//! | `/api/default-alarms`, `/api/default-alarms/{name}/settings` | the settings of default alarms, and their change |
//! | `/api/plant-states` | the plant states with their declarations |
//! | `/api/plant-states/{name}/declare`, `.../extend`, `.../end` | declares a plant state, gives it a later end, ends it |
//! | `/api/webhooks` | the webhooks with the status of their deliveries |
//! | `/api/gateways` | the gateways to control systems with their clients and errors |
//! | `/api/session` | the user of the session |
//! | `/api/login`, `/api/logout`, `/api/password` | begins a session, ends it, changes the password |
//! | `/api/openid/begin`, `/api/openid/login` | begins a login at an OpenID provider, completes it |
//! | `/api/live` | the state of the station and its changes, as server-sent events |
//! | `/api/openapi.json` | the OpenAPI description |
//!
//! | Module | Holds |
//! |---|---|
//! | `openapi` | the OpenAPI description |
//! | `database` | queries on blocking threads |
//! | `fits` | fits of plants, one at a time |
//! | `names` | answers to names that the station does not have |
//! | the others | the handlers |

mod alarm_settings;
mod alarms;
mod audit;
mod backup;
mod bus;
mod control;
mod database;
mod fits;
mod history;
mod identify;
mod live;
mod names;
mod notes;
#[cfg_attr(not(feature = "openapi"), path = "no_openapi.rs")]
mod openapi;
mod plant_states;
mod pump_downs;
mod report;
mod snapshot;

use crate::services::Services;
use axum::Router;
use axum::extract::FromRef;
use axum::routing::{delete, get, post};
use backup::Backups;
use database::DatabaseReaders;
use fits::Fits;
pub use openapi::description;
use profivac_web_server::headers;
use profivac_web_server::live_source::LiveSource;
use profivac_web_server::problem::Problem;
use profivac_web_server::session::session_routes;
use std::sync::Arc;

/// The state of all handlers.
#[derive(Clone)]
struct Shared {
    services: Arc<Services>,
    readers: DatabaseReaders,
    fits: Fits,
    backups: Backups,
    snapshots: Arc<LiveSource<live::Snapshot>>,
}

impl FromRef<Shared> for Arc<Services> {
    fn from_ref(shared: &Shared) -> Self {
        Self::clone(&shared.services)
    }
}

impl FromRef<Shared> for DatabaseReaders {
    fn from_ref(shared: &Shared) -> Self {
        shared.readers.clone()
    }
}

impl FromRef<Shared> for Fits {
    fn from_ref(shared: &Shared) -> Self {
        shared.fits.clone()
    }
}

impl FromRef<Shared> for Backups {
    fn from_ref(shared: &Shared) -> Self {
        shared.backups.clone()
    }
}

impl FromRef<Shared> for Arc<LiveSource<live::Snapshot>> {
    fn from_ref(shared: &Shared) -> Self {
        Self::clone(&shared.snapshots)
    }
}

async fn method_not_allowed() -> Problem {
    Problem::method_not_allowed()
}

/// Commands and control authority.
fn control_routes() -> Router<Shared> {
    Router::new()
        .route("/api/gauges/{name}/commands", get(control::commands))
        .route("/api/gauges/{name}/arm", post(control::arm))
        .route("/api/armed-commands/{id}/execute", post(control::execute))
        .route("/api/armed-commands/{id}", delete(control::disarm))
        .route("/api/control-authority", get(control::authority))
        .route("/api/control-authority/request", post(control::request))
        .route("/api/control-authority/release", post(control::release))
        .route("/api/control-authority/grant", post(control::grant))
        .route("/api/control-authority/take-over", post(control::take_over))
}

fn alarm_routes() -> Router<Shared> {
    Router::new()
        .route("/api/alarms", get(alarms::alarms))
        .route("/api/alarms/history", get(alarms::history))
        .route("/api/alarms/performance", get(alarms::performance))
        .route("/api/alarms/acknowledge", post(alarms::acknowledge_all))
        .route("/api/alarms/{name}/acknowledge", post(alarms::acknowledge))
        .route("/api/alarms/shelve", post(alarms::shelve))
        .route("/api/alarms/unshelve", post(alarms::unshelve))
        .route("/api/alarms/{name}/out-of-service", post(alarms::out_of_service))
        .route("/api/alarms/{name}/return-to-service", post(alarms::return_to_service))
        .route("/api/alarms/{name}/settings", get(alarm_settings::settings).post(alarm_settings::change))
        .route("/api/default-alarms", get(alarm_settings::defaults))
        .route("/api/default-alarms/{name}/settings", post(alarm_settings::change_default))
        .route("/api/plant-states", get(plant_states::plant_states))
        .route("/api/plant-states/{name}/declare", post(plant_states::declare))
        .route("/api/plant-states/{name}/extend", post(plant_states::extend))
        .route("/api/plant-states/{name}/end", post(plant_states::end))
        .route("/api/webhooks", get(alarms::webhooks))
}

/// The API of a station, and the dashboard.
pub fn router(services: Arc<Services>) -> Router {
    let readers = DatabaseReaders::of(Arc::clone(&services));
    let backups = Backups::new(&services);
    let snapshots = Arc::new(live::source(Arc::clone(&services)));
    Router::new()
        .route("/api/station", get(snapshot::station))
        .route("/api/segments", get(snapshot::segments))
        .route("/api/segments/{name}/bus", get(bus::bus))
        .route("/api/segments/{name}/captures", get(bus::captures).post(bus::trigger))
        .route("/api/segments/{name}/captures/{file}", get(bus::capture))
        .route("/api/gauges", get(snapshot::gauges))
        .route("/api/gauges/{name}", get(snapshot::gauge))
        .route("/api/gauges/{name}/blocks", get(snapshot::blocks))
        .route("/api/gateways", get(snapshot::gateways))
        .route("/api/plant", get(snapshot::plant))
        .route("/api/directory", get(snapshot::directory))
        .route("/api/trend", get(history::trend))
        .route("/api/events", get(history::events))
        .route("/api/notes", post(notes::make))
        .route("/api/rise", get(history::rise))
        .route("/api/identify", get(identify::identify))
        .route("/api/report.html", get(report::report))
        .route("/api/pump-downs", get(pump_downs::pump_downs))
        .route("/api/export.csv", get(history::export))
        .route("/api/export.parquet", get(history::export_parquet))
        .route("/api/points", get(history::points))
        .route("/api/points.csv", get(history::export_points))
        .route("/api/points.parquet", get(history::export_points_parquet))
        .route("/api/point-trend", get(history::point_trend))
        .merge(alarm_routes())
        .merge(session_routes())
        .route("/api/audit", get(audit::audit))
        .route("/api/audit.csv", get(audit::csv))
        .route("/api/backup", post(backup::backup))
        .route("/api/backup/{id}", get(backup::download))
        .merge(control_routes())
        .route("/api/live", get(live::live))
        .route("/api/openapi.json", get(async || ([("content-type", "application/json")], description())))
        .route(
            "/api/{*rest}",
            get(async || Problem::not_found("the API has no such path; /api/openapi.json lists all paths")),
        )
        .fallback(get(profivac_web_pages::file).fallback(method_not_allowed))
        .method_not_allowed_fallback(method_not_allowed)
        .layer(axum::middleware::from_fn(headers::catch_panic))
        .layer(axum::middleware::from_fn(headers::headers))
        .with_state(Shared { services, readers, fits: Fits::new(), backups, snapshots })
}
