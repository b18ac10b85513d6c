//! The devices of several files beside the built-in ones, as one value.

use crate::error::DeviceFileError;
use crate::{DeviceFile, MAX_MODELS, intern};
use profivac_devices::catalog::KnownDevices;
use std::path::{Path, PathBuf};

/// The ending of a device file.
const ENDING: &str = "toml";

/// The folder of the installation's device files.
const INSTALLED: &str = "/usr/share/profivac/devices";

/// The folders in which device files are found without being named: that of the installation and that of the user.
fn usual_folders() -> Vec<PathBuf> {
    let absolute = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let of_user = absolute("XDG_CONFIG_HOME").or_else(|| absolute("HOME").map(|home| home.join(".config")));
    let folders = of_user.into_iter().map(|folder| folder.join("profivac/devices"));
    [PathBuf::from(INSTALLED)].into_iter().chain(folders).filter(|folder| folder.is_dir()).collect()
}

/// The device files of the usual folders that can be used, and why the others cannot.
#[must_use]
pub fn usual_files() -> (Vec<PathBuf>, Vec<DeviceFileError>) {
    let (mut good, mut wrong) = (Vec::new(), Vec::new());
    for folder in usual_folders() {
        let found = files(&folder).unwrap_or_else(|error| {
            wrong.push(error);
            Vec::new()
        });
        for file in found {
            match DeviceFile::read(&file) {
                Ok(_) => good.push(file),
                Err(error) => wrong.push(error),
            }
        }
    }
    (good, wrong)
}

/// Whether `name` names a device file and not a device.
#[must_use]
pub fn is_device_file(name: &Path) -> bool {
    name.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(ENDING))
}

/// The built-in devices and those of the files at `paths`; of a folder, those of its files with the ending .toml.
///
/// The same files give the same devices: a program that reads them again keeps no second copy. A wrong file keeps nothing.
///
/// # Errors
/// The first wrong file, two files with one name, or more than [`MAX_MODELS`] files.
pub fn known_devices(paths: &[PathBuf]) -> Result<KnownDevices, DeviceFileError> {
    let mut found: Vec<(PathBuf, DeviceFile)> = Vec::new();
    for path in paths {
        for file in files(path)? {
            let read = DeviceFile::read(&file)?;
            match found.iter().find(|(_, other)| other.name() == read.name()) {
                // The same file, reached in two ways.
                Some((_, other)) if other.is_same(&read) => {}
                Some((other, _)) => {
                    let text = format!("{} has the name {:?} too; rename one", other.display(), read.name());
                    return Err(about(&file, text));
                }
                None if found.len() >= MAX_MODELS => {
                    let text = format!(
                        "expected at most {MAX_MODELS} device files, found more; name only those that are needed"
                    );
                    return Err(about(&file, text));
                }
                None => found.push((file, read)),
            }
        }
    }
    let model = |(file, read): (PathBuf, DeviceFile)| read.model().map_err(|error| about(&file, error.to_string()));
    Ok(intern::of_models(found.into_iter().map(model).collect::<Result<_, _>>()?))
}

/// The file, or the device files of the folder, by name.
fn files(path: &Path) -> Result<Vec<PathBuf>, DeviceFileError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let failed = |error: std::io::Error| about(path, format!("the folder cannot be read: {error}"));
    let mut files = Vec::new();
    for entry in path.read_dir().map_err(failed)? {
        let file = entry.map_err(failed)?.path();
        if file.is_file() && is_device_file(&file) {
            files.push(file);
        }
    }
    files.sort();
    Ok(files)
}

fn about(path: &Path, text: String) -> DeviceFileError {
    DeviceFileError { file: path.display().to_string(), position: None, text }
}
