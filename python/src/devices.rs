//! The devices that a bus knows: the twelve, and those of device files.

use crate::failure::Failure;
use profivac_device_file::{DeviceFile, is_device_file, known_devices, of_models, usual_files};
use profivac_devices::catalog::{KnownDevices, is_built_in};
use profivac_devices::model::Model;
use profivac_virtual::device_spec::SpecError;
use std::path::{Path, PathBuf};

/// The twelve, and the devices of these files and folders and of the usual folders. A wrong file of the usual folders is left out.
pub fn known(files: &[PathBuf]) -> Result<KnownDevices, Failure> {
    let (mut paths, _wrong) = usual_files();
    paths.extend(files.iter().cloned());
    known_devices(&paths).map_err(Failure::usage)
}

/// The twelve, and these models of files, each once.
pub fn of(models: impl IntoIterator<Item = &'static Model>) -> KnownDevices {
    let mut described: Vec<&'static Model> = Vec::new();
    for model in models {
        if !is_built_in(model) && !described.contains(&model) {
            described.push(model);
        }
    }
    of_models(described)
}

/// The model with this name, or of this device file.
pub fn named(text: &str) -> Result<&'static Model, Failure> {
    if is_device_file(Path::new(text)) {
        return DeviceFile::read(Path::new(text)).map_err(Failure::usage)?.model().map_err(Failure::usage);
    }
    let devices = known(&[])?;
    devices.named(text).ok_or_else(|| Failure::usage(SpecError::UnknownDevice { name: text.to_owned(), devices }))
}
