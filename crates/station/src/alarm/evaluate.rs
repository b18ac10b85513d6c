//! Evaluates the condition of an alarm from the present snapshots and, for rates, from the recent past.
//!
//! A reading bounds the pressure: a valid one from both sides, an overrange from below, an underrange from above; all others do
//! not. A limit condition is known only if the bounds decide it. An unknown condition neither raises nor clears an alarm;
//! that it is unknown is an alarm of its own (not measurable, stale).

use super::rule::{BusQuantity, Condition, PointTest, Rule, Series};
use crate::gateway_status::ArchiveState;
use crate::view::{BusStationState, Gauge, Reading, Segment, SegmentState, fault_text, mbar};
use profivac_listen::report::BusReport;
use profivac_recorder::validity::is_fresh;
use profivac_recorder::{Micros, Quality};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::Duration;

/// The snapshots from which alarms are evaluated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    /// All segments.
    pub segments: Vec<Segment>,
    /// All gauges.
    pub gauges: Vec<Gauge>,
    /// The lines of the segments, by the name of the segment.
    pub buses: BTreeMap<String, Arc<BusReport>>,
    /// The reason why the recorder does not write, if it does not.
    pub recorder_error: Option<String>,
    /// The damage of the database and what to do, in a sentence, if the last check has found any.
    pub damage: Option<String>,
    /// The archive, if the station sends to one.
    pub archive: Option<ArchiveState>,
}

impl Inputs {
    fn gauge(&self, name: &str) -> Option<&Gauge> {
        self.gauges.iter().find(|gauge| gauge.name == name)
    }

    fn segment(&self, name: &str) -> Option<&Segment> {
        self.segments.iter().find(|segment| segment.name == name)
    }

    /// The gauges and slaves of a segment.
    fn gauges_of(&self, segment: &str) -> impl Iterator<Item = &Gauge> {
        self.gauges.iter().filter(move |gauge| gauge.segment == segment)
    }

    /// The gauge of this name, if its readings are fresh.
    fn fresh_gauge(&self, name: &str) -> Option<&Gauge> {
        self.gauge(name).filter(|gauge| is_fresh(gauge.age_ms, gauge.poll_ms))
    }

    /// The reading of a measuring part, if it is fresh.
    fn fresh_reading(&self, series: &Series) -> Option<&Reading> {
        self.fresh_gauge(&series.gauge).and_then(|gauge| reading(gauge, &series.name))
    }
}

/// Damaged telegrams are counted over this time.
const MINUTE: Duration = Duration::from_secs(60);

/// The fewest points of a line.
const MIN_POINTS: usize = 3;

/// The result of an evaluation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// Whether the condition is met; `None` if that is unknown.
    pub holds: Option<bool>,
    /// The number that decides, in the unit of the condition.
    pub value: Option<f64>,
    /// A sentence about the present state.
    pub text: String,
}

impl Evaluation {
    /// An evaluation without a number. The sentence is used only if the condition is met.
    fn without_value(holds: Option<bool>, text: String) -> Self {
        Self { holds, value: None, text: if holds == Some(true) { text } else { String::new() } }
    }

    /// An evaluation without a number that holds if there is a sentence.
    fn met_if_some(text: Option<String>) -> Self {
        Self { holds: Some(text.is_some()), value: None, text: text.unwrap_or_default() }
    }

    /// An evaluation of a number, which holds above `threshold`; unknown without the number.
    fn above(value: Option<f64>, threshold: f64, text: impl FnOnce(f64) -> String) -> Self {
        Self { holds: value.map(|value| value > threshold), value, text: value.map(text).unwrap_or_default() }
    }
}

/// Evaluates one rule.
#[derive(Clone, Debug, Default)]
pub struct Evaluator {
    /// The past of a rate: times with logarithms of pressure, or with numbers of telegrams.
    past: VecDeque<(Micros, f64)>,
    /// Since when a rate is unknown because readings are beyond the range of the gauge, with all readings since then bounding the
    /// pressure.
    beyond_since: Option<Micros>,
    /// Those of the conditions of [`Condition::Several`].
    conditions: Vec<Evaluator>,
}

