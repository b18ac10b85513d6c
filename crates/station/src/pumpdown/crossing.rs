//! When a pressure was reached.

use super::trace::{Section, Trace};
use profivac_recorder::Quality;

/// When a pressure was reached, in seconds since the beginning of the span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crossing {
    /// Then, between two samples in a straight line over the logarithm of pressure.
    Reached {
        /// When.
        s: f64,
    },
    /// Somewhere in a time in which nothing valid was recorded.
    Between {
        /// Last seen above.
        from_s: f64,
        /// First seen below.
        to_s: f64,
    },
    /// Not later than this: the gauge was not able to measure so high a pressure before, or had nothing.
    Before {
        /// First seen below.
        s: f64,
    },
    /// It was below from the beginning.
    Already,
    /// Not at all.
    Not,
}

/// What was known last.
#[derive(Clone, Copy)]
enum Known {
    Nothing,
    Above(f64),
    /// At least the end of the range, which is lower than what is asked for.
    Unmeasurable,
}

/// When `trace` reached `pa` for the first time.
#[must_use]
pub fn crossing(trace: &Trace, pa: f64) -> Crossing {
    let mut known = Known::Nothing;
    for piece in &trace.pieces {
        let reached = match piece.quality {
            Quality::Valid => within(piece, pa, known),
            Quality::Underrange if end_of_range(piece).is_some_and(|end| end <= pa) => {
                Some(entered(piece.from_s, known))
            }
            Quality::Overrange | Quality::Underrange | Quality::Invalid | Quality::Gap => None,
        };
        if let Some(reached) = reached {
            return reached;
        }
        known = after(piece, pa, known);
    }
    Crossing::Not
}

/// Within a piece with a curve.
fn within(piece: &Section, pa: f64, known: Known) -> Option<Crossing> {
    let place = piece.smooth.iter().position(|(_, p)| *p <= pa)?;
    let (t, p) = *piece.smooth.get(place)?;
    let before = place.checked_sub(1).and_then(|before| piece.smooth.get(before));
    Some(before.map_or_else(
        || entered(t, known),
        |(t0, p0)| Crossing::Reached { s: t0 + (t - t0) * (p0 / pa).ln() / (p0 / p).ln() },
    ))
}

/// A piece begins below.
fn entered(t: f64, known: Known) -> Crossing {
    match known {
        Known::Nothing if t <= 0.0 => Crossing::Already,
        Known::Nothing | Known::Unmeasurable => Crossing::Before { s: t },
        // The samples of both sides are kept where a quality changes, so the curve was left no longer than that.
        Known::Above(from_s) if t - from_s < 1.0 => Crossing::Reached { s: t },
        Known::Above(from_s) => Crossing::Between { from_s, to_s: t },
    }
}

fn after(piece: &Section, pa: f64, known: Known) -> Known {
    match piece.quality {
        Quality::Valid => piece.smooth.last().map_or(known, |(t, _)| Known::Above(*t)),
        Quality::Overrange if end_of_range(piece).is_some_and(|end| end >= pa) => Known::Above(piece.to_s),
        Quality::Overrange => Known::Unmeasurable,
        Quality::Underrange | Quality::Invalid | Quality::Gap => known,
    }
}

fn end_of_range(piece: &Section) -> Option<f64> {
    piece.points.last().map(|(_, pa)| *pa)
}
