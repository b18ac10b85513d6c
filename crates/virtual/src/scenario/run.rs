//! Runs a scenario step by step.

use super::event::{Check, DeviceAction, Event, Expectation, ScenarioAction, Subject};
use super::plant::{Part, Plant};
use super::{Gauge, Scenario, environment};
use crate::device::VirtualDevice;
use crate::gsd_slave::GsdStation;
use crate::memory_segment::MemorySegment;
use profivac_devices::StateReport;
use profivac_dp::slave::Relation;
use profivac_vacuum::sensor::GasExchange;
use profivac_vacuum::{Gas, Mixture};
use std::fmt;

/// Whether a master exchanges data with the devices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MasterPresence {
    /// A master is present or may come: devices measure while they exchange data.
    Present,
    /// No master: devices measure as if they exchanged data.
    Absent,
}

/// An expectation that was not met.
#[derive(Clone, Debug, PartialEq)]
pub struct FailedExpectation {
    /// The file.
    pub file: String,
    /// The line of the expectation; `None` for an action that a device refused.
    pub line: Option<usize>,
    /// The time in s.
    pub seconds: f64,
    /// The expected and the found state.
    pub description: String,
}

impl fmt::Display for FailedExpectation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, line, seconds, description } = self;
        match line {
            Some(line) => write!(f, "{file}:{line}: after {seconds} s: {description}"),
            None => write!(f, "{file}: after {seconds} s: {description}"),
        }
    }
}

/// The state of a part of a plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PartState {
    /// A tube, valve, leak, vent or inlet is open.
    Open,
    /// It is closed.
    Closed,
    /// A pump runs.
    Running,
    /// A pump does not run.
    Stopped,
    /// The speed of a rotor as a fraction of its rated speed.
    RotorSpeed(f64),
    /// The temperature of a wall, in K.
    Temperature(f64),
}

impl PartState {
    const fn open(is_open: bool) -> Self {
        if is_open { Self::Open } else { Self::Closed }
    }

    const fn running(is_running: bool) -> Self {
        if is_running { Self::Running } else { Self::Stopped }
    }
}

impl fmt::Display for PartState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open => f.write_str("open"),
            Self::Closed => f.write_str("closed"),
            Self::Running => f.write_str("runs"),
            Self::Stopped => f.write_str("stands"),
            Self::RotorSpeed(fraction) => write!(f, "{:.0} %", fraction * 100.0),
            Self::Temperature(kelvin) => write!(f, "{:.0} C", kelvin - 273.15),
        }
    }
}

/// A run of a scenario.
#[derive(Clone, Debug)]
pub struct Run {
    file: String,
    plant: Plant,
    /// The devices and their volumes.
    gauges: Vec<Gauge>,
    /// The remaining events, the last first.
    events: Vec<Event>,
    step_s: f64,
    steps: u64,
    last: u64,
    bus: MasterPresence,
    noise: f64,
    message: Option<String>,
    failures: Vec<FailedExpectation>,
}

impl Run {
    pub(super) fn new(scenario: &Scenario, bus: MasterPresence) -> Self {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of steps, never negative")]
        let last = (scenario.until_s / scenario.step_s).round() as u64;
        Self {
            file: scenario.name.clone(),
            plant: scenario.plant.clone(),
            gauges: scenario.gauges.clone(),
            events: scenario.events.iter().rev().cloned().collect(),
            step_s: scenario.step_s,
            steps: 0,
            last,
            bus,
            noise: 0.0,
            message: None,
            failures: Vec::new(),
        }
    }

