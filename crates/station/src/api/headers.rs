//! What stands between every request and its answer.

use super::database::task_failed;
use axum::extract::Request;
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, HOST, STRICT_TRANSPORT_SECURITY};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderValue, Uri};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::IpAddr;

/// Nothing from elsewhere, nothing in frames of others, no plug-ins, no other base. Curves set their size by a style, so styles
/// may stand in the page.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
    connect-src 'self'; object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'";

/// What is no page is never drawn as one.
const BARE: &str = "default-src 'none'; object-src 'none'; base-uri 'none'; frame-ancestors 'none'; sandbox";

/// Whatever a page of ours does not need.
const PERMISSIONS: &str = "camera=(), display-capture=(), geolocation=(), microphone=(), payment=(), usb=()";

/// A year and a day.
const TLS_ONLY: &str = "max-age=31622400";

/// What stands above every answer.
const HEADERS: [(&str, &str); 6] = [
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("permissions-policy", PERMISSIONS),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
];

/// Adds the headers; what is live is not kept.
pub async fn headers(request: Request, next: Next) -> Response {
    let is_live = request.uri().path().starts_with("/api/");
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(if is_live { BARE } else { POLICY }));
    if is_live {
        headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
    response
}

/// Who has come over TLS once comes over nothing else.
pub async fn tls_only(request: Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    response.headers_mut().insert(STRICT_TRANSPORT_SECURITY, HeaderValue::from_static(TLS_ONLY));
    response
}

/// A defect in an answer is told, and is the end of that answer alone.
pub async fn catch_panic(request: Request, next: Next) -> Response {
    let answered = tokio::spawn(next.run(request)).await;
    answered.unwrap_or_else(|error| task_failed(&error).into_response())
}

/// What this computer is called. A page from elsewhere can make a browser ask us under a name of its own (DNS rebinding), and
/// would then read the answer: who means somebody else is not answered.
#[derive(Clone, Debug)]
pub struct Hosts {
    /// Whether only this computer reaches us: then it may be called so.
    pub loopback: bool,
    /// Names and addresses that the station's file gives, without ports.
    pub given: Vec<String>,
}

impl Hosts {
    /// Whether we are meant. Where others reach us and no names are given, everybody who knows our certificate's is right.
    #[must_use]
    pub fn accept(&self, named: &str) -> bool {
        (self.loopback && is_loopback(named))
            || self.accept_configured(named)
            || (!self.loopback && self.given.is_empty())
    }

    /// Whether this is one of the names that are given.
    #[must_use]
    pub fn accept_configured(&self, named: &str) -> bool {
        host(named).is_some_and(|host| self.given.iter().any(|given| given.eq_ignore_ascii_case(&host)))
    }
}

/// Who is meant: the name in the address, or else the header; nobody, if there are two headers.
#[must_use]
pub fn named(headers: &HeaderMap, uri: &Uri) -> String {
    let mut all = headers.get_all(HOST).iter();
    let (first, second) = (all.next().and_then(|host| host.to_str().ok()), all.next());
    let named = uri.authority().map(Authority::as_str).or(first).filter(|_| second.is_none());
    named.unwrap_or_default().to_owned()
}

/// The host without its port, without the dot at the end of a whole name, without the brackets of an address.
#[must_use]
pub fn host(named: &str) -> Option<String> {
    // A name before an at sign is no host, and nobody sends one.
    let authority = named.parse::<Authority>().ok().filter(|_| !named.contains('@'))?;
    Some(authority.host().trim_end_matches('.').trim_start_matches('[').trim_end_matches(']').to_owned())
}

/// Whether this names the computer itself.
#[must_use]
pub fn is_loopback(named: &str) -> bool {
    let address = |host: &str| host.parse::<IpAddr>().is_ok_and(|address| address.is_loopback());
    host(named).is_some_and(|host| host.eq_ignore_ascii_case("localhost") || address(&host))
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
            assert!(is_loopback(name), "{name}");
        }
        for name in [
            "",
            "evil.example",
            "evil@localhost",
            "localhost.evil.example:8080",
            "10.0.0.1",
            "[fe80::1]",
            "127.0.0.1.evil.example",
        ] {
            assert!(!is_loopback(name), "{name}");
        }
    }

    #[test]
    fn names_that_are_given_are_ours_and_others_are_not() {
        let hosts =
            |loopback, given: &[&str]| Hosts { loopback, given: given.iter().map(|name| (*name).to_owned()).collect() };
        let behind_a_proxy = hosts(true, &["vacuum.example"]);
        for (name, ours) in
            [("localhost", true), ("Vacuum.Example:443", true), ("evil.example", false), ("10.0.0.1", false)]
        {
            assert_eq!(behind_a_proxy.accept(name), ours, "{name}");
        }
        let public = hosts(false, &["vacuum.example", "10.0.0.1"]);
        for (name, ours) in
            [("localhost", false), ("vacuum.example.", true), ("10.0.0.1:8443", true), ("evil.example", false)]
        {
            assert_eq!(public.accept(name), ours, "{name}");
        }
        assert!(hosts(false, &[]).accept("anything.example") && !hosts(true, &[]).accept("anything.example"));
    }

    #[test]
    fn a_defect_is_an_answer() {
        async fn defect() {
            panic!("on purpose");
        }
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        let (status, text) = runtime.block_on(async {
            let router = Router::new().route("/", get(defect)).layer(axum::middleware::from_fn(catch_panic));
            let response = router.oneshot(Request::get("/").body(Body::empty()).unwrap()).await.unwrap();
            let status = response.status().as_u16();
            (status, String::from_utf8(to_bytes(response.into_body(), 1000).await.unwrap().to_vec()).unwrap())
        });
        assert_eq!((status, text.contains("a defect of the program")), (500, true), "{text}");
    }
}
