//! The program through models of adapters in front of a pty, in real time: the delays of the adapter are those of the model, and a loaded
//! computer adds its own.

use crate::adapter::{Adapter, UNKNOWN, timer, usb};
use crate::common::{Folder, Program, run};
use crate::relay::Relay;
use profivac_dp::link::Baud;

/// The rates at which each model is tried.
const RATES: [Baud; 2] = [Baud::B19200, Baud::B500000];

const ADAPTERS: [Adapter; 4] = [
    usb("CP210x", 64, 0, UNKNOWN),
    usb("PL2303", 64, 0, UNKNOWN),
    usb("CH341", 32, 0, UNKNOWN),
    usb("FT232, latency 16 ms", 62, 16, timer(16)),
];

/// The most tries of a command: a loaded computer may lose its telegrams.
const TRIES: usize = 20;

/// Runs a command until its output has `wanted`, and ends the test if it never has.
fn succeeds(what: &str, command: &[&str], wanted: &str) {
    let mut seen = String::new();
    for _ in 0..TRIES {
        let output = run(command);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        if output.status.success() && text.contains(wanted) {
            return;
        }
        seen = format!("{text}{}", String::from_utf8_lossy(&output.stderr));
        println!("{what}: {seen}");
    }
    panic!("{what}: {seen}");
}

fn scan_and_read(adapter: Adapter, baud: Baud) {
    let folder = Folder::new();
    let (computer, line) = (folder.name("computer"), folder.name("line"));
    let relay = Relay::start(adapter, baud, &folder.path("computer"), &folder.path("line"));
    let rate = baud.bits_per_second().to_string();
    let gauge = Program::start(&["simulate", "--serial", &line, "--baud", &rate, "bcg450@5"]);
    gauge.ready();
    let bus = ["--port", &computer, "--baud", &rate];
    let what = format!("{} at {baud}", adapter.name);
    succeeds(&what, &[&["scan", "--hsa", "6"], &bus[..]].concat(), "bcg450");
    succeeds(
        &what,
        &[&["read", "--address", "5", "pirani.process-value"], &bus[..]].concat(),
        "pirani.process-value = ",
    );
    // Two commands with several answers each.
    assert!(relay.end() > 10, "{what}: the answers did not come through the model");
}

#[test]
fn scan_and_read_work_through_a_cp210x_in_front_of_a_pty() {
    RATES.iter().for_each(|baud| scan_and_read(ADAPTERS[0], *baud));
}

#[test]
fn scan_and_read_work_through_a_pl2303_in_front_of_a_pty() {
    RATES.iter().for_each(|baud| scan_and_read(ADAPTERS[1], *baud));
}

#[test]
fn scan_and_read_work_through_a_ch341_in_front_of_a_pty() {
    RATES.iter().for_each(|baud| scan_and_read(ADAPTERS[2], *baud));
}

#[test]
fn scan_and_read_work_through_an_ft232_with_16_ms_in_front_of_a_pty() {
    RATES.iter().for_each(|baud| scan_and_read(ADAPTERS[3], *baud));
}
