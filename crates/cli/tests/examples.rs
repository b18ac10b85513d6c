//! The examples of the client crate, run against virtual devices.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

#[path = "../../client/examples/clone_settings.rs"]
mod clone_settings;
#[path = "../../client/examples/read_all.rs"]
mod read_all;
#[path = "../../client/examples/watch.rs"]
pub mod watch;

use crate::common::{Folder, Program};
use profivac_client::{Bus, BusBuilder};
use std::ops::ControlFlow;

fn simulate(path: &str, pressure: &str, devices: &[&str]) -> Program {
    let simulation = Program::start(&[&["simulate", "--pty", path, "--pressure", pressure], devices].concat());
    simulation.ready();
    simulation
}

/// A master that waits for an answer longer than usual: a loaded computer delays the devices.
fn patient(path: &str) -> BusBuilder {
    Bus::builder(path).slot_time(4000)
}

#[test]
fn read_all_reads_every_gauge_that_answers() {
    let folder = Folder::new();
    let path = folder.name("line");
    let _simulation = simulate(&path, "5e-4 mbar", &["bcg450@5", "hpg400@6", "psg550@7", "img400@8"]);
    let mut bus = patient(&path).open().unwrap();
    for address in 5..9 {
        let mut gauge = bus.gauge(address).unwrap();
        if gauge.read("device.device-state").unwrap().text == "IDLE" {
            gauge.command("execute").unwrap();
        }
    }
    let rows = read_all::read_all(&mut bus, 4..10).unwrap();
    let read: Vec<_> = rows
        .iter()
        .map(|row| (row.address, row.title, row.pressure.map(|pressure| format!("{:.3e}", pressure.mbar()))))
        .collect();
    let pressure = Some("5.000e-4".to_owned());
    assert_eq!(
        read,
        [
            (5, "BCG450-SP", pressure.clone()),
            (6, "HPG400-SP", pressure.clone()),
            (7, "PSG550", pressure),
            // Channels 1 and 2 are ionisation gauges without emission; channel 3 is a Pirani below its range.
            (8, "IMG 400", None),
        ]
    );
}

#[test]
fn watch_starts_the_gauges_and_reports_their_pressures_in_turn() {
    let folder = Folder::new();
    let path = folder.name("line");
    let _simulation = simulate(&path, "5e-6 mbar", &["bcg450@5", "hpg400@6"]);
    let bus = patient(&path).open_async().unwrap();
    let mut readings = Vec::new();
    let watched = watch::watch(&bus, &[5, 6], |address, reading| {
        readings.push((address, reading.pressure().map(|pressure| format!("{:.3e}", pressure.mbar()))));
        if readings.len() == 4 { ControlFlow::Break("enough") } else { ControlFlow::Continue(()) }
    });
    assert_eq!(pollster::block_on(watched).unwrap(), Some("enough"));
    assert_eq!(readings.iter().map(|(address, _)| *address).collect::<Vec<_>>(), [5, 6, 5, 6]);
    assert!(readings.iter().all(|(_, pressure)| pressure.as_deref() == Some("5.000e-6")), "{readings:?}");
}

#[test]
fn clone_settings_copies_what_differs_to_the_replacement() {
    let folder = Folder::new();
    let path = folder.name("line");
    let _simulation = simulate(&path, "1 mbar", &["bcg450@5:unit=torr", "bcg450@6:unit=mbar"]);
    let mut bus = patient(&path).open().unwrap();
    bus.gauge(5).unwrap().write("pirani.safe-state", "hold-last-value").unwrap();
    let changes = clone_settings::clone_settings(&mut bus, 5, 6).unwrap();
    let unit = changes.iter().find(|change| change.name == "pirani.data-units").unwrap();
    assert_eq!((unit.before.as_str(), unit.after.as_ref().unwrap().as_str()), ("mbar", "Torr"));
    assert!(changes.iter().any(|change| change.name == "pirani.safe-state"), "{changes:?}");
    assert!(clone_settings::clone_settings(&mut bus, 5, 6).unwrap().is_empty(), "nothing differs any more");
}
