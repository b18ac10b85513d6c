//! Scrapes of the gateway for Prometheus, with a token and without: any path, host, token and `Accept`.
//!
//! The metrics come only to the right host and token, and every other request gets a text that says why.

use crate::script::Script;
use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{HeaderValue, Request, StatusCode};
use profivac_gateway::ReadModel;
use profivac_gateway::thread::Context;
use profivac_gateway_prometheus::router;
use profivac_recorder::Recorder;
use profivac_station::config::gateways::prometheus::Settings;
use profivac_station::services::Services;
use profivac_web_server::tables::Secret;
use std::cell::LazyCell;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use tokio::runtime::{Builder, Runtime};
use tower::ServiceExt;

const TOKEN: &str = "correct-horse-battery-staple";

/// Values that are right, or nearly.
const HOSTS: [&str; 4] = ["localhost:9464", "127.0.0.1", "vacuum.example", "[::1]"];
const TOKENS: [&str; 4] =
    ["Bearer correct-horse-battery-staple", "bearer  correct-horse-battery-staple ", "Basic cm9vdA==", "Bearer"];
const ACCEPT: [&str; 4] = [
    "application/openmetrics-text;version=1.0.0;q=0.5,text/plain;version=0.0.4;q=0.3,*/*;q=0.1",
    "text/*;q=1",
    "*/*",
    "application/openmetrics-text; version=\"0.0.1\"",
];

/// A gateway without a token, and one with it.
struct Gateway {
    _folder: tempfile::TempDir,
    runtime: Runtime,
    routers: [Router; 2],
}

impl Gateway {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let database = folder.path().join("plant.db");
        let recorder = Recorder::start(&database, profivac_recorder::Settings::default()).expect("a new database");
        let services = Arc::new(Services::new("hall".to_owned(), database, recorder));
        let model = Arc::new(ReadModel::start(Arc::clone(&services)).expect("a thread"));
        let routers = [None, Some(secret())].map(|token| {
            let listen = SocketAddr::from((Ipv4Addr::LOCALHOST, 9464));
            let (context, _stop) = Context::new("prometheus", Arc::clone(&model), Arc::clone(&services));
            router(&Settings { listen, token, tls: None }, context)
        });
        let runtime = Builder::new_current_thread().enable_time().build().expect("a runtime");
        Self { _folder: folder, runtime, routers }
    }
}

/// The token as a file of the station has it.
fn secret() -> Secret {
    serde_json::from_value(TOKEN.into()).expect("a text")
}

thread_local! {
    static GATEWAY: LazyCell<Gateway> = LazyCell::new(Gateway::new);
}

/// A value of a header: one of `usual`, or any octets that a header may have.
fn value(script: &mut Script<'_>, usual: &[&'static str]) -> Option<HeaderValue> {
    match script.choice() {
        choice if choice & 0x80 == 0 => Some(HeaderValue::from_static(usual[usize::from(choice) % usual.len()])),
        _ => HeaderValue::from_bytes(script.piece(100)).ok(),
    }
}

/// Runs the target.
pub fn run(octets: &[u8]) {
    let mut script = Script::new(octets);
    let kind = script.choice();
    let mut request = Request::builder().method(script.one_of(&["GET", "HEAD", "POST"]));
    request =
        request.uri(script.one_of(&["/metrics", "/", "http://localhost/metrics", "http://vacuum.example/metrics"]));
    for (bit, name, usual) in
        [(1, "host", HOSTS), (2, "authorization", TOKENS), (4, "accept", ACCEPT), (8, "host", HOSTS)]
    {
        if kind & bit != 0 {
            let Some(value) = value(&mut script, &usual) else { return };
            request = request.header(name, value);
        }
    }
    let has_token = kind & 0x80 != 0;
    let Ok(request) = request.body(Body::empty()) else { return };
    let given = request.headers().get("authorization").and_then(|value| value.to_str().ok()).unwrap_or_default();
    let is_right = given.to_ascii_lowercase().starts_with("bearer ") && given[7..].trim() == TOKEN;
    let is_get = request.method() == "GET";
    GATEWAY.with(|gateway| {
        gateway.runtime.block_on(async {
            let answer = gateway.routers[usize::from(has_token)].clone().oneshot(request).await.expect("an answer");
            let status = answer.status();
            let body = to_bytes(answer.into_body(), usize::MAX).await.expect("the body of an answer");
            assert!(status != StatusCode::OK || is_right || !has_token, "metrics without a token");
            assert!(!is_get || !body.is_empty(), "{status} without a text");
            assert!(!status.is_server_error(), "{status}");
        });
    });
}
