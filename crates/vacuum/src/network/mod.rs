//! A plant: volumes, what joins them, what fills and what empties them.

mod step;

use crate::atmosphere::Atmosphere;
use crate::conductance::Conductance;
use crate::gas::{GAS_COUNT, Gas, Mixture};
use crate::pump::{Roughing, Turbo};
use crate::series::{PerGas, add};
use crate::surface::Surface;
use step::Step;

/// A volume of a [`Network`].
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

/// A wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wall(usize);

/// What is behind a leak or a vent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outside {
    /// The air around the plant, whatever it is at the time.
    Air,
    /// A bottle.
    Gas(Mixture),
}

/// What a gas inlet lets in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Supply {
    /// Nothing.
    Closed,
    /// A flow, in Pa m^3/s.
    Flow(f64),
    /// As much as keeps the pressure.
    Pressure {
        /// The total pressure to keep, in Pa.
        pa: f64,
        /// What the valve lets in when it is open, in Pa m^3/s.
        most: f64,
    },
}

/// What came, what left, and what is there, by gas in Pa m^3. What came is the sum of the other two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// What was there at the beginning and all that came in since.
    pub entered: Mixture,
    /// What the pumps took, and what flowed out of openings.
    pub left: Mixture,
    /// What is in all volumes.
    pub present: Mixture,
}

#[derive(Clone, Debug)]
struct JointState {
    conductance: Conductance,
    /// 0 closed, 1 open.
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
    /// In m^3.
    volumes: Vec<f64>,
    joins: Vec<JointState>,
    turbos: Vec<Turbo>,
    roughings: Vec<(usize, Roughing)>,
    holes: Vec<OpeningState>,
    feeds: Vec<InletState>,
    surfaces: Vec<(usize, Surface)>,
    /// What gauges and the like give off into each volume, in Pa m^3/s.
    loads: Vec<PerGas>,
    /// What each volume has, in Pa m^3.
    amounts: Vec<PerGas>,
    came: PerGas,
    left: PerGas,
    /// The ends of the joints, then those of the turbos.
    ends: Vec<(usize, usize)>,
    step: Step,
}

impl Network {
    /// A plant of nothing in this air.
    #[must_use]
    pub fn new(atmosphere: Atmosphere) -> Self {
        Self { atmosphere, ..Self::default() }
    }

    /// A volume in m^3, filled with `gas`.
    pub fn add_volume(&mut self, m3: f64, gas: Mixture) -> Volume {
        let mut amount = [0.0; GAS_COUNT];
        add(&mut amount, gas.as_array(), m3);
        add(&mut self.came, &amount, 1.0);
        self.volumes.push(m3);
        self.amounts.push(amount);
        self.loads.push([0.0; GAS_COUNT]);
        self.changed();
        Volume(self.volumes.len() - 1)
    }

    /// Joins two volumes by an open tube or valve.
    pub fn add_joint(&mut self, one: Volume, other: Volume, conductance: Conductance) -> Joint {
        self.ends.insert(self.joins.len(), (one.0, other.0));
        self.joins.push(JointState { conductance, opening: 1.0 });
        self.changed();
        Joint(self.joins.len() - 1)
    }

    /// Puts a turbomolecular pump between two volumes.
    pub fn add_turbo_pump(&mut self, inlet: Volume, fore: Volume, turbo: Turbo) -> TurboPump {
        self.ends.push((inlet.0, fore.0));
        self.turbos.push(turbo);
        self.changed();
        TurboPump(self.turbos.len() - 1)
    }

    /// Puts a roughing pump at a volume.
    pub fn add_roughing_pump(&mut self, at: Volume, pump: Roughing) -> RoughingPump {
        self.roughings.push((at.0, pump));
        self.changed();
        RoughingPump(self.roughings.len() - 1)
    }

    /// A closed leak or vent: a way to what is outside.
    pub fn add_opening(&mut self, at: Volume, conductance: Conductance, outside: Outside) -> Opening {
        self.holes.push(OpeningState { at: at.0, conductance, outside, opening: 0.0 });
        self.changed();
        Opening(self.holes.len() - 1)
    }

