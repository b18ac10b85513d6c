//! `scan` finds stations with their identity and owner, and changes nothing.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{End, Folder, Program, octets, run, sd2};
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::thread;
use std::time::Duration;

/// A slot time of 200 ms, in bit times, so that a loaded computer misses no answer.
const PATIENTLY: &str = "--slot-time=4000";

/// Standard output of a command that must succeed.
fn output(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn on_tcp(devices: &[&str]) -> (Program, String) {
    let program = Program::start(&[&["simulate", "--tcp", "127.0.0.1:0"], devices].concat());
    let address = program.ready();
    (program, address)
}

/// Each silent address takes 200 ms, twice.
#[test]
fn a_signal_ends_a_scan_with_exit_code_3() {
    let (_simulation, address) = on_tcp(&["bcg450@5"]);
    let mut listener = End::tcp(&address);
    let mut scan = Program::start(&["scan", "--port", &format!("tcp://{address}"), PATIENTLY]);
    while listener.receive_within(Duration::from_secs(5)).is_empty() {
        assert!(!scan.has_ended(), "it is over: {}", scan.complaint());
    }
    scan.terminate();
    assert_eq!((scan.complaint().as_str(), scan.exit_code()), ("profivac: interrupted by a signal", 3));
}

#[test]
fn the_map_shows_the_stations_that_answer() {
    let folder = Folder::new();
    let path = folder.name("line");
    let program = Program::start(&["simulate", "--pty", &path, "bcg450@5", "bcg450@12", "bcg450@126"]);
    program.ready();
    let expected = "      0 1 2 3 4 5 6 7 8 9
   0  . . . * . S . . . .
  10  . . S . . .
S slave, M master, * this master, . no station

ADDR  KIND    IDENT   OWNER     STATE                               DEVICE
   5  slave   0x08E6  none      waits for parameters, not ready     bcg450
  12  slave   0x08E6  none      waits for parameters, not ready     bcg450
";
    assert_eq!(output(&["scan", "--port", &path, PATIENTLY, "--master", "3", "--hsa", "15"]), expected);
}

#[test]
fn a_slave_at_the_address_of_the_master_is_found() {
    let folder = Folder::new();
    let path = folder.name("line");
    let program = Program::start(&["simulate", "--pty", &path, "bcg450@3", "bcg450@5"]);
    program.ready();
    let scanned = run(&["scan", "--port", &path, PATIENTLY, "--master", "3", "--hsa", "6"]);
    let (shown, said) = (String::from_utf8(scanned.stdout).unwrap(), String::from_utf8(scanned.stderr).unwrap());
    assert!(shown.contains("\n   0  . . . S . S .\n"), "{shown}");
    assert!(shown.contains("\n   3  slave   0x08E6") && shown.contains("\n   5  slave   0x08E6"), "{shown}");
    assert!(said.contains("a slave answers at address 3, which this master used"), "{said}");
    let file = folder.name("plant.toml");
    let made = run(&["init", "--port", &path, PATIENTLY, "--master", "3", "--hsa", "6", "--out", &file]);
    let said = String::from_utf8(made.stderr).unwrap();
    assert_eq!(made.status.code(), Some(2), "{said}");
    assert!(said.contains("another station has address 3"), "{said}");
    assert!(!std::path::Path::new(&file).exists(), "no file with an address that is used twice");
}

/// FDL_Status to the address of the master, from any other one: what `scan` asks last.
fn asks_own_address(octets: &[u8]) -> bool {
    octets.windows(4).any(|octets| matches!(octets, [0x10, 3, _, 0x49]))
}

/// A port that is lost when the address of the master is asked.
fn lost_before_the_last_address(target: &str) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let name = listener.local_addr().unwrap().to_string();
    let target = target.to_owned();
    thread::spawn(move || {
        let (mut client, _) = listener.accept().unwrap();
        drop(listener);
        let mut line = TcpStream::connect(target).unwrap();
        let (mut from, mut to) = (line.try_clone().unwrap(), client.try_clone().unwrap());
        thread::spawn(move || io::copy(&mut from, &mut to));
        let (mut sent, mut chunk) = (Vec::new(), [0; 256]);
        while let Ok(length @ 1..) = client.read(&mut chunk) {
            sent.extend(&chunk[..length]);
            if asks_own_address(&sent) {
                break;
            }
            line.write_all(&chunk[..length]).unwrap();
        }
        client.shutdown(Shutdown::Both).unwrap();
        line.shutdown(Shutdown::Both).unwrap();
    });
    name
}

