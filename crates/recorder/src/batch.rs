//! The format of a batch: the rows of one transaction of a recorder, for an archive elsewhere.
//!
//! A batch is a message of Protocol Buffers, compressed with deflate (RFC 1951). `docs/archive-format.md` describes it for other
//! programs. A field that a reader does not know is skipped; [`FORMAT`] changes only when an older reader would misunderstand a batch.

use super::point::{Point, PointKind, PointSample};
use super::quality::Quality;
use super::recorded::Recorded;
use super::sample::{Micros, Sample};
use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use prost::Message;
use prost::bytes::Buf;
use prost::encoding::{DecodeContext, decode_key, skip_field};
use std::io::{Read, Write};
use thiserror::Error;

/// The present format.
pub const FORMAT: u32 = 1;

/// The most octets of a batch that is not compressed. The three limits keep a batch from the network from filling the memory.
pub const MAX_OCTETS: u64 = 4 << 20;

/// The most samples of a batch.
pub const MAX_SAMPLES: usize = 20_000;

/// The most series, spans, events, changes of alarms and rows of the audit trail of a batch, together.
pub const MAX_ROWS: usize = 30_000;

/// The rows of a batch.
#[derive(Clone, PartialEq, Message)]
pub struct Batch {
    /// [`FORMAT`] of the writer.
    #[prost(uint32, tag = "1")]
    pub format: u32,
    /// When the batch was written, by the clock of the station, in microseconds since 1970 (UTC), like all times in it.
    #[prost(int64, tag = "2")]
    pub made_us: i64,
    /// Samples, by series.
    #[prost(message, repeated, tag = "3")]
    pub samples: Vec<Samples>,
    /// Spans.
    #[prost(message, repeated, tag = "4")]
    pub spans: Vec<Span>,
    /// Events.
    #[prost(message, repeated, tag = "5")]
    pub events: Vec<Event>,
    /// Rows of the alarm history.
    #[prost(message, repeated, tag = "6")]
    pub alarms: Vec<AlarmChange>,
    /// Rows of the audit trail.
    #[prost(message, repeated, tag = "7")]
    pub audit: Vec<Audit>,
    /// Samples of points, by point. A reader of version 0.1 skips them and the spans of points.
    #[prost(message, repeated, tag = "8")]
    pub point_samples: Vec<PointSamples>,
    /// Spans of points.
    #[prost(message, repeated, tag = "9")]
    pub point_spans: Vec<PointSpan>,
    /// The number of the first batch of the epoch; 0 if an older program has begun the epoch.
    #[prost(int64, tag = "10")]
    pub first_number: i64,
    /// Texts of the codes of points in this batch. A reader of a former version skips them.
    #[prost(message, repeated, tag = "11")]
    pub point_texts: Vec<PointText>,
}

/// Samples of one series.
#[derive(Clone, PartialEq, Message)]
pub struct Samples {
    /// The name of the series.
    #[prost(string, tag = "1")]
    pub series: String,
    /// For each sample the time since the sample before, for the first one since 1970, in microseconds.
    #[prost(sint64, repeated, tag = "2")]
    pub steps_us: Vec<i64>,
    /// For each sample the number of its quality; 128 is added if it has a pressure.
    #[prost(bytes = "vec", tag = "3")]
    pub qualities: Vec<u8>,
    /// The pressures in Pa, of the samples that have one.
    #[prost(double, repeated, tag = "4")]
    pub pressures_pa: Vec<f64>,
}

