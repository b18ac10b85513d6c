//! Commands on ports that are lost, return, run at an unknown rate or are files.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{End, Folder, Program, run};
use rustix::fs::{Mode, OFlags};
use std::io::Read;
use std::net::TcpListener;
use std::os::fd::OwnedFd;
use std::path::Path;

/// A slot time of 200 ms, in bit times, so that a loaded computer misses no answer.
const PATIENTLY: &str = "--slot-time=4000";

/// FDL status of the station at address 5, asked by master 2, and its answer.
const STATUS: (&str, &str) = ("10 05 02 49 50 16", "10 02 05 00 07 16");

/// Standard error of a command that must fail with this exit code.
fn failing(arguments: &[&str], code: i32) -> String {
    let output = run(arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    message
}

#[test]
fn a_kind_of_port_that_does_not_exist_is_wrong_usage() {
    for command in [&["scan"][..], &["conform", "--address", "5", "--own"], &["monitor", "--own", "5"], &["sniff"]] {
        let said = failing(&[command, &["--port", "udp://10.0.0.1:4000"]].concat(), 2);
        assert!(said.contains("udp://10.0.0.1:4000 is no kind of port"), "{said}");
    }
}

/// Reads rows until one contains `text`.
fn shows(monitor: &Program, text: &str) {
    let shown = (0..60).any(|_| monitor.line().contains(text));
    assert!(shown, "{text} is not shown");
}

/// The next line on standard error that is not about an answer that the load of the computer delayed.
fn complaint(monitor: &Program) -> String {
    loop {
        let line = monitor.complaint();
        if !line.contains("later than the slot time of") {
            return line;
        }
    }
}

/// Keeps the number of a pty from other tests. After a kill its link dangles, and a program that opens the link again would reach
/// the pty of the test that got the number.
fn kept(path: &Path) -> OwnedFd {
    rustix::fs::open(path, OFlags::RDONLY | OFlags::NOCTTY | OFlags::NONBLOCK, Mode::empty()).unwrap()
}

/// `monitor` of the gauge at address 5 reports the lost line, and shows another pressure after its return.
fn monitor_survives(port: &str, simulation: &[&str]) {
    let simulate = |pressure| {
        let program = Program::start(&[&["simulate", "--pressure", pressure], simulation, &["bcg450@5"]].concat());
        program.ready();
        program
    };
    let mut first = simulate("1e-3 mbar");
    let monitor = Program::start(&["monitor", "--port", port, "--own", "--csv", PATIENTLY, "5"]);
    shows(&monitor, ",5,bcg450,1e-3,mbar,1e-3,2,DATA,");
    let _kept = simulation.contains(&"--pty").then(|| kept(Path::new(port)));
    first.kill();
    let lost = format!(
        "profivac: lost {port}: it was unplugged, or its other side was closed; profivac tries to open it again"
    );
    assert_eq!(complaint(&monitor), lost);
    shows(&monitor, ",OFFLINE,");
    let _second = simulate("3e-7 mbar");
    assert_eq!(complaint(&monitor), format!("profivac: {port} is open again"));
    shows(&monitor, ",5,bcg450,3e-7,mbar,3e-7,2,DATA,");
}

#[test]
fn monitor_survives_the_loss_of_a_pty() {
    let folder = Folder::new();
    let path = folder.name("line");
    monitor_survives(&path, &["--pty", &path]);
}

#[test]
fn monitor_survives_the_loss_of_a_tcp_server() {
    // A port that was free before.
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    monitor_survives(&format!("tcp://{address}"), &["--tcp", &address]);
}

#[test]
fn a_simulation_survives_the_loss_of_its_hub() {
    let folder = Folder::new();
    let (a, b) = (folder.name("a"), folder.name("b"));
    let hub = || {
        let hub = Program::start(&["hub", "--pty", &a, "--pty", &b]);
        hub.ready();
        hub
    };
    let mut first = hub();
    let mut simulation = Program::start(&["simulate", "--serial", &a, "bcg450@5"]);
    assert_eq!(simulation.ready(), a);
    End::pty(&folder.path("b")).insist(STATUS.0, STATUS.1);
    let _kept = [&a, &b].map(|path| kept(Path::new(path)));
    first.kill();
    assert!(simulation.complaint().starts_with(&format!("profivac: lost {a}: ")));
    assert_eq!(simulation.tell("pressure 1e-5 mbar"), "ok", "it is operated all the same");
    let _second = hub();
    assert_eq!(simulation.complaint(), format!("profivac: {a} is open again"));
    End::pty(&folder.path("b")).insist(STATUS.0, STATUS.1);
    assert_eq!(simulation.tell("quit"), "ok");
    assert_eq!(simulation.exit_code(), 0);
}

#[test]
fn a_command_with_single_requests_ends_with_its_port() {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp://{}", server.local_addr().unwrap());
    let mut scan = Program::start(&["scan", "--port", &port]);
    // The server ends in the middle of the work: at the opening it would be asked again.
    let mut line = server.accept().unwrap().0;
    line.read_exact(&mut [0]).unwrap();
    drop(line);
    assert_eq!(scan.exit_code(), 3);
    let message = scan.complaint();
    assert_eq!(message, format!("profivac: lost {port}: it was unplugged, or its other side was closed"));
}

#[test]
fn a_segment_in_memory_is_a_port() {
    let folder = Folder::new();
    let file = "devices = [\"bcg450@5:unit=torr\", \"pcg550@6\"]\npressure = \"5e-6 mbar\"\n";
    std::fs::write(folder.path("memory.toml"), file).unwrap();
    let port = format!("sim:{}", folder.name("memory.toml"));
    let scan = run(&["scan", "--port", &port, PATIENTLY, "--hsa", "8", "--json"]);
    let found: serde_json::Value = serde_json::from_slice(&scan.stdout).unwrap();
    let idents: Vec<_> = found.as_array().unwrap().iter().map(|slave| (&slave["address"], &slave["ident"])).collect();
    assert_eq!(idents, [(&5.into(), &"0x08E6".into()), (&6.into(), &"0x0C85".into())]);
    let monitor = Program::start(&["monitor", "--port", &port, "--own", "--json", PATIENTLY, "5"]);
    let row: serde_json::Value = serde_json::from_str(&monitor.line()).unwrap();
    assert_eq!(row["unit"], "Torr");
    assert!((row["mbar"].as_f64().unwrap() / 5e-6 - 1.0).abs() < 1e-6, "{row}");
}

#[test]
fn the_error_for_a_wrong_file_has_its_position() {
    let folder = Folder::new();
    let path = folder.name("memory.toml");
    let port = format!("sim:{path}");
    let message = failing(&["scan", "--port", &port], 2);
    assert_eq!(message, format!("profivac: {path}: No such file or directory (os error 2)\n"));
    std::fs::write(&path, "devices = [\n  \"bcg450@127\",\n]\n").unwrap();
    let message = failing(&["scan", "--port", &port], 2);
    assert_eq!(message, format!("profivac: {path}:2:3: expected an address from 0 to 126, got \"127\"\n"));
}

#[test]
fn auto_is_refused_on_a_port_without_a_rate() {
    let folder = Folder::new();
    let path = folder.name("line");
    let simulation = Program::start(&["simulate", "--pty", &path, "bcg450@5"]);
    simulation.ready();
    let message = failing(&["scan", "--port", &path, "--baud", "auto"], 2);
    let sentence = "has no transmission rate to detect: give the rate as a number (--baud 19200)";
    assert_eq!(message, format!("profivac: {path} {sentence}\n"));
    let message = failing(&["scan", "--port", "/nowhere", "--baud", "auto"], 3);
    assert_eq!(
        message,
        "profivac: there is no port /nowhere: plug in the adapter, or start the program that serves it\n"
    );
}

#[test]
fn the_error_for_a_wrong_port_says_what_it_is() {
    let message = failing(&["scan", "--port", "tcp://::1:4000"], 2);
    assert!(
        message.contains("expected HOST:PORT, got \"::1:4000\" (an IPv6 address in brackets: [::1]:4000)"),
        "{message}"
    );
    let host = format!("tcp://{}:4000", "h".repeat(300));
    let message = failing(&["scan", "--port", &host], 3);
    assert!(message.contains("the name of the host cannot be resolved"), "{message}");
}
