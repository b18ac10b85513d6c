//! The middleware before every handler: rate limit, host, origin, session, token and body of a request.
//!
//! | Request | Needs |
//! |---|---|
//! | a file of the dashboard | nothing |
//! | `GET /api/session` | an `Origin` of the station, or none |
//! | `/api/login`, `/api/openid/begin`, `/api/openid/login` | the same, and a JSON body, which a foreign page cannot send without a preflight |
//! | any other path below `/api/` | the same, and a session |
//! | … with another method than GET and HEAD | the same, and the token of the session in `x-csrf-token` |

use crate::auth::Actor;
use crate::auth::User;
use crate::auth::connections::{Permit, StreamClient, StreamPermit, StreamPermits};
use crate::auth::openid::{OpenIdError, pending};
use crate::auth::secret::RandomSecret;
use crate::auth::sessions::AuthenticatedUser;
use crate::authenticator::{AuthError, Authenticator};
use crate::headers::{self, Hosts};
use crate::host_name::is_loopback;
use crate::problem::Problem;
use axum::body::{Body, to_bytes};
use axum::extract::{FromRequestParts, Request, State};
use axum::http::header::{CONTENT_TYPE, COOKIE, HeaderName, ORIGIN};
use axum::http::request::Parts;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderValue, Method, Uri};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::convert::Infallible;
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio_stream::StreamExt;

/// The largest body, in octets: enough for the names of a thousand alarms.
const MAX_BODY: usize = 64 << 10;

/// The largest body of a request without a session, in octets. chosen: some times the codes that OpenID providers send.
const MAX_BODY_BEFORE_LOGIN: usize = 16 << 10;

/// How long an answer waits until the end of its session is stored. chosen: a disk that hangs delays no logout for longer.
const STORE_TIMEOUT: Duration = Duration::from_secs(5);

/// The path of the live stream.
const LIVE_STREAM: &str = "/api/live";

/// The header with the token of the session.
const TOKEN: HeaderName = HeaderName::from_static("x-csrf-token");

/// The header in which a browser says which page caused the request.
const FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// The address at the other end of the connection.
#[derive(Clone, Copy, Debug)]
pub struct Peer(pub IpAddr);

/// The guard of one server.
pub struct RequestGuard {
    /// The authentication of the station.
    pub authenticator: Arc<Authenticator>,
    /// The host names of this computer.
    pub hosts: Hosts,
    /// Whether the server uses TLS.
    pub tls: bool,
    /// The port of the server. It is part of the cookie's name, because browsers share cookies between all ports of a computer.
    pub port: u16,
    /// The longest time for a body to arrive.
    pub body_timeout: Duration,
    /// The permits for live streams.
    pub streams: StreamPermits,
}

/// An authorised request, for its handler.
#[derive(Clone)]
pub struct RequestContext {
    guard: Arc<RequestGuard>,
    session: Option<RandomSecret>,
    /// The cookie of a login at the OpenID provider.
    openid_browser: Option<RandomSecret>,
    authenticated: Option<AuthenticatedUser>,
    peer: IpAddr,
    is_secure: bool,
}

impl RequestContext {
    /// The authentication of the station.
    #[must_use]
    pub fn authenticator(&self) -> &Authenticator {
        &self.guard.authenticator
    }

    /// The user and the token of the session; `None` before login.
    #[must_use]
    pub const fn authenticated(&self) -> Option<&AuthenticatedUser> {
        self.authenticated.as_ref()
    }

    /// The identifier of the session, as the cookie names it.
    #[must_use]
    pub const fn session(&self) -> Option<&RandomSecret> {
        self.session.as_ref()
    }

    /// What binds a login at the OpenID provider to this browser.
    #[must_use]
    pub const fn openid_browser(&self) -> Option<&RandomSecret> {
        self.openid_browser.as_ref()
    }

    /// The address of the client.
    #[must_use]
    pub const fn peer(&self) -> IpAddr {
        self.peer
    }

    /// Whether the session has not ended since the request.
    #[must_use]
    pub fn is_still_authenticated(&self) -> bool {
        self.authenticator().authenticate(self.session()).is_some()
    }

    /// Stores the sessions, so that one that has ended does not continue after a restart.
    pub async fn store_sessions(&self) {
        let authenticator = Arc::clone(&self.guard.authenticator);
        let stored = tokio::task::spawn_blocking(move || authenticator.store_sessions());
        tokio::time::timeout(STORE_TIMEOUT, stored).await.ok();
    }

