//! Sockets: what EPICS expects of them beyond the standard library.

use profivac_station::config::gateways::epics::Interface;
use socket2::{Domain, Socket, Type};
use std::io;
use std::net::{Ipv4Addr, SocketAddrV4};
use tokio::net::{TcpListener, UdpSocket};

/// A socket for searches. Several servers of one computer share the port, as EPICS servers do, so that each of them hears a broadcast.
///
/// # Errors
/// Of the operating system.
pub fn search_socket(address: Ipv4Addr, port: u16) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, None)?;
    socket.set_nonblocking(true)?;
    socket.set_reuse_address(true)?;
    socket.set_broadcast(true)?;
    socket.bind(&SocketAddrV4::new(address, port).into())?;
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

/// Where the beacons of an interface go.
#[must_use]
pub fn beacon_address(interface: &Interface) -> Ipv4Addr {
    match interface.broadcast {
        Some(broadcast) => broadcast,
        None if interface.address.is_unspecified() => Ipv4Addr::BROADCAST,
        None => interface.address,
    }
}
