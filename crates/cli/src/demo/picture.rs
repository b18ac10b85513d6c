//! The screen of the demo: the plant, its pressures over time, the gauges, the bus.

use super::Demo;
use super::plant::LEAST_ROTOR_SPEED;
use super::trend::Trend;
use profivac_client::cyclic::{ChannelValue, CyclicSlave};
use profivac_devices::reading::Quality;
use profivac_devices::{Principle, ReportedState};
use profivac_dp::master::Counters;
use profivac_host::clock::duration_of;
use profivac_virtual::device::VirtualDevice;
use profivac_virtual::memory_segment::MemorySegment;
use profivac_virtual::scenario::PartState;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Cell, Chart, Dataset, GraphType, Paragraph, Row, Table, Wrap};

/// A rotor from this fraction of its rated speed on is shown as `100 %`.
const FULL_ROTOR_SPEED: f64 = 0.995;

/// The decades of curve and bars, as powers of ten of mbar.
const DECADES: [f64; 2] = [-10.0, 4.0];

/// The shortest time axis, in s.
const SHORTEST_AXIS: f64 = 60.0;

/// The widths of the plant and of a bar in it.
const PLANT: u16 = 46;
const BAR: usize = 20;

/// The size from which frames, a scale for each gauge and telegrams are shown.
const LARGE: (u16, u16) = (112, 34);

/// The width of the scale of a gauge: two characters for each decade from 1e-10 to 1e4 mbar.
const SCALE: usize = 29;

/// The colours of the volumes, in the order of their names.
const COLOURS: [Color; 5] = [Color::Green, Color::Yellow, Color::Magenta, Color::Blue, Color::White];

/// The colour of the pressure that the master reads from the first gauge.
const READ_COLOUR: Color = Color::Cyan;

/// Draws the screen. On a small one the gauges have priority.
pub fn draw(frame: &mut Frame<'_>, demo: &Demo, trend: &Trend) {
    let area = frame.area();
    let roomy = area.width >= LARGE.0 && area.height >= LARGE.1;
    let frames = if roomy { 2 } else { 0 };
    let gauges_height = u16::try_from(demo.segment.slaves().len()).unwrap_or(u16::MAX).saturating_add(1 + frames);
    let bus_height = if roomy { (area.height / 10).clamp(4, 7) } else { 1 };
    let [header, upper, middle, lower] = Layout::vertical([
        Constraint::Length(2),
        Constraint::Fill(1),
        Constraint::Length(gauges_height),
        Constraint::Length(bus_height),
    ])
    .areas(area);
    title(frame, header, demo);
    let [left, right] = Layout::horizontal([Constraint::Length(PLANT), Constraint::Fill(1)]).areas(upper);
    plant(frame, left, demo);
    curves(frame, right, demo, trend);
    gauges(frame, middle, &demo.segment, roomy);
    bus(frame, lower, &demo.segment, roomy);
}

/// The title, the time, and the last message of the scenario.
fn title(frame: &mut Frame<'_>, area: Rect, demo: &Demo) {
    let seconds = demo.run.seconds();
    let speed = if demo.speed == 1.0 { String::new() } else { format!(", {} x", demo.speed) };
    let title = Line::from(vec![
        Span::from(format!(" profivac  {} ", demo.title)).bold(),
        Span::from(format!(" {}{speed} ", clock(seconds))).fg(READ_COLOUR),
        Span::from("  q quits").dark_gray(),
    ]);
    let message = demo.run.message().unwrap_or_default();
    let message = Line::from(vec![Span::from(" \u{25B6} "), Span::from(message)]).yellow().bold();
    frame.render_widget(Paragraph::new(vec![title, message]), area);
}

/// Minutes and seconds, with hours if there are any.
fn clock(seconds: f64) -> String {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "never negative, far from the end")]
    let whole = seconds as u64;
    let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
    if hours > 0 { format!("{hours}:{minutes:02}:{seconds:02}") } else { format!("{minutes}:{seconds:02}") }
}