    /// The time since the start, in s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.steps as f64 * self.step_s
    }

    /// The length of a step, in s.
    #[must_use]
    pub const fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Whether the last step is done.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.steps > self.last
    }

    /// The last message of the timeline.
    #[must_use]
    pub fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// The probability with which noise damages an octet on the bus, 0 to 1.
    #[must_use]
    pub const fn noise(&self) -> f64 {
        self.noise
    }

    /// The expectations that were not met so far.
    #[must_use]
    pub fn failures(&self) -> &[FailedExpectation] {
        &self.failures
    }

    /// The plant.
    #[must_use]
    pub const fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Executes the events that are due and advances plant and devices by a step. After the end plant and devices go on
    /// without events.
    pub fn step<'d>(&mut self, devices: impl IntoIterator<Item = &'d mut VirtualDevice>) {
        self.step_with(devices, []);
    }

    /// The same with slaves by their GSD files, to which events give orders.
    pub fn step_with<'d>(
        &mut self,
        devices: impl IntoIterator<Item = &'d mut VirtualDevice>,
        slaves: impl IntoIterator<Item = &'d mut GsdStation>,
    ) {
        let mut devices: Vec<&mut VirtualDevice> = devices.into_iter().collect();
        let mut slaves: Vec<&mut GsdStation> = slaves.into_iter().collect();
        if self.steps == 0 && self.bus == MasterPresence::Absent {
            devices.iter_mut().for_each(|device| device.device_mut().set_exchanging(true));
        }
        while self.events.last().is_some_and(|event| event.step <= self.steps)
            && let Some(event) = self.events.pop()
        {
            self.execute(event, &mut devices, &mut slaves);
        }
        self.exchange_gas(&devices);
        self.plant.network.advance(self.step_s);
        self.steps = self.steps.saturating_add(1);
        for device in devices {
            let address = device.switch_address();
            if let Some(gauge) = self.gauges.iter().find(|gauge| gauge.spec.address == address) {
                for (instance, volume) in &gauge.channel_volumes {
                    device.set_part_environment(*instance, environment(&self.plant, *volume));
                }
                device.advance_in(environment(&self.plant, gauge.volume), self.step_s);
            }
        }
    }

    /// Runs up to `seconds` with a segment in memory. If the line is ahead because a request was answered on it, it stays
    /// ahead and does not wait for the plant.
    pub fn step_segment(&mut self, segment: &mut MemorySegment, seconds: f64) {
        let ahead = segment.seconds() - self.seconds();
        let ahead = if ahead > self.step_s { ahead } else { 0.0 };
        while self.seconds() + self.step_s <= seconds {
            let (devices, slaves) = segment.stations_mut();
            self.step_with(devices, slaves);
            segment.set_noise(self.noise);
            segment.run_until(self.seconds() + ahead);
        }
    }

    /// Gauges release gas, most of all during degas, and pump a little.
    fn exchange_gas(&mut self, devices: &[&mut VirtualDevice]) {
        for volume in self.plant.volumes.values() {
            let mut all = GasExchange::default();
            for device in devices {
                let Some(gauge) = self.gauges.iter().find(|gauge| gauge.spec.address == device.switch_address()) else {
                    continue;
                };
                for (instance, exchange) in device.gas_exchanges() {
                    let elsewhere = gauge.channel_volumes.iter().find(|(channel, _)| *channel == instance);
                    if elsewhere.map_or(gauge.volume, |(_, volume)| *volume) == *volume {
                        all.outgassing += exchange.outgassing;
                        all.speed += exchange.speed;
                    }
                }
            }
            self.plant.network.set_load(*volume, &Mixture::pure(Gas::Co, all.outgassing));
            self.plant.network.set_gauge_speed(*volume, all.speed);
        }
    }

    /// Checks the expectations of an event, then executes its actions.
    fn execute(&mut self, event: Event, devices: &mut [&mut VirtualDevice], slaves: &mut [&mut GsdStation]) {
        for expectation in &event.expectations {
            let failed = expectation.checks.iter().filter_map(|check| self.failed(expectation, check, devices, slaves));
            let failed: Vec<_> = failed.collect();
            failed.into_iter().for_each(|what| self.fail(Some(expectation.line), what));
        }
        self.message = event.message.or(self.message.take());
        event.actions.into_iter().for_each(|action| self.action(action, devices, slaves));
    }

    fn fail(&mut self, line: Option<usize>, description: String) {
        let (file, seconds) = (self.file.clone(), self.seconds());
        self.failures.push(FailedExpectation { file, line, seconds, description });
    }

    fn action(&mut self, action: ScenarioAction, devices: &mut [&mut VirtualDevice], slaves: &mut [&mut GsdStation]) {
        let slave_at = |address: u8| move |slave: &&mut &mut GsdStation| slave.switch_address() == address;
        let network = &mut self.plant.network;
        match action {
            ScenarioAction::Joint(joint, how_far) => network.set_joint(joint, how_far),
            ScenarioAction::Opening(opening, how_far) => network.set_opening(opening, how_far),
            ScenarioAction::Roughing(pump, running) => network.run_roughing(pump, running),
            ScenarioAction::Turbo(pump, running) => network.run_turbo(pump, running),
            ScenarioAction::Capture(pump, running) => network.run_capture(pump, running),
            ScenarioAction::Feed(inlet, supply) => network.set_inlet(inlet, supply),
            ScenarioAction::Heat(wall, kelvin, seconds) => network.heat_wall(wall, kelvin, seconds),
            ScenarioAction::Spray(leak, outside) => network.set_outside(leak, outside),
            ScenarioAction::Regenerate(pump) => network.regenerate(pump),
            ScenarioAction::Noise(part) => self.noise = part,
            ScenarioAction::Air(atmosphere) => network.set_atmosphere(atmosphere),
            ScenarioAction::Order(address, order) => {
                // The order was tried when the file was parsed; together with others it may be too much.
                let refused = slaves.iter_mut().find(slave_at(address)).map(|slave| slave.execute(&order));
                if let Some(Err(refused)) = refused {
                    self.fail(None, format!("slave {address}: {refused}"));
                }
            }
            ScenarioAction::Device(address, action) => {
                if let Some(slave) = slaves.iter_mut().find(slave_at(address)) {
                    match action {
                        DeviceAction::Power(on) => slave.set_power(on),
                        DeviceAction::Connector(connected) => slave.set_connected(connected),
                        _ => {}
                    }
                }
                let device = devices.iter_mut().find(|device| device.switch_address() == address);
                let refused = device.and_then(|device| self.operate(device, &action));
                refused.into_iter().for_each(|what| self.fail(None, what));
            }
        }
    }

    /// Executes an action on a device. Reports a refusal as a failure.
    fn operate(&self, device: &mut VirtualDevice, action: &DeviceAction) -> Option<String> {
        match action {
            DeviceAction::Power(on) => {
                device.set_power(*on);
                if self.bus == MasterPresence::Absent && *on {
                    device.device_mut().set_exchanging(true);
                }
            }
            DeviceAction::Connector(connected) => device.set_connected(*connected),
            DeviceAction::Write(slot, index, octets) => {
                let written = device.device_mut().write(Relation::Ms2(0), *slot, *index, octets);
                let name = title(device);
                return written.err().map(|refusal| {
                    format!("expected {name} to take {octets:?} in slot {slot} index {index}, it refused: {refusal:?}")
                });
            }
            _ => {
                // The action was tried when the file was parsed.
                let _ = action.action().map(|action| device.operate_text(action));
            }
        }
        None
    }

    /// The difference from an expectation, if there is one.
    fn failed(
        &self,
        expectation: &Expectation,
        check: &Check,
        devices: &[&mut VirtualDevice],
        slaves: &[&mut GsdStation],
    ) -> Option<String> {
        match (&expectation.subject, check) {
            (Subject::Volume(name, volume), Check::Pressure(above, below)) => {
                outside(name, "have", self.plant.network.mixture(*volume).total(), *above, *below)
            }
            (Subject::Slave(address), Check::Exchanging(expected)) => {
                let slave = slaves.iter().find(|slave| slave.switch_address() == *address)?;
                let found = slave.is_exchanging();
                (found != *expected)
                    .then(|| format!("expected the data exchange of slave {address} to be {expected}, got {found}"))
            }
            (Subject::Volume(..) | Subject::Slave(_), _) => None,
            (Subject::Device(address, instance), check) => {
                let device = devices.iter().find(|device| device.switch_address() == *address)?;
                shown_otherwise(device, *instance, check)
            }
        }
    }

    /// The states of the parts of the plant, with their names.
    #[must_use]
    pub fn states(&self) -> Vec<(&str, PartState)> {
        let network = &self.plant.network;
        let state = |part: &Part| match part {
            Part::Joint(joint) => PartState::open(network.joint_opening(*joint) > 0.0),
            Part::Opening(opening) => PartState::open(network.vent_opening(*opening) > 0.0),
            Part::Roughing(pump) => PartState::running(network.is_roughing_pump_running(*pump)),
            Part::Turbo(pump) => PartState::RotorSpeed(network.rotor_speed(*pump)),
            Part::Capture(pump) => PartState::running(network.capture_pump(*pump).running),
            Part::Inlet(inlet) => PartState::open(network.is_inlet_open(*inlet)),
            Part::Wall(wall) => PartState::Temperature(network.wall_temperature_k(*wall)),
        };
        self.plant.parts.iter().map(|(name, part)| (name.as_str(), state(part))).collect()
    }

    /// The true pressures of the volumes, in Pa.
    pub fn pressures(&self) -> impl Iterator<Item = (&str, f64)> {
        let volumes = self.plant.volumes.iter();
        volumes.map(|(name, volume)| (name.as_str(), self.plant.network.mixture(*volume).total()))
    }
}

