//! `profivac simulate`: virtual devices on a port, controlled by commands on standard input.

mod command;
mod state;

use crate::console::{Console, Input};
use crate::failure::Failure;
use crate::output::{notice, notices, out, visible};
use crate::values;
use clap::{ArgGroup, Args};
use command::{Command, CommandError, DeviceCommand};
use profivac_client::suggestion::list;
use profivac_device_file::is_device_file;
use profivac_dp::link::Baud;
use profivac_host::clock::duration_of;
use profivac_host::port::{Port, PortError, Pty, Serial, TcpServer};
use profivac_host::segment::Segment;
use profivac_host::text_file;
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DeviceSpec, MemoryError, check_distinct, device_and_rest};
use profivac_virtual::gas_pressure::GasPressure;
use profivac_virtual::gsd_slave::{GsdStation, OpenedSlave};
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_virtual::open;
use profivac_virtual::scenario::{Included, MasterPresence, Run, Scenario};
use profivac_virtual::station_spec::{StationSpec, StationSpecError, VirtualStation, gauges_of};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::{Duration, Instant};

/// Put virtual devices on a pty, a serial device or TCP, for any PROFIBUS master.
///
/// The command prints `ready` and the port when the devices answer. Then it reads commands from standard input and answers each
/// with one line that begins with `ok` or `error:`. It continues after end of file; `quit`, SIGTERM and SIGINT end it.
#[derive(Args, Debug)]
#[command(after_help = format!("{EXAMPLES}\n\n{}", values::included_scenarios()), group = ArgGroup::new("port").required(true))]
pub struct Arguments {
    /// Make a pty and link PATH to it: the serial port for a master
    #[arg(long, value_name = "PATH", group = "port")]
    pty: Option<PathBuf>,
    /// Use a serial device, or the pty of a hub; a lost device is opened again. On a physical line the answers come
    /// late: the command prints the slot time that every master on the line needs
    #[arg(long, value_name = "DEV", group = "port")]
    serial: Option<String>,
    /// Print the file of the scenario and exit: `--scenario NAME --show`
    #[arg(long, group = "port", requires = "scenario")]
    show: bool,
    /// Listen for masters on TCP; port 0 selects a free one
    #[arg(long, value_name = "HOST:PORT", group = "port")]
    tcp: Option<String>,
    /// Bits per second; delays are counted in bit times of this rate
    #[arg(long, value_name = "RATE", default_value = "19200", value_parser = values::baud)]
    baud: Baud,
    /// Transmit every octet in the time it takes on a line
    #[arg(long)]
    pace: bool,
    /// The true pressure, with its unit; from 1e-15 mbar to 10 bar
    #[arg(long, value_name = "PRESSURE", default_value = "1e-3 mbar", allow_hyphen_values = true)]
    pressure: GasPressure,
    /// Run a scenario, a plant with its gauges and a timeline, in real time: a file, or the name of an included one (below)
    #[arg(long, value_name = "NAME|FILE", conflicts_with_all = ["pressure", "atmosphere", "gas"])]
    scenario: Option<PathBuf>,
    /// The pressure outside the chamber, in the same range
    #[arg(long, value_name = "PRESSURE", default_value = "1013.25 mbar", allow_hyphen_values = true)]
    atmosphere: GasPressure,
    /// The gas in the chamber
    #[arg(long, value_name = "GAS", default_value = "n2")]
    gas: Gas,
    /// Store nonvolatile values in files in DIR, one for each device and address
    #[arg(long, value_name = "DIR")]
    state: Option<PathBuf>,
    /// A device and the setting of its address switch; 126 means a setting outside 0 to 125. With a scenario these devices are
    /// added to its gauges, at a constant 1e-3 mbar. FILE.gsd@ADDR is a slave as its GSD file describes it, with the modules in slot
    /// order, by number: FILE.gsd@9:modules=3+7; or by name in a TOML file: FILE.gsd@9:setup=FILE.toml.
    /// FILE.toml@ADDR is a device of a device file, with the behaviour that the file names or inherits
    #[arg(value_name = "DEVICE@ADDR[:KEY=VALUE,...]", required_unless_present = "scenario")]
    devices: Vec<Wanted>,
}

