//! Answers to names that the station does not have: the problem lists the names that exist.

use crate::services::Services;
use crate::snapshot::UnknownGauge;
use profivac_client::suggestion::known;
use profivac_recorder::Reader;
use profivac_web_server::problem::Problem;
use std::collections::HashSet;

/// The problem for a gauge that the station does not have.
pub fn not_found(unknown: UnknownGauge) -> Problem {
    Problem::not_found(unknown.to_string())
}

/// The problem for a segment that the station does not have, or that has not observed its line yet.
pub fn no_bus(services: &Services, name: &str) -> Problem {
    let segments: Vec<String> = services.snapshots().segments().into_iter().map(|segment| segment.name).collect();
    Problem::not_found(if segments.iter().any(|segment| segment == name) {
        format!("the segment {name:?} has not observed its line yet; try again when it is running")
    } else {
        format!("there is no segment {name:?}; {}", known("segments", name, &segments))
    })
}

/// The series of the database, and then the gauges that have none there yet.
pub fn all_series(services: &Services, reader: &Reader) -> Result<Vec<String>, Problem> {
    let mut all = reader.series_names()?;
    let gauges = services.snapshots().gauges().into_iter().map(|gauge| gauge.name);
    let recorded: HashSet<String> = all.iter().cloned().collect();
    all.extend(gauges.filter(|name| !recorded.contains(name)));
    Ok(all)
}

/// Fails unless a gauge has this series, or the database has samples of it: `gauge.N` is channel N of a controller.
///
/// # Errors
/// A problem with the series that exist.
pub fn check_series(services: &Services, reader: &Reader, name: &str) -> Result<(), Problem> {
    let channel = name.rsplit_once('.').filter(|(_, channel)| channel.parse::<u8>().is_ok());
    let is_gauge = |name: &str| services.snapshots().gauge(name).is_some();
    if is_gauge(name) || channel.is_some_and(|(gauge, _)| is_gauge(gauge)) {
        return Ok(());
    }
    let mut all = all_series(services, reader)?;
    if all.iter().any(|series| series == name) {
        return Ok(());
    }
    all.sort_unstable();
    Err(Problem::not_found(format!("there is no series {name:?}; {}", known("series", name, &all))))
}