/// The summary of a part of a series, as in the table `span`.
#[derive(Clone, PartialEq, Message)]
pub struct Span {
    /// The name of the series.
    #[prost(string, tag = "1")]
    pub series: String,
    /// The level: 2 of two minutes, 3 of half an hour, 4 of six hours.
    #[prost(uint32, tag = "2")]
    pub level: u32,
    /// The start.
    #[prost(int64, tag = "3")]
    pub start_us: i64,
    /// The lowest pressure in Pa.
    #[prost(double, optional, tag = "4")]
    pub min_pa: Option<f64>,
    /// The highest pressure in Pa.
    #[prost(double, optional, tag = "5")]
    pub max_pa: Option<f64>,
    /// The sum of the decimal logarithms of the pressures in Pa.
    #[prost(double, tag = "6")]
    pub log10_sum: f64,
    /// The number of pressures.
    #[prost(uint32, tag = "7")]
    pub count: u32,
    /// The qualities that occurred: bit 0 valid, bit 1 overrange, and so on.
    #[prost(uint32, tag = "8")]
    pub qualities: u32,
}

/// A point of a slave, as in the table `point`.
#[derive(Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Message)]
pub struct BatchPoint {
    /// The slave.
    #[prost(string, tag = "1")]
    pub slave: String,
    /// The point.
    #[prost(string, tag = "2")]
    pub name: String,
    /// The unit of the values; empty without one.
    #[prost(string, tag = "3")]
    pub unit: String,
    /// `number`, or `code` for a code or a bit.
    #[prost(string, tag = "4")]
    pub kind: String,
}

/// The text that the file of the station has for a value of a point that is a code or a bit.
#[derive(Clone, PartialEq, Message)]
pub struct PointText {
    /// The point.
    #[prost(message, required, tag = "1")]
    pub point: BatchPoint,
    /// The value in the samples and spans of the point.
    #[prost(double, tag = "2")]
    pub value: f64,
    /// The text.
    #[prost(string, tag = "3")]
    pub text: String,
}

/// Samples of one point.
#[derive(Clone, PartialEq, Message)]
pub struct PointSamples {
    /// The point.
    #[prost(message, required, tag = "1")]
    pub point: BatchPoint,
    /// For each sample the time since the sample before, for the first one since 1970, in microseconds.
    #[prost(sint64, repeated, tag = "2")]
    pub steps_us: Vec<i64>,
    /// For each sample the number of its quality; 128 is added if it has a value.
    #[prost(bytes = "vec", tag = "3")]
    pub qualities: Vec<u8>,
    /// The values in the unit of the point, of the samples that have one.
    #[prost(double, repeated, tag = "4")]
    pub values: Vec<f64>,
}

/// The summary of a part of a point, as in the table `point_span`.
#[derive(Clone, PartialEq, Message)]
pub struct PointSpan {
    /// The point.
    #[prost(message, required, tag = "1")]
    pub point: BatchPoint,
    /// The level: 2 of two minutes, 3 of half an hour, 4 of six hours.
    #[prost(uint32, tag = "2")]
    pub level: u32,
    /// The start.
    #[prost(int64, tag = "3")]
    pub start_us: i64,
    /// The lowest value.
    #[prost(double, optional, tag = "4")]
    pub min_value: Option<f64>,
    /// The highest value.
    #[prost(double, optional, tag = "5")]
    pub max_value: Option<f64>,
    /// The value that was recorded last.
    #[prost(double, optional, tag = "6")]
    pub last_value: Option<f64>,
    /// The sum of the values.
    #[prost(double, tag = "7")]
    pub sum: f64,
    /// The number of values.
    #[prost(uint32, tag = "8")]
    pub count: u32,
    /// The qualities that occurred: bit 0 valid, bit 1 overrange, and so on.
    #[prost(uint32, tag = "9")]
    pub qualities: u32,
}

/// An event.
#[derive(Clone, PartialEq, Message)]
pub struct Event {
    /// Its row in the database.
    #[prost(int64, tag = "1")]
    pub id: i64,
    /// When.
    #[prost(int64, tag = "2")]
    pub at_us: i64,
    /// The name of the gauge.
    #[prost(string, optional, tag = "3")]
    pub series: Option<String>,
    /// The kind, as in the table `event`.
    #[prost(string, tag = "4")]
    pub kind: String,
    /// One sentence.
    #[prost(string, tag = "5")]
    pub text: String,
}

