//! What every command has that speaks with one gauge.

use crate::bus::Bus;
use crate::console::Signals;
use crate::failure::Failure;
use crate::output::remark;
use crate::values;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, ValueEnum};
use profivac_client::class1::Owned;
use profivac_client::ms2::Ms2;
use profivac_client::records::{RecordError, Records};
use profivac_client::watch::{WatchError, Watched};
use profivac_client::{ClientError, Gauge, Severity, identify};
use profivac_devices::model::{Model, Unit, Via};
use profivac_host::port;
use profivac_host::scan::SlaveSeen;
use profivac_host::session::BusSession;
use rustix::fd::AsFd;
use std::io::{self, BufRead, IsTerminal, Write};
use std::time::Duration;

/// How long people are waited for at a time.
const PATIENCE: Duration = Duration::from_secs(3600);

/// Which gauge, and how to reach it.
#[derive(Args, Debug)]
pub struct At {
    #[command(flatten)]
    pub bus: Bus,
    /// The address of the gauge
    #[arg(long, value_name = "N", value_parser = values::slave_address)]
    pub address: u8,
    /// How to reach its parameters: ms2 claims nothing; ms1 and pkw, the parameter channel, take the gauge over and unlock it
    /// at the end
    #[arg(long, value_name = "WAY", default_value = "ms2")]
    via: Way,
    /// With --via ms1 or pkw: take the gauge over without telling anybody; needed where no terminal is
    #[arg(long)]
    own: bool,
}

/// The ways to parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Way {
    Ms2,
    Ms1,
    Pkw,
}

/// The same for a command that can do without: port and address are needed unless `--device` is given.
#[derive(Debug)]
pub struct MaybeAt(pub Option<At>);

impl Args for MaybeAt {
    fn augment_args(command: Command) -> Command {
        let optional = |arg: Arg| arg.required(false).required_unless_present("device").conflicts_with("device");
        At::augment_args(command).mut_arg("port", optional).mut_arg("address", optional)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for MaybeAt {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let there = matches.contains_id("port") && matches.contains_id("address");
        Ok(Self(there.then(|| At::from_arg_matches(matches)).transpose()?))
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
    told: bool,
}

impl<R> Interruptible<R> {
    fn check(&mut self) -> Result<(), RecordError> {
        if !self.told && self.signals.are_pending() {
            self.told = true;
            return Err(RecordError::Lost("interrupted by a signal".to_owned()));
        }
        Ok(())
    }
}

impl<R: Records> Records for Interruptible<R> {
    fn via(&self) -> Via {
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

impl At {
    /// Works with the gauge, and leaves it as it was found, however the work ends.
    pub fn with<T>(&self, work: impl FnOnce(&mut AnyGauge<'_>) -> Result<T, Failure>) -> Result<T, Failure> {
        self.bus.check_other(self.address, "--address")?;
        let mut tool = self.bus.open()?;
        let seen = identify::meet(&mut tool, self.address)?;
        let mut gauge = self.gauge(&mut tool, &seen)?;
        let done = work(&mut gauge);
        // Why the work failed says more than what followed from it.
        let left = gauge.finish();
        if let (true, Some(master)) = (gauge.has_moved(), seen.owner) {
            remark(&format_args!(
                "the Channel Instance Selector was moved and put back while master {master} owns the gauge"
            ));
        }
        let done = done?;
        left?;
        Ok(done)
    }

    fn gauge<'a>(&self, tool: &'a mut BusSession, seen: &SlaveSeen) -> Result<AnyGauge<'a>, Failure> {
        let address = self.address;
        let model = identify::model(seen.ident, address, &mut Ms2::new(tool, address))?;
        // Until here a signal may end it anywhere: nothing has to be put back.
        let signals = Signals::catch()?;
        let via = match self.via {
            Way::Ms2 => {
                let records = Interruptible { records: Ms2::new(tool, address), signals, told: false };
                return Ok(Gauge::known(Box::new(records), address, model));
            }
            Way::Ms1 => Via::Class1,
            Way::Pkw => Via::Channel,
        };
        let (records, unit) = self.own(tool, seen, model, via, &signals)?;
        let records: Box<dyn Records> = Box::new(Interruptible { records, signals, told: false });
        Ok(Gauge::known(records, address, model).in_unit(unit))
    }

    /// Takes the gauge over, if nobody else has it and somebody wants it.
    fn own<'a>(
        &self,
        tool: &'a mut BusSession,
        seen: &SlaveSeen,
        model: &'static Model,
        via: Via,
        signals: &Signals,
    ) -> Result<(Owned<'a>, &'static Unit), Failure> {
        if let Some(master) = seen.owner.filter(|owner| *owner != self.bus.master()) {
            return Err(WatchError::Owned { address: self.address, master }.into());
        }
        if !self.own && !somebody_is_there() {
            return Err(Failure::usage("--via ms1 and pkw parameterise the gauge and own it: say --own in a script"));
        }
        remark(&format_args!(
            "{} at address {} is parameterised now, with the unit it has, and unlocked at the end",
            model.name, self.address
        ));
        let watched = Watched::find(tool, self.address, self.bus.master())?;
        let (device, address) = (model.name, self.address);
        let owned =
            Owned::take_unless(tool, &watched, via, &|| signals.are_pending()).map_err(|error| match error {
                RecordError::Tool(error) => error.into(),
                RecordError::Lost(reason) => Failure::no_answer(format!("{device} at address {address}: {reason}")),
                error => Failure::refused(format!("{device} at address {address}: {error}")),
            })?;
        Ok((owned, watched.unit))
    }
}

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        let sentence = error.to_string();
        match error.severity() {
            Severity::Refused => Self::refused(sentence),
            Severity::Usage => Self::usage(sentence),
            Severity::Line => Self::no_answer(sentence),
        }
    }
}

/// Whether people sit in front of standard input and see what is said.
fn somebody_is_there() -> bool {
    io::stdin().is_terminal() && io::stderr().is_terminal()
}

/// Shows a risk and asks whether to go on. In a script somebody must have said `--yes`.
pub fn confirm(risk: &str, yes: bool) -> Result<(), Failure> {
    if yes {
        return Ok(());
    }
    if !somebody_is_there() {
        return Err(Failure::usage(format!("{risk}; nothing was sent: say --yes in a script")));
    }
    // Before anybody sees the question.
    let signals = Signals::catch()?;
    write!(io::stderr(), "profivac: {risk}. Go on? [y/N] ")?;
    io::stderr().flush()?;
    // Whoever is asked may also answer with Ctrl-C.
    if !answers(&signals)? {
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
fn answers(signals: &Signals) -> Result<bool, Failure> {
    let stdin = io::stdin();
    loop {
        match port::wait(&[signals.as_fd(), stdin.as_fd()], PATIENCE)?.as_slice() {
            [true, _] => return Ok(false),
            [_, true] => return Ok(true),
            _ => {}
        }
    }
}
