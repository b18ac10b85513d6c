//! The database of a station.

use super::Finding;
use profivac_client::cyclic::IntegerRange;
use profivac_client::pressure::Pressure;
use profivac_client::values::format_number;
use profivac_devices::catalog::MODELS;
use profivac_devices::model::Model;
use profivac_recorder::export::iso;
use profivac_recorder::{DatabaseError, LastCheck, Micros, Occurrence, Occurrences, Reader};
use std::path::Path;

/// The most periods that a finding lists.
const MAX_PERIODS: usize = 5;

/// The findings about a database. `model` is the device that records a series, if a station's file names it.
pub fn check(path: &Path, model: impl Fn(&str) -> Option<&'static Model>) -> Vec<Finding> {
    let reader = match Reader::open(path) {
        Ok(reader) => reader,
        Err(error) => {
            return vec![Finding::bad_file(
                error.to_string(),
                "restore it from a backup, or name the database of a station",
            )];
        }
    };
    let mut findings = check_now(&reader, model);
    findings.extend(last_check(&reader));
    findings
}

/// The findings of a check of the whole file now.
fn check_now(reader: &Reader, model: impl Fn(&str) -> Option<&'static Model>) -> Vec<Finding> {
    match reader.damage() {
        Ok(damage) if damage.is_empty() => {
            let mut findings = vec![Finding::good("the database is not damaged"), contents(reader)];
            findings.extend(integer_ends(reader, model).unwrap_or_else(|error| {
                vec![Finding::bad_file(error.to_string(), "stop the station and check the database again")]
            }));
            findings
        }
        Ok(damage) => vec![Finding::bad_file(
            format!("the database is damaged: {}", damage.join("; ")),
            "stop the station and restore the database from a backup (`profivac backup` makes one)",
        )],
        Err(error) => {
            vec![Finding::bad_file(error.to_string(), "stop the station and restore the database from a backup")]
        }
    }
}

/// What the last daily check of the station has found; `None` if that cannot be read, which a damage explains.
fn last_check(reader: &Reader) -> Option<Finding> {
    Some(match reader.last_check().ok()? {
        None => Finding::good("the station has not checked this database yet"),
        Some(LastCheck { at, found }) if found.is_empty() => {
            Finding::good(format!("the last check of the station, at {}, found no damage", at.to_iso(0)))
        }
        Some(LastCheck { at, found }) => Finding::note(
            format!("the last check of the station, at {}, found damage: {}", at.to_iso(0), found.join("; ")),
            "restore the database from a backup; the station checks a database with damage again when it is started",
        ),
    })
}

fn contents(reader: &Reader) -> Finding {
    let Ok(series) = reader.series_names() else { return Finding::good("a database") };
    let points = reader.points().unwrap_or_default();
    let of_points = points.iter().filter_map(|point| reader.point_time_range(point).ok().flatten());
    let of_series = series.iter().filter_map(|series| reader.time_range(series).ok().flatten());
    let last = of_series.chain(of_points).map(|(_, to)| to).max();
    let Some(last) = last else {
        return Finding::note("a database without samples", "start the station: `profivac run`");
    };
    let age = Micros::now().0.saturating_sub(last.0).max(0) / Micros::SECOND;
    let of_points = if points.is_empty() { String::new() } else { format!(" and {} points of slaves", points.len()) };
    Finding::good(format!("a database of {} series{of_points}; the last sample is {age} s old", series.len()))
}

/// The series with valid samples that are the highest integer in a pressure unit. Version 0.1 recorded it as a measured pressure; it
/// stands for every higher one (errata-bpg-bcg-tpg 70, errata-pxg55x-img400 16).
fn integer_ends(
    reader: &Reader,
    model: impl Fn(&str) -> Option<&'static Model>,
) -> Result<Vec<Finding>, DatabaseError> {
    let mut findings = Vec::new();
    for series in reader.series_names()? {
        let models: Vec<_> = model(&series).map_or_else(|| MODELS.to_vec(), |model| vec![model]);
        let ends = ends_pa(&models);
        let found = reader.occurrences(&series, &ends, MAX_PERIODS)?;
        findings.extend(integer_end(&series, &found));
    }
    Ok(findings)
}

/// The highest integers of these models in all pressure units, in Pa.
fn ends_pa(models: &[&'static Model]) -> Vec<f64> {
    let mut ends = Vec::new();
    for model in models {
        for configuration in model.configurations {
            let ranges = model.units.iter().filter_map(|unit| IntegerRange::of(model, configuration, unit));
            ends.extend(ranges.map(|range| range.highest_pa));
        }
    }
    ends.sort_unstable_by(f64::total_cmp);
    ends.dedup();
    ends
}

/// The finding about one series; `None` without such a sample.
fn integer_end(series: &str, found: &Occurrences) -> Option<Finding> {
    let mut places: Vec<_> = found.periods.iter().map(period).collect();
    if found.more > 0 {
        places.push(format!("{} more periods", found.more));
    }
    if let Some((first, last)) = found.spans {
        let (first, last) = (iso(first), iso(last));
        places
            .push(format!("deleted samples, in six hours from {first} and six hours from {last}, and perhaps between"));
    }
    let and_deleted = if found.spans.is_some() { ", without deleted ones" } else { "" };
    let places = Some(places.join("; ")).filter(|places| !places.is_empty())?;
    Some(Finding::note(
        format!(
            "{series}: valid samples that are the highest integer in a pressure unit ({}{and_deleted}): {places}",
            found.samples
        ),
        "read each one as this pressure or a higher one: how high it was is not stored, and no alarm with a limit above it was raised. The database \
         has neither the module nor the unit of a gauge: a gauge with floats that showed exactly this pressure is listed too. Readings of \
         0, below one unit, are stored as faults and are not listed",
    ))
}

/// `327.67 mbar from 2026-01-01T00:00:00.000000Z to ...`.
fn period(Occurrence { pa, first, last }: &Occurrence) -> String {
    let mbar = format_number(Pressure::from_pa(*pa).mbar());
    if first == last {
        format!("{mbar} mbar at {}", iso(*first))
    } else {
        format!("{mbar} mbar from {} to {}", iso(*first), iso(*last))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_in_a_finding_says_that_deleted_samples_are_not_counted() {
        let periods = vec![Occurrence { pa: 32767.0, first: Micros(1), last: Micros(1) }];
        let found = |spans| {
            let found = Occurrences { samples: 1, periods: periods.clone(), more: 0, spans };
            integer_end("chamber", &found).unwrap().found
        };
        assert!(found(None).contains("pressure unit (1): 327.67 mbar at "), "{}", found(None));
        let deleted = found(Some((Micros(0), Micros(0))));
        assert!(deleted.contains("pressure unit (1, without deleted ones): 327.67 mbar at "), "{deleted}");
        assert!(deleted.contains("; deleted samples, in six hours from "), "{deleted}");
    }
}
