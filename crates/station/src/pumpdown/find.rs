//! The pump-downs there are: a pressure that falls by two decades or more, from the last moment at the top to the next
//! venting or the end of what is known.
//!
//! The last moment at the top is that of the last sample within 5 % of the highest, and from there on back to where the
//! pressure began to fall without a break.

use profivac_recorder::{Micros, Quality, Sample};

/// A fall by so many decades is a pump-down. free choice: less is done by opening a valve.
const LEAST: f64 = 2.0;

/// So near to the highest pressure is still the top, in decades: 5 %.
const TOP: f64 = 0.0223;

/// A venting rises to within so many decades of where the pump-down began.
const VENTED: f64 = 1.0;

/// So near to the lowest pressure is still the bottom, in decades: a factor of two.
const BOTTOM: f64 = 0.301;

/// From one moment to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeRange {
    /// The beginning.
    pub start: Micros,
    /// The end.
    pub end: Micros,
}

impl TimeRange {
    /// Its length in seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        super::trace::seconds(self.start, self.end)
    }

    /// Whether both have a time in common.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.start < other.end && other.start < self.end
    }
}

/// A pump-down as one gauge saw it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PumpDown {
    /// From when to when.
    pub span: TimeRange,
    /// Which gauge saw it, by its place in what was given.
    pub gauge: usize,
    /// The pressure at the beginning, in Pa.
    pub start_pa: f64,
    /// The lowest pressure, in Pa.
    pub lowest_pa: f64,
    /// Whether it ended with a venting, and not with what is known.
    pub is_vented: bool,
}

impl PumpDown {
    /// By how many decades the pressure fell.
    #[must_use]
    pub fn decades(&self) -> f64 {
        (self.start_pa / self.lowest_pa).log10()
    }

    /// What counts more: to have begun at a higher pressure, then to have fallen further. A hot cathode falls over many
    /// decades too, but begins late.
    fn rank(&self) -> (f64, f64) {
        (self.start_pa.log10().round(), self.decades())
    }
}

/// A sample on the way, with the logarithm of its pressure.
#[derive(Clone, Copy)]
struct Point {
    at: Micros,
    y: f64,
}

/// What is known on the way through the samples, by their places.
enum Way {
    /// The highest pressure, and the last place near it.
    Top { high: f64, last: usize },
    /// Where it began, the lowest pressure, and the last place near that.
    Down { from: usize, low: f64, last: usize },
}

/// All pump-downs in the samples of one gauge, the earliest first. Overrange counts as the end of the range, and so does
/// underrange.
#[must_use]
pub fn find(samples: &[Sample], gauge: usize) -> Vec<PumpDown> {
    let points: Vec<Point> = samples
        .iter()
        .filter(|sample| matches!(sample.quality, Quality::Valid | Quality::Overrange | Quality::Underrange))
        .filter_map(|sample| Some(Point { at: sample.at, y: sample.decades()? }))
        .collect();
    let mut found = Vec::new();
    let mut way = Way::Top { high: f64::MIN, last: 0 };
    for (place, point) in points.iter().enumerate() {
        way = match way {
            Way::Top { high, last } => top(&points, place, high, last),
            Way::Down { from, low, last } => {
                if is_vented(&points, from, low, point.y) {
                    found.extend(chosen_of(&points, gauge, from, low, last, true));
                    Way::Top { high: point.y, last: place }
                } else {
                    let low = low.min(point.y);
                    Way::Down { from, low, last: if point.y <= low + BOTTOM { place } else { last } }
                }
            }
        };
    }
    if let Way::Down { from, low, .. } = way {
        found.extend(chosen_of(&points, gauge, from, low, points.len().saturating_sub(1), false));
    }
    found
}

fn top(points: &[Point], place: usize, high: f64, last: usize) -> Way {
    let y = points.get(place).map_or(f64::MIN, |point| point.y);
    let high = high.max(y);
    if y >= high - TOP {
        return Way::Top { high, last: place };
    }
    if y > high - LEAST {
        return Way::Top { high, last };
    }
    Way::Down { from: shoulder(points, last), low: y, last: place }
}

/// Back from the last place near the top to where the pressure began to fall without a break.
fn shoulder(points: &[Point], last: usize) -> usize {
    let y = |place: usize| points.get(place).map_or(f64::MIN, |point| point.y);
    let mut place = last;
    while place > 0 && y(place - 1) > y(place) {
        place -= 1;
    }
    place
}

fn is_vented(points: &[Point], from: usize, low: f64, y: f64) -> bool {
    y >= low + LEAST && points.get(from).is_some_and(|start| y >= start.y - VENTED)
}

fn chosen_of(points: &[Point], gauge: usize, from: usize, low: f64, to: usize, is_vented: bool) -> Option<PumpDown> {
    let (from, to) = (points.get(from)?, points.get(to)?);
    Some(PumpDown {
        span: TimeRange { start: from.at, end: to.at },
        gauge,
        start_pa: 10_f64.powf(from.y),
        lowest_pa: 10_f64.powf(low),
        is_vented,
    })
}

/// The pump-downs of a chamber that several gauges saw, the earliest first: what overlaps is one, and the gauge that saw
/// most of it says when it was.
#[must_use]
pub fn select(mut found: Vec<PumpDown>) -> Vec<PumpDown> {
    found.sort_by(|one, two| {
        let ((height, decades), (other_height, other_decades)) = (two.rank(), one.rank());
        height.total_cmp(&other_height).then(decades.total_cmp(&other_decades))
    });
    let mut leads: Vec<PumpDown> = Vec::new();
    for one in found {
        if leads.iter().all(|lead| !lead.span.overlaps(&one.span)) {
            leads.push(one);
        }
    }
    leads.sort_by_key(|one| one.span.start);
    leads
}
