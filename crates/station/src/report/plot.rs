//! A chart as SVG. The style sheet of the page sets colours and dashes, so that the chart follows a dark page.

use super::format::escape;
use profivac_recorder::Quality;
use std::fmt::Write;

const WIDTH: f64 = 820.0;
const LEFT: f64 = 64.0;
/// The width of the column with the names of the curves.
const RIGHT: f64 = 150.0;
/// The height of the row with the numbers of the events.
const TOP: f64 = 30.0;
const HEIGHT: f64 = 350.0;
/// The height of the labels below the axis.
const FOOT: f64 = 56.0;
const LANE: f64 = 16.0;
/// The smallest distance between two names or numbers.
const APART: f64 = 15.0;

/// The number of line styles.
pub const STYLES: usize = 8;

/// The longest name beside a curve, in characters.
const LONGEST_NAME: usize = 18;

/// An axis.
pub struct Axis {
    /// The values at both ends; their logarithms if the axis is logarithmic.
    pub ends: (f64, f64),
    /// Whether the axis is logarithmic.
    pub is_log: bool,
    /// Labelled grid lines: value, label, second line of the label.
    pub ticks: Vec<(f64, String, String)>,
    /// Grid lines without labels.
    pub minor: Vec<f64>,
    /// The title of the axis.
    pub label: String,
}

/// A curve.
pub struct Curve {
    /// Its name.
    pub name: String,
    /// Its line style.
    pub style: usize,
    /// Its connected points. Between two runs the curve has a gap.
    pub runs: Vec<Vec<(f64, f64)>>,
    /// The times with another quality than valid.
    pub spans: Vec<(f64, f64, Quality)>,
}

/// A chart.
pub struct Plot {
    /// An identifier, unique on the page.
    pub id: &'static str,
    /// The text alternative, in a sentence.
    pub description: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The curves.
    pub curves: Vec<Curve>,
    /// Horizontal lines: names and values.
    pub levels: Vec<(String, f64)>,
    /// Events: numbers and positions.
    pub marks: Vec<(usize, f64)>,
}

impl Axis {
    /// The position of a value on the axis: 0 and 1 are its ends.
    fn share(&self, value: f64) -> f64 {
        let value = if self.is_log { value.log10() } else { value };
        (value - self.ends.0) / (self.ends.1 - self.ends.0)
    }

    fn has(&self, value: f64) -> bool {
        (-1e-9..=1.0 + 1e-9).contains(&self.share(value))
    }
}

