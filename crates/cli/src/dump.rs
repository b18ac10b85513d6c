//! `profivac dump`: reads every parameter of a gauge.

use crate::advice;
use crate::failure::Failure;
use crate::gauge::GaugeOptions;
use crate::list::{matches_target, tree};
use crate::output::{Progress, json, notice, out};
use crate::record_row::RecordRow;
use crate::whole_file::{check_absent, write_text};
use clap::Args;
use profivac_client::ParameterReading;
use profivac_client::cyclic::ChannelValue;
use profivac_client::names::NamedParameter;
use profivac_client::settings::{Dump, dump_with_progress, is_setting};
use serde::Serialize;
use std::path::PathBuf;

/// Read every readable parameter of a gauge; with --out, into a file.
///
/// Reading takes no ownership. Where several instances share a slot, it writes the Channel Instance Selector for each of them and
/// restores it at the end: meanwhile a PLC that reads this slot acyclically gets the values of another instance, without an error.
/// The selector is nonvolatile, so do not repeat the command in a loop. The file is TOML: `profivac diff` compares its settings with
/// a gauge, `profivac restore` writes them to a replacement.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    options: GaugeOptions,
    /// Write settings and readings to this file
    #[arg(long, value_name = "FILE", conflicts_with_all = ["json", "target"])]
    out: Option<PathBuf>,
    /// Overwrite FILE if it exists
    #[arg(long, requires = "out")]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Show only names that contain this text
    #[arg(value_name = "TARGET")]
    target: Option<String>,
}

const EXAMPLES: &str = "\
Examples:
  profivac dump --port /dev/ttyUSB0 --address 5
  profivac dump --port /dev/ttyUSB0 --address 5 --out gauge.toml
  profivac dump --port /tmp/line --address 5 trip-point --json";

/// A parameter in the JSON output.
#[derive(Debug, Serialize)]
struct DumpRow {
    #[serde(flatten)]
    row: Option<RecordRow>,
    /// The name of a parameter that could not be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    unread: Option<String>,
    setting: bool,
    error: Option<String>,
}

/// Reads all parameters.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(path) = &arguments.out {
        check_absent(path, arguments.force)?;
    }
    let dump = arguments.options.with_gauge(|gauge| {
        let mut progress = Progress::of("parameters");
        Ok(dump_with_progress(gauge, |done, all| progress.update(done, all))?)
    })?;
    if let Some(path) = &arguments.out {
        write_text(path, &dump.to_toml())?;
        let settings = dump.readings.iter().filter(|(named, _)| is_setting(named)).count();
        notice(&format_args!(
            "{settings} settings and {} readings in {}",
            dump.readings.len() - settings,
            path.display()
        ));
        return Ok(());
    }
    print(arguments, &dump);
    Ok(())
}

fn print(arguments: &Arguments, dump: &Dump) {
    let selected: Vec<_> =
        dump.readings.iter().filter(|(named, _)| matches_target(named, arguments.target.as_deref())).collect();
    if arguments.json {
        let lines = selected.iter().map(|(named, reading)| DumpRow {
            row: reading.as_ref().ok().map(|reading| row(dump, named, reading)),
            unread: reading.is_err().then(|| named.name.clone()),
            setting: is_setting(named),
            error: reading.as_ref().err().map(advice::sentence),
        });
        out(&json(&lines.collect::<Vec<_>>()));
        return;
    }
    let heading = format!("{} at address {}", dump.device, arguments.options.address);
    let names: Vec<_> = selected.iter().map(|(named, _)| named).collect();
    let mut readings = selected.iter().map(|(named, reading)| match reading {
        Ok(reading) => row(dump, named, reading).value_text(),
        Err(error) => format!("- {}", advice::sentence(error)),
    });
    out(&tree(&heading, &names, |_| readings.next().unwrap_or_default()));
}

/// A reading; of a Process Value with its validity.
fn row(dump: &Dump, named: &NamedParameter, reading: &ParameterReading) -> RecordRow {
    let valid = dump.pressures.get(&named.name).map(ChannelValue::is_valid);
    RecordRow { valid, reason: dump.invalid_reason(named), ..RecordRow::of(reading) }
}
