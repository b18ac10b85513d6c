//! A connection of a client, for both protocols.
//!
//! There is no queue of updates. Whenever the octets for a client have left, the connection compares the newest snapshot with what the
//! client has, and writes the differences until a bounded buffer is full. So a client that is slow or stopped gets fewer updates, each of
//! them the newest, and delays no other.

use crate::database::World;
use crate::put::{Finished, Puts, Writer};
use profivac_gateway::thread::StopSignal;
use profivac_station::gateway_status::GatewayStatus;
use std::collections::HashMap;
use std::io;
use std::net::IpAddr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::sync::watch;
use tokio::time::{Instant, sleep, sleep_until};

/// The octets that wait for a client at most, before the last message is added.
pub const MAX_OUT: usize = 64 * 1024;

/// The largest message of a client, in octets. chosen: a thousand names in one search.
pub const MAX_MESSAGE: usize = 64 * 1024;

/// Connections in total and from one computer.
const MAX_CLIENTS: usize = 1000;
const MAX_CLIENTS_OF_HOST: usize = 200;

/// Channels and monitors of all clients.
const MAX_SLOTS: usize = 400_000;

/// Channels, and monitors, of one client.
pub const MAX_PER_CLIENT: usize = 40_000;

/// How long a new connection may take for its first message.
const FIRST_MESSAGE: Duration = Duration::from_secs(10);

/// How long a client may take no octets before its connection is closed. A client that continues later connects again by itself.
const STALLED: Duration = Duration::from_secs(60);

/// The pause after the system could not accept a connection.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Why a connection ends.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Broken {
    /// The octets are no message of the protocol.
    #[error("sent what is no message of the protocol: {0}")]
    Malformed(&'static str),
    /// A message is too large.
    #[error("sent a message of {0} octets; at most {MAX_MESSAGE} are accepted")]
    TooLarge(u64),
    /// The records changed, and a channel of the client has none any more.
    #[error("has a channel whose record no longer exists after a change of the file")]
    RecordGone,
}

/// What one turn of updates did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Posted {
    /// Updates that were written.
    pub sent: u64,
    /// Updates that newer ones replaced.
    pub dropped: u64,
    /// Whether the client has everything of this snapshot.
    pub is_complete: bool,
}

/// One side of a conversation.
pub trait Protocol: Send + 'static {
    /// What the protocol keeps of a put until its result is there.
    type Request: Send + 'static;
    /// The puts of this client.
    fn puts(&mut self) -> &mut Puts<Self::Request>;
    /// Tells the client the result of a put.
    fn finish(&mut self, finished: Finished<Self::Request>, out: &mut Vec<u8>);
    /// What the server says first.
    fn greet(&mut self, out: &mut Vec<u8>);
    /// Handles the message at the beginning of `input`, and returns its octets; 0 if it is not complete.
    ///
    /// # Errors
    /// The connection must end.
    fn receive(&mut self, input: &[u8], world: &World, out: &mut Vec<u8>) -> Result<usize, Broken>;
    /// Writes the updates that the client does not have, until `out` has [`MAX_OUT`] octets.
    fn post(&mut self, world: &World, out: &mut Vec<u8>) -> Posted;
    /// Looks up its channels in the records of a changed file.
    ///
    /// # Errors
    /// A record is gone: the client must search it again.
    fn renew(&mut self, old: &World, new: &World) -> Result<(), Broken>;
}

/// Permits for channels and monitors, shared by all clients, so that their number is bounded.
#[derive(Debug, Default)]
pub struct Slots {
    used: Arc<AtomicUsize>,
    own: usize,
}

impl Slots {
    /// Takes a permit.
    pub fn take(&mut self) -> bool {
        let is_free = self.used.fetch_add(1, Ordering::Relaxed) < MAX_SLOTS;
        if is_free {
            self.own = self.own.saturating_add(1);
        } else {
            self.used.fetch_sub(1, Ordering::Relaxed);
        }
        is_free
    }

