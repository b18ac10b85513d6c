//! `[[segment.slave]]` and `[[segment.slave.point]]`: a slave by its GSD file or its device file.

mod alarms;
mod described;
mod outputs;
mod points;
#[cfg(test)]
mod tests;

use super::error::{ConfigProblem, Located};
use super::slave_problem::SlaveProblem;
use crate::time_span::TimeSpan;
use outputs::OutputsToml;
use points::PointToml;
use profivac_devices::model::Model;
use profivac_gsd::GsdFile;
use profivac_gsd_slave::{Catalog, Change, GsdSlave, Modules, Selection, Value as PrmValue};
use profivac_host::text_file::Parsed;
use profivac_station::alarm::Rule;
use profivac_station::config::{POLL, Slave};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::Spanned;

/// `[[segment.slave]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlaveToml {
    /// The name, unique in the station.
    pub name: Spanned<String>,
    /// The address on the segment, 0 to 125.
    pub address: Spanned<u8>,
    /// Its GSD file, or a folder with this file and its other languages.
    gsd: Option<Spanned<PathBuf>>,
    /// In place of `gsd`: a device that `profivac device list` knows, or a device file beside this file: `turbo.toml`. The values of its
    /// inputs are points.
    pub device: Option<Spanned<String>>,
    /// The tables of `device`, once they were found.
    #[serde(skip)]
    pub model: Option<&'static Model>,
    /// The modules: a list of numbers and names of the GSD file in slot order, or a table `{ SLOT = NUMBER or "NAME" }`. Default: those
    /// that the file presets; of `device` the default configuration.
    modules: Option<Spanned<Modules>>,
    /// Parameters that differ from the GSD file: `{ "NAME" = "VALUE" }`. If several have the name, `"SLOT:NAME"`.
    #[serde(default)]
    parameters: BTreeMap<Spanned<String>, PrmValue>,
    /// `true`: the station takes the slave into data exchange and sends it parameters, configuration and outputs. Default: `false`, the
    /// station only reads it.
    own: Option<Spanned<bool>>,
    /// With `own`, needed for a slave with outputs: all octets in hexadecimal, or a table `{ SLOT = "OCTETS" }`.
    outputs: Option<Spanned<OutputsToml>>,
    /// With `own`: an output by its name, instead of the octets in `outputs` or over them.
    #[serde(default)]
    output: Vec<PointToml>,
    /// The sampling interval, 20 ms to 1 h. Default: `200 ms`.
    pub poll: Option<Spanned<Parsed<TimeSpan>>>,
    /// Its first slot in the map of `[modbus]`, 0 to 494.
    pub modbus: Option<Spanned<u16>>,
    /// A value in its inputs.
    #[serde(default)]
    point: Vec<PointToml>,
}

/// The error at this place.
fn at(span: Range<usize>, problem: SlaveProblem) -> Located {
    Located::new(span, ConfigProblem::Slave(Box::new(problem)))
}

/// The slaves of a segment of the file in `folder`.
pub fn slaves(slaves: &[SlaveToml], listen_only: bool, folder: &Path) -> Result<Vec<Slave>, Located> {
    slaves.iter().map(|slave| slave.settings(folder, listen_only)).collect()
}

/// Why the station reads no records of a slave; `None` if it does.
fn no_records(gsd: &GsdSlave, is_owned: bool, listen_only: bool) -> Option<&'static str> {
    let has_ms2 = gsd.device().general.c2_read_write_supp == Some(true);
    match (is_owned, listen_only, has_ms2) {
        (true, ..) => Some("record only of a slave with own = false"),
        (_, true, _) => {
            Some("record only on a segment with a master of the station, and listen-only = true sends nothing")
        }
        (.., false) => Some("record only of a slave whose GSD file has C2_Read_Write_supp"),
        _ => None,
    }
}