impl Evaluator {
    /// Evaluates `rule` at `now`, a monotonic time. While the alarm `is_active`, the reset value counts instead of the limit.
    pub fn evaluate(&mut self, rule: &Rule, is_active: bool, inputs: &Inputs, now: Micros) -> Evaluation {
        self.condition(&rule.condition, is_active, inputs, now)
    }

    fn condition(&mut self, condition: &Condition, is_active: bool, inputs: &Inputs, now: Micros) -> Evaluation {
        let threshold = |limit: f64, reset: f64| if is_active { reset } else { limit };
        match condition {
            Condition::Above { series, limit, reset } => {
                let threshold = Threshold { limit: *limit, present: threshold(*limit, *reset) };
                bounded(inputs, series, Bounds::above, ("above", "not above"), threshold)
            }
            Condition::Below { series, limit, reset } => {
                let threshold = Threshold { limit: *limit, present: threshold(*limit, *reset) };
                bounded(inputs, series, Bounds::below, ("below", "not below"), threshold)
            }
            Condition::Rise { series, limit, reset, window } => {
                let point = inputs.fresh_gauge(&series.gauge).and_then(|gauge| point(gauge, &series.name, now));
                let rate = self.rate(point, *window, now);
                match inputs.fresh_reading(series) {
                    Some(reading) if self.stays_beyond_range(rate, reading, *window, now) => {
                        let text = format!("{} shows {}, no rise at the end of its range", series.name, shown(reading));
                        Evaluation { holds: Some(false), value: None, text }
                    }
                    Some(_) => Evaluation::above(rate, threshold(*limit, *reset), |rate| {
                        format!("{} changes by {rate:.2} decades per minute", series.name)
                    }),
                    None => {
                        self.beyond_since = None;
                        Evaluation::default()
                    }
                }
            }
            Condition::Several { conditions, count } => {
                self.conditions.resize_with(conditions.len(), Self::default);
                let evaluators = self.conditions.iter_mut().zip(conditions);
                let all: Vec<_> = evaluators
                    .map(|(evaluator, condition)| evaluator.condition(condition, is_active, inputs, now))
                    .collect();
                several(&all, *count)
            }
            Condition::Point { gauge, point, test, .. } => point_test(inputs, gauge, point, test, is_active),
            Condition::NotMeasurable { series, limits, has_fault_alarm } => {
                not_measurable(inputs, series, limits, *has_fault_alarm)
            }
            Condition::Fault { gauge } => fault(inputs, gauge),
            Condition::Stale { gauge, behind_segment } => stale(inputs, gauge, behind_segment.as_deref()),
            Condition::SegmentDown { segment } => segment_down(inputs, segment),
            Condition::DamagedTelegrams { segment, limit } => {
                let count = self.damaged(inputs.segment(segment), now);
                Evaluation::above(count, threshold(*limit, *limit / 2.0), |count| {
                    format!("{count} telegrams of segment {segment} arrived damaged in the last minute")
                })
            }
            Condition::BusRate { segment, station, quantity, limit } => {
                let percent = bus_rate(inputs, segment, *station, *quantity);
                Evaluation::above(percent, threshold(*limit, *limit / 2.0), |percent| {
                    let what = quantity.text();
                    format!(
                        "{what} of station {station} on segment {segment}: {percent:.2} % of its requests in the last minute"
                    )
                })
            }
            Condition::NotRecording => {
                let text = inputs.recorder_error.as_ref().map(|error| format!("the recorder does not write: {error}"));
                Evaluation::met_if_some(text)
            }
            Condition::DatabaseDamaged => Evaluation::met_if_some(inputs.damage.clone()),
            Condition::NotArchived { limit } => not_archived(inputs.archive.as_ref(), *limit),
        }
    }

    /// Decades per minute along the line through the window; unknown until half of the window is covered.
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

    /// Whether the reading is beyond the range of the gauge, and the rate has been unknown for longer than the window only because readings
    /// are, or change between both sides of its end. Such a pressure does not rise any more, as far as the gauge can tell. Readings within
    /// the range for half of the window have a rate, and the wait begins anew; with fewer of them nothing is known.
    fn stays_beyond_range(&mut self, rate: Option<f64>, reading: &Reading, window: Duration, now: Micros) -> bool {
        if rate.is_some() || Bounds::of(reading).is_none() {
            self.beyond_since = None;
        } else if reading.quality != Quality::Valid {
            self.beyond_since.get_or_insert(now);
        }
        reading.quality != Quality::Valid && self.beyond_since.is_some_and(|since| since.after(window) < now)
    }

