//! How the system finds out that the other side of a silent connection has disappeared.

use rustix::fd::AsFd;
use std::io;
use std::time::Duration;

/// When the system asks a silent peer whether it still exists, and how long it waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeepAlive {
    /// The silence before the first question.
    pub after: Duration,
    /// The time between two questions.
    pub period: Duration,
    /// The number of questions without an answer after which the connection is lost. Windows always asks ten times.
    pub count: u32,
}

impl KeepAlive {
    /// Sets it on a TCP connection.
    ///
    /// # Errors
    /// Of the operating system.
    #[cfg(not(windows))]
    pub fn set(self, socket: &impl AsFd) -> io::Result<()> {
        use rustix::net::sockopt::{set_socket_keepalive, set_tcp_keepcnt, set_tcp_keepidle, set_tcp_keepintvl};
        set_socket_keepalive(socket, true)?;
        set_tcp_keepidle(socket, self.after)?;
        set_tcp_keepintvl(socket, self.period)?;
        Ok(set_tcp_keepcnt(socket, self.count)?)
    }

    /// Sets it on a TCP connection.
    ///
    /// # Errors
    /// Of the operating system.
    #[cfg(windows)]
    pub fn set(self, socket: &impl AsFd) -> io::Result<()> {
        let times = socket2::TcpKeepalive::new().with_time(self.after).with_interval(self.period);
        socket2::SockRef::from(&socket.as_fd()).set_tcp_keepalive(&times)
    }
}
