//! Requests to the HTTP API of a station without gauges: any path of the API, any query, any body, each role.
//!
//! The API never fails with 500, and what it refuses as JSON is a problem with a title.

use crate::script::Script;
use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::Request;
use profivac_recorder::{Recorder, Settings};
use profivac_station::api::router;
use profivac_station::auth::{Role, User};
use profivac_station::services::Services;
use std::cell::LazyCell;
use std::sync::Arc;
use tokio::runtime::{Builder, Runtime};
use tower::ServiceExt;

/// The paths, with `*` for a name. Those of a session need the server, which gives each request its context.
const PATHS: [&str; 42] = [
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
];

const METHODS: [&str; 4] = ["GET", "POST", "DELETE", "PUT"];

thread_local! {
    static STATION: LazyCell<(tempfile::TempDir, Runtime, Router)> = LazyCell::new(|| {
        let folder = tempfile::tempdir().expect("a folder");
        let database = folder.path().join("plant.db");
        let recorder = Recorder::start(&database, Settings::default()).expect("a new database");
        let services = Arc::new(Services::new("hall".to_owned(), database, recorder));
        let runtime = Builder::new_current_thread().enable_time().build().expect("a runtime");
        let router = router(services);
        (folder, runtime, router)
    });
}

/// A part of a path or a query with the letters that it may have there.
fn letters(octets: &[u8]) -> String {
    octets.iter().map(|octet| if octet.is_ascii_graphic() { char::from(*octet) } else { '0' }).collect()
}

/// A request from the script.
fn request(script: &mut Script<'_>) -> Option<Request<Body>> {
    let (method, role) = (script.choice(), script.choice());
    let mut path = String::new();
    for letter in script.one_of(&PATHS).chars() {
        match letter {
            '*' => path += &letters(script.piece(12)),
            letter => path.push(letter),
        }
    }
    if method & 0x80 != 0 {
        path = format!("{path}?{}", letters(script.piece(80)));
    }
    let user =
        User { name: Arc::from("Erna"), role: [Role::Viewer, Role::Operator, Role::Engineer][usize::from(role % 3)] };
    let request = Request::builder().method(METHODS[usize::from(method & 3)]).uri(path);
    let request = request.header("content-type", if role & 0x80 == 0 { "application/json" } else { "text/plain" });
    request.extension(user).body(Body::from(script.rest().to_vec())).ok()
}

/// Runs the target.
pub fn run(octets: &[u8]) {
    let Some(request) = request(&mut Script::new(octets)) else { return };
    let shown = format!("{} {}", request.method(), request.uri());
    STATION.with(|station| {
        let (_, runtime, router) = &**station;
        runtime.block_on(async {
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
    });
}
