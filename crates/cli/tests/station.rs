//! `init` and `run`: from a bus to a station with a dashboard.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod common;

use common::{Folder, Program, run};
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(60);

/// A segment in memory, and the folder it lies in.
fn bench() -> (Folder, String) {
    let folder = Folder::new();
    let file = folder.name("bench.toml");
    fs::write(&file, "devices = [\"bcg450@5\", \"psg550@6\"]\nbaud = 187500\n").unwrap();
    (folder, format!("sim:{file}"))
}

/// What a GET at `path` gives.
fn get(address: &str, path: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

/// Asks again until what comes contains `wanted`.
fn until(address: &str, path: &str, wanted: &str) -> String {
    let end = Instant::now() + PATIENCE;
    loop {
        let answer = get(address, path);
        if answer.contains(wanted) {
            return answer;
        }
        assert!(Instant::now() < end, "{path} never has {wanted}: {answer}");
        std::thread::yield_now();
    }
}

#[test]
fn a_bus_becomes_a_station_with_a_dashboard() {
    let (folder, port) = bench();
    let file = folder.name("plant.toml");
    let made = run(&["init", "--port", &port, "--baud", "187500", "--hsa", "8", "--out", &file]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let checked = run(&["run", &file, "--check"]);
    assert_eq!(String::from_utf8_lossy(&checked.stdout), format!("{file}: 1 segments, 2 gauges\n"));
    let mut station = Program::start(&["run", &file, "--listen", "127.0.0.1:0"]);
    let ready = station.ready();
    let address = ready.strip_prefix("http://").unwrap();
    let gauges = until(address, "/api/gauges", "\"exchanging\"");
    assert!(gauges.contains("\"bcg450 5\""), "{gauges}");
    assert!(get(address, "/").contains("<div id=\"app\">"));
    // A changed file, and one that is wrong.
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("bcg450 5", "Chamber")).unwrap();
    station.hang_up();
    until(address, "/api/gauges", "\"Chamber\"");
    fs::write(&file, "nonsense").unwrap();
    station.hang_up();
    assert!(station.complaint().contains("the station goes on as it was"));
    assert!(get(address, "/api/gauges").contains("\"Chamber\""));
    station.terminate();
    assert_eq!(station.exit_code(), 0);
    let record = fs::metadata(folder.name("plant.db")).unwrap();
    assert!(record.len() > 0);
}

#[test]
fn what_is_wrong_with_a_file_is_told_before_anything_starts() {
    let folder = Folder::new();
    let file = folder.name("plant.toml");
    fs::write(&file, "[[segment]]\nname = \"a\"\nport = \"/dev/null\"\nbaud = 1\n").unwrap();
    let told = run(&["run", &file]);
    assert_eq!(told.status.code(), Some(2));
    let complaint = String::from_utf8_lossy(&told.stderr).into_owned();
    assert!(complaint.starts_with(&format!("profivac: {file}:4:8: expected a PROFIBUS rate out of ")), "{complaint}");
    let missing = run(&["run", &folder.name("missing.toml")]);
    assert_eq!(missing.status.code(), Some(2));
}

#[test]
fn nobody_else_sees_a_station_unless_that_is_wanted() {
    let (folder, port) = bench();
    let file = folder.name("plant.toml");
    fs::write(&file, format!("[[segment]]\nname = \"a\"\nport = {port:?}\n")).unwrap();
    let told = run(&["run", &file, "--listen", "0.0.0.0:0"]);
    assert_eq!(told.status.code(), Some(2));
    let complaint = String::from_utf8_lossy(&told.stderr).into_owned();
    assert_eq!(
        complaint.trim(),
        "profivac: 0.0.0.0:0 can be reached from other computers: say --public if everybody there may see the station"
    );
}

#[test]
fn init_never_writes_over_a_file() {
    let (folder, port) = bench();
    let file = folder.name("plant.toml");
    fs::write(&file, "mine").unwrap();
    let told = run(&["init", "--port", &port, "--baud", "187500", "--hsa", "6", "--out", &file]);
    assert_eq!(told.status.code(), Some(2));
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
}

#[test]
fn the_demonstration_has_the_dashboard_over_all_devices() {
    let demo = Program::start(&["demo", "--headless", "--listen", "127.0.0.1:0", "--speed", "5"]);
    let told = demo.complaint();
    let address = told.strip_prefix("profivac: the dashboard is at http://").unwrap_or_else(|| panic!("{told}"));
    let end = Instant::now() + PATIENCE;
    loop {
        let gauges = get(address, "/api/gauges");
        let measuring = gauges.matches("\"exchanging\"").count() + gauges.matches("\"faulty\"").count();
        if measuring == 12 {
            break;
        }
        assert!(Instant::now() < end, "{gauges}");
        std::thread::yield_now();
    }
    let blocks = get(address, "/api/gauges/bcg450%205/blocks");
    assert!(blocks.starts_with("HTTP/1.1 200") && blocks.contains("\"Safe Value\""), "{blocks}");
    assert!(get(address, "/").contains("<div id=\"app\">"));
}
