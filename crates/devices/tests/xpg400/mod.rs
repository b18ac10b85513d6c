//! The BPG400-SP and the HPG400-SP after tira36e1, each behaviour in its own file. Numbers in brackets are those of
//! errata-bpg-bcg-tpg.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod adjust;
mod cathode;
mod channel;
mod exceptions;
mod exchange;
mod limits;
mod memory;
mod property;
mod rows;
mod safe;
mod set_points;
mod states;
mod switchover;

use crate::support::{Tester, hex};
use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;
use profivac_devices::xpg400::{Xpg400, Xpg400Model};
use profivac_devices::{Action, SimulatedDevice, Switch, UnsupportedAction};

type Gauge = Xpg400<RamStore>;

const KINDS: [Xpg400Model; 2] = [Xpg400Model::Bpg, Xpg400Model::Hpg];

/// As delivered, with the address switch at 5.
fn gauge(kind: Xpg400Model) -> Gauge {
    Gauge::new(RamStore::default(), kind, Setup::new(5))
}

/// Behind a slave, settled.
fn tester(kind: Xpg400Model) -> Tester<Gauge> {
    Tester::new(gauge(kind))
}

/// User parameters for mbar, and the configuration of floats without outputs.
const MBAR: &str = "00 00 00 05 1C";
const FLOATS: &str = "44 86 05 05 05 08";

/// In cyclic exchange at this pressure, and so in EXECUTING.
fn exchanging(kind: Xpg400Model, cfg: &str, mbar: f64) -> Tester<Gauge> {
    let mut tester = tester(kind);
    tester.pressure_mbar(mbar);
    tester.bring_up(&hex(MBAR), &hex(cfg));
    tester
}

/// Switches power off and on again, and lets the gauge start.
fn restart(tester: &mut Tester<Gauge>) {
    tester.device().set_power(false);
    tester.device().set_power(true);
    tester.slave.power_up(5);
    tester.device().settle();
}

/// The octets of slot 1 for an instance.
fn of_instance(tester: &mut Tester<Gauge>, instance: u8, index: u8) -> Vec<u8> {
    tester.put(1, 46, &[instance]).unwrap();
    tester.get(1, index)
}

fn float_of(octets: &[u8]) -> f32 {
    f32::from_be_bytes(octets.try_into().unwrap())
}

/// A float at slot 1 for an instance.
fn float(tester: &mut Tester<Gauge>, instance: u8, index: u8) -> f32 {
    float_of(&of_instance(tester, instance, index))
}

fn switch(tester: &mut Tester<Gauge>, switch: Switch) -> Result<(), UnsupportedAction> {
    tester.device().operate(Action::Switch(switch))
}
