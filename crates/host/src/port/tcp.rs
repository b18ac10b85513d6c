//! A line over TCP: raw octets, no protocol of its own.
//!
//! The clients of a server share one line as if they were wired to it: what one sends, all others hear.

use super::{CHUNK, Character, Port, PortError};
use rustix::fd::{AsFd, BorrowedFd};
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};

/// Listens, and is the line between its clients and us.
#[derive(Debug)]
pub struct TcpServer {
    name: String,
    listener: TcpListener,
    clients: Vec<TcpStream>,
}

impl TcpServer {
    /// Listens at `HOST:PORT`. Port 0 lets the system choose one; [`name`](Port::name) tells which.
    ///
    /// # Errors
    /// [`PortError::Address`] when `address` is none, [`PortError::InUse`] when somebody else listens there.
    pub fn listen(address: &str) -> Result<Self, PortError> {
        let host = host(address)?;
        let failed = |error| network(address, error);
        let listener = TcpListener::bind(address).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        Ok(Self { name: format!("{host}:{port}"), listener, clients: Vec::new() })
    }

    /// Takes everybody who wants to join. A client that cannot be set up is not taken.
    fn accept(&mut self) {
        while let Ok((client, _)) = self.listener.accept() {
            if client.set_nonblocking(true).and_then(|()| client.set_nodelay(true)).is_ok() {
                self.clients.push(client);
            }
        }
    }

    fn share(&mut self, octets: &[u8], except: Option<usize>) {
        for (number, client) in self.clients.iter_mut().enumerate() {
            if Some(number) != except {
                // What a client does not read is dropped; one that is gone is noticed when it is read from.
                let _taken = client.write(octets);
            }
        }
    }
}

impl Port for TcpServer {
    fn name(&self) -> &str {
        &self.name
    }

    fn watched(&self) -> Vec<BorrowedFd<'_>> {
        std::iter::once(self.listener.as_fd()).chain(self.clients.iter().map(AsFd::as_fd)).collect()
    }

    fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
        self.accept();
        let mut buffer = [0; CHUNK];
        let mut gone = Vec::new();
        for number in 0..self.clients.len() {
            match self.clients.get_mut(number).map(|client| client.read(&mut buffer)) {
                Some(Ok(length)) if length > 0 => {
                    let octets = buffer.get(..length).unwrap_or_default();
                    heard.extend(octets.iter().map(|octet| Character::Octet(*octet)));
                    self.share(octets, Some(number));
                }
                Some(Err(error)) if is_passing(&error) => {}
                _ => gone.push(number),
            }
        }
        for number in gone.into_iter().rev() {
            self.clients.remove(number);
        }
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        self.share(octets, None);
        Ok(())
    }
}

/// A connection to a serial server.
#[derive(Debug)]
pub struct TcpClient {
    name: String,
    stream: TcpStream,
}

impl TcpClient {
    /// Connects to `HOST:PORT`.
    ///
    /// # Errors
    /// [`PortError::Address`] when `address` is none, [`PortError::Missing`] when nobody listens there.
    pub fn connect(address: &str) -> Result<Self, PortError> {
        host(address)?;
        let name = format!("tcp://{address}");
        let failed = |error| network(&name, error);
        let stream = TcpStream::connect(address).map_err(failed)?;
        stream.set_nonblocking(true).and_then(|()| stream.set_nodelay(true)).map_err(failed)?;
        Ok(Self { name, stream })
    }
}

impl Port for TcpClient {
    fn name(&self) -> &str {
        &self.name
    }

    fn watched(&self) -> Vec<BorrowedFd<'_>> {
        vec![self.stream.as_fd()]
    }

    fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
        let mut buffer = [0; CHUNK];
        match self.stream.read(&mut buffer) {
            Ok(0) => return Err(PortError::Lost(self.name.clone())),
            Ok(length) => heard.extend(buffer.iter().take(length).map(|octet| Character::Octet(*octet))),
            Err(error) if is_passing(&error) => {}
            Err(_) => return Err(PortError::Lost(self.name.clone())),
        }
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        match self.stream.write(octets) {
            Ok(_) => Ok(()),
            Err(error) if is_passing(&error) => Ok(()),
            Err(_) => Err(PortError::Lost(self.name.clone())),
        }
    }
}

fn is_passing(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

/// The part of `HOST:PORT` before the port.
fn host(address: &str) -> Result<&str, PortError> {
    match address.rsplit_once(':') {
        Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok() => Ok(host),
        _ => Err(PortError::Address(address.to_owned())),
    }
}

fn network(name: &str, error: std::io::Error) -> PortError {
    match error.kind() {
        ErrorKind::AddrInUse => PortError::InUse(name.to_owned()),
        ErrorKind::PermissionDenied => PortError::Denied(name.to_owned()),
        ErrorKind::ConnectionRefused | ErrorKind::AddrNotAvailable | ErrorKind::NotFound | ErrorKind::TimedOut => {
            PortError::Missing(name.to_owned())
        }
        _ => PortError::system(name, error),
    }
}
