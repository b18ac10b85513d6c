//! When a pressure was reached.

use super::trace::{Piece, Trace};
use profivac_recorder::Quality;

/// When a pressure was reached, in seconds since the beginning of the span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Passage {
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
pub fn passage(trace: &Trace, pa: f64) -> Passage {
    let mut known = Known::Nothing;
    for piece in &trace.pieces {
        let reached = match piece.quality {
            Quality::Valid => within(piece, pa, known),
            Quality::Under if end_of_range(piece).is_some_and(|end| end <= pa) => Some(entered(piece.from_s, known)),
            Quality::Over | Quality::Under | Quality::Invalid | Quality::Gap => None,
        };
        if let Some(reached) = reached {
            return reached;
        }
        known = after(piece, pa, known);
    }
    Passage::Not
}

/// Within a piece with a curve.
fn within(piece: &Piece, pa: f64, known: Known) -> Option<Passage> {
    let place = piece.smooth.iter().position(|(_, p)| *p <= pa)?;
    let (t, p) = *piece.smooth.get(place)?;
    let before = place.checked_sub(1).and_then(|before| piece.smooth.get(before));
    Some(before.map_or_else(
        || entered(t, known),
        |(t0, p0)| Passage::Reached { s: t0 + (t - t0) * (p0 / pa).ln() / (p0 / p).ln() },
    ))
}

/// A piece begins below.
fn entered(t: f64, known: Known) -> Passage {
    match known {
        Known::Nothing if t <= 0.0 => Passage::Already,
        Known::Nothing | Known::Unmeasurable => Passage::Before { s: t },
        // The samples of both sides are kept where a quality changes, so the curve was left no longer than that.
        Known::Above(from_s) if t - from_s < 1.0 => Passage::Reached { s: t },
        Known::Above(from_s) => Passage::Between { from_s, to_s: t },
    }
}

fn after(piece: &Piece, pa: f64, known: Known) -> Known {
    match piece.quality {
        Quality::Valid => piece.smooth.last().map_or(known, |(t, _)| Known::Above(*t)),
        Quality::Over if end_of_range(piece).is_some_and(|end| end >= pa) => Known::Above(piece.to_s),
        Quality::Over => Known::Unmeasurable,
        Quality::Under | Quality::Invalid | Quality::Gap => known,
    }
}

fn end_of_range(piece: &Piece) -> Option<f64> {
    piece.points.last().map(|(_, pa)| *pa)
}
