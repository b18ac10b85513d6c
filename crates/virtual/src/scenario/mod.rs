//! Scenarios: a plant, its gauges, a timeline of events, and the expected results, in one file.
//!
//! ```toml
//! title = "Pump-down"
//! until = "10 min"
//!
//! [volumes]
//! chamber = { volume = "100 l" }                  # filled with the air outside
//!
//! [roughing-pumps]
//! pump = { at = "chamber", speed = "20 m3/h", ultimate = "1e-2 mbar" }
//!
//! [gauges]
//! "pcg550@5" = "chamber"
//!
//! [[timeline]]
//! at = "10 s"
//! start = ["pump"]
//!
//! [[timeline]]
//! at = "5 min"
//! expect = [{ volume = "chamber", below = "0.1 mbar" }, { device = 5, state = "EXECUTING" }]
//! ```
//!
//! docs/scenarios.md describes all keys. The file is checked completely before it runs; an error has line, column and the
//! expected value. The same file runs in a [`MemorySegment`], on real ports, and on devices without a bus. [`Run`] takes
//! the same steps everywhere, so that the sensors depend on the file alone.

mod error;
mod event;
mod included;
mod plant;
mod quantities;
mod run;
mod schematic;

pub use error::ScenarioEntryError;
pub use event::{Check, DeviceAction, Event, Expectation, ScenarioAction, Subject};
pub use included::{INCLUDED, Included};
pub use plant::{Part, Plant};
pub use run::{FailedExpectation, MasterPresence, PartState, Run};
pub use schematic::{Schematic, SchematicGauge, SchematicKind, SchematicPart};

use crate::device::VirtualDevice;
use crate::device_spec::{DeviceSpec, SpecError, check_addresses, check_distinct};
use crate::gsd_slave::{GsdSpec, GsdSpecError, GsdStation, OpenedSlave};
use crate::memory_segment::MemorySegment;
use crate::nonvolatile::NonvolatileMemory;
use error::TextError;
use event::EventParser;
use profivac_client::cyclic::{CyclicSlave, ReportedChannels};
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::{Configuration, Field, Model, NumberType};
use profivac_dp::link::Baud;
use profivac_dp::link::active::{BusParameters, OutOfRange};
use profivac_dp::master::SlaveListError;
use profivac_scenario_file::{File, Text};
use profivac_vacuum::network::Volume;
use profivac_vacuum::sensor::{Environment, REFERENCE_K};
use quantities::{TIME, unknown};
use std::cell::RefCell;
use std::path::Path;

/// The default length of a step and the longest one, in s.
const STEP_S: f64 = 0.01;
const LONGEST_STEP_S: f64 = 3600.0;

/// The reason why a scenario cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("{name}: {source}")]
    Read {
        /// The file.
        name: String,
        /// The error of the system.
        source: std::io::Error,
    },
    /// There is no file of this name, and no included scenario.
    #[error("expected a scenario file or the name of an included scenario, found {found:?}; included: {known}{}",
        suggestion.as_ref().map(|name| format!("; did you mean {name:?}?")).unwrap_or_default())]
    Unknown {
        /// The given name.
        found: String,
        /// All names.
        known: String,
        /// The most similar name.
        suggestion: Option<String>,
    },
    /// The text is invalid.
    #[error("{name}:{line}:{column}: {}{error}", key.as_ref().map(|key| format!("{key}: ")).unwrap_or_default())]
    Invalid {
        /// The file.
        name: String,
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// The key whose value is wrong; `None` where the error is not about the value of a key.
        key: Option<String>,
        /// The expected and the found value.
        error: Box<ScenarioEntryError>,
    },
}

