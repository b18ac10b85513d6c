//! The timeline of a scenario, with every name resolved.

use super::error::{ScenarioEntryError, TextError};
use super::plant::{Part, Plant, air};
use super::quantities::{PART, TIME, flow, gas_pressure, parsed, pressure, temperature, unknown};
use crate::action_text::ActionText;
use crate::device_spec::{DeviceSpec, parse_address};
use crate::gsd_slave::{FORMS, GsdStation, Order};
use crate::nonvolatile::NonvolatileMemory;
use profivac_devices::ReportedState;
use profivac_dp::link::Baud;
use profivac_scenario_file::{Entry, Expect, File, Flow, Heat, Spray, Text};
use profivac_vacuum::network::{
    CapturePump, Inlet, Joint, Opening, Outside, RoughingPump, Supply, TurboPump, Volume, Wall,
};
use profivac_vacuum::{Atmosphere, Gas, Mixture};
use std::cell::RefCell;
use toml::Spanned;

/// The flow of a regulated inlet that is fully open, in Pa m³/s: 200 sccm. chosen
const MAX_INLET_FLOW: f64 = 0.36;

/// The time in which a wall is heated or cooled if the file does not say it, in s. chosen: an hour
const HEATING_S: f64 = 3600.0;

/// The limits of a potentiometer in V: its supply, either sign.
const MAX_VOLTS: f64 = 24.0;

/// The tolerance of `near` without `within`.
const DEFAULT_TOLERANCE: f64 = 0.1;

/// The event at one time: first its expectations are checked, then its actions are executed.
#[derive(Clone, Debug)]
pub struct Event {
    /// The number of the step.
    pub step: u64,
    /// A message for the reader of the run.
    pub message: Option<String>,
    /// The actions.
    pub actions: Vec<ScenarioAction>,
    /// The expectations.
    pub expectations: Vec<Expectation>,
}

/// An action of the timeline.
#[derive(Clone, Debug)]
pub enum ScenarioAction {
    /// Opens a tube or a valve to a degree from 0 to 1.
    Joint(Joint, f64),
    /// Opens or closes a leak or a vent.
    Opening(Opening, f64),
    /// Starts or stops a roughing pump.
    Roughing(RoughingPump, bool),
    /// Starts or stops a turbomolecular pump.
    Turbo(TurboPump, bool),
    /// Starts or stops a capture pump.
    Capture(CapturePump, bool),
    /// Sets a gas inlet.
    Feed(Inlet, Supply),
    /// Heats or cools a wall to a temperature in K, within a time in s.
    Heat(Wall, f64, f64),
    /// Changes the gas outside a leak or a vent.
    Spray(Opening, Outside),
    /// Empties a capture pump.
    Regenerate(CapturePump),
    /// Changes the air outside.
    Air(Atmosphere),
    /// Sets the probability with which noise damages an octet on the bus, 0 to 1.
    Noise(f64),
    /// Operates the device at this address.
    Device(u8, DeviceAction),
    /// An order to the slave by its GSD file at this address.
    Order(u8, Order),
}

/// An action on a device.
#[derive(Clone, Debug)]
pub enum DeviceAction {
    /// Sets or clears a fault.
    Fault(String, bool),
    /// Switches the power.
    Power(bool),
    /// Connects or disconnects the bus connector.
    Connector(bool),
    /// Presses a button.
    Button(u8),
    /// Sets a switch.
    Switch(String, String),
    /// Turns a potentiometer.
    Pot(char, f64),
    /// Writes a record as a class 2 master.
    Write(u8, u8, Vec<u8>),
}

impl DeviceAction {
    /// The action on the simulated device. `None` for power, bus and records.
    #[must_use]
    pub fn action(&self) -> Option<ActionText<'_>> {
        match self {
            Self::Fault(name, present) => Some(ActionText::Fault { name, present: *present }),
            Self::Button(number) => Some(ActionText::Button(*number)),
            Self::Switch(name, value) => Some(ActionText::Switch { name, value }),
            Self::Pot(which, volts) => Some(ActionText::Pot { which: *which, volts: *volts }),
            Self::Power(_) | Self::Connector(_) | Self::Write(..) => None,
        }
    }
}

