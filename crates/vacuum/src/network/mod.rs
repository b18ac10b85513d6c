//! A plant: volumes with tubes, valves, pumps, leaks, inlets and walls.

mod step;

use crate::atmosphere::Atmosphere;
use crate::conductance::Conductance;
use crate::gas::{GAS_COUNT, Gas, Mixture};
use crate::permeation::Seal;
use crate::pump::{Capture, Roughing, Turbo};
use crate::series::{PerGas, add};
use crate::surface::Surface;
use step::Step;

/// A volume of a [`Network`]. Like the other handles it belongs to the network that made it: another network takes it for a part of its
/// own, or panics if it has fewer parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Volume(usize);

/// A tube or a valve between two volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Joint(usize);

/// A leak or a vent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Opening(usize);

/// A gas inlet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inlet(usize);

/// A roughing pump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RoughingPump(usize);

/// A turbomolecular pump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TurboPump(usize);

/// A capture pump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CapturePump(usize);

/// A wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wall(usize);

/// The gas outside a leak or a vent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outside {
    /// The present air around the plant.
    Air,
    /// A gas from a bottle.
    Gas(Mixture),
}

/// The state of a gas inlet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Supply {
    /// Closed.
    Closed,
    /// A constant flow, in Pa m³/s.
    Flow(f64),
    /// A regulator that keeps the pressure.
    Pressure {
        /// The set point of the total pressure, in Pa.
        pa: f64,
        /// The flow of the open valve, in Pa m³/s.
        max_flow: f64,
    },
}

/// The balance of each gas, in Pa m³. The entered gas is the sum of the other two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// The initial gas and all gas that has entered since.
    pub entered: Mixture,
    /// The gas that has left through pumps and openings, and the water that walls have adsorbed.
    pub left: Mixture,
    /// The gas in all volumes.
    pub present: Mixture,
}

#[derive(Clone, Debug)]
struct JointState {
    conductance: Conductance,
    /// 0 is closed, 1 is open.
    opening: f64,
}

#[derive(Clone, Debug)]
struct OpeningState {
    at: usize,
    conductance: Conductance,
    outside: Outside,
    opening: f64,
}

#[derive(Clone, Debug)]
struct InletState {
    at: usize,
    gas: Gas,
    supply: Supply,
}

/// A plant.
#[derive(Clone, Debug, Default)]
pub struct Network {
    atmosphere: Atmosphere,
    /// In m³.
    volumes: Vec<f64>,
    joints: Vec<JointState>,
    turbo_pumps: Vec<Turbo>,
    roughing_pumps: Vec<(usize, Roughing)>,
    capture_pumps: Vec<(usize, Capture)>,
    openings: Vec<OpeningState>,
    inlets: Vec<InletState>,
    seals: Vec<(usize, Seal)>,
    surfaces: Vec<(usize, Surface)>,
    /// Further gas sources of each volume, such as gauges, in Pa m³/s.
    loads: Vec<PerGas>,
    /// The pumping speed of the gauges of each volume, in m³/s.
    gauge_speeds: Vec<f64>,
    /// The gas in each volume, in Pa m³.
    amounts: Vec<PerGas>,
    entered: PerGas,
    left: PerGas,
    /// The two volumes of each joint, then those of each turbomolecular pump.
    connections: Vec<(usize, usize)>,
    step: Step,
}

impl Network {
    /// An empty plant in this air.
    #[must_use]
    pub fn new(atmosphere: Atmosphere) -> Self {
        Self { atmosphere, ..Self::default() }
    }

    /// Adds a volume in m³, filled with `gas`.
    pub fn add_volume(&mut self, m3: f64, gas: Mixture) -> Volume {
        let mut amount = [0.0; GAS_COUNT];
        add(&mut amount, gas.as_array(), m3);
        add(&mut self.entered, &amount, 1.0);
        self.volumes.push(m3);
        self.amounts.push(amount);
        self.loads.push([0.0; GAS_COUNT]);
        self.gauge_speeds.push(0.0);
        self.invalidate();
        Volume(self.volumes.len() - 1)
    }

