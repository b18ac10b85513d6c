//! The dashboard and the API on a socket, in a thread of their own.
//!
//! Whoever is on the net may ask too much, too slowly, or never end: each costs one of a limited number of connections and
//! nothing else. Other computers reach it only over TLS, and only those who log in.

mod connection_limit;
mod slow_client;
mod tls;

use crate::api::headers::{self, Hosts};
use crate::api::middleware::{self, Peer, RequestGuard};
use crate::auth::Access;
use crate::auth::authenticator::Authenticator;
use crate::auth::rate_limit::RateLimits;
use crate::auth::users::{Users, UsersError};
use crate::config::TlsFiles;
use crate::services::Services;
use axum::Router;
use axum::extract::Request;
use axum::middleware::{from_fn, from_fn_with_state};
use connection_limit::ConnectionLimit;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use slow_client::StallTimeout;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
pub use tls::{Keys, PemItem, TlsError};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::oneshot;
use tokio::time::timeout;
use tokio_rustls::TlsAcceptor;
use tower::ServiceExt;

/// The longest head of a request, in octets.
const LONGEST_HEAD: usize = 32 << 10;

/// When the system has no room for a connection, the next is taken so much later.
const NO_ROOM: Duration = Duration::from_millis(100);

/// How often somebody looks whether the users' file has changed.
const LOOK: Duration = Duration::from_millis(500);

/// What somebody is told who does not speak TLS where it is spoken.
const PLAIN: &[u8] =
    b"HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain; charset=utf-8\r\nConnection: close\r\n\r\n\
    Here TLS is spoken: the address begins with https.\n";

/// What is granted to those who ask. free choice: some dozen people with some windows each, and a page over a slow line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// So many connections at once; further ones are closed.
    pub connections: usize,
    /// So long may the head of a request take, its body, and a handshake, and so long may a connection be silent.
    pub head: Duration,
    /// Whoever takes nothing of an answer for so long is left.
    pub stalled: Duration,
    /// How often what may be asked.
    pub paces: RateLimits,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 256,
            head: Duration::from_secs(15),
            stalled: Duration::from_secs(30),
            paces: RateLimits::default(),
        }
    }
}

/// Where to listen, and whom to let in.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The address; port 0 lets the system choose one.
    pub listen: SocketAddr,
    /// Who is let in.
    pub access: Access,
    /// Further names and addresses of this computer.
    pub hosts: Vec<String>,
    /// Where the certificate is, if TLS is spoken.
    pub tls: Option<TlsFiles>,
    /// What is granted.
    pub limits: Limits,
}

impl Setup {
    /// Without TLS and without further names.
    #[must_use]
    pub fn new(listen: SocketAddr, access: Access) -> Self {
        Self { listen, access, hosts: Vec::new(), tls: None, limits: Limits::default() }
    }
}

/// Why nobody is served.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// Passwords would be heard by everybody on the way.
    #[error(
        "{0} can be reached from other computers: that needs TLS, [tls] with certificate and key in the station's file"
    )]
    NoTls(SocketAddr),
    /// Everybody could come in.
    #[error(
        "{0} can be reached from other computers: that needs users, `profivac user add NAME --role engineer FILE.toml` \
         makes the first"
    )]
    NoUsers(SocketAddr),
    /// Everybody could come in, through a proxy.
    #[error(
        "`hosts` lets other computers reach {0} through a proxy: that needs users, `profivac user add NAME --role \
         engineer FILE.toml` makes the first"
    )]
    Proxy(SocketAddr),
    /// Those who may come in.
    #[error(transparent)]
    Users(#[from] UsersError),
    /// Certificate and key.
    #[error(transparent)]
    Tls(#[from] TlsError),
    /// The address cannot be listened at.
    #[error("{address} cannot be listened at: {error}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// What the system says.
        error: std::io::Error,
    },
}

/// A server that runs.
pub struct Server {
    address: SocketAddr,
    keys: Option<Arc<Keys>>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Listens. At an address that other computers reach only with TLS and somebody who can log in.
    ///
    /// # Errors
    /// [`ServerError`] says what is in the way.
    pub fn start(plant: Arc<Services>, setup: Setup) -> Result<Self, ServerError> {
        let Setup { listen, access, hosts, tls, limits } = setup;
        let keys = tls.map(Keys::read).transpose()?.map(Arc::new);
        let door = Arc::new(Authenticator::new(Arc::clone(&plant), access, limits.paces)?);
        check_exposure(listen, &hosts, keys.is_some(), door.has_users())?;
        let failed = |error| ServerError::Listen { address: listen, error };
        let runtime = runtime().map_err(failed)?;
        let listener = runtime.block_on(TcpListener::bind(listen)).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let gate = RequestGuard {
            authenticator: Arc::clone(&door),
            hosts: Hosts { loopback: listen.ip().is_loopback(), given: hosts },
            tls: keys.is_some(),
            port: address.port(),
            body_timeout: limits.head,
        };
        let served = Connections { router: router(plant, gate), keys: keys.clone(), limits };
        let (stop, stopped) = oneshot::channel();
        let thread = std::thread::spawn(move || run(runtime, &listener, &served, &door, stopped));
        Ok(Self { address, keys, stop: Some(stop), thread: Some(thread) })
    }

