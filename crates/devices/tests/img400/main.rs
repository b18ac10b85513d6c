//! The IMG 400 after BG 5530 BEN/A, each behaviour in its own file. Numbers in brackets are those of
//! errata-pxg55x-img400.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod exchange;
mod rows;
#[path = "../support/mod.rs"]
mod support;

use profivac_devices::img400::{Gauges, Img400, IonGauge, OtherGauge};
use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;
use support::Desk;

type Controller = Img400<RamStore>;

/// What can be on channels 1 and 2, and on channels 3 and 4.
const IONS: [Option<IonGauge>; 3] = [None, Some(IonGauge::Bag), Some(IonGauge::Ext)];
const OTHERS: [Option<OtherGauge>; 3] = [None, Some(OtherGauge::Tpr), Some(OtherGauge::Cmr)];

/// As bought, with the address switch at 5.
fn controller(gauges: Gauges) -> Controller {
    Img400::new(RamStore::default(), Setup::new(5), gauges)
}

/// Behind a slave, settled, with one gauge of each kind.
fn desk() -> Desk<Controller> {
    Desk::new(controller(Gauges::default()))
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
