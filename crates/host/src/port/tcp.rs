//! A line over TCP: raw octets without a protocol.
//!
//! The clients of a server share one line as if they were wired to it: every client receives what another sends. A client
//! that does not read does not delay the others: its octets are dropped, and a notice reports it.

use super::notice::{DropCounter, Notice, Notices};
use super::stream::{Stream, is_temporary, write_now};
use super::{CHUNK, Character, Port, PortError};
use crate::keep_alive::KeepAlive;
use crate::readiness::Readiness;
use std::io::{ErrorKind, Read};
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::time::Duration;

/// The longest wait for a host. chosen: a serial server in the same plant answers in milliseconds; the system waits
/// minutes.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// When and how often a silent connection is probed before it counts as lost. chosen: a bus is hardly ever silent, so
/// the probes cost nothing, and an unplugged cable is detected within half a minute.
const KEEP_ALIVE: KeepAlive = KeepAlive { after: Duration::from_secs(10), period: Duration::from_secs(5), count: 3 };

/// The most clients of a server. chosen: more than the stations of most segments, and few enough to serve in turn.
const MAX_CLIENTS: usize = 64;

/// How long sent octets may stay unacknowledged, in milliseconds: as long as a silent connection may be lost.
#[cfg(target_os = "linux")]
const USER_TIMEOUT_MS: u32 = 25_000;

/// A listener that is the line between its clients and this program.
#[derive(Debug)]
pub struct TcpServer {
    name: String,
    listener: TcpListener,
    clients: Vec<Client>,
    notices: Notices,
}

#[derive(Debug)]
struct Client {
    name: String,
    socket: TcpStream,
    drops: DropCounter,
}

impl TcpServer {
    /// Listens at `HOST:PORT`. Port 0 lets the system choose one; [`name`](Port::name) contains it.
    ///
    /// # Errors
    /// [`PortError::InvalidAddress`], or [`PortError::AddressInUse`] when another program listens there.
    pub fn listen(address: &str) -> Result<Self, PortError> {
        let host = host(address)?;
        let failed = |error: std::io::Error| match error.kind() {
            // The port exists; this computer does not have the address.
            ErrorKind::AddrNotAvailable => PortError::system(address, error),
            _ => network(address, error),
        };
        let addresses = resolve(address, address)?;
        let listener = TcpListener::bind(addresses.as_slice()).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        Ok(Self { name: format!("{host}:{port}"), listener, clients: Vec::new(), notices: Notices::default() })
    }

    /// Puts accepted connections on the line. A client that cannot be set up is dropped, and so is one too many.
    fn admit(&mut self, connections: Vec<(TcpStream, SocketAddr)>) {
        for (socket, address) in connections {
            let name = format!("tcp://{address}");
            if self.clients.len() >= MAX_CLIENTS {
                self.notices.extend(Some(Notice::ClientRefused { name, most: MAX_CLIENTS }));
            } else if set_up(&socket).is_ok() {
                self.clients.push(Client { name, socket, drops: DropCounter::default() });
            }
        }
    }

    fn distribute(&mut self, octets: &[u8], except: Option<usize>) {
        for (number, client) in self.clients.iter_mut().enumerate() {
            if Some(number) != except {
                // A closed connection is detected at the next read.
                let taken = write_now(&mut client.socket, octets).unwrap_or(octets.len());
                self.notices.extend(client.drops.sent(&client.name, octets.len(), taken));
            }
        }
    }
}

impl Port for TcpServer {
    fn name(&self) -> &str {
        &self.name
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        let clients = self.clients.iter().map(|client| Readiness::of(&client.socket));
        std::iter::once(Readiness::of(&self.listener)).chain(clients).collect()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        // A program that closes its connection and opens another one must not receive its own last octets there. So new clients
        // are on the line only after everything was read that was sent before they connected.
        let connections: Vec<_> = std::iter::from_fn(|| self.listener.accept().ok()).collect();
        let mut buffer = [0; CHUNK];
        let mut gone = Vec::new();
        for number in 0..self.clients.len() {
            match self.clients.get_mut(number).map(|client| client.socket.read(&mut buffer)) {
                Some(Ok(length)) if length > 0 => {
                    let octets = buffer.get(..length).unwrap_or_default();
                    characters.extend(octets.iter().map(|octet| Character::Octet(*octet)));
                    self.distribute(octets, Some(number));
                }
                Some(Err(error)) if is_temporary(&error) => {}
                _ => gone.push(number),
            }
        }
        for number in gone.into_iter().rev() {
            self.clients.remove(number);
        }
        self.admit(connections);
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        self.distribute(octets, None);
        Ok(())
    }

    fn next_notice(&mut self) -> Option<Notice> {
        self.notices.next()
    }
}

/// A connection to a serial server.
pub type TcpClient = Stream<TcpStream>;

impl TcpClient {
    /// Connects to `HOST:PORT`. Tries each address of the host for three seconds.
    ///
    /// # Errors
    /// [`PortError::InvalidAddress`], [`PortError::UnresolvedHost`], [`PortError::NotFound`] when no program listens there,
    /// [`PortError::Unreachable`] when the host does not answer.
    pub fn connect(address: &str) -> Result<Self, PortError> {
        let name = format!("tcp://{address}");
        let socket = connect(&name, address)?;
        Ok(Self::new(name, socket, Vec::new()).examined())
    }
}

