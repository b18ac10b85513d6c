//! Pictures of a fit: an SVG file with the pressure above its residuals, and a line of the residuals for a terminal.

use profivac_identify::Interval;
use profivac_identify::plant::{Plant, Residual};

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 360.0;
const BELOW: f64 = 110.0;
const LEFT: f64 = 70.0;
const TOP: f64 = 40.0;

/// The largest residual that is drawn, in standard deviations.
const FAR: f64 = 4.0;

/// The upper edge of the residuals.
const FOOT: f64 = TOP + HEIGHT + 24.0;

const DAY_S: f64 = 86_400.0;

const MEASURED: &str = "#666666";
const FIT: &str = "#0072b2";
const PREDICTED: &str = "#d55e00";

/// The axes of a picture: logarithms of seconds and of mbar.
struct Axes {
    /// The first time that is drawn, in s.
    first_s: f64,
    /// The decimal logarithms of the ends of the axis of time.
    times: [f64; 2],
    /// The decimal logarithms of the ends of the axis of pressure.
    decades: [f64; 2],
}

impl Axes {
    fn of(plant: &Plant) -> Self {
        let all = &plant.residuals;
        let last_s = plant.end_s() + DAY_S;
        let first_s = all.iter().map(|one| one.at_s).find(|s| *s > 0.0).unwrap_or(1.0).max(0.1);
        let pressures = || all.iter().flat_map(|one| [one.measured_pa / 100.0, one.fitted_pa / 100.0]);
        let low = pressures().fold(f64::INFINITY, f64::min).min(plant.predicted_pa(last_s).low / 100.0);
        let high = pressures().fold(0.0, f64::max);
        Self {
            first_s,
            times: [first_s.log10().floor(), last_s.log10()],
            decades: [low.log10().floor(), high.log10().ceil()],
        }
    }

    fn x(&self, s: f64) -> f64 {
        let [start, end] = self.times;
        LEFT + WIDTH * (s.max(self.first_s).log10() - start) / (end - start)
    }

    fn y(&self, mbar: f64) -> f64 {
        let [low, high] = self.decades;
        TOP + HEIGHT * (high - mbar.log10()) / (high - low)
    }

    /// The numbers beside the axes.
    fn labels(&self) -> Vec<String> {
        let [low, high] = self.decades.map(|decade| decade as i32);
        let [start, end] = self.times.map(|decade| decade as i32);
        let pressure = |decade: i32| {
            let (x, y) = (LEFT - 6.0, self.y(10_f64.powi(decade)) + 4.0);
            format!("<text x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">1e{decade}</text>")
        };
        let time = |decade: i32| {
            let (x, y) = (self.x(10_f64.powi(decade)) - 10.0, FOOT + BELOW + 18.0);
            format!("<text x=\"{x:.1}\" y=\"{y}\">1e{decade}</text>")
        };
        (low..=high).map(pressure).chain((start..=end).map(time)).collect()
    }
}

/// The height of a residual in standard deviations.
fn residual_y(deviations: f64) -> f64 {
    FOOT + BELOW * (0.5 - deviations.clamp(-FAR, FAR) / FAR / 2.0)
}

/// The measured and the fitted pressure over the logarithm of time with the prediction and its band, and the residuals below.
pub fn svg(plant: &Plant, title: &str) -> String {
    let axes = Axes::of(plant);
    let mut parts = vec![format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"{LEFT}\" y=\"20\">{}</text>",
        LEFT + WIDTH + 20.0,
        FOOT + BELOW + 50.0,
        escaped(title)
    )];
    parts.extend([(TOP, HEIGHT), (FOOT, BELOW)].map(|(top, height)| {
        format!(
            "<rect x=\"{LEFT}\" y=\"{top}\" width=\"{WIDTH}\" height=\"{height}\" fill=\"none\" stroke=\"#888888\"/>"
        )
    }));
    parts.extend(axes.labels());
    parts.push(format!(
        "<text x=\"{LEFT}\" y=\"{}\">seconds since the start of the pump-down; pressure in mbar above, residuals in standard deviations below (±{FAR})</text>",
        FOOT + BELOW + 40.0
    ));
    parts.extend(points(plant, &axes));
    parts.extend(curves(plant, &axes));
    parts.extend(legend());
    parts.push("</svg>\n".to_owned());
    parts.join("\n")
}

/// The measured pressures and their residuals.
fn points(plant: &Plant, axes: &Axes) -> impl Iterator<Item = String> {
    plant.residuals.iter().flat_map(|one| {
        let x = axes.x(one.at_s);
        [axes.y(one.measured_pa / 100.0), residual_y(one.deviations)]
            .map(|y| format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.8\" fill=\"{MEASURED}\"/>"))
    })
}

/// The fit, the prediction with its band, and the zero of the residuals.
fn curves(plant: &Plant, axes: &Axes) -> [String; 5] {
    let fit = plant.residuals.iter().map(|one| (axes.x(one.at_s), axes.y(one.fitted_pa / 100.0))).collect();
    let last_s = plant.end_s() + DAY_S;
    let times = (0..=60).map(|step| last_s.powf(f64::from(step) / 60.0)).filter(|s| *s >= axes.first_s);
    let times: Vec<f64> = times.collect();
    let predicted = |of: fn(Interval) -> f64| {
        times.iter().map(|s| (axes.x(*s), axes.y(of(plant.predicted_pa(*s)) / 100.0))).collect()
    };
    [
        line(fit, FIT, "none"),
        line(predicted(|found| found.mean), PREDICTED, "none"),
        line(predicted(|found| found.low), PREDICTED, "4 3"),
        line(predicted(|found| found.high), PREDICTED, "4 3"),
        line(vec![(LEFT, residual_y(0.0)), (LEFT + WIDTH, residual_y(0.0))], FIT, "none"),
    ]
}

fn line(points: Vec<(f64, f64)>, colour: &str, dash: &str) -> String {
    let points: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let points = points.join(" ");
    format!("<polyline fill=\"none\" stroke=\"{colour}\" stroke-dasharray=\"{dash}\" points=\"{points}\"/>")
}

fn legend() -> [String; 3] {
    let names = [
        (TOP + 18.0, MEASURED, "measured"),
        (TOP + 34.0, FIT, "fit"),
        (TOP + 50.0, PREDICTED, "predicted with the valve open, and its 95 % band"),
    ];
    let x = LEFT + WIDTH - 300.0;
    names.map(|(y, colour, name)| format!("<text x=\"{x}\" y=\"{y}\" fill=\"{colour}\">{name}</text>"))
}

/// One letter for each of at most 60 parts of the record: the mean residual from -2 to 2 standard deviations.
pub fn residual_line(all: &[Residual]) -> String {
    const LETTERS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let size = all.len().div_ceil(60).max(1);
    let letter = |part: &[Residual]| {
        let mean = part.iter().map(|one| one.deviations).sum::<f64>() / part.len() as f64;
        let index = ((mean + 2.0) / 4.0 * 8.0).floor().clamp(0.0, 7.0) as usize;
        LETTERS.get(index).copied().unwrap_or('?')
    };
    all.chunks(size).map(letter).collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}
