//! Scenarios: a plant, the gauges at it, what happens, and what has to come of it, in one file.
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
//! docs/scenarios.md has all keys. Everything is checked before anything starts; what is wrong is told with line, column and
//! what was expected. The same file runs in [`Scene`]s, on real ports, and on devices without a bus,
//! and [`Run`] takes the same steps everywhere, so that what the sensors see depends on the file alone.

mod event;
mod file;
mod plant;
mod run;
mod words;

pub use event::{Act, Check, DeviceAct, Event, Expectation, Subject};
pub use plant::{Part, Plant};
pub use run::{Bus, Finding, Run};

use crate::device::VirtualDevice;
use crate::factory::{Spec, SpecError, check_places, entry};
use crate::memory::Memory;
use crate::scene::Scene;
use event::Reader;
use file::File;
use profivac_client::watch::{Fitted, Watched};
use profivac_devices::model::{Configuration, Field, Model, NumberType};
use profivac_dp::link::Baud;
use profivac_vacuum::network::Volume;
use profivac_vacuum::sensor::{REFERENCE_K, Surroundings};
use std::path::Path;
use words::{TIME, Text, Wrong, unknown};

/// The length of a step unless the file says it, in s, and the longest.
const STEP_S: f64 = 0.01;
const LONGEST_STEP_S: f64 = 3600.0;

/// What is wrong with a scenario.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("{name}: {source}")]
    Read {
        /// The file.
        name: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// Something in it is wrong.
    #[error("{name}:{line}:{column}: {what}")]
    Wrong {
        /// The file.
        name: String,
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// What was expected, and what came.
        what: String,
    },
}

/// Why there is no segment in memory.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A device.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The master.
    #[error("{0}")]
    Master(String),
}

/// A scenario that can be run.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// What it is about.
    pub title: String,
    /// How long it lasts, in s.
    pub until_s: f64,
    name: String,
    seed: u64,
    real: bool,
    step_s: f64,
    plant: Plant,
    gauges: Vec<Gauge>,
    events: Vec<Event>,
}

impl Scenario {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`ScenarioError`] with the place in the file and what was expected there.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        let name = path.display().to_string();
        let text = profivac_host::text_file::read(path)
            .map_err(|source| ScenarioError::Read { name: name.clone(), source })?;
        Self::parse(&text, &name)
    }

    /// Reads `text`, which stands in the file `name`.
    ///
    /// # Errors
    /// [`ScenarioError::Wrong`] with the place in the text and what was expected there.
    pub fn parse(text: &str, name: &str) -> Result<Self, ScenarioError> {
        Self::make(text, name).map_err(|Wrong { at, what }| {
            let (line, column) = profivac_host::text_file::place_of(text, at);
            ScenarioError::Wrong { name: name.to_owned(), line, column, what }
        })
    }

    fn make(text: &str, name: &str) -> Result<Self, Wrong> {
        let file: File = toml::from_str(text)
            .map_err(|error| Wrong::at(&error.span().unwrap_or_default(), words::parser_sentence(error.message())))?;
        let plant = Plant::new(&file)?;
        let mut gauges = gauges(&file, &plant)?;
        channels(&file, &plant, &mut gauges)?;
        let specs: Vec<Spec> = gauges.iter().map(|gauge| gauge.spec.clone()).collect();
        let step_s = file.step.as_ref().map(step).transpose()?.unwrap_or(STEP_S);
        let until_s = TIME.positive(&file.until)?;
        let reader = Reader { plant: &plant, specs: &specs, text, step_s, until_s };
        let events = reader.events(&file)?;
        let real = real(&file)?;
        let File { title, seed, .. } = file;
        Ok(Self { title, until_s, name: name.to_owned(), seed, real, step_s, plant, gauges, events })
    }

    /// The devices by which the plant is watched.
    pub fn specs(&self) -> impl Iterator<Item = &Spec> {
        self.gauges.iter().map(|gauge| &gauge.spec)
    }

    /// Makes the devices, each with the memory it is given. They live by the time of a [`Run`].
    ///
    /// # Errors
    /// [`SpecError`] if a memory holds what the device cannot have; the file has been checked.
    pub fn devices<E: From<SpecError>>(
        &self,
        baud: Baud,
        memory: impl Fn(&Spec) -> Result<Memory, E>,
    ) -> Result<Vec<VirtualDevice>, E> {
        let device = |Gauge { spec, volume, elsewhere }: &Gauge| {
            let unit = spec.build(memory(spec)?, baud)?;
            let mut device = VirtualDevice::new(unit, spec.place, baud, around(&self.plant, *volume));
            for (instance, volume) in elsewhere {
                device.surround_part(*instance, around(&self.plant, *volume));
            }
            if self.real {
                device = device.with_real_sensors(self.seed);
            }
            Ok(device.driven())
        };
        self.gauges.iter().map(device).collect()
    }

    /// Puts the devices on a segment in memory with a master at `address` that exchanges data with all of them.
    ///
    /// # Errors
    /// [`SceneError`] when the master cannot have so many slaves, or a device is not as the file says; it has been checked.
    pub fn scene(&self, address: u8, baud: Baud) -> Result<Scene, SceneError> {
        let devices = self.devices(baud, |_| Ok::<_, SpecError>(Memory::volatile()))?;
        let watched = |Gauge { spec, .. }: &Gauge| {
            let model = entry(&spec.device)?.model;
            let configuration = telling(model);
            // Every device knows mbar; without it what it shows could not be told from counts.
            let unit = model.unit_named("mbar").ok_or_else(|| SpecError::Device(spec.device.clone()))?;
            Ok::<_, SpecError>(Watched { address: spec.place, model, configuration, unit, fitted: Fitted::default() })
        };
        let watched = self.gauges.iter().map(watched).collect::<Result<Vec<_>, _>>()?;
        Scene::new(devices, watched, address, baud).map_err(|error| SceneError::Master(error.to_string()))
    }

    /// A run from the beginning.
    #[must_use]
    pub fn start(&self, bus: Bus) -> Run {
        Run::new(self, bus)
    }
}

