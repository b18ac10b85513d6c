//! The HTTP API of the view.
//!
//! | Path | Content |
//! |---|---|
//! | `/api/archive` | stations, latest readings, active alarms |
//! | `/api/live` | the same, then its changes |
//! | `/api/trend` | the trend of a series |
//! | `/api/points` | the points of slaves |
//! | `/api/point-trend` | the trend of a point |
//! | `/api/events` | events |
//! | `/api/stations/{station}/alarms/{alarm}/acknowledge` | acknowledges an alarm at its station |
//! | `/api/session`, `/api/login`, `/api/openid/begin`, `/api/openid/login`, `/api/logout`, `/api/password` | the user, as at a station |
//! | `/api/openapi.json` | this API as an OpenAPI document |
//! | every other path | the page |

use super::history::{ArchivedEvent, ArchivedPoint, Wanted, events, point_trend, points, trend};
use super::pool::{Pool, PoolError};
use super::state::State as Shown;
use super::stations::Stations;
use super::visibility::{Hidden, Visibility};
use super::watch::Watch;
use crate::config::Config;
use crate::pending::Pending;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Path, Query, State};
use axum::http::{Extensions, HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use profivac_archive_protocol::request::{MAX_PIXELS as MAX_STATION_PIXELS, Request};
use profivac_recorder::{PointTrend, Trend};
use profivac_web_pages::archive_file;
use profivac_web_server::auth::{Role, User};
use profivac_web_server::authenticator::AccessObserver;
use profivac_web_server::body::Body;
use profivac_web_server::headers;
use profivac_web_server::live_source::{LiveSource, stream};
use profivac_web_server::problem::{Problem, task_failed};
use profivac_web_server::query::{checked_range, parsed_query, time_range};
use profivac_web_server::session::session_routes;
use serde::Deserialize;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use utoipa::{IntoParams, OpenApi, ToSchema};

/// The most entries of a trend: more than a screen has pixels.
const MAX_PIXELS: u32 = 20_000;

/// The entries of a trend, unless the request says otherwise.
const PIXELS: u32 = 1000;

/// The most events of an answer, and the number unless the request says otherwise.
const MAX_EVENTS: u32 = 10_000;
const EVENTS: u32 = 200;

/// The interval between two events of the live stream: the database is read as often.
const PERIOD: Duration = Duration::from_secs(1);

/// The end of the year 9999, in milliseconds since 1970: no station is asked for later times.
const LAST_MS: i64 = 253_402_300_799_999;

/// The description of the API.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "profivac archive",
        description = "Readings, alarms, events and trends of many vacuum stations. Pressures are in Pa, times in milliseconds since 1970 (UTC)."
    ),
    paths(archive, live, get_trend, get_points, get_point_trend, get_events, acknowledge)
)]
struct Description;

/// The description of the API as JSON.
#[must_use]
pub fn description() -> String {
    Description::openapi().to_pretty_json().unwrap_or_default()
}

/// The state of all handlers.
#[derive(Clone)]
struct Shared {
    pool: Pool,
    watch: Watch,
    stations: Stations,
    log: Arc<dyn AccessObserver>,
    visibility: Visibility,
    sources: Arc<Mutex<HashMap<Hidden, Arc<LiveSource<Shown>>>>>,
}

/// The API and the page.
pub fn router(config: &Config, watch: &Watch, pending: Pending, log: Arc<dyn AccessObserver>) -> Router {
    let shared = Shared {
        pool: Pool::of(config.database.clone()),
        watch: watch.clone(),
        stations: Stations::of(config.nats.clone(), pending),
        log,
        visibility: Visibility::of(&config.plants),
        sources: Arc::default(),
    };
    Router::new()
        .route("/api/archive", get(archive))
        .route("/api/live", get(live))
        .route("/api/trend", get(get_trend))
        .route("/api/points", get(get_points))
        .route("/api/point-trend", get(get_point_trend))
        .route("/api/events", get(get_events))
        .route("/api/stations/{station}/alarms/{alarm}/acknowledge", post(acknowledge))
        .merge(session_routes())
        .route("/api/openapi.json", get(async || ([("content-type", "application/json")], description())))
        .route(
            "/api/{*rest}",
            get(async || Problem::not_found("the API has no such path; /api/openapi.json lists all paths")),
        )
        .fallback(get(archive_file).fallback(method_not_allowed))
        .method_not_allowed_fallback(method_not_allowed)
        .layer(axum::middleware::from_fn(headers::catch_panic))
        .layer(axum::middleware::from_fn(headers::headers))
        .with_state(shared)
}

/// A time that the database has a form for.
fn checked_time(from: i64, to: i64) -> Result<(i64, i64), Problem> {
    time_range(from, to)?;
    Ok((from.clamp(0, LAST_MS), to.clamp(0, LAST_MS)))
}

async fn method_not_allowed() -> Problem {
    Problem::method_not_allowed()
}

/// Stations, latest readings, active alarms
#[utoipa::path(get, path = "/api/archive", responses((status = 200, body = Shown)))]
async fn archive(State(shared): State<Shared>, user: User) -> Json<Shown> {
    Json(shared.watch.state(&shared.visibility.hidden_from(&user)))
}

