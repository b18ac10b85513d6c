//! Whether a condition holds, going by what the plant shows now and, for what changes, by a little of the past.
//!
//! A reading bounds the pressure: a valid one from both sides, an overrange from below, an underrange from above; one that is
//! invalid or old does not. A condition is judged only if the bounds decide it. Where they do not, nothing is known, and what was
//! last known stays: no alarm is raised and none is over. That nothing is known is an alarm of its own (blind, stale).

use super::rule::{Condition, Rule, Subject};
use crate::view::{BusStationState, Gauge, Reading, Segment, SegmentState};
use profivac_recorder::{Micros, Quality};
use std::collections::VecDeque;
use std::time::Duration;

/// What is seen of the plant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    /// All segments.
    pub segments: Vec<Segment>,
    /// All gauges.
    pub gauges: Vec<Gauge>,
    /// Why nothing is recorded.
    pub recorder_error: Option<String>,
}

impl Inputs {
    fn gauge(&self, name: &str) -> Option<&Gauge> {
        self.gauges.iter().find(|gauge| gauge.name == name)
    }

    fn segment(&self, name: &str) -> Option<&Segment> {
        self.segments.iter().find(|segment| segment.name == name)
    }
}

/// Readings older than so many polls are not fresh, and never sooner than after so long: as on the dashboard. free choice.
const STALE_POLLS: u64 = 5;
const MIN_STALE_MS: u64 = 3_000;

/// Damaged telegrams are counted over so long.
const MINUTE: Duration = Duration::from_secs(60);

/// A line takes so many points.
const MIN_POINTS: usize = 3;

/// What came of looking.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// Whether the condition holds; nothing if that is not known.
    pub holds: Option<bool>,
    /// The number that decided, in the unit of the condition.
    pub value: Option<f64>,
    /// What is seen, in a sentence.
    pub text: String,
}

impl Evaluation {
    /// Something without a number. What is over is not told as if it were so.
    fn plain(holds: Option<bool>, text: String) -> Self {
        Self { holds, value: None, text: if holds == Some(true) { text } else { String::new() } }
    }
}

/// Judges one rule.
#[derive(Clone, Debug, Default)]
pub struct Evaluator {
    /// Of a rate: when, and the logarithm of the pressure or the number of telegrams.
    past: VecDeque<(Micros, f64)>,
}

impl Evaluator {
    /// Whether the condition of `rule` holds at `now` on a clock that nobody sets. While the alarm `stands`, its hysteresis counts.
    pub fn evaluate(&mut self, rule: &Rule, stands: bool, sight: &Inputs, now: Micros) -> Evaluation {
        match (&rule.condition, &rule.subject) {
            (Condition::Above { limit, reset }, Subject::Series { gauge, series }) => bounded(
                sight,
                gauge,
                series,
                |bounds| bounds.above(if stands { *reset } else { *limit }),
                "above",
                *limit,
            ),
            (Condition::Below { limit, reset }, Subject::Series { gauge, series }) => bounded(
                sight,
                gauge,
                series,
                |bounds| bounds.below(if stands { *reset } else { *limit }),
                "below",
                *limit,
            ),
            (Condition::Rise { limit, reset, window }, Subject::Series { gauge, series }) => {
                let point = fresh(sight, gauge).and_then(|gauge| point(gauge, series, now));
                let rate = self.rate(point, *window, now);
                let limit = if stands { *reset } else { *limit };
                let text = rate.map(|rate| format!("{series} changes by {rate:.2} decades per minute"));
                Evaluation { holds: rate.map(|rate| rate > limit), value: rate, text: text.unwrap_or_default() }
            }
            (Condition::NotMeasurable { limits }, Subject::Series { gauge, series }) => {
                unmeasurable(sight, gauge, series, limits)
            }
            (Condition::Fault, Subject::Gauge(name)) => fault(sight, name),
            (Condition::Stale { behind_segment }, Subject::Gauge(name)) => {
                stale(sight, name, behind_segment.as_deref())
            }
            (Condition::SegmentDown, Subject::Segment(name)) => down(sight, name),
            (Condition::DamagedTelegrams { limit }, Subject::Segment(name)) => {
                let count = self.damage(sight.segment(name), now);
                let limit = if stands { limit / 2.0 } else { *limit };
                let text =
                    count.map(|count| format!("{count} telegrams of segment {name} arrived damaged in a minute"));
                Evaluation { holds: count.map(|count| count > limit), value: count, text: text.unwrap_or_default() }
            }
            (Condition::NotRecording, Subject::Station) => Evaluation {
                holds: Some(sight.recorder_error.is_some()),
                value: None,
                text: sight
                    .recorder_error
                    .as_ref()
                    .map(|error| format!("nothing is recorded: {error}"))
                    .unwrap_or_default(),
            },
            // The file makes no other pairs.
            _ => Evaluation::default(),
        }
    }

