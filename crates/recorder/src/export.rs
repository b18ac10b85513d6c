//! Samples as rows, chunk by chunk: a year of samples does not fit into memory, and the recipient may be slow.
//!
//! Each chunk is a separate query. No read transaction stays open between chunks, so the recorder can truncate its log, and the
//! export contains samples that were recorded meanwhile.

use super::error::DatabaseError;
use super::reader::Reader;
use super::sample::{Micros, Sample};
use std::collections::VecDeque;
use std::fmt::Write;

/// Samples in a chunk, about 120 kB of CSV.
const SAMPLES_PER_CHUNK: u32 = 2_000;

/// Consecutive samples of one series.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk {
    /// The name of the series.
    pub series: String,
    /// The samples in the order of time; empty when the series has no more.
    pub samples: Vec<Sample>,
}

/// The samples of series, one series after the other.
pub struct Chunks {
    reader: Reader,
    series: VecDeque<String>,
    /// Where the first of `series` continues.
    next: Micros,
    from: Micros,
    to: Micros,
}

impl Chunks {
    /// The samples of these series from `from` to `to`.
    #[must_use]
    pub fn new(reader: Reader, series: Vec<String>, from: Micros, to: Micros) -> Self {
        Self { reader, series: series.into(), next: from, from, to }
    }

    /// The next samples of a series. After its last sample the next series follows.
    fn read(&mut self, series: String) -> Result<Chunk, DatabaseError> {
        let samples = self.reader.page(&series, self.next, self.to, SAMPLES_PER_CHUNK)?;
        match samples.last() {
            Some(last) if samples.len() >= SAMPLES_PER_CHUNK as usize && last.at < self.to => {
                self.next = Micros(last.at.0.saturating_add(1));
            }
            _ => {
                self.series.pop_front();
                self.next = self.from;
            }
        }
        Ok(Chunk { series, samples })
    }
}

impl Iterator for Chunks {
    type Item = Result<Chunk, DatabaseError>;

    /// The next chunk. An error ends the series.
    fn next(&mut self) -> Option<Self::Item> {
        let series = self.series.front()?.clone();
        let chunk = self.read(series);
        if chunk.is_err() {
            self.series.clear();
        }
        Some(chunk)
    }
}

/// An export as CSV: time in ISO 8601 (UTC), series, pressure in Pa, quality.
pub struct Export {
    chunks: Chunks,
    has_heading: bool,
}

impl Export {
    /// The samples of these series from `from` to `to`.
    #[must_use]
    pub fn new(reader: Reader, series: Vec<String>, from: Micros, to: Micros) -> Self {
        Self { chunks: Chunks::new(reader, series, from, to), has_heading: false }
    }
}

impl Iterator for Export {
    type Item = Result<String, DatabaseError>;

    /// The heading, then chunks of rows. An error ends the export.
    fn next(&mut self) -> Option<Self::Item> {
        if !std::mem::replace(&mut self.has_heading, true) {
            return Some(Ok("time,gauge,pressure_pa,quality\n".to_owned()));
        }
        let chunk = self.chunks.next()?;
        Some(chunk.map(|Chunk { series, samples }| {
            let name = csv_field(&series);
            samples.iter().map(|sample| csv_row(&name, sample)).collect()
        }))
    }
}

/// A number for people: seven significant digits, which is the precision of a float that a gauge sends. The digits behind them come from
/// the conversion and mean nothing: 5e-6 mbar as a float is 4.999999873689376e-4 Pa.
#[must_use]
pub fn seven_digits(number: f64) -> f64 {
    format!("{number:.6e}").parse().unwrap_or(number)
}

fn csv_row(name: &str, sample: &Sample) -> String {
    let mut row = format!("{},{name},", iso(sample.at));
    if let Some(pa) = sample.pa {
        // Writing into a String does not fail.
        write!(row, "{:e}", seven_digits(pa)).unwrap_or_default();
    }
    row + "," + sample.quality.word() + "\n"
}

/// A name as a CSV field (RFC 4180), in quotes where it needs them.
fn csv_field(name: &str) -> String {
    if is_formula(name) || name.contains([',', '"', '\n', '\r']) { quoted(name) } else { name.to_owned() }
}

/// A text as a CSV field in quotes (RFC 4180). A text that a spreadsheet would take for a formula gets an apostrophe before it.
#[must_use]
pub fn quoted(text: &str) -> String {
    let guard = if is_formula(text) { "'" } else { "" };
    format!("\"{guard}{}\"", text.replace('"', "\"\""))
}

fn is_formula(text: &str) -> bool {
    text.starts_with(['=', '+', '-', '@', '\t', '\r'])
}

/// A time in ISO 8601, in UTC with microseconds.
#[must_use]
pub fn iso(at: Micros) -> String {
    at.to_iso(6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_is_quoted_where_needed_and_no_formula() {
        let fields = ["chamber", "a,b", "the \"old\" one", "=1+2", "-a\"b"].map(csv_field);
        assert_eq!(fields, ["chamber", "\"a,b\"", "\"the \"\"old\"\" one\"", "\"'=1+2\"", "\"'-a\"\"b\""]);
        assert_eq!(["chamber", "@x"].map(quoted), ["\"chamber\"", "\"'@x\""]);
    }

    #[test]
    fn a_number_for_people_has_the_digits_of_a_float() {
        let pa = f64::from(5e-6_f32) * 100.0;
        assert_ne!(pa, 5e-4, "the float has other digits behind its precision");
        assert_eq!(seven_digits(pa), 5e-4);
        for number in [0.0, 1013.25, 1.234_567e-9, -5.5, 1e300] {
            assert_eq!(seven_digits(number), number);
        }
        assert_eq!(seven_digits(1.234_567_8), 1.234_568);
        assert!(seven_digits(f64::NAN).is_nan() && seven_digits(f64::INFINITY).is_infinite());
        let sample = Sample { at: Micros(0), pa: Some(pa), quality: crate::Quality::Valid };
        assert_eq!(csv_row("chamber", &sample), "1970-01-01T00:00:00.000000Z,chamber,5e-4,valid\n");
    }

    #[test]
    fn a_time_after_the_year_9999_is_written_as_the_last_one() {
        assert_eq!(iso(Micros(1_767_225_600_000_001)), "2026-01-01T00:00:00.000001Z");
        assert_eq!(iso(Micros(i64::MAX)), "9999-12-30T22:00:00.999999Z");
        assert_eq!(iso(Micros(i64::MIN)), "1970-01-01T00:00:00.000000Z");
    }
}
