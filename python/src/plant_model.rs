//! The physics of a plant: volumes, tubes, pumps, leaks, walls, and the gauges on them. SI units: Pa, m³, m³/s, Pa m³/s, K, s.
//!
//! A part is known by its number. The package makes objects of the parts.

use crate::failure::Failure;
use crate::segment::Segment;
use crate::whole::Whole;
use profivac_vacuum::conductance::SHARP_DISCHARGE;
use profivac_vacuum::gas::GAS_COUNT;
use profivac_vacuum::network::{
    CapturePump, Inlet, Joint, Network, Opening, Outside, RoughingPump, Supply, TurboPump, Volume, Wall,
};
use profivac_vacuum::permeation::Seal;
use profivac_vacuum::pump::{Capture, Roughing, SpeedCurve, Turbo};
use profivac_vacuum::sensor::{Environment, GasExchange, REFERENCE_K};
use profivac_vacuum::surface::{MATERIALS, Material, Surface};
use profivac_vacuum::{Atmosphere, Conductance, Gas, Mixture};
use profivac_virtual::device::VirtualDevice;
use pyo3::prelude::*;
use std::ops::RangeInclusive;
use std::process;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::{Duration, Instant};

/// The longest time without a look at signals. chosen: a user takes it for at once.
const SLICE: Duration = Duration::from_millis(20);

/// The longest time without a look at the line, which a master asks meanwhile. chosen: several of them are shorter than the slot
/// time of a master on a line in memory.
const LINE_SLICE: Duration = Duration::from_millis(1);

/// The longest wait of a forked process for the plant. chosen: some slices.
const FORK_WAIT: Duration = Duration::from_secs(1);

/// The most volumes of a plant, as in a scenario: a step takes the square of their number.
const MOST_VOLUMES: usize = 64;

/// The conductance of a turbomolecular pump that does not turn, as in a scenario: that of a tube of this width and length, in m.
const ROTOR_M: [f64; 2] = [0.03, 0.2];

/// Bounds of the quantities, as in a scenario: wider than any real plant, and narrow enough for every calculation.
mod bounds {
    use std::ops::RangeInclusive;

    pub const PRESSURE_PA: RangeInclusive<f64> = 1e-13..=1e6;
    pub const VOLUME_M3: RangeInclusive<f64> = 1e-9..=1e6;
    pub const LENGTH_M: RangeInclusive<f64> = 1e-6..=1e3;
    pub const AREA_M2: RangeInclusive<f64> = 1e-6..=1e6;
    pub const SPEED_M3_S: RangeInclusive<f64> = 1e-18..=1e6;
    pub const FLOW_PA_M3_S: RangeInclusive<f64> = 0.0..=1e6;
    pub const AMOUNT_PA_M3: RangeInclusive<f64> = 1e-10..=1e8;
    pub const PERMEABILITY_M2_S: RangeInclusive<f64> = 1e-20..=1e-3;
    pub const COMPRESSION: RangeInclusive<f64> = 1.0..=1e15;
    pub const FRACTION: RangeInclusive<f64> = 0.0..=1.0;
    pub const TEMPERATURE_K: RangeInclusive<f64> = 1.0..=2000.0;
    pub const TIME_S: RangeInclusive<f64> = 0.0..=3.2e9;
    pub const POSITIVE_TIME_S: RangeInclusive<f64> = 1e-3..=3.2e9;
    pub const STEP_S: RangeInclusive<f64> = 1e-3..=3600.0;
}

/// A number of a user within its bounds.
fn within(name: &str, value: f64, bounds: RangeInclusive<f64>) -> Result<f64, Failure> {
    if bounds.contains(&value) {
        return Ok(value);
    }
    let (low, high) = bounds.into_inner();
    Err(Failure::usage(format!("expected {name} from {low:e} to {high:e}, got {value}")))
}

fn gas(name: &str) -> Result<Gas, Failure> {
    name.parse().map_err(Failure::usage)
}

