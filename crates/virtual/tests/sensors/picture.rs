//! The picture in `docs/sensors.md`: the readings of two gauges in nitrogen, argon and helium.

use super::curves::sweep_of;
use super::shown;
use crate::golden;
use profivac_vacuum::Gas;
use std::fmt::Write;

/// Gauges, and the gases with their colours.
const GAUGES: [(&str, &str); 2] =
    [("bpg400", "BPG400: Pirani, ion gauge"), ("bcg450", "BCG450: Pirani, ion gauge, diaphragm")];
const GASES: [(Gas, &str, &str); 3] =
    [(Gas::N2, "#444444", "nitrogen"), (Gas::Ar, "#c2185b", "argon"), (Gas::He, "#0277bd", "helium")];

/// The axes, in decades of mbar, and a decade in pixels.
const LOWEST: i32 = -6;
const HIGHEST: i32 = 3;
const DECADE: f64 = 40.0;
const SIDE: f64 = (HIGHEST - LOWEST) as f64 * DECADE;

/// The origin of a panel, and the distance to the next one.
const LEFT: f64 = 60.0;
const TOP: f64 = 40.0;
const NEXT: f64 = SIDE + 60.0;

/// The position of a pressure on an axis.
fn place(mbar: f64) -> f64 {
    (mbar.log10() - f64::from(LOWEST)) * DECADE
}

fn pressures() -> Vec<f64> {
    (LOWEST * 40..=HIGHEST * 40).map(|step| 10f64.powf(f64::from(step) / 40.0)).collect()
}

#[test]
fn the_picture_has_the_readings_of_the_gauges() {
    let (width, height) = (LEFT + 2.0 * NEXT, TOP + SIDE + 60.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    for (number, (name, title)) in GAUGES.into_iter().enumerate() {
        writeln!(svg, "<g transform=\"translate({} {TOP})\">", LEFT + number as f64 * NEXT).unwrap();
        svg += &axes(title);
        GASES.iter().for_each(|gas| svg += &curve(name, *gas));
        svg += "</g>\n";
    }
    svg += "</svg>\n";
    golden::compare("docs/pictures/gases.svg", &svg);
}

fn axes(title: &str) -> String {
    let mut svg =
        format!("<text x=\"{}\" y=\"-14\" text-anchor=\"middle\" font-size=\"14\">{title}</text>\n", SIDE / 2.0);
    for decade in LOWEST..=HIGHEST {
        let at = f64::from(decade - LOWEST) * DECADE;
        let up = SIDE - at;
        writeln!(svg, "<path d=\"M{at} 0V{SIDE}M0 {up}H{SIDE}\" stroke=\"#dddddd\"/>").unwrap();
        writeln!(svg, "<text x=\"{at}\" y=\"{}\" text-anchor=\"middle\">1e{decade}</text>", SIDE + 18.0).unwrap();
        writeln!(svg, "<text x=\"-6\" y=\"{}\" text-anchor=\"end\">1e{decade}</text>", up + 4.0).unwrap();
    }
    let (middle, below) = (SIDE / 2.0, SIDE + 40.0);
    writeln!(svg, "<text x=\"{middle}\" y=\"{below}\" text-anchor=\"middle\">true pressure, mbar</text>").unwrap();
    writeln!(
        svg,
        "<text transform=\"translate(-42 {middle}) rotate(-90)\" text-anchor=\"middle\">indicated, mbar</text>"
    )
    .unwrap();
    for (number, (_, colour, name)) in GASES.into_iter().enumerate() {
        writeln!(svg, "<text x=\"12\" y=\"{}\" fill=\"{colour}\">{name}</text>", 18 + 16 * number).unwrap();
    }
    svg
}

fn curve(name: &str, (gas, colour, _): (Gas, &str, &str)) -> String {
    let pressures = pressures();
    let points = pressures.iter().zip(sweep_of(name, gas, pressures.iter().copied(), shown));
    // A point outside the picture is not drawn.
    let seen = points.filter(|(_, shown)| (0.0..=SIDE).contains(&place(*shown)));
    let path: Vec<String> =
        seen.map(|(mbar, shown)| format!("{:.1} {:.1}", place(*mbar), SIDE - place(shown))).collect();
    format!("<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>\n", path.join(" "))
}