#[test]
fn the_stations_are_printed_although_the_port_is_lost_before_the_last_address() {
    let (_simulation, address) = on_tcp(&["bcg450@5"]);
    for (option, expected) in [(None, "\n   5  slave   0x08E6"), (Some("--json"), "\"address\": 5,")] {
        let port = format!("tcp://{}", lost_before_the_last_address(&address));
        let mut arguments = vec!["scan", "--port", &port, PATIENTLY, "--master", "3", "--hsa", "6"];
        arguments.extend(option);
        let scanned = run(&arguments);
        let (shown, said) = (String::from_utf8(scanned.stdout).unwrap(), String::from_utf8(scanned.stderr).unwrap());
        assert!(shown.contains(expected), "{shown}{said}");
        assert!(said.contains(&port), "{said}");
        assert_eq!(scanned.status.code(), Some(3), "{said}");
    }
}

#[test]
fn every_address_is_asked() {
    let (_program, address) = on_tcp(&["bcg450@126"]);
    let port = format!("tcp://{address}");
    let mut listener = End::tcp(&address);
    // A loaded computer may answer too late for such a fast scan; the requests are visible on the line.
    let _ = run(&["scan", "--port", &port]);
    listener.send("10 7E 7D 49 44 16");
    let mut received = Vec::new();
    while !received.ends_with(&octets("10 7D 7E 00 FB 16")) {
        received.extend(listener.receive());
    }
    for asked in 1..=126 {
        assert!(received.windows(4).any(|octets| octets == [0x10, asked, 0, 0x49]), "{asked} was not asked");
    }
}

#[test]
fn json_has_the_same_data_and_the_owner_of_a_slave() {
    let (_program, address) = on_tcp(&["bcg450@5", "bcg450@6"]);
    let mut master = End::tcp(&address);
    master.ask(&sd2(5, 61, 0x5D, "80 00 00 0B 08 E6 00 00 00 00 05 1C"), "E5");
    master.ask(&sd2(5, 62, 0x7D, "44 86 05 05 05 08"), "E5");
    let json = output(&["scan", "--port", &format!("tcp://{address}"), "--hsa", "8", PATIENTLY, "--json"]);
    let expected = serde_json::json!([
        {"address": 5, "kind": "slave", "ident": "0x08E6", "devices": ["bcg450"], "state": "exchanges data", "owner": 2},
        {"address": 6, "kind": "slave", "ident": "0x08E6", "devices": ["bcg450"],
         "state": "waits for parameters, not ready", "owner": null},
    ]);
    assert_eq!(serde_json::from_str::<serde_json::Value>(&json).unwrap(), expected);
}

/// Set_Prm is the service that takes ownership of a slave: no telegram of a scan goes to SAP 61, and every request is FDL
/// status or Slave_Diag.
#[test]
fn a_scan_only_reads() {
    let (_program, address) = on_tcp(&["bcg450@5"]);
    let mut listener = End::tcp(&address);
    output(&["scan", "--port", &format!("tcp://{address}"), PATIENTLY, "--hsa", "6"]);
    listener.send("10 05 7D 49 CB 16");
    let mut received = Vec::new();
    while !received.ends_with(&octets("10 7D 05 00 82 16")) {
        received.extend(listener.receive());
    }
    let slave_diag = octets("68 05 05 68 85 80");
    assert!(received.windows(6).any(|octets| octets == slave_diag));
    for request in received.windows(9).filter(|octets| octets.starts_with(&slave_diag)) {
        // FC, DSAP, SSAP
        assert_eq!(request[7..], [60, 62], "{request:02X?}");
    }
}

