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
use toml::Spanned;

/// The folder beside the station's file whose device files need not be named.
const FOLDER: &str = "devices";

/// Finds the tables of each gauge and slave, and the devices of the station: those of the usual folders, of the folder beside the station's
/// file, of `device-files`, and of gauges and slaves that name a file. A wrong file of the usual folders is left out: another station may need it.
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
    let of_gauges = file.segment.iter().flat_map(|segment| &segment.gauge).map(|gauge| &gauge.device);
    let of_slaves = file.segment.iter().flat_map(|segment| &segment.slave).filter_map(|slave| slave.device.as_ref());
    for device in of_gauges.chain(of_slaves) {
        let (name, path) = (device.get_ref(), folder.join(device.get_ref()));
        if is_device_file(Path::new(name)) && !of_files.contains_key(name) {
            of_files.extend(read(&path, device.span())?.described().first().map(|model| (name.clone(), *model)));
            paths.push(path);
        }
    }
    let devices = known_devices(&paths).map_err(|error| wrong(0..0, error.to_string()))?;
    let model = |device: &Spanned<String>| {
        let name = device.get_ref();
        let found = of_files.get(name).copied().or_else(|| devices.named(name));
        let unknown = || ConfigProblem::UnknownDevice(SpecError::UnknownDevice { name: name.clone(), devices });
        found.ok_or_else(|| Located::new(device.span(), unknown()))
    };
    for segment in &mut file.segment {
        let listen_only = segment.listen_only;
        for gauge in &mut segment.gauge {
            let found = model(&gauge.device)?;
            if !listen_only && found.values.iter().any(|value| value.is_output) {
                let title = found.title;
                let text = format!(
                    "{title} takes outputs, and zeros can stop a pump or close a valve: write [[segment.slave]] with device in place of \
                     [[segment.gauge]]"
                );
                return Err(wrong(gauge.device.span(), text));
            }
            gauge.model = Some(found);
        }
        for slave in &mut segment.slave {
            slave.model = slave.device.as_ref().map(model).transpose()?;
        }
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
