//! Mistakes of users: output that cannot be written, wrong files, typing errors. Each ends with one sentence and the right exit
//! code, without a panic and without a false success.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program, run, run_on_terminal};
use std::fs::OpenOptions;
use std::io::{BufRead, BufReader};
use std::process::{Command, Output, Stdio};

const PROFIVAC: &str = env!("CARGO_BIN_EXE_profivac");

/// A full disk.
fn full() -> Stdio {
    OpenOptions::new().write(true).open("/dev/full").unwrap().into()
}

fn stderr_of(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Commands that print without a bus.
const PRINTS: [&[&str]; 8] = [
    &["list", "--device", "bcg450"],
    &["list", "--device", "bcg450", "--json"],
    &["gsd", "bcg450"],
    &["completions", "bash"],
    &["--help"],
    &["help", "scan"],
    &["--version"],
    &["demo", "--headless", "--for", "30"],
];

#[test]
fn a_full_disk_is_a_failure() {
    for arguments in PRINTS {
        let output = Command::new(PROFIVAC).args(arguments).stdout(full()).output().unwrap();
        assert_eq!(
            (output.status.code(), stderr_of(&output).as_str()),
            (Some(3), "profivac: standard output cannot be written: no storage space\n"),
            "{arguments:?}"
        );
    }
}

#[test]
fn a_closed_pipe_ends_an_endless_command_without_a_message() {
    let folder = Folder::new();
    let line = folder.name("line");
    let simulation = Program::start(&["simulate", "--pty", &line, "bcg450@5"]);
    simulation.ready();
    for arguments in [
        &["demo", "--headless"][..],
        &["monitor", "--port", &line, "--own", "--json", "5"],
        &["monitor", "--port", &line, "--own", "--csv", "5"],
    ] {
        let mut child =
            Command::new(PROFIVAC).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut first = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).unwrap();
        let output = child.wait_with_output().unwrap();
        assert!(!first.is_empty());
        assert_eq!((output.status.code(), stderr_of(&output).as_str()), (Some(3), ""), "{arguments:?}");
    }
}

#[test]
fn a_closed_standard_error_does_not_change_the_result() {
    for (arguments, code) in [(&["gsd", "bcg450"][..], 0), (&["gsd", "bcg45"], 2), (&["frobnicate"], 2), (&[], 2)] {
        let output = Command::new(PROFIVAC).args(arguments).stderr(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
    }
}

/// A device or a pipe is not replaced by a file, and no partial file remains.
#[test]
fn settings_are_written_completely_or_not_at_all() {
    let folder = Folder::new();
    let line = folder.name("line");
    let simulation = Program::start(&["simulate", "--pty", &line, "bcg450@5"]);
    simulation.ready();
    let dump = |out: &str| run(&["dump", "--port", &line, "--address", "5", "--out", out]);
    // A link, so that a defect would replace the link and not the device.
    let device = folder.name("device");
    std::os::unix::fs::symlink("/dev/full", &device).unwrap();
    let output = dump(&device);
    let expected = format!("profivac: {device} cannot be written: No space left on device (os error 28)\n");
    assert_eq!((output.status.code(), stderr_of(&output)), (Some(2), expected));
    assert!(folder.path("device").is_symlink());
    let place = folder.name("place");
    std::fs::create_dir(&place).unwrap();
    let output = dump(&place);
    let expected = format!("profivac: {place} cannot be written: Is a directory (os error 21)\n");
    assert_eq!((output.status.code(), stderr_of(&output)), (Some(2), expected));
    let missing = folder.name("missing/file");
    assert_eq!(dump(&missing).status.code(), Some(2));
    let left: Vec<_> = std::fs::read_dir(folder.path("")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().ends_with(".part")), "{left:?}");
}

#[test]
fn the_error_names_a_path_that_is_no_file() {
    let folder = Folder::new();
    let (garbage, place, line) = (folder.name("garbage.toml"), folder.name("place.toml"), folder.name("line"));
    std::fs::write(&garbage, [0xFF, 0x00, 0x80]).unwrap();
    std::fs::create_dir(&place).unwrap();
    let simulation = Program::start(&["simulate", "--pty", &line, "bcg450@5"]);
    simulation.ready();
    let sim = |file: &str| format!("sim:{file}");
    for (file, reason) in [
        (garbage.as_str(), "expected a text in UTF-8, got other octets"),
        (&place, "Is a directory (os error 21)"),
        ("/nowhere.toml", "No such file or directory (os error 2)"),
        ("/dev/zero", "expected a text of at most 262144 octets, got more"),
    ] {
        for arguments in [
            &["demo", "--headless", "--scenario", file][..],
            &["simulate", "--scenario", file, "--tcp", "127.0.0.1:0"],
            &["run", file],
            &["scan", "--port", &sim(file)],
            &["diff", "--port", &line, "--address", "5", file],
            &["restore", "--port", &line, "--address", "5", file],
        ] {
            let output = run(arguments);
            let message = stderr_of(&output);
            assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
            assert!(
                message.starts_with("profivac: ") && message.contains(file) && message.contains(reason),
                "{arguments:?}: {message}"
            );
            assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
        }
    }
}

#[test]
fn an_empty_port_name_is_wrong_usage() {
    for arguments in [&["scan", "--port", ""][..], &["sniff", "--port", ""], &["monitor", "--port", "", "5"]] {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr_of(&output).contains("a value is required for '--port <PORT>'"), "{}", stderr_of(&output));
    }
}

/// A dump is slow on a slow line: on a terminal one line shows the progress, in a script none does.
#[test]
fn a_dump_shows_its_progress_on_a_terminal() {
    let folder = Folder::new();
    let line = folder.name("line");
    let simulation = Program::start(&["simulate", "--pty", &line, "bcg450@5"]);
    simulation.ready();
    let arguments = ["dump", "--port", &line, "--address", "5"];
    let (code, out, shown) = run_on_terminal(&arguments, "88 of 88 parameters", "");
    assert_eq!((code, out.lines().next()), (0, Some("bcg450 at address 5")));
    let steps: String = (0..=88).map(|done| format!("\rprofivac: {done} of 88 parameters")).collect();
    assert_eq!(shown, steps);
    let output = run(&arguments);
    assert_eq!((output.status.code(), stderr_of(&output).as_str()), (Some(0), ""));
}
