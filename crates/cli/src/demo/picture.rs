//! The picture of the demo: the pump-down curve, the gauge, the bus.

use super::{GAUGE, Row};
use profivac_host::clock::duration_of;
use profivac_host::scene::Scene;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, Paragraph};

/// So many points are kept; when there are more, every second one is forgotten.
const POINTS: usize = 2000;

/// The decades of the curve, as powers of ten.
const DECADES: [f64; 2] = [-10.0, 4.0];

/// Beyond this many seconds the time axis grows.
const SHORTEST_AXIS: f64 = 60.0;

/// What has been measured so far: seconds and log10 of mbar.
#[derive(Debug, Default)]
pub struct Trend {
    truth: Vec<(f64, f64)>,
    read: Vec<(f64, f64)>,
}

impl Trend {
    /// One more moment.
    pub fn add(&mut self, row: &Row) {
        self.truth.push((row.seconds, row.true_mbar.log10()));
        self.read.extend(row.read_mbar.map(|mbar| (row.seconds, mbar.log10())));
        for points in [&mut self.truth, &mut self.read] {
            if points.len() > POINTS {
                let mut keep = false;
                points.retain(|_| {
                    keep = !keep;
                    keep
                });
            }
        }
    }
}

/// Fills the screen.
pub fn draw(frame: &mut Frame<'_>, scene: &Scene, trend: &Trend, speed: f64) {
    let [upper, lower] = Layout::vertical([Constraint::Fill(1), Constraint::Length(10)]).areas(frame.area());
    let [left, right] = Layout::horizontal([Constraint::Fill(1), Constraint::Length(34)]).areas(upper);
    curve(frame, left, trend, speed);
    gauge(frame, right, scene);
    bus(frame, lower, scene);
}

fn curve(frame: &mut Frame<'_>, area: Rect, trend: &Trend, speed: f64) {
    let end = trend.truth.last().map_or(SHORTEST_AXIS, |(seconds, _)| seconds.max(SHORTEST_AXIS));
    let set = |name, color, points| {
        Dataset::default().name(name).marker(Marker::Braille).graph_type(GraphType::Line).style(color).data(points)
    };
    let sets = vec![set("true", Color::DarkGray, &trend.truth), set("read", Color::Cyan, &trend.read)];
    let time =
        Axis::default().bounds([0.0, end]).labels(["0".to_owned(), format!("{:.0}", end / 2.0), format!("{end:.0} s")]);
    let decades = (0..=7).map(|step| format!("1e{:+}", DECADES[0] as i32 + 2 * step));
    let pressure = Axis::default().bounds(DECADES).labels(decades);
    let title = format!(" Pump-down, mbar over time (speed {speed}) ");
    let block = Block::bordered().title(title).title_bottom(" q leaves ");
    let grey = Style::new().fg(Color::Gray);
    frame.render_widget(Chart::new(sets).block(block).x_axis(time.style(grey)).y_axis(pressure.style(grey)), area);
}

fn gauge(frame: &mut Frame<'_>, area: Rect, scene: &Scene) {
    let Some((device, watched)) = scene.devices().zip(scene.watched()).next() else { return };
    let (report, reading) = (device.report(), scene.reading(watched));
    let value = reading.values.first();
    let pressure = value.and_then(|value| value.pa).map(|pa| format!("{:.3e} mbar", pa / 100.0));
    let instance = value.map(|value| value.instance);
    let part = device.instrument().parts().iter().find(|part| Some(part.instance) == instance);
    let switches =
        |states: Vec<bool>| states.iter().map(|on| if *on { "on" } else { "off" }).collect::<Vec<_>>().join(" ");
    let lines = vec![
        Line::from(""),
        Line::from(pressure.unwrap_or_else(|| "no valid value".to_owned())).bold().fg(Color::Cyan).centered(),
        Line::from(""),
        fact("measures", part.map_or("-".to_owned(), |part| format!("{:?}", part.principle))),
        fact("state", report.device_state.to_owned()),
        fact("emission", switches(report.emission.iter().copied().collect())),
        fact("relays", switches(report.relays.iter().copied().collect())),
        Line::from(reading.exceptions().join(", ")).fg(Color::Yellow),
    ];
    let title = format!(" {} at address {GAUGE} ", watched.model.title);
    frame.render_widget(Paragraph::new(lines).block(Block::bordered().title(title)), area);
}

fn bus(frame: &mut Frame<'_>, area: Rect, scene: &Scene) {
    let Some(master) = scene.master() else { return };
    let counters = master.counters(GAUGE).copied().unwrap_or_default();
    let cycle = duration_of(scene.baud(), master.cycle_tbit());
    let state = master.state(GAUGE).map_or_else(String::new, |state| state.to_string());
    let summary = format!(
        "{}  {state}  cycle {:.2} ms  exchanges {}  lost {}  repeated {}",
        master.mode(),
        cycle.as_secs_f64() * 1e3,
        counters.exchanges,
        counters.lost,
        counters.retries
    );
    let rows = usize::from(area.height.saturating_sub(3));
    let telegrams = scene.telegrams().rev().take(rows).collect::<Vec<_>>();
    let lines = [Line::from(summary).bold()].into_iter().chain(telegrams.into_iter().rev().map(telegram));
    let title = format!(" PROFIBUS at {} ", scene.baud());
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()).block(Block::bordered().title(title)), area);
}

fn fact(name: &'static str, value: String) -> Line<'static> {
    Line::from(vec![Span::from(format!(" {name:<10}")).dark_gray(), Span::from(value)])
}

/// What it is, and its octets.
fn telegram(octets: &[u8]) -> Line<'static> {
    let (what, color) = match octets {
        [0xDC, ..] => ("token", Color::DarkGray),
        [_, .., 0x49, _, 0x16] => ("FDL status", Color::DarkGray),
        [0x10, ..] => ("request", Color::Blue),
        _ => ("answer", Color::Green),
    };
    let hex = octets.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ");
    Line::from(vec![Span::from(format!(" {what:<12}")).fg(color), Span::from(hex)])
}