/// A change of an alarm.
#[derive(Clone, PartialEq, Message)]
pub struct AlarmChange {
    /// Its row in the database.
    #[prost(int64, tag = "1")]
    pub id: i64,
    /// When.
    #[prost(int64, tag = "2")]
    pub at_us: i64,
    /// The name of the alarm.
    #[prost(string, tag = "3")]
    pub alarm: String,
    /// The change, as in the table `alarm_history`.
    #[prost(string, tag = "4")]
    pub change: String,
    /// The state after it.
    #[prost(string, tag = "5")]
    pub state: String,
    /// The priority.
    #[prost(string, tag = "6")]
    pub priority: String,
    /// What the alarm is about.
    #[prost(string, optional, tag = "7")]
    pub subject: Option<String>,
    /// The number of the occurrence: the time at which it was raised, in ms since 1970, or one more than the number before.
    #[prost(int64, tag = "8")]
    pub occurrence: i64,
    /// The user who changed it.
    #[prost(string, optional, tag = "9")]
    pub user: Option<String>,
    /// The value that raised it, in `unit`.
    #[prost(double, optional, tag = "10")]
    pub value: Option<f64>,
    /// The unit of `value`.
    #[prost(string, optional, tag = "11")]
    pub unit: Option<String>,
    /// One sentence.
    #[prost(string, tag = "12")]
    pub text: String,
}

/// A row of the audit trail.
#[derive(Clone, PartialEq, Message)]
pub struct Audit {
    /// Its row in the database.
    #[prost(int64, tag = "1")]
    pub id: i64,
    /// When.
    #[prost(int64, tag = "2")]
    pub at_us: i64,
    /// The action, as in the table `audit`.
    #[prost(string, tag = "3")]
    pub action: String,
    /// The row whose outcome this row states.
    #[prost(int64, optional, tag = "4")]
    pub refers_to: Option<i64>,
    /// The user.
    #[prost(string, tag = "5")]
    pub user: String,
    /// The role of the user.
    #[prost(string, tag = "6")]
    pub role: String,
    /// The network address of the user.
    #[prost(string, optional, tag = "7")]
    pub peer: Option<String>,
    /// The gauge.
    #[prost(string, optional, tag = "8")]
    pub gauge: Option<String>,
    /// The parameter that was written or executed.
    #[prost(string, optional, tag = "9")]
    pub target: Option<String>,
    /// The value before.
    #[prost(string, optional, tag = "10")]
    pub before: Option<String>,
    /// The value after.
    #[prost(string, optional, tag = "11")]
    pub after: Option<String>,
    /// The outcome.
    #[prost(string, optional, tag = "12")]
    pub outcome: Option<String>,
}

/// Why octets are no batch.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BatchError {
    /// They cannot be decompressed.
    #[error("the batch is damaged: {0}")]
    Damaged(#[from] std::io::Error),
    /// They are too many.
    #[error("the batch has more than {MAX_OCTETS} octets after decompression")]
    TooLong,
    /// The rows are too many.
    #[error("the batch has more than {MAX_ROWS} series, spans, events, changes of alarms and rows of the audit trail")]
    TooManyRows,
    /// The samples are too many.
    #[error("the batch has {0} samples, and at most {MAX_SAMPLES} are read")]
    TooManySamples(usize),
    /// They are no message.
    #[error("the batch is no message of Protocol Buffers: {0}")]
    NoMessage(#[from] prost::DecodeError),
    /// They are of a later format.
    #[error(
        "the batch has format {0}, and this program reads formats up to {FORMAT}: update the archive before the stations"
    )]
    Format(u32),
    /// Two lists of a series do not fit together.
    #[error(
        "the samples of series {series} have {times} times, {qualities} qualities and {values} values, which do not fit together"
    )]
    Lists {
        /// The series.
        series: String,
        /// The number of times.
        times: usize,
        /// The number of qualities.
        qualities: usize,
        /// The number of values.
        values: usize,
    },
}