/// A station of the command line.
#[derive(Clone, Debug)]
enum Wanted {
    Spec(StationSpec),
    /// A device of a device file, which is read when the simulation starts.
    OfFile(String),
}

impl FromStr for Wanted {
    type Err = StationSpecError;

    fn from_str(text: &str) -> Result<Self, StationSpecError> {
        let device = device_and_rest(text).map_or(text, |(device, _)| device);
        if is_device_file(Path::new(device)) { Ok(Self::OfFile(text.to_owned())) } else { text.parse().map(Self::Spec) }
    }
}

impl Wanted {
    fn spec(&self) -> Result<StationSpec, Failure> {
        match self {
            Self::Spec(spec) => Ok(spec.clone()),
            Self::OfFile(text) => text.parse().map_err(|error: StationSpecError| Failure::usage(error.to_string())),
        }
    }
}

const EXAMPLES: &str = "\
Lines on standard input:
  pressure 5e-6 mbar            sets the true pressure
  atmosphere 1000 mbar          sets the pressure outside the chamber
  gas ar                        sets the gas in the chamber
  fault ADDR NAME               starts a fault; the answer to a wrong name lists the faults with their effects
  clear ADDR NAME               ends a fault
  power ADDR off|on             switches the device off or on
  button ADDR N                 presses a push button once
  switch ADDR NAME VALUE        sets a switch or an input
  pot ADDR a|b VOLTS            sets a set point potentiometer
  advance SECONDS               advances the time of the devices, not of the bus
  state ADDR                    answers `ok {json}`
Lines for a slave by its GSD file, which also takes power and state:
  input ADDR SLOT [at OCTET] OCTET|TYPE:VALUE ...
                                sets inputs of the module in the slot: hexadecimal octets like 1F or 16#1F, or values like
                                float:23.5, u16:500, i32:-7
  input ADDR SLOT bit N on|off  sets a bit; bit 8 is the lowest one of the second octet
  diagnosis ADDR bit N on|off   reports a bit behind the header of the diagnosis, as the file numbers its texts
  diagnosis ADDR area FIRST-LAST VALUE|TEXT
                                reports a number in several bits, or the number of the file's text
  diagnosis ADDR none           ends every report
  channel-error ADDR SLOT CHANNEL ERROR|TEXT on|off
                                reports an error of a channel, by number or by the file's text
  alarm ADDR SLOT diagnostic|process|pull|plug|status|update|32...126 [appears|disappears|others-remain] [OCTET|TYPE:VALUE ...]
                                sends an alarm of the slot; a number is an alarm of the manufacturer
  record ADDR SLOT INDEX [OCTET|TYPE:VALUE ...]
                                makes or changes a DP-V1 record for masters; without octets, prints it
All:
  quit                          ends the simulation

Examples:
  profivac simulate --pty /tmp/gauge bcg450@5
  profivac simulate --pty /tmp/line --pressure '5e-6 mbar' --gas ar bcg450@5 bcg450@6:unit=torr
  profivac simulate --pty /tmp/gauge --state ~/gauges bcg450@126:serial=4711
  profivac simulate --tcp 127.0.0.1:0 --baud 93750 --pace bcg450@5
  profivac simulate --pty /tmp/line bcg450@5 valves.gsd@9:modules=3+7
  profivac simulate --pty /tmp/line my-gauge.toml@7
  profivac simulate --pty /tmp/line --scenario pump-down
  profivac simulate --scenario pump-down --show > mine.toml";

/// How often the command looks whether a slave has refused a master. chosen: soon for a reader, rarely for the processor.
const REFUSALS_EVERY: Duration = Duration::from_millis(100);