/// Volumes with their true pressures, and the states of valves and pumps: below each other if there is room, otherwise in a row.
fn plant(frame: &mut Frame<'_>, area: Rect, demo: &Demo) {
    let block = Block::bordered().title(" Plant: true pressures in mbar ");
    let inner = block.inner(area);
    let mut lines: Vec<_> =
        demo.run.pressures().zip(COLOURS).map(|((name, pa), colour)| level(name, pa / 100.0, colour)).collect();
    let states = demo.run.states();
    if lines.len() + states.len() < usize::from(inner.height) {
        lines.push(Line::from(""));
        lines.extend(states.iter().map(|(name, state)| {
            Line::from(vec![
                Span::from(format!(" {name:<14}")).gray(),
                Span::from(state.to_string()).fg(state_colour(*state)),
            ])
        }));
        frame.render_widget(Paragraph::new(lines).block(block), area);
        return;
    }
    let words = states.iter().flat_map(|(name, state)| {
        [Span::from(format!(" {name} ")).gray(), Span::from(format!("{state} ")).fg(state_colour(*state))]
    });
    lines.push(Line::from(words.collect::<Vec<_>>()));
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: false }).block(block), area);
}

/// A volume as a bar.
fn level(name: &str, mbar: f64, colour: Color) -> Line<'static> {
    let filled = bar(mbar);
    Line::from(vec![
        Span::from(format!(" {name:<12} ")).fg(colour),
        Span::from("\u{2588}".repeat(filled)).fg(colour),
        Span::from("\u{2591}".repeat(BAR.saturating_sub(filled))).dark_gray(),
        Span::from(format!(" {mbar:.2e}")).bold(),
    ])
}

/// The colour of the state of a part.
fn state_colour(state: PartState) -> Color {
    match state {
        PartState::Open | PartState::Running => Color::Green,
        PartState::Closed | PartState::Stopped => Color::DarkGray,
        PartState::RotorSpeed(fraction) if fraction >= FULL_ROTOR_SPEED => Color::Green,
        PartState::RotorSpeed(fraction) if fraction < LEAST_ROTOR_SPEED => Color::DarkGray,
        PartState::RotorSpeed(_) | PartState::Temperature(_) => Color::Cyan,
    }
}

/// The fraction of all decades below a pressure, 0 to 1.
fn fraction(mbar: f64) -> f64 {
    ((mbar.log10() - DECADES[0]) / (DECADES[1] - DECADES[0])).clamp(0.0, 1.0)
}

/// The number of filled characters of a bar.
fn bar(mbar: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of a small number")]
    let filled = (fraction(mbar) * BAR as f64).round() as usize;
    filled
}

fn curves(frame: &mut Frame<'_>, area: Rect, demo: &Demo, trend: &Trend) {
    let end = trend.end().max(SHORTEST_AXIS);
    let set = |name: String, colour, points| {
        Dataset::default().name(name).marker(Marker::Braille).graph_type(GraphType::Line).style(colour).data(points)
    };
    let truth = trend.true_pressures.iter().zip(COLOURS.iter().cycle());
    let mut sets: Vec<_> = truth.map(|((name, curve), colour)| set(name.clone(), *colour, curve)).collect();
    let first = demo.segment.slaves().first().map_or("", |watched| watched.model.title);
    sets.push(set(format!("read: {first}"), READ_COLOUR, &trend.read_pressure));
    let time = Axis::default().bounds([0.0, end]).labels(["0:00".to_owned(), clock(end / 2.0), clock(end)]);
    // Labels need every second line at least.
    let labels = if area.height < 12 { 2 } else { 7 };
    let decades = (0..=labels).map(|step| format!("1e{:+}", DECADES[0] as i32 + 14 / labels * step));
    let pressure = Axis::default().bounds(DECADES).labels(decades);
    let block = Block::bordered().title(" mbar over time ").title_bottom(dashboard_title(demo));
    let grey = Style::new().fg(Color::Gray);
    let legend = (Constraint::Percentage(50), Constraint::Percentage(60));
    let chart = Chart::new(sets).block(block).hidden_legend_constraints(legend);
    frame.render_widget(chart.x_axis(time.style(grey)).y_axis(pressure.style(grey)), area);
}

/// The address of the dashboard.
fn dashboard_title(demo: &Demo) -> String {
    let url = demo.dashboard.as_ref().and_then(super::dashboard::Dashboard::url);
    url.map(|url| format!(" dashboard {url} ")).unwrap_or_default()
}

