//! Requests to the HTTP API of a station without gauges: any path of the API, any query, any body, each role; and the same with any head
//! through the middleware of the server, with and without users.
//!
//! The API never fails with 500, and what it refuses as JSON is a problem with a title.

use crate::script::Script;
use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{HeaderValue, Request};
use profivac_recorder::{Recorder, Settings};
use profivac_station::api::router;
use profivac_station::services::Services;
use profivac_web_server::auth::access::Access;
use profivac_web_server::auth::connections::StreamPermits;
use profivac_web_server::auth::rate_limit::{RateLimit, RateLimits};
use profivac_web_server::auth::{Role, User};
use profivac_web_server::authenticator::Authenticator;
use profivac_web_server::headers::Hosts;
use profivac_web_server::middleware::RequestGuard;
use profivac_web_server::server::guarded;
use std::cell::LazyCell;
use std::sync::Arc;
use std::time::Duration;
use tokio::runtime::{Builder, Runtime};
use tower::ServiceExt;

/// The paths, with `*` for a name.
const PATHS: [&str; 51] = [
    "/api/station",
    "/api/segments/*/bus",
    "/api/segments/*/captures",
    "/api/segments/*/captures/*",
    "/api/gauges/*",
    "/api/gauges/*/blocks",
    "/api/plant",
    "/api/trend",
    "/api/events",
    "/api/rise",
    "/api/identify",
    "/api/report.html",
    "/api/pump-downs",
    "/api/export.csv",
    "/api/alarms",
    "/api/alarms/history",
    "/api/alarms/performance",
    "/api/alarms/acknowledge",
    "/api/alarms/*/acknowledge",
    "/api/alarms/shelve",
    "/api/alarms/unshelve",
    "/api/alarms/*/out-of-service",
    "/api/alarms/*/return-to-service",
    "/api/default-alarms",
    "/api/default-alarms/*/settings",
    "/api/plant-states",
    "/api/plant-states/*/declare",
    "/api/plant-states/*/extend",
    "/api/plant-states/*/end",
    "/api/webhooks",
    "/api/gateways",
    "/api/gauges",
    "/api/audit",
    "/api/audit.csv",
    "/api/gauges/*/commands",
    "/api/gauges/*/commands/*",
    "/api/armed-commands/*/execute",
    "/api/armed-commands/*",
    "/api/control-authority",
    "/api/control-authority/request",
    "/api/control-authority/take-over",
    "/*",
    "/api/segments",
    "/api/directory",
    "/api/notes",
    "/api/export.parquet",
    "/api/gauges/*/arm",
    "/api/openapi.json",
    "/api/alarms/*/settings",
    "/api/backup",
    "/api/backup/*",
];

/// The paths of a session, which need the middleware of the server.
const SESSION: [&str; 4] = ["/api/session", "/api/login", "/api/logout", "/api/password"];

/// The headers that the middleware reads.
const HEADERS: [&str; 8] =
    ["host", "origin", "cookie", "content-type", "x-csrf-token", "sec-fetch-site", "accept-encoding", "authorization"];

/// Values that are right at some place.
const VALUES: [&str; 9] = [
    "localhost:8080",
    "http://localhost:8080",
    "application/json",
    "same-origin",
    "none",
    "gzip",
    "vacuum.example",
    "https://vacuum.example",
    "127.0.0.1",
];

const METHODS: [&str; 4] = ["GET", "POST", "DELETE", "PUT"];

/// A station without gauges.
struct Station {
    _folder: tempfile::TempDir,
    runtime: Runtime,
    /// The API alone.
    api: Router,
    /// The API behind the middleware: where every request has an engineer, and where users log in.
    guarded: [Router; 2],
    /// The token of the engineer.
    token: String,
}

impl Station {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let (database, users) = (folder.path().join("plant.db"), folder.path().join("plant.users.toml"));
        let recorder = Recorder::start(&database, Settings::default()).expect("a new database");
        let services = Arc::new(Services::new("hall".to_owned(), database, recorder));
        let runtime = Builder::new_current_thread().enable_time().build().expect("a runtime");
        profivac_web_server::auth::users::Users::change(&users, |_| Ok(())).expect("a new file");
        let guards =
            [guard(&services, Access::anonymous("Erna", Role::Engineer)), guard(&services, Access::Users(users))];
        let token = guards[0].authenticator.authenticate(None).map(|user| user.token.reveal().to_owned());
        let api = router(services);
        let guarded = guards.map(|guard| guarded(api.clone(), guard));
        Self { _folder: folder, runtime, api, guarded, token: token.unwrap_or_default() }
    }
}

