//! Ports that are lost and opened again, and ports that are in use: the errors, the retained settings, the dropped octets.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::until::pause;
use profivac_dp::link::Baud;
use profivac_dp::master::services;
use profivac_host::port::{Character, Delivery, Notice, Port, PortError, Pty, Reopening, Serial, TcpClient, TcpServer};
use profivac_host::segment::Segment;
use profivac_host::session::{BusSession, Reply, bus_parameters};
use profivac_virtual::open;
use profivac_virtual::segment_file::SegmentFile;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::sockopt::{socket_keepalive, tcp_keepidle, tcp_nodelay, tcp_user_timeout};
use rustix::net::{AddressFamily, SocketType};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;

const BAUD: Baud = Baud::B19200;

/// The longest wait of a test. It waits for events only, never for time to pass.
const DEADLINE: Timespec = Timespec { tv_sec: 30, tv_nsec: 0 };

fn folder() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line");
    (folder, path)
}

/// Waits until the port is readable and lets it receive.
fn turn(port: &mut dyn Port, heard: &mut Vec<Character>) {
    let sources = port.readiness();
    let mut events: Vec<_> = sources.iter().map(|source| PollFd::new(source, PollFlags::IN)).collect();
    assert!(poll(&mut events, Some(&DEADLINE)).unwrap() > 0, "nothing came");
    drop(events);
    port.receive(heard).unwrap();
}

/// Serves the port until it has a notice.
fn next_notice(port: &mut dyn Port) -> Notice {
    loop {
        if let Some(notice) = port.next_notice() {
            return notice;
        }
        turn(port, &mut Vec::new());
    }
}

fn hear(port: &mut dyn Port, octets: &[u8]) {
    let mut heard = Vec::new();
    while heard.len() < octets.len() {
        turn(port, &mut heard);
    }
    assert_eq!(heard, octets.iter().map(|octet| Character::Octet(*octet)).collect::<Vec<_>>());
}

fn reopening(name: &str) -> Reopening {
    Reopening::new(open::port(name, BAUD).unwrap(), open::opener(name, BAUD))
}

/// A port is lost with one server and opened again with the next, twice.
fn goes_and_comes_back<S: Port>(name: &str, first: S, serve: impl Fn() -> S) {
    let mut port = reopening(name);
    let mut server = Some(first);
    for round in 1..=2 {
        drop(server.take());
        assert_eq!(next_notice(&mut port), Notice::Lost(name.to_owned()));
        port.send(b"dropped").unwrap();
        let server = server.insert(serve());
        assert_eq!(next_notice(&mut port), Notice::Reopened(name.to_owned()));
        assert_eq!(port.generation(), round);
        port.send(b"here again").unwrap();
        hear(server, b"here again");
        server.send(b"so am I").unwrap();
        hear(&mut port, b"so am I");
    }
}

#[test]
fn a_lost_pty_is_opened_again() {
    let (_folder, path) = folder();
    let serve = || Pty::create(&path).unwrap();
    goes_and_comes_back(path.to_str().unwrap(), serve(), serve);
}

#[test]
fn a_lost_tcp_server_is_connected_again() {
    let first = TcpServer::listen("127.0.0.1:0").unwrap();
    let address = first.name().to_owned();
    goes_and_comes_back(&format!("tcp://{address}"), first, || TcpServer::listen(&address).unwrap());
}

#[test]
fn the_search_for_a_port_ends_when_the_port_is_dropped() {
    let (_folder, path) = folder();
    let (name, server) = (path.to_str().unwrap(), Pty::create(&path).unwrap());
    let opener = open::opener(name, BAUD);
    let mut port = Reopening::new(open::port(name, BAUD).unwrap(), Arc::clone(&opener));
    drop(server);
    assert_eq!(next_notice(&mut port), Notice::Lost(name.to_owned()));
    assert!(Arc::strong_count(&opener) > 2, "it is looked for");
    drop(port);
    let begun = Instant::now();
    while Arc::strong_count(&opener) > 1 {
        assert!(begun.elapsed() < Duration::from_secs(30), "it is still looked for");
        pause();
    }
}

/// The virtual gauge at address 5 behind a pty at `path`, served by a thread until `stop` is set.
fn gauge(path: &Path, stop: Receiver<()>) -> JoinHandle<()> {
    let mut pty = Pty::create(path).unwrap();
    std::thread::spawn(move || {
        let file = SegmentFile::parse("devices = [\"bcg450@5\"]", Path::new("bench.toml")).unwrap();
        let mut devices = file.run().unwrap();
        let mut characters = Vec::new();
        while stop.try_recv() == Err(TryRecvError::Empty) {
            let watched = [pty.readiness(), devices.readiness()].concat();
            profivac_host::readiness::wait(&watched, Duration::from_millis(50)).unwrap();
            pass(&mut pty, &mut devices, &mut characters);
            pass(&mut devices, &mut pty, &mut characters);
        }
    })
}

