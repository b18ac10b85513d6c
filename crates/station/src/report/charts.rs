//! The charts of a report: pressure over the logarithm of time, pressure over time, effective pumping speed over pressure.

use super::figures::{Gauge, Report, since};
use super::format::{decade, time_of_day};
use super::plot::{Axis, Curve, Plot};
use crate::pumpdown::Trace;
use profivac_recorder::Quality;
use std::ops::RangeInclusive;
use std::time::Duration;

/// The permitted distances between two labels of a time axis, in seconds.
const STEPS: [f64; 24] = [
    1.0,
    2.0,
    5.0,
    10.0,
    20.0,
    30.0,
    60.0,
    120.0,
    300.0,
    600.0,
    1_200.0,
    1_800.0,
    3_600.0,
    7_200.0,
    10_800.0,
    21_600.0,
    43_200.0,
    86_400.0,
    172_800.0,
    432_000.0,
    864_000.0,
    2_592_000.0,
    7_776_000.0,
    31_536_000.0,
];

/// The most labels of a time axis.
const MOST_TICKS: f64 = 8.0;

/// An axis over more decades has no minor grid lines.
const MOST_MINOR: usize = 9;

/// Pressure over the logarithm of time.
pub fn over_log_time(report: &Report) -> Plot {
    let first = if report.seconds > 100.0 { 0 } else { -1 };
    let ends = (f64::from(first), report.seconds.max(2.0).log10());
    let exponents = first..=(ends.1.floor() as i32);
    let ticks = exponents.clone().map(|exponent| log_tick(10_f64.powi(exponent), exponent));
    let x = Axis {
        ends,
        is_log: true,
        ticks: ticks.collect(),
        minor: minor(exponents),
        label: "time since the beginning".to_owned(),
    };
    let least = 10_f64.powi(first);
    let run = |points: &[(f64, f64)]| from(points, least);
    pressures(report, "log", x, "over the logarithm of time", run)
}

/// Pressure over time.
pub fn over_time(report: &Report) -> Plot {
    let seconds = report.seconds.max(1.0);
    let step = STEPS.into_iter().find(|step| seconds / step <= MOST_TICKS).unwrap_or(seconds);
    let count = (seconds / step).floor() as u32;
    let ticks = (0..=count).map(|number| f64::from(number) * step).map(|s| {
        let at = report.span.start.after(Duration::from_secs_f64(s));
        (s, elapsed(s, step), time_of_day(at, report.span.start, &report.zone))
    });
    let zone = super::format::moment(report.span.start, &report.zone);
    let zone = zone.rsplit(' ').next().unwrap_or_default();
    let label = format!("time since the beginning, and time of day ({zone})");
    let x = Axis { ends: (0.0, seconds), is_log: false, ticks: ticks.collect(), minor: Vec::new(), label };
    pressures(report, "lin", x, "over time", <[(f64, f64)]>::to_vec)
}

/// Effective pumping speed over pressure; `None` without a volume or without falls.
pub fn speeds(report: &Report) -> Option<Plot> {
    let volume = report.volume_m3?;
    let one = report.unit.pa();
    let run = |gauge: &Gauge| -> Vec<(f64, f64)> {
        gauge.falls.iter().map(|fall| (fall.pa / one, volume / fall.time_constant_s * 1e3)).collect()
    };
    let curves = report.gauges.iter().enumerate().map(|(style, gauge)| Curve {
        name: gauge.name.clone(),
        style,
        runs: vec![run(gauge)],
        spans: Vec::new(),
    });
    let curves: Vec<Curve> = curves.filter(|curve| curve.runs.iter().any(|run| run.len() > 1)).collect();
    let points = || curves.iter().flat_map(|curve| &curve.runs).flatten();
    let x = decades(points().map(|(x, _)| *x), format!("pressure in {}", report.unit.name()))?;
    let y = decades(points().map(|(_, y)| *y), "effective speed in l/s".to_owned())?;
    // From high to low pressure, in the direction of time.
    let x = Axis { ends: (x.ends.1, x.ends.0), ..x };
    let description =
        format!("Effective pumping speed over pressure, of {}", names(curves.iter().map(|curve| &curve.name)));
    Some(Plot { id: "speed", description, x, y, curves, levels: Vec::new(), marks: Vec::new() })
}

