//! The program `profivac`: one module per command, each with its arguments, its help and its `run`.

mod bus;
mod conform;
mod console;
mod demo;
mod failure;
mod gsd;
mod hub;
mod monitor;
mod output;
mod scan;
mod screen;
mod simulate;
mod values;

use clap::{Parser, Subcommand};
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
    Monitor(monitor::Arguments),
    Conform(conform::Arguments),
    Gsd(gsd::Arguments),
}

fn main() -> ExitCode {
    let done = match Profivac::parse().command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Hub(arguments) => hub::run(&arguments),
        Command::Scan(arguments) => scan::run(&arguments),
        Command::Monitor(arguments) => monitor::run(&arguments),
        Command::Conform(arguments) => conform::run(&arguments),
        Command::Gsd(arguments) => gsd::run(&arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("profivac: {failure}");
            failure.into()
        }
    }
}
