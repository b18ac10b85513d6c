//! What was recorded as CSV, piece by piece: a year does not fit into memory, and whoever takes it may be slow.
//!
//! Each piece is a question of its own to the file. Nothing is held between two of them, so the log of the recorder can be
//! cut back meanwhile, and what is recorded meanwhile is in the table too.

use super::database::DatabaseError;
use super::reader::Reader;
use super::sample::{Micros, Sample};
use std::collections::VecDeque;
use std::fmt::Write;

/// So many samples are in a piece, about 120 kB.
const SAMPLES_PER_CHUNK: u32 = 2_000;

/// A table that is being written: time in ISO 8601 (UTC), gauge, pressure in Pa, quality.
pub struct Export {
    reader: Reader,
    gauges: VecDeque<String>,
    /// Where the present gauge goes on, and where each begins and ends.
    next: Micros,
    from: Micros,
    to: Micros,
    is_begun: bool,
}

impl Export {
    /// The samples of these gauges in a time.
    #[must_use]
    pub fn new(reader: Reader, gauges: Vec<String>, from: Micros, to: Micros) -> Self {
        Self { reader, gauges: gauges.into(), next: from, from, to, is_begun: false }
    }

    /// The next samples of the present gauge as rows. After its last ones the next gauge is the present one.
    fn rows(&mut self, gauge: &str) -> Result<String, DatabaseError> {
        let samples = self.reader.page(gauge, self.next, self.to, SAMPLES_PER_CHUNK)?;
        let quoted = csv_field(gauge);
        match samples.last() {
            Some(last) if samples.len() >= SAMPLES_PER_CHUNK as usize && last.at < self.to => {
                self.next = Micros(last.at.0.saturating_add(1));
            }
            _ => {
                self.gauges.pop_front();
                self.next = self.from;
            }
        }
        Ok(samples.iter().map(|sample| csv_row(&quoted, sample)).collect())
    }
}

impl Iterator for Export {
    type Item = Result<String, DatabaseError>;

    /// The heading, then rows. After an error there is nothing more.
    fn next(&mut self) -> Option<Self::Item> {
        if !std::mem::replace(&mut self.is_begun, true) {
            return Some(Ok("time,gauge,pressure_pa,quality\n".to_owned()));
        }
        let gauge = self.gauges.front()?.clone();
        let rows = self.rows(&gauge);
        if rows.is_err() {
            self.gauges.clear();
        }
        Some(rows)
    }
}

fn csv_row(gauge: &str, sample: &Sample) -> String {
    let mut row = format!("{},{gauge},", iso(sample.at));
    if let Some(pa) = sample.pa {
        // A String takes everything.
        write!(row, "{pa:e}").unwrap_or_default();
    }
    row + "," + sample.quality.word() + "\n"
}

/// A name in CSV, RFC 4180. What would begin a formula in a spreadsheet gets an apostrophe before it.
fn csv_field(name: &str) -> String {
    if name.starts_with(['=', '+', '-', '@', '\t', '\r']) {
        return format!("\"'{}\"", name.replace('"', "\"\""));
    }
    if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() }
}

/// A moment as ISO 8601 has it, in UTC with microseconds.
#[must_use]
pub fn iso(at: Micros) -> String {
    humantime::format_rfc3339_micros(at.to_system_time()).to_string()
}
