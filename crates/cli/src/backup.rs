//! `profivac backup`: copies the database of a station.

use crate::database::Database;
use crate::failure::Failure;
use crate::output::{Progress, json, notice, out};
use clap::Args;
use profivac_recorder::backup::{BackupError, Existing};
use profivac_recorder::export::iso;
use profivac_recorder::{Micros, Point, Reader};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Copy the database of a station, also while it runs: samples, spans, events, alarms and the audit trail
///
/// The copy is one state of the database: everything that was written before it began, nothing later. It is checked, and gets its name
/// when it is complete, so a failed or interrupted copy leaves an existing file unchanged. To go back to a copy, stop the station and put the copy
/// where the station's file says `database`; remove the files of the old database with the endings -wal and -shm. The station's file and
/// its users are separate files: copy them as well.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A station's file, or its database
    #[arg(value_name = "STATION.toml|DATABASE.db")]
    source: PathBuf,
    /// The copy
    #[arg(long, value_name = "FILE")]
    to: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
    /// Print what was copied as JSON
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac backup plant.toml --to /backup/plant-monday.db
  profivac backup plant.toml --to /backup/plant.db --force
  profivac report /backup/plant-monday.db";

/// The result: the files, and what the copy holds.
#[derive(Serialize)]
struct Copied<'p> {
    database: &'p Path,
    copy: &'p Path,
    octets: u64,
    /// The number of series: one for each gauge, or for each channel of a controller.
    series: usize,
    /// The number of points of slaves.
    points: usize,
    /// The first and the last recorded time (RFC 3339), if anything was recorded.
    first: Option<String>,
    last: Option<String>,
}

/// Copies the database and says what the copy holds.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let database = Database::open(&arguments.source)?;
    let existing = if arguments.force { Existing::Replace } else { Existing::Keep };
    let mut progress = Progress::of("KiB");
    let kib = |octets: u64| usize::try_from(octets >> 10).unwrap_or(usize::MAX);
    database.reader.backup(&arguments.to, existing, |done, all| progress.update(kib(done), kib(all)))?;
    drop(progress);
    // The copy is opened as a station or a report would open it.
    let copy = Database::open_database(&arguments.to)?;
    let names = copy.series(&[])?;
    let points = copy.reader.points()?;
    let range = time_range(&copy.reader, &names, &points)?;
    let copied = Copied {
        database: &database.path,
        copy: &arguments.to,
        octets: std::fs::metadata(&arguments.to)?.len(),
        series: names.len(),
        points: points.len(),
        first: range.map(|(first, _)| iso(first)),
        last: range.map(|(_, last)| iso(last)),
    };
    if arguments.json {
        out(&json(&copied));
    } else {
        notice(&sentence(&copied));
    }
    Ok(())
}

/// The first and the last time of all series and points.
fn time_range(reader: &Reader, names: &[String], points: &[Point]) -> Result<Option<(Micros, Micros)>, Failure> {
    let of_series = names.iter().map(|name| reader.time_range(name));
    let of_points = points.iter().map(|point| reader.point_time_range(point));
    let ranges = of_series.chain(of_points).collect::<Result<Vec<_>, _>>()?;
    let all = ranges.into_iter().flatten();
    Ok(all.reduce(|one, two| (one.0.min(two.0), one.1.max(two.1))))
}

fn sentence(copied: &Copied<'_>) -> String {
    let range = match (&copied.first, &copied.last) {
        (Some(first), Some(last)) if copied.points == 0 => format!("{} series from {first} to {last}", copied.series),
        (Some(first), Some(last)) => {
            format!("{} series and {} points of slaves from {first} to {last}", copied.series, copied.points)
        }
        _ => "no samples yet".to_owned(),
    };
    let [from, to] = [copied.database, copied.copy].map(Path::display);
    format!("{from} is copied to {to}: {range}, {:.1} MB", copied.octets as f64 / 1e6)
}

impl From<BackupError> for Failure {
    fn from(error: BackupError) -> Self {
        let hint = if matches!(error, BackupError::Exists(_)) { "; add --force to replace it" } else { "" };
        Self::usage(format!("{error}{hint}"))
    }
}