    /// The cookie that sets this session for `lifetime` (`None`: until the browser is closed), or that deletes the session of the browser.
    #[must_use]
    pub fn cookie(&self, session: Option<&RandomSecret>, lifetime: Option<Duration>) -> HeaderValue {
        self.cookie_of(&self.guard.cookie_name(self.is_secure), session, lifetime)
    }

    /// The cookie that binds a login at the OpenID provider to the browser while it is pending, or that deletes it.
    #[must_use]
    pub fn openid_cookie(&self, browser: Option<&RandomSecret>) -> HeaderValue {
        self.cookie_of(&self.guard.openid_cookie_name(self.is_secure), browser, Some(pending::LIFETIME))
    }

    fn cookie_of(&self, name: &str, value: Option<&RandomSecret>, lifetime: Option<Duration>) -> HeaderValue {
        let secure = if self.is_secure { "; Secure" } else { "" };
        let age = |age: Duration| format!("; Max-Age={}", age.as_secs());
        let (value, age) = match value {
            Some(value) => (value.reveal(), lifetime.map(age).unwrap_or_default()),
            None => ("", age(Duration::ZERO)),
        };
        let text = format!("{name}={value}; Path=/; HttpOnly; SameSite=Strict{secure}{age}");
        HeaderValue::from_str(&text).unwrap_or(HeaderValue::from_static(""))
    }
}

/// Passes an authorised request on, and answers any other with a problem document.
pub async fn authorise(State(guard): State<Arc<RequestGuard>>, request: Request, next: Next) -> Response {
    let authorised = guard.authorised(request).await.and_then(|request| Ok((guard.stream_permit(&request)?, request)));
    match authorised {
        Ok((None, request)) => next.run(request).await,
        Ok((Some(permit), request)) => next.run(request).await.map(|body| with_permit(body, permit)),
        Err(problem) => problem.into_response(),
    }
}

/// A body that has the permit of its live stream until it ends.
fn with_permit(body: Body, permit: StreamPermit) -> Body {
    Body::from_stream(body.into_data_stream().map(move |chunk| {
        let _permit = &permit;
        chunk
    }))
}

impl RequestGuard {
    async fn authorised(self: &Arc<Self>, request: Request) -> Result<Request, Problem> {
        let peer = request.extensions().get::<Peer>().map_or(IpAddr::from([0, 0, 0, 0]), |peer| peer.0);
        let limiters = self.authenticator.limiters();
        limiters.request(peer).map_err(Problem::too_many_requests)?;
        let host = headers::requested_host(request.headers(), request.uri());
        if !self.hosts.accept(&host) {
            return Err(Problem::wrong_host(&host));
        }
        if !request.uri().path().starts_with("/api/") {
            return Ok(request);
        }
        let context = self.context(&request, &host, peer);
        let checked = self.check_page(&request, &host).and_then(|()| check_session(&context, &request));
        checked.inspect_err(|problem| self.record_refusal(&context, &request, problem))?;
        if let (Some(permit), Some(known)) = (request.extensions().get::<Arc<Permit>>(), &context.authenticated) {
            permit.hold(&known.user.name);
        }
        if let Some(authenticated) = context.authenticated.as_ref().filter(|_| !is_safe(request.method())) {
            limiters.write_request(&authenticated.user.name).map_err(Problem::too_many_requests)?;
        }
        let mut request = self.with_whole_body(request, context.authenticated.is_some()).await?;
        if let Some(authenticated) = &context.authenticated {
            request.extensions_mut().insert(authenticated.user.clone());
        }
        request.extensions_mut().insert(context);
        Ok(request)
    }

    /// The permit of a live stream; `None` for any other request.
    fn stream_permit(&self, request: &Request) -> Result<Option<StreamPermit>, Problem> {
        let context = request.extensions().get::<RequestContext>();
        let Some(context) = context.filter(|_| request.uri().path() == LIVE_STREAM) else { return Ok(None) };
        let user =
            context.authenticated.as_ref().map_or_else(|| User::anonymous().name, |known| known.user.name.clone());
        let session = context.session.clone().filter(|_| self.authenticator.requires_login());
        let client = StreamClient { peer: context.peer, user, session };
        self.streams.take(client).map(Some).map_err(|limit| Problem::too_many_streams(&limit))
    }

