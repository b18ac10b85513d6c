//! The database of a station.

use super::Finding;
use profivac_recorder::{Micros, Reader};
use std::path::Path;

/// The findings about a database.
pub fn check(path: &Path) -> Vec<Finding> {
    let reader = match Reader::open(path) {
        Ok(reader) => reader,
        Err(error) => {
            return vec![Finding::bad_file(
                error.to_string(),
                "restore it from a backup, or name the database of a station",
            )];
        }
    };
    match reader.damage() {
        Ok(damage) if damage.is_empty() => vec![Finding::good("the database is not damaged"), contents(&reader)],
        Ok(damage) => vec![Finding::bad_file(
            format!("the database is damaged: {}", damage.join("; ")),
            "stop the station and restore the database from a backup (`profivac backup` makes one)",
        )],
        Err(error) => {
            vec![Finding::bad_file(error.to_string(), "stop the station and restore the database from a backup")]
        }
    }
}

fn contents(reader: &Reader) -> Finding {
    let Ok(series) = reader.series_names() else { return Finding::good("a database") };
    let last = series.iter().filter_map(|series| reader.time_range(series).ok().flatten()).map(|(_, to)| to).max();
    let Some(last) = last else {
        return Finding::note("a database without samples", "start the station: `profivac run`");
    };
    let age = Micros::now().0.saturating_sub(last.0).max(0) / Micros::SECOND;
    Finding::good(format!("a database of {} series; the last sample is {age} s old", series.len()))
}