impl Batch {
    /// The octets of the batch.
    ///
    /// # Errors
    /// Never: the octets are written to memory.
    pub fn encode_compressed(&self) -> std::io::Result<Vec<u8>> {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&self.encode_to_vec())?;
        encoder.finish()
    }

    /// The batch of these octets.
    ///
    /// # Errors
    /// [`BatchError`] when they are no batch that this program understands.
    pub fn decode_compressed(octets: &[u8]) -> Result<Self, BatchError> {
        let mut plain = Vec::new();
        DeflateDecoder::new(octets).take(MAX_OCTETS.saturating_add(1)).read_to_end(&mut plain)?;
        if plain.len() as u64 > MAX_OCTETS {
            return Err(BatchError::TooLong);
        }
        check_rows(&plain)?;
        let batch = Self::decode(&plain[..])?;
        match (batch.format, batch.sample_count()) {
            (1..=FORMAT, 0..=MAX_SAMPLES) => Ok(batch),
            (1..=FORMAT, samples) => Err(BatchError::TooManySamples(samples)),
            (other, _) => Err(BatchError::Format(other)),
        }
    }

    /// The number of octets before the compression.
    #[must_use]
    pub fn octets(&self) -> usize {
        self.encoded_len()
    }

    /// The number of samples.
    #[must_use]
    pub fn sample_count(&self) -> usize {
        let of_points = self.point_samples.iter().map(|point| point.steps_us.len());
        self.samples.iter().map(|series| series.steps_us.len()).chain(of_points).sum()
    }

    /// The number of series, points and their texts, spans, events, changes of alarms and rows of the audit trail.
    #[must_use]
    pub fn row_count(&self) -> usize {
        let of_pressures = self.samples.len().saturating_add(self.spans.len());
        let of_points: usize = [self.point_samples.len(), self.point_spans.len(), self.point_texts.len()].iter().sum();
        [of_pressures, of_points, self.events.len(), self.alarms.len(), self.audit.len()].iter().sum()
    }
}

/// Refuses too many rows before memory is taken for them: an empty row has two octets here and some 300 in memory.
fn check_rows(plain: &[u8]) -> Result<(), BatchError> {
    let (mut rest, mut rows) = (plain, 0_usize);
    while rest.has_remaining() {
        let (tag, wire_type) = decode_key(&mut rest)?;
        skip_field(wire_type, tag, &mut rest, DecodeContext::default())?;
        rows = rows.saturating_add(1);
    }
    // The two fields that are no rows stand once.
    if rows > MAX_ROWS.saturating_add(2) { Err(BatchError::TooManyRows) } else { Ok(()) }
}

/// Added to the number of a quality whose sample has a value.
const HAS_VALUE: u8 = 128;

/// Times, qualities and values of samples, in lists of their own.
fn packed<T: Recorded>(samples: &[T]) -> (Vec<i64>, Vec<u8>, Vec<f64>) {
    let (mut steps_us, mut qualities, mut values) = (Vec::new(), Vec::new(), Vec::new());
    let mut before = 0;
    for sample in samples {
        steps_us.push(sample.at().0.wrapping_sub(before));
        qualities.push(sample.quality() as u8 | if sample.value().is_some() { HAS_VALUE } else { 0 });
        values.extend(sample.value());
        before = sample.at().0;
    }
    (steps_us, qualities, values)
}

/// The samples of these lists. A quality that this program does not know is a fault without a value.
fn unpacked<T: Recorded>(
    series: &str,
    steps_us: &[i64],
    qualities: &[u8],
    values: &[f64],
) -> Result<Vec<T>, BatchError> {
    let with_value = qualities.iter().filter(|quality| *quality & HAS_VALUE != 0).count();
    if steps_us.len() != qualities.len() || with_value != values.len() {
        let (series, times) = (series.to_owned(), steps_us.len());
        return Err(BatchError::Lists { series, times, qualities: qualities.len(), values: values.len() });
    }
    let mut values = values.iter().copied();
    let mut at = 0_i64;
    let samples = steps_us.iter().zip(qualities).map(|(step, quality)| {
        at = at.wrapping_add(*step);
        let value = if quality & HAS_VALUE == 0 { None } else { values.next() };
        let known = Quality::from_number(i64::from(quality & !HAS_VALUE)).unwrap_or(Quality::Fault);
        T::of(Micros(at), value, known)
    });
    Ok(samples.collect())
}

