//! `profivac gsd`: the GSD files of devices, and GSD files of any slave.

mod check;
mod chosen;
mod file;

use crate::device_files::named;
use crate::failure::Failure;
use crate::output::out;
use crate::whole_file::{self, not_written};
use clap::Args;
use profivac_devices::catalog::MODELS;
use profivac_devices::model::Model;
use profivac_gsd::GsdFile;
use profivac_gsd_slave::MAX_OCTETS;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Print the GSD file of a device, for the engineering tool of a master; with --out, write it with its bitmaps.
///
/// profivac generates it from the device's tables; it is not the vendor's file. Every configuration of the manual is a module.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Arguments {
    #[command(subcommand)]
    file: Option<file::FileCommand>,
    /// The device, for instance bcg450, or a device file; with --out and without a device, all devices
    #[arg(value_name = "DEVICE|FILE.toml", required_unless_present = "out")]
    device: Option<String>,
    /// Write the GSD file and its three bitmaps into this folder; create the folder if it is missing, and replace older files
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  profivac gsd bcg450 > BCG450.GSD
  profivac gsd bcg450 --out gsd
  profivac gsd --out gsd
  profivac gsd my-gauge.toml > MY450.GSD
  profivac gsd check PUMP.GSD VALVE.GSD
  profivac gsd check gsd_files --all
  profivac gsd show VALVE.GSD --json
  profivac gsd show VALVE.GSD --modules 3+7";

/// Prints or writes our GSD files, or reads the files of other vendors.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(command) = &arguments.file {
        return file::run(command);
    }
    let model = arguments.device.as_deref().map(named).transpose()?;
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

/// Reads a GSD file of any slave.
pub fn read(path: &Path) -> Result<GsdFile, Failure> {
    let failed =
        |error: io::Error| Failure::usage(format!("{} cannot be read: {error}; check the path", path.display()));
    let mut octets = Vec::new();
    File::open(path).and_then(|file| file.take(MAX_OCTETS + 1).read_to_end(&mut octets)).map_err(failed)?;
    if octets.len() as u64 > MAX_OCTETS {
        return Err(Failure::usage(format!(
            "expected a GSD file of at most {} MiB, {} is larger; check the path",
            MAX_OCTETS >> 20,
            path.display()
        )));
    }
    Ok(GsdFile::read(&octets))
}

fn write(folder: &Path, models: &[&Model]) -> Result<(), Failure> {
    let failed = |error: io::Error| {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test")]

    use super::*;

    #[test]
    fn a_file_that_is_too_large_to_be_a_gsd_file_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.gsd");
        let file = File::create(&path).unwrap();
        file.set_len(MAX_OCTETS + 1).unwrap();
        let failure = read(&path).err().map(|failure| failure.to_string()).unwrap_or_default();
        assert!(failure.contains("at most 16 MiB"), "{failure}");
        file.set_len(MAX_OCTETS).unwrap();
        assert!(read(&path).is_ok());
    }
}
