//! Security headers, the check of the requested host, and the answer to a panic.

use crate::host_name::{host, is_loopback};
use crate::problem::task_failed;
use axum::extract::Request;
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, HOST, STRICT_TRANSPORT_SECURITY};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderValue, Uri};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// The policy of the page: only resources of the station, no frames, no plug-ins, no other base. The chart library sets the size of
/// its elements by inline styles.
const PAGE_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
    connect-src 'self'; object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'";

/// The policy of API answers: a browser never renders them as a page.
const API_POLICY: &str = "default-src 'none'; object-src 'none'; base-uri 'none'; frame-ancestors 'none'; sandbox";

/// Browser features that the dashboard does not use.
const PERMISSIONS: &str = "camera=(), display-capture=(), geolocation=(), microphone=(), payment=(), usb=()";

/// HSTS for a year and a day.
const HSTS: &str = "max-age=31622400";

/// Headers of every answer.
const HEADERS: [(&str, &str); 6] = [
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("permissions-policy", PERMISSIONS),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
];

/// Adds the security headers. Answers of the API are not cached.
pub async fn headers(request: Request, next: Next) -> Response {
    let is_api = request.uri().path().starts_with("/api/");
    let mut response = next.run(request).await;
    add_to(response.headers_mut(), is_api);
    response
}

/// Adds the security headers to the headers of an answer.
pub fn add_to(headers: &mut HeaderMap, is_api: bool) {
    for (name, value) in HEADERS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(if is_api { API_POLICY } else { PAGE_POLICY }));
    if is_api {
        headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
}

/// Adds HSTS: a browser that has used TLS once never uses plain HTTP again.
pub async fn tls_only(request: Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    response.headers_mut().insert(STRICT_TRANSPORT_SECURITY, HeaderValue::from_static(HSTS));
    response
}

/// Answers 500 when a handler panics. Other requests are not affected.
pub async fn catch_panic(request: Request, next: Next) -> Response {
    let response = tokio::spawn(next.run(request)).await;
    response.unwrap_or_else(|error| task_failed(&error).into_response())
}

/// The host names of this computer. With DNS rebinding a foreign page makes a browser send requests to the station under a name of
/// its own and reads the answers. So requests for other names are refused.
#[derive(Clone, Debug)]
pub struct Hosts {
    /// Whether the station listens on loopback. Then the names of the loopback interface are accepted.
    pub loopback: bool,
    /// The names and addresses in the configuration file, without ports.
    pub configured: Vec<String>,
}

impl Hosts {
    /// Whether requests for this host are accepted. A public station without configured names accepts every name: TLS
    /// protects it, because the certificate of the station is not valid for foreign names.
    #[must_use]
    pub fn accept(&self, requested: &str) -> bool {
        (self.loopback && is_loopback(requested))
            || self.accept_configured(requested)
            || (!self.loopback && self.configured.is_empty())
    }

    /// Whether this host is a configured name.
    #[must_use]
    pub fn accept_configured(&self, requested: &str) -> bool {
        host(requested).is_some_and(|host| self.configured.iter().any(|name| name.eq_ignore_ascii_case(&host)))
    }
}

/// The host that a request is meant for: from its URI (`:authority` of HTTP/2), or else from its `Host` header. Empty if there are two headers,
/// or if URI and header differ (RFC 9113 8.3.1): a proxy in front of the station could decide by the other one.
#[must_use]
pub fn requested_host(headers: &HeaderMap, uri: &Uri) -> String {
    let mut all = headers.get_all(HOST).iter();
    let (first, second) = (all.next(), all.next());
    let authority = uri.authority().map(Authority::as_str);
    let is_same = |(host, authority): (&HeaderValue, &str)| host.as_bytes().eq_ignore_ascii_case(authority.as_bytes());
    let is_same = first.zip(authority).is_none_or(is_same);
    let host = first.and_then(|host| host.to_str().ok());
    let requested = authority.or(host).filter(|_| second.is_none() && is_same);
    requested.unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::Router;
    use axum::body::{Body, to_bytes};
    use axum::routing::get;
    use tower::ServiceExt;

    #[test]
    fn configured_names_are_accepted_and_others_refused() {
        let hosts = |loopback, configured: &[&str]| Hosts {
            loopback,
            configured: configured.iter().map(|name| (*name).to_owned()).collect(),
        };
        let behind_a_proxy = hosts(true, &["vacuum.example"]);
        for (name, accepted) in
            [("localhost", true), ("Vacuum.Example:443", true), ("evil.example", false), ("10.0.0.1", false)]
        {
            assert_eq!(behind_a_proxy.accept(name), accepted, "{name}");
        }
        let public = hosts(false, &["vacuum.example", "10.0.0.1"]);
        for (name, accepted) in
            [("localhost", false), ("vacuum.example.", true), ("10.0.0.1:8443", true), ("evil.example", false)]
        {
            assert_eq!(public.accept(name), accepted, "{name}");
        }
        assert!(hosts(false, &[]).accept("anything.example") && !hosts(true, &[]).accept("anything.example"));
    }

    #[test]
    fn the_authority_of_a_request_is_its_host_and_differs_from_no_header() {
        let requests: [(&str, &[&'static str], &str); 7] = [
            ("/", &["vacuum.example"], "vacuum.example"),
            ("https://vacuum.example:8443/", &[], "vacuum.example:8443"),
            ("https://vacuum.example/", &["Vacuum.example"], "vacuum.example"),
            ("https://vacuum.example/", &["evil.example"], ""),
            ("https://vacuum.example/", &["väcuum.example"], ""),
            ("https://vacuum.example/", &["vacuum.example", "evil.example"], ""),
            ("/", &[], ""),
        ];
        for (uri, hosts, expected) in requests {
            let mut headers = HeaderMap::new();
            for &host in hosts {
                headers.append(HOST, HeaderValue::from_bytes(host.as_bytes()).unwrap());
            }
            assert_eq!(requested_host(&headers, &uri.parse().unwrap()), expected, "{uri} {hosts:?}");
        }
    }

    #[test]
    fn a_panic_in_a_handler_is_answered_with_500() {
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