    /// A closed gas inlet.
    pub fn add_inlet(&mut self, at: Volume, gas: Gas) -> Inlet {
        self.feeds.push(InletState { at: at.0, gas, supply: Supply::Closed });
        self.changed();
        Inlet(self.feeds.len() - 1)
    }

    /// A wall of a volume.
    pub fn add_wall(&mut self, of: Volume, surface: Surface) -> Wall {
        self.surfaces.push((of.0, surface));
        self.changed();
        Wall(self.surfaces.len() - 1)
    }

    /// Opens a joint as far as 0 (closed) to 1.
    pub fn set_joint(&mut self, joint: Joint, opening: f64) {
        self.joins[joint.0].opening = opening;
        self.step.current = false;
    }

    /// Opens a leak or vent as far as 0 (closed) to 1.
    pub fn set_opening(&mut self, opening: Opening, how_far: f64) {
        self.holes[opening.0].opening = how_far;
        self.step.current = false;
    }

    /// Replaces what is behind a leak or vent.
    pub fn set_outside(&mut self, opening: Opening, outside: Outside) {
        self.holes[opening.0].outside = outside;
        self.step.current = false;
    }

    /// Sets a gas inlet.
    pub fn set_inlet(&mut self, inlet: Inlet, supply: Supply) {
        self.feeds[inlet.0].supply = supply;
        self.step.current = false;
    }

    /// Starts or stops a roughing pump. One that stands is closed.
    pub fn run_roughing(&mut self, pump: RoughingPump, running: bool) {
        self.roughings[pump.0].1.running = running;
        self.step.current = false;
    }

    /// Switches the motor of a turbomolecular pump.
    pub fn run_turbo(&mut self, pump: TurboPump, running: bool) {
        self.turbos[pump.0].running = running;
        self.step.current = false;
    }

    /// Heats a wall, or lets it cool, to so many kelvin.
    pub fn set_wall_temperature(&mut self, wall: Wall, kelvin: f64) {
        self.surfaces[wall.0].1.temperature_k = kelvin;
    }

    /// What gauges and the like give off into a volume from now on, in Pa m^3/s.
    pub fn set_load(&mut self, volume: Volume, flow: &Mixture) {
        self.loads[volume.0] = *flow.as_array();
    }

    /// The air around the plant changes.
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

    /// How far a joint is open.
    #[must_use]
    pub fn joint_opening(&self, joint: Joint) -> f64 {
        self.joins[joint.0].opening
    }

    /// How far a leak or a vent is open.
    #[must_use]
    pub fn vent_opening(&self, opening: Opening) -> f64 {
        self.holes[opening.0].opening
    }

    /// Whether a roughing pump runs.
    #[must_use]
    pub fn is_roughing_pump_running(&self, pump: RoughingPump) -> bool {
        self.roughings[pump.0].1.running
    }

    /// Whether a gas inlet lets something in.
    #[must_use]
    pub fn is_inlet_open(&self, inlet: Inlet) -> bool {
        self.feeds[inlet.0].supply != Supply::Closed
    }

    /// How fast the rotor of a turbomolecular pump turns, 0 to 1.
    #[must_use]
    pub fn rotor_speed(&self, pump: TurboPump) -> f64 {
        self.turbos[pump.0].rotor
    }

    /// The temperature of a wall, in K.
    #[must_use]
    pub fn wall_temperature_k(&self, wall: Wall) -> f64 {
        self.surfaces[wall.0].1.temperature_k
    }

    /// What came, left and is there.
    #[must_use]
    pub fn balance(&self) -> Balance {
        let mut there = [0.0; GAS_COUNT];
        self.amounts.iter().for_each(|amount| add(&mut there, amount, 1.0));
        Balance { entered: self.came.into(), left: self.left.into(), present: there.into() }
    }

    fn changed(&mut self) {
        self.step.ready = false;
    }
}
