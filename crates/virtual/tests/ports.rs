//! Ports transfer every octet, survive closing and opening of the other side, and report errors in one sentence.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_dp::link::Baud;
use profivac_host::port::{Character, Port, PortError, Pty, Serial, TcpClient, TcpServer};
use profivac_virtual::open;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::termios::{LocalModes, OptionalActions, SpecialCodeIndex, Termios, tcgetattr, tcsetattr};
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

const BAUD: Baud = Baud::B19200;

/// The longest wait of a test. It waits for octets only, never for time to pass.
const DEADLINE: Timespec = Timespec { tv_sec: 10, tv_nsec: 0 };

fn folder() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line");
    (folder, path)
}

fn serial(path: &std::path::Path) -> Result<Serial, PortError> {
    Serial::open(path.to_str().unwrap(), BAUD)
}

/// Waits until the port is readable and lets it receive.
fn turn(port: &mut dyn Port, heard: &mut Vec<Character>) -> Result<(), PortError> {
    let sources = port.readiness();
    let mut events: Vec<_> = sources.iter().map(|source| PollFd::new(source, PollFlags::IN)).collect();
    assert!(poll(&mut events, Some(&DEADLINE)).unwrap() > 0, "nothing came");
    drop(events);
    port.receive(heard)
}

fn hear(port: &mut dyn Port, count: usize) -> Vec<u8> {
    let mut heard = Vec::new();
    while heard.len() < count {
        turn(port, &mut heard).unwrap();
    }
    let octet = |character: Character| match character {
        Character::Octet(octet) => octet,
        Character::Error => panic!("a broken character"),
    };
    heard.into_iter().map(octet).collect()
}

fn all_octets() -> Vec<u8> {
    (0..=255).collect()
}

#[test]
fn every_octet_passes_a_pty_both_ways() {
    let (_folder, path) = folder();
    let mut ours = Pty::create(&path).unwrap();
    let mut theirs = serial(&path).unwrap();
    theirs.send(&all_octets()).unwrap();
    assert_eq!(hear(&mut ours, 256), all_octets());
    ours.send(&all_octets()).unwrap();
    assert_eq!(hear(&mut theirs, 256), all_octets());
}

#[test]
fn the_slave_side_of_a_pty_may_be_closed_and_opened_again() {
    let (_folder, path) = folder();
    let mut ours = Pty::create(&path).unwrap();
    for round in 0..5 {
        let mut theirs = serial(&path).unwrap();
        theirs.send(&[round]).unwrap();
        assert_eq!(hear(&mut ours, 1), [round]);
        ours.send(&[!round]).unwrap();
        assert_eq!(hear(&mut theirs, 1), [!round]);
    }
}

#[test]
fn a_program_does_not_read_the_octets_sent_to_another() {
    let (_folder, path) = folder();
    let mut ours = Pty::create(&path).unwrap();
    // Opened as a plain file, so that only the pty itself can discard unread octets.
    let first = fs::OpenOptions::new().read(true).write(true).open(&path).unwrap();
    ours.send(b"for the first").unwrap();
    drop(first);
    ours.receive(&mut Vec::new()).unwrap();
    ours.send(b"dropped").unwrap();
    let mut second = fs::OpenOptions::new().read(true).write(true).open(&path).unwrap();
    ours.send(b"!").unwrap();
    let mut read = [0; 8];
    assert_eq!(std::io::Read::read(&mut second, &mut read).unwrap(), 1);
    assert_eq!(read[0], b'!');
}

#[test]
fn between_two_programs_a_pty_becomes_raw_again_and_a_raw_one_is_not_changed() {
    let (_folder, path) = folder();
    let mut ours = Pty::create(&path).unwrap();
    let mut after = |change: fn(&mut Termios)| {
        let program = fs::OpenOptions::new().read(true).write(true).open(&path).unwrap();
        ours.receive(&mut Vec::new()).unwrap();
        let mut settings = tcgetattr(&program).unwrap();
        change(&mut settings);
        tcsetattr(&program, OptionalActions::Now, &settings).unwrap();
        drop(program);
        ours.receive(&mut Vec::new()).unwrap();
        tcgetattr(fs::File::open(&path).unwrap()).unwrap()
    };
    let settings = after(|settings| settings.special_codes[SpecialCodeIndex::VMIN] = 0);
    assert_eq!(settings.special_codes[SpecialCodeIndex::VMIN], 0);
    let settings = after(|settings| settings.local_modes |= LocalModes::ECHO);
    assert!(!settings.local_modes.contains(LocalModes::ECHO));
}