fn pass(from: &mut dyn Port, to: &mut dyn Port, characters: &mut Vec<Character>) {
    characters.clear();
    from.receive(characters).unwrap();
    let octets: Vec<_> = characters
        .iter()
        .filter_map(|character| match character {
            Character::Octet(octet) => Some(*octet),
            Character::Error => None,
        })
        .collect();
    if !octets.is_empty() {
        to.send(&octets).unwrap();
    }
}

#[test]
fn a_master_starts_again_when_its_port_was_reopened() {
    let (_folder, path) = folder();
    let name = path.to_str().unwrap();
    let (stop, stopped) = channel();
    let server = gauge(&path, stopped);
    let bus = bus_parameters(2, BAUD, Delivery::Unpaced);
    let session = BusSession::new(open::port(name, BAUD).unwrap(), BAUD, bus, Duration::from_secs(30)).unwrap();
    let mut session = session.with_reopening(open::opener(name, BAUD));
    let answers =
        |session: &mut BusSession| matches!(session.request(&services::fdl_status(5)).unwrap(), Reply::Answer { .. });
    let insist = |session: &mut BusSession| {
        let begun = Instant::now();
        while !answers(session) {
            assert!(begun.elapsed() < Duration::from_secs(30), "no answer");
        }
    };
    insist(&mut session);
    drop(stop);
    server.join().unwrap();
    assert!(!answers(&mut session), "no device answers");
    assert_eq!(session.next_notice(), Some(Notice::Lost(name.to_owned())));
    let (_stop, stopped) = channel();
    let _server = gauge(&path, stopped);
    insist(&mut session);
    assert_eq!(session.next_notice(), Some(Notice::Reopened(name.to_owned())));
}

#[test]
fn a_lost_port_without_an_opener_ends_the_session() {
    let (_folder, path) = folder();
    let server = Pty::create(&path).unwrap();
    let port = open::port(path.to_str().unwrap(), BAUD).unwrap();
    let mut segment = Segment::new(port, BAUD, false, Vec::<profivac_virtual::device::VirtualDevice>::new());
    drop(server);
    let lost = segment.serve(&[], Duration::from_secs(30)).unwrap_err();
    assert_eq!(lost.to_string(), format!("lost {}: it was unplugged, or its other side was closed", path.display()));
}

#[test]
fn the_error_of_a_locked_device_tells_how_to_find_the_other_program() {
    let (_folder, path) = folder();
    let _server = Pty::create(&path).unwrap();
    let name = path.to_str().unwrap();
    // flock, as profivac and picocom use it.
    let _first = Serial::open(name, BAUD).unwrap();
    let refused = Serial::open(name, BAUD).unwrap_err();
    let sentence =
        format!("{name} is in use by another program: end that program first; `fuser -v`, as root, names it");
    assert_eq!(refused.to_string(), sentence);
}

/// TIOCEXCL, as minicom and pyserial use it. The kernel keeps it when its program is killed, so `fuser` may name no program.
#[test]
fn the_error_of_a_locked_pty_tells_what_to_do_also_when_no_program_has_it_open() {
    let (_folder, path) = folder();
    let _server = Pty::create(&path).unwrap();
    let name = path.to_str().unwrap();
    let other = rustix::fs::open(&path, rustix::fs::OFlags::RDWR | rustix::fs::OFlags::NOCTTY, 0.into()).unwrap();
    rustix::termios::ioctl_tiocexcl(&other).unwrap();
    drop(other);
    become_an_ordinary_user();
    let refused = Serial::open(name, BAUD).unwrap_err();
    let sentence = format!(
        "{name} is locked by another program: end the program that `fuser -v`, as root, names; if it names none, a signal ended that \
         program: start the program that serves the pty again"
    );
    assert_eq!(refused.to_string(), sentence);
}

/// Takes CAP_SYS_ADMIN from this thread, if it has it: a privileged process can open a locked terminal.
fn become_an_ordinary_user() {
    use rustix::thread::{CapabilitySet, capabilities, set_capabilities};
    let mut sets = capabilities(None).unwrap();
    sets.effective -= CapabilitySet::SYS_ADMIN;
    set_capabilities(None, sets).unwrap();
}

