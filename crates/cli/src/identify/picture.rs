//! Pictures of a fit: an SVG file with the pressure above its residuals, and a line of the residuals for a terminal.

use profivac_identify::plant::{Plant, Residual};
use std::fmt::Write;

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 360.0;
const BELOW: f64 = 110.0;
const LEFT: f64 = 70.0;
const TOP: f64 = 40.0;

/// The largest residual that is drawn, in standard deviations.
const FAR: f64 = 4.0;

/// The measured and the fitted pressure over the logarithm of time with the prediction and its band, and the residuals below.
pub fn svg(plant: &Plant, title: &str) -> String {
    let all = &plant.residuals;
    let ahead: Vec<f64> = (0..=60).map(|step| (plant.end_s() + 86_400.0).powf(f64::from(step) / 60.0)).collect();
    let first = all.iter().map(|one| one.at_s).find(|s| *s > 0.0).unwrap_or(1.0).max(0.1);
    let times = [first.log10().floor(), (plant.end_s() + 86_400.0).log10()];
    let pressures = || all.iter().flat_map(|one| [one.measured_pa / 100.0, one.fitted_pa / 100.0]);
    let low = pressures().fold(f64::INFINITY, f64::min).min(plant.predicted_pa(plant.end_s() + 86_400.0).low / 100.0);
    let decades = [low.log10().floor(), pressures().fold(0.0, f64::max).log10().ceil()];
    let x = |s: f64| LEFT + WIDTH * (s.max(first).log10() - times[0]) / (times[1] - times[0]);
    let y = |mbar: f64| TOP + HEIGHT * (decades[1] - mbar.log10()) / (decades[1] - decades[0]);
    let foot = TOP + HEIGHT + 24.0;
    let residual = |deviations: f64| foot + BELOW * (0.5 - deviations.clamp(-FAR, FAR) / FAR / 2.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"{LEFT}\" y=\"20\">{}</text>\n",
        LEFT + WIDTH + 20.0,
        foot + BELOW + 50.0,
        escaped(title)
    );
    let mut put = |part: String| writeln!(svg, "{part}").unwrap_or_default();
    for (top, height) in [(TOP, HEIGHT), (foot, BELOW)] {
        put(format!(
            "<rect x=\"{LEFT}\" y=\"{top}\" width=\"{WIDTH}\" height=\"{height}\" fill=\"none\" stroke=\"#888888\"/>"
        ));
    }
    for decade in decades[0] as i32..=decades[1] as i32 {
        put(format!(
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">1e{decade}</text>",
            LEFT - 6.0,
            y(10_f64.powi(decade)) + 4.0
        ));
    }
    for decade in times[0] as i32..=times[1] as i32 {
        put(format!(
            "<text x=\"{:.1}\" y=\"{}\">1e{decade}</text>",
            x(10_f64.powi(decade)) - 10.0,
            foot + BELOW + 18.0
        ));
    }
    put(format!(
        "<text x=\"{LEFT}\" y=\"{}\">seconds since the start of the pump-down; pressure in mbar above, residuals in standard deviations below (±{FAR})</text>",
        foot + BELOW + 40.0
    ));
    for one in all {
        let [across, down] = [x(one.at_s), y(one.measured_pa / 100.0)];
        put(format!("<circle cx=\"{across:.1}\" cy=\"{down:.1}\" r=\"1.8\" fill=\"#666666\"/>"));
        put(format!("<circle cx=\"{across:.1}\" cy=\"{:.1}\" r=\"1.8\" fill=\"#666666\"/>", residual(one.deviations)));
    }
    let line = |points: Vec<(f64, f64)>, colour: &str, dash: &str| {
        let points: Vec<String> = points.iter().map(|(across, down)| format!("{across:.1},{down:.1}")).collect();
        format!(
            "<polyline fill=\"none\" stroke=\"{colour}\" stroke-dasharray=\"{dash}\" points=\"{}\"/>",
            points.join(" ")
        )
    };
    put(line(all.iter().map(|one| (x(one.at_s), y(one.fitted_pa / 100.0))).collect(), "#0072b2", "none"));
    let later: Vec<f64> = ahead.into_iter().filter(|s| *s >= first).collect();
    let curve = |of: &dyn Fn(profivac_identify::Interval) -> f64| {
        later.iter().map(|s| (x(*s), y(of(plant.predicted_pa(*s)) / 100.0))).collect::<Vec<_>>()
    };
    put(line(curve(&|found| found.mean), "#d55e00", "none"));
    put(line(curve(&|found| found.low), "#d55e00", "4 3"));
    put(line(curve(&|found| found.high), "#d55e00", "4 3"));
    put(line(vec![(LEFT, residual(0.0)), (LEFT + WIDTH, residual(0.0))], "#0072b2", "none"));
    for (place, (colour, name)) in
        [("#666666", "measured"), ("#0072b2", "fit"), ("#d55e00", "predicted with the valve open, and its 95 % band")]
            .into_iter()
            .enumerate()
    {
        put(format!(
            "<text x=\"{}\" y=\"{}\" fill=\"{colour}\">{name}</text>",
            LEFT + WIDTH - 300.0,
            TOP + 18.0 + 16.0 * place as f64
        ));
    }
    svg + "</svg>\n"
}

/// One letter for each of at most 60 parts of the record: the mean residual from -2 to 2 standard deviations.
pub fn residual_line(all: &[Residual]) -> String {
    const LETTERS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let size = all.len().div_ceil(60).max(1);
    let letter = |part: &[Residual]| {
        let mean = part.iter().map(|one| one.deviations).sum::<f64>() / part.len() as f64;
        let place = ((mean + 2.0) / 4.0 * 8.0).floor().clamp(0.0, 7.0) as usize;
        LETTERS.get(place).copied().unwrap_or('?')
    };
    all.chunks(size).map(letter).collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}
