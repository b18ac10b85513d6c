//! Rises of the pressure within a pump-down: a closed valve, a leak, a degas.

use super::trace::{Section, Trace};
use profivac_identify::Interval;
use profivac_identify::rise::{Cause, GasDependence, RiseSetup, analyse};
use profivac_vacuum::gas::Gas;

/// The smallest rise, in decades, seconds and samples. chosen: a factor of three.
const HEIGHT: f64 = 0.477;
const SHORTEST_S: f64 = 20.0;
const SAMPLES: usize = 20;

/// A rise ends when the pressure is this far below its highest value, in decades.
const OVER: f64 = 0.1;

/// A rise has not begun while the pressure is this near to its lowest value, in decades (5 %).
const BOTTOM: f64 = 0.0223;

/// The largest misfit of a rise in a closed volume, in standard deviations of the noise. chosen
const MISFIT: f64 = 3.0;

/// The parts of a rise in a closed volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RiseParts {
    /// The cause.
    pub cause: Cause,
    /// The leak, in Pa/s.
    pub leak_pa_per_s: Interval,
    /// The outgassing at the beginning, in Pa/s.
    pub outgassing_pa_per_s: Interval,
    /// Both at the beginning divided by the pressure before it, in 1/s: with the valve open the pump has taken this part of the gas each
    /// second, so times the volume it is the effective speed. Not stated if the rise is not certain.
    pub pumped_per_s: Option<f64>,
}

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
    /// The time of pumping before it in s, if the beginning of its pump-down is recorded.
    pub pumped_s: Option<f64>,
    /// Its parts, if it is explained as a rise in a closed volume.
    pub fit: Option<RiseParts>,
}

/// All rises, the earliest first. `begun` are the beginnings of pump-downs, in seconds since the beginning of the time range.
#[must_use]
pub fn pressure_rises(trace: &Trace, begun: &[f64]) -> Vec<PressureRise> {
    trace.valid().flat_map(|section| in_section(section, begun)).collect()
}

/// The search uses the median, which removes outliers; the fit uses the samples, because a median rounds corners.
fn in_section(section: &Section, begun: &[f64]) -> Vec<PressureRise> {
    let points = &section.smooth;
    let mut found = Vec::new();
    // The lowest pressure, the last index near it, and the index of the highest pressure since.
    let (mut lowest, mut foot, mut high) = (f64::MAX, 0, 0);
    let decades = |index: usize| points.get(index).map_or(f64::MAX, |(_, pa)| pa.log10());
    for index in 0..points.len() {
        let y = decades(index);
        if y >= decades(high) {
            high = index;
        }
        let is_over = y < decades(high) - OVER || index + 1 == points.len();
        if is_over && decades(high) - lowest >= HEIGHT {
            found.extend(rise(section, foot, high, begun));
            (lowest, foot, high) = (y, index, index);
        } else if y <= lowest + BOTTOM {
            (lowest, foot, high) = (lowest.min(y), index, index);
        }
    }
    found
}

fn rise(section: &Section, low: usize, high: usize, begun: &[f64]) -> Option<PressureRise> {
    let points = section.points.get(low..=high)?;
    let (_, before_pa) = *section.smooth.get(low)?;
    let ((from_s, from_pa), (to_s, to_pa)) = (*points.first()?, *points.last()?);
    if to_s - from_s < SHORTEST_S || points.len() < SAMPLES {
        return None;
    }
    let pumped_s = begun.iter().copied().filter(|begun| *begun < from_s).reduce(f64::max).map(|begun| from_s - begun);
    Some(PressureRise { from_s, to_s, from_pa, to_pa, pumped_s, fit: parts(points, before_pa, pumped_s) })
}

/// The parts of a rise after a pressure in Pa, as indicated.
fn parts(points: &[(f64, f64)], before_pa: f64, pumped_s: Option<f64>) -> Option<RiseParts> {
    let (from_s, _) = *points.first()?;
    let samples: Vec<_> = points.iter().map(|(s, pa)| (s - from_s, *pa)).collect();
    // With 1 m³ a flow in Pa m³/s has the number of the rate in Pa/s.
    let setup = RiseSetup {
        volume_m3: 1.0,
        pumped_s,
        gauge: GasDependence::None,
        outgassed: Gas::H2o,
        gauge_uncertainty: 0.0,
        gas_k: profivac_vacuum::atmosphere::ROOM_K,
    };
    let rise = analyse(&samples, &setup).ok().filter(|rise| rise.misfit <= MISFIT)?;
    let [leak_pa_per_s, outgassing_pa_per_s, total] =
        [rise.leak, rise.outgassing, rise.total].map(|flow| flow.pa_m3_per_s);
    let pumped_per_s = (rise.cause != Cause::NoRise).then_some(total.mean / before_pa);
    Some(RiseParts { cause: rise.cause, leak_pa_per_s, outgassing_pa_per_s, pumped_per_s })
}
