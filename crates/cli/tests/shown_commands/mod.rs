//! The command lines that help texts and pages of the documentation show, run in a shell. docs/first-steps.md, docs/first-station.md and
//! docs/plc.md, whose commands follow each other, are run by `first_steps`.
//!
//! A command line runs in a folder of its own with the files that the examples name, with gauges and a slave on a line in place of the port,
//! and with a short time in place of a long one. An archive runs without its servers: `contrib/archive/example.py` runs it with them. What the
//! program would ask on a terminal is agreed to as a script agrees. The exit code is 0 unless [`REFUSED`] has the line.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod lines;
mod workplace;

use crate::common::Program;
use lines::{Lines, Shown};
use std::collections::BTreeSet;
use std::process::{Output, Stdio};
use std::thread;
use workplace::{Workplace, adapted, until_data};

/// The commands that end by a signal, unless this word is in the line.
const LASTING: [(&str, &str); 7] = [
    ("demo", "--for"),
    ("simulate", "--show"),
    ("hub", "--for"),
    ("monitor", "--for"),
    ("run", "--check"),
    ("archive", "--check"),
    ("sniff", "--for"),
];

/// Command lines that end with an error here, with a part of its text. Everything else ends with 0.
const REFUSED: [(&str, &str); 3] = [
    // A pty has no rate. The same line runs with a rate, too.
    ("--baud auto", "has no transmission rate to detect"),
    // The choice of an operator is for the database, which does not run here; contrib/archive/cases.py makes both.
    ("--drop-old-samples", "error connecting to server"),
    ("--accept", "error connecting to server"),
];

/// The groups of commands that run side by side.
const GROUPS: [&[&str]; 7] = [
    &["demo", "run", "user", "names", "archive"],
    &["simulate", "hub", "st", "gsd", "device", "completions", "decode"],
    &["scan", "list", "read", "write", "dump", "diff", "restore", "address"],
    &["sniff", "doctor", "monitor", "init"],
    &["report", "export", "backup", "identify"],
    &["conform"],
    &["field-test"],
];

/// Every command line that runs, once.
fn all() -> Vec<Shown> {
    let mut seen = BTreeSet::new();
    let mut lines = Lines::all().complete;
    let with_rate = lines.iter().filter(|shown| shown.line.contains("--baud auto"));
    let with_rate = with_rate.map(|Shown { line, place }| {
        let line = line.replace("--baud auto", "--baud 19200");
        Shown { line, place: place.clone() }
    });
    lines.extend(with_rate.collect::<Vec<_>>());
    // Options in another order are the same command.
    let words = |line: &str| {
        let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        words.sort_unstable();
        words
    };
    lines.retain(|shown| seen.insert(words(&adapted(&shown.line))));
    lines
}

fn text(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|octets| String::from_utf8_lossy(octets).into_owned()).concat()
}

/// Runs a command line as a user would; one that lasts is ended by Ctrl-C after its first line.
fn follow(shown: &Shown) {
    let line = &shown.line;
    let mut workplace = Workplace::new();
    let adapted = adapted(line);
    workplace.prepare(&adapted);
    let typed = adapted.replace("PORT", "line").replace("LINE", "tmp/c");
    let command = shown.command();
    let lasts = LASTING.iter().any(|(name, unless)| *name == command && !typed.contains(unless));
    let refused = REFUSED.iter().find(|(part, _)| line.contains(part));
    if lasts && refused.is_none() {
        let mut program = Program::of(&mut workplace.shell(&format!("exec {typed}")));
        // `sniff` hears nothing on this line. The first line of `demo` is the head of a table.
        let first = match command {
            "sniff" => program.complaint(),
            "demo" => program.line() + &program.line(),
            "monitor" => until_data(&program),
            // It waits for its servers.
            "archive" => program.line() + &program.complaint(),
            _ => program.line(),
        };
        program.interrupt();
        assert_eq!(program.exit_code(), 0, "{typed}: {first}\n{}", program.complaint());
        return;
    }
    let output = workplace.shell(&typed).stdin(Stdio::null()).output().unwrap();
    match refused {
        None => assert!(output.status.success(), "{typed}: {:?}\n{}", output.status.code(), text(&output)),
        Some((_, part)) => {
            assert!(!output.status.success() && text(&output).contains(part), "{typed}\n{}", text(&output));
        }
    }
}

/// Why a command line failed.
fn failure(shown: &Shown) -> Option<String> {
    let reason = std::panic::catch_unwind(|| follow(shown)).err()?;
    let reason = reason.downcast_ref::<String>().map_or("", String::as_str);
    Some(format!("{}: {}: {reason}", shown.place, shown.line))
}

fn of_group(number: usize) -> Vec<Shown> {
    all().into_iter().filter(|shown| GROUPS[number].contains(&shown.command())).collect()
}

/// Follows one command line after the other.
fn follow_group(number: usize) {
    let failed: Vec<String> = of_group(number).iter().filter_map(failure).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
}

/// Follows all command lines of a group at once: each waits a minute for its slave and takes hardly any time of the processor.
fn follow_group_at_once(number: usize) {
    let all = of_group(number);
    let failed: Vec<String> = thread::scope(|scope| {
        let threads: Vec<_> = all.iter().map(|shown| scope.spawn(|| failure(shown))).collect();
        threads.into_iter().filter_map(|thread| thread.join().unwrap()).collect()
    });
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
}

#[test]
fn shown_commands_of_a_station_run() {
    follow_group(0);
}

#[test]
fn shown_commands_without_a_bus_run() {
    follow_group(1);
}

#[test]
fn shown_commands_for_parameters_run() {
    follow_group(2);
}

#[test]
fn shown_commands_that_listen_or_watch_run() {
    follow_group(3);
}

#[test]
fn shown_commands_for_a_record_run() {
    follow_group(4);
}

#[test]
fn shown_commands_for_the_rules_of_dp_run() {
    follow_group_at_once(5);
}

#[test]
fn shown_commands_that_measure_a_line_run() {
    follow_group_at_once(6);
}

#[test]
fn every_shown_command_is_in_one_group() {
    for shown in all() {
        let groups = GROUPS.iter().filter(|group| group.contains(&shown.command())).count();
        assert_eq!(groups, 1, "{}: {}", shown.place, shown.line);
    }
}

#[test]
fn every_command_and_option_that_a_sentence_names_exists() {
    let named = Lines::all().named;
    assert!(named.len() > 40, "{named:?}");
    for shown in &named {
        let help = lines::help_of(shown);
        let known: BTreeSet<&str> =
            help.split(|character: char| !character.is_alphanumeric() && character != '-').collect();
        for option in lines::options(shown) {
            assert!(known.contains(option), "{}: {}: the help does not list {option}", shown.place, shown.line);
        }
    }
}