/// The same, and its changes, up to one a second
///
/// Server-sent events. The event `snapshot` has the whole state and comes first; each event `change` has the parts of it that have
/// changed: of stations, readings and alarms the entries that have changed, `null` for one that is gone. The stream ends with the session of its client.
#[utoipa::path(get, path = "/api/live", responses((status = 200, content_type = "text/event-stream", body = Shown)))]
async fn live(State(shared): State<Shared>, user: User, headers: HeaderMap, extensions: Extensions) -> Response {
    stream(shared.source_for(&user), &headers, &extensions)
}

/// The series and the time range of a trend.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
struct TrendParameters {
    /// Station and series: `hall-1/chamber`.
    #[param(example = "hall-1/chamber")]
    series: String,
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// The most entries of the trend, 1 to 20000.
    #[param(default = 1000, minimum = 1, maximum = 20_000)]
    pixels: Option<u32>,
    /// Whether the station is asked for the trend of its own database, which has all samples; then `pixels` is 4000 at most.
    #[param(default = false)]
    full: Option<bool>,
}

/// The trend of a series
///
/// Samples where a pixel is shorter than two minutes, otherwise the spans of the station. A series without rows has an empty trend.
#[utoipa::path(
    get,
    path = "/api/trend",
    params(TrendParameters),
    responses(
        (status = 200, body = Trend),
        (status = 400, body = Problem, description = "A parameter is wrong"),
        (status = 404, body = Problem, description = "The archive has no such station"),
        (status = 409, body = Problem, description = "The station refuses"),
        (status = 501, body = Problem, description = "The file of the archive has no way to the station"),
        (status = 503, body = Problem, description = "The database or the station does not answer")
    )
)]
async fn get_trend(
    State(shared): State<Shared>,
    user: User,
    query: Result<Query<TrendParameters>, QueryRejection>,
) -> Result<Response, Problem> {
    let TrendParameters { series, from, to, pixels, full } = parsed_query(query)?;
    let time = checked_time(from, to)?;
    let pixels = checked_range("pixels", pixels.unwrap_or(PIXELS), MAX_PIXELS)?;
    let Some((station, series)) = series.split_once('/') else {
        return Err(Problem::bad_request(format!("expected series=STATION/SERIES, found {series:?}")));
    };
    let plant = shared.plant_of(station, &user)?;
    if full == Some(true) {
        let pixels = checked_range("pixels", pixels, MAX_STATION_PIXELS)?;
        let request = Request::Trend { series: series.to_owned(), from_ms: time.0, to_ms: time.1, pixels };
        let trend = shared.stations.trend(&plant, station, &request).await?;
        // The station knows the series without its own name before it.
        return Ok(Json(Trend { series: format!("{station}/{series}"), ..trend }).into_response());
    }
    let wanted = Wanted { station: station.to_owned(), series: series.to_owned(), time, pixels };
    Ok(Json(to_its_end(async move { trend(&shared.pool, &wanted).await }).await?).into_response())
}

/// The points of slaves, with their units
#[utoipa::path(
    get,
    path = "/api/points",
    responses(
        (status = 200, body = [ArchivedPoint]),
        (status = 503, body = Problem, description = "The database does not answer")
    )
)]
async fn get_points(State(shared): State<Shared>, user: User) -> Result<Json<Vec<ArchivedPoint>>, Problem> {
    let hidden = shared.visibility.hidden_from(&user);
    Ok(Json(to_its_end(async move { points(&shared.pool, &hidden).await }).await?))
}

/// The point and the time range of a trend.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
struct PointTrendParameters {
    /// The station.
    #[param(example = "hall-1")]
    station: String,
    /// The slave.
    #[param(example = "turbo")]
    slave: String,
    /// The point.
    #[param(example = "speed")]
    point: String,
    /// The unit, if the point was recorded in several; empty for a point without a unit. Default: the unit of the last value.
    unit: Option<String>,
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// The most entries of the trend, 1 to 20000.
    #[param(default = 1000, minimum = 1, maximum = 20_000)]
    pixels: Option<u32>,
}

/// The trend of a point, in its unit
///
/// Values where a pixel is shorter than two minutes, otherwise the spans of the station.
#[utoipa::path(
    get,
    path = "/api/point-trend",
    params(PointTrendParameters),
    responses(
        (status = 200, body = PointTrend),
        (status = 400, body = Problem, description = "A parameter is wrong"),
        (status = 404, body = Problem, description = "The archive has no such station or point"),
        (status = 503, body = Problem, description = "The database does not answer")
    )
)]
async fn get_point_trend(
    State(shared): State<Shared>,
    user: User,
    query: Result<Query<PointTrendParameters>, QueryRejection>,
) -> Result<Json<PointTrend>, Problem> {
    let PointTrendParameters { station, slave, point, unit, from, to, pixels } = parsed_query(query)?;
    let time = checked_time(from, to)?;
    let pixels = checked_range("pixels", pixels.unwrap_or(PIXELS), MAX_PIXELS)?;
    shared.plant_of(&station, &user)?;
    let none = || Problem::not_found(format!("the archive has no point {point:?} of {slave:?} at {station:?}"));
    let (missing, wanted) = (none(), Wanted { station, series: point, time, pixels });
    let query = async move { point_trend(&shared.pool, &slave, unit.as_deref(), &wanted).await };
    to_its_end(query).await?.map(Json).ok_or(missing)
}