/// A required state.
#[derive(Clone, Debug)]
pub struct Expectation {
    /// The line of the file.
    pub line: usize,
    /// The subject of the checks.
    pub subject: Subject,
    /// The checks.
    pub checks: Vec<Check>,
}

/// The subject of an expectation.
#[derive(Clone, Debug)]
pub enum Subject {
    /// The true pressure in a volume.
    Volume(String, Volume),
    /// The device at this address, and an instance, or the active one.
    Device(u8, Option<u8>),
    /// The slave by its GSD file at this address.
    Slave(u8),
}

/// A single check.
#[derive(Clone, Debug, PartialEq)]
pub enum Check {
    /// The pressure is within these bounds, in Pa.
    Pressure(f64, f64),
    /// The value is valid.
    Valid(bool),
    /// The device state.
    State(ReportedState),
    /// At least one cathode emits.
    Emission(bool),
    /// At least one cathode is being degassed.
    Degas(bool),
    /// The relay of this number, from 1, is closed.
    Relay(u8, bool),
    /// The device reports an exception.
    Fault(bool),
    /// The device exchanges data with a master.
    Exchanging(bool),
}

/// Resolves the names of a timeline.
pub struct EventParser<'a> {
    /// The plant.
    pub plant: &'a Plant,
    /// The devices.
    pub specs: &'a [DeviceSpec],
    /// Slaves by their GSD files, on which orders are tried.
    pub slaves: &'a RefCell<Vec<GsdStation>>,
    /// The text of the file.
    pub text: &'a str,
    /// The length of a step in s.
    pub step_s: f64,
    /// The duration of the scenario in s.
    pub until_s: f64,
}

