//! A plant from its record: how a record is cut into phases, what the numbers mean in words, and what the API shows.
//!
//! The fit itself is `profivac_identify::plant`. The command `profivac identify` and the dashboard share this module.
//!
//! | Module | Holds |
//! |---|---|
//! | [`record`] | the record of a fit, from samples and what the user knows |
//! | [`words`] | how certain a number is, and remedies, as sentences |
//! | [`sprays`] | helium at a leak, in words |
//! | [`view`] | what the API shows |

pub mod record;
pub mod sprays;
pub mod view;
pub mod words;

use profivac_identify::plant::{NotIdentified, identify_unless};
use profivac_recorder::Sample;
use record::{Known, chosen};
use view::{Asked, PlantView};

/// Identifies the plant of a series. `stopped` is called often, and ends the search when it is true.
///
/// # Errors
/// [`NotIdentified`] when the record is incomplete, or the search was stopped.
pub fn identified(
    series: String,
    samples: &[Sample],
    known: &Known,
    asked: &Asked,
    stopped: &dyn Fn() -> bool,
) -> Result<PlantView, NotIdentified> {
    let chosen = chosen(samples, known);
    let plant = identify_unless(&chosen.record, stopped)?;
    Ok(PlantView::new(series, known.span.start, &chosen, &plant, asked))
}
