//! The PCG55x and PSG55x after tira56e1, each behaviour in its own file. Numbers in brackets are those of
//! errata-pxg55x-img400.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod exchange;
mod rows;
#[path = "../support/mod.rs"]
mod support;

use profivac_devices::profile::Setup;
use profivac_devices::pxg55x::{Kind, Pxg55x};
use profivac_devices::store::RamStore;
use support::Desk;

type Gauge = Pxg55x<RamStore>;

/// As bought, with the address switch at 5.
fn gauge(kind: Kind) -> Gauge {
    Gauge::new(RamStore::default(), kind, Setup::new(5))
}

/// Behind a slave, settled.
fn desk(kind: Kind) -> Desk<Gauge> {
    Desk::new(gauge(kind))
}

/// 3.8
const COUNTS: &str = "00 00 00 10 01";
const TORR: &str = "00 00 00 13 01";
const MBAR: &str = "00 00 00 13 08";
const PASCAL: &str = "00 00 00 13 09";
const TTR: &str = "00 00 00 00 00";
