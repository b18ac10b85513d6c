//! The dashboard and the API on a socket, in a thread of their own.

use crate::api;
use crate::plant::Plant;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;
use tokio::net::TcpListener;
use tokio::runtime::Builder;
use tokio::sync::oneshot;

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
        if !address.ip().is_loopback() && !public {
            return Err(ServerError::Public(address));
        }
        let failed = |error| ServerError::Listen { address, error };
        let runtime =
            Builder::new_multi_thread().worker_threads(2).enable_io().enable_time().build().map_err(failed)?;
        let listener = runtime.block_on(TcpListener::bind(address)).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let (stop, stopped) = oneshot::channel::<()>();
        let serve = async move {
            let served = axum::serve(listener, api::router(plant));
            tokio::select! {
                _ = served => {}
                _ = stopped => {}
            }
        };
        let thread = std::thread::spawn(move || {
            runtime.block_on(serve);
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
