//! Builds the plant of a scenario from the parts of `profivac_vacuum`.

use super::error::{ScenarioEntryError, TextError};
use super::quantities::{
    AMOUNT, AREA, LENGTH, PART, PERMEABILITY, SPEED, TIME, VOLUME, flow, gas_pressure, parsed, temperature, unknown,
};
use profivac_scenario_file::{
    Capture, File, Inlet, Leak, Pocket, Roughing, Seal, Text, Tube, Turbo, Vent, Volume, Wall,
};
use profivac_vacuum::atmosphere::ROOM_K;
use profivac_vacuum::conductance::SHARP_DISCHARGE;
use profivac_vacuum::gas::GAS_COUNT;
use profivac_vacuum::network::{self, Network, Outside};
use profivac_vacuum::permeation;
use profivac_vacuum::surface::{MATERIALS, Material, Surface};
use profivac_vacuum::{Atmosphere, Conductance, Gas, Mixture, pump};
use std::collections::BTreeMap;
use toml::Spanned;

/// The conductance of a turbomolecular pump that does not turn: that of a tube of this width and length, in m. chosen
const ROTOR_M: [f64; 2] = [0.03, 0.2];

/// The highest compression, and the highest number of volumes including virtual leaks. chosen
const HIGHEST_COMPRESSION: f64 = 1e15;
const MOST_VOLUMES: usize = 64;

/// A part of a plant that can be operated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A tube or a valve.
    Joint(network::Joint),
    /// A leak or a vent.
    Opening(network::Opening),
    /// A roughing pump.
    Roughing(network::RoughingPump),
    /// A turbomolecular pump.
    Turbo(network::TurboPump),
    /// A capture pump.
    Capture(network::CapturePump),
    /// A gas inlet.
    Inlet(network::Inlet),
    /// A wall.
    Wall(network::Wall),
}

/// A plant with the names of its parts.
#[derive(Clone, Debug)]
pub struct Plant {
    /// The network.
    pub network: Network,
    /// The volumes by name.
    pub volumes: BTreeMap<String, network::Volume>,
    /// The parts that can be operated, by name.
    pub parts: BTreeMap<String, Part>,
}

impl Plant {
    /// Builds the plant of a file.
    pub fn new(file: &File) -> Result<Self, TextError> {
        let atmosphere = air(file.atmosphere.as_ref(), Atmosphere::default())?;
        let mut plant = Self { network: Network::new(atmosphere), volumes: BTreeMap::new(), parts: BTreeMap::new() };
        let mut volumes = file.volumes.values().map(Spanned::span).chain(file.pockets.values().map(Spanned::span));
        if let Some(span) = volumes.nth(MOST_VOLUMES) {
            return Err(TextError::at(&span, ScenarioEntryError::TooManyVolumes(MOST_VOLUMES)));
        }
        each(&file.volumes, |name, volume| plant.volume(name, volume))?;
        each(&file.walls, |name, wall| plant.wall(name, wall))?;
        each(&file.tubes, |name, tube| plant.tube(name, tube))?;
        each(&file.valves, |name, valve| plant.tube(name, valve))?;
        each(&file.pockets, |name, pocket| plant.pocket(name, pocket))?;
        each(&file.roughing_pumps, |name, pump| plant.roughing(name, pump))?;
        each(&file.turbo_pumps, |name, pump| plant.turbo(name, pump))?;
        each(&file.capture_pumps, |name, pump| plant.capture(name, pump))?;
        each(&file.leaks, |name, leak| plant.leak(name, leak))?;
        each(&file.vents, |name, vent| plant.vent(name, vent))?;
        each(&file.inlets, |name, inlet| plant.inlet(name, inlet))?;
        each(&file.seals, |_, seal| plant.seal(seal))?;
        Ok(plant)
    }

    /// The volume of this name.
    pub fn at(&self, name: &Text) -> Result<network::Volume, TextError> {
        let known = || self.volumes.keys().map(String::as_str);
        self.volumes.get(name.get_ref()).copied().ok_or_else(|| unknown("a volume", name, known()))
    }

    /// The part of this name, if `pick` accepts it.
    pub fn part<T>(&self, what: &'static str, name: &Text, pick: impl Fn(Part) -> Option<T>) -> Result<T, TextError> {
        let known = self.parts.iter().filter(|(_, part)| pick(**part).is_some()).map(|(name, _)| name.as_str());
        self.parts.get(name.get_ref()).copied().and_then(&pick).ok_or_else(|| unknown(what, name, known))
    }

    fn add(&mut self, name: &str, span: &Spanned<impl Sized>, part: Part) -> Result<(), TextError> {
        match self.parts.insert(name.to_owned(), part) {
            None => Ok(()),
            Some(_) => Err(TextError::at(&span.span(), ScenarioEntryError::DuplicateName(name.to_owned()))),
        }
    }

