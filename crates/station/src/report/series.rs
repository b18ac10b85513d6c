//! The samples of a series in a time range, in an amount that fits into memory, and the pump-downs in a whole database.
//!
//! A database may hold two years with five samples a second. The beginning of a time range is read sample by sample. Later parts
//! are read in longer spans if they hold too many samples, which a logarithmic time axis shows in the same way.

use crate::pumpdown::{PumpDown, TimeRange, find, select};
use profivac_recorder::reader::Span;
use profivac_recorder::spans::{LEVELS, Level};
use profivac_recorder::{DatabaseError, Micros, Qualities, Quality, Reader, Sample};
use std::time::Duration;

/// The most samples that are read for each part of a time range. chosen: some megabytes, some tenths of a second.
const MOST: u32 = 200_000;

/// The number of spans for a part with more samples.
const BINS: u32 = 20_000;

/// The time before and after the range in which samples give the values at its ends: twice the longest interval between two samples.
const HELD: Duration = Duration::from_secs(120);

/// The length of the first part, in microseconds; each further part is ten times as long.
const FIRST_PART: i64 = 3_600 * Micros::SECOND;

/// The search ranges for pump-downs, in seconds before the last sample, and the length of the spans in which they are searched.
const LOOKS: [(i64, i64); 3] = [(86_400, 1), (30 * 86_400, 10), (i64::MAX, 120)];

/// The samples of a series.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// The samples.
    pub samples: Vec<Sample>,
    /// The length of the longest span used in place of samples, in seconds; `None` if all samples are stored.
    pub coarsest_s: Option<f64>,
}

/// The samples of a time range, and those of two minutes before and after it, which give the values at its ends.
///
/// # Errors
/// [`DatabaseError`] when the database cannot be read.
pub fn series(reader: &Reader, gauge: &str, span: TimeRange) -> Result<Series, DatabaseError> {
    let mut series = Series::default();
    let mut from = span.start.before(HELD);
    let end = span.end.after(HELD);
    let mut part = FIRST_PART;
    while from <= end {
        let to = Micros(from.0.saturating_add(part).min(end.0));
        series.read(reader, gauge, from, to)?;
        // There is no time after the largest one.
        let Some(next) = to.0.checked_add(1) else { break };
        from = Micros(next);
        part = part.saturating_mul(10);
    }
    Ok(series)
}

impl Series {
    fn read(&mut self, reader: &Reader, gauge: &str, from: Micros, to: Micros) -> Result<(), DatabaseError> {
        let page = reader.page(gauge, from, to, MOST)?;
        if page.len() >= MOST as usize {
            let bins = reader.trend(gauge, from, to, BINS)?;
            self.take(&bins, width(&bins));
        } else if page.is_empty() {
            let bins = older(reader, gauge, from, to)?;
            self.take(&bins, width(&bins));
        } else {
            self.samples.extend(page);
        }
        Ok(())
    }

    fn take(&mut self, bins: &[Span], width: Option<i64>) {
        let width = width.map(|width| width as f64 / Micros::SECOND as f64);
        self.coarsest_s = [self.coarsest_s, width].into_iter().flatten().reduce(f64::max);
        self.samples.extend(bins.iter().map(sample));
    }
}

/// The spans of a time range without samples. A span that overlaps the first sample is left out.
fn older(reader: &Reader, gauge: &str, from: Micros, to: Micros) -> Result<Vec<Span>, DatabaseError> {
    let Some(first) = reader.first_sample(gauge)? else { return reader.trend(gauge, from, to, BINS) };
    if first <= from {
        return Ok(Vec::new());
    }
    let mut bins = reader.trend(gauge, from, to.min(first), BINS)?;
    let width = width(&bins);
    bins.retain(|bin| width.is_some_and(|width| bin.start.0.saturating_add(width) <= first.0));
    Ok(bins)
}

/// The length of spans, in microseconds. Spans begin at pixels, so the nearest length of a stored level is meant.
fn width(bins: &[Span]) -> Option<i64> {
    let least =
        bins.windows(2).filter_map(|pair| Some(pair.last()?.start.0.saturating_sub(pair.first()?.start.0))).min()?;
    let is_near = |level: &i64| level.abs_diff(least) < level.unsigned_abs() / 4;
    Some(LEVELS.into_iter().map(Level::micros).find(is_near).unwrap_or(least))
}

/// The sample that stands for a span: the end of the range if the gauge was beyond it, otherwise the mean.
fn sample(bin: &Span) -> Sample {
    let occurred: Qualities = bin.summary.qualities;
    let first = |all: &[Quality]| all.iter().copied().find(|quality| occurred.contains(*quality));
    let without_pressure = [Quality::Stale, Quality::Assumed, Quality::Fault, Quality::Off, Quality::Missing];
    let (pa, quality) = match (bin.summary.bound(), bin.summary.mean()) {
        (Some(bound), _) => (Some(bound), first(&[Quality::Overrange, Quality::Underrange])),
        (None, Some(mean)) => (Some(mean), Some(Quality::Valid)),
        (None, None) => (None, first(&without_pressure)),
    };
    Sample::new(bin.start, pa, quality.unwrap_or(Quality::Fault))
}