/// Values by gas; 0 for the others.
fn by_gas(name: &str, values: &[(String, f64)], bounds: &RangeInclusive<f64>) -> Result<Mixture, Failure> {
    let mut mixture = Mixture::default();
    for (word, value) in values {
        mixture[gas(word)?] = within(&format!("{name} of {word}"), *value, bounds.clone())?;
    }
    Ok(mixture)
}

/// The gases that are there.
fn rows(mixture: Mixture) -> Vec<(String, f64)> {
    mixture.iter().filter(|(_, value)| *value > 0.0).map(|(gas, value)| (gas.to_string(), value)).collect()
}

/// The number of the volume of a gauge, and those of its other measuring parts by instance.
pub type PlaceRow = (usize, Vec<(Whole<u8>, usize)>);

/// A gauge: the setting of its address switch, its volume, and the volumes of its other measuring parts by instance.
pub struct Place {
    address: u8,
    volume: Volume,
    parts: Vec<(u8, Volume)>,
}

impl Place {
    fn of_part(&self, instance: u8) -> Volume {
        self.parts.iter().find(|(known, _)| *known == instance).map_or(self.volume, |(_, volume)| *volume)
    }
}

/// A plant with its gauges over time.
pub struct World {
    network: Network,
    step_s: f64,
    seconds: f64,
    volumes: Vec<Volume>,
    joints: Vec<Joint>,
    openings: Vec<Opening>,
    inlets: Vec<Inlet>,
    roughing_pumps: Vec<RoughingPump>,
    turbo_pumps: Vec<TurboPump>,
    capture_pumps: Vec<CapturePump>,
    walls: Vec<Wall>,
    gauges: Vec<Place>,
}

/// A part by its number. The package gives only numbers of parts.
fn part<T: Copy>(parts: &[T], number: usize) -> Result<T, Failure> {
    parts.get(number).copied().ok_or_else(|| Failure::usage("this part belongs to another plant"))
}

fn added<T>(parts: &mut Vec<T>, part: T) -> usize {
    parts.push(part);
    parts.len().saturating_sub(1)
}

impl World {
    fn volume(&self, number: usize) -> Result<Volume, Failure> {
        part(&self.volumes, number)
    }

    fn two(&self, (one, other): (usize, usize)) -> Result<(Volume, Volume), Failure> {
        if one == other {
            return Err(Failure::usage("expected two different chambers, got the same one twice"));
        }
        Ok((self.volume(one)?, self.volume(other)?))
    }

    fn joint(&mut self, ends: (usize, usize), conductance: Conductance) -> Result<usize, Failure> {
        let (one, other) = self.two(ends)?;
        Ok(added(&mut self.joints, self.network.add_joint(one, other, conductance)))
    }

    fn opening(&mut self, at: usize, conductance: Conductance, outside: Outside) -> Result<usize, Failure> {
        let at = self.volume(at)?;
        Ok(added(&mut self.openings, self.network.add_opening(at, conductance, outside)))
    }

    /// A gas at the pressure of the air; the air itself without a name.
    fn outside(&self, name: Option<&str>) -> Result<Outside, Failure> {
        Ok(match name.map(gas).transpose()? {
            None | Some(Gas::Air) => Outside::Air,
            Some(gas) => Outside::Gas(Mixture::pure(gas, self.network.atmosphere().pressure_pa)),
        })
    }

    fn environment(&self, volume: Volume) -> Environment {
        Environment {
            gas: self.network.mixture(volume),
            atmosphere_pa: self.network.atmosphere().pressure_pa,
            temperature_k: REFERENCE_K,
        }
    }

    /// Puts devices on the plant in place of those before. They begin in the present state of their volumes, and their time is that of
    /// the plant.
    pub fn place(
        &mut self,
        devices: Vec<VirtualDevice>,
        places: &[PlaceRow],
        seed: Option<u64>,
    ) -> Result<Vec<VirtualDevice>, Failure> {
        let mut placed = Vec::new();
        let mut gauges = Vec::new();
        for (mut device, (at, parts)) in devices.into_iter().zip(places) {
            let volume = self.volume(*at)?;
            let instances: Vec<u8> = device.device().parts().iter().map(|part| part.instance).collect();
            let mut elsewhere = Vec::new();
            for (Whole(instance), at) in parts {
                if !instances.contains(instance) {
                    let known = instances.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
                    let name = device.device().name();
                    return Err(Failure::usage(format!("{name} has no part {instance}; it has {known}")));
                }
                let volume = self.volume(*at)?;
                device.set_part_environment(*instance, self.environment(volume));
                elsewhere.push((*instance, volume));
            }
            device.settle_in(self.environment(volume));
            let device = match seed {
                Some(seed) => device.with_real_sensors(seed),
                None => device,
            };
            gauges.push(Place { address: device.switch_address(), volume, parts: elsewhere });
            placed.push(device.with_external_time());
        }
        self.gauges = gauges;
        Ok(placed)
    }