fn pressures(
    report: &Report,
    id: &'static str,
    x: Axis,
    how: &str,
    run: impl Fn(&[(f64, f64)]) -> Vec<(f64, f64)>,
) -> Plot {
    let one = report.unit.pa();
    let curves = report.gauges.iter().enumerate().map(|(style, gauge)| Curve {
        name: gauge.name.clone(),
        style,
        runs: gauge.trace.valid().map(|section| scaled(&run(&section.points), one)).collect(),
        spans: not_valid(&gauge.trace),
    });
    let curves: Vec<Curve> = curves.collect();
    let points = curves.iter().flat_map(|curve| &curve.runs).flatten().map(|(_, y)| *y);
    let y = decades(points, format!("pressure in {}, as indicated", report.unit.name()));
    let y = y.unwrap_or_else(|| axis(-9..=3, String::new()));
    let shown = names(report.gauges.iter().map(|gauge| &gauge.name));
    let description = format!("Pressure {how}, of {shown}; the table of times lists when it crossed each decade");
    let levels = report.targets.iter().filter_map(|target| Some((target.name.clone()?, target.pa / one)));
    let marks = report.events.iter().map(|event| (event.number, since(report, event.moment)));
    Plot { id, description, x, y, curves, levels: levels.collect(), marks: marks.collect() }
}

fn names<'a>(names: impl Iterator<Item = &'a String>) -> String {
    names.cloned().collect::<Vec<_>>().join(", ")
}

fn scaled(points: &[(f64, f64)], one: f64) -> Vec<(f64, f64)> {
    points.iter().map(|(s, pa)| (*s, pa / one)).collect()
}

fn not_valid(trace: &Trace) -> Vec<(f64, f64, Quality)> {
    let other = trace.sections.iter().filter(|section| section.quality != Quality::Valid);
    other.map(|section| (section.from_s, section.to_s, section.quality)).collect()
}

/// The points from `least` on, with an interpolated point at `least`.
fn from(points: &[(f64, f64)], least: f64) -> Vec<(f64, f64)> {
    let index = points.partition_point(|(s, _)| *s < least);
    let after = points.get(index..).unwrap_or_default();
    let before = index.checked_sub(1).and_then(|before| points.get(before)).zip(after.first());
    let begin = before.filter(|(_, next)| next.0 > least).map(|(last, next)| {
        let share = (least - last.0) / (next.0 - last.0);
        (least, last.1 * (next.1 / last.1).powf(share))
    });
    begin.into_iter().chain(after.iter().copied()).collect()
}

/// An axis over whole decades around all values.
fn decades(values: impl Iterator<Item = f64> + Clone, label: String) -> Option<Axis> {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return None;
    }
    // A value beyond a decade by a rounding error does not add another decade.
    let (low, high) = ((low.log10() + 0.02).floor() as i32, (high.log10() - 0.02).ceil() as i32);
    Some(axis(low..=high.max(low + 1), label))
}

fn axis(exponents: RangeInclusive<i32>, label: String) -> Axis {
    let ends = (f64::from(*exponents.start()), f64::from(*exponents.end()));
    let ticks = exponents.clone().map(|exponent| (10_f64.powi(exponent), decade(exponent), String::new()));
    Axis { ends, is_log: true, ticks: ticks.collect(), minor: minor(exponents), label }
}

/// Grid lines at 2 and 5 of every decade, unless there are too many decades.
fn minor(exponents: RangeInclusive<i32>) -> Vec<f64> {
    if exponents.clone().count() > MOST_MINOR {
        return Vec::new();
    }
    exponents.flat_map(|exponent| [2.0, 5.0].map(|digit| digit * 10_f64.powi(exponent))).collect()
}

fn log_tick(s: f64, exponent: i32) -> (f64, String, String) {
    let more = match s {
        ..59.0 => String::new(),
        59.0..3_600.0 => format!("{:.1} min", s / 60.0),
        3_600.0..86_400.0 => format!("{:.1} h", s / 3_600.0),
        _ => format!("{:.1} d", s / 86_400.0),
    };
    (s, format!("{} s", decade(exponent)), more)
}

/// A duration in the largest unit that the distance between two labels has.
fn elapsed(s: f64, step: f64) -> String {
    match step {
        _ if s == 0.0 => "0".to_owned(),
        ..60.0 => format!("{s} s"),
        60.0..3_600.0 => format!("{} min", s / 60.0),
        3_600.0..86_400.0 => format!("{} h", s / 3_600.0),
        _ => format!("{} d", s / 86_400.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_begins_at_the_left_edge_with_an_interpolated_value() {
        let begun = from(&[(0.0, 100.0), (2.0, 1.0), (3.0, 0.5)], 1.0);
        assert_eq!(begun.len(), 3);
        assert!((begun[0].1 - 10.0).abs() < 1e-9, "{begun:?}");
        assert!(from(&[(0.0, 1.0)], 1.0).is_empty());
    }

    #[test]
    fn an_axis_has_whole_decades() {
        let ends = |values: &[f64]| decades(values.iter().copied(), String::new()).map(|axis| axis.ends);
        assert_eq!(ends(&[1013.0, 3e-7]), Some((-7.0, 3.0)));
        assert_eq!(ends(&[2.0]), Some((0.0, 1.0)));
        assert_eq!(ends(&[1.0]), Some((0.0, 1.0)));
        assert_eq!(ends(&[]), None);
    }
}
