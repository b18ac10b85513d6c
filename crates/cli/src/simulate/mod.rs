//! `profivac simulate`: virtual devices on a port, operated by lines on standard input.

mod command;
mod state;

use crate::console::{Console, Input};
use crate::failure::Failure;
use crate::output::{notice, notices, out};
use crate::values;
use clap::{ArgGroup, Args};
use command::{Command, DeviceCommand};
use profivac_client::pressure::Pressure;
use profivac_dp::link::Baud;
use profivac_host::port::{Port, PortError, Pty, Serial, TcpServer};
use profivac_host::segment::Segment;
use profivac_vacuum::Gas;
use profivac_virtual::action_text::ActionText as Action;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DeviceSpec, check_addresses};
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_virtual::open;
use profivac_virtual::scenario::{MasterPresence, Run, Scenario};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Virtual devices on a pty, a serial device or TCP, which any PROFIBUS master takes for real ones.
///
/// Prints `ready` and the port once it serves. Then it takes lines on standard input and answers each with one line that
/// begins `ok` or `error:`. End of file keeps it serving; `quit`, SIGTERM and SIGINT end it.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, group = ArgGroup::new("port").required(true))]
pub struct Arguments {
    /// Make a pty and link PATH to it: the serial port of a master
    #[arg(long, value_name = "PATH", group = "port")]
    pty: Option<PathBuf>,
    /// Use a serial device, or the pty of a hub; it may go and come back
    #[arg(long, value_name = "DEV", group = "port")]
    serial: Option<String>,
    /// Listen for masters; port 0 takes a free one
    #[arg(long, value_name = "HOST:PORT", group = "port")]
    tcp: Option<String>,
    /// Bits per second; delays are counted in its bit times
    #[arg(long, value_name = "RATE", default_value = "19200", value_parser = values::baud)]
    baud: Baud,
    /// Give every octet the time it would take on a line
    #[arg(long)]
    pace: bool,
    /// The true pressure, with its unit
    #[arg(long, value_name = "PRESSURE", default_value = "1e-3 mbar", allow_hyphen_values = true)]
    pressure: Pressure,
    /// A plant with its gauges and what happens to them, in real time
    #[arg(long, value_name = "FILE", conflicts_with_all = ["pressure", "atmosphere", "gas", "devices"])]
    scenario: Option<PathBuf>,
    /// The pressure outside of the chamber
    #[arg(long, value_name = "PRESSURE", default_value = "1013.25 mbar", allow_hyphen_values = true)]
    atmosphere: Pressure,
    /// What the chamber is filled with
    #[arg(long, value_name = "GAS", default_value = "n2")]
    gas: Gas,
    /// Keep nonvolatile values in files in DIR, one for each device and address
    #[arg(long, value_name = "DIR")]
    state: Option<PathBuf>,
    /// A device and the setting of its address switch; 126 is a setting outside 0 to 125
    #[arg(value_name = "DEVICE@ADDR[:KEY=VALUE,...]", required_unless_present = "scenario")]
    devices: Vec<DeviceSpec>,
}

const EXAMPLES: &str = "\
Lines on standard input:
  pressure 5e-6 mbar            the true pressure
  atmosphere 1000 mbar          the pressure outside
  gas ar                        what the chamber is filled with
  fault ADDR NAME               a fault begins; a wrong name is answered with the list
  clear ADDR NAME               a fault ends
  power ADDR off|on             the device is switched off, or on again
  button ADDR N                 a push button is pressed once
  switch ADDR NAME VALUE        a switch or input is set
  pot ADDR a|b VOLTS            a set point potentiometer is turned
  advance SECONDS               time passes for the devices, not on the bus
  state ADDR                    answers `ok {json}`
  quit                          ends the simulation

Examples:
  profivac simulate --pty /tmp/gauge bcg450@5
  profivac simulate --pty /tmp/line --pressure '5e-6 mbar' --gas ar bcg450@5 bcg450@6:unit=torr
  profivac simulate --pty /tmp/gauge --state ~/gauges bcg450@126:serial=4711
  profivac simulate --tcp 127.0.0.1:0 --baud 93750 --pace bcg450@5
  profivac simulate --pty /tmp/line --scenario scenarios/pump-down.toml";

