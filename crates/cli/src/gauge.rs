//! What every command has that speaks with one gauge.

use crate::bus::BusOptions;
use crate::console::Signals;
use crate::failure::Failure;
use crate::output::notice;
use crate::values;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, ValueEnum};
use profivac_client::class1::Class1Session;
use profivac_client::cyclic::{CyclicError, CyclicSlave};
use profivac_client::ms2::Ms2;
use profivac_client::records::{RecordError, Records};
use profivac_client::{ClientError, ErrorKind, Gauge, identify};
use profivac_devices::model::{AccessPath, Model, Unit};
use profivac_host::port;
use profivac_host::scan::SlaveStatus;
use profivac_host::session::BusSession;
use rustix::fd::AsFd;
use std::io::{self, BufRead, IsTerminal, Write};
use std::time::Duration;

/// How long people are waited for at a time.
const MAX_WAIT: Duration = Duration::from_secs(3600);

/// Which gauge, and how to reach it.
#[derive(Args, Debug)]
pub struct GaugeOptions {
    #[command(flatten)]
    pub bus: BusOptions,
    /// The address of the gauge
    #[arg(long, value_name = "N", value_parser = values::slave_address)]
    pub address: u8,
    /// How to reach its parameters: ms2 claims nothing; ms1 and pkw, the parameter channel, take the gauge over and unlock it
    /// at the end
    #[arg(long, value_name = "WAY", default_value = "ms2")]
    via: Via,
    /// With --via ms1 or pkw: take the gauge over without telling anybody; needed where no terminal is
    #[arg(long)]
    own: bool,
}

/// The ways to parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Via {
    Ms2,
    Ms1,
    Pkw,
}

/// The same for a command that can do without: port and address are needed unless `--device` is given.
#[derive(Debug)]
pub struct OptionalGaugeOptions(pub Option<GaugeOptions>);

impl Args for OptionalGaugeOptions {
    fn augment_args(command: Command) -> Command {
        let optional = |arg: Arg| arg.required(false).required_unless_present("device").conflicts_with("device");
        GaugeOptions::augment_args(command).mut_arg("port", optional).mut_arg("address", optional)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for OptionalGaugeOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let there = matches.contains_id("port") && matches.contains_id("address");
        Ok(Self(there.then(|| GaugeOptions::from_arg_matches(matches)).transpose()?))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Records until somebody wants to stop: then the next request fails, once, so that what was changed on the way can still be
/// put back.
struct Interruptible<R> {
    records: R,
    signals: Signals,
    reported: bool,
}

impl<R> Interruptible<R> {
    fn check(&mut self) -> Result<(), RecordError> {
        if !self.reported && self.signals.are_pending() {
            self.reported = true;
            return Err(RecordError::Interrupted("interrupted by a signal".to_owned()));
        }
        Ok(())
    }
}

impl<R: Records> Records for Interruptible<R> {
    fn via(&self) -> AccessPath {
        self.records.via()
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        self.check()?;
        self.records.read(slot, index)
    }

    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        self.check()?;
        self.records.write(slot, index, octets)
    }
}

/// A gauge, whichever way it is reached.
pub type AnyGauge<'a> = Gauge<Box<dyn Records + 'a>>;

impl GaugeOptions {
    /// Works with the gauge, and leaves it as it was found, however the work ends.
    pub fn with_gauge<T>(&self, work: impl FnOnce(&mut AnyGauge<'_>) -> Result<T, Failure>) -> Result<T, Failure> {
        self.bus.check_not_own_address(self.address, "--address")?;
        let mut tool = self.bus.open()?;
        let seen = identify::wait_for_slave(&mut tool, self.address)?;
        let mut gauge = self.gauge(&mut tool, &seen)?;
        let done = work(&mut gauge);
        // Why the work failed says more than what followed from it.
        let left = gauge.restore_selector();
        if let (true, Some(master)) = (gauge.selector_moved(), seen.owner) {
            notice(&format_args!(
                "the Channel Instance Selector was moved and put back while master {master} owns the gauge"
            ));
        }
        let done = done?;
        left?;
        Ok(done)
    }

    fn gauge<'a>(&self, tool: &'a mut BusSession, seen: &SlaveStatus) -> Result<AnyGauge<'a>, Failure> {
        let address = self.address;
        let model = identify::model(seen.ident, address, &mut Ms2::new(tool, address))?;
        // Until here a signal may end it anywhere: nothing has to be put back.
        let signals = Signals::catch()?;
        let via = match self.via {
            Via::Ms2 => {
                let records = Interruptible { records: Ms2::new(tool, address), signals, reported: false };
                return Ok(Gauge::with_model(Box::new(records), address, model));
            }
            Via::Ms1 => AccessPath::Class1,
            Via::Pkw => AccessPath::ParameterChannel,
        };
        let (records, unit) = self.take_ownership(tool, seen, model, via, &signals)?;
        let records: Box<dyn Records> = Box::new(Interruptible { records, signals, reported: false });
        Ok(Gauge::with_model(records, address, model).with_unit(unit))
    }

