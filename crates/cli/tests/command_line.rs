//! Wrong command lines fail with one sentence and the exit code of the contract.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, run};

/// Runs a command and checks its exit code and standard error. Standard output stays empty.
#[track_caller]
fn fails(arguments: &[&str], code: i32, sentence: &str) {
    let output = run(arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(message.contains(sentence), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
}

/// Checks the error of a simulation that fails before it makes its pty.
fn simulate(arguments: &[&str], sentence: &str) {
    fails(&[&["simulate", "--pty", "/nowhere/at/all"], arguments].concat(), 2, sentence);
}

#[test]
fn devices_are_checked_before_anything_is_opened() {
    simulate(&["bcg451@5"], "unknown device \"bcg451\"; known: ");
    simulate(&["bcg450@127"], "expected an address from 0 to 126, got \"127\"");
    simulate(&["bcg450"], "expected DEVICE@ADDR[:key=value,...] like bcg450@5, got \"bcg450\"");
    simulate(&["bcg450@5:color=red"], "bcg450 has no key \"color\"; it has ");
    simulate(&["bcg450@5", "bcg450@5"], "two devices at address 5");
    simulate(&["bcg450@5:unit=psi"], "bcg450: expected unit=COUNTS|Torr|Micron|mbar|Pascal, got \"psi\"");
    simulate(&["--state", "/dev/null", "bcg450@5"], "--state /dev/null: ");
    simulate(&[], "required");
}

#[test]
fn options_are_checked_before_anything_is_opened() {
    simulate(&["--baud", "115200", "bcg450@5"], "expected a PROFIBUS rate, one of 9600, 19200, ");
    simulate(&["--pressure", "1e-3", "bcg450@5"], "expected a unit, one of mbar, Pa, ");
    simulate(&["--pressure", "-1 mbar", "bcg450@5"], "expected a pressure like '1e-3 mbar', got \"-1 mbar\"");
    simulate(&["--gas", "steam", "bcg450@5"], "expected a gas, one of n2, air, ");
    simulate(&["--scenario", "pump-down.toml", "--gas", "ar"], "cannot be used with");
    fails(&["simulate", "bcg450@5"], 2, "--pty <PATH>|--serial <DEV>|--show|--tcp <HOST:PORT>");
    fails(&["simulate", "--pty", "/a", "--serial", "/b", "bcg450@5"], 2, "cannot be used with");
    fails(&["simulate", "--tcp", "nonsense", "bcg450@5"], 2, "expected HOST:PORT, got \"nonsense\"");
    fails(&["hub", "--pty", "/nowhere/a"], 2, "expected at least two --pty, got one");
    fails(&["hub", "--pty", "/nowhere/a", "--pty", "/nowhere/a"], 2, "--pty /nowhere/a is given twice");
    fails(&["hub", "--pty", "a", "--pty", "b", "--flip", "2"], 2, "expected a probability from 0 to 1, got \"2\"");
}

#[test]
fn an_unknown_command_is_refused_and_absent_from_the_help() {
    fails(&["dance"], 2, "unrecognized subcommand");
    let help = String::from_utf8(run(&["simulate", "--help"]).stdout).unwrap();
    assert!(help.contains("--scenario") && !help.contains("--listen"), "{help}");
}

#[test]
fn the_error_names_a_port_that_cannot_be_opened() {
    let folder = Folder::new();
    let file = folder.name("file");
    std::fs::write(&file, "precious").unwrap();
    let device = ["bcg450@5"];
    let simulate = |option: &str, port: &str, sentence: &str| {
        fails(&[&["simulate", option, port], &device[..]].concat(), 3, sentence);
    };
    simulate("--serial", "/dev/nothing", "there is no port /dev/nothing");
    simulate("--serial", &file, "is not a serial device");
    simulate("--pty", &file, "exists already");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "precious");
}

/// A path is part of the command line, and no adapter is missing.
#[test]
fn the_error_names_the_cause_when_no_pty_can_be_linked_at_a_path() {
    let folder = Folder::new();
    let file = folder.name("file");
    std::fs::write(&file, "precious").unwrap();
    let inside = format!("{file}/line");
    let long = folder.name(&"x".repeat(300));
    for (path, cause) in [
        ("/proc/x", "No such file or directory"),
        ("/nowhere/at/all", "No such file or directory"),
        (&inside, "Not a directory"),
        (&long, "File name too long"),
    ] {
        let sentence = format!("no link to a pty can be created at {path} ({cause}");
        fails(&["simulate", "--pty", path, "bcg450@5"], 2, &sentence);
        fails(&["hub", "--pty", path, "--pty", &folder.name("b")], 2, &sentence);
    }
}

#[test]
fn a_pressure_that_no_chamber_has_is_refused() {
    let simulate = |option: &str, pressure: &str, sentence: &str| {
        fails(&["simulate", "--tcp", "127.0.0.1:0", option, pressure, "bcg450@5"], 2, sentence);
    };
    for option in ["--pressure", "--atmosphere"] {
        for pressure in ["0 mbar", "1e300 mbar", "1e-320 mbar"] {
            simulate(option, pressure, &format!("expected a pressure from 1e-15 mbar to 10 bar, got {pressure:?}"));
        }
        for pressure in ["nan mbar", "inf mbar", "-1 mbar"] {
            simulate(option, pressure, &format!("expected a pressure like '1e-3 mbar', got {pressure:?}"));
        }
    }
}

#[test]
fn a_port_in_use_is_not_shared() {
    let folder = Folder::new();
    let (a, b) = (folder.name("a"), folder.name("b"));
    let hub = Program::start(&["hub", "--pty", &a, "--pty", &b]);
    hub.ready();
    let first = Program::start(&["simulate", "--serial", &a, "bcg450@5"]);
    assert_eq!(first.ready(), a);
    fails(&["simulate", "--serial", &a, "bcg450@6"], 3, &format!("{a} is in use by another program"));
    fails(&["simulate", "--pty", &a, "bcg450@6"], 3, &format!("{a} exists already"));
    let tcp = Program::start(&["simulate", "--tcp", "127.0.0.1:0", "bcg450@5"]);
    let address = tcp.ready();
    fails(&["simulate", "--tcp", &address, "bcg450@6"], 3, &format!("{address} is in use by another program"));
}
