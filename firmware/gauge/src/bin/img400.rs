//! An IMG400 with its flash store. Its sensors are in air.
#![no_std]
#![no_main]

use profivac_board::{address_switch, entry, start_timer};
use profivac_devices::img400::{Gauges, Img400};
use profivac_devices::profile::Setup;
use profivac_gauge::{BUS_RATE, NoSensors, run, store};

entry!(main);

fn main() -> ! {
    start_timer();
    let mut gauge = Img400::new(store(), Setup::new(address_switch()), Gauges::default());
    run(&mut gauge, &mut NoSensors, BUS_RATE)
}