/// Serves until `quit` or a signal.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let (true, Some(given)) = (arguments.show, &arguments.scenario) {
        return show(given);
    }
    let scenario = arguments.scenario.as_deref().map(Scenario::of_file_or_name).transpose()?;
    let conditions =
        GasConditions { pressure: arguments.pressure.0, atmosphere: arguments.atmosphere.0, gas: arguments.gas };
    let mut devices = scenario.as_ref().map_or(Ok(Vec::new()), |scenario| stations_of(scenario, arguments))?;
    devices.extend(stations(arguments, conditions)?);
    check_distinct(devices.iter().map(VirtualStation::switch_address))?;
    let mut console = Console::open()?;
    let segment = segment(arguments, devices)?;
    let scenario =
        scenario.map(|scenario| RunningScenario { run: scenario.start(MasterPresence::Present), reported: 0 });
    let mut simulation = Simulation { segment, conditions, scenario };
    out(&format!("ready {}", simulation.segment.port().name()));
    let started = Instant::now();
    loop {
        let readable = simulation.segment.serve(&console.descriptors(), simulation.time_until_step(started))?;
        notices(|| simulation.segment.next_notice());
        simulation.report_refusals();
        simulation.advance_scenario(started);
        for input in console.take_input(&readable) {
            if simulation.handle_input(&input).is_break() {
                return Ok(());
            }
        }
    }
}

/// Prints the file of a scenario.
fn show(given: &Path) -> Result<(), Failure> {
    // Finds the scenario as a run would, with its errors.
    Scenario::of_file_or_name(given)?;
    let included = given.to_str().and_then(Included::named);
    match included {
        Some(included) => out(included.text.trim_end()),
        None => out(text_file::read(given)?.trim_end()),
    }
    Ok(())
}

/// The stations of the command line.
fn stations(arguments: &Arguments, conditions: GasConditions) -> Result<Vec<VirtualStation>, Failure> {
    let specs = arguments.devices.iter().map(Wanted::spec).collect::<Result<Vec<_>, _>>()?;
    check_distinct(specs.iter().map(StationSpec::address))?;
    let station = |spec: &StationSpec| match spec {
        StationSpec::Gauge(spec) => {
            let unit = spec.build(memory(spec, arguments.state.as_deref())?, arguments.baud)?;
            Ok(VirtualStation::Gauge(VirtualDevice::new(unit, spec.address, arguments.baud, conditions)))
        }
        StationSpec::Slave(spec) => Ok(slave(spec.open(arguments.baud, arguments.state.as_deref())?)),
    };
    specs.iter().map(station).collect()
}

/// The stations of a scenario.
fn stations_of(scenario: &Scenario, arguments: &Arguments) -> Result<Vec<VirtualStation>, Failure> {
    let state = arguments.state.as_deref();
    let devices = scenario.devices(arguments.baud, |spec| memory(spec, state))?;
    let slaves = scenario.slaves(arguments.baud, state)?;
    Ok(devices.into_iter().map(VirtualStation::Gauge).chain(slaves.into_iter().map(slave)).collect())
}

/// A slave by its GSD file, with notices about it.
fn slave(OpenedSlave { station, warnings, set_aside }: OpenedSlave) -> VirtualStation {
    let address = station.switch_address();
    for warning in warnings {
        notice(&format_args!("slave {address}: {warning}"));
    }
    if let Some((name, aside)) = set_aside {
        notice(&aside.notice(&name, address));
    }
    VirtualStation::Slave(station)
}

/// The nonvolatile memory of a device: from the folder, or with default values.
fn memory(spec: &DeviceSpec, folder: Option<&Path>) -> Result<NonvolatileMemory, Failure> {
    let Some(folder) = folder else { return Ok(NonvolatileMemory::volatile()) };
    let opened = spec.open_memory(folder).map_err(|error| match error {
        MemoryError::Spec(error) => error.into(),
        error => Failure::usage(format!("--state {}: {error}", folder.display())),
    })?;
    if let Some(aside) = opened.set_aside {
        notice(&aside.notice(&spec.device, spec.address));
    }
    Ok(opened.memory)
}

