//! Ports: where the octets of a segment come from and go to.
//!
//! | Port | Opened by | The other side |
//! |---|---|---|
//! | [`Serial`] | a device name | a line, or a pty that somebody else serves |
//! | [`Pty`] | a path that becomes a link | a program that opens the path as its serial port |
//! | [`TcpServer`] | an address to listen on | any number of clients, which share one line |
//! | [`TcpClient`] | `tcp://host:port` | a serial server, or a [`TcpServer`] |
//! | [`Stream`] | somebody in the same program | a segment in memory |
//! | [`Reopening`] | any of them | the same, which may go and come back |
//!
//! A port never blocks and never panics: what nobody takes is dropped, and a port that is gone says so. What works, but not
//! as it should, is a [`Remark`].

mod echo;
mod error;
mod marks;
mod notice;
mod pty;
mod reopening;
mod serial;
mod stream;
mod tcp;

#[cfg(target_os = "linux")]
#[path = "linux.rs"]
mod system;
#[cfg(not(target_os = "linux"))]
#[path = "other.rs"]
mod system;

pub use error::PortError;
pub use notice::Notice;
pub use pty::Pty;
pub use reopening::{Opener, Reopening};
pub use serial::Serial;
pub use stream::Stream;
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
    Error,
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

    /// Sends `octets`. What nobody takes is dropped, and a [`Remark::Cut`] says so.
    ///
    /// # Errors
    /// [`PortError::Lost`] when nothing can ever be sent again.
    fn send(&mut self, octets: &[u8]) -> Result<(), PortError>;

    /// Goes on at another rate.
    ///
    /// # Errors
    /// [`PortError::NoRate`] when it runs at none, [`PortError::Rate`] when it cannot run at this one.
    fn set_baud(&mut self, _baud: Baud) -> Result<(), PortError> {
        Err(PortError::NoBaudRate(self.name().to_owned()))
    }

    /// What somebody should know, the oldest first, each once.
    fn next_notice(&mut self) -> Option<Notice> {
        None
    }

    /// Changes whenever the port was lost and is back: whoever speaks on it begins anew.
    fn generation(&self) -> u32 {
        0
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
