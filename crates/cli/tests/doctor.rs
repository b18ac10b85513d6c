//! `profivac doctor`: each finding names the next step, and the exit code says whether something is wrong.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, run};
use serde_json::Value;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpListener;
use std::process::Output;

/// The findings as (verdict, text), and the exit code.
fn findings(output: &Output) -> (Vec<(String, String)>, i32) {
    let examinations: Value = serde_json::from_slice(&output.stdout).unwrap();
    let all = examinations.as_array().unwrap().iter().flat_map(|it| it["findings"].as_array().unwrap());
    let finding = |finding: &Value| {
        let verdict = finding["verdict"].as_str().unwrap().to_owned();
        let next = finding["next"].as_str();
        assert_eq!(verdict == "good", next.is_none(), "{finding}: only what is good has no next step");
        (verdict, format!("{} -> {}", finding["found"].as_str().unwrap(), next.unwrap_or_default()))
    };
    (all.map(finding).collect(), output.status.code().unwrap())
}

fn doctor(subjects: &[&str]) -> (Vec<(String, String)>, i32) {
    doctor_for("1", subjects)
}

fn doctor_for(seconds: &str, subjects: &[&str]) -> (Vec<(String, String)>, i32) {
    findings(&run(&[&["doctor", "--json", "--for", seconds], subjects].concat()))
}

/// Asserts that one finding has this verdict and contains this text.
#[track_caller]
fn assert_finds(found: &[(String, String)], verdict: &str, text: &str) {
    assert!(
        found.iter().any(|(own, sentence)| own == verdict && sentence.contains(text)),
        "{verdict} {text}: {found:#?}"
    );
}

#[test]
fn the_computer_is_checked_without_a_name() {
    let (found, code) = doctor(&[]);
    assert_finds(&found, "good", "the clock is set");
    assert!(found.iter().any(|(_, text)| text.contains("runs this program at most")), "{found:?}");
    // A serial device of this computer may be one that the user may not open.
    assert!(code == 0 || found.iter().any(|(verdict, _)| verdict == "bad-port"), "{found:?}");
}

#[test]
fn a_missing_port_is_a_problem_and_its_next_step_names_those_that_are_there() {
    let (found, code) = doctor(&["/dev/no-such-device"]);
    assert_eq!(code, 3);
    assert_finds(&found, "bad-port", "there is no port /dev/no-such-device -> plug in the adapter");
    assert!(found[0].1.contains("this computer has"), "{found:?}");
}

#[test]
fn a_silent_line_is_noted_and_a_scan_is_the_next_step() {
    let folder = Folder::new();
    let line = folder.name("line");
    let simulation = Program::start(&["simulate", "--pty", &line, "bcg450@5"]);
    simulation.ready();
    let (found, code) = doctor(&[&fs::canonicalize(&line).unwrap().to_string_lossy()]);
    assert_eq!(code, 0);
    assert_finds(
        &found,
        "note",
        "the line is silent: no master sends -> ask the gauges with `profivac scan --port /dev/pts/",
    );
}

/// A master and slaves that a test writes octet by octet.
fn line_with(octets: &'static [u8]) -> (Vec<(String, String)>, i32, Vec<u8>) {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp://{}", server.local_addr().unwrap());
    let writer = std::thread::spawn(move || {
        let (mut line, _) = server.accept().unwrap();
        line.write_all(octets).unwrap();
        let mut sent = Vec::new();
        line.read_to_end(&mut sent).unwrap();
        sent
    });
    // Long enough for a writer that a loaded computer delays.
    let (found, code) = doctor_for("5", &[&port]);
    (found, code, writer.join().unwrap())
}

#[test]
fn telegrams_name_the_masters_and_a_slave_that_does_not_answer_and_nothing_is_sent() {
    // Two Slave_Diag requests of master 2 to slave 5, repeated, and its token.
    const REQUESTS: [u8; 11] = [0x68, 5, 5, 0x68, 0x85, 0x82, 0x6D, 0x3C, 0x3E, 0xEE, 0x16];
    let mut line = Vec::new();
    for _ in 0..4 {
        line.extend(REQUESTS);
        line.extend([0xDC, 2, 2]);
    }
    let (found, code, sent) = line_with(line.leak());
    assert_eq!((code, sent), (3, Vec::new()));
    assert_finds(&found, "good", "8 telegrams");
    assert_finds(&found, "bad-port", "station 5 is asked and does not answer -> check its power");
}

