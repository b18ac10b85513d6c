//! Nonvolatile values survive the power switch, and with `--state` the process.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod common;

use common::{End, Folder, Program, sd2};

/// A BCG450 whose switch is set outside 0 to 125, on its own line.
fn simulation(folder: &Folder, arguments: &[&str]) -> (Program, End) {
    let program = Program::start(&[&["simulate", "--pty", &folder.name("line"), "bcg450@126"], arguments].concat());
    program.ready();
    let line = End::pty(&folder.path("line"));
    (program, line)
}

/// Set_Slave_Add from 126 to 9, changeable afterwards: profibus-wire 2.11.
fn set_address_9(line: &mut End) {
    line.ask(&sd2(126, 55, 0x6D, "09 08 E6 00"), "E5");
}

#[test]
fn an_address_from_the_bus_survives_the_power_switch() {
    let folder = Folder::new();
    let (mut program, mut line) = simulation(&folder, &[]);
    assert_eq!(program.state(126)["address"], 126);
    set_address_9(&mut line);
    assert_eq!(program.tell("power 126 off"), "ok");
    assert_eq!(program.tell("power 126 on"), "ok");
    line.ask("10 09 02 49 54 16", "10 02 09 00 0B 16");
    assert_eq!(program.state(126)["address"], 9);
}

#[test]
fn without_a_folder_values_end_with_the_process() {
    let folder = Folder::new();
    let (mut program, mut line) = simulation(&folder, &[]);
    set_address_9(&mut line);
    assert_eq!(program.tell("quit"), "ok");
    program.exit_code();
    let (mut program, _line) = simulation(&folder, &[]);
    assert_eq!(program.state(126)["address"], 126);
}

#[test]
fn with_a_folder_acknowledged_values_survive_a_kill() {
    let folder = Folder::new();
    let state = folder.name("state");
    let (mut program, mut line) = simulation(&folder, &["--state", &state]);
    set_address_9(&mut line);
    program.kill();
    // The dangling link of the killed process is replaced.
    let (mut program, mut line) = simulation(&folder, &["--state", &state]);
    line.ask("10 09 02 49 54 16", "10 02 09 00 0B 16");
    assert_eq!(program.state(126)["address"], 9);
}

#[test]
fn every_address_has_its_own_memory() {
    let folder = Folder::new();
    let state = folder.name("state");
    let (mut program, _line) = simulation(&folder, &["--state", &state, "bcg450@7"]);
    assert_eq!(program.tell("quit"), "ok");
    for name in ["bcg450-126.state", "bcg450-7.state"] {
        assert!(std::path::Path::new(&state).join(name).is_file(), "{name}");
    }
}

#[test]
fn a_damaged_memory_is_reported_and_renamed() {
    let folder = Folder::new();
    std::fs::write(folder.path("bcg450-126.state"), "address = 09 00\n").unwrap();
    let (mut program, _line) = simulation(&folder, &["--state", &folder.name("")]);
    let message = program.complaint();
    assert!(
        message.starts_with("profivac: the nonvolatile memory of bcg450 at address 126 is damaged; it was renamed to "),
        "{message}"
    );
    assert_eq!(program.state(126)["address"], 126);
    let kept = std::fs::read_to_string(folder.path("bcg450-126.damaged-1")).unwrap();
    assert_eq!(kept, "address = 09 00\n");
}