    /// Two different volumes.
    fn two(&self, one: &Text, other: &Text) -> Result<(network::Volume, network::Volume), TextError> {
        let (first, second) = (self.at(one)?, self.at(other)?);
        let same = || ScenarioEntryError::SameVolume(other.get_ref().clone());
        if first == second { Err(TextError::at(&other.span(), same())) } else { Ok((first, second)) }
    }

    fn volume(&mut self, name: &str, volume: &Spanned<Volume>) -> Result<(), TextError> {
        let Volume { volume, gas, pressure } = volume.get_ref();
        let air = self.network.atmosphere().mixture();
        let pa = pressure.as_ref().map(gas_pressure).transpose()?.unwrap_or_else(|| air.total());
        let filled = match gas.as_ref().map(parsed).transpose()? {
            None | Some(Gas::Air) => air.scaled(pa / air.total()),
            Some(gas) => Mixture::pure(gas, pa),
        };
        let made = self.network.add_volume(VOLUME.positive(volume)?, filled);
        self.volumes.insert(name.to_owned(), made);
        Ok(())
    }

    fn wall(&mut self, name: &str, wall: &Spanned<Wall>) -> Result<(), TextError> {
        let Wall { of, material, area, aged, aged_at } = wall.get_ref();
        let known = || MATERIALS.iter().map(|material| material.name);
        let made = Material::named(material.get_ref()).ok_or_else(|| unknown("a material", material, known()))?;
        let mut surface = Surface::fresh(AREA.positive(area)?, made);
        if let Some(aged) = aged {
            let kelvin = aged_at.as_ref().map(temperature).transpose()?.unwrap_or(ROOM_K);
            surface = surface.aged(TIME.parse(aged)?, kelvin);
        }
        let of = self.at(of)?;
        let made = self.network.add_wall(of, surface);
        self.add(name, wall, Part::Wall(made))
    }

    fn tube(&mut self, name: &str, tube: &Spanned<Tube>) -> Result<(), TextError> {
        let Tube { between: [one, other], diameter, length, conductance, sharp_edged, open } = tube.get_ref();
        let conductance = match (diameter, length, conductance) {
            (Some(diameter), Some(length), None) => round_tube(diameter, length, *sharp_edged)?,
            (None, None, Some(conductance)) if !sharp_edged => Conductance::fixed(SPEED.positive(conductance)?),
            _ => return Err(TextError::at(&tube.span(), ScenarioEntryError::NoConductance)),
        };
        let (one, other) = self.two(one, other)?;
        let made = self.network.add_joint(one, other, conductance);
        self.network.set_joint(made, if open.unwrap_or(true) { 1.0 } else { 0.0 });
        self.add(name, tube, Part::Joint(made))
    }

    fn pocket(&mut self, name: &str, pocket: &Spanned<Pocket>) -> Result<(), TextError> {
        let Pocket { of, volume, conductance } = pocket.get_ref();
        let air = self.network.atmosphere().mixture();
        let of = self.at(of)?;
        let inside = self.network.add_volume(VOLUME.positive(volume)?, air);
        let made = self.network.add_joint(of, inside, Conductance::viscous(SPEED.positive(conductance)?));
        self.add(name, pocket, Part::Joint(made))
    }

    fn roughing(&mut self, name: &str, pump: &Spanned<Roughing>) -> Result<(), TextError> {
        let Roughing { at, speed, ultimate, speed_at, running } = pump.get_ref();
        let nominal = SPEED.positive(speed)?;
        let points = speed_at.iter().map(|(pa, speed)| Ok((gas_pressure(pa)?, SPEED.positive(speed)? / nominal)));
        let mut points = points.collect::<Result<Vec<_>, TextError>>()?;
        points.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        let wrong = |error| TextError::at(&pump.span(), ScenarioEntryError::SpeedCurve(error));
        let made = pump::Roughing {
            running: *running,
            curve: pump::SpeedCurve::new(&points).map_err(wrong)?,
            ..pump::Roughing::dry(nominal, gas_pressure(ultimate)?)
        };
        let at = self.at(at)?;
        let made = self.network.add_roughing_pump(at, made);
        self.add(name, pump, Part::Roughing(made))
    }

    fn turbo(&mut self, name: &str, pump: &Spanned<Turbo>) -> Result<(), TextError> {
        let Turbo { inlet, fore, speed, compression, speeds, compressions, critical_pressure, spin_up, running } =
            pump.get_ref();
        let mut turbo = pump::Turbo::ordinary(SPEED.positive(speed)?);
        turbo.standstill = Conductance::tube(ROTOR_M[0], ROTOR_M[1]);
        turbo.running = *running;
        // A pump that runs at the beginning has been running for long.
        turbo.rotor = if *running { 1.0 } else { 0.0 };
        if let Some(compression) = compression {
            turbo.compression = self::compression(compression)?;
        }
        for (gas, speed) in speeds {
            turbo = turbo.with_speed(parsed(gas)?, SPEED.positive(speed)?);
        }
        for (gas, compression) in compressions {
            turbo = turbo.with_compression(parsed(gas)?, self::compression(compression)?);
        }
        if let Some(pressure) = critical_pressure {
            turbo.critical_pa = gas_pressure(pressure)?;
        }
        if let Some(time) = spin_up {
            turbo.spin_up_s = TIME.positive(time)?;
        }
        let (inlet, fore) = self.two(inlet, fore)?;
        let made = self.network.add_turbo_pump(inlet, fore, turbo);
        self.add(name, pump, Part::Turbo(made))
    }

