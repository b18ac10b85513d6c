//! `profivac export`: writes recorded samples as a table.

use crate::database::{Database, time};
use crate::failure::Failure;
use crate::output::{check, notice, out};
use crate::time_argument::checked;
use crate::whole_file::{self, check_absent, not_written};
use clap::Args;
use jiff::Zoned;
use profivac_recorder::{Chunks, Export, Exported, Micros};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Write recorded samples as a table: time (UTC), gauge, pressure in Pa, quality
///
/// With --points or --point the table has the points of slaves: time (UTC), slave, point, unit, value, quality, and the text that
/// STATION.toml has for a code. Without --out the rows are CSV on standard output. The station may continue to record. If a row has no
/// value, its quality says why.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A station's file, or its database
    #[arg(value_name = "STATION.toml|DATABASE.db")]
    source: PathBuf,
    /// A gauge; may be repeated; the name of a controller selects all its channels. Default: all gauges
    #[arg(long, value_name = "NAME")]
    gauge: Vec<String>,
    /// A point of a slave as SLAVE.POINT; may be repeated; the name of a slave selects all its points
    #[arg(long, value_name = "NAME", conflicts_with = "gauge")]
    point: Vec<String>,
    /// All points of all slaves
    #[arg(long, conflicts_with_all = ["gauge", "point"])]
    points: bool,
    /// The beginning: '2026-11-21 14:00', 14:00, yesterday, -2h, -7d, or RFC 3339. Default: the first sample
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = checked)]
    from: Option<String>,
    /// The end, in the same form. Default: the last sample
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = checked)]
    to: Option<String>,
    /// Write to this file, or - for standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write Parquet, which pandas, Polars and DuckDB read with its types; needs --out FILE
    #[arg(long, requires = "out")]
    parquet: bool,
    /// Overwrite an existing file
    #[arg(long, requires = "out")]
    force: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac export plant.toml > all.csv
  profivac export plant.toml --gauge chamber --from yesterday --to today --out chamber.csv
  profivac export plant.toml --point turbo.speed --from -2h
  profivac export plant.toml --from -7d --parquet --out week.parquet";

/// Writes the selected samples.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let now = Zoned::now();
    let from = time(arguments.from.as_deref(), &now)?.unwrap_or(Micros(i64::MIN));
    let to = time(arguments.to.as_deref(), &now)?.unwrap_or(Micros(i64::MAX));
    if from >= to {
        return Err(Failure::usage("expected a beginning before the end; see --from and --to"));
    }
    let database = Database::open(&arguments.source)?;
    let range = (from, to);
    if arguments.points || !arguments.point.is_empty() {
        let points = database.points(&arguments.point)?;
        return exported(arguments, database, points, range);
    }
    if let Some(name) = database.point_as_gauge(&arguments.gauge)? {
        return Err(Failure::usage(format!("{name:?} has values with units and no pressures: use --point {name:?}")));
    }
    let series = database.series(&arguments.gauge)?;
    if arguments.gauge.is_empty() {
        tell_points(&database)?;
    }
    exported(arguments, database, series, range)
}

/// Says that the table of pressures leaves out the points.
fn tell_points(database: &Database) -> Result<(), Failure> {
    let count = database.reader.points()?.len();
    if count > 0 {
        let points = if count == 1 { "1 point".to_owned() } else { format!("{count} points") };
        notice(&format_args!(
            "the database also has {points} of slaves, whose values are no pressures: --points exports them"
        ));
    }
    Ok(())
}

/// Writes the samples of series or of points.
fn exported<S: Exported>(
    arguments: &Arguments,
    database: Database,
    series: Vec<S>,
    (from, to): (Micros, Micros),
) -> Result<(), Failure> {
    let file = arguments.out.as_deref().filter(|path| path.as_os_str() != "-");
    if arguments.parquet {
        let path =
            file.ok_or_else(|| Failure::usage("expected a file for Parquet, got standard output; give --out FILE"))?;
        return parquet(Chunks::new(database.reader, series, from, to), path, arguments.force);
    }
    let export = Export::new(database.reader, series, from, to);
    match file {
        Some(path) => write_rows(path, arguments.force, |to| csv(export, to, path)),
        None => printed(export),
    }
}

#[cfg(feature = "parquet")]
fn parquet<S: Exported>(chunks: Chunks<S>, path: &Path, force: bool) -> Result<(), Failure> {
    write_rows(path, force, |to| {
        profivac_recorder::parquet::write(chunks, to)
            .map_err(|error| Failure::usage(format!("{}: {error}", path.display())))
    })
}

#[cfg(not(feature = "parquet"))]
fn parquet<S: Exported>(_: Chunks<S>, _: &Path, _: bool) -> Result<(), Failure> {
    Err(Failure::usage(
        "this program was built without Parquet: export CSV without --parquet, or build with --features parquet",
    ))
}

/// Writes CSV to standard output until it ends or its reader has gone.
fn printed<S: Exported>(export: Export<S>) -> Result<(), Failure> {
    for rows in export {
        let rows = rows?;
        if !rows.is_empty() {
            out(rows.trim_end());
        }
        check()?;
    }
    Ok(())
}

/// Writes CSV; returns the number of rows.
fn csv<S: Exported>(export: Export<S>, to: &mut (dyn Write + Send), path: &Path) -> Result<u64, Failure> {
    let mut lines: usize = 0;
    for rows in export {
        let rows = rows?;
        lines = lines.saturating_add(rows.lines().count());
        to.write_all(rows.as_bytes()).map_err(|error| not_written(path, &error))?;
    }
    Ok(lines.saturating_sub(1) as u64)
}

/// Writes a whole file, and tells the number of its rows.
fn write_rows(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut (dyn Write + Send)) -> Result<u64, Failure>,
) -> Result<(), Failure> {
    check_absent(path, force)?;
    let rows = whole_file::write(path, write)?;
    notice(&format_args!("{rows} rows in {}", path.display()));
    Ok(())
}
