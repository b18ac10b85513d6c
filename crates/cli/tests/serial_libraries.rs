//! Libraries for serial ports of several languages open the ptys of `simulate` and `hub` again and again: docs/masters.md.
//!
//! Each opening is a program of its own, in ci/serial_libraries; `./test` fetches the libraries into target/venv and target/serial_libraries.
//! pyprofibus is in `peers`.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program};
use crate::peers::pyprofibus_master::python;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The answer of the station at address 5 to an FDL status request.
const ANSWER: &str = "10 02 05 00 07 16\n";

/// How often a pty is opened. The first opening shows nothing: the settings of a new pty are no program's.
const OPENINGS: usize = 3;

/// What `./test` has made.
fn made(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/serial_libraries").join(name);
    assert!(path.exists(), "there is no {}: ./test makes it", path.display());
    path
}

fn python_program(library: &str, line: &str) -> Command {
    let mut command = Command::new(python());
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../ci/serial_libraries/ask.py");
    command.arg(program).args([library, line]);
    command
}

fn pyserial(line: &str) -> Command {
    python_program("pyserial", line)
}

fn serialx(line: &str) -> Command {
    python_program("serialx", line)
}

/// serialport of npm.
fn node(line: &str) -> Command {
    let mut command = Command::new("node");
    command.arg(made("node/ask.mjs")).arg(line);
    command
}

/// The crate serialport.
fn rust(line: &str) -> Command {
    let mut command = Command::new(made("rust/debug/ask"));
    command.arg(line);
    command
}

/// Waits until a server has seen that the last program has closed its pty. It looks at its ptys and at its standard input in one loop, so
/// its second answer comes behind a look at the ptys.
pub fn settle(server: &mut Program) {
    for _ in 0..2 {
        assert!(server.tell("no order").starts_with("error: "));
    }
}

fn opens_again_and_again(library: fn(&str) -> Command, server: &mut Program, line: &str) {
    for number in 1..=OPENINGS {
        let output = library(line).output().unwrap();
        let (answer, errors) =
            (String::from_utf8(output.stdout).unwrap(), String::from_utf8_lossy(&output.stderr).into_owned());
        assert_eq!(answer, ANSWER, "opening {number}: {errors}");
        settle(server);
    }
}

/// Opens the pty of `simulate`, and one of `hub` with the same gauge behind another one.
fn opens_both(library: fn(&str) -> Command) {
    let folder = Folder::new();
    let [line, slave, tap] = ["line", "slave", "tap"].map(|name| folder.name(name));
    let mut simulate = Program::start(&["simulate", "--pty", &line, "bcg450@5"]);
    simulate.ready();
    opens_again_and_again(library, &mut simulate, &line);
    let mut hub = Program::start(&["hub", "--pty", &slave, "--pty", &tap]);
    hub.ready();
    let behind = Program::start(&["simulate", "--serial", &slave, "bcg450@5"]);
    behind.ready();
    opens_again_and_again(library, &mut hub, &tap);
}

#[test]
fn pyserial_opens_a_pty_again_and_again() {
    opens_both(pyserial);
}

#[test]
fn serialx_opens_a_pty_again_and_again() {
    opens_both(serialx);
}

#[test]
fn serialport_of_npm_opens_a_pty_again_and_again() {
    opens_both(node);
}

#[test]
fn the_crate_serialport_opens_a_pty_again_and_again() {
    opens_both(rust);
}
