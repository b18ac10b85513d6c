//! The time at which a pressure was reached.

use super::trace::{Section, Trace};
use profivac_recorder::Quality;

/// The time at which a pressure was reached, in seconds since the beginning of the time range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crossing {
    /// Reached, interpolated between two samples over the logarithm of pressure.
    Reached {
        /// The time.
        s: f64,
    },
    /// Reached at some time in a gap of valid samples.
    Between {
        /// The last valid sample above the pressure.
        from_s: f64,
        /// The first valid sample below the pressure.
        to_s: f64,
    },
    /// Reached at this time or before: the gauge could not measure so high a pressure before, or has no samples.
    Before {
        /// The first valid sample below the pressure.
        s: f64,
    },
    /// Below from the beginning.
    Already,
    /// The pressure was below the range of the gauge, which does not show whether it was reached.
    Unknown {
        /// When the pressure was below the range for the first time.
        since_s: f64,
        /// The end of the range, in Pa.
        end_pa: f64,
    },
    /// Not reached: no reading was at or below it, and none was below the range.
    Not,
}

/// The knowledge before a section.
#[derive(Clone, Copy)]
enum Known {
    Nothing,
    Above(Above),
    /// The pressure is above the range of the gauge, whose end is below the requested pressure.
    Unmeasurable,
}

/// A pressure above the requested one.
#[derive(Clone, Copy)]
struct Above {
    /// Its last sample, in seconds.
    sample_s: f64,
    /// Until when it held: a reading above the range lasts until the next section begins.
    held_s: f64,
    /// The pressure in Pa; above the range its end.
    pa: f64,
}

/// Readings on both sides of a change of quality that are farther apart do not show when a pressure between them was crossed. chosen: a decade,
/// which no pump-down takes within the interval of a gauge.
const FARTHEST: f64 = 10.0;

/// The first time at which `trace` reached the pressure `pa`, in Pa.
#[must_use]
pub fn crossing(trace: &Trace, pa: f64) -> Crossing {
    let mut known = Known::Nothing;
    for section in &trace.sections {
        let reached = match section.quality {
            Quality::Valid => within(section, pa, known),
            Quality::Underrange => {
                let end = end_of_range(section).filter(|end| *end <= pa);
                end.map(|end| entered((section.from_s, end), known))
            }
            Quality::Overrange
            | Quality::Fault
            | Quality::Stale
            | Quality::Off
            | Quality::Missing
            | Quality::Assumed => None,
        };
        if let Some(reached) = reached {
            return reached;
        }
        known = after(section, pa, known);
    }
    below_range(trace).unwrap_or(Crossing::Not)
}

/// The first time below the range: the pressure may have been reached in it.
fn below_range(trace: &Trace) -> Option<Crossing> {
    let below = trace.sections.iter().find(|section| section.quality == Quality::Underrange)?;
    Some(Crossing::Unknown { since_s: below.from_s, end_pa: end_of_range(below)? })
}

/// The crossing in a section of valid samples.
fn within(section: &Section, pa: f64, known: Known) -> Option<Crossing> {
    let index = section.smooth.iter().position(|(_, p)| *p <= pa)?;
    let (t, p) = *section.smooth.get(index)?;
    let before = index.checked_sub(1).and_then(|before| section.smooth.get(before));
    Some(before.map_or_else(
        || entered((t, p), known),
        |(t0, p0)| Crossing::Reached { s: t0 + (t - t0) * (p0 / pa).ln() / (p0 / p).ln() },
    ))
}

/// The crossing at the beginning of a section that begins at `t` with `pa`, which is below the pressure.
fn entered((t, pa): (f64, f64), known: Known) -> Crossing {
    match known {
        Known::Nothing if t <= 0.0 => Crossing::Already,
        Known::Nothing | Known::Unmeasurable => Crossing::Before { s: t },
        // The recorder keeps the samples on both sides of a change of quality, so this gap is no longer than one interval.
        Known::Above(above) if t - above.held_s < 1.0 && above.pa < FARTHEST * pa => Crossing::Reached { s: t },
        Known::Above(Above { sample_s, held_s, .. }) => {
            Crossing::Between { from_s: if held_s < t { held_s } else { sample_s }, to_s: t }
        }
    }
}

fn after(section: &Section, pa: f64, known: Known) -> Known {
    match section.quality {
        Quality::Valid => {
            let above = |(s, pa): &(f64, f64)| Known::Above(Above { sample_s: *s, held_s: *s, pa: *pa });
            section.smooth.last().map_or(known, above)
        }
        Quality::Overrange => match section.points.last() {
            Some((s, end)) if *end >= pa => Known::Above(Above { sample_s: *s, held_s: section.to_s, pa: *end }),
            _ => Known::Unmeasurable,
        },
        Quality::Underrange | Quality::Fault | Quality::Stale | Quality::Off | Quality::Missing | Quality::Assumed => {
            known
        }
    }
}

fn end_of_range(section: &Section) -> Option<f64> {
    section.points.last().map(|(_, pa)| *pa)
}
