//! How many chambers one core can keep alive in real time: `cargo bench -p profivac-vacuum`.
//!
//! A thousand chambers with a turbo and a fore line each, in high vacuum, in steps of ten milliseconds for a second of their
//! time.

use profivac_vacuum::pump::{Roughing, Turbo};
use profivac_vacuum::surface::{Material, Surface};
use profivac_vacuum::{Atmosphere, Conductance, Network};
use std::time::Instant;

const CHAMBERS: usize = 1000;
const STEPS: u32 = 100;
const STEP_S: f64 = 0.01;

fn main() {
    let mut plants: Vec<_> = (0..CHAMBERS).map(plant).collect();
    let begun = Instant::now();
    for _ in 0..STEPS {
        plants.iter_mut().for_each(|plant| plant.advance(STEP_S));
    }
    let seconds = begun.elapsed().as_secs_f64();
    let step_ns = seconds * 1e9 / (CHAMBERS as f64 * f64::from(STEPS));
    println!("{CHAMBERS} chambers, one second in steps of 10 ms: {seconds:.3} s, {step_ns:.0} ns a step");
}

/// No two are alike.
fn plant(number: usize) -> Network {
    let air = Atmosphere::default().mixture();
    let mut plant = Network::new(Atmosphere::default());
    let chamber = plant.volume(0.1 + 1e-5 * number as f64, air);
    let fore = plant.volume(0.005, air);
    let through = Conductance::tube(0.025, 0.3);
    let turbo = plant.turbo(chamber, fore, Turbo { through, ..Turbo::ordinary(0.3) });
    plant.roughing(fore, Roughing::dry(0.006, 1.0));
    if let Some(steel) = Material::named("steel") {
        plant.wall(chamber, Surface::fresh(1.5, steel));
    }
    plant.advance(300.0);
    plant.run_turbo(turbo, true);
    plant.advance(1800.0);
    plant
}
