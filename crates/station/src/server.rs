//! The dashboard and the API on a socket, in a thread of their own.
//!
//! Whoever is on the net may ask too much, too slowly, or never end: each costs one of a limited number of connections and
//! nothing else.

use crate::api::{self, guard};
use crate::plant::Plant;
use axum::extract::ConnectInfo;
use axum::middleware::from_fn;
use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::{Semaphore, oneshot};

/// The longest head of a request, in octets. How long a body may be is said where one is read.
const LONGEST_HEAD: usize = 32 << 10;

/// When the system has no room for a connection, the next is taken so much later.
const NO_ROOM: Duration = Duration::from_millis(100);

/// What is granted to those who ask. free choice: some dozen people with some windows each, and a page over a slow line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// So many connections at once; further ones are closed.
    pub connections: usize,
    /// So long may the head of a request take, and a connection be silent.
    pub head: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self { connections: 256, head: Duration::from_secs(15) }
    }
}

/// Why nobody is served.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// Everybody could see the station, and nobody has said that this is wanted.
    #[error("{0} can be reached from other computers: say --public if everybody there may see the station")]
    Public(SocketAddr),
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
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Listens at `address`; port 0 lets the system choose one. Only with `public` may it be one that other computers reach.
    ///
    /// # Errors
    /// [`ServerError`] says what is in the way.
    pub fn start(plant: Arc<Plant>, address: SocketAddr, public: bool) -> Result<Self, ServerError> {
        Self::within(Limits::default(), plant, address, public)
    }

    /// The same with other limits.
    ///
    /// # Errors
    /// [`ServerError`] says what is in the way.
    pub fn within(limits: Limits, plant: Arc<Plant>, address: SocketAddr, public: bool) -> Result<Self, ServerError> {
        Self::of(limits, api::router(plant), address, public)
    }

    /// The same for a router that somebody has put something before.
    ///
    /// # Errors
    /// [`ServerError`] says what is in the way.
    pub fn of(limits: Limits, router: Router, address: SocketAddr, public: bool) -> Result<Self, ServerError> {
        if !address.ip().is_loopback() && !public {
            return Err(ServerError::Public(address));
        }
        let failed = |error| ServerError::Listen { address, error };
        let runtime = runtime().map_err(failed)?;
        let listener = runtime.block_on(TcpListener::bind(address)).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let router = if address.ip().is_loopback() { router.layer(from_fn(guard::ourselves)) } else { router };
        let (stop, stopped) = oneshot::channel::<()>();
        let thread = std::thread::spawn(move || {
            runtime.block_on(async {
                tokio::select! {
                    () = serve(&listener, &router, limits) => {}
                    _ = stopped => {}
                }
            });
            // Live streams never end by themselves.
            runtime.shutdown_background();
        });
        Ok(Self { address, stop: Some(stop), thread: Some(thread) })
    }

    /// Where it listens.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
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

fn runtime() -> std::io::Result<Runtime> {
    Builder::new_multi_thread().worker_threads(2).max_blocking_threads(64).enable_io().enable_time().build()
}

/// Takes connections, for ever.
async fn serve(listener: &TcpListener, router: &Router, limits: Limits) {
    let places = Arc::new(Semaphore::new(limits.connections));
    loop {
        let Ok((stream, peer)) = listener.accept().await else {
            tokio::time::sleep(NO_ROOM).await;
            continue;
        };
        if let Ok(place) = Arc::clone(&places).try_acquire_owned() {
            // What is asked over a connection comes from its other end.
            let router = router.clone().layer(Extension(ConnectInfo(peer)));
            tokio::spawn(async move {
                answer(stream, router, limits).await;
                drop(place);
            });
        }
    }
}

/// Answers what comes over a connection, until it ends.
async fn answer(stream: TcpStream, router: Router, limits: Limits) {
    let mut protocol = http1::Builder::new();
    protocol.timer(TokioTimer::new()).header_read_timeout(limits.head).max_buf_size(LONGEST_HEAD);
    // Whoever asked may go at any time.
    protocol.serve_connection(TokioIo::new(stream), TowerToHyperService::new(router)).await.ok();
}
