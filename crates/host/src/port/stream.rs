//! Octets over a socket: the client side of a TCP connection, and the port of a segment in memory.

use super::notice::{DropCounter, Notice, Notices};
use super::{CHUNK, Character, Port, PortError};
use crate::readiness::Readiness;
use std::io::{ErrorKind, Read, Write};
use std::os::fd::AsFd;

/// A connected socket that does not block.
#[derive(Debug)]
pub struct Stream<S> {
    name: String,
    socket: S,
    drops: DropCounter,
    notices: Notices,
}

impl<S> Stream<S> {
    /// Octets over `socket`, which must not block, with the notices that exist already.
    pub fn new(name: String, socket: S, notices: Vec<Notice>) -> Self {
        let mut waiting = Notices::default();
        waiting.extend(notices);
        Self { name, socket, drops: DropCounter::default(), notices: waiting }
    }
}

impl<S: Read + Write + AsFd + Send> Port for Stream<S> {
    fn name(&self) -> &str {
        &self.name
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        vec![Readiness::of(&self.socket)]
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        let mut buffer = [0; CHUNK];
        match self.socket.read(&mut buffer) {
            Ok(0) => return Err(PortError::Lost(self.name.clone())),
            Ok(length) => characters.extend(buffer.iter().take(length).map(|octet| Character::Octet(*octet))),
            Err(error) if is_temporary(&error) => {}
            Err(_) => return Err(PortError::Lost(self.name.clone())),
        }
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        let taken = write_now(&mut self.socket, octets).ok_or_else(|| PortError::Lost(self.name.clone()))?;
        self.notices.extend(self.drops.sent(&self.name, octets.len(), taken));
        Ok(())
    }

    fn next_notice(&mut self) -> Option<Notice> {
        self.notices.next()
    }
}

/// The number of `octets` that the other side takes now. `None` if the connection is closed.
pub(super) fn write_now(socket: &mut impl Write, octets: &[u8]) -> Option<usize> {
    match socket.write(octets) {
        Ok(taken) => Some(taken),
        Err(error) => is_temporary(&error).then_some(0),
    }
}

/// Whether the operation would succeed later.
pub(super) fn is_temporary(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
