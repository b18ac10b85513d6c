//! `profivac sniff` from outside: what it tells while it happens, that it never sends, and how it ends.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod common;

use common::{Folder, Program, run};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};

const LISTENING: &str = "profivac: listening on ";

/// A line with somebody who listens to it.
fn listened(options: &[&str]) -> (Program, TcpStream) {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp://{}", server.local_addr().unwrap());
    let program = Program::start(&[&["sniff", "--port", &port], options].concat());
    let (line, _) = server.accept().unwrap();
    assert!(program.complaint().starts_with(LISTENING));
    (program, line)
}

fn octets(text: &str) -> Vec<u8> {
    text.split_whitespace().map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect()
}

const DIAG: &str = "68 05 05 68 85 82 6D 3C 3E EE 16";
const ANSWER: &str = "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 08 E6 7D 16";

/// A request to listen to, an answer in two pieces, junk between telegrams.
#[test]
fn it_tells_what_happens_survives_junk_sends_nothing_and_ends_with_ctrl_c() {
    let (mut program, mut line) = listened(&[]);
    line.write_all(&octets(DIAG)).unwrap();
    line.write_all(&octets(ANSWER)[..7]).unwrap();
    line.write_all(&octets(ANSWER)[7..]).unwrap();
    assert!(
        program
            .line()
            .ends_with("s    5  is present: bcg450 (ident 08E6), has no owner, waits for parameters, not ready")
    );
    line.write_all(&[0; 40]).unwrap();
    line.write_all(&octets("DC 02 02")).unwrap();
    let damaged = program.line();
    assert!(damaged.contains("damaged, 40 octets: no telegram begins with 00"), "{damaged}");
    line.write_all(&octets("DC 02 02")).unwrap();
    program.interrupt();
    let mut rest = Vec::new();
    loop {
        rest.push(program.line());
        if rest.last().unwrap().contains("bcg450") {
            break;
        }
    }
    assert!(rest.iter().any(|line| line.contains("telegrams, 1 damaged piece (")), "{rest:?}");
    assert_eq!(program.exit_code(), 0);
    let mut sent = Vec::new();
    line.read_to_end(&mut sent).unwrap();
    assert_eq!(sent, [0; 0], "it only listens");
}

/// On a hub beside a virtual gauge and a master that scans: the story of the scan, and the scan as if nobody listened.
#[test]
fn a_scan_is_overheard_without_being_disturbed() {
    let folder = Folder::new();
    let [gauge, master, ear] = ["gauge", "master", "ear"].map(|name| folder.name(name));
    let hub = Program::start(&["hub", "--pty", &gauge, "--pty", &master, "--pty", &ear]);
    hub.ready();
    let simulator = Program::start(&["simulate", "--serial", &gauge, "bcg450@5"]);
    simulator.ready();
    let mut program = Program::start(&["sniff", "--port", &ear]);
    assert!(program.complaint().starts_with(LISTENING));
    // The gauge joins a line that may be busy, and the machine may be slow: a scan that finds nobody is repeated.
    let scan = || run(&["scan", "--port", &master, "--hsa", "6", "--slot-time", "2000"]).status.code();
    assert!((0..10).any(|_| scan() == Some(0)), "nobody was found");
    while !program.line().ends_with("is present: bcg450 (ident 08E6), has no owner, waits for parameters, not ready")
    {
    }
    program.interrupt();
    while !program.line().contains("bcg450 ") {}
    assert_eq!(program.exit_code(), 0);
}

#[test]
fn json_and_a_capture_file_while_it_happens() {
    let folder = Folder::new();
    let capture = folder.name("line.pcapng");
    let (mut program, mut line) = listened(&["--json", "--raw", "--out", &capture]);
    line.write_all(&octets(DIAG)).unwrap();
    let row: serde_json::Value = serde_json::from_str(&program.line()).unwrap();
    assert_eq!((row["kind"].as_str(), row["octets"].as_str()), (Some("telegram"), Some(DIAG)));
    assert_eq!(row["words"], "2 -> 5 Slave_Diag first");
    program.terminate();
    let row: serde_json::Value = serde_json::from_str(&program.line()).unwrap();
    assert_eq!((row["kind"].as_str(), row["telegrams"].as_u64()), (Some("summary"), Some(1)));
    assert_eq!(program.exit_code(), 0);
    let output = run(&["decode", "--raw", &capture]);
    assert!(String::from_utf8(output.stdout).unwrap().contains(&format!("Slave_Diag       first  | {DIAG}")));
}

#[test]
fn it_ends_after_its_time_and_says_who_spoke() {
    let (mut program, _line) = listened(&["--for", "0"]);
    assert_eq!(program.line(), "");
    assert_eq!(program.line(), "0 telegrams, 0 damaged pieces");
    assert_eq!(program.exit_code(), 0);
}

#[test]
fn a_port_that_goes_away_ends_it_with_3_after_the_summary() {
    let (mut program, mut line) = listened(&[]);
    line.write_all(&octets(DIAG)).unwrap();
    drop(line);
    assert_eq!(program.line(), "");
    assert_eq!(program.line(), "1 telegram, 0 damaged pieces");
    assert_eq!(program.exit_code(), 3);
    assert!(program.complaint().starts_with("profivac: lost tcp://"));
}

#[test]
fn a_port_that_is_not_there_ends_it_with_3() {
    let output = run(&["sniff", "--port", "/nowhere/tty", "--for", "0"]);
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(
        String::from_utf8(output.stderr).unwrap(),
        "profivac: there is no port /nowhere/tty: is the adapter plugged in, or the program running that makes it?\n"
    );
}
