//! The picture of the demo: the plant, its pressures over time, the gauges, the bus.

use super::Demo;
use super::trend::Trend;
use profivac_host::bench::VirtualDevice;
use profivac_host::clock::duration_of;
use profivac_host::scene::Scene;
use profivac_host::watch::Watched;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Cell, Chart, Dataset, GraphType, Paragraph, Row, Table};

/// The decades of curve and bars, as powers of ten of mbar.
const DECADES: [f64; 2] = [-10.0, 4.0];

/// Beyond this many seconds the time axis grows.
const SHORTEST_AXIS: f64 = 60.0;

/// How wide the plant and a bar in it are.
const PLANT: u16 = 46;
const BAR: usize = 20;

/// The colours of the volumes, in the order of their names.
const COLOURS: [Color; 5] = [Color::Green, Color::Yellow, Color::Magenta, Color::Blue, Color::White];

/// Fills the screen.
pub fn draw(frame: &mut Frame<'_>, demo: &Demo, trend: &Trend) {
    let devices = u16::try_from(demo.scene.watched().len()).unwrap_or(u16::MAX);
    let gauges_height = devices.saturating_add(3);
    let [upper, middle, lower] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(gauges_height), Constraint::Length(4)])
            .areas(frame.area());
    let [left, right] = Layout::horizontal([Constraint::Length(PLANT), Constraint::Fill(1)]).areas(upper);
    plant(frame, left, demo);
    curves(frame, right, demo, trend);
    gauges(frame, middle, &demo.scene);
    bus(frame, lower, &demo.scene);
}

/// Volumes with their true pressures, and what the parts are doing.
fn plant(frame: &mut Frame<'_>, area: Rect, demo: &Demo) {
    let said = demo.run.said().unwrap_or_default().to_owned();
    let volumes = demo.run.pressures().zip(COLOURS.iter().cycle()).map(|((name, pa), colour)| {
        let filled = bar(pa / 100.0);
        Line::from(vec![
            Span::from(format!(" {name:<12}")).fg(*colour),
            Span::from("\u{2588}".repeat(filled)).fg(*colour),
            Span::from("\u{2591}".repeat(BAR.saturating_sub(filled))).dark_gray(),
            Span::from(format!(" {:.2e}", pa / 100.0)).bold(),
        ])
    });
    let parts = demo.run.states().into_iter().map(|(name, state)| {
        let colour = match state.as_str() {
            "open" | "runs" => Color::Green,
            "closed" | "stands" | "0 %" => Color::DarkGray,
            _ => Color::Cyan,
        };
        Line::from(vec![Span::from(format!(" {name:<14}")).gray(), Span::from(state).fg(colour)])
    });
    let seconds = format!(" {:.0} s, {} x ", demo.run.seconds(), demo.speed);
    let lines: Vec<_> = volumes.chain([Line::from("")]).chain(parts).collect();
    let block = Block::bordered().title(format!(" {} ", demo.title)).title_bottom(seconds);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let [list, words] = Layout::vertical([Constraint::Fill(1), Constraint::Length(2)]).areas(inner);
    frame.render_widget(Paragraph::new(lines), list);
    frame.render_widget(Paragraph::new(said).wrap(ratatui::widgets::Wrap { trim: true }).yellow(), words);
}

/// How many of the places of a bar are filled, one decade after the other.
fn bar(mbar: f64) -> usize {
    let part = (mbar.log10() - DECADES[0]) / (DECADES[1] - DECADES[0]);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of a small number")]
    let filled = (part.clamp(0.0, 1.0) * BAR as f64).round() as usize;
    filled
}

fn curves(frame: &mut Frame<'_>, area: Rect, demo: &Demo, trend: &Trend) {
    let end = trend.end().max(SHORTEST_AXIS);
    let set = |name: String, colour, points| {
        Dataset::default().name(name).marker(Marker::Braille).graph_type(GraphType::Line).style(colour).data(points)
    };
    let truth = trend.truth.iter().zip(COLOURS.iter().cycle());
    let mut sets: Vec<_> = truth.map(|((name, curve), colour)| set(name.clone(), *colour, curve)).collect();
    let first = demo.scene.watched().first().map_or("", |watched| watched.model.title);
    sets.push(set(format!("read: {first}"), Color::Cyan, &trend.read));
    let time =
        Axis::default().bounds([0.0, end]).labels(["0".to_owned(), format!("{:.0}", end / 2.0), format!("{end:.0} s")]);
    let decades = (0..=7).map(|step| format!("1e{:+}", DECADES[0] as i32 + 2 * step));
    let pressure = Axis::default().bounds(DECADES).labels(decades);
    let block = Block::bordered().title(" mbar over time ").title_bottom(farewell(demo));
    let grey = Style::new().fg(Color::Gray);
    frame.render_widget(Chart::new(sets).block(block).x_axis(time.style(grey)).y_axis(pressure.style(grey)), area);
}

/// How to leave, and where more is to be seen.
fn farewell(demo: &Demo) -> String {
    let dashboard = demo.dashboard.as_ref().map(|dashboard| format!("dashboard {} ", dashboard.url()));
    format!(" q leaves {}", dashboard.unwrap_or_default())
}

