//! `demo` exchanges data in memory and tells a script whether all of it arrived.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod common;

use common::{Program, run};
use serde_json::Value;

fn row(line: &str) -> Value {
    serde_json::from_str(line).unwrap()
}

#[test]
fn what_the_master_reads_is_the_pressure_of_the_chamber() {
    let done = run(&["demo", "--headless", "--json", "--speed", "20", "--for", "2"]);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let rows: Vec<_> = String::from_utf8(done.stdout).unwrap().lines().map(row).collect();
    assert!(!rows.is_empty());
    let mut exchanges = 0;
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap();
        assert!((number("read_mbar") / number("true_mbar") - 1.0).abs() < 0.05, "{row}");
        assert!(row["exchanges"].as_u64().unwrap() > exchanges, "{row}");
        assert_eq!(row["lost"], 0);
        exchanges = row["exchanges"].as_u64().unwrap();
    }
    assert!(exchanges > 100, "{exchanges}");
}

#[test]
fn a_table_is_printed_until_somebody_ends_it() {
    let mut demo = Program::start(&["demo", "--headless"]);
    assert_eq!(demo.line(), "  SECONDS   TRUE mbar   READ mbar  INSTANCE  EXCHANGES  LOST");
    let columns = demo.line();
    assert_eq!(columns.split_whitespace().count(), 6, "{columns}");
    demo.terminate();
    assert_eq!(demo.exit_code(), 0);
}

#[test]
fn without_a_terminal_it_says_so_and_prints_rows() {
    let done = run(&["demo", "--for", "1"]);
    assert_eq!(done.status.code(), Some(0));
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!(said, "profivac: there is no terminal to draw on: rows as with --headless\n");
    assert!(done.stdout.starts_with(b"  SECONDS   TRUE mbar"));
}

#[test]
fn impossible_options_are_refused() {
    for (arguments, sentence) in [
        (["--speed", "0"], "expected a speed from 0.01 to 10000, got \"0\""),
        (["--for", "-1"], "expected a number of seconds, got \"-1\""),
        (["--listen", "127.0.0.1:8080"], "unexpected argument '--listen'"),
        (["--scenario", "x.toml"], "unexpected argument '--scenario'"),
    ] {
        let failed = run(&[&["demo", "--headless"], &arguments[..]].concat());
        assert_eq!(failed.status.code(), Some(2));
        let said = String::from_utf8(failed.stderr).unwrap();
        assert!(said.contains(sentence), "{said}");
    }
}
