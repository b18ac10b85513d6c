//! The connections of clients. The library accepts any number of connections, and goes on to read requests while a client takes no
//! answers; so a relay stands before it, which counts connections and stops reading from a client that does not take its answers.

use profivac_gateway::socket::keep_alive;
use profivac_gateway::thread::StopSignal;
use profivac_station::gateway_status::GatewayStatus;
use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, PoisonError};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Mutex;
use tokio::time::{sleep, timeout};

/// The most connections at the same time. free choice: some clients for each control room.
pub const MAX_CONNECTIONS: usize = 128;

/// The most connections from one address, so that one computer does not take all of them.
const MAX_OF_ADDRESS: usize = 64;

/// A client that has not taken an answer after this time is disconnected.
const STALL_TIMEOUT: Duration = Duration::from_secs(10);

/// The pause after the system could not accept a connection, for example because no file descriptor is free.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// The octets that are passed on at once: the largest chunk of a message.
const CHUNK: usize = 65_536;

/// The connections of each address.
#[derive(Debug, Default)]
struct Slots(std::sync::Mutex<BTreeMap<IpAddr, usize>>);

/// A connection that counts, until it is dropped.
#[derive(Debug)]
struct Slot {
    slots: Arc<Slots>,
    peer: IpAddr,
}

impl Slots {
    /// A slot for a connection of this address, unless it or all addresses have too many.
    fn take(slots: &Arc<Self>, peer: IpAddr) -> Option<Slot> {
        let mut counts = slots.0.lock().unwrap_or_else(PoisonError::into_inner);
        let all: usize = counts.values().sum();
        let own = counts.get(&peer).copied().unwrap_or_default();
        if all >= MAX_CONNECTIONS || own >= MAX_OF_ADDRESS {
            return None;
        }
        counts.insert(peer, own.saturating_add(1));
        Some(Slot { slots: Arc::clone(slots), peer })
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        let mut counts = self.slots.0.lock().unwrap_or_else(PoisonError::into_inner);
        let left = counts.remove(&self.peer).unwrap_or_default().saturating_sub(1);
        if left > 0 {
            counts.insert(self.peer, left);
        }
    }
}

/// Accepts clients and passes their octets to the library at `server`, until it is told to stop.
pub async fn run(listener: TcpListener, server: SocketAddr, status: Arc<GatewayStatus>, mut stop: StopSignal) {
    let slots = Arc::new(Slots::default());
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = stop.stopped() => return,
        };
        let Ok((client, peer)) = accepted else {
            sleep(ACCEPT_PAUSE).await;
            continue;
        };
        let Some(slot) = Slots::take(&slots, peer.ip()) else {
            status
                .refused(&format!("a connection beyond {MAX_CONNECTIONS}, or beyond {MAX_OF_ADDRESS} of one address"));
            continue;
        };
        let (status, mut stop) = (Arc::clone(&status), stop.clone());
        tokio::spawn(async move {
            status.client_connected();
            tokio::select! {
                _ = serve(client, server) => {}
                () = stop.stopped() => {}
            }
            status.client_disconnected();
            drop(slot);
        });
    }
}

async fn serve(client: TcpStream, server: SocketAddr) -> std::io::Result<()> {
    let server = TcpStream::connect(server).await?;
    // A system without keepalive keeps dead connections until they are written to.
    keep_alive(&client).ok();
    server.set_nodelay(true)?;
    let (from_client, to_client) = client.into_split();
    let (from_server, to_server) = server.into_split();
    // Held while an answer waits for the client.
    let answering = Mutex::new(());
    tokio::select! {
        ended = pass_requests(from_client, to_server, &answering) => ended,
        ended = pass_answers(from_server, to_client, &answering, STALL_TIMEOUT) => ended,
    }
}

/// Passes requests on, but none while an answer waits for the client.
async fn pass_requests(
    mut client: impl AsyncRead + Unpin,
    mut server: impl AsyncWrite + Unpin,
    answering: &Mutex<()>,
) -> std::io::Result<()> {
    let mut chunk = vec![0; CHUNK];
    loop {
        let length = client.read(&mut chunk).await?;
        if length == 0 {
            return Ok(());
        }
        drop(answering.lock().await);
        server.write_all(chunk.get(..length).unwrap_or_default()).await?;
    }
}

/// Passes answers on; ends when the client has not taken one after the time `stall`.
async fn pass_answers(
    mut server: impl AsyncRead + Unpin,
    mut client: impl AsyncWrite + Unpin,
    answering: &Mutex<()>,
    stall: Duration,
) -> std::io::Result<()> {
    let mut chunk = vec![0; CHUNK];
    loop {
        let length = server.read(&mut chunk).await?;
        if length == 0 {
            return client.shutdown().await;
        }
        let _answering = answering.lock().await;
        timeout(stall, client.write_all(chunk.get(..length).unwrap_or_default())).await??;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::duplex;

    #[test]
    fn one_address_does_not_take_all_connections() {
        let slots = Arc::new(Slots::default());
        let address = |number: u8| IpAddr::from([10, 0, 0, number]);
        let mut taken: Vec<_> = (0..MAX_CONNECTIONS).filter_map(|_| Slots::take(&slots, address(1))).collect();
        assert_eq!(taken.len(), MAX_OF_ADDRESS);
        taken.extend((0..MAX_CONNECTIONS).filter_map(|_| Slots::take(&slots, address(2))));
        assert_eq!(taken.len(), MAX_CONNECTIONS);
        assert!(Slots::take(&slots, address(3)).is_none());
        taken.clear();
        assert!(slots.0.lock().unwrap().is_empty());
        assert!(Slots::take(&slots, address(3)).is_some());
    }

    /// A client that takes no answers: after the first that waits, no request reaches the server.
    #[tokio::test]
    async fn while_an_answer_waits_for_the_client_no_request_passes() {
        let (client_in, mut client_requests) = duplex(CHUNK);
        let (client_out, _client_answers) = duplex(4);
        let (server_in, mut server_answers) = duplex(CHUNK);
        let (server_out, mut server_requests) = duplex(CHUNK);
        let answering = Mutex::new(());
        let mut answers = Box::pin(pass_answers(server_in, client_out, &answering, Duration::MAX));
        let mut requests = Box::pin(pass_requests(client_in, server_out, &answering));
        server_answers.write_all(b"more than four").await.unwrap();
        // Without time a future is polled and not awaited: the answer begins, and holds the requests back until it ends.
        assert!(timeout(Duration::ZERO, &mut answers).await.is_err(), "the answer waits");
        client_requests.write_all(b"request").await.unwrap();
        assert!(timeout(Duration::ZERO, &mut requests).await.is_err());
        let mut request = [0; 7];
        assert!(timeout(Duration::ZERO, server_requests.read(&mut request)).await.is_err(), "no request passes");
        // Without the answer that waits the request passes.
        drop(answers);
        assert!(timeout(Duration::ZERO, &mut requests).await.is_err());
        assert_eq!(server_requests.read(&mut request).await.unwrap(), 7);
    }

    #[tokio::test]
    async fn a_client_that_takes_no_answers_is_disconnected() {
        let (client_out, _client_answers) = duplex(4);
        let (server_in, mut server_answers) = duplex(CHUNK);
        server_answers.write_all(b"more than four").await.unwrap();
        let ended = pass_answers(server_in, client_out, &Mutex::new(()), Duration::from_millis(1)).await;
        assert_eq!(ended.unwrap_err().kind(), std::io::ErrorKind::TimedOut);
    }
}
