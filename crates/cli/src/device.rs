//! `profivac device`: the devices that profivac has, and devices described in a file.

mod against_gsd;

use crate::device_files::{DeviceFileOptions, named, read};
use crate::failure::Failure;
use crate::gsd;
use crate::output::{json, notice, out, visible};
use clap::{Args, Subcommand};
use profivac_devices::catalog::is_built_in;
use profivac_devices::model::Model;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// List the devices, print one as a file, check files that describe devices, or print the schema of such files.
///
/// A device file is TOML with the tables of a manual: docs/device-files.md explains how to write one.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(subcommand)]
    command: DeviceCommand,
}

const EXAMPLES: &str = "\
Examples:
  profivac device list
  profivac device list --device-files my-gauge.toml
  profivac device show bcg450 > bcg450.toml
  profivac device check my-gauge.toml
  profivac device check my-gauge.toml --gsd INFI08E6.GSD
  profivac device schema > device-file.schema.json";

#[derive(Subcommand, Debug)]
enum DeviceCommand {
    List(ListArguments),
    Show(ShowArguments),
    Check(CheckArguments),
    /// Print the JSON schema of device files, for an editor that knows JSON schemas for TOML
    Schema,
}

/// List the built-in devices and those of device files, with name, manual and ident number
#[derive(Args, Debug)]
struct ListArguments {
    #[command(flatten)]
    device_files: DeviceFileOptions,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Print a device as a device file: all its tables
#[derive(Args, Debug)]
struct ShowArguments {
    /// A device by its name, for instance bcg450, or a device file: with like, all that it inherits
    #[arg(value_name = "DEVICE|FILE.toml")]
    device: String,
}

/// Check device files: what is wrong in which line, and what to do about it
///
/// Exit code 2 if a file cannot be used, or differs from the GSD file.
#[derive(Args, Debug)]
struct CheckArguments {
    /// Device files
    #[arg(value_name = "FILE.toml", required = true)]
    files: Vec<PathBuf>,
    /// Compare each device with this GSD file of its vendor: Ident_Number, configurations, lengths, services
    #[arg(long, value_name = "FILE.GSD")]
    gsd: Option<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.command {
        DeviceCommand::List(arguments) => list(arguments),
        DeviceCommand::Show(arguments) => {
            out(profivac_device_file::show(named(&arguments.device)?).trim_end());
            Ok(())
        }
        DeviceCommand::Check(arguments) => check(arguments),
        DeviceCommand::Schema => {
            out(profivac_device_file::SCHEMA.trim_end());
            Ok(())
        }
    }
}

/// A device in the JSON output.
#[derive(Serialize)]
struct Row {
    name: &'static str,
    title: &'static str,
    vendor: &'static str,
    manual: &'static str,
    ident: u16,
    /// A device file describes it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    from_device_file: bool,
}

fn list(arguments: &ListArguments) -> Result<(), Failure> {
    let row = |model: &'static Model| Row {
        name: model.name,
        title: model.title,
        vendor: model.vendor,
        manual: model.manual,
        ident: model.ident,
        from_device_file: !is_built_in(model),
    };
    let rows: Vec<Row> = arguments.device_files.read()?.iter().map(row).collect();
    if arguments.json {
        out(&json(&rows));
        return Ok(());
    }
    for Row { name, title, vendor, manual, ident, from_device_file } in rows {
        let file = if from_device_file { " (device file)" } else { "" };
        out(&visible(&format!("{name:<8} {ident:04X}  {title:<10} {vendor:<16} {manual}{file}")));
    }
    Ok(())
}

fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    let gsd = arguments.gsd.as_deref().map(gsd::read).transpose()?;
    let mut names: BTreeMap<&'static str, &Path> = BTreeMap::new();
    let mut wrong = 0_usize;
    for path in &arguments.files {
        let found = read(path).and_then(|(parents, model)| {
            out(&visible(&summary(path, &parents, model)));
            match names.insert(model.name, path) {
                Some(other) => Err(Failure::usage(format!(
                    "{} and {} both have the name {:?}; rename one",
                    other.display(),
                    path.display(),
                    model.name
                ))),
                None => Ok(model),
            }
        });
        let differences = match (found, &gsd) {
            (Ok(model), Some(gsd)) => against_gsd::differences(model, gsd.device()),
            (Ok(_), None) => Vec::new(),
            (Err(failure), _) => vec![failure.to_string()],
        };
        differences.iter().for_each(|line| notice(&visible(line)));
        wrong = wrong.saturating_add(usize::from(!differences.is_empty()));
    }
    if wrong == 0 {
        return Ok(());
    }
    let all = arguments.files.len();
    Err(Failure::usage(format!(
        "{wrong} of {all} device files cannot be used as they are; the lines above say where and why"
    )))
}

/// A device file that can be used, in one line.
fn summary(path: &Path, parents: &[String], model: &Model) -> String {
    let rows = model.blocks.iter().map(|placed| placed.block.rows.len().saturating_mul(placed.locations.len()));
    let parameters: usize = rows.sum();
    let like = if parents.is_empty() { String::new() } else { format!(", like {}", parents.join(", like ")) };
    let left_out = match profivac_device_file::left_out(model) {
        "" => String::new(),
        text => format!("; simulated without: {text}"),
    };
    format!(
        "{}: {} ({}), ident {:04X}{like}: {} configurations, {parameters} parameters{left_out}",
        path.display(),
        model.name,
        model.title,
        model.ident,
        model.configurations.len(),
    )
}