    fn context(self: &Arc<Self>, request: &Request, host: &str, peer: IpAddr) -> RequestContext {
        // A name that is not local is that of a proxy, and the proxy uses TLS.
        let is_secure = self.tls || !is_loopback(host);
        let session = session(request.headers(), &self.cookie_name(is_secure));
        let openid_browser = self::session(request.headers(), &self.openid_cookie_name(is_secure));
        let authenticated = self.authenticator.authenticate(session.as_ref());
        RequestContext { guard: Arc::clone(self), session, openid_browser, authenticated, peer, is_secure }
    }

    /// The name of the cookie. Browsers accept the prefix `__Host-` only from this host over TLS.
    fn cookie_name(&self, is_secure: bool) -> String {
        format!("{}profivac-{}", if is_secure { "__Host-" } else { "" }, self.port)
    }

    /// The name of the cookie of a login at the OpenID provider.
    fn openid_cookie_name(&self, is_secure: bool) -> String {
        format!("{}-openid", self.cookie_name(is_secure))
    }

    /// Checks that a page of the station, or no page, caused the request.
    fn check_page(&self, request: &Request, host: &str) -> Result<(), Problem> {
        let site = request.headers().get(FETCH_SITE).map(HeaderValue::as_bytes);
        let is_own_site = match site {
            None | Some(b"same-origin") => true,
            // The user typed the address.
            Some(b"none") => is_safe(request.method()),
            Some(_) => false,
        };
        let is_own_origin = request.headers().get(ORIGIN).is_none_or(|origin| self.is_own_origin(origin, host));
        if is_own_site && is_own_origin {
            Ok(())
        } else {
            Err(Problem::forbidden("the request comes from a foreign page"))
        }
    }

    fn is_own_origin(&self, origin: &HeaderValue, host: &str) -> bool {
        let uri = origin.to_str().ok().and_then(|text| text.parse::<Uri>().ok()).filter(|uri| uri.scheme().is_some());
        let authority = uri.as_ref().and_then(Uri::authority).map(Authority::as_str);
        // A proxy may send another host than its clients.
        authority.is_some_and(|origin| origin.eq_ignore_ascii_case(host) || self.hosts.accept_configured(origin))
    }

    /// The request with its whole body in memory, so that no handler waits for a slow client. GET and HEAD have no body. Without a session
    /// (`is_known` is false) bodies are smaller, and a connection has few at the same time.
    async fn with_whole_body(&self, mut request: Request, is_known: bool) -> Result<Request, Problem> {
        if is_safe(request.method()) {
            *request.body_mut() = Body::empty();
            return Ok(request);
        }
        let is_json = is_json(request.headers());
        let permit = request.extensions().get::<Arc<Permit>>().filter(|_| !is_known);
        let too_many = || Problem::too_many_requests(Duration::ZERO);
        let _place = permit.map(|permit| permit.body_before_login().ok_or_else(too_many)).transpose()?;
        let max = if is_known { MAX_BODY } else { MAX_BODY_BEFORE_LOGIN };
        let (head, body) = request.into_parts();
        let read = tokio::time::timeout(self.body_timeout, to_bytes(body, max)).await;
        let body = read.map_err(|_| Problem::body_timeout())?.map_err(|_| Problem::body_too_large(max))?;
        if !body.is_empty() && !is_json {
            return Err(Problem::not_json());
        }
        Ok(Request::from_parts(head, Body::from(body)))
    }

    /// Records a refusal in the event log. A request without a session is no event.
    fn record_refusal(&self, context: &RequestContext, request: &Request, problem: &Problem) {
        if problem.is_unauthorised() {
            return;
        }
        let name = context.authenticated.as_ref().map_or("an unknown user", |authenticated| &*authenticated.user.name);
        let (peer, path) = (context.peer, request.uri().path());
        let path: String = path.chars().take(64).collect();
        self.authenticator.record_refusal(&format!("refused for {name} at {peer}, {path:?}: {problem}"));
    }
}

/// Checks that the request has the session and the token that it needs.
fn check_session(context: &RequestContext, request: &Request) -> Result<(), Problem> {
    match request.uri().path() {
        "/api/login" | "/api/openid/begin" | "/api/openid/login" => Ok(()),
        "/api/session" if is_safe(request.method()) => Ok(()),
        _ if context.authenticated.is_none() => Err(Problem::unauthorised("log in first")),
        _ if is_safe(request.method()) => Ok(()),
        _ => check_token(context, request.headers()),
    }
}

