//! What every command has that speaks with one gauge.

use crate::bus::Bus;
use crate::failure::Failure;
use crate::values;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};
use profivac_host::client::records::Records;
use profivac_host::client::{ClientError, Gauge, Severity};
use profivac_host::ms2::Ms2;
use profivac_host::tool::Tool;
use std::io::{self, BufRead, IsTerminal, Write};

/// Which gauge, and how to reach it.
#[derive(Args, Debug)]
pub struct At {
    #[command(flatten)]
    pub bus: Bus,
    /// The address of the gauge
    #[arg(long, value_name = "N", value_parser = values::slave_address)]
    pub address: u8,
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

/// A gauge, whichever way it is reached.
pub type AnyGauge<'a> = Gauge<Box<dyn Records + 'a>>;

impl At {
    /// Works with the gauge, and leaves it as it was found, however the work ends.
    pub fn with<T>(&self, work: impl FnOnce(&mut AnyGauge<'_>) -> Result<T, Failure>) -> Result<T, Failure> {
        let mut tool = self.bus.open()?;
        let mut gauge = self.gauge(&mut tool)?;
        let done = work(&mut gauge);
        // Why the work failed says more than what followed from it.
        let left = gauge.finish();
        let done = done?;
        left?;
        Ok(done)
    }

    fn gauge<'a>(&self, tool: &'a mut Tool) -> Result<AnyGauge<'a>, Failure> {
        let seen = profivac_host::client::identify::meet(tool, self.address)?;
        let records: Box<dyn Records> = Box::new(Ms2::new(tool, self.address));
        Ok(Gauge::new(records, self.address, seen.ident)?)
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

/// Shows a risk and asks whether to go on. In a script somebody must have said `--yes`.
pub fn confirm(risk: &str, yes: bool) -> Result<(), Failure> {
    if yes {
        return Ok(());
    }
    if !(io::stdin().is_terminal() && io::stderr().is_terminal()) {
        return Err(Failure::usage(format!("{risk}; nothing was sent: say --yes in a script")));
    }
    eprint!("profivac: {risk}. Go on? [y/N] ");
    io::stderr().flush()?;
    let mut answer = String::new();
    io::stdin().lock().read_line(&mut answer)?;
    match answer.trim() {
        "y" | "Y" | "yes" => Ok(()),
        _ => Err(Failure::usage("nothing was sent")),
    }
}
