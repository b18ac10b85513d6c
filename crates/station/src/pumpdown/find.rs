//! The search for pump-downs. A pump-down is a fall of the pressure by two decades or more, from the last time at the top to the next
//! venting or to the last sample.
//!
//! The last time at the top is that of the last sample within 5 % of the highest pressure, and from there back to where the
//! pressure began to fall monotonically.

use super::time_range::TimeRange;
use profivac_recorder::{Micros, Quality, Sample};

/// The smallest fall, in decades. chosen: opening a valve causes a smaller one.
const LEAST: f64 = 2.0;

/// The top: within this distance of the highest pressure, in decades (5 %).
const TOP: f64 = 0.0223;

/// A venting: a rise to within this distance of the initial pressure, in decades.
const VENTED: f64 = 1.0;

/// The bottom: within this distance of the lowest pressure, in decades (a factor of two).
const BOTTOM: f64 = 0.301;

/// A pump-down as one gauge measured it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PumpDown {
    /// The time range.
    pub span: TimeRange,
    /// The index of the gauge, as given to [`find`].
    pub gauge: usize,
    /// The pressure at the beginning, in Pa.
    pub start_pa: f64,
    /// The lowest pressure, in Pa.
    pub lowest_pa: f64,
    /// Whether a venting ended it; otherwise the samples ended.
    pub is_vented: bool,
}

impl PumpDown {
    /// The fall of the pressure, in decades.
    #[must_use]
    pub fn decades(&self) -> f64 {
        (self.start_pa / self.lowest_pa).log10()
    }

    /// The rank among gauges: the initial pressure first, then the fall. A hot cathode falls over many decades too, but measures
    /// late.
    fn rank(&self) -> (f64, f64) {
        (self.start_pa.log10().round(), self.decades())
    }
}

/// A sample with the logarithm of its pressure.
#[derive(Clone, Copy)]
struct Point {
    at: Micros,
    y: f64,
}

/// The state of the search, with indices of samples.
enum State {
    /// At the top: the highest pressure, and the last sample near it.
    Top { high: f64, last: usize },
    /// On the way down: the first sample, the lowest pressure, and the last sample near it.
    Down { from: usize, low: f64, last: usize },
}

/// All pump-downs in the samples of one gauge, the earliest first. Overrange and underrange count as the ends of the range.
#[must_use]
pub fn find(samples: &[Sample], gauge: usize) -> Vec<PumpDown> {
    let points: Vec<Point> = samples
        .iter()
        .filter(|sample| matches!(sample.quality, Quality::Valid | Quality::Overrange | Quality::Underrange))
        .filter_map(|sample| Some(Point { at: sample.at, y: sample.decades()? }))
        .collect();
    let mut found = Vec::new();
    let mut state = State::Top { high: f64::MIN, last: 0 };
    for (index, point) in points.iter().enumerate() {
        state = match state {
            State::Top { high, last } => top(&points, index, high, last),
            State::Down { from, low, last } => {
                if is_vented(&points, from, low, point.y) {
                    found.extend(pump_down(&points, gauge, from, low, last, true));
                    State::Top { high: point.y, last: index }
                } else {
                    let low = low.min(point.y);
                    State::Down { from, low, last: if point.y <= low + BOTTOM { index } else { last } }
                }
            }
        };
    }
    if let State::Down { from, low, .. } = state {
        found.extend(pump_down(&points, gauge, from, low, points.len().saturating_sub(1), false));
    }
    found
}

fn top(points: &[Point], index: usize, high: f64, last: usize) -> State {
    let y = points.get(index).map_or(f64::MIN, |point| point.y);
    let high = high.max(y);
    if y >= high - TOP {
        return State::Top { high, last: index };
    }
    if y > high - LEAST {
        return State::Top { high, last };
    }
    State::Down { from: shoulder(points, last), low: y, last: index }
}

/// From the last sample near the top back to where the pressure began to fall monotonically.
fn shoulder(points: &[Point], last: usize) -> usize {
    let y = |index: usize| points.get(index).map_or(f64::MIN, |point| point.y);
    let mut index = last;
    while index > 0 && y(index - 1) > y(index) {
        index -= 1;
    }
    index
}

fn is_vented(points: &[Point], from: usize, low: f64, y: f64) -> bool {
    y >= low + LEAST && points.get(from).is_some_and(|start| y >= start.y - VENTED)
}

fn pump_down(points: &[Point], gauge: usize, from: usize, low: f64, to: usize, is_vented: bool) -> Option<PumpDown> {
    let (from, to) = (points.get(from)?, points.get(to)?);
    Some(PumpDown {
        span: TimeRange { start: from.at, end: to.at },
        gauge,
        start_pa: 10_f64.powf(from.y),
        lowest_pa: 10_f64.powf(low),
        is_vented,
    })
}

/// The pump-downs of a chamber with several gauges, the earliest first. Overlapping pump-downs are one, and the gauge with the highest
/// rank gives its times.
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