/// The middleware of a station behind a proxy. One login is checked in a while, because the check of a password takes long on purpose.
fn guard(services: &Arc<Services>, access: Access) -> RequestGuard {
    let [often, seldom] = [(u32::MAX, Duration::from_nanos(1)), (1, Duration::from_secs(3600))]
        .map(|(burst, period)| RateLimit::new(burst, period));
    let limits = RateLimits {
        requests: often,
        logins: seldom,
        names: seldom,
        openid: seldom,
        writes: often,
        log_entries: seldom,
    };
    let observer = Arc::clone(services);
    let server = ([127, 0, 0, 1], 8080).into();
    RequestGuard {
        authenticator: Arc::new(Authenticator::new(observer, server, access, limits).expect("a right file")),
        hosts: Hosts { loopback: true, configured: vec!["vacuum.example".to_owned()] },
        tls: false,
        port: 8080,
        body_timeout: Duration::from_secs(15),
        streams: StreamPermits::new(16),
    }
}

thread_local! {
    static STATION: LazyCell<Station> = LazyCell::new(Station::new);
}

/// A part of a path or a query with the letters that it may have there.
fn letters(octets: &[u8]) -> String {
    octets.iter().map(|octet| if octet.is_ascii_graphic() { char::from(*octet) } else { '0' }).collect()
}

/// A path of the API from the script, with a query if `has_query`.
fn path(script: &mut Script<'_>, paths: &[&str], has_query: bool) -> String {
    let mut path = String::new();
    for letter in script.one_of(paths).chars() {
        match letter {
            '*' => path += &letters(script.piece(12)),
            letter => path.push(letter),
        }
    }
    if has_query {
        path = format!("{path}?{}", letters(script.piece(80)));
    }
    path
}

/// A request from the script.
fn request(script: &mut Script<'_>) -> Option<Request<Body>> {
    let (method, role) = (script.choice(), script.choice());
    let path = path(script, &PATHS, method & 0x80 != 0);
    let user =
        User { name: Arc::from("Erna"), role: [Role::Viewer, Role::Operator, Role::Engineer][usize::from(role % 3)] };
    let request = Request::builder().method(METHODS[usize::from(method & 3)]).uri(path);
    let request = request.header("content-type", if role & 0x80 == 0 { "application/json" } else { "text/plain" });
    request.extension(user).body(Body::from(script.rest().to_vec())).ok()
}

/// A request as it comes over the network, and the position of the server that gets it.
fn whole_request(script: &mut Script<'_>, token: &str) -> Option<(Request<Body>, usize)> {
    let (method, kind) = (script.choice(), script.choice());
    let path = path(script, if kind & 2 == 0 { &SESSION } else { &PATHS }, method & 0x80 != 0);
    let path = if kind & 4 == 0 { path } else { format!("http://{}{path}", letters(script.piece(20))) };
    let mut request = Request::builder().method(METHODS[usize::from(method & 3)]).uri(path);
    // What a page of the station sends.
    if kind & 8 == 0 {
        request = request.header("host", "localhost:8080").header("content-type", "application/json");
        request = request.header("x-csrf-token", token);
    }
    for _ in 0..kind >> 5 {
        let name = script.one_of(&HEADERS);
        let value = match script.choice() {
            choice if choice & 0x80 == 0 => HeaderValue::from_static(VALUES[usize::from(choice) % VALUES.len()]),
            _ => HeaderValue::from_bytes(script.piece(100)).ok()?,
        };
        request = request.header(name, value);
    }
    let request = request.body(Body::from(script.rest().to_vec())).ok()?;
    Some((request, usize::from(kind & 1)))
}

/// Runs the target.
pub fn run(octets: &[u8]) {
    let Some(request) = request(&mut Script::new(octets)) else { return };
    STATION.with(|station| check(station, &station.api, request));
}

/// Runs the target with the middleware.
pub fn server(octets: &[u8]) {
    STATION.with(|station| {
        let Some((request, position)) = whole_request(&mut Script::new(octets), &station.token) else { return };
        check(station, &station.guarded[position], request);
    });
}

/// Sends a request and looks at the answer.
fn check(station: &Station, router: &Router, request: Request<Body>) {
    let shown = format!("{} {}", request.method(), request.uri());
    station.runtime.block_on(async {
        let answer = router.clone().oneshot(request).await.expect("a router always answers");
        let (status, is_stream) = (answer.status(), shown.contains("/api/live"));
        assert!(status.as_u16() < 500 || status.as_u16() == 503, "{shown}: {status}");
        if is_stream {
            return;
        }
        let body = to_bytes(answer.into_body(), usize::MAX).await.expect("the body of an answer");
        if status.is_client_error() && !body.is_empty() {
            let problem: serde_json::Value = serde_json::from_slice(&body).expect("a problem in JSON");
            assert!(problem["title"].is_string() || problem["detail"].is_string(), "{shown}: {problem}");
        }
    });
}
