//! `/metrics` for Prometheus: the check of the requested host and of the bearer token, and the choice of the format.

use crate::exposition::Format;
use crate::headers::{Hosts, requested_host};
use crate::tables::Secret;
use axum::Router;
use axum::body::Bytes;
use axum::extract::{Request, State};
use axum::http::header::{ACCEPT, AUTHORIZATION, CONTENT_TYPE, WWW_AUTHENTICATE};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use std::net::SocketAddr;
use std::sync::Arc;
use subtle::ConstantTimeEq;

/// What has metrics.
pub trait Source: Send + Sync + 'static {
    /// The present text of a scrape.
    fn text(&self, format: Format) -> Bytes;

    /// Counts a request that was refused.
    fn refused(&self, _reason: &'static str) {}
}

/// What all scrapes share.
struct Scrapes {
    hosts: Hosts,
    token: Option<Secret>,
    source: Arc<dyn Source>,
}

/// Answers scrapes at this address, those with the token if there is one.
pub fn router(listen: SocketAddr, token: Option<Secret>, source: Arc<dyn Source>) -> Router {
    let hosts = Hosts { loopback: listen.ip().is_loopback(), configured: Vec::new() };
    let scrapes = Arc::new(Scrapes { hosts, token, source });
    Router::new()
        .route("/metrics", get(metrics))
        .fallback(async |State(scrapes): State<Arc<Scrapes>>| {
            scrapes.refuse(StatusCode::NOT_FOUND, "the metrics are at /metrics")
        })
        .method_not_allowed_fallback(async |State(scrapes): State<Arc<Scrapes>>| {
            scrapes.refuse(StatusCode::METHOD_NOT_ALLOWED, "expected GET; the metrics are only read")
        })
        .layer(from_fn_with_state(Arc::clone(&scrapes), authorise))
        .with_state(scrapes)
}

impl Scrapes {
    /// Refuses a request, and counts it.
    fn refuse(&self, status: StatusCode, reason: &'static str) -> Response {
        self.source.refused(reason);
        (status, format!("{reason}\n")).into_response()
    }
}

async fn metrics(State(scrapes): State<Arc<Scrapes>>, headers: HeaderMap) -> Response {
    let accept = headers.get(ACCEPT).and_then(|accept| accept.to_str().ok()).unwrap_or_default();
    let format = Format::accepted(accept);
    ([(CONTENT_TYPE, format.content_type())], scrapes.source.text(format)).into_response()
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