/// A connection to `HOST:PORT` for the port `name`.
pub(super) fn connect(name: &str, address: &str) -> Result<TcpStream, PortError> {
    host(address)?;
    let mut refused = PortError::NotFound(name.to_owned());
    for address in resolve(name, address)? {
        match TcpStream::connect_timeout(&address, CONNECT_TIMEOUT) {
            Ok(socket) => {
                set_up(&socket).map_err(|error| network(name, error))?;
                return Ok(socket);
            }
            Err(error) => refused = network(name, error),
        }
    }
    Err(refused)
}

/// Sends octets at once, never blocks, and detects a peer that vanished.
fn set_up(socket: &TcpStream) -> std::io::Result<()> {
    socket.set_nonblocking(true)?;
    socket.set_nodelay(true)?;
    KEEP_ALIVE.set(socket)?;
    #[cfg(target_os = "linux")]
    {
        // Without this limit the system repeats unacknowledged octets for a quarter of an hour before it reports an error.
        rustix::net::sockopt::set_tcp_user_timeout(socket, USER_TIMEOUT_MS)?;
    }
    Ok(())
}

fn resolve(name: &str, address: &str) -> Result<Vec<SocketAddr>, PortError> {
    let addresses = address.to_socket_addrs().map(Iterator::collect);
    addresses.map_err(|source| PortError::UnresolvedHost { name: name.to_owned(), source })
}

/// The part of `HOST:PORT` before the port. An IPv6 address must be in brackets.
fn host(address: &str) -> Result<&str, PortError> {
    let in_brackets = |host: &str| host.starts_with('[') && host.ends_with(']');
    match address.rsplit_once(':') {
        Some((host, port))
            if !host.is_empty() && port.parse::<u16>().is_ok() && (!host.contains(':') || in_brackets(host)) =>
        {
            Ok(host)
        }
        _ => Err(PortError::InvalidAddress(address.to_owned())),
    }
}

fn network(name: &str, error: std::io::Error) -> PortError {
    match error.kind() {
        ErrorKind::AddrInUse => PortError::AddressInUse(name.to_owned()),
        ErrorKind::PermissionDenied => PortError::PermissionDenied(name.to_owned()),
        ErrorKind::ConnectionRefused | ErrorKind::AddrNotAvailable | ErrorKind::NotFound => {
            PortError::NotFound(name.to_owned())
        }
        ErrorKind::TimedOut => PortError::Unreachable { name: name.to_owned(), seconds: CONNECT_TIMEOUT.as_secs() },
        _ => PortError::system(name, error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// The longest wait for the operating system. A test that waits longer has failed.
    const TIMEOUT: Duration = Duration::from_secs(60);

    /// Serves until `done`.
    fn serve_until(server: &mut TcpServer, done: impl Fn(&TcpServer) -> bool) {
        while !done(server) {
            let ready = crate::readiness::wait(&server.readiness(), TIMEOUT).unwrap();
            assert!(ready.contains(&true), "no client in a minute");
            server.receive(&mut Vec::new()).unwrap();
        }
    }

    /// Waits until a client has connected.
    fn wait_for_connection(server: &TcpServer) {
        assert_eq!(crate::readiness::wait(&[Readiness::of(&server.listener)], TIMEOUT).unwrap(), [true]);
    }

    #[test]
    fn a_server_with_all_its_clients_closes_the_connection_of_another_and_reports_it() {
        let mut server = TcpServer::listen("127.0.0.1:0").unwrap();
        let connect = |server: &TcpServer| TcpStream::connect(server.name()).unwrap();
        let mut clients: Vec<_> = (0..MAX_CLIENTS).map(|_| connect(&server)).collect();
        serve_until(&mut server, |server| server.clients.len() == MAX_CLIENTS);
        let mut refused = connect(&server);
        wait_for_connection(&server);
        server.receive(&mut Vec::new()).unwrap();
        assert_eq!(server.clients.len(), MAX_CLIENTS);
        let name = format!("tcp://{}", refused.local_addr().unwrap());
        assert_eq!(server.next_notice(), Some(Notice::ClientRefused { name, most: MAX_CLIENTS }));
        assert_eq!(refused.read(&mut [0]).unwrap(), 0, "closed");
        // One client leaves and another takes its place.
        clients.pop();
        serve_until(&mut server, |server| server.clients.len() < MAX_CLIENTS);
        clients.push(connect(&server));
        serve_until(&mut server, |server| server.clients.len() == MAX_CLIENTS);
        assert_eq!(server.next_notice(), None);
    }

    #[test]
    fn a_client_that_connects_again_does_not_receive_its_own_last_octets() {
        let mut server = TcpServer::listen("127.0.0.1:0").unwrap();
        let address = server.name().to_owned();
        let mut first = TcpStream::connect(&address).unwrap();
        serve_until(&mut server, |server| server.clients.len() == 1);
        first.write_all(&[0xDC, 0, 0]).unwrap();
        drop(first);
        let mut second = TcpStream::connect(&address).unwrap();
        wait_for_connection(&server);
        let mut characters = Vec::new();
        server.receive(&mut characters).unwrap();
        assert_eq!(characters, [0xDC, 0, 0].map(Character::Octet));
        server.send(&[0xE5]).unwrap();
        let mut received = [0; 8];
        let length = second.read(&mut received).unwrap();
        assert_eq!(received[..length], [0xE5]);
    }
}
