//! Samples as rows, chunk by chunk: a year of samples does not fit into memory, and the recipient may be slow.
//!
//! Each chunk is a separate query. No read transaction stays open between chunks, so the recorder can truncate its log, and the
//! export contains samples that were recorded meanwhile.
//!
//! Pressures and values of points are separate tables: a column has one unit, or a column beside it says the unit of each row.

use super::error::DatabaseError;
use super::point::{DescribedPoint, PointSample};
use super::reader::Reader;
use super::recorded::Recorded;
use super::sample::{Micros, Sample};
use std::collections::VecDeque;

/// Samples in a chunk, about 120 kB of CSV.
const SAMPLES_PER_CHUNK: u32 = 2_000;

/// A series that is exported: a gauge or a channel by its name, or a point.
pub trait Exported: Clone {
    /// Its samples.
    type Sample: Recorded;

    /// The columns of text that name the series, between the time and the value.
    const LABELS: &'static [&'static str];

    /// Whether the last column is the text of the value.
    const HAS_TEXT: bool;

    /// The texts of the columns that name the series.
    fn labels(&self) -> Vec<&str>;

    /// The text of a value; `None` for a number without one.
    fn text(&self, value: f64) -> Option<&str>;

    /// A value as CSV.
    fn number(value: f64) -> String;

    /// The first `limit` kept samples from `from` to `to`.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    fn page(&self, reader: &Reader, from: Micros, to: Micros, limit: u32) -> Result<Vec<Self::Sample>, DatabaseError>;
}

/// A series of pressures in Pa.
impl Exported for String {
    type Sample = Sample;

    const LABELS: &'static [&'static str] = &["gauge"];
    const HAS_TEXT: bool = false;

    fn labels(&self) -> Vec<&str> {
        vec![self]
    }

    fn text(&self, _: f64) -> Option<&str> {
        None
    }

    fn number(value: f64) -> String {
        format!("{:e}", seven_digits(value))
    }

    fn page(&self, reader: &Reader, from: Micros, to: Micros, limit: u32) -> Result<Vec<Sample>, DatabaseError> {
        reader.page(self, from, to, limit)
    }
}

/// A point, whose unit is a column, empty without one. The text of a code is the last column.
impl Exported for DescribedPoint {
    type Sample = PointSample;

    const LABELS: &'static [&'static str] = &["slave", "point", "unit"];
    const HAS_TEXT: bool = true;

    fn labels(&self) -> Vec<&str> {
        vec![&self.point.slave, &self.point.name, self.point.unit.as_deref().unwrap_or_default()]
    }

    fn text(&self, value: f64) -> Option<&str> {
        self.text_of(value)
    }

    /// All digits, because a counter of 32 bits has ten; a very large or small number with an exponent.
    fn number(value: f64) -> String {
        let is_usual = value == 0.0 || (1e-6..1e15).contains(&value.abs());
        if is_usual { value.to_string() } else { format!("{value:e}") }
    }

    fn page(&self, reader: &Reader, from: Micros, to: Micros, limit: u32) -> Result<Vec<PointSample>, DatabaseError> {
        reader.point_page(&self.point, from, to, limit)
    }
}

/// Consecutive samples of one series.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk<S: Exported = String> {
    /// The series.
    pub series: S,
    /// The samples in the order of time; empty when the series has no more.
    pub samples: Vec<S::Sample>,
}

/// The samples of series, one series after the other.
pub struct Chunks<S: Exported = String> {
    reader: Reader,
    series: VecDeque<S>,
    /// Where the first of `series` continues.
    next: Micros,
    from: Micros,
    to: Micros,
}

impl<S: Exported> Chunks<S> {
    /// The samples of these series from `from` to `to`.
    #[must_use]
    pub fn new(reader: Reader, series: Vec<S>, from: Micros, to: Micros) -> Self {
        Self { reader, series: series.into(), next: from, from, to }
    }

    /// The next samples of a series. After its last sample the next series follows.
    fn read(&mut self, series: S) -> Result<Chunk<S>, DatabaseError> {
        let samples = series.page(&self.reader, self.next, self.to, SAMPLES_PER_CHUNK)?;
        match samples.last() {
            Some(last) if samples.len() >= SAMPLES_PER_CHUNK as usize && last.at() < self.to => {
                self.next = Micros(last.at().0.saturating_add(1));
            }
            _ => {
                self.series.pop_front();
                self.next = self.from;
            }
        }
        Ok(Chunk { series, samples })
    }
}

