//! Answers of a slave as tables, compared by a test.

use crate::golden as files;

/// Rows of cells, each column as wide as its widest cell.
pub fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let cell = |row: &Vec<String>, column: usize| row.get(column).cloned().unwrap_or_default();
    let widths: Vec<usize> = (0..columns)
        .map(|column| rows.iter().map(|row| cell(row, column).chars().count()).max().unwrap_or(0))
        .collect();
    rows.iter()
        .map(|row| {
            let cells = (0..columns).map(|column| format!("{:width$}", cell(row, column), width = widths[column]));
            format!("{}\n", cells.collect::<Vec<_>>().join("  ").trim_end())
        })
        .collect()
}

/// Compares `text` with `tests/golden/slave/NAME` of the repository.
#[track_caller]
pub fn compare(name: &str, text: &str) {
    files::compare(&format!("tests/golden/slave/{name}"), text);
}