/// The pump-downs of these series, the earliest first: all of them, or those in the shortest search range in which one began.
///
/// # Errors
/// [`DatabaseError`] when the database cannot be read.
pub fn pump_downs(reader: &Reader, gauges: &[String], is_all: bool) -> Result<Vec<PumpDown>, DatabaseError> {
    let Some(known) = known(reader, gauges)? else { return Ok(Vec::new()) };
    for (back, width) in LOOKS {
        let from = Micros(known.end.0.saturating_sub(back.saturating_mul(Micros::SECOND)));
        let is_last = back == i64::MAX || from <= known.start;
        if is_all && !is_last {
            continue;
        }
        let start = if is_last { known.start } else { from };
        let looked = TimeRange { start, end: known.end };
        let found = within(reader, gauges, looked, width)?;
        // A pump-down at the beginning of the search range may have begun before it.
        let begun = |one: &PumpDown| one.span.start > start.after(Duration::from_secs(60));
        if is_last || found.last().is_some_and(begun) {
            return sharp(reader, gauges, &found, width);
        }
    }
    Ok(Vec::new())
}

/// The pump-downs of these series in a time range, the earliest first, searched in spans of a length in s.
///
/// # Errors
/// [`DatabaseError`] when the database cannot be read.
pub fn pump_downs_in(
    reader: &Reader,
    gauges: &[String],
    looked: TimeRange,
    width: i64,
) -> Result<Vec<PumpDown>, DatabaseError> {
    let found = within(reader, gauges, looked, width)?;
    sharp(reader, gauges, &found, width)
}

/// The same pump-downs, searched in the samples.
fn sharp(reader: &Reader, gauges: &[String], found: &[PumpDown], width: i64) -> Result<Vec<PumpDown>, DatabaseError> {
    let sharp: Result<Vec<_>, _> = found.iter().map(|one| sharpened(reader, gauges, one, width)).collect();
    Ok(select(sharp?.into_iter().flatten().collect()))
}

/// The time range from the first to the last sample.
///
/// # Errors
/// [`DatabaseError`] when the database cannot be read.
pub fn known(reader: &Reader, gauges: &[String]) -> Result<Option<TimeRange>, DatabaseError> {
    let mut known: Option<TimeRange> = None;
    for gauge in gauges {
        if let Some((start, end)) = reader.time_range(gauge)? {
            let all = known.get_or_insert(TimeRange { start, end });
            *all = TimeRange { start: all.start.min(start), end: all.end.max(end) };
        }
    }
    Ok(known)
}

/// The change of the pressure in a time range, in decades; `None` without samples.
///
/// # Errors
/// [`DatabaseError`] when the database cannot be read.
pub fn moved(reader: &Reader, gauge: &str, span: TimeRange) -> Result<Option<f64>, DatabaseError> {
    let is_sampled = !reader.page(gauge, span.start, span.end, 1)?.is_empty();
    let bins = if is_sampled {
        reader.trend(gauge, span.start, span.end, 1_000)?
    } else {
        older(reader, gauge, span.start, span.end)?
    };
    let low = bins.iter().filter_map(|bin| bin.summary.low).reduce(f64::min);
    let high = bins.iter().filter_map(|bin| bin.summary.high).reduce(f64::max);
    let moved = high.zip(low).map(|(high, low)| (high / low).log10());
    Ok(moved.or(is_sampled.then_some(0.0)))
}

fn within(reader: &Reader, gauges: &[String], span: TimeRange, width: i64) -> Result<Vec<PumpDown>, DatabaseError> {
    let pixels = u32::try_from((span.seconds() / width as f64).ceil() as i64).unwrap_or(u32::MAX).max(1);
    let mut found = Vec::new();
    for (index, gauge) in gauges.iter().enumerate() {
        let bins = reader.trend(gauge, span.start, span.end, pixels)?;
        found.extend(find(&outlines(&bins), index));
    }
    Ok(select(found))
}

/// The highest and the lowest pressure of each span, in the order of a falling pressure.
fn outlines(bins: &[Span]) -> Vec<Sample> {
    let end = |bin: &Span, pa| Sample::new(bin.start, pa, sample(bin).quality);
    bins.iter().flat_map(|bin| [end(bin, bin.summary.high), end(bin, bin.summary.low)]).collect()
}

/// The same pump-down, searched in the samples. `None` if it was none: a rise and a fall within one span.
fn sharpened(
    reader: &Reader,
    gauges: &[String],
    one: &PumpDown,
    width: i64,
) -> Result<Option<PumpDown>, DatabaseError> {
    let margin = Duration::from_secs(width.unsigned_abs().saturating_mul(3));
    let around = TimeRange { start: one.span.start.before(margin), end: one.span.end.after(margin) };
    let Some(gauge) = gauges.get(one.gauge) else { return Ok(None) };
    let found = find(&series(reader, gauge, around)?.samples, one.gauge);
    let nearest = found.into_iter().filter(|other| other.span.overlaps(&one.span));
    let longest = nearest.max_by(|one, two| one.span.seconds().total_cmp(&two.span.seconds()));
    // The venting may lie behind a gap, outside the samples that were read.
    Ok(longest.map(|sharp| PumpDown { is_vented: sharp.is_vented || one.is_vented, ..sharp }))
}