/// Serves until somebody wants it to end.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scenario = arguments.scenario.as_deref().map(Scenario::read).transpose()?;
    let conditions =
        GasConditions { pressure: arguments.pressure, atmosphere: arguments.atmosphere, gas: arguments.gas };
    let devices = match &scenario {
        Some(scenario) => scenario.devices(arguments.baud, |spec| memory(spec, arguments.state.as_deref()))?,
        None => devices(arguments, conditions)?,
    };
    let mut console = Console::open()?;
    let segment = segment(arguments, devices)?;
    let playing =
        scenario.map(|scenario| RunningScenario { run: scenario.start(MasterPresence::Present), reported: 0 });
    let mut simulation = Simulation { segment, conditions, scenario: playing };
    out(&format!("ready {}", simulation.segment.port().name()));
    let begun = Instant::now();
    loop {
        let readable = simulation.segment.serve(&console.descriptors(), simulation.time_until_step(begun))?;
        notices(|| simulation.segment.next_notice());
        simulation.advance_scenario(begun);
        for said in console.take_input(&readable) {
            if simulation.handle_input(&said).is_break() {
                return Ok(());
            }
        }
    }
}

/// The devices of the command line.
fn devices(arguments: &Arguments, conditions: GasConditions) -> Result<Vec<VirtualDevice>, Failure> {
    check_addresses(&arguments.devices)?;
    let device = |spec: &DeviceSpec| {
        let unit = spec.build(memory(spec, arguments.state.as_deref())?, arguments.baud)?;
        Ok(VirtualDevice::new(unit, spec.address, arguments.baud, conditions))
    };
    arguments.devices.iter().map(device).collect()
}

/// The memory of a device: as it was left in the folder, or as from the box.
fn memory(spec: &DeviceSpec, folder: Option<&Path>) -> Result<NonvolatileMemory, Failure> {
    let Some(folder) = folder else { return Ok(NonvolatileMemory::volatile()) };
    let opened = NonvolatileMemory::open(folder, &spec.device, spec.address)
        .map_err(|error| Failure::usage(format!("--state {}: {error}", folder.display())))?;
    if let Some(aside) = opened.damaged_copy {
        let DeviceSpec { device, address: place, .. } = spec;
        notice(&format_args!(
            "the memory of {device} at address {place} is damaged: kept as {}, defaults used",
            aside.display()
        ));
    }
    Ok(opened.memory)
}

/// The devices on the port. Only a serial device can be lost, and then it is looked for.
fn segment(arguments: &Arguments, devices: Vec<VirtualDevice>) -> Result<Segment<Vec<VirtualDevice>>, PortError> {
    let segment = Segment::new(port(arguments)?, arguments.baud, arguments.pace, devices);
    Ok(match &arguments.serial {
        Some(device) => segment.with_reopening(open::opener(device, arguments.baud)),
        None => segment,
    })
}

fn port(arguments: &Arguments) -> Result<Box<dyn Port>, PortError> {
    Ok(match (&arguments.pty, &arguments.serial, &arguments.tcp) {
        (Some(path), ..) => Box::new(Pty::create(path)?),
        (_, Some(device), _) => Box::new(Serial::open(device, arguments.baud)?),
        (.., address) => Box::new(TcpServer::listen(address.as_deref().unwrap_or_default())?),
    })
}

/// What the lines act on.
struct Simulation {
    segment: Segment<Vec<VirtualDevice>>,
    conditions: GasConditions,
    /// Instead of constant conditions.
    scenario: Option<RunningScenario>,
}

/// A scenario that runs in real time.
struct RunningScenario {
    run: Run,
    /// So many findings have been told.
    reported: usize,
}

/// The conditions are not to be changed by hand.
const SCENARIO_IN_CONTROL: &str = "a scenario decides what is in the chamber";

impl Simulation {
    /// How long until the scenario has its next step.
    fn time_until_step(&self, begun: Instant) -> Duration {
        let Some(RunningScenario { run, .. }) = &self.scenario else { return Duration::MAX };
        let next = Duration::try_from_secs_f64(run.seconds() + run.step_s()).unwrap_or(Duration::MAX);
        next.saturating_sub(begun.elapsed())
    }

