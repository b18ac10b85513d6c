//! Sockets of clients.

use profivac_host::keep_alive::KeepAlive;
use std::io;
use std::time::Duration;
use tokio::net::TcpStream;

/// When the system asks a silent client whether it still exists, how often, and how long it waits.
const KEEP_ALIVE: KeepAlive = KeepAlive { after: Duration::from_secs(60), period: Duration::from_secs(15), count: 4 };

/// Lets the system find out that a client has disappeared.
///
/// # Errors
/// Of the operating system.
pub fn keep_alive(stream: &TcpStream) -> io::Result<()> {
    KEEP_ALIVE.set(stream)?;
    stream.set_nodelay(true)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use rustix::net::sockopt::{socket_keepalive, tcp_keepcnt, tcp_keepidle, tcp_keepintvl};
    use tokio::net::TcpListener;

    #[tokio::test]
    async fn a_client_that_has_disappeared_is_found_within_two_minutes() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let stream = TcpStream::connect(listener.local_addr().unwrap()).await.unwrap();
        keep_alive(&stream).unwrap();
        let probes = tcp_keepintvl(&stream).unwrap() * tcp_keepcnt(&stream).unwrap();
        assert!(socket_keepalive(&stream).unwrap() && stream.nodelay().unwrap());
        assert!(tcp_keepidle(&stream).unwrap() + probes <= Duration::from_secs(120));
    }
}