/// The alarms of all points, with the places of their conditions.
pub fn rules<'a>(slaves: impl Iterator<Item = &'a SlaveToml>) -> Result<Vec<(Range<usize>, Rule)>, Located> {
    let points = slaves.flat_map(|slave| slave.point.iter().map(move |point| (slave.name.get_ref(), point)));
    let rules = points.flat_map(|(slave, point)| point.rules(slave));
    rules.collect()
}

impl SlaveToml {
    fn settings(&self, folder: &Path, listen_only: bool) -> Result<Slave, Located> {
        let gsd = self.slave(self.file(folder)?)?;
        let own = self.own.as_ref().filter(|own| *own.get_ref());
        if let Some(own) = own.filter(|_| listen_only) {
            return Err(at(own.span(), SlaveProblem::OwnedByListener));
        }
        let place = own.map_or_else(|| self.name.span(), Spanned::span);
        let outputs = outputs::outputs(&gsd, own.is_some(), self.outputs.as_ref(), &self.output, place)?;
        let points = points::points(&self.point, &gsd, no_records(&gsd, own.is_some(), listen_only))?;
        let points = match self.model {
            Some(model) => described::with_values(model, &gsd, points),
            None => points,
        };
        Ok(Slave {
            name: self.name.get_ref().clone(),
            address: *self.address.get_ref(),
            gsd: Arc::new(gsd),
            is_owned: own.is_some(),
            outputs,
            poll: self.poll.as_ref().map_or(POLL, |poll| poll.get_ref().0.into()),
            points,
        })
    }

    /// The place of the GSD file or of the device.
    fn source(&self) -> Range<usize> {
        let device = self.device.as_ref().map(Spanned::span);
        self.gsd.as_ref().map(Spanned::span).or(device).unwrap_or_else(|| self.name.span())
    }

    /// The GSD file, or that of the tables of the device. A folder must have the files of one device.
    fn file(&self, folder: &Path) -> Result<Arc<GsdFile>, Located> {
        let gsd = match (&self.gsd, self.model) {
            (Some(gsd), None) => gsd,
            (None, Some(model)) => return Ok(described::file(model)),
            _ => return Err(at(self.name.span(), SlaveProblem::GsdOrDevice)),
        };
        let path = folder.join(gsd.get_ref());
        let wrong = |problem| at(gsd.span(), problem);
        let catalog = Catalog::read(std::slice::from_ref(&path)).map_err(|error| wrong(SlaveProblem::File(error)))?;
        let all: Vec<_> = catalog.entries().map(|(_, entry)| entry).collect();
        match all.as_slice() {
            [only] => Ok(Arc::clone(&only.file)),
            several => {
                let found =
                    several.iter().map(|entry| format!("{} ({})", entry.path.display(), entry.name())).collect();
                Err(wrong(SlaveProblem::SeveralFiles { path, found }))
            }
        }
    }

    /// The slave of the file with modules and parameters. The changes are tried one after the other, so that an error has the place of its
    /// parameter.
    fn slave(&self, file: Arc<GsdFile>) -> Result<GsdSlave, Located> {
        let usual = || self.model.map_or_else(Modules::default, described::usual_module);
        let modules = self.modules.as_ref().map_or_else(usual, |modules| modules.get_ref().clone());
        let modules_at = self.modules.as_ref().map_or_else(|| self.source(), Spanned::span);
        let mut selection = Selection { modules, changes: Vec::new() };
        let mut slave = GsdSlave::new(Arc::clone(&file), &selection)
            .map_err(|error| at(modules_at, SlaveProblem::Selection(error)))?;
        for (name, PrmValue(value)) in &self.parameters {
            selection.changes.push(Change { slot: None, target: name.get_ref().clone(), value: value.clone() });
            slave = GsdSlave::new(Arc::clone(&file), &selection)
                .map_err(|error| at(name.span(), SlaveProblem::Selection(error)))?;
        }
        Ok(slave)
    }
}
