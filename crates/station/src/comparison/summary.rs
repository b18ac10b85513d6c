//! The figures of a report that need more than its own pump-down: the numbers of the plant, and the usual times.

use super::recorded::{Recorded, excess_of, recorded, usual_before};
use super::words::{likeness, sentence};
use crate::identification::identified;
use crate::identification::record::{Known, KnownVolume};
use crate::identification::view::Asked;
use crate::pumpdown::TimeRange;
use crate::pumpdown::compare::{Comparison, Run, compare};
use crate::report::figures::{UsualTime, UsualTimes};
use crate::report::{Report, series::series};
use profivac_identify::rise::GasDependence;
use profivac_identify::standard_uncertainty;
use profivac_recorder::{DatabaseError, Reader};
use std::time::Duration;

/// Earlier pump-downs are searched in this time. chosen
const PAST: Duration = Duration::from_secs(90 * 86_400);

/// What a report says about its plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlantPart {
    /// Nothing: a fit takes seconds, and minutes where a record does not follow the law.
    Without,
    /// Its numbers, with the accuracy of the gauge as a fraction.
    Identified(Option<f64>),
}

/// Adds the plant of the leading gauge, if it is wanted and the report has a volume, and the times beside the usual ones. `stopped`
/// is called often, and ends the fit when it is true.
///
/// # Errors
/// [`DatabaseError`] when the database cannot be read.
pub fn complete(
    reader: &Reader,
    report: &mut Report,
    plant: PlantPart,
    stopped: &dyn Fn() -> bool,
) -> Result<(), DatabaseError> {
    let Some(name) = report.lead().map(|lead| lead.name.clone()) else { return Ok(()) };
    if let (Some(m3), PlantPart::Identified(accuracy)) = (report.volume_m3, plant) {
        let samples = series(reader, &name, report.span)?.samples;
        let gauge_uncertainty = accuracy.map_or(0.0, standard_uncertainty);
        let volume = KnownVolume::Given(m3);
        let known = Known { span: report.span, closed: None, opened: None, volume, gauge_uncertainty };
        let asked = Asked { gauge: GasDependence::None, accuracy, target_pa: None, is_volume_given: true };
        match identified(name.clone(), &samples, &known, &asked, stopped) {
            Ok(plant) => report.plant = Some(plant),
            Err(error) => report.plant_note = Some(error.to_string()),
        }
    }
    report.usual = usual(reader, &name, report)?;
    Ok(())
}

/// The times of the report's pump-down beside the usual ones; `None` if the series has none in its time range.
fn usual(reader: &Reader, name: &str, report: &Report) -> Result<Option<UsualTimes>, DatabaseError> {
    let TimeRange { start, end } = report.span;
    let all = recorded(reader, name, TimeRange { start: start.before(PAST), end })?;
    let minute = Duration::from_secs(60);
    let Some(index) = all.iter().position(|one| one.run.start >= start.before(minute)) else { return Ok(None) };
    let runs: Vec<Run> = all.iter().take(index.saturating_add(1)).map(|one| one.run.clone()).collect();
    let compared = compare(&runs);
    let found = compared.last().zip(all.get(index));
    Ok(found.map(|(comparison, own)| times(name, comparison, own, &usual_before(&all, &compared, index), report)))
}

fn times(name: &str, comparison: &Comparison, own: &Recorded, usual: &[&Recorded], report: &Report) -> UsualTimes {
    let levels = comparison.levels.iter().map(|level| UsualTime {
        pa: level.pa,
        s: level.s,
        usual_s: level.usual.map(|usual| usual.s),
        limits_s: level.usual.map(|usual| [usual.least_s, usual.most_s]),
        deviation: level.deviation,
    });
    let levels: Vec<UsualTime> = levels.collect();
    let deviation = sentence(comparison, &report.zone);
    let text = match deviation {
        Some(text) => text,
        None if levels.iter().any(|level| level.usual_s.is_some()) => "as usual".to_owned(),
        None => "too few pump-downs before it to compare with: five from a similar pressure are needed".to_owned(),
    };
    UsualTimes {
        gauge: name.to_owned(),
        text,
        likeness: likeness(comparison, excess_of(comparison, own, usual)),
        sprays: own.sprays().into_iter().map(|spray| spray.text).collect(),
        levels,
    }
}
