//! The HTTP server for the dashboard and the API, on threads of its own.
//!
//! A hostile client may send too much, send too slowly or never finish. It then costs one of a limited number of connections, which it
//! loses when another client needs it, and nothing else. Listening beyond loopback requires TLS and users.

mod heads;
mod http2;
mod slow_client;
mod tls;

use crate::auth::Access;
use crate::auth::connections::{Evicted, Permit, Permits, StreamPermits};
use crate::auth::openid::{OpenIdProvider, OpenIdSettings};
use crate::auth::rate_limit::RateLimits;
use crate::auth::users::{Users, UsersError};
use crate::authenticator::{AccessObserver, Authenticator};
use crate::headers::{self, Hosts};
use crate::middleware::{self, Peer, RequestGuard};
use axum::Router;
use axum::extract::Request;
use axum::http::HeaderValue;
use axum::http::header::CONNECTION;
use axum::middleware::{from_fn, from_fn_with_state};
use axum::response::IntoResponse;
use heads::{Heads, MAX_HEAD, Reuse};
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use slow_client::StallTimeout;
use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
pub use tls::{Keys, PemItem, TlsError, TlsFiles};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::oneshot;
use tokio::time::timeout;
use tokio_rustls::{TlsAcceptor, rustls};
use tower::ServiceExt;

/// The pause after the system has refused a connection, for example because no file descriptor is free.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// The interval between checks of the users' file.
const USERS_INTERVAL: Duration = Duration::from_millis(500);

/// The answer to plain HTTP where the server uses TLS.
const PLAIN_HTTP: &[u8] =
    b"HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain; charset=utf-8\r\nConnection: close\r\n\r\n\
    This port uses TLS: use an address that begins with https.\n";

/// The limits of a server. chosen: some dozen users with some pages each, and a page over a slow line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Connections at the same time: see [`crate::auth::connections`].
    pub connections: usize,
    /// The longest time for the head of a request, for its body, for a TLS handshake, without a request, and for octets after the last
    /// answer, which are dropped.
    pub head: Duration,
    /// A connection ends when its client does not read for this time.
    pub stalled: Duration,
    /// The limits on requests and logins.
    pub rate_limits: RateLimits,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 256,
            head: Duration::from_secs(15),
            stalled: Duration::from_secs(30),
            rate_limits: RateLimits::default(),
        }
    }
}

/// The settings of a server.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The address to listen on. With port 0 the system chooses a port.
    pub listen: SocketAddr,
    /// How requests get a user.
    pub access: Access,
    /// The OpenID provider at which users may log in besides.
    pub openid: Option<OpenIdSettings>,
    /// Host names and addresses of this computer, besides localhost.
    pub hosts: Vec<String>,
    /// Certificate and key, if the server uses TLS.
    pub tls: Option<TlsFiles>,
    /// The limits.
    pub limits: Limits,
}

impl Setup {
    /// Settings without TLS and without further host names.
    #[must_use]
    pub fn new(listen: SocketAddr, access: Access) -> Self {
        Self { listen, access, openid: None, hosts: Vec::new(), tls: None, limits: Limits::default() }
    }
}

