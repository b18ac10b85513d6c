//! What every request passes before anybody answers it: how often, for whom, from which page, by whom, and how much.
//!
//! | Asked for | Needs |
//! |---|---|
//! | the dashboard's own files | nothing |
//! | `/api/session`, to be seen | a page of ours or none |
//! | `/api/login` | that, and a body of JSON, which no page from elsewhere can send without asking first |
//! | anything else below `/api/` | that, and a session |
//! | … with any other method than GET and HEAD | that, and the session's token in `x-csrf-token` |

use super::headers::{self, Hosts};
use super::problem::Problem;
use crate::auth::authenticator::{AuthError, Authenticator};
use crate::auth::secret::Secret;
use crate::auth::sessions::AuthenticatedUser;
use axum::body::{Body, to_bytes};
use axum::extract::{Request, State};
use axum::http::header::{CONTENT_TYPE, COOKIE, HeaderName, ORIGIN};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderValue, Method, Uri};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;

/// The largest body, in octets: the names of a thousand alarms.
const LARGEST_BODY: usize = 64 << 10;

/// Where the page proves that it is ours.
const TOKEN: HeaderName = HeaderName::from_static("x-csrf-token");

/// Where browsers say which page has made them ask.
const FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// Who is at the other end of the connection.
#[derive(Clone, Copy, Debug)]
pub struct Peer(pub IpAddr);

/// The gate of one server.
pub struct RequestGuard {
    /// Who comes in.
    pub authenticator: Arc<Authenticator>,
    /// What this computer is called.
    pub hosts: Hosts,
    /// Whether TLS is spoken.
    pub tls: bool,
    /// The port, which stands in the name of the cookie: browsers give a computer's cookies to all its ports.
    pub port: u16,
    /// So long may a body take.
    pub body_timeout: Duration,
}

/// A request that has been let in, for those who answer it.
#[derive(Clone)]
pub struct RequestContext {
    gate: Arc<RequestGuard>,
    session: Option<Secret>,
    known: Option<AuthenticatedUser>,
    peer: IpAddr,
    secure: bool,
}

impl RequestContext {
    /// The door it came through.
    #[must_use]
    pub fn authenticator(&self) -> &Authenticator {
        &self.gate.authenticator
    }

    /// By whom, if they have logged in.
    #[must_use]
    pub const fn user(&self) -> Option<&AuthenticatedUser> {
        self.known.as_ref()
    }

    /// In which session.
    #[must_use]
    pub const fn session(&self) -> Option<&Secret> {
        self.session.as_ref()
    }

    /// From where.
    #[must_use]
    pub const fn peer(&self) -> IpAddr {
        self.peer
    }

    /// Whether whoever came may still be here.
    #[must_use]
    pub fn is_still_authenticated(&self) -> bool {
        self.authenticator().authenticate(self.session()).is_some()
    }

    /// The cookie with this session, or without any.
    #[must_use]
    pub fn cookie(&self, session: Option<&Secret>) -> HeaderValue {
        let name = self.gate.cookie(self.secure);
        let secure = if self.secure { "; Secure" } else { "" };
        let (value, age) = session.map_or(("", "; Max-Age=0"), |session| (session.reveal(), ""));
        let text = format!("{name}={value}; Path=/; HttpOnly; SameSite=Strict{secure}{age}");
        HeaderValue::from_str(&text).unwrap_or(HeaderValue::from_static(""))
    }
}

/// Lets requests in, or says why not.
pub async fn authorise(State(gate): State<Arc<RequestGuard>>, request: Request, next: Next) -> Response {
    match gate.authorised(request).await {
        Ok(request) => next.run(request).await,
        Err(problem) => problem.into_response(),
    }
}

impl RequestGuard {
    async fn authorised(self: &Arc<Self>, request: Request) -> Result<Request, Problem> {
        let peer = request.extensions().get::<Peer>().map_or(IpAddr::from([0, 0, 0, 0]), |peer| peer.0);
        self.authenticator.rates().request(peer).map_err(Problem::too_often)?;
        let named = headers::named(request.headers(), request.uri());
        if !self.hosts.accept(&named) {
            return Err(Problem::host(&named));
        }
        if !request.uri().path().starts_with("/api/") {
            return Ok(request);
        }
        let visit = self.visit(&request, &named, peer);
        let checked = self.check_page(&request, &named).and_then(|()| check_right(&visit, &request));
        checked.inspect_err(|problem| self.record_refusal(&visit, &request, problem))?;
        if let Some(known) = visit.known.as_ref().filter(|_| !is_safe(request.method())) {
            self.authenticator.rates().write_request(&known.user.name).map_err(Problem::too_often)?;
        }
        let mut request = self.with_whole_body(request).await?;
        if let Some(known) = &visit.known {
            request.extensions_mut().insert(known.user.clone());
        }
        request.extensions_mut().insert(visit);
        Ok(request)
    }

    fn visit(self: &Arc<Self>, request: &Request, named: &str, peer: IpAddr) -> RequestContext {
        let secure = self.tls || !headers::is_loopback(named);
        let session = session(request.headers(), &self.cookie(secure));
        let known = self.authenticator.authenticate(session.as_ref());
        RequestContext { gate: Arc::clone(self), session, known, peer, secure }
    }

    /// Over TLS a name that browsers take from nobody else. A name that is not of this computer alone is one of a proxy, which
    /// speaks TLS.
    fn cookie(&self, secure: bool) -> String {
        format!("{}profivac-{}", if secure { "__Host-" } else { "" }, self.port)
    }

