//! Options and steps of every command that works with one gauge.

use crate::advice;
use crate::bus::BusOptions;
use crate::console::{Signals, read, stdin};
use crate::device_files::{DeviceFileOptions, known};
use crate::failure::Failure;
use crate::output::{notice, visible};
use crate::values;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, ValueEnum};
use profivac_client::class1::Class1Session;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::discover::CyclicError;
use profivac_client::ms2::Ms2;
use profivac_client::records::{RecordError, Records};
use profivac_client::{ClientError, ErrorKind, Gauge, identify};
use profivac_devices::model::{AccessPath, Model, Unit};
use profivac_host::readiness::{Readiness, wait};
use profivac_host::scan::SlaveStatus;
use profivac_host::session::{BusSession, UnrestoredRecord};
use std::io::{self, IsTerminal, Write};
use std::time::Duration;

/// The longest single wait for the reply of the user.
const MAX_WAIT: Duration = Duration::from_secs(3600);

/// The longest answer in octets. chosen: it is a number.
const MAX_ANSWER: usize = 256;

/// The options that select a gauge and the access path to it.
#[derive(Args, Debug)]
pub struct GaugeOptions {
    #[command(flatten)]
    pub bus: BusOptions,
    /// The address of the gauge
    #[arg(long, value_name = "N", value_parser = values::slave_address)]
    pub address: u8,
    /// The access path to its parameters: ms2 takes no ownership; ms1 and pkw (the parameter channel) take ownership and unlock
    /// the gauge at the end
    #[arg(long, value_name = "WAY", default_value = "ms2")]
    via: Via,
    /// With --via ms1 or pkw: take ownership of the gauge without an announcement; required without a terminal
    #[arg(long)]
    own: bool,
}

/// The access paths to parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Via {
    Ms2,
    Ms1,
    Pkw,
}

/// The same for a command that also works without a gauge: port and address are required unless `--device` is given.
#[derive(Debug)]
pub struct OptionalGaugeOptions {
    pub gauge: Option<GaugeOptions>,
    /// Those of `gauge`, or without a bus.
    pub device_files: DeviceFileOptions,
}

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
        let is_given = matches.contains_id("port") && matches.contains_id("address");
        let device_files = DeviceFileOptions::from_arg_matches(matches)?;
        Ok(Self { gauge: is_given.then(|| GaugeOptions::from_arg_matches(matches)).transpose()?, device_files })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// A gauge on any access path.
pub type AnyGauge<'a> = Gauge<Box<dyn Records + 'a>>;

impl GaugeOptions {
    /// Runs `work` with the gauge, and restores the state of the gauge also if `work` fails.
    pub fn with_gauge<T>(&self, work: impl FnOnce(&mut AnyGauge<'_>) -> Result<T, Failure>) -> Result<T, Failure> {
        self.bus.check_not_own_address(self.address, "--address")?;
        let mut session = self.bus.open()?;
        let slave = identify::wait_for_slave(&mut session, self.address)?;
        let mut gauge = self.gauge(&mut session, &slave)?;
        let done = work(&mut gauge);
        // The failure of the work is reported, not the failure to restore that follows from it.
        let restored = gauge.restore_selector();
        let is_moved = gauge.selector_moved();
        drop(gauge);
        if let Some(left) = session.take_unrestored(self.address) {
            notice(&unrestored(self.address, left));
        } else if let (true, Some(master)) = (is_moved, slave.owner) {
            notice(&format_args!(
                "the Channel Instance Selector was changed and restored while master {master} owns the gauge"
            ));
        }
        let done = done?;
        restored?;
        Ok(done)
    }

    /// Runs `work` with the records of the slave over MS2, whatever device it is.
    pub fn with_records<T>(&self, work: impl FnOnce(&mut dyn Records) -> Result<T, Failure>) -> Result<T, Failure> {
        if self.via != Via::Ms2 {
            return Err(Failure::usage("--octets works over MS2 only: remove --via"));
        }
        self.bus.check_not_own_address(self.address, "--address")?;
        let mut session = self.bus.open()?;
        identify::wait_for_slave(&mut session, self.address)?;
        work(&mut Ms2::new(&mut session, self.address))
    }

    fn gauge<'a>(&self, session: &'a mut BusSession, slave: &SlaveStatus) -> Result<AnyGauge<'a>, Failure> {
        let address = self.address;
        let model = identify::model(known(), slave.ident, address, &mut Ms2::new(session, address))?;
        let via = match self.via {
            Via::Ms2 => return Ok(Gauge::with_model(Box::new(Ms2::new(session, address)), address, model)),
            Via::Ms1 => AccessPath::Class1,
            Via::Pkw => AccessPath::ParameterChannel,
        };
        let (records, unit) = self.take_ownership(session, slave, model, via)?;
        let records: Box<dyn Records> = Box::new(records);
        Ok(Gauge::with_model(records, address, model).with_unit(unit))
    }

    /// Takes ownership of the gauge if no other master owns it and the user has agreed.
    fn take_ownership<'a>(
        &self,
        session: &'a mut BusSession,
        slave: &SlaveStatus,
        model: &'static Model,
        via: AccessPath,
    ) -> Result<(Class1Session<'a>, &'static Unit), Failure> {
        if let Some(master) = slave.owner.filter(|owner| *owner != self.bus.master()) {
            return Err(CyclicError::OwnedByOther { address: self.address, master }.into());
        }
        if !self.own && !is_interactive() {
            return Err(Failure::usage(
                "--via ms1 and pkw take ownership of the gauge and set its parameters; without a terminal add --own",
            ));
        }
        notice(&format_args!(
            "{} at address {} gets its parameters from this master now, keeps its unit, and is unlocked at the end",
            model.name, self.address
        ));
        let cyclic = CyclicSlave::find_among(known(), session, self.address, self.bus.master())?;
        let (device, address) = (model.name, self.address);
        let session = Class1Session::open(session, &cyclic, via).map_err(|error| match error {
            RecordError::Session(error) | RecordError::NotSent(error) => error.into(),
            RecordError::Interrupted(reason) => Failure::no_answer(format!("{device} at address {address}: {reason}")),
            error => {
                let reason = advice::record_sentence(&error);
                Failure::refused(format!("{device} at address {address}: {reason}"))
            }
        })?;
        Ok((session, cyclic.unit))
    }
}