impl<S: Exported> Iterator for Chunks<S> {
    type Item = Result<Chunk<S>, DatabaseError>;

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

/// An export as CSV: time in ISO 8601 (UTC); the gauge and its pressure in Pa, or slave, point, unit and value; quality; of a point the text.
pub struct Export<S: Exported = String> {
    chunks: Chunks<S>,
    has_heading: bool,
}

impl<S: Exported> Export<S> {
    /// The samples of these series from `from` to `to`.
    #[must_use]
    pub fn new(reader: Reader, series: Vec<S>, from: Micros, to: Micros) -> Self {
        Self { chunks: Chunks::new(reader, series, from, to), has_heading: false }
    }
}

impl<S: Exported> Iterator for Export<S> {
    type Item = Result<String, DatabaseError>;

    /// The heading, then chunks of rows. An error ends the export.
    fn next(&mut self) -> Option<Self::Item> {
        if !std::mem::replace(&mut self.has_heading, true) {
            let text = if S::HAS_TEXT { ",text" } else { "" };
            return Some(Ok(format!("time,{},{},quality{text}\n", S::LABELS.join(","), S::Sample::VALUE)));
        }
        let chunk = self.chunks.next()?;
        Some(chunk.map(|Chunk { series, samples }| {
            let labels = series.labels().into_iter().map(csv_field).collect::<Vec<_>>().join(",");
            samples.iter().map(|sample| csv_row(&series, &labels, sample)).collect()
        }))
    }
}

/// A number for people: seven significant digits, which is the precision of a float that a gauge sends. The digits behind them come from
/// the conversion and mean nothing: 5e-6 mbar as a float is 4.999999873689376e-4 Pa.
#[must_use]
pub fn seven_digits(number: f64) -> f64 {
    format!("{number:.6e}").parse().unwrap_or(number)
}

fn csv_row<S: Exported>(series: &S, labels: &str, sample: &S::Sample) -> String {
    let value = sample.value().map(S::number).unwrap_or_default();
    let text = sample.value().and_then(|value| series.text(value)).map(csv_field).unwrap_or_default();
    let text = if S::HAS_TEXT { format!(",{text}") } else { text };
    format!("{},{labels},{value},{}{text}\n", iso(sample.at()), sample.quality().word())
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
    use crate::{Point, PointKind};

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
        assert_eq!(
            csv_row(&"chamber".to_owned(), "chamber", &sample),
            "1970-01-01T00:00:00.000000Z,chamber,5e-4,valid\n"
        );
    }

    #[test]
    fn a_value_of_a_point_has_all_digits_of_a_counter() {
        let (slave, name, unit) = ("turbo".to_owned(), "energy".to_owned(), Some("kWh".to_owned()));
        let point = Point { slave, name, unit, kind: PointKind::Number };
        let energy = DescribedPoint { point, texts: Vec::new() };
        let row = |number| {
            let sample = PointSample::new(Micros(0), number, crate::Quality::Valid);
            csv_row(&energy, &energy.labels().join(","), &sample)
        };
        assert_eq!(row(Some(429_496_729.4)), "1970-01-01T00:00:00.000000Z,turbo,energy,kWh,429496729.4,valid,\n");
        assert_eq!(row(None), "1970-01-01T00:00:00.000000Z,turbo,energy,kWh,,fault,\n");
        let numbers = [0.0, -40.0, 4_294_967_295.0, 1e-7, 3.402_823_5e38].map(DescribedPoint::number);
        assert_eq!(numbers, ["0", "-40", "4294967295", "1e-7", "3.4028235e38"]);
    }

    #[test]
    fn a_time_after_the_year_9999_is_written_as_the_last_one() {
        assert_eq!(iso(Micros(1_767_225_600_000_001)), "2026-01-01T00:00:00.000001Z");
        assert_eq!(iso(Micros(i64::MAX)), "9999-12-30T22:00:00.999999Z");
        assert_eq!(iso(Micros(i64::MIN)), "1970-01-01T00:00:00.000000Z");
    }
}
