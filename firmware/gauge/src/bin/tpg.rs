//! A TPG300 or TPG500 with its flash store: the table and the boards are arguments of `new`. Its sensors are in air.
#![no_std]
#![no_main]

use profivac_board::{address_switch, entry, start_timer};
use profivac_devices::profile::Setup;
use profivac_devices::tpg::{Tpg, table};
use profivac_gauge::{BUS_RATE, NoSensors, run, store};

entry!(main);

fn main() -> ! {
    start_timer();
    let mut gauge = Tpg::new(&table::TPG300, store(), Setup::new(address_switch()), [None; 4]);
    run(&mut gauge, &mut NoSensors, BUS_RATE)
}