/// The length of a step.
fn step(text: &Text) -> Result<f64, Wrong> {
    let step_s = TIME.positive(text)?;
    let what = || format!("expected a step of at most 1 h, got {:?}", text.get_ref());
    if step_s <= LONGEST_STEP_S { Ok(step_s) } else { Err(Wrong::at(&text.span(), what())) }
}

/// The first configuration that tells a number as it is and which sensor it comes from, or the usual one.
fn telling(model: &'static Model) -> &'static Configuration {
    let tells = |configuration: &&Configuration| {
        let has = |field| configuration.inputs.is_some_and(|inputs| inputs.fields.contains(&field));
        has(Field::PvSelector) && has(Field::ProcessValue(NumberType::Float)) && configuration.outputs.is_none()
    };
    model.configurations.iter().find(tells).unwrap_or(model.default_configuration)
}

/// A device and where it sits.
#[derive(Clone, Debug)]
struct Gauge {
    spec: Spec,
    volume: Volume,
    /// Measuring parts that sit elsewhere, by their instances.
    elsewhere: Vec<(u8, Volume)>,
}

/// What surrounds a gauge at a volume.
fn around(plant: &Plant, volume: Volume) -> Surroundings {
    Surroundings {
        gas: plant.network.mixture(volume),
        atmosphere_pa: plant.network.atmosphere().pa,
        temperature_k: REFERENCE_K,
    }
}

/// The devices and where they sit, in the order of their addresses.
fn gauges(file: &File, plant: &Plant) -> Result<Vec<Gauge>, Wrong> {
    let mut gauges: Vec<Gauge> = Vec::new();
    for (written, at) in &file.gauges {
        let spec: Spec = words::parsed(written)?;
        spec.build(Memory::volatile(), Baud::B19200).map_err(|error| Wrong::at(&written.span(), error))?;
        let volume = plant.at(at)?;
        gauges.push(Gauge { spec, volume, elsewhere: Vec::new() });
        let specs: Vec<Spec> = gauges.iter().map(|gauge| gauge.spec.clone()).collect();
        check_places(&specs).map_err(|error| Wrong::at(&written.span(), error))?;
    }
    gauges.sort_by_key(|gauge| gauge.spec.place);
    Ok(gauges)
}

/// The measuring parts that sit elsewhere.
fn channels(file: &File, plant: &Plant, gauges: &mut [Gauge]) -> Result<(), Wrong> {
    for (address, channels) in &file.channels {
        let places: Vec<String> = gauges.iter().map(|gauge| gauge.spec.place.to_string()).collect();
        let wrong = || unknown("the address of a gauge", address, places.iter().map(String::as_str));
        let at = places.iter().position(|place| place == address.get_ref()).ok_or_else(wrong)?;
        let Some(gauge) = gauges.get_mut(at) else { continue };
        let unit = gauge.spec.build(Memory::volatile(), Baud::B19200);
        let unit = unit.map_err(|error| Wrong::at(&address.span(), error))?;
        let instances: Vec<String> = unit.instrument().parts().iter().map(|part| part.instance.to_string()).collect();
        for (instance, volume) in channels {
            let wrong = || unknown("an instance of a sensor", instance, instances.iter().map(String::as_str));
            let known =
                instances.iter().find(|known| *known == instance.get_ref()).and_then(|known| known.parse().ok());
            gauge.elsewhere.push((known.ok_or_else(wrong)?, plant.at(volume)?));
        }
    }
    Ok(())
}

/// Whether sensors are as they are bought.
fn real(file: &File) -> Result<bool, Wrong> {
    match &file.sensors {
        None => Ok(true),
        Some(text) if text.get_ref() == "real" => Ok(true),
        Some(text) if text.get_ref() == "ideal" => Ok(false),
        Some(text) => Err(unknown("a kind of sensors", text, ["real", "ideal"].into_iter())),
    }
}
