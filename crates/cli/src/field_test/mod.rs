//! `profivac field-test`: measures an adapter and the slaves on a line, and puts everything into one archive.

mod archive;
mod capture;
mod expectation;
mod figures;
mod line;
mod read_only;
mod redact;
mod replay;
mod report;
mod run;

use crate::bus::{BusOptions, MasterOptions};
use crate::console::Signals;
use crate::failure::Failure;
use crate::gsd_slaves::GsdOptions;
use crate::output::{notice, out};
use archive::{Archive, Output};
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use line::Line;
use replay::{Comparison, Replay};
use report::{CYCLES, Options};
use run::{GsdSource, Run};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Measure an adapter and the slaves on its line, and write one archive that can be sent to the developers.
///
/// It listens first, and ends without sending anything if another master is on the line. Then it scans the line, tests the rules
/// of `conform` that only read, and measures the answers of each slave. The archive contains a report, a capture and timing
/// figures, but no names of the computer and no serial numbers: docs/field-test.md lists its contents. With `--gsd` and --allow-writes
/// slaves of any vendor get the parameters of their GSD files, and more rules test what the files state. The command shows the outputs
/// of a slave that is not a known gauge and asks first, because zeros can stop a pump or close a valve. A run that ends early, also
/// with Ctrl-C, writes an archive that says so.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A serial device, a pty, tcp://HOST:PORT, or sim:FILE.toml for a segment in memory
    #[arg(
        long,
        value_name = "PORT",
        value_parser = NonEmptyStringValueParser::new(),
        required_unless_present = "replay"
    )]
    port: Option<String>,
    #[command(flatten)]
    master: MasterOptions,
    /// The archive to write; its name must not exist yet
    #[arg(long, value_name = "FILE.tar", required_unless_present = "replay")]
    out: Option<PathBuf>,
    /// Test all rules of `conform`: slaves without owner get parameters and outputs of zero, and are released, many times
    #[arg(long)]
    allow_writes: bool,
    /// Send zeros as the outputs of slaves that are not known gauges without a question; without it and without a terminal, only rules
    /// that read are tested with such slaves
    #[arg(long, requires = "allow_writes")]
    own: bool,
    /// Measured requests of each service to each slave, 1 to 100000
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = cycles)]
    cycles: usize,
    #[command(flatten)]
    gsd: GsdOptions,
    /// Keep the contents of records (serial numbers, texts) in the capture
    #[arg(long)]
    with_serial_numbers: bool,
    /// Repeat the run of an archive without its line, and compare the results
    #[arg(long, value_name = "FILE.tar", conflicts_with_all = ["port", "out", "allow_writes", "with_serial_numbers", "paths"])]
    replay: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  profivac field-test --port /dev/ttyUSB0 --baud 19200 --out line.tar
  profivac field-test --port /dev/ttyUSB0 --hsa 20 --cycles 1000 --allow-writes --out gauges.tar
  profivac field-test --port /dev/ttyUSB0 --gsd gsd_files --allow-writes --out valves.tar
  profivac field-test --replay line.tar

The rate of a line is fixed, so an archive has figures for one rate. docs/field-test.md says how to measure others.";

/// A text that is no number of [`CYCLES`].
#[derive(Debug, thiserror::Error)]
#[error("expected a number from {least} to {most}, got {0:?}", least = CYCLES.start(), most = CYCLES.end())]
struct CyclesError(String);

fn cycles(text: &str) -> Result<usize, CyclesError> {
    let number = text.parse().ok().filter(|number| CYCLES.contains(number));
    number.ok_or_else(|| CyclesError(text.to_owned()))
}

/// Runs a field test, or replays one.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match (&arguments.replay, &arguments.port, &arguments.out) {
        (Some(archive), ..) => replay_archive(archive),
        (None, Some(port), Some(path)) => measure(arguments, port, path),
        (None, ..) => Err(Failure::usage("expected --port PORT and --out FILE.tar, or --replay FILE.tar")),
    }
}

fn measure(arguments: &Arguments, port: &str, path: &Path) -> Result<(), Failure> {
    let bus = BusOptions::new(port, &arguments.master);
    bus.check()?;
    let catalog = arguments.gsd.read()?;
    let output = Output::create(path)?;
    let options = Options {
        baud: bus.rate().initial().bits_per_second(),
        master: bus.master(),
        hsa: bus.hsa(),
        cycles: arguments.cycles,
        allow_writes: arguments.allow_writes,
        with_serial_numbers: arguments.with_serial_numbers,
    };
    if arguments.allow_writes {
        notice(
            &"--allow-writes: slaves without owner get parameters and outputs of zero, and are released, many times",
        );
    }
    let signals = Signals::catch()?;
    let mut run = Run::new(&bus, Line::at_port(&bus), options, Some(&signals), Arc::default());
    run.gsd = GsdSource::Files(catalog);
    run.own = arguments.own;
    let done = run.all_steps();
    if run.report.port.is_none() {
        // The port was never open, so nothing was measured.
        return done;
    }
    let (files, done) = run.finish(done);
    let text = report::as_text(&run.report);
    let contents = archive::files(&run.report, &text, &files.capture, &files.pieces);
    let contents: Vec<_> = contents.iter().map(|(name, octets)| (*name, octets.as_slice())).collect();
    output.write(&contents)?;
    out(text.trim_end());
    notice(&format_args!("{} contains the results; read its README before you send it", path.display()));
    done
}

/// Repeats the run of an archive. Results that differ are exit code 1.
fn replay_archive(path: &Path) -> Result<(), Failure> {
    let archive = Archive::read(path)?;
    let recorded = &archive.report;
    if !recorded.complete {
        return Err(Failure::usage(format!(
            "{}: expected an archive of a complete run, found one that ended early: {}",
            path.display(),
            recorded.end
        )));
    }
    let baud = archive.rate()?;
    let replay = Replay::of(&archive)?;
    let unknown = replay.unknown_requests();
    let master = MasterOptions::new(baud, recorded.options.master, recorded.options.hsa);
    let bus = BusOptions::new("archive", &master);
    bus.check()?;
    let signals = Signals::catch()?;
    let line = Line::of_archive(replay, baud);
    let mut run = Run::new(&bus, line, recorded.options.clone(), Some(&signals), unknown);
    let facts = recorded.slaves.iter().filter_map(|slave| Some((slave.address, slave.gsd.clone()?)));
    let notes = recorded.slaves.iter().filter_map(|slave| Some((slave.address, slave.limits_note.clone()?)));
    run.gsd = GsdSource::Recorded { facts: facts.collect(), notes: notes.collect() };
    run.all_steps()?;
    let comparison = Comparison::of(recorded, &run.report);
    comparison.differences.iter().for_each(|difference| out(difference));
    out(&format!(
        "stations: {}, slaves: {}, rules with the same outcome: {}, rules that the archive does not have: {}",
        run.report.stations.len(),
        run.report.slaves.len(),
        comparison.same_rules,
        comparison.unknown_rules
    ));
    match comparison.differences.len() {
        0 => Ok(()),
        count => Err(Failure::refused(format!(
            "{}: the replay differs from the archive in {count} result{}; the archive is of version {}",
            path.display(),
            if count == 1 { "" } else { "s" },
            recorded.version
        ))),
    }
}