    /// Gives a permit back.
    pub fn give(&mut self) {
        if let Some(less) = self.own.checked_sub(1) {
            self.own = less;
            self.used.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

impl Drop for Slots {
    fn drop(&mut self) {
        self.used.fetch_sub(self.own, Ordering::Relaxed);
    }
}

/// What the connections share.
#[derive(Clone)]
pub struct Shared {
    /// Records and values, with each snapshot.
    pub world: watch::Receiver<Arc<World>>,
    /// Where clients, errors and refused requests are counted.
    pub status: Arc<GatewayStatus>,
    /// Tells all connections to end.
    pub stop: StopSignal,
    /// Writes what clients put, if the file permits it.
    pub writer: Option<Arc<Writer>>,
    clients: Arc<Mutex<HashMap<IpAddr, usize>>>,
    slots: Arc<AtomicUsize>,
}

impl Shared {
    /// Without connections.
    #[must_use]
    pub fn new(
        world: watch::Receiver<Arc<World>>,
        status: Arc<GatewayStatus>,
        stop: StopSignal,
        writer: Option<Arc<Writer>>,
    ) -> Self {
        Self { world, status, stop, writer, clients: Arc::default(), slots: Arc::default() }
    }

    /// Permits for the channels of one client.
    #[must_use]
    pub fn slots(&self) -> Slots {
        Slots { used: Arc::clone(&self.slots), own: 0 }
    }

    fn admit(&self, host: IpAddr) -> Option<Admission> {
        let mut clients = self.clients.lock().unwrap_or_else(PoisonError::into_inner);
        let total: usize = clients.values().sum();
        let own = clients.get(&host).copied().unwrap_or_default();
        if total >= MAX_CLIENTS || own >= MAX_CLIENTS_OF_HOST {
            return None;
        }
        clients.insert(host, own.saturating_add(1));
        self.status.client_connected();
        Some(Admission { shared: self.clone(), host })
    }
}

/// A client that is counted until this is dropped.
struct Admission {
    shared: Shared,
    host: IpAddr,
}

impl Drop for Admission {
    fn drop(&mut self) {
        let mut clients = self.shared.clients.lock().unwrap_or_else(PoisonError::into_inner);
        match clients.get(&self.host).copied().unwrap_or_default() {
            0 | 1 => {
                clients.remove(&self.host);
            }
            more => {
                clients.insert(self.host, more.saturating_sub(1));
            }
        }
        self.shared.status.client_disconnected();
    }
}

/// Accepts connections until the gateway stops.
pub async fn accept<P: Protocol>(
    listener: TcpListener,
    shared: Shared,
    protocol: impl Fn(&Shared, IpAddr) -> P + Send,
) {
    let mut stop = shared.stop.clone();
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = stop.stopped() => return,
        };
        let Ok((stream, address)) = accepted else {
            // For example too many open files: the connections that end make room.
            sleep(ACCEPT_PAUSE).await;
            continue;
        };
        let host = address.ip();
        let Some(admission) = shared.admit(host) else {
            shared.status.refused(&format!("a connection from {host}: too many connections"));
            continue;
        };
        let protocol = protocol(&shared, host);
        tokio::spawn(async move {
            let shared = admission.shared.clone();
            if let Err(End::Broken(reason)) = Connection::new(stream, protocol).serve(&shared).await {
                shared.status.refused(&format!("the client at {host} {reason}"));
            }
            drop(admission);
        });
    }
}

/// Why a connection ended.
enum End {
    /// The client broke the protocol.
    Broken(Broken),
    /// The client is gone or too slow.
    Gone,
}

impl From<Broken> for End {
    fn from(reason: Broken) -> Self {
        Self::Broken(reason)
    }
}

/// The next result of a put.
async fn next<R>(results: &mut Option<UnboundedReceiver<Finished<R>>>) -> Option<Finished<R>> {
    match results {
        Some(results) => results.recv().await,
        None => None,
    }
}

struct Connection<P> {
    stream: TcpStream,
    protocol: P,
    input: Vec<u8>,
    out: Vec<u8>,
    /// A snapshot is there of which the client may lack something.
    is_pending: bool,
    /// A newer one came while the last one was being written.
    is_newer: bool,
    /// When the connection ends unless the client does something.
    deadline: Option<Instant>,
    has_spoken: bool,
}

impl<P: Protocol> Connection<P> {
    fn new(stream: TcpStream, protocol: P) -> Self {
        let deadline = Instant::now().checked_add(FIRST_MESSAGE);
        let (input, out) = (Vec::new(), Vec::new());
        Self { stream, protocol, input, out, is_pending: false, is_newer: false, deadline, has_spoken: false }
    }

