//! The gauge on a board, with its flash store. Its sensor stands for one at an analogue input.
#![no_std]
#![no_main]

use example_gauge::{Example, example_gauge};
use profivac_board::{address_switch, entry, start_timer};
use profivac_devices::Drive;
use profivac_devices::profile::{BlockDevice, Setup};
use profivac_devices::store::Store;
use profivac_gauge::{BUS_RATE, Gauge, run, store};
use profivac_runtime::sensor::{Attached, Measurement, Sensor, SensorStatus};

struct Wire {
    is_on: bool,
}

impl Sensor for Wire {
    fn drive(&mut self, drive: Drive) {
        self.is_on = drive != Drive::Off;
    }

    fn measure(&mut self) -> Measurement {
        Measurement { pa: if self.is_on { 1234.0 } else { 0.0 }, status: SensorStatus::Good }
    }
}

struct Sensors(Attached<Wire>);

impl<S: Store> Gauge<Example, S> for Sensors {
    fn measure(&mut self, device: &mut BlockDevice<Example, S>, _seconds: f64) {
        self.0.serve(device);
    }
}

entry!(main);

fn main() -> ! {
    start_timer();
    let mut gauge = example_gauge(store(), Setup::new(address_switch()));
    let mut sensors = Sensors(Attached::new(Wire { is_on: false }, 0));
    run(&mut gauge, &mut sensors, BUS_RATE)
}
