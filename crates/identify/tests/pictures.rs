//! The figures of docs/vacuum.md, drawn from fits and compared in every run. `PROFIVAC_BLESS=1` writes them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::fresh::plants;
use crate::golden;
use crate::support::normal;
use profivac_identify::plant::{Phase, PlantRecord, Residual, Volume, identify};
use profivac_identify::rise::{Cause, GasDependence, RiseSetup, analyse};
use profivac_vacuum::Gas;
use std::fmt::Write;

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 400.0;
const MARGIN: f64 = 60.0;
const COLOURS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];

/// The seeds of the drawn plants: the first three of a fresh range.
const PLANTS: [u64; 3] = [50_001, 50_002, 50_003];

/// Axes from `low` to `high`, and pictures of points as dots or lines.
struct Picture {
    low: [f64; 2],
    high: [f64; 2],
    svg: String,
    names: usize,
}

impl Picture {
    fn new(title: &str, axes: [&str; 2], low: [f64; 2], high: [f64; 2]) -> Self {
        let [wide, tall] = [WIDTH + 2.0 * MARGIN, HEIGHT + 2.0 * MARGIN];
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {wide} {tall}\" font-family=\"sans-serif\" font-size=\"12\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        writeln!(svg, "<rect x=\"{MARGIN}\" y=\"{MARGIN}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#888888\"/>")
            .unwrap();
        let mut picture = Self { low, high, svg, names: 0 };
        picture.word(MARGIN, 20.0, "#222222", title);
        picture.word(MARGIN + WIDTH / 2.0, tall - 12.0, "#222222", axes[0]);
        picture.word(8.0, MARGIN - 14.0, "#222222", axes[1]);
        picture
    }

    fn word(&mut self, x: f64, y: f64, colour: &str, text: &str) {
        writeln!(self.svg, "<text x=\"{x:.0}\" y=\"{y:.0}\" fill=\"{colour}\">{text}</text>").unwrap();
    }

    fn place(&self, point: [f64; 2]) -> [f64; 2] {
        let part = |axis: usize| (point[axis] - self.low[axis]) / (self.high[axis] - self.low[axis]);
        [MARGIN + WIDTH * part(0), MARGIN + HEIGHT * (1.0 - part(1))]
    }

    fn mark(&mut self, point: [f64; 2], text: &str) {
        let [x, y] = self.place(point);
        let at = if point[1] <= self.low[1] { [x - 10.0, y + 16.0] } else { [x - 50.0, y + 4.0] };
        self.word(at[0], at[1], "#222222", text);
    }

    fn dots(&mut self, points: &[[f64; 2]]) {
        for point in points {
            let [x, y] = self.place(*point);
            writeln!(self.svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.5\" fill=\"#888888\"/>").unwrap();
        }
    }

    fn line(&mut self, name: &str, points: &[[f64; 2]]) {
        let colour = COLOURS[self.names % COLOURS.len()];
        let places = points.iter().map(|point| self.place(*point)).map(|[x, y]| format!("{x:.1},{y:.1}"));
        let places = places.collect::<Vec<_>>().join(" ");
        writeln!(self.svg, "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" points=\"{places}\"/>")
            .unwrap();
        self.word(MARGIN + 20.0, MARGIN + 20.0 + 16.0 * self.names as f64, colour, name);
        self.names += 1;
    }

    fn compare(mut self, name: &str) {
        self.svg += "</svg>\n";
        golden::compare(&format!("docs/curves/{name}"), &self.svg);
    }
}

/// Rises into 100 l in Pa: a leak, outgassing after an hour, and both, with the cause that the fit states.
#[test]
fn three_rises_are_drawn_with_their_fits() {
    let setup = RiseSetup {
        volume_m3: 0.1,
        pumped_s: Some(3600.0),
        gauge: GasDependence::None,
        outgassed: Gas::H2o,
        gauge_uncertainty: 0.0,
        gas_k: 293.15,
    };
    let mut picture = Picture::new("Three rises of 100 l", ["minutes", "Pa"], [0.0, 0.0], [30.0, 0.3]);
    for minutes in [0, 10, 20, 30] {
        picture.mark([f64::from(minutes), 0.0], &format!("{minutes}"));
    }
    for tenth in [1, 2, 3] {
        picture.mark([0.0, f64::from(tenth) / 10.0], &format!("0.{tenth}"));
    }
    for (leak, outgassing, expected) in
        [(5e-6, 0.0, Cause::Leak), (0.0, 5.1e-6, Cause::Outgassing), (1e-5, 5.1e-6, Cause::Both)]
    {
        let mut random = fastrand::Rng::with_seed(9);
        let pa = |t: f64| 1e-5 + (leak * t + outgassing * 3600.0 * (t / 3600.0).ln_1p()) / 0.1;
        let samples: Vec<_> =
            (0..=180).map(|k| f64::from(k) * 10.0).map(|t| (t, pa(t) * (1.0 + 0.005 * normal(&mut random)))).collect();
        let rise = analyse(&samples, &setup).unwrap();
        let stated = rise.cause == expected || expected == Cause::Both && rise.cause == Cause::Leak;
        assert!(stated, "{:?} {:?} {:?}", rise.cause, rise.leak, rise.outgassing);
        picture.dots(&samples.iter().step_by(3).map(|(t, pa)| [t / 60.0, *pa]).collect::<Vec<_>>());
        let [leak, walls] = [rise.leak, rise.outgassing].map(|flow| flow.pa_m3_per_s);
        let name = format!(
            "leak {:.1e} to {:.1e}, outgassing {:.1e} to {:.1e} Pa m³/s",
            leak.low, leak.high, walls.low, walls.high
        );
        picture.line(&name, &rise.fitted.iter().map(|(t, pa)| [t / 60.0, *pa]).collect::<Vec<_>>());
    }
    picture.compare("rises.svg");
}