    /// The number of telegrams damaged within the last minute.
    fn damaged(&mut self, segment: Option<&Segment>, now: Micros) -> Option<f64> {
        let Some(segment) = segment.filter(|segment| segment.state == SegmentState::Running) else {
            self.past.clear();
            return None;
        };
        let count = f64::from(segment.damaged_telegrams);
        // A restarted master counts from zero.
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

/// The archive has not answered for more than `limit` hours, or there is a problem that does not wait for that.
fn not_archived(archive: Option<&ArchiveState>, limit: f64) -> Evaluation {
    let Some(ArchiveState { silence, problem }) = archive else { return Evaluation::default() };
    let hours = silence.as_secs_f64() / 3_600.0;
    let holds = problem.is_some() || hours > limit;
    let text = problem.clone().unwrap_or_else(|| format!("the archive has not answered for {hours:.1} h"));
    // In tenths: a value that changes all the time would be published all the time.
    Evaluation { holds: Some(holds), value: Some((hours * 10.0).floor() / 10.0), text }
}

/// At least `count` of the conditions are met. Conditions that are not known decide neither.
fn several(conditions: &[Evaluation], count: usize) -> Evaluation {
    let met: Vec<_> = conditions.iter().filter(|condition| condition.holds == Some(true)).collect();
    let possible = conditions.iter().filter(|condition| condition.holds != Some(false)).count();
    let holds = decided(met.len() >= count, possible < count);
    let texts: Vec<_> = met.iter().map(|condition| condition.text.as_str()).collect();
    let text = format!("{} of {}", met.len(), conditions.len());
    let text = if texts.is_empty() { text } else { format!("{text}: {}", texts.join("; ")) };
    Evaluation { holds, value: Some(met.len() as f64), text }
}

/// The part of the requests to a station in percent; unknown without a request in the last minute.
fn bus_rate(inputs: &Inputs, segment: &str, station: u8, quantity: BusQuantity) -> Option<f64> {
    inputs.segment(segment).filter(|segment| segment.state == SegmentState::Running)?;
    let stations = &inputs.buses.get(segment)?.stations;
    let counts = stations.iter().find(|other| other.address == station)?.last_minute;
    (counts.requests > 0).then(|| match quantity {
        BusQuantity::Repetitions => counts.repeated_percent(),
        BusQuantity::Lost => counts.lost_percent(),
        BusQuantity::Damaged => counts.damaged_percent(),
    })
}

/// The slope of the least-squares line, per minute.
fn slope(points: &VecDeque<(Micros, f64)>) -> Option<f64> {
    let first = points.front()?.0;
    let minutes = |at: Micros| at.0.saturating_sub(first.0) as f64 / (60.0 * Micros::SECOND as f64);
    let count = points.len() as f64;
    let sum = |of: &dyn Fn(f64, f64) -> f64| points.iter().map(|(at, value)| of(minutes(*at), *value)).sum::<f64>();
    let (x, y) = (sum(&|x, _| x) / count, sum(&|_, y| y) / count);
    let spread = sum(&|at, _| (at - x) * (at - x));
    (spread > 0.0).then(|| sum(&|at, value| (at - x) * (value - y)) / spread)
}

/// The bounds of a pressure, in Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounds {
    low: f64,
    high: f64,
}

impl Bounds {
    /// The bounds that a reading gives, if it gives any.
    fn of(reading: &Reading) -> Option<Self> {
        let pa = reading.bound_pa()?;
        match reading.quality {
            Quality::Valid => Some(Self { low: pa, high: pa }),
            Quality::Overrange => Some(Self { low: pa, high: f64::INFINITY }),
            Quality::Underrange => Some(Self { low: 0.0, high: pa }),
            Quality::Fault | Quality::Stale | Quality::Off | Quality::Missing | Quality::Assumed => None,
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

fn reading<'a>(gauge: &'a Gauge, series: &str) -> Option<&'a Reading> {
    gauge.readings.iter().find(|reading| reading.series == series)
}

/// The time of a valid reading, and the logarithm of its pressure.
fn point(gauge: &Gauge, series: &str, now: Micros) -> Option<(Micros, f64)> {
    let reading = reading(gauge, series).filter(|reading| reading.quality == Quality::Valid)?;
    let age = Duration::from_millis(gauge.age_ms?);
    Some((now.before(age), reading.pa?.log10()))
}

/// The pressures of a limit alarm, in Pa.
struct Threshold {
    limit: f64,
    /// The pressure that decides now: the reset value while the alarm is active, otherwise the limit.
    present: f64,
}

impl Threshold {
    /// The pressure that decides for a reading, and its name. Beyond the range of a gauge it is the limit in any case: the pressure cannot
    /// pass a reset value that the gauge does not measure, and the end of the range does not flicker.
    fn for_reading(&self, reading: &Reading) -> (f64, &'static str) {
        let has_reset = self.present != self.limit && reading.quality == Quality::Valid;
        if has_reset { (self.present, "reset value") } else { (self.limit, "limit") }
    }
}

/// Evaluates a limit. The words are those for a condition that is met and for one that is not.
fn bounded(
    inputs: &Inputs,
    series: &Series,
    decide: impl Fn(Bounds, f64) -> Option<bool>,
    (met, cleared): (&str, &str),
    threshold: Threshold,
) -> Evaluation {
    let reading = inputs.fresh_reading(series);
    let Some((reading, bounds)) = reading.and_then(|reading| Some((reading, Bounds::of(reading)?))) else {
        return Evaluation::default();
    };
    let (threshold, name) = threshold.for_reading(reading);
    let holds = decide(bounds, threshold);
    let side = if holds == Some(true) { met } else { cleared };
    let text = format!("{} shows {}, {side} the {name} of {}", series.name, shown(reading), mbar(threshold));
    Evaluation { holds, value: reading.pa, text }
}

/// The reading in words: `5.00e-4 mbar`, `under range (< 5.00e-4 mbar)`, `off`.
fn shown(reading: &Reading) -> String {
    let label = reading.quality.label();
    let sign = if reading.quality == Quality::Underrange { '<' } else { '>' };
    match (reading.pa, reading.limit_pa, &reading.cause) {
        (Some(pa), _, _) => mbar(pa),
        (None, Some(limit), _) => format!("{label} ({sign} {})", mbar(limit)),
        (None, None, Some(cause)) => format!("{label} ({cause})"),
        (None, None, None) => label.to_owned(),
    }
}

/// A stale gauge and a fault are not reported here but by their own alarms.
fn not_measurable(inputs: &Inputs, series: &Series, limits: &[f64], has_fault_alarm: bool) -> Evaluation {
    let Some(gauge) = inputs.fresh_gauge(&series.gauge) else { return Evaluation::default() };
    let name = &series.name;
    if has_fault_alarm && reading(gauge, name).is_some_and(|reading| reading.quality == Quality::Fault) {
        return Evaluation::default();
    }
    let undecided = |bounds: Bounds, limit: f64| bounds.above(limit).is_none() || bounds.below(limit).is_none();
    let text = match reading(gauge, name) {
        None => Some(format!("{} has no series {name}", gauge.name)),
        Some(reading) => match Bounds::of(reading) {
            None => Some(format!("{name} shows no pressure: {}", shown(reading))),
            Some(bounds) if limits.iter().any(|limit| undecided(bounds, *limit)) => {
                Some(format!("{name} is {}: its range ends before a limit", shown(reading)))
            }
            Some(_) => None,
        },
    };
    Evaluation::met_if_some(text)
}

/// The condition ends only when the gauge is in data exchange and reports no fault. A pressure out of range, and a gauge that is off,
/// is no fault.
fn fault(inputs: &Inputs, name: &str) -> Evaluation {
    let gauge = inputs.fresh_gauge(name);
    let holds = gauge.and_then(|gauge| match gauge.state {
        BusStationState::Fault => Some(true),
        BusStationState::DataExchange => Some(false),
        _ => None,
    });
    let faults = gauge.map(|gauge| fault_text(&gauge.exceptions, &gauge.readings)).unwrap_or_default();
    Evaluation::without_value(holds, format!("{name} reports {faults}"))
}

/// Tests a point of a slave; unknown without a good value. While the alarm `is_active`, the reset value counts instead of the limit.
fn point_test(inputs: &Inputs, gauge: &str, name: &str, test: &PointTest, is_active: bool) -> Evaluation {
    let points = inputs.fresh_gauge(gauge).map(|gauge| gauge.parameters.iter());
    let Some(point) = points.into_iter().flatten().find(|it| it.target == name && it.quality == Quality::Valid) else {
        return Evaluation::default();
    };
    let holds = match test {
        PointTest::Above { limit, reset } => point.number.map(|number| number > *if is_active { reset } else { limit }),
        PointTest::Below { limit, reset } => point.number.map(|number| number < *if is_active { reset } else { limit }),
        PointTest::Is(text) => Some(point.text == *text || point.text_without_remark() == text),
    };
    Evaluation { holds, value: point.number, text: format!("{gauge}: {name} is {}", point.text) }
}

fn stale(inputs: &Inputs, name: &str, behind_segment: Option<&str>) -> Evaluation {
    if behind_segment.is_some_and(|segment| segment_down(inputs, segment).holds != Some(false)) {
        return Evaluation::default();
    }
    let Some(gauge) = inputs.gauge(name) else {
        return Evaluation::without_value(Some(true), format!("no segment has a gauge {name}"));
    };
    if is_awaited(inputs, gauge) {
        return Evaluation::default();
    }
    let text = match (&gauge.problem, gauge.age_ms) {
        (Some(problem), _) => format!("{name} gives no data: {problem}"),
        (None, None) => format!("{name} never gave data"),
        (None, Some(age)) => format!("{name} gives no data, the last are {} s old", age / 1000),
    };
    Evaluation::without_value(Some(!is_fresh(gauge.age_ms, gauge.poll_ms)), text)
}

fn segment_down(inputs: &Inputs, name: &str) -> Evaluation {
    let segment = inputs.segment(name);
    if segment.is_some_and(|segment| segment.state == SegmentState::Running) {
        let is_open = inputs.gauges_of(name).count() > 1 && is_silent_and_awaited(inputs, name);
        return if is_open { Evaluation::default() } else { Evaluation::met_if_some(silent_from_start(inputs, name)) };
    }
    let problem = segment.and_then(|segment| segment.problem.as_deref()).unwrap_or("it waits for its line");
    Evaluation::without_value(Some(true), format!("segment {name} does not run: {problem}"))
}

/// The sentence about a segment of which no gauge has given data since the station started: one alarm in place of one for each gauge. One
/// gauge alone has its own alarm.
fn silent_from_start(inputs: &Inputs, segment: &str) -> Option<String> {
    let gauges: Vec<_> = inputs.gauges_of(segment).collect();
    let is_silent = gauges.iter().all(|gauge| gauge.age_ms.is_none() && !gauge.is_awaited);
    let problem = gauges.iter().find_map(|gauge| Some(format!("; {}: {}", gauge.name, gauge.problem.as_ref()?)));
    (is_silent && gauges.len() > 1).then(|| {
        let problem = problem.unwrap_or_default();
        format!(
            "segment {segment} gives no data: none of its {} gauges has answered since the start{problem}",
            gauges.len()
        )
    })
}

/// Whether it is too early to miss a gauge: the station has not found out yet whether it answers or, while its segment has given no data
/// at all, whether the others do.
fn is_awaited(inputs: &Inputs, gauge: &Gauge) -> bool {
    gauge.is_awaited || is_silent_and_awaited(inputs, &gauge.segment)
}

/// Whether a segment has given no data at all, and one of its gauges is awaited.
fn is_silent_and_awaited(inputs: &Inputs, segment: &str) -> bool {
    let of_segment = || inputs.gauges_of(segment);
    of_segment().all(|gauge| gauge.age_ms.is_none()) && of_segment().any(|gauge| gauge.is_awaited)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hours_without_an_archive_count_in_tenths() {
        let silent = |minutes: u64| ArchiveState { silence: Duration::from_secs(60 * minutes), problem: None };
        let told = |minutes| not_archived(Some(&silent(minutes)), 1.0);
        assert_eq!([told(59), told(60), told(61)].map(|it| it.value), [Some(0.9), Some(1.0), Some(1.0)]);
        assert_eq!([told(60), told(61)].map(|it| it.holds), [Some(false), Some(true)], "the limit is not rounded");
    }

    const WINDOW: Duration = Duration::from_secs(30);

    /// The evaluations of a rise in virtual time: `quality` and pressure in Pa of the reading at each step of a quarter of a second.
    struct Rising {
        evaluator: Evaluator,
        condition: Condition,
        steps: i64,
    }

    impl Rising {
        fn new() -> Self {
            let series = Series { gauge: "process".to_owned(), name: "process".to_owned() };
            let condition = Condition::Rise { series, limit: 0.5, reset: 0.25, window: WINDOW };
            Self { evaluator: Evaluator::default(), condition, steps: 0 }
        }

        fn see(&mut self, quality: Quality, pa: f64) -> Evaluation {
            let mut reading = Reading {
                series: "process".to_owned(),
                instance: 1,
                principle: None,
                pa: None,
                limit_pa: None,
                corrected_pa: None,
                quality,
                cause: None,
                is_defect: false,
            };
            match quality {
                Quality::Valid => reading.pa = Some(pa),
                Quality::Overrange | Quality::Underrange => reading.limit_pa = Some(pa),
                _ => {}
            }
            let (name, readings) = ("process".to_owned(), vec![reading]);
            let gauge = Gauge { name, readings, age_ms: Some(0), poll_ms: 250, ..Gauge::default() };
            let inputs = Inputs { gauges: vec![gauge], ..Inputs::default() };
            self.steps += 1;
            self.evaluator.condition(&self.condition, true, &inputs, Micros(self.steps * Micros::SECOND / 4))
        }

        /// A minute with one decade.
        fn rise(&mut self) {
            let all: Vec<_> =
                (0..240).map(|step| self.see(Quality::Valid, 10_f64.powf(f64::from(step) / 240.0))).collect();
            assert_eq!(all.last().unwrap().holds, Some(true));
        }

        /// When the condition was known, in steps from here, with its first state.
        fn first_known(&mut self, readings: impl Iterator<Item = (Quality, f64)>) -> Option<(usize, bool)> {
            let mut all = readings.map(|(quality, pa)| self.see(quality, pa).holds).enumerate();
            all.find_map(|(step, holds)| Some((step, holds?)))
        }
    }

    /// A vented chamber: the gauge is at the end of its range for hours, and changes between its two sides.
    #[test]
    fn a_rise_ends_when_the_pressure_stays_at_the_end_of_the_range() {
        let steps_of_window = 4 * 30;
        let at_end = |step: i32| if step % 7 < 3 { (Quality::Valid, 9.9e4) } else { (Quality::Overrange, 1e5) };
        let mut flickers = Rising::new();
        flickers.rise();
        let first = (0..1).map(|_| (Quality::Overrange, 1e5));
        assert_eq!(flickers.first_known(first.chain((0..240).map(at_end))), Some((steps_of_window + 3, false)));
        let text = flickers.see(Quality::Overrange, 1e5).text;
        assert_eq!(text, "process shows over range (> 1000 mbar), no rise at the end of its range");

        let mut stays = Rising::new();
        stays.rise();
        let beyond = |quality| (0..240).map(move |_| (quality, 1e5));
        assert_eq!(stays.first_known(beyond(Quality::Overrange)), Some((steps_of_window + 1, false)));

        // A new rise is one: the rate is known again after half of the window.
        stays.rise();
    }

    /// A chamber that was vented and is pumped down: the gauge measures again, and the alarm says nothing about an end of its range.
    #[test]
    fn a_reading_within_the_range_is_at_no_end_of_it() {
        let mut rising = Rising::new();
        rising.rise();
        let below = (0..4 * 25).map(|_| (Quality::Underrange, 5e-8));
        let measures = (0..4 * 10).map(|_| (Quality::Valid, 2e-4));
        assert_eq!(rising.first_known(below.chain(measures)), None);
    }

    #[test]
    fn a_rise_of_which_nothing_is_known_neither_ends_nor_begins() {
        for quality in [Quality::Off, Quality::Fault, Quality::Missing, Quality::Assumed] {
            let mut rising = Rising::new();
            rising.rise();
            assert_eq!(rising.first_known((0..480).map(|_| (quality, 1e5))), None, "{quality:?}");
            // Beyond the range for less than the window, between two readings without a pressure.
            let mixed = (0..480).map(|step| (if step % 100 == 0 { quality } else { Quality::Overrange }, 1e5));
            assert_eq!(rising.first_known(mixed), None, "{quality:?}");
        }
    }
}