/// The devices on the port. Only a serial device can be lost; it is then opened again.
fn segment(arguments: &Arguments, devices: Vec<VirtualStation>) -> Result<Segment<Vec<VirtualStation>>, PortError> {
    let port = port(arguments)?;
    report_slot_time(&*port, arguments.baud);
    let segment = Segment::new(port, arguments.baud, arguments.pace, devices);
    Ok(match &arguments.serial {
        Some(device) => segment.with_reopening(open::opener(device, arguments.baud)),
        None => segment,
    })
}

/// On a physical line: the slot time that a master needs to receive the answers.
fn report_slot_time(port: &dyn Port, baud: Baud) {
    if let Some(tbit) = port.delivery().master_slot_tbit(baud, baud.max_tsdr_tbit().into()) {
        notice(&format_args!(
            "{} is {}: its answers come late, so every master on the line needs a slot time of at least {tbit} bit times ({:.1} ms)",
            port.name(),
            port.delivery(),
            duration_of(baud, tbit).as_secs_f64() * 1e3,
        ));
    }
}

fn port(arguments: &Arguments) -> Result<Box<dyn Port>, PortError> {
    Ok(match (&arguments.pty, &arguments.serial, &arguments.tcp) {
        (Some(path), ..) => Box::new(Pty::create(path)?.with_rate(Some(arguments.baud))),
        (_, Some(device), _) => Box::new(Serial::open(device, arguments.baud)?),
        (.., address) => Box::new(TcpServer::listen(address.as_deref().unwrap_or_default())?),
    })
}

/// The segment and its conditions, which the commands change.
struct Simulation {
    segment: Segment<Vec<VirtualStation>>,
    conditions: GasConditions,
    /// The running scenario, if there is one; it replaces the constant conditions.
    scenario: Option<RunningScenario>,
}

/// A scenario that runs in real time.
struct RunningScenario {
    run: Run,
    /// How many findings have been printed.
    reported: usize,
}

impl Simulation {
    /// The time until the next step of the scenario, or until the next look at refusals.
    fn time_until_step(&self, started: Instant) -> Duration {
        let has_slave = self.segment.stations().iter().any(|station| matches!(station, VirtualStation::Slave(_)));
        let look = if has_slave { REFUSALS_EVERY } else { Duration::MAX };
        let Some(RunningScenario { run, .. }) = &self.scenario else { return look };
        let next = Duration::try_from_secs_f64(run.seconds() + run.step_s()).unwrap_or(Duration::MAX);
        next.saturating_sub(started.elapsed()).min(look)
    }

    /// Prints why slaves have refused the parameters or the configuration of a master, and which alarms it has acknowledged.
    fn report_refusals(&mut self) {
        for station in self.segment.stations_mut() {
            let VirtualStation::Slave(slave) = station else { continue };
            if let Some(refusal) = slave.take_refusal() {
                notice(&format_args!("slave {}: refused {refusal}", slave.switch_address()));
            }
            for alarm in slave.take_alarm_notices() {
                notice(&format_args!("slave {}: {alarm}", slave.switch_address()));
            }
        }
    }

    /// Runs the steps of the scenario that are due, and prints expectations that do not hold.
    fn advance_scenario(&mut self, started: Instant) {
        let Some(RunningScenario { run, reported }) = &mut self.scenario else { return };
        while run.seconds() + run.step_s() <= started.elapsed().as_secs_f64() {
            let (mut gauges, mut slaves) = (Vec::new(), Vec::new());
            for station in self.segment.stations_mut() {
                match station {
                    VirtualStation::Gauge(device) => gauges.push(device),
                    VirtualStation::Slave(slave) => slaves.push(slave),
                }
            }
            run.step_with(gauges, slaves);
            self.segment.set_noise(run.noise());
        }
        for finding in run.failures().iter().skip(*reported) {
            notice(&format_args!("{finding}"));
        }
        *reported = run.failures().len();
    }