#[test]
fn octets_without_a_telegram_name_the_wires() {
    let (found, code, _) = line_with(&[0x55; 60]);
    assert_eq!(code, 3);
    assert_finds(&found, "bad-port", "60 octets and no telegram among them -> exchange the wires A and B");
}

const STATION: &str = "[station]\nlisten = \"127.0.0.1:0\"\ndatabase = \"plant.db\"\n\n[[segment]]\nname = \"hall\"\nport = \"PORT\"\n\n\
                       [[segment.gauge]]\nname = \"chamber\"\naddress = 5\ndevice = \"bcg450\"\n";

#[test]
fn the_file_of_a_station_is_checked_with_its_ports_its_database_and_its_address() {
    let folder = Folder::new();
    fs::write(folder.path("hall.toml"), "devices = [\"bcg450@5\"]\npressure = \"1e-3 mbar\"\n").unwrap();
    let file = folder.name("plant.toml");
    fs::write(&file, STATION.replace("PORT", "sim:hall.toml")).unwrap();
    let (found, code) = doctor(&[&file]);
    assert_eq!(code, 0, "{found:?}");
    assert_finds(&found, "good", "the file of a station, segments: 1, gauges: 1");
    assert_finds(&found, "good", "the database will be");
    assert_finds(&found, "good", "the address of the dashboard");
    fs::write(&file, STATION.replace("PORT", "/dev/no-such-device")).unwrap();
    let (found, code) = doctor(&[&file]);
    assert_eq!(code, 3);
    assert_finds(&found, "bad-port", "segment hall: there is no port /dev/no-such-device");
    fs::write(&file, STATION.replace("bcg450", "bcg4500")).unwrap();
    let (found, code) = doctor(&[&file]);
    assert_eq!(code, 2);
    assert_finds(&found, "bad-file", "plant.toml:");
}

#[test]
fn a_database_is_checked_whole_and_a_damaged_one_is_a_problem() {
    let folder = Folder::new();
    fs::write(folder.path("hall.toml"), "devices = [\"bcg450@5\"]\npressure = \"1e-3 mbar\"\n").unwrap();
    let file = folder.name("plant.toml");
    fs::write(&file, STATION.replace("PORT", "sim:hall.toml")).unwrap();
    let mut station = Program::start(&["run", &file]);
    station.ready();
    station.terminate();
    assert_eq!(station.exit_code(), 0);
    let database = folder.name("plant.db");
    let (found, code) = doctor(&[&database]);
    assert_eq!(code, 0, "{found:?}");
    assert_finds(&found, "good", "the database is not damaged");
    let mut octets = fs::read(&database).unwrap();
    // Pages after the first one, which holds the list of tables.
    let page = 4096;
    octets[page..3 * page].fill(0xA5);
    fs::write(folder.path("damaged.db"), octets).unwrap();
    let (found, code) = doctor(&[&folder.name("damaged.db")]);
    assert_eq!(code, 2, "{found:?}");
    assert_finds(&found, "bad-file", "backup");
}

#[test]
fn other_files_are_recognised() {
    let folder = Folder::new();
    let of = |name: &str, text: &str| {
        fs::write(folder.path(name), text).unwrap();
        doctor(&[&folder.name(name)])
    };
    let (found, code) = of("segment.toml", "devices = [\"bcg450@5\"]\npressure = \"1e-3 mbar\"\n");
    assert_eq!(code, 0);
    assert_finds(&found, "good", "a segment in memory");
    let (found, code) = of("log.txt", "68 05 05 68 85 82 6D 3C 3E EE 16\nDC 02 02\n");
    assert_eq!(code, 0);
    assert_finds(&found, "good", "text with octets: 2 telegrams, 0 damaged");
    let (found, code) = of("scenario.toml", "no-such-key = 1\n");
    assert_eq!(code, 2);
    assert_finds(&found, "bad-file", "unknown field");
    let (found, code) = doctor(&[&folder.name("absent.toml")]);
    assert_eq!(code, 2);
    assert_finds(&found, "bad-file", "check the name");
}
