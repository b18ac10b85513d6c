//! What stands between every request and its answer.

use super::archive::stopped;
use super::problem::Problem;
use axum::extract::Request;
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, HOST, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderValue, Uri};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::IpAddr;

/// Nothing from elsewhere, nothing in frames of others.
const POLICY: &str =
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; frame-ancestors 'none'";

/// Adds the headers; what is live is not kept.
pub async fn headers(request: Request, next: Next) -> Response {
    let is_live = request.uri().path().starts_with("/api/");
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    headers.insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(X_FRAME_OPTIONS, HeaderValue::from_static("DENY"));
    headers.insert(REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY));
    if is_live {
        headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
    response
}

/// A defect in an answer is told, and is the end of that answer alone.
pub async fn caught(request: Request, next: Next) -> Response {
    let answered = tokio::spawn(next.run(request)).await;
    answered.unwrap_or_else(|error| stopped(&error).into_response())
}

/// Only who means this computer is answered. A page from elsewhere can make a browser on this computer ask us under a name
/// of its own (DNS rebinding), and would then read the answer.
pub async fn ourselves(request: Request, next: Next) -> Response {
    let named = named(request.headers(), request.uri());
    if is_ourselves(&named) { next.run(request).await } else { Problem::host(&named).into_response() }
}

/// Who is meant: the name in the address, or else the header.
fn named(headers: &HeaderMap, uri: &Uri) -> String {
    let header = headers.get(HOST).and_then(|host| host.to_str().ok());
    uri.authority().map(Authority::as_str).or(header).unwrap_or_default().to_owned()
}

fn is_ourselves(named: &str) -> bool {
    let Ok(authority) = named.parse::<Authority>() else { return false };
    let host = authority.host().trim_end_matches('.');
    let address = host.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
    host.eq_ignore_ascii_case("localhost") || address.is_ok_and(|address| address.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::Router;
    use axum::body::{Body, to_bytes};
    use axum::routing::get;
    use tower::ServiceExt;

    #[test]
    fn only_this_computer_is_ourselves() {
        for name in ["localhost", "LOCALHOST:8080", "127.0.0.1:8080", "127.1.2.3", "[::1]:8080", "[::1]", "localhost."]
        {
            assert!(is_ourselves(name), "{name}");
        }
        for name in
            ["", "evil.example", "localhost.evil.example:8080", "10.0.0.1", "[fe80::1]", "127.0.0.1.evil.example"]
        {
            assert!(!is_ourselves(name), "{name}");
        }
    }

    #[test]
    fn a_defect_is_an_answer() {
        async fn defect() {
            panic!("on purpose");
        }
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        let (status, text) = runtime.block_on(async {
            let router = Router::new().route("/", get(defect)).layer(axum::middleware::from_fn(caught));
            let response = router.oneshot(Request::get("/").body(Body::empty()).unwrap()).await.unwrap();
            let status = response.status().as_u16();
            (status, String::from_utf8(to_bytes(response.into_body(), 1000).await.unwrap().to_vec()).unwrap())
        });
        assert_eq!((status, text.contains("a defect of the program")), (500, true), "{text}");
    }
}
