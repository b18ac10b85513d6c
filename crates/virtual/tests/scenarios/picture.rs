//! Curves on log-log axes as SVG in plain text, so that a change is visible in a comparison.

use std::fmt::Write;

/// The size of the plot area and of its margin.
const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 440.0;
const MARGIN: f64 = 64.0;

const COLOURS: [&str; 8] = ["#222222", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5195"];

pub struct Curve {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// How numbers are placed on an axis.
#[derive(Clone, Copy)]
pub enum Scale {
    Linear,
    Logarithmic,
}

/// A picture; its vertical axis is logarithmic.
pub struct Picture<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    pub curves: Vec<Curve>,
    pub x_scale: Scale,
}

/// A linear axis from 0.
struct Ticks {
    each: f64,
    to: f64,
}

impl Ticks {
    /// About eight steps of 1, 2 or 5 times a power of ten.
    fn up_to(largest: f64) -> Self {
        let power = 10_f64.powf((largest / 8.0).log10().floor());
        let each = [1.0, 2.0, 5.0, 10.0].map(|step| step * power).into_iter().find(|each| largest / each <= 10.0);
        let each = each.unwrap_or(largest);
        Self { each, to: (largest / each).ceil() * each }
    }
}

/// Whole decades around some numbers.
struct Decades {
    from: f64,
    to: f64,
}

impl Decades {
    fn around(numbers: impl Iterator<Item = f64> + Clone) -> Self {
        let from = numbers.clone().fold(f64::INFINITY, f64::min).log10().floor();
        let to = numbers.fold(f64::MIN_POSITIVE, f64::max).log10().ceil();
        Self { from, to }
    }

    /// 0 to 1.
    fn part(&self, number: f64) -> f64 {
        (number.log10() - self.from) / (self.to - self.from)
    }

    fn all(&self) -> impl Iterator<Item = i32> {
        self.from as i32..=self.to as i32
    }
}

impl Picture<'_> {
    pub fn svg(&self) -> String {
        let points = || self.curves.iter().flat_map(|curve| curve.points.iter());
        let largest = points().map(|(x, _)| *x).fold(f64::MIN_POSITIVE, f64::max);
        let x = Decades::around(points().map(|(x, _)| *x));
        let ticks = Ticks::up_to(largest);
        let y = Decades::around(points().map(|(_, y)| *y));
        let part = |number: f64| match self.x_scale {
            Scale::Linear => number / ticks.to,
            Scale::Logarithmic => x.part(number),
        };
        let left = |number: f64| MARGIN + WIDTH * part(number);
        let top = |number: f64| MARGIN + HEIGHT * (1.0 - y.part(number));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0} {:.0}\" font-family=\"sans-serif\" \
             font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            WIDTH + 4.0 * MARGIN,
            HEIGHT + 2.0 * MARGIN
        );
        word(&mut svg, MARGIN, MARGIN / 2.0, "start", self.title);
        let marks: Vec<(f64, String)> = match self.x_scale {
            Scale::Logarithmic => x.all().map(|decade| (10_f64.powi(decade), format!("1e{decade}"))).collect(),
            Scale::Linear => (0..=(ticks.to / ticks.each).round() as i32)
                .map(|step| f64::from(step) * ticks.each)
                .map(|number| (number, format!("{}", (number * 1e6).round() / 1e6)))
                .collect(),
        };
        for (number, mark) in marks {
            let at = left(number);
            line(&mut svg, [at, MARGIN, at, MARGIN + HEIGHT]);
            word(&mut svg, at, MARGIN + HEIGHT + 18.0, "middle", &mark);
        }
        for decade in y.all() {
            let at = top(10_f64.powi(decade));
            line(&mut svg, [MARGIN, at, MARGIN + WIDTH, at]);
            word(&mut svg, MARGIN - 6.0, at + 4.0, "end", &format!("1e{decade}"));
        }
        word(&mut svg, MARGIN + WIDTH / 2.0, HEIGHT + 1.7 * MARGIN, "middle", self.x);
        word(&mut svg, MARGIN / 4.0, MARGIN - 14.0, "start", self.y);
        for (number, (curve, colour)) in self.curves.iter().zip(COLOURS.iter().cycle()).enumerate() {
            let points = curve.points.iter().map(|(x, y)| format!("{:.1},{:.1}", left(*x), top(*y)));
            let points = points.collect::<Vec<_>>().join(" ");
            writeln!(svg, "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" points=\"{points}\"/>")
                .unwrap();
            let at = MARGIN + 16.0 * number as f64;
            writeln!(
                svg,
                "<text x=\"{:.0}\" y=\"{at:.0}\" fill=\"{colour}\">{}</text>",
                MARGIN + WIDTH + 12.0,
                curve.name
            )
            .unwrap();
        }
        svg += "</svg>\n";
        svg
    }
}

fn line(svg: &mut String, [x1, y1, x2, y2]: [f64; 4]) {
    writeln!(svg, "<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" stroke=\"#dddddd\"/>").unwrap();
}

fn word(svg: &mut String, x: f64, y: f64, anchor: &str, text: &str) {
    writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>").unwrap();
}
