//! `profivac gsd`: the GSD files of devices, and GSD files of any slave.

mod file;

pub use file::visible;

use crate::failure::Failure;
use crate::output::out;
use crate::whole_file::{self, not_written};
use clap::Args;
use profivac_devices::catalog::MODELS;
use profivac_devices::model::Model;
use profivac_virtual::device_spec::entry;
use std::path::{Path, PathBuf};

/// Print the GSD file of a device, for the engineering tool of a master; with --out, write it with its bitmaps.
///
/// profivac generates it from the device's tables; it is not the vendor's file. Every configuration of the manual is a module.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Arguments {
    #[command(subcommand)]
    file: Option<file::FileCommand>,
    /// The device, for instance bcg450; with --out and without a device, all devices
    #[arg(value_name = "DEVICE", required_unless_present = "out")]
    device: Option<String>,
    /// Write the GSD file and its three bitmaps into this folder, which is made if it is missing; older files are replaced
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  profivac gsd bcg450 > BCG450.GSD
  profivac gsd bcg450 --out gsd
  profivac gsd --out gsd
  profivac gsd check PUMP.GSD VALVE.GSD
  profivac gsd show VALVE.GSD --json";

/// Prints or writes our GSD files, or reads the files of other vendors.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(command) = &arguments.file {
        return file::run(command);
    }
    let model = arguments.device.as_deref().map(entry).transpose()?.map(|entry| entry.model);
    match (&arguments.out, model) {
        (Some(folder), Some(model)) => write(folder, &[model]),
        (Some(folder), None) => write(folder, &MODELS),
        (None, Some(model)) => {
            out(profivac_client::gsd::gsd(model).trim_end());
            Ok(())
        }
        // The parser asks for one of them.
        (None, None) => Err(Failure::usage("expected a device, for instance `profivac gsd bcg450`")),
    }
}

fn write(folder: &Path, models: &[&Model]) -> Result<(), Failure> {
    let failed = |error: std::io::Error| {
        Failure::usage(format!("{} cannot be written: {error}; choose another folder with --out", folder.display()))
    };
    std::fs::create_dir_all(folder).map_err(failed)?;
    for (name, octets) in models.iter().flat_map(|model| profivac_client::gsd::files(model)) {
        let path = folder.join(name);
        whole_file::write(&path, |to| to.write_all(&octets).map_err(|error| not_written(&path, &error)))?;
        out(&path.display().to_string());
    }
    Ok(())
}
