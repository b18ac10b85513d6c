//! The IMG 400 after BG 5530 BEN/A, each behaviour in its own file. Numbers in brackets are those of
//! errata-pxg55x-img400.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod cathode;
mod channel;
mod errors;
mod exchange;
mod memory;
mod property;
mod relays;
mod rows;
mod states;
mod values;

use crate::support::{Tester, hex};
use profivac_devices::img400::{Gauges, Img400, IonGauge, OtherGauge};
use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;

type Controller = Img400<RamStore>;

/// The gauges of channels 1 and 2, and of channels 3 and 4.
const IONS: [Option<IonGauge>; 3] = [None, Some(IonGauge::Bag), Some(IonGauge::Ext)];
const OTHERS: [Option<OtherGauge>; 3] = [None, Some(OtherGauge::Tpr), Some(OtherGauge::Cmr)];

/// As delivered, with the address switch at 5.
fn controller(gauges: Gauges) -> Controller {
    Img400::new(RamStore::default(), Setup::new(5), gauges)
}

/// Behind a slave, settled, with one gauge of each kind.
fn tester() -> Tester<Controller> {
    Tester::new(controller(Gauges::default()))
}

/// Every combination of gauges: the 76 of Appendix A, the four of (155), and none at all.
fn every_combination() -> impl Iterator<Item = Gauges> {
    (0..81).map(|number| Gauges {
        ch1: IONS[number % 3],
        ch2: IONS[number / 3 % 3],
        ch3: OTHERS[number / 9 % 3],
        ch4: OTHERS[number / 27],
    })
}

/// hPa, and configurations: floats alone, with transition commands, with parameter channel, with both and everything.
const HPA: &str = "00 00 00 13 08";
const FLOATS: &str = "45 90 05 08 08 08 08";
const COMMANDS: &str = "C9 81 99 05 05 05 08 08 08 08 0A 0A";
const CHANNEL: &str = "C9 89 98 0A 05 05 0A 05 08 08 08 08";

/// In cyclic exchange with all gauges in one chamber.
fn exchanging(cfg: &str, mbar: f64) -> Tester<Controller> {
    let mut tester = tester();
    tester.pressure_mbar(mbar);
    tester.bring_up(&hex(HPA), &hex(cfg));
    tester
}

/// A float parameter.
fn float(tester: &mut Tester<Controller>, slot: u8, index: u8) -> f32 {
    f32::from_be_bytes(tester.get(slot, index).try_into().unwrap())
}

/// Writes a float.
fn put_float(tester: &mut Tester<Controller>, slot: u8, index: u8, value: f32) -> Result<(), u8> {
    tester.put(slot, index, &value.to_be_bytes())
}