    /// Nothing, if the request comes from a page of ours, or from no page at all.
    fn check_page(&self, request: &Request, named: &str) -> Result<(), Problem> {
        let site = request.headers().get(FETCH_SITE).map(HeaderValue::as_bytes);
        let ours = match site {
            None | Some(b"same-origin") => true,
            // Typed by somebody.
            Some(b"none") => is_safe(request.method()),
            Some(_) => false,
        };
        let origin = request.headers().get(ORIGIN).map(|origin| self.is_our_origin(origin, named));
        if ours && origin.unwrap_or(true) {
            Ok(())
        } else {
            Err(Problem::forbidden("this comes from a page that is not ours"))
        }
    }

    fn is_our_origin(&self, origin: &HeaderValue, named: &str) -> bool {
        let uri = origin.to_str().ok().and_then(|text| text.parse::<Uri>().ok()).filter(|uri| uri.scheme().is_some());
        let authority = uri.as_ref().and_then(Uri::authority).map(Authority::as_str);
        // A proxy may call us by another name than those who ask it.
        authority
            .is_some_and(|authority| authority.eq_ignore_ascii_case(named) || self.hosts.accept_configured(authority))
    }

    /// The request with all of its body: who answers it waits for nobody.
    async fn with_whole_body(&self, mut request: Request) -> Result<Request, Problem> {
        if is_safe(request.method()) {
            *request.body_mut() = Body::empty();
            return Ok(request);
        }
        let is_json = is_json(request.headers());
        let (head, body) = request.into_parts();
        let read = tokio::time::timeout(self.body_timeout, to_bytes(body, LARGEST_BODY)).await;
        let body = read.map_err(|_| Problem::slow())?.map_err(|_| Problem::large(LARGEST_BODY))?;
        if !body.is_empty() && !is_json {
            return Err(Problem::kind());
        }
        Ok(Request::from_parts(head, Body::from(body)))
    }

    /// Whoever has not logged in is no event; whoever has and is refused is.
    fn record_refusal(&self, visit: &RequestContext, request: &Request, problem: &Problem) {
        if problem.is_unauthorised() {
            return;
        }
        let name = visit.known.as_ref().map_or("nobody", |known| &*known.user.name);
        let (peer, path) = (visit.peer, request.uri().path());
        let path: String = path.chars().take(64).collect();
        self.authenticator.record_refusal(&format!("refused for {name} at {peer}, {path:?}: {problem}"));
    }
}

/// Nothing, if whoever comes may ask this at all.
fn check_right(visit: &RequestContext, request: &Request) -> Result<(), Problem> {
    match request.uri().path() {
        "/api/login" => Ok(()),
        "/api/session" if is_safe(request.method()) => Ok(()),
        _ if visit.known.is_none() => Err(Problem::unauthorised("log in first")),
        _ if is_safe(request.method()) => Ok(()),
        _ => check_token(visit, request.headers()),
    }
}

fn check_token(visit: &RequestContext, headers: &HeaderMap) -> Result<(), Problem> {
    let told = headers.get(TOKEN).map(HeaderValue::as_bytes).unwrap_or_default();
    let proven = visit.known.as_ref().is_some_and(|known| known.token.matches(told));
    let why = "expected the header x-csrf-token with the token that /api/session gives";
    if proven { Ok(()) } else { Err(Problem::forbidden(why)) }
}

fn is_safe(method: &Method) -> bool {
    method == Method::GET || method == Method::HEAD
}

fn is_json(headers: &HeaderMap) -> bool {
    let kind = headers.get(CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
    kind.split(';').next().unwrap_or_default().trim().eq_ignore_ascii_case("application/json")
}

/// The session in the cookie of this name; nothing, if there are two.
fn session(headers: &HeaderMap, name: &str) -> Option<Secret> {
    let all = headers.get_all(COOKIE).iter().filter_map(|line| line.to_str().ok()).flat_map(|line| line.split(';'));
    let mut values = all.filter_map(|cookie| cookie.trim().split_once('=')).filter(|(other, _)| *other == name);
    match (values.next(), values.next()) {
        (Some((_, value)), None) => Secret::parse(value),
        _ => None,
    }
}

impl From<AuthError> for Problem {
    fn from(refusal: AuthError) -> Self {
        let sentence = refusal.to_string();
        match refusal {
            AuthError::NoUsers => Self::unknown(sentence),
            AuthError::Wrong => Self::unauthorised(sentence),
            AuthError::NotYours => Self::forbidden(sentence),
            AuthError::TooOften(wait) => Self::too_often(wait),
            AuthError::Unfit(_) => Self::bad(sentence),
            AuthError::Busy | AuthError::System(_) => Self::unavailable(sentence),
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
    fn a_session_stands_in_one_cookie_of_its_name() {
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
    fn json_is_json() {
        for (kind, is) in [
            ("application/json", true),
            ("Application/JSON; charset=utf-8", true),
            ("text/plain", false),
            ("text/plain; application/json", false),
            ("application/x-www-form-urlencoded", false),
            ("application/jsonp", false),
            ("", false),
        ] {
            let headers = HeaderMap::from_iter([(CONTENT_TYPE, HeaderValue::from_static(kind))]);
            assert_eq!(is_json(&headers), is, "{kind}");
        }
    }
}