    /// Advances plant and devices by at most `seconds`, until a slice of real time has passed. Returns what is left.
    fn advance(&mut self, seconds: f64, devices: &mut [VirtualDevice], slice: Duration) -> f64 {
        let (begun, mut left) = (Instant::now(), seconds);
        while left > 0.0 {
            // A rest far below a step is the rounding of the subtraction.
            let now = if left < self.step_s * (1.0 + 1e-9) { left } else { self.step_s };
            self.step(now, devices);
            left -= now;
            if begun.elapsed() >= slice {
                break;
            }
        }
        left
    }

    fn step(&mut self, seconds: f64, devices: &mut [VirtualDevice]) {
        self.exchange_gas(devices);
        self.network.advance(seconds);
        self.seconds += seconds;
        for gauge in &self.gauges {
            let Some(device) = devices.iter_mut().find(|device| device.switch_address() == gauge.address) else {
                continue;
            };
            for (instance, volume) in &gauge.parts {
                device.set_part_environment(*instance, self.environment(*volume));
            }
            device.advance_in(self.environment(gauge.volume), seconds);
        }
    }

    /// Gauges release gas, most of all during degas, and pump a little.
    fn exchange_gas(&mut self, devices: &[VirtualDevice]) {
        for volume in &self.volumes {
            let mut all = GasExchange::default();
            for device in devices {
                let place = self.gauges.iter().find(|gauge| gauge.address == device.switch_address());
                let Some(place) = place else { continue };
                for (_, exchange) in device.gas_exchanges().filter(|(instance, _)| place.of_part(*instance) == *volume)
                {
                    all.outgassing += exchange.outgassing;
                    all.speed += exchange.speed;
                }
            }
            self.network.set_load(*volume, &Mixture::pure(Gas::Co, all.outgassing));
            self.network.set_gauge_speed(*volume, all.speed);
        }
    }
}

/// A plant that Python and the thread of its devices share.
#[pyclass(frozen, module = "profivac._profivac")]
pub struct PlantModel {
    world: Arc<Mutex<World>>,
    process: u32,
}

impl PlantModel {
    /// The plant, for the thread of its devices.
    fn shared(&self) -> Arc<Mutex<World>> {
        Arc::clone(&self.world)
    }

    /// Does something with the plant, without the interpreter lock while another thread advances it.
    pub fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut World) -> Result<T, Failure> + Send,
    ) -> PyResult<T> {
        let is_forked = process::id() != self.process;
        Ok(py.detach(|| {
            let mut world = if is_forked { locked_after_fork(&self.world)? } else { locked(&self.world) };
            work(&mut world)
        })?)
    }
}

/// The plant. A poisoned lock is usable: after a panic the program has the error, and the numbers are still numbers.
fn locked(world: &Mutex<World>) -> MutexGuard<'_, World> {
    world.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The plant in a forked process: another thread may have advanced it at the fork, and then no thread ends the step.
fn locked_after_fork(world: &Mutex<World>) -> Result<MutexGuard<'_, World>, Failure> {
    let begun = Instant::now();
    loop {
        match world.try_lock() {
            Ok(world) => return Ok(world),
            Err(TryLockError::Poisoned(error)) => return Ok(error.into_inner()),
            Err(TryLockError::WouldBlock) if begun.elapsed() < FORK_WAIT => thread::sleep(SLICE),
            Err(TryLockError::WouldBlock) => {
                return Err(Failure::usage(
                    "another thread advanced this plant when the process was forked; make another plant in this process",
                ));
            }
        }
    }
}

