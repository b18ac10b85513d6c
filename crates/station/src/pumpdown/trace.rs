//! The samples of a series in a time range, as sections of one quality.
//!
//! A sample that the deadband left out is no gap: the pressure holds until the next sample. A gap is a recorded gap, or a time
//! without samples that is longer than the recorder permits.

use super::time_range::{TimeRange, seconds};
use profivac_recorder::{Deadband, Micros, Quality, Sample};

/// The length of the running median: it removes single outliers and keeps slopes and steps. chosen.
const MEDIAN: usize = 5;

/// A time of one quality.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// The quality.
    pub quality: Quality,
    /// Its beginning, in seconds since the beginning of the time range.
    pub from_s: f64,
    /// Its end: the beginning of the next section, or the last sample.
    pub to_s: f64,
    /// Seconds and Pa; empty without pressures. In overrange and underrange the end of the range.
    pub points: Vec<(f64, f64)>,
    /// The same after a running median, for times and slopes.
    pub smooth: Vec<(f64, f64)>,
}

/// The samples of a series.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// The sections, in the order of time.
    pub sections: Vec<Section>,
    /// The number of samples.
    pub samples: usize,
    /// The median time between two samples, in seconds.
    pub spacing_s: Option<f64>,
}

impl Trace {
    /// The sections from the beginning of `span` to its end. The samples before and after it give the values at its ends.
    #[must_use]
    pub fn new(samples: &[Sample], span: TimeRange) -> Self {
        let first = samples.partition_point(|sample| sample.at < span.start);
        let end = samples.partition_point(|sample| sample.at <= span.end);
        let inside = samples.get(first..end).unwrap_or_default();
        let spacing_s = spacing(inside);
        let longest = spacing_s.map_or(hole(), |spacing| hole().max(3.0 * spacing));
        let held = first.checked_sub(1).and_then(|before| samples.get(before)).filter(|held| {
            let next = inside.first();
            seconds(held.at, span.start) <= longest && next.is_some_and(|next| seconds(held.at, next.at) <= longest)
        });
        let held = held
            .map(|held| Sample { at: span.start, ..*held })
            .filter(|held| inside.first().is_some_and(|next| next.at > held.at));
        let mut trace = Self { sections: Vec::new(), samples: inside.len(), spacing_s };
        held.iter().chain(inside).for_each(|sample| trace.take(sample, span.start, longest));
        if let Some(next) = samples.get(end) {
            trace.hold(next, seconds(span.start, next.at), span.seconds(), longest);
        }
        trace.sections.iter_mut().filter(|section| section.quality == Quality::Valid).for_each(Section::apply_median);
        trace
    }

    fn take(&mut self, sample: &Sample, start: Micros, longest: f64) {
        let t = seconds(start, sample.at);
        let last = self.sections.last().map(|section| (section.quality, section.to_s));
        let is_hole = last.is_some_and(|(quality, to_s)| quality != Quality::Stale && t - to_s > longest);
        match self.sections.last_mut() {
            Some(section) if is_hole => {
                let from_s = section.to_s;
                self.sections.push(Section::begin(Quality::Stale, from_s));
                self.close(t);
                self.sections.push(Section::begin(sample.quality, t));
            }
            Some(section) if section.quality == sample.quality => {}
            _ => {
                self.close(t);
                self.sections.push(Section::begin(sample.quality, t));
            }
        }
        if let Some(section) = self.sections.last_mut() {
            section.to_s = t;
            section.points.extend(sample.pa.map(|pa| (t, pa)));
        }
    }

    /// Extends the last section to the end of the time range, interpolated to the next sample after it. The end of a range is no pressure to
    /// interpolate to.
    fn hold(&mut self, next: &Sample, next_s: f64, end_s: f64, longest: f64) {
        let Some(section) = self.sections.last_mut().filter(|section| next_s - section.to_s <= longest) else { return };
        let last = section.points.last().copied().filter(|_| section.quality == Quality::Valid);
        let next_pa = next.pa.filter(|_| next.quality == Quality::Valid);
        if let Some(((s, pa), next_pa)) = last.zip(next_pa) {
            section.points.push((end_s, pa * (next_pa / pa).powf((end_s - s) / (next_s - s))));
        }
        section.to_s = end_s;
    }

    /// A section without a curve lasts until the next one begins.
    fn close(&mut self, t: f64) {
        if let Some(section) = self.sections.last_mut().filter(|section| section.quality != Quality::Valid) {
            section.to_s = t;
        }
    }

    /// The sections with valid pressures.
    pub fn valid(&self) -> impl Iterator<Item = &Section> {
        self.sections.iter().filter(|section| section.quality == Quality::Valid)
    }

    /// The total time of a quality, in seconds.
    #[must_use]
    pub fn seconds_of(&self, quality: Quality) -> f64 {
        self.sections
            .iter()
            .filter(|section| section.quality == quality)
            .map(|section| section.to_s - section.from_s)
            .sum()
    }

    /// The first, the lowest and the last valid pressure, with their times.
    #[must_use]
    pub fn ends(&self) -> Option<[(f64, f64); 3]> {
        let mut points = self.valid().flat_map(|section| &section.smooth).copied();
        let first = points.next()?;
        Some(
            points.fold([first; 3], |[first, low, _], point| [first, if point.1 < low.1 { point } else { low }, point]),
        )
    }

    /// Whether the pressure changed by more than `decades`.
    #[must_use]
    pub fn has_moved(&self, decades: f64) -> bool {
        let points = || self.valid().flat_map(|section| &section.smooth).map(|(_, pa)| pa.log10());
        points().fold(f64::MIN, f64::max) - points().fold(f64::MAX, f64::min) > decades
    }
}

impl Section {
    const fn begin(quality: Quality, from_s: f64) -> Self {
        Self { quality, from_s, to_s: from_s, points: Vec::new(), smooth: Vec::new() }
    }

    /// A running median. The first and the last samples stay unchanged.
    fn apply_median(&mut self) {
        let half = MEDIAN / 2;
        self.smooth.clone_from(&self.points);
        for (index, window) in self.points.windows(MEDIAN).enumerate() {
            let mut values: Vec<f64> = window.iter().map(|(_, pa)| *pa).collect();
            values.sort_by(f64::total_cmp);
            if let (Some(point), Some(middle)) = (self.smooth.get_mut(index + half), values.get(half)) {
                point.1 = *middle;
            }
        }
    }
}

/// The longest time without a sample, in seconds: twice the longest interval of the recorder.
fn hole() -> f64 {
    2.0 * Deadband::default().max_interval.as_secs_f64()
}

fn spacing(samples: &[Sample]) -> Option<f64> {
    let mut times: Vec<f64> =
        samples.windows(2).filter_map(|pair| Some(seconds(pair.first()?.at, pair.last()?.at))).collect();
    let middle = times.len() / 2;
    (!times.is_empty()).then(|| *times.select_nth_unstable_by(middle, f64::total_cmp).1)
}