/// A row for each device: the values that the master reads, and its front panel.
fn gauges(frame: &mut Frame<'_>, area: Rect, segment: &MemorySegment, roomy: bool) {
    let rows = segment.slaves().iter().filter_map(|watched| {
        let device = segment.devices().find(|device| device.switch_address() == watched.address)?;
        Some(gauge(segment, watched, device, roomy))
    });
    let mut names = vec!["ADR", "DEVICE", "READ mbar", "FROM", "STATE", "EMITS", "RELAYS", "BUS", "REPORTS"];
    let mut widths = [3, 6, 9, 12, 10, 5, 7, 9].map(Constraint::Length).to_vec();
    if roomy {
        names.insert(3, "1e-10    1e-5      1    1e+4");
        widths.insert(3, Constraint::Length(SCALE as u16));
    }
    widths.push(Constraint::Fill(1));
    let table = Table::new(rows, widths).header(Row::new(names).bold().gray());
    let block = Block::bordered().title(" Gauges, as the master reads them ");
    frame.render_widget(if roomy { table.block(block) } else { table }, area);
}

fn gauge(segment: &MemorySegment, watched: &CyclicSlave, device: &VirtualDevice, roomy: bool) -> Row<'static> {
    let (report, reading) = (device.report(), segment.values(watched));
    let value = reading.values.iter().find(|value| value.pa.is_some()).or(reading.values.first());
    let mbar = value.and_then(|value| value.pa).map(|pa| pa / 100.0);
    let shown = value.map_or_else(|| "-".to_owned(), pressure_text);
    let part = device.device().parts().iter().find(|part| Some(part.instance) == value.map(|value| value.instance));
    let (from, colour) = part.map_or(("-", Color::DarkGray), |part| principle(part.principle));
    let colour = if mbar.is_some() { colour } else { Color::DarkGray };
    let state = segment.master().state(watched.address).map_or_else(String::new, |s| s.to_string());
    let bus = if device.is_exchanging() { Color::Green } else { Color::Red };
    let device_state = match report.device_state {
        ReportedState::None => "-",
        state => state.name(),
    };
    let mut cells = vec![
        Cell::from(format!("{:>3}", watched.address)),
        Cell::from(watched.model.name),
        Cell::from(shown).fg(colour).bold(),
        Cell::from(from).fg(colour),
        Cell::from(device_state),
        Cell::from(lamps(report.emission.iter())).yellow(),
        Cell::from(lamps(report.relays.iter())),
        Cell::from(state).fg(bus),
        Cell::from(reading.alarms().join(", ")).red(),
    ];
    if roomy {
        cells.insert(3, Cell::from(scale(mbar, colour)));
    }
    Row::new(cells)
}

/// A reading in mbar: the pressure, the end of the range, or the reason why there is no pressure.
fn pressure_text(value: &ChannelValue) -> String {
    let mbar = |pa: f64| pa / 100.0;
    match (value.pa, value.limit_pa, value.quality) {
        (Some(pa), _, _) => format!("{:.3e}", mbar(pa)),
        (None, Some(limit), Quality::Underrange) => format!("<{:.1e}", mbar(limit)),
        (None, Some(limit), _) => format!(">{:.1e}", mbar(limit)),
        (None, None, quality) => quality.label().to_owned(),
    }
}

/// The name of a principle and its colour.
const fn principle(principle: Principle) -> (&'static str, Color) {
    match principle {
        Principle::Pirani => ("Pirani", Color::Yellow),
        Principle::Diaphragm => ("diaphragm", Color::Green),
        Principle::HotCathode => ("hot cathode", Color::Magenta),
        Principle::ColdCathode => ("cold cathode", Color::LightBlue),
        Principle::Atmosphere => ("atmosphere", Color::White),
    }
}

/// A pressure as a mark on a scale of decades.
fn scale(mbar: Option<f64>, colour: Color) -> Line<'static> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of a small number")]
    let index = mbar.map(|mbar| (fraction(mbar) * (SCALE - 1) as f64).round() as usize);
    let mark = |at| match (index == Some(at), at % 2) {
        (true, _) => Span::from("\u{25C6}").fg(colour),
        (false, 0) => Span::from("\u{00B7}").dark_gray(),
        (false, _) => Span::from(" "),
    };
    Line::from((0..SCALE).map(mark).collect::<Vec<_>>())
}

