//! The gateway with its sockets: a station without readings serves its heartbeat.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Plant, config};
use crate::until::{TIMEOUT, until};
use profivac_gateway::ReadModel;
use profivac_gateway::thread::Context;
use profivac_gateway_epics::ca::{self, message};
use profivac_gateway_epics::connection::Shared;
use profivac_gateway_epics::pva;
use profivac_gateway_epics::socket::search_socket;
use profivac_recorder::{Recorder, Settings};
use profivac_station::services::Services;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpStream, UdpSocket};
use std::path::Path;
use std::sync::Arc;
use tokio::runtime::Builder;
use tokio::sync::watch;

fn header(command: u16, data_type: u16, count: u16, first: u32, second: u32, payload: &[u8]) -> Vec<u8> {
    let mut octets = Vec::new();
    let header = message::Header { command, payload: 0, data_type, count: count.into(), first, second };
    message::put(&mut octets, header, payload);
    octets
}

/// Reads messages until one of this command.
fn receive(stream: &mut TcpStream, command: u16) -> (message::Header, Vec<u8>) {
    let mut octets = Vec::new();
    loop {
        match message::parse(&octets).unwrap() {
            Some(it) if it.header.command == command => return (it.header, it.payload.to_vec()),
            Some(message::Message { used, .. }) => drop(octets.drain(..used)),
            None => {
                let mut octet = [0];
                stream.read_exact(&mut octet).unwrap();
                octets.extend(octet);
            }
        }
    }
}

/// A station without segments.
fn station(folder: &Path) -> (Arc<Services>, Arc<ReadModel>) {
    let path = folder.join("station.db");
    let recorder = Recorder::start(&path, Settings::default()).unwrap();
    let services = Arc::new(Services::new("hall".to_owned(), path, recorder));
    let model = Arc::new(ReadModel::start(Arc::clone(&services)).unwrap());
    (services, model)
}

/// The runtime learns later that a new socket is writable: without waiting, the first datagram is lost.
#[test]
fn the_first_beacon_of_a_new_socket_is_sent() {
    let folder = tempfile::tempdir().unwrap();
    let (services, model) = station(folder.path());
    let (context, _stop) = Context::new("epics", model, services);
    let (_worlds, world) = watch::channel(Arc::new(Plant::new("").world()));
    let shared = Shared::new(world, context.status, context.stop, None);
    let runtime = Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let receiver = tokio::net::UdpSocket::bind("127.0.0.1:0").await.unwrap();
        let to = (Ipv4Addr::LOCALHOST, receiver.local_addr().unwrap().port());
        let socket = || search_socket(Ipv4Addr::LOCALHOST, 0).unwrap();
        // The number of the beacon that comes first.
        let mut octets = [0; 128];
        tokio::select! {
            () = ca::search::beacons(socket(), to, 5064, shared.clone()) => panic!("it stopped"),
            size = receiver.recv(&mut octets) => assert_eq!(octets[..size.unwrap()], ca::search::beacon(5064, 0)),
        }
        tokio::select! {
            () = pva::search::beacons(socket(), to, [7; 12], 5075, shared) => panic!("it stopped"),
            size = receiver.recv(&mut octets) => assert_eq!(octets[..size.unwrap()], pva::search::beacon([7; 12], 0, 5075)),
        }
    });
}

#[test]
fn a_client_finds_the_heartbeat_and_monitors_it_beside_connections_that_are_silent_or_send_nonsense() {
    let folder = tempfile::tempdir().unwrap();
    let (services, model) = station(folder.path());
    let (_, settings) = config("ca-port = 0\npva-port = 0\npva-search-port = 0\nprefix = 'VAC:'");
    let gateway = profivac_gateway_epics::start(settings, model, Arc::clone(&services)).unwrap();
    let address = until("the addresses of the gateway", || {
        let view = services.gateways().views().remove(0);
        assert_eq!(view.problem, None);
        view.address
    });
    let ca = address.split(", ").find_map(|it| it.strip_prefix("ca ")).unwrap();
    let pva = address.split(", ").find_map(|it| it.strip_prefix("pva ")).unwrap();
    let search = UdpSocket::bind("127.0.0.1:0").unwrap();
    search.set_read_timeout(Some(TIMEOUT)).unwrap();
    let request = [header(0, 0, 13, 0, 0, b""), header(6, 5, 13, 3, 3, b"VAC:HEARTBEAT\0")].concat();
    search.send_to(&request, ca).unwrap();
    let mut answer = [0; 64];
    assert_eq!(search.recv(&mut answer).unwrap(), 40);
    let port = u16::from_be_bytes([answer[20], answer[21]]);
    assert_eq!(port.to_string(), ca.rsplit(':').next().unwrap());
    let silent: Vec<_> = [ca, pva].map(|address| TcpStream::connect(address).unwrap()).into();
    for address in [ca, pva] {
        let mut nonsense = TcpStream::connect(address).unwrap();
        nonsense.set_read_timeout(Some(TIMEOUT)).unwrap();
        nonsense.write_all(&[0xFF; 64]).unwrap();
        // The octets that the server sent first, and then the end of the connection.
        nonsense.read_to_end(&mut Vec::new()).ok();
    }
    let mut client = TcpStream::connect(ca).unwrap();
    client.set_read_timeout(Some(TIMEOUT)).unwrap();
    client.write_all(&header(18, 0, 0, 1, 13, b"VAC:HEARTBEAT\0")).unwrap();
    let (created, _) = receive(&mut client, 18);
    let mask = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0];
    client.write_all(&header(1, 20, 1, created.second, 7, &mask)).unwrap();
    let (update, payload) = receive(&mut client, 1);
    assert_eq!((update.first, update.second, payload.len()), (1, 7, 24));
    let view = services.gateways().views().remove(0);
    assert_eq!((view.refused, view.clients), (2, 3), "{view:?}");
    drop((silent, gateway));
    assert_eq!(client.read_to_end(&mut Vec::new()).unwrap_or_default(), 0, "the circuit ends with the gateway");
}