fn title(device: &VirtualDevice) -> String {
    format!("{}@{}", device.device().name(), device.switch_address())
}

/// A pressure in Pa outside its bounds.
fn outside(name: &str, verb: &str, pa: f64, above: f64, below: f64) -> Option<String> {
    if pa > above && pa < below {
        return None;
    }
    let expected = match (above > 0.0, below.is_finite()) {
        (true, true) => format!("between {:.3e} and {:.3e} mbar", above / 100.0, below / 100.0),
        (true, false) => format!("above {:.3e} mbar", above / 100.0),
        _ => format!("below {:.3e} mbar", below / 100.0),
    };
    Some(format!("expected {name} to {verb} {expected}, got {:.3e} mbar", pa / 100.0))
}

/// The first check that a device does not meet.
fn shown_otherwise(device: &VirtualDevice, instance: Option<u8>, check: &Check) -> Option<String> {
    let (name, report) = (title(device), device.report());
    let instance = instance.unwrap_or(report.active_instance);
    let shown = report.indicated.iter().find(|shown| shown.instance == instance);
    let differs = |what: &str, expected: &dyn fmt::Display, found: &dyn fmt::Display| {
        Some(format!("expected {what} of {name} to be {expected}, got {found}"))
    };
    let flag = |what: &str, expected: bool, found: bool| {
        if expected == found { None } else { differs(what, &expected, &found) }
    };
    match check {
        Check::Pressure(above, below) => match shown {
            Some(shown) => outside(&name, "show", shown.value_mbar * 100.0, *above, *below),
            None => Some(format!("expected {name} to have an instance {instance}")),
        },
        Check::Valid(expected) => flag("the validity of the value", *expected, shown.is_some_and(|shown| shown.valid)),
        Check::State(expected) if *expected == report.device_state => None,
        Check::State(expected) => differs("the state", &expected.name(), &report.device_state.name()),
        Check::Emission(expected) => flag("the emission", *expected, any(report.emission.iter())),
        Check::Degas(expected) => flag("the degas", *expected, any(report.degas.iter())),
        Check::Relay(number, closed) => relay(&report, *number).map_or_else(
            || Some(format!("expected {name} to have a relay {number}")),
            |found| flag("the relay", *closed, found),
        ),
        Check::Fault(expected) => flag("the exception", *expected, report.exception_status & EXCEPTION != 0),
        Check::Exchanging(expected) => flag("the data exchange", *expected, device.is_exchanging()),
    }
}

/// The alarm and warning bits of Exception Status: all but the toggle and the expanded format, E54.
const EXCEPTION: u8 = 0x7F;

fn relay(report: &StateReport, number: u8) -> Option<bool> {
    report.relays.iter().nth(usize::from(number).checked_sub(1)?).copied()
}

fn any<'a>(mut states: impl Iterator<Item = &'a bool>) -> bool {
    states.any(|state| *state)
}
