//! The commands for gauges as a program: output, errors and exit codes, with virtual devices on a pty.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod commands;
mod harmless;
mod list;
mod ownership;
mod read;
mod settings;
mod write;

use crate::common::{Folder, Program, run};
use crate::golden;

/// A loaded computer delays answers; the slot time is longer than usual, so that no answer comes too late.
const PATIENTLY: &str = "--slot-time=4000";

/// The messages of a command without those about answers that the load of the computer delayed.
fn without_late_answers(messages: &str) -> String {
    messages.split_inclusive('\n').filter(|line| !line.contains("later than the slot time of")).collect()
}

/// Devices on a pty.
struct Line {
    simulation: Program,
    path: String,
    folder: Folder,
}

/// The result of a command.
#[derive(Debug, PartialEq, Eq)]
struct Done {
    code: i32,
    out: String,
    err: String,
}

impl Line {
    fn with(arguments: &[&str]) -> Self {
        let folder = Folder::new();
        let path = folder.name("line");
        let simulation = Program::start(&[&["simulate", "--pty", &path], arguments].concat());
        simulation.ready();
        Self { simulation, path, folder }
    }

    /// Runs a command: its name, the address, and the rest.
    fn run(&self, command: &str, address: u8, rest: &[&str]) -> Done {
        let address = address.to_string();
        let arguments = [&[command, "--port", &self.path, PATIENTLY, "--address", &address], rest].concat();
        let output = run(&arguments);
        Done {
            code: output.status.code().unwrap(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: without_late_answers(&String::from_utf8(output.stderr).unwrap()),
        }
    }

    /// Runs a command that must succeed, and returns what it prints.
    fn output(&self, command: &str, address: u8, rest: &[&str]) -> String {
        let done = self.run(command, address, rest);
        assert_eq!(done.code, 0, "{command} {rest:?}: {}", done.err);
        done.out
    }

    /// Runs a command that must fail with this code and sentence.
    fn fails(&self, command: &str, address: u8, rest: &[&str], code: i32, sentence: &str) {
        let done = self.run(command, address, rest);
        assert_eq!(
            (done.code, done.err.as_str()),
            (code, format!("profivac: {sentence}\n").as_str()),
            "{command} {rest:?}"
        );
        assert_eq!(done.out, "", "{command} {rest:?}");
    }

    /// Sends a command to the simulation, which must answer `ok`.
    fn tell(&mut self, line: &str) {
        assert_eq!(self.simulation.tell(line), "ok", "{line}");
    }
}

/// Compares with a file of `tests/golden`.
fn compare(name: &str, text: &str) {
    golden::compare(&format!("crates/cli/tests/golden/{name}"), text);
}
