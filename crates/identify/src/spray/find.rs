//! The times at which an indication leaves its course and returns.

use super::Spray;
use super::fit::{Window, fit};

/// The samples from which a course is extrapolated, and how many beyond it mean that the indication has left it. chosen
const BEFORE: usize = 20;
const BEYOND: usize = 3;

/// An indication has left its course when it is this many standard deviations and this part beyond it. chosen
const DEVIATIONS: f64 = 5.0;
const LEAST_CHANGE: f64 = 0.02;

/// It has nearly returned below this part of its largest change. chosen
const RETURNED: f64 = 0.3;

/// The longest spray, in s and in groups (longer groups find the longer ones), and the largest change of the logarithm. chosen
const LONGEST_S: f64 = 1800.0;
const LONGEST: usize = 400;
const LARGEST: f64 = 5.0;

/// Samples are averaged in groups of 1, 4, 16 and more, up to this length in s, so that slow changes are seen. chosen
const GROUP: usize = 4;
const LONGEST_GROUP_S: f64 = 60.0;

/// The most fits for one length of groups: those of the latest changes. chosen
const MOST_FITS: usize = 50;

/// Above this the shape does not describe the record; as for a plant. chosen
const MISFIT: f64 = 2.0;

/// A change shorter than this part of its time constant is a burst of gas. chosen
const LEAST_LENGTH: f64 = 0.5;

/// The record after the return, in lengths of the change. chosen
const AFTER: f64 = 2.0;

/// All changes of an indication with the shape of helium at a leak, the earliest first. Samples are seconds and pressures in Pa, in the
/// order of time, with the valve to the pump open.
#[must_use]
pub fn find(samples: &[(f64, f64)]) -> Vec<Spray> {
    let valid = |(t, pa): &&(f64, f64)| t.is_finite() && pa.is_finite() && *pa > 0.0;
    let samples: Vec<(f64, f64)> = samples.iter().filter(valid).copied().collect();
    let Some(spacing_s) = spacing(&samples) else { return Vec::new() };
    let mut found: Vec<Spray> = Vec::new();
    let mut size = 1_usize;
    while size == 1 || size as f64 * spacing_s <= LONGEST_GROUP_S {
        let groups = logarithms(&samples, size);
        if groups.len() < BEFORE + BEYOND {
            break;
        }
        let windows = windows(&groups, size as f64 * spacing_s);
        let latest = windows.len().saturating_sub(MOST_FITS);
        found.extend(windows.iter().skip(latest).filter_map(|window| fit(&samples, window)).filter(is_spray));
        size = size.saturating_mul(GROUP);
    }
    apart(found)
}

/// Whether the change is certain, has the shape, lasts long enough to have one, and has returned.
fn is_spray(spray: &Spray) -> bool {
    let length = spray.to_s.mean - spray.from_s.mean;
    let width = spray.change_pa.high - spray.change_pa.low;
    let is_certain = spray.change_pa.mean.abs() > width * DEVIATIONS / (2.0 * crate::interval::SIGMAS);
    let is_large = spray.change_pa.mean.abs() >= LEAST_CHANGE * spray.base_pa && spray.base_pa > 0.0;
    is_certain && is_large && spray.misfit <= MISFIT && length >= LEAST_LENGTH * spray.tau_s.mean
}

/// Those that do not overlap, in the order of time; of two that do, the one of the shorter groups. The more certain one would be
/// too certain.
fn apart(found: Vec<Spray>) -> Vec<Spray> {
    let mut kept: Vec<Spray> = Vec::new();
    for spray in found {
        let is_apart = |other: &Spray| spray.to_s.mean < other.from_s.mean || other.to_s.mean < spray.from_s.mean;
        if kept.iter().all(is_apart) {
            kept.push(spray);
        }
    }
    kept.sort_by(|one, two| one.from_s.mean.total_cmp(&two.from_s.mean));
    kept
}

/// The median time between two samples.
fn spacing(samples: &[(f64, f64)]) -> Option<f64> {
    let mut times: Vec<f64> = samples.windows(2).filter_map(|two| Some(two.last()?.0 - two.first()?.0)).collect();
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().filter(|spacing| *spacing > 0.0)
}

/// Means of groups: time and logarithm.
fn logarithms(samples: &[(f64, f64)], size: usize) -> Vec<(f64, f64)> {
    let mean = |group: &[(f64, f64)]| {
        let count = group.len() as f64;
        let (t, pa) = group.iter().fold((0.0, 0.0), |(t, pa), one| (t + one.0 / count, pa + one.1 / count));
        (t, pa.ln())
    };
    samples.chunks_exact(size).map(mean).collect()
}

/// Where the indication leaves its course and returns.
fn windows(groups: &[(f64, f64)], step_s: f64) -> Vec<Window> {
    let mut found: Vec<Window> = Vec::new();
    let mut position = BEFORE;
    while position.saturating_add(BEYOND) <= groups.len() {
        let Some((returns, window)) = left(groups, position).and_then(|up| returned(groups, position, up, step_s))
        else {
            position = position.saturating_add(1);
            continue;
        };
        // The window does not reach into the change before it, whose window ends here.
        let begins_s = found
            .last()
            .map_or(window.from_s, |last: &Window| f64::midpoint(last.returns_s, window.leaves_s).max(window.from_s));
        if let Some(last) = found.last_mut() {
            last.to_s = last.to_s.min(window.leaves_s - step_s);
        }
        found.push(Window { from_s: begins_s, ..window });
        position = returns.saturating_add(1);
    }
    found
}

/// Whether the indication leaves its course at a place, and to which side.
fn left(groups: &[(f64, f64)], position: usize) -> Option<f64> {
    let before = groups.get(position.checked_sub(BEFORE)?..position)?;
    let next = groups.get(position..position.checked_add(BEYOND)?)?;
    let count = before.len() as f64;
    let (t, y) = before.iter().fold((0.0, 0.0), |(t, y), one| (t + one.0 / count, y + one.1 / count));
    let squares: f64 = before.iter().map(|one| (one.0 - t).powi(2)).sum();
    let slope = before.iter().map(|one| (one.0 - t) * (one.1 - y)).sum::<f64>() / squares;
    let beyond = |one: &(f64, f64)| one.1 - y - slope * (one.0 - t);
    let deviation = (before.iter().map(|one| beyond(one).powi(2)).sum::<f64>() / (count - 2.0)).sqrt();
    let limit = (DEVIATIONS * deviation).max(LEAST_CHANGE);
    let side = beyond(next.first()?).signum();
    next.iter().all(|one| side * beyond(one) > limit).then_some(side)
}

/// When it returns, and the window around it.
fn returned(groups: &[(f64, f64)], position: usize, side: f64, step_s: f64) -> Option<(usize, Window)> {
    let before = groups.get(position.checked_sub(BEFORE / 2)?..position)?;
    let level = before.iter().map(|one| one.1).sum::<f64>() / before.len() as f64;
    let leaves_s = before.last()?.0;
    let mut peak = 0.0;
    for (index, (t, y)) in groups.iter().enumerate().skip(position).take(LONGEST) {
        let change = side * (y - level);
        peak = f64::max(peak, change);
        if t - leaves_s > LONGEST_S || peak > LARGEST {
            return None;
        }
        if index >= position.saturating_add(BEYOND) && change < RETURNED * peak {
            let length = (t - leaves_s).max(10.0 * step_s);
            let window =
                Window { from_s: leaves_s - length, leaves_s, returns_s: *t, to_s: t + AFTER * length, step_s };
            return Some((index, window));
        }
    }
    None
}