/// A row for each device: what the master reads, and what stands on its front.
fn gauges(frame: &mut Frame<'_>, area: Rect, scene: &Scene) {
    let rows = scene.watched().iter().filter_map(|watched| {
        let device = scene.devices().find(|device| device.place() == watched.address)?;
        Some(gauge(scene, watched, device))
    });
    let header =
        Row::new(["ADDR", "DEVICE", "READ mbar", "FROM", "STATE", "EMISSION", "RELAYS", "BUS", "REPORTS"]).bold();
    let widths = [4, 12, 11, 12, 14, 8, 8, 16, 30].map(Constraint::Length);
    let table =
        Table::new(rows, widths).header(header).block(Block::bordered().title(" Gauges, as the master reads them "));
    frame.render_widget(table, area);
}

fn gauge(scene: &Scene, watched: &Watched, device: &VirtualDevice) -> Row<'static> {
    let (report, reading) = (device.report(), scene.reading(watched));
    let value = reading.values.iter().find(|value| value.pa.is_some()).or(reading.values.first());
    let read = value.and_then(|value| value.pa).map(|pa| format!("{:.3e}", pa / 100.0));
    let colour = if read.is_some() { Color::Cyan } else { Color::DarkGray };
    let part = device.instrument().parts().iter().find(|part| Some(part.instance) == value.map(|value| value.instance));
    let state =
        scene.master().and_then(|master| master.state(watched.address)).map_or_else(String::new, |s| s.to_string());
    let bus = if device.is_exchanging() { Style::new().fg(Color::Green) } else { Style::new().fg(Color::Red) };
    Row::new(vec![
        Cell::from(watched.address.to_string()),
        Cell::from(watched.model.name),
        Cell::from(read.unwrap_or_else(|| "-".to_owned())).style(Style::new().fg(colour).bold()),
        Cell::from(part.map_or_else(|| "-".to_owned(), |part| format!("{:?}", part.principle))),
        Cell::from(report.device_state),
        Cell::from(lamps(report.emission.iter())).yellow(),
        Cell::from(lamps(report.relays.iter())),
        Cell::from(state).style(bus),
        Cell::from(reading.exceptions().join(", ")).red(),
    ])
}

/// A full circle for what is on, an empty one for what is off.
fn lamps<'a>(states: impl Iterator<Item = &'a bool>) -> String {
    states.map(|on| if *on { '\u{25CF}' } else { '\u{25CB}' }).collect()
}

fn bus(frame: &mut Frame<'_>, area: Rect, scene: &Scene) {
    let Some(master) = scene.master() else { return };
    let counters = |watched: &Watched| master.counters(watched.address).copied().unwrap_or_default();
    let sum = |number: fn(profivac_dp::master::Counters) -> u32| -> u32 {
        scene.watched().iter().map(|watched| number(counters(watched))).fold(0, u32::saturating_add)
    };
    let (exchanges, lost, retries) = (sum(|c| c.exchanges), sum(|c| c.lost), sum(|c| c.retries));
    let cycle = duration_of(scene.baud(), master.cycle_tbit());
    let summary = format!(
        " {}  cycle {:.1} ms  exchanges {exchanges}  lost {lost}  repeated {retries}",
        master.mode(),
        cycle.as_secs_f64() * 1e3,
    );
    let rows = usize::from(area.height.saturating_sub(3));
    let telegrams = scene.telegrams().rev().take(rows).collect::<Vec<_>>();
    let lines = [Line::from(summary).bold()].into_iter().chain(telegrams.into_iter().rev().map(telegram));
    let title = format!(" PROFIBUS at {} ", scene.baud());
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()).block(Block::bordered().title(title)), area);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::Arguments;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    /// The picture after so many seconds, as lines of text.
    fn picture(seconds: f64, width: u16, height: u16) -> String {
        let arguments = Arguments { scenario: None, speed: 1.0, time: None, headless: false, json: false };
        let mut demo = Demo::new(&arguments).unwrap();
        let mut trend = Trend::default();
        while demo.run.seconds() < seconds {
            demo.run.step_scene(&mut demo.scene, demo.run.seconds() + 0.5);
            trend.add(demo.run.seconds(), &demo.run, &demo.row());
        }
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| draw(frame, &demo, &trend)).unwrap();
        terminal.backend().to_string()
    }

    #[test]
    fn the_picture_has_the_plant_the_gauges_and_the_bus() {
        let picture = picture(8.0, 140, 45);
        for word in
            ["A small vacuum plant", "fore-line", "scroll", "runs", "The scroll pump", "bcg450", "img400", "EXECUTING"]
        {
            assert!(picture.contains(word), "{word}:\n{picture}");
        }
        assert!(picture.contains("PROFIBUS at 187.5 kbit/s") && picture.contains("cycle"), "{picture}");
        // Twelve devices exchange data.
        assert_eq!(picture.matches(" DATA ").count(), 12, "{picture}");
    }

    #[test]
    fn a_small_terminal_is_no_reason_to_fail() {
        for (width, height) in [(80, 24), (20, 8), (1, 1)] {
            assert!(!picture(0.5, width, height).is_empty());
        }
    }

    #[test]
    fn a_bar_counts_decades() {
        assert_eq!([1e-12, 1e-10, 1e-3, 1e4, 1e5].map(bar), [0, 0, BAR / 2, BAR, BAR]);
    }
}