impl Plot {
    /// The chart as SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        let lanes: Vec<&Curve> = self.curves.iter().filter(|curve| !curve.spans.is_empty()).collect();
        let height = TOP + HEIGHT + FOOT + if lanes.is_empty() { 0.0 } else { 8.0 + LANE * lanes.len() as f64 };
        let mut svg = String::new();
        let id = self.id;
        put(&mut svg, &format!("<svg viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" aria-labelledby=\"{id}-is\">\n"));
        put(&mut svg, &format!("<title id=\"{id}-is\">{}</title>\n", escape(&self.description)));
        put(&mut svg, &self.defs());
        self.grid(&mut svg);
        self.levels(&mut svg);
        self.marks(&mut svg);
        put(&mut svg, &format!("<g clip-path=\"url(#{id}-in)\">\n"));
        self.curves.iter().for_each(|curve| self.curve(&mut svg, curve));
        put(&mut svg, "</g>\n");
        self.names(&mut svg);
        lanes.iter().enumerate().for_each(|(index, curve)| self.lane(&mut svg, index, curve));
        put(&mut svg, "</svg>\n");
        svg
    }

    fn px(&self, value: f64) -> f64 {
        LEFT + self.x.share(value) * (WIDTH - LEFT - RIGHT)
    }

    fn py(&self, value: f64) -> f64 {
        TOP + (1.0 - self.y.share(value)) * HEIGHT
    }

    /// Clip paths for the curves and for the quality lanes.
    fn defs(&self) -> String {
        let id = self.id;
        let (width, right) = (WIDTH - LEFT - RIGHT, WIDTH - RIGHT);
        format!(
            "<defs><clipPath id=\"{id}-in\"><rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{width}\" height=\"{HEIGHT}\"/></clipPath>\
             <clipPath id=\"{id}-along\"><rect x=\"{LEFT}\" y=\"0\" width=\"{}\" height=\"2000\"/></clipPath></defs>\n",
            right - LEFT
        )
    }

    fn grid(&self, svg: &mut String) {
        let (bottom, right) = (TOP + HEIGHT, WIDTH - RIGHT);
        for value in self.x.minor.iter().filter(|value| self.x.has(**value)) {
            let x = self.px(*value);
            put(svg, &format!("<path class=\"minor\" d=\"M{x:.1} {TOP}V{bottom}\"/>\n"));
        }
        for value in self.y.minor.iter().filter(|value| self.y.has(**value)) {
            let y = self.py(*value);
            put(svg, &format!("<path class=\"minor\" d=\"M{LEFT} {y:.1}H{right}\"/>\n"));
        }
        for (value, words, more) in self.x.ticks.iter().filter(|(value, _, _)| self.x.has(*value)) {
            let x = self.px(*value);
            put(svg, &format!("<path class=\"major\" d=\"M{x:.1} {TOP}V{}\"/>\n", bottom + 4.0));
            put(svg, &text("middle", x, bottom + 18.0, "", words));
            put(svg, &text("middle", x, bottom + 32.0, "faint", more));
        }
        for (value, words, _) in self.y.ticks.iter().filter(|(value, _, _)| self.y.has(*value)) {
            let y = self.py(*value);
            put(svg, &format!("<path class=\"major\" d=\"M{} {y:.1}H{right}\"/>\n", LEFT - 4.0));
            put(svg, &text("end", LEFT - 8.0, y + 4.0, "", words));
        }
        put(svg, &format!("<path class=\"frame\" d=\"M{LEFT} {TOP}V{bottom}H{right}\"/>\n"));
        // Along its axis: the numbers of events are above the chart.
        let (x, middle) = (14.0, TOP + HEIGHT / 2.0);
        put(
            svg,
            &format!(
                "<text class=\"axis\" transform=\"translate({x:.1} {middle:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                escape(&self.y.label)
            ),
        );
        put(svg, &text("middle", f64::midpoint(LEFT, right), bottom + 50.0, "axis", &self.x.label));
    }

    fn levels(&self, svg: &mut String) {
        let right = WIDTH - RIGHT;
        for (name, value) in self.levels.iter().filter(|(_, value)| self.y.has(*value)) {
            let y = self.py(*value);
            put(svg, &format!("<path class=\"level\" d=\"M{LEFT} {y:.1}H{right}\"/>\n"));
            put(svg, &text("start", LEFT + 6.0, y - 4.0, "level", &shortened(name)));
        }
    }

    /// Events that are close together share a label.
    fn marks(&self, svg: &mut String) {
        let bottom = TOP + HEIGHT;
        let mut labels: Vec<MarkLabel> = Vec::new();
        for (number, at) in self.marks.iter().filter(|(_, at)| self.x.has(*at)) {
            let x = self.px(*at);
            put(svg, &format!("<path class=\"mark\" d=\"M{x:.1} {TOP}V{bottom}\"/>\n"));
            add_mark(&mut labels, x, *number);
        }
        for label in labels {
            let (left, width, words) = (label.left(), label.width(), label.words());
            let top = TOP - 20.0;
            put(
                svg,
                &format!(
                    "<rect class=\"mark\" x=\"{left:.1}\" y=\"{top}\" width=\"{width}\" height=\"16\" rx=\"8\"/>\n"
                ),
            );
            put(svg, &text("middle", left + width / 2.0, top + 12.0, "mark", &words));
        }
    }

    fn curve(&self, svg: &mut String, curve: &Curve) {
        for run in &curve.runs {
            let path = self.path(run);
            if !path.is_empty() {
                put(svg, &format!("<path class=\"c c{}\" d=\"{path}\"/>\n", curve.style % STYLES));
            }
        }
    }

    /// In each pixel column the curve keeps its first, highest, lowest and last point.
    fn path(&self, run: &[(f64, f64)]) -> String {
        let mut drawn: Vec<(f64, f64)> = Vec::new();
        let mut column: Vec<(f64, f64)> = Vec::new();
        for (x, y) in run.iter().map(|(x, y)| (self.px(*x), self.py(*y))) {
            if column.first().is_some_and(|first| first.0.floor() < x.floor()) {
                drawn.extend(ends(&column));
                column.clear();
            }
            column.push((x, y));
        }
        drawn.extend(ends(&column));
        drawn.dedup();
        // A single point becomes a dot: a line of no length with round caps.
        let dot = if drawn.len() == 1 { "h0" } else { "" };
        let points = drawn.iter().enumerate().fold(String::new(), |mut path, (index, (x, y))| {
            write!(path, "{}{x:.1} {y:.1}", if index == 0 { "M" } else { "L" }).ok();
            path
        });
        points + dot
    }

    /// The name of each curve is beside its end, or as near to it as other names permit.
    fn names(&self, svg: &mut String) {
        let mut places: Vec<(f64, f64, &Curve)> = self
            .curves
            .iter()
            .filter_map(|curve| {
                let (x, y) = *curve.runs.iter().rfind(|run| !run.is_empty())?.last()?;
                let y = self.py(y).clamp(TOP, TOP + HEIGHT);
                Some((y, self.px(x).min(WIDTH - RIGHT), curve))
            })
            .collect();
        places.sort_by(|one, two| one.0.total_cmp(&two.0));
        let preferred: Vec<f64> = places.iter().map(|(y, _, _)| *y).collect();
        let x = WIDTH - RIGHT + 14.0;
        for (label, (y, end, curve)) in spread(&preferred).into_iter().zip(places) {
            let style = curve.style % STYLES;
            put(svg, &format!("<path class=\"lead c{style}\" d=\"M{end:.1} {y:.1}L{} {:.1}\"/>\n", x - 3.0, label));
            put(svg, &text("start", x, label + 4.0, &format!("name t{style}"), &shortened(&curve.name)));
        }
    }

    /// The times without a valid pressure, in a lane below the axis.
    fn lane(&self, svg: &mut String, index: usize, curve: &Curve) {
        let y = TOP + HEIGHT + FOOT + 4.0 + LANE * index as f64;
        let (middle, style) = (y + 9.0, curve.style % STYLES);
        put(svg, &format!("<path class=\"minor\" d=\"M{LEFT} {:.1}H{}\"/>\n", y + 5.0, WIDTH - RIGHT));
        put(svg, &text("start", WIDTH - RIGHT + 14.0, middle, &format!("name t{style}"), &shortened(&curve.name)));
        put(svg, &format!("<g clip-path=\"url(#{}-along)\">\n", self.id));
        for (from, to, quality) in &curve.spans {
            let [from, to] = [from, to].map(|at| self.px(*at).clamp(LEFT, WIDTH - RIGHT));
            put(svg, &span(from, y, (to - from).max(1.5), *quality));
        }
        put(svg, "</g>\n");
    }
}