#[pymethods]
impl PlantModel {
    /// An empty plant in air.
    #[new]
    fn new(air_pa: f64, humidity: f64, step_s: f64) -> PyResult<Self> {
        let atmosphere = Atmosphere {
            pressure_pa: within("air_pa", air_pa, bounds::PRESSURE_PA)?,
            humidity: within("humidity", humidity, bounds::FRACTION)?,
        };
        let world = World {
            network: Network::new(atmosphere),
            step_s: within("step_s", step_s, bounds::STEP_S)?,
            seconds: 0.0,
            volumes: Vec::new(),
            joints: Vec::new(),
            openings: Vec::new(),
            inlets: Vec::new(),
            roughing_pumps: Vec::new(),
            turbo_pumps: Vec::new(),
            capture_pumps: Vec::new(),
            walls: Vec::new(),
            gauges: Vec::new(),
        };
        Ok(Self { world: Arc::new(Mutex::new(world)), process: process::id() })
    }

    /// A volume, filled with air or a gas.
    fn chamber(&self, py: Python<'_>, volume_m3: f64, pressure_pa: Option<f64>, name: &str) -> PyResult<usize> {
        self.with(py, |world| {
            if world.volumes.len() >= MOST_VOLUMES {
                return Err(Failure::usage(format!("expected at most {MOST_VOLUMES} chambers in a plant")));
            }
            let air = world.network.atmosphere().mixture();
            let pa = within("pressure_pa", pressure_pa.unwrap_or_else(|| air.total()), bounds::PRESSURE_PA)?;
            let filled = match gas(name)? {
                Gas::Air => air.scaled(pa / air.total()),
                gas => Mixture::pure(gas, pa),
            };
            let m3 = within("volume_m3", volume_m3, bounds::VOLUME_M3)?;
            Ok(added(&mut world.volumes, world.network.add_volume(m3, filled)))
        })
    }

    /// A round tube between two volumes.
    fn tube(&self, py: Python<'_>, ends: (usize, usize), size_m: (f64, f64), sharp_edged: bool) -> PyResult<usize> {
        let tube = round_tube(size_m, sharp_edged)?;
        self.with(py, |world| world.joint(ends, tube))
    }

    /// A connection of two volumes with a molecular conductance for nitrogen.
    fn conductance(&self, py: Python<'_>, ends: (usize, usize), m3_s: f64) -> PyResult<usize> {
        let conductance = Conductance::fixed(within("conductance_m3_s", m3_s, bounds::SPEED_M3_S)?);
        self.with(py, |world| world.joint(ends, conductance))
    }

    /// A roughing pump. `curve` has the speed at some inlet pressures.
    fn roughing_pump(
        &self,
        py: Python<'_>,
        at: usize,
        speed_m3_s: f64,
        ultimate_pa: f64,
        curve: Vec<(f64, f64)>,
    ) -> PyResult<usize> {
        let speed = within("speed_m3_s", speed_m3_s, bounds::SPEED_M3_S)?;
        let mut points = Vec::new();
        for (pa, at_pa) in curve {
            let factor = within("a speed of the curve", at_pa, bounds::SPEED_M3_S)? / speed;
            points.push((within("a pressure of the curve", pa, bounds::PRESSURE_PA)?, factor));
        }
        points.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        let curve = SpeedCurve::new(&points).map_err(Failure::usage)?;
        let dry = Roughing::dry(speed, within("ultimate_pa", ultimate_pa, bounds::PRESSURE_PA)?);
        self.with(py, |world| {
            let at = world.volume(at)?;
            let pump = world.network.add_roughing_pump(at, Roughing { running: false, curve, ..dry });
            Ok(added(&mut world.roughing_pumps, pump))
        })
    }