impl EventParser<'_> {
    /// The events in the order of time.
    pub fn events(&self, file: &File) -> Result<Vec<Event>, TextError> {
        let mut atmosphere = self.plant.network.atmosphere();
        let events = file.timeline.iter().map(|entry| self.event(entry.get_ref(), &mut atmosphere));
        let mut events = events.collect::<Result<Vec<_>, _>>()?;
        events.sort_by_key(|event| event.step);
        Ok(events)
    }

    fn event(&self, entry: &Entry, atmosphere: &mut Atmosphere) -> Result<Event, TextError> {
        let seconds = TIME.parse(&entry.at)?;
        if seconds > self.until_s {
            return Err(TextError::at(&entry.at.span(), ScenarioEntryError::AfterEnd(entry.at.get_ref().clone())));
        }
        let mut actions = self.plant_actions(entry)?;
        if entry.atmosphere.is_some() {
            *atmosphere = air(entry.atmosphere.as_ref(), *atmosphere)?;
            actions.push(ScenarioAction::Air(*atmosphere));
        }
        if let Some(part) = &entry.noise {
            actions.push(ScenarioAction::Noise(PART.parse(part)?));
        }
        self.device_actions(entry, &mut actions)?;
        let expectations = entry.expect.iter().map(|expect| self.expectation(expect)).collect::<Result<_, _>>()?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of steps, never negative")]
        let step = (seconds / self.step_s).round() as u64;
        Ok(Event { step, message: entry.say.clone(), actions, expectations })
    }

    fn plant_actions(&self, entry: &Entry) -> Result<Vec<ScenarioAction>, TextError> {
        let mut actions = self.valves_and_pumps(entry)?;
        for flow in &entry.flow {
            actions.push(self.feed(flow)?);
        }
        for heat in &entry.heat {
            actions.push(self.heat(heat)?);
        }
        for spray in &entry.spray {
            actions.push(self.spray(spray)?);
        }
        for name in &entry.regenerate {
            actions.push(self.plant.part("a capture pump", name, |part| match part {
                Part::Capture(pump) => Some(ScenarioAction::Regenerate(pump)),
                _ => None,
            })?);
        }
        Ok(actions)
    }

    fn valves_and_pumps(&self, entry: &Entry) -> Result<Vec<ScenarioAction>, TextError> {
        let mut actions = Vec::new();
        let opened = entry.open.iter().map(|name| (name, 1.0)).chain(entry.close.iter().map(|name| (name, 0.0)));
        for (name, how_far) in opened {
            actions.push(self.plant.part("a valve, tube, leak or vent", name, |part| match part {
                Part::Joint(joint) => Some(ScenarioAction::Joint(joint, how_far)),
                Part::Opening(opening) => Some(ScenarioAction::Opening(opening, how_far)),
                _ => None,
            })?);
        }
        let started = entry.start.iter().map(|name| (name, true)).chain(entry.stop.iter().map(|name| (name, false)));
        for (name, running) in started {
            actions.push(self.plant.part("a pump", name, |part| match part {
                Part::Roughing(pump) => Some(ScenarioAction::Roughing(pump, running)),
                Part::Turbo(pump) => Some(ScenarioAction::Turbo(pump, running)),
                Part::Capture(pump) => Some(ScenarioAction::Capture(pump, running)),
                _ => None,
            })?);
        }
        Ok(actions)
    }

    fn heat(&self, heat: &Heat) -> Result<ScenarioAction, TextError> {
        let kelvin = temperature(&heat.to)?;
        let seconds = heat.over.as_ref().map_or(Ok(HEATING_S), |over| TIME.parse(over))?;
        self.plant.part("a wall", &heat.wall, |part| match part {
            Part::Wall(wall) => Some(ScenarioAction::Heat(wall, kelvin, seconds)),
            _ => None,
        })
    }

    fn spray(&self, spray: &Spray) -> Result<ScenarioAction, TextError> {
        let outside = match parsed(&spray.gas)? {
            Gas::Air => Outside::Air,
            gas => Outside::Gas(Mixture::pure(gas, self.plant.network.atmosphere().pressure_pa)),
        };
        self.plant.part("a leak or vent", &spray.leak, |part| match part {
            Part::Opening(opening) => Some(ScenarioAction::Spray(opening, outside)),
            _ => None,
        })
    }

    fn feed(&self, set: &Flow) -> Result<ScenarioAction, TextError> {
        let supply = match (&set.flow, &set.pressure) {
            (Some(text), None) => match flow(text)? {
                0.0 => Supply::Closed,
                flow => Supply::Flow(flow),
            },
            // 0 closes the inlet.
            (None, Some(text)) if pressure(text)? == 0.0 => Supply::Closed,
            (None, Some(text)) => Supply::Pressure { pa: gas_pressure(text)?, max_flow: MAX_INLET_FLOW },
            _ => return Err(TextError::at(&set.inlet.span(), ScenarioEntryError::NoSupply)),
        };
        self.plant.part("a gas inlet", &set.inlet, |part| match part {
            Part::Inlet(inlet) => Some(ScenarioAction::Feed(inlet, supply)),
            _ => None,
        })
    }

    fn device_actions(&self, entry: &Entry, actions: &mut Vec<ScenarioAction>) -> Result<(), TextError> {
        let mut add = |device: &Spanned<u8>, at: std::ops::Range<usize>, action| {
            actions.push(ScenarioAction::Device(self.check_action(device, &at, &action)?, action));
            Ok::<(), TextError>(())
        };
        for (faults, present) in [(&entry.fault, true), (&entry.clear, false)] {
            for fault in faults {
                add(&fault.device, fault.name.span(), DeviceAction::Fault(fault.name.get_ref().clone(), present))?;
            }
        }
        for (addresses, on) in [(&entry.power_off, false), (&entry.power_on, true)] {
            addresses.iter().try_for_each(|address| add(address, address.span(), DeviceAction::Power(on)))?;
        }
        for (addresses, on) in [(&entry.unplug, false), (&entry.plug, true)] {
            addresses.iter().try_for_each(|address| add(address, address.span(), DeviceAction::Connector(on)))?;
        }
        for button in &entry.button {
            add(&button.device, button.number.span(), DeviceAction::Button(*button.number.get_ref()))?;
        }
        for switch in &entry.switch {
            let action = DeviceAction::Switch(switch.name.get_ref().clone(), switch.value.get_ref().clone());
            add(&switch.device, switch.name.span(), action)?;
        }
        for pot in &entry.pot {
            let volts = *pot.volts.get_ref();
            if !(-MAX_VOLTS..=MAX_VOLTS).contains(&volts) {
                let error = ScenarioEntryError::Volts { most: MAX_VOLTS, found: volts };
                return Err(TextError::at(&pot.volts.span(), error));
            }
            add(&pot.device, pot.which.span(), DeviceAction::Pot(*pot.which.get_ref(), volts))?;
        }
        for write in &entry.write {
            let action = DeviceAction::Write(write.slot, write.index, write.octets.clone());
            add(&write.device, write.device.span(), action)?;
        }
        for line in &entry.order {
            actions.push(self.order(line)?);
        }
        Ok(())
    }

    /// An order, tried on a slave that is then discarded.
    fn order(&self, line: &Text) -> Result<ScenarioAction, TextError> {
        let wrong = |sentence: String| TextError::at(&line.span(), ScenarioEntryError::Slave(sentence));
        let forms = || wrong(format!("expected {}", FORMS.map(|(word, form)| format!("{word} {form}")).join(", or ")));
        let words: Vec<&str> = line.get_ref().split_whitespace().collect();
        let [word, address, rest @ ..] = words.as_slice() else { return Err(forms()) };
        let order = Order::parse(word, rest).ok_or_else(forms)?.map_err(|error| wrong(error.to_string()))?;
        let address = parse_address(address).map_err(|error| wrong(error.to_string()))?;
        let mut slaves = self.slaves.borrow_mut();
        let known = slaves.iter().map(|slave| format!("{} ({})", slave.switch_address(), slave.name()));
        let known = known.collect::<Vec<_>>().join(", ");
        let missing =
            || wrong(format!("expected the address of a slave by its GSD file, got {address}; known: {known}"));
        let slave = slaves.iter_mut().find(|slave| slave.switch_address() == address).ok_or_else(missing)?;
        slave.execute(&order).map_err(|refused| wrong(refused.to_string()))?;
        Ok(ScenarioAction::Order(address, order))
    }

    fn is_slave(&self, address: u8) -> bool {
        self.slaves.borrow().iter().any(|slave| slave.switch_address() == address)
    }

    /// Tries the action on a device that is then discarded.
    fn check_action(
        &self,
        device: &Spanned<u8>,
        at: &std::ops::Range<usize>,
        action: &DeviceAction,
    ) -> Result<u8, TextError> {
        if matches!(action, DeviceAction::Power(_) | DeviceAction::Connector(_)) && self.is_slave(*device.get_ref()) {
            return Ok(*device.get_ref());
        }
        let spec = self.spec(device)?;
        let Some(text) = action.action() else { return Ok(spec.address) };
        let slave =
            spec.build(NonvolatileMemory::volatile(), Baud::B19200).map_err(|error| TextError::at(at, error))?;
        let (device, address) = (slave.device().name(), spec.address);
        text.resolve(slave.device())
            .map_err(|unknown| TextError::at(at, ScenarioEntryError::UnknownPart { device, address, unknown }))?;
        Ok(spec.address)
    }

    fn spec(&self, device: &Spanned<u8>) -> Result<&DeviceSpec, TextError> {
        let address = *device.get_ref();
        self.specs.iter().find(|spec| spec.address == address).ok_or_else(|| {
            let slaves = self.slaves.borrow();
            let error = match slaves.iter().find(|slave| slave.switch_address() == address) {
                Some(slave) => ScenarioEntryError::AddressOfSlave {
                    found: address,
                    name: slave.name().to_owned(),
                    faults: slave.fault_orders(),
                },
                None => {
                    let known = self.specs.iter().map(|spec| format!("{} ({})", spec.address, spec.device)).collect();
                    ScenarioEntryError::UnknownAddress { found: address, known }
                }
            };
            TextError::at(&device.span(), error)
        })
    }

    fn expectation(&self, written: &Spanned<Expect>) -> Result<Expectation, TextError> {
        let expect = written.get_ref();
        let wrong = |error: ScenarioEntryError| TextError::at(&written.span(), error);
        let of = match (&expect.volume, &expect.device) {
            (Some(volume), None) => Subject::Volume(volume.get_ref().clone(), self.plant.at(volume)?),
            (None, Some(device)) if self.is_slave(*device.get_ref()) => Subject::Slave(*device.get_ref()),
            (None, Some(device)) => Subject::Device(self.spec(device)?.address, expect.instance),
            _ => return Err(wrong(ScenarioEntryError::NoSubject)),
        };
        let checks = checks(expect, &wrong)?;
        if checks.is_empty() {
            return Err(wrong(ScenarioEntryError::NoCheck));
        }
        if matches!(of, Subject::Volume(..)) && checks.iter().any(|check| !matches!(check, Check::Pressure(..))) {
            return Err(wrong(ScenarioEntryError::NotOfVolume));
        }
        if matches!(of, Subject::Slave(_)) && checks.iter().any(|check| !matches!(check, Check::Exchanging(_))) {
            return Err(wrong(ScenarioEntryError::NotOfSlave));
        }
        let (line, _) = profivac_host::text_file::line_and_column(self.text, written.span().start);
        Ok(Expectation { line, subject: of, checks })
    }
}