    /// The scenario makes the steps that are due, and says what was not as expected.
    fn advance_scenario(&mut self, begun: Instant) {
        let Some(RunningScenario { run, reported: told }) = &mut self.scenario else { return };
        while run.seconds() + run.step_s() <= begun.elapsed().as_secs_f64() {
            run.step(self.segment.stations_mut());
            self.segment.set_noise(run.noise());
        }
        for finding in run.failures().iter().skip(*told) {
            notice(&format_args!("{finding}"));
        }
        *told = run.failures().len();
    }

    /// Does what was said and answers.
    fn handle_input(&mut self, said: &Input) -> ControlFlow<()> {
        let Input::Line(line) = said else { return ControlFlow::Break(()) };
        let order = Command::parse(line);
        let quits = matches!(order, Ok(Command::Quit));
        match order.and_then(|order| self.execute(&order)) {
            Ok(None) => out("ok"),
            Ok(Some(answer)) => out(&format!("ok {answer}")),
            Err(reason) => out(&format!("error: {reason}")),
        }
        if quits { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn execute(&mut self, order: &Command<'_>) -> Result<Option<String>, String> {
        match order {
            Command::Pressure(_) | Command::Atmosphere(_) | Command::Gas(_) | Command::Advance(_)
                if self.scenario.is_some() =>
            {
                return Err(SCENARIO_IN_CONTROL.to_owned());
            }
            Command::Pressure(pressure) => {
                self.set_conditions(GasConditions { pressure: *pressure, ..self.conditions })
            }
            Command::Atmosphere(atmosphere) => {
                self.set_conditions(GasConditions { atmosphere: *atmosphere, ..self.conditions })
            }
            Command::Gas(gas) => self.set_conditions(GasConditions { gas: *gas, ..self.conditions }),
            Command::Advance(seconds) => {
                self.segment.stations_mut().iter_mut().for_each(|device| device.advance(*seconds));
            }
            Command::Device(place, order) => return self.execute_at(*place, order),
            Command::Quit => {}
        }
        Ok(None)
    }

    fn set_conditions(&mut self, conditions: GasConditions) {
        self.conditions = conditions;
        self.segment.stations_mut().iter_mut().for_each(|device| device.settle_in(conditions));
    }

    fn execute_at(&mut self, place: u8, order: &DeviceCommand<'_>) -> Result<Option<String>, String> {
        let constant = self.scenario.is_none().then(|| self.conditions.pressure.mbar());
        let device = self.device(place)?;
        let true_mbar = constant.unwrap_or_else(|| device.surroundings().gas.total() / 100.0);
        match order {
            DeviceCommand::Power(on) => device.set_power(*on),
            DeviceCommand::State => return Ok(Some(state::json(device, true_mbar))),
            DeviceCommand::Operate(action) => {
                let name = device.instrument().name();
                device.operate_text(*action).map_err(|unknown| unknown_part(name, *action, &unknown.expected))?;
            }
        }
        Ok(None)
    }

    fn device(&mut self, place: u8) -> Result<&mut VirtualDevice, String> {
        let places = self.segment.stations().iter().map(|device| device.switch_address().to_string());
        let unknown = format!("no device at address {place}; there are {}", places.collect::<Vec<_>>().join(", "));
        self.segment.stations_mut().iter_mut().find(|device| device.switch_address() == place).ok_or(unknown)
    }
}

/// The device has nothing like that.
fn unknown_part(device: &str, action: Action<'_>, expected: &[String]) -> String {
    let what = match action {
        Action::Fault { name, .. } => format!("fault {name:?}"),
        Action::Button(number) => format!("button {number}"),
        Action::Switch { name, value } => format!("switch {name:?} with a position {value:?}"),
        Action::Pot { which, .. } => format!("potentiometer {which:?}"),
    };
    match expected {
        [] => format!("{device} has no {what}"),
        expected => format!("{device} has no {what}; it has {}", expected.join(", ")),
    }
}