/// The label of one event, or of several that are close together.
struct MarkLabel {
    /// The position of the first one.
    x: f64,
    first: usize,
    last: usize,
}

impl MarkLabel {
    fn words(&self) -> String {
        if self.first == self.last { self.first.to_string() } else { format!("{}–{}", self.first, self.last) }
    }

    fn left(&self) -> f64 {
        self.x - 8.0
    }

    fn width(&self) -> f64 {
        9.0 + 7.0 * self.words().chars().count() as f64
    }
}

/// Adds an event at `x` to the last label if its own would cover it.
fn add_mark(labels: &mut Vec<MarkLabel>, x: f64, number: usize) {
    let label = MarkLabel { x, first: number, last: number };
    match labels.last_mut() {
        Some(last) if label.left() < last.left() + last.width() + 2.0 => last.last = number,
        _ => labels.push(label),
    }
}

/// A part of a lane: overrange in the upper half, underrange in the lower half, a fault filled, an empty frame without samples, a thin
/// line in the middle while the gauge is off.
fn span(x: f64, y: f64, width: f64, quality: Quality) -> String {
    let (top, height) = match quality {
        Quality::Overrange => (y, 5.0),
        Quality::Underrange => (y + 5.0, 5.0),
        Quality::Off | Quality::Missing | Quality::Assumed => (y + 3.5, 3.0),
        Quality::Valid | Quality::Fault | Quality::Stale => (y, 10.0),
    };
    format!(
        "<rect class=\"q {}\" x=\"{x:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height}\"/>\n",
        quality.word()
    )
}

