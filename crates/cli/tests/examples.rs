//! The examples of the client library, run against virtual devices.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod common;

#[path = "../../client/examples/asynchronous.rs"]
mod asynchronous;
#[path = "../../client/examples/blocking.rs"]
mod blocking;

use common::{Folder, Program};

#[test]
fn the_blocking_example_reads_writes_and_shows_a_refusal() {
    let folder = Folder::new();
    let path = folder.name("line");
    let simulation = Program::start(&["simulate", "--pty", &path, "--pressure", "5e-6 mbar", "bcg450@5"]);
    simulation.ready();
    let lines = blocking::report(&path, 5).unwrap();
    let expected = [
        "BCG450-SP at address 5",
        "instance 2 measures 5.000e-6 mbar",
        "pirani.safe-value is 0.125 mbar now",
        "bcg450 at address 5, device.serial-number (slot 0, index 23): it is read-only (access 1/2_R)",
    ];
    assert_eq!(lines, expected);
}

#[test]
fn the_async_example_reads_several_gauges_on_one_bus() {
    let folder = Folder::new();
    let path = folder.name("line");
    let devices = ["bcg450@5", "hpg400@6", "psg550@7", "img400@8"];
    let simulation = Program::start(&[&["simulate", "--pty", &path, "--pressure", "5e-4 mbar"], &devices[..]].concat());
    simulation.ready();
    let lines = asynchronous::report(&path, &[5, 6, 7, 8]).unwrap();
    let expected = [
        "BCG450-SP at address 5: 5.000e-4 mbar",
        "HPG400-SP at address 6: 5.000e-4 mbar",
        "PSG550 at address 7: 5.000e-4 mbar",
        // Channels 1 and 2 are ionisation gauges without emission; channel 3 is a Pirani.
        "IMG 400 at address 8: 5.000e-4 mbar",
    ];
    assert_eq!(lines, expected);
}
