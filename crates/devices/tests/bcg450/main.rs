//! The BCG450-SP after tira41d1, each behaviour in its own file. Numbers in brackets are those of errata-bpg-bcg-tpg.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod cathode;
mod channel;
mod exceptions;
mod exchange;
mod limits;
mod memory;
mod property;
mod relays;
mod rows;
mod safe;
mod states;
#[path = "../support/mod.rs"]
mod support;

use profivac_devices::bcg450::Bcg450;
use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;
use support::{Desk, hex};

type Gauge = Bcg450<RamStore>;

/// As delivered, with the address switch at 5.
fn gauge() -> Gauge {
    Gauge::new(RamStore::default(), Setup::new(5))
}

/// Behind a slave, settled.
fn desk() -> Desk<Gauge> {
    Desk::new(gauge())
}

/// mbar, and floats with nothing to send.
const MBAR: &str = "00 00 00 05 1C";
const FLOATS: &str = "44 86 05 05 05 08";
/// Transition command out, floats in.
const COMMANDS: &str = "C6 81 86 05 05 05 05 05 08";

/// In cyclic exchange at this pressure, and so in EXECUTING.
fn exchanging(cfg: &str, mbar: f64) -> Desk<Gauge> {
    let mut desk = desk();
    desk.pressure_mbar(mbar);
    desk.bring_up(&hex(MBAR), &hex(cfg));
    desk
}

/// The octets of slot 1 for an instance.
fn of_instance(desk: &mut Desk<Gauge>, instance: u8, index: u8) -> Vec<u8> {
    desk.put(1, 46, &[instance]).unwrap();
    desk.get(1, index)
}

/// A float at slot 1 for an instance.
fn float(desk: &mut Desk<Gauge>, instance: u8, index: u8) -> f32 {
    f32::from_be_bytes(of_instance(desk, instance, index).try_into().unwrap())
}