    /// A turbomolecular pump: at standstill, or with its final speed.
    #[expect(clippy::too_many_arguments, reason = "the package names each of them")]
    fn turbo_pump(
        &self,
        py: Python<'_>,
        ends: (usize, usize),
        speed_m3_s: f64,
        numbers: (f64, f64, f64),
        speeds: Vec<(String, f64)>,
        compressions: Vec<(String, f64)>,
        runs: bool,
    ) -> PyResult<usize> {
        let (compression, critical_pa, spin_up_s) = numbers;
        let mut turbo = Turbo {
            running: runs,
            rotor: if runs { 1.0 } else { 0.0 },
            compression: within("compression", compression, bounds::COMPRESSION)?,
            critical_pa: within("critical_pa", critical_pa, bounds::PRESSURE_PA)?,
            spin_up_s: within("spin_up_s", spin_up_s, bounds::POSITIVE_TIME_S)?,
            standstill: Conductance::tube(ROTOR_M[0], ROTOR_M[1]),
            ..Turbo::ordinary(within("speed_m3_s", speed_m3_s, bounds::SPEED_M3_S)?)
        };
        for (name, speed) in speeds {
            turbo = turbo.with_speed(gas(&name)?, within("a speed", speed, bounds::SPEED_M3_S)?);
        }
        for (name, compression) in compressions {
            turbo = turbo.with_compression(gas(&name)?, within("a compression", compression, bounds::COMPRESSION)?);
        }
        self.with(py, |world| {
            let (inlet, fore) = world.two(ends)?;
            Ok(added(&mut world.turbo_pumps, world.network.add_turbo_pump(inlet, fore, turbo)))
        })
    }

    /// A stopped capture pump.
    fn capture_pump(
        &self,
        py: Python<'_>,
        at: usize,
        speeds: Vec<(String, f64)>,
        capacities: Vec<(String, f64)>,
        highest_pa: f64,
    ) -> PyResult<usize> {
        let mut unlimited = Mixture::from([f64::INFINITY; GAS_COUNT]);
        for (name, amount) in capacities {
            unlimited[gas(&name)?] = within(&format!("the capacity for {name}"), amount, bounds::AMOUNT_PA_M3)?;
        }
        let pump = Capture {
            speeds: by_gas("the speed", &speeds, &bounds::SPEED_M3_S)?,
            capacities: unlimited,
            highest_pa: within("highest_pa", highest_pa, bounds::PRESSURE_PA)?,
            running: false,
            captured: Mixture::default(),
        };
        self.with(py, |world| {
            let at = world.volume(at)?;
            Ok(added(&mut world.capture_pumps, world.network.add_capture_pump(at, pump)))
        })
    }

    /// A closed leak.
    fn leak(&self, py: Python<'_>, at: usize, flow_pa_m3_s: f64) -> PyResult<usize> {
        let conductance = Conductance::leak(within("flow_pa_m3_s", flow_pa_m3_s, bounds::FLOW_PA_M3_S)?);
        self.with(py, |world| world.opening(at, conductance, Outside::Air))
    }

    /// A closed vent.
    fn vent(
        &self,
        py: Python<'_>,
        at: usize,
        size_m: (f64, f64),
        sharp_edged: bool,
        name: Option<&str>,
    ) -> PyResult<usize> {
        let tube = round_tube(size_m, sharp_edged)?;
        self.with(py, |world| {
            let outside = world.outside(name)?;
            world.opening(at, tube, outside)
        })
    }

    /// A closed gas inlet.
    fn inlet(&self, py: Python<'_>, at: usize, name: &str) -> PyResult<usize> {
        let gas = gas(name)?;
        self.with(py, |world| {
            let at = world.volume(at)?;
            Ok(added(&mut world.inlets, world.network.add_inlet(at, gas)))
        })
    }

    /// A wall that releases gas.
    fn wall(
        &self,
        py: Python<'_>,
        of: usize,
        material: &str,
        area_m2: f64,
        aged_s: f64,
        aged_at_k: f64,
    ) -> PyResult<usize> {
        let found = Material::named(material).ok_or_else(|| {
            let known = MATERIALS.each_ref().map(|material| material.name).join(", ");
            Failure::usage(format!("expected a material, one of {known}, got {material:?}"))
        })?;
        let surface = Surface::fresh(within("area_m2", area_m2, bounds::AREA_M2)?, found)
            .aged(within("aged_s", aged_s, bounds::TIME_S)?, within("aged_at_k", aged_at_k, bounds::TEMPERATURE_K)?);
        self.with(py, |world| {
            let of = world.volume(of)?;
            Ok(added(&mut world.walls, world.network.add_wall(of, surface)))
        })
    }