    /// Decades per minute along the line through the window; nothing before half of it is known.
    fn rate(&mut self, point: Option<(Micros, f64)>, window: Duration, now: Micros) -> Option<f64> {
        let Some((at, decades)) = point else {
            self.past.clear();
            return None;
        };
        if self.past.back().is_none_or(|(last, _)| *last < at) {
            self.past.push_back((at, decades));
        }
        self.forget(now.before(window));
        let (first, last) = (self.past.front()?.0, self.past.back()?.0);
        let covered = i64::try_from(window.as_micros()).unwrap_or(i64::MAX) / 2;
        let enough = self.past.len() >= MIN_POINTS && last.0.saturating_sub(first.0) >= covered;
        enough.then(|| slope(&self.past))?
    }

    /// How many more damaged telegrams there are than a minute ago.
    fn damage(&mut self, segment: Option<&Segment>, now: Micros) -> Option<f64> {
        let Some(segment) = segment.filter(|segment| segment.state == SegmentState::Running) else {
            self.past.clear();
            return None;
        };
        let count = f64::from(segment.damaged);
        // A master that was made anew counts from nothing.
        if self.past.back().is_some_and(|(_, last)| *last > count) {
            self.past.clear();
        }
        self.past.push_back((now, count));
        self.forget(now.before(MINUTE));
        self.past.front().map(|(_, first)| count - first)
    }

    fn forget(&mut self, before: Micros) {
        while self.past.front().is_some_and(|(at, _)| *at < before) {
            self.past.pop_front();
        }
    }
}

/// The slope of the line with the least squares, per minute.
fn slope(points: &VecDeque<(Micros, f64)>) -> Option<f64> {
    let first = points.front()?.0;
    let minutes = |at: Micros| at.0.saturating_sub(first.0) as f64 / (60.0 * Micros::SECOND as f64);
    let count = points.len() as f64;
    let sum = |of: &dyn Fn(f64, f64) -> f64| points.iter().map(|(at, value)| of(minutes(*at), *value)).sum::<f64>();
    let (x, y) = (sum(&|x, _| x) / count, sum(&|_, y| y) / count);
    let spread = sum(&|at, _| (at - x) * (at - x));
    (spread > 0.0).then(|| sum(&|at, value| (at - x) * (value - y)) / spread)
}

/// Between which the pressure lies, in Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounds {
    low: f64,
    high: f64,
}

impl Bounds {
    fn of(reading: &Reading) -> Option<Self> {
        let pa = reading.pa?;
        match reading.quality {
            word if word == Quality::Valid.word() => Some(Self { low: pa, high: pa }),
            word if word == Quality::Overrange.word() => Some(Self { low: pa, high: f64::INFINITY }),
            word if word == Quality::Underrange.word() => Some(Self { low: 0.0, high: pa }),
            _ => None,
        }
    }

    fn above(self, limit: f64) -> Option<bool> {
        decided(self.low > limit, self.high <= limit)
    }

    fn below(self, limit: f64) -> Option<bool> {
        decided(self.high < limit, self.low >= limit)
    }
}

const fn decided(yes: bool, no: bool) -> Option<bool> {
    match (yes, no) {
        (true, _) => Some(true),
        (false, true) => Some(false),
        (false, false) => None,
    }
}

/// The gauge, if what it shows is of now.
fn fresh<'a>(sight: &'a Inputs, name: &str) -> Option<&'a Gauge> {
    sight.gauge(name).filter(|gauge| is_fresh(gauge))
}

fn is_fresh(gauge: &Gauge) -> bool {
    gauge.age_ms.is_some_and(|age| age <= gauge.poll_ms.saturating_mul(STALE_POLLS).max(MIN_STALE_MS))
}