/// Names a selector that could not be restored, and the way to restore it.
fn unrestored(address: u8, left: UnrestoredRecord) -> String {
    let UnrestoredRecord { slot, index, written, original } = left;
    format!(
        "the Channel Instance Selector of the gauge at address {address} (slot {slot}, index {index}) may still show instance {written}: \
         `profivac write ... {slot}/{index} {original}` restores it"
    )
}

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        if let ClientError::Session(error) = error {
            return error.into();
        }
        let sentence = advice::sentence(&error);
        match error.kind() {
            ErrorKind::Refused => Self::refused(sentence),
            ErrorKind::Usage => Self::usage(sentence),
            ErrorKind::Line => Self::no_answer(sentence),
        }
    }
}

/// Whether standard input and standard error are terminals, so that a user can be asked.
pub fn is_interactive() -> bool {
    io::stdin().is_terminal() && io::stderr().is_terminal()
}

/// Shows a risk and asks whether to continue. Without a terminal `--yes` is required.
pub fn confirm(risk: &str, yes: bool) -> Result<(), Failure> {
    if yes {
        return Ok(());
    }
    if !is_interactive() {
        return Err(Failure::usage(format!("{risk}; nothing was sent; without a terminal add --yes")));
    }
    if ask(risk)? { Ok(()) } else { Err(Failure::usage("nothing was sent")) }
}

/// Shows a risk on the terminal and asks whether to continue.
pub fn ask(risk: &str) -> Result<bool, Failure> {
    let answer = answer(&format!("profivac: {}. Continue? [y/N] ", visible(risk)))?;
    Ok(matches!(answer.trim(), "y" | "Y" | "yes"))
}

/// Shows numbered choices on the terminal and asks for one. Returns its index; `None` if the answer is no number of a choice.
pub fn choose(question: &str, choices: &[String]) -> Result<Option<usize>, Failure> {
    let listed: String =
        (1..).zip(choices).map(|(number, choice)| format!("\n  {number}  {}", visible(choice))).collect();
    let answer = answer(&format!(
        "profivac: {}:{listed}\nNumber of the right one [1-{}, Enter: none] ",
        visible(question),
        choices.len()
    ))?;
    let index = answer.trim().parse::<usize>().ok().and_then(|number| number.checked_sub(1));
    Ok(index.filter(|index| *index < choices.len()))
}

/// Shows a question on the terminal and waits for the answer. A signal ends the command.
fn answer(question: &str) -> Result<String, Failure> {
    // Signals are caught before the prompt is visible.
    let signals = Signals::catch()?;
    write!(io::stderr(), "{question}")?;
    io::stderr().flush()?;
    // The user may also answer with Ctrl-C.
    let answer = line(&signals)?;
    answer.ok_or_else(|| {
        // An error of the terminal is reported by what follows.
        writeln!(io::stderr()).ok();
        Failure::interrupted_with("nothing was chosen, and nothing is sent")
    })
}

/// Waits for a line; `None` if a signal arrives first.
fn line(signals: &Signals) -> Result<Option<String>, Failure> {
    let stdin = stdin()?;
    let (mut line, mut octet) = (Vec::new(), [0]);
    loop {
        match wait(&[signals.readiness(), Readiness::of(&stdin)], MAX_WAIT)?.as_slice() {
            [true, _] => return Ok(None),
            [_, true] if read(&stdin, &mut octet)? == 0 || octet == [b'\n'] || line.len() >= MAX_ANSWER => {
                return Ok(Some(String::from_utf8_lossy(&line).into_owned()));
            }
            [_, true] => line.extend(octet),
            _ => {}
        }
    }
}
