//! Devices by name or by device file: what a command accepts where a device is named, and the devices that it knows.

use crate::failure::Failure;
use crate::output::notice;
use clap::Args;
use profivac_device_file::{DeviceFile, DeviceFileError, is_device_file, known_devices, usual_files};
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::Model;
use profivac_virtual::device_spec::SpecError;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The devices of this command. A program runs one command, and what it knows is the same in each of its parts.
static KNOWN: OnceLock<KnownDevices> = OnceLock::new();

/// The files that describe devices.
#[derive(Args, Clone, Debug, Default)]
pub struct DeviceFileOptions {
    /// Files that describe devices (docs/device-files.md), and folders of them; those of /usr/share/profivac/devices and
    /// ~/.config/profivac/devices need not be named
    #[arg(long = "device-files", id = "device-files", value_name = "FILE|FOLDER")]
    device_files: Vec<PathBuf>,
}

impl DeviceFileOptions {
    /// Without files that are named.
    pub const fn none() -> Self {
        Self { device_files: Vec::new() }
    }

    /// Reads the files; the devices are those of the command from here on. A wrong file that was not named is a notice.
    pub fn read(&self) -> Result<KnownDevices, Failure> {
        if let Some(known) = KNOWN.get() {
            return Ok(*known);
        }
        let (mut paths, wrong_files) = usual_files();
        for error in wrong_files {
            notice(&format_args!("{error}; this device file is left out"));
        }
        paths.extend(self.device_files.iter().cloned());
        let devices = known_devices(&paths).map_err(wrong)?;
        Ok(*KNOWN.get_or_init(|| devices))
    }
}

fn wrong(error: DeviceFileError) -> Failure {
    Failure::usage(error.to_string())
}

/// The devices that the command knows: the built-in ones, and those of the files that it has read.
pub fn known() -> KnownDevices {
    KNOWN.get().copied().unwrap_or_default()
}

/// The names of the devices with this Ident_Number.
pub fn names_with_ident(ident: u16) -> Vec<&'static str> {
    known().names_with_ident(ident).collect()
}

/// The model of a device by its name, or of a device file.
pub fn named(text: &str) -> Result<&'static Model, Failure> {
    if is_device_file(Path::new(text)) {
        return Ok(read(Path::new(text))?.1);
    }
    let devices = DeviceFileOptions::none().read()?;
    devices.named(text).ok_or_else(|| SpecError::UnknownDevice { name: text.to_owned(), devices }.into())
}

/// The devices that the device of a file is like, and its model.
pub fn read(path: &Path) -> Result<(Vec<String>, &'static Model), Failure> {
    let file = DeviceFile::read(path).map_err(wrong)?;
    let parents = file.parents().map(str::to_owned).collect();
    let model = file.model().map_err(|error| Failure::usage(error.to_string()))?;
    Ok((parents, model))
}
