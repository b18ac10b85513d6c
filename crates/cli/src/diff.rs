//! `profivac diff`: compares a gauge with a settings file.

use crate::failure::Failure;
use crate::gauge::{AnyGauge, GaugeOptions};
use crate::output::{json, notice, out};
use clap::Args;
use profivac_client::ClientError;
use profivac_client::names::NamedParameter;
use profivac_client::settings::{Difference, Setting, SettingsFile, SettingsFileError, compare};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Compare a gauge with the settings in a file of `profivac dump`.
///
/// This takes no ownership and changes no setting; where several instances share a slot, the Channel Instance Selector is changed and
/// restored. Pressures in different units are converted before they are compared.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    options: GaugeOptions,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// The settings file
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  profivac diff --port /dev/ttyUSB0 --address 5 gauge.toml
  profivac diff --port /tmp/line --address 5 gauge.toml --json";

#[derive(Debug, Serialize)]
struct Row<'a> {
    name: &'a str,
    file: &'a str,
    gauge: &'a str,
}

/// Compares and prints the differences.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = load(&arguments.file)?;
    let differences = arguments.options.with_gauge(|gauge| {
        let settings = ordered_settings(&file, &arguments.file, gauge)?;
        differences(gauge, &settings, &arguments.file)
    })?;
    let rows: Vec<_> = differences
        .iter()
        .map(|it| Row { name: &it.write.named.name, file: &it.write.text, gauge: &it.current.text })
        .collect();
    if arguments.json {
        out(&json(&rows));
    } else if rows.is_empty() {
        notice(&format_args!("no differences in {} settings", file.settings.len()));
    } else {
        out(&table(&rows));
    }
    Ok(())
}

fn table(rows: &[Row<'_>]) -> String {
    let width = |column: fn(&Row<'_>) -> usize| rows.iter().map(column).max().unwrap_or_default().max(4);
    let (name, file) = (width(|row| row.name.len()), width(|row| row.file.len()));
    let header = format!("{:<name$}  {:<file$}  GAUGE", "NAME", "FILE");
    rows.iter().fold(header, |text, row| text + &format!("\n{:<name$}  {:<file$}  {}", row.name, row.file, row.gauge))
}

/// Reads a settings file.
pub fn load(path: &Path) -> Result<SettingsFile, Failure> {
    let text = profivac_host::text_file::read(path)
        .map_err(|error| Failure::usage(format!("{} cannot be read: {error}", path.display())))?;
    SettingsFile::parse(&text).map_err(|error| file_failure(path, &error))
}

fn file_failure(path: &Path, error: &SettingsFileError) -> Failure {
    Failure::usage(format!("{}: {error}", path.display()))
}

/// The settings of a file in the order in which they are written. A file of another device is an error.
pub fn ordered_settings(
    file: &SettingsFile,
    path: &Path,
    gauge: &AnyGauge<'_>,
) -> Result<Vec<(NamedParameter, Setting)>, Failure> {
    file.check(gauge).map_err(|error| file_failure(path, &error))?;
    file.in_order(gauge).map_err(|error| file_failure(path, &error))
}

/// The settings whose value differs from the file. A value that the gauge cannot have is an error of the file.
pub fn differences(
    gauge: &mut AnyGauge<'_>,
    settings: &[(NamedParameter, Setting)],
    path: &Path,
) -> Result<Vec<Difference>, Failure> {
    let mut differences = Vec::new();
    for (named, setting) in settings {
        match compare(gauge, named, setting) {
            Ok(difference) => differences.extend(difference),
            Err(ClientError::Value { error, .. }) => {
                let (line, column) = setting.at;
                return Err(file_failure(
                    path,
                    &SettingsFileError::Syntax { line, column, message: format!("{named}: {error}") },
                ));
            }
            Err(error) => return Err(error.into()),
        }
    }
    Ok(differences)
}