    /// A seal between a volume and the air.
    fn seal(
        &self,
        py: Python<'_>,
        of: usize,
        area_m2: f64,
        thickness_m: f64,
        permeabilities: Vec<(String, f64)>,
    ) -> PyResult<()> {
        let permeabilities = by_gas("the permeability", &permeabilities, &bounds::PERMEABILITY_M2_S)?;
        let permeabilities: Vec<_> = permeabilities.iter().collect();
        let area = within("area_m2", area_m2, bounds::AREA_M2)?;
        let seal = Seal::new(area, within("thickness_m", thickness_m, bounds::LENGTH_M)?, &permeabilities);
        self.with(py, |world| {
            world.network.add_seal(world.volume(of)?, seal);
            Ok(())
        })
    }

    /// The opening of a tube or valve, 0 to 1.
    fn joint_opening(&self, py: Python<'_>, number: usize) -> PyResult<f64> {
        self.with(py, |world| Ok(world.network.joint_opening(part(&world.joints, number)?)))
    }

    /// Sets the opening of a tube or valve.
    fn set_joint_opening(&self, py: Python<'_>, number: usize, opening: f64) -> PyResult<()> {
        let opening = within("the opening", opening, bounds::FRACTION)?;
        self.with(py, |world| {
            world.network.set_joint(part(&world.joints, number)?, opening);
            Ok(())
        })
    }

    /// The opening of a leak or vent, 0 to 1.
    fn vent_opening(&self, py: Python<'_>, number: usize) -> PyResult<f64> {
        self.with(py, |world| Ok(world.network.vent_opening(part(&world.openings, number)?)))
    }

    /// Sets the opening of a leak or vent.
    fn set_vent_opening(&self, py: Python<'_>, number: usize, opening: f64) -> PyResult<()> {
        let opening = within("the opening", opening, bounds::FRACTION)?;
        self.with(py, |world| {
            world.network.set_opening(part(&world.openings, number)?, opening);
            Ok(())
        })
    }

    /// Sets the gas outside a leak or vent; the air without a name.
    fn set_outside(&self, py: Python<'_>, number: usize, name: Option<&str>) -> PyResult<()> {
        self.with(py, |world| {
            let outside = world.outside(name)?;
            world.network.set_outside(part(&world.openings, number)?, outside);
            Ok(())
        })
    }

    /// Lets gas in: a constant flow, or a regulator for a pressure with the flow of its open valve. Closes the inlet without either.
    fn set_inlet(
        &self,
        py: Python<'_>,
        number: usize,
        flow_pa_m3_s: Option<f64>,
        pressure_pa: Option<f64>,
    ) -> PyResult<()> {
        let flow = flow_pa_m3_s.map(|flow| within("flow_pa_m3_s", flow, bounds::FLOW_PA_M3_S)).transpose()?;
        let pa = pressure_pa.map(|pa| within("pressure_pa", pa, bounds::PRESSURE_PA)).transpose()?;
        let supply = match (flow, pa) {
            (None, _) => Supply::Closed,
            (Some(flow), None) => Supply::Flow(flow),
            (Some(max_flow), Some(pa)) => Supply::Pressure { pa, max_flow },
        };
        self.with(py, |world| {
            world.network.set_inlet(part(&world.inlets, number)?, supply);
            Ok(())
        })
    }

    /// Starts or stops a roughing pump.
    fn run_roughing(&self, py: Python<'_>, number: usize, runs: bool) -> PyResult<()> {
        self.with(py, |world| {
            world.network.run_roughing(part(&world.roughing_pumps, number)?, runs);
            Ok(())
        })
    }

    /// Switches the motor of a turbomolecular pump.
    fn run_turbo(&self, py: Python<'_>, number: usize, runs: bool) -> PyResult<()> {
        self.with(py, |world| {
            world.network.run_turbo(part(&world.turbo_pumps, number)?, runs);
            Ok(())
        })
    }