    /// Connects two volumes by an open tube or valve.
    pub fn add_joint(&mut self, one: Volume, other: Volume, conductance: Conductance) -> Joint {
        self.connections.insert(self.joints.len(), (one.0, other.0));
        self.joints.push(JointState { conductance, opening: 1.0 });
        self.invalidate();
        Joint(self.joints.len() - 1)
    }

    /// Adds a turbomolecular pump between two volumes.
    pub fn add_turbo_pump(&mut self, inlet: Volume, fore: Volume, turbo: Turbo) -> TurboPump {
        self.connections.push((inlet.0, fore.0));
        self.turbo_pumps.push(turbo);
        self.invalidate();
        TurboPump(self.turbo_pumps.len() - 1)
    }

    /// Adds a roughing pump to a volume.
    pub fn add_roughing_pump(&mut self, at: Volume, pump: Roughing) -> RoughingPump {
        self.roughing_pumps.push((at.0, pump));
        self.invalidate();
        RoughingPump(self.roughing_pumps.len() - 1)
    }

    /// Adds a capture pump to a volume.
    pub fn add_capture_pump(&mut self, at: Volume, pump: Capture) -> CapturePump {
        self.capture_pumps.push((at.0, pump));
        self.invalidate();
        CapturePump(self.capture_pumps.len() - 1)
    }

    /// Adds a closed leak or vent to a volume.
    pub fn add_opening(&mut self, at: Volume, conductance: Conductance, outside: Outside) -> Opening {
        self.openings.push(OpeningState { at: at.0, conductance, outside, opening: 0.0 });
        self.invalidate();
        Opening(self.openings.len() - 1)
    }

    /// Adds a closed gas inlet to a volume.
    pub fn add_inlet(&mut self, at: Volume, gas: Gas) -> Inlet {
        self.inlets.push(InletState { at: at.0, gas, supply: Supply::Closed });
        self.invalidate();
        Inlet(self.inlets.len() - 1)
    }

    /// Adds a seal between a volume and the air around the plant, in its steady state.
    pub fn add_seal(&mut self, of: Volume, seal: Seal) {
        self.seals.push((of.0, seal));
        self.invalidate();
    }

    /// Adds a wall to a volume.
    pub fn add_wall(&mut self, of: Volume, surface: Surface) -> Wall {
        self.surfaces.push((of.0, surface));
        self.invalidate();
        Wall(self.surfaces.len() - 1)
    }

    /// Sets the opening of a joint, 0 (closed) to 1 (open).
    pub fn set_joint(&mut self, joint: Joint, opening: f64) {
        self.joints[joint.0].opening = opening;
        self.step.current = false;
    }

    /// Sets the opening of a leak or vent, 0 (closed) to 1 (open).
    pub fn set_opening(&mut self, opening: Opening, fraction: f64) {
        self.openings[opening.0].opening = fraction;
        self.step.current = false;
    }

    /// Sets the gas outside a leak or vent, for example the helium of a leak test.
    pub fn set_outside(&mut self, opening: Opening, outside: Outside) {
        self.openings[opening.0].outside = outside;
        self.step.current = false;
    }

    /// Sets the state of a gas inlet.
    pub fn set_inlet(&mut self, inlet: Inlet, supply: Supply) {
        self.inlets[inlet.0].supply = supply;
        self.step.current = false;
    }

    /// Starts or stops a roughing pump. A stopped pump is closed.
    pub fn run_roughing(&mut self, pump: RoughingPump, running: bool) {
        self.roughing_pumps[pump.0].1.running = running;
        self.step.current = false;
    }

    /// Switches the motor of a turbomolecular pump on or off.
    pub fn run_turbo(&mut self, pump: TurboPump, running: bool) {
        self.turbo_pumps[pump.0].running = running;
        self.step.current = false;
    }

