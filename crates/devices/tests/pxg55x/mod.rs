//! The PCG55x and PSG55x after tira56e1, each behaviour in its own file. Numbers in brackets are those of
//! errata-pxg55x-img400.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod acyclic;
mod adjust;
mod channel;
mod exceptions;
mod exchange;
mod identity;
mod memory;
mod property;
mod rows;
mod safe;
mod states;
mod trip;
mod ttr;
mod values;

use crate::support::{Tester, hex};
use profivac_devices::profile::Setup;
use profivac_devices::pxg55x::{Pxg55x, Pxg55xModel};
use profivac_devices::store::RamStore;

type Gauge = Pxg55x<RamStore>;

/// A PCG550 with and without its atmosphere sensor, and a PSG550.
fn pcg() -> Pxg55xModel {
    Pxg55xModel::named("pcg550", Some(true)).unwrap()
}

fn pcg_without_atm() -> Pxg55xModel {
    Pxg55xModel::named("pcg550", Some(false)).unwrap()
}

fn psg() -> Pxg55xModel {
    Pxg55xModel::named("psg550", None).unwrap()
}

/// As delivered, with the address switch at 5.
fn gauge(kind: Pxg55xModel) -> Gauge {
    Gauge::new(RamStore::default(), kind, Setup::new(5))
}

/// Behind a slave, settled.
fn tester(kind: Pxg55xModel) -> Tester<Gauge> {
    Tester::new(gauge(kind))
}

/// 3.8
const COUNTS: &str = "00 00 00 10 01";
const TORR: &str = "00 00 00 13 01";
const MBAR: &str = "00 00 00 13 08";
const PASCAL: &str = "00 00 00 13 09";
const TTR: &str = "00 00 00 00 00";

/// Telegrams 4, 10 and 202: floats, floats with parameter channel, floats with relays.
const FLOATS: &str = "44 86 05 05 05 08";
const CHANNEL: &str = "C6 87 8E 0A 0A 05 05 05 08";
const RELAYS: &str = "44 87 05 08 05 0A";

/// In cyclic exchange in mbar at this pressure, and so in EXECUTING.
fn exchanging(kind: Pxg55xModel, cfg: &str, mbar: f64) -> Tester<Gauge> {
    let mut tester = tester(kind);
    tester.pressure_mbar(mbar);
    tester.bring_up(&hex(MBAR), &hex(cfg));
    tester
}

/// In EXECUTING without cyclic exchange.
fn executing(kind: Pxg55xModel, mbar: f64) -> Tester<Gauge> {
    let mut tester = tester(kind);
    tester.pressure_mbar(mbar);
    tester.command(4).unwrap();
    tester
}

/// Switches power off and on again, and lets the gauge start.
fn restart(tester: &mut Tester<Gauge>) {
    use profivac_devices::SimulatedDevice;
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
