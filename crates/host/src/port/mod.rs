//! Ports: where the octets of a segment come from and go to.
//!
//! | Port | Opened by | The other side |
//! |---|---|---|
//! | [`Serial`] | a device name | a line, or a pty that somebody else serves |
//! | [`Pty`] | a path that becomes a link | a program that opens the path as its serial port |
//! | [`TcpServer`] | an address to listen on | any number of clients, which share one line |
//! | [`TcpClient`] | `tcp://host:port` | a serial server, or a [`TcpServer`] |
//!
//! A port never blocks and never panics: what nobody takes is dropped, and a port that is gone says so.

mod echo;
mod marks;
mod pty;
mod serial;
mod tcp;

pub use pty::Pty;
pub use serial::Serial;
pub use tcp::{TcpClient, TcpServer};

use profivac_dp::link::Baud;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::BorrowedFd;
use rustix::io::Errno;
use std::time::Duration;

/// What a port heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Character {
    /// A character without error.
    Octet(u8),
    /// A character with a parity or framing error.
    Broken,
}

/// Why a port cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// There is nothing of this name.
    #[error("there is no port {0}")]
    Missing(String),
    /// Somebody else has it.
    #[error("{0} is in use by another program")]
    InUse(String),
    /// The user may not open it.
    #[error("no permission to open {0} (for a serial device the group is mostly dialout)")]
    Denied(String),
    /// The name stands for something that carries no octets.
    #[error("{0} is not a serial device")]
    NotSerial(String),
    /// The adapter has no such rate.
    #[error("{name} cannot run at {baud}, it offers {offered} bit/s")]
    Rate {
        /// The port.
        name: String,
        /// What was asked for.
        baud: Baud,
        /// What the driver made of it.
        offered: u32,
    },
    /// The path of a pty is taken by something else.
    #[error("{0} exists already: remove it, or stop the program that serves it")]
    Exists(String),
    /// No `HOST:PORT`.
    #[error("expected HOST:PORT, got {0:?}")]
    Address(String),
    /// It worked, and does not any more.
    #[error("lost {0}: it was unplugged, or its other side was closed")]
    Lost(String),
    /// Anything else the system says.
    #[error("{name}: {source}")]
    System {
        /// The port.
        name: String,
        /// What the system says.
        source: std::io::Error,
    },
}

impl PortError {
    /// What an error means when a port is opened.
    fn opening(name: &str, errno: Errno) -> Self {
        match errno {
            Errno::NOENT | Errno::NODEV | Errno::NXIO | Errno::NOTDIR => Self::Missing(name.to_owned()),
            Errno::BUSY | Errno::WOULDBLOCK => Self::InUse(name.to_owned()),
            Errno::ACCESS | Errno::PERM => Self::Denied(name.to_owned()),
            Errno::NOTTY | Errno::ISDIR => Self::NotSerial(name.to_owned()),
            _ => Self::system(name, errno),
        }
    }

    /// What an error means once a port was open.
    fn using(name: &str, errno: Errno) -> Self {
        match errno {
            Errno::IO | Errno::NXIO | Errno::NODEV | Errno::PIPE | Errno::CONNRESET | Errno::BADF => {
                Self::Lost(name.to_owned())
            }
            _ => Self::system(name, errno),
        }
    }

    fn system(name: &str, source: impl Into<std::io::Error>) -> Self {
        Self::System { name: name.to_owned(), source: source.into() }
    }
}

/// A port that is open.
pub trait Port: Send {
    /// The name people know it by.
    fn name(&self) -> &str;

    /// Whether octets take their time to leave. If not, they arrive as soon as they are sent.
    fn is_timed(&self) -> bool {
        false
    }

    /// The descriptors that become readable when [`receive`](Self::receive) has something to do.
    fn watched(&self) -> Vec<BorrowedFd<'_>>;

    /// Appends what has arrived to `heard`, possibly nothing.
    ///
    /// # Errors
    /// [`PortError::Lost`] when nothing will ever arrive again.
    fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError>;

    /// Sends `octets`. What nobody takes is dropped.
    ///
    /// # Errors
    /// [`PortError::Lost`] when nothing can ever be sent again.
    fn send(&mut self, octets: &[u8]) -> Result<(), PortError>;
}

/// Opens the port a person names: `tcp://host:port`, or a serial device or pty.
///
/// # Errors
/// A [`PortError`] in one sentence.
pub fn open(name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError> {
    match name.strip_prefix("tcp://") {
        Some(address) => Ok(Box::new(TcpClient::connect(address)?)),
        None => Ok(Box::new(Serial::open(name, baud)?)),
    }
}

/// Waits until something is readable, `at_most` so long, and says what is.
///
/// # Errors
/// [`PortError::System`] when the system cannot wait.
pub fn wait(watched: &[BorrowedFd<'_>], at_most: Duration) -> Result<Vec<bool>, PortError> {
    let mut events: Vec<_> = watched.iter().map(|fd| PollFd::from_borrowed_fd(*fd, PollFlags::IN)).collect();
    // A time too long for the system is as good as none.
    let timeout = Timespec::try_from(at_most).ok();
    match poll(&mut events, timeout.as_ref()) {
        Ok(_) | Err(Errno::INTR) => Ok(events.iter().map(|event| !event.revents().is_empty()).collect()),
        Err(errno) => Err(PortError::system("poll", errno)),
    }
}

/// The largest piece taken from a port at once.
const CHUNK: usize = 4096;