/// A full circle for each state that is on, an empty one for off.
fn lamps<'a>(states: impl Iterator<Item = &'a bool>) -> String {
    states.map(|on| if *on { '\u{25CF}' } else { '\u{25CB}' }).collect()
}

/// The counters of the master, and the last telegrams if there is room.
fn bus(frame: &mut Frame<'_>, area: Rect, segment: &MemorySegment, roomy: bool) {
    let master = segment.master();
    let counters = |watched: &CyclicSlave| master.counters(watched.address).copied().unwrap_or_default();
    let sum = |number: fn(Counters) -> u32| -> u32 {
        segment.slaves().iter().map(|watched| number(counters(watched))).fold(0, u32::saturating_add)
    };
    let (exchanges, lost, repetitions) = (sum(|c| c.exchanges), sum(|c| c.lost), sum(|c| c.repetitions));
    let cycle = duration_of(segment.baud(), master.cycle_tbit()).as_secs_f64() * 1e3;
    let counted = format!("cycle {cycle:.1} ms  exchanges {exchanges}  lost {lost}  repeated {repetitions}");
    let mode = Span::from(format!(" {}  ", master.mode())).bold();
    if !roomy {
        let rate = Span::from(format!(" PROFIBUS {}", segment.baud())).gray();
        frame.render_widget(Paragraph::new(Line::from(vec![rate, mode, Span::from(counted)])), area);
        return;
    }
    let rows = usize::from(area.height.saturating_sub(3));
    // Tokens are not shown.
    let telegrams = segment.telegrams().filter(|octets| octets.len() > 3).rev().take(rows).collect::<Vec<_>>();
    let summary = Line::from(vec![mode, Span::from(counted)]);
    let lines = [summary].into_iter().chain(telegrams.into_iter().rev().map(telegram));
    let title = format!(" PROFIBUS at {} ", segment.baud());
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()).block(Block::bordered().title(title)), area);
}

/// The kind of a telegram, and its octets.
fn telegram(octets: &[u8]) -> Line<'static> {
    let master_asks = |da_sa: &[u8]| da_sa.get(1).is_some_and(|sa| sa & 0x7F == super::MASTER);
    let (what, color) = match octets {
        [0xDC, ..] => ("token", Color::DarkGray),
        [0x10, rest @ ..] if rest.get(2) == Some(&0x49) => ("FDL status", Color::DarkGray),
        [0x10, rest @ ..] | [0x68, _, _, _, rest @ ..] if master_asks(rest) => ("request", Color::LightBlue),
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

    /// The screen after `seconds`, as lines of text.
    fn picture(seconds: f64, width: u16, height: u16) -> String {
        let arguments = Arguments {
            scenario: None,
            listen: None,
            record: None,
            speed: 1.0,
            time: None,
            headless: true,
            json: false,
        };
        let mut demo = Demo::new(&arguments).unwrap();
        let mut trend = Trend::default();
        while demo.run.seconds() < seconds {
            demo.run.step_segment(&mut demo.segment, demo.run.seconds() + 0.5);
            trend.add(demo.run.seconds(), &demo.run, &demo.row());
        }
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| draw(frame, &demo, &trend)).unwrap();
        terminal.backend().to_string()
    }

    #[test]
    fn a_large_screen_shows_the_plant_the_gauges_and_the_bus() {
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
    fn a_screen_of_80_by_24_shows_all_gauges_and_the_last_message() {
        let picture = picture(8.0, 80, 24);
        assert_eq!(picture.matches(" DATA ").count(), 12, "{picture}");
        for word in ["The scroll pump evacuates", "fore-line", "img400", "EXECUTING", "bypass open", "OPERATE  cycle"] {
            assert!(picture.contains(word), "{word}:\n{picture}");
        }
    }

    #[test]
    fn a_very_small_screen_is_drawn_without_an_error() {
        for (width, height) in [(80, 24), (20, 8), (1, 1)] {
            assert!(!picture(0.5, width, height).is_empty());
        }
    }

    #[test]
    fn a_bar_counts_decades() {
        assert_eq!([1e-12, 1e-10, 1e-3, 1e4, 1e5].map(bar), [0, 0, BAR / 2, BAR, BAR]);
    }
}
