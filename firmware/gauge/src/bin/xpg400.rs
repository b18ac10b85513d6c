//! A BPG400 or HPG400 with its flash store: the model is an argument of `new`. Its sensors are in air.
#![no_std]
#![no_main]

use profivac_board::{address_switch, entry, start_timer};
use profivac_devices::profile::Setup;
use profivac_devices::xpg400::{Xpg400, Xpg400Model};
use profivac_gauge::{BUS_RATE, NoSensors, run, store};

entry!(main);

fn main() -> ! {
    start_timer();
    let mut gauge = Xpg400::new(store(), Xpg400Model::Bpg, Setup::new(address_switch()));
    run(&mut gauge, &mut NoSensors, BUS_RATE)
}