/// Two hours of pumping and a rise; the prediction beside six more hours that the fit did not see.
#[test]
fn a_prediction_is_drawn_beside_the_measurement() {
    let mut random = fastrand::Rng::with_seed(9);
    // S / V = 2 / s; leak 1e-6, outgassing 5e-6 Pa m3/s after an hour, in 100 l.
    let gas = |t: f64| (1e-6 + 5e-6 * 3600.0 / t.max(1.0)) / 0.1;
    let (mut t, mut pa, mut all) = (0.0_f64, 10.0_f64, Vec::new());
    while t < 8.0 * 3600.0 {
        let step = (0.02 * t).max(0.05);
        for _ in 0..100 {
            let end = gas(t + step / 200.0) / 2.0;
            pa = end + (pa - end) * (-0.02 * step).exp();
            t += step / 100.0;
        }
        all.push((t, pa * (1.0 + 0.01 * normal(&mut random))));
    }
    let mut seen: Vec<_> = all.iter().copied().filter(|(t, _)| *t < 7200.0).collect();
    let (closed, mut pa) = *seen.last().unwrap();
    for _ in 0..100 {
        let t = seen.last().unwrap().0;
        pa += gas(t + 9.0) * 18.0;
        seen.push((t + 18.0, pa * (1.0 + 0.01 * normal(&mut random))));
    }
    let phases = vec![Phase { from_s: 0.0, pumped: true }, Phase { from_s: closed, pumped: false }];
    let plant =
        identify(&PlantRecord { samples: seen, phases, volume: Volume::Given(0.1), gauge_uncertainty: 0.0 }).unwrap();
    assert!(plant.leak.contains(1e-6), "{:?}", plant.leak);
    let mut picture = Picture::new(
        "Pump-down: measured, and predicted from the first two hours",
        ["seconds", "Pa"],
        [-1.0, -6.0],
        [5.0, 1.0],
    );
    for decade in -1..=5 {
        picture.mark([f64::from(decade), -6.0], &format!("1e{decade}"));
    }
    for decade in -5..=1 {
        picture.mark([-1.0, f64::from(decade)], &format!("1e{decade}"));
    }
    picture.dots(&all.iter().step_by(2).map(|(t, pa)| [t.log10(), pa.log10()]).collect::<Vec<_>>());
    let times: Vec<f64> = (-10..=47).map(|tenth| 10_f64.powf(f64::from(tenth) / 10.0)).collect();
    let curve = |of: &dyn Fn(profivac_identify::Interval) -> f64| -> Vec<[f64; 2]> {
        times.iter().map(|t| [t.log10(), of(plant.predicted_pa(*t)).log10()]).collect()
    };
    picture.line("prediction", &curve(&|interval| interval.mean));
    picture.line("95 % band, above", &curve(&|interval| interval.high));
    picture.line("95 % band, below", &curve(&|interval| interval.low));
    picture.compare("identified.svg");
}

/// Three of the random plants, each with its fit; the intervals of leak and outgassing beside the true numbers. The coloured lines are
/// the fits through the dots of the measurement, with the rise at the end.
#[test]
fn three_random_plants_are_drawn_with_their_fits() {
    let mut picture = Picture::new(
        "Three random plants: measured, and fitted with the rise at the end",
        ["seconds", "Pa"],
        [-1.0, -7.0],
        [5.0, 3.0],
    );
    for decade in -1..=5 {
        picture.mark([f64::from(decade), -7.0], &format!("1e{decade}"));
    }
    for decade in -6..=3 {
        picture.mark([-1.0, f64::from(decade)], &format!("1e{decade}"));
    }
    for seed in PLANTS {
        let truth = plants::Truth::of(seed);
        let plant = identify(&truth.record(seed)).unwrap();
        for (found, true_number) in [
            (plant.leak, truth.leak),
            (plant.outgassing_1h, truth.outgassing_1h),
            (plant.exponent, truth.exponent),
            (plant.ultimate_pa, truth.ultimate_pa),
        ] {
            assert!(found.contains(true_number), "{seed}: {true_number:e} is not within {found:?}");
        }
        let shown = || plant.residuals.iter().filter(|one| one.at_s >= 0.1);
        let points = |pa: fn(&Residual) -> f64| -> Vec<[f64; 2]> {
            shown().map(|one| [one.at_s.log10(), pa(one).log10()]).collect()
        };
        picture.dots(&points(|one| one.measured_pa));
        let name = format!(
            "leak {:.1e} to {:.1e} (true {:.1e}), outgassing {:.1e} to {:.1e} (true {:.1e}) Pa m³/s",
            plant.leak.low,
            plant.leak.high,
            truth.leak,
            plant.outgassing_1h.low,
            plant.outgassing_1h.high,
            truth.outgassing_1h
        );
        picture.line(&name, &points(|one| one.fitted_pa));
    }
    picture.compare("three-plants.svg");
}
