//! The program `profivac`: one module per command, each with its arguments, its help and its `run`.

mod address;
mod advice;
#[cfg(feature = "archive")]
mod archive;
mod backup;
mod bus;
mod completions;
mod conform;
mod console;
mod database;
mod decode;
mod demo;
mod device;
mod device_files;
mod diff;
mod doctor;
mod dump;
mod explanation;
mod export;
mod failure;
mod field_test;
mod gateways;
mod gauge;
mod gsd;
mod gsd_files;
mod gsd_slaves;
mod hub;
mod identify;
mod init;
mod list;
mod monitor;
mod names;
mod octets;
mod output;
mod read;
mod record_row;
mod report;
mod restore;
mod run;
mod scan;
mod screen;
mod simulate;
mod sniff;
mod st;
mod time_argument;
mod user;
mod values;
mod whole_file;
mod write;
mod write_failure;
mod zeros;

use clap::{CommandFactory, Parser, Subcommand};
use failure::Failure;
use std::process::ExitCode;

/// PROFIBUS DP for vacuum gauges: virtual devices, a bus master, and a station.
#[derive(Debug, Parser)]
#[command(name = "profivac", version, arg_required_else_help = true, after_help = EXIT_CODES)]
struct Profivac {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "\
Where to start, without a bus:
  profivac demo
  profivac simulate --pty /tmp/line --pressure '5e-6 mbar' bcg450@5
and in another terminal, or with the port of an adapter:
  profivac scan --port /tmp/line
  profivac dump --port /tmp/line --address 5
`profivac help COMMAND` has examples for every command. docs/first-steps.md is an introduction that takes fifteen minutes.

Exit codes:
  0  done
  1  the device refused, a rule of conform is broken, an expectation of a scenario is not met, or `diff` found differences
  2  wrong usage, unknown device, two devices at one address, or a bad file
  3  the port is missing, busy or lost, no station answers, a signal ended the command, or standard output cannot be written";

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
    #[cfg(feature = "archive")]
    Archive(archive::Arguments),
    Names(names::Arguments),
    User(user::Arguments),
    Init(init::Arguments),
    Report(report::Arguments),
    Export(export::Arguments),
    Backup(backup::Arguments),
    Identify(identify::Arguments),
    Address(address::Arguments),
    Conform(conform::Arguments),
    Doctor(doctor::Arguments),
    FieldTest(field_test::Arguments),
    Sniff(sniff::Arguments),
    Decode(decode::Arguments),
    Device(device::Arguments),
    Gsd(gsd::Arguments),
    St(st::Arguments),
    Completions(completions::Arguments),
}

fn main() -> ExitCode {
    let done = match Profivac::try_parse() {
        Ok(profivac) => run(profivac.command).and_then(|()| output::check()),
        Err(error) => output::print_usage(&error),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !failure.is_quiet() {
                output::notice(&failure);
            }
            failure.into()
        }
    }
}

fn run(command: Command) -> Result<(), Failure> {
    match command {
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
        #[cfg(feature = "archive")]
        Command::Archive(arguments) => archive::run(&arguments),
        Command::Names(arguments) => names::run(&arguments),
        Command::User(arguments) => user::run(&arguments),
        Command::Init(arguments) => init::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Backup(arguments) => backup::run(&arguments),
        Command::Identify(arguments) => identify::run(&arguments),
        Command::Address(arguments) => address::run(&arguments),
        Command::Conform(arguments) => conform::run(&arguments),
        Command::Doctor(arguments) => doctor::run(&arguments),
        Command::FieldTest(arguments) => field_test::run(&arguments),
        Command::Sniff(arguments) => sniff::run(&arguments),
        Command::Decode(arguments) => decode::run(&arguments),
        Command::Device(arguments) => device::run(&arguments),
        Command::Gsd(arguments) => gsd::run(&arguments),
        Command::St(arguments) => st::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments, Profivac::command()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// The command lines of a help text, split into words as a shell does, up to a redirection or a comment.
    fn examples(help: &str) -> Vec<Vec<String>> {
        let lines = help.lines().filter_map(|line| line.strip_prefix("  profivac "));
        lines.map(|line| words(&format!("profivac {line}"))).collect()
    }

    fn words(line: &str) -> Vec<String> {
        let mut words = Vec::new();
        for (number, part) in line.split('\'').enumerate() {
            match number % 2 {
                1 => words.push(part.to_owned()),
                _ => words.extend(part.split_whitespace().map(str::to_owned)),
            }
        }
        words
            .into_iter()
            .take_while(|word| !["|", "||", "&&", ";", "&", ">", "<", "#"].contains(&word.as_str()))
            .collect()
    }

    #[test]
    fn every_command_and_every_option_has_a_help_text() {
        Profivac::command().debug_assert();
        for command in Profivac::command().get_subcommands() {
            let name = command.get_name();
            assert!(command.get_about().is_some(), "{name}");
            for argument in command.get_arguments() {
                assert!(argument.get_help().is_some(), "{name} {}", argument.get_id());
            }
        }
    }

    #[test]
    fn every_command_has_examples_that_the_parser_accepts() {
        for command in Profivac::command().get_subcommands() {
            let name = command.get_name();
            let help = command.get_after_help().unwrap_or_else(|| panic!("{name}")).to_string();
            let examples = examples(&help);
            assert!(examples.iter().any(|example| example[1] == name), "{name}: {help}");
            for example in examples {
                assert!(Profivac::try_parse_from(&example).is_ok(), "{example:?}");
            }
        }
        let help = Profivac::command().get_after_help().unwrap().to_string();
        for example in examples(&help) {
            assert!(Profivac::try_parse_from(&example).is_ok(), "{example:?}");
        }
    }

    #[test]
    fn the_readme_has_a_row_for_every_command() {
        let readme = include_str!("../../../README.md");
        let (_, table) = readme.split_once("| Command |").unwrap();
        let (table, _) = table.split_once("\n\n").unwrap();
        let mut named: Vec<&str> = table
            .lines()
            .skip(2)
            .flat_map(|row| {
                let cell = row.split('|').nth(1).unwrap_or_default();
                cell.split('`').skip(1).step_by(2)
            })
            .collect();
        let mut existing: Vec<String> =
            Profivac::command().get_subcommands().map(|command| command.get_name().to_owned()).collect();
        // Its row says that it comes with a feature.
        named.retain(|name| cfg!(feature = "archive") || *name != "archive");
        named.sort_unstable();
        existing.sort_unstable();
        assert_eq!(named, existing);
    }

    #[test]
    fn the_readme_has_the_effect_of_every_command_that_can_be_a_master() {
        let readme = include_str!("../../../README.md");
        let (_, table) = readme.split_once("| Effect on the gauges |").unwrap();
        let (table, _) = table.split_once("\n\n").unwrap();
        let cells = table
            .lines()
            .skip(2)
            .flat_map(|row| row.split('|').nth(2).unwrap_or_default().split('`').skip(1).step_by(2));
        let named: BTreeSet<&str> =
            cells.filter_map(|text| text.split(' ').next()).filter(|word| !word.starts_with('-')).collect();
        for name in &named {
            assert!(Profivac::command().find_subcommand(name).is_some(), "{name}");
        }
        for command in Profivac::command().get_subcommands() {
            let is_master = command.get_arguments().any(|argument| argument.get_id() == "master");
            assert!(!is_master || named.contains(command.get_name()), "{}", command.get_name());
        }
    }
}
