//! Searches and beacons.

use crate::ca::message::{self, Header, MINOR_VERSION, Message, command, put, put_empty};
use crate::connection::Shared;
use crate::database::World;
use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;
use tokio::net::UdpSocket;
use tokio::time::sleep;

/// The largest datagram of a client, in octets: `MAX_UDP_RECV` of EPICS base.
const MAX_DATAGRAM: usize = 65_507;

/// The largest answer: below the size of an Ethernet frame, as EPICS base sends it.
const MAX_ANSWER: usize = 1024;

/// The most names of a datagram that are looked up. chosen: more than fit into an Ethernet frame.
const MAX_NAMES: usize = 1500 / 24;

/// A client that searches over TCP and over UDP asks to be told that a name is not here.
const REPLY_IF_NOT_FOUND: u16 = 10;

/// Stands for "the address from which this comes".
const OWN_ADDRESS: u32 = u32::MAX;

/// The shortest and the longest time between two beacons; it doubles at first (`EPICS_CAS_BEACON_PERIOD`).
const FIRST_BEACON: Duration = Duration::from_millis(20);
const LAST_BEACON: Duration = Duration::from_secs(15);

/// The answer to a search over a circuit, for name servers.
pub fn answer_on_circuit(header: Header, payload: &[u8], world: &World, port: u16, out: &mut Vec<u8>) {
    let Header { data_type, count, first, second, .. } = header;
    if world.database.find(message::text(payload)).is_some() {
        put(out, found(port, second), &version());
    } else if data_type == REPLY_IF_NOT_FOUND {
        put_empty(out, command::NOT_FOUND, data_type, count, first, second);
    }
}

/// The header of the answer to the search with this number.
const fn found(port: u16, second: u32) -> Header {
    Header { command: command::SEARCH, payload: 0, data_type: port, count: 0, first: OWN_ADDRESS, second }
}

fn version() -> [u8; 8] {
    let [high, low] = MINOR_VERSION.to_be_bytes();
    [high, low, 0, 0, 0, 0, 0, 0]
}

/// The answers to the searches in a datagram; empty if none of the names is here.
#[must_use]
pub fn answer(datagram: &[u8], world: &World, port: u16) -> Vec<u8> {
    let mut out = Vec::new();
    let mut rest = datagram;
    for _ in 0..MAX_NAMES {
        let Ok(Some(Message { header, payload, used })) = message::parse(rest) else { break };
        rest = rest.get(used..).unwrap_or_default();
        let is_found = header.command == command::SEARCH && world.database.find(message::text(payload)).is_some();
        if !is_found {
            continue;
        }
        if out.is_empty() {
            put_empty(&mut out, command::VERSION, 0, MINOR_VERSION.into(), 0, 0);
        }
        put(&mut out, found(port, header.second), &version());
        if out.len() >= MAX_ANSWER {
            break;
        }
    }
    out
}

/// Answers searches until the gateway stops.
pub async fn serve(socket: UdpSocket, port: u16, shared: Shared) {
    let mut stop = shared.stop.clone();
    let mut buffer = vec![0_u8; MAX_DATAGRAM];
    loop {
        let received = tokio::select! {
            received = socket.recv_from(&mut buffer) => received,
            () = stop.stopped() => return,
        };
        // An error tells of an earlier answer that did not arrive.
        let Ok((size, client)) = received else { continue };
        let world = shared.world.borrow().clone();
        let octets = answer(buffer.get(..size).unwrap_or_default(), &world, port);
        if !octets.is_empty() {
            // A full send buffer loses the answer; the client searches again. Who waited here for one client would answer no other one.
            socket.try_send_to(&octets, client).ok();
        }
    }
}

/// A beacon.
#[must_use]
pub fn beacon(port: u16, number: u32) -> Vec<u8> {
    let mut out = Vec::new();
    put_empty(&mut out, command::BEACON, MINOR_VERSION, port.into(), number, 0);
    out
}

/// Sends beacons until the gateway stops: at first in short intervals, so that clients notice a new server at once.
pub async fn beacons(socket: UdpSocket, to: (Ipv4Addr, u16), port: u16, shared: Shared) {
    let mut stop = shared.stop.clone();
    let (mut number, mut pause) = (0_u32, FIRST_BEACON);
    loop {
        // The first beacon has to wait until the runtime has seen that the new socket is writable.
        let beacon = beacon(port, number);
        tokio::select! {
            sent = socket.send_to(&beacon, SocketAddr::from(to)) => drop(sent),
            () = stop.stopped() => return,
        }
        number = number.wrapping_add(1);
        tokio::select! {
            () = sleep(pause) => pause = pause.saturating_mul(2).min(LAST_BEACON),
            () = stop.stopped() => return,
        }
    }
}
