//! `profivac sniff` as a program: its explanations, its silence on the line, and its end.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, octets, run};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};

const LISTENING: &str = "profivac: listening on ";

/// A line with `sniff` as a tap.
fn listened(options: &[&str]) -> (Program, TcpStream) {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp://{}", server.local_addr().unwrap());
    let program = Program::start(&[&["sniff", "--port", &port], options].concat());
    let (line, _) = server.accept().unwrap();
    assert!(program.complaint().starts_with(LISTENING));
    (program, line)
}

const DIAG: &str = "68 05 05 68 85 82 6D 3C 3E EE 16";
const ANSWER: &str = "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 08 E6 7D 16";

/// A request, an answer in two pieces, random octets between telegrams.
#[test]
fn sniff_explains_traffic_skips_random_octets_sends_nothing_and_ends_with_ctrl_c() {
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

/// On a hub with a virtual gauge and a master that scans: `sniff` explains the scan and does not change its result.
#[test]
fn sniff_explains_a_scan_without_disturbing_it() {
    let folder = Folder::new();
    let [gauge, master, tap] = ["gauge", "master", "tap"].map(|name| folder.name(name));
    let hub = Program::start(&["hub", "--pty", &gauge, "--pty", &master, "--pty", &tap]);
    hub.ready();
    let simulator = Program::start(&["simulate", "--serial", &gauge, "bcg450@5"]);
    simulator.ready();
    let mut program = Program::start(&["sniff", "--port", &tap]);
    assert!(program.complaint().starts_with(LISTENING));
    // On a slow computer the first scan may find no station: it is repeated.
    let scan = || run(&["scan", "--port", &master, "--hsa", "6", "--slot-time", "2000"]).status.code();
    assert!((0..10).any(|_| scan() == Some(0)), "no station was found");
    while !program.line().ends_with("is present: bcg450 (ident 08E6), has no owner, waits for parameters, not ready") {}
    program.interrupt();
    while !program.line().contains("bcg450 ") {}
    assert_eq!(program.exit_code(), 0);
}

#[test]
fn json_and_a_capture_file_are_written_while_traffic_happens() {
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
fn sniff_ends_after_its_time_with_a_summary() {
    let (mut program, _line) = listened(&["--for", "0"]);
    assert_eq!(program.line(), "");
    assert_eq!(program.line(), "0 telegrams, 0 damaged pieces");
    assert_eq!(program.exit_code(), 0);
}

#[test]
fn a_lost_port_ends_sniff_with_exit_code_3_after_the_summary() {
    let (mut program, mut line) = listened(&[]);
    line.write_all(&octets(DIAG)).unwrap();
    drop(line);
    assert_eq!(program.line(), "");
    assert_eq!(program.line(), "1 telegram, 0 damaged pieces");
    assert_eq!(program.exit_code(), 3);
    assert!(program.complaint().starts_with("profivac: lost tcp://"));
}

#[test]
fn a_missing_port_ends_sniff_with_exit_code_3() {
    let output = run(&["sniff", "--port", "/nowhere/tty", "--for", "0"]);
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(
        String::from_utf8(output.stderr).unwrap(),
        "profivac: there is no port /nowhere/tty: plug in the adapter, or start the program that serves it\n"
    );
}

/// A token, a diagnosis, an exchange and its repetition: live list and counts, and the pressure of a gauge that the user names.
#[test]
fn statistics_are_a_table_or_one_json_object() {
    const EXCHANGE: &str = "10 05 02 7D 84 16";
    const INPUTS: &str = "68 0A 0A 68 02 05 08 80 00 02 38 D1 B7 17 68 16";
    let telegrams = octets(&["DC 02 02", EXCHANGE, EXCHANGE, INPUTS].join(" "));
    let listen = |options: &[&str]| {
        let (program, mut line) = listened(&[&["--statistics", "--gauge", "bcg450@5"], options].concat());
        line.write_all(&telegrams).unwrap();
        drop(line);
        program
    };
    let program = listen(&["--json"]);
    let mut text = String::new();
    loop {
        let line = program.line();
        text += &line;
        if line == "}" || text.ends_with('}') && serde_json::from_str::<serde_json::Value>(&text).is_ok() {
            break;
        }
    }
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    let slave = &report["stations"][1];
    assert_eq!((slave["address"].as_u64(), slave["state"].as_str()), (Some(5), Some("exchanging")), "{text}");
    assert_eq!((slave["total"]["repeated"].as_u64(), slave["longest_sequence"].as_u64()), (Some(1), Some(1)));
    let gauge = &report["gauges"][0];
    let pa = gauge["pa"].as_f64().unwrap();
    assert!((pa / 0.01 - 1.0).abs() < 1e-6, "1e-4 mbar: {pa}");
    assert_eq!(gauge["origin"].as_str(), Some("assumed"), "neither configuration nor unit was heard");
    let program = listen(&[]);
    while !program.line().contains("exchanging") {}
    let gauge = loop {
        let line = program.line();
        if line.contains("bcg450 instance 2: ") {
            break line;
        }
    };
    assert!(gauge.ends_with("mbar (assumed)"), "{gauge}");
}

/// A TPG with one module 93: its diagnosis, Chk_Cfg, and an exchange with the mantissa 830 and the exponent -5.
const MANTISSA: &str = "\
68 05 05 68 89 82 6D 3C 3E F2 16\n\
68 0B 0B 68 82 89 08 3E 3C 00 0C 00 02 05 D9 79 16\n\
68 09 09 68 89 82 5D 3E 3E 97 A7 93 A0 55 16\n\
E5\n\
68 0C 0C 68 09 02 7D 00 00 00 00 00 00 00 00 00 88 16\n\
68 0F 0F 68 02 09 08 00 00 00 00 00 00 00 00 03 3E FB 00 4F 16\n";

#[test]
fn the_mantissa_of_a_tpg_is_a_pressure_with_its_assumption() {
    let (program, mut line) = listened(&["--statistics", "--gauge", "tpg300@9:unit=mbar"]);
    MANTISSA.lines().for_each(|telegram| line.write_all(&octets(telegram)).unwrap());
    drop(line);
    let until = |begin: &str| loop {
        let line = program.line();
        if line.trim_start().starts_with(begin) {
            break line;
        }
    };
    let gauge = until("9  tpg300 instance 1: ");
    assert!(gauge.ends_with("instance 1: 8.3e-3 mbar (configured)"), "{gauge}");
    let assumption = until("station 9: the manual (i9973ber/a 3.2.4.1) does not define");
    assert!(assumption.ends_with("compare a pressure with the display of the controller"), "{assumption}");
}
