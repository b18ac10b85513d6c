//! Octets over a socket: the client's side of a TCP connection, and the way into a segment in memory.

use super::remark::{Cuts, Remark, Remarks};
use super::{CHUNK, Character, Port, PortError};
use rustix::fd::{AsFd, BorrowedFd};
use std::io::{ErrorKind, Read, Write};

/// A connected socket that does not block.
#[derive(Debug)]
pub struct Stream<S> {
    name: String,
    socket: S,
    cuts: Cuts,
    remarks: Remarks,
}

impl<S> Stream<S> {
    /// Octets over `socket`, which must not block, and what there is to remark about it already.
    pub fn new(name: String, socket: S, remarks: Vec<Remark>) -> Self {
        let mut waiting = Remarks::default();
        waiting.extend(remarks);
        Self { name, socket, cuts: Cuts::default(), remarks: waiting }
    }
}

impl<S: Read + Write + AsFd + Send> Port for Stream<S> {
    fn name(&self) -> &str {
        &self.name
    }

    fn watched(&self) -> Vec<BorrowedFd<'_>> {
        vec![self.socket.as_fd()]
    }

    fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
        let mut buffer = [0; CHUNK];
        match self.socket.read(&mut buffer) {
            Ok(0) => return Err(PortError::Lost(self.name.clone())),
            Ok(length) => heard.extend(buffer.iter().take(length).map(|octet| Character::Octet(*octet))),
            Err(error) if is_passing(&error) => {}
            Err(_) => return Err(PortError::Lost(self.name.clone())),
        }
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        let taken = taken(&mut self.socket, octets).ok_or_else(|| PortError::Lost(self.name.clone()))?;
        self.remarks.extend(self.cuts.sent(&self.name, octets.len(), taken));
        Ok(())
    }

    fn next_remark(&mut self) -> Option<Remark> {
        self.remarks.next()
    }
}

/// How many of `octets` the other side takes now; nothing if there is no other side any more.
pub(super) fn taken(socket: &mut impl Write, octets: &[u8]) -> Option<usize> {
    match socket.write(octets) {
        Ok(taken) => Some(taken),
        Err(error) => is_passing(&error).then_some(0),
    }
}

/// Whether an error says no more than: not now.
pub(super) fn is_passing(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
