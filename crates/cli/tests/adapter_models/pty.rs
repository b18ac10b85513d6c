//! The program through models of adapters in front of a pty, in real time: the delays of the adapter are those of the model, and a loaded
//! computer adds its own.

use crate::adapter_models::adapter::{Adapter, UNKNOWN, timer, usb};
use crate::adapter_models::relay::Relay;
use crate::common::{Folder, Program, run};
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

/// A command, and a text that its output must contain.
type Step = (&'static [&'static str], &'static str);

const SCAN_AND_READ: [Step; 2] = [
    (&["scan", "--hsa", "6"], "bcg450"),
    (&["read", "--address", "5", "pirani.process-value"], "pirani.process-value = "),
];

/// Runs commands through an adapter whose line has a virtual gauge.
fn through(adapter: Adapter, baud: Baud, steps: &[Step]) {
    let folder = Folder::new();
    let (computer, line) = (folder.name("computer"), folder.name("line"));
    let relay = Relay::start(adapter, baud, &folder.path("computer"), &folder.path("line"));
    let rate = baud.bits_per_second().to_string();
    let gauge = Program::start(&["simulate", "--serial", &line, "--baud", &rate, "bcg450@5"]);
    gauge.ready();
    let what = format!("{} at {baud}", adapter.name);
    for (command, wanted) in steps {
        succeeds(&what, &[command, &["--port", &computer, "--baud", &rate][..]].concat(), wanted);
    }
    // Each command gets several answers.
    assert!(relay.end() > 5, "{what}: the answers did not come through the model");
}

#[test]
fn scan_and_read_work_through_a_cp210x_in_front_of_a_pty() {
    RATES.iter().for_each(|baud| through(ADAPTERS[0], *baud, &SCAN_AND_READ));
}

#[test]
fn scan_and_read_work_through_a_pl2303_in_front_of_a_pty() {
    RATES.iter().for_each(|baud| through(ADAPTERS[1], *baud, &SCAN_AND_READ));
}

#[test]
fn scan_and_read_work_through_a_ch341_in_front_of_a_pty() {
    RATES.iter().for_each(|baud| through(ADAPTERS[2], *baud, &SCAN_AND_READ));
}

#[test]
fn scan_and_read_work_through_an_ft232_with_16_ms_in_front_of_a_pty() {
    RATES.iter().for_each(|baud| through(ADAPTERS[3], *baud, &SCAN_AND_READ));
}

/// An adapter behind a serial server looks like this too: the port has no rate, and the answers have the pauses of the adapter. At 19200
/// bit/s an answer of more than 27 characters comes in two pieces.
#[test]
fn a_dump_works_on_a_port_without_a_rate_whose_answers_have_pauses_of_16_ms() {
    let dump: Step = (&["dump", "--address", "5"], "setpoint-b.atmospheric-pressure-reached");
    through(ADAPTERS[3], Baud::B19200, &[dump]);
}
