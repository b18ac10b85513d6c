//! A BCG450 with its flash store. Its sensors play a pump-down.
#![no_std]
#![no_main]

use profivac_board::{address_switch, entry, start_timer};
use profivac_devices::SimulatedDevice;
use profivac_devices::bcg450::Bcg450;
use profivac_devices::profile::{Behaviour, BlockDevice, Setup};
use profivac_devices::store::Store;
use profivac_gauge::{BUS_RATE, Gauge, run, store};
use profivac_runtime::scenario::{Scenario, Step};
use profivac_runtime::sensor::Attached;

const STEPS: &[Step] =
    &[Step { seconds: 10.0, pa: 100_000.0 }, Step { seconds: 10.0, pa: 50.0 }, Step { seconds: 20.0, pa: 1e-2 }];

struct PumpDown([Attached<Scenario>; 3]);

impl<B: Behaviour, S: Store> Gauge<B, S> for PumpDown {
    fn measure(&mut self, device: &mut BlockDevice<B, S>, seconds: f64) {
        for part in &mut self.0 {
            part.sensor_mut().advance(seconds);
            part.serve(device);
        }
    }
}

entry!(main);

fn main() -> ! {
    start_timer();
    let mut sensors = PumpDown([0, 1, 2].map(|part| Attached::new(Scenario::new(STEPS), part)));
    let mut gauge = Bcg450::new(store(), Setup::new(address_switch()));
    gauge.advance(1.0);
    run(&mut gauge, &mut sensors, BUS_RATE)
}
