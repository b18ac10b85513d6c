//! The samples of a gauge in a span of time, as pieces of one quality.
//!
//! What the dead band left out is no gap: a pressure holds until the next sample. A gap is what the record calls one, or a
//! time in which it has nothing although it keeps a sample a minute.

use super::find::TimeRange;
use profivac_recorder::{Deadband, Micros, Quality, Sample};

/// So many values in a row, of which the middle one counts: single outliers go, slopes and steps stay. free choice.
const MEDIAN: usize = 5;

/// A time of one quality.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// What the samples are worth.
    pub quality: Quality,
    /// Its beginning, in seconds since the beginning of the span.
    pub from_s: f64,
    /// Its end: where the next piece begins, or the last sample.
    pub to_s: f64,
    /// Seconds and Pa; empty where there is no pressure. In overrange and underrange the end of the range.
    pub points: Vec<(f64, f64)>,
    /// The same without outliers, for times and slopes.
    pub smooth: Vec<(f64, f64)>,
}

/// A gauge in a span.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Its pieces, in the order of time.
    pub pieces: Vec<Section>,
    /// How many samples they are made from.
    pub samples: usize,
    /// The time between two samples, in seconds: the middle one of all.
    pub spacing_s: Option<f64>,
}

impl Trace {
    /// What `samples` show from the beginning of `span` to its end. Those before and after it say what held at its ends.
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
        let mut trace = Self { pieces: Vec::new(), samples: inside.len(), spacing_s };
        held.iter().chain(inside).for_each(|sample| trace.take(sample, span.start, longest));
        if let Some(next) = samples.get(end) {
            trace.hold(seconds(span.start, next.at), next.pa, span.seconds(), longest);
        }
        trace.pieces.iter_mut().filter(|piece| piece.quality == Quality::Valid).for_each(Section::calm);
        trace
    }

    fn take(&mut self, sample: &Sample, start: Micros, longest: f64) {
        let t = seconds(start, sample.at);
        let last = self.pieces.last().map(|piece| (piece.quality, piece.to_s));
        let is_hole = last.is_some_and(|(quality, to_s)| quality != Quality::Gap && t - to_s > longest);
        match self.pieces.last_mut() {
            Some(piece) if is_hole => {
                let from_s = piece.to_s;
                self.pieces.push(Section::begin(Quality::Gap, from_s));
                self.close(t);
                self.pieces.push(Section::begin(sample.quality, t));
            }
            Some(piece) if piece.quality == sample.quality => {}
            _ => {
                self.close(t);
                self.pieces.push(Section::begin(sample.quality, t));
            }
        }
        if let Some(piece) = self.pieces.last_mut() {
            piece.to_s = t;
            piece.points.extend(sample.pa.map(|pa| (t, pa)));
        }
    }

    /// What was last before the end holds there, as the next sample shows, which comes after it.
    fn hold(&mut self, next_s: f64, next_pa: Option<f64>, end_s: f64, longest: f64) {
        let Some(piece) = self.pieces.last_mut().filter(|piece| next_s - piece.to_s <= longest) else { return };
        let last = piece.points.last().copied().filter(|_| piece.quality == Quality::Valid);
        if let Some(((s, pa), next_pa)) = last.zip(next_pa) {
            piece.points.push((end_s, pa * (next_pa / pa).powf((end_s - s) / (next_s - s))));
        }
        piece.to_s = end_s;
    }

    /// A piece without a curve lasts until the next begins.
    fn close(&mut self, t: f64) {
        if let Some(piece) = self.pieces.last_mut().filter(|piece| piece.quality != Quality::Valid) {
            piece.to_s = t;
        }
    }

    /// The pieces in which the gauge measures.
    pub fn valid(&self) -> impl Iterator<Item = &Section> {
        self.pieces.iter().filter(|piece| piece.quality == Quality::Valid)
    }

    /// How long a quality lasted, in seconds.
    #[must_use]
    pub fn seconds_of(&self, quality: Quality) -> f64 {
        self.pieces.iter().filter(|piece| piece.quality == quality).map(|piece| piece.to_s - piece.from_s).sum()
    }

    /// The first pressure, the lowest and the last, with their times. Only what was measured counts.
    #[must_use]
    pub fn ends(&self) -> Option<[(f64, f64); 3]> {
        let mut points = self.valid().flat_map(|piece| &piece.smooth).copied();
        let first = points.next()?;
        Some(
            points.fold([first; 3], |[first, low, _], point| [first, if point.1 < low.1 { point } else { low }, point]),
        )
    }

    /// Whether the pressure changed by more than this, in decades.
    #[must_use]
    pub fn has_moved(&self, decades: f64) -> bool {
        let points = || self.valid().flat_map(|piece| &piece.smooth).map(|(_, pa)| pa.log10());
        points().fold(f64::MIN, f64::max) - points().fold(f64::MAX, f64::min) > decades
    }
}

impl Section {
    const fn begin(quality: Quality, from_s: f64) -> Self {
        Self { quality, from_s, to_s: from_s, points: Vec::new(), smooth: Vec::new() }
    }

    /// A running median. The ends have nothing beside them and stay.
    fn calm(&mut self) {
        let half = MEDIAN / 2;
        self.smooth.clone_from(&self.points);
        for (place, window) in self.points.windows(MEDIAN).enumerate() {
            let mut values: Vec<f64> = window.iter().map(|(_, pa)| *pa).collect();
            values.sort_by(f64::total_cmp);
            if let (Some(point), Some(middle)) = (self.smooth.get_mut(place + half), values.get(half)) {
                point.1 = *middle;
            }
        }
    }
}

/// From one moment to another.
#[must_use]
pub fn seconds(from: Micros, to: Micros) -> f64 {
    to.0.saturating_sub(from.0) as f64 / Micros::SECOND as f64
}

/// Longer without a sample is a gap: twice what the recorder lets pass.
fn hole() -> f64 {
    2.0 * Deadband::default().max_interval.as_secs_f64()
}

fn spacing(samples: &[Sample]) -> Option<f64> {
    let mut times: Vec<f64> =
        samples.windows(2).filter_map(|pair| Some(seconds(pair.first()?.at, pair.last()?.at))).collect();
    let middle = times.len() / 2;
    (!times.is_empty()).then(|| *times.select_nth_unstable_by(middle, f64::total_cmp).1)
}