    /// Starts or stops a capture pump. A stopped pump keeps its gas.
    pub fn run_capture(&mut self, pump: CapturePump, running: bool) {
        self.capture_pumps[pump.0].1.running = running;
        self.step.current = false;
    }

    /// Empties a capture pump: regeneration.
    pub fn regenerate(&mut self, pump: CapturePump) {
        self.capture_pumps[pump.0].1.captured = Mixture::default();
        self.step.current = false;
    }

    /// Sets the temperature of a wall at once, in K.
    pub fn set_wall_temperature(&mut self, wall: Wall, kelvin: f64) {
        self.surfaces[wall.0].1.set_temperature(kelvin);
    }

    /// Heats or cools a wall to a temperature in K within `seconds`, at a constant rate.
    pub fn heat_wall(&mut self, wall: Wall, kelvin: f64, seconds: f64) {
        self.surfaces[wall.0].1.heat(kelvin, seconds);
    }

    /// Sets the further gas sources of a volume, such as gauges, in Pa m³/s.
    pub fn set_load(&mut self, volume: Volume, flow: &Mixture) {
        self.loads[volume.0] = *flow.as_array();
    }

    /// Sets the pumping speed of the gauges of a volume, in m³/s. Changes of less than 5 % have no effect, because each one costs
    /// a calculation of all rates.
    pub fn set_gauge_speed(&mut self, volume: Volume, m3_per_s: f64) {
        if (self.gauge_speeds[volume.0] - m3_per_s).abs() > 0.05 * m3_per_s {
            self.gauge_speeds[volume.0] = m3_per_s;
            self.step.current = false;
        }
    }

    /// Sets the air around the plant.
    pub fn set_atmosphere(&mut self, atmosphere: Atmosphere) {
        self.atmosphere = atmosphere;
        self.step.current = false;
    }

    /// The air around the plant.
    #[must_use]
    pub const fn atmosphere(&self) -> Atmosphere {
        self.atmosphere
    }

    /// The gas in a volume.
    #[must_use]
    pub fn mixture(&self, volume: Volume) -> Mixture {
        Mixture::from(self.amounts[volume.0].map(|amount| amount / self.volumes[volume.0]))
    }

    /// The opening of a joint, 0 to 1.
    #[must_use]
    pub fn joint_opening(&self, joint: Joint) -> f64 {
        self.joints[joint.0].opening
    }

    /// The opening of a leak or vent, 0 to 1.
    #[must_use]
    pub fn vent_opening(&self, opening: Opening) -> f64 {
        self.openings[opening.0].opening
    }

    /// Whether a roughing pump runs.
    #[must_use]
    pub fn is_roughing_pump_running(&self, pump: RoughingPump) -> bool {
        self.roughing_pumps[pump.0].1.running
    }

    /// A capture pump with the gas that it has captured.
    #[must_use]
    pub fn capture_pump(&self, pump: CapturePump) -> &Capture {
        &self.capture_pumps[pump.0].1
    }

    /// Whether a gas inlet is open.
    #[must_use]
    pub fn is_inlet_open(&self, inlet: Inlet) -> bool {
        self.inlets[inlet.0].supply != Supply::Closed
    }

    /// The speed of the rotor of a turbomolecular pump, 0 to 1.
    #[must_use]
    pub fn rotor_speed(&self, pump: TurboPump) -> f64 {
        self.turbo_pumps[pump.0].rotor
    }

    /// The temperature of a wall, in K.
    #[must_use]
    pub fn wall_temperature_k(&self, wall: Wall) -> f64 {
        self.surfaces[wall.0].1.temperature_k
    }

    /// The gas balance.
    #[must_use]
    pub fn balance(&self) -> Balance {
        let mut present = [0.0; GAS_COUNT];
        self.amounts.iter().for_each(|amount| add(&mut present, amount, 1.0));
        Balance { entered: self.entered.into(), left: self.left.into(), present: present.into() }
    }

    fn invalidate(&mut self) {
        self.step.ready = false;
    }
}
