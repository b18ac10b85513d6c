//! Sockets: what EPICS expects of them beyond the standard library.

use profivac_station::config::gateways::epics::Interface;
use rustix::net::sockopt::{
    set_socket_broadcast, set_socket_keepalive, set_socket_reuseaddr, set_tcp_keepcnt, set_tcp_keepidle,
    set_tcp_keepintvl,
};
use rustix::net::{AddressFamily, SocketFlags, SocketType, bind, socket_with};
use std::io;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream, UdpSocket};

/// When the system asks a silent client whether it still exists, how often, and how long it waits.
const KEEPALIVE_AFTER: Duration = Duration::from_secs(60);
const KEEPALIVE_PERIOD: Duration = Duration::from_secs(15);
const KEEPALIVE_COUNT: u32 = 4;

/// A socket for searches. Several servers of one computer share the port, as EPICS servers do, so that each of them hears a broadcast.
///
/// # Errors
/// Of the operating system.
pub fn search_socket(address: Ipv4Addr, port: u16) -> io::Result<UdpSocket> {
    let socket =
        socket_with(AddressFamily::INET, SocketType::DGRAM, SocketFlags::CLOEXEC | SocketFlags::NONBLOCK, None)?;
    set_socket_reuseaddr(&socket, true)?;
    set_socket_broadcast(&socket, true)?;
    bind(&socket, &SocketAddrV4::new(address, port))?;
    UdpSocket::from_std(socket.into())
}

/// A listener for circuits. If another server of this computer has the port, a free one is taken: the answer to a search names it.
///
/// # Errors
/// Of the operating system.
pub async fn circuit_listener(address: Ipv4Addr, port: u16) -> io::Result<TcpListener> {
    match TcpListener::bind((address, port)).await {
        Err(error) if error.kind() == io::ErrorKind::AddrInUse => TcpListener::bind((address, 0)).await,
        bound => bound,
    }
}

/// Lets the system find out that a client has disappeared.
///
/// # Errors
/// Of the operating system.
pub fn keep_alive(stream: &TcpStream) -> io::Result<()> {
    set_socket_keepalive(stream, true)?;
    set_tcp_keepidle(stream, KEEPALIVE_AFTER)?;
    set_tcp_keepintvl(stream, KEEPALIVE_PERIOD)?;
    set_tcp_keepcnt(stream, KEEPALIVE_COUNT)?;
    stream.set_nodelay(true)
}

/// Where the beacons of an interface go.
#[must_use]
pub fn beacon_address(interface: &Interface) -> Ipv4Addr {
    match interface.broadcast {
        Some(broadcast) => broadcast,
        None if interface.address.is_unspecified() => Ipv4Addr::BROADCAST,
        None => interface.address,
    }
}