/// A sample of a line style, for tables.
#[must_use]
pub fn swatch(style: usize) -> String {
    format!(
        "<svg class=\"swatch\" viewBox=\"0 0 34 10\" aria-hidden=\"true\"><path class=\"c c{}\" d=\"M1 5H33\"/></svg>",
        style % STYLES
    )
}

/// A sample of a lane, for the legend.
#[must_use]
pub fn lane_swatch(quality: Quality) -> String {
    format!(
        "<svg class=\"lane\" viewBox=\"0 0 20 12\" aria-hidden=\"true\">{}</svg>",
        span(1.0, 1.0, 18.0, quality).trim()
    )
}

fn ends(column: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let order = |one: &&(f64, f64), two: &&(f64, f64)| one.1.total_cmp(&two.1);
    let mut kept: Vec<(f64, f64)> =
        [column.first(), column.iter().min_by(order), column.iter().max_by(order), column.last()]
            .into_iter()
            .flatten()
            .copied()
            .collect();
    kept.sort_by(|one, two| one.0.total_cmp(&two.0));
    kept.dedup();
    kept
}

/// Moves labels apart by the smallest distance needed: first downwards from the top, then upwards from the bottom.
fn spread(preferred: &[f64]) -> Vec<f64> {
    let mut heights = preferred.to_vec();
    let mut least = TOP;
    for height in &mut heights {
        *height = height.max(least);
        least = *height + APART;
    }
    let mut most = TOP + HEIGHT;
    for height in heights.iter_mut().rev() {
        *height = height.min(most);
        most = *height - APART;
    }
    heights
}

fn text(anchor: &str, x: f64, y: f64, class: &str, words: &str) -> String {
    if words.is_empty() {
        return String::new();
    }
    let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
    format!("<text{class} x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>\n", escape(words))
}

fn shortened(name: &str) -> String {
    if name.chars().count() <= LONGEST_NAME {
        return name.to_owned();
    }
    name.chars().take(LONGEST_NAME - 1).chain(['…']).collect()
}

fn put(svg: &mut String, section: &str) {
    svg.push_str(section);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_their_distance_and_order() {
        let placed = spread(&[100.0, 101.0, 102.0, TOP + HEIGHT, TOP + HEIGHT]);
        assert!(placed.windows(2).all(|pair| pair[1] - pair[0] >= APART), "{placed:?}");
        assert!(placed.iter().all(|height| (TOP..=TOP + HEIGHT).contains(height)), "{placed:?}");
        assert_eq!(placed[0], 100.0);
    }

    #[test]
    fn no_number_of_an_event_covers_another_one() {
        for step in 1..60 {
            let mut labels = Vec::new();
            (1..200_u16).for_each(|number| add_mark(&mut labels, f64::from(step * number), usize::from(number)));
            let ends: Vec<_> = labels.iter().map(|label| (label.left(), label.left() + label.width())).collect();
            assert!(ends.windows(2).all(|pair| pair[0].1 < pair[1].0), "{step}: {ends:?}");
            assert_eq!((labels[0].first, labels.last().unwrap().last), (1, 199), "{step}");
            assert!(labels.windows(2).all(|pair| pair[0].last + 1 == pair[1].first), "{step}");
        }
    }

    #[test]
    fn a_column_of_pixels_keeps_its_extremes() {
        let column = [(0.1, 5.0), (0.2, 9.0), (0.3, 1.0), (0.4, 6.0), (0.5, 5.0)];
        assert_eq!(ends(&column), [(0.1, 5.0), (0.2, 9.0), (0.3, 1.0), (0.5, 5.0)]);
    }

    #[test]
    fn a_long_name_is_cut_between_letters() {
        assert_eq!(shortened("Hauptkammer mit Übergröße"), "Hauptkammer mit Ü…");
    }
}
