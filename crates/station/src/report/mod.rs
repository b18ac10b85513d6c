//! A report about a pump-down: what a vacuum engineer hands to a customer or keeps with the chamber.
//!
//! | Module | Holds |
//! |---|---|
//! | [`series`] | what a record has of a gauge in a span, and the pump-downs in it |
//! | [`figures`] | the numbers |
//! | [`page`] | the page |
//! | `pictures` | which curves it has |
//! | `plot` | how a curve is drawn |
//! | `tables` | its tables |
//! | [`words`] | numbers and times as people read them |

mod charts;
pub mod figures;
pub mod format;
pub mod page;
mod plot;
pub mod series;
mod tables;

pub use figures::{GaugeInfo, Report, ReportRequest, TargetPressure};
pub use format::Unit;

/// From this likeness on a name may have been meant: half of its letters stand where they should. free choice.
const ALIKE: f64 = 0.5;

/// The name that may have been meant, if one is like it.
#[must_use]
pub fn likeliest<'a>(name: &str, names: &'a [String]) -> Option<&'a str> {
    let likeness = |known: &String| strsim::normalized_damerau_levenshtein(&name.to_lowercase(), &known.to_lowercase());
    let best = names.iter().max_by(|one, two| likeness(one).total_cmp(&likeness(two)));
    best.filter(|best| likeness(best) >= ALIKE).map(String::as_str)
}
