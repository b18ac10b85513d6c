//! The gauge on a board, with its flash store: a Pirani at the analogue input, with a calibration table.
#![no_std]
#![no_main]

use example_gauge::{Example, example_gauge};
use profivac_board::{address_switch, analog_input, entry, start_timer};
use profivac_devices::profile::{BlockDevice, Setup};
use profivac_devices::store::Store;
use profivac_gauge::{BUS_RATE, Gauge, run, store};
use profivac_runtime::pirani::{AnalogInput, CalibrationPoint, Pirani};
use profivac_runtime::sensor::Attached;

/// The analogue input of the board.
struct Input;

impl AnalogInput for Input {
    fn convert(&mut self) -> u16 {
        analog_input()
    }
}

/// The calibration of the Pirani. The table of a real one is measured.
const CALIBRATION: &[CalibrationPoint] = &[
    CalibrationPoint { steps: 200, pa: 0.1 },
    CalibrationPoint { steps: 600, pa: 1.0 },
    CalibrationPoint { steps: 1000, pa: 10.0 },
    CalibrationPoint { steps: 1750, pa: 100.0 },
    CalibrationPoint { steps: 2800, pa: 1000.0 },
    CalibrationPoint { steps: 3600, pa: 10_000.0 },
    CalibrationPoint { steps: 4000, pa: 100_000.0 },
];

struct Sensors(Attached<Pirani<Input>>);

impl<S: Store> Gauge<Example, S> for Sensors {
    fn measure(&mut self, device: &mut BlockDevice<Example, S>, _seconds: f64) {
        self.0.serve(device);
    }
}

entry!(main);

fn main() -> ! {
    start_timer();
    let mut gauge = example_gauge(store(), Setup::new(address_switch()));
    let mut sensors = Sensors(Attached::new(Pirani::new(Input, CALIBRATION), 0));
    run(&mut gauge, &mut sensors, BUS_RATE)
}