#[test]
fn an_empty_bus_is_no_answer() {
    let (_program, address) = on_tcp(&["bcg450@50"]);
    let failed = run(&["scan", "--port", &format!("tcp://{address}"), "--hsa", "5"]);
    assert_eq!(failed.status.code(), Some(3));
    assert_eq!(String::from_utf8(failed.stderr).unwrap(), format!("profivac: no station answers on tcp://{address}\n"));
}

#[test]
fn a_scan_gives_up_on_a_line_that_another_master_occupies() {
    let (_program, address) = on_tcp(&["bcg450@5"]);
    let mut other = End::tcp(&address);
    // A token every 20 ms, from before the scan until it ends.
    other.send("DC 02 02");
    let mut scan = Program::start(&["scan", "--port", &format!("tcp://{address}"), "--timeout", "1"]);
    while !scan.has_ended() {
        other.send("DC 02 02");
        other.receive_within(Duration::from_millis(20));
    }
    assert_eq!(scan.exit_code(), 3);
    assert_eq!(scan.complaint(), "profivac: master 2 is using the line");
}

/// At this rate the pause between two scans of the GAP is 1 s; the slot time is 200 ms.
const IN_A_RING: [&str; 4] = ["--baud", "1500000", "--slot-time", "300000"];

#[test]
fn a_scan_joins_the_ring_of_another_master_and_leaves_it_complete() {
    let (_program, address) = on_tcp(&["bcg450@6", "--baud", "1500000"]);
    let port = format!("tcp://{address}");
    let mut other = Program::start(
        &[&["monitor", "--port", &port, "--master", "2", "--hsa", "4", "--own", "--json", "6"], &IN_A_RING[..]]
            .concat(),
    );
    assert!(other.line().contains("\"state\":\"DATA\""));
    let map = output(
        &[&["scan", "--port", &port, "--master", "3", "--hsa", "6", "--timeout", "60"], &IN_A_RING[..]].concat(),
    );
    assert!(map.starts_with("      0 1 2 3 4 5 6 7 8 9\n   0  . . M * . . S"), "{map}");
    // The monitor continues after the scan.
    for _ in 0..3 {
        assert!(other.line().contains("\"state\":\"DATA\""));
    }
    other.terminate();
    assert_eq!(other.exit_code(), 0);
}

#[test]
fn a_second_master_with_the_same_address_is_reported() {
    let (_program, address) = on_tcp(&["bcg450@6", "--baud", "1500000"]);
    let port = format!("tcp://{address}");
    let mut other = Program::start(
        &[&["monitor", "--port", &port, "--master", "2", "--hsa", "4", "--own", "--json", "6"], &IN_A_RING[..]]
            .concat(),
    );
    other.line();
    let failed = run(&[&["scan", "--port", &port, "--master", "2", "--timeout", "1"], &IN_A_RING[..]].concat());
    assert_eq!(failed.status.code(), Some(3));
    assert_eq!(String::from_utf8(failed.stderr).unwrap(), "profivac: another master has the address 2\n");
    other.terminate();
    assert_eq!(other.exit_code(), 0);
}

#[test]
fn impossible_bus_parameters_are_refused() {
    for (option, value, sentence) in [
        ("--master", "126", "the master's address must be 0 to 125, not 126"),
        ("--slot-time", "10", "the slot time must be at least 75, not 10"),
        ("--baud", "fast", "expected auto or a PROFIBUS rate, one of 9600, "),
        ("--timeout", "-1", "expected a number of seconds, or a time like '10 min' or 2d, got \"-1\""),
    ] {
        let failed = run(&["scan", "--port", "/nowhere", option, value]);
        let message = String::from_utf8(failed.stderr).unwrap();
        assert_eq!(failed.status.code(), Some(2), "{message}");
        assert!(message.contains(sentence), "{option}: {message}");
    }
    let failed = run(&["scan", "--port", "/nowhere"]);
    assert_eq!(failed.status.code(), Some(3));
    assert_eq!(
        String::from_utf8(failed.stderr).unwrap(),
        "profivac: there is no port /nowhere: plug in the adapter, or start the program that serves it\n"
    );
}
