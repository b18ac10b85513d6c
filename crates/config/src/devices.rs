//! The devices of a station: the built-in ones and those of device files.

use super::error::{ConfigProblem, Located};
use super::file::ConfigToml;
use profivac_device_file::{is_device_file, known_devices, usual_files};
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::Model;
use profivac_station::config::Config;
use profivac_virtual::device_spec::SpecError;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The folder beside the station's file whose device files need not be named.
const FOLDER: &str = "devices";

/// Finds the tables of each gauge, and the devices of the station: those of the usual folders, of the folder beside the station's file, of
/// `device-files`, and of gauges that name a file. A wrong file of the usual folders is left out: another station may need it.
pub fn resolve(file: &mut ConfigToml, folder: &Path) -> Result<KnownDevices, Located> {
    let wrong = |span, text: String| Located::new(span, ConfigProblem::DeviceFile(text));
    let read = |path: &PathBuf, span: Range<usize>| {
        known_devices(std::slice::from_ref(path)).map_err(|error| wrong(span, error.to_string()))
    };
    let mut paths = usual_files().0;
    if let Some(beside) = Some(folder.join(FOLDER)).filter(|folder| folder.is_dir()) {
        read(&beside, 0..0)?;
        paths.push(beside);
    }
    for named in &file.station.device_files {
        let path = folder.join(named.get_ref());
        read(&path, named.span())?;
        paths.push(path);
    }
    let mut of_files: BTreeMap<String, &'static Model> = BTreeMap::new();
    for gauge in file.segment.iter().flat_map(|segment| &segment.gauge) {
        let (name, path) = (gauge.device.get_ref(), folder.join(gauge.device.get_ref()));
        if is_device_file(Path::new(name)) && !of_files.contains_key(name) {
            of_files.extend(read(&path, gauge.device.span())?.described().first().map(|model| (name.clone(), *model)));
            paths.push(path);
        }
    }
    let devices = known_devices(&paths).map_err(|error| wrong(0..0, error.to_string()))?;
    for gauge in file.segment.iter_mut().flat_map(|segment| &mut segment.gauge) {
        let name = gauge.device.get_ref();
        let found = of_files.get(name).copied().or_else(|| devices.named(name));
        let unknown = || ConfigProblem::UnknownDevice(SpecError::UnknownDevice { name: name.clone(), devices });
        gauge.model = Some(found.ok_or_else(|| Located::new(gauge.device.span(), unknown()))?);
    }
    Ok(devices)
}

/// Gives the devices of `config` the tables that the running station has for them: a device file that has changed counts from the next
/// start on. Returns the names of the devices whose files have changed.
pub fn keep(running: KnownDevices, config: &mut Config) -> Vec<&'static str> {
    let mut changed = Vec::new();
    let old = running.described();
    let kept = |model: &'static Model| old.iter().copied().find(|old| old.name == model.name).unwrap_or(model);
    for model in config.devices.described().iter().filter(|model| kept(model) != **model) {
        changed.push(model.name);
    }
    config.devices =
        profivac_device_file::of_models(config.devices.described().iter().map(|model| kept(model)).collect());
    for segment in &mut config.segments {
        segment.devices = config.devices;
        for gauge in &mut segment.gauges {
            gauge.device = kept(gauge.device);
        }
    }
    changed
}
