//! The program `profivac`: one module per command, each with its arguments, its help and its `run`.

mod address;
mod bus;
mod completions;
mod conform;
mod console;
mod decode;
mod demo;
mod diff;
mod dump;
mod failure;
mod gauge;
mod gsd;
mod hub;
mod init;
mod list;
mod monitor;
mod output;
mod read;
mod restore;
mod run;
mod scan;
mod screen;
mod simulate;
mod sniff;
mod story;
mod values;
mod write;

use clap::{CommandFactory, Parser, Subcommand};
use std::process::ExitCode;

/// PROFIBUS DP for vacuum gauges: virtual devices, a bus master, and the tools around them.
#[derive(Debug, Parser)]
#[command(name = "profivac", version, arg_required_else_help = true, after_help = EXIT_CODES)]
struct Profivac {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  the device refused
  2  wrong usage, unknown device, two devices at one address, or a bad file
  3  the port is missing, busy or lost, or nobody answers";

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Arguments),
    Simulate(simulate::Arguments),
    Hub(hub::Arguments),
    Scan(scan::Arguments),
    List(list::Arguments),
    Read(read::Arguments),
    Write(write::Arguments),
    Dump(dump::Arguments),
    Diff(diff::Arguments),
    Restore(restore::Arguments),
    Monitor(monitor::Arguments),
    Run(run::Arguments),
    Init(init::Arguments),
    Address(address::Arguments),
    Conform(conform::Arguments),
    Sniff(sniff::Arguments),
    Decode(decode::Arguments),
    Gsd(gsd::Arguments),
    Completions(completions::Arguments),
}

fn main() -> ExitCode {
    let done = match Profivac::parse().command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Hub(arguments) => hub::run(&arguments),
        Command::Scan(arguments) => scan::run(&arguments),
        Command::List(arguments) => list::run(&arguments),
        Command::Read(arguments) => read::run(&arguments),
        Command::Dump(arguments) => dump::run(&arguments),
        Command::Diff(arguments) => diff::run(&arguments),
        Command::Restore(arguments) => restore::run(&arguments),
        Command::Write(arguments) => write::run(&arguments),
        Command::Monitor(arguments) => monitor::run(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        Command::Init(arguments) => init::run(&arguments),
        Command::Address(arguments) => address::run(&arguments),
        Command::Conform(arguments) => conform::run(&arguments),
        Command::Sniff(arguments) => sniff::run(&arguments),
        Command::Decode(arguments) => decode::run(&arguments),
        Command::Gsd(arguments) => gsd::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments, Profivac::command()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("profivac: {failure}");
            failure.into()
        }
    }
}
