//! The server: `/metrics` over HTTP, with TLS and a bearer token beyond loopback.

use crate::exposition::Format;
use crate::metrics::{Layout, Others};
use axum::Router;
use axum::body::Bytes;
use axum::extract::{Request, State};
use axum::http::header::{ACCEPT, AUTHORIZATION, CONTENT_TYPE, WWW_AUTHENTICATE};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use profivac_gateway::Snapshot;
use profivac_gateway::thread::Context;
use profivac_station::config::gateways::prometheus::Settings;
use profivac_station::gateway_status::GatewayStatus;
use profivac_web_server::headers::{Hosts, requested_host};
use profivac_web_server::server::{Connections, Keys, Limits, TlsError};
use profivac_web_server::tables::Secret;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use subtle::ConstantTimeEq;
use tokio::net::TcpListener;
use tokio::time::{MissedTickBehavior, interval};

/// Connections at the same time. chosen: some dozen servers, each with one or two connections.
const MAX_CONNECTIONS: usize = 128;

/// The longest time for the head of a request and for a TLS handshake, and that a client may not read its answer.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(10);

/// The time between two readings of certificate and key.
const KEYS_PERIOD: Duration = Duration::from_secs(60);

/// The reason why the gateway does not serve.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PrometheusError {
    /// The address cannot be used.
    #[error("cannot listen on {address}: {error}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The error of the operating system.
        error: std::io::Error,
    },
    /// Certificate or key cannot be used.
    #[error(transparent)]
    Tls(#[from] TlsError),
}

/// Serves until the gateway is to end.
pub async fn serve(settings: Settings, context: Context) -> Result<(), PrometheusError> {
    let router = router(&settings, context.clone());
    let Settings { listen: address, tls, .. } = settings;
    let keys = tls.map(Keys::read).transpose()?.map(Arc::new);
    let listener = TcpListener::bind(address).await.map_err(|error| PrometheusError::Listen { address, error })?;
    context.status.runs(listener.local_addr().unwrap_or(address).to_string());
    let mut stop = context.stop.clone();
    let status = Arc::clone(&context.status);
    let connections = Connections {
        observer: Some(Arc::<GatewayStatus>::clone(&status)),
        keys: keys.clone(),
        limits: Limits {
            connections: MAX_CONNECTIONS,
            head: CLIENT_TIMEOUT,
            stalled: CLIENT_TIMEOUT,
            ..Limits::default()
        },
        router,
    };
    tokio::select! {
        () = connections.serve(&listener) => {}
        () = renew(keys, &status) => {}
        () = stop.stopped() => {}
    }
    Ok(())
}

/// Reads certificate and key again and again, because certificates are renewed while the station runs. Never returns.
async fn renew(keys: Option<Arc<Keys>>, status: &GatewayStatus) {
    let Some(keys) = keys else { return std::future::pending().await };
    let mut ticks = interval(KEYS_PERIOD);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        ticks.tick().await;
        if let Err(error) = keys.renew() {
            status.error(&format!("{error}; the gateway keeps the present certificate"));
        }
    }
}

/// What answers the requests of the connections.
pub fn router(settings: &Settings, context: Context) -> Router {
    let scrapes = Arc::new(Scrapes {
        hosts: Hosts { loopback: settings.listen.ip().is_loopback(), configured: Vec::new() },
        token: settings.token.clone(),
        latest: Mutex::default(),
        context,
    });
    Router::new()
        .route("/metrics", get(metrics))
        .fallback(async |State(scrapes): State<Arc<Scrapes>>| {
            scrapes.refuse(StatusCode::NOT_FOUND, "the metrics are at /metrics")
        })
        .method_not_allowed_fallback(async |State(scrapes): State<Arc<Scrapes>>| {
            scrapes.refuse(StatusCode::METHOD_NOT_ALLOWED, "expected GET; the gateway only reads")
        })
        .layer(from_fn_with_state(Arc::clone(&scrapes), authorise))
        .with_state(scrapes)
}

/// What all scrapes share.
struct Scrapes {
    context: Context,
    hosts: Hosts,
    token: Option<Secret>,
    latest: Mutex<Latest>,
}

/// The texts of the latest snapshot that was asked for: all scrapes of a snapshot get the same.
#[derive(Default)]
struct Latest {
    snapshot: Arc<Snapshot>,
    layout: Option<Layout>,
    texts: [Option<Bytes>; 2],
}

impl Scrapes {
    /// The text of the present snapshot.
    fn text(&self, format: Format) -> Bytes {
        let snapshot = self.context.model.snapshot();
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        if !Arc::ptr_eq(&latest.snapshot, &snapshot) {
            latest.snapshot = snapshot;
            latest.texts = [None, None];
        }
        let Latest { snapshot, layout, texts: [open_metrics, prometheus] } = &mut *latest;
        let text = match format {
            Format::OpenMetrics => open_metrics,
            Format::Prometheus => prometheus,
        };
        let make = || {
            let fitting = layout.take().filter(|layout| layout.fits(snapshot));
            let layout = layout.insert(fitting.unwrap_or_else(|| Layout::of(&snapshot.points)));
            Bytes::from(layout.text(snapshot, &self.others(), format))
        };
        text.get_or_insert_with(make).clone()
    }

    fn others(&self) -> Others {
        let services = &self.context.services;
        Others {
            station: services.name().to_owned(),
            recorder: services.station().recorder,
            buses: services.snapshots().buses().reports(),
            gateways: services.gateways().views(),
        }
    }

    /// Refuses a request, and counts it.
    fn refuse(&self, status: StatusCode, reason: &'static str) -> Response {
        self.context.status.refused(reason);
        (status, format!("{reason}\n")).into_response()
    }
}

async fn metrics(State(scrapes): State<Arc<Scrapes>>, headers: HeaderMap) -> Response {
    let accept = headers.get(ACCEPT).and_then(|accept| accept.to_str().ok()).unwrap_or_default();
    let format = Format::accepted(accept);
    let text = scrapes.text(format);
    scrapes.context.status.sent(1);
    ([(CONTENT_TYPE, format.content_type())], text).into_response()
}

/// Lets requests pass that are meant for this computer and have the token.
async fn authorise(State(scrapes): State<Arc<Scrapes>>, request: Request, next: Next) -> Response {
    if !scrapes.hosts.accept(&requested_host(request.headers(), request.uri())) {
        return scrapes.refuse(StatusCode::MISDIRECTED_REQUEST, "the request is meant for another computer");
    }
    let given = request.headers().get(AUTHORIZATION).and_then(|given| given.to_str().ok());
    if !is_authorised(scrapes.token.as_ref(), given) {
        let refusal = scrapes.refuse(StatusCode::UNAUTHORIZED, "expected the bearer token of token-file");
        return ([(WWW_AUTHENTICATE, "Bearer")], refusal).into_response();
    }
    next.run(request).await
}

/// Whether the header has the token. The comparison takes the same time wherever they differ.
fn is_authorised(token: Option<&Secret>, given: Option<&str>) -> bool {
    let Some(token) = token else { return true };
    let Some((scheme, given)) = given.and_then(|given| given.split_once(' ')) else { return false };
    scheme.eq_ignore_ascii_case("bearer") && bool::from(given.trim().as_bytes().ct_eq(token.reveal().as_bytes()))
}
