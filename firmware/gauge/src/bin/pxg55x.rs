//! A gauge of the series PCG55x and PSG55x with its flash store: the name chooses the model. Its sensors are in air.
#![no_std]
#![no_main]

use profivac_board::{address_switch, entry, restart, start_timer};
use profivac_devices::profile::Setup;
use profivac_devices::pxg55x::{Pxg55x, Pxg55xModel};
use profivac_gauge::{BUS_RATE, NoSensors, run, store};

entry!(main);

fn main() -> ! {
    start_timer();
    let Some(model) = Pxg55xModel::named("pcg550", None) else { restart() };
    let mut gauge = Pxg55x::new(store(), model, Setup::new(address_switch()));
    run(&mut gauge, &mut NoSensors, BUS_RATE)
}
