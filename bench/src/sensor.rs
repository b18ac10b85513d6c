//! The cost of a sensor: one reading, ten milliseconds after the last.

use profivac_vacuum::sensor::{Drive, Environment, Principle, REFERENCE_K, Range, Sensor};
use profivac_vacuum::{Gas, Mixture};
use std::hint::black_box;

/// A residual atmosphere in which every gas counts.
fn around(pa: f64) -> Environment {
    let mut gas = Mixture::pure(Gas::N2, 0.7 * pa);
    (gas[Gas::H2o], gas[Gas::Ar]) = (0.2 * pa, 0.1 * pa);
    Environment { gas, atmosphere_pa: 101_325.0, temperature_k: REFERENCE_K }
}

/// A gauge with a Pirani, a hot and a cold cathode, and a diaphragm, in a chamber that is pumped down.
pub fn four_sensors(times: u32) {
    let emission = Drive::Emission { milliamperes: 5.0, degas: false };
    let sensor = |principle, lowest_pa, highest_pa| Sensor::real(principle, Range { lowest_pa, highest_pa }, 1);
    let mut sensors = [
        (sensor(Principle::Pirani, 0.08, 1e5), Drive::On),
        (sensor(Principle::HotCathode, 5e-8, 2.0), emission),
        (sensor(Principle::ColdCathode, 1e-7, 1.0), Drive::On),
        (sensor(Principle::Diaphragm, 100.0, 1.5e5), Drive::On),
    ];
    let decades = [1e5, 1e3, 1.0, 1e-3, 1e-6].map(around);
    for time in 0..times {
        let around = &decades[time as usize % decades.len()];
        for (sensor, drive) in &mut sensors {
            black_box(sensor.read(black_box(around), *drive, 0.01));
        }
    }
}