impl Samples {
    /// Samples of a series.
    #[must_use]
    pub fn new(series: String, samples: &[Sample]) -> Self {
        let (steps_us, qualities, pressures_pa) = packed(samples);
        Self { series, steps_us, qualities, pressures_pa }
    }

    /// The samples. A quality that this program does not know is a fault without a pressure.
    ///
    /// # Errors
    /// [`BatchError::Lists`].
    pub fn unpack(&self) -> Result<Vec<Sample>, BatchError> {
        unpacked(&self.series, &self.steps_us, &self.qualities, &self.pressures_pa)
    }
}

impl BatchPoint {
    /// The point in a batch.
    #[must_use]
    pub fn of(point: &Point) -> Self {
        let Point { slave, name, unit, kind } = point.clone();
        Self { slave, name, unit: unit.unwrap_or_default(), kind: kind.word().to_owned() }
    }

    /// The kind; one of a later program has no mean, as a code.
    #[must_use]
    pub fn point_kind(&self) -> PointKind {
        PointKind::from_word(&self.kind).unwrap_or(PointKind::Code)
    }
}

impl PointSamples {
    /// Samples of a point.
    #[must_use]
    pub fn new(point: BatchPoint, samples: &[PointSample]) -> Self {
        let (steps_us, qualities, values) = packed(samples);
        Self { point, steps_us, qualities, values }
    }