#[test]
fn unread_octets_are_dropped_and_do_not_block() {
    let (_folder, path) = folder();
    let mut ours = Pty::create(&path).unwrap();
    let _theirs = serial(&path).unwrap();
    ours.receive(&mut Vec::new()).unwrap();
    for _ in 0..10_000 {
        ours.send(&[0; 255]).unwrap();
    }
}

#[test]
fn a_pty_exists_as_long_as_its_server() {
    let (_folder, path) = folder();
    let ours = Pty::create(&path).unwrap();
    let mut theirs = serial(&path).unwrap();
    drop(ours);
    assert!(!path.is_symlink());
    let lost = turn(&mut theirs, &mut Vec::new());
    assert!(matches!(lost, Err(PortError::Lost(_))), "{lost:?}");
}

#[test]
fn a_link_that_leads_nowhere_is_replaced_and_anything_else_is_kept() {
    let (_folder, path) = folder();
    std::os::unix::fs::symlink("/nowhere/at/all", &path).unwrap();
    drop(Pty::create(&path).unwrap());
    // The number of a closed pty. It is held open, otherwise a pty of another test may get the number.
    let other = path.with_file_name("other");
    let gone = Pty::create(&other).unwrap();
    let _kept = serial(&other).unwrap();
    std::os::unix::fs::symlink(fs::read_link(&other).unwrap(), &path).unwrap();
    drop(gone);
    drop(Pty::create(&path).unwrap());
    fs::write(&path, "precious").unwrap();
    assert!(matches!(Pty::create(&path), Err(PortError::AlreadyExists(_))));
    assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
}

#[test]
fn two_servers_do_not_share_a_path() {
    let (_folder, path) = folder();
    let first = Pty::create(&path).unwrap();
    assert!(matches!(Pty::create(&path), Err(PortError::AlreadyExists(_))));
    drop(first);
    Pty::create(&path).unwrap();
}

#[test]
fn a_serial_port_belongs_to_one_program() {
    let (_folder, path) = folder();
    let _ours = Pty::create(&path).unwrap();
    let first = serial(&path).unwrap();
    let second = serial(&path);
    assert!(matches!(second, Err(PortError::InUse(_))), "{second:?}");
    drop(first);
    serial(&path).unwrap();
}

#[test]
fn a_missing_path_and_a_file_that_is_no_serial_port_are_different_errors() {
    let (folder, path) = folder();
    assert!(matches!(serial(&path), Err(PortError::NotFound(_))));
    fs::write(&path, "").unwrap();
    assert!(matches!(serial(&path), Err(PortError::NotSerial(_))));
    assert!(matches!(serial(folder.path()), Err(PortError::NotSerial(_))));
    assert!(matches!(Pty::create(&folder.path().join("no/line")), Err(PortError::NotCreatable { .. })));
}

#[test]
fn tcp_clients_share_one_line() {
    let mut server = TcpServer::listen("127.0.0.1:0").unwrap();
    let name = format!("tcp://{}", server.name());
    let mut first = open::port(&name, BAUD).unwrap();
    let mut second = open::port(&name, BAUD).unwrap();
    second.send(b"I am here").unwrap();
    assert_eq!(hear(&mut server, 9), b"I am here");
    assert_eq!(hear(&mut *first, 9), b"I am here");
    first.send(b"so am I").unwrap();
    assert_eq!(hear(&mut server, 7), b"so am I");
    assert_eq!(hear(&mut *second, 7), b"so am I");
    server.send(b"welcome").unwrap();
    assert_eq!(hear(&mut *first, 7), b"welcome");
    assert_eq!(hear(&mut *second, 7), b"welcome");
}

#[test]
fn a_tcp_line_outlives_its_clients_and_a_client_is_lost_with_the_line() {
    let mut server = TcpServer::listen("127.0.0.1:0").unwrap();
    let address = server.name().to_owned();
    drop(TcpClient::connect(&address).unwrap());
    let mut client = TcpClient::connect(&address).unwrap();
    client.send(b"next").unwrap();
    assert_eq!(hear(&mut server, 4), b"next");
    drop(server);
    let lost = turn(&mut client, &mut Vec::new());
    assert!(matches!(lost, Err(PortError::Lost(_))), "{lost:?}");
    assert!(matches!(TcpClient::connect(&address), Err(PortError::NotFound(_))));
}

#[test]
fn tcp_addresses_are_checked() {
    for address in ["", "here", ":7", "127.0.0.1:port", "127.0.0.1:70000"] {
        assert!(matches!(TcpServer::listen(address), Err(PortError::InvalidAddress(_))), "{address}");
        assert!(matches!(TcpClient::connect(address), Err(PortError::InvalidAddress(_))), "{address}");
    }
    let server = TcpServer::listen("127.0.0.1:0").unwrap();
    assert!(matches!(TcpServer::listen(server.name()), Err(PortError::AddressInUse(_))));
}
