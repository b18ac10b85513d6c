//! Gas flows through short tubes into vacuum, by direct simulation of molecules that collide: the reference of the law of the crate.
//!
//! The flows of docs/vacuum.md, in about an hour of one processor core:
//! `PROFIVAC_TUBES="n:1:10 s:0:10" cargo test --release -p profivac-vacuum --test all collisions:: -- --ignored --nocapture`
//! prints those of nitrogen (n) or hard spheres (s) for a length by radius and a rarefaction parameter; `n:1:10:0.5` into half the
//! pressure, `n:1:10:0.5:4` with an average over four times the time.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod flow;
mod gas;
mod tube;

use flow::{Flow, Setting, simulate};
use gas::Model;

/// A setting that is fine enough for its rarefaction parameter.
fn setting(length: f64, delta: f64, behind: f64, model: Model) -> Setting {
    let cells_per_radius = (2.5 * delta).clamp(10.0, 40.0) as u32;
    // In dense gas the molecules come from near, with the flow; fewer of them decide.
    let is_dense = delta >= 10.0;
    let molecules_per_cell = match cells_per_radius {
        31.. => 16.0,
        _ if is_dense => 24.0,
        _ => 60.0,
    };
    Setting {
        length,
        delta,
        model,
        behind,
        cells_per_radius,
        molecules_per_cell,
        settle: 8.0 + 3.0 * length,
        sample: (12.0 * (40.0 / f64::from(cells_per_radius)).powi(2)).min(120.0),
        // Gas behind the tube comes from as far as that before it.
        boxes: if behind > 0.0 { [3, 3] } else { [if is_dense { 2 } else { 3 }, 2] },
        seed: 1,
    }
}

/// A flow of the table, from its text.
fn wanted(text: &str) -> Setting {
    let mut parts = text.split(':');
    let model = match parts.next() {
        Some("n") => Model::NITROGEN,
        Some("s") => Model::SPHERES,
        other => panic!("expected n or s, found {other:?}"),
    };
    let mut number = || parts.next().map(|number| number.parse::<f64>().unwrap());
    let (length, delta) = (number().unwrap(), number().unwrap());
    let behind = number().unwrap_or(0.0);
    // The average takes this many times as long.
    let times = number().unwrap_or(1.0);
    let setting = setting(length, delta, behind, model);
    Setting { sample: times * setting.sample, ..setting }
}

/// Prints the flows of `PROFIVAC_TUBES`.
#[test]
#[ignore = "a calculation of hours, which compares nothing"]
fn the_flows_of_the_table_are_printed() {
    let Ok(list) = std::env::var("PROFIVAC_TUBES") else { return };
    for text in list.split_whitespace() {
        let Flow { mean, deviation } = simulate(wanted(text));
        println!("{text}: {mean:.4} with a standard deviation of {deviation:.4}");
    }
}

/// Without collisions the flow is that of Clausing; with them it is that of the table, for a coarse and quick setting.
#[test]
fn coarse_flows_agree_with_clausing_and_with_the_table() {
    for (length, delta, expected) in [(1.0, 0.0, 0.672), (1.0, 3.0, 0.871)] {
        let coarse = Setting {
            cells_per_radius: 8,
            molecules_per_cell: 30.0,
            sample: 60.0,
            ..setting(length, delta, 0.0, Model::SPHERES)
        };
        let Flow { mean, deviation } = simulate(coarse);
        assert!(deviation < 0.02, "{deviation}");
        assert!((mean - expected).abs() < 3.0 * deviation + 0.01, "l/r = {length}, δ = {delta}: {mean} ± {deviation}");
    }
}