    /// The samples. A quality that this program does not know is a fault without a value.
    ///
    /// # Errors
    /// [`BatchError::Lists`].
    pub fn unpack(&self) -> Result<Vec<PointSample>, BatchError> {
        let name = format!("{}.{}", self.point.slave, self.point.name);
        unpacked(&name, &self.steps_us, &self.qualities, &self.values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples() -> Vec<Sample> {
        vec![
            Sample::new(Micros(1_700_000_000_000_000), Some(1.25e-4), Quality::Valid),
            Sample::gap(Micros(1_700_000_000_500_000)),
            Sample::new(Micros(1_699_999_999_000_000), Some(1e5), Quality::Overrange),
        ]
    }

    fn batch() -> Batch {
        Batch { format: FORMAT, samples: vec![Samples::new("chamber".to_owned(), &samples())], ..Batch::default() }
    }

    #[test]
    fn a_batch_is_the_same_after_the_network() {
        let read = Batch::decode_compressed(&batch().encode_compressed().unwrap()).unwrap();
        assert_eq!(read, batch());
        assert_eq!(read.samples[0].unpack().unwrap(), samples());
    }

    /// The format in the database and on the network: an archive reads batches of older stations.
    #[test]
    fn the_octets_of_a_batch_do_not_change() {
        let octets: String = batch().encode_to_vec().iter().map(|octet| format!("{octet:02x}")).collect();
        assert_eq!(
            octets,
            "08011a310a076368616d626572120f8080f28183898506c0843dbf8db7011a038004812210fca9f1d24d62203f00000000006af840"
        );
    }

    #[test]
    fn a_later_format_a_bomb_and_damaged_octets_are_refused() {
        let later = Batch { format: FORMAT + 1, ..batch() }.encode_compressed().unwrap();
        assert!(matches!(Batch::decode_compressed(&later), Err(BatchError::Format(2))));
        let none = Batch { format: 0, ..batch() }.encode_compressed().unwrap();
        assert!(matches!(Batch::decode_compressed(&none), Err(BatchError::Format(0))));
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&vec![0; 5 << 20]).unwrap();
        assert!(matches!(Batch::decode_compressed(&encoder.finish().unwrap()), Err(BatchError::TooLong)));
        let octets = batch().encode_compressed().unwrap();
        for length in 1..octets.len() {
            // A cut batch never reads as a batch with other samples.
            assert!(Batch::decode_compressed(&octets[..length]).map_or(true, |read| read == batch()), "{length}");
        }
    }

    #[test]
    fn rows_and_samples_beyond_the_limits_are_refused_and_those_at_the_limits_read() {
        let audit = |count| Batch { audit: vec![Audit::default(); count], ..batch() }.encode_compressed().unwrap();
        assert_eq!(Batch::decode_compressed(&audit(MAX_ROWS - 1)).unwrap().row_count(), MAX_ROWS);
        assert!(matches!(Batch::decode_compressed(&audit(MAX_ROWS + 1)), Err(BatchError::TooManyRows)));
        let of_series = |count| Samples::new("chamber".to_owned(), &vec![Sample::gap(Micros(1)); count]);
        let two =
            |count| Batch { samples: vec![of_series(count), of_series(1)], ..batch() }.encode_compressed().unwrap();
        assert_eq!(Batch::decode_compressed(&two(MAX_SAMPLES - 1)).unwrap().sample_count(), MAX_SAMPLES);
        assert!(matches!(Batch::decode_compressed(&two(MAX_SAMPLES)), Err(BatchError::TooManySamples(20_001))));
    }

    fn point_samples() -> Vec<PointSample> {
        vec![
            PointSample::new(Micros(1_700_000_000_000_000), Some(-1.5), Quality::Valid),
            PointSample::gap(Micros(1_700_000_000_500_000)),
            PointSample::new(Micros(1_700_000_001_000_000), Some(0.0), Quality::Valid),
        ]
    }

    fn speed() -> BatchPoint {
        let words = ["turbo", "speed", "Hz", "number"].map(str::to_owned);
        let [slave, name, unit, kind] = words;
        BatchPoint { slave, name, unit, kind }
    }

    fn with_points() -> Batch {
        let span =
            PointSpan { point: speed(), level: 2, start_us: 1_700_000_040_000_000, count: 1, ..PointSpan::default() };
        let samples = vec![PointSamples::new(speed(), &point_samples())];
        let point_texts = vec![PointText { point: speed(), value: 0.0, text: "stopped".to_owned() }];
        Batch { point_samples: samples, point_spans: vec![span], point_texts, ..batch() }
    }

    #[test]
    fn values_of_points_are_the_same_after_the_network_and_count_as_samples() {
        let read = Batch::decode_compressed(&with_points().encode_compressed().unwrap()).unwrap();
        assert_eq!((read.clone(), read.sample_count(), read.row_count()), (with_points(), 6, 4));
        assert_eq!(read.point_samples[0].unpack().unwrap(), point_samples());
        let mut short = PointSamples::new(speed(), &point_samples());
        short.values.pop();
        assert!(matches!(short.unpack(), Err(BatchError::Lists { series, .. }) if series == "turbo.speed"));
    }

    /// The messages as an archive of version 0.1 knows them.
    #[derive(Clone, PartialEq, Message)]
    struct FormerBatch {
        #[prost(uint32, tag = "1")]
        format: u32,
        #[prost(message, repeated, tag = "3")]
        samples: Vec<Samples>,
    }

    #[test]
    fn an_archive_without_points_reads_the_pressures_of_a_batch_with_points() {
        let read = FormerBatch::decode(&with_points().encode_to_vec()[..]).unwrap();
        assert_eq!((read.format, read.samples), (FORMAT, batch().samples));
    }

    #[test]
    fn a_reader_skips_fields_that_it_does_not_know() {
        let mut octets = batch().encode_to_vec();
        // Field 200, of type octets, with three of them.
        octets.extend([0xc2, 0x0c, 3, 1, 2, 3]);
        assert_eq!(Batch::decode(&octets[..]).unwrap(), batch());
    }

    #[test]
    fn lists_of_different_lengths_are_refused() {
        let mut packed = Samples::new("chamber".to_owned(), &samples());
        packed.pressures_pa.pop();
        assert!(matches!(packed.unpack(), Err(BatchError::Lists { .. })));
    }
}
