//! The live table.

use super::row::Row;
use ratatui::Frame;
use ratatui::layout::Constraint;
use ratatui::style::{Color, Style, Stylize};
use ratatui::widgets::{Block, Cell, Row as Line, Table};

const HEADER: [&str; 8] = ["ADDR", "DEVICE", "PART", "PRESSURE", "STATE", "CYCLES", "LOST", "REMARKS"];

/// On a narrow terminal what stands behind goes first: half a number is a wrong number.
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

/// Fills the screen.
pub fn draw(frame: &mut Frame<'_>, title: &str, rows: &[Row]) {
    let block = Block::bordered().title(format!(" {title} ")).title_bottom(" q leaves, the slaves are unlocked then ");
    let table = Table::new(rows.iter().map(line), WIDTHS).header(Line::new(HEADER).bold()).block(block);
    frame.render_widget(table, frame.area());
}

fn line(row: &Row) -> Line<'static> {
    let state = if row.is_exchanging() { Color::Green } else { Color::Red };
    Line::new([
        Cell::from(row.address.to_string()),
        Cell::from(row.device),
        Cell::from(row.instance.to_string()),
        Cell::from(row.pressure_text()).bold(),
        Cell::from(row.state.clone()).style(Style::new().fg(state)),
        Cell::from(row.exchanges.to_string()),
        Cell::from(row.lost.to_string()),
        Cell::from(row.remarks_text()).style(Style::new().fg(Color::Yellow)),
    ])
}