#[test]
fn a_client_that_does_not_read_delays_no_other_client_and_causes_a_notice() {
    let mut server = TcpServer::listen("127.0.0.1:0").unwrap();
    let deaf = TcpStream::connect(server.name()).unwrap();
    let mut client = TcpClient::connect(server.name()).unwrap();
    client.send(b"I read").unwrap();
    hear(&mut server, b"I read");
    let telegram = [0x55; 249];
    let mut told = None;
    for _ in 0..100_000 {
        server.send(&telegram).unwrap();
        hear(&mut client, &telegram);
        told = server.next_notice();
        if told.is_some() {
            break;
        }
    }
    let Some(Notice::OctetsDropped { name, octets: 1..=249 }) = told else { panic!("{told:?}") };
    assert_eq!(name, format!("tcp://{}", deaf.local_addr().unwrap()));
    server.send(&telegram).unwrap();
    hear(&mut client, &telegram);
    assert_eq!(server.next_notice(), None, "told once");
}

#[test]
fn a_server_that_does_not_read_does_not_block_and_causes_a_notice() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let mut client = TcpClient::connect(&listener.local_addr().unwrap().to_string()).unwrap();
    let _deaf = listener.accept().unwrap();
    let mut told = None;
    for _ in 0..100_000 {
        client.send(&[0x55; 249]).unwrap();
        told = client.next_notice();
        if told.is_some() {
            break;
        }
    }
    assert!(matches!(told, Some(Notice::OctetsDropped { octets: 1..=249, .. })), "{told:?}");
}

#[test]
fn unread_octets_of_a_pty_cause_a_notice() {
    let (_folder, path) = folder();
    let mut server = Pty::create(&path).unwrap();
    let _deaf = Serial::open(path.to_str().unwrap(), BAUD).unwrap();
    server.receive(&mut Vec::new()).unwrap();
    let told = (0..10_000).find_map(|_| {
        server.send(&[0x55; 249]).unwrap();
        server.next_notice()
    });
    assert!(matches!(told, Some(Notice::OctetsDropped { .. })), "{told:?}");
}

#[test]
fn a_connection_has_no_delay_and_keepalive() {
    let mut server = TcpServer::listen("127.0.0.1:0").unwrap();
    let client = TcpClient::connect(server.name()).unwrap();
    turn(&mut server, &mut Vec::new());
    for socket in [client.readiness()[0], server.readiness()[1]] {
        assert!(tcp_nodelay(socket).unwrap() && socket_keepalive(socket).unwrap());
        assert!(tcp_keepidle(socket).unwrap() < Duration::from_secs(60), "the system waits for two hours");
        assert!(
            (1..60_000).contains(&tcp_user_timeout(socket).unwrap()),
            "the system repeats for a quarter of an hour"
        );
    }
}

#[test]
fn a_host_that_does_not_answer_is_given_up_in_seconds() {
    // A listener with a full queue leaves further connections pending.
    let listener = rustix::net::socket(AddressFamily::INET, SocketType::STREAM, None).unwrap();
    rustix::net::bind(&listener, &SocketAddr::from(([127, 0, 0, 1], 0))).unwrap();
    rustix::net::listen(&listener, 0).unwrap();
    let address = SocketAddr::try_from(rustix::net::getsockname(&listener).unwrap()).unwrap();
    let _first = TcpStream::connect(address).unwrap();
    let refused = TcpClient::connect(&address.to_string()).unwrap_err().to_string();
    assert!(refused.starts_with(&format!("tcp://{address} does not answer within 3 s")), "{refused}");
}

#[test]
fn the_error_names_a_host_without_an_address() {
    // Longer than a host name may be: no request leaves the machine.
    let address = format!("{}:4000", "h".repeat(300));
    let refused = TcpClient::connect(&address).unwrap_err();
    assert!(matches!(refused, PortError::UnresolvedHost { .. }), "{refused:?}");
    assert!(refused.to_string().starts_with(&format!("tcp://{address}: the name of the host cannot be resolved")));
}

#[test]
fn an_ipv6_address_is_written_in_brackets() {
    for address in ["::1:4000", "[::1:4000", "fe80::1:4000"] {
        let refused = TcpClient::connect(address).unwrap_err().to_string();
        assert!(refused.ends_with("(an IPv6 address in brackets: [::1]:4000)"), "{refused}");
    }
    let mut server = TcpServer::listen("[::1]:0").unwrap();
    assert!(server.name().starts_with("[::1]:"));
    let mut client = open::port(&format!("tcp://{}", server.name()), BAUD).unwrap();
    client.send(b"six").unwrap();
    hear(&mut server, b"six");
}

#[test]
fn only_a_port_with_a_baud_rate_can_search_it() {
    let (_folder, path) = folder();
    let _pty = Pty::create(&path).unwrap();
    let server = TcpServer::listen("127.0.0.1:0").unwrap();
    for name in [path.to_str().unwrap(), &format!("tcp://{}", server.name())] {
        let refused = profivac_host::rate::detect(&mut *open::port(name, BAUD).unwrap()).unwrap_err();
        assert!(matches!(refused, PortError::NoBaudRate(_)), "{refused:?}");
    }
}
