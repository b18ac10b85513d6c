//! A master exchanges data with three virtual slaves over a line on which one octet in 500 has an inverted bit.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, Program};
use serde_json::Value;

/// The number of exchanges with each slave.
const EXCHANGES: u64 = 1000;

/// The most rows that a loaded computer needs for them; an idle one needs a few seconds.
const ROUNDS: usize = 300;

/// The check octet detects every single inverted bit: no row shows a pressure that was not set, and every slave continues to
/// exchange data.
#[test]
fn exchange_continues_and_no_wrong_value_is_shown() {
    let folder = Folder::new();
    let names = ["master", "a", "b", "c"].map(|name| folder.name(name));
    let ptys: Vec<&str> = names.iter().flat_map(|name| ["--pty", name.as_str()]).collect();
    let mut hub = Program::start(&[&["hub", "--flip", "0.002", "--seed", "7"], &ptys[..]].concat());
    hub.ready();
    let gauges: Vec<_> = [(&names[1], "bcg450@5"), (&names[2], "bcg450@6"), (&names[3], "bcg450@7")]
        .into_iter()
        .map(|(name, gauge)| {
            let program =
                Program::start(&["simulate", "--serial", name, "--baud", "500000", "--pressure", "2e-7 mbar", gauge]);
            program.ready();
            program
        })
        .collect();
    let options = ["--port", &names[0], "--baud", "500000", "--own", "--json", "--timeout", "20"];
    let mut monitor = Program::start(&[&["monitor"], &options[..], &["5", "6", "7"]].concat());
    let (mut least, mut lost, mut rounds) = (0, 0, 0);
    while least < EXCHANGES {
        let rows: Vec<Value> = (0..3).map(|_| serde_json::from_str(&monitor.line()).unwrap()).collect();
        for row in &rows {
            // No value while a slave starts.
            assert!(row["mbar"].is_null() || row["mbar"] == 2e-7, "{row}");
        }
        let counts = |key: &str| rows.iter().map(|row| row[key].as_u64().unwrap()).collect::<Vec<_>>();
        least = counts("exchanges").into_iter().min().unwrap();
        rounds += 1;
        assert!(rounds < ROUNDS, "only {rows:#?} after {rounds} seconds");
        lost = counts("lost").into_iter().sum();
    }
    monitor.terminate();
    assert_eq!(monitor.exit_code(), 0);
    assert_eq!(hub.tell("quit"), "ok");
    // "profivac: 123456 octets, 250 with an inverted bit, 0 lost"
    let complaint = hub.complaint();
    let numbers: Vec<u64> = complaint.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    assert!(numbers[1] > 20, "{complaint}");
    println!("seed 7: {complaint}; {lost} message cycles lost");
    drop(gauges);
}
