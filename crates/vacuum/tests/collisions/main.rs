//! Gas flows through short tubes into vacuum, by molecules that collide: the reference of the law of the crate.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod flow;
mod gas;
mod tube;

use flow::{Flow, Setting, simulate};
use gas::Model;

/// A setting that is fine enough for its rarefaction parameter.
fn setting(length: f64, delta: f64, model: Model) -> Setting {
    let cells_per_radius = (2.5 * delta).clamp(10.0, 40.0) as u32;
    // In dense gas the molecules come from near, with the flow; fewer of them decide.
    let is_dense = delta >= 10.0;
    let sample = (12.0 * (40.0 / f64::from(cells_per_radius)).powi(2)).min(120.0);
    Setting {
        length,
        delta,
        model,
        cells_per_radius,
        molecules_per_cell: if cells_per_radius > 30 {
            16.0
        } else if is_dense {
            24.0
        } else {
            60.0
        },
        settle: 8.0 + 3.0 * length,
        sample,
        boxes: [if is_dense { 2 } else { 3 }, 2],
        seed: 1,
    }
}

#[test]
fn flows_of_the_table() {
    let Ok(list) = std::env::var("PROFIVAC_COLLISIONS") else { return };
    for text in list.split_whitespace() {
        let parts: Vec<&str> = text.split(':').collect();
        let (length, delta) = (parts[1].parse::<f64>().unwrap(), parts[2].parse::<f64>().unwrap());
        let model = if parts[0] == "n" { Model::NITROGEN } else { Model::SPHERES };
        let start = std::time::Instant::now();
        let Flow { mean, deviation } = simulate(setting(length, delta, model));
        println!("{} {length} {delta} {mean:.4} {deviation:.4} {:.1} s", parts[0], start.elapsed().as_secs_f64());
    }
}