/// The reason why a server cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServerError {
    /// Passwords would travel unencrypted.
    #[error("listening beyond loopback on {0} needs TLS: add [tls] with certificate and key to the station's file")]
    NoTls(SocketAddr),
    /// Every client would have access.
    #[error(
        "listening beyond loopback on {0} needs users: `profivac user add NAME --role engineer FILE.toml` adds the first"
    )]
    NoUsers(SocketAddr),
    /// Every client of a proxy would have access.
    #[error(
        "`hosts` makes {0} reachable through a proxy, which needs users: `profivac user add NAME --role engineer \
         FILE.toml` adds the first"
    )]
    Proxy(SocketAddr),
    /// A provider would not know where to send browsers back.
    #[error("listening beyond loopback on {0} needs url in [openid]: the address of the dashboard as browsers use it")]
    OpenIdUrl(SocketAddr),
    /// The users' file cannot be read.
    #[error(transparent)]
    Users(#[from] UsersError),
    /// Certificate or key cannot be used.
    #[error(transparent)]
    Tls(#[from] TlsError),
    /// The TLS library cannot reach an OpenID provider.
    #[error("no login by [openid]: {0}")]
    Client(#[from] rustls::Error),
    /// The address cannot be used.
    #[error("cannot listen on {address}: {error}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The error of the operating system.
        error: std::io::Error,
    },
}

/// A running server. Dropping it stops the server.
pub struct Server {
    address: SocketAddr,
    keys: Option<Arc<Keys>>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Starts a server that answers with `router` what the middleware lets through. `observer` gets what happens to the users.
    ///
    /// # Errors
    /// [`ServerError`].
    pub fn start(router: Router, observer: Arc<dyn AccessObserver>, setup: Setup) -> Result<Self, ServerError> {
        check_openid(&setup)?;
        let Setup { listen, access, openid, hosts, tls, limits } = setup;
        let keys = tls.map(Keys::read).transpose()?.map(Arc::new);
        let authenticator = Authenticator::new(observer, listen, access, limits.rate_limits)?;
        check_exposure(listen, &hosts, keys.is_some(), authenticator.has_users())?;
        let failed = |error| ServerError::Listen { address: listen, error };
        let runtime = runtime().map_err(failed)?;
        let listener = runtime.block_on(TcpListener::bind(listen)).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let provider = openid.map(|openid| OpenIdProvider::new(openid, url(address, keys.is_some()))).transpose()?;
        let authenticator = Arc::new(authenticator.with_provider(provider));
        authenticator.restore_sessions();
        let guard = RequestGuard {
            authenticator: Arc::clone(&authenticator),
            hosts: Hosts { loopback: listen.ip().is_loopback(), configured: hosts },
            tls: keys.is_some(),
            port: address.port(),
            body_timeout: limits.head,
            streams: StreamPermits::new(limits.connections),
        };
        let connections = Connections { router: guarded(router, guard), keys: keys.clone(), limits, observer: None };
        let (stop, stopped) = oneshot::channel();
        let thread = std::thread::spawn(move || run(runtime, &listener, &connections, &authenticator, stopped));
        Ok(Self { address, keys, stop: Some(stop), thread: Some(thread) })
    }

    /// Checks the settings and the files that they name, without listening.
    ///
    /// # Errors
    /// [`ServerError`].
    pub fn check(setup: &Setup) -> Result<(), ServerError> {
        check_openid(setup)?;
        let keys = setup.tls.clone().map(Keys::read).transpose()?;
        let has_users = match &setup.access {
            Access::Users(file) => !Users::read(file)?.is_empty(),
            Access::UsersWhenPresent(file) if file.exists() => !Users::read(file)?.is_empty(),
            Access::Anonymous(_) | Access::UsersWhenPresent(_) => false,
        };
        check_exposure(setup.listen, &setup.hosts, keys.is_some(), has_users)
    }

    /// The address of the server, with the port that the system has chosen.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// The address as a URL.
    #[must_use]
    pub fn url(&self) -> String {
        url(self.address, self.keys.is_some())
    }

    /// Reads certificate and key again.
    ///
    /// # Errors
    /// [`TlsError`]. The former certificate and key stay in use then.
    pub fn renew(&self) -> Result<(), TlsError> {
        self.keys.as_ref().map_or(Ok(()), |keys| keys.renew())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

fn url(address: SocketAddr, has_tls: bool) -> String {
    format!("{}://{address}", if has_tls { "https" } else { "http" })
}

/// Checks that a provider knows where the dashboard is.
fn check_openid(setup: &Setup) -> Result<(), ServerError> {
    let lacks_url = setup.openid.as_ref().is_some_and(|openid| openid.url.is_none());
    if lacks_url && !setup.listen.ip().is_loopback() { Err(ServerError::OpenIdUrl(setup.listen)) } else { Ok(()) }
}

/// Checks that other computers reach the server only with TLS and a login.
fn check_exposure(listen: SocketAddr, hosts: &[String], has_tls: bool, has_users: bool) -> Result<(), ServerError> {
    match (listen.ip().is_loopback(), has_tls, has_users) {
        (false, false, _) => Err(ServerError::NoTls(listen)),
        (false, true, false) => Err(ServerError::NoUsers(listen)),
        (true, _, false) if !hosts.is_empty() => Err(ServerError::Proxy(listen)),
        _ => Ok(()),
    }
}

/// Serves until the stop signal.
fn run(
    runtime: Runtime,
    listener: &TcpListener,
    connections: &Connections,
    authenticator: &Arc<Authenticator>,
    stopped: oneshot::Receiver<()>,
) {
    runtime.block_on(async {
        tokio::select! {
            () = connections.serve(listener) => {}
            () = watch_users(authenticator) => {}
            _ = stopped => {}
        }
    });
    authenticator.store_sessions_at_stop();
    // Live streams do not end on their own.
    runtime.shutdown_background();
}

/// Counts the connections of a server, for example those of a gateway.
pub trait ConnectionObserver: Send + Sync {
    /// A client has connected.
    fn connected(&self);

    /// A client has disconnected.
    fn disconnected(&self);

    /// A connection was refused, with a sentence why.
    fn refused(&self, reason: &str);
}

/// HTTP connections with their limits: of the dashboard, and of gateways over HTTP.
#[derive(Clone)]
pub struct Connections {
    /// What answers the requests.
    pub router: Router,
    /// Certificate and key, if the connections use TLS.
    pub keys: Option<Arc<Keys>>,
    /// The limits; those on the rate of requests are the router's.
    pub limits: Limits,
    /// Who counts the connections.
    pub observer: Option<Arc<dyn ConnectionObserver>>,
}

/// An API behind its middleware. The outermost layer adds the headers, so that refusals have them too.
pub fn guarded(router: Router, guard: RequestGuard) -> Router {
    let tls = guard.tls;
    let router =
        router.layer(from_fn_with_state(Arc::new(guard), middleware::authorise)).layer(from_fn(headers::headers));
    if tls { router.layer(from_fn(headers::tls_only)) } else { router }
}

fn runtime() -> std::io::Result<Runtime> {
    Builder::new_multi_thread().worker_threads(2).max_blocking_threads(64).enable_io().enable_time().build()
}

/// Reads the users' file again after each change, and stores the sessions. Never returns.
async fn watch_users(authenticator: &Arc<Authenticator>) {
    loop {
        tokio::time::sleep(USERS_INTERVAL).await;
        let authenticator = Arc::clone(authenticator);
        let work = move || {
            authenticator.reload_users();
            authenticator.store_sessions();
        };
        // After a panic the users stay as they were.
        tokio::task::spawn_blocking(work).await.ok();
    }
}

/// Counts a connection while it lives.
struct Counted(Option<Arc<dyn ConnectionObserver>>);

impl Counted {
    fn of(observer: Option<&Arc<dyn ConnectionObserver>>) -> Self {
        if let Some(observer) = observer {
            observer.connected();
        }
        Self(observer.map(Arc::clone))
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        if let Some(observer) = &self.0 {
            observer.disconnected();
        }
    }
}

impl Connections {
    /// Accepts connections. Never returns.
    pub async fn serve(&self, listener: &TcpListener) {
        let permits = Permits::new(self.limits.connections);
        loop {
            let Ok((stream, peer)) = listener.accept().await else {
                tokio::time::sleep(ACCEPT_PAUSE).await;
                continue;
            };
            match (permits.take(peer.ip()), &self.observer) {
                (Some((permit, evicted)), _) => {
                    drop(tokio::spawn(self.clone().accept(stream, peer.ip(), permit, evicted)))
                }
                (None, Some(observer)) => observer.refused("all places for connections are taken"),
                (None, None) => {}
            }
        }
    }

    /// Serves one connection until it ends, or until its permit is needed for another one.
    async fn accept(self, stream: TcpStream, peer: IpAddr, permit: Arc<Permit>, evicted: Evicted) {
        let _counted = Counted::of(self.observer.as_ref());
        tokio::select! {
            () = self.serve_one(stream, peer, permit) => {}
            _ = evicted => {}
        }
    }

    async fn serve_one(&self, mut stream: TcpStream, peer: IpAddr, permit: Arc<Permit>) {
        let Some(keys) = &self.keys else { return self.answer(stream, peer, permit).await };
        let acceptor = TlsAcceptor::from(keys.config());
        let handshake = async {
            if is_plain_http(&stream).await {
                answer_plain_http(&mut stream).await.ok();
                return None;
            }
            acceptor.accept(stream).await.ok()
        };
        let Ok(Some(stream)) = timeout(self.limits.head, handshake).await else { return };
        if stream.get_ref().1.alpn_protocol() == Some(http2::PROTOCOL) {
            let times = http2::Times { head: self.limits.head, stalled: self.limits.stalled };
            let stream = StallTimeout::new(stream, times.stalled);
            http2::serve(stream, &self.router, peer, &permit, times).await;
        } else {
            self.answer(stream, peer, permit).await;
        }
    }

    /// Serves HTTP/1.1.
    async fn answer(&self, stream: impl AsyncRead + AsyncWrite + Unpin, peer: IpAddr, permit: Arc<Permit>) {
        let mut stream = Heads::new(StallTimeout::new(stream, self.limits.stalled));
        let framing = stream.framing();
        let service = service_fn(|mut request: Request<Incoming>| {
            let begun = framing.begin(request.body());
            request.extensions_mut().insert(Peer(peer));
            request.extensions_mut().insert(Arc::clone(&permit));
            let router = self.router.clone();
            async move {
                let mut response = match begun {
                    Ok(_) => router.oneshot(request).await?,
                    Err(refusal) => refusal.into_response(),
                };
                if begun != Ok(Reuse::Possible) {
                    response.headers_mut().insert(CONNECTION, HeaderValue::from_static("close"));
                }
                Ok::<_, Infallible>(response)
            }
        });
        let mut protocol = http1::Builder::new();
        protocol.timer(TokioTimer::new()).header_read_timeout(self.limits.head).max_buf_size(MAX_HEAD);
        let served = protocol.serve_connection(TokioIo::new(&mut stream), service).await;
        // A client may disconnect at any time, which is no error.
        if served.is_ok() {
            timeout(self.limits.head, stream.drain()).await.ok();
        }
    }
}

/// Whether a connection begins like an HTTP request: with a letter. TLS begins with the octet 22, the type of a handshake record.
async fn is_plain_http(stream: &TcpStream) -> bool {
    let mut first = [0];
    matches!(stream.peek(&mut first).await, Ok(1) if first.iter().all(u8::is_ascii_uppercase))
}

/// Reads the request before the answer: closing a socket with unread data would discard the answer.
async fn answer_plain_http(stream: &mut TcpStream) -> std::io::Result<()> {
    let _read = stream.read(&mut [0; 4096]).await?;
    stream.write_all(PLAIN_HTTP).await?;
    stream.shutdown().await
}