    /// Whether a server would begin, as far as its files can tell.
    ///
    /// # Errors
    /// [`ServerError`] says what is in the way.
    pub fn check(setup: &Setup) -> Result<(), ServerError> {
        let keys = setup.tls.clone().map(Keys::read).transpose()?;
        let users = match &setup.access {
            Access::Users(file) => !Users::read(file)?.is_empty(),
            Access::Anonymous(_) => false,
        };
        check_exposure(setup.listen, &setup.hosts, keys.is_some(), users)
    }

    /// Where it listens.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// The same for a browser.
    #[must_use]
    pub fn url(&self) -> String {
        format!("{}://{}", if self.keys.is_some() { "https" } else { "http" }, self.address)
    }

    /// Reads certificate and key again.
    ///
    /// # Errors
    /// [`TlsError`]; what was read before still holds then.
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

/// Nothing, unless others would reach us who should not, or whose passwords would be heard.
fn check_exposure(listen: SocketAddr, hosts: &[String], tls: bool, users: bool) -> Result<(), ServerError> {
    let loopback = listen.ip().is_loopback();
    match (loopback, tls, users) {
        (false, false, _) => Err(ServerError::NoTls(listen)),
        (false, true, false) => Err(ServerError::NoUsers(listen)),
        (true, _, false) if !hosts.is_empty() => Err(ServerError::Proxy(listen)),
        _ => Ok(()),
    }
}

/// Serves until it is told to stop.
fn run(
    runtime: Runtime,
    listener: &TcpListener,
    served: &Connections,
    door: &Arc<Authenticator>,
    stopped: oneshot::Receiver<()>,
) {
    runtime.block_on(async {
        tokio::select! {
            () = serve(listener, served) => {}
            () = watch_users(door) => {}
            _ = stopped => {}
        }
    });
    // Live streams never end by themselves.
    runtime.shutdown_background();
}

/// What every connection needs.
#[derive(Clone)]
struct Connections {
    router: Router,
    keys: Option<Arc<Keys>>,
    limits: Limits,
}

/// The API behind its gate; headers stand above refusals as well.
fn router(plant: Arc<Services>, gate: RequestGuard) -> Router {
    let tls = gate.tls;
    let router = crate::api::router(plant)
        .layer(from_fn_with_state(Arc::new(gate), middleware::authorise))
        .layer(from_fn(headers::headers));
    if tls { router.layer(from_fn(headers::tls_only)) } else { router }
}

fn runtime() -> std::io::Result<Runtime> {
    Builder::new_multi_thread().worker_threads(2).max_blocking_threads(64).enable_io().enable_time().build()
}

/// Sees when the users change, for ever.
async fn watch_users(door: &Arc<Authenticator>) {
    loop {
        tokio::time::sleep(LOOK).await;
        let door = Arc::clone(door);
        // It never panics; if it did, the users would stay as they were.
        tokio::task::spawn_blocking(move || door.reload_users()).await.ok();
    }
}

/// Takes connections, for ever.
async fn serve(listener: &TcpListener, served: &Connections) {
    let places = ConnectionLimit::new(served.limits.connections);
    loop {
        let Ok((stream, peer)) = listener.accept().await else {
            tokio::time::sleep(NO_ROOM).await;
            continue;
        };
        if let Some(place) = places.take(peer.ip()) {
            let served = served.clone();
            tokio::spawn(async move {
                served.accept(stream, peer.ip()).await;
                drop(place);
            });
        }
    }
}

impl Connections {
    /// Answers what comes over a connection, until it ends.
    async fn accept(self, mut stream: TcpStream, peer: IpAddr) {
        let Some(keys) = &self.keys else { return self.answer(stream, peer).await };
        let acceptor = TlsAcceptor::from(keys.config());
        let greeted = async {
            if speaks_plainly(&stream).await {
                refuse(&mut stream).await.ok();
                return None;
            }
            acceptor.accept(stream).await.ok()
        };
        if let Ok(Some(stream)) = timeout(self.limits.head, greeted).await {
            self.answer(stream, peer).await;
        }
    }

    async fn answer(&self, stream: impl AsyncRead + AsyncWrite + Unpin, peer: IpAddr) {
        let router = self.router.clone().map_request(move |mut request: Request<Incoming>| {
            request.extensions_mut().insert(Peer(peer));
            request
        });
        let mut protocol = http1::Builder::new();
        protocol.timer(TokioTimer::new()).header_read_timeout(self.limits.head).max_buf_size(LONGEST_HEAD);
        // Whoever asked may go at any time.
        let stream = StallTimeout::new(stream, self.limits.stalled);
        protocol.serve_connection(TokioIo::new(stream), TowerToHyperService::new(router)).await.ok();
    }
}

/// Whether this begins like a request; TLS begins with the number of its records, 22.
async fn speaks_plainly(stream: &TcpStream) -> bool {
    let mut first = [0];
    matches!(stream.peek(&mut first).await, Ok(1) if first.iter().all(u8::is_ascii_uppercase))
}

/// What was asked is taken before the answer: otherwise the system would throw the answer away.
async fn refuse(stream: &mut TcpStream) -> std::io::Result<()> {
    let _taken = stream.read(&mut [0; 4096]).await?;
    stream.write_all(PLAIN).await?;
    stream.shutdown().await
}