/// The reason why the segment in memory cannot be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MemorySegmentError {
    /// A device spec is invalid.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The master cannot have its address.
    #[error(transparent)]
    Bus(#[from] OutOfRange),
    /// The master cannot have the slaves.
    #[error(transparent)]
    Master(#[from] SlaveListError),
    /// A slave by its GSD file cannot be built.
    #[error(transparent)]
    Slave(#[from] GsdSpecError),
}

/// A scenario that can be run.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The title.
    pub title: String,
    /// The duration in s.
    pub until_s: f64,
    name: String,
    seed: u64,
    has_real_sensors: bool,
    step_s: f64,
    plant: Plant,
    schematic: Schematic,
    gauges: Vec<Gauge>,
    slaves: Vec<GsdSpec>,
    events: Vec<Event>,
}

impl Scenario {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`ScenarioError`] with the position in the file.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        let name = path.display().to_string();
        let text = profivac_host::text_file::read(path)
            .map_err(|source| ScenarioError::Read { name: name.clone(), source })?;
        Self::parse(&text, &name)
    }

    /// Parses `text` of the file `name`.
    ///
    /// # Errors
    /// [`ScenarioError::Invalid`] with the position in the text.
    pub fn parse(text: &str, name: &str) -> Result<Self, ScenarioError> {
        Self::make(text, name).map_err(|TextError { at, error }| {
            let (line, column) = profivac_host::text_file::line_and_column(text, at);
            let key = key_before(text, at);
            ScenarioError::Invalid { name: name.to_owned(), line, column, key, error: Box::new(error) }
        })
    }

    fn make(text: &str, name: &str) -> Result<Self, TextError> {
        let file = File::read(text).map_err(|error| {
            TextError::at(&error.span().unwrap_or_default(), ScenarioEntryError::Toml(Box::new(error)))
        })?;
        let plant = Plant::new(&file)?;
        let mut gauges = gauges(&file, &plant, name)?;
        channels(&file, &plant, &mut gauges)?;
        let specs: Vec<DeviceSpec> = gauges.iter().map(|gauge| gauge.spec.clone()).collect();
        let step_s = file.step.as_ref().map(step).transpose()?.unwrap_or(STEP_S);
        let until_s = TIME.positive(&file.until)?;
        let (slaves, trial) = slaves(&file, name, &specs)?;
        let trial = RefCell::new(trial);
        let reader = EventParser { plant: &plant, specs: &specs, slaves: &trial, text, step_s, until_s };
        let events = reader.events(&file)?;
        let real = has_real_sensors(&file)?;
        let schematic = Schematic::new(&file, &plant, &gauges);
        let File { title, seed, .. } = file;
        let name = name.to_owned();
        Ok(Self {
            title,
            until_s,
            name,
            seed,
            has_real_sensors: real,
            step_s,
            plant,
            schematic,
            gauges,
            slaves,
            events,
        })
    }

    /// The plant as a drawing needs it.
    #[must_use]
    pub const fn schematic(&self) -> &Schematic {
        &self.schematic
    }

    /// The devices of the plant.
    pub fn specs(&self) -> impl Iterator<Item = &DeviceSpec> {
        self.gauges.iter().map(|gauge| &gauge.spec)
    }

    /// Builds the devices, each with its nonvolatile memory. A [`Run`] advances their time.
    ///
    /// # Errors
    /// [`SpecError`] if the stored values do not fit the device; the file itself has been checked.
    pub fn devices<E: From<SpecError>>(
        &self,
        baud: Baud,
        memory: impl Fn(&DeviceSpec) -> Result<NonvolatileMemory, E>,
    ) -> Result<Vec<VirtualDevice>, E> {
        let device = |Gauge { spec, volume, channel_volumes: elsewhere }: &Gauge| {
            let slave = spec.build(memory(spec)?, baud)?;
            let mut device = VirtualDevice::new(slave, spec.address, baud, environment(&self.plant, *volume));
            for (instance, volume) in elsewhere {
                device.set_part_environment(*instance, environment(&self.plant, *volume));
            }
            // A channel elsewhere begins with its own pressure and not with that of the chamber.
            device.settle_in(environment(&self.plant, *volume));
            if self.has_real_sensors {
                device = device.with_real_sensors(self.seed);
            }
            Ok(device.with_external_time())
        };
        self.gauges.iter().map(device).collect()
    }

    /// Builds the slaves by their GSD files. They keep records and addresses in `state`, or only while the process runs.
    ///
    /// # Errors
    /// [`GsdSpecError`] if a slave does not run at the rate, or the folder cannot be used; the file itself has been checked.
    pub fn slaves(&self, baud: Baud, state: Option<&Path>) -> Result<Vec<OpenedSlave>, GsdSpecError> {
        self.slaves.iter().map(|spec| spec.open(baud, state)).collect()
    }

    /// Puts the devices on a segment in memory with a master at `address` that exchanges data with all of them.
    ///
    /// # Errors
    /// [`MemorySegmentError`] when the master has no room for the slaves, or no master can have this address.
    pub fn memory_segment(&self, address: u8, baud: Baud) -> Result<MemorySegment, MemorySegmentError> {
        let devices = self.devices(baud, |_| Ok::<_, SpecError>(NonvolatileMemory::volatile()))?;
        let watched = |(Gauge { spec, .. }, device): (&Gauge, &VirtualDevice)| {
            let model = spec.model;
            let configuration = cyclic_configuration(model);
            // Every device has mbar. COUNTS would need the scale of the gauge.
            let unit = model.unit_named("mbar").ok_or_else(|| SpecError::UnknownDevice {
                name: spec.device.clone(),
                devices: KnownDevices::BUILT_IN,
            })?;
            Ok::<_, SpecError>(CyclicSlave {
                address: spec.address,
                model,
                configuration,
                unit,
                channels: ReportedChannels::of_parts(model, device.ranges()),
            })
        };
        let watched = self.gauges.iter().zip(&devices).map(watched).collect::<Result<Vec<_>, _>>()?;
        let bus = BusParameters::new(address, baud).check()?;
        let slaves = self.slaves(baud, None)?.into_iter().map(|opened| opened.station).collect();
        let segment = MemorySegment::new(devices, watched, bus, baud).map_err(MemorySegmentError::Master)?;
        Ok(segment.with_slaves(slaves))
    }

    /// A run from the beginning.
    #[must_use]
    pub fn start(&self, bus: MasterPresence) -> Run {
        Run::new(self, bus)
    }
}

