//! `profivac read`: reads parameters of a gauge.

use crate::advice;
use crate::failure::Failure;
use crate::gauge::{AnyGauge, GaugeOptions};
use crate::octets;
use crate::output::{json, notice, out};
use crate::record_row::RecordRow;
use clap::Args;
use profivac_client::cyclic::ChannelValue;
use profivac_client::names::{NamedParameter, Target};
use profivac_client::settings::IN_IDLE;
use profivac_client::{ClientError, ErrorKind};
use profivac_devices::model::Role;
use profivac_devices::profile::DeviceState;
use serde::Serialize;

/// Read parameters of a gauge by name or number.
///
/// TARGET is a name like pirani.process-value, slot and index like 1/19, or with instance 2 like 1:2/19; `profivac list` shows
/// all. The beginning of a word is enough: `serial`, `pressure`. Reading takes no ownership. Where several instances share a slot,
/// it writes the Channel Instance Selector and restores it: meanwhile a PLC that reads this slot acyclically gets the values of
/// another instance, without an error. The manuals list the selector as nonvolatile, so a gauge may write its EEPROM each time:
/// use `profivac monitor`, not a loop of `read`, to watch a pressure.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    options: GaugeOptions,
    /// Print JSON: a list
    #[arg(long)]
    json: bool,
    /// Read records as octets from any slave with DP-V1, also from an unknown device: TARGET is SLOT/INDEX, or im0 for the
    /// identification (I&M0), which needs a Call: one write to slot 0, index 255
    #[arg(long)]
    octets: bool,
    /// The parameters
    #[arg(value_name = "TARGET", required = true)]
    targets: Vec<String>,
}

const EXAMPLES: &str = "\
Examples:
  profivac read --port /dev/ttyUSB0 --address 5 pirani.process-value
  profivac read --port /tmp/line --address 5 device.device-state trip-point.1/high-trip-point
  profivac read --port /tmp/line --address 5 --json 1:2/19
  profivac read --port /tmp/line --address 9 --octets 1/19 im0     # any slave with DP-V1";

/// One of several targets in the JSON output.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum JsonRow<'a> {
    Read(RecordRow),
    Failed { target: &'a str, error: String },
}

/// Reads all targets; a refused one does not end the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.octets {
        return octets::read(&arguments.options, &arguments.targets, arguments.json);
    }
    let (mut answers, mut refused) = (Vec::new(), None);
    let done = arguments.options.with_gauge(|gauge| {
        for target in &arguments.targets {
            match read(gauge, target) {
                Ok(row) => {
                    let name = row.name.as_deref().unwrap_or(target);
                    if !arguments.json {
                        out(&format!("{name} = {}", row.value_text()));
                    }
                    if row.valid == Some(false) {
                        warn_invalid(gauge, name);
                    }
                    answers.push(JsonRow::Read(row));
                }
                Err(error) if error.kind() == ErrorKind::Line => return Err(error.into()),
                Err(error) => {
                    answers.push(JsonRow::Failed { target, error: advice::sentence(&error) });
                    match &mut refused {
                        None => refused = Some(Failure::from(error)),
                        // The first refusal is printed at the end, as the reason for the exit code.
                        Some(_) => notice(&advice::sentence(&error)),
                    }
                }
            }
        }
        Ok(())
    });
    // A single refused target gives no JSON.
    let is_read = answers.iter().any(|answer| matches!(answer, JsonRow::Read(_)));
    if arguments.json && (is_read || answers.len() > 1) {
        out(&json(&answers));
    }
    done.and(refused.map_or(Ok(()), Err))
}

fn read(gauge: &mut AnyGauge<'_>, target: &str) -> Result<RecordRow, ClientError> {
    let names = gauge.names();
    match names.find(gauge.model().name, target)? {
        Target::Raw { slot, index } => Ok(RecordRow::raw(slot, index, &gauge.read_raw(slot, index)?)),
        Target::Parameter(_) | Target::CurrentInstance { .. } => {
            let reading = gauge.read(target)?;
            let pressure = pressure(gauge, &reading.named)?;
            let valid = pressure.map(|pressure| pressure.is_valid());
            let reason = pressure.filter(|pressure| !pressure.is_valid()).map(|pressure| {
                // In IDLE the status bits of the reading mean nothing.
                if is_idle(gauge) { IN_IDLE.to_owned() } else { pressure.text() }
            });
            Ok(RecordRow { valid, reason, ..RecordRow::of(&reading) })
        }
    }
}

fn pressure(gauge: &mut AnyGauge<'_>, named: &NamedParameter) -> Result<Option<ChannelValue>, ClientError> {
    let is_pressure = named.parameter.row.role == Some(Role::ProcessValue);
    is_pressure.then(|| gauge.pressure_of(named)).transpose()
}

fn is_idle(gauge: &mut AnyGauge<'_>) -> bool {
    gauge.device_state().is_ok_and(|state| state == DeviceState::Idle)
}

/// Prints a notice that the value is no pressure: the value of a safe state looks like one.
fn warn_invalid(gauge: &mut AnyGauge<'_>, name: &str) {
    let advice = if is_idle(gauge) { "; the gauge is in IDLE: `profivac write ... execute` starts it" } else { "" };
    notice(&format_args!("{name} is not a valid pressure{advice}"));
}
