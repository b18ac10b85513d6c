//! The readings of gauges during a pump-down, as numbers in `tests/golden/curves` and as pictures in `docs/curves`, both
//! compared in every run.

use super::picture::{Curve, Picture, Scale};
use super::{devices, scenario};
use crate::golden;
use profivac_virtual::device::VirtualDevice;
use profivac_virtual::scenario::{MasterPresence, Run, Scenario};
use std::fmt::Write;

/// One line of numbers: the time, the true pressure, and the valid reading of each part.
struct Line {
    seconds: f64,
    true_mbar: f64,
    shown: Vec<Option<f64>>,
}

/// Runs a whole scenario, with a line for each time, and returns the names of the columns.
fn record(scenario: &Scenario, times: &[f64]) -> (Vec<String>, Vec<Line>) {
    let mut devices = devices(scenario);
    let mut run = scenario.start(MasterPresence::Absent);
    let mut lines = Vec::new();
    for time in times {
        while run.seconds() + 1e-6 < *time {
            run.step(&mut devices);
        }
        lines.push(line(&run, &devices));
    }
    let names = devices.iter().flat_map(|device| {
        let name = format!("{}@{}", device.device().name(), device.switch_address());
        let parts = device.device().parts().to_vec();
        parts.into_iter().map(move |part| format!("{name} {:?}", part.principle))
    });
    (names.collect(), lines)
}

fn line(run: &Run, devices: &[VirtualDevice]) -> Line {
    let shown = devices.iter().flat_map(|device| {
        let report = device.report();
        let parts = device.device().parts().iter();
        let shown = parts.map(move |part| {
            let shown = report.indicated.iter().find(|it| it.instance == part.instance)?;
            Some(shown.value_mbar).filter(|mbar| shown.valid && *mbar > 0.0)
        });
        shown.collect::<Vec<_>>()
    });
    let true_mbar = run.pressures().find(|(name, _)| *name == "chamber").unwrap().1 / 100.0;
    Line { seconds: run.seconds(), true_mbar, shown: shown.collect() }
}

/// The number of times for each decade of seconds.
fn times(first: f64, last: f64, each: i32) -> Vec<f64> {
    let decades = (last / first).log10();
    let count = (decades * f64::from(each)).round() as i32;
    (0..=count).map(|number| first * 10_f64.powf(decades * f64::from(number) / f64::from(count))).collect()
}

fn table(names: &[String], lines: &[Line]) -> String {
    let mut text = format!("{:>10}{:>12}", "seconds", "true mbar");
    names.iter().for_each(|name| write!(text, "{name:>24}").unwrap());
    text.push('\n');
    for line in lines {
        write!(text, "{:>10.1}{:>12.2e}", line.seconds, line.true_mbar).unwrap();
        for shown in &line.shown {
            let shown = shown.map_or_else(|| "-".to_owned(), |mbar| format!("{mbar:.2e}"));
            write!(text, "{shown:>24}").unwrap();
        }
        text.push('\n');
    }
    text
}

/// The columns whose names `wanted` selects, each as a curve.
fn curves(names: &[String], lines: &[Line], wanted: impl Fn(&str) -> bool) -> Vec<Curve> {
    let truth = lines.iter().map(|line| (line.seconds, line.true_mbar)).collect();
    let mut curves = vec![Curve { name: "true pressure".to_owned(), points: truth }];
    for (number, name) in names.iter().enumerate().filter(|(_, name)| wanted(name)) {
        let points = lines.iter().filter_map(|line| Some((line.seconds, line.shown[number]?))).collect();
        curves.push(Curve { name: name.clone(), points });
    }
    curves
}

#[test]
fn every_gauge_follows_a_pump_down_within_its_range() {
    let scenario = scenario("pump-down");
    let (names, coarse) = record(&scenario, &times(11.0, 3600.0, 8));
    golden::compare("tests/golden/curves/pump-down.txt", &table(&names, &coarse));
    let (names, fine) = record(&scenario, &times(11.0, 3600.0, 60));
    let curves = curves(&names, &fine, |name| !name.starts_with("psg") && !name.contains("Atmosphere"));
    let picture =
        Picture { title: "Pump-down of a clean chamber", x: "seconds", y: "mbar", curves, x_scale: Scale::Logarithmic };
    golden::compare("docs/curves/pump-down.svg", &picture.svg());
}

#[test]
fn argon_and_nitrogen_are_shown_differently() {
    let text = std::fs::read_to_string(super::file("argon")).unwrap();
    // The gas rises slowly through all decades.
    let (head, _) = text.split_once("[[timeline]]").unwrap();
    let rising = |gas: &str| {
        let head = head.replace("gas = \"ar\"", &format!("gas = \"{gas}\"")).replace("80 min", "4000 s");
        let flow =
            "[[timeline]]\nat = \"0 s\"\nclose = [\"gate\"]\nflow = [{ inlet = \"argon\", flow = \"150 sccm\" }]\n";
        let head =
            head.replace("pressure = \"1e-3 mbar\"", "pressure = \"1e-6 mbar\"").replace("\"real\"", "\"ideal\"");
        Scenario::parse(&format!("sensors = \"ideal\"\n{head}{flow}"), "rising.toml").unwrap()
    };
    let mut all = Vec::new();
    let mut text = String::new();
    for gas in ["n2", "ar"] {
        let (names, lines) = record(&rising(gas), &times(0.5, 4000.0, 6));
        writeln!(text, "{gas}").unwrap();
        text += &table(&names, &lines);
        for curve in curves(&names, &lines, |name| name.starts_with("psg") || name == "pcg554@3 Diaphragm").split_off(1)
        {
            let number = names.iter().position(|name| *name == curve.name).unwrap();
            let points = lines.iter().filter_map(|line| Some((line.true_mbar, line.shown[number]?))).collect();
            all.push(Curve { name: format!("{gas}: {}", curve.name), points });
        }
    }
    golden::compare("tests/golden/curves/argon.txt", &text);
    let picture = Picture {
        title: "Argon against nitrogen",
        x: "true mbar",
        y: "indicated mbar",
        curves: all,
        x_scale: Scale::Logarithmic,
    };
    golden::compare("docs/curves/argon.svg", &picture.svg());
}
