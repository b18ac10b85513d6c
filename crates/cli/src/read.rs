//! `profivac read`: reads parameters of a gauge.

use crate::advice;
use crate::failure::Failure;
use crate::gauge::{AnyGauge, GaugeOptions};
use crate::octets;
use crate::output::{json, notice, out};
use clap::Args;
use profivac_client::cyclic::ChannelValue;
use profivac_client::names::{NamedParameter, Target};
use profivac_client::settings::IN_IDLE;
use profivac_client::values::{Value, hex};
use profivac_client::{ClientError, ErrorKind, ParameterReading};
use profivac_devices::model::Role;
use profivac_devices::profile::DeviceState;
use serde::Serialize;

/// Read parameters of a gauge by name or number.
///
/// TARGET is a name like pirani.process-value, slot and index like 1/19, or those of instance 2 like 1:2/19; `profivac list`
/// shows all. The beginning of a word is enough: `serial`, `pressure`. Reading takes no ownership. Where several instances share a slot, it writes the Channel Instance Selector and restores
/// it: meanwhile a PLC that reads this slot acyclically gets the values of another instance, without an error. The manuals list the
/// selector as nonvolatile, so a gauge may write its EEPROM each time: use `profivac monitor`, not a loop of `read`, to watch a
/// pressure.
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

/// A parameter in the JSON output.
#[derive(Debug, Serialize)]
pub struct Row {
    pub name: Option<String>,
    pub slot: u8,
    pub instance: u8,
    pub index: u8,
    /// A number, a string, or octets as hexadecimal digits.
    pub value: serde_json::Value,
    pub text: String,
    pub unit: Option<&'static str>,
    pub octets: String,
    /// Of a Process Value: whether the gauge reports it as valid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub valid: Option<bool>,
    /// Of a Process Value that is not valid: why.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Row {
    pub fn of(reading: &ParameterReading) -> Self {
        let parameter = reading.named.parameter;
        Self {
            name: Some(reading.named.name.clone()),
            slot: parameter.location.slot,
            instance: parameter.location.instance,
            index: parameter.row.index,
            value: value(&reading.value),
            text: reading.text.clone(),
            unit: reading.unit,
            octets: hex(&reading.octets),
            valid: None,
            reason: None,
        }
    }

    /// The value, and on the same line why it is no pressure: a script may read standard output alone.
    pub fn value_text(&self) -> String {
        let reason = self.reason.as_ref().map(|reason| format!("  (not valid: {reason})"));
        self.text.clone() + &reason.unwrap_or_default()
    }
}

fn value(value: &Value) -> serde_json::Value {
    match value {
        Value::Integer(number) => (*number).into(),
        // Printed with the digits of a 32-bit float.
        #[expect(clippy::cast_possible_truncation, reason = "the value was a 32-bit float")]
        Value::Number(number) => {
            (*number as f32).to_string().parse::<f64>().map_or(serde_json::Value::Null, Into::into)
        }
        Value::Text(text) => text.clone().into(),
        Value::Octets(octets) => hex(octets).into(),
    }
}

/// One of several targets in the JSON output.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum JsonRow<'a> {
    Read(Row),
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

fn read(gauge: &mut AnyGauge<'_>, target: &str) -> Result<Row, ClientError> {
    let names = gauge.names();
    match names.find(gauge.model().name, target)? {
        Target::Raw { slot, index } => Ok(raw_row(slot, index, &gauge.read_raw(slot, index)?)),
        Target::Parameter(_) | Target::CurrentInstance { .. } => {
            let reading = gauge.read(target)?;
            let pressure = pressure(gauge, &reading.named)?;
            let valid = pressure.map(|pressure| pressure.is_valid());
            let reason = pressure.filter(|pressure| !pressure.is_valid()).map(|pressure| {
                // In IDLE the status bits of the reading mean nothing.
                if is_idle(gauge) { IN_IDLE.to_owned() } else { pressure.text() }
            });
            Ok(Row { valid, reason, ..Row::of(&reading) })
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

/// The row of a record without a name.
pub fn raw_row(slot: u8, index: u8, octets: &[u8]) -> Row {
    let octets = hex(octets);
    let (value, text) = (octets.clone().into(), octets.clone());
    Row { name: None, slot, instance: 0, index, value, text, unit: None, octets, valid: None, reason: None }
}