    fn capture(&mut self, name: &str, pump: &Spanned<Capture>) -> Result<(), TextError> {
        let Capture { at, speeds, capacities, highest_pressure, running } = pump.get_ref();
        let mut made = pump::Capture {
            speeds: Mixture::default(),
            capacities: Mixture::from([f64::INFINITY; GAS_COUNT]),
            highest_pa: gas_pressure(highest_pressure)?,
            running: *running,
            captured: Mixture::default(),
        };
        for (gas, speed) in speeds {
            made.speeds[parsed::<Gas>(gas)?] = SPEED.positive(speed)?;
        }
        for (gas, amount) in capacities {
            made.capacities[parsed::<Gas>(gas)?] = AMOUNT.positive(amount)?;
        }
        let at = self.at(at)?;
        let made = self.network.add_capture_pump(at, made);
        self.add(name, pump, Part::Capture(made))
    }

    fn leak(&mut self, name: &str, leak: &Spanned<Leak>) -> Result<(), TextError> {
        let Leak { at, rate, open } = leak.get_ref();
        let conductance = Conductance::leak(flow(rate)?);
        let at = self.at(at)?;
        let made = self.network.add_opening(at, conductance, Outside::Air);
        self.network.set_opening(made, if *open { 1.0 } else { 0.0 });
        self.add(name, leak, Part::Opening(made))
    }

    fn vent(&mut self, name: &str, vent: &Spanned<Vent>) -> Result<(), TextError> {
        let Vent { at, diameter, length, sharp_edged, gas, open } = vent.get_ref();
        let conductance = round_tube(diameter, length, *sharp_edged)?;
        let outside = match gas.as_ref().map(parsed).transpose()? {
            None | Some(Gas::Air) => Outside::Air,
            Some(gas) => Outside::Gas(Mixture::pure(gas, self.network.atmosphere().pressure_pa)),
        };
        let at = self.at(at)?;
        let made = self.network.add_opening(at, conductance, outside);
        self.network.set_opening(made, if *open { 1.0 } else { 0.0 });
        self.add(name, vent, Part::Opening(made))
    }

    fn inlet(&mut self, name: &str, inlet: &Spanned<Inlet>) -> Result<(), TextError> {
        let Inlet { at, gas } = inlet.get_ref();
        let (at, gas) = (self.at(at)?, parsed(gas)?);
        let made = self.network.add_inlet(at, gas);
        self.add(name, inlet, Part::Inlet(made))
    }

    fn seal(&mut self, seal: &Spanned<Seal>) -> Result<(), TextError> {
        let Seal { of, area, thickness, permeabilities } = seal.get_ref();
        let by_gas = permeabilities.iter().map(|(gas, written)| Ok((parsed(gas)?, PERMEABILITY.positive(written)?)));
        let by_gas = by_gas.collect::<Result<Vec<(Gas, f64)>, TextError>>()?;
        let of = self.at(of)?;
        self.network.add_seal(of, permeation::Seal::new(AREA.positive(area)?, LENGTH.positive(thickness)?, &by_gas));
        Ok(())
    }
}

/// A round tube with rounded or sharp edges.
fn round_tube(diameter: &Text, length: &Text, sharp_edged: bool) -> Result<Conductance, TextError> {
    let discharge = if sharp_edged { SHARP_DISCHARGE } else { 1.0 };
    Ok(Conductance::tube_with_discharge(LENGTH.positive(diameter)?, LENGTH.positive(length)?, discharge))
}

/// A compression within its limits.
fn compression(written: &Spanned<f64>) -> Result<f64, TextError> {
    let compression = *written.get_ref();
    let wrong = || TextError::at(&written.span(), ScenarioEntryError::Compression(compression));
    if (1.0..=HIGHEST_COMPRESSION).contains(&compression) { Ok(compression) } else { Err(wrong()) }
}

/// Applies a function to each part, in the order of the names.
fn each<T>(
    parts: &BTreeMap<String, Spanned<T>>,
    mut make: impl FnMut(&str, &Spanned<T>) -> Result<(), TextError>,
) -> Result<(), TextError> {
    parts.iter().try_for_each(|(name, part)| make(name, part))
}

/// The air outside; missing keys keep the value before.
pub fn air(air: Option<&profivac_scenario_file::Air>, before: Atmosphere) -> Result<Atmosphere, TextError> {
    let Some(air) = air else { return Ok(before) };
    let pa = air.pressure.as_ref().map(gas_pressure).transpose()?.unwrap_or(before.pressure_pa);
    let humidity = match &air.humidity {
        None => before.humidity,
        Some(text) => PART.parse(text)?,
    };
    Ok(Atmosphere { pressure_pa: pa, humidity })
}