    /// Executes a command and prints the answer.
    fn handle_input(&mut self, input: &Input) -> ControlFlow<()> {
        let Some(line) = input.command()? else { return ControlFlow::Continue(()) };
        let command = Command::parse(line);
        let quits = matches!(command, Ok(Command::Quit));
        match command.and_then(|command| self.execute(&command)) {
            Ok(None) => out("ok"),
            Ok(Some(answer)) => out(&format!("ok {answer}")),
            Err(error) => out(&visible(&format!("error: {error}"))),
        }
        if quits { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Executes a command. Returns the JSON of `state`.
    fn execute(&mut self, command: &Command<'_>) -> Result<Option<String>, CommandError> {
        match command {
            Command::Pressure(_) | Command::Atmosphere(_) | Command::Gas(_) | Command::Advance(_)
                if self.scenario.is_some() =>
            {
                return Err(CommandError::ScenarioRuns);
            }
            Command::Pressure(_) | Command::Atmosphere(_) | Command::Gas(_) if !self.has_gauge() => {
                return Err(CommandError::NoGauges);
            }
            Command::Pressure(pressure) => {
                self.set_conditions(GasConditions { pressure: *pressure, ..self.conditions })
            }
            Command::Atmosphere(atmosphere) => {
                self.set_conditions(GasConditions { atmosphere: *atmosphere, ..self.conditions })
            }
            Command::Gas(gas) => self.set_conditions(GasConditions { gas: *gas, ..self.conditions }),
            Command::Advance(seconds) => {
                gauges_of(self.segment.stations_mut()).for_each(|device| device.advance(*seconds));
            }
            Command::Device(address, command) => return self.execute_at(*address, command),
            Command::Quit => {}
        }
        Ok(None)
    }

    fn set_conditions(&mut self, conditions: GasConditions) {
        self.conditions = conditions;
        gauges_of(self.segment.stations_mut()).for_each(|device| device.settle_in(conditions));
    }

    fn has_gauge(&self) -> bool {
        self.segment.stations().iter().any(|station| matches!(station, VirtualStation::Gauge(_)))
    }

    fn execute_at(&mut self, address: u8, command: &DeviceCommand<'_>) -> Result<Option<String>, CommandError> {
        let constant = self.scenario.is_none().then(|| self.conditions.pressure.mbar());
        let device = match self.station(address)? {
            VirtualStation::Gauge(device) => device,
            VirtualStation::Slave(slave) => return execute_at_slave(slave, command),
        };
        let true_mbar = constant.unwrap_or_else(|| device.environment().gas.total() / 100.0);
        match command {
            DeviceCommand::Power(on) => device.set_power(*on),
            DeviceCommand::State => return Ok(Some(state::json(device, true_mbar))),
            DeviceCommand::Order(_) => {
                return Err(CommandError::IsGauge { device: device.device().name(), address });
            }
            DeviceCommand::Operate(action) => {
                let name = device.device().name();
                device.operate_text(*action).map_err(|unknown| CommandError::NoPart {
                    device: name,
                    address,
                    unknown,
                })?;
            }
        }
        Ok(None)
    }

    fn station(&mut self, address: u8) -> Result<&mut VirtualStation, CommandError> {
        let known: Vec<_> = self.segment.stations().iter().map(VirtualStation::named).collect();
        let missing = CommandError::NoDevice { address, known: list(&known) };
        self.segment.stations_mut().iter_mut().find(|station| station.switch_address() == address).ok_or(missing)
    }
}

/// Executes a command for a slave by its GSD file.
fn execute_at_slave(slave: &mut GsdStation, command: &DeviceCommand<'_>) -> Result<Option<String>, CommandError> {
    match command {
        DeviceCommand::Power(on) => slave.set_power(*on),
        DeviceCommand::State => return Ok(Some(state::slave_json(slave))),
        DeviceCommand::Order(order) => {
            let answer = visible(&slave.execute(order)?);
            return Ok(Some(answer).filter(|answer| !answer.is_empty()));
        }
        DeviceCommand::Operate(_) => {
            let (name, address) = (slave.name().to_owned(), slave.switch_address());
            return Err(CommandError::NoGauge { name, address, faults: slave.fault_orders() });
        }
    }
    Ok(None)
}
