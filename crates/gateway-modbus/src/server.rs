//! The server: connections with their limits, and the task that keeps the registers up to date.

use crate::image::{Encoder, Image};
use crate::map::{Map, MapError};
use crate::pdu::{Head, Identity, answer};
use profivac_gateway::thread::Context;
use profivac_recorder::Micros;
use profivac_station::config::gateways::modbus::Settings;
use profivac_station::gateway_status::GatewayStatus;
use profivac_web_server::auth::connections::{Evicted, Permit, Permits};
use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::time::{sleep, timeout};

/// The longest time that a client may take for the rest of a request, or not read its answer. chosen.
const STALL_TIMEOUT: Duration = Duration::from_secs(5);

/// The age from which registers count as no longer true: the read model makes new ones every 100 ms.
const OLD: Duration = Duration::from_secs(5);

/// The pause after the system has refused a connection, for example because no file descriptor is free.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// The reason why the gateway does not serve.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModbusError {
    /// The address cannot be used.
    #[error("cannot listen on {address}: {error}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The error of the operating system.
        error: std::io::Error,
    },
    /// The points do not fit into the map.
    #[error(transparent)]
    Map(#[from] MapError),
}

/// The latest registers.
type Latest = watch::Receiver<Option<Arc<Image>>>;

/// Serves until the gateway is to end.
pub async fn serve(settings: Settings, context: Context) -> Result<(), ModbusError> {
    let address = settings.listen;
    let listener = TcpListener::bind(address).await.map_err(|error| ModbusError::Listen { address, error })?;
    context.status.runs(listener.local_addr().unwrap_or(address).to_string());
    let (sender, latest) = watch::channel(None);
    let identity =
        Identity { version: env!("CARGO_PKG_VERSION").to_owned(), station: context.services.name().to_owned() };
    let mut stop = context.stop.clone();
    let server = Server { latest, identity, status: Arc::clone(&context.status), settings: settings.clone() };
    tokio::select! {
        ended = encode(&settings, &context, &sender) => match ended? {},
        () = Arc::new(server).accept(&listener) => Ok(()),
        () = stop.stopped() => Ok(()),
    }
}

/// Makes the registers of each snapshot.
async fn encode(
    settings: &Settings,
    context: &Context,
    sender: &watch::Sender<Option<Arc<Image>>>,
) -> Result<Infallible, MapError> {
    let mut subscription = context.model.subscribe();
    let mut present: Option<(Arc<[profivac_gateway::Point]>, Encoder)> = None;
    loop {
        if subscription.changed().await.is_err() {
            // The model has ended, and the gateway is about to.
            return std::future::pending().await;
        }
        let snapshot = Arc::clone(&subscription.borrow_and_update());
        let encoder = match present.take() {
            Some((points, encoder)) if Arc::ptr_eq(&points, &snapshot.points) => encoder,
            _ => Encoder::new(Map::of(&snapshot.points, settings)?, settings),
        };
        let (_, encoder) = present.insert((Arc::clone(&snapshot.points), encoder));
        let image = encoder.image(&snapshot, Micros::now());
        sender.send_replace(Some(Arc::new(image)).filter(|_| !snapshot.points.is_empty()));
    }
}

/// What all connections share.
struct Server {
    latest: Latest,
    identity: Identity,
    status: Arc<GatewayStatus>,
    settings: Settings,
}

impl Server {
    /// Accepts connections. Never returns.
    async fn accept(self: Arc<Self>, listener: &TcpListener) {
        let permits = Permits::new(self.settings.connections);
        loop {
            let Ok((stream, peer)) = listener.accept().await else {
                sleep(ACCEPT_PAUSE).await;
                continue;
            };
            if !self.is_allowed(peer.ip()) {
                self.status.refused(&format!("a connection from {}, which is not in allow", peer.ip()));
                continue;
            }
            match permits.take(peer.ip()) {
                Some((permit, evicted)) => drop(tokio::spawn(Arc::clone(&self).client(stream, permit, evicted))),
                None => self.status.refused("all places for connections are taken"),
            }
        }
    }

    /// This computer, and those of the file.
    fn is_allowed(&self, peer: IpAddr) -> bool {
        peer.to_canonical().is_loopback() || self.settings.allow.iter().any(|network| network.contains(peer))
    }

    /// Serves a connection until it ends, or until its permit is needed for another one.
    async fn client(self: Arc<Self>, stream: TcpStream, _permit: Arc<Permit>, evicted: Evicted) {
        self.status.client_connected();
        tokio::select! {
            ended = self.requests(stream) => if ended.is_none() {
                self.status.refused("octets that are no Modbus telegram, or half of one");
            },
            _ = evicted => {}
        }
        self.status.client_disconnected();
    }

    /// Answers requests one after the other. Returns `None` if the client sent what is no telegram.
    async fn requests(&self, mut stream: TcpStream) -> Option<()> {
        stream.set_nodelay(true).ok();
        loop {
            let mut head = [0; Head::LENGTH];
            // The first octet may take its time, the rest of a request not.
            match timeout(self.settings.idle, stream.read(head.get_mut(..1)?)).await {
                Ok(Ok(1)) => {}
                _ => return Some(()),
            }
            timeout(STALL_TIMEOUT, stream.read_exact(head.get_mut(1..)?)).await.ok()?.ok()?;
            let head = Head::parse(head)?;
            let mut pdu = vec![0; head.length];
            timeout(STALL_TIMEOUT, stream.read_exact(&mut pdu)).await.ok()?.ok()?;
            let telegram = head.telegram(&self.answer(&pdu));
            if !matches!(timeout(STALL_TIMEOUT, stream.write_all(&telegram)).await, Ok(Ok(()))) {
                return Some(());
            }
        }
    }

    fn answer(&self, pdu: &[u8]) -> Vec<u8> {
        let image = self.latest.borrow().clone().filter(|image| image.made.elapsed() < OLD);
        let (answer, exception) = answer(pdu, image.as_deref(), &self.identity);
        match exception {
            Some(exception) => self.status.refused(exception.reason()),
            None => self.status.sent(1),
        }
        answer
    }
}