    /// Takes the gauge over, if nobody else has it and somebody wants it.
    fn take_ownership<'a>(
        &self,
        tool: &'a mut BusSession,
        seen: &SlaveStatus,
        model: &'static Model,
        via: AccessPath,
        signals: &Signals,
    ) -> Result<(Class1Session<'a>, &'static Unit), Failure> {
        if let Some(master) = seen.owner.filter(|owner| *owner != self.bus.master()) {
            return Err(CyclicError::OwnedByOther { address: self.address, master }.into());
        }
        if !self.own && !is_interactive() {
            return Err(Failure::usage("--via ms1 and pkw parameterise the gauge and own it: say --own in a script"));
        }
        notice(&format_args!(
            "{} at address {} is parameterised now, with the unit it has, and unlocked at the end",
            model.name, self.address
        ));
        let watched = CyclicSlave::find(tool, self.address, self.bus.master())?;
        let (device, address) = (model.name, self.address);
        let owned =
            Class1Session::open_unless(tool, &watched, via, &|| signals.are_pending()).map_err(
                |error| match error {
                    RecordError::Session(error) => error.into(),
                    RecordError::Interrupted(reason) => {
                        Failure::no_answer(format!("{device} at address {address}: {reason}"))
                    }
                    error => Failure::refused(format!("{device} at address {address}: {error}")),
                },
            )?;
        Ok((owned, watched.unit))
    }
}

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        let sentence = error.to_string();
        match error.kind() {
            ErrorKind::Refused => Self::refused(sentence),
            ErrorKind::Usage => Self::usage(sentence),
            ErrorKind::Line => Self::no_answer(sentence),
        }
    }
}

/// Whether people sit in front of standard input and see what is said.
fn is_interactive() -> bool {
    io::stdin().is_terminal() && io::stderr().is_terminal()
}

/// Shows a risk and asks whether to go on. In a script somebody must have said `--yes`.
pub fn confirm(risk: &str, yes: bool) -> Result<(), Failure> {
    if yes {
        return Ok(());
    }
    if !is_interactive() {
        return Err(Failure::usage(format!("{risk}; nothing was sent: say --yes in a script")));
    }
    // Before anybody sees the question.
    let signals = Signals::catch()?;
    write!(io::stderr(), "profivac: {risk}. Go on? [y/N] ")?;
    io::stderr().flush()?;
    // Whoever is asked may also answer with Ctrl-C.
    if !wait_for_line(&signals)? {
        writeln!(io::stderr())?;
        return Err(Failure::usage("nothing was sent"));
    }
    let mut answer = String::new();
    io::stdin().lock().read_line(&mut answer)?;
    match answer.trim() {
        "y" | "Y" | "yes" => Ok(()),
        _ => Err(Failure::usage("nothing was sent")),
    }
}

/// Waits for a line. False if a signal comes instead.
fn wait_for_line(signals: &Signals) -> Result<bool, Failure> {
    let stdin = io::stdin();
    loop {
        match port::wait(&[signals.as_fd(), stdin.as_fd()], MAX_WAIT)?.as_slice() {
            [true, _] => return Ok(false),
            [_, true] => return Ok(true),
            _ => {}
        }
    }
}
