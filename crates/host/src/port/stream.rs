//! Octets over a socket: the client side of a TCP connection, and the port of a segment in memory.

use super::doubled_ff::{DoubledFf, Verdict};
use super::notice::{DropCounter, Notice, Notices};
use super::server::{Connection, words};
use super::{CHUNK, Character, Port, PortError};
use crate::readiness::Readiness;
use rustix::fd::AsFd;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// A connected socket that does not block.
#[derive(Debug)]
pub struct Stream<S> {
    name: String,
    socket: S,
    drops: DropCounter,
    notices: Notices,
    /// The first octets, until they show whether a server greets; `None` behind them.
    greeting: Option<Vec<u8>>,
    /// The octets, until they show whether a server sends FF twice; `None` behind them.
    doubled: Option<DoubledFf>,
}

impl<S> Stream<S> {
    /// Octets over `socket`, which must not block, with the notices that exist already.
    pub fn new(name: String, socket: S, notices: Vec<Notice>) -> Self {
        let mut waiting = Notices::default();
        waiting.extend(notices);
        Self { name, socket, drops: DropCounter::default(), notices: waiting, greeting: None, doubled: None }
    }

    /// Examines the first octets for the greeting of a server that does not pass octets alone, and all octets for an FF that it doubles.
    pub(super) fn examined(self) -> Self {
        Self { greeting: Some(Vec::new()), doubled: Some(DoubledFf::default()), ..self }
    }

    /// Examines the next octets until they show what the server sends.
    fn examine(&mut self, octets: &[u8]) {
        self.examine_greeting(octets);
        match self.doubled.as_mut().map(|doubled| doubled.examine(octets)) {
            None | Some(Verdict::Open) => {}
            Some(Verdict::Raw) => self.doubled = None,
            Some(Verdict::Doubled) => {
                self.doubled = None;
                self.notices.extend([Notice::DoubledFf(self.name.clone())]);
            }
        }
    }

    fn examine_greeting(&mut self, octets: &[u8]) {
        let Some(mut seen) = self.greeting.take() else { return };
        seen.extend(octets.iter().take(GREETING_OCTETS.saturating_sub(seen.len())));
        match greeting(&seen, &self.name) {
            Some(notice) => self.notices.extend([notice]),
            None if seen.len() < GREETING_OCTETS => self.greeting = Some(seen),
            None => {}
        }
    }
}

impl Connection for Stream<TcpStream> {
    // chosen: a server of raw octets says nothing.
    const PATIENCE: Duration = Duration::ZERO;

    fn socket(&self) -> &TcpStream {
        &self.socket
    }

    /// The octets stay: they may be telegrams.
    fn hear(&mut self, heard: &mut Vec<u8>) -> Result<(), PortError> {
        let mut buffer = [0; GREETING_OCTETS];
        match self.socket.peek(&mut buffer) {
            Ok(0) => return Err(PortError::Lost(self.name.clone())),
            Ok(length) => *heard = buffer.get(..length).unwrap_or_default().to_vec(),
            Err(error) if is_temporary(&error) => {}
            Err(_) => return Err(PortError::Lost(self.name.clone())),
        }
        Ok(())
    }

    fn check_server(&mut self, heard: &[u8]) {
        let name = &self.name;
        let banner = || words(heard).map(|words| Notice::ServerBanner { name: name.clone(), words });
        if let Some(notice) = greeting(heard, name).or_else(banner) {
            (self.greeting, self.doubled) = (None, None);
            self.notices.extend([notice]);
        }
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
            Ok(length) => {
                let octets = buffer.get(..length).unwrap_or_default();
                self.examine(octets);
                characters.extend(octets.iter().map(|octet| Character::Octet(*octet)));
            }
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

/// The number of octets in which a greeting shows itself. chosen: a line of text; two telegrams have as many.
const GREETING_OCTETS: usize = 24;

/// The notice about a server that begins with commands of telnet or with words.
fn greeting(octets: &[u8], name: &str) -> Option<Notice> {
    // IAC, one of WILL, WONT, DO, DONT, and an option (RFC 854). No telegram begins with FF.
    if let [0xFF, 0xFB..=0xFE, 0..=50, ..] = octets {
        return Some(Notice::TelnetServer(name.to_owned()));
    }
    let is_whole = octets.len() >= GREETING_OCTETS || octets.ends_with(b"\n");
    let words = words(octets).filter(|_| is_whole)?;
    Some(Notice::ServerBanner { name: name.to_owned(), words })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_server_that_greets_is_named_and_telegrams_are_no_greeting() {
        let text = |octets: &[u8]| greeting(octets, "tcp://x:1").map(|notice| notice.to_string()).unwrap_or_default();
        let telnet = text(&[0xFF, 0xFD, 44, 0xFF, 0xFB, 0]);
        assert!(telnet.contains("telnet://x:1") && telnet.contains("rfc2217://x:1"), "{telnet}");
        let banner = text(b"ser2net port 2000 device /dev/ttyS0");
        assert!(banner.contains("'ser2net port 2000 device"), "{banner}");
        assert!(text(b"Welcome to the server\r\n").contains("Welcome"));
        for octets in [
            &[][..],
            &[0xFF, 0xFF, 0xFF],
            b"hh",
            &[0x10, 8, 2, 0x49, 0x53, 0x16].repeat(4),
            &[0x68, 5, 5, 0x68, 0x88, 0x82, 0x6D, 0x3C, 0x3E, 0xF1, 0x16].repeat(3),
            &[0xDC, 2, 2].repeat(8),
        ] {
            assert_eq!(text(octets), "", "{octets:02X?}");
        }
    }
}
