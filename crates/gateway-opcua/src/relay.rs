//! The connections of clients. The library accepts any number of connections, goes on to read requests while a client takes no answers,
//! and collects the octets of a chunk whatever length it claims; so a relay stands before it. It counts connections, stops reading from a
//! client that does not take its answers, and disconnects one whose chunk is too long.

use profivac_gateway::socket::keep_alive;
use profivac_gateway::thread::StopSignal;
use profivac_station::gateway_status::GatewayStatus;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, PoisonError};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Mutex;
use tokio::time::{sleep, timeout};

/// The most connections at the same time. chosen: some clients for each control room.
pub const MAX_CONNECTIONS: usize = 128;

/// The most connections from one address, so that one computer does not take all of them.
const MAX_OF_ADDRESS: usize = 64;

/// A client that has not taken an answer after this time is disconnected.
const STALL_TIMEOUT: Duration = Duration::from_secs(10);

/// The pause after the system could not accept a connection, for example because no file descriptor is free.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// The largest chunk of a message in octets, and the most octets that are passed on at once. The library announces 65,535 (OPC 10000-6,
/// 7.1.2.4).
const CHUNK: usize = 65_536;

/// The head of a chunk: its type in four octets, and its length with the head in 32 bits, the lowest octet first (OPC 10000-6, 7.1.2.2).
const HEAD: usize = 8;

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
                ended = serve(client, server) => {
                    if let Some(reason) = ended.err().filter(|error| error.kind() == ErrorKind::InvalidData) {
                        status.refused(&format!("a connection from {}: {reason}", peer.ip()));
                    }
                }
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

/// A client has begun a chunk with a length that it may not have.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a chunk of {HEAD} to {CHUNK} octets, found one of {0}")]
struct WrongLength(u32);

/// Where the chunks of a client begin and end.
#[derive(Debug, Default)]
struct Chunks {
    head: Vec<u8>,
    /// The octets of the present chunk that follow.
    rest: usize,
}

impl Chunks {
    /// The client has sent these octets.
    ///
    /// # Errors
    /// The length of the first chunk that may not have it.
    fn take(&mut self, mut octets: &[u8]) -> Result<(), WrongLength> {
        while !octets.is_empty() {
            let wanted = if self.rest > 0 { self.rest } else { HEAD - self.head.len() };
            let (taken, behind) = octets.split_at(wanted.min(octets.len()));
            octets = behind;
            if self.rest > 0 {
                self.rest -= taken.len();
                continue;
            }
            self.head.extend_from_slice(taken);
            let Some(length) = self.head.get(4..).and_then(|length| length.try_into().ok()) else { continue };
            self.head.clear();
            let length = u32::from_le_bytes(length);
            let is_right = usize::try_from(length).is_ok_and(|it| (HEAD..=CHUNK).contains(&it));
            if !is_right {
                return Err(WrongLength(length));
            }
            self.rest = length as usize - HEAD;
        }
        Ok(())
    }
}

/// Passes requests on, but none while an answer waits for the client. Ends at a chunk of a wrong length, without passing its head on.
async fn pass_requests(
    mut client: impl AsyncRead + Unpin,
    mut server: impl AsyncWrite + Unpin,
    answering: &Mutex<()>,
) -> std::io::Result<()> {
    let (mut octets, mut chunks) = (vec![0; CHUNK], Chunks::default());
    loop {
        let length = client.read(&mut octets).await?;
        if length == 0 {
            return Ok(());
        }
        let read = octets.get(..length).unwrap_or_default();
        chunks.take(read).map_err(|error| std::io::Error::new(ErrorKind::InvalidData, error))?;
        drop(answering.lock().await);
        server.write_all(read).await?;
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
        client_requests.write_all(&chunk(9)).await.unwrap();
        assert!(timeout(Duration::ZERO, &mut requests).await.is_err());
        let mut request = [0; 9];
        assert!(timeout(Duration::ZERO, server_requests.read(&mut request)).await.is_err(), "no request passes");
        // Without the answer that waits the request passes.
        drop(answers);
        assert!(timeout(Duration::ZERO, &mut requests).await.is_err());
        assert_eq!(server_requests.read(&mut request).await.unwrap(), 9);
    }

    /// A chunk of this length, or its first octets.
    fn chunk(length: u32) -> Vec<u8> {
        let mut octets = [b"MSGF".as_slice(), &length.to_le_bytes()].concat();
        octets.resize((length as usize).clamp(HEAD, CHUNK), 0);
        octets
    }

    #[test]
    fn chunks_of_right_lengths_follow_each_other_in_pieces_of_any_size() {
        let stream = [chunk(8), chunk(9), chunk(65_536), chunk(8), chunk(100)].concat();
        for size in [1, 3, 8, 1000, stream.len()] {
            let mut chunks = Chunks::default();
            assert!(stream.chunks(size).all(|piece| chunks.take(piece).is_ok()), "pieces of {size}");
            assert_eq!((chunks.head.len(), chunks.rest), (0, 0));
            for length in [0, 7, 65_537, u32::MAX] {
                let mut chunks = Chunks::default();
                chunks.take(&stream).unwrap();
                let found = chunk(length).chunks(size).find_map(|piece| chunks.take(piece).err());
                assert_eq!(found, Some(WrongLength(length)), "pieces of {size}");
            }
        }
    }

    /// The library would collect its octets until the memory is full.
    #[tokio::test]
    async fn a_client_that_begins_a_chunk_without_end_is_disconnected() {
        let (client_in, mut client) = duplex(CHUNK);
        let (server_out, mut server) = duplex(CHUNK);
        client.write_all(&chunk(u32::MAX)[..HEAD]).await.unwrap();
        let ended = pass_requests(client_in, server_out, &Mutex::new(())).await;
        assert_eq!(ended.unwrap_err().to_string(), "expected a chunk of 8 to 65536 octets, found one of 4294967295");
        let mut passed = Vec::new();
        server.read_to_end(&mut passed).await.unwrap();
        assert!(passed.is_empty(), "{passed:?}");
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
