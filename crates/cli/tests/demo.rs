//! `demo` exchanges data in memory; its exit code reports whether all of it arrived.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Program, run};
use serde_json::Value;
use std::io::{Read, Write};

fn row(line: &str) -> Value {
    serde_json::from_str(line).unwrap()
}

#[test]
fn the_master_reads_the_pressure_of_the_chamber() {
    let done = run(&["demo", "--headless", "--json", "--speed", "5", "--for", "3"]);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let rows: Vec<_> = String::from_utf8(done.stdout).unwrap().lines().map(row).collect();
    assert!(!rows.is_empty());
    let mut exchanges = 0;
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap();
        // Real sensors deviate: half of the pressure is tolerated.
        assert!((number("read_mbar") / number("true_mbar") - 1.0).abs() < 0.5, "{row}");
        assert!(row["exchanges"].as_u64().unwrap() > exchanges, "{row}");
        assert_eq!(row["lost"], 0);
        exchanges = row["exchanges"].as_u64().unwrap();
    }
    assert!(exchanges > 100, "{exchanges}");
}

#[test]
fn a_table_is_printed_until_a_signal() {
    let mut demo = Program::start(&["demo", "--headless"]);
    assert_eq!(demo.line(), "  SECONDS   TRUE mbar   READ mbar  INSTANCE  EXCHANGES  LOST  GAUGE");
    let columns = demo.line();
    assert_eq!(columns.split_whitespace().count(), 7, "{columns}");
    demo.terminate();
    assert_eq!(demo.exit_code(), 0);
}

#[test]
fn without_a_terminal_demo_prints_a_notice_and_rows() {
    let done = run(&["demo", "--for", "1"]);
    assert_eq!(done.status.code(), Some(0));
    let message = String::from_utf8(done.stderr).unwrap();
    assert!(
        message.starts_with("profivac: standard output is no terminal; printing rows as with --headless, until SIGTERM, Ctrl-C or --for\n"),
        "{message}"
    );
    assert!(message.contains("profivac: the dashboard is at http://127.0.0.1:"), "{message}");
    assert!(done.stdout.starts_with(b"  SECONDS   TRUE mbar"));
}

/// A scenario of two seconds with this expectation of its chamber.
fn scenario(expected: &str) -> tempfile::NamedTempFile {
    let text = format!(
        "title = \"t\"\nuntil = \"2 s\"\n[volumes]\nchamber = {{ volume = \"1 l\" }}\n[gauges]\n\"bcg450@5\" = \"chamber\"\n\
         [[timeline]]\nat = \"1 s\"\nexpect = [{{ volume = \"chamber\", {expected} }}]\n"
    );
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), text).unwrap();
    file
}

