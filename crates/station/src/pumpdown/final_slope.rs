//! The slope at the end: the exponent n of `p ~ t^-n` in the last decade of time.
//!
//! Outgassing of surfaces falls with `t^-n`: n is about 1 for water on metals, and about 0.5 for diffusion out of polymers.
//! field: outgassing rates are tabulated with this exponent.

use super::trace::Trace;

/// The number of points, evenly spaced over the logarithm of time, so that the sampling rate does not weight them.
const POINTS: usize = 40;

/// The fewest points with a valid pressure.
const LEAST: usize = 12;

/// The shortest pump-down with a slope, in seconds. chosen: gauges settle within seconds.
const SHORTEST_S: f64 = 100.0;

/// A slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinalSlope {
    /// The exponent n.
    pub exponent: f64,
    /// The standard error of n.
    pub error: f64,
    /// The beginning of the fitted time, in seconds since the beginning.
    pub from_s: f64,
    /// The end of the fitted time, in seconds since the beginning.
    pub to_s: f64,
    /// The time at which the pressure will have fallen to a tenth, if the slope stays the same, in seconds since the beginning.
    pub tenth_s: f64,
}

/// The slope of the last decade of time; `None` if the gauge measured in too little of it.
#[must_use]
pub fn final_slope(trace: &Trace) -> Option<FinalSlope> {
    let to_s = trace.valid().last()?.to_s;
    if to_s < SHORTEST_S {
        return None;
    }
    let from_s = to_s / 10.0;
    let at = |step: usize| from_s * 10_f64.powf(step as f64 / (POINTS - 1) as f64);
    let points: Vec<(f64, f64)> =
        (0..POINTS).filter_map(|step| Some((at(step).log10(), pressure(trace, at(step))?.log10()))).collect();
    let (slope, error) = line(&points)?;
    let exponent = -slope;
    Some(FinalSlope {
        exponent,
        error,
        from_s,
        to_s,
        tenth_s: to_s * 10_f64.powf(1.0 / exponent.max(f64::MIN_POSITIVE)),
    })
}

/// The pressure in Pa at a time in s since the beginning, interpolated over its logarithm; `None` in a gap.
#[must_use]
pub fn pressure(trace: &Trace, t: f64) -> Option<f64> {
    // The end of the last decade is the last sample, except for rounding errors.
    let section = trace.valid().find(|section| section.from_s <= t && t <= section.to_s * (1.0 + 1e-12))?;
    let next = section.smooth.partition_point(|(at, _)| *at < t);
    let (t1, p1) = *section.smooth.get(next).or(section.smooth.last())?;
    let (t0, p0) = *section.smooth.get(next.saturating_sub(1))?;
    let share = if t1 > t0 { ((t - t0) / (t1 - t0)).min(1.0) } else { 1.0 };
    Some(p0 * (p1 / p0).powf(share))
}

/// The slope of a fitted straight line, and its standard error.
fn line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    if points.len() < LEAST {
        return None;
    }
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let squares: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
    let products: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    let slope = products / squares;
    let missed: f64 = points.iter().map(|point| (point.1 - y - slope * (point.0 - x)).powi(2)).sum();
    (squares > 0.0).then(|| (slope, (missed / (count - 2.0) / squares).sqrt()))
}
