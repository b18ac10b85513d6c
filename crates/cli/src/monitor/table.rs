//! The live table of the screen.

use super::row::Row;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout};
use ratatui::style::{Color, Style, Stylize};
use ratatui::widgets::{Block, Cell, Paragraph, Row as Line, Table};

const HEADER: [&str; 8] = ["ADDR", "DEVICE", "PART", "PRESSURE", "STATE", "CYCLES", "LOST", "REMARKS"];

/// On a narrow terminal the last columns become narrow first, so that no number is cut.
const WIDTHS: [Constraint; 8] = [
    Constraint::Min(4),
    Constraint::Min(8),
    Constraint::Min(4),
    Constraint::Min(18),
    Constraint::Max(8),
    Constraint::Max(10),
    Constraint::Max(6),
    Constraint::Fill(1),
];

/// The width of the segment column.
const SEGMENT_WIDTH: Constraint = Constraint::Max(12);

/// Draws all rows, and above them the title of each segment.
pub fn draw(frame: &mut Frame<'_>, titles: &[String], rows: &[Row]) {
    let with_segment = titles.len() > 1;
    let lines = if with_segment { u16::try_from(titles.len()).unwrap_or(u16::MAX) } else { 0 };
    let [above, below] = Layout::vertical([Constraint::Length(lines), Constraint::Fill(1)]).areas(frame.area());
    let mut block = Block::bordered().title_bottom(" q quits and unlocks the slaves ");
    match titles {
        [title] => block = block.title(format!(" {title} ")),
        _ => frame.render_widget(Paragraph::new(titles.join("\n")), above),
    }
    let segment = with_segment.then_some((SEGMENT_WIDTH, "SEGMENT"));
    let (first_width, first_name): (Vec<_>, Vec<_>) = segment.into_iter().unzip();
    let widths = first_width.into_iter().chain(WIDTHS);
    let header = Line::new(first_name.into_iter().chain(HEADER)).bold();
    let lines = rows.iter().map(|row| line(row, with_segment));
    frame.render_widget(Table::new(lines, widths).header(header).block(block), below);
}

fn line(row: &Row, with_segment: bool) -> Line<'static> {
    let state = if row.is_exchanging() { Color::Green } else { Color::Red };
    let segment = with_segment.then(|| Cell::from(row.segment.clone().unwrap_or_default()));
    let cells = [
        Cell::from(row.address.to_string()),
        Cell::from(row.device.clone()),
        Cell::from(row.instance.to_string()),
        Cell::from(row.pressure_text()).bold(),
        Cell::from(row.state.to_string()).style(Style::new().fg(state)),
        Cell::from(row.exchanges.to_string()),
        Cell::from(row.lost.to_string()),
        Cell::from(row.inputs_and_remarks_text()).style(Style::new().fg(Color::Yellow)),
    ];
    Line::new(segment.into_iter().chain(cells))
}

#[cfg(test)]
mod tests {
    use super::super::row::RowState;
    use super::*;
    use profivac_devices::reading::Quality;
    use profivac_dp::master::HandlerState;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn row(segment: Option<&str>) -> Row {
        Row {
            pressure: Some(5e-6),
            unit: "mbar",
            mbar: Some(5e-6),
            instance: 2,
            state: RowState::Handler(HandlerState::Data { diag: false }),
            exchanges: 1234,
            lost: 5,
            quality: Some(Quality::Valid),
            ..Row::empty(segment, 5, "bcg450".to_owned(), 1.5)
        }
    }

    fn drawn(titles: &[&str], rows: &[Row]) -> Vec<String> {
        let mut terminal = Terminal::new(TestBackend::new(90, 8)).unwrap();
        let titles: Vec<_> = titles.iter().map(|title| (*title).to_owned()).collect();
        terminal.draw(|frame| draw(frame, &titles, rows)).unwrap();
        let cells = terminal.backend().buffer().content.chunks(90);
        cells.map(|line| line.iter().map(|cell| cell.symbol()).collect::<String>()).collect()
    }

    #[test]
    fn the_frame_shows_the_port_of_a_single_segment() {
        let lines = drawn(&["/dev/ttyUSB0"], &[row(None)]);
        assert!(lines[0].starts_with("┌ /dev/ttyUSB0 ─"), "{lines:?}");
        assert!(lines[1].starts_with("│ADDR"), "{lines:?}");
    }

    #[test]
    fn several_segments_have_a_line_each_and_every_row_names_its_segment() {
        let lines = drawn(&["hall: /dev/ttyUSB0", "annex: no answer"], &[row(Some("hall"))]);
        assert!(lines[0].starts_with("hall: /dev/ttyUSB0 "), "{lines:?}");
        assert!(lines[1].starts_with("annex: no answer "), "{lines:?}");
        assert!(lines[3].starts_with("│SEGMENT      ADDR"), "{lines:?}");
        assert!(lines[4].starts_with("│hall         5 ") && lines[4].contains("5.000e-6 mbar"), "{lines:?}");
    }
}