fn reading<'a>(gauge: &'a Gauge, series: &str) -> Option<&'a Reading> {
    gauge.readings.iter().find(|reading| reading.series == series)
}

/// When a valid pressure was read, and its logarithm.
fn point(gauge: &Gauge, series: &str, now: Micros) -> Option<(Micros, f64)> {
    let reading = reading(gauge, series).filter(|reading| reading.quality == Quality::Valid.word())?;
    let pa = reading.pa.filter(|pa| *pa > 0.0)?;
    let age = Duration::from_millis(gauge.age_ms?);
    Some((now.before(age), pa.log10()))
}

fn bounded(
    sight: &Inputs,
    gauge: &str,
    series: &str,
    judged: impl Fn(Bounds) -> Option<bool>,
    side: &str,
    limit: f64,
) -> Evaluation {
    let reading = fresh(sight, gauge).and_then(|gauge| reading(gauge, series));
    let Some((reading, bounds)) = reading.and_then(|reading| Some((reading, Bounds::of(reading)?))) else {
        return Evaluation::default();
    };
    // Where a range ends is no value.
    let value = reading.pa.filter(|_| reading.quality == Quality::Valid.word());
    let shown = value.map_or_else(|| format!("an {}", reading.quality), mbar);
    let text = format!("{series} shows {shown}, {side} the limit of {}", mbar(limit));
    Evaluation { holds: judged(bounds), value, text }
}

fn mbar(pa: f64) -> String {
    format!("{:.2e} mbar", pa / 100.0)
}

/// A gauge that is not heard is not blind but stale.
fn unmeasurable(sight: &Inputs, gauge: &str, series: &str, limits: &[f64]) -> Evaluation {
    let Some(gauge) = fresh(sight, gauge) else { return Evaluation::default() };
    let text = match reading(gauge, series) {
        None => Some(format!("{} has no part {series}", gauge.name)),
        Some(reading) => match Bounds::of(reading) {
            None => Some(format!("{series} has no valid reading")),
            Some(bounds)
                if limits.iter().any(|limit| bounds.above(*limit).is_none() || bounds.below(*limit).is_none()) =>
            {
                Some(format!("{series} shows {}: its range ends before a limit", reading.quality))
            }
            Some(_) => None,
        },
    };
    Evaluation { holds: Some(text.is_some()), value: None, text: text.unwrap_or_default() }
}

/// Only a gauge that exchanges data has no fault.
fn fault(sight: &Inputs, name: &str) -> Evaluation {
    let gauge = fresh(sight, name);
    let holds = gauge.and_then(|gauge| match gauge.standing {
        BusStationState::Faulty => Some(true),
        BusStationState::Exchanging => Some(!gauge.exceptions.is_empty()),
        _ => None,
    });
    let words = gauge.map(|gauge| gauge.exceptions.join(", ")).filter(|words| !words.is_empty());
    let text = words.map_or_else(|| format!("{name} reports a fault"), |words| format!("{name} reports {words}"));
    Evaluation::plain(holds, text)
}

fn stale(sight: &Inputs, name: &str, behind_segment: Option<&str>) -> Evaluation {
    if behind_segment.is_some_and(|segment| down(sight, segment).holds != Some(false)) {
        return Evaluation::default();
    }
    let Some(gauge) = sight.gauge(name) else {
        return Evaluation::plain(Some(true), format!("nothing is known of {name}"));
    };
    let text = match (&gauge.trouble, gauge.age_ms) {
        (Some(trouble), _) => format!("{name} gives no data: {trouble}"),
        (None, None) => format!("{name} never gave data"),
        (None, Some(age)) => format!("{name} gives no data, the last are {} s old", age / 1000),
    };
    Evaluation::plain(Some(!is_fresh(gauge)), text)
}

fn down(sight: &Inputs, name: &str) -> Evaluation {
    let segment = sight.segment(name);
    let holds = segment.is_none_or(|segment| segment.state != SegmentState::Running);
    let trouble = segment.and_then(|segment| segment.trouble.as_deref()).unwrap_or("it waits for its line");
    Evaluation::plain(Some(holds), format!("segment {name} does not run: {trouble}"))
}
