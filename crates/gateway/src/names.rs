//! What a gateway publishes, as a table: `profivac names`.

use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};

/// The names under which a gateway publishes the points of a station, with what a user of its protocol needs beside them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NameTable {
    columns: &'static [&'static str],
    rows: Vec<Vec<String>>,
}

impl NameTable {
    /// An empty table. The first column is the name in the protocol.
    #[must_use]
    pub const fn new(columns: &'static [&'static str]) -> Self {
        Self { columns, rows: Vec::new() }
    }

    /// Adds a row with a cell for each column.
    pub fn push<const N: usize>(&mut self, row: [String; N]) {
        debug_assert_eq!(N, self.columns.len(), "a cell for each column");
        self.rows.push(row.into());
    }

    /// The columns.
    #[must_use]
    pub const fn columns(&self) -> &'static [&'static str] {
        self.columns
    }

    /// The rows, in the order in which the station has its points.
    #[must_use]
    pub fn rows(&self) -> &[Vec<String>] {
        &self.rows
    }

    /// The table as CSV (RFC 4180) with a head, lines ended by a line feed.
    #[must_use]
    pub fn csv(&self) -> String {
        let head = self.columns.join(",");
        let lines = self.rows.iter().map(|row| row.iter().map(|cell| csv_cell(cell)).collect::<Vec<_>>().join(","));
        std::iter::once(head).chain(lines).map(|line| line + "\n").collect()
    }

    /// The table for people: columns of equal width, two blanks apart.
    #[must_use]
    pub fn text(&self) -> String {
        let head: Vec<String> = self.columns.iter().map(|column| column.to_uppercase()).collect();
        let lines: Vec<&Vec<String>> = std::iter::once(&head).chain(&self.rows).collect();
        let width = |column: usize| {
            lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max().unwrap_or_default()
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let line = |cells: &Vec<String>| {
            let cells = cells.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
            cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
        };
        lines.into_iter().map(line).collect::<Vec<_>>().join("\n")
    }
}

/// The key of a signal in capitalized words without hyphens: `last-reading` as `LastReading`.
#[must_use]
pub fn capitalized(key: &str) -> String {
    let capital = |word: &str| {
        let mut letters = word.chars();
        letters.next().map(|first| first.to_ascii_uppercase()).into_iter().chain(letters).collect::<String>()
    };
    key.split('-').map(capital).collect()
}

/// A cell of a CSV file. An apostrophe before `=`, `+`, `-`, `@`, tabulator and carriage return keeps a spreadsheet from reading the cell
/// as a formula; a number keeps its sign.
fn csv_cell(cell: &str) -> String {
    let is_formula = cell.starts_with(['=', '+', '-', '@', '\t', '\r']) && cell.parse::<f64>().is_err();
    let cell = if is_formula { format!("'{cell}") } else { cell.to_owned() };
    if cell.contains([',', '"', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell }
}

/// One object for each row, with the columns as keys in their order.
impl Serialize for NameTable {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        struct Row<'a>(&'a NameTable, &'a [String]);
        impl Serialize for Row<'_> {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let mut map = serializer.serialize_map(Some(self.1.len()))?;
                for (column, cell) in self.0.columns.iter().zip(self.1) {
                    map.serialize_entry(column, cell)?;
                }
                map.end()
            }
        }
        let mut list = serializer.serialize_seq(Some(self.rows.len()))?;
        for row in &self.rows {
            list.serialize_element(&Row(self, row))?;
        }
        list.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> NameTable {
        let mut table = NameTable::new(&["name", "description"]);
        table.push(["VAC:P".to_owned(), "a \"pressure\", in Pa".to_owned()]);
        table.push(["-5".to_owned(), "=1+1".to_owned()]);
        table
    }

    #[test]
    fn a_capitalized_key_has_no_hyphens() {
        assert_eq!(capitalized("last-reading"), "LastReading");
        assert_eq!(capitalized("pressure"), "Pressure");
        assert_eq!(capitalized("pressure-log10"), "PressureLog10");
    }

    #[test]
    fn a_cell_with_commas_is_quoted_and_a_formula_is_defused() {
        assert_eq!(table().csv(), "name,description\nVAC:P,\"a \"\"pressure\"\", in Pa\"\n-5,'=1+1\n");
    }

    #[test]
    fn the_columns_of_the_text_are_below_each_other() {
        assert_eq!(table().text(), "NAME   DESCRIPTION\nVAC:P  a \"pressure\", in Pa\n-5     =1+1");
    }
}