fn checks(expect: &Expect, wrong: &impl Fn(ScenarioEntryError) -> TextError) -> Result<Vec<Check>, TextError> {
    let mut checks = Vec::new();
    if let Some(bounds) = bounds(expect, wrong)? {
        checks.push(bounds);
    }
    checks.extend(expect.valid.map(Check::Valid));
    checks.extend(expect.state.as_ref().map(state).transpose()?.map(Check::State));
    checks.extend(expect.emission.map(Check::Emission));
    checks.extend(expect.degas.map(Check::Degas));
    checks.extend(expect.fault.map(Check::Fault));
    checks.extend(expect.exchanging.map(Check::Exchanging));
    match (expect.relay, expect.closed) {
        (None, None) => {}
        (Some(relay), Some(closed)) => checks.push(Check::Relay(relay, closed)),
        _ => return Err(wrong(ScenarioEntryError::HalfRelay)),
    }
    Ok(checks)
}

/// The device state of this name.
fn state(text: &Text) -> Result<ReportedState, TextError> {
    let known = || ReportedState::ALL.into_iter().map(ReportedState::name);
    ReportedState::from_name(text.get_ref()).ok_or_else(|| unknown("a device state", text, known()))
}

fn bounds(expect: &Expect, wrong: &impl Fn(ScenarioEntryError) -> TextError) -> Result<Option<Check>, TextError> {
    let pa = |text: &Option<Text>| text.as_ref().map(pressure).transpose();
    let within = expect.within.as_ref().map(|text| PART.parse(text)).transpose()?;
    match (pa(&expect.above)?, pa(&expect.below)?, pa(&expect.near)?) {
        (None, None, Some(near)) => {
            let part = within.unwrap_or(DEFAULT_TOLERANCE);
            Ok(Some(Check::Pressure(near * (1.0 - part), near * (1.0 + part))))
        }
        _ if within.is_some() => Err(wrong(ScenarioEntryError::NoNear)),
        (None, None, None) => Ok(None),
        (above, below, None) => Ok(Some(Check::Pressure(above.unwrap_or(0.0), below.unwrap_or(f64::INFINITY)))),
        _ => Err(wrong(ScenarioEntryError::MixedBounds)),
    }
}
