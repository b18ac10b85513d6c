//! Searches and beacons.

use crate::connection::{Broken, Shared};
use crate::database::World;
use crate::pva::source::Source;
use crate::pva::wire::{self, Reader, Writer, command, put};
use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;
use tokio::net::UdpSocket;
use tokio::time::sleep;

/// The number of a server that is new at each start, so that clients notice it.
pub type Guid = [u8; 12];

/// The largest datagram, in octets.
const MAX_DATAGRAM: usize = 65_507;

/// The most names of a datagram that are looked up. chosen: more than fit into an Ethernet frame.
const MAX_NAMES: u16 = 200;

/// The most messages of a datagram that are read.
const MAX_MESSAGES: usize = 8;

/// The client asks for an answer although a name is not here: it lists servers.
const REPLY_REQUIRED: u8 = 1;

/// The time between beacons at first and later (protocol specification, "beacons").
const FIRST_BEACON: Duration = Duration::from_secs(1);
const LAST_BEACON: Duration = Duration::from_secs(15);
const FIRST_BEACONS: u8 = 10;

/// A search.
struct Search {
    sequence: u32,
    is_reply_required: bool,
    /// The port to which the answer goes.
    port: u16,
    found: Vec<u32>,
}

fn search(mut payload: Reader, world: &World) -> Result<Search, Broken> {
    let (sequence, flags) = (payload.word()?, payload.octet()?);
    payload.take(3)?;
    // The answer goes to the sender: a foreign address here would let anybody direct answers at it.
    payload.take(16)?;
    let port = payload.half()?;
    let mut speaks_tcp = false;
    let protocols = payload.size()?;
    for _ in 0..protocols {
        speaks_tcp |= payload.text()? == "tcp";
    }
    let count = payload.half()?.min(MAX_NAMES);
    let mut found = Vec::new();
    for _ in 0..count {
        let id = payload.word()?;
        if Source::named(payload.text()?, world).is_some() && speaks_tcp {
            found.push(id);
        }
    }
    Ok(Search { sequence, is_reply_required: flags & REPLY_REQUIRED != 0, port, found })
}

/// Appends the answer to a search.
fn put_answer(out: &mut Vec<u8>, search: &Search, guid: Guid, port: u16) {
    let mut answer = Writer::default();
    answer.0.extend(guid);
    answer.word(search.sequence);
    put_own_address(&mut answer, port);
    answer.text("tcp");
    answer.octet(u8::from(!search.found.is_empty()));
    answer.half(u16::try_from(search.found.len()).unwrap_or_default());
    search.found.iter().for_each(|id| answer.word(*id));
    put(out, command::SEARCH_RESPONSE, &answer);
}

/// No address, which stands for the one from which this comes, and the port of the circuits.
fn put_own_address(out: &mut Writer, port: u16) {
    out.0.extend([0; 16]);
    out.half(port);
}

/// The answer to a search over a circuit, for name servers.
///
/// # Errors
/// The message is malformed.
pub fn answer_on_circuit(
    payload: Reader,
    world: &World,
    guid: Guid,
    port: u16,
    out: &mut Vec<u8>,
) -> Result<(), Broken> {
    let search = search(payload, world)?;
    if !search.found.is_empty() || search.is_reply_required {
        put_answer(out, &search, guid, port);
    }
    Ok(())
}

/// The answers to the searches in a datagram, and the port of the client to which they go.
#[must_use]
pub fn answer(datagram: &[u8], world: &World, guid: Guid, port: u16) -> Option<(Vec<u8>, u16)> {
    let mut out = Vec::new();
    let mut client_port = 0;
    let mut rest = datagram;
    for _ in 0..MAX_MESSAGES {
        let Ok(Some(message)) = wire::parse(rest) else { break };
        rest = rest.get(message.used..).unwrap_or_default();
        if message.command != Some(command::SEARCH) {
            continue;
        }
        let Ok(search) = search(message.payload, world) else { break };
        if !search.found.is_empty() || search.is_reply_required {
            client_port = search.port;
            put_answer(&mut out, &search, guid, port);
        }
    }
    (!out.is_empty()).then_some((out, client_port))
}

/// Answers searches until the gateway stops.
pub async fn serve(socket: UdpSocket, guid: Guid, port: u16, shared: Shared) {
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
        if let Some((octets, client_port)) = answer(buffer.get(..size).unwrap_or_default(), &world, guid, port) {
            // A full send buffer loses the answer; the client searches again. Who waited here for one client would answer no other one.
            socket.try_send_to(&octets, SocketAddr::new(client.ip(), client_port)).ok();
        }
    }
}

/// A beacon.
#[must_use]
pub fn beacon(guid: Guid, sequence: u8, port: u16) -> Vec<u8> {
    let mut beacon = Writer::default();
    beacon.0.extend(guid);
    beacon.octet(0);
    beacon.octet(sequence);
    // The list of names does not change while the server runs with this number.
    beacon.half(0);
    put_own_address(&mut beacon, port);
    beacon.text("tcp");
    // No state of the server follows: the type "none".
    beacon.octet(0xFF);
    let mut out = Vec::new();
    put(&mut out, command::BEACON, &beacon);
    out
}

/// Sends beacons until the gateway stops.
pub async fn beacons(socket: UdpSocket, to: (Ipv4Addr, u16), guid: Guid, port: u16, shared: Shared) {
    let mut stop = shared.stop.clone();
    let mut sequence = 0_u8;
    let mut early = FIRST_BEACONS;
    loop {
        // The first beacon has to wait until the runtime has seen that the new socket is writable.
        let beacon = beacon(guid, sequence, port);
        tokio::select! {
            sent = socket.send_to(&beacon, SocketAddr::from(to)) => drop(sent),
            () = stop.stopped() => return,
        }
        sequence = sequence.wrapping_add(1);
        early = early.saturating_sub(1);
        tokio::select! {
            () = sleep(if early > 0 { FIRST_BEACON } else { LAST_BEACON }) => {}
            () = stop.stopped() => return,
        }
    }
}