/// The key whose value begins at `at`.
fn key_before(text: &str, at: usize) -> Option<String> {
    let before = text.get(..at)?.trim_end_matches([' ', '\t']).strip_suffix('=')?.trim_end_matches([' ', '\t']);
    let is_key = |letter: char| letter.is_alphanumeric() || "_-".contains(letter);
    let key: String = before.chars().rev().take_while(|letter| is_key(*letter)).collect();
    (!key.is_empty()).then(|| key.chars().rev().collect())
}

/// The length of a step.
fn step(text: &Text) -> Result<f64, TextError> {
    let step_s = TIME.positive(text)?;
    let long = || ScenarioEntryError::LongStep(text.get_ref().clone());
    if step_s <= LONGEST_STEP_S { Ok(step_s) } else { Err(TextError::at(&text.span(), long())) }
}

/// The first configuration with floats and their instance or the status of each channel, or the default one.
#[must_use]
pub fn cyclic_configuration(model: &'static Model) -> &'static Configuration {
    let tells = |configuration: &&Configuration| {
        let has = |field| configuration.inputs.is_some_and(|inputs| inputs.fields.contains(&field));
        let is_gauge = has(Field::PvSelector) && has(Field::ProcessValue(NumberType::Float));
        let is_controller = has(Field::ChannelStatus) && has(Field::ChannelValue(1, NumberType::Float));
        (is_gauge || is_controller) && configuration.outputs.is_none()
    };
    model.configurations.iter().find(tells).unwrap_or(model.default_configuration)
}

/// A device and its volume.
#[derive(Clone, Debug)]
struct Gauge {
    spec: DeviceSpec,
    volume: Volume,
    /// The volumes of the other measuring parts, by instance.
    channel_volumes: Vec<(u8, Volume)>,
}

/// The environment of a gauge at a volume.
fn environment(plant: &Plant, volume: Volume) -> Environment {
    Environment {
        gas: plant.network.mixture(volume),
        atmosphere_pa: plant.network.atmosphere().pressure_pa,
        temperature_k: REFERENCE_K,
    }
}

/// The devices and their volumes, in the order of their addresses. Their files are relative to the scenario `name`.
fn gauges(file: &File, plant: &Plant, name: &str) -> Result<Vec<Gauge>, TextError> {
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    let mut gauges: Vec<Gauge> = Vec::new();
    for (written, at) in &file.gauges {
        let wrong = |error: SpecError| TextError::at(&written.span(), error);
        let spec = DeviceSpec::parse_in(written.get_ref(), folder).map_err(wrong)?;
        spec.build(NonvolatileMemory::volatile(), Baud::B19200)
            .map_err(|error| TextError::at(&written.span(), error))?;
        let volume = plant.at(at)?;
        gauges.push(Gauge { spec, volume, channel_volumes: Vec::new() });
        let specs: Vec<DeviceSpec> = gauges.iter().map(|gauge| gauge.spec.clone()).collect();
        check_addresses(&specs).map_err(|error| TextError::at(&written.span(), error))?;
    }
    gauges.sort_by_key(|gauge| gauge.spec.address);
    Ok(gauges)
}

/// The slaves by their GSD files, and one of each to try orders on. Their files are relative to the scenario `name`.
fn slaves(file: &File, name: &str, gauges: &[DeviceSpec]) -> Result<(Vec<GsdSpec>, Vec<GsdStation>), TextError> {
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    let (mut specs, mut trial) = (Vec::new(), Vec::new());
    for written in &file.slaves {
        let wrong = |sentence: String| TextError::at(&written.span(), ScenarioEntryError::Slave(sentence));
        let spec: GsdSpec = written.get_ref().parse().map_err(|error: GsdSpecError| wrong(error.to_string()))?;
        let spec = spec.in_folder(folder);
        trial.push(spec.try_out().map_err(|error| wrong(error.to_string()))?);
        specs.push(spec);
        let addresses = gauges.iter().map(|spec| spec.address).chain(specs.iter().map(|spec| spec.address));
        check_distinct(addresses).map_err(|error| TextError::at(&written.span(), error))?;
    }
    Ok((specs, trial))
}

/// Resolves the volumes of the other measuring parts.
fn channels(file: &File, plant: &Plant, gauges: &mut [Gauge]) -> Result<(), TextError> {
    for (address, channels) in &file.channels {
        let addresses: Vec<String> = gauges.iter().map(|gauge| gauge.spec.address.to_string()).collect();
        let wrong = || unknown("the address of a gauge", address, addresses.iter().map(String::as_str));
        let at = addresses.iter().position(|known| known == address.get_ref()).ok_or_else(wrong)?;
        let Some(gauge) = gauges.get_mut(at) else { continue };
        let slave = gauge.spec.build(NonvolatileMemory::volatile(), Baud::B19200);
        let slave = slave.map_err(|error| TextError::at(&address.span(), error))?;
        let instances: Vec<String> = slave.device().parts().iter().map(|part| part.instance.to_string()).collect();
        for (instance, volume) in channels {
            let wrong = || unknown("an instance of a sensor", instance, instances.iter().map(String::as_str));
            let known =
                instances.iter().find(|known| *known == instance.get_ref()).and_then(|known| known.parse().ok());
            gauge.channel_volumes.push((known.ok_or_else(wrong)?, plant.at(volume)?));
        }
    }
    Ok(())
}

/// Whether the sensors are real.
fn has_real_sensors(file: &File) -> Result<bool, TextError> {
    match &file.sensors {
        None => Ok(true),
        Some(text) if text.get_ref() == "real" => Ok(true),
        Some(text) if text.get_ref() == "ideal" => Ok(false),
        Some(text) => Err(unknown("a kind of sensors", text, ["real", "ideal"].into_iter())),
    }
}
