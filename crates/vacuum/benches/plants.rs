//! The number of chambers that one core simulates in real time: `cargo bench -p profivac-vacuum`.
//!
//! A thousand chambers in high vacuum, each with turbo and fore line, for one simulated second in steps of 10 ms; then the
//! same with four gauges per chamber: Pirani, hot cathode, cold cathode, diaphragm.

use profivac_vacuum::network::Volume;
use profivac_vacuum::pump::{Roughing, Turbo};
use profivac_vacuum::sensor::{Drive, Environment, Principle, REFERENCE_K, Range, Sensor};
use profivac_vacuum::surface::{Material, Surface};
use profivac_vacuum::{Atmosphere, Conductance, Network};
use std::hint::black_box;
use std::time::Instant;

const CHAMBERS: usize = 1000;
const STEPS: u32 = 100;
const STEP_S: f64 = 0.01;

fn main() {
    let mut plants: Vec<_> = (0..CHAMBERS).map(plant).collect();
    tell("chambers", || plants.iter_mut().for_each(|(plant, _)| plant.advance(STEP_S)));
    let mut gauges: Vec<_> = (0..CHAMBERS).map(gauges).collect();
    tell("chambers with four gauges each", || {
        for ((plant, chamber), gauges) in plants.iter_mut().zip(&mut gauges) {
            plant.advance(STEP_S);
            let gas = plant.mixture(*chamber);
            let around = Environment { gas, atmosphere_pa: plant.atmosphere().pressure_pa, temperature_k: REFERENCE_K };
            for (gauge, drive) in gauges {
                black_box(gauge.read(&around, *drive, STEP_S));
            }
        }
    });
}

/// Prints the time of the processor for one simulated second.
fn tell(what: &str, mut step: impl FnMut()) {
    let begun = Clock::begun();
    (0..STEPS).for_each(|_| step());
    let seconds = begun.seconds();
    let step_ns = seconds * 1e9 / (CHAMBERS as f64 * f64::from(STEPS));
    println!("{CHAMBERS} {what}, one second in steps of 10 ms: {seconds:.3} s, {step_ns:.0} ns a step");
}

/// A clock that stands while other processes have the core; where the system does not tell that time, it goes on.
struct Clock {
    wall: Instant,
    on_core_ns: Option<u64>,
}

impl Clock {
    fn begun() -> Self {
        Self { wall: Instant::now(), on_core_ns: on_core_ns() }
    }

    fn seconds(&self) -> f64 {
        match self.on_core_ns.zip(on_core_ns()) {
            Some((begun, now)) => now.saturating_sub(begun) as f64 / 1e9,
            None => self.wall.elapsed().as_secs_f64(),
        }
    }
}

/// The time that this thread has had a core, in ns: the first number of this file of Linux.
fn on_core_ns() -> Option<u64> {
    std::fs::read_to_string("/proc/self/schedstat").ok()?.split(' ').next()?.parse().ok()
}

fn gauges(number: usize) -> [(Sensor, Drive); 4] {
    let emission = Drive::Emission { milliamperes: 5.0, degas: false };
    let sensor =
        |principle, lowest_pa, highest_pa| Sensor::real(principle, Range { lowest_pa, highest_pa }, number as u64);
    [
        (sensor(Principle::Pirani, 0.08, 1e5), Drive::On),
        (sensor(Principle::HotCathode, 5e-8, 2.0), emission),
        (sensor(Principle::ColdCathode, 1e-7, 1.0), Drive::On),
        (sensor(Principle::Diaphragm, 100.0, 1.5e5), Drive::On),
    ]
}

/// A plant; no two numbers give the same one.
fn plant(number: usize) -> (Network, Volume) {
    let air = Atmosphere::default().mixture();
    let mut plant = Network::new(Atmosphere::default());
    let chamber = plant.add_volume(0.1 + 1e-5 * number as f64, air);
    let fore = plant.add_volume(0.005, air);
    let through = Conductance::tube(0.025, 0.3);
    let turbo = plant.add_turbo_pump(chamber, fore, Turbo { standstill: through, ..Turbo::ordinary(0.3) });
    plant.add_roughing_pump(fore, Roughing::dry(0.006, 1.0));
    if let Some(steel) = Material::named("steel") {
        plant.add_wall(chamber, Surface::fresh(1.5, steel));
    }
    plant.advance(300.0);
    plant.run_turbo(turbo, true);
    plant.advance(1800.0);
    (plant, chamber)
}
