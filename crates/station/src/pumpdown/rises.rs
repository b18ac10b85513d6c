//! Rises within a pump-down: a valve to the pump that was closed, a leak, a degas.

use super::trace::{Section, Trace};
use crate::rise::{Rise, fit};

/// A rise by so many decades, in so many seconds and samples, is one. free choice: three times the pressure.
const HEIGHT: f64 = 0.477;
const SHORTEST_S: f64 = 20.0;
const SAMPLES: usize = 20;

/// It is over when the pressure is so many decades below the highest.
const OVER: f64 = 0.1;

/// So near to the lowest pressure the rise has not begun, in decades: 5 %.
const BOTTOM: f64 = 0.0223;

/// So much of it must be explained by a steady inflow and one that slows down; anything else is no rise in a closed volume.
const EXPLAINED: f64 = 0.98;

/// A rise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureRise {
    /// From when, in seconds since the beginning.
    pub from_s: f64,
    /// Until when.
    pub to_s: f64,
    /// The pressure before, in Pa.
    pub from_pa: f64,
    /// The highest, in Pa.
    pub to_pa: f64,
    /// What it consists of, if it is explained as a rise in a closed volume.
    pub fit: Option<Rise>,
}

/// The rises there are, the earliest first.
#[must_use]
pub fn pressure_rises(trace: &Trace) -> Vec<PressureRise> {
    trace.valid().flat_map(in_piece).collect()
}

/// Found in what is free of outliers, and fitted to what was measured: a median rounds corners.
fn in_piece(piece: &Section) -> Vec<PressureRise> {
    let points = &piece.smooth;
    let mut found = Vec::new();
    // The lowest pressure, the last place near it, and the highest since.
    let (mut lowest, mut foot, mut high) = (f64::MAX, 0, 0);
    let decades = |place: usize| points.get(place).map_or(f64::MAX, |(_, pa)| pa.log10());
    for place in 0..points.len() {
        let y = decades(place);
        if y >= decades(high) {
            high = place;
        }
        let is_over = y < decades(high) - OVER || place + 1 == points.len();
        if is_over && decades(high) - lowest >= HEIGHT {
            found.extend(climb(&piece.points, foot, high));
            (lowest, foot, high) = (y, place, place);
        } else if y <= lowest + BOTTOM {
            (lowest, foot, high) = (lowest.min(y), place, place);
        }
    }
    found
}

fn climb(points: &[(f64, f64)], low: usize, high: usize) -> Option<PressureRise> {
    let points = points.get(low..=high)?;
    let ((from_s, from_pa), (to_s, to_pa)) = (*points.first()?, *points.last()?);
    if to_s - from_s < SHORTEST_S || points.len() < SAMPLES {
        return None;
    }
    let fit = fit(points).ok().filter(|rise| rise.explained >= EXPLAINED);
    Some(PressureRise { from_s, to_s, from_pa, to_pa, fit })
}