fn check_token(context: &RequestContext, headers: &HeaderMap) -> Result<(), Problem> {
    let given = headers.get(TOKEN).map(HeaderValue::as_bytes).unwrap_or_default();
    let is_right = context.authenticated.as_ref().is_some_and(|authenticated| authenticated.token.matches(given));
    let problem = "expected the header x-csrf-token with the token that /api/session gives";
    if is_right { Ok(()) } else { Err(Problem::forbidden(problem)) }
}

fn is_safe(method: &Method) -> bool {
    method == Method::GET || method == Method::HEAD
}

fn is_json(headers: &HeaderMap) -> bool {
    let content_type = headers.get(CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    content_type.split(';').next().unwrap_or_default().trim().eq_ignore_ascii_case("application/json")
}

/// The session in the cookie of this name; `None` if there are two such cookies.
fn session(headers: &HeaderMap, name: &str) -> Option<RandomSecret> {
    let all = headers.get_all(COOKIE).iter().filter_map(|line| line.to_str().ok()).flat_map(|line| line.split(';'));
    let mut values = all.filter_map(|cookie| cookie.trim().split_once('=')).filter(|(other, _)| *other == name);
    match (values.next(), values.next()) {
        (Some((_, value)), None) => RandomSecret::parse(value),
        _ => None,
    }
}

/// The user of the session; an anonymous viewer if there is none.
impl<S: Send + Sync> FromRequestParts<S> for User {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        Ok(parts.extensions.get::<Self>().cloned().unwrap_or_else(Self::anonymous))
    }
}

/// The user of the session and the address of the client.
impl<S: Send + Sync> FromRequestParts<S> for Actor {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Infallible> {
        let user = User::from_request_parts(parts, state).await?;
        let peer = parts.extensions.get::<Peer>().map(|Peer(peer)| *peer);
        Ok(Self { user, peer })
    }
}

impl From<AuthError> for Problem {
    fn from(error: AuthError) -> Self {
        let detail = error.to_string();
        match error {
            AuthError::NoUsers | AuthError::NoProvider => Self::not_found(detail),
            AuthError::WrongCredentials => Self::unauthorised(detail),
            AuthError::OpenId(OpenIdError::Provider { .. } | OpenIdError::Busy) => Self::unavailable(detail),
            AuthError::WrongPassword | AuthError::ForeignPassword | AuthError::OpenId(_) => Self::forbidden(detail),
            AuthError::TooOften(wait) => Self::too_many_requests(wait),
            AuthError::NewPassword(_) => Self::bad_request(detail),
            AuthError::Defect => Self::defect(),
            AuthError::Busy | AuthError::Users(_) | AuthError::Random(_) => Self::unavailable(detail),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(lines: &[&str]) -> HeaderMap {
        let mut headers = HeaderMap::new();
        for line in lines {
            headers.append(COOKIE, HeaderValue::from_str(line).unwrap());
        }
        headers
    }

    #[test]
    fn a_session_is_taken_from_exactly_one_cookie_of_its_name() {
        let id = "ab".repeat(32);
        let cookie = format!("profivac-80={id}");
        let found = |lines: &[&str]| session(&headers(lines), "profivac-80").is_some();
        assert!(found(&[&cookie]) && found(&["a=b", &format!("c=d;{cookie} ; e=f")]));
        for lines in [
            vec![cookie.as_str(), cookie.as_str()],
            vec!["profivac-80=abc"],
            vec!["profivac-80"],
            vec!["profivac-81=abc"],
            vec![],
        ] {
            assert!(!found(&lines), "{lines:?}");
        }
        assert!(!found(&[&format!("{cookie}; {cookie}")]));
        assert!(!found(&[&format!("__Host-{cookie}")]));
    }

    #[test]
    fn only_application_json_is_json() {
        for (content_type, expected) in [
            ("application/json", true),
            ("Application/JSON; charset=utf-8", true),
            ("text/plain", false),
            ("text/plain; application/json", false),
            ("application/x-www-form-urlencoded", false),
            ("application/jsonp", false),
            ("", false),
        ] {
            let headers = HeaderMap::from_iter([(CONTENT_TYPE, HeaderValue::from_static(content_type))]);
            assert_eq!(is_json(&headers), expected, "{content_type}");
        }
    }
}
