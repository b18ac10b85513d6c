//! Two independent masters bring the BCG450-SP to Data_Exchange over a pty and read its pressure, and every other device too
//! (`every_device`), and slaves by their GSD files (`gsd_slaves`).
//!
//! pyprofibus 1.13 runs as a Python program in the environment that `./test` makes; profirust 0.6.0 runs in a thread with a
//! port of this test. Comments at the tests name the known defects of each. A pty has no timing, so the tests prove only content
//! and order of telegrams.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

mod every_device;
mod gauge;
mod gsd_slaves;
mod profirust_master;
pub mod pyprofibus_master;
mod pyprofibus_rows;
mod slave;
mod watched;

use crate::common::{Folder, Program};
use crate::serial_libraries::settle;
use gauge::{CONFIGURATIONS, Cfg, UNITS, UnitString};
use slave::Slave;
use std::path::Path;
use watched::Watched;

/// The address of the gauge.
const ADDRESS: u8 = 5;

/// Brings a slave on this pty to Data_Exchange and keeps it there.
type Master = fn(&Path, &Slave) -> Watched;

const PYPROFIBUS: Master = pyprofibus_master::start;
const PROFIRUST: Master = profirust_master::start;

/// The largest configuration of the gauge, with floats, in mbar.
static USUAL: (&Cfg, &UnitString) = (&CONFIGURATIONS[7], &UNITS[3]);

/// A gauge on a separate pty.
fn simulator(folder: &Folder) -> Program {
    let program = Program::start(&["simulate", "--pty", &folder.name("line"), "bcg450@5"]);
    program.ready();
    program
}

fn order(program: &mut Program, line: &str) {
    assert!(program.tell(line).starts_with("ok"), "{line}");
}

/// Changes the true pressure and waits until the master sees it.
fn follow(simulator: &mut Program, master: &Watched, (cfg, unit): (&Cfg, &UnitString), mbar: f64) {
    order(simulator, &format!("pressure {mbar:e} mbar"));
    let what = format!("{mbar} mbar with {} in {}", cfg.octets, unit.name);
    master.until(&what, |inputs| gauge::shows(cfg, unit, inputs, mbar));
}

/// Brings a gauge up once for each configuration and unit, and follows the pressure through the range of each sensor.
fn reads_the_pressure(master: Master, cases: impl IntoIterator<Item = (&'static Cfg, &'static UnitString)>) {
    let folder = Folder::new();
    let mut simulator = simulator(&folder);
    for case in cases {
        let master = master(&folder.path("line"), &gauge::slave(case.0, case.1));
        for mbar in gauge::PRESSURES {
            follow(&mut simulator, &master, case, mbar);
        }
    }
}

#[test]
fn pyprofibus_reads_every_configuration_in_every_unit() {
    reads_the_pressure(PYPROFIBUS, CONFIGURATIONS.iter().flat_map(|cfg| UNITS.iter().map(move |unit| (cfg, unit))));
}

/// Units alternate: profirust needs half a second to claim the token each time.
#[test]
fn profirust_reads_every_configuration() {
    reads_the_pressure(PROFIRUST, CONFIGURATIONS.iter().zip(UNITS.iter().cycle()));
}

/// A program that is started again and again opens the ptys of `simulate` and of `hub` each time.
#[test]
fn pyprofibus_opens_a_pty_again_and_again() {
    let folder = Folder::new();
    let start_three_times = |server: &mut Program, line: &str| {
        for _ in 0..3 {
            PYPROFIBUS(&folder.path(line), &gauge::slave(USUAL.0, USUAL.1)).until_exchanging();
            settle(server);
        }
    };
    start_three_times(&mut simulator(&folder), "line");
    let (slave, tap) = (folder.name("slave"), folder.name("tap"));
    let mut hub = Program::start(&["hub", "--pty", &slave, "--pty", &tap]);
    hub.ready();
    let behind = Program::start(&["simulate", "--serial", &slave, "bcg450@5"]);
    behind.ready();
    start_three_times(&mut hub, "tap");
}

fn returns_after_a_restart_of_the_gauge(master: Master) {
    let folder = Folder::new();
    let mut simulator = simulator(&folder);
    let master = master(&folder.path("line"), &gauge::slave(USUAL.0, USUAL.1));
    follow(&mut simulator, &master, USUAL, 5e-6);
    order(&mut simulator, "power 5 off");
    master.until_lost();
    order(&mut simulator, "power 5 on");
    master.until_exchanging();
    follow(&mut simulator, &master, USUAL, 7e-2);
}

#[test]
fn pyprofibus_exchanges_data_again_after_a_restart_of_the_gauge() {
    returns_after_a_restart_of_the_gauge(PYPROFIBUS);
}

#[test]
fn profirust_exchanges_data_again_after_a_restart_of_the_gauge() {
    returns_after_a_restart_of_the_gauge(PROFIRUST);
}

/// A gauge behind a hub, and the master that loses its answers for 3 s.
fn muted(folder: &Folder, master: Master) -> (Program, Program, Watched) {
    let (line, tap) = (folder.name("line"), folder.name("tap"));
    let mut hub = Program::start(&["hub", "--pty", &line, "--pty", &tap]);
    hub.ready();
    let mut simulator = Program::start(&["simulate", "--serial", &tap, "bcg450@5"]);
    simulator.ready();
    let master = master(&folder.path("line"), &gauge::slave(USUAL.0, USUAL.1));
    follow(&mut simulator, &master, USUAL, 5e-6);
    order(&mut hub, &format!("mute {tap} 3"));
    master.until_lost();
    (hub, simulator, master)
}

#[test]
fn pyprofibus_exchanges_data_again_after_muted_answers() {
    let folder = Folder::new();
    let (_hub, mut simulator, master) = muted(&folder, PYPROFIBUS);
    master.until_exchanging();
    follow(&mut simulator, &master, USUAL, 7e-2);
}

/// profirust never restarts its frame count bit. A slave holds its last answer, as the standard demands, and repeats it to every
/// further request; profirust accepts none of these answers as a diagnosis and stays offline until the slave loses the answer.
#[test]
fn profirust_stays_offline_after_muted_answers_until_the_gauge_restarts() {
    let folder = Folder::new();
    let (_hub, mut simulator, master) = muted(&folder, PROFIRUST);
    master.until_unheeded(20);
    order(&mut simulator, "power 5 off");
    order(&mut simulator, "power 5 on");
    master.until_exchanging();
    follow(&mut simulator, &master, USUAL, 7e-2);
}
