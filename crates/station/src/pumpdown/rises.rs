//! Rises of the pressure within a pump-down: a closed valve, a leak, a degas.

use super::trace::{Section, Trace};
use crate::rise::{Rise, fit};

/// The smallest rise, in decades, seconds and samples. free choice: a factor of three.
const HEIGHT: f64 = 0.477;
const SHORTEST_S: f64 = 20.0;
const SAMPLES: usize = 20;

/// A rise ends when the pressure is this far below its highest value, in decades.
const OVER: f64 = 0.1;

/// A rise has not begun while the pressure is this near to its lowest value, in decades (5 %).
const BOTTOM: f64 = 0.0223;

/// The smallest explained share of a fit by a steady inflow and one that slows down. Other rises are not those of a closed volume.
const EXPLAINED: f64 = 0.98;

/// A rise of the pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureRise {
    /// Its beginning, in seconds since the beginning of the time range.
    pub from_s: f64,
    /// Its end, in seconds since the beginning of the time range.
    pub to_s: f64,
    /// The pressure before, in Pa.
    pub from_pa: f64,
    /// The highest pressure, in Pa.
    pub to_pa: f64,
    /// Its parts, if it is explained as a rise in a closed volume.
    pub fit: Option<Rise>,
}

/// All rises, the earliest first.
#[must_use]
pub fn pressure_rises(trace: &Trace) -> Vec<PressureRise> {
    trace.valid().flat_map(in_section).collect()
}

/// The search uses the median, which removes outliers; the fit uses the samples, because a median rounds corners.
fn in_section(section: &Section) -> Vec<PressureRise> {
    let points = &section.smooth;
    let mut found = Vec::new();
    // The lowest pressure, the last index near it, and the index of the highest pressure since.
    let (mut lowest, mut foot, mut high) = (f64::MAX, 0, 0);
    let decades = |place: usize| points.get(place).map_or(f64::MAX, |(_, pa)| pa.log10());
    for place in 0..points.len() {
        let y = decades(place);
        if y >= decades(high) {
            high = place;
        }
        let is_over = y < decades(high) - OVER || place + 1 == points.len();
        if is_over && decades(high) - lowest >= HEIGHT {
            found.extend(rise(&section.points, foot, high));
            (lowest, foot, high) = (y, place, place);
        } else if y <= lowest + BOTTOM {
            (lowest, foot, high) = (lowest.min(y), place, place);
        }
    }
    found
}

fn rise(points: &[(f64, f64)], low: usize, high: usize) -> Option<PressureRise> {
    let points = points.get(low..=high)?;
    let ((from_s, from_pa), (to_s, to_pa)) = (*points.first()?, *points.last()?);
    if to_s - from_s < SHORTEST_S || points.len() < SAMPLES {
        return None;
    }
    let fit = fit(points).ok().filter(|rise| rise.explained >= EXPLAINED);
    Some(PressureRise { from_s, to_s, from_pa, to_pa, fit })
}