/// Runs a query to its end, also when the client is gone: its statement keeps its permit until then, so that clients who leave cannot
/// start more statements than there are permits.
async fn to_its_end<T: Send + 'static>(
    query: impl Future<Output = Result<T, PoolError>> + Send + 'static,
) -> Result<T, Problem> {
    Ok(tokio::spawn(query).await.map_err(|error| task_failed(&error))??)
}

impl Shared {
    /// The plant of a station that the archive knows and the user sees. One that is hidden has the answer of one that does not exist.
    fn plant_of(&self, station: &str, user: &User) -> Result<String, Problem> {
        let plant = self.watch.plant_of(station);
        let seen = plant.map(|plant| Some(plant).filter(|it| !self.visibility.hidden_from(user).contains(it)));
        match seen {
            Ok(Some(plant)) => Ok(plant),
            Err(Some(problem)) => Err(Problem::unavailable(problem)),
            Ok(None) | Err(None) => Err(Problem::not_found(format!("the archive has no station {station:?}"))),
        }
    }

    /// The stream of all who see the same plants.
    fn source_for(&self, user: &User) -> Arc<LiveSource<Shown>> {
        let hidden = self.visibility.hidden_from(user);
        let mut sources = self.sources.lock().unwrap_or_else(PoisonError::into_inner);
        let source = || {
            let (watch, hidden) = (self.watch.clone(), hidden.clone());
            Arc::new(LiveSource::of(PERIOD, move || watch.state(&hidden)))
        };
        Arc::clone(sources.entry(hidden.clone()).or_insert_with(source))
    }
}

/// The occurrence of an alarm that a user has seen.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct Acknowledge {
    /// The number of the occurrence.
    #[schema(example = 1)]
    occurrence: i64,
}

/// Acknowledge an alarm at its station
///
/// The station decides, and writes the name of the user into its audit trail. The changed state comes in the live stream.
#[utoipa::path(
    post,
    path = "/api/stations/{station}/alarms/{alarm}/acknowledge",
    params(
        ("station" = String, Path, description = "The station", example = "hall-1"),
        ("alarm" = String, Path, description = "The alarm", example = "chamber too high")
    ),
    request_body = Acknowledge,
    responses(
        (status = 204, description = "The alarm is acknowledged"),
        (status = 400, body = Problem, description = "The body is malformed"),
        (status = 403, body = Problem, description = "The role operator is needed"),
        (status = 404, body = Problem, description = "The archive has no such station"),
        (status = 409, body = Problem, description = "The station refuses"),
        (status = 501, body = Problem, description = "The file of the archive has no way to the station"),
        (status = 503, body = Problem, description = "The station does not answer")
    )
)]
async fn acknowledge(
    State(shared): State<Shared>,
    user: User,
    Path((station, alarm)): Path<(String, String)>,
    Body(Acknowledge { occurrence }): Body<Acknowledge>,
) -> Result<StatusCode, Problem> {
    user.require(Role::Operator, "acknowledging an alarm")?;
    let request = Request::Acknowledge { alarm: alarm.clone(), occurrence, user: user.name.to_string() };
    shared.stations.acknowledge(&shared.plant_of(&station, &user)?, &station, &request).await?;
    shared.log.record(&format!("{} acknowledged {alarm:?} at {station}", user.name));
    Ok(StatusCode::NO_CONTENT)
}

/// The station and the time range of events.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
struct EventsParameters {
    /// The station; all unless given.
    #[param(example = "hall-1")]
    station: Option<String>,
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// The most events of the answer, 1 to 10000.
    #[param(default = 200, minimum = 1, maximum = 10_000)]
    limit: Option<u32>,
}

/// Events, the latest first
#[utoipa::path(
    get,
    path = "/api/events",
    params(EventsParameters),
    responses(
        (status = 200, body = [ArchivedEvent]),
        (status = 400, body = Problem, description = "A parameter is wrong"),
        (status = 503, body = Problem, description = "The database does not answer")
    )
)]
async fn get_events(
    State(shared): State<Shared>,
    user: User,
    query: Result<Query<EventsParameters>, QueryRejection>,
) -> Result<Json<Vec<ArchivedEvent>>, Problem> {
    let EventsParameters { station, from, to, limit } = parsed_query(query)?;
    let time = checked_time(from, to)?;
    let limit = checked_range("limit", limit.unwrap_or(EVENTS), MAX_EVENTS)?;
    let hidden = shared.visibility.hidden_from(&user);
    let query = async move { events(&shared.pool, station.as_deref(), time, limit.into(), &hidden).await };
    Ok(Json(to_its_end(query).await?))
}