/// Without --headless the dashboard is served until the user ends the program, also without a terminal.
#[test]
fn without_a_terminal_the_dashboard_is_served_beyond_the_end_of_the_scenario() {
    let file = scenario("near = \"1013 mbar\"");
    let path = file.path().to_str().unwrap();
    let mut demo = Program::start(&["demo", "--listen", "127.0.0.1:0", "--speed", "10", "--scenario", path]);
    assert!(demo.line().starts_with("  SECONDS"));
    // The scenario lasts two seconds.
    let seconds = |line: &str| line.split_whitespace().next().unwrap().parse::<f64>().unwrap();
    let mut rows = Vec::new();
    while rows.len() < 2 {
        let now = seconds(&demo.line());
        if now > 4.0 {
            rows.push(now);
        }
    }
    let message = [demo.complaint(), demo.complaint()].concat();
    let url = message.split("http://").nth(1).unwrap().trim().trim_end_matches('/').to_owned();
    let mut stream = std::net::TcpStream::connect(&url).unwrap();
    stream.write_all(format!("GET / HTTP/1.1\r\nHost: {url}\r\nConnection: close\r\n\r\n").as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    demo.terminate();
    assert_eq!(demo.exit_code(), 0);
}

/// With --headless the end of the scenario is the end.
#[test]
fn headless_ends_with_the_scenario() {
    let file = scenario("near = \"1013 mbar\"");
    let path = file.path().to_str().unwrap();
    let done = run(&["demo", "--headless", "--listen", "127.0.0.1:0", "--speed", "10", "--scenario", path]);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn the_exit_code_reports_the_expectations_of_a_scenario() {
    for (expected, code, sentence) in [
        ("near = \"1013 mbar\"", 0, ""),
        (
            "below = \"1 mbar\"",
            1,
            "9: after 1 s: expected chamber to have below 1.000e0 mbar, got 1.013e3 mbar\nprofivac: one expectation",
        ),
        ("belwo = \"1 mbar\"", 2, "9:33: unknown field `belwo`, expected one of `volume`, `device`"),
    ] {
        let file = scenario(expected);
        let path = file.path().to_str().unwrap();
        let done = run(&["demo", "--headless", "--speed", "10", "--scenario", path]);
        let message = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(code), "{message}");
        assert!(message.contains(sentence), "{message}");
    }
}

#[test]
fn impossible_options_are_refused() {
    for (arguments, sentence) in [
        (["--speed", "0"], "expected a speed from 0.01 to 10000, got \"0\""),
        (["--for", "-1"], "expected a number of seconds, or a time like '10 min' or 2d, got \"-1\""),
        (["--listen", "here"], "invalid socket address syntax"),
        (["--listen", "0.0.0.0:0"], "expected an address of this computer like 127.0.0.1:8080, got 0.0.0.0:0"),
        (["--scenario", "x.toml"], "x.toml: No such file or directory"),
        (["--scenario", "coatr"], "the name of an included scenario, found \"coatr\"; included: demo, "),
        (["--scenario", "coatr"], "; did you mean \"coater\"?"),
    ] {
        let failed = run(&[&["demo", "--headless"], &arguments[..]].concat());
        assert_eq!(failed.status.code(), Some(2));
        let message = String::from_utf8(failed.stderr).unwrap();
        assert!(message.contains(sentence), "{message}");
    }
}

/// The names are those of the help and of the folder `scenarios`. A file of the same name does not hide a scenario.
#[test]
fn every_included_scenario_runs_by_its_name() {
    let help = String::from_utf8(run(&["help", "demo"]).stdout).unwrap();
    let mut names: Vec<_> = help.split("Included scenarios:").nth(1).unwrap().split_whitespace().collect();
    names.sort_unstable();
    let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios")).unwrap();
    let mut files: Vec<_> = files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    files.sort_unstable();
    assert_eq!(names.iter().map(|name| format!("{name}.toml")).collect::<Vec<_>>(), files);
    let folder = tempfile::tempdir().unwrap();
    for name in names {
        std::fs::write(folder.path().join(name), "no scenario").unwrap();
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_profivac"));
        command.args(["demo", "--headless", "--json", "--scenario", name, "--speed", "1000", "--for", "0.1"]);
        let done = command.current_dir(folder.path()).output().unwrap();
        assert_eq!(done.status.code(), Some(0), "{name}: {}", String::from_utf8_lossy(&done.stderr));
    }
}

#[test]
fn a_database_with_accelerated_time_causes_a_notice() {
    let folder = tempfile::tempdir().unwrap();
    for (speed, has_notice) in [("20", true), ("1", false)] {
        let record = folder.path().join(format!("{speed}.db"));
        let done = run(&["demo", "--headless", "--speed", speed, "--for", "1", "--record", record.to_str().unwrap()]);
        let stderr = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(0), "{stderr}");
        assert_eq!(stderr.contains("everything in it is 20 times as fast as in the plant"), has_notice, "{stderr}");
    }
}

/// The exchanges with a gauge without power are no lost ones.
#[test]
fn a_scenario_that_switches_a_gauge_off_holds_as_a_check() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/filament.toml");
    let done = run(&["demo", "--headless", "--speed", "10000", "--scenario", path]);
    let message = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(0), "{message}");
    let text = String::from_utf8(done.stdout).unwrap();
    assert!(text.lines().skip(1).all(|row| row.ends_with("  bpg400@5")), "{text}");
}
