//! `profivac write`: writes a parameter of a gauge, or sends a command.

use crate::failure::Failure;
use crate::gauge::{AnyGauge, GaugeOptions, confirm};
use crate::octets;
use crate::output::{json, out};
use crate::record_row::RecordRow;
use crate::write_failure::{before_write, print_failure};
use clap::Args;
use profivac_client::records::WriteEffect;
use profivac_client::{ClientError, PreparedWrite, WriteResult};
use profivac_devices::catalog::is_built_in;
use serde::Serialize;

/// Write a parameter of a gauge, or send a command by name.
///
/// TARGET VALUE is a parameter with its whole name, or its numbers, and its value: `trip-point.1/low-trip-point '1e-3 mbar'`. A
/// value is a number, one of the names that `profivac list` shows, or a pressure with any unit of the gauge: `1e-3 mbar`.
/// A command needs no value: `execute`, `stop`, `degas on`, `emission off`, `zero-adjust`; if several parts have it, name the
/// part: `cdg.zero-adjust`, `channel.1/degas on`.
///
/// Before anything is sent, the value is checked against the table and the measuring range, and the conditions of a command against the
/// gauge. The output shows the value before and after. A command that switches emission or degas, adjusts, or stops the measurement asks
/// for confirmation on a terminal and needs --yes without one. Commands of a device file are marked in the question and in the output:
/// their conditions and risks are as good as the file.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    options: GaugeOptions,
    /// Do not ask for confirmation
    #[arg(long)]
    yes: bool,
    /// Write octets to a record of any slave with DP-V1, also of an unknown device: TARGET is SLOT/INDEX, VALUE is hex like '11 21'.
    /// Nothing is checked, so this asks for confirmation
    #[arg(long, conflicts_with = "force")]
    octets: bool,
    /// Write a pressure outside the measuring range of the gauge
    #[arg(long)]
    force: bool,
    /// Print JSON; after a failure its key `effect` says whether the gauge has the value: not-sent, refused, possibly-executed or executed
    #[arg(long)]
    json: bool,
    /// The parameter to write, or a command
    #[arg(value_name = "TARGET", required = true)]
    target: String,
    /// The new value
    #[arg(value_name = "VALUE", allow_hyphen_values = true)]
    value: Option<String>,
}

const EXAMPLES: &str = "\
Examples:
  profivac write --port /dev/ttyUSB0 --address 5 pirani.safe-state use-safe-value
  profivac write --port /dev/ttyUSB0 --address 5 trip-point.1/low-trip-point '2e-3 mbar'
  profivac write --port /dev/ttyUSB0 --address 5 execute
  profivac write --port /dev/ttyUSB0 --address 5 --yes degas on
  profivac write --port /dev/ttyUSB0 --address 9 --octets 1/24 '00 3F'     # any slave with DP-V1";

/// Marks a command whose conditions and risk come from a device file.
const OF_DEVICE_FILE: &str = " (a command of a device file)";

/// A write in the JSON output.
#[derive(Debug, Serialize)]
struct Change {
    name: String,
    slot: u8,
    instance: u8,
    index: u8,
    written: String,
    before: Option<RecordRow>,
    after: Option<RecordRow>,
    /// A command of a device file.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    from_device_file: bool,
}

/// Checks, asks for confirmation, sends, reads back.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.octets {
        let Arguments { options, target, value, yes, json, .. } = arguments;
        return octets::write(options, target, value.as_deref(), *yes, *json);
    }
    // The effect of a write that has no output yet.
    let mut effect = Some(WriteEffect::NotSent);
    let done = arguments.options.with_gauge(|gauge| {
        let prepared = prepare(gauge, arguments)?;
        let is_command = prepared.named.parameter.row.codes.is_command();
        let from_device_file = is_command && !is_built_in(gauge.model());
        if let Some(risk) = prepared.code.map(|code| code.risk).filter(|risk| !risk.is_empty()) {
            let mark = if from_device_file { OF_DEVICE_FILE } else { "" };
            confirm(&format!("{} {} {risk}{mark}", prepared.named.name, prepared.text), arguments.yes)?;
        }
        let written = gauge.execute(prepared).inspect_err(|error| effect = Some(error.write_effect()))?;
        out(&if arguments.json {
            json(&Change { from_device_file, ..change(&written) })
        } else {
            format!("{}{}", line(&written), if from_device_file { OF_DEVICE_FILE } else { "" })
        });
        effect = None;
        Ok(())
    });
    let done = done.map_err(|failure| match effect {
        Some(WriteEffect::NotSent) => before_write(failure),
        _ => failure,
    });
    if let (Err(failure), Some(effect), true) = (&done, effect, arguments.json) {
        print_failure(&arguments.target, effect, failure);
    }
    done
}

/// Prepares a command, or a parameter and its value.
fn prepare(gauge: &mut AnyGauge<'_>, arguments: &Arguments) -> Result<PreparedWrite, Failure> {
    let (names, target, value) = (gauge.names(), arguments.target.as_str(), arguments.value.as_deref());
    let words = value.map_or_else(|| target.to_owned(), |value| format!("{target} {value}"));
    if let Some((named, code)) = names.command(&words).map_err(ClientError::from)? {
        return Ok(gauge.prepare(named, code.name)?);
    }
    let named = gauge.find_whole(target)?;
    let value = value.ok_or_else(|| {
        Failure::usage(format!("expected a VALUE for {named}, got none; `profivac list` shows the values it accepts"))
    })?;
    Ok(if arguments.force { gauge.prepare_forced(&named, value) } else { gauge.prepare(&named, value) }?)
}

fn change(written: &WriteResult) -> Change {
    let parameter = written.named.parameter;
    Change {
        name: written.named.name.clone(),
        slot: parameter.location.slot,
        instance: parameter.location.instance,
        index: parameter.row.index,
        written: written.text.clone(),
        before: written.before.as_ref().map(RecordRow::of),
        after: written.after.as_ref().map(RecordRow::of),
        from_device_file: false,
    }
}

/// `NAME: OLD -> NEW`, or the value sent if the parameter cannot be read.
fn line(written: &WriteResult) -> String {
    let name = &written.named.name;
    match (&written.before, &written.after) {
        (Some(before), Some(after)) => format!("{name}: {} -> {}", before.text, after.text),
        _ => format!("{name}: {} done", written.text),
    }
}