    /// The speed of the rotor, 0 to 1.
    fn rotor_speed(&self, py: Python<'_>, number: usize) -> PyResult<f64> {
        self.with(py, |world| Ok(world.network.rotor_speed(part(&world.turbo_pumps, number)?)))
    }

    /// Starts or stops a capture pump.
    fn run_capture(&self, py: Python<'_>, number: usize, runs: bool) -> PyResult<()> {
        self.with(py, |world| {
            world.network.run_capture(part(&world.capture_pumps, number)?, runs);
            Ok(())
        })
    }

    /// Empties a capture pump.
    fn regenerate(&self, py: Python<'_>, number: usize) -> PyResult<()> {
        self.with(py, |world| {
            world.network.regenerate(part(&world.capture_pumps, number)?);
            Ok(())
        })
    }

    /// The gas in a capture pump, in Pa m³.
    fn captured(&self, py: Python<'_>, number: usize) -> PyResult<Vec<(String, f64)>> {
        self.with(py, |world| Ok(rows(world.network.capture_pump(part(&world.capture_pumps, number)?).captured)))
    }

    /// Heats or cools a wall.
    fn heat(&self, py: Python<'_>, number: usize, kelvin: f64, seconds: f64) -> PyResult<()> {
        let kelvin = within("temperature_k", kelvin, bounds::TEMPERATURE_K)?;
        let seconds = within("seconds", seconds, bounds::TIME_S)?;
        self.with(py, |world| {
            let wall = part(&world.walls, number)?;
            if seconds > 0.0 {
                world.network.heat_wall(wall, kelvin, seconds);
            } else {
                world.network.set_wall_temperature(wall, kelvin);
            }
            Ok(())
        })
    }

    /// The temperature of a wall in K.
    fn temperature(&self, py: Python<'_>, number: usize) -> PyResult<f64> {
        self.with(py, |world| Ok(world.network.wall_temperature_k(part(&world.walls, number)?)))
    }

    /// The partial pressures in a volume, in Pa.
    fn gases(&self, py: Python<'_>, number: usize) -> PyResult<Vec<(String, f64)>> {
        self.with(py, |world| Ok(rows(world.network.mixture(world.volume(number)?))))
    }

    /// The pressure in a volume, in Pa.
    fn pressure(&self, py: Python<'_>, number: usize) -> PyResult<f64> {
        self.with(py, |world| Ok(world.network.mixture(world.volume(number)?).total()))
    }

    /// The gas that entered, left and is present, in Pa m³.
    fn balance(&self, py: Python<'_>) -> PyResult<[Vec<(String, f64)>; 3]> {
        self.with(py, |world| {
            let balance = world.network.balance();
            Ok([balance.entered, balance.left, balance.present].map(rows))
        })
    }

    /// The time since the start, in s.
    fn seconds(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |world| Ok(world.seconds))
    }

    /// Lets time pass for the plant and the devices of the segment. Ctrl-C ends it after the present slice.
    fn advance(&self, py: Python<'_>, seconds: f64, segment: Option<PyRef<'_, Segment>>) -> PyResult<()> {
        let mut left = within("seconds", seconds, bounds::TIME_S)?;
        while left > 0.0 {
            let world = self.shared();
            left = match &segment {
                Some(segment) => {
                    segment.run(py, move |devices| Ok(locked(&world).advance(left, devices, LINE_SLICE)))?
                }
                None => self.with(py, |world| Ok(world.advance(left, &mut [], SLICE)))?,
            };
            py.check_signals()?;
        }
        Ok(())
    }
}

/// A round tube of a diameter and a length in m, with rounded or sharp edges.
fn round_tube((diameter_m, length_m): (f64, f64), sharp_edged: bool) -> Result<Conductance, Failure> {
    let discharge = if sharp_edged { SHARP_DISCHARGE } else { 1.0 };
    let diameter_m = within("diameter_m", diameter_m, bounds::LENGTH_M)?;
    Ok(Conductance::tube_with_discharge(diameter_m, within("length_m", length_m, bounds::LENGTH_M)?, discharge))
}