    async fn serve(mut self, shared: &Shared) -> Result<(), End> {
        // A system without keepalive keeps dead connections until they are written to.
        profivac_gateway::socket::keep_alive(&self.stream).ok();
        let (mut worlds, mut stop) = (shared.world.clone(), shared.stop.clone());
        let mut world = Arc::clone(&worlds.borrow_and_update());
        let mut results = self.protocol.puts().take_results();
        self.protocol.greet(&mut self.out);
        loop {
            self.handle(&world)?;
            self.post(&world, &shared.status);
            self.watch_stalls();
            let wants_input = self.out.len() < MAX_OUT && self.input.len() <= MAX_MESSAGE;
            let deadline = self.deadline.unwrap_or_else(Instant::now);
            tokio::select! {
                ready = self.stream.readable(), if wants_input => {
                    ready.map_err(|_| End::Gone)?;
                    self.read()?;
                }
                ready = self.stream.writable(), if !self.out.is_empty() => {
                    ready.map_err(|_| End::Gone)?;
                    self.write()?;
                }
                Some(finished) = next(&mut results) => {
                    // The client reads the value next that this put has waited for.
                    if worlds.has_changed().unwrap_or_default() {
                        self.take_world(&mut worlds, &mut world)?;
                    }
                    self.protocol.puts().finished();
                    self.protocol.finish(finished, &mut self.out);
                }
                changed = worlds.changed() => {
                    changed.map_err(|_| End::Gone)?;
                    self.take_world(&mut worlds, &mut world)?;
                }
                () = sleep_until(deadline), if self.deadline.is_some() => return Err(End::Gone),
                () = stop.stopped() => return Ok(()),
            }
            // A client with many requests leaves time to the others.
            tokio::task::yield_now().await;
        }
    }

    /// Takes the newest records and values.
    fn take_world(&mut self, worlds: &mut watch::Receiver<Arc<World>>, world: &mut Arc<World>) -> Result<(), End> {
        let new = Arc::clone(&worlds.borrow_and_update());
        if !Arc::ptr_eq(&new.database, &world.database) {
            self.protocol.renew(world, &new)?;
        }
        *world = new;
        self.is_newer = self.is_pending;
        self.is_pending = true;
        Ok(())
    }

    /// Handles the complete messages while there is room for their answers.
    fn handle(&mut self, world: &World) -> Result<(), End> {
        let mut used = 0_usize;
        while self.out.len() < MAX_OUT {
            let rest = self.input.get(used..).unwrap_or_default();
            match self.protocol.receive(rest, world, &mut self.out)? {
                0 => break,
                octets => used = used.saturating_add(octets),
            }
        }
        self.input.drain(..used.min(self.input.len()));
        if used > 0 && !self.has_spoken {
            self.has_spoken = true;
            self.deadline = None;
        }
        // A new monitor gets its first value.
        self.is_pending |= used > 0;
        Ok(())
    }

    fn post(&mut self, world: &World, status: &GatewayStatus) {
        if !self.is_pending || self.out.len() >= MAX_OUT {
            return;
        }
        let posted = self.protocol.post(world, &mut self.out);
        if posted.sent > 0 {
            status.sent(posted.sent);
        }
        if posted.dropped > 0 {
            status.dropped_updates(posted.dropped);
        }
        if posted.is_complete {
            self.is_pending = std::mem::take(&mut self.is_newer);
        }
    }

    /// Starts the time limit of a client that takes no octets.
    fn watch_stalls(&mut self) {
        if self.has_spoken {
            self.deadline = match (self.out.is_empty(), self.deadline) {
                (true, _) => None,
                (false, None) => Instant::now().checked_add(STALLED),
                (false, running) => running,
            };
        }
    }

    fn read(&mut self) -> Result<(), End> {
        let mut chunk = [0_u8; 16 * 1024];
        match self.stream.try_read(&mut chunk) {
            Ok(0) => Err(End::Gone),
            Ok(count) => {
                self.input.extend_from_slice(chunk.get(..count).unwrap_or_default());
                Ok(())
            }
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(()),
            Err(_) => Err(End::Gone),
        }
    }

    fn write(&mut self) -> Result<(), End> {
        match self.stream.try_write(&self.out) {
            Ok(count) => {
                self.out.drain(..count.min(self.out.len()));
                if self.has_spoken {
                    self.deadline = None;
                }
                Ok(())
            }
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(()),
            Err(_) => Err(End::Gone),
        }
    }
}
