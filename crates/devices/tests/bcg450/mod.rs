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

use crate::support::{Tester, hex};
use profivac_devices::bcg450::Bcg450;
use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;

type Gauge = Bcg450<RamStore>;

/// As delivered, with the address switch at 5.
fn gauge() -> Gauge {
    Gauge::new(RamStore::default(), Setup::new(5))
}

/// Behind a slave, settled.
fn tester() -> Tester<Gauge> {
    Tester::new(gauge())
}

/// User parameters for mbar, and the configuration of floats without outputs.
const MBAR: &str = "00 00 00 05 1C";
const FLOATS: &str = "44 86 05 05 05 08";
/// Transition command out, floats in.
const COMMANDS: &str = "C6 81 86 05 05 05 05 05 08";

/// In cyclic exchange at this pressure, and so in EXECUTING.
fn exchanging(cfg: &str, mbar: f64) -> Tester<Gauge> {
    let mut tester = tester();
    tester.pressure_mbar(mbar);
    tester.bring_up(&hex(MBAR), &hex(cfg));
    tester
}

/// The octets of slot 1 for an instance.
fn of_instance(tester: &mut Tester<Gauge>, instance: u8, index: u8) -> Vec<u8> {
    tester.put(1, 46, &[instance]).unwrap();
    tester.get(1, index)
}

/// A float at slot 1 for an instance.
fn float(tester: &mut Tester<Gauge>, instance: u8, index: u8) -> f32 {
    f32::from_be_bytes(of_instance(tester, instance, index).try_into().unwrap())
}
